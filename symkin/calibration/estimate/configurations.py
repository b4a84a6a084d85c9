"""Solve the closure for many configurations at once: the direct problem at any parameters, joints for poses, all coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.estimate.model import ConfigurationModel
from symkin.closure.closure import Closure, build_closure
from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import System
from symkin.position.given import pose_coordinates, pose_from
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply, quaternion_from_euler

CLOSURE_TOLERANCE = 1e-10
"""A posture is solved when its largest closure row, over the size, is below this."""
ROUGH_CLOSURE_TOLERANCE = 1e-6
"""The same where an estimator goes on from there and corrects what is left to first order."""
_MAX_STEP = 0.3
"""Longest Newton step, in sizes."""
_RANDOM_STARTS = 12
"""Random starts for a posture that neither the reference nor its neighbours reach."""


@dataclass(frozen=True, eq=False)
class SolvedConfigurations:
    """Unknown coordinates z (n, width), and which of them are solved (n,)."""

    z: np.ndarray
    solved: np.ndarray


def newton_configurations(
    model: ConfigurationModel,
    z: np.ndarray,
    joints: np.ndarray,
    p: np.ndarray,
    *,
    tolerance: float = CLOSURE_TOLERANCE,
    iterations: int = 20,
) -> tuple[np.ndarray, np.ndarray]:
    """Newton or Gauss-Newton with a bounded step for all postures: points and which of them closed."""
    size = model.closure.size
    largest = np.full(len(z), np.inf)
    for _ in range(iterations):
        rows, rows_z = model.rows(z, joints, p)
        largest = np.max(np.abs(rows), axis=1, initial=0.0) / size
        if not np.any(largest > tolerance):
            break
        step = -solve_systems(rows_z, rows[:, :, None])[:, :, 0]
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, _MAX_STEP * size / np.maximum(length, 1e-300))[:, None]
        moved = model.system.move(z, np.nan_to_num(step))
        z = np.where((largest > tolerance)[:, None], moved, z)
    return z, largest <= tolerance


def solve_systems(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Least-squares solutions of n systems matrix (n, m, f), right (n, m, k); of no use (NaN) where singular."""
    if matrix.shape[1] == matrix.shape[2]:
        try:
            return np.asarray(np.linalg.solve(matrix, right))
        except np.linalg.LinAlgError:
            pass
    if not np.all(np.isfinite(matrix)):
        matrix = np.nan_to_num(matrix)
    return np.asarray(np.linalg.pinv(matrix, rcond=1e-12) @ right)


def solve_configurations(
    model: ConfigurationModel, measurements: Measurements, p: np.ndarray, *, z: np.ndarray | None = None, seed: int = 0,
    tolerance: float = CLOSURE_TOLERANCE,
) -> SolvedConfigurations:  # fmt: skip
    """Solve F(z; q, p) = 0 for every posture, from `z` if given, else from the measurements' starts, the measured poses
    or the reference. Where Newton fails, Levenberg-Marquardt tries solved neighbours and random starts (`seed`)."""
    start = start_points(model, measurements) if z is None else z
    joints = measurements.joints
    with np.errstate(all="ignore"):
        found, solved = newton_configurations(model, start, joints, p, tolerance=tolerance)
        if not solved.all():
            for k in np.flatnonzero(~solved):
                near = _neighbours(joints, found, solved, int(k))
                better = _solve_from_many(model, measurements, p, int(k), np.vstack([start[k], near]), seed)
                found[k] = found[k] if better is None else better
            found, solved = newton_configurations(model, found, joints, p, tolerance=tolerance)
        if tolerance <= CLOSURE_TOLERANCE:
            found = np.where(solved[:, None], _polished(model, found, joints, p), found)
    return SolvedConfigurations(found, solved)


def _polished(model: ConfigurationModel, z: np.ndarray, joints: np.ndarray, p: np.ndarray) -> np.ndarray:
    """One Newton step more: closed to rounding."""
    rows, rows_z = model.rows(z, joints, p)
    return model.system.move(z, np.nan_to_num(-solve_systems(rows_z, rows[:, :, None])[:, :, 0]))


def determinant_signs(rows_z: np.ndarray) -> np.ndarray:
    """Sign of det F_z (n,), 0 where F_z is not square: it changes only across a singularity."""
    if rows_z.shape[1] != rows_z.shape[2] or rows_z.shape[2] == 0:
        return np.zeros(len(rows_z))
    return np.asarray(np.sign(np.linalg.slogdet(rows_z)[0]))


def start_points(model: ConfigurationModel, measurements: Measurements, *, measured: bool = False) -> np.ndarray:
    """Unknowns (n, width) at the starts: the pose given or measured (only so if `measured`), else the reference. Poses that are
    seen through unknown frames are no starts."""
    if model.observes_through_frames:
        measurements = without_poses(measurements)
    closure, system = model.closure, model.system
    places = dict(zip((c.name for c in system.unknowns), system.slices, strict=True))
    begin = np.empty((len(measurements), system.width))
    for name, place in places.items():
        begin[:, place] = closure.reference[closure.slices[name]]
    for k, pose in enumerate(known_poses(measurements, measured=measured)):
        if pose is None:
            continue
        values, _ = pose_coordinates(model.mechanism, pose_from(pose.tolist(), f"starts: posture {measurements.labels[k]}"))
        taken = 0
        for c in closure.role("pose"):
            begin[k, places[c.name]] = values[taken : taken + c.width]
            taken += c.width
    return begin


def known_poses(measurements: Measurements, *, measured: bool = False) -> list[np.ndarray | None]:
    """A whole pose of each posture: its start (unless `measured`), else what was measured."""
    poses: list[np.ndarray | None] = [None] * len(measurements)
    both = (measurements.position, measurements.orientation)
    read = None if any(part is None for part in both) else np.hstack(both)  # type: ignore[arg-type]
    for table in (read, None if measured else measurements.starts):
        if table is not None:
            poses = [row if np.all(np.isfinite(row)) else old for row, old in zip(table, poses, strict=True)]
    return poses


def without_poses(measurements: Measurements) -> Measurements:
    """The measurements without positions and orientations."""
    return replace(measurements, position=None, orientation=None)


def _neighbours(joints: np.ndarray, z: np.ndarray, solved: np.ndarray, k: int, count: int = 5) -> np.ndarray:
    near = [int(i) for i in np.argsort(np.linalg.norm(joints - joints[k], axis=1)) if solved[i]]
    return z[near[:count]]


def _solve_from_many(
    model: ConfigurationModel, measurements: Measurements, p: np.ndarray, k: int, starts: np.ndarray, seed: int
) -> np.ndarray | None:
    """A solution of one posture nearest to its first start, or None."""
    system: System = model.system
    rng = np.random.default_rng([seed, k])
    steps = 0.2 * model.closure.size * rng.normal(size=(_RANDOM_STARTS, system.freedom))
    starts = np.vstack([starts, system.move(np.tile(starts[:1], (_RANDOM_STARTS, 1)), steps)])
    batch = levenberg_marquardt(system, starts, np.concatenate([measurements.joints[k], p]))
    good = batch.points[batch.converged]
    if len(good) == 0:
        return None
    return np.asarray(good[np.argmin(np.linalg.norm(good - starts[0], axis=1))])


@dataclass(frozen=True, eq=False)
class ClosedConfigurations:
    """Closed configurations: all variables of the closure (n, width), actuated joints (n, a) and platform poses (n, 7)."""

    values: np.ndarray
    joints: np.ndarray
    poses: np.ndarray

    def __len__(self) -> int:
        return len(self.values)

    def take(self, index: np.ndarray) -> ClosedConfigurations:
        return ClosedConfigurations(self.values[index], self.joints[index], self.poses[index])

    @staticmethod
    def joined(parts: Sequence[ClosedConfigurations]) -> ClosedConfigurations:
        return ClosedConfigurations(*(np.vstack([getattr(p, k) for p in parts]) for k in ("values", "joints", "poses")))


def joints_at_poses(mechanism: Mechanism, poses: np.ndarray) -> np.ndarray:
    """Actuated joints (n, a) at platform poses (n, 7), the limbs as near to the reference as Newton finds them; NaN where a limb does
    not reach the pose."""
    closure = build_closure(mechanism)
    starts = np.array([with_pose(mechanism, closure.reference, Pose(row[:3], row[3:])) for row in poses])
    solver = JointsOfPose(closure)
    with np.errstate(all="ignore"):
        values, closed = solver.newton(starts)
    return np.where(closed[:, None], values[:, : len(mechanism.actuated)], np.nan)


def with_pose(mechanism: Mechanism, values: np.ndarray, pose: Pose) -> np.ndarray:
    """Variables with the pose coordinates nearest to a pose."""
    closure, values = build_closure(mechanism), values.copy()
    numbers, _ = pose_coordinates(mechanism, pose)
    begin = closure.slices[closure.role("pose")[0].name].start
    values[begin : begin + len(numbers)] = numbers
    return values


class _ClosureNewton:
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
            step = np.nan_to_num(-solve_systems(rows_z, rows[:, :, None])[:, :, 0])
            step *= np.minimum(1.0, 0.5 * self.system.size / np.maximum(np.linalg.norm(step, axis=1), 1e-300))[:, None]
            z = np.where((largest > 1e-14)[:, None], self.system.move(z, step), z)
        return z, largest < 1e-11


class JointsOfPose:
    """Joints, actuated and passive, at a given pose."""

    def __init__(self, closure: Closure) -> None:
        self.closure = closure
        unknowns, known = closure.role("actuated", "passive"), closure.role("pose")
        self.width = sum(c.width for c in unknowns)
        unknown = closure.variables[: self.width]
        pose = closure.variables[self.width : self.width + sum(c.width for c in known)]
        rows = closure.bound(closure.rows)
        self._newton = _ClosureNewton(System(unknowns, unknown, pose, rows, closure.bound(closure.errors), closure.size))

    def newton(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Joints by Newton from those in the values, and which postures closed."""
        return self._newton.newton(values[:, : self.width], values[:, self.width :])

    def solve(self, values: np.ndarray) -> np.ndarray:
        """Values with joints from Newton where it closes; others as they were."""
        joints, closed = self.newton(values)
        return np.where(closed[:, None], np.hstack([joints, values[:, self.width :]]), values)


class AllCoordinates(_ClosureNewton):
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
