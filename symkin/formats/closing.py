"""The closed configuration of a robot that is nearest to the file's own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symkin.computed_once import cached_property
from symkin.formats.robot import Robot
from symkin.formats.tree import Tree
from symkin.numeric.nearest_root import NearestRoot
from symkin.numeric.tolerances import CLOSED_CONFIGURATION, FILE_DIGITS
from symkin.spatial.pose import Pose


@dataclass(frozen=True, eq=False)
class Closed:
    """The closed configuration of a robot that is nearest to the file's own, or what comes nearest
    to one: `state` holds the values of the tree's coordinates.

    `displacements` move links from their places in the file. `gaps` tell what each closure and
    coupling leaves open in the file, `residuals` what it leaves here (metres).
    """

    tree: Tree
    state: np.ndarray

    @cached_property
    def gaps(self) -> Mapping[str, float]:
        return self.tree.misfits(self.tree.own)

    @cached_property
    def residuals(self) -> Mapping[str, float]:
        return self.tree.misfits(self.state)

    @property
    def open_by(self) -> float:
        """How far the file's own configuration leaves the loops open."""
        return max(self.gaps.values(), default=0.0)

    @property
    def residual(self) -> float:
        """The largest closure error left."""
        return max(self.residuals.values(), default=0.0)

    @property
    def resists(self) -> str:
        """The closure or coupling that has it."""
        return max(self.residuals, key=lambda name: self.residuals[name], default="")

    @property
    def closed(self) -> bool:
        return self.residual <= CLOSED_CONFIGURATION * self.tree.size

    @property
    def to_digits(self) -> bool:
        """Whether the loops close, if only to the digits of a file."""
        return self.residual <= FILE_DIGITS * self.tree.size

    @cached_property
    def values(self) -> dict[str, tuple[float, ...]]:
        """Of every coordinate, in radians and metres; the quaternion of a ball from the file's
        configuration.
        """
        return self.tree.by_name(self.state)

    @cached_property
    def displacements(self) -> dict[str, Pose]:
        return self.tree.displacements(self.state)


def nearest_closed(robot: Robot) -> Closed:
    """Close the loops from the file's own configuration."""
    tree = Tree(robot)
    return Closed(tree, NearestRoot(tree.system, tree.own).found())
