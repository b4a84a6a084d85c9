"""Solve small symbolic systems by least squares or for the shortest solution, without choice of
pivots.

Columns are made orthogonal one after the other (modified Gram-Schmidt without square roots, Bjoerck
1967), M = V U with V^T V diagonal and U unit upper triangular: as accurate as other orthogonal
factorisations in solving, and defined wherever the columns are independent, so that expressions
have no poles of their own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from symkin.numeric.system import components

_LARGEST_MINOR = 2
"""Columns up to which one remaining equation is made of minors, without divisions."""
_LIKE = 20
"""Power of two up to which weights of rows are alike: six of sixteen digits may be lost."""


@dataclass(frozen=True, eq=False)
class Factors:
    """M = V U of a matrix (m, k), and what that makes of others beside it (m, l): `coefficients`
    (k, l) with rest = V coefficients + remainder, the remainder orthogonal to M's columns.
    """

    orthogonal: ca.SX
    triangular: ca.SX
    squares: tuple[ca.SX, ...]
    coefficients: ca.SX
    remainder: ca.SX

    def solution(self, first: int = 0) -> ca.SX:
        """Rows `first`... of the least-squares solution Y of M Y = rest: U Y = coefficients."""
        return back_substituted(self.triangular[first:, first:], self.coefficients[first:, :])


def factored(matrix: ca.SX, rest: ca.SX) -> Factors:
    """Orthogonal columns of `matrix`, and `rest` without their span."""
    left, k = ca.sparsify(matrix), matrix.shape[1]
    triangular, coefficients = ca.SX.eye(k), ca.SX(k, rest.shape[1])
    squares, columns = [], []
    for j in range(k):
        column = ca.sparsify(left[:, j])
        parts, square = _parts(column, ca.horzcat(left[:, j + 1 :], rest))
        triangular[j, j + 1 :] = parts[:, : k - j - 1]
        coefficients[j, :] = parts[:, k - j - 1 :]
        left[:, j + 1 :] = _without(left[:, j + 1 :], column, triangular[j, j + 1 :])
        rest = _without(rest, column, coefficients[j, :])
        squares.append(square)
        columns.append(column)
    orthogonal = ca.horzcat(*columns) if columns else ca.SX(matrix.shape[0], 0)
    return Factors(
        orthogonal,
        ca.sparsify(triangular),
        tuple(squares),
        ca.sparsify(coefficients),
        ca.sparsify(rest),
    )


def back_substituted(triangular: ca.SX, right: ca.SX) -> ca.SX:
    """Y of U Y = right for a unit upper triangular U."""
    rows: list[ca.SX] = []
    for j in reversed(range(triangular.shape[0])):
        known = ca.vertcat(*rows) if rows else ca.SX(0, right.shape[1])
        rows.insert(0, ca.sparsify(right[j, :] - ca.mtimes(triangular[j, j + 1 :], known)))
    return ca.vertcat(*rows) if rows else ca.SX(0, right.shape[1])


def outer_rates(
    inner: ca.SX, outer: ca.SX, driving: ca.SX, levers: Sequence[float] | None
) -> ca.SX:
    """y of (inner) x + (outer) y + driving = 0 by least squares, x eliminated first.

    With `levers`, what makes lengths of rates x, one row of a few x is made of minors: other
    weights, for equations that have a solution.
    """
    width = outer.shape[1]
    rows = _without_inner(inner, ca.horzcat(outer, driving), levers)
    return -factored(rows[:, :width], rows[:, width:]).solution()


def inner_rates(inner: ca.SX, outer: ca.SX, driving: ca.SX, found: ca.SX) -> ca.SX:
    """x of (inner) x + (outer) y + driving = 0 by least squares, with y `found`."""
    width = outer.shape[1]
    parts = factored(inner, ca.horzcat(outer, driving))
    moved = ca.mtimes(parts.coefficients[:, :width], found)
    return -back_substituted(parts.triangular, moved + parts.coefficients[:, width:])


def _without_inner(inner: ca.SX, rest: ca.SX, levers: Sequence[float] | None) -> ca.SX:
    """What is left of the rest's rows in parts that share no column of `inner`."""
    held: list[set[int]] = [set() for _ in range(inner.shape[0])]
    for row, column in zip(*inner.sparsity().get_triplet(), strict=True):
        held[row].add(column)
    found = [rest[[k for k, columns in enumerate(held) if not columns], :]]
    for part in components(held, inner.shape[1]):
        rows = [k for k, columns in enumerate(held) if columns & part]
        own, left = inner[rows, sorted(part)], rest[rows, :]
        if levers and len(rows) - len(part) == 1 and len(part) <= _LARGEST_MINOR:
            # rows of unlike weights lose digits: those of far sizes are as long as others
            weight = math.frexp(math.prod(levers[k] for k in part))[1]
            scale = 1.0 if abs(weight) <= _LIKE else 2.0**-weight
            found.append(ca.mtimes(scale * cofactors(own), left))
        elif len(rows) > len(part):
            remainder = factored(own, left).remainder
            found.append(remainder[nonzero_rows(remainder), :])
    return ca.vertcat(*found)


def shortest(matrix: ca.SX, right: ca.SX) -> ca.SX:
    """The shortest Y of M Y = right for a matrix (k, n) of independent rows: with M^T = V U, Y = V
    D^-1 U^-T right.
    """
    factors = factored(matrix.T, ca.SX(matrix.shape[1], 0))
    reversed_rows = list(reversed(range(matrix.shape[0])))
    lower = factors.triangular.T
    weights = back_substituted(lower[reversed_rows, reversed_rows], right[reversed_rows, :])[
        reversed_rows, :
    ]
    return ca.sparsify(
        ca.mtimes(
            factors.orthogonal,
            ca.mtimes(ca.diag(ca.vertcat(*(1 / d for d in factors.squares))), weights),
        )
    )


def without_span(rows: ca.SX, forbidden: ca.SX) -> ca.SX:
    """Rows (a, r) projected onto the orthogonal complement of independent rows (c, r)."""
    return factored(forbidden.T, rows.T).remainder.T


def cofactors(matrix: ca.SX) -> ca.SX:
    """(1, k + 1): y with y M = 0 for M of shape (k + 1, k), the signed minors; zero only where M
    loses rank.
    """
    count = matrix.shape[0]
    minors = []
    for k in range(count):
        others = [i for i in range(count) if i != k]
        minors.append((-1) ** k * ca.det(matrix[others, :]))
    return ca.sparsify(ca.horzcat(*minors))


def nonzero_rows(matrix: ca.SX) -> list[int]:
    """Rows that hold anything."""
    return sorted(set(ca.sparsify(matrix).sparsity().row()))


def _parts(column: ca.SX, others: ca.SX) -> tuple[ca.SX, ca.SX]:
    """v.w / v.v for each column w, and v.v; a column with a single entry divides by it alone."""
    if column.nnz() == 1:
        row, entry = column.sparsity().row()[0], column.nz[0]
        return ca.sparsify(others[row, :] / entry), entry * entry
    square = ca.sumsqr(column)
    return ca.sparsify(ca.mtimes(column.T, others) / square), square


def _without(others: ca.SX, column: ca.SX, parts: ca.SX) -> ca.SX:
    if column.nnz() == 1:
        kept = ca.SX(others)
        kept[column.sparsity().row()[0], :] = 0
        return ca.sparsify(kept)
    return ca.sparsify(others - ca.mtimes(column, parts))
