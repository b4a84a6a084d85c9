"""Closing the loops of many postures at once: joints for a pose, or all coordinates together near a start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.caching import cached_property
from symkin.calibration.direct import signs, solved_steps
from symkin.calibration.measurements import Measurements
from symkin.calibration.model import PostureModel, build_model
from symkin.closure.closure import Closure, build_closure
from symkin.model.limb import RodLimb
from symkin.model.mechanism import Mechanism
from symkin.numeric.system import System
from symkin.position.given import pose_coordinates, pose_from
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply, quaternion_from_euler

_POORER = 3.0
"""The example is home where the reference is conditioned worse by this factor."""
_SINGULAR, _WORSE = 1e6, 30.0
"""Condition of the direct problem above which home counts as singular, and how many times home's that of a posture may be."""


@dataclass(frozen=True, eq=False)
class Configurations:
    """Closed configurations: all variables of the closure (n, width), actuated joints (n, a) and platform poses (n, 7)."""

    values: np.ndarray
    joints: np.ndarray
    poses: np.ndarray

    def __len__(self) -> int:
        return len(self.values)

    def take(self, index: np.ndarray) -> Configurations:
        return Configurations(self.values[index], self.joints[index], self.poses[index])

    @staticmethod
    def joined(parts: Sequence[Configurations]) -> Configurations:
        return Configurations(*(np.vstack([getattr(p, k) for p in parts]) for k in ("values", "joints", "poses")))


class Closing:
    """Newton on the closure for many postures at once: first the joints for the pose, then all coordinates together."""

    def __init__(self, mechanism: Mechanism, home: Pose, margin: float = 0.0) -> None:
        self.mechanism, self.closure, self.home, self.margin = mechanism, build_closure(mechanism), home, margin
        self._model = build_model(mechanism, Measurements(np.zeros((1, len(mechanism.actuated)))), ())
        self._joints = _JointsOfPose(self.closure)
        self._whole = _Whole(self.closure, home, held=False)
        self._held = _Whole(self.closure, home, held=True)

    def close(
        self, starts: np.ndarray, inclinations: np.ndarray | None, *, limits: bool = True
    ) -> tuple[Configurations, np.ndarray]:
        """Closed configurations near the starts and which of them are good: closed, with the inclination where one is
        given, within limits, regular, and on the reference's side."""
        nothing = np.zeros((len(starts), 0))
        with np.errstate(all="ignore"):
            values = self._joints.solve(starts)
            known = nothing if inclinations is None else inclinations
            values, closed = (self._whole if inclinations is None else self._held).newton(values, known)
            z, joints = self.split(values)
            _, rows_z = self._model.rows(z, joints, np.zeros(0))
            made = Configurations(values, joints, self._model.poses(z, np.zeros(0)))
            good = closed & self._regular(rows_z)
            if limits:
                good &= self._within_limits(values)
        return made, good

    def split(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unknown coordinates of the direct problem, and actuated joints."""
        count = len(self.mechanism.actuated)
        return np.ascontiguousarray(values[:, count:]), np.ascontiguousarray(values[:, :count])

    def with_tool(self, values: np.ndarray) -> np.ndarray:
        """The tool of an arm at its joints."""
        z, joints = self.split(values)
        system = self._model.system
        for _ in range(30):
            rows, rows_z = self._model.rows(z, joints, np.zeros(0))
            z = system.move(z, -solved_steps(rows_z, rows[:, :, None])[:, :, 0])
        return np.hstack([joints, z])

    def _within_limits(self, values: np.ndarray) -> np.ndarray:
        good = np.all(np.isfinite(values), axis=1)
        for c in self.closure.coordinates:
            column = values[:, self.closure.slices[c.name].start]
            if c.limits is not None:
                kept = self.margin * (c.limits[1] - c.limits[0])
                turn = 2 * math.pi * np.ceil((c.limits[0] - column) / (2 * math.pi) - 1e-12) if c.kind == "angle" else 0.0
                good &= (column + turn >= c.limits[0] + kept) & (column + turn <= c.limits[1] - kept)
            elif c.least is not None:
                good &= column > c.least
        return np.asarray(good)

    @cached_property
    def _at_home(self) -> tuple[float, float]:
        """Sign of det F_z at home, 0 where F_z is not square, and the condition of F_z."""
        start = self._joints.solve(placed(self.mechanism, self.closure.reference, self.home)[None])
        return _side_and_condition(self._model, *self.split(start))

    def _regular(self, rows_z: np.ndarray) -> np.ndarray:
        if rows_z.shape[2] == 0:
            return np.ones(len(rows_z), dtype=bool)
        side, condition = self._at_home
        singular = np.linalg.svd(np.nan_to_num(rows_z), compute_uv=False)
        worst = _WORSE * condition if condition < _SINGULAR else _SINGULAR
        return np.asarray((singular[:, -1] * worst > singular[:, 0]) & (signs(rows_z) * side >= 0))


def home_pose(mechanism: Mechanism) -> Pose:
    """The reference pose; the pose of the worked example where the file says no reference, or where the direct problem is conditioned
    much better there."""
    example, reference = mechanism.example, mechanism.reference_pose
    given = None if example is None else example.pose or (example.start if example.joints is not None else None)
    if mechanism.serial or given is None or len(given) != 7:
        return reference
    closure, count = build_closure(mechanism), len(mechanism.actuated)
    model = build_model(mechanism, Measurements(np.zeros((1, count))), ())
    shown = pose_from(given, "example")
    if not says_reference(mechanism):
        return shown
    values = _JointsOfPose(closure).solve(np.array([placed(mechanism, closure.reference, pose) for pose in (reference, shown)]))
    here, there = (_side_and_condition(model, row[None, count:].copy(), row[None, :count].copy())[1] for row in values)
    return shown if here > _POORER * there else reference


def says_reference(mechanism: Mechanism) -> bool:
    """Whether a file says where the platform stands at the reference: rod limbs alone leave it open, and it is then the origin."""
    return any(mechanism.platform_position) or not all(isinstance(limb, RodLimb) for limb in mechanism.limbs)


def joints_at(mechanism: Mechanism, poses: np.ndarray) -> np.ndarray:
    """Actuated joints (n, a) at platform poses (n, 7), the limbs as near to the reference as Newton finds them; NaN where a limb does
    not reach the pose."""
    closure = build_closure(mechanism)
    starts = np.array([placed(mechanism, closure.reference, Pose(row[:3], row[3:])) for row in poses])
    solver = _JointsOfPose(closure)
    with np.errstate(all="ignore"):
        values, closed = solver.newton(starts)
    return np.where(closed[:, None], values[:, : len(mechanism.actuated)], np.nan)


def _side_and_condition(model: PostureModel, z: np.ndarray, joints: np.ndarray) -> tuple[float, float]:
    _, rows_z = model.rows(z, joints, np.zeros(0))
    condition = float(np.linalg.cond(rows_z[0])) if rows_z.shape[2] else 1.0
    return float(signs(rows_z)[0]) if condition < _SINGULAR else 0.0, condition


def placed(mechanism: Mechanism, values: np.ndarray, pose: Pose) -> np.ndarray:
    """Variables with the pose coordinates nearest to a pose."""
    closure, values = build_closure(mechanism), values.copy()
    numbers, _ = pose_coordinates(mechanism, pose)
    begin = closure.slices[closure.role("pose")[0].name].start
    values[begin : begin + len(numbers)] = numbers
    return values


class _Newton:
    """Gauss-Newton with rows and derivatives mapped over postures; each posture has its own known values."""

    def __init__(self, system: System) -> None:
        self.system = system
        self._one = ca.Function("rows", [system.unknown, system.known], [ca.densify(system.rows), ca.densify(system.jacobian)])
        self._maps: dict[int, ca.Function] = {}

    def rows(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        count = len(z)
        mapped = self._maps.setdefault(count, self._one.map(count))
        rows, rows_z = (np.asarray(part) for part in mapped(z.T, known.T))
        m = int(self.system.rows.shape[0])
        return rows.T.reshape(count, m), rows_z.reshape(m, count, self.system.freedom).transpose(1, 0, 2)

    def newton(self, z: np.ndarray, known: np.ndarray, iterations: int = 30) -> tuple[np.ndarray, np.ndarray]:
        largest = np.full(len(z), np.inf)
        for _ in range(iterations):
            rows, rows_z = self.rows(z, known)
            largest = np.max(np.abs(rows), axis=1, initial=0.0) / self.system.size
            if not np.any(largest > 1e-14):
                break
            step = np.nan_to_num(-solved_steps(rows_z, rows[:, :, None])[:, :, 0])
            step *= np.minimum(1.0, 0.5 * self.system.size / np.maximum(np.linalg.norm(step, axis=1), 1e-300))[:, None]
            z = np.where((largest > 1e-14)[:, None], self.system.move(z, step), z)
        return z, largest < 1e-11


class _JointsOfPose:
    """Joints, actuated and passive, at a given pose."""

    def __init__(self, closure: Closure) -> None:
        self.closure = closure
        unknowns, known = closure.role("actuated", "passive"), closure.role("pose")
        self.width = sum(c.width for c in unknowns)
        unknown = closure.variables[: self.width]
        pose = closure.variables[self.width : self.width + sum(c.width for c in known)]
        rows = closure.bound(closure.rows)
        self._newton = _Newton(System(unknowns, unknown, pose, rows, closure.bound(closure.errors), closure.size))

    def newton(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Joints by Newton from those in the values, and which postures closed."""
        return self._newton.newton(values[:, : self.width], values[:, self.width :])

    def solve(self, values: np.ndarray) -> np.ndarray:
        """Values with joints from Newton where it closes; others as they were."""
        joints, closed = self.newton(values)
        return np.where(closed[:, None], np.hstack([joints, values[:, self.width :]]), values)


class _Whole(_Newton):
    """All coordinates; with `held` also the inclination, size (R^T e_z - R_home^T (Ry Rx)^T e_z) = 0."""

    def __init__(self, closure: Closure, home: Pose, *, held: bool) -> None:
        rows, known = closure.bound(closure.rows), ca.SX.sym("inclination", 2 if held else 0)
        if held:
            tilted = quaternion_from_euler([known[0], known[1], 0.0], "xyz")
            wanted = Pose(ca.SX.zeros(3), multiply(tilted, ca.SX(ca.DM(home.quaternion))))
            quaternion = closure.bound(closure.pose.quaternion)
            up = ca.SX(ca.DM([0.0, 0.0, 1.0]))
            rows = ca.vertcat(rows, closure.size * (Pose(up, quaternion).inverse().turn(up) - wanted.inverse().turn(up)))
        super().__init__(System(closure.coordinates, closure.variables, known, rows, rows, closure.size))
