"""Numbers written as arithmetic in mechanism files: "240/sqrt(3)", "pi/6"."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable

from symkin.errors import MechanismError

_ALLOWED = "numbers, + - * / ^ ( ), sqrt, sin, cos, tan, pi"
_BINARY: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,
}
_UNARY: dict[type, Callable[[float], float]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}


def evaluate(text: str, angle_unit: str) -> float:
    """Value of an arithmetic expression; trigonometric functions take their argument in `angle_unit`.

    Raises MechanismError for anything else than numbers, + - * / ^ ( ), sqrt, sin, cos, tan and pi.
    """
    factor = math.pi / 180 if angle_unit == "deg" else 1.0
    functions: dict[str, Callable[[float], float]] = {
        "sqrt": math.sqrt,
        "sin": lambda v: math.sin(v * factor),
        "cos": lambda v: math.cos(v * factor),
        "tan": lambda v: math.tan(v * factor),
    }

    def value(node: ast.AST) -> float:
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return float(number)
            case ast.Name(id="pi"):
                return math.pi
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
                return _BINARY[type(op)](value(left), value(right))
            case ast.UnaryOp(op=op, operand=operand) if type(op) in _UNARY:
                return _UNARY[type(op)](value(operand))
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in functions:
                return functions[name](value(argument))
        raise MechanismError(f"{text!r} is no arithmetic; allowed: {_ALLOWED}")

    if "**" in text or "_" in text or len(text) > 200:
        raise MechanismError(f"{text!r} is no arithmetic; allowed: {_ALLOWED}")
    try:
        result = value(ast.parse(text.strip().replace("^", "**"), mode="eval").body)
    except (SyntaxError, RecursionError, MemoryError):
        raise MechanismError(f"{text!r} is no arithmetic; allowed: {_ALLOWED}") from None
    except (ArithmeticError, ValueError) as error:
        raise MechanismError(f"{text!r} has no value ({error})") from None
    if not math.isfinite(result):
        raise MechanismError(f"{text!r} is not finite")
    return result
