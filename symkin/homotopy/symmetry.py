"""Symmetries of an algebraic system: maps of the unknowns that carry roots to roots at the same
known values.

A map T with F_i(T z, k) = F_i(z, k) or -F_i(z, k) for every row takes roots to roots and paths to
paths, so that one path of each orbit need be tracked. Maps that change signs of unknowns and turn
angles by half turns are found from the rows alone; others, such as the reflection of a platform
with coplanar points (see `coplanar`), are given and checked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import casadi as ca
import numpy as np

from symkin.closure.numpy_code import vectorise
from symkin.homotopy.algebraic import SAME_ROOT, AlgebraicSystem, complex_normal
from symkin.homotopy.tracker import Tracked

_EQUAL = 1e-11
"""Largest difference between a row's absolute values at a point and at its image, over the largest
row. What a symmetry is broken by must be larger to be seen, and rounding smaller.
"""
_MOST_FLIPS = 14
"""Changes of one row's unknowns that are tried in all combinations; a row with more of them is
taken to admit none.
"""
_MOST_MAPS = 64
Draw = Callable[[np.random.Generator], np.ndarray]
"""Draws complex known values (known,) at which a symmetry must hold."""


@dataclass(frozen=True, eq=False)
class Symmetries:
    """A group of maps z -> M z + t: `matrices` (maps, width, width), `shifts` (maps, width); the
    identity is first.
    """

    matrices: np.ndarray
    shifts: np.ndarray

    def __len__(self) -> int:
        return len(self.matrices)

    def apply(self, z: np.ndarray) -> np.ndarray:
        """Images (maps, width, n) of points z (width, n)."""
        return self.matrices @ z + self.shifts[:, :, None]


@dataclass(frozen=True, eq=False)
class Orbits:
    """Roots at one k: `labels` (n,) numbers the orbit of each, `first` (orbits,) are roots that
    stand for them, and `maps` (n,) take those to the others. `whole`: all images were among the
    roots.
    """

    symmetries: Symmetries
    labels: np.ndarray
    first: np.ndarray
    maps: np.ndarray
    whole: bool

    def unfold(self, z: np.ndarray) -> np.ndarray:
        """The continuations (width, n) of all roots from those (width, orbits) of the ones that
        stand for them.
        """
        images = self.symmetries.apply(z)
        return images[self.maps, :, self.labels].T

    def unfold_tracked(self, tracked: Tracked) -> Tracked:
        """What all paths came to, from the paths of `first`."""
        z = self.unfold(tracked.z)
        return Tracked(
            z, *(values[self.labels] for values in (tracked.arrived, tracked.s, tracked.tries))
        )


def orbits_under(system: AlgebraicSystem, symmetries: Symmetries, z: np.ndarray) -> Orbits:
    """Group roots z (width, n) of a common k into orbits."""
    f = system.features(z)
    n = z.shape[1]
    labels, maps, whole = np.full(n, -1), np.zeros(n, dtype=int), True
    first: list[int] = []
    for i in range(n):
        if labels[i] >= 0:
            continue
        images = system.features(symmetries.apply(z[:, [i]])[:, :, 0].T)
        distance = np.max(np.abs(images[:, None] - f[None]), axis=2)
        nearest = np.argmin(distance, axis=1)
        met = distance[np.arange(len(nearest)), nearest] < SAME_ROOT
        whole &= bool(met.all())
        for m in np.flatnonzero(met)[::-1]:
            labels[nearest[m]], maps[nearest[m]] = len(first), m
        first.append(i)
    return Orbits(symmetries, labels, np.array(first, dtype=int), maps, whole)


# --- finding them ---------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Flip:
    """A change of one unknown: its sign, or a half turn."""

    place: int
    sign: float
    shift: float


def find_symmetries(
    system: AlgebraicSystem, draw: Draw | None = None, others: Sequence[np.ndarray] = ()
) -> Symmetries:
    """The group of sign changes, half turns and those of the matrices `others` (width, width) under
    which every row keeps its absolute value, at all known values that `draw` gives (default: all).
    Maps that move no root are left out: the sign of a ray, that of a rod's length.
    """
    rows = _Rows(system, draw)
    flips = _flips(system)
    generators = [
        _map(system, [flips[b] for b in np.flatnonzero(bits)])
        for bits in _admitted(system, rows, flips)
    ]
    generators += [(np.asarray(matrix, dtype=complex), np.zeros(system.width)) for matrix in others]
    return _group(system, [g for g in generators if rows.keep(*g)])


class _Rows:
    """The rows as numbers at random points."""

    def __init__(self, system: AlgebraicSystem, draw: Draw | None) -> None:
        self.system = system
        self.rng = np.random.default_rng(0)
        self.draw = draw or (lambda rng: complex_normal(system.k.shape[0], rng))
        self.code = vectorise(
            ca.Function("r", [system.z, system.k], [ca.densify(system.rows)], {"cse": True})
        )

    def at(self, z: np.ndarray, k: np.ndarray) -> np.ndarray:
        """|F| (n, rows) at points z (width, n), over the largest."""
        f = np.zeros((z.shape[1], self.system.count, 1), dtype=complex)
        self.code(z, np.repeat(k[:, None], z.shape[1], axis=1), f)
        return f[:, :, 0]

    def same(self, images: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Whether each row keeps its absolute value at each image (n, rows) of random points."""
        kept = np.bool_(True)
        for _ in range(2):
            z, k = complex_normal(self.system.width, self.rng), self.draw(self.rng).astype(complex)
            here, there = self.at(z[:, None], k), self.at(images(z), k)
            bound = _EQUAL * np.max(np.abs(here))
            kept = kept & ((np.abs(there - here) < bound) | (np.abs(there + here) < bound))
        return np.asarray(kept)

    def keep(self, matrix: np.ndarray, shift: np.ndarray) -> bool:
        """Whether a map is a symmetry."""
        return bool(self.same(lambda z: (matrix @ z + shift)[:, None]).all())


def _flips(system: AlgebraicSystem) -> list[_Flip]:
    """One sign a unknown (a ray's first coordinate keeps its own), and a half turn an angle."""
    fixed = system.projective[:1]
    signs = [_Flip(i, -1.0, 0.0) for i in range(system.width) if i not in fixed]
    return signs + [_Flip(i, 1.0, np.pi) for i, c in enumerate(system.unknowns) if c.is_periodic]


def _admitted(system: AlgebraicSystem, rows: _Rows, flips: list[_Flip]) -> np.ndarray:
    """Generators (any, flips) of the sets of flips that every row admits, as bits.

    The sets that a row admits are a vector space over the field of two elements. It is found for
    rows of the same unknowns by trying all sets of their flips; the equations that cut it out are
    collected over the rows and solved.
    """
    pattern = np.asarray(ca.DM(ca.jacobian_sparsity(system.rows, system.z), 1)) != 0
    equations: list[np.ndarray] = []
    for support in np.unique(pattern, axis=0):
        members = np.flatnonzero((pattern == support).all(axis=1))
        bits = [b for b, flip in enumerate(flips) if support[flip.place]]
        if len(bits) > _MOST_FLIPS:
            turns = [b for b in bits if flips[b].shift]
            equations += [_unit(b, len(flips)) for b in turns]
            bits = [b for b in bits if b not in turns]
        if len(bits) > _MOST_FLIPS:
            equations += [_unit(b, len(flips)) for b in bits]
            continue
        chosen = _all_sets(len(bits))
        good = rows.same(partial(_images, flips=[flips[b] for b in bits], chosen=chosen))[
            :, members
        ]
        for equation in binary_null_space(chosen[good.all(axis=1)]):
            equations.append(np.zeros(len(flips), dtype=bool))
            equations[-1][bits] = equation
    return binary_null_space(np.array(equations, dtype=bool).reshape(-1, len(flips)))


def binary_null_space(a: np.ndarray) -> np.ndarray:
    """Basis (any, n) of the x with a x = 0 over the field of two elements, a (m, n) of booleans."""
    a = np.unique(a.astype(bool), axis=0)
    n = a.shape[1]
    pivots: list[int] = []
    for column in range(n):
        rank = len(pivots)
        below = np.flatnonzero(a[rank:, column])
        if below.size == 0:
            continue
        a[[rank, rank + below[0]]] = a[[rank + below[0], rank]]
        others = a[:, column].copy()
        others[rank] = False
        a[others] ^= a[rank]
        pivots.append(column)
    free = [c for c in range(n) if c not in pivots]
    basis = np.zeros((len(free), n), dtype=bool)
    for i, column in enumerate(free):
        basis[i, column] = True
        basis[i, pivots] = a[: len(pivots), column]
    return basis


def _all_sets(count: int) -> np.ndarray:
    return (np.arange(2**count)[:, None] >> np.arange(count)) % 2 == 1


def _images(z: np.ndarray, flips: Sequence[_Flip], chosen: np.ndarray) -> np.ndarray:
    """The point z (width,) under each set of flips: (width, sets)."""
    images = np.repeat(z[:, None], len(chosen), axis=1)
    for flip, taken in zip(flips, chosen.T, strict=True):
        images[flip.place, taken] = flip.sign * images[flip.place, taken] + flip.shift
    return images


def _map(system: AlgebraicSystem, flips: Sequence[_Flip]) -> tuple[np.ndarray, np.ndarray]:
    matrix, shift = np.eye(system.width, dtype=complex), np.zeros(system.width)
    for flip in flips:
        matrix[flip.place, flip.place] *= flip.sign
        shift[flip.place] = flip.sign * shift[flip.place] + flip.shift
    return matrix, shift


def _group(
    system: AlgebraicSystem, generators: Sequence[tuple[np.ndarray, np.ndarray]]
) -> Symmetries:
    """All products of the generators that differ in where they take a root; at most
    `_MOST_MAPS`.
    """
    point = complex_normal(system.width, np.random.default_rng(1))
    maps = [(np.eye(system.width, dtype=complex), np.zeros(system.width))]
    seen = [system.features(point[:, None])[0]]
    for matrix, shift in maps:
        for other, by in generators:
            new = (matrix @ other, matrix @ by + shift)
            f = system.features((new[0] @ point + new[1])[:, None])[0]
            if (
                len(maps) < _MOST_MAPS
                and min(float(np.max(np.abs(f - g))) for g in seen) > SAME_ROOT
            ):
                maps.append((new[0], new[1].real))
                seen.append(f)
    return Symmetries(np.array([m for m, _ in maps]), np.array([t for _, t in maps]))


def _unit(place: int, count: int) -> np.ndarray:
    row = np.zeros(count, dtype=bool)
    row[place] = True
    return row
