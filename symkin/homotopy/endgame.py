"""Where paths end that a tracker cannot follow to their target: singular roots, infinity, sets that
are not isolated.

All paths that failed are followed together on circles k1 + t d, |t| = r, of falling radius about
the target k1 (see `circles`). A path that comes back by itself to where Newton settles is regular.
Else what its cycle says at one radius is believed when the next radius says the same and the rows
agree.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.circles import Germ, circle, follow, gaps, separations
from symkin.homotopy.ends import Ends, SingularRoots
from symkin.homotopy.engine import aligned, newton, track
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.point_checks import ROWS, is_no_pose, lie_on_sets, look, polish
from symkin.homotopy.tracker import Tracked, TrackSettings
from symkin.numeric.tolerances import MULTIPLE_ROOT_SHARE, RANK_TOLERANCE, ROOT_POLISHED

RADII = (3e-2, 6e-3, 1.2e-3, 2.5e-4, 5e-5, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13)
"""Radii of the circles, as shares of the line from the base to the target."""
_WIDE = (2e-1, 1e-1, 5e-2, 3e-2)
"""Radii for what these leave open: ends at infinity that are approached faster than their digits
last.
"""
_BASES = (0.3 + 0.4j, 0.3 - 0.5j)
"""Where a second and a third base lie on the complex line from the start to the target, 0 and 1 on
it.
"""
_AGREED = 1e-6
"""Largest distance between ends that two radii, or a mean and Newton, give for one cycle."""
_BESIDE = (1e-7, 1e-9)
"""Distances from a root at which a Newton step shows that it is well conditioned; the second for
roots about which the rows bend more.
"""
_RETURNED = 0.05
"""Share of such a distance by which a step from beside a regular root may miss it."""
_ONE = 1e-7
"""Distance below which two regular ends are one root, and one of the paths has jumped."""
_SAME_END = 1e-5
"""Distance within which singular ends of different cycles are one root."""
_CLUSTER = 1e-12
"""Rows up to which an end stands for roots that nearly merge, where no smaller circle tells them
apart.
"""

_OPEN, _REGULAR, _MULTIPLE, _INFINITE = range(4)
_SPLIT = "paths meet about the target, but the rows do not vanish where they meet"


@dataclass(frozen=True, eq=False)
class _End:
    """A mean, polished: its point, the largest row there, whether the Jacobian has lost its rank,
    and the rows that an exact root may leave.
    """

    point: np.ndarray
    rows: float
    is_singular: bool
    allowed: float


@dataclass(eq=False)
class _Paths:
    """For each path of one attempt its kind, end, turns and accuracy so far, and why it is open.
    `last` holds the germs of the last circle, `clusters` ends whose rows nearly vanish, `tried` the
    paths that were sent straight on.
    """

    kind: np.ndarray
    z: np.ndarray
    turns: np.ndarray
    accuracy: np.ndarray
    reason: list[str]
    last: dict[int, Germ] = field(default_factory=dict)
    clusters: dict[int, tuple[np.ndarray, int, float]] = field(default_factory=dict)
    tried: set[int] = field(default_factory=set)

    def decide(
        self, i: int, kind: int, point: np.ndarray, turns: int = 1, accuracy: float = 0.0
    ) -> None:
        self.kind[i], self.z[:, i], self.turns[i], self.accuracy[i] = kind, point, turns, accuracy

    def leave(self, paths: Iterable[int], reason: str, accuracy: float | None = None) -> None:
        for i in paths:
            self.kind[i], self.reason[i] = _OPEN, reason
            self.accuracy[i] = self.accuracy[i] if accuracy is None else accuracy


def finish(system: AlgebraicSystem, start: Fibre, target: np.ndarray, tracked: Tracked) -> Ends:
    """Ends of all paths of `tracked`, which go straight from `start` to `target`. Where paths stay
    unresolved, all of them are followed again by other ways, within the complex line through the
    start's known values and the target.
    """
    with np.errstate(all="ignore"):
        regular = are_regular(system, tracked, target)
        if regular.all():
            return Ends(tracked.z, SingularRoots.none(system.width), 0, ())
        done = _with_far_roots(system, start, target, tracked, (~regular).nonzero()[0])
        if done is not None:
            return done
        best = _attempt(system, start.z, start.k, target, tracked, 1e-4)
        for attempt, place in enumerate(_BASES):
            if not best.unresolved:
                break
            careful = TrackSettings(
                tolerance=10.0 ** (-5 - attempt), smallest_step=1e-10, most_steps=2000
            )
            base = start.k + place * (target - start.k)
            moved = track(system, start.z, start.k, base, careful)
            if moved.arrived.all():
                tracked = track(system, moved.z, base, target, careful)
                again = _attempt(system, moved.z, base, target, tracked, careful.tolerance)
                best = again if len(again.unresolved) < len(best.unresolved) else best
    return best


def are_regular(system: AlgebraicSystem, tracked: Tracked, target: np.ndarray) -> np.ndarray:
    """Paths that arrived at regular roots with a pose, no two at the same: these need no
    endgame.
    """
    regular = tracked.arrived.copy()
    places = np.flatnonzero(regular)
    if not places.size:
        return regular
    z = tracked.z[:, places]
    good = are_well_conditioned(system, z, target)
    regular[places] = good & ~is_no_pose(system, z) & (separations(system, z) > _ONE)
    return regular


def are_well_conditioned(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Which roots z (width, n) at known values (known,) or (known, n) are well conditioned: a
    Newton step from beside each leads back to it, or the Jacobian there has full rank.
    """
    direction, good = _direction(system.width), np.zeros(z.shape[1], dtype=bool)
    for distance in _BESIDE:
        left = (~good).nonzero()[0]
        if left.size:
            here, at = z[:, left], k if k.ndim == 1 else k[:, left]
            back, _ = newton(system, here + distance * direction, at, 1)
            good[left] = gaps(system, back, here) < _RETURNED * distance
    left = (~good).nonzero()[0]
    if left.size:
        at = k if k.ndim == 1 else k[:, left]
        good[left] = look(system, z[:, left], at).share > RANK_TOLERANCE
    return good


@lru_cache(maxsize=64)
def _direction(width: int) -> np.ndarray:
    """A random complex direction (width, 1), the same for every root."""
    rng = np.random.default_rng(0)
    return rng.normal(size=(width, 1)) + 1j * rng.normal(size=(width, 1))


def _with_far_roots(
    system: AlgebraicSystem, start: Fibre, target: np.ndarray, tracked: Tracked, left: np.ndarray
) -> Ends | None:
    """Ends where all paths that are `left` lead to regular roots far from the real ones, which
    Newton's method with more bits finds where they arrived, or do so by shorter steps; else None.
    Those that are no pose to the last digits are at infinity.
    """
    from symkin.homotopy.far_roots import are_far, are_infinite, completed, is_square, settled

    z = tracked.z.copy()
    if not is_square(system) or not are_far(system, z[:, left]).all():
        return None
    came = left[tracked.arrived[left]]
    found, z[:, came] = settled(system, z[:, came], target)
    end, missing = aligned(system, start.k, target), np.setdiff1d(left, came[found])
    for _ in range(2):
        if completed(system, start, z, missing, end).size:
            return None
        # of paths that have come to one root, one has jumped
        missing = np.flatnonzero(separations(system, z) < _ONE)
        if not missing.size:
            infinite = are_infinite(system, z)
            none = SingularRoots.none(system.width)
            return Ends(z[:, ~infinite], none, int(infinite.sum()), ())
    return None


def _attempt(
    system: AlgebraicSystem,
    z: np.ndarray,
    base: np.ndarray,
    target: np.ndarray,
    tracked: Tracked,
    tolerance: float,
) -> Ends:
    n = z.shape[1]
    kind = np.where(are_regular(system, tracked, target), _REGULAR, _OPEN)
    paths = _Paths(kind, tracked.z.copy(), np.ones(n, dtype=int), np.full(n, np.inf), [""] * n)
    _close_in(system, z, base, target, paths, tolerance, RADII)
    _close_in(system, z, base, target, paths, tolerance, _WIDE)
    for i, (point, turns, accuracy) in paths.clusters.items():
        if paths.kind[i] == _OPEN:
            paths.decide(i, _MULTIPLE, point, turns, accuracy)
    places = np.flatnonzero(paths.kind == _REGULAR)
    paths.leave(
        places[separations(system, paths.z[:, places]) < _ONE], "two paths end at one regular root"
    )
    return _collect(system, target, paths)


# --- circles --------------------------------------------------------------------------------------


def _close_in(
    system: AlgebraicSystem,
    z: np.ndarray,
    base: np.ndarray,
    target: np.ndarray,
    paths: _Paths,
    tolerance: float,
    radii: tuple[float, ...],
) -> None:
    """Decide open paths on circles of falling radius."""
    paths.last = {}
    direction = base - target
    going = np.flatnonzero(paths.kind == _OPEN)
    here, begin = z[:, going], base
    settings = TrackSettings(tolerance=tolerance, smallest_step=1e-10, most_steps=2000)
    for radius in radii if going.size else ():
        at = target + radius * direction
        moved, came = follow(system, here, begin, at, settings)
        paths.leave(going[~came], f"stalled before {radius:.0e} of the line")
        going, here, begin = going[came], moved[:, came], at
        if not going.size:
            return
        apart = float(np.min(separations(system, here), initial=1.0))
        settings = replace(
            settings, tolerance=float(np.clip(0.01 * apart, 1e-9, 1e-4)), most_steps=400
        )
        around = replace(settings, first_step=0.5, smallest_step=1e-4, most_steps=100)
        germs = circle(system, here, target, direction, radius, around)
        floor = float(np.max(look(system, here, at).largest_row, initial=0.0))
        _judge(
            system,
            target,
            going,
            {int(going[j]): germ for j, germ in germs.items()},
            ROWS + 10 * floor,
            paths,
        )
        _go_straight(system, here, at, target, going, paths)
        left = paths.kind[going] == _OPEN
        going, here = going[left], here[:, left]


def _judge(
    system: AlgebraicSystem,
    target: np.ndarray,
    going: np.ndarray,
    germs: dict[int, Germ],
    allowed: float,
    paths: _Paths,
) -> None:
    """Decide paths by one circle, the one before and the rows at the target, of which `allowed` may
    be left.
    """
    paths.leave(going, "its cycle about the target does not close")
    if germs:
        points = np.array([germ.point for germ in germs.values()]).T
        regular, exact = _settle(system, points, target)
        polished, local = polish(system, points, target)
        for j, (i, germ) in enumerate(germs.items()):
            if regular[j] and germ.turns == 1 and germ.is_closed:
                paths.decide(i, _REGULAR, exact[:, j])
            else:
                end = _End(
                    polished[:, j],
                    float(local.largest_row[j]),
                    bool(local.share[j] < MULTIPLE_ROOT_SHARE),
                    allowed,
                )
                _compare(system, i, germ, end, paths)
    paths.last = germs


def _settle(
    system: AlgebraicSystem, points: np.ndarray, target: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Which points (width, n) Newton settles at once at a regular pose, and where."""
    exact, last = newton(system, points, target, 6)
    regular = (
        (last < ROOT_POLISHED)
        & (gaps(system, exact, points) < _AGREED)
        & ~is_no_pose(system, exact)
    )
    return regular & (look(system, exact, target).share > RANK_TOLERANCE), exact


def _compare(system: AlgebraicSystem, i: int, new: Germ, end: _End, paths: _Paths) -> None:
    """Decide a path by what the last circle said of it and by its end."""
    old = paths.last.get(i)
    if old is None or old.turns != new.turns:
        return paths.leave([i], "its cycle was seen on one circle only")
    if _leaves(system, old, new):
        return paths.decide(i, _INFINITE, end.point)
    gap = float(gaps(system, old.point, new.point))
    if not (new.is_closed and gap < _AGREED and new.principal.max() < _AGREED):
        return paths.leave([i], f"two circles give ends that are {gap:.0e} apart", gap)
    accuracy = max(gap, end.rows ** (1 / new.turns))
    if end.is_singular and end.rows <= end.allowed:
        return paths.decide(i, _MULTIPLE, end.point, new.turns, accuracy)
    if end.is_singular and end.rows <= _CLUSTER:
        paths.clusters[i] = end.point, new.turns, accuracy
    return paths.leave([i], _SPLIT, accuracy)


def _leaves(system: AlgebraicSystem, old: Germ, new: Germ) -> bool:
    """Whether both circles say that some unknown goes to infinity."""
    if (old.leaving & new.leaving).any():
        return True
    gap = float(gaps(system, old.point, new.point))
    settled = gap < _AGREED and new.principal.max() < _AGREED
    return bool(settled and is_no_pose(system, new.point[:, None], gap)[0])


def _go_straight(
    system: AlgebraicSystem,
    here: np.ndarray,
    at: np.ndarray,
    target: np.ndarray,
    going: np.ndarray,
    paths: _Paths,
) -> None:
    """Paths that nearly merge before the target are tracked on to it, once, by steps as small as it
    takes.
    """
    split = [j for j, i in enumerate(going) if paths.reason[i] == _SPLIT and i not in paths.tried]
    if split:
        tracked = track(
            system, here[:, split], at, target, TrackSettings(tolerance=1e-6, smallest_step=1e-12)
        )
        paths.tried |= {int(going[j]) for j in split}
        for j in np.flatnonzero(are_regular(system, tracked, target)):
            paths.decide(int(going[split[j]]), _REGULAR, tracked.z[:, j])


def _collect(system: AlgebraicSystem, target: np.ndarray, paths: _Paths) -> Ends:
    """Singular ends within their accuracy of each other are one root."""
    left = np.flatnonzero(paths.kind == _MULTIPLE)
    left = left[np.argsort(paths.accuracy[left], kind="stable")]
    groups, accuracy = [], []
    while left.size:
        gap = gaps(system, paths.z[:, left], paths.z[:, left[:1]])
        same = gap < np.maximum(_SAME_END, paths.accuracy[left])
        groups.append(left[same])
        accuracy.append(max(gap[same].max(), paths.accuracy[left[same]].max()))
        left = left[~same]
    singular = SingularRoots.none(system.width)
    if groups:
        points = np.stack([paths.z[:, g[0]] for g in groups], axis=1)
        multiplicity = np.array([len(g) for g in groups])
        turns = np.array([paths.turns[g].max() for g in groups])
        singular = SingularRoots(
            points, multiplicity, turns, np.array(accuracy), ~lie_on_sets(system, points, target)
        )
    reasons = tuple(paths.reason[i] for i in np.flatnonzero(paths.kind == _OPEN))
    return Ends(
        paths.z[:, paths.kind == _REGULAR], singular, int(np.sum(paths.kind == _INFINITE)), reasons
    )
