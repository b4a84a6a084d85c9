"""Write expressions as text of another language: one walk over the graph, and what differs from language to language.

What is used more than once gets a name, and so do parts of what grows longer than the language likes; the rest is written in
place.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import casadi as ca

from symkin.closure.graph import instructions

ATOM, POWER, PRODUCT, SUM = 3, 2, 1, 0
"""How tightly a text binds."""


@dataclass(frozen=True)
class Text:
    """The text of a subexpression and how tightly it binds."""

    text: str
    level: int


class Language(Protocol):
    """The texts of operations and constants; `longest` is the `width` of a text beyond which parts of it get names."""

    @property
    def longest(self) -> int | None: ...
    def width(self, text: str) -> int: ...
    def operation(self, op: int, values: Sequence[Text]) -> Text: ...
    def constant(self, value: float) -> Text: ...
    def temporary(self, number: int) -> str: ...


def write(function: ca.Function, names: Sequence[str], language: Language) -> tuple[list[tuple[str, str]], list[str]]:
    """Named intermediate values, in order, and the text of each entry of the dense first output (column by column). `names`
    are the texts of all inputs' entries, input after input."""
    starts = [sum(function.numel_in(k) for k in range(i)) for i in range(function.n_in())]
    uses = _use_counts(function)
    slots: dict[int, Text] = {}
    definitions: list[tuple[str, str]] = []

    def named(text: str) -> Text:
        definitions.append((language.temporary(len(definitions) + 1), text))
        return Text(definitions[-1][0], ATOM)

    results = [language.constant(0.0).text] * int(function.numel_out(0))
    for k, (op, inputs, outputs, constant) in enumerate(instructions(function)):
        if op == ca.OP_OUTPUT:
            results[outputs[1]] = slots[inputs[0]].text
            continue
        if op == ca.OP_INPUT:
            value = Text(names[starts[inputs[0]] + inputs[1]], ATOM)
        elif op == ca.OP_CONST:
            value = language.constant(constant)
        else:
            value = language.operation(op, [slots[i] for i in inputs])
            while language.longest is not None and language.width(value.text) > language.longest:
                part = max(inputs, key=lambda i: language.width(slots[i].text))
                if language.width(slots[part].text) <= language.width(language.temporary(len(definitions) + 1)):
                    break
                slots[part] = named(slots[part].text)
                value = language.operation(op, [slots[i] for i in inputs])
            if uses[k] > 1:
                value = named(value.text)
        slots[outputs[0]] = value
    return definitions, results


def _use_counts(function: ca.Function) -> Counter[int]:
    """How often the result of each instruction is read."""
    counts: Counter[int] = Counter()
    writer: dict[int, int] = {}
    for k, (op, inputs, outputs, _) in enumerate(instructions(function)):
        if op not in (ca.OP_INPUT, ca.OP_CONST):
            for slot in inputs[:1] if op == ca.OP_OUTPUT else inputs:
                counts[writer[slot]] += 1
        if op != ca.OP_OUTPUT:
            writer[outputs[0]] = k
    return counts


_PYTHON: dict[int, tuple[str, int, tuple[int, ...]]] = {
    ca.OP_ADD: ("{0} + {1}", SUM, (SUM, PRODUCT)),
    ca.OP_SUB: ("{0} - {1}", SUM, (SUM, PRODUCT)),
    ca.OP_MUL: ("{0} * {1}", PRODUCT, (PRODUCT, POWER)),
    ca.OP_DIV: ("{0} / {1}", PRODUCT, (PRODUCT, POWER)),
    ca.OP_NEG: ("-{0}", PRODUCT, (PRODUCT,)),
    ca.OP_SQ: ("{0}**2", POWER, (ATOM,)),
    ca.OP_TWICE: ("2 * {0}", PRODUCT, (POWER,)),
    ca.OP_INV: ("1 / {0}", PRODUCT, (POWER,)),
    ca.OP_POW: ("{0}**{1}", POWER, (ATOM, ATOM)),
    ca.OP_CONSTPOW: ("{0}**{1}", POWER, (ATOM, ATOM)),
}
"""Operations of Python: the text, how tightly it binds, and how tightly its operands must."""

_SIGNS = {ca.OP_ADD: ca.OP_SUB, ca.OP_SUB: ca.OP_ADD}


@dataclass(frozen=True)
class Python:
    """Python over a module's functions: `calls` maps operations to them."""

    calls: dict[int, str]
    prefix: str
    longest: int | None = 90

    def width(self, text: str) -> int:
        return len(text)

    def operation(self, op: int, values: Sequence[Text]) -> Text:
        if op == ca.OP_ASSIGN:
            return values[0]
        if op in self.calls:
            return Text(f"{self.calls[op]}({', '.join(v.text for v in values)})", ATOM)
        if op not in _PYTHON:
            raise NotImplementedError(f"CasADi operation {op} has no form in Python here")
        if op in _SIGNS and values[1].text.startswith("-") and values[1].level == PRODUCT:
            op, values = _SIGNS[op], [values[0], Text(values[1].text[1:], PRODUCT)]
        template, level, needed = _PYTHON[op]
        return Text(template.format(*(bracketed(v, n, "(", ")") for v, n in zip(values, needed, strict=True))), level)

    def constant(self, value: float) -> Text:
        text = repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
        return Text(text, PRODUCT if value < 0 else ATOM)

    def temporary(self, number: int) -> str:
        return f"{self.prefix}{number}"


def module_functions(module: str, names: dict[str, str]) -> dict[int, str]:
    """Functions of a module by operation; `names` are the module's own names for `asin`, `atan2` and others."""
    ops = {
        "sqrt": ca.OP_SQRT, "sin": ca.OP_SIN, "cos": ca.OP_COS, "tan": ca.OP_TAN, "asin": ca.OP_ASIN, "acos": ca.OP_ACOS,
        "atan": ca.OP_ATAN, "atan2": ca.OP_ATAN2, "exp": ca.OP_EXP, "log": ca.OP_LOG, "abs": ca.OP_FABS,
    }  # fmt: skip
    return {op: f"{module}.{names.get(name, name)}" for name, op in ops.items()}


def bracketed(value: Text, level: int, left: str, right: str) -> str:
    """The text in brackets where it binds less tightly than needed."""
    return value.text if value.level >= level else f"{left}{value.text}{right}"
