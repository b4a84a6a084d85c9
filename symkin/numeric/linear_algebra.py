"""Dense linear algebra of many small matrices at once: least-squares steps, singular values,
conditions.

Stacks have the matrices along the first axes. What is regular is solved by elimination or QR; the
singular value decomposition, which costs ten times as much, is kept for matrices that are nearly
singular.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import prod

import numpy as np

from symkin.computed_once import lru_cache
from symkin.numeric.shared_library import library_of_extremes
from symkin.numeric.tolerances import GRAM_CONDITION, NO_MOTION, ROUNDED_STEP, WELL_CONDITIONED

_LARGE = 64
"""Columns from which on a matrix is looked at for parts that share neither rows nor columns."""


def diagonal_parts(matrices: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Rows (k, r) and columns (k, c) of k parts of one shape, for each shape, of a stack (n, rows,
    columns) of block diagonal matrices whose rows and columns stand in any order; none where the
    matrices are small or have one part only.
    """
    return parts_of_pattern(pattern_of(matrices)) if matrices.shape[2] >= _LARGE else []


def pattern_of(matrices: np.ndarray) -> np.ndarray:
    """Which entries (rows, columns) of large matrices (n, rows, columns) are not all zero; of small
    ones, which are not looked at, every one.
    """
    if matrices.shape[2] < _LARGE:
        return np.ones(matrices.shape[1:], dtype=bool)
    return (matrices != 0.0).any(axis=0)


def parts_of_pattern(
    pattern: np.ndarray, least: int = _LARGE
) -> list[tuple[np.ndarray, np.ndarray]]:
    """The same parts of all matrices that are zero where a pattern (rows, columns) is, of `least`
    columns or more.
    """
    if pattern.shape[1] < least:
        return []
    return _parts_of(np.packbits(pattern).tobytes(), *pattern.shape)


@lru_cache(maxsize=16)
def _parts_of(pattern: bytes, rows: int, columns: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """The parts of matrices (rows, columns) by the bits of which entries are not zero: the steps of
    a search ask for the same ones.
    """
    bits = np.frombuffer(pattern, dtype=np.uint8)
    held, holds = np.nonzero(np.unpackbits(bits, count=rows * columns).reshape(rows, columns))
    label, changed = np.arange(columns), True
    while changed:
        # each row and its columns take the least label among them
        least = np.full(rows, columns)
        np.minimum.at(least, held, label[holds])
        before = label.copy()
        np.minimum.at(label, holds, least[held])
        changed = bool((label != before).any())
    owner = np.full(rows, -1)
    owner[held] = label[holds]
    shapes: dict[tuple[int, int], list[tuple[np.ndarray, np.ndarray]]] = {}
    parts = np.unique(label)
    for places, own in zip(_places(owner, parts), _places(label, parts), strict=True):
        shapes.setdefault((len(places), len(own)), []).append((places, own))
    if len(parts) == 1:
        return []
    return [
        (np.array([places for places, _ in same]), np.array([own for _, own in same]))
        for same in shapes.values()
    ]


def _places(labels: np.ndarray, parts: np.ndarray) -> list[np.ndarray]:
    """The places of each of some labels, rising."""
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.searchsorted(labels[order], parts))[1:]


def part_by_part(
    solve: Callable[[np.ndarray, np.ndarray], np.ndarray],
    matrices: np.ndarray,
    values: np.ndarray,
    pattern: np.ndarray | None = None,
) -> np.ndarray:
    """What `solve` makes of matrices (n, rows, columns) and values (n, rows): n vectors (columns,),
    those of block diagonal matrices part by part. Matrices are zero where a `pattern` is.
    """
    parts = parts_of_pattern(pattern_of(matrices) if pattern is None else pattern)
    if not parts:
        return solve(matrices, values)
    found = np.zeros((len(matrices), matrices.shape[2]))
    for rows, columns in parts:
        own = matrices[:, rows[:, :, None], columns[:, None, :]]
        solved = solve(own.reshape(-1, *own.shape[2:]), values[:, rows].reshape(-1, rows.shape[1]))
        found[:, columns] = solved.reshape(len(matrices), *columns.shape)
    return found


def singular_values(matrices: np.ndarray) -> np.ndarray:
    """Singular values (..., min(rows, columns)) in falling order; zero where a matrix is not
    finite.
    """
    finite = np.isfinite(matrices).all(axis=(-2, -1))
    if not finite.all():
        matrices = np.where(finite[..., None, None], matrices, 0.0)
    stack = matrices.reshape(prod(matrices.shape[:-2]), *matrices.shape[-2:])
    parts = diagonal_parts(stack)
    if not parts:
        return np.linalg.svd(matrices, compute_uv=False)
    found = [
        np.linalg.svd(stack[:, rows[:, :, None], columns[:, None, :]], compute_uv=False)
        for rows, columns in parts
    ]
    least = min(matrices.shape[-2:])
    every = np.hstack([np.zeros((len(stack), least)), *(v.reshape(len(stack), -1) for v in found)])
    return np.sort(every, axis=1)[:, ::-1][:, :least].reshape(*matrices.shape[:-2], least)


def conditions(jacobians: np.ndarray) -> np.ndarray:
    """Largest over smallest of the min(rows, columns) singular values of each matrix (n, rows,
    columns); infinite where the smallest vanishes (see `NO_MOTION`) or entries are not finite, 1
    where there are no rows or no columns.
    """
    count, rows, columns = jacobians.shape
    if min(rows, columns) == 0:
        return np.ones(count)
    return condition_of(extreme_singular_values(jacobians))


def condition_of(extremes: np.ndarray) -> np.ndarray:
    """Conditions (n,) from the largest and smallest singular values (n, 2)."""
    largest, smallest = extremes.T
    regular = smallest > np.maximum(1e-15 * largest, NO_MOTION)
    return np.divide(largest, smallest, out=np.full(len(extremes), np.inf), where=regular)


def extreme_singular_values(matrices: np.ndarray) -> np.ndarray:
    """The largest and the smallest (n, 2) of the min(rows, columns) singular values; zeros where a
    matrix is not finite.
    """
    if not len(matrices):
        return np.zeros((0, 2))
    if diagonal_parts(matrices):
        return singular_values(matrices)[:, [0, -1]]
    found = np.sqrt(np.maximum(_squared_extremes(matrices), 0.0))
    doubtful = (~(found[:, 0] < GRAM_CONDITION * found[:, 1])).nonzero()[0]
    if doubtful.size:
        found[doubtful] = singular_values(matrices[doubtful])[:, [0, -1]]
    return found


def _squared_extremes(matrices: np.ndarray) -> np.ndarray:
    """Squares (n, 2) of the largest and smallest singular values, to 1e-16 of the largest:
    eigenvalues of the smaller of J^T J and J J^T take half the time of the decomposition. Zero
    where a matrix is not finite.
    """
    library = library_of_extremes(matrices)
    if library is not None:
        return library.squared_extremes(matrices)
    transposed = matrices.transpose(0, 2, 1)
    gram = (
        transposed @ matrices if matrices.shape[1] >= matrices.shape[2] else matrices @ transposed
    )
    if not np.isfinite(gram).all():
        gram = np.where(np.isfinite(gram).all(axis=(1, 2))[:, None, None], gram, 0.0)
    return np.linalg.eigvalsh(gram)[:, [-1, 0]]


def squared_norms(stack: np.ndarray) -> np.ndarray:
    """Sums (n,) of the squares of the entries of each vector or matrix of a stack (n, ...)."""
    axes = list(range(stack.ndim))
    return np.einsum(stack, axes, stack, axes, [0])


def least_squares_steps(
    jacobians: np.ndarray, values: np.ndarray, cut_below: float = ROUNDED_STEP
) -> np.ndarray:
    """The shortest d (n, columns) that make |J d + F| least, for J (n, rows, columns) and F (n,
    rows); singular values below a share of the largest are cut.
    """
    if min(jacobians.shape) == 0:
        return np.zeros((len(jacobians), jacobians.shape[2]))
    return part_by_part(partial(_least_squares_steps, cut_below), jacobians, values)


def _least_squares_steps(cut_below: float, jacobians: np.ndarray, values: np.ndarray) -> np.ndarray:
    if not jacobians.shape[1]:
        return np.zeros((len(jacobians), jacobians.shape[2]))
    steps, regular = _regular_steps(jacobians, values)
    if not regular.all():
        cut = ~regular
        inverse = np.linalg.pinv(jacobians[cut], rcond=cut_below)
        steps[cut] = -(inverse @ values[cut, :, None])[:, :, 0]
    return steps


def _regular_steps(jacobians: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps by elimination, or by QR where rows are more than columns or fewer, and where these are
    as good as any.
    """
    count, rows, columns = jacobians.shape
    right, basis = values[:, :, None], None
    if rows > columns:
        q, jacobians = np.linalg.qr(jacobians)
        right = q.transpose(0, 2, 1) @ right
    elif rows < columns:
        # the shortest step is one of the rows' span
        basis, triangle = np.linalg.qr(jacobians.transpose(0, 2, 1))
        jacobians = triangle.transpose(0, 2, 1)
    try:
        inverses = np.linalg.inv(jacobians)
    except np.linalg.LinAlgError:
        return np.zeros((count, columns)), np.zeros(count, dtype=bool)
    # |J| |J^-1| in the Frobenius norm is at least the condition, at most `columns` times it
    with np.errstate(over="ignore"):
        size = squared_norms(jacobians) * squared_norms(inverses)
    steps = -(inverses @ right)
    steps = steps if basis is None else basis @ steps
    return steps[:, :, 0], size < WELL_CONDITIONED**2


def largest_of(values: np.ndarray) -> float:
    """The largest absolute value; 0 of none."""
    return float(np.max(np.abs(values), initial=0.0))
