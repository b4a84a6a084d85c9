"""Write expressions as text of another language: one walk over the graph, and what differs from
language to language.

What is used more than once gets a name, and so do parts of what grows longer than the language
likes; the rest is written in place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

import casadi as ca

from symkin.closure.expression_graph import walk

ATOM, POWER, PRODUCT, SUM = 3, 2, 1, 0
"""How tightly a text binds."""


@dataclass(frozen=True)
class Text:
    """The text of a subexpression and how tightly it binds."""

    text: str
    level: int


class Language(Protocol):
    """The texts of operations and constants; `longest` is the `width` of a text beyond which parts
    of it get names.
    """

    @property
    def longest(self) -> int | None: ...
    def width(self, text: str) -> int: ...
    def operation(self, op: int, values: Sequence[Text]) -> Text: ...
    def constant(self, value: float) -> Text: ...
    def temporary(self, number: int) -> str: ...


@dataclass
class _Part:
    """A value on its way: its text, or the name that it has got, and its place among all values."""

    text: Text
    place: int


@dataclass
class _UseCounts:
    """Evaluator that counts how often each value is read, in order of their making."""

    counts: list[int] = field(default_factory=list)

    def input(self, number: int, nonzero: int) -> int:  # noqa: ARG002 - the walker's signature
        return self._new()

    def constant(self, number: float) -> int:  # noqa: ARG002 - the walker's signature
        return self._new()

    def operation(self, op: int, operands: list[int]) -> int:  # noqa: ARG002 - the walker's signature
        for k in operands:
            self.counts[k] += 1
        return self._new()

    def output(self, number: int, nonzero: int, value: int) -> None:  # noqa: ARG002 - the walker's signature
        self.counts[value] += 1

    def _new(self) -> int:
        self.counts.append(0)
        return len(self.counts) - 1


@dataclass
class _Writer:
    """Evaluator that writes values as text and names those that are read more than once or grow too
    long.
    """

    names: Sequence[Sequence[str]]
    language: Language
    uses: Sequence[int]
    results: list[str]
    definitions: list[tuple[str, str]] = field(default_factory=list)
    made: int = 0

    def input(self, number: int, nonzero: int) -> _Part:
        return self._part(Text(self.names[number][nonzero], ATOM))

    def constant(self, number: float) -> _Part:
        return self._part(self.language.constant(number))

    def operation(self, op: int, operands: list[_Part]) -> _Part:
        language = self.language
        text = language.operation(op, [part.text for part in operands])
        while language.longest is not None and language.width(text.text) > language.longest:
            widest = max(operands, key=lambda part: language.width(part.text.text))
            if language.width(widest.text.text) <= language.width(
                language.temporary(len(self.definitions) + 1)
            ):
                break
            widest.text = self._named(widest.text.text)
            text = language.operation(op, [part.text for part in operands])
        part = self._part(text)
        if self.uses[part.place] > 1:
            part.text = self._named(text.text)
        return part

    def output(self, number: int, nonzero: int, value: _Part) -> None:
        if number == 0:
            self.results[nonzero] = value.text.text

    def _part(self, text: Text) -> _Part:
        self.made += 1
        return _Part(text, self.made - 1)

    def _named(self, text: str) -> Text:
        self.definitions.append((self.language.temporary(len(self.definitions) + 1), text))
        return Text(self.definitions[-1][0], ATOM)


def write(
    function: ca.Function, names: Sequence[str], language: Language
) -> tuple[list[tuple[str, str]], list[str]]:
    """Write a function: named intermediate values, in order, and the text of each entry of the
    dense first output (column by column). `names` are the texts of all inputs' entries, input after
    input.
    """
    ends = [sum(function.numel_in(k) for k in range(i)) for i in range(function.n_in() + 1)]
    uses = _UseCounts()
    walk(function, uses)
    inputs = [names[begin:end] for begin, end in pairwise(ends)]
    writer = _Writer(
        inputs, language, uses.counts, [language.constant(0.0).text] * int(function.numel_out(0))
    )
    walk(function, writer)
    return writer.definitions, writer.results


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
        return Text(
            template.format(
                *(bracketed(v, n, "(", ")") for v, n in zip(values, needed, strict=True))
            ),
            level,
        )

    def constant(self, value: float) -> Text:
        text = repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
        return Text(text, PRODUCT if value < 0 else ATOM)

    def temporary(self, number: int) -> str:
        return f"{self.prefix}{number}"


def module_functions(module: str, names: dict[str, str]) -> dict[int, str]:
    """Functions of a module by operation; `names` are the module's own names for `asin`, `atan2`
    and others.
    """
    ops = {
        "sqrt": ca.OP_SQRT,
        "sin": ca.OP_SIN,
        "cos": ca.OP_COS,
        "tan": ca.OP_TAN,
        "asin": ca.OP_ASIN,
        "acos": ca.OP_ACOS,
        "atan": ca.OP_ATAN,
        "atan2": ca.OP_ATAN2,
        "exp": ca.OP_EXP,
        "log": ca.OP_LOG,
        "abs": ca.OP_FABS,
    }
    return {op: f"{module}.{names.get(name, name)}" for name, op in ops.items()}


def bracketed(value: Text, level: int, left: str, right: str) -> str:
    """The text in brackets where it binds less tightly than needed."""
    return value.text if value.level >= level else f"{left}{value.text}{right}"
