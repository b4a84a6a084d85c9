"""What symkin answers to a case of `twin_cases`, through its public names alone.

The same module is run with the package of another checkout in its path, an older one too; it
imports nothing else of the project.
"""

from __future__ import annotations

import math
import os
import tempfile
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

MOST_MODES, MOST_CLOSELY = 120, 2
"""Modes of a problem that are kept, and those of them of which singularity and Jacobians are."""
DIGITS = 12
"""Significant digits of numbers in the file."""
JACOBIANS = ("direct", "inverse", "analytic", "passive")
WELL_CONDITIONED = 1e6
"""Jacobians are asked for at configurations with a smaller condition only: at others they are
rounding."""

Answer = dict[str, Any]


def answers(case: Mapping[str, Any], send: Callable[[Any], None]) -> None:
    """Send (key, answer) for each question of a case, with a cache of the machine's own: what
    another machine has left in it changes the last digits."""
    import symkin

    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["SYMKIN_CACHE"] = str(Path(folder) / "cache")
        path = Path(folder) / "machine.toml"
        path.write_text(case["toml"], encoding="utf-8")

        def ask(key: str, question: Callable[[], Answer]) -> None:
            try:
                answer = question()
            except symkin.SymkinError as error:
                answer = {"refused": " ".join(str(error).replace(str(path), "FILE").split())}
            except Exception as error:
                answer = {"crashed": f"{type(error).__name__}: {error}".replace(folder, "FOLDER")}
            send((key, answer))

        ask("loaded", lambda: {"name": symkin.load(path).name})
        ask("mobility", lambda: mobility(symkin.load(path)))
        for problem in case["problems"]:
            given = {k: v for k, v in problem.items() if k != "key"}
            ask(problem["key"], lambda given=given: modes(symkin.load(path), given, case))
        if case["calibration"]:
            ask("calibration", lambda: identified(symkin.load(path), case["calibration"]))


def mobility(mechanism: Any) -> Answer:
    """Counts of freedoms that do not depend on where loops are cut."""
    import symkin

    found = symkin.mobility(mechanism).to_dict()
    return {key: found[key] for key in ("mobility", "redundant", "gruebler")}


def modes(mechanism: Any, given: Mapping[str, Any], case: Mapping[str, Any]) -> Answer:
    """All modes with what is claimed of them, in an order of their own."""
    import symkin

    found = symkin.modes(mechanism, **given)
    told = found.to_dict()
    printed = [(mode, _mode(mode.to_dict())) for mode in found]
    printed.sort(key=lambda pair: _order(pair[1], case))
    for solution, mode in printed[:MOST_CLOSELY]:
        mode["singularity"] = _guarded(lambda s=solution: _singularity(s, given))
        if (mode["condition"] or math.inf) < WELL_CONDITIONED:
            mode["jacobians"] = _jacobians(solution, given)
    return {
        "modes": [mode for _, mode in printed[:MOST_MODES]],
        "count": told["count"],
        "complex_count": told["complex_count"],
        "completeness": told["completeness"],
        "unresolved_paths": told["unresolved_paths"],
        "positive_dimensional": bool(found.positive_dimensional),
    }


def _mode(told: Mapping[str, Any]) -> Answer:
    pose = told["pose"]
    return {
        "pose": None if pose is None else _rounded([*pose["position"], *pose["quaternion"]]),
        "joints": {name: _rounded(value) for name, value in sorted(told["joints"].items())},
        "points": {name: _rounded(value) for name, value in sorted(told["points"].items())},
        "residual": _rounded(told["residual"], 2),
        "condition": _rounded(told["condition"], 2),
        "certified": told["certified"],
        "has_ground": told["ground"] is not None,
        "within_limits": told["within_limits"],
        "multiple": any(n.startswith(("singular", "double")) for n in told["notes"]),
    }


def _order(mode: Answer, case: Mapping[str, Any]) -> list[float]:
    """Coarse numbers of a mode, so that rounding changes no order."""
    turn = 2.0 * math.pi if 'angle_unit = "rad"' in case["toml"] else 360.0
    numbers = []
    for value in (mode["pose"] or [])[:3]:
        numbers.append(value / case["size"])
    for name, value in mode["joints"].items():
        kind = case["kinds"].get(name)
        if isinstance(value, float) and name not in case["idle"] and kind is not None:
            there = value / (case["size"] if kind == "length" else turn)
            numbers.append(math.cos(2 * math.pi * there) if kind == "angle" else there)
            numbers.append(math.sin(2 * math.pi * there) if kind == "angle" else 0.0)
    numbers += [abs(v) for v in (mode["pose"] or [])[3:]]
    return [round(v, 4) + 0.0 for v in numbers]


def _singularity(solution: Any, given: Mapping[str, Any]) -> Answer:
    import symkin

    named = {"given": list(given["given"])} if given.get("given") else {}
    found = symkin.singularity(solution, **named)
    return {
        "kinds": sorted(found.kinds),
        "everywhere": dict(sorted(found.permanent_freedoms.items())),
    }


def _jacobians(solution: Any, given: Mapping[str, Any]) -> Answer:
    """The entries of each kind of Jacobian by the names of row and column, in the file's order of
    names no longer."""
    import symkin

    def entries(found: Any) -> Answer:
        matrix = found.at(solution)
        rows = {
            str(row): {
                str(c): _rounded(float(v)) for c, v in sorted(zip(found.columns, line, strict=True))
            }
            for row, line in zip(found.rows, matrix, strict=True)
        }
        return dict(sorted(rows.items()))

    by = list(given.get("given", {}))
    if by:
        others = [n for n, v in solution.joints.items() if isinstance(v, float) and n not in by]
        return {
            "rates": _guarded(
                lambda: entries(symkin.jacobian(solution.mechanism, of=others, by=by))
            )
        }
    return {
        kind: _guarded(lambda kind=kind: entries(symkin.jacobian(solution.mechanism, kind)))
        for kind in JACOBIANS
    }


def _guarded(question: Callable[[], Answer]) -> Answer:
    import symkin

    try:
        return question()
    except symkin.SymkinError as error:
        return {"refused": " ".join(str(error).split())}


def identified(mechanism: Any, postures: Mapping[str, Any]) -> Answer:
    """How many parameters exact poses identify, of how many."""
    import symkin

    poses = np.array(postures["poses"])
    joints = np.array(postures["joints"])
    for k, c in enumerate(mechanism.actuated):
        if c.is_angular and mechanism.angle_unit == "deg":
            joints[:, k] = np.radians(joints[:, k])
    data = symkin.Measurements(
        joints,
        position=poses[:, :3],
        orientation=poses[:, 3:],
        position_sigma=1e-4 * mechanism.characteristic_length,
        orientation_sigma=1e-4,
        starts=poses,
    )
    found = symkin.calibrate(mechanism, data, outliers="ignore")
    values = np.append(found.identifiability.singular_values, 0.0)
    return {
        "rank": found.rank,
        "parameters": sorted(found.identifiability.names),
        "clear": bool(values[found.rank - 1] >= 1e3 * values[found.rank]),
    }


def _rounded(value: Any, digits: int = DIGITS) -> Any:
    """A number, or a list of them, with so many significant digits; None for what is not finite."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, list | tuple | np.ndarray):
        return [_rounded(float(v), digits) for v in value]
    return float(f"{value:.{digits}g}") + 0.0 if math.isfinite(value) else None
