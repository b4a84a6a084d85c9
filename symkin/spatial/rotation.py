"""Rotations and their charts: matrix, unit quaternion (w, x, y, z), Euler angles, rotation
vector.

Formulas take floats, NumPy arrays (components first) or CasADi columns alike. The unit quaternion
is the hub: each chart has one function to it and one from it. Angles are in radians. A rotation R
maps coordinates in the turned frame to coordinates in the base frame.
"""

from __future__ import annotations

import math

import numpy as np

from symkin.spatial.backend import (
    Array,
    atan2,
    cos,
    cross,
    dot,
    matrix,
    norm,
    one_call,
    scale,
    sin,
    sqrt,
    vector,
    where,
)

_TINY = 1e-16


def wrapped(angles: np.ndarray) -> np.ndarray:
    """The same directions within half a turn of zero; angles that are stay as they are, bit by
    bit.
    """
    return angles - 2.0 * np.pi * np.rint(angles / (2.0 * np.pi))


# --- unit quaternions -----------------------------------------------------------------------------


@one_call
def multiply(a: Array, b: Array) -> Array:
    """Hamilton product: the rotation b followed by a, R(a b) = R(a) R(b)."""
    (a0, a1, a2, a3), (b0, b1, b2, b3) = ((v[0], v[1], v[2], v[3]) for v in (a, b))
    return vector(
        a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
        a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
        a0 * b2 - a1 * b3 + a2 * b0 + a3 * b1,
        a0 * b3 + a1 * b2 - a2 * b1 + a3 * b0,
    )


def conjugate(q: Array) -> Array:
    return vector(q[0], -q[1], -q[2], -q[3])


def normalized(q: Array) -> Array:
    return scale(1.0 / norm(q), q)


@one_call
def rotate(q: Array, v: Array) -> Array:
    """q v q* for a unit quaternion: v + 2 w (u x v) + 2 u x (u x v), u the vector part."""
    u = q[1:]
    t = cross(u, v)
    return v + 2.0 * (scale(q[0], t) + cross(u, t))


# --- axis and angle, rotation vector --------------------------------------------------------------


@one_call
def quaternion_from_axis_angle(axis: Array, angle: Array) -> Array:
    """(cos(a/2), axis sin(a/2)) for a unit axis."""
    s = sin(0.5 * angle)
    return vector(cos(0.5 * angle), axis[0] * s, axis[1] * s, axis[2] * s)


def quaternion_from_rotation_vector(r: Array) -> Array:
    """exp of the rotation vector r = angle * axis; regular at r = 0."""
    squared = dot(r, r)
    # below 1e-4 rad the series of sin(a/2)/a and cos(a/2): the terms left out are below rounding
    small = squared < 1e-8
    angle = sqrt(where(small, 1.0, squared))
    half_sinc = where(small, 0.5 - squared / 48.0, sin(0.5 * angle) / angle)
    c = where(small, 1.0 - squared / 8.0 + squared * squared / 384.0, cos(0.5 * angle))
    return vector(c, half_sinc * r[0], half_sinc * r[1], half_sinc * r[2])


def rotation_vector_from_quaternion(q: Array) -> Array:
    """log of a unit quaternion: angle * axis with angle in [0, pi]."""
    # q and -q are one rotation: the half with w >= 0 has the angle in [0, pi]
    sign = where(q[0] < 0, -1.0, 1.0)
    w, u = sign * q[0], scale(sign, q[1:])
    squared = dot(u, u)
    small = squared < 1e-12
    sine = sqrt(where(small, 1.0, squared))
    factor = where(small, 2.0 + squared / 3.0, 2.0 * atan2(sine, w) / sine)
    return scale(factor, u)


# --- matrix ---------------------------------------------------------------------------------------


@one_call
def matrix_from_quaternion(q: Array) -> Array:
    """Rotation matrix of a unit quaternion; columns are the turned frame's axes."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_from_matrix(r: Array) -> Array:
    """Unit quaternion with w >= 0 of a rotation matrix, by the best conditioned of the four
    divisions (Shepperd).
    """
    # these are 4 w^2, 4 x^2, 4 y^2, 4 z^2; the largest is at least 1, so that dividing by its root
    # is safe
    trace = r[0, 0] + r[1, 1] + r[2, 2]
    squares = [1 + trace, 1 + 2 * r[0, 0] - trace, 1 + 2 * r[1, 1] - trace, 1 + 2 * r[2, 2] - trace]
    candidates = [
        vector(squares[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]),
        vector(r[2, 1] - r[1, 2], squares[1], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]),
        vector(r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], squares[2], r[1, 2] + r[2, 1]),
        vector(r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], squares[3]),
    ]
    best, chosen = squares[0], candidates[0]
    for square, candidate in zip(squares[1:], candidates[1:], strict=True):
        better = square > best
        chosen = vector(*(where(better, candidate[i], chosen[i]) for i in range(4)))
        best = where(better, square, best)
    return normalized(scale(where(chosen[0] < 0, -1.0, 1.0), chosen))


# --- Euler angles ---------------------------------------------------------------------------------


def _sequence_axes(sequence: str) -> tuple[list[int], bool]:
    """Axis numbers in fixed-axes order and whether the sequence was written about moving axes."""
    axes = ["xyz".find(letter) for letter in sequence.lower()]
    moving = sequence.isupper()
    if (
        len(axes) != 3
        or -1 in axes
        or axes[0] == axes[1]
        or axes[1] == axes[2]
        or not (moving or sequence.islower())
    ):
        raise ValueError(
            f"Euler sequence {sequence!r} is unknown: three letters such as 'xyz' (about fixed "
            f"axes, in that order) "
            "or 'XYZ' (about moving axes), neighbours different"
        )
    return (axes[::-1] if moving else axes), moving


def quaternion_from_euler(angles: Array, sequence: str) -> Array:
    """Three elementary rotations; 'xyz' about fixed axes, R = Rz(c) Ry(b) Rx(a); 'XYZ' about moving
    axes, R = Rx(a) Ry(b) Rz(c). `angles` are in the order of the letters.
    """
    axes, moving = _sequence_axes(sequence)
    order = (2, 1, 0) if moving else (0, 1, 2)
    total = None
    for axis, k in zip(axes, order, strict=True):
        unit = [0.0, 0.0, 0.0]
        unit[axis] = 1.0
        turn = quaternion_from_axis_angle(unit, angles[k])
        total = turn if total is None else multiply(turn, total)
    return total


def euler_from_quaternion(q: Array, sequence: str) -> Array:
    """Euler angles of a unit quaternion, the middle one in [-pi/2, pi/2] (three axes) or [0, pi]
    (first = last).

    Source: Bernardes and Viollet, Quaternion to Euler angles conversion, PLoS ONE 17 (2022)
    e0276302.
    """
    (i, j, k), moving = _sequence_axes(sequence)
    symmetric = i == k
    if symmetric:
        k = 3 - i - j
    # the sign of the permutation (i, j, k): left-handed sequences mirror the last axis
    parity = (i - j) * (j - k) * (k - i) // 2
    w, v = q[0], q[1:]
    if symmetric:
        a, b, c, d = w, v[i], v[j], v[k] * parity
    else:
        a, b, c, d = w - v[j], v[i] + v[k] * parity, v[j] + w, v[k] * parity - v[i]
    middle = 2.0 * atan2(sqrt(c * c + d * d + _TINY**2), sqrt(a * a + b * b))
    half_sum, half_difference = atan2(b, a), atan2(d, c)
    first, last = half_sum - half_difference, half_sum + half_difference
    if not symmetric:
        middle, last = middle - 0.5 * math.pi, last * parity
    turned = [atan2(sin(angle), cos(angle)) for angle in (first, last)]
    return vector(turned[1], middle, turned[0]) if moving else vector(turned[0], middle, turned[1])
