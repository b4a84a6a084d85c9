"""The base of a start system from which real instances are tracked in few steps.

The generic roots of a mechanism may be kept at any generic complex known values. How many steps a
path takes depends on how close to branch points it passes; bases beside the middle of what is asked
for, apart by imaginary parts only, do better than bases anywhere. Candidates are tried on typical
real targets, and the one with the fewest steps is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.engine import Line, track_lines
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.tracker import Tracked, TrackSettings

TrackLines = Callable[
    [AlgebraicSystem, Sequence[np.ndarray], Sequence[Line], TrackSettings | None], list[Tracked]
]
"""`engine.track_lines` or one of the same meaning."""
_CAREFUL = TrackSettings(tolerance=1e-5)
_LEAST, _MOST = 0.4, 2.0
"""Heights of bases over real known values: lower ones pass close to real branch points, higher ones
are far away.
"""
_SAME = 1e-7
"""Distance of features below which two ends are one root."""


@dataclass(frozen=True, eq=False)
class Choice:
    """The start that was chosen, and for each candidate, the start that was given first, the
    targets at which a path failed or met another one, and the mean steps of a target; (all,
    infinity) for a base that the start did not reach. All candidates were tried on the first
    target, the best quarter on all.
    """

    start: Fibre
    failures: tuple[int, ...]
    steps: tuple[float, ...]


def bases_beside(targets: Sequence[np.ndarray], count: int, seed: int) -> list[np.ndarray]:
    """Complex known values beside the mean of real ones, at a height of 0.4 to 2 (of the size, of a
    radian) over it: imaginary parts about the same everywhere, or of any sign, and real parts that
    scatter a little. Numbers that are the same in all targets, such as a geometry, stay.
    """
    rng = np.random.default_rng(seed)
    values = np.asarray(targets)
    middle, free = values.mean(axis=0), np.ptp(values.real, axis=0) > 0.0
    bases = []
    for i in range(count):
        sign = rng.choice([-1.0, 1.0], len(middle)) if i % 2 else np.ones(len(middle))
        scatter = 0.1 * rng.normal(size=(2, len(middle)))
        aside = (
            _LEAST
            * (_MOST / _LEAST) ** rng.uniform()
            * (1j * sign * (1.0 + scatter[0]) + scatter[1])
        )
        bases.append(np.where(free, middle.real + aside, middle))
    return bases


def best_start(
    system: AlgebraicSystem,
    start: Fibre,
    bases: Iterable[np.ndarray],
    targets: Sequence[np.ndarray],
    track: TrackLines = track_lines,
) -> Choice:
    """The roots of `start` at whichever of its own base and `bases` takes the fewest steps to the
    real known values `targets`, fewest failures first. A base counts only if all roots reach it and
    stay apart.
    """
    candidates = _moved(system, start, list(bases), track)
    scores = [(len(targets), np.inf)] * len(candidates)
    whole = [i for i, candidate in enumerate(candidates) if candidate is not None]

    def score(which: list[int], targets: Sequence[np.ndarray]) -> None:
        chosen = [
            (candidate, target) for i in which if (candidate := candidates[i]) for target in targets
        ]
        lines = [(candidate.k, target) for candidate, target in chosen]
        tracked = track(system, [candidate.z for candidate, _ in chosen], lines, None)
        for place, i in enumerate(which):
            ends = tracked[place * len(targets) : (place + 1) * len(targets)]
            lost = sum(not _is_whole(system, end) for end in ends)
            scores[i] = lost, float(np.mean([end.steps for end in ends]))

    score(whole, targets[:1])
    finalists = sorted(whole, key=scores.__getitem__)[: max(2, len(candidates) // 4)]
    score(finalists, targets)
    best = candidates[min(finalists, key=scores.__getitem__)]
    return Choice(best or start, tuple(s[0] for s in scores), tuple(s[1] for s in scores))


def _moved(
    system: AlgebraicSystem, start: Fibre, bases: Sequence[np.ndarray], track: TrackLines
) -> list[Fibre | None]:
    """The start itself, and its roots at other bases, in their order; None where one is lost."""
    tracked = track(system, [start.z] * len(bases), [(start.k, base) for base in bases], _CAREFUL)
    moved = [
        replace(start, z=t.z, k=k) if _is_whole(system, t) else None
        for t, k in zip(tracked, bases, strict=True)
    ]
    return [start, *moved]


def _is_whole(system: AlgebraicSystem, tracked: Tracked) -> bool:
    """All paths have arrived, at roots that differ."""
    if not tracked.arrived.all():
        return False
    f = system.features(tracked.z)
    distance = np.max(np.abs(f[:, None] - f[None]), axis=2) + np.eye(len(f))
    return bool(distance.min() > _SAME)
