"""Pictures of modes and single solutions: a 3-D panel for each configuration, with its pose or joints above it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.assembly.modes_result import Modes
from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.plots.graph_figures import GraphPanel, panels_of_graph
from symkin.plots.graph_lines import reference_graph_lines, solution_lines
from symkin.plots.mechanism_lines import lines_at, reference_lines
from symkin.plots.panel_figure import Panel, panel_figure
from symkin.plots.picture_options import chosen_numbers, looks_of, ranges_text
from symkin.position.solution import Solution
from symkin.position.solve_result import SolveResult
from symkin.spatial.rotation import euler_from_quaternion

if TYPE_CHECKING:
    from matplotlib.figure import Figure


DEFAULT_MOST = 12
"""Panels of a picture of modes where nothing is chosen."""


def figure_of_modes(
    found: Modes, *, modes: str | Sequence[int] | None = None, most: int = DEFAULT_MOST, names: str = "none",
    views: str | Sequence[str] = "main",
) -> Figure:  # fmt: skip
    """One panel per mode, those of `shown_numbers`, all with the same limits and equal axes; without modes the mechanism's reference
    configuration. Raises InputError for `most` below 1, and for modes, names and views that are not there."""
    mechanism = found.problem.mechanism
    numbers = shown_numbers(found, modes, most)
    look, given = _look_of(mechanism), [c.name for c in found.problem.known_coordinates]
    shown = [(k, found[k - 1]) for k in numbers]
    panels = [look.panel(f"mode {k}", look.text(s, given) + _limits_text(s), look.lines(s)) for k, s in shown]
    panels = panels or [look.panel(_nothing(found), "drawn at the reference configuration", look.reference(mechanism))]
    part = f" \N{EM DASH} {len(numbers)} of {found.total} modes shown" if len(numbers) < found.total else ""
    return look.figure(mechanism, panels, _facts(found), part, **looks_of(mechanism, names, views))


def shown_numbers(modes: Modes, chosen: str | Sequence[int] | None = None, most: int = DEFAULT_MOST) -> list[int]:
    """Numbers of the modes that a picture shows: the chosen ones, else `most` of them, poses before branches. Raises InputError."""
    if most < 1:
        raise InputError(f"most = {most} must be at least 1")
    if chosen is not None and len(modes):
        return chosen_numbers(chosen, len(modes))
    first = {id(mode) for mode in modes.representatives}
    numbers = range(1, len(modes) + 1)
    return sorted(sorted(numbers, key=lambda k: (id(modes[k - 1]) not in first, k))[:most])


def left_out(modes: Modes, shown: Sequence[int]) -> str:
    """What a picture of some modes leaves out, in a sentence; empty where it shows all."""
    others = [k for k in range(1, len(modes) + 1) if k not in set(shown)]
    unlisted = f"; {modes.total - len(modes)} more are not listed" if modes.total > len(modes) else ""
    if not others and not unlisted:
        return ""
    numbers = f": {ranges_text(others)}" if others else ""
    return f"shows {len(shown)} of {modes.total} modes, leaves out {modes.total - len(shown)}{numbers}{unlisted}; --modes chooses"


def figure_of_solution(solution: Solution, *, names: str = "none", views: str | Sequence[str] = "main") -> Figure:
    """The mechanism in this configuration, a panel for each view."""
    look = _look_of(solution.mechanism)
    panel = look.panel("", look.text(solution, ()) + _limits_text(solution), look.lines(solution))
    unit = solution.mechanism.length_unit
    facts = [f"closure error {solution.residual:.1e} {unit}, condition {solution.condition:.3g}"]
    return look.figure(solution.mechanism, [panel], facts, **looks_of(solution.mechanism, names, views))


def figure_of_solve(result: SolveResult, *, names: str = "none", views: str | Sequence[str] = "main") -> Figure:
    """The configuration that a solve reached. Raises InputError where it reached none."""
    if result.solution is None:
        raise InputError(f"plot: {result.message}")
    return figure_of_solution(result.solution, names=names, views=views)


@dataclass(frozen=True)
class _Look:
    """How configurations are drawn: a panel's type, lines of a solution and of the reference, text of a solution for given names, and
    the figure of several panels."""

    panel: Callable[[str, str, Any], Any]
    lines: Callable[[Solution], Any]
    reference: Callable[[Mechanism], Any]
    text: Callable[[Solution, Sequence[str]], str]
    figure: Callable[..., Figure]


def _look_of(mechanism: Mechanism) -> _Look:
    """Limbs are drawn with base and platform in space; links joined in any way with a colour each, in a plane where they move in one."""
    if mechanism.is_graph:
        return _Look(GraphPanel, solution_lines, reference_graph_lines, _joints_text, panels_of_graph)
    return _Look(Panel, lambda s: lines_at(s.mechanism, s.values, s.pose), reference_lines, _mode_text, panel_figure)


def _joints_text(solution: Solution, given: Sequence[str]) -> str:
    """The first few single joint coordinates that were not given; below them where the platform's link is."""
    values = {name: v for name, v in solution.joints.items() if isinstance(v, float) and name not in given}
    size = solution.mechanism.characteristic_length
    scale = {c.name: 1.0 if c.is_angular else size for c in solution.mechanism.coordinates}
    first = list(values)[:_MOST_VALUES]
    clean = [_clean([values[name]], scale[name])[0] for name in first]
    shown = ", ".join(f"{name}\N{NO-BREAK SPACE}{v + 0.0:.5g}" for name, v in zip(first, clean, strict=True))
    more = ", ..." if len(values) > _MOST_VALUES else ""
    pose = _pose_text(solution) if solution.has_platform else ""
    return "\n".join(line for line in (shown + more, pose) if line)


_MOST_VALUES = 4
"""Joint coordinates that are written above a panel."""


def _facts(modes: Modes) -> list[str]:
    """What is given, and the count of modes with its completeness."""
    mechanism = modes.problem.mechanism
    given = ", ".join(_given_text(key, values) for key, values in modes.given.items()) or "nothing"
    count = len(modes)
    found = f"{count} mode{'' if count == 1 else 's'}" if count else _nothing(modes)
    units = f"{mechanism.length_unit}, {mechanism.angle_unit}"
    statement = f"{found}; completeness: {modes.completeness}" + (f", {modes.starts} starts" if modes.starts else "")
    return [f"{modes.problem.name} problem at {given} ({units})", statement]


def _given_text(key: str, values: Any) -> str:
    return f"{key} = {values:.5g}" if np.ndim(values) == 0 else f"{key} {_list(np.ravel(values).tolist())}"


def _nothing(modes: Modes) -> str:
    return "no isolated solution" if modes.positive_dimensional else "no real solution"


def _mode_text(solution: Solution, given: Sequence[str]) -> str:
    """Where the mode is: the platform's pose, or where that is given the actuated joints."""
    posed = any(c.name in given for c in build_closure(solution.mechanism).role("pose"))
    return f"joints {_list(solution.actuated_values)}" if posed else _pose_text(solution)


def _limits_text(solution: Solution) -> str:
    return {None: "", True: "\n\N{CHECK MARK} within limits", False: "\n\N{BALLOT X} outside limits"}[solution.within_limits]


def _pose_text(solution: Solution) -> str:
    """Position and orientation: the angle of a motion with one, else roll, pitch and yaw, where the motion turns at all."""
    mechanism = solution.mechanism
    text = f"position {_list(_clean(solution.position, mechanism.characteristic_length))} {mechanism.length_unit}"
    if "pose.gamma" in solution.values:
        (angle,) = _clean([mechanism.angle_out(solution.values["pose.gamma"])], 1.0)
        return f"{text.removeprefix('position ')}, gamma {angle:.5g} {mechanism.angle_unit}"
    turn = euler_from_quaternion(np.asarray(solution.quaternion), "xyz")
    angles = f"roll, pitch, yaw {_list(_clean([mechanism.angle_out(float(v)) for v in turn], 1.0))} {mechanism.angle_unit}"
    return {"spherical": angles, "translation": text}.get(mechanism.motion, f"{text}\n{angles}")


def _clean(values: Sequence[float] | np.ndarray, size: float) -> list[float]:
    return [0.0 if abs(v) < 1e-9 * size else float(v) for v in values]


def _list(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v + 0.0:.5g}" for v in values) + ")"
