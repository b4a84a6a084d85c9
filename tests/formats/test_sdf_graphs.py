"""Random graphs of joints in SDF, with all types and any number of loops: mobility and motion are
those of the joints as they were made.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from helpers.inside import Robot, euler_from_quaternion, nearest_closed, read_sdf
from helpers.robot_files import closed_neighbours, joint_misfit, rank_at
from symkin import Joint, Pose

WORDS = {
    "R": "revolute",
    "P": "prismatic",
    "H": "screw",
    "U": "universal",
    "S": "ball",
    "weld": "fixed",
}


@dataclass
class Made:
    """Link poses in the model's frame, and joints with their two links, all in that frame."""

    links: list[Pose]
    joints: list[tuple[Joint, int, int]]


def made(seed: int) -> Made:
    """A tree of random joints and some joints more; all of them told at random poses, so that every
    loop is closed there.
    """
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 9))
    links = [
        Pose.from_euler(rng.uniform(-1, 1, 3), rng.uniform(-1.5, 1.5, 3), "xyz")
        for _ in range(count)
    ]
    pairs = [(int(rng.integers(0, k)), k) for k in range(1, count)]
    for _ in range(int(rng.integers(1, 4))):
        a, b = (int(k) for k in rng.choice(count, 2, replace=False))
        pairs.append((a, b))
    order = rng.permutation(len(pairs))
    types = rng.choice(list(WORDS), len(pairs), p=[0.4, 0.12, 0.12, 0.14, 0.14, 0.08])
    joints = []
    for k in order:
        a, b = pairs[k] if rng.random() < 0.5 else pairs[k][::-1]
        kind, axis = str(types[k]), _direction(rng)
        second = np.cross(axis, _direction(rng))
        joints.append(
            (
                Joint(
                    f"j{k}",
                    kind,  # type: ignore[arg-type]
                    rng.uniform(-1, 1, 3),
                    None if kind in ("S", "weld") else axis,
                    second / np.linalg.norm(second) if kind == "U" else None,
                    pitch=0.3 if kind == "H" else 0.0,
                ),
                a,
                b,
            )
        )
    return Made(links, joints)


def _direction(rng: np.random.Generator) -> np.ndarray:
    vector = rng.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def text(machine: Made) -> str:
    """The machine in SDF: joints in their child's frame, axes in the joint's."""
    links = "".join(
        f"<link name='l{k}'><pose>{_pose(pose)}</pose></link>"
        for k, pose in enumerate(machine.links)
    )
    joints = "".join(_joint(machine, *entry) for entry in machine.joints)
    return f"<sdf version='1.7'><model name='m'>{links}{joints}</model></sdf>"


def _joint(machine: Made, joint: Joint, parent: int, child: int) -> str:
    turn = Pose.from_euler(np.array(joint.point), np.array([0.3, 0.2, 0.1]), "xyz")
    axes = "".join(
        f"<{tag}><xyz>{_words(np.asarray(turn.inverse().turn(np.array(axis))))}</xyz></{tag}>"
        for tag, axis in (("axis", joint.axis), ("axis2", joint.axis2))
        if axis is not None
    )
    pitch = f"<screw_thread_pitch>{joint.pitch!r}</screw_thread_pitch>" if joint.pitch else ""
    return (
        f"<joint name='{joint.name}' "
        f"type='{WORDS[joint.type]}'><parent>l{parent}</parent><child>l{child}</child>"
        f"<pose>{_pose(machine.links[child].inverse() @ turn)}</pose>{axes}{pitch}</joint>"
    )


def _pose(pose: Pose) -> str:
    angles = euler_from_quaternion(pose.quaternion, "xyz")
    return f"{_words(np.asarray(pose.position))} {_words(np.asarray(angles))}"


def _words(vector: np.ndarray) -> str:
    return " ".join(repr(float(c)) for c in vector)


def freedoms(machine: Made) -> int:
    """Dimension of all link twists and joint rates with v(child) - v(parent) = sum of the joint's
    screws x rates, link 0 held.
    """
    count = len(machine.links)
    blocks = []
    for joint, parent, child in machine.joints:
        screws = _screws(joint)
        row = np.zeros((6, 6 * count))
        row[:, 6 * child : 6 * child + 6] += np.eye(6)
        row[:, 6 * parent : 6 * parent + 6] -= np.eye(6)
        # what no rate of the joint does: the part of the twist off its screws
        blocks.append((np.eye(6) - screws @ np.linalg.pinv(screws)) @ row if screws.size else row)
    held = np.eye(6, 6 * count)
    return 6 * count - int(np.linalg.matrix_rank(np.vstack([*blocks, held]), tol=1e-9))


def _screws(joint: Joint) -> np.ndarray:
    """Twists (angular velocity, velocity at the origin) that a joint allows, as columns."""
    point, axes = (
        np.array(joint.point),
        [np.array(a) for a in (joint.axis, joint.axis2) if a is not None],
    )
    if joint.type == "P":
        return np.concatenate([np.zeros(3), axes[0]])[:, None]
    axes = list(np.eye(3)) if joint.type == "S" else axes
    lead = joint.pitch / (2 * np.pi)
    columns = [np.concatenate([axis, np.cross(point, axis) + lead * axis]) for axis in axes]
    return np.array(columns).T.reshape(6, len(columns))


@pytest.mark.parametrize("seed", range(12))
def test_a_random_graph_moves_as_its_joints_do(seed: int, tmp_path: Path) -> None:
    machine = made(seed)
    path = tmp_path / "m.sdf"
    path.write_text(text(machine))
    robot = read_sdf(path)
    closed = nearest_closed(robot)
    assert closed.open_by < 1e-12
    assert closed.tree.freedom - rank_at(closed.tree, closed.state) == freedoms(machine)
    root = machine.links[0]
    for state in closed_neighbours(closed, 2, seed=seed, step=0.05):
        placed = closed.tree.displacements(state)
        moved = {
            f"l{k}": root @ placed[_carrier(robot, f"l{k}")] @ root.inverse()
            for k in range(len(machine.links))
        }
        for joint, parent, child in machine.joints:
            between = moved[f"l{parent}"].inverse() @ moved[f"l{child}"]
            assert joint_misfit(joint, between) < 1e-8, joint.name


def _carrier(robot: Robot, link: str) -> str:
    """The link of the robot that a link of the file is part of."""
    return "base" if link == "l0" else robot.frames[link][0] if link in robot.frames else link
