"""Rigid displacements as a position and a unit quaternion, made from matrices, angles, vectors and
quaternions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from symkin.errors import InputError
from symkin.spatial.backend import Array, is_casadi, matrix, vector
from symkin.spatial.rotation import (
    conjugate,
    matrix_from_quaternion,
    multiply,
    quaternion_from_euler,
    quaternion_from_matrix,
    quaternion_from_rotation_vector,
    rotate,
)
from symkin.text import not_among

_NOT_ORTHONORMAL = 1e-3
"""Largest entry of R^T R - 1 that is taken for the rounding of printed digits; beyond, a matrix is
no rotation.
"""
NORM_OFF = 1e-2
"""How far a quaternion's norm may be from 1, as in mechanism files; beyond, its numbers are not
those of a rotation.
"""

AngleUnit = Literal["deg", "rad"]


@dataclass(frozen=True, eq=False)
class Pose:
    """A rigid displacement x -> R(quaternion) x + position: coordinates in the moved frame to those
    in the base frame.

    `position` has three components (the mechanism's length unit), `quaternion` four (w, x, y, z,
    unit length); both NumPy or both CasADi, or stacks of columns (3, N) and (4, N). `a @ b` is the
    displacement b, then a, in the frame of a. Numbers are taken as they are; `from_quaternion`,
    `from_matrix`, `from_euler` and `from_rotation_vector` check them and raise InputError with a
    sentence for what is no rotation.

    >>> import symkin
    >>> home = symkin.Pose.from_euler([0.0, 0.0, 420.0], [0.0, 0.0, 90.0], "XYZ", angle_unit="deg")
    >>> [round(float(v), 6) + 0.0 for v in home.apply([100.0, 0.0, 0.0])]
    [0.0, 100.0, 420.0]

    Source: R. M. Murray, Z. Li, S. S. Sastry, A Mathematical Introduction to Robotic Manipulation,
    1994, chapter 2.
    """

    position: Array
    quaternion: Array

    @staticmethod
    def identity() -> Pose:
        """The pose of the base frame itself."""
        return Pose(vector(0.0, 0.0, 0.0), vector(1.0, 0.0, 0.0, 0.0))

    @staticmethod
    def from_matrix(transform: Array, position: Array = None) -> Pose:
        """Make a pose from a homogeneous transform (4 x 4), or from a rotation matrix (3 x 3) and a
        position (3).

        The columns of R are the moved frame's axes in the base frame. Raises InputError where R^T R
        differs from the identity by more than 1e-3, or R is a reflection (det R = -1); the
        quaternion has w >= 0.

        >>> import symkin
        >>> quarter_turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
        >>> symkin.Pose.from_matrix(quarter_turn, [1.0, 2.0, 3.0]).quaternion.round(6)
        array([0.707107, 0.      , 0.      , 0.707107])
        """
        if is_casadi(transform):
            own = (
                vector(transform[0, 3], transform[1, 3], transform[2, 3])
                if position is None
                else position
            )
            return Pose(own, quaternion_from_matrix(transform))
        whole = _array(transform, "transform")
        if whole.shape[:2] not in ((4, 4), (3, 3)) or (whole.shape[0] == 3) == (position is None):
            raise InputError(
                f"transform: shape {whole.shape}; a homogeneous transform of 4 x 4 is needed, or a "
                f"rotation matrix of 3 x 3 and "
                "`position`"
            )
        _check_rotation(whole)
        return Pose(
            whole[:3, 3] if position is None else _position(position), quaternion_from_matrix(whole)
        )

    @staticmethod
    def from_euler(
        position: Array, angles: Array, sequence: str = "xyz", *, angle_unit: AngleUnit = "rad"
    ) -> Pose:
        """Make a pose from a position (3) and three angles, in the order of the letters of
        `sequence`.

        Small letters turn about the fixed axes of the base frame ("xyz": R = Rz(c) Ry(b) Rx(a),
        roll, pitch, yaw); capitals about the axes that have turned along ("XYZ": R = Rx(a) Ry(b)
        Rz(c)). `angle_unit` is "rad" or "deg". Raises InputError for another sequence or unit, and
        for numbers that are not finite.

        >>> import symkin
        >>> pose = symkin.Pose.from_euler([0, 0, 0], [90, 0, 0], "xyz", angle_unit="deg")
        >>> pose.quaternion.round(6)
        array([0.707107, 0.707107, 0.      , 0.      ])
        """
        if is_casadi(angles):
            return Pose(
                _position(position), quaternion_from_euler(angles * _radians(angle_unit), sequence)
            )
        try:
            quaternion = quaternion_from_euler(
                _array(angles, "angles", 3) * _radians(angle_unit), sequence
            )
        except ValueError as error:
            raise InputError(str(error)) from None
        return Pose(_position(position), quaternion)

    @staticmethod
    def from_rotation_vector(
        position: Array, rotation_vector: Array, *, angle_unit: AngleUnit = "rad"
    ) -> Pose:
        """Make a pose from a position (3) and a rotation vector (3): the axis of the rotation, as
        long as its angle.

        `angle_unit` is "rad" or "deg". Raises InputError for another unit, and for numbers that are
        not finite.

        >>> import symkin
        >>> pose = symkin.Pose.from_rotation_vector([0, 0, 0], [0, 0, 180], angle_unit="deg")
        >>> pose.quaternion.round(6)
        array([0., 0., 0., 1.])
        """
        if is_casadi(rotation_vector):
            return Pose(
                _position(position),
                quaternion_from_rotation_vector(rotation_vector * _radians(angle_unit)),
            )
        turn = _array(rotation_vector, "rotation_vector", 3) * _radians(angle_unit)
        return Pose(_position(position), quaternion_from_rotation_vector(turn))

    @staticmethod
    def from_quaternion(
        position: Array, quaternion: Array, *, order: Literal["wxyz", "xyzw"] = "wxyz"
    ) -> Pose:
        """Make a pose from a position (3) and a quaternion (4), w first, or last with order="xyzw"
        (ROS, SciPy).

        The quaternion is normalised. Raises InputError where its norm is off 1 by more than 1e-2.

        >>> import symkin
        >>> symkin.Pose.from_quaternion([0, 0, 0], [0, 0, 0, 1], order="xyzw").quaternion
        array([1., 0., 0., 0.])
        """
        if order not in ("wxyz", "xyzw"):
            raise InputError(f"order = {not_among(order, ('wxyz', 'xyzw'))}")
        numbers = _array(quaternion, "quaternion", 4)
        norms = np.linalg.norm(numbers, axis=0)
        worst = float(norms.ravel()[np.argmax(np.abs(norms - 1.0))])
        if abs(worst - 1.0) > NORM_OFF:
            raise InputError(
                f"quaternion: norm {worst:.6g}; a unit quaternion is needed (1 to within 0.01)"
            )
        numbers = numbers / norms
        return Pose(
            _position(position), numbers if order == "wxyz" else np.roll(numbers, 1, axis=0)
        )

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


# --- checks of given numbers ----------------------------------------------------------------------


def _array(values: Array, what: str, count: int | None = None) -> np.ndarray:
    """Finite numbers of a given count along the first axis. Raises InputError."""
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{what} = {values!r} is not made of numbers") from None
    if count is not None and (numbers.ndim == 0 or numbers.shape[0] != count):
        raise InputError(f"{what}: shape {numbers.shape}; {count} numbers are needed")
    if not np.all(np.isfinite(numbers)):
        raise InputError(f"{what}: a number is not finite")
    return numbers


def _position(values: Array) -> Array:
    """Three numbers, checked, or three CasADi expressions."""
    return values if is_casadi(values) else _array(values, "position", 3)


def _check_rotation(transform: np.ndarray) -> None:
    """Raises InputError where the upper left of a matrix is no rotation, or the last row is not 0,
    0, 0, 1.
    """
    r = np.moveaxis(transform[:3, :3].reshape(3, 3, -1), -1, 0)
    off = float(np.max(np.abs(np.swapaxes(r, 1, 2) @ r - np.eye(3))))
    if off > _NOT_ORTHONORMAL:
        raise InputError(
            f"transform: its columns are off being orthonormal by {off:.2g} (allowed: "
            f"{_NOT_ORTHONORMAL:g}); it is no rotation"
        )
    if np.min(np.linalg.det(r)) < 0:
        raise InputError(
            "transform: its determinant is -1; it is a reflection, no rotation (is an axis or a "
            "row swapped?)"
        )
    if transform.shape[0] == 4:
        last = transform[3].reshape(4, -1).T
        if float(np.max(np.abs(last - [0.0, 0.0, 0.0, 1.0]))) > _NOT_ORTHONORMAL:
            raise InputError(
                f"transform: the last row is {last[0].tolist()}; 0, 0, 0, 1 is needed (is the "
                f"matrix transposed?)"
            )


def _radians(angle_unit: str) -> float:
    """Radians of one unit of angle."""
    if angle_unit not in ("deg", "rad"):
        raise InputError(f"angle_unit = {not_among(angle_unit, ('deg', 'rad'))}")
    return math.pi / 180 if angle_unit == "deg" else 1.0
