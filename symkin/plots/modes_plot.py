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
from symkin.position.solution import Solution
from symkin.position.solve_result import SolveResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figure_of_modes(modes: Modes, *, most: int = 12) -> Figure:
    """One panel per mode, `most` of them, poses before branches, all with the same limits and equal axes; without modes the
    mechanism's reference configuration. Raises InputError for `most` below 1."""
    if most < 1:
        raise InputError(f"most = {most} must be at least 1")
    mechanism = modes.problem.mechanism
    numbered = _chosen(modes, most)
    look, given = _look_of(mechanism), [c.name for c in modes.problem.known_coordinates]
    panels = [look.panel(f"mode {k}", look.text(s, given) + _limits_text(s), look.lines(s)) for k, s in numbered]
    panels = panels or [look.panel(_nothing(modes), "drawn at the reference configuration", look.reference(mechanism))]
    part = f" \N{EM DASH} {len(numbered)} of {len(modes)} modes shown" if len(numbered) < len(modes) else ""
    return look.figure(mechanism, panels, _facts(modes), part)


def figure_of_solution(solution: Solution) -> Figure:
    """One panel: the mechanism in this configuration."""
    look = _look_of(solution.mechanism)
    panel = look.panel("", look.text(solution, ()) + _limits_text(solution), look.lines(solution))
    unit = solution.mechanism.length_unit
    facts = [f"closure error {solution.residual:.1e} {unit}, condition {solution.condition:.3g}"]
    return look.figure(solution.mechanism, [panel], facts)


def figure_of_solve(result: SolveResult) -> Figure:
    """The configuration that a solve reached. Raises InputError where it reached none."""
    if result.solution is None:
        raise InputError(f"plot: {result.message}")
    return figure_of_solution(result.solution)


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
    """The first few single joint coordinates that were not given."""
    values = {name: v for name, v in solution.joints.items() if isinstance(v, float) and name not in given}
    size = solution.mechanism.characteristic_length
    scale = {c.name: 1.0 if c.is_angular else size for c in solution.mechanism.coordinates}
    first = list(values)[:_MOST_VALUES]
    clean = [_clean([values[name]], scale[name])[0] for name in first]
    shown = ", ".join(f"{name}\N{NO-BREAK SPACE}{v + 0.0:.5g}" for name, v in zip(first, clean, strict=True))
    more = ", ..." if len(values) > _MOST_VALUES else ""
    return shown + more or (_pose_text(solution) if solution.has_platform else "")


_MOST_VALUES = 4
"""Joint coordinates that are written above a panel."""


def _chosen(modes: Modes, most: int) -> list[tuple[int, Solution]]:
    """Numbers and modes to draw: all, or one for each pose first and then others, in their order."""
    numbered = list(enumerate(modes.modes, start=1))
    if len(numbered) <= most:
        return numbered
    first = {id(mode) for mode in modes.representatives}
    ranked = sorted(numbered, key=lambda pair: (id(pair[1]) not in first, pair[0]))
    return sorted(ranked[:most], key=lambda pair: pair[0])


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
    """Position, with the angle where the motion has one; the quaternion for a spherical motion."""
    mechanism = solution.mechanism
    if mechanism.motion == "spherical":
        return f"quaternion {_list(_clean(solution.quaternion, 1.0))}"
    text = f"{_list(_clean(solution.position, mechanism.characteristic_length))} {mechanism.length_unit}"
    if "pose.gamma" not in solution.values:
        return f"position {text}"
    (angle,) = _clean([mechanism.angle_out(solution.values["pose.gamma"])], 1.0)
    return f"{text}, gamma {angle:.5g} {mechanism.angle_unit}"


def _clean(values: Sequence[float] | np.ndarray, size: float) -> list[float]:
    return [0.0 if abs(v) < 1e-9 * size else float(v) for v in values]


def _list(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v + 0.0:.5g}" for v in values) + ")"
