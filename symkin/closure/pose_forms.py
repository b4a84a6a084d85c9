"""State the platform's pose in the forms in which closure rows take it.

Each form gives points, directions and squared distances times a weight N, so that rows stay
polynomial in the pose: N = 1 for a unit quaternion, N = q.q for quaternions of any length.
Quaternions may then be complex and projective, which path tracking needs; where N = 0 there is no
pose.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np

from symkin.spatial.backend import cross, dot
from symkin.spatial.rotation import conjugate, multiply, rotate


class PlatformPose(Protocol):
    """A pose X whose points x -> position + R x come times `weight`."""

    @property
    def quaternion(self) -> ca.SX: ...
    @property
    def weight(self) -> ca.SX: ...
    def point(self, m: ca.SX) -> ca.SX: ...
    def direction(self, v: ca.SX) -> ca.SX: ...
    def squared_distance(self, m: ca.SX, other: ca.SX) -> ca.SX: ...


@dataclass(frozen=True)
class UnitPose:
    """Position and unit quaternion; N = 1."""

    position: ca.SX
    quaternion: ca.SX

    @property
    def weight(self) -> ca.SX:
        return ca.SX(1)

    def point(self, m: ca.SX) -> ca.SX:
        return self.position + self.direction(m)

    def direction(self, v: ca.SX) -> ca.SX:
        return rotate(self.quaternion, v)

    def squared_distance(self, m: ca.SX, other: ca.SX) -> ca.SX:
        difference = self.point(m) - other
        return dot(difference, difference)


class _OfAnyLength:
    """A quaternion of any length; N = q.q."""

    quaternion: ca.SX

    @property
    def weight(self) -> ca.SX:
        return dot(self.quaternion, self.quaternion)

    def direction(self, v: ca.SX) -> ca.SX:
        """q v q*: (w^2 - u.u) v + 2 (u.v) u + 2 w u x v."""
        w, u = self.quaternion[0], self.quaternion[1:]
        return (w * w - dot(u, u)) * v + 2 * (dot(u, v) * u + w * cross(u, v))


@dataclass(frozen=True)
class HomogeneousPose(_OfAnyLength):
    """Position and a quaternion of any length."""

    position: ca.SX
    quaternion: ca.SX

    def point(self, m: ca.SX) -> ca.SX:
        return self.weight * self.position + self.direction(m)

    def squared_distance(self, m: ca.SX, other: ca.SX) -> ca.SX:
        # |p + R m - b|^2 = |p - b|^2 + |m|^2 + 2 (p - b).R m, where N R m is a quadratic form of
        # the quaternion
        offset = self.position - other
        return self.weight * (dot(offset, offset) + dot(m, m)) + 2 * dot(offset, self.direction(m))


@dataclass(frozen=True)
class StudyPose(_OfAnyLength):
    """Study coordinates (e; g), e.g = 0: rotation e of any length, position 2 g e* / N, N = e.e.

    N times the squared distance of p + R m to b is |2 g + e m - b e|^2, a quadratic form (Husty
    1996).
    """

    quaternion: ca.SX
    dual: ca.SX

    def point(self, m: ca.SX) -> ca.SX:
        # N p = 2 g e*: the dual part holds half the position times e
        return 2 * multiply(self.dual, conjugate(self.quaternion))[1:] + self.direction(m)

    def squared_distance(self, m: ca.SX, other: ca.SX) -> ca.SX:
        # N |p + R m - b|^2 = |(p + R m - b) e|^2 with p e = 2 g and (R m) e = e m: linear in (e, g)
        # inside the bars
        e = self.quaternion
        difference = (
            2 * self.dual + multiply(e, ca.vertcat(0, m)) - multiply(ca.vertcat(0, other), e)
        )
        return dot(difference, difference)


_HALF_TURNS = np.eye(4)
"""Quaternions of which each vector's turned ones add to nothing."""


def linear_parts(point: ca.SX, position: ca.SX, quaternion: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """A, R a at R = 1 and b of points A p + R a + b, by the position p and the unit quaternion of
    R.
    """
    turns = [ca.substitute(point, quaternion, ca.SX(ca.DM(q))) for q in _HALF_TURNS]
    turned = [ca.substitute(w, position, ca.SX.zeros(*position.shape)) for w in turns]
    still = sum(turned[1:], turned[0]) / len(turned)
    return ca.simplify(ca.jacobian(point, position)), turned[0] - still, still


def weighted_point(point: ca.SX, position: ca.SX, quaternion: ca.SX, pose: PlatformPose) -> ca.SX:
    """Points A p + R a + b times the weight of a pose in another form."""
    moved, arm, still = linear_parts(point, position, quaternion)
    arms = [pose.direction(arm[k : k + 3]) for k in range(0, point.shape[0], 3)]
    place = pose.point(ca.SX(3, 1)) if position.shape[0] else position
    return ca.mtimes(moved, place) + ca.vertcat(*arms) + pose.weight * still
