"""Path tracking for closures made of quadratics: Taylor series of high order from one factorisation
a step.

Along a line of known values the rows are F(x, s) = x^T A(s) x, A = B + sum_q u_q(s) V_q (see
`quadratic_form`). With x(s + t) = sum_p x_p t^p and u(s + t) = sum_c u_c t^c the coefficient of
t^p,

    J x_p = - sum_{0<a<p} B(x_a, x_{p-a}) - sum_c u_c sum_{a+b=p-c} V(x_a, x_b),    J = 2 A(s) x_0,

where the last sum leaves out x_p itself at c = 0, gives x_p from the lower ones and the inverse of
J. The series is summed over a denominator q(t) common to all unknowns, which reaches beyond the
nearest branch points (a simultaneous Pade approximant). A Newton step and a chord step with its
matrix correct it; their ratio is the test that the point is well within the region from which
Newton converges. A projective point moves within the hyperplane conj(x_0).x = 1, a row of J, and is
normalised after each step. All paths advance at once, by stacked matrix products.
"""

from __future__ import annotations

import numpy as np

from symkin.homotopy import tracker
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.quadratic_form import Line, QuadraticForm, line_of, quadratic_form
from symkin.homotopy.tracker import Tracked, TrackSettings
from symkin.numeric.tolerances import ROOT_POLISHED, ROWS_CONTRADICT

__all__ = ["quadratic_form", "track"]

_ORDER = 8
"""Terms of a series after its value."""
_POLES = 3
"""Degree of the common denominator."""
_AIM = 0.1
"""First correction that a step aims at, over the tolerance."""
_CONTRACTION = 0.1
"""Largest ratio of the chord step to the Newton step."""
_ROUNDING = 1e-3
"""Chord step, over the tolerance, that is small enough whatever the ratio: ill-conditioned roots
end in rounding.
"""
_SETTLED = 1e-8
"""Newton step at the end after which no other is taken."""
_RIDGE = 1e-12
"""Relative weight by which the equations for the denominator are kept regular."""


def track(
    system: AlgebraicSystem,
    form: QuadraticForm,
    z: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    settings: TrackSettings | None = None,
) -> Tracked:
    """Track roots z (width, n) of F(., begin) to roots of F(., end), with the meaning of
    `tracker.track`, which is called where the paths have lines of their own or the coefficients
    cannot be interpolated along the line.

    `settings.first_step` is not used: the series gives the first step.
    """
    settings = settings or TrackSettings()
    ends = _common(begin), _common(end)
    line = None if ends[0] is None or ends[1] is None else line_of(form, ends[0], ends[1], _ORDER)
    if line is None:
        return tracker.track(system, z, begin, end, settings)
    start = np.ones((z.shape[1], form.width), dtype=complex)
    start[:, : form.unknowns] = system.normalise(z.astype(complex)).T
    with np.errstate(all="ignore"):
        return _track(line, start, settings)


def _common(k: np.ndarray) -> np.ndarray | None:
    """The known values (known,) of all paths, None where each has its own."""
    if k.ndim == 1:
        return k
    return np.asarray(k[:, 0]) if k.shape[1] and np.all(k == k[:, :1]) else None


def _track(line: Line, x: np.ndarray, settings: TrackSettings) -> Tracked:
    """`reach` is what each path's steps have been found to be worth, over the estimate from the
    last term.
    """
    n, form, aim = len(x), line.form, _AIM * settings.tolerance
    ends, reached, tries = x.copy(), np.zeros(n), np.zeros(n, dtype=int)
    active, s, reach, rounds = np.arange(n), np.zeros(n), np.full(n, 1.5), 0
    while active.size and rounds < settings.most_steps:
        rounds += 1
        tries[active] = rounds
        terms = _series(line, x, s)
        h = np.minimum(reach * _trusted(terms, aim), 1.0 - s)
        landing = np.where(h >= 1.0 - s, 1.0, s + h)
        trial, first, last = _correct(line, _sum(terms, h), landing)
        good = (first <= settings.tolerance) & (
            last <= np.maximum(_CONTRACTION * first, _ROUNDING * settings.tolerance)
        )
        factor = np.nan_to_num(
            0.9 * (aim / np.maximum(first, 1e-16)) ** (1.0 / (_ORDER + 1)), nan=0.25
        )
        reach *= np.where(good, np.clip(factor, 0.5, 1.5), np.clip(factor, 0.1, 0.5))
        x, s = np.where(good[:, None], _unit(form, trial), x), np.where(good, landing, s)
        leave = (s >= 1.0) | ~(h >= settings.smallest_step)
        if leave.any():
            ends[active[leave]], reached[active[leave]] = x[leave], s[leave]
            x, s, reach, active = x[~leave], s[~leave], reach[~leave], active[~leave]
    ends[active], reached[active] = x, s
    return _arrive(line, ends, reached, tries)


def _arrive(line: Line, x: np.ndarray, s: np.ndarray, tries: np.ndarray) -> Tracked:
    """Newton at the end; a point that it does not settle has not arrived."""
    form, arrived = line.form, s >= 1.0
    there = np.flatnonzero(arrived)
    if there.size:
        at = np.ones(there.size)
        for _ in range(3):
            moved, first, last = _correct(line, x[there], at)
            x[there] = _unit(form, moved)
            if np.all(first <= _SETTLED):
                break
        left = np.max(
            np.abs(_rows(line, line.apply(x[there]), x[there], line.weights(at)[:, :, 0])),
            axis=(1, 2),
        )
        arrived[there] = (last <= ROOT_POLISHED) & (left <= ROWS_CONTRADICT)
    return Tracked(x[:, : form.unknowns].T, arrived, s, tries)


# --- series ---------------------------------------------------------------------------------------


def _series(line: Line, x: np.ndarray, s: np.ndarray) -> np.ndarray:
    """x_p at [:, _ORDER - p] of an array (n, _ORDER + 1, width).

    `images` are 2 B x_a and 2 V x_a. `known` holds, from right to left, V(x, x) of order 0, 1, ...,
    and before them, for the moment, the sum of B(x_a, x_{p-a}): its product with -J^-1 (1, u_0,
    u_1, ...) is x_p.
    """
    n, form = len(x), line.form
    rows, moving, width, free = form.rows, line.moving, form.width, form.unknowns
    u, first = line.weights(s), line.apply(x)
    inverse = -_inverse(_jacobian(form, x, first, u[:, :, 0]))[:, :, :rows]
    answer = np.concatenate([inverse, inverse @ u.reshape(n, rows, -1)], axis=2)
    slope = first[:, rows:, :free]
    terms = np.zeros((n, _ORDER + 1, width), dtype=complex)
    images = np.empty((n, rows + moving, _ORDER // 2, width), dtype=complex)
    known = np.zeros((n, rows + (_ORDER + 1 + line.terms) * moving), dtype=complex)
    here = rows + _ORDER * moving
    terms[:, _ORDER] = x
    known[:, here : here + moving] = 0.5 * (first[:, rows:] @ x[:, :, None])[:, :, 0]
    for p in range(1, _ORDER + 1):
        here -= moving
        half = p // 2
        if half:
            if p % 2 == 0:
                images[:, :, half - 1] = line.apply(terms[:, _ORDER - half])
            known[:, here - rows : here + moving] = _pairs(images, terms, p)
        xp = answer @ known[:, here - rows : here + (line.terms + 1) * moving, None]
        terms[:, _ORDER - p, :free] = xp[:, :, 0]
        if p < _ORDER:
            known[:, here : here + moving] += (slope @ xp)[:, :, 0]
    return terms


def _pairs(images: np.ndarray, terms: np.ndarray, p: int) -> np.ndarray:
    """sum_{0<a<p} of B(x_a, x_{p-a}) and V(x_a, x_{p-a}): each pair once and doubled, the middle
    one simply.
    """
    n, rows, _, width = images.shape
    half = p // 2
    others = terms[:, _ORDER - p + 1 : _ORDER - p + 1 + half].reshape(n, half * width, 1)
    if p % 2 == 0:
        others = others.copy()
        others[:, -width:] *= 0.5
    return np.asarray((images.reshape(n, rows, -1)[:, :, : half * width] @ others)[:, :, 0])


def _trusted(terms: np.ndarray, aim: float) -> np.ndarray:
    """Step at which the last term of the series is as small as `aim`, relative to max(1, |x|)."""
    size = np.maximum(1.0, np.max(np.abs(terms[:, _ORDER]), axis=1))
    return np.asarray((aim * size / np.max(np.abs(terms[:, 0]), axis=1)) ** (1.0 / _ORDER))


def _sum(terms: np.ndarray, h: np.ndarray) -> np.ndarray:
    """The series at h over its common denominator q(t) = 1 + q_1 t + ..., which makes the last term
    of q x, of order p = _ORDER, the least: |sum_j q_j x_{p-j}|. Then x = sum_p x_p h^p
    Q_{min(_POLES, _ORDER - p)} / Q_{_POLES}, where Q_m are the partial sums of q(h).
    """
    powers = np.ones((len(h), _ORDER + 1))
    np.cumprod(np.repeat(h[:, None], _ORDER, axis=1), axis=1, out=powers[:, _ORDER - 1 :: -1])
    last = terms[:, : _POLES + 1] * powers[:, : _POLES + 1, None]
    gram = last.conj() @ last.transpose(0, 2, 1)
    diagonal = np.arange(1, _POLES + 1)
    gram[:, diagonal, diagonal] = (1.0 + _RIDGE) * gram[:, diagonal, diagonal] + 1e-300
    partial = 1.0 - np.cumsum((_inverse(gram[:, 1:, 1:]) @ gram[:, 1:, :1])[:, :, 0], axis=1)
    weights = powers.astype(complex)
    weights[:, 0] /= partial[:, -1]
    weights[:, 1:_POLES] *= partial[:, :-1] / partial[:, -1:]
    return np.asarray((weights[:, None] @ terms)[:, 0])


# --- corrector ------------------------------------------------------------------------------------


def _correct(line: Line, x: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One Newton step and one with the same matrix, and their sizes relative to max(1, |x|)."""
    form, u, images = line.form, line.weights(s)[:, :, 0], line.apply(x)
    inverse = _inverse(_jacobian(form, x, images, u))[:, :, : form.rows]
    newton = (inverse @ _rows(line, images, x, u))[:, :, 0]
    x = x.copy()
    x[:, : form.unknowns] -= newton
    chord = (inverse @ _rows(line, line.apply(x), x, u))[:, :, 0]
    x[:, : form.unknowns] -= chord
    scale = np.maximum(1.0, np.max(np.abs(x), axis=1))
    return x, np.max(np.abs(newton), axis=1) / scale, np.max(np.abs(chord), axis=1) / scale


def _rows(line: Line, images: np.ndarray, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """F (n, rows, 1) from the images 2 B x, 2 V x and the weights u (n, rows, moving)."""
    values = images @ (0.5 * x[:, :, None])
    return np.asarray(values[:, : line.form.rows] + u @ values[:, line.form.rows :])


def _jacobian(form: QuadraticForm, x: np.ndarray, images: np.ndarray, u: np.ndarray) -> np.ndarray:
    """2 A x (n, rows, unknowns), and the row that keeps a step orthogonal to the ray."""
    part = images[:, :, : form.unknowns]
    j = part[:, : form.rows] + u @ part[:, form.rows :]
    if form.ray.stop == 0:
        return np.asarray(j)
    row = np.zeros((len(x), 1, form.unknowns), dtype=complex)
    row[:, 0, form.ray] = x[:, form.ray].conj()
    return np.concatenate([j, row], axis=1)


def _inverse(j: np.ndarray) -> np.ndarray:
    """Inverses (n, columns, rows), or least-squares ones where rows are redundant; not a number
    where there is none.
    """
    try:
        if j.shape[1] == j.shape[2]:
            return np.asarray(np.linalg.inv(j))
        q, r = np.linalg.qr(j)
        return np.asarray(np.linalg.inv(r) @ q.conj().transpose(0, 2, 1))
    except np.linalg.LinAlgError:
        if len(j) == 1:
            return np.full((1, j.shape[2], j.shape[1]), np.nan, dtype=complex)
        return np.concatenate([_inverse(one[None]) for one in j])


def _unit(form: QuadraticForm, x: np.ndarray) -> np.ndarray:
    """The points with their rays of unit length."""
    ray = x[:, form.ray]
    length = np.sqrt((ray.real**2 + ray.imag**2).sum(axis=1))[:, None]
    if ray.shape[1] == form.width:
        return np.asarray(x / length)
    x = x.copy()
    x[:, form.ray] /= length
    return x
