"""Machines with loops written in MJCF, URDF and SDF, against MuJoCo and Pinocchio: link poses at
random closed configurations that symkin finds, rank and mobility of the constraints, and rates
against central differences on MuJoCo's own closed set.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symkin
from helpers.gate import each_once, in_gate
from helpers.inside import Robot, Tree, read_robot
from helpers.made_robots import MACHINES, Machine, humanoid, opened
from helpers.robot_files import rank_at
from helpers.robot_texts import write
from oracle.robot_accounts import MuJoCo, Pinocchio, ball_values, freedom, rank

pytest.importorskip("mujoco")
pytest.importorskip("pinocchio")
POSE = 1e-10
"""Metres, and components of directions."""
FORMATS = ("xml", "urdf", "sdf")
LARGE = ("delta", "stewart")
STEP = 1e-5
"""Of given joints, for central differences (m, rad): their error is about its square."""


@dataclass(frozen=True)
class Read:
    """A machine as symkin reads it from one of its files, and the accounts of others."""

    machine: Machine
    robot: Robot
    tree: Tree
    mechanism: symkin.Mechanism
    closed: symkin.ClosedConfiguration
    mujoco: MuJoCo
    pinocchio: Pinocchio


@cache
def accounts(name: str) -> tuple[Machine, MuJoCo, Pinocchio]:
    machine = MACHINES[name]()
    return machine, MuJoCo(machine), Pinocchio(machine)


@pytest.fixture(scope="module")
def read_one(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Read a machine from a format, each pair once."""

    @cache
    def found(name: str, suffix: str, form: int = 0) -> Read:
        machine, mujoco, pinocchio = accounts(name)
        path = write(machine, suffix, tmp_path_factory.mktemp("robots"), form)
        robot = read_robot(path)
        return Read(
            machine, robot, Tree(robot), symkin.load(path), symkin.close(path), mujoco, pinocchio
        )

    return found


def solved(one: Read, count: int, seed: int) -> list[symkin.Solution]:
    """Closed configurations by symkin's own solver, at random values of the given joints."""
    rng, found = np.random.default_rng(seed), []
    for _ in range(count):
        given = {name: float(rng.uniform(-1, 1)) * one.machine.reach for name in one.machine.given}
        result = symkin.solve(one.mechanism, given=given)
        assert result.status == "ok"
        assert all(
            result.solution.joints[name] == pytest.approx(value, abs=1e-12)
            for name, value in given.items()
        )
        found.append(result.solution)
    return found


def part_poses(one: Read, solution: symkin.Solution) -> dict[str, np.ndarray]:
    """symkin's frames of all parts."""
    found = {}
    for part in one.machine.parts:
        (carrier, _), frame = one.robot.frames[part.name], one.closed.link_poses[part.name]
        displacement = symkin.Pose.identity() if carrier == "base" else solution.link_poses[carrier]
        found[part.name] = np.asarray((displacement @ frame).matrix)
    return found


def told_name(one: Read, coordinate: str) -> str:
    """A coordinate of the machine as the file has it: of a universal joint told from the link that
    it carries, the last axis is first.
    """
    joint, _, number = coordinate.rpartition(".")
    entry = next((e for e in one.mechanism.link_joints if e.joint.name == joint), None)
    backward = entry is not None and entry.links[0] in {
        part.name for part in one.machine.parts if part.joint_name == joint
    }
    return f"{joint}.{3 - int(number)}" if backward else coordinate


def values_of(one: Read, solution: symkin.Solution) -> dict[str, Any]:
    """Joint values in the machine's own terms: those of universal joints count from the reference
    in the mechanism, and have the numbers of the file's axes.
    """
    universal = {
        c.name
        for entry in one.robot.tree
        if entry.joint.type == "U"
        for c in entry.joint.coordinates
    }
    start = {name: one.closed.joints[name] for name in universal}
    told = {c: told_name(one, c) for part in one.machine.parts for c in part.coordinates}
    scalars = {c: solution.joints[name] + start.get(name, 0.0) for c, name in told.items()}
    return {**scalars, **ball_values(one.machine, part_poses(one, solution))}


CASES = each_once(MACHINES, FORMATS)
LIGHT = [case for case in CASES if case[0] not in ("delta", "stewart", "six_bar")]
"""Those of them that are solved at once."""


@pytest.mark.parametrize(("name", "suffix"), in_gate(product(MACHINES, FORMATS), LIGHT))
def test_link_poses_at_closed_configurations(name: str, suffix: str, read_one: Any) -> None:
    """Those of MuJoCo's and Pinocchio's kinematics for symkin's joint values, where MuJoCo finds
    its constraints closed.
    """
    one = read_one(name, suffix, len(name))
    for solution in solved(one, 3, seed=len(name)):
        own, values = part_poses(one, solution), values_of(one, solution)
        others = (
            one.mujoco.poses(one.mujoco.place(values)),
            one.pinocchio.poses(one.pinocchio.place(values)),
        )
        for poses in others:
            assert set(poses) == set(own)
            for part, pose in poses.items():
                np.testing.assert_allclose(own[part], pose, atol=POSE, err_msg=part)
        assert np.abs(one.mujoco.rows(one.mujoco.place(values))[0]).max() <= POSE


@pytest.mark.parametrize(("name", "suffix"), CASES)
def test_rank_and_mobility(name: str, suffix: str, read_one: Any) -> None:
    """At the reference and at a random closed configuration: the freedoms that are left are those
    of MuJoCo's and Pinocchio's constraints, and where the tree is the same, so is the rank; the
    mechanism's own count is the machine's.
    """
    one = read_one(name, suffix, len(name))
    (solution,) = solved(one, 1, seed=7)
    values = values_of(one, solution)
    _, jacobian = one.mujoco.rows(one.mujoco.place(values))
    theirs = one.mujoco.model.nv - rank(jacobian)
    assert theirs == one.machine.mobility
    assert (
        one.pinocchio.model.nv - rank(one.pinocchio.jacobian(one.pinocchio.place(values))) == theirs
    )
    state = np.hstack([solution.joints[c.name] for c in one.tree.coordinates])
    ours = rank_at(one.tree, state)
    assert one.tree.freedom - ours == theirs
    if one.tree.freedom == one.mujoco.model.nv:
        assert ours == rank(jacobian)
    elif suffix != "sdf":
        assert one.tree.freedom == freedom(one.machine)
    assert (one.closed.mobility, one.closed.generic_rank) == (theirs, one.closed.rank)
    assert symkin.mobility(one.mechanism).mobility == theirs


@pytest.mark.parametrize(
    ("name", "suffix"),
    in_gate(
        product(MACHINES, FORMATS),
        LIGHT,
    ),
)
def test_rates_are_central_differences_of_mujocos_poses(
    name: str, suffix: str, read_one: Any
) -> None:
    """Each given joint is moved a step and back, the loops closed by Newton's method on MuJoCo's
    constraints: joint values change as the Jacobian of the other joints by the given ones tells,
    and so does the pose of the last link.
    """
    one = read_one(name, suffix, len(name))
    (solution,) = solved(one, 1, seed=3)
    qpos = one.mujoco.place(values_of(one, solution))
    others = [
        c for part in one.machine.parts for c in part.coordinates if c not in one.machine.given
    ]
    told, by = ([told_name(one, c) for c in names] for names in (others, one.machine.given))
    own = symkin.jacobian(one.mechanism, of=told, by=by).at(solution)
    link, pose_rates = link_rates(one, solution)
    for column, name_moved in enumerate(one.machine.given):
        ahead, behind = (moved(one, qpos, name_moved, sign * STEP) for sign in (1, -1))
        values = [
            (one.mujoco.value(ahead, c) - one.mujoco.value(behind, c)) / (2 * STEP) for c in others
        ]
        scale = max(1.0, float(np.abs(own).max()), float(np.abs(pose_rates).max()))
        np.testing.assert_allclose(own[:, column], values, atol=1e-6 * scale)
        change = pose_numbers(one.mujoco.poses(ahead)[link]) - pose_numbers(
            one.mujoco.poses(behind)[link]
        )
        change[3:] = np.arctan2(np.sin(change[3:]), np.cos(change[3:]))
        np.testing.assert_allclose(pose_rates[:, column], change / (2 * STEP), atol=1e-6 * scale)


def moved(one: Read, qpos: np.ndarray, name: str, step: float) -> np.ndarray:
    """MuJoCo's closed configuration with one given joint moved, the others held."""
    held = {given: one.mujoco.value(qpos, given) for given in one.machine.given}
    held[name] += step
    return one.mujoco.closed(qpos, held)


def link_rates(one: Read, solution: symkin.Solution) -> tuple[str, np.ndarray]:
    """The last link that moves, and the rates of its pose by the given joints."""
    link = [part.name for part in one.machine.parts if part.name in one.robot.links][-1]
    frame = one.closed.link_poses[link]
    carrying = replace(
        one.mechanism,
        platform_link=link,
        platform_position=tuple(frame.position),
        platform_quaternion=tuple(frame.quaternion),
    )
    given = {name: solution.joints[name] for name in (told_name(one, c) for c in one.machine.given)}
    there = symkin.solve(carrying, given=given).solution
    return link, symkin.jacobian(
        carrying, of=["x", "y", "z", "azimuth", "tilt", "torsion"], by=list(given)
    ).at(there)


def pose_numbers(pose: np.ndarray) -> np.ndarray:
    """Position, and azimuth, tilt, torsion of the rotation Rz(azimuth) Ry(tilt) Rz(torsion -
    azimuth).
    """
    turn = pose[:3, :3]
    azimuth = np.arctan2(turn[1, 2], turn[0, 2])
    tilt = np.arctan2(np.hypot(turn[0, 2], turn[1, 2]), turn[2, 2])
    return np.array([*pose[:3, 3], azimuth, tilt, np.arctan2(turn[2, 1], -turn[2, 0]) + azimuth])


PLANAR = [name for name in MACHINES if name not in (*LARGE, "universal_loop", "leg")]


@pytest.mark.parametrize(("name", "suffix"), each_once(PLANAR, ["xml", "urdf"]))
def test_files_that_are_open(name: str, suffix: str, tmp_path: Path) -> None:
    """Joints told from other zeros: closed by `close` where MuJoCo's constraints are closed, with
    MuJoCo's poses; and so beside it.
    """
    machine = opened(MACHINES[name](), 0.3, seed=len(name))
    mujoco, path = MuJoCo(machine), write(machine, suffix, tmp_path, 1)
    robot = read_robot(path)
    one = Read(
        machine,
        robot,
        Tree(robot),
        symkin.load(path),
        symkin.close(path),
        mujoco,
        Pinocchio(machine),
    )
    assert one.closed.open_by > 1e-3
    assert one.closed.mobility == machine.mobility
    given = {n: one.closed.joints[n] + 0.1 * machine.reach for n in machine.given}
    for solution in (
        symkin.solve(one.mechanism, given=g).solution
        for g in ({n: one.closed.joints[n] for n in given}, given)
    ):
        qpos = mujoco.place(values_of(one, solution))
        assert np.abs(mujoco.rows(qpos)[0]).max() <= 1e-9
        poses = mujoco.poses(qpos)
        for part, pose in part_poses(one, solution).items():
            np.testing.assert_allclose(pose, poses[part], atol=POSE)


WRITTEN = ["four_bar", "five_bar", "gripper", "screw_drive"]


@pytest.mark.parametrize(("name", "form"), each_once(WRITTEN, range(5)))
def test_every_way_of_writing_a_loop_in_urdf_is_the_same_machine(
    name: str, form: int, read_one: Any
) -> None:
    """The same mobility, and MuJoCo's poses, whichever element or file tells the closures."""
    one = read_one(name, "urdf", form)
    assert len(one.robot.closures) == len(one.machine.pins)
    assert one.closed.open_by <= 1e-12
    assert one.closed.mobility == one.machine.mobility
    (solution,) = solved(one, 1, seed=form)
    poses = one.mujoco.poses(one.mujoco.place(values_of(one, solution)))
    for part, pose in part_poses(one, solution).items():
        np.testing.assert_allclose(pose, poses[part], atol=POSE)


@pytest.mark.parametrize(
    ("name", "form"), each_once([name for name in MACHINES if name not in LARGE], [0, 1])
)
def test_joints_of_a_graph_are_told_from_either_link(name: str, form: int, read_one: Any) -> None:
    """MuJoCo's poses for the same values, whichever link the file calls a joint's parent."""
    one = read_one(name, "sdf", form)
    (solution,) = solved(one, 1, seed=2)
    poses = one.mujoco.poses(one.mujoco.place(values_of(one, solution)))
    for part, pose in part_poses(one, solution).items():
        np.testing.assert_allclose(pose, poses[part], atol=POSE)


@pytest.mark.parametrize("suffix", FORMATS)
def test_names_motors_ranges_and_couplings_are_those_of_the_machine(
    suffix: str, read_one: Any
) -> None:
    for name in ("four_bar", "gripper", "parallel_ankle"):
        one = read_one(name, suffix)
        assert {part.name for part in one.machine.parts} <= set(one.robot.frames)
        assert {c.name for c in one.mechanism.actuated} == set(one.machine.motors)
        limits = {c.name: c.limits for c in one.mechanism.coordinates}
        assert all(
            limits[part.joint_name] == part.limits
            for part in one.machine.parts
            if part.limits is not None
        )
        assert len(one.robot.couplings) == len(one.machine.followers)


def test_a_loop_of_universal_joints_closes_by_one_in_a_graph(read_one: Any) -> None:
    """In SDF the fourth joint closes the loop as it is; MJCF and URDF write it as a chain and a
    weld.
    """
    kinds = {
        suffix: [
            c.joint.type
            for c in read_one("universal_loop", suffix, len("universal_loop")).robot.closures
        ]
        for suffix in FORMATS
    }
    assert kinds == {"xml": ["weld"], "urdf": ["weld"], "sdf": ["U"]}


@pytest.mark.slow
@pytest.mark.parametrize("suffix", in_gate(FORMATS, ["xml"]))
def test_a_robot_of_sixty_joints_and_six_loops(suffix: str, tmp_path: Path) -> None:
    """Read and closed with the mobility of MuJoCo's constraints: each planar loop takes two
    freedoms, though it is told by five rows.
    """
    machine = humanoid()
    found = symkin.close(write(machine, suffix, tmp_path))
    mujoco = MuJoCo(machine)
    _, jacobian = mujoco.rows(mujoco.place({part.joint_name: 0.0 for part in machine.parts}))
    assert (len(machine.parts), len(machine.pins)) == (60, 6)
    assert found.mobility == mujoco.model.nv - rank(jacobian) == machine.mobility
    assert (
        symkin.mobility(symkin.load(write(machine, suffix, tmp_path))).mobility == machine.mobility
    )
