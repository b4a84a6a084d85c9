"""XML that others wrote: what is read keeps its lines; entities, depth, size and broken text are
refused in a sentence with a line.
"""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest

from helpers.inside import (
    DEEPEST,
    LARGEST_FILE,
    allowed_names,
    name_fault,
    parse_xml,
    read_xml,
    renamed,
    robot_name,
)
from symkin import InputError, MechanismError

BOMB = b"""<?xml version="1.0"?>
<!DOCTYPE robot [<!ENTITY a "ha">
<!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]>
<robot name="&c;"/>"""


def test_elements_keep_tag_attributes_text_and_line() -> None:
    root = parse_xml(
        b"<robot name='r'>\n <link name='a'/>\n <joint\n  name='j'>0 <!-- x -->1</joint></robot>",
        "r.urdf",
        "robot",
    )
    link, joint = root.children
    assert (link.line, joint.line) == (2, 3)
    assert joint.text_numbers(2) == (0.0, 1.0)
    assert [e.tag for e in root.walk()] == ["robot", "link", "joint"]
    assert joint.where == "r.urdf: line 3: <joint name='j'>"


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", r"^r\.urdf: the file is empty; the element <robot> is needed$"),
        (b"<robot>\n<link></robot>", r"^r\.urdf: line 2: not XML: mismatched tag \(column \d+\)$"),
        (b"<robot/>\n<robot/>", r"^r\.urdf: line 2: not XML: junk after document element"),
        (b"hello", r"^r\.urdf: line 1: not XML: syntax error"),
        (b"<robot name='a' name='b'/>", r"^r\.urdf: line 1: not XML: duplicate attribute"),
        (b"<robot>&lol;</robot>", r"^r\.urdf: line 1: not XML: undefined entity"),
        (b"<?xml version='1.0' encoding='no-such'?><robot/>", r"^r\.urdf: line 1: not XML: "),
        (b"\x00\x01\x02", r"^r\.urdf: line 1: not XML: "),
        (
            b"<sdf/>",
            r"^r\.urdf: line 1: <sdf>: the file's first element is <sdf>; <robot> is needed; the "
            r"file is SDF, and its name should end in \.sdf$",
        ),
        (BOMB, r"^r\.urdf: line 2: <!DOCTYPE>: document types and entities are not read"),
        (
            b"<robot>" + b"<a>" * DEEPEST,
            rf"^r\.urdf: line 1: <a>: the elements stand more than {DEEPEST} within each other",
        ),
        (b"<robot>" + b" " * LARGEST_FILE + b"</robot>", r"^r\.urdf: the file has more than 8 MB"),
    ],
)
def test_what_is_no_description_is_refused(content: bytes, sentence: str) -> None:
    with pytest.raises(MechanismError) as refusal:
        parse_xml(content, "r.urdf", "robot")
    assert re.search(sentence, str(refusal.value)), str(refusal.value)


def test_a_declaration_behind_empty_lines_keeps_the_lines() -> None:
    root = parse_xml(b"\n\n<?xml version='1.0'?>\n<robot name='\xc3\xa4'/>", "r.urdf", "robot")
    assert (root.line, root.attributes["name"]) == (4, "\u00e4")


@pytest.mark.parametrize("text", ["nan", "1 2", "1_0", "0x1", "1,5", "inf", "", "1e400", "٣"])
def test_what_is_no_finite_number_is_refused(text: str) -> None:
    element = parse_xml(f"<robot v='{text}'/>".encode(), "r.urdf", "robot")
    with pytest.raises(MechanismError, match=r"r\.urdf: line 1: <robot>: .*v"):
        element.number("v")


def test_numbers_are_read_as_written() -> None:
    element = parse_xml(b"<robot a=' +.5 ' b='1e-3 -2.  3E2'>-inf</robot>", "r.urdf", "robot")
    assert element.number("a") == 0.5
    assert element.numbers("b", 3) == (1e-3, -2.0, 300.0)
    assert element.text_number(infinite=True) == float("-inf")
    assert element.number("c", 7.0) == 7.0
    with pytest.raises(MechanismError, match="has 3 numbers; 2 are needed"):
        element.numbers("b", 2)
    with pytest.raises(MechanismError, match="the attribute c is missing"):
        element.number("c")


def test_children_are_one_or_many() -> None:
    element = parse_xml(b"<robot><a/>\n<a name='x'/><b/></robot>", "r.urdf", "robot")
    assert [child.tag for child in element.all("a", "b")] == ["a", "a", "b"]
    assert element.needed("b") is element.one("b")
    with pytest.raises(MechanismError, match="line 2: <a name='x'>: stands twice in <robot>"):
        element.one("a")
    with pytest.raises(MechanismError, match="<robot>: <c> is missing"):
        element.needed("c")


def test_a_large_file_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "large.urdf"
    path.write_bytes(b"<robot>" + b"<link/>" * 1_500_000 + b"</robot>")
    begin = time.perf_counter()
    with pytest.raises(MechanismError, match="more than 8 MB"):
        read_xml(path, "robot")
    assert time.perf_counter() - begin < 1.0


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        read_xml(tmp_path / "none.urdf", "robot")
    with pytest.raises(InputError, match="the file cannot be read"):
        read_xml(tmp_path, "robot")


def test_names_are_kept_or_changed_to_allowed_ones_each_its_own() -> None:
    names = [
        "knee",
        "a[1]",
        "a_1_",
        "base",
        " x ",
        "",
        "-a",
        "toe a/2",
        "a\tb",
        "n" * 200,
        "n" * 201,
    ]
    found = allowed_names(names, taken=["base"])
    assert [found[name] for name in ("knee", "a_1_", "toe a/2")] == ["knee", "a_1_", "toe a/2"]
    assert len(set(found.values())) == len(names)
    assert "base" not in found.values()
    assert not [new for new in found.values() if name_fault(new)]
    assert "'a[1]' is 'a_1__2'" in renamed("links", found)[0]
    assert renamed("links", allowed_names(["knee"])) == ()


def test_a_robot_has_a_name_of_c() -> None:
    assert robot_name("5 bar-linkage", Path("a.urdf")) == "q_5_bar_linkage"
    assert robot_name(None, Path("leg.urdf")) == "leg"
    assert robot_name("con", Path("leg.urdf")) == "con_robot"
