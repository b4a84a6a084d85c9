"""Screws, their exponentials and reciprocity.

A screw is the six-vector (s; s0) in ray order: direction s and moment s0 about the frame's origin.
A twist is (angular velocity; velocity of the point at the origin), a wrench (force; moment about
the origin); a wrench does no work on a twist when their reciprocal product s_t . s0_w + s0_t . s_w
is zero.
"""

from __future__ import annotations

import math

import numpy as np

from symkin.spatial.backend import Array, cos, cross, dot, scale, sin, sqrt, vector, where
from symkin.spatial.pose import Pose

_ZERO_ENTRY = 1e-9
"""Entries of tidy rows below this are rounding."""


def revolute_screw(point: Array, axis: Array, pitch_per_turn: Array = 0.0) -> Array:
    """Unit twist of a revolute (pitch 0) or helical joint: (a; c x a + h a), h = pitch per turn / 2
    pi.
    """
    moment = cross(point, axis) + scale(pitch_per_turn / (2 * math.pi), axis)
    return vector(axis[0], axis[1], axis[2], moment[0], moment[1], moment[2])


def prismatic_screw(axis: Array) -> Array:
    """Unit twist of a prismatic joint: (0; a)."""
    zero = 0.0 * axis[0]
    return vector(zero, zero, zero, axis[0], axis[1], axis[2])


def exponential(screw: Array, value: Array) -> Pose:
    """exp(value * screw), a rigid displacement; the direction part of the screw need not be a unit
    vector.

    With angle t = |s| value and u = s / |s|: p = (s0 + (1 - cos t)/t u x s0 + (1 - sin t / t) u x
    (u x s0)) value.
    """
    s, s0 = scale(value, screw[:3]), scale(value, screw[3:])
    squared = dot(s, s)
    # below 1e-5 rad the series of the coefficients: the terms left out are below rounding
    small = squared < 1e-10
    angle = sqrt(where(small, 1.0, squared))
    first = where(small, 0.5 - squared / 24.0, (1.0 - cos(angle)) / (angle * angle))
    second = where(
        small, 1.0 / 6.0 - squared / 120.0, (angle - sin(angle)) / (angle * angle * angle)
    )
    half_sinc = where(small, 0.5 - squared / 48.0, sin(0.5 * angle) / angle)
    half_cos = where(small, 1.0 - squared / 8.0, cos(0.5 * angle))
    t = cross(s, s0)
    position = s0 + scale(first, t) + scale(second, cross(s, t))
    return Pose(position, vector(half_cos, half_sinc * s[0], half_sinc * s[1], half_sinc * s[2]))


def move_screw(pose: Pose, screw: Array) -> Array:
    """Adjoint map: the same screw after the displacement, in the same frame (R s; R s0 + p x R
    s).
    """
    s, s0 = pose.turn(screw[:3]), pose.turn(screw[3:])
    moment = s0 + cross(pose.position, s)
    return vector(s[0], s[1], s[2], moment[0], moment[1], moment[2])


def reciprocal_product(twist: Array, wrench: Array) -> Array:
    """Rate of work of a wrench on a twist."""
    return dot(twist[:3], wrench[3:]) + dot(twist[3:], wrench[:3])


def tidy_rows(rows: np.ndarray) -> np.ndarray:
    """The same row space in reduced echelon form with unit rows: readable bases for print-outs."""
    reduced = np.array(rows, dtype=float)
    pivot_row = 0
    for column in range(reduced.shape[1]):
        if pivot_row >= reduced.shape[0]:
            break
        best = pivot_row + int(np.argmax(np.abs(reduced[pivot_row:, column])))
        if abs(reduced[best, column]) < _ZERO_ENTRY:
            continue
        reduced[[pivot_row, best]] = reduced[[best, pivot_row]]
        reduced[pivot_row] /= reduced[pivot_row, column]
        for other in range(reduced.shape[0]):
            if other != pivot_row:
                reduced[other] -= reduced[other, column] * reduced[pivot_row]
        pivot_row += 1
    norms = np.linalg.norm(reduced, axis=1, keepdims=True)
    reduced = reduced / np.where(norms > 0, norms, 1.0)
    reduced[np.abs(reduced) < _ZERO_ENTRY] = 0.0
    return reduced
