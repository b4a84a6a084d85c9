"""A serial arm as a product of exponentials: its one-freedom joints as screws at the reference
configuration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.closure.snapping import snap
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
    (length unit).
    """

    screws: tuple[Screw, ...]
    tool: Pose
    size: float

    def __len__(self) -> int:
        return len(self.screws)


def arm_screws(mechanism: Mechanism) -> ArmScrews | None:
    """The screws of a serial arm of R and P joints, numbers free of rounding; None for other
    mechanisms.
    """
    joints = [joint for _, joint in mechanism.joints]
    if not mechanism.serial or any(joint.type not in ("R", "P") for joint in joints):
        return None
    origin, size = mechanism.places[joints[0].name], mechanism.characteristic_length
    found: list[Screw] = []
    for joint in joints:
        k = np.array(joint.axis, dtype=float)
        away = np.array(mechanism.places[joint.name]) - origin
        # the point next to the first joint: its numbers are small, and some of them zero
        point = snapped_vector(origin + away - k * (k @ away), size)
        found.append(
            Screw(joint.name, joint.type == "P", point, snapped_vector(k, 1.0), joint.zero)
        )
    tool = Pose(
        np.array(snapped_vector(np.array(mechanism.platform_position), size)),
        np.array(mechanism.platform_quaternion),
    )
    return ArmScrews(tuple(found), tool, size)


def snapped_vector(numbers: np.ndarray, scale: float) -> Vector:
    x, y, z = (snap(float(value), scale) for value in numbers)
    return x, y, z
