"""Describe arms by Denavit-Hartenberg tables, and turn these into joints at the reference
configuration.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from symkin.errors import MechanismError
from symkin.model.joint import finite, interval
from symkin.spatial.backend import Array, vector
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import quaternion_from_axis_angle
from symkin.text import not_among

_X, _Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class DHRow:
    """One row of a Denavit-Hartenberg table; the joint value adds to `theta` (R) or `d` (P).

    `theta`, `alpha` in radians, `d`, `a` in the length unit; `limits` (low, high) is a range of the
    joint value. Raises MechanismError for another type and numbers that are not finite.

    >>> import math, symkin
    >>> symkin.DHRow("q1", d=105.03, alpha=math.pi / 2).type
    'R'
    """

    name: str
    type: Literal["R", "P"] = "R"
    theta: float = 0.0
    d: float = 0.0
    a: float = 0.0
    alpha: float = 0.0
    limits: Sequence[float] | None = None

    def __post_init__(self) -> None:
        if self.type not in ("R", "P"):
            raise MechanismError(f"dh row {self.name!r}: type = {not_among(self.type, ('R', 'P'))}")
        for key in ("theta", "d", "a", "alpha"):
            object.__setattr__(
                self, key, finite(getattr(self, key), f"dh row {self.name!r}: {key}")
            )
        object.__setattr__(self, "limits", interval(self.limits, f"dh row {self.name!r}: limits"))


@dataclass(frozen=True)
class DHTable:
    """A Denavit-Hartenberg table: the tool's pose is the product of the rows' displacements A.

    "standard": A = Rz(theta) Tz(d) Tx(a) Rx(alpha), joint i along z of frame i-1. "modified"
    (Craig): A = Rx(alpha) Tx(a) Rz(theta) Tz(d), joint i along z of frame i, a and alpha of the
    link before it. `rows` hold at least one DHRow; raises MechanismError otherwise, and for another
    convention. `symkin.serial_arm_from_dh` makes a Mechanism of it.

    >>> import symkin
    >>> rows = [symkin.DHRow("q1", a=120.0), symkin.DHRow("q2", a=80.0)]
    >>> arm = symkin.serial_arm_from_dh("two_links", symkin.DHTable("standard", rows))
    >>> [float(v) for v in arm.platform_position]
    [200.0, 0.0, 0.0]

    Sources: J. Denavit, R. S. Hartenberg, J. Applied Mechanics 22 (1955) 215; J. J. Craig,
    Introduction to Robotics, 1986.
    """

    convention: Literal["standard", "modified"]
    rows: Sequence[DHRow]

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", tuple(self.rows))
        if self.convention not in ("standard", "modified"):
            raise MechanismError(
                f"dh.convention = {not_among(self.convention, ('standard', 'modified'))}"
            )
        if not self.rows:
            raise MechanismError("dh.rows is empty; a serial arm needs at least one joint")


def reference_frames(
    convention: str, rows: Sequence[Sequence[Array]]
) -> tuple[list[tuple[Array, Array]], Pose]:
    """(point, axis) of each joint and the tool pose at zero joint values; `rows` hold (theta, d, a,
    alpha), floats or CasADi.
    """
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
