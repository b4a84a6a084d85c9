"""Bound how fast the joints of an arm go along a part of a line of tool poses, and how far what its
steps keep above zero bends there.

From the innermost motion to the outermost `carried_bounds` bound what a step's equation holds,
E = A cos q + B sin q - C = 0 and D = A^2 + B^2 - C^2 with Z = (A, B):

    D'' <= 2 |Z'|^2 + 2 |Z| |Z''| + 2 |C| |C''|,
    sqrt(D) |q'| <= |Z'| + |C'|,    sqrt(D) |q''| <= |C| q'^2 + 2 |Z'| |q'| + |Z''| + |C''|.

Of F x = y, a turn, the angles of x and y across the axis change by |y'| / r and by
|y''| / r + |y'|^2 / r^2. Each step reads the bounds of the joints before it, so that all hold on
the whole part once the squares are above zero on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closed.screws import Screw
from symkin.closed.steps import (
    TOOL,
    Carry,
    Distance,
    Level,
    Operand,
    Slides,
    Step,
    inverse,
)
from symkin.codegen.carried_bounds import CarriedBounds
from symkin.codegen.moving_bounds import (
    ONE,
    ZERO,
    Moving,
    Scalar,
    at_rest,
    between,
    dot_of,
    length_of,
    lesser,
    norm_of,
    size_of,
)

_MORE = 1.01
"""By how much three digits of a bound are more than it at most."""


@dataclass(frozen=True)
class Decided:
    """Bounds of one joint: |q'| is at most `speed`, |q''| at most
    curved q'^2 + 2 crossed |q'| + own; it goes no farther than `whole`, whole turns and all.
    """

    joint: int
    speed: ca.SX
    curved: ca.SX = ZERO
    crossed: ca.SX = ZERO
    own: ca.SX = ZERO
    way: ca.SX | None = None

    @property
    def whole(self) -> ca.SX:
        return self.speed if self.way is None else self.way


@dataclass(frozen=True)
class Stepped:
    """What holds of one step. Of its guard, a square or what the step divides by, half of the
    second derivative is at most `bend`; or of the guard's root, a length, the derivative is at most
    `speed`, and the length at least `least`. `less`: what is taken off the root for slides.
    """

    size: ca.SX
    joints: tuple[Decided, ...]
    bend: ca.SX = ZERO
    speed: ca.SX | None = None
    least: float = 0.0
    is_sine: bool = False
    """Whether that root is the sine of an angle that changes by at most `speed`."""
    is_square: bool = True
    sides: tuple[ca.SX, ...] = ()
    """Speeds of those of what is carried and of where it goes that turn about the axis."""
    less: ca.SX = ZERO


@dataclass(frozen=True, eq=False)
class ArmBounds(CarriedBounds):
    """Bounds of an arm's steps as expressions of what changes along a part."""

    def of(self, step: Step, root: ca.SX) -> Stepped:
        """Bounds of a step by the least root of its guard."""
        match step:
            case Carry():
                return self._carried(step, root)
            case Level():
                return self._level(step, root)
            case Distance():
                return self._distance(step, root)
            case Slides():
                return self._slid(step, root)
        raise AssertionError(step)

    def _carried(self, step: Carry, root: ca.SX) -> Stepped:
        """Of F x = y the angles of x and y across the axis, at least `least` long."""
        (joint,) = step.joints
        screw = self.arm.screws[joint]
        point = self._point(screw, is_point=step.x.is_point)
        if screw.slides:
            here, there = self.value(step.x), self.value(step.y)
            slid = Decided(joint, here.speed + there.speed, own=here.bend + there.bend)
            return Stepped(ZERO, (slid,))
        step = replace(step, x=self._level_off(step.x), y=self._level_off(step.y))
        x, y = (self._across(step, operand, screw) for operand in (step.x, step.y))
        turning = [
            side
            for side, operand in zip((x, y), (step.x, step.y), strict=True)
            if not self._keeps_side(operand, screw)
        ]
        # r q'' = the part of x'' and y'' along r q' less 2 r' q'
        speed = min(x.speed, y.speed, key=self.usual)
        decided = Decided(
            joint,
            sum((side.speed for side in turning), ZERO) / root,
            crossed=speed / root,
            own=sum((side.bend for side in turning), ZERO) / root,
        )
        return Stepped(
            lesser(self.at_ends(x.size), self.at_ends(y.size)) ** 2,
            (self._spun_by(step, screw, decided),),
            speed=speed,
            least=max(self._least_across(operand, screw, point) for operand in (step.x, step.y)),
            sides=tuple(side.speed for side in turning),
        )

    def _across(self, step: Carry, operand: Operand, screw: Screw) -> Scalar:
        """A vector's part across an axis, of one length for x and y at the ends, like the level
        along it. An outer turn about another axis that meets the first one at a right angle moves
        that part only as far as the vector's level from there.
        """
        whole, k = self.value(operand), np.array(screw.axis)
        found = whole.across(screw, self._point(screw, is_point=operand.is_point))
        meeting = self._meeting(operand, screw)
        if meeting is None:
            return found
        joint, inner = operand.word[0].joint, self.value(replace(operand, word=operand.word[1:]))
        sides = [self._less(Operand(screw.axis, False), side) for side in (step.x, step.y)]
        levels = [self.at_ends(self.value(side).along(k, meeting).size) for side in sides]
        level = lesser(*levels) + 0.5 * whole.speed
        speed, bend, far = self.speeds[joint], self.bends[joint], whole.away(meeting).size
        crossed = Scalar(
            found.size,
            inner.speed + speed * level,
            inner.bend + 2 * speed * inner.speed + bend * level + speed**2 * far,
        )
        return min(found, crossed, key=lambda one: self.usual(one.speed))

    def _meeting(self, operand: Operand, screw: Screw) -> np.ndarray | None:
        """Where the axis of a vector's outer turn meets another axis at a right angle; None where
        it does not.
        """
        if not operand.word or operand.word[0].joint == TOOL:
            return None
        other = self.arm.screws[operand.word[0].joint]
        if other.slides:
            return None
        k, axis = np.array(screw.axis), np.array(other.axis)
        point = self._point(screw, is_point=operand.is_point)
        gap = self._point(other, is_point=operand.is_point) - point
        meets = size_of(k @ axis) == 0.0 and size_of(np.cross(k, axis) @ gap) == 0.0
        return point + k * (k @ gap) if meets else None

    def _level(self, step: Level, root: ca.SX) -> Stepped:
        """C = n . y - n . W c of the centre c + k (k . (x - c)) of x's circle."""
        (joint,) = step.joints
        screw, k = self.arm.screws[joint], np.array(self.arm.screws[joint].axis)
        normal, x = self.value(step.normal), self.value(step.x)
        fixed, y = map(self.value, (step.level_normal, self._less(step.level_normal, step.y)))
        level = dot_of(fixed, y)
        if screw.slides:
            axis = self.carry(step.before, at_rest(k), is_point=False)
            there = self.carry(step.before, x, is_point=step.x.is_point)
            c = level.plus(dot_of(normal, there))
            if self._rises(joint):  # turns leave that level alone
                c = Scalar(c.size, self.place, ZERO)
            return self._quotient((joint,), [c], dot_of(normal, axis), root)
        point = self._point(screw, is_point=step.x.is_point)
        own = self.carry(inverse(step.before), normal, is_point=False)
        z = own.across(screw, np.zeros(3)).times(x.across(screw, point))
        centre = self.carry(step.before, at_rest(point), is_point=step.x.is_point)
        tilt = own.along(k, np.zeros(3))
        level = level.plus(dot_of(normal, centre)).plus(tilt.times(x.along(k, point)))
        if not step.x.is_point and self._is_angle(fixed, own, x, k):
            return self._angle(joint, level, root)
        if level.speed.is_zero() and tilt.size.is_zero():
            normal_level = normal.centre @ centre.centre
            level = replace(level, size=ca.SX(size_of(fixed.centre @ y.centre - normal_level)))
        return self._balanced(joint, z, level, root)

    def _distance(self, step: Distance, root: ca.SX) -> Stepped:
        """2 C = |y - other|^2 - |gap|^2 - |x|^2, the gap between the centre of x's circle and
        `centre`.
        """
        (joint,) = step.joints
        screw = self.arm.screws[joint]
        k, point = np.array(screw.axis), self._point(screw, is_point=True)
        if not screw.slides:
            words = map(self._level_off, (step.x, step.centre, step.y, step.other))
            step = Distance(step.joints, step.reason, step.branch, step.sign, *words)
        x, centre = self.value(step.x), self.value(step.centre)
        away = between(self.value(self._less(step.other, step.y)), self.value(step.other))
        if screw.slides:
            there = between(x, centre)
            half = away.away(np.zeros(3)).half_square.plus(there.away(np.zeros(3)).half_square)
            return self._slid_to(joint, there.along(k, np.zeros(3)), half, root)
        across, gap = x.across(screw, point), centre.across(screw, point)
        # as far as F x from the centre, which stays the same where these two stay: beyond that D is
        # below zero, and is led on in a straight line of the distance, so that it bends no more
        at, radius = self._turned(joint, x, is_point=True)
        ends = self.at_ends(length_of(at - centre.centre) + radius + centre.radius)
        wanted = away.away(np.zeros(3))
        spread = ZERO if x.speed.is_zero() and centre.speed.is_zero() else 0.5 * wanted.speed
        wanted = replace(wanted, size=lesser(ends, wanted.size) + spread)
        along = between(x, centre).along(k, np.zeros(3))
        level = wanted.half_square
        for part in (gap, along, across):
            level = level.plus(part.half_square)
        return self._balanced(joint, gap.times(across), level, root)

    def _balanced(self, joint: int, z: Scalar, level: Scalar, root: ca.SX) -> Stepped:
        """Of A cos q + B sin q = C, Z = (A, B): at the ends |C| is at most |Z|. Where Z stays D may
        be led on in a straight line of C below zero, so that it bends no more than up to there.
        """
        spread = ZERO if z.speed.is_zero() else 0.5 * level.speed
        farthest = min(self.at_ends(z.size) + spread, level.size, key=self.usual)
        bend = z.speed**2 + z.size * z.bend + farthest * level.bend
        decided = Decided(
            joint,
            (z.speed + level.speed) / root,
            curved=min(z.size, level.size, key=self.usual) / root,
            crossed=z.speed / root,
            own=(z.bend + level.bend) / root,
        )
        return Stepped(z.size**2, (decided,), bend=bend)

    def _is_angle(self, fixed: Moving, own: Moving, x: Moving, k: np.ndarray) -> bool:
        """Whether a level is the cosine of the joint's angle: of directions that stay and are
        across its axis.
        """
        still = all(v.radius.is_zero() and v.speed.is_zero() for v in (fixed, own, x))
        return still and all(size_of(v.centre @ k) == 0.0 for v in (own, x))

    def _angle(self, joint: int, level: Scalar, root: ca.SX) -> Stepped:
        """Of cos q = n . y, the angle of two directions: it changes by as much as y turns; y goes
        by q' towards n and by sin(q) p' across, and q'' is y'' towards n and sin(q) cos(q) p'^2.
        """
        decided = Decided(joint, level.speed, own=level.bend + level.speed**2 / root)
        return Stepped(ca.SX(1), (decided,), speed=level.speed, is_sine=True)

    def _slid_to(self, joint: int, a: Scalar, half: Scalar, root: ca.SX) -> Stepped:
        """Of d^2 + 2 A d = C: D = A^2 + C, d + A = r = +-sqrt(D), half of C beside d^2 / 2."""
        end, wide = self.ends[joint], self.ends[joint] + 0.5 * self.speeds[joint]
        decided = Decided(
            joint,
            (end * a.speed + half.speed) / root,
            curved=1 / root,
            crossed=a.speed / root,
            own=(wide * a.bend + half.bend) / root,
        )
        size = a.size**2 + 2 * half.size
        bend = a.half_square.bend + half.bend
        return Stepped(size, (decided,), bend=bend, less=0.5 * a.speed)

    def _quotient(
        self,
        joints: tuple[int, ...],
        over: Sequence[Scalar],
        under: Scalar,
        root: ca.SX,
        *,
        is_square: bool = True,
    ) -> Stepped:
        """Of d = C / A, joint by joint; the guard is A^2, or A."""
        found = []
        for joint, c in zip(joints, over, strict=True):
            end, wide = self.ends[joint], self.ends[joint] + 0.5 * self.speeds[joint]
            decided = Decided(
                joint,
                (c.speed + end * under.speed) / root,
                crossed=under.speed / root,
                own=(c.bend + wide * under.bend) / root,
            )
            found.append(decided)
        size, bend = under.size, 0.5 * under.bend
        if is_square:
            size, bend = under.size**2, under.half_square.bend
        less = 0.5 * under.speed
        return Stepped(size, tuple(found), bend=bend, is_square=is_square, less=less)

    def _slid(self, step: Slides, root: ca.SX) -> Stepped:
        """Slides s of sum s_i w_i = r, by Cramer's rule: directions w, carried by what stands
        before.
        """
        turns = tuple(factor for factor in step.chain if factor.joint not in step.joints)
        away = between(self.value(step.x.carried(step.target)), self.value(step.x.carried(turns)))
        ends = sum((self.ends[joint] for joint in step.joints), ca.SX(0))
        r = Scalar(ends + 0.5 * away.speed, away.speed, away.bend)
        w = []
        for joint in step.joints:
            place = next(i for i, f in enumerate(step.chain) if f.joint == joint)
            axis = at_rest(np.array(self.arm.screws[joint].axis))
            carried = self.carry(step.chain[:place], axis, is_point=False)
            w.append(Scalar(ca.SX(1), carried.speed, carried.bend))
        if len(w) == 1:
            return self._quotient(step.joints, [w[0].times(r)], ONE, root)
        if len(w) == 2:
            both = w[0].times(w[1])
            over = [w[i].times(r).plus(both.times(w[1 - i].times(r))) for i in range(2)]
            under = replace(both.times(both), size=ca.SX(1))
            return self._quotient(step.joints, over, under, root, is_square=False)
        pairs = [w[1].times(w[2]), w[2].times(w[0]), w[0].times(w[1])]
        over = [pair.times(r) for pair in pairs]
        return self._quotient(step.joints, over, w[0].times(pairs[0]), root)

    def _spun_by(self, step: Carry, screw: Screw, decided: Decided) -> Decided:
        """Of a turn that takes a direction across the axis to another one: as these stay across it,
        they turn as that part of their angular velocity does that is along the axis, of parallel
        axes as far as the joints go.
        """
        k = np.array(screw.axis)
        if step.x.is_point or step.x.word or size_of(k @ np.array(step.x.vector)) > 0.0:
            return decided
        first, whole, word = ZERO, ZERO, step.y.word
        for i, factor in enumerate(word):
            if factor.joint == TOOL:
                first, whole = first + self.turn, whole + self.turn
            elif not self.arm.screws[factor.joint].slides:
                axis = at_rest(np.array(self.arm.screws[factor.joint].axis))
                tilted = self._reached_direction(word[:i], axis)
                share = lesser(tilted.along(k, np.zeros(3)).size, ca.SX(1))
                along = size_of(norm_of(np.cross(k, tilted.centre))) == 0.0
                is_parallel = along and tilted.radius.is_zero()
                first = first + share * self.speeds[factor.joint]
                ways = self.ways if is_parallel else self.speeds
                whole = whole + share * ways[factor.joint]
        return replace(decided, speed=first, way=whole)

    def _least_across(self, operand: Operand, screw: Screw, point: np.ndarray) -> float:
        """How far from an axis a vector is at least, whatever its joints do."""
        if any(factor.joint == TOOL for factor in operand.word):
            return 0.0
        moving, k = self.value(operand), np.array(screw.axis)
        gap = moving.centre - point
        away = size_of(norm_of(gap - k * (k @ gap)))
        return max(0.0, away / _MORE - float(moving.radius)) if moving.radius.is_constant() else 0.0

    def _keeps_side(self, operand: Operand, screw: Screw) -> bool:
        """Whether the only motion of a vector is a turn in a plane that holds the axis: its part
        across the axis keeps its direction.
        """
        joints = [factor.joint for factor in operand.word]
        if len(joints) != 1 or joints[0] == TOOL or self.arm.screws[joints[0]].slides:
            return False
        other = self.arm.screws[joints[0]]
        normal, unit = np.array(other.axis), self.arm.size if operand.is_point else 1.0
        point = self._point(screw, is_point=operand.is_point)
        level = normal @ (np.array(operand.vector) / unit - point)
        return size_of(normal @ np.array(screw.axis)) == 0.0 and size_of(level) == 0.0
