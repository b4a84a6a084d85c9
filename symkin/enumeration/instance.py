"""All paths from a mechanism's generic roots to one set of given values."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.enumeration.algebraic import AlgebraicSystem, rotation_share
from symkin.enumeration.engine import newton, track
from symkin.enumeration.monodromy import Fibre
from symkin.enumeration.roots import merge
from symkin.enumeration.tracker import Tracked, TrackSettings

_AT_INFINITY = 1e-7
_FADING = 5e-3
_GROWN_ANGLE = 4.0
_GROWN_LENGTH = 50.0
_RETRIES = 3


@dataclass(frozen=True, eq=False)
class Ends:
    """What the paths of one block came to: distinct finite roots z (width, n), how many paths ended at infinity and
    how many at singular roots, and which start roots are unresolved."""

    z: np.ndarray
    at_infinity: int
    singular: int
    unresolved: int


def instance(system: AlgebraicSystem, start: Fibre, target: np.ndarray) -> Ends:
    """Track all generic roots to known values `target`. What fails, or meets another path, is tracked again over a
    second base at a tenth of the tolerance; what then still fails near the end is tried as a singular root."""
    settings = TrackSettings()
    tracked = _tracked(system, start, target, settings)
    z, s = tracked.z.copy(), tracked.s.copy()
    done = _without_collisions(system, z, tracked.arrived)
    for attempt in range(_RETRIES):
        if done.all():
            break
        z, s, done = _again(
            system, start, target, (z, s, done), replace(settings, tolerance=settings.tolerance * 0.1 ** (attempt + 1)), attempt
        )
    return _classify(system, z, s, done, target)


def _tracked(system: AlgebraicSystem, start: Fibre, target: np.ndarray, settings: TrackSettings) -> Tracked:
    """All paths; of those that symmetries carry to each other, one is followed."""
    mirrors = start.mirrors
    if mirrors is None:
        return track(system, start.z, start.k, target, settings)
    return mirrors.unfold_tracked(track(system, start.z[:, mirrors.first], start.k, target, settings))


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
        f = system.all_features(z[:, places])
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
        f = system.all_features(everything)
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
