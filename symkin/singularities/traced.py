"""Distinct curves through the seeds of a locus."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.singularities.curve import Curve, Window, is_regular, trace
from symkin.singularities.cusps import with_cusps
from symkin.singularities.locus import SAME_PICTURE, picture_distance, stands
from symkin.singularities.locus_seeds import Seeds, inside
from symkin.singularities.locus_system import LocusSystem
from symkin.singularities.working_mode import same_mode

_FINENESS = 1 / 150
"""Longest step of a curve in the plane, of the window's sides."""


@dataclass(frozen=True, eq=False)
class Traced:
    """A curve and its equations, the numbers of its cusps, its points in the working mode, and the starts that met it."""

    system: LocusSystem
    curve: Curve
    cusps: np.ndarray
    in_mode: np.ndarray
    starts: set[int]


def traced_curves(system: LocusSystem, found: Seeds, window: np.ndarray) -> tuple[list[Traced], int]:
    """Curves through the seeds, and how many starts ended on none. Seeds in the configuration's working mode come first, inexact
    ones (multiple zeros) last. Those at which more than one rank is lost and no curve is found are tried again at the end, with
    w free to move in one place: most are on other seeds' curves by then."""
    traced: list[Traced] = []
    seeds, view = found.points, _view(system, window)
    modes = same_mode(system, np.array(seeds)) if seeds else np.zeros(0, dtype=bool)
    regular = [is_regular(system.curve, z) for z in seeds]
    left = sorted(range(len(seeds)), key=lambda k: (not regular[k], not modes[k]))
    for again in (False, True):
        missed = []
        for k in left:
            met = _met(system, traced, seeds[k], bool(modes[k]), window)
            if met is None:
                met = _through(system, seeds[k], view, again)
                traced.extend([] if met is None else [met])
            if met is None:
                missed.append(k)
            else:
                met.starts.add(found.starts[k])
        left = missed
    return traced, len({found.starts[k] for k in left})


def _through(system: LocusSystem, seed: np.ndarray, view: Window, again: bool) -> Traced | None:
    here, start = (system, seed) if again else system.through(seed)
    curve = trace(here.curve, start, view)
    if curve is None or (here is not system and stands(curve.points[:, system.uv])):
        return None
    curve, cusps = with_cusps(here, curve)
    return Traced(here, curve, cusps, same_mode(system, curve.points), set())


def _view(system: LocusSystem, window: np.ndarray) -> Window:
    """The window for tracing: steps of at most 1/150 of its sides in the plane."""
    sides = window[:, 1] - window[:, 0]
    scale = np.array([system.curve.size if c.is_angular else 1.0 for c in system.plane.coordinates])

    def cap(t: np.ndarray) -> float:
        speed = float(np.max(np.abs(t[system.uv_columns]) / (scale * sides)))
        return _FINENESS / speed if speed > 0.0 else np.inf

    return Window(lambda z: inside(z[system.uv], window), cap, len(system.free) + 2)


def _met(system: LocusSystem, traced: Sequence[Traced], z: np.ndarray, in_mode: bool, window: np.ndarray) -> Traced | None:
    """The curve whose picture has a seed; a seed in the configuration's working mode asks for one that has it too."""
    sides = window[:, 1] - window[:, 0]
    for t in traced:
        away, nearest = picture_distance(t.curve.points[:, system.uv], t.curve.closed, sides, z[None, system.uv])
        if away[0] < SAME_PICTURE and (not in_mode or t.in_mode[nearest[0]]):
            return t
    return None
