"""Walk from a closed configuration along its own assembly: other points of the component of the
solution set that holds it.

Least squares from far off may end at another assembly of the same links (cranks that were parallel
cross), whose mobility is another one. Here each step goes along a motion of first order or on in
the direction of the last step, and what brings it back to closed loops must be much shorter than
the step. Where that succeeds for random motions of first order, the rank is the same all around and
each of them is a motion. Else the configuration is singular: the closed configurations at a small
distance are sought, since every one near enough is joined to it (a real algebraic set is locally a
cone, Milnor 1968). Where there are none, no motion leads away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.newton import polish
from symkin.numeric.rank import Rank, null_space, row_space
from symkin.numeric.rank import generic as generic_one
from symkin.numeric.system import NOTHING, System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION, RANK_TOLERANCE, SINGULAR_VALUE

_LENGTHS = (0.06, 0.2, 0.6)
"""Of the size: how far walks go, over all coordinates together (rad, or lengths over the size)."""
_WALKS, _FEW_WALKS, _MANY_FREEDOMS = 8, 2, 40
"""Walks of each length; of a mechanism of many freedoms, whose single steps take long, fewer."""
_FIRST, _LONGEST = 0.03, 0.2
"""Of the size: the first step of a walk, shorter than the whole of any, and the longest one."""
_SIDEWAYS = 0.3
"""Share of a step that the way back to closed loops is at most, else the step left the component
and a shorter one is tried.
"""
_SHORTENED, _TRIES = 0.25, 4
"""Factor of the shorter steps, and how many lengths are tried."""
_OBSTACLE = 1e-3
"""What an obstacle of second order leaves the loops open by, over the step's square (of the size):
where less is closed to the digits of a file, a shorter step shows no motion.
"""
_SPREAD = (0.7, 1.3)
"""Random factors of the lengths: walks along one freedom end at different places."""
_STEPS = 24
"""Steps of a walk at most."""
_CLOSED_STEP = 1e-12
"""Of the size: rows below which a step's end is closed; rounding leaves 1e-15."""
_MEETING = 0.01
"""Of the size: distance from a singular configuration at which its branches are sought. An obstacle
of fifth order still leaves rows of 1e-10 there, and where a branch touches another one its rank is
clear (1e-6).
"""
_STEPS_OFF = 3
"""Steps as long from there: in each of several loops that share no joint, one of two leads off the
places at which that one is singular.
"""
_BESIDE = 0.2
"""Of the size: distance at which branches that touch are apart."""
_SEARCHES, _FEW_SEARCHES = 40, 12
"""Starts of that search; of a mechanism of many freedoms."""
_HALVINGS = 40
"""Steps of Newton at most to a configuration at which each step halves the distance."""
_FOLLOWING = 6
"""Steps of Newton by which the other coordinates follow a motion of first order."""
_FOLLOWED = 1e-16
"""Of the size: rows that another step of these would not lessen."""
_BESIDE_SINGULAR = 1e-12
"""Added to the diagonal of a matrix of order one that elimination finds singular."""
_LOOKED = 3
"""Configurations of a branch at which its dimension is found."""
_TANGENT, _SPANNED = 0.003, 0.1
"""Of the size: distance of configurations whose directions are nearly tangents; and singular value
of such unit directions, over the root of their number, above which they span another dimension:
radii of curvature are above a thirtieth of the size.
"""


@dataclass(frozen=True, eq=False)
class Component:
    """Generic configurations of the assembly that a closed configuration belongs to (n, width),
    that one alone where no motion leads away; their rank; how many freedoms of first order no
    motion follows; the ranks of other branches that meet there; where some are followed by none,
    directions (orthonormal rows) of those that lead away from one of the points.
    """

    points: np.ndarray
    rank: Rank
    infinitesimal: int = 0
    other_ranks: tuple[int, ...] = ()
    motions: np.ndarray | None = None


def regular_component(system: System, start: np.ndarray, seed: int) -> Component:
    """Walk away from a closed configuration of a system without known values, in random motions of
    first order. Where these are not all motions, all of them are counted as infinitesimal: see
    `component_at_singular`.
    """
    walker = _Walker(system, system.residual(start), np.random.default_rng(seed))
    motions, rank = walker.motions(start, RANK_TOLERANCE)
    if not len(motions):
        return Component(start[None], rank)
    lengths = np.repeat(_LENGTHS, _FEW_WALKS if system.freedom > _MANY_FREEDOMS else _WALKS)
    lengths *= walker.rng.uniform(*_SPREAD, len(lengths))
    first = walker.begun(start, walker.directions(motions, len(lengths)))
    if first is None:
        return Component(start[None], rank, infinitesimal=len(motions))
    ends = walker.closed(walker.walked(start, first, lengths))
    return Component(ends if len(ends) else start[None], rank)


def component_at_singular(system: System, start: np.ndarray, seed: int) -> Component:
    """The branch of largest rank of those that meet at a singular configuration. Branches that
    touch there are told from each other at a larger distance only, and one of these is a branch of
    this configuration if its rank is met at the small one too.
    """
    walker = _Walker(system, system.residual(start), np.random.default_rng(seed))
    motions, rank = walker.motions(start, RANK_TOLERANCE)
    searches = _FEW_SEARCHES if system.freedom > _MANY_FREEDOMS else _SEARCHES
    near = walker.near(start, motions, searches, _MEETING)
    if not len(near):
        return Component(start[None], rank, infinitesimal=len(motions), motions=motions[:0])
    near = walker.off_singular_places(start, near)
    meeting = {walker.motions(z, SINGULAR_VALUE)[1].value for z in near}
    ends = walker.closed(walker.walked(start, near, np.resize(_LENGTHS, len(near))))
    points = np.vstack([ends, walker.near(start, motions, searches, _BESIDE), near])
    looked = [(z, *walker.motions(z, SINGULAR_VALUE)) for z in points]
    looked = [(z, left, found) for z, left, found in looked if found.value in meeting]
    best = looked[generic_one([found for _, _, found in looked])][2]
    clear = [found.value for _, _, found in looked if found.is_clear and found.value != best.value]
    others = tuple(sorted({value for value in clear if clear.count(value) > 1}))
    kept = [
        (z, left)
        for z, left, found in looked
        if found.value == best.value and (found.is_clear or not best.is_clear)
    ]
    points, freedoms = (
        np.array([z for z, _ in kept[: len(_LENGTHS) * _WALKS]]),
        [left for _, left in kept],
    )
    some = slice(0, len(points), max(1, len(points) // _LOOKED))
    followed = walker.followed(points[some], freedoms[: len(points)][some])
    infinitesimal = len(freedoms[0]) - len(followed)
    return Component(points, best, infinitesimal, others, followed if infinitesimal else None)


def _unit(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)


@dataclass(frozen=True, eq=False)
class _Walker:
    """Steps among the closed configurations of a system; `misfit` is what the first one leaves open
    (length unit): digits of a file that cannot be mended by a step.
    """

    system: System
    misfit: float
    rng: np.random.Generator

    @property
    def size(self) -> float:
        return self.system.characteristic_length

    def allowed(self, share: float) -> float:
        """Closure error (length unit) up to which a configuration is closed, a share of the size at
        least.
        """
        return max(share * self.size, 10.0 * self.misfit)

    def motions(self, z: np.ndarray, share: float) -> tuple[np.ndarray, Rank]:
        """Motions of first order at a configuration, orthonormal rows, and the rank there."""
        _, jacobian = self.system.linearise_one(z)
        return null_space(jacobian, share, relative=True), Rank.of(jacobian, share)

    def directions(self, motions: np.ndarray, count: int) -> np.ndarray:
        return _unit(self.rng.normal(size=(count, len(motions))) @ motions)

    def begun(self, start: np.ndarray, directions: np.ndarray) -> np.ndarray | None:
        """Where one step in each direction ends; None where some of these are no motions."""
        begin = np.tile(start, (len(directions), 1))
        ends, went = self.stepped(begin, directions, np.full(len(directions), _FIRST * self.size))
        return ends if went.all() else None

    def off_singular_places(self, start: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Some short random steps from points, away from the start, along what is free at them:
        where more is free than motions they lead to where that is not so, and not back.
        """
        lengths = np.full(len(points), _MEETING * self.size)
        for _ in range(_STEPS_OFF):
            ways = [self.directions(self.motions(z, SINGULAR_VALUE)[0], 1)[0] for z in points]
            away = self.system.difference(np.tile(start, (len(points), 1)), points)
            sides = np.where(np.sum(ways * away, axis=1) < 0.0, -1.0, 1.0)
            points, _ = self.stepped(points, sides[:, None] * ways, lengths)
        return points

    def walked(self, start: np.ndarray, points: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Go on from points in the direction in which they lie of the start, as far as `lengths`
        (of the size); a walk that finds no way on ends where it is.
        """
        points, lengths = points.copy(), lengths * self.size
        before = np.tile(start, (len(points), 1))
        last = np.linalg.norm(self.system.difference(before, points), axis=1)
        gone = last.copy()
        going = np.arange(len(points))
        for _ in range(_STEPS):
            going = going[gone[going] < lengths[going]]
            if not going.size:
                break
            ways = _unit(self.system.difference(before[going], points[going]))
            most = np.minimum(2.0 * last[going], _LONGEST * self.size)
            ends, went = self.stepped(
                points[going], ways, np.minimum(lengths[going] - gone[going], most)
            )
            going, ends = going[went], ends[went]
            before[going], points[going] = points[going], ends
            last[going] = np.linalg.norm(self.system.difference(before[going], ends), axis=1)
            gone[going] += last[going]
        return points

    def stepped(
        self, z: np.ndarray, ways: np.ndarray, lengths: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """One step from each point, as long as it can be, and which of them went."""
        ends, lengths, left = z.copy(), lengths.copy(), np.arange(len(z))
        went, allowed = np.zeros(len(z), dtype=bool), self.allowed(_CLOSED_STEP)
        for _ in range(_TRIES):
            there = self.system.move(z[left], lengths[left, None] * ways[left])
            batch = levenberg_marquardt(
                self.system, there, NOTHING, tolerance=_CLOSED_STEP, max_iterations=40
            )
            back = np.linalg.norm(self.system.difference(there, batch.points), axis=1)
            good = (batch.largest_row <= allowed) & (back <= _SIDEWAYS * lengths[left])
            ends[left[good]], went[left[good]] = batch.points[good], True
            lengths[left] *= _SHORTENED
            left = left[~good]
            left = left[_OBSTACLE * lengths[left] ** 2 > allowed * self.size]
            if not left.size:
                break
        return ends, went

    def closed(self, points: np.ndarray) -> np.ndarray:
        """The points to full precision, those that close."""
        points = self.system.polish_many(points).points
        return points[self.system.residuals(points) <= self.allowed(CLOSED_CONFIGURATION)]

    def near(
        self, centre: np.ndarray, motions: np.ndarray, count: int, distance: float
    ) -> np.ndarray:
        """Closed configurations at a small distance from a singular one, by least squares from
        random motions of first order.
        """
        here = _Branching.at(self.system, centre, len(motions), distance * self.size)
        y = here.distance * _unit(self.rng.normal(size=(count, len(motions))))
        starts = here.move(np.tile(centre, (count, 1)), y)
        batch = levenberg_marquardt(
            here, starts, NOTHING, tolerance=_CLOSED_STEP, max_iterations=100, patience=20
        )
        # where motions of first order end at second order all along a branch, each step of Newton
        # halves what is left
        ends = polish(here, batch.points, NOTHING, _HALVINGS).points
        open_by = self.system.residuals(ends)
        return ends[open_by <= self.allowed(_CLOSED_STEP)]

    def followed(self, points: np.ndarray, motions: list[np.ndarray]) -> np.ndarray:
        """Of the motions of first order at generic configurations those that lead away from one:
        the fewest, since other branches that pass nearby add theirs.
        """
        every = (self._followed(point, there) for point, there in zip(points, motions, strict=True))
        return min(every, key=len)

    def _followed(self, point: np.ndarray, motions: np.ndarray) -> np.ndarray:
        count = 4 * len(motions) + 8
        if not len(motions) or self.begun(point, self.directions(motions, count)) is not None:
            return motions
        near = self.near(point, motions, count, _TANGENT)
        near = near[
            np.array(
                [len(self.motions(z, SINGULAR_VALUE)[0]) == len(motions) for z in near], dtype=bool
            )
        ]
        if not len(near):
            return motions[:0]
        ways = _unit(self.system.difference(np.tile(point, (len(near), 1)), near))
        return row_space(ways, _SPANNED * np.sqrt(len(ways)))


@dataclass(frozen=True, eq=False)
class _Branching:
    """What second and higher order ask of motions of first order at a singular configuration
    (Lyapunov and Schmidt's reduction), for configurations at one distance of it.

    With J = U S V^T there, U = (U1, U2), V = (V1, N) split at its rank: each motion y of first
    order, z = centre + N y + V1 c, has its c from U1^T F(z) = 0. What is left is U2^T F(z) = 0 in
    y, here times size / distance, on the sphere |y| = distance.
    """

    system: System
    centre: np.ndarray
    distance: float
    held: tuple[np.ndarray, np.ndarray]
    left: tuple[np.ndarray, np.ndarray]

    @staticmethod
    def at(system: System, centre: np.ndarray, motions: int, distance: float) -> _Branching:
        _, jacobian = system.linearise_one(centre)
        u, _, v = np.linalg.svd(jacobian)
        rank = len(v) - motions
        return _Branching(
            system, centre, distance, (u[:, :rank], v[:rank].T), (u[:, rank:], v[rank:].T)
        )

    @property
    def characteristic_length(self) -> float:
        return self.system.characteristic_length

    @property
    def freedom(self) -> int:
        return self.left[1].shape[1]

    def linearise(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The rows that are left, and their derivatives along y, across the sphere."""
        rows, jacobians = self.system.linearise(z, known)
        (u1, v1), (u2, n) = self.held, self.left
        follows = -_solved(u1.T @ jacobians @ v1, u1.T @ jacobians @ n)
        y = _unit(self._motion_of(z))
        share = self.characteristic_length / self.distance
        slopes = share * (u2.T @ (jacobians @ (n + v1 @ follows)))
        return share * (rows @ u2), slopes - (slopes @ y[:, :, None]) * y[:, None]

    def move(self, z: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Configurations of moved y at the distance, whose other coordinates follow."""
        (u1, v1), (_, n) = self.held, self.left
        begin = np.tile(self.centre, (len(z), 1))
        z = self.system.move(begin, self.distance * _unit(self._motion_of(z) + step) @ n.T)
        for _ in range(_FOLLOWING):
            rows, jacobians = self.system.linearise(z)
            held = rows @ u1
            if not np.max(np.abs(held), initial=0.0) > _FOLLOWED * self.characteristic_length:
                break
            z = self.system.move(
                z, -_solved(u1.T @ jacobians @ v1, held[:, :, None])[:, :, 0] @ v1.T
            )
        return z

    def _motion_of(self, z: np.ndarray) -> np.ndarray:
        return self.system.difference(np.tile(self.centre, (len(z), 1)), z) @ self.left[1]


def _solved(matrices: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions of square systems, in dimensionless numbers; of a singular one far off, any: it
    closes nothing.
    """
    try:
        return np.linalg.solve(matrices, right)
    except np.linalg.LinAlgError:
        return np.linalg.solve(matrices + _BESIDE_SINGULAR * np.eye(matrices.shape[-1]), right)
