"""Arms that a robot's file describes as graphs: what joint noise does to their poses, and plans
about a level tool.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.gate import in_gate
from helpers.inside import build_model
from symkin import Measurements, ReadOptions

ARM = Path(__file__).parents[2] / "docs" / "robots" / "arm.urdf"


def test_joint_noise_moves_poses_of_open_chains() -> None:
    """The slopes of positions by joints, of which a graph's pose is a function without unknowns,
    are central differences.
    """
    arm = symkin.load(ARM, ReadOptions(platform="tool0"))
    joints = np.array([[0.3, -0.4, 0.2, 0.5, -0.6, 0.1]])
    found = symkin.solve(arm, joints=joints[0].tolist()).solution
    made = Measurements(
        joints, position=np.array([found.position]), orientation=np.array([found.quaternion])
    )
    model = build_model(arm, made, ())
    quaternions = np.array([found.quaternion])
    z, p = np.zeros((1, 0)), np.zeros(0)
    slopes = model.joint_slopes(
        model.evaluate(z, joints, p, quaternions), z, joints, p, quaternions
    )[0]
    step = 1e-6
    for k in range(6):
        aside = [
            model.evaluate(z, joints + sign * step * np.eye(6)[k], p, quaternions).readings[0]
            for sign in (1, -1)
        ]
        np.testing.assert_allclose(-slopes[:, k], (aside[0] - aside[1]) / (2 * step), atol=1e-8)


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
