"""Which limbs cannot reach: what is said where given values have no solution."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.given import Given
from symkin.position.problem import Problem
from symkin.position.starts import random_starts
from symkin.quiet import without_float_warnings
from symkin.text import first_of

_STARTS = 24
"""Random starts of least squares, the first at the reference."""
_CLOSED = 1e-6
"""Largest row (no unit) of a limb that reaches a pose; least squares end there quadratically."""
_MUCH = 0.5
"""Share of the largest row from which a limb's rows count as the ones that stay open."""


@without_float_warnings
def reach_note(problem: Problem, given: Given) -> str | None:
    """Name the limbs that cannot reach a pose, each by itself; for other given values those that stay open most where all loops
    together come nearest to closing. None where least squares close them after all, and where nothing is sought."""
    system, sources = problem.system, problem.closure.row_sources
    if given.off_motion > 0.0 or not system.width or int(system.rows.shape[0]) != len(sources):
        return None
    starts = random_starts(problem, system, given, _STARTS, np.random.default_rng(0))
    ends = levenberg_marquardt(system, starts, given.values, max_iterations=200, patience=30).points
    ends = ends[np.all(np.isfinite(ends), axis=1)]
    if not len(ends):
        return None
    left = system.residuals(ends, given.values)
    if not np.all(np.isfinite(left)) or left.min() <= CLOSURE_TOLERANCE * system.characteristic_length:
        return None
    rows = np.abs(system.linearise(ends, given.values)[0])
    names = list(dict.fromkeys(row.limb for row in sources))
    largest = np.stack([rows[:, [k for k, row in enumerate(sources) if row.limb == name]].max(axis=1) for name in names], axis=1)
    if given.kind == "inverse":
        return _out_of_reach(problem, [name for name, least in zip(names, largest.min(axis=0), strict=True) if least > _CLOSED])
    return _open(names, largest[int(np.argmin(left))])


def _out_of_reach(problem: Problem, names: Sequence[str]) -> str | None:
    """Limbs that cannot reach a pose; of a serial arm, which is one limb, the arm."""
    if not names:
        return None
    if problem.mechanism.serial:
        return "the arm cannot reach this pose: it is too far away, or its joints cannot turn the tool so"
    if len(names) == len(problem.mechanism.limbs):
        return "none of the limbs can reach this pose"
    return f"limb{'s' * (len(names) > 1)} {first_of(names, 8)} cannot reach this pose, in whatever configuration; the others can"


def _open(names: Sequence[str], errors: np.ndarray) -> str | None:
    """The limbs, joints or rods at which the loops stay open most; None where that is most of them."""
    worst = [names[k] for k in np.argsort(-errors) if errors[k] > _MUCH * errors.max()]
    if len(worst) > max(2, len(names) // 2):
        return None
    return f"where the loops come nearest to closing, what stays open most is {first_of(worst, 4)}"
