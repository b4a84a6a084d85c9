"""Name what the formulas of a direct problem read and give, and write what their guards need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.record import Source
from symkin.codegen.steps.direct_formulas import DirectFormulas
from symkin.codegen.steps.guard_text import GuardText
from symkin.codegen.text.angles import Numbers
from symkin.codegen.text.c import Emitter
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate, places_of
from symkin.numeric.system import System


@dataclass(frozen=True, eq=False)
class DirectValues(Source):
    """The values of one platform's direct problem: `u` the given ones, `y` the unknowns, angles by
    cosine and sine, `half` those of half the pose's turn.
    """

    made: LimbPlatform
    found: DirectFormulas

    @cached_property
    def guards(self) -> GuardText:
        return GuardText(self.found.guards, self.real, measures=True)

    @cached_property
    def joint_places(self) -> dict[str, range]:
        """Places of each actuated joint's generators in the arrays `at` and `u`."""
        return _generators_of(self.made.actuated)

    @cached_property
    def unknown_places(self) -> dict[str, range]:
        """Places of each unknown's generators in `y`."""
        return _generators_of(self.unknowns)

    @property
    def unknowns(self) -> tuple[Coordinate, ...]:
        return self.found.formulas.system.unknowns

    @cached_property
    def count(self) -> int:
        return sum(len(places) for places in self.joint_places.values())

    @cached_property
    def u(self) -> ca.SX:
        return ca.SX.sym("u", self.count)

    @cached_property
    def y(self) -> ca.SX:
        return ca.SX.sym("y", sum(len(places) for places in self.unknown_places.values()))

    @cached_property
    def half(self) -> ca.SX:
        return ca.SX.sym("h", 2)

    def places(self, system: System) -> list[tuple[ca.SX, str]]:
        """Symbols of a system's coordinates with their names."""
        whole = system is self.found.formulas.system
        known = self.made.direct.known_coordinates if whole else self.made.inverse.known_coordinates
        parts = ((system.unknowns, system.unknown), (known, system.known))
        return [
            (symbols[k], c.name)
            for coordinates, symbols in parts
            for k, c in enumerate(coordinates)
        ]

    def signed(self, expression: ca.SX) -> ca.SX:
        """An expression in which roots have their signs."""
        return ca.substitute(
            expression, self.found.formulas.signs, ca.SX.ones(*self.found.formulas.signs.shape)
        )

    @cached_property
    def generators(self) -> dict[str, Numbers]:
        """Symbols of the joints and of the unknowns; of the pose's turn those of half of it."""
        found = {}
        for places, array in ((self.joint_places, self.u), (self.unknown_places, self.y)):
            for name, own in places.items():
                found[name] = Numbers.of(tuple(array[i] for i in own))
        return found

    @property
    def turns(self) -> list[tuple[ca.SX, ca.SX]]:
        """The joints' symbols that are cosine and sine of one angle."""
        return [(self.u[p[0]], self.u[p[1]]) for p in self.joint_places.values() if len(p) == 2]

    def store_guards(self, emitter: Emitter, output: int, array: str, *, of_divisors: bool) -> None:
        """Add statements of guards: those of divisors, by which formulas divide, or those of
        discriminants.
        """
        for j, guard in enumerate(self.found.guards):
            if guard.is_divisor == of_divisors:
                emitter.lines.append(f"w->{array}[{j}] = {emitter.value(output, j)};")

    def above(self, array: str, *, of_divisors: bool) -> str:
        """C condition: these guards are more than rounding, where it is least: the line asks again
        by the part of the slides' ranges that holds it.
        """
        tests = [
            f"(w->{array}[{j}] > {self.literal(self.guards.roundings(guard)[0])})"
            for j, guard in enumerate(self.found.guards)
            if guard.is_divisor == of_divisors
        ]
        return " && ".join(tests)


def _generators_of(coordinates: Sequence[Coordinate]) -> dict[str, range]:
    """Places of the generators of coordinates, one after the other."""
    return places_of(coordinates, [2 if c.is_angular else 1 for c in coordinates])
