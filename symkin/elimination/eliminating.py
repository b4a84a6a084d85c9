"""Take unknowns out of rows: each step leaves fewer unknowns in the rest and defers those that it
took out.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import casadi as ca
import numpy as np

from symkin.closure.snapping import snap
from symkin.elimination.polynomial import Polynomial
from symkin.elimination.solving import independent_pair
from symkin.elimination.sums import constant_basis, cross, determinant, product, total
from symkin.elimination.workspace import ROUNDING, Deferred, Workspace
from symkin.numeric.rank import null_space
from symkin.spatial.screw import tidy_rows

_MOST_LENGTHS = 2
"""Lengths that are taken out together."""


def defer_defined(work: Workspace) -> bool:
    """A length that stands in one row only, linear and with a known coefficient: that row gives
    it.
    """
    for unknown in _lengths(work):
        rows = _rows_with(work, unknown)
        if len(rows) != 1 or work.ring.degree_in(rows[0], unknown) != 1:
            continue
        coefficient, _ = work.ring.linear_in(rows[0], unknown)
        if work.ring.scalar(coefficient) is not None:
            _defer(work, (unknown,), rows, [])
            work.steps.append(f"{work.name(unknown)} is given by one row once the rest is known")
            return True
    return False


def combine_lengths(work: Workspace) -> bool:
    """Lengths that stand linear, with known coefficients, in one row more than they are: a
    combination of the rows is free of them.
    """
    for count in range(1, _MOST_LENGTHS + 1):
        for unknowns in combinations(_lengths(work), count):
            rows = [row for row in work.rows if work.ring.held(row) & set(unknowns)]
            linear = [row for row in rows if _is_linear_in(work, row, unknowns)]
            if len(linear) != count + 1 or (count == 1 and len(rows) > len(linear)):
                continue
            matrix = [[_coefficient(work, row, k) for k in unknowns] for row in linear]
            factors = [
                (-1) ** i * determinant(matrix[:i] + matrix[i + 1 :]) for i in range(count + 1)
            ]
            factors = [work.define(f, "n") for f in factors]
            if count > 1 and not _independent(work, matrix):
                continue
            rest = Polynomial({})
            for factor, row in zip(factors, linear, strict=True):
                rest = rest.plus(row, factor)
            _defer(work, unknowns, linear, [work.ring.free_of(rest, unknowns)])
            work.steps.append(
                f"{work.names(unknowns)} taken out of {count + 1} rows that are linear in them, by "
                f"a combination"
            )
            return True
    return False


def leave_alone(work: Workspace) -> bool:
    """An unknown that a constant combination of the rows leaves alone: of turns that close, M = 1,
    a . M b holds only the angle between the axes a and b. Nothing is divided by, and no row goes.
    """
    monomials, table = work.table()
    if not table.size:
        return False
    largest = np.max(np.abs(table), axis=(0, 1))
    for unknown in sorted(work.active):
        if any(work.ring.held(row) == {unknown} for row in work.rows):
            continue
        others = [k for k, m in enumerate(monomials) if work.ring.held_by(m) - {unknown}]
        foreign = (table[:, others] / largest).reshape(-1, len(work.rows))
        factors = tidy_rows(null_space(foreign, ROUNDING, relative=True)) / largest
        combined = map(work.combined, factors.tolist())
        found = [row for row in combined if work.ring.held(row) == {unknown}]
        if found:
            work.rows = [*found, *work.rows]
            work.steps.append(f"{work.name(unknown)} left alone by a combination of the rows")
            return True
    return False


def _independent(work: Workspace, matrix: list[list[ca.SX]]) -> bool:
    """Whether at each sample some two of three rows with two coefficients each are independent."""
    parallel = [work.agree(u[0] * v[1], u[1] * v[0]) for u, v in combinations(matrix, 2)]
    return not np.all(parallel, axis=0).any()


def turn_angle(work: Workspace) -> bool:
    """An angle that stands linear in rows: in a basis of the rows in which two of them hold it and
    the others do not, these two are

        M (cos t, sin t) + r = 0

    with known M, so that |M^-1 r|^2 = 1; or with M M^T = m times the identity, a vector that the
    angle turns, so that |r|^2 = m.
    """
    for unknown in sorted(work.active):
        rows = _rows_with(work, unknown)
        if not work.ring.unknowns[unknown].is_angular or len(rows) < 2:
            continue
        if any(work.ring.degree_in(row, unknown) != 1 for row in rows):
            continue
        if _by_known_matrix(work, unknown, rows) or _by_length(work, unknown, rows):
            return True
    return False


def _by_known_matrix(work: Workspace, unknown: int, rows: list[Polynomial]) -> bool:
    """d cos t and d sin t from two rows of determinant d; their squares, which add to d^2, and the
    other rows are free of the angle. Nothing is divided by what is known, so that the rest is as
    smooth in the known values as the rows: who solves for the angle divides by d.
    """
    ring = work.ring
    pair = independent_pair(work, rows, unknown)
    if pair is None:
        return False
    (a1, b1, r1), (a2, b2, r2) = (_knowns(work, row, unknown) for row in pair)
    whole = work.define(a1 * b2 - a2 * b1, "d")
    unit = _usual_size(work, whole)
    whole = whole / unit
    cosine = r2.times(b1 / unit).plus(r1.times(b2 / unit), -1.0)
    sine = r1.times(a2 / unit).plus(r2.times(a1 / unit), -1.0)
    squares = ring.product(cosine, cosine).plus(ring.product(sine, sine))
    rest = [squares.plus(ring.constant(whole * whole), -1.0)]
    for row in rows:
        if row not in pair:
            a, b, r = ring.linear_in(row, unknown)
            rest.append(ring.product(a, cosine).plus(ring.product(b, sine)).plus(r, whole))
    _defer(work, (unknown,), list(pair), rest, rows)
    work.steps.append(
        f"{work.name(unknown)} taken out: cosine and sine are linear in the others, and their "
        f"squares add to 1"
    )
    return True


def _usual_size(work: Workspace, expression: ca.SX) -> float:
    """A constant itself; of another expression a power of two near its size, in which products
    stay within floats whatever the unit of length.
    """
    if expression.is_constant():
        return float(expression)
    usual = float(np.median(np.abs(work.numbers([expression]))))
    return float(2.0 ** np.round(np.log2(usual))) if usual > 0.0 else 1.0


def _by_length(work: Workspace, unknown: int, rows: list[Polynomial]) -> bool:
    """Two rows are a vector that the angle turns: the vector's length is free of it."""
    ring = work.ring
    turned = _turned_basis(work, unknown, rows)
    if turned is None:
        return False
    two, free = turned
    (a1, b1, r1), (a2, b2, r2) = (ring.linear_in(row, unknown) for row in two)
    square = work.tidied(ring.product(a1, a1).plus(ring.product(b1, b1)))
    other = ring.product(a2, a2).plus(ring.product(b2, b2))
    across = ring.product(a1, a2).plus(ring.product(b1, b2))
    if any(work.tidied(rest).terms for rest in (other.plus(square, -1.0), across)):
        return False
    length = _one_way(work, unknown, two) or [
        ring.product(r1, r1).plus(ring.product(r2, r2)).plus(square, -1.0)
    ]
    _defer(work, (unknown,), two, [*length, *free], rows)
    work.steps.append(
        f"{work.name(unknown)} taken out: it turns a vector, whose length is free of it"
    )
    return True


def _one_way(work: Workspace, unknown: int, two: list[Polynomial]) -> list[Polynomial]:
    """Where the vector that the angle turns to a known one has a constant direction in the rows,
    its length along it is a polynomial u of others: u = +- |r|, as one row. Empty where it is not
    so, or where u is an unknown alone, whose square is plainer.
    """
    ring = work.ring
    (a1, b1, r1), (a2, b2, r2) = (ring.linear_in(row, unknown) for row in two)
    known = [ring.scalar(r) for r in (r1, r2)]
    if any(v is None for v in known) or len(ring.held(a1) | ring.held(b1)) < 2:
        return []
    monomials = sorted({*a1.terms, *b1.terms, *a2.terms, *b2.terms})
    vectors = np.concatenate(
        [work.numbers([part[m] for part in (a1, b1, a2, b2)]) for m in monomials]
    )
    basis = constant_basis(vectors)
    if len(basis) != 1:
        return []
    # u(others) by the largest of its four parts, which are constant multiples of it
    place = int(np.argmax(np.abs(basis[0])))
    part, share = (a1, b1, a2, b2)[place], float(basis[0][place])
    u = part.times(snap(float(np.sqrt(0.5)) / share))
    square = ca.SX(known[0]) ** 2 + ca.SX(known[1]) ** 2
    told = total(
        c * product(work.own[place] for place, e in enumerate(m) for _ in range(e))
        for m, c in u.terms.items()
    )
    root = work.choose(f"{work.name(unknown)}_side", square, told)
    return [u.plus(ring.constant(root), -1.0)]


def _turned_basis(
    work: Workspace, unknown: int, rows: list[Polynomial]
) -> tuple[list[Polynomial], list[Polynomial]] | None:
    """Combinations of the rows with constant factors: two that hold an angle, and those that do
    not. None where more hold it.
    """
    if len(rows) == 2:
        return rows, []
    vectors = _coefficient_vectors(work, unknown, rows)
    if len(constant_basis(vectors)) != 2:
        return None
    basis = constant_basis(np.concatenate([vectors, np.eye(len(rows))]))
    combined = [_combination(work, rows, factors) for factors in basis]
    return combined[:2], [work.ring.free_of(row, [unknown]) for row in combined[2:]]


def _coefficient_vectors(work: Workspace, unknown: int, rows: list[Polynomial]) -> np.ndarray:
    """Vectors (any, rows) of the coefficients that monomials with an angle have in rows, at all
    samples.
    """
    own = work.ring.places[unknown]
    monomials = sorted({m for row in rows for m in row.terms if any(m[place] for place in own)})
    columns = [work.numbers([row[m] for m in monomials]) for row in rows]
    return np.stack(columns, axis=-1).reshape(-1, len(rows))


def _combination(work: Workspace, rows: list[Polynomial], factors: np.ndarray) -> Polynomial:
    total = Polynomial({})
    for row, factor in zip(rows, factors, strict=True):
        number = snap(float(factor))
        if number:
            total = total.plus(row, number)
    return work.tidied(total)


def subtract_quadratics(work: Workspace) -> bool:
    """Rows of one and the same quadratic part, such as spheres: the differences from the first are
    linear.
    """
    for i, first in enumerate(work.rows):
        quadratic = sorted(m for m in first.terms if sum(m) >= 2)
        alike = [
            j
            for j, row in enumerate(work.rows)
            if j > i
            and quadratic
            and sorted(m for m in row.terms if sum(m) >= 2) == quadratic
            and work.is_parallel(
                [row.terms[m] for m in quadratic], [first.terms[m] for m in quadratic]
            )
        ]
        if not alike:
            continue
        for j in alike:
            row = work.rows[j]
            factor = work.define(row.terms[quadratic[0]] / first.terms[quadratic[0]], "f")
            left = row.plus(first, -factor)
            work.rows[j] = work.tidied(left.those(lambda m: sum(m) < 2))
        work.steps.append(
            f"{len(alike) + 1} rows have one quadratic part: their differences are linear"
        )
        return True
    return False


def cut_by_line(work: Workspace) -> bool:
    """Lengths x in as many linear rows as they are less one, and in one quadratic row: they lie on
    the line x = p + t d, which the quadratic row cuts at two values of t.
    """
    for count in (2, 3):
        for unknowns in combinations(_lengths(work), count):
            rows = [row for row in work.rows if work.ring.held(row) <= set(unknowns)]
            linear = [row for row in rows if row.degree == 1][: count - 1]
            curved = next((row for row in rows if row.degree == 2), None)
            if len(linear) == count - 1 and curved is not None:
                _cut(work, unknowns, *_line(work, unknowns, linear), curved)
                return True
    return False


def _line(
    work: Workspace, unknowns: tuple[int, ...], rows: list[Polynomial]
) -> tuple[list[ca.SX], list[ca.SX], ca.SX]:
    """The line of one linear row a x = e in two lengths, or of two in three: its point next to the
    origin, its direction d, d.d.
    """
    normals = [[work.define(_coefficient(work, row, k), "n") for k in unknowns] for row in rows]
    offsets = [work.define(-row[work.ring.one], "e") for row in rows]
    if len(unknowns) == 2:
        (a, b), (e,) = normals[0], offsets
        direction, feet = [-b, a], [a * e, b * e]
    else:
        u, v = normals
        direction = [work.define(part, "d") for part in cross(u, v)]
        feet = [
            offsets[0] * p + offsets[1] * q
            for p, q in zip(cross(v, direction), cross(direction, u), strict=True)
        ]
    square = work.divisor(total(d * d for d in direction), "dd")
    return [work.define(foot / square, "p") for foot in feet], direction, square


def _cut(
    work: Workspace,
    unknowns: tuple[int, ...],
    point: list[ca.SX],
    direction: list[ca.SX],
    square: ca.SX,
    curved: Polynomial,
) -> None:
    """Solve for t, and so for the lengths."""
    places = [work.ring.places[k][0] for k in unknowns]
    sphere = _as_sphere(work, places, curved)
    curved = curved if sphere is None else sphere
    # the quadratic row on the line: lead t^2 + 2 half t + rest
    lead, half, rest = ca.SX(0), ca.SX(0), ca.SX(0)
    # half its derivative along the line, which is lead t + half, at a solution
    slope, own = ca.SX(0), [work.own[place] for place in places]
    for monomial, c in curved.terms.items():
        on = [i for i, place in enumerate(places) for _ in range(monomial[place])]
        p, d = [point[i] for i in on], [direction[i] for i in on]
        rest = rest + c * product(p)
        if len(on) == 1:
            half = half + 0.5 * c * d[0]
            slope = slope + 0.5 * c * d[0]
        elif len(on) == 2:
            lead = lead + c * d[0] * d[1]
            if sphere is None:  # else the point, next to the origin, is across the line
                half = half + 0.5 * c * (d[0] * p[1] + d[1] * p[0])
            slope = slope + 0.5 * c * (d[0] * own[on[1]] + d[1] * own[on[0]])
    multiple = work.multiple(lead, square)
    lead = work.divisor(lead, "a") if multiple is None else multiple * square
    half = work.define(half / lead, "h")
    names = work.names(unknowns)
    work.steps.append(
        f"{names} on the line of the linear rows, cut by the quadratic one: two values"
    )
    root = work.choose(names.replace(", ", "_"), half * half - rest / lead, slope / lead)
    part = work.define(root - half, "t")
    for unknown, p, d in zip(unknowns, point, direction, strict=True):
        work.solve(unknown, [p + part * d])


def _as_sphere(work: Workspace, places: Sequence[int], curved: Polynomial) -> Polynomial | None:
    """A row whose quadratic part is a multiple of the sum of the lengths' squares, over that where
    it is constant; None where it is no multiple.
    """
    squares = [work.ring.power(place, place) for place in places]
    factors = [curved[m] for m in squares]
    if {m for m in curved.terms if sum(m) == 2} != set(squares):
        return None
    if not work.is_parallel(factors, [ca.SX(1)] * len(factors)):
        return None
    factor = work.multiple(factors[0], ca.SX(1))
    return curved if factor is None else curved.times(1.0 / factor)


# --- parts ----------------------------------------------------------------------------------------


def _lengths(work: Workspace) -> list[int]:
    return [k for k in sorted(work.active) if not work.ring.unknowns[k].is_angular]


def _rows_with(work: Workspace, unknown: int) -> list[Polynomial]:
    return [row for row in work.rows if unknown in work.ring.held(row)]


def _is_linear_in(work: Workspace, row: Polynomial, unknowns: Sequence[int]) -> bool:
    """Whether some lengths stand in a row each by itself, to the first power and with a known
    coefficient.
    """
    parts = work.ring.split(row, unknowns)
    return all(
        sum(m) <= 1 and (sum(m) == 0 or work.ring.scalar(part) is not None)
        for m, part in parts.items()
    )


def _coefficient(work: Workspace, row: Polynomial, unknown: int) -> ca.SX:
    return row[work.ring.power(work.ring.places[unknown][0])]


def _knowns(work: Workspace, row: Polynomial, unknown: int) -> tuple[ca.SX, ca.SX, Polynomial]:
    a, b, rest = work.ring.linear_in(row, unknown)
    return ca.SX(work.ring.scalar(a)), ca.SX(work.ring.scalar(b)), rest


def _defer(
    work: Workspace,
    unknowns: tuple[int, ...],
    givers: list[Polynomial],
    rest: list[Polynomial],
    taken: list[Polynomial] | None = None,
) -> None:
    """Put rows that give unknowns aside, and rows without them in their place."""
    gone = {id(row) for row in (givers if taken is None else taken)}
    left = [row for row in work.rows if id(row) not in gone]
    work.rows = [row for row in (*left, *work.all_tidied(rest)) if work.ring.held(row)]
    work.deferred.append(Deferred(unknowns, tuple(givers)))
    work.active -= set(unknowns)
