"""Roots of generic instances to begin with: random complex points, moved onto the closure with the
known values free.

Newton's method with least steps solves F(z, k) = 0 for unknowns z and known values k together; all
points advance at once.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem, complex_normal
from symkin.homotopy.engine import track
from symkin.homotopy.tracker import TrackSettings
from symkin.homotopy.values import coordinate_scale, known_values
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply

Points = Callable[[np.random.Generator, bool], tuple[np.ndarray, np.ndarray]]
"""Draws a complex point (z, k), near the reference or not."""
_ATTEMPTS = 5
"""Draws of points until some lead to a root."""
_ITERATIONS = 40
_LONGEST_STEP = 1.0
"""Newton steps are cut to this length (sizes, radians)."""
_SETTLED, _VANISHING = 1e-12, 1e-11
"""Length of the last step, and largest row, of a point that has become a root."""
_NEGLIGIBLE = 1e-13
"""Singular values below this share of the largest are rounding."""
_ORDINARY = 1e-2
"""Least share of the largest singular value of the rows' derivatives in 1, which is their order at
an ordinary point.
"""


def seed_roots(
    system: AlgebraicSystem, points: Points, rng: np.random.Generator, rank: int, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Regular roots z (width, n) with their known values k (known, n) that `count` points, half of
    them near the reference, lead to; drawn anew while there are none. Singular values below the
    generic `rank` are cut.
    """
    for _ in range(_ATTEMPTS):
        drawn = [points(rng, i % 2 == 0) for i in range(count)]
        z, k = (np.array(part, dtype=complex).T for part in zip(*drawn, strict=True))
        with np.errstate(all="ignore"):
            z, k, settled = _settled(system, z, k, rank + (1 if system.projective else 0))
        good = settled & regular(system, z, k)
        if good.any():
            return z[:, good], k[:, good]
    return z[:, good], k[:, good]


def _settled(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, rank: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points moved by Newton's method, and which of them are roots."""
    last = np.full(z.shape[1], np.inf)
    active = np.arange(z.shape[1])
    for _ in range(_ITERATIONS):
        f, jz, jk = full_linearisation(system, z[:, active], k[:, active])
        both = np.concatenate([jz, jk], axis=2)
        step = _least_steps(*system.patched(z[:, active], both, f), rank)
        length = np.linalg.norm(step, axis=0)
        step = step * np.minimum(1.0, _LONGEST_STEP / np.maximum(length, 1e-300))
        z[:, active] = system.normalise(z[:, active] + step[: len(z)])
        k[:, active] = k[:, active] + step[len(z) :]
        last[active] = np.where(np.isfinite(length), length, np.inf)
        active = active[np.isfinite(length) & (length > 0.1 * _SETTLED)]
        if not active.size:
            break
    f = system.linearise(z, k)[0]
    return z, k, (last < _SETTLED) & (np.max(np.abs(f), axis=1) < _VANISHING)


def _least_steps(jacobian: np.ndarray, f: np.ndarray, rank: int) -> np.ndarray:
    """Least Newton steps (columns, n) that use at most `rank` singular values."""
    bad = ~np.isfinite(jacobian).all(axis=(1, 2))
    left, s, right = np.linalg.svd(np.where(bad[:, None, None], 0.0, jacobian), full_matrices=False)
    kept = (s > _NEGLIGIBLE * s[:, :1]) & (np.arange(s.shape[1]) < rank)
    weights = np.einsum("nij,ni->nj", np.conj(left), f) * np.where(
        kept, 1.0 / np.where(kept, s, 1.0), 0.0
    )
    steps = -np.einsum("nji,nj->ni", np.conj(right), weights)
    steps[bad] = np.nan
    return steps.T


def full_linearisation(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """F (n, rows), dF/dz (n, rows, width) and dF/dk (n, rows, known) at z (width, n), k (known,
    n).
    """
    f, jz = system.linearise(z, k)
    known, n = k.shape
    directions = np.repeat(np.eye(known, dtype=complex), n, axis=1)
    along = system.evaluate(np.tile(z, known), np.tile(k, known), directions)[2]
    return f, jz, along.reshape(known, n, -1).transpose(1, 2, 0)


def regular(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Which roots are isolated at fixed k. Where a known quaternion has e.e = 0 all rows vanish,
    and their derivatives too.
    """
    _, jz = system.linearise(z, k)
    need = system.width - (1 if system.projective else 0)
    singular = np.linalg.svd(np.where(np.isfinite(jz), jz, 0.0), compute_uv=False)
    if singular.shape[1] < need:
        return np.zeros(z.shape[1], dtype=bool)
    return singular[:, need - 1] > 1e-7 * np.maximum(singular[:, 0], _ORDINARY)


def carried(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Roots at `base` that roots z at k, (known,) or (known, n), are tracked to."""
    if not z.shape[1]:
        return z
    base = np.asarray(base, dtype=complex)
    ends = base if k.ndim == 1 else np.repeat(base[:, None], z.shape[1], axis=1)
    tracked = track(system, z, k, ends, TrackSettings(tolerance=1e-5))
    return tracked.z[:, tracked.arrived]


def random_point(
    problem: Problem, system: AlgebraicSystem, rng: np.random.Generator, *, near: bool
) -> tuple[np.ndarray, np.ndarray]:
    """A complex point: about the reference with imaginary parts of about a half (of the size, of a
    radian), or anywhere.
    """
    z = _about_reference(problem, system.unknowns, rng, near)
    if system.projective:
        pose = _reference_pose(problem, system)
        ray = _noise(4, rng, near) + (np.asarray(pose.quaternion) if near else 0.0)
        if len(system.projective) == 8:
            t = np.concatenate(
                [
                    [0.0],
                    np.asarray(pose.position) / problem.closure.characteristic_length
                    + _noise(3, rng, near),
                ]
            )
            ray = np.concatenate([ray, 0.5 * multiply(t, ray)])
        z = np.concatenate([z, ray])
    return z, known_values(problem, random_known(problem, rng, near=near))


def _reference_pose(problem: Problem, system: AlgebraicSystem) -> Pose:
    """Of the body for which the projective point stands."""
    places, reference = problem.closure.slices, problem.closure.reference
    if system.body == "pose":
        return problem.mechanism.reference_pose
    position = [float(reference[places[f"{system.body}.{axis}"]][0]) for axis in "xyz"]
    return Pose(np.array(position), reference[places[f"{system.body}.quaternion"]])


def random_known(problem: Problem, rng: np.random.Generator, *, near: bool) -> np.ndarray:
    """Complex values of the known coordinates, in the length unit and radians."""
    known = _about_reference(problem, problem.known_coordinates, rng, near)
    return known * coordinate_scale(problem, problem.known_coordinates)


def _about_reference(
    problem: Problem, coordinates: tuple[Coordinate, ...], rng: np.random.Generator, near: bool
) -> np.ndarray:
    """Reference values, lengths in units of the size, and noise."""
    closure = problem.closure
    parts = [closure.reference[closure.slices[c.name]] for c in coordinates]
    values = np.concatenate([*parts, np.zeros(0)]) / coordinate_scale(problem, coordinates)
    return values + _noise(len(values), rng, near)


def _noise(count: int, rng: np.random.Generator, near: bool) -> np.ndarray:
    return (0.5 if near else 1.5) * complex_normal(count, rng) + 0.3j * rng.choice([-1, 1], count)
