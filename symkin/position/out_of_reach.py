"""Which limbs cannot reach, and by how much: what is said where given values have no solution."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.newton import Polished
from symkin.numeric.root_checks import are_roots, rounding
from symkin.numeric.system import split_blocks
from symkin.position.determination import is_least
from symkin.position.given import Given
from symkin.position.mobility import must_agree
from symkin.position.problem import Problem
from symkin.position.starts import random_starts
from symkin.quiet import without_float_warnings
from symkin.text import first_of

_STARTS = 24
"""Random starts of least squares, the first at the reference."""
_LEAST = 1e-15
"""Of the size: rows down to which least squares go on; given values may lie that little beyond
reach.
"""
_MUCH = 0.5
"""Share of the largest row from which a limb's rows count as the ones that stay open."""


@without_float_warnings
def reach_note(problem: Problem, given: Given) -> str | None:
    """Name the limbs that cannot reach a pose, each by itself; for other given values those that
    stay open most where all loops together come nearest to closing; and say by how much. None where
    least squares close them after all, and where nothing is sought.
    """
    system, sources = problem.system, problem.closure.row_sources
    if given.off_motion > 0.0 or not system.width or system.rows.shape[0] != len(sources):
        return None
    nearest = _nearest(problem, given)
    if nearest is None:
        return None
    gap = f"{_gap(problem, nearest, given):.3g} {problem.mechanism.length_unit}"
    left = system.residuals(nearest.points, given.values)
    if is_least(problem, given.values, nearest.points[int(np.argmin(left))], float(left.min())):
        return _few_digits(problem, gap)
    rows = np.abs(system.linearise(nearest.points, given.values)[0])
    names = list(dict.fromkeys(row.limb for row in sources))
    largest = np.stack(
        [
            rows[:, [k for k, row in enumerate(sources) if row.limb == name]].max(axis=1)
            for name in names
        ],
        axis=1,
    )
    if not problem.of_pose:
        return _open(names, largest[int(np.argmin(left))], gap)
    zero = float(rounding(system, nearest.points).max())
    return _out_of_reach(
        problem,
        [name for name, least in zip(names, largest.min(axis=0), strict=True) if least > zero],
        gap,
    )


def _nearest(problem: Problem, given: Given) -> Polished | None:
    """Where least squares from random starts end; None where that is nowhere, or some end is a
    root.
    """
    system = problem.system
    starts = random_starts(problem, system, given.values, _STARTS, np.random.default_rng(0))
    ends = levenberg_marquardt(
        system, starts, given.values, tolerance=_LEAST, max_iterations=200, patience=30
    ).points
    ends = ends[np.all(np.isfinite(ends), axis=1)]
    rows, jacobians = system.linearise(ends, given.values)
    left = system.residuals(ends, given.values)
    if (
        not len(ends)
        or not np.all(np.isfinite(left))
        or are_roots(system, Polished(ends, rows, jacobians), left).any()
    ):
        return None
    return Polished(ends, rows, jacobians)


def _gap(problem: Problem, nearest: Polished, given: Given) -> float:
    """The least closure error (length unit) of the part of the problem for which that is
    largest.
    """
    places, gaps = problem.system.places, [0.0]
    for block in split_blocks(problem.system, by_errors=True):
        columns = np.r_[tuple(places[c.name] for c in block.unknowns)]
        gaps.append(float(block.residuals(nearest.points[:, columns], given.values).min()))
    return max(gaps)


def _few_digits(problem: Problem, gap: str) -> str:
    """What is said where nothing is out of reach, but redundant rows contradict each other."""
    why = must_agree(problem.mechanism) if problem.of_joints else None
    digits = (
        "redundant constraints want more digits in the mechanism's numbers (arithmetic such as "
        '"1/sqrt(3)" is allowed)'
    )
    return f"the loops close to within {gap} only: {why or digits}"


def _out_of_reach(problem: Problem, names: Sequence[str], gap: str) -> str | None:
    """Limbs that cannot reach a pose; of a serial arm, which is one limb, the arm."""
    if not names:
        return None
    nearest = f"where it comes nearest, the loop stays open by {gap}"
    if problem.mechanism.serial:
        return (
            f"the arm cannot reach this pose: it is too far away, or its joints cannot turn the "
            f"tool so; {nearest}"
        )
    if len(names) == len(problem.mechanism.limbs):
        return (
            f"none of the limbs can reach this pose; where they come nearest, loops stay open by "
            f"up to {gap}"
        )
    if len(names) == 1:
        return (
            f"limb {names[0]} cannot reach this pose, in whatever configuration; the others can; "
            f"{nearest}"
        )
    return (
        f"limbs {first_of(names, 8)} cannot reach this pose, in whatever configuration; the others "
        f"can; where they come nearest, "
        f"loops stay open by up to {gap}"
    )


def _open(names: Sequence[str], errors: np.ndarray, gap: str) -> str:
    """The limbs, joints or rods at which the loops stay open most, unless that is most of them; and
    by how much.
    """
    worst = [names[k] for k in np.argsort(-errors) if errors[k] > _MUCH * errors.max()]
    nearest = "where the loops come nearest to closing"
    if len(worst) > max(2, len(names) // 2):
        return f"{nearest}, they stay open by {gap}"
    return f"{nearest}, what stays open most is {first_of(worst, 4)}, by {gap}"
