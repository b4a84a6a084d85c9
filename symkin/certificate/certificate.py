"""Certificates: proofs, by ball arithmetic, that approximate roots of F(z, k) = 0 stand for exact ones.

The known values k and the constants of the system's graph are taken as the exact doubles that they are (k may also be given
as balls: the proof then holds for every k in them). What is proved of a root: it exists within a stated radius and is the
only one there, it is regular, it is real or it is not, it is a pose (e.e is not zero), and it is none of the other roots:
neither by whole turns of angles, nor by the scale of a ray, nor by the sign of a rod's length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import acb, arb

from symkin.certificate.ball_system import BallSystem
from symkin.certificate.balls import COMPLEX, REAL, RINGS, UP, Number, precision
from symkin.certificate.coordinates import Coordinates, aligned, in_phase
from symkin.certificate.krawczyk import Box, chart_of, enclose
from symkin.certificate.separation import distinct_boxes, is_pose, not_real
from symkin.homotopy.algebraic import AlgebraicSystem

_BITS = (64, 128, 256)
"""Precisions tried in turn; up to 64 bits a number is one machine word."""
_DOUBLE = 53
"""Bits of what is computed with balls around the proofs."""
_NEWTON_STEPS, _SMALL_STEP = 2, 1e-10
"""Newton steps in double precision at most, and the largest one that is not followed by another."""
_CONJUGATE = 1e-9
"""Two points so close to conjugate share one proof."""
_FARTHEST = 1e-7
"""A root farther than this from the given point (unit ray, angles, lengths over size) is not what was given; a point with a
smaller imaginary part is tried as a real one."""


@dataclass(frozen=True, eq=False)
class Certificates:
    """What is proved of n roots.

    `certified` (n,): one regular root lies in the box |Re (z_j - centre_j)|, |Im (z_j - centre_j)| <= ball about `centre`
    (width, n); of a ray, the representative x with conj(g).(x - c) = 0, g the given unit ray and c the centre. Where the
    root is real the box is one of real points. `radius` (n,), length unit: how far the root is from the given point in any
    coordinate: lengths, position, and angles and unit quaternion times the size; for a root that is not proved real, in z
    times the size. `real` (n,): "real", "not real" or "unknown". `pose` (n,): e.e is not zero. `distinct`: so many of the
    certified roots are proved to differ from each other. `reasons` (n,): why a root is not certified, else empty.
    """

    balls: BallSystem
    size: float
    certified: np.ndarray
    centre: np.ndarray
    ball: np.ndarray
    radius: np.ndarray
    real: np.ndarray
    pose: np.ndarray
    distinct: int
    reasons: tuple[str, ...]

    @property
    def system(self) -> AlgebraicSystem:
        return self.balls.system

    @property
    def disjoint(self) -> bool:
        """Whether all certified roots are proved to differ from each other."""
        return self.distinct == int(np.sum(self.certified))

    def find(self, point: np.ndarray) -> tuple[int, float] | None:
        """The certified real root at a real point (width,), such as one with other whole turns, scale or sign of a length,
        or one that was polished on other rows: its index, and `radius` about that point. None where there is none."""
        proved = np.flatnonzero(self.certified & (self.real == "real"))
        if not proved.size:
            return None
        points = aligned(self.system, np.asarray(point, dtype=complex), self.centre[:, proved])
        away = (np.max(np.abs(points - self.centre[:, proved]), axis=0) + self.ball[proved]) * UP
        nearest = int(np.argmin(away))
        if not away[nearest] <= _FARTHEST:
            return None
        spread = Coordinates(self.balls).spread(points[:, nearest].real, float(away[nearest]))
        return int(proved[nearest]), float(self.size * spread * UP)


@precision(_DOUBLE)
def certify(system: AlgebraicSystem, z: np.ndarray, k: Sequence[Number] | np.ndarray, size: float | None = None) -> Certificates:
    """Certificates of approximate roots z (width, n) at known values k: doubles, taken as exact, or balls. `size` is the
    length that z has as its unit, by default the system's."""
    known = tuple(_plain(v) for v in k)
    balls = BallSystem(system, known)
    has_real_rows = all(not isinstance(v, (complex, acb)) for v in known)
    given = in_phase(system, np.asarray(z, dtype=complex))
    near = (np.max(np.abs(given.imag), axis=0, initial=0.0) <= _FARTHEST) & has_real_rows
    centre, inverses = _polished(system, np.where(near, given.real, given), np.array([_middle(v) for v in known]))
    mates = _conjugates(given) if has_real_rows else {}
    boxes: list[Box | None] = []
    reasons: list[str] = []
    for i in range(given.shape[1]):
        mate = boxes[mates[i]] if i in mates else None
        if mate is not None and not near[i]:
            boxes.append(mate.conjugate())
            reasons.append("")
            continue
        box, reason = _prove(balls, given[:, i], bool(near[i]), centre[:, i], inverses[i])
        boxes.append(box)
        reasons.append(reason)
    for i in np.flatnonzero(_distances(boxes, given) > _FARTHEST).tolist():
        boxes[i], reasons[i] = None, reasons[i] or "the point is not a root; the one found is farther away than 1e-7"
    distinct = len(distinct_boxes(system, [box for box in boxes if box is not None]))
    return _collect(balls, given, boxes, tuple(reasons), distinct, size or system.size)


def _prove(
    balls: BallSystem, given: np.ndarray, near: bool, centre: np.ndarray, inverse: np.ndarray | None
) -> tuple[Box | None, str]:
    """A box, or None and the reason: first about the polished centre in double precision, then about the given point by
    more bits."""
    if not np.isfinite(given).all():
        return None, "the point is not finite"
    chart = chart_of(balls, given.real if near else given)
    if chart is None:
        return None, (
            f"{balls.count} rows for {balls.freedom} unknowns: no square part of them is known to imply the others "
            "(`symkin show` names the motion that removes some, where there is one)"
        )
    box = None
    if inverse is not None and chart.is_whole:
        box = enclose(balls, chart, REAL if near else COMPLEX, centre, _BITS[0], inverse)
    trials = ((bits, ring) for bits in _BITS for ring in (RINGS if near else RINGS[1:]))
    while box is None and (trial := next(trials, None)) is not None:
        bits, ring = trial
        box = enclose(balls, chart, ring, given.real if ring.is_real else given, bits)
    reason = f"no proof by {_BITS[-1]} bits: the point is no root, or one that is singular or nearly so"
    return box, "" if box is not None else reason


def _distances(boxes: Sequence[Box | None], points: np.ndarray) -> np.ndarray:
    """No point of a box is farther than this from its point (width, n) in any |Re| or |Im|; infinite without a box."""
    far = np.full(points.shape[1], np.inf)
    found = [(i, box) for i, box in enumerate(boxes) if box is not None]
    if found:
        places = [i for i, _ in found]
        apart = np.array([box.point for _, box in found]).T - points[:, places]
        extent = np.array([box.rounding + box.radius for _, box in found])
        far[places] = (np.max(np.maximum(np.abs(apart.real), np.abs(apart.imag)), axis=0) + extent) * UP
    return far


def _collect(
    balls: BallSystem, given: np.ndarray, boxes: list[Box | None], reasons: tuple[str, ...], distinct: int, size: float
) -> Certificates:
    system, n = balls.system, given.shape[1]
    centre, real, pose = given.copy(), np.full(n, "unknown", dtype="<U8"), np.zeros(n, dtype=bool)
    for i, box in enumerate(boxes):
        if box is not None:
            centre[:, i] = box.point
            real[i] = "real" if box.ring.is_real else "not real" if not_real(system, box) else "unknown"
            pose[i] = is_pose(system, box)
    away = _distances(boxes, np.where(real == "real", given.real, given))
    coordinates = Coordinates(balls)
    radius = away.copy()
    for i in np.flatnonzero(real == "real").tolist():
        radius[i] = coordinates.spread(given[:, i].real, float(away[i]))
    certified = np.array([box is not None for box in boxes], dtype=bool)
    ball = _distances(boxes, centre)
    return Certificates(balls, size, certified, centre, ball, radius * size * UP, real, pose, distinct, reasons)


# --- points in double precision ----------------------------------------------------------------------------------


def _plain(value: Number) -> Number:
    """A known value as a float, a complex number that is not real, or a ball."""
    if isinstance(value, (arb, acb)):
        return value.real if isinstance(value, acb) and value.imag == 0 else value
    number = complex(value)
    return number.real if number.imag == 0.0 else number


def _middle(value: Number) -> complex:
    return complex(float(value.real), float(value.imag)) if isinstance(value, (arb, acb)) else complex(value)


def _conjugates(given: np.ndarray) -> dict[int, int]:
    """Points whose conjugates stand among the earlier points, up to rounding."""
    weights = np.random.default_rng(0).normal(size=len(given))
    mixed = weights @ given
    with np.errstate(invalid="ignore"):
        candidates = np.argwhere(np.tril(np.abs(mixed[:, None] - np.conj(mixed)) < len(given) * 10 * _CONJUGATE, -1)).tolist()
    return {i: j for i, j in candidates if np.max(np.abs(given[:, i] - np.conj(given[:, j]))) < _CONJUGATE}


def _polished(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, list[np.ndarray | None]]:
    """Newton steps, and the last inverse of dF/dz with the patch; None where there is none or rows are too many."""
    n, width = z.shape[1], system.width
    if system.count + bool(system.projective) != width or not np.isfinite(z).all():
        return z, [None] * n
    patch = np.zeros((n, int(bool(system.projective)), width), dtype=complex)
    patch[:, :, list(system.projective)] = np.conj(z[list(system.projective)].T)[:, None]
    known = np.repeat(k[:, None], n, axis=1)
    centre, inverses = z, np.zeros((n, width, width), dtype=complex)
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_STEPS):
            f, j = system.linearise(centre, known)
            try:
                inverses = np.linalg.inv(np.concatenate([j, patch], axis=1))
            except np.linalg.LinAlgError:
                return z, [None] * n
            step = np.einsum("nij,nj->in", inverses[:, :, : system.count], f)
            centre = centre - step
            if np.max(np.abs(step), initial=0.0) < _SMALL_STEP:
                break
    fine = np.isfinite(centre).all(axis=0) & np.isfinite(inverses).all(axis=(1, 2))
    return centre, [inverses[i] if fine[i] else None for i in range(n)]
