"""One curve of a singularity locus in a plane of two coordinates; curves with the same picture are
merged into one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symkin.singularities.curve import Curve
from symkin.singularities.locus_system import LocusSystem
from symkin.singularities.self_motion import has_self_motion

SAME_PICTURE = 5e-4
"""Curves whose points are within this of another curve (of the window's sides) have one picture."""
_LEAST_SHARE, _FARTHEST = 0.9, 0.01
"""So many of the points at least, and the others within this: a polyline cuts off sharp tips, and
its ends lie up to a step outside the window. A step is 1/150 of the sides.
"""
_SAME_PLACE = 1e-6
"""A distance below this, of the window's sides, counts as zero."""


@dataclass(frozen=True, eq=False)
class Locus:
    """One curve, or one point over a single coordinate: `points` (n, 2), (1, 1), in the plane and
    `configurations` (n, width of the unknowns `names`, those of the machine that is meant), every
    one a zero.

    Where passive joints alone lose the rank, the kind is "passive". `hits` counts the starts.
    Curves of other working modes and mirror images with the same picture are not listed again.

    `in_mode` (n,) says which points belong to the working mode of the plane's configuration (all of
    them, where that cannot be told); `self_motion`: finite steps show that the mechanism moves with
    both coordinates held; a curve of one point without it is a place where curves nearly touch or
    cross. `cusps` (c, 2) are points at which the curve in the plane turns back. Values are in the
    mechanism's units; configurations in radians.
    """

    kind: str
    limb: str | None
    points: np.ndarray
    closed: bool
    in_mode: np.ndarray
    cusps: np.ndarray
    names: tuple[str, ...]
    configurations: np.ndarray
    largest_row: float
    hits: int
    self_motion: bool = False

    @property
    def is_point(self) -> bool:
        """The curve stands in one point of the plane."""
        return is_one_place(self.points)

    def to_dict(self) -> dict[str, Any]:
        """The curve in the JSON of `Loci`, but for its loose ends, which depend on the window."""
        return {
            "kind": self.kind,
            "limb": self.limb,
            "closed": self.closed,
            "points": self.points.tolist(),
            "cusps": self.cusps.tolist(),
            "in_mode": self.in_mode.tolist(),
            "largest_row": self.largest_row,
            "hits": self.hits,
            "self_motion": self.self_motion,
        }

    def loose_ends(self, ranges: Sequence[Sequence[float]]) -> np.ndarray:
        """Ends (n, 2) of an open curve inside the window, where tracing could not go on; cusps are
        not counted.
        """
        if self.closed or self.is_point:
            return np.zeros((0, 2))
        low, high = np.array(ranges, dtype=float).T
        ends = self.points[[0, -1]]
        within = np.all((ends > low) & (ends < high), axis=1)
        at_cusp = [
            bool(len(self.cusps))
            and float(np.abs((self.cusps - end) / (high - low)).max(axis=1).min()) < _SAME_PLACE
            for end in ends
        ]
        return ends[within & ~np.array(at_cusp)]


def make_locus(
    system: LocusSystem, curve: Curve, cusps: np.ndarray, in_mode: np.ndarray, hits: int
) -> Locus:
    """A traced curve in the mechanism's units; `cusps` are numbers of its points."""
    mechanism = system.plane.mechanism
    factors = np.array([mechanism.value_out(c, 1.0) for c in system.plane.coordinates])
    w = curve.points[:, system.uv.stop :] / system.curve.characteristic_length
    kind = (
        "passive" if system.loss.is_passive(curve.points[:, : system.uv.stop], w) else system.kind
    )
    values, _ = system.curve.linearise(curve.points, np.zeros(0))
    names = (*(c.name for c in system.free), *system.plane.names)
    points = curve.points[:, system.uv] * factors
    return Locus(
        kind=kind,
        limb=system.plane.limb_name(system.limb),
        points=points,
        closed=curve.closed,
        in_mode=in_mode,
        cusps=points[cusps if kind == "type 2" else cusps[:0]],
        names=names,
        configurations=curve.points[:, : system.uv.stop],
        largest_row=float(np.max(np.abs(values))),
        hits=hits,
        self_motion=points.shape[1] == 2
        and is_one_place(points)
        and has_self_motion(system, curve.points[len(points) // 2]),
    )


def is_one_place(points: np.ndarray) -> bool:
    """Whether points (n, 2) of a curve are one place of the plane."""
    return bool(np.ptp(points, axis=0).max() <= _SAME_PLACE * max(1.0, float(np.abs(points).max())))


def merged(curves: Sequence[Locus], sides: np.ndarray) -> tuple[Locus, ...]:
    """One locus for each picture: those with more points in the configuration's working mode stand
    for the others.
    """
    kept: list[Locus] = []
    for curve in sorted(curves, key=lambda c: (-int(c.in_mode.sum()), -len(c.points))):
        place = next((k for k, other in enumerate(kept) if _has_picture(other, curve, sides)), None)
        if place is None:
            kept.append(curve)
        else:
            other = kept[place]
            limb = other.limb if other.limb == curve.limb else other.limb or curve.limb
            kept[place] = replace(
                other,
                hits=other.hits + curve.hits,
                limb=limb,
                self_motion=other.self_motion or curve.self_motion,
            )
    return tuple(sorted(kept, key=lambda c: (c.kind, c.limb or "", -len(c.points))))


def _has_picture(other: Locus, curve: Locus, sides: np.ndarray) -> bool:
    """Whether `curve` lies on the polyline of `other`, but for points where that is too coarse."""
    if (
        other.kind != curve.kind
        or (other.limb != curve.limb and curve.kind != "passive")
        or other.is_point != curve.is_point
    ):
        return False
    away, _ = picture_distance(other.points, other.closed, sides, curve.points)
    return bool(np.mean(away < SAME_PICTURE) >= _LEAST_SHARE and np.all(away < _FARTHEST))


def picture_distance(
    line: np.ndarray, closed: bool, sides: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How far points (k, 2) are from a polyline (n, 2), of the window's sides, and the number of
    the nearest segment.
    """
    line = np.vstack([line, line[:1]]) if closed or len(line) == 1 else line
    begin, along = line[:-1] / sides, np.diff(line, axis=0) / sides
    gaps = points[:, None] / sides - begin
    lengths = np.maximum(np.sum(along**2, axis=1), 1e-300)
    share = np.clip(np.sum(gaps * along, axis=2) / lengths, 0.0, 1.0)
    away = np.linalg.norm(gaps - share[:, :, None] * along, axis=2)
    return away.min(axis=1), away.argmin(axis=1)
