"""Machines of many equal loops: parts that share nothing are solved apart, and what loops of one
shape have in common is derived once.
"""

from __future__ import annotations

import numpy as np
import pytest

from helpers.inside import (
    diagonal_parts,
    extreme_singular_values,
    least_squares_steps,
    null_space,
    singular_values,
)


def _scattered(rng: np.random.Generator, shapes: list[tuple[int, int]]) -> np.ndarray:
    """A block diagonal matrix of random parts, its rows and columns in random order."""
    rows, columns = (sum(shape[k] for shape in shapes) for k in (0, 1))
    whole, i, j = np.zeros((rows, columns)), 0, 0
    for r, c in shapes:
        whole[i : i + r, j : j + c] = rng.normal(size=(r, c))
        i, j = i + r, j + c
    return whole[rng.permutation(rows)][:, rng.permutation(columns)]


@pytest.mark.parametrize("shapes", [[(3, 2)] * 40, [(2, 3)] * 20 + [(5, 5)] * 3])
def test_parts_of_a_matrix_are_the_matrix(shapes: list[tuple[int, int]]) -> None:
    """Singular values, null space and least steps of a block diagonal matrix are those of the
    whole one.
    """
    rng = np.random.default_rng(0)
    whole = _scattered(rng, shapes)
    parts = diagonal_parts(whole[None])
    assert sum(rows.size for rows, _ in parts) == len(whole)
    assert sum(columns.size for _, columns in parts) == whole.shape[1]
    wanted = np.linalg.svd(whole, compute_uv=False)
    np.testing.assert_allclose(singular_values(whole), wanted, atol=1e-12)
    left = null_space(whole, 1e-9, relative=True)
    assert len(left) == whole.shape[1] - np.sum(wanted > 1e-9)
    np.testing.assert_allclose(left @ left.T, np.eye(len(left)), atol=1e-12)
    np.testing.assert_allclose(whole @ left.T, 0.0, atol=1e-12)
    values = rng.normal(size=(1, len(whole)))
    step = least_squares_steps(whole[None], values)[0]
    np.testing.assert_allclose(step, -np.linalg.pinv(whole) @ values[0], atol=1e-9)
    extremes = extreme_singular_values(whole[None])[0]
    np.testing.assert_allclose(extremes, wanted[[0, -1]], atol=1e-12)
