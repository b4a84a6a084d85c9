"""Write the C that follows an arm's closed form along the line of tool poses from a guess's to the
given one.

Each step of the closed form decides its joints while a square D stays above zero: the step's
discriminant, or the square of the length that is carried, as a function of the tool's pose and the
joints before. Between two points a, b of the line D stays above zero where its second derivative is
below 2 (D_a + D_b) + 4 min(D_a, D_b). That derivative is bounded by weights times the squares of
the changes of place, turn and joints between the two points: sampled at random configurations,
raised, and taken several times for speeds that change on the way. Parts of the line for which this
holds are kept, others are cut (`guard_text`). Limits of joints are functions of the same kind
(`closed_limits`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closed.evaluation import Evaluation, Motion
from symkin.closed.plan import Plan
from symkin.closed.steps import Carry, Step
from symkin.codegen.arm_motion import ArmMotion
from symkin.codegen.closed_source import ClosedCode
from symkin.codegen.guard_text import GuardText
from symkin.codegen.guards import Bound, Guard
from symkin.codegen.newton_kernel import rounded
from symkin.codegen.text.c import Emitter, Real, indent
from symkin.codegen.text.templates import copy, fill
from symkin.computed_once import cached_property
from symkin.spatial.rotation import multiply

_WAY = 4.0
"""By how much the second derivative of a square may be larger than at constant speed of the joints
that the step reads. Beside its own fold such a joint turns ever faster, without a bound: with 2
lines that all but touch the folds of two joints were OK, with 3 none of 5,000 that approach them.
"""
_NOTHING = 1e-9
"""Bounds below this are rounding."""
_LONGEST = 1.5
"""Longest way of the joints in one part (root of the sum of squares; rad, or of the size): it tells
whole turns.
"""
_LONGER = 1.4
"""By which parts grow where the last one was kept at once: a point costs all of the closed form."""
_SAMPLES = 400
"""Random joint values over which derivatives are bounded."""
_DIRECTIONS = 20
"""Random joint values at which the tool's directions of motion are looked for."""
_ROOM = 1.25
"""By which the largest sampled derivative is raised."""
_LEAST = 256.0
"""Squares below so many roundings decide nothing."""


@dataclass(frozen=True)
class LimitCheck:
    """How the line asks whether joints keep their limits: values of names in its template,
    `members` of its work space, statements where a part is `shorter`, and the functions that these
    call.
    """

    names: dict[str, str]
    text: str
    members: tuple[str, ...] = ()
    shorter: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class ClosedLine:
    """The line check of one arm's closed form."""

    code: ClosedCode
    motion: ArmMotion

    @property
    def plan(self) -> Plan:
        return self.code.plan

    @property
    def real(self) -> Real:
        return self.code.real

    # --- expressions of joint values --------------------------------------------------------------

    @cached_property
    def _x(self) -> ca.SX:
        return ca.SX.sym("x", 7)

    @cached_property
    def _guards(self) -> ca.SX:
        """Of the guarded steps g, where they have two solutions, else g^2; by the half turns and
        the pose that they lead to.
        """
        at, found = self.evaluated(), []
        for i in self.code.guarded:
            step = self.plan.steps[i]
            if step.branch is not None:
                found.append(at.slope(step) / float(np.sqrt(at.discriminant_scale(step))))
            else:
                found.append(at.decide(step, 1.0).strength)
        return ca.vertcat(ca.SX(0, 1), *found)

    def _square(self, at: Evaluation, step: Step) -> ca.SX:
        """g^2 of a step as a function of the tool's pose and the joints before: of F x = y the
        square of y's part across the axis, which has the length of x's, or of x's where y is known.
        """
        decision = at.decide(step, 1.0)
        if step.branch is not None:
            return decision.discriminant
        if not isinstance(step, Carry) or decision.strength.is_constant():
            return decision.strength
        squares = at.across_squares(step)
        return squares[0] if squares[1].is_constant() else squares[1]

    @property
    def ways(self) -> list[str]:
        """What changes along a line."""
        names = [screw.name for screw in self.plan.arm.screws]
        return ["the tool's place (over the size)", "its turn", *names]

    @cached_property
    def guards(self) -> list[Guard]:
        """The squares g^2 of the steps that choose or carry."""
        steps = [self.plan.steps[i] for i in self.code.guarded]
        bounds = self.bounds(lambda at: [self._square(at, step) for step in steps])
        return [
            Guard(step.reason, None, None, (), 1.0, "sampled", (bound,))
            for step, bound in zip(steps, bounds, strict=True)
        ]

    def bounds(self, functions: Callable[[Evaluation], Sequence[ca.SX]]) -> list[Bound]:
        """Bounds of functions D of the tool's pose and of joints, by the squares of the changes of
        the tool's place (over the size) and turn, and of the joints that D reads (angles; slides
        over the size). Sampled.
        """
        screws, size = self.plan.arm.screws, self.plan.arm.size
        n = len(screws)
        q, moved = ca.SX.sym("q", n), ca.SX.sym("d", 6 + n)
        base = ca.vertcat(
            *(
                v
                for i, s in enumerate(screws)
                for v in ((size * q[i], 0) if s.slides else (ca.cos(q[i] / 2), ca.sin(q[i] / 2)))
            )
        )
        pose = ca.substitute(self.motion.pose, self.motion.halves, base)
        turned = multiply(
            ca.vertcat(1 - ca.dot(moved[3:6], moved[3:6]) / 8, 0.5 * moved[3:6]), pose[3:]
        )
        values = [
            size * (q[i] + moved[6 + i]) if s.slides else q[i] + moved[6 + i]
            for i, s in enumerate(screws)
        ]
        motions = {
            i: Motion(v) if screws[i].slides else Motion(v, ca.cos(v), ca.sin(v))
            for i, v in enumerate(values)
        }
        at = replace(
            Evaluation(self.plan.arm, pose[:3] + size * moved[:3], turned), motions=motions
        )
        found = []
        rng = np.random.default_rng(11)
        samples = rng.uniform(-1, 1, (_SAMPLES, n)) * np.array(
            [1.0 if s.slides else np.pi for s in screws]
        )
        for function in functions(at):
            still = [
                ca.densify(ca.substitute(e, moved, ca.DM.zeros(6 + n)))
                for e in (ca.hessian(function, moved)[0], function)
            ]
            bent, values_there = map(
                np.asarray, ca.Function("there", [q], still).map(_SAMPLES)(samples.T)
            )
            matrices = bent.reshape(6 + n, _SAMPLES, 6 + n).transpose(1, 0, 2)
            sums, none = _block_sums(matrices, self._ways(samples)), np.zeros(2 + n)
            weights = 0.5 * _WAY * _ROOM * np.where(sums > _NOTHING, sums, 0.0)
            size = rounded(_ROOM * float(np.max(np.abs(values_there))))
            found.append(Bound(size, weights, none, none))
        return found

    def _ways(self, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Orthonormal columns that span the tool's velocities, and its angular velocities: a
        SCARA's turn about one axis.
        """
        screws = self.plan.arm.screws
        jacobian = ca.Function("jacobian", [self.motion.halves], [self.motion.jacobian])
        halves = [
            [
                v
                for q, s in zip(row, screws, strict=True)
                for v in ((q, 0.0) if s.slides else (np.cos(q / 2), np.sin(q / 2)))
            ]
            for row in samples[:_DIRECTIONS]
        ]
        columns = np.hstack([np.asarray(jacobian(u)) for u in halves])
        return _span(columns[:3]), _span(columns[3:])

    def evaluated(self) -> Evaluation:
        """The arm at the half turns and the pose that they lead to."""
        return replace(
            Evaluation(self.plan.arm, self._x[:3], self._x[3:]), motions=self.motion.motions
        )

    def emitter(self, expressions: ca.SX) -> Emitter:
        """Emitter of functions of the half turns `u` and of the pose `x` that they lead to."""
        return self.motion.emitter(expressions, self._x)

    # --- text -------------------------------------------------------------------------------------

    @cached_property
    def guard_text(self) -> GuardText:
        return GuardText(self.guards, self.real, measures=True)

    @property
    def _read_lines(self) -> list[str]:
        """Statements that set margins and bits."""
        emitter, number, zero = self.emitter(self._guards), 0, self.real.literal(0.0)
        choices = [i for i, step in enumerate(self.plan.steps) if step.branch is not None]
        for k, i in enumerate(self.code.guarded):
            emitter.comment(self.plan.steps[i].reason)
            text = emitter.value(0, k)
            emitter.lines.append(
                f"margin[{k}] = {text} * {text};" if i in choices else f"margin[{k}] = {text};"
            )
            if i in choices:
                number = choices.index(i)
                emitter.lines.append(
                    f"wanted |= ({text} < {zero}) ? {2 << (2 * number)}U : {1 << (2 * number)}U;"
                )
        return emitter.lines

    @property
    def per_lengths(self) -> str:
        """What makes joint values numbers of the order of one, joint by joint."""
        return ", ".join(
            self.real.literal(1.0 / self.plan.arm.size if s.slides else 1.0)
            for s in self.plan.arm.screws
        )

    def text(self, limits: LimitCheck) -> str:
        """The functions, which need those of the closed form."""
        literal, size, p = self.real.literal, self.plan.arm.size, self.code.values["P"]
        names = (
            self.code.names
            | {
                "k": f"{self.code.values['p']}_inverse",
                "nto": len(self.ways),
                "nat": 7,
                "nways": 2,
                "turns": 2 * len(self.plan.arm),
                "read": indent(self._read_lines),
                "longest2": literal(_LONGEST**2),
                "per_lengths": self.per_lengths,
                "per_size2": literal(size**-2),
                "size2": literal(size**2),
                "least": literal(_LEAST * self.real.epsilon),
                "eight": literal(8.0),
                "turn_noise": literal(4.0 * self.real.epsilon),
                "aimed": f"unsigned int wanted, {self.real.type} most2, ",
                "take": indent(copy("w->joints", "w->found[0]", len(self.plan.arm)), 3),
                "longer": f"{literal(_LONGER)} * part",
                "and_follows": f" && {self.code.values['p']}_inverse_follows(w, change, most2)",
            }
            | limits.names
        )
        names |= {
            "members": indent([*self.guard_text.members, *limits.members]),
            "ways": fill("line_of_poses.c", names),
            "unreached": (
                f"((reached == {p}_SINGULAR) || ((reached == {p}_OUT_OF_RANGE) && (end >= "
                f"{literal(1.0)}))) ? reached : {p}_WRONG_BRANCH"
            ),
            "shorter": indent([*self.guard_text.shorter_lines, *limits.shorter], 3),
        }
        aim = fill("point_of_poses.c", names).split("\n")
        walk = self.guard_text.text(names, aim, 1.0)
        return limits.text + fill("closed_line.c", names | {"walk": walk})


def _span(columns: np.ndarray) -> np.ndarray:
    """Orthonormal columns (3, rank) that span all columns."""
    vectors, values, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(vectors[:, values > _NOTHING * max(1.0, float(values.max()))])


def _block_sums(matrices: np.ndarray, ways: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Weights w of d' H d <= w_1 |d_1|^2 + ..., for matrices H (count, n, n) whose blocks are the
    first three and the next three variables, which go only in the directions of `ways`, and each
    other one.
    """
    count = matrices.shape[1] - 6
    parts = [np.zeros((matrices.shape[1], way.shape[1])) for way in ways] + [
        np.eye(matrices.shape[1])[:, 6 + i : 7 + i] for i in range(count)
    ]
    parts[0][:3], parts[1][3:6] = ways
    sums = np.zeros((len(matrices), len(parts)))
    for i, rows in enumerate(parts):
        for j, columns in enumerate(parts):
            part = rows.T @ matrices @ columns
            if part.size == 0:
                continue
            if i == j:
                sums[:, i] += np.maximum(np.linalg.eigvalsh(part)[:, -1], 0.0)
            else:
                sums[:, i] += np.linalg.norm(part, ord=2, axis=(1, 2))
    return np.asarray(sums.max(axis=0))
