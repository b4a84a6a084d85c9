"""Choose the frame in which a machine stands: with an axis along z, or the one in which its numbers
are simplest; in it numbers that are equal to rounding are one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from symkin.closure.branches import edges_of
from symkin.computed_once import cached_property
from symkin.model.changed import Changed, displaced
from symkin.model.joint import BASE, Joint
from symkin.model.keys import ABOUT_Z
from symkin.model.machine import Machine
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose

ALIGNED = 1e-12
"""Sine of the angle off parallel and off normal of axes that are it, and distance, over the size,
of an axis from a point of it: rounding.
"""
_TELLS = 1e-3
"""Length, over the size, of a vector that tells a direction."""
_ROUNDING = 1e-14
"""Difference, over the size, of numbers that a turn made of one."""
_SIMPLER, _FEW = 2, 1.0 / 3.0
"""Times as many zeros on the base, and share of its numbers, above which a machine is turned:
turning poses has its price.
"""
_SAME_WAY = 4e-12
"""Difference of the angles about an axis of vectors that are parallel or normal to each other:
rounding.
"""
_PAIRED, _TIED = 64, 32
"""Directions on the base of which normals of two are tried, and axes of equally many zeros that
are: of more limbs each is one of many.
"""
_Z = np.array([0.0, 0.0, 1.0])
_AS_BASE = (1.0, 0.0, 0.0, 0.0)
"""Quaternion of a frame along that of the base."""


@dataclass(frozen=True, eq=False)
class Frames:
    """The frames of a machine that stands otherwise than its description: poses are turned by
    `base` into its base frame, and `platform` is the described platform frame in its own.
    """

    base: Pose
    platform: Pose

    def told(self, pose: Pose) -> Pose:
        """A pose of the machine as the description has it."""
        return _beside(pose, self._base_inverse) @ pose @ _beside(pose, self.platform)

    def taken(self, pose: Pose) -> Pose:
        """A pose of the description as the machine has it."""
        return _beside(pose, self.base) @ pose @ _beside(pose, self._platform_inverse)

    @cached_property
    def _base_inverse(self) -> Pose:
        return self.base.inverse()

    @cached_property
    def _platform_inverse(self) -> Pose:
        return self.platform.inverse()


def _beside(pose: Pose, own: Pose) -> Pose:
    """A frame's own pose as it multiplies another one, or a stack of poses (3, n) and (4, n)."""
    if not isinstance(pose.position, np.ndarray) or pose.position.ndim < 2:
        return own
    return Pose(np.asarray(own.position)[:, None], np.asarray(own.quaternion)[:, None])


def with_z(mechanism: Mechanism, normal: np.ndarray) -> tuple[Mechanism, Frames | None]:
    """The machine with an axis along z, x and y such that most coordinates are zero, its platform
    frame along that of the base at the reference; None in place of the frames where it stands so.
    """
    if is_along_z(normal):
        return mechanism, None
    told, first = _vectors(mechanism)
    frames = _frames(first, [normal])
    best = frames[_most(_zeros([told, first], frames))]
    return _placed(mechanism, Pose.from_matrix(best, np.zeros(3)))


def with_own_frame(mechanism: Mechanism) -> tuple[Mechanism, Frames | None]:
    """The machine in the frame in which its numbers are simplest, its platform frame along that of
    the base at the reference; None in place of the frames where it stands so. Numbers that are zero
    to rounding are zero.
    """
    if mechanism.serial or not any(limb.joints for limb in mechanism.limbs):
        return mechanism, None
    turn = _turn_to_axes(mechanism)
    return (_aligned(mechanism), None) if turn is None else _placed(mechanism, turn)


def is_along_z(axis: np.ndarray | None) -> bool:
    """Whether there is an axis, and it is that of z."""
    return axis is not None and float(np.linalg.norm(np.cross(axis, _Z))) <= ALIGNED


def _turn_to_axes(mechanism: Mechanism) -> Pose | None:
    """The turn by which most coordinates of joints are zero, those on the base first: about z where
    the motion is one about z.
    """
    told, first = _vectors(mechanism)
    turn = simplest_turn(told, first, in_plane=mechanism.motion in ABOUT_Z)
    return None if turn is None else Pose.from_matrix(turn, np.zeros(3))


def simplest_turn(told: np.ndarray, first: np.ndarray, *, in_plane: bool) -> np.ndarray | None:
    """The matrix that makes most coordinates of vectors (n, 3) zero, of the first ones before those
    of the others; with `in_plane` it is about z. None where it makes less than twice as many zero
    as there are, or only a few.
    """
    axes = np.array([_Z]) if in_plane else _promising(first)
    if not len(axes):
        return None
    frames = _frames(first, axes)
    counts = _zeros([told, first], frames)
    best = _most(counts)
    [written] = _zeros([first], np.eye(3)[None])
    # about z, what is zero along it always is
    always, few = (int(counts[1].min()), 0.0) if in_plane else (0, _FEW * first.size)
    most = int(counts[1][best]) - always
    is_simpler = most > max(_SIMPLER * (int(written[0]) - always), few)
    return frames[best] if is_simpler else None


def _promising(vectors: np.ndarray) -> np.ndarray:
    """Of the directions of vectors (n, 3) and the normals of two of them those that are z in the
    frames in which most coordinates are zero; none where these are only a few.
    """
    ways = _distinct(vectors)
    axes = _distinct([*ways, *(np.cross(a, b) for a, b in combinations(ways[:_PAIRED], 2))])
    if not len(axes):
        return axes
    zeros = _zeros_about(axes, vectors)
    best = int(zeros.max())
    return axes[zeros == best][:_TIED] if best > _FEW * vectors.size else axes[:0]


def _zeros_about(axes: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """For each axis (m, 3) the most coordinates of vectors (n, 3) that are zero in a frame whose z
    it is: one of each vector in the directions of x and y, which are those of most vectors, two of
    one along z, and the third of one across.
    """
    aside = np.cross(axes, np.eye(3)[np.abs(axes).argmin(axis=1)])
    aside /= np.linalg.norm(aside, axis=1)[:, None]
    x, y, z = vectors @ aside.T, vectors @ np.cross(axes, aside).T, vectors @ axes.T
    is_along = np.hypot(x, y) <= ALIGNED
    quarter = 0.5 * math.pi
    angles = np.where(is_along, np.inf, np.arctan2(y, x) % quarter)
    angles = np.where(np.abs(angles - quarter) <= _SAME_WAY, angles - quarter, angles)
    angles.sort(axis=0)
    same = most = np.isfinite(angles[0]).astype(int)
    with np.errstate(invalid="ignore"):  # those along z stand behind the others, at infinity
        gaps = np.diff(angles, axis=0)
    for gap, angle in zip(gaps, angles[1:], strict=True):
        same = np.where(gap <= _SAME_WAY, same + 1, np.isfinite(angle))
        most = np.maximum(most, same)
    return most + np.sum(np.abs(z) <= ALIGNED, axis=0) + 2 * np.sum(is_along, axis=0)


def _frames(vectors: np.ndarray, normals: Iterable[np.ndarray]) -> np.ndarray:
    """Frames (n, 3, 3) whose z is one of the normals, and x the direction of one of the vectors, or
    of one of the axes where all vectors are along z.
    """
    ways = _distinct([*vectors, *np.eye(3)])
    found = list[np.ndarray]()
    for up in normals:
        in_plane = ways - np.outer(ways @ up, up)
        lengths = np.linalg.norm(in_plane, axis=1)
        xs = in_plane[lengths > _TELLS] / lengths[lengths > _TELLS, None]
        found += [np.array([x, np.cross(up, x), up]) for x in xs]
    return np.array(found)


def _vectors(mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray]:
    """Directions (n, 3) of joints, and places over the size: of all joints, and of those on the
    base.
    """
    edges = [(edge.ends, edge.elements[0].part) for edge in edges_of(mechanism)]
    joints = [(part, BASE in ends) for ends, part in edges if isinstance(part, Joint)]
    found = [
        (vector, on_base)
        for joint, on_base in joints
        for vector in (*_axes(joint), np.array(joint.point) / mechanism.characteristic_length)
    ]
    told = np.array([vector for vector, _ in found]).reshape(-1, 3)
    far = np.linalg.norm(told, axis=1) > ALIGNED
    return told[far], told[far & [on_base for _, on_base in found]]


def _axes(joint: Joint) -> list[np.ndarray]:
    return [np.array(axis) for axis in (joint.axis, joint.axis2) if axis is not None]


def _distinct(vectors: Iterable[np.ndarray]) -> np.ndarray:
    """Vectors of another direction than those before them."""
    found = np.zeros((0, 3))
    for vector in vectors:
        length = float(np.linalg.norm(vector))
        if length > _TELLS and not np.any(np.abs(found @ vector) > (1.0 - ALIGNED) * length):
            found = np.vstack([found, vector / length])
    return found


def _zeros(parts: Sequence[np.ndarray], frames: np.ndarray) -> list[np.ndarray]:
    """How many coordinates of vectors are zero in each frame (n, 3, 3), of each part."""
    turned = [np.abs(vectors @ frames.transpose(0, 2, 1)) for vectors in parts]
    return [np.count_nonzero(found <= ALIGNED, axis=(1, 2)) for found in turned]


def _most(counts: Sequence[np.ndarray]) -> int:
    """The first place of the largest counts, the last ones before the others."""
    return int(np.lexsort((-np.arange(len(counts[0])), *counts))[-1])


def _placed(mechanism: Mechanism, turn: Pose) -> tuple[Mechanism, Frames]:
    """The machine turned, its platform frame along that of the base."""
    if mechanism.platform_link is None and not mechanism.limbs:
        return _aligned(displaced(mechanism, turn)), Frames(
            turn, Pose(np.zeros(3), np.array(_AS_BASE))
        )
    own = Pose(np.zeros(3), (turn @ mechanism.reference_pose).quaternion)
    told_in = tuple(tuple(np.asarray(p.quaternion).tolist()) for p in (turn, own))
    turned = displaced(mechanism, turn, inner=own)
    placed = Machine.of(turned, platform_quaternion=_AS_BASE, told_in=told_in)
    return _aligned(placed), Frames(turn, own)


def _aligned(mechanism: Mechanism) -> Mechanism:
    """The machine with numbers that are zero to rounding so to the last digit, and one where they
    are equal to rounding: else what processors make of their last digits tells what formulas cost.
    """
    clean = _Clean(mechanism.characteristic_length, [])
    changed = Changed(lambda _, p: clean.point(p), lambda _, v: clean.axis(v), clean.point)
    return replace(
        changed.mechanism(mechanism),
        platform_position=clean.point(np.array(mechanism.platform_position)).tolist(),
        example=mechanism.example,
    )


@dataclass(frozen=True)
class _Clean:
    """Takes the rounding out of the numbers of a machine of a size: they are 0, of directions also
    1, and those `seen` before.
    """

    size: float
    seen: list[float]

    def point(self, numbers: np.ndarray) -> np.ndarray:
        return np.array([self._number(c, (0.0,), self.size) for c in numbers.tolist()])

    def axis(self, numbers: np.ndarray) -> np.ndarray:
        return np.array([self._number(c, (0.0, 1.0), 1.0) for c in numbers.tolist()])

    def _number(self, number: float, whole: Sequence[float], size: float) -> float:
        length = abs(number)
        near = [one for one in whole if abs(length - one) <= ALIGNED * size]
        near += [one for one in self.seen if abs(length - one) <= _ROUNDING * size]
        if near:
            return math.copysign(near[0], number) if near[0] else 0.0
        self.seen.append(length)
        return number
