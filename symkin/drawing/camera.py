"""From where a mechanism is seen: a planar one along its axes, others from where joints hide each
other least, or along the axes of the base frame. NumPy only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from symkin.drawing.layout import Layout

ViewName = Literal["main", "top", "front", "side"]
"""Sides from which a mechanism is seen: at an angle (a planar one along its axes), against z, along
y, against x of the base frame.
"""
_SAME = 1e-6
"""Distance over the size below which two points are one, and sine below which two directions
are.
"""
_NEAR, _ASIDE = 0.075, 0.08
"""Distances over the size: below which symbols cover each other, and at which those of joints that
share a point stand, while directions are tried.
"""
_ELEVATIONS = (20.0, 26.0, 32.0, 14.0)
_AZIMUTHS = (-57.0, -66.0, -48.0, -38.0, -30.0, -75.0, -22.0)
"""Directions of the eye that are tried for a mechanism that is not planar, degrees, the preferred
first.
"""
_SIDES: dict[ViewName, np.ndarray] = {
    "top": np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "front": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
    "side": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
}


@dataclass(frozen=True, eq=False)
class Camera:
    """A side: rows right, up and towards the eye, and whether the mechanism is planar and seen
    along its axes.
    """

    axes: np.ndarray
    planar: bool
    name: ViewName = "main"

    @staticmethod
    def of(layout: Layout) -> Camera:
        """The main view of a mechanism at its reference."""
        normal = _plane_normal(layout)
        if normal is not None:
            return Camera(_onto(normal), planar=True)
        return Camera(_best_view(layout), planar=False)

    def seen_from(self, name: ViewName) -> Camera:
        """The same mechanism from another side."""
        if name == "main":
            return self
        axes = _SIDES[name]
        along = abs(float(self.axes[2] @ axes[2])) > 1.0 - 1e-9
        return replace(self, axes=axes, planar=self.planar and along, name=name)

    def flat(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the picture (..., 2)."""
        return np.asarray(points, dtype=float) @ self.axes[:2].T


def _plane_normal(layout: Layout) -> np.ndarray | None:
    """The axis about which everything turns and across which everything slides; None where there is
    none. A ball that closes a loop turns about it too, as the links that it joins do.
    """
    turning = [joint.axes[0] for joint in layout.joints if joint.type == "R"]
    others = [joint for joint in layout.joints if joint.type not in ("R", "P", "weld")]
    if (
        not turning
        or layout.rods
        or any(joint.type != "S" or joint.name not in layout.closing for joint in others)
    ):
        return None
    normal = turning[0] * np.sign(turning[0][int(np.argmax(np.abs(turning[0])))])
    parallel = all(np.linalg.norm(np.cross(axis, normal)) < _SAME for axis in turning)
    across = all(abs(j.axes[0] @ normal) < _SAME for j in layout.joints if j.type == "P")
    return normal if parallel and across else None


def _onto(normal: np.ndarray) -> np.ndarray:
    """Rows right, up and towards the eye, along a normal; x is to the right where it can be, z up
    where x cannot.
    """
    right = np.eye(3)[0] if abs(normal[0]) < 0.9 else np.eye(3)[1]
    right = right - (right @ normal) * normal
    right /= np.linalg.norm(right)
    up = np.cross(normal, right)
    if up[int(np.argmax(np.abs(up)))] < 0.0:
        normal, up = -normal, -up
    return np.array([right, up, normal])


def _best_view(layout: Layout) -> np.ndarray:
    """The direction, of those tried, in which joints are farthest from hiding each other."""
    size = layout.size
    places = [joint.centre for joint in layout.spread(_ASIDE * size).joints]
    places += [place for rod in layout.rods for place in (rod.start, rod.end)]
    points = np.array(places).reshape(-1, 3)
    views = [_axes(e, a) for e in _ELEVATIONS for a in _AZIMUTHS]
    return max(views, key=lambda axes: round(_clear(points @ axes[:2].T, points, size), 3))


def _axes(elevation: float, azimuth: float) -> np.ndarray:
    (se, sa), (ce, ca) = (f(np.radians([elevation, azimuth])) for f in (np.sin, np.cos))
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


def _clear(flat: np.ndarray, points: np.ndarray, size: float) -> float:
    """Closeness, negative, of joints that are apart and look near: 0 where none looks nearer than
    `_NEAR`.
    """
    near, (i, j) = _NEAR * size, np.triu_indices(len(points), 1)
    apart = np.linalg.norm(points[i] - points[j], axis=1) > _SAME * size
    gaps = np.linalg.norm(flat[i] - flat[j], axis=1)[apart]
    return -float(np.sum(np.clip(near - gaps, 0.0, None) ** 2)) / near**2
