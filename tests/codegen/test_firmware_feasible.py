"""OK of generated C means that all loops close, that limits are kept and that no infinity was
passed; what fails its own test is not written.
"""

from __future__ import annotations

import ctypes
import math
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import Options, can_run, folder_files, run_own_test
from helpers.samples import random_mechanism
from symkin import InputError

MACHINES = Path(__file__).parents[2] / "codegen" / "bench" / "machines"
OK, SINGULAR, OUT_OF_RANGE, WRONG_BRANCH = 0, 2, 4, 5
FLAT = (0.69982928, -0.69971412, 0.10159385, -0.10157713)
"""A quaternion at which a Tricept's strut is all but level."""

LEVER = """format = 1
name = "lever"
length_unit = "mm"
angle_unit = "deg"
[[joint]]
name = "theta"
type = "R"
links = ["base", "arm"]
point = [0.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
zero = 45.0
actuated = true
[[joint]]
name = "slot"
type = "P"
links = ["arm", "block"]
point = [10.0, 10.0, 0.0]
axis = [1.0, 1.0, 0.0]
[[joint]]
name = "pin"
type = "R"
links = ["block", "carriage"]
point = [10.0, 10.0, 0.0]
axis = [0.0, 0.0, 1.0]
[[joint]]
name = "guide"
type = "P"
links = ["base", "carriage"]
point = [10.0, 10.0, 0.0]
axis = [1.0, 0.0, 0.0]
zero = 10.0
"""
"""An arm with a slot that draws a carriage along a guide: guide = 10 / tan theta."""

FIVE_BAR = """format = 1
name = "five_bar"
length_unit = "mm"
angle_unit = "deg"

[platform]
motion = "planar"
position = [0.0, "100 + 75*sqrt(3)", 0.0]

[[limb]]
name = "left"
[[limb.joint]]
name = "crank1"
type = "R"
point = [-75.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
actuated = true
[[limb.joint]]
name = "elbow1"
type = "R"
point = [-75.0, 100.0, 0.0]
axis = [0.0, 0.0, 1.0]

[[limb]]
name = "right"
[[limb.joint]]
name = "crank2"
type = "R"
point = [75.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
actuated = true
[[limb.joint]]
name = "elbow2"
type = "R"
point = [75.0, 100.0, 0.0]
axis = [0.0, 0.0, 1.0]
[[limb.joint]]
name = "tip"
type = "R"
point = [0.0, "100 + 75*sqrt(3)", 0.0]
axis = [0.0, 0.0, 1.0]
"""
"""Two cranks and a platform on the end of the left forearm, hinged to the right one: the left limb
decides its turn.
"""


def library(mechanism: symkin.Mechanism, folder: Path, **options: tuple[str, ...]) -> ctypes.CDLL:
    """The code of a mechanism, compiled without a warning."""
    tools.write_code(mechanism, folder, Options(**options))
    tools.built("gcc", folder, [f"{mechanism.name}.c"], "code.so", "-O1", "-shared", "-fPIC")
    return ctypes.CDLL(str(folder / "code.so"))


def limited(text: str, joint: str, low: float, high: float) -> str:
    """A file with limits of one joint."""
    assert f'name = "{joint}"\n' in text
    return text.replace(f'name = "{joint}"\n', f'name = "{joint}"\nlimits = [{low}, {high}]\n')


def loaded(folder: Path, text: str) -> symkin.Mechanism:
    """The mechanism of a file's text."""
    (folder / "mechanism.toml").write_text(text)
    return symkin.load(folder / "mechanism.toml")


def doubles(values: object) -> ctypes.Array[ctypes.c_double]:
    numbers = np.ravel(np.asarray(values, float)).tolist()
    return (ctypes.c_double * len(numbers))(*numbers)


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(["float", "double"], ["float"]))
@pytest.mark.parametrize("name", in_gate(["five_bar", "tricept", "three_rps"], ["five_bar"]))
def test_ok_of_a_platform_that_cannot_take_every_pose_closes_all_rows(name, real):
    """Poses on and off what the limbs can take: an OK closes, poses that can be taken are taken in
    the type's rounding.
    """
    tools.compiler("gcc")
    closes = tools.bench_module("closes")
    code = closes.Asked(symkin.load(MACHINES / f"{name}.toml"), Options(real))
    found = closes.closes(code, 8, np.random.default_rng(3))
    assert found.wrong == 0, found.said
    assert found.ok > 0
    assert found.moved == 0
    assert found.taken == found.feasible


def test_a_five_bar_takes_the_turn_that_its_first_limb_leaves_and_no_other(tmp_path):
    """The first limb of two revolutes holds the platform's point and its turn together."""
    made = loaded(tmp_path, FIVE_BAR)
    code = library(made, tmp_path / "c")
    found = symkin.solve(made, joints=[10.0, -5.0]).solution
    position, quaternion = np.array(found.pose.position), np.array(found.pose.quaternion)
    joints = doubles([9.0, 9.0])
    assert code.five_bar_inverse(doubles([*position, *quaternion]), joints) == OK
    np.testing.assert_allclose(np.degrees(joints), [10.0, -5.0], atol=1e-7)
    size = made.characteristic_length
    for turn in (1e-3, -1e-3, 0.05, -0.3, 0.7):
        turned = symkin.Pose(position, quaternion) @ symkin.Pose(
            [0, 0, 0], [math.cos(turn / 2), 0, 0, math.sin(turn / 2)]
        )
        joints = doubles([9.0, 9.0])
        assert (
            code.five_bar_inverse(doubles([*turned.position, *turned.quaternion]), joints)
            == OUT_OF_RANGE
        )
        assert list(joints) == [9.0, 9.0]
    for step in ([1e-3 * size, 0.0, 0.0], [0.0, -1e-3 * size, 0.0]):
        assert (
            code.five_bar_inverse(doubles([*(position + step), *quaternion]), joints)
            == OUT_OF_RANGE
        )


def test_no_ok_across_infinity(tmp_path):
    """The guide of a lever is at infinity where the slot is along it; within a branch the answer is
    10 / tan theta.
    """
    code = library(loaded(tmp_path, LEVER), tmp_path / "c", given=("guide",), find=("theta",))
    for degrees in (1.0, 44.0, 45.0, 90.0, 135.0, 170.0):
        guide = doubles([0.0])
        assert (
            code.lever_inverse(None, doubles([math.radians(degrees)]), doubles([10.0]), guide, None)
            == OK
        )
        assert abs(guide[0] - 10.0 / math.tan(math.radians(degrees))) <= 1e-9 * max(
            10.0, abs(guide[0])
        )
    for degrees in (-1.0, -10.0, -45.0, -80.0, -135.0):
        guide = doubles([7.0])
        assert (
            code.lever_inverse(None, doubles([math.radians(degrees)]), doubles([10.0]), guide, None)
            == WRONG_BRANCH
        )
        assert guide[0] == 7.0


FOLLOWER = ("follower_pin", -120.0, 3.0)


@pytest.mark.parametrize(
    ("joint", "low", "high"), in_gate([("crank_pin", -5.0, 5.0), FOLLOWER], [FOLLOWER])
)
def test_limits_of_passive_joints_are_kept_by_a_map(tmp_path, joint, low, high):
    """OK where, and only where, Python says that the configuration is within limits; of a joint
    that the closure cuts too.
    """
    text = (Path(symkin.__file__).parent / "mechanisms" / "four_bar.toml").read_text()
    made = loaded(tmp_path, limited(text, joint, low, high))
    code = library(made, tmp_path / "c", given=("crank",), find=("follower",))
    reference = symkin.solve(made, given={"crank": 90.0}).solution.joints["follower"]
    statuses = set()
    for crank in np.linspace(60.0, 125.0, 14):
        solution = symkin.solve(made, given={"crank": float(crank)}).solution
        found = doubles([0.0])
        status = code.four_bar_direct(
            None, doubles([math.radians(crank)]), doubles([math.radians(reference)]), found, None
        )
        assert status == (OK if solution.within_limits else OUT_OF_RANGE), crank
        back = code.four_bar_inverse(
            None,
            doubles([math.radians(solution.joints["follower"])]),
            doubles([math.pi / 2]),
            found,
            None,
        )
        assert back == (OK if solution.within_limits else OUT_OF_RANGE), crank
        statuses.add(status)
    assert statuses == {OK, OUT_OF_RANGE}


def test_a_guess_a_little_beyond_its_limits_begins_where_it_stands(tmp_path):
    """Not a whole turn away: the line from there to values within is a short one."""
    text = (Path(symkin.__file__).parent / "mechanisms" / "four_bar.toml").read_text()
    plain = loaded(tmp_path, text)
    within, beyond = (
        symkin.solve(plain, given={"crank": crank}).solution.joints["follower"]
        for crank in (90.0, 95.0)
    )
    high = within + 0.9 * (beyond - within)
    made = loaded(tmp_path, limited(text, "follower", *sorted((high, 2.0 * within - high))))
    code = library(made, tmp_path / "c", given=("crank",), find=("follower",))
    crank = doubles([0.0])
    status = code.four_bar_inverse(
        None, doubles([math.radians(within)]), doubles([math.radians(95.0)]), crank, None
    )
    assert status == OK
    assert math.degrees(crank[0]) == pytest.approx(90.0, abs=1e-6)


@pytest.mark.parametrize("joint", in_gate(["elbow1", "tip"], ["tip"]))
def test_limits_of_passive_joints_are_kept_by_a_platform(tmp_path, joint):
    """Direct problem, inverse problem and tracking alike."""
    made = loaded(tmp_path, limited(FIVE_BAR, joint, -8.0, 8.0))
    code = library(made, tmp_path / "c")
    home, statuses = doubles([*made.platform_position, 1.0, 0.0, 0.0, 0.0]), set()
    for first, second in np.random.default_rng(5).uniform(-12.0, 12.0, (14, 2)):
        solution = symkin.solve(made, joints=[first, second]).solution
        wanted = OK if solution.within_limits else OUT_OF_RANGE
        pose, joints = doubles(np.zeros(7)), doubles([0.0, 0.0])
        assert (
            code.five_bar_direct(None, doubles(np.radians([first, second])), home, pose, None)
            == wanted
        )
        stated = doubles([*solution.pose.position, *solution.pose.quaternion])
        assert code.five_bar_inverse(stated, joints) == wanted
        assert (code.five_bar_track(doubles(np.radians([first, second])), stated, None) == OK) == (
            wanted == OK
        )
        statuses.add(wanted)
    assert statuses == {OK, OUT_OF_RANGE}


PASSIVE = [("three_rrr", "b1", 0.15), ("three_rps", "r1", 0.05)]


@pytest.mark.parametrize(("name", "joint", "high"), in_gate(PASSIVE, PASSIVE[:1]))
def test_an_answer_at_a_passive_limit_is_held_by_a_platform(name, joint, high):
    """What Newton's method finds just within a passive joint's limits is OK from itself in float,
    though a step of rounding leads over the limit.
    """
    tools.compiler("gcc")
    made = symkin.load(MACHINES / f"{name}.toml")
    limits = {joint: (-high, high)}
    limbs = [
        replace(limb, joints=[replace(j, limits=limits.get(j.name)) for j in limb.joints])
        for limb in made.limbs
    ]
    asked = tools.bench_module("asked").Asked(replace(made, limbs=limbs), Options("float"))
    lines = tools.bench_module("directions").directions(asked)[0]
    row = tools.bench_module("grazes").grazed(lines, 12, np.random.default_rng(5))
    assert row.ok > 100
    assert row.said == []


def test_code_that_fails_its_own_test_is_not_written(tmp_path):
    tools.compiler("gcc")
    made = loaded(tmp_path, FIVE_BAR)
    files = folder_files(made, Options("double"))
    run_own_test("five_bar", files)
    wrong = {**files, "five_bar.c": files["five_bar.c"].replace("x[0] = ", "x[0] = 0.1 + ", 1)}
    with pytest.raises(InputError, match=r"own test fails here \(failed: .*failures\)"):
        run_own_test("five_bar", wrong)
    # a number that is none is no answer, wherever it stands
    none = files["five_bar.c"].replace("joints[0] = q[0];", "joints[0] = NAN;", 1)
    with pytest.raises(InputError, match="failed: inverse, answer"):
        run_own_test("five_bar", {**files, "five_bar.c": none})
    with pytest.raises(InputError, match="the compiler says: "):
        run_own_test("five_bar", {**files, "five_bar.c": files["five_bar.c"] + "}"})


@pytest.mark.parametrize("seed", in_gate([2, 6, 8, 10, 16, 20], [2, 20]))
def test_hard_lines_refuse_no_machine(seed):
    """Random platforms whose home is not far from a singularity, of the joints or of a limb: the
    vectors ask for no line that code may refuse, of which it cut one into 124 parts. Limbs whose
    third step is longer than the second lets expect (20) are followed in parts that it tells.
    """
    tools.compiler("gcc")
    level = (1.0, 0.0, 0.0, 0.0)
    rng = np.random.default_rng(seed)
    made = random_mechanism(rng, ["rUS"] * 3, motion="planar", platform_quaternion=level)
    files = folder_files(made, Options("double"))
    run_own_test(made.name, files)
    assert "SAMPLE_VECTORS 24\n" in files["sample_vectors.h"]


def test_rates_are_tested_of_twists_that_the_platform_can_take(tmp_path):
    """A Sarrus linkage moves one way: the rows of one limb give rates to other twists than those of
    both, and no others to that one.
    """
    tools.compiler("gcc")
    made = symkin.load(MACHINES / "sarrus_limbs.toml")
    files = folder_files(made, Options("double"))
    run_own_test(made.name, files)
    source = files[f"{made.name}.c"]
    wrong = source.replace("rates[i] = jacobian[i]", "rates[i] = 1.001 * jacobian[i]")
    assert wrong != source
    with pytest.raises(InputError, match="failed: jacobian, entry"):
        run_own_test(made.name, {**files, f"{made.name}.c": wrong})
    of_all = folder_files(symkin.load("zhang2009"), Options())["zhang2009_vectors.h"]
    assert "vector_feasible" not in of_all


def test_a_strut_that_lies_flat_is_read_as_a_guess():
    """A Tricept's strut by all three rows of its direction, whose square is constant: it divides by
    nothing, where its tip has no height least of all.
    """
    tools.compiler("gcc")
    made = symkin.load(MACHINES / "tricept.toml")
    code = tools.bench_module("asked").Asked(made, Options("float"))
    assert all(not b.formulas.divisors.numel() for b in code.program.kind.blocks if b.formulas)
    joints = np.array([[889.97058, 813.33948, 1138.16627]])
    guess = np.array([[182.26755, 614.54517, 0.1010961, *FLAT]])
    first = code.answers(joints, guess)
    again = code.answers(joints, first.found)
    assert first.status[0] == again.status[0] == OK
    assert code.back(again.found)[0][0] == OK


def test_without_a_compiler_code_is_written_untested(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    assert not can_run()
    files = folder_files(loaded(tmp_path, FIVE_BAR), Options("double"))
    run_own_test("five_bar", {**files, "five_bar.c": "}"})


def test_tests_of_folders_hold_what_cannot_be_taken(tmp_path):
    """Of a platform poses and joints beyond limits; of a map values of both sides."""
    platform = folder_files(
        loaded(tmp_path, limited(FIVE_BAR, "crank1", -60.0, 60.0)), Options("float")
    )["five_bar_vectors.h"]
    four_bar = folder_files(
        symkin.load("four_bar"), Options("float", given=("crank",), find=("follower",))
    )
    assert "#define FIVE_BAR_VECTOR_PAST 2" in platform
    assert "#define FIVE_BAR_VECTOR_INFEASIBLE 0" not in platform
    # a crank turns all the way round, its follower does not
    assert "#define FOUR_BAR_VECTOR_INFEASIBLE_FOUND 0" not in four_bar["four_bar_vectors.h"]


def test_a_limb_without_a_motor_compiles_without_a_warning(tmp_path):
    """A four-bar whose coupler is the platform: its rocker has no joint rates to write."""
    text = (Path(symkin.__file__).parent / "mechanisms" / "four_bar.toml").read_text()
    made = loaded(tmp_path, text + '[platform]\nlink = "coupler"\n')
    library(made, tmp_path / "c")


RSSR = """format = 1
name = "rssr"
length_unit = "mm"
angle_unit = "deg"
joint = [
  { name = "in", type = "R", links = ["base", "crank"], point = [0, 0, 0], axis = [0, 0, 1] },
  { name = "out", type = "R", links = ["base", "arm"], point = [200, 50, 0], axis = [0, 1, 0] },
]
rod = [{ name = "rod", links = ["crank", "arm"], from = [60, 10, 0], to = [190, 50, 120] }]
"""
"""A crank drives an arm, which turns back 5 degrees beyond the reference."""


@pytest.mark.skipif(not can_run(), reason="no C compiler")
def test_answers_of_one_unknown_are_judged_by_how_far_their_fold_is(tmp_path):
    """One row's condition by its unknown is 1 everywhere: code was held to digits that no float has
    beside a fold, and refused.
    """
    options = Options("float", given=("in",), find=("out",))
    run_own_test("rssr", folder_files(loaded(tmp_path, RSSR), options))


@pytest.mark.skipif(not can_run(), reason="no C compiler")
def test_small_steps_in_float_are_made(tmp_path):
    """Beside a crank's fold a guess is open by what a small step of the arm asks, up to 256
    roundings: it was given back unchanged, so that a servo stuck and then jumped.
    """
    code = library(loaded(tmp_path, RSSR), tmp_path, real="float", given=("in",), find=("out",))
    number, taken = ctypes.c_float * 1, 0

    def open_by(crank, arm):
        """How far the rod's length is from the reference's (mm)."""
        c, s, turned = math.cos(crank), math.sin(crank), (math.cos(arm), math.sin(arm))
        end = 200 - 10 * turned[0] + 120 * turned[1], 50, 10 * turned[1] + 120 * turned[0]
        gap = math.dist((60 * c - 10 * s, 60 * s + 10 * c, 0), end)
        return abs(gap - math.dist((60, 10, 0), (190, 50, 120)))

    for first in (2.2083666806338442e-07, -0.0007679685368202627, 0.054802749305963516):
        arm = number()
        assert code.rssr_direct(None, number(first), number(0.0), arm, None) == OK
        for step in np.linspace(-2e-4, 2e-4, 41):
            goal, crank = number(arm[0] + step), number()
            if code.rssr_inverse(None, goal, number(first), crank, None) == OK:
                taken += 1
                assert open_by(crank[0], goal[0]) < 2e-3, (first, step)
    assert taken > 100


def three_limbs(axis: tuple[float, float], types: str) -> str:
    """A planar platform on three limbs of revolutes and a slide along an axis of its first limb's
    frame.
    """
    text = (
        'format = 1\nname = "planar"\nlength_unit = "mm"\nangle_unit = "rad"\n[platform]\n'
        'motion = "planar"\nposition = [0.0, 0.0, 0.0]\n'
    )
    for i in range(3):
        turn = 2 * math.pi * i / 3
        r = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
        points, along = (
            (r @ np.array([[-200.0, -200.0, -60.0], [0.0, 80.0, 60.0]])).T,
            r @ np.array(axis),
        )
        text += f'[[limb]]\nname = "limb{i}"\n'
        for k, (kind, point) in enumerate(zip(types, points.tolist(), strict=True)):
            direction = [0.0, 0.0, 1.0] if kind == "R" else [*along.tolist(), 0.0]
            text += (
                f'[[limb.joint]]\nname = "{kind.lower()}{i}{k}"\ntype = "{kind}"\n'
                f"point = [{point[0]}, {point[1]}, 0.0]\naxis = {direction}\n"
            )
            text += "actuated = true\n" if k == 0 else ""
    return text


AXES = [(1.0, 0.0), (0.0, 1.0), (0.6, 0.8), (1.0, 0.5)]


@pytest.mark.parametrize(
    ("types", "axis"),
    in_gate(product(["RRP", "RPR", "PRR"], AXES), [("RRP", AXES[0])]),
)
def test_a_regular_home_is_answered_whatever_formulas_divide_by(tmp_path, axis, types):
    """No divisor that vanishes, or is small, at home makes a regular pose there singular, nor
    joints inexact.
    """
    made = loaded(tmp_path, three_limbs(axis, types))
    try:
        code = library(made, tmp_path / "c")
    except InputError as reason:
        # a home that is singular, or beside which nothing closes, has no code
        assert "nothing to generate" in str(reason)  # noqa: PT017
        return
    home, rng = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), np.random.default_rng(4)
    for far in (0.0, 1e-6, 0.1, 0.5):
        x, y, angle = far * rng.uniform(-1, 1, 3) * [1.0, 1.0, 0.01]
        pose = home + [x, y, 0.0, math.cos(angle / 2) - 1.0, 0.0, 0.0, math.sin(angle / 2)]
        joints = doubles([9.0] * 3)
        assert code.planar_inverse(doubles(pose), joints) == OK
        found = symkin.solve(made, pose=pose.tolist()).solution.joints
        wanted = [found[c.name] for c in made.actuated]
        np.testing.assert_allclose(joints, wanted, atol=1e-9 * made.characteristic_length)
