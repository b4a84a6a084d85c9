"""The steps of a plan as CasADi expressions: motions of joints with their cosines and sines, branch
signs, discriminants.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import casadi as ca
import numpy as np

from symkin.closed.screws import ArmScrews, Screw
from symkin.closed.steps import TOOL, Carry, Distance, Factor, Level, Operand, Slides, Step, Word
from symkin.closure.snapping import snapped_constants
from symkin.spatial.rotation import matrix_from_quaternion, multiply

_LEVEL = 1e-12
"""Cosine of two axes that are across each other, but for rounding."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A joint's motion: cosine and sine of its angle, or its slide; `value` is the angle or the
    slide.
    """

    value: ca.SX
    cosine: ca.SX = field(default_factory=lambda: ca.SX(1))
    sine: ca.SX = field(default_factory=lambda: ca.SX(0))

    @staticmethod
    def turn(cosine: ca.SX, sine: ca.SX) -> Motion:
        """A rotation by the direction (cosine, sine) of unit length."""
        return Motion(ca.atan2(sine, cosine), cosine, sine)

    @staticmethod
    def towards(cosine: ca.SX, sine: ca.SX) -> Motion:
        """A rotation by a direction of any length."""
        scale = 1 / ca.sqrt(cosine * cosine + sine * sine)
        return Motion(ca.atan2(sine, cosine), scale * cosine, scale * sine)

    @property
    def pair(self) -> tuple[ca.SX, ca.SX]:
        """Cosine and sine of the angle, of one that a step decides up to one factor above zero; a
        slide and 0.
        """
        if self.value.is_op(ca.OP_ATAN2):
            return self.value.dep(1), self.value.dep(0)
        slides = self.sine.is_zero() and self.cosine.is_one()
        return (self.value, ca.SX(0)) if slides else (self.cosine, self.sine)


@dataclass(frozen=True, eq=False)
class Decision:
    """Motions that a step decides; how far its equation is from a double root and from leaving the
    joint undecided (squares over the size's, negative `discriminant`: no real solution).
    """

    motions: tuple[Motion, ...]
    discriminant: ca.SX
    strength: ca.SX


@dataclass(frozen=True, eq=False)
class Evaluation:
    """An arm at one tool pose (`position` (3), `quaternion` (4) of unit length) with the motions
    that are decided so far.
    """

    arm: ArmScrews
    position: ca.SX
    quaternion: ca.SX
    motions: dict[int, Motion] = field(default_factory=dict)

    def decided(self, joints: tuple[int, ...], motions: tuple[Motion, ...]) -> Evaluation:
        return replace(self, motions=self.motions | dict(zip(joints, motions, strict=True)))

    @property
    def _place(self) -> ca.SX:
        """The tool's position in the frame of the screws."""
        base = self.arm.base
        return self.position if base is None else ca.mtimes(ca.DM(base.rotation), self.position)

    @property
    def _turn(self) -> ca.SX:
        """The tool's quaternion in the frame of the screws."""
        base = self.arm.base
        return self.quaternion if base is None else multiply(base.quaternion, self.quaternion)

    # --- vectors that motions carry ---------------------------------------------------------------

    def value(self, operand: Operand) -> ca.SX:
        return self.carry(
            operand.word, ca.SX(ca.DM(list(operand.vector))), is_point=operand.is_point
        )

    def carry(self, word: Word, v: ca.SX, *, is_point: bool) -> ca.SX:
        for factor in reversed(word):
            v = self._moved(factor, v, is_point=is_point)
        return v

    def _moved(self, factor: Factor, v: ca.SX, *, is_point: bool) -> ca.SX:
        if factor.joint == TOOL:
            return (
                self._with_tool(v, is_point=is_point)
                if factor.sign > 0
                else self._from_tool(v, is_point=is_point)
            )
        screw, motion = self.arm.screws[factor.joint], self.motions[factor.joint]
        if screw.slides:
            return v + factor.sign * motion.value * _column(screw.axis) if is_point else v
        circle = Circle.of(screw, v, is_point=is_point)
        return (
            circle.centre + motion.cosine * circle.cosine + factor.sign * motion.sine * circle.sine
        )

    def _with_tool(self, v: ca.SX, *, is_point: bool) -> ca.SX:
        """M v = R (T0^-1 v) + p."""
        tool = self.arm.tool
        local = v - _column(tool.position) if is_point else v
        turned = ca.mtimes(
            matrix_from_quaternion(self._turn), ca.mtimes(_matrix(tool.quaternion).T, local)
        )
        return turned + self._place if is_point else turned

    def _from_tool(self, v: ca.SX, *, is_point: bool) -> ca.SX:
        """M^-1 v = T0 (R^T (v - p))."""
        tool = self.arm.tool
        local = ca.mtimes(matrix_from_quaternion(self._turn).T, v - self._place if is_point else v)
        turned = ca.mtimes(_matrix(tool.quaternion), local)
        return turned + _column(tool.position) if is_point else turned

    # --- steps ------------------------------------------------------------------------------------

    def decide(self, step: Step, sign: ca.SX | float) -> Decision:
        """The step's solution of the branch `sign` (1 or -1)."""
        match step:
            case Carry():
                return self._carried(step)
            case Level() | Distance():
                return self._balanced(step, sign)
            case Slides():
                return self._slid(step)
        raise AssertionError(step)

    def slope(self, step: Step) -> ca.SX:
        """What has the sign of the branch at known motions."""
        assert isinstance(step, Level | Distance)  # noqa: S101 - no other step has branches
        (joint,) = step.joints
        motion = self.motions[joint]
        return self.lean(
            step, motion.value if self.arm.screws[joint].slides else motion.cosine, motion.sine
        )

    def lean(self, step: Step, cosine: ca.SX, sine: ca.SX) -> ca.SX:
        """What has the sign of the branch nearest to an angle, by its cosine and sine, or to a
        slide (in place of the cosine).
        """
        assert isinstance(step, Level | Distance)  # noqa: S101 - no other step has branches
        (joint,) = step.joints
        a, b, _ = self._equation(step)
        return cosine + a if self.arm.screws[joint].slides else a * sine - b * cosine

    def discriminant_scale(self, step: Step) -> float:
        """What the square of `slope` is divided by in the step's discriminant."""
        assert isinstance(step, Level | Distance)  # noqa: S101 - no other step has branches
        if self.arm.screws[step.joints[0]].slides:
            return self.arm.size**2
        return (self._scale(step.x) if isinstance(step, Level) else self.arm.size**2) ** 2

    def _scale(self, *operands: Operand) -> float:
        return self.arm.size if all(operand.is_point for operand in operands) else 1.0

    def _carried(self, step: Carry) -> Decision:
        (joint,) = step.joints
        screw = self.arm.screws[joint]
        if screw.slides:
            along = ca.dot(_column(screw.axis), self.value(step.y) - self.value(step.x))
            return Decision((Motion(step.sign * along),), ca.SX(1), ca.SX(1))
        cosine, sine = self._directions(step)
        strength = ca.sqrt(cosine * cosine + sine * sine) / self._scale(step.x) ** 2
        return Decision((Motion.towards(cosine, sine),), ca.SX(1), strength)

    def _directions(self, step: Carry) -> tuple[ca.SX, ca.SX]:
        """Cosine and sine of a turn that carries x to y, times the lengths of both across the
        axis.
        """
        screw, x, y = self.arm.screws[step.joints[0]], self.value(step.x), self.value(step.y)
        k = _column(screw.axis)
        if step.x.is_point:
            x, y = x - _column(screw.point), y - _column(screw.point)
        return ca.dot(x, y) - ca.dot(k, x) * ca.dot(k, y), step.sign * ca.dot(k, ca.cross(x, y))

    def _balanced(self, step: Level | Distance, sign: ca.SX | float) -> Decision:
        """A cos q + B sin q = C; of a slide d: A d = C, or d^2 + 2 A d = C."""
        (joint,) = step.joints
        a, b, c = self._equation(step)
        if self.arm.screws[joint].slides:
            if isinstance(step, Level):
                return Decision((Motion(c / a),), ca.SX(1), a * a)
            discriminant = a * a + c
            motion = Motion(sign * _root(discriminant) - a)
            return Decision((motion,), discriminant / self.discriminant_scale(step), ca.SX(1))
        squares = a * a + b * b
        crossed, inverse = self._crossed(step), 1 / squares
        discriminant = squares - c * c if crossed is None else crossed
        across = sign * _root(discriminant)
        motion = Motion.turn(inverse * (a * c - b * across), inverse * (b * c + a * across))
        scale = self.discriminant_scale(step)
        return Decision((motion,), discriminant / scale, squares / scale)

    def _crossed(self, step: Level | Distance) -> ca.SX | None:
        """The discriminant of a level that is the cosine of the joint's angle, by the cross product
        of its two directions: 1 - C^2 has lost the digits where these are nearly along each other.
        """
        if not isinstance(step, Level) or step.before or step.x.is_point:
            return None
        k = _column(self.arm.screws[step.joints[0]].axis)
        normal, x = self.value(step.normal), self.value(step.x)
        tilts = ca.vertcat(ca.dot(k, normal), ca.dot(k, x))
        if not tilts.is_constant() or np.abs(ca.DM(tilts).full()).max() > _LEVEL:
            return None
        crossed = ca.cross(self.value(step.level_normal), self.value(step.y))
        return ca.dot(crossed, crossed)

    def _equation(self, step: Level | Distance) -> tuple[ca.SX, ca.SX, ca.SX]:
        (joint,) = step.joints
        screw = self.arm.screws[joint]
        return self._level(step, screw) if isinstance(step, Level) else self._distance(step, screw)

    def _level(self, step: Level, screw: Screw) -> tuple[ca.SX, ca.SX, ca.SX]:
        normal, x = self.value(step.normal), self.value(step.x)
        level = ca.dot(self.value(step.level_normal), self.value(step.y))
        if screw.slides:
            along = ca.dot(normal, self.carry(step.before, _column(screw.axis), is_point=False))
            return (
                step.sign * along,
                ca.SX(0),
                level - ca.dot(normal, self.carry(step.before, x, is_point=step.x.is_point)),
            )
        circle = Circle.of(screw, x, is_point=step.x.is_point)
        centre = self.carry(step.before, circle.centre, is_point=step.x.is_point)
        cosine, sine = (
            self.carry(step.before, v, is_point=False) for v in (circle.cosine, circle.sine)
        )
        return (
            ca.dot(normal, cosine),
            step.sign * ca.dot(normal, sine),
            level - ca.dot(normal, centre),
        )

    def _distance(self, step: Distance, screw: Screw) -> tuple[ca.SX, ca.SX, ca.SX]:
        x, centre = self.value(step.x), self.value(step.centre)
        away = self.value(step.y) - self.value(step.other)
        wanted = ca.dot(away, away)
        if screw.slides:
            gap = x - centre
            return step.sign * ca.dot(_column(screw.axis), gap), ca.SX(0), wanted - ca.dot(gap, gap)
        circle = Circle.of(screw, x, is_point=True)
        gap = circle.centre - centre
        level = 0.5 * (wanted - ca.dot(gap, gap) - ca.dot(circle.cosine, circle.cosine))
        return ca.dot(circle.cosine, gap), step.sign * ca.dot(circle.sine, gap), level

    def _slid(self, step: Slides) -> Decision:
        """sum of s_i w_i = M x - (F_1 ... F_n x without slides), w_i the slides' directions carried
        by what stands before them.
        """
        still = self.decided(step.joints, tuple(Motion(ca.SX(0)) for _ in step.joints))
        away = still.value(step.x.carried(step.target)) - still.value(step.x.carried(step.chain))
        places = [
            next(i for i, f in enumerate(step.chain) if f.joint == joint) for joint in step.joints
        ]
        w = []
        for place in places:
            factor = step.chain[place]
            axis = _column(self.arm.screws[factor.joint].axis)
            w.append(factor.sign * still.carry(step.chain[:place], axis, is_point=False))
        slides, strength = _solved(w, away)
        return Decision(tuple(Motion(s) for s in slides), ca.SX(1), strength)


@dataclass(frozen=True, eq=False)
class Circle:
    """x turned by q about an axis: centre + cos q cosine + sin q sine."""

    centre: ca.SX
    cosine: ca.SX
    sine: ca.SX

    @staticmethod
    def of(screw: Screw, x: ca.SX, *, is_point: bool) -> Circle:
        k, point = _column(screw.axis), _column(screw.point)
        r = x - point if is_point else x
        along = k * ca.dot(k, r)
        return Circle(point + along if is_point else along, r - along, ca.cross(k, r))


def _solved(w: list[ca.SX], r: ca.SX) -> tuple[list[ca.SX], ca.SX]:
    """s of sum s_i w_i = r, one to three unit vectors w, by least squares where there are fewer;
    how far they are from dependent.
    """
    if len(w) == 1:
        return [ca.dot(w[0], r)], ca.SX(1)
    if len(w) == 2:
        both = ca.dot(w[0], w[1])
        a, b, determinant = ca.dot(w[0], r), ca.dot(w[1], r), 1 - both * both
        return [(a - both * b) / determinant, (b - both * a) / determinant], determinant
    across = [ca.cross(w[1], w[2]), ca.cross(w[2], w[0]), ca.cross(w[0], w[1])]
    determinant = ca.dot(w[0], across[0])
    return [ca.dot(c, r) / determinant for c in across], determinant * determinant


def _root(x: ca.SX) -> ca.SX:
    """Square root, 0 of what is negative."""
    return ca.sqrt(0.5 * (x + ca.fabs(x)))


def _column(v: object) -> ca.SX:
    return ca.SX(ca.DM([float(x) for x in np.asarray(v)]))


def _matrix(quaternion: object) -> ca.SX:
    rotation = snapped_constants(ca.SX(ca.DM(matrix_from_quaternion(np.asarray(quaternion)))))
    assert rotation is not None  # noqa: S101 - numbers stay numbers
    return rotation
