"""Close many configurations at once: the direct problem at any parameters, joints for poses,
passive joints, all coordinates; everywhere by one set of rows, in the coordinates that are free.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.data.observables import PLATFORM
from symkin.calibration.estimate.configuration_model import (
    ConfigurationModel,
    model_of,
    solve_systems,
)
from symkin.closure.closure import Closure
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.joint import Coordinate, units_of
from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.linear_algebra import conditions, largest_of
from symkin.numeric.system import NOTHING
from symkin.position.pose_coordinates import poses_coordinates
from symkin.position.readings import into_limits
from symkin.spatial.rotation import wrapped

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
"""Most Newton steps of direct problems, and of all else."""
_FOLLOWED_STEP, _MAX_FOLLOWED_STEPS = 0.1, 400
"""Steps of joints (radians, or of the size) in which configurations are followed, and most of
them.
"""
_MAX_FOLLOWED_MOVE = 0.6
"""Furthest that an unknown coordinate (radians, or of the size) may move in such a step: what goes
further has jumped.
"""
_MAX_COMPARED_ROWS = 1000
"""Most rows among which neighbours are sought."""
_NEIGHBOURS = 5
"""Solved neighbours from which a configuration is tried again."""
_RANDOM_STARTS = 12
"""Random starts for a configuration that neither the reference nor its neighbours reach."""


class SolvedConfigurations(NamedTuple):
    """Unknown coordinates z (n, width), and which of them are solved (n,)."""

    z: np.ndarray
    solved: np.ndarray


@dataclass(frozen=True, eq=False)
class Closing:
    """The closure at parameters p over points (n, a + width), joint readings and unknown
    coordinates. All may move that are not `held`: "joints" (actuated), "passive" (joints and
    bodies), "pose". `inclined` says what alpha and beta the platform must have, as groups compare
    them: (n, 2), or (n,) the numbers of the configurations whose they are.
    """

    model: ConfigurationModel
    p: np.ndarray = field(default_factory=NOTHING.copy)
    held: tuple[str, ...] = ("joints",)
    inclined: np.ndarray | None = None

    @cached_property
    def free(self) -> np.ndarray:
        """Places of the freedoms that may move, joints first."""
        kinds = ["joints"] * self._joints
        for c in self.model.system.unknowns:
            kinds += ["pose" if c.role == "pose" else "passive"] * c.freedom
        return np.flatnonzero([kind not in self.held for kind in kinds])

    @property
    def characteristic_length(self) -> float:
        return self.model.size

    @property
    def freedom(self) -> int:
        """Count of the freedoms that may move."""
        return len(self.free)

    @property
    def _joints(self) -> int:
        return len(self.model.closure.role("actuated"))

    @cached_property
    def _units(self) -> np.ndarray:
        size, joints = self.characteristic_length, self.model.closure.role("actuated")
        return np.array([1.0 / c.lever(size) for c in joints])

    def split(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unknown coordinates and joint readings of points."""
        return points[:, self._joints :], points[:, : self._joints]

    def linearise(
        self, points: np.ndarray, _known: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Rows (n, m) and their derivatives along the freedoms that may move (n, m, freedom)."""
        z, joints = self.split(points)
        if "joints" in self.held:
            rows, rows_z = self.model.values("rows", z, joints, self.p)
            return rows, rows_z[:, :, self.free - self._joints]
        rows, rows_z, rows_q, h, h_z, h_q = self.model.values("tangent", z, joints, self.p)
        by = np.concatenate([rows_q * self._units, rows_z], axis=2)
        if self.inclined is not None:
            columns, size = self.model.grouped, self.characteristic_length
            h, told = h[:, columns], self.inclined
            gap = wrapped(h - (h[told] if told.ndim == 1 else told))
            below = np.concatenate([h_q * self._units, h_z], axis=2)[:, columns]
            rows = np.hstack([rows, size * gap])
            by = np.concatenate([by, size * below], axis=1)
        return rows, by[:, :, self.free]

    def move(self, points: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Points moved by tangent steps (n, freedom)."""
        whole = np.zeros((len(points), self._joints + self.model.system.freedom))
        whole[:, self.free] = step
        z, joints = self.split(points)
        moved = self.model.system.move(z, whole[:, self._joints :])
        return np.hstack([joints + self._units * whole[:, : self._joints], moved])

    def newton(
        self,
        points: np.ndarray,
        *,
        count: int = _MAX_POSE_STEPS,
        tolerance: float = _ROUNDED_CLOSURE,
        longest: float = _MAX_POSE_STEP,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Newton, or Gauss-Newton where rows are not as many as freedoms, of at most `count` steps,
        none longer than `longest` sizes, until rows are within a tolerance: points and their
        largest rows (n,), over the size.
        """
        largest, size = np.full(len(points), np.inf), self.characteristic_length
        with np.errstate(all="ignore"):
            for _ in range(count):
                rows, by = self.linearise(points)
                largest = np.abs(rows).max(axis=1, initial=0.0) / size
                if not np.any(largest > tolerance):
                    break
                step = -solve_systems(by, rows[:, :, None])[:, :, 0]
                lengths = np.maximum(np.linalg.norm(step, axis=1), 1e-300)
                step *= np.minimum(1.0, longest * size / lengths)[:, None]
                moved = self.move(points, np.nan_to_num(step))
                points = np.where((largest > tolerance)[:, None], moved, points)
        return points, largest

    def close(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Close to rounding: points, and which of them closed (n,); others as they were."""
        found, largest = self.newton(points)
        closed = largest < _CLOSED_TO_ROUNDING
        return np.where(closed[:, None], found, points), closed


def newton_configurations(
    model: ConfigurationModel,
    z: np.ndarray,
    joints: np.ndarray,
    p: np.ndarray,
    *,
    tolerance: float = SOLVED_TOLERANCE,
    count: int = _MAX_STEPS,
) -> SolvedConfigurations:
    """Solve the direct problems by Newton from points z (n, width)."""
    closing = Closing(model, p)
    points, largest = closing.newton(
        np.hstack([joints, z]), count=count, tolerance=tolerance, longest=_MAX_STEP
    )
    return SolvedConfigurations(closing.split(points)[0], largest <= tolerance)


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
    found = first_points(model, measurements, p) if z is None else z
    joints = measurements.joints
    # configurations that were followed from one stay on its side of singularities
    carried = is_carried(model.closure) and z is None

    def solved_from(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        z, solved = newton_configurations(model, z, joints, p, tolerance=tolerance)
        if carried:
            signs = determinant_signs(model.values("rows", z, joints, p)[1])
            solved &= signs * signs[solved].sum() >= 0.0
        return z, solved

    with np.errstate(all="ignore"):
        start, (found, solved) = found, solved_from(found)
        system, good = model.system, np.flatnonzero(solved)
        for k in np.flatnonzero(~solved):
            near = found[:0]
            if len(good):
                near = found[good[nearest_rows(joints[good], joints[[k]], _NEIGHBOURS)[0]]]
            tried = near if carried and len(near) else np.vstack([start[k], near])
            if not carried:
                drawn = np.random.default_rng([seed, int(k)]).normal(
                    size=(_RANDOM_STARTS, system.freedom)
                )
                away = 0.2 * model.size * drawn
                tried = np.vstack([tried, system.move(np.tile(tried[0], (len(away), 1)), away)])
            points = np.hstack([np.tile(joints[k], (len(tried), 1)), tried])
            batch = levenberg_marquardt(Closing(model, p), points, NOTHING)
            ends = batch.points[batch.converged, joints.shape[1] :]
            if len(ends):
                found[k] = ends[np.argmin(np.linalg.norm(ends - tried[0], axis=1))]
        if len(good) < len(found):
            found, solved = solved_from(found)
        if tolerance <= SOLVED_TOLERANCE:
            # one step more, so that configurations are closed to rounding
            last, _ = newton_configurations(model, found, joints, p, tolerance=0.0, count=1)
            found = np.where(solved[:, None], last, found)
    return SolvedConfigurations(found, solved)


def determinant_signs(rows_z: np.ndarray) -> np.ndarray:
    """Return the sign of det F_z (n,), 0 where F_z is not square: it changes only across a
    singularity.
    """
    if rows_z.shape[1] != rows_z.shape[2] or rows_z.shape[2] == 0:
        return np.zeros(len(rows_z))
    return np.sign(np.linalg.slogdet(rows_z)[0])


def is_determined(
    model: ConfigurationModel, z: np.ndarray, joints: np.ndarray, p: np.ndarray
) -> bool:
    """Tell whether joint readings fix the configuration: the closure has full column rank in its
    unknown coordinates anywhere.
    """
    rows_z = model.values("rows", z, joints, p)[1]
    return rows_z.shape[1] >= rows_z.shape[2] and bool(np.any(conditions(rows_z) <= 1e10))


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
        measurements = replace(measurements, position=None, orientation=None)
    poses, starts = measurements.poses, measurements.starts
    if starts is not None and not measured:
        poses = np.where(np.isfinite(starts).all(axis=1, keepdims=True), starts, poses)
    return Closing(model).split(with_poses(model.closure, poses))[0]


def first_points(
    model: ConfigurationModel, measurements: Measurements, p: np.ndarray
) -> np.ndarray:
    """Return the unknowns (n, width) from which direct problems begin: `start_points`; where a pose
    is not all that is unknown beside joints, what the reference leads to when the joints move
    straight from it to their readings.
    """
    if not is_carried(model.closure):
        return start_points(model, measurements)
    begin = np.tile(model.closure.reference, (len(measurements), 1))
    start, joints = Closing(model, p).split(begin)
    return follow_joints(model, start, joints, measurements.joints, p)


def is_carried(closure: Closure) -> bool:
    """Tell whether the pose of the platform, or of the link judged in its place, follows from the
    joints or other bodies.
    """
    return not closure.role("pose") or bool(closure.role("body"))


def follow_joints(
    model: ConfigurationModel,
    z: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    p: np.ndarray = NOTHING,
) -> np.ndarray:
    """Follow configurations z (n, width) by Newton while the joint readings move straight from
    `begin` to `end` (n, a); one that is lost, or would jump, stays where it was last.
    """
    size, away = model.size, end - begin
    units, lengths = (
        np.array(units_of(coordinates, size))
        for coordinates in (model.closure.role("actuated"), model.system.unknowns)
    )
    furthest = largest_of(away / units)
    count = min(max(1, int(np.ceil(furthest / _FOLLOWED_STEP))), _MAX_FOLLOWED_STEPS)
    # from the reference, which need not be closed, the first step may be a long one
    longest = np.inf
    for k in range(1, count + 1):
        found, closed = newton_configurations(
            model, z, begin + (k / count) * away, p, tolerance=ROUGHLY_SOLVED_TOLERANCE
        )
        near = np.all(np.abs(found - z) < longest * lengths, axis=1)
        z, longest = np.where((closed & near)[:, None], found, z), _MAX_FOLLOWED_MOVE
    return z


def nearest_rows(joints: np.ndarray, wanted: np.ndarray, count: int) -> np.ndarray:
    """Find the rows of `joints` that are nearest to each row of `wanted`, by number (k, count);
    columns count by their spread, and of many rows only some are looked at.
    """
    chosen = spread_rows(len(joints), _MAX_COMPARED_ROWS)
    spread = np.vstack([joints, wanted]).std(axis=0)
    weight = 1.0 / np.where(spread > 0.0, spread, 1.0)
    scaled = joints[chosen] * weight
    found = [
        np.argsort(np.sum((scaled - row) ** 2, axis=1), kind="stable")[:count]
        for row in wanted * weight
    ]
    return chosen[np.array(found)]


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


def closing_model(mechanism: Mechanism) -> ConfigurationModel:
    """The model by which configurations are closed: its readings are the platform's inclination, as
    groups compare it.
    """
    return model_of(mechanism, () if mechanism.platform_link is None else (PLATFORM["group"],))


def closed_at(
    model: ConfigurationModel, poses: np.ndarray
) -> tuple[Closing, np.ndarray, np.ndarray]:
    """Close the joints at platform poses (n, 7), from the reference: the closing, its points, and
    which of them closed (n,).
    """
    closing = Closing(model, held=("pose",))
    return closing, *closing.close(with_poses(model.closure, poses))


def with_poses(closure: Closure, poses: np.ndarray, around: np.ndarray | None = None) -> np.ndarray:
    """Put the pose coordinates nearest to poses (n, 7) into the closure's variables `around` (n,
    width), by default those of the reference; they stay where a pose is not a number, or the
    closure has none.
    """
    given = np.isfinite(poses).all(axis=1)
    values = np.tile(closure.reference, (len(poses), 1)) if around is None else around.copy()
    if closure.role("pose") and given.any():
        position, quaternion = poses[given, :3].T, poses[given, 3:].T
        numbers, _ = poses_coordinates(closure.mechanism, position, quaternion)
        begin = closure.slices[closure.role("pose")[0].name].start
        values[given, begin : begin + numbers.shape[1]] = numbers
    return values


def outside_limits(c: Coordinate, values: np.ndarray, kept: float = 0.0) -> np.ndarray:
    """Tell which values (n,) of a coordinate are outside its limits, angles by whole turns as near
    as may be, or nearer than `kept` to one of them, or below the least value of a rod.
    """
    low, high = c.limits or (-np.inf, np.inf)
    if c.limits is not None and c.is_periodic:
        values = into_limits(values, c.limits)
    least = -np.inf if c.least is None else c.least
    return (values < low + kept) | (values > high - kept) | (values < least)
