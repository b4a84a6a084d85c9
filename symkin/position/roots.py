"""What random starts find of one block, and how roots are told apart."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from math import isnan, lgamma, log, nan, prod
from typing import TypeVar

import numpy as np

from symkin.model.joint import Coordinate
from symkin.numeric.linear_algebra import extreme_singular_values
from symkin.numeric.newton import Polished
from symkin.numeric.root_checks import (
    NEARLY_SINGULAR,
    POLISHING,
    are_one,
    are_roots,
    are_suspect,
    lost_directions,
)
from symkin.numeric.system import System
from symkin.numeric.tolerances import (
    CLOSED_CONFIGURATION,
    DISTINCT_ROOTS,
    MULTIPLE_ROOT_SHARE,
)

Answer = TypeVar("Answer")

MOST_MODES = 20_000
_TO_A_SIDE = 1e-4
"""Of the size: steps aside from a nearly singular root to where Newton's method leads to the one on
that side.
"""
_NEAR_SINGULAR = 1e-3
"""Of the size: distance within which singular roots may be one, if the rows between them vanish
too.
"""
NOT_KNOWN = nan
"""A count that is not known, in arrays of counts: no product and no sum with it is a number."""
_LOOKED_TOGETHER = 16
"""Roots of which it is asked together whether they lie on a continuum."""
_CONTINUUM_SAMPLE = 5


@dataclass(frozen=True, eq=False)
class Sample:
    """Distinct real roots of one block that random `starts` have reached: points (n, width) and the
    `hits` (n,) of each; the least error reached, and whether members of a `continuum` were met;
    `late`: hits of the second half of the starts, and how many of them are at roots that the first
    half has not hit. Roots with no hits were found beside others, a turn of a screw away; `turned`:
    whether that was looked for beside all roots.
    """

    points: np.ndarray
    hits: np.ndarray
    smallest_residual: float
    starts: int
    continuum: bool = False
    late: tuple[int, int] = (0, 0)
    turned: bool = True

    @staticmethod
    def of_none(system: System, smallest: float, starts: int) -> Sample:
        """No root, and the least error that was reached."""
        return Sample(np.zeros((0, system.width)), np.zeros(0, dtype=int), smallest, starts)

    @property
    def unseen(self) -> float:
        """Chao's lower bound f1^2 / (2 f2) of the roots not yet hit, with f2 at least 1, without
        those that were found beside others.
        """
        beside, once, twice = (int(np.sum(self.hits == k)) for k in range(3))
        return max(0.0, once * once / (2 * max(twice, 1)) - beside)

    @property
    def next_new(self) -> float:
        """Good-Turing: the share of hits that are single, the probability that the next hit is a
        new root.
        """
        total = int(np.sum(self.hits))
        return float(np.sum(self.hits == 1)) / total if total else 1.0

    def unseen_share(self, doubt: float) -> float:
        """An upper bound of the share of hits at roots that are not hit yet, which holds but for a
        probability `doubt`: Clopper and Pearson's of the second half of the starts, whose hits are
        new with the probability that the first half left.
        """
        return binomial_bound(*self.late, doubt)


def binomial_bound(trials: int, seen: int, doubt: float) -> float:
    """The largest probability at which as few as `seen` of `trials` have a probability of `doubt`
    (Clopper, Pearson 1934).
    """
    if seen >= trials:
        return 1.0
    choices = [lgamma(trials + 1) - lgamma(k + 1) - lgamma(trials - k + 1) for k in range(seen + 1)]
    low, high = 0.0, 1.0
    for _ in range(60):
        p = 0.5 * (low + high)
        terms = (c + k * log(p) + (trials - k) * log(1.0 - p) for k, c in enumerate(choices))
        low, high = (p, high) if sum(np.exp(term) for term in terms) > doubt else (low, p)
    return high


def of_each(function: Callable[[Sequence[float]], Answer], rows: np.ndarray) -> list[Answer]:
    """What a function makes of each of some rows (n, any), asked once of equal ones."""
    told: dict[tuple[float, ...], Answer] = {}
    return [
        told[row] if row in told else told.setdefault(row, function(row))
        for row in map(tuple, rows.tolist())
    ]


def product_of_counts(counts: Iterable[float]) -> int | None:
    """The product of counts; None where one is not known."""
    known = list(counts)
    return None if any(isnan(c) for c in known) else prod(int(c) for c in known)


def sum_of_counts(counts: Iterable[float]) -> int | None:
    """The sum of counts; None where one is not known."""
    known = list(counts)
    return None if any(isnan(c) for c in known) else sum(int(c) for c in known)


def features(system: System, points: np.ndarray) -> np.ndarray:
    """Coordinates in which equal configurations are equal: lengths, size (cos, sin) of angles, size
    times the products q_i q_j of quaternions.
    """
    pairs = zip(system.unknowns, system.slices, strict=True)
    return features_of(pairs, points, system.characteristic_length)


def features_of(
    pairs: Iterable[tuple[Coordinate, slice]], points: np.ndarray, size: float
) -> np.ndarray:
    """As `features`, of coordinates and their places."""
    columns = []
    for c, place in pairs:
        part = points[:, place]
        if c.is_rotation:
            outer = part[:, :, None] * part[:, None, :]
            columns.append(size * outer.reshape(len(part), 16))
        elif c.is_periodic:
            columns += [size * np.cos(part), size * np.sin(part)]
        else:
            columns.append(size * part if c.is_advancing else part)
    return np.concatenate(columns, axis=1)


def merge(points: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Representatives and the label of each row of `points` (features); rows within `tolerance` are
    one. At most `MOST_MODES` are told apart; rows beyond have the label -1.
    """
    labels = np.full(len(points), -1)
    chosen: list[int] = []
    left = np.arange(len(points))
    while left.size and len(chosen) < MOST_MODES:
        same = np.max(np.abs(points[left] - points[left[0]]), axis=1) <= tolerance
        labels[left[same]] = len(chosen)
        chosen.append(int(left[0]))
        left = left[~same]
    return np.array(chosen, dtype=int), labels


def distinct(system: System, ends: np.ndarray, known: np.ndarray, starts: int) -> Sample:
    """Merge ends, polish the representatives to full precision, drop what is no root, merge again.
    Roots of a continuum are set apart; once they outnumber the isolated ones, a few of them stand
    for the rest.
    """
    ends = system.wrap(system.fold(ends))
    first, labels = merge(features(system, ends), 1e-5 * system.characteristic_length)
    ends_at, hits = labels, np.bincount(labels[labels >= 0], minlength=len(first))
    order = np.argsort(-hits, kind="stable")
    found = polished_roots(system, ends[first[order]], known, most_of_continuum=_CONTINUUM_SAMPLE)
    first, labels = unite(system, found.points, known, continuum_met=found.continuum is not None)
    counts = np.where(found.origin < 0, 0, hits[order][found.origin])
    totals = np.bincount(
        labels[labels >= 0], weights=counts[labels >= 0], minlength=len(first)
    ).astype(int)
    own = (found.origin >= 0) & (labels >= 0)
    root_of = np.full(len(hits) + 1, -1)
    root_of[order[found.origin[own]]] = labels[own]
    late = _late_hits(root_of[ends_at])
    return Sample(
        found.points[first],
        np.maximum(totals, 1),
        found.smallest_residual,
        starts,
        found.continuum is not None,
        late,
    )


def _late_hits(at: np.ndarray) -> tuple[int, int]:
    """Hits in the second half of the starts, and those of roots that the first half has not met;
    `at` are roots by starts, -1 of none.
    """
    at = at[at >= 0]
    half = len(at) // 2
    return len(at) - half, int(np.sum(~np.isin(at[half:], at[:half])))


@dataclass(frozen=True, eq=False)
class PolishedRoots:
    """Isolated roots `points` (n, width) with the candidates `origin` (n,) that they come from, -1
    for those found beside others; members of a continuum; the least closure error of all
    candidates.
    """

    points: np.ndarray
    origin: np.ndarray
    continuum: np.ndarray | None
    smallest_residual: float


def polished_roots(
    system: System,
    candidates: np.ndarray,
    known: np.ndarray,
    *,
    most_of_continuum: int | None = None,
) -> PolishedRoots:
    """Candidates (n, width) polished on all rows: those that are roots (see `are_roots`). Beside
    nearly singular ones the other root of the pair is looked for, on either side. The candidates
    are left once `most_of_continuum` of their roots lie on one and these outnumber other singular
    ones.
    """
    polished = system.polish_many(candidates, known, POLISHING)
    polished = replace(polished, points=system.fold(polished.points))
    residuals = system.residuals(polished.points, known)
    closed, extremes = (
        are_roots(system, polished, residuals),
        extreme_singular_values(polished.jacobians),
    )
    suspect = are_suspect(extremes)
    roots, continuum = _apart_from_continuum(
        system, polished.points, known, np.flatnonzero(closed), suspect, most_of_continuum
    )
    beside = _beside(
        system, polished, [i for i in roots if extremes[i, 1] < NEARLY_SINGULAR], known
    )
    return PolishedRoots(
        np.concatenate([polished.points[roots], beside]),
        np.concatenate([np.array(roots, dtype=int), np.full(len(beside), -1)]),
        polished.points[continuum] if continuum else None,
        float(np.min(residuals, initial=np.inf)),
    )


def _apart_from_continuum(
    system: System,
    points: np.ndarray,
    known: np.ndarray,
    closed: np.ndarray,
    suspect: np.ndarray,
    most_of_continuum: int | None,
) -> tuple[list[int], list[int]]:
    """The places of isolated roots and of members of a continuum among the `closed` ones, as many
    as are looked at (see `polished_roots`); `suspect` are roots that may be either.
    """
    roots: list[int] = []
    continuum: list[int] = []
    for begin in range(0, len(closed), _LOOKED_TOGETHER):
        some = closed[begin : begin + _LOOKED_TOGETHER]
        doubtful = some[suspect[some]]
        free = set(doubtful[move_freely(system, points[doubtful], known)].tolist())
        for i in some.tolist():
            (continuum if i in free else roots).append(i)
            singular = np.count_nonzero(suspect[roots])
            if (
                most_of_continuum is not None
                and len(continuum) >= most_of_continuum
                and len(continuum) > len(roots) - 2 * singular
            ):
                return roots, continuum
    return roots, continuum


def _beside(system: System, polished: Polished, places: list[int], known: np.ndarray) -> np.ndarray:
    """Roots (n, width) that Newton's method reaches from either side of nearly singular ones: of
    two that nearly meet, both.
    """
    directions = [lost_directions(polished.jacobians[i], MULTIPLE_ROOT_SHARE) for i in places]
    if not directions:
        return np.zeros((0, system.width))
    begin = np.repeat(polished.points[places], [len(d) for d in directions], axis=0)
    starts = system.move(
        begin, _TO_A_SIDE * system.characteristic_length * np.concatenate(directions)
    )
    found = system.polish_many(starts, known, POLISHING)
    points = system.fold(found.points)
    return points[are_roots(system, replace(found, points=points), system.residuals(points, known))]


def unite(
    system: System, points: np.ndarray, known: np.ndarray, *, continuum_met: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Representatives and labels of polished roots: two near each other are one where the rows
    halfway vanish to rounding (see `are_one`). Where a continuum was met, singular roots are
    counted with it (-1).
    """
    if not len(points):
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    f, extremes = (
        features(system, points),
        extreme_singular_values(system.linearise(points, known)[1]),
    )
    singular = are_suspect(extremes)
    near = np.where(singular, _NEAR_SINGULAR, DISTINCT_ROOTS) * system.characteristic_length
    labels = np.full(len(points), -1)
    chosen: list[int] = []
    left = np.argsort(np.where(singular, extremes[:, 1], np.inf), kind="stable")
    left = left[~singular[left]] if continuum_met else left
    while left.size and len(chosen) < MOST_MODES:
        i, others = left[0], left[1:]
        same = np.max(np.abs(f[others] - f[i]), axis=1) <= near[i]
        if same.any():
            same[same] = are_one(system, points[i], points[others[same]], known)
        labels[[i, *others[same]]] = len(chosen)
        chosen.append(int(i))
        left = others[~same]
    return np.array(chosen, dtype=int), labels


def move_freely(system: System, points: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Which roots (n, width) lie on a continuum: a step of 1e-3 of the size along a direction in
    which the Jacobian has lost its rank closes again nearby without coming back (from an isolated
    multiple root it comes back).
    """
    if not len(points):
        return np.zeros(0, dtype=bool)
    _, jacobians = system.linearise(points, known)
    lost = [lost_directions(jacobian, MULTIPLE_ROOT_SHARE) for jacobian in jacobians]
    owner = np.repeat(np.arange(len(points)), [len(directions) for directions in lost])
    here, size = features(system, points)[owner], system.characteristic_length
    begin = system.move(points[owner], 1e-3 * size * np.concatenate(lost))
    end = system.polish_many(begin, known, steps=30).points
    closed = system.residuals(end, known) <= CLOSED_CONFIGURATION * size
    moved, stepped = (
        np.max(np.abs(features(system, places) - here), axis=1, initial=0.0)
        for places in (end, begin)
    )
    free = closed & (moved > 0.1 * stepped)
    return np.bincount(owner, weights=free, minlength=len(points)) > 0
