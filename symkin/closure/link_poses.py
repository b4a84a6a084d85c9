"""Where every link is, and what every joint reads, at configurations of a closure: links and joints that it leaves out included.

The frame of a link is the base frame at the reference configuration, so that its pose is its displacement from there. A link between
two spherical joints may spin about the line of their centres, which nothing holds: it is turned there from its reference by the
shortest way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closure.branches import Branch
from symkin.closure.chain import Chain, Side
from symkin.closure.closure import Closure
from symkin.closure.rows import RowBuilder
from symkin.computed_once import lru_cache
from symkin.model.joint import Joint
from symkin.spatial.backend import cross, dot, norm, scale
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, normalized, rotate

_OPPOSITE = 1e-12
"""1 + cosine of two directions that are opposite to rounding: any half turn across them is the shortest way."""


@dataclass(frozen=True, eq=False)
class LinkPoses:
    """Displacements of all links by name at m configurations: stacks of positions (3, m) and unit quaternions (4, m)."""

    poses: dict[str, Pose]

    def __getitem__(self, link: str) -> Pose:
        return self.poses[link]

    def at(self, index: int) -> dict[str, Pose]:
        """The poses of all links at one of the configurations."""
        return {link: Pose(pose.position[:, index], pose.quaternion[:, index]) for link, pose in self.poses.items()}


def link_poses(closure: Closure, values: np.ndarray) -> LinkPoses:
    """The displacements of all links, the base and those within limbs ("leg1.1", from the base on) included, at full vectors of
    variables (m, variables)."""
    placed = _placed_links(closure)
    # of no configuration CasADi makes one
    numbers = np.asarray(placed.evaluate(np.asarray(values, dtype=float).T))[:, : len(values)]
    poses = {
        link: Pose(numbers[7 * k : 7 * k + 3], normalized(numbers[7 * k + 3 : 7 * k + 7])) for k, link in enumerate(placed.links)
    }
    for bridge in placed.bridges:
        poses |= _hung(bridge, poses)
    return LinkPoses(poses)


def joint_readings(closure: Closure, poses: LinkPoses) -> dict[str, np.ndarray]:
    """Every joint coordinate by name (m,), those of cut joints included, from the poses of the links on both sides: radians, lengths
    and quaternions (4, m)."""
    found: dict[str, np.ndarray] = {}
    for joint, (before, after) in _placed_links(closure).joints.items():
        between = poses[before].inverse() @ poses[after]
        found |= dict(zip((c.name for c in joint.coordinates), _readings(joint, between), strict=True))
    return found


# --- links that the closure places ---------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Bridge:
    """`links` between two spherical joints: the links on which these are, and their centres at the reference."""

    links: tuple[str, ...]
    ends: tuple[str, str]
    centres: tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class _PlacedLinks:
    """`evaluate` gives position and quaternion of each of the `links`; those of a bridge as seen from its first one."""

    evaluate: Callable[[np.ndarray], ca.DM]
    links: tuple[str, ...]
    bridges: tuple[_Bridge, ...]
    joints: dict[Joint, tuple[str, str]]


@lru_cache(maxsize=128)
def _placed_links(closure: Closure) -> _PlacedLinks:
    builder = RowBuilder(closure.mechanism, partition=closure.partition)
    builder.build_rows()
    if closure.partition.geometry:
        builder.declare_geometry()
    sides: dict[str, Side] = {**builder.bodies, **builder.links}
    chains = [(branch, (branch.ends[0], *branch.links, branch.ends[1])) for branch in builder.layout.branches]
    bridges = []
    for branch, links in chains:
        free = [k for k, link in enumerate(links) if link not in sides]
        if free:
            first, last = free[0], free[-1]
            centres = [np.array(builder.mechanism.places[branch.elements[k].name]) for k in (first - 1, last)]
            bridges.append(_Bridge(links[first : last + 1], (links[first - 1], links[last + 1]), (centres[0], centres[1])))
            sides |= {links[k]: builder.chain_of(branch.elements[first:k]) for k in range(first, last + 1)}
    frames = _frames(list(sides.values()))
    variables = ca.vertcat(ca.SX(0, 1), *(builder.coordinates[c.name][1] for c in closure.coordinates))
    fixed = [k for k, name in enumerate(builder.table.names) if name not in builder.coordinates]
    symbols = ca.vertcat(ca.SX(0, 1), *(builder.table.symbols[k] for k in fixed))
    numbers = ca.SX(ca.DM([builder.table.values[k] for k in fixed]))
    packed = ca.densify(ca.substitute(ca.vertcat(*frames), symbols, numbers))
    evaluate = ca.Function("links", [variables], [packed], {"cse": True})
    return _PlacedLinks(evaluate, tuple(sides), tuple(bridges), _joints_between(chains))


def _frames(sides: Sequence[Side]) -> list[ca.SX]:
    """Position and quaternion of each side; those that begin alike are built on each other, so that a long chain costs its length."""
    known: dict[tuple[int, ...], tuple[ca.SX, ca.SX]] = {}

    def frame(side: Side) -> tuple[ca.SX, ca.SX]:
        key = (0 if isinstance(side, Chain) else id(side.pose), *map(id, side.steps))
        if key not in known:
            if not side.steps:
                known[key] = side.move(ca.SX(3, 1)) / side.weight, side.quaternion
            else:
                position, quaternion = frame(replace(side, steps=side.steps[:-1]))
                step = side.steps[-1]
                moved = position + rotate(quaternion, step.move(ca.SX(3, 1)))
                known[key] = moved, multiply(quaternion, step.quaternion)
        return known[key]

    return [ca.vertcat(*frame(side)) for side in sides]


def _joints_between(chains: Sequence[tuple[Branch, tuple[str, ...]]]) -> dict[Joint, tuple[str, str]]:
    """The links that each joint is between, the one that it moves last."""
    found: dict[Joint, tuple[str, str]] = {}
    for branch, links in chains:
        for k, element in enumerate(branch.elements):
            if isinstance(element.part, Joint) and element.part.type != "weld":
                found[element.part] = (links[k], links[k + 1]) if element.along else (links[k + 1], links[k])
    return found


def _hung(bridge: _Bridge, poses: dict[str, Pose]) -> dict[str, Pose]:
    """The links of a bridge, turned about its first centre by the shortest way, so that both ends meet."""
    first, last = (poses[link] for link in bridge.ends)
    near, far = (centre[:, None] for centre in bridge.centres)
    arm = poses[bridge.links[-1]].apply(far) - near
    turn = _shortest_turn(arm, first.inverse().apply(last.apply(far)) - near)
    ball = Pose(near - rotate(turn, near), turn)
    return {link: first @ (ball @ poses[link]) for link in bridge.links}


def _shortest_turn(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Unit quaternions (4, m) that turn directions into others about an axis normal to both."""
    a, b = scale(1.0 / norm(start), start), scale(1.0 / norm(end), end)
    # 1 + cos = 2 cos^2 of half the angle, and the sine has the same factor 2 cos of half the angle
    quaternion = np.concatenate([1.0 + dot(a, b)[None], cross(a, b)])
    across = np.zeros_like(a)
    np.put_along_axis(across, np.argmin(np.abs(a), axis=0)[None], 1.0, axis=0)
    half_turn = np.concatenate([np.zeros((1, a.shape[1])), cross(a, across)])
    return np.asarray(normalized(np.where(quaternion[0] > _OPPOSITE, quaternion, half_turn)))


# --- what a joint reads --------------------------------------------------------------------------------------------


def _readings(joint: Joint, between: Pose) -> list[np.ndarray]:
    """The coordinates of a joint from the displacement of its second link in the frame of its first."""
    if joint.type == "S":
        return [between.quaternion]
    axis, point = np.array(joint.axis)[:, None], np.array(joint.point)[:, None]
    q = between.quaternion
    slide = dot(axis, between.apply(point) - point)
    match joint.type:
        case "R":
            return [joint.zero + _angle(dot(axis, q[1:]), q[0])]
        case "P":
            return [joint.zero + slide]
        case "H":
            return [joint.zero + 2.0 * np.pi * slide / joint.pitch]
        case "C":
            return [_angle(dot(axis, q[1:]), q[0]), slide]
        case _:
            # Turn(axis, first) carries axis2 to where it is; Turn(axis2, -second) carries axis to where it is from the second link
            axis2 = np.array(joint.axis2)[:, None]
            first = _turn_about(axis, axis2, rotate(q, axis2))
            second = -_turn_about(axis2, axis, rotate(conjugate(q), axis))
            return [first, second]


def _angle(half_sine: np.ndarray, half_cosine: np.ndarray) -> np.ndarray:
    """The angle in (-pi, pi] from sine and cosine of its half, of either sign together."""
    sign = np.where(half_cosine < 0.0, -1.0, 1.0)
    return np.asarray(2.0 * np.arctan2(sign * half_sine, sign * half_cosine))


def _turn_about(axis: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The angle about an axis from one direction to another, as seen along it."""
    flat = start - dot(axis, start) * axis
    return np.asarray(np.arctan2(dot(axis, cross(flat, end)), dot(flat, end)))
