"""Modes and single configurations of graphs for values by name: counts of the gallery, closure in
maximal coordinates that share nothing with symkin, command line, JSON and mistakes.
"""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers import samples
from helpers.command_line import run, run_json
from helpers.gate import in_gate
from helpers.inside import build_closure, build_problem, start_store
from helpers.shipped import TWELVE
from oracle.plain_check import MECHANISMS, plain_gap
from symkin import Joint, LinkJoint, Mechanism, Modes

GALLERY = json.loads((Path(__file__).parents[1] / "data" / "gallery.json").read_text())
CASES = [(name, k) for name, entry in GALLERY.items() for k in range(len(entry["cases"]))]
FEW = [
    (name, 0) for name in TWELVE if name in GALLERY and name not in ("sarrus", "spherical_wrist")
]
FEW += [("stephenson_six_bar", 2)]
"""Cases that the gate runs: of each kind of linkage, by joints that are actuated and by others."""
SIX_DIGITS = """
format = 1
name = "nearly_bennett"
length_unit = "mm"
angle_unit = "deg"
[[joint]]
name = "input"
type = "R"
links = ["base", "crank"]
point = [60, 0, 20]
axis = [-10, 4, 15]
actuated = true
[[joint]]
name = "crank_pin"
type = "R"
links = ["crank", "coupler"]
point = [20.0003, 50.0001, -20.0002]
axis = [0, 4, 5]
[[joint]]
name = "rocker_pin"
type = "R"
links = ["coupler", "rocker"]
point = [-60, 0, 20]
axis = [10, -4, 15]
[[joint]]
name = "output"
type = "R"
links = ["base", "rocker"]
point = [-20, -50, -20]
axis = [0, -4, 5]
"""


@lru_cache(maxsize=64)
def found_modes(name: str, k: int) -> Modes:
    return symkin.modes(symkin.load(name), given=GALLERY[name]["cases"][k]["given"])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "k"), in_gate(CASES, FEW))
def test_every_case_of_the_gallery_has_its_modes(name: str, k: int) -> None:
    """As many as an independent solver finds; each has the given values and closes the plain
    graph's own rows.
    """
    case, found = GALLERY[name]["cases"][k], found_modes(name, k)
    assert len(found) == case["count"]
    if len(found):
        closure = build_closure(found.problem.mechanism, found.problem.closure.partition)
        assert (
            plain_gap(
                MECHANISMS / f"{name}.toml", closure, np.array([mode.variables for mode in found])
            )
            < 1e-8
        )
    for mode in found:
        for given, value in case["given"].items():
            if given in mode.joints:
                assert mode.joints[given] == pytest.approx(value)
            elif given in ("x", "y", "z"):
                assert mode.position["xyz".index(given)] == pytest.approx(value)


@pytest.mark.parametrize(
    "name",
    in_gate(
        [
            "four_bar",
            "stephenson_six_bar",
            "ankle",
            "double_wishbone",
            "klann_leg",
            "excavator_bucket",
        ],
        ["four_bar", "stephenson_six_bar", "ankle"],
    ),
)
def test_any_coordinate_given_back_has_the_mode_among_its_modes(name: str) -> None:
    """Values of other coordinates of a mode, as many as the mobility, lead to a set of modes that
    holds it.
    """
    mechanism = symkin.load(name)
    reference = symkin.solve(mechanism).solution
    assert reference is not None
    count = len(mechanism.actuated)
    scalars = [
        n
        for n, v in reference.joints.items()
        if isinstance(v, float) and n not in {c.name for c in mechanism.actuated}
    ]
    moved = {
        c.name: v + 4.0 for c, v in zip(mechanism.actuated, reference.actuated_values, strict=True)
    }
    for mode in list(symkin.modes(mechanism, joints=moved))[:2]:
        for chosen in (scalars[:count], scalars[-count:]):
            given = {n: mode.joints[n] for n in chosen}
            try:
                back = symkin.modes(mechanism, given=given)
            except symkin.InputError as error:
                assert "freedom" in str(error) or "mobility" in str(error)  # noqa: PT017 - these do not decide a configuration
                continue
            gaps = [
                max(
                    abs(np.exp(1j * np.radians(other.joints[n] - mode.joints[n])) - 1.0)
                    for n in scalars
                    if isinstance(mode.joints[n], float)
                )
                for other in back
            ]
            assert min(gaps) < 1e-5


@pytest.mark.parametrize("name", in_gate(GALLERY, TWELVE))
def test_solve_reaches_a_mode_near_its_start(name: str) -> None:
    """The configuration of the first case closes and has the given values; started there, it is
    found again in few steps.
    """
    mechanism, given = symkin.load(name), GALLERY[name]["cases"][0]["given"]
    first = symkin.solve(mechanism, given=given).solution
    assert first is not None
    assert first.residual < 1e-9 * mechanism.characteristic_length
    assert {n: first.joints[n] for n in given if n in first.joints} == pytest.approx(
        {n: v for n, v in given.items() if n in first.joints}
    )
    start = {n: v for n, v in first.joints.items() if isinstance(v, float)}
    again = symkin.solve(mechanism, given=given, start=start)
    assert again.solution is not None
    assert again.solution.joints == {n: pytest.approx(v, abs=1e-6) for n, v in first.joints.items()}
    if len(start) >= GALLERY[name]["mobility"]:  # joints alone tell the configuration
        assert again.iterations <= 2


def test_starts_choose_the_assembly() -> None:
    """From the joints of each mode of a four-bar the same mode is found, whichever joint is
    given.
    """
    mechanism = symkin.load("four_bar")
    for mode in symkin.modes(mechanism, given={"crank": 50.0}):
        for name in mode.joints:
            start = {n: v for n, v in mode.joints.items() if n != name}
            found = symkin.solve(mechanism, given={name: mode.joints[name]}, start=start).solution
            assert found is not None
            assert found.joints == pytest.approx(mode.joints, abs=1e-6)


def test_fewer_values_lead_near_the_start_and_say_so() -> None:
    """With nothing but one of two coordinates given, the other stays near the start's."""
    mechanism = symkin.load("ankle")
    found = symkin.solve(mechanism, given={"ankle.1": 10.0}, start={"ankle.1": 9.0, "ankle.2": 4.0})
    assert found.solution is not None
    assert found.solution.joints["ankle.1"] == pytest.approx(10.0)
    assert found.solution.joints["ankle.2"] == pytest.approx(4.0, abs=0.5)
    assert any("1 of the 2 coordinates" in note for note in found.notes)


def test_loops_that_close_only_to_the_digits_of_a_file_have_configurations(tmp_path: Path) -> None:
    """A Bennett linkage whose joint is off by 0.3 um is rigid, strictly speaking: the misfit is
    told, and the configuration is that of the exact linkage to as many digits.
    """
    path = tmp_path / "nearly_bennett.toml"
    path.write_text(SIX_DIGITS)
    exact = symkin.solve(symkin.load("bennett"), given={"input": 40.0}).solution
    assert exact is not None
    solved = symkin.solve(symkin.load(path), given={"input": 40.0})
    listed = symkin.modes(symkin.load(path), given={"input": 40.0})
    others = [
        symkin.solve(symkin.load(path), given={"input": 40.0}, solver=name)
        for name in ("ipopt", "fast_newton")
    ]
    results = [(one.solution, one.notes) for one in (solved, *others)]
    for found, notes in (*results, (listed[0], listed.notes)):
        assert found is not None
        assert 1e-6 < found.residual < 1e-2
        assert found.joints == pytest.approx(exact.joints, abs=1e-2)
        assert any("close only to" in note and "mm" in note for note in notes)
    assert len(listed) == GALLERY["bennett"]["cases"][0]["count"]
    assert listed.completeness == "sampled"


def test_values_out_of_reach_have_no_configuration() -> None:
    """The rocker of a crank-rocker does not turn fully: beyond its range nothing closes, and the
    error that is left is told.
    """
    mechanism = symkin.load("four_bar")
    low = [len(symkin.modes(mechanism, given={"follower": float(v)})) for v in range(-180, 180, 30)]
    out = float(range(-180, 180, 30)[low.index(0)])
    result = symkin.solve(mechanism, given={"follower": out}, check=False)
    assert (result.solution, result.status) == (None, "infeasible")
    assert result.smallest_residual is not None
    assert result.smallest_residual > 1.0
    with pytest.raises(symkin.SolveError, match="infeasible"):
        symkin.solve(mechanism, given={"follower": out})


# --- results --------------------------------------------------------------------------------------


def test_json_of_modes(capsys: pytest.CaptureFixture[str]) -> None:
    """Contract: pose null without a platform, points, given by name, blocks in the order of
    solution, counts.
    """
    status, data = run_json(capsys, "modes", "four_bar", "--given", "follower=20")
    assert status == 0
    assert (data["problem"], data["given"], data["poses"]) == ("given", {"follower": 20.0}, None)
    assert data["count"] == data["listed"] == len(data["modes"]) == 2
    assert all(mode["pose"] is None and mode["points"] == {} for mode in data["modes"])
    assert list(data["modes"][0]["joints"]) == ["crank", "crank_pin", "follower_pin", "follower"]
    status, data = run_json(capsys, "modes", "klann_leg", "--joints", "crank=100")
    assert data["problem"] == "direct"
    assert [block["count"] for block in data["blocks"]] == [2, 2]
    assert sorted(n for block in data["blocks"] for n in block["unknowns"]) != []
    assert set(data["blocks"][0]) == {"name", "unknowns", "complex_count", "count", "completeness"}
    for mode in data["modes"]:
        assert len(mode["pose"]["position"]) == len(mode["points"]["foot"]) == 3


def test_a_structure_without_actuated_joints_is_given_nothing(
    capsys: pytest.CaptureFixture[str],
) -> None:
    status, data = run_json(capsys, "modes", "triad")
    assert (status, data["count"], data["given"]) == (0, GALLERY["triad"]["cases"][0]["count"], {})


def test_the_pose_as_a_whole_is_one_of_the_values(capsys: pytest.CaptureFixture[str]) -> None:
    """--given pose=... is --pose, for a graph and for limbs; beside other values it stands as one
    of them.
    """
    pose = "0,0,0,0.96592582628,0,0,0.25881904510"
    for name, numbers in (("spherical_wrist", pose), ("zhang2009", "10,5,300,1,0,0,0")):
        answers = [
            run_json(capsys, "solve", name, *option)
            for option in (("--pose", numbers), ("--given", f"pose={numbers}"))
        ]
        for _, data in answers:
            del data["elapsed_s"]
            assert data["problem"] == "inverse"
        assert answers[0] == answers[1]


def test_all_actuated_joints_by_name_are_the_direct_problem_of_limbs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    answers = [
        run_json(
            capsys, "modes", "zhao2000", option, "theta1=81.6,theta2=202.8,theta3=330.6,op=105.2"
        )[1]
        for option in ("--joints", "--given")
    ]
    for data in answers:
        del data["elapsed_s"]
    assert answers[0] == answers[1]


def test_tables_name_joints_and_points(capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = run(capsys, "modes", "klann_leg", "--given", "crank=100", "--all")
    assert "foot.x [mm]" in out
    assert "upper_pivot [deg]" in out
    _, out, _ = run(capsys, "solve", "four_bar", "--given", "follower=20")
    assert "x [mm]" not in out
    assert "crank [deg]" in out


def test_limits_of_a_cut_joint_count(tmp_path: Path) -> None:
    """Whichever joint a loop is cut at, a mode outside a joint's limits is said to be."""
    text = (MECHANISMS / "four_bar.toml").read_text()
    for name in ("crank_pin", "follower_pin", "follower"):
        path = tmp_path / f"{name}.toml"
        path.write_text(
            text.replace(f'name = "{name}"\n', f'name = "{name}"\nlimits = [-30, 30]\n')
        )
        for mode in symkin.modes(symkin.load(path), given={"crank": 60.0}):
            assert mode.within_limits == (-30 <= mode.joints[name] <= 30)


# --- mistakes -------------------------------------------------------------------------------------

MISTAKES = [
    (["modes", "ankle", "--given", "ankle.1=10"], ["1 freedom", "give 1 more"]),
    (
        ["modes", "ankle", "--given", "ankle.1=10,ankle.2=5,upper_motor=3"],
        ["mobility is 2", "upper_motor", "leave it out"],
    ),
    (
        ["solve", "ankle", "--given", "ankle.1=10,ankle.2=5,upper_motor=3"],
        ["mobility is 2", "upper_motor"],
    ),
    (
        ["solve", "ankle", "--given", "upper_moter=10"],
        ["'upper_moter'", "do you mean 'upper_motor'?"],
    ),
    (["modes", "ankle", "--given", "10"], ["'10'", "NAME=VALUE"]),
    (["modes", "ankle", "--given", "ankle.1=10,5"], ["'5'", "NAME=VALUE"]),
    (["modes", "ankle", "--given", "ankle.1=ten"], ["ankle.1", "ten"]),
    (["modes", "ankle", "--given", "ankle.1=1,ankle.1=2"], ["'ankle.1'", "twice"]),
    (["modes", "ankle", "--given", "ankle.1=1", "--joints", "1,2"], ["give one of them"]),
    (["modes", "ankle", "--joints", "upper_motor=3"], ["lower_motor", "no value"]),
    (["modes", "four_bar", "--pose", "0,0,0,1,0,0,0"], ["no platform link"]),
    (["modes", "four_bar", "--given", "pose=0,0,0,1,0,0,0"], ["'pose'"]),
    (["modes", "four_bar", "--given", "x=3"], ["'x'", "crank"]),
    (
        ["solve", "four_bar", "--given", "crank=3", "--start", "crunk=3"],
        ["start", "'crunk'", "crank"],
    ),
    (["solve", "four_bar", "--given", "crank=3", "--start", "1,2,3"], ["start", "NAME=VALUE"]),
    (["modes", "triad", "--given", "pivot1=3"], ["mobility is 0", "pivot1"]),
    (["modes", "spherical_wrist", "--given", "pose=0,0,0,1,0,0,0,tilt=3"], ["whole pose", "tilt"]),
    (["modes", "spherical_wrist", "--given", "pose=0,0,0,1,0,0"], ["7 are needed"]),
]


@pytest.mark.parametrize(("arguments", "parts"), MISTAKES)
def test_mistakes_are_one_sentence(
    capsys: pytest.CaptureFixture[str], arguments: list[str], parts: list[str]
) -> None:
    status, out, err = run(capsys, *arguments)
    assert (status, out, err.count("\n")) == (2, "", 1)
    for part in parts:
        assert part in err


# --- limbs ----------------------------------------------------------------------------------------

GIVEN_BACK = [
    ("x", "y", "z", "theta1"),
    ("radial1", "radial2", "radial3", "height1"),
    ("theta1", "theta2", "height1", "radial2"),
    ("x", "y", "z", "torsion"),
    ("top1", "x", "y", "z"),
    ("op", "theta1", "radial2", "height3"),
]
FEW_BACK = [list(GIVEN_BACK[k]) for k in (1, 4)]
"""What the gate gives back: passive joints, a cut joint with the pose."""


@pytest.mark.parametrize("names", in_gate(map(list, GIVEN_BACK), FEW_BACK), ids=",".join)
def test_a_mode_of_limbs_is_found_from_any_of_its_coordinates(names: tuple[str, ...]) -> None:
    """What joints lead to is among the modes for as many other coordinates of it, passive and cut
    joints and the pose's alike.
    """
    mechanism = symkin.load("zhao2000")
    mode = symkin.modes(mechanism, joints=[81.6, 202.8, 330.6, 105.2])[0]
    pose = dict(zip("xyz", mode.position.tolist(), strict=True)) | {
        "torsion": float(np.degrees(mode.values["pose.gamma"]))
    }
    found = symkin.modes(
        mechanism, given={name: mode.joints.get(name, pose.get(name)) for name in names}
    )
    apart = [float(np.max(np.abs(other.position - mode.position))) for other in found]
    joints = [
        max(
            abs(np.exp(1j * np.radians(other.joints[n] - mode.joints[n])) - 1)
            for n in ("theta1", "theta2", "theta3")
        )
        for other in found
    ]
    assert min(a + j for a, j in zip(apart, joints, strict=True)) < 1e-6


def test_a_platform_of_three_freedoms_by_height_and_tilt() -> None:
    """3-RPS: z, azimuth and tilt lead to modes that have them; their legs lead back to the same
    pose.
    """
    mechanism = samples.three_rps()
    given = {"z": 290.0, "azimuth": 0.5, "tilt": 0.09}
    found = symkin.modes(mechanism, given=given)
    assert (
        len(found) == len(symkin.modes(mechanism, given=given, method="multistart", starts=300)) > 0
    )
    for mode in found:
        assert mode.position[2] == pytest.approx(given["z"])
        wanted = [np.sin(0.09) * np.cos(0.5), np.sin(0.09) * np.sin(0.5), np.cos(0.09)]
        assert mode.rotation[:, 2] == pytest.approx(wanted, abs=1e-8)
        back = symkin.modes(mechanism, joints=mode.actuated_values)
        assert min(np.max(np.abs(other.position - mode.position)) for other in back) < 1e-6
    near = symkin.solve(mechanism, given=given).solution
    assert near is not None
    assert min(np.max(np.abs(other.position - near.position)) for other in found) < 1e-6


def test_angles_that_no_given_value_moves_are_all_found() -> None:
    """The three turns of a loop C P R P C close in two ways, wherever its slides are."""
    joints = [
        Joint("c1", "C", (0, 0, 0), (1, 0.2, 0)),
        Joint("p1", "P", (3, 0, 1), (0, 1, 0.3)),
        Joint("r", "R", (3, 2, 1), (0, 0.4, 1)),
        Joint("p2", "P", (1, 4, 2), (1, 0, 1)),
        Joint("c2", "C", (0, 4, 0), (0.3, 1, -0.2)),
    ]
    links = ["base", "a", "b", "c", "d", "base"]
    loop = Mechanism(
        "loop",
        link_joints=[LinkJoint(joint, links[k : k + 2]) for k, joint in enumerate(joints)],
        platform_link=None,
    )
    found = symkin.modes(loop, given={"p2": 0.4})
    assert (len(found), found.complex_count, found.completeness) == (2, 2, "probability one")
    assert all(mode.certified for mode in found)
    assert min(abs(mode.joints["r"]) for mode in found) < 1e-12
    assert len(symkin.modes(loop, given={"p2": 0.4}, method="multistart")) == 2


def test_a_mode_that_is_singular_whatever_is_given_is_listed() -> None:
    """A spherical platform on three legs of two revolutes whose planes meet in a line at the
    reference: a double mode there, beside two others, wherever a spindle on one leg's axis is. No
    loop of known values leads to it, and a list of the two alone claimed to be complete.
    """
    legs = [
        ([-2, 1, 0], [2, -1, 1], "one", "platform"),
        ([-1, 1, -1], [1, -1, -2], "two", "platform"),
        ([0, 2, 1], [0, 1, 1], "three", "spindle"),
    ]
    joints = [LinkJoint(Joint("spin", "R", (0, 0, 0), (0, -1, -1)), ("spindle", "platform"))]
    for first, second, link, end in legs:
        joints.append(LinkJoint(Joint(f"{link}.1", "R", (0, 0, 0), first), ("base", link)))
        joints.append(LinkJoint(Joint(f"{link}.2", "R", (0, 0, 0), second), (link, end)))
    platform = Mechanism("three_legs", (), link_joints=joints)
    found = symkin.modes(platform, given={"spin": 0.3}, starts=300)
    assert [any("double" in note for note in mode.notes) for mode in found] == [True, False, False]
    assert found[0].joints["one.1"] == pytest.approx(0.0, abs=1e-7)
    assert found.completeness == "sampled"
    assert "singular whatever the given values are" in str(found)


@pytest.mark.parametrize("count", [0, 1, 2, 5])
def test_modes_are_singular_whatever_is_given_where_two_instances_say_so(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Such modes may be complex at some values, and one instance alone be near a fold."""
    flags = iter([k < count for k in range(5)][::-1])
    monkeypatch.setattr(
        start_store, "_sampled", lambda *_: (np.zeros((1, 1)), np.array([next(flags)]))
    )
    problem = build_problem(symkin.load("zhao2000"), "direct")
    assert start_store._has_singular_roots(problem) == (count > 1)


def test_joints_that_meet_no_root_but_double_ones_are_answered() -> None:
    """Spherical loops of small whole directions whose j1, j4 meet in double solutions alone: a
    search that found no root of their structure ended in an error of NumPy's.
    """
    axes = {
        ("base", "one"): (0, -1, 0),
        ("one", "two"): (1, 1, 0),
        ("two", "three"): (1, 1, 0),
        ("three", "base"): (1, 0, 0),
        ("base", "four"): (-1, -1, -1),
        ("four", "five"): (1, 0, 1),
        ("five", "two"): (0, -1, -1),
    }
    joints = [
        LinkJoint(Joint(f"j{k}", "R", 100.0 * np.array(axis), axis), links)
        for k, (links, axis) in enumerate(axes.items(), start=1)
    ]
    found = symkin.modes(Mechanism("loops", (), link_joints=joints), given={"j3": -0.04}, starts=64)
    assert [any("double" in note for note in mode.notes) for mode in found] == [True, True]
    assert found.completeness == "sampled"
