"""Words of a command line that are wrong: one sentence that says what is meant."""

import shlex
from pathlib import Path

import pytest

import symkin
from helpers.command_line import run
from helpers.inside import parse


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("modes zhao2000 --joints 1 2 3 4", ["separate values by commas", "--joints 1,2,3,4"]),
        ("modes zhao2000 --joints 1, 2, 3, 4", ["--joints 1,2,3,4"]),
        ("modes zhao2000 --joints -1 -2 3 4", ["--joints -1,-2,3,4"]),
        ("track zhao2000 --from 1 2 3 4 --to 2 3 4 5", ["--from 1,2,3,4"]),
        ("modes zhao2000 --given theta1=80 op=200", ["--given theta1=80,op=200"]),
        ("singularities zhang2009 --plane x y", ["--plane x,y"]),
        ("modes zhao2000 1,2,3,4", ["'1,2,3,4' stands alone", "--joints 1,2,3,4"]),
        ("track zhang2009 -o path.csv stray", ["'stray' stands alone"]),
        ("firmware zhao2000 -o ''", ["-o is empty; the name of a file or folder is needed"]),
        ("modes zhao2000 --plot=", ["--plot is empty"]),
        ("modes zhao2000 --joints", ["--joints has no value", "--joints V1,V2,..."]),
        ("modes zhao2000 --jonts 1", ["'--jonts'", "do you mean '--joints'?", "`symkin modes -h`"]),
        ("view zhao2000 -o page.html", ["'-o' is unknown", "do you mean '--html'?"]),
        ("modes zhao2000 --output a.png", ["'--output'", "do you mean '--plot'?"]),
        ("modes zhao2000 --json=yes", ["--json takes no value"]),
        ("modes", ["MECH is missing", "`symkin modes -h`"]),
        ("firmware zhao2000", ["-o DIR is missing"]),
        ("mode zhao2000", ["'mode' is unknown", "do you mean 'modes'?", "allowed: list, show"]),
        ("zhao2000", ["'zhao2000' is a mechanism", "symkin modes zhao2000"]),
        ("calibrate zhang2009 data.csv", ["symkin calibrate fit zhang2009"]),
        ("help", ["symkin --help"]),
        (
            "modes zhao2000 --method multstart",
            ["--method 'multstart' is unknown", "'multistart'", "continuation"],
        ),
        ("list zhao2000", ["options only"]),
        (
            "modes jansen_leg --given foot.x=1",
            ["foot is a point of shin", "[platform] link = 'shin'", "coordinates are x, y, z"],
        ),
    ],
)
def test_words_are_told_what_they_lack(
    capsys: pytest.CaptureFixture[str], words: str, expected: list[str]
) -> None:
    """Status 2, nothing on stdout, one line with the offender and how it is written."""
    status, out, err = run(capsys, *shlex.split(words))
    assert (status, out) == (2, "")
    assert err.startswith("symkin: ")
    assert len(err.splitlines()) == 1
    assert all(text in err for text in expected), err


@pytest.mark.parametrize(
    ("mech", "expected"),
    [
        ("loops.yaml", "a YAML file tells the loops of a URDF file beside it"),
        ("folder", "is a folder"),
        ("plain", "the file has no suffix"),
        ("notes.txt", "the file has the suffix '.txt'"),
        ("mine", "the file is named mine.toml"),
        ("mien.toml", "there is no such file (do you mean 'mine.toml'?)"),
        ("mien.urdf", "there is no such file (do you mean 'mine.urdf'?)"),
        ("nothere.toml", "nothere.toml: there is no such file\n"),  # not 'str.toml'
        ("some/where", "there is no such file"),
        ("zhao200", "'zhao200' is unknown (do you mean 'zhao2000'?)"),
        ("zhang2009.tml", "zhang2009.tml: there is no such file"),
        ("../zhang2009", "there is no such file"),
        ("", "an empty text"),
        (" ", "an empty text"),
    ],
)
def test_what_is_no_mechanism_is_told_apart(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    mech: str,
    expected: str,
) -> None:
    """A file that is something else, a folder, a name without its suffix, a misspelt name: each has
    its own sentence.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    for name in ("loops.yaml", "plain", "notes.txt", "mine.toml", "str.toml", "mine.urdf"):
        (tmp_path / name).write_text("")
    status, out, err = run(capsys, "show", mech)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert expected in err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (
            "modes zhao2000 --joints theta1=80,theta2=200,theta3=330,opp=105",
            "'opp' is unknown (do you mean 'op'?)",
        ),
        ("solve ankle --given uper_motor=8,lower_motor=12", "do you mean 'upper_motor'?"),
        ("sweep zhao2000 --grid theta_1=1:2:3 -o x", "do you mean 'theta1'?"),
        ("singularities zhang2009 --plane leg1,lge2", "do you mean 'leg2'?"),
        (
            "jacobian ankle --of ankle.3 --by upper_motor,lower_motor --format c",
            "do you mean 'ankle.2'?",
        ),
        (
            "calibrate plan zhang2009 -o x.csv --parameters leg1.bsae.x",
            "do you mean 'leg1.base.x'?",
        ),
        ("calibrate plan zhang2009 -o x.csv --criterion d", "do you mean 'D'?"),
    ],
)
def test_names_are_told_the_nearest_one(
    capsys: pytest.CaptureFixture[str], words: str, expected: str
) -> None:
    """Joints, coordinates, axes of a plane, parameters, values of options."""
    status, out, err = run(capsys, *words.split())
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert expected in err


def test_a_key_of_a_file_is_told_the_nearest_one(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Keys, and values that are words, as they are meant: `bsae` is `base`."""
    text = symkin.load("zhang2009").to_toml()
    for old, new, expected in (
        ("base =", "bsae =", "do you mean 'base'?"),
        ('length_unit = "mm"', 'length_unit = "mmm"', "do you mean 'mm'?"),
        ('angle_unit = "deg"', 'angle_unit = "degree"', "do you mean 'deg'?"),
        ('type = "SPS"', 'type = "sps"', "do you mean 'SPS'?"),
        ("format = 1\n", "", "format is missing; allowed: 1"),
        ('length_unit = "mm"', "", "length_unit is missing; allowed: 'm', 'mm'"),
    ):
        assert old in text
        (tmp_path / "m.toml").write_text(text.replace(old, new, 1))
        status, _, err = run(capsys, "show", str(tmp_path / "m.toml"))
        assert (status, err.count("\n")) == (2, 1)
        assert expected in err
    text = symkin.load("four_bar").to_toml().replace('type = "R"', 'type = "revolute"', 1)
    with pytest.raises(symkin.MechanismError, match=r"\(do you mean 'R'\?\); allowed: 'R'"):
        parse(text)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("modes zhao2000 --joints 80deg,200,330,105", "without a unit"),
        ("modes zhao2000 --joints 80,200,330,105mm", "without a unit"),
        ("modes zhao2000 --joints theta1:80", "NAME=VALUE"),
        ("modes zhao2000 --joints 80;200;330;105", "separated by commas"),
        ("modes zhao2000 --pose x=0,y=0,z=100", "these values have no names"),
        ("solve zhao2000 --start 1", "start: 1 value given"),
        ("track zhao2000 81,202,330,105 85,200,330,110", "a path is --from 81,202,330,105 --to"),
        ("mode-graph zhao2000 --over theta1", "--over: 'theta1' is no range; NAME=LOW:HIGH"),
        ("mode-graph zhao2000 --over theta1=70:90 --points 1", "--points"),
        (
            "transmission ankle --motors upper_motor,lower_motor --at 8",
            "1 value given, 2 are needed: upper_motor, lower_motor",
        ),
        (
            "view zhao2000 --joints 1,2 --html x.html",
            "2 values given, zhao2000 has 4 actuated joints",
        ),
    ],
)
def test_values_are_told_how_they_are_written(
    capsys: pytest.CaptureFixture[str], words: str, expected: str
) -> None:
    """Units, colons, names where none are taken, too few values: one line that says what is written
    instead.
    """
    status, out, err = run(capsys, *words.split())
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert expected in err


@pytest.mark.parametrize(
    "words",
    [
        "track zhao2000 --csv paht.csv",
        "view zhao2000 --path paht.csv --html page.html",
        "calibrate fit zhang2009 paht.csv -o fitted",
    ],
)
def test_a_table_that_is_not_there_is_told_the_nearest_file(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    words: str,
) -> None:
    """As for a mechanism's own file, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "path.csv").write_text("")
    status, out, err = run(capsys, *words.split())
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "paht.csv: there is no such file (do you mean 'path.csv'?)" in err
    assert [file.name for file in tmp_path.iterdir()] == ["path.csv"]
