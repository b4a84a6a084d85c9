"""Gather expressions: sums of products of few values, where the constants of a machine leave such a
sum of a longer calculation.

Each value of a graph is written as a polynomial in its atoms, which are symbols and the results of
divisions and roots; squares of sines become those of cosines. What is shorter as a polynomial is
written so, by Horner's rule; what is not keeps its operations.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import product

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import walk
from symkin.closure.snapping import snap
from symkin.codegen.text.graph import Graph, Node, kind_of
from symkin.computed_once import cached_property

_MOST_TERMS = 40
"""Terms of the longest polynomial that is followed."""
_NOISE = 1e-13
"""Share of what a coefficient is summed from below which it is rounding."""
_Monomial = tuple[int, ...]
"""Atoms of a product, in order; a square stands twice."""
_Terms = Mapping[_Monomial, tuple[float, float]]
"""Coefficients of a polynomial, and what each was summed from."""


def gathered(
    expressions: Sequence[ca.SX], symbols: Sequence[ca.SX], turns: Sequence[tuple[ca.SX, ca.SX]]
) -> list[ca.SX]:
    """The same values, written shorter. `turns` are the symbols that are cosine and sine of one
    angle.
    """
    whole, every = ca.densify(ca.vertcat(*expressions)), ca.vertcat(*symbols)
    graph = _Values(every, turns)
    walk(ca.Function("f", [every], [whole], {"cse": True}), graph)
    best = min((whole, graph.whole(whole.numel(), 0)), key=lambda e: _operations(e, every))
    # what is gathered for no gain may tear apart what others share
    strict = graph.whole(whole.numel(), 1)
    best = min((best, strict), key=lambda e: _operations(e, every)[0])
    return ca.vertsplit(best, np.cumsum([0, *(e.numel() for e in expressions)]).tolist())


class _Values(Graph):
    """The values, each with its polynomial; the symbols are the first ones."""

    def __init__(self, symbols: ca.SX, turns: Sequence[tuple[ca.SX, ca.SX]]) -> None:
        super().__init__()
        self.symbols = symbols
        self.chosen, self.written = set[int](), dict[int, ca.SX]()
        hashes = [symbols[k].element_hash() for k in range(symbols.numel())]
        self.cosine_of = {
            hashes.index(s.element_hash()): hashes.index(c.element_hash()) for c, s in turns
        }
        for k in range(len(hashes)):
            super().input(0, k)

    def input(self, number: int, nonzero: int) -> int:  # noqa: ARG002 - the walker's signature
        return nonzero

    def operation(self, op: int, operands: list[int]) -> int:
        return self._add(Node(op, tuple(operands)))

    # --- polynomials ------------------------------------------------------------------------------

    @cached_property
    def terms(self) -> list[_Terms]:
        """The polynomial of each value; what has no short one is an atom of what is made of it."""
        found = list[_Terms]()
        for place, node in enumerate(self.nodes):
            terms = self._terms(node, [found[k] for k in node.reads])
            if terms is None or len(terms) > _MOST_TERMS:
                terms = {(place,): (1.0, 1.0)}
            found.append(terms)
        return found

    def _terms(self, node: Node, parts: Sequence[_Terms]) -> _Terms | None:
        match node.op:
            case ca.OP_CONST:
                return {(): (node.constant, abs(node.constant))}
            case ca.OP_ADD | ca.OP_SUB:
                return _sum(parts[0], parts[1], 1.0 if node.op == ca.OP_ADD else -1.0)
            case ca.OP_NEG | ca.OP_TWICE:
                return _sum({}, parts[0], -1.0 if node.op == ca.OP_NEG else 2.0)
            case ca.OP_MUL | ca.OP_SQ:
                return self._product(parts[0], parts[-1])
            case ca.OP_DIV if set(parts[1]) == {()}:
                return _sum({}, parts[0], 1.0 / parts[1][()][0])
        return None

    def _product(self, first: _Terms, second: _Terms) -> _Terms | None:
        if len(first) * len(second) > 8 * _MOST_TERMS:
            return None
        found: dict[_Monomial, tuple[float, float]] = {}
        for (a, (x, _)), (b, (y, _)) in product(first.items(), second.items()):
            for monomial, sign in self._reduced(tuple(sorted(a + b))):
                _put(found, monomial, sign * x * y, abs(x * y))
        return _cleaned(found)

    def _reduced(self, monomial: _Monomial) -> list[tuple[_Monomial, float]]:
        """A product with sin^2 as 1 - cos^2."""
        for sine, cosine in self.cosine_of.items():
            if monomial.count(sine) >= 2:
                rest = _without(_without(monomial, sine), sine)
                squared = tuple(sorted([*rest, cosine, cosine]))
                return [*self._reduced(rest), *((m, -s) for m, s in self._reduced(squared))]
        return [(monomial, 1.0)]

    # --- writing ----------------------------------------------------------------------------------

    def _choose(self, gain: int) -> set[int]:
        """The values to write as polynomials: those that take fewer operations by `gain` than the
        part of the graph that nothing else reads, the last values first.
        """
        chosen, uses = set[int](), Counter(self.uses)
        for place in reversed(range(len(self.nodes))):
            terms = self.terms[place]
            if not uses[place] or not self.nodes[place].reads or (place,) in terms:
                continue
            before = uses.copy()
            if _cost(terms) + gain <= self._released(uses, place):
                chosen.add(place)
                uses.update({atom for m in terms for atom in m})
            else:
                uses = before
        return chosen

    def _released(self, uses: Counter[int], place: int) -> int:
        """How many values go with one, which are read no more then."""
        count, stack = 0, [place]
        while stack:
            count += 1
            for read in self.nodes[stack.pop()].reads:
                uses[read] -= 1
                if not uses[read] and self.nodes[read].reads:
                    stack.append(read)
        return count

    def whole(self, count: int, gain: int) -> ca.SX:
        """The output, written anew."""
        self.chosen, self.written = self._choose(gain), {}
        places = (self.outputs.get((0, k)) for k in range(count))
        return ca.vertcat(*(ca.SX(0) if k is None else self._value(k) for k in places))

    def _value(self, place: int) -> ca.SX:
        if place not in self.written:
            node = self.nodes[place]
            if node.op == ca.OP_INPUT:
                value = self.symbols[place]
            elif node.op == ca.OP_CONST:
                value = ca.SX(node.constant)
            elif place in self.chosen:
                value = self._horner({m: v for m, (v, _) in self.terms[place].items()})
            else:
                make = ca.SX.binary if len(node.reads) == 2 else ca.SX.unary
                value = make(node.op, *map(self._value, node.reads))
            self.written[place] = value
        return self.written[place]

    def _horner(self, terms: Mapping[_Monomial, float]) -> ca.SX:
        """A polynomial, the atom that stands in most terms drawn out first."""
        counts = Counter(atom for m in terms for atom in set(m))
        if not counts:
            return ca.SX(snap(terms.get((), 0.0)))
        atom = min(counts, key=lambda k: (-counts[k], k))
        factor = self._horner({_without(m, atom): v for m, v in terms.items() if atom in m})
        rest = {m: v for m, v in terms.items() if atom not in m}
        found = self._value(atom) * factor
        if not rest:
            return found
        others = self._horner(rest)
        if factor.is_constant() and float(factor) < 0:
            return others - self._value(atom) * -factor
        return others + found


def _operations(expression: ca.SX, symbols: ca.SX) -> tuple[int, int]:
    """How many operations are printed, and how many there are before signs are drawn out."""
    function = ca.Function("f", [symbols], [expression], {"cse": True})
    graph = Graph.of(function)
    printed = sum(kind_of(graph.nodes[k].op) is not None for k, n in graph.uses.items() if n)
    return printed, function.n_instructions()


def _without(monomial: _Monomial, atom: int) -> _Monomial:
    at = monomial.index(atom)
    return monomial[:at] + monomial[at + 1 :]


def _put(
    terms: dict[_Monomial, tuple[float, float]], monomial: _Monomial, value: float, size: float
) -> None:
    before, from_what = terms.get(monomial, (0.0, 0.0))
    terms[monomial] = (before + value, from_what + size)


def _sum(first: _Terms, second: _Terms, factor: float) -> _Terms:
    found = dict(first)
    for monomial, (value, size) in second.items():
        _put(found, monomial, factor * value, abs(factor) * size)
    return _cleaned(found)


def _cleaned(terms: _Terms) -> _Terms:
    return {m: (value, size) for m, (value, size) in terms.items() if abs(value) > _NOISE * size}


def _cost(terms: _Terms) -> int:
    """Operations of a polynomial."""
    products = sum(max(len(m) - 1, 0) + (bool(m) and abs(v) != 1.0) for m, (v, _) in terms.items())
    return products + max(len(terms) - 1, 0)
