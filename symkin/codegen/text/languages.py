"""Tables of languages that expressions are printed in: JavaScript, Python over NumPy, SymPy and
arrays of any kind, LaTeX.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import casadi as ca

from symkin.codegen.text.graph import CALLS
from symkin.codegen.text.printer import (
    ATOM,
    POWER,
    PRODUCT,
    SIGNED,
    SIGNED_SUM,
    SUM,
    Form,
    Language,
)

ARITHMETIC = {
    ca.OP_ADD: Form("{} + {}", SUM, (SIGNED_SUM, PRODUCT)),
    ca.OP_SUB: Form("{} - {}", SUM, (SIGNED_SUM, PRODUCT)),
    ca.OP_MUL: Form("{} * {}", PRODUCT, (SIGNED, POWER)),
    ca.OP_DIV: Form("{} / {}", PRODUCT, (SIGNED, POWER)),
    ca.OP_NEG: Form("-{}", PRODUCT, (PRODUCT,)),
    ca.OP_SQ: Form("{0} * {0}", PRODUCT, (POWER,)),
    ca.OP_TWICE: Form("{0} + {0}", SUM, (PRODUCT,)),
    ca.OP_INV: Form("1 / {}", PRODUCT, (POWER,)),
}
"""What C, JavaScript and Python share."""
_POWER = Form("{}**{}", POWER, (ATOM, ATOM))


def calls(pattern: str, names: Mapping[str, str]) -> dict[int, Form]:
    """Functions of one argument, and atan2; `names` are a language's own ones."""
    return {
        op: Form(
            f"{pattern.format(names.get(name, name))}({', '.join(['{}'] * count)})",
            ATOM,
            (SIGNED_SUM,) * count,
        )
        for op, name in CALLS.items()
        for count in (1 + (op == ca.OP_ATAN2),)
    }


def _short(value: float) -> str:
    """A number in JavaScript."""
    return "0" if value == 0 else repr(float(value)).removesuffix(".0")


_BELOW = {
    ca.OP_LT: Form("({}<{}?1:0)", ATOM, (SIGNED_SUM,) * 2),
    ca.OP_LE: Form("({}<={}?1:0)", ATOM, (SIGNED_SUM,) * 2),
    ca.OP_NOT: Form("({}?0:1)", ATOM, (SIGNED_SUM,)),
    ca.OP_IF_ELSE_ZERO: Form("({}?{}:0)", ATOM, (SIGNED_SUM,) * 2),
    ca.OP_FMAX: Form("Math.max({},{})", ATOM, (SIGNED_SUM,) * 2),
}
JAVASCRIPT = Language(
    {
        op: Form(form.pattern.replace(" ", ""), form.level, form.needed)
        for op, form in (ARITHMETIC | calls("Math.{}", {"fabs": "abs"})).items()
    }
    | _BELOW,
    _short,
    statement="const {name}={text};",
    nested=False,
)


def python_language(
    module: str, names: Mapping[str, str], prefix: str, statement: str = "{name} = {text}"
) -> Language:
    """Python over a module's functions; `names` are those that the module calls otherwise than C
    does.
    """
    own = {
        ca.OP_SQ: Form("{}**2", POWER, (ATOM,)),
        ca.OP_TWICE: Form("2 * {}", PRODUCT, (POWER,)),
        ca.OP_POW: _POWER,
        ca.OP_CONSTPOW: _POWER,
    }
    return Language(
        ARITHMETIC | own | calls(f"{module}.{{}}", names),
        _python_number,
        name=f"{prefix}{{}}",
        statement=statement,
        first=1,
        longest=90,
    )


NUMPY_NAMES = {
    "asin": "arcsin",
    "acos": "arccos",
    "atan": "arctan",
    "atan2": "arctan2",
    "fabs": "abs",
}
SYMPY_NAMES = {"fabs": "Abs"}
ARRAY_NAMES = {"fabs": "abs"}
"""Names of the array API standard."""


def _python_number(value: float) -> str:
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


_TEX_POWER = Form("{}^{{{}}}", POWER, (ATOM, SIGNED_SUM))
_TEX = {
    op: Form(rf"\{name}\left({{}}\right)", POWER, (SIGNED_SUM,))
    for op, name in {
        ca.OP_SIN: "sin",
        ca.OP_COS: "cos",
        ca.OP_TAN: "tan",
        ca.OP_ASIN: "arcsin",
        ca.OP_ACOS: "arccos",
        ca.OP_ATAN: "arctan",
        ca.OP_EXP: "exp",
        ca.OP_LOG: "ln",
    }.items()
} | {
    ca.OP_ADD: Form("{} + {}", SUM, (SIGNED_SUM, SUM)),
    ca.OP_SUB: Form("{} - {}", SUM, (SIGNED_SUM, PRODUCT)),
    ca.OP_MUL: Form(r"{} \, {}", PRODUCT, (SIGNED, PRODUCT)),
    ca.OP_DIV: Form(r"\frac{{{}}}{{{}}}", POWER, (SIGNED_SUM, SIGNED_SUM)),
    ca.OP_SQ: Form("{}^2", POWER, (ATOM,)),
    ca.OP_NEG: Form("-{}", PRODUCT, (PRODUCT,)),
    ca.OP_TWICE: Form(r"2 \, {}", PRODUCT, (PRODUCT,)),
    ca.OP_SQRT: Form(r"\sqrt{{{}}}", ATOM, (SIGNED_SUM,)),
    ca.OP_INV: Form(r"\frac{{1}}{{{}}}", POWER, (SIGNED_SUM,)),
    ca.OP_POW: _TEX_POWER,
    ca.OP_CONSTPOW: _TEX_POWER,
    ca.OP_FABS: Form(r"\left|{}\right|", ATOM, (SIGNED_SUM,)),
    ca.OP_ATAN2: Form(r"\operatorname{{atan2}}\left({}, {}\right)", ATOM, (SIGNED_SUM,) * 2),
}


def latex_language(
    letter: str = "v", longest: int | None = None, *, exact: bool = False
) -> Language:
    """LaTeX; numbers to 12 decimals for reading, or with every digit where they are `exact`."""
    return Language(
        _TEX,
        _exact_number if exact else _read_number,
        name=f"{letter}_{{{{{{}}}}}}",
        statement=r"{name} &= {text} \\",
        first=1,
        bracket=r"\left({}\right)",
        finish=_with_dots,
        longest=longest,
        width=_printed_width,
    )


def _with_dots(text: str) -> str:
    """A dot between factors of which the second is a number."""
    return re.sub(r" \\, (?=[\d.])", r" \\cdot ", text)


def _printed_width(text: str) -> int:
    """About the number of characters that are printed."""
    return len(re.sub(r"\\[A-Za-z]+|\\,|[{}_^]", "", text))


def _exact_number(value: float) -> str:
    return _powers_of_ten(f"{value:.15g}" if float(f"{value:.15g}") == value else f"{value:.17g}")


def _read_number(value: float) -> str:
    return _powers_of_ten(
        f"{round(value, 12):.12g}" if abs(value) >= 1e-6 or value == 0 else f"{value:.6g}"
    )


def _powers_of_ten(text: str) -> str:
    if not math.isfinite(float(text)):
        return r"\infty"
    mantissa, _, exponent = text.partition("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else text
