"""Dense linear algebra of many small matrices at once: least-squares steps, singular values,
conditions, null spaces.

Stacks have the matrices along the first axes. What is regular is solved by elimination or QR; the
singular value decomposition, which costs ten times as much, is kept for matrices that are nearly
singular.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from symkin.numeric.tolerances import GRAM_CONDITION, NO_MOTION, ROUNDED_STEP, WELL_CONDITIONED


def singular_values(matrices: np.ndarray) -> np.ndarray:
    """Singular values (..., min(rows, columns)) in falling order; zero where a matrix is not
    finite.
    """
    finite = np.isfinite(matrices).all(axis=(-2, -1))
    if not finite.all():
        matrices = np.where(finite[..., None, None], matrices, 0.0)
    return np.asarray(np.linalg.svd(matrices, compute_uv=False))


def conditions(jacobians: np.ndarray) -> np.ndarray:
    """Largest over smallest of the min(rows, columns) singular values of each matrix (n, rows,
    columns); infinite where the smallest vanishes (see `NO_MOTION`) or entries are not finite, 1
    where there are no rows and no columns.
    """
    count, rows, columns = jacobians.shape
    if min(rows, columns) == 0:
        return np.full(count, 1.0 if rows * columns == 0 else np.inf)
    return condition_of(extreme_singular_values(jacobians))


def condition_of(extremes: np.ndarray) -> np.ndarray:
    """Conditions (n,) from the largest and smallest singular values (n, 2)."""
    largest, smallest = extremes.T
    regular = smallest > np.maximum(1e-15 * largest, NO_MOTION)
    return np.where(regular, largest / np.where(regular, smallest, 1.0), np.inf)


def extreme_singular_values(matrices: np.ndarray) -> np.ndarray:
    """The largest and the smallest (n, 2) of the min(rows, columns) singular values; zeros where a
    matrix is not finite.
    """
    if not len(matrices):
        return np.zeros((0, 2))
    found = np.sqrt(np.maximum(_squared_extremes(matrices), 0.0))
    doubtful = np.flatnonzero(~(found[:, 0] < GRAM_CONDITION * found[:, 1]))
    if doubtful.size:
        found[doubtful] = singular_values(matrices[doubtful])[:, [0, -1]]
    return np.asarray(found)


def _squared_extremes(matrices: np.ndarray) -> np.ndarray:
    """Squares (n, 2) of the largest and smallest singular values, to 1e-16 of the largest:
    eigenvalues of the smaller of J^T J and J J^T take half the time of the decomposition. Zero
    where a matrix is not finite.
    """
    transposed = matrices.transpose(0, 2, 1)
    gram = (
        transposed @ matrices if matrices.shape[1] >= matrices.shape[2] else matrices @ transposed
    )
    finite = np.isfinite(gram).all(axis=(1, 2))
    if not finite.all():
        gram = np.where(finite[:, None, None], gram, 0.0)
    return np.linalg.eigvalsh(gram)[:, [-1, 0]]


def least_squares_steps(
    jacobians: np.ndarray, values: np.ndarray, cut_below: float = ROUNDED_STEP
) -> np.ndarray:
    """The shortest d (n, columns) that make |J d + F| least, for J (n, rows, columns) and F (n,
    rows); singular values below a share of the largest are cut.
    """
    count, rows, columns = jacobians.shape
    if min(count, rows, columns) == 0:
        return np.zeros((count, columns))
    steps, regular = _regular_steps(jacobians, values)
    if not regular.all():
        cut = ~regular
        inverse = np.linalg.pinv(jacobians[cut], rcond=cut_below)
        steps[cut] = -(inverse @ values[cut, :, None])[:, :, 0]
    return steps


def _regular_steps(jacobians: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps by elimination, or by QR where rows are more than columns, and where these are as good
    as any.
    """
    count, rows, columns = jacobians.shape
    none = np.zeros((count, columns)), np.zeros(count, dtype=bool)
    if rows < columns:
        return none
    right = values[:, :, None]
    if rows > columns:
        q, jacobians = np.linalg.qr(jacobians)
        right = q.transpose(0, 2, 1) @ right
    try:
        inverses = np.linalg.inv(jacobians)
    except np.linalg.LinAlgError:
        return none
    # |J| |J^-1| in the Frobenius norm is at least the condition, at most `columns` times it
    size = np.einsum("nij,nij->n", jacobians, jacobians) * np.einsum(
        "nij,nij->n", inverses, inverses
    )
    return -(inverses @ right)[:, :, 0], size < WELL_CONDITIONED**2


def null_space(matrix: np.ndarray, tolerance: float, *, relative: bool = False) -> np.ndarray:
    """Orthonormal rows n with matrix n = 0, singular values up to `tolerance` taken as zero: an
    absolute bound, or a share of the largest one.
    """
    if not len(matrix):
        return np.eye(matrix.shape[1])
    _, singular, right = np.linalg.svd(matrix)
    bound = (
        tolerance * max(float(singular[0]), float(np.finfo(float).tiny))
        if relative and singular.size
        else tolerance
    )
    return np.asarray(right[int(np.sum(singular > bound)) :])


def independent_rows(space: np.ndarray, order: Iterable[int], least: float) -> list[int]:
    """Choose rows of a matrix in an order, each further than `least` from what those before it
    span; as many as there are columns at most.
    """
    chosen, rest = list[int](), space
    for k in order:
        length = float(np.linalg.norm(rest[k]))
        if length > least and len(chosen) < space.shape[1]:
            chosen.append(int(k))
            rest = rest - np.outer(rest @ rest[k], rest[k]) / length**2
    return chosen
