"""Write a block's rows along one interval of a path: G(y; c) = 0 for y = (z, u), the unknowns and
the path parameter.

Lengths among the unknowns z are over the size, and so are the rows; angles and unit quaternions are
as they are, and each quaternion has a row (q.q - 1) / 2 = 0 of its own. The coefficients c are the
interval's ends (see `trajectory`), so that one graph serves all intervals.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.certificate.discs import DiscFunction
from symkin.computed_once import cached_property, lru_cache
from symkin.following.trajectory import between_samples
from symkin.model.joint import units_of
from symkin.numeric.mapped import Mapped
from symkin.numeric.system import System, split_blocks
from symkin.numeric.tape import build_tape, raise_constants
from symkin.numeric.tolerances import ROUNDED_STEP
from symkin.position.problem import Problem
from symkin.spatial.backend import stacked

NEWTON_ARRIVED = 1e-7
"""A Newton step below this (over the size, or rad) is that of a root: the next one would be its
square.
"""
_NEWTON_STEPS = 8
"""Newton steps at most; from a good prediction two or three suffice."""


@dataclass(frozen=True, eq=False)
class PathSystem:
    """Rows G (m,) in y (w + 1,) with coefficients c. `scale` (w,): an unknown is `scale` times its
    part of y. `system` is the block, `places` (w,) where its unknowns stand among those of the
    problem. `is_square`: as many rows as unknowns, so that a regular root of some combinations of
    rows is one of all.
    """

    problem: Problem
    system: System
    y: ca.SX
    c: ca.SX
    rows: ca.SX
    scale: np.ndarray

    @property
    def width(self) -> int:
        return len(self.scale)

    @cached_property
    def places(self) -> np.ndarray:
        whole = [self.problem.system.places[c.name] for c in self.system.unknowns]
        parts = [np.arange(place.start, place.stop) for place in whole]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=int)

    @property
    def is_square(self) -> bool:
        return self.count == self.width

    @cached_property
    def discs(self) -> DiscFunction:
        """G and dG/dy over discs."""
        return DiscFunction(build_tape(self.y, self.c, self.rows, ("value", "slope")))

    @cached_property
    def bend(self) -> tuple[DiscFunction, tuple[float, ...]]:
        """The derivative of dG/dy along d over discs, row by row in (y, d), and the constants that
        follow c as its knowns.
        """
        rows, constants, values = raise_constants(self.rows, self.y, self.c)
        d = ca.SX.sym("d", self.width + 1)
        along = ca.jtimes(ca.vec(ca.jacobian(rows, self.y).T), self.y, d)
        tape = build_tape(
            ca.vertcat(self.y, d), ca.vertcat(self.c, constants), ca.vec(along), ("value",)
        )
        return DiscFunction(tape), values

    @cached_property
    def _function(self) -> Mapped:
        return Mapped.of([self.y, self.c], [self.rows, ca.jacobian(self.rows, self.y)])

    @property
    def count(self) -> int:
        """Rows, the norms of quaternions included."""
        return self.rows.shape[0]

    @cached_property
    def coefficient_scales(self) -> np.ndarray:
        """What rounding in each of the coefficients is relative to, beside its value: the size for
        lengths, 1 for others.
        """
        size = self.problem.closure.characteristic_length
        parts = [
            [1.0] * 9 if c.is_rotation else [c.unit(size)] * 2
            for c in self.problem.known_coordinates
        ]
        return np.array([v for part in parts for v in part])

    def changes(self, c: np.ndarray) -> np.ndarray:
        """The largest change of a known coordinate (over the size, or rad) on intervals (k,)."""
        found, place = [np.zeros(len(c))], 0
        for coordinate in self.problem.known_coordinates:
            place += 9 if coordinate.is_rotation else 2
            found.append(np.abs(c[:, place - 1]) / self.coefficient_scales[place - 1])
        return np.asarray(np.max(found, axis=0))

    def evaluate(self, y: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """G (n, m) and dG/dy (n, m, w + 1) at points y (n, w + 1) with coefficients c (n, ...)."""
        values, jacobian = self._function(y, c)
        return values[..., 0], jacobian

    def correct(self, y: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Newton (Gauss-Newton where rows are redundant) from points y (n, w + 1) at a fixed u: y
        and dG/dy there, and the size (n,) of the last step (infinite where rows are not finite).
        """
        y, size = y.copy(), np.full(len(y), np.inf)
        values, jacobian = self.evaluate(y, c)
        moving = np.arange(len(y))
        for _ in range(_NEWTON_STEPS):
            finite = np.isfinite(values).all(axis=1) & np.isfinite(jacobian).all(axis=(1, 2))
            size[moving[~finite]] = np.inf
            moving, values, jacobian = (a[finite] for a in (moving, values, jacobian))
            step = np.zeros((len(moving), self.width + 1))
            step[:, :-1] = least_squares(jacobian[..., :-1], values)
            before = size[moving]
            now = np.max(np.abs(step), axis=1, initial=0.0)
            y[moving], size[moving] = y[moving] - step, np.where(np.isnan(now), np.inf, now)
            with np.errstate(invalid="ignore"):
                more = ~(
                    (now < 1e-9) | ~(now <= 1.0) | ((now < NEWTON_ARRIVED) & (now > 0.5 * before))
                )
            moving = moving[more]
            if not len(moving):
                break
            values, jacobian = self.evaluate(y[moving], c[moving])
        return y, self.evaluate(y, c)[1], size

    def unknown(self, z: np.ndarray) -> np.ndarray:
        """The unknowns in radians and the length unit, quaternions of unit length."""
        return np.asarray(self.unknowns(z[None])[0])

    def unknowns(self, z: np.ndarray) -> np.ndarray:
        """The same of many points."""
        return self.system.move(z * self.scale, np.zeros((len(z), self.system.freedom)))


def least_squares(matrices: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x (n, b) with matrices (n, a, b) x = right (n, a), by least squares where rows are redundant;
    NaN where there is none.
    """
    if matrices.shape[1] == matrices.shape[2]:
        try:
            return np.linalg.solve(matrices, right[..., None])[..., 0]
        except np.linalg.LinAlgError:
            if len(matrices) == 1:
                return np.full((1, matrices.shape[2]), np.nan)
            each = [least_squares(m[None], r[None]) for m, r in zip(matrices, right, strict=True)]
            return np.concatenate(each)
    return (inverses(matrices) @ right[..., None])[..., 0]


def along(slopes: np.ndarray) -> np.ndarray:
    """dz/du (n, w) of branches from dG/dy (n, m, w + 1): -(dG/dz)^-1 dG/du."""
    return -least_squares(slopes[..., :-1], slopes[..., -1])


def inverses(matrices: np.ndarray) -> np.ndarray:
    """About the (pseudo-)inverses of matrices (n, a, b), a not below b; zero for those that are
    not finite.
    """
    fine = np.isfinite(matrices).all(axis=(1, 2))
    left, singular, right = np.linalg.svd(
        np.where(fine[:, None, None], matrices, 0.0), full_matrices=False
    )
    return right.transpose(0, 2, 1) @ scaled_left(singular, left)


def scaled_left(singular: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Left singular vectors (n, a, b) as rows, over their singular values (n, b), or zero where
    these are zero to rounding.
    """
    regular = singular > ROUNDED_STEP * singular.max(axis=1, keepdims=True, initial=0.0)
    over = np.where(regular, 1.0 / np.where(regular, singular, 1.0), 0.0)
    return left.transpose(0, 2, 1) * over[..., None]


@lru_cache(maxsize=128)
def path_systems(problem: Problem) -> tuple[PathSystem, ...]:
    """The rows of each independent block of a problem along an interval; built once for each
    problem.
    """
    return tuple(
        _path_system(problem, block) for block in split_blocks(problem.system, by_errors=True)
    )


def _path_system(problem: Problem, system: System) -> PathSystem:
    size = problem.closure.characteristic_length
    y = ca.SX.sym("y", system.width + 1)
    scale = np.array(units_of(system.unknowns, size))
    c = ca.SX.sym("c", sum(9 if one.is_rotation else 2 for one in problem.known_coordinates))
    known = stacked(between_samples(problem.known_coordinates, c, y[system.width]))
    rows = ca.substitute(
        system.rows / size,
        ca.vertcat(system.unknown, system.known),
        ca.vertcat(ca.DM(scale) * y[: system.width], known),
    )
    rows = ca.vertcat(rows, 0.5 * system.norms(y))
    return PathSystem(problem, system, y, c, rows, scale)
