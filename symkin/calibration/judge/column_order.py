"""Find the order and the signs of the joint columns that explain the readings best.

Where whole poses were measured, each limb of a parallel mechanism has a joint value of its own at each pose (the inverse problem at the
nominal geometry), and the columns are assigned to the limbs that they fit best, whatever the order. Elsewhere single exchanges and signs
are taken one after the other, each the best, while the readings fit better.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np

from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.estimate.configurations import joints_at_poses, known_poses
from symkin.calibration.estimate.residuals import wrapped
from symkin.calibration.judge.statistics import rms_of_better_part
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism

_MAX_ASSIGNED_JOINTS = 7
"""Joints whose orders are all tried (5040); with more only single exchanges are."""
_MIN_WHOLE_POSES = 4
"""Whole poses from which columns are assigned to joints."""
_EXCHANGE_CONFIGURATIONS = 16
"""Configurations by which exchanges one after the other are judged."""
_EXCHANGE_GAIN = 0.9
"""An exchange is taken where the misfit falls below this share."""


def best_column_order(
    mechanism: Mechanism, m: Measurements, misfit: Callable[[Measurements], float]
) -> tuple[str, Measurements] | None:
    """A sentence on the order and signs of the joint columns that explain the readings, and the readings put right; None where the
    columns stand as they should, or where too few poses are known."""
    whole = np.array([pose is not None for pose in known_poses(m, measured=True)])
    if not mechanism.serial and np.sum(whole) >= _MIN_WHOLE_POSES and len(mechanism.actuated) <= _MAX_ASSIGNED_JOINTS:
        found = _assign_columns(mechanism, m.subset(whole))
    else:
        found = _exchange_one_by_one(mechanism, m, misfit)
    if found is None:
        return None
    order, signs = found
    return _describe_order(mechanism.actuated, order, signs), replace(m, joints=signs * m.joints[:, order])


def is_possible(actuated: Sequence[Coordinate], joints: np.ndarray) -> bool:
    """Whether no reading is below the least value of its joint (rods of negative length)."""
    return all(c.least is None or bool(np.all(joints[:, k] > c.least)) for k, c in enumerate(actuated))


def like_pairs(mechanism: Mechanism) -> Iterator[tuple[int, int]]:
    """Pairs of joints of one kind."""
    actuated = mechanism.actuated
    return ((a, b) for a, b in combinations(range(len(actuated)), 2) if actuated[a].is_angular == actuated[b].is_angular)


def swapped(count: int, a: int, b: int) -> np.ndarray:
    order = np.arange(count)
    order[[a, b]] = b, a
    return order


def sign_change(count: int, k: int) -> np.ndarray:
    return np.where(np.arange(count) == k, -1.0, 1.0)


def _assign_columns(mechanism: Mechanism, m: Measurements) -> tuple[np.ndarray, np.ndarray] | None:
    """For each joint the column that fits its values at the measured poses best, each column once, and its sign."""
    actuated = mechanism.actuated
    poses = np.array([pose for pose in known_poses(m, measured=True) if pose is not None])
    values = joints_at_poses(mechanism, poses)
    reached = np.all(np.isfinite(values), axis=1)
    if np.sum(reached) < _MIN_WHOLE_POSES:
        return None
    values, read, count = values[reached], m.joints[reached], len(actuated)
    cost, sign = np.full((count, count), np.inf), np.ones((count, count))
    for j, c in enumerate(actuated):
        for k, other in enumerate(actuated):
            if c.is_angular != other.is_angular:
                continue
            for s in (1.0, -1.0):
                found = rms_of_better_part(_joint_gap(s * read[:, k] - values[:, j], c) ** 2) ** 2
                if found < cost[j, k]:
                    cost[j, k], sign[j, k] = found, s
    orders = np.array(list(permutations(range(count))))
    best = orders[int(np.argmin(np.sum(cost[np.arange(count), orders], axis=1)))]
    signs = sign[np.arange(count), best]
    unchanged = np.array_equal(best, np.arange(count)) and np.all(signs > 0)
    return None if unchanged or not is_possible(actuated, signs * m.joints[:, best]) else (best, signs)


def _joint_gap(values: np.ndarray, c: Coordinate) -> np.ndarray:
    return wrapped(values) if c.is_angular else values


def _exchange_one_by_one(
    mechanism: Mechanism, m: Measurements, misfit: Callable[[Measurements], float]
) -> tuple[np.ndarray, np.ndarray] | None:
    """Exchanges of two columns and changes of one sign, the best first, while the misfit falls."""
    count, m = len(mechanism.actuated), m.subset(spread_rows(len(m), _EXCHANGE_CONFIGURATIONS))
    order, signs, least = np.arange(count), np.ones(count), misfit(m)
    for step in range(count):
        swaps = [swapped(count, a, b) for a, b in like_pairs(mechanism)]
        trials = [(order[swap], signs[swap]) for swap in swaps]
        trials += [(order, signs * sign_change(count, k)) for k in range(count)]
        judged = [
            (misfit(replace(m, joints=s * m.joints[:, o])), o, s)
            for o, s in trials
            if is_possible(mechanism.actuated, s * m.joints[:, o])
        ]
        value, o, s = min(judged, key=lambda trial: trial[0], default=(np.inf, order, signs))
        if not value < _EXCHANGE_GAIN * least:
            return None if step < 1 else (order, signs)
        order, signs, least = o, s, value
    return order, signs


def _describe_order(actuated: Sequence[Coordinate], order: np.ndarray, signs: np.ndarray) -> str:
    """'the columns a, b, c look exchanged: they seem to hold b, c, a; the sign of d looks reversed'."""
    names = [c.name for c in actuated]
    holds = np.argsort(order)  # column order[j] holds joint j
    moved = [k for k in range(len(names)) if holds[k] != k]
    parts = []
    if moved:
        parts.append(
            f"the columns {', '.join(names[k] for k in moved)} look exchanged: they seem to hold {', '.join(names[holds[k]] for k in moved)}"
        )
    turned = [names[order[j]] for j in range(len(names)) if signs[j] < 0]
    if turned:
        parts.append(f"the sign{'s' * (len(turned) > 1)} of {', '.join(turned)} look{'s' * (len(turned) == 1)} reversed")
    return "; ".join(parts)
