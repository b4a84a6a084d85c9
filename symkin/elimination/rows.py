"""Write closure rows as polynomials in their unknowns, by a walk over their graph.

An angle is known to rows by cosines and sines of sums of angles, which the addition theorems
expand. Half angles, by which rotations are turned, must stand in even powers: cos^2(a/2) = (1 + cos
a) / 2, and so on. Where axes are parallel, rows hold sums of angles: then the sums are the
unknowns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca

from symkin.closure.angle_sums import AngleSum, combined
from symkin.closure.expression_graph import walk
from symkin.elimination.angle_sums import Sums
from symkin.elimination.polynomial import Monomial, Polynomial, Ring, add_term, times
from symkin.numeric.system import System


class NotPolynomialError(Exception):
    """Rows hold an unknown in another way than by polynomials in lengths, cosines and sines."""


_Value = Polynomial | AngleSum


def polynomial_rows(ring: Ring, system: System, rows: ca.SX, sums: Sums) -> list[Polynomial]:
    """Each row as a polynomial. The generators of an angle that stands in one of the `sums` are
    those of the sum up to it. Raises NotPolynomialError where a row is no polynomial.
    """
    if any(c.kind not in ("length", "angle") for c in system.unknowns):
        raise NotPolynomialError
    unknown = ca.SX(system.unknown)
    for k, (before, sign) in sums.items():
        unknown[k] = sign * (system.unknown[k] - system.unknown[before])
    put_in = ca.substitute(ca.densify(rows), system.unknown, unknown)
    function = ca.Function("rows", [system.unknown, system.known], [put_in], {"cse": True})
    halves = _halved(function, ring)
    reader = _Reader(ring, system, halves)
    walk(function, reader)
    whole = (_whole(ring, reader.found[k], halves) for k in range(rows.shape[0]))
    return [Polynomial({m: ca.SX(c) for m, c in row.terms.items()}) for row in whole]


@dataclass
class _Factors:
    """Evaluator that finds by which factor each angle stands under sines and cosines: its sums of
    angles, and None for the rest.
    """

    ring: Ring
    found: dict[int, set[float]] = field(default_factory=dict)

    def input(self, number: int, nonzero: int) -> AngleSum | float | None:
        if number == 0 and self.ring.unknowns[nonzero].is_angular:
            return AngleSum.of(nonzero)
        return None

    def constant(self, number: float) -> AngleSum | float | None:
        return number

    def operation(
        self, op: int, operands: list[AngleSum | float | None]
    ) -> AngleSum | float | None:
        angles = [v for v in operands if isinstance(v, AngleSum)]
        if not angles:
            return None
        if op in (ca.OP_SIN, ca.OP_COS):
            for unknown, factor in angles[0].factors.items():
                self.found.setdefault(unknown, set()).add(abs(factor))
            return None
        # what is known beside angles matters only where it is a constant factor
        return _combined(op, [AngleSum({}, ca.SX(0)) if v is None else v for v in operands])

    def output(self, number: int, nonzero: int, value: object) -> None:
        """Nothing is kept."""


def _halved(function: ca.Function, ring: Ring) -> set[int]:
    """The unknowns that stand as half angles."""
    factors = _Factors(ring)
    walk(function, factors)
    if any(not found <= {1.0, 0.5} for found in factors.found.values()):
        raise NotPolynomialError
    return {unknown for unknown, found in factors.found.items() if 0.5 in found}


def _combined(op: int, operands: Sequence[AngleSum | float]) -> AngleSum:
    """The sum of angles that an operation makes of others. Raises NotPolynomialError where it makes
    something else.
    """
    found = combined(op, operands)
    if found is None:
        raise NotPolynomialError
    return found


@dataclass
class _Reader:
    """Evaluator that makes polynomials, whose constant coefficients are floats meanwhile; the
    generators of an angle in `halves` are those of half of it.
    """

    ring: Ring
    system: System
    halves: set[int]
    found: dict[int, Polynomial] = field(default_factory=dict)

    def input(self, number: int, nonzero: int) -> _Value:
        if number == 1:
            return self.ring.constant(self.system.known[nonzero])
        if self.ring.unknowns[nonzero].is_angular:
            return AngleSum.of(nonzero)
        return self._generator(self.ring.places[nonzero][0])

    def constant(self, number: float) -> _Value:
        return self._constant(number)

    def _constant(self, value: float | ca.SX) -> Polynomial:
        known = ca.SX(value)
        return Polynomial({self.ring.one: float(known) if known.is_constant() else known})

    def _generator(self, place: int) -> Polynomial:
        return Polynomial({self.ring.power(place): 1.0})

    def output(self, number: int, nonzero: int, value: _Value) -> None:
        if number == 0:
            if isinstance(value, AngleSum):
                raise NotPolynomialError
            self.found[nonzero] = value

    def operation(self, op: int, operands: list[_Value]) -> _Value:
        if any(isinstance(v, AngleSum) for v in operands):
            return self._of_angles(op, operands)
        return self._of_polynomials(op, [v for v in operands if isinstance(v, Polynomial)])

    def _of_angles(self, op: int, operands: Sequence[_Value]) -> _Value:
        if op in (ca.OP_SIN, ca.OP_COS) and isinstance(operands[0], AngleSum):
            cosine, sine = self._cosine_and_sine(operands[0])
            return sine if op == ca.OP_SIN else cosine
        return _combined(
            op, [v if isinstance(v, AngleSum) else self._factor(op, v) for v in operands]
        )

    def _factor(self, op: int, value: Polynomial) -> AngleSum | float:
        """A number beside angles: a constant factor, or something known that is added."""
        known = self._known(value)
        if op == ca.OP_MUL:
            if not known.is_constant():
                raise NotPolynomialError
            return float(known)
        return AngleSum({}, known)

    def _cosine_and_sine(self, angle: AngleSum) -> tuple[Polynomial, Polynomial]:
        """By the addition theorems, from those of the offset."""
        cosine, sine = (
            self._constant(ca.cos(angle.offset)),
            self._constant(ca.sin(angle.offset)),
        )
        product = self.ring.product
        for unknown, factor in angle.factors.items():
            own = 0.5 if unknown in self.halves else 1.0
            count = factor / own
            if count != round(count):
                raise NotPolynomialError
            c, s = (self._generator(place) for place in self.ring.places[unknown])
            for _ in range(abs(round(count))):
                turn = s.times(1.0 if count > 0 else -1.0)
                cosine, sine = (
                    product(cosine, c).plus(product(sine, turn), -1.0),
                    product(sine, c).plus(product(cosine, turn)),
                )
        return cosine, sine

    def _of_polynomials(self, op: int, operands: Sequence[Polynomial]) -> Polynomial:
        ring = self.ring
        if len(operands) == 1:
            (a,) = operands
            if op in (ca.OP_NEG, ca.OP_TWICE):
                return a.times(-1.0 if op == ca.OP_NEG else 2.0)
            if op == ca.OP_SQ:
                return ring.product(a, a)
            return self._constant(ca.SX.unary(op, self._known(a)))
        a, b = operands
        if op in (ca.OP_ADD, ca.OP_SUB):
            return a.plus(b, 1.0 if op == ca.OP_ADD else -1.0)
        if op == ca.OP_MUL:
            return ring.product(a, b)
        if op == ca.OP_DIV:
            return a.times(1 / self._known(b))
        return self._constant(ca.SX.binary(op, self._known(a), self._known(b)))

    def _known(self, value: Polynomial) -> ca.SX:
        """Raises NotPolynomialError for what depends on unknowns."""
        known = self.ring.scalar(value)
        if known is None:
            raise NotPolynomialError
        return ca.SX(known)


def _whole(ring: Ring, row: Polynomial, halves: set[int]) -> Polynomial:
    """The same row by cosines and sines of whole angles."""
    for unknown in halves:
        cosine, sine = ring.places[unknown]
        terms: dict[Monomial, ca.SX] = {}
        for monomial, coefficient in row.terms.items():
            base = tuple(0 if place in (cosine, sine) else e for place, e in enumerate(monomial))
            for place, part in _of_whole(monomial[cosine], monomial[sine], cosine, sine):
                whole = (
                    base if place is None else tuple(e + (k == place) for k, e in enumerate(base))
                )
                add_term(terms, whole, times(part, coefficient))
        row = Polynomial(terms)
    return row


def _of_whole(
    cosines: int, sines: int, cosine: int, sine: int
) -> tuple[tuple[int | None, float], ...]:
    """Powers of cosine and sine of a half angle by generators of the whole one: 1, cos, sin. Sines
    stand once at most.
    """
    if (cosines, sines) == (0, 0):
        return ((None, 1.0),)
    if (cosines, sines) == (2, 0):
        return ((None, 0.5), (cosine, 0.5))
    if (cosines, sines) == (1, 1):
        return ((sine, 0.5),)
    raise NotPolynomialError
