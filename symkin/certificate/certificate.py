"""Certificates: proofs that approximate roots of F(z, k) = 0 stand for exact ones.

The known values k and the constants of the system's graph are taken as the exact doubles that they
are (k may also be given as balls or discs: the proof then holds for every k in them). What is
proved of a root: it exists within a stated radius and is the only one there, it is regular, it is
real or it is not, it is a pose (e.e is not zero), and it is none of the other roots of its
instance: neither by whole turns of angles, nor by the scale of a ray, nor by the sign of a rod's
length.

All points are proved together in double precision with bounds of every rounding (`quick_test`);
what that leaves open is proved point by point in ball arithmetic (`open_points`).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from symkin.certificate.ball_system import BallSystem
from symkin.certificate.coordinates import aligned, in_phase, spread
from symkin.certificate.discs import Discs, Knowns
from symkin.certificate.krawczyk import Box, box_about
from symkin.certificate.open_points import prove_points, prove_pose
from symkin.certificate.quick_test import enclose_all
from symkin.certificate.separation import (
    Features,
    are_apart,
    are_not_real,
    distinct_boxes,
    features,
    is_pose,
    not_real,
)
from symkin.computed_once import unshared_property
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.balls import COMPLEX, REAL, UP, precision

_DOUBLE = 53
"""Bits of what is computed with balls around the proofs."""
_FARTHEST = 1e-7
"""A root farther than this from the given point (unit ray, angles, lengths over size) is not what
was given, and so many of its reach where it is complex, as rounding is of lengths far off; a point
with a smaller imaginary part is tried as a real one.
"""
_REALITY = np.array(["unknown", "real", "not real"])
_DIAGONAL = 1.4143
"""At least half the diagonal of a square over half its side."""


@dataclass(eq=False)
class CertificateBatch:
    """What is proved of n roots of m instances.

    `instance` (n,) says which of the known values each root belongs to, in ascending order.
    `certified` (n,): one regular root lies in the box |Re (z_j - centre_j)|, |Im (z_j -
    centre_j)| <= ball about `centre` (width, n); of a ray, the representative x with conj(g).(x -
    c) = 0, g the given unit ray and c the centre. Where the root `is_real` the box is one of real
    points; which roots are proved to be real, and which not to be: `proved_real`, `proved_unreal`
    (n,); `reasons`: why a root is not certified. Boxes that balls have proved are kept in `boxes`.
    """

    system: AlgebraicSystem
    knowns: Knowns
    instance: np.ndarray
    characteristic_length: float
    given: np.ndarray
    centre: np.ndarray
    ball: np.ndarray
    is_real: np.ndarray
    reasons: dict[int, str] = field(default_factory=dict)
    boxes: dict[int, Box] = field(default_factory=dict)
    certified: np.ndarray = field(default_factory=lambda: np.zeros(0))
    proved_real: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    proved_unreal: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))

    @property
    def real(self) -> np.ndarray:
        """Whether each root (n,) is "real", "not real" or "unknown"."""
        return _REALITY[self.proved_real + 2 * self.proved_unreal]

    @property
    def radius(self) -> np.ndarray:
        """How far each root (n,) is from its point in any coordinate, in the length unit: lengths,
        position, and angles and unit quaternion times the size; for a root that is not proved real,
        in z times the size.
        """
        real = self.proved_real
        given = self.given.real if real.all() else np.where(real, self.given.real, self.given)
        away = _away(self.centre, self.ball, given)
        away[real] = spread(
            self.system, self.given[:, real].real, away[real], self.knowns, self.instance[real]
        )
        return away * self.characteristic_length * UP

    def reason(self, i: int) -> str:
        """Why root i is not certified, else nothing."""
        return self.reasons.get(i, "")

    @property
    def _marks(self) -> tuple[np.ndarray, np.ndarray]:
        """Certified real roots, and a number for each in which equal roots are about equal."""
        proved = np.flatnonzero(self.proved_real)
        return proved, features(self.system, Discs.exact(self.centre[:, proved].T)).mixed.middle[
            :, 0
        ]

    def find(
        self,
        points: np.ndarray,
        instance: np.ndarray | None = None,
        expected: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """The certified real roots at real points (width, p) of instances (p,), ascending: their
        indices, -1 where there is none, and `radius` about these points, NaN where there is none.
        `expected` (p,) are the indices of the roots that the points come from, where they are
        known.
        """
        count = points.shape[1]
        instance = np.zeros(count, dtype=int) if instance is None else np.asarray(instance)
        index, radius = np.full(count, -1), np.full(count, np.nan)
        nearest = (
            self._nearest(points, instance)
            if expected is None
            else np.where(self.proved_real[expected], expected, -1)
        )
        some = (nearest >= 0).nonzero()[0]
        if not some.size:
            return index, radius
        roots = nearest[some]
        near = aligned(self.system, points[:, some], self.centre[:, roots])
        away = (np.max(np.abs(near - self.centre[:, roots]), axis=0) + self.ball[roots]) * UP
        found = away <= _FARTHEST
        index[some[found]] = roots[found]
        wide = spread(
            self.system, near[:, found].real, away[found], self.knowns, instance[some[found]]
        )
        radius[some[found]] = self.characteristic_length * wide * UP
        return index, radius

    def _nearest(self, points: np.ndarray, instance: np.ndarray) -> np.ndarray:
        """The root of its instance whose marks are nearest to those of each point; -1 where it has
        no root.
        """
        proved, marks = self._marks
        nearest = np.full(points.shape[1], -1)
        if not proved.size or not nearest.size:
            return nearest
        own = features(self.system, Discs.exact(points.T.astype(complex))).mixed.middle[:, 0]
        owners = self.instance[proved]
        for j in np.flatnonzero(np.bincount(owners)).tolist():
            here, roots = (slice(*np.searchsorted(of, [j, j + 1])) for of in (instance, owners))
            if own[here].size:
                far = np.abs(own[here, None] - marks[roots])
                nearest[here] = proved[roots][np.argmin(np.nan_to_num(far, nan=np.inf), axis=1)]
        return nearest

    def prove_open_points(self, near: np.ndarray) -> None:
        """By balls, what the quick test has not proved, one instance after another; of points that
        are `near` (n,) real ones real roots.
        """
        found = np.isfinite(self.ball)
        if found.all():
            return
        todo = np.flatnonzero(~found)
        for j in np.flatnonzero(np.bincount(self.instance[todo])).tolist():
            self._prove_some(j, todo[self.instance[todo] == j], near)

    @precision(_DOUBLE)
    def _prove_some(self, j: int, chosen: np.ndarray, near: np.ndarray) -> None:
        balls, real_rows = (
            BallSystem(self.system, self.knowns.numbers(j)),
            self.knowns.discs.is_real,
        )
        known = self.knowns.discs.middle[j].astype(complex)
        proved = prove_points(
            balls, self.given[:, chosen], near[chosen], known, real_rows=real_rows
        )
        for i, box, reason in zip(chosen.tolist(), proved.boxes, proved.reasons, strict=True):
            if box is None:
                self.reasons[i] = reason
            else:
                self.boxes[i] = box
                self.centre[:, i], self.ball[i], self.is_real[i] = (
                    box.point,
                    (box.rounding + box.radius) * UP,
                    box.ring.is_real,
                )

    def leave_out_far_ones(self) -> None:
        """Roots that are too far from their points to be what was given."""
        reach = np.maximum(1.0, np.abs(self.given).max(axis=0, initial=0.0))
        farthest = _FARTHEST * np.where(self.is_real, 1.0, reach)
        far = ~(_away(self.centre, self.ball, self.given) <= farthest)
        for i in far.nonzero()[0].tolist():
            self.ball[i] = np.inf
            self.reasons[i] = (
                self.reasons.get(i)
                or "the point is not a root; the one found is farther away than 1e-7"
            )

    def tell(self) -> None:
        """Which roots are certified in the end, and which of them are real."""
        self.certified = found = np.isfinite(self.ball)
        self.proved_real = self.is_real & found
        self.proved_unreal = self._not_real(found & ~self.proved_real)
        if not found.all():
            self.centre = np.where(found, self.centre, self.given)

    @unshared_property
    def _features(self) -> Features:
        """Of the numbers within discs that hold the boxes."""
        radius = np.where(self.is_real & self.certified, self.ball, self.ball * _DIAGONAL)
        return features(
            self.system, Discs(self.centre.T, np.repeat(radius[:, None], self.system.width, axis=1))
        )

    def _not_real(self, among: np.ndarray) -> np.ndarray:
        """Which roots are proved not to be real, of those `among` (n,)."""
        if not among.any():
            return among
        shown: np.ndarray = are_not_real(self.system, self.centre, self.ball) & among
        for i in (among & ~shown).nonzero()[0].tolist():
            shown[i] = not_real(self.system, self._box(i))
        return shown

    @unshared_property
    def pose(self) -> np.ndarray:
        """Which certified roots (n,) are proved to be poses."""
        found = self.certified
        if not self.system.projective:
            return found
        poses: np.ndarray = self._features.poses & found
        for i in np.flatnonzero(found & ~poses).tolist() if not poses.all() else ():
            poses[i] = is_pose(self.system, self._box(i)) or self._is_pose_by_bits(i)
        return poses

    def _is_pose_by_bits(self, i: int) -> bool:
        with precision(_DOUBLE):
            balls = BallSystem(self.system, self.knowns.numbers(int(self.instance[i])))
            is_real = bool(self.is_real[i])
            point = self.centre[:, i].real if is_real else self.centre[:, i]
            return prove_pose(balls, point, float(self.ball[i]), is_real=is_real)

    @unshared_property
    def distinct(self) -> np.ndarray:
        """So many certified roots of each instance (m,) are proved to differ."""
        found, mixed = self.certified, self._features.mixed
        instance = self.instance
        if not found.all():
            instance, mixed = instance[found], mixed.at(found)
        distinct = np.bincount(instance, minlength=self.knowns.count)
        apart = are_apart(mixed, instance, len(distinct))
        for j in np.flatnonzero(~apart).tolist() if not apart.all() else ():
            chosen = np.flatnonzero(found & (self.instance == j))
            distinct[j] = len(distinct_boxes(self.system, [self._box(i) for i in chosen.tolist()]))
        return distinct

    def _box(self, i: int) -> Box:
        if i not in self.boxes:
            ring = REAL if self.is_real[i] else COMPLEX
            self.boxes[i] = box_about(ring, self.centre[:, i], float(self.ball[i]))
        return self.boxes[i]


def certify_batch(
    system: AlgebraicSystem,
    z: np.ndarray,
    knowns: Knowns,
    instance: np.ndarray | None = None,
    size: float | None = None,
) -> CertificateBatch:
    """Certificates of approximate roots z (width, n) of the instances `instance` (n,), ascending,
    of known values. `size` is the length that z has as its unit, by default the system's.
    """
    instance = np.zeros(z.shape[1], dtype=int) if instance is None else np.asarray(instance)
    given = in_phase(system, np.asarray(z, dtype=complex))
    near = (np.abs(given.imag).max(axis=0, initial=0.0) <= _FARTHEST) & knowns.discs.is_real
    quick = enclose_all(system, given, near, knowns, instance)
    found = CertificateBatch(
        system,
        knowns,
        instance,
        size or system.characteristic_length,
        given,
        centre=quick.centre,
        ball=quick.half_width,
        is_real=quick.is_real,
    )
    found.prove_open_points(near)
    found.leave_out_far_ones()
    found.tell()
    return found


def _away(centre: np.ndarray, half: np.ndarray, points: np.ndarray) -> np.ndarray:
    """No point of a box of half width (n,) about its centre (width, n) is farther than this from
    its point (width, n) in any
    |Re| or |Im|; infinite without a box.
    """
    apart = centre - points
    far = np.maximum(np.abs(apart.real), np.abs(apart.imag)).max(axis=0, initial=0.0)
    return (far + half) * UP
