"""Distinct roots of one independent part of a problem, and how roots are told apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.linear_algebra import conditions
from symkin.numeric.system import System
from symkin.numeric.tolerances import (
    CLOSED_CONFIGURATION,
    CLOSURE_TOLERANCE,
    DISTINCT_ROOTS,
    MULTIPLE_ROOT_SHARE,
    SUSPECT_CONDITION,
)
from symkin.position.solution import PartialProof

MOST_MODES = 20_000
_DIGITS_LEFT = 100.0
"""Rounding errors of a root, in units of its condition times the machine's precision."""
_CONTINUUM_SAMPLE = 5


@dataclass(frozen=True, eq=False)
class Proofs:
    """Of each real root: whether it is certified, and its radius (length unit; NaN without certificate). `theorem` names
    the bound that the certified roots reach, so that there are no others; `distinct` complex roots were certified and
    proved to differ; `reason` why some real root is not certified; `partial` what is proved of each all the same, where rows are
    redundant (None for certified roots)."""

    certified: np.ndarray
    radius: np.ndarray
    theorem: str | None
    distinct: int
    reason: str | None
    partial: tuple[PartialProof | None, ...] = ()

    def of(self, number: int, system: System) -> PartialProof | None:
        """What is proved of one root of a system: of all rows, where it is certified."""
        if self.certified[number]:
            return PartialProof.whole(int(system.rows.shape[0]), float(self.radius[number]))
        return self.partial[number] if self.partial else None


@dataclass(frozen=True, eq=False)
class Roots:
    """Distinct real roots of one block: points (n, width) and what is known of them.

    From starts: `hits` (n,) and `starts`. From paths: `complex_count` distinct complex roots, `unresolved` paths. In
    both: the least error reached where there is no root, members of a continuum that were met, and what is proved.
    `engine`: what has tracked the paths. `complex_sets`: paths ended on a set of complex roots that are not isolated.
    `missing`: why there are fewer complex roots than generic ones.
    """

    system: System
    points: np.ndarray
    hits: np.ndarray | None
    smallest_residual: float
    starts: int | None = None
    continuum: np.ndarray | None = None
    complex_count: int | None = None
    unresolved: int = 0
    sampled: bool = True
    proofs: Proofs | None = None
    complex_sets: bool = False
    engine: str | None = None
    missing: str | None = None

    @property
    def unseen(self) -> float:
        """Chao's lower bound f1^2 / (2 f2) of the roots not yet hit, with f2 at least 1."""
        if self.hits is None:
            return 0.0
        once, twice = int(np.sum(self.hits == 1)), int(np.sum(self.hits == 2))
        return once * once / (2 * max(twice, 1))

    @property
    def next_new(self) -> float:
        """Good-Turing: the share of hits that are single, the probability that the next hit is a new root."""
        total = 0 if self.hits is None else int(np.sum(self.hits))
        return float(np.sum(self.hits == 1)) / total if total else 1.0


def features(system: System, points: np.ndarray) -> np.ndarray:
    """Coordinates in which equal configurations are equal: lengths, size (cos, sin) of angles, size times the
    products q_i q_j of quaternions."""
    columns = []
    for c, place in zip(system.unknowns, system.slices, strict=True):
        part = points[:, place]
        if c.kind == "quaternion":
            outer = part[:, :, None] * part[:, None, :]
            columns.append(system.characteristic_length * outer.reshape(len(part), 16))
        elif c.kind == "angle":
            columns += [system.characteristic_length * np.cos(part), system.characteristic_length * np.sin(part)]
        else:
            columns.append(system.characteristic_length * part if c.kind == "turns" else part)
    return np.hstack(columns)


def merge(points: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Representatives and the label of each row of `points` (features); rows within `tolerance` are one. At most
    `MOST_MODES` are told apart; rows beyond have the label -1."""
    labels = np.full(len(points), -1)
    chosen: list[int] = []
    left = np.arange(len(points))
    while left.size and len(chosen) < MOST_MODES:
        same = np.max(np.abs(points[left] - points[left[0]]), axis=1) <= tolerance
        labels[left[same]] = len(chosen)
        chosen.append(int(left[0]))
        left = left[~same]
    return np.array(chosen, dtype=int), labels


def distinct(system: System, ends: np.ndarray, known: np.ndarray, starts: int) -> Roots:
    """Merge ends, polish the representatives to full precision, drop what fails the check, merge again. Roots of a
    continuum are set apart; once they outnumber the isolated ones, a few of them stand for the rest."""
    ends = system.wrap(system.fold(ends))
    first, labels = merge(features(system, ends), 1e-5 * system.characteristic_length)
    hits = np.bincount(labels[labels >= 0], minlength=len(first))
    order = np.argsort(-hits, kind="stable")
    polished = system.polish_many(ends[first[order]], known)
    residuals, suspect = system.residuals(polished.points, known), conditions(polished.jacobians) > SUSPECT_CONDITION
    roots: list[np.ndarray] = []
    counts, continuum, smallest, singular = [], [], np.inf, 0
    for z, left, is_singular, count in zip(polished.points, residuals.tolist(), suspect.tolist(), hits[order], strict=True):
        smallest = min(smallest, left)
        if left > CLOSURE_TOLERANCE * system.characteristic_length:
            continue
        if is_singular and moves_freely(system, z, known):
            continuum.append(z)
        else:
            roots.append(z)
            counts.append(count)
            singular += is_singular
        if len(continuum) >= _CONTINUUM_SAMPLE and len(continuum) + singular > len(roots) - singular:
            break
    points = np.array(roots).reshape(len(roots), system.width)
    first, labels = unite(system, points, known, continuum_met=bool(continuum))
    weights, labels = np.array(counts)[labels >= 0], labels[labels >= 0]
    totals = np.bincount(labels, weights=weights, minlength=len(first)).astype(int)
    members = np.array(continuum) if continuum else None
    return Roots(system, points[first], totals, smallest, starts, members)


def unite(system: System, points: np.ndarray, known: np.ndarray, *, continuum_met: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Representatives and labels of polished roots: regular ones are one within 1e-6 of the size, singular ones within
    what their condition leaves of their digits. Where a continuum was met, singular roots are counted with it (-1)."""
    if not len(points):
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    f = features(system, points)
    found = system.conditions(points, known)
    singular = found > SUSPECT_CONDITION
    first, labels = merge(f[~singular], DISTINCT_ROOTS * system.characteristic_length)
    everything = np.full(len(points), -1)
    everything[~singular] = labels
    chosen = np.flatnonzero(~singular)[first].tolist()
    if not continuum_met:
        for i in sorted(np.flatnonzero(singular), key=lambda i: -found[i]):
            if everything[i] < 0:
                tolerance = min(_DIGITS_LEFT * found[i] * np.finfo(float).eps, 1e-3) * system.characteristic_length
                same = (np.max(np.abs(f - f[i]), axis=1) <= tolerance) & singular & (everything < 0)
                everything[same] = len(chosen)
                chosen.append(int(i))
    return np.array(chosen, dtype=int), everything


def moves_freely(system: System, z: np.ndarray, known: np.ndarray) -> bool:
    """Whether the root z lies on a continuum: a step of 1e-3 of the size along a direction in which the Jacobian has
    lost its rank closes again nearby without coming back (from an isolated multiple root it comes back)."""
    _, jacobian = system.linearise_one(z, known)
    _, singular, right = np.linalg.svd(jacobian)
    lost = right[int(np.sum(singular > MULTIPLE_ROOT_SHARE * max(singular[0], 1e-300))) :]
    if len(lost) == 0:
        lost = right[-1:]
    mixed = np.random.default_rng(0).normal(size=(4 * len(lost), len(lost))) @ lost
    directions = np.vstack([lost, -lost, mixed / np.linalg.norm(mixed, axis=1, keepdims=True)])
    return any(_closes_beside(system, z, direction, known) for direction in directions)


def _closes_beside(system: System, z: np.ndarray, direction: np.ndarray, known: np.ndarray) -> bool:
    here = features(system, z[None])
    begin = system.move(z[None], 1e-3 * system.characteristic_length * direction[None])
    end = system.polish(begin[0], known, steps=30)
    if system.residual(end, known) > CLOSED_CONFIGURATION * system.characteristic_length:
        return False
    moved = np.max(np.abs(features(system, end[None]) - here))
    return bool(moved > 0.1 * np.max(np.abs(features(system, begin) - here)))
