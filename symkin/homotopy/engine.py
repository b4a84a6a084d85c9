"""The engine that tracks paths of a system: compiled C where a compiler is found and it pays, else
NumPy.

Both have the same meaning (see `tracker`) and agree on the roots. SYMKIN_ENGINE = numpy keeps to
NumPy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.homotopy import tracker
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.compiled import CompiledTracker, load
from symkin.homotopy.tracker import Tracked, TrackSettings

Line = tuple[np.ndarray, np.ndarray]
"""Known values (known,) at which paths begin and end."""
_FAR, _MOST_TIMES = 20.0, 100.0
"""Known values (rad, sizes) as far away as this take as many steps as paths may have, those further
away as many times more, at most so many.
"""
_WORTH_COMPILING = 50
"""Instructions of one evaluation below which NumPy answers sooner than a compiler builds."""


def track(
    system: AlgebraicSystem,
    z: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    settings: TrackSettings | None = None,
) -> Tracked:
    """Roots z (width, n) of F(., begin) to roots of F(., end); known values (known,) or (known,
    n).
    """
    end = aligned(system, begin, end)
    settings = _as_long(settings or TrackSettings(), begin, end)
    compiled, _ = engine_of(system)
    if compiled is not None:
        return compiled.track(z, begin, end, settings)
    return tracker.track(system, z, begin, end, settings)


def _as_long(settings: TrackSettings, begin: np.ndarray, end: np.ndarray) -> TrackSettings:
    """The settings with more steps where known values are far away, as screws of many turns are:
    rows turn as often on the way.
    """
    far = float(np.abs((end.T - begin.T).T).max(initial=0.0))
    if not far > _FAR:
        return settings
    times = min(far / _FAR, _MOST_TIMES)
    return replace(settings, most_steps=int(times * settings.most_steps))


def track_lines(
    system: AlgebraicSystem,
    roots: Sequence[np.ndarray],
    lines: Sequence[Line],
    settings: TrackSettings | None = None,
) -> list[Tracked]:
    """Roots (width, n) of each line's beginning to its end, all lines at once: the same as `track`
    of each.
    """
    if len(lines) < 2:
        return [
            track(system, z, begin, end, settings)
            for z, (begin, end) in zip(roots, lines, strict=True)
        ]
    counts = [z.shape[1] for z in roots]
    begin = np.repeat(np.array([begin for begin, _ in lines], dtype=complex).T, counts, axis=1)
    end = np.repeat(np.array([end for _, end in lines], dtype=complex).T, counts, axis=1)
    whole = track(system, np.concatenate(roots, axis=1), begin, end, settings)
    ends = np.cumsum(counts)
    return [
        whole.take(slice(last - count, last))
        for last, count in zip(ends.tolist(), counts, strict=True)
    ]


def newton(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, iterations: int = 5
) -> tuple[np.ndarray, np.ndarray]:
    """Newton at fixed k, (known,) or (known, n); points and the size of the last step. Nothing is
    compiled for it alone.
    """
    compiled, _ = engine_of(system, build=False)
    return (
        compiled.newton(z, k, iterations) if compiled else tracker.newton(system, z, k, iterations)
    )


def engine_of(system: AlgebraicSystem, *, build: bool = True) -> tuple[CompiledTracker | None, str]:
    """The compiled engine of a system, built at need if `build`, or None; and what is used, in a
    few words.
    """
    if system.cost < _WORTH_COMPILING:
        return None, "NumPy"
    compiled, text = load(system, build=build)
    return compiled, text if compiled else f"NumPy ({text})"


def aligned(system: AlgebraicSystem, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Known values `end` with a known quaternion q scaled by the complex number that takes it
    nearest to that of `begin`, p: q (q* p) / (q* q). The roots are the same, the way is shorter.
    """
    if not system.known_ray:
        return end
    ray = list(system.known_ray)
    end = np.array(end, dtype=complex)
    p, q = np.asarray(begin)[ray], end[ray]
    p = p.reshape(p.shape + (1,) * (q.ndim - p.ndim))
    end[ray] = q * (np.sum(np.conj(q) * p, axis=0) / np.sum(np.abs(q) ** 2, axis=0))
    return end
