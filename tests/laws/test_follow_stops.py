"""Where a track stops: turning points and bifurcations stand where closed forms put them, and loops
that open.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import symkin
from helpers.gate import each_once, in_gate
from helpers.laws import closes, frame, same_angle
from helpers.samples import (
    COUPLER,
    CRANK,
    GROUND,
    ROCKER,
    TOGGLE,
    bars,
    circles,
    delta,
    pieper,
    readme_five_bar,
    three_rps,
    three_rrr,
    turning,
)
from symkin import Joint, Limb, Mechanism, track


@pytest.fixture(scope="module")
def zhang() -> Mechanism:
    return symkin.load("zhang2009")


@pytest.mark.slow
@pytest.mark.parametrize("motion", in_gate(["planar", "spatial"], ["planar"]))
def test_four_bar_stops_at_its_toggle(motion):
    """The crank stops within 1e-9 of the angle at which coupler and rocker are in line, and the two
    modes merge there.
    """
    found = track(bars(GROUND, CRANK, COUPLER, ROCKER, motion), joints=[[1.0], [2.0]])
    assert found.stop is not None
    assert found.stop.kind == "turning point"
    assert found.stop.type == "type 2"
    assert abs(found.end.actuated[0] - TOGGLE) < 1e-9
    assert found.stop.meeting is not None
    assert {found.stop.meeting.own, *found.stop.meeting.others} == {1, 2}
    assert found.certified
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
    """At the fold of a planar 3-RRR the lines of its three second links meet in one point (or are
    parallel).
    """
    mechanism = three_rrr("planar")
    q = np.array(symkin.solve(mechanism).solution.actuated_values)
    found = track(mechanism, joints=[q, q + [0.6, 0.78, 0.96]], name_modes=False)
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
    """At the fold the six lines of a hexapod's legs are dependent; behind it two modes are lost,
    and their two mirror images.
    """
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
        lines.append([*along, *(np.cross(foot, along) / zhang.characteristic_length)])
    singular = np.linalg.svd(np.array(lines), compute_uv=False)
    assert singular[-1] < 1e-10 * singular[0]
    beyond = found.trajectory.at(0, found.stop.u + 1e-4)
    assert found.stop.meeting is not None
    assert len(symkin.modes(zhang, joints=beyond)) == found.stop.meeting.count - 4


def test_near_miss_of_a_flat_position_is_passed():
    """A parallelogram whose coupler is too short by 1e-6 passes its nearly flat position, and its
    rocker goes on the side that the closed form says.
    """
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
        own = [
            same_angle(
                sample.joints["d"] + _rocker_at_reference(coupler), math.atan2(c[1], c[0] - 100.0)
            )
            for c in tips
        ]
        assert sum(own) == 1
        side.append(own.index(True))
    assert side[0] == side[1]
    assert min(s.smallest_singular_value for s in found.samples) > 0.0


def _rocker_at_reference(coupler: float) -> float:
    b = 40.0 * np.array([0.5, math.sqrt(0.75)])
    c = circles(b, coupler, np.array([100.0, 0.0]), 40.0)[0]
    return math.atan2(c[1], c[0] - 100.0)


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["planar", "spatial"])
def test_flat_parallelogram_is_a_bifurcation(motion):
    """A parallelogram four-bar is stopped at its flat position, to 1e-9, and both its modes meet
    there.
    """
    found = track(bars(100.0, 40.0, 100.0, 40.0, motion), joints=[[1.0], [-1.0]])
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    wrenches = () if motion == "planar" else ("constraint",)
    assert found.stop.kinds == ("type 2", "increased", *wrenches)
    assert not found.certified
    assert abs(found.end.actuated[0]) < 1e-9
    assert found.stop.meeting is not None
    assert {found.stop.meeting.own, *found.stop.meeting.others} == {1, 2}


@pytest.mark.parametrize(("motion", "samples"), each_once(["planar", "spatial"], [None, 101]))
def test_a_path_that_ends_at_a_bifurcation_names_it(motion, samples):
    """The flat position as the last row, the path undivided or in a hundred short intervals."""
    found = track(
        bars(100.0, 40.0, 100.0, 40.0, motion),
        joints=[[1.0], [0.0]],
        samples=samples,
        name_modes=False,
    )
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert abs(found.end.actuated[0]) < 1e-9


@pytest.mark.parametrize(("half", "samples"), each_once([0.1, 1e-3, 1e-4], [None, 101]))
def test_bifurcations_on_short_paths_are_named(half, samples):
    """A path of a fraction of a degree through the flat position."""
    found = track(
        bars(100.0, 40.0, 100.0, 40.0), joints=[[half], [-half]], samples=samples, name_modes=False
    )
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert abs(found.end.actuated[0]) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("samples", in_gate([None, 2, 101, 1001], [None, 2, 101]))
def test_joints_that_meet_are_placed_in_intervals_of_any_length(samples):
    """A five-bar whose cranks bring the couplers' lower ends together, where the platform turns
    freely about them: cranks 100, bases 150 apart, cranks at -a and a from upright meet at sin a =
    0.75; to 1e-9 rad.
    """
    found = track(
        readme_five_bar("planar"),
        joints=[[-60.0, 60.0], [-40.0, 40.0]],
        samples=samples,
        name_modes=False,
    )
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert abs(math.radians(found.end.actuated[1]) - math.asin(0.75)) < 1e-9


@pytest.mark.parametrize("gap", in_gate([1e-9, 1e-8, 1e-4], [1e-9, 1e-4]))
def test_fold_beside_a_bifurcation_is_placed(gap):
    """A parallelogram whose coupler is too long by a gap folds where coupler and rocker are in
    line, to 1e-9 of the path.
    """
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


@pytest.mark.slow
def test_delta_stops_where_its_elbows_coincide():
    """A delta's arms that turn alike bring its rods' ends together, cos q = -(base - platform) /
    arm, where the platform is free on a sphere.
    """
    found = track(delta(), joints=[[0, 0, 0], [3, 3, 3]], name_modes=False)
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert abs(found.end.actuated[0] - math.acos(-0.8)) < 1e-9


@pytest.mark.slow
def test_limbs_that_turn_together_end_the_workspace():
    """A delta that goes straight away stretches all three arms at once, where arm and rod are in
    line: the end of the workspace, at which the followed one of its eight working modes meets all
    others.
    """
    found = track(delta(), poses=[[0, 0, -200, 1, 0, 0, 0], [0, 0, -600, 1, 0, 0, 0]])
    assert found.stop is not None
    assert (found.stop.kind, found.stop.kinds, found.stop.blocks) == (
        "turning point",
        ("type 1",),
        3,
    )
    assert abs(found.end.pose.position[2] + math.sqrt((100 + 220) ** 2 - 80**2)) < 1e-6
    assert found.stop.meeting is not None
    assert {found.stop.meeting.own, *found.stop.meeting.others} == set(range(1, 9))


def test_one_limb_stops_and_the_others_stand_beside():
    """Where one limb of several ends, the others stand at the same place: all loops are closed
    there.
    """
    found = track(
        delta(), poses=[[0, 0, -150, 1, 0, 0, 0], [90, 10, -350, 1, 0, 0, 0]], name_modes=False
    )
    assert found.stop is not None
    assert found.stop.blocks == 1
    assert closes(delta(), found.end.solution)


@pytest.mark.slow
def test_delta_reaches_no_farther_than_arm_and_rod():
    """An inverse path that leaves the workspace stops where a rod is normal to the way of its arm's
    end.
    """
    found = track(
        delta(), poses=[[0, 0, -150, 1, 0, 0, 0], [90, 10, -350, 1, 0, 0, 0]], name_modes=False
    )
    assert found.stop is not None
    assert found.stop.type == "type 1"
    across = []
    for k in range(3):
        towards, q = 2 * math.pi * k / 3, found.end.joints[f"q{k + 1}"]
        outward, down = (
            np.array([math.cos(towards), math.sin(towards), 0.0]),
            np.array([0.0, 0.0, -1.0]),
        )
        tip = (120.0 + 100.0 * math.cos(q)) * outward + 100.0 * math.sin(q) * down
        rod = found.end.pose.position + 40.0 * outward - tip
        assert np.linalg.norm(rod) == pytest.approx(220.0)
        across.append(abs(rod @ (math.cos(q) * down - math.sin(q) * outward)) / 220.0)
    assert min(across) < 1e-9


@pytest.mark.slow
def test_arm_stops_stretched_out():
    """Beyond its reach an arm's inverse path stops, of type 1, with its elbow straight."""
    arm = pieper()
    start = symkin.solve(arm, joints=[0.1, 0.2, 0.9, 0.4, 0.5, 0.6]).solution
    beyond = [*(np.asarray(start.position) * 2.5), *start.quaternion]
    found = track(arm, poses=[start.pose, beyond], start=start, name_modes=False)
    assert found.stop is not None
    assert found.stop.kind == "turning point"
    assert found.stop.type == "type 1"
    # from the upper arm (along z) to the wrist centre's direction at q3 = 0
    elbow = math.atan2(90.0, 0.0)
    assert same_angle(found.end.joints["q3"] + elbow, 0.0, 1e-6) or same_angle(
        found.end.joints["q3"] + elbow, math.pi, 1e-6
    )


def test_loops_that_open_stop_the_track():
    """A 3-RPS cannot move its platform straight aside: the track ends at once, and says that loops
    open.
    """
    mechanism = three_rps()
    pose = symkin.solve(mechanism).solution.pose
    found = track(
        mechanism, poses=[pose, [*(np.asarray(pose.position) + [30, 0, 0]), *pose.quaternion]]
    )
    assert found.stop is not None
    assert found.stop.kind == "open loops"
    assert found.end.parameter < 1e-6
