"""A serial arm as a product of exponentials: its one-freedom joints as screws at the reference
configuration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.closure.snapping import snap
from symkin.machine.frame import simplest_turn
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Screw:
    """One freedom of an arm: it turns about, or slides along, the unit `axis` through `point`, by
    its coordinate less `zero`.
    """

    name: str
    slides: bool
    point: Vector
    axis: Vector
    zero: float


@dataclass(frozen=True, eq=False)
class ArmScrews:
    """Screws from the base to the tool, the tool's pose at the reference, and the arm's size
    (length unit), in the frame in which these numbers are simplest; the matrix of `base` turns
    vectors as they are described into it (None: it is the described one).
    """

    screws: tuple[Screw, ...]
    tool: Pose
    size: float
    base: Pose | None = None

    def told(self, pose: Pose) -> Pose:
        """A pose of this frame as it is described."""
        return pose if self.base is None else self.base.inverse() @ pose

    def __len__(self) -> int:
        return len(self.screws)


def arm_screws(mechanism: Mechanism) -> ArmScrews | None:
    """The screws of a serial arm of R and P joints, numbers free of rounding; None for other
    mechanisms.
    """
    joints = [joint for _, joint in mechanism.joints]
    if not mechanism.serial or any(joint.type not in ("R", "P") for joint in joints):
        return None
    size = mechanism.characteristic_length
    axes = np.array([joint.axis for joint in joints], dtype=float)
    points = np.array([mechanism.places[joint.name] for joint in joints])
    # the points next to the first joint: their numbers are small, and some of them zero
    away = points - points[0]
    points = np.array([points[0] + a - k * (k @ a) for k, a in zip(axes, away, strict=True)])
    tool = Pose(mechanism.platform_position, mechanism.platform_quaternion)
    base = None
    vectors = np.vstack([axes, points / size])
    turn = simplest_turn(vectors, vectors, in_plane=False)
    if turn is not None:
        base = Pose.from_matrix(turn, np.zeros(3))
        axes, points, tool = axes @ turn.T, points @ turn.T, base @ tool
    found = [
        Screw(j.name, j.type == "P", snapped_vector(p, size), snapped_vector(k, 1.0), j.zero)
        for j, p, k in zip(joints, points, axes, strict=True)
    ]
    place = np.array(snapped_vector(np.array(tool.position), size))
    return ArmScrews(tuple(found), Pose(place, tool.quaternion), size, base)


def snapped_vector(numbers: np.ndarray, scale: float) -> Vector:
    x, y, z = (snap(float(value), scale) for value in numbers)
    return x, y, z
