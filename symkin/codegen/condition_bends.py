"""Bound how far the conditions of formulas bend away from their chord along a straight line of
known values.

A condition that reads the root of another one, or is divided by it, bends the more the nearer that
one is to zero: sqrt(g)'' holds -g'^2 / (4 g^(3/2)), and (n^2 / g^2)'' holds 6 n^2 g'^2 / g^4. Its
bend is bounded after it has been multiplied by the shares of the conditions that it reads, g^(3/2)
of a root and g^4 of a divisor, g over its usual size and at most 1: a number that stays as it is up
to the fold. Generated code divides by the shares that the conditions keep in each part of a line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.codegen.line_bounds import Span, bend_of
from symkin.codegen.newton_kernel import rounded, rounded_up

_RAISED = 1.5
"""What the largest bend over samples is multiplied by."""
_LEAST_SHARE = 1e-9
"""Share of the conditions that are read below which a sample says nothing but rounding."""
_STEPS = 60
"""Steps by which the largest samples are followed uphill."""
_MOST_UNIT = 100.0
"""How many times its scale a known value's unit is at most."""
_ALIKE = 0.5
"""Share of the largest from which on a known value's part of a bend is as large as that one."""
_MOST_GIVEN = 3
"""Known values of which waves are summed: their samples grow by a power with each."""


@dataclass(frozen=True)
class ConditionBend:
    """An eighth of a condition's largest second derivative over its usual size, known values in
    their units, multiplied by the shares of the conditions `read` (their numbers); `ground` says
    how it is known.
    """

    eighth: float
    ground: str
    read: tuple[int, ...]


def share_of(condition: ca.SX, *, divides: bool) -> ca.SX:
    """What a condition over its usual size leaves of the bend of those that read it."""
    if divides:
        return ca.fmin(ca.fabs(condition), 1) ** 4
    kept = ca.fmin(ca.fmax(condition, 0), 1)
    return kept * ca.sqrt(kept)


def condition_bend(
    condition: ca.SX,
    share: ca.SX,
    values: ca.SX,
    scales: np.ndarray,
    units: np.ndarray,
    spans: Sequence[Span] | None,
    points: np.ndarray,
    read: tuple[int, ...],
) -> ConditionBend:
    """Bound the bend of a condition over its usual size, a function of `values` whose changes are
    told in `units`; `share` is that of the conditions that it reads, `spans` are what the values
    run over (None: nobody knows), `points` (n, known) samples in them, and `scales` how far apart
    others are tried.
    """
    if not read and spans is not None and len(spans) <= _MOST_GIVEN:
        function = ca.Function("g", [values], [condition])
        bend = bend_of(lambda given: np.asarray(function(given.T)).ravel(), spans)
        if bend is not None:
            return ConditionBend(rounded_up(float(np.max(bend.weights)) / 8.0), "proved", read)
    hessian = ca.Function("h", [values], [ca.hessian(condition, values)[0], share])
    largest = _largest(hessian, points, scales, units)
    return ConditionBend(rounded_up(_RAISED * largest / 8.0), "sampled", read)


def even_units(
    conditions: Sequence[ca.SX], values: ca.SX, scales: np.ndarray, near: np.ndarray
) -> np.ndarray:
    """Units of the known values in which conditions bend alike with each: of one with which they
    bend much less than with others more than its scale. `near` (n, known) are known values of
    regular configurations.
    """
    share = np.full(len(scales), 1.0 / _MOST_UNIT)
    for condition in conditions:
        hessian = ca.Function("h", [values], [ca.hessian(condition, values)[0]])
        sizes = np.abs([np.asarray(hessian(at)) for at in near]) * np.outer(scales, scales)
        rows = np.median(sizes, axis=0).max(axis=1)
        if np.isfinite(rows).all() and rows.max() > 0.0:
            share = np.maximum(share, np.sqrt(rows / rows.max()))
    return scales * [rounded(float(1.0 / v)) if v < _ALIKE else 1.0 for v in share]


def _largest(
    hessian: ca.Function, points: np.ndarray, scales: np.ndarray, units: np.ndarray
) -> float:
    """The largest norm of a matrix, known values in their units, times its share over points (n,
    width), the eight largest followed uphill by random steps of the scales that shrink; 1 where no
    point has a share.
    """

    def norms(at: np.ndarray) -> np.ndarray:
        matrices, shares = (np.asarray(part) for part in hessian.map(len(at))(at.T))
        bent = matrices.reshape(len(units), len(at), len(units)).transpose(1, 0, 2)
        kept = shares.ravel()
        told = (kept > _LEAST_SHARE) & np.isfinite(bent).all(axis=(1, 2))
        found = np.zeros(len(at))
        scaled = bent[told] * np.outer(units, units)
        found[told] = np.linalg.norm(scaled, 2, axis=(1, 2)) * kept[told]
        return found

    rng, sizes = np.random.default_rng(8), norms(points)
    chosen = np.argsort(sizes)[-8:]
    at, best = points[chosen], sizes[chosen]
    for k in range(_STEPS):
        tried = at + 0.5 * 0.9**k * rng.uniform(-1, 1, at.shape) * scales
        tried_sizes = norms(tried)
        better = tried_sizes > best
        at, best = np.where(better[:, None], tried, at), np.where(better, tried_sizes, best)
    return float(best.max()) or 1.0
