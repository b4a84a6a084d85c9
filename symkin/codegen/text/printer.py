"""Print graphs as text of a language: one printer, and a table of operations a language.

A language either names each operation, in the order in which its values are asked for, so that few
live at a time; or it is nested, and names only what is read more than once or grows too long.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import casadi as ca

from symkin.codegen.text.graph import Graph, Node, kind_of
from symkin.computed_once import cached_property

SIGNED_SUM, SUM, SIGNED, PRODUCT, POWER, ATOM = range(6)
"""How tightly a text binds; what begins with a minus binds less than what does not."""
_OPPOSITE = {ca.OP_ADD: ca.OP_SUB, ca.OP_SUB: ca.OP_ADD}


class Text(NamedTuple):
    """The text of a value and how tightly it binds."""

    text: str
    level: int


class Form(NamedTuple):
    """How an operation is written: its pattern, how tightly this binds, and how tightly its
    operands must.
    """

    pattern: str
    level: int
    needed: tuple[int, ...]


@dataclass(frozen=True)
class Language:
    """What differs from language to language: texts of operations, constants, names (by number) and
    the statement of a name.

    `longest` is the `width` beyond which parts of a nested text get names; `folds_signs` writes
    a + -b as a - b; `shares_reciprocals` multiplies by the reciprocal of a constant, and of what
    divides more than once.
    """

    forms: Mapping[int, Form]
    constant: Callable[[float], str]
    name: str = "v{}"
    statement: str = "{name} = {text}"
    first: int = 0
    bracket: str = "({})"
    finish: Callable[[str], str] = str
    nested: bool = True
    longest: int | None = None
    width: Callable[[str], int] = len
    folds_signs: bool = True
    shares_reciprocals: bool = False

    def number(self, value: float) -> Text:
        """A constant; a negative one is signed, a power of ten a product."""
        text = self.constant(value)
        return Text(text, SIGNED if text.startswith("-") else PRODUCT if " " in text else ATOM)

    def operation(self, op: int, values: Sequence[Text]) -> Text:
        """An operation, operands that bind too little in brackets."""
        if op not in self.forms:
            raise NotImplementedError(f"CasADi operation {op} has no form here")
        if self.folds_signs and op in _OPPOSITE and values[1].level == SIGNED:
            op, values = _OPPOSITE[op], [values[0], Text(values[1].text[1:], PRODUCT)]
        pattern, level, needed = self.forms[op]
        operands = [
            value.text if value.level >= least else self.bracket.format(value.text)
            for value, least in zip(values, needed, strict=True)
        ]
        text = self.finish(pattern.format(*operands))
        return Text(text, level - (text.startswith("-") and level in (SUM, PRODUCT)))


@dataclass
class Printer:
    """Text of a CasADi SX function: `value(o, k)` makes the statements for one output nonzero and
    gives its text.

    `inputs[i][k]` is the text of nonzero k of input i, which may be the name of an array of them.
    `operations` counts what is printed,
    `divisions` has the line of each and what it divides by.
    """

    function: ca.Function
    inputs: Sequence[Sequence[str] | str]
    language: Language
    lines: list[str] = field(default_factory=list)
    operations: Counter[str] = field(default_factory=Counter)
    divisions: list[tuple[int, str]] = field(default_factory=list)
    _text: dict[int, Text] = field(default_factory=dict)
    _inverse: dict[int, str] = field(default_factory=dict)
    _remarks: int = 0
    _taken: int = 0

    @cached_property
    def _graph(self) -> Graph:
        return Graph.of(self.function, is_read=self.language.nested)

    def value(self, output: int, nonzero: int) -> str:
        """Make the statements up to one output nonzero; its text, 0 where the function has no such
        nonzero.
        """
        place = self._graph.outputs.get((output, nonzero))
        if place is None:
            return self.language.constant(0.0)
        for k in self._graph.needed(place, self._text):
            self._text[k] = self._written(k, self._graph.nodes[k])
        return self._text[place].text

    def values(self, output: int) -> list[str]:
        """Make the statements up to all entries of a dense output; their texts."""
        return [self.value(output, k) for k in range(self.function.numel_out(output))]

    def entry(self, row: int, column: int) -> str:
        """Make the statements up to one entry of the first output; its text."""
        nonzero = self._places.get((row, column))
        return self.language.constant(0.0) if nonzero is None else self.value(0, nonzero)

    @cached_property
    def _places(self) -> dict[tuple[int, int], int]:
        """Nonzero number of each structural entry of the first output."""
        triplets = zip(*self.function.sparsity_out(0).get_triplet(), strict=True)
        return {place: k for k, place in enumerate(triplets)}

    def entries(self) -> dict[tuple[int, int], str]:
        """The texts of all entries of the first output that are not 0, row by row; their
        statements in the order of the calculation.
        """
        for k, node in enumerate(self._graph.nodes):
            if self._graph.uses[k] and k not in self._text:
                self._text[k] = self._written(k, node)
        found = {place: self.value(0, k) for place, k in sorted(self._places.items())}
        return {place: text for place, text in found.items() if text != self.language.constant(0.0)}

    def reads(self, text: str) -> bool:
        """Whether an output needs the input of this text."""
        graph = self._graph
        return any(
            graph.uses[k] and node.op == ca.OP_INPUT and self._written(k, node).text == text
            for k, node in enumerate(graph.nodes)
        )

    def take(self) -> list[str]:
        """The statements that were made since the last time."""
        new, self._taken = self.lines[self._taken :], len(self.lines)
        return new

    def remark(self, line: str) -> None:
        """Add a line that names do not count."""
        self.lines.append(line)
        self._remarks += 1

    def assign(self, text: str) -> str:
        """Add a statement that names a value; its name."""
        name = self._next_name
        self.lines.append(self.language.statement.format(name=name, text=text))
        return name

    @property
    def _next_name(self) -> str:
        return self.language.name.format(len(self.lines) - self._remarks + self.language.first)

    def _written(self, k: int, node: Node) -> Text:
        if node.op == ca.OP_CONST:
            return self.language.number(node.constant)
        if node.op == ca.OP_INPUT:
            texts, number = self.inputs[node.source[0]], node.source[1]
            name = f"{texts}[{number}]" if isinstance(texts, str) else texts[number]
            return Text(name, SIGNED if name.startswith("-") else ATOM)
        if node.op == ca.OP_ASSIGN:
            return self._text[node.reads[0]]
        text = self._operation(node)
        named = not self.language.nested or self._graph.uses[k] > 1
        return Text(self.assign(text.text), ATOM) if named else text

    def _operation(self, node: Node) -> Text:
        language, reads = self.language, node.reads
        if language.shares_reciprocals and node.op in (ca.OP_DIV, ca.OP_INV):
            return self._quotient(node.op, reads)
        text = self._counted(node.op, [self._text[r] for r in reads])
        while language.longest is not None and language.width(text.text) > language.longest:
            widest = max(reads, key=lambda r: language.width(self._text[r].text))
            if language.width(self._text[widest].text) <= language.width(self._next_name):
                break
            self._text[widest] = Text(self.assign(self._text[widest].text), ATOM)
            text = language.operation(node.op, [self._text[r] for r in reads])
        return text

    def _quotient(self, op: int, reads: Sequence[int]) -> Text:
        """A quotient, by a reciprocal where that costs less: a controller multiplies in one cycle
        and divides in 14 or more.
        """
        above, below = self._text[reads[0]], self._graph.nodes[reads[-1]]
        if op == ca.OP_INV:
            return Text(self._reciprocal(reads[0]), ATOM)
        if below.op == ca.OP_CONST:
            factor = Text(self.language.constant(1.0 / below.constant), ATOM)
            return self._counted(ca.OP_MUL, [above, factor])
        if self._graph.divisors[reads[1]] > 1:
            return self._counted(ca.OP_MUL, [above, Text(self._reciprocal(reads[1]), ATOM)])
        return self._counted(op, [above, self._text[reads[1]]])

    def _reciprocal(self, k: int) -> str:
        if k not in self._inverse:
            self._inverse[k] = self.assign(self._counted(ca.OP_INV, [self._text[k]]).text)
        return self._inverse[k]

    def _counted(self, op: int, values: Sequence[Text]) -> Text:
        if op in (ca.OP_DIV, ca.OP_INV):
            self.divisions.append((len(self.lines), values[-1].text))
        if kind := kind_of(op):
            self.operations[kind] += 1
        return self.language.operation(op, values)
