"""Which mode each posture starts in: what was read of it decides, whatever the file of the
mechanism leaves open.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers import hexapods
from helpers.command_line import run
from helpers.gate import in_gate
from helpers.inside import (
    build_calibration,
    fit_file,
    matrix_from_quaternion,
    platform_points,
    read_measurements,
    start_configurations,
    with_starts,
)
from helpers.inside import workspace_home_pose as home_pose
from symkin import Joint, Limb, Measurements, Mechanism, calibrate


def machine(folder, rng, *, home):
    """A nominal mechanism, and joint centres of the true one, off by up to 1 mm."""
    base, platform = hexapods.rings(rng)
    path = folder / "hexapod.toml"
    path.write_text(hexapods.toml(base, platform, home=home))
    return symkin.load(str(path)), *(t + rng.uniform(-1, 1, (6, 3)) for t in (base, platform))


def data(folder, mechanism, base, platform, rng, rows, change):
    """A file of rows whose readings are changed, with the true poses."""
    position, q = hexapods.poses(rows, rng)
    read = hexapods.noisy(hexapods.legs(base, platform, position, q), position, q, rng)
    path = folder / "data.csv"
    path.write_text(hexapods.csv(*change(*read)))
    return read_measurements(path, mechanism), position, q


def blank(column, rows):
    """Readings with one of them (1: positions, 2: orientations) blank in some rows."""

    def change(*read):
        read = [np.array(part) for part in read]
        read[column][rows] = np.nan
        return read

    return change


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [
        blank(2, [3, 30, 59]),
        blank(2, slice(5, None)),
        blank(1, slice(0, 60, 4)),
        lambda *read: (read[0], read[1], None),
    ],
    ids=[
        "three orientations",
        "all orientations but five",
        "a quarter of the positions",
        "positions only",
    ],
)
@pytest.mark.parametrize("seed", [0, 1])
def test_blank_readings_do_not_lose_the_fit(tmp_path, seed, change):
    """Rods without a reference pose, so that home is the origin: the fit is believable, and every
    posture stands at its true pose.
    """
    rng = np.random.default_rng(seed)
    mechanism, base, platform = machine(tmp_path, rng, home=False)
    file, position, q = data(tmp_path, mechanism, base, platform, rng, 60, change)
    report = fit_file(mechanism, file)
    assert report.believable, report.verdict
    assert np.max(np.abs(report.fit.poses[:, :3] - position[list(report.fit.used)])) < 0.1
    if file.measurements.orientation is not None:
        turn = np.abs(np.sum(report.fit.poses[:, 3:] * q[list(report.fit.used)], axis=1))
        assert np.all(turn > 1 - 1e-7)


@pytest.mark.slow
def test_six_blank_orientations_among_six_hundred(tmp_path):
    """As the log of a controller has them: believable, nothing left out."""
    rng = np.random.default_rng(4)
    mechanism, base, platform = machine(tmp_path, rng, home=True)
    file, position, _ = data(
        tmp_path, mechanism, base, platform, rng, 600, blank(2, rng.choice(600, 6, replace=False))
    )
    report = fit_file(mechanism, file)
    assert report.believable, report.verdict
    assert not report.fit.unsolved
    assert np.max(np.abs(report.fit.poses[:, :3] - position)) < 0.1


@pytest.mark.slow
def test_groups_alone_find_the_mode_they_agree_in(tmp_path):
    """Groups of equal inclination and no reference pose: the groups agree in the mode that was
    measured, platform above base.
    """
    rng = np.random.default_rng(7)
    mechanism, base, platform = machine(tmp_path, rng, home=False)
    groups = np.repeat(np.arange(8), 5)
    position, q = hexapods.poses(40, rng)
    tilt, yaw = hexapods.poses(8, rng)[1][groups], np.radians(10) * rng.uniform(-1, 1, 40)
    spin = np.column_stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)])
    w, u = spin[:, :1], spin[:, 1:]
    q = np.hstack(
        [
            w * tilt[:, :1] - np.sum(u * tilt[:, 1:], axis=1, keepdims=True),
            w * tilt[:, 1:] + tilt[:, :1] * u + np.cross(u, tilt[:, 1:]),
        ]
    )
    m = Measurements(hexapods.legs(base, platform, position, q), groups=groups, group_sigma=1e-5)
    problem = build_calibration(mechanism, with_starts(mechanism, m))
    found = start_configurations(problem, problem.model.nominal)
    at = problem.model.poses(found.z, problem.measurements.joints, problem.model.nominal)
    assert found.solved.all()
    assert np.max(np.abs(at[:, :3] - position)) < 20
    assert calibrate(mechanism, m).status == "ok"


@pytest.mark.slow
def test_the_region_of_pose_sigma_is_the_measured_one(tmp_path):
    """Postures far from the reference pose: the poses at which standard deviations are stated lie
    within the box of those measured.
    """
    rng = np.random.default_rng(3)
    mechanism, base, platform = machine(tmp_path, rng, home=True)
    moved = replace(mechanism, platform_position=(0.0, 0.0, 600.0))
    file, position, q = data(tmp_path, mechanism, base, platform, rng, 50, lambda *read: read)
    report = fit_file(moved, file)
    middle = np.mean(platform_points(mechanism), axis=0)
    at, said = (
        p[:, :3] + np.array([matrix_from_quaternion(v) @ middle for v in p[:, 3:]])
        for p in (np.hstack([position, q]), report.sigma.poses)
    )
    assert np.all(said > at.min(axis=0) - 5)
    assert np.all(said < at.max(axis=0) + 5)
    assert np.all(np.ptp(said, axis=0) > 0.5 * np.ptp(at, axis=0))
    assert "region measured" in report.sigma_text()


def test_home_is_the_example_where_the_file_says_no_reference(tmp_path):
    """Rods without [platform] and an [example]: direct problems begin there, not at the origin;
    with a reference they begin at it.
    """
    base, platform = hexapods.rings(np.random.default_rng(8))
    example = symkin.Example(
        joints=tuple([500.0] * 6), start=(10.0, 0.0, hexapods.HEIGHT, 1.0, 0.0, 0.0, 0.0)
    )
    for home, height in ((False, hexapods.HEIGHT), (True, hexapods.HEIGHT)):
        (tmp_path / "hexapod.toml").write_text(
            hexapods.toml(base, platform + [0, 0, 150], home=home)
        )
        mechanism = replace(symkin.load(str(tmp_path / "hexapod.toml")), example=example)
        assert home_pose(mechanism).position[2] == height
        assert home_pose(mechanism).position[0] == (0.0 if home else 10.0)


def planar_three_rrr() -> Mechanism:
    """Three cranks and three couplers in a plane, no two limbs alike."""
    limbs = []
    points = (
        ((0.0, 240.0), (89.14352, 145.377419), (-28.765532, 52.654954)),
        ((-207.846097, -120.0), (-170.472297, 4.511843), (-31.217761, -51.239159)),
        ((207.846097, -120.0), (81.328778, -149.889262), (59.983294, -1.415795)),
    )
    for k, places in enumerate(points, start=1):
        joints = [
            Joint(f"{name}{k}", "R", (x, y, 0.0), (0.0, 0.0, 1.0), actuated=name == "m")
            for name, (x, y) in zip("met", places, strict=True)
        ]
        limbs.append(Limb(f"limb{k}", joints))
    return Mechanism("rrr3", limbs, motion="planar", angle_unit="deg")


@pytest.mark.parametrize("seed", in_gate([0, 6, 7], [7]))
def test_passive_joints_far_from_the_reference_do_not_bend_the_first_guess(
    seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whole poses of the file's own geometry, elbows up to a quarter turn off: the fit begins and
    ends at this geometry.
    """
    (tmp_path / "rrr3.toml").write_text(planar_three_rrr().to_toml(), encoding="utf-8")
    described, readings = tmp_path / "rrr3.toml", tmp_path / "data.csv"
    assert (
        run(
            capsys,
            "calibrate",
            "simulate",
            described,
            "-o",
            readings,
            "--postures",
            40,
            "--readings",
            "pose",
            "--seed",
            seed,
        )[0]
        == 0
    )
    status, out, _ = run(capsys, "calibrate", "fit", described, readings, "-o", tmp_path / "fit")
    assert status == 0
    assert out.startswith("rrr3: believable")


@pytest.mark.slow
def test_a_posture_whose_mode_ends_before_the_file_joins_at_the_estimate():
    """Positions of a hexapod some millimetres off its file: what closes at the file's geometry for
    line 21 is far from what was read, which is good, and fitted as the others.
    """
    hexapod = symkin.load("zhang2009")
    read = read_measurements(Path(__file__).parent / "ending_mode.csv", hexapod).measurements
    fit = calibrate(hexapod, replace(read, position_sigma=0.0126))
    assert fit.believable
    assert len(fit.used) == 28
    assert "line 21" not in {o.label for o in fit.outliers}
