"""Any mechanism as a graph of links in metres and radians, as files of other formats hold it: limbs
become joints and rods between links.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

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
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0), "gamma": (0.0, 0.0, 1.0)}


def as_graph(mechanism: Mechanism) -> Mechanism:
    """The same mechanism with joints and rods between named links alone.

    Links within a limb are called leg1.1, leg1.2, ... from its first link on. A platform of
    restricted motion is carried from the base by passive joints (platform.x, platform.gamma, ...)
    that leave it this motion.
    """
    carriers = list(_carriers(mechanism))
    joints = [entry for limb in mechanism.limbs for entry in _chain(limb)]
    graph = Mechanism(
        mechanism.name,
        link_joints=[*joints, *carriers, *mechanism.link_joints],
        link_rods=[
            *(rod for limb in mechanism.limbs for rod in _rods(mechanism, limb)),
            *mechanism.link_rods,
        ],
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


def _chain(limb: AnyLimb) -> Iterator[LinkJoint]:
    """The joints of a limb, each between two of its links."""
    for joint, links in zip(limb.joints, pairwise(limb.links_along), strict=True):
        yield LinkJoint(joint, links)


def _rods(mechanism: Mechanism, limb: AnyLimb) -> Iterator[LinkRod]:
    """The rods at the end of a limb, between its last link and the platform."""
    start = limb.links_along[-1]
    for bar in limb.bars(mechanism.reference_pose):
        driven = bar.coordinate is not None
        yield LinkRod(
            bar.path,
            (start, limb.links[1]),
            bar.start.point,
            bar.places[1].tolist(),
            length=bar.length,
            actuated=driven,
            offset=bar.offset,
            limits=bar.coordinate.limits if bar.coordinate is not None else None,
        )


def _carriers(mechanism: Mechanism) -> Iterator[LinkJoint]:
    """Passive joints that leave the platform its motion, with the values of its pose."""
    taken = {c.name for c in mechanism.coordinates}
    position, link = tuple(mechanism.platform_position), BASE
    names = _MOTIONS[mechanism.motion]
    for k, key in enumerate(names, start=1):
        name = f"{PLATFORM}.{key}"
        while name in taken:
            name += "_"
        to = mechanism.platform_link or PLATFORM if k == len(names) else f"{name}.link"
        if key == "turn":
            joint = Joint(name, "S", position)
        elif key == "gamma":
            joint = Joint(name, "R", position, _AXES[key])
        else:
            joint = Joint(name, "P", position, _AXES[key], zero=position["xyz".index(key)])
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
