"""Rods with spherical ends, wherever a file describes them: legs, rods at the ends of limbs, rods
between links.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.model.joint import Coordinate
from symkin.spatial.pose import Pose


@dataclass(frozen=True)
class RodEnd:
    """One end of a rod: the key path of its point, and the point, in the platform frame or in the
    base frame at the reference; of a platform's point `there` is that in the base frame.
    """

    path: str
    point: tuple[float, ...]
    there: tuple[float, ...] | None = None

    @staticmethod
    def of_platform(path: str, point: Sequence[float], platform: Pose) -> RodEnd:
        """An end in the platform frame, which is at `platform` at the reference."""
        return RodEnd(path, tuple(point), tuple(platform.apply(np.array(point)).tolist()))

    @property
    def in_platform_frame(self) -> bool:
        return self.there is not None


@dataclass(frozen=True)
class Bar:
    """A rod with spherical ends: of fixed `length` (None: as at the reference), or with a
    `coordinate` beyond `offset`. It `spins` about itself unless an end is a universal joint.
    """

    name: str
    start: RodEnd
    end: RodEnd
    path: str
    length: float | None = None
    offset: float = 0.0
    coordinate: Coordinate | None = None
    spins: bool = True

    @property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Its ends in the base frame at the reference."""
        return np.array(self.start.there or self.start.point), np.array(
            self.end.there or self.end.point
        )

    @property
    def reference_length(self) -> float:
        """Distance of the ends at the reference."""
        return float(np.linalg.norm(np.subtract(*self.places)))

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Its coordinate, if it has one."""
        return () if self.coordinate is None else (self.coordinate,)

    def driven(self, limits: Sequence[float] | None) -> Bar:
        """The same with a coordinate, whose range is within `limits`."""
        bounds = None if limits is None else (limits[0], limits[1])
        reference = self.reference_length - self.offset
        c = Coordinate(self.name, "length", "actuated", (reference,), bounds, least=-self.offset)
        return replace(self, coordinate=c)

    @property
    def freedom(self) -> int:
        """Freedoms that it leaves the links at its ends: all but their distance, which one with a
        coordinate leaves too.
        """
        return 5 if self.coordinate is None else 6
