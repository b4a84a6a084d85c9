"""At the limits of reach: no mode that does not exist, none lost, and of two that meet within
rounding one, named double.

The short form of `tests/campaigns/limits_of_reach.py`, which counts solutions in 60 digits; and the
laws of the judgement.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import symkin
from campaigns import limits_of_reach as campaign
from helpers.command_line import run_json
from helpers.gate import each_once, in_gate
from helpers.inside import Coordinate, System, are_double, polished_roots, unite

QUICK = ("four_bar", "slider_crank", "rssr", "tripod", "delta_pose")
SLOW = ("six_bar", "spherical_four_bar", "delta_joints", "three_rrr", "scara", "arm_of_six")
OFFSETS = (1e-3, 1e-8, 1e-12, 1e-15)
FOUR_BAR = symkin.load("four_bar")
DELTA = symkin.load("delta")
TOP = -math.sqrt(344.0**2 - ((457.3 - 115.0) / (2.0 * math.sqrt(3.0))) ** 2)
"""Height at which the delta's three arms are stretched (mm)."""


# --- machines against 60 digits -------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(n, marks=[pytest.mark.slow, pytest.mark.long]) for n in SLOW)]
)
def test_modes_appear_and_vanish_where_sixty_digits_say_so(name, tmp_path, monkeypatch, capsys):
    """Inside and outside of each limit, by the default way."""
    monkeypatch.setattr(campaign, "OFFSETS", OFFSETS)
    asked, wrong = campaign.run(name, 1.0, ["default"], tmp_path)
    assert (asked, wrong) == (2 * len(OFFSETS), 0), capsys.readouterr().out


@pytest.mark.parametrize("beyond", in_gate([1e-3, 3e-7, 1e-8, 1e-10], [1e-10]))
def test_a_pose_beyond_reach_has_no_mode_and_its_distance_is_told(beyond):
    """A delta's pose below its lowest: none, by each way of listing and by `solve`; the loops stay
    open by what the stretched arms lack, a closed form.
    """
    pose = [0.0, 0.0, TOP - beyond, 1.0, 0.0, 0.0, 0.0]
    lacking = math.hypot((457.3 - 115.0) / (2.0 * math.sqrt(3.0)), pose[2]) - 344.0
    ways = [{}, {"method": "continuation"}, {"method": "multistart", "starts": 200}]
    for found in [
        *(symkin.modes(DELTA, pose=pose, **way) for way in ways),
        symkin.solve(DELTA, pose=pose, check=False),
    ]:
        assert not getattr(found, "modes", ())
        assert getattr(found, "solution", None) is None
        (told,) = [
            float(note.rpartition(" by up to ")[2].split()[0])
            for note in found.notes
            if "come nearest" in note
        ]
        assert told == pytest.approx(lacking, rel=0.02, abs=2e-13)
        # what the search has reached, which is no less
        assert 0.98 * lacking <= found.smallest_residual <= 1.5 * lacking
    assert not symkin.modes(DELTA, pose=[pose, pose])[1].modes


@pytest.mark.parametrize("by", [0.0, 1e3, 1e5])
def test_a_machine_far_from_the_origin_keeps_its_modes(by):
    """Numbers that are large and cancel leave larger rounding: two modes all the same, beside the
    limit and away from it.
    """
    away = np.array([by, by / 3.0, 0.0])
    joints = [
        replace(e, joint=replace(e.joint, point=tuple(e.joint.point + away)))
        for e in FOUR_BAR.link_joints
    ]
    mechanism = replace(FOUR_BAR, link_joints=tuple(joints))
    for follower in (20.0, 53.985, 53.98553):
        assert len(symkin.modes(mechanism, given={"follower": follower})) == 2


def test_a_double_mode_is_one_and_named(capsys):
    """At the limit itself: one mode, in its notes and in the table; two beside it, without."""
    mechanism, at = FOUR_BAR, 53.98553763182445
    for way in ({}, {"method": "continuation"}, {"method": "multistart"}):
        found = symkin.modes(mechanism, given={"follower": at}, **way)
        assert len(found) == 1
        assert any(note.startswith("double") for note in found[0].notes)
        assert "multiplicity" in str(found)
        assert "double" in str(found)
        beside = symkin.modes(mechanism, given={"follower": at - 1e-10}, **way)
        assert len(beside) == 2
        assert not any("double" in note for mode in beside for note in mode.notes)
        assert "multiplicity" not in str(beside)
    _, data = run_json(capsys, "modes", "four_bar", "--given", f"follower={at}")
    assert any(note.startswith("double") for note in data["modes"][0]["notes"])
    assert data["modes"][0]["certified"] is False


@pytest.mark.parametrize("digits", in_gate([7, 8, 9, 10], [7]))
def test_redundant_rows_of_few_digits_keep_their_modes(digits, tmp_path):
    """One of a pair of rods longer by a few digits: rows contradict each other, no motion lessens
    that, and modes stay.
    """
    text = (Path(symkin.__file__).parent / "mechanisms" / "delta.toml").read_text()
    end = 'platform = ["115/(2*sqrt(3))", 20, 0.0]'
    file = tmp_path / "delta.toml"
    file.write_text(text.replace(end, f"{end}\nlength = {232.0 + 10.0**-digits!r}"))
    mechanism = symkin.load(str(file))
    assert len(symkin.modes(mechanism, pose=[0, 0, -200, 1, 0, 0, 0])) == 8
    assert len(symkin.modes(mechanism, joints=[10, 20, 30])) == 2


def test_a_pose_beyond_the_reach_of_a_tool_on_four_joints_is_not_projected():
    """What joints tie is projected, what they cannot reach is not: a pose turned by little, and one
    that lies too far.
    """
    arm = symkin.load("scara")
    stretched = symkin.solve(
        arm, joints=[20.0, 0.0, *[0.0] * (len(arm.actuated) - 2)]
    ).solution.pose
    bent = symkin.solve(arm, joints=[20.0, 70.0, *[0.0] * (len(arm.actuated) - 2)]).solution.pose
    outward = np.array([*(stretched.position[:2] / np.hypot(*stretched.position[:2])), 0.0])
    for beyond in (1e-3, 1e-5, 1e-7):
        found = symkin.modes(
            arm, pose=symkin.Pose(stretched.position + beyond * outward, stretched.quaternion)
        )
        assert not len(found)
        assert any("lies" in note or "reach" in note for note in found.notes)
    tilted = symkin.Pose(bent.position, bent.quaternion + np.array([0.0, 1e-6, 0.0, 0.0]))
    found = symkin.modes(arm, pose=tilted)
    assert len(found)
    assert any("projected" in note for note in found.notes)


def test_certified_is_false_where_a_proof_was_tried():
    """Of structure groups too, where no mode has a certificate: double ones, and those of redundant
    rows.
    """
    found = symkin.modes(DELTA, given={"motor1": 10.0, "motor2": 20.0, "motor3": 30.0})
    assert len(found)
    assert {mode.certified for mode in found} <= {True, False}
    assert symkin.modes(FOUR_BAR, given={"follower": 53.98553763182445})[0].certified is False


# --- the judgement --------------------------------------------------------------------------------


def parabola(copies: int, misfit: float, size: float, bend: float) -> System:
    """Rows (bend x^2 / size - d) / 2, `copies` of them, which contradict each other by a misfit."""
    x, d = ca.SX.sym("x"), ca.SX.sym("d")
    rows = ca.vertcat(*((bend * x * x / size - d) / 2.0 + k * misfit for k in range(copies)))
    return System((Coordinate("x", "length", "passive"),), x, d, rows, rows, size)


@pytest.mark.parametrize(
    ("size", "bend", "copies"),
    each_once([1e-6, 1.0, 1e3], [0.3, 1.0, 4.0], [1, 2], kept=[(1.0, 0.3, 2), (1e3, 1.0, 1)]),
)
def test_a_parabola_has_two_roots_one_double_one_or_none(size, bend, copies):
    """bend x^2 = d size: two roots for d above rounding, however little, a double one within, none
    below; from any start near.
    """
    system = parabola(copies, 0.0, size, bend)
    starts = size * np.array([-0.3, -1e-2, -1e-5, 2e-9, 3e-7, 2e-4, 0.1])[:, None]
    for share, count in [
        (s * 10.0**-k, 2 if s > 0 else 0) for k in range(3, 14) for s in (1, -1)
    ] + [(0.0, 1), (1e-15, 1)]:
        known = np.array([share * size])
        found = polished_roots(system, starts, known)
        points = found.points[unite(system, found.points, known)[0]]
        assert len(points) == count, share
        assert are_double(system, points, known).tolist() == [count == 1] * count
        if count == 2:
            assert sorted(points[:, 0]) == pytest.approx(
                [s * size * math.sqrt(share / bend) for s in (-1, 1)], rel=1e-2
            )


@pytest.mark.parametrize("misfit", [1e-12, 1e-11, 1e-10])
def test_rows_that_contradict_each_other_are_no_root_beyond_reach(misfit):
    """Two parabolas that differ by digits: two roots well inside, none outside, wherever Newton's
    method stops.
    """
    system, starts = parabola(2, misfit, 1.0, 1.0), np.linspace(-0.3, 0.3, 40)[:, None]
    for d, count in [(1e-3, 2), (1e-2, 2), (-1e-3, 0), (-1e-6, 0), (-1e-8, 0)]:
        found = polished_roots(system, starts, np.array([d]))
        assert len(unite(system, found.points, np.array([d]))[0]) == count
