"""Any mechanism as a graph of links in metres and radians, as files of other formats hold it: limbs
become joints and rods between links.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from symkin.formats.robot import AXES, Z
from symkin.model.changed import scaled
from symkin.model.graph import LinkJoint, LinkRod
from symkin.model.joint import BASE, PLATFORM, Joint
from symkin.model.limb import AnyLimb
from symkin.model.mechanism import Mechanism

METRES = {"m": 1.0, "mm": 1e-3}
"""Metres of a length unit."""
_MOTIONS: dict[str, tuple[str, ...]] = {
    "spatial": (),
    "schoenflies": ("x", "y", "z", "gamma"),
    "planar": ("x", "y", "gamma"),
    "translation": ("x", "y", "z"),
    "spherical": ("turn",),
}
"""The joints that carry a platform of restricted motion from the base, in order."""


def as_graph(mechanism: Mechanism) -> Mechanism:
    """The same mechanism with joints and rods between named links alone.

    Links within a limb are called leg1.1, leg1.2, ... from its first link on. A platform of
    restricted motion is carried from the base by passive joints (platform.x, platform.gamma, ...)
    that leave it this motion.
    """
    joints = [
        LinkJoint(joint, links)
        for limb in mechanism.limbs
        for joint, links in zip(limb.joints, pairwise(limb.links_along), strict=True)
    ]
    rods = [rod for limb in mechanism.limbs for rod in _rods(mechanism, limb)]
    graph = Mechanism(
        mechanism.name,
        link_joints=[*joints, *_carriers(mechanism), *mechanism.link_joints],
        link_rods=[*rods, *mechanism.link_rods],
        couplings=mechanism.couplings,
        link_points=mechanism.link_points,
        platform_position=mechanism.platform_position,
        platform_quaternion=mechanism.platform_quaternion,
        platform_link=mechanism.platform_link,
        length_unit="m",
        angle_unit="rad",
        title=mechanism.title,
        source=mechanism.source,
    )
    return scaled(graph, METRES[mechanism.length_unit])


def _rods(mechanism: Mechanism, limb: AnyLimb) -> Iterator[LinkRod]:
    """The rods at the end of a limb, between its last link and the platform."""
    start = limb.links_along[-1]
    for bar in limb.bars(mechanism.reference_pose):
        yield LinkRod(
            bar.path,
            (start, limb.links[1]),
            bar.start.point,
            bar.places[1].tolist(),
            length=bar.length,
            actuated=bar.coordinate is not None,
            offset=bar.offset,
            limits=None if bar.coordinate is None else bar.coordinate.limits,
        )


def _carriers(mechanism: Mechanism) -> Iterator[LinkJoint]:
    """Passive joints that leave the platform its motion, with the values of its pose."""
    taken = {c.name for c in mechanism.coordinates}
    position, link = tuple(mechanism.platform_position), BASE
    names = _MOTIONS[mechanism.motion]
    for key in names:
        name = f"{PLATFORM}.{key}"
        while name in taken:
            name += "_"
        to = mechanism.platform_link or PLATFORM if key == names[-1] else f"{name}.link"
        if key == "turn":
            joint = Joint(name, "S", position)
        elif key == "gamma":
            joint = Joint(name, "R", position, Z)
        else:
            joint = Joint(name, "P", position, AXES[key], zero=position["xyz".index(key)])
        yield LinkJoint(joint, (link, to))
        link = to


def is_closed_at_reference(graph: Mechanism, share: float) -> bool:
    """Whether the rods of a graph have their lengths at the reference, and its couplings hold
    there, to a share of its size.
    """
    size = graph.characteristic_length
    values = {c.name: c.reference[0] for c in graph.coordinates}
    gaps = [rod.reference_length - rod.length for rod in graph.link_rods if rod.length is not None]
    gaps += [values[c.joint] - c.value(values) for c in graph.couplings]
    return all(abs(gap) <= share * size for gap in gaps)
