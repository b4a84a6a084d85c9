"""Write the C of a map's values and their numbers: of an angle cosine and sine, in a configuration
y, in states and beside limits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symkin.codegen.map.joint_map import JointMap
from symkin.codegen.map.record import Source
from symkin.codegen.text.angles import number_counts
from symkin.codegen.text.c import indexed
from symkin.model.joint import Coordinate, places_of


def places_among(coordinates: Sequence[Coordinate], wanted: Sequence[Coordinate]) -> list[int]:
    """Places of the numbers of wanted coordinates among those of coordinates that stand beside each
    other.
    """
    places = places_of(coordinates, number_counts(coordinates))
    return [i for c in wanted for i in places[c.name]]


@dataclass(frozen=True, eq=False)
class MapValues(Source):
    """Statements and C text of one map's values."""

    made: JointMap

    def places(self, coordinates: Sequence[Coordinate]) -> list[int]:
        """Where the numbers of coordinates stand in y."""
        return places_among(self.made.coordinates, coordinates)

    def copies(self, target: str, coordinates: Sequence[Coordinate]) -> list[str]:
        """Statements that copy numbers of coordinates from y."""
        return [f"{target}[{i}] = y[{place}];" for i, place in enumerate(self.places(coordinates))]

    def into_y(self, source: str, coordinates: Sequence[Coordinate]) -> list[str]:
        """Statements that copy numbers of coordinates into y."""
        return [f"y[{place}] = {source}[{i}];" for i, place in enumerate(self.places(coordinates))]

    def circles(
        self, values: str, coordinates: Sequence[Coordinate], target: str, places: Sequence[int]
    ) -> list[str]:
        """Statements that set the numbers of coordinates by an array of their values."""
        return self.circles_of(indexed(values, len(coordinates)), coordinates, target, places)

    def circles_of(
        self,
        values: Sequence[str],
        coordinates: Sequence[Coordinate],
        target: str,
        places: Sequence[int],
    ) -> list[str]:
        """Statements that set the numbers of coordinates by C text of their values."""
        lines, place = [], iter(places)
        for c, value in zip(coordinates, values, strict=True):
            entry = f"{target}[{next(place)}]"
            if c.is_periodic:
                lines.append(f"name_cosine_and_sine({value}, &{entry});")
                next(place)
            else:
                lines.append(f"{entry} = {value};")
        return lines

    def nearest(self, c: Coordinate, value: str, near: str) -> str:
        """C text of a value; of an angle's, the one of its whole turns that is nearest to another
        value.
        """
        return self.turned(c, value, near) if c.is_periodic else value

    def plain_values(self, coordinates: Sequence[Coordinate], numbers: Sequence[str]) -> list[str]:
        """C text of the values of coordinates by their numbers, angles within half a turn of 0."""
        entry, found = iter(numbers), list[str]()
        for c in coordinates:
            first = next(entry)
            found.append(f"atan2({next(entry)}, {first})" if c.is_periodic else first)
        return found

    def values_of(
        self, coordinates: Sequence[Coordinate], numbers: Sequence[str], near: str
    ) -> list[str]:
        """C text of the values of coordinates by their numbers, angles next to `near`."""
        plain = self.plain_values(coordinates, numbers)
        return [
            self.nearest(c, value, f"{near}[{i}]")
            for i, (c, value) in enumerate(zip(coordinates, plain, strict=True))
        ]
