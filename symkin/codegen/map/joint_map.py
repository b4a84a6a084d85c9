"""Describe a map between joints of a mechanism for code generation: given coordinates, found ones,
and the passive ones inside.

Either direction is split into structure groups. Where each of them has a closed form, so has the
direction; else Newton's method solves the whole direction, with angles as cosines and sines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import casadi as ca
import numpy as np

from symkin.codegen.map.record import Described
from symkin.codegen.map.signature import MAP, Function
from symkin.codegen.steps.circle_kernel import CircleKernel, circle_kernel, shortened
from symkin.codegen.steps.composed import Part
from symkin.codegen.steps.formula_guards import is_firm
from symkin.codegen.steps.geometry import Geometry
from symkin.codegen.steps.newton_kernel import Kernel
from symkin.codegen.steps.passive_limits import PassiveLimit, passive_limits
from symkin.codegen.steps.samples import Configuration, all_followed, configurations
from symkin.codegen.text.angles import numbers_at, sum_of_angles
from symkin.computed_once import cached_property
from symkin.elimination.closed_form import closed_form, samples_about
from symkin.errors import InputError
from symkin.model.joint import Coordinate, places_of, units_of
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import Rank
from symkin.numeric.system import NOTHING, System
from symkin.position.closed_configurations import closed_configurations
from symkin.position.given import checked_names
from symkin.position.groups import dependence_of, is_linear, structure_groups
from symkin.position.problem import Problem, build_problem

_SAMPLES = 40
_SPREAD, _TURN = 0.1, 0.4
"""How far the given coordinates of samples are from the reference: in sizes, and in radians."""
_DRAWS = 10
"""Sets of known values about the reference at which divisors are compared with those there."""
_BACK = 1e-6
"""How far from where it began a way there and back may end: in sizes, and in radians."""
_CLOSED = 1e-6
"""Closure error at the reference, in sizes, above which the loops are open there."""


@dataclass(frozen=True, eq=False)
class Direction:
    """One direction of a map: from its known coordinates to all others."""

    name: Literal["direct", "inverse"]
    problem: Problem

    @property
    def known(self) -> tuple[Coordinate, ...]:
        return self.problem.known_coordinates

    @property
    def unknown(self) -> tuple[Coordinate, ...]:
        return self.problem.system.unknowns

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The structure groups in the order of their solution."""
        return tuple(_part(group) for group in structure_groups(self.problem))

    @cached_property
    def is_closed(self) -> bool:
        """Whether formulas solve all of it."""
        return all(part.is_closed for part in self.parts)

    @cached_property
    def circles(self) -> CircleKernel:
        """Newton's iteration of this direction. Formulas read the numbers of known coordinates,
        which are then its known values too.
        """
        return circle_kernel(
            self.name,
            _with_continuous_couplings(self.problem),
            self.known,
            collected=not self.is_closed,
        )

    @property
    def kernel(self) -> Kernel:
        return self.circles.kernel


def _with_advancing_wheels(mechanism: Mechanism) -> Mechanism:
    """The mechanism whose wheels of unlike ratios advance: from a guess's wheel of several places
    no driver's place follows, so that the values themselves, whole turns included, must tell it.
    """
    unlike = [
        c.whole_numbers is not None and {1} != {c.whole_numbers[0], *map(abs, c.whole_numbers[1])}
        for c in mechanism.couplings
    ]
    if not any(unlike):
        return mechanism
    couplings = [
        replace(c, advances=some) for c, some in zip(mechanism.couplings, unlike, strict=True)
    ]
    return replace(mechanism, couplings=couplings)


def _with_continuous_couplings(problem: Problem) -> System:
    """The system with the tangent of half a coupling's gap in place of the sine, which changes its
    sign where an angle that is known by cosine and sine passes a half turn.
    """
    closure, rows = problem.closure, ca.vertsplit(problem.system.rows)
    kinds = {c.name: c.kind for c in closure.coordinates}
    couplings = {
        f"coupling of {c.joint}": c
        for c in problem.mechanism.couplings
        if c.advance_reason(kinds) is None
    }
    for k, place in enumerate(problem.row_places):
        coupling = couplings.get(closure.row_sources[place].limb)
        if coupling is None or coupling.whole_numbers is None:
            continue
        own, numbers = coupling.whole_numbers
        joint, *others = (
            closure.variables[closure.slices[name]] for name in (coupling.joint, *coupling.names)
        )
        gap = own * joint - sum(
            (n * v for n, v in zip(numbers, others, strict=True)), ca.SX(own * coupling.constant)
        )
        rows[k] = 2 * closure.characteristic_length / own * ca.sin(gap) / (1 + ca.cos(gap))
    return replace(problem.system, rows=ca.vertcat(*rows))


def _part(group: Problem) -> Part:
    """How a structure group is solved."""
    system = group.system
    (known, unknown) = (group.known_coordinates, system.unknowns)
    periodic = any(c.is_periodic for c in (*unknown, *known))
    if len(unknown) == 1 and unknown[0].is_angular and system.rows.numel() == 1:
        angular = [
            [c.is_angular for c in part for _ in range(c.width)] for part in (unknown, known)
        ]
        total = sum_of_angles(system.rows, [system.unknown, system.known], angular)
        if total is not None and (0, 0) in total.factors:
            return Part(group, total=total)
    if is_linear(group) and system.rows.numel() == system.freedom:
        return Part(group, is_linear=True)
    sources = [group.closure.row_sources[place].relation for place in group.row_places]
    if periodic and "coupling" in sources:
        # its row is of half an angle and changes its sign with every turn, and the choice of a
        # formula with it
        return Part(group)
    reference = group.select_values(group.closure.reference, known)
    short = shortened(system, known)
    found = closed_form(short, samples_about(short, reference, known))
    if found is None or found.has_conditions:
        return Part(group)
    signs = found.signs_at(group.select_values(group.closure.reference, unknown), reference)
    near = np.vstack([samples_about(short, reference, known, seed) for seed in range(_DRAWS)])
    return Part(group, found if is_firm(found, reference, near, signs) else None)


@dataclass(frozen=True, eq=False)
class JointMap(Described):
    """A map between joints with its options: what its C is written from."""

    templates: ClassVar[str] = "map"
    of_poses: ClassVar[bool] = False

    @property
    def functions(self) -> tuple[Function, ...]:
        return MAP

    @property
    def geometry(self) -> Geometry:
        return Geometry(self._whole.closure, at_run_time=False)

    @property
    def told(self) -> dict[str, tuple[Coordinate, ...]]:
        return {"joints": self.given, "found": self.found}

    @cached_property
    def _whole(self) -> Problem:
        """All loops that hold a given or a found coordinate."""
        given, found = self.options.given, self.options.find
        problem = build_problem(_with_advancing_wheels(self.mechanism), given, found)
        return _connected(problem, {*given, *found})

    @cached_property
    def direct(self) -> Direction:
        return Direction("direct", self._whole)

    @cached_property
    def inverse(self) -> Direction:
        everything = (*self.given, *self.direct.unknown)
        known = tuple(next(c for c in everything if c.name == name) for name in self.options.find)
        names = {c.name for c in known}
        return Direction(
            "inverse",
            _partitioned(self._whole, tuple(c for c in everything if c.name not in names), known),
        )

    @property
    def given(self) -> tuple[Coordinate, ...]:
        return self.direct.known

    @property
    def found(self) -> tuple[Coordinate, ...]:
        return self.inverse.known

    @cached_property
    def passive(self) -> tuple[Coordinate, ...]:
        """Coordinates that are neither given nor found."""
        return tuple(c for c in self.direct.unknown if c.name not in self.options.find)

    @cached_property
    def passive_limits(self) -> list[PassiveLimit]:
        """Limits of joints that are neither given nor found and that move with them."""
        closure = self._whole.closure
        moving = closure.symbols(self.coordinates)
        return passive_limits(closure, (*self.given, *self.found), self.real, moving)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """All of them: given, found, passive."""
        return (*self.given, *self.found, *self.passive)

    @property
    def reference(self) -> np.ndarray:
        """The closure's variables at the reference."""
        return self._whole.closure.reference

    def reference_of(self, coordinates: Sequence[Coordinate]) -> np.ndarray:
        """Values of coordinates at the reference."""
        return self._whole.select_values(self.reference, tuple(coordinates))

    @cached_property
    def samples(self) -> list[Configuration]:
        """Configurations reached from the reference when the given coordinates move in straight
        lines.
        """
        return map_configurations(self, _SAMPLES, 3, _SPREAD, _TURN)

    def numbers(self, direction: Direction, sample: Configuration) -> tuple[np.ndarray, np.ndarray]:
        """State and known numbers of a direction's kernel at a configuration."""
        values = [
            self._whole.select_values(sample.values, c)
            for c in (direction.unknown, direction.known)
        ]
        return numbers_at(direction.unknown, values[0]), direction.circles.known_at(
            numbers_at(direction.known, values[1])
        )

    # --- what cannot be ---------------------------------------------------------------------------

    def check(self) -> None:
        """Raises InputError where there is no such map."""
        self._check_names()
        self._check_counts()
        if not self.samples:
            raise InputError(
                f"{self.name}: no closed configurations were found near the reference; nothing to "
                f"generate"
            )

    def _check_names(self) -> None:
        given, found, name = self.options.given, self.options.find, self.name
        known = [c.name for c in self.mechanism.coordinates if not c.is_rotation]
        for what, names in (("--given", given), ("--find", found)):
            if not names:
                other = "--find" if what == "--given" else "--given"
                raise InputError(
                    f"{name}: {other} needs {what} beside it: names of joint coordinates, as in "
                    f"{what} {','.join(known[:2])}"
                )
            checked_names(self.mechanism, names, what, known)
        both = [one for one in given if one in found]
        if both:
            raise InputError(
                f"{name}: {', '.join(both)}: given and to be found at once; leave it out of "
                f"--given or of --find"
            )

    def _check_counts(self) -> None:
        """Given coordinates must decide all others of their loops, and found ones the given."""
        name, given, found = self.name, self.given, self.found
        system = self._whole.system
        values = np.array([self.reference, *closed_configurations(self._whole.closure, 0)])
        if (
            system.residual(
                values[0][self._whole.unknown_places], values[0][self._whole.known_places]
            )
            > _CLOSED * self.size
        ):
            raise InputError(
                f"{name}: its loops are open at the reference configuration; `symkin close` closes "
                f"them"
            )
        everything = (*given, *self.direct.unknown)
        whole = _partitioned(self._whole, everything, ())
        jacobians = whole.system.linearise(values[:, whole.unknown_places], NOTHING)[1]
        rank = max(Rank.of(j).value for j in jacobians)
        columns = places_of(everything, [c.freedom for c in everything])
        mobility = jacobians[0].shape[1] - rank
        told, loops = (
            ", ".join(self.options.given),
            f"the loops of {', '.join((*self.options.given, *self.options.find))}",
        )
        for one in (*given, *found):
            if all(np.all(np.abs(j[:, columns[one.name]]) < 1e-9) for j in jacobians):
                raise InputError(
                    f"{name}: {one.name} is in no loop: nothing but itself moves it, so that no "
                    f"other coordinate is a function of it"
                )
        if len(given) != mobility:
            more = mobility - len(given)
            what = (
                f"give {more} more"
                if more > 0
                else f"leave {-more} out: their values would have to agree with each other"
            )
            raise InputError(
                f"{name}: --given {told} are {len(given)} coordinate(s), and {loops} have "
                f"{mobility} freedom(s); {what}"
            )
        if len(found) != len(given):
            raise InputError(
                f"{name}: {len(given)} coordinate(s) given and {len(found)} to be found; a map "
                f"that can be turned round has as many of both"
            )
        for direction, known, others in (
            (self.direct, "--given", "--find"),
            (self.inverse, "--find", "--given"),
        ):
            kept = [k for c in direction.unknown for k in columns[c.name]]
            ranks = [Rank.of(j[:, kept]).value for j in jacobians]
            names = ", ".join(c.name for c in direction.known)
            if max(ranks) < len(kept):
                asked = ", ".join(self.options.find if known == "--given" else self.options.given)
                raise InputError(
                    f"{name}: {known} {names} does not determine {others} {asked}: some of them "
                    f"decide each other, "
                    "and others are left free"
                )
            if ranks[0] < len(kept):
                raise InputError(
                    f"{name}: the reference configuration is singular for {known} {names}; give "
                    f"the file another reference"
                )


def _partitioned(
    problem: Problem, unknown: tuple[Coordinate, ...], known: tuple[Coordinate, ...]
) -> Problem:
    """The same rows with other coordinates known."""
    symbols = problem.closure.symbols
    system = replace(
        problem.system, unknowns=unknown, unknown=symbols(unknown), known=symbols(known)
    )
    return replace(problem, system=system, known_coordinates=known)


def _connected(problem: Problem, names: set[str]) -> Problem:
    """The rows and unknowns that are joined with some coordinates by rows."""
    closure, system, reached = problem.closure, problem.system, set(names)
    rows, errors = (
        [
            {c.name for c in closure.coordinates if line[closure.slices[c.name]].any()}
            for line in dependence_of(part, closure)
        ]
        for part in (system.rows, system.errors)
    )
    for _ in rows:
        reached.update(*(held for held in rows if held & reached))
    places, checks = (
        [k for k, held in enumerate(part) if held & reached] for part in (rows, errors)
    )
    unknowns = tuple(c for c in system.unknowns if c.name in reached)
    made = replace(
        system,
        unknowns=unknowns,
        unknown=closure.symbols(unknowns),
        rows=system.rows[places, 0],
        errors=system.errors[checks, 0],
    )
    return replace(problem, system=made, row_places=tuple(places))


def map_configurations(
    made: JointMap, count: int, seed: int, spread: float, turn: float
) -> list[Configuration]:
    """Configurations, at most `count`, that are reached from the reference when the given
    coordinates move in straight lines by up to `spread` sizes and `turn` radians, within their
    limits, and back again when the found ones do.
    """
    inverse, home = made.inverse.problem, made.reference
    scales = np.array(units_of(made.inverse.unknown, made.size))
    low, high = np.array([c.limits or (-np.inf, np.inf) for c in made.found]).T

    def leads_back(values: np.ndarray) -> np.ndarray:
        unknown, known = values[:, inverse.unknown_places], values[:, inverse.known_places]
        begin = home[inverse.unknown_places], home[inverse.known_places]
        back, whole = all_followed(inverse, *begin, known)
        same = np.all(np.abs(back - unknown) <= _BACK * scales, axis=1)
        return whole & same & np.all((low < known) & (known < high), axis=1)

    direct = made.direct.problem
    return configurations(direct, home, count, seed, spread, turn, leads_back)
