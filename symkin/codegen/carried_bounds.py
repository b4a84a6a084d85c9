"""Bound how fast points and directions that an arm carries go along a part of a line of tool poses.

Along a part, t from 0 to 1, the tool's place goes straight by `place` (over the size) and its turn
is that of a quaternion between two, at a speed of at most `turn`. A point or direction x that a
joint carries by its angle q with |q'| <= v, |q''| <= a goes as

    |(F x)'| <= |x'| + v r,    |(F x)''| <= |x''| + 2 v |x'| + (a + v^2) r,

r its largest distance from the axis, and the tool's motion likewise: of the quaternion between two
|R''| <= turn^2. Distances hold at both ends of the part, where the tool is on the arm, and by half
of the change between them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closed.screws import ArmScrews, Screw
from symkin.closed.steps import TOOL, Factor, Operand, Word, inverse
from symkin.codegen.moving_bounds import Moving, at_rest, length_of, lesser
from symkin.computed_once import cached_property


@dataclass(frozen=True, eq=False)
class CarriedBounds:
    """Bounds of what an arm carries as expressions of what changes along a part."""

    arm: ArmScrews

    @cached_property
    def place(self) -> ca.SX:
        """Way of the tool's place (over the size)."""
        return ca.SX.sym("place")

    @cached_property
    def turn(self) -> ca.SX:
        """Largest speed of the tool's turn."""
        return ca.SX.sym("turn")

    @cached_property
    def speeds(self) -> ca.SX:
        """Bounds of the joints' speeds (angles; slides over the size)."""
        return ca.SX.sym("v", len(self.arm))

    @cached_property
    def bends(self) -> ca.SX:
        """Bounds of the speeds' changes."""
        return ca.SX.sym("a", len(self.arm))

    @cached_property
    def ways(self) -> ca.SX:
        """How far joints go from one end of the part to the other."""
        return ca.SX.sym("d", len(self.arm))

    @cached_property
    def ends(self) -> ca.SX:
        """How far slides are from their zeros at the farther end of the part (over the size)."""
        return ca.SX.sym("e", len(self.arm))

    @cached_property
    def _flat(self) -> np.ndarray | None:
        """The direction about which all turning joints turn, and with them the tool; None where
        there is none.
        """
        axes = [np.array(screw.axis) for screw in self.arm.screws if not screw.slides]
        are_parallel = axes and all(length_of(np.cross(axes[0], axis)) == 0.0 for axis in axes)
        return axes[0] if are_parallel else None

    def _rises(self, joint: int) -> bool:
        """Whether a joint slides along the direction about which all others turn: these bring
        vectors to where they must be across that direction alone.
        """
        screw, flat = self.arm.screws[joint], self._flat
        along = flat is not None and length_of(np.cross(flat, np.array(screw.axis))) == 0.0
        return screw.slides and along

    # --- what moves -------------------------------------------------------------------------------

    def value(self, operand: Operand) -> Moving:
        """A point or direction carried by motions."""
        unit = self.arm.size if operand.is_point else 1.0
        return self.carry(
            operand.word, at_rest(np.array(operand.vector) / unit), is_point=operand.is_point
        )

    def carry(self, word: Word, still: Moving, *, is_point: bool) -> Moving:
        """What motions make of a point or direction."""
        moving = still
        for i, factor in reversed(list(enumerate(word))):
            if factor.joint != TOOL:
                moving = self._by_joint(factor.joint, moving, is_point=is_point)
            elif is_point:
                ball = self._reached(factor, word[i + 1 :], still)
                moving = self._by_tool(factor, moving, *ball)
            else:
                radius = lesser(moving.away(np.zeros(3)).size, ca.SX(1))
                moving = self._spun(np.zeros(3), radius, moving.speed, moving)
        return moving

    def _by_joint(self, joint: int, moving: Moving, *, is_point: bool) -> Moving:
        speed, bend = self.speeds[joint], self.bends[joint]
        if self.arm.screws[joint].slides:
            if not is_point:
                return moving
            wide = self.ends[joint] + 0.5 * speed
            radius = moving.radius + wide
            return Moving(moving.centre, radius, moving.speed + speed, moving.bend + bend)
        at, radius = self._turned(joint, moving, is_point=is_point)
        return Moving(
            at,
            radius,
            moving.speed + speed * radius,
            moving.bend + 2 * speed * moving.speed + (bend + speed**2) * radius,
        )

    def _turned(self, joint: int, moving: Moving, *, is_point: bool) -> tuple[np.ndarray, ca.SX]:
        """Where on a joint's axis the centre is, and how far from it what moves is at most."""
        screw = self.arm.screws[joint]
        k, point = np.array(screw.axis), self._point(screw, is_point=is_point)
        radius = moving.across(screw, point).size
        if not is_point:
            radius = lesser(radius, ca.SX(1))
        return point + k * (k @ (moving.centre - point)), radius

    def _by_tool(self, factor: Factor, moving: Moving, at: np.ndarray, reach: ca.SX) -> Moving:
        """What the tool's motion makes of a point, which is then within reach of `at` at the ends
        of the part: M v = R (T0^-1 v) + p, or M^-1 v = T0 R^T (v - p).
        """
        tool = np.array(self.arm.tool.position) / self.arm.size
        if factor.sign > 0:
            arm = tool - moving.centre
            if self._flat is not None:
                arm = arm - self._flat * (self._flat @ arm)
            spun = self._spun(at, length_of(arm) + moving.radius, moving.speed, moving)
            speed = spun.speed + self.place
            return Moving(at, reach + 0.5 * speed, speed, spun.bend)
        speed = moving.speed + self.place
        return self._spun(tool, length_of(at - tool) + reach + 0.5 * speed, speed, moving)

    def _spun(self, at: np.ndarray, radius: ca.SX, speed: ca.SX, moving: Moving) -> Moving:
        """What the tool's turn moves, of which the speed beside it is told."""
        return Moving(
            at,
            radius,
            speed + self.turn * radius,
            moving.bend + 2 * self.turn * speed + self.turn**2 * radius,
        )

    def _reached(self, factor: Factor, inner: Word, still: Moving) -> tuple[np.ndarray, ca.SX]:
        """A ball that holds a point carried by an inner word and the tool's motion where that is
        the one of all joints.
        """
        told = self._by_joints((factor, *inner))
        at, radius = still.centre, still.radius
        for one in reversed(told):
            if self.arm.screws[one.joint].slides:
                radius = radius + self.ends[one.joint]
            else:
                turned = replace(still, centre=at, radius=radius)
                at, radius = self._turned(one.joint, turned, is_point=True)
        return at, radius

    def _by_joints(self, word: Word) -> Word:
        """Motions without the tool's, which is that of all joints."""
        chain: Word = tuple(Factor(i) for i in range(len(self.arm)))
        found: Word = ()
        chain = tuple(factor for factor in chain if not self._rises(factor.joint))
        for factor in word:
            own = (factor,) if factor.joint != TOOL else chain
            for one in own if factor.joint != TOOL or factor.sign > 0 else inverse(own):
                found = found[:-1] if found[-1:] == (one.inverse,) else (*found, one)
        return found

    def _point(self, screw: Screw, *, is_point: bool) -> np.ndarray:
        return np.array(screw.point) / self.arm.size if is_point else np.zeros(3)

    def _reached_direction(self, word: Word, still: Moving) -> Moving:
        """A ball that holds a direction carried by motions, the tool's as that of all joints."""
        moving = self.carry(self._by_joints(word), still, is_point=False)
        return replace(moving, radius=self.at_ends(moving.radius))

    # --- what need not be carried -----------------------------------------------------------------

    def _level_off(self, operand: Operand) -> Operand:
        """A vector without slides along the direction about which all other joints turn."""
        word = tuple(f for f in operand.word if f.joint == TOOL or not self._rises(f.joint))
        return replace(operand, word=word)

    def _less(self, fixed: Operand, moved: Operand) -> Operand:
        """A vector without the outer turns about axes that leave alone what is asked of it: its
        distance from a `fixed` point, its level along a fixed direction.
        """
        while moved.word and not fixed.word and self._leaves(moved.word[0].joint, fixed):
            moved = replace(moved, word=moved.word[1:])
        return moved

    def _leaves(self, joint: int, fixed: Operand) -> bool:
        if joint == TOOL or self.arm.screws[joint].slides:
            return False
        screw, unit = self.arm.screws[joint], self.arm.size if fixed.is_point else 1.0
        gap = np.array(fixed.vector) / unit - self._point(screw, is_point=fixed.is_point)
        return length_of(np.cross(np.array(screw.axis), gap)) == 0.0

    # --- how large bounds are ---------------------------------------------------------------------

    def at_ends(self, expression: ca.SX) -> ca.SX:
        """A distance at the ends of the part."""
        moved = ca.vertcat(self.place, self.turn, self.speeds, self.bends)
        return ca.substitute(expression, moved, ca.DM.zeros(moved.shape[0]))

    def usual(self, expression: ca.SX, value: float = 0.1) -> float:
        """What a bound is where all goes at one speed, and slides are as far away."""
        moved = ca.vertcat(self.place, self.turn, self.speeds, self.bends, self.ways, self.ends)
        told = ca.substitute(expression, moved, value * ca.DM.ones(moved.shape[0]))
        return float(ca.evalf(told))
