"""Write the statements that hold an arm's squares on a part of a line, step by step, and bound what
the joints do on it as far as later steps and limits of joints read that.

Its work space `w` has the squares at both ends, `left` and `guard`, the joints' ways between them,
and takes the bounds of their speeds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from symkin.codegen.arm_bounds import ArmBounds, Decided, Stepped
from symkin.codegen.closed_source import SAME, ClosedCode
from symkin.codegen.steps.newton_kernel import rounded, rounded_up
from symkin.codegen.text.c import Emitter, indexed
from symkin.computed_once import cached_property

_NOISE = 64.0
"""Roundings of a square's size below which its value is nothing."""
RAISED = 1.001
"""By which bounds are raised for their own rounding."""
MOST_WAY = 6.28
"""Speed and way of a joint (rad) that together leave its whole turns no choice: a turn."""

_Key = tuple[str, int]
"""What a printed number is, and the step or joint of which it is told."""


@dataclass(frozen=True, eq=False)
class HeldPart:
    """How one arm's closed form is held on a part; `limited`: joints of which limits read the
    bounds.
    """

    code: ClosedCode
    limited: Sequence[int]

    @cached_property
    def bounds(self) -> ArmBounds:
        return ArmBounds(self.code.plan.arm)

    @cached_property
    def _roots(self) -> ca.SX:
        """What each step divides by at least."""
        return ca.SX.sym("r", len(self.code.plan.steps))

    @cached_property
    def steps(self) -> list[Stepped]:
        """Bounds of each step."""
        steps = enumerate(self.code.plan.steps)
        return [self.bounds.of(step, self._roots[i]) for i, step in steps]

    # --- what is printed --------------------------------------------------------------------------

    @cached_property
    def _told(self) -> dict[_Key, ca.SX]:
        """The numbers that are printed; of joints those that later ones read, or limits."""
        found: dict[_Key, ca.SX] = {}
        for i, step in reversed(list(enumerate(self.steps))):
            own = self._told_of_step(i)
            later = ca.vertcat(ca.SX(0, 1), *own.values(), *found.values())
            for decided in step.joints:
                j = decided.joint
                moved = ca.vertcat(self.bounds.speeds[j], self.bounds.bends[j])
                if j in self.limited or ca.depends_on(later, moved):
                    own |= _told_of_joint(decided)
            found = own | found
        keys, places = list(found), [i for i in range(len(self.steps)) if not self._is_named(i)]
        if not places:
            return found
        hidden = ca.vertcat(*(self._roots[i] for i in places))
        known = ca.vertcat(*(self._whole(i) for i in places))
        return dict(zip(keys, ca.substitute([*found.values()], [hidden], [known]), strict=True))

    def _told_of_step(self, i: int) -> dict[_Key, ca.SX]:
        """Of a step's own square its rounding and how far it bends, or how fast its root changes;
        what slides take of the root; how far its joints turn.
        """
        square, step, told = self.code.squares[i], self.steps[i], dict[_Key, ca.SX]()
        if square.own:
            told["rounding", i] = _NOISE * self.code.real.epsilon * self.bounds.at_ends(step.size)
            told["change", i] = step.bend if step.speed is None else step.speed
        if not step.less.is_zero():
            told["less", i] = step.less
            if not square.own:
                told["whole root", i] = self._whole(i)
        for decided in step.joints:
            if not self.code.plan.arm.screws[decided.joint].slides:
                told["whole", decided.joint] = decided.whole
        if self._turns_short(i):
            told |= {(f"side {k}", i): side for k, side in enumerate(step.sides)}
        return told

    def _turns_short(self, i: int) -> bool:
        """Whether the square of a step tells how long what it turns is across the axis."""
        square = self.code.squares[i]
        alike = square.number is not None and abs(square.times - 1.0) <= SAME
        return alike and len(self.steps[i].sides) > 0

    def _whole(self, i: int) -> ca.SX:
        """The least root of a step's square, before slides take of it: its own, or by the square
        that tells it.
        """
        square = self.code.squares[i]
        if square.own:
            return self._roots[i]
        factor = 1.0 / rounded_up(square.times ** (-0.5 if self.steps[i].is_square else -1.0))
        if square.number is None:
            return ca.SX(factor)
        return factor * self._roots[self.code.guarded[square.number]]

    def _is_named(self, i: int) -> bool:
        """Whether the least root of a step is a number of its own."""
        return self.code.squares[i].own or not self.steps[i].less.is_zero()

    def _reads(self, symbol: ca.SX) -> bool:
        return bool(ca.depends_on(ca.vertcat(*self._told.values()), symbol))

    # --- text -------------------------------------------------------------------------------------

    @cached_property
    def _emitter(self) -> Emitter:
        bounds, n = self.bounds, len(self.code.plan.arm)
        inputs = [
            (bounds.place, ["place"]),
            (bounds.turn, ["turn"]),
            (bounds.speeds, indexed("w->speed", n)),
            (bounds.bends, indexed("w->change", n)),
            (bounds.ways, indexed("w->way", n)),
            (bounds.ends, [f"end{i}" for i in range(n)]),
            (self._roots, [f"root{i}" for i in range(len(self.steps))]),
        ]
        return Emitter.of(self.code.real, inputs, ca.vertcat(*self._told.values()))

    def _text(self, kind: str, number: int) -> str:
        """Make the statements up to a printed number; its text."""
        return self._emitter.value(0, list(self._told).index((kind, number)))

    @cached_property
    def lines(self) -> list[str]:
        """All statements."""
        for i, step in enumerate(self.steps):
            self._emitter.comment(f"{self.code.plan.steps[i].reason}: proved")
            if self.code.squares[i].own:
                self._hold(i)
            if not step.less.is_zero():
                self._take_less(i)
            for decided in step.joints:
                self._bound(i, decided.joint)
        return [*self._begin_lines, *self._emitter.lines, *self._end_lines]

    def _hold(self, i: int) -> None:
        """Statements of what a step divides by at least; where nothing reads that, its square is
        held all the same.
        """
        step, number = self.steps[i], self.code.squares[i].number
        texts = f"w, {number}, {self._text('rounding', i)}, {self._text('change', i)}"
        root = ""
        if step.is_sine:
            asked = f"name_inverse_least_sine({texts})"
        elif step.speed is not None:
            asked = f"name_inverse_least_length({texts}, {rounded(step.least)})"
        else:
            asked, root = f"name_inverse_least({texts})", "sqrt" if step.is_square else ""
        if self._reads(self._roots[i]) or not step.less.is_zero():
            name = "root" if step.less.is_zero() else "whole"
            text = f"{root}({asked})" if root else asked
            self._add(f"const real {name}{i} = {text};")
        else:
            self._add(f"(void){asked};")

    def _take_less(self, i: int) -> None:
        """Statements of the root less what slides' own ways take of it."""
        less = self._text("less", i)
        whole = f"whole{i}" if self.code.squares[i].own else self._text("whole root", i)
        self._add(f"name_inverse_take(w, {less}, {whole});")
        if self._reads(self._roots[i]):
            rest = f"({less} < {whole}) ? ({whole} - {less}) : 1.0"
            self._add(f"const real root{i} = {rest};")

    def _bound(self, i: int, joint: int) -> None:
        """Statements that bound what a joint does."""
        if ("whole", joint) in self._told:
            self._tell(i, joint)
        if ("speed", joint) in self._told:
            self._limit(joint)

    def _limit(self, joint: int) -> None:
        """Statements that bound a joint's speed and how this changes, which is plain where that
        does not depend on the speed.
        """
        speed, own = self._text("speed", joint), self._text("own", joint)
        told = f"w->speed[{joint}]"
        if any(not self._told[kind, joint].is_zero() for kind in ("curved", "crossed")):
            self._add(f"{told} = {speed};")
            texts = ", ".join(self._text(kind, joint) for kind in ("curved", "crossed", "own"))
            self._add(f"name_inverse_bounds(w, {joint}, {texts});")
            return
        self._add(f"const real way{joint} = w->way[{joint}] + (0.5 * {own});")
        self._add(f"{told} = (way{joint} < {speed}) ? way{joint} : {speed};")
        self._add(f"w->change[{joint}] = {own};")

    def _tell(self, i: int, joint: int) -> None:
        """Statements that take how far a joint goes for the most of all, which must tell its way:
        `whole` and its way, unless what is turned and where it goes to cover too short ways across
        the axis for a quarter turn each, or the only one of them that turns for a half.
        """
        number = self.code.squares[i].number
        whole = self._emitter.assign(f"{self._text('whole', joint)} + w->way[{joint}]")
        asked = f"{whole} > most"
        if self._turns_short(i):
            here, there = (f"w->{part}[{number}]" for part in ("left", "guard"))
            ends, sides = f"{here} + {there}", range(len(self.steps[i].sides))
            if len(sides) == 1:
                ends += f" + (2.0 * (({here} < {there}) ? {here} : {there}))"
            texts = [self._text(f"side {k}", i) for k in sides]
            short = [f"({RAISED} * {s} * {s} < {ends})" for s in texts]
            asked = f"({asked}) && !({' && '.join(short)})"
        self._add(f"most = ({asked}) ? {whole} : most;")
        told = MOST_WAY
        self._emitter.lines += [f"if (!(most < {told})) {{", f"    {self._take_most}", "}"]

    @property
    def _end_lines(self) -> list[str]:
        """Statements that end with the longest way of all joints."""
        return [*([self._take_most] if self._has_turns else []), "return w->kept;"]

    @property
    def _take_most(self) -> str:
        turn2 = MOST_WAY**2
        return f"name_inverse_take(w, most * most, {turn2});"

    @property
    def _has_turns(self) -> bool:
        return any(key[0] == "whole" for key in self._told)

    def _add(self, line: str) -> None:
        self._emitter.lines.append(line)

    @property
    def _begin_lines(self) -> list[str]:
        """Statements of what changes on the part, as far as the others read it."""
        bounds, size = self.bounds, self.code.plan.arm.size
        found = ["w->kept = true;", "w->bent = 0.0;", "w->most = 1.0;"]
        if self._has_turns:
            found.append("real most = 0.0;")
        for i, (name, symbol) in enumerate((("place", bounds.place), ("turn", bounds.turn))):
            if self._reads(symbol):
                found.append(f"const real {name} = sqrt(change[{i}]);")
        for i in range(len(self.code.plan.arm)):
            if self._reads(bounds.ends[i]):
                per = 1.0 / size
                found += [
                    f"const real begin{i} = fabs(w->turned[{i}][0]) * {per};",
                    f"const real goal{i} = fabs(w->aimed[{i}][0]) * {per};",
                    f"const real end{i} = (begin{i} < goal{i}) ? goal{i} : begin{i};",
                ]
        return found


def _told_of_joint(decided: Decided) -> dict[_Key, ca.SX]:
    """What bounds a joint's speed and its change."""
    kinds = ("speed", "curved", "crossed", "own")
    return {(kind, decided.joint): getattr(decided, kind) for kind in kinds}
