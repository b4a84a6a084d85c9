"""The problems of generated C that take a guess, asked many at once, and the same lines walked
finely beside it: of platforms, arms and maps between joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from asked import STATUSES, Answers, Asked
from continuation import LONGEST, ROUNDINGS, Ends, Walker
from symkin.codegen.map.joint_map import JointMap
from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.program import Kind
from symkin.codegen.map.rod_platform import RodPlatform
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.text.c import Real
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem, actuated_names, build_problem, pose_names
from symkin.position.readings import poses_of

OUT_OF_RANGE = STATUSES.index("OUT_OF_RANGE")
REGULAR = 1.0 / 25600
"""A line that needs shorter steps than this part of it passes too near a singularity to be called
regular.
"""
PLAIN = 0.25
"""Step of the fine walk, as a part of a line, which lines that nothing is beside take."""
HARD = 50.0
"""Condition from which on a refusal beside a singularity is not held against the code: bounds are
kept from it.
"""
_REFUSED = 0.2
"""Refused goals that are walked too, as a part of all goals: they tell how many regular lines are
OK.
"""
_FIRM = 0.02
"""Condition of a limb at a given pose, times the root of rounding, from which on the limb is beside
a dead centre: an error t of the pose is one of sqrt(t) there, and code keeps bounds of some such.
"""
_NEAR = 2e-7
"""How far right answers are from where lines lead: so much of the size, and roundings times the
condition.
"""


class Starts(NamedTuple):
    """Where lines begin: unknowns, known values, and the same as the generated code's guesses."""

    unknowns: np.ndarray
    known: np.ndarray
    guesses: np.ndarray

    def where(self, chosen: np.ndarray, other: Starts) -> Starts:
        """These where chosen, else the other ones."""
        pairs = zip(self, other, strict=True)
        return Starts(*(np.where(chosen[:, None], mine, yours) for mine, yours in pairs))

    def repeated(self, count: int) -> Starts:
        """Each of these so many times."""
        return Starts(*(np.repeat(part, count, axis=0) for part in self))


@dataclass(frozen=True)
class Outcome:
    """One batch of lines: the C's answers, which lines were walked and where they led, and which
    answers are right.
    """

    starts: Starts
    goals: np.ndarray
    answers: Answers
    walked: np.ndarray
    ends: Ends
    right: np.ndarray

    @property
    def ok(self) -> np.ndarray:
        return np.asarray(self.answers.status == 0)

    @property
    def regular(self) -> np.ndarray:
        """Walked lines that are regular, of goals within limits."""
        within = self.walked & (self.answers.status != OUT_OF_RANGE)
        return np.asarray(within & (self.ends.shortest >= REGULAR))


@dataclass(frozen=True, eq=False)
class Direction:
    """One problem of one machine's code, by its function, and the closure that it solves. Of arms
    and maps the places of what is found among the unknowns, of a map the problem that leads `back`;
    platforms find poses.
    """

    asked: Asked
    problem: Problem
    longest: float = LONGEST
    solved_by: str = ""
    way: str = ""
    places: np.ndarray | None = None
    back: Direction | None = None

    @cached_property
    def walker(self) -> Walker:
        return Walker(self.problem, self.longest, self.epsilon)

    @cached_property
    def far_walker(self) -> Walker:
        """One whose steps are long where nothing is near."""
        return Walker(self.problem, PLAIN, self.epsilon)

    @property
    def kind(self) -> Kind:
        return self.asked.program.kind

    @property
    def real(self) -> str:
        return self.asked.options.real

    @property
    def epsilon(self) -> float:
        return Real(self.asked.options.real).epsilon

    @property
    def size(self) -> float:
        return self.asked.mechanism.characteristic_length

    @cached_property
    def home(self) -> Starts:
        """Home; of an arm the first of its samples, which is regular."""
        kind, problem = self.kind, self.problem
        if isinstance(kind, SerialArm):
            joints, pose = kind.samples[0]
            return Starts(joints[None], pose[None], joints[None])
        if isinstance(kind, JointMap):
            values = kind.reference
        else:
            # code may be of another machine that the mechanism means: its home is the reference
            alike = kind.mechanism == problem.mechanism
            values = kind.home_values if alike else problem.closure.reference
        unknowns = problem.select_values(values, problem.system.unknowns)[None]
        known = problem.select_values(values, problem.known_coordinates)[None]
        return Starts(unknowns, known, self.stated(unknowns, known))

    def answers(self, goals: np.ndarray, guesses: np.ndarray) -> Answers:
        return self.asked.answers(goals, guesses, self.way)

    def stated(self, unknowns: np.ndarray, known: np.ndarray) -> np.ndarray:
        """What the code finds at configurations: poses, or joint values."""
        if self.places is not None:
            return unknowns[:, self.places]
        return np.hstack(poses_of(self.problem.closure, self.problem.join_values(unknowns, known)))

    def gives_back(self, found: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Whether the code's limbs, on the reference's branches, reach a pose with these joint
        values: else one is past a dead centre.
        """
        if self.places is not None:
            return np.ones(len(found), bool)
        status, joints = self.asked.back(found)
        away = self._away(joints - known, self.problem.known_coordinates)
        # beside a dead centre joints differ by the root of the pose's rounding
        return np.asarray((status == 0) & (away < np.sqrt(self.epsilon)))

    def is_firm(self, unknowns: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Whether rounded poses tell on which side of their dead centres limbs stand: those of
        configurations at which the limbs' rows, the pose given, are far from singular.
        """
        if self.places is not None:
            return np.ones(len(unknowns), bool)
        values = self.problem.join_values(unknowns, known)
        limbs = build_problem(self.asked.mechanism, pose_names(self.asked.mechanism))
        parts = (limbs.system.unknowns, limbs.known_coordinates)
        conditions = limbs.system.conditions(*(limbs.select_values(values, c) for c in parts))
        return np.asarray(conditions * np.sqrt(self.epsilon) < _FIRM)

    def tells(self, guesses: np.ndarray, known: np.ndarray, *, easily: bool = False) -> np.ndarray:
        """Whether guesses alone tell the code that it stands at these known values: those of a map
        hold one side's values only, and mean the configuration to which these lead from home;
        `easily`: by a line far from singularities.
        """
        if self.back is None:
            return np.ones(len(guesses), bool)
        home = self.back.home.repeated(len(guesses))
        ends = self.back.walker.reached(home.unknowns, home.known, guesses)
        away = self.back.off(self.back.stated(ends.unknowns, guesses), known)
        told = (ends.shortest > 0.0) & (away < 10 * np.sqrt(self.epsilon))
        if easily:
            conditions = self.back.problem.system.conditions(ends.unknowns, guesses)
            told &= (ends.shortest >= PLAIN) & (conditions < HARD)
        return np.asarray(told)

    def off(self, found: np.ndarray, reached: np.ndarray) -> np.ndarray:
        """Largest differences (n,), over the size or in rad; of quaternions twice that, up to sign;
        of maps but for whole turns.
        """
        if self.places is not None:
            system, turns = self.problem.system, self.asked.kind == "map"
            at = {s.start: c for c, s in zip(system.unknowns, system.slices, strict=True)}
            return self._away(found - reached, [at[int(p)] for p in self.places], turns=turns)
        q, r = found[:, 3:], reached[:, 3:]
        turned = np.minimum(np.max(np.abs(q - r), axis=1), np.max(np.abs(q + r), axis=1))
        moved = np.max(np.abs(found[:, :3] - reached[:, :3]), axis=1) / self.size
        return np.maximum(moved, 2 * turned)

    def _away(
        self, differences: np.ndarray, coordinates: Sequence[Coordinate], *, turns: bool = True
    ) -> np.ndarray:
        """The largest difference of coordinates (n,), over the size or in rad, with `turns` but for
        whole ones.
        """
        angular = np.array([c.is_angular for c in coordinates])
        away = differences / np.where(angular, 1.0, self.size)
        if turns:
            away[:, angular] = np.angle(np.exp(1j * away[:, angular]))
        return np.asarray(np.max(np.abs(away), axis=1))

    def run(
        self, starts: Starts, goals: np.ndarray, rng: np.random.Generator, share: float = _REFUSED
    ) -> Outcome:
        """Asks for all goals; walks the lines of all that are OK, and of a share of the others."""
        answers = self.answers(goals, starts.guesses)
        walked = (answers.status == 0) | (rng.random(len(goals)) < share)
        begins, ends_at = self.line(starts.known, goals)
        parts = self.walker.reached(starts.unknowns[walked], begins[walked], ends_at[walked])
        ends = Ends(starts.unknowns.copy(), np.zeros(len(goals)), np.zeros(len(goals)))
        for key, whole in vars(ends).items():
            whole[walked] = getattr(parts, key)
        begun = Starts(starts.unknowns, begins, starts.guesses)
        return Outcome(begun, ends_at, answers, walked, ends, self._right(ends, ends_at, answers))

    def line(self, known: np.ndarray, goals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Begins and ends of lines: angles begin whole turns away where that is the nearer way
        round and within limits; quaternions are of the same sign and of length one, which those of
        float goals are not quite.
        """
        begin, end, place = known.copy(), goals.copy(), 0
        for c in self.problem.known_coordinates:
            at = slice(place, place + c.width)
            if c.kind == "quaternion":
                opposite = np.sum(begin[:, at] * end[:, at], axis=1, keepdims=True) < 0
                end[:, at] *= np.where(opposite, -1.0, 1.0)
                end[:, at] /= np.linalg.norm(end[:, at], axis=1, keepdims=True)
            elif c.kind == "angle" and not self.asked.mechanism.serial:
                low, high = c.limits or (-np.inf, np.inf)
                turns = np.round((end[:, at] - begin[:, at]) / (2 * np.pi))
                moved = begin[:, at] + 2 * np.pi * turns
                begin[:, at] = np.where((moved >= low) & (moved <= high), moved, begin[:, at])
            place += c.width
        return begin, end

    def _right(self, ends: Ends, goals: np.ndarray, answers: Answers) -> np.ndarray:
        """Whether what is found is where the line leads, but for what rounding makes of the rows
        there. Lines of poses that an arm of few joints cannot take need not lead anywhere: where
        the walk does not arrive, the tool has to be at the goal, and that is where it goes on.
        """
        ok = answers.status == 0
        right = ok & (ends.shortest > 0.0)
        judged = np.flatnonzero(right)
        if len(judged):
            z, known = ends.unknowns[judged], goals[judged]
            off = self.off(answers.found[judged], self.stated(z, known))
            conditions = self.problem.system.conditions(z, known)
            right[judged] = off < _NEAR + ROUNDINGS * self.epsilon * conditions
        if ok.any() and isinstance(self.kind, SerialArm) and not self.kind.keeps_to_lines:
            lost = np.flatnonzero(ok & (ends.shortest == 0.0))
            gaps = self.problem.system.residuals(answers.found[lost], goals[lost]) / self.size
            right[lost] = gaps < _NEAR + ROUNDINGS * self.epsilon
            ends.unknowns[lost] = answers.found[lost]
        return right

    def after(self, outcome: Outcome, other: Starts) -> Starts:
        """Right answers, home where these do not tell where they stand, else other ones."""
        found, goals = outcome.answers.found, outcome.goals
        home = self.home.repeated(len(goals))
        reached = Starts(outcome.ends.unknowns, goals, found).where(outcome.right, other)
        return home.where(outcome.right & ~self.tells(found, goals), reached)


def directions(asked: Asked, longest: float = LONGEST) -> list[Direction]:
    """The problems of a machine's code that take a guess, walked in steps of `longest`, told by
    what solves them: six rods, an arm, limbs by formulas or by Newton's method, a map by either.
    """
    kind, arm = asked.program.kind, asked.mechanism.serial
    if isinstance(kind, JointMap):
        found = []
        for way, function, wanted in (
            (kind.direct, "direct", asked.options.find),
            (kind.inverse, "inverse", asked.options.given),
        ):
            by = f"map {function}, {'formulas' if way.is_closed else 'Newton'}"
            places = np.array([way.problem.system.places[name].start for name in wanted])
            found.append(Direction(asked, way.problem, longest, by, function, places))
        return [replace(one, back=other) for one, other in (found, found[::-1])]
    names = (pose_names if arm else actuated_names)(asked.mechanism)
    closed = isinstance(kind, LimbPlatform) and kind.direct_formulas is not None
    by = f"limbs, {'formulas' if closed else 'Newton'}"
    by = "arm" if arm else "six rods" if isinstance(kind, RodPlatform) else by
    places = np.arange(len(asked.mechanism.actuated)) if arm else None
    return [Direction(asked, build_problem(asked.mechanism, names), longest, by, places=places)]
