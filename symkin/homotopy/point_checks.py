"""What the rows of a system say about points at one instance: rank, Newton steps, poses that are
none, neighbours.

Jacobians take a row more where there is a ray x, conj(x).dx = 0, so that a regular root has full
rank. The share of a singular value is its ratio to the largest, or to 1 (rows and unknowns are of
order one) where that is more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.circles import gaps
from symkin.numeric.tolerances import MULTIPLE_ROOT_SHARE

ROWS = 1e-14
"""Largest row that a root may leave, beyond what rows that contradict each other leave
everywhere.
"""
_FAR = 1e-5
"""|e| / |(e, g)| below which a ray is no pose: positions beyond 1e5 sizes."""
_NO_WEIGHT = 1e-8
"""|e.e| / |e|^2 below which a ray is no pose: rotation matrices with entries beyond 1e8."""
_WELL_DETERMINED = 1e-4
"""Share above which a direction is polished at a singular root."""
_STEPS = (0.1, 0.03)
"""Steps (of angles, of the size, of a ray's unit length) that look for more roots beside a singular
one.
"""
_MOST_STEPS = 60
"""Damped steps after which the search for one of them is given up."""


@dataclass(frozen=True, eq=False)
class Local:
    """Rows (n, m) at n points and their Jacobians' singular value decompositions: left (n, m, r),
    values (n, r) in falling order, right (n, r, width), adjoint.
    """

    rows: np.ndarray
    left: np.ndarray
    values: np.ndarray
    right: np.ndarray

    @property
    def largest_row(self) -> np.ndarray:
        return np.max(np.abs(self.rows), axis=1, initial=0.0)

    @property
    def shares(self) -> np.ndarray:
        return self.values / np.maximum(self.values[:, :1], 1.0)

    @property
    def share(self) -> np.ndarray:
        """That of the smallest singular value."""
        return self.shares[:, -1]

    def step(self, weights: np.ndarray) -> np.ndarray:
        """-V diag(weights) U^H F, (width, n)."""
        along = np.einsum("nij,ni->nj", np.conj(self.left), self.rows) * weights
        return -np.einsum("nji,nj->in", np.conj(self.right), along)


def look(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> Local:
    """The rows and their Jacobians at points z (width, n) for known values k, (known,) or (known,
    n).
    """
    each = (
        k.astype(complex)
        if k.ndim == 2
        else np.repeat(k.astype(complex)[:, None], z.shape[1], axis=1)
    )
    f, j = system.linearise(z, each)
    j, f = system.patched(system.unit_rays(z), j, f)
    j = np.where(np.isfinite(j).all(axis=(1, 2), keepdims=True), j, 0.0)
    return Local(f, *np.linalg.svd(j, full_matrices=False))


def polish(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, Local]:
    """Singular roots (width, n) moved to meet the rows in the directions that are well
    determined.
    """
    for _ in range(3):
        here = look(system, z, k)
        inverse = np.where(here.shares > _WELL_DETERMINED, 1 / np.maximum(here.values, 1e-300), 0.0)
        z = system.normalise(z + here.step(inverse))
    return z, look(system, z, k)


def is_no_pose(
    system: AlgebraicSystem,
    z: np.ndarray,
    error: float = 0.0,
    *,
    far: float = _FAR,
    thin: float = _NO_WEIGHT,
) -> np.ndarray:
    """Rays (e, g), each known within an error, without a rotation: e = 0 beside g or e.e = 0, where
    roots are at infinity. `far` and `thin` are the shares |e| / |(e, g)| and |e.e| / |e|^2 that
    count as none.
    """
    if not system.projective:
        return np.zeros(z.shape[1], dtype=bool)
    ray = z[list(system.projective)]
    e, squares = ray[:4], ray.real**2 + ray.imag**2
    weight = squares[:4].sum(axis=0)
    short = weight <= max(far, 10 * error) ** 2 * squares.sum(axis=0)
    return short | (np.abs((e * e).sum(axis=0)) <= max(thin, 10 * error) * weight)


def lie_on_sets(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Which singular roots z (width, n) are surrounded by complex roots of a continuum: long and
    short steps along directions that the Jacobian has lost both close again beside them, at points
    where its rank is lost too.
    """
    found = np.ones(z.shape[1], dtype=bool)
    for length in _STEPS:
        places = np.flatnonzero(found)
        found[places] = _close_beside(system, z[:, places], length, k)
    return found


def _close_beside(
    system: AlgebraicSystem, z: np.ndarray, length: float, k: np.ndarray
) -> np.ndarray:
    """Steps are damped (Levenberg, by the size of the rows), since Newton's own lead back to a
    multiple root.
    """
    here = look(system, z, k)
    allowed = ROWS + 10 * here.largest_row
    found = np.zeros(z.shape[1], dtype=bool)
    directions = [
        _lost_directions(here.right[i][here.shares[i] < MULTIPLE_ROOT_SHARE])
        for i in range(z.shape[1])
    ]
    owner = np.repeat(np.arange(z.shape[1]), [len(d) for d in directions])
    lanes = z[:, owner] + length * np.concatenate([*directions, np.zeros((0, system.width))]).T
    for _ in range(_MOST_STEPS):
        if not owner.size:
            break
        here = look(system, lanes, k)
        away = gaps(system, lanes, z[:, owner])
        beside = (away > 0.1 * length) & (away < 3 * length)
        found[
            owner[beside & (here.largest_row < allowed[owner]) & (here.share < MULTIPLE_ROOT_SHARE)]
        ] = True
        damped = here.values / (here.values**2 + here.largest_row[:, None] + 1e-30)
        left = beside & ~found[owner]
        lanes, owner = (lanes + here.step(damped))[:, left], owner[left]
    return found


def _lost_directions(rows: np.ndarray) -> np.ndarray:
    """Unit vectors (any, width) of the space that right singular vectors (count, width) span:
    themselves and mixtures.
    """
    lost: np.ndarray = np.conj(rows)
    if not len(lost):
        return lost
    rng = np.random.default_rng(0)
    mixed = (rng.normal(size=(4, len(lost))) + 1j * rng.normal(size=(4, len(lost)))) @ lost
    return np.concatenate([lost, mixed / np.linalg.norm(mixed, axis=1, keepdims=True)])
