"""Branches of a closed form over the complex numbers: whether all of them are solutions."""

from __future__ import annotations

import casadi as ca
import numpy as np

from symkin.closure.numpy_code import vectorise
from symkin.elimination.closed_form import ClosedForm


def complex_errors(form: ClosedForm, known: np.ndarray) -> np.ndarray:
    """By how much all branches, complex ones included, leave the rows open for known values (n,
    known): (n, count), in sizes. Raises NotImplementedError for rows that have no complex form.
    """
    system = form.system
    size = system.characteristic_length
    angular = np.array([c.is_angular for c in system.unknowns])[:, None]
    inputs = np.tile(form.choices, (len(known), 1)).T, np.repeat(known, form.count, axis=0).T
    values = ca.densify(form.at_roots(ca.vertcat(form.first, form.second), ca.sqrt))
    with np.errstate(all="ignore"):
        first, second = np.split(_evaluated([form.signs, system.known], values, inputs), 2)
        z = np.where(angular, -1j * np.log(first + 1j * second), first)
        rows = (
            _evaluated([system.unknown, system.known], ca.densify(system.rows), (z, inputs[1]))
            / size
        )
        circles = np.where(angular, first**2 + second**2 - 1.0, 0.0)
        # rows are of second degree in what is large
        reach = (
            np.maximum(
                1.0,
                np.max(
                    np.where(angular, np.abs(first) + np.abs(second), np.abs(first) / size), axis=0
                ),
            )
            ** 2
        )
        found = np.max(np.abs(np.concatenate([rows, circles])), axis=0) / reach
    return np.where(np.isfinite(found), found, np.inf).reshape(len(known), form.count)


def _evaluated(
    symbols: list[ca.SX], expression: ca.SX, inputs: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """An expression (rows,) of two vectors at complex values (length, n) of these: (rows, n)."""
    found = np.zeros((inputs[1].shape[1], int(expression.shape[0]), 1), dtype=complex)
    vectorise(ca.Function("complex", symbols, [expression], {"cse": True}))(
        *(v.astype(complex) for v in inputs), found
    )
    return found[:, :, 0].T
