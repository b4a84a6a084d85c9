"""Passive joints for values that are given and those of a start, if only roughly: the branch of
each limb or loop that the start means.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import lru_cache
from symkin.model.joint import Coordinate
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import System, split_blocks
from symkin.position.closed_configurations import whole_system

_STARTS = 23
"""Further starts, with random angles, of a limb that the values given do not lead to a closed
loop.
"""
_AS_GOOD = 2.0
"""Branches that leave at most this many times the least closure error are equals; the nearest to
the values given is taken.
"""


def fit_passive(closure: Closure, values: np.ndarray, told: frozenset[str]) -> np.ndarray:
    """Values of all variables, those that are not `told` such that each limb or loop closes as well
    as it can with the others held; of branches that close equally well, the one nearest to
    `values`.
    """
    found = values.copy()
    held = [values[closure.slices[c.name]] for c in closure.coordinates if c.name in told]
    known = np.concatenate(held)
    for part in _parts(closure, told):
        here = np.concatenate([values[closure.slices[c.name]] for c in part.unknowns])
        fitted = _best(part, here, known)
        for name, place in part.places.items():
            found[closure.slices[name]] = fitted[place]
    return found


@lru_cache(maxsize=128)
def _parts(closure: Closure, told: frozenset[str]) -> tuple[System, ...]:
    """The rows of each limb or loop that holds coordinates which are not told: these unknown."""
    held = tuple(c for c in closure.coordinates if c.name in told)
    left = tuple(c for c in closure.coordinates if c.name not in told)
    whole, unknown = whole_system(closure), closure.symbols(left)
    known = closure.symbols(held)
    return split_blocks(replace(whole, unknowns=left, unknown=unknown, known=known)) if left else ()


def _best(part: System, here: np.ndarray, known: np.ndarray) -> np.ndarray:
    near = levenberg_marquardt(part, here[None], known)
    if near.largest_row[0] <= 1e-6 * part.characteristic_length:
        return np.asarray(near.points[0])
    points = np.vstack([near.points, levenberg_marquardt(part, _starts(part, here), known).points])
    errors = np.linalg.norm(part.linearise(points, known)[0], axis=1)
    errors = np.where(np.isfinite(errors), errors, np.inf)
    least = float(errors.min())
    if not np.isfinite(least):
        return here
    good = np.flatnonzero(errors <= _AS_GOOD * least + 1e-6 * part.characteristic_length)
    return np.asarray(points[min(good, key=lambda k: _distance(part, here, points[k]))])


def _starts(part: System, here: np.ndarray) -> np.ndarray:
    """Angles uniform, lengths as they are."""
    rng = np.random.default_rng(0)
    starts = np.tile(here, (_STARTS, 1))
    for c, place in zip(part.unknowns, part.slices, strict=True):
        if c.is_rotation:
            q = rng.normal(size=(_STARTS, 4))
            starts[:, place] = q / np.linalg.norm(q, axis=1, keepdims=True)
        elif c.is_periodic:
            starts[:, place] = rng.uniform(-np.pi, np.pi, (_STARTS, 1))
    return starts


def _distance(part: System, a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference of a coordinate: angles without whole turns (rad), lengths by the size."""
    return max(
        _apart(c, a[place], b[place], part.characteristic_length)
        for c, place in zip(part.unknowns, part.slices, strict=True)
    )


def _apart(c: Coordinate, a: np.ndarray, b: np.ndarray, size: float) -> float:
    if c.is_rotation:
        return 2 * math.acos(min(1.0, abs(float(a @ b))))
    if c.is_periodic:
        return abs(math.remainder(float(a[0] - b[0]), 2 * math.pi))
    return abs(float(a[0] - b[0])) / c.unit(size)
