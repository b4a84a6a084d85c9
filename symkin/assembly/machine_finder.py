"""Modes at many points of the machine that a description means, as the description has them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np

from symkin.assembly.as_written import COMPLETE, as_checked
from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.mode_table import COMPLETENESS, PER_POINT, ModeTable, at_places, table_of
from symkin.machine.lower import Lowered
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.problem import Problem


class Plain(NamedTuple):
    """Modes of the points at the `places` (n,), rising."""

    table: ModeTable
    places: np.ndarray


class Finder(Protocol):
    """What finds the modes at many points of one problem."""

    @property
    def engine(self) -> str | None: ...
    @property
    def starts_digest(self) -> str: ...
    @property
    def is_tracked(self) -> bool: ...
    @property
    def most_modes(self) -> int: ...
    def find(self, known: np.ndarray, *, certify: bool) -> Plain: ...


@dataclass(frozen=True, eq=False)
class MachineFinder:
    """What is prepared once for all points of a `problem` of joint values: the finder of the
    machine's problem, whose known values are the problem's at `places`.
    """

    problem: Problem
    low: Lowered
    of_machine: Problem
    places: tuple[int, ...]
    own: Finder

    @property
    def engine(self) -> str | None:
        return self.own.engine

    @property
    def starts_digest(self) -> str:
        return self.own.starts_digest

    @property
    def is_tracked(self) -> bool:
        return self.own.is_tracked

    @property
    def most_modes(self) -> int:
        return self.own.most_modes

    def find(self, known: np.ndarray, *, certify: bool) -> Plain:
        """Modes at those of the points known (n, values) of which the machine's list is complete
        and closes on all rows of the description.
        """
        there = self.own.find(known[:, list(self.places)], certify=certify)
        whole = np.isin(there.table.completeness, [COMPLETENESS.index(c) for c in COMPLETE])
        kept = np.flatnonzero(whole & (there.table.count >= 0))
        table, places = at_places(there.table, kept), there.places[kept]
        owner = np.repeat(np.arange(len(places)), table.count)
        listed = as_checked(
            self.low, self.problem, self.of_machine.closure, table.values, known[places[owner]]
        )
        size = self.problem.closure.characteristic_length
        is_open = np.bincount(
            owner, ~(listed.residual <= CLOSURE_TOLERANCE * size), minlength=len(places)
        )
        order = order_of_modes(
            self.problem, listed.values, listed.position, listed.quaternion, owner
        )
        listed = replace(listed, certified=table.certified, radius=table.radius).chosen(order)
        told = {name: getattr(table, name) for name in PER_POINT}
        closed = np.flatnonzero(is_open == 0)
        found = at_places(table_of(self.problem, listed, **told), closed)
        return Plain(found, places[closed])
