"""The coordinates of a platform's motion that a pose is, how far it lies off that motion, and,
where joints tie them, those that the mechanism can take.
"""

from __future__ import annotations

import numpy as np

from symkin.machine.lower import Lowered, posed
from symkin.model.keys import ABOUT_Z
from symkin.model.machine import untwisted
from symkin.model.mechanism import Mechanism
from symkin.position.feasible_pose import PROJECTED, nearest_pose
from symkin.spatial.backend import Array, atan2, vector
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, wrapped
from symkin.text import plain

ON_MOTION = 1e-6
"""A pose off a restricted motion by less than this (of the size, or rad) is projected onto it."""


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
    if mechanism.motion in ABOUT_Z:
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
    delta = multiply(quaternion, conjugate(untwisted(mechanism)))
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
        return away.max(axis=0)
    w, x, y, z = multiply(quaternion, conjugate(reference.quaternion))
    # a turn about z and one about an axis normal to it: each has a half of the quaternion
    tilt = 2.0 * size * np.arctan2(np.hypot(x, y), np.hypot(w, z))
    match mechanism.motion:
        case "planar":
            return np.maximum(tilt, away[2])
        case "translation":
            turn = np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(w))
            return 2.0 * size * turn
        case _:
            return tilt


def leaves_motion(mechanism: Mechanism, position: np.ndarray, quaternion: np.ndarray) -> bool:
    """Whether any of some poses, with positions (n, 3) and unit quaternions (n, 4), lies off the
    motion that is declared of the platform, by more than rounding: where joints carry the platform,
    they decide how it moves.
    """
    if mechanism.motion == "spatial" or not len(position):
        return False
    off = _off_motion(mechanism, position.T, quaternion.T)
    return bool(np.any(off > ON_MOTION * mechanism.characteristic_length))


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


def reader_of_poses(mechanism: Mechanism) -> Lowered:
    """The machine that reads the poses of a description which does not tell what its joints leave
    the platform, or tie of its pose: it declares no motion, or is a graph. The description where it
    does.
    """
    low = posed(mechanism)
    tells_more = mechanism.is_graph and not low.machine.is_graph
    told = tells_more or low.machine.motion != mechanism.motion
    return low if told else Lowered(mechanism, mechanism)


def projected_below(low: Lowered) -> float:
    """How far (length unit) off its motion a pose is taken for one of it: of a motion that is
    declared by rounding, of one that the joints leave the machine of `low` by few digits, as where
    joints tie poses.
    """
    is_declared = low.written.motion != "spatial"
    return (ON_MOTION if is_declared else PROJECTED) * low.machine.characteristic_length


def feasible_pose(low: Lowered, values: np.ndarray) -> tuple[np.ndarray, float, tuple[str, ...]]:
    """Pose coordinates that the joints can take, where they tie them to each other: those of a pose
    with few digits are moved to the nearest; a distance that is more than that or beyond reach, and
    what is said of it, in the words of the description of `low`.
    """
    mechanism = low.machine
    nearest = nearest_pose(mechanism, values)
    if nearest is None:
        return values, 0.0, ()
    frame = low.written.frame_name
    unit = mechanism.length_unit
    if nearest.distance <= PROJECTED * mechanism.characteristic_length and not nearest.beyond_reach:
        note = (
            f"the pose was projected onto those that the {frame} can take, by "
            f"{nearest.distance:.3g} {unit}",
        )
        return nearest.values, 0.0, note
    there = low.told(motion_pose(mechanism, nearest.values))
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


def motion_pose(mechanism: Mechanism, values: np.ndarray) -> Pose:
    """The pose whose coordinates (numbers,) are these of the mechanism's motion."""
    if mechanism.motion == "spatial":
        return Pose(values[:3], values[3:])
    position = np.array(mechanism.reference_pose.position, dtype=float)
    if mechanism.motion == "spherical":
        return Pose(position, values)
    lengths = 2 if mechanism.motion == "planar" else 3
    position[:lengths] = values[:lengths]
    half = 0.5 * sum(values[lengths:])
    turn = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
    return Pose(position, multiply(turn, untwisted(mechanism)))
