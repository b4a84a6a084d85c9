"""Good fits of wrong files: the machine that the readings are of is told from the one that the file
describes.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

import symkin
from helpers import hexapods
from helpers.inside import fit_file, main, read_measurements
from symkin import calibrate


def described(folder, base, platform):
    path = folder / "hexapod.toml"
    path.write_text(hexapods.toml(base, platform, home=True))
    return path


def measured(folder, base, platform, rng, *, rows=48, columns=(0, 1, 2, 3, 4, 5), signs=1.0):
    """A file of whole poses, its leg columns in another order."""
    position, q = hexapods.poses(rows, rng)
    rods, *read = hexapods.noisy(hexapods.legs(base, platform, position, q), position, q, rng)
    path = folder / "data.csv"
    path.write_text(hexapods.csv(signs * rods[:, list(columns)], *read))
    return path


def run(capsys, *arguments):
    """Exit status and stdout."""
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code or 0, capsys.readouterr().out


def built(base, platform, rng, spread=1.0):
    return tuple(t + rng.uniform(-spread, spread, t.shape) for t in (base, platform))


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ((2, 1, 0, 3, 4, 5), "the columns leg1 and leg3 look exchanged"),
        (
            (1, 2, 0, 3, 4, 5),
            "the columns leg1, leg2, leg3 look exchanged: they seem to hold leg2, leg3, leg1",
        ),
        ((5, 4, 3, 2, 1, 0), "they seem to hold leg6, leg5, leg4, leg3, leg2, leg1"),
    ],
    ids=["two", "three", "all"],
)
def test_exchanged_columns_are_another_machine_and_named(capsys, tmp_path, columns, words):
    """Whole poses and leg columns in another order fit perfectly: exit 3 all the same, no mechanism
    file, and the first line says so and in which order they stand.
    """
    rng = np.random.default_rng(1)
    nominal = hexapods.rings(rng)
    machine, out = described(tmp_path, *nominal), tmp_path / "out"
    data = measured(tmp_path, *built(*nominal, rng), rng, columns=columns)
    status, said = run(capsys, "calibrate", "fit", machine, data, "-o", out)
    assert status == 3
    assert words in said.splitlines()[0]
    assert "NOT USABLE" in said.splitlines()[0]
    assert not (out / "hexapod.toml").exists()
    assert not json.loads((out / "report.json").read_text())["believable"]


@pytest.mark.slow
def test_another_machines_nominal_is_refused_unless_told_otherwise(capsys, tmp_path):
    """Readings of a machine with a platform half as large again: exit 3; with --any-machine exit 0
    and the file of that machine, which solves its rows, and the first line still says what it is.
    """
    rng = np.random.default_rng(2)
    nominal = hexapods.rings(rng)
    true = built(nominal[0], 1.5 * nominal[1], rng)
    machine, data, out = (
        described(tmp_path, *nominal),
        measured(tmp_path, *true, rng),
        tmp_path / "out",
    )
    status, said = run(capsys, "calibrate", "fit", machine, data, "-o", out)
    assert status == 3
    assert "another machine than hexapod describes" in said.splitlines()[0]
    assert not (out / "hexapod.toml").exists()
    status, said = run(capsys, "calibrate", "fit", machine, data, "-o", out, "--any-machine")
    assert status == 0
    assert "another machine than hexapod describes" in said.splitlines()[0]
    made, (position, q) = symkin.load(str(out / "hexapod.toml")), hexapods.poses(3, rng)
    for row, p, o in zip(hexapods.legs(*true, position, q), position, q, strict=True):
        assert (
            np.max(np.abs(symkin.solve(made, joints=row, start=[*p, *o]).solution.position - p))
            < 0.02
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spread", "far"),
    [(1.0, False), pytest.param(6.0, False, marks=pytest.mark.long), (60.0, True)],
)
def test_the_machine_as_built_is_no_other_one(tmp_path, spread, far):
    """Joint centres off by up to 1 mm, 6 mm (1 % of the size) and 60 mm: believable, believable,
    another machine.
    """
    rng = np.random.default_rng(5)
    nominal = hexapods.rings(rng)
    mechanism = symkin.load(str(described(tmp_path, *nominal)))
    report = fit_file(
        mechanism,
        read_measurements(measured(tmp_path, *built(*nominal, rng, spread), rng), mechanism),
    )
    assert report.believable is not far
    assert report.usable is not far
    assert (report.fit.departure.share > 0.08) is far


@pytest.mark.slow
def test_another_base_frame_is_no_other_machine(tmp_path):
    """The same machine with base and platform frames turned by 25 degrees and moved: the poses that
    the fit gives are the file's but for constant frames.
    """
    rng = np.random.default_rng(6)
    base, platform = hexapods.rings(rng)
    true = built(base, platform, rng, 0.5)
    c, s = np.cos(np.radians(25)), np.sin(np.radians(25))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    mechanism = symkin.load(
        str(described(tmp_path, (base - [30, 20, 10]) @ turn.T, (platform + [5, 5, 40]) @ turn.T))
    )
    report = fit_file(mechanism, read_measurements(measured(tmp_path, *true, rng), mechanism))
    assert report.fit.believable
    assert report.fit.departure.share < 0.01
    assert report.usable


@pytest.mark.slow
def test_tolerances_are_prior_standard_deviations(tmp_path):
    """Geometries drawn from the tolerance and fewer readings than parameters: errors of the
    estimate have the covariance that is stated, chi-square (readings and tolerances) has as many
    degrees of freedom as there are readings, and pose sigma is finite.
    """
    squares, values = [], []
    for seed in range(6):
        rng = np.random.default_rng(100 + seed)
        nominal = hexapods.rings(rng)
        mechanism = symkin.load(str(described(tmp_path, *nominal)))
        true = [t + rng.normal(size=t.shape) for t in nominal]
        path = measured(tmp_path, *true, rng, rows=5)
        fixed = [f"leg{k}.offset" for k in range(1, 7)]
        fit = calibrate(
            mechanism,
            read_measurements(path, mechanism).measurements,
            fixed=fixed,
            tolerance=(1.0, 0.01),
        )
        assert fit.status == "ok"
        assert fit.degrees == 30
        values.append(fit.chi_square / fit.degrees)
        error = np.array(
            [
                p.value
                - true[("base", "platform").index(p.name.split(".")[1])][int(p.name[3]) - 1][
                    "xyz".index(p.name[-1])
                ]
                for p in fit.parameters
                if not p.held
            ]
        )
        covariance = fit.covariance[: len(error), : len(error)]
        squares.append(error @ np.linalg.solve(covariance, error) / len(error))
        assert 0.3 < np.max(np.sqrt(np.diag(covariance))) < 1.0
    assert 0.7 < np.mean(squares) < 1.35
    assert 0.7 < np.mean(values) < 1.35


@pytest.mark.slow
def test_a_tolerance_holds_a_machine_that_is_within_and_refuses_one_that_is_not(capsys, tmp_path):
    """Joint centres 60 mm away are another machine; with a tolerance of 40 mm they are expected,
    with one of 1 mm not.
    """
    rng = np.random.default_rng(5)
    nominal = hexapods.rings(rng)
    machine, data, out = (
        described(tmp_path, *nominal),
        measured(tmp_path, *built(*nominal, rng, 60.0), rng),
        tmp_path / "out",
    )
    assert (
        run(capsys, "calibrate", "fit", machine, data, "-o", out, "--tolerance", "1mm,0.1deg")[0]
        == 3
    )
    assert (
        run(capsys, "calibrate", "fit", machine, data, "-o", out, "--tolerance", "3deg,40mm")[0]
        == 0
    )
    assert run(capsys, "calibrate", "fit", machine, data, "-o", out, "--tolerance", "40mm")[0] == 2


def test_what_no_reading_sees_has_no_standard_deviation():
    """The last twist of an arm read by positions alone: unknown, and not exactly known."""
    arm, rng = symkin.load("gluon_6l3"), np.random.default_rng(0)
    joints = rng.uniform(-1.5, 1.5, (40, 6))
    tips = [symkin.solve(arm, joints=np.degrees(row)).solution.pose.position for row in joints]
    noisy = np.array(tips) + 1e-2 * rng.normal(size=(40, 3))
    fit = calibrate(arm, symkin.Measurements(joints, position=noisy, position_sigma=1e-2))
    unknown = [q.name for q in fit.parameters if not q.held and q.sigma is None]
    assert unknown == ["dh.6.alpha"]
    told = {q["name"]: q["sigma"] for q in fit.to_dict()["parameters"]}
    assert told["dh.6.alpha"] is None
    assert told["dh.6.a"] > 0
