"""What is said of a closed configuration: the result of `close`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from symkin.model.mechanism import Mechanism
from symkin.result import Result, Summary
from symkin.spatial.pose import Pose


@dataclass(frozen=True)
class LoopGap:
    """How far a closure or coupling is open in the file, and what is left at the closed
    configuration (length unit).
    """

    name: str
    open_by: float
    residual: float


@dataclass(frozen=True, eq=False, repr=False)
class ClosedConfiguration(Result):
    """The closed configuration nearest to a file's own.

    mobility = freedoms - rank, here as is `redundant`, the constraints that others imply (rows -
    rank where no motion is declared); `generic_rank` is that of closed configurations beside it,
    None where it is not clear, `infinitesimal` counts freedoms of first order that no motion
    follows there. `open_by` and `residual` are the largest of what the loops leave open in the file
    and here, `joints` the values of all joints in `units` (length, angle), `link_poses` the frames
    of links, and of bodies that are part of them, in the base frame. `closed` is False where no
    search closed the loops: then this is what comes nearest, and `notes` name the loop that
    resists. `reference` is the mechanism whose reference configuration this is, None where nothing
    closes or moves.

    >>> import symkin
    >>> found = symkin.close("jansen_leg")
    >>> found.open_by < 1e-9, found.mobility, found.reference.name
    (True, 1, 'jansen_leg')
    """

    mechanism: str
    units: tuple[str, str]
    links: int
    joint_count: int
    freedoms: int
    rows: int
    rank: int
    redundant: int
    generic_rank: int | None
    actuated: tuple[str, ...]
    loops: tuple[LoopGap, ...]
    open_by: float
    residual: float
    closed: bool
    joints: Mapping[str, float | list[float]]
    link_poses: Mapping[str, Pose]
    notes: tuple[str, ...] = ()
    reference: Mechanism | None = None
    infinitesimal: int = 0

    @property
    def mobility(self) -> int:
        """Freedoms that the constraints leave."""
        return self.freedoms - self.rank

    def summary(self, most_rows: int | None = None) -> Summary:
        """Mobility, how far the loops were open and are, then every joint's value."""
        length, angle = self.units
        above = [
            f"{self.mechanism}: mobility {self.mobility} = {self.freedoms} freedoms - rank "
            f"{self.rank} of {self.rows} rows; redundant "
            f"constraints: {self.redundant}"
        ]
        if not self.rows:
            above.append("it has no loop to close")
        elif self.closed:
            above.append(
                f"closed to {self.residual:.1e} {length}; the file's own configuration is open by "
                f"{self.open_by:.3g} {length}"
            )
        above += [
            f"  {loop.name}: open by {loop.open_by:.3g}, now {loop.residual:.1e}"
            for loop in self.loops
            if loop.open_by > 1e-9
        ]
        rows = [[name, _number(value)] for name, value in self.joints.items()]
        return Summary(
            above,
            ["joint", f"value [{length}, {angle}]"],
            rows[:most_rows],
            [f"note: {note}" for note in self.notes],
        )

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of `symkin close --json`."""
        rank = self.generic_rank
        return {
            "mechanism": self.mechanism,
            "length_unit": self.units[0],
            "angle_unit": self.units[1],
            "links": self.links,
            "joint_count": self.joint_count,
            "loops": self.joint_count - self.links + 1,
            "rows": self.rows,
            "rank": self.rank,
            "mobility": self.mobility,
            "redundant": self.redundant,
            "generic": {
                "rank": rank,
                "mobility": None if rank is None else self.freedoms - rank - self.infinitesimal,
                "redundant": None if rank is None else self.redundant + self.rank - rank,
            },
            "actuated": list(self.actuated),
            "closed": self.closed,
            "open_by": self.open_by,
            "residual": self.residual,
            "each_loop": [
                {"name": loop.name, "open_by": loop.open_by, "residual": loop.residual}
                for loop in self.loops
            ],
            "joints": dict(self.joints),
            "link_poses": {name: _pose(pose) for name, pose in self.link_poses.items()},
            "notes": list(self.notes),
        }


def _number(value: float | list[float]) -> str:
    return f"{value:.9g}" if isinstance(value, float) else ", ".join(f"{v:.6g}" for v in value)


def _pose(pose: Pose) -> dict[str, list[float]]:
    """Position and quaternion, its first number not negative."""
    sign = -1.0 if pose.quaternion[0] < 0.0 else 1.0
    return {
        "position": [float(v) for v in pose.position],
        "quaternion": [sign * float(v) + 0.0 for v in pose.quaternion],
    }
