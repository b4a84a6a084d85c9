"""Take passive joints out of a limb's rows: what is left ties the platform's pose to the actuated
joints alone.

The rows of a limb hold a platform point w by the joints, w + f(q, x) = 0. A combination of them in
which no passive joint x stands is

    |w - A(q)|^2 = c(q)     the point lies on a sphere (or with a plane, on a circle) that the
                            actuated joints q move, or
    n(q) . w = c(q)         it lies in a plane.

A(q), n(q) and c(q) are polynomials of lengths, cosines and sines; their coefficients solve linear
equations: all terms with a passive joint vanish. So the structure is found in the rows, whatever
joints have made them. Lengths are compared in a unit that is a power of two, about the size, so
that no coefficient is nothing beside others because its machine is tiny or huge, and none is
rounded by the change.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure, random_points
from symkin.closure.pose_forms import PlatformPose, linear_parts, weighted_point
from symkin.closure.snapping import snap
from symkin.elimination.polynomial import Monomial, Polynomial, Ring
from symkin.elimination.product_rows import Normal, ProductRow, multipliers
from symkin.elimination.rows import NotPolynomialError, polynomial_rows
from symkin.elimination.sums import product
from symkin.elimination.workspace import Workspace
from symkin.model.joint import Coordinate
from symkin.numeric.rank import null_space
from symkin.numeric.system import System
from symkin.spatial.backend import stacked

_VANISHED = 1e-10
"""Share of the largest term below which a sum of terms is zero."""
_OF_VECTORS = ("point", "axis", "orientation", "frame")
"""Relations whose closure errors are gaps between points and between directions."""
_DRAWS = 3
"""Random values at which coefficients are compared."""
_MOST_TERMS = 48
"""Terms of a row at most: its square has as many products as pairs of them."""
_CANCELLED = 1e-13
"""Share of the largest coefficient below which one is what rounding leaves of others that
cancel.
"""


@dataclass(frozen=True, eq=False)
class PointRow:
    """|w - of|^2 = level where `is_sphere`, else of . w = level: `point` w by the pose, `of` and
    `level` by the actuated joints.
    """

    point: ca.SX
    of: ca.SX
    level: ca.SX
    is_sphere: bool

    @property
    def row(self) -> ca.SX:
        """What is zero."""
        if self.is_sphere:
            return ca.sumsqr(self.point - self.of) - self.level
        return ca.dot(self.of, self.point) - self.level

    def weighted(self, position: ca.SX, quaternion: ca.SX, pose: PlatformPose) -> ca.SX:
        """The row times the weight of a pose in another form, where w by the `position` p and the
        unit `quaternion` of R is A p + R a + b.
        """
        if not self.is_sphere:
            w = weighted_point(self.point, position, quaternion, pose)
            return ca.dot(self.of, w) - pose.weight * self.level
        moved, arm, still = linear_parts(self.point, position, quaternion)
        if not moved.is_zero():
            # w moves with the position itself, or against it
            sign = moved[0, 0]
            squared = pose.squared_distance(sign * arm, sign * (self.of - still))
            return squared - pose.weight * self.level
        gap = still - self.of
        rest = ca.sumsqr(gap) + ca.sumsqr(arm) - self.level
        return pose.weight * rest + 2 * ca.dot(gap, pose.direction(arm))


def pose_rows(system: System, poses: np.ndarray) -> list[PointRow] | None:
    """The rows of a limb without its passive joints, as many as the platform loses freedoms by it;
    None where none are found. Coefficients are compared at the sampled `poses` (n, known).
    """
    limb = _limb(system, poses)
    if limb is None:
        return None
    lacking = len(limb.rows) - len(limb.gone)
    planes = limb.planes()
    points = next(planes)[:lacking]
    if not points:
        # of several by terms of joints some may be multiples of each other
        more = next(planes)
        points = more[:lacking] if len(more) == 1 else []
    sphere = limb.sphere() if len(points) < lacking else None
    if sphere is not None:
        points.append(sphere)
    return points if len(points) == lacking else None


def implied_rows(
    closure: Closure, branch: str, gone: Collection[str]
) -> list[PointRow | ProductRow]:
    """What a branch of a closure says without the joints `gone`, which no other branch holds: of
    its vectors w + f = 0 the planes in which they lie together and the sphere of each; of each
    with the angle that a universal joint keeps their product (see `product_rows`).

    Joints whose terms multiply those of joints that go stand in f, all others in w. Rows that
    follow from each other, and rows that say nothing, are among them.
    """
    vectors = _vectors(closure, branch)
    every = stacked(vectors)
    depends = ca.which_depends(every, closure.variables, 1, False)
    moved = [
        k
        for k, c in enumerate(closure.coordinates)
        if c.name in gone and any(depends[closure.slices[c.name]])
    ]
    factors = _factors_beside(closure, every, moved) if moved else None
    if factors is None:
        return []
    limbs = [_limb(*_part(closure, v, [*moved, *factors])) for v in vectors]
    kept = [replace(limb, gone=frozenset(range(len(moved)))) for limb in limbs if limb is not None]
    if not kept:
        return []
    together = replace(
        kept[0],
        rows=tuple(row for limb in kept for row in limb.rows),
        point=ca.vertcat(*(limb.point for limb in kept)),
    )
    spheres = [limb.sphere() for limb in kept]
    products = [
        row
        for angle in _errors_of(closure, branch, "axes' angle")
        for limb in kept
        for row in _products_of(closure, limb, angle, [*moved, *factors])
    ]
    planes = [row for rows in together.planes() for row in rows]
    return [*planes, *(s for s in spheres if s is not None), *products]


def _products_of(
    closure: Closure, limb: _Limb, angle: ca.SX, joints: Sequence[int]
) -> list[ProductRow]:
    """The products of a limb's point with a direction that an angle holds."""
    system, _ = _part(closure, angle, joints)
    depends = np.array(ca.which_depends(angle, closure.variables, 1, False), dtype=bool)
    others = [c for k, c in enumerate(closure.coordinates) if k not in joints]
    held = [c for c in others if depends[closure.slices[c.name]].any()]
    if [c.kind for c in held] != ["quaternion"]:
        return []
    quaternion = closure.variables[closure.slices[held[0].name]]
    normal = Normal.of(replace(system, known=quaternion), limb.ring, quaternion)
    if normal is None:
        return []
    found = multipliers(limb.ring, limb.rows, limb.factors[-1], normal)
    return [
        ProductRow(
            limb.point,
            by,
            ca.vertcat(*(limb.expression(part, 1) for part in level)),
            quaternion,
            normal.turn,
            normal.still,
        )
        for by, level in found
    ]


def _errors_of(closure: Closure, branch: str, relation: str) -> list[ca.SX]:
    """The checks of a relation that a branch keeps, one by one."""
    errors = closure.bound(closure.errors)
    return [
        errors[k, 0]
        for k, source in enumerate(closure.error_sources)
        if source.limb == branch and source.relation == relation
    ]


def _vectors(closure: Closure, branch: str) -> list[ca.SX]:
    """Gaps between points and between directions that a branch closes, three numbers each."""
    found = list[ca.SX]()
    for relation in _OF_VECTORS:
        own = _errors_of(closure, branch, relation)
        found += [ca.vertcat(*own[k : k + 3]) for k in range(0, len(own), 3)]
    return found


def _factors_beside(closure: Closure, vectors: ca.SX, moved: Sequence[int]) -> list[int] | None:
    """Numbers of the joints whose terms multiply those of the joints `moved` in the vectors; None
    where the vectors are no polynomials of joints, or something else multiplies them.
    """
    system, samples = _part(closure, vectors, moved)
    ring = Ring(system.unknowns)
    try:
        rows = polynomial_rows(ring, system, system.rows, {})
    except NotPolynomialError:
        return None
    terms = [c for row in rows for m, c in row.terms.items() if m != ring.one]
    if not terms:
        return None
    slopes = ca.Function("slopes", [system.known], [ca.jacobian(ca.vertcat(*terms), system.known)])
    sizes = np.max([np.abs(np.asarray(slopes(sample))) for sample in samples], axis=(0, 1))
    others = [k for k in range(len(closure.coordinates)) if k not in moved]
    owner = np.repeat(others, [closure.coordinates[k].width for k in others])
    found = np.unique(owner[sizes > _VANISHED * np.max(sizes, initial=0.0)]).tolist()
    joints = [closure.coordinates[k] for k in found]
    scalar = all(c.kind in ("angle", "length") and c.body is None for c in joints)
    return found if scalar else None


def _part(closure: Closure, rows: ca.SX, unknown: Sequence[int]) -> tuple[System, np.ndarray]:
    """Rows in some of a closure's coordinates, by number, all others known; and samples (n, known)
    of these.
    """
    size = closure.characteristic_length
    values = random_points(closure.coordinates, size, _DRAWS)
    chosen = [closure.coordinates[k] for k in unknown]
    own, others = (
        [p for c in part for p in range(*closure.slices[c.name].indices(values.shape[1]))]
        for part in (chosen, [c for c in closure.coordinates if c not in chosen])
    )
    variables = closure.variables
    system = System(tuple(chosen), variables[own, 0], variables[others, 0], rows, rows, size)
    return system, values[:, others]


def plain(
    expressions: ca.SX, joints: ca.SX, coordinates: Sequence[Coordinate], size: float
) -> ca.SX:
    """The same expressions of joints as sums of products, where they are polynomials of lengths,
    cosines and sines of a mechanism of this size.
    """
    none, unit = ca.SX(0, 1), unit_of(size)
    system = System(tuple(coordinates), joints, none, expressions, expressions, size)
    ring = Ring(system.unknowns)
    try:
        rows = polynomial_rows(ring, system, expressions, {})
    except NotPolynomialError:
        return expressions
    return ca.vertcat(
        none, *(expression_of(ring, _in_units(ring, row, unit), joints, unit) for row in rows)
    )


def unit_of(size: float) -> float:
    """The power of two next to a size: lengths in this unit have the same digits."""
    return float(2.0 ** round(math.log2(size)))


def _slides(ring: Ring, monomial: Monomial) -> int:
    """How many lengths a term is the product of."""
    return sum(e for place, e in enumerate(monomial) if ring.generators[place][1] == "value")


def _in_units(ring: Ring, polynomial: Polynomial, unit: float, power: int = 0) -> Polynomial:
    """A polynomial of joints whose lengths are in `unit`, over that unit to a power."""
    return Polynomial(
        {m: c * ca.SX(unit ** (_slides(ring, m) - power)) for m, c in polynomial.terms.items()}
    )


def _limb(system: System, poses: np.ndarray) -> _Limb | None:
    """The limb's rows as polynomials, where their coefficients are constants but for the term
    without joints.
    """
    ring = Ring(system.unknowns)
    try:
        rows = polynomial_rows(ring, system, system.rows, {})
    except NotPolynomialError:
        return None
    work = Workspace(ring, rows, set(), [system.known], poses, system.characteristic_length)
    rows = work.all_tidied(rows)
    if any(not c.is_constant() for row in rows for m, c in row.terms.items() if m != ring.one):
        return None
    point = ca.vertcat(*(row[ring.one] for row in rows))
    unit = unit_of(system.characteristic_length)
    others = tuple(_in_units(ring, row.those(lambda m: m != ring.one), unit, 1) for row in rows)
    gone = frozenset(k for k, c in enumerate(system.unknowns) if c.role != "actuated")
    return _Limb(system, ring, others, point, gone)


@dataclass(frozen=True, eq=False)
class _Limb:
    """Rows point + rows(joints) = 0 with constant coefficients, those of `rows` in the size's unit;
    the joints with the numbers `gone` are taken out.
    """

    system: System
    ring: Ring
    rows: tuple[Polynomial, ...]
    point: ca.SX
    gone: frozenset[int]

    @property
    def unit(self) -> float:
        return unit_of(self.system.characteristic_length)

    def _is_free(self, monomial: Monomial) -> bool:
        """Whether no joint that goes stands in a term."""
        return not any(
            e and self.ring.generators[place][0] in self.gone for place, e in enumerate(monomial)
        )

    @property
    def factors(self) -> list[list[Monomial]]:
        """Terms that factors of rows may have: the number alone, then those in the rows of the
        joints that stay.
        """
        own = {
            tuple(e * (self.ring.generators[p][0] not in self.gone) for p, e in enumerate(m))
            for row in self.rows
            for m in row.terms
        }
        return [[self.ring.one], sorted({self.ring.one, *own}, reverse=True)]

    def _products(self, monomials: Sequence[Monomial]) -> list[Polynomial]:
        """Each row times each term."""
        return [
            self.ring.product(Polynomial({m: ca.SX(1)}), row)
            for row in self.rows
            for m in monomials
        ]

    def _bound(self, polynomials: Sequence[Polynomial]) -> np.ndarray:
        """Coefficients (terms, polynomials) of the terms with joints that go, the largest of each
        term 1.
        """
        terms = sorted({m for p in polynomials for m in p.terms if not self._is_free(m)})
        if not terms:
            return np.zeros((0, len(polynomials)))
        matrix = np.array([[float(p[m]) for p in polynomials] for m in terms]).reshape(
            len(terms), len(polynomials)
        )
        sizes = np.max(np.abs(matrix), axis=1, initial=0.0)
        kept = sizes > _CANCELLED * np.max(sizes, initial=0.0)
        return matrix[kept] / sizes[kept, None]

    def planes(self) -> Iterator[list[PointRow]]:
        """Planes in which the point lies, for each of the `factors`; of those of joints some may be
        multiples of each other.
        """
        for monomials in self.factors:
            polynomials = self._products(monomials)
            null = _reduced_null_space(self._bound(polynomials))
            yield [self._plane(factors, monomials, polynomials) for factors in null]

    def _plane(
        self, factors: np.ndarray, monomials: Sequence[Monomial], polynomials: Sequence[Polynomial]
    ) -> PointRow:
        level = _sum(zip(factors, polynomials, strict=True)).times(-1.0)
        return PointRow(
            self.point,
            self._vector(factors, monomials, 0),
            self.expression(self._free(level), 1),
            is_sphere=False,
        )

    def sphere(self) -> PointRow | None:
        """The sphere on which the point lies."""
        squares = _sum((1.0, self.ring.product(row, row)) for row in self.rows)
        for monomials in self.factors:
            polynomials = [squares, *(p.times(2.0) for p in self._products(monomials))]
            matrix = self._bound(polynomials)
            if not len(matrix):
                continue
            factors = np.linalg.lstsq(matrix[:, 1:], -matrix[:, 0], rcond=_VANISHED)[0]
            left = matrix[:, 1:] @ factors + matrix[:, 0]
            if np.max(np.abs(left)) <= _VANISHED * max(1.0, float(np.max(np.abs(factors)))):
                return self._sphere(
                    np.array([_tidy(v, factors) for v in factors]), monomials, polynomials
                )
        return None

    def _sphere(
        self, factors: np.ndarray, monomials: Sequence[Monomial], polynomials: Sequence[Polynomial]
    ) -> PointRow:
        # |w - A|^2 = |f + A|^2 = |f|^2 + 2 A f + |A|^2
        level = self._free(_sum(zip((1.0, *factors), polynomials, strict=True)))
        for part in self._parts(factors, monomials):
            level = level.plus(self.ring.product(part, part))
        return PointRow(
            self.point,
            self._vector(factors, monomials, 1),
            self.expression(level, 2),
            is_sphere=True,
        )

    def _free(self, polynomial: Polynomial) -> Polynomial:
        return polynomial.those(self._is_free)

    def _vector(self, factors: np.ndarray, monomials: Sequence[Monomial], power: int) -> ca.SX:
        """One expression of the actuated joints for each row, of a power of lengths."""
        parts = self._parts(factors, monomials)
        return ca.vertcat(*(self.expression(part, power) for part in parts))

    def _parts(self, factors: np.ndarray, monomials: Sequence[Monomial]) -> list[Polynomial]:
        """One polynomial for each row, of its own factors."""
        each = factors.reshape(len(self.rows), -1).tolist()
        return [
            Polynomial({m: ca.SX(v) for m, v in zip(monomials, own, strict=True)}) for own in each
        ]

    def expression(self, polynomial: Polynomial, power: int) -> ca.SX:
        return expression_of(self.ring, polynomial, self.system.unknown, self.unit, power)


def expression_of(
    ring: Ring, polynomial: Polynomial, joints: ca.SX, unit: float, power: int = 0
) -> ca.SX:
    """A polynomial of the joints with constant coefficients, in `unit`, as an expression of a power
    of lengths, without terms that are rounding.
    """
    numbers = {m: float(c) for m, c in polynomial.terms.items()}
    largest, found = max((abs(v) for v in numbers.values()), default=0.0), ca.SX(0)
    for m, v in numbers.items():
        if abs(v) > _VANISHED * largest:
            number = snap(v * unit ** (power - _slides(ring, m)))
            found = found + number * product(
                _generator(ring, place, joints) for place, e in enumerate(m) for _ in range(e)
            )
    return found


def _generator(ring: Ring, place: int, joints: ca.SX) -> ca.SX:
    number, part = ring.generators[place]
    z = joints[number]
    return z if part == "value" else ca.cos(z) if part == "cosine" else ca.sin(z)


def _sum(parts: Iterable[tuple[float, Polynomial]]) -> Polynomial:
    whole = Polynomial({})
    for factor, polynomial in parts:
        whole = whole.plus(polynomial, ca.SX(float(factor)))
    return whole


def _tidy(value: float, beside: np.ndarray) -> float:
    """A factor, nothing where it is rounding of others."""
    return float(value) if abs(value) > _VANISHED * np.max(np.abs(beside)) else 0.0


def _reduced_null_space(matrix: np.ndarray) -> np.ndarray:
    """Unit vectors (k, columns) that a matrix makes zero, in a form of its own: reduced, so that
    plain factors stay plain.
    """
    null = null_space(matrix, _VANISHED, relative=True)
    # reduced row by row: ones and zeros where the vectors allow them; of entries that are equal but
    # for rounding, the first
    for i in range(len(null)):
        place = int(np.argmax(np.abs(null[i]) >= (1.0 - _VANISHED) * np.max(np.abs(null[i]))))
        null[i] /= null[i, place]
        for other in range(len(null)):
            if other != i:
                null[other] -= null[other, place] * null[i]
    null = np.array(
        [[snap(float(v)) if abs(v) >= _VANISHED else 0.0 for v in row] for row in null]
    ).reshape(null.shape)
    return null / np.linalg.norm(null, axis=1, keepdims=True)
