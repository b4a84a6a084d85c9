"""Write the C that follows an arm's closed form along the line of tool poses from a guess's to the
given one.

Each step of the closed form decides its joints while a square D stays above zero: the step's
discriminant, or the square of the length that is carried, as a function of the tool's pose and the
joints before. Between two points a, b of the line D stays above zero where its second derivative is
below 2 (D_a + D_b) + 4 min(D_a, D_b). `arm_bounds` bounds that derivative by what the tool and the
joints before do on the part; and what these do by the least of their own squares there and by their
ways between the two points. Parts of the line for which this holds are kept, others are cut.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closed.evaluation import Evaluation
from symkin.closed.plan import Plan
from symkin.codegen.arm_bounds import ArmBounds, Stepped
from symkin.codegen.arm_motion import ArmMotion
from symkin.codegen.closed_source import LEAST, SAME, ClosedCode
from symkin.codegen.steps.guard_text import GuardText
from symkin.codegen.steps.guards import Bound, Guard
from symkin.codegen.steps.newton_kernel import rounded, rounded_up
from symkin.codegen.text.c import Emitter, Real, indent, indexed
from symkin.codegen.text.templates import copy, fill
from symkin.computed_once import cached_property

_HELPERS = ("take", "least", "least_length", "least_sine", "bounds")
"""Functions that hold squares and bound joints, the first of which others call."""
_OF_STEP, _OF_JOINT = 5, 5
"""Numbers that are told of a step and of each of its joints."""
_NOISE = 64.0
"""Roundings of a square's size below which its value is nothing."""
RAISED = 1.001
"""By which bounds are raised for their own rounding."""
_MOST_WAY = 6.28
"""Speed and way of a joint (rad) that together leave its whole turns no choice: a turn."""
_NEARLY_ONE = 0.999
"""Share of a discriminant that rounding leaves above zero."""
_LONGER = "part * ((w->bent < {0} * w->most) ? {1} : ({2} * {3}(w->most / w->bent)))"
"""The next part where one was kept at once: four fifths of what would do, at most twice as long."""


@dataclass(frozen=True)
class LimitCheck:
    """How the line asks whether joints keep their limits: which ones have some, values of names in
    its template, `members` of its work space, statements where a part is `shorter`, and the
    functions that these call.
    """

    joints: tuple[int, ...]
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

    def evaluated(self) -> Evaluation:
        """The arm at the half turns and the pose that they lead to."""
        return replace(
            Evaluation(self.plan.arm, self._x[:3], self._x[3:]), motions=self.motion.motions
        )

    def emitter(self, expressions: ca.SX) -> Emitter:
        """Emitter of functions of the half turns `u` and of the pose `x` that they lead to."""
        return self.motion.emitter(expressions, self._x)

    # --- how far squares bend ---------------------------------------------------------------------

    @cached_property
    def _bounds(self) -> ArmBounds:
        return ArmBounds(self.plan.arm)

    @cached_property
    def _steps(self) -> list[Stepped]:
        """Bounds of each step."""
        return [self._bounds.of(step, self._roots[i]) for i, step in enumerate(self.plan.steps)]

    @cached_property
    def guards(self) -> list[Guard]:
        """The squares of the steps that choose or carry; sizes are of slides within one size."""
        none, found = np.zeros(0), []
        for i in self.code.guarded:
            size = rounded_up(self._bounds.usual(self._bounds.at_ends(self._steps[i].size), 1.0))
            bounds = (Bound(size, none, none, none),)
            name = self.plan.steps[i].reason
            found.append(Guard(name, None, None, (), 1.0, "proved", bounds))
        return found

    @cached_property
    def _roots(self) -> ca.SX:
        return ca.SX.sym("r", len(self.plan.steps))

    def _root_lines(self) -> tuple[list[str], list[str]]:
        """C text of what each step divides by at least, and the statements of those that another
        one tells.
        """
        texts, lines = list[str](), list[str]()
        for i, square in enumerate(self.code.squares):
            power = -0.5 if self._steps[i].is_square else -1.0
            text = self.real.literal(1.0 / rounded_up(square.times**power))
            if square.number is not None and not square.own:
                other = texts[self.code.guarded[square.number]]
                text = other if text == self.real.literal(1.0) else f"{text} * {other}"
            less = not self._steps[i].less.is_zero()
            is_named = square.own or " " in text or less
            line = f"const {self.real.type} {'whole' if less else 'root'}{i} = {text};"
            lines.append(line if is_named and not square.own else "")
            texts.append(f"root{i}" if is_named else text)
        return texts, lines

    @property
    def _numbers(self) -> list[list[ca.SX]]:
        """Of each step the rounding of its square and how far this bends; of each of its joints
        what `Decided` tells.
        """
        least, found = _NOISE * self.real.epsilon, []
        for step in self._steps:
            change = step.bend if step.speed is None else step.speed
            sides = (*step.sides, ca.SX(0), ca.SX(0))[:2]
            numbers = [least * self._bounds.at_ends(step.size), change, step.less, *sides]
            for d in step.joints:
                numbers += [d.whole, d.speed, d.curved, d.crossed, d.own]
            found.append(numbers)
        return found

    def _keep_lines(self, limited: Sequence[int]) -> list[str]:
        """Statements that hold the squares on a part of the line, step by step, and bound what the
        joints do on it as far as later steps and limits of joints read that.
        """
        bounds, n, numbers = self._bounds, len(self.plan.arm), self._numbers
        texts, told = self._root_lines()
        inputs = [
            (bounds.place, ["place"]),
            (bounds.turn, ["turn"]),
            (bounds.speeds, indexed("w->speed", n)),
            (bounds.bends, indexed("w->change", n)),
            (bounds.ways, indexed("w->way", n)),
            (bounds.ends, [f"end{i}" for i in range(n)]),
            (self._roots, texts),
        ]
        emitter = Emitter.of(self.real, inputs, *(ca.vertcat(*part) for part in numbers))
        read = self._read_joints(numbers, limited)
        for i, step in enumerate(self._steps):
            emitter.comment(f"{self.plan.steps[i].reason}: proved")
            self._hold(emitter, i, told[i])
            self._take_less(emitter, i)
            for k, decided in enumerate(step.joints):
                self._bound(emitter, (i, k), is_read=decided.joint in read)
        lines = _without_unread(emitter.lines)
        return [*self._begin_lines(lines), *lines, "return w->kept;"]

    def _read_joints(self, numbers: list[list[ca.SX]], limited: Sequence[int]) -> set[int]:
        """Joints whose bounds later steps read, or their limits."""
        bounds, read = self._bounds, set(limited)
        asked = ca.SX(0, 1)
        for part, step in reversed(list(zip(numbers, self._steps, strict=True))):
            wholes = [part[_OF_STEP + _OF_JOINT * k] for k in range(len(step.joints))]
            asked = ca.vertcat(asked, *part[:_OF_STEP], *wholes)
            for k, decided in enumerate(step.joints):
                j = decided.joint
                symbols = ca.vertcat(bounds.speeds[j], bounds.bends[j])
                if j in read or ca.depends_on(asked, symbols):
                    read.add(j)
                    place = _OF_STEP + _OF_JOINT * k
                    asked = ca.vertcat(asked, *part[place : place + _OF_JOINT])
        return read

    def _hold(self, emitter: Emitter, i: int, told: str) -> None:
        """Statements of what a step divides by at least."""
        square, step, p = self.code.squares[i], self._steps[i], self.code.values["p"]
        if square.own:
            texts = ", ".join(emitter.value(i, k) for k in range(2))
            least = f"{p}_inverse_least(w, {square.number}, {texts})"
            if step.is_sine:
                least = f"{p}_inverse_least_sine(w, {square.number}, {texts})"
            elif step.speed is not None:
                always = self.real.literal(rounded(step.least))
                least = f"{p}_inverse_least_length(w, {square.number}, {texts}, {always})"
            elif step.is_square:
                least = f"{self.real.call('sqrt')}({least})"
            name = "root" if step.less.is_zero() else "whole"
            told = f"const {self.real.type} {name}{i} = {least};"
        if told:
            emitter.lines.append(told)

    def _bound(self, emitter: Emitter, at: tuple[int, int], *, is_read: bool) -> None:
        """Statements that bound what the joint `at` a step and place of its joints does."""
        (i, k), p = at, self.code.values["p"]
        joint, place = self._steps[i].joints[k].joint, _OF_STEP + _OF_JOINT * k
        if not self.plan.arm.screws[joint].slides:
            self._tell(emitter, i, joint, emitter.value(i, place))
        if is_read:
            emitter.lines.append(f"w->speed[{joint}] = {emitter.value(i, place + 1)};")
            texts = ", ".join(emitter.value(i, place + j) for j in (2, 3, 4))
            emitter.lines.append(f"{p}_inverse_bounds(w, {joint}, {texts});")

    def _tell(self, emitter: Emitter, i: int, joint: int, whole: str) -> None:
        """Statements that ask whether a joint's way is told, which goes no farther than `whole`:
        by that, or where what is turned and where it goes to cover too short ways across the axis
        for a quarter turn each, or the only one of them that turns for a half.
        """
        square, p, literal = self.code.squares[i], self.code.values["p"], self.real.literal
        sides = [3 + k for k in range(len(self._steps[i].sides))]
        way = f"({whole} + w->way[{joint}])"
        asked = f"{p}_inverse_take(w, {way} * {way}, {literal(_MOST_WAY**2)});"
        if not sides or square.number is None or abs(square.times - 1.0) > SAME:
            emitter.lines.append(asked)
            return
        here, there = (f"w->{part}[{square.number}]" for part in ("left", "guard"))
        ends = f"{here} + {there}"
        if len(sides) == 1:
            ends += f" + {literal(2.0)} * (({here} < {there}) ? {here} : {there})"
        texts = [emitter.value(i, side) for side in sides]
        short = [f"({literal(RAISED)} * {s} * {s} < {ends})" for s in texts]
        emitter.lines += [f"if (!({' && '.join(short)})) {{", f"    {asked}", "}"]

    def _take_less(self, emitter: Emitter, i: int) -> None:
        """Statements of the root less what slides' own ways take of it."""
        if self._steps[i].less.is_zero():
            return
        less, p, one = emitter.value(i, 2), self.code.values["p"], self.real.literal(1.0)
        emitter.lines += [
            f"{p}_inverse_take(w, {less}, whole{i});",
            f"const {self.real.type} root{i} = ({less} < whole{i}) ? (whole{i} - {less}) : {one};",
        ]

    def _begin_lines(self, lines: Sequence[str]) -> list[str]:
        """Statements of what changes on the part, as far as the lines read it."""
        real = self.real
        text = "\n".join(line for line in lines if not line.startswith("/*"))
        found = [
            "w->kept = true;",
            f"w->bent = {real.literal(0.0)};",
            f"w->most = {real.literal(1.0)};",
        ]
        for i, name in enumerate(("place", "turn")):
            if re.search(rf"\b{name}\b", text):
                found.append(f"const {real.type} {name} = {real.call('sqrt')}(change[{i}]);")
        for i, screw in enumerate(self.plan.arm.screws):
            if re.search(rf"\bend{i}\b", text):
                zero = f" - {real.literal(screw.zero)}" if screw.zero else ""
                here, there = (f"w->{part}[{i}]{zero}" for part in ("joints", "found[0]"))
                fabs, per = real.call("fabs"), real.literal(1.0 / self.plan.arm.size)
                found += [
                    f"const {real.type} begin{i} = {fabs}({here}) * {per};",
                    f"const {real.type} goal{i} = {fabs}({there}) * {per};",
                    f"const {real.type} end{i} = (begin{i} < goal{i}) ? goal{i} : begin{i};",
                ]
        return found

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
                "nto": 2,
                "nat": 7,
                "turns": 2 * len(self.plan.arm),
                "read": indent(self._read_lines),
                "per_lengths": self.per_lengths,
                "per_size2": literal(size**-2),
                "size2": literal(size**2),
                "least": literal(LEAST * self.real.epsilon),
                "four": literal(4.0),
                "quarter_part": literal(0.25),
                "eight": literal(8.0),
                "sixth": literal(1.0 / 6.0),
                "turn_noise": literal(4.0 * self.real.epsilon),
                "raised": literal(RAISED),
                "most_way": literal(_MOST_WAY),
                "nearly_one": literal(_NEARLY_ONE),
                "keep_lines": indent(self._keep_lines(limits.joints)),
                "aimed": f"unsigned int wanted, {self.real.type} most2, ",
                "take": indent(copy("w->joints", "w->found[0]", len(self.plan.arm)), 3),
                "longer": _LONGER.format(
                    literal(0.16), literal(2.0), literal(0.8), self.real.call("sqrt")
                ),
                "and_follows": f" && {self.code.values['p']}_inverse_follows(w, most2)",
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
        called = walk + limits.text
        helpers = [
            fill(f"closed_{name}.c", names)
            for name in _HELPERS[1:]
            if f"_inverse_{name}(" in called
        ]
        if f"_inverse_{_HELPERS[0]}(" in "".join([called, *helpers]):
            helpers.insert(0, fill(f"closed_{_HELPERS[0]}.c", names))
        own = {"walk": walk, "limits": limits.text, "helpers": "".join(helpers)}
        return fill("closed_line.c", names | own)


def _without_unread(lines: Sequence[str]) -> list[str]:
    """Statements without the roots that no other one reads, but for what these ask."""
    found, text = list[str](), "\n".join(line for line in lines if not line.startswith("/*"))
    for line in lines:
        named = re.match(r"const \w+ ((?:root|whole)\d+) = (.*);$", line)
        if named is None or len(re.findall(rf"\b{named[1]}\b", text)) > 1:
            found.append(line)
        elif "_inverse_least" in named[2]:
            asked = named[2][named[2].index("(") + 1 : -1] if "sqrt" in named[2] else named[2]
            found.append(f"(void){asked};")
    return found
