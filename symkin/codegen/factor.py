"""The linear systems of generated code: LU unrolled in an order chosen beforehand, LU in loops, QR for more rows.

The order of pivots is chosen once over sampled matrices: at each stage the entry whose smallest size over the samples,
relative to its row and column, is largest. Each unrolled pivot is guarded; where a guard fails, loops with partial
pivoting take over, so that the order costs time at worst, never the answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.codegen.emit import Emitter, indexed
from symkin.codegen.kernel import Kernel

UNROLLED = 8
"""Largest square system that is unrolled."""
GUARD = 1e-3
"""Where a scaled pivot may be below this, the pivoting fallback takes over."""


@dataclass(frozen=True)
class Pivots:
    """Rows and columns in the order of elimination, the usual size of each pivot, and the scales of rows and columns."""

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    usual: tuple[float, ...]
    row_scale: tuple[float, ...]
    column_scale: tuple[float, ...]

    @property
    def parity(self) -> int:
        """Sign of the two permutations together: what the product of pivots lacks to be the determinant."""
        return _parity(self.rows) * _parity(self.columns)

    def large_first(self, i: int) -> bool:
        """Pivots by size take turns, the largest first, so that a product of every other one's reciprocal stays near 1."""
        return sorted(range(len(self.usual)), key=lambda k: -self.usual[k]).index(i) % 2 == 0


def _parity(order: Sequence[int]) -> int:
    inversions = sum(a > b for i, a in enumerate(order) for b in order[i + 1 :])
    return -1 if inversions % 2 else 1


def scales(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Typical sizes of columns (largest entry, median over samples) and of rows after columns are scaled."""
    columns = np.median(np.max(np.abs(matrices), axis=1), axis=0)
    columns[columns == 0.0] = 1.0
    rows = np.median(np.linalg.norm(matrices / columns, axis=2), axis=0)
    rows[rows == 0.0] = 1.0
    return rows, columns


def choose_pivots(matrices: np.ndarray) -> Pivots:
    """The elimination order for sampled matrices (count, n, n)."""
    row_scale, column_scale = scales(matrices)
    work = matrices / row_scale[:, None] / column_scale
    n = work.shape[1]
    rows, columns, usual = list(range(n)), list(range(n)), []
    chosen_rows: list[int] = []
    chosen_columns: list[int] = []
    for _ in range(n):
        sizes = np.quantile(np.abs(work[:, rows][:, :, columns]), 0.1, axis=0)
        fill = np.array([[_filled(work, i, j, rows, columns) for j in columns] for i in rows])
        best = float(np.max(sizes))
        allowed = np.where(sizes >= 0.3 * best, fill + (1.0 - sizes / best), np.inf)
        a, b = np.unravel_index(int(np.argmin(allowed)), sizes.shape)
        i, j = rows.pop(int(a)), columns.pop(int(b))
        pivot = work[:, i, j].copy()
        usual.append(rounded(float(np.median(np.abs(pivot)) * row_scale[i] * column_scale[j])))
        pivot[pivot == 0.0] = 1e-300
        for other in rows:
            work[:, other] -= (work[:, other, j] / pivot)[:, None] * work[:, i]
        chosen_rows.append(i)
        chosen_columns.append(j)
    return Pivots(
        tuple(chosen_rows), tuple(chosen_columns), tuple(usual),
        tuple(rounded(row_scale[i]) for i in chosen_rows), tuple(rounded(column_scale[j]) for j in chosen_columns),
    )  # fmt: skip


def rounded(value: float) -> float:
    """Three digits: generated constants must not depend on the last bits of a linear algebra library."""
    return float(f"{value:.3g}")


def curvature(
    kernel: Kernel, states: Sequence[np.ndarray], known: Sequence[np.ndarray], geometry: np.ndarray, seed: int = 5
) -> float:
    """kappa of a typical pose: a Newton step s leaves an error of kappa |s|^2, kappa = |J^-1 (J(x + s) - J(x)) s| / (2 |s|^2).
    The ninth decile over states and random directions."""
    rng = np.random.default_rng(seed)
    move = kernel.move_function()
    found = []
    for state, k in zip(states, known, strict=True):
        here = kernel.matrix(state, k, geometry)
        scale = np.max(np.abs(here), axis=0)
        step = rng.normal(size=kernel.n) / np.where(scale > 0, scale, 1.0)
        unit = float(move(state, step, geometry)[1])
        step *= 0.02 * kernel.size / np.sqrt(unit)
        there, squared = move(state, step, geometry)
        change = (kernel.matrix(np.asarray(there).ravel(), k, geometry) - here) @ step
        second = np.linalg.lstsq(here, change, rcond=None)[0]
        found.append(0.5 * np.sqrt(float(move(state, second, geometry)[1])) / float(squared))
    return rounded(float(np.quantile(found, 0.9)))


def _filled(work: np.ndarray, i: int, j: int, rows: Sequence[int], columns: Sequence[int]) -> int:
    """Markowitz count: entries that eliminating with (i, j) may fill."""
    nonzero = np.any(work != 0.0, axis=0)
    across = sum(bool(nonzero[i, c]) for c in columns) - 1
    down = sum(bool(nonzero[r, j]) for r in rows) - 1
    return across * down


@dataclass(frozen=True)
class UnrolledLU:
    """Statements of the factorisation and of the solution; the factors lie in a[n * row + column] of elimination order,
    reciprocals of pivots on the diagonal. `spread` is the sum of the squared reciprocals of the scaled pivots."""

    factor: list[str]
    solve: list[str]
    operations: dict[str, int]


def unroll(kernel: Kernel, emitter: Emitter, pivots: Pivots) -> UnrolledLU:
    """Row by row, so that few values live at a time: a row's entries are made, reduced by the rows before it, stored."""
    n, real = kernel.n, emitter.real
    zero = real.literal(0.0)
    upper: list[dict[int, str]] = []
    inverses: list[str] = []
    signs: list[str] = []
    squares: list[str] = []
    lower: list[dict[int, str]] = []
    structure = emitter.function.sparsity_out(0)
    places = {place: k for k, place in enumerate(zip(*structure.get_triplet(), strict=True))}
    lines = emitter.lines
    for i in range(n):
        row: dict[int, str] = {}
        for j, column in enumerate(pivots.columns):
            k = places.get((pivots.rows[i], column))
            text = zero if k is None else emitter.value(0, k)
            if text != zero:
                row[j] = text
        factors: dict[int, str] = {}
        for k in range(i):
            if k not in row:
                continue
            factors[k] = emitter.assign(f"{_safe(row.pop(k))} * {inverses[k]}")
            lines.append(f"w->a[{n * i + k}] = {factors[k]};")
            emitter.operations["multiplications"] += 1
            for j, above in upper[k].items():
                emitter.operations["multiplications"] += 1
                emitter.operations["additions"] += 1
                product = f"{factors[k]} * {_safe(above)}"
                row[j] = emitter.assign(f"{row[j]} - {product}" if j in row else f"-({product})")
        pivot = row.pop(i, zero)
        emitter.operations["divisions"] += 1
        inverses.append(emitter.assign(f"{real.literal(1.0)} / {pivot}"))
        signs.append(pivot if pivots.large_first(i) else inverses[i])
        lines.append(f"w->a[{n * i + i}] = {inverses[i]};")
        scaled = emitter.assign(f"{inverses[i]} * {real.literal(pivots.row_scale[i] * pivots.column_scale[i])}")
        squares.append(f"{scaled} * {scaled}")
        for j, text in row.items():
            lines.append(f"w->a[{n * i + j}] = {text};")
        upper.append(row)
        lower.append(factors)
    lines.append(f"det = {' * '.join(signs)};")
    lines.append(f"w->spread = {' + '.join(squares)};")
    return UnrolledLU(lines, _solve(n, upper, lower, pivots, real.type), dict(emitter.operations))


def _solve(n: int, upper: Sequence[dict[int, str]], lower: Sequence[dict[int, str]], pivots: Pivots, kind: str) -> list[str]:
    """Forward and back substitution of f into the step, in place."""
    lines = []
    for i in range(n):
        terms = "".join(f" - w->a[{n * i + k}] * y{k}" for k in lower[i])
        lines.append(f"const {kind} y{i} = w->f[{pivots.rows[i]}]{terms};")
    for i in reversed(range(n)):
        terms = "".join(f" - w->a[{n * i + j}] * s{j}" for j in sorted(upper[i], reverse=True))
        lines.append(f"const {kind} s{i} = (y{i}{terms}) * w->a[{n * i + i}];")
    return lines + [f"w->f[{pivots.columns[i]}] = s{i};" for i in range(n)]


def _safe(text: str) -> str:
    return f"({text})" if text.startswith("-") else text


def dense_statements(emitter: Emitter, rows: int, columns: int, target: str, *, transposed: bool = False) -> list[str]:
    """Statements that fill a row-major array with the function's first output, or with its transpose."""
    places = {place: k for k, place in enumerate(zip(*emitter.function.sparsity_out(0).get_triplet(), strict=True))}
    names = indexed(target, rows * columns)
    for i in range(rows):
        for j in range(columns):
            k = places.get((i, j))
            text = emitter.real.literal(0.0) if k is None else emitter.value(0, k)
            emitter.lines.append(f"{names[rows * j + i if transposed else columns * i + j]} = {text};")
    return emitter.lines
