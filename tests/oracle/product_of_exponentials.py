"""What joints do to their links, by matrix exponentials of their screws, from the words of the
mechanism file alone.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import symkin

Values = Mapping[str, object]
"""Coordinates by name: numbers, and unit quaternions (w, x, y, z) of spherical joints."""


def random_values(mechanism: symkin.Mechanism, seed: int) -> dict[str, object]:
    """A value for every coordinate of a mechanism, beside its reference."""
    rng = np.random.default_rng(seed)
    found: dict[str, object] = {}
    for c in mechanism.coordinates:
        step = rng.normal(size=4 if c.width == 4 else 1)
        scale = mechanism.characteristic_length if c.kind == "length" else 1.0
        found[c.name] = (
            step / np.linalg.norm(step)
            if c.width == 4
            else float(c.reference[0] + 0.5 * scale * step[0])
        )
    return found


def displacement(joint: symkin.Joint, values: Values) -> np.ndarray:
    """The displacement (4, 4) of a joint's second link in its first from the reference, at values
    of coordinates.
    """
    name, point = joint.name, np.array(joint.point)
    match joint.type:
        case "weld":
            return np.eye(4)
        case "S":
            w, x, y, z = np.asarray(values[name])
            turn = np.eye(4)
            turn[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix()
            turn[:3, 3] = point - turn[:3, :3] @ point
            return turn
        case "U":
            first, second = (_turn(point, axis) for axis in (joint.axis, joint.axis2))
            return np.asarray(
                expm(first * values[f"{name}.1"]) @ expm(second * values[f"{name}.2"])
            )
        case "C":
            return np.asarray(
                expm(
                    _turn(point, joint.axis) * values[f"{name}.angle"]
                    + _slide(joint.axis) * values[f"{name}.slide"]
                )
            )
        case "P":
            return np.asarray(expm(_slide(joint.axis) * (values[name] - joint.zero)))
        case _:
            screw = _turn(point, joint.axis) + _slide(joint.axis) * (joint.pitch / (2 * np.pi))
            return np.asarray(expm(screw * (values[name] - joint.zero)))


def between_links(mechanism: symkin.Mechanism, values: Values) -> dict[str, tuple[str, np.ndarray]]:
    """By joint of a graph: the link that comes first in the alphabet, and the other's displacement
    in it.
    """
    found = {}
    for entry in mechanism.link_joints:
        moved, (first, second) = displacement(entry.joint, values), entry.links
        found[entry.joint.name] = (
            (first, moved) if first < second else (second, np.linalg.inv(moved))
        )
    return found


def _turn(point: np.ndarray, axis: object) -> np.ndarray:
    direction, screw = np.asarray(axis), np.zeros((4, 4))
    screw[:3, :3] = np.cross(np.eye(3), direction)
    screw[:3, 3] = np.cross(point, direction)
    return screw


def _slide(axis: object) -> np.ndarray:
    screw = np.zeros((4, 4))
    screw[:3, 3] = np.asarray(axis)
    return screw
