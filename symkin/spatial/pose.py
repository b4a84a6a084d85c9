"""Rigid displacements as a position and a unit quaternion."""

from __future__ import annotations

from dataclasses import dataclass

from symkin.spatial.backend import Array, matrix, vector
from symkin.spatial.rotation import (
    conjugate,
    matrix_from_quaternion,
    multiply,
    quaternion_from_euler,
    quaternion_from_matrix,
    rotate,
)


@dataclass(frozen=True, eq=False)
class Pose:
    """x -> R(quaternion) x + position: coordinates in the moved frame to coordinates in the base frame.

    `position` has three components, `quaternion` four (w, x, y, z, unit length); both NumPy or both CasADi.
    """

    position: Array
    quaternion: Array

    @staticmethod
    def identity() -> Pose:
        return Pose(vector(0.0, 0.0, 0.0), vector(1.0, 0.0, 0.0, 0.0))

    @staticmethod
    def from_matrix(transform: Array) -> Pose:
        """From a 4 x 4 homogeneous transform."""
        return Pose(vector(transform[0, 3], transform[1, 3], transform[2, 3]), quaternion_from_matrix(transform))

    @staticmethod
    def from_euler(position: Array, angles: Array, sequence: str) -> Pose:
        """From a position and three angles in radians about the axes of `sequence` ('XYZ' moving, 'xyz' fixed)."""
        return Pose(vector(*position), quaternion_from_euler(angles, sequence))

    def __matmul__(self, other: Pose) -> Pose:
        """self after other: (self @ other)(x) = self(other(x))."""
        return Pose(self.apply(other.position), multiply(self.quaternion, other.quaternion))

    def inverse(self) -> Pose:
        back = conjugate(self.quaternion)
        return Pose(-rotate(back, self.position), back)

    def apply(self, point: Array) -> Array:
        """Move a point."""
        return rotate(self.quaternion, point) + self.position

    def turn(self, direction: Array) -> Array:
        """Move a direction: rotation only."""
        return rotate(self.quaternion, direction)

    @property
    def rotation(self) -> Array:
        """Rotation matrix, 3 x 3."""
        return matrix_from_quaternion(self.quaternion)

    @property
    def matrix(self) -> Array:
        """Homogeneous transform, 4 x 4."""
        r, p = self.rotation, self.position
        rows = [[r[i, 0], r[i, 1], r[i, 2], p[i]] for i in range(3)]
        zero = 0.0 * p[0]
        return matrix([*rows, [zero, zero, zero, zero + 1.0]])
