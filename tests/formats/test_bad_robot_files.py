"""Files of robots that are wrong, in every format, on the command line: exit status 2, one sentence
with file, line and element where there is one, quickly, and nothing on disk is replaced.
"""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from helpers.command_line import run
from helpers.gate import each_once
from symkin import ReadOptions

SUFFIXES = ("urdf", "sdf", "xml")
GOOD = {
    "urdf": """<robot name='r'>
<link name='a'/><link name='b'/><link name='c'/>
<joint name='j' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/></joint>
<joint name='k' type='revolute'><parent link='a'/><child link='c'/><axis xyz='0 1 0'/></joint>
</robot>""",
    "sdf": """<sdf version='1.9'><model name='r'>
<link name='a'/><link name='b'/><link name='c'/>
<joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis>
</joint>
<joint name='k' type='revolute'><parent>a</parent><child>c</child><axis><xyz>0 1 0</xyz></axis>
</joint>
</model></sdf>""",
    "xml": """<mujoco model='r'><worldbody>
<body name='b'><joint name='j' axis='0 0 1'/></body>
<body name='c'><joint name='k' axis='0 1 0'/></body>
</worldbody>
</mujoco>""",
}
END = {"urdf": "</robot>", "sdf": "</model></sdf>", "xml": "</mujoco>"}
BOMB = "<!DOCTYPE r [<!ENTITY a 'ha'>" + "".join(
    f"<!ENTITY {chr(98 + k)} '{f'&{chr(97 + k)};' * 10}'>" for k in range(8)
)
EVERYWHERE = {
    "broken XML": (lambda text, _: text.replace("</", "<", 1), "not XML"),
    "another root": (
        lambda text, _: text.replace(text.split()[0], "<page", 1).replace(
            text.rpartition("</")[2], "page>"
        ),
        "line 1: <page",
    ),
    "entity bomb": (
        lambda text, _: BOMB + "]>" + text,
        "line 1: <!DOCTYPE>: document types and entities are not read",
    ),
    "10 MB": (lambda text, _: text + " " * 10_000_000, "the file has more than 8 MB"),
    "empty": (lambda *_: "", "the file is empty"),
    "no text": (lambda *_: "\0\1\2", "line 1: not XML"),
    "NaN": (lambda text, _: text.replace("0 0 1", "0 nan 1"), "line {line}"),
    "infinite": (lambda text, _: text.replace("0 0 1", "0 inf 1"), "line {line}"),
    "zero axis": (lambda text, _: text.replace("0 0 1", "0 0 0"), "line {line}"),
    "two numbers": (lambda text, _: text.replace("0 0 1", "0 1"), "line {line}"),
    "too deep": (
        lambda text, s: text.replace(END[s], "<x>" * 300 + "</x>" * 300 + END[s]),
        "more than 200 within each other",
    ),
}
MESH = {
    "urdf": (
        "<link name='b'><visual><geometry><mesh filename='x.stl' scale='0 1 "
        "1'/></geometry></visual></link>"
    ),
    "sdf": (
        "<link name='b'><visual name='v'><geometry><mesh><uri>x.stl</uri><scale>0 1 "
        "1</scale></mesh></geometry></visual></link>"
    ),
    "xml": "<body name='b'><geom type='mesh' mesh='m'/>",
}
SDF_JOINT = (
    "<joint name='l' type='revolute'><parent>b</parent><child>zz</child><axis><xyz>0 0 "
    "1</xyz></axis></joint>"
)
LOOP = (
    "<loop_joint name='l' type='revolute'><axis xyz='0 0 1'/><link1 link='b'/>\n"
    "<link2 link='zz'/></loop_joint>"
)
# suffix, what is replaced, by what (of <end>: what is added), what is said
ONE_FORMAT = {
    "links of one name, URDF": (
        "urdf",
        "end",
        "<link name='b'/>",
        "line 5: <link name='b'>: two links are named 'b'",
    ),
    "links of one name, SDF": (
        "sdf",
        "end",
        "<link name='b'/>",
        "line 7: <link name='b'>: the name 'b' is taken",
    ),
    "links of one name, MJCF": (
        "xml",
        "name='c'",
        "name='b'",
        "repeated name 'b' in body Element 'body', line 3",
    ),
    "unknown link, URDF": (
        "urdf",
        "end",
        LOOP,
        "line 6: <link2 link='zz'>: the link 'zz' is unknown",
    ),
    "unknown link, SDF": ("sdf", "end", SDF_JOINT, "line 7: <child>: the frame 'zz' is unknown"),
    "unknown link, MJCF": (
        "xml",
        "end",
        "<equality><connect body1='b' body2='zz' anchor='0 0 0'/></equality>",
        "unknown element 'zz'",
    ),
    "no axis, URDF": (
        "urdf",
        "<axis xyz='0 0 1'/>",
        "",
        "line 3: <joint name='j'>: <axis> is missing",
    ),
    "no axis, SDF": (
        "sdf",
        "<axis><xyz>0 0 1</xyz></axis>",
        "",
        "line 3: <joint name='j'>: <axis> is missing",
    ),
    "mimic of itself, URDF": (
        "urdf",
        "<axis xyz='0 0 1'/>",
        "<axis xyz='0 0 1'/><mimic joint='j'/>",
        "line 3: <mimic joint='j'>: the joint 'j' mimics itself",
    ),
    "mimic of itself, SDF": (
        "sdf",
        "1</xyz>",
        "1</xyz><mimic joint='j'><multiplier>1</multiplier></mimic>",
        "line 3: <mimic joint='j'>: the joint mimics itself",
    ),
    "mimic of itself, MJCF": (
        "xml",
        "end",
        "<equality><joint joint1='j' joint2='j'/></equality>",
        "'j' is repeated in equality constraint",
    ),
    "circle, URDF": ("urdf", "<axis", "<mimic joint='{other}'/><axis", "in a circle: j, k"),
    "circle, SDF": (
        "sdf",
        "</xyz>",
        "</xyz><mimic joint='{other}'><multiplier>2</multiplier></mimic>",
        "<mimic joint='j'>: the joints mimic each other in a circle: j, k",
    ),
    "circle, MJCF": (
        "xml",
        "end",
        "<equality><joint joint1='j' joint2='k'/>\n"
        "<joint joint1='k' joint2='j' polycoef='0 2 0 0 0'/></equality>",
        "line 6: <joint>: it and other couplings hold the joint 'k' at 0;",
    ),
    "missing include, SDF": (
        "sdf",
        "end",
        "<include><uri>model://none</uri></include>",
        "line 7: <include>: the included model 'model://none' is not found",
    ),
    "missing include, MJCF": (
        "xml",
        "end",
        "<include file='none.xml'/>",
        "Error opening file 'none.xml' Element 'include', line 5",
    ),
    "includes itself, SDF": (
        "sdf",
        "end",
        "<include><uri>r.sdf</uri></include>",
        "line 7: <include>: 'r.sdf' includes itself",
    ),
    "includes itself, MJCF": (
        "xml",
        "end",
        "<include file='r.xml'/>",
        "already included Element 'include', line 5",
    ),
    "mesh of no size, URDF": (
        "urdf",
        "<link name='b'/>",
        MESH["urdf"],
        "line 2: <mesh>: scale = [0.0, 1.0, 1.0] makes nothing of the mesh",
    ),
    "mesh of no size, SDF": (
        "sdf",
        "<link name='b'/>",
        MESH["sdf"],
        "line 2: <mesh>: scale = [0.0, 1.0, 1.0] makes nothing of the mesh",
    ),
    "spatial tendon": (
        "xml",
        "end",
        "<tendon><spatial name='t'><site site='s'/><site site='u'/></spatial></tendon><equality>\n"
        "<tendon tendon1='t'/></equality>",
        "line 6: <tendon>: its tendon 't' is a spatial one",
    ),
    "distance": (
        "xml",
        "end",
        "<equality>\n<distance geom1='g' geom2='h'/></equality>",
        "unrecognized element Element 'distance', line 6",
    ),
}


def refused(path: Path, capsys: pytest.CaptureFixture[str], command: str, *options: object) -> str:
    """The one sentence with which a command refuses a file."""
    begin = time.perf_counter()
    status, out, err = run(capsys, command, path, *options)
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert path.name in err
    assert time.perf_counter() - begin < 5.0
    return err


@pytest.mark.parametrize(("what", "suffix"), each_once(EVERYWHERE, SUFFIXES))
def test_what_can_be_wrong_in_every_format(
    what: str, suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if suffix == "xml":
        pytest.importorskip("mujoco")
    spoil, sentence = EVERYWHERE[what]
    path = tmp_path / f"r.{suffix}"
    path.write_text(spoil(GOOD[suffix], suffix), encoding="utf-8")
    line = 2 if suffix == "xml" else 3
    for command in ("show", "close"):
        assert sentence.format(line=line) in refused(path, capsys, command)


@pytest.mark.parametrize("what", ONE_FORMAT)
def test_what_can_be_wrong_in_one_format(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    suffix, old, new, sentence = ONE_FORMAT[what]
    if suffix == "xml":
        pytest.importorskip("mujoco")
    text = GOOD[suffix]
    if old == "end":
        text = text.replace(END[suffix], new + END[suffix])
    elif "{other}" in new:
        lines = [
            line.replace(old, new.format(other="k" if "name='j'" in line else "j"))
            for line in text.splitlines()
        ]
        text = "\n".join(lines)
    else:
        text = text.replace(old, new, 1)
    if what == "spatial tendon":
        text = text.replace(
            "<joint name='j'", "<site name='s' pos='1 0 0'/><joint name='j'"
        ).replace("<joint name='k'", "<site name='u'/><joint name='k'")
    path = tmp_path / f"r.{suffix}"
    path.write_text(text, encoding="utf-8")
    for command in ("show", "close"):
        assert sentence in refused(path, capsys, command)


@pytest.mark.parametrize(
    "element",
    [
        "<flexcomp name='f' type='grid' count='3 3 1' spacing='.1 .1 .1' radius='.01' "
        "mass='1'><edge equality='true'/></flexcomp>"
    ],
)
def test_flexes_are_named_by_the_element_that_makes_their_constraint(
    element: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "r.xml"
    path.write_text(GOOD["xml"].replace("</worldbody>", f"{element}</worldbody>"), encoding="utf-8")
    assert "line 4: <flexcomp name='f'>: flex constraints are not kinematics of links" in refused(
        path, capsys, "show"
    )


def test_constraints_of_included_files_are_named_with_their_own_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mujoco")
    (tmp_path / "loops.xml").write_text(
        "<mujoco>\n<equality>\n\n"
        "<joint joint1='k' joint2='j' polycoef='0 2 0 0 0'/></equality></mujoco>",
        encoding="utf-8",
    )
    path = tmp_path / "r.xml"
    first = "<equality><joint joint1='j' joint2='k'/></equality>\n<include file='loops.xml'/>"
    path.write_text(GOOD["xml"].replace("</mujoco>", f"{first}</mujoco>"), encoding="utf-8")
    assert "loops.xml: line 4: <joint>: it " in refused(path, capsys, "show")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_that_is_not_there_and_one_that_is_a_folder(
    suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "there is no such file" in refused(tmp_path / f"none.{suffix}", capsys, "show")
    (tmp_path / f"folder.{suffix}").mkdir()
    assert "the file cannot be read" in refused(tmp_path / f"folder.{suffix}", capsys, "show")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_nothing_on_disk_is_replaced_by_what_is_refused(
    suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if suffix == "xml":
        pytest.importorskip("mujoco")
    path, output = tmp_path / f"r.{suffix}", tmp_path / "kept.toml"
    path.write_text(GOOD[suffix].replace("0 0 1", "0 nan 1"), encoding="utf-8")
    output.write_text("kept", encoding="utf-8")
    before = path.read_text(encoding="utf-8")
    for command in ("close", "convert"):
        refused(path, capsys, command, "-o", output)
    assert output.read_text(encoding="utf-8") == "kept"
    assert path.read_text(encoding="utf-8") == before
    assert {p.name for p in tmp_path.iterdir()} == {path.name, output.name}


def test_the_good_files_are_good(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What the others spoil is read, with nothing told beside it."""
    pytest.importorskip("mujoco")
    for suffix in SUFFIXES:
        path = tmp_path / f"r.{suffix}"
        path.write_text(GOOD[suffix], encoding="utf-8")
        assert run(capsys, "close", path)[0] == 0
    assert ReadOptions() == ReadOptions(loop={}, packages=[])
