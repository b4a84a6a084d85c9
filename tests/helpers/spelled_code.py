"""The generated C of a machine in one of its spellings: what its functions cost, and whether its
answers are those of `modes`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

import symkin
from helpers.firmware_tools import bench_module
from helpers.inside import Options, build_program, with_limbs
from helpers.spellings import Machine, Spelling
from symkin import Mechanism, Pose

NEAR = 1e-6
"""Largest difference of places, over the size, and of angles, of one answer."""
REACH = (0.6, 0.15)
"""How far goals are from the machine's input: radians, and sizes."""
_POSE, _ROW = 75, 30
"""Operations of a pose at the border of a turned machine: two matrices, 3 x 3 and 4 x 4, times
vectors, and as much back; and of a twist.
"""
_BY_ROWS = ("jacobian", "rates", "feed")


def border_of(function: str, machine: Machine) -> int:
    """Operations that the turn of poses and twists may take of a function."""
    rows = len(machine.home.actuated) if function in _BY_ROWS else 1
    return 2 * _POSE + rows * _ROW


def operations(mechanism: Mechanism) -> dict[str, int]:
    """Operations of each function at most."""
    usual = build_program(mechanism, Options("double")).worst.usual
    return {n: sum(bound.operations.values()) for n, bound in usual.items() if bound is not None}


@dataclass(frozen=True)
class Goals:
    """Joint values (n, joints) of a machine, in radians and the home's unit and order, for the
    spellings that have the modes of `kind`, which is as the home is.
    """

    machine: Machine
    kind: Mechanism
    joints: np.ndarray

    @staticmethod
    def of(machine: Machine, one: Spelling, count: int) -> Goals:
        """Random ones about the machine's input, which is beside the reference, for the kind of a
        spelling that stands as the home does.
        """
        home, rng = machine.home, np.random.default_rng(machine.seed)
        size = home.characteristic_length
        reach = [REACH[0] if c.is_angular else REACH[1] * size for c in home.actuated]
        middle = np.array([machine.values[c.name] for c in home.actuated])
        joints = middle + reach * rng.uniform(-1, 1, (count, len(middle)))
        return Goals(machine, one.mechanism, joints)

    @cached_property
    def poses(self) -> list[list[Pose]]:
        """The poses of all modes at each goal."""
        return self.poses_of(self.joints)

    def poses_of(self, joints: np.ndarray) -> list[list[Pose]]:
        """The poses of all modes of joint values."""
        if not len(joints):
            return []
        home, kind = self.machine.home, self.kind
        given = [
            {
                c.name: kind.angle_out(value) if c.is_angular else value
                for c, value in zip(home.actuated, row, strict=True)
            }
            for row in joints.tolist()
        ]
        if kind.serial:
            return [[symkin.solve(kind, joints=one).solution.pose] for one in given]  # type: ignore[union-attr]
        return [[mode.pose for mode in found] for found in symkin.modes(kind, joints=given)]


@dataclass(frozen=True)
class Answered:
    """Shares of goals that the C of a spelling accepts, of the direct and of the inverse problem,
    and how many of its answers are not on the machine.
    """

    direct: float
    inverse: float
    wrong: int


def answered(goals: Goals, spelling: Spelling) -> Answered:
    """What the compiled C of a spelling says of the goals, from the machine's input, and of the
    poses of all of their modes.
    """
    made = with_limbs(spelling.mechanism, "firmware", "")
    asked = bench_module("asked").Asked(made, Options("double"))
    machine, home = goals.machine, goals.machine.home
    size = home.characteristic_length
    names = [c.name for c in made.actuated]
    # columns of the home's joints in the spelling's order, and back
    order = [[c.name for c in home.actuated].index(name) for name in names]
    units = np.array([1.0 if c.is_angular else spelling.factor for c in made.actuated])
    joints, start = (
        units * np.array(rows)[:, order]
        for rows in (goals.joints, [[machine.values[c.name] for c in home.actuated]])
    )
    poses = [pose for modes in goals.poses for pose in modes]
    told = np.array([_numbers(spelling.told(pose)) for pose in poses]).reshape(-1, 7)
    if made.serial:
        found = asked.answers(told, np.tile(start, (len(told), 1)))
        by_pose, back = found.status, found.found
        by_joints, reached = asked.back(joints)
    else:
        guess = _numbers(spelling.told(machine.configuration.pose))
        found = asked.answers(joints, np.tile(guess, (len(joints), 1)))
        by_joints, reached = found.status, found.found
        by_pose, back = asked.back(told)
    ok = np.flatnonzero(by_joints == 0)
    ends = [spelling.taken(Pose(reached[k, :3], reached[k, 3:])) for k in ok]
    wrong = sum(not _among(end, goals.poses[k], size) for end, k in zip(ends, ok, strict=True))
    ok = np.flatnonzero(by_pose == 0)
    there = goals.poses_of((back[ok] / units)[:, np.argsort(order)])
    wrong += sum(not _among(poses[k], modes, size) for modes, k in zip(there, ok, strict=True))
    return Answered(float(np.mean(by_joints == 0)), float(np.mean(by_pose == 0)), wrong)


def _numbers(pose: Pose) -> np.ndarray:
    return np.array([*pose.position, *pose.quaternion])


def _among(pose: Pose, poses: Sequence[Pose], size: float) -> bool:
    """Whether a pose is one of these."""
    return any(
        np.linalg.norm(np.subtract(pose.position, other.position)) <= NEAR * size
        and abs(float(np.dot(pose.quaternion, other.quaternion))) >= 1.0 - NEAR
        for other in poses
    )
