"""Denavit-Hartenberg tables, turned into joints at the reference configuration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from symkin.errors import MechanismError
from symkin.model.joint import finite, interval
from symkin.spatial.backend import Array, vector
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import quaternion_from_axis_angle

_X, _Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class DHRow:
    """One row; the joint value adds to `theta` (R) or `d` (P). Angles in radians."""

    name: str
    type: Literal["R", "P"] = "R"
    theta: float = 0.0
    d: float = 0.0
    a: float = 0.0
    alpha: float = 0.0
    limits: Sequence[float] | None = None

    def __post_init__(self) -> None:
        if self.type not in ("R", "P"):
            raise MechanismError(f"dh row {self.name!r}: type = {self.type!r} is unknown; allowed: R, P")
        for key in ("theta", "d", "a", "alpha"):
            object.__setattr__(self, key, finite(getattr(self, key), f"dh row {self.name!r}: {key}"))
        object.__setattr__(self, "limits", interval(self.limits, f"dh row {self.name!r}: limits"))


@dataclass(frozen=True)
class DHTable:
    """standard: A = Rz(theta) Tz(d) Tx(a) Rx(alpha), joint i along z of frame i-1; modified (Craig): A = Rx(alpha)
    Tx(a) Rz(theta) Tz(d), joint i along z of frame i, a and alpha of the link before it."""

    convention: Literal["standard", "modified"]
    rows: Sequence[DHRow]

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", tuple(self.rows))
        if self.convention not in ("standard", "modified"):
            raise MechanismError(f"dh.convention = {self.convention!r} is unknown; allowed: standard, modified")
        if not self.rows:
            raise MechanismError("dh.rows is empty; a serial arm needs at least one joint")


def reference_frames(convention: str, rows: Sequence[Sequence[Array]]) -> tuple[list[tuple[Array, Array]], Pose]:
    """(point, axis) of each joint and the tool pose at zero joint values; `rows` hold (theta, d, a, alpha), floats or
    CasADi."""
    frame = Pose.identity()
    joints = []
    for theta, d, a, alpha in rows:
        about_x = Pose(vector(a, 0.0, 0.0), quaternion_from_axis_angle(_X, alpha))
        along_z = Pose(vector(0.0, 0.0, d), quaternion_from_axis_angle(_Z, theta))
        if convention == "modified":
            frame = frame @ about_x
        joints.append((frame.position, frame.turn(vector(*_Z))))
        frame = frame @ along_z
        if convention == "standard":
            frame = frame @ about_x
    return joints, frame
