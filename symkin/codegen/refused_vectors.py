"""Find inputs that generated code must refuse: values that no configuration has, and joints beyond
their limits.

A value counts as one that the mechanism cannot take where least squares over all rows leave a large
error from every start.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.codegen.joint_map import Direction, JointMap
from symkin.codegen.limb_platform import LimbPlatform
from symkin.codegen.passive_limits import keeps_limits
from symkin.codegen.pose_coordinates import COLUMNS
from symkin.codegen.samples import Configuration, configurations
from symkin.model.joint import Coordinate, units_of
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
_STEPS = (0.003, 0.03, 0.3, 1.0)
"""How far from values that can be taken others are tried: in sizes and radians."""
_STARTS = 160
_PAST = 1e-2
"""How far joints are beyond limits, as a share of the range."""


def infeasible_poses(kind: LimbPlatform, cases: Sequence[Configuration]) -> np.ndarray:
    """Poses (n, 7), as stated, that the platform cannot take: off its motion, open in a limb, or
    with a passive joint beyond its limits.
    """
    inverse, found = kind.inverse, list[np.ndarray]()
    closure = inverse.closure
    size, rng = closure.characteristic_length, np.random.default_rng(31)
    for case in cases[:2]:
        pose = pose_of(closure, case.values)
        found += [
            kind.stated(_moved(pose, column, 0.01, size))
            for column in range(6)
            if column not in COLUMNS[kind.mechanism.motion]
        ][:2]
    known = inverse.known_coordinates
    pose_system = inverse.system.exchanged(known)
    for step in _STEPS:
        for case in cases[:3]:
            at, near = (
                inverse.select_values(case.values, known),
                inverse.select_values(case.values, inverse.system.unknowns),
            )
            way = rng.choice([-1.0, 1.0], pose_system.freedom) * step * size
            moved = pose_system.move(at[None], way[None])[0]
            if len(found) < MOST and _is_open_in_a_limb(inverse, case, moved, rng):
                found.append(kind.stated(pose_of(closure, inverse.join_values(near, moved))))
    found += [kind.stated(pose_of(closure, values)) for values in _beyond_passive(kind)]
    return np.array(found).reshape(-1, 7)


def _moved(pose: Pose, column: int, step: float, size: float) -> Pose:
    """A pose moved along, or turned about, an axis of the base."""
    position, turn = np.array(pose.position), np.array([1.0, 0.0, 0.0, 0.0])
    if column < 3:
        position[column] += step * size
    else:
        turn[0], turn[column - 2] = np.cos(0.5 * step), np.sin(0.5 * step)
    return Pose(position, np.asarray(multiply(turn, pose.quaternion)).ravel())


def _is_open_in_a_limb(
    inverse: Problem, case: Configuration, known: np.ndarray, rng: np.random.Generator
) -> bool:
    """Whether a limb, or a row of the pose alone, does not close at known values."""
    alone = constant_rows(inverse.system)
    size, none = inverse.system.characteristic_length, np.zeros((1, 0))
    if int(alone.errors.shape[0]) and alone.residuals(none, known)[0] > _OPEN * size:
        return True
    return any(
        _is_open(b, known, [inverse.select_values(case.values, b.unknowns)], rng)
        for b in split_blocks(inverse.system)
    )


def _is_open(
    system: System, known: np.ndarray, near: Sequence[np.ndarray], rng: np.random.Generator
) -> bool:
    """Whether least squares leave the rows open at known values, from all of some starts, and then
    from others about them.
    """
    starts = np.array([near[i % len(near)] for i in range(max(_STARTS, len(near)))])
    steps = rng.normal(size=(len(starts), system.freedom)) * system.characteristic_length
    steps[: len(near)] = 0.0
    begun, least = system.move(starts, steps), _OPEN * system.characteristic_length
    return all(
        np.min(system.residuals(levenberg_marquardt(system, part, known).points, known)) > least
        for part in (begun[: len(near)], begun[len(near) :])
    )


def _beyond_passive(kind: LimbPlatform) -> list[np.ndarray]:
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
        for end, side in enumerate((-1.0, 1.0)) if c.limits is not None else ():
            assert c.limits is not None  # noqa: S101 - as the line above says
            low, high = c.limits
            row = at.copy()
            row[i] = (
                c.limits[end]
                + side * max(_PAST * (high - low), 1e-3 * max(abs(low), abs(high)))
                - zeros[i]
            )
            rows.append(row)
            blamed.append(i)
    return np.array(rows[: 2 * MOST]).reshape(-1, len(coordinates)), blamed[: 2 * MOST]


def infeasible_values(
    made: JointMap, direction: Direction, cases: Sequence[Configuration]
) -> np.ndarray:
    """Known values (n, known) of a direction of a map that no configuration has, within the limits
    of these.
    """
    problem: Problem = direction.problem
    rng, found = np.random.default_rng(37), list[np.ndarray]()
    near = [
        made.direct.problem.select_values(case.values, direction.unknown)
        for case in (*cases[:6], *made.samples[:12])
    ]
    scales = np.array(units_of(direction.known, made.size))
    for step in (0.3, 1.0, 2.0, 3.0):
        for case in cases[:4]:
            at = made.direct.problem.select_values(case.values, direction.known)
            moved = at + step * scales * rng.choice([-1.0, 1.0], len(at))
            inside = all(
                c.limits is None or c.limits[0] < v < c.limits[1]
                for c, v in zip(direction.known, moved, strict=True)
            )
            if inside and len(found) < MOST and _is_open(problem.system, moved, near, rng):
                found.append(moved)
    return np.array(found).reshape(-1, len(direction.known))
