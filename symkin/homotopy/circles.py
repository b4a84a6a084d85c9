"""Paths around a target: z on the circle k(t) = k1 + t d, |t| = r, of complex known values.

Where the circle encloses no branch point but t = 0, a path that comes back after c turns is a
Laurent series in t^(1/c), and the mean of its samples over the c turns is its value at t = 0, with
an error of order (r / rho)^M for M samples a turn and the next branch point at rho (Cauchy's
integral; Morgan, Sommese, Wampler 1991).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.homotopy import tracker
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.engine import engine_of, track
from symkin.homotopy.tracker import TrackSettings

VERTICES = 8
"""Samples a turn; the paths go along the chords between them."""
_LONG = 1000
"""Steps of a long way, which take NumPy half a second; a chord of a circle is given up before."""
_CLOSED = 1e-6
"""Largest distance (of coordinates of order one) between a path's end and the start that it has
come back to.
"""
_NOTHING = 1e-6
"""Share of the largest sample or coefficient that counts as none."""
_POLE = 1e-3
"""Least coefficient of a pole, times its power of r."""
_APART = 1e-2
"""Largest share of the distance to the nearest other path that a match may take up."""


@dataclass(frozen=True, eq=False)
class Germ:
    """One cycle of a path about the target, of `turns` turns.

    `point` is the mean (rays in the chart of their main direction, unit length); `principal` the
    largest Laurent coefficient of a negative power, times its power of r, of each unknown and then
    of the ray; `leaving` the unknowns that are infinite at t = 0: angles z that gain whole turns in
    a cycle, so that exp(iz) or exp(-iz) vanishes there, and lengths with a pole there.
    """

    turns: int
    point: np.ndarray
    principal: np.ndarray
    leaving: np.ndarray
    is_closed: bool


def gaps(system: AlgebraicSystem, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances of points a from points b (width, ...), which broadcast: angles up to whole turns,
    large lengths by their ratio, rays by their sine.
    """
    ray, count = list(system.projective), len(system.unknowns)
    gap = a[:count] - b[:count]
    if system.angles:
        gap[system.angles] -= 2 * np.pi * np.round(gap[system.angles].real / (2 * np.pi))
    if system.others:
        gap[system.others] /= np.maximum(1.0, np.abs(b[system.others]))
    found = np.abs(gap).max(axis=0, initial=0.0)
    if ray:
        p, q = a[ray] / _length(a[ray]), b[ray] / _length(b[ray])
        found = np.maximum(found, _length(p - q * (q.conj() * p).sum(axis=0)))
    return found


def _length(x: np.ndarray) -> np.ndarray:
    """Lengths of complex vectors along the first axis: a third of the time of NumPy's norm."""
    return np.asarray(np.sqrt((x.real**2 + x.imag**2).sum(axis=0)))


def distances(system: AlgebraicSystem, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances (n, m) between points a (width, n) and b (width, m)."""
    return gaps(system, a[:, :, None], b[:, None, :])


def separations(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """Distance (n,) of each point to the nearest other one; infinite for a single point."""
    apart = distances(system, z, z)
    np.fill_diagonal(apart, np.inf)
    return apart.min(axis=1, initial=np.inf)


def follow(
    system: AlgebraicSystem,
    z: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    settings: TrackSettings,
) -> tuple[np.ndarray, np.ndarray]:
    """Paths tracked from begin to end, and which of them came there, whatever Newton says of their
    last digits: near an end at infinity few of them are determined. The compiled engine does not go
    where it cannot polish; NumPy does. A way that is long for one is long for both, and is not
    followed twice.
    """
    tracked = track(system, z, begin, end, settings)
    came = (tracked.s >= 1.0) & np.isfinite(tracked.z).all(axis=0)
    left = np.flatnonzero(~came & (tracked.tries < _LONG))
    if left.size and engine_of(system)[0] is not None:
        again = tracker.track(system, z[:, left], begin, end, settings)
        tracked.z[:, left] = again.z
        came[left] = (again.s >= 1.0) & np.isfinite(again.z).all(axis=0)
    return tracked.z, came


def circle(
    system: AlgebraicSystem,
    z: np.ndarray,
    target: np.ndarray,
    direction: np.ndarray,
    radius: float,
    settings: TrackSettings,
) -> dict[int, Germ]:
    """Send paths z (width, n) from t = radius around the target; germs of those that come back to
    where they began, by path.
    """
    samples, through = _turn(system, z, target, direction, radius, settings)
    followers = np.where(through, _matches(system, samples), -1)
    found: dict[int, Germ] = {}
    for members in _cycles(followers):
        found |= dict.fromkeys(members, _germ(system, samples, members))
    return found


def _turn(
    system: AlgebraicSystem,
    z: np.ndarray,
    target: np.ndarray,
    direction: np.ndarray,
    radius: float,
    settings: TrackSettings,
) -> tuple[np.ndarray, np.ndarray]:
    """Samples (VERTICES + 1, width, n) of one turn, and which paths came through."""
    t = radius * np.exp(2j * np.pi * np.arange(VERTICES) / VERTICES)
    corners = [target + x * direction for x in (*t, t[0])]
    samples = np.full((VERTICES + 1, *z.shape), np.nan, dtype=complex)
    samples[0] = z
    going = np.arange(z.shape[1])
    for m in range(VERTICES):
        if going.size:
            ends, came = follow(system, samples[m][:, going], corners[m], corners[m + 1], settings)
            going = going[came]
            samples[m + 1][:, going] = ends[:, came]
    through = np.zeros(z.shape[1], dtype=bool)
    through[going] = True
    return samples, through


def _matches(system: AlgebraicSystem, samples: np.ndarray) -> np.ndarray:
    """Which path begins where each path ends; -1 where none does, or another path ends there
    too.
    """
    begin, end = samples[0], samples[-1]
    apart = distances(system, end, begin)
    apart[~np.isfinite(apart)] = np.inf
    nearest = np.argmin(apart, axis=1)
    gap = apart[np.arange(len(nearest)), nearest]
    followers = np.where(
        (gap < _CLOSED) & (gap < _APART * separations(system, begin)[nearest]), nearest, -1
    )
    taken = np.bincount(followers[followers >= 0], minlength=len(nearest))
    return np.where((followers >= 0) & (taken[followers] == 1), followers, -1)


def _cycles(followers: np.ndarray) -> list[list[int]]:
    """Closed cycles of a partial permutation."""
    found, seen = [], np.zeros(len(followers), dtype=bool)
    for i in range(len(followers)):
        chain: list[int] = []
        while i >= 0 and not seen[i]:
            seen[i] = True
            chain.append(i)
            i = int(followers[i])
        if chain and i == chain[0]:
            found.append(chain)
    return found


def _germ(system: AlgebraicSystem, samples: np.ndarray, members: list[int]) -> Germ:
    """What the samples (VERTICES + 1, width, n) of one cycle say of its end."""
    z = np.concatenate([samples[:-1, :, i] for i in members])
    affine, ray = len(system.unknowns), list(system.projective)
    angles = np.array([c.is_periodic for c in system.unknowns], dtype=bool)
    steps = np.diff(np.vstack([z[:, :affine], z[:1, :affine]]), axis=0)
    steps -= np.where(angles, 2 * np.pi * np.round(steps.real / (2 * np.pi)), 0.0)
    winding = np.where(angles, np.round(steps.sum(axis=0).real / (2 * np.pi)), 0.0)
    z[1:, :affine] = z[0, :affine] + np.cumsum(steps[:-1], axis=0)
    if ray:
        z[:, ray] /= np.linalg.norm(z[:, ray], axis=1, keepdims=True)
        main = np.linalg.svd(z[:, ray], full_matrices=False)[2][0]
        z[:, ray] /= (z[:, ray] @ np.conj(main))[:, None]
    point = z.mean(axis=0)
    if ray:
        point[ray] /= np.linalg.norm(point[ray])
    negative = np.abs(np.fft.fft(z, axis=0)[: len(z) // 2 : -1]) / len(z)
    largest = negative.max(axis=0)
    vanishing = _vanishes_inside(np.exp(1j * np.sign(winding) * (z[:, :affine] - point[:affine])))
    leaving = np.where(angles, (winding != 0) & vanishing, _is_pole(negative[:, :affine]))
    return Germ(
        len(members),
        point,
        np.append(largest[:affine], largest[ray].max(initial=0.0)),
        leaving,
        not winding.any(),
    )


def _vanishes_inside(u: np.ndarray) -> np.ndarray:
    """Whether functions with samples u (n, any) are zero at t = 0."""
    return np.abs(u.mean(axis=0)) < _NOTHING * np.abs(u).max(axis=0)


def _is_pole(negative: np.ndarray) -> np.ndarray:
    """Whether coefficients (powers, any) of the powers -1, -2, ... belong to a pole at t = 0:
    beyond its order there are none, as there would be of a pole at another place within the circle.
    """
    largest = negative.max(axis=0)
    return (
        (largest > _POLE)
        & (negative[-1] < _NOTHING * largest)
        & (negative[-2] < _NOTHING * largest)
    )
