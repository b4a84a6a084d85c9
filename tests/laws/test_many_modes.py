"""Modes of many inputs at once are those of each input alone."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import symkin
from helpers.samples import delta, five_bar, random_mechanism, three_rps, three_rrr


def joints_about(mechanism, count, spread, seed=0):
    """Joint values about the reference: angles by `spread`, lengths by a tenth of it."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(count):
        rows.append(
            [
                mechanism.angle_out(c.reference[0] + rng.uniform(-spread, spread))
                if c.is_angular
                else c.reference[0] * (1 + 0.1 * rng.uniform(-spread, spread))
                for c in mechanism.actuated
            ]
        )
    return np.array(rows)


def poses_of(mechanism, joints):
    """Poses (n, 7) that the mechanism takes at some joint values."""
    poses = [symkin.solve(mechanism, joints=list(row)).solution.pose for row in joints]
    return np.array([[*pose.position, *pose.quaternion] for pose in poses])


def check_same(together, alone):
    """The same statement, and the same modes in the same order to rounding."""
    assert (together.completeness, together.complex_count, together.unresolved_paths) == (
        alone.completeness,
        alone.complex_count,
        alone.unresolved_paths,
    )
    assert together.given == alone.given
    assert len(together) == len(alone)
    size = together.problem.closure.characteristic_length
    for a, b in zip(together, alone, strict=True):
        np.testing.assert_allclose(a.position, b.position, atol=1e-9 * size)
        np.testing.assert_allclose(a.rotation, b.rotation, atol=1e-9)
        assert a.certified == b.certified
        assert a.notes == b.notes
        assert a.within_limits == b.within_limits
        assert max(a.residual, b.residual) <= 1e-9 * size
        assert a.condition == pytest.approx(b.condition, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanism", "spread"),
    [
        pytest.param(symkin.load("zhang2009"), 0.5, marks=pytest.mark.long),
        (five_bar(), 0.3),
        (three_rrr("planar"), 0.2),
        pytest.param(three_rps(), 0.5, marks=pytest.mark.long),
        (symkin.load("zhao2000"), 0.05),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_many_joints_are_each_alone(mechanism, spread):
    """Direct problems, with limbs of one and of several branches; rows of lists and rows of an
    array mean the same.
    """
    joints = joints_about(mechanism, 6, spread)
    together = symkin.modes(mechanism, joints=joints)
    assert len(together) == 6
    for row, found in zip(joints, together, strict=True):
        check_same(found, symkin.modes(mechanism, joints=list(row)))
    for found, other in zip(together, symkin.modes(mechanism, joints=joints.tolist()), strict=True):
        check_same(found, other)


@pytest.mark.slow
@pytest.mark.parametrize(
    "mechanism",
    [symkin.load("yao2020"), pytest.param(three_rrr("planar"), marks=pytest.mark.long)],
    ids=lambda m: m.name,
)
def test_many_poses_are_each_alone(mechanism):
    """Inverse problems of one block and of several, poses as rows and as objects."""
    poses = poses_of(mechanism, joints_about(mechanism, 4, 0.2))
    together = symkin.modes(mechanism, pose=poses)
    objects = [symkin.Pose(row[:3], row[3:]) for row in poses]
    for row, found, other in zip(
        poses, together, symkin.modes(mechanism, pose=objects), strict=True
    ):
        check_same(found, symkin.modes(mechanism, pose=list(row)))
        check_same(found, other)


@pytest.mark.slow
def test_inputs_in_doubt_stand_beside_plain_ones():
    """Inputs without a real mode, with merging modes and with plain ones: each has what it has
    alone.
    """
    platform = symkin.load("zhang2009")
    legs = np.array(platform.example.joints)
    rows = [
        legs,
        np.full(6, 250.0),
        legs + 1.0,
        np.array([100.0, 100.0, 100.0, 100.0, 100.0, 400.0]),
    ]
    for row, found in zip(rows, symkin.modes(platform, joints=np.array(rows)), strict=True):
        alone = symkin.modes(platform, joints=list(row))
        check_same(found, alone)
        # what stays open, and by how much, is said of one input alone
        assert found.notes == tuple(note for note in alone.notes if "come nearest" not in note)
        assert (found.smallest_residual is None) == (alone.smallest_residual is None)


@pytest.mark.slow
def test_a_pose_off_the_motion_stands_beside_others():
    """A pose that the platform cannot take has no modes and its note; the others have theirs."""
    mechanism = delta()
    good = [*mechanism.platform_position, 1.0, 0.0, 0.0, 0.0]
    tilted = [*mechanism.platform_position, np.cos(0.2), np.sin(0.2), 0.0, 0.0]
    found = symkin.modes(mechanism, pose=[good, tilted, good])
    assert [len(f) for f in found] == [8, 0, 8]
    assert any("off the platform's" in note for note in found[1].notes)


@pytest.mark.slow
def test_results_do_not_depend_on_neighbours():
    """The same numbers to the last bit, whatever other inputs stand beside."""
    mechanism = five_bar()
    joints = joints_about(mechanism, 5, 0.3)
    whole, part = (
        symkin.modes(mechanism, joints=joints),
        symkin.modes(mechanism, joints=joints[2:4]),
    )
    for a, b in zip(whole[2:4], part, strict=True):
        for x, y in zip(a, b, strict=True):
            np.testing.assert_allclose(x.position, y.position, rtol=1e-13)


def test_compiled_batches_are_those_of_casadi(monkeypatch):
    """Many poses of an arm: the same digits with a compiler and without, conditions to rounding,
    and each pose as alone.
    """
    arm = symkin.load("ur5e")
    joints = np.random.default_rng(4).uniform(-150, 150, (12, 6))
    poses = np.array([[*m[0].position, *m[0].quaternion] for m in symkin.modes(arm, joints=joints)])
    found = symkin.modes(arm, pose=poses)
    check_same(found[7], symkin.modes(arm, pose=poses[7].tolist()))
    monkeypatch.setenv("SYMKIN_ENGINE", "numpy")
    for a, b in zip(found, symkin.modes(arm, pose=poses), strict=True):
        assert np.array_equal(a.modes.values, b.modes.values)
        assert np.array_equal(a.modes.residual, b.modes.residual)
        np.testing.assert_allclose(a.modes.condition, b.modes.condition, rtol=1e-9)


def test_a_copy_of_one_of_many_holds_no_other():
    """The modes of an input are cut out of those of all when they are asked for, or copied."""
    machine = five_bar()
    found = symkin.modes(machine, joints=joints_about(machine, 300, 0.3))
    copied = pickle.loads(pickle.dumps(found[5].modes))
    assert np.array_equal(copied.values, found[5].modes.values)
    assert len(pickle.dumps(found[5])) < len(pickle.dumps(found[5].modes)) + 2_000 < 20_000
    with pytest.raises(AttributeError):
        _ = found[5].modes.nothing


def test_what_found_the_modes_of_one_is_told_alike_beside_others():
    """Two limbs by paths and by formulas, of which a pose out of reach needs the one only."""
    machine = random_mechanism(np.random.default_rng(0), ["PSS", "RRS"], motion="schoenflies")
    pose = [*machine.reference_pose.position, *machine.reference_pose.quaternion]
    away = [*np.add(pose[:3], [-76.0, -37.0, 2.0]).tolist(), *pose[3:]]
    alone = symkin.modes(machine, pose=pose)
    assert len(alone) == 2
    for together in ([pose, away], [away, pose]):
        found = symkin.modes(machine, pose=together)[together.index(pose)]
        assert (found.engine, len(found)) == (alone.engine, 2)


def test_no_inputs_have_no_modes():
    assert symkin.modes(five_bar(), joints=np.zeros((0, 2))) == ()


@pytest.mark.parametrize(
    ("joints", "text"),
    [
        ([[10.0, 20.0], [10.0, float("nan")]], "input 1: joints: value 2"),
        ([[10.0, 20.0], [10.0]], "input 1: joints: 1 value given"),
        ([[10.0, 20.0], [10.0, "x"]], "input 1: joints: value 2 = 'x' is not a number"),
    ],
)
def test_a_faulty_input_is_named(joints, text):
    with pytest.raises(symkin.InputError, match=text):
        symkin.modes(five_bar(), joints=joints)


def test_turns_are_left_out_of_many_inputs_too():
    """Angles of many turns are those without the turns."""
    mechanism = five_bar()
    joints = joints_about(mechanism, 2, 0.2)
    far = symkin.modes(
        mechanism, joints=joints + mechanism.angle_out(2 * np.pi) * np.array([[5.0, -3.0]])
    )
    for a, b in zip(far, symkin.modes(mechanism, joints=joints), strict=True):
        assert len(a) == len(b)
        for x, y in zip(a, b, strict=True):
            np.testing.assert_allclose(
                x.position, y.position, atol=1e-9 * mechanism.characteristic_length
            )


def test_solutions_are_made_when_asked_for():
    """The list behaves as a tuple of solutions: length, slices, negative places, one object for one
    place.
    """
    found = symkin.modes(symkin.load("zhang2009"))
    assert len(found.modes) == len(list(found)) == 4
    assert found[-1] is found[3]
    assert list(found.modes[1:3]) == [found[1], found[2]]
    with pytest.raises(IndexError):
        found[4]
