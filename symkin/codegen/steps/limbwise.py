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

from symkin.codegen.steps.composed import Formulas, Part, parts_of
from symkin.codegen.steps.samples import Configuration
from symkin.elimination.closed_form import ClosedForm, closed_form
from symkin.elimination.implied_rows import plain
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.system import System
from symkin.position.problem import Problem
from symkin.spatial.backend import stacked

_COMPARED = 4
"""Configurations at which the coefficients of rows are compared."""
_FITTED = 1e-9
"""Share of the largest discriminant by which one that follows the law of cosines may miss it."""
_SAME = 1e-9
"""Relative spread of a value that is constant over the samples."""


@dataclass(frozen=True, eq=False)
class Reach:
    """What has to stay above zero for a limb to reach the pose: its `value` by the closure's
    variables. `name` is the coordinate that is decided.
    """

    name: str
    value: ca.SX


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
class DirectForm(Formulas):
    """The formulas of a direct problem, the pose's first: the `divisors` that are watched, by the
    known numbers, and the limbs' `reaches`, which stand for the discriminants of all other parts.
    """

    divisors: ca.SX
    reaches: tuple[Reach, ...] = ()

    @property
    def pose_choices(self) -> int:
        """How many discriminants are watched themselves."""
        form = self.whole.parts[0].form
        return 0 if form is None else form.roots.numel()

    @property
    def is_limbwise(self) -> bool:
        """Whether passive joints are solved limb by limb, after the pose."""
        return len(self.whole.parts) > 1

    @property
    def steps(self) -> list[str]:
        """The derivation, a sentence each."""
        return [step for form in self.whole.forms for step in form.steps]


def whole_form(problem: Problem, samples: np.ndarray) -> DirectForm | None:
    """The closed form of all rows together, whose coefficients are compared at known values (n,
    known).
    """
    form = closed_form(problem.system, samples)
    if form is None:
        return None
    found = Formulas.of(problem, [Part(problem, form)])
    divisors = found.whole.written(form.divisors, form)
    return DirectForm(problem, found.known, found.whole, divisors)


def limbwise_form(
    problem: Problem,
    limbs: Sequence[System],
    samples: Sequence[Configuration],
    held: Held | None = None,
) -> DirectForm | None:
    """The closed form of a direct problem by its parts, the pose first; None where it is not found
    in this way. `limbs` are systems of a given pose, in the order of what is `held`.
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
    given = given_coordinates(problem)
    made = replace(
        limb,
        unknowns=unknowns,
        unknown=problem.closure.symbols(unknowns),
        known=problem.closure.symbols(given),
    )
    return _of_whole_angles(made, problem, (*limb.unknowns, *problem.closure.role("pose")))


def _of_whole_angles(system: System, problem: Problem, coordinates: Sequence[Coordinate]) -> System:
    """The system without half angles of the pose, of which formulas give cosine and sine of the
    whole.
    """
    if any(c.width != 1 for c in coordinates):
        return system
    rows, errors = (
        plain(part, problem.closure.symbols(coordinates), coordinates, system.characteristic_length)
        for part in (system.rows, system.errors)
    )
    return replace(system, rows=rows, errors=errors)


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

    def found(self) -> DirectForm | None:
        known = self.problem.known_coordinates
        if any(c.width != 1 for c in (*self._pose, *known)):
            return None
        pose, *others = parts_of(self.problem)
        if not others or pose.system.unknowns != self._pose:
            return None
        made = Formulas.of(self.problem)
        reaches, divisors = list[Reach](), list[ca.SX]()
        for part in (pose, *others):
            form = self._form(part)
            if form is None:
                return None
            made.whole.add(Part(part, form))
            found = ([], form.divisors.elements()) if part is pose else self._watched(part, form)
            if found is None:
                return None
            reaches += found[0]
            divisors.append(made.whole.written(stacked(found[1]), form))
        if self.held is not None:
            reaches.append(Reach("the motion's wrenches", self.held.volume))
        whole = DirectForm(self.problem, made.known, made.whole, stacked(divisors), tuple(reaches))
        return whole if whole.closes(np.array([s.values for s in self.samples])) else None

    def _form(self, part: Problem) -> ClosedForm | None:
        coordinates = (*part.system.unknowns, *part.known_coordinates)
        system = _of_whole_angles(part.system, self.problem, coordinates)
        return closed_form(system, self._values(part.known_coordinates)[:_COMPARED])

    def _watched(self, part: Problem, form: ClosedForm) -> tuple[list[Reach], list[ca.SX]] | None:
        """What has to stay above zero for a limb's choices, and divisors of its formulas that are
        watched; None where that is not known.
        """
        square = None if self.held is None else self._square(part, self.held)
        if square is None:
            return self._by_cosines(part, form)
        return self._by_wrench(part, form, square)

    def _square(self, part: Problem, held: Held) -> ca.SX | None:
        """The square of the wrench of the limb that a part belongs to."""
        own = {c.name for c in part.system.unknowns}
        limb = next(k for k, s in enumerate(self.limbs) if own <= {c.name for c in s.unknowns})
        return held.squares[limb]

    def _by_wrench(
        self, part: Problem, form: ClosedForm, square: ca.SX
    ) -> tuple[list[Reach], list[ca.SX]] | None:
        """Nothing where all discriminants and divisors are multiples of a wrench's squared length,
        which the volume holds, or divisors of the joints alone, which are watched; else None.
        """
        poses, known = (self._values(c) for c in (self._pose, part.known_coordinates))
        signs = form.signs_at(self._values(form.system.unknowns)[0], known[0])
        length = ca.Function("length", [self.problem.closure.symbols(self._pose)], [square])
        lengths = np.array([float(length(v)) for v in poses])
        values = np.hstack([form.discriminants_at(known, signs), form.divisors_at(known, signs)])
        alone = [
            k
            for k in range(values.shape[1])
            if not _is_multiple_of_any(values[:, k], lengths[:, None])
        ]
        count = form.discriminants.numel()
        others = ca.vertcat(form.roots, form.signs, self.problem.closure.symbols(self._pose))
        watched = [form.divisors[k - count] for k in alone if k >= count]
        if len(watched) < len(alone) or any(ca.depends_on(d, others) for d in watched):
            return None
        return [], watched

    def _by_cosines(
        self, part: Problem, form: ClosedForm
    ) -> tuple[list[Reach], list[ca.SX]] | None:
        """The bounds of N of each choice; None where a discriminant does not follow the law of
        cosines or a divisor may vanish alone.
        """
        if ca.depends_on(ca.vertcat(form.discriminants, form.divisors), form.roots):
            return None
        known = self._values(part.known_coordinates)
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
            reaches += [Reach(name, bound) for bound in bounds]
        alone = [
            divisors[:, j]
            for j in range(divisors.shape[1])
            if not _is_multiple_of_any(divisors[:, j], divisors[:, sorted(squares)])
        ]
        constant = all(np.ptp(v) <= _SAME * np.max(np.abs(v)) for v in alone)
        return (reaches, []) if constant else None


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
