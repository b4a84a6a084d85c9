"""LaTeX of expressions read back as arithmetic."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

_WORDS = {
    r"\left(": "(",
    r"\right)": ")",
    r"\left|": "abs(",
    r"\right|": ")",
    r"\,": "*",
    r"\cdot": "*",
    "^": "**",
    r"\operatorname{atan2}": "atan2",
    r"\arcsin": "asin",
    r"\arccos": "acos",
    r"\arctan": "atan",
    r"\ln": "log",
    r"\sin": "sin",
    r"\cos": "cos",
    r"\tan": "tan",
    r"\exp": "exp",
}


def evaluated(
    definitions: Sequence[tuple[str, str]], texts: Sequence[str], values: Mapping[str, float]
) -> list[float]:
    """Values of `texts` over symbols with `values`, after the definitions (symbol, text) in order;
    what looks alike without braces is one symbol.
    """
    scope = {name: getattr(math, name) for name in dir(math) if not name.startswith("_")} | {
        "abs": abs
    }
    known = {_look(symbol): value for symbol, value in values.items()}
    for symbol, text in definitions:
        assert _look(symbol) not in known, f"{symbol} is defined twice"
        known[_look(symbol)] = _value(text, known, scope)
    return [_value(text, known, scope) for text in texts]


def _look(symbol: str) -> str:
    return re.sub(r"[{}]", "", symbol)


def _value(text: str, known: Mapping[str, float], scope: dict) -> float:
    return eval(_python(text), {"known": known}, scope)


_SYMBOL = re.compile(
    r"(\\mathrm\{(?:[^{}]|\\_)*\}|\\(?:alpha|beta|gamma|delta|theta|phi|psi|rho|omega|nu)(?![a-z])|[A-Za-z])"
    r"(\^\{\\mathrm\{[^{}]*\}\})?(_(\d|\{\d+\}))?"
)


def _python(text: str) -> str:
    found, place = "", 0
    while place < len(text):
        rest = text[place:]
        word = next((w for w in _WORDS if rest.startswith(w)), None)
        symbol = _SYMBOL.match(rest)
        if word is not None:
            found, place = found + _WORDS[word], place + len(word)
        elif rest.startswith(r"\frac"):
            top, end = _group(text, place + 5)
            bottom, place = _group(text, end)
            found += f"(({_python(top)})/({_python(bottom)}))"
        elif rest.startswith(r"\sqrt"):
            inside, place = _group(text, place + 5)
            found += f"sqrt({_python(inside)})"
        elif symbol is not None:
            found, place = found + f"known[{_look(symbol.group())!r}]", place + symbol.end()
        else:
            found, place = found + {"{": "(", "}": ")"}.get(rest[0], rest[0]), place + 1
    return found


def _group(text: str, place: int) -> tuple[str, int]:
    """The braces that begin at a place, and where they end."""
    assert text[place] == "{"
    depth = 0
    for end in range(place, len(text)):
        depth += {"{": 1, "}": -1}.get(text[end], 0)
        if depth == 0:
            return text[place + 1 : end], end + 1
    raise AssertionError("braces do not balance")
