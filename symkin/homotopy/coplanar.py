"""Six distances between coplanar points of the base and coplanar points of the platform: the
reflection.

Reflected in the plane of the base points, and on the platform in the plane of its points, a pose
keeps all distances. In frames whose z = 0 are these planes the reflection changes signs of Study
coordinates only: (w, x, y, z) -> (w, -x, -y, z) of e, and (w, x, y, z) -> (-w, x, y, -z) of g.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.spatial.rotation import multiply, quaternion_from_matrix

_FLAT = 1e-12
"""Largest distance of points from their plane, over their extent, that counts as none."""
REFLECTION = np.array([1.0, -1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0])
"""Signs of (e, g) under the reflection in z = 0 of both frames."""


@dataclass(frozen=True, eq=False)
class Frame:
    """Axes as columns of `rotation` (3, 3), right-handed, and `origin` (3,), in the coordinates of
    the points.
    """

    rotation: np.ndarray
    origin: np.ndarray

    def coordinates(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) in this frame."""
        return (points - self.origin) @ self.rotation

    @property
    def study(self) -> np.ndarray:
        """Study coordinates (e, g) of the frame's pose."""
        e = np.asarray(quaternion_from_matrix(self.rotation))
        return np.concatenate([e, 0.5 * multiply(np.array([0.0, *self.origin]), e)])

    @property
    def inverse(self) -> Frame:
        return Frame(self.rotation.T, -self.rotation.T @ self.origin)


@dataclass(frozen=True, eq=False)
class Frames:
    """Frames of base and platform points, in whose planes z = 0 they lie where they are
    coplanar.
    """

    base: Frame
    platform: Frame

    @property
    def into(self) -> np.ndarray:
        """Matrix (8, 8) from Study coordinates of a pose to those between the frames: base^-1 pose
        platform.
        """
        return times_left(self.base.inverse.study) @ times_right(self.platform.study)

    @property
    def back(self) -> np.ndarray:
        """Its inverse."""
        return times_left(self.base.study) @ times_right(self.platform.inverse.study)


def plane_frame(points: np.ndarray) -> Frame | None:
    """A frame with all points (n, 3) in z = 0, its origin at their centroid; None where they are
    not coplanar.
    """
    origin = points.mean(axis=0)
    _, extent, axes = np.linalg.svd(points - origin)
    off = np.max(np.abs((points - origin) @ axes[2]))
    if off > _FLAT * max(extent[0], np.max(np.abs(points))):
        return None
    rotation = axes.T * np.array([1.0, 1.0, np.linalg.det(axes)])
    return Frame(rotation, origin)


def distance_frames(data: np.ndarray) -> Frames | None:
    """Frames for the distances `data` (n, 7), real L, b, m of each, or None where base or platform
    points are not coplanar.
    """
    base, platform = plane_frame(data[:, 1:4]), plane_frame(data[:, 4:7])
    return None if base is None or platform is None else Frames(base, platform)


def reflection(frames: Frames) -> np.ndarray:
    """The reflection (8, 8) of Study coordinates in the points' own frames."""
    return frames.back @ np.diag(REFLECTION) @ frames.into


def times_left(a: np.ndarray) -> np.ndarray:
    """Matrix (8, 8) of b -> a b for dual quaternions (e, g): (e_a e_b, e_a g_b + g_a e_b)."""
    columns = [_product(a, unit) for unit in np.eye(8)]
    return np.array(columns).T


def times_right(b: np.ndarray) -> np.ndarray:
    """Matrix (8, 8) of a -> a b."""
    columns = [_product(unit, b) for unit in np.eye(8)]
    return np.array(columns).T


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    e = multiply(a[:4], b[:4])
    return np.concatenate([e, multiply(a[:4], b[4:]) + multiply(a[4:], b[:4])])
