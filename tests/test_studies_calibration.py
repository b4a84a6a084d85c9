"""The studies of calibration in small: the paper's claims, and what the planned postures reach.

Published figures: Ren, Feng, Su 2008: 1e-10 m without noise; 0.1 mm and 0.01 deg at 80 postures.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

STUDIES = Path(__file__).resolve().parent.parent / "studies"
sys.path.insert(0, str(STUDIES))
import ren2008_method as method  # noqa: E402
import ren2008_tables as tables  # noqa: E402
import symkin  # noqa: E402

NOMINAL, TRUE = symkin.load("ren2008"), symkin.load("ren2008_true")


def test_groups_have_one_inclination_and_tables_their_frames():
    """Without noise the extensions of a group belong to equal (alpha, beta), within the rods' range; held entries are 0."""
    rng = np.random.default_rng(0)
    measured = method.measure(TRUE, 5, 4, method.EXACT, rng)
    poses = method.direct(TRUE, {}, method.UnusedPoses([TRUE.reference_pose] * 20, measured.joints))
    angles = np.array([method.angles_of(p) for p in poses]).reshape(5, 4, 3)
    assert np.abs(angles[:, :, :2] - angles[:, :1, :2]).max() < 1e-9
    assert (measured.joints >= 0).all()
    assert (measured.joints <= 0.55).all()
    assert len(tables.held_names(TRUE)) == 10


def test_alignment_removes_constant_frames_and_nothing_else():
    """Poses moved by one base and one tool frame have no error left; an error that is no frame stays."""
    poses = method.unused_poses(TRUE, 1, 30).poses
    base = symkin.Pose.from_euler([1e-3, -2e-3, 5e-4], np.radians([0.1, -0.05, 0.2]), "xyz")
    tool = symkin.Pose.from_euler([-1e-3, 3e-3, 1e-3], np.radians([-0.1, 0.15, 0.1]), "xyz")
    assert np.abs(method.aligned([base @ p @ tool for p in poses], poses)).max() < 1e-8
    stretched = [symkin.Pose(1.001 * p.position, p.quaternion) for p in poses]
    assert np.abs(method.aligned(stretched, poses)).max() > 1e-5


def test_best_frames_bring_joints_to_nominal():
    """Rigidly moved joints return exactly."""
    moved = symkin.Pose.from_euler([0.1, 0.2, -0.3], [0.2, -0.1, 0.4], "xyz")
    points = [np.array(limb.base) for limb in TRUE.limbs]
    back = method.procrustes([moved.apply(p) for p in points], points)
    assert np.abs((back @ moved).matrix - np.eye(4)).max() < 1e-12


@pytest.mark.parametrize(("spread", "count"), [(0.005, 6), (0.05, 3)])
def test_exact_readings_recover_random_truths(spread, count):
    """Below 1e-12 m, a hundredth of the paper's figure, from truths within +-5 and +-50 mm."""
    rng = np.random.default_rng(7)
    for _ in range(count):
        true = method.random_truth(NOMINAL, spread, rng)
        assert method.deviation(method.fit(NOMINAL, method.measure(true, 10, 4, method.EXACT, rng)), true) < 1e-12


def test_80_postures_reach_the_claim_in_aligned_frames_only():
    """At 2 um and 0.001 deg: 0.1 mm and 0.01 deg in aligned frames, not in the joint frames."""
    tests = method.unused_poses(TRUE, 2)
    found = method.fit(NOMINAL, method.measure(TRUE, 20, 4, method.BEST, np.random.default_rng(5)))
    errors = method.pose_errors(NOMINAL, TRUE, found.values, tests)
    assert errors["aligned"].position < 0.1
    assert errors["aligned"].angle < 0.01
    assert errors["raw"].position > 0.1
    assert errors["raw"].angle > 0.01


def test_the_calibration_study_runs(tmp_path):
    """Exit 0, a picture, rows for every noise, count and frame, and the erratum on raw frames shown."""
    command = [sys.executable, "-W", "error", str(STUDIES / "ren2008_calibration.py"), "-o", str(tmp_path), "--trials", "1"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert run.returncode == 0, run.stderr
    content = json.loads((tmp_path / "ren2008_calibration.json").read_text())
    assert (tmp_path / "ren2008_calibration.png").read_bytes()[:4] == b"\x89PNG"
    assert sum("worst errors" in row["quantity"] and "rod" in row["quantity"] for row in content["rows"]) == 4 * 3 * 3 + 3 * 2
    assert len(content["errata"]) == 1
