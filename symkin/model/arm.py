"""The serial arm that a graph of links is, where its joints are one chain from the base to the platform link."""

from __future__ import annotations

from dataclasses import replace

from symkin.errors import InputError
from symkin.model.graph import LinkJoint
from symkin.model.joint import BASE, Joint
from symkin.model.limb import Limb
from symkin.model.mechanism import Mechanism, require_mechanism

_ARM_JOINTS = ("R", "P", "H")


def with_limbs(mechanism: Mechanism, verb: str, instead: str) -> Mechanism:
    """The mechanism, or the arm that a graph is, for a verb that takes limbs between a base and a platform. Raises InputError for
    other graphs; `instead` says what is taken for them."""
    require_mechanism(mechanism)
    found = arm_of(mechanism) if mechanism.is_graph else mechanism
    if found is None:
        arm = "; of an arm, name the tool's link by [platform] link, of a robot's file by --platform LINK"
        raise InputError(
            f"{mechanism.name} is a graph of links and joints, and {verb} takes limbs between a base and a platform, and serial arms; "
            f"{instead}{arm if mechanism.platform_link is None else ''}"
        )
    return found


def arm_of(graph: Mechanism) -> Mechanism | None:
    """The graph as a serial arm: its joints in order from the base to the platform link, the tool. None where other joints, rods or
    limbs are there, a joint is passive, or joints are coupled.

    >>> import symkin
    >>> pan = symkin.Joint("pan", "R", [0, 0, 0], [0, 0, 1], actuated=True)
    >>> tilt = symkin.Joint("tilt", "R", [0, 0, 200], [1, 0, 0], actuated=True)
    >>> chain = [symkin.LinkJoint(tilt, ["head", "camera"]), symkin.LinkJoint(pan, ["base", "head"])]
    >>> neck = symkin.Mechanism("neck", link_joints=chain, platform_link="camera")
    >>> [joint.name for _, joint in arm_of(neck).joints]
    ['pan', 'tilt']
    """
    if graph.platform_link is None or graph.limbs or graph.link_rods or graph.couplings or graph.motion != "spatial":
        return None
    joints, link, left = [], BASE, list(graph.link_joints)
    while link != graph.platform_link:
        beside = [entry for entry in left if link in entry.links]
        if len(beside) != 1:
            return None
        left.remove(beside[0])
        link = beside[0].links[beside[0].links[0] == link]
        joints.append(_outward(beside[0], link))
    moving = [joint for joint in joints if joint.type != "weld"]
    if left or not moving or any(joint.type not in _ARM_JOINTS or not joint.actuated for joint in moving):
        return None
    return replace(
        graph,
        limbs=[Limb(graph.name, moving)],
        serial=True,
        link_joints=(),
        link_points=(),
        link_meshes=(),
        platform_link=None,
        example=None,
    )


def _outward(entry: LinkJoint, link: str) -> Joint:
    """The joint as it moves the link that is farther from the base, `link`."""
    if entry.links[1] == link or entry.joint.axis is None:
        return entry.joint
    return replace(entry.joint, axis=tuple(-c for c in entry.joint.axis))
