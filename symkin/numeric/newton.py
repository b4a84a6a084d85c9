"""Gauss-Newton on all rows, for many points at once: roots to full precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from symkin.numeric.linear_algebra import least_squares_steps, squared_norms
from symkin.numeric.tolerances import CLOSURE_ROUNDING, FREE_DIRECTION, ROUNDED_STEP

_ROUNDING = 2.0**-50
"""Norm of the rows, over the size, that is rounding: 4 units in the last place of a length as long
as the size.
"""


class Rows(Protocol):
    """Rows F(z; k) over points that tangent steps move; `size` is the length by which rows are
    judged.
    """

    @property
    def characteristic_length(self) -> float: ...

    @property
    def freedom(self) -> int:
        """Numbers of a tangent step."""

    def linearise(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F (n, rows) and its derivatives along tangent steps (n, rows, freedom)."""

    def move(self, z: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Points (n, width) moved by tangent steps (n, freedom)."""


@dataclass(frozen=True, eq=False)
class Polished:
    """Points z (n, width), and there the rows (n, rows) and their Jacobians (n, rows, freedom)."""

    points: np.ndarray
    rows: np.ndarray
    jacobians: np.ndarray


def polish(
    system: Rows,
    z: np.ndarray,
    known: np.ndarray,
    steps: int = 8,
    floor: float = _ROUNDING,
    begun: tuple[np.ndarray, np.ndarray] | None = None,
) -> Polished:
    """Move points z (n, width) at known values (n, known) or (known,) by z <- z - J^+ F(z), each
    point until its rows are rounding (`floor`, of the size) or a step no longer shrinks them, at
    most `steps` times; F and J at z may be `begun`. Points where F or J is not finite stay. Where
    the rows stay larger than those of roots, directions that a set of roots leaves free have misled
    the step, and it is taken without them.
    """
    found = Polished(z.copy(), *(system.linearise(z, known) if begun is None else begun))
    size, every = system.characteristic_length, np.arange(len(z))
    with np.errstate(over="ignore"):
        stuck = _descend(system, found, known, steps, every, (floor * size, ROUNDED_STEP))
        if stuck.size:
            _descend(system, found, known, steps, stuck, (CLOSURE_ROUNDING * size, FREE_DIRECTION))
    return found


def _descend(
    system: Rows,
    found: Polished,
    known: np.ndarray,
    steps: int,
    chosen: np.ndarray,
    bounds: tuple[float, float],
) -> np.ndarray:
    """Take steps from those of the `chosen` points whose rows are larger than the first bound, by
    singular values above the second, a share of the largest. The points whose last step did not
    shrink the rows are returned.
    """
    floor, cut = bounds
    z, rows, jacobians = found.points, found.rows, found.jacobians
    sizes = np.sqrt(squared_norms(rows))
    finite = np.isfinite(jacobians).all(axis=(1, 2)) & np.isfinite(sizes)
    going, stuck = chosen[finite[chosen] & (sizes[chosen] > floor)], [chosen[:0]]
    for _ in range(steps):
        if not going.size:
            break
        trial = system.move(z[going], least_squares_steps(jacobians[going], rows[going], cut))
        trial_rows, trial_jacobians = system.linearise(
            trial, known[going] if known.ndim == 2 else known
        )
        trial_sizes = np.sqrt(squared_norms(trial_rows))
        better = (trial_sizes < sizes[going]) & np.isfinite(trial_jacobians).all(axis=(1, 2))
        stuck.append(going[~better])
        going, left = going[better], trial_sizes[better]
        z[going], rows[going], jacobians[going], sizes[going] = (
            trial[better],
            trial_rows[better],
            trial_jacobians[better],
            left,
        )
        going = going[left > floor]
    return np.concatenate(stuck)
