"""Prove that branches of G(y; c) = 0 run through tubes, many at once, by Krawczyk's operator in
disc arithmetic (Krawczyk 1969; see `certificate.quick_test`).

A tube holds the points p(t) + T w, |w_i| <= half_i, about a curve p(t), 0 <= t <= length. With e
the unit tangent of the branch in the middle and T orthonormal across it, both from the singular
vectors of dG/dy there, so that the box is thin in all directions but those of small singular
values (parallelepipeds against wrapping as in Lohner 1987), and for M about the inverse of dG/dy T,

    K = -M G(p(t)) + (1 - M dG/dy (p(t) + T w) T) w

is enclosed for all t at once, by Taylor's formula about the middle of the curve with remainders
over the tube. If K lies in the interior of the box, there is exactly one root across the curve at
each t: one branch runs through the tube, and it is regular. Its tangent is e + T w', M dG/dy T w'
= -M dG/dy e; where its part along the path parameter u is proved to be positive, there is one
solution for every u, and dG/dz is regular: no singularity. Where it changes its sign, and d2u/ds2 <
0 is proved, there is one fold. A tube without length is a box about a point.

Where rows are redundant M is a pseudo-inverse, and what is proved is proved of the combinations M G
of rows. Where these are known to vanish nowhere on the branch without all rows (see
`dependent_rows.rows_suffice`), this holds from tube to tube: a root of all rows that lies in the
next tube is the root of its combinations there, and rows that vanish on a piece of an analytic
branch vanish on all of it. Else at most one root is proved, and its existence rests on the
residual. The path's coefficients are discs of a radius of about 2e-15 (of the size, or rad), in
which the samples as given lie.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.certificate.disc_arithmetic import UNIT
from symkin.certificate.discs import Discs
from symkin.computed_once import cached_property
from symkin.following.cubic import Cubic
from symkin.following.path_system import PathSystem, inverses, scaled_left

COEFFICIENT_RADIUS = 2.0**-49
"""Radius of the coefficients' discs, relative to their values, or to the size and 1: what
interpolation in double precision leaves out at the samples.
"""
_MANY = 1.0 + 2.0**-42
"""Outweighs the roundings of sums and products of numbers that are not negative."""
_LARGEST_FILL = 0.99
"""The image must lie in the box shrunk by this factor."""
_TRIALS = 3
"""Boxes tried for one tube or point."""
_ROOM = 1.25
"""A first box has this much room for what moves its image."""
_WIDEST = 1.0
"""Boxes wider than this (over the size, or rad) prove nothing that is of use."""
_WIDEST_BOX = 1e-2
"""The same for boxes about points."""
_POWERS = 4
"""Multiplications that find about the largest eigenvalue of what shrinks."""
_FRAME_ROUNDING = 1e-13
"""How far frames are from orthonormal at most."""
_OVERHANG = 0.02
"""A tube begins before its curve and ends beyond it by this share of it, so that the boxes of both
ends lie in it.
"""


@dataclass(frozen=True, eq=False)
class Tubes:
    """Tubes (n,) about curves in coordinates times a `unit` (n, w + 1), with boxes `half` (n, w) in
    those of the `frame` (n, w + 1, w + 1), whose last column is e, of the rows that `combined` M
    (n, w, rows) makes; those that are `proved` (n,)
    hold one branch each, and `grows` (n,) says whether the path parameter is proved to grow along
    it. `tightness` (n,) is the share of the box that its image fills; `effort` (n,) grows about as
    the square of the curve's length.
    """

    curve: Cubic
    unit: np.ndarray
    frame: np.ndarray
    combined: np.ndarray
    half: np.ndarray
    proved: np.ndarray
    grows: np.ndarray
    tightness: np.ndarray
    effort: np.ndarray

    def among(self, chosen: slice | np.ndarray) -> Tubes:
        """Some of the tubes."""
        curve, *rest = vars(self).values()
        return Tubes(curve.among(chosen), *(a[chosen] for a in rest))

    def hold(self, share: float, y: np.ndarray, half: np.ndarray) -> np.ndarray:
        """Whether boxes (n, w + 1) about points y, near those of the curves at a share of them, lie
        in the proved tubes, each of their points across some point of the curve.
        """
        inside = (share + _OVERHANG) / (1.0 + 2.0 * _OVERHANG)
        y, half = y * self.unit, half * self.unit
        off = y - self.curve.at(inside)
        across, along = self.frame[..., :-1].transpose(0, 2, 1), self.frame[..., -1]
        centre, extent = self.curve.velocity
        wide = half + self.curve.rounding[:, None] + UNIT * np.abs(y)
        wide = (wide + _FRAME_ROUNDING * (np.abs(off) + half)) * _MANY
        with np.errstate(all="ignore"):
            slowest = _dot(along, centre) * (1.0 - 1e-12) - _dot(np.abs(along), extent) * _MANY
            late = (_dot(np.abs(along), wide) + np.abs(_dot(along, off))) / slowest * _MANY
            away = np.abs(_product(across, off)) + _product(np.abs(across), wide)
            away += late[:, None] * (
                np.abs(_product(across, centre)) + _product(np.abs(across), extent)
            )
            room = np.minimum(inside, 1.0 - inside) * self.curve.length
            fits = (away * _MANY <= self.half).all(axis=1) & (slowest > 0.0) & (late < room)
        return self.proved & fits


@dataclass(frozen=True, eq=False)
class Interval:
    """The rows with the coefficients (k, coefficients) of k intervals of the path bound: points are
    on the interval whose number `which` (n,) tells. `of_combinations`: rows are redundant but such
    as follow from others, so that boxes are of the combinations of rows that tubes are of.
    """

    system: PathSystem
    c: np.ndarray
    of_combinations: bool = False

    def evaluate(self, y: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """G (n, rows) and dG/dy (n, rows, w + 1) in doubles."""
        return self.system.evaluate(y, self.c[which])

    @cached_property
    def _known(self) -> Discs:
        scale = np.maximum(np.abs(self.c), self.system.coefficient_scales)
        return Discs(self.c, COEFFICIENT_RADIUS * scale)

    @cached_property
    def _units(self) -> np.ndarray:
        """Powers of two (k, w + 1) by which coordinates are multiplied, so that the path parameter
        changes about as much as the known coordinates do."""
        units = np.ones((len(self.c), self.system.width + 1))
        units[:, -1] = 2.0 ** np.round(np.log2(np.clip(self.system.changes(self.c), 1e-12, None)))
        return units

    @cached_property
    def _prepared(self) -> Discs:
        return self.system.discs.prepare(self._known)

    @cached_property
    def _prepared_bend(self) -> Discs:
        function, constants = self.system.bend
        return function.prepare(self._known.beside(np.array(constants)))

    def value(self, y: np.ndarray, radius: np.ndarray, which: np.ndarray) -> Matrix:
        """G (n, rows, 1) over boxes about points."""
        return self._matrix(0, Discs(y, radius), which)

    def slope(self, y: np.ndarray, radius: np.ndarray, which: np.ndarray) -> Matrix:
        """dG/dy (n, rows, w + 1) over boxes about points."""
        return self._matrix(1, Discs(y, radius), which)

    def bend(
        self,
        place: tuple[np.ndarray, np.ndarray],
        along: tuple[np.ndarray, np.ndarray],
        which: np.ndarray,
    ) -> Matrix:
        """The derivative of dG/dy along boxes of vectors, over boxes."""
        discs = Discs(*(np.concatenate(parts, axis=1) for parts in zip(place, along, strict=True)))
        function = self.system.bend[0]
        found = function.evaluate(0, discs, self._prepared_bend, which)
        shape = (self.system.count, self.system.width + 1)
        return _dense(found, function.tape.patterns[0], (shape[0] * shape[1], 1)).shaped(shape)

    def _matrix(self, part: int, discs: Discs, which: np.ndarray) -> Matrix:
        function = self.system.discs
        found = function.evaluate(part, discs, self._prepared, which)
        shape = (self.system.count, (1, self.system.width + 1)[part])
        return _dense(found, function.tape.patterns[part], shape)

    def tubes(self, curve: Cubic, which: np.ndarray, *held: np.ndarray) -> Tubes:
        """Tubes about n curves, begun and ended a little beyond them, with room for boxes `held`
        (n, w + 1) about points of these.
        """
        unit = self._units[which]
        scaled = Cubic(curve.control * unit[:, None], curve.length).longer(_OVERHANG)
        operator = _Operator(self, scaled, unit, which)
        n, width = len(which), self.system.width
        least = np.zeros((n, width))
        for box in held:
            across = np.abs(operator.across).transpose(0, 2, 1)
            least = np.maximum(least, 2.0 * _product(across, box * unit))
        first = operator.over(np.zeros((n, width)))
        half = np.maximum(_first_box(first), least)
        possible = np.isfinite(half).all(axis=1) & (half.max(axis=1, initial=0.0) < _WIDEST)
        half = np.where(possible[:, None], half, 0.0)
        for _ in range(_TRIALS):
            found = operator.over(half)
            fill = found.fill(half)
            proved = possible & (fill <= _LARGEST_FILL)
            grown = np.where(np.isfinite(found.image), 1.5 * np.maximum(found.image, half), 0.0)
            half = np.where((proved | ~possible)[:, None], half, grown)
            if (proved == possible).all():
                break
        effort = _largest_eigenvalue(first.shrinks)
        up = operator.frame[:, -1, -1] - found.sideways
        grows = proved & (up > _FRAME_ROUNDING)
        frame, combined = operator.frame, operator.inverse
        return Tubes(operator.curve, unit, frame, combined, half, proved, grows, fill, effort)

    def folds(self, tubes: Tubes, which: np.ndarray) -> np.ndarray:
        """Whether d2u/ds2 < 0 is proved for the branches in tubes (n,) over s = e.y, so that u has
        at most one extreme: w'' = -M d2G/dy2 y' y' + (1 - M dG/dy T) w''.
        """
        operator = _Operator(self, tubes.curve, tubes.unit, which)
        image = operator.over(tubes.half)
        tangents = (operator.along, operator.spread(image.tangent))
        with np.errstate(all="ignore"):
            bend = operator.bend(tubes.half, tangents)
            middle = _product(operator.inverse, _product(bend.middle, operator.along))
            size = bend.moved(operator.inverse, *tangents)
            loose = _product(bend.loose, np.abs(operator.along) + tangents[1])
            loose += _product(np.abs(bend.middle), tangents[1])
            error = _product(np.abs(operator.inverse), loose)
            error += _fixed_points(image.shrinks, _product(image.shrinks, size))
            up = operator.frame[:, -1, :-1]
            curved = _dot(up, middle) > _dot(np.abs(up), error) * _MANY
        return tubes.proved & curved

    def boxes(
        self,
        y: np.ndarray,
        jacobian: np.ndarray,
        across: np.ndarray,
        which: np.ndarray,
        combined: np.ndarray | None = None,
    ) -> np.ndarray:
        """Half widths (n, w + 1) of boxes about points y that hold exactly one root on y + across w
        (`across` (w + 1, w)), infinite where none is proved; of `combined` rows (n, w, rows), those
        of a pseudo-inverse if none are told.
        """
        if combined is None:
            inverse = inverses(jacobian @ across)
        else:
            inverse = inverses(combined @ jacobian @ across) @ combined
        value = self.value(y, np.zeros(y.shape), which)
        step = value.moved(inverse, np.ones(1))
        half = 2.5 * step + 0.01 * step.max(axis=1, keepdims=True, initial=0.0) + 1e-17
        wide = np.abs(across)
        for _ in range(_TRIALS):
            spread = half @ wide.T * _MANY
            shrinks = self.slope(y, spread, which).shrinks(inverse, across)
            image = (step + _product(shrinks, half)) * _MANY
            fits = (image <= _LARGEST_FILL * half) & (half < _WIDEST_BOX)
            proved = fits.all(axis=1)
            if proved.all():
                break
            half = np.where(proved[:, None], half, 8.0 * half)
        return np.where(proved[:, None], half @ wide.T * _MANY, np.inf)


@dataclass(frozen=True, eq=False)
class Matrix:
    """All matrices (n, a, b) whose entries are within `radius` of `middle`."""

    middle: np.ndarray
    radius: np.ndarray

    @cached_property
    def loose(self) -> np.ndarray:
        """The radius, and what a product with other matrices is rounded by."""
        gamma = 2.0 * (sum(self.middle.shape[1:]) + 8) * UNIT
        return (self.radius + gamma * np.abs(self.middle)) * _MANY

    def over(self, unit: np.ndarray) -> Matrix:
        """The columns over powers of two (n, b)."""
        return Matrix(self.middle / unit[:, None], self.radius / unit[:, None])

    def shaped(self, shape: tuple[int, int]) -> Matrix:
        """The same entries, row by row, in another shape."""
        return Matrix(*(a.reshape(len(a), *shape) for a in (self.middle, self.radius)))

    def moved(
        self, inverse: np.ndarray, v: np.ndarray, spread: np.ndarray | float = 0.0
    ) -> np.ndarray:
        """Bounds (n, w) of |M A v| for all A and all v within `spread`."""
        away = _product(self.loose, np.abs(v) + spread) + _product(np.abs(self.middle), spread)
        middle = np.abs(_product(inverse, _product(self.middle, v)))
        return (middle + _product(np.abs(inverse), away)) * _MANY

    def between(self, inverse: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Bounds (n, w, w) of |M A T| for all A."""
        away = np.abs(inverse) @ self.loose @ np.abs(across)
        return (np.abs(inverse @ self.middle @ across) + away) * _MANY

    def shrinks(
        self, inverse: np.ndarray, across: np.ndarray, unit: np.ndarray | None = None
    ) -> np.ndarray:
        """Bounds of |1 - M A T| for all A, or of |unit - M A T|."""
        whole = np.eye(across.shape[-1]) if unit is None else unit
        rest = np.abs(inverse @ self.middle @ across - whole)
        return (rest + np.abs(inverse) @ self.loose @ np.abs(across)) * _MANY


class _Operator:
    """Krawczyk's operator about curves: what does not depend on the box."""

    def __init__(
        self, interval: Interval, curve: Cubic, unit: np.ndarray, which: np.ndarray
    ) -> None:
        self.interval, self.curve, self.unit, self.which = interval, curve, unit, which
        self.middle = curve.at(0.5)
        self.rounding = np.repeat(curve.rounding[:, None], self.middle.shape[1], axis=1)
        self.slope = self._slope(self.rounding)
        self.frame, self.inverse = _frames(
            self.slope.middle, curve.control[:, -1] - curve.control[:, 0]
        )
        self.late = 0.5 * curve.length[:, None] * _MANY
        self.velocity, self.acceleration = curve.velocity, curve.acceleration
        slipping = 12.0 * (curve.rounding / curve.length)[:, None]
        value = interval.value(self.middle / unit, self.rounding / unit, which)
        self.value = value.moved(self.inverse, np.ones(1)) + self.late * self.slope.moved(
            self.inverse, curve.middle_velocity, slipping
        )

    @property
    def across(self) -> np.ndarray:
        return self.frame[..., :-1]

    @property
    def along(self) -> np.ndarray:
        return self.frame[..., -1]

    def _slope(self, radius: np.ndarray) -> Matrix:
        """dG/dy over boxes about the middle."""
        found = self.interval.slope(self.middle / self.unit, radius / self.unit, self.which)
        return found.over(self.unit)

    def bend(self, half: np.ndarray, along: tuple[np.ndarray, np.ndarray]) -> Matrix:
        """The derivative of dG/dy along boxes of vectors, over the whole tubes."""
        centre, extent = self.curve.hull
        place = (centre / self.unit, (extent + self.spread(half)) * _MANY / self.unit)
        vectors = (along[0] / self.unit, along[1] / self.unit)
        return self.interval.bend(place, vectors, self.which).over(self.unit)

    def spread(self, half: np.ndarray) -> np.ndarray:
        """Half widths (n, w + 1) along the axes of a box's."""
        return _product(np.abs(self.across), half) * _MANY

    def over(self, half: np.ndarray) -> _Image:
        """The operator over boxes of these half widths (n, w)."""
        bend = self.bend(half, self.velocity)
        box = self._slope(self.rounding + self.spread(half))
        late = self.late
        # the path parameter as one more coordinate, w_u = T_u w, so that what cancels in it does
        up, w = self.across[:, -1:], self.across.shape[2]
        rows = np.concatenate([self.inverse, up @ self.inverse], axis=1)
        unit = np.concatenate([np.broadcast_to(np.eye(w), (len(up), w, w)), up], axis=1)
        shrinks = box.shrinks(rows, self.across, unit)
        shrinks += late[..., None] * bend.between(rows, self.across)
        turning = box.moved(rows, self.along) + late * bend.moved(rows, self.along)
        (v, v_spread), (a, a_spread) = self.velocity, self.acceleration
        curved = np.abs(
            _product(self.inverse, _product(bend.middle, v) + _product(self.slope.middle, a))
        )
        loose = (
            _product(bend.loose, np.abs(v) + v_spread)
            + _product(np.abs(bend.middle), v_spread)
            + _product(self.slope.loose, np.abs(a) + a_spread)
            + _product(np.abs(self.slope.middle), a_spread)
            + late * _product(np.abs(bend.middle) + bend.radius, np.abs(a) + a_spread)
        )
        curved += _product(np.abs(self.inverse), loose)
        drift = self.value + 0.5 * late**2 * curved
        image = (drift + _product(shrinks[:, :-1], half)) * _MANY
        return _Image(image, shrinks * _MANY, turning * _MANY)


@dataclass(frozen=True, eq=False)
class _Image:
    """Bounds over boxes: of |K| (n, w), of |1 - M dG/dy T| (n, w + 1, w) and of |M dG/dy e|
    (n, w + 1), whose last rows are those of the path parameter.
    """

    image: np.ndarray
    all_shrinks: np.ndarray
    turning: np.ndarray

    @property
    def shrinks(self) -> np.ndarray:
        return self.all_shrinks[:, :-1]

    @cached_property
    def tangent(self) -> np.ndarray:
        """Bounds (n, w) of the branch's w'."""
        return _fixed_points(self.shrinks, self.turning[:, :-1])

    @property
    def sideways(self) -> np.ndarray:
        """A bound (n,) of what w' adds to du/ds."""
        with np.errstate(all="ignore"):
            along = self.turning[:, -1] + _dot(self.all_shrinks[:, -1], self.tangent)
        return along * _MANY

    def fill(self, half: np.ndarray) -> np.ndarray:
        """The largest share (n,) of the boxes that the images fill."""
        with np.errstate(all="ignore"):
            share = np.max(self.image / half, axis=1, initial=0.0)
        return np.where(np.isfinite(share), share, np.inf)


def _frames(slope: np.ndarray, ahead: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal columns (n, w + 1, w + 1), the last one the branch's tangent towards `ahead`, and
    about the inverse (n, w, rows) of dG/dy in the others."""
    fine = np.isfinite(slope).all(axis=(1, 2))
    left, singular, right = np.linalg.svd(np.where(fine[:, None, None], slope, 0.0))
    width = slope.shape[2] - 1
    frame = right.transpose(0, 2, 1).copy()
    frame[..., -1] *= np.where(_dot(frame[..., -1], ahead) < 0.0, -1.0, 1.0)[:, None]
    return frame, scaled_left(singular[:, :width], left[..., :width])


def _first_box(first: _Image) -> np.ndarray:
    """A box (n, w) that holds its image, as far as the operator is that of no box; no numbers where
    there is none."""
    w = first.shrinks.shape[-1]
    drift = _ROOM * first.image + 1e-16 + 0.01 * first.image.max(axis=1, keepdims=True, initial=0.0)
    half = _solved(np.eye(w) - _ROOM * first.shrinks, drift)
    return np.where((half > 0.0).all(axis=1, keepdims=True), half, np.nan)


def _fixed_points(shrinks: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Bounds (n, w) of |x| where |x| <= first + |E| |x|, |E| at most `shrinks`; infinite where they
    give none."""
    # room for rounding is a share of the largest: what a symmetry keeps at zero has none of its own
    room = 1e-6 * first.max(axis=1, keepdims=True, initial=0.0) + 1e-300
    bound = _solved(np.eye(first.shape[1]) - shrinks, first + room)
    holds = (first + _product(shrinks, bound)) * _MANY <= bound
    return np.where((holds & (bound > 0.0)).all(axis=1, keepdims=True), bound, np.inf)


def _solved(matrices: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x (n, w) with matrices x = right; no numbers where these are singular or none themselves."""
    fine = np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    fine[fine] = np.linalg.det(matrices[fine]) != 0.0
    found = np.full(right.shape, np.nan)
    found[fine] = np.linalg.solve(matrices[fine], right[fine][..., None])[..., 0]
    return found


def _largest_eigenvalue(matrices: np.ndarray) -> np.ndarray:
    """About those (n,) of matrices without negative entries."""
    v = np.ones(matrices.shape[:2])
    size = np.zeros(len(v))
    with np.errstate(all="ignore"):
        for _ in range(_POWERS):
            v = _product(matrices, v)
            size = v.max(axis=1, initial=0.0)
            v = v / size[:, None] + 1e-3
    return np.where(np.isfinite(size), size, np.inf)


def _dense(discs: Discs, pattern: tuple[np.ndarray, np.ndarray], shape: tuple[int, int]) -> Matrix:
    """Nonzeros (n, entries) at their places in matrices."""
    middle, radius = np.zeros((2, len(discs.middle), *shape))
    middle[:, *pattern], radius[:, *pattern] = discs.middle, discs.radius
    return Matrix(middle, radius)


def _product(matrices: np.ndarray, vectors: np.ndarray | float) -> np.ndarray:
    """Matrices (n, a, b) times vectors (n, b), or one (b,), or one number in all entries."""
    if np.ndim(vectors) == 0 or np.shape(vectors)[-1] != matrices.shape[-1]:
        vectors = np.broadcast_to(vectors, (len(matrices), matrices.shape[-1]))
    return (matrices @ np.asarray(vectors)[..., None])[..., 0]


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar products (n,)."""
    return np.sum(a * b, axis=1)
