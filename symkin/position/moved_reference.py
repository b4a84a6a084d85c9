"""The same mechanism described at another of its configurations: points, axes and zeros are those
there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.link_poses import joint_readings, link_poses
from symkin.formats.graph_form import links_along
from symkin.model.graph import Coupling, LinkJoint, LinkRod
from symkin.model.joint import FREEDOMS, Joint
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose


def with_reference_at(closure: Closure, values: np.ndarray) -> Mechanism:
    """The closure's mechanism with the configuration of a full vector of variables as its
    reference.

    Values of R, P and H joints and of rods stay what they are. Coordinates of C, U and S joints
    count from the reference, and couplings that name them are written for the new one; an example
    that gives them, a DH table and meshes are left out.
    """
    poses = link_poses(closure, values[None])
    read = {
        name: float(np.ravel(value)[0]) for name, value in joint_readings(closure, poses).items()
    }
    held = {c.name for c in closure.coordinates}
    read |= {name: float(values[closure.slices[name]][0]) for name in read if name in held}
    return _Moved(closure.mechanism, poses.at(0), read).mechanism()


class _Moved:
    """A mechanism, how far its links are displaced, and the values of its joints there."""

    def __init__(
        self, mechanism: Mechanism, links: Mapping[str, Pose], values: Mapping[str, float]
    ) -> None:
        self.given, self.links, self.values = mechanism, links, values
        several = [c for j in mechanism.all_joints if j.type in ("C", "U") for c in j.coordinates]
        self.shifts = {c.name: values[c.name] for c in several}

    def mechanism(self) -> Mechanism:
        given, link = self.given, self.given.platform_link
        pose = given.reference_pose if link is None else self.links[link] @ given.reference_pose
        example = given.example
        named = (
            {c.name for c in given.actuated}
            | {name for name, _ in (example.given or ()) if example}
            if example
            else set()
        )
        return replace(
            given,
            limbs=[self._limb(limb) for limb in given.limbs],
            platform_position=tuple(pose.position),
            platform_quaternion=tuple(pose.quaternion),
            link_joints=[
                LinkJoint(self._joint(e.joint, e.links[0], e.links[1]), e.links)
                for e in given.link_joints
            ],
            link_rods=[self._rod(rod) for rod in given.link_rods],
            couplings=[self._coupling(coupling) for coupling in given.couplings],
            link_points=[replace(p, point=self._point(p.link, p.point)) for p in given.link_points],
            example=None if named & set(self.shifts) else example,
            dh=None,
            link_meshes=(),
        )

    def _point(self, link: str, point: object) -> tuple[float, ...]:
        return tuple(float(v) for v in self.links[link].apply(np.array(point, dtype=float)))

    def _joint(self, joint: Joint, carrier: str, link: str) -> Joint:
        turned = {
            key: tuple(float(v) for v in self.links[by].turn(np.array(axis)))
            for key, axis, by in (("axis", joint.axis, carrier), ("axis2", joint.axis2, link))
            if axis is not None
        }
        zero = self.values[joint.coordinates[0].name] if FREEDOMS[joint.type] == 1 else 0.0
        return replace(joint, point=self._point(carrier, joint.point), zero=zero, **turned)  # type: ignore[arg-type]

    def _limb(self, limb: Limb | RodLimb) -> Limb | RodLimb:
        if isinstance(limb, RodLimb):
            return replace(limb, base=self._point(limb.links[0], limb.base))
        links = links_along(limb)
        joints = [self._joint(joint, links[k], links[k + 1]) for k, joint in enumerate(limb.joints)]
        rods = [replace(rod, start=self._point(links[-1], rod.start)) for rod in limb.rods]
        return replace(limb, joints=joints, rods=rods)

    def _rod(self, rod: LinkRod) -> LinkRod:
        start, end = (
            self._point(link, point)
            for link, point in zip(rod.links, (rod.start, rod.end), strict=True)
        )
        return replace(rod, start=start, end=end)

    def _coupling(self, coupling: Coupling) -> Coupling:
        """y + y0 = b + sum f (x + x0), of coordinates that count from the reference."""
        own = self.shifts.get(coupling.joint, 0.0)
        away = {name: self.shifts.get(name, 0.0) for name in coupling.names}
        if not own and not any(away.values()):
            return coupling
        if coupling.polynomial is None:
            offset = (
                coupling.offset - own + sum(factor * away[name] for name, factor in coupling.terms)
            )
            return replace(coupling, offset=offset)
        (shift,) = away.values()
        moved = (
            np.polynomial.Polynomial(coupling.polynomial)(np.polynomial.Polynomial([shift, 1.0]))
            - own
        )
        powers = [float(c) for c in moved.coef]
        return replace(
            coupling, polynomial=[*powers, *[0.0] * (len(coupling.polynomial) - len(powers))]
        )
