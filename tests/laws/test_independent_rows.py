"""Laws of what is proved where rows are redundant: never more than is true of the numbers given."""

from __future__ import annotations

import numpy as np
import pytest

import symkin
from helpers.inside import build_closure
from helpers.samples import tied_platform


@pytest.mark.slow
def test_modes_of_redundant_rows_say_what_is_proved_of_them():
    """No certificate, but an exact root of rows as many as their rank, and a bound of the others
    that holds of the residual.
    """
    found = symkin.modes(symkin.load("sarrus"))
    for mode in found:
        ground = mode.to_dict()["ground"]
        assert mode.certified is False
        assert 0 < ground["independent"] < ground["rows"]
        assert 0.0 < ground["radius"] < 1e-9
        assert ground["remaining"] < 1e-9
    assert any("independent rows" in note for note in found.notes)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_the_bound_of_the_other_rows_is_never_smaller_than_their_contradiction(seed):
    """A pose moved by d along a limb's first axis leaves a gap of d there, whatever that limb's
    joints do: rows that two joints make zero leave it to the third.
    """
    rng = np.random.default_rng(seed)
    machine = tied_platform(False)
    pose = symkin.solve(machine, joints=rng.uniform(-8, 8, 3)).solution.pose
    away = 4e-10
    for k in (1, 2):
        angle = 2 * np.pi * k / 3
        moved = np.asarray(pose.position) + away * np.array([-np.sin(angle), np.cos(angle), 0.0])
        found = symkin.modes(machine, pose=[*moved, *pose.quaternion])
        assert not any("projected" in note for note in found.notes)
        grounds = [mode.ground for mode in found]
        assert len(grounds) == 8
        assert all(
            g is not None and away * 0.99 <= g.remaining + 2e-13 and g.remaining < 10 * away
            for g in grounds
        )


def test_a_planar_loop_is_proved_wherever_its_plane_stands():
    """A five-bar whose coupler carries a hinge that a rod turns: two rows of the loop and one of
    the rod, however the machine is turned in space.
    """
    turn = symkin.Pose.from_rotation_vector([1, 2, 3], [0.4, 1.1, -0.3])
    places = [(-5, 0, 0), (8, 0, 0), (-7, 10, 0), (12, 9, 0), (2, 20, 0), (2, 23, 3)]
    links = ["base a", "base b", "a c", "b d", "c d", "c hand"]
    joints = [
        symkin.LinkJoint(
            symkin.Joint(f"j{k}", "R", turn.apply(place), turn.turn(axis), actuated=k < 2),
            pair.split(),
        )
        for k, (place, pair) in enumerate(zip(places, links, strict=True))
        for axis in [(0, 0, 1) if k < 5 else (0, 0.6, 0.8)]
    ]
    ends = [turn.apply((0, 16, 1)), turn.apply((3, 25, 4))]
    machine = symkin.Mechanism(
        "oblique", link_joints=joints, link_rods=[symkin.LinkRod("push", ["c", "hand"], *ends)]
    )
    assert len(build_closure(machine).row_sources) == 3
    found = symkin.modes(machine, joints=[0.1, -0.1])
    assert (len(found), found.completeness, found.complex_count) == (4, "proved", 4)
    assert all(mode.certified for mode in found)


def test_certified_modes_need_no_other_ground():
    for mode in symkin.modes(symkin.load("zhang2009")):
        assert mode.certified
        assert mode.to_dict()["ground"] is None


def test_a_count_below_the_generic_one_says_where_the_others_are():
    """A platform of 28 generic solutions, at a regular pose and where it is turned by a quarter."""
    machine = symkin.load("zhang2009")
    for pose in ([10, 20, 300, 1, 0, 0, 0], [0, 0, 250, np.sqrt(0.5), 0, 0, np.sqrt(0.5)]):
        found = symkin.modes(
            machine, joints=symkin.solve(machine, pose=pose).solution.actuated_values
        )
        told = [note for note in found.notes if "generic complex solutions" in note]
        assert bool(told) == (found.complex_count < 28)


def test_modes_of_many_inputs_have_the_same_grounds_as_one_by_one():
    """A rod of each pair is redundant: what is proved of a configuration does not depend on the
    inputs beside it.
    """
    delta = symkin.load("delta")
    joints = np.array([10.0, 20.0, 30.0]) + np.random.default_rng(4).uniform(-20, 20, (12, 3))
    for many, one in zip(
        symkin.modes(delta, joints=joints),
        (symkin.modes(delta, joints=q) for q in joints),
        strict=True,
    ):
        assert len(many) == len(one) == 2
        for a, b in zip(many, one, strict=True):
            assert (
                (a.ground.independent, a.ground.rows)
                == (b.ground.independent, b.ground.rows)
                == (3, 6)
            )
            assert (
                0.0
                < max(a.ground.radius, a.ground.remaining, b.ground.radius, b.ground.remaining)
                < 1e-9
            )
