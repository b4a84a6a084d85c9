"""What the user gives: joints, a pose, or values of any coordinates by name, read at the border
into radians and unit quaternions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.machine.lower import Lowered
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.model.oddities import FULL_TURN
from symkin.numeric.linear_algebra import squared_norms
from symkin.position.feasible_pose import taken_poses, ties_poses
from symkin.position.pose_coordinates import (
    feasible_pose,
    motion_pose,
    pose_coordinates,
    poses_coordinates,
    projected_below,
    reader_of_poses,
)
from symkin.position.problem import actuated_names, are_joints_of_limbs, pose_names
from symkin.quiet import collector_at_rest
from symkin.spatial.pose import NORM_OFF, Pose
from symkin.text import counted, first_of, meant, shown
from symkin.verb import real

_Read = TypeVar("_Read")
Joints = Sequence[float] | Mapping[str, float]
"""Values of all actuated joints in the mechanism's units: in file order, or by name."""
Values = Mapping[str, float | Sequence[float]]
"""Values of any coordinates by name."""
Columns = Mapping[str, float | Sequence[float] | Sequence[Sequence[float]] | np.ndarray]
"""Values by name of many inputs: columns, and one value where all inputs have the same."""

LARGEST_GIVEN = 1e150
"""Largest magnitude of a given value, in the mechanism's units: the square of a larger one
overflows a double.
"""

_ROUNDING = 1e-12
"""Of the size: how far rounding moves a pose off those that the platform can take."""


@dataclass(frozen=True)
class Given:
    """Known values of a problem: the `names` of its known coordinates, their `values` in inside
    units, `echo` as the user gave them; `off_motion` is how far a pose lies off those that the
    platform can take (length unit), 0 where it is one or was projected; `there` is the pose as the
    machine has it that reads it, where this is not the description.
    """

    names: tuple[str, ...]
    values: np.ndarray
    echo: dict[str, Any]
    notes: tuple[str, ...] = ()
    off_motion: float = 0.0
    there: Given | None = None


# --- one input ------------------------------------------------------------------------------------


def read_given(
    mechanism: Mechanism, joints: Any = None, pose: Any = None, given: Values | None = None
) -> Given:
    """What is given in any form: all actuated joints, the platform's pose, or values by name. Where
    nothing is: the example's, else the joints of the reference. Raises InputError.
    """
    require_mechanism(mechanism)
    example = mechanism.example
    if given is None and joints is None and pose is None and example is not None:
        given = None if example.given is None else dict(example.given)
        joints = example.joints if given is None else None
        pose = example.pose if given is None and joints is None else None
    if given is not None:
        if joints is not None or pose is not None:
            raise InputError(
                "given: values by name and joints or a pose beside them; give one of them"
            )
        if isinstance(given, Mapping) and are_joints_of_limbs(mechanism, tuple(given)):
            return given_joints(mechanism, given)  # type: ignore[arg-type]
        return given_by_name(mechanism, given)
    if joints is not None and pose is not None:
        raise InputError(
            "both joints and a pose are given; joints make a direct problem, a pose an inverse "
            "one: give one of them"
        )
    if pose is not None:
        return given_pose(mechanism, pose)
    if joints is None and not mechanism.actuated:
        if mechanism.is_graph:
            return Given((), np.zeros(0), {})
        raise InputError(
            f"{mechanism.name} has no actuated joint and no [example]; nothing to solve: give a "
            f"pose"
        )
    if joints is None:
        joints = [mechanism.value_out(c, c.reference[0]) for c in mechanism.actuated]
    return given_joints(mechanism, joints)


def given_joints(mechanism: Mechanism, joints: Joints, what: str = "joints") -> Given:
    """Values of all actuated joints in the mechanism's units, in file order or by name: angles of
    more than a turn without their whole turns; lengths must not be negative.
    """
    if isinstance(joints, Mapping):
        joints = in_file_order(mechanism, joints, what)
    least, most, unit = _ranges(mechanism)
    is_row = isinstance(joints, (list, tuple, np.ndarray))
    values = _plain_rows([joints], least, most) if is_row else None
    notes: tuple[str, ...] = ()
    if values is None:
        values = np.array([_judged_joints(mechanism, joints, what)])
        notes = _turn_notes(mechanism, joints)
    names, given = actuated_names(mechanism), {"joints": list(map(float, joints))}
    return Given(names, values[0] * unit, given, notes)


@lru_cache(maxsize=128)
def _ranges(mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each actuated joint the least value, the magnitude up to which it is taken as it is, and
    its unit (radians of a degree, or 1).
    """
    coordinates, turn = mechanism.actuated, mechanism.angle_out(2 * math.pi)
    return (
        np.array([-np.inf if c.least is None else c.least for c in coordinates]),
        np.array([turn if c.is_periodic else LARGEST_GIVEN for c in coordinates]),
        np.array([mechanism.value_in(c, 1.0) for c in coordinates]),
    )


def given_pose(mechanism: Mechanism, given: Sequence[float] | Pose) -> Given:
    """A pose of the platform, on its motion, which is declared or which its joints leave it, and,
    where joints tie poses, on those that they can take.
    """
    if mechanism.platform_link is None:
        raise InputError(
            f"pose: {mechanism.name} has no platform link; name it by [platform] link in its "
            f"mechanism file, of a robot's file by --platform LINK, or give joints"
        )
    pose = pose_from(given)
    return given_poses(mechanism, np.array([[*pose.position, *pose.quaternion]]))[0]


@collector_at_rest()
def given_poses(mechanism: Mechanism, rows: np.ndarray) -> list[Given]:
    """`given_pose` for poses (n, 7) whose quaternions are of unit length."""
    low, poses = reader_of_poses(mechanism), Pose(rows[:, :3].T, rows[:, 3:].T)
    machine, at = low.machine, low.taken(poses)
    values, off = poses_coordinates(machine, at.position, at.quaternion)
    exact = off <= _ROUNDING * machine.characteristic_length
    if ties_poses(machine):
        exact &= taken_poses(machine, values)
    names = pose_names(machine)
    found = [Given(names, values[k], {"pose": row}) for k, row in enumerate(rows.tolist())]
    for k in (~exact).nonzero()[0].tolist():
        found[k] = _moved(low, replace(found[k], off_motion=float(off[k])))
    if low.is_written:
        return found
    own, _ = poses_coordinates(mechanism, poses.position, poses.quaternion)
    for k, there in enumerate(found):
        told = own[k]
        if not exact[k] and not there.off_motion:
            told, _ = pose_coordinates(mechanism, low.told(motion_pose(machine, there.values)))
        found[k] = replace(there, names=pose_names(mechanism), values=told, there=there)
    return found


def _moved(low: Lowered, given: Given) -> Given:
    """A pose off those that joints can take, moved to the nearest of them where few digits are why;
    of the machine of `low` notes are told of the description.
    """
    machine, values, off, notes = low.machine, given.values, given.off_motion, list[str]()
    by = f"{off:.3g} {machine.length_unit}"
    if off >= projected_below(low):
        notes.append(f"the pose lies off the platform's {machine.motion} motion by {by}")
    else:
        if off > _ROUNDING * machine.characteristic_length:
            notes.append(
                f"the pose was projected onto the platform's {machine.motion} motion, by {by}"
            )
        values, off, more = feasible_pose(low, values)
        notes += more
    return replace(given, values=values, notes=tuple(notes), off_motion=off)


def given_by_name(mechanism: Mechanism, values: Values) -> Given:
    """Values by name as they are told, in the mechanism's units; "pose" is x, y, z, qw, qx, qy, qz
    as a whole. Raises InputError for a name that nothing has and a value that is none.
    """
    if not isinstance(values, Mapping):
        raise InputError(
            f"given = {shown(str(values))} has no names; values by name are needed, as in "
            f"given={{'crank': 60.0}}"
        )
    coordinates = _coordinates_named(mechanism, values)
    read: Given | None = None
    if "pose" in values and "pose" not in coordinates:
        read = given_pose(mechanism, values["pose"])  # type: ignore[arg-type]
    numbers: dict[str, float] = {}
    for name, value in values.items():
        if read is not None and name == "pose":
            continue
        number = number_of(value, f"given: {name}")
        refuse_negative_rod(mechanism, coordinates[name], number, "given")
        numbers[name] = mechanism.value_in(coordinates[name], number)
    clash = sorted(set(numbers) & set(POSE_CONDITIONS)) if read is not None else []
    if clash:
        raise InputError(
            f"given: the whole pose and {', '.join(clash)} beside it; give one or the other"
        )
    read = read or Given((), np.zeros(0), {})
    return replace(
        read,
        names=(*read.names, *numbers),
        there=None if numbers else read.there,
        values=np.array([*read.values, *numbers.values()]),
        echo=read.echo | {name: float(values[name]) for name in numbers},  # type: ignore[arg-type]
    )


# --- names ----------------------------------------------------------------------------------------


def given_coordinates(mechanism: Mechanism) -> dict[str, Coordinate]:
    """What can be given: coordinates of joints, actuated rods, and those of the pose that no joint
    has the name of.
    """
    found = {c.name: c for c in mechanism.coordinates if not c.is_rotation}
    if mechanism.platform_link is not None:
        pose = {
            n: Coordinate(n, "length" if n in ("x", "y", "z") else "angle", "condition")
            for n in POSE_CONDITIONS
        }
        found = pose | found
    return found


def _coordinates_named(mechanism: Mechanism, values: Iterable[str]) -> dict[str, Coordinate]:
    """What can be given; a whole "pose" can be too. Raises InputError for a name that nothing
    has.
    """
    coordinates = given_coordinates(mechanism)
    for name in values:
        is_pose = name == "pose" and mechanism.platform_link is not None
        if name not in coordinates and not is_pose:
            raise InputError(unknown_name(mechanism, name, list(coordinates)))
    return coordinates


def unknown_name(mechanism: Mechanism, name: str, known: list[str], what: str = "given") -> str:
    """A sentence about a name that no coordinate has, with the nearest ones, or how those of a
    named point are given.
    """
    points = {p.name: p for p in mechanism.link_points}
    point = points.get(str(name).rpartition(".")[0])
    of_point = (
        ""
        if point is None
        else (
            f"; {point.name} is a point of {point.link}: with [platform] link = {point.link!r} and "
            f"position = {list(point.point)} its coordinates are x, y, z"
        )
    )
    return (
        f"{what}: {mechanism.name} has no coordinate {shown(name)}"
        f"{of_point or meant(name, known)}; allowed: {', '.join(known)}"
    )


def checked_names(
    mechanism: Mechanism, names: Iterable[str], what: str, known: Iterable[str]
) -> tuple[str, ...]:
    """Names of some `known` coordinates. Raises InputError for what is no list of names, names that
    no coordinate has, and those that stand there twice.
    """
    listed = () if isinstance(names, str) else tuple(names)
    if not listed:
        raise InputError(
            f"{what} = {names!r}; a list of names of coordinates is needed, as in {what}=['crank']"
        )
    allowed = list(known)
    for name in listed:
        if name not in allowed:
            raise InputError(unknown_name(mechanism, name, allowed, what))
        if listed.count(name) > 1:
            raise InputError(
                f"{what} = {', '.join(listed)}: {name} stands there twice; each name once"
            )
    return listed


def in_order(mechanism: Mechanism, given: Given) -> Given:
    """The same values, those of all actuated joints of limbs in file order."""
    names = actuated_names(mechanism)
    if given.names == names or not are_joints_of_limbs(mechanism, given.names):
        return given
    return replace(given, names=names, values=given.values[[given.names.index(n) for n in names]])


# --- many inputs ----------------------------------------------------------------------------------


def is_many(joints: Any, pose: Any, given: Any) -> bool:
    """Whether values are those of several inputs: an array (n, numbers), a sequence of sequences,
    mappings or poses, or a mapping of names to columns; by name, some are a column, of whole poses
    several rows.
    """
    if given is not None:
        return isinstance(given, Mapping) and any(map(_is_column, given, given.values()))
    return _are_many(joints) or _are_many(pose)


def _are_many(values: Any) -> bool:
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


def read_many(mechanism: Mechanism, joints: Any, pose: Any, given: Columns | None) -> list[Given]:
    """As `read_given`, for n inputs: all joints (n, joints), all poses (n, 7), or by name a column
    or one value each; a message names the input that does not fit, counted from 0.
    """
    require_mechanism(mechanism)
    if given is not None:
        _coordinates_named(mechanism, given)
        return [read_given(mechanism, joints, pose, row) for row in rows_by_name(given)]
    if pose is not None and (joints is not None or mechanism.platform_link is None):
        return [read_given(mechanism, joints, pose)]
    if pose is not None:
        rows = _poses_without_fault(pose)
        if rows is None:
            read = [_named_input(i, partial(pose_from, one)) for i, one in enumerate(pose)]
            rows = np.array([[*one.position, *one.quaternion] for one in read]).reshape(-1, 7)
        return given_poses(mechanism, rows)
    joints = joint_rows(mechanism, joints) if isinstance(joints, Mapping) else joints
    least, most, unit = _ranges(mechanism)
    rows = _plain_rows(joints, least, most)
    if rows is None:
        return [
            _named_input(i, partial(given_joints, mechanism, one)) for i, one in enumerate(joints)
        ]
    names, values = actuated_names(mechanism), rows * unit
    return [
        Given(names, v, {"joints": echo}) for v, echo in zip(values, rows.tolist(), strict=True)
    ]


def _named_input(number: int, read: Callable[[], _Read]) -> _Read:
    try:
        return read()
    except InputError as error:
        raise InputError(f"input {number}: {error}") from None


def _poses_without_fault(poses: Any) -> np.ndarray | None:
    """Poses (n, 7), quaternions of unit length, that are plain numbers; else None."""
    most = np.full(7, LARGEST_GIVEN)
    rows = _plain_rows(poses, -most, most)
    if rows is None:
        return None
    norms = np.sqrt(squared_norms(rows[:, 3:]))
    rows[:, 3:] /= norms[:, None]
    return rows if (np.abs(norms - 1.0) <= NORM_OFF).all() else None


def _plain_rows(values: Any, least: np.ndarray, most: np.ndarray) -> np.ndarray | None:
    """Rows of plain numbers, none below `least` (k,) nor of magnitude above `most` (k,), so that
    they need no look one by one; else None.
    """
    try:
        values = np.array(values)
    except ValueError:
        return None
    if values.dtype.kind not in "fiu" or values.ndim != 2 or values.shape[1] != len(most):
        return None
    return values.astype(float) if ((values >= least) & (np.abs(values) <= most)).all() else None


def _is_column(name: str, value: Any) -> bool:
    """Whether a value is one of each input: of whole poses several rows or poses."""
    several = not isinstance(value, Pose | str) and np.ndim(value) > 0
    if name != "pose" or not several:
        return several
    return np.ndim(value) > 1 or any(isinstance(one, Pose) or np.ndim(one) > 0 for one in value)


def rows_by_name(given: Mapping[str, Any], each: str = "an input") -> list[dict[str, Any]]:
    """Values by name of `each` input or sample; one value is that of all. Raises InputError for
    columns of different lengths.
    """
    lengths = {name: len(value) for name, value in given.items() if _is_column(name, value)}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise InputError(
            f"given: the columns have different counts of values ({told}); each needs one {each}"
        )
    columns = {
        name: list(value) if name in lengths else [value] * max(lengths.values())
        for name, value in given.items()
    }
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


# --- values ---------------------------------------------------------------------------------------


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


def in_file_order(
    mechanism: Mechanism, joints: Mapping[str, Any], what: str = "joints"
) -> list[Any]:
    """What is told by name of all actuated joints, in file order. Raises InputError for a name that
    is no actuated joint, and for one that is missing.
    """
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
            if isinstance(row, Mapping)
            else row
            for k, row in enumerate(joints, start=1)
        ]
    columns = in_file_order(mechanism, joints)
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


def _judged_joints(mechanism: Mechanism, values: Joints, what: str) -> list[float]:
    """Joint values that need a look one by one."""
    coordinates = mechanism.actuated
    numbers = _numbers(values, what)  # type: ignore[arg-type]
    if len(numbers) != len(coordinates):
        names = ", ".join(c.name for c in coordinates) or "none"
        raise InputError(
            f"{what}: {counted(len(numbers))} given, {mechanism.name} has {len(coordinates)} "
            f"actuated joints ({names})"
        )
    for coordinate, number in zip(coordinates, numbers, strict=True):
        refuse_negative_rod(mechanism, coordinate, number, what)
    turn = mechanism.angle_out(2 * math.pi)
    return [
        math.remainder(n, turn) if c.is_periodic and abs(n) > turn else n
        for c, n in zip(coordinates, numbers, strict=True)
    ]


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
    if abs(norm - 1.0) > NORM_OFF:
        raise InputError(
            f"{what}: the quaternion {numbers[3:]} has norm {norm:.6g}; allowed: 1 to within 0.01"
        )
    return Pose(np.array(numbers[:3]), np.array(numbers[3:]) / norm)


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
