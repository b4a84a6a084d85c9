"""Simplify expressions to what a reader would write: signs and factors drawn out of products,
constants of nested sums added, and c h + (1 - c) h, which turns about an axis leave of what lies
along it, as h.

Each rule is an identity, applied once to each step of the graph, from the inputs to the results.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from symkin.closure.expression_graph import rebuilt
from symkin.closure.snapping import snap


def tidied(expression: ca.SX, symbols: Sequence[ca.SX]) -> ca.SX:
    """The same values, written shorter."""
    function = ca.Function("f", list(symbols), [expression], {"cse": True})
    return ca.cse(rebuilt(function, symbols, ca.SX, _tidy))


def _tidy(x: ca.SX) -> ca.SX:
    """One step whose operands are tidy already."""
    if x.is_constant():
        return ca.SX(snap(float(x)))
    match x.op():
        case ca.OP_ADD:
            return _sum(x.dep(0), x.dep(1))
        case ca.OP_SUB:
            return _sum(x.dep(0), -x.dep(1))
        case ca.OP_MUL:
            return _product(x.dep(0), x.dep(1))
        case ca.OP_TWICE:
            return _product(ca.SX(2.0), x.dep(0))
        case ca.OP_NEG:
            return _product(ca.SX(-1.0), x.dep(0))
        case ca.OP_SQ:
            factor, inner = _factor(x.dep(0))
            return _scaled(factor**2, inner * inner)
    return x


def _sum(a: ca.SX, b: ca.SX) -> ca.SX:
    """a + b with one constant, at the end."""
    (rest_a, one), (rest_b, two) = _without_constant(a), _without_constant(b)
    rest, constant = _added(rest_a, rest_b), snap(one + two, max(abs(one), abs(two)))
    if constant == 0.0:
        return rest
    return rest - ca.SX(-constant) if constant < 0.0 else rest + ca.SX(constant)


def _without_constant(x: ca.SX) -> tuple[ca.SX, float]:
    """x as a sum of something and a constant at its end."""
    sign, inner = _factor(x)
    if x.is_constant():
        return ca.SX(0.0), float(x)
    if abs(sign) == 1.0 and inner.op() in (ca.OP_ADD, ca.OP_SUB):
        for k in (0, 1):
            if inner.dep(k).is_constant():
                second = 1.0 if inner.op() == ca.OP_ADD else -1.0
                constant, other = float(inner.dep(k)), inner.dep(1 - k)
                own, rest = (second, 1.0) if k == 1 else (1.0, second)
                return _scaled(sign * rest, other), sign * own * constant
    return x, 0.0


def _added(a: ca.SX, b: ca.SX) -> ca.SX:
    """a + b, neither with a constant of its own."""
    if a.is_zero() or b.is_zero():
        return a + b
    whole = _whole_of(a, b)
    if whole is not None:
        return whole
    factor, inner = _factor(b)
    if factor < 0.0:
        return a - _scaled(-factor, inner)
    factor, inner = _factor(a)
    return b - _scaled(-factor, inner) if factor < 0.0 else a + b


def _whole_of(a: ca.SX, b: ca.SX) -> ca.SX | None:
    """h of c h + (1 - c) h, in either order; None for anything else."""
    (one, left), (two, right) = _factor(a), _factor(b)
    if one != two:
        return None
    pairs = [
        (share, rest)
        for p, q in ((left, right), (right, left))
        for share in _halves(p)
        for rest in _halves(q)
    ]
    for (c, h), (complement, other) in pairs:
        if _is_complement(complement, c) and ca.is_equal(h, other, 2):
            return _scaled(one, h)
    return None


def _halves(x: ca.SX) -> list[tuple[ca.SX, ca.SX]]:
    """x as a product of two, in both orders; as itself times 1."""
    return [
        (x, ca.SX(1.0)),
        *([(x.dep(0), x.dep(1)), (x.dep(1), x.dep(0))] if x.op() == ca.OP_MUL else []),
    ]


def _is_complement(x: ca.SX, c: ca.SX) -> bool:
    """Whether x is 1 - c."""
    return x.op() == ca.OP_SUB and x.dep(0).is_one() and bool(ca.is_equal(x.dep(1), c, 2))


def _product(a: ca.SX, b: ca.SX) -> ca.SX:
    """a b with one constant factor, at the front."""
    (one, left), (two, right) = _factor(a), _factor(b)
    if left.is_one() or right.is_one():
        return _scaled(one * two, right if left.is_one() else left)
    return _scaled(one * two, left * right)


def _factor(x: ca.SX) -> tuple[float, ca.SX]:
    """x as a constant factor and the rest, 1 where x is a constant."""
    if x.is_constant():
        return float(x), ca.SX(1.0)
    if x.op() == ca.OP_NEG:
        factor, rest = _factor(x.dep(0))
        return -factor, rest
    if x.op() == ca.OP_TWICE:
        factor, rest = _factor(x.dep(0))
        return 2.0 * factor, rest
    if x.op() == ca.OP_MUL and x.dep(0).is_constant():
        return float(x.dep(0)), x.dep(1)
    return 1.0, x


def _scaled(factor: float, x: ca.SX) -> ca.SX:
    """factor x, the sign alone where that is all."""
    factor = snap(factor)
    if factor == 0.0 or x.is_one():
        return ca.SX(factor)
    if factor == -1.0 and x.op() == ca.OP_SUB:
        return x.dep(1) - x.dep(0)
    return x if factor == 1.0 else -x if factor == -1.0 else ca.SX(factor) * x
