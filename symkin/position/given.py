"""What the user gives: joint values, a pose or a start, read at the border into radians and unit
quaternions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.machine.lower import Lowered, lowered
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.model.oddities import FULL_TURN
from symkin.plain_number import plain
from symkin.position.feasible_pose import PROJECTED, closing_poses, nearest_pose, ties_poses
from symkin.position.problem import Kind, OfKind
from symkin.spatial.backend import Array, atan2, vector
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, wrapped
from symkin.text import counted, first_of, meant, shown
from symkin.verb import real

_ON_MOTION = 1e-6
"""A pose off a restricted motion by less than this (of the size, or rad) is projected onto it."""

Joints = Sequence[float] | Mapping[str, float]
"""Values of all actuated joints in the mechanism's units: in file order, or by name."""

LARGEST_GIVEN = 1e150
"""Largest magnitude of a given value, in the mechanism's units: the square of a larger one
overflows a double.
"""


@dataclass(frozen=True)
class Given(OfKind):
    """Known values of a problem: `values` in inside units, `echo` as the user gave them;
    `off_motion` is how far a pose lies off the platform's motion (length unit), 0 when it lies on
    it or was projected; `names` are the coordinates of a "given" problem.
    """

    kind: Kind
    values: np.ndarray
    echo: dict[str, Any]
    names: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    off_motion: float = 0.0


def given_from(
    mechanism: Mechanism, joints: Joints | None, pose: Sequence[float] | Pose | None
) -> Given:
    """Joints make a direct problem, a pose an inverse one; neither: the example's, else the
    reference's joints.
    """
    require_mechanism(mechanism)
    if joints is not None and pose is not None:
        raise InputError(
            "both joints and a pose are given; joints make a direct problem, a pose an inverse "
            "one: give one of them"
        )
    if joints is None and pose is None:
        example = mechanism.example
        if example is not None and example.joints is not None:
            joints = example.joints
        elif example is not None and example.pose is not None:
            pose = example.pose
        else:
            joints = [_coordinate_out(mechanism, c) for c in mechanism.actuated]
            if not joints:
                raise InputError(
                    f"{mechanism.name} has no actuated joint and no [example]; nothing to solve: "
                    f"give a pose"
                )
    if pose is not None:
        return given_pose(mechanism, pose)
    assert joints is not None  # noqa: S101 - one of the branches above has set it
    ordered = in_file_order(mechanism, joints)
    values = joint_values(mechanism, ordered)
    return Given(
        "direct",
        values,
        {"joints": [float(v) for v in ordered]},
        notes=_turn_notes(mechanism, ordered),
    )


def _turn_notes(mechanism: Mechanism, ordered: Sequence[float]) -> tuple[str, ...]:
    """A note on angles of more than a turn where the unit is rad."""
    if mechanism.angle_unit != "rad":
        return ()
    told = [
        f"{c.name} = {v:g}"
        for c, v in zip(mechanism.actuated, ordered, strict=True)
        if c.is_periodic and abs(v) > FULL_TURN
    ]
    return (
        (
            f"{first_of(told, 3)} rad: more than a turn, taken without its whole turns; are "
            f"degrees meant?",
        )
        if told
        else ()
    )


def are_many(values: Any) -> bool:
    """Whether values are those of several inputs: an array (n, numbers), a sequence of sequences,
    mappings or poses, or a mapping of names to columns.
    """
    if values is None or isinstance(values, (Pose, str)):
        return False
    if isinstance(values, Mapping):
        return any(np.ndim(column) > 0 for column in values.values())
    if isinstance(values, np.ndarray):
        return values.ndim == 2
    return (
        isinstance(values, Sequence)
        and len(values) > 0
        and not isinstance(values[0], str)
        and isinstance(values[0], (Pose, Sequence, Mapping, np.ndarray))
    )


def given_many(mechanism: Mechanism, joints: Any, pose: Any) -> list[Given]:
    """As `given_from`, for n inputs: all joints (n, joints) or all poses (n, 7); a message names
    the input that does not fit, counted from 0.
    """
    require_mechanism(mechanism)
    if joints is not None and pose is not None:
        return [given_from(mechanism, joints, pose)]
    if pose is not None:
        return [_named_input(i, partial(given_pose, mechanism, one)) for i, one in enumerate(pose)]
    joints = joint_rows(mechanism, joints) if isinstance(joints, Mapping) else joints
    rows = _rows_without_fault(mechanism, joints)
    if rows is None:
        return [
            _named_input(i, partial(given_from, mechanism, one, None))
            for i, one in enumerate(joints)
        ]
    values = rows * np.array([mechanism.value_in(c, 1.0) for c in mechanism.actuated])
    return [
        Given("direct", v, {"joints": echo}) for v, echo in zip(values, rows.tolist(), strict=True)
    ]


def _named_input(number: int, read: Callable[[], Given]) -> Given:
    try:
        return read()
    except InputError as error:
        raise InputError(f"input {number}: {error}") from None


def _rows_without_fault(mechanism: Mechanism, joints: Any) -> np.ndarray | None:
    """Joint values (n, joints) that all fit and are within a turn, so that they need no look one by
    one; else None.
    """
    coordinates = mechanism.actuated
    try:
        rows = np.array(joints)
    except ValueError:
        return None
    if (
        rows.dtype.kind not in "fiu"
        or rows.ndim != 2
        or rows.shape[1] != len(coordinates)
        or not (np.abs(rows) <= LARGEST_GIVEN).all()
    ):
        return None
    rows = rows.astype(float)
    turn = mechanism.angle_out(2 * math.pi)
    least = np.array([-np.inf if c.least is None else c.least for c in coordinates])
    most = np.array([turn if c.is_periodic else np.inf for c in coordinates])
    return rows if ((rows >= least) & (np.abs(rows) <= most)).all() else None


def in_file_order(mechanism: Mechanism, joints: Joints, what: str = "joints") -> Sequence[float]:
    """The values of all actuated joints in file order; those given in a row stay as they are, those
    given by name are put in their places. Raises InputError for a name that is no actuated joint,
    and for one that is missing.
    """
    if not isinstance(joints, Mapping):
        return joints
    names = [c.name for c in mechanism.actuated]
    allowed = f"the actuated joints of {mechanism.name} are {', '.join(names) or 'none'}"
    unknown = [str(name) for name in joints if name not in names]
    if unknown:
        verb, near = "is" if len(unknown) == 1 else "are", meant(unknown[0], names)
        raise InputError(
            f"{what}: {', '.join(map(shown, unknown))} {verb} unknown{near}; {allowed}"
        )
    missing = [name for name in names if name not in joints]
    if missing:
        raise InputError(
            f"{what}: no value is given for {', '.join(missing)}; {allowed}, and each one needs a "
            f"value"
        )
    return [joints[name] for name in names]


def joint_rows(
    mechanism: Mechanism, joints: Sequence[Joints] | Mapping[str, Sequence[float]] | np.ndarray
) -> list[Sequence[float]]:
    """Rows of actuated joint values in file order, from rows of either form or from a column for
    each name. Raises InputError.
    """
    if not isinstance(joints, Mapping):
        return [
            in_file_order(mechanism, row, f"joints of sample {k}")
            for k, row in enumerate(joints, start=1)
        ]
    columns = in_file_order(mechanism, joints)  # type: ignore[arg-type]
    lengths = {np.size(column) for column in columns}
    if len(lengths) > 1:
        counts = ", ".join(
            f"{c.name} {np.size(column)}"
            for c, column in zip(mechanism.actuated, columns, strict=True)
        )
        raise InputError(
            f"joints: the columns have different counts of values ({counts}); each joint needs one "
            f"a sample"
        )
    return [
        list(row) for row in zip(*(np.ravel(column).tolist() for column in columns), strict=True)
    ]


def joint_values(mechanism: Mechanism, values: Joints, what: str = "joints") -> np.ndarray:
    """Actuated joint values in file order, from the mechanism's units to radians, angles of more
    than a turn without their whole turns; lengths must not be negative.
    """
    coordinates = mechanism.actuated
    numbers = _numbers(in_file_order(mechanism, values, what), what)
    if len(numbers) != len(coordinates):
        names = ", ".join(c.name for c in coordinates) or "none"
        raise InputError(
            f"{what}: {counted(len(numbers))} given, {mechanism.name} has {len(coordinates)} "
            f"actuated joints ({names})"
        )
    for coordinate, number in zip(coordinates, numbers, strict=True):
        refuse_negative_rod(mechanism, coordinate, number, what)
    turn = mechanism.angle_out(2 * math.pi)
    whole = [
        math.remainder(n, turn) if c.is_periodic and abs(n) > turn else n
        for c, n in zip(coordinates, numbers, strict=True)
    ]
    return np.array([mechanism.value_in(c, n) for c, n in zip(coordinates, whole, strict=True)])


def pose_from(values: Joints | Pose, what: str = "pose") -> Pose:
    """A pose from x, y, z, qw, qx, qy, qz; the quaternion is normalised, refused when its norm is
    off by over 1e-2.
    """
    if isinstance(values, Mapping):
        raise InputError(
            f"{what}: values by name are given ({', '.join(map(str, values))}); a pose x, y, z, "
            f"qw, qx, qy, qz is needed"
        )
    if isinstance(values, Pose):
        values = [*np.asarray(values.position).ravel(), *np.asarray(values.quaternion).ravel()]
    numbers = _numbers(values, what)
    if len(numbers) != 7:
        raise InputError(
            f"{what}: {counted(len(numbers))} given, 7 are needed: x, y, z, qw, qx, qy, qz"
        )
    norm = math.hypot(*numbers[3:])
    if abs(norm - 1.0) > 1e-2:
        raise InputError(
            f"{what}: the quaternion {numbers[3:]} has norm {norm:.6g}; allowed: 1 to within 0.01"
        )
    return Pose(np.array(numbers[:3]), np.array(numbers[3:]) / norm)


def pose_coordinates(mechanism: Mechanism, pose: Pose) -> tuple[np.ndarray, float]:
    """Pose coordinates of the motion nearest to a pose, and the distance left (length unit, angles
    times the size).
    """
    values, off = poses_coordinates(
        mechanism, np.asarray(pose.position)[:, None], np.asarray(pose.quaternion)[:, None]
    )
    return values[0], float(off[0])


def poses_coordinates(
    mechanism: Mechanism, position: np.ndarray, quaternion: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Of poses with position (3, n) and unit quaternion (4, n): coordinates (n, numbers) of the
    motion nearest to each, and the distances left (n,).
    """
    numbers = motion_coordinates(mechanism, position, quaternion).T.copy()
    if mechanism.motion in ("schoenflies", "planar"):
        numbers[:, -1] = wrapped(numbers[:, -1])
    return numbers, _off_motion(mechanism, position, quaternion)


def motion_coordinates(mechanism: Mechanism, position: Array, quaternion: Array) -> Array:
    """The coordinates, an angle up to whole turns, of the declared motion nearest to a pose: of
    numbers (3, n) and (4, n), or of expressions.
    """
    match mechanism.motion:
        case "schoenflies":
            return vector(*_parts(position, 3), _turn_about_z(mechanism, quaternion))
        case "planar":
            return vector(*_parts(position, 2), _turn_about_z(mechanism, quaternion))
        case "translation":
            return position
        case "spherical":
            return quaternion
        case _:
            return vector(*_parts(position, 3), *_parts(quaternion, 4))


def _parts(numbers: Array, count: int) -> list[Array]:
    return [numbers[k] for k in range(count)]


def _turn_about_z(mechanism: Mechanism, quaternion: Array) -> Array:
    """The turn about z from the reference that is nearest to that of a quaternion."""
    delta = multiply(quaternion, conjugate(mechanism.reference_pose.quaternion))
    return 2.0 * atan2(delta[3], delta[0])


def _off_motion(mechanism: Mechanism, position: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
    """How far (n,) poses with position (3, n) and unit quaternion (4, n) lie off the declared
    motion, turns times the size.
    """
    if mechanism.motion == "spatial":
        return np.zeros(position.shape[1])
    reference, size = mechanism.reference_pose, mechanism.characteristic_length
    away = np.abs(position - np.asarray(reference.position)[:, None])
    if mechanism.motion == "spherical":
        return np.asarray(away.max(axis=0))
    w, x, y, z = multiply(quaternion, conjugate(reference.quaternion))
    # a turn about z and one about an axis normal to it: each has a half of the quaternion
    tilt = 2.0 * size * np.arctan2(np.hypot(x, y), np.hypot(w, z))
    match mechanism.motion:
        case "planar":
            return np.asarray(np.maximum(tilt, away[2]))
        case "translation":
            turn = np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(w))
            return np.asarray(2.0 * size * turn)
        case _:
            return np.asarray(tilt)


def leaves_motion(mechanism: Mechanism, position: np.ndarray, quaternion: np.ndarray) -> bool:
    """Whether any of some poses, with positions (n, 3) and unit quaternions (n, 4), lies off the
    motion that is declared of the platform, by more than rounding: where joints carry the platform,
    they decide how it moves.
    """
    if mechanism.motion == "spatial" or not len(position):
        return False
    off = _off_motion(mechanism, position.T, quaternion.T)
    return bool(np.any(off > _ON_MOTION * mechanism.characteristic_length))


def motion_note(mechanism: Mechanism, position: np.ndarray, quaternion: np.ndarray) -> str | None:
    """What is said of poses, as `leaves_motion` has them, that lie off the motion that is declared
    of the platform; None where none does.
    """
    if not leaves_motion(mechanism, position, quaternion):
        return None
    return (
        f"the platform's motion is declared {mechanism.motion}, and the joints that carry it move "
        f"it otherwise too: whole poses are told; "
        "leave the declaration out"
    )


def feasible_poses(
    mechanism: Mechanism, position: np.ndarray, quaternion: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pose coordinates (n, numbers) that the mechanism can take, nearest to poses with position (3,
    n) and unit quaternion (4, n), and how far those that are more than rounding lie off them, 0 for
    others.
    """
    own, pose = _with_own_motion(mechanism), Pose(position, quaternion)
    if own is not None:
        values, off = _feasible_of_machine(own.machine, own.taken(pose), PROJECTED)
        there = own.told(pose_of(own.machine, values))
        written, _ = poses_coordinates(mechanism, position, quaternion)
        nearest, _ = poses_coordinates(
            mechanism, np.asarray(there.position), np.asarray(there.quaternion)
        )
        return np.where(off[:, None] > 0.0, written, nearest), off
    return _feasible_of_machine(mechanism, pose, _ON_MOTION)


def _feasible_of_machine(
    mechanism: Mechanism, pose: Pose, near: float
) -> tuple[np.ndarray, np.ndarray]:
    """`feasible_poses` of a mechanism whose motion is declared; poses `near` it, over the size, are
    projected onto it.
    """
    values, off = poses_coordinates(
        mechanism, np.asarray(pose.position), np.asarray(pose.quaternion)
    )
    off = np.where(off < near * mechanism.characteristic_length, 0.0, off)
    if ties_poses(mechanism):
        for i in np.flatnonzero((off == 0.0) & ~closing_poses(mechanism, values)):
            values[i], off[i], _ = _feasible(mechanism, values[i])
    return values, off


def _with_own_motion(mechanism: Mechanism) -> Lowered | None:
    """The machine whose platform has a motion that the description does not declare."""
    if mechanism.motion != "spatial":
        return None
    low = lowered(mechanism)
    return None if low is None or low.machine.motion == "spatial" else low


def given_pose(mechanism: Mechanism, given: Sequence[float] | Pose) -> Given:
    """The known values of the inverse problem: of a pose on the platform's motion, which is
    declared or which its joints leave it, and, where joints tie poses, on those that they can take.
    """
    pose = pose_from(given)
    own = _with_own_motion(mechanism)
    if own is None:
        return given_of_pose(mechanism, pose)
    there = given_of_pose(own.machine, own.taken(pose), near=PROJECTED, low=own)
    on_motion = pose if there.off_motion else own.told(pose_of(own.machine, there.values))
    values, _ = pose_coordinates(mechanism, on_motion)
    return replace(there, values=values, echo=_echo(pose))


def given_of_pose(
    mechanism: Mechanism,
    pose: Pose,
    *,
    is_feasible: bool = False,
    near: float = _ON_MOTION,
    low: Lowered | None = None,
) -> Given:
    """`given_pose` of numbers that were looked at before, on the declared motion; the joints can
    take a pose that `is_feasible`, and one `near` the motion, over the size, is projected onto it.
    Notes tell of the description of `low`, whose machine the mechanism is.
    """
    values, off = pose_coordinates(mechanism, pose)
    notes: tuple[str, ...] = ()
    if 0.0 < off < near * mechanism.characteristic_length:
        if off > 1e-12 * mechanism.characteristic_length:
            notes = (
                f"the pose was projected onto the platform's {mechanism.motion} motion, by "
                f"{off:.3g} {mechanism.length_unit}",
            )
        off = 0.0
    elif off > 0.0:
        notes = (
            f"the pose lies off the platform's {mechanism.motion} motion by {off:.3g} "
            f"{mechanism.length_unit}",
        )
    if off == 0.0 and not is_feasible:
        values, off, more = _feasible(mechanism, values, low)
        notes += more
    return Given("inverse", values, _echo(pose), (), notes, off)


def _echo(pose: Pose) -> dict[str, Any]:
    return {"pose": [float(v) for v in (*pose.position, *pose.quaternion)]}


def _feasible(
    mechanism: Mechanism, values: np.ndarray, low: Lowered | None = None
) -> tuple[np.ndarray, float, tuple[str, ...]]:
    """Pose coordinates that the joints can take, where they tie them to each other: those of a pose
    with few digits are moved to the nearest; a distance that is more than that or beyond reach, and
    what is said of it, in the words of the description of `low`.
    """
    nearest = nearest_pose(mechanism, values)
    if nearest is None:
        return values, 0.0, ()
    frame = (mechanism if low is None else low.written).frame_name
    unit = mechanism.length_unit
    if nearest.distance <= PROJECTED * mechanism.characteristic_length and not nearest.beyond_reach:
        note = (
            f"the pose was projected onto those that the {frame} can take, by "
            f"{nearest.distance:.3g} {unit}",
        )
        return nearest.values, 0.0, note
    there = pose_of(mechanism, nearest.values)
    there = there if low is None else low.told(there)
    numbers = np.concatenate([there.position, there.quaternion])
    scales = [mechanism.characteristic_length] * 3 + [1.0] * 4
    at = ", ".join(
        f"{plain(v, scale):.7g}" for v, scale in zip(numbers.tolist(), scales, strict=True)
    )
    note = (
        f"the joints tie the coordinates of the {frame}'s pose, and this one lies "
        f"{nearest.distance:.3g} {unit} (angles times the "
        f"size) off those that it can take; the nearest is {at}",
    )
    return values, nearest.distance, note


def pose_of(mechanism: Mechanism, values: np.ndarray) -> Pose:
    """The pose whose coordinates (numbers,) are these of the mechanism's motion, or a stack of them
    for coordinates (n, numbers).
    """
    columns = np.asarray(values, dtype=float).T
    if mechanism.motion == "spatial":
        return Pose(columns[:3], columns[3:])
    reference, shape = mechanism.reference_pose, columns.shape[1:]
    position, home = (
        np.broadcast_to(np.reshape(part, (-1, *[1] * len(shape))), (len(part), *shape)).copy()
        for part in map(np.asarray, (reference.position, reference.quaternion))
    )
    if mechanism.motion == "spherical":
        return Pose(position, columns)
    lengths = 2 if mechanism.motion == "planar" else 3
    position[:lengths] = columns[:lengths]
    half = 0.5 * (columns[lengths] if len(columns) > lengths else np.zeros(shape))
    none = np.zeros(shape)
    return Pose(position, multiply(np.array([np.cos(half), none, none, np.sin(half)]), home))


def _numbers(values: Sequence[float], what: str) -> list[float]:
    if isinstance(values, (Set, str, bytes, bytearray)) or not isinstance(values, Iterable):
        raise InputError(f"{what} = {shown(values)} is no list of numbers")
    return [number_of(value, f"{what}: value {k}") for k, value in enumerate(values, start=1)]


def number_of(value: Any, what: str) -> float:
    """A given number. Raises InputError where it is none, or none to compute with."""
    try:
        number = real(value)
    except OverflowError:
        number = LARGEST_GIVEN * 2
    except (TypeError, ValueError):
        raise InputError(f"{what} = {shown(value)} is not a number") from None
    if not math.isfinite(number):
        raise InputError(f"{what} = {shown(value)} is not finite")
    if abs(number) > LARGEST_GIVEN:
        raise InputError(
            f"{what} = {shown(value)} is too large to compute with; allowed: magnitudes up to "
            f"{LARGEST_GIVEN:g}"
        )
    return number


def refuse_negative_rod(mechanism: Mechanism, c: Coordinate, number: float, what: str) -> None:
    """Raise InputError for the value of a rod that makes its length negative."""
    if c.least is not None and number < c.least:
        raise InputError(
            f"{what}: {c.name} = {number:g} makes a rod of length {number - c.least:g} "
            f"{mechanism.length_unit}; allowed: {c.least + 0.0:g} and above"
        )


def _coordinate_out(mechanism: Mechanism, coordinate: Coordinate) -> float:
    value = coordinate.reference[0]
    return mechanism.value_out(coordinate, value)
