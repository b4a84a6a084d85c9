"""Closed forms of serial arms: all modes, the same as by paths, or handed over to paths.

Oracles: the direct problem, which no formula of the inverse one enters, and continuation.
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.arms import (
    along,
    direction,
    free,
    random_values,
    serial,
    short_structures,
    structures,
    through,
)
from helpers.gate import in_gate
from helpers.inside import ArmScrews, AxisGeometry, Screw, plan_of
from symkin import InputError

ARMS, SHORT = structures(np.random.default_rng(7)), short_structures(np.random.default_rng(7))
ALL = ARMS | SHORT
KINDS = [
    "parallel_inner",
    "wrist_first_meeting",
    "stanford",
    "planar_with_slide",
    "gantry_with_turn",
]
"""One arm of each kind of structure."""
SEARCHED = ["stanford", "planar_with_slide", "gantry_with_turn"]
"""Those whose start of continuation takes a second or two, not ten."""
ON_LINE = 1e-7
"""What a plan of an ideal arm may be off by before it is polished: rounding times the conditions of
random configurations.
"""


def pose_of(arm: symkin.Mechanism, values) -> symkin.Pose:
    return symkin.solve(arm, joints=list(values)).solution.pose


def turned(a: np.ndarray, b: np.ndarray, arm: symkin.Mechanism) -> np.ndarray:
    """Largest differences of joint values, whole turns left aside."""
    angular = np.array([c.is_angular for c in arm.actuated])
    gap = np.asarray(a) - np.asarray(b)
    return np.max(np.abs(np.where(angular, np.angle(np.exp(1j * gap)), gap)), axis=-1)


@pytest.mark.parametrize("name", in_gate(ALL, list(ALL)[::4]))
def test_every_structure_has_a_plan_that_says_how_it_goes(name: str) -> None:
    """One step a joint or more joints, each with its reason; every choice has a name of its own."""
    plan = plan_of(ALL[name])
    assert plan is not None
    assert sorted(joint for step in plan.steps for joint in step.joints) == list(
        range(len(ALL[name].actuated))
    )
    assert len(set(plan.branches)) == len(plan.branches)
    assert all(any(c.name in line for c in ALL[name].actuated) for line in plan.derivation())


@pytest.mark.parametrize("name", in_gate(ARMS, KINDS))
def test_real_branches_reach_the_pose_and_one_of_them_is_the_arm(name: str) -> None:
    """Inverse of direct is among the branches, in the branch that its slopes name; every real
    branch has the pose.
    """
    arm, rng = ARMS[name], np.random.default_rng(3)
    plan = plan_of(arm)
    x, q = ca.SX.sym("x", 7), ca.SX.sym("q", len(arm.actuated))
    branches = [plan.branch(x, signs) for signs in plan.signs.tolist()]
    formulas = ca.Function(
        "f",
        [x],
        [
            ca.horzcat(*(b.joints for b in branches)),
            ca.horzcat(*(b.discriminants for b in branches)),
        ],
    )
    flags = ca.Function("s", [x, q], [plan.slopes(x, q)])
    for _ in range(10):
        values = random_values(arm, rng)
        pose = pose_of(arm, values)
        given = [*pose.position, *pose.quaternion]
        joints, discriminants = (np.array(part).T for part in formulas(given))
        real = discriminants.min(axis=1) > 0.0
        gaps = turned(joints, values, arm)
        assert gaps[real].min() < ON_LINE
        signs = np.sign(np.array(flags(given, values)).ravel())
        assert gaps[np.flatnonzero((plan.signs == signs).all(axis=1))[0]] < ON_LINE
        for found in joints[real]:
            again = pose_of(arm, found)
            assert (
                np.abs(again.position - pose.position).max() < ON_LINE * arm.characteristic_length
            )
            assert 1.0 - abs(again.quaternion @ pose.quaternion) < ON_LINE


@pytest.mark.parametrize("name", in_gate(ALL, [*SEARCHED, *list(ALL)[::12]]))
def test_modes_hold_the_arm_and_close(name: str) -> None:
    """Of random joint values' poses: the closed form answers, the joint values are among the modes,
    each closes to 1e-9.
    """
    arm, rng = ALL[name], np.random.default_rng(4)
    inputs = [random_values(arm, rng) for _ in range(20)]
    found = symkin.modes(arm, pose=[pose_of(arm, values) for values in inputs])
    answered = [
        (values, modes)
        for values, modes in zip(inputs, found, strict=True)
        if modes.method == "closed"
    ]
    assert len(answered) >= 19
    for values, modes in answered:
        assert modes.completeness in ("probability one", "proved")
        assert max(mode.residual for mode in modes) < 1e-9 * arm.characteristic_length
        assert min(turned(list(mode.actuated), values, arm) for mode in modes) < ON_LINE
        assert len(modes) <= plan_of(arm).count


@pytest.mark.parametrize("name", in_gate(["parallel_inner", "gantry"], ["gantry"]))
def test_modes_are_those_of_continuation(name: str) -> None:
    same_as_continuation(ARMS[name], 6)


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(ALL, [*SEARCHED, "planar"]))
def test_all_structures_have_the_modes_of_continuation(name: str) -> None:
    same_as_continuation(ALL[name], 6)


def same_as_continuation(arm: symkin.Mechanism, count: int) -> None:
    """The same joint values, mode by mode, and as many complex solutions where both are counted."""
    rng = np.random.default_rng(5)
    poses = [pose_of(arm, random_values(arm, rng)) for _ in range(count)]
    closed, tracked = (
        symkin.modes(arm, pose=poses),
        symkin.modes(arm, pose=poses, method="continuation"),
    )
    for a, b in zip(closed, tracked, strict=True):
        assert b.method == "continuation"
        assert len(a) == len(b)
        ours, theirs = np.array([m.actuated for m in a]), np.array([m.actuated for m in b])
        assert max(turned(ours, one, arm).min() for one in theirs) < ON_LINE
        if a.complex_count is not None and b.complex_count is not None:
            assert a.complex_count == b.complex_count
        assert all(
            ours.certified or not theirs.certified for ours, theirs in zip(a, b, strict=True)
        )


@pytest.mark.long
def test_a_wrist_without_an_angle_is_left_to_paths() -> None:
    """Where the axes of joints 4 and 6 fall together the wrist's solutions are a continuum: no
    formula tells them.
    """
    y, z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    spec = [
        ("R", (0, 0, 0), z),
        ("R", (0, 0, 80), y),
        ("R", (0, 0, 180), y),
        *(("R", (90, 0, 180), k) for k in (z, y, z)),
    ]
    joints = [
        symkin.Joint(f"q{i}", t, p, k, actuated=True) for i, (t, p, k) in enumerate(spec, start=1)
    ]
    arm = symkin.Mechanism(
        "wrist", [symkin.Limb("arm", joints)], platform_position=(90.0, 0.0, 220.0), serial=True
    )
    straight = symkin.modes(arm, pose=pose_of(arm, [0.3, 0.4, 0.5, 0.6, 0.0, 0.8]))
    assert (straight.method, straight.positive_dimensional) == ("continuation", True)
    nearly = symkin.modes(arm, pose=pose_of(arm, [0.3, 0.4, 0.5, 0.6, 1e-5, 0.8]))
    assert nearly.method == "continuation"
    bent = symkin.modes(arm, pose=pose_of(arm, [0.3, 0.4, 0.5, 0.6, 0.1, 0.8]))
    assert (bent.method, bent.engine, len(bent)) == ("closed", "closed form", 8)


def test_a_nearly_straight_wrist_is_told_to_rounding() -> None:
    """The angle of a wrist that is straight but for 1e-3 to 1e-6 rad is one branch's to rounding:
    1 - cos^2 would have lost up to half of its digits.
    """
    arm = symkin.load("ur5e")
    plan = plan_of(arm)
    assert plan is not None
    pose = ca.SX.sym("x", 7)
    branches = [plan.branch(pose, list(signs)).joints[4] for signs in plan.signs]
    told = ca.Function("wrists", [pose], [ca.vertcat(*branches)])
    rng = np.random.default_rng(8)
    for bend in (1e-3, 1e-4, 1e-5, 1e-6):
        values = rng.uniform(-2.5, 2.5, 6)
        values[4] = bend
        there = pose_of(arm, np.degrees(values))
        wrists = np.asarray(told([*there.position, *there.quaternion])).ravel()
        assert np.abs(wrists - bend).min() < 1e-13 + 1e-9 * bend


def test_a_stretched_elbow_is_left_to_paths() -> None:
    """Two solutions in one: the discriminant is zero. What has solved a pose beside it is said of
    that one.
    """
    arm = symkin.load("gluon_6l3")
    poses = [pose_of(arm, [10.0, 20.0, elbow, 40.0, 50.0, 60.0]) for elbow in (0.0, 5.0)]
    stretched, bent = symkin.modes(arm, pose=poses)
    assert (stretched.method, bent.method) == ("continuation", "closed")
    assert (bent.engine, "closed form" in stretched.engine) == ("closed form", False)


def test_other_arms_have_no_plan() -> None:
    """A general arm, one with a joint too many, and one whose axes are off by a thousandth of a
    millimetre in a metre.
    """
    rng = np.random.default_rng(0)
    general = serial("general", [free(rng) for _ in range(6)], rng)
    seven = serial(
        "seven",
        [free(rng), *along(rng, direction(rng), 3), *through(rng, rng.normal(size=3), 3)],
        rng,
    )
    k = direction(rng)
    axes = [free(rng), *along(rng, k, 3), *through(rng, rng.normal(size=3), 2)]
    exact = serial("exact", axes, np.random.default_rng(1))
    off = serial(
        "off",
        [*axes[:3], ("R", axes[3][1], k + 1e-6 * direction(rng)), *axes[4:]],
        np.random.default_rng(1),
    )
    assert plan_of(exact) is not None
    assert [plan_of(arm) for arm in (general, seven, off, symkin.load("zhao2000"))] == [None] * 4
    assert plan_of(off, tolerance=1e-4) is not None


def test_what_a_closed_form_has_no_use_for_is_refused() -> None:
    arm = symkin.load("gluon_6l3")
    with pytest.raises(InputError, match="starts"):
        symkin.modes(arm, pose=pose_of(arm, [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]), starts=10)
    with pytest.raises(InputError, match="'closed' is unknown"):
        symkin.modes(arm, pose=pose_of(arm, [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]), method="closed")


def test_a_short_arm_has_no_mode_at_a_pose_beside_its_own() -> None:
    """A pose turned away from those that the arm can take has no mode, whatever single equations
    say.
    """
    arm = SHORT["five_parallel"]
    pose = pose_of(arm, [0.1, 0.2, 0.3, 0.4, 0.5])
    assert len(symkin.modes(arm, pose=pose)) >= 1
    q = pose.quaternion + np.array([0.0, 0.05, -0.03, 0.02])
    assert not len(
        symkin.modes(arm, pose=symkin.Pose(pose.position, q / np.linalg.norm(q)), method=None)
    )


@pytest.mark.parametrize("name", ["wrist_parallel_two_three", "stanford", "scara"])
def test_solve_by_the_closed_form_takes_the_nearest_branch(name: str) -> None:
    """From beside an arm's joints the closed form leads back to them, whole turns included, in one
    step, where Newton's method does.
    """
    arm, rng = ALL[name], np.random.default_rng(6)
    for _ in range(5):
        values = np.array(random_values(arm, rng))
        angular = np.array([c.is_angular for c in arm.actuated])
        start = values + 1e-3 * rng.uniform(-1, 1, len(values))
        found = symkin.solve(arm, pose=pose_of(arm, values), start=start.tolist(), solver="closed")
        newton = symkin.solve(arm, pose=pose_of(arm, values), start=start.tolist())
        assert (found.iterations, found.method) == (1, "closed")
        assert (
            turned(list(found.solution.actuated_values), list(newton.solution.actuated_values), arm)
            < ON_LINE
        )
        assert turned(list(found.solution.actuated_values), values, arm) < ON_LINE
        assert angular.any()


def test_solve_by_a_closed_form_that_is_not_there() -> None:
    """No formulas: a sentence; out of reach: no solution."""
    platform = symkin.load("zhang2009")
    with pytest.raises(InputError, match="has no closed form"):
        symkin.solve(platform, joints=platform.example.joints, solver="closed")
    arm = symkin.load("gluon_6l3")
    far = symkin.solve(arm, pose=[1e4, 0, 0, 1, 0, 0, 0], solver="closed", check=False)
    assert (far.solution, far.status) == (None, "infeasible")


def test_a_pose_that_formulas_close_is_left_as_it_is():
    """A SCARA's poses satisfy conditions: exact ones stay, rounded ones are moved to the nearest,
    others are refused with it.
    """
    arm = symkin.load("scara")
    pose = symkin.solve(arm, joints=[20.0, 60.0, -30.0, -50.0]).solution.pose
    exact = [*pose.position, *pose.quaternion]
    assert not any("projected" in note for note in symkin.modes(arm, pose=exact).notes)
    tilted = [*exact[:4], 1e-6, *exact[5:]]
    found = symkin.modes(arm, pose=tilted)
    assert len(found) == 2
    assert any("projected" in note for note in found.notes)
    away = symkin.modes(arm, pose=[*exact[:3], np.cos(0.4), np.sin(0.4), 0.0, 0.0])
    assert len(away) == 0
    assert any("off those that it can take" in note for note in away.notes)


@pytest.mark.parametrize("count", [2, 3])
def test_axes_meet_in_their_common_point_or_nowhere(count: int) -> None:
    """Random axes through a random point meet there; with one of them beside it, along the normal
    of two of them, they do not meet, and parallel ones have no single point.
    """
    rng = np.random.default_rng(count)
    for _ in range(10):
        point, axes = rng.normal(size=3), [direction(rng) for _ in range(count)]
        through_it = [
            Screw(f"q{k}", False, tuple(point + rng.normal() * np.array(a)), tuple(a), 0.0)
            for k, a in enumerate(axes)
        ]
        found = AxisGeometry(
            ArmScrews(tuple(through_it), symkin.Pose.identity(), 1.0)
        ).meeting_point(range(count))
        np.testing.assert_allclose(found, point, atol=1e-9)
        beside = replace(
            through_it[-1],
            point=tuple(np.array(through_it[-1].point) + 0.01 * np.cross(axes[0], axes[-1])),
        )
        other = replace(through_it[-1], axis=through_it[0].axis)
        for last in (beside, other):
            arm = ArmScrews((*through_it[:-1], last), symkin.Pose.identity(), 1.0)
            found = AxisGeometry(arm).meeting_point(range(count))
            assert found is None or (last is other and count == 3)
