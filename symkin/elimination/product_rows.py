"""Take passive joints out of the angle that a universal joint keeps: rows that multiply a point of
the platform by a direction of it.

A limb that ends in a U joint holds a point w and directions d of the platform by its joints,
w + f(q, x) = 0 and n(q, x) . d = 0, where d has the numbers of a rotation and 1. Where the point
says what n is, but for a factor that is a polynomial of the joints,

    l(q, x) n(q, x) = M w + m(q)    on w + f = 0,

no passive joint x is left in (M w + m) . d = 0. Of a leg U P U with parallel inner axes the outer
axes and the leg lie in a plane: (b x w) . a = 0, where b is the first axis and a the last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.pose_forms import PlatformPose, weighted_point
from symkin.elimination.polynomial import Monomial, Polynomial, Ring
from symkin.elimination.rows import NotPolynomialError, polynomial_rows
from symkin.numeric.rank import count_above, null_space
from symkin.numeric.system import System
from symkin.spatial.rotation import matrix_from_quaternion

_VANISHED = 1e-9
"""Share of the largest number below which one is rounding."""
_MOST_UNKNOWNS = 300
"""Coefficients that are sought at most."""


@dataclass(frozen=True, eq=False)
class ProductRow:
    """(by w + level) . (turn R + still) = 0: `point` w by the pose, R the nine numbers of the
    rotation matrix of `quaternion`, column by column; `level` by the joints that stay, the rest
    numbers.
    """

    point: ca.SX
    by: np.ndarray
    level: ca.SX
    quaternion: ca.SX
    turn: np.ndarray
    still: np.ndarray
    is_sphere = False

    @property
    def row(self) -> ca.SX:
        """What is zero."""
        turned = ca.vec(matrix_from_quaternion(self.quaternion))
        return self._row(self.point, turned, ca.SX(1))

    def weighted(self, position: ca.SX, quaternion: ca.SX, pose: PlatformPose) -> ca.SX:
        """The row times the square of the weight of a pose in another form, where w is by the
        `position` and the unit `quaternion`.
        """
        turned = ca.vertcat(*(pose.direction(ca.SX(ca.DM(e))) for e in np.eye(3)))
        point = weighted_point(self.point, position, quaternion, pose)
        return self._row(point, turned, pose.weight)

    def _row(self, point: ca.SX, turned: ca.SX, weight: ca.SX) -> ca.SX:
        first = ca.mtimes(_sparse(self.by), point) + weight * self.level
        second = ca.mtimes(_sparse(self.turn), turned) + weight * _sparse(self.still[:, None])
        return ca.dot(first, second)


def _sparse(matrix: np.ndarray) -> ca.SX:
    return ca.SX(ca.sparsify(ca.DM(matrix)))


@dataclass(frozen=True, eq=False)
class Normal:
    """Polynomials n (k,) of joints, and the numbers of d = turn R + still by which they are
    multiplied, R the rotation of `quaternion`.
    """

    parts: tuple[Polynomial, ...]
    quaternion: ca.SX
    turn: np.ndarray
    still: np.ndarray

    @staticmethod
    def of(system: System, ring: Ring, quaternion: ca.SX) -> Normal | None:
        """The only row of a system in joints, whose known value is a quaternion; None where it is
        no polynomial of the joints with coefficients that are linear in the rotation.
        """
        try:
            (row,) = polynomial_rows(ring, system, system.rows, {})
        except NotPolynomialError:
            return None
        monomials = list(row.terms)
        read = ca.Function("c", [system.known], [ca.vertcat(*row.terms.values())])
        turns = np.random.default_rng(0).normal(size=(16, 4))
        turns /= np.linalg.norm(turns, axis=1)[:, None]
        values = np.array([np.asarray(read(q)).ravel() for q in turns])
        basis = np.array([[*matrix_from_quaternion(q).T.ravel().tolist(), 1.0] for q in turns])
        linear = np.linalg.lstsq(basis, values, rcond=None)[0]
        size = float(np.max(np.abs(values), initial=0.0))
        if not size or np.max(np.abs(basis @ linear - values)) > _VANISHED * size:
            return None
        # as few combinations of directions as there are, with as few numbers in each
        mixed = _echelon(linear.T / size)
        weights = np.linalg.lstsq(mixed.T, linear / size, rcond=None)[0]
        parts = tuple(
            Polynomial(
                {
                    m: ca.SX(float(v))
                    for m, v in zip(monomials, column, strict=True)
                    if abs(v) > _VANISHED
                }
            )
            for column in weights
        )
        return Normal(parts, quaternion, mixed[:, :9], mixed[:, 9])


def _echelon(matrix: np.ndarray) -> np.ndarray:
    """A basis of the span of some rows, reduced row by row; numbers that are rounding are zero."""
    left, found = matrix.copy(), list[np.ndarray]()
    while np.max(np.abs(left), initial=0.0) > _VANISHED:
        row, place = np.unravel_index(np.argmax(np.abs(left)), left.shape)
        pivot = left[row] / left[row, place]
        left = left - left[:, [place]] * pivot
        found = [other - other[place] * pivot for other in found] + [pivot]
    return _tidied(np.array(found))


def _tidied(numbers: np.ndarray) -> np.ndarray:
    return np.where(np.abs(numbers) > _VANISHED, numbers, 0.0)


def multipliers(
    ring: Ring, point: Sequence[Polynomial], stay: Sequence[Monomial], normal: Normal
) -> list[tuple[np.ndarray, list[Polynomial]]]:
    """All M (k, 3) and m (k polynomials of joints that stay) with l n = M w + m for some l that is
    not zero, w + `point` = 0.
    """
    every = {m for row in point for m in row.terms} | set(stay)
    held = {m for part in normal.parts for m in part.terms}
    factors = sorted({q for m in every for h in held if (q := _over(m, h)) is not None})
    count = len(normal.parts)
    if not factors or len(factors) + count * (3 + len(stay)) > _MOST_UNKNOWNS:
        return []
    columns: list[list[Polynomial | None]] = [
        [ring.product(Polynomial({q: ca.SX(1)}), part) for part in normal.parts] for q in factors
    ]
    terms = [*point, *(Polynomial({m: ca.SX(-1)}) for m in stay)]
    for k in range(count):
        for term in terms:
            columns.append([term if j == k else None for j in range(count)])
    equations = _equations(columns)
    sizes = np.max(np.abs(equations), axis=1, initial=0.0)
    equations = equations[sizes > 0] / sizes[sizes > 0, None]
    null = null_space(equations, _VANISHED, relative=True)
    if not len(null):
        return []
    # those with a factor l, each as short as it can be
    left, strength, _ = np.linalg.svd(null[:, : len(factors)])
    found = []
    for own in (left.T @ null)[: count_above(strength, 1e-6)]:
        own = _tidied(own / np.max(np.abs(own)))
        rest = own[len(factors) :].reshape(count, -1)
        level = [
            Polynomial({m: ca.SX(float(v)) for m, v in zip(stay, line[3:], strict=True) if v})
            for line in rest
        ]
        found.append((rest[:, :3], level))
    return found


def _equations(columns: Sequence[Sequence[Polynomial | None]]) -> np.ndarray:
    """Coefficients (terms of each sum, columns)."""
    rows: dict[tuple[int, Monomial], int] = {}
    entries = []
    for j, column in enumerate(columns):
        for k, part in enumerate(column):
            for m, value in ({} if part is None else part.terms).items():
                entries.append((rows.setdefault((k, m), len(rows)), j, float(value)))
    matrix = np.zeros((len(rows), len(columns)))
    for i, j, value in entries:
        matrix[i, j] += value
    return matrix


def _over(monomial: Monomial, by: Monomial) -> Monomial | None:
    """A monomial over another, None where that is none."""
    quotient = tuple(a - b for a, b in zip(monomial, by, strict=True))
    return quotient if min(quotient, default=0) >= 0 else None
