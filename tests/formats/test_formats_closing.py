"""Robots with open loops: the rows of every closure against finite differences, the nearest closed
configuration against the condition of a constrained minimum, and the mechanism assembled there
against its own closure.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.inside import (
    ClosingJoint,
    NearestRoot,
    Robot,
    assembled,
    build_closure,
    close_robot,
    joint_at,
    mechanism_of,
    nearest_closed,
    read_urdf,
    whole_system,
)
from helpers.laws import axis_turn, chain
from helpers.robot_files import closed_neighbours, closure_misfit, rank_at, robot_of
from symkin import Coupling, Joint, LinkJoint, Pose

Z = (0.0, 0.0, 1.0)
ROWS = {"S": 3, "U": 4, "R": 5, "H": 5, "C": 4, "P": 5, "weld": 6}
"""Constraints of a closure of each type: what its freedoms leave of six."""


def random_pose(rng: np.random.Generator, spread: float = 1.0) -> Pose:
    quaternion = rng.normal(size=4)
    return Pose(spread * rng.normal(size=3), quaternion / np.linalg.norm(quaternion))


def near(pose: Pose, rng: np.random.Generator, step: float) -> Pose:
    return pose @ Pose.from_rotation_vector(step * rng.normal(size=3), step * rng.normal(size=3))


def spatial_loop(kind: str, open_by: float, seed: int = 0) -> Robot:
    """Two arms with joints of all types, a link on nothing, and a closure of a type between the
    arms' ends and to the loose link.
    """
    rng = np.random.default_rng(seed)
    joints, links = [], {"base": Pose.identity()}

    def add(name: str, type_: str, pair: tuple[str, str]) -> None:
        axes = [tuple(rng.normal(size=3)) for _ in range(2)]
        joint = Joint(
            name,
            type_,
            tuple(rng.normal(size=3)),
            None if type_ == "S" else axes[0],
            axes[1] if type_ == "U" else None,
            pitch=0.3 if type_ == "H" else 0.0,
            zero=0.4 if type_ in "RPH" else 0.0,
        )
        joints.append(LinkJoint(joint, pair))
        links[pair[1]] = random_pose(rng)

    for k, type_ in enumerate("RPHS"):
        add(f"a{k}", type_, ("base" if k == 0 else f"left{k - 1}", f"left{k}"))
    for k, type_ in enumerate("CURR"):
        add(f"b{k}", type_, ("base" if k == 0 else f"right{k - 1}", f"right{k}"))
    links["loose"] = random_pose(rng)
    frame = random_pose(rng)
    closures = (
        ClosingJoint(
            joint_at(frame, "loop", kind, pitch=0.2 if kind == "H" else 0.0),
            ("left3", "right3"),
            (frame, near(frame, rng, open_by)),
            "",
        ),
        ClosingJoint(
            joint_at(frame, "hang", "S"), ("left3", "loose"), (frame, near(frame, rng, open_by)), ""
        ),
    )
    couplings = (
        Coupling("b2", {"a0": 0.5}, 0.1),
        Coupling("b3", "a0", polynomial=[0.2, 0.3, -0.2]),
    )
    floating = {"loose": links["loose"]}
    return robot_of("loop", links, joints, closures, couplings=couplings, floating=floating)


def four_bar(open_by: float = 0.0, reach: float = 4.0) -> Robot:
    """Crank 1, coupler 4, follower 3, ground `reach`; the coupler's end is a point of the tree."""
    joints = [
        LinkJoint(Joint("crank", "R", (0, 0, 0), Z), ("base", "arm")),
        LinkJoint(Joint("knee", "R", (0, 1, 0), Z), ("arm", "coupler")),
        LinkJoint(Joint("follower", "R", (reach, 0, 0), Z), ("base", "lever")),
    ]
    links = dict.fromkeys(("base", "arm", "coupler", "lever"), Pose.identity())
    first = Pose(np.array([4.0, 1.0, 0.0]), np.array([1.0, 0, 0, 0]))
    second = Pose(np.array([reach, 3.0 + open_by, 0.0]), np.array([1.0, 0, 0, 0]))
    end = joint_at(first, "end", "R")
    closure = ClosingJoint(end, ("coupler", "lever"), (first, second), "line 9")
    return robot_of("four_bar", links, joints, [closure])


@pytest.mark.parametrize("kind", ROWS)
def test_derivatives_are_finite_differences(kind: str) -> None:
    """Rows of every closure and coupling, at random states near a closed one (the angle of a screw
    is about a common axis there).
    """
    found = nearest_closed(spatial_loop(kind, 0.05))
    assert found.closed
    tree, state, rng = found.tree, found.state, np.random.default_rng(1)
    if kind != "H":
        step = 0.3 * tree.size * rng.normal(size=(1, tree.freedom))
        (state,) = tree.system.move(state[None], step)
    _, jacobian = tree.system.linearise_one(state, np.zeros(0))
    length = 1e-6 * tree.size
    for k, unit in enumerate(np.eye(tree.freedom)):
        ends = tree.system.move(np.tile(state, (2, 1)), length * np.array([unit, -unit]))
        ahead, behind = tree.system.linearise(ends, np.zeros(0))[0]
        np.testing.assert_allclose((ahead - behind) / (2 * length), jacobian[:, k], atol=2e-8)


@pytest.mark.parametrize("kind", ROWS)
def test_ranks_are_the_constraints_of_the_type(kind: str) -> None:
    """Of a loop in general position: as many as the joint's freedoms leave of 6, with the ball's 3
    and the two couplings.
    """
    robot = spatial_loop(kind, 0.05)
    found = nearest_closed(robot)
    assert rank_at(found.tree, found.state) == ROWS[kind] + 3 + 2 == found.tree.system.rows.shape[0]
    assert [rank_at(found.tree, state) for state in closed_neighbours(found, 2, 0)] == [
        rank_at(found.tree, found.state)
    ] * 2


@pytest.mark.parametrize("kind", ["S", "R", "U"])
def test_the_nearest_closed_configuration(kind: str) -> None:
    """The way from the file's own configuration is square to the closed ones: the condition of the
    least distance.
    """
    found = nearest_closed(spatial_loop(kind, 0.1))
    assert found.closed
    assert found.open_by > 0.01
    way = NearestRoot(found.tree.system, found.tree.own).way_from(found.state)
    _, s, vt = np.linalg.svd(found.tree.system.linearise_one(found.state, np.zeros(0))[1])
    free = vt[int(np.sum(s > 1e-8 * s[0])) :]
    assert np.linalg.norm(free @ way) <= 1e-3 * np.linalg.norm(way)


def wrist(seed: int, joints: int = 5) -> str:
    """A URDF of hinges whose axes meet in a point, but for six digits, in one loop."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(joints, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    reach = 0.2 * rng.uniform(0.5, 1.5, (joints, 1))
    points = np.round(0.1 * rng.normal(size=3) + axes * reach, 6)
    steps = np.diff(points, axis=0, prepend=np.zeros((1, 3)))

    def numbers(vector: np.ndarray) -> str:
        return " ".join(f"{x:.6f}" for x in vector)

    links = [f"<link name='l{k}'/>" for k in range(joints)]
    hinges = [
        f"<joint name='j{k}' type='continuous'><parent link='l{k}'/><child link='l{k + 1}'/>"
        f"<origin xyz='{numbers(steps[k])}'/><axis xyz='{numbers(axes[k])}'/></joint>"
        for k in range(joints - 1)
    ]
    end = numbers(steps[-1] + [0.0, 1e-6, -1e-6])
    loop = (
        f"<loop_joint name='end' type='revolute'><axis xyz='{numbers(axes[-1])}'/>"
        f"<link1 link='l0' xyz='{numbers(points[-1])}'/><link2 link='l{joints - 1}' xyz='{end}'/>"
        "</loop_joint>"
    )
    return f"<robot name='wrist'>{''.join([*links, *hinges, loop])}</robot>"


@pytest.mark.parametrize("seed", range(4))
def test_what_closes_to_digits_alone_is_the_nearest_that_does(seed: int, tmp_path: Path) -> None:
    """Redundant rows of rounded numbers close exactly far away, if anywhere: a file that is closed
    to its digits stays there, and the way from a start that is open is square to what is free to
    digits.
    """
    path = tmp_path / "wrist.urdf"
    path.write_text(wrist(seed))
    found = nearest_closed(read_urdf(path))
    tree = found.tree
    assert 1e-6 < found.open_by < 2e-6
    assert found.to_digits
    assert np.abs(found.state - tree.own).max() <= 1e-4
    step = 0.1 * tree.size * np.random.default_rng(seed).normal(size=(1, tree.freedom))
    (start,) = tree.system.move(tree.own[None], step)
    search = NearestRoot(tree.system, start)
    end = search.found()
    assert tree.system.residual(end) <= 1e-5 * tree.size
    way = search.way_from(end)
    _, s, vt = np.linalg.svd(tree.system.linearise_one(end, np.zeros(0))[1])
    free = vt[int(np.sum(s > 1e-5 * s[0])) :]
    assert len(free) == 2
    assert np.linalg.norm(free @ way) <= 1e-3 * np.linalg.norm(way)


def test_a_closed_file_stays_as_it_is() -> None:
    found = nearest_closed(four_bar(reach=4.0, open_by=-2.0))
    assert found.open_by == 0.0
    assert found.values == {"crank": (0.0,), "knee": (0.0,), "follower": (0.0,)}


@pytest.mark.parametrize("kind", ROWS)
def test_the_assembled_mechanism_is_closed_and_has_the_mobility(kind: str) -> None:
    """The frames of every closure meet as its type says; the mechanism's reference leaves no row of
    its own closure; its freedoms less its rank are those of the
    tree less the closures' rank, but for idle spins; its joints tell the closed values at the
    reference.
    """
    robot = spatial_loop(kind, 0.05)
    found = nearest_closed(robot)
    misfits = [closure_misfit(closure, found.displacements) for closure in robot.closures]
    assert max(misfits) <= 1e-9 * found.tree.size
    mechanism = assembled(robot, found)
    closure = build_closure(mechanism)
    assert whole_system(closure).residual(closure.reference, np.zeros(0)) <= 1e-9 * found.tree.size
    counted = symkin.mobility(mechanism)
    assert (
        counted.mobility
        <= found.tree.freedom - rank_at(found.tree, found.state)
        <= counted.mobility + 3
    )
    zeros = {
        e.joint.name: e.joint.zero
        for e in mechanism.link_joints
        if e.joint.name in ("a0", "a1", "a2", "b2", "b3")
    }
    assert zeros == {name: found.values[name][0] for name in zeros}


def test_axes_of_the_assembled_mechanism_are_moved_with_their_links() -> None:
    """Of the arm C U R R of a loop that was open: points and axes where the displacements of the
    joints before them lead, the second axis of the universal joint behind its first turn.
    """
    robot = spatial_loop("S", 0.3)
    found = nearest_closed(robot)
    made = {entry.joint.name: entry.joint for entry in mechanism_of(robot).link_joints}
    arm = [entry.joint for entry in robot.tree if entry.joint.name.startswith("b")]
    values = {name: float(value[0]) for name, value in found.values.items() if len(value) == 1}
    assert abs(values["b1.1"]) > 1e-3
    for count, joint in enumerate(arm):
        before = chain(arm[:count], values)
        line = before[:3, :3] @ joint.axis
        np.testing.assert_allclose(made[joint.name].axis, line, atol=1e-9)
        offset = before[:3, :3] @ joint.point + before[:3, 3] - made[joint.name].point
        assert np.linalg.norm(np.cross(offset, line)) < 1e-9
        if joint.axis2 is not None:
            turned = before[:3, :3] @ axis_turn(joint.axis, values["b1.1"]) @ joint.axis2
            np.testing.assert_allclose(made[joint.name].axis2, turned, atol=1e-9)


def test_couplings_of_universal_joints_hold_at_the_closed_reference() -> None:
    """A turn of a universal joint counts from the reference of the mechanism, which is not the
    file's where loops were open: the coupling that names it is written for that.
    """
    robot = replace(spatial_loop("S", 0.3), couplings=(Coupling("b2", {"b1.1": 0.5}, 0.1),))
    found = nearest_closed(robot)
    assert abs(found.values["b1.1"][0]) > 0.1
    closure = build_closure(assembled(robot, found))
    assert whole_system(closure).residual(closure.reference) <= 1e-9 * found.tree.size


def test_link_poses_are_those_of_the_tree() -> None:
    """A closed neighbour by the tree's joints, and the same values in the assembled mechanism: the
    same displacements of links.
    """
    robot = four_bar(open_by=0.3)
    found = nearest_closed(robot)
    mechanism = mechanism_of(robot)
    tree = found.tree
    for state in closed_neighbours(found, 3, 1):
        placed = tree.displacements(state)
        values = {name: value for name, (value,) in tree.by_name(state).items()}
        modes = symkin.modes(mechanism, given={"crank": values["crank"]})
        assert len(modes) == 2
        mode = min(modes, key=lambda mode: abs(mode.joints["follower"] - values["follower"]))
        assert mode.joints["follower"] == pytest.approx(values["follower"], abs=1e-9)
        for link in ("arm", "coupler", "lever"):
            moved = placed[link] @ found.displacements[link].inverse()
            np.testing.assert_allclose(mode.link_poses[link].matrix, moved.matrix, atol=1e-9)


def test_two_hinges_with_one_axis_forbid_nothing() -> None:
    """All their rows vanish but for rounding, which is no rank."""
    tilted = tuple(np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8]))
    frame = Pose.from_rotation_vector(np.array([1.1, 2.2, 3.3]), np.array([0.2, 0.7, -0.4]))
    axis = tuple(np.asarray(frame.rotation)[:, 2])
    hinge = LinkJoint(Joint("hinge", "R", tuple(frame.position), axis), ("base", "door"))
    other = ClosingJoint(joint_at(frame, "other", "R"), ("base", "door"), (frame, frame), "")
    links = {"base": Pose.identity(), "door": Pose.identity()}
    robot = robot_of("door", links, [hinge], [other])
    found = nearest_closed(robot)
    assert rank_at(found.tree, found.state) == 0
    assert symkin.mobility(mechanism_of(robot)).mobility == 1
    tilted_hinge = replace(hinge, joint=replace(hinge.joint, axis=tilted))
    across = robot_of("door", links, [tilted_hinge], [other])
    found = nearest_closed(across)
    assert rank_at(found.tree, found.state) == 1


def test_digits_that_make_constraints_of_redundant_ones_are_told() -> None:
    """A four-bar, closed in the file, with one axis 1e-7 rad off the others: rigid to the letter,
    one freedom to the digits.
    """
    robot = four_bar(reach=4.0)
    *others, follower = robot.tree
    off = replace(follower.joint, axis=(1e-7, 0.0, 1.0))
    (end,) = robot.closures
    closed = replace(end, frames=(end.frames[0], end.frames[0]))
    robot = robot_of(robot.name, robot.links, [*others, LinkJoint(off, follower.links)], [closed])
    found, account = close_robot(robot), symkin.mobility(mechanism_of(robot))
    assert (account.mobility, account.to_dict()["to_digits"]["mobility"]) == (0, 1)
    assert "close only to the digits of the file" in account.warnings[0]
    assert (found.rank, found.generic_rank) == (3, 2)
    assert any(
        "the digits of the file make constraints of what is redundant: the rank is 3 here, and 2"
        in n
        for n in found.notes
    )


@cache
def too_long():
    """The least misfit of a four-bar whose ground link is longer than the others together."""
    return nearest_closed(four_bar(reach=9.0))


def test_loops_that_nothing_closes() -> None:
    """A ground link longer than the others together: the least misfit is what is missing, and the
    loop is named with its place.
    """
    found = too_long()
    assert not found.closed
    assert found.residual == pytest.approx(9.0 - (1.0 + 4.0 + 3.0), abs=1e-3)
    with pytest.raises(
        symkin.MechanismError, match=r"leaves 1 m, most of it in the loop of end \(line 9\)"
    ):
        mechanism_of(four_bar(reach=9.0))


@pytest.mark.parametrize("turns", [-4, 2, 3])
def test_turns_of_coupled_joints_count_while_loops_close(turns: int) -> None:
    """A pinion coupled to a lever of a loop, several turns off in the file: whole turns of coupled
    joints are kept, those of others are left out.
    """
    bar = four_bar(open_by=-1.5)
    pinion = LinkJoint(Joint("pinion", "R", (0, 0, 1), Z), ("base", "wheel"))
    links = {**bar.links, "wheel": Pose.identity()}
    coupling = Coupling("pinion", {"follower": 1.5}, 2 * np.pi * turns)
    joints = [*bar.tree, pinion]
    found = nearest_closed(robot_of("bar", links, joints, bar.closures, couplings=[coupling]))
    values = {name: float(value) for name, (value,) in found.values.items()}
    assert found.closed
    assert abs(values["pinion"]) > 1.1 * np.pi
    assert values["pinion"] == pytest.approx(1.5 * values["follower"] + 2 * np.pi * turns, abs=1e-9)
    far = found.state + [6 * np.pi * (c.name == "knee") for c in found.tree.coordinates]
    search = NearestRoot(found.tree.system, found.tree.own)
    np.testing.assert_allclose(search.without_turns(far), found.state, atol=1e-9)
