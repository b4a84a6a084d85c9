"""Say what must stay above zero along a straight line of known values, and bound how far it bends.

Formulas follow the machine while no discriminant and no divisor of theirs reaches zero. Each is a
guard g of the known values. With |g''| <= 2 K along a part of the line, t from 0 to 1,

    g >= (1 - t) g_a + t g_b - K t (1 - t),

which is above zero where K < g_a + g_b + 2 min(g_a, g_b), and no less than min(g_a, g_b) - K / 4. A
bound is proved where g is a polynomial in lengths and in cosines and sines of angles, or P + Q r of
such ones with the root r of another guard; else it is the largest of samples, raised. A sampled
guard that reads the root of another one, or is divided by it, bends the more the nearer that one is
to zero: sqrt(h)'' holds -h'^2 / (4 h^(3/2)), and (n^2 / h^2)'' holds 6 n^2 h'^2 / h^4. Its bend is
sampled after it has been multiplied by the shares of the guards that it reads, h^(3/2) of a root
and h^4 of a divisor, h over its usual size and at most 1: a number that stays as it is up to the
fold.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import factorial, prod
from typing import Literal

import casadi as ca
import numpy as np

from symkin.codegen.line_bounds import Bend, Span, bend_of
from symkin.codegen.steps.newton_kernel import rounded

Ground = Literal["proved", "sampled", "measured"]
"""How a bound is known: of all values of a range, of samples, or of the line itself as it goes."""

NOISE = 1e-9
"""Share of the largest weight below which another is rounding."""
SLIDE_PARTS = (1.0 / 16, 1.0 / 4, 1.0)
"""Parts of a slide's range for which bounds are made: a line takes those of the first that holds
it.
"""
_ROOT_DEGREE = 4
"""Highest degree in a root that is looked for, less one."""
_POINTS = 400
"""Samples of a range."""
_RAISED = 1.5
"""What the largest bend over samples is multiplied by."""
_LEAST_SHARE = 1e-9
"""Share of the guards that are read below which a sample says nothing but rounding."""
_STEPS = 60
"""Steps by which the largest samples are followed uphill."""
_MOST_UNIT = 100.0
"""How many times its scale a known value's unit is at most."""
_ALIKE = 0.5
"""Share of the largest from which on a known value's part of a bend is as large as that one."""


@dataclass(frozen=True)
class Bound:
    """K by the squares of the known values' changes (known,): `plain`, and, of a guard that holds
    the root of another one's value m, what is multiplied by m^(-1/2) and m^(-3/2). `size` bounds
    the guard itself.
    """

    size: float
    plain: np.ndarray
    by_root: np.ndarray
    by_cube: np.ndarray

    def over(self, squares: np.ndarray) -> Bound:
        """The bound by changes whose squares are these times as large."""
        return Bound(
            self.size, self.plain / squares, self.by_root / squares, self.by_cube / squares
        )

    def under(self, factor: float) -> Bound:
        """The bound by the value m of a guard that is so many times what stands under the root."""
        return replace(self, by_root=self.by_root * factor**0.5, by_cube=self.by_cube * factor**1.5)


@dataclass(frozen=True)
class Guard:
    """What has to stay above zero: number `place` of what is watched (None: a divisor), times
    divisors to some `powers`, times `factor`. `bounds` are one for each part of the
    slides' ranges, known as `ground` says. `root` is the guard whose root a proved bound reads,
    `read` are those over whose shares a sampled one is.
    """

    name: str
    place: int | None
    powers: tuple[int, ...]
    factor: float
    ground: Ground
    bounds: tuple[Bound, ...]
    root: int | None = None
    read: tuple[int, ...] = ()

    @property
    def is_divisor(self) -> bool:
        """Whether the formulas divide by it."""
        return self.place is None

    @property
    def is_led(self) -> bool:
        """Whether its bound follows from what the line does, and from no squares of changes."""
        return any(not len(bound.plain) for bound in self.bounds)

    def of(self, watched: ca.SX, divisors: ca.SX) -> ca.SX:
        """Its expression, by what is watched and divisors."""
        whole = times(divisors, self.powers) * self.factor
        return whole if self.place is None else whole * watched[self.place]


DETERMINANT = Guard("the determinant of Newton's matrix", None, (), 1.0, "measured", ())
"""What Newton's method watches, by how its steps shrink."""


def times(divisors: ca.SX, powers: Sequence[int]) -> ca.SX:
    """The product of divisors to some powers."""
    return prod((divisors[j] ** e for j, e in enumerate(powers)), start=ca.SX(1))


@dataclass(frozen=True, eq=False)
class Line:
    """What lines run over: the `known` values, and for each part of the slides' ranges a span of
    each of them.
    """

    known: ca.SX
    spans: Sequence[Sequence[Span]]

    def values(self, expression: ca.SX) -> Callable[[np.ndarray], np.ndarray]:
        """The function (n, known) -> (n,) of an expression."""
        function = ca.Function("guard", [self.known], [expression], {"cse": True})

        def values(given: np.ndarray) -> np.ndarray:
            return np.asarray(function.map(len(given))(given.T)).ravel()

        return values

    def proved(
        self,
        guard: Guard,
        value: ca.SX,
        roots: Mapping[int, tuple[ca.SX, ca.SX]],
        before: Sequence[Guard],
        divisors: ca.SX,
        powers: Iterable[tuple[int, ...]] = ((),),
    ) -> Guard | None:
        """The guard of a value that is a polynomial P, or P + Q r with one of the `roots` (symbol
        and discriminant, by the number of its guard among those `before`), times the first of the
        `powers` of divisors that make it one; None where none does.
        """
        read = [j for j, (root, _) in roots.items() if ca.depends_on(value, root)]
        if len(read) > 1 or any(
            before[j].root is not None or before[j].read or any(before[j].powers) for j in read
        ):
            return None
        parts = [value] if not read else by_root(value, *roots[read[0]])
        if parts is None:
            return None
        for some in powers:
            factor = times(divisors, some)
            bounds = self.bounds([part * factor for part in parts], [roots[j][1] for j in read])
            if bounds is not None:
                per = before[read[0]].factor if read else 1.0
                bounds = tuple(bound.under(per) for bound in bounds)
                held = any(np.max(b.by_root + b.by_cube) > NOISE * np.max(b.plain) for b in bounds)
                root = read[0] if held else None
                return replace(guard, powers=some, bounds=bounds, root=root)
        return None

    def bounds(
        self, parts: Sequence[ca.SX], under: Sequence[ca.SX] = ()
    ) -> tuple[Bound, ...] | None:
        """Bounds of a polynomial P, or of P + Q r by both `parts` and what stands `under` the root
        r, over each part of the slides' ranges; None where they are no polynomials.
        """
        found = list[list[Bend]]()
        for polynomial in (*parts, *under):
            bends = self._bends(polynomial)
            if bends is None:
                return None
            found.append(bends)
        bounds = map(_with_root, *found) if under else map(_plain, found[0])
        squares = np.array([span.unit**2 for span in self.spans[-1]])
        return tuple(bound.over(squares) for bound in bounds)

    def _bends(self, expression: ca.SX) -> list[Bend] | None:
        """Bounds of an expression over each part; None where it is no polynomial."""
        values, found = self.values(expression), list[Bend]()
        for spans in reversed(self.spans):
            bend = bend_of(values, spans)
            if bend is None:
                return None
            found.append(bend)
        return found[::-1]


def by_root(expression: ca.SX, root: ca.SX, discriminant: ca.SX) -> list[ca.SX] | None:
    """P and Q of an expression P + Q root that is a polynomial in a discriminant's root; None where
    its degree is too high.
    """
    parts, derivative, zero = [ca.SX(0), ca.SX(0)], expression, ca.SX(0)
    for k in range(_ROOT_DEGREE + 2):
        at_zero = ca.substitute(derivative, root, zero) / factorial(k)
        parts[k % 2] = parts[k % 2] + at_zero * discriminant ** (k // 2)
        derivative = ca.jacobian(derivative, root)
        if not ca.depends_on(derivative, root) and derivative.is_zero():
            return parts
    return None


def _plain(bend: Bend) -> Bound:
    zero = np.zeros(len(bend.weights))
    return Bound(bend.size, 0.5 * _cleaned(bend.weights), zero, zero)


def _with_root(p: Bend, q: Bend, d: Bend) -> Bound:
    """Bounds of P + Q r, r^2 = D and D at least m: P'' + Q'' r + 2 Q' r' + Q r'' with r' = D' / (2
    r), r'' = D'' / (2 r) - D'^2 / (4 r^3).
    """
    both = 0.5 * (q.slopes * np.sum(d.slopes) + d.slopes * np.sum(q.slopes))
    return Bound(
        size=p.size + q.size * float(np.sqrt(d.size)),
        plain=0.5 * _cleaned(p.weights + np.sqrt(d.size) * q.weights),
        by_root=0.5 * _cleaned(both + 0.5 * q.size * d.weights),
        by_cube=0.5 * _cleaned(0.25 * q.size * d.slopes * np.sum(d.slopes)),
    )


def _cleaned(weights: np.ndarray) -> np.ndarray:
    return np.where(weights > NOISE * np.max(weights, initial=0.0), weights, 0.0)


# --- samples --------------------------------------------------------------------------------------


def share_of(value: ca.SX, *, divides: bool) -> ca.SX:
    """What a guard's value over its usual size leaves of the bend of those that read it."""
    if divides:
        return ca.fmin(ca.fabs(value), 1) ** 4
    kept = ca.fmin(ca.fmax(value, 0), 1)
    return kept * ca.sqrt(kept)


def sampled_bound(
    value: ca.SX,
    share: ca.SX,
    line: Line,
    part: int,
    scales: np.ndarray,
    units: np.ndarray,
) -> Bound:
    """The bound of a value over its usual size, times the `share` of the guards that it reads, over
    a part of the slides' ranges; `scales` are how far apart places are tried, and the value bends
    alike with all known values in their `units`.
    """
    spans, known = line.spans[part], line.known
    low, high = np.array([(s.middle - s.half, s.middle + s.half) for s in spans]).T
    points = np.random.default_rng(7).uniform(low, high, (_POINTS, len(spans)))
    hessian = ca.Function("h", [known], [ca.hessian(value, known)[0], share])
    zero, read = np.zeros(len(units)), np.array(ca.which_depends(value, known, 1, False))
    largest = _RAISED * _largest(hessian, points, scales, units)
    return Bound(1.0, np.where(read, 0.5 * largest / units**2, zero), zero, zero)


def even_units(
    values: Sequence[ca.SX], known: ca.SX, scales: np.ndarray, near: np.ndarray
) -> np.ndarray:
    """Units of the known values in which values bend alike with each: of one with which they bend
    much less than with others more than its scale. `near` (n, known) are known values of regular
    configurations.
    """
    share = np.full(len(scales), 1.0 / _MOST_UNIT)
    for value in values:
        hessian = ca.Function("h", [known], [ca.hessian(value, known)[0]])
        sizes = np.abs([np.asarray(hessian(at)) for at in near]) * np.outer(scales, scales)
        rows = np.median(sizes, axis=0).max(axis=1)
        if np.isfinite(rows).all() and rows.max() > 0.0:
            share = np.maximum(share, np.sqrt(rows / rows.max()))
    return scales * [rounded(1.0 / v) if v < _ALIKE else 1.0 for v in share]


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
