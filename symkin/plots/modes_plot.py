"""Pictures of modes and single solutions: a panel for each configuration, with its pose or joints
above it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.assembly.modes_result import Modes, nothing_found
from symkin.drawing.layout import layout_of
from symkin.errors import InputError
from symkin.plots.figures import Panel, figure_of_panels
from symkin.plots.look import listed, panel_of
from symkin.plots.picture_options import chosen_numbers, looks_of, ranges_text
from symkin.position.solution import Solution
from symkin.position.solve_result import SolveResult
from symkin.position.table import without_rounding

if TYPE_CHECKING:
    from matplotlib.figure import Figure


DEFAULT_MOST = 12
"""Panels of a picture of modes where nothing is chosen."""


def figure_of_modes(
    found: Modes,
    *,
    modes: str | Sequence[int] | None = None,
    most: int = DEFAULT_MOST,
    names: str = "none",
    views: str | Sequence[str] = "main",
) -> Figure:
    """One panel per mode, those of `shown_numbers`, all with the same limits and equal axes;
    without modes the mechanism's reference configuration. Raises InputError for `most` below 1, and
    for modes, names and views that are not there.
    """
    mechanism = found.problem.mechanism
    numbers = shown_numbers(found, modes, most)
    given = [c.name for c in found.problem.known_coordinates]
    panels = [panel_of(f"mode {k}", found[k - 1], given) for k in numbers] or [
        Panel(nothing_found(found), "drawn at the reference configuration", layout_of(mechanism))
    ]
    part = (
        f" \N{EM DASH} {len(numbers)} of {found.total} modes shown"
        if len(numbers) < found.total
        else ""
    )
    looks = looks_of(mechanism, names, views)
    return figure_of_panels(mechanism, panels, _facts(found), part, **looks)


def shown_numbers(
    modes: Modes, chosen: str | Sequence[int] | None = None, most: int = DEFAULT_MOST
) -> list[int]:
    """Numbers of the modes that a picture shows: the chosen ones, else `most` of them, poses and
    sets of actuated joints before branches. Raises InputError.
    """
    if most < 1:
        raise InputError(f"most = {most} must be at least 1")
    if chosen is not None and len(modes):
        return chosen_numbers(chosen, len(modes))
    first = set(modes.first_of_sets)
    numbers = range(1, len(modes) + 1)
    return sorted(sorted(numbers, key=lambda k: (k - 1 not in first, k))[:most])


def left_out(modes: Modes, shown: Sequence[int]) -> str:
    """What a picture of some modes leaves out, in a sentence; empty where it shows all."""
    others = [k for k in range(1, len(modes) + 1) if k not in set(shown)]
    unlisted = (
        f"; {modes.total - len(modes)} more are not listed" if modes.total > len(modes) else ""
    )
    if not others and not unlisted:
        return ""
    numbers = f": {ranges_text(others)}" if others else ""
    return (
        f"shows {len(shown)} of {modes.total} modes, leaves out "
        f"{modes.total - len(shown)}{numbers}{unlisted}; --modes chooses"
    )


def figure_of_solution(
    solution: Solution, *, names: str = "none", views: str | Sequence[str] = "main"
) -> Figure:
    """The mechanism in this configuration, a panel for each view."""
    mechanism = solution.mechanism
    unit, looks = mechanism.length_unit, looks_of(mechanism, names, views)
    facts = [f"closure error {solution.residual:.1e} {unit}, condition {solution.condition:.3g}"]
    return figure_of_panels(mechanism, [panel_of("", solution, ())], facts, **looks)


def figure_of_solve(
    result: SolveResult, *, names: str = "none", views: str | Sequence[str] = "main"
) -> Figure:
    """The configuration that a solve reached. Raises InputError where it reached none."""
    if result.solution is None:
        raise InputError(f"plot: {result.message}")
    return figure_of_solution(result.solution, names=names, views=views)


def _facts(modes: Modes) -> list[str]:
    """What is given, and the count of modes with its completeness."""
    mechanism = modes.problem.mechanism
    given = ", ".join(_given_text(key, values) for key, values in modes.given.items()) or "nothing"
    units = f"{mechanism.length_unit}, {mechanism.angle_unit}"
    statement = f"{modes.counted}; completeness: {modes.completeness}" + (
        f", {modes.starts} starts" if modes.starts else ""
    )
    return [f"{modes.problem.name} problem at {given} [{units}]", statement]


def _given_text(key: str, values: Any) -> str:
    return (
        f"{key} = {values:.5g}"
        if np.ndim(values) == 0
        else f"{key} {listed(without_rounding(values))}"
    )
