"""Each row and each check of a cut joint by itself: a displacement that breaks one condition of the
joint alone is seen, and as large as it is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from helpers.inside import build_closure
from helpers.laws import axis_turn, chain, displacement, evaluated, frame
from helpers.samples import random_coordinate, random_mechanism
from symkin import Pose


def evaluated_after(mechanism, rng, step):
    """Rows and errors, over the size, at random joint values, the platform displaced from where
    they lead by `step` (of the last joint, which is cut, where the joints before it carry it:
    point, axis, second axis)."""
    closure = build_closure(mechanism)
    *before, last = mechanism.limbs[0].joints
    named = {c.name: random_coordinate(rng, c) for j in [*before, last] for c in j.coordinates}
    carried, whole = chain(before, named), chain([*before, last], named)
    point = carried[:3, :3] @ last.point + carried[:3, 3]
    axis = carried[:3, :3] @ last.axis
    second = None if last.axis2 is None else whole[:3, :3] @ last.axis2
    reference = frame(mechanism.platform_position, mechanism.platform_quaternion)
    pose = Pose.from_matrix(step(point, axis, second) @ whole @ reference)
    named |= {f"pose.{k}": v for k, v in zip("xyz", pose.position, strict=True)} | {
        "pose.quaternion": pose.quaternion
    }
    values = np.concatenate([np.atleast_1d(named[c.name]) for c in closure.coordinates])
    return [float(np.max(np.abs(part))) for part in evaluated(closure, values)]


def across(axis, rng):
    """A random direction square to an axis."""
    v = np.cross(axis, rng.normal(size=3))
    return v / np.linalg.norm(v)


@pytest.mark.parametrize("angle", [1e-3, 1.0, math.pi])
@pytest.mark.parametrize("kinds", ["rP", "rC", "rR"])
def test_a_turn_about_the_joints_own_point_is_seen(kinds, angle):
    """The joint's point stays; all its other conditions hold but that of orientation."""
    rng = np.random.default_rng(4)

    def step(point, axis, _):
        return displacement(axis_turn(across(axis, rng), angle), point)

    for _ in range(4):
        mechanism = random_mechanism(rng, [kinds])
        rows, errors = evaluated_after(mechanism, rng, step)
        assert min(rows, errors) > 0.1 * min(angle, 0.5)


@pytest.mark.parametrize("angle", [1e-3, 1.0, 3.0])
def test_a_universal_joint_keeps_the_angle_of_its_axes(angle):
    """Opened by an angle about the normal of both axes: rows and errors are the change of the
    cosine."""
    rng = np.random.default_rng(3)
    seen = []

    def step(point, axis, second):
        about = np.cross(axis, second)
        change = math.cos(math.acos(axis @ second) + angle) - axis @ second
        seen.append(abs(change))
        return displacement(axis_turn(about / np.linalg.norm(about), angle), point)

    for _ in range(4):
        found = evaluated_after(random_mechanism(rng, ["rU"]), rng, step)
        np.testing.assert_allclose(found, seen[-1], rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("angle", [1e-3, 1.0, 3.0])
def test_a_slide_keeps_its_turn_about_the_axis(angle):
    """A P joint does not turn about its own axis, a C joint does."""
    for kinds, free in (("rP", False), ("rC", True)):
        rng = np.random.default_rng(5)
        mechanism = random_mechanism(rng, [kinds])
        found = evaluated_after(
            mechanism, rng, lambda point, axis, _: displacement(axis_turn(axis, angle), point)
        )
        assert max(found) < 1e-11 if free else min(found) > 0.1 * min(angle, 0.5)


@pytest.mark.parametrize("kinds", ["rP", "rC", "rR", "rU"])
def test_a_shift_across_the_axis_is_seen_and_one_along_slides(kinds):
    rng = np.random.default_rng(6)
    mechanism = random_mechanism(rng, [kinds])
    size = build_closure(mechanism).characteristic_length

    def shift(direction):
        return displacement(np.eye(3), np.zeros(3), 1e-3 * size * direction)

    assert min(evaluated_after(mechanism, rng, lambda _, axis, __: shift(across(axis, rng)))) > 1e-4
    along = evaluated_after(mechanism, rng, lambda _, axis, __: shift(axis))
    assert max(along) < 1e-11 if kinds[-1] in "PC" else min(along) > 1e-4
