"""Search for the curves of one locus: random closed configurations are brought onto it, and the
curves traced from there.

Points belong to the working mode of another configuration by the signs of the limbs' inverse
problems: with the pose given each limb is a problem of its own, F_i(q_i, x_i) = 0; where it is
square, two of its solutions between which det dF_i/d(q_i, x_i) changes its sign are different
working modes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import whole_system
from symkin.singularities.curve import Curve, Window, correct, is_regular, trace
from symkin.singularities.cusps import with_cusps
from symkin.singularities.locus import SAME_PICTURE, is_one_place, picture_distance
from symkin.singularities.locus_system import LocusSystem
from symkin.velocity.limb_equations import limb_blocks

_RADII = (0.1, 0.5, 3.0)
"""Random steps off the configuration, of the size: the same mode, its neighbours, anywhere."""
_CLOSED = 1e-8
"""A start is closed when no row exceeds this times the size; the curve's own correction follows."""
_OTHER_VECTORS = 3
"""Beside the null vector of the smallest singular value a start tries one of so many next ones: of
joints that are nearly parallel everywhere, or of units far apart, the smallest one never leads to a
curve.
"""
_SAME_VALUE = 1e-7
"""Zeros over one coordinate are one place where they are within this (rad, or of the size): they
are known to 1e-11.
"""
_FINENESS = 1 / 150
"""Longest step of a curve in the plane, of the window's sides."""


@dataclass(frozen=True, eq=False)
class Seeds:
    """Points of the curves in the window and the number of the start that each came from; how many
    starts closed the loops, and whether J has lost rank at most of them: then there are no curves,
    the whole plane is singular.
    """

    points: list[np.ndarray]
    starts: list[int]
    closed: int
    lost_everywhere: bool


def seeds_of(
    system: LocusSystem, window: np.ndarray, starts: int, rng: np.random.Generator
) -> Seeds:
    """Seeds from random closed configurations over the window (inside units)."""
    closed = _closed_starts(system, window, starts, rng)
    if not len(closed):
        return Seeds([], [], 0, False)
    lifted, smallest = zip(*(system.lift(z) for z in closed), strict=True)
    if float(np.median(smallest)) < RANK_TOLERANCE:
        return Seeds([], [], len(closed), True)
    begin, numbers = _lifted_starts(lifted)
    batch = levenberg_marquardt(
        system.curve, begin, np.zeros(0), max_iterations=60, tolerance=1e-10
    )
    points, origins = [], []
    for z, number in zip(batch.points[batch.converged], numbers[batch.converged], strict=True):
        point = correct(system.curve, system.curve.fold(system.curve.unit(z)[None])[0])
        if point is not None and system.loss.is_lost(point[: system.uv.stop]):
            point = _turned_into(system, point, window)
            if inside(point[system.uv], window):
                points.append(point)
                origins.append(int(number))
    return Seeds(points, origins, len(closed), False)


def _lifted_starts(lifted: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """All starts with their first null vector, then all with another one in turn (of every radius),
    and the starts' numbers.
    """
    numbers = np.arange(len(lifted))
    begin = [vectors[0] for vectors in lifted]
    others = min(_OTHER_VECTORS, len(lifted[0]) - 1)
    if not others:
        return np.array(begin), numbers
    begin += [vectors[1 + k // len(_RADII) % others] for k, vectors in enumerate(lifted)]
    return np.array(begin), np.tile(numbers, 2)


def inside(uv: np.ndarray, window: np.ndarray) -> bool:
    return bool(np.all(uv >= window[:, 0]) and np.all(uv <= window[:, 1]))


def _closed_starts(
    system: LocusSystem, window: np.ndarray, starts: int, rng: np.random.Generator
) -> np.ndarray:
    """Closed configurations (n, width of free coordinates, u, v) from random steps off the plane's
    configuration.
    """
    part = system.closed
    begin = np.tile(system.centre, (starts, 1))
    radii = np.resize(_RADII, starts)[:, None] * part.characteristic_length
    begin = part.move(begin, radii * rng.normal(size=(starts, part.freedom)))
    begin[:, system.uv] = rng.uniform(window[:, 0], window[:, 1], (starts, len(window)))
    if not part.rows.shape[0]:
        return begin
    batch = levenberg_marquardt(part, begin, np.zeros(0), max_iterations=60)
    ends = part.fold(batch.points[batch.converged])
    return np.array(
        [
            z
            for z in ends
            if part.residual(part.unit(z), np.zeros(0)) <= _CLOSED * part.characteristic_length
        ]
    )


def _turned_into(system: LocusSystem, point: np.ndarray, window: np.ndarray) -> np.ndarray:
    """Angles of the plane that lie outside the window, moved by whole turns towards it. Rows of an
    orientation change sign with a turn, and with them a w that relates rows: it is taken anew
    there.
    """
    turned = point.copy()
    uv = turned[system.uv]
    for k, (c, (low, high)) in enumerate(zip(system.plane.coordinates, window, strict=True)):
        if c.is_periodic and not low <= uv[k] <= high:
            uv[k] = low + np.remainder(uv[k] - low, 2 * np.pi)
    if not np.array_equal(turned, point) and system.loss.free_motions:
        return system.lift(turned[: system.uv.stop])[0][0]
    return turned


# --- tracing --------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Traced:
    """A curve and its equations, the numbers of its cusps, its points in the working mode, and the
    starts that met it.
    """

    system: LocusSystem
    curve: Curve
    cusps: np.ndarray
    in_mode: np.ndarray
    starts: set[int]


def traced_curves(
    system: LocusSystem, found: Seeds, window: np.ndarray
) -> tuple[list[Traced], int]:
    """Curves through the seeds, and how many starts ended on none. Seeds in the configuration's
    working mode come first, inexact ones (multiple zeros) last. Those at which more than one rank
    is lost and no curve is found are tried again at the end, with w free to move in one place: most
    are on other seeds' curves by then.
    """
    if len(system.plane.coordinates) == 1:
        return _points(system, found), 0
    traced: list[Traced] = []
    seeds, view = found.points, _tracing_window(system, window)
    modes = same_mode(system, np.array(seeds)) if seeds else np.zeros(0, dtype=bool)
    regular = [is_regular(system.curve, z) for z in seeds]
    left = sorted(range(len(seeds)), key=lambda k: (not regular[k], not modes[k]))
    for again in (False, True):
        missed = []
        for k in left:
            met = _curve_at(system, traced, seeds[k], bool(modes[k]), window)
            if met is None:
                met = _curve_through(system, seeds[k], view, again)
                traced.extend([] if met is None else [met])
            if met is None:
                missed.append(k)
            else:
                met.starts.add(found.starts[k])
        left = missed
    return traced, len({found.starts[k] for k in left})


def _points(system: LocusSystem, found: Seeds) -> list[Traced]:
    """The zeros over one coordinate, one for each value of it: seeds are zeros already."""
    traced: list[Traced] = []
    near = _SAME_VALUE * system.plane.coordinates[0].unit(system.closed.characteristic_length)
    for z, start in zip(found.points, found.starts, strict=True):
        same = next(
            (t for t in traced if np.abs(t.curve.points[0, system.uv] - z[system.uv])[0] <= near),
            None,
        )
        if same is None:
            alone = Curve(z[None], np.zeros((1, system.curve.freedom)), closed=False)
            same = Traced(system, alone, np.zeros(0, dtype=int), np.ones(1, dtype=bool), set())
            traced.append(same)
        same.starts.add(start)
    return sorted(traced, key=lambda t: float(t.curve.points[0, system.uv][0]))


def _curve_through(
    system: LocusSystem, seed: np.ndarray, view: Window, again: bool
) -> Traced | None:
    here, start = (system, seed) if again else system.through(seed)
    curve = trace(here.curve, start, view)
    if curve is None or (here is not system and is_one_place(curve.points[:, system.uv])):
        return None
    curve, cusps = with_cusps(here, curve)
    return Traced(here, curve, cusps, same_mode(system, curve.points), set())


def _tracing_window(system: LocusSystem, window: np.ndarray) -> Window:
    """The window for tracing: steps of at most 1/150 of its sides in the plane."""
    sides = window[:, 1] - window[:, 0]
    scale = np.array(
        [c.lever(system.curve.characteristic_length) for c in system.plane.coordinates]
    )

    def cap(t: np.ndarray) -> float:
        speed = float(np.max(np.abs(t[system.uv_columns]) / (scale * sides)))
        return _FINENESS / speed if speed > 0.0 else np.inf

    return Window(lambda z: inside(z[system.uv], window), cap, len(system.free) + 2)


def _curve_at(
    system: LocusSystem, traced: Sequence[Traced], z: np.ndarray, in_mode: bool, window: np.ndarray
) -> Traced | None:
    """The curve whose picture has a seed; a seed in the configuration's working mode asks for one
    that has it too.
    """
    sides = window[:, 1] - window[:, 0]
    for t in traced:
        away, nearest = picture_distance(
            t.curve.points[:, system.uv], t.curve.closed, sides, z[None, system.uv]
        )
        if away[0] < SAME_PICTURE and (not in_mode or t.in_mode[nearest[0]]):
            return t
    return None


# --- working modes --------------------------------------------------------------------------------


def same_mode(system: LocusSystem, points: np.ndarray) -> np.ndarray:
    """For points (n, width) of a curve, whether every limb's sign is that of the plane's
    configuration. Limbs whose inverse problem is not square, or that the curve's equations leave
    out, tell nothing.
    """
    blocks = _blocks(system)
    if not blocks:
        return np.ones(len(points), dtype=bool)
    count = system.uv.stop
    own = _signs(blocks, system.centre)
    here = np.array([_signs(blocks, z[:count]) for z in points])
    return np.all((own == 0.0) | (here == own), axis=1)


def _signs(blocks: Sequence[ca.Function], z: np.ndarray) -> np.ndarray:
    return np.array([np.sign(np.linalg.det(np.asarray(block(z)))) for block in blocks])


def _blocks(system: LocusSystem) -> list[ca.Function]:
    """dF_i/d(q_i, x_i) of the limbs where it is square, as functions of (free, u, v)."""
    if system.plane.by_name or (system.kind == "type 1" and system.plane.of_pose):
        return []
    plane = system.plane
    closure, whole = plane.closure, whole_system(plane.closure)
    unknown = ca.vertcat(plane.closure.symbols(system.free), plane.symbols)
    found = []
    for limb in limb_blocks(closure):
        if len(limb.joints) == len(limb.rows) and limb.limb != system.limb:
            block = ca.substitute(
                whole.jacobian[limb.rows, limb.joints], closure.variables, plane.values
            )
            found.append(ca.Function("block", [unknown], [ca.densify(block)], {"cse": True}))
    return found
