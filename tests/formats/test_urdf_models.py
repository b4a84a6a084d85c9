"""Real robots in URDF against data of their own: the counts and the closed configuration of an
independent solver, Pinocchio's trees.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from helpers.inside import (
    Robot,
    exponential,
    nearest_closed,
    read_urdf,
    revolute_screw,
)
from helpers.robot_files import (
    MODELS,
    all_frames,
    closed_neighbours,
    closure_misfit,
    facts,
    joint_misfit,
    poses_at,
    rank_at,
    told_poses,
)
from symkin import Joint, Pose, load, mobility

NAMES = (
    "urdf_gepetto_yaml/5bar_linkage_iso3d",
    "urdf_gepetto_yaml/digit_like_2legs",
    "urdf_loop_joint/strandbeest",
    "urdf_onshape_closing/reachy_mini",
    "urdf_plus/four_bar",
    "urdf_plus/six_bar",
)
KINDS = {"R": "revolute", "S": "ball", "U": "universal", "weld": "fixed"}
TOLD_TO = 1e-10
"""Metres: the JSON holds body poses to twelve digits."""


def robot(name: str) -> Robot:
    return read_urdf(MODELS / f"{name}.urdf")


@pytest.mark.parametrize("name", NAMES)
def test_counts_are_those_of_an_independent_reader(name: str) -> None:
    data, found = facts(name), robot(name)
    assert len(found.frames) == data["bodies"]
    assert len(found.closures) == data["independent_loops"]
    assert len(found.tree) == len(found.links) - 1
    kinds = Counter(KINDS[joint.joint.type] for joint in found.tree)
    kinds.update(KINDS[closure.joint.type] for closure in found.closures)
    fixed = len(found.frames) - len(found.links)
    kinds.update({"fixed": fixed} if fixed else {})
    assert dict(kinds) == {key: count for key, count in data["joints"].items() if count}
    if "actuated" in data:
        assert {joint.joint.name for joint in found.tree if joint.joint.actuated} == set(
            data["actuated"]
        )


@pytest.mark.parametrize("name", NAMES)
def test_a_configuration_that_closes_elsewhere_closes_here(name: str) -> None:
    """Joints let the links take the poses of the JSON, merged bodies go with their links, and all
    closures are closed there.
    """
    found = robot(name)
    data = facts(name)
    told, cut = told_poses(data, found), {joint["name"] for joint in data["cut_joints"]}
    moved = {link: told[link] @ pose.inverse() for link, pose in found.links.items()}
    for link, (carrier, pose) in all_frames(found).items():
        assert np.allclose(
            np.asarray((moved[carrier] @ pose).matrix), np.asarray(told[link].matrix), atol=TOLD_TO
        )
    for entry in found.tree:
        first, second = (moved[link] for link in entry.links)
        misfit = joint_misfit(entry.joint, first.inverse() @ second)
        if entry.joint.name in cut:
            # the solver of the JSON asks of a joint that it cut that the axes are parallel: they
            # may be opposite
            misfit = min(
                misfit, joint_misfit(entry.joint, first.inverse() @ second @ flipped(entry.joint))
            )
        assert misfit < TOLD_TO, entry.joint.name
    for closure in found.closures:
        assert closure_misfit(closure, moved) < TOLD_TO, closure.joint.name


def flipped(joint: Joint) -> Pose:
    """Half a turn about a line through the joint's point, square to its axis."""
    point, axis = np.array(joint.point), np.array(joint.axis)
    across = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    return exponential(revolute_screw(point, across / np.linalg.norm(across)), np.pi)


@pytest.mark.parametrize("name", [name for name in NAMES if "digit" not in name])
def test_trees_are_those_of_pinocchio(name: str) -> None:
    """Link poses at random joint values, in the root's frame."""
    pin = pytest.importorskip("pinocchio")
    found = robot(name)
    model = pin.buildModelFromUrdf(str(MODELS / f"{name}.urdf"))
    data, rng = model.createData(), np.random.default_rng(15)
    values = {joint.joint.name: float(rng.uniform(-1, 1)) for joint in found.joints}
    q = pin.neutral(model)
    for k, joint in enumerate(model.joints):
        if k and joint.nq == 1:
            q[joint.idx_q] = values[model.names[k]]
        elif k:
            q[joint.idx_q : joint.idx_q + 2] = (
                np.cos(values[model.names[k]]),
                np.sin(values[model.names[k]]),
            )
    pin.framesForwardKinematics(model, data, q)
    own = poses_at(found, values)
    bodies = [
        frame for frame in model.frames if frame.type == pin.FrameType.BODY and frame.name in own
    ]
    assert len(bodies) == len(own) - 1
    for frame in bodies:
        other = data.oMf[model.getFrameId(frame.name, pin.FrameType.BODY)].homogeneous
        assert np.allclose(np.asarray(own[frame.name].matrix), other, atol=1e-10), frame.name


def test_retyped_joints_turn_as_the_file_beside_tells() -> None:
    """A universal joint by the axes x and then y of the joint's own frame."""
    found = robot("urdf_gepetto_yaml/digit_like_2legs")
    joint = next(entry for entry in found.tree if entry.joint.name == "spherical_free_knee")
    told = facts("urdf_gepetto_yaml/digit_like_2legs")
    poses = told_poses(told, found)
    first, second = (poses[link] @ found.links[link].inverse() for link in joint.links)
    between: Pose = first.inverse() @ second
    axis, axis2 = np.array(joint.joint.axis), np.array(joint.joint.axis2)
    angles = told["tree_coordinates"]["spherical_free_knee"]
    turned = (
        Pose.from_rotation_vector([0, 0, 0], angles[0] * axis).rotation
        @ Pose.from_rotation_vector([0, 0, 0], angles[1] * axis2).rotation
    )
    assert np.allclose(np.asarray(between.rotation), np.asarray(turned), atol=TOLD_TO)


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.long] if "strandbeest" in n else []) for n in NAMES]
)
def test_mobility_is_that_of_an_independent_solver(name: str) -> None:
    """At the closed configuration nearest to the file's and at closed neighbours. Where the same
    joints are cut, the rank as well; the four-bar is singular in its file, and a neighbour is not.
    """
    data, closed = facts(name), nearest_closed(robot(name))
    assert closed.closed
    assert (
        closed.tree.freedom - rank_at(closed.tree, closed.state)
        == data["mobility_at_configuration"]
    )
    if closed.tree.freedom == data["coordinates"]:
        assert rank_at(closed.tree, closed.state) == data["rank_at_configuration"]
    near = closed_neighbours(closed, 2, seed=0)
    assert near
    assert {closed.tree.freedom - rank_at(closed.tree, state) for state in near} == {
        data["mobility_generic"]
    }


@pytest.mark.parametrize(
    "name",
    [
        "urdf_gepetto_yaml/5bar_linkage_iso3d",
        "urdf_plus/six_bar",
        "urdf_onshape_closing/reachy_mini",
    ],
)
def test_a_file_loads_as_a_closed_mechanism(name: str) -> None:
    """All joints of the tree and all closures are joints of the graph, which is closed at its
    reference.
    """
    mechanism, found = load(MODELS / f"{name}.urdf"), robot(name)
    assert len(mechanism.link_joints) == len(found.joints)
    assert (mechanism.length_unit, mechanism.angle_unit) == ("m", "rad")
    assert mobility(mechanism).mobility == facts(name)["mobility_at_configuration"]


@pytest.mark.parametrize(
    ("name", "pairs"),
    [
        ("urdf_gepetto_yaml/5bar_linkage_iso3d", [("closedloop3D_1B", "closedloop3D_1A")]),
        (
            "urdf_onshape_closing/reachy_mini",
            [(f"closing_{k}_1", f"closing_{k}_2") for k in range(1, 6)],
        ),
    ],
)
def test_closed_configurations_are_those_of_pinocchio(
    name: str, pairs: list[tuple[str, str]]
) -> None:
    """At the closed configuration and at closed neighbours: its link poses, its closed frames, the
    rank of its constraints.
    """
    pin = pytest.importorskip("pinocchio")
    found = robot(name)
    closed = nearest_closed(found)
    model = pin.buildModelFromUrdf(str(MODELS / f"{name}.urdf"))
    data = model.createData()
    states = [closed.state, *closed_neighbours(closed, 3, seed=2)]
    assert len(states) > 1
    for state in states:
        values = {name: value for name, (value,) in closed.tree.by_name(state).items()}
        q = np.array([values[model.names[k]] for k in range(1, model.njoints)])
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        own = closed.tree.displacements(state)
        for body, (carrier, pose) in all_frames(found).items():
            if body != "base":
                other = data.oMf[model.getFrameId(body, pin.FrameType.BODY)].homogeneous
                assert np.allclose(np.asarray((own[carrier] @ pose).matrix), other, atol=1e-10), (
                    body
                )
        rows = []
        for pair in pairs:
            frames = [model.getFrameId(link, pin.FrameType.BODY) for link in pair]
            first, second = (data.oMf[frame].translation for frame in frames)
            assert np.allclose(first, second, atol=1e-10)
            jacobians = [
                pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
                for frame in frames
            ]
            rows.append(jacobians[0] - jacobians[1])
        assert np.linalg.matrix_rank(np.vstack(rows), tol=1e-8) == rank_at(closed.tree, state)
