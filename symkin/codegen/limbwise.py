"""Find the closed form of a direct problem limb by limb: the pose by rows without passive joints,
then each limb's passive joints.

A limb's passive joints by its pose and actuated joints have closed forms of their own. Of one with
two values the discriminant is

    D = N - C^2,  N = A^2 + B^2.

By the law of cosines C is a + b N, so that D = -b^2 (N - low) (N - high): the limb reaches the pose
while low < N < high, which bends less along a line than D does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.codegen.samples import Configuration
from symkin.codegen.text.angles import Generators, lifted
from symkin.elimination.closed_form import ClosedForm, closed_form
from symkin.elimination.implied_rows import plain, pose_rows
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.rank import Rank
from symkin.numeric.system import System
from symkin.position.problem import Problem

_COMPARED = 4
"""Configurations at which the coefficients of rows are compared."""
_FITTED = 1e-9
"""Share of the largest discriminant by which one that follows the law of cosines may miss it."""
_SAME = 1e-9
"""Relative spread of a value that is constant over the samples."""


@dataclass(frozen=True, eq=False)
class Reach:
    """What has to stay above zero for a limb to reach the pose: by a configuration's coordinates,
    `of_configuration`, and by the formulas of the known values, their signs and roots, `of_known`.
    `name` is the coordinate that is decided.
    """

    name: str
    of_configuration: ca.SX
    of_known: ca.SX


@dataclass(frozen=True, eq=False)
class Held:
    """How limbs hold a platform in its motion: their wrenches' `volume` must stay above zero, and
    of each limb the square of its wrench's length (None: it has none), all by the pose.
    """

    volume: ca.SX
    squares: tuple[ca.SX | None, ...]

    def in_unit(self, unit: float, own: Problem, problem: Problem) -> Held:
        """The same of the `problem` of a machine whose lengths are `unit` times those of `own`."""
        volume, *squares = (
            None if e is None else of_twin(e, own, problem, unit)
            for e in (self.volume, *self.squares)
        )
        return Held(volume, tuple(squares))


@dataclass(frozen=True, eq=False)
class LimbwiseForm:
    """The closed form of all unknowns; the limbs' `reaches` stand for discriminants from number
    `pose_choices` on.
    """

    form: ClosedForm
    pose_choices: int
    reaches: tuple[Reach, ...]


def limbwise_form(
    problem: Problem,
    limbs: Sequence[System],
    samples: Sequence[Configuration],
    held: Held | None = None,
) -> LimbwiseForm | None:
    """The closed form of a direct problem by `limbs`, systems of a given pose; None where it is not
    found in this way.
    """
    return _Limbwise(problem, limbs, samples, held).found()


def of_twin(expression: ca.SX, own: Problem, problem: Problem, unit: float) -> ca.SX:
    """An expression of the variables of the `own` problem over those of the `problem` of a twin
    whose lengths are `unit` times as long.
    """
    closure = problem.closure
    there = closure.variables / ca.DM(units_of(closure.coordinates, unit))
    return ca.substitute(expression, own.closure.variables, there)


def given_coordinates(problem: Problem) -> tuple[Coordinate, ...]:
    """The coordinates of the passive systems' known values: all joints that are given, then the
    pose.
    """
    return (*problem.known_coordinates, *problem.closure.role("pose"))


def passive_system(problem: Problem, limb: System) -> System:
    """A limb's rows in its passive joints, by the given coordinates."""
    unknowns = tuple(c for c in limb.unknowns if c.role != "actuated")
    made = _system(problem, limb, unknowns, given_coordinates(problem))
    every = (*limb.unknowns, *problem.closure.role("pose"))
    if any(c.width != 1 for c in every):
        return made
    # no half angles of the pose, of which formulas give cosine and sine of the whole
    rows, errors = (
        plain(part, _symbols(problem, every), every, limb.characteristic_length)
        for part in (limb.rows, limb.errors)
    )
    return replace(made, rows=rows, errors=errors)


def _system(
    problem: Problem,
    limb: System,
    unknowns: tuple[Coordinate, ...],
    known: Sequence[Coordinate],
) -> System:
    return System(
        unknowns,
        _symbols(problem, unknowns),
        _symbols(problem, known),
        limb.rows,
        limb.errors,
        limb.characteristic_length,
    )


def _symbols(problem: Problem, coordinates: Sequence[Coordinate]) -> ca.SX:
    closure = problem.closure
    return ca.vertcat(
        ca.SX(0, 1), *(closure.variables[closure.slices[c.name]] for c in coordinates)
    )


@dataclass(frozen=True, eq=False)
class _Limbwise:
    problem: Problem
    limbs: Sequence[System]
    samples: Sequence[Configuration]
    held: Held | None = None

    @property
    def _pose(self) -> tuple[Coordinate, ...]:
        return self.problem.closure.role("pose")

    def _values(self, coordinates: tuple[Coordinate, ...]) -> np.ndarray:
        return np.array([self.problem.select_values(s.values, coordinates) for s in self.samples])

    def found(self) -> LimbwiseForm | None:
        if any(c.width != 1 for c in (*self._pose, *self.problem.known_coordinates)):
            return None
        pose = self._pose_form()
        if pose is None:
            return None
        reaches, whole = list[Reach](), _Composed(self, pose)
        for number, limb in enumerate(self.limbs):
            system = passive_system(self.problem, limb)
            if not system.unknowns:
                continue
            form = closed_form(system, self._values(given_coordinates(self.problem))[:_COMPARED])
            found = None if form is None else self._reaches_of(form, whole, number)
            if form is None or found is None:
                return None
            reaches += found
            whole.add(form)
        if len(whole.forms) == 1:
            return None
        if self.held is not None:
            reaches.append(
                Reach("the motion's wrenches", self.held.volume, whole.of_known(self.held.volume))
            )
        made = whole.form()
        known = self._values(self.problem.known_coordinates)
        return (
            LimbwiseForm(made, int(pose.signs.shape[0]), tuple(reaches))
            if made.closes(known)
            else None
        )

    def _pose_form(self) -> ClosedForm | None:
        """The closed form of the pose by the rows that hold no passive joint."""
        closure, joints = self.problem.closure, self.problem.known_coordinates
        rows, poses = [], self._values(self._pose)
        for limb in self.limbs:
            own = [c for c in limb.unknowns if c.role == "actuated"]
            if len(own) == len(limb.unknowns):
                rows.append(limb.rows)
                continue
            points = pose_rows(limb, poses[:_COMPARED], self._lost(limb))
            if points is None:
                return None
            rows += [p.row for p in points]
        known = _symbols(self.problem, joints)
        whole = ca.vertcat(*rows)
        system = System(
            self._pose,
            _symbols(self.problem, self._pose),
            known,
            whole,
            whole,
            closure.characteristic_length,
        )
        return closed_form(system, self._values(joints)[:_COMPARED])

    def _lost(self, limb: System) -> int:
        """How many freedoms the platform loses by a limb whose actuated joints are held."""
        passive = tuple(c for c in limb.unknowns if c.role != "actuated")
        ranks = []
        for unknowns in (passive, (*passive, *self._pose)):
            held = tuple(c for c in (*limb.unknowns, *self._pose) if c not in unknowns)
            system = _system(self.problem, limb, unknowns, held)
            sample = self.samples[0].values
            _, matrix = system.linearise_one(
                self.problem.select_values(sample, unknowns),
                self.problem.select_values(sample, held),
            )
            ranks.append(Rank.of(matrix).value)
        return ranks[1] - ranks[0]

    def _reaches_of(self, form: ClosedForm, whole: _Composed, number: int) -> list[Reach] | None:
        """What has to stay above zero for a limb's choices; None where that is not known."""
        square = None if self.held is None else self.held.squares[number]
        return (
            self._by_cosines(form, whole)
            if square is None
            else self._by_wrench(form, whole, square)
        )

    def _by_wrench(self, form: ClosedForm, whole: _Composed, square: ca.SX) -> list[Reach] | None:
        """Nothing where all discriminants and divisors are multiples of a wrench's squared length,
        which the volume holds, or divisors of the joints alone, which become those of the whole;
        else None.
        """
        known, poses = self._values(given_coordinates(self.problem)), self._values(self._pose)
        signs = form.signs_at(self._values(form.system.unknowns)[0], known[0])
        length = ca.Function("length", [_symbols(self.problem, self._pose)], [square])
        lengths = np.array([float(length(v)) for v in poses])
        values = np.hstack([form.discriminants_at(known, signs), form.divisors_at(known, signs)])
        alone = [
            k
            for k in range(values.shape[1])
            if not _is_multiple_of_any(values[:, k], lengths[:, None])
        ]
        count = int(form.discriminants.shape[0])
        others = ca.vertcat(form.roots, form.signs, _symbols(self.problem, self._pose))
        for k in alone:
            if k < count or ca.depends_on(form.divisors[k - count], others):
                return None
            whole.divisors.append(form.divisors[k - count])
        return []

    def _by_cosines(self, form: ClosedForm, whole: _Composed) -> list[Reach] | None:
        """The bounds of N of each choice; None where a discriminant does not follow the law of
        cosines or a divisor may vanish alone.
        """
        if ca.depends_on(ca.vertcat(form.discriminants, form.divisors), form.roots):
            return None
        known = self._values(given_coordinates(self.problem))
        function = ca.Function("d", [form.system.known], [form.discriminants, form.divisors])
        numbers = [function(v) for v in known]
        discriminants, divisors = (
            np.array([np.asarray(n[k]).ravel() for n in numbers]) for k in range(2)
        )
        reaches: list[Reach] = []
        squares: set[int] = set()
        for k, name in enumerate(form.names):
            found = _law_of_cosines(discriminants[:, k], divisors)
            if found is None:
                return None
            j, low, high = found
            squares.add(j)
            bounds = [high - form.divisors[j]]
            # N is a sum of squares, which is zero where both are: no bound that a line crosses
            bounds += [form.divisors[j] - low] if low > _SAME * high else []
            reaches += [Reach(name, bound, whole.of_known(bound)) for bound in bounds]
        alone = [
            divisors[:, j]
            for j in range(divisors.shape[1])
            if not _is_multiple_of_any(divisors[:, j], divisors[:, sorted(squares)])
        ]
        return reaches if all(np.ptp(v) <= _SAME * np.max(np.abs(v)) for v in alone) else None


@dataclass
class _Composed:
    """A form of the pose and those of limbs, put together over the known values alone."""

    parts: _Limbwise
    pose: ClosedForm

    def __post_init__(self) -> None:
        own = self.pose.system.unknowns
        self.forms = [self.pose]
        self.values = {c.name: (self.pose.first[k], self.pose.second[k]) for k, c in enumerate(own)}
        self.discriminants = [self.pose.discriminants]
        self.divisors = [self.pose.divisors]
        known = self.parts.problem.known_coordinates
        symbols = _symbols(self.parts.problem, known)
        generators = [
            Generators((ca.cos(symbols[k]), ca.sin(symbols[k])) if c.is_angular else (symbols[k],))
            for k, c in enumerate(known)
        ]
        self.generators = {c.name: g for c, g in zip(known, generators, strict=True)}
        for k, c in enumerate(own):
            self.generators[c.name] = Generators(
                self.values[c.name] if c.is_angular else (self.pose.first[k],)
            )

    def of_known(self, expression: ca.SX, others: ca.SX | None = None) -> ca.SX:
        """An expression of joints and pose with the pose's formulas in place of the pose."""
        coordinates = (*self.parts.problem.known_coordinates, *self.pose.system.unknowns)
        symbols = _symbols(self.parts.problem, coordinates)
        places = [(symbols[k], c.name) for k, c in enumerate(coordinates)]
        return lifted(
            expression, places, self.generators, ca.SX(0, 1) if others is None else others
        )

    def add(self, form: ClosedForm) -> None:
        """Add a limb's passive joints."""
        others = ca.vertcat(form.signs, form.roots)
        first, second = (self.of_known(e, others) for e in (form.first, form.second))
        self.discriminants.append(self.of_known(form.discriminants, others))
        self.values |= {c.name: (first[k], second[k]) for k, c in enumerate(form.system.unknowns)}
        self.forms.append(form)

    def form(self) -> ClosedForm:
        problem, none = self.parts.problem, ca.SX(0, 1)
        pairs = [self.values[c.name] for c in problem.system.unknowns]
        return ClosedForm(
            system=problem.system,
            signs=ca.vertcat(none, *(f.signs for f in self.forms)),
            roots=ca.vertcat(none, *(f.roots for f in self.forms)),
            first=ca.vertcat(*(p[0] for p in pairs)),
            second=ca.vertcat(*(p[1] for p in pairs)),
            discriminants=ca.vertcat(none, *self.discriminants),
            divisors=ca.vertcat(none, *self.divisors),
            implied=frozenset(),
            squares=frozenset(),
            told=ca.vertcat(none, *(f.told for f in self.forms)),
            steps=tuple(step for f in self.forms for step in f.steps),
            names=tuple(name for f in self.forms for name in f.names),
            samples=self.pose.samples,
        )


def _law_of_cosines(
    discriminant: np.ndarray, divisors: np.ndarray
) -> tuple[int, float, float] | None:
    """Which divisor N makes a discriminant -b^2 (N - low) (N - high), with low and high; None where
    none does.
    """
    for j in range(divisors.shape[1]):
        size = float(np.max(np.abs(divisors[:, j])))
        if np.ptp(divisors[:, j]) <= _SAME * size:
            continue
        matrix = np.stack(
            [np.ones(len(divisors)), divisors[:, j] / size, (divisors[:, j] / size) ** 2], axis=1
        )
        factors, *_ = np.linalg.lstsq(matrix, discriminant, rcond=None)
        missed = np.max(np.abs(matrix @ factors - discriminant))
        if missed <= _FITTED * np.max(np.abs(discriminant)) and factors[2] < 0.0:
            low, high = sorted(float(v) for v in np.real(np.roots(factors[::-1])))
            return j, low * size, high * size
    return None


def _is_multiple_of_any(values: np.ndarray, others: np.ndarray) -> bool:
    ratios = values[:, None] / others
    return bool(
        np.any(np.ptp(ratios, axis=0) <= _SAME * np.max(np.abs(ratios), axis=0, initial=0.0))
    )
