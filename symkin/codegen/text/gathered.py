"""Gather expressions: sums of products of few values, where the constants of a machine leave such a
sum of a longer calculation.

Each value of a graph is written as a polynomial in its atoms, which are symbols and the results of
divisions and roots; squares of sines become those of cosines. What is shorter as a polynomial is
written so, by Horner's rule; what is not keeps its operations.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import casadi as ca

from symkin.closure.expression_graph import walk
from symkin.closure.snapping import snap

_MOST_TERMS = 40
"""Terms of the longest polynomial that is followed."""
_NOISE = 1e-13
"""Share of what a coefficient is summed from below which it is rounding."""
_Monomial = tuple[int, ...]
"""Atoms of a product, in order; a square stands twice."""


@dataclass(frozen=True, eq=False)
class _Node:
    """A value: its operation and operands, or an atom's expression; its polynomial (coefficient,
    what it was summed from), if it is short.
    """

    op: int
    reads: tuple[int, ...]
    atom: ca.SX | None
    terms: Mapping[_Monomial, tuple[float, float]] | None


def gathered(
    expressions: Sequence[ca.SX], symbols: Sequence[ca.SX], turns: Sequence[tuple[ca.SX, ca.SX]]
) -> list[ca.SX]:
    """The same values, written shorter. `turns` are the symbols that are cosine and sine of one
    angle.
    """
    sizes = [e.numel() for e in expressions]
    whole = ca.densify(ca.vertcat(*expressions))
    reader = _Reader(ca.vertcat(*symbols), [(c.element_hash(), s.element_hash()) for c, s in turns])
    walk(ca.Function("f", [reader.symbols], [whole], {"cse": True}), reader)
    count = whole.numel()
    found = [whole, _Writer(reader, _by_cones(reader)).whole(count)]
    best = min(
        found,
        key=lambda e: ca.Function("f", [reader.symbols], [e], {"cse": True}).n_instructions(),
    )
    parts, begin = [], 0
    for size in sizes:
        parts.append(best[begin : begin + size])
        begin += size
    return parts


@dataclass
class _Reader:
    """Evaluator that lists the values with their polynomials."""

    symbols: ca.SX
    turns: Sequence[tuple[int, int]]
    nodes: list[_Node] = field(default_factory=list)
    outputs: dict[int, int] = field(default_factory=dict)
    cosine_of: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        hashes = [self.symbols[k].element_hash() for k in range(self.symbols.numel())]
        for k in range(len(hashes)):
            self._add(_Node(ca.OP_INPUT, (), self.symbols[k], {(k,): (1.0, 1.0)}))
        self.cosine_of = {hashes.index(s): hashes.index(c) for c, s in self.turns}

    def input(self, number: int, nonzero: int) -> int:  # noqa: ARG002 - the walker's signature
        return nonzero

    def constant(self, number: float) -> int:
        value = snap(number)
        return self._add(_Node(ca.OP_CONST, (), ca.SX(value), {(): (value, abs(value))}))

    def output(self, number: int, nonzero: int, value: int) -> None:  # noqa: ARG002 - the walker's signature
        self.outputs[nonzero] = value

    def operation(self, op: int, operands: list[int]) -> int:
        terms = self._terms(op, [self.nodes[k].terms for k in operands])
        self._add(_Node(op, tuple(operands), None, terms))
        place = len(self.nodes) - 1
        if terms is None:
            # what has no short polynomial is an atom of what is made of it
            self.nodes[place] = _Node(op, tuple(operands), None, {(place,): (1.0, 1.0)})
        return place

    def _add(self, node: _Node) -> int:
        self.nodes.append(node)
        return len(self.nodes) - 1

    def _terms(
        self, op: int, parts: Sequence[Mapping[_Monomial, tuple[float, float]] | None]
    ) -> Mapping[_Monomial, tuple[float, float]] | None:
        if any(part is None for part in parts):
            return None
        known = [part for part in parts if part is not None]
        if op in (ca.OP_ADD, ca.OP_SUB):
            return _short(_sum(known[0], known[1], 1.0 if op == ca.OP_ADD else -1.0))
        if op in (ca.OP_NEG, ca.OP_TWICE):
            return _sum({}, known[0], -1.0 if op == ca.OP_NEG else 2.0)
        if op in (ca.OP_MUL, ca.OP_SQ):
            return self._product(known[0], known[-1])
        if op == ca.OP_DIV and set(known[1]) == {()}:
            return _sum({}, known[0], 1.0 / known[1][()][0])
        return None

    def _product(
        self,
        first: Mapping[_Monomial, tuple[float, float]],
        second: Mapping[_Monomial, tuple[float, float]],
    ) -> Mapping[_Monomial, tuple[float, float]] | None:
        if len(first) * len(second) > 8 * _MOST_TERMS:
            return None
        found: dict[_Monomial, tuple[float, float]] = {}
        for (a, (x, _)), (b, (y, _)) in product(first.items(), second.items()):
            for monomial, sign in self._reduced(tuple(sorted(a + b))):
                _put(found, monomial, sign * x * y, abs(x * y))
        return _short(_cleaned(found))

    def _reduced(self, monomial: _Monomial) -> list[tuple[_Monomial, float]]:
        """A product with sin^2 as 1 - cos^2."""
        for sine, cosine in self.cosine_of.items():
            if monomial.count(sine) >= 2:
                rest = list(monomial)
                rest.remove(sine)
                rest.remove(sine)
                squared = tuple(sorted([*rest, cosine, cosine]))
                return [*self._reduced(tuple(rest)), *((m, -s) for m, s in self._reduced(squared))]
        return [(monomial, 1.0)]


def _put(
    terms: dict[_Monomial, tuple[float, float]], monomial: _Monomial, value: float, size: float
) -> None:
    before, from_what = terms.get(monomial, (0.0, 0.0))
    terms[monomial] = (before + value, from_what + size)


def _sum(
    first: Mapping[_Monomial, tuple[float, float]],
    second: Mapping[_Monomial, tuple[float, float]],
    factor: float,
) -> Mapping[_Monomial, tuple[float, float]]:
    found = dict(first)
    for monomial, (value, size) in second.items():
        _put(found, monomial, factor * value, abs(factor) * size)
    return _cleaned(found)


def _cleaned(
    terms: Mapping[_Monomial, tuple[float, float]],
) -> Mapping[_Monomial, tuple[float, float]]:
    return {m: (value, size) for m, (value, size) in terms.items() if abs(value) > _NOISE * size}


def _short(
    terms: Mapping[_Monomial, tuple[float, float]],
) -> Mapping[_Monomial, tuple[float, float]] | None:
    return terms if len(terms) <= _MOST_TERMS else None


def _polynomial_cost(node: _Node) -> int:
    """Operations of a polynomial."""
    assert node.terms is not None  # noqa: S101 - the caller has looked
    count = sum(
        max(len(m) - 1, 0) + (bool(m) and abs(v) != 1.0) for m, (v, _) in node.terms.items()
    )
    return count + max(len(node.terms) - 1, 0)


def _by_cones(reader: _Reader) -> set[int]:
    """The values to write as polynomials: those that take no more operations than the part of the
    graph that nothing else reads, the last values first.
    """
    nodes, chosen = reader.nodes, set[int]()
    uses = Counter(k for node in nodes for k in node.reads)
    uses.update(reader.outputs.values())
    # values that no output needs are not there
    for place in reversed(range(len(nodes))):
        if not uses[place]:
            uses.subtract(nodes[place].reads)
    for place in reversed(range(len(nodes))):
        node = nodes[place]
        if not uses[place] or node.atom is not None or node.terms is None or (place,) in node.terms:
            continue
        before = uses.copy()
        if _polynomial_cost(node) <= _released(nodes, uses, place):
            chosen.add(place)
            uses.update({atom for m in node.terms for atom in m})
        else:
            uses = before
    return chosen


def _released(nodes: Sequence[_Node], uses: Counter[int], place: int) -> int:
    """How many values go with one, which are read no more then."""
    count, stack = 0, [place]
    while stack:
        k = stack.pop()
        count += 1
        for read in nodes[k].reads:
            uses[read] -= 1
            if not uses[read] and nodes[read].atom is None:
                stack.append(read)
    return count


@dataclass
class _Writer:
    """Writes the values of a reader, `polynomials` as such."""

    reader: _Reader
    polynomials: set[int]
    written: dict[int, ca.SX] = field(default_factory=dict)

    def whole(self, count: int) -> ca.SX:
        return ca.vertcat(
            *(
                self._value(self.reader.outputs[k]) if k in self.reader.outputs else ca.SX(0)
                for k in range(count)
            )
        )

    def _value(self, place: int) -> ca.SX:
        if place not in self.written:
            node = self.reader.nodes[place]
            if node.atom is not None:
                self.written[place] = node.atom
            elif place in self.polynomials:
                assert node.terms is not None  # noqa: S101 - it was chosen for them
                self.written[place] = self._horner({m: v for m, (v, _) in node.terms.items()})
            else:
                make = ca.SX.binary if len(node.reads) == 2 else ca.SX.unary
                self.written[place] = make(node.op, *(self._value(k) for k in node.reads))
        return self.written[place]

    def _horner(self, terms: Mapping[_Monomial, float]) -> ca.SX:
        """A polynomial, the atom that stands in most terms drawn out first."""
        counts = Counter(atom for m in terms for atom in set(m))
        if not counts:
            return ca.SX(snap(terms.get((), 0.0)))
        atom = min(counts, key=lambda k: (-counts[k], k))
        inner: dict[_Monomial, float] = {}
        rest: dict[_Monomial, float] = {}
        for m, v in terms.items():
            if atom in m:
                left = list(m)
                left.remove(atom)
                inner[tuple(left)] = v
            else:
                rest[m] = v
        factor = self._horner(inner)
        found = self._value(atom) * factor
        if not rest:
            return found
        others = self._horner(rest)
        return (
            others - self._value(atom) * -factor
            if factor.is_constant() and float(factor) < 0
            else others + found
        )
