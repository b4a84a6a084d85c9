"""What is told of a robot beside its file: kinds of closures, actuated joints, xacro and its
arguments, packages.
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from test_urdf import FORMS, PAIR, TREE, closed_values

import symkin
from helpers.command_line import run
from helpers.inside import read_robot, read_sdf, read_urdf
from symkin import InputError, ReadOptions, SymkinError, load

CLOSING = f"<robot name='r'>{TREE}{FORMS['closing']}</robot>"


@pytest.fixture
def four_bar(tmp_path: Path) -> Path:
    """A four-bar whose loop is a pair of closing frames: their mate's kind is not written."""
    path = tmp_path / "r.urdf"
    path.write_text(CLOSING, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("kind", "rows", "rank"),
    [("S", 3, 2), ("R", 5, 2), pytest.param("R:z", 5, 2, marks=pytest.mark.long), ("C", 4, 2)],
)
def test_a_closure_of_a_told_kind_has_its_rows(
    kind: str, rows: int, rank: int, four_bar: Path
) -> None:
    """A planar loop has rank 2 whatever its pin holds beside the plane; the closed joint angles are
    those of the law of cosines.
    """
    found = symkin.close(four_bar, ReadOptions(loop={"closing_d": kind}))
    assert (found.rows, found.rank, found.mobility) == (rows, rank, 1)
    mechanism = symkin.load(four_bar, ReadOptions(loop={"closing_d": kind}))
    wanted = closed_values()
    modes = symkin.modes(mechanism, given={"a": wanted["a"]})
    assert min(abs(mode.joints["c"] - wanted["c"]) for mode in modes) < 1e-9


def test_a_closure_about_another_axis_cannot_turn_in_the_plane(four_bar: Path) -> None:
    """About the x axis of frames in the plane it holds the angle between rod and rocker: one
    freedom less.
    """
    four_bar.write_text(CLOSING.replace("3 0 0", "3.5 0 0"), encoding="utf-8")
    found = symkin.close(four_bar, ReadOptions(loop={"closing_d": "R:x"}))
    assert found.mobility == 0
    first, second = (found.link_poses[f"closing_d_{k}"].rotation for k in (1, 2))
    np.testing.assert_allclose(first[:, 0], second[:, 0], atol=1e-9)


def test_the_note_of_unknown_mates_goes_where_the_kind_is_told(four_bar: Path) -> None:
    plain, told = read_robot(four_bar), read_robot(four_bar, ReadOptions(loop={"closing_d": "R"}))
    assert any("kind of the mates is not written" in note for note in plain.notes)
    assert not any("kind of the mates is not written" in note for note in told.notes)
    assert any("'closing_d' is of type R, as told" in note for note in told.notes)


def test_actuated_joints_are_those_that_are_told(four_bar: Path) -> None:
    """They and no others; the note that nothing tells them goes."""
    robot = read_robot(four_bar, ReadOptions(actuated=["c"]))
    assert [entry.joint.name for entry in robot.tree if entry.joint.actuated] == ["c"]
    assert not any("no motors" in note for note in robot.notes)
    assert [c.name for c in load(four_bar, ReadOptions(actuated=["c"])).actuated] == ["c"]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            ["--loop", "closing_e=R"],
            "loop: no closure is named 'closing_e' (do you mean 'closing_d'?); closures: closing_d",
        ),
        (["--loop", "a=R"], "loop: 'a' is a joint of the tree and closes no loop"),
        (["--loop", "closing_d=Q"], "allowed: S, U, R, C, P, weld"),
        (["--loop", "closing_d=S:x"], "names an axis, and S has none"),
        (["--loop", "closing_d"], "--loop: 'closing_d' is no NAME=VALUE"),
        (["--loop", "closing_d=R,closing_d=S"], "--loop: 'closing_d' is given twice"),
        (["--loop", ""], "--loop '': a name is empty"),
        (
            ["--actuated", "aa"],
            "actuated: no joint is named 'aa' (do you mean 'a'?); joints that may be: a, c, b",
        ),
        (
            ["--actuated", "closing_d"],
            "actuated: 'closing_d' is of type S, which no one motor drives",
        ),
        (["--actuated", "a,a"], "actuated: 'a' is given twice"),
        (["--arguments", "x=1"], "arguments (--arguments) has no meaning for"),
        (["--model", "m"], "model (--model) has no meaning for"),
        (["--packages", "nowhere"], "packages: 'nowhere' is no folder"),
    ],
)
@pytest.mark.parametrize("command", ["show", "close"])
def test_what_does_not_fit_the_file_is_refused_in_one_sentence(
    command: str,
    options: list[str],
    sentence: str,
    four_bar: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    status, out, err = run(capsys, command, str(four_bar), *options)
    assert (status, out) == (2, "")
    assert sentence in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("name", ["four_bar", "made.toml"])
@pytest.mark.parametrize(
    "option", [["--loop", "a=R"], ["--actuated", "a"], ["--model", "a"], ["--packages", "."]]
)
def test_mechanism_files_take_none_of_it(
    name: str, option: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "made.toml"
    path.write_text(symkin.load("four_bar").to_toml(), encoding="utf-8")
    for command in ("show", "close"):
        status, _, err = run(capsys, command, str(path) if name.endswith("toml") else name, *option)
        assert status == 2
        assert "has no meaning for" in err
        assert "a mechanism file says everything itself" in err


def test_other_commands_take_them_too(four_bar: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = ["--loop", "closing_d=R", "--actuated", "a"]
    status, out, _ = run(capsys, "modes", str(four_bar), *told, "--joints", "0.3", "--json")
    assert status == 0
    assert '"a"' in out
    status, _, err = run(capsys, "solve", str(four_bar), *told, "--joints", "0.3,0.1")
    assert status == 2
    assert "1" in err


def test_options_of_python_are_checked() -> None:
    with pytest.raises(InputError, match="actuated = 'hip' is one text; a list is needed"):
        ReadOptions(actuated="hip")
    with pytest.raises(InputError, match="no kind of closure"):
        ReadOptions(loop={"a": "H"})


# --- xacro ----------------------------------------------------------------------------------------

HEAD = "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>"
MACROS = f"""{HEAD}<xacro:arg name="reach" default="2"/>
<xacro:property name="half" value="${{pi / 2}}"/>
<xacro:macro name="bar" params="name parent at turn"><link name="${{name}}"/>
<joint name="j_${{name}}" type="continuous">
<parent link="${{parent}}"/><child link="${{name}}"/><origin xyz="${{at}}" rpy="0 0 ${{turn}}"/>
<axis xyz="0 0 1"/></joint></xacro:macro>
<link name="ground"/><xacro:bar name="crank" parent="ground" at="0 0 0" turn="0"/>
<xacro:bar name="$(arg name)" parent="crank" at="$(arg reach) 0 0" turn="${{half}}"/></robot>"""


def in_file(folder: Path, text: str, name: str = "m.xacro") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", ["m.xacro", "m.urdf.xacro", "m.urdf"])
def test_macros_are_expanded_with_arguments(name: str, tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    path = in_file(tmp_path, MACROS, name)
    robot = read_urdf(path, ReadOptions(arguments={"name": "rod", "reach": "3"}))
    assert set(robot.links) == {"base", "crank", "rod"}
    np.testing.assert_allclose(robot.links["rod"].position, [3, 0, 0], atol=1e-15)
    np.testing.assert_allclose(robot.links["rod"].rotation[:, 0], [0, 1, 0], atol=1e-15)


def test_files_of_packages_are_found_where_they_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("xacro")
    package = tmp_path / "elsewhere" / "parts"
    package.mkdir(parents=True)
    (package / "bar.xacro").write_text(MACROS.replace("$(arg name)", "rod"), encoding="utf-8")
    path = in_file(tmp_path, f'{HEAD}<xacro:include filename="$(find parts)/bar.xacro"/></robot>')
    for folder in (package, package.parent):
        status, out, _ = run(capsys, "show", str(path), "--packages", str(folder))
        assert status == 0
        assert "rod" in out
    status, _, err = run(capsys, "show", str(path))
    assert status == 2
    assert (
        "the package 'parts' of $(find parts) is not found; name the folder that holds it by "
        "packages (--packages)" in err
    )


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            MACROS,
            r"its argument 'name' is not told and has no default; give arguments \(--arguments "
            r"name=VALUE\)",
        ),
        pytest.param(
            f"{HEAD}<link name='${{1 / 0}}'/></robot>", "xacro: .*division", marks=pytest.mark.long
        ),
        pytest.param(
            f"{HEAD}<link name='${{nothing}}'/></robot>", "xacro: .*nothing", marks=pytest.mark.long
        ),
        (f"{HEAD}<link name='${{().__class__}}'/></robot>", "xacro: .*__class__"),
        (f"{HEAD}<xacro:include filename='none.xacro'/></robot>", "xacro: .*none.xacro"),
        (
            f"{HEAD}<xacro:include filename='m.xacro'/></robot>",
            "xacro: its macros or includes call themselves",
        ),
        pytest.param(
            f"{HEAD}<xacro:macro name='m'><xacro:m/></xacro:macro><xacro:m/></robot>",
            "xacro: its macros or includes call themselves",
            marks=pytest.mark.long,
        ),
        (f"{HEAD}<xacro:unknown/></robot>", "xacro: .*unknown"),
        (
            f"{HEAD}<xacro:property name='a' value='nan'/><link name='a'/><link name='b'/><joint "
            f"name='j' type='revolute'>"
            "<parent link='a'/><child link='b'/><axis xyz='0 0 ${a}'/></joint></robot>",
            r"expanded\): line \d+: <axis>: .*not a finite number",
        ),
        (
            '<!DOCTYPE r [<!ENTITY a "b">]><robot name="${1}">&a;</robot>',
            "document types and entities are not read",
        ),
    ],
)
def test_mistakes_in_xacro_are_one_sentence(text: str, sentence: str, tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    path = in_file(tmp_path, text)
    with pytest.raises(SymkinError, match=sentence) as error:
        load(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_an_argument_that_the_file_has_not_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    with pytest.raises(
        InputError,
        match=(
            r"arguments: .* has no argument 'reech' \(do you mean 'reach'\?\); its arguments: "
            r"name, reach"
        ),
    ):
        load(in_file(tmp_path, MACROS), ReadOptions(arguments={"name": "rod", "reech": "3"}))


def test_entities_in_an_included_file_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    in_file(tmp_path, '<!DOCTYPE r [<!ENTITY a "ha">]><robot>&a;</robot>', "inner.xacro")
    path = in_file(tmp_path, f"{HEAD}<xacro:include filename='inner.xacro'/></robot>")
    with pytest.raises(SymkinError, match=r"inner\.xacro: line 1: <!DOCTYPE>: document types"):
        load(path)


def test_without_the_package_one_sentence_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(
        InputError, match=r"m\.xacro: is written in xacro.*pip install 'symkin\[urdf\]'"
    ):
        load(in_file(tmp_path, MACROS))


def test_models_of_sdf_are_included_from_packages(tmp_path: Path) -> None:
    models = tmp_path / "library" / "arm"
    models.mkdir(parents=True)
    (models / "model.sdf").write_text(
        "<sdf version='1.8'><model name='arm'><link name='p'/></model></sdf>", encoding="utf-8"
    )
    text = (
        "<sdf version='1.8'><model name='m'><link "
        "name='hub'/><include><uri>model://arm</uri></include>"
        + (
            "<joint name='k' type='revolute'><parent>hub</parent><child>arm::p</child><axis><xyz>0 "
            "0 1</xyz></axis></joint></model></sdf>"
        )
    )
    path = in_file(tmp_path, text, "m.sdf")
    for folder in (models.parent, models):
        assert "arm/p" in read_sdf(path, ReadOptions(packages=[folder])).links
    with pytest.raises(
        InputError, match=r"is not found beside the file, .* or in a folder of packages"
    ):
        read_sdf(path)


def test_loops_beside_a_file_in_xacro_are_those_of_its_name(tmp_path: Path) -> None:
    """leg.yaml tells the loops of leg.urdf.xacro, as of leg.urdf."""
    pytest.importorskip("xacro")
    inside = TREE.replace('"1 0 0"', '"${2 - 1} 0 0"') + PAIR
    path = in_file(tmp_path, f"{HEAD}{inside}</robot>", "leg.urdf.xacro")
    (tmp_path / "leg.yaml").write_text("closed_loop: [[d1, d2]]\ntype: [3d]\n", encoding="utf-8")
    (closure,) = read_urdf(path).closures
    assert (closure.joint.type, closure.links) == ("S", ("rod", "rocker"))


def test_files_in_xacro_are_read_by_many_threads_at_once(tmp_path: Path) -> None:
    """Each thread gets the robot of its own arguments."""
    pytest.importorskip("xacro")
    path = in_file(tmp_path, MACROS)

    def reach(k: int) -> float:
        return float(
            read_urdf(path, ReadOptions(arguments={"name": f"rod{k}", "reach": str(k)}))
            .links[f"rod{k}"]
            .position[0]
        )

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(reach, range(1, 5))) == [float(k) for k in range(1, 5)]


def test_nothing_is_printed_beside_the_answer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """xacro's warnings, as of a property told anew, stay away from the terminal."""
    pytest.importorskip("xacro")
    told = (
        "<xacro:property name='pi' value='3'/><xacro:property name='said' "
        "value=\"${xacro.message('hello')}\"/><xacro:property name='half' value='2'/>"
    )
    read_urdf(
        in_file(tmp_path, MACROS.replace('<link name="ground"/>', f'{told}<link name="ground"/>')),
        ReadOptions(arguments={"name": "rod"}),
    )
    assert capsys.readouterr() == ("", "")
