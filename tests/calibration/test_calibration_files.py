"""Measurement files: what is written is read back, every mistake is named by line and column, slips
are found.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.csv_cells import rewritten
from helpers.inside import (
    SEQUENCES,
    Case,
    Noise,
    Workspace,
    diagnose,
    find_sequence,
    fit_file,
    group_numbers,
    match_parameters,
    random_configurations,
    read_measurements,
    simulate_readings,
)
from helpers.measured_files import write_measurements
from symkin import InputError

NOMINAL, TRUE = symkin.load("ren2008"), symkin.load("ren2008_true")
QUIET = Noise(lengths=1e-6, group=1e-5, inclination=1e-5, position=1e-5, orientation=1e-5)


@pytest.fixture(scope="module")
def measured():
    rng = np.random.default_rng(4)
    groups = group_numbers(24, 6)
    made = random_configurations(Workspace.about(TRUE), groups, QUIET, rng)
    return simulate_readings(TRUE, made, groups, ("inclination", "pose"), QUIET, rng)


def test_rounded_quaternions_and_columns_of_another_name_are_told(tmp_path, measured):
    """Quaternions of three digits tell orientations to some hundredths of a degree, and exact ones
    are not suspected; a standard deviation of orientations names the columns that are not read.
    """
    path = tmp_path / "data.csv"
    for digits, told in ((9, 0), (3, 1)):
        write_measurements(path, NOMINAL, measured)
        header, *rows = (line.split(",") for line in path.read_text().splitlines())
        turns = [header.index(name) for name in ("qw", "qx", "qy", "qz")]
        for row in rows:
            row[turns[0] : turns[3] + 1] = [f"{float(row[k]):.{digits}f}" for k in turns]
        path.write_text("\n".join(map(",".join, [header, *rows])) + "\n")
        notes = read_measurements(path, NOMINAL).notes
        assert sum("qw, qx, qy, qz are rounded" in note for note in notes) == told
    write_measurements(path, NOMINAL, replace(measured, orientation=None, orientation_sigma=None))
    lines = path.read_text().split("\n")
    more = ["rx[deg],ry[deg],rz[deg]", *["1.0,2.0,3.0"] * (len(lines) - 2), ""]
    path.write_text("\n".join(f"{a},{b}" if b else a for a, b in zip(lines, more, strict=True)))
    with pytest.raises(InputError, match=r"left out: 'rx.*rz"):
        fit_file(NOMINAL, read_measurements(path, NOMINAL), sigmas={"orientation": 1e-4})


@pytest.mark.parametrize("sequence", [None, "ZYX", "xyz", "YZY"])
def test_files_hold_what_is_written(tmp_path, measured, sequence):
    """Reading back gives the same numbers to rounding: joints, groups, readings, standard
    deviations.
    """
    path = tmp_path / "data.csv"
    write_measurements(path, NOMINAL, measured, sequence=sequence)
    back = read_measurements(path, NOMINAL).measurements
    assert np.array_equal(back.groups, measured.groups)
    for key in ("joints", "inclination", "position"):
        np.testing.assert_allclose(
            getattr(back, key), getattr(measured, key), rtol=1e-14, atol=1e-15
        )
    same = np.abs(np.sum(back.orientation * measured.orientation, axis=1))
    np.testing.assert_allclose(same, 1.0, atol=1e-13)
    for key in ("joint", "group", "inclination", "position", "orientation"):
        np.testing.assert_allclose(back.sigma(key), measured.sigma(key), rtol=1e-12)


def test_roll_pitch_and_yaw_turn_about_fixed_axes(tmp_path, measured):
    path = tmp_path / "data.csv"
    write_measurements(path, NOMINAL, measured, sequence="xyz")
    text = path.read_text()
    for number, name in enumerate(("roll", "pitch", "yaw"), start=1):
        assert f"euler_xyz_{number}[" in text
        text = text.replace(f"euler_xyz_{number}[", f"{name}[")
    path.write_text(text)
    back = read_measurements(path, NOMINAL).measurements
    same = np.abs(np.sum(back.orientation * measured.orientation, axis=1))
    np.testing.assert_allclose(same, 1.0, atol=1e-13)


def test_units_of_the_header_count(tmp_path, measured):
    """Lengths in mm and angles in arcsec are the same readings."""
    path = tmp_path / "data.csv"
    write_measurements(path, NOMINAL, measured)

    def other_units(header, rows):
        for k, name in enumerate(header):
            factor, unit = (
                (1e3, "mm")
                if name.endswith("[m]")
                else (3600, "arcsec")
                if name.endswith("[deg]")
                else (None, "")
            )
            if factor:
                header[k] = name.split("[")[0] + f"[{unit}]"
                for row in rows:
                    row[k] = repr(float(row[k]) * factor)

    back = read_measurements(rewritten(path, other_units), NOMINAL).measurements
    np.testing.assert_allclose(back.joints, measured.joints, rtol=1e-13)
    np.testing.assert_allclose(back.inclination, measured.inclination, rtol=1e-12, atol=1e-15)


def as_a_spreadsheet_writes(path):
    """Semicolons, decimal commas, capitals, units in parentheses, NaN, a byte order mark, CRLF, a
    column of times and remarks.
    """
    header, *rows = [line.split(",") for line in path.read_text().splitlines()]
    names = [re.sub(r"\[(.*)\]", r" (\1)", name).capitalize() for name in header]
    lines = [[*names, "Uhrzeit", "Bemerkung"]]
    lines += [
        [*(cell.replace(".", ",") or "NaN" for cell in row), f"12:00:{k:02d}.5", "1.5"]
        for k, row in enumerate(rows)
    ]
    path.write_bytes(("\ufeff" + "".join(";".join(line) + "\r\n" for line in lines)).encode())
    return path


def test_a_spreadsheets_file_is_the_same_file(tmp_path, measured):
    """Every number, label and blank is that of the file as symkin writes it, and the notes say what
    was read otherwise.
    """
    part = measured.without(3, "position")
    write_measurements(tmp_path / "own.csv", NOMINAL, part)
    write_measurements(tmp_path / "other.csv", NOMINAL, part)
    own = read_measurements(tmp_path / "own.csv", NOMINAL)
    other = read_measurements(as_a_spreadsheet_writes(tmp_path / "other.csv"), NOMINAL)
    for key in ("joints", "groups", "inclination", "position", "orientation"):
        assert np.array_equal(
            getattr(own.measurements, key), getattr(other.measurements, key), equal_nan=True
        )
    for key in ("joint", "group", "inclination", "position", "orientation"):
        assert np.array_equal(own.measurements.sigma(key), other.measurements.sigma(key))
    said = " ".join(set(other.notes) - set(own.notes))
    for words in (
        "semicolons",
        "decimal commas",
        "'Leg1 (m)' as leg1[m]",
        "3 cells with NaN",
        "'Uhrzeit', 'Bemerkung'",
    ):
        assert words in said


def test_rows_with_their_own_times_are_no_copies(tmp_path, measured):
    """A row with the readings of an earlier one and another time stays; with the same time it is a
    copy.
    """
    path = tmp_path / "data.csv"
    write_measurements(path, NOMINAL, measured)
    header, *rows = path.read_text().splitlines()
    lines = [
        f"{header},time",
        *(f"{row},{k}" for k, row in enumerate(rows)),
        f"{rows[0]},99",
        f"{rows[1]},1",
    ]
    path.write_text("\n".join(lines) + "\n")
    assert read_measurements(path, NOMINAL).copies == ((len(rows) + 1, 1),)


def set_cell(row, column, value):
    def change(header, rows):
        rows[row][next(k for k, name in enumerate(header) if name.split("[")[0] == column)] = value

    return change


def rename(old, new):
    def change(header, rows):
        header[header.index(old)] = new

    return change


@pytest.mark.parametrize(
    ("change", "fragments"),
    [
        (set_cell(3, "leg2", ""), ("line 5", "leg2[m]")),
        (set_cell(0, "leg6", "abc"), ("line 2", "leg6[m]", "abc")),
        (set_cell(2, "leg1", "-2"), ("line 4", "leg1[m]", "negative length")),
        (set_cell(4, "qw", "9"), ("line 6", "qw", "norm")),
        (set_cell(4, "qx", ""), ("line 6", "qx", "all or none")),
        (set_cell(1, "sigma_alpha", "0"), ("line 3", "sigma_alpha", "positive")),
        (rename("leg3[m]", "leg3[deg]"), ("leg3[deg]", "unit of length")),
        (rename("leg3[m]", "leg7[m]"), ("leg7", "leg1, leg2")),
        (rename("sigma_leg4[m]", "sigma_alpha2[m]"), ("'sigma_leg4' is missing", "sigma_alpha2")),
        (rename("beta[deg]", "euler_XXY_1[deg]"), ("XXY", "neighbours different")),
        (rename("beta[deg]", "EULER_ZYX_1[deg]"), ("in capitals", "euler_ZYX_1 for moving axes")),
        (rename("beta[deg]", "Tilt B"), ("'beta' is missing", "Tilt B")),
    ],
)
def test_mistakes_are_named_by_line_and_column(tmp_path, measured, change, fragments):
    """Every mistake is refused in one sentence with the file, the line and the column."""
    path = tmp_path / "data.csv"
    write_measurements(path, NOMINAL, measured)
    with pytest.raises(InputError) as refused:
        read_measurements(rewritten(path, change), NOMINAL)
    for fragment in ("data.csv", *fragments):
        assert fragment in str(refused.value)


def test_empty_cells_and_columns_are_readings_not_taken(tmp_path, measured):
    """An empty cell is no reading; a column of empty cells is no column; a group of one is noted
    and says nothing.
    """
    path = tmp_path / "data.csv"
    write_measurements(path, NOMINAL, measured)

    def change(header, rows):
        for row in rows:
            row[header.index("z[m]")] = ""
        rows[2][header.index("x[m]")] = ""
        rows[0][0] = "alone"

    data = read_measurements(rewritten(path, change), NOMINAL)
    assert np.all(np.isnan(data.measurements.position[:, 2]))
    assert np.isnan(data.measurements.position[2, 0])
    assert np.isfinite(data.measurements.position[:, 1]).all()
    assert data.measurements.groups[0] == -1
    assert any("line 2" in note and "alone" in note for note in data.notes)


def test_names_of_joints_come_before_names_of_readings(tmp_path):
    """Where joints are called x, y, z the platform's position is platform.x, platform.y,
    platform.z.
    """
    axes = np.eye(3)
    joints = [
        symkin.Joint(n, "P", axis=tuple(a), actuated=True) for n, a in zip("xyz", axes, strict=True)
    ]
    gantry = symkin.Mechanism(
        "gantry", [symkin.Limb("gantry", joints)], serial=True, platform_position=(0, 0, 50.0)
    )
    rng = np.random.default_rng(0)
    workspace = Workspace.about(gantry)
    made = workspace.draw(workspace.inclinations(5, rng), rng, held=False)
    taken = simulate_readings(gantry, made, np.full(5, -1), ("position",), Noise(position=0.1), rng)
    path = tmp_path / "data.csv"
    write_measurements(path, gantry, taken)
    header = path.read_text().splitlines()[0]
    assert header.startswith("x[mm],y[mm],z[mm],platform.x[mm]")
    back = read_measurements(path, gantry).measurements
    np.testing.assert_allclose(back.position, taken.position, rtol=1e-14)
    np.testing.assert_allclose(back.joints, taken.joints, rtol=1e-14)


def test_every_sequence_is_named_and_different():
    """Twelve sequences about moving and twelve about fixed axes, neighbours different."""
    assert len(set(SEQUENCES)) == len(SEQUENCES) == 24
    assert sum(s.isupper() for s in SEQUENCES) == 12
    assert all(s[0] != s[1] != s[2] for s in SEQUENCES)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(("sequence", "rows"), [("YXZ", 600), ("zyz", 60)])
def test_the_euler_sequence_that_fits_is_found(tmp_path, sequence, rows):
    """600 or 60 rows of joints and poses, truth and sequence hidden: the whole geometry of a
    platform from joint centres a tenth of the size wrong (which is another machine, and said to be
    expected), and the sequence, clear of the runner-up.
    """
    true = symkin.load("zhang2009")
    rng = np.random.default_rng(21)
    workspace = Workspace.about(true)
    noise = Noise(lengths=0.01, position=0.02, orientation=math.radians(0.005))
    made = workspace.draw(workspace.inclinations(rows, rng), rng, held=False)
    path = tmp_path / "data.csv"
    write_measurements(
        path,
        true,
        simulate_readings(true, made, group_numbers(rows, 0), ("pose",), noise, rng),
        sequence=sequence,
        hidden=True,
    )
    assert sequence not in path.read_text()

    def away(point):
        return tuple(np.array(point) + 0.1 * true.characteristic_length * rng.uniform(-1, 1, 3))

    wrong = replace(
        true,
        limbs=[
            replace(limb, base=away(limb.base), platform=away(limb.platform)) for limb in true.limbs
        ],
    )
    data = read_measurements(path, wrong)
    choice = find_sequence(wrong, data)
    assert choice.sequence == sequence
    assert choice.clear
    assert choice.second.chi_square > 100 * choice.best.chi_square
    report = fit_file(wrong, data, any_machine=True)
    assert report.believable, report.verdict
    assert report.fit.rank == 42
    closure = inside.build_closure(true)
    truth = dict(zip(closure.parameter_names, closure.parameter_values, strict=True))
    for p in report.fit.parameters:
        assert abs(p.value - truth[p.name]) < 5 * p.sigma, p.name


@pytest.mark.parametrize(
    ("slip", "word"),
    [
        (lambda q: q * 1e-3, "too small"),
        (lambda q: q * 1e3, "too large"),
        (lambda q: q[:, [0, 4, 2, 3, 1, 5]], "leg2 and leg5 look exchanged"),
    ],
)
def test_slips_are_suspected(measured, slip, word):
    """Units wrong by 1000 and exchanged columns are named; right readings are not suspected."""
    grouped = replace(
        measured,
        inclination=None,
        position=None,
        orientation=None,
        inclination_sigma=None,
        position_sigma=None,
        orientation_sigma=None,
    )
    assert diagnose(Case(NOMINAL, grouped)) == ()
    assert word in diagnose(Case(NOMINAL, replace(grouped, joints=slip(grouped.joints))))[0]


def test_patterns_name_parameters():
    """Patterns match names of parameters; `all` is the closure's; what matches nothing is refused
    with examples.
    """
    assert len(match_parameters(NOMINAL, "all")) == 42
    assert match_parameters(NOMINAL, "leg2.base.*, leg1.offset") == (
        "leg1.offset",
        "leg2.base.x",
        "leg2.base.y",
        "leg2.base.z",
    )
    assert len(match_parameters(NOMINAL, "all,leg*.scale")) == 48
    with pytest.raises(InputError, match=r"leg\*\.bse.*leg1\.base\.x"):
        match_parameters(NOMINAL, "leg*.bse")
