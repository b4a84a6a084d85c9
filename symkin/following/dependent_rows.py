"""Rows of a block beyond as many as it has unknowns: whether they follow from the others, and how
far they are from zero where the others are.

Rows of a planar loop that is written in space vanish out of its plane; others vanish only where the
loop is closed, u cos(t) = u sin(t) = 0 of parallel axes for one.
"""

from __future__ import annotations

import numpy as np

from symkin.certificate.disc_arithmetic import UP
from symkin.following.path_system import NEWTON_ARRIVED, PathSystem, inverses, least_squares
from symkin.following.trajectory import coefficients
from symkin.following.tube import Interval
from symkin.model.joint import units_of
from symkin.numeric.rank import most_independent

_WAYS, _FAR, _PLACES, _APART = 4, 0.5, 30, 0.1
"""Random ways from a root, how far they go in each known coordinate at most, places on each, and
how far unknowns move between these (over the size, or rad).
"""
_FOLLOWS = 1e-11
"""Rows (over the size) below this at random places are zero everywhere, as those of a planar loop
out of its plane are (see `closure.closure.nonzero_rows`).
"""
_MOST_CORRECTIONS = 6


def rows_suffice(system: PathSystem, z: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Whether combinations of rows, as many as unknowns, vanish nowhere about each of some roots z
    (n, w) at known values (n, k) without all rows: at random known values, to which Newton's method
    leads on these combinations alone. So it is, with probability one, wherever a branch leads from
    the root without a singularity: what is analytic and vanishes about one of its points vanishes
    on all of it.
    """
    if system.is_square or not len(z):
        return np.ones(len(z), dtype=bool)
    c = np.array([way for values in known for way in _random_ways(system, values)])
    y = np.append(np.repeat(z, _WAYS, axis=0), np.zeros((len(c), 1)), axis=1)
    jacobian = system.evaluate(y, c)[1]
    combined, largest, moved = inverses(jacobian[..., :-1]), np.zeros(len(y)), np.zeros(len(y))
    going = np.arange(len(y))
    for _ in range(_PLACES):
        combinations = combined[going] @ jacobian[going]
        slope = -least_squares(combinations[..., :-1], combinations[..., -1])
        speed = np.max(np.abs(slope), axis=1, initial=_FAR)
        h = np.fmin(_APART / speed, 1.0 - y[going, -1])
        guess = y[going] + h[:, None] * np.append(slope, np.ones((len(slope), 1)), axis=1)
        there, size = _corrected(system, combined[going], guess, c[going])
        reached = (size < NEWTON_ARRIVED) & (np.abs(there - guess).max(axis=1) < _APART)
        moved[going] += np.where(reached, h * speed, 0.0)
        going = going[reached]
        y[going] = there[reached]
        values, jacobian[going] = system.evaluate(y[going], c[going])
        largest[going] = np.maximum(largest[going], np.abs(values).max(axis=1))
        going = going[y[going, -1] < 1.0]
    far = moved.reshape(-1, _WAYS).max(axis=1) >= _APART
    return np.asarray(far & (largest.reshape(-1, _WAYS).max(axis=1) < _FOLLOWS))


def _random_ways(system: PathSystem, known: np.ndarray) -> list[np.ndarray]:
    """Coefficients of ways from known values to random ones about them."""
    coordinates, size = system.problem.known_coordinates, system.problem.closure
    units = np.array(units_of(coordinates, size.characteristic_length))
    rng, ways = np.random.default_rng(0), []
    for _ in range(_WAYS):
        there, place = known + _FAR * units * rng.uniform(-1.0, 1.0, len(known)), 0
        for c in coordinates:
            if c.is_rotation:
                there[place : place + 4] /= np.linalg.norm(there[place : place + 4])
            place += c.width
        ways.append(coefficients(coordinates, known, there))
    return ways


def _corrected(
    system: PathSystem, combined: np.ndarray, y: np.ndarray, c: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Newton's method from points (n, w + 1) on combined rows at a fixed u: where it leads, and its
    last step's size."""
    y, size = y.copy(), np.full(len(y), np.inf)
    for _ in range(_MOST_CORRECTIONS):
        values, jacobian = system.evaluate(y, c)
        step = least_squares(combined @ jacobian[..., :-1], (combined @ values[..., None])[..., 0])
        y[:, :-1] -= step
        size = np.max(np.abs(step), axis=1, initial=0.0)
    return y, size


def redundant_rows_bound(interval: Interval, y: np.ndarray, which: np.ndarray) -> float:
    """An upper bound (length unit) of all rows at the exact roots near points y (n, w + 1), at
    their u, of as many independent rows as unknowns; infinite where no such root is proved.
    """
    width = interval.system.width
    jacobian = interval.evaluate(y, which)[1]
    chosen = most_independent(jacobian[..., :-1], width)
    if (np.count_nonzero(chosen, axis=1) < width).any():
        return float("inf")
    rows = np.eye(interval.system.count)[np.nonzero(chosen)[1].reshape(len(y), width)]
    half = interval.boxes(y, jacobian, np.eye(width + 1)[:, :-1], which, rows)
    value = interval.value(y, half, which)
    beyond = (np.abs(value.middle) + value.radius)[..., 0][~chosen]
    size = interval.system.problem.closure.characteristic_length
    bound = float(np.max(beyond, initial=0.0)) * size * UP
    return bound if bound == bound else float("inf")
