"""SDF that is written: read again it is the same mechanism, and its joints, by the numbers of the
file alone, allow the motions that symkin finds.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import symkin
from helpers.gate import in_gate
from helpers.inside import as_graph, matrix_from_quaternion, quaternion_from_axis_angle
from helpers.random_graphs import random_graph
from helpers.robot_files import LARGEST, ROBOTS
from helpers.same_mechanism import assert_same
from helpers.shipped import TWELVE
from helpers.written_moves import Moved, configurations

COUPLED = ("differential", "planetary_gear")
"""Mechanisms with joints that follow two others."""
HELD = [name for name in symkin.shipped_names() if name not in COUPLED]
MOVED = 1e-10
"""Metres, and components of rotation matrices."""


@pytest.mark.parametrize("name", in_gate(HELD, TWELVE))
def test_shipped_mechanisms_come_back(name: str, tmp_path: Path) -> None:
    mechanism = symkin.load(name)
    assert_same(
        as_graph(mechanism), symkin.load(symkin.convert(mechanism, tmp_path / "written.sdf"))
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    in_gate(ROBOTS, [p for p in ROBOTS if p not in LARGEST][1::3]),
    ids=lambda path: path.stem,
)
def test_real_robots_come_back(path: Path, tmp_path: Path) -> None:
    if path.suffix == ".xml":
        pytest.importorskip("mujoco")
    mechanism = symkin.load(path)
    assert_same(
        as_graph(mechanism), symkin.load(symkin.convert(mechanism, tmp_path / "written.sdf"))
    )


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000))
def test_random_graphs_come_back(seed: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    mechanism = random_graph(seed, lines_only=True)
    path = tmp_path_factory.getbasetemp() / "random.sdf"
    assert_same(as_graph(mechanism), symkin.load(symkin.convert(mechanism, path)))


@pytest.mark.parametrize("name", in_gate(HELD, TWELVE))
def test_the_joints_of_the_file_allow_the_motion(name: str, tmp_path: Path) -> None:
    """At closed configurations the child of each joint stands where its parent, its screws and its
    values in the file place it.
    """
    mechanism = symkin.load(name)
    model = (
        ElementTree.parse(symkin.convert(mechanism, tmp_path / "written.sdf"))
        .getroot()
        .find("model")
    )
    places = {link.get("name"): _numbers(link.find("pose")) for link in model.iter("link")}
    zeros = {c.name: c.reference[0] for c in as_graph(mechanism).coordinates if c.width == 1}
    checked = 0
    for links, values, balls in configurations(mechanism):
        moved: Moved = (
            {**links, "world": links["base"]},
            {n: v - zeros.get(n, 0.0) for n, v in values.items()},
            balls,
        )
        for joint in model.findall("joint"):
            checked += _check(joint, places, moved)
    assert checked >= len(as_graph(mechanism).link_joints) // 2 + len(mechanism.bars)


def _check(joint: ElementTree.Element, places: dict[str, np.ndarray], moved: Moved) -> int:
    links, values, _ = moved
    parent, child = (joint.find(tag).text for tag in ("parent", "child"))
    if parent not in links or child not in links:
        return 0
    point = (places[child] + _numbers(joint.find("pose")))[:3]
    between, name = links[parent].inverse() @ links[child], joint.get("name")
    expected = np.eye(4)
    kind = joint.get("type")
    if kind == "ball":
        np.testing.assert_allclose(between.apply(point), point, atol=MOVED, err_msg=name)
        return 1
    axes = [
        _numbers(joint.find(f"{tag}/xyz"))
        for tag in ("axis", "axis2")
        if joint.find(tag) is not None
    ]
    names = [f"{name}.1", f"{name}.2"] if kind == "universal" else [name.removesuffix(".joint")]
    for axis, coordinate in zip(axes, names, strict=True):
        value = values[coordinate]
        pitch = (
            float(joint.find("screw_thread_pitch").text) / (2 * np.pi) if kind == "screw" else 0.0
        )
        step = np.eye(4)
        if kind != "prismatic":
            step[:3, :3] = matrix_from_quaternion(quaternion_from_axis_angle(axis, value))
        slide = axis * value * (1.0 if kind == "prismatic" else pitch)
        step[:3, 3] = point - step[:3, :3] @ point + slide
        expected = expected @ step
    np.testing.assert_allclose(between.position, expected[:3, 3], atol=MOVED, err_msg=name)
    np.testing.assert_allclose(between.rotation, expected[:3, :3], atol=MOVED, err_msg=name)
    for mimic in joint.iter("mimic"):
        told = {child.tag: float(child.text) for child in mimic}
        assert values[name] == pytest.approx(
            told["multiplier"] * values[mimic.get("joint")] + told["offset"], abs=MOVED
        )
    return 1


def _numbers(element: ElementTree.Element) -> np.ndarray:
    return np.array([float(word) for word in element.text.split()])


@pytest.mark.parametrize("name", HELD)
def test_names_are_unique_and_frames_known(name: str, tmp_path: Path) -> None:
    """As sdformat asks: links and joints share no name, parents and children are links or the
    world, the world is no child.
    """
    root = ElementTree.parse(symkin.convert(name, tmp_path / "written.sdf")).getroot()
    model = root.find("model")
    links, joints = ([e.get("name") for e in model.findall(tag)] for tag in ("link", "joint"))
    assert len({*links, *joints}) == len(links) + len(joints)
    assert {j.find("parent").text for j in model.findall("joint")} <= {"world", *links}
    assert {j.find("child").text for j in model.findall("joint")} <= set(links)
    assert all(plugin.find("joint_name").text in joints for plugin in model.iter("plugin"))


def test_links_and_joints_of_one_name(tmp_path: Path) -> None:
    """The joint is called otherwise in the file, in couplings and welds too, and has its name again
    when it is read.
    """
    z = [0, 0, 1]
    joints = [
        symkin.LinkJoint(
            symkin.Joint("arm", "R", [0, 0, 0], z, actuated=True, zero=0.4), ["base", "arm"]
        ),
        symkin.LinkJoint(symkin.Joint("lever", "R", [9, 0, 0], z), ["lever", "base"]),
        symkin.LinkJoint(symkin.Joint("u", "U", [9, 9, 0], z, [1, 0, 0]), ["lever", "u"]),
        symkin.LinkJoint(symkin.Joint("hand", "R", [9, 9, 0], z), ["u", "hand"]),
        symkin.LinkJoint(symkin.Joint("lock", "weld", [1, 0, 0]), ["hand", "lock"]),
        symkin.LinkJoint(symkin.Joint("again", "S", [1, 0, 0]), ["base", "lock"]),
        symkin.LinkJoint(symkin.Joint("third", "R", [1, 0, 0], z), ["base", "lock"]),
    ]
    couplings = [symkin.Coupling("lever", {"arm": -2.0}, 0.8), symkin.Coupling("u.2", {"u.1": 0.5})]
    mechanism = symkin.Mechanism("same_names", link_joints=joints, couplings=couplings)
    assert_same(as_graph(mechanism), symkin.load(symkin.convert(mechanism, tmp_path / "m.sdf")))


@pytest.mark.parametrize(("name", "what"), [("world", "link"), ("__arm__", "link")])
def test_names_that_sdf_keeps(name: str, what: str, tmp_path: Path) -> None:
    joint = symkin.LinkJoint(symkin.Joint("q", "R", [0, 0, 0], [0, 0, 1]), ["base", name])
    with pytest.raises(
        symkin.MechanismError, match=f"a {what} is named '{name}', which SDF keeps for itself"
    ):
        symkin.convert(symkin.Mechanism("m", link_joints=[joint]), tmp_path / "m.sdf")


@pytest.mark.parametrize("name", COUPLED)
def test_joints_that_follow_two_others(name: str, tmp_path: Path) -> None:
    with pytest.raises(
        symkin.MechanismError, match=r"is no line of one other joint, .*MJCF \(\.xml\) holds it"
    ):
        symkin.convert(name, tmp_path / "written.sdf")
