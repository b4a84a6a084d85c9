"""Make a path of inputs: joint values or poses from sample to sample, in the mechanism's units,
with all turns of angles kept.

Between two samples each joint value and each position moves straight, a rotation by the shortest
way about a fixed axis (slerp), an angle of a restricted motion by the shortest way:

    k(u) = a + u (b - a),    q(u) = cos(u h) a + sin(u h) n,    0 <= u <= 1,

h half the angle between two orientations and n the unit quaternion orthogonal to a in their plane
(slerp, Shoemake 1985).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from symkin.errors import InputError
from symkin.following.options import Columns, PathOptions
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.position.given import (
    Given,
    given_by_name,
    given_joints,
    is_many,
    joint_rows,
    pose_from,
    rows_by_name,
)
from symkin.position.pose_coordinates import ON_MOTION, pose_coordinates
from symkin.position.problem import (
    Kind,
    Problem,
    are_joints_of_limbs,
    are_of_limbs,
    build_problem,
    pose_names,
)
from symkin.position.readings import left_out
from symkin.spatial.backend import Array, cos, sin
from symkin.spatial.pose import Pose
from symkin.verb import verb
from symkin.verb_options import refuse_ignored

_ROUNDED = 1e-12
"""Of the size: a shorter way onto the motion is rounding."""
_MOST_SAMPLES = 10**6
"""Samples that a path may be divided into: each one is solved and kept."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Samples (n, w) of the known coordinates of a problem, in radians and the length unit: angles
    continue over whole turns, consecutive quaternions have a scalar product that is not negative.
    `times` (n,) or None. `given` are the first and the last sample as the user wrote them:
    arguments of `solve`. The closure holds the joints that are `limited`.
    """

    problem: Problem
    samples: np.ndarray
    times: np.ndarray | None
    given: tuple[dict[str, Any], dict[str, Any]]
    notes: tuple[str, ...] = ()
    limited: tuple[str, ...] = ()

    @property
    def mechanism(self) -> Mechanism:
        return self.problem.mechanism

    @property
    def kind(self) -> Kind:
        """What is followed, as users read it."""
        return self.problem.name

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        return self.problem.known_coordinates

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
        c = coefficients(self.coordinates, self.samples[row], self.samples[row + 1])
        return np.concatenate([np.zeros(0), *between_samples(self.coordinates, c, u)])

    def time(self, row: int, u: float) -> float | None:
        if self.times is None:
            return None
        return float(self.times[row] + (u * (self.times[row + 1] - self.times[row]) if u else 0.0))


@verb(PathOptions)
def make_trajectory(mechanism: Mechanism, **options: Unpack[PathOptions]) -> Trajectory:
    """A path through rows of actuated joint values, poses, or values of coordinates by name, in the
    mechanism's units. With `samples`, each interval is divided so that about that many samples
    stand on the whole path. With `limits` the closure of coordinates by name holds all joints that
    have some. Raises InputError.
    """
    joints, poses, given = options["joints"], options["poses"], options["given"]
    count = options["samples"]
    require_mechanism(mechanism)
    if sum(path is not None for path in (joints, poses, given)) != 1:
        raise InputError(
            "a path is given either by joint values (direct problem) or by poses (inverse "
            "problem), or by values of coordinates by name "
            "(given)"
        )
    form, rows = _rows(mechanism, joints, poses, given)
    if not rows:
        raise InputError("the path has no samples; at least one is needed")
    read = [_READ[form](mechanism, row, k) for k, row in enumerate(rows, start=1)]
    limited = _limited(mechanism, read[0].names) if options["limits"] else ()
    problem = path_problem(mechanism, read[0].names, limited)
    samples, size = list[np.ndarray](), mechanism.characteristic_length
    motion, unit = f"the platform's {mechanism.motion} motion", mechanism.length_unit
    for k, one in enumerate(read, start=1):
        if one.off_motion > ON_MOTION * size:
            raise InputError(
                f"pose of sample {k} lies off {motion} by {one.off_motion:.3g} {unit}; allowed: "
                f"{ON_MOTION * size:.3g}"
            )
        samples.append(
            continued(problem.known_coordinates, samples[-1], one.values) if samples else one.values
        )
    furthest = max(one.off_motion for one in read)
    projected = furthest > _ROUNDED * size
    note = f"poses were projected onto {motion}, by {furthest:.3g} {unit}"
    trajectory = Trajectory(
        problem,
        np.array(samples),
        _times(options["times"], len(rows)),
        (read[0].echo, read[-1].echo),
        (note,) if projected else (),
        limited,
    )
    return trajectory if count is None else _refined(trajectory, count)


def _rows(
    mechanism: Mechanism, joints: Any, poses: Any, given: Columns | None
) -> tuple[str, list[Any]]:
    """What a path is told by, "joints", "pose" or "given", and its rows. Values by name that are
    those of all actuated joints of limbs are joints, a whole pose of limbs is a pose.
    """
    if given is not None:
        rows = _named_rows(given)
        names = tuple(rows[0]) if rows else ()
        if not are_of_limbs(mechanism, names):
            return "given", rows
        if are_joints_of_limbs(mechanism, names):
            joints = {name: [row[name] for row in rows] for name in names}
        else:
            poses = [row["pose"] for row in rows]
    if joints is not None:
        return "joints", joint_rows(mechanism, joints)
    if mechanism.platform_link is None:
        raise InputError(
            f"poses: {mechanism.name} has no platform link; name it by [platform] link in its "
            f"mechanism file, of a robot's file by --platform LINK, or give joints"
        )
    return "pose", list(poses)


def _limited(mechanism: Mechanism, names: tuple[str, ...]) -> tuple[str, ...]:
    """The joints that have limits, but for known ones."""
    own = mechanism.coordinates
    return tuple(c.name for c in own if c.limits is not None and c.name not in names)


def path_problem(mechanism: Mechanism, names: tuple[str, ...], limited: tuple[str, ...]) -> Problem:
    """The problem of known coordinates; its closure holds joints that are limited, so that these
    are seen: all of them where one would be left out, since a loop that is not cut there may be cut
    at another.
    """
    if not are_of_limbs(mechanism, names):
        return build_problem(mechanism, names, limited)
    left = {c.name for c in left_out(build_problem(mechanism, names).closure)}
    return build_problem(mechanism, names, limited=limited if left & {*limited} else ())


def _named_rows(given: Columns) -> list[dict[str, Any]]:
    """Rows of values by name from a column for each name; a single value stands for the whole
    path.
    """
    if not isinstance(given, Mapping) or not given:
        raise InputError(
            "given: columns of values by name are needed, as in given={'crank': [0.0, 90.0]}"
        )
    if not is_many(None, None, given):
        raise InputError(
            "given: every value stands alone; a path has values for at least one coordinate, one a "
            "sample"
        )
    return rows_by_name(given, "a sample, or one for all")


def coefficients(coordinates: Sequence[Coordinate], a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """What tells k(u) between samples: a, b - a of each number; a, n, h of each quaternion."""
    out, start = list[float](), 0
    for c in coordinates:
        begin, end = (sample[start : start + c.width] for sample in (a, b))
        if c.is_rotation:
            half, normal = great_circle(begin, end)
            out += [*begin.tolist(), *normal.tolist(), half]
        else:
            out += [float(begin[0]), float(end[0] - begin[0])]
        start += c.width
    return np.array(out)


def between_samples(coordinates: Sequence[Coordinate], c: Array, u: Array) -> list[Array]:
    """k(u) from its coefficients, numbers or expressions, a part for each coordinate."""
    out, start = list[Array](), 0
    for coordinate in coordinates:
        if coordinate.is_rotation:
            a, n, half = c[start : start + 4], c[start + 4 : start + 8], c[start + 8]
            out.append(cos(u * half) * a + sin(u * half) * n)
            start += 9
        else:
            out.append(c[start : start + 1] + u * c[start + 1 : start + 2])
            start += 2
    return out


def great_circle(a: np.ndarray, b: np.ndarray) -> tuple[float, np.ndarray]:
    """Half the angle of the rotation between unit quaternions (a.b not negative), and the unit
    quaternion n with b = cos(half) a + sin(half) n; n is zero where they are equal.
    """
    across = b - (a @ b) * a
    across = across - (a @ across) * a
    length = float(np.linalg.norm(across))
    return math.atan2(length, float(a @ b)), across / length if length > 0.0 else across


def _joints(mechanism: Mechanism, row: Sequence[float], number: int) -> Given:
    """Joint values without leaving out whole turns."""
    what = f"joints of sample {number}"
    read = given_joints(mechanism, row, what)
    whole = np.array(
        [mechanism.value_in(c, float(v)) for c, v in zip(mechanism.actuated, row, strict=True)]
    )
    values = np.where(np.abs(whole - read.values) > 1.0, whole, read.values)
    return replace(read, values=values, notes=())


def _pose(mechanism: Mechanism, row: Sequence[float] | Pose, number: int) -> Given:
    """The pose of the platform's motion that is nearest."""
    values, off = pose_coordinates(mechanism, pose_from(row, f"pose of sample {number}"))
    numbers = [*row.position, *row.quaternion] if isinstance(row, Pose) else row
    echo = {"pose": [float(v) for v in numbers]}
    return Given(pose_names(mechanism), values, echo, off_motion=off)


def _named(mechanism: Mechanism, row: dict[str, Any], number: int) -> Given:
    """Values by name."""
    try:
        read = given_by_name(mechanism, row)
    except InputError as error:
        raise InputError(f"sample {number}: {error}" if number > 1 else str(error)) from None
    return replace(read, echo={"given": read.echo})


_READ: dict[str, Callable[[Mechanism, Any, int], Given]] = {
    "joints": _joints,
    "pose": _pose,
    "given": _named,
}
"""How a row of a path is read."""


def continued(
    coordinates: tuple[Coordinate, ...], before: np.ndarray, values: np.ndarray
) -> np.ndarray:
    """The same pose, its quaternion and angle written as near as possible to those before; other
    values as they are.
    """
    out, start = values.copy(), 0
    for c in coordinates:
        place = slice(start, start + c.width)
        if c.is_rotation and values[place] @ before[place] < 0.0:
            out[place] = -values[place]
        elif c.is_periodic and c.role == "pose":
            turned = math.remainder(values[start] - before[start], 2 * math.pi)
            out[start] = before[start] + turned
        start += c.width
    return out


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
            f"times: value {back[0] + 2} is {values[back[0] + 1]:g}, before {values[back[0]]:g}; "
            f"times must not go back"
        )
    return values


def _refined(trajectory: Trajectory, count: int) -> Trajectory:
    intervals = len(trajectory) - 1
    if not isinstance(count, int | np.integer) or not 2 <= count <= _MOST_SAMPLES:
        raise InputError(f"samples = {count}; a whole number from 2 to {_MOST_SAMPLES} is needed")
    if intervals < 1 or count < len(trajectory):
        have = f"{len(trajectory)} sample{'s' * (intervals > 0)}"
        reason = (
            f"the path has {have} already, which "
            f"{'can only be divided further' if intervals else 'leaves nothing to divide'}"
        )
        refuse_ignored({f"samples = {count}": count}, reason)
    if count == len(trajectory):
        return trajectory
    parts = math.ceil((count - 1) / intervals)
    places = [(row, j / parts) for row in range(intervals) for j in range(parts)]
    places.append((intervals - 1, 1.0))
    samples, times = np.array([trajectory.at(*place) for place in places]), trajectory.times
    if times is not None:
        times = np.array([trajectory.time(*place) for place in places], dtype=float)
    return replace(trajectory, samples=samples, times=times)
