"""What rows of a study say: expressions as a line of text, and what a list of modes is worth.

Every row of a closure is written as a reader would write it, numbers rounded for print."""

from __future__ import annotations

import casadi as ca
import numpy as np

from symkin import Modes

SHOWN = 6
"""Significant digits of a printed number."""
NOISE = 1e-12
"""Constants below this, relative to the row's largest, are rounding of cos(90 deg) and the like,
and are left out.
"""
_FUNCTIONS = {
    ca.OP_SIN: "sin",
    ca.OP_COS: "cos",
    ca.OP_TAN: "tan",
    ca.OP_SQRT: "sqrt",
    ca.OP_ATAN2: "atan2",
}
_SUM, _PRODUCT, _ATOM = 1, 2, 3
"""How tightly the outermost operation of a text binds."""


def written(expression: ca.SX) -> str:
    """Write a scalar expression as text; terms with a factor of rounding noise vanish."""
    return _text(expression)[0]


def _text(x: ca.SX) -> tuple[str, int]:
    if x.is_constant():
        value = float(x)
        return (
            f"{0.0 if abs(value) < NOISE else value:.{SHOWN}g}",
            _ATOM if value >= 0 else _PRODUCT,
        )
    if x.is_symbolic():
        return x.name(), _ATOM
    parts = [x.dep(k) for k in range(x.n_dep())]
    operation = x.op()
    if operation in (ca.OP_ADD, ca.OP_SUB):
        return _sum(parts, minus=operation == ca.OP_SUB)
    if operation in (ca.OP_MUL, ca.OP_TWICE):
        return _product(parts if operation == ca.OP_MUL else [ca.SX(2.0), *parts])
    if operation == ca.OP_NEG:
        return _sum([ca.SX(0.0), *parts], minus=True)
    if operation == ca.OP_DIV:
        return f"{_bound(_text(parts[0]), _PRODUCT)} / {_bound(_text(parts[1]), _ATOM)}", _PRODUCT
    if operation == ca.OP_SQ:
        return f"{_bound(_text(parts[0]), _ATOM)}^2", _ATOM
    if operation in _FUNCTIONS:
        return f"{_FUNCTIONS[operation]}({', '.join(_text(p)[0] for p in parts)})", _ATOM
    raise ValueError(f"operation {operation} has no text")


def _sum(parts: list[ca.SX], *, minus: bool) -> tuple[str, int]:
    (left, tight), right = _text(parts[0]), _text(parts[1])
    if right[0] == "0":
        return left, tight
    sign = "-" if minus else "+"
    text = _bound(right, _PRODUCT) if minus else right[0]
    if text.startswith("-"):
        sign, text = ("+" if minus else "-"), text[1:]
    if left == "0":
        return (text if sign == "+" else f"-{text}"), _SUM
    return f"{left} {sign} {text}", _SUM


def _product(parts: list[ca.SX]) -> tuple[str, int]:
    texts = [_text(p) for p in parts]
    if any(text == "0" for text, _ in texts):
        return "0", _ATOM
    texts = [t for t in texts if t[0] != "1"] or texts[:1]
    if len(texts) == 1:
        return texts[0]
    shown = [_bound(t, _PRODUCT) for t in texts]
    minus = sum(text.startswith("-") for text in shown) % 2
    return "-" * minus + " ".join(text.removeprefix("-") for text in shown), _PRODUCT


def _bound(part: tuple[str, int], tightness: int) -> str:
    """Put in brackets where the operation around binds more tightly."""
    text, own = part
    return f"({text})" if own < tightness else text


# --- lists of modes -------------------------------------------------------------------------------


def statement(found: Modes) -> str:
    """State completeness as the result itself states it: `proved: 40 complex solutions, 40 real, 40
    certified, 0 paths unresolved`.
    """
    complex_count = "unknown number of" if found.complex_count is None else str(found.complex_count)
    unresolved = (
        "no paths"
        if found.unresolved_paths is None
        else f"{found.unresolved_paths} paths unresolved"
    )
    return (
        f"{found.completeness}: {complex_count} complex solutions, {len(found)} real, "
        f"{certified(found)} certified, {unresolved}"
    )


def certified(found: Modes) -> int:
    """Count the modes that carry a certificate."""
    return sum(mode.certified is True for mode in found)


def largest_radius(found: Modes) -> float | None:
    """Return the largest radius within which a certificate places its mode, length unit; None
    without certificates.
    """
    return max((mode.radius for mode in found if mode.radius is not None), default=None)


def largest_residual(found: Modes) -> float | None:
    return max((mode.residual for mode in found), default=None)


def distances(found: Modes, size: float) -> np.ndarray:
    """Return the largest difference (n, n) of two modes' positions and, times `size`, rotation
    matrices; infinite on the diagonal.
    """
    rows = np.array([[*mode.position, *(size * mode.rotation.ravel())] for mode in found]).reshape(
        len(found), 12
    )
    apart = np.max(np.abs(rows[:, None] - rows[None]), axis=2, initial=0.0)
    np.fill_diagonal(apart, np.inf)
    return apart
