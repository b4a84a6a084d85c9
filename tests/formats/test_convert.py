"""The verb and the command `convert`: what is written, read again, has the same solutions; what
cannot be written replaces nothing.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.gate import each_once, in_gate
from helpers.inside import as_graph, main
from helpers.same_mechanism import assert_same
from helpers.samples import readme_five_bar

pytest.importorskip("mujoco")
FORMATS = (".xml", ".urdf", ".sdf")


@pytest.mark.parametrize("suffix", FORMATS)
def test_redundant_constraints_are_those_of_limbs_and_of_the_declared_motion(
    suffix: str, tmp_path: Path
) -> None:
    """A planar five-bar has 3 beyond its limbs' rows; where its motion is declared the joints that
    carry its platform close one more planar loop, with 3 of its own.
    """
    for motion, count in (("spatial", 3), ("planar", 6)):
        path = symkin.convert(readme_five_bar(motion), tmp_path / f"five_bar{suffix}")
        found, counted = symkin.close(path), symkin.mobility(symkin.load(path))
        assert (found.redundant, counted.redundant) == (count, count)
        assert symkin.mobility(readme_five_bar(motion)).redundant == 3


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    out, err = capsys.readouterr()
    return int(stop.value.code or 0), out, err


FEW = ["four_bar", "ankle", "slider_crank", "excavator_bucket", "parallel_gripper"]


@pytest.mark.parametrize(
    ("name", "suffix"),
    in_gate(
        product(FEW, FORMATS),
        [("four_bar", ".sdf"), ("ankle", ".urdf"), ("parallel_gripper", ".xml")],
    ),
)
def test_as_many_modes(name: str, suffix: str, tmp_path: Path) -> None:
    """At values of the actuated joints near the reference; angles are in radians and lengths in
    metres in the file.
    """
    mechanism = symkin.load(name)
    written = symkin.load(symkin.convert(mechanism, tmp_path / f"m{suffix}"))
    assert [c.name for c in written.actuated] == [c.name for c in mechanism.actuated]
    values = {c.name: c.reference[0] + (0.05 if c.is_angular else 2.0) for c in mechanism.actuated}
    kinds = {c.name: c.is_angular for c in mechanism.actuated}
    own = {
        n: math.degrees(v) if kinds[n] and mechanism.angle_unit == "deg" else v
        for n, v in values.items()
    }
    metres = {
        n: v if kinds[n] or mechanism.length_unit == "m" else 1e-3 * v for n, v in values.items()
    }
    before, after = symkin.modes(mechanism, given=own), symkin.modes(written, given=metres)
    assert len(after) == len(before) > 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    in_gate(["spherical_wrist", "zhang2009", "zhao2000", "delta_parallelograms"], ["zhao2000"]),
)
def test_as_many_modes_of_limbs(name: str, tmp_path: Path) -> None:
    """Limbs are joints and rods between links in the file, a restricted platform hangs on joints of
    its own.
    """
    test_as_many_modes(name, ".xml", tmp_path)


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_bytes_every_time(suffix: str, tmp_path: Path) -> None:
    first, second = (
        symkin.convert("ankle", tmp_path / f"{name}{suffix}").read_bytes() for name in ("a", "b")
    )
    assert first == second


@pytest.mark.parametrize("suffix", FORMATS)
def test_written_twice_is_written_once(suffix: str, tmp_path: Path) -> None:
    """A file that is read and written again in its own format is the same text, but for where it
    came from.
    """
    first = symkin.convert("double_wishbone", tmp_path / f"a{suffix}")
    second = symkin.convert(first, tmp_path / f"b{suffix}")
    assert_same(symkin.load(first), symkin.load(second))


def test_a_robot_as_a_mechanism_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The file that `close -o` writes."""
    robot = symkin.convert("parallel_gripper", tmp_path / "gripper.xml")
    output, closed = tmp_path / "gripper.toml", tmp_path / "closed.toml"
    assert run(capsys, "convert", str(robot), "-o", str(output)) == (0, f"written: {output}\n", "")
    assert run(capsys, "close", str(robot), "-o", str(closed))[0] == 0
    assert output.read_bytes() == closed.read_bytes()
    assert_same(as_graph(symkin.load("parallel_gripper")), symkin.load(output))


def test_wrong_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = symkin.convert("four_bar", tmp_path / "four_bar.xml")
    before = path.read_bytes()
    for arguments, sentence in [
        ((path, "-o", path), "is read by this command"),
        ((path, "-o", tmp_path / "four_bar.stl"), "another suffix than .toml, .xml, .urdf, .sdf"),
        ((path, "-o", tmp_path / "none" / "four_bar.xml"), "its folder does not exist"),
        ((path, "-o", tmp_path), "another suffix"),
        ((tmp_path / "none.xml", "-o", tmp_path / "out.toml"), "there is no such file"),
        (("four_ba", "-o", tmp_path / "out.toml"), "is unknown"),
        ((path,), "-o FILE is missing"),
    ]:
        status, out, err = run(capsys, "convert", *map(str, arguments))
        assert (status, out, err.count("\n")) == (2, "", 1), arguments
        assert sentence in err
    link = tmp_path / "link.xml"
    link.symlink_to(path)
    assert "is read by this command" in run(capsys, "convert", str(path), "-o", str(link))[2]
    assert path.read_bytes() == before
    assert {p.name for p in tmp_path.iterdir()} == {"four_bar.xml", "link.xml"}


def test_what_no_format_holds(tmp_path: Path) -> None:
    """Loops that nothing closes, a weld that joins two links alone, a link with the name of the
    base of MJCF.
    """
    joint = symkin.LinkJoint(
        symkin.Joint("q", "R", [0, 0, 0], [0, 0, 1], actuated=True), ["base", "arm"]
    )
    other = symkin.LinkJoint(symkin.Joint("p", "R", [9, 0, 0], [0, 0, 1]), ["base", "lever"])
    rod = symkin.LinkRod("rod", ["arm", "lever"], [1, 0, 0], [9, 1, 0], length=12.0)
    weld = symkin.LinkJoint(symkin.Joint("w", "weld", [1, 0, 0]), ["arm", "world"])
    turned = symkin.LinkJoint(symkin.Joint("r", "R", [1, 0, 0], [0, 1, 0]), ["arm", "world"])
    for parts, sentence in [
        (
            {"link_joints": [joint, other], "link_rods": [rod]},
            "no closed configuration was found, .* leaves 1",
        ),
        ({"link_joints": [joint, weld]}, "the weld 'w' alone joins the links 'arm' and 'world'"),
        ({"link_joints": [joint, turned]}, "a link is named 'world'"),
    ]:
        with pytest.raises(symkin.MechanismError, match=sentence):
            symkin.convert(symkin.Mechanism("m", **parts), tmp_path / "m.xml")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("ankle = U: ", "ankle is U ", "is no statement on joints in parts"),
        (
            "ankle = U: ankle.1",
            "ankle = U: shank",
            "names the joint 'shank', which the file has not",
        ),
        ("ankle = U: ankle.1, ankle.2", "ankle = U: ankle.2, lower_motor", "no chain of joints"),
        ("ankle = U", "ankle = C", "make no C"),
        ("ankle = U", "ankle = H x", "holds no finite number"),
        ("actuated: ", "actuated: nobody, ", "names the joint 'nobody'"),
        ("platform: foot | ", "platform: foot | x | ", "is no LINK | X | Y"),
        ("platform: foot | ", "platform: shank | ", "platform.link = 'shank' is unknown"),
        ("points: toe | foot | ", "points: toe | ", "is no NAME | LINK | X"),
        (
            "upper_rod = rod: upper_rod.from, upper_rod.to",
            "upper_rod = rod: upper_rod.from",
            "make no rod",
        ),
    ],
)
def test_parts_that_no_longer_fit(old: str, new: str, sentence: str, tmp_path: Path) -> None:
    """A file that was edited after it was written."""
    path = symkin.convert("ankle", tmp_path / "ankle.xml")
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(symkin.MechanismError, match=sentence) as error:
        symkin.load(path)
    assert "ankle.xml" in str(error.value)


def test_without_the_text_parts_are_joints_of_their_own(tmp_path: Path) -> None:
    """The text is what makes rods and universal joints whole: other readers see hinges and
    balls.
    """
    path = symkin.convert("ankle", tmp_path / "ankle.xml")
    lines = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join(line for line in lines if "<text " not in line), encoding="utf-8")
    plain = symkin.load(path)
    assert {e.joint.name for e in plain.link_joints} >= {
        "ankle.1",
        "ankle.2",
        "upper_rod.from",
        "upper_rod.to",
    }
    assert not plain.link_rods


@pytest.mark.parametrize(("name", "suffix"), each_once(["bricard", "zhang2009", "ankle"], FORMATS))
def test_motors_are_those_of_the_mechanism(name: str, suffix: str, tmp_path: Path) -> None:
    """What moves and no motor drives is not taken for driven, though nothing else tells motors; and
    motors may be told beside it.
    """
    mechanism = symkin.load(name)
    joints = [replace(e, joint=replace(e.joint, actuated=False)) for e in mechanism.link_joints]
    idle = replace(
        mechanism, link_joints=joints, link_rods=[r for r in mechanism.link_rods if not r.actuated]
    )
    path = symkin.convert(idle, tmp_path / f"m{suffix}")
    expected = [c.name for c in idle.actuated]
    assert [c.name for c in symkin.load(path).actuated] == expected
    assert sorted(symkin.close(path).actuated) == sorted(expected)
    assert not any("no motors are told" in note for note in symkin.close(path).notes)
    first = next((e.joint.name for e in idle.link_joints if e.joint.type == "R"), None)
    if first is not None:
        assert [
            c.name for c in symkin.load(path, symkin.ReadOptions(actuated=[first])).actuated
        ] == [first]


@pytest.mark.parametrize("suffix", [".toml", *FORMATS])
def test_an_open_reference_is_closed(suffix: str, tmp_path: Path) -> None:
    """A rod of 9 mm whose ends are 8.06 mm apart at the reference: in the file it has its length,
    and the joints the values of `close`.
    """
    joint = symkin.LinkJoint(
        symkin.Joint("q", "R", [0, 0, 0], [0, 0, 1], actuated=True), ["base", "arm"]
    )
    other = symkin.LinkJoint(
        symkin.Joint("p", "R", [9, 0, 0], [0, 0, 1], zero=0.3), ["base", "lever"]
    )
    rod = symkin.LinkRod("rod", ["arm", "lever"], [1, 0, 0], [9, 1, 0], length=9.0)
    mechanism = symkin.Mechanism("open", link_joints=[joint, other], link_rods=[rod])
    metres = 1.0 if suffix == ".toml" else 1e-3
    written = symkin.load(symkin.convert(mechanism, tmp_path / f"m{suffix}"))
    assert written.link_rods[0].reference_length == pytest.approx(9.0 * metres, rel=1e-12)
    assert np.linalg.norm(written.link_rods[0].start) == pytest.approx(metres, rel=1e-12)
    found = symkin.close(mechanism)
    assert found.reference is not None
    for entry in written.link_joints:
        assert entry.joint.zero == pytest.approx(found.joints[entry.joint.name], abs=1e-12)


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_tool_stands_where_it_stood(suffix: str, tmp_path: Path) -> None:
    """The platform frame comes back: the pose of an arm for the same joint values, in metres."""
    mechanism = symkin.load("gluon_6l3")
    written = symkin.load(symkin.convert(mechanism, tmp_path / f"arm{suffix}"))
    values = [10.0, -20.0, 30.0, 40.0, -50.0, 60.0]
    before = symkin.solve(mechanism, joints=values).solution
    after = symkin.solve(written, joints=[math.radians(v) for v in values]).solution
    np.testing.assert_allclose(after.position, 1e-3 * np.asarray(before.position), atol=1e-10)
    assert (
        min(
            np.abs(after.quaternion - sign * np.asarray(before.quaternion)).max()
            for sign in (1, -1)
        )
        <= 1e-10
    )


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("unit", ["mm", "m"])
def test_rods_keep_the_lengths_that_they_are_told(suffix: str, unit: str, tmp_path: Path) -> None:
    """A rod whose length the file states has it stated again; one that takes its length from the
    reference goes on to do so.
    """
    links = ["base", "coupler"]
    turning = symkin.LinkJoint(symkin.Joint("ball", "S", (0, 0, 0)), links)
    rods = [
        symkin.LinkRod("stated", links, (3, 0, 0), (3, 4, 12), length=math.hypot(4, 12)),
        symkin.LinkRod("measured", links, (0, 3, 0), (4, 3, 3)),
        symkin.LinkRod("driven", links, (0, 0, 3), (1, 2, 5), actuated=True, offset=0.75),
    ]
    mechanism = symkin.Mechanism("rods", link_joints=[turning], link_rods=rods, length_unit=unit)
    written = symkin.load(symkin.convert(mechanism, tmp_path / f"m{suffix}"))
    scale = 1e-3 if unit == "mm" else 1.0
    found = {rod.name: rod for rod in written.link_rods}
    assert found["stated"].length == pytest.approx(scale * math.hypot(4, 12), rel=1e-12)
    assert found["measured"].length is None
    assert found["driven"].offset == pytest.approx(scale * 0.75, rel=1e-12)
