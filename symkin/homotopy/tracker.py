"""Path tracking: roots of F(z, k(s)) = 0 while the known values k move along a straight complex
line.

All paths advance at once, each with its own s and step. The predictor extrapolates the polynomial
of fifth degree through the last three points and their tangents dz/ds = -(dF/dz)^+ (dF/dk) dk/ds
(confluent divided differences; the first step is one of Runge and Kutta); two Newton corrections
follow, whose second matrix gives the next tangent. All rows are used, by QR. A projective point
moves within the hyperplane conj(x).dx = 0 and is normalised after each step, so that it needs no
fixed chart; earlier points are carried into the chart of the last one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.tolerances import ROOT_POLISHED, ROWS_CONTRADICT

_POINTS = 3
"""Points and tangents that the predictor keeps."""


@dataclass(frozen=True)
class TrackSettings:
    """`tolerance`: largest first correction of a step (relative to 1, the scale of z);
    `smallest_step`: where a path is given up; `most_steps`: bound on the steps of all paths
    together.
    """

    tolerance: float = 1e-3
    first_step: float = 0.05
    smallest_step: float = 1e-9
    most_steps: int = 2000


@dataclass(frozen=True, eq=False)
class Tracked:
    """End points z (width, n), and for each path whether it reached s = 1; `s` is how far it came,
    `tries` the steps that were tried on it.
    """

    z: np.ndarray
    arrived: np.ndarray
    s: np.ndarray
    tries: np.ndarray

    @property
    def steps(self) -> int:
        """Steps tried on the path that took most."""
        return int(np.max(self.tries, initial=0))

    def take(self, which: slice) -> Tracked:
        """Some of the paths."""
        return Tracked(self.z[:, which], self.arrived[which], self.s[which], self.tries[which])


@dataclass(frozen=True, eq=False)
class _Line:
    """k(s) = begin + s direction of each path, (known, n)."""

    begin: np.ndarray
    direction: np.ndarray

    def take(self, which: np.ndarray) -> _Line:
        return _Line(self.begin[:, which], self.direction[:, which])

    def at(self, s: np.ndarray | float) -> np.ndarray:
        return self.begin + s * self.direction


@dataclass(eq=False)
class LastPoints:
    """Last points z (points, width, n), tangents and places s (points, n) of each path, newest
    first; `count` are kept.
    """

    z: np.ndarray
    t: np.ndarray
    s: np.ndarray
    count: np.ndarray

    @staticmethod
    def begun(z: np.ndarray, t: np.ndarray) -> LastPoints:
        """Points (width, n) at s = 0 and tangents there."""
        points, tangents = (np.stack([part] * _POINTS).astype(complex) for part in (z, t))
        n = z.shape[1]
        return LastPoints(points, tangents, np.zeros((_POINTS, n)), np.ones(n, dtype=int))

    def take(self, which: np.ndarray) -> LastPoints:
        return LastPoints(
            self.z[:, :, which], self.t[:, :, which], self.s[:, which], self.count[which]
        )

    def push(self, which: np.ndarray, z: np.ndarray, t: np.ndarray, s: np.ndarray) -> None:
        for kept, new in ((self.z, z), (self.t, t), (self.s, s)):
            kept[1:, ..., which] = kept[:-1, ..., which]
            kept[0][..., which] = new
        self.count[which] = np.minimum(self.count[which] + 1, _POINTS)


def track(
    system: AlgebraicSystem,
    z: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    settings: TrackSettings | None = None,
) -> Tracked:
    """Track roots z (width, n) of F(., begin) to roots of F(., end); known values (known,), or
    (known, n) for each path its own.
    """
    first, last = _columns(begin, z.shape[1]), _columns(end, z.shape[1])
    with np.errstate(all="ignore"):
        return _track(
            system,
            system.normalise(z.astype(complex)),
            _Line(first, last - first),
            settings or TrackSettings(),
        )


def _columns(k: np.ndarray, n: int) -> np.ndarray:
    k = np.asarray(k, dtype=complex)
    return np.broadcast_to(k if k.ndim == 2 else k[:, None], (len(k), n))


def _track(system: AlgebraicSystem, z: np.ndarray, line: _Line, settings: TrackSettings) -> Tracked:
    n = z.shape[1]
    s, h, tries = np.zeros(n), np.full(n, settings.first_step), np.zeros(n, dtype=int)
    begin = system.unit_rays(z)
    paths = LastPoints.begun(begin, _slope(system, begin, line, s, begin))
    active = np.flatnonzero(np.isfinite(paths.t[0]).all(axis=0))
    steps = 0
    while active.size and steps < settings.most_steps:
        steps += 1
        tries[active] += 1
        step = np.minimum(h[active], 1.0 - s[active])
        s_new = np.where(h[active] >= 1.0 - s[active], 1.0, s[active] + step)
        now, ahead = paths.take(active), line.take(active)
        predicted = _predict(system, now, step, ahead)
        trial, tangent, first, last = _correct(system, predicted, ahead.at(s_new), ahead.direction)
        good = (first <= settings.tolerance) & (last <= 0.1 * settings.tolerance)
        z[:, active[good]], s[active[good]] = trial[:, good], s_new[good]
        paths.push(active[good], system.unit_rays(trial[:, good]), tangent[:, good], s_new[good])
        order = np.where(now.count == 1, 5.0, 2.0 * now.count)
        factor = 0.9 * (0.5 * settings.tolerance / np.maximum(first, 1e-16)) ** (1.0 / order)
        factor = np.where(np.isfinite(factor), factor, 0.25)
        h[active] = step * np.where(good, np.clip(factor, 0.3, 2.0), np.clip(factor, 0.1, 0.5))
        active = active[(s[active] < 1.0) & (h[active] > settings.smallest_step)]
    return _arrive(system, z, s, line.at(1.0), tries)


def _arrive(
    system: AlgebraicSystem, z: np.ndarray, s: np.ndarray, end: np.ndarray, tries: np.ndarray
) -> Tracked:
    """Newton at the end; a point that Newton does not settle has not arrived."""
    z, there = system.unit_rays(z), np.flatnonzero(s >= 1.0)
    arrived = s >= 1.0
    if there.size:
        z[:, there], last = newton(system, z[:, there], end[:, there], 4)
        arrived[there] = last <= ROOT_POLISHED
    return Tracked(z, arrived, s, tries)


def newton(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, iterations: int = 5
) -> tuple[np.ndarray, np.ndarray]:
    """Newton at fixed k, (known,) or (known, n); returns points and the size of the last step,
    infinite where rows stay that no unknowns can satisfy.
    """
    known = _columns(k, z.shape[1])
    last = np.zeros(z.shape[1])
    with np.errstate(all="ignore"):
        for _ in range(iterations):
            f, j = system.linearise(z, known)
            (dz,) = _newton_step(system, z, j, f)
            z, size = z + dz, _relative(dz, z)
            closes = np.isfinite(size) & (np.max(np.abs(f), axis=1) < ROWS_CONTRADICT)
            last = np.where(closes, size, np.inf)
            # far from a root rows stay and steps go on
            if not np.any((last >= 1e-13) & np.isfinite(size)):
                break
    return system.normalise(z), last


def _slope(
    system: AlgebraicSystem, z: np.ndarray, line: _Line, s: np.ndarray, chart: np.ndarray
) -> np.ndarray:
    """dz/ds at points z, across the rays of the points `chart`."""
    _, j, t = system.evaluate(z, line.at(s), line.direction)
    (slope,) = _newton_step(system, chart, j, t)
    return slope


def _predict(system: AlgebraicSystem, paths: LastPoints, h: np.ndarray, line: _Line) -> np.ndarray:
    predicted = extrapolated(system, paths, h)
    fresh = np.flatnonzero(paths.count == 1)
    if fresh.size:
        predicted[:, fresh] = _runge_kutta(system, paths.take(fresh), h[fresh], line.take(fresh))
    return predicted


def _runge_kutta(
    system: AlgebraicSystem, paths: LastPoints, h: np.ndarray, line: _Line
) -> np.ndarray:
    z, s = paths.z[0], paths.s[0]
    k1 = paths.t[0]
    k2 = _slope(system, z + 0.5 * h * k1, line, s + 0.5 * h, z)
    k3 = _slope(system, z + 0.5 * h * k2, line, s + 0.5 * h, z)
    k4 = _slope(system, z + h * k3, line, s + h, z)
    return z + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def extrapolated(system: AlgebraicSystem, paths: LastPoints, h: np.ndarray) -> np.ndarray:
    """Hermite's polynomial through (c, c, b, b, a, a), newest point c first, at h beyond c; fewer
    points, lower degree.
    """
    z, t = _in_newest_chart(system, paths.z, paths.t)
    two, three = paths.count >= 2, paths.count >= 3
    d1 = np.where(two, paths.s[1] - paths.s[0], 1.0)
    d2 = np.where(three, paths.s[2] - paths.s[0], 2.0)
    d21 = np.where(three, d2 - d1, 1.0)
    cb, ba = (z[1] - z[0]) / d1, (z[2] - z[1]) / d21
    ccb, cbb, bba, baa = (cb - t[0]) / d1, (t[1] - cb) / d1, (ba - t[1]) / d21, (t[2] - ba) / d21
    ccbb, cbba, bbaa = (cbb - ccb) / d1, (bba - cbb) / d2, (baa - bba) / d21
    ccbba, cbbaa = (cbba - ccbb) / d2, (bbaa - cbba) / d2
    high = np.where(three, ccbba + (h - d2) * (cbbaa - ccbba) / d2, 0.0)
    middle = np.where(two, ccb + (h - d1) * (ccbb + (h - d1) * high), 0.0)
    return z[0] + h * (t[0] + h * middle)


def _in_newest_chart(
    system: AlgebraicSystem, z: np.ndarray, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Points and tangents (any, width, n), newest first, with rays p scaled to conj(x).p = 1, x the
    newest ray: p / a, t / a - p b / a^2 for a = conj(x).p, b = conj(x).t.
    """
    if not system.projective:
        return z, t
    ray = slice(system.projective[0], system.projective[-1] + 1)
    z, t = z.copy(), t.copy()
    p, v = z[1:, ray], t[1:, ray]
    c = np.conj(z[0, ray])
    a, b = np.sum(c * p, axis=1, keepdims=True), np.sum(c * v, axis=1, keepdims=True)
    t[1:, ray] = v / a - p * (b / a**2)
    z[1:, ray] = p / a
    return z, t


def _correct(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, direction: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Two Newton steps; the point, its tangent, and the sizes of both steps relative to the larger
    of 1 and |z|. The second is infinite where rows stay that no unknowns can satisfy.
    """
    f, j = system.linearise(z, k)
    (dz,) = _newton_step(system, z, j, f)
    z, first = z + dz, _relative(dz, z)
    f, j, t = system.evaluate(z, k, direction)
    dz, tangent = _newton_step(system, z, j, f, t)
    last = np.where(np.max(np.abs(f), axis=1) < ROWS_CONTRADICT, _relative(dz, z), np.inf)
    z = z + dz
    if system.projective:
        ray = slice(system.projective[0], system.projective[-1] + 1)
        tangent[ray] /= np.linalg.norm(z[ray], axis=0)
    return (
        z,
        tangent,
        np.where(np.isfinite(first), first, np.inf),
        np.where(np.isfinite(last), last, np.inf),
    )


def _relative(dz: np.ndarray, z: np.ndarray) -> np.ndarray:
    return np.max(np.abs(dz), axis=0) / np.maximum(1.0, np.max(np.abs(z), axis=0))


def _newton_step(
    system: AlgebraicSystem, z: np.ndarray, j: np.ndarray, *right: np.ndarray
) -> list[np.ndarray]:
    """For each right hand side (n, rows) the steps (width, n), across the rays of points z."""
    beside = np.stack(right, axis=2)
    steps = -solve_rows(system.patched(z, j, right[0])[0], beside)
    return [steps[:, :, k] for k in range(len(right))]


def solve_rows(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Least-squares solutions (width, n, columns) of a x = (b; 0) for stacks a (n, rows, width), b
    (n, fewer rows, columns).
    """
    n, m, w = a.shape
    right = np.zeros((n, m, b.shape[2]), dtype=complex)
    right[:, : b.shape[1]] = b
    bad = ~(np.isfinite(a).all(axis=(1, 2)) & np.isfinite(right).all(axis=(1, 2)))
    if bad.any():
        a, right = a.copy(), right.copy()
        a[bad], right[bad] = np.eye(m, w), np.nan
    if m > w:
        q, r = np.linalg.qr(a)
        right, a = np.conj(q.transpose(0, 2, 1)) @ right, r
    diagonal = np.arange(w)
    tiny = np.abs(a[:, diagonal, diagonal]) == 0.0
    if m > w and tiny.any():
        a = a.copy()
        a[:, diagonal, diagonal] += np.where(tiny, 1e-300, 0.0)
    try:
        x = np.linalg.solve(a, right)
    except np.linalg.LinAlgError:
        x = np.linalg.pinv(a) @ right
    return x.transpose(1, 0, 2)
