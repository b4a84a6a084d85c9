"""All roots of a generic instance, found by moving the known values around loops.

The mechanism is its own start system: random complex unknowns fix the known values that they need, which gives one root
of one generic instance. Loops in the space of known values permute the roots and reveal new ones (Duff et al. 2019).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem, complex_normal
from symkin.homotopy.branches import SAME, cover, labels_of, uncovered
from symkin.homotopy.engine import newton, track
from symkin.homotopy.seeds import Points, carried, seed_roots
from symkin.homotopy.symmetry import Orbits
from symkin.numeric.levenberg import Progress

MOST_ROOTS = 130
MOST_WORK = 1.5e7
"""More roots than MOST_ROOTS, or more work than MOST_WORK - steps of all loops times the instructions of a step's
evaluation, weighed by the count of paths - and a search is given up. A count, not a clock, so that the same input gives
the same answer."""
_SEEDS = 12
"""Points from which seeds are sought; fewer are found."""
_MOST_ORBIT_LOOPS = 60
"""Loops at most in search of connections between known roots."""


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
    """The known roots, or a first seed and what other seeds give at its base."""
    if known is not None:
        z, k0 = known
        return _Found.of(system, z), k0
    z, k = seed_roots(system, points, rng, rank, _SEEDS)
    if not z.shape[1]:
        return None, np.zeros(0)
    return _Found.of(system, np.hstack([z[:, :1], carried(system, z[:, 1:], k[:, 1:], k[:, 0])])), k[:, 0]


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
