"""What the limbs can do at a pose: poses first, then the branches of each limb, then their product.

Where the pose and the actuated joints are known, limbs no longer know of each other, and each has
its own few branches. The roots that are tracked cover every pair of a pose and a branch of one
limb; all combinations follow, so that six limbs of two branches need two paths a pose, not 64.
"""

from __future__ import annotations

from itertools import product
from math import prod

import numpy as np

from symkin.errors import TooManyModesError
from symkin.homotopy.algebraic import AlgebraicSystem, imaginary_part
from symkin.position.roots import MOST_MODES, merge

SAME = 1e-6
"""Largest difference of features (relative to 1) of two equal roots."""
_REAL = 1e-5
"""Largest imaginary part of a root that is tried as a real one; the closure decides."""


def labels_of(features: np.ndarray) -> np.ndarray:
    """Equal rows (complex features) have equal labels, counted from 0."""
    return (
        merge(np.hstack([features.real, features.imag]), SAME)[1]
        if len(features)
        else np.zeros(0, dtype=int)
    )


def uncovered(system: AlgebraicSystem, known: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Index of the known root (width, m) that each column of z repeats; -1 where it has a new pose,
    or a new branch of some limb at a known pose. A repeat whose limbs differ from every known root
    has the first root of its pose.
    """
    same = _equal(system.features(z), system.features(known))
    limbs = [
        _equal(a, b) & same
        for a, b in zip(system.limb_features(z), system.limb_features(known), strict=True)
    ]
    covered = (
        np.all([limb.any(axis=1) for limb in limbs], axis=0) & same.any(axis=1)
        if limbs
        else same.any(axis=1)
    )
    exact = np.all(limbs, axis=0) if limbs else same
    index = np.where(exact.any(axis=1), np.argmax(exact, axis=1), np.argmax(same, axis=1))
    return np.where(covered, index, -1)


def _equal(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(np.max(np.abs(a[:, None] - b[None]), axis=2) < SAME)


def cover(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """Fewest roots of one pose that hold every branch of every limb that the columns of z hold:
    root j takes branch j of each limb, counted round.
    """
    if not system.limbs:
        return z[:, :1]
    firsts = [np.unique(labels_of(f), return_index=True)[1] for f in system.limb_features(z)]
    columns = []
    for j in range(max(len(first) for first in firsts)):
        column = z[:, 0].copy()
        for limb, first in zip(system.limbs, firsts, strict=True):
            column[list(limb)] = z[list(limb), first[j % len(first)]]
        columns.append(column)
    return np.array(columns).T


def complex_count(system: AlgebraicSystem, z: np.ndarray) -> int:
    """Roots that the columns of z stand for: over all poses, the product of the limbs' counts of
    branches.
    """
    poses = labels_of(system.features(z))
    limbs = [labels_of(f) for f in system.limb_features(z)]
    counts = [
        [int(np.count_nonzero(np.bincount(limb[poses == pose]))) for limb in limbs]
        for pose in range(poses.max(initial=-1) + 1)
    ]
    return sum(prod(count) for count in counts)


def real_candidates(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """Columns that may be real: all combinations of real branches at real poses."""
    z = z[:, imaginary_part(system, z, system.pose_places) < _REAL]
    if not system.limbs or not z.shape[1]:
        return z
    poses = labels_of(system.features(z))
    columns = [
        column
        for label in np.unique(poses)
        for column in _combinations(system, z[:, poses == label])
    ]
    return np.array(columns).T.reshape(system.width, len(columns))


def _combinations(system: AlgebraicSystem, z: np.ndarray) -> list[np.ndarray]:
    """Roots z of one pose, with every combination of the real branches of its limbs."""
    choices = []
    for limb, features in zip(system.limbs, system.limb_features(z), strict=True):
        first = np.unique(labels_of(features), return_index=True)[1]
        real = imaginary_part(system, z[:, first], limb) < _REAL
        choices.append(z[list(limb)][:, first[real]].T)
    count = prod(len(c) for c in choices)
    if count > MOST_MODES:
        raise TooManyModesError(
            f"the limbs' branches combine to {count} modes at one pose, more than the {MOST_MODES} "
            f"that are listed; "
            "solve for one of them near a start"
        )
    columns = []
    for choice in product(*choices):
        column = z[:, 0].copy()
        for limb, values in zip(system.limbs, choice, strict=True):
            column[list(limb)] = values
        columns.append(column)
    return columns
