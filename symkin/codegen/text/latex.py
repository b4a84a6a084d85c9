"""Write expressions and closure equations as LaTeX."""

from __future__ import annotations

import re
from collections.abc import Sequence

import casadi as ca

from symkin.closure.closure import Closure, algebraic_rows, build_closure
from symkin.closure.snapping import snapped_expression
from symkin.codegen.text.gathered import gathered
from symkin.codegen.text.languages import latex_language
from symkin.codegen.text.printer import Printer
from symkin.model.mechanism import Mechanism
from symkin.text import ascii_letters, latex_text, printable

_GREEK = ("alpha", "beta", "gamma", "delta", "theta", "phi", "psi", "rho", "omega")


def equations(mechanism: Mechanism) -> str:
    """The closure equations of a mechanism, geometry as numbers: a compilable LaTeX fragment
    (amsmath).
    """
    closure = build_closure(mechanism)
    # a sum of lengths leaves the rounding of lengths
    scale = max(1.0, closure.characteristic_length)
    snapped = snapped_expression(_in_user_scale(closure), [closure.variables], scale)
    (rows,) = gathered([snapped], [closure.variables], [])
    names = coordinate_symbols(closure)
    definitions, results = write(rows, closure.variables, names)
    norms = [closure.slices[c.name] for c in closure.coordinates if c.is_rotation]
    lines = [f"% closure of {mechanism.name}: lengths in {mechanism.length_unit}, angles in rad"]
    lines += [
        f"% {symbol} is {printable(name)}"
        for symbol, name in renamed(names, variable_names(closure))
    ]
    if definitions:
        lines += [r"\begin{align*}", *definitions, r"\end{align*}"]
    lines.append(r"\begin{align*}")
    for row, text in zip(closure.row_sources, results, strict=True):
        lines.append(rf"0 &= {text} && \text{{{latex_text(row.limb)}: {row.relation}}} \\")
    for place in norms:
        lines.append(
            "0 &= "
            + " + ".join(f"{name}^2" for name in names[place])
            + r" - 1 && \text{unit quaternion} \\"
        )
    return "\n".join([*lines, r"\end{align*}"])


def document(body: str) -> str:
    """A document that compiles on its own around a fragment."""
    return "\n".join(
        [
            r"\documentclass{article}",
            r"\usepackage{amsmath}",
            r"\usepackage[a4paper, margin=15mm]{geometry}",
            r"\begin{document}",
            r"\allowdisplaybreaks",
            body,
            r"\end{document}",
        ]
    )


def symbol_name(name: str, component: int | None = None) -> str:
    """LaTeX symbol of a coordinate: `pose.x` is x, `theta1` is theta with subscript 1, a quaternion
    has e_0..e_3.
    """
    short = ascii_letters(name.removeprefix("pose."))
    if component is not None:
        return (
            f"e_{component}"
            if short == "quaternion"
            else rf"e^{{\mathrm{{{upright(short)}}}}}_{component}"
        )
    match = re.fullmatch(r"([A-Za-z]+?)_?([0-9]+)", short)
    stem, index = match.groups() if match else (short, "")
    head = (
        rf"\{stem}"
        if stem in _GREEK
        else stem
        if re.fullmatch("[A-Za-z]", stem)
        else rf"\mathrm{{{upright(stem)}}}"
    )
    return f"{head}_{{{index}}}" if index else head


def variable_names(closure: Closure) -> list[tuple[str, int | None]]:
    """For each of a closure's variables the name of its coordinate, and which component of a
    quaternion it is."""
    return [
        (c.name, k if c.width > 1 else None) for c in closure.coordinates for k in range(c.width)
    ]


def coordinate_symbols(closure: Closure) -> list[str]:
    """A symbol for each of a closure's variables, no two alike."""
    parts = variable_names(closure)
    return distinct(
        [symbol_name(*part) for part in parts],
        [name if k is None else f"{name}.{k}" for name, k in parts],
    )


def renamed(
    symbols: Sequence[str], parts: Sequence[tuple[str, int | None]]
) -> list[tuple[str, str]]:
    """The symbols that do not tell their coordinate's name, with this name: of names that look
    alike, or with signs that no symbol has."""
    found = []
    for symbol, (name, k) in zip(symbols, parts, strict=False):
        short = name.removeprefix("pose.")
        if symbol != symbol_name(name, k) or not re.fullmatch(r"[A-Za-z0-9_.]+", short):
            found.append((symbol, short if k is None else f"{short}, component {k}"))
    return found


def distinct(symbols: Sequence[str], full: Sequence[str]) -> list[str]:
    """The symbols, but upright the `full` name of one that looks like one before it: `theta1` and
    `theta_1` have one symbol.
    """
    found: dict[str, str] = {}
    for symbol, name in zip(symbols, full, strict=True):
        while _look(symbol) in found:
            symbol = rf"\mathrm{{{upright(name)}}}"
            name += "_"
        found[_look(symbol)] = symbol
    return list(found.values())


def upright(name: str) -> str:
    """A name in a symbol, where signs and spaces would be mathematics."""
    return latex_text(re.sub(r"[^A-Za-z0-9_.]", "_", ascii_letters(name)))


def _look(symbol: str) -> str:
    """What tells symbols apart on paper: braces are not seen."""
    return re.sub(r"[{}]", "", symbol)


def letter_of_values(symbols: Sequence[str]) -> str:
    """The letter of numbered intermediate values, one that no symbol with an index has."""
    return r"\nu" if any(symbol.startswith("v_") for symbol in symbols) else "v"


def write(expression: ca.SX, variables: ca.SX, names: Sequence[str]) -> tuple[list[str], list[str]]:
    """Lines that name intermediate values, in order, and the text of each entry of a column of
    `variables`.
    """
    function = ca.Function("f", [variables], [ca.densify(expression)], {"cse": True})
    printer = Printer(function, [names], latex_language(letter_of_values(names)))
    printer.entries()
    return printer.lines, [printer.value(0, k) for k in range(expression.numel())]


def _in_user_scale(closure: Closure) -> ca.SX:
    """Rows as a reader expects them: distances as d.d - l^2, orientation without the factor of the
    size.
    """
    factor = {"distance": 2 * closure.characteristic_length, "point": 1.0, "line": 1.0}
    scaled = [
        factor.get(row.relation, 1 / closure.characteristic_length) for row in closure.row_sources
    ]
    for k, row in enumerate(closure.row_sources):
        if row.relation == "frame" and k % 6 < 3 and _is_position_row(closure, k):
            scaled[k] = 1.0
    rows = algebraic_rows(closure).rows
    return ca.vertcat(*(f * rows[k] for k, f in enumerate(scaled)))


def _is_position_row(closure: Closure, k: int) -> bool:
    """The first three of a limb's six frame rows."""
    first = next(i for i, row in enumerate(closure.row_sources) if row == closure.row_sources[k])
    return k - first < 3
