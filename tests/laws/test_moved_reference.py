"""A mechanism described at another of its configurations is the same mechanism: its links move as
before, and so do its joints.
"""

from __future__ import annotations

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import (
    Closure,
    build_closure,
    closed_configurations,
    joint_readings,
    link_poses,
    whole_system,
    with_reference_at,
)
from helpers.random_graphs import random_graph
from helpers.shipped import TWELVE


def check(closure: Closure, seed: int) -> None:
    """At a configuration of the old description the joints of the new one, moved to the values that
    they read, lie where they lay.
    """
    here, there = (
        closed_configurations(closure, seed)[:2]
        if len(closed_configurations(closure, seed)) > 1
        else [None] * 2
    )
    if here is None:
        return
    moved = with_reference_at(closure, here)
    own = build_closure(moved)
    assert (
        whole_system(own).residual(own.reference, np.zeros(0)) <= 1e-11 * own.characteristic_length
    )
    before, after = (link_poses(closure, np.array([z])).at(0) for z in (here, there))
    read = {
        n: np.ravel(v)
        for n, v in joint_readings(closure, link_poses(closure, np.array([there]))).items()
    }
    start = {
        n: np.ravel(v)
        for n, v in joint_readings(closure, link_poses(closure, np.array([here]))).items()
    }
    for entry in moved.link_joints:
        joint, (first, second) = entry.joint, entry.links
        between = (after[first] @ before[first].inverse()).inverse() @ (
            after[second] @ before[second].inverse()
        )
        if joint.type in ("S", "U", "R"):
            np.testing.assert_allclose(
                between.apply(joint.point), joint.point, atol=1e-8 * own.characteristic_length
            )
        if joint.type in ("P", "H"):
            slide = np.dot(joint.axis, between.apply(joint.point) - np.array(joint.point))
            value = read[joint.name][0] - joint.zero
            lead = 1.0 if joint.type == "P" else joint.pitch / (2 * np.pi)
            assert slide == pytest.approx(lead * value, abs=1e-8 * own.characteristic_length), (
                joint.name
            )
        if joint.type in ("R", "P", "H"):
            assert joint.zero == pytest.approx(start[joint.name][0], abs=1e-9) or joint.type == "R"
            np.testing.assert_allclose(between.turn(joint.axis), joint.axis, atol=1e-8)


@pytest.mark.parametrize("seed", range(12))
def test_random_graphs(seed: int) -> None:
    check(build_closure(random_graph(seed)), seed)


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_shipped_mechanisms_keep_their_mobility(name: str) -> None:
    """Limbs too: the new reference is closed, and has the pose of the platform and the values of
    the configuration.
    """
    mechanism = symkin.load(name)
    closure = build_closure(mechanism)
    values = closed_configurations(closure, 3)[-1]
    moved = with_reference_at(closure, values)
    own = build_closure(moved)
    assert (
        whole_system(own).residual(own.reference, np.zeros(0)) <= 1e-12 * own.characteristic_length
    )
    for old, new in zip(mechanism.actuated, moved.actuated, strict=True):
        if old.name in closure.slices:
            assert new.reference[0] == pytest.approx(
                values[closure.slices[old.name]][0], rel=1e-9, abs=1e-9
            )
    links = link_poses(closure, values[None]).at(0)
    if mechanism.platform_link is not None:
        expected = links[mechanism.platform_link] @ mechanism.reference_pose
        np.testing.assert_allclose(moved.platform_position, expected.position, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("four_bar", {"crank": 70.0}),
        pytest.param("ankle", {"upper_motor": 5.0, "lower_motor": -4.0}, marks=pytest.mark.long),
    ],
)
def test_modes_are_the_same(name: str, given: dict[str, float]) -> None:
    """Values of revolute joints mean the same in both descriptions."""
    mechanism = symkin.load(name)
    closure = build_closure(mechanism)
    moved = with_reference_at(closure, closed_configurations(closure, 3)[-1])
    before, after = symkin.modes(mechanism, given=given), symkin.modes(moved, given=given)
    assert len(after) == len(before)
    names = [e.joint.name for e in mechanism.link_joints if e.joint.type == "R"]
    rows = [
        np.array(sorted([mode.joints[n] % 360.0 for n in names] for mode in found))
        for found in (before, after)
    ]
    np.testing.assert_allclose(rows[1], rows[0], atol=1e-6)


@pytest.mark.parametrize("polynomial", [None, [0.2, 0.5, -0.3]])
def test_couplings_of_universal_joints(polynomial: list[float] | None) -> None:
    """Their coordinates count from the reference, which another one shifts: the coupling holds at
    the same configurations.
    """
    u = symkin.LinkJoint(symkin.Joint("u", "U", [0, 0, 0], [0, 0, 1], [1, 0, 0]), ["base", "arm"])
    r = symkin.LinkJoint(
        symkin.Joint("r", "R", [9, 0, 0], [0, 1, 0], actuated=True, zero=0.2), ["arm", "hand"]
    )
    of = {"u.1": 0.5} if polynomial is None else "u.1"
    coupling = symkin.Coupling("r", of, 0.2 if polynomial is None else 0.0, polynomial)
    closure = build_closure(symkin.Mechanism("m", link_joints=[u, r], couplings=[coupling]))
    here, there = closed_configurations(closure, 0)[:2]
    moved = with_reference_at(closure, here)
    shift, value = (float(z[closure.slices["u.1"]][0]) for z in (here, there))
    told = float(there[closure.slices["r"]][0])
    (new,) = moved.couplings
    if polynomial is None:
        assert new.offset + new.terms[0][1] * (value - shift) == pytest.approx(told, abs=1e-9)
    else:
        assert np.polynomial.Polynomial(new.polynomial)(value - shift) == pytest.approx(
            told, abs=1e-9
        )
