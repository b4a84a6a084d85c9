"""The base of a start system from which real instances are tracked in few steps.

The generic roots of a mechanism may be kept at any generic complex known values. How many steps a path takes depends on
how close to branch points it passes; bases beside the middle of what is asked for, apart by imaginary parts only, do
better than bases anywhere. Candidates are tried on typical real targets, and the one with the fewest steps is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.homotopy import tracker
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.tracker import Tracked, TrackSettings

Track = Callable[[AlgebraicSystem, np.ndarray, np.ndarray, np.ndarray, TrackSettings | None], Tracked]
"""`tracker.track` or one of the same meaning."""
_CAREFUL = TrackSettings(tolerance=1e-5)
_LEAST, _MOST = 0.4, 2.0
"""Heights of bases over real known values: lower ones pass close to real branch points, higher ones are far away."""
_SAME = 1e-7
"""Distance of features below which two ends are one root."""


@dataclass(frozen=True, eq=False)
class Choice:
    """The start that was chosen, and for each candidate, the start that was given first, the targets at which a path failed or
    met another one, and the mean steps of a target; (all, infinity) for a base that the start did not reach. All
    candidates were tried on the first target, the best quarter on all."""

    start: Fibre
    failures: tuple[int, ...]
    steps: tuple[float, ...]


def bases_beside(targets: Sequence[np.ndarray], count: int, seed: int) -> list[np.ndarray]:
    """Complex known values beside the mean of real ones, at a height of 0.4 to 2 (of the size, of a radian) over it:
    imaginary parts about the same everywhere, or of any sign, and real parts that scatter a little. Numbers that are
    the same in all targets, such as a geometry, stay."""
    rng = np.random.default_rng(seed)
    values = np.asarray(targets)
    middle, free = values.mean(axis=0), np.ptp(values.real, axis=0) > 0.0
    bases = []
    for i in range(count):
        sign = rng.choice([-1.0, 1.0], len(middle)) if i % 2 else np.ones(len(middle))
        scatter = 0.1 * rng.normal(size=(2, len(middle)))
        aside = _LEAST * (_MOST / _LEAST) ** rng.uniform() * (1j * sign * (1.0 + scatter[0]) + scatter[1])
        bases.append(np.where(free, middle.real + aside, middle))
    return bases


def best_start(
    system: AlgebraicSystem, start: Fibre, bases: Iterable[np.ndarray], targets: Sequence[np.ndarray],
    track: Track = tracker.track, settings: TrackSettings | None = None,
) -> Choice:  # fmt: skip
    """The roots of `start` at whichever of its own base and `bases` takes the fewest steps to the real known values
    `targets`, fewest failures first. A base counts only if all roots reach it and stay apart."""
    candidates = [start, *(_moved(system, start, base, track) for base in bases)]
    scores = [_score(system, candidate, targets[:1], track, settings) for candidate in candidates]
    order = sorted(range(len(scores)), key=scores.__getitem__)
    finalists = order[: max(2, len(order) // 4)]
    for i in finalists:
        scores[i] = _score(system, candidates[i], targets, track, settings)
    best = candidates[min(finalists, key=scores.__getitem__)]
    return Choice(best or start, tuple(s[0] for s in scores), tuple(s[1] for s in scores))


def _moved(system: AlgebraicSystem, start: Fibre, base: np.ndarray, track: Track) -> Fibre | None:
    """The roots at another base, in their order, or None where one is lost."""
    tracked = track(system, start.z, start.k, base, _CAREFUL)
    return replace(start, z=tracked.z, k=base) if _is_whole(system, tracked) else None


def _score(
    system: AlgebraicSystem, start: Fibre | None, targets: Sequence[np.ndarray], track: Track, settings: TrackSettings | None
) -> tuple[int, float]:
    if start is None:
        return len(targets), np.inf
    ends = [track(system, start.z, start.k, target, settings) for target in targets]
    return sum(not _is_whole(system, end) for end in ends), float(np.mean([end.steps for end in ends]))


def _is_whole(system: AlgebraicSystem, tracked: Tracked) -> bool:
    """All paths have arrived, at roots that differ."""
    if not tracked.arrived.all():
        return False
    f = system.all_features(tracked.z)
    distance = np.max(np.abs(f[:, None] - f[None]), axis=2) + np.eye(len(f))
    return bool(distance.min() > _SAME)
