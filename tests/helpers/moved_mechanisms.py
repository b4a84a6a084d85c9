"""The same machine in another length unit or at another place of its base frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import symkin
from symkin import Joint, Limb, Mechanism, RodLimb
from symkin.position.problem import build_problem
from symkin.position.solution import Solution
from symkin.position.solution_list import make_solution


def reference_solution(mechanism: Mechanism) -> Solution:
    problem = build_problem(mechanism, "direct")
    return make_solution(problem, problem.closure.reference)


def scaled(mechanism: Mechanism, factor: float) -> Mechanism:
    """The same machine with every length times `factor`."""

    def joint(j: Joint) -> Joint:
        zero = j.zero * factor if j.type == "P" else j.zero
        return replace(j, point=tuple(factor * np.array(j.point)), zero=zero, pitch=factor * j.pitch)

    def limb(item: Limb | RodLimb) -> Limb | RodLimb:
        if isinstance(item, RodLimb):
            return replace(item, base=tuple(factor * np.array(item.base)), platform=tuple(factor * np.array(item.platform)))
        rods = [
            replace(r, start=tuple(factor * np.array(r.start)), platform=tuple(factor * np.array(r.platform))) for r in item.rods
        ]
        return Limb(item.name, [joint(j) for j in item.joints], rods)

    position = tuple(factor * np.array(mechanism.platform_position))
    return replace(mechanism, limbs=tuple(limb(item) for item in mechanism.limbs), platform_position=position, length_unit="m")


def displaced(mechanism: Mechanism, by: symkin.Pose) -> Mechanism:
    """The same machine placed elsewhere in the base frame."""

    def turn(v: object) -> tuple[float, ...] | None:
        return None if v is None else tuple(by.turn(np.array(v)))

    def joint(j: Joint) -> Joint:
        return replace(j, point=tuple(by.apply(np.array(j.point))), axis=turn(j.axis), axis2=turn(j.axis2))

    def limb(item: Limb | RodLimb) -> Limb | RodLimb:
        if isinstance(item, RodLimb):
            return replace(item, base=tuple(by.apply(np.array(item.base))))
        rods = [replace(r, start=tuple(by.apply(np.array(r.start)))) for r in item.rods]
        return Limb(item.name, [joint(j) for j in item.joints], rods)

    home = by @ mechanism.reference_pose
    return replace(
        mechanism, limbs=tuple(limb(item) for item in mechanism.limbs), platform_position=tuple(home.position),
        platform_quaternion=tuple(home.quaternion),
    )  # fmt: skip
