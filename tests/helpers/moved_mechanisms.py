"""The same machine in another length unit, at another place of its base frame, or with its parts in
another order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import symkin
from helpers.inside import build_problem, make_solution
from symkin import Coupling, Joint, Limb, LinkJoint, LinkRod, Mechanism, RodLimb, Solution


def reference_solution(mechanism: Mechanism) -> Solution:
    problem = build_problem(mechanism, "direct")
    return make_solution(problem, problem.closure.reference)


def scaled(mechanism: Mechanism, factor: float) -> Mechanism:
    """The same machine with every length times `factor`."""

    def times(numbers: object) -> tuple[float, ...] | None:
        return None if numbers is None else tuple(factor * np.array(numbers))

    def joint(j: Joint) -> Joint:
        zero, limits = (j.zero * factor, times(j.limits)) if j.type == "P" else (j.zero, j.limits)
        return replace(j, point=times(j.point), zero=zero, limits=limits, pitch=factor * j.pitch)

    def limb(item: Limb | RodLimb) -> Limb | RodLimb:
        if isinstance(item, RodLimb):
            moved = {
                "base": times(item.base),
                "platform": times(item.platform),
                "limits": times(item.limits),
            }
            return replace(item, offset=factor * item.offset, **moved)
        rods = [
            replace(
                r,
                start=times(r.start),
                platform=times(r.platform),
                length=None if r.length is None else factor * r.length,
            )
            for r in item.rods
        ]
        return Limb(item.name, [joint(j) for j in item.joints], rods)

    def rod(item: LinkRod) -> LinkRod:
        length = None if item.length is None else factor * item.length
        moved = {"start": times(item.start), "end": times(item.end), "limits": times(item.limits)}
        return replace(item, offset=factor * item.offset, length=length, **moved)

    powers = {c.name: int(c.kind == "length") for c in mechanism.coordinates}

    def coupling(item: Coupling) -> Coupling:
        own = powers[item.joint]
        if item.polynomial is not None:
            other = powers[str(item.of)]
            return replace(
                item,
                polynomial=[c * factor ** (own - k * other) for k, c in enumerate(item.polynomial)],
            )
        of = {name: f * factor ** (own - powers[name]) for name, f in item.terms}
        return replace(item, of=of, offset=item.offset * factor**own)

    return replace(
        mechanism,
        limbs=tuple(limb(item) for item in mechanism.limbs),
        link_joints=[LinkJoint(joint(item.joint), item.links) for item in mechanism.link_joints],
        link_rods=[rod(item) for item in mechanism.link_rods],
        couplings=[coupling(item) for item in mechanism.couplings],
        link_points=[replace(item, point=times(item.point)) for item in mechanism.link_points],
        platform_position=times(mechanism.platform_position),
        length_unit="m",
        dh=None,
        example=None,
    )


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
