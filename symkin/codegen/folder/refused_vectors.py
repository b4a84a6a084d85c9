"""Find inputs that generated code must refuse: values that no configuration has, and joints beyond
their limits.

A value counts as one that the mechanism cannot take where least squares over all rows leave a large
error from every start.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.steps.passive_limits import keeps_limits
from symkin.codegen.steps.pose_coordinates import COLUMNS
from symkin.codegen.steps.samples import configurations
from symkin.model.joint import Coordinate
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import System, constant_rows, split_blocks
from symkin.position.problem import Problem
from symkin.position.solution import pose_of
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply

MOST = 6
"""Values of a kind in a test."""
_OPEN = 1e-4
"""Share of the size that the rows are open by, of values that cannot be taken: far above the
rounding of floats.
"""
_STEPS = (0.003, 0.03, 0.3, 1.0, 2.0, 3.0)
"""How far from values that can be taken others are tried: in sizes and radians."""
_STARTS = 160
_PAST = 1e-2
"""How far joints are beyond limits, as a share of the range."""


def off_motion(kind: LimbPlatform, cases: Sequence[np.ndarray]) -> list[Pose]:
    """Poses beside those of two configurations that the platform's motion does not have."""
    size, columns = kind.closure.characteristic_length, COLUMNS[kind.mechanism.motion]
    off = [column for column in range(6) if column not in columns][:2]
    poses = (pose_of(kind.closure, values) for values in cases[:2])
    return [_moved(pose, column, 0.01, size) for pose in poses for column in off]


def _moved(pose: Pose, column: int, step: float, size: float) -> Pose:
    """A pose moved along, or turned about, an axis of the base."""
    position, turn = np.array(pose.position), np.array([1.0, 0.0, 0.0, 0.0])
    if column < 3:
        position[column] += step * size
    else:
        turn[0], turn[column - 2] = np.cos(0.5 * step), np.sin(0.5 * step)
    return Pose(position, multiply(turn, pose.quaternion).ravel())


def infeasible(problem: Problem, cases: Sequence[np.ndarray], most: int = MOST) -> list[np.ndarray]:
    """Copies of configurations, all variables, with known values within limits that no
    configuration has.
    """
    known, size = problem.known_coordinates, problem.system.characteristic_length
    limits = [c.limits or (-np.inf, np.inf) for c in known for _ in range(c.width)]
    (low, high), rng = np.array(limits).T, np.random.default_rng(31)
    moving, alone = problem.system.exchanged(known), constant_rows(problem.system)
    parts, near = split_blocks(problem.system), np.array(cases[:MOST])
    found = list[np.ndarray]()
    for step in _STEPS:
        for case in cases[:3]:
            if len(found) >= most:
                return found
            way = rng.choice([-1.0, 1.0], moving.freedom) * step * size
            moved = moving.move(case[problem.known_places][None], way[None])[0]
            if np.all((low < moved) & (moved < high)) and (
                alone.residuals(np.zeros((1, 0)), moved)[0] > _OPEN * size
                or any(
                    _is_open(part, moved, problem.select_values(near, part.unknowns), rng)
                    for part in parts
                )
            ):
                found.append(case.copy())
                found[-1][problem.known_places] = moved
    return found


def _is_open(system: System, known: np.ndarray, near: np.ndarray, rng: np.random.Generator) -> bool:
    """Whether least squares leave the rows open at known values, from all of some starts, and then
    from others about them.
    """
    starts = near[np.arange(_STARTS) % len(near)]
    steps = rng.normal(size=(len(starts), system.freedom)) * system.characteristic_length
    steps[: len(near)] = 0.0
    begun, least = system.move(starts, steps), _OPEN * system.characteristic_length
    return all(
        np.min(system.residuals(levenberg_marquardt(system, part, known).points, known)) > least
        for part in (begun[: len(near)], begun[len(near) :])
    )


def beyond_passive(kind: LimbPlatform) -> list[np.ndarray]:
    """Closed configurations with a passive joint clearly beyond its limits, all variables."""
    if not kind.passive_limits:
        return []
    direct = kind.direct
    cases = configurations(direct, kind.home_values, 3 * MOST, 23, spread=0.2, turn=0.5)
    return [
        c.values
        for c in cases
        if not keeps_limits(kind.passive_limits, direct.closure, c.values, -1.0)
    ][:MOST]


def joints_past(
    coordinates: Sequence[Coordinate], at: np.ndarray, zero: float | np.ndarray = 0.0
) -> tuple[np.ndarray, list[int]]:
    """Joint values (n, joints), each with one joint beyond a limit, and which: `at` are values
    within limits, less `zero`.
    """
    rows, blamed, zeros = [], [], np.broadcast_to(zero, at.shape)
    for i, c in enumerate(coordinates):
        for end, side in zip(c.limits or (), (-1.0, 1.0), strict=False):
            low, high = c.limits or (end, end)
            row = at.copy()
            row[i] = (
                end + side * max(_PAST * (high - low), 1e-3 * max(abs(low), abs(high))) - zeros[i]
            )
            rows.append(row)
            blamed.append(i)
    return np.array(rows[: 2 * MOST]).reshape(-1, len(coordinates)), blamed[: 2 * MOST]
