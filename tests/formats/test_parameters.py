"""`[parameters]` of a mechanism file: numbers with names, which its other numbers may use."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import symkin
from helpers.command_line import run, run_json
from symkin import InputError, MechanismError, ReadOptions, load

PARAMETERS = """[parameters]
ground = 100.0
crank = "ground/4"
Height_2 = "80*sin(60)"
"""
BODY = """
[[joint]]
name = "crank"
type = "R"
links = ["base", "a"]
point = [0.0, 0.0, 0.0]
axis = [0, 0, 1]
actuated = true
limits = ["-crank", "crank + 5"]
[[joint]]
name = "elbow"
type = "R"
links = ["a", "b"]
point = [0.0, "crank", 0.0]
axis = [0, 0, 1]
[[joint]]
name = "knee"
type = "R"
links = ["b", "c"]
point = ["ground", "Height_2", 0.0]
axis = [0, 0, 1]
[[joint]]
name = "follower"
type = "R"
links = ["base", "c"]
point = ["ground", 0.0, 0.0]
axis = [0, 0, 1]
"""
HEAD = 'format = 1\nname = "four"\nlength_unit = "mm"\nangle_unit = "deg"\n'


def written(folder: Path, parameters: str = PARAMETERS, body: str = BODY) -> Path:
    """A file of a four-bar in the folder."""
    path = folder / "four.toml"
    path.write_text(HEAD + parameters + body, encoding="utf-8")
    return path


def with_numbers(**numbers: float) -> str:
    """The tables with numbers in place of names."""
    text = BODY.replace('"crank + 5"', repr(numbers["crank"] + 5.0))
    text = text.replace('"-crank"', repr(-numbers["crank"])).replace('name = "crank"', "NAME")
    for name, value in numbers.items():
        text = text.replace(f'"{name}"', repr(value))
    return text.replace("NAME", 'name = "crank"')


HEIGHT = 80 * math.sin(60 * (math.pi / 180))


@pytest.mark.parametrize(
    ("told", "numbers"),
    [
        ({}, (100.0, 25.0, HEIGHT)),
        ({"ground": 120.0}, (120.0, 30.0, HEIGHT)),
        ({"crank": "ground/5", "Height_2": 70}, (100.0, 20.0, 70.0)),
    ],
)
def test_names_stand_for_their_numbers(
    told: dict[str, Any], numbers: tuple[float, ...], tmp_path: Path
) -> None:
    """A file with names is the file with numbers in their place, also where others are told: what
    depends on them follows.
    """
    found = load(written(tmp_path), set=told)
    assert found == load(written(tmp_path), ReadOptions(set=told))
    ground, crank, height = numbers
    plain = with_numbers(ground=ground, crank=crank, Height_2=height)
    assert found == load(written(tmp_path, "", plain))


def test_what_is_written_holds_the_numbers(tmp_path: Path) -> None:
    """A file that is written reads as the same mechanism, and its closed configuration is that of
    the numbers told.
    """
    path, output = written(tmp_path), tmp_path / "out.toml"
    symkin.convert(path, output, ReadOptions(set={"ground": 110.0}))
    assert load(output) == load(path, set={"ground": 110.0})
    assert symkin.close(path, ReadOptions(set={"ground": 110.0})).closed


def test_every_command_takes_set(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """`--set`, once or several times, with arithmetic, is `set` of `load`."""
    path = str(written(tmp_path))
    words = ("solve", path, "--given", "crank=10", "--set", "ground=2*60", "--set", "Height_2=70")
    status, data = run_json(capsys, *words)
    there = load(path, set={"ground": 120.0, "Height_2": 70.0})
    solution = symkin.solve(there, given={"crank": 10.0}).solution
    assert status == 0
    assert solution is not None
    assert data["solution"]["joints"]["follower"] == pytest.approx(
        solution.joints["follower"], abs=1e-9
    )


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ("parameters = 3\n", "parameters = 3: a table of names with numbers is needed"),
        ("[parameters]\nsin = 1\n", "parameters.sin: sin has a meaning in arithmetic"),
        (
            "[parameters]\n2x = 1\n",
            "parameters.2x: the name of a parameter has letters, digits and _",
        ),
        ("[parameters]\nx = [1]\n", r"parameters.x = \[1\]: a number or a string of arithmetic"),
        ('[parameters]\na = "b"\nb = 1\n', "parameters.a = 'b': 'b' is no arithmetic"),
        (
            '[parameters]\na = 1\nb = "b"\n',
            "'b' is no arithmetic: b is no parameter; allowed: .* a$",
        ),
        ('[parameters]\na = "1e200^2"\n', "parameters.a = '1e200\\^2': .*"),
        (
            "[parameters]\nground = 1.0\ncrnk = 2\nHeight_2 = 3\n",
            r"joint\[0\] \(crank\).limits\[0\] = '-crank': '-crank' is no arithmetic: crank is no "
            r"parameter \(do you mean 'crnk'\?\); allowed: .*, and the parameters ground, crnk, "
            "Height_2$",
        ),
    ],
)
def test_mistakes_are_one_sentence(parameters: str, message: str, tmp_path: Path) -> None:
    """File, key path, value, what is allowed."""
    with pytest.raises(MechanismError, match=rf"four.toml: .*{message}"):
        load(written(tmp_path, parameters))


@pytest.mark.parametrize(
    ("told", "message"),
    [
        ({"groun": 1.0}, r"set: no parameter is named 'groun' \(do you mean 'ground'\?\)"),
        ({"ground": "1/0"}, "set.ground = '1/0': '1/0' has no value"),
        ({"ground": float("nan")}, "set.ground = nan: a finite number is needed"),
        ({"ground": True}, "set.ground = True: a number"),
        ({"ground": "Height_2"}, "set.ground = 'Height_2'"),
    ],
)
def test_what_is_told_wrong_is_refused(told: dict[str, Any], message: str, tmp_path: Path) -> None:
    """A name that the file has not, and values that are no numbers."""
    with pytest.raises(MechanismError, match=message):
        load(written(tmp_path), set=told)


def test_only_mechanism_files_have_parameters(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """A shipped mechanism without any, a robot's file and what is no mapping are refused."""
    with pytest.raises(MechanismError, match=r"the file has no \[parameters\]"):
        load("zhao2000", set={"L": 1.0})
    robot = tmp_path / "r.urdf"
    robot.write_text("<robot name='r'><link name='a'/></robot>", encoding="utf-8")
    with pytest.raises(InputError, match=r"set \(--set\) has no meaning for .*r.urdf: parameters"):
        load(robot, set={"L": 1.0})
    with pytest.raises(InputError, match="set = 3; a mapping of names to values is needed"):
        load("zhao2000", set=3)  # type: ignore[arg-type]
    assert run(capsys, "show", "zhao2000", "--set", "L")[0] == 2


def test_keys_of_other_formats_may_be_names_of_parameters(tmp_path: Path) -> None:
    """A parameter may be called `ratio`, which as a key of a table belongs to another format."""
    parameters = PARAMETERS + "ratio = 2.0\n"
    assert load(written(tmp_path, parameters)) == load(written(tmp_path))
