"""What modules ask of a mechanism that it imports itself: it checks and writes itself, so that they
cannot import its class.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Protocol

from symkin.model.dh import DHTable
from symkin.model.graph import Coupling, LinkJoint, LinkPoint, LinkRod
from symkin.model.joint import Coordinate, Joint
from symkin.model.limb import Limb, RodLimb


class Graph(Protocol):
    """Links and what joins them."""

    @property
    def limbs(self) -> Sequence[Limb | RodLimb]: ...
    @property
    def link_joints(self) -> Sequence[LinkJoint]: ...
    @property
    def link_rods(self) -> Sequence[LinkRod]: ...
    @property
    def couplings(self) -> Sequence[Coupling]: ...
    @property
    def link_points(self) -> Sequence[LinkPoint]: ...
    @property
    def platform_link(self) -> str | None: ...
    @property
    def platform_position(self) -> Sequence[float]: ...
    @property
    def platform_quaternion(self) -> Sequence[float]: ...
    @property
    def motion(self) -> str: ...
    @property
    def all_joints(self) -> Iterator[Joint]: ...
    @property
    def coordinates(self) -> tuple[Coordinate, ...]: ...


class Description(Graph, Protocol):
    """All that a mechanism file says."""

    @property
    def angle_unit(self) -> str: ...
    @property
    def serial(self) -> bool: ...
    @property
    def joints(self) -> Iterator[tuple[Limb | RodLimb, Joint]]: ...
    @property
    def dh(self) -> DHTable | None: ...
    @property
    def example(self) -> object | None: ...
    @property
    def is_graph(self) -> bool: ...


def unit_of_coordinates(described: Description) -> dict[str, float]:
    """The unit of each coordinate in its file, by name: radians of a degree, or 1."""
    degree = math.radians(1.0) if described.angle_unit == "deg" else 1.0
    return {c.name: degree if c.is_angular else 1.0 for c in described.coordinates}
