"""Solve rows that have one unknown, and unknowns that have been deferred: the formulas of lengths
and angles.

a x + b = 0                       x = -b / a
x^2 + 2 h x + e = 0               x = -h +- sqrt(h^2 - e)
A cos t + B sin t + C = 0         (cos t, sin t) = (-A C -+ B r, -B C +- A r) / N,
                                  N = A^2 + B^2,  r = sqrt(N - C^2)
two such rows                     cos t and sin t by Cramer's rule
more of them                      by normal equations, where all rows are to take part
"""

from __future__ import annotations

from itertools import combinations

import casadi as ca

from symkin.elimination.polynomial import Polynomial
from symkin.elimination.sums import determinant, total
from symkin.elimination.workspace import Deferred, Workspace


def solve_deferred(work: Workspace) -> bool:
    """Solve what has been deferred and hangs on solved unknowns only."""
    for entry in work.deferred:
        rows = work.known_put_in(entry.rows)
        if set().union(*map(work.ring.held, rows)) <= set(entry.unknowns):
            work.deferred.remove(entry)
            return _from_rows(work, entry, rows)
    return False


def solve_single(work: Workspace) -> bool:
    """Solve an unknown that stands alone in a row, one with a single value before one with two."""
    alone: dict[int, list[Polynomial]] = {}
    for row in work.rows:
        held = work.ring.held(row)
        if len(held) == 1:
            alone.setdefault(next(iter(held)), []).append(row)
    ways = (_linear_angle, _linear_length, _harmonic_angle, _quadratic_length)
    return any(way(work, unknown, rows) for way in ways for unknown, rows in alone.items())


def _linear_length(work: Workspace, unknown: int, rows: list[Polynomial]) -> bool:
    if work.ring.unknowns[unknown].is_angular:
        return False
    row = next((r for r in rows if work.ring.degree_in(r, unknown) == 1), None)
    if row is None:
        return False
    a, b = _scalars(work, row, unknown)
    work.steps.append(f"{work.name(unknown)} stands alone and linear in a row")
    work.solve(unknown, [-b / work.divisor(a, "a")])
    return True


def _quadratic_length(work: Workspace, unknown: int, rows: list[Polynomial]) -> bool:
    ring = work.ring
    row = next((r for r in rows if ring.degree_in(r, unknown) == 2), None)
    if ring.unknowns[unknown].is_angular or row is None:
        return False
    (place,) = ring.places[unknown]
    a, b, c = (row[m] for m in (ring.power(place, place), ring.power(place), ring.one))
    lead = work.divisor(a, "a")
    half = work.define(b / (2 * lead), "h")
    work.steps.append(f"{work.name(unknown)} stands alone and squared in a row: two values")
    root = work.choose(work.name(unknown), half * half - c / lead, work.own[place] + half)
    work.solve(unknown, [root - half])
    return True


def _linear_angle(work: Workspace, unknown: int, rows: list[Polynomial]) -> bool:
    if not work.ring.unknowns[unknown].is_angular:
        return False
    linear = [r for r in rows if work.ring.degree_in(r, unknown) == 1]
    pair = independent_pair(work, linear, unknown)
    if pair is None:
        return False
    if work.all_rows and len(linear) > 2:
        work.steps.append(
            f"{work.name(unknown)} by its cosine and sine, linear in {len(linear)} rows"
        )
        _least_squares(work, unknown, linear)
        return True
    work.steps.append(f"{work.name(unknown)} by its cosine and sine, linear in two rows")
    _cramer(work, unknown, pair)
    return True


def _harmonic_angle(work: Workspace, unknown: int, rows: list[Polynomial]) -> bool:
    row = next((r for r in rows if work.ring.degree_in(r, unknown) == 1), None)
    if not work.ring.unknowns[unknown].is_angular or row is None:
        return False
    a, b, c = (work.define(v, n) for v, n in zip(_scalars(work, row, unknown), "ABC", strict=True))
    square = work.divisor(a * a + b * b, "N")
    if work.agree(square, c * c).all():
        work.steps.append(
            f"{work.name(unknown)} stands alone in A cos + B sin + C = 0 with A^2 + B^2 = C^2: one "
            f"value"
        )
        work.solve(unknown, [-a * c / square, -b * c / square])
        return True
    cosine, sine = (work.own[place] for place in work.ring.places[unknown])
    work.steps.append(f"{work.name(unknown)} stands alone in A cos + B sin + C = 0: two values")
    root = work.choose(work.name(unknown), square - c * c, a * sine - b * cosine)
    work.implied.append(square)
    work.squares.append(square)
    work.solve(unknown, [-(a * c + b * root) / square, (a * root - b * c) / square])
    return True


# --- deferred unknowns ----------------------------------------------------------------------------


def _from_rows(work: Workspace, entry: Deferred, rows: list[Polynomial]) -> bool:
    """Solve linear rows for a deferred angle, or for lengths: rows that are more than the lengths
    agree with each other. False where they do not decide the angle.
    """
    unknowns, ring = entry.unknowns, work.ring
    work.steps.append(f"{work.names(unknowns)} from the rows out of which taken")
    if ring.unknowns[unknowns[0]].is_angular:
        pair = independent_pair(work, rows, unknowns[0])
        if pair is not None:
            _cramer(work, unknowns[0], pair)
        return pair is not None
    count = len(unknowns)
    matrix = [[row[ring.power(ring.places[k][0])] for k in unknowns] for row in rows]
    right = [-row[ring.one] for row in rows]
    if len(rows) > count:
        # normal equations
        matrix, right = (
            [[total(r[i] * r[j] for r in matrix) for j in range(count)] for i in range(count)],
            [total(r[i] * b for r, b in zip(matrix, right, strict=True)) for i in range(count)],
        )
    matrix = [[work.define(v, "m") for v in line] for line in matrix]
    whole = work.divisor(determinant(matrix), "det")
    for j, unknown in enumerate(unknowns):
        replaced = [
            [right[i] if k == j else v for k, v in enumerate(line)] for i, line in enumerate(matrix)
        ]
        work.solve(unknown, [determinant(replaced) / whole])
    return True


def _cramer(work: Workspace, unknown: int, pair: tuple[Polynomial, Polynomial]) -> None:
    (a1, b1, c1), (a2, b2, c2) = (_scalars(work, row, unknown) for row in pair)
    whole = work.divisor(a1 * b2 - a2 * b1, "d")
    across = work.agree(a1 * a2, -b1 * b2) & work.agree(a1 * a1 + b1 * b1, a2 * a2 + b2 * b2)
    if across.all():
        # (a2, b2) is (a1, b1) turned by a quarter
        work.squares.append(whole)
    work.solve(unknown, [(b1 * c2 - b2 * c1) / whole, (a2 * c1 - a1 * c2) / whole])


def _least_squares(work: Workspace, unknown: int, rows: list[Polynomial]) -> None:
    """Cosine and sine from rows that agree with each other: no two of them need decide."""
    triples = [_scalars(work, row, unknown) for row in rows]
    aa, bb, ab, ac, bc = (
        work.define(total(t[i] * t[j] for t in triples), "m")
        for i, j in ((0, 0), (1, 1), (0, 1), (0, 2), (1, 2))
    )
    whole = work.divisor(aa * bb - ab * ab, "det")
    work.solve(unknown, [(ab * bc - bb * ac) / whole, (ab * ac - aa * bc) / whole])


def independent_pair(
    work: Workspace, rows: list[Polynomial], unknown: int
) -> tuple[Polynomial, Polynomial] | None:
    """Two rows, linear in an angle with known coefficients, that decide its cosine and sine."""
    known = []
    for row in rows:
        a, b, _ = work.ring.linear_in(row, unknown)
        parts = [work.ring.scalar(part) for part in (a, b)]
        known += [] if any(v is None for v in parts) else [(row, *map(ca.SX, parts))]
    for (first, a1, b1), (second, a2, b2) in combinations(known, 2):
        if not work.agree(a1 * b2, b1 * a2).any():
            return first, second
    return None


def _scalars(work: Workspace, row: Polynomial, unknown: int) -> list[ca.SX]:
    """Coefficients of an unknown's generators and the rest, of a row that has nothing else."""
    return [ca.SX(work.ring.scalar(part)) for part in work.ring.linear_in(row, unknown)]
