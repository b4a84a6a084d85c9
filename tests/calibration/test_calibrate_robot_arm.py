"""Arms that a robot's file describes as graphs: what joint noise does to their poses, and plans
about a level tool.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.gate import in_gate
from helpers.inside import build_calibration, joint_covariance
from symkin import Measurements, ReadOptions

ARM = Path(__file__).parents[2] / "docs" / "robots" / "arm.urdf"


def test_joint_noise_moves_poses_of_open_chains() -> None:
    """The noise of a joint moves the pose of a graph, a function of the joints without unknowns, by
    central differences.
    """
    arm = symkin.load(ARM, ReadOptions(platform="tool0"))
    joints = np.array([[0.3, -0.4, 0.2, 0.5, -0.6, 0.1]])
    found = symkin.solve(arm, joints=joints[0].tolist()).solution
    made = Measurements(
        joints, position=np.array([found.position]), orientation=np.array([found.quaternion])
    )
    problem = build_calibration(arm, made)
    z, p, q = np.zeros((1, 0)), problem.model.nominal, np.array([found.quaternion])
    step = 1e-6
    for k in range(6):
        alone = replace(problem, measurements=replace(made, joint_sigma=np.eye(6)[k]))
        aside = [
            problem.model.evaluate(z, joints + sign * step * np.eye(6)[k], p, q).readings[0]
            for sign in (1, -1)
        ]
        slopes = (aside[0] - aside[1]) / (2 * step)
        made_by_it = joint_covariance(alone, p, z)[0]
        np.testing.assert_allclose(made_by_it, np.outer(slopes, slopes), atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("seed", in_gate([0, 1], [0]))
def test_simulated_measurements_are_believable(
    seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whole poses with noise of joints and of readings, as stated in the file: no posture is an
    outlier.
    """
    data, words = tmp_path / "data.csv", ["--platform", "tool0"]
    more = ["--readings", "pose", "--postures", "40", "--seed", seed]
    assert run(capsys, "calibrate", "simulate", ARM, *words, "-o", data, *more)[0] == 0
    status, out, _ = run(capsys, "calibrate", "fit", ARM, data, *words, "-o", tmp_path / "fit")
    assert status == 0, out
    assert "believable: the residuals are as the stated noise lets expect" in out
    assert "40 of 40 postures" in out


@pytest.mark.slow
def test_one_posture_tells_zeros_and_no_geometry(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A pose of an arm tells the six zeros of its joints; all 24 parameters leave it 18 to choose,
    and its pose the one that was measured.
    """
    data, more = tmp_path / "data.csv", ["--readings", "pose", "--postures", "1"]
    assert run(capsys, "calibrate", "simulate", "ur5e", "-o", data, *more)[0] == 0
    fit = ("calibrate", "fit", "ur5e", data)
    status, out, _ = run(capsys, *fit, "-o", tmp_path / "all")
    assert status == 3
    assert "do not determine the geometry" in out
    assert run(capsys, *fit, "-o", tmp_path / "zeros", "--parameters", "dh.*.theta")[0] == 0


@pytest.mark.slow
@pytest.mark.long
def test_a_misfit_is_compared_with_that_of_the_nominal_geometry(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Angles that are coarser than the machine is off its file: the verdict gives both misfits."""
    data, noise = tmp_path / "data.csv", ["--noise-position", "0.01", "--noise-orientation", "0.2"]
    more = ["--readings", "pose", "--postures", "40", *noise]
    assert run(capsys, "calibrate", "simulate", "ur5e", "-o", data, *more)[0] == 0
    lines = [line for line in data.read_text().splitlines() if not line.startswith("#")]
    cells = [line.split(",") for line in lines]
    kept = [k for k, name in enumerate(cells[0]) if not name.startswith("sigma_")]
    data.write_text("".join(",".join(row[k] for k in kept) + "\n" for row in cells))
    status, out, _ = run(capsys, "calibrate", "fit", "ur5e", data, "-o", tmp_path / "fit")
    assert status == 3
    found = re.search(r"nominal geometry \((\S+) mm after (\S+) mm", out)
    assert found is not None
    assert 0.8 < float(found[1]) / float(found[2]) < 1.2


@pytest.mark.slow
def test_a_plan_about_a_level_tool(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two inclinations have no slopes where the tool's axis lies level, as this arm's does at zero:
    a plan is made all the same.
    """
    status, out, err = run(
        capsys,
        "calibrate",
        "plan",
        ARM,
        "--platform",
        "tool0",
        "-o",
        tmp_path / "plan.csv",
        "--readings",
        "pose",
        "--postures",
        "10",
    )
    assert status == 0, err
    assert "rank 30 of 30 parameters" in out
