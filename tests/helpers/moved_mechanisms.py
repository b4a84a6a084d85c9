"""The same machine in another length unit, at another place of its base frame, with its parts in
another order, with axes the other way, with revolutes for its universal joints, or with a named
point.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from helpers.inside import build_problem, make_solution, scaled
from symkin import Joint, LinkJoint, LinkPoint, Mechanism, RodLimb, Solution


def reference_solution(mechanism: Mechanism) -> Solution:
    problem = build_problem(mechanism, "direct")
    return make_solution(problem, problem.closure.reference)


def reordered(mechanism: Mechanism, seed: int) -> Mechanism:
    """The same machine with its limbs, joints and rods written in another order."""
    rng = np.random.default_rng(seed)

    def shuffled(items: object) -> list:
        items = list(items)  # type: ignore[call-overload]
        return [items[i] for i in rng.permutation(len(items))]

    parts = {
        name: shuffled(getattr(mechanism, name)) for name in ("limbs", "link_joints", "link_rods")
    }
    return replace(mechanism, **parts)


def with_axes_reversed(mechanism: Mechanism) -> Mechanism:
    """The same machine with every other of its passive R and P joints about the opposite axis, and
    so with the negative of their coordinates.
    """
    passive = [
        joint.name
        for joint in mechanism.all_joints
        if joint.type in ("R", "P") and not joint.actuated
    ]
    turned = set(passive[::2])

    def reversed_one(joint: Joint) -> Joint:
        if joint.name not in turned:
            return joint
        axis = tuple(-v for v in joint.axis or ())
        return replace(joint, axis=axis, zero=-joint.zero)

    limbs = [
        limb
        if isinstance(limb, RodLimb)
        else replace(limb, joints=[reversed_one(joint) for joint in limb.joints])
        for limb in mechanism.limbs
    ]
    links = [replace(item, joint=reversed_one(item.joint)) for item in mechanism.link_joints]
    return replace(mechanism, limbs=limbs, link_joints=links, example=None)


def scaled_values(
    mechanism: Mechanism, values: Mapping[str, float], factor: float
) -> dict[str, float]:
    """Values of coordinates, by name, of the machine whose lengths are times `factor`."""
    kinds = {c.name: c.kind for c in mechanism.coordinates}
    return {
        name: value * (factor if kinds[name] == "length" else 1.0) for name, value in values.items()
    }


def in_length_unit(mechanism: Mechanism, unit: Literal["m", "mm"]) -> Mechanism:
    """The same machine described in another length unit."""
    metres = {"m": 1.0, "mm": 1e-3}
    factor = metres[mechanism.length_unit] / metres[unit]
    return replace(scaled(mechanism, factor), length_unit=unit)


def with_point(mechanism: Mechanism) -> Mechanism:
    """The same machine with a named point of its platform, which nothing depends on."""
    assert mechanism.platform_link is not None
    at = LinkPoint(mechanism.platform_link, "mark", mechanism.platform_position)
    return replace(mechanism, link_points=[*mechanism.link_points, at], example=None)


def as_revolutes(mechanism: Mechanism) -> Mechanism:
    """The same machine with two revolutes in place of each universal joint."""
    links: list[LinkJoint] = []
    for item in mechanism.link_joints:
        pair = _revolutes(item.joint)
        middle = [f"{item.joint.name}.middle"] * (len(pair) - 1)
        chain = [item.links[0], *middle, item.links[1]]
        links += [LinkJoint(joint, chain[k : k + 2]) for k, joint in enumerate(pair)]
    limbs = [
        limb
        if isinstance(limb, RodLimb)
        else replace(limb, joints=[r for joint in limb.joints for r in _revolutes(joint)])
        for limb in mechanism.limbs
    ]
    return replace(mechanism, limbs=limbs, link_joints=links, example=None)


def revolute_links(mechanism: Mechanism) -> dict[str, str]:
    """What links within limbs are called in `as_revolutes`, by their names in a mechanism."""
    found: dict[str, str] = {}
    for limb in mechanism.limbs:
        if isinstance(limb, RodLimb):
            continue
        own, split = (
            limb.links_along,
            as_revolutes(replace(mechanism, limbs=[limb])).limbs[0].links_along,
        )
        counts = [len(_revolutes(joint)) for joint in limb.joints]
        found |= {link: split[sum(counts[:k])] for k, link in enumerate(own)}
    return found


def _revolutes(joint: Joint) -> list[Joint]:
    """A joint as itself, or a universal one as two revolutes."""
    if joint.type != "U":
        return [joint]
    first = Joint(f"{joint.name}_1", "R", joint.point, joint.axis, actuated=joint.actuated)
    return [first, replace(first, name=f"{joint.name}_2", axis=joint.axis2)]
