"""Poses first, then the branches of the limbs and their combinations."""

import numpy as np
import pytest

import symkin
from symkin import Joint, Limb, Mechanism


def joint_hexapod(rods: Mechanism, kind: str) -> Mechanism:
    """The platform of six rods with each rod as U P S, or as R U S with a crank of 60."""
    rng = np.random.default_rng(0)
    place = np.array([5.0, -7.0, 300.0])
    limbs = []
    for i, rod in enumerate(rods.limbs):
        foot, ball = np.array(rod.base), np.array(rod.platform) + place
        hinge = foot if kind == "UPS" else foot + 60 * np.array([0, 0, 1.0])
        along = (ball - hinge) / np.linalg.norm(ball - hinge)
        first = np.cross(along, rng.normal(size=3))
        first /= np.linalg.norm(first)
        joints = [
            Joint(f"u{i}", "U", hinge, first, np.cross(first, along)),
            Joint(f"s{i}", "S", ball),
        ]
        if kind == "UPS":
            length = float(np.linalg.norm(ball - hinge))
            joints.insert(1, Joint(f"p{i}", "P", hinge, along, actuated=True, zero=length))
        else:
            joints.insert(0, Joint(f"r{i}", "R", foot, np.cross(along, [0, 0, 1.0]), actuated=True))
        limbs.append(Limb(f"limb{i}", joints))
    return Mechanism(f"hexapod_{kind.lower()}", limbs, platform_position=place)


@pytest.mark.long
@pytest.mark.slow
def test_rods_and_universal_joints_give_the_same_poses():
    """A limb U P S is a rod: the same poses, each with 2^6 choices of the universal joints."""
    rods = symkin.load("zhang2009")
    by_rods = symkin.modes(rods)
    by_joints = symkin.modes(joint_hexapod(rods, "UPS"), joints=rods.example.joints)
    assert (by_joints.poses, len(by_joints)) == (len(by_rods), 64 * len(by_rods))
    assert by_joints.complex_count == 64 * by_rods.complex_count
    heights = [
        sorted(mode.position[2] for mode in found.representatives) for found in (by_rods, by_joints)
    ]
    np.testing.assert_allclose(heights[0], heights[1], atol=1e-8)


@pytest.mark.long
@pytest.mark.slow
def test_a_rotary_hexapod_is_complete():
    """Six limbs R U S: every mode closes, the reference is among them, no path is unresolved."""
    mechanism = joint_hexapod(symkin.load("zhang2009"), "RUS")
    found = symkin.modes(mechanism)
    assert (found.completeness, found.unresolved_paths) == ("probability one", 0)
    assert len(found) == 64 * found.poses
    assert max(mode.residual for mode in found) < 1e-9 * mechanism.characteristic_length
    assert (
        min(np.max(np.abs(mode.position - mechanism.reference_pose.position)) for mode in found)
        < 1e-8
    )


@pytest.mark.long
@pytest.mark.slow
def test_modes_are_products_of_the_branches_of_limbs():
    """Three limbs of two real branches each: eight modes a pose."""
    found = symkin.modes(symkin.load("zhao2000_links"))
    assert len(found) == 8 * found.poses
