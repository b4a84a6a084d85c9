"""A file that shows what a link looks like: a reference, which kinematics never reads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.spatial.pose import Pose


@dataclass(frozen=True)
class LinkMesh:
    """A mesh that shows a link.

    `file` is the path where it is found, else what a robot's file writes; `position` (3, length
    unit) and `quaternion` (w, x, y, z) are its frame in the base frame at the reference
    configuration, `scale` (3) is that of its own numbers along its axes.
    """

    link: str
    file: str
    position: Sequence[float] = (0.0, 0.0, 0.0)
    quaternion: Sequence[float] = (1.0, 0.0, 0.0, 0.0)
    scale: Sequence[float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        for key in ("position", "quaternion", "scale"):
            object.__setattr__(self, key, tuple(float(number) for number in getattr(self, key)))

    @property
    def pose(self) -> Pose:
        """The mesh's frame in the base frame at the reference configuration."""
        return Pose(np.array(self.position), np.array(self.quaternion))
