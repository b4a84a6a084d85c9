"""The root of rows that is nearest to a start, by Levenberg-Marquardt: of those along the branch
that a search from there comes to.

Of a four-bar thrown open by up to 0.3 rad at every joint that is the nearest of all (240 of 240
starts), of one by 1 rad it need not be (46 of 60).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.rank import row_space
from symkin.numeric.system import NOTHING, System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION, FILE_DIGITS, RANK_TOLERANCE
from symkin.spatial.rotation import wrapped

ROUNDING = 1e-14
"""Of the size: loops that stay open by less are left as they are."""
_ITERATIONS = 300
"""Steps of one search; those that arrive take 10 to 100."""
_STALLED = 25
"""Steps in a row that shrink the gap by less than a tenth, after which a search has ended at a
local minimum.
"""
_STALLED_NEAR = 3
"""The same of a search from a step off a closed configuration."""
_SEARCHES = ((0.05, 4), (0.3, 8), (1.0, 24))
"""Further searches where the first does not close: radians (or shares of the size) of their random
steps, and how many.
"""
_NEAREST_STEPS = 30
"""Steps along the closed configurations towards the start."""
_SAME_DISTANCE = 1e-15
"""Share of a distance by which another one differs in rounding only: it comes no nearer."""
_CLOSING_STEPS = 8
"""Steps of Gauss-Newton to digits: each squares what is left of a tenth."""
_NEAR = FILE_DIGITS**0.5
"""Of the size: how far the root of loops that a file leaves open by its digits is, at a double
point. One that is farther closes what the digits of redundant rows alone leave open.
"""
_SEED = 0


def closed_to_digits(system: System, points: np.ndarray) -> np.ndarray:
    """Gauss-Newton on what moves the rows to the digits of a file: steps along what does not would
    lead away to where loops close exactly.
    """
    for _ in range(_CLOSING_STEPS):
        rows, jacobians = system.linearise(points)
        inverses = np.linalg.pinv(jacobians, rcond=FILE_DIGITS)
        points = system.move(points, -(inverses @ rows[:, :, None])[:, :, 0])
    return points


@dataclass(frozen=True, eq=False)
class NearestRoot:
    """The search of a system whose coordinates are all unknown."""

    system: System
    start: np.ndarray

    def found(self) -> np.ndarray:
        """Search from the start, and go along the roots to the nearest. Where the first search ends
        open, others begin at random steps from there; where all do, the least rows are told. A
        start that is closed to the digits of a file stays so where no root is near.
        """
        system, start = self.system, self.start
        if self._open_by(start) <= ROUNDING * system.characteristic_length:
            return start
        (best,) = self._searched(start[None])
        if self._is_to_digits(start) and not (self._is_closed(best) and self._is_near(best)):
            (own,) = closed_to_digits(system, start[None])
            return self._nearest(min((own, start), key=self._open_by))
        rng = np.random.default_rng(_SEED)
        for radius, count in _SEARCHES:
            if self._is_closed(best):
                break
            steps = radius * system.characteristic_length * rng.normal(size=(count, system.freedom))
            ends = self._searched(system.move(np.tile(start, (count, 1)), steps))
            closed = [self.without_turns(end) for end in ends if self._is_closed(end)]
            best = (
                min(closed, key=lambda z: float(np.linalg.norm(self.way_from(z))))
                if closed
                else min((best, *ends), key=self._open_by)
            )
        return self._nearest(self.without_turns(best)) if self._is_to_digits(best) else best

    def way_from(self, z: np.ndarray) -> np.ndarray:
        """The step of all freedoms, in lengths, from a point to the start; of balls the angle times
        the size.
        """
        system = self.system
        step, begin = system.difference(z[None], self.start[None])[0], 0
        for c in system.unknowns:
            if c.is_rotation:
                turn = step[begin : begin + 3]
                tangent = float(np.linalg.norm(turn)) / (2.0 * system.characteristic_length)
                turn *= np.arctan(tangent) / tangent if tangent else 1.0
            begin += c.freedom
        return step

    def without_turns(self, z: np.ndarray) -> np.ndarray:
        """The same configuration with angles within half a turn of the start's, but those whose
        turns a coupling or a screw counts.
        """
        turns = np.array([c.is_periodic for c in self.system.unknowns for _ in range(c.width)])
        away = z - self.start
        return np.where(turns, z - (away - wrapped(away)), z)

    def _open_by(self, z: np.ndarray) -> float:
        return self.system.residual(z)

    def _is_closed(self, z: np.ndarray) -> bool:
        return self._open_by(z) <= CLOSED_CONFIGURATION * self.system.characteristic_length

    def _is_to_digits(self, z: np.ndarray) -> bool:
        return self._open_by(z) <= FILE_DIGITS * self.system.characteristic_length

    def _is_near(self, z: np.ndarray) -> bool:
        away = float(np.linalg.norm(self.way_from(self.without_turns(z))))
        return away <= _NEAR * self.system.characteristic_length

    def _searched(self, starts: np.ndarray) -> np.ndarray:
        """Where least squares on all rows ends: at rounding, or at a local minimum."""
        return self.system.polish_many(self._ends(starts, _STALLED)).points

    def _ends(self, starts: np.ndarray, patience: int) -> np.ndarray:
        """The same to the digits that its steps reach."""
        return levenberg_marquardt(
            self.system,
            starts,
            NOTHING,
            tolerance=ROUNDING,
            max_iterations=_ITERATIONS,
            patience=patience,
        ).points

    def _nearest(self, z: np.ndarray) -> np.ndarray:
        """Go along the roots towards the start, as long as that comes nearer; along what is closed
        to digits from where no root is.
        """
        system, share, far = self.system, 1.0, float(np.linalg.norm(self.way_from(z)))
        is_root = self._is_closed(z)
        holds = self._is_closed if is_root else self._is_to_digits
        held = RANK_TOLERANCE if is_root else FILE_DIGITS
        for _ in range(_NEAREST_STEPS):
            back = self.way_from(z)
            felt = row_space(system.linearise_one(z)[1], held, relative=True)
            free = back - felt.T @ (felt @ back)
            if share < 1e-3 or np.linalg.norm(free) <= 1e-9 * system.characteristic_length:
                break
            ahead = system.move(z[None], share * free[None])
            ends = self._ends(ahead, _STALLED_NEAR) if is_root else closed_to_digits(system, ahead)
            trial = ends[0]
            distance = float(np.linalg.norm(self.way_from(trial)))
            if distance < far and holds(trial):
                z, far = trial, distance
            elif abs(distance - far) <= _SAME_DISTANCE * far:
                break
            else:
                share *= 0.3
        return system.polish(z, NOTHING, steps=8) if is_root else z
