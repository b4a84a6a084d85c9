"""Path tracking: roots of F(z, k(s)) = 0 while the known values k move along a straight complex line.

All paths advance at once, each with its own s and step. A step is a Runge-Kutta predictor of fourth order on
dz/ds = -(dF/dz)^+ (dF/dk) dk/ds, then Newton corrections; all rows are used, by QR. A projective point moves within
the hyperplane conj(x).dx = 0 and is normalised after each step, so that it needs no fixed chart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.enumeration.algebraic import AlgebraicSystem


@dataclass(frozen=True)
class TrackSettings:
    """`tolerance`: largest first correction of a step (relative to 1, the scale of z); `smallest_step`: where a path
    is given up; `most_steps`: bound on the steps of all paths together."""

    tolerance: float = 1e-4
    first_step: float = 0.05
    smallest_step: float = 1e-7
    most_steps: int = 2000
    corrections: int = 3


@dataclass(frozen=True, eq=False)
class Tracked:
    """End points z (width, n), and for each path whether it reached s = 1; `s` is how far it came."""

    z: np.ndarray
    arrived: np.ndarray
    s: np.ndarray
    steps: int


def track(
    system: AlgebraicSystem, z: np.ndarray, begin: np.ndarray, end: np.ndarray, settings: TrackSettings | None = None
) -> Tracked:
    """Track roots z (width, n) of F(., begin) to roots of F(., end)."""
    settings = settings or TrackSettings()
    z, n = system.normalise(z.astype(complex)), z.shape[1]
    s, h = np.zeros(n), np.full(n, settings.first_step)
    direction = (end - begin).astype(complex)
    active = np.arange(n)
    steps = 0
    while active.size and steps < settings.most_steps:
        steps += 1
        step = np.minimum(h[active], 1.0 - s[active])
        predicted = _predict(system, z[:, active], s[active], step, begin, direction)
        s_new = np.where(h[active] >= 1.0 - s[active], 1.0, s[active] + step)
        k_new = begin[:, None] + s_new * direction[:, None]
        trial, first, last = _correct(system, predicted, k_new, settings.corrections)
        good = np.isfinite(first) & (first <= settings.tolerance) & (last <= 1e-9)
        accepted = active[good]
        z[:, accepted], s[accepted] = trial[:, good], s_new[good]
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            factor = 0.8 * (0.5 * settings.tolerance / np.maximum(first, 1e-16)) ** 0.2
        factor = np.where(np.isfinite(factor), factor, 0.25)
        h[active] = step * np.where(good, np.clip(factor, 0.3, 3.0), np.clip(factor, 0.1, 0.5))
        if system.projective:
            p = np.array(system.projective)[:, None]
            z[p, accepted] = z[p, accepted] / np.linalg.norm(z[p, accepted], axis=0)
        active = active[(s[active] < 1.0) & (h[active] > settings.smallest_step)]
    return Tracked(z, s >= 1.0, s, steps)


def newton(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, iterations: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Newton at fixed k; returns points and the size of the last step."""
    known = np.repeat(k[:, None], z.shape[1], axis=1)
    z, _, last = _correct(system, z, known, iterations)
    return system.normalise(z), last


def _predict(
    system: AlgebraicSystem, z: np.ndarray, s: np.ndarray, h: np.ndarray, begin: np.ndarray, direction: np.ndarray
) -> np.ndarray:
    patch = _patch(system, z)

    def slope(at: np.ndarray, where: np.ndarray) -> np.ndarray:
        _, j, t = system.evaluate(at, begin[:, None] + where * direction[:, None], direction)
        return -solve_rows(_with_patch(j, patch), t)

    with np.errstate(all="ignore"):
        k1 = slope(z, s)
        k2 = slope(z + 0.5 * h * k1, s + 0.5 * h)
        k3 = slope(z + 0.5 * h * k2, s + 0.5 * h)
        k4 = slope(z + h * k3, s + h)
        return np.asarray(z + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))


def _correct(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, corrections: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Newton steps; sizes of the first and the last one, relative to the larger of 1 and |z|. The last one is infinite
    where rows stay that no unknowns can satisfy."""
    first = last = left = np.zeros(z.shape[1])
    with np.errstate(all="ignore"):
        for i in range(corrections):
            f, j = system.linearise(z, k)
            dz = -solve_rows(_with_patch(j, _patch(system, z)), f)
            z = z + dz
            last = np.max(np.abs(dz), axis=0) / np.maximum(1.0, np.max(np.abs(z), axis=0))
            left = np.max(np.abs(f), axis=1)
            first = last if i == 0 else first
            if np.all((last < 1e-13) | ~np.isfinite(last)):
                break
    return z, first, np.where(np.isfinite(last) & (left < 1e-6), last, np.inf)


def _patch(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray | None:
    """Row (n, width) that keeps a correction orthogonal to the ray."""
    if not system.projective:
        return None
    p = list(system.projective)
    row = np.zeros((z.shape[1], system.width), dtype=complex)
    row[:, p] = np.conj(z[p]).T
    return row


def _with_patch(jacobian: np.ndarray, patch: np.ndarray | None) -> np.ndarray:
    return jacobian if patch is None else np.concatenate([jacobian, patch[:, None]], axis=1)


def solve_rows(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Least-squares solutions (width, n) of a x = (b; 0) for stacks a (n, rows, width), b (n, fewer rows)."""
    n, m, w = a.shape
    right = np.zeros((n, m, 1), dtype=complex)
    right[:, : b.shape[1], 0] = b
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
        return np.asarray(np.linalg.solve(a, right)[:, :, 0].T)
    except np.linalg.LinAlgError:
        return np.asarray((np.linalg.pinv(a) @ right)[:, :, 0].T)
