"""What `symkin calibrate` writes replaces nothing that symkin has not written, and nothing that was
edited since.
"""

from __future__ import annotations

import hashlib

import pytest

import symkin
from helpers.inside import main

FIT = ("fit", "ren2008", "data.csv", "-o", "out")
SIMULATE = ("simulate", "ren2008", "--readings", "pose", "--postures", "16", "-o", "made.csv")
PLAN = (
    "plan",
    "ren2008",
    "--readings",
    "pose",
    "--groups",
    "0",
    "--postures",
    "8",
    "-o",
    "made.csv",
)


def run(capsys, *arguments):
    """Exit status, stdout and stderr."""
    with pytest.raises(SystemExit) as ended:
        main(["calibrate", *map(str, arguments)])
    said = capsys.readouterr()
    return ended.value.code or 0, said.out, said.err


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch, capsys):
    """A working folder with a file of measurements."""
    monkeypatch.chdir(tmp_path)
    run(capsys, "simulate", "ren2008", "--readings", "pose", "--postures", "16", "-o", "data.csv")
    return tmp_path


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", [SIMULATE, pytest.param(PLAN, marks=pytest.mark.long)], ids=["simulate", "plan"]
)
def test_a_file_of_the_users_is_kept(capsys, folder, command):
    """It is named before anything is computed, and kept; --force replaces it."""
    (folder / "made.csv").write_text("mine")
    status, out, err = run(capsys, *command)
    assert (status, out) == (2, "")
    assert "would replace made.csv, there already and not written by symkin" in err
    assert err.count("\n") == 1
    assert (folder / "made.csv").read_text() == "mine"
    assert run(capsys, *command, "--force")[0] == 0
    assert (folder / "made.csv").read_text() != "mine"


@pytest.mark.slow
def test_a_file_is_replaced_only_as_it_was_written(capsys, folder):
    """symkin's own file is written again, its digest beside it; edited since, it is named and kept;
    --force replaces it.
    """
    made = folder / "made.csv"
    for seed in (1, 2):
        assert run(capsys, *SIMULATE, "--seed", seed)[0] == 0
    written = made.read_bytes()
    assert (folder / "made.csv.sha256").read_text().split() == [
        hashlib.sha256(written).hexdigest(),
        "made.csv",
    ]
    made.write_bytes(written + b"# mine\n")
    status, _, err = run(capsys, *SIMULATE)
    assert status == 2
    assert "would replace made.csv, edited since" in err
    assert made.read_bytes() == written + b"# mine\n"
    assert run(capsys, *SIMULATE, "--force")[0] == 0
    assert b"mine" not in made.read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["report.md", "ren2008.toml", "pose_sigma.png", "manifest.json"])
def test_a_folder_with_a_file_of_the_users_is_kept(capsys, folder, name):
    """Each of the names: a sentence with it, before anything is computed, and nothing is written;
    --force replaces it.
    """
    out = folder / "out"
    out.mkdir()
    (out / name).write_text("mine")
    status, said, err = run(capsys, *FIT)
    assert (status, said) == (2, "")
    assert f"would replace {name}, there already and not written by symkin" in err
    assert contents(out) == {name: b"mine"}


@pytest.mark.long
@pytest.mark.slow
def test_a_fit_replaces_its_own_unedited_folder(capsys, folder):
    """Written again as it is, other files stay; an edited file is named and nothing changes, also
    where the new fit would not be usable; --force replaces it; another mechanism's folder is kept.
    """
    out = folder / "out"
    assert run(capsys, *FIT)[0] == 0
    (out / "notes.txt").write_text("mine")
    assert run(capsys, *FIT)[0] == 0
    (out / "report.md").write_text((out / "report.md").read_text() + "mine")
    before = contents(out)
    for arguments in (FIT, (*FIT[:2], "none.csv", *FIT[3:])):
        status, _, err = run(capsys, *arguments)
        assert status == 2
        assert "would replace report.md, edited since they were written" in err
        assert contents(out) == before
    assert run(capsys, *FIT, "--force")[0] == 0
    assert "mine" not in (out / "report.md").read_text()
    assert (out / "notes.txt").read_text() == "mine"
    status, _, err = run(capsys, "fit", "ren2008_true", *FIT[2:])
    assert status == 2
    assert "holds the calibration of 'ren2008'" in err


@pytest.mark.long
@pytest.mark.slow
def test_a_run_that_was_cut_short_is_mended(capsys, folder, monkeypatch):
    """Where the disk is full after some files, the same command writes the folder, the file, once
    there is room.
    """
    from helpers.inside import calibrate_folder

    assert run(capsys, *FIT)[0] == 0
    whole, left = calibrate_folder.write_output, iter(range(4))

    def replace(target, content):
        if next(left, None) is None:
            raise OSError(28, "No space left on device")
        whole(target, content)

    monkeypatch.setattr(calibrate_folder, "write_output", replace)
    status, _, err = run(capsys, *FIT)
    assert status == 2
    assert "No space left" in err
    monkeypatch.setattr(calibrate_folder, "write_output", whole)
    assert run(capsys, *FIT)[0] == 0


@pytest.mark.long
@pytest.mark.slow
def test_what_an_unusable_fit_leaves_is_still_its_own(capsys, folder):
    """The mechanism of an earlier fit stays when a later one cannot be used, and is replaced by the
    next that can.
    """
    assert run(capsys, *FIT)[0] == 0
    header, *rows = (folder / "data.csv").read_text().splitlines()
    (folder / "few.csv").write_text("\n".join([header, *rows[:3]]) + "\n")
    assert run(capsys, "fit", "ren2008", "few.csv", "-o", "out")[0] == 3
    assert (folder / "out" / "ren2008.toml").exists()
    assert run(capsys, *FIT)[0] == 0
    assert symkin.load(str(folder / "out" / "ren2008.toml")).name == "ren2008"
