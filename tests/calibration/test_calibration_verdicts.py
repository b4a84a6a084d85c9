"""What a fit is said to be: figures of a wrong fit are never given, headline and notes agree, and
slips of files are named.
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import symkin
from helpers.built_machines import built, random_postures
from helpers.csv_cells import rewritten
from helpers.gate import in_gate
from helpers.inside import (
    Noise,
    NotFittedError,
    Workspace,
    fit_file,
    group_numbers,
    main,
    random_configurations,
    read_measurements,
    residual_figure,
    simulate_readings,
)
from helpers.measured_files import write_measurements
from symkin import InputError

NOMINAL, RODS, RODS_TRUE = (
    symkin.load("zhang2009"),
    symkin.load("ren2008"),
    symkin.load("ren2008_true"),
)
NOISE = Noise(lengths=0.005, position=0.02, orientation=np.radians(0.002))


@pytest.fixture(scope="module")
def poses():
    """Joints and whole poses of a platform whose joint centres are off by up to 0.2 % of the
    size.
    """
    rng = np.random.default_rng(5)

    def away(point):
        return tuple(np.array(point) + 2e-3 * NOMINAL.characteristic_length * rng.uniform(-1, 1, 3))

    true = replace(
        NOMINAL,
        limbs=[
            replace(limb, base=away(limb.base), platform=away(limb.platform))
            for limb in NOMINAL.limbs
        ],
    )
    made = random_configurations(Workspace.about(true), group_numbers(60, 0), NOISE, rng)
    return simulate_readings(NOMINAL, made, group_numbers(60, 0), ("pose",), NOISE, rng)


@pytest.fixture(scope="module")
def grouped():
    """Rods and groups of equal inclination: 40 postures in 5 groups."""
    rng, groups, noise = (
        np.random.default_rng(6),
        group_numbers(40, 5),
        Noise(lengths=2e-6, group=np.radians(0.001)),
    )
    return simulate_readings(
        RODS,
        random_configurations(Workspace.about(RODS_TRUE), groups, noise, rng),
        groups,
        (),
        noise,
        rng,
    )


def fitted(path, mechanism, measurements, **options):
    write_measurements(path, mechanism, measurements, **options)
    return fit_file(mechanism, read_measurements(path, mechanism))


def refused(path, mechanism, measurements, **options):
    """What is said of a file that cannot be used, whether something could be fitted or not."""
    try:
        report = fitted(path, mechanism, measurements, **options)
    except NotFittedError as error:
        return str(error)
    assert not report.usable
    assert report.suspicions
    return report.verdict


# --- fits that are none ---------------------------------------------------------------------------


@pytest.mark.slow
def test_a_geometry_bent_to_wrong_readings_is_not_usable(capsys, tmp_path, poses):
    """A fit whose residuals are hundreds of times the noise: exit 3, no mechanism file, no pose
    figures, the slip named.
    """
    path, out = tmp_path / "data.csv", tmp_path / "out"
    few = poses.subset(np.arange(20))
    write_measurements(path, NOMINAL, replace(few, orientation=few.orientation * (1, -1, -1, -1)))
    with pytest.raises(SystemExit) as ended:
        main(["calibrate", "fit", "zhang2009", str(path), "-o", str(out)])
    said = capsys.readouterr().out
    report = json.loads((out / "report.json").read_text())
    assert ended.value.code == 3
    assert not report["usable"]
    assert report["pose_sigma"] is None
    assert report["verdict"].startswith("NOT USABLE")
    assert "orientations look inverted" in said
    assert "poses in aligned frames" not in said
    assert not (out / "zhang2009.toml").exists()


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "signs", "words"),
    [
        ([1, 0, 2], 1, "the columns x and y look exchanged"),
        ([0, 1, 2], [1, -1, 1], "the sign of y looks reversed"),
        ([1, 2, 0], 1, "x, y, z seem to stand in z, x, y"),
    ],
    ids=["exchanged", "mirrored", "turned"],
)
def test_pose_columns_that_stand_wrong_are_named(tmp_path, poses, order, signs, words):
    """Exchanged or mirrored positions are not usable, and the slip that explains them comes
    first.
    """
    assert words in refused(
        tmp_path / "data.csv", NOMINAL, replace(poses, position=poses.position[:, order] * signs)
    )


@pytest.mark.slow
def test_files_of_an_earlier_fit_are_told_from_this_one(capsys, tmp_path, grouped):
    """A folder with the mechanism of a fit that was usable: after one that is not it is still
    there, and a note says whose it is.
    """
    path, out, said = tmp_path / "data.csv", tmp_path / "out", []
    for measurements in (grouped, replace(grouped, joints=1e3 * grouped.joints)):
        write_measurements(path, RODS, measurements)
        with pytest.raises(SystemExit):
            main(["calibrate", "fit", "ren2008", str(path), "-o", str(out)])
        said.append(capsys.readouterr().out)
    assert (out / "ren2008.toml").exists()
    assert ["of an earlier fit" in text for text in said] == [False, True]


@pytest.mark.slow
def test_noise_stated_too_small_stays_usable(tmp_path, poses):
    """Noise ten times the stated one: usable, not believable, no suspicion."""
    report = fitted(
        tmp_path / "data.csv",
        NOMINAL,
        replace(poses, position_sigma=0.002, orientation_sigma=np.radians(2e-4)),
    )
    assert report.usable
    assert not report.believable
    assert report.verdict.startswith("NOT BELIEVABLE: chi-square per degree of freedom is")
    assert not report.suspicions


@pytest.fixture(scope="module")
def arm():
    """A UR5e, and 24 postures of one as it is built."""
    nominal, rng = symkin.load("ur5e"), np.random.default_rng(3)
    true = built(nominal, 1e-3, rng)
    return nominal, true, random_postures(nominal, true, 24, rng)


def poses_of(arm, lengths, angles):
    """Whole poses with noise of so many sizes and radians, which the file does not state."""
    nominal, true, made = arm
    noise = Noise(position=lengths * nominal.characteristic_length, orientation=angles)
    own = np.random.default_rng(0)
    taken = simulate_readings(true, made, group_numbers(24, 0), ("pose",), noise, own)
    return replace(taken, position_sigma=None, orientation_sigma=None)


@pytest.mark.parametrize(("lengths", "angles"), [(1e-5, 1e-2), (5e-4, 1e-6)])
def test_unlike_precision_that_is_not_stated_is_no_misfit(tmp_path, arm, lengths, angles):
    """Lengths a thousand times as precise as angles and the reverse: no kind is misfit for being
    worse than the other, as none is where both are stated; and kinds are told each in its unit.
    """
    report = fitted(tmp_path / "data.csv", arm[0], poses_of(arm, lengths, angles))
    assert report.verdict.startswith("NOT TESTED")
    size = arm[0].characteristic_length
    for kind, noise in (("position", lengths * size), ("orientation", angles)):
        assert 0.5 < report.fit.problem.estimated[kind] / noise < 2.0


@pytest.mark.long
@pytest.mark.slow
def test_a_kind_of_readings_that_nothing_explains_is_told(tmp_path, arm):
    """Orientations of other postures beside right positions: not usable, since of orientations."""
    taken = poses_of(arm, 1e-5, 1e-4)
    mixed = replace(taken, orientation=np.roll(taken.orientation, 7, axis=0))
    verdict = fitted(tmp_path / "data.csv", arm[0], mixed).verdict
    assert verdict.startswith("NOT USABLE: the residuals of orientation are")


# --- headline, notes and figures agree ------------------------------------------------------------


@pytest.mark.slow
def test_noise_stated_too_large_is_not_as_expected(tmp_path, grouped):
    """Standard deviations ten times too large: headline, JSON and the pose's figures say so, as the
    note does.
    """
    report = fitted(tmp_path / "data.csv", RODS, replace(grouped, group_sigma=np.radians(0.01)))
    assert report.fit.p_value > 0.999
    assert not report.believable
    assert not report.to_dict()["believable"]
    assert "the stated noise is too large" in report.verdict
    assert any("the stated noise is too large" in note for note in report.fit.notes)
    times = float(re.search(r"the residuals are (\S+) times as large", report.sigma_text())[1])
    assert times == pytest.approx(np.sqrt(report.fit.chi_square / report.fit.degrees), rel=1e-2)
    assert times < 0.2


@pytest.mark.slow
def test_copies_of_rows_are_left_out(tmp_path, grouped):
    """Every row twice, numbers written otherwise: the same degrees of freedom and standard
    deviations as once, and the lines named.
    """
    path = tmp_path / "data.csv"
    once = fitted(path, RODS, grouped)

    def twice(header, rows):
        rows += [[row[0], f"{float(row[1]):.17e}", *row[2:]] for row in rows]

    again = fit_file(RODS, read_measurements(rewritten(path, twice), RODS))
    assert again.fit.degrees == once.fit.degrees
    np.testing.assert_allclose(again.sigma.position, once.sigma.position, rtol=1e-6)
    assert any("line 42 of line 2" in note for note in again.notes)


def test_one_posture_again_and_again_is_refused(tmp_path, grouped):
    """A file of nothing but copies is refused in one sentence."""
    path = tmp_path / "data.csv"
    write_measurements(path, RODS, grouped)

    def same(header, rows):
        rows[:] = [rows[0]] * 10

    with pytest.raises(InputError, match="all rows are copies of line 2"):
        fit_file(RODS, read_measurements(rewritten(path, same), RODS))


@pytest.mark.slow
def test_rows_without_a_reading_are_not_counted(tmp_path, grouped):
    """A row with joints only tells nothing: 39 of 40 postures, the line named, and the fit that of
    the other rows.
    """
    path = tmp_path / "data.csv"
    write_measurements(path, RODS, grouped)

    def empty(header, rows):
        rows[4][0] = ""

    report = fit_file(RODS, read_measurements(rewritten(path, empty), RODS))
    assert "39 of 40 postures" in report.summary()
    assert report.to_dict()["silent"] == ["line 6"]
    assert any("line 6 holds no reading" in note for note in report.fit.notes)
    others = fitted(path, RODS, grouped.subset(np.arange(40) != 4))
    assert report.fit.degrees == others.fit.degrees
    assert report.fit.chi_square == pytest.approx(others.fit.chi_square, rel=1e-6)


# --- diagnoses ------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.slow
def test_a_posture_that_never_changes_is_said(tmp_path, grouped):
    """One posture with noise is not taken for another unit."""
    rng = np.random.default_rng(0)
    joints = grouped.joints[:1] + 2e-6 * rng.normal(size=(20, 6))
    report = fitted(
        tmp_path / "data.csv", RODS, replace(grouped.subset(np.arange(20)), joints=joints)
    )
    assert not report.usable
    assert "the posture never changes" in report.verdict
    assert "1000" not in report.verdict


def merged(groups):
    return np.where(groups == 4, 3, groups)


def shuffled(groups):
    return np.random.default_rng(1).permutation(groups)


def strayed(groups):
    groups = groups.copy()
    groups[[5, 20, 33]] = (groups[[5, 20, 33]] + 1) % 5
    return groups


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (merged, "looks to be two groups under one label"),
        (shuffled, "the groups look wrongly labelled"),
        (strayed, "posture line 7, line 22, line 35 look to be in wrong groups"),
    ],
)
def test_wrong_labels_of_groups_are_named(tmp_path, grouped, change, words):
    """Two groups under one label, shuffled labels and single stray postures are told from one
    another; right labels are not suspected.
    """
    report = fitted(tmp_path / "data.csv", RODS, replace(grouped, groups=change(grouped.groups)))
    assert not report.believable
    assert words in report.verdict
    assert not fitted(tmp_path / "data.csv", RODS, grouped).suspicions


@pytest.mark.long
@pytest.mark.slow
def test_a_sequence_named_wrongly_is_told(tmp_path, poses):
    """Angles of one sequence under the header of another: the sequence that fits is named."""
    path = tmp_path / "data.csv"
    write_measurements(path, NOMINAL, poses, sequence="XZX")
    path.write_text(path.read_text().replace("euler_XZX_", "euler_ZYX_"))
    try:
        said = fit_file(NOMINAL, read_measurements(path, NOMINAL)).verdict
    except NotFittedError as nothing:
        said = str(nothing)
    assert said.startswith("NOT ")
    assert "look to be of another sequence than ZYX" in said
    assert "XZX about moving axes" in said


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("hidden", [False, True], ids=["ZYX named", "no sequence named"])
def test_euler_angles_in_radians_are_told(tmp_path, poses, hidden):
    """Radians under a header that says degrees: the unit is named, whether the sequence is stated
    or sought.
    """
    path = tmp_path / "data.csv"
    write_measurements(path, NOMINAL, poses, sequence="ZYX", hidden=hidden)

    def in_radians(header, rows):
        for k, name in enumerate(header):
            for row in rows if name.startswith("euler_") else ():
                row[k] = repr(math.radians(float(row[k])))

    try:
        report = fit_file(NOMINAL, read_measurements(rewritten(path, in_radians), NOMINAL))
    except NotFittedError as nothing:
        said = str(nothing)
    else:
        assert not report.usable
        said = report.verdict
    assert "the Euler angles look radians taken for degrees" in said


# --- picture --------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("sigma", in_gate([2e-6, 0.02], [0.02]))
def test_the_legends_stand_beside_the_points_and_few_ticks_on_the_axis(tmp_path, poses, sigma):
    """Whether residuals are like the noise or 10^4 times larger, legends cover no panel, tick
    labels do not overlap, and the normal distribution is drawn within the panel.
    """
    report = fitted(
        tmp_path / "data.csv",
        NOMINAL,
        replace(poses, position_sigma=sigma, orientation_sigma=np.radians(0.1 * sigma)),
    )
    figure = residual_figure(report.fit)
    figure.draw_without_rendering()
    for axes in figure.axes:
        panel, legend = axes.get_window_extent(), axes.get_legend().get_window_extent()
        assert legend.y0 >= panel.y1
    boxes = [
        label.get_window_extent() for label in figure.axes[1].get_xticklabels() if label.get_text()
    ]
    assert all(a.x1 < b.x0 for a, b in pairwise(boxes))
    assert any("normal" in text.get_text() for text in figure.axes[1].get_legend().get_texts())
