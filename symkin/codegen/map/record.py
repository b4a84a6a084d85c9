"""Say of any machine what its C is written from, whatever is known and found in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from symkin.codegen.map.options import Options
from symkin.codegen.map.signature import Function
from symkin.codegen.steps.geometry import Geometry
from symkin.codegen.steps.joint_ranges import range_of
from symkin.codegen.text.c import Real
from symkin.codegen.text.templates import fill
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism

_MOST_TURNS = 1e4
"""Whole turns beyond which an angle is not moved: a float of them tells no angle."""


@dataclass(frozen=True, eq=False)
class Described:
    """A machine with its options. `templates` begins the names of its test's and example's parts;
    `of_poses`: a pose is what it finds, or what is given.
    """

    mechanism: Mechanism
    options: Options
    real: Real
    templates: ClassVar[str]
    of_poses: ClassVar[bool] = True

    @property
    def name(self) -> str:
        return self.mechanism.name

    @property
    def size(self) -> float:
        return self.mechanism.characteristic_length

    @property
    def geometry(self) -> Geometry:
        raise NotImplementedError

    @property
    def actuated(self) -> tuple[Coordinate, ...]:
        return self.mechanism.actuated

    @property
    def functions(self) -> tuple[Function, ...]:
        """The functions of its interface, in the order of their declarations."""
        raise NotImplementedError

    @property
    def told(self) -> dict[str, tuple[Coordinate, ...]]:
        """The coordinates of each array of values."""
        return {"joints": self.actuated}

    @property
    def zero(self) -> np.ndarray | float:
        """Joint values at home, where joints are changes from there."""
        return 0.0

    @property
    def about_values(self) -> list[str]:
        """What the header says of joint values and poses that are changes from home."""
        return []

    @property
    def is_redundant(self) -> bool:
        """Whether a pose leaves joints free."""
        return False

    @property
    def has_dead_centres(self) -> bool:
        """Whether the values leave a limb more than one way to stand."""
        return False

    @property
    def can_be_compact(self) -> bool:
        """Whether there is code that --compact makes shorter."""
        return False

    @property
    def is_closed(self) -> bool:
        """Whether formulas solve a platform's direct problem."""
        return False

    def check(self) -> None:
        """Raises InputError where a generated solver could not work."""


@dataclass(frozen=True, eq=False)
class Source:
    """What writes a part of one machine's C."""

    made: Described

    @property
    def real(self) -> Real:
        return self.made.real

    @property
    def name(self) -> str:
        return self.made.name

    def array(self, values: Sequence[float] | np.ndarray) -> str:
        """C text of the numbers of an array."""
        return ", ".join(map(str, values))

    def turned(self, c: Coordinate, angle: str, near: str) -> str:
        """C text of an angle moved by whole turns next to another, within its limits."""
        if c.limits is None:
            return f"name_nearest({angle}, {near})"
        limits = self.array(range_of(c, self.real, self.made.size))
        return f"name_turned({angle}, {near}, {limits})"

    def into_limits(self, at: str, near: str) -> list[str]:
        """Statements that turn limited angles of an array of joints by whole turns towards another,
        as far as their limits allow: a pose does not tell turns.
        """
        return [
            f"{at}[{i}] = {self.turned(c, f'{at}[{i}]', f'{near}[{i}]')};"
            for i, c in enumerate(self.made.actuated)
            if c.is_periodic and c.limits is not None
        ]

    def unwrapped(
        self, target: str, values: str, at: str, coordinates: Sequence[Coordinate] = ()
    ) -> list[str]:
        """Statements that take whole turns off angles without limits, of joints or others, so that
        the nearer way from `at` is meant.
        """
        return [
            f"{target}[{i}] = {self.turned(c, value, f'{at}[{i}]')};"
            if c.is_periodic and c.limits is None
            else f"{target}[{i}] = {value};"
            for i, c in enumerate(coordinates or self.made.actuated)
            for value in [f"{values}[{i}]"]
        ]

    def turning(self, text: str, values: Mapping[str, object]) -> str:
        """The functions that move an angle by whole turns, where a text calls them."""
        shown, found = {**values, "many": _MOST_TURNS}, ""
        for called, template in (("turned", "turned_angle.c"), ("nearest", "nearest_turn.c")):
            if f"_{called}(" in found + text:
                found = fill(template, shown) + found
        return found
