"""C of serial arms: explicit direct problem and Jacobian with sin and cos of libm, inverse by Newton from a guess.

The inverse problem walks from the guess's tool pose to the given one: positions along a line, orientations along the
shorter arc.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.caching import cached_property
from symkin.closure.snapping import snapped_expression
from symkin.codegen.closed import line_target, ranges
from symkin.codegen.emit import Emitter, Real, indent, indexed
from symkin.codegen.factor import curvature
from symkin.codegen.geometry import Geometry
from symkin.codegen.kernel import Kernel, system_kernel
from symkin.codegen.options import Options
from symkin.codegen.source import KernelSource, common_values, copy, fill, kernel_source
from symkin.errors import InputError
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.position.problem import Problem, build_problem
from symkin.spatial.rotation import conjugate, multiply


@dataclass(frozen=True, eq=False)
class SerialArm:
    """A serial arm with its options: what the emitters read."""

    mechanism: Mechanism
    options: Options
    real: Real

    @property
    def name(self) -> str:
        return self.mechanism.name

    @cached_property
    def inverse(self) -> Problem:
        return build_problem(self.mechanism, "inverse")

    @property
    def actuated(self) -> tuple[Coordinate, ...]:
        return self.mechanism.actuated

    @cached_property
    def joints(self) -> ca.SX:
        """Joint symbols in file order: the unknowns of the inverse problem."""
        return self.inverse.system.unknown

    @cached_property
    def pose(self) -> ca.SX:
        """Tool pose (x, y, z, qw, qx, qy, qz) of the joints."""
        closure = self.inverse.closure
        assert closure.forward is not None  # noqa: S101 - every serial arm has it
        pose = self.geometry.of(ca.vertcat(closure.forward.position, closure.forward.quaternion))
        return snapped_expression(pose, [self.joints, self.geometry.symbols])

    @cached_property
    def jacobian(self) -> ca.SX:
        """Twist (velocity; angular velocity) by joint rates, 6 x N: 2 dq q* is the angular velocity's quaternion."""
        rates = ca.jacobian(self.pose, self.joints)
        q = self.pose[3:]
        columns = []
        for i in range(int(self.joints.shape[0])):
            spin = multiply(2 * rates[3:, i], conjugate(q))
            columns.append(ca.vertcat(rates[:3, i], spin[1:]))
        return ca.horzcat(*columns)

    @cached_property
    def geometry(self) -> Geometry:
        return Geometry(self.inverse.closure, self.options.geometry == "struct")

    def forward_at(self, joints: np.ndarray) -> np.ndarray:
        """Tool pose (7,) of joint values, nominal geometry."""
        return np.asarray(self._forward(joints, self.geometry.values)).ravel()

    def jacobian_at(self, joints: np.ndarray) -> np.ndarray:
        """Jacobian (6, N) at joint values, nominal geometry."""
        return np.asarray(self._rates(joints, self.geometry.values))

    @cached_property
    def _forward(self) -> ca.Function:
        return ca.Function("forward", [self.joints, self.geometry.symbols], [ca.densify(self.pose)])

    @cached_property
    def _rates(self) -> ca.Function:
        return ca.Function("jacobian", [self.joints, self.geometry.symbols], [ca.densify(self.jacobian)])

    @cached_property
    def kernel(self) -> Kernel:
        system = self.geometry.system(self.inverse)
        return system_kernel("inverse", system, system.known, (False,) * 7, 3, self.geometry.symbols)

    @cached_property
    def samples(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Joint values and their poses: within 0.8 rad and a tenth of the size of the middle, limits respected."""
        rng = np.random.default_rng(4)
        found = []
        for _ in range(60):
            q = np.array([_middle(c, self.mechanism.size, float(rng.uniform(-1, 1))) for c in self.actuated])
            found.append((q, self.forward_at(q)))
        return found

    @property
    def is_redundant(self) -> bool:
        """A tool pose does not decide the joints."""
        return len(self.actuated) > 6

    def check(self) -> None:
        count, rank = len(self.actuated), self.inverse.generic_rank
        if rank < min(6, count):
            raise InputError(
                f"{self.name}: its {count} joints move the tool in {rank} directions only, so that no step is decided; C is "
                "generated for arms whose joints are independent, or that reach all six directions"
            )


def _meaning(arm: SerialArm) -> str:
    """What OK says of the joint values, as lines of a comment in the header."""
    if not arm.is_redundant:
        return ""
    return "\n".join(
        [
            f" * The arm has {len(arm.actuated)} joints, so that a pose leaves {len(arm.actuated) - 6} of them free: each step is the shortest that",
            " * its linear system allows (angles times the size), and the line is cut where a step is too long. The answer is the",
            " * one of the joints' shortest motion from `guess`, as fine as these steps follow it; its tool pose is exact. A closed",
            " * path of poses need not lead back to the same joint values.",
        ]
    )


def _middle(c: Coordinate, size: float, part: float) -> float:
    middle = 0.5 * (c.limits[0] + c.limits[1]) if c.limits else c.reference[0]
    spread = 0.8 if c.is_angular else 0.1 * size
    if c.limits:
        spread = min(spread, 0.45 * (c.limits[1] - c.limits[0]))
    return round(middle + spread * part, 6)


def serial_source(arm: SerialArm) -> tuple[str, KernelSource, dict[str, object]]:
    """Everything of NAME.c between its beginning and end, the inverse kernel, and the values that templates need."""
    arm.check()
    real, name, kernel = arm.real, arm.name, arm.kernel
    nq, geometry = len(arm.actuated), arm.geometry
    values = common_values(name, real, geometry.at_run_time) | {
        "nq": nq, "ns": nq, "meaning": _meaning(arm), "least_norm": real.literal(0.98), "most_norm": real.literal(1.0201), "nj": 6 * nq,
    }  # fmt: skip
    matrices = np.array([kernel.matrix(q, pose, geometry.values) for q, pose in arm.samples])
    regular = [k for k, m in enumerate(matrices) if np.linalg.cond(m) < 1e6]
    states, poses = [arm.samples[k][0] for k in regular], [arm.samples[k][1] for k in regular]
    kappa = curvature(kernel, states, poses, geometry.values)
    source = kernel_source(kernel, name, real, geometry.names, matrices, line_target(real, 7, 3), kappa)
    symbols = [arm.joints, geometry.symbols]
    forward = Emitter(ca.Function("f", symbols, [ca.densify(arm.pose)], {"cse": True}), [indexed("q", nq), geometry.names], real)
    texts = [forward.value(0, i) for i in range(7)]
    body = [*forward.lines, *(f"x[{i}] = {text};" for i, text in enumerate(texts))]
    matrix = Emitter(
        ca.Function("j", symbols, [ca.densify(arm.jacobian)], {"cse": True}), [indexed("joints", nq), geometry.names], real
    )
    entries = [f"jacobian[{nq * i + j}] = {matrix.value(0, 6 * j + i)};" for i in range(6) for j in range(nq)]
    text = fill("unit.c", values)
    text += fill("joints.c", values | {"positive": "", "ranges": ranges(arm.actuated, real, arm.mechanism.size)})
    text += fill("forward.c", values | {"forward": indent(body)})
    text += source.text + fill("serial.c", values | {
        "jacobian": indent([*matrix.lines, *entries], 2), "to_x": indent(copy("w.x", "guess", nq), 2),
        "out": indent(copy("joints", "w.x", nq), 3),
    })  # fmt: skip
    return text, source, values
