"""Couplings as other formats write them, equations between joints in any number and order, as those
of a mechanism: each joint coupled once, in no circle.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from symkin.errors import MechanismError
from symkin.model.graph import Coupling

_ZERO = 1e-12
"""Coefficients and constants below this, where the others are about 1, are rounding of equations
that say the same.
"""


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
    """Couplings that are added one after another; `places` are those of the file that tell them."""

    found: dict[str, Coupling] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    places: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls, told: Iterable[tuple[Coupling, str]], equations: Iterable[LinearEquation]
    ) -> CouplingSet:
        """Couplings with their places, then equations."""
        made = cls()
        for coupling, where in told:
            made.add(coupling, where)
        for equation in equations:
            made.add_linear(equation)
        return made

    def add(self, coupling: Coupling, where: str) -> None:
        """A coupling that names the joint that follows. Raises MechanismError where another one
        already says what the joint is.
        """
        joint = coupling.joint
        if joint in self.found:
            raise MechanismError(
                f"{where}: the joint {joint!r} follows others already ({self.places[joint]}); "
                f"write one of the two"
            )
        circle = self._circle(joint, coupling.names)
        if circle:
            raise MechanismError(
                f"{where}: the joints mimic each other in a circle: {', '.join(sorted(circle))}"
            )
        self.found[joint], self.places[joint] = coupling, where

    def add_linear(self, equation: LinearEquation) -> None:
        """Write an equation for its first joint that may follow the others; what other equations
        say already is left out.
        """
        terms = {name: factor for name, factor in equation.terms.items() if factor != 0.0}
        equation = replace(equation, terms=terms)
        if not self._write(equation, first_only=True):
            equation = self._reduced(equation)
            if not equation.terms:
                self._check_repeated(equation)
            elif len(equation.terms) == 1:
                ((joint, factor),) = equation.terms.items()
                raise MechanismError(
                    f"{equation.where}: it and other couplings hold the joint {joint!r} at "
                    f"{equation.constant / factor + 0.0:.6g}; make it a fixed joint, or write one "
                    f"of them otherwise"
                )
            elif not self._write(equation, first_only=False):
                raise MechanismError(
                    f"{equation.where}: it and other couplings run in a circle; write one of them "
                    f"otherwise"
                )

    def _write(self, equation: LinearEquation, *, first_only: bool) -> bool:
        terms = equation.terms
        for joint in list(terms)[:1] if first_only else terms:
            others = {
                name: -factor / terms[joint] for name, factor in terms.items() if name != joint
            }
            if others and joint not in self.found and not self._circle(joint, others):
                coupling = Coupling(joint, others, equation.constant / terms[joint])
                self.add(coupling, equation.where)
                return True
        return False

    def _circle(self, joint: str, others: Iterable[str]) -> list[str]:
        """The joints on a way of couplings from a joint back to itself, if it follows some others;
        none where there is no such way.
        """
        ways = {name: [joint, name] for name in others}
        for name in (todo := [*ways]):
            for other in self.found[name].names if name in self.found else ():
                if other == joint:
                    return ways[name]
                if other not in ways:
                    ways[other] = [*ways[name], other]
                    todo.append(other)
        return []

    def _reduced(self, equation: LinearEquation) -> LinearEquation:
        """The equation with what linear couplings say of its joints put in their place."""
        found, rest = dict(equation.terms), equation.constant
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
        return replace(equation, terms=found, constant=rest)

    def _check_repeated(self, equation: LinearEquation) -> None:
        if abs(equation.constant) > _ZERO:
            raise MechanismError(
                f"{equation.where}: it contradicts other couplings, or holds a joint at a value; "
                f"off by {equation.constant:.3g}"
            )
        self.notes.append(f"{equation.where}: it says what other couplings say, and is left out")
