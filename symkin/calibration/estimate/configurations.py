"""Solve the closure for many configurations at once: the direct problem at any parameters, joints
for poses, all coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.estimate.configuration_model import ConfigurationModel, solve_systems
from symkin.closure.closure import Closure, build_closure
from symkin.errors import InputError
from symkin.model.joint import units_of
from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import System
from symkin.position.given import pose_coordinates, pose_from
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply, quaternion_from_euler

SOLVED_TOLERANCE = 1e-10
"""A configuration is solved when its largest closure row is below this, of the size: far above
rounding (1e-15), far below any noise.
"""
ROUGHLY_SOLVED_TOLERANCE = 1e-6
"""The same, of the size, where an estimator goes on from there and corrects what is left to first
order.
"""
_MAX_STEP = 0.3
"""Longest Newton step, of the size: longer ones leave the assembly mode."""
_ROUNDED_CLOSURE, _CLOSED_TO_ROUNDING = 1e-14, 1e-11
"""Closure error (of the size) at which poses and joints that are drawn are no longer improved, and
that below which they are closed.
"""
_MAX_POSE_STEP = 0.5
"""Longest Newton step, of the size, from a drawn pose: its joints may be far from the reference."""
_MAX_STEPS, _MAX_POSE_STEPS = 20, 30
"""Most Newton steps of direct problems, and from drawn poses."""
_FOLLOWED_STEP, _MAX_FOLLOWED_STEPS = 0.1, 400
"""Steps of joints (radians, or of the size) in which configurations are followed, and most of
them.
"""
_MAX_FOLLOWED_MOVE = 0.6
"""Furthest that an unknown coordinate (radians, or of the size) may move in such a step: what goes
further has jumped.
"""
_FIRST_PASSIVE_DAMPING, _MIN_PASSIVE_DECREASE, _IDLE_PASSIVE_STEPS = 1e-3, 1e-8, 6
"""First damping of passive joints at a pose, and steps in a row that lower no configuration's cost
by this share after which they end.
"""
_MAX_COMPARED_ROWS = 1000
"""Most rows among which neighbours are sought."""
_NEIGHBOURS = 5
"""Solved neighbours from which a configuration is tried again."""
_RANDOM_STARTS = 12
"""Random starts for a configuration that neither the reference nor its neighbours reach."""


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
    tolerance: float = SOLVED_TOLERANCE,
) -> tuple[np.ndarray, np.ndarray]:
    """Solve the direct problems by Newton from points z (n, width): points, and which of them
    closed (n,).
    """
    z, largest = _newton(
        lambda z: model.rows(z, joints, p),
        model.system,
        z,
        _Steps(_MAX_STEPS, tolerance, _MAX_STEP),
    )
    return z, largest <= tolerance


@dataclass(frozen=True)
class _Steps:
    """Most Newton steps, the closure error (over the size) that ends them, and the longest step (in
    sizes).
    """

    count: int
    tolerance: float
    longest: float


def _newton(
    linearise: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    system: System,
    z: np.ndarray,
    steps: _Steps,
) -> tuple[np.ndarray, np.ndarray]:
    """Newton, or Gauss-Newton where rows are more than unknowns, with a bounded step: points z (n,
    width) and their largest closure rows over the size (n,).
    """
    largest = np.full(len(z), np.inf)
    for _ in range(steps.count):
        rows, rows_z = linearise(z)
        largest = np.max(np.abs(rows), axis=1, initial=0.0) / system.characteristic_length
        if not np.any(largest > steps.tolerance):
            break
        step = -solve_systems(rows_z, rows[:, :, None])[:, :, 0]
        step *= np.minimum(
            1.0,
            steps.longest
            * system.characteristic_length
            / np.maximum(np.linalg.norm(step, axis=1), 1e-300),
        )[:, None]
        z = np.where((largest > steps.tolerance)[:, None], system.move(z, np.nan_to_num(step)), z)
    return z, largest


def solve_configurations(
    model: ConfigurationModel,
    measurements: Measurements,
    p: np.ndarray,
    *,
    z: np.ndarray | None = None,
    seed: int = 0,
    tolerance: float = SOLVED_TOLERANCE,
) -> SolvedConfigurations:
    """Solve F(z; q, p) = 0 for every configuration, from `z` if given, else from the measurements'
    starts, the measured poses or the reference. Where Newton fails, Levenberg-Marquardt tries
    solved neighbours and random starts (`seed`); where joints carry the platform neighbours alone,
    on their side of singularities: what lies further is another assembly mode.
    """
    start = first_points(model, measurements, p) if z is None else z
    joints = measurements.joints
    with np.errstate(all="ignore"):
        found, solved = newton_configurations(model, start, joints, p, tolerance=tolerance)
        # configurations that were followed from one stay on its side of singularities
        carried = is_carried(model.closure) and z is None
        solved &= _on_one_side(model, found, joints, p, solved) | (not carried)
        if not solved.all():
            for k in np.flatnonzero(~solved):
                near = found[solved]
                if len(near):
                    near = near[nearest_rows(joints[solved], joints[k : k + 1], _NEIGHBOURS)[0]]
                starts = near if carried and len(near) else np.vstack([start[k], near])
                better = _solve_from_many(
                    model, measurements, p, int(k), starts, None if carried else seed
                )
                found[k] = found[k] if better is None else better
            found, solved = newton_configurations(model, found, joints, p, tolerance=tolerance)
            solved &= _on_one_side(model, found, joints, p, solved) | (not carried)
        if tolerance <= SOLVED_TOLERANCE:
            found = np.where(solved[:, None], _polished(model, found, joints, p), found)
    return SolvedConfigurations(found, solved)


def _on_one_side(
    model: ConfigurationModel, z: np.ndarray, joints: np.ndarray, p: np.ndarray, solved: np.ndarray
) -> np.ndarray:
    """Tell which configurations (n,) have the sign of det F_z that most of those solved have."""
    signs = determinant_signs(model.rows(z, joints, p)[1])
    return np.asarray(signs * np.sum(signs[solved]) >= 0.0)


def _polished(
    model: ConfigurationModel, z: np.ndarray, joints: np.ndarray, p: np.ndarray
) -> np.ndarray:
    """Take one Newton step more, so that configurations are closed to rounding."""
    rows, rows_z = model.rows(z, joints, p)
    return model.system.move(z, np.nan_to_num(-solve_systems(rows_z, rows[:, :, None])[:, :, 0]))


def determinant_signs(rows_z: np.ndarray) -> np.ndarray:
    """Return the sign of det F_z (n,), 0 where F_z is not square: it changes only across a
    singularity.
    """
    if rows_z.shape[1] != rows_z.shape[2] or rows_z.shape[2] == 0:
        return np.zeros(len(rows_z))
    return np.asarray(np.sign(np.linalg.slogdet(rows_z)[0]))


def is_determined(
    model: ConfigurationModel, z: np.ndarray, joints: np.ndarray, p: np.ndarray
) -> bool:
    """Tell whether joint readings fix the configuration: the closure has full column rank in its
    unknown coordinates anywhere.
    """
    rows_z = model.rows(z, joints, p)[1]
    if rows_z.shape[2] == 0:
        return True
    if rows_z.shape[1] < rows_z.shape[2]:
        return False
    singular = np.linalg.svd(np.nan_to_num(rows_z), compute_uv=False)
    return bool(np.any(singular[:, -1] >= 1e-10 * singular[:, 0]))


def refuse_undetermined(
    model: ConfigurationModel, z: np.ndarray, joints: np.ndarray, p: np.ndarray
) -> None:
    """Raises InputError where joint readings do not fix the configuration."""
    if not is_determined(model, z, joints, p):
        m = model.mechanism
        raise InputError(
            f"{m.name}: the actuated joints ({', '.join(c.name for c in m.actuated) or 'none'}) do "
            f"not determine the pose; calibration "
            "needs a direct problem with isolated solutions: actuate more joints (those that are "
            "read), or declare the platform's motion"
        )


def start_points(
    model: ConfigurationModel, measurements: Measurements, *, measured: bool = False
) -> np.ndarray:
    """Return the unknowns (n, width) at the starts: the pose given or measured (only so if
    `measured`), else the reference. Poses that are seen through unknown frames are no starts.
    """
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
        values, _ = pose_coordinates(
            model.mechanism, pose_from(pose.tolist(), f"starts: posture {measurements.labels[k]}")
        )
        taken = 0
        for c in closure.role("pose"):
            begin[k, places[c.name]] = values[taken : taken + c.width]
            taken += c.width
    return begin


def first_points(
    model: ConfigurationModel, measurements: Measurements, p: np.ndarray
) -> np.ndarray:
    """Return the unknowns (n, width) from which direct problems begin: `start_points`; where a pose
    is not all that is unknown beside joints, what the reference leads to when the joints move
    straight from it to their readings.
    """
    if not is_carried(model.closure):
        return start_points(model, measurements)
    start = start_points(model, without_starts(measurements))
    reference = np.concatenate(
        [np.zeros(0), *(np.array(c.reference) for c in model.closure.role("actuated"))]
    )
    return follow_joints(model, start, np.tile(reference, (len(start), 1)), measurements.joints, p)


def is_carried(closure: Closure) -> bool:
    """Tell whether the pose of the platform, or of the link judged in its place, follows from the
    joints or other bodies.
    """
    return not closure.role("pose") or bool(closure.role("body"))


def follow_joints(
    model: ConfigurationModel, z: np.ndarray, begin: np.ndarray, end: np.ndarray, p: np.ndarray
) -> np.ndarray:
    """Follow configurations z (n, width) by Newton while the joint readings move straight from
    `begin` to `end` (n, a); one that is lost, or would jump, stays where it was last.
    """
    units = np.array(
        [
            1.0 if c.is_angular else 1.0 / model.closure.characteristic_length
            for c in model.closure.role("actuated")
        ]
    )
    furthest = float(np.max(np.abs(end - begin) * units, initial=0.0))
    count = min(max(1, int(np.ceil(furthest / _FOLLOWED_STEP))), _MAX_FOLLOWED_STEPS)
    size = model.closure.characteristic_length
    lengths = np.array(units_of(model.system.unknowns, size))
    with np.errstate(all="ignore"):
        for k in range(1, count + 1):
            joints = begin + (k / count) * (end - begin)
            found, closed = newton_configurations(
                model, z, joints, p, tolerance=ROUGHLY_SOLVED_TOLERANCE
            )
            # from the reference, which need not be closed, the first step may be a long one
            near = np.max(np.abs(found - z) / lengths, axis=1, initial=0.0) < (
                _MAX_FOLLOWED_MOVE if k > 1 else np.inf
            )
            z = np.where((closed & near)[:, None], found, z)
    return z


def passive_freedoms(model: ConfigurationModel) -> np.ndarray:
    """Return the places of the unknowns' freedoms that are not the pose's."""
    return np.flatnonzero(
        [c.role != "pose" for c in model.system.unknowns for _ in range(c.freedom)]
    )


def fit_passive(
    model: ConfigurationModel, z: np.ndarray, joints: np.ndarray, p: np.ndarray, most: int
) -> np.ndarray:
    """Fit the passive joints in z (n, width) at which the geometry p closes best with the pose as
    it is, each configuration by itself: Levenberg-Marquardt of at most so many steps.
    """
    width, passive = model.system.freedom, passive_freedoms(model)
    if not passive.size:
        return z

    def rows_at(z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        rows, rows_z = model.rows(z, joints, p)
        return np.sum(rows**2, axis=1), rows, rows_z[:, :, passive]

    (cost, rows, by_x), damping, idle = rows_at(z), np.full(len(z), _FIRST_PASSIVE_DAMPING), 0
    for _ in range(most):
        normal = np.swapaxes(by_x, 1, 2) @ by_x
        normal += (
            damping[:, None, None]
            * np.trace(normal, axis1=1, axis2=2)[:, None, None]
            * np.eye(len(passive))
        )
        if not np.isfinite(normal).all():
            break
        follow = np.zeros((len(z), width))
        follow[:, passive] = -(
            np.linalg.pinv(normal, hermitian=True) @ np.swapaxes(by_x, 1, 2) @ rows[:, :, None]
        )[:, :, 0]
        trial = model.system.move(z, follow)
        found = rows_at(trial)
        better = found[0] < cost
        z = np.where(better[:, None], trial, z)
        damping = np.where(better, damping / 10.0, 4.0 * damping)
        idle = 0 if (found[0] < (1.0 - _MIN_PASSIVE_DECREASE) * cost).any() else idle + 1
        if idle == _IDLE_PASSIVE_STEPS:
            break
        cost, rows, by_x = rows_at(z)
    return z


def known_poses(measurements: Measurements, *, measured: bool = False) -> list[np.ndarray | None]:
    """Return a whole pose of each configuration, None where there is none: its start (unless
    `measured`), else what was measured.
    """
    poses: list[np.ndarray | None] = [None] * len(measurements)
    both = (measurements.position, measurements.orientation)
    read = None if any(part is None for part in both) else np.hstack(both)  # type: ignore[arg-type]
    for table in (read, None if measured else measurements.starts):
        if table is not None:
            poses = [
                row if np.all(np.isfinite(row)) else old
                for row, old in zip(table, poses, strict=True)
            ]
    return poses


def without_poses(measurements: Measurements) -> Measurements:
    """Leave out positions and orientations."""
    return replace(measurements, position=None, orientation=None)


def without_starts(measurements: Measurements) -> Measurements:
    """Leave out positions, orientations and starts."""
    return replace(without_poses(measurements), starts=None)


def nearest_rows(joints: np.ndarray, wanted: np.ndarray, count: int) -> np.ndarray:
    """Find the rows of `joints` that are nearest to each row of `wanted`, by number (k, count);
    columns count by their spread, and of many rows only some are looked at.
    """
    chosen = spread_rows(len(joints), _MAX_COMPARED_ROWS)
    spread = np.std(np.vstack([joints, wanted]), axis=0)
    weight = 1.0 / np.where(spread > 0.0, spread, 1.0)
    scaled = joints[chosen] * weight
    found = [
        np.argsort(np.sum((scaled - row) ** 2, axis=1), kind="stable")[:count]
        for row in wanted * weight
    ]
    return chosen[np.array(found)]


def _solve_from_many(
    model: ConfigurationModel,
    measurements: Measurements,
    p: np.ndarray,
    k: int,
    starts: np.ndarray,
    seed: int | None,
) -> np.ndarray | None:
    """Find the solution of one configuration that is nearest to its first start, from random starts
    too where there is a seed; or None.
    """
    system: System = model.system
    if seed is not None:
        rng = np.random.default_rng([seed, k])
        steps = (
            0.2
            * model.closure.characteristic_length
            * rng.normal(size=(_RANDOM_STARTS, system.freedom))
        )
        starts = np.vstack([starts, system.move(np.tile(starts[:1], (_RANDOM_STARTS, 1)), steps)])
    batch = levenberg_marquardt(system, starts, np.concatenate([measurements.joints[k], p]))
    good = batch.points[batch.converged]
    if len(good) == 0:
        return None
    return np.asarray(good[np.argmin(np.linalg.norm(good - starts[0], axis=1))])


@dataclass(frozen=True, eq=False)
class ClosedConfigurations:
    """Closed configurations: all variables of the closure (n, width), actuated joints (n, a) and
    platform poses (n, 7).
    """

    values: np.ndarray
    joints: np.ndarray
    poses: np.ndarray

    def __len__(self) -> int:
        return len(self.values)

    def take(self, index: np.ndarray) -> ClosedConfigurations:
        return ClosedConfigurations(self.values[index], self.joints[index], self.poses[index])

    @staticmethod
    def joined(parts: Sequence[ClosedConfigurations]) -> ClosedConfigurations:
        return ClosedConfigurations(
            *(np.vstack([getattr(p, k) for p in parts]) for k in ("values", "joints", "poses"))
        )


def joints_at_poses(mechanism: Mechanism, poses: np.ndarray) -> np.ndarray:
    """Solve for the actuated joints (n, a) at platform poses (n, 7), the limbs as near to the
    reference as Newton finds them; NaN where a limb does not reach the pose.
    """
    closure = build_closure(mechanism)
    starts = np.array(
        [with_pose(mechanism, closure.reference, Pose(row[:3], row[3:])) for row in poses]
    )
    solver = JointsOfPose(closure)
    with np.errstate(all="ignore"):
        values, closed = solver.newton(starts)
    return np.where(closed[:, None], values[:, : len(mechanism.actuated)], np.nan)


def with_pose(mechanism: Mechanism, values: np.ndarray, pose: Pose) -> np.ndarray:
    """Put the pose coordinates nearest to a pose into the closure's variables; as they are where it
    has none.
    """
    closure, values = build_closure(mechanism), values.copy()
    if not closure.role("pose"):
        return values
    numbers, _ = pose_coordinates(mechanism, pose)
    begin = closure.slices[closure.role("pose")[0].name].start
    values[begin : begin + len(numbers)] = numbers
    return values


def closed_points(
    system: System, z: np.ndarray, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Solve a system by Newton from points z (n, width), each with known values (n, k) of its own:
    points, and which of them closed to rounding (n,).
    """
    steps = _Steps(_MAX_POSE_STEPS, _ROUNDED_CLOSURE, _MAX_POSE_STEP)
    z, largest = _newton(lambda z: system.linearise(z, known), system, z, steps)
    return z, largest < _CLOSED_TO_ROUNDING


class JointsOfPose:
    """Solves for all joints, actuated and passive, at given poses."""

    def __init__(self, closure: Closure) -> None:
        unknowns, known = closure.role("actuated", "passive", "body"), closure.role("pose")
        self.width = sum(c.width for c in unknowns)
        unknown = closure.variables[: self.width]
        pose = closure.variables[self.width : self.width + sum(c.width for c in known)]
        rows, errors = closure.bound(closure.rows), closure.bound(closure.errors)
        self._system = System(unknowns, unknown, pose, rows, errors, closure.characteristic_length)

    def newton(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Solve for the joints by Newton from those in the values; and tell which configurations
        closed.
        """
        return closed_points(self._system, values[:, : self.width], values[:, self.width :])

    def solve(self, values: np.ndarray) -> np.ndarray:
        """Replace the joints by Newton's where it closes; others stay as they were."""
        joints, closed = self.newton(values)
        return np.where(closed[:, None], np.hstack([joints, values[:, self.width :]]), values)


def all_coordinates(closure: Closure, home: Pose, *, held: bool) -> System:
    """The closure in all coordinates; with `held` also the inclination, size (R^T e_z - R_home^T
    (Ry Rx)^T e_z) = 0.
    """
    rows, known = closure.bound(closure.rows), ca.SX.sym("inclination", 2 if held else 0)
    if held:
        tilted = quaternion_from_euler([known[0], known[1], 0.0], "xyz")
        wanted = Pose(ca.SX.zeros(3), multiply(tilted, ca.SX(ca.DM(home.quaternion))))
        quaternion = closure.bound(closure.pose.quaternion)
        up = ca.SX(ca.DM([0.0, 0.0, 1.0]))
        rows = ca.vertcat(
            rows,
            closure.characteristic_length
            * (Pose(up, quaternion).inverse().turn(up) - wanted.inverse().turn(up)),
        )
    return System(
        closure.coordinates, closure.variables, known, rows, rows, closure.characteristic_length
    )
