"""Any mechanism as a graph of links in metres and radians, as files of other formats hold it: limbs
become joints and rods between links.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from symkin.model.graph import Coupling, LinkJoint, LinkRod, coupling_scale
from symkin.model.joint import BASE, PLATFORM, Joint
from symkin.model.limb import Limb, RodLimb
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
    metres = METRES[mechanism.length_unit]
    carriers = list(_carriers(mechanism))
    joints = [entry for limb in mechanism.limbs if isinstance(limb, Limb) for entry in _chain(limb)]
    joints += [*carriers, *mechanism.link_joints]
    rods = [rod for limb in mechanism.limbs for rod in _rods(mechanism, limb)] + list(
        mechanism.link_rods
    )
    points = [replace(p, point=_scaled(p.point, metres)) for p in mechanism.link_points]
    return Mechanism(
        mechanism.name,
        link_joints=[LinkJoint(_joint(entry.joint, metres), entry.links) for entry in joints],
        link_rods=[_rod(rod, metres) for rod in rods],
        couplings=[_coupling(mechanism, c, metres) for c in mechanism.couplings],
        link_points=points,
        platform_position=_scaled(mechanism.platform_position, metres),
        platform_quaternion=mechanism.platform_quaternion,
        platform_link=mechanism.platform_link,
        length_unit="m",
        angle_unit="rad",
        title=mechanism.title,
        source=mechanism.source,
    )


def links_along(limb: Limb) -> list[str]:
    """The links of a limb in order: its first, those between its joints, and behind the last joint
    its last or the one that carries its rods.
    """
    first, last = limb.links
    inner = len(limb.joints) - (0 if limb.rods else 1)
    return [
        first,
        *(f"{limb.name}.{k}" for k in range(1, inner + 1)),
        *([] if limb.rods else [last]),
    ]


def _chain(limb: Limb) -> Iterator[LinkJoint]:
    """The joints of a limb, each between two of its links."""
    links = links_along(limb)
    for k, joint in enumerate(limb.joints):
        yield LinkJoint(joint, (links[k], links[k + 1]))


def _rods(mechanism: Mechanism, limb: Limb | RodLimb) -> Iterator[LinkRod]:
    """The rods at the end of a limb, between its last link and the platform."""
    pose = mechanism.reference_pose
    start = limb.links[0] if isinstance(limb, RodLimb) else links_along(limb)[-1]
    for bar in limb.bars(pose):
        driven = bar.coordinate is not None
        yield LinkRod(
            bar.path,
            (start, limb.links[1]),
            bar.start.point,
            bar.end.at_reference(pose).tolist(),
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


# --- in metres ------------------------------------------------------------------------------------


def _scaled(vector: Sequence[float], factor: float) -> tuple[float, ...]:
    return tuple(factor * component for component in vector)


def _joint(joint: Joint, metres: float) -> Joint:
    own = metres if joint.type == "P" else 1.0
    limits = None if joint.limits is None else _scaled(joint.limits, own)
    return replace(
        joint,
        point=_scaled(joint.point, metres),
        pitch=metres * joint.pitch,
        zero=own * joint.zero,
        limits=limits,
    )


def _rod(rod: LinkRod, metres: float) -> LinkRod:
    return replace(
        rod,
        start=_scaled(rod.start, metres),
        end=_scaled(rod.end, metres),
        length=None if rod.length is None else metres * rod.length,
        offset=metres * rod.offset,
        limits=None if rod.limits is None else _scaled(rod.limits, metres),
    )


def _coupling(mechanism: Mechanism, coupling: Coupling, metres: float) -> Coupling:
    """The coupling of coordinates in metres and radians."""
    unit = {c.name: 1.0 if c.is_angular else metres for c in mechanism.coordinates}
    own = unit[coupling.joint]
    if coupling.polynomial is not None:
        (name,) = coupling.names
        powers = [c * coupling_scale(own, unit[name], k) for k, c in enumerate(coupling.polynomial)]
        return replace(coupling, polynomial=powers)
    factors = tuple(
        (name, factor * coupling_scale(own, unit[name], 1)) for name, factor in coupling.terms
    )
    return replace(coupling, of=factors, offset=own * coupling.offset)


def is_closed_at_reference(graph: Mechanism, share: float) -> bool:
    """Whether the rods of a graph have their lengths at the reference, and its couplings hold
    there, to a share of its size.
    """
    size = graph.characteristic_length
    values = {c.name: c.reference[0] for c in graph.coordinates}
    gaps = [rod.reference_length - rod.length for rod in graph.link_rods if rod.length is not None]
    for coupling in graph.couplings:
        if coupling.polynomial is not None:
            (name,) = coupling.names
            told = math.fsum(c * values[name] ** k for k, c in enumerate(coupling.polynomial))
        else:
            told = coupling.offset + math.fsum(
                factor * values[name] for name, factor in coupling.terms
            )
        gaps.append(values[coupling.joint] - told)
    return all(abs(gap) <= share * size for gap in gaps)
