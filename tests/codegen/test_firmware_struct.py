"""`--geometry struct`: generated C with another geometry gives the answers of the closure with that
geometry.
"""

from __future__ import annotations

import ctypes
import subprocess

import casadi as ca
import numpy as np
import pytest

from helpers import firmware_tools as tools
from helpers import joint_types, samples
from helpers.inside import (
    Geometry,
    Options,
    System,
    build_closure,
    build_problem,
    configurations,
    pose_of,
    scaled,
    write_folder,
)
from symkin import load

STRUCT = Options("double", geometry="struct")


def _library(mechanism, folder):
    write_folder(mechanism, folder, STRUCT)
    tools.passed(
        tools.built(
            "gcc", folder, [f"{mechanism.name}.c", f"{mechanism.name}_test.c"], "test", "-O1"
        )
    )
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


def _calibrated(mechanism, seed, only=""):
    """Parameters moved as a calibration moves them: by 1e-3 of the size, 1 mrad, and a thousandth
    of a direction; `only` those whose key path ends in one of some letters.
    """
    closure = build_closure(mechanism)
    moves = [
        1e-3
        * (mechanism.characteristic_length if _is_length(name) else 1.0)
        * name.endswith(tuple(only.split()) or ("",))
        for name in closure.parameter_names
    ]
    rng = np.random.default_rng(seed)
    return closure.parameter_values + np.array(moves) * rng.uniform(-1, 1, len(moves))


def _is_length(name):
    parts = name.split(".")
    return parts[-1] in ("d", "a", "length", "offset") or parts[-2] in (
        "point",
        "position",
        "base",
        "platform",
        "from",
    )


def _moved_system(problem, values):
    """The problem's system with other parameters."""
    closure, bound = problem.closure, problem.system
    rows, errors = (
        ca.substitute(e, closure.parameters, ca.SX(ca.DM(values)))
        for e in (closure.rows, closure.errors)
    )
    return System(
        bound.unknowns, bound.unknown, bound.known, rows, errors, bound.characteristic_length
    )


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", ["gluon_6l3", "yao2020"])
def test_arms_take_another_geometry(name, tmp_path):
    """The pose is that of the moved parameters, not the nominal one; the inverse leads back to the
    joints.
    """
    mechanism = load(name)
    library, closure, values = (
        _library(mechanism, tmp_path),
        build_closure(mechanism),
        _calibrated(mechanism, 3),
    )
    joints = build_problem(mechanism, "inverse").system.unknown
    assert closure.forward is not None
    forward = ca.Function(
        "f",
        [joints, closure.parameters],
        [ca.vertcat(closure.forward.position, closure.forward.quaternion)],
    )
    rng, n = np.random.default_rng(5), len(mechanism.actuated)
    for _ in range(5):
        q = np.array([c.reference[0] for c in mechanism.actuated]) + rng.uniform(-0.5, 0.5, n)
        pose, answer = (ctypes.c_double * 7)(), (ctypes.c_double * n)()
        assert getattr(library, f"{name}_direct")(_numbers(values), _numbers(q), pose) == 0
        expected = np.asarray(forward(q, values)).ravel()
        expected[3:] *= np.sign(expected[3:] @ np.array(pose[3:])) / np.linalg.norm(expected[3:])
        assert np.allclose(pose, expected, rtol=0, atol=1e-12 * mechanism.characteristic_length)
        nominal = np.asarray(forward(q, closure.parameter_values)).ravel()
        assert np.linalg.norm(nominal[:3] - expected[:3]) > 1e-5 * mechanism.characteristic_length
        guess = q + rng.uniform(-1e-3, 1e-3, n)
        if (
            getattr(library, f"{name}_inverse")(
                _numbers(values), None, pose, _numbers(guess), answer, None
            )
            == 0
        ):
            again = (ctypes.c_double * 7)()
            assert getattr(library, f"{name}_direct")(_numbers(values), answer, again) == 0
            assert np.allclose(again, pose, rtol=0, atol=1e-7 * mechanism.characteristic_length)


PLATFORMS = {
    "six cranks": (joint_types.rods_at_the_end, ""),
    "6-UPS by joints": (joint_types.universal, ""),
    "3-RRR": (lambda: samples.three_rrr("planar"), "point.x point.y"),
}
"""Mechanisms, and which parameters may move without contradicting the others."""


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", list(PLATFORMS))
def test_platforms_take_another_geometry(name, tmp_path):
    """Direct and inverse problem agree with Newton's method on the closure with the moved
    parameters.
    """
    made, movable = PLATFORMS[name]
    mechanism = made()
    library, values = _library(mechanism, tmp_path), _calibrated(mechanism, 4, movable)
    direct = build_problem(mechanism, "direct")
    system, closure, size = (
        _moved_system(direct, values),
        direct.closure,
        mechanism.characteristic_length,
    )
    n = len(mechanism.actuated)
    for case in configurations(direct, closure.reference, 4, 6, spread=0.05, turn=0.1):
        z = system.polish(case.unknown, case.known, 8)
        assert system.residual(z, case.known) < 1e-10 * size
        expected = pose_of(closure, direct.join_values(z, case.known))
        guess = pose_of(closure, case.values)
        pose = (ctypes.c_double * 7)()
        start = _numbers([*guess.position, *guess.quaternion])
        status = getattr(library, f"{mechanism.name}_direct")(
            _numbers(values), None, _numbers(case.known), start, pose, None
        )
        assert status == 0
        assert np.allclose(pose[:3], expected.position, rtol=0, atol=1e-9 * size)
        assert np.linalg.norm(np.array(pose[:3]) - guess.position) > 1e-5 * size
        joints = (ctypes.c_double * n)()
        assert getattr(library, f"{mechanism.name}_inverse")(_numbers(values), pose, joints) == 0
        assert np.allclose(joints, case.known, rtol=0, atol=1e-8 * size)


@pytest.mark.long
def test_loops_that_do_not_close_are_not_ok(tmp_path):
    """An overconstrained machine whose parameters contradict one another: no pose is called OK."""
    mechanism = load("zhao2000_links")
    library, values = _library(mechanism, tmp_path), _calibrated(mechanism, 7)
    reference = mechanism.reference_pose
    joints = _numbers([c.reference[0] for c in mechanism.actuated])
    pose = (ctypes.c_double * 7)()
    start = _numbers([*reference.position, *reference.quaternion])
    nominal = _numbers(build_closure(mechanism).parameter_values)
    assert library.zhao2000_links_direct(nominal, None, joints, start, pose, None) == 0
    assert library.zhao2000_links_direct(_numbers(values), None, joints, start, pose, None) != 0


def test_members_are_key_paths_in_letters_of_c():
    """One member a parameter, each another."""
    closure = build_closure(load("gluon_6l3"))
    members = Geometry(closure, True).members
    assert len(set(members)) == len(closure.parameter_names)
    assert members[0] == "dh_1_theta"
    assert Geometry(closure, False).members == []


@pytest.mark.parametrize("factor", [1e-8, 1e-3, 1e3])
def test_bounds_of_lengths_in_a_struct_follow_the_size(factor):
    """A machine of lengths alone takes numbers in proportion to its size, up to 1,000 sizes and its
    own; one with angles and directions takes a whole turn and unit vectors at any size.
    """
    rods = load("zhang2009")
    own, other = (_geometry(m) for m in (rods, scaled(rods, factor)))
    assert other.largest == pytest.approx(factor * own.largest, rel=1e-2)
    arm = _geometry(scaled(samples.pieper(), factor))
    most = 1000 * arm.closure.characteristic_length + np.max(np.abs(arm.values))
    assert 2 * np.pi < arm.largest < 1.01 * (most + 2 * np.pi)


def _geometry(mechanism):
    return Geometry(build_closure(mechanism), True)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
def test_struct_folders_of_all_kinds_pass_with_nominal_numbers(real, tmp_path):
    """The folder's own test, with the nominal initialiser."""
    for mechanism in (
        load("zhang2009"),
        load("yao2020"),
        samples.five_bar(),
        samples.four_bar()[0],
    ):
        folder = tmp_path / mechanism.name
        write_folder(mechanism, folder, Options(real, geometry="struct"))
        tools.passed(
            tools.built(
                "gcc", folder, [f"{mechanism.name}.c", f"{mechanism.name}_test.c"], "test", "-O1"
            )
        )
        tools.built("gcc", folder, [f"{mechanism.name}.c", "example_main.c"], "example", "-O1")
