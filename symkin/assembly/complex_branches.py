"""Branches of a closed form over the complex numbers: whether all of them are solutions, and
whether there are other solutions.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from symkin.closure.numpy_code import vectorise
from symkin.computed_once import lru_cache
from symkin.elimination.closed_form import ClosedForm
from symkin.homotopy.algebraic import complex_normal, known_root
from symkin.homotopy.engine import newton
from symkin.homotopy.systems import system_of
from symkin.homotopy.values import algebraic_points, known_values
from symkin.position.problem import Problem

_STARTS, _STEPS = 256, 40
"""Random complex starts of Newton's method, and its steps."""
_FEWEST = 40
"""Starts that must end at solutions. Of four solutions that are met alike so many miss a certain
one with a probability of 10^-5.
"""
_CONVERGED = 1e-9
"""Last step to a solution: angles, lengths in sizes."""
_FARTHEST = 12.0
"""Imaginary part of an angle beyond which no end is held for a solution: rows of cosines of 1e5
keep no digits, and their steps may end anywhere.
"""


def complex_errors(problem: Problem, form: ClosedForm, known: np.ndarray) -> np.ndarray:
    """By how much all branches, complex ones included, leave the rows of a problem open for known
    values (n, known): (n, count), in sizes. Raises NotImplementedError for rows that have no
    complex form.
    """
    with np.errstate(all="ignore"):
        z, k, off = _branches(problem, form, known)
        rows = system_of(problem).linearise(z, k)[0]
        # rows are of second degree
        reach = np.maximum(1.0, np.max(np.abs(np.exp(1j * z)) + np.abs(z), axis=0))
        found = np.maximum(np.max(np.abs(rows), axis=1), off) / reach**2
    return np.where(np.isfinite(found), found, np.inf).reshape(len(known), form.count)


def complex_ends(problem: Problem, form: ClosedForm, known: np.ndarray) -> np.ndarray:
    """The branches of a closed form as complex roots (width, n count) of a problem's algebraic
    system for known values (n, known), far ones by more bits. Raises NotImplementedError as above.
    """
    from symkin.homotopy.far_roots import are_far, settled

    system = system_of(problem)
    with np.errstate(all="ignore"):
        z, k, _ = _branches(problem, form, known)
    for place in are_far(system, z).nonzero()[0].tolist():
        z[:, [place]] = settled(system, z[:, [place]], k[:, place])[1]
    return z


def misses_none(problem: Problem, form: ClosedForm, known: np.ndarray) -> bool:
    """Whether all solutions at which Newton's method ends from random complex starts are branches
    for known values (known,), and are enough to tell.
    """
    system, rng = system_of(problem), np.random.default_rng(7)
    with np.errstate(all="ignore"):
        branches, k, _ = _branches(problem, form, known[None])
        z = complex_normal(system.width * _STARTS, rng).reshape(system.width, _STARTS)
        turns = [i for i, c in enumerate(system.unknowns) if c.is_periodic]
        z[turns] += rng.uniform(-np.pi, np.pi, (len(turns), _STARTS))
        ends, last = newton(system, z, k[:, 0], _STEPS)
        near = np.max(np.abs(ends[turns].imag), axis=0, initial=0.0) <= _FARTHEST
        ends = ends[:, near & (last <= _CONVERGED)]
        return ends.shape[1] >= _FEWEST and bool((known_root(system, branches, ends) >= 0).all())


def _branches(
    problem: Problem, form: ClosedForm, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points z (width, branches) and known values (known, branches) of a problem's algebraic system
    for all branches at known values (n, known), and by how much the squares of their cosines and
    sines miss 1.
    """
    every = np.repeat(known, form.count, axis=0)
    inputs = np.tile(form.choices, (len(known), 1)), every
    found = np.zeros((len(every), 2 * form.system.width, 1), dtype=complex)
    _over_complex(form)(*(v.T.astype(complex) for v in inputs), found)
    first, second = found[:, :, 0].T.reshape(2, form.system.width, -1)
    angular = np.array([c.is_angular for c in form.system.unknowns])[:, None]
    # of exp(i z) and exp(-i z) the larger one is no small difference
    turns = first + 1j * second, first - 1j * second
    larger = np.where(
        np.abs(turns[0]) < np.abs(turns[1]), 1j * np.log(turns[1]), -1j * np.log(turns[0])
    )
    points = np.where(angular, larger, first)
    z = algebraic_points(problem, system_of(problem), form.system, points.T)
    off = np.max(np.abs(np.where(angular, first**2 + second**2 - 1.0, 0.0)), axis=0)
    return z, known_values(problem, every.T).astype(complex), off


@lru_cache(maxsize=64)
def _over_complex(form: ClosedForm) -> Callable[..., None]:
    """Writes cosines and sines, lengths and zeros of signs' and known values' branches."""
    values = ca.densify(form.at_roots(ca.vertcat(form.first, form.second), ca.sqrt))
    code = ca.Function("complex", [form.signs, form.system.known], [values], {"cse": True})
    return vectorise(code)
