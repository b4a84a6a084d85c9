"""The LinuxCNC component against shims of its headers, beside `solve` in Python."""

from __future__ import annotations

import subprocess

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import symkin
from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import Options, write_folder
from helpers.samples import readme_five_bar
from symkin import InputError

SHIMS = tools.HELPERS / "linuxcnc"


def component(mechanism, folder, **options):
    """The program that loads the component."""
    write_folder(mechanism, folder, Options("double", also=("linuxcnc",), **options))
    name = mechanism.name
    flags = [
        "-std=gnu11",
        "-O1",
        "-Wall",
        "-Wextra",
        "-Werror",
        f"-I{SHIMS}",
        f"-DJOINTS={len(mechanism.actuated)}",
    ]
    command = [
        tools.compiler("gcc"),
        *flags,
        f"{name}_kins.c",
        str(SHIMS / "runner.c"),
        "-lm",
        "-o",
        "runner",
    ]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "runner"


def asked(program, *lines):
    """The answers: a status and numbers a line."""
    done = subprocess.run(
        [program], input="\n".join(lines), capture_output=True, text=True, check=True
    )
    return [[float(number) for number in line.split()] for line in done.stdout.splitlines()]


def text(kind, *parts):
    return " ".join([kind, *(repr(float(v)) for part in parts for v in part)])


def units(mechanism):
    """A joint's unit of LinuxCNC (mm, degree) in the mechanism's (length unit, rad)."""
    scale = {"mm": 1.0, "m": 1000.0}[mechanism.length_unit]
    return np.array([180 / np.pi if c.is_angular else scale for c in mechanism.actuated]), scale


@pytest.mark.parametrize("name", in_gate(["zhang2009", "ren2008"], ["ren2008"]))
def test_a_hexapod_as_python_solves_it(name, tmp_path):
    """World coordinates in mm and degrees, R = Rz(C) Ry(B) Rx(A), joints in mm; forward undoes
    inverse, from other poses too.
    """
    mechanism = symkin.load(name)
    program = component(mechanism, tmp_path)
    per_joint, mm = units(mechanism)
    home = (
        np.array(mechanism.platform_position) if name == "ren2008" else np.array([0.0, 0.0, 420.0])
    )
    rng = np.random.default_rng(1)
    for _ in range(4):
        world = np.array([*(home * mm + rng.uniform(-20, 20, 3)), *rng.uniform(-8, 8, 3)])
        q = Rotation.from_euler("xyz", world[3:], degrees=True).as_quat()[[3, 0, 1, 2]]
        wanted = symkin.solve(mechanism, pose=[*(world[:3] / mm), *q]).solution
        wanted = np.array([wanted.joints[c.name] for c in mechanism.actuated]) * per_joint
        (inverse,) = asked(program, text("i", world, np.zeros(6)))
        assert inverse[0] == 0
        assert np.allclose(inverse[1:], wanted, atol=1e-6)
        # a fresh component begins at home
        (forward,) = asked(program, text("f", wanted))
        assert forward[0] == 0
        assert np.allclose(forward[1:], world, atol=1e-6)


@pytest.mark.parametrize(
    "name", in_gate(["delta", "zhao2000", "scara", "ur5e", "five_bar"], ["five_bar"])
)
def test_forward_undoes_inverse(name, tmp_path):
    """At the reference and beside it; world coordinates that a platform does not have are as at
    home, whatever is asked.
    """
    mechanism = readme_five_bar("planar") if name == "five_bar" else symkin.load(name)
    program = component(mechanism, tmp_path)
    per_joint, _ = units(mechanism)
    joints = np.array([c.reference[0] for c in mechanism.actuated]) * per_joint
    if name == "ur5e":
        joints = np.array([10.0, -80.0, 70.0, -60.0, 50.0, 20.0])
    if name == "scara":
        joints = np.where(
            [c.is_angular for c in mechanism.actuated],
            20.0,
            np.mean([c.limits or (0, 0) for c in mechanism.actuated], axis=1),
        )
    for shift in (0.0, 0.4, 1.1):
        moved = joints + shift * np.resize([1.0, -0.5, 0.7], len(joints))
        (forward,) = asked(program, text("f", moved))
        assert forward[0] == 0
        (inverse,) = asked(program, text("i", forward[1:], joints))
        assert inverse[0] == 0
        assert np.allclose(inverse[1:], moved, atol=1e-5)
    far, other = asked(program, text("i", [1e9, 0, 0, 0, 0, 0], joints), text("f", joints))
    assert far[0] == -1
    assert other[0] == 0


def test_pins_hold_the_geometry(tmp_path):
    """A base joint moved by 1 mm along a rod that stands upright changes this rod alone; a name
    that is no pin is refused by HAL.
    """
    mechanism = symkin.load("zhang2009")
    program = component(
        mechanism, tmp_path, geometry="struct", home=(0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)
    )
    world = text("i", [0, 0, 420, 0, 0, 0], np.zeros(6))
    before, status, after, wrong = asked(
        program, world, "p zhang2009_kins.offset.2 5.0", world, "p zhang2009_kins.offset.9 1.0"
    )
    assert (before[0], status[0], after[0], wrong[0]) == (0, 0, 0, -1)
    assert np.allclose(np.array(after[1:]) - before[1:], [0, 0, -5, 0, 0, 0], atol=1e-9)


def test_what_linuxcnc_cannot_take_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"--linuxcnc needs --real double"):
        write_folder(symkin.load("delta"), tmp_path, Options("float", also=("linuxcnc",)))
    assert not list(tmp_path.iterdir())
