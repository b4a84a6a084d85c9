"""Write formulas once for all arguments of one shape: the loops of a machine of many equal loops
differ by their symbols and numbers only.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import fields, is_dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from symkin.computed_once import lru_cache
from symkin.spatial.backend import stacked

Rows = list[tuple[str, list[ca.SX], list[ca.SX]]]
"""Rows and their checks, by the relation that they keep."""


class _Shape(NamedTuple):
    """In place of an expression in a nested argument: its size and the places that it fills."""

    rows: int
    columns: int
    places: tuple[int, ...]


def written_once(write: Callable[..., Rows], *arguments: Any) -> Rows:
    """The rows that `write` makes of arguments: expressions, hashable values, and tuples and frozen
    dataclasses of these.
    """
    leaves: list[ca.SX] = []
    described = _described(arguments, leaves)
    try:
        hash(described)
    except TypeError:
        # an argument that keeps a record of what it is asked for has to be asked itself
        return write(*arguments)
    relations, function = _written(write, described)
    sizes = np.cumsum([0, *(size for _, *both in relations for size in both)]).tolist()
    whole = ca.vertsplit(function(*leaves)) if leaves else ca.vertsplit(function()["o0"])
    parts = [whole[a:b] for a, b in pairwise(sizes)]
    return [(r[0], parts[2 * k], parts[2 * k + 1]) for k, r in enumerate(relations)]


@lru_cache(maxsize=512)
def _written(
    write: Callable[..., Rows], described: Hashable
) -> tuple[list[tuple[str, int, int]], ca.Function]:
    """Relations with the numbers of their rows and checks, and all of these as a function of the
    expressions.
    """
    symbols: list[ca.SX] = []
    found = write(*_made(described, symbols))
    every = [row for _, rows, errors in found for row in (*rows, *errors)]
    function = ca.Function("rows", symbols, [stacked(every)])
    return [(relation, len(rows), len(errors)) for relation, rows, errors in found], function


def _described(value: Any, leaves: list[ca.SX]) -> Hashable:
    """A value with shapes in place of expressions, which become `leaves`."""
    if isinstance(value, ca.SX):
        leaves.append(value)
        pattern = value.sparsity()
        return _Shape(pattern.size1(), pattern.size2(), tuple(pattern.find()))
    if isinstance(value, tuple):
        return tuple, tuple(_described(part, leaves) for part in value)
    if is_dataclass(value):
        parts = (getattr(value, field.name) for field in fields(value))
        return type(value), tuple(_described(part, leaves) for part in parts)
    return value


def _made(described: Any, symbols: list[ca.SX]) -> Any:
    """The value again with new symbols, which become `symbols`, where it had expressions."""
    if isinstance(described, _Shape):
        pattern = ca.Sparsity.nonzeros(described.rows, described.columns, described.places)
        symbols.append(ca.SX.sym("x", pattern))
        return symbols[-1]
    if isinstance(described, tuple):
        kind, parts = described
        values = (_made(part, symbols) for part in parts)
        return tuple(values) if kind is tuple else kind(*values)
    return described
