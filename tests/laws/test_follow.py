"""Staying on one mode: branches are those of closed forms, and stops stand where closed forms put
them.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import symkin
from helpers.inside import build_problem, great_circle
from helpers.laws import closes, same_angle, same_pose
from helpers.samples import (
    COUPLER,
    CRANK,
    GROUND,
    ROCKER,
    TOGGLE,
    bars,
    five_bar,
    parallel_rrr,
    pieper,
    three_rps,
    three_rrr,
)
from symkin import InputError, Mechanism, track


@pytest.fixture(scope="module")
def zhang() -> Mechanism:
    return symkin.load("zhang2009")


@pytest.mark.long
@pytest.mark.slow
def test_random_smooth_paths_keep_their_mode(zhang):
    """Along random smooth curves of leg lengths the tracked end is the one of independent small
    Newton steps, stands in the complete enumeration, and every stop is a fold.
    """
    rng = np.random.default_rng(5)
    system = build_problem(zhang, "direct").system
    for _ in range(5):
        pose = [
            *rng.uniform(-60, 60, 2),
            rng.uniform(80, 160),
            1.0,
            *(0.09 * rng.uniform(-1, 1, 3)),
        ]
        q = np.array(symkin.solve(zhang, pose=pose).solution.actuated_values)
        start = symkin.solve(zhang, joints=q, start=pose).solution
        a, b = rng.normal(size=(2, 6)) * 25
        t = np.linspace(0, 1, 9)[:, None]
        rows = np.maximum(q + a * np.sin(math.pi * t) + b * (1 - np.cos(math.pi * t)), 30.0)
        found = track(zhang, joints=rows, start=start, name_modes=False)
        assert found.certified
        assert found.stop is None or found.stop.kind == "turning point"
        z = np.concatenate([start.position, start.quaternion])
        kept = found.samples if found.stop is None else found.samples[:-1]
        for before, after in pairwise(kept):
            for u in np.linspace(0, 1, 60)[1:]:
                k = np.array(before.actuated) * (1 - u) + np.array(after.actuated) * u
                z = system.polish(z, k, steps=3)
        z = system.polish(z, np.array(kept[-1].actuated), steps=8)
        assert np.max(np.abs(z[:3] - kept[-1].pose.position)) < 1e-6
        every = symkin.modes(zhang, joints=kept[-1].actuated)
        assert (
            sum(
                same_pose(mode.pose, kept[-1].pose, zhang.characteristic_length, 1e-7)
                for mode in every
            )
            == 1
        )
        if found.stop is not None:
            assert found.end.smallest_singular_value < 1e-9


@pytest.mark.parametrize(
    "mechanism",
    [five_bar(), three_rrr("planar"), three_rps(), symkin.load("zhao2000")],
    ids=lambda m: m.name,
)
def test_way_back_ends_at_the_start(mechanism):
    """A path and its way back end at the starting configuration; every sample closes all loops."""
    q = np.array(symkin.solve(mechanism).solution.actuated_values)
    step = np.array(
        [
            mechanism.angle_out(0.1) if c.is_angular else 0.05 * mechanism.characteristic_length
            for c in mechanism.actuated
        ]
    )
    found = track(mechanism, joints=[q, q + step, q], samples=9)
    assert found.reached
    assert found.certified
    assert same_pose(found.end.pose, found.samples[0].pose, mechanism.characteristic_length)
    assert all(closes(mechanism, sample.solution) for sample in found.samples)


def test_whole_turns_are_kept():
    """A crank that turns three times ends where it began, its angle and the passive ones counted
    on.
    """
    mechanism = bars(100.0, 30.0, 90.0, 70.0)
    found = track(mechanism, joints=[[1.0], [1.0 + 6 * math.pi]])
    assert found.reached
    assert found.certified
    assert found.end.actuated[0] == pytest.approx(1.0 + 6 * math.pi)
    assert same_pose(found.end.pose, found.samples[0].pose, mechanism.characteristic_length)


@pytest.mark.slow
def test_inverse_path_of_an_arm_keeps_its_working_mode():
    """The end of an inverse path of a 6R arm is one of the complete list, and direct kinematics
    gives its pose.
    """
    arm = pieper()
    ends = [symkin.solve(arm, joints=[0.1, 0.2, 0.3, 0.4, q5, 0.6]).solution for q5 in (0.5, 0.35)]
    found = track(arm, poses=[e.pose for e in ends], start=ends[0])
    assert found.reached
    assert found.certified
    assert same_pose(
        symkin.solve(arm, joints=found.end.actuated).solution.pose,
        ends[1].pose,
        arm.characteristic_length,
    )
    every = symkin.modes(arm, pose=ends[1].pose)
    assert (
        sum(
            all(same_angle(a, b) for a, b in zip(m.actuated, found.end.actuated, strict=True))
            for m in every
        )
        == 1
    )


def test_joints_of_an_arm_need_no_steps():
    """The pose of an arm is a formula of its joints: samples are those of `solve`, a limit stops
    them at its value.
    """
    arm = pieper()
    begin, end = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), np.array([1.1, 0.2, -0.3, 0.4, 2.5, 0.6])
    found = track(arm, joints=[begin, end], samples=5)
    assert found.reached
    assert (found.certified, found.steps) == (True, 0)
    for share, sample in zip(np.linspace(0, 1, 5), found.samples, strict=True):
        assert same_pose(
            sample.solution.pose,
            symkin.solve(arm, joints=begin + share * (end - begin)).solution.pose,
            arm.characteristic_length,
        )


@pytest.mark.slow
def test_wrist_that_is_nearly_straight_is_passed():
    """A tool that turns past the fourth axis at 1e-4 rad is followed with a proof; joints 4 and 6
    turn by half a turn less twice the angle whose tangent is distance over way, and joint 5 is back
    at its value.
    """
    arm, way, miss = pieper(), 0.1, 1e-4
    # the wrist's deflection is the angle between axes 4 and 6: joint 5, joint 4 its azimuth
    deflection, azimuth = math.hypot(way, miss), math.atan2(miss, way)
    ends = []
    for turn in (azimuth, math.pi - azimuth):
        ends.append(
            symkin.solve(arm, joints=[0.1, 0.2, 0.3, turn, deflection, 0.6 - turn]).solution
        )
    found = track(arm, poses=[e.pose for e in ends], start=ends[0], name_modes=False)
    assert found.reached
    assert found.certified
    assert min(s.smallest_singular_value for s in found.samples) > 0.0
    for a, b in zip(found.end.actuated, ends[1].actuated, strict=True):
        assert same_angle(a, b, 1e-6)


def test_singular_starts_are_named():
    """A start at a fold, at a bifurcation or on a continuum of solutions is not followed."""
    fold = track(bars(GROUND, CRANK, COUPLER, ROCKER), joints=[[TOGGLE], [1.0]])
    flat = track(
        bars(100.0, 40.0, 100.0, 40.0), joints=[[0.0], [1.0]], start=[40, 0, 0, 1, 0, 0, 0]
    )
    continuum = track(parallel_rrr("planar"), joints=[[0, 0, 0], [0.1, 0.1, 0.1]])
    nearly = track(bars(100.0, 40.0, 100.0, 40.0), joints=[[0.0], [1.0]])
    for found in (fold, flat, nearly, continuum):
        assert found.stop is not None
        assert found.stop.kind == "singular start"
        assert not found.certified


def test_start_must_lie_on_the_path(zhang):
    """A start mode of other inputs or of another mechanism is refused, naming what differs; whole
    turns do not matter.
    """
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER)
    mode = symkin.modes(mechanism, joints=[0.9])[1]
    with pytest.raises(InputError, match=r"crank = 0\.9, the path begins at 1"):
        track(mechanism, joints=[[1.0], [1.1]], start=mode)
    with pytest.raises(InputError, match="bars"):
        track(zhang, joints=[zhang.example.joints], start=mode)
    turned = track(mechanism, joints=[[0.9 + 2 * math.pi], [1.0 + 2 * math.pi]], start=mode)
    assert turned.reached
    assert same_pose(turned.samples[0].pose, mode.pose, mechanism.characteristic_length)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "either by joint values"),
        ({"joints": []}, "no samples"),
        ({"joints": [[1.0], [math.nan]]}, "sample 2.*not finite"),
        ({"joints": [[1.0, 2.0]]}, "2 values given"),
        ({"joints": [[1.0], [1.1]], "times": [1.0, 0.0]}, "must not go back"),
        ({"joints": [[1.0], [1.1]], "times": [1.0]}, "1 values for 2 samples"),
        ({"joints": [[1.0], [1.1]], "samples": 1}, "from 2 to"),
        ({"poses": [[0, 0, 9, 1, 0, 0, 0]]}, "planar motion"),
    ],
)
def test_wrong_paths_are_refused(given, words):
    """Every mistake is one sentence that says where it is."""
    with pytest.raises(InputError, match=words):
        track(bars(GROUND, CRANK, COUPLER, ROCKER), **given)


def test_slerp_turns_at_a_constant_rate():
    """cos(u h) a + sin(u h) n is a unit quaternion, a at 0 and b at 1, u h of the half angle away
    from a.
    """
    rng = np.random.default_rng(0)
    for _ in range(20):
        a, b = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 4)))
        b = b if a @ b >= 0 else -b
        half, n = great_circle(a, b)
        for u in (0.0, 0.3, 1.0):
            q = math.cos(u * half) * a + math.sin(u * half) * n
            assert abs(np.linalg.norm(q) - 1) < 1e-14
            assert abs(math.acos(min(1.0, a @ q)) - u * half) < 1e-7
        assert np.max(np.abs(q - b)) < 1e-14
