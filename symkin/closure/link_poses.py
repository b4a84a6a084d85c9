"""Where every link is, and what every joint reads, at configurations of a closure: links and joints
that it leaves out included.

The frame of a link is the base frame at the reference configuration, so that its pose is its
displacement from there. A link between two spherical joints may spin about the line of their
centres, which nothing holds: it is turned there from its reference by the shortest way.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from symkin.closure.chain import JointSymbols
from symkin.closure.closure import Closure
from symkin.closure.link_frames import Bridge, LinkFrames, link_frames
from symkin.computed_once import lru_cache
from symkin.model.joint import Joint
from symkin.spatial.backend import (
    Array,
    atan2,
    cross,
    dot,
    is_casadi,
    norm,
    scale,
    stacked,
    vector,
    where,
)
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, normalized, rotate

_OPPOSITE = 1e-12
"""1 + cosine of two directions that are opposite to rounding: any half turn across them is the
shortest way.
"""


@dataclass(frozen=True, eq=False)
class LinkPoses:
    """Displacements of all links by name at m configurations, the full vectors of variables
    `values` (m, variables): stacks of positions (3, m) and unit quaternions (4, m).
    """

    poses: dict[str, Pose]
    values: np.ndarray

    def __getitem__(self, link: str) -> Pose:
        return self.poses[link]

    def at(self, index: int) -> dict[str, Pose]:
        """The poses of all links at one of the configurations."""
        return {
            link: Pose(pose.position[:, index], pose.quaternion[:, index])
            for link, pose in self.poses.items()
        }


def link_poses(closure: Closure, values: np.ndarray) -> LinkPoses:
    """The displacements of all links, the base and those within limbs ("leg1.1", from the base on)
    included, at full vectors of variables (m, variables).
    """
    values = np.asarray(values, dtype=float)
    links, evaluate = _placed(closure)
    numbers = _at(evaluate, values).reshape(len(links), 7, len(values))
    poses = {link: Pose(own[:3], own[3:]) for link, own in zip(links, numbers, strict=True)}
    return LinkPoses(poses, values)


def _at(evaluate: ca.Function, values: np.ndarray) -> np.ndarray:
    """The numbers (numbers, m) at m configurations."""
    # of no configuration CasADi makes one
    return np.asarray(evaluate(values.T))[:, : len(values)]


def joint_readings(closure: Closure, poses: LinkPoses) -> dict[str, np.ndarray]:
    """Every joint coordinate by name (m,), those of cut joints included: radians, lengths and
    quaternions (4, m).
    """
    numbers, found, place = _at(_read_joints(closure), poses.values), dict[str, np.ndarray](), 0
    for c in (c for joint in link_frames(closure).joints for c in joint.coordinates):
        found[c.name] = numbers[place : place + c.width] if c.width > 1 else numbers[place]
        place += c.width
    return found


def reading_expressions(closure: Closure) -> dict[str, tuple[ca.SX, ...]]:
    """What single coordinates read, over the closure's variables at the geometry of the
    description: a length (of a screw its angle) as one expression, an angle as its cosine and sine.
    Joints at links that may spin, which no expression places, are left out.
    """
    found = link_frames(closure)
    read: dict[str, tuple[ca.SX, ...]] = {}
    for joint, between in _between(found):
        if joint.type == "S":
            continue
        parts = [
            part if len(part) == 1 else _unit_parts(part[0], part[1], _zero_of(joint))
            for part in _parts(joint, between)
        ]
        for c, values in zip(joint.coordinates, parts, strict=True):
            read[c.name] = tuple(map(found.bound, values))
    return read


def cut_expressions(closure: Closure, free: Collection[str] = ()) -> dict[str, ca.SX]:
    """The coordinates of joints at which loops are cut, over the closure's variables, and of the
    geometry those numbers that stay `free`. Joints at links that may spin are left out.
    """
    found = link_frames(closure)
    return {
        c.name: found.bound(value, free)
        for joint, between in _between(found)
        for c, value in zip(
            joint.coordinates,
            joint_coordinates(joint, between, found.symbols[joint.name]),
            strict=True,
        )
        if c.name not in closure.slices
    }


def link_expressions(closure: Closure) -> dict[str, Pose]:
    """As `link_poses`, over the closure's variables at the geometry of the description."""
    found = link_frames(closure)
    frames = ca.densify(found.bound(ca.horzcat(*found.frames.values())))
    poses = {
        link: Pose(frames[:3, k], normalized(frames[3:, k])) for k, link in enumerate(found.frames)
    }
    for bridge in found.bridges:
        poses |= _hung(bridge, poses)
    return poses


def joint_expressions(closure: Closure, links: Mapping[str, Pose]) -> dict[str, ca.SX]:
    """As `joint_readings`, from the expressions of links."""
    read: dict[str, ca.SX] = {}
    for joint, (before, after) in link_frames(closure).joints.items():
        values = joint_coordinates(joint, links[before].inverse() @ links[after])
        read |= dict(zip((c.name for c in joint.coordinates), values, strict=True))
    return read


def _between(found: LinkFrames) -> Iterator[tuple[Joint, Pose]]:
    """The displacement of each joint's second link in the frame of its first, of joints at links
    that expressions place.
    """
    hung = [set(bridge.links) for bridge in found.bridges]
    for joint, (before, after) in found.joints.items():
        if not any((before in links) != (after in links) for links in hung):
            first, last = (
                Pose(found.frames[link][:3], found.frames[link][3:]) for link in (before, after)
            )
            yield joint, first.inverse() @ last


# --- links that the closure places ----------------------------------------------------------------


@lru_cache(maxsize=128)
def _placed(closure: Closure) -> tuple[tuple[str, ...], ca.Function]:
    """All links, and position and quaternion of each, one below the other."""
    links = link_expressions(closure)
    parts = [part for pose in links.values() for part in (pose.position, pose.quaternion)]
    return tuple(links), _function(closure, ca.vertcat(*parts))


@lru_cache(maxsize=128)
def _read_joints(closure: Closure) -> ca.Function:
    """The coordinates of all joints, one below the other."""
    read = joint_expressions(closure, link_expressions(closure))
    return _function(closure, stacked(read.values()))


def _function(closure: Closure, numbers: ca.SX) -> ca.Function:
    variables = ca.vertcat(ca.SX(0, 1), closure.variables)
    return ca.Function("placed", [variables], [ca.densify(numbers)], {"cse": True})


def _hung(bridge: Bridge, poses: dict[str, Pose]) -> dict[str, Pose]:
    """The links of a bridge, turned about the first of its centres by the shortest way, so that
    both ends meet.
    """
    first, last = (poses[link] for link in bridge.ends)
    near, far = (ca.SX(ca.DM(centre)) for centre in bridge.centres)
    arm = poses[bridge.links[-1]].apply(far) - near
    turn = _shortest_turn(arm, first.inverse().apply(last.apply(far)) - near)
    ball = Pose(near - rotate(turn, near), turn)
    return {link: first @ (ball @ poses[link]) for link in bridge.links}


def _shortest_turn(start: Array, end: Array) -> Array:
    """Unit quaternions (4, m) that turn directions into others about an axis normal to both."""
    a, b = scale(1.0 / norm(start), start), scale(1.0 / norm(end), end)
    # 1 + cos = 2 cos^2 of half the angle, and the sine has the same factor 2 cos of half the angle
    cosine, sine = 1.0 + dot(a, b), cross(a, b)
    x, y, z = (a[k] * a[k] for k in range(3))
    along_x, along_y = (x <= y) * (x <= z), y <= z
    one, nothing = 1.0 + 0.0 * x, 0.0 * x
    across = where(
        along_x,
        vector(one, nothing, nothing),
        where(along_y, vector(nothing, one, nothing), vector(nothing, nothing, one)),
    )
    half_turn = cross(a, across)
    turn = where(
        cosine > _OPPOSITE,
        vector(cosine, sine[0], sine[1], sine[2]),
        vector(nothing, half_turn[0], half_turn[1], half_turn[2]),
    )
    return normalized(turn)


# --- what a joint reads ---------------------------------------------------------------------------


def joint_coordinates(
    joint: Joint, between: Pose, symbols: JointSymbols | None = None
) -> list[Array]:
    """The coordinates of a joint from the displacement of its second link in the frame of its
    first, (3, m) and (4, m) or in symbols; its own geometry may be symbols too.
    """
    if joint.type == "S":
        return [between.quaternion]
    return [
        part[0] if len(part) == 1 else _zero_of(joint) + atan2(part[1], part[0])
        for part in _parts(joint, between, symbols)
    ]


def _zero_of(joint: Joint) -> float:
    """What the angle of a joint reads at the reference."""
    return joint.zero if joint.type == "R" else 0.0


def _parts(
    joint: Joint, between: Pose, symbols: JointSymbols | None = None
) -> list[tuple[Array, ...]]:
    """The coordinates of a joint that is no ball: a length (of a screw its angle) as one number, an
    angle from the reference as multiples of its cosine and sine.
    """
    q, own = between.quaternion, symbols or joint

    def column(numbers: Any) -> Array:
        if isinstance(numbers, ca.SX):
            return numbers
        return ca.DM(numbers) if is_casadi(q) else np.array(numbers)[:, None]

    axis, point = column(own.axis), column(own.point)
    slide = dot(axis, between.apply(point) - point)
    if joint.type in ("P", "H"):
        return [(joint.zero + (slide if joint.type == "P" else 2.0 * np.pi * slide / own.pitch),)]
    if joint.type in ("R", "C"):
        s, w = dot(axis, q[1:]), q[0]
        turn = (w * w - s * s, 2.0 * w * s)
        return [turn] if joint.type == "R" else [turn, (slide,)]
    # Turn(axis, first) carries axis2 to where it is; Turn(axis2, -second) carries axis to where it
    # is from the second link
    axis2 = column(own.axis2)
    first = _turn_parts(axis, axis2, rotate(q, axis2))
    cosine, sine = _turn_parts(axis2, axis, rotate(conjugate(q), axis))
    return [first, (cosine, -sine)]


def _turn_parts(axis: Array, start: Array, end: Array) -> tuple[Array, Array]:
    """Multiples of cosine and sine of the angle about an axis from one direction to another."""
    flat = start - dot(axis, start) * axis
    return dot(flat, end), dot(axis, cross(flat, end))


def _unit_parts(cosine: ca.SX, sine: ca.SX, zero: float = 0.0) -> tuple[ca.SX, ca.SX]:
    """Cosine and sine of an angle, from multiples of these, moved on by `zero`."""
    length = ca.sqrt(cosine * cosine + sine * sine)
    c, s = cosine / length, sine / length
    return (
        (c, s)
        if zero == 0.0
        else (c * np.cos(zero) - s * np.sin(zero), s * np.cos(zero) + c * np.sin(zero))
    )
