"""How the axes of an arm lie to each other: parallel, meeting in a point, normal; and what pairs of
joints leave unchanged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.closed.screws import ArmScrews, Screw, Vector, snapped_vector

EXACT = 1e-10
"""Tolerance (rad, or of the size) within which axes are parallel or meet as they are described:
digits of a file, and rounding.
"""


@dataclass(frozen=True)
class Invariant:
    """What motions leave unchanged of a point: its level along a direction `vector`, or its
    distance from the point `vector`.
    """

    is_level: bool
    vector: Vector
    text: str


@dataclass(frozen=True, eq=False)
class AxisGeometry:
    """Relations of an arm's axes to within `tolerance` (rad, or of the size)."""

    arm: ArmScrews
    tolerance: float = EXACT

    def _screw(self, joint: int) -> Screw:
        return self.arm.screws[joint]

    def are_parallel(self, i: int, j: int) -> bool:
        return bool(
            np.linalg.norm(np.cross(self._screw(i).axis, self._screw(j).axis)) <= self.tolerance
        )

    def are_normal(self, i: int, j: int) -> bool:
        return bool(abs(np.dot(self._screw(i).axis, self._screw(j).axis)) <= self.tolerance)

    def meeting_point(self, joints: Sequence[int]) -> Vector | None:
        """The point in which axes of turning joints meet, of one joint the point of its axis; None
        where there is no single one.
        """
        screws = [self._screw(joint) for joint in joints]
        if not screws or any(screw.slides for screw in screws):
            return None
        if len(screws) == 1:
            return screws[0].point
        across = [np.eye(3) - np.outer(screw.axis, screw.axis) for screw in screws]
        normal = sum(across)
        if np.linalg.svd(normal, compute_uv=False)[-1] < self.tolerance:
            return None
        found = np.linalg.solve(
            normal, sum(a @ np.array(s.point) for a, s in zip(across, screws, strict=True))
        )
        away = max(
            float(np.linalg.norm(a @ (found - np.array(s.point))))
            for a, s in zip(across, screws, strict=True)
        )
        return (
            None if away > self.tolerance * self.arm.size else snapped_vector(found, self.arm.size)
        )

    def plane_normal(self, joints: Sequence[int]) -> int | None:
        """A turning joint to whose axis all turning ones of `joints` are parallel and all sliding
        ones normal; None where there is none.
        """
        turning = [joint for joint in joints if not self._screw(joint).slides]
        if not turning:
            return None
        first = turning[0]
        planar = all(
            self.are_normal(first, j) if self._screw(j).slides else self.are_parallel(first, j)
            for j in joints
        )
        return first if planar else None

    # --- what joints leave unchanged --------------------------------------------------------------

    def invariants(self, joint: int) -> list[Invariant]:
        """Two functions of a point that a joint leaves unchanged and that tell its orbits apart."""
        screw = self._screw(joint)
        if screw.slides:
            return [Invariant(True, v, f"level across {screw.name}") for v in across(screw.axis)]
        return [
            Invariant(True, screw.axis, f"level along the axis of {screw.name}"),
            Invariant(False, screw.point, f"distance from the axis of {screw.name}"),
        ]

    def common_invariant(self, i: int, j: int) -> Invariant | None:
        """A function of a point that two joints leave unchanged."""
        a, b = self._screw(i), self._screw(j)
        if a.slides and b.slides:
            if self.are_parallel(i, j):
                return None
            normal = np.cross(a.axis, b.axis)
            return Invariant(
                True,
                snapped_vector(normal / np.linalg.norm(normal), 1.0),
                f"level across {a.name} and {b.name}",
            )
        normal_joint = self.plane_normal((i, j))
        if normal_joint is not None:
            if not (a.slides or b.slides) and self._coincide(a, b):
                return None
            return Invariant(
                True,
                self._screw(normal_joint).axis,
                f"level along the parallel axes of {a.name} and {b.name}"
                if not (a.slides or b.slides)
                else f"level normal to the plane of {a.name} and {b.name}",
            )
        point = self.meeting_point((i, j))
        if point is None:
            return None
        return Invariant(
            False, point, f"distance from the point where the axes of {a.name} and {b.name} meet"
        )

    def _coincide(self, a: Screw, b: Screw) -> bool:
        gap = np.array(a.point) - np.array(b.point)
        return bool(np.linalg.norm(np.cross(a.axis, gap)) <= self.tolerance * self.arm.size)


def across(axis: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors normal to an axis and to each other, along the base frame's axes where that
    is possible.
    """
    k = np.array(axis)
    start = np.eye(3)[int(np.argmin(np.abs(k)))]
    first = start - k * (k @ start)
    first = first / np.linalg.norm(first)
    return snapped_vector(first, 1.0), snapped_vector(np.cross(k, first), 1.0)
