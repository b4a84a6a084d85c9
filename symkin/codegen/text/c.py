"""Print CasADi functions as straight-line, single-assignment C of one type of numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.snapping import snapped_expression
from symkin.codegen.text.languages import ARITHMETIC, calls
from symkin.codegen.text.printer import POWER, PRODUCT, Form, Language, Printer
from symkin.errors import InputError
from symkin.text import c_comment

_PLAIN = re.compile(
    r'/\*.*?\*/|"[^"\n]*"|(?<![\w.])\d+\.\d+(?:e[-+]?\d+)?(?!\w)|(?<![\w.])\d+e[-+]?\d+(?!\w)'
    r"|(?<![\w>])(?:(?:fabs|sqrt|sin|cos|atan2)(?=\()|(?:HUGE_VAL|real|inf|nan)\b"
    r"|(?:name|NAME)(?=_)|GEOMETRY(?:_GIVEN)? )",
    re.S,
)
"""Comments and strings; numbers, functions and the infinity of doubles; names that stand for
others.
"""


@dataclass(frozen=True)
class Real:
    """The C type of numbers: `name` is float or double, `type` what the generated file calls it."""

    name: str
    type: str = "real"

    @property
    def suffix(self) -> str:
        return "f" if self.name == "float" else ""

    @property
    def epsilon(self) -> float:
        """Half a unit in the last place of 1."""
        return 2.0**-24 if self.name == "float" else 2.0**-53

    @property
    def least(self) -> float:
        """The least normal number."""
        return 2.0**-126 if self.name == "float" else 2.0**-1022

    @property
    def zero(self) -> str:
        return self.literal(0.0)

    @property
    def one(self) -> str:
        return self.literal(1.0)

    def call(self, function: str) -> str:
        return function + self.suffix

    def literal(self, value: float) -> str:
        """The shortest decimal that reads back as the same number of this type. Raises InputError
        for a number that the type does not hold: infinity, or what is none.
        """
        with np.errstate(over="ignore"):
            number = np.float32(value) if self.name == "float" else np.float64(value)
        if not np.isfinite(number):
            remedy = "use --real double" if self.name == "float" else "use another length unit"
            raise InputError(
                f"the code would hold the number {value:.3g}, which is no finite {self.name}; "
                f"{remedy}, or another reference configuration"
            )
        text = str(number)
        if not any(mark in text for mark in ".e"):
            text += ".0"
        return text + self.suffix

    def typed(self, text: str, name: str, *, struct: bool) -> str:
        """C text of the machine of a name, with names, numbers and functions of math.h of this type
        in the places of name_, NAME_, real and what doubles have; comments, strings, and what has
        them already, stay. A `struct` of its geometry is an argument where GEOMETRY stands.
        """
        own = {"real": self.type, "name": name, "NAME": name.upper()} | {
            "GEOMETRY ": "geometry, " if struct else "",
            "GEOMETRY_GIVEN ": f"const {name}_geometry *geometry, " if struct else "",
        }

        begun = (f"{name}_", f"{name.upper()}_") if name.lower().startswith("name_") else ()

        def word(found: re.Match[str]) -> str:
            told = found[0]
            if told[0] in '/"' or found.string.startswith(begun, found.start()):
                return told
            if told in own:
                return own[told]
            if told in ("inf", "nan"):
                return self.literal(float(told))
            if self.name == "double":
                return told
            if told == "atan2":
                return f"{name}_angle"
            return self.literal(float(told)) if told[0].isdigit() else told + "fF"[told.isupper()]

        return _PLAIN.sub(word, text)

    def hexadecimal(self, value: float) -> str:
        """The exact bits of the rounded value, for test vectors."""
        if math.isnan(value):
            return "NAN"
        if math.isinf(value):
            return "INFINITY" if value > 0 else "-INFINITY"
        rounded = float(np.float32(value)) if self.name == "float" else float(value)
        return rounded.hex() + self.suffix


def c_language(real: Real, prefix: str) -> Language:
    """C99 with numbers of a type, an operation a statement."""
    inverse = {ca.OP_INV: Form(f"{real.one} / {{}}", PRODUCT, (POWER,))}
    return Language(
        ARITHMETIC | inverse | calls("{}" + real.suffix, {}),
        real.literal,
        name=f"{prefix}{{}}",
        statement=f"const {real.type} {{name}} = {{text}};",
        nested=False,
        folds_signs=False,
        shares_reciprocals=True,
    )


class Emitter(Printer):
    """Printer of C; `prefix` begins the names of temporaries."""

    def __init__(
        self,
        function: ca.Function,
        inputs: Sequence[Sequence[str] | str],
        real: Real,
        prefix: str = "t",
    ) -> None:
        super().__init__(function, inputs, c_language(real, prefix))
        self.real = real

    @classmethod
    def of(
        cls,
        real: Real,
        inputs: Sequence[tuple[ca.SX, Sequence[str] | str]],
        *outputs: ca.SX,
        prefix: str = "t",
    ) -> Emitter:
        """The emitter of expressions of symbols, beside which stand their texts in C, or the array
        that holds them; without rounding noise of their constants.
        """
        symbols = [symbol for symbol, _ in inputs]
        told = [ca.densify(snapped_expression(ca.densify(e), symbols)) for e in outputs]
        function = ca.Function("f", symbols, told, {"cse": True})
        return cls(function, [texts for _, texts in inputs], real, prefix)

    def stored(self, targets: Sequence[str] | str, output: int = 0) -> list[str]:
        """Add statements that set `targets`, or an array of this name, to the entries of an output;
        all that have not been taken.
        """
        texts = self.values(output)
        if isinstance(targets, str):
            targets = indexed(targets, len(texts))
        self.lines += [f"{target} = {text};" for target, text in zip(targets, texts, strict=True)]
        return self.take()

    def root(
        self, number: int, square: str, least: str, other: str, *, about: str = "", sign: str = ""
    ) -> str:
        """Add statements of the root r1, ... of a square d1, ..., times a `sign`; `other` in place
        of it where the square is not above `least`: that condition. `about`: the coordinate that
        has two values. A root that no output reads is asked for alone.
        """
        told = f" /* above 0 where {c_comment(about)} has two values */" if about else ""
        kind, d, above = self.real.type, f"d{number}", f"(d{number} > {least})"
        root = f"{above} ? {self.real.call('sqrt')}({d}) : {other}"
        self.lines.append(f"const {kind} {d} = {square};{told}")
        if self.reads(f"r{number}"):
            self.lines.append(f"const {kind} r{number} = {f'{sign} * ({root})' if sign else root};")
        return above

    def comment(self, text: str) -> None:
        """Add a line of comment, whatever text it is; names of temporaries do not count it."""
        self.remark(f"/* {c_comment(text)} */")


def indexed(name: str, count: int, first: int = 0) -> list[str]:
    """Name consecutive array elements in C."""
    return [f"{name}[{k}]" for k in range(first, first + count)]


def indent(lines: Sequence[str], depth: int = 1) -> str:
    """Join lines, indented by four spaces a level."""
    return "\n".join("    " * depth + line if line else "" for line in lines)


def block(head: str, lines: Sequence[str], otherwise: Sequence[str] = ()) -> list[str]:
    """Write a statement with a body in braces, and one behind else where there is some."""
    then = [f"{head} {{", *(f"    {line}" for line in lines)]
    return [*then, *block("} else", otherwise)] if otherwise else [*then, "}"]


def if_ok(lines: Sequence[str]) -> list[str]:
    """Write statements under the condition that nothing has been refused before."""
    return block("if (status == NAME_OK)", lines)


def refused(condition: str, status: str, lines: Sequence[str] = ()) -> list[str]:
    """Write statements under a condition, without which a status is set; no condition: as they
    are.
    """
    if not condition:
        return list(lines)
    return block(f"if (!({condition}))", [f"status = NAME_{status};"], lines)


def indented_by_braces(lines: Sequence[str]) -> list[str]:
    """Indent lines by the braces that are open before them."""
    depth, found = 0, []
    for line in lines:
        depth -= line.startswith("}")
        found.append("    " * depth + line)
        depth += line.endswith("{")
    return found
