"""Write the C of a map's values and their numbers: of an angle cosine and sine, in a configuration
y, in states and beside limits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symkin.codegen.joint_map import JointMap
from symkin.codegen.joint_ranges import range_of
from symkin.codegen.text.angles import number_counts
from symkin.codegen.text.c import indexed
from symkin.codegen.text.templates import FARTHEST
from symkin.model.joint import Coordinate


def places_among(coordinates: Sequence[Coordinate], wanted: Sequence[Coordinate]) -> list[int]:
    """Places of the numbers of wanted coordinates among those of coordinates that stand beside each
    other.
    """
    places, start = {}, 0
    for c, count in zip(coordinates, number_counts(coordinates), strict=True):
        places[c.name] = list(range(start, start + count))
        start += count
    return [i for c in wanted for i in places[c.name]]


@dataclass(frozen=True, eq=False)
class MapValues:
    """Statements and C text of one map's values."""

    made: JointMap

    def limits(
        self, coordinates: Sequence[Coordinate], *, bounded: bool = True
    ) -> list[tuple[float, float]]:
        """Least and largest value of each coordinate: its limits with slack if `bounded`, else how
        far it may be.
        """
        size, found = self.made.size, []
        for c in coordinates:
            far = FARTHEST * (1.0 if c.is_angular else size)
            found.append(range_of(c, self.made.real, size) if bounded and c.limits else (-far, far))
        return found

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
        lines, k = [], 0
        for i, c in enumerate(coordinates):
            if c.kind == "angle":
                lines.append(
                    f"{self.made.name}_cosine_and_sine({values[i]}, &{target}[{places[k]}]);"
                )
                k += 2
            else:
                lines.append(f"{target}[{places[k]}] = {values[i]};")
                k += 1
        return lines

    def turned(self, c: Coordinate, angle: str, near: str) -> str:
        """C text of an angle moved by whole turns next to another, within its limits."""
        ((low, high),) = self.limits([c])
        return (
            f"{self.made.name}_turned({angle}, {near}, {self.made.real.literal(low)}, "
            f"{self.made.real.literal(high)})"
        )

    def plain_values(self, coordinates: Sequence[Coordinate], numbers: Sequence[str]) -> list[str]:
        """C text of the values of coordinates by their numbers, angles within half a turn of 0."""
        found, k = [], 0
        angle = (
            f"{self.made.name}_angle"
            if self.made.real.name == "float"
            else self.made.real.call("atan2")
        )
        for c in coordinates:
            found.append(
                f"{angle}({numbers[k + 1]}, {numbers[k]})" if c.kind == "angle" else numbers[k]
            )
            k += 2 if c.kind == "angle" else 1
        return found

    def values_of(
        self, coordinates: Sequence[Coordinate], numbers: Sequence[str], near: str
    ) -> list[str]:
        """C text of the values of coordinates by their numbers, angles next to `near`."""
        found = []
        for i, (c, value) in enumerate(
            zip(coordinates, self.plain_values(coordinates, numbers), strict=True)
        ):
            found.append(self.turned(c, value, f"{near}[{i}]") if c.kind == "angle" else value)
        return found
