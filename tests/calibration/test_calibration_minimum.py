"""Fits end at a minimum of what is written: parameters that nothing tells at nominal and something
tells on the way, and the file read back. The machines, their readings and their chi-square are
NumPy's (see `parallel_arm`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import parallel_arm
from helpers.inside import assessment, main, parse, told_directions
from helpers.measured_files import write_measurements
from symkin import Measurements, calibrate, load


@pytest.fixture(scope="module")
def delivered():
    """Tool positions of a machine as a factory calibrates it: axes off parallel by 1e-4 rad,
    hundreds of metres that cancel.
    """
    rng = np.random.default_rng([1, 5])
    table = parallel_arm.moved_lines(1e-3, 0.3, rng)
    assert np.max(np.abs(table[:, 1])) > 1e5
    return table, parallel_arm.measured(table, rng)


def projected_gradient(mechanism, data):
    """By how much one more linear step would lower chi-square, in NumPy."""
    table = np.array(
        [[getattr(row, key) for key in parallel_arm.KEYS] for row in mechanism.dh.rows]
    )
    matrix = parallel_arm.slopes(table, data.joints).reshape(-1, 24) / parallel_arm.SIGMA
    gap = (
        (parallel_arm.positions(table, data.joints) - data.position) / parallel_arm.SIGMA
    ).ravel()
    left, singular, _ = np.linalg.svd(
        matrix / np.maximum(np.linalg.norm(matrix, axis=0), 1.0), full_matrices=False
    )
    return np.linalg.norm(left[:, singular > 1e-6].T @ gap)


@pytest.mark.slow
def test_the_minimum_is_that_of_the_truth_or_less(delivered):
    """Chi-square of the written file is not above that of the true table, is the one reported, and
    has no gradient; by the arm's lines it takes few steps.
    """
    table, data = delivered
    fit = calibrate(parallel_arm.arm(), data, outliers="ignore")
    assert fit.iterations <= 24  # 15 to 17 by the rounding of a processor
    found = parse(fit.corrected.to_toml())
    own = parallel_arm.chi_square(found, data)
    assert fit.status == "ok"
    assert own < parallel_arm.chi_square(parallel_arm.arm(table), data)
    assert fit.chi_square == pytest.approx(own, rel=1e-6)
    assert sum((r.value / r.sigma) ** 2 for r in fit.residuals) == pytest.approx(own, rel=1e-6)
    assert projected_gradient(found, data) < 0.02


@pytest.mark.slow
def test_scipy_finds_no_less():
    """Two random machines: below the chi-square of the true tables, and above the least that
    SciPy's methods find from the same start by no more than what the prior holds in the directions
    that the readings hardly tell, one each.
    """
    pytest.importorskip("scipy")
    for seed in (1, 2):
        rng = np.random.default_rng([seed, 5])
        table = parallel_arm.random_table(rng)
        data = parallel_arm.measured(table, rng)
        fit = calibrate(parallel_arm.arm(), data, outliers="ignore")
        own = parallel_arm.chi_square(fit.corrected, data)
        told = told_directions(fit.problem, fit.state)
        assert own < parallel_arm.chi_square(parallel_arm.arm(table), data)
        hardly = len(fit.problem.names) - np.sum(told.ratios > 10.0)
        assert own < parallel_arm.least_chi_square(data) + hardly


def test_what_the_model_lacks_is_in_the_figures(delivered):
    """A target off the tool that is no parameter: chi-square is as large as the file's is, and
    nothing is believable.
    """
    table, _ = delivered
    rng = np.random.default_rng(3)
    data = parallel_arm.measured(table, rng, offset=(30.0, 20.0, 0.0))
    fit = calibrate(
        parallel_arm.arm(), data, parameters=["dh.1.d", "dh.2.a", "dh.3.a"], outliers="ignore"
    )
    assert fit.chi_square == pytest.approx(parallel_arm.chi_square(fit.corrected, data), rel=1e-6)
    assert fit.chi_square > 1e4
    assert not fit.believable


@pytest.mark.slow
def test_a_file_that_is_not_the_fit_is_not_written(capsys, monkeypatch, tmp_path):
    """A writer that loses digits: no mechanism file, the sentence says where it differs from the
    fit, exit status 3; without the loss the file is written.
    """
    rng = np.random.default_rng([1, 5])
    data = parallel_arm.measured(parallel_arm.random_table(rng), rng)
    arm, corrected = parallel_arm.arm(), assessment.with_parameters
    (tmp_path / "arm.toml").write_text(arm.to_toml())
    write_measurements(tmp_path / "data.csv", arm, data)

    def rounded(mechanism, values):
        return corrected(mechanism, {name: float(f"{value:.5g}") for name, value in values.items()})

    for lossy in (True, False):
        monkeypatch.setattr(assessment, "with_parameters", rounded if lossy else corrected)
        with pytest.raises(SystemExit) as ended:
            main(
                [
                    "calibrate",
                    "fit",
                    str(tmp_path / "arm.toml"),
                    str(tmp_path / "data.csv"),
                    "-o",
                    str(tmp_path / "out"),
                ]
            )
        assert ended.value.code == (3 if lossy else 0)
        assert (
            "does not give the readings that the fit does at posture line 2"
            in capsys.readouterr().out
        ) == lossy
        assert (tmp_path / "out" / "arm.toml").exists() != lossy
    assert parallel_arm.chi_square(
        load(tmp_path / "out" / "arm.toml"), data
    ) < parallel_arm.chi_square(arm, data)


# --- physical -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def hexapod():
    """Whole poses of a platform on six rods, joints by distances of points in NumPy."""
    mechanism, rng = load("ren2008"), np.random.default_rng(8)
    base, platform = (
        np.array([getattr(limb, end) for limb in mechanism.limbs]) for end in ("base", "platform")
    )
    offset = np.array([limb.offset for limb in mechanism.limbs])
    position = np.array(mechanism.platform_position) + rng.uniform(-0.1, 0.1, (24, 3))
    turn = 0.1 * rng.normal(size=(24, 3))
    q = np.column_stack([np.ones(24), turn])
    q /= np.linalg.norm(q, axis=1)[:, None]
    w, v = q[:, :1, None], q[:, None, 1:]
    ends = platform + 2 * np.cross(v, np.cross(v, platform) + w * platform)
    lengths = np.linalg.norm(position[:, None] + ends - base, axis=2)
    joints = lengths - offset + 2e-6 * rng.normal(size=lengths.shape)
    return mechanism, Measurements(
        joints,
        position=position,
        orientation=q,
        joint_sigma=2e-6,
        position_sigma=1e-6,
        orientation_sigma=1e-6,
    )


def test_rods_inside_out_are_refused(hexapod):
    """All readings negated, in the file of a machine whose offsets are: the fit is perfect with
    rods inside out, and refused with the legs and rows named; right readings are not.
    """
    mechanism, data = hexapod
    assert calibrate(mechanism, data).refused is None
    limbs = [replace(limb, offset=-limb.offset) for limb in mechanism.limbs]
    fit = calibrate(replace(mechanism, limbs=limbs), replace(data, joints=-data.joints))
    assert fit.status == "ok"
    assert "the rod of leg1 would have a negative length" in fit.refused
    assert not fit.believable


def test_the_written_file_solves_its_rows(hexapod):
    """`solve` at the rows measured, from the poses measured, gives them back within the noise."""
    mechanism, data = hexapod
    found = parse(calibrate(mechanism, data).corrected.to_toml())
    for k in range(0, 24, 7):
        pose = symkin.solve(
            found, joints=data.joints[k], start=[*data.position[k], *data.orientation[k]]
        ).solution.pose
        np.testing.assert_allclose(pose.position, data.position[k], atol=3e-5)
