"""`track` along values of coordinates by name, of graphs and of limbs: closure in maximal
coordinates that share nothing with symkin, dead points by elementary geometry, limits of any joint,
files and mistakes.
"""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symkin
from helpers import samples
from helpers.command_line import run, run_json
from helpers.gate import in_gate
from oracle.plain_check import MECHANISMS, plain_gap
from symkin import InputError, Track

PATHS: list[tuple[str, dict[str, Any]]] = [
    ("four_bar", {"crank": [0.0, 360.0]}),
    ("stephenson_six_bar", {"output": [0.0, 20.0]}),
    ("jansen_leg", {"crank": [0.0, 360.0]}),
    ("ankle", {"ankle.1": [0.0, 30.0], "ankle.2": [5.0, -10.0]}),
    ("ankle", {"tilt": [5.0, 20.0], "azimuth": [0.0, 90.0]}),
    ("double_wishbone", {"z": [330.0, 350.0], "rack": 5.0}),
    ("bennett", {"input": [0.0, 360.0]}),
    ("spherical_wrist", {"motor1": [1.0, 20.0], "motor2": 2.0, "motor3": [0.0, 5.0]}),
    ("planetary_gear", {"sun": [0.0, 90.0], "ring": 10.0}),
]


@pytest.mark.parametrize(
    ("name", "given"),
    in_gate(PATHS, [path for path in PATHS if path[0] not in ("jansen_leg", "spherical_wrist")]),
)
def test_every_sample_closes_all_rows_and_has_the_values_of_the_path(
    name: str, given: dict[str, Any]
) -> None:
    """Redundant rows too: on the plain graph's own rows; known values run straight from one end to
    the other.
    """
    found = symkin.track(symkin.load(name), given=given, samples=5)
    assert found.reached
    values = np.array([sample.values for sample in found.samples])
    assert plain_gap(MECHANISMS / f"{name}.toml", found.problem.closure, values) < 1e-9
    for k, sample in enumerate(found.samples):
        for c, ends in given.items():
            wanted = ends[0] + 0.25 * k * (ends[1] - ends[0]) if isinstance(ends, list) else ends
            assert value(sample, c) == pytest.approx(wanted, abs=1e-9)


def value(sample: Any, name: str) -> float:
    """A coordinate in degrees or the length unit."""
    if name in sample.joints:
        return float(sample.joints[name])
    rotation = np.asarray(sample.pose.rotation)
    match name:
        case "tilt":
            return math.degrees(math.acos(rotation[2, 2]))
        case "azimuth":
            return math.degrees(math.atan2(rotation[1, 2], rotation[0, 2]))
    return float(np.asarray(sample.pose.position)["xyz".index(name)])


@pytest.mark.parametrize(
    "name", in_gate(["four_bar", "jansen_leg", "bennett"], ["four_bar", "bennett"])
)
def test_joints_go_on_over_whole_turns(name: str) -> None:
    """Between samples of 10 degrees no joint jumps, those at which loops are cut included; all are
    as many degrees on after a turn as they turned.
    """
    mechanism = symkin.load(name)
    found = symkin.track(mechanism, given={mechanism.actuated[0].name: [0.0, 360.0]}, samples=37)
    joints = np.array([list(sample.joints.values()) for sample in found.samples])
    assert list(found.samples[0].joints) == [c.name for c in mechanism.coordinates]
    assert np.abs(np.diff(joints, axis=0)).max() < 60.0
    turns = (joints[-1] - joints[0]) / 360.0
    assert turns == pytest.approx(np.round(turns), abs=1e-9)


def test_gears_turn_on_evenly() -> None:
    """Two turns of the sun: every gear's angle runs straight."""
    found = symkin.track(
        symkin.load("planetary_gear"), given={"sun": [0.0, 720.0], "ring": [0.0, 10.0]}, samples=9
    )
    angles = np.array([list(sample.joints.values()) for sample in found.samples])
    assert np.abs(np.diff(angles, 2, axis=0)).max() < 1e-9
    assert np.abs(angles[-1]).max() == pytest.approx(720.0)


def test_the_grounds_of_square_and_redundant_rows() -> None:
    """A path of as many rows as unknowns is proved, and one of redundant rows that follow from
    others.
    """
    square, redundant = (
        symkin.track(symkin.load(n), given={j: [0.0, 40.0]})
        for n, j in (("four_bar", "crank"), ("bennett", "input"))
    )
    assert (square.certified, redundant.certified) == (True, True)
    assert "follow from the others" not in square.ground
    assert "follow from the others" in redundant.ground


# --- where it stops -------------------------------------------------------------------------------


def dead_point(sign: float) -> float:
    """Angle of the four-bar's follower where crank 40 and coupler 101 are in line, by the cosine
    theorem: the triangle of base 110, rocker 61 and 101 +- 40; from the reference, at which the
    rocker points to (-11, 60).
    """
    far = 101.0 + sign * 40.0
    inner = math.acos((110.0**2 + 61.0**2 - far**2) / (2.0 * 110.0 * 61.0))
    return math.degrees(math.pi - inner - math.atan2(60.0, -11.0))


def test_a_four_bar_driven_by_its_follower_stops_at_the_cranks_dead_point() -> None:
    found = symkin.track(symkin.load("four_bar"), given={"follower": [0.0, -60.0]})
    assert found.stop is not None
    assert (found.stop.kind, found.stop.type, found.stop.kinds) == (
        "turning point",
        "type 2",
        ("type 2",),
    )
    assert found.end.joints["follower"] == pytest.approx(dead_point(1.0), abs=1e-9)
    assert found.certified
    assert found.stop.meeting is not None
    assert (found.stop.meeting.count, {found.stop.meeting.own, *found.stop.meeting.others}) == (
        2,
        {1, 2},
    )
    assert found.stop.meeting.opposite_signs is True
    assert [group.loops for group in found.stop.groups] == [
        ("crank, crank_pin, follower_pin, follower",)
    ]


@pytest.mark.parametrize(("end", "reach"), [(130.0, 125.0), (40.0, 45.0)])
def test_a_slider_crank_driven_by_its_piston_stops_at_its_dead_points(
    end: float, reach: float
) -> None:
    """Crank 40 and rod 85 in line: 85 +- 40."""
    found = symkin.track(symkin.load("slider_crank"), given={"piston": [75.0, end]})
    assert found.end.joints["piston"] == pytest.approx(reach, abs=1e-9)
    assert found.stop is not None
    assert found.stop.kinds == ("type 2",)


def test_a_six_bars_second_dyad_stops_alone() -> None:
    """Fifth and output link, at right angles at the reference, are in line at the stop; the crank's
    own loop is not named.
    """
    found = symkin.track(symkin.load("stephenson_six_bar"), given={"crank": [0.0, 60.0]})
    assert found.end.joints["output_pin"] == pytest.approx(-90.0, abs=1e-6)
    assert found.stop is not None
    (group,) = found.stop.groups
    listed = symkin.modes(symkin.load("stephenson_six_bar"), given={"crank": 0.0})
    assert group.unknowns == listed.groups[group.number].unknowns == ("output", "output_pin")
    assert group.loops == ("crank, crank_pin, coupler_pin, output_pin, output",)
    assert "block 1 (output, output_pin)" in str(found.stop)


def test_a_bifurcation_of_a_redundant_loop_is_found() -> None:
    """Sarrus: the first chain's links fold onto each other where the lower one is level, 3-4-5 from
    the reference.
    """
    found = symkin.track(symkin.load("sarrus"), given={"foot_x": [30.0, 40.0]}, name_modes=False)
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"
    assert found.end.joints["foot_x"] == pytest.approx(
        math.degrees(math.atan2(60.0, 80.0)), abs=1e-6
    )
    assert "increased" in found.stop.kinds


@pytest.mark.parametrize(
    ("step", "count"),
    [pytest.param((100.0, 30.0, -300.0), 1, marks=pytest.mark.long), ((0.0, 0.0, -300.0), 3)],
)
def test_a_path_of_poses_stops_where_motors_are_at_dead_points(
    step: tuple[float, ...], count: int
) -> None:
    """A delta lowered as far as an arm reaches, or straight down, as far as all three do: type 1,
    and each motor's own block and loops.
    """
    mechanism = symkin.load("delta_parallelograms")
    here = symkin.solve(mechanism).solution
    assert here is not None
    found = symkin.track(
        mechanism,
        poses=[here.pose, [*(here.position + np.array(step)), *here.quaternion]],
        start=here,
    )
    assert found.stop is not None
    assert (found.stop.kind, found.stop.type) == ("turning point", "type 1")
    assert "type 1" in found.stop.kinds
    assert [len(group.unknowns) for group in found.stop.groups] == [1] * count
    assert found.stop.meeting is not None
    assert len(found.stop.meeting.others) == 2**count - 1
    for group in found.stop.groups:
        assert any(group.unknowns[0] in loop.split(", ") for loop in group.loops)


def limited(tmp_path: Path, joint: str, low: float, high: float) -> symkin.Mechanism:
    """The four-bar with limits of one joint."""
    text = (MECHANISMS / "four_bar.toml").read_text()
    head, tail = text.split(f'name = "{joint}"\n')
    path = tmp_path / "limited.toml"
    path.write_text(f'{head}name = "{joint}"\nlimits = [{low}, {high}]\n{tail}')
    return symkin.load(path)


@pytest.mark.parametrize("joint", ["crank", "crank_pin", "follower_pin", "follower"])
def test_limits_of_any_joint_stop_the_path(tmp_path: Path, joint: str) -> None:
    """Known, unknown or cut: the path ends where the joint meets the value that it has at 30
    degrees more, and goes on without limits.
    """
    free = symkin.track(symkin.load("four_bar"), given={"crank": [90.0, 120.0, 150.0]})
    values = [sample.joints[joint] for sample in free.samples]
    mechanism = limited(tmp_path, joint, *sorted((2 * values[0] - values[1], values[1])))
    found = symkin.track(mechanism, given={"crank": [90.0, 150.0]})
    assert found.stop is not None
    assert (found.stop.kind, found.stop.limit.name) == ("limit", joint)  # type: ignore[union-attr]
    assert found.end.joints["crank"] == pytest.approx(120.0, abs=1e-5)
    assert symkin.track(mechanism, given={"crank": [90.0, 150.0]}, limits=False).reached


def test_loops_that_close_to_a_files_digits_are_followed_by_least_squares(tmp_path: Path) -> None:
    """A Bennett loop with a point off by 0.0003: its joints move as those of the exact one, to that
    misfit, and it is said.
    """
    exact = (MECHANISMS / "bennett.toml").read_text()
    (tmp_path / "off.toml").write_text(
        exact.replace("[20.0, 50.0, -20.0]", "[20.0003, 50.0001, -20.0002]")
    )
    given = {"input": [10.0, 40.0]}
    mechanism = symkin.load(tmp_path / "off.toml")
    found, true = (
        symkin.track(m, given=given, samples=3) for m in (mechanism, symkin.load("bennett"))
    )
    assert found.reached
    assert 1e-6 < found.residual < 1e-2
    for a, b in zip(found.samples, true.samples, strict=True):
        assert list(a.joints.values()) == pytest.approx(list(b.joints.values()), abs=1e-2)
    assert "close only to the digits" in found.ground
    assert not found.certified
    bound = float(found.ground.split("no other row is more than ")[1].split()[0])
    assert 0.1 * found.residual < bound < 10.0 * found.residual
    assert any("least squares" in note for note in found.trajectory.notes)
    here = symkin.singularity(found.end.solution, given=["input"])
    assert (here.kinds, here.generic.freedoms) == ((), 1)


def test_a_track_travels(tmp_path: Path) -> None:
    """Pickled and read again, with a closure that holds a joint for its limits: the same samples,
    stop and distances.
    """
    found = symkin.track(
        limited(tmp_path, "follower_pin", -170.0, 30.0), given={"crank": [60.0, 90.0]}, samples=3
    )
    again = pickle.loads(pickle.dumps(found))
    assert again.problem.closure.partition == found.problem.closure.partition
    assert again.to_dict() == found.to_dict()
    assert again.end.solution.joints == found.end.solution.joints


# --- starts and forms of the path -----------------------------------------------------------------


def test_start_chooses_the_mode() -> None:
    """Each mode of the four-bar, and values by name near it, lead along its own branch; both
    coupler sides end apart.
    """
    mechanism = symkin.load("four_bar")
    listed = symkin.modes(mechanism, given={"crank": 60.0})
    ends = [
        symkin.track(mechanism, given={"crank": [60.0, 100.0]}, start=mode).end.joints["follower"]
        for mode in listed
    ]
    assert len({round(end, 3) for end in ends}) == 2
    named = [{"follower": mode.joints["follower"]} for mode in listed]
    again = [
        symkin.track(mechanism, given={"crank": [60.0, 100.0]}, start=near).end.joints["follower"]
        for near in named
    ]
    assert again == pytest.approx(ends)


def test_a_mode_of_other_coordinates_is_a_start(tmp_path: Path) -> None:
    """A solution of the crank's value starts a path of the follower's, with limits that make the
    closure hold other joints.
    """
    mechanism = limited(tmp_path, "follower_pin", -170.0, 170.0)
    begin = symkin.solve(mechanism, given={"crank": 60.0}).solution
    assert begin is not None
    follower = begin.joints["follower"]
    found = symkin.track(mechanism, given={"follower": [follower, follower - 5.0]}, start=begin)
    assert found.samples[0].joints["crank"] == pytest.approx(60.0)
    with pytest.raises(InputError, match="the path begins at"):
        symkin.track(mechanism, given={"follower": [follower + 1.0, follower]}, start=begin)


def test_joints_and_poses_of_a_graph_are_values_by_name() -> None:
    """Rows of actuated joints, the same columns by name; poses lead back to the joints."""
    mechanism = symkin.load("delta_parallelograms")
    rows = [[0.0, 0.0, 0.0], [10.0, -5.0, 3.0]]
    by_rows = symkin.track(mechanism, joints=rows)
    columns = {c.name: [row[k] for row in rows] for k, c in enumerate(mechanism.actuated)}
    by_name = symkin.track(mechanism, given=columns)
    assert [s.joints for s in by_rows.samples] == [s.joints for s in by_name.samples]
    back = symkin.track(mechanism, poses=[sample.pose for sample in by_rows.samples])
    assert back.trajectory.kind == "inverse"
    assert back.end.actuated_values == pytest.approx(rows[1], abs=1e-6)


def test_all_joints_of_limbs_by_name_are_the_direct_problem() -> None:
    """The same samples, JSON keys and kind as rows of joints."""
    mechanism = symkin.load("zhao2000")
    ends = [[81.6, 202.8, 330.6, 105.2], [83.0, 202.8, 330.6, 105.2]]
    named = {c.name: [row[k] for row in ends] for k, c in enumerate(mechanism.actuated)}
    one, two = (
        symkin.track(mechanism, joints=ends).to_dict(),
        symkin.track(mechanism, given=named).to_dict(),
    )
    assert one | {"elapsed_s": 0} == two | {"elapsed_s": 0}


def test_limbs_follow_coordinates_of_the_pose() -> None:
    """A 3-RPS by height, azimuth and tilt: the legs at the end lead back to that pose."""
    mechanism = samples.three_rps()
    size = mechanism.characteristic_length
    path = {"z": [300.0, 320.0], "azimuth": [0.3, 0.8], "tilt": [0.1, 0.2]}
    found = symkin.track(mechanism, given=path, samples=4)
    assert found.reached
    for k, sample in enumerate(found.samples):
        rotation = np.asarray(sample.pose.rotation)
        assert float(np.asarray(sample.pose.position)[2]) == pytest.approx(
            300.0 + 20.0 * k / 3, abs=1e-9 * size
        )
        assert math.acos(rotation[2, 2]) == pytest.approx(0.1 + 0.1 * k / 3, abs=1e-9)
        near = symkin.solve(mechanism, joints=sample.actuated_values, start=sample.pose).solution
        assert near is not None
        assert np.allclose(near.position, np.asarray(sample.pose.position), atol=1e-7 * size)


def test_a_chain_without_loops_is_followed() -> None:
    """All joints given: nothing is left to find."""
    joints = [
        symkin.LinkJoint(
            symkin.Joint("a", "R", [0, 0, 0], [0, 0, 1], actuated=True), ["base", "one"]
        ),
        symkin.LinkJoint(
            symkin.Joint("b", "R", [10, 0, 0], [0, 0, 1], actuated=True), ["one", "two"]
        ),
    ]
    point = symkin.LinkPoint("two", "tip", [20, 0, 0])
    mechanism = symkin.Mechanism("chain", link_joints=joints, link_points=[point])
    found = symkin.track(mechanism, given={"a": [0.0, math.pi / 2], "b": [0.0, math.pi / 2]})
    assert found.reached
    assert found.end.points["tip"] == pytest.approx([-10.0, 10.0, 0.0])


# --- files, pictures, mistakes --------------------------------------------------------------------


def test_command_writes_what_it_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A path of pitch and roll; its file, read by the motors' columns, leads back to pitch and
    roll.
    """
    one, two, picture = (str(tmp_path / name) for name in ("one.csv", "two.csv", "track.png"))
    there = ["--given", "ankle.1=0:20,ankle.2=5", "--samples", "6", "-o", one, "--plot", picture]
    status, first = run_json(capsys, "track", "ankle", *there)
    assert (status, first["problem"], first["given"]["from"]) == (
        0,
        "given",
        {"ankle.1": 0.0, "ankle.2": 5.0},
    )
    assert Path(picture).stat().st_size > 1000
    assert set(first["samples"][0]["points"]) == {"toe", "heel"}
    status, second = run_json(capsys, "track", "ankle", "--csv", one, "-o", two)
    assert (status, second["problem"]) == (0, "direct")
    _, third = run_json(capsys, "track", "ankle", "--csv", one, "--given", "ankle.1,ankle.2")
    for again in (second, third):
        for a, b in zip(first["samples"], again["samples"], strict=True):
            assert list(a["joints"].values()) == pytest.approx(list(b["joints"].values()), abs=1e-7)


def test_tilt_is_written_and_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Angles of the pose along which the path is told have columns of their own."""
    path = str(tmp_path / "t.csv")
    given = ["--from", "azimuth=10,tilt=5", "--to", "azimuth=30,tilt=12"]
    _, first = run_json(capsys, "track", "ankle", *given, "--samples", "4", "-o", path)
    _, again = run_json(capsys, "track", "ankle", "--csv", path, "--given", "azimuth,tilt")
    for a, b in zip(first["samples"], again["samples"], strict=True):
        assert list(a["joints"].values()) == pytest.approx(list(b["joints"].values()), abs=1e-7)


def test_a_stop_names_block_and_loop(capsys: pytest.CaptureFixture[str]) -> None:
    """Status 3; JSON and text name the block that is singular and its loop; there is no pose
    without a platform.
    """
    status, found = run_json(
        capsys, "track", "four_bar", "--given", "follower=0:-60", "--samples", "3"
    )
    assert status == 3
    (block,) = found["stop"]["blocks"]
    assert (block["number"], block["loops"]) == (0, ["crank, crank_pin, follower_pin, follower"])
    assert found["samples"][0]["pose"] is None
    status, out, _ = run(capsys, "track", "four_bar", "--given", "follower=0:-60", "--samples", "3")
    assert "of loop crank, crank_pin, follower_pin, follower" in out
    assert "four_bar, given follower" in out


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["four_bar", "--given", "folower=0:60"], "do you mean 'follower'?"),
        (["four_bar", "--given", "crank=0"], "nothing moves"),
        (["four_bar", "--given", "crank"], "has no values"),
        (["four_bar", "--given", "crank=0:1:2"], "is no range"),
        (["ankle", "--given", "ankle.1=0:1,ankle.2=0", "--poses"], "both --given and --poses"),
        (["four_bar", "--given", "crank=0:x"], "--given: crank = 'x' is not a number"),
        (["four_bar", "--given", "crank=0:1,crank=2"], "given twice"),
        (["four_bar", "--given", "crank=0:60", "--from", "1"], "give one of them"),
        (["four_bar", "--given", "crank=0:60,follower=0:5"], "leave"),
        (["ankle", "--given", "ankle.1=0:10"], "1 freedom"),
        (["four_bar", "--from", "follower=0", "--to", "crank=3"], "stands in one of them only"),
        (
            ["four_bar", "--poses", "--from", "0,0,0,1,0,0,0", "--to", "1,0,0,1,0,0,0"],
            "no platform link",
        ),
        (["triad", "--from", "1", "--to", "2"], "0 actuated joints"),
    ],
)
def test_mistakes_are_one_line(
    capsys: pytest.CaptureFixture[str], arguments: list[str], part: str
) -> None:
    status, out, err = run(capsys, "track", *arguments)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert part in err


@pytest.mark.parametrize(
    ("given", "part"),
    [
        ({"crank": [0.0, 1.0], "follower": [1.0]}, "different counts"),
        ({"crank": 3.0}, "every value stands alone"),
        ({"crank": []}, "no samples"),
        ([0.0, 1.0], "columns of values by name"),
        ({"crank": [0.0, math.nan]}, "sample 2"),
    ],
)
def test_columns_that_do_not_fit_are_refused(given: Any, part: str) -> None:
    with pytest.raises(InputError, match=part):
        symkin.track(symkin.load("four_bar"), given=given)


def test_loops_that_cannot_close_are_no_start() -> None:
    """A follower beyond its reach: status of no start, and the reason."""
    found: Track = symkin.track(symkin.load("four_bar"), given={"follower": [90.0, 100.0]})
    assert found.stop is not None
    assert found.stop.kind == "no start"
    assert "closure error" in str(found.stop)


def test_a_screw_takes_steps_of_its_own_size() -> None:
    """Screws of 2 mm a turn make 6 rad while the finger makes 0.02: steps are as long as their
    turns allow, a tenth of a radian, and not as the pitch over the machine's size; the screws'
    advance is what both fingers' tips move apart."""
    path = Path(__file__).parents[1] / "data" / "models" / "sdf" / "pr2_gripper.sdf"
    found = symkin.track(
        symkin.load(path), given={"r_gripper_l_finger_joint": [0.0, 0.02]}, samples=5
    )
    assert found.reached
    first, last = (found.samples[k].joints for k in (0, -1))
    left, right = (
        last[f"r_gripper_{side}_screw_screw_joint"] - first[f"r_gripper_{side}_screw_screw_joint"]
        for side in "lr"
    )
    assert found.steps < 20 * abs(left)
    advance = 0.001999995323140943 * (abs(left) + abs(right)) / (2 * math.pi)
    assert abs(last["r_gripper_joint"] - first["r_gripper_joint"]) == pytest.approx(advance)
