"""Find the motion that joints leave a platform in all configurations: in a plane, which is turned
into that of x and y, or about a point.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import casadi as ca
import numpy as np

from symkin.closure.branches import chains_of, edges_of
from symkin.closure.link_poses import joint_coordinates
from symkin.computed_once import cached_property
from symkin.model.changed import displaced
from symkin.model.graph import LinkJoint
from symkin.model.joint import BASE, Joint
from symkin.model.limb import AnyLimb, RodLimb
from symkin.model.mechanism import Mechanism, Motion
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, rotate

_ALIGNED = 1e-12
"""Sine of the angle off parallel and off normal of axes that are it, and distance, over the size,
of an axis from a point of it: rounding.
"""
_SPREAD = 1e-3
"""Smallest singular value of unit directions of slides that go everywhere, and length, over the
size, of a way in a plane that tells a direction there.
"""
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
_ABOUT_Z = ("planar", "schoenflies")
"""Motions whose z is that of the base frame."""
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
        return self._base_inverse @ pose @ self.platform

    def taken(self, pose: Pose) -> Pose:
        """A pose of the description as the machine has it."""
        return self.base @ pose @ self._platform_inverse

    @cached_property
    def _base_inverse(self) -> Pose:
        return self.base.inverse()

    @cached_property
    def _platform_inverse(self) -> Pose:
        return self.platform.inverse()


def with_own_motion(mechanism: Mechanism, *, declare: bool) -> tuple[Mechanism, Frames | None]:
    """The machine with z normal to the plane in which its joints leave the platform to move, or all
    links, and with a platform frame that is along that of the base at the reference; None in place
    of the frames where they are those of the description. With `declare` the platform's motion is
    declared.
    """
    if mechanism.motion != "spatial" or mechanism.serial:
        return mechanism, None
    chains = list(_chains_to_platform(mechanism))
    of_platform = _first(_normal, chains)
    normal = _normal(_all_joints(mechanism)) if of_platform is None else of_platform
    if normal is None:
        about = declare and any(_is_about(mechanism, chain) for chain in chains)
        return replace(mechanism, motion="spherical") if about else mechanism, None
    turn = _turn_to_z(mechanism, normal)
    placed, frames = (mechanism, None) if turn is None else _placed(mechanism, turn)
    known = declare and of_platform is not None
    return replace(placed, motion="planar") if known else placed, frames


def with_own_frame(mechanism: Mechanism) -> tuple[Mechanism, Frames | None]:
    """The machine in the frame in which its numbers are simplest, its platform frame along that of
    the base at the reference; None in place of the frames where it stands so. Numbers that are zero
    to rounding are zero.
    """
    if mechanism.serial or not any(limb.joints for limb in mechanism.limbs):
        return mechanism, None
    turn = _turn_to_axes(mechanism)
    return (_aligned(mechanism, turned=False), None) if turn is None else _placed(mechanism, turn)


@dataclass(frozen=True)
class Guide:
    """A limb of passive joints that leaves the platform all of its motion and nothing else."""

    joints: tuple[Joint, ...]

    def readings(self, moved: Pose) -> dict[str, ca.SX]:
        """Values of the joints where the platform has `moved` from the reference."""
        turning = [joint for joint in self.joints if joint.type != "P"]
        slides = [joint for joint in self.joints if joint.type == "P"]
        centre = ca.DM(turning[0].point if turning else [0.0, 0.0, 0.0])
        way = moved.apply(centre) - centre
        if self.joints[0].type == "R":
            # slides that the joint has turned
            way = rotate(conjugate(moved.quaternion), way)
        found = {joint.name: ca.vertcat(*joint_coordinates(joint, moved)) for joint in turning}
        if slides:
            steps = ca.mtimes(ca.DM(np.linalg.pinv(np.array([j.axis for j in slides]).T)), way)
            found |= {j.name: j.zero + steps[k] for k, j in enumerate(slides)}
        return found


def without_guides(mechanism: Mechanism) -> tuple[Mechanism, tuple[Guide, ...]]:
    """The machine without its guides, in place of which the motion is declared, and these; itself
    where nothing else carries it.
    """
    guides = {limb.name: _guided(mechanism, limb) for limb in mechanism.limbs}
    motion = mechanism.motion
    if motion == "spatial":
        motion = next((m for m in guides.values() if m == "translation"), motion)
    left = [limb for limb in mechanism.limbs if guides[limb.name] != motion or motion == "spatial"]
    if not left or len(left) == len(mechanism.limbs):
        return mechanism, ()
    gone = tuple(Guide(tuple(limb.joints)) for limb in mechanism.limbs if limb not in left)
    return replace(mechanism, limbs=left, motion=motion), gone


def _guided(mechanism: Mechanism, limb: AnyLimb) -> Motion:
    """The motion whose every pose a limb lets the platform take, and no other pose; "spatial" where
    it is no such limb.
    """
    joints = limb.joints
    if isinstance(limb, RodLimb) or limb.rods or any(not _is_idle(joint) for joint in joints):
        return "spatial"
    types = "".join(joint.type for joint in joints)
    slides = np.array([joint.axis for joint in joints if joint.type == "P"]).reshape(-1, 3)
    spread = np.linalg.svd(slides, compute_uv=False)
    free = len(slides) and len(slides) <= 3 and spread[-1] > _SPREAD
    if types in ("PPR", "RPP") and free and _is_along_z(_normal(joints)):
        return "planar"
    if types == "PPP" and free:
        return "translation"
    if types == "S" and _is_about(mechanism, joints):
        return "spherical"
    return "spatial"


def _is_idle(joint: Joint) -> bool:
    """Whether a joint is neither driven nor stopped."""
    return not joint.actuated and joint.limits is None


def _is_along_z(axis: np.ndarray | None) -> bool:
    return axis is not None and float(np.linalg.norm(np.cross(axis, _Z))) <= _ALIGNED


def _chains_to_platform(mechanism: Mechanism) -> Iterator[list[Joint] | None]:
    """The joints of each chain from the base to the platform; None of one with a rod."""
    platform = mechanism.platform_link
    if platform is None:
        return
    for chain in chains_of(list(edges_of(mechanism)), {platform}):
        if set(chain.ends) == {BASE, platform}:
            parts = [element.part for element in chain.elements]
            yield parts if all(isinstance(part, Joint) for part in parts) else None  # type: ignore[misc]


def _all_joints(mechanism: Mechanism) -> list[Joint] | None:
    """The joints of a machine without rods."""
    rods = any(isinstance(limb, RodLimb) or limb.rods for limb in mechanism.limbs)
    return None if rods or mechanism.link_rods else list(mechanism.all_joints)


def _normal(joints: Sequence[Joint] | None) -> np.ndarray | None:
    """The axis to which revolute joints are parallel, and slides normal; None where there is none,
    and without a revolute joint.
    """
    parts = [joint for joint in joints or () if joint.type != "weld"]
    axes = [np.array(joint.axis) for joint in parts if joint.type == "R"]
    slides = [np.array(joint.axis) for joint in parts if joint.type == "P"]
    if not axes or len(axes) + len(slides) < len(parts):
        return None
    normal = axes[0]
    fits = all(np.linalg.norm(np.cross(axis, normal)) <= _ALIGNED for axis in axes)
    return normal if fits and all(abs(slide @ normal) <= _ALIGNED for slide in slides) else None


def _first(
    found: Callable[[Sequence[Joint] | None], np.ndarray | None],
    chains: Iterable[Sequence[Joint] | None],
) -> np.ndarray | None:
    return next((axis for axis in map(found, chains) if axis is not None), None)


def _is_about(mechanism: Mechanism, joints: Sequence[Joint] | None) -> bool:
    """Whether revolute joints and balls alone, all at the origin of the platform's frame, carry
    it.
    """
    parts = [joint for joint in joints or () if joint.type != "weld"]
    centre = np.array(mechanism.platform_position)
    near = _ALIGNED * mechanism.characteristic_length
    return bool(parts) and all(_passes(joint, centre, near) for joint in parts)


def _passes(joint: Joint, centre: np.ndarray, near: float) -> bool:
    """Whether a joint turns about a point alone."""
    away = np.subtract(joint.point, centre)
    if joint.type in ("S", "U"):
        return float(np.linalg.norm(away)) <= near
    return joint.type == "R" and float(np.linalg.norm(np.cross(joint.axis, away))) <= near  # type: ignore[arg-type]


def _turn_to_z(mechanism: Mechanism, normal: np.ndarray) -> Pose | None:
    """The turn that makes an axis that of z, by which most coordinates are zero; None where it is z
    already.
    """
    if _is_along_z(normal):
        return None
    told, first = _vectors(mechanism)
    frames = _frames(first, [normal])
    return Pose.from_matrix(frames[_most(_zeros([told, first], frames))], np.zeros(3))


def _turn_to_axes(mechanism: Mechanism) -> Pose | None:
    """The turn by which most coordinates of joints are zero, those on the base first: about z where
    the motion is one about z.
    """
    told, first = _vectors(mechanism)
    turn = simplest_turn(told, first, in_plane=mechanism.motion in _ABOUT_Z)
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
    return np.asarray(frames[best]) if is_simpler else None


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
    is_along = np.hypot(x, y) <= _ALIGNED
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
    return np.asarray(most + np.sum(np.abs(z) <= _ALIGNED, axis=0) + 2 * np.sum(is_along, axis=0))


def _frames(vectors: np.ndarray, normals: Iterable[np.ndarray]) -> np.ndarray:
    """Frames (n, 3, 3) whose z is one of the normals, and x the direction of one of the vectors, or
    of one of the axes where all vectors are along z.
    """
    ways = _distinct([*vectors, *np.eye(3)])
    found = list[np.ndarray]()
    for up in normals:
        in_plane = ways - np.outer(ways @ up, up)
        lengths = np.linalg.norm(in_plane, axis=1)
        xs = in_plane[lengths > _SPREAD] / lengths[lengths > _SPREAD, None]
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
    far = np.linalg.norm(told, axis=1) > _ALIGNED
    return told[far], told[far & [on_base for _, on_base in found]]


def _axes(joint: Joint) -> list[np.ndarray]:
    return [np.array(axis) for axis in (joint.axis, joint.axis2) if axis is not None]


def _distinct(vectors: Iterable[np.ndarray]) -> np.ndarray:
    """Vectors of another direction than those before them."""
    found = np.zeros((0, 3))
    for vector in vectors:
        length = float(np.linalg.norm(vector))
        if length > _SPREAD and not np.any(np.abs(found @ vector) > (1.0 - _ALIGNED) * length):
            found = np.vstack([found, vector / length])
    return found


def _zeros(parts: Sequence[np.ndarray], frames: np.ndarray) -> list[np.ndarray]:
    """How many coordinates of vectors are zero in each frame (n, 3, 3), of each part."""
    turned = [np.abs(vectors @ frames.transpose(0, 2, 1)) for vectors in parts]
    return [np.count_nonzero(found <= _ALIGNED, axis=(1, 2)) for found in turned]


def _most(counts: Sequence[np.ndarray]) -> int:
    """The first place of the largest counts, the last ones before the others."""
    return int(np.lexsort((-np.arange(len(counts[0])), *counts))[-1])


def _placed(mechanism: Mechanism, turn: Pose) -> tuple[Mechanism, Frames]:
    """The machine turned, its platform frame along that of the base."""
    turned = displaced(mechanism, turn)
    if mechanism.platform_link is None and not mechanism.limbs:
        return _aligned(turned, turned=True), Frames(turn, Pose(np.zeros(3), np.array(_AS_BASE)))
    own = Pose(np.zeros(3), turned.reference_pose.quaternion)
    limbs = [_with_rods(limb, own) for limb in turned.limbs]
    return (
        _aligned(replace(turned, limbs=limbs, platform_quaternion=_AS_BASE), turned=True),
        Frames(turn, own),
    )


def _with_rods(limb: AnyLimb, own: Pose) -> AnyLimb:
    """The limb with the ends of its rods in a platform frame of which the former is `own`."""
    if isinstance(limb, RodLimb):
        return replace(limb, platform=own.apply(np.array(limb.platform)).tolist())
    rods = [replace(rod, platform=own.apply(np.array(rod.platform)).tolist()) for rod in limb.rods]
    return replace(limb, rods=rods)


def _aligned(mechanism: Mechanism, *, turned: bool) -> Mechanism:
    """The machine with numbers that are zero to rounding so to the last digit; of one that was
    `turned`, those that are equal to rounding are one.
    """
    clean = _Clean(mechanism.characteristic_length, [] if turned else None)
    entries = [LinkJoint(clean.joint(entry.joint), entry.links) for entry in mechanism.link_joints]
    return replace(
        mechanism,
        limbs=[clean.limb(limb) for limb in mechanism.limbs],
        link_joints=entries,
        platform_position=clean.point(mechanism.platform_position),
    )


@dataclass(frozen=True)
class _Clean:
    """Takes the rounding out of the numbers of a machine of a size: they are 0, of directions also
    1, and those `seen` before, unless that is None.
    """

    size: float
    seen: list[float] | None

    def point(self, numbers: Sequence[float]) -> list[float]:
        return [self._number(c, (0.0,), self.size) for c in numbers]

    def axis(self, numbers: Sequence[float] | None) -> list[float] | None:
        return None if numbers is None else [self._number(c, (0.0, 1.0), 1.0) for c in numbers]

    def joint(self, joint: Joint) -> Joint:
        axis, axis2 = self.axis(joint.axis), self.axis(joint.axis2)
        return replace(joint, point=self.point(joint.point), axis=axis, axis2=axis2)

    def limb(self, limb: AnyLimb) -> AnyLimb:
        if isinstance(limb, RodLimb):
            return replace(limb, base=self.point(limb.base), platform=self.point(limb.platform))
        rods = [
            replace(rod, start=self.point(rod.start), platform=self.point(rod.platform))
            for rod in limb.rods
        ]
        return replace(limb, joints=[self.joint(joint) for joint in limb.joints], rods=rods)

    def _number(self, number: float, whole: Sequence[float], size: float) -> float:
        length = abs(number)
        near = [one for one in whole if abs(length - one) <= _ALIGNED * size]
        near += [one for one in self.seen or () if abs(length - one) <= _ROUNDING * size]
        if near:
            return math.copysign(near[0], number) if near[0] else 0.0
        if self.seen is not None:
            self.seen.append(length)
        return number
