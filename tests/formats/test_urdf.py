"""URDF as small files tell it: one four-bar in every form of loop, mimics, joints of many freedoms,
motors; what is wrong is one sentence.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from helpers.inside import Robot, read_urdf
from helpers.robot_files import closure_misfit, displaced, poses_at
from symkin import Pose, SymkinError

TREE = """
  <link name="ground"/> <link name="crank"/> <link name="rod"/> <link name="rocker"/>
  <joint name="a" type="revolute"><parent link="ground"/><child link="crank"/><axis xyz="0 0 2"/>
    <limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
  <joint name="b" type="continuous"><parent link="crank"/><child link="rod"/><origin xyz="1 0 0"/>
  <axis xyz="0 0 1"/></joint>
  <joint name="c" type="continuous"><parent link="ground"/><child link="rocker"/>
  <origin xyz="0 2 0" rpy="0 0 1.5707963267948966"/>
    <axis xyz="0 0 1"/></joint>
"""
"""A four-bar: crank of 1 and rod of 2 along x, rocker of 3 along y from (0, 2); a point at its
end.
"""
FIXED = """<link name="{name}"/><joint name="{name}_frame" type="fixed"><parent link="{parent}"/>
  <child link="{name}"/><origin xyz="{at}"/></joint>"""
FORMS = {
    "loop_joint": """<loop_joint name="d" type="revolute"><axis xyz="0 0 1"/>
      <link1 link="rod" xyz="2 0 0" rpy="0 0 0"/>
      <link2 link="rocker" xyz="3 0 0"/></loop_joint>""",
    "link1 twice": """<loop_joint name="d" type="continuous"><axis xyz="0 0 1"/>
      <link1 link="rod" xyz="2 0 0"/>
      <link1 link="rocker" xyz="3 0 0"/></loop_joint>""",
    "loop": """<loop name="d" type="revolute">
      <predecessor link="rod"><origin xyz="2 0 0"/></predecessor>
      <successor link="rocker"><origin xyz="3 0 0"/></successor><axis xyz="0 0 1"/></loop>""",
    "constraint": """<constraint name="d" type="revolute">
      <parent link="rod"/><parent_origin xyz="2 0 0"/><child link="rocker"/>
      <child_origin xyz="3 0 0"/>
      <parent_axis xyz="0 0 1"/><child_axis xyz="0 0 1"/></constraint>""",
    "spherical_joint": """<constraint name="d" type="spherical_joint">
      <parent link="rod"/><parent_origin xyz="2 0 0"/>
      <child link="rocker"/><child_origin xyz="3 0 0"/></constraint>""",
    "closing": FIXED.format(name="closing_d_1", parent="rod", at="2 0 0")
    + FIXED.format(name="closing_d_2", parent="rocker", at="3 0 0"),
    "drake": """<drake:ball_constraint><drake:ball_constraint_body_A name="rod"/>
      <drake:ball_constraint_p_AP value="2 0 0"/>
      <drake:ball_constraint_body_B name="rocker"/>
      <drake:ball_constraint_p_BQ value="3 0 0"/></drake:ball_constraint>""",
}
POINTS = ("spherical_joint", "closing", "drake")
"""Forms that hold a point and no axis."""


def read(folder: Path, inside: str, name: str = "r") -> Robot:
    path = folder / f"{name}.urdf"
    path.write_text(f"<robot name='{name}'>{inside}</robot>", encoding="utf-8")
    return read_urdf(path)


def refusal(folder: Path, inside: str) -> str:
    with pytest.raises(SymkinError) as error:
        read(folder, inside)
    return str(error.value)


def closed_values() -> dict[str, float]:
    """Joint values of the four-bar by the law of cosines, crank at 0.3 rad."""
    end, pivot = np.array([np.cos(0.3), np.sin(0.3)]), np.array([0.0, 2.0])
    way = pivot - end
    reach = float(np.linalg.norm(way))
    rod = np.arctan2(way[1], way[0]) - np.arccos((reach**2 + 4 - 9) / (4 * reach))
    tip = end + 2 * np.array([np.cos(rod), np.sin(rod)])
    rocker = np.arctan2(*(tip - pivot)[::-1])
    return {"a": 0.3, "b": rod - 0.3, "c": rocker - np.pi / 2}


@pytest.mark.parametrize("form", FORMS)
def test_one_loop_is_read_alike_in_every_form(form: str, tmp_path: Path) -> None:
    """It is as far open at zero as the points are, and closed where the law of cosines says."""
    robot = read(tmp_path, TREE + FORMS[form])
    (closure,) = robot.closures
    assert closure.joint.type == ("S" if form in POINTS else "R")
    assert closure.links == ("rod", "rocker")
    assert np.allclose(np.asarray(closure.frames[0].position), [3, 0, 0])
    assert np.allclose(np.asarray(closure.frames[1].position), [0, 5, 0])
    assert closure_misfit(closure, displaced(robot, closed_values())) < 1e-12
    assert closure_misfit(closure, displaced(robot, {**closed_values(), "b": 0.1})) > 0.01


def test_a_joint_of_sdf_within_gazebo_closes_a_loop(tmp_path: Path) -> None:
    """Its pose is in the child's frame: the frame on the parent is where the child's is at zero, so
    that the file is closed.
    """
    inside = """<gazebo><joint name="d" type="revolute"><parent>rod</parent><child>rocker</child>
<pose>3 0 0 0 0 0</pose>
      <axis><xyz>0 0 1</xyz></axis></joint></gazebo>"""
    robot = read(tmp_path, TREE + inside)
    assert not [note for note in robot.notes if "simulator settings" in note]
    robot = read(tmp_path, TREE + inside + '<gazebo reference="rod"><mu1>1</mu1></gazebo>')
    assert [note for note in robot.notes if "simulator settings" in note]
    (closure,) = robot.closures
    assert closure.joint.type == "R"
    assert np.allclose(np.asarray(closure.frames[0].position), [0, 5, 0])
    assert closure_misfit(closure, displaced(robot, {"a": 0.0, "b": 0.0, "c": 0.0})) < 1e-15


@pytest.mark.parametrize("form", ["constraint", "loop"])
def test_a_slide_told_by_an_axis_on_either_link_is_closed_where_the_file_is(
    form: str, tmp_path: Path
) -> None:
    """Two axes leave the angle about them open: it is that of the links at zero, wherever the
    frames of these are turned to. Along the slide the loop stays closed, across it does not.
    """
    turn = (0.4, -0.7, 1.1)
    x, y, z = Pose.from_euler((0.0, 0.0, 0.0), turn, "xyz").inverse().turn(np.array([1.0, 0, 0]))
    origin = f'xyz="1 0 0" rpy="{turn[0]} {turn[1]} {turn[2]}"'
    inside = f"""<link name="ground"/><link name="cart"/><link name="block"/>
      <joint name="s" type="prismatic"><parent link="ground"/><child link="cart"/>
        <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
      <joint name="t" type="prismatic"><parent link="cart"/><child link="block"/>
        <origin {origin}/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
    if form == "constraint":
        inside += f"""<constraint name="d" type="prismatic"><parent link="ground"/>
          <parent_origin xyz="1 0 0"/><child link="block"/>
          <parent_axis xyz="1 0 0"/><child_axis xyz="{x} {y} {z}"/></constraint>"""
    else:
        inside += f"""<loop name="d" type="prismatic">
          <predecessor link="ground"><origin xyz="1 0 0"/><axis xyz="1 0 0"/></predecessor>
          <successor link="block"><axis xyz="{x} {y} {z}"/></successor></loop>"""
    robot = read(tmp_path, inside)
    (closure,) = robot.closures
    assert closure.joint.type == "P"
    assert closure_misfit(closure, displaced(robot, {"s": 0.3, "t": 0.0})) < 1e-12
    assert closure_misfit(closure, displaced(robot, {"s": 0.0, "t": 0.3})) > 0.01


@pytest.mark.parametrize("angle", [40.0, 90.0, 130.0])
def test_a_slide_of_two_axes_stays_in_the_plane_of_its_linkage(
    angle: float, tmp_path: Path
) -> None:
    """A block slides along an axis that is turned in the plane of its slider-crank: closed, it is
    turned back in this plane.
    """
    x, y = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    inside = (
        TREE
        + f"""<link name="guide"/><joint name="g" type="fixed"><parent link="ground"/>
      <child link="guide"/><origin xyz="4 0 0"/></joint>
      <constraint name="d" type="prismatic"><parent link="guide"/><child link="rod"/>
      <child_origin xyz="3 0 0"/><parent_axis xyz="1 0 0"/><child_axis xyz="{x} {y} 0"/>
      </constraint>"""
    )
    (closure,) = read(tmp_path, inside).closures
    turn = closure.frames[0] @ closure.frames[1].inverse()
    assert np.allclose(turn.turn(np.array([0.0, 0.0, 1.0])), [0.0, 0.0, 1.0])
    assert np.allclose(turn.turn(np.array([x, y, 0.0])), [1.0, 0.0, 0.0])


def test_closures_join_what_no_joint_does(tmp_path: Path) -> None:
    """A second tree hangs on its loop joint, backwards where its root is farther: what the file
    tells as joint values moves it so.
    """
    more = """<link name="x"/><link name="y"/><joint name="e" type="continuous"><parent link="x"/>
<child link="y"/>
      <origin xyz="0 1 0"/><axis xyz="0 0 1"/></joint>
      <loop_joint name="f" type="revolute"><axis xyz="0 0 1"/><link1 link="rod" xyz="2 0 0"/>
      <link2 link="y"/></loop_joint>"""
    robot = read(tmp_path, TREE + more)
    assert not robot.closures
    poses = poses_at(robot, {"a": 0.0, "b": 0.0, "c": 0.0, "f": 0.0, "e": 0.5})
    y, x = np.asarray(poses["y"].position), np.asarray(poses["x"].position)
    assert np.allclose(y, [3, 0, 0])
    # y = x turned by e about its own origin, which is 1 along x's y axis
    assert np.allclose(x, [3 - np.sin(0.5), -np.cos(0.5), 0])


def test_mimic_is_a_coupling(tmp_path: Path) -> None:
    mimic = TREE.replace("</axis", "").replace(
        '<origin xyz="1 0 0"/>',
        '<origin xyz="1 0 0"/><mimic joint="a" multiplier="-2" offset="0.5"/>',
    )
    (coupling,) = read(tmp_path, mimic).couplings
    assert (coupling.joint, coupling.terms, coupling.offset) == ("b", (("a", -2.0),), 0.5)


def test_couplings_of_links_are_of_the_joints_from_their_common_ancestor(tmp_path: Path) -> None:
    """3 (a + b) = c for the rod and the rocker, whose common ancestor is the ground."""
    inside = TREE + (
        '<coupling name="g"><predecessor link="rod"/><successor link="rocker"/><ratio '
        'value="3"/></coupling>'
    )
    (coupling,) = read(tmp_path, inside).couplings
    assert (coupling.joint, dict(coupling.terms)) == ("c", {"a": 3.0, "b": 3.0})


def test_a_coupling_of_links_that_mimics_say_already_is_left_out(tmp_path: Path) -> None:
    """c = 3 (a + b) with b = -2 a is c = -3 a: couplings are equations, whichever tell them."""
    inside = TREE
    for name, factor in (("b", -2), ("c", -3)):
        inside = inside.replace(
            f'<joint name="{name}" type="continuous">',
            f'<joint name="{name}" type="continuous"><mimic joint="a" multiplier="{factor}"/>',
        )
    inside += (
        '<coupling name="g"><predecessor link="rod"/><successor link="rocker"/><ratio '
        'value="3"/></coupling>'
    )
    robot = read(tmp_path, inside)
    assert {c.joint: dict(c.terms) for c in robot.couplings} == {"b": {"a": -2}, "c": {"a": -3}}
    assert any("says what other couplings say" in note for note in robot.notes)


def test_fixed_joints_are_merged_and_names_kept_in_notes(tmp_path: Path) -> None:
    robot = read(
        tmp_path,
        TREE
        + FIXED.format(name="tool@tip", parent="rod", at="0 1 0")
        + FIXED.format(name="base", parent="ground", at="0 0 1"),
    )
    assert robot.frames["tool_tip"][0] == "rod"
    assert robot.frames["base_2"][0] == "base"
    assert np.allclose(np.asarray(robot.frames["tool_tip"][1].position), [1, 1, 0])
    assert any("'tool@tip' is 'tool_tip'" in note for note in robot.notes)
    assert any("'ground' is held" in note for note in robot.notes)


def test_limits_and_motors(tmp_path: Path) -> None:
    joints = {j.joint.name: j.joint for j in read(tmp_path, TREE).tree}
    assert joints["a"].limits == (-1.0, 2.0)
    assert joints["b"].limits is None
    assert all(joint.actuated for joint in joints.values())
    motor = (
        '<transmission name="t"><joint '
        'name="a"><hardwareInterface>x</hardwareInterface></joint></transmission>'
    )
    driven = read(tmp_path, TREE + motor).tree
    assert [entry.joint.name for entry in driven if entry.joint.actuated] == ["a"]


@pytest.mark.parametrize(("named", "driven"), [("ab", ["a"]), ("b", ["b"]), ("a", ["a"])])
def test_controllers_of_a_joint_that_mimics_are_those_of_its_leader(
    named: str, driven: list[str], tmp_path: Path
) -> None:
    """Simulators want an interface for joints that mimic, too, which no motor drives by itself;
    where the follower alone is named, it is the driven one.
    """
    controls = "".join(f'<joint name="{n}"><command_interface name="p"/></joint>' for n in named)
    mimic = TREE.replace('<origin xyz="1 0 0"/>', '<origin xyz="1 0 0"/><mimic joint="a"/>')
    robot = read(tmp_path, mimic + f'<ros2_control name="s">{controls}</ros2_control>')
    assert [entry.joint.name for entry in robot.tree if entry.joint.actuated] == driven


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "spherical", "fixed"])
def test_a_controller_drives_a_closing_joint_or_a_note_tells_why_not(
    kind: str, tmp_path: Path
) -> None:
    """What closes a loop is driven as any joint is, where it has one coordinate."""
    controls = "".join(f'<joint name="{n}"><command_interface name="p"/></joint>' for n in "ad")
    loop = FORMS["loop_joint"].replace("revolute", kind)
    robot = read(tmp_path, TREE + loop + f'<ros2_control name="s">{controls}</ros2_control>')
    driven = [entry.joint.name for entry in robot.joints if entry.joint.actuated]
    notes = [note for note in robot.notes if "no one motor drives: 'd' (" in note]
    able = kind in ("revolute", "prismatic")
    assert driven == (["a", "d"] if able else ["a"])
    assert len(notes) == (not able)


def test_joints_that_a_transmission_only_reads_are_passive(tmp_path: Path) -> None:
    def transmission(name: str, interface: str) -> str:
        return (
            f'<transmission name="{name}_t"><joint '
            f'name="{name}"><hardwareInterface>{interface}</hardwareInterface></joint></transmission>'
        )

    told = transmission("a", "hardware_interface/EffortJointInterface") + transmission(
        "b", "hardware_interface/PassiveJointInterface"
    )
    driven = read(
        tmp_path, TREE + told + transmission("c", "hardware_interface/JointStateInterface")
    ).tree
    assert [entry.joint.name for entry in driven if entry.joint.actuated] == ["a"]


def test_independent_joints_of_urdf_plus_are_driven_however_true_is_written(tmp_path: Path) -> None:
    told = TREE.replace('name="a"', 'name="a" independent="true"').replace(
        'name="b"', 'name="b" independent="True"'
    )
    driven = read(tmp_path, told.replace('name="c"', 'name="c" independent="False"')).tree
    assert [entry.joint.name for entry in driven if entry.joint.actuated] == ["a", "b"]


def test_the_world_needs_no_link(tmp_path: Path) -> None:
    """As Drake and MuJoCo read it: a joint from the world, which no <link> writes."""
    robot = read(
        tmp_path,
        TREE
        + (
            '<joint name="stand" type="fixed"><parent link="world"/><child '
            'link="ground"/><origin xyz="0 0 1"/></joint>'
        ),
    )
    assert robot.links["base"].position.tolist() == [0.0, 0.0, 0.0]
    assert robot.frames["ground"][1].position.tolist() == [0.0, 0.0, 1.0]
    assert any("'world'" in note and "no <link> writes" in note for note in robot.notes)


@pytest.mark.parametrize(("kind", "freedoms"), [("planar", 3), ("floating", 6)])
def test_joints_of_many_freedoms_are_chains(kind: str, freedoms: int, tmp_path: Path) -> None:
    more = (
        f'<link name="x"/><joint name="p" type="{kind}"><parent link="rod"/><child '
        f'link="x"/><origin xyz="0 0 1"/><axis xyz="1 0 0"/></joint>'
    )
    robot = read(tmp_path, TREE + more)
    added = [entry.joint for entry in robot.tree if entry.joint.name.startswith("p.")]
    assert sum(joint.freedom for joint in added) == freedoms
    if kind == "planar":
        assert all(abs(np.dot(joint.axis, [1, 0, 0])) < 1e-15 for joint in added[:2])
        assert added[2].axis == (1.0, 0.0, 0.0)


def test_a_floating_root_is_held(tmp_path: Path) -> None:
    world = (
        '<link name="world"/><joint name="free" type="floating"><parent link="world"/><child '
        'link="ground"/></joint>'
    )
    robot = read(tmp_path, world + TREE)
    assert len(robot.tree) == 3
    assert any("held" in note and "'free'" in note for note in robot.notes)


LINK = (
    '<link name="u"/><joint name="j" type="{type}"><parent link="rod"/><child '
    'link="{child}"/>{more}</joint>'
)
BAD = {
    "no rotation": (
        TREE.replace('xyz="1 0 0"', 'quat_xyzw="0 0 0 2"', 1),
        "<origin>: quaternion: norm 2; a unit quaternion is needed",
    ),
    "two links": (TREE + '<link name="rod"/>', "two links are named 'rod'"),
    "two joints": (
        TREE
        + '<link name="u"/>'
        + '<joint name="a" type="fixed"><parent link="rod"/><child link="u"/></joint>',
        "two joints are named 'a'",
    ),
    "no axis": (TREE + LINK.format(type="revolute", child="u", more=""), "<axis> is missing"),
    "zero axis": (
        TREE + LINK.format(type="revolute", child="u", more='<axis xyz="0 0 0"/>'),
        "is the zero vector",
    ),
    "NaN": (
        TREE + LINK.format(type="fixed", child="u", more='<origin xyz="nan 0 0"/>'),
        "'nan' is not a finite number",
    ),
    "two numbers": (
        TREE + LINK.format(type="fixed", child="u", more='<origin xyz="1 0"/>'),
        "has 2 numbers; 3 are needed",
    ),
    "unknown type": (
        TREE + LINK.format(type="hinge", child="u", more=""),
        "type = 'hinge' is unknown; allowed: revolute",
    ),
    "unknown child": (
        TREE + LINK.format(type="fixed", child="rodd", more=""),
        "the link 'rodd' is unknown (do you mean 'rod'?)",
    ),
    "two parents": (
        TREE + LINK.format(type="fixed", child="rocker", more=""),
        "child of two joints",
    ),
    "itself": (
        TREE + LINK.format(type="fixed", child="rod", more=""),
        "joins the link 'rod' to itself",
    ),
    "no parent": (
        TREE + '<link name="u"/><joint name="j" type="fixed"><child link="u"/></joint>',
        "<parent> is missing",
    ),
    "mimics itself": (TREE.replace('<origin xyz="1 0 0"/>', '<mimic joint="b"/>'), "mimics itself"),
    "mimics none": (
        TREE.replace('<origin xyz="1 0 0"/>', '<mimic joint="bb"/>'),
        "the joint 'bb' that 'b' mimics is unknown (do you mean 'b'?)",
    ),
    "circle": (
        TREE.replace('<origin xyz="1 0 0"/>', '<mimic joint="c"/>').replace(
            '<origin xyz="0 2 0"', '<mimic joint="b"/><origin xyz="0 2 0"'
        ),
        "in a circle: b, c",
    ),
    "loop to nothing": (
        TREE + FORMS["loop"].replace('"rocker"', '"roker"'),
        "the link 'roker' is unknown (do you mean 'rocker'?)",
    ),
    "loop to itself": (
        TREE + FORMS["loop"].replace('"rocker"', '"rod"'),
        "joins the link 'rod' to itself",
    ),
    "loop of no type": (
        TREE + FORMS["loop"].replace('"revolute"', '"snap"'),
        "type of closure = 'snap' is unknown; allowed: ",
    ),
    "one closing": (
        TREE + FIXED.format(name="closing_d_1", parent="rod", at="0 0 0"),
        "'closing_d_2', is missing",
    ),
    "lost link": (
        TREE + '<link name="u"/>',
        "<link name='u'>: neither joints nor closures join it to the root link 'ground'",
    ),
    "macro": (
        TREE + '<xacro:include filename="x"/>',
        f"line {TREE.count(chr(10)) + 1}: xacro: not XML: unbound prefix",
    ),
    "unknown": (TREE + '<rope><link name="rod"/></rope>', "<rope> is unknown, and it names links"),
    "empty": ("", "no <link> is found"),
    "within a link": (
        TREE
        + FIXED.format(name="u", parent="rod", at="0 0 0")
        + FORMS["loop"].replace('"rocker"', '"u"'),
        "within the one link 'rod', whose two frames are 1 apart",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_one_sentence_with_file_line_and_element(
    case: str, tmp_path: Path
) -> None:
    inside, sentence = BAD[case]
    message = refusal(tmp_path, inside)
    assert sentence in message
    assert message.startswith(str(tmp_path / "r.urdf"))
    assert "line " in message
    assert "\n" not in message


def test_elements_of_no_meaning_are_named(tmp_path: Path) -> None:
    robot = read(
        tmp_path, TREE + '<material name="red"/><drake:linear_bushing_rpy/><note>hello</note>'
    )
    assert (
        "left out, of no meaning here: materials, bushings, which are springs, <note>"
        in robot.notes
    )


# --- a YAML file beside it ------------------------------------------------------------------------

PAIR = FIXED.format(name="d1", parent="rod", at="2 0 0") + FIXED.format(
    name="d2", parent="rocker", at="3 0 0"
)


def test_loops_motors_and_types_beside_the_file(tmp_path: Path) -> None:
    (tmp_path / "r.yaml").write_text(
        "closed_loop: [[d1, d2]]\ntype: [3d]\nname_mot: [a]\njoint_name: [b]\n"
        "joint_type: [UJOINT_ZY]\n"
    )
    robot = read(tmp_path, TREE + PAIR)
    (closure,) = robot.closures
    assert (closure.joint.type, closure.links) == ("S", ("rod", "rocker"))
    joints = {entry.joint.name: entry.joint for entry in robot.tree}
    assert (joints["b"].type, joints["b"].axis, joints["b"].axis2) == (
        "U",
        (0.0, 0.0, 1.0),
        (0.0, 1.0, 0.0),
    )
    assert [name for name, joint in joints.items() if joint.actuated] == ["a"]


def test_frames_beside_the_file_may_be_named_by_their_joints(tmp_path: Path) -> None:
    """As Pinocchio names frames: that of a joint is its child's."""
    (tmp_path / "r.yaml").write_text("closed_loop: [[d1, d2]]\ntype: [3d]")
    by_link = read(tmp_path, TREE + PAIR)
    (tmp_path / "r.yaml").write_text("closed_loop: [[d1_frame, d2]]\ntype: [3d]")
    by_joint = read(tmp_path, TREE + PAIR)
    ((one,), (other,)) = (by_link.closures, by_joint.closures)
    assert one.links == other.links
    np.testing.assert_array_equal(one.frames[0].position, other.frames[0].position)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "closed_loop: [[d1, d9]]\ntype: [3d]",
            "names the frame 'd9', which is no link or joint of r.urdf",
        ),
        ("closed_loop: [[d1, d2]]\ntype: [4d]", "type: '4d' is unknown; allowed: 3d, 6d"),
        ("closed_loop: [[d1, d2]]\ntype: []", "type has 0 entries and closed_loop 1"),
        ("closed_loop: [d1, d2]\ntype: [3d]", "is no list of pairs of links"),
        (
            "closed_loop: [[d1, d2]]\ntype: [3d]\njoint_name: [b]\njoint_type: [HELIX]",
            "joint_type: 'HELIX' is unknown",
        ),
        (
            "closed_loop: [[d1, d2]]\ntype: [3d]\njoint_name: [bb]\njoint_type: [FIXED]",
            "joint_name: 'bb' is no joint of r.urdf",
        ),
        ("closed_loop: [[d1, d2\ntype: [3d]", "not YAML"),
        ("closed_loop: !!python/object:os.system [x]", "not YAML"),
    ],
)
def test_a_file_beside_that_is_wrong_is_named(text: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "r.yaml").write_text(text)
    message = refusal(tmp_path, TREE + PAIR)
    assert sentence in message
    assert str(tmp_path / "r.yaml") in message


def test_a_file_beside_without_loops_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "r.yaml").write_text("gains: [1, 2]\n")
    assert any("r.yaml" in note for note in read(tmp_path, TREE).notes)
