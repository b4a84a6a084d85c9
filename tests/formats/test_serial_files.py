"""Serial equivalents of robots with closed linkages: what is written, read back by symkin, MuJoCo
and Pinocchio.
"""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import symkin
from helpers.inside import app, largest_box, write_serial
from helpers.needed import Later, needs
from symkin import InputError, MechanismError

mujoco, pinocchio = Later("mujoco"), Later("pinocchio")
ANKLE = str(Path(__file__).parents[1] / "data" / "models" / "mjcf" / "g1_parallel_ankle.xml")
MOTORS, JOINTS = ["left_motor_joint", "right_motor_joint"], ["pitch_joint", "roll_joint"]
RANGES = {"pitch_joint": [-0.6, 0.4], "roll_joint": [-0.25, 0.25]}
TOLD = {"inertia": 2e-3, "torque_limits": 20.0, "speed_limits": 30.0}


@pytest.fixture(scope="module")
def ankle():
    """The robot and its transmission."""
    robot = symkin.load(ANKLE)
    return robot, symkin.transmission(robot, MOTORS, JOINTS, ranges=RANGES, **TOLD)


@pytest.fixture(scope="module")
def files(ankle, tmp_path_factory):
    folder = tmp_path_factory.mktemp("serial")
    for suffix in (".urdf", ".xml"):
        write_serial(ankle[0], [ankle[1]], folder / f"ankle{suffix}")
    return folder


@needs("mujoco")
@needs("pinocchio")
def test_the_tree_is_where_the_robot_is(ankle, files):
    """At joint values that the motors reach, links of the serial files are displaced as those of
    the original model: MuJoCo's of the original, MuJoCo's and Pinocchio's of the written ones.
    """
    _, transmission = ankle
    states = transmission.survey.states
    original, written = (
        mujoco.MjModel.from_xml_path(str(file)) for file in (ANKLE, files / "ankle.xml")
    )
    tree = pinocchio.buildModelFromUrdf(str(files / "ankle.urdf"))
    assert [list(tree.names)[1:], tree.nq, written.nq, written.neq] == [JOINTS, 2, 2, 0]
    placed = tree.createData()

    def of_mujoco(model, values):
        data = mujoco.MjData(model)
        for name, value in zip(JOINTS, values, strict=True):
            data.qpos[model.joint(name).qposadr[0]] = value
        mujoco.mj_kinematics(model, data)
        found = {}
        for link in ("pitch_link", "roll_link"):
            found[link] = np.eye(4)
            found[link][:3, :3] = data.body(link).xmat.reshape(3, 3)
            found[link][:3, 3] = data.body(link).xpos
        return found

    def of_pinocchio(values):
        pinocchio.framesForwardKinematics(tree, placed, np.asarray(values))
        links = ("pitch_link", "roll_link")
        return {link: placed.oMf[tree.getFrameId(link)].homogeneous.copy() for link in links}

    home = [of_mujoco(original, [0.0, 0.0]), of_mujoco(written, [0.0, 0.0]), of_pinocchio([0, 0])]
    for values in states.joints[:: max(1, len(states.joints) // 40)]:
        now = [of_mujoco(original, values), of_mujoco(written, values), of_pinocchio(values)]
        for link in home[0]:
            moved = [
                at[link] @ np.linalg.inv(began[link]) for at, began in zip(now, home, strict=True)
            ]
            np.testing.assert_allclose(moved[1], moved[0], rtol=0, atol=1e-9)
            np.testing.assert_allclose(moved[2], moved[0], rtol=0, atol=1e-9)


def test_files_hold_ranges_efforts_speeds_and_inertias(ankle, files):
    """symkin reads two driven joints with the original's screws and the told ranges from either
    file; MuJoCo's armature is the reflected inertia, its efforts and URDF's are one box within all
    torque polytopes, of which some motor is at its limit.
    """
    robot, transmission = ankle
    screws = {entry.joint.name: entry.joint for entry in robot.link_joints}
    for suffix in (".urdf", ".xml"):
        read = symkin.load(files / f"ankle{suffix}")
        assert [c.name for c in read.actuated] == JOINTS
        assert len(read.coordinates) == 2
        for entry in read.link_joints:
            joint, its = entry.joint, screws[entry.joint.name]
            np.testing.assert_allclose(joint.axis, its.axis, atol=1e-12)
            np.testing.assert_allclose(joint.point, its.point, atol=1e-12)
            low, high = RANGES[joint.name]
            assert low - 1e-6 <= joint.limits[0] < joint.limits[1] <= high + 1e-6
    model = mujoco.MjModel.from_xml_path(str(files / "ankle.xml"))
    inertia = transmission.inertia(joints=[0.0, 0.0])
    np.testing.assert_allclose(model.dof_armature, np.diag(inertia), rtol=1e-9)
    tree = pinocchio.buildModelFromUrdf(str(files / "ankle.urdf"))
    states, efforts = transmission.survey.states, tree.effortLimit
    np.testing.assert_allclose(model.jnt_actfrcrange[:, 1], efforts)
    for matrices, box, limit in (
        (states.jacobian.transpose(0, 2, 1), efforts, TOLD["torque_limits"]),
        (states.inverse_jacobian, tree.velocityLimit, TOLD["speed_limits"]),
    ):
        corners = np.array(list(itertools.product([-1.0, 1.0], repeat=2))) * box
        shares = np.abs(np.einsum("kmi,ci->kcm", matrices, corners)) / limit
        assert shares.max() == pytest.approx(1.0, abs=1e-9)
    text = (files / "ankle.urdf").read_text()
    assert "armature of pitch_joint" in text
    assert "the limit of roll_joint" in text
    assert "at the reference" in text


def test_no_box_within_the_limits_is_larger():
    """Of random effects on three joints, boxes of random proportions that keep all limits have no
    larger volume.
    """
    rng = np.random.default_rng(2)
    effects = rng.normal(size=(50, 4, 3))
    limits = np.sort(rng.uniform(0.5, 2.0, (4, 2)), axis=1) * [-1.0, 1.0]
    box = largest_box(effects, limits, "torque_limits")
    rows = np.abs(effects) / np.minimum(-limits[:, 0], limits[:, 1])[:, None]
    assert (rows @ box).max() == pytest.approx(1.0, abs=1e-12)
    shapes = np.exp(rng.normal(size=(4000, 3))) * box
    others = shapes / np.einsum("kmi,ci->ckm", rows, shapes).max(axis=(1, 2))[:, None]
    assert others.prod(axis=1).max() <= box.prod() * (1 + 1e-9)
    with pytest.raises(InputError, match="0 must be within the limits"):
        largest_box(effects, np.abs(limits) + [[0.0, 2.0]], "torque_limits")


def test_two_coordinates_of_a_joint_are_two_joints_in_metres(tmp_path):
    """The shipped ankle, in mm, with its motors at some angles: the foot of the serial file is
    where the closed one is; nothing is told of its motors, and nothing of them is written.
    """
    ankle = symkin.load("ankle")
    names, bare = (
        ["ankle.1", "ankle.2"],
        replace(ankle, platform_link=None, platform_position=[0] * 3),
    )
    transmission = symkin.transmission(bare, ["upper_motor", "lower_motor"], names)
    notes = write_serial(ankle, [transmission], tmp_path / "ankle.xml")
    assert "not told of the motors" in notes[-1]
    read = symkin.load(tmp_path / "ankle.xml")
    assert [c.name for c in read.actuated] == names
    for motors in ([10.0, -5.0], [-8.0, 12.0]):
        closed = symkin.solve(ankle, joints=motors).solution
        angles = np.radians(transmission.joints_of(motors))
        serial = symkin.solve(read, joints=angles).solution
        there, wanted = serial.pose, closed.pose
        np.testing.assert_allclose(there.position, np.asarray(wanted.position) / 1000, atol=1e-9)
        alike = abs(np.dot(there.quaternion, wanted.quaternion))
        assert alike == pytest.approx(1.0, abs=1e-12)
    text = (tmp_path / "ankle.xml").read_text()
    assert "armature=" not in text
    assert "ctrlrange" not in text


def test_what_hangs_on_a_left_out_link_is_named(tmp_path):
    """A hand on the crank of a four-bar linkage, whose follower alone is driven; on the coupler,
    to which no one joint leads; another suffix.
    """
    four_bar = symkin.load("four_bar")
    for link, error, sentence in (
        ("crank_link", MechanismError, "hand is on the link 'crank_link', which only joints"),
        ("coupler", InputError, "'coupler', .*, is by crank, .*, of which the linkage leaves 1"),
    ):
        hand = symkin.LinkJoint(
            symkin.Joint("hand", "R", [0, 90, 0], [0, 0, 1], actuated=True), [link, "palm"]
        )
        robot = symkin.Mechanism(
            "robot",
            link_joints=[*four_bar.link_joints, hand],
            length_unit="mm",
            angle_unit="deg",
        )
        transmission = symkin.transmission(robot, ["crank"], ["follower"])
        with pytest.raises(error, match=sentence):
            write_serial(robot, [transmission], tmp_path / "robot.urdf")
    with pytest.raises(InputError, match=r"another suffix than \.urdf, \.xml"):
        write_serial(robot, [transmission], tmp_path / "robot.stl")
    held = symkin.transmission(robot, ["crank"], ["follower"], ranges={"follower": [170, 175]})
    with pytest.raises(InputError, match="follower: within the limits of its linkage"):
        write_serial(four_bar, [held], tmp_path / "robot.urdf")
    assert list(tmp_path.iterdir()) == []
    arm = symkin.LinkJoint(
        symkin.Joint("tool", "R", [110, 90, 0], [0, 0, 1], actuated=True), ["rocker", "palm"]
    )
    robot = symkin.Mechanism(
        "robot", link_joints=[*four_bar.link_joints, arm], length_unit="mm", angle_unit="deg"
    )
    write_serial(robot, [transmission], tmp_path / "robot.urdf")
    read = symkin.load(tmp_path / "robot.urdf")
    assert {c.name for c in read.actuated} == {"follower", "tool"}
    assert not read.link_rods


def test_the_command_writes_serial_file_and_c(tmp_path):
    """--serial and --format of `symkin transmission`: the robot without its loop, and C with its
    header for C++ and the ROS 2 package.
    """
    told = ["--motors", "crank", "--joints", "follower", "--serial", str(tmp_path / "serial.urdf")]
    done = CliRunner().invoke(
        app, ["transmission", "four_bar", *told, "--format", "ros2", "-o", str(tmp_path / "c")]
    )
    assert done.exit_code == 0, done.output
    assert "range of follower" in done.stderr
    assert [c.name for c in symkin.load(tmp_path / "serial.urdf").coordinates] == ["follower"]
    for file in ("four_bar.c", "four_bar.hpp", "ros2/four_bar_transmission.hpp"):
        assert (tmp_path / "c" / file).is_file()
