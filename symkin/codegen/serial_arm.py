"""Write the C of serial arms: explicit direct problem and Jacobian with sin and cos of libm,
inverse by Newton from a guess.

The inverse problem walks from the guess's tool pose to the given one: positions along a line,
orientations along the shorter arc.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import casadi as ca
import numpy as np

from symkin.closed.plan import Plan, plan_of
from symkin.closed.screws import ArmScrews, arm_screws
from symkin.closure.snapping import snapped_expression
from symkin.codegen.arm_frame import ArmFrame, unturned
from symkin.codegen.arm_motion import ArmMotion
from symkin.codegen.arm_speeds import arm_error, arm_speeds
from symkin.codegen.closed_line import ClosedLine
from symkin.codegen.closed_source import ClosedCode
from symkin.codegen.line_parts import line_target
from symkin.codegen.map.platform_rates import fastest
from symkin.codegen.map.record import Described, Source
from symkin.codegen.map.signature import ARM, ARM_SPEEDS, CLOSED_ARM, Function
from symkin.codegen.steps.geometry import Geometry
from symkin.codegen.steps.guard_text import Watched
from symkin.codegen.steps.guards import DETERMINANT
from symkin.codegen.steps.joint_ranges import range_functions, ranges_of
from symkin.codegen.steps.linear_solver import is_unrolled
from symkin.codegen.steps.newton_kernel import Kernel, curvature, system_kernel
from symkin.codegen.steps.newton_source import NewtonCode, tolerance_of
from symkin.codegen.text.c import Emitter, Real, if_ok, indexed
from symkin.codegen.text.templates import (
    FARTHEST,
    common_values,
    copy,
    farthest,
    fill,
    normalise_pose,
)
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.joint import Coordinate
from symkin.position.feasible_pose import closing_poses
from symkin.position.problem import Problem, build_problem, pose_names
from symkin.spatial.rotation import conjugate, multiply

NEARLY = 0.005
"""Axes that are off by less than this (rad, or of the size), as a calibration finds them, make an
arm nearly one with a closed form: its branches then begin Newton's method. Offsets that are
designed are larger, and branches that begin so far off are lost.
"""
_FINISHED = 64.0
"""Error of a branch, in roundings of the size, that is still held to meet a pose."""


def closed_misfit(real: Real, size: float) -> float:
    """How far (length unit, angles times the size) a branch of fewer joints may be from the pose
    that it is said to meet.
    """
    return 4.0 * tolerance_of(real, size) + _FINISHED * real.epsilon * size


def poses_between(begins: np.ndarray, ends: np.ndarray, part: float) -> np.ndarray:
    """Poses (n, 7) at a part of straight lines, orientations along the shorter arcs."""
    is_far = np.sum(begins[:, 3:] * ends[:, 3:], axis=1, keepdims=True) < 0.0
    begins = np.hstack([begins[:, :3], np.where(is_far, -1.0, 1.0) * begins[:, 3:]])
    poses = begins + part * (ends - begins)
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    return poses


@dataclass(frozen=True, eq=False)
class SerialArm(Described):
    """A serial arm with its options: what its C is written from."""

    templates: ClassVar[str] = "serial"

    @property
    def functions(self) -> tuple[Function, ...]:
        return (*ARM, *(CLOSED_ARM if self.plan is not None else ()), *ARM_SPEEDS)

    @cached_property
    def inverse(self) -> Problem:
        return build_problem(self.mechanism, pose_names(self.mechanism))

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
        """Twist (velocity; angular velocity) by joint rates, 6 x N: 2 dq q* is the angular
        velocity's quaternion.
        """
        rates = ca.jacobian(self.pose, self.joints)
        q = self.pose[3:]
        columns = []
        for i in range(self.joints.shape[0]):
            # dq/dt = (0, w) q / 2, so that w is the vector part of 2 dq/dt q*
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
        return ca.Function(
            "jacobian", [self.joints, self.geometry.symbols], [ca.densify(self.jacobian)]
        )

    @cached_property
    def kernel(self) -> Kernel:
        """The Newton iteration of the inverse problem."""
        return system_kernel(
            "inverse",
            self.geometry.system(self.inverse),
            self.inverse.known_coordinates,
            self.geometry.symbols,
        )

    @cached_property
    def samples(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Joint values and their poses: within 0.8 rad and a tenth of the size of the middle,
        limits respected.
        """
        rng = np.random.default_rng(4)
        found = []
        for _ in range(60):
            q = np.array([_middle(c, self.size, float(rng.uniform(-1, 1))) for c in self.actuated])
            found.append((q, self.forward_at(q)))
        return found

    @property
    def keeps_to_lines(self) -> bool:
        """Whether poses between two that the arm can take are such poses too: not of most arms of
        fewer than six joints, which then go by least squares along the line.
        """
        if len(self.actuated) >= 6:
            return True
        first, second = (np.array([pose for _, pose in self.samples[k::2]]) for k in (0, 1))
        middle = poses_between(first, second, 0.5)
        return bool(np.mean(closing_poses(self.mechanism, middle)) > 0.5)

    @cached_property
    def plan(self) -> tuple[Plan, bool] | None:
        """The arm's closed form, where it has one and the geometry is that of the code, and whether
        its axes are only nearly as that asks.
        """
        if self.options.geometry == "struct":
            return None
        exact = plan_of(self.mechanism)
        found = plan_of(self.mechanism, NEARLY) if exact is None else exact
        return None if found is None else (found, exact is None)

    @cached_property
    def follows_closed_form(self) -> bool:
        """Whether the inverse problem is the closed form along the line of poses; else it is
        Newton's method.
        """
        return self.plan is not None and not self.plan[1] and self.keeps_to_lines

    @property
    def can_be_compact(self) -> bool:
        return self.plan is None and is_unrolled(self.kernel, compact=False)

    @property
    def is_redundant(self) -> bool:
        return len(self.actuated) > 6

    def check(self) -> None:
        count, rank = len(self.actuated), self.inverse.generic_rank
        if rank < min(6, count):
            raise InputError(
                f"{self.name}: its {count} joints move the tool in {rank} directions only, so that "
                f"no step is decided; C is "
                "generated for arms whose joints are independent, or that reach all six directions"
            )


def _meaning(arm: SerialArm) -> str:
    """What OK says of the joint values, in words of the header."""
    if not arm.is_redundant:
        return ""
    return (
        f"The arm has {len(arm.actuated)} joints, so that a pose leaves {len(arm.actuated) - 6} of "
        "them free: each step is the shortest that its linear system allows (angles times the "
        "size), and the line is cut where a step is too long. The answer is the one of the joints' "
        "shortest motion from `guess`, as fine as these steps follow it; its tool pose is exact. A "
        "closed path of poses need not lead back to the same joint values."
    )


def _middle(c: Coordinate, size: float, part: float) -> float:
    middle = 0.5 * (c.limits[0] + c.limits[1]) if c.limits else c.reference[0]
    spread = 0.8 if c.is_angular else 0.1 * size
    if c.limits:
        spread = min(spread, 0.45 * (c.limits[1] - c.limits[0]))
    unit = 1.0 if c.is_angular else size
    return unit * round((middle + spread * part) / unit, 6)


@dataclass(frozen=True, eq=False)
class ArmSource(Source):
    """The C of one arm, function by function."""

    made: SerialArm

    @cached_property
    def code(self) -> NewtonCode:
        """The Newton iteration of the inverse problem; kappa is taken where the matrix is
        regular.
        """
        arm, kernel, geometry = self.made, self.made.kernel, self.made.geometry
        matrices = np.array([kernel.matrix(q, pose, geometry.values) for q, pose in arm.samples])
        regular = [
            sample
            for sample, m in zip(arm.samples, matrices, strict=True)
            if np.linalg.cond(m) < 1e6
        ]
        return NewtonCode(
            kernel=kernel,
            name=arm.name,
            real=self.real,
            geometry=geometry.names,
            matrices=matrices,
            kappa=curvature(
                kernel, [q for q, _ in regular], [pose for _, pose in regular], geometry.values
            ),
            target_lines=line_target(7, 3),
            compact=arm.options.compact,
        )

    @cached_property
    def values(self) -> dict[str, object]:
        """Values of the names in the templates of this kind, the tests and the header."""
        nq = len(self.made.actuated)
        common = common_values(self.name, self.real, struct=self.made.geometry.at_run_time)
        size = self.made.size
        far = farthest(
            size, self.made.forward_at(np.array([c.reference[0] for c in self.made.actuated]))[:3]
        )
        return (
            common
            | {
                "nq": nq,
                "last_joint": nq - 1,
                "ns": nq,
                "nj": 6 * nq,
                "meaning": _meaning(self.made),
                "farthest": far,
                "farthest_joint": self._farthest_joint,
                "largest": fastest(size),
                "per_size": 1.0 / size,
                "branches_told": "" if self.closed is None else self.closed.header,
                "line_words": self._line_words,
            }
            | self._turns
            | self._frame_names
        )

    @property
    def _farthest_joint(self) -> float:
        """Beyond which no joint value is a guess."""
        return FARTHEST * max(self.made.size, 1.0)

    @property
    def _turns(self) -> dict[str, object]:
        """What pose and Jacobian are functions of: half turns where there are motions, which are
        set from joint values once for both; else the joint values.
        """
        count = len(self.made.actuated)
        own = {"u": "joints", "u_what": "joint values", "u_moved": "moved", "n_u": count}
        own |= {"pose_at": "forward", "work_u": [], "set_u": [], "set_moved": []}
        if self.motion is not None:
            own |= {"u": "u", "u_what": "half turns", "u_moved": "u", "n_u": 2 * count}
            own |= {"pose_at": "pose_of_turns", "work_u": f"real u[{2 * count}];"}
            own |= {
                "set_u": "name_half_turns(joints, u);",
                "set_moved": "name_half_turns(moved, u);",
            }
        return own

    @cached_property
    def _frame(self) -> ArmFrame | None:
        """The border of an arm that is solved by its closed form in a frame of its own."""
        arm = self.made
        if not arm.follows_closed_form or arm.plan is None or arm.plan[0].arm.base is None:
            return None
        nq = len(arm.actuated)
        return ArmFrame(arm.plan[0].arm.base, self.real, {"nq": nq, "nj": 6 * nq})

    @cached_property
    def _frame_names(self) -> dict[str, object]:
        return unturned() if self._frame is None else self._frame.names

    def _in_own(self, screws: ArmScrews) -> ArmScrews:
        """The screws, of an arm with a border without the turn that this makes."""
        return screws if self._frame is None else replace(screws, base=None)

    @property
    def _line_words(self) -> str:
        """What the line costs at most, and where limits are checked, in words of the header."""
        prefix = self.name.upper()
        limited = any(c.limits is not None for c in self.made.actuated)
        words = []
        if self.line is None:
            words = [
                "Newton's method: the worst case is config->max_iterations steps "
                f"({prefix}_MAX_STEPS where config is NULL), whatever pose and guess. The answer's "
                "error is that of the last step: predicted to be within the tolerance, its rows "
                "evaluated.",
                *(["Limits are checked at the answer, not along the line."] if limited else []),
            ]
        elif limited:
            words = [
                "Joints keep their limits at all points of the line, the guess included: else, and "
                f"where one comes too near to be decided, {prefix}_OUT_OF_RANGE, and info->joint "
                "is the joint."
            ]
        return " ".join(words)

    @cached_property
    def closed(self) -> ClosedCode | None:
        """The closed form, where the arm has one."""
        arm = self.made
        if arm.plan is None:
            return None
        plan, nearly = arm.plan
        misfit = closed_misfit(self.real, arm.size)
        common = common_values(arm.name, self.real, struct=False) | self._frame_names
        common["farthest_joint"] = self._farthest_joint
        return ClosedCode(
            replace(plan, arm=self._in_own(plan.arm)),
            arm.actuated,
            self.real,
            common,
            misfit,
            self.code if nearly else None,
        )

    @cached_property
    def motion(self) -> ArmMotion | None:
        """Pose and Jacobian by the screws' motions, where the geometry is that of the code and
        joints turn or slide.
        """
        arm = self.made
        screws = None if arm.geometry.at_run_time else arm_screws(arm.mechanism)
        return None if screws is None else ArmMotion(self._in_own(screws), self.real)

    @cached_property
    def line(self) -> ClosedLine | None:
        """The closed form's check of lines, where it is the arm's own."""
        if self.closed is None or not self.made.follows_closed_form:
            return None
        assert self.motion is not None  # noqa: S101 - a closed form is one of screws
        return ClosedLine(self.closed, self.motion)

    @property
    def _solving(self) -> dict[str, object]:
        """How NAME_inverse solves: by the closed form along the line, else by Newton's method."""
        nq, config = len(self.made.actuated), "(config != NULL) ? config : &usual"
        how, at, work = "the closed form", "at", f"real at[{nq}];"
        solve, stand = [f"status = name_inverse_along(to, {config}, at, info);"], ""
        if self.line is None:
            how, at, work = "Newton's method", "w.x", "name_inverse_work w;"
            solve = [
                "name_forward(GEOMETRY w.x, w.at);",
                f"status = name_inverse_newton(GEOMETRY &w, to, {config}, info);",
            ]
        within = if_ok(
            [
                f"status = name_limit_joints(GEOMETRY status, {at});",
                "if (info != NULL) {",
                f"    info->joint = name_first_beyond(GEOMETRY {at});",
                "}",
            ]
        )
        if self.line is None and any(c.limits is not None for c in self.made.actuated):
            stand = self.code.stand(copy(at, "guess", nq), "to", within)
        return {
            "how": f"The joints by {how}",
            "work": work,
            "at": at,
            "to_x": copy(at, "guess", nq),
            "out": copy("joints", at, nq),
            "solve": solve,
            "within": within,
            "stand": stand,
        }

    @property
    def watched(self) -> dict[str, Watched]:
        """What the inverse problem watches along lines."""
        if self.line is None:
            return {"inverse": (["the pose"], (DETERMINANT,))}
        return {"inverse": ([], self.line.guards)}

    @property
    def text(self) -> str:
        """Everything of NAME.c between its beginning and end."""
        arm, values = self.made, self.values
        ranges = ranges_of(arm.actuated, self.real, arm.size)
        functions = fill(
            "serial_functions.c",
            values
            | {
                "jacobian": self._jacobian_lines,
                **self._solving,
            },
        )
        newton = "" if self.line is not None else self.code.text
        closed = "" if self.closed is None else self.closed.text
        line = "" if self.line is None else self.line.text()
        frame = self._frame
        return "".join(
            [
                normalise_pose(values),
                fill("info.c", values),
                range_functions(ranges, self.real, values),
                self._forward,
                arm_error(arm.actuated, self.real, arm.size, values),
                newton,
                closed,
                line,
                functions,
                "" if frame is None else frame.jacobian,
                self._speeds,
            ]
        )

    @property
    def _speeds(self) -> str:
        """Rates, twist, feed and the step of a control loop."""
        rounding = self.code.tuning.rounding
        return arm_speeds(self.made.actuated, rounding, self.values)

    def _emitter(self, expression: ca.SX, joints: str) -> Emitter:
        """Emitter of a dense function of the joints, whose C name is given."""
        arm = self.made
        inputs = [
            (arm.joints, indexed(joints, len(arm.actuated))),
            (arm.geometry.symbols, arm.geometry.names),
        ]
        return Emitter.of(self.real, inputs, expression)

    @property
    def _forward(self) -> str:
        """NAME_forward: the tool's pose of joint values."""
        if self.motion is not None:
            return self.motion.text
        lines = self._emitter(self.made.pose, "q").stored(indexed("x", 7))
        return fill("forward.c", self.values | {"forward": lines})

    @property
    def _jacobian_lines(self) -> list[str]:
        """Statements of the Jacobian, row by row."""
        if self.motion is not None:
            return self.motion.jacobian_lines
        emitter = self._emitter(ca.vec(self.made.jacobian.T), "joints")
        return emitter.stored(indexed("jacobian", 6 * len(self.made.actuated)))
