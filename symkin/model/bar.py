"""Rods with spherical ends, wherever a file describes them: legs, rods at the ends of limbs, rods
between links.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.model.joint import Coordinate
from symkin.spatial.pose import Pose


@dataclass(frozen=True)
class RodEnd:
    """One end of a rod: the key path of its point, and the point, in the platform frame or in the
    base frame at the reference.
    """

    path: str
    point: tuple[float, ...]
    in_platform_frame: bool = False

    def at_reference(self, platform: Pose) -> np.ndarray:
        """The point in the base frame at the reference, where the platform frame is at
        `platform`.
        """
        point = np.array(self.point)
        return platform.apply(point) if self.in_platform_frame else point


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
    def freedom(self) -> int:
        """Freedoms that it leaves the links at its ends: all but their distance, which one with a
        coordinate leaves too.
        """
        return 5 if self.coordinate is None else 6
