"""Write a transmission as rows F(w) = 0 over motors, joints and what is between them.

At a closed configuration w = w(s) on a chart s of the linkage's motion, F_w w_s = 0 and
F_w w_ss = -F_ww w_s w_s. With m and j the motors' and joints' parts of w,

    d joints / d motors    J = j_s m_s^-1,    d2j/dm2 = (j_ss - J m_ss)(m_s^-1, m_s^-1)
    d motors / d joints    G = m_s j_s^-1,    d2m/dj2 = (m_ss - G j_ss)(j_s^-1, j_s^-1)

so that neither side is preferred where the other is singular. Quaternions are four numbers with
|q|^2 = 1 among the rows.

Many configurations are followed at once, each along a straight line of its known values. A step
from z0 to z1 is taken where the Jacobians at its ends are near to each other, |J1^+ J0 - I| at most
`_NEAR`: every mean of such Jacobians is regular, so that no other solution lies between. What
cannot be reached in this way is told with the share of the line up to which it leads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import casadi as ca
import numpy as np

from symkin.closure.link_poses import joint_readings, link_poses
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate, units_of
from symkin.model.mechanism import Mechanism
from symkin.numeric.linear_algebra import least_squares_steps
from symkin.numeric.mapped import Mapped
from symkin.numeric.system import System
from symkin.numeric.tolerances import RANK_TOLERANCE, ROUNDED_STEP
from symkin.position.closed_configurations import closed_configurations, whole_system
from symkin.position.problem import Problem, build_problem


@dataclass(frozen=True, eq=False)
class Linkage:
    """The loops between motors and joints, named by their coordinates, as a machine of its own."""

    mechanism: Mechanism
    motors: tuple[str, ...]
    joints: tuple[str, ...]

    @cached_property
    def problem(self) -> Problem:
        """The rows with the motors known."""
        held = tuple(name for name in self.joints if name not in self.motors)
        return build_problem(self.mechanism, self.motors, held)

    @cached_property
    def system(self) -> System:
        """The rows with every coordinate unknown."""
        return whole_system(self.problem.closure)

    @cached_property
    def _systems(self) -> dict[tuple[str, ...], System]:
        """The rows with the coordinates of the motors, or of the joints, known."""
        closure, found = self.problem.closure, dict[tuple[str, ...], System]()
        for names in (self.motors, self.joints):
            unknowns = tuple(c for c in closure.coordinates if c.name not in names)
            symbols = closure.symbols(unknowns), closure.symbols(self.coordinates_of(names))
            found[names] = replace(
                self.problem.system, unknowns=unknowns, unknown=symbols[0], known=symbols[1]
            )
        return found

    def coordinates_of(self, names: Sequence[str]) -> list[Coordinate]:
        known = {c.name: c for c in self.problem.closure.coordinates}
        return [known[name] for name in names]

    def places_of(self, names: Sequence[str]) -> np.ndarray:
        """Places of single coordinates in w."""
        return self.problem.places(tuple(self.coordinates_of(names)))

    def radians(self, names: Sequence[str]) -> np.ndarray:
        """What turns values of coordinates in the mechanism's units into radians and lengths."""
        return np.array([self.mechanism.value_in(c, 1.0) for c in self.coordinates_of(names)])

    @cached_property
    def motor_places(self) -> np.ndarray:
        return self.places_of(self.motors)

    @cached_property
    def joint_places(self) -> np.ndarray:
        return self.places_of(self.joints)

    @cached_property
    def reference(self) -> np.ndarray:
        """w at the reference, polished."""
        closure = self.problem.closure
        return self.system.polish(closure.reference, np.zeros(0))

    @property
    def size(self) -> float:
        return self.mechanism.characteristic_length

    @cached_property
    def units(self) -> np.ndarray:
        """The size for lengths and 1 for other numbers of w."""
        return np.array(units_of(self.problem.closure.coordinates, self.size))

    def moved(self, names: tuple[str, ...], starts: np.ndarray, goals: np.ndarray) -> Followed:
        """Configurations w from some, or from one, along straight lines of the motors or the joints
        to goals (n, names).
        """
        system = self._systems[names]
        unknown, known = self.problem.places(system.unknowns), self.places_of(names)
        w = np.broadcast_to(starts, (len(goals), self.units.size)).copy()
        found = follow_lines(system, w[:, unknown], w[:, known], goals)
        w[:, unknown] = found.points
        w[:, known] += found.shares[:, None] * (goals - w[:, known])
        return Followed(w, found.shares)

    # --- differentials at n closed configurations w (n, width) ------------------------------------

    @cached_property
    def _rows(self) -> ca.SX:
        """F over the size, lengths of w over it too, and the norms of quaternions."""
        closure = self.problem.closure
        norms = whole_system(closure).norms(closure.variables)
        return ca.vertcat(closure.bound(closure.rows) / self.size, 0.5 * norms)

    @cached_property
    def _slopes(self) -> Mapped:
        w = self.problem.closure.variables
        return Mapped.of([w], [ca.mtimes(ca.jacobian(self._rows, w), ca.diag(self.units))])

    @cached_property
    def _curvature(self) -> Mapped:
        """F_ww u v."""
        w = self.problem.closure.variables
        u, v = ca.SX.sym("u", w.shape[0]), ca.SX.sym("v", w.shape[0])
        along = ca.jtimes(ca.jtimes(self._rows, w, self.units * u), w, self.units * v)
        return Mapped.of([w, u, v], [along])

    @cached_property
    def generic(self) -> np.ndarray:
        """Closed configurations (n, width) of the reference's own assembly, itself among them."""
        return np.array([self.reference, *closed_configurations(self.problem.closure, 0)])

    @cached_property
    def mobility(self) -> int:
        """Freedoms at generic closed configurations."""
        singular = np.linalg.svd(self._slopes(self.generic)[0], compute_uv=False)
        ranks = np.sum(singular > RANK_TOLERANCE * singular[:, :1], axis=1)
        return int(self.units.size - ranks.max(initial=0))

    def tangents(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """An orthonormal w_s (n, width, mobility), what solves F_w x = y (n, width, rows), and
        whether the rank is the generic one (n,); lengths are over the size.
        """
        free = self.mobility
        left, singular, right = np.linalg.svd(self._slopes(w)[0])
        rank = self.units.size - free
        kept = singular[:, :rank]
        regular = kept[:, -1] > RANK_TOLERANCE * kept[:, 0] if rank else np.ones(len(w), bool)
        inverse = 1.0 / np.where(regular[:, None], kept, 1.0)
        solving = (right[:, :rank].transpose(0, 2, 1) * inverse[:, None]) @ left[
            :, :, :rank
        ].transpose(0, 2, 1)
        return right[:, rank:].transpose(0, 2, 1), solving, regular

    def bends(self, w: np.ndarray, tangents: np.ndarray, solving: np.ndarray) -> np.ndarray:
        """w_ss (n, width, mobility, mobility) for these w_s; lengths are over the size."""
        free = tangents.shape[2]
        found = np.empty((*tangents.shape, free))
        for a in range(free):
            for b in range(a, free):
                along = self._curvature(w, tangents[:, :, a], tangents[:, :, b])[0]
                found[:, :, a, b] = found[:, :, b, a] = -(solving @ along)[:, :, 0]
        return found

    # --- limits -----------------------------------------------------------------------------------

    @cached_property
    def limited(self) -> tuple[Coordinate, ...]:
        """Coordinates with limits, passive ones too; ranges of more than two turns are none."""
        return tuple(
            c
            for c in self.mechanism.coordinates
            if c.limits is not None
            and not (c.is_angular and c.limits[1] - c.limits[0] >= 4.0 * np.pi)
        )

    def beyond_limits(self, w: np.ndarray) -> np.ndarray:
        """By how much each of the `limited` (n, limited) is beyond its limits, below 0 within."""
        closure = self.problem.closure
        own = [c for c in self.limited if c.name not in closure.slices]
        read = joint_readings(closure, link_poses(closure, w)) if own and len(w) else {}
        found = np.empty((len(w), len(self.limited)))
        for k, c in enumerate(self.limited):
            low, high = c.limits or (-np.inf, np.inf)
            values = w[:, closure.slices[c.name].start] if c not in own else read.get(c.name)
            if values is None:
                found[:, k] = -np.inf
                continue
            if c in own and c.is_periodic:
                # a reading is an angle modulo turns: that next to the middle of its range
                middle = 0.5 * (low + high)
                values = middle + np.remainder(values - middle + np.pi, 2 * np.pi) - np.pi
            found[:, k] = np.maximum(low - values, values - high)
        return found


_NEAR, _EASY = 0.5, 0.15
"""Largest row sum of |J1^+ J0 - I| of a step that is taken, and of one after which the next is
twice as long.
"""
_LONGEST = 0.3
"""Of a step of any unknown: radians, and lengths over the size."""
_SHORTEST = 1e-7
"""Share of a line below which steps end: what is left is a singularity, or opens."""
_CLOSED = 1e-12
"""Closure error of a point, over the size."""
_NEWTON = 6
_TINY = 1e-14
"""Of the normal equations' trace, added to their diagonal, so that they can be solved where they
are singular but for rounding: directions of singular values below 1e-7 count as lost.
"""
_MOST_STEPS = 2000


class Followed(NamedTuple):
    """Points (n, width), and the share of its line (n,) that each has come: 1 at the goal."""

    points: np.ndarray
    shares: np.ndarray

    @property
    def reached(self) -> np.ndarray:
        return self.shares >= 1.0


def follow_lines(
    system: System, start: np.ndarray, begin: np.ndarray, goals: np.ndarray
) -> Followed:
    """Follow the unknowns `start` (n, width) while the known values move from `begin` (n, known) to
    `goals` (n, known). Goals that are not finite are not followed.
    """
    size = system.characteristic_length
    points, shares = start.copy(), np.zeros(len(goals))
    steps = np.full(len(goals), 1.0)
    jacobians = system.linearise(points, begin)[1]
    going = np.flatnonzero(np.isfinite(goals).all(axis=1))
    eye = np.eye(system.freedom)
    for _ in range(_MOST_STEPS):
        if not going.size:
            break
        share = np.minimum(shares[going] + steps[going], 1.0)
        known = begin[going] + share[:, None] * (goals[going] - begin[going])
        moved = system.polish_many(points[going], known, _NEWTON)
        change = np.abs(system.difference(points[going], moved.points)).max(axis=1, initial=0.0)
        closed = np.abs(moved.rows).max(axis=1, initial=0.0) <= _CLOSED * size
        turned = _distances(moved.jacobians, jacobians[going], eye)
        good = closed & (turned <= _NEAR) & (change <= _LONGEST * size)
        taken = going[good]
        points[taken], jacobians[taken] = moved.points[good], moved.jacobians[good]
        shares[taken] = share[good]
        steps[taken] *= np.where(turned[good] <= _EASY, 2.0, 1.0)
        steps[going[~good]] *= 0.5
        going = going[(shares[going] < 1.0) & (steps[going] > _SHORTEST)]
    # what counts as closed may be far from the solution in directions that close little
    done = np.flatnonzero(shares >= 1.0)
    rows, slopes = system.linearise(points[done], goals[done])
    points[done] = system.move(points[done], least_squares_steps(slopes, rows, ROUNDED_STEP))
    return Followed(points, shares)


def _distances(after: np.ndarray, before: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """The largest row sum of |J1^+ J0 - I| (n,), at least 1 where J1 has no such inverse."""
    if not eye.size:
        return np.zeros(len(after))
    finite = np.isfinite(after).all(axis=(1, 2), keepdims=True)
    after = np.where(finite, after, 0.0)
    # by the normal equations, kept solvable: half of the digits suffice to judge a step
    turned = after.transpose(0, 2, 1)
    gram = turned @ after
    floor = _TINY * np.trace(gram, axis1=1, axis2=2) + np.finfo(float).tiny
    near = np.linalg.solve(gram + floor[:, None, None] * eye, turned @ before) - eye
    return np.abs(near).sum(axis=2).max(axis=1)
