"""Which parameters of a test the gate runs: those that repeat a law on further machines are run by
`-m long` alone.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from itertools import product

import pytest


def in_gate(values: Iterable[object], kept: Collection[object]) -> list[object]:
    """Parameters of a test: those that are not kept are marked as long."""
    return [value if value in kept else _long(value) for value in values]


def _long(value: object) -> object:
    """A parameter that is marked as long; a tuple is several arguments."""
    return pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.long)


def in_gate_but(values: Iterable[object], others: Collection[object]) -> list[object]:
    """Parameters of a test: the `others` are marked as long."""
    every = list(values)
    unknown = [value for value in others if value not in every]
    if unknown:
        raise ValueError(f"no parameters of this test: {unknown}")
    return in_gate(every, [value for value in every if value not in others])


def each_once(*lists: Collection[object], kept: Collection[object] = ()) -> list[object]:
    """Parameters of a test over several lists: all combinations, of which the gate runs as few as
    hold each value of each list.

    `kept` are combinations that the gate runs besides.
    """
    values = [list(one) for one in lists]
    few = {tuple(one[k % len(one)] for one in values) for k in range(max(map(len, values)))}
    return in_gate(product(*values), few | set(kept))
