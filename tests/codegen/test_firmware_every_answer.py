"""What the generated C must never do: OK off the machine or across a meeting, refuse to stand
still, run what a name says.
"""

import ctypes
import re
import subprocess
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import ClosedDirection, Options, Real, build_program, folder_files
from helpers.samples import random_mechanism
from symkin import Coupling, Joint, Limb, LinkJoint, Mechanism

MODELS = Path(__file__).parents[1] / "data" / "models"
X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Compiled code of a mechanism with options, once in the module."""
    tools.compiler("gcc")

    @cache
    def built(name, options):
        mechanism = symkin.load(name) if isinstance(name, str) else name
        folder = tmp_path_factory.mktemp("code")
        tools.write_code(mechanism, folder, options)
        command = [
            "gcc",
            "-O1",
            "-std=c99",
            "-ffp-contract=off",
            "-shared",
            "-fPIC",
            f"{mechanism.name}.c",
            "-o",
            "code.so",
            "-lm",
        ]
        subprocess.run(command, cwd=folder, check=True)
        return ctypes.CDLL(str(folder / "code.so"))

    return built


def _array(kind, values):
    return (kind * len(values))(*values)


def _doubles(values):
    return _array(ctypes.c_double, values)


GEOMETRY = {"ur5e": (24, 6), "delta": (67, 3)}
"""Arms and platforms: how many numbers their geometry has, and their joints."""


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(GEOMETRY, ["delta"]))
def test_geometry_that_is_not_finite_is_refused_by_every_function(name, library):
    """Any number of the struct: NONFINITE (3), whatever the other arguments are."""
    count, joints = GEOMETRY[name]
    code = library(name, Options("double", geometry="struct"))
    text = (Path(code._name).parent / f"{name}.h").read_text()
    nominal = re.sub(r"/\*.*?\*/", "", re.search(r"_NOMINAL \\\n((?:.*\\\n)*.*)\n", text)[1])
    numbers = [float(v) for v in re.findall(r"-?\d+\.?\d*(?:e[-+]?\d+)?", nominal)]
    assert len(numbers) == count
    pose = _doubles([*symkin.load(name).platform_position, 1.0, 0.0, 0.0, 0.0])
    values, six, out = _doubles([0.1] * joints), _doubles([0.1] * 6), _doubles([0.0] * 40)
    calls = {
        "ur5e": {
            "direct": (values, out),
            "inverse": (None, pose, values, out, None),
            "jacobian": (values, out),
            "rates": (values, six, out, None),
            "twist": (values, values, out),
            "track": (pose, values, None),
        },
        "delta": {
            "direct": (None, values, pose, out, None),
            "inverse": (pose, out),
            "jacobian": (pose, out),
            "rates": (pose, six, out),
            "twist": (pose, values, out),
            "track": (values, pose, None),
        },
    }[name]
    for k in range(count):
        changed = list(numbers)
        changed[k] = np.nan if k % 2 else np.inf
        geometry = _doubles(changed)
        for function, arguments in calls.items():
            assert getattr(code, f"{name}_{function}")(geometry, *arguments) == 3, (k, function)


HOSTILE = "q1*/injected/* name_x"


def _arm(name):
    """SCARA-like: a closed form whose steps, choices and limits name the joint."""
    joints = [
        Joint(name, "R", (0, 0, 0), Z, limits=(-2.0, 2.0), actuated=True),
        Joint("q2", "R", (0.4, 0, 0), Z, actuated=True),
        Joint("q3", "R", (0.7, 0, 0), Z, actuated=True),
        Joint("q4", "P", (0.7, 0, 0), Z, actuated=True),
    ]
    return Mechanism(
        "arm",
        [Limb("arm", joints)],
        serial=True,
        platform_position=(0.7, 0.0, 0.1),
        length_unit="m",
        angle_unit="rad",
    )


def _four_bar(name):
    joints = [
        LinkJoint(Joint(name, "R", (0, 0, 0), Z, actuated=True), ("base", "a")),
        LinkJoint(Joint("b", "R", (0, 1, 0), Z), ("a", "c")),
        LinkJoint(Joint("d", "R", (2, 1.5, 0), Z), ("c", "e")),
        LinkJoint(Joint("f", "R", (2.2, 0, 0), Z), ("e", "base")),
    ]
    return Mechanism("bars", link_joints=joints, length_unit="m", angle_unit="rad")


@pytest.mark.parametrize("kind", in_gate(["arm", "map"], ["map"]))
def test_a_name_stays_in_its_comment(kind):
    """What a name says is never code: without comments and strings no file of the folder holds
    it; nor is it a word of a template.
    """
    if kind == "arm":
        files = folder_files(_arm(HOSTILE), Options("double", also=("cpp",)))
    else:
        files = folder_files(_four_bar(HOSTILE), Options("double", given=(HOSTILE,), find=("f",)))
    for file, text in files.items():
        if Path(file).suffix in (".c", ".h", ".hpp"):
            code = re.sub(r'/\*.*?\*/|//[^\n]*|"(?:[^"\\\n]|\\.)*"', "", text, flags=re.DOTALL)
            assert "injected" not in code, file
    assert "name_x" in next(text for file, text in files.items() if file.endswith(".c"))


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
def test_standing_still_is_ok(real, library):
    """G1 ankle, whose Newton steps end in rounding of all directions: an answer asked for again
    from itself is OK.
    """
    given, find = ("left_motor_joint", "right_motor_joint"), ("pitch_joint", "roll_joint")
    code = library(
        str(MODELS / "mjcf" / "g1_parallel_ankle.xml"), Options(real, given=given, find=find)
    )
    kind, rng, answered = (
        {"float": ctypes.c_float, "double": ctypes.c_double}[real],
        np.random.default_rng(5),
        0,
    )
    for angles in rng.uniform((-0.5, -0.2), (0.3, 0.2), (3000, 2)):
        found, motors, again = (
            _array(kind, angles),
            _array(kind, [0.0, 0.0]),
            _array(kind, [0.0, 0.0]),
        )
        if code.g1_ankle_inverse(None, found, motors, motors, None) != 0:
            continue
        answered += 1
        assert code.g1_ankle_inverse(None, found, motors, again, None) == 0
        assert code.g1_ankle_direct(None, motors, found, again, None) == 0
    assert answered > 2900


def _two_spherical_loops():
    """Two spherical loops of one centre, whose branches meet where j1 is -0.857 rad; redundant
    rows.
    """
    axes = {
        "j0": (("base", "k1"), (-1, 1, -2)),
        "j1": (("k1", "k2"), (1, 1, 1)),
        "j2": (("k2", "k3"), (-1, 1, 0)),
        "j3": (("k3", "base"), (-1, -1, 1)),
        "p0": (("k1", "p1"), (1, 1, 1)),
        "p1": (("p1", "p2"), (1, -1, 0)),
        "p2": (("p2", "base"), (1, 0, 0)),
    }
    joints = [LinkJoint(Joint(n, "R", a, a), links) for n, (links, a) in axes.items()]
    return Mechanism("meeting", link_joints=joints, length_unit="m", angle_unit="rad")


@pytest.mark.slow
def test_nothing_is_ok_beyond_a_meeting_of_branches(library):
    """`track` ends at the meeting, and so does the code, although one Newton step would hop over
    it.
    """
    mechanism = _two_spherical_loops()
    track = symkin.track(mechanism, given={"j1": (0.0, -1.5)})
    assert -0.87 < track.end.solution.joints["j1"] < -0.85
    code = library(mechanism, Options("double", given=("j1",), find=("p0",)))
    out = _doubles([0.0])
    for value in (-0.2, -0.6, -0.8):
        assert code.meeting_direct(None, _doubles([value]), _doubles([0.0]), out, None) == 0
    for value in (-0.9, -1.0, -1.2, -1.5):
        assert code.meeting_direct(None, _doubles([value]), _doubles([0.0]), out, None) != 0


class _Info(ctypes.Structure):
    _fields_ = [
        ("iterations", ctypes.c_uint8),
        ("residual", ctypes.c_float),
        ("step", ctypes.c_float),
        ("min_pivot", ctypes.c_float),
        ("joint", ctypes.c_uint8),
    ]


@pytest.mark.slow
@pytest.mark.parametrize("count", in_gate([500, 2000], [500]))
def test_the_residual_of_an_arm_is_the_tools(library, count):
    """ur5e in float, poses near folds among them: what `info` says is how far direct kinematics in
    double misses the pose, and no answer, of one branch or of all, is off by more than is allowed.
    """
    code, arm = (
        library("ur5e", Options("float")),
        build_program(symkin.load("ur5e"), Options("double")).kind,
    )
    size, rng, seen, worst = arm.mechanism.characteristic_length, np.random.default_rng(3), 0, 0.0
    allowed = 72 * 2.0**-24 * size
    floats = lambda values: _array(ctypes.c_float, values)  # noqa: E731 - as short as a call
    for q in rng.uniform(-3, 3, (count, 6)):
        pose, out, info, every = floats([0.0] * 7), floats([0.0] * 6), _Info(), floats([0.0] * 48)
        if (
            code.ur5e_direct(floats(q), pose) != 0
            or code.ur5e_inverse(None, pose, floats(q), out, ctypes.byref(info)) != 0
        ):
            continue
        found = [
            np.array(out[:]),
            *np.array(every[: 6 * code.ur5e_inverse_all(pose, every)]).reshape(-1, 6),
        ]
        errors = [_pose_error(arm.forward_at(joints), np.array(pose[:]), size) for joints in found]
        assert abs(errors[0] - info.residual) < 8 * 2.0**-24 * size
        seen, worst = seen + 1, max(worst, *errors)
    assert seen > 0.75 * count
    assert worst < allowed


def _pose_error(pose, target, size):
    away = min(
        (pose[3:] - s * target[3:] / np.linalg.norm(target[3:]) for s in (1, -1)),
        key=np.linalg.norm,
    )
    return float(np.hypot(np.linalg.norm(pose[:3] - target[:3]), 2 * size * np.linalg.norm(away)))


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(["ur5e", "ren2008"], ["ren2008"]))
def test_speeds_may_be_written_over_what_is_read(name, library):
    """Rates and twist in one array are those of two arrays."""
    code, six = library(name, Options("double")), [0.3, -0.2, 0.1, 0.2, 0.5, -0.4]
    if name == "ur5e":
        function, first = code.ur5e_twist, _doubles([0.3, -1.0, 0.8, 0.2, 0.9, 0.1])
    else:
        function, first = (
            code.ren2008_rates,
            _doubles([*symkin.load(name).platform_position, 1.0, 0.0, 0.0, 0.0]),
        )
    out, both = _doubles([0.0] * 6), _doubles(six)
    assert function(first, _doubles(six), out) == 0
    assert function(first, both, both) == 0
    assert both[:] == out[:]


def test_a_map_that_is_linear_both_ways_has_code():
    """Gears alone: a step of Newton's method leaves nothing, so that its limit is no division by
    zero.
    """
    joints = [
        LinkJoint(Joint(n, "R", (x, 0, 0), Z, actuated=n == "a"), ("base", n))
        for n, x in (("a", 0.0), ("b", 1.0))
    ]
    gears = Mechanism(
        "gears",
        link_joints=joints,
        couplings=[Coupling("b", {"a": -2.0})],
        length_unit="m",
        angle_unit="rad",
    )
    files = folder_files(gears, Options("double", given=("a",), find=("b",)))
    limit = re.search(r"GEARS_TRACK_LIMIT \(\(gears_real\)([^)]*)\)", files["gears.h"])[1]
    assert 0.0 < float(limit) <= gears.characteristic_length


@pytest.mark.parametrize(
    ("name", "given", "find"),
    [
        ("four_bar", "crank", "follower"),
        pytest.param("ankle", "upper_motor,lower_motor", "ankle.1,ankle.2", marks=pytest.mark.long),
    ],
)
def test_bends_hold_everywhere(name, given, find):
    """The bound of a condition's second derivative is above that of 4,000 random lines through
    random values.
    """
    made = build_program(
        symkin.load(name),
        Options("double", given=tuple(given.split(",")), find=tuple(find.split(","))),
    ).kind
    for way in (made.direct, made.inverse):
        if not way.is_closed:
            continue
        direction = ClosedDirection(made, way, {})
        values, rng = direction.formulas.values, np.random.default_rng(9)
        for one, guard in zip(direction.conditions, direction.guards, strict=True):
            expression = direction._put_in(one.value) * guard.factor
            hessian = ca.Function("h", [values], [ca.hessian(expression, values)[0]])
            points = rng.uniform(-np.pi, np.pi, (4000, len(way.known)))
            found = np.asarray(hessian(points.T)).reshape(len(way.known), 4000, -1).swapaxes(0, 1)
            changes = rng.normal(size=points.shape)
            bends = np.abs(np.einsum("ni,nij,nj->n", changes, found, changes))
            assert guard.root is None
            assert np.all(bends <= 2 * changes**2 @ guard.bounds[-1].plain * (1 + 1e-6) + 1e-12)


@pytest.mark.parametrize("name", ["float", "double"])
def test_no_number_is_printed_that_the_type_does_not_hold(name):
    """A division by a constant zero, and what is beyond the type's range, are refused with a
    sentence, not printed as nan.0 and inf.0; macros stand for them in vectors alone.
    """
    real, largest = Real(name), np.finfo({"float": "f", "double": "d"}[name]).max
    assert float(real.literal(largest).rstrip("f")) == pytest.approx(largest, rel=1e-6)
    beyond = [2.0 * float(largest)] if name == "float" else []
    for value in (np.nan, np.inf, -np.inf, *beyond):
        with pytest.raises(symkin.InputError, match=f"no finite {name}; use "):
            real.literal(value)
    found = [real.hexadecimal(v) for v in (np.nan, np.inf, -np.inf)]
    assert found == ["NAN", "INFINITY", "-INFINITY"]


def test_an_answer_beside_a_singularity_stands_still():
    """Sarrus' linkage beside its stretched leg, where an answer is known to the root of rounding
    and steps find no pivot: from itself it is OK again and again, and does not leave that.
    """
    options = Options("float", given=("foot_x",), find=("head_y",))
    code = tools.bench_module("asked").Asked(symkin.load("sarrus"), options)
    goal, guess = np.array([[0.48632049560546875]]), np.array([[-0.9257011413574219]])
    first = code.answers(goal, guess, "inverse")
    assert first.status[0] == 0
    again = first
    for _ in range(30):
        again = code.answers(goal, again.found, "inverse")
        assert again.status[0] == 0
        assert abs(again.found - first.found)[0] < 64 * np.finfo("f").eps


@pytest.mark.parametrize("seed", [16, 17])
def test_answers_of_limbs_beside_dead_centres_stand_still(seed):
    """Planar platforms whose limbs pass dead centres on smooth paths, where a pose rounded gives
    joint values that are off by its root, or none: each OK is OK from itself, and moves by no more
    than rounding.
    """
    rng, level = np.random.default_rng(seed), (1.0, 0.0, 0.0, 0.0)
    made = random_mechanism(rng, ["rUS"] * 3, motion="planar", platform_quaternion=level)
    asked = tools.bench_module("asked").Asked(made, Options("float"))
    lines = tools.bench_module("directions").directions(asked)[0]
    paths = tools.bench_module("ranges").paths_of(lines, 40, 60, np.random.default_rng(1))
    at, count = lines.home.repeated(40).guesses, 0
    for goal in asked.rounded(paths):
        answers = lines.answers(goal, at)
        ok = answers.status == 0
        again = lines.answers(goal[ok], answers.found[ok])
        assert not again.status.any()
        assert np.all(lines.off(again.found, answers.found[ok]) < 64 * lines.epsilon)
        at, count = np.where(ok[:, None], answers.found, at), count + np.sum(ok)
    assert count > 200
