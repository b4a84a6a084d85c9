"""Couplings as other formats write them, equations between joints in any number and order, as those
of a mechanism: each joint coupled once, in no circle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from symkin.errors import MechanismError
from symkin.formats.xml_text import Element
from symkin.model.graph import Coupling

_ZERO = 1e-12
"""Coefficients and constants below this, where the others are about 1, are rounding of equations
that say the same.
"""


ToldCoupling = tuple[Coupling, Element]
"""A coupling, and the element that tells it."""


def couplings_told(found: Sequence[ToldCoupling]) -> list[Coupling]:
    """The couplings of elements that each name the joint that follows. Raises MechanismError for a
    joint that follows twice, and for joints that follow each other in a circle.
    """
    told: dict[str, ToldCoupling] = {}
    for coupling, element in found:
        if coupling.joint in told:
            raise element.error(
                f"the joint {coupling.joint!r} follows others already (line "
                f"{told[coupling.joint][1].line}); write one of the two"
            )
        told[coupling.joint] = coupling, element
    for name in told:
        circle = _circle(name, told)
        if circle:
            raise told[name][1].error(
                f"the joints mimic each other in a circle: {', '.join(sorted(circle))}"
            )
    return [coupling for coupling, _ in told.values()]


def mimic_of(coupling: Coupling, mechanism: str, format_name: str) -> tuple[str, float, float]:
    """The joint that another follows on a line, factor and offset. Raises MechanismError for a
    coupling that is no such line, which a format without polynomials and sums cannot hold.
    """
    line = coupling.line
    if line is None or len(line) != 1:
        raise MechanismError(
            f"{mechanism}: the coupling of {coupling.joint!r} is no line of one other joint, which "
            f"is what {format_name} holds as mimic; "
            "MJCF (.xml) holds it"
        )
    return (*line[0], coupling.constant)


def _circle(begin: str, told: Mapping[str, ToldCoupling]) -> list[str]:
    """The joints on a way from a joint back to itself; none where there is no such way."""
    ways = {begin: [begin]}
    todo = [begin]
    while todo:
        at = todo.pop()
        for other in told[at][0].names if at in told else ():
            if other == begin:
                return ways[at]
            if other not in ways:
                ways[other] = [*ways[at], other]
                todo.append(other)
    return []


@dataclass(frozen=True)
class LinearEquation:
    """The sum of factor x joint = constant; the joint named first is the one that the file writes
    as following the others.
    """

    terms: Mapping[str, float]
    constant: float
    where: str


@dataclass
class CouplingSet:
    """Couplings that are added one after another."""

    found: dict[str, Coupling] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def add_polynomial(
        self, joint: str, of: str, coefficients: Sequence[float], where: str
    ) -> None:
        """joint = c0 + c1 other + c2 other^2 + ... Raises MechanismError where another coupling
        already says what the joint is.
        """
        if not self._may_follow(joint, [of]):
            raise MechanismError(
                f"{where}: the joint {joint!r} follows others already by another coupling; write "
                f"one of the two"
            )
        self.found[joint] = Coupling(joint, of, polynomial=tuple(coefficients))

    def add_linear(self, equation: LinearEquation) -> None:
        """Write an equation for its first joint that may follow the others; what other equations
        say already is left out.
        """
        terms = {name: factor for name, factor in equation.terms.items() if factor != 0.0}
        if not self._write(terms, equation.constant, first_only=True):
            terms, constant = self._reduced(terms, equation.constant)
            if not terms:
                self._check_repeated(equation, constant)
            elif not self._write(terms, constant, first_only=False):
                raise MechanismError(
                    f"{equation.where}: it and other couplings run in a circle; write one of them "
                    f"otherwise"
                )

    def _write(self, terms: Mapping[str, float], constant: float, *, first_only: bool) -> bool:
        names = list(terms)[:1] if first_only else list(terms)
        for joint in names:
            others = {
                name: -factor / terms[joint] for name, factor in terms.items() if name != joint
            }
            if others and self._may_follow(joint, list(others)):
                self.found[joint] = Coupling(joint, others, constant / terms[joint])
                return True
        return False

    def _may_follow(self, joint: str, others: Sequence[str]) -> bool:
        """Whether a joint follows nothing yet, and none of the others follows it."""
        todo, seen = list(others), set(others)
        while todo:
            coupling = self.found.get(todo.pop())
            more = (
                [name for name in coupling.names if name not in seen]
                if coupling is not None
                else []
            )
            seen |= set(more)
            todo += more
        return joint not in self.found and joint not in seen

    def _reduced(
        self, terms: Mapping[str, float], constant: float
    ) -> tuple[dict[str, float], float]:
        """The equation with what linear couplings say of its joints put in their place."""
        found, rest = dict(terms), constant
        while (
            name := next(
                (n for n in found if n in self.found and self.found[n].polynomial is None), None
            )
        ) is not None:
            factor, coupling = found.pop(name), self.found[name]
            rest -= factor * coupling.offset
            for other, share in coupling.terms:
                found[other] = found.get(other, 0.0) + factor * share
            found = {n: f for n, f in found.items() if abs(f) > _ZERO}
        return found, rest

    def _check_repeated(self, equation: LinearEquation, constant: float) -> None:
        if abs(constant) > _ZERO:
            raise MechanismError(
                f"{equation.where}: it contradicts other couplings, or holds a joint at a value; "
                f"off by {constant:.3g}"
            )
        self.notes.append(f"{equation.where}: it says what other couplings say, and is left out")
