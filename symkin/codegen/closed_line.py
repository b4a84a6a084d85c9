"""Write the C that follows an arm's closed form along the line of tool poses from a guess's to the given one.

Each step of the closed form decides its joints by a function g that vanishes only where the step decides nothing or two solutions
meet: |g| is a root of the step's discriminant or strength. As functions of the joint values these g have bounded derivatives. On
a line that meets such a point between two regular ones the joints come from one side and leave on the other, or the step's
discriminant bends down to zero and back while the joints of the steps before move: either takes a way of joints of at least
(|g_a| + |g_b|) / L. Parts between points of the line whose joints are nearer than that are kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closed.evaluation import Evaluation, Motion
from symkin.closed.plan import Plan
from symkin.closed.steps import Carry, Step
from symkin.codegen.arm_motion import ArmMotion
from symkin.codegen.c_emitter import Real, indent
from symkin.codegen.c_templates import fill
from symkin.codegen.closed_source import ClosedCode
from symkin.codegen.newton_kernel import rounded
from symkin.computed_once import cached_property
from symkin.spatial.rotation import multiply

WAY = 2.0
"""By how much the second derivative of a square may be larger than at constant speed of the joints that the step reads."""
_NOTHING = 1e-9
"""Bounds below this are rounding."""
_LONGEST = 1.5
"""Longest way of the joints in one part (root of the sum of squares; rad, or of the size): it tells whole turns."""
_LEAST_PART = 2.0**-12
"""Shortest part of a line."""
_SAMPLES = 400
"""Random joint values over which derivatives are bounded."""
_ROOM = 1.25
"""By which the largest sampled derivative is raised."""
_LEAST = 256.0
"""Squares below so many roundings decide nothing."""


@dataclass(frozen=True, eq=False)
class ClosedLine:
    """The line check of one arm's closed form; `rounding` bounds the error of an answer's pose, as a length."""

    code: ClosedCode
    motion: ArmMotion
    rounding: float

    @property
    def plan(self) -> Plan:
        return self.code.plan

    @property
    def real(self) -> Real:
        return self.code.real

    # --- expressions of joint values --------------------------------------------------------------------------------------

    @cached_property
    def _x(self) -> ca.SX:
        return ca.SX.sym("x", 7)

    @cached_property
    def _guards(self) -> ca.SX:
        """Of the guarded steps g, where they have two solutions, else g^2; by the half turns and the pose that they lead to."""
        pose = self._x
        at = replace(Evaluation(self.plan.arm, pose[:3], pose[3:]), motions=self.motion.motions)
        found = []
        for i in self.code.guarded:
            step = self.plan.steps[i]
            if step.branch is not None:
                found.append(at.slope(step) / float(np.sqrt(at.discriminant_scale(step))))
            else:
                found.append(at.decide(step, 1.0).strength)
        return ca.vertcat(ca.SX(0, 1), *found)

    def _square(self, at: Evaluation, step: Step) -> ca.SX:
        """g^2 of a step as a function of the tool's pose and the joints before: of F x = y the square of y's part across the axis, which
        has the length of x's, or of x's where y is known."""
        decision = at.decide(step, 1.0)
        if step.branch is not None:
            return decision.discriminant
        if not isinstance(step, Carry) or decision.strength.is_constant():
            return decision.strength
        squares = at.across_squares(step)
        return squares[0] if squares[1].is_constant() else squares[1]

    @cached_property
    def bends(self) -> np.ndarray:
        """Bounds (guards, 2 + joints) of the squares g^2: |d^2 g^2 / ds^2| is at most the sum of these times the squares of the rates
        of the tool's place (over the size) and turn, and of the joints that the step reads (angles; slides over the size). Sampled."""
        screws, size = self.plan.arm.screws, self.plan.arm.size
        n = len(screws)
        q, moved = ca.SX.sym("q", n), ca.SX.sym("d", 6 + n)
        base = ca.vertcat(
            *(v for i, s in enumerate(screws) for v in ((size * q[i], 0) if s.slides else (ca.cos(q[i] / 2), ca.sin(q[i] / 2))))
        )
        pose = ca.substitute(self.motion.pose, self.motion.halves, base)
        turned = multiply(ca.vertcat(1 - ca.dot(moved[3:6], moved[3:6]) / 8, 0.5 * moved[3:6]), pose[3:])
        values = [size * (q[i] + moved[6 + i]) if s.slides else q[i] + moved[6 + i] for i, s in enumerate(screws)]
        motions = {i: Motion(v) if screws[i].slides else Motion(v, ca.cos(v), ca.sin(v)) for i, v in enumerate(values)}
        at = replace(Evaluation(self.plan.arm, pose[:3] + size * moved[:3], turned), motions=motions)
        bounds = []
        rng = np.random.default_rng(11)
        samples = rng.uniform(-1, 1, (_SAMPLES, n)) * np.array([1.0 if s.slides else np.pi for s in screws])
        for i in self.code.guarded:
            step = self.plan.steps[i]
            square = self._square(at, step)
            hessian = ca.substitute(ca.hessian(square, moved)[0], moved, ca.DM.zeros(6 + n))
            found = ca.Function("hessian", [q], [ca.densify(hessian)]).map(_SAMPLES)(samples.T)
            matrices = np.asarray(found).reshape(6 + n, _SAMPLES, 6 + n).transpose(1, 0, 2)
            bounds.append(_ROOM * _block_sums(matrices))
        return np.array(bounds).reshape(-1, 2 + n)

    # --- text ------------------------------------------------------------------------------------------------------------

    @property
    def _read_lines(self) -> list[str]:
        """Statements that set margins and bits."""
        emitter, number, zero = self.motion.emitter(self._guards, self._x), 0, self.real.literal(0.0)
        choices = [i for i, step in enumerate(self.plan.steps) if step.branch is not None]
        for k, i in enumerate(self.code.guarded):
            emitter.comment(self.plan.steps[i].reason)
            text = emitter.value(0, k)
            emitter.lines.append(f"margin[{k}] = {text} * {text};" if i in choices else f"margin[{k}] = {text};")
            if i in choices:
                number = choices.index(i)
                emitter.lines.append(f"wanted |= ({text} < {zero}) ? {2 << (2 * number)}U : {1 << (2 * number)}U;")
        return emitter.lines

    @property
    def _bend_lines(self) -> list[str]:
        """Statements that say whether each square stays above zero: `place` and `turn` are squares of the tool's way."""
        lines = []
        for k, (row, i) in enumerate(zip(WAY * self.bends, self.code.guarded, strict=True)):
            squares = ["place", "turn", *(f"moved[{j}]" for j in range(len(self.plan.arm)))]
            terms = [
                f"{self.real.literal(rounded(w))} * {square}" for w, square in zip(row, squares, strict=True) if w > _NOTHING
            ]
            sum_of = " + ".join(terms) or self.real.literal(0.0)
            lines += [
                f"/* {self.plan.steps[i].reason} */",
                f"const {self.real.type} bend{k} = {sum_of};",
                f"const {self.real.type} lesser{k} = (a[{k}] < b[{k}]) ? a[{k}] : b[{k}];",
                f"const {self.real.type} share{k} = bend{k} / ({self.real.literal(2.0)} * (a[{k}] + b[{k}]) + {self.real.literal(4.0)} * lesser{k});",
                f"largest = (share{k} > largest) ? share{k} : largest;",
            ]
        return lines

    @property
    def text(self) -> str:
        """The functions, which need those of the closed form."""
        literal, size = self.real.literal, self.plan.arm.size
        names = self.code.names | {
            "turns": 2 * len(self.plan.arm), "read": indent(self._read_lines),
            "bends": indent(self._bend_lines), "longest2": literal(_LONGEST**2),
            "per_lengths": ", ".join(literal(1.0 / size if s.slides else 1.0) for s in self.plan.arm.screws),
            "per_size2": literal(size**-2), "size2": literal(size**2), "least": literal(_LEAST * self.real.epsilon),
            "eight": literal(8.0), "quick": literal(0.2), "usual": literal(0.6), "shorter": literal(0.75), "far_shorter": literal(0.25), "near_one": literal(0.999), "turn_noise": literal(4.0 * self.real.epsilon), "least_part": literal(_LEAST_PART), "answer_rounding": literal(self.rounding), "huge": self.code.values["huge"],
        }  # fmt: skip
        return fill("closed_line.c", names)


def _block_sums(matrices: np.ndarray) -> np.ndarray:
    """Weights w of d' H d <= w_1 |d_1|^2 + ..., for matrices H (count, n, n) whose blocks are the first three and the next three
    variables, and each other one."""
    n = matrices.shape[1]
    blocks = [slice(0, 3), slice(3, 6), *(slice(i, i + 1) for i in range(6, n))]
    sums = np.zeros((len(matrices), len(blocks)))
    for i, rows in enumerate(blocks):
        for j, columns in enumerate(blocks):
            part = matrices[:, rows, columns]
            if i == j:
                sums[:, i] += np.maximum(np.linalg.eigvalsh(part)[:, -1], 0.0)
            else:
                sums[:, i] += np.linalg.norm(part, ord=2, axis=(1, 2))
    return np.asarray(sums.max(axis=0))
