"""Staying on one mode: branches are those of closed forms, and stops stand where closed forms put them."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import symkin
from helpers.laws import closes, frame, same_angle, same_pose
from helpers.samples import (
    bars,
    circles,
    delta,
    five_bar,
    parallel_rrr,
    pieper,
    readme_five_bar,
    three_rps,
    three_rrr,
    turning,
)
from symkin import InputError, Joint, Limb, Mechanism
from symkin.following.cubic import Cubic
from symkin.following.last_tube import on_plane
from symkin.following.path_system import coefficients, path_systems
from symkin.following.step_certificate import Interval
from symkin.following.track import track
from symkin.following.trajectory import great_circle, make_trajectory
from symkin.position.problem import build_problem

GROUND, CRANK, COUPLER, ROCKER = 100.0, 70.0, 60.0, 50.0
TOGGLE = math.acos((GROUND**2 + CRANK**2 - (COUPLER + ROCKER) ** 2) / (2 * GROUND * CRANK))
"""The crank angle at which coupler and rocker are in line."""


def rocker_angle(angle: float, branch: int) -> float:
    """Angle of the rocker of a four-bar GROUND, CRANK, COUPLER, ROCKER, closed form."""
    b = CRANK * np.array([math.cos(angle), math.sin(angle)])
    c = circles(b, COUPLER, np.array([GROUND, 0.0]), ROCKER)[branch]
    return math.atan2(c[1], c[0] - GROUND)


@pytest.mark.parametrize("motion", ["planar", "spatial"])
def test_four_bar_stops_at_its_toggle(motion):
    """The crank stops within 1e-9 of the angle at which coupler and rocker are in line, and the two modes merge there."""
    found = track(bars(GROUND, CRANK, COUPLER, ROCKER, motion), joints=[[1.0], [2.0]])
    assert found.stop is not None
    assert found.stop.kind == "turning point"
    assert found.stop.type == "type 2"
    assert abs(found.end.actuated[0] - TOGGLE) < 1e-9
    assert found.stop.meeting is not None
    assert {found.stop.meeting.own, *found.stop.meeting.others} == {1, 2}
    assert found.certified == (motion == "planar")
    if found.certified:
        assert found.stop.error is not None
        assert found.stop.error < 1e-9
        assert found.stop.meeting.opposite_signs
        assert "first singularity" in found.ground


def test_slider_crank_stops_at_its_dead_centre():
    """A slider that drives a crank 30 by a rod 80 stops at 110 from the crank's axis."""
    crank, rod, begin = 30.0, 80.0, 1.0
    pin = np.array([crank * math.cos(begin), crank * math.sin(begin)])
    x = pin[0] + math.sqrt(rod**2 - pin[1] ** 2)
    slider = Joint("slide", "P", (x, 0.0, 0.0), (1.0, 0.0, 0.0), actuated=True, zero=x)
    limbs = [
        Limb("crank", [turning("a", 0.0, 0.0), turning("b", *pin)]),
        Limb("slider", [slider, turning("c", x, 0.0)]),
    ]
    mechanism = Mechanism("slider", limbs, platform_position=(x, 0.0, 0.0), motion="planar")
    found = track(mechanism, joints=[[x], [130.0]])
    assert found.stop is not None
    assert found.stop.kind == "turning point"
    assert found.certified
    assert abs(found.end.actuated[0] - (crank + rod)) < 1e-9 * (crank + rod)


def test_three_rrr_stops_where_its_links_meet():
    """At the fold of a planar 3-RRR the lines of its three second links meet in one point (or are parallel)."""
    mechanism = three_rrr("planar")
    q = np.array(symkin.solve(mechanism).solution.actuated_values)
    found = track(mechanism, joints=[q, q + [0.6, 0.78, 0.96]])
    assert found.stop is not None
    assert found.stop.kind == "turning point"
    assert found.certified
    lines = []
    platform = frame(found.end.pose.position, found.end.pose.quaternion)
    for k in range(3):
        towards = math.pi / 2 + 2 * math.pi * k / 3
        base, end = (
            100.0 * np.array([math.cos(towards), math.sin(towards)]),
            30.0 * np.array([math.cos(towards), math.sin(towards)]),
        )
        angle = found.end.joints[f"q{k + 1}"]
        elbow = base + 60.0 * np.array([math.cos(angle), math.sin(angle)])
        tip = (platform @ [*end, 0.0, 1.0])[:2]
        along = (tip - elbow) / 65.0
        lines.append([*along, (tip[0] * along[1] - tip[1] * along[0]) / 100.0])
    assert abs(np.linalg.det(lines)) < 1e-9


def test_hexapod_folds_where_its_legs_depend(zhang):
    """At the fold the six lines of a hexapod's legs are dependent; behind it two modes are lost, and their two mirror images."""
    q = np.array(zhang.example.joints)
    found = track(zhang, joints=[q, q + 60 * (1 + 0.3 * np.arange(6))])
    assert found.stop is not None
    assert found.stop.kind == "turning point"
    assert found.certified
    platform = frame(found.end.pose.position, found.end.pose.quaternion)
    lines = []
    for leg in zhang.limbs:
        tip, foot = (platform @ [*leg.platform, 1.0])[:3], np.array(leg.base)
        along = (tip - foot) / np.linalg.norm(tip - foot)
        lines.append([*along, *(np.cross(foot, along) / zhang.size)])
    singular = np.linalg.svd(np.array(lines), compute_uv=False)
    assert singular[-1] < 1e-10 * singular[0]
    beyond = found.trajectory.at(0, found.stop.u + 1e-4)
    assert found.stop.meeting is not None
    assert len(symkin.modes(zhang, joints=beyond)) == found.stop.meeting.count - 4


@pytest.fixture(scope="module")
def zhang() -> Mechanism:
    return symkin.load("zhang2009")


def test_random_smooth_paths_keep_their_mode(zhang):
    """Along random smooth curves of leg lengths the tracked end is the one of independent small Newton steps, stands in the
    complete enumeration, and every stop is a fold."""
    rng = np.random.default_rng(5)
    system = build_problem(zhang, "direct").system
    for _ in range(20):
        pose = [*rng.uniform(-60, 60, 2), rng.uniform(80, 160), 1.0, *(0.09 * rng.uniform(-1, 1, 3))]
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
        assert sum(same_pose(mode.pose, kept[-1].pose, zhang.size, 1e-7) for mode in every) == 1
        if found.stop is not None:
            assert found.end.smallest_singular_value < 1e-9


def test_near_miss_of_a_flat_position_is_passed():
    """A parallelogram whose coupler is too short by 1e-6 passes its nearly flat position, and its rocker goes on the side that
    the closed form says."""
    coupler = 100.0 - 1e-4
    mechanism = bars(100.0, 40.0, coupler, 40.0)
    found = track(mechanism, joints=[[1.0], [-1.0]])
    assert found.reached
    assert found.certified
    side = []
    for sample in (found.samples[0], found.end):
        angle = sample.actuated_values[0]
        b = 40.0 * np.array([math.cos(angle), math.sin(angle)])
        tips = circles(b, coupler, np.array([100.0, 0.0]), 40.0)
        own = [same_angle(sample.joints["d"] + _rocker_at_reference(coupler), math.atan2(c[1], c[0] - 100.0)) for c in tips]
        assert sum(own) == 1
        side.append(own.index(True))
    assert side[0] == side[1]
    assert min(s.smallest_singular_value for s in found.samples) > 0.0


def _rocker_at_reference(coupler: float) -> float:
    b = 40.0 * np.array([0.5, math.sqrt(0.75)])
    c = circles(b, coupler, np.array([100.0, 0.0]), 40.0)[0]
    return math.atan2(c[1], c[0] - 100.0)


@pytest.mark.parametrize("motion", ["planar", "spatial"])
def test_flat_parallelogram_is_a_bifurcation(motion):
    """A parallelogram four-bar is stopped at its flat position, to 1e-9, and both its modes meet there."""
    found = track(bars(100.0, 40.0, 100.0, 40.0, motion), joints=[[1.0], [-1.0]])
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert found.stop.kinds == (("type 2",) if motion == "planar" else ("type 2", "constraint"))
    assert not found.certified
    assert abs(found.end.actuated[0]) < 1e-9
    assert found.stop.meeting is not None
    assert {found.stop.meeting.own, *found.stop.meeting.others} == {1, 2}


@pytest.mark.parametrize("motion", ["planar", "spatial"])
@pytest.mark.parametrize("samples", [None, 101])
def test_a_path_that_ends_at_a_bifurcation_names_it(motion, samples):
    """The flat position as the last row, the path undivided or in a hundred short intervals."""
    found = track(bars(100.0, 40.0, 100.0, 40.0, motion), joints=[[1.0], [0.0]], samples=samples, name_modes=False)
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert abs(found.end.actuated[0]) < 1e-9


@pytest.mark.parametrize("half", [0.1, 1e-3, 1e-4])
@pytest.mark.parametrize("samples", [None, 101])
def test_bifurcations_on_short_paths_are_named(half, samples):
    """A path of a fraction of a degree through the flat position."""
    found = track(bars(100.0, 40.0, 100.0, 40.0), joints=[[half], [-half]], samples=samples, name_modes=False)
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert abs(found.end.actuated[0]) < 1e-9


@pytest.mark.parametrize("samples", [None, 2, 101, 1001])
def test_joints_that_meet_are_placed_in_intervals_of_any_length(samples):
    """A five-bar whose cranks bring the couplers' lower ends together, where the platform turns freely about them: cranks 100,
    bases 150 apart, cranks at -a and a from upright meet at sin a = 0.75; to 1e-9 rad."""
    found = track(readme_five_bar("planar"), joints=[[-60.0, 60.0], [-40.0, 40.0]], samples=samples, name_modes=False)
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert abs(math.radians(found.end.actuated[1]) - math.asin(0.75)) < 1e-9


@pytest.mark.parametrize("gap", [1e-9, 1e-8, 1e-4])
def test_fold_beside_a_bifurcation_is_placed(gap):
    """A parallelogram whose coupler is too long by a gap folds where coupler and rocker are in line, to 1e-9 of the path."""
    found = track(bars(100.0, 40.0, 100.0 + gap, 40.0), joints=[[1.0], [-1.0]], name_modes=False)
    # 100^2 + 40^2 - 2 100 40 cos q = (60 + gap)^2, written without cancellation
    angle = 2 * math.asin(math.sqrt((120 * gap + gap**2) / 16000.0))
    assert found.stop is not None
    assert found.stop.kind == "turning point"
    assert abs(found.end.actuated[0] - angle) < 1e-9


def test_stop_just_behind_a_sample_stands_behind_it():
    """A toggle a little after a sample of the path is placed there, whatever the sampling."""
    rows = [[TOGGLE - 0.5], [TOGGLE - 1e-4], [TOGGLE + 0.5]]
    found = track(bars(GROUND, CRANK, COUPLER, ROCKER), joints=rows, name_modes=False)
    assert found.stop is not None
    assert found.stop.row == 1
    assert len(found.samples) == 3
    assert abs(found.end.actuated[0] - TOGGLE) < 1e-9


def test_delta_stops_where_its_elbows_coincide():
    """A delta's arms that turn alike bring its rods' ends together, cos q = -(base - platform) / arm, where the platform
    is free on a sphere."""
    found = track(delta(), joints=[[0, 0, 0], [3, 3, 3]])
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert abs(found.end.actuated[0] - math.acos(-0.8)) < 1e-9


def test_limbs_that_turn_together_end_the_workspace():
    """A delta that goes straight away stretches all three arms at once, where arm and rod are in line: the end of the workspace,
    at which the followed one of its eight working modes meets all others."""
    found = track(delta(), poses=[[0, 0, -200, 1, 0, 0, 0], [0, 0, -600, 1, 0, 0, 0]])
    assert found.stop is not None
    assert (found.stop.kind, found.stop.kinds, found.stop.blocks) == ("turning point", ("type 1",), 3)
    assert abs(found.end.pose.position[2] + math.sqrt((100 + 220) ** 2 - 80**2)) < 1e-6
    assert found.stop.meeting is not None
    assert {found.stop.meeting.own, *found.stop.meeting.others} == set(range(1, 9))


def test_one_limb_stops_and_the_others_stand_beside():
    """Where one limb of several ends, the others stand at the same place: all loops are closed there."""
    found = track(delta(), poses=[[0, 0, -150, 1, 0, 0, 0], [90, 10, -350, 1, 0, 0, 0]], name_modes=False)
    assert found.stop is not None
    assert found.stop.blocks == 1
    assert closes(delta(), found.end.solution)


def test_delta_reaches_no_farther_than_arm_and_rod():
    """An inverse path that leaves the workspace stops where a rod is normal to the way of its arm's end."""
    found = track(delta(), poses=[[0, 0, -150, 1, 0, 0, 0], [90, 10, -350, 1, 0, 0, 0]])
    assert found.stop is not None
    assert found.stop.type == "type 1"
    across = []
    for k in range(3):
        towards, q = 2 * math.pi * k / 3, found.end.joints[f"q{k + 1}"]
        outward, down = np.array([math.cos(towards), math.sin(towards), 0.0]), np.array([0.0, 0.0, -1.0])
        tip = (120.0 + 100.0 * math.cos(q)) * outward + 100.0 * math.sin(q) * down
        rod = found.end.pose.position + 40.0 * outward - tip
        assert np.linalg.norm(rod) == pytest.approx(220.0)
        across.append(abs(rod @ (math.cos(q) * down - math.sin(q) * outward)) / 220.0)
    assert min(across) < 1e-9


def test_tube_holds_one_branch_and_not_the_other():
    """The closed form's branch lies in the proved tube at every crank angle of the step, the other branch outside."""
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER)
    problem = build_problem(mechanism, "direct")
    system = path_systems(problem)[0]
    index = [c.name for c in problem.system.unknowns].index("d")
    trajectory = make_trajectory(mechanism, joints=[[1.0], [1.05]])
    interval = Interval(system, coefficients(problem, *trajectory.samples))
    ends = []
    for angle in (1.0, 1.05):
        mode = next(m for m in symkin.modes(mechanism, joints=[angle]) if _on(m.joints["d"], angle, 0))
        ends.append(np.concatenate([np.atleast_1d(mode.values[c.name]) for c in problem.system.unknowns]) / system.scale)
    slopes = [_slope(interval, np.append(z, u)) for z, u in zip(ends, (0.0, 1.0), strict=True)]
    curve = Cubic.hermite(np.append(ends[0], 0.0), slopes[0], np.append(ends[1], 1.0), slopes[1], 1.0)
    tube = interval.tube(curve, np.append(np.zeros(len(ends[0])), 1.0))
    assert tube is not None
    for u in np.linspace(0, 1, 21):
        own, other = (rocker_angle(1.0 + 0.05 * u, k) - rocker_angle(math.pi / 3, 0) for k in (0, 1))
        assert abs(own - curve.at(u)[index]) < tube.half[index] < abs(other - curve.at(u)[index])


def _on(d: float, angle: float, branch: int) -> bool:
    return same_angle(d, rocker_angle(angle, branch) - rocker_angle(math.pi / 3, 0), 1e-6)


def _slope(interval: Interval, y: np.ndarray) -> np.ndarray:
    jacobian = interval.evaluate(y)[1]
    return np.append(-np.linalg.solve(jacobian[:, :-1], jacobian[:, -1]), 1.0)


def test_no_tube_over_a_fold_or_off_the_branch():
    """No tube is proved over crank angles beyond the toggle, nor about a curve that is off the branch."""
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER)
    problem = build_problem(mechanism, "direct")
    system = path_systems(problem)[0]
    mode = symkin.modes(mechanism, joints=[TOGGLE - 1e-3])[0]
    z = np.concatenate([np.atleast_1d(mode.values[c.name]) for c in problem.system.unknowns]) / system.scale
    for end, shift in ((TOGGLE + 1e-3, 0.0), (TOGGLE - 0.99e-3, 0.3)):
        trajectory = make_trajectory(mechanism, joints=[[TOGGLE - 1e-3], [end]])
        interval = Interval(system, coefficients(problem, *trajectory.samples))
        slope = _slope(interval, np.append(z, 0.0))
        a = np.append(z + shift, 0.0)
        curve = Cubic.hermite(a, slope, a + slope, slope, 1.0)
        assert interval.tube(curve, np.append(np.zeros(len(z)), 1.0)) is None


@pytest.mark.parametrize(("path", "folds"), [((TOGGLE - 1e-2, TOGGLE), True), ((TOGGLE, TOGGLE - 1e-2), False)])
def test_curvature_of_the_path_parameter_is_proved_at_a_fold(path, folds):
    """Through the toggle the crank angle has a maximum over the arc of the branch: u curves down where it grows to the
    toggle, and up where it grows away from it."""
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER)
    problem = build_problem(mechanism, "direct")
    system = path_systems(problem)[0]
    trajectory = make_trajectory(mechanism, joints=[[v] for v in path])
    interval = Interval(system, coefficients(problem, *trajectory.samples))
    mode = symkin.modes(mechanism, joints=[TOGGLE - 1e-6])[0]
    z = np.concatenate([np.atleast_1d(mode.values[c.name]) for c in problem.system.unknowns]) / system.scale
    y = np.append(z, (TOGGLE - 1e-6 - path[0]) / (path[1] - path[0]))
    null = np.linalg.svd(interval.evaluate(y)[1][:, :-1])[2][-1]
    direction = np.append(null, 0.0)
    a, b = (on_plane(interval, y + s * direction, direction) for s in (-1e-3, 1e-3))
    curve = Cubic.hermite(*a, *b, float(direction @ (b[0] - a[0])))
    tube = interval.tube(curve, direction)
    assert tube is not None
    assert interval.folds_once(curve, direction, tube) == folds


@pytest.mark.parametrize(
    "mechanism", [five_bar(), three_rrr("planar"), three_rps(), symkin.load("zhao2000")], ids=lambda m: m.name
)
def test_way_back_ends_at_the_start(mechanism):
    """A path and its way back end at the starting configuration; every sample closes all loops."""
    q = np.array(symkin.solve(mechanism).solution.actuated_values)
    step = np.array([mechanism.angle_out(0.1) if c.is_angular else 0.05 * mechanism.size for c in mechanism.actuated])
    found = track(mechanism, joints=[q, q + step, q], samples=9)
    assert found.reached
    assert found.certified == (mechanism.name != "five_bar")
    assert same_pose(found.end.pose, found.samples[0].pose, mechanism.size)
    assert all(closes(mechanism, sample.solution) for sample in found.samples)


def test_whole_turns_are_kept():
    """A crank that turns three times ends where it began, its angle and the passive ones counted on."""
    mechanism = bars(100.0, 30.0, 90.0, 70.0)
    found = track(mechanism, joints=[[1.0], [1.0 + 6 * math.pi]])
    assert found.reached
    assert found.certified
    assert found.end.actuated[0] == pytest.approx(1.0 + 6 * math.pi)
    assert same_pose(found.end.pose, found.samples[0].pose, mechanism.size)


def test_inverse_path_of_an_arm_keeps_its_working_mode():
    """The end of an inverse path of a 6R arm is one of the complete list, and direct kinematics gives its pose."""
    arm = pieper()
    ends = [symkin.solve(arm, joints=[0.1, 0.2, 0.3, 0.4, q5, 0.6]).solution for q5 in (0.5, 0.35)]
    found = track(arm, poses=[e.pose for e in ends], start=ends[0])
    assert found.reached
    assert found.certified
    assert same_pose(symkin.solve(arm, joints=found.end.actuated).solution.pose, ends[1].pose, arm.size)
    every = symkin.modes(arm, pose=ends[1].pose)
    assert sum(all(same_angle(a, b) for a, b in zip(m.actuated, found.end.actuated, strict=True)) for m in every) == 1


def test_arm_stops_stretched_out():
    """Beyond its reach an arm's inverse path stops, of type 1, with its elbow straight."""
    arm = pieper()
    start = symkin.solve(arm, joints=[0.1, 0.2, 0.9, 0.4, 0.5, 0.6]).solution
    beyond = [*(np.asarray(start.position) * 2.5), *start.quaternion]
    found = track(arm, poses=[start.pose, beyond], start=start, name_modes=False)
    assert found.stop is not None
    assert found.stop.kind == "turning point"
    assert found.stop.type == "type 1"
    elbow = math.atan2(90.0, 0.0)  # from the upper arm (along z) to the wrist centre's direction at q3 = 0
    assert same_angle(found.end.joints["q3"] + elbow, 0.0, 1e-6) or same_angle(found.end.joints["q3"] + elbow, math.pi, 1e-6)


def test_limit_is_met_at_its_value_and_may_be_touched():
    """A path that passes a limit stops at it to 1e-9; one that only touches it goes on; limits may be ignored."""
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER, limits=(0.5, 1.2))
    crossing = track(mechanism, joints=[[1.0], [1.3]])
    assert crossing.stop is not None
    assert crossing.stop.kind == "limit"
    assert "crank" in crossing.statement
    assert abs(crossing.end.actuated[0] - 1.2) < 2e-9
    assert track(mechanism, joints=[[1.0], [1.2], [1.0]]).reached
    assert track(mechanism, joints=[[1.0], [1.3]], limits=False).reached
    assert track(mechanism, joints=[[1.25], [1.0]]).stop.kind == "limit"


def test_limits_hold_whole_turns_apart():
    """A crank within its limits but for a whole turn is within them, as in `solve`, and stops a turn beyond the limit."""
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER, limits=(0.5, 1.2))
    turn = 2 * math.pi
    assert track(mechanism, joints=[[1.0 + turn], [1.1 + turn]]).reached
    found = track(mechanism, joints=[[1.0 - turn], [1.3 - turn]])
    assert found.stop is not None
    assert found.stop.kind == "limit"
    assert "whole turn" in found.statement
    assert abs(found.end.actuated[0] - (1.2 - turn)) < 2e-9


def test_joints_of_an_arm_need_no_steps():
    """The pose of an arm is a formula of its joints: samples are those of `solve`, a limit stops them at its value."""
    arm = pieper()
    begin, end = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), np.array([1.1, 0.2, -0.3, 0.4, 2.5, 0.6])
    found = track(arm, joints=[begin, end], samples=5)
    assert found.reached
    assert (found.certified, found.steps) == (True, 0)
    for share, sample in zip(np.linspace(0, 1, 5), found.samples, strict=True):
        assert same_pose(sample.solution.pose, symkin.solve(arm, joints=begin + share * (end - begin)).solution.pose, arm.size)


def test_wrist_that_is_nearly_straight_is_passed():
    """A tool that turns past the fourth axis at 1e-4 rad is followed with a proof; joints 4 and 6 turn by half a turn less
    twice the angle whose tangent is distance over way, and joint 5 is back at its value."""
    arm, way, miss = pieper(), 0.1, 1e-4
    # the wrist's deflection is the angle between axes 4 and 6: joint 5, joint 4 its azimuth
    deflection, azimuth = math.hypot(way, miss), math.atan2(miss, way)
    ends = []
    for turn in (azimuth, math.pi - azimuth):
        ends.append(symkin.solve(arm, joints=[0.1, 0.2, 0.3, turn, deflection, 0.6 - turn]).solution)
    found = track(arm, poses=[e.pose for e in ends], start=ends[0], name_modes=False)
    assert found.reached
    assert found.certified
    assert min(s.smallest_singular_value for s in found.samples) > 0.0
    for a, b in zip(found.end.actuated, ends[1].actuated, strict=True):
        assert same_angle(a, b, 1e-6)


def test_passive_limits_count_within_a_step():
    """A limit of an unknown that is passed and kept again between two samples stops the track."""
    plain = bars(100.0, 30.0, 90.0, 70.0)
    free = track(plain, joints=[[0.0], [2 * math.pi]], samples=60)
    swing = [s.joints["d"] for s in free.samples]
    rocker = replace(plain.limbs[1].joints[0], limits=(min(swing) - 0.1, max(swing) - 0.01))
    limited = replace(plain, limbs=[plain.limbs[0], replace(plain.limbs[1], joints=[rocker, plain.limbs[1].joints[1]])])
    found = track(limited, joints=[[0.0], [2 * math.pi]])
    assert found.stop is not None
    assert found.stop.kind == "limit"
    assert found.stop.limit.name == "d"
    assert abs(found.end.joints["d"] - found.stop.limit.value) < 2e-9


def test_loops_that_open_stop_the_track():
    """A 3-RPS cannot move its platform straight aside: the track ends at once, and says that loops open."""
    mechanism = three_rps()
    pose = symkin.solve(mechanism).solution.pose
    found = track(mechanism, poses=[pose, [*(np.asarray(pose.position) + [30, 0, 0]), *pose.quaternion]])
    assert found.stop is not None
    assert found.stop.kind == "open loops"
    assert found.end.parameter < 1e-6


def test_singular_starts_are_named():
    """A start at a fold, at a bifurcation or on a continuum of solutions is not followed."""
    fold = track(bars(GROUND, CRANK, COUPLER, ROCKER), joints=[[TOGGLE], [1.0]])
    flat = track(bars(100.0, 40.0, 100.0, 40.0), joints=[[0.0], [1.0]], start=[40, 0, 0, 1, 0, 0, 0])
    continuum = track(parallel_rrr("planar"), joints=[[0, 0, 0], [0.1, 0.1, 0.1]])
    nearly = track(bars(100.0, 40.0, 100.0, 40.0), joints=[[0.0], [1.0]])
    for found in (fold, flat, nearly, continuum):
        assert found.stop is not None
        assert found.stop.kind == "singular start"
        assert not found.certified


def test_start_must_lie_on_the_path(zhang):
    """A start mode of other inputs or of another mechanism is refused, naming what differs; whole turns do not matter."""
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER)
    mode = symkin.modes(mechanism, joints=[0.9])[1]
    with pytest.raises(InputError, match=r"crank = 0\.9, the path begins at 1"):
        track(mechanism, joints=[[1.0], [1.1]], start=mode)
    with pytest.raises(InputError, match="bars"):
        track(zhang, joints=[zhang.example.joints], start=mode)
    turned = track(mechanism, joints=[[0.9 + 2 * math.pi], [1.0 + 2 * math.pi]], start=mode)
    assert turned.reached
    assert same_pose(turned.samples[0].pose, mode.pose, mechanism.size)


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
    """cos(u h) a + sin(u h) n is a unit quaternion, a at 0 and b at 1, u h of the half angle away from a."""
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
