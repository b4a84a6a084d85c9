"""C of maps between joints of graphs: held against the closure's own solutions, laws of rates, and
fine walks along lines.
"""

import ctypes
import math
import subprocess
from collections import Counter
from functools import cache
from pathlib import Path

import casadi as ca
import mpmath as mp
import numpy as np
import pytest
from click.testing import CliRunner

import symkin
from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import (
    JointMap,
    Options,
    Real,
    all_followed,
    app,
    build_program,
    can_run,
    folder_files,
    home_sheet,
    map_configurations,
    run_own_test,
    write_folder,
)
from symkin import InputError

ANKLE = ("ankle", ("upper_motor", "lower_motor"), ("ankle.1", "ankle.2"))
MODELS = str(Path(__file__).parents[1] / "data" / "models") + "/"
MAPS = {
    "ankle": ANKLE,
    "four-bar": ("four_bar", ("crank",), ("follower",)),
    "slider": ("slider_crank", ("crank",), ("piston",)),
    "gripper": ("parallel_gripper", ("left",), ("right_guide",)),
    "five-bar": ("pantograph_five_bar", ("arm1", "arm2"), ("wrist1", "elbow1")),
    "G1 ankle": (
        MODELS + "mjcf/g1_parallel_ankle.xml",
        ("left_motor_joint", "right_motor_joint"),
        ("pitch_joint", "roll_joint"),
    ),
}
"""Mechanism, given and found coordinates."""
CLOSED = {"four-bar", "slider", "gripper", "five-bar"}
"""Those that formulas solve both ways."""


class _Map:
    """A compiled map."""

    def __init__(self, folder, made):
        self.made, self.n = made, len(made.given)
        self.type = ctypes.c_double if made.real.name == "double" else ctypes.c_float
        self.library = ctypes.CDLL(str(folder / "code.so"))
        numbers = ((name, self.type) for name in ("residual", "step", "min_pivot"))
        fields = [("iterations", ctypes.c_uint8), *numbers, ("joint", ctypes.c_uint8)]
        self.info = type("Info", (ctypes.Structure,), {"_fields_": fields})

    def array(self, values):
        return (self.type * len(values))(*values)

    def solve(self, name, values, guess):
        """Status and answer of a direction."""
        out, info = self.array([7.0] * self.n), self.info()
        status = self._call(
            name, None, self.array(values), self.array(guess), out, ctypes.byref(info)
        )
        assert status == 0 or list(out) == [7.0] * self.n
        return status, np.array(out)

    def track(self, name, values, last):
        out, info = self.array(last), self.info()
        status = self._call(name, self.array(values), out, ctypes.byref(info))
        return status, np.array(out)

    def apply(self, name, *values, count=None):
        out = self.array([7.0] * (count or self.n))
        status = self._call(name, *(self.array(v) for v in values), out)
        return status, np.array(out)

    def _call(self, name, *arguments):
        return getattr(self.library, f"{self.made.name}_{name}")(*arguments)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """Maps by their key and type, each written and compiled once."""

    @cache
    def make(key, real):
        name, given, find = MAPS[key]
        mechanism, folder = symkin.load(name), tmp_path_factory.mktemp("map")
        options = Options(real, given=given, find=find)
        tools.write_untested(mechanism, folder, options)
        tools.passed(
            tools.built("gcc", folder, [f"{mechanism.name}_test.c", f"{mechanism.name}.c"], "test")
        )
        tools.built("gcc", folder, [f"{mechanism.name}.c"], "code.so", "-O1", "-shared", "-fPIC")
        return _Map(folder, JointMap(mechanism, options, Real(real)))

    return make


def _values(made, sample):
    return (made.direct.problem.select_values(sample.values, c) for c in (made.given, made.found))


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(["double", "float"], ["double"]))
@pytest.mark.parametrize("key", in_gate(MAPS, ["ankle", "slider"]))
def test_maps_lead_where_the_closure_does(compiled, key, real):
    """From the reference's values either way to configurations that Newton's method of the closure
    followed in small steps; and what the inverse finds leads back.
    """
    code = compiled(key, real)
    made = code.made
    home = [made.reference_of(c) for c in (made.given, made.found)]
    limit = 3e-4 if real == "float" else 1e-9
    scales = [
        np.array([1.0 if c.is_angular else made.size for c in part])
        for part in (made.given, made.found)
    ]
    for sample in map_configurations(made, 40, 5, 0.1, 0.4):
        given, found = _values(made, sample)
        status, answer = code.solve("direct", given, home[1])
        assert status == 0
        assert np.all(np.abs(answer - found) <= limit * scales[1])
        status, back = code.solve("inverse", answer, home[0])
        assert status == 0
        assert np.all(np.abs(back - given) <= limit * scales[0])
        near = given + 1e-3 * scales[0]
        status, moved = code.solve("direct", near, answer)
        assert status == 0
        for name, values, last, wanted, scale in (
            ("track", near, answer, moved, scales[1]),
            ("track_inverse", moved, given, near, scales[0]),
        ):
            status, tracked = code.track(name, values, last)
            assert status == 0
            assert np.all(np.abs(tracked - wanted) <= max(limit, 1e-4) * scale)


@pytest.mark.slow
@pytest.mark.parametrize("key", in_gate(MAPS, ["ankle"]))
def test_jacobians_are_differences_of_the_map(compiled, key):
    """J is the central difference of NAME_direct; rates are J's product, and torques do the same
    work on both sides.
    """
    code = compiled(key, "double")
    made, rng, step = code.made, np.random.default_rng(3), 1e-5
    for sample in map_configurations(made, 10, 6, 0.1, 0.4):
        given, found = _values(made, sample)
        status, flat = code.apply("jacobian", given, found, count=code.n**2)
        assert status == 0
        jacobian = flat.reshape(code.n, code.n)
        for j in range(code.n):
            ends = [
                code.solve("direct", given + s * step * np.eye(code.n)[j], found)
                for s in (1.0, -1.0)
            ]
            assert [status for status, _ in ends] == [0, 0]
            difference = (ends[0][1] - ends[1][1]) / (2 * step)
            np.testing.assert_allclose(
                jacobian[:, j], difference, rtol=1e-5, atol=1e-5 * (1 + np.abs(difference).max())
            )
        rates, torques = rng.normal(size=(2, code.n))
        moved, held = (
            code.apply("rates", given, found, rates),
            code.apply("torques", given, found, torques),
        )
        assert (moved[0], held[0]) == (0, 0)
        np.testing.assert_allclose(
            moved[1], jacobian @ rates, atol=1e-9 * (1 + np.abs(jacobian).max())
        )
        assert np.isclose(torques @ moved[1], held[1] @ rates, rtol=1e-9)


def _ankle_gaps(motors, angles):
    """How much longer each rod of the shipped ankle is than at the reference, squared, of motor and
    ankle angles in 50 digits, by the vectors of ankle.toml.
    """
    (pitch, roll), gaps = angles, []
    for motor, y, z, end in ((motors[0], 40, 250, 35), (motors[1], -40, 180, -35)):
        c, s = mp.cos(motor), mp.sin(motor)
        tip = (-45 * c + 5 * s, mp.mpf(y), z + 45 * s + 5 * c)
        across, up = end * mp.cos(roll) - 20 * mp.sin(roll), end * mp.sin(roll) + 20 * mp.cos(roll)
        held = (
            -50 * mp.cos(pitch) + up * mp.sin(pitch),
            across,
            50 * mp.sin(pitch) + up * mp.cos(pitch),
        )
        squares = sum((a - b) ** 2 for a, b in zip(tip, held, strict=True))
        gaps.append(squares - (5**2 + (y - end) ** 2 + (z - 15) ** 2))
    return gaps


def test_second_derivatives_are_differences_to_ten_digits(compiled):
    """Of the ankle, Jacobian and second derivatives are central differences of the angles at which
    rods keep their lengths, in 50 digits; the inverse Jacobian and the reflected inertia follow
    from them.
    """
    code, rng = compiled("ankle", "double"), np.random.default_rng(17)
    with mp.workdps(50):
        step = mp.mpf(10) ** -12
        for sample in map_configurations(code.made, 4, 7, 0.1, 0.4):
            motors = [float(v) for v in next(_values(code.made, sample))]
            near = [float(v) for v in list(_values(code.made, sample))[1]]

            def angles(a, b, motors=motors, near=near):
                moved = (motors[0] + a * step, motors[1] + b * step)
                found = mp.findroot(lambda *x: _ankle_gaps(moved, x), near, tol=1e-90)
                return np.array(list(found), dtype=object)

            at = {(a, b): angles(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)}
            first = np.array([at[1, 0] - at[-1, 0], at[0, 1] - at[0, -1]]).T / (2 * step)
            mixed = (at[1, 1] - at[1, -1] - at[-1, 1] + at[-1, -1]) / (4 * step**2)
            second = [
                [at[1, 0] - 2 * at[0, 0] + at[-1, 0], mixed * step**2],
                [mixed * step**2, at[0, 1] - 2 * at[0, 0] + at[0, -1]],
            ]
            second = np.moveaxis(np.array(second), 2, 0) / step**2
            found = [float(v) for v in at[0, 0]]
            jacobian, bends = code.array([0.0] * 4), code.array([0.0] * 8)
            numbers = code.array(motors), code.array(found)
            assert code._call("second", *numbers, jacobian, bends) == 0
            wanted, inverse = first.astype(float), np.linalg.inv(first.astype(float))
            np.testing.assert_allclose(np.reshape(jacobian, (2, 2)), wanted, rtol=0, atol=1e-10)
            np.testing.assert_allclose(
                np.reshape(bends, (2, 2, 2)), second.astype(float), rtol=0, atol=1e-10
            )
            status, back = code.apply("inverse_jacobian", motors, found, count=4)
            assert status == 0
            np.testing.assert_allclose(back.reshape(2, 2), inverse, rtol=0, atol=1e-10)
            inertias = rng.uniform(0.1, 2.0, 2)
            status, reflected = code.apply("inertia", motors, found, inertias, count=4)
            assert status == 0
            np.testing.assert_allclose(
                reflected.reshape(2, 2), inverse.T @ np.diag(inertias) @ inverse, atol=1e-9
            )


def test_a_jacobian_far_from_the_reference_is_that_of_its_values(tmp_path):
    """A boom in an oblique plane: where its line from the reference turned it by more than half a
    radian, cosine and sine of the line's middle were left in place of those of its end.
    """
    turn = symkin.Pose.from_rotation_vector([0, 0, 0], [0.5, 1.0, -0.4])
    joints = [
        ("boom", "R", (0, 0, 0), (0, 0, 1), ["base", "boom"]),
        ("foot", "R", (0.3, -0.2, 0), (0, 0, 1), ["base", "cylinder"]),
        ("stroke", "P", (0, 0, 0), (0.7, 0.9, 0), ["cylinder", "rod"]),
        ("pin", "R", (1, 0.7, 0), (0, 0, 1), ["rod", "boom"]),
    ]
    mechanism = symkin.Mechanism(
        "digger",
        link_joints=[
            symkin.LinkJoint(
                symkin.Joint(
                    name, kind, turn.apply(point), turn.turn(axis), actuated=name == "stroke"
                ),
                links,
            )
            for name, kind, point, axis, links in joints
        ],
    )
    options = Options("double", given=("stroke",), find=("boom",))
    tools.write_untested(mechanism, tmp_path, options)
    tools.built("gcc", tmp_path, ["digger.c"], "code.so", "-O1", "-shared", "-fPIC")
    code = _Map(tmp_path, JointMap(mechanism, options, Real("double")))
    step = 1e-6
    for angle in np.arange(-0.9, 0.91, 0.03):
        status, stroke = code.solve("inverse", [angle], [0.0])
        assert status == 0
        _, beside = code.solve("inverse", [angle + step], stroke)
        status, jacobian = code.apply("jacobian", stroke, [angle], count=1)
        assert status == 0
        assert math.isclose((beside[0] - stroke[0]) / step, 1.0 / jacobian[0], abs_tol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("key", in_gate(MAPS, ["G1 ankle"]))
def test_second_derivatives_are_differences_of_the_jacobian(compiled, key):
    """Central differences of NAME_jacobian along the map, of passive joints too; limits of torque
    and rate put one joint at its own.
    """
    code = compiled(key, "double")
    made, n, h = code.made, code.n, 1e-5
    for sample in map_configurations(made, 5, 12, 0.1, 0.3):
        given, found = _values(made, sample)
        matrix, bends = code.array([0.0] * n**2), code.array([0.0] * n**3)
        assert code._call("second", code.array(given), code.array(found), matrix, bends) == 0
        matrix, bends = np.reshape(matrix, (n, n)), np.reshape(bends, (n, n, n))
        for j in range(n):
            ends = []
            for sign in (1.0, -1.0):
                moved = given + sign * h * np.eye(n)[j]
                status, there = code.solve("direct", moved, found)
                assert status == 0
                status, flat = code.apply("jacobian", moved, there, count=n**2)
                assert status == 0
                ends.append(flat.reshape(n, n))
            difference = (ends[0] - ends[1]) / (2 * h)
            scale = 1 + np.abs(bends).max()
            np.testing.assert_allclose(bends[:, :, j], difference, rtol=0, atol=1e-4 * scale)
        own = np.arange(1.0, n + 1)
        for name, effects in (("torque", matrix), ("rate", np.linalg.inv(matrix).T)):
            status, limits = code.apply(f"{name}_limits", given, found, own)
            assert status == 0
            shares = np.abs(effects) * limits[:, None] / own
            np.testing.assert_allclose(shares.max(axis=1), 1.0, rtol=1e-9)


def _walked(problem, z, begin, end, steps):
    """The unknowns after the straight line of known values, point by point; None where a point has
    no configuration, is singular or lies far from the one before.
    """
    system, sign = problem.system, 0.0
    scales = np.array(
        [1.0 if c.is_angular else problem.closure.characteristic_length for c in system.unknowns]
    )
    for k in range(steps + 1):
        known = begin + k / steps * (end - begin)
        moved = system.polish(z, known, 8)
        if system.residual(moved, known) > 1e-9 * system.characteristic_length:
            return None
        if np.max(np.abs(moved - z) / scales) > max(0.05, 30 / steps):
            return None
        now = float(np.sign(np.linalg.det(system.linearise_one(moved, known)[1])))
        if now * sign < 0.0:
            return None
        z, sign = moved, now
    return z


@pytest.mark.slow
@pytest.mark.parametrize("reach", in_gate([0.5, 2.6], [2.6]))
@pytest.mark.parametrize("direction", in_gate(["direct", "inverse"], ["direct"]))
@pytest.mark.parametrize("key", in_gate(["ankle", "four-bar", "gripper", "five-bar"], ["ankle"]))
def test_ok_means_that_the_machine_can_move_there(compiled, key, direction, reach):
    """Lines between random values: an answer that is OK is the end of a fine walk with every point
    real and regular, and most lines that can be walked are OK.
    """
    code = compiled(key, "double")
    made, rng = code.made, np.random.default_rng(8)
    problem = getattr(made, direction).problem
    known, wanted = (made.given, made.found) if direction == "direct" else (made.found, made.given)
    samples = map_configurations(made, 30, 9, 0.1, min(reach, 0.8))
    counts = Counter()
    for _ in range(60):
        values = samples[rng.integers(len(samples))].values
        begin = values[problem.known_places]
        scales = np.array([1.0 if c.is_angular else 0.5 * made.size for c in known])
        end = begin + reach * scales * rng.uniform(-1, 1, code.n)
        status, answer = code.solve(direction, end, problem.select_values(values, wanted))
        walked = _walked(problem, values[problem.unknown_places], begin, end, 150)
        if status == 0 and walked is None:
            walked = _walked(problem, values[problem.unknown_places], begin, end, 3000)
        counts["regular"] += walked is not None
        counts["ok"] += status == 0
        if status != 0:
            continue
        assert walked is not None
        there = values.copy()
        there[problem.unknown_places] = walked
        off = answer - problem.select_values(there, wanted)
        turns = np.array(
            [
                round(float(v) / (2 * np.pi)) if c.is_angular else 0
                for v, c in zip(off, wanted, strict=True)
            ]
        )
        np.testing.assert_allclose(off - 2 * np.pi * turns, 0.0, atol=1e-6 * max(1.0, made.size))
    assert counts["ok"] >= 0.9 * counts["regular"]
    assert counts["ok"] > 5


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("cc", ["gcc", "clang"])
def test_anything_may_be_given(compiled, cc, tmp_path):
    """Random bits as numbers, under ASan and UBSan: what leaves with OK is finite."""
    del compiled
    mechanism = symkin.load("ankle")
    write_folder(mechanism, tmp_path, Options("float", given=ANKLE[1], find=ANKLE[2]))
    (tmp_path / "fuzz.c").write_text(_FUZZ)
    program = tools.built(
        cc,
        tmp_path,
        ["fuzz.c", "ankle.c"],
        "fuzz",
        "-O1",
        "-g",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
    )
    done = subprocess.run([str(program)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


_FUZZ = r"""
#include "ankle.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static uint32_t state = 1U;

static float number(void)
{
    float value;
    state = state * 1664525U + 1013904223U;
    uint32_t bits = state;
    state = state * 1664525U + 1013904223U;
    if ((state >> 30) != 0U) {
        return ((float)(bits >> 8) / 16777216.0f - 0.5f) * (((state >> 29) & 1U) != 0U ?
          2.0f : 8.0f);
    }
    memcpy(&value, &bits, sizeof value);
    return value;
}

int main(void)
{
    for (int k = 0; k < 20000; ++k) {
        float a[2] = { number(), number() };
        float b[2] = { number(), number() };
        float c[2] = { number(), number() };
        float out[2];
        float matrix[4];
        float second[8];
        ankle_info info;
        ankle_config config = { number(), (uint8_t)(number() > 0.0f ? 20 : 0), number() };
        int bad = 0;
        if (ankle_direct(k % 3 ? NULL : &config, a, b, out, &info) == ANKLE_OK) {
            bad = bad || !isfinite(out[0]) || !isfinite(out[1]);
        }
        if (ankle_inverse(k % 3 ? NULL : &config, a, b, out, &info) == ANKLE_OK) {
            bad = bad || !isfinite(out[0]) || !isfinite(out[1]);
        }
        if (ankle_jacobian(a, b, matrix) == ANKLE_OK) {
            bad = bad || !isfinite(matrix[0]) || !isfinite(matrix[1]);
            bad = bad || !isfinite(matrix[2]) || !isfinite(matrix[3]);
        }
        if (ankle_torques(a, b, c, out) == ANKLE_OK) {
            bad = bad || !isfinite(out[0]) || !isfinite(out[1]);
        }
        if (ankle_second(a, b, matrix, second) == ANKLE_OK) {
            for (int i = 0; i < 8; ++i) {
                bad = bad || !isfinite(second[i]) || !isfinite(matrix[i / 2]);
            }
        }
        if (ankle_inertia(a, b, c, matrix) == ANKLE_OK) {
            bad = bad || !isfinite(matrix[0]) || !isfinite(matrix[1]);
            bad = bad || !isfinite(matrix[2]) || !isfinite(matrix[3]);
        }
        if (ankle_torque_limits(a, b, c, out) == ANKLE_OK) {
            bad = bad || !isfinite(out[0]) || !isfinite(out[1]);
        }
        if (ankle_rate_limits(a, b, c, out) == ANKLE_OK) {
            bad = bad || !isfinite(out[0]) || !isfinite(out[1]);
        }
        if (ankle_rates(a, b, c, out) == ANKLE_OK) {
            bad = bad || !isfinite(out[0]) || !isfinite(out[1]);
        }
        if (ankle_track(a, b, &info) == ANKLE_OK) {
            bad = bad || !isfinite(b[0]) || !isfinite(b[1]);
        }
        if (ankle_track_inverse(c, a, &info) == ANKLE_OK) {
            bad = bad || !isfinite(a[0]) || !isfinite(a[1]);
        }
        if (bad) {
            printf("case %d\n", k);
            return 1;
        }
    }
    return 0;
}
"""


def _refused(name, given, find):
    """The sentence; nothing is written before it."""
    with pytest.raises(InputError) as found:
        build_program(symkin.load(name), Options(given=tuple(given), find=tuple(find)))
    return str(found.value)


def test_what_cannot_be_is_a_sentence():
    """Names that nothing has, too few or too many, both at once, and coordinates that decide
    nothing.
    """
    assert "has no coordinate 'uper_motor' (do you mean 'upper_motor'?)" in _refused(
        "ankle", ["uper_motor"], ["ankle.1"]
    )
    assert "--given needs --find beside it" in _refused("ankle", ["upper_motor"], [])
    assert "--find needs --given beside it" in _refused("ankle", [], ["ankle.1"])
    assert "upper_motor: given and to be found at once" in _refused(
        "ankle", ["upper_motor", "lower_motor"], ["upper_motor", "ankle.1"]
    )
    assert "upper_motor stands there twice" in _refused(
        "ankle", ["upper_motor", "upper_motor"], ["ankle.1", "ankle.2"]
    )
    assert "have 2 freedom(s); give 1 more" in _refused("ankle", ["upper_motor"], ["ankle.1"])
    assert "leave 1 out: their values would have to agree" in _refused(
        "four_bar", ["crank", "crank_pin"], ["follower"]
    )
    assert "as many of both" in _refused("ankle", ["upper_motor", "lower_motor"], ["ankle.1"])
    message = _refused("pantograph_five_bar", ["arm1", "arm2"], ["plate_pivot", "lower_guide_base"])
    assert "--find plate_pivot, lower_guide_base does not determine --given arm1, arm2" in message
    assert "left-hip-roll is in no loop" in _refused(
        MODELS + "mjcf/cassie.xml", ["left-hip-roll"], ["left-foot-crank"]
    )


def test_the_command_writes_a_map(tmp_path):
    """--given and --find with a file of another format: a folder whose manifest names both; without
    --find a sentence.
    """
    options = [
        "firmware",
        MAPS["G1 ankle"][0],
        "--given",
        "left_motor_joint,right_motor_joint",
        "-o",
        str(tmp_path),
    ]
    found = CliRunner().invoke(app, options)
    assert isinstance(found.exception, InputError)
    assert "--given needs --find beside it" in str(found.exception)


def test_closed_forms_are_found():
    """Motors from ankle angles by A cos + B sin = C each; linkages of two links both ways by
    formulas, a mimicked finger too.
    """
    for key, (name, given, find) in MAPS.items():
        made = JointMap(symkin.load(name), Options(given=given, find=find), Real("double"))
        assert (made.direct.is_closed and made.inverse.is_closed) == (key in CLOSED)
        if key == "ankle":
            assert [len(part.form.names) for part in made.inverse.parts] == [1, 1]


def test_polynomials_about_home_lie_where_the_map_leads():
    """Within the box of the home sheet, straight lines from the reference end where its polynomials
    are, to their stated error.
    """
    made = JointMap(symkin.load("ankle"), Options(given=ANKLE[1], find=ANKLE[2]), Real("double"))
    sheet = home_sheet(made, made.direct, made.found)
    assert sheet is not None
    values, rng, problem = (
        ca.Function("f", [sheet.known], [sheet.values]),
        np.random.default_rng(4),
        made.direct.problem,
    )
    begin, home = made.reference_of(made.given), made.reference_of(made.direct.unknown)
    shares = rng.uniform(-1, 1, (30, len(begin)))
    ends, whole = all_followed(problem, home, begin, begin + shares * sheet.reach)
    assert whole.all()
    for share, there in zip(shares, ends, strict=True):
        full = made.reference.copy()
        full[problem.unknown_places] = there
        found = problem.select_values(full, made.found)
        np.testing.assert_allclose(
            np.asarray(values(share * sheet.reach)).ravel(), found, atol=1.5 * sheet.error
        )


WHEELS = """format = 1
name = "wheels"
length_unit = "m"
angle_unit = "rad"
[[joint]]
name = "x"
type = "R"
links = ["base", "a"]
point = [0.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
[[joint]]
name = "y"
type = "R"
links = ["base", "b"]
point = [1.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
[[coupling]]
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "coupling",
    [
        'joint = "y"\nof = { x = -1.5 }\n',
        pytest.param('joint = "x"\nof = { y = "-2/3" }\n', marks=pytest.mark.long),
    ],
)
def test_wheels_follow_their_drivers_over_whole_turns(tmp_path, coupling):
    """y = -3/2 x from guess to guess over four turns, both ways: values count with their whole
    turns, as a wheel's place alone would not tell its driver's.
    """
    (tmp_path / "wheels.toml").write_text(WHEELS + coupling)
    mechanism, options = (
        symkin.load(tmp_path / "wheels.toml"),
        Options("double", given=("x",), find=("y",)),
    )
    tools.write_untested(mechanism, tmp_path / "c", options)
    tools.passed(tools.built("gcc", tmp_path / "c", ["wheels_test.c", "wheels.c"], "test"))
    tools.built("gcc", tmp_path / "c", ["wheels.c"], "code.so", "-O1", "-shared", "-fPIC")
    code = _Map(tmp_path / "c", JointMap(mechanism, options, Real("double")))
    for name, ratio in (("direct", -1.5), ("inverse", -2 / 3)):
        answer = np.zeros(1)
        for value in np.linspace(0.0, 8 * np.pi, 41):
            status, answer = code.solve(name, [value], answer)
            assert status == 0
            assert answer == pytest.approx([ratio * value], abs=1e-9)


@pytest.mark.skipif(not can_run(), reason="no C compiler")
@pytest.mark.parametrize(
    ("given", "find"),
    in_gate(
        [
            ("bucket_cylinder", "bucket"),
            ("boom", "boom_cylinder"),
            ("stick_cylinder,boom_cylinder", "boom,stick"),
        ],
        [("stick_cylinder,boom_cylinder", "boom,stick")],
    ),
)
def test_a_map_of_some_loops_of_a_machine_is_of_the_rows_of_these(given, find):
    """The groups of each way hold rows of the loops of their joints, each of the closure's row of
    that number.
    """
    options = Options("double", given=tuple(given.split(",")), find=tuple(find.split(",")))
    made = build_program(symkin.load("excavator_bucket"), options).kind
    for direction in (made.direct, made.inverse):
        for group in (part.problem for part in direction.parts):
            closure, values = group.closure, made.reference + 0.1
            rows = ca.Function(
                "rows",
                [closure.variables],
                [closure.bound(closure.rows)[list(group.row_places), 0], group.system.rows],
            )
            ours, its = rows(ca.DM(values))
            np.testing.assert_allclose(its.full(), ours.full(), rtol=1e-9, atol=1e-9 * made.size)
    run_own_test(made.name, folder_files(made.mechanism, options))
