"""Pictures of modes and single solutions: a 3-D panel for each configuration, with its pose or joints above it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.assembly.modes_result import Modes
from symkin.errors import InputError
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
    if mechanism.is_graph:
        return _figure_of_graph(modes, numbered)
    panels = [Panel(f"mode {k}", _mode_text(modes, s), lines_at(mechanism, s.values, s.pose)) for k, s in numbered]
    panels = panels or [Panel(_nothing(modes), "drawn at the reference configuration", reference_lines(mechanism))]
    part = f" \N{EM DASH} {len(numbered)} of {len(modes)} modes shown" if len(numbered) < len(modes) else ""
    return panel_figure(mechanism, panels, _facts(modes), part)


def figure_of_solution(solution: Solution) -> Figure:
    """One panel: the mechanism in this configuration."""
    mechanism = solution.mechanism
    if mechanism.is_graph:
        unit = mechanism.length_unit
        facts = [f"closure error {solution.residual:.1e} {unit}, condition {solution.condition:.3g}"]
        return panels_of_graph(mechanism, [GraphPanel("", _joints_text(solution, ()), solution_lines(solution))], facts)
    panel = Panel("", _pose_text(solution) + _limits_text(solution), lines_at(mechanism, solution.values, solution.pose))
    unit = mechanism.length_unit
    facts = [f"closure error {solution.residual:.1e} {unit}, condition {solution.condition:.3g}"]
    return panel_figure(mechanism, [panel], facts)


def figure_of_solve(result: SolveResult) -> Figure:
    """The configuration that a solve reached. Raises InputError where it reached none."""
    if result.solution is None:
        raise InputError(f"plot: {result.message}")
    return figure_of_solution(result.solution)


def _figure_of_graph(modes: Modes, numbered: Sequence[tuple[int, Solution]]) -> Figure:
    """A panel for each mode of a graph; without modes its reference configuration."""
    mechanism = modes.problem.mechanism
    given = modes.problem.known_coordinates
    panels = [GraphPanel(f"mode {k}", _joints_text(s, [c.name for c in given]), solution_lines(s)) for k, s in numbered]
    nothing = GraphPanel(_nothing(modes), "drawn at the reference configuration", reference_graph_lines(mechanism))
    part = f" \N{EM DASH} {len(numbered)} of {len(modes)} modes shown" if len(numbered) < len(modes) else ""
    return panels_of_graph(mechanism, panels or [nothing], _facts(modes), part)


def _joints_text(solution: Solution, given: Sequence[str]) -> str:
    """The first few single joint coordinates that were not given, and whether all are within limits."""
    values = {name: v for name, v in solution.joints.items() if isinstance(v, float) and name not in given}
    shown = ", ".join(f"{name}\N{NO-BREAK SPACE}{v + 0.0:.5g}" for name, v in list(values.items())[:_MOST_VALUES])
    more = ", ..." if len(values) > _MOST_VALUES else ""
    if not shown and solution.has_platform:
        shown = _pose_text(solution)
    return shown + more + _limits_text(solution)


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


def _mode_text(modes: Modes, solution: Solution) -> str:
    """Where the mode is: the platform's pose, or for an inverse problem the actuated joints; and whether within limits."""
    where = f"joints {_list(solution.actuated_values)}" if modes.problem.kind == "inverse" else _pose_text(solution)
    return where + _limits_text(solution)


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
