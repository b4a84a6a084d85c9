"""Write the linear solver of a Newton kernel in C: LU unrolled in an order chosen beforehand, LU in
loops, QR for more rows.

The order of pivots is chosen once over sampled matrices: at each stage the entry whose smallest
size over the samples, relative to its row and column, is largest. Each unrolled pivot is guarded;
where a guard fails, loops with partial pivoting take over, so that the order costs time at worst,
never the answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from symkin.codegen.steps.newton_kernel import Kernel, rounded
from symkin.codegen.text.c import Emitter, Real, indexed
from symkin.codegen.text.templates import fill

UNROLLED = 8
"""Largest square system that is unrolled."""
GUARD = 1e-3
"""Where a scaled pivot may be below this, the pivoting fallback takes over."""

SINGULAR = 32.0
"""Roundings of a column's usual size below which its pivot is none."""


# --- the order of pivots --------------------------------------------------------------------------


@dataclass(frozen=True)
class Pivots:
    """Rows and columns in the order of elimination, the usual size of each pivot, and the scales of
    rows and columns.
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    usual: tuple[float, ...]
    row_scale: tuple[float, ...]
    column_scale: tuple[float, ...]

    @property
    def parity(self) -> int:
        """Sign of the two permutations together: what the product of pivots lacks to be the
        determinant.
        """
        return _parity(self.rows) * _parity(self.columns)

    def large_first(self, i: int) -> bool:
        """Pivots by size take turns, the largest first, so that a product of every other one's
        reciprocal stays near 1.
        """
        return sorted(range(len(self.usual)), key=lambda k: -self.usual[k]).index(i) % 2 == 0


def _parity(order: Sequence[int]) -> int:
    """Sign of a permutation."""
    inversions = sum(a > b for i, a in enumerate(order) for b in order[i + 1 :])
    return -1 if inversions % 2 else 1


def scales(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Typical sizes of rows after columns are scaled, and of columns (largest entry, median over
    samples).
    """
    columns = np.median(np.max(np.abs(matrices), axis=1), axis=0)
    columns[columns == 0.0] = 1.0
    rows = np.median(np.linalg.norm(matrices / columns, axis=2), axis=0)
    rows[rows == 0.0] = 1.0
    return rows, columns


def choose_pivots(matrices: np.ndarray) -> Pivots:
    """Choose the elimination order for sampled matrices (count, n, n)."""
    row_scale, column_scale = scales(matrices)
    work = matrices / row_scale[:, None] / column_scale
    n = work.shape[1]
    rows, columns = list(range(n)), list(range(n))
    chosen: list[tuple[int, int]] = []
    usual: list[float] = []
    for _ in range(n):
        i, j = _next_pivot(work, rows, columns)
        rows.remove(i)
        columns.remove(j)
        pivot = work[:, i, j].copy()
        usual.append(rounded(float(np.median(np.abs(pivot)) * row_scale[i] * column_scale[j])))
        # a sample that is singular here must not stop the others
        pivot[pivot == 0.0] = 1e-300
        for other in rows:
            work[:, other] -= (work[:, other, j] / pivot)[:, None] * work[:, i]
        chosen.append((i, j))
    return Pivots(
        rows=tuple(i for i, _ in chosen),
        columns=tuple(j for _, j in chosen),
        usual=tuple(usual),
        row_scale=tuple(rounded(row_scale[i]) for i, _ in chosen),
        column_scale=tuple(rounded(column_scale[j]) for _, j in chosen),
    )


def _next_pivot(work: np.ndarray, rows: Sequence[int], columns: Sequence[int]) -> tuple[int, int]:
    """Row and column of the next pivot: nearly the largest entry, at the first decile of the
    samples, that fills in least.
    """
    sizes = np.quantile(np.abs(work[:, rows][:, :, columns]), 0.1, axis=0)
    fill_in = np.array([[_filled(work, i, j, rows, columns) for j in columns] for i in rows])
    best = float(np.max(sizes))
    # within a factor 3 of the largest, fewer new entries matter more than size
    allowed = np.where(sizes >= 0.3 * best, fill_in + (1.0 - sizes / best), np.inf)
    a, b = np.unravel_index(int(np.argmin(allowed)), sizes.shape)
    return rows[int(a)], columns[int(b)]


def _filled(work: np.ndarray, i: int, j: int, rows: Sequence[int], columns: Sequence[int]) -> int:
    """Markowitz count: entries that eliminating with (i, j) may fill."""
    nonzero = np.any(work != 0.0, axis=0)
    across = sum(bool(nonzero[i, c]) for c in columns) - 1
    down = sum(bool(nonzero[r, j]) for r in rows) - 1
    return across * down


# --- unrolled LU ----------------------------------------------------------------------------------


@dataclass
class UnrolledLU:
    """Elimination row by row, so that few values live at a time: a row's entries are made, reduced
    by the rows before it, stored.

    The factors lie in a[n * row + column] of elimination order, reciprocals of pivots on the
    diagonal: `lower` and `upper` hold the C text of what is not zero, by column.
    """

    emitter: Emitter
    pivots: Pivots
    upper: list[dict[int, str]] = field(default_factory=list)
    lower: list[dict[int, str]] = field(default_factory=list)
    inverses: list[str] = field(default_factory=list)

    @property
    def n(self) -> int:
        return len(self.pivots.rows)

    def factor(self) -> list[str]:
        """Statements of the factorisation, of the determinant and of `spread`, the sum of the
        squared reciprocals of the scaled pivots.
        """
        signs, squares = [], []
        for i in range(self.n):
            pivot = self._eliminate_row(i)
            signs.append(pivot if self.pivots.large_first(i) else self.inverses[i])
            scale = self.pivots.row_scale[i] * self.pivots.column_scale[i]
            scaled = self.emitter.assign(f"{self.inverses[i]} * {scale}")
            squares.append(f"{scaled} * {scaled}")
            self._store(self.upper[i], i)
        lines = self.emitter.lines
        self.emitter.comment(
            "the determinant's sign: pivots and reciprocals by turns, so that the product stays "
            "near 1"
        )
        lines.append(f"det = {' * '.join(signs)};")
        lines.append(f"w->spread = {' + '.join(squares)};")
        return lines

    def _eliminate_row(self, i: int) -> str:
        """Make row i and reduce it by the rows before; the text of its pivot."""
        emitter, zero = self.emitter, self.emitter.real.zero
        emitter.comment(
            f"pivot {i + 1}: row {self.pivots.rows[i] + 1}, unknown {self.pivots.columns[i] + 1}"
        )
        texts = {
            j: emitter.entry(self.pivots.rows[i], column)
            for j, column in enumerate(self.pivots.columns)
        }
        row = {j: text for j, text in texts.items() if text != zero}
        factors: dict[int, str] = {}
        for k in range(i):
            if k in row:
                factors[k] = emitter.assign(f"{_bracketed(row.pop(k))} * {self.inverses[k]}")
                emitter.lines.append(f"w->a[{self.n * i + k}] = {factors[k]};")
                emitter.operations["multiplications"] += 1
                self._subtract(row, factors[k], self.upper[k])
        pivot = row.pop(i, zero)
        emitter.operations["divisions"] += 1
        emitter.operations["additions"] += 1
        self.inverses.append(emitter.assign(f"1.0 / ({pivot} + {self._least(i)})"))
        self._store({i: self.inverses[i]}, i)
        self.upper.append(row)
        self.lower.append(factors)
        return pivot

    def _least(self, i: int) -> float:
        """What is added to pivot i, so that none is zero: below the rounding of every pivot that
        the guard lets pass. Of the last one, another number: it may be what was added to one
        before.
        """
        scales = [
            a * b for a, b in zip(self.pivots.row_scale, self.pivots.column_scale, strict=True)
        ]
        least = 0.5 * GUARD * self.emitter.real.epsilon * min(scales)
        return rounded(0.7 * least if i == self.n - 1 else least)

    def _subtract(self, row: dict[int, str], factor: str, above: Mapping[int, str]) -> None:
        """Subtract a multiple of a row above."""
        for j, text in above.items():
            self.emitter.operations["multiplications"] += 1
            self.emitter.operations["additions"] += 1
            product = f"{factor} * {_bracketed(text)}"
            row[j] = self.emitter.assign(f"{row[j]} - {product}" if j in row else f"-({product})")

    def _store(self, entries: Mapping[int, str], i: int) -> None:
        self.emitter.lines += [f"w->a[{self.n * i + j}] = {text};" for j, text in entries.items()]

    def solve(self) -> list[str]:
        """Statements of the forward and back substitution of f into the step."""
        n, pivots = self.n, self.pivots
        lines = ["/* forward substitution, the rows in the order of the pivots */"]
        for i in range(n):
            terms = "".join(f" - w->a[{n * i + k}] * y{k}" for k in self.lower[i])
            lines.append(f"const real y{i} = w->f[{pivots.rows[i]}]{terms};")
        lines.append("/* back substitution */")
        for i in reversed(range(n)):
            terms = "".join(
                f" - w->a[{n * i + j}] * s{j}" for j in sorted(self.upper[i], reverse=True)
            )
            lines.append(f"const real s{i} = (y{i}{terms}) * w->a[{n * i + i}];")
        return [
            *lines,
            "/* the step in the order of the unknowns */",
            *(f"s[{pivots.columns[i]}] = s{i};" for i in range(n)),
        ]


def _bracketed(text: str) -> str:
    return f"({text})" if text.startswith("-") else text


# --- C functions ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class LinearSolver:
    """C functions that factorise and solve, the operations that they count, and the pivots of an
    unrolled LU.
    """

    text: str
    operations: Mapping[str, int]
    pivots: Pivots | None = None


def linear_solver(
    kernel: Kernel,
    real: Real,
    inputs: Sequence[Sequence[str] | str],
    matrices: np.ndarray,
    values: Mapping[str, object],
    given: Sequence[str] = (),
    *,
    compact: bool = False,
) -> LinearSolver:
    """Write the solver that fits the kernel. `matrices` are samples, `given` statements that fill
    w->a, where something shorter than the emitted ones is known; `compact`: loops in place of an
    unrolled LU.
    """
    dense = Emitter(kernel.jacobian_function(), inputs, real)
    matrix = given or dense_statements(dense, kernel.m, kernel.n, "w->a", transposed=kernel.is_wide)
    if not kernel.is_square:
        return _qr(kernel, {**values, "matrix": matrix}, dense.operations)
    _, column_scale = scales(matrices)
    rounded_scales = [rounded(s) for s in column_scale]
    tables = {
        "column_scales": tuple(rounded_scales),
        "least_pivots": tuple(SINGULAR * real.epsilon * s for s in rounded_scales),
    }
    text = fill("pivoted.c", {**values, "matrix": matrix, **tables}) + "\n"
    if not is_unrolled(kernel, compact=compact):
        counted = {
            **dense.operations,
            "multiplications": dense.operations["multiplications"] + kernel.n**3 // 3,
        }
        return LinearSolver(text + fill("looped.c", values), counted)
    pivots = choose_pivots(matrices)
    lu = UnrolledLU(Emitter(kernel.jacobian_function(), inputs, real), pivots)
    shown = {
        "factor": lu.factor(),
        "solve": lu.solve(),
        "sign": ">" if pivots.parity > 0 else "<",
    }
    return LinearSolver(
        text + fill("unrolled.c", {**values, **shown}), dict(lu.emitter.operations), pivots
    )


def _qr(
    kernel: Kernel, values: Mapping[str, object], operations: Mapping[str, int]
) -> LinearSolver:
    """QR of a matrix of more rows than unknowns, or of the transposed matrix of fewer: least
    squares, or the shortest step.
    """
    n, m = min(kernel.n, kernel.m), max(kernel.n, kernel.m)
    counted = {**operations, "multiplications": operations.get("multiplications", 0) + m * n * n}
    which = "transposed matrix" if kernel.is_wide else "matrix"
    shown = {
        **values,
        "n": n,
        "last": n - 1,
        "m": m,
        "which": which,
        **_loops_over_columns(n, m),
    }
    return LinearSolver(
        fill("qr.c", shown) + fill("least_norm.c" if kernel.is_wide else "least_squares.c", shown),
        counted,
    )


def _loops_over_columns(n: int, m: int) -> dict[str, object]:
    """Loops over further columns; a single column has none."""
    if n == 1:
        return {"others": "", "above": ""}
    others = [
        f"for (int j = c + 1; j < {n}; ++j) {{",
        "    real r = 0.0;",
        f"    for (int i = 0; i < {m}; ++i) {{",
        f"        r += w->a[{n} * i + c] * w->a[{n} * i + j];",
        "    }",
        f"    w->r[{n} * c + j] = r;",
        f"    for (int i = 0; i < {m}; ++i) {{",
        f"        w->a[{n} * i + j] -= r * w->a[{n} * i + c];",
        "    }",
        "}",
    ]
    above = [
        f"for (int j = c + 1; j < {n}; ++j) {{",
        f"    y[c] -= w->r[{n} * c + j] * s[j];",
        "}",
    ]
    return {"others": others, "above": above}


def dense_statements(
    emitter: Emitter, rows: int, columns: int, target: str, *, transposed: bool = False
) -> list[str]:
    """Statements that fill a row-major array with the function's first output, or with its
    transpose.
    """
    names = indexed(target, rows * columns)
    for i in range(rows):
        for j in range(columns):
            text = emitter.entry(i, j)
            emitter.lines.append(
                f"{names[rows * j + i if transposed else columns * i + j]} = {text};"
            )
    return emitter.lines


def is_unrolled(kernel: Kernel, *, compact: bool) -> bool:
    """Whether the LU is unrolled, with loops as its fallback, rather than loops alone."""
    return kernel.is_square and kernel.n <= UNROLLED and not compact


def factor_calls(kernel: Kernel, k: str, *, compact: bool = False) -> list[str]:
    """How the driver gets its factors: unrolled with the pivoting fallback, of which the statements
    come behind the call, pivoting loops, or QR.
    """
    if is_unrolled(kernel, compact=compact):
        second = ["if (turn == 0) {", f"    turn = {k}_pivoted(GEOMETRY w);", "}"]
        return [f"{k}_factor(GEOMETRY w)", *second]
    return [f"{k}_{'pivoted' if kernel.is_square else 'factor'}(GEOMETRY w)"]


def singular_condition(kernel: Kernel, k: str, work: str, *, compact: bool = False) -> str:
    """C condition that factorises: the matrix is singular."""
    if not kernel.is_square:
        return f"{k}_factor(GEOMETRY {work}) == 0"
    pivoted = f"{k}_pivoted(GEOMETRY {work}) == 0"
    return (
        f"({k}_factor(GEOMETRY {work}) == 0) && ({pivoted})"
        if is_unrolled(kernel, compact=compact)
        else pivoted
    )
