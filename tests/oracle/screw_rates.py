"""Rates of coordinates by others from joint screws: an account of its own beside the closure's
rows.

Every link has a twist about the base's origin; each joint says that those of its two links
differ by its screws times its rates, each rod that its ends keep their distance, each coupling
what it says. What all motions have in common is their null space.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from helpers.inside import as_graph
from symkin import Mechanism, Pose

Values = Mapping[str, Any]
_METRES = {"m": 1.0, "mm": 1e-3}


@dataclass
class _Rows:
    """Linear equations in named columns; angular velocities and angles are multiplied by the
    size."""

    size: float
    columns: dict[tuple[str, int], int] = field(default_factory=dict)
    rows: list[dict[int, float]] = field(default_factory=list)

    def place(self, name: str, part: int) -> int:
        return self.columns.setdefault((name, part), len(self.columns))

    def add(self, *terms: tuple[str, Sequence[float]]) -> None:
        row: dict[int, float] = {}
        for name, weights in terms:
            for part, weight in enumerate(weights):
                if weight != 0.0:
                    place = self.place(name, part)
                    row[place] = row.get(place, 0.0) + weight
        self.rows.append(row)

    def matrix(self) -> np.ndarray:
        found = np.zeros((len(self.rows), len(self.columns)))
        for k, row in enumerate(self.rows):
            found[k, list(row)] = list(row.values())
        return found


def screw_rates(
    mechanism: Mechanism,
    poses: Mapping[str, Pose],
    values: Values,
    of: Sequence[str],
    by: Sequence[str],
) -> tuple[np.ndarray, float]:
    """of' = J by' (length unit, rad) and the least singular value by which `by` decide the
    motion, at displacements of all links and values of all scalar coordinates (length unit,
    rad); NaN where `of` is not decided. `platform` is the link of the pose."""
    graph, metres = as_graph(mechanism), _METRES[mechanism.length_unit]
    size = mechanism.characteristic_length
    rows = _Rows(size)
    poses = _with_carriers(graph, poses, metres)
    for entry in graph.link_joints:
        _add_joint(rows, entry, poses, metres)
    for rod in graph.link_rods:
        _add_rod(rows, rod, poses, metres)
    scale = {c.name: size if c.is_angular else 1.0 for c in mechanism.coordinates}
    for coupling in mechanism.couplings:
        _add_coupling(rows, coupling, values, scale)
    link = mechanism.platform_link or "platform"
    if link in poses and any(
        name in ("x", "y", "z", "tilt", "torsion", "azimuth") for name in (*of, *by)
    ):
        scale |= _add_pose(rows, mechanism, poses[link], link)
    names = [*of, *by]
    places = [rows.place(name, 0) for name in names]
    singular, right = np.linalg.svd(rows.matrix())[1:]
    rank = int(np.sum(singular > 1e-9 * singular[0]))
    motions = right[rank:, places].T
    wanted, told = motions[: len(of)], motions[len(of) :]
    decided = (
        float(np.linalg.svd(told, compute_uv=False)[len(by) - 1])
        if min(told.shape) >= len(by)
        else 0.0
    )
    jacobian = wanted @ np.linalg.pinv(told, rcond=1e-9)
    left = np.abs(wanted - jacobian @ told).max(axis=1, initial=0.0)
    jacobian[left > 1e-7] = np.nan
    weights = np.array([scale[name] for name in names])
    return jacobian / weights[: len(of), None] * weights[len(of) :], decided


def _with_carriers(graph: Mechanism, poses: Mapping[str, Pose], metres: float) -> dict[str, Pose]:
    """Displacements of the links that carry a platform of restricted motion too: they do not
    turn, and go where its origin is."""
    found = dict(poses)
    for entry in graph.link_joints:
        if not set(entry.links) <= set(found):
            at = np.array(entry.joint.point) / metres
            found |= {
                link: Pose(poses["platform"].apply(at) - at, (1, 0, 0, 0))
                for link in entry.links
                if link not in found
            }
    return found


def _moment(p: np.ndarray, direction: np.ndarray) -> np.ndarray:
    return np.cross(p, direction)


def _add_joint(rows: _Rows, entry: Any, poses: Mapping[str, Pose], metres: float) -> None:
    joint, (a, b) = entry.joint, entry.links
    size = rows.size
    point = np.asarray(poses[a].apply(np.array(joint.point) / metres))
    screws: list[
        tuple[str, int, np.ndarray, np.ndarray]
    ] = []  # name, part, velocity of the origin, size x angular velocity

    def turn(name: str, part: int, axis: np.ndarray, along: float = 0.0) -> None:
        screws.append((name, part, _moment(point, axis) / size + along * axis / size, axis))

    def slide(name: str, axis: np.ndarray) -> None:
        screws.append((name, 0, axis, np.zeros(3)))

    first = (
        np.asarray(poses[a].rotation) @ np.array(joint.axis)
        if joint.axis is not None
        else np.zeros(3)
    )
    match joint.type:
        case "R":
            turn(joint.name, 0, first)
        case "H":
            turn(joint.name, 0, first, joint.pitch / metres / (2 * np.pi))
        case "P":
            slide(joint.name, first)
        case "C":
            turn(f"{joint.name}.angle", 0, first)
            slide(f"{joint.name}.slide", first)
        case "U":
            turn(f"{joint.name}.1", 0, first)
            turn(f"{joint.name}.2", 0, np.asarray(poses[b].rotation) @ np.array(joint.axis2))
        case "S":
            for k, axis in enumerate(np.eye(3)):
                turn(joint.name, k, axis)
    for part in range(6):
        terms: list[tuple[str, list[float]]] = []
        for link, sign in ((b, 1.0), (a, -1.0)):
            if link != "base":
                terms.append((f"link {link}", [sign if k == part else 0.0 for k in range(6)]))
        for name, k, velocity, angular in screws:
            terms.append((name, [0.0] * k + [-float(np.concatenate([velocity, angular])[part])]))
        rows.add(*terms)


def _velocity(rows: _Rows, link: str, p: np.ndarray, along: np.ndarray) -> tuple[str, np.ndarray]:
    """The speed of a point of a link along a direction, by its twist."""
    return f"link {link}", np.concatenate([along, _moment(p, along) / rows.size])


def _add_rod(rows: _Rows, rod: Any, poses: Mapping[str, Pose], metres: float) -> None:
    a, b = rod.links
    start, end = (
        np.asarray(poses[link].apply(np.array(p) / metres))
        for link, p in ((a, rod.start), (b, rod.end))
    )
    along = (end - start) / np.linalg.norm(end - start)
    terms = [
        (n, list(w))
        for n, w in (_velocity(rows, b, end, along), _velocity(rows, a, start, -along))
        if n != "link base"
    ]
    if rod.actuated:
        terms.append((rod.name, [-1.0]))
    rows.add(*terms)


def _add_coupling(rows: _Rows, coupling: Any, values: Values, scale: Mapping[str, float]) -> None:
    """joint' = sum of slope x other' (length unit, rad)."""
    slopes = dict(coupling.terms)
    if coupling.polynomial is not None:
        x = values[coupling.names[0]]
        slopes = {
            coupling.names[0]: sum(
                k * c * x ** (k - 1) for k, c in enumerate(coupling.polynomial) if k
            )
        }
    own = 1.0 / scale[coupling.joint]
    rows.add(
        (coupling.joint, [own]), *((name, [-slope / scale[name]]) for name, slope in slopes.items())
    )


def _add_pose(rows: _Rows, mechanism: Mechanism, moved: Pose, link: str) -> dict[str, float]:
    """Columns of the platform's coordinates by its twist, and their scales."""
    pose = moved @ mechanism.reference_pose
    p, size = np.asarray(pose.position), rows.size
    for name, along in zip("xyz", np.eye(3), strict=True):
        rows.add(
            (name, [1.0]), (_velocity(rows, link, p, along)[0], -_velocity(rows, link, p, along)[1])
        )
    w, x, y, z = (float(v) for v in np.asarray(pose.quaternion))
    # q' = (0, omega) q / 2
    rate = 0.5 * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]])
    torsion = 2 * (w * rate[3] - z * rate[0]) / (w * w + z * z)
    turns = {"torsion": torsion}
    s, c = np.hypot(x, y), np.hypot(w, z)
    if s > 1e-9:
        turns["tilt"] = 2 * (
            (x * rate[1] + y * rate[2]) / s * c - s * (w * rate[0] + z * rate[3]) / c
        )
        turns["azimuth"] = (-y * rate[1] + x * rate[2]) / (s * s) + 0.5 * torsion
    for name, weights in turns.items():
        rows.add((name, [1.0]), (f"link {link}", [0.0] * 3 + (-weights).tolist()))
    return {"x": 1.0, "y": 1.0, "z": 1.0, "torsion": size, "tilt": size, "azimuth": size}
