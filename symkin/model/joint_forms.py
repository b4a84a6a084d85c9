"""The table of joint types: a new one goes here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from symkin.spatial.screw import prismatic_screw, revolute_screw

JointType = Literal["R", "P", "H", "C", "U", "S", "weld"]
Kind = Literal["length", "angle", "turns", "quaternion"]
"""length; angle modulo a turn; turns: an angle that advances (helical joint), not periodic; unit
quaternion.
"""
Relation = Literal["point", "line", "axis", "axes' angle", "orientation"]
"""What a joint keeps between its two links: a point on both, a line on which a point stays, a
common direction, the angle between its two axes, all directions.
"""

NUMBERS: dict[Kind, tuple[int, int]] = {
    "length": (1, 1),
    "angle": (1, 1),
    "turns": (1, 1),
    "quaternion": (4, 3),
}
"""Numbers that hold a coordinate of each kind, and independent ways in which it changes."""


How = Literal["turn", "slide", "screw", "ball"]
"""An elementary motion: about an axis, along it, both at once, about a point."""
_KINDS: dict[How, Kind] = {
    "turn": "angle",
    "slide": "length",
    "screw": "turns",
    "ball": "quaternion",
}


class Move(NamedTuple):
    """An elementary motion of a joint: what is added to the joint's name for its coordinate, and
    the number of its axis.
    """

    how: How
    suffix: str = ""
    axis: int = 0


@dataclass(frozen=True)
class JointForm:
    """What joints of a type have: elementary `moves` in their order, how many `axes`, whether their
    `point` means something, and the relations that they keep (`kept`), which are the rows of a loop
    that is cut there; None where no loop is.
    """

    moves: tuple[Move, ...]
    axes: int
    has_point: bool
    kept: tuple[Relation, ...] | None

    @property
    def coordinates(self) -> tuple[tuple[str, Kind], ...]:
        """What is added to the joint's name, and the kind, of each coordinate."""
        return tuple((move.suffix, _KINDS[move.how]) for move in self.moves)

    @property
    def freedom(self) -> int:
        """Count of degrees of freedom."""
        return sum(NUMBERS[kind][1] for _, kind in self.coordinates)

    def screws(self, point: np.ndarray, axes: Sequence[np.ndarray], pitch: float) -> np.ndarray:
        """Unit twists of the freedoms (freedom, 6), angular velocity and velocity at the origin, of
        a joint there; `pitch` is a length per turn.
        """
        found = []
        for move in self.moves:
            if move.how == "slide":
                found.append(prismatic_screw(axes[move.axis]))
                continue
            lead = pitch if move.how == "screw" else 0.0
            about = np.eye(3) if move.how == "ball" else [axes[move.axis]]
            found += [revolute_screw(point, axis, lead) for axis in about]
        return np.array(found).reshape(-1, 6)


JOINT_FORMS: dict[JointType, JointForm] = {
    "R": JointForm((Move("turn"),), 1, True, ("point", "axis")),
    "P": JointForm((Move("slide"),), 1, False, ("line", "orientation")),
    "H": JointForm((Move("screw"),), 1, True, None),
    "C": JointForm((Move("turn", ".angle"), Move("slide", ".slide")), 1, True, ("line", "axis")),
    "U": JointForm((Move("turn", ".1"), Move("turn", ".2", 1)), 2, True, ("point", "axes' angle")),
    "S": JointForm((Move("ball"),), 0, True, ("point",)),
    "weld": JointForm((), 0, False, None),
}
JOINT_TYPES: tuple[JointType, ...] = ("R", "P", "H", "C", "U", "S")
"""Those that move."""
