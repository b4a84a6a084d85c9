"""The order of modes: nearest to the example's start or the reference pose first, without a
platform to the reference's joints; ties by joint values, all rounded.
"""

from __future__ import annotations

import numpy as np

from symkin.computed_once import lru_cache
from symkin.numeric.linear_algebra import squared_norms
from symkin.position.given import pose_from
from symkin.position.problem import Problem
from symkin.position.solution_list import SolutionList
from symkin.spatial.pose import Pose

_DIGITS = 6
"""Decimals to which distances (of the size) and values are rounded, so that rounding errors do not
decide the order.
"""
_FEW = 64
"""Modes up to which ties are told by all values at once; of many most stand in order already."""


def order_of_modes(problem: Problem, listed: SolutionList, owner: np.ndarray) -> np.ndarray:
    """Places (m,) that sort modes by their points `owner`, then by nearness, then by their
    variables.
    """
    away = (
        _joint_distances(problem, listed.values)
        if problem.mechanism.platform_link is None
        else _distances(problem, listed.position, listed.quaternion)
    )
    return places_by(owner, away, listed.values)


def places_by(owner: np.ndarray, first: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Places (m,) that sort by `owner`, then by `first` (m,), ties by rounded values (m, any)."""
    order = np.lexsort((first, owner))
    keys, owners = first[order], owner[order]
    tied = (keys[1:] == keys[:-1]) & (owners[1:] == owners[:-1])
    if len(order) <= _FEW and tied.any():
        return np.lexsort((*values.T[::-1].round(_DIGITS), first, owner))
    for column in values.T:
        if not tied.any():
            break
        key = column[order].round(_DIGITS)
        if (key[1:] < key[:-1])[tied].any():
            turn = np.lexsort((key, np.append(0, ~tied).cumsum()))
            order, key = order[turn], key[turn]
        tied &= key[1:] == key[:-1]
    return order


def _distances(problem: Problem, position: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
    """|R - R0|^2 + (|x - x0| / size)^2 of poses, with |R - R0|^2 = 8 (1 - (q.q0)^2)."""
    first = _first_pose(problem)
    turn = 8.0 * (1.0 - (quaternion @ np.asarray(first.quaternion)) ** 2)
    step = (position - np.asarray(first.position)) / problem.system.characteristic_length
    return (turn + squared_norms(step)).round(_DIGITS)


def _joint_distances(problem: Problem, values: np.ndarray) -> np.ndarray:
    """Squares of the distances of coordinates from the reference's: chords of angles, lengths over
    the size.
    """
    closure, total = problem.closure, np.zeros(len(values))
    for c in closure.coordinates:
        place = closure.slices[c.name]
        gap = values[:, place] - closure.reference[place]
        match c.kind:
            case "angle":
                total += 2.0 - 2.0 * np.cos(gap[:, 0])
            case "quaternion":
                total += 8.0 * (1.0 - (values[:, place] @ closure.reference[place]) ** 2)
            case "turns":
                total += gap[:, 0] ** 2
            case _:
                total += (gap[:, 0] / closure.characteristic_length) ** 2
    return np.round(total, _DIGITS)


@lru_cache(maxsize=64)
def _first_pose(problem: Problem) -> Pose:
    """The pose from which distances are taken."""
    example = problem.mechanism.example
    if (
        problem.of_joints
        and example is not None
        and example.start is not None
        and example.joints is not None
    ):
        return pose_from(example.start)
    return problem.mechanism.reference_pose
