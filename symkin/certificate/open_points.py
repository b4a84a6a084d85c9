"""Proofs by balls, point by point, of what the quick test leaves open: more bits, parts of the
rows, nearly double roots.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.certificate.ball_system import BallSystem
from symkin.certificate.krawczyk import Box, chart_of, enclose
from symkin.certificate.separation import is_pose
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.balls import COMPLEX, REAL, RINGS

_BITS = (64, 128, 256)
"""Precisions tried in turn; up to 64 bits a number is one machine word."""
_DOUBLE = 53
"""Bits of a centre in double precision."""
_NEWTON_STEPS, _SMALL_STEP = 2, 1e-10
"""Newton steps in double precision at most, and the largest one that is not followed by another."""
_CONJUGATE = 1e-9
"""Two points so close to conjugate share one proof."""


@dataclass(frozen=True, eq=False)
class Proved:
    """Of each point: its box, or None and the reason."""

    boxes: list[Box | None]
    reasons: list[str]


def prove_points(
    balls: BallSystem, given: np.ndarray, near: np.ndarray, known: np.ndarray, *, real_rows: bool
) -> Proved:
    """Boxes of points (width, n) of one instance: real ones are tried where `near` (n,). `known`
    are about its values; with real rows, one proof serves a pair of conjugate points.
    """
    centre, inverses = _polished(balls.system, np.where(near, given.real, given), known)
    mates = _conjugates(given) if real_rows else {}
    proved = Proved([], [])
    for i in range(given.shape[1]):
        mate = proved.boxes[mates[i]] if i in mates else None
        if mate is not None and not near[i]:
            proved.boxes.append(mate.conjugate())
            proved.reasons.append("")
            continue
        box, reason = _prove(balls, given[:, i], bool(near[i]), centre[:, i], inverses[i])
        proved.boxes.append(box)
        proved.reasons.append(reason)
    return proved


def _prove(
    balls: BallSystem, given: np.ndarray, near: bool, centre: np.ndarray, inverse: np.ndarray | None
) -> tuple[Box | None, str]:
    """A box, or None and the reason: first about the polished centre in double precision, then
    about the given point by more bits.
    """
    if not np.isfinite(given).all():
        return None, "the point is not finite"
    chart = chart_of(balls, given.real if near else given)
    if chart is None and balls.count < balls.freedom:
        return (
            None,
            f"{balls.count} rows hold the pose, and others, which these do not tell, the passive "
            f"joints beside it",
        )
    if chart is None:
        return None, (
            f"{balls.count} rows for {balls.freedom} unknowns: no square part of them is known to "
            f"imply the others "
            "(`symkin show` names the motion that removes some, where there is one)"
        )
    box = None
    if inverse is not None and chart.is_whole and _may_hold(inverse, _DOUBLE):
        box = enclose(balls, chart, REAL if near else COMPLEX, centre, _BITS[0], inverse)
    trials = (
        (bits, ring)
        for bits in _BITS
        if inverse is None or _may_hold(inverse, bits)
        for ring in (RINGS if near else RINGS[1:])
    )
    while box is None and (trial := next(trials, None)) is not None:
        bits, ring = trial
        box = enclose(balls, chart, ring, given.real if ring.is_real else given, bits)
    reason = (
        f"no proof by {_BITS[-1]} bits: the point is no root, or one that is singular or nearly so"
    )
    return box, "" if box is not None else reason


def _may_hold(inverse: np.ndarray, bits: int) -> bool:
    """Whether a box may hold its image at a precision: its radius is |Y| times what that leaves of
    rows of order one, and |Y| times as much is what the derivatives change by in it; by measurement
    |Y|^2.5 2^-bits is about one where boxes begin to fail.
    """
    return bool(np.max(np.abs(inverse)) < 2.0 ** (0.4 * bits))


def prove_pose(balls: BallSystem, point: np.ndarray, half: float, *, is_real: bool) -> bool:
    """Whether more bits show that the one root within `half` of a point is a pose: its rotation may
    have large entries, e.e close to zero, and the box of doubles hold zero.
    """
    chart, ring = chart_of(balls, point.real if is_real else point), REAL if is_real else COMPLEX
    if chart is None:
        return False
    for bits in _BITS[1:]:
        box = enclose(balls, chart, ring, point, bits)
        if box is None:
            continue
        # charts about a point and about its box's centre differ by rounding: half of the way is
        # left to it, and what lies nearer is the same root
        away = float(np.max(np.abs(box.point - point))) + box.rounding + box.radius
        if away <= 0.5 * half and is_pose(balls.system, box):
            return True
    return False


def _conjugates(given: np.ndarray) -> dict[int, int]:
    """Points whose conjugates stand among the earlier points, up to rounding."""
    weights = np.random.default_rng(0).normal(size=len(given))
    mixed = weights @ given
    with np.errstate(invalid="ignore"):
        candidates = np.argwhere(
            np.tril(np.abs(mixed[:, None] - np.conj(mixed)) < len(given) * 10 * _CONJUGATE, -1)
        ).tolist()
    return {
        i: j
        for i, j in candidates
        if np.max(np.abs(given[:, i] - np.conj(given[:, j]))) < _CONJUGATE
    }


def _polished(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray
) -> tuple[np.ndarray, Sequence[np.ndarray | None]]:
    """Newton steps, and the last inverse of dF/dz with the patch; None where there is none or rows
    are too many.
    """
    n, width = z.shape[1], system.width
    if system.count + bool(system.projective) != width or not np.isfinite(z).all():
        return z, [None] * n
    known = np.repeat(k[:, None], n, axis=1)
    centre, inverses = z, np.zeros((n, width, width), dtype=complex)
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_STEPS):
            f, j = system.linearise(centre, known)
            try:
                inverses = np.linalg.inv(system.patched(z, j, f)[0])
            except np.linalg.LinAlgError:
                return z, [None] * n
            step = np.einsum("nij,nj->in", inverses[:, :, : system.count], f)
            centre = centre - step
            if np.max(np.abs(step), initial=0.0) < _SMALL_STEP:
                break
    fine = np.isfinite(centre).all(axis=0) & np.isfinite(inverses).all(axis=(1, 2))
    return centre, [inverses[i] if fine[i] else None for i in range(n)]
