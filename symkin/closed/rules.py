"""Rules that decide joints of a chain F_1 ... F_n = T from how its axes lie; each gives sequences
of steps, best first.

A wrist: the last joints turn about one point W, so that F_1 F_2 F_3 W = T W. Parallel axes: what
stands between two products of motions L and R is a planar motion of normal k, so that L k = T R^-1
k, and k . R y = k . L^-1 T y for all points y. Few turning joints: directions tell them, and the
slides are linear.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from symkin.closed.geometry import AxisGeometry, Invariant, across
from symkin.closed.point_problem import Steps, balanced, carried, point_steps
from symkin.closed.screws import Screw, Vector
from symkin.closed.steps import TOOL, Carry, Factor, Level, Operand, Slides, Word, inverse

_MOST_OUTSIDE = 3
"""Joints beside a planar part: three conditions decide them."""


@dataclass(frozen=True)
class Chain:
    """The joints that are still to be decided, F_1 ... F_n = T."""

    factors: Word
    target: Word

    @property
    def reversed(self) -> Chain:
        return Chain(inverse(self.factors), inverse(self.target))

    @property
    def joints(self) -> tuple[int, ...]:
        return tuple(factor.joint for factor in self.factors)

    def without(self, decided: set[int]) -> Chain:
        """The chain without decided joints at its ends."""
        factors, target = self.factors, self.target
        while factors and factors[0].joint in decided:
            target, factors = (factors[0].inverse, *target), factors[1:]
        while factors and factors[-1].joint in decided:
            target, factors = (*target, factors[-1].inverse), factors[:-1]
        return Chain(factors, target)


@dataclass(frozen=True, eq=False)
class Rules:
    """The rules for one arm."""

    axes: AxisGeometry

    def options(self, chain: Chain) -> Iterator[Steps]:
        """Sequences of steps, each of which decides joints so that what is left is a chain."""
        both = (chain, chain.reversed)
        rules: tuple[Callable[[Chain], Iterator[Steps]], ...] = (
            self._single,
            self._planar,
            self._rotations,
            self._wrist,
        )
        for rule in rules:
            for view in both[:1] if rule in (self._single, self._rotations) else both:
                yield from rule(view)

    def _screw(self, factor: Factor) -> Screw:
        return self.axes.arm.screws[factor.joint]

    def _axis(self, factor: Factor) -> Operand:
        return Operand(self._screw(factor).axis, False)

    # --- one joint --------------------------------------------------------------------------------

    def _single(self, chain: Chain) -> Iterator[Steps]:
        if len(chain.factors) != 1:
            return
        (factor,) = chain.factors
        screw = self._screw(factor)
        if screw.slides:
            x = Operand(screw.point, True)
            yield (carried(self.axes, factor, x, x.carried(chain.target), "the tool"),)
            return
        for v in across(screw.axis):
            x = Operand(v, False)
            yield (
                carried(self.axes, factor, x, x.carried(chain.target), "a direction of the tool"),
            )

    # --- a wrist ----------------------------------------------------------------------------------

    def _wrist(self, chain: Chain) -> Iterator[Steps]:
        for count in (3, 2, 1):
            before, wrist = chain.factors[:-count], chain.factors[-count:]
            if not 1 <= len(before) <= 3:
                continue
            point, target = self._wrist_point(wrist, chain.target)
            if point is None:
                continue
            names = ", ".join(self._screw(f).name for f in wrist)
            what = (
                f"the point where the axes of {names} meet"
                if count > 1
                else f"a point of the axis of {names}"
            )
            w = Operand(point, True)
            yield from point_steps(self.axes, before, w, w.carried(target), what, "arm")

    def _wrist_point(self, wrist: Word, target: Word) -> tuple[Vector | None, Word]:
        """A point that the wrist leaves where it is, and the part of the target that moves it: of a
        single axis the point where the one decided before meets it.
        """
        joints = [factor.joint for factor in wrist]
        inner = target[-1].joint
        if len(wrist) == 1 and inner != TOOL:
            point = self.axes.meeting_point([*joints, inner])
            if point is not None:
                return point, target[:-1]
        return self.axes.meeting_point(joints), target

    # --- directions, then slides ------------------------------------------------------------------

    def _rotations(self, chain: Chain) -> Iterator[Steps]:
        turning = tuple(factor for factor in chain.factors if not self._screw(factor).slides)
        sliding = tuple(factor for factor in chain.factors if self._screw(factor).slides)
        if len(turning) > 3 or len(sliding) > 3:
            return
        slides: Steps = ()
        if sliding:
            names = ", ".join(self._screw(f).name for f in sliding)
            slides = (
                Slides(
                    tuple(f.joint for f in sliding),
                    f"with all rotations known, the tool's place tells {names}",
                    None,
                    chain.factors,
                    Operand((0.0, 0.0, 0.0), True),
                    chain.target,
                ),
            )
        for steps in self._turns(turning, chain.target):
            yield (*steps, *slides)

    def _turns(self, turning: Word, target: Word) -> Iterator[Steps]:
        """Steps for up to three rotations that make a known one."""
        if not turning:
            yield ()
            return
        *before, last = turning
        axis = self._axis(last)
        what = f"the axis of {self._screw(last).name}"
        heads: Iterator[Steps] = iter([()])
        if before:
            heads = point_steps(self.axes, tuple(before), axis, axis.carried(target), what, "wrist")
        back = inverse(tuple(before))
        for head in heads:
            for v in across(self._screw(last).axis):
                x = Operand(v, False)
                yield (
                    *head,
                    carried(
                        self.axes, last, x, x.carried((*back, *target)), "a direction of the tool"
                    ),
                )

    # --- parallel axes ----------------------------------------------------------------------------

    def _planar(self, chain: Chain) -> Iterator[Steps]:
        factors = chain.factors
        for begin in range(len(factors) - 2):
            joint = self.axes.plane_normal([f.joint for f in factors[begin : begin + 3]])
            left, right = factors[:begin], factors[begin + 3 :]
            if (
                joint is not None
                and left + right
                and len(left) <= 1
                and len(left + right) <= _MOST_OUTSIDE
            ):
                names = ", ".join(self._screw(f).name for f in factors[begin : begin + 3])
                yield from _Outside(
                    self,
                    left,
                    right,
                    chain.target,
                    Operand(self.axes.arm.screws[joint].axis, False),
                    names,
                ).steps()


@dataclass(frozen=True, eq=False)
class _Outside:
    """The joints L (at most one) before and R behind a planar part of normal k: L (planar) R =
    T.
    """

    rules: Rules
    left: Word
    right: Word
    target: Word
    k: Operand
    names: str

    @property
    def axes(self) -> AxisGeometry:
        return self.rules.axes

    @property
    def _parallel(self) -> str:
        return f"{self.names} have parallel axes"

    def _is_turn(self, factor: Factor) -> bool:
        return not self.rules._screw(factor).slides

    def _level(self, factor: Factor, before: Word, y: Operand, goal: Operand) -> Level:
        """k . before F y = k . goal."""
        name = self.rules._screw(factor).name
        reason = f"{self._parallel}: a level along them, which they do not change, tells {name}"
        return Level(
            (factor.joint,),
            reason,
            "arm" if self._is_turn(factor) else None,
            factor.sign,
            self.k,
            before,
            y,
            self.k,
            goal,
        )

    def steps(self) -> Iterator[Steps]:
        """Sequences that decide all joints of L and R."""
        match len(self.left), len(self.right):
            case (1, 0):
                yield from self._one(self.left[0])
            case (0, 1):
                yield from self._one(self.right[0])
            case (0, 2):
                yield from self._two_behind()
            case (1, 1):
                yield from self._one_each()
            case (1, 2):
                yield from self._one_and_two()
            case (0, 3):
                yield from self._three_behind()

    def _one(self, factor: Factor) -> Iterator[Steps]:
        if not self._is_turn(factor):
            yield (self._slide(factor),)
        elif self.left:
            yield (
                carried(
                    self.axes,
                    factor,
                    self.k,
                    self.k.carried(self.target),
                    "the planar part's normal",
                ),
            )
        else:
            yield (
                carried(
                    self.axes,
                    factor,
                    self.k.carried(inverse(self.target)),
                    self.k,
                    "the planar part's normal",
                ),
            )

    def _slide(self, factor: Factor) -> Level:
        """k . R y = k . L^-1 T y for y = 0, the slide in L or R."""
        origin = Operand((0.0, 0.0, 0.0), True)
        if factor in self.left:
            return self._level(
                factor.inverse, (), origin.carried(self.target), origin.carried(self.right)
            )
        place = self.right.index(factor)
        y = origin.carried(self.right[place + 1 :])
        goal = origin.carried((*inverse(self.left), *self.target))
        return self._level(factor, self.right[:place], y, goal)

    def _normal(self) -> Operand:
        """T^-1 L k, which R takes to k."""
        return self.k.carried((*inverse(self.target), *self.left))

    def _direction(self, factors: Word) -> Iterator[Steps]:
        yield from point_steps(
            self.axes, factors, self._normal(), self.k, f"the normal of {self.names}", "wrist"
        )

    def _two_behind(self) -> Iterator[Steps]:
        turning = tuple(f for f in self.right if self._is_turn(f))
        sliding = tuple(self._slide(f) for f in self.right if not self._is_turn(f))
        for steps in self._direction(turning):
            yield (*steps, *sliding)

    def _one_each(self) -> Iterator[Steps]:
        (first,), (last,) = self.left, self.right
        slides = tuple(self._slide(f) for f in (first, last) if not self._is_turn(f))
        if slides:
            if len(slides) == 1:
                turning = next(f for f in (first, last) if self._is_turn(f))
                yield (*self._one_turn(turning), *slides)
            return
        for head in (*self._by_point(first, (last,)), self._by_angle(first, last)):
            yield (
                head,
                carried(self.axes, last, self._normal(), self.k, f"the normal of {self.names}"),
            )

    def _one_turn(self, factor: Factor) -> Steps:
        """The only turning joint outside, told by directions."""
        if factor in self.left:
            return (
                carried(
                    self.axes,
                    factor,
                    self.k,
                    self.k.carried(self.target),
                    f"the normal of {self.names}",
                ),
            )
        return (
            carried(
                self.axes,
                factor,
                self.k.carried(inverse(self.target)),
                self.k,
                f"the normal of {self.names}",
            ),
        )

    def _by_point(self, first: Factor, behind: Word) -> list[Level]:
        """k . c = k . L^-1 T c for the point c where the axes of R meet."""
        point = self.axes.meeting_point([f.joint for f in behind])
        if point is None:
            return []
        c = Operand(point, True)
        return [self._level(first.inverse, (), c.carried(self.target), c)]

    def _by_angle(self, first: Factor, last: Factor) -> Level:
        """The angle of k with the axis of R's joint: axis . T^-1 L k = axis . k."""
        axis = self.rules._axis(last)
        name = self.rules._screw(first).name
        reason = f"{self._parallel}: their angle with the next axis tells {name}"
        return Level(
            (first.joint,),
            reason,
            "arm",
            first.sign,
            axis.carried(self.target),
            (),
            self.k,
            axis,
            self.k,
        )

    def _one_and_two(self) -> Iterator[Steps]:
        (first,), (middle, last) = self.left, self.right
        if not self._is_turn(first):
            return
        if self._is_turn(middle) and self._is_turn(last):
            for head in self._by_point(first, (middle, last)):
                for rest in self._direction((middle, last)):
                    yield (head, *rest)
            if self.axes.are_parallel(middle.joint, last.joint):
                yield (
                    self._by_angle(first, last),
                    self._level_of_axis(middle, last),
                    self._last(last),
                )
        elif self._is_turn(middle) != self._is_turn(last):
            turning, sliding = (middle, last) if self._is_turn(middle) else (last, middle)
            carry = carried(
                self.axes, turning, self._normal(), self.k, f"the normal of {self.names}"
            )
            yield self._by_angle(first, turning), carry, self._slide(sliding)

    def _level_of_axis(self, middle: Factor, last: Factor) -> Level:
        """k . R y = k . L^-1 T y for a point y of the last axis."""
        y = Operand(self.rules._screw(last).point, True)
        place = self.right.index(middle)
        return self._level(
            middle, self.right[:place], y, y.carried((*inverse(self.left), *self.target))
        )

    def _last(self, last: Factor) -> Carry:
        """The last joint of R, told by the normal when all others are."""
        before = inverse(self.right[:-1])
        return carried(
            self.axes, last, self._normal(), self.k.carried(before), f"the normal of {self.names}"
        )

    def _three_behind(self) -> Iterator[Steps]:
        first, middle, last = self.right
        if not all(self._is_turn(f) for f in self.right):
            return
        u = self._normal()
        point = self.axes.meeting_point([middle.joint, last.joint])
        what = f"the normal of {self.names}"
        if point is not None:
            c = Operand(point, True)
            head = self._level(first, (), c, c.carried(self.target))
            for rest in point_steps(
                self.axes, (middle, last), u, self.k.carried((first.inverse,)), what, "wrist"
            ):
                yield (head, *rest)
        point = self.axes.meeting_point([first.joint, middle.joint])
        if point is not None:
            c = Operand(point, True)
            head = Level(
                (last.joint,),
                f"{self._parallel}: a level along them tells {self.rules._screw(last).name}",
                "arm",
                -last.sign,
                self.k,
                self.target,
                c,
                self.k,
                c,
            )
            for rest in point_steps(
                self.axes, (first, middle), u.carried((last,)), self.k, what, "wrist"
            ):
                yield (head, *rest)
        if self.axes.are_parallel(middle.joint, last.joint):
            axis = self.rules._axis(last)
            same = Invariant(
                True, axis.vector, f"level along the axis of {self.rules._screw(last).name}"
            )
            head_step = balanced(self.axes, same, first.inverse, self.k, u, what, "arm")
            y = Operand(self.rules._screw(last).point, True)
            second = self._level(middle, (first,), y, y.carried(self.target))
            yield (
                head_step,
                second,
                carried(self.axes, last, u, self.k.carried(inverse((first, middle))), what),
            )
