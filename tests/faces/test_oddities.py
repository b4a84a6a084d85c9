"""Numbers that are allowed and rarely meant, values that nothing reaches, and files of more parts
than any machine has.
"""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run, run_json
from helpers.gate import in_gate
from helpers.graph_twin import graph_twin
from helpers.inside import MOST_PARTS, oddities, parse
from helpers.shipped import TWELVE

HEXAPOD = symkin.load("zhang2009")


def _with_leg(**changes: object) -> symkin.Mechanism:
    first, *others = HEXAPOD.limbs
    return dataclasses.replace(HEXAPOD, limbs=[dataclasses.replace(first, **changes), *others])  # type: ignore[type-var]


@pytest.mark.parametrize("name", in_gate(symkin.shipped_names(), TWELVE))
def test_shipped_mechanisms_are_not_odd(name: str) -> None:
    """No note on any of them."""
    assert oddities(symkin.load(name)) == ()


def test_rods_of_negative_lengths() -> None:
    """Limits below zero beyond an offset: noted; with an offset that makes them lengths: not."""
    assert (
        "limb leg1 (limits -400 to -100 beyond offset 0): all lengths"
        in oddities(_with_leg(limits=(-400.0, -100.0)))[0]
    )
    assert oddities(_with_leg(limits=(-400.0, -100.0), offset=500.0)) == ()


@pytest.mark.parametrize("key", ["base", "platform"])
def test_a_point_far_off(key: str) -> None:
    """A point in micrometres among millimetres is named; the shipped one with all points a thousand
    times as far is not odd.
    """
    point = np.array(getattr(HEXAPOD.limbs[0], key))
    assert f"leg1.{key} lies" in oddities(_with_leg(**{key: tuple(1000.0 * point)}))[0]
    scaled = [
        dataclasses.replace(
            limb,
            base=tuple(1e3 * np.array(limb.base)),
            platform=tuple(1e3 * np.array(limb.platform)),
        )
        for limb in HEXAPOD.limbs
    ]  # type: ignore[type-var, union-attr]
    assert oddities(dataclasses.replace(HEXAPOD, limbs=scaled)) == ()


def test_ends_of_rods_between_links_are_looked_at_too() -> None:
    """The hexapod as a graph of links: the same end, a thousand times as far, is named."""
    legs = list(graph_twin(HEXAPOD).link_rods)
    legs[0] = dataclasses.replace(legs[0], start=tuple(1000.0 * np.array(legs[0].start)))
    odd = oddities(dataclasses.replace(graph_twin(HEXAPOD), link_rods=legs))
    assert "leg1.from lies" in odd[0]
    assert oddities(graph_twin(HEXAPOD)) == ()


def test_degrees_in_a_file_of_radians(capsys: pytest.CaptureFixture[str], tmp_path: object) -> None:
    """`angle_unit = "rad"` beside 90 and 210: every command says so on stderr, JSON stays alone on
    stdout.
    """
    file = f"{tmp_path}/m.toml"
    with open(file, "w", encoding="utf-8") as out:
        out.write(
            symkin.load("zhao2000").to_toml().replace('angle_unit = "deg"', 'angle_unit = "rad"')
        )
    for command in ("show", "solve"):
        _, out, err = run(capsys, command, file, "--json")
        assert out.startswith("{")
        assert err.count("\n") == 1
        assert "theta1.zero = 90" in err
        assert "are degrees meant?" in err


def test_joint_values_in_degrees_where_radians_are_read(capsys: pytest.CaptureFixture[str]) -> None:
    """Joints of more than a turn are taken without whole turns, and a note asks; one turn is no
    reason.
    """
    arm = symkin.load("ur5e")
    told = dataclasses.replace(arm, angle_unit="rad")
    assert any(
        "q1 = 90 rad: more than a turn" in note or "90 rad" in note
        for note in symkin.solve(told, joints=[90, 0, 0, 0, 0, 0]).notes
    )
    assert (
        symkin.solve(told, joints=[6.28, 0, 0, 0, 0, 0]).notes
        == symkin.solve(told, joints=[0, 0, 0, 0, 0, 0]).notes
    )
    assert not any(
        "rad" in note
        for note in run_json(capsys, "solve", "ur5e", "--joints", "400,0,0,0,0,0")[1]["notes"]
    )


def test_the_limb_that_cannot_reach_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    """A delta's pose beside one arm's reach names that limb and no other: those whose closest
    distance to the pose's rods is more than upper and lower arm together; `modes` and `solve`
    alike.
    """
    status, data = run_json(capsys, "modes", "delta", "--pose", "0,0,-900")
    assert status == 3
    assert any("none of the limbs can reach this pose" in note for note in data["notes"])
    delta = symkin.load("delta")
    short = dataclasses.replace(delta, limbs=[_shortened(delta.limbs[0]), *delta.limbs[1:]])
    pose = [0.0, 0.0, -250.0, 1.0, 0.0, 0.0, 0.0]
    assert len(symkin.modes(delta, pose=pose)) == 8
    for found in (symkin.modes(short, pose=pose), symkin.solve(short, pose=pose, check=False)):
        assert any(
            f"limb {delta.limbs[0].name} cannot reach this pose" in note for note in found.notes
        ), found.notes


def _shortened(limb: symkin.Limb) -> symkin.Limb:
    return dataclasses.replace(
        limb, rods=[dataclasses.replace(rod, length=60.0) for rod in limb.rods]
    )


def test_what_stays_open_most_is_named() -> None:
    """Of six legs one is given far too long: it is named for joints, the arm for a pose out of its
    reach, and nothing for values that have a solution.
    """
    joints = [100.0, 2000.0, 100.0, 100.0, 100.0, 100.0]
    for found in (
        symkin.modes(HEXAPOD, joints=joints),
        symkin.solve(HEXAPOD, joints=joints, check=False),
    ):
        assert "what stays open most is leg2" in found.notes[-1]
    far = symkin.modes(symkin.load("ur5e"), pose=[5e3, 5e3, 5e3, 1, 0, 0, 0])
    assert "the arm cannot reach this pose" in far.notes[-1]
    assert not any("open most" in note for note in symkin.modes(HEXAPOD).notes)


def test_too_many_parts_are_refused(capsys: pytest.CaptureFixture[str], tmp_path: object) -> None:
    """5,000 limbs: one sentence with their number, in seconds."""
    legs = "".join(
        f'[[limb]]\nname="l{k}"\ntype="SPS"\nbase=[{k},0,0]\nplatform=[0,{k},1]\n'
        for k in range(5000)
    )
    file = f"{tmp_path}/big.toml"
    with open(file, "w", encoding="utf-8") as out:
        out.write(f'format = 1\nname = "big"\nlength_unit = "mm"\nangle_unit = "deg"\n{legs}')
    status, _, err = run(capsys, "show", file)
    assert (status, err.count("\n")) == (2, 1)
    assert (
        f"the mechanism has 5000 limbs; allowed: {MOST_PARTS} limbs, joints and rods together"
        in err
    )


def test_limits_in_degrees_where_radians_are_read(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Limits of 22.5 in a file of radians ask, in robots' files too and in C; those within a turn,
    and those that stand for none, do not.
    """
    limit, files = '<limit lower="{0}" upper="{1}" effort="1" velocity="1"/>', {}
    for name, ends in (
        ("degrees", (-15, 22.5)),
        ("radians", (-0.26, 6.2832)),
        ("none", (-1e9, 1e9)),
    ):
        links = "".join(f'<link name="{link}"/>' for link in ("base", "a"))
        joint = (
            '<joint name="x" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 '
            '1"/>'
        )
        files[name] = tmp_path / f"{name}.urdf"
        files[name].write_text(
            f'<robot name="r">{links}{joint}{limit.format(*ends)}</joint></robot>'
        )
    for name, file in files.items():
        _, _, err = run(capsys, "solve", str(file))
        assert (
            ("x.limits = -15 to 22.5" in err)
            == ("are degrees meant?" in err)
            == (name == "degrees")
        )
    rows = 'rows = [ { type = "R", a = 200.0, limits = [-15.0, 22.5] }, { type = "R", a = 150.0 } ]'
    for unit in ("rad", "deg"):
        head = (
            f'format = 1\nname = "arm"\nlength_unit = "mm"\nangle_unit = "{unit}"\n[dh]\n'
            f'convention = "standard"\n'
        )
        symkin.write_firmware(parse(head + rows), tmp_path / unit)
        for text in ("README.md", "arm.h"):
            told = (tmp_path / unit / text).read_text().replace("\n *", "")
            assert ("are degrees meant?" in told) == (unit == "rad")


HEAD = 'format = 1\nname = "m"\nlength_unit = "mm"\nangle_unit = "deg"\n'
FOUR = HEAD + "".join(
    f'[[joint]]\nname = "{name}"\ntype = "R"\nlinks = {links}\npoint = {point}\naxis = [0, 0, 1]\n'
    for name, links, point in (
        ("a", '["base", "x"]', "[0, 0, 0]"),
        ("b", '["x", "y"]', "[0, {n}, 0]"),
        ("c", '["y", "z"]', "[{n}, {n}, 0]"),
        ("d", '["z", "base"]', "[{n}, 0, 0]"),
    )
)
GEARS = (
    FOUR.partition('[[joint]]\nname = "c"')[0] + '[[coupling]]\njoint = "b"\nof = {{ a = {n} }}\n'
)
ROD = HEAD + "".join(
    f'[[joint]]\nname = "{name}"\ntype = "S"\nlinks = ["base", "x"]\npoint = [{x}, 0, 0]\n'
    for name, x in (("s", 0), ("t", 100))
)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("verb", ["show", "close", "modes", "solve"])
@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (FOUR.format(n="1e162"), "joint 'b': point = 1e+162 is too large; at most 1e+153"),
        (GEARS.format(n="1e300").replace("0, 1e300, 0", "0, 1, 0"), "of.a = 1e+300 is too large"),
        (ROD, "m: no coordinate is left to find; a link on two S joints is a rod"),
    ],
    ids=["lengths", "factor", "a rod alone"],
)
def test_what_cannot_be_computed_is_one_sentence(
    verb: str, text: str, reason: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Numbers whose products overflow, and a machine without a coordinate: status 2, no warning."""
    (tmp_path / "m.toml").write_text(text, encoding="utf-8")
    status, _, said = run(capsys, verb, str(tmp_path / "m.toml"))
    assert status == 2
    assert reason in said


@pytest.mark.filterwarnings("error")
def test_numbers_as_large_as_are_allowed(tmp_path: Path) -> None:
    """A four-bar of 1e150 mm has the mobility of one of 100 mm."""
    (tmp_path / "m.toml").write_text(FOUR.format(n="1e150"), encoding="utf-8")
    machine = symkin.load(tmp_path / "m.toml")
    assert symkin.close(machine).mobility == symkin.close(parse(FOUR.format(n="100"))).mobility == 1
