"""What a closure must hold for what is given, and the names of a pose's coordinates."""

from __future__ import annotations

from dataclasses import dataclass

POSE_COORDINATES: dict[str, tuple[tuple[str, str], ...]] = {
    "spatial": (("x", "length"), ("y", "length"), ("z", "length"), ("quaternion", "quaternion")),
    "schoenflies": (("x", "length"), ("y", "length"), ("z", "length"), ("gamma", "angle")),
    "planar": (("x", "length"), ("y", "length"), ("gamma", "angle")),
    "translation": (("x", "length"), ("y", "length"), ("z", "length")),
    "spherical": (("quaternion", "quaternion"),),
}


@dataclass(frozen=True)
class Partition:
    """What a closure must hold, for what is given: joint coordinates by name (`kept`), and whether
    the platform of a graph has pose coordinates; `pose_conditions` are coordinates of its pose that
    are given one by one, as variables with rows of their own; with `geometry`, points and lengths
    are known coordinates too. Any closure holds the actuated joints and those that couplings name.
    """

    kept: frozenset[str] = frozenset()
    pose: bool = False
    pose_conditions: tuple[str, ...] = ()
    geometry: bool = False


ALL_JOINTS = Partition()
"""No more than any closure holds."""
