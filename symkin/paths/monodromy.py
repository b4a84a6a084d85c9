"""All roots of a generic instance, found by moving the known values around loops.

The mechanism is its own start system: random complex unknowns fix the known values that they need, which gives one root
of one generic instance. Loops in the space of known values permute the roots and reveal new ones (Duff et al. 2019).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from symkin.model.joint import Coordinate
from symkin.paths.algebraic import AlgebraicSystem, complex_normal
from symkin.paths.branches import SAME, cover, labels_of, uncovered
from symkin.paths.engine import newton, track
from symkin.paths.symmetry import Orbits
from symkin.paths.values import coordinate_scale, known_values
from symkin.position.levenberg import Progress
from symkin.position.problem import Problem
from symkin.spatial.rotation import multiply

MOST_ROOTS = 130
MOST_WORK = 1.5e7
"""More roots than MOST_ROOTS, or more work than MOST_WORK - steps of all loops times the instructions of a step's
evaluation, weighed by the count of paths - and a search is given up. A count, not a clock, so that the same input gives
the same answer."""
_ORDINARY = 1e-2
"""Least share of the largest singular value of the rows' derivatives in 1, which is their order at an ordinary point."""
_MOST_ORBIT_LOOPS = 60
"""Loops at most in search of connections between known roots."""
Points = Callable[[np.random.Generator, bool], tuple[np.ndarray, np.ndarray]]
"""Draws a complex point (z, k), near the reference or not."""


class TooManyRootsError(Exception):
    """A search that was given up; holds how many roots had been met."""


@dataclass(frozen=True, eq=False)
class Fibre:
    """Roots z (width, n) of F(., k); `orbits` labels the roots by what the loops have connected; `evidence` is
    sum -log10(1 - share of roots moved) over the loops since the last new root; `mirrors` groups roots that symmetries of
    the closure carry to each other."""

    z: np.ndarray
    k: np.ndarray
    orbits: np.ndarray
    evidence: float
    loops: int
    seed: int
    mirrors: Orbits | None = None


@dataclass
class _Found:
    """Roots met so far; `poses` numbers the pose of each column, `parents` joins poses that loops have connected."""

    system: AlgebraicSystem
    z: np.ndarray
    poses: np.ndarray
    parents: list[int]

    @staticmethod
    def of(system: AlgebraicSystem, z: np.ndarray) -> _Found:
        poses = labels_of(system.features(z))
        return _Found(system, z, poses, list(range(len(np.unique(poses))))).compressed()

    def match(self, z: np.ndarray) -> np.ndarray:
        """Index of the known root that each column of z repeats, or -1."""
        return uncovered(self.system, self.z, z)

    def add(self, column: np.ndarray) -> int:
        """Append a root, of a known pose or of a new one."""
        apart = np.max(np.abs(self.system.features(self.z) - self.system.features(column[:, None])), axis=1)
        pose = int(self.poses[np.argmin(apart)]) if apart.min() < SAME else len(self.parents)
        if pose == len(self.parents):
            self.parents.append(pose)
        self.z = np.concatenate([self.z, column[:, None]], axis=1)
        self.poses = np.append(self.poses, pose)
        return len(self.poses) - 1

    def compressed(self) -> _Found:
        """The same poses and branches with the fewest roots."""
        parts = [cover(self.system, self.z[:, self.poses == pose]) for pose in range(len(self.parents))]
        poses = np.repeat(np.arange(len(parts)), [part.shape[1] for part in parts])
        return _Found(self.system, np.hstack(parts), poses, self.parents)

    def orbit(self, pose: int) -> int:
        while self.parents[pose] != pose:
            pose = self.parents[pose]
        return pose

    def join(self, i: int, j: int) -> None:
        """Roots i and j are connected."""
        self.parents[self.orbit(self.poses[i])] = self.orbit(self.poses[j])


def truncated_step(jacobian: np.ndarray, f: np.ndarray, rank: int) -> np.ndarray:
    """Least Newton step that uses the `rank` largest singular values."""
    try:
        left, s, right = np.linalg.svd(jacobian, full_matrices=False)
    except np.linalg.LinAlgError:
        return np.full(jacobian.shape[1], np.nan, dtype=complex)
    kept = min(rank, int(np.sum(s > 1e-13 * s[0])))
    return np.asarray(-np.conj(right[:kept].T) @ ((np.conj(left[:, :kept].T) @ f) / s[:kept]))


def seed_root(
    system: AlgebraicSystem, points: Points, rng: np.random.Generator, rank: int, attempts: int = 60
) -> tuple[np.ndarray, np.ndarray] | None:
    """One root (z, k) of a generic instance: unknowns and known values both move, by least steps, from a random complex
    point near or far from the reference; singular values below the generic rank are cut."""
    for attempt in range(attempts):
        z, k = points(rng, attempt % 2 == 0)
        for _ in range(40):
            f, jz, jk = full_linearisation(system, z, k)
            jacobian = np.hstack([jz, jk])
            step = truncated_step(*_with_ray(system, z, jacobian, f), rank + (1 if system.projective else 0))
            length = float(np.linalg.norm(step))
            step *= min(1.0, 1.0 / max(length, 1e-300))
            z, k = z + step[: len(z)], k + step[len(z) :]
            z = system.normalise(z[:, None])[:, 0]
            if not np.all(np.isfinite(z)) or length > 1e6:
                break
            if length < 1e-13:
                break
        if np.all(np.isfinite(z)) and np.max(np.abs(full_linearisation(system, z, k)[0])) < 1e-11 and _is_regular(system, z, k):
            return system.normalise(z[:, None])[:, 0], k
    return None


def _with_ray(system: AlgebraicSystem, z: np.ndarray, jacobian: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A row that keeps the step orthogonal to the ray, whose length means nothing."""
    if not system.projective:
        return jacobian, f
    row = np.zeros(jacobian.shape[1], dtype=complex)
    row[list(system.projective)] = np.conj(z[list(system.projective)])
    return np.vstack([jacobian, row]), np.append(f, 0.0)


def full_linearisation(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """F, dF/dz and dF/dk at one point."""
    columns = []
    f = jz = None
    for i in range(len(k)):
        unit = np.zeros(len(k), dtype=complex)
        unit[i] = 1.0
        f, jz, t = system.evaluate(z[:, None], k[:, None], unit)
        columns.append(t[0])
    assert f is not None and jz is not None  # noqa: S101, PT018 - there is at least one known value
    return f[0], jz[0], np.array(columns).T


def random_point(
    problem: Problem, system: AlgebraicSystem, rng: np.random.Generator, *, near: bool
) -> tuple[np.ndarray, np.ndarray]:
    """A complex point: about the reference with imaginary parts of about a half (of the size, of a radian), or
    anywhere."""
    z = _about_reference(problem, system.unknowns, rng, near)
    if system.projective:
        pose = problem.mechanism.reference_pose
        ray = _noise(4, rng, near) + (np.asarray(pose.quaternion) if near else 0.0)
        if len(system.projective) == 8:
            t = np.concatenate([[0.0], np.asarray(pose.position) / problem.closure.size + _noise(3, rng, near)])
            ray = np.concatenate([ray, 0.5 * multiply(t, ray)])
        z = np.concatenate([z, ray])
    return z, known_values(problem, random_known(problem, rng, near=near))


def random_known(problem: Problem, rng: np.random.Generator, *, near: bool) -> np.ndarray:
    """Complex values of the known coordinates, in the length unit and radians."""
    known = _about_reference(problem, problem.known_coordinates, rng, near)
    return np.asarray(known * coordinate_scale(problem, problem.known_coordinates))


def _about_reference(problem: Problem, coordinates: tuple[Coordinate, ...], rng: np.random.Generator, near: bool) -> np.ndarray:
    """Reference values, lengths in units of the size, and noise."""
    closure = problem.closure
    parts = [closure.reference[closure.slices[c.name]] for c in coordinates]
    values = np.concatenate([*parts, np.zeros(0)]) / coordinate_scale(problem, coordinates)
    return np.asarray(values + _noise(len(values), rng, near))


def _noise(count: int, rng: np.random.Generator, near: bool) -> np.ndarray:
    return np.asarray((0.5 if near else 1.5) * complex_normal(count, rng) + 0.3j * rng.choice([-1, 1], count))


def _is_regular(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> bool:
    """The root is isolated at fixed k. Where a known quaternion has e.e = 0 all rows vanish, and their derivatives with them."""
    _, jz, _ = full_linearisation(system, z, k)
    singular = np.linalg.svd(jz, compute_uv=False)
    need = system.width - (1 if system.projective else 0)
    return bool(len(singular) >= need and singular[need - 1] > 1e-7 * max(singular[0], _ORDINARY))


def fibre(
    system: AlgebraicSystem, points: Points, rng: np.random.Generator, seed: int, rank: int,
    *, bound: int | None = None, known: tuple[np.ndarray, np.ndarray] | None = None, needed: float = 6.0,
    most_loops: int = 200, progress: Progress | None = None,
) -> Fibre | None:  # fmt: skip
    """Loop until a bound is reached or the evidence is `needed`. None where no seed was found. `known` are roots and
    base to begin with."""
    found, k0 = _begin(system, points, rng, rank, known)
    if found is None:
        return None
    evidence, loops = 0.0, 0
    work = 0.0
    while loops < most_loops and evidence < needed and (bound is None or found.z.shape[1] < bound):
        loops += 1
        before = found.z.shape[1]
        ends, arrived, steps = _loop(system, found.z, k0, rng)
        work += steps * system.cost * (1 + before / 100)
        if work > MOST_WORK or found.z.shape[1] > MOST_ROOTS:
            raise TooManyRootsError(found.z.shape[1])
        moved, new = _absorb(found, ends, arrived)
        found = found.compressed() if new else found
        if new:
            evidence = 0.0
        elif arrived.sum() > 0:
            share = min(moved / before, 1 - 1e-3)
            evidence += -np.log10(1 - share)
        if progress is not None:
            progress(int(100 * min(1.0, evidence / needed)), 100)
        if before == 1 and not new and loops >= 25:
            break
    orbits = np.array([found.orbit(pose) for pose in found.poses])
    return Fibre(found.z, k0, np.unique(orbits, return_inverse=True)[1], evidence, loops, seed)


def _begin(
    system: AlgebraicSystem, points: Points, rng: np.random.Generator, rank: int, known: tuple[np.ndarray, np.ndarray] | None
) -> tuple[_Found | None, np.ndarray]:
    """The known roots, or a first seed and what six more of them give at the same base."""
    if known is not None:
        z, k0 = known
        return _Found.of(system, z), k0
    start = seed_root(system, points, rng, rank)
    if start is None:
        return None, np.zeros(0)
    z0, k0 = start
    found = _Found.of(system, z0[:, None])
    for _ in range(8):
        other = _carry(system, seed_root(system, points, rng, rank), k0)
        if other is not None and found.match(other[:, None])[0] < 0:
            found.add(other)
    return found.compressed(), k0


def _carry(system: AlgebraicSystem, root: tuple[np.ndarray, np.ndarray] | None, k0: np.ndarray) -> np.ndarray | None:
    """A root of another generic instance, tracked to k0."""
    if root is None:
        return None
    tracked = track(system, root[0][:, None], root[1], k0)
    return tracked.z[:, 0] if tracked.arrived[0] else None


def _loop(system: AlgebraicSystem, z: np.ndarray, k0: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, int]:
    """Along a random triangle k0, k1, k2, k0; angles may wind by whole turns."""
    radius = loop_radius(rng)
    return around(system, z, [k0, k0 + radius * complex_normal(len(k0), rng), k0 + radius * complex_normal(len(k0), rng), k0])


def loop_radius(rng: np.random.Generator) -> float:
    """Log-uniform between 0.7 and 5 sizes (or radians), at times up to 30."""
    return float(0.7 * (5.0 / 0.7) ** rng.uniform() if rng.uniform() < 0.85 else 5.0 * 6.0 ** rng.uniform())


def around(system: AlgebraicSystem, z: np.ndarray, corners: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, int]:
    """Roots z tracked along a closed polygon; ends, which of them arrived, and steps."""
    steps = 0
    arrived = np.ones(z.shape[1], dtype=bool)
    for begin, end in pairwise(corners):
        tracked = track(system, z[:, arrived], begin, end)
        steps += tracked.steps
        next_z = z.copy()
        next_z[:, np.flatnonzero(arrived)] = tracked.z
        z = next_z
        arrived[np.flatnonzero(arrived)[~tracked.arrived]] = False
    if arrived.any():
        polished, last = newton(system, z[:, arrived], corners[0])
        z[:, np.flatnonzero(arrived)] = polished
        arrived[np.flatnonzero(arrived)[last > 1e-9]] = False
    return z, arrived, steps


def orbits(
    system: AlgebraicSystem, z: np.ndarray, k0: np.ndarray, corner: Callable[[], np.ndarray], needed: float = 10.0
) -> np.ndarray:
    """Labels of roots by what loops through pairs of corners connect, until all are one or the evidence since the last
    connection is `needed`. All zero where the loops leave a root alone: that is no evidence of a part of its own."""
    found, evidence = _Found.of(system, z), 0.0
    for _ in range(_MOST_ORBIT_LOOPS):
        before = len({found.orbit(pose) for pose in found.poses})
        if before == 1 or evidence >= needed:
            break
        ends, arrived, _ = around(system, found.z, [k0, corner(), corner(), k0])
        moved, _ = _absorb(found, ends, arrived & (found.match(ends) >= 0))
        same = len({found.orbit(pose) for pose in found.poses}) == before
        evidence = evidence - np.log10(1 - min(moved / z.shape[1], 1 - 1e-3)) if same else 0.0
    labels = np.unique([found.orbit(pose) for pose in found.poses], return_inverse=True)[1]
    return labels if np.bincount(labels).min() > 1 and evidence >= needed else np.zeros_like(labels)


def _absorb(found: _Found, ends: np.ndarray, arrived: np.ndarray) -> tuple[int, int]:
    moved = new = 0
    for i in np.flatnonzero(arrived):
        j = int(found.match(ends[:, [i]])[0])
        if j < 0:
            j = found.add(ends[:, i])
            new += 1
        if j != i:
            moved += 1
        found.join(int(i), j)
    return moved, new
