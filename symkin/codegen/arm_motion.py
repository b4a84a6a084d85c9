"""Tool pose and Jacobian of an arm from cosine and sine of half its joints' angles, and the C that
both share.

Each joint's axis and a point on it are carried by the joints before: the Jacobian's columns are (a
x (tool - p); a) of a turn, (a; 0) of a slide, so that nothing is differentiated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closed.evaluation import Evaluation, Motion
from symkin.closed.screws import ArmScrews
from symkin.closed.steps import Factor, Operand, Word
from symkin.codegen.text.c import Emitter, Real, indexed
from symkin.codegen.text.gathered import gathered
from symkin.codegen.text.templates import fill
from symkin.codegen.text.turns import cosine_and_sine
from symkin.computed_once import cached_property
from symkin.spatial.rotation import multiply


@dataclass(frozen=True, eq=False)
class ArmMotion:
    """How the joints of one arm move its tool."""

    arm: ArmScrews
    real: Real

    # --- expressions ------------------------------------------------------------------------------

    @cached_property
    def halves(self) -> ca.SX:
        """Cosine and sine of half an angle, a slide and 0, joint by joint; each from its zero."""
        return ca.SX.sym("u", 2 * len(self.arm))

    @cached_property
    def motions(self) -> dict[int, Motion]:
        found = {}
        for i, screw in enumerate(self.arm.screws):
            c, s = self.halves[2 * i], self.halves[2 * i + 1]
            found[i] = Motion(c) if screw.slides else Motion(ca.SX(0), c * c - s * s, 2 * c * s)
        return found

    @property
    def turns(self) -> list[tuple[ca.SX, ca.SX]]:
        """The symbols that are cosine and sine of one angle."""
        return [
            (self.halves[2 * i], self.halves[2 * i + 1])
            for i, s in enumerate(self.arm.screws)
            if not s.slides
        ]

    def _carried(self, vector: tuple[float, float, float], before: int, *, is_point: bool) -> ca.SX:
        """A point or direction of the reference, carried by the first joints."""
        chain: Word = tuple(Factor(i) for i in range(before))
        still = replace(Evaluation(self.arm, ca.SX(3, 1), ca.SX(4, 1)), motions=self.motions)
        return still.value(Operand(vector, is_point, chain))

    @cached_property
    def pose(self) -> ca.SX:
        """Tool pose: position by the chain of motions, quaternion as the product of the turns'."""
        quaternion = ca.SX(ca.DM(np.asarray(self.arm.tool.quaternion, dtype=float)))
        for i in reversed(range(len(self.arm))):
            screw = self.arm.screws[i]
            if not screw.slides:
                turn = ca.vertcat(
                    self.halves[2 * i], *(self.halves[2 * i + 1] * k for k in screw.axis)
                )
                quaternion = multiply(turn, quaternion)
        base = self.arm.base
        if base is not None:
            quaternion = multiply(ca.DM(base.inverse().quaternion), quaternion)
        return ca.vertcat(self._told(self._tool), quaternion)

    def _told(self, vector: ca.SX) -> ca.SX:
        """A vector of the screws' frame as it is described."""
        base = self.arm.base
        return vector if base is None else ca.mtimes(ca.DM(base.rotation.T), vector)

    @cached_property
    def _tool(self) -> ca.SX:
        """The tool's position."""
        x, y, z = (float(v) for v in np.asarray(self.arm.tool.position))
        return self._carried((x, y, z), len(self.arm), is_point=True)

    @cached_property
    def jacobian(self) -> ca.SX:
        """Twist of the tool (velocity; angular velocity) by joint rates, 6 x N."""
        columns = []
        for i, screw in enumerate(self.arm.screws):
            axis = self._carried(screw.axis, i, is_point=False)
            if screw.slides:
                columns.append(ca.vertcat(self._told(axis), ca.SX(3, 1)))
            else:
                arm = self._tool - self._carried(screw.point, i, is_point=True)
                columns.append(ca.vertcat(self._told(ca.cross(axis, arm)), self._told(axis)))
        return ca.densify(ca.horzcat(*columns))

    # --- text -------------------------------------------------------------------------------------

    def emitter(self, expression: ca.SX, pose: ca.SX | None = None) -> Emitter:
        """Emitter of a function of the halves, whose C name is `u`, and of the symbols of their
        pose, `x`, if there are some.
        """
        symbols = [self.halves, ca.SX(0, 1) if pose is None else pose]
        (short,) = gathered([expression], symbols, self.turns)
        names = [indexed("u", 2 * len(self.arm)), indexed("x", symbols[1].shape[0])]
        return Emitter.of(self.real, list(zip(symbols, names, strict=True)), short)

    @property
    def _turned_lines(self) -> list[str]:
        """Statements that set u from the joint values."""
        lines = list[str]()
        for i, screw in enumerate(self.arm.screws):
            value = f"(joints[{i}] - {screw.zero})" if screw.zero else f"joints[{i}]"
            if screw.slides:
                lines += [f"u[{2 * i}] = {value};", f"u[{2 * i + 1}] = 0.0;"]
            elif self.real.name == "float":
                lines.append(f"name_cosine_and_sine(0.5 * {value}, &u[{2 * i}]);")
            else:
                lines += [
                    f"u[{2 * i}] = cos(0.5 * {value});",
                    f"u[{2 * i + 1}] = sin(0.5 * {value});",
                ]
        return lines

    @property
    def jacobian_lines(self) -> list[str]:
        """Statements of the Jacobian at half turns, row by row."""
        emitter = self.emitter(ca.vec(self.jacobian.T))
        return emitter.stored(indexed("jacobian", 6 * len(self.arm)))

    @property
    def text(self) -> str:
        """The functions that set half turns from joints, and the pose from half turns."""
        pose = self.emitter(self.pose).stored(indexed("x", 7))
        shown = {
            "turns": 2 * len(self.arm),
            "nn": len(self.arm),
            "turned": self._turned_lines,
            "pose_lines": pose,
        }
        turn = cosine_and_sine(self.real, shown) if self.real.name == "float" and self.turns else ""
        return turn + fill("arm_motion.c", shown)
