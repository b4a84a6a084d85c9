"""Exponentials of screws, screws after a displacement, and their reciprocity; screws as
`symkin.spatial.screw` has them.
"""

from __future__ import annotations

from symkin.spatial.backend import Array, cos, cross, dot, scale, sin, sqrt, vector, where
from symkin.spatial.pose import Pose


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
