"""Sums, products and determinants of CasADi expressions, and what spans vectors of numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import casadi as ca
import numpy as np

_RANK = 1e-9
"""Share of a vector's length below which what is left of it across others is rounding."""


def total(parts: Iterable[ca.SX]) -> ca.SX:
    found = ca.SX(0)
    for part in parts:
        found = found + part
    return found


def product(factors: Iterable[ca.SX]) -> ca.SX:
    found = ca.SX(1)
    for factor in factors:
        found = found * factor
    return found


def cross(u: Sequence[ca.SX], v: Sequence[ca.SX]) -> list[ca.SX]:
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def determinant(matrix: list[list[ca.SX]]) -> ca.SX:
    """By the first row's minors; 1 of no rows."""
    if not matrix:
        return ca.SX(1)
    minors = ([line[:j] + line[j + 1 :] for line in matrix[1:]] for j in range(len(matrix)))
    return total((-1) ** j * matrix[0][j] * determinant(minor) for j, minor in enumerate(minors))


def constant_basis(vectors: np.ndarray) -> list[np.ndarray]:
    """Orthonormal vectors that span others (n, width), in the order of these."""
    basis: list[np.ndarray] = []
    for vector in vectors:
        length = float(np.linalg.norm(vector))
        left = _across(vector, basis)
        if length > 0 and np.linalg.norm(left) > _RANK * length:
            basis.append(left / np.linalg.norm(left))
    return basis


def _across(vector: np.ndarray, basis: Sequence[np.ndarray]) -> np.ndarray:
    """What is left of a vector across an orthonormal basis."""
    for unit in (*basis, *basis):  # twice, against rounding
        vector = vector - (vector @ unit) * unit
    return vector
