"""Evaluate numbers written as arithmetic in mechanism files: "240/sqrt(3)", "pi/6".

    sum     = product (("+" | "-") product)*
    product = factor (("*" | "/") factor)*
    factor  = ("+" | "-") factor | power
    power   = atom ["^" factor]
    atom    = number | "pi" | name | "(" sum ")" | ("sqrt" | "sin" | "cos" | "tan") "(" sum ")"

Numbers are decimal, in ASCII: 12, 0.5, .5, 5., 1e-3; no digit groups, no leading zeros, no inf, no
nan. Names are those of parameters. Spaces and tabs separate.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping

from symkin.errors import MechanismError
from symkin.text import first_of, meant, shown

_ALLOWED = "numbers, + - * / ^ ( ), sqrt, sin, cos, tan, pi"
_LONGEST = 200
"""Characters of an expression, which bounds the depth of its brackets too."""
_DECIMAL = r"(?:0|[1-9][0-9]*)(?:\.[0-9]*)?(?:[eE][-+]?[0-9]+)?|\.[0-9]+(?:[eE][-+]?[0-9]+)?"
_NUMBER = re.compile(rf"[-+]?(?:{_DECIMAL})")
_TOKEN = re.compile(rf"[ \t]*((?:{_DECIMAL})(?![0-9.])|[-+*/^()]|[A-Za-z_][A-Za-z0-9_]*)[ \t]*")
_NAME = re.compile("[A-Za-z_][A-Za-z0-9_]*")
_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
}
_SIGNS: dict[str, Callable[[float, float], float]] = {"+": operator.add, "-": operator.sub}
_TIMES: dict[str, Callable[[float, float], float]] = {"*": operator.mul, "/": operator.truediv}


def evaluate(text: str, angle_unit: str, parameters: Mapping[str, float] | None = None) -> float:
    """Value of an arithmetic expression; trigonometric functions take their argument in
    `angle_unit`. `parameters` are the numbers that have names.

    Raises MechanismError for anything else than numbers, + - * / ^ ( ), sqrt, sin, cos, tan, pi and
    these names.
    """
    try:
        factor = math.pi / 180 if angle_unit == "deg" else 1.0
        return _Parser(text, factor, parameters or {}).value()
    except _UnknownNameError as error:
        known = list(parameters or ())
        raise MechanismError(
            f"{shown(text)} is no arithmetic: {error} is no parameter{meant(str(error), known)}; "
            f"allowed: {_ALLOWED}, and the parameters {first_of(known)}"
        ) from None
    except _NoArithmeticError:
        longer = f", to {_LONGEST} characters" if len(text) > _LONGEST else ""
        raise MechanismError(
            f"{shown(text)} is no arithmetic; allowed: {_ALLOWED}{longer}"
        ) from None
    except (ArithmeticError, ValueError) as error:
        raise MechanismError(f"{shown(text)} has no value ({error})") from None
    except _NotFiniteError:
        raise MechanismError(f"{shown(text)} is not finite") from None


def parameter_fault(name: str) -> str | None:
    """Why expressions cannot have a parameter of this name; None where they can."""
    if name in (*_FUNCTIONS, "sqrt", "pi"):
        return f"{name} has a meaning in arithmetic; another name is needed"
    if _NAME.fullmatch(name) is None:
        return (
            "the name of a parameter has letters, digits and _ in ASCII, and begins with no digit"
        )
    return None


def plain_number(text: str) -> float | None:
    """The value of a decimal number with or without a sign; None for any other text. What is too
    large is infinite.
    """
    stripped = text.strip(" \t\r\n")
    return float(stripped) if _NUMBER.fullmatch(stripped) else None


class _NoArithmeticError(Exception):
    pass


class _UnknownNameError(Exception):
    pass


class _NotFiniteError(Exception):
    pass


class _Parser:
    """One expression, read from left to right; `factor` turns its angles into radians."""

    def __init__(self, text: str, factor: float, parameters: Mapping[str, float]) -> None:
        self.tokens = _tokens(text)
        self.factor, self.parameters = factor, parameters

    def value(self) -> float:
        result = self._sum()
        if self.tokens:
            raise _NoArithmeticError
        return result

    def _next(self, *allowed: str) -> str | None:
        """Take the next token if it is allowed."""
        return self.tokens.pop() if self.tokens and self.tokens[-1] in allowed else None

    def _need(self, token: str) -> None:
        if self._next(token) is None:
            raise _NoArithmeticError

    def _sum(self) -> float:
        return self._left_to_right(self._product, _SIGNS)

    def _product(self) -> float:
        return self._left_to_right(self._signed, _TIMES)

    def _left_to_right(
        self, operand: Callable[[], float], operations: dict[str, Callable[[float, float], float]]
    ) -> float:
        result = operand()
        while (sign := self._next(*operations)) is not None:
            result = _finite(operations[sign](result, operand()))
        return result

    def _signed(self) -> float:
        sign = self._next("+", "-")
        if sign is None:
            return self._power()
        return -self._signed() if sign == "-" else self._signed()

    def _power(self) -> float:
        base = self._atom()
        return base if self._next("^") is None else _finite(math.pow(base, self._signed()))

    def _atom(self) -> float:
        if not self.tokens:
            raise _NoArithmeticError
        token = self.tokens.pop()
        if _NUMBER.fullmatch(token):
            return _finite(float(token))
        if token == "pi":
            return math.pi
        if token == "(":
            return self._bracketed()
        if token in self.parameters:
            return self.parameters[token]
        if token != "sqrt" and token not in _FUNCTIONS:
            is_name = self.parameters and token.isidentifier()
            raise _UnknownNameError(token) if is_name else _NoArithmeticError
        self._need("(")
        argument = self._bracketed()
        return _finite(
            math.sqrt(argument) if token == "sqrt" else _FUNCTIONS[token](argument * self.factor)
        )

    def _bracketed(self) -> float:
        """The rest of a sum in brackets."""
        result = self._sum()
        self._need(")")
        return result


def _tokens(text: str) -> list[str]:
    """Numbers, names and signs, the first one last."""
    stripped = text.strip(" \t\r\n")
    if len(text) > _LONGEST:
        raise _NoArithmeticError
    found, place = [], 0
    while place < len(stripped):
        match = _TOKEN.match(stripped, place)
        if match is None:
            raise _NoArithmeticError
        found.append(match[1])
        place = match.end()
    return found[::-1]


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise _NotFiniteError
    return value
