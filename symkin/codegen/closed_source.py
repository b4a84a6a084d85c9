"""Write the C of an arm's closed form: all branches of the inverse problem in one function of
nested loops, one loop a choice.

The statements of a step stand in the loops of the choices before it, so that what branches share is
computed once. `near` holds cosine and sine of a guess's angle (or its slide) for each choice; a
choice whose bits in `wanted` are zero takes the solution that is nearest to it: of A cos q + B sin
q = C the one on the side of the guess g that A sin g - B cos g tells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closed.evaluation import Decision, Evaluation
from symkin.closed.geometry import across
from symkin.closed.plan import Plan, forward
from symkin.closed.steps import TOOL, Factor, Operand, Step, Word
from symkin.codegen.steps.newton_source import NewtonCode
from symkin.codegen.text.c import Emitter, Real, indented_by_braces, indexed
from symkin.codegen.text.templates import fill
from symkin.codegen.text.turns import angle_of_direction, rough_sine
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.text import c_comment

LEAST = 256.0
"""Discriminants and strengths (squares over the size's) below so many roundings decide nothing."""
_TRIED, SAME = 8, 1e-9
"""Random joint values at which squares are compared, and the relative difference of equal ones."""
_FINISH_STEPS, _FINISH_REACH = 6, 0.5
"""Newton steps from a nearly equal arm's branch, and the longest one (of the size)."""
_NEARLY_CLOSED = (
    " The axes are only nearly as the formulas ask, and Newton's method goes on from these: "
    "solutions may be MISSING, all of them too, near where two of them meet."
)
_MOST_TURNS = 1e4
"""Whole turns beyond which an angle is not moved: a float of them tells no angle."""


@dataclass(frozen=True, eq=False)
class _Written:
    """A step as expressions: what it decides by, and, of a choice, which side the guess is on."""

    step: Step
    decision: Decision
    lean: ca.SX


@dataclass(frozen=True)
class Square:
    """What a step keeps above zero: `times` the square of this number among those that are watched
    (None: 1), which is the step's `own` or that of one before.
    """

    number: int | None
    times: float
    own: bool = False


def _own(squares: list[Square]) -> list[int]:
    return [i for i, square in enumerate(squares) if square.own]


@dataclass(frozen=True, eq=False)
class ClosedCode:
    """The closed form of one arm; `misfit`: the largest error of an answer's pose, as a length;
    `newton`: where the plan is that of an arm whose axes are nearly these, the method that has to
    finish.
    """

    plan: Plan
    coordinates: tuple[Coordinate, ...]
    real: Real
    values: dict[str, object]
    misfit: float
    newton: NewtonCode | None

    # --- expressions ------------------------------------------------------------------------------

    @cached_property
    def _pose(self) -> ca.SX:
        return ca.SX.sym("x", 7)

    @cached_property
    def _signs(self) -> ca.SX:
        return ca.SX.sym("s", len(self.plan.branches))

    @cached_property
    def _near(self) -> ca.SX:
        return ca.SX.sym("g", 2 * len(self.plan.branches))

    @cached_property
    def _steps(self) -> tuple[list[_Written], Evaluation]:
        at, found, number = Evaluation(self.plan.arm, self._pose[:3], self._pose[3:]), [], 0
        for step in self.plan.steps:
            sign, lean = ca.SX(1), ca.SX(0)
            if step.branch is not None:
                sign, lean = (
                    self._signs[number],
                    at.lean(step, self._near[2 * number], self._near[2 * number + 1]),
                )
                number += 1
            decision = at.decide(step, sign)
            found.append(_Written(step, decision, lean))
            at = at.decided(step.joints, decision.motions)
        return found, at

    def _gap(self, at: Evaluation) -> ca.SX:
        """Square of how far the joints' tool pose is from the given one: origin, and two directions
        times the size, one of which is an axis, since fewer joints turn it.
        """
        chain: Word = tuple(Factor(i) for i in range(len(self.plan.arm)))
        total = ca.SX(0)
        x, y, z = (float(v) for v in np.asarray(self.plan.arm.tool.position))
        axis = next(
            (s.axis for s in reversed(self.plan.arm.screws) if not s.slides), (0.0, 0.0, 1.0)
        )
        for operand in (
            Operand((x, y, z), True),
            Operand(axis, False),
            Operand(across(axis)[0], False),
        ):
            gap = at.value(operand.carried(chain)) - at.value(operand.carried((Factor(TOOL),)))
            total += (1.0 if operand.is_point else self.plan.arm.size**2) * ca.dot(gap, gap)
        return total

    @cached_property
    def is_checked(self) -> bool:
        """Whether branches are held against the pose: those of arms of fewer than six joints need
        not meet all of it.
        """
        return len(self.plan.arm) < 6 and self.newton is None

    def _emitter(self, signs: Sequence[str], *, is_line: bool = False) -> Emitter:
        """Emitter of what the steps decide by, how far the joints' pose is from the given one, and
        the joint values, or, on a line, their pairs.
        """
        written, at = self._steps
        outputs = [
            e for w in written for e in (w.decision.strength, w.decision.discriminant, w.lean)
        ]
        motions = [at.motions[i] for i in range(len(self.plan.arm))]
        values = [m.value + s.zero for m, s in zip(motions, self.plan.arm.screws, strict=True)]
        told = [e for motion in motions for e in motion.pair] if is_line else values
        symbols = [self._pose, self._signs, self._near]
        gap = self._gap(at) if self.is_checked else ca.SX(0)
        expression = ca.vertcat(*outputs, gap, *told)
        texts = ["x", signs, indexed("near", 2 * len(signs))]
        return Emitter.of(self.real, list(zip(symbols, texts, strict=True)), expression)

    @cached_property
    def squares(self) -> list[Square]:
        """What each step keeps above zero: a number, or a multiple of a square that is watched."""
        values, found = self._squares_at, list[Square]()
        for i in range(len(self.plan.steps)):
            shares = [(values[:, i] / values[:, j], k) for k, j in enumerate(_own(found))]
            same = [Square(k, float(s[0])) for s, k in shares if np.ptp(s) <= SAME * abs(s[0])]
            if np.ptp(values[:, i]) <= SAME * abs(values[0, i]):
                found.append(Square(None, float(values[0, i])))
            else:
                found.append(same[0] if same else Square(len(_own(found)), 1.0, own=True))
        return found

    @property
    def _squares_at(self) -> np.ndarray:
        """Squares (_TRIED, steps) at random joint values."""
        n, rows = len(self.plan.arm), []
        pose, joints = ca.SX.sym("x", 7), ca.SX.sym("q", n)
        at = self.plan.at(pose, joints)
        squares = [
            decision.strength if step.branch is None else decision.discriminant
            for step in self.plan.steps
            for decision in [at.decide(step, 1.0)]
        ]
        function = ca.Function("squares", [pose, joints], [ca.vertcat(*squares)])
        rng, arm = np.random.default_rng(3), self.plan.arm
        for _ in range(_TRIED):
            values = rng.uniform(-3.0, 3.0, n) * [arm.size if s.slides else 1.0 for s in arm.screws]
            there = forward(arm, values)
            told = values + [s.zero for s in arm.screws]
            rows.append(np.asarray(function([*there.position, *there.quaternion], told)).ravel())
        return np.array(rows)

    @property
    def guarded(self) -> list[int]:
        """Numbers of the steps that could decide nothing, or of which two solutions could meet; of
        several where the same square vanishes, the first.
        """
        return _own(self.squares)

    # --- text -------------------------------------------------------------------------------------

    @cached_property
    def body(self) -> list[str]:
        """Statements of the function of all branches."""
        emitter, n = self._emitter([f"sign{i}" for i in range(len(self.plan.branches))]), 0
        opened, first = list[str](), 3 * len(self.plan.steps) + 1
        joints: dict[int, str] = {}
        for i, step in enumerate(self.plan.steps):
            opened += self._conditions(emitter, i, "*undecided = true;")
            if i in self.guarded:
                square = self._square(emitter, i)
                emitter.lines.append(f"margin[{self.guarded.index(i)}] = {square};")
            if step.branch is not None:
                emitter.lines += self._choice_lines(n, emitter.value(0, 3 * i + 2))
                opened += ["}", "}"]
                n += 1
            joints |= {k: emitter.value(0, first + k) for k in step.joints}
        found = [f"found[count][{k}] = {joints[k]};" for k in range(len(self.plan.arm))]
        text = "\n".join(self._closed_text(emitter, opened, [*found, "++count;"]))
        if self.real.name == "float":
            text = text.replace("atan2f(", "atan2(")
        return indented_by_braces(text.split("\n"))

    @property
    def line_body(self) -> list[str]:
        """Statements that set the pairs and squares of one branch at a point of a line, whose signs
        are known, and the status.
        """
        emitter = self._emitter(indexed("w->sign", len(self.plan.branches)), is_line=True)
        n = len(self.plan.arm)
        opened = list[str]()
        for i in range(len(self.plan.steps)):
            opened += self._conditions(emitter, i, "status = NAME_SINGULAR;")
        squares = {f"w->guard[{k}]": self._square(emitter, i) for k, i in enumerate(self.guarded)}
        first = 3 * len(self.plan.steps) + 1
        pairs = {f"w->aimed[{k // 2}][{k % 2}]": emitter.value(0, first + k) for k in range(2 * n)}
        told = [f"{target} = {text};" for target, text in (squares | pairs).items()]
        closed = self._closed_text(emitter, opened, [*told, "status = NAME_OK;"])
        return indented_by_braces("\n".join(closed).split("\n"))

    def _conditions(self, emitter: Emitter, i: int, undecided: str) -> list[str]:
        """Add what must hold before a step's solutions are formed; what is said where it does not:
        nothing decides the joint, two solutions meet, or there is none.
        """
        least, opened = LEAST * self.real.epsilon, list[str]()
        emitter.comment(self.plan.steps[i].reason)
        strength = emitter.value(0, 3 * i)
        if not _is_number(strength):
            emitter.lines.append(f"if ({strength} > {least}) {{")
            opened.append(f"}} else {{\n{undecided}\n}}")
        text = emitter.value(0, 3 * i + 1)
        if not _is_number(text):
            emitter.lines.append(f"if ({text} > {least}) {{")
            opened.append(
                f"}} else if ({text} > -{least}) {{\n{undecided}\n}} else {{\n/* out of reach */\n"
                f"}}"
            )
        return opened

    def _closed_text(
        self, emitter: Emitter, opened: list[str], innermost: Sequence[str]
    ) -> list[str]:
        """All statements, the innermost ones where the joints meet the pose, each bracket
        closed.
        """
        if self.is_checked:
            gap = emitter.value(0, 3 * len(self.plan.steps))
            emitter.lines.append(f"if ({gap} < {self.misfit**2}) {{")
            opened = [*opened, "}"]
        return [*emitter.lines, *innermost, *reversed(opened)]

    def _square(self, emitter: Emitter, i: int) -> str:
        """C text of a square that is zero where a step is not decided: what `ClosedLine`
        follows.
        """
        return emitter.value(0, 3 * i + (self.plan.steps[i].branch is not None))

    def _choice_lines(self, number: int, lean: str) -> list[str]:
        """The loop over the solutions of one choice."""
        k = f"k{number}"
        return [
            f"const unsigned int bits{number} = (wanted >> {2 * number}U) & 3U;",
            f"const unsigned int side{number} = ({lean} < 0.0) ? 2U : 1U;",
            f"for (unsigned int {k} = 1U; {k} <= 2U; ++{k}) {{",
            f"if ((((bits{number} != 0U) ? bits{number} : side{number}) & {k}) != 0U) {{",
            f"const real sign{number} = ({k} == 1U) ? 1.0 : -1.0;",
        ]

    @property
    def _near_lines(self) -> list[str]:
        """Statements that set `near` from a guess."""
        lines, number = [], 0
        for step in self.plan.steps:
            if step.branch is None:
                continue
            (joint,) = step.joints
            screw = self.plan.arm.screws[joint]
            value = f"guess[{joint}]" + (f" - {screw.zero}" if screw.zero else "")
            cosine = value if screw.slides else f"name_sine({value} + 1.5707963267948966)"
            lines += [f"near[{2 * number}] = {cosine};"]
            lines += [] if screw.slides else [f"near[{2 * number + 1}] = name_sine({value});"]
            number += 1
        # what no statement reads is not computed
        text = "\n".join(self.body)
        return [line for line in lines if line.split(" = ")[0] in text]

    @property
    def names(self) -> dict[str, object]:
        names = self.plan.branches
        spans = [c.limits for c in self.coordinates]
        middles = [0.5 * (s[0] + s[1]) if s else 0.0 for s in spans]
        named = [
            f"wanted |= ((branch & {1 << (len(names) - 1 - i)}U) != 0U) ? {2 << (2 * i)}U : "
            f"{1 << (2 * i)}U;"
            for i in range(len(names))
        ]
        both = sum(3 << (2 * i) for i in range(len(names)))
        return self.values | {
            "branches": self.plan.count,
            "choices": max(len(names), 1),
            "nears": max(2 * len(names), 1),
            "both": f"{both}U",
            "margins": max(len(self.guarded), 1),
            "body": self.body,
            "near": self._near_lines,
            "nn": len(self.plan.arm),
            "angular": tuple(c.is_angular for c in self.coordinates),
            "middles": tuple(middles),
            "many": _MOST_TURNS,
            "sine": rough_sine(self.real),
            "named": named,
        }

    @property
    def text(self) -> str:
        """All functions of the closed form."""
        sine = (
            fill("closed_trigonometry.c", self.names)
            if any("_sine(" in line for line in self._near_lines)
            else ""
        )
        angle = angle_of_direction(self.real, self.names, "".join(self.body))
        return angle + sine + fill("closed.c", self.names | {"finish": self._finish})

    @property
    def _finish(self) -> str:
        if self.newton is None:
            return fill("closed_hold.c", self.names | {"answer_rounding": self.misfit})
        size = self.plan.arm.size
        own = {"most_steps": _FINISH_STEPS, "longest2": (_FINISH_REACH * size) ** 2}
        return fill("closed_finish.c", self.newton.factoring | self.names | own)

    @property
    def header(self) -> str:
        """The declarations, with the names of the choices."""
        prefix, names = self.values["P"], self.plan.branches
        flags = [
            f"#define {prefix}_{name.upper()} ({1 << (len(names) - 1 - i)}U) /* the other solution "
            f"of joint {c_comment(self._joint_of(i))} */"
            for i, name in enumerate(names)
        ]
        nearly = "" if self.newton is None else _NEARLY_CLOSED
        return fill("closed.h", self.names | {"flags": "\n".join(flags), "nearly": nearly})

    def _joint_of(self, number: int) -> str:
        (joint,) = [step for step in self.plan.steps if step.branch is not None][number].joints
        return self.plan.arm.screws[joint].name

    @property
    def derivation(self) -> str:
        """The section of the README."""
        lines = [f"{i}. {line}." for i, line in enumerate(self.plan.derivation(), start=1)]
        return "\n".join(lines)


def _is_number(text: str) -> bool:
    return text[0].isdigit()
