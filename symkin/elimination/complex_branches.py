"""Branches of a closed form over the complex numbers: whether all of them are solutions, and
whether there are other solutions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np

from symkin.closure.numpy_code import vectorise
from symkin.computed_once import lru_cache
from symkin.elimination.closed_form import ClosedForm
from symkin.model.joint import units_of
from symkin.numeric.system import System

Evaluate = Callable[..., list[np.ndarray]]
_STARTS, _STEPS = 64, 40
"""Random complex starts of Newton's method, and its steps."""
_FEWEST = 40
"""Starts that must end at solutions. Of four solutions that are met alike so many miss a certain
one with a probability of 10^-5.
"""
_CONVERGED = 1e-9
"""Last step to a solution: angles, lengths in sizes."""
_CLOSED, _SAME = 1e-7, 1e-6
"""Closure error of a solution, beside its terms, and how far its branch may be from it: cosines and
sines, lengths in sizes.
"""
_DAMPING = 1e-14
"""Share of the squared derivatives that is added to them, so that every step is finite."""


def complex_errors(form: ClosedForm, known: np.ndarray) -> np.ndarray:
    """By how much all branches, complex ones included, leave the rows open for known values (n,
    known): (n, count), in sizes. Raises NotImplementedError for rows that have no complex form.
    """
    system, angular = form.system, _angular(form.system)
    with np.errstate(all="ignore"):
        first, second = parts = _branches(form, known)
        u = np.where(angular, -1j * np.log(first + 1j * second), first)
        (rows,) = _rows_over_complex(system)(u, np.repeat(known, form.count, axis=0))
        circles = np.where(angular, first**2 + second**2 - 1.0, 0.0).T
        found = np.max(np.abs(np.hstack([rows[:, :, 0], circles])), axis=1) / _reach(parts) ** 2
    return np.where(np.isfinite(found), found, np.inf).reshape(len(known), form.count)


def misses_none(form: ClosedForm, known: np.ndarray) -> bool:
    """Whether all solutions at which Newton's method ends from random complex starts are branches
    for known values (known,), and are enough to tell.
    """
    with np.errstate(all="ignore"):
        found = _solutions(form.system, known)
        apart = np.abs(found[:, :, :, None] - _branches(form, known[None])[:, :, None])
        near = apart.max(axis=(0, 1)).min(axis=1) <= _SAME * _reach(found)
    return len(near) >= _FEWEST and bool(near.all())


def _solutions(system: System, known: np.ndarray) -> np.ndarray:
    """Parts (2, width, n) of solutions, one for each random start that leads to one."""
    angular, every = _angular(system), np.tile(known, (_STARTS, 1))
    rows = system.rows / system.characteristic_length
    gradients = ca.jacobian(rows, system.unknown) @ ca.diag(ca.SX(ca.DM(_units(system))))
    linearise = _over_complex(system, [rows, gradients])
    real, imaginary = np.random.default_rng(7).normal(size=(2, system.width, _STARTS))
    u = np.where(angular, np.pi, 1.0) * real + 0.5j * imaginary
    for _ in range(_STEPS):
        errors, jacobians = linearise(u, every)
        adjoint = jacobians.conj().transpose(0, 2, 1)
        squares = adjoint @ jacobians
        scale = 1.0 + np.abs(squares).max(axis=(1, 2), keepdims=True)
        squares = squares + _DAMPING * scale * np.eye(system.width)
        # a start whose rows overflow stays at what is no number
        squares[~np.isfinite(scale[:, 0, 0])] = np.eye(system.width)
        step = np.linalg.solve(squares, -adjoint @ errors)[:, :, 0].T
        length = np.max(np.abs(step), axis=0)
        u = u + step / np.maximum(1.0, length)
        if np.all(length < _CONVERGED):
            break
    parts = np.array([np.where(angular, np.cos(u), u), np.where(angular, np.sin(u), 0.0)])
    closes = np.max(np.abs(errors), axis=(1, 2)) < _CLOSED * _reach(parts) ** 2
    return parts[:, :, closes & (length < _CONVERGED)]


@lru_cache(maxsize=64)
def _rows_over_complex(system: System) -> Evaluate:
    return _over_complex(system, [system.rows / system.characteristic_length])


def _over_complex(system: System, outputs: Sequence[ca.SX]) -> Evaluate:
    """Expressions, an array (n, rows, columns) of each, at complex values u (width, n) of the
    unknowns, angles and lengths in sizes, for known values (n, known).
    """
    outputs = [ca.densify(part) for part in outputs]
    code = vectorise(ca.Function("complex", [system.unknown, system.known], outputs, {"cse": True}))

    def evaluate(u: np.ndarray, known: np.ndarray) -> list[np.ndarray]:
        found = [np.zeros((len(known), *part.shape), dtype=complex) for part in outputs]
        code(_units(system) * u, known.T.astype(complex), *found)
        return found

    return evaluate


def _branches(form: ClosedForm, known: np.ndarray) -> np.ndarray:
    """Parts (2, width, branches) of all branches for known values (n, known): cosines and sines,
    lengths in sizes and 0.
    """
    inputs = np.tile(form.choices, (len(known), 1)), np.repeat(known, form.count, axis=0)
    found = np.zeros((len(inputs[1]), 2 * form.system.width, 1), dtype=complex)
    _branches_over_complex(form)(*(v.T.astype(complex) for v in inputs), found)
    parts = found[:, :, 0].T.reshape(2, form.system.width, -1)
    return parts / _units(form.system)


@lru_cache(maxsize=64)
def _branches_over_complex(form: ClosedForm) -> Callable[..., None]:
    values = ca.densify(form.at_roots(ca.vertcat(form.first, form.second), ca.sqrt))
    code = ca.Function("complex", [form.signs, form.system.known], [values], {"cse": True})
    return vectorise(code)


def _angular(system: System) -> np.ndarray:
    """Which unknowns (width, 1) are angles."""
    return np.array([c.is_angular for c in system.unknowns])[:, None]


def _units(system: System) -> np.ndarray:
    """What the unknowns (width, 1) are told in: radians, and sizes."""
    return np.array(units_of(system.unknowns, system.characteristic_length))[:, None]


def _reach(parts: np.ndarray) -> np.ndarray:
    """How large points (n,) of parts (2, width, n) are, at least 1: rows are of second degree."""
    return np.maximum(1.0, np.max(np.abs(parts[0]) + np.abs(parts[1]), axis=0))
