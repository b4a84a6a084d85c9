"""The nearest pose that a mechanism can take, where its joints tie the pose's coordinates to each
other (a 3-RPS platform, a tool on four joints): a pose written with few digits lies beside these
poses and closes no loop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.computed_once import lru_cache
from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.newton import polish
from symkin.numeric.rank import Rank, count_above
from symkin.numeric.system import System, split_blocks
from symkin.numeric.tolerances import CLOSED_CONFIGURATION
from symkin.position.closed_configurations import closed_configurations
from symkin.position.problem import Problem, are_of_limbs, build_problem, pose_names

PROJECTED = 1e-4
"""Distance over the size below which a pose is one of few digits: tables print three of a length,
five of a quaternion.
"""
_CLOSED = 1e-11
"""Largest closure error over the size of a pose that is left as it is."""
_STARTS = 32
"""Random joint values from which each limb is brought as near to the pose as it comes."""
_HELD = 1e-6
"""Share of the largest singular value below which joints do not move the rows: beside a singular
configuration of a limb the joints would move far to follow the pose by little.
"""
_STEPS = 40
"""Steps to the nearest feasible pose at most."""


@dataclass(frozen=True, eq=False)
class NearestPose:
    """Pose coordinates that close all loops, near given ones, and their distance: the largest
    difference of a coordinate, angles times the size. `beyond_reach`: the given ones lie off them
    where joints are stretched, not only where they tie poses.
    """

    values: np.ndarray
    distance: float
    beyond_reach: bool


@lru_cache(maxsize=128)
def ties_poses(mechanism: Mechanism) -> bool:
    """Whether the joints of limbs put conditions on the pose's coordinates: at closed
    configurations, moves of the pose that no joints follow.
    """
    names = pose_names(mechanism)
    if not are_of_limbs(mechanism, names):
        return False
    problem = build_problem(mechanism, names)
    if problem.generic_rank == problem.system.rows.shape[0]:
        return False
    return all(both > joints for both, joints in _ranks(mechanism))


def _joint_rank(mechanism: Mechanism) -> int:
    """Independent motions of the rows by joints, at configurations where these are most."""
    return max((joints for _, joints in _ranks(mechanism)), default=0)


@lru_cache(maxsize=128)
def _ranks(mechanism: Mechanism) -> tuple[tuple[int, int], ...]:
    """Ranks of the rows by joints and pose, and by joints alone, at some closed configurations."""
    problem = build_problem(mechanism, pose_names(mechanism))
    whole, joints = _whole(problem), problem.system.freedom
    jacobians = [
        whole.linearise_one(values[[*problem.unknown_places, *problem.known_places]])[1]
        for values in closed_configurations(problem.closure, 2)[:3]
    ]
    return tuple(
        (Rank.of(jacobian).value, Rank.of(jacobian[:, :joints]).value) for jacobian in jacobians
    )


def nearest_pose(mechanism: Mechanism, pose: np.ndarray) -> NearestPose | None:
    """The feasible pose nearest to pose coordinates; None where the joints do not tie them, the
    pose closes all loops already, or no feasible one was found.
    """
    if not ties_poses(mechanism) or taken_poses(mechanism, pose[None])[0]:
        return None
    problem = build_problem(mechanism, pose_names(mechanism))
    joints = _nearest_joints(problem, pose)
    if problem.system.residual(joints, pose) <= _CLOSED * problem.closure.characteristic_length:
        return None
    whole, z = _whole(problem), np.concatenate([joints, pose])
    for _ in range(_STEPS):
        step = _step(problem, whole, z, pose)
        if step is None:
            return None
        z = whole.move(z[None], step[None])[0]
        if float(np.max(np.abs(step))) < 1e-13 * whole.characteristic_length:
            break
    if not whole.residual(z) <= CLOSED_CONFIGURATION * whole.characteristic_length:
        return None
    off = _to_pose(whole, problem.system.freedom, z, pose)
    distance = float(np.max(np.abs(off), initial=0.0))
    return NearestPose(z[len(joints) :], distance, _is_beyond_reach(problem, whole, z, off))


def _is_beyond_reach(problem: Problem, whole: System, z: np.ndarray, off: np.ndarray) -> bool:
    """Whether the way `off` from the nearest pose to the wanted one leads where joints could follow
    at other configurations.
    """
    jacobian, count = whole.linearise_one(z)[1], problem.system.freedom
    left, singular, _ = np.linalg.svd(jacobian[:, :count])
    rank = count_above(singular, _HELD, relative=True)
    lost = left[:, rank : _joint_rank(problem.mechanism)].T
    away = lost @ jacobian[:, count:] @ off
    return bool(np.max(np.abs(away), initial=0.0) > _CLOSED * whole.characteristic_length)


def taken_poses(mechanism: Mechanism, poses: np.ndarray) -> np.ndarray:
    """Which pose coordinates (n, numbers) close all loops by formulas, or in the reference's
    branch, which closes most that are to be closed; others may close them all the same.
    """
    shown = closing_poses(mechanism, poses)
    problem, left = build_problem(mechanism, pose_names(mechanism)), (~shown).nonzero()[0]
    if left.size:
        system, near = problem.system, _CLOSED * problem.closure.characteristic_length
        here = problem.closure.reference[problem.unknown_places]
        begin = here[None].repeat(len(left), axis=0)
        ends = polish(system, begin, poses[left], _STEPS, 0.1 * _CLOSED).points
        shown[left] = system.residuals(ends, poses[left]) <= near
    return shown


def closing_poses(mechanism: Mechanism, poses: np.ndarray) -> np.ndarray:
    """Which pose coordinates (n, numbers) formulas show to close all loops (n,); those not shown
    may close them all the same.
    """
    from symkin.position.arm_formulas import arm_formulas

    problem = build_problem(mechanism, pose_names(mechanism))
    arm, shown = arm_formulas(problem), np.zeros(len(poses), dtype=bool)
    if arm is not None:
        found = arm.solutions(poses)
        owner, branch = np.nonzero(found.real)
        errors = problem.system.residuals(found.values[owner, branch], poses[owner])
        shown[owner[errors <= _CLOSED * problem.closure.characteristic_length]] = True
    return shown


def _nearest_joints(problem: Problem, pose: np.ndarray) -> np.ndarray:
    """Joint values of each limb that leave the least closure error at a pose."""
    rng = np.random.default_rng(0)
    values = problem.closure.reference
    named: dict[str, np.ndarray] = {}
    for block in split_blocks(problem.system, by_errors=True):
        here = np.concatenate([values[problem.closure.slices[c.name]] for c in block.unknowns])
        starts = block.move(
            np.tile(here, (_STARTS, 1)),
            block.characteristic_length
            * rng.normal(size=(_STARTS, block.freedom))
            * (np.arange(_STARTS) > 0)[:, None],
        )
        batch = levenberg_marquardt(block, starts, pose, max_iterations=200, patience=40)
        largest = np.where(np.isfinite(batch.largest_row), batch.largest_row, np.inf)
        best = block.polish(batch.points[int(np.argmin(largest))], pose, steps=8)
        named |= {name: best[place] for name, place in block.places.items()}
    return np.concatenate([named[c.name] for c in problem.system.unknowns] or [np.zeros(0)])


def _step(problem: Problem, whole: System, z: np.ndarray, wanted: np.ndarray) -> np.ndarray | None:
    """A step to rows that vanish whose pose part is as near to the wanted pose as the linearised
    rows allow: with N the rows' combinations that no joint moves, N (F + J_X x) = 0, |x - x0|
    least, x0 the way back to the wanted pose; the joints follow.
    """
    rows, jacobian = whole.linearise_one(z)
    if not np.isfinite(jacobian).all():
        return None
    count = problem.system.freedom
    joints, pose = jacobian[:, :count], jacobian[:, count:]
    left, singular, _ = np.linalg.svd(joints)
    rank = count_above(singular, _HELD, relative=True)
    held = left[:, rank:].T
    back = _to_pose(whole, count, z, wanted)
    tie = held @ pose
    x = back - np.linalg.lstsq(tie, held @ rows + tie @ back, rcond=1e-9)[0]
    q = np.linalg.lstsq(joints, -(rows + pose @ x), rcond=_HELD)[0]
    return np.concatenate([q, x])


def _to_pose(whole: System, joints: int, z: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Tangent vector (length unit) from the pose at z, the last of its coordinates, to another."""
    there = np.concatenate([z[: -len(pose)], pose])
    return whole.difference(z[None], there[None])[0, joints:]


@lru_cache(maxsize=64)
def _whole(problem: Problem) -> System:
    """All rows with joints and pose unknown, joints first."""
    return problem.system.freed(problem.known_coordinates)
