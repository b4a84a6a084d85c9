"""SDF: the real models against data of their own, one machine in the rules of every version, nested
models, what is wrong.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.inside import (
    Robot,
    assembled,
    mechanism_of,
    nearest_closed,
    read_sdf,
)
from helpers.robot_files import (
    MODELS,
    all_frames,
    closed_neighbours,
    closure_misfit,
    displaced,
    facts,
    joint_misfit,
    poses_at,
    rank_at,
    told_poses,
)
from oracle.product_of_exponentials import displacement
from symkin import Joint, SymkinError

KINDS = {
    "R": "revolute",
    "P": "prismatic",
    "H": "screw",
    "U": "universal",
    "S": "ball",
    "weld": "fixed",
}
NAMES = ("sdf/pr2_gripper", "sdf/minitaur")
AWAY = "0.3 -0.2 0.5 0.4 -0.3 1.1"
"""A pose of no special kind: position and roll, pitch, yaw."""


def read(folder: Path, inside: str, version: str = "1.7", name: str = "r") -> Robot:
    path = folder / f"{name}.sdf"
    path.write_text(
        f"<sdf version='{version}'><model name='{name}'>{inside}</model></sdf>", encoding="utf-8"
    )
    return read_sdf(path)


def joints_of(robot: Robot) -> dict[str, Joint]:
    return {entry.joint.name: entry.joint for entry in robot.tree}


# --- real models ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_counts_and_the_closed_configuration_are_those_of_an_independent_reader(name: str) -> None:
    data, found = facts(name), read_sdf(MODELS / f"{name}.sdf")
    assert len(found.frames) + len(data["unreached"]) == data["bodies"]
    assert len(found.closures) == data["independent_loops"]
    kinds = Counter(KINDS[joint.joint.type] for joint in found.tree)
    kinds.update(KINDS[closure.joint.type] for closure in found.closures)
    assert dict(kinds) == data["joints"]
    assert all(any(link in note for note in found.notes) for link in data["unreached"])
    told = told_poses(data, found)
    moved = {link: told[link] @ pose.inverse() for link, pose in found.links.items()}
    assert set(all_frames(found)) == set(told)
    assert all(
        joint_misfit(e.joint, moved[e.links[0]].inverse() @ moved[e.links[1]]) < 1e-9
        for e in found.tree
    )
    assert all(closure_misfit(closure, moved) < 1e-9 for closure in found.closures)


@pytest.mark.parametrize("name", NAMES)
def test_rank_and_mobility_are_those_of_an_independent_solver(name: str) -> None:
    data, closed = facts(name), nearest_closed(read_sdf(MODELS / f"{name}.sdf"))
    assert closed.closed
    assert rank_at(closed.tree, closed.state) == data["rank_at_configuration"]
    assert (
        closed.tree.freedom - rank_at(closed.tree, closed.state)
        == data["mobility_at_configuration"]
    )


def test_the_gripper_has_one_freedom_nearby() -> None:
    closed = nearest_closed(read_sdf(MODELS / "sdf/pr2_gripper.sdf"))
    near = closed_neighbours(closed, 4, seed=1)
    assert near
    assert {closed.tree.freedom - rank_at(closed.tree, state) for state in near} == {
        facts("sdf/pr2_gripper")["mobility_generic"]
    }


def test_minitaur_leaves_its_singular_configuration() -> None:
    """With its legs turned in their planes it has eight freedoms, if constraints below the file's
    digits (1e-6) are not counted.
    """
    closed = nearest_closed(read_sdf(MODELS / "sdf/minitaur.sdf"))
    tree, rng = closed.tree, np.random.default_rng(0)
    for _ in range(4):
        steps = [0.0 if c.name.endswith(".2") else 0.3 * rng.normal() for c in tree.coordinates]
        turned = tree.own + np.array(steps)
        near = closed_neighbours(replace(closed, state=turned), 1, seed=0, step=0.0)
        if near:
            break
    assert (
        tree.freedom - rank_at(tree, near[0], share=1e-5)
        == facts("sdf/minitaur")["mobility_generic"]
    )


def test_minitaur_legs_combine_freely() -> None:
    """Its legs share no joint: each is a five-bar, which closes in two ways, so that the modes of
    least squares are every combination, of few random starts too, and of several inputs together
    as of each alone.
    """
    mechanism, rng = symkin.load(MODELS / "sdf/minitaur.sdf"), np.random.default_rng(2)
    inputs = rng.uniform(-0.2, 0.2, (2, len(mechanism.actuated))).tolist()
    driven = {c.name for c in mechanism.actuated}
    legs: dict[str, list[str]] = {}
    for loop in symkin.mobility(mechanism).loops:
        own = [name for joint in loop.joints for name in (joint, f"{joint}.1", f"{joint}.2")]
        legs[loop.name] = [name for name in own if name not in driven]
    together = symkin.modes(mechanism, joints=inputs, starts=100)
    for values, found in zip(inputs, together, strict=True):
        ways = [
            {tuple(round(mode.joints[n], 3) for n in own if n in mode.joints) for mode in found}
            for own in legs.values()
        ]
        assert [len(way) for way in ways] == [2, 2, 2, 2]
        assert len(found) == 16
        alone = symkin.modes(mechanism, joints=values, starts=100)
        assert len(alone) == 16
        np.testing.assert_allclose(
            [list(mode.joints.values()) for mode in found],
            [list(mode.joints.values()) for mode in alone],
            atol=1e-6,
        )


# --- versions -------------------------------------------------------------------------------------

BODIES = (
    f"<link name='a'><pose>{AWAY}</pose></link><link name='b'><pose>1 2 3 0.5 0.6 0.7</pose></link>"
)
JOINT = (
    "<joint name='j' "
    "type='revolute'><parent>a</parent><child>b</child><pose>{pose}</pose><axis>{axis}</axis></joint>"
)
AXIS = np.array([0.6, 0.0, 0.8])


def _words(vector: np.ndarray) -> str:
    return " ".join(repr(float(c)) for c in vector)


def test_the_axis_is_told_in_the_frame_of_the_version(tmp_path: Path) -> None:
    """One axis, 0.6 0 0.8 in the joint's frame: in the model's frame before 1.5, in the joint's
    from then on, in any named one from 1.7.
    """
    at = "0.1 0.2 0.3 0.3 0.2 0.1"
    plain = read(tmp_path, BODIES + JOINT.format(pose=at, axis=f"<xyz>{_words(AXIS)}</xyz>"), "1.6")
    wanted, root = joints_of(plain)["j"], plain.links["base"]
    assert np.allclose(np.asarray(root.matrix), np.eye(4))
    # the axis in the model's frame, by Euler angles written out here
    turn = _turn(0.5, 0.6, 0.7) @ _turn(0.3, 0.2, 0.1)
    model = f"<xyz>{_words(turn @ AXIS)}</xyz>"
    others = {
        "1.4": JOINT.format(pose=at, axis=model),
        "1.5": JOINT.format(
            pose=at, axis=model + "<use_parent_model_frame>true</use_parent_model_frame>"
        ),
        "1.7": JOINT.format(pose=at, axis=model.replace("<xyz>", "<xyz expressed_in='__model__'>")),
        "1.9": JOINT.format(pose=at, axis=f"<xyz expressed_in='j'>{_words(AXIS)}</xyz>"),
        "1.12": JOINT.format(
            pose=at, axis=f"<xyz expressed_in='b'>{_words(_turn(0.3, 0.2, 0.1) @ AXIS)}</xyz>"
        ),
    }
    for version, text in others.items():
        found = joints_of(read(tmp_path, BODIES + text, version))["j"]
        assert np.allclose(found.axis, wanted.axis, atol=1e-14), version
        assert np.allclose(found.point, wanted.point, atol=1e-14), version
    # and in the base frame, the first link's
    assert np.allclose(wanted.axis, _turn(0.4, -0.3, 1.1).T @ turn @ AXIS)


def _turn(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Rz(yaw) Ry(pitch) Rx(roll)."""
    (a, b, c), (d, e, f) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    x = np.array([[1, 0, 0], [0, a, -d], [0, d, a]])
    y = np.array([[b, 0, e], [0, 1, 0], [-e, 0, b]])
    z = np.array([[c, -f, 0], [f, c, 0], [0, 0, 1]])
    return z @ y @ x


@pytest.mark.parametrize("version", ["1.6", "1.9"])
def test_poses_are_told_in_frames(version: str, tmp_path: Path) -> None:
    """Link b is told in a frame that is attached to link a, in degrees and as a quaternion; all
    three give the same robot, in files of older versions that have these, too (Drake's have).
    """
    axis = JOINT.format(pose="0 0 0 0 0 0", axis="<xyz>0 0 1</xyz>")
    first = f"<link name='a'><pose>{AWAY}</pose></link>"
    frame = "<frame name='f' attached_to='a'><pose>0 0 1 0 0 1.5707963267948966</pose></frame>"
    told = [
        "<link name='b'><pose relative_to='f'>1 0 0 0 0 0</pose></link>",
        "<link name='b'><pose relative_to='a' degrees='true'>0 1 1 0 0 90</pose></link>",
        "<link name='b'><pose relative_to='a' rotation_format='quat_xyzw'>0 1 1 0 0 "
        "0.7071067811865476 0.7071067811865476</pose></link>",
    ]
    for text in told:
        robot = read(tmp_path, first + text + frame + axis, version)
        assert np.allclose(np.asarray(robot.links["b"].position), [0, 1, 1])
        assert np.allclose(np.asarray(robot.links["b"].rotation), _turn(0, 0, np.pi / 2))


def test_the_pose_of_the_model_moves_nothing_but_against_the_world(tmp_path: Path) -> None:
    axis = JOINT.format(pose="0 0 0 0 0 0", axis="<xyz>0 0 1</xyz>")
    alone = read(tmp_path, BODIES + axis)
    moved = read(tmp_path, "<pose>5 6 7 1 1 1</pose>" + BODIES + axis)
    assert np.allclose(np.asarray(alone.links["b"].matrix), np.asarray(moved.links["b"].matrix))
    held = "<joint name='w' type='fixed'><parent>world</parent><child>a</child></joint>"
    fixed = read(tmp_path, "<pose>5 6 7 0 0 0</pose>" + BODIES + axis + held)
    assert fixed.frames["a"][0] == "base"
    assert np.allclose(np.asarray(fixed.frames["a"][1].position), [5.3, 5.8, 7.5])


# --- joints ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("told", "pitch"),
    [
        ("<screw_thread_pitch>0.25</screw_thread_pitch>", 0.25),
        ("<thread_pitch>8</thread_pitch>", -2 * np.pi / 8),
    ],
)
def test_a_screw_advances_by_its_pitch_in_its_sense(
    told: str, pitch: float, tmp_path: Path
) -> None:
    """screw_thread_pitch: metres a turn, right-handed; thread_pitch: radians a metre,
    left-handed.
    """
    inside = BODIES + (
        f"<joint name='j' "
        f"type='screw'><parent>a</parent><child>b</child>{told}<axis><xyz>0 0 "
        f"1</xyz></axis></joint>"
    )
    robot = read(tmp_path, inside)
    joint = joints_of(robot)["j"]
    before, after = (
        np.asarray(poses_at(robot, {"j": value})["b"].position) for value in (0.0, 2 * np.pi)
    )
    assert joint.type == "H"
    assert np.allclose((after - before) @ np.array(joint.axis), pitch)


def test_universal_joints_turn_about_both_axes_in_order(tmp_path: Path) -> None:
    inside = (
        "<link name='a'/><link name='b'/><joint name='j' "
        "type='{}'><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz></axis>"
    )
    inside += "<axis2><xyz>1 0 0</xyz></axis2></joint>"
    for kind in ("universal", "revolute2"):
        robot = read(tmp_path, inside.format(kind))
        turned = poses_at(robot, {"j": (0.3, 0.7)})["b"].rotation
        assert np.allclose(np.asarray(turned), _turn(0, 0.3, 0) @ _turn(0.7, 0, 0))


def test_gearboxes_and_mimics_are_couplings(tmp_path: Path) -> None:
    """theta_2 = -ratio theta_1 against the reference body; follower = multiplier (leader -
    reference) + offset.
    """
    gears = "<link name='g'/>" + "".join(
        f"<link name='{w}'/><joint name='j{w}' "
        f"type='revolute'><parent>{p}</parent><child>{c}</child><axis><xyz>0 0 "
        f"1</xyz>{m}</axis></joint>"
        for w, p, c, m in (
            ("x", "g", "x", ""),
            ("y", "y", "g", ""),
            (
                "z",
                "g",
                "z",
                "<mimic "
                "joint='jx'><multiplier>2</multiplier><offset>1</offset><reference>3</reference></mimic>",
            ),
        )
    )
    box = """<joint name='box' type='gearbox'><parent>x</parent><child>y</child>
      <gearbox_ratio>4</gearbox_ratio>
      <gearbox_reference_body>g</gearbox_reference_body><axis><xyz>0 0 1</xyz></axis><axis2>
      <xyz>0 0 1</xyz></axis2></joint>"""
    mimic, gear = read(tmp_path, gears + box, "1.11").couplings
    assert (mimic.joint, mimic.terms, mimic.offset) == ("jz", (("jx", 2.0),), -5.0)
    # y is the parent of its joint to g: its angle against g is minus the joint's value
    assert (gear.joint, gear.terms, gear.offset) == ("jy", (("jx", 4.0),), 0.0)


def test_a_loop_of_joints_needs_no_marker(tmp_path: Path) -> None:
    """A square of four links, closed in the file; two joints are told from the link that is farther
    from the root.
    """
    corners = {"a": "0 0 0 0 0 0", "b": "1 0 0 0 0 1", "c": "1 1 0 0 0 2", "d": "0 1 0 0 0 3"}
    links = "".join(
        f"<link name='{name}'><pose>{pose}</pose></link>" for name, pose in corners.items()
    )
    pairs = (("ab", "a", "b"), ("bc", "c", "b"), ("cd", "c", "d"), ("da", "a", "d"))
    joints = "".join(
        f"<joint name='{n}' type='revolute'><parent>{p}</parent><child>{c}</child><pose>0 0 0.5 0 "
        f"0 0</pose><axis><xyz>0 0 1</xyz></axis></joint>"
        for n, p, c in pairs
    )
    robot = read(tmp_path, links + joints)
    (closure,) = robot.closures
    assert closure.joint.type == "R"
    still = dict.fromkeys(joints_of(robot), 0.0)
    assert closure_misfit(closure, displaced(robot, still)) < 1e-15
    # bc turns b against c, also where the tree has b nearer to the root
    told = [entry for entry in robot.tree if entry.joint.name == "bc"]
    assert all((e.links, e.joint.axis) == (("c", "b"), (0.0, 0.0, 1.0)) for e in told)


def test_a_joint_that_closes_a_loop_keeps_its_range_and_counts_from_the_file(
    tmp_path: Path,
) -> None:
    """A parallelogram with a range on every joint, of which one closes the loop: turned, its angles
    are those of the tree's joints.
    """
    square = {"a": "0 0", "b": "0 0", "c": "0 2", "d": "1 0"}
    links = "".join(
        f"<link name='{name}'><pose>{at} 0 0 0 0</pose></link>" for name, at in square.items()
    )
    joints = "".join(
        f"<joint name='{p}{c}' type='revolute'><parent>{p}</parent><child>{c}</child><pose "
        f"relative_to='__model__'>{at} 0 0 0 0</pose>"
        "<axis><xyz>0 0 1</xyz><limit><lower>-0.5</lower><upper>0.25</upper></limit></axis></joint>"
        for p, c, at in (("a", "b", "0 0"), ("b", "c", "0 2"), ("a", "d", "1 0"), ("d", "c", "1 2"))
    )
    robot = read(tmp_path, links + joints)
    (closure,) = robot.closures
    assert closure.joint.limits == (-0.5, 0.25)
    closed = nearest_closed(robot)
    state = {"ab": 0.2, "ad": 0.2, "bc": -0.2}
    near = replace(closed, state=np.array([state[c.name] for c in closed.tree.coordinates]))
    made = {joint.joint.name: joint.joint for joint in assembled(robot, near).link_joints}
    assert np.isclose(made[closure.joint.name].zero, -0.2)
    assert made[closure.joint.name].limits == (-0.5, 0.25)


# --- nested models --------------------------------------------------------------------------------

ARM = "<link name='p'/><link name='q'><pose>0 0 1 0 0 0</pose></link>" + JOINT.format(
    pose="0 0 0 0 0 0", axis="<xyz>1 0 0</xyz>"
).replace(">a<", ">p<").replace(">b<", ">q<")
HUB = "<link name='hub'/>"
TO_ARM = (
    "<joint name='k' type='revolute'><parent>hub</parent><child>arm::p</child><axis><xyz>0 0 "
    "1</xyz></axis></joint>"
)


@pytest.mark.parametrize("form", ["nested", "included", "merged"])
def test_models_within_models(form: str, tmp_path: Path) -> None:
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "model.sdf").write_text(
        f"<sdf version='1.8'><model name='arm'>{ARM}</model></sdf>"
    )
    at = "<pose>2 0 0 0 0 1.5707963267948966</pose>"
    inside = {
        "nested": f"<model name='arm'>{at}{ARM}</model>",
        "included": f"<include><uri>model://arm</uri>{at}</include>",
        "merged": f"<include merge='true'><uri>arm</uri>{at}</include>",
    }[form]
    to = TO_ARM.replace("arm::", "") if form == "merged" else TO_ARM
    robot = read(tmp_path, HUB + inside + to, "1.9")
    prefix = "" if form == "merged" else "arm/"
    assert np.allclose(np.asarray(robot.links[f"{prefix}q"].position), [2, 0, 1])
    assert np.allclose(joints_of(robot)[f"{prefix}j"].axis, [0, 1, 0])


def test_a_model_is_placed_by_one_of_its_frames(tmp_path: Path) -> None:
    inside = f"<model name='arm' placement_frame='q'><pose>2 0 0 0 0 0</pose>{ARM}</model>"
    robot = read(tmp_path, HUB + inside + TO_ARM, "1.8")
    assert np.allclose(np.asarray(robot.links["arm/q"].position), [2, 0, 0])
    assert np.allclose(np.asarray(robot.links["arm/p"].position), [2, 0, -1])


def test_what_is_left_out_is_named(tmp_path: Path) -> None:
    """Bounds that are no range, elements that name nothing of the robot."""
    locked = "<xyz>0 0 1</xyz><limit><lower>0</lower><upper>0</upper></limit>"
    robot = read(
        tmp_path,
        "<author>me</author><plugin name='p' filename='x'/>"
        + BODIES
        + JOINT.format(pose="0 0 0 0 0 0", axis=locked),
    )
    assert joints_of(robot)["j"].limits is None
    assert any("the range [0, 0] of <joint name='j'> is left out" in note for note in robot.notes)
    assert "left out, of no meaning here: <author>, <plugin>" in robot.notes


# --- what real files do ---------------------------------------------------------------------------


def test_a_link_named_world_before_1_7_is_what_the_model_stands_in(tmp_path: Path) -> None:
    inside = (
        "<link name='world'/>"
        + BODIES
        + JOINT.format(pose="0 0 0 0 0 0", axis="<xyz>0 0 1</xyz>").replace(">a<", ">world<")
    )
    found = read(tmp_path, inside, "1.6")
    assert [entry.links for entry in found.tree] == [("base", "b")]
    np.testing.assert_allclose(found.links["b"].position, [1.0, 2.0, 3.0])
    assert any("the link 'world' is what the model stands in" in note for note in found.notes)


def test_an_axis_that_both_rules_read_alike_may_say_use_parent_model_frame(tmp_path: Path) -> None:
    flag = "<xyz>0.6 0 0.8</xyz><use_parent_model_frame>1</use_parent_model_frame>"
    straight = "<link name='a'/><link name='b'><pose>1 2 3 0 0 0</pose></link>" + JOINT.format(
        pose="0 0 0 0 0 0", axis=flag
    )
    np.testing.assert_allclose(joints_of(read(tmp_path, straight, "1.8"))["j"].axis, AXIS)


def test_a_parent_frame_away_from_the_joint_is_told(tmp_path: Path) -> None:
    """The joint stands at its child, whatever frame names its parent."""
    frame = "<frame name='f' attached_to='a'><pose relative_to='b'>{} 0 0 0 0 0</pose></frame>"
    joint = JOINT.format(pose="0 0 0 0 0 0", axis="<xyz>0 0 1</xyz>").replace(">a<", ">f<")
    away, at = (read(tmp_path, BODIES + frame.format(x) + joint) for x in (0.5, 0))
    for found in (away, at):
        (entry,) = found.tree
        np.testing.assert_allclose(entry.joint.point, found.links["b"].position)
    assert any(
        "the parent frame 'f' of <joint name='j'> is 0.5 m from the joint" in note
        for note in away.notes
    )
    assert not any("parent frame" in note for note in at.notes)


def test_a_loop_that_a_plugin_makes_at_run_time_is_told(tmp_path: Path) -> None:
    plugin = (
        "<plugin "
        "name='gz::sim::systems::DetachableJoint'><parent_link>a</parent_link><child_link>b</child_link></plugin>"
    )
    found = read(tmp_path, BODIES + GOOD + plugin, "1.8")
    assert not found.closures
    assert any("a plugin joins a and b when the simulation runs" in note for note in found.notes)


def test_joints_whose_states_a_plugin_publishes_are_not_driven_by_it(tmp_path: Path) -> None:
    """Of two joints whose states are published one has a controller, and is the motor."""
    end = "<link name='c'/>" + GOOD.replace("'j'", "'k'").replace(">b<", ">c<")
    names = "<joint_name>j</joint_name><joint_name>k</joint_name>"
    plugins = (
        "<plugin filename='gz-sim-joint-state-publisher-system' "
        f"name='gz::sim::systems::JointStatePublisher'>{names}</plugin>"
        "<plugin filename='gz-sim-joint-controller-system' "
        "name='gz::sim::systems::JointController'><joint_name>k</joint_name></plugin>"
    )
    found = read(tmp_path, BODIES + GOOD + end + plugins, "1.8")
    assert [entry.joint.name for entry in found.tree if entry.joint.actuated] == ["k"]


# --- what is wrong --------------------------------------------------------------------------------

GOOD = JOINT.format(pose="0 0 0 0 0 0", axis="<xyz>0 0 1</xyz>")
BAD = {
    "no rotation": (
        BODIES.replace("<pose>1 2 3", "<pose rotation_format='quat_xyzw'>0 0 0 2") + GOOD,
        "1.9",
        "<pose>: quaternion: norm",
    ),
    "two links": ("<link name='a'/>" + BODIES, "1.7", "the name 'a' is taken"),
    "unknown link": (
        BODIES + GOOD.replace(">b<", ">bb<"),
        "1.7",
        "the frame 'bb' is unknown (do you mean 'b'?)",
    ),
    "itself": (BODIES + GOOD.replace(">b<", ">a<"), "1.7", "joins the link 'a' to itself"),
    "no axis": (BODIES + GOOD.replace("axis", "axes"), "1.7", "<axis> is missing"),
    "zero axis": (BODIES + GOOD.replace("0 0 1", "0 0 0"), "1.7", "is the zero vector"),
    "NaN": (BODIES.replace("1 2 3", "nan 2 3") + GOOD, "1.7", "'nan' is not a finite number"),
    "unknown type": (
        BODIES + GOOD.replace("revolute", "hinge"),
        "1.7",
        "type = 'hinge' is unknown; allowed: revolute",
    ),
    "two joints": (BODIES + GOOD + GOOD, "1.7", "two joints are named 'j'"),
    "unknown version": (BODIES + GOOD, "3.0", "version = '3.0' is unknown; allowed: 1.4 to 1.12"),
    "circle": (
        "<frame name='f'><pose relative_to='g'/></frame><frame name='g'><pose "
        "relative_to='f'/></frame>" + BODIES.replace("<pose>1", "<pose relative_to='f'>1") + GOOD,
        "1.7",
        "in each other in a circle",
    ),
    "told in nothing": (
        "<frame name='tip'/>" + BODIES.replace("<pose>1", "<pose relative_to='tipp'>1") + GOOD,
        "1.7",
        "the frame 'tipp' in which it is told is unknown (do you mean 'tip'?)",
    ),
    "old frames": (
        BODIES.replace("<pose>1", "<pose frame='a'>1") + GOOD,
        "1.6",
        "not told in the frame 'a'; write relative_to",
    ),
    "model frame": (
        BODIES
        + GOOD.replace("</axis>", "<use_parent_model_frame>1</use_parent_model_frame></axis>"),
        "1.8",
        "<use_parent_model_frame>: is of versions before 1.7, and would turn the axis",
    ),
    "link named world": (
        "<link name='world'/>" + BODIES + GOOD,
        "1.7",
        "the name 'world' is reserved",
    ),
    "placed world": (
        "<link name='world'><pose>0 0 1 0 0 0</pose></link>" + BODIES + GOOD,
        "1.6",
        "the name 'world' is reserved",
    ),
    "parallel": (
        BODIES
        + GOOD.replace("revolute", "universal").replace(
            "</axis>", "</axis><axis2><xyz>0 0 1</xyz></axis2>"
        ),
        "1.7",
        "axis and axis2 are parallel",
    ),
    "no pitch": (
        BODIES + GOOD.replace("revolute", "screw"),
        "1.7",
        "<screw_thread_pitch> is missing",
    ),
    "missing include": (
        BODIES + "<include><uri>model://none</uri></include>",
        "1.7",
        "'model://none' is not found",
    ),
    "world": (BODIES + GOOD.replace(">b<", ">world<"), "1.7", "the child is the world"),
    "static": ("<static>true</static>" + BODIES + GOOD, "1.7", "the model is static"),
    "unknown": (
        "<rope><to>a</to></rope>" + BODIES + GOOD,
        "1.7",
        "<rope> is unknown in a model, and it names links",
    ),
    "empty": ("", "1.7", "no <link> is found"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_one_sentence_with_file_line_and_element(
    case: str, tmp_path: Path
) -> None:
    inside, version, sentence = BAD[case]
    with pytest.raises(SymkinError) as error:
        read(tmp_path, inside, version)
    message = str(error.value)
    assert sentence in message
    assert message.startswith(str(tmp_path / "r.sdf"))
    assert "line " in message
    assert "\n" not in message


def test_a_file_that_includes_itself_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SymkinError, match=r"line 1: <include>: 'r\.sdf' includes itself"):
        read(tmp_path, HUB + "<include><uri>r.sdf</uri></include>")


def test_several_models_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "w.sdf"
    model = f"<model name='{{}}'>{BODIES}{GOOD}</model>"
    path.write_text(
        f"<sdf version='1.7'><world name='w'>{model.format('m')}{model.format('n')}</world></sdf>"
    )
    with pytest.raises(SymkinError, match="2 models are found: m, n; name one of them"):
        read_sdf(path)


def test_show_and_close_give_one_account_of_a_singular_file_that_closes_to_its_digits() -> None:
    """Minitaur's own configuration is singular, and beside it the legs close only to the file's
    digits: both say 12 and 8.
    """
    path = MODELS / "sdf/minitaur.sdf"
    told = facts("sdf/minitaur")
    shown, closed = symkin.mobility(symkin.load(path)).to_dict(), symkin.close(path).to_dict()
    for account in (shown, closed):
        assert account["mobility"] == told["mobility_at_configuration"]
        assert account["generic"]["mobility"] == told["mobility_generic"]
        (note,) = (note for note in account["notes"] if "singular" in note)
        assert "digits of the file" in note
        assert {" 12", " 8"} <= {
            word.rstrip(",;") and " " + word.rstrip(",;") for word in note.split()
        }


def _to_digits(digits: int, number: re.Match[str]) -> str:
    return f"{float(number[0]):.{digits}g}"


def test_another_format_tells_the_mobility_of_a_singular_file_that_closes_to_its_digits(
    tmp_path: Path,
) -> None:
    """Minitaur's legs move alike however their file is written: where its digits lead back to the
    singular place, 10 freedoms were told for 8, and 12 of eight digits, where short steps closed.
    """
    converted = tmp_path / "minitaur.urdf"
    symkin.convert(MODELS / "sdf/minitaur.sdf", converted)
    text = converted.read_text()
    for digits in (17, 8):
        written = partial(_to_digits, digits)
        converted.write_text(re.sub(r"-?\d+\.\d+(e[-+]?\d+)?", written, text))
        told = symkin.close(converted).to_dict()
        assert told["generic"]["mobility"] == facts("sdf/minitaur")["mobility_generic"]


def test_a_universal_joint_that_is_told_from_the_other_link_is_as_the_file_has_it(
    tmp_path: Path,
) -> None:
    """The file's joint turns the root against the link about x and then y: .1 and .2 are these two
    of the mechanism, whatever tree the reader chooses, and what follows axis2 follows .2.
    """
    inside = """<link name='a'/><link name='b'/><link name='c'/>
    <joint name='u' type='universal'><parent>b</parent><child>a</child>
    <pose relative_to='__model__'/><axis><xyz>1 0 0</xyz></axis>
    <axis2><xyz>0 1 0</xyz></axis2></joint>
    <joint name='j' type='revolute'><parent>a</parent><child>c</child><axis><xyz>0 0 1</xyz>
    <mimic joint='u' axis='axis2'>
    <multiplier>2</multiplier></mimic></axis></joint>"""
    robot = read(tmp_path, inside, "1.11")
    (coupling,) = robot.couplings
    assert (coupling.joint, coupling.terms) == ("j", (("u.2", 2.0),))
    mechanism = mechanism_of(robot)
    entry = next(e for e in mechanism.link_joints if e.joint.name == "u")
    assert entry.links == ("b", "base")
    # a in b: about x by 0.3, then about y by 0.7
    moved = displacement(entry.joint, {"u.1": 0.3, "u.2": 0.7})
    np.testing.assert_allclose(moved[:3, :3], _turn(0.3, 0, 0) @ _turn(0, 0.7, 0), atol=1e-15)
    assert coupling == mechanism.couplings[0]
