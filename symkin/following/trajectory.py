"""Make a path of inputs: joint values or poses from sample to sample, in the mechanism's units, with all turns of angles kept.

Between two samples each joint value and each position moves straight, a rotation by the shortest way about a fixed axis
(slerp), an angle of a restricted motion by the shortest way:

    k(u) = a + u (b - a),    q(u) = cos(u h) a + sin(u h) n,    0 <= u <= 1,

h half the angle between two orientations and n the unit quaternion orthogonal to a in their plane (slerp, Shoemake 1985).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.ignored_options import refuse_ignored
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.position.given import Joints, joint_rows, joint_values, pose_coordinates, pose_from
from symkin.position.problem import Kind, build_problem
from symkin.spatial.pose import Pose

_ON_MOTION = 1e-6
"""A pose off a restricted motion by less than this times the size is projected, as in `solve`."""
_MOST_SAMPLES = 10**6
"""Samples that a path may be divided into: each one is solved and kept."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Samples (n, w) of the known coordinates of a problem, in radians and the length unit: angles continue over whole turns,
    consecutive quaternions have a scalar product that is not negative. `times` (n,) or None. `given` are the first and the
    last sample as the user wrote them."""

    mechanism: Mechanism
    kind: Kind
    samples: np.ndarray
    times: np.ndarray | None
    given: tuple[tuple[float, ...], tuple[float, ...]]
    notes: tuple[str, ...] = ()

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        return build_problem(self.mechanism, self.kind).known_coordinates

    def __len__(self) -> int:
        return len(self.samples)

    def parameter(self, row: int, u: float) -> float:
        """Share of the path from 0 to 1, each interval between two samples counting the same."""
        return (row + u) / max(len(self) - 1, 1)

    def at(self, row: int, u: float) -> np.ndarray:
        """Values of the known coordinates between samples `row` and `row + 1`."""
        if u == 0.0 or len(self) == 1:
            return np.array(self.samples[row])
        if u == 1.0:
            return np.array(self.samples[row + 1])
        return interpolated(self.coordinates, self.samples[row], self.samples[row + 1], u)

    def time(self, row: int, u: float) -> float | None:
        if self.times is None:
            return None
        return float(self.times[row] + (u * (self.times[row + 1] - self.times[row]) if u else 0.0))


def make_trajectory(
    mechanism: Mechanism,
    *,
    joints: Sequence[Joints] | Mapping[str, Sequence[float]] | np.ndarray | None = None,
    poses: Sequence[Sequence[float] | Pose] | np.ndarray | None = None,
    times: Sequence[float] | None = None,
    count: int | None = None,
) -> Trajectory:
    """A path through rows of actuated joint values (direct problem) or poses (inverse problem), in the mechanism's units.
    With `count`, each interval is divided so that about that many samples stand on the whole path. Raises InputError."""
    require_mechanism(mechanism)
    if (joints is None) == (poses is None):
        raise InputError("a path is given either by joint values (direct problem) or by poses (inverse problem)")
    rows: list[Any] = joint_rows(mechanism, joints) if joints is not None else list(poses if poses is not None else [])
    if not rows:
        raise InputError("the path has no samples; at least one is needed")
    notes: tuple[str, ...] = ()
    if joints is not None:
        samples = np.array([_joints(mechanism, row, k) for k, row in enumerate(rows, start=1)])
        echo = [tuple(float(v) for v in row) for row in (rows[0], rows[-1])]
    else:
        samples, notes = _poses(mechanism, rows)
        echo = [tuple(_seven(row)) for row in (rows[0], rows[-1])]
    trajectory = Trajectory(
        mechanism, "direct" if joints is not None else "inverse", samples, _times(times, len(rows)), (echo[0], echo[-1]), notes
    )
    return trajectory if count is None else _refined(trajectory, count)


def interpolated(coordinates: tuple[Coordinate, ...], a: np.ndarray, b: np.ndarray, u: float) -> np.ndarray:
    """k(u) between two samples."""
    out, start = np.empty(len(a)), 0
    for c in coordinates:
        place = slice(start, start + c.width)
        if c.kind == "quaternion":
            half, normal = great_circle(a[place], b[place])
            out[place] = math.cos(u * half) * a[place] + math.sin(u * half) * normal
        else:
            out[place] = a[place] + u * (b[place] - a[place])
        start += c.width
    return out


def great_circle(a: np.ndarray, b: np.ndarray) -> tuple[float, np.ndarray]:
    """Half the angle of the rotation between unit quaternions (a.b not negative), and the unit quaternion n with
    b = cos(half) a + sin(half) n; n is zero where they are equal."""
    across = b - (a @ b) * a
    across = across - (a @ across) * a
    length = float(np.linalg.norm(across))
    return math.atan2(length, float(a @ b)), across / length if length > 0.0 else across


def _joints(mechanism: Mechanism, row: Sequence[float], number: int) -> np.ndarray:
    """Joint values without leaving out whole turns."""
    what = f"joints of sample {number}"
    once = joint_values(mechanism, row, what)
    whole = np.array(
        [mechanism.angle_in(float(v)) if c.is_angular else float(v) for c, v in zip(mechanism.actuated, row, strict=True)]
    )
    return np.where(np.abs(whole - once) > 1.0, whole, once) if len(once) else once


def _poses(mechanism: Mechanism, rows: Sequence[Sequence[float] | Pose]) -> tuple[np.ndarray, tuple[str, ...]]:
    samples: list[np.ndarray] = []
    furthest = 0.0
    coordinates = build_problem(mechanism, "inverse").known_coordinates
    for number, row in enumerate(rows, start=1):
        values, off = pose_coordinates(mechanism, pose_from(row, f"pose of sample {number}"))
        if off > _ON_MOTION * mechanism.characteristic_length:
            raise InputError(
                f"pose of sample {number} lies off the platform's {mechanism.motion} motion by {off:.3g} "
                f"{mechanism.length_unit}; allowed: {_ON_MOTION * mechanism.characteristic_length:.3g}"
            )
        furthest = max(furthest, off)
        samples.append(_continued(coordinates, samples[-1], values) if samples else values)
    notes = (
        (f"poses were projected onto the platform's {mechanism.motion} motion, by {furthest:.3g} {mechanism.length_unit}",)
        if furthest > 1e-12 * mechanism.characteristic_length
        else ()
    )
    return np.array(samples), notes


def _continued(coordinates: tuple[Coordinate, ...], before: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The same pose, its quaternion and angle written as near as possible to those before."""
    out, start = values.copy(), 0
    for c in coordinates:
        place = slice(start, start + c.width)
        if c.kind == "quaternion":
            out[place] = values[place] if values[place] @ before[place] >= 0.0 else -values[place]
        elif c.kind == "angle":
            out[place] = before[place] + np.array([math.remainder(values[start] - before[start], 2 * math.pi)])
        start += c.width
    return out


def _seven(row: Sequence[float] | Pose) -> list[float]:
    if isinstance(row, Pose):
        return [float(v) for v in (*np.ravel(row.position), *np.ravel(row.quaternion))]
    return [float(v) for v in row]


def _times(times: Sequence[float] | None, count: int) -> np.ndarray | None:
    if times is None:
        return None
    values = np.asarray(times, dtype=float)
    if len(values) != count:
        raise InputError(f"times: {len(values)} values for {count} samples; one for each is needed")
    if not np.isfinite(values).all():
        raise InputError(f"times: value {int(np.argmin(np.isfinite(values))) + 1} is not finite")
    back = np.flatnonzero(np.diff(values) < 0)
    if back.size:
        raise InputError(
            f"times: value {back[0] + 2} is {values[back[0] + 1]:g}, before {values[back[0]]:g}; times must not go back"
        )
    return values


def _refined(trajectory: Trajectory, count: int) -> Trajectory:
    intervals = len(trajectory) - 1
    if not isinstance(count, int | np.integer) or not 2 <= count <= _MOST_SAMPLES:
        raise InputError(f"samples = {count}; a whole number from 2 to {_MOST_SAMPLES} is needed")
    if intervals < 1 or count < len(trajectory):
        have = f"{len(trajectory)} sample{'s' * (intervals > 0)}"
        reason = (
            f"the path has {have} already, which {'can only be divided further' if intervals else 'leaves nothing to divide'}"
        )
        refuse_ignored({f"samples = {count}": count}, reason)
    if count == len(trajectory):
        return trajectory
    parts = math.ceil((count - 1) / intervals)
    places = [(row, j / parts) for row in range(intervals) for j in range(parts)] + [(intervals - 1, 1.0)]
    samples = np.array([trajectory.at(row, u) for row, u in places])
    times = None if trajectory.times is None else np.array([trajectory.time(row, u) for row, u in places], dtype=float)
    return Trajectory(trajectory.mechanism, trajectory.kind, samples, times, trajectory.given, trajectory.notes)
