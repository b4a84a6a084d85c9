"""Matrices over balls and bounds of fixed points, for proofs about a branch."""

from __future__ import annotations

import numpy as np
from flint import arb, arb_mat

from symkin.numeric.balls import upper
from symkin.numeric.tolerances import ROUNDED_STEP


def balls(centre: np.ndarray, half: np.ndarray) -> list[arb]:
    """Balls of given centres and radii."""
    return [arb(c, r) for c, r in zip(centre.tolist(), half.tolist(), strict=True)]


def matrix(a: np.ndarray) -> arb_mat:
    """The exact matrix of doubles."""
    return arb_mat(a.shape[0], a.shape[1], a.ravel().tolist())


def identity(n: int) -> arb_mat:
    """The unit matrix."""
    return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])


def bounds(m: arb_mat) -> np.ndarray:
    """Upper bounds of a matrix' entries' absolute values."""
    return np.array([upper(v) for v in m.entries()]).reshape(m.nrows(), m.ncols())


def sum_rounding(n: int) -> float:
    """Outward rounding of sums of n products of doubles that are not negative, and of a few
    operations more.
    """
    return float(1.0 + (n + 8) * 2.0**-51)


def fixed_point(error: arb_mat, first: np.ndarray) -> np.ndarray | None:
    """Bounds (n,) of |x - c| where x = c + E x and first bounds |E c|: first + |E| max(first) /
    (1 - norm E); None where the norm is not below 1.
    """
    e = bounds(error)
    norm = float(np.max(e.sum(axis=1))) * sum_rounding(len(e))
    if not norm < 1.0:
        return None
    rest = e.sum(axis=1) * (float(np.max(first)) / (1.0 - norm))
    return np.asarray((first + rest) * sum_rounding(len(e)))


def inverse_with(jacobian: np.ndarray, direction: np.ndarray) -> np.ndarray | None:
    """About the (pseudo-)inverse of [dG/dy; e], (n, m + 1); None where it is singular or not
    finite. Where e is the path parameter's direction its last row is e exactly.
    """
    if not np.isfinite(jacobian).all():
        return None
    try:
        if direction[-1] == 1.0:
            inverse = _inverse(jacobian[:, :-1])
            top = np.hstack([inverse, -inverse @ jacobian[:, -1:]])
            inverse = np.vstack([top, np.append(np.zeros(jacobian.shape[0]), 1.0)])
        else:
            inverse = _inverse(np.vstack([jacobian, direction]))
    except np.linalg.LinAlgError:
        return None
    return inverse if np.isfinite(inverse).all() else None


def _inverse(a: np.ndarray) -> np.ndarray:
    square = a.shape[0] == a.shape[1]
    return np.asarray(np.linalg.inv(a) if square else np.linalg.pinv(a, rcond=ROUNDED_STEP))
