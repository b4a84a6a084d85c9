"""Write a block's rows along one interval of a path: G(y; c) = 0 for y = (z, u), the unknowns and
the path parameter.

Lengths among the unknowns z are over the size, and so are the rows; angles and unit quaternions are
as they are, and each quaternion has a row (q.q - 1) / 2 = 0 of its own. The coefficients c are the
interval's ends (see `trajectory`), so that one graph serves all intervals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import instructions
from symkin.computed_once import cached_property, lru_cache
from symkin.following.trajectory import great_circle
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.balls import BallFunction, raise_constants
from symkin.numeric.system import System, incidence_of, split_blocks
from symkin.numeric.tolerances import ROUNDED_STEP
from symkin.pool import Pool
from symkin.position.problem import Problem

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
        whole = self.problem.system
        starts = {c.name: place for c, place in zip(whole.unknowns, whole.slices, strict=True)}
        parts = [np.arange(starts[c.name].start, starts[c.name].stop) for c in self.system.unknowns]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=int)

    @property
    def is_square(self) -> bool:
        return self.count == self.width

    @cached_property
    def has_series(self) -> bool:
        """Whether the rows can be evaluated along power series over balls."""
        operations = {
            op
            for op, *_ in instructions(
                ca.Function("rows", [self.y, self.c], [ca.densify(self.rows)])
            )
        }
        return not operations & {ca.OP_SQRT, ca.OP_ATAN2}

    @cached_property
    def balls(self) -> BallFunction:
        """G and dG/dy over balls."""
        return BallFunction(self.y, self.c, self.rows, ("value", "slope"))

    @cached_property
    def second(self) -> tuple[BallFunction, tuple[float, ...]]:
        """The derivative of dG/dy along d over balls, row by row in (y, d), and the constants that
        follow c as its knowns.
        """
        rows, constants, values = raise_constants(self.rows, self.y, self.c)
        d = ca.SX.sym("d", self.width + 1)
        along = ca.jtimes(ca.vec(ca.jacobian(rows, self.y).T), self.y, d)
        return BallFunction(ca.vertcat(self.y, d), ca.vertcat(self.c, constants), along), values

    @cached_property
    def _function(self) -> ca.Function:
        outputs = [ca.densify(self.rows), ca.densify(ca.jacobian(self.rows, self.y))]
        return ca.Function("path", [self.y, self.c], outputs, {"cse": True})

    @property
    def count(self) -> int:
        """Rows, the norms of quaternions included."""
        return int(self.rows.shape[0])

    @cached_property
    def _buffers(self) -> Pool[tuple[Any, ...]]:
        return Pool(self._make_buffer)

    def _make_buffer(self) -> tuple[Any, ...]:
        """The function with its memory: y, c, values, jacobian (transposed), and the call."""
        buffer, call = self._function.buffer()
        shapes = [
            (self.width + 1,),
            (int(self.c.shape[0]),),
            (self.count,),
            (self.width + 1, self.count),
        ]
        arrays = [np.zeros(shape) for shape in shapes]
        for k in (0, 1):
            buffer.set_arg(k, arrays[k].data)
            buffer.set_res(k, arrays[k + 2].reshape(-1).data)
        return (*arrays, call, buffer)

    def evaluate(self, y: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """G (m,) and dG/dy (m, w + 1)."""
        with self._buffers.borrowed() as (point, coefficients, values, jacobian, call, _):
            point[:], coefficients[:] = y, c
            call()
            return values.copy(), jacobian.T.copy()

    def correct(
        self, y: np.ndarray, c: np.ndarray, direction: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Newton (Gauss-Newton where rows are redundant) at a fixed u, or on the hyperplane through
        y across a direction: y and dG/dy there, and the size of the last step (infinite where rows
        are not finite).
        """
        size = np.inf
        for _ in range(_NEWTON_STEPS):
            values, jacobian = self.evaluate(y, c)
            if not (np.isfinite(values).all() and np.isfinite(jacobian).all()):
                return y, jacobian, np.inf
            if direction is None:
                step = np.append(least_squares(jacobian[:, :-1], values), 0.0)
            else:
                step = least_squares(np.vstack([jacobian, direction]), np.append(values, 0.0))
            before, size = size, float(np.max(np.abs(step), initial=0.0))
            y = y - step
            if size < 1e-9 or size > 1.0 or (size < NEWTON_ARRIVED and size > 0.5 * before):
                break
        return y, self.evaluate(y, c)[1], size

    def unknown(self, z: np.ndarray) -> np.ndarray:
        """The unknowns in radians and the length unit, quaternions of unit length."""
        return np.asarray(self.system.unit(z * self.scale))


def least_squares(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x with matrix x = right, by least squares where rows are redundant; NaN where there is
    none.
    """
    try:
        if matrix.shape[0] == matrix.shape[1]:
            return np.asarray(np.linalg.solve(matrix, right))
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=ROUNDED_STEP)[0])
    except np.linalg.LinAlgError:
        return np.full((matrix.shape[1], *right.shape[1:]), np.nan)


@lru_cache(maxsize=128)
def path_systems(problem: Problem) -> tuple[PathSystem, ...]:
    """The rows of each independent block of a problem along an interval; built once for each
    problem.
    """
    return tuple(_path_system(problem, block) for block in _independent(problem))


def _independent(problem: Problem) -> tuple[System, ...]:
    """The independent parts of a problem; those of coordinates told by name are what rows and
    checks join.
    """
    if problem.kind != "given":
        return problem.blocks
    return split_blocks(problem.system, incidence_of(problem.system.errors, problem.system))


def _path_system(problem: Problem, system: System) -> PathSystem:
    size = problem.closure.characteristic_length
    y = ca.SX.sym("y", system.width + 1)
    scale = np.array(units_of(system.unknowns, size))
    known, coefficients = _known(problem.known_coordinates, y[system.width])
    rows = ca.substitute(
        system.rows / size,
        ca.vertcat(system.unknown, system.known),
        ca.vertcat(ca.DM(scale) * y[: system.width], known),
    )
    norms = [
        0.5 * (ca.sumsqr(y[place]) - 1)
        for c, place in zip(system.unknowns, system.slices, strict=True)
        if c.kind == "quaternion"
    ]
    return PathSystem(problem, system, y, coefficients, ca.vertcat(rows, *norms), scale)


def _known(coordinates: tuple[Coordinate, ...], u: ca.SX) -> tuple[ca.SX, ca.SX]:
    """k(u) and its coefficients: a, b - a for each number; a, n, half angle for each quaternion."""
    values, symbols = [], []
    for c in coordinates:
        if c.kind == "quaternion":
            a, n, half = ca.SX.sym("a", 4), ca.SX.sym("n", 4), ca.SX.sym("h")
            values.append(ca.cos(u * half) * a + ca.sin(u * half) * n)
            symbols += [a, n, half]
        else:
            a, d = ca.SX.sym("a"), ca.SX.sym("d")
            values.append(a + u * d)
            symbols += [a, d]
    return ca.vertcat(ca.SX(0, 1), *values), ca.vertcat(ca.SX(0, 1), *symbols)


def coefficients(problem: Problem, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The values of c for the interval from sample a to sample b."""
    out: list[float] = []
    start = 0
    for c in problem.known_coordinates:
        place = slice(start, start + c.width)
        if c.kind == "quaternion":
            half, normal = great_circle(a[place], b[place])
            out += [*a[place].tolist(), *normal.tolist(), half]
        else:
            out += [float(a[start]), float(b[start] - a[start])]
        start += c.width
    return np.array(out)


def coefficient_scales(problem: Problem) -> np.ndarray:
    """What rounding in each of the coefficients is relative to, beside its value: the size for
    lengths, 1 for others.
    """
    out: list[float] = []
    for c in problem.known_coordinates:
        out += (
            [1.0] * 9
            if c.kind == "quaternion"
            else [problem.closure.characteristic_length if c.kind == "length" else 1.0] * 2
        )
    return np.array(out)
