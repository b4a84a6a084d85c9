"""Ask the generated C for goals from guesses, and walk the same lines finely beside it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from asked import STATUSES, Answers, Asked
from continuation import Ends, Walker
from goals import Reach, goals_about
from symkin.codegen.options import Options
from symkin.codegen.program import Kind
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.text.c import Real
from symkin.model.mechanism import Mechanism
from symkin.position.canonical import poses_of
from symkin.position.problem import Problem, build_problem

REGULAR = 1.0 / 25600
"""A line that needs shorter steps than this part of it passes too near a singularity to be called
regular.
"""
_REFUSED = 0.2
"""Refused goals that are walked too, as a part of all goals: they tell how many regular lines are
OK.
"""
_BESIDE = {"double": 6.0, "float": 2.5}
"""Guesses beside a fold lie at most ten to this power nearer to it than the line was long."""
_OUT_OF_RANGE = STATUSES.index("OUT_OF_RANGE")


@dataclass(frozen=True)
class Starts:
    """Where lines begin: unknowns, known values, and the same as the generated code's guesses."""

    unknowns: np.ndarray
    known: np.ndarray
    guesses: np.ndarray

    def where(self, chosen: np.ndarray, other: Starts) -> Starts:
        """These where chosen, else the other ones."""
        pairs = (
            (self.unknowns, other.unknowns),
            (self.known, other.known),
            (self.guesses, other.guesses),
        )
        return Starts(*(np.where(chosen[:, None], mine, yours) for mine, yours in pairs))


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
        return np.asarray(
            self.walked & (self.ends.shortest >= REGULAR) & (self.answers.status != _OUT_OF_RANGE)
        )


@dataclass(frozen=True, eq=False)
class Lines:
    """The lines of one mechanism's generated C: of joint values for platforms, of tool poses for
    arms.
    """

    mechanism: Mechanism
    options: Options

    @property
    def kind(self) -> Kind:
        return self.asked.program.kind

    @cached_property
    def problem(self) -> Problem:
        return build_problem(self.mechanism, "inverse" if self.mechanism.serial else "direct")

    @cached_property
    def asked(self) -> Asked:
        return Asked(self.mechanism, self.options)

    @cached_property
    def walker(self) -> Walker:
        return Walker(self.problem)

    def home(self, count: int) -> Starts:
        """Home, `count` times; of an arm the first of its samples, which is regular."""
        kind, problem = self.kind, self.problem
        if isinstance(kind, SerialArm):
            joints, pose = kind.samples[0]
            return Starts(*(np.tile(v, (count, 1)) for v in (joints, pose, joints)))
        # code may be of another machine that the mechanism means: its home is the reference then
        alike = kind.mechanism == problem.mechanism
        values = kind.home_values if alike else problem.closure.reference
        unknowns = problem.select_values(values, problem.system.unknowns)
        known = problem.select_values(values, problem.known_coordinates)
        return Starts(
            *(
                np.tile(v, (count, 1))
                for v in (unknowns, known, self.stated(unknowns[None], known[None])[0])
            )
        )

    def stated(self, unknowns: np.ndarray, known: np.ndarray) -> np.ndarray:
        """What the generated code finds at configurations: poses, or an arm's joint values."""
        if self.mechanism.serial:
            return unknowns
        return np.hstack(poses_of(self.problem.closure, self.problem.join_values(unknowns, known)))

    def goals(self, count: int, reach: Reach, rng: np.random.Generator) -> np.ndarray:
        """Goals as the C's numbers are."""
        return goals_about(self.kind, count, reach, rng).astype(self.asked.number).astype(float)

    def run(self, starts: Starts, goals: np.ndarray, rng: np.random.Generator) -> Outcome:
        """Asks for all goals; walks the lines of all that are OK, and of some that are not."""
        answers = self.asked.answers(goals, starts.guesses)
        walked = (answers.status == 0) | (rng.random(len(goals)) < _REFUSED)
        begins, ends_at = self.line(starts.known, goals)
        parts = self.walker.reached(starts.unknowns[walked], begins[walked], ends_at[walked])
        ends = Ends(starts.unknowns.copy(), np.zeros(len(goals)), np.zeros(len(goals)))
        for whole, part in (
            (ends.unknowns, parts.unknowns),
            (ends.done, parts.done),
            (ends.shortest, parts.shortest),
        ):
            whole[walked] = part
        begun = Starts(starts.unknowns, begins, starts.guesses)
        return Outcome(begun, ends_at, answers, walked, ends, self._right(ends, ends_at, answers))

    def line(self, known: np.ndarray, goals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Begins and ends of lines: angles the nearer way round and within limits, quaternions of
        the same sign and of length one, which those of float goals are not quite.
        """
        begin, end, place = known.copy(), goals.copy(), 0
        for c in self.problem.known_coordinates:
            at = slice(place, place + c.width)
            if c.kind == "quaternion":
                end[:, at] *= np.where(np.sum(begin[:, at] * end[:, at], axis=1) < 0, -1.0, 1.0)[
                    :, None
                ]
                end[:, at] /= np.linalg.norm(end[:, at], axis=1, keepdims=True)
            elif c.kind == "angle" and not self.mechanism.serial:
                turns = 2 * np.pi * np.round((end[:, place] - begin[:, place]) / (2 * np.pi))
                if c.limits is None:
                    end[:, place] -= turns
                else:
                    moved = begin[:, place] + turns
                    begin[:, place] = np.where(
                        (moved >= c.limits[0]) & (moved <= c.limits[1]), moved, begin[:, place]
                    )
            place += c.width
        return begin, end

    def _right(self, ends: Ends, goals: np.ndarray, answers: Answers) -> np.ndarray:
        """Whether what is found is where the line leads, but for what rounding makes of the rows
        there: 16 units in the last place times the condition, and 2e-7 of the size.
        """
        right = (answers.status == 0) & (ends.shortest > 0.0)
        judged = np.flatnonzero(right)
        if len(judged):
            z, known, size = (
                ends.unknowns[judged],
                goals[judged],
                self.mechanism.characteristic_length,
            )
            off = self.distance(answers.found[judged], self.stated(z, known))
            epsilon = Real(self.options.real).epsilon
            right[judged] = off < size * (
                2e-7 + 16 * epsilon * self.problem.system.conditions(z, known)
            )
        return right

    def distance(self, found: np.ndarray, reached: np.ndarray) -> np.ndarray:
        """Largest differences (n,), angles times the size; of quaternions, twice that, up to
        sign.
        """
        size = self.mechanism.characteristic_length
        if self.mechanism.serial:
            scale = np.array([size if c.is_angular else 1.0 for c in self.mechanism.actuated])
            return np.asarray(np.max(np.abs(found - reached) * scale, axis=1))
        q, r = found[:, 3:], reached[:, 3:]
        turned = np.minimum(np.max(np.abs(q - r), axis=1), np.max(np.abs(q + r), axis=1))
        return np.maximum(np.max(np.abs(found[:, :3] - reached[:, :3]), axis=1), 2 * size * turned)

    def after(self, outcome: Outcome, home: Starts) -> Starts:
        """Right answers, else home."""
        reached = Starts(outcome.ends.unknowns, outcome.goals, outcome.answers.found)
        return reached.where(outcome.right, home)

    def beside_folds(self, outcome: Outcome, home: Starts, rng: np.random.Generator) -> Starts:
        """Guesses short of the folds at which lines stopped, where the code's other problem gives
        their known values back; else home.
        """
        stopped = outcome.walked & (outcome.ends.shortest == 0.0) & (outcome.ends.done > 0.0)
        nearer = 10.0 ** -rng.uniform(1.0, _BESIDE[self.options.real], len(stopped))
        part = (outcome.ends.done * (1.0 - nearer))[:, None]
        begin = outcome.starts.known
        known = begin + part * (outcome.goals - begin)
        z, good = home.unknowns.copy(), np.zeros(len(stopped), dtype=bool)
        if stopped.any():
            parts = self.walker.reached(
                outcome.starts.unknowns[stopped], begin[stopped], known[stopped]
            )
            z[stopped], good[stopped] = parts.unknowns, parts.shortest > 0.0
        starts = Starts(z, known, self.stated(z, known))
        return starts.where(good & self.gives_back(starts.guesses, known), home)

    def gives_back(self, found: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Whether the code's other problem gives known values back for what it should find: else a
        limb stands beyond a dead centre.
        """
        status, back = self.asked.back(found.astype(self.asked.number).astype(float))
        if self.mechanism.serial:
            return np.ones(len(found), dtype=bool)
        size, epsilon = self.mechanism.characteristic_length, Real(self.options.real).epsilon
        off = back - known
        for i, c in enumerate(self.mechanism.actuated):
            off[:, i] = (
                size * np.remainder(off[:, i] + np.pi, 2 * np.pi) - size * np.pi
                if c.is_angular
                else off[:, i]
            )
        return np.asarray((status == 0) & (np.max(np.abs(off), axis=1) < size * np.sqrt(epsilon)))
