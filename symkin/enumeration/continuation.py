"""Every mode by parameter continuation from the mechanism's own start system.

The roots of one generic complex instance are found once for a mechanism and kept (see `start_store`); each real
instance is then a straight path in the known values from there, with exactly the mechanism's own number of paths. All
paths accounted for, the list is complete with probability one: the random numbers avoid a set of measure zero, and the
generic count rests on a theorem's bound or on the evidence of monodromy, never on a proof.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.enumeration.algebraic import (
    AlgebraicSystem,
    algebraic_systems,
    imaginary_part,
    known_values,
    real_values,
    rotation_share,
)
from symkin.enumeration.monodromy import Fibre
from symkin.enumeration.multistart import batched
from symkin.enumeration.roots import SINGULAR_ROOT, Roots, is_of_continuum, merge, unite
from symkin.enumeration.start_store import start_of
from symkin.enumeration.tracker import TrackSettings, newton, track
from symkin.position.given import Given
from symkin.position.levenberg import Progress
from symkin.position.problem import Problem
from symkin.position.solution import ACCEPTED
from symkin.position.system import System

_AT_INFINITY = 1e-7
_FADING = 5e-3
_GROWN_ANGLE = 4.0
_GROWN_LENGTH = 50.0
_REAL = 1e-5
"""Largest imaginary part of a root that is tried as a real one; the closure decides."""
_RETRIES = 3


@dataclass(frozen=True, eq=False)
class Ends:
    """What the paths of one block came to: distinct finite roots z (width, n), how many paths ended at infinity and
    how many at singular roots, and which start roots are unresolved."""

    z: np.ndarray
    at_infinity: int
    singular: int
    unresolved: int


def by_continuation(
    problem: Problem, given: Given, starts: int, rng: np.random.Generator, progress: Progress | None = None
) -> tuple[list[Roots], tuple[str, ...]]:
    """Roots of each block by paths; blocks without a start system by `starts` random starts, with a note why."""
    blocks, notes = [], []
    systems = {tuple(sorted(c.name for c in b.unknowns)): b for b in problem.blocks}
    reason = unsuitable(problem)
    algebraic = () if reason else algebraic_systems(problem)
    for block in systems.values():
        names = {c.name for c in block.unknowns}
        match = next((a for a in algebraic if names >= {c.name for c in a.unknowns} and _covers(a, names)), None)
        start, why = (None, reason) if match is None else start_of(problem, match, block, progress)
        if match is None or start is None:
            roots = batched(problem, block, given, starts, rng)
            notes.append(f"{', '.join(sorted(names))}: sampled by multistart, {why}")
            blocks.append(roots)
            continue
        ends = instance(match, start, known_values(problem, given.values))
        blocks.append(_real_roots(problem, match, block, ends, given, starts, rng))
        notes += _orbit_notes(start)
    return blocks, tuple(notes)


def unsuitable(problem: Problem) -> str | None:
    """Why a problem has no complex start system, if it has none."""
    for c in problem.system.unknowns:
        if c.kind == "turns":
            return f"the closure is not algebraic in {c.name} (helical joint)"
        if c.kind == "quaternion" and c.role != "pose":
            return f"{c.name} is a spherical joint that the closure keeps"
    return None


def _covers(system: AlgebraicSystem, names: set[str]) -> bool:
    """The algebraic block has the coordinates of a real block: its affine ones, and the pose if it is projective."""
    pose = {n for n in names if n.startswith("pose.")}
    affine = {c.name for c in system.unknowns}
    return affine == names or (bool(system.projective) and affine == names - pose)


def _orbit_notes(start: Fibre) -> list[str]:
    sizes = np.bincount(start.orbits)
    if len(sizes) < 2:
        return []
    return [f"the generic modes fall into {len(sizes)} operation modes of {', '.join(str(s) for s in sizes)} complex solutions"]


# --- paths of one instance ---------------------------------------------------------------------------------------


def instance(system: AlgebraicSystem, start: Fibre, target: np.ndarray) -> Ends:
    """Track all generic roots to known values `target`. What fails, or meets another path, is tracked again over a
    second base at a tenth of the tolerance; what then still fails near the end is tried as a singular root."""
    settings = TrackSettings()
    tracked = track(system, start.z, start.k, target, settings)
    z, s = tracked.z.copy(), tracked.s.copy()
    done = _without_collisions(system, z, tracked.arrived)
    for attempt in range(_RETRIES):
        if done.all():
            break
        z, s, done = _again(
            system, start, target, (z, s, done), replace(settings, tolerance=settings.tolerance * 0.1 ** (attempt + 1)), attempt
        )
    return _classify(system, z, s, done, target)


def _again(
    system: AlgebraicSystem, start: Fibre, target: np.ndarray, state: tuple[np.ndarray, np.ndarray, np.ndarray],
    settings: TrackSettings, attempt: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    z, s, done = state
    careful = replace(settings, most_steps=8000, smallest_step=1e-10)
    rng = np.random.default_rng(100 + attempt)
    base = start.k + 0.4 * (rng.normal(size=len(start.k)) + 1j * rng.normal(size=len(start.k)))
    moved = track(system, start.z, start.k, base, careful)
    left = np.ones(start.z.shape[1], dtype=bool) if attempt else ~done
    left &= moved.arrived
    tracked = track(system, moved.z[:, left], base, target, careful)
    z, s, arrived = z.copy(), s.copy(), done.copy()
    places = np.flatnonzero(left)
    better = tracked.arrived | (tracked.s >= s[places]) | bool(attempt)
    z[:, places[better]], s[places[better]] = tracked.z[:, better], tracked.s[better]
    arrived[places] = tracked.arrived
    return z, s, _without_collisions(system, z, arrived)


def _without_collisions(system: AlgebraicSystem, z: np.ndarray, arrived: np.ndarray) -> np.ndarray:
    """Two paths that end in one regular root: one of them has jumped, and both count as failed."""
    done = arrived.copy()
    places = np.flatnonzero(done)
    if places.size > 1:
        f = system.features(z[:, places])
        close = np.max(np.abs(f[:, None] - f[None]), axis=2) < 1e-7
        done[places[close.sum(axis=1) > 1]] = False
    return done


def _classify(system: AlgebraicSystem, z: np.ndarray, s: np.ndarray, done: np.ndarray, target: np.ndarray) -> Ends:
    failed = ~done & np.isfinite(z).all(axis=0)
    leaving = failed & _leaves(system, z, s)
    near = failed & ~leaving & (s > 1 - 1e-3)
    ends, last = newton(system, z[:, near], target, 60) if near.any() else (z[:, near], np.zeros(0))
    singular = last < 1e-6
    finite, _ = newton(system, z[:, done], target)
    at_infinity = rotation_share(system, finite) < _AT_INFINITY
    everything = np.concatenate([finite[:, ~at_infinity], ends[:, singular]], axis=1)
    first = np.zeros(0, dtype=int)
    if everything.shape[1]:
        f = system.features(everything)
        first, _ = merge(np.hstack([f.real, f.imag]), 1e-6)
    unresolved = int(np.sum(~done)) - int(leaving.sum()) - int(singular.sum())
    return Ends(everything[:, first], int(at_infinity.sum() + leaving.sum()), int(singular.sum()), unresolved)


def _leaves(system: AlgebraicSystem, z: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Paths that stalled on their way to infinity: a rotation part that fades beside the dual one, or, without
    projective coordinates, angles or lengths that have grown beyond all others close to the end."""
    if system.projective:
        return (s > 0.9) & (rotation_share(system, z) < _FADING)
    angles = [i for i, c in enumerate(system.unknowns) if c.is_angular]
    lengths = [i for i, c in enumerate(system.unknowns) if not c.is_angular]
    grown = np.max(np.abs(z[angles].imag), axis=0, initial=0.0) > _GROWN_ANGLE
    return np.asarray((s > 1 - 1e-4) & (grown | (np.max(np.abs(z[lengths]), axis=0, initial=0.0) > _GROWN_LENGTH)))


# --- from complex to real ----------------------------------------------------------------------------------------


def _real_roots(
    problem: Problem, algebraic: AlgebraicSystem, block: System, ends: Ends, given: Given, starts: int, rng: np.random.Generator
) -> Roots:
    """Roots that are real: polished on the block's own rows and checked on all of them. Where paths are unresolved or
    singular, random starts look for what they missed and for sets that are not isolated."""
    candidates = np.flatnonzero(imaginary_part(algebraic, ends.z) < _REAL)
    points: list[np.ndarray] = []
    members: list[np.ndarray] = []
    smallest = np.inf
    for i in candidates:
        named = real_values(algebraic, ends.z[:, i])
        z = block.polish(np.concatenate([named[c.name] for c in block.unknowns]), given.values, steps=8)
        left = block.residual(block.fold(z[None])[0], given.values)
        smallest = min(smallest, left)
        if left <= ACCEPTED * block.size:
            (members if is_of_continuum(block, z, given.values) else points).append(block.fold(z[None])[0])
    found = np.array(points).reshape(len(points), block.width)
    continuum = np.array(members) if members else None
    if ends.unresolved or ends.singular or not points:
        sampled = batched(problem, block, given, starts, rng)
        regular = [z for z in sampled.points if block.condition(z, given.values) < SINGULAR_ROOT]
        found = np.concatenate([found, np.array(regular).reshape(len(regular), block.width)])
        continuum = sampled.continuum if continuum is None else continuum
        smallest = min(smallest, sampled.smallest_residual)
    first, _ = unite(block, found, given.values, continuum_met=continuum is not None)
    found = found[first]
    return Roots(
        block,
        found,
        None,
        smallest,
        continuum=continuum,
        complex_count=ends.z.shape[1],
        unresolved=ends.unresolved,
        sampled=False,
    )
