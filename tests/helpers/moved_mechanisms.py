"""The same machine in another length unit, at another place of its base frame, or with its parts in
another order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import symkin
from helpers.inside import build_problem, make_solution
from symkin import Joint, Limb, LinkJoint, Mechanism, RodLimb, Solution


def reference_solution(mechanism: Mechanism) -> Solution:
    problem = build_problem(mechanism, "direct")
    return make_solution(problem, problem.closure.reference)


def displaced(mechanism: Mechanism, by: symkin.Pose) -> Mechanism:
    """The same machine placed elsewhere in the base frame."""

    def turn(v: object) -> tuple[float, ...] | None:
        return None if v is None else tuple(by.turn(np.array(v)))

    def at(point: object) -> tuple[float, ...]:
        return tuple(by.apply(np.array(point)))

    def joint(j: Joint) -> Joint:
        return replace(j, point=at(j.point), axis=turn(j.axis), axis2=turn(j.axis2))

    def limb(item: Limb | RodLimb) -> Limb | RodLimb:
        if isinstance(item, RodLimb):
            return replace(item, base=at(item.base))
        rods = [replace(r, start=at(r.start)) for r in item.rods]
        return Limb(item.name, [joint(j) for j in item.joints], rods)

    home = by @ mechanism.reference_pose
    # without a platform there is no frame to move
    frame = (
        {}
        if mechanism.platform_link is None
        else {
            "platform_position": tuple(home.position),
            "platform_quaternion": tuple(home.quaternion),
        }
    )
    return replace(
        mechanism,
        limbs=tuple(limb(item) for item in mechanism.limbs),
        link_joints=[LinkJoint(joint(item.joint), item.links) for item in mechanism.link_joints],
        link_rods=[
            replace(item, start=at(item.start), end=at(item.end)) for item in mechanism.link_rods
        ],
        link_points=[replace(item, point=at(item.point)) for item in mechanism.link_points],
        **frame,
        dh=None,
        example=None,
    )


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


def scaled_values(
    mechanism: Mechanism, values: Mapping[str, float], factor: float
) -> dict[str, float]:
    """Values of coordinates, by name, of the machine whose lengths are times `factor`."""
    kinds = {c.name: c.kind for c in mechanism.coordinates}
    return {
        name: value * (factor if kinds[name] == "length" else 1.0) for name, value in values.items()
    }
