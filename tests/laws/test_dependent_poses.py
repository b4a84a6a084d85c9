"""Laws of platforms whose joints tie the coordinates of their pose: what is printed is accepted,
what is near is projected.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.samples import exechon, parallel_rrr, tied_platform
from symkin import InputError, SolveError


def _printed(pose: symkin.Pose) -> list[float]:
    """As tables print: three digits of a length, five of a quaternion."""
    return [
        *(round(float(v), 3) for v in pose.position),
        *(round(float(v), 5) for v in pose.quaternion),
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    "make",
    [
        pytest.param(lambda: tied_platform(False), id="3RPS"),
        pytest.param(lambda: tied_platform(True), id="3RRS", marks=pytest.mark.long),
        pytest.param(exechon, id="Exechon"),
    ],
)
def test_a_printed_pose_is_accepted_and_every_limb_is_complete(make):
    """Two branches in each of three limbs: eight modes, among them the joints that gave the
    pose.
    """
    machine = make()
    given = [4.0, -7.0, 3.0]
    pose = symkin.solve(machine, joints=given).solution.pose
    found = symkin.modes(machine, pose=_printed(pose))
    assert len(found) == 8
    assert found.completeness == "probability one"
    assert found.complex_count == 8
    assert any("projected" in note for note in found.notes)
    assert min(np.max(np.abs(np.array(mode.actuated_values) - given)) for mode in found) < 0.01
    assert all(mode.residual < 1e-9 * machine.characteristic_length for mode in found)
    one = symkin.solve(machine, pose=_printed(pose))
    assert (
        np.max(np.abs(one.solution.position - pose.position)) < 2e-5 * machine.characteristic_length
    )


def test_a_pose_off_the_feasible_ones_is_told_how_far_and_which_is_nearest():
    """The nearest pose that the message names is accepted as it stands, and none on the way to it
    is nearer.
    """
    machine = tied_platform(False)
    pose = symkin.solve(machine, joints=[4.0, -7.0, 3.0]).solution.pose
    off = [*(np.asarray(pose.position) + [1.0, 0.0, 0.0]), *pose.quaternion]
    found = symkin.modes(machine, pose=off)
    assert not found.modes
    note = next(note for note in found.notes if "nearest is" in note)
    nearest = [float(v) for v in note.split("nearest is ")[1].split(",")]
    assert 0.01 < float(note.split("lies ")[1].split()[0]) < 1.1
    assert symkin.solve(machine, pose=nearest).solution is not None
    with pytest.raises(SolveError, match="the nearest is"):
        symkin.solve(machine, pose=off)


def test_random_feasible_poses_come_back_through_rounding():
    rng = np.random.default_rng(1)
    machine = tied_platform(True, (100.0, 110.0, 90.0))
    for joints in rng.uniform(-12, 12, (6, 3)):
        pose = symkin.solve(machine, joints=joints).solution.pose
        back = symkin.solve(machine, pose=_printed(pose), start=joints).solution
        assert np.max(np.abs(np.array(back.actuated_values) - joints)) < 0.02


def test_a_platform_of_six_freedoms_is_never_projected():
    machine = symkin.load("zhang2009")
    found = symkin.solve(machine, pose=[10.0, 20.0, 300.0, 0.98, 0.1, 0.1, 0.1])
    assert not found.notes


@pytest.mark.parametrize("length", [1e20, 1e150])
def test_lengths_of_rods_that_no_machine_has_end_without_an_infinite_error(length):
    result = symkin.solve(symkin.load("zhang2009"), joints=[length] * 6, check=False)
    assert result.solution is not None or math.isfinite(result.smallest_residual)


def test_motors_that_are_too_few_are_told_wherever_modes_are_followed_or_counted(tmp_path):
    """No motion is declared, so that rows lose rank only where loops close: no singular start, no
    double solution, no count of modes, but the unknown that stays free.
    """
    ball = exechon().limbs[2]
    slide = replace(ball.joints[1], actuated=False)
    limbs = [*exechon().limbs[:2], replace(ball, joints=[ball.joints[0], slide, ball.joints[2]])]
    machine, free = replace(exechon(), limbs=limbs), "leaves 1 of 10 unknowns free"
    found = symkin.solve(machine, joints=[1.0, 0.0])
    assert any(free in note for note in found.notes)
    listed = symkin.modes(machine, joints=[1.0, 0.0])
    assert (len(listed), listed.positive_dimensional, listed.starts) == (0, True, None)
    assert any(free in note for note in listed.notes)
    told = symkin.singularity(machine, joints=[1.0, 0.0])
    assert any(free in note for note in told.solution.notes)
    for solution in (found.solution, told.solution):
        assert not any("double" in note or "multiple" in note for note in solution.notes)
    for ask in (
        lambda: symkin.track(machine, joints=[[0, 0], [5, 3]]),
        lambda: symkin.sweep(machine, {"p1": [0.0, 1.0]}, tmp_path / "swept", workers=0),
        lambda: symkin.write_firmware(machine, tmp_path / "code"),
    ):
        with pytest.raises(InputError, match=free):
            ask()


def test_a_sweep_counts_no_modes_where_none_is_isolated(tmp_path):
    """Motion declared: what `modes` says of an input, a sweep says of all of them."""
    machine = parallel_rrr("planar")
    first = replace(machine.limbs[0].joints[0], actuated=False)
    free = replace(machine.limbs[0], joints=[first, *machine.limbs[0].joints[1:]])
    machine = replace(machine, limbs=[free, *machine.limbs[1:]])
    assert symkin.modes(machine, joints=[0.0, 0.0]).positive_dimensional
    with pytest.raises(InputError, match="leaves 1 of 7 unknowns free"):
        symkin.sweep(machine, {"q2": [0.0, 0.1]}, tmp_path / "swept", workers=0)
