"""The serial arm that a graph of links is, where its joints are one chain from the base to the
platform link.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from symkin.model.graph import LinkJoint, LinkRod
from symkin.model.joined import way
from symkin.model.joint import BASE, Joint
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism
from symkin.model.names import identifier

_ARM_JOINTS = ("R", "P", "H")
_DIGITS = 1e-10
"""Difference (rad, or of the size) of numbers that are one: robots' files write pi/2 with eleven
digits.
"""
_USUAL = (0.0, 0.5, math.sqrt(0.5), 1.0)
"""Numbers of quaternions of whole and half right angles."""
_Part: TypeAlias = LinkJoint | LinkRod | Limb | RodLimb


def arm_of(graph: Mechanism) -> Mechanism | None:
    """The graph as a serial arm: the joints in order from the base to the platform link, the tool.
    Joints that do not move the tool are left out, and the arm is then named after its tool too.
    Axes that are parallel, and coordinates of points that are equal or zero, to the digits of a
    robot's file (1e-10, of the size) are so exactly, as an arm's closed form takes them. None of
    limbs, and where a loop or a coupling moves it, one of these joints is passive, or it has
    another type than R, P and H.

    >>> import symkin
    >>> pan = symkin.Joint("pan", "R", [0, 0, 0], [0, 0, 1], actuated=True)
    >>> tilt = symkin.Joint("tilt", "R", [0, 0, 200], [1, 0, 0], actuated=True)
    >>> links = [symkin.LinkJoint(tilt, ["head", "camera"])]
    >>> links += [symkin.LinkJoint(pan, ["base", "head"])]
    >>> neck = symkin.Mechanism("neck", link_joints=links, platform_link="camera")
    >>> [joint.name for _, joint in arm_of(neck).joints]
    ['pan', 'tilt']
    """
    if graph.platform_link is None or graph.motion != "spatial":
        return None
    chain = _only_chain(graph, graph.platform_link)
    joints = [joint for joint in chain or () if joint.type != "weld"]
    coupled = {name for coupling in graph.couplings for name in (coupling.joint, *coupling.names)}
    if not joints or any(
        j.type not in _ARM_JOINTS or not j.actuated or j.name in coupled for j in joints
    ):
        return None
    joints, tool, turn = _without_noise(joints, graph)
    # a robot has several arms and legs, whose code must not have one name
    alone = (
        len(joints) == sum(entry.joint.type != "weld" for entry in graph.link_joints)
        and not graph.link_rods
        and not graph.limbs
    )
    name = graph.name if alone else identifier(f"{graph.name}_{graph.platform_link}")
    return replace(
        graph,
        name=name,
        limbs=[Limb(name, joints)],
        platform_position=tool,
        platform_quaternion=turn,
        serial=True,
        link_joints=(),
        link_rods=(),
        couplings=(),
        link_points=(),
        link_meshes=(),
        platform_link=None,
        example=None,
    )


def joints_left_out(graph: Mechanism) -> tuple[str, ...]:
    """Actuated joints of a graph that is an arm, which do not move its tool."""
    arm = arm_of(graph)
    return () if arm is None else tuple(c.name for c in graph.actuated if c not in arm.actuated)


def _only_chain(graph: Mechanism, tool: str) -> list[Joint] | None:
    """The joints from the base to a link, where nothing else leads there; each as it moves its
    outer link.
    """
    parts: list[_Part] = [*graph.link_joints, *graph.link_rods, *graph.limbs]
    chain = way(parts, BASE, tool) or []
    if any(way([part for part in parts if part is not cut], BASE, tool) for cut in chain):
        return None
    joints, link = [], BASE
    for part in chain:
        if not isinstance(part, LinkJoint):
            return None
        along = part.links[0] == link
        link = part.links[along]
        joints.append(part.joint if along else part.joint.turned())
    return joints


def _without_noise(
    joints: Sequence[Joint], graph: Mechanism
) -> tuple[list[Joint], list[float], list[float]]:
    """Joints, and the tool's position and quaternion, whose axes and points have the numbers of
    those before where they differ in the digits of a file only.
    """
    directions, seen = [np.array(row) for row in np.eye(3)], [[0.0], [0.0], [0.0]]

    def known(point: Sequence[float]) -> list[float]:
        near = _DIGITS * graph.characteristic_length
        found = [
            next((n for n in numbers if abs(n - p) <= near), p)
            for p, numbers in zip(point, seen, strict=True)
        ]
        for p, numbers in zip(found, seen, strict=True):
            numbers.append(p)
        return found

    cleaned = []
    for joint in joints:
        axis = np.array(joint.axis, dtype=float)
        axis /= np.linalg.norm(axis)
        same = next((k for k in directions if np.linalg.norm(np.cross(k, axis)) <= _DIGITS), None)
        if same is None:
            directions.append(axis)
        else:
            axis = same * np.sign(same @ axis)
        cleaned.append(replace(joint, axis=tuple(axis.tolist()), point=tuple(known(joint.point))))
    half_turns = [
        next((math.copysign(n, c) if n else 0.0 for n in _USUAL if abs(abs(c) - n) <= _DIGITS), c)
        for c in graph.platform_quaternion
    ]
    return cleaned, known(graph.platform_position), half_turns
