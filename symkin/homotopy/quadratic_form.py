"""Closures whose rows are at most quadratic in the unknowns, in the form that series are made from.

With x = z, or (z, 1) where the rows are not homogeneous, row i is x^T A_i(k) x. Only some entries
of A depend on the known values k, often in the same way: A_i(k) = B_i + sum_q u_iq(k) V_q with
constant symmetric matrices B_i and V_q. Along a straight line k(s) the weights u are polynomials in
s, or entire functions that a polynomial meets to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.polynomial import chebyshev

from symkin.closure.numpy_code import vectorise
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem

_DEGREES = (1, 2, 4, 8, 16, 32, 64)
"""Degrees that are tried for the weights along a line."""
_POLYNOMIAL = 8
"""Largest degree along a random line of length 3 that is taken for the weights' own, along every
line.
"""
_MET = 1e-12
"""Largest error of interpolated weights over the largest weight."""
_BETWEEN = 0.4321
"""A place in [0, 1] that is no node, where the interpolation is checked."""
_ALIKE = 1e-15
"""Difference over the largest weight below which weights move alike."""


@dataclass(frozen=True, eq=False)
class QuadraticForm:
    """`matrices` (rows + q, width, width) are B of each row, then V; `weights` fills u (n, rows, q)
    from k (known, n).

    `unknowns` is the length of z; `width` is that, or one more for the constant 1; `ray` are the
    places of the projective unknowns, none where it is empty. `degree` is that of the weights along
    every line, None where they are no polynomials.
    """

    rows: int
    unknowns: int
    ray: slice
    matrices: np.ndarray
    weights: Callable[..., None]
    degree: int | None

    @property
    def width(self) -> int:
        return int(self.matrices.shape[1])

    @property
    def moving(self) -> int:
        return len(self.matrices) - self.rows

    def at(self, k: np.ndarray) -> np.ndarray:
        """u (n, rows, q) at known values k (known, n)."""
        u = np.zeros((k.shape[1], self.rows, self.moving), dtype=complex)
        self.weights(k, u)
        return u


@dataclass(frozen=True, eq=False)
class Line:
    """A quadratic form along k(s) = begin + s (end - begin), 0 <= s <= 1.

    `products` (width, (rows + q) width) takes points (n, width) to 2 B x and 2 V x; `taylor`
    (degree + 1, ...) takes the Chebyshev polynomials in 2 s - 1 to the Taylor coefficients of the
    `moving` weights u at s, `terms` of them after the value.
    """

    form: QuadraticForm
    products: np.ndarray
    taylor: np.ndarray
    terms: int
    moving: int

    def weights(self, s: np.ndarray) -> np.ndarray:
        """Taylor coefficients (n, rows, terms + 1, q) of u at s (n,)."""
        basis = np.empty((len(self.taylor), len(s)))
        basis[0], basis[1] = 1.0, 2.0 * s - 1.0
        for i in range(2, len(basis)):
            basis[i] = 2.0 * basis[1] * basis[i - 1] - basis[i - 2]
        return np.asarray(
            (basis.T @ self.taylor).reshape(len(s), self.form.rows, self.terms + 1, self.moving)
        )

    def apply(self, x: np.ndarray) -> np.ndarray:
        """2 B x of each row, then 2 V x: (n, rows + q, width)."""
        return np.asarray((x @ self.products).reshape(len(x), -1, self.form.width))


# --- a system as a form ---------------------------------------------------------------------------


@lru_cache(maxsize=64)
def quadratic_form(system: AlgebraicSystem) -> QuadraticForm | None:
    """The form of a system. None where a row is of higher degree in z, where the rows are fewer
    than the unknowns, or where the coefficients cannot be interpolated along a line.
    """
    slope = ca.jacobian(system.rows, system.z)
    if any(ca.which_depends(ca.vec(slope), system.z, 2, False)):
        return None
    if system.count + bool(system.projective) < system.width:
        return None
    coefficients, pairs = _coefficients(system, slope)
    moving = (
        np.array(ca.which_depends(ca.densify(ca.vec(coefficients)), system.k, 1, True))
        .reshape(len(pairs), -1)
        .any(axis=1)
    )
    samples = _samples(system, coefficients)
    places = np.flatnonzero(moving)
    if not places.size:
        return None
    _, chosen, kind = np.unique(
        np.vstack(samples)[:, places], axis=1, return_index=True, return_inverse=True
    )
    matrices = np.zeros(
        (system.count + len(chosen), pairs[-1][1] + 1, pairs[-1][1] + 1), dtype=complex
    )
    for (a, b), value in zip(pairs, np.where(moving, 0.0, samples[0]).T, strict=True):
        matrices[: system.count, a, b] += 0.5 * value
        matrices[: system.count, b, a] += 0.5 * value
    for p, q in zip(places, kind.ravel(), strict=True):
        a, b = pairs[p]
        matrices[system.count + q, a, b] += 0.5
        matrices[system.count + q, b, a] += 0.5
    try:
        weights = vectorise(
            ca.Function("u", [system.k], [coefficients[:, places[chosen].tolist()]], {"cse": True})
        )
    except NotImplementedError:
        return None
    ray = slice(min(system.projective, default=0), max(system.projective, default=-1) + 1)
    form = QuadraticForm(system.count, system.width, ray, matrices, weights, None)
    return _with_degree(form, int(system.k.shape[0]))


def _coefficients(system: AlgebraicSystem, slope: ca.SX) -> tuple[ca.SX, list[tuple[int, int]]]:
    """Coefficients (rows, monomials) of x_a x_b, a <= b, as expressions of k, and the pairs (a,
    b).
    """
    n, rows, zero = system.width, system.count, ca.DM.zeros(system.width)
    curvature = ca.substitute(ca.jacobian(ca.vec(slope), system.z), system.z, zero)
    pairs = [(a, b) for a in range(n) for b in range(a, n)]
    columns = [curvature[a * rows : (a + 1) * rows, b] * (0.5 if a == b else 1.0) for a, b in pairs]
    lower = ca.horzcat(
        ca.substitute(slope, system.z, zero), ca.substitute(system.rows, system.z, zero)
    )
    if ca.sparsify(lower).nnz():
        columns += ca.horzsplit(lower)
        pairs += [(a, n) for a in range(n + 1)]
    return ca.sparsify(ca.horzcat(*columns)), pairs


def _samples(system: AlgebraicSystem, coefficients: ca.SX) -> list[np.ndarray]:
    """The coefficients at three random points: columns equal at all of them are equal."""
    rng = np.random.default_rng(0)
    function = ca.Function("c", [system.k], [ca.densify(coefficients)])
    return [np.asarray(function(rng.uniform(0.5, 1.5, int(system.k.shape[0])))) for _ in range(3)]


# --- a form along a line --------------------------------------------------------------------------


def line_of(form: QuadraticForm, begin: np.ndarray, end: np.ndarray, order: int) -> Line | None:
    """The form along a line, with Taylor coefficients up to `order`; None where the weights cannot
    be interpolated.

    What the weights are at the beginning goes into B, so that those which do not move along this
    line drop out, and those which move alike are one.
    """
    for degree in _DEGREES if form.degree is None else (form.degree,):
        s = np.append(_nodes(degree), _BETWEEN)
        u = form.at(begin[:, None] + s * (end - begin).astype(complex)[:, None])
        moved = u - u[0]
        error = moved[-1] - np.tensordot(_between(degree), moved[:-1], 1)
        scale = np.max(np.abs(u), initial=0.0)
        if np.max(np.abs(error), initial=0.0) <= _MET * scale:
            break
    else:
        return None
    kinds = _kinds(moved.reshape(-1, form.moving), _ALIKE * scale)
    constant = form.matrices[: form.rows] + np.tensordot(u[0], form.matrices[form.rows :], 1)
    alike = np.array([form.matrices[form.rows + np.array(kind)].sum(axis=0) for kind in kinds])
    matrices = np.concatenate([constant, alike.reshape(-1, form.width, form.width)])
    products = np.ascontiguousarray(2.0 * matrices.transpose(1, 0, 2)).reshape(form.width, -1)
    terms = min(degree, order)
    taylor = np.tensordot(
        _derivatives(degree, terms), moved[:-1][:, :, [kind[0] for kind in kinds]], 1
    )
    return Line(
        form,
        products,
        np.ascontiguousarray(taylor.transpose(1, 2, 0, 3)).reshape(degree + 1, -1),
        terms,
        len(kinds),
    )


def _kinds(moved: np.ndarray, tolerance: float) -> list[list[int]]:
    """Columns that move, those that do so alike together."""
    kinds: list[list[int]] = []
    for q in np.flatnonzero(np.max(np.abs(moved), axis=0, initial=0.0) > tolerance):
        same = next(
            (k for k in kinds if np.max(np.abs(moved[:, k[0]] - moved[:, q])) <= tolerance), None
        )
        if same is None:
            kinds.append([int(q)])
        else:
            same.append(int(q))
    return kinds


def _with_degree(form: QuadraticForm, known: int) -> QuadraticForm | None:
    gauss = np.random.default_rng(1).normal(size=(4, known))
    line = line_of(form, gauss[0] + 1j * gauss[1], gauss[2] + 1j * gauss[3], 0)
    if line is None:
        return None
    degree = len(line.taylor) - 1
    return replace(form, degree=degree) if degree <= _POLYNOMIAL else form


def _nodes(degree: int) -> np.ndarray:
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.arange(degree + 1) / degree))


@lru_cache(maxsize=16)
def _inverse_basis(degree: int) -> np.ndarray:
    """From values at the nodes to coefficients in T_j(2 s - 1)."""
    return np.asarray(np.linalg.inv(chebyshev.chebvander(2.0 * _nodes(degree) - 1.0, degree)))


@lru_cache(maxsize=16)
def _between(degree: int) -> np.ndarray:
    """From values at the nodes to the one at `_BETWEEN`."""
    return np.asarray(
        chebyshev.chebvander(2.0 * _BETWEEN - 1.0, degree)[0] @ _inverse_basis(degree)
    )


@lru_cache(maxsize=16)
def _derivatives(degree: int, terms: int) -> np.ndarray:
    """Maps (terms + 1, degree + 1, degree + 1) from values of f at the nodes to the Chebyshev
    coefficients of its p-th derivative in s over p!, p = 0, 1, ..., terms.
    """
    now = _inverse_basis(degree)
    maps = [now]
    for p in range(1, terms + 1):
        now = chebyshev.chebder(now, axis=0) * 2.0 / p
        maps.append(np.vstack([now, np.zeros((degree + 1 - len(now), degree + 1))]))
    return np.array(maps)
