"""Lines of joint values that begin where the last one ended, for mechanisms whose matrix reads the
joints.
"""

from __future__ import annotations

import ctypes
import math
import subprocess

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers import joint_types, samples
from helpers.gate import in_gate, in_gate_but
from helpers.inside import Options
from helpers.samples import bars
from symkin import Joint, Limb, Mechanism

MECHANISMS = {
    "five-bar": (lambda: samples.readme_five_bar("planar"), 0.9, 60.0),
    "3-RRR": (lambda: samples.three_rrr("planar"), 0.9, 70.0),
    "six cranks": (joint_types.rods_at_the_end, 0.9, 70.0),
}
"""Mechanism, how far joints go from home (rad), and how many of the regular lines must succeed
(%).
"""


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(["double", "float"], ["float"]))
@pytest.mark.parametrize("name", in_gate(MECHANISMS, ["3-RRR"]))
def test_walks_keep_their_branch(name, real):
    """Three lines after each other from home: what is OK is what fine continuation reaches."""
    tools.compiler("gcc")
    make, turn, least = MECHANISMS[name]
    asked = tools.bench_module("asked")
    reach = tools.bench_module("ranges").Reach(0.2, turn)
    found = tools.study(asked.Asked(make(), Options(real)), 30, reach, seed=6, legs=3)
    assert found.ok > 30
    assert found.wrong == 0
    assert found.ok_of_regular > least


def _library(mechanism, folder):
    tools.write_code(mechanism, folder, Options("double"))
    command = [
        tools.compiler("gcc"),
        "-O1",
        "-shared",
        "-fPIC",
        f"{mechanism.name}.c",
        "-o",
        "code.so",
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "code.so"))


def _numbers(values):
    return (ctypes.c_double * len(values))(*values)


@pytest.mark.slow
def test_a_long_line_of_a_five_bar_is_not_answered_from_another_branch(tmp_path):
    """A line on which det of the matrix at the guess changes its sign between the guess's joint
    values and the given ones: the tip that the circles of the couplers reach continuously is
    (0.0338, 238.4711), the other one (2.207, -47.385).
    """
    library = _library(samples.readme_five_bar(), tmp_path)
    guess = _numbers(
        [
            -23.45668092865065,
            -92.46047606222544,
            0.0,
            -0.15146385226797096,
            0.0,
            0.0,
            0.9884627972038941,
        ]
    )
    goal, pose = _numbers([-0.3111966769802995, 0.28774171547505556]), _numbers([0.0] * 7)
    status = library.five_bar_direct(None, goal, guess, pose, None)
    assert status != 0 or np.allclose(pose[:2], [0.0338, 238.4711], atol=1e-3)


@pytest.mark.long
@pytest.mark.slow
def test_the_inverse_of_an_answer_is_what_was_given(tmp_path):
    """Cranks that pass their dead centre: the direct problem does not answer OK, for its pose would
    not give the joint values back; every OK answer gives them back, and the next call can begin
    there.
    """
    mechanism = joint_types.rods_at_the_end()
    library, name = _library(mechanism, tmp_path), mechanism.name
    direct, inverse = getattr(library, f"{name}_direct"), getattr(library, f"{name}_inverse")
    rng = np.random.default_rng(2)
    home = _numbers([*mechanism.platform_position, 1.0, 0.0, 0.0, 0.0])
    middle, answered = np.array([c.reference[0] for c in mechanism.actuated]), 0
    for goal in middle + 1.3 * rng.uniform(-1, 1, (400, 6)):
        pose, back, again = _numbers([0.0] * 7), _numbers([0.0] * 6), _numbers([0.0] * 7)
        if direct(None, _numbers(goal), home, pose, None) != 0:
            continue
        answered += 1
        assert inverse(pose, back) == 0
        np.testing.assert_allclose(back[:], goal, atol=1e-2)
        assert direct(None, _numbers(goal), pose, again, None) == 0
    assert answered > 100


def _short_coupler():
    """A slider-crank whose crank of 100 is four degrees from where it stands square on its coupler
    of 10: there it must turn back.
    """
    lean = math.radians(4.0)
    pin = (100 * math.cos(lean), -100 * math.sin(lean))
    slider = pin[0] + math.sqrt(100 - pin[1] ** 2)
    crank = Joint("crank", "R", (0, 0, 0), samples.Z, actuated=True)
    left = Limb(
        "left", [crank, samples.turning("pin", *pin), samples.turning("gudgeon", slider, 0.0)]
    )
    right = Limb("right", [Joint("slide", "P", (0, 0, 0), (1, 0, 0))])
    return Mechanism("short", [left, right], platform_position=(slider, 0.0, 0.0), motion="planar")


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("degrees", [3.9, 4.0, 4.1, 4.2, 4.3, 6.0])
def test_no_answer_lies_beyond_a_dead_centre_however_near(degrees, tmp_path):
    """A crank that passes the line of its coupler: the pose of an OK answer gives the crank's own
    angle back.
    """
    # rates of a slide by motions across it are not defined, and the folder's own test asks for them
    library = _library(_short_coupler(), tmp_path)
    home = _numbers([_short_coupler().platform_position[0], 0, 0, 1, 0, 0, 0])
    pose, back, given = _numbers([0.0] * 7), _numbers([0.0]), math.radians(degrees)
    if library.short_direct(None, _numbers([given]), home, pose, None) == 0:
        assert library.short_inverse(pose, back) == 0
        assert abs(back[0] - given) < 1e-4


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("low", "high"),
    [(0.0, 2 * math.pi), (-7.0, 7.0), (-math.pi, math.pi)],
)
def test_limited_cranks_that_turn_over_half_a_turn(low, high, tmp_path):
    """A crank-rocker whose crank has limits: every angle within them is reached in steps of ten
    degrees, and the inverse gives it back, by whole turns within the limits.
    """
    mechanism = bars(100.0, 30.0, 90.0, 60.0, limits=(low, high))
    library = _library(mechanism, tmp_path)
    start = symkin.solve(mechanism, joints=[1.0]).solution
    pose, back = _numbers([*start.position, *start.quaternion]), _numbers([0.0])
    answered = 0
    for angle in np.arange(1.0, high, math.radians(10)):
        if library.bars_direct(None, _numbers([angle]), pose, pose, None) != 0:
            break
        answered += 1
        assert library.bars_inverse(pose, back) == 0
        assert low <= back[0] <= high
        assert math.isclose(math.remainder(back[0] - angle, 2 * math.pi), 0.0, abs_tol=1e-6)
    assert answered > 10


FAR = {
    # the branch ends after 97.5 % of each line; the last steps of two thirds of the size shortened
    # as if it went on
    "zhang2009": (
        "double",
        [
            [
                403.6239461417195,
                684.4675414510874,
                415.66697430028745,
                106.20110213510607,
                432.1214509853884,
                241.28206012271582,
            ],
            [
                522.764952891999,
                368.82453372839814,
                288.89240448443104,
                591.7628937502355,
                380.48152885510535,
                184.42180516202373,
            ],
        ],
    ),
    # a first step of most of the size that happened to be good let the next ones seem better than
    # they were: off by 1.6e-3 mm
    "three_rrr": (
        "float",
        [
            [-0.883320689201355, 1.1981297731399536, -3.076019287109375],
            [-0.9707484841346741, 1.246923804283142, -3.0136852264404297],
        ],
    ),
}
"""Goals from home that were answered wrongly, with the real numbers' type."""


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(FAR, ["zhang2009"]))
def test_far_goals_that_were_answered_wrongly(name):
    """What is OK is what the fine walk of the line reaches, and no line that ends is OK."""
    tools.compiler("gcc")
    subjects, directions = tools.bench_module("subjects"), tools.bench_module("directions")
    real, goals = FAR[name]
    (lines,) = directions.directions(subjects.machine_of(name).of(real))
    home = lines.home.repeated(len(goals))
    outcome = lines.run(home, np.array(goals), np.random.default_rng(0))
    assert not np.any(outcome.ok & ~outcome.right)


REGULAR = {
    # from beside a singularity; the second step to the end of the line lies beyond it
    "three_rps": (
        "double",
        [-16.517749, 6.103583, 284.362698, 0.90769287, -0.07387884, 0.41308059, 0.0],
        [275.567196501, 373.355564558, 341.870637067],
    ),
    # slides near the middle of their ranges, where a discriminant is rounded far less than at its
    # largest
    "orthoglide": (
        "float",
        [-79.04155, -93.679596, -40.050316, 1.0, 0.0, 0.0, 0.0],
        [-47.193333, -80.278160, 5.623045],
    ),
}
"""Regular lines, by machine, that were refused: real numbers' type, guess and goal."""


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(REGULAR, ["orthoglide"]))
def test_a_regular_line_is_not_refused(name):
    """A line that is far from singularities is OK, and ends where fifty short ones do."""
    tools.compiler("gcc")
    subjects, directions = tools.bench_module("subjects"), tools.bench_module("directions")
    real, guess, goal = (np.array([v]) for v in REGULAR[name])
    (direction,) = directions.directions(subjects.machine_of(name).of(str(real[0])))
    status, found, _ = direction.answers(goal, guess)
    assert status[0] == 0
    _, begin = direction.asked.back(guess)
    for part in np.linspace(0.0, 1.0, 51)[1:]:
        status, guess, _ = direction.answers(begin + part * (goal - begin), guess)
        assert status[0] == 0
    assert direction.off(found, guess)[0] < 1e-4


def _slides_on_arms():
    """Three limbs whose slides stand on turning arms: where a slide's length passes zero its arm's
    angle goes over by half a turn.
    """
    return symkin.load("zhao2000")


GRAZES = {
    "formulas, slides on arms": _slides_on_arms,
    "formulas, elbows": lambda: samples.readme_five_bar("planar"),
    "Newton, elbows": lambda: samples.three_rrr("planar"),
}


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(["double", "float"], ["float"]))
@pytest.mark.parametrize(
    "name", in_gate_but(GRAZES, ["formulas, elbows", "formulas, slides on arms"])
)
def test_what_is_ok_beside_a_dead_centre_can_be_held(name, real):
    """Lines that end at folds and dead centres, goals ever nearer to them: an OK answer is read as
    a guess, and of formulas its own joint values are OK again; of Newton's method all but one in
    200, whose pose is another one after it has been read.
    """
    tools.compiler("gcc")
    asked, grazes, directions = map(tools.bench_module, ("asked", "grazes", "directions"))
    (direction,) = directions.directions(asked.Asked(GRAZES[name](), Options(real)))
    found = grazes.grazed(direction, 200, np.random.default_rng(3))
    assert found.ok > 500
    assert found.unread == 0, found.said
    share = 0.0 if direction.solved_by == "limbs, formulas" else 0.005
    assert found.slipped <= share * found.ok, found.said


@pytest.mark.parametrize("name", ["zhang2009", "hexaglide"])
def test_answers_of_long_lines_can_be_held(name):
    """Random lines in float, some of a hundred steps in many parts: an answer's quaternion has
    length one to a few roundings, as of one part, and the answer as its own guess is OK.
    """
    tools.compiler("gcc")
    directions, ranges = map(tools.bench_module, ("directions", "ranges"))
    machine = tools.bench_module("subjects").machine_of(name).of("float")
    (direction,) = directions.directions(machine)
    goals = ranges.goals_about(direction, 1000, ranges.WIDEST, np.random.default_rng(0))
    status, found, steps = direction.answers(goals, direction.home.repeated(1000).guesses)
    ok = status == 0
    assert steps[ok].max() > 40
    lengths = np.linalg.norm(found[ok, 3:], axis=1)
    assert np.max(np.abs(lengths - 1.0)) < 5 * np.finfo(np.float32).eps
    assert not np.any(direction.answers(goals[ok], found[ok]).status)


HELD = {
    # its two chains fold flat, where branches meet
    ("sarrus", "float"): ("foot_x", "head_y"),
    ("pantograph_five_bar", "float"): ("arm1,arm2", "wrist1,plate_pivot"),
    ("ankle", "double"): ("upper_motor,lower_motor", "ankle.1,ankle.2"),
}
"""Maps between joints whose answers beside folds were OK and refused as their own guess: given and
found coordinates by mechanism and type.
"""


def _map_directions(name, real):
    """Both directions of a map of `HELD`."""
    machine = tools.bench_module("subjects").machine_of(name, *HELD[name, real])
    return tools.bench_module("directions").directions(machine.of(real))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "real"), in_gate(HELD, [("sarrus", "float")]))
def test_an_answer_of_a_map_can_be_held(name, real):
    """Lines that end at folds, goals ever nearer to them: an OK answer, given back as the guess
    with the same values, is OK and stays.
    """
    tools.compiler("gcc")
    grazes = tools.bench_module("grazes")
    for direction in _map_directions(name, real):
        found = grazes.grazed(direction, 60, np.random.default_rng(3))
        assert found.ok > 300
        assert found.slipped == 0, found.said


@pytest.mark.slow
def test_a_short_line_that_is_refused_is_not_tried_for_ever():
    """Steps beside where branches meet are as long as rounding makes them: a line that is neither
    regular nor rounding is refused as such, not after all iterations.
    """
    tools.compiler("gcc")
    direct, _ = _map_directions("sarrus", "float")
    goals = direct.asked.rounded(np.linspace(0.6397, 0.6437, 100)[:, None])
    status = direct.answers(goals, np.full_like(goals, -2.367640733718872)).status
    assert not np.any(status == 1)  # MAX_ITERATIONS


@pytest.mark.slow
def test_a_slide_beside_zero_is_not_answered_on_the_other_side():
    """A line whose end has a slide of length zero but for rounding: OK only where the pose gives
    the joint values back.
    """
    asked, directions = tools.bench_module("asked"), tools.bench_module("directions")
    (direction,) = directions.directions(asked.Asked(_slides_on_arms(), Options("float")))
    rng, home = np.random.default_rng(5), direction.home
    goal = np.array(
        [[1.9871028661727905, 3.0342817306518555, 5.613564968109131, 141.12986755371094]]
    )
    guess = home.guesses
    for part in np.linspace(0.0, 1.0, 60)[1:]:
        at = direction.asked.rounded(home.known + part * (goal - home.known))
        status, answer, _ = direction.answers(at, guess)
        guess = answer if status[0] == 0 else guess
    goals = direction.asked.rounded(
        goal + 1e-5 * rng.normal(size=(500, 4)) * [1.0, 1.0, 1.0, 100.0]
    )
    status, answers, _ = direction.answers(goals, np.repeat(guess, 500, axis=0))
    again = direction.answers(goals, answers).status
    assert np.all(again[status == 0] == 0)
