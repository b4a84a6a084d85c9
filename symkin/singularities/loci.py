"""Singularity loci over a plane of two coordinates: curves of true zeros, found from random configurations and traced.

Over two pose coordinates the loci belong to poses; over two actuated joints they bound the regions in which the number of
real assembly modes is constant, and have cusps where three modes meet. Seeds: random configurations over the plane are
closed, lifted by the null vector of their smallest singular value (`locus_system`) and brought onto the curve by
Levenberg-Marquardt; then the curve is traced (`curve`). A closed curve that no seed reaches is missed: `starts` says how
many seeds there were, `hits` how often each curve was met.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.position.solution import Solution
from symkin.singularities.curve import Curve, Window, trace
from symkin.singularities.cusps import with_cusps
from symkin.singularities.locus import SAME_PICTURE, Locus, make_locus, merged, picture_distance
from symkin.singularities.locus_seeds import inside, seeds_of
from symkin.singularities.locus_system import LocusKind, LocusSystem, Plane, locus_systems, plane_of
from symkin.singularities.motion_ranks import generic_ranks
from symkin.singularities.working_mode import same_mode

DEFAULT_STARTS = 200
MOST_STARTS = 100_000
_FINENESS = 1 / 150
"""Longest step of a curve in the plane, of the window's sides."""
_FEW_HITS = 2
"""Where some curve was met by no more seeds than this, another may have been met by none."""
MISSING = "some curves were met by one or two seeds only: curves may be missing; raise --starts"
"""What is said then, in the text and in the picture."""


@dataclass(frozen=True, eq=False)
class Loci:
    """All curves found over a plane through a configuration; `ranges` are the window's sides in the mechanism's units."""

    plane: Plane
    ranges: tuple[tuple[float, float], tuple[float, float]]
    curves: tuple[Locus, ...]
    starts: int
    seed: int
    notes: tuple[str, ...]

    @property
    def solution(self) -> Solution:
        return self.plane.solution

    def of(self, kind: str) -> tuple[Locus, ...]:
        return tuple(curve for curve in self.curves if curve.kind == kind)

    @property
    def units(self) -> tuple[str, str]:
        m = self.plane.mechanism
        first, second = (m.angle_unit if c.is_angular else m.length_unit for c in self.plane.coordinates)
        return first, second

    def to_json(self) -> dict[str, Any]:
        """One object: the window and, for each curve, kind, limb, points and cusps in the mechanism's units."""
        return {
            "mechanism": self.plane.mechanism.name,
            "plane": list(self.plane.names),
            "units": list(self.units),
            "ranges": [list(r) for r in self.ranges],
            "configuration": self.solution.to_json(),
            "curves": [
                {
                    "kind": c.kind, "limb": c.limb, "closed": c.closed, "points": c.points.tolist(), "cusps": c.cusps.tolist(),
                    "in_mode": c.in_mode.tolist(), "largest_row": c.largest_row, "hits": c.hits, "self_motion": c.self_motion,
                    "loose_ends": c.loose_ends(self.ranges).tolist(),
                }
                for c in self.curves
            ],
            "starts": self.starts,
            "seed": self.seed,
            "notes": list(self.notes),
        }  # fmt: skip

    def __str__(self) -> str:
        from symkin.view.loci_text import loci_text

        return loci_text(self)


def singular_loci(
    solution: Solution,
    plane: Sequence[str],
    *,
    ranges: Sequence[Sequence[float]] | None = None,
    kinds: Sequence[LocusKind] = ("type 1", "type 2"),
    starts: int = DEFAULT_STARTS,
    seed: int = 0,
) -> Loci:
    """Curves of singular configurations over two coordinates, all other pose coordinates (or actuated joints) as in
    `solution`, whose working mode is the one that `in_mode` names.

    `plane` names two pose coordinates (x, y, z, gamma; rx, ry, rz turn about base axes) or two actuated joints; `ranges`
    are two pairs in the mechanism's units, by default half the size or half a turn to both sides. Raises InputError.
    """
    chosen = plane_of(solution, plane)
    if seed < 0:
        raise InputError(f"seed = {seed} must not be negative")
    if not 1 <= starts <= MOST_STARTS:
        raise InputError(f"starts = {starts}; allowed: 1 to {MOST_STARTS}")
    if not kinds or any(kind not in ("type 1", "type 2") for kind in kinds):
        raise InputError(f"kinds = {', '.join(kinds)!r}; allowed: type 1, type 2")
    if chosen.of_pose:
        _check_pose(chosen)
    window = _window(chosen, ranges)
    curves: list[Locus] = []
    notes: list[str] = []
    for system in locus_systems(chosen, kinds):
        found, note = _curves(system, window, starts, np.random.default_rng(seed))
        curves.extend(found)
        notes.extend([note] if note else [])
    outside = tuple(
        (chosen.mechanism.angle_out(low), chosen.mechanism.angle_out(high)) if c.is_angular else (low, high)
        for c, (low, high) in zip(chosen.coordinates, window.tolist(), strict=True)
    )
    found_sides = np.ptp(np.array(outside), axis=1)
    kept = merged(curves, found_sides)
    if any(curve.hits <= _FEW_HITS and not curve.is_point for curve in kept):
        notes.append(MISSING)
    return Loci(chosen, (outside[0], outside[1]), kept, starts, seed, tuple(dict.fromkeys(notes)))


def _check_pose(plane: Plane) -> None:
    """Every pose near the configuration must be one that the mechanism takes."""
    freedoms = generic_ranks(plane.mechanism).outputs
    wanted = sum(c.freedom for c in plane.closure.role("pose"))
    if freedoms < wanted:
        raise InputError(
            f"plane = {', '.join(plane.names)!r}: the platform of {plane.mechanism.name} has {freedoms} freedoms of {wanted}, so that "
            "two pose coordinates cannot vary alone; allowed: two actuated joints, or pose coordinates of a declared motion"
        )


def _window(plane: Plane, ranges: Sequence[Sequence[float]] | None) -> np.ndarray:
    """Sides (2, 2) in inside units."""
    if ranges is None:
        half = [np.pi if c.is_angular else 0.5 * plane.closure.size for c in plane.coordinates]
        sides = np.array([[m - h, m + h] for m, h in zip([c.reference[0] for c in plane.coordinates], half, strict=True)])
    else:
        sides = np.array([_side(plane, k, r) for k, r in enumerate(ranges)]) if len(ranges) == 2 else np.zeros((0, 2))
        if len(sides) != 2:
            raise InputError(f"ranges: {len(ranges)} given, two are needed, one for each of {', '.join(plane.names)}")
    for k, c in enumerate(plane.coordinates):
        if c.least is not None:
            sides[k, 0] = max(sides[k, 0], c.least) + 0.0
            if not sides[k, 0] < sides[k, 1]:
                raise InputError(
                    f"range of {plane.names[k]} ends at {sides[k, 1]:g} {plane.mechanism.length_unit}; allowed: above "
                    f"{c.least + 0.0:g}, where the rod has no length"
                )
    return sides


def _side(plane: Plane, k: int, given: Sequence[float]) -> tuple[float, float]:
    low, high = (float(v) for v in given) if len(given) == 2 else (0.0, 0.0)
    if not (np.isfinite([low, high]).all() and low < high):
        raise InputError(f"range of {plane.names[k]} = {list(given)}; two numbers are needed, the lower one first")
    if plane.coordinates[k].is_angular:
        return plane.mechanism.angle_in(low), plane.mechanism.angle_in(high)
    return low, high


# --- curves ----------------------------------------------------------------------------------------------


def _curves(system: LocusSystem, window: np.ndarray, starts: int, rng: np.random.Generator) -> tuple[list[Locus], str | None]:
    """Distinct curves through the seeds, and what to say where there are none to be had."""
    curves: list[tuple[Curve, np.ndarray, np.ndarray, int]] = []
    view, isolated = _view(system, window), 0
    found = seeds_of(system, window, starts, rng)
    seeds, name = found.points, system.kind + (f" of {system.limb}" if system.limb else "")
    if not found.closed:
        return [], f"{name}: none of {starts} starts closes over the window"
    if found.everywhere:
        return [], f"{name}: a freedom that no actuated joint decides, everywhere; there are no curves"
    modes = same_mode(system, np.array(seeds)) if seeds else np.zeros(0, dtype=bool)
    for k in sorted(range(len(seeds)), key=lambda k: not modes[k]):
        place = _place(system, curves, seeds[k], bool(modes[k]), window)
        if place is not None:
            curves[place] = (*curves[place][:3], curves[place][3] + 1)
            continue
        curve = trace(system.curve, seeds[k], view)
        if curve is None:
            isolated += 1
        else:
            curve, cusps = with_cusps(system, curve)
            curves.append((curve, cusps, same_mode(system, curve.points), 1))
    note = f"{name}: {isolated} seeds lie on no curve (crossings, isolated or everywhere singular)" if isolated else None
    return [make_locus(system, *parts) for parts in curves], note


def _view(system: LocusSystem, window: np.ndarray) -> Window:
    """The window for tracing: steps of at most 1/150 of its sides in the plane."""
    sides = window[:, 1] - window[:, 0]
    scale = np.array([system.curve.size if c.is_angular else 1.0 for c in system.plane.coordinates])

    def cap(t: np.ndarray) -> float:
        speed = float(np.max(np.abs(t[system.uv_columns]) / (scale * sides)))
        return _FINENESS / speed if speed > 0.0 else np.inf

    return Window(lambda z: inside(z[system.uv], window), cap, len(system.free) + 2)


def _place(
    system: LocusSystem,
    curves: Sequence[tuple[Curve, np.ndarray, np.ndarray, int]],
    z: np.ndarray,
    in_mode: bool,
    window: np.ndarray,
) -> int | None:
    """Number of the curve whose picture has a seed; a seed in the configuration's working mode asks for one that has it too."""
    sides = window[:, 1] - window[:, 0]
    for k, (curve, _, mode, _) in enumerate(curves):
        away, nearest = picture_distance(curve.points[:, system.uv], curve.closed, sides, z[None, system.uv])
        if away[0] < SAME_PICTURE and (not in_mode or mode[nearest[0]]):
            return k
    return None
