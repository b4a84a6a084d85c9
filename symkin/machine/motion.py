"""Find the motion that joints leave a platform in all configurations: in a plane, which is turned
into that of x and y, or about a point.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closure.branches import chains_of, edges_of
from symkin.closure.link_poses import joint_coordinates
from symkin.machine.frame import ALIGNED, Frames, is_along_z, with_z
from symkin.model.joint import BASE, Joint
from symkin.model.limb import AnyLimb
from symkin.model.mechanism import Mechanism, Motion
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, rotate

_SPREAD = 1e-3
"""Smallest singular value of unit directions of slides that go everywhere."""


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
    placed, frames = with_z(mechanism, normal)
    known = declare and of_platform is not None
    return replace(placed, motion="planar") if known else placed, frames


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
    if not all(_is_idle(joint) for joint in joints):
        return "spatial"
    types = limb.type
    slides = np.array([joint.axis for joint in joints if joint.type == "P"]).reshape(-1, 3)
    spread = np.linalg.svd(slides, compute_uv=False)
    free = len(slides) and len(slides) <= 3 and spread[-1] > _SPREAD
    if types in ("PPR", "RPP") and free and is_along_z(_normal(joints)):
        return "planar"
    if types == "PPP" and free:
        return "translation"
    if types == "S" and _is_about(mechanism, joints):
        return "spherical"
    return "spatial"


def _is_idle(joint: Joint) -> bool:
    """Whether a joint is neither driven nor stopped."""
    return not joint.actuated and joint.limits is None


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
    return None if mechanism.bars else list(mechanism.all_joints)


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
    fits = all(np.linalg.norm(np.cross(axis, normal)) <= ALIGNED for axis in axes)
    return normal if fits and all(abs(slide @ normal) <= ALIGNED for slide in slides) else None


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
    near = ALIGNED * mechanism.characteristic_length
    return bool(parts) and all(_passes(joint, centre, near) for joint in parts)


def _passes(joint: Joint, centre: np.ndarray, near: float) -> bool:
    """Whether a joint turns about a point alone."""
    away = np.subtract(joint.point, centre)
    if joint.type in ("S", "U"):
        return float(np.linalg.norm(away)) <= near
    return joint.type == "R" and float(np.linalg.norm(np.cross(joint.axis, away))) <= near  # type: ignore[arg-type]
