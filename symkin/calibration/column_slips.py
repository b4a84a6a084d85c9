"""Joint columns that stand in the wrong order, with the wrong sign, or both: the order and signs that explain the readings.

Where whole poses were measured, each limb of a parallel mechanism has a joint value of its own at each pose (the inverse problem at the
nominal geometry), and the columns are assigned to the limbs that they fit best, whatever the order. Elsewhere single exchanges and signs
are taken one after the other, each the best, while the readings fit better.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np

from symkin.calibration.closing import joints_at
from symkin.calibration.direct import known_poses
from symkin.calibration.measurements import Measurements
from symkin.calibration.plausible import better_part
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism

_MOST_ASSIGNED = 7
"""Joints whose orders are all tried (5040); with more only single exchanges are."""
_FEWEST = 4
"""Whole poses from which columns are assigned."""
_ROWS = 16
"""Postures by which exchanges one after the other are judged."""
_GAIN = 0.9
"""An exchange is taken where the misfit falls below this share."""

Misfit = Callable[[Mechanism, Measurements], float]


def wrong_columns(mechanism: Mechanism, m: Measurements, misfit: Misfit) -> Iterator[tuple[str, Measurements]]:
    """Orders and signs of the joint columns that may explain the readings, with the readings put right."""
    whole = np.array([pose is not None for pose in known_poses(m, measured=True)])
    if not mechanism.serial and np.sum(whole) >= _FEWEST and len(mechanism.actuated) <= _MOST_ASSIGNED:
        found = _assigned(mechanism, m.subset(whole))
    else:
        found = _one_by_one(mechanism, m, misfit)
    if found is not None:
        order, signs = found
        yield _described(mechanism.actuated, order, signs), replace(m, joints=signs * m.joints[:, order])


def is_possible(actuated: Sequence[Coordinate], joints: np.ndarray) -> bool:
    """Whether no reading is below the least value of its joint (rods of negative length)."""
    return all(c.least is None or bool(np.all(joints[:, k] > c.least)) for k, c in enumerate(actuated))


def _assigned(mechanism: Mechanism, m: Measurements) -> tuple[np.ndarray, np.ndarray] | None:
    """For each joint the column that fits its values at the measured poses best, each column once, and its sign."""
    actuated = mechanism.actuated
    poses = np.array([pose for pose in known_poses(m, measured=True) if pose is not None])
    values = joints_at(mechanism, poses)
    reached = np.all(np.isfinite(values), axis=1)
    if np.sum(reached) < _FEWEST:
        return None
    values, read, count = values[reached], m.joints[reached], len(actuated)
    cost, sign = np.full((count, count), np.inf), np.ones((count, count))
    for j, c in enumerate(actuated):
        for k, other in enumerate(actuated):
            if c.is_angular != other.is_angular:
                continue
            for s in (1.0, -1.0):
                found = better_part(_gap(s * read[:, k] - values[:, j], c) ** 2) ** 2
                if found < cost[j, k]:
                    cost[j, k], sign[j, k] = found, s
    orders = np.array(list(permutations(range(count))))
    best = orders[int(np.argmin(np.sum(cost[np.arange(count), orders], axis=1)))]
    signs = sign[np.arange(count), best]
    unchanged = np.array_equal(best, np.arange(count)) and np.all(signs > 0)
    return None if unchanged or not is_possible(actuated, signs * m.joints[:, best]) else (best, signs)


def _gap(values: np.ndarray, c: Coordinate) -> np.ndarray:
    return np.asarray(np.remainder(values + np.pi, 2 * np.pi) - np.pi if c.is_angular else values)


def _one_by_one(mechanism: Mechanism, m: Measurements, misfit: Misfit) -> tuple[np.ndarray, np.ndarray] | None:
    """Exchanges of two columns and changes of one sign, the best first, while the misfit falls."""
    actuated, count = mechanism.actuated, len(mechanism.actuated)
    m = m.subset(np.unique(np.linspace(0, len(m) - 1, _ROWS).astype(int)))
    order, signs, least = np.arange(count), np.ones(count), misfit(mechanism, m)
    for step in range(count):
        trials = []
        for a, b in combinations(range(count), 2):
            if actuated[a].is_angular == actuated[b].is_angular:
                swap = np.arange(count)
                swap[[a, b]] = b, a
                trials.append((order[swap], signs[swap]))
        trials += [(order, signs * np.where(np.arange(count) == k, -1.0, 1.0)) for k in range(count)]
        judged = [
            (misfit(mechanism, replace(m, joints=s * m.joints[:, o])), o, s)
            for o, s in trials
            if is_possible(actuated, s * m.joints[:, o])
        ]
        value, o, s = min(judged, key=lambda trial: trial[0], default=(np.inf, order, signs))
        if not value < _GAIN * least:
            return None if step < 1 else (order, signs)
        order, signs, least = o, s, value
    return order, signs


def _described(actuated: Sequence[Coordinate], order: np.ndarray, signs: np.ndarray) -> str:
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
