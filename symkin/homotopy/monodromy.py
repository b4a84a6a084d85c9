"""All roots of a generic instance, found by moving the known values around loops.

The mechanism is its own start system: random complex unknowns fix the known values that they need,
which gives one root of one generic instance. Loops in the space of known values permute the roots
and reveal new ones (Duff et al. 2019).
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem, complex_normal, first_of_each, known_root
from symkin.homotopy.engine import newton, track_lines
from symkin.homotopy.seeds import Points, carried, seed_roots
from symkin.homotopy.symmetry import Orbits
from symkin.homotopy.tracker import TrackSettings
from symkin.numeric.levenberg import Progress

LOG = logging.getLogger(__name__)
MOST_ROOTS = 600
MOST_WORK = 2.5e8
"""More roots than MOST_ROOTS, or more work than MOST_WORK - steps of all loops times the
instructions of a step's evaluation, weighed by the count of paths - and a search is given up: some
10 s, and once for a machine. A delta of six freedoms has 512 roots for the place of its platform. A
count, not a clock, so that the same input gives the same answer.
"""
_SEEDS = 72
"""Points from which seeds are sought; a tenth to a third of them are found, on whichever components
of the closure there are.
"""
_FEWEST_AT_ONCE, _LOOPS_AT_ONCE, _PATHS_AT_ONCE = 2, 24, 240
"""Loops that are tracked together while they find roots, and afterwards at most, and their paths at
most.
"""
_IDLE_LOOPS = 25
"""Loops after which a single root that none has moved is taken to be alone."""
_LONGEST_TURN, _HIGHEST = 2 * np.pi, 2.0
"""Real and imaginary part (radians) of the way of an angle in a loop, at most."""
_LOOPING = TrackSettings(most_steps=400)
"""Paths that take more steps around a loop are given up: hardly any of them arrives."""
_ORBIT_LOOPS_AT_ONCE = 4
_MOST_ORBIT_LOOPS = 60
"""Loops at most in search of connections between known roots."""
_ORBITS_APART = 10.0
"""Evidence that orbits which no loop connects are apart."""
_LOOPS_APART = 20
"""Loops in a row that connect no two orbits before orbits are told apart. A loop around one branch
point moves every root and connects only the pairs that meet there, so that moved roots alone are no
evidence: where one loop in five would connect two orbits, twenty miss it once in a hundred times.
"""


class TooManyRootsError(Exception):
    """A search that was given up; holds how many roots had been met."""


@dataclass(frozen=True, eq=False)
class Fibre:
    """Roots z (width, n) of F(., k); `orbits` labels the roots by what the loops have connected;
    `evidence` is sum -log10(1 - share of roots moved) over the loops since the last new root;
    `mirrors` groups roots that symmetries of the closure carry to each other.
    """

    z: np.ndarray
    k: np.ndarray
    orbits: np.ndarray
    evidence: float
    loops: int
    seed: int
    mirrors: Orbits | None = None


@dataclass
class _Found:
    """Distinct roots met so far; `parents` joins those that loops have connected."""

    system: AlgebraicSystem
    z: np.ndarray
    parents: list[int]

    @staticmethod
    def of(system: AlgebraicSystem, z: np.ndarray) -> _Found:
        first = first_of_each(system, z)
        return _Found(system, z[:, first], list(range(len(first))))

    def match(self, z: np.ndarray) -> np.ndarray:
        """Index of the known root that each column of z repeats, or -1."""
        return known_root(self.system, self.z, z)

    def add(self, column: np.ndarray) -> int:
        """Append a root."""
        self.z = np.concatenate([self.z, column[:, None]], axis=1)
        self.parents.append(len(self.parents))
        return len(self.parents) - 1

    def orbit(self, root: int) -> int:
        while self.parents[root] != root:
            root = self.parents[root]
        return root

    @property
    def orbits(self) -> np.ndarray:
        """The orbit of each root, counted from 0."""
        return np.unique([self.orbit(i) for i in range(len(self.parents))], return_inverse=True)[1]

    @property
    def parts(self) -> int:
        """How many orbits there are."""
        return len({self.orbit(i) for i in range(len(self.parents))})

    def join(self, i: int, j: int) -> None:
        """Roots i and j are connected."""
        self.parents[self.orbit(i)] = self.orbit(j)


@dataclass(frozen=True, eq=False)
class Looping:
    """Where loops go and end. `angles`: which known values are angles (None: none); `bound`: roots
    at which the search ends (None: no bound is known); `needed`: the evidence at which it ends;
    `most_loops`: loops after which it ends.
    """

    angles: np.ndarray | None = None
    bound: int | None = None
    needed: float = 6.0
    most_loops: int = 200


_progress: ContextVar[Progress | None] = ContextVar("progress", default=None)


@contextmanager
def told_of_searches(progress: Progress | None) -> Iterator[None]:
    """In this block the first search for generic solutions of each system tells how far it has
    come, wherever it is begun.
    """
    token = _progress.set(progress)
    try:
        yield
    finally:
        _progress.reset(token)


def progress_of_searches() -> Progress | None:
    """What is told how far a search for generic solutions has come."""
    return _progress.get()


def fibre(
    system: AlgebraicSystem,
    points: Points,
    rng: np.random.Generator,
    seed: int,
    rank: int,
    looping: Looping,
    known: tuple[np.ndarray, np.ndarray] | None = None,
    progress: Progress | None = None,
) -> Fibre | None:
    """Loop until a bound is reached or the evidence is enough. None where no seed was found.
    `known` are roots and base to begin with.
    """
    found, k0 = _begin(system, points, rng, rank, known)
    if found is None:
        return None
    search = _Search(system, found, k0, looping.angles, rng)
    while search.loops < looping.most_loops and not search.is_over(looping):
        search.go_round(looping.needed, looping.most_loops)
        if progress is not None:
            progress(int(100 * min(1.0, search.evidence / looping.needed)), 100)
        if search.found.z.shape[1] == 1 and search.loops >= _IDLE_LOOPS:
            break
    found = search.found
    return Fibre(found.z, k0, found.orbits, search.evidence, search.loops, seed)


Known = tuple[np.ndarray, np.ndarray]
"""Roots (width, n) and their base."""
_CLOSED = 1e-9
"""Largest last step of Newton's method at a root."""


def agreeing_searches(
    system: AlgebraicSystem,
    search: Callable[[int, Known | None, int | None], Fibre | None],
    missing: Callable[[Fibre, int], np.ndarray],
    most: int,
) -> tuple[Fibre | None, str]:
    """All roots by as many searches as it takes until one finds nothing new, or None and why. A
    `search` takes a seed, roots to begin with, and how many are enough; what is `missing` of roots
    is told by other means at their base.
    """
    first = search(0, None, None)
    for seed in range(1, 1 + most):
        if first is None:
            return None, "no generic complex solution was found"
        count = first.z.shape[1]
        LOG.info("%d generic solutions; they are searched again from other numbers", count)
        second = search(seed, None, count)
        ends, closed = first.z[:, :0], np.zeros(0, dtype=bool)
        if second is not None:
            ends, closed = _brought(system, second.z, second.k, first.k)
        new = known_root(system, first.z, ends) < 0
        others = np.hstack([missing(first, seed), ends[:, new & closed]])
        # a root that is lost on its way may be another one; of one far off, where rounding alone
        # moves Newton's method by more, it is enough to come to one that is known
        alike = second is not None and second.z.shape[1] == ends.shape[1] == count
        alike = alike and not new.any()
        if alike and not others.shape[1]:
            return first, ""
        first = search(seed + 100, (np.hstack([first.z, others]), first.k), None)
    return None, "independent searches for the generic count disagree"


def roots_beside(system: AlgebraicSystem, start: Fibre, z: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Of roots z at k, (known,) or (known, n), those that lead to others at the start's base than
    it has.
    """
    ends, closed = _brought(system, z, k, start.k)
    return ends[:, closed & (known_root(system, start.z, ends) < 0)]


def _brought(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, base: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Roots at a base that roots z at k, (known,) or (known, n), lead to; which are closed."""
    ends, last = newton(system, carried(system, z, k, base), base)
    return ends, last <= _CLOSED


@dataclass
class _Search:
    """Loops of the known values at k0 and what they have found; `work` is what MOST_WORK bounds."""

    system: AlgebraicSystem
    found: _Found
    k0: np.ndarray
    angles: np.ndarray | None
    rng: np.random.Generator
    evidence: float = 0.0
    loops: int = 0
    work: float = 0.0
    at_once: int = _FEWEST_AT_ONCE
    apart: int = 0
    """Loops since the last that found a root or connected two orbits."""

    def is_over(self, looping: Looping) -> bool:
        """Whether the bound or the evidence is reached, and orbits that are left have stayed apart
        for long enough.
        """
        reached = looping.bound is not None and self.found.z.shape[1] >= looping.bound
        return (reached or self.evidence >= looping.needed) and (
            self.found.parts == 1 or self.apart >= _LOOPS_APART
        )

    def go_round(self, needed: float, most_loops: int) -> None:
        """Several loops at once, all of the same roots. Where one finds a root, none of them is
        evidence: the others did not move it. After idle ones come as many as the evidence `needed`
        seems to take.
        """
        z, parts = self.found.z, self.found.parts
        roots = z.shape[1]
        count = min(self.at_once, most_loops - self.loops, max(1, _PATHS_AT_ONCE // roots))
        loops = around(self.system, z, [self._triangle() for _ in range(count)])
        self.loops += count
        self.work += (
            max(loop.steps for loop in loops) * self.system.cost * (1 + count * roots / 100)
        )
        if self.work > MOST_WORK:
            raise TooManyRootsError(roots)
        moved = [_absorb(self.found, loop) for loop in loops]
        if self.found.z.shape[1] > MOST_ROOTS:
            raise TooManyRootsError(self.found.z.shape[1])
        if self.found.z.shape[1] > roots:
            self.evidence, self.at_once, self.apart = 0.0, _FEWEST_AT_ONCE, 0
            return
        self.apart = self.apart + count if self.found.parts == parts else 0
        gained = sum(
            _evidence(m, roots) for m, loop in zip(moved, loops, strict=True) if loop.arrived.any()
        )
        self.evidence += gained
        fewest = _ORBIT_LOOPS_AT_ONCE if self.found.parts > 1 else 1
        self.at_once = int(
            np.clip(
                np.ceil((needed - self.evidence) / max(gained / count, 0.1)), fewest, _LOOPS_AT_ONCE
            )
        )

    def _triangle(self) -> list[np.ndarray]:
        """A random loop k0, k1, k2, k0."""
        radius = loop_radius(self.rng)
        ways = [radius * complex_normal(len(self.k0), self.rng) for _ in range(2)]
        return [self.k0, *(self.k0 + within_reach(way, self.angles) for way in ways), self.k0]


def _evidence(moved: int, roots: int) -> float:
    """Of one loop that found no root: -log10 of the share of roots that it left alone."""
    return float(-np.log10(1 - min(moved / roots, 1 - 1e-3)))


def _begin(
    system: AlgebraicSystem,
    points: Points,
    rng: np.random.Generator,
    rank: int,
    known: tuple[np.ndarray, np.ndarray] | None,
) -> tuple[_Found | None, np.ndarray]:
    """The known roots, or a first seed and what other seeds give at its base."""
    if known is not None:
        z, k0 = known
        return _Found.of(system, z), k0
    z, k = seed_roots(system, points, rng, rank, _SEEDS)
    if not z.shape[1]:
        return None, np.zeros(0)
    return _Found.of(
        system, np.hstack([z[:, :1], carried(system, z[:, 1:], k[:, 1:], k[:, 0])])
    ), k[:, 0]


def loop_radius(rng: np.random.Generator) -> float:
    """Log-uniform between 0.7 and 5 sizes (or radians), at times up to 30."""
    return float(
        0.7 * (5.0 / 0.7) ** rng.uniform() if rng.uniform() < 0.85 else 5.0 * 6.0 ** rng.uniform()
    )


@dataclass(frozen=True, eq=False)
class _Loop:
    """What one loop came to: an end for each root that it began with, which of them arrived, and
    the steps taken.
    """

    z: np.ndarray
    arrived: np.ndarray
    steps: int


def within_reach(way: np.ndarray, angles: np.ndarray | None) -> np.ndarray:
    """A way from a base of known values, with its angles shortened to what loops need: branch
    points repeat after a whole turn, and where imaginary parts are large sines and cosines are one
    exponential, which paths follow slowly or not at all.
    """
    if angles is None or not angles.any():
        return way
    turned = _LONGEST_TURN * np.tanh(way.real / _LONGEST_TURN) + 1j * _HIGHEST * np.tanh(
        way.imag / _HIGHEST
    )
    return np.where(angles, turned, way)


def around(
    system: AlgebraicSystem, z: np.ndarray, polygons: Sequence[Sequence[np.ndarray]]
) -> list[_Loop]:
    """Roots z (width, n) tracked along closed polygons of equally many corners, all with the same
    first corner.
    """
    ends, arrived = (
        [z.copy() for _ in polygons],
        [np.ones(z.shape[1], dtype=bool) for _ in polygons],
    )
    steps = [0] * len(polygons)
    for sides in zip(*(pairwise(corners) for corners in polygons), strict=True):
        tracked = track_lines(
            system, [e[:, a] for e, a in zip(ends, arrived, strict=True)], sides, _LOOPING
        )
        for i, t in enumerate(tracked):
            there = np.flatnonzero(arrived[i])
            ends[i][:, there], arrived[i][there], steps[i] = t.z, t.arrived, steps[i] + t.steps
    counts = [int(a.sum()) for a in arrived]
    if sum(counts):
        polished, last = newton(
            system, np.hstack([e[:, a] for e, a in zip(ends, arrived, strict=True)]), polygons[0][0]
        )
        begins = np.cumsum([0, *counts])
        for i, begin in enumerate(begins[:-1]):
            there, here = np.flatnonzero(arrived[i]), slice(begin, begins[i + 1])
            ends[i][:, there], arrived[i][there] = polished[:, here], last[here] <= 1e-9
    return [_Loop(*parts) for parts in zip(ends, arrived, steps, strict=True)]


def orbits(
    system: AlgebraicSystem,
    z: np.ndarray,
    k0: np.ndarray,
    corner: Callable[[], np.ndarray],
) -> np.ndarray:
    """Labels of roots by what loops through pairs of corners connect, until all are one or the
    evidence since the last connection is `_ORBITS_APART` and `_LOOPS_APART` have connected none.
    All zero where the loops leave a root alone: that is no evidence of a part of its own.
    """
    found, evidence, loops, apart = _Found.of(system, z), 0.0, 0, 0
    while (
        found.parts > 1
        and (evidence < _ORBITS_APART or apart < _LOOPS_APART)
        and loops < _MOST_ORBIT_LOOPS
    ):
        count = max(1, min(_ORBIT_LOOPS_AT_ONCE, _PATHS_AT_ONCE // z.shape[1]))
        for loop in around(system, found.z, [[k0, corner(), corner(), k0] for _ in range(count)]):
            before, loops = found.parts, loops + 1
            moved = _absorb(found, replace(loop, arrived=loop.arrived & (found.match(loop.z) >= 0)))
            evidence, apart = (
                (evidence + _evidence(moved, z.shape[1]), apart + 1)
                if found.parts == before
                else (0.0, 0)
            )
    labels = found.orbits
    are_apart = np.bincount(labels).min() > 1 and evidence >= _ORBITS_APART
    return labels if are_apart else np.zeros_like(labels)


def _absorb(found: _Found, loop: _Loop) -> int:
    """Unite roots with the ends of a loop that began at the first of them; how many it has
    moved.
    """
    moved, there = 0, np.flatnonzero(loop.arrived)
    if not there.size:
        return 0
    for i, known in zip(there.tolist(), found.match(loop.z[:, there]).tolist(), strict=True):
        j = known
        if j < 0:
            j = int(found.match(loop.z[:, [i]])[0])
            j = found.add(loop.z[:, i]) if j < 0 else j
        moved += j != i
        found.join(i, j)
    return moved
