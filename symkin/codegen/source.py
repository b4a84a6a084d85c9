"""C functions of one kernel: work space, rows, factors, step, target and the Newton driver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from string import Template

import numpy as np

from symkin.codegen.emit import Emitter, Real, indent, indexed
from symkin.codegen.factor import GUARD, UNROLLED, Pivots, choose_pivots, dense_statements, rounded, scales, unroll
from symkin.codegen.kernel import Kernel


class _C(Template):
    """Templates of C: @{name}; a name without a value is an error."""

    delimiter = "@"


def fill(template: str, values: Mapping[str, object]) -> str:
    """A file of `templates/` with its names replaced."""
    text = resources.files("symkin.codegen").joinpath("templates", template).read_text(encoding="utf-8")
    return substitute(text, values)


def substitute(text: str, values: Mapping[str, object]) -> str:
    """Text with its names replaced; lines whose name stands for nothing are left out."""
    lines = [(line, _C(line).substitute(values).rstrip()) for line in text.split("\n")]
    return "\n".join(filled for line, filled in lines if filled or not line)


@dataclass(frozen=True)
class Tuning:
    """Constants of the driver: tolerances as lengths, kappa^2 of a typical pose."""

    tolerance: float
    floor: float
    rounding: float
    kappa2: float


@dataclass(frozen=True, eq=False)
class KernelSource:
    """The text of one kernel's functions and what is known of it."""

    kernel: Kernel
    text: str
    operations: dict[str, int]
    pivots: Pivots | None
    tuning: Tuning


def tuning_of(kernel: Kernel, real: Real, kappa: float) -> Tuning:
    """Tolerance near what the type resolves."""
    resolution = real.epsilon * kernel.size
    tolerance = resolution * (1.0 if real.name == "float" else 1e4)
    return Tuning(tolerance, 64.0 * resolution, 64.0 * resolution, kappa**2)


def common_values(name: str, real: Real, struct: bool) -> dict[str, object]:
    """Names that every template knows."""
    return {
        "p": name, "P": name.upper(), "real": real.type,
        "COLD": f"{name.upper()}_COLD", "SHARED": f"{name.upper()}_SHARED",
        "gp": f"const {name}_geometry *geometry, " if struct else "", "ga": "geometry, " if struct else "",
        "use": "    (void)geometry;" if struct else "",
        "fabs": real.call("fabs"), "sqrt": real.call("sqrt"),
        "zero": real.literal(0.0), "one": real.literal(1.0), "two": real.literal(2.0), "four": real.literal(4.0), "half": real.literal(0.5),
        "before": "", "huge": "HUGE_VALF" if real.name == "float" else "HUGE_VAL",
    }  # fmt: skip


def kernel_source(
    kernel: Kernel,
    name: str,
    real: Real,
    geometry: Sequence[str],
    matrices: np.ndarray,
    target: Sequence[str],
    kappa: float,
    *,
    start_aim: str | None = None,
    again: str = "",
    known_count: int | None = None,
    guess: str = "",
    matrix: Sequence[str] = (),
) -> KernelSource:
    """The functions of one kernel, named NAME_KERNEL_...; `target` are statements that set w->k from w->at, to and part;
    `matrix` statements fill w->a, where something shorter than the emitted ones is
    known; `again` is the call that aims anew and puts the state back, where known values at the guess are not kept."""
    struct = bool(geometry)
    tuning = tuning_of(kernel, real, kappa)
    k = f"{name}_{kernel.name}"
    n, m, ns = kernel.n, kernel.m, int(kernel.state.shape[0])
    nk, nd = int(kernel.known.shape[0]), int(kernel.shared_symbols.shape[0])
    inputs = [indexed("w->x", ns), indexed("w->k", nk), list(geometry)]
    literal = real.literal
    aim = f"{k}_target({'geometry, ' if struct else ''}w, to, aim);"
    there = kernel.reads_known and not kernel.is_wide  # shortest steps follow the path more closely by the matrix aimed at
    values = common_values(name, real, struct) | {
        "k": k, "n": n, "n1": n + 1, "m": m, "ns": ns, "nk": nk, "nto": known_count or nk,
        "na": m * n, "most": max(m, n),
        "at": "" if again else f"    {real.type} at[{known_count or nk}]; /* known values at the guess */",
        "shared": f"    {real.type} d[{nd}]; /* what rows and matrix share */" if nd else "",
        "r": "" if kernel.is_square else f"    {real.type} r[{min(m, n) ** 2}]; /* R of QR */",
        **_factor_calls(kernel, k, struct),
        "row_length": literal(kernel.row_length), "rounding": literal(tuning.rounding), "floor2": literal(tuning.floor**2),
        "kappa2": literal(tuning.kappa2), "contraction2": literal(1.0 / 16.0), "careful2": literal(1.0 / 64.0), "settling2": literal(1.0), "quick": literal(400.0),
        "chord2": literal(0.3), "near_one": literal(0.999), "least_part": literal(1.0 / 1024.0), "shrink": literal(0.375),
        "start_aim": start_aim or literal(1.0), "singular": literal(32.0 * real.epsilon),
        "part_of": "" if again else ", aim", "part": "" if again else f", {real.type} part",
        "aimed": "" if again else ": a part of the line from the guess's to `to`", "guard": literal(GUARD**-2),
        "at_done": indent(["if (!judging) {", f"    {aim.replace('aim', 'done')}", "}"], 3) if there else "",
        "at_aim": indent(["if (!judging) {", f"    {aim}", "}"], 3) if there else "",
        "save0": "" if again else indent(copy("w->x0", "w->x", ns)),
        "advance": indent([*_loop("w->x0", "w->x", ns), again or aim], 4),
        "retreat": indent([again] if again else [*_loop("w->x", "w->x0", ns), aim], 3),
        "guess": (f"    {guess}" if guess else "")
        + (f"    {real.type} aim; /* how much of the line to try first */" if start_aim == "w->aim" else ""),
    }  # fmt: skip
    row_emitter = Emitter(kernel.row_function(), inputs, real)
    shared = [(1, i, f"w->d[{i}]") for i in range(nd)]
    row_lines = _stores(row_emitter, [(0, i, f"w->f[{i}]") for i in range(m)], shared)
    move_emitter = Emitter(kernel.move_function(), [inputs[0], indexed("w->f", n), list(geometry)], real)
    moved = [move_emitter.value(0, i) for i in range(ns)]
    norm = move_emitter.value(1, 0)
    move_lines = [*move_emitter.lines, *(f"w->x[{i}] = {text};" for i, text in enumerate(moved)), f"return {norm};"]
    body = substitute(fill_text("functions.c"), values | {
        "residual": indent(_residual(m, real, kernel.row_length)),
        "rows": indent(row_lines), "move": indent(move_lines), "target": indent(target),
    })  # fmt: skip
    jacobian_inputs = [*inputs, indexed("w->d", nd)]
    linear, pivots, counted = _linear(kernel, real, jacobian_inputs, matrices, values, matrix)
    operations = {key: row_emitter.operations[key] + move_emitter.operations[key] + counted.get(key, 0)
                  for key in sorted({*row_emitter.operations, *move_emitter.operations, *counted})}  # fmt: skip
    text = fill("work.c", values) + body + linear + fill("newton.c", values)
    return KernelSource(kernel, text, operations, pivots, tuning)


def _residual(count: int, real: Real, length: float) -> list[str]:
    """A loop in float, where room counts, statements in double, where each is an instruction or two."""
    squares = f"{real.type} sum = w->f[0] * w->f[0];"
    adds = [f"sum += w->f[{i}] * w->f[{i}];" for i in range(1, count)]
    if real.name == "float":
        adds = [f"for (int i = 1; i < {count}; ++i) {{", "    sum += w->f[i] * w->f[i];", "}"]
    root = f"{real.call('sqrt')}(sum)"
    return [squares, *adds, f"return {root};" if length == 1.0 else f"return {root} * {real.literal(length)};"]


def _factor_calls(kernel: Kernel, k: str, struct: bool) -> dict[str, str]:
    """How the driver gets its factors: unrolled with the pivoting fallback, pivoting loops, or QR."""
    ga = "geometry, " if struct else ""
    if kernel.is_square and kernel.n <= UNROLLED:
        second = ["if (turn == 0) {", f"    turn = {k}_pivoted({ga}w);", "}"]
        return {"first_factor": f"{k}_factor({ga}w)", "second_factor": indent(second, 3)}
    return {"first_factor": f"{k}_{'pivoted' if kernel.is_square else 'factor'}({ga}w)", "second_factor": ""}


def factored(kernel: Kernel, k: str, work: str, ga: str = "") -> str:
    """C condition: the matrix is singular."""
    if not kernel.is_square:
        return f"{k}_factor({ga}{work}) == 0"
    pivoted = f"{k}_pivoted({ga}{work}) == 0"
    return pivoted if kernel.n > UNROLLED else f"({k}_factor({ga}{work}) == 0) && ({pivoted})"


def fill_text(template: str) -> str:
    return resources.files("symkin.codegen").joinpath("templates", template).read_text(encoding="utf-8")


def copy(target: str, source: str, count: int) -> list[str]:
    """Statements that copy an array; short ones without a loop."""
    if count <= 8:
        return [f"{target}[{i}] = {source}[{i}];" for i in range(count)]
    return _loop(target, source, count)


def _loop(target: str, source: str, count: int) -> list[str]:
    return [f"for (int i = 0; i < {count}; ++i) {{", f"    {target}[i] = {source}[i];", "}"]


def _stores(emitter: Emitter, first: Sequence[tuple[int, int, str]], shared: Sequence[tuple[int, int, str]]) -> list[str]:
    """Each output made and stored in turn: what is shared as soon as its row has been made."""
    each = len(shared) // max(len(first), 1)
    for number, (output, nonzero, target) in enumerate(first):
        text = emitter.value(output, nonzero)
        emitter.lines.append(f"{target} = {text};")
        for o, k, place in shared[each * number : each * (number + 1)]:
            value = emitter.value(o, k)
            emitter.lines.append(f"{place} = {value};")
    return emitter.lines


def _linear(
    kernel: Kernel,
    real: Real,
    inputs: Sequence[Sequence[str]],
    matrices: np.ndarray,
    values: Mapping[str, object],
    given: Sequence[str],
) -> tuple[str, Pivots | None, dict[str, int]]:
    """Text of factor, solve and min_pivot."""
    function = kernel.jacobian_function()
    dense = Emitter(function, inputs, real)
    matrix = indent(given or dense_statements(dense, kernel.m, kernel.n, "w->a", transposed=kernel.is_wide))
    if not kernel.is_square:
        n, m = min(kernel.n, kernel.m), max(kernel.n, kernel.m)
        counted = {**dense.operations, "multiplications": dense.operations["multiplications"] + m * n * n}
        shown = {**values, "n": n, "m": m, "matrix": matrix, "which": "transposed matrix" if kernel.is_wide else "matrix"}
        solve = fill("least_norm.c" if kernel.is_wide else "least_squares.c", {**shown, **_qr_loops(n, m, real)})
        return fill("qr.c", {**shown, **_qr_loops(n, m, real)}) + solve, None, counted
    _, column_scale = scales(matrices)
    text = fill("pivoted.c", {**values, "matrix": matrix,
                              "column_scales": ", ".join(real.literal(rounded(float(s))) for s in column_scale)})  # fmt: skip
    if kernel.n > UNROLLED:
        counted = {**dense.operations, "multiplications": dense.operations["multiplications"] + kernel.n**3 // 3}
        return text + "\n" + fill("looped.c", values), None, counted
    pivots = choose_pivots(matrices)
    unrolled = unroll(kernel, Emitter(function, inputs, real), pivots)
    factor = [substitute(line, values) for line in unrolled.factor]
    text += "\n" + fill("unrolled.c", {**values, "factor": indent(factor), "solve": indent(unrolled.solve),
                                       "sign": ">" if pivots.parity > 0 else "<"})  # fmt: skip
    return text, pivots, unrolled.operations


def _qr_loops(n: int, m: int, real: Real) -> dict[str, str]:
    """Loops over further columns; a single column has none."""
    if n == 1:
        return {"others": "", "above": ""}
    others = [
        f"for (int j = c + 1; j < {n}; ++j) {{", f"    {real.type} r = {real.literal(0.0)};", f"    for (int i = 0; i < {m}; ++i) {{",
        f"        r += w->a[{n} * i + c] * w->a[{n} * i + j];", "    }", f"    w->r[{n} * c + j] = r;",
        f"    for (int i = 0; i < {m}; ++i) {{", f"        w->a[{n} * i + j] -= r * w->a[{n} * i + c];", "    }", "}",
    ]  # fmt: skip
    above = [f"for (int j = c + 1; j < {n}; ++j) {{", f"    y[c] -= w->r[{n} * c + j] * w->f[j];", "}"]
    return {"others": indent(others, 2), "above": indent(above, 2)}
