"""The machines and the questions that twins are asked: all shipped mechanisms and random ones.

Closed configurations come from the independent closures, so that the questions do not depend on
the code that answers them. A case is plain data, kept in the file of answers: another checkout is
asked the very same.
"""

from __future__ import annotations

import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.twin_oracle import (
    FAMILIES,
    ROOT,
    SMALL,
    Drawing,
    Oracle,
    chosen_values,
    joint_kinds,
    numbers_only,
    oracle_of,
    random_file,
    random_graph,
    to_toml,
)

SHIPPED = ROOT / "symkin" / "mechanisms"
RANDOM = ("limbs", "small", "limbs", "graph", "limbs", "small", "odd")
"""Kinds of random machines in turn: limbs and arms; small graphs at sizes 1e-6 to 1e6; graphs of up
to five loops; graphs with odd names, limits and couplings."""
SPREAD = 0.1
"""Random steps off the reference from which closed configurations are found (share of the size,
rad)."""
OFF_FEASIBLE = 0.5
"""How far inputs that may have no configuration lie from those that have one (share of the size,
rad)."""
POSTURES = 24
"""Configurations of a calibration: poses give six readings each, machines have up to some 60
parameters."""
MOST_JOINTS = 14
"""Most joint coordinates of a machine whose calibration is asked for: larger ones take minutes."""

Case = dict[str, Any]
"""name, toml, size, kinds (of coordinates), idle (names), problems = [{key, joints | pose |
given}], calibration = {joints, poses} or None, left_out: sentences that say what is not asked and
why.
"""


def shipped() -> list[str]:
    """Names of the shipped mechanisms."""
    return [f"shipped {path.stem}" for path in sorted(SHIPPED.glob("*.toml"))]


def random_name(seed: int, index: int) -> str:
    """The name of a random machine: it says how it is made."""
    return f"random {RANDOM[index % len(RANDOM)]} {seed} {index:04d}"


def text_of(name: str) -> str:
    """The mechanism file of a machine by its name."""
    source, kind, *numbers = name.split()
    if source == "shipped":
        return (SHIPPED / f"{kind}.toml").read_text(encoding="utf-8")
    seed, index = map(int, numbers)
    rng = np.random.default_rng([seed, index])
    if kind == "limbs":
        return str(to_toml(random_file(rng)))
    if kind == "odd":
        return str(random_graph(1000 * seed + index).to_toml())
    families = SMALL if kind == "small" else FAMILIES
    return str(Drawing(rng, families).grow())


def make_case(name: str, text: str, seed: int) -> Case:
    """The questions of one machine."""
    rng = np.random.default_rng([seed, *name.encode()])
    data = numbers_only(tomllib.loads(text))
    oracle = oracle_of(data)
    near = oracle.closed(4, SPREAD, rng)
    problems = list(_problems(data, oracle, near, text, rng))
    calibration = _postures(oracle, rng)
    left_out = []
    if not len(near):
        left_out.append("no closed configuration was found near the reference")
    if not any(p["key"].startswith(("direct", "named")) for p in problems):
        left_out.append("direct: no joints were found that decide the others")
    if not any(p["key"].startswith(("inverse", "named")) for p in problems):
        left_out.append("inverse: there is no platform whose pose could be given")
    if calibration is None:
        left_out.append(
            f"calibration: no platform, no actuated joints, or more than {MOST_JOINTS} coordinates"
        )
    return {
        "name": name,
        "toml": text,
        "size": oracle.size,
        "kinds": joint_kinds(data),
        "idle": sorted(oracle.idle),
        "problems": problems,
        "calibration": calibration,
        "left_out": left_out,
    }


def _problems(
    data: Mapping[str, Any], oracle: Oracle, near: np.ndarray, text: str, rng: np.random.Generator
) -> Iterator[dict[str, Any]]:
    """Both directions at closed configurations near the reference, at the example, and one direct
    problem beside them."""
    example = data.get("example", {})
    for kind in ("joints", "pose", "given"):
        if kind in example:
            yield {"key": f"example {kind}", kind: example[kind]}
    mobility = oracle.mobility()
    decided = bool(oracle.actuated) and (
        len(oracle.actuated) == mobility or not hasattr(oracle, "g")
    )
    for k, x in enumerate(near[:2]):
        joints = [oracle.joints(x)[name] for name in oracle.actuated]
        if decided:
            yield {"key": f"direct {k}", "joints": joints}
        if oracle.has_platform:
            yield {"key": f"inverse {k}", "pose": oracle.pose(x)}
    if hasattr(oracle, "g"):
        yield from _named(text, mobility, rng)
    if decided and len(near):
        units = _units(data, oracle)
        off = rng.uniform(-OFF_FEASIBLE, OFF_FEASIBLE, len(oracle.actuated))
        here = [oracle.joints(near[0])[name] for name in oracle.actuated]
        yield {
            "key": "direct off",
            "joints": [h + o * u for h, o, u in zip(here, off, units, strict=True)],
        }


def _units(data: Mapping[str, Any], oracle: Oracle) -> list[float]:
    """What OFF_FEASIBLE counts in, for each actuated joint in the file's units."""
    kinds, radian = joint_kinds(data), 180.0 / np.pi if data["angle_unit"] == "deg" else 1.0
    return [oracle.size if kinds[name] == "length" else radian for name in oracle.actuated]


def _named(text: str, mobility: int | None, rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    """A graph by coordinates that decide all others, twice; by none where nothing moves."""
    if mobility == 0:
        yield {"key": "named 0", "given": {}}
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "graph.toml"
        path.write_text(text, encoding="utf-8")
        for k in range(2):
            chosen = chosen_values(path, rng)
            if chosen is not None and chosen[0]:
                yield {"key": f"named {k}", "given": dict(sorted(chosen[0].items()))}


def _postures(oracle: Oracle, rng: np.random.Generator) -> dict[str, Any] | None:
    """Joint readings and exact poses of a calibration, None for machines without platform or
    actuated joints, and large ones."""
    if not oracle.has_platform or not oracle.actuated:
        return None
    x = oracle.closed(POSTURES, SPREAD, rng)
    if not len(x) or len(oracle.joints(x[0])) > MOST_JOINTS:
        return None
    joints = [[oracle.joints(v)[name] for name in oracle.actuated] for v in x]
    return {"joints": joints, "poses": [oracle.pose(v) for v in x]}
