"""Levenberg-Marquardt on all closure rows, for every start at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from symkin.numeric.linear_algebra import part_by_part, pattern_of
from symkin.numeric.newton import Rows

_SLIGHT_DAMPING = 1e-2
"""Damping up to which a step sees all that could shrink the rows: a direction of singular value s
is seen by the share s^2 / (s^2 + damping^2) of what it could.
"""
_NO_GAIN = 1e-8
"""Of |F|: a step that shrinks |F|^2 by no more than the square of this share shrinks nothing."""
_ROUNDING = 2.0**-50
"""Of the size: norm of rows that is rounding."""
Progress = Callable[[int, int], None]
"""Called with (starts finished, starts in all)."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Where n starts ended: points (n, width), largest row (n,) in the length unit, and whether
    each is a root.
    """

    points: np.ndarray
    largest_row: np.ndarray
    converged: np.ndarray
    iterations: int


def levenberg_marquardt(
    system: Rows,
    starts: np.ndarray,
    known: np.ndarray,
    *,
    tolerance: float = 1e-9,
    max_iterations: int = 80,
    patience: int = 5,
    progress: Progress | None = None,
    trace: list[np.ndarray] | None = None,
) -> Batch:
    """Minimise |F|^2 / 2 from each start with (J^T J + l^2 I) d = -J^T F, a damping l for each
    start; known values are those of each start (n, known) or of all (known,).

    A start is finished when its largest row is below `tolerance` times the size, when `patience`
    steps have shrunk |F| by less than a tenth while it is far from zero (a local minimum), when a
    step of slight damping is told to shrink it by rounding only (the bottom of one), or when it
    meets NaN. `trace` takes the points after each step.
    """
    points = starts.copy()
    count = len(points)
    values, jacobians = system.linearise(points, known)
    cost = np.linalg.norm(values, axis=1)
    damping, pattern = np.full(count, 0.1), pattern_of(jacobians)
    mark, since = cost.copy(), np.zeros(count, dtype=int)
    floor = tolerance * system.characteristic_length
    active = np.flatnonzero(
        np.isfinite(cost) & (np.max(np.abs(values), axis=1, initial=0.0) > floor)
    )
    iteration = 0
    for iteration in range(1, max_iterations + 1):  # noqa: B007 - the last value is reported
        if active.size == 0:
            break
        solve = partial(_damped_steps, damping=damping[active])
        # that of all steps so far: entries that vanish for a step only make no new parts
        pattern |= pattern_of(jacobians[active])
        step = part_by_part(solve, jacobians[active], values[active], pattern)
        gain = -np.einsum("ni,nij,nj->n", values[active], jacobians[active], step)
        least = np.maximum(_NO_GAIN * cost[active], _ROUNDING * system.characteristic_length)
        bottom = (damping[active] <= _SLIGHT_DAMPING) & (gain <= least**2)
        trial = system.move(points[active], step)
        trial_values, trial_jacobians = system.linearise(
            trial, known[active] if known.ndim == 2 else known
        )
        trial_cost = np.linalg.norm(trial_values, axis=1)
        better = trial_cost < cost[active]
        taken = active[better]
        points[taken], values[taken] = trial[better], trial_values[better]
        jacobians[taken], cost[taken] = trial_jacobians[better], trial_cost[better]
        damping[active] = np.where(
            better, np.maximum(damping[active] * 0.25, 1e-12), damping[active] * 4.0
        )
        since[active] += 1
        moved = active[cost[active] < 0.9 * mark[active]]
        mark[moved], since[moved] = cost[moved], 0
        done = np.max(np.abs(values[active]), axis=1, initial=0.0) <= floor
        stuck = (since[active] >= patience) | (damping[active] > 1e8)
        active = active[~(done | stuck | bottom)]
        if trace is not None:
            trace.append(points.copy())
        if progress is not None:
            progress(count - active.size, count)
    largest = np.max(np.abs(values), axis=1, initial=0.0)
    converged = np.isfinite(largest) & (
        largest <= np.maximum(floor, 1e-7 * system.characteristic_length)
    )
    return Batch(points, largest, converged, iteration)


def patiently(
    system: Rows,
    starts: np.ndarray,
    known: np.ndarray,
    trace: list[np.ndarray] | None = None,
) -> Batch:
    """As `levenberg_marquardt`, for starts that may be far from any root: some ten steps suffice
    from one nearby.
    """
    return levenberg_marquardt(system, starts, known, max_iterations=300, patience=60, trace=trace)


def _damped_steps(jacobians: np.ndarray, values: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Steps d (n, columns) with (J^T J + l^2 I) d = -J^T F; of parts of n matrices, as many after
    each other, l (n,) is that of their matrix.
    """
    freedom = jacobians.shape[2]
    transposed = jacobians.transpose(0, 2, 1)
    normal = transposed @ jacobians
    diagonal = normal[:, range(freedom), range(freedom)]
    damping = np.repeat(damping, len(jacobians) // len(damping))
    normal[:, range(freedom), range(freedom)] += (
        damping**2 + 1e-13 * np.max(diagonal, axis=1, initial=0.0) + 1e-30
    )[:, None]
    try:
        steps = np.linalg.solve(normal, -(transposed @ values[:, :, None]))
    except np.linalg.LinAlgError:
        return np.zeros((len(values), freedom))
    return steps[:, :, 0]
