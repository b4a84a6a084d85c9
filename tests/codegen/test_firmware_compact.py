"""`--compact`: less code with the answers of the plain folder, for every kind of machine."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.arms import free, serial
from helpers.gate import in_gate, in_gate_but
from helpers.inside import Options, build_program, codegen_folder, write_folder
from symkin import InputError

MACHINES = Path(__file__).parents[2] / "codegen" / "bench" / "machines"
HOME = (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)
PLATFORMS = {
    "zhang2009": ("zhang2009", {"home": HOME}, HOME),
    "three_rrr": (str(MACHINES / "three_rrr.toml"), {}, None),
}
"""What is loaded, its options, and the pose about which goals lie (None: the reference's)."""


def asked(name, options, real, *, compact):
    """The compiled code of one machine."""
    return tools.bench_module("asked").Asked(
        symkin.load(name), Options(real, compact=compact, **options)
    )


def poses_about(mechanism, home, count, reach, turn, rng):
    """Poses about home: shifts within `reach` and turns within `turn` (rad) as the platform's
    motion allows.
    """
    centre = np.array(
        [*mechanism.platform_position, *mechanism.platform_quaternion] if home is None else home,
        dtype=float,
    )
    poses = np.tile(centre, (count, 1))
    poses[:, : 2 if mechanism.motion == "planar" else 3] += rng.uniform(
        -reach, reach, (count, 2 if mechanism.motion == "planar" else 3)
    )
    if mechanism.motion != "translation":
        half = (
            0.5
            * rng.uniform(-turn, turn, (count, 3))
            * ([0, 0, 1] if mechanism.motion == "planar" else [1, 1, 1])
        )
        poses[:, 3:] = (
            np.column_stack([np.ones(count), half]) / np.sqrt(1 + np.sum(half**2, axis=1))[:, None]
        )
    return poses


@pytest.mark.parametrize("real", in_gate(["float", "double"], ["float"]))
@pytest.mark.parametrize("machine", in_gate_but(PLATFORMS, ["three_rrr"]))
def test_platforms_answer_as_the_plain_code_does(machine, real):
    """Near poses and far ones, of which some are refused, and joint values without a pose: statuses
    and poses are the same.
    """
    tools.compiler("gcc")
    name, options, home = PLATFORMS[machine]
    plain, small = (asked(name, options, real, compact=compact) for compact in (False, True))
    mechanism, rng = plain.mechanism, np.random.default_rng(3)
    size = mechanism.characteristic_length
    near, far = (
        poses_about(mechanism, home, 300, part * size, turn, rng)
        for part, turn in ((0.05, 0.2), (0.4, 1.0))
    )
    poses = np.vstack([near, far])
    (status, joints), (other, again) = plain.back(poses), small.back(poses)
    np.testing.assert_array_equal(other, status)
    bound = (4e-6 if real == "float" else 1e-13) * size
    np.testing.assert_allclose(again, joints, atol=bound)
    goals = joints + np.where(
        np.arange(len(joints)) % 7 == 0, 0.3 * rng.normal(size=len(joints)), 0.0
    )[:, None] * np.abs(joints)
    guesses = poses_about(mechanism, home, len(goals), 0.0, 0.0, rng)
    first, second = plain.answers(goals, guesses), small.answers(goals, guesses)
    good = (first.status == 0) & (second.status == 0)
    assert good.sum() > 250
    # on a line that passes a limit within rounding either code may be the one that refuses
    # pivots tell which steps are far: other factors judge some far lines otherwise
    assert np.mean(first.status == second.status) > 0.95
    assert len(set(first.status)) > 1
    np.testing.assert_allclose(second.found[good], first.found[good], atol=50 * bound)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
def test_arms_answer_as_the_plain_code_does(real):
    """An arm without a closed form, whose inverse problem is iterated."""
    tools.compiler("gcc")
    rng = np.random.default_rng(0)
    arm = serial("general", [free(rng) for _ in range(6)], rng)
    asked = tools.bench_module("asked").Asked
    plain, small = (asked(arm, Options(real, compact=compact)) for compact in (False, True))
    guesses = rng.uniform(-1, 1, (300, 6))
    joints = guesses + 0.3 * rng.normal(size=(300, 6))
    (status, poses), (other, again) = plain.back(joints), small.back(joints)
    np.testing.assert_array_equal(other, status)
    np.testing.assert_array_equal(again, poses)
    first, second = plain.answers(poses, guesses), small.answers(poses, guesses)
    good = (first.status == 0) & (second.status == 0)
    assert good.sum() > 100
    # pivots tell which steps are far: other factors judge some far lines otherwise
    assert np.mean(first.status == second.status) > 0.95
    np.testing.assert_allclose(
        second.found[good], first.found[good], atol=3e-2 if real == "float" else 1e-8
    )


@pytest.mark.long
@pytest.mark.parametrize("name", ["zhang2009", "ren2008"])
def test_the_folder_passes_its_own_test_and_is_smaller(name, tmp_path):
    """Vectors of the Python solvers, Jacobians, rates and refusals; machine code of the host's
    compiler.
    """
    sizes = []
    for compact in (False, True):
        folder = tmp_path / str(compact)
        options = {"home": HOME} if name == "zhang2009" else {}
        write_folder(symkin.load(name), folder, Options("float", compact=compact, **options))
        tools.passed(tools.built("gcc", folder, [f"{name}.c", f"{name}_test.c"], "test", "-O1"))
        subprocess.run(
            [tools.compiler("gcc"), "-O2", "-fno-math-errno", "-c", f"{name}.c", "-o", "code.o"],
            cwd=folder,
            check=True,
        )
        text = subprocess.run(
            ["size", "code.o"], cwd=folder, check=True, capture_output=True, text=True
        ).stdout
        sizes.append(int(text.split("\n")[1].split()[0]))
    assert sizes[1] < 0.97 * sizes[0]


def test_the_option_is_written_down():
    program = build_program(symkin.load("ren2008"), Options("float", compact=True))
    assert "options: --real float --compact." in program.header
    assert '"compact": true' in codegen_folder.manifest(program, {})
    assert "compact" not in tools.manifest("ren2008_float")["options"]


def test_maps_are_refused(tmp_path):
    options = Options(
        given=("upper_motor", "lower_motor"), find=("ankle.1", "ankle.2"), compact=True
    )
    with pytest.raises(InputError, match="leave --compact out"):
        write_folder(symkin.load("ankle"), tmp_path, options)


@pytest.mark.parametrize("name", ["delta", "ur5e"])
def test_machines_whose_code_is_as_short_as_it_gets_are_refused(name, tmp_path):
    """Formulas, and more unknowns than are unrolled."""
    with pytest.raises(InputError, match="nothing that --compact would shorten"):
        write_folder(symkin.load(name), tmp_path, Options("float", compact=True))
    assert not list(tmp_path.iterdir())
