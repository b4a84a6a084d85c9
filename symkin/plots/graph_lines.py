"""What is drawn of a graph of links at one configuration: NumPy only, base frame, length unit.

A link is drawn through the points of its joints, of its rods' ends and its named points, which its
pose moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from symkin.closure.branches import Branch, edges_of
from symkin.model.bar import Bar
from symkin.model.graph_checks import links_of
from symkin.model.joint import BASE, Joint, JointType
from symkin.model.mechanism import Mechanism
from symkin.plots.sketch_layout import JointMark, best_view, view_onto
from symkin.spatial.pose import Pose

if TYPE_CHECKING:
    from symkin.position.solution import Solution

_SAME = 1e-6
"""Distance over the size below which two points are one, and sine below which two directions
are.
"""
_HAND, _MANY = 0.16, 12
"""Length over the size of the hand that shows how a link of one joint is turned, and how many links
a graph has whose hands are shorter.
"""


@dataclass(frozen=True, eq=False)
class RodLine:
    """A rod between its two ends (3,)."""

    name: str
    start: np.ndarray
    end: np.ndarray
    actuated: bool


@dataclass(eq=False)
class GraphLines:
    """Points (k, 3) of each link by name, joints, rods, rails (a line between the two links of a
    slide), named points, places of coupled joints, joints that close loops, and the platform's
    pose, None where there is none.
    """

    mechanism: Mechanism
    links: dict[str, list[np.ndarray]] = field(default_factory=dict)
    joints: list[JointMark] = field(default_factory=list)
    rods: list[RodLine] = field(default_factory=list)
    rails: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    points: dict[str, np.ndarray] = field(default_factory=dict)
    couplings: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    closing: frozenset[str] = frozenset()
    pose: Pose | None = None

    @property
    def all_points(self) -> np.ndarray:
        """Every point drawn, (k, 3)."""
        found = [point for points in self.links.values() for point in points]
        found += [joint.centre for joint in self.joints]
        return np.array(found or [np.zeros(3)])


def solution_lines(solution: Solution) -> GraphLines:
    """The lines of a solution."""
    return graph_lines(solution.mechanism, solution.link_poses)


def reference_graph_lines(mechanism: Mechanism) -> GraphLines:
    """The lines at the reference configuration, where every link is at rest."""
    links = {link for edge in edges_of(mechanism) for link in edge.ends}
    return graph_lines(mechanism, dict.fromkeys([*links, *links_of(mechanism)], Pose.identity()))


def graph_lines(mechanism: Mechanism, poses: Mapping[str, Pose]) -> GraphLines:
    """The lines of a configuration from the displacements of its links."""
    edges = list(edges_of(mechanism))
    lines = GraphLines(mechanism, closing=_closing(edges))
    slides = [edge for edge in edges if _has_no_place(edge)]
    for edge in edges:
        if isinstance(edge.elements[0].part, Bar):
            _add_rod(lines, edge, poses)
        elif edge not in slides:
            _add_joint(lines, edge, poses)
    for point in mechanism.link_points:
        lines.points[point.name] = poses[point.link].apply(np.array(point.point))
        if point.link != BASE:
            _attach(lines, point.link, lines.points[point.name])
    for edge in slides:
        _add_slide(lines, edge, poses)
    platform = mechanism.platform_link
    if platform is not None:
        lines.pose = poses[platform] @ mechanism.reference_pose
    _add_hands(lines, edges, poses)
    places = {joint.name: joint.centre for joint in lines.joints} | {
        rod.name: 0.5 * (rod.start + rod.end) for rod in lines.rods
    }
    for coupling in mechanism.couplings:
        first, *others = (_joint_of(name, places) for name in (coupling.joint, *coupling.names))
        lines.couplings += [(places[first], places[other]) for other in others]
    return lines


def _closing(edges: Sequence[Branch]) -> frozenset[str]:
    """Joints between links that joints and rods before them in the file join already."""
    heads: dict[str, str] = {}

    def head(link: str) -> str:
        while heads.setdefault(link, link) != link:
            link = heads[link]
        return link

    found = set()
    for edge in edges:
        first, second = (head(link) for link in edge.ends)
        if first == second and isinstance(edge.elements[0].part, Joint):
            found.add(edge.elements[0].part.name)
        heads[first] = second
    return frozenset(found)


def _joint_of(coordinate: str, places: Mapping[str, np.ndarray]) -> str:
    """The joint that has a coordinate: `u.1` is one of `u`."""
    return coordinate if coordinate in places else coordinate.rsplit(".", 1)[0]


def _attach(lines: GraphLines, link: str, point: np.ndarray) -> None:
    lines.links.setdefault(link, []).append(point)


def _part(edge: Branch) -> Joint:
    part = edge.elements[0].part
    assert isinstance(part, Joint)  # noqa: S101 - the caller has asked
    return part


def _has_no_place(edge: Branch) -> bool:
    """A P joint or a weld whose point, which holds nothing, the file may have left out."""
    part = edge.elements[0].part
    return isinstance(part, Joint) and part.type in ("P", "weld") and not any(part.point)


def _add_rod(lines: GraphLines, edge: Branch, poses: Mapping[str, Pose]) -> None:
    bar = edge.elements[0].part
    assert isinstance(bar, Bar)  # noqa: S101 - the caller has asked
    ends = []
    for link, end in zip(edge.ends, (bar.start, bar.end), strict=True):
        ends.append(poses[link].apply(end.at_reference(lines.mechanism.reference_pose)))
        _attach(lines, link, ends[-1])
    lines.rods.append(RodLine(bar.name, ends[0], ends[1], bar.coordinate is not None))


def _add_joint(lines: GraphLines, edge: Branch, poses: Mapping[str, Pose]) -> None:
    joint = _part(edge)
    before, after = (poses[link] for link in edge.ends)
    place = lines.mechanism.places[joint.name]
    start, end = before.apply(place), after.apply(place)
    _attach(lines, edge.ends[0], start)
    _attach(lines, edge.ends[1], end)
    if joint.type in "PCH":
        lines.rails.append((start, end))
    _mark(lines, joint, end, before, after)


def _add_slide(lines: GraphLines, edge: Branch, poses: Mapping[str, Pose]) -> None:
    """A slide or weld without a place of its own stands at the other joints of the link that moves
    on the base, or halfway between those of its two links.
    """
    joint = _part(edge)
    middles = {
        link: np.mean(lines.links[link], axis=0)
        for link in edge.ends
        if link != BASE and lines.links.get(link)
    }
    centre = (
        np.mean(list(middles.values()), axis=0)
        if middles
        else poses[edge.ends[1]].apply(np.array(joint.point))
    )
    for link in edge.ends:
        _attach(lines, link, centre)
    _mark(lines, joint, centre, poses[edge.ends[0]], poses[edge.ends[1]])


def _mark(lines: GraphLines, joint: Joint, centre: np.ndarray, before: Pose, after: Pose) -> None:
    turned = [(before, joint.axis), (after, joint.axis2)]
    axes = tuple(np.asarray(pose.turn(np.array(axis))) for pose, axis in turned if axis is not None)
    lines.joints.append(
        JointMark(joint.name, joint.type, np.asarray(centre), axes, joint.actuated, joint.name)
    )


def _add_hands(lines: GraphLines, edges: Sequence[Branch], poses: Mapping[str, Pose]) -> None:
    """A link with one point gets a second one, which turns with it."""
    size, taken = lines.mechanism.characteristic_length, list[np.ndarray]()
    hand = _HAND * size * min(1.0, np.sqrt(_MANY / len(lines.links)))
    for edge in edges:
        part = edge.elements[0].part
        axis = np.array(getattr(part, "axis", None) or (0.0, 0.0, 1.0))
        first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        across = _unit(0.5 * _unit(first) + _unit(np.cross(axis, first)))
        for link in edge.ends:
            points = lines.links.get(link, [])
            if link != BASE and len(points) == 1:
                # hands at one place are of different lengths
                longer = sum(
                    float(np.linalg.norm(points[0] - other)) < _SAME * size for other in taken
                )
                taken.append(points[0])
                points.append(
                    points[0] + (1.0 + 0.5 * longer) * hand * np.asarray(poses[link].turn(across))
                )


def _unit(vector: np.ndarray) -> np.ndarray:
    return np.asarray(vector / np.linalg.norm(vector))


# --- view -----------------------------------------------------------------------------------------


def view_axes(lines: GraphLines) -> tuple[np.ndarray, bool]:
    """Rows right, up and towards the eye, and whether the mechanism is planar and seen along its
    axes.
    """
    normal = _plane_normal(lines)
    if normal is not None:
        return view_onto(normal), True
    size = lines.mechanism.characteristic_length
    ends = [
        JointMark(f"{rod.name}.{k}", _BALL, place, (), False, rod.name)
        for rod in lines.rods
        for k, place in enumerate((rod.start, rod.end))
    ]
    return best_view([*lines.joints, *ends], size), False


_BALL: JointType = "S"


def _plane_normal(lines: GraphLines) -> np.ndarray | None:
    """The axis about which everything turns and across which everything slides; None where there is
    none. A ball that closes a loop turns about it too, as the links that it joins do.
    """
    turning = [joint.axes[0] for joint in lines.joints if joint.type == "R"]
    others = [joint for joint in lines.joints if joint.type not in ("R", "P", "weld")]
    if (
        not turning
        or lines.rods
        or any(joint.type != "S" or joint.name not in lines.closing for joint in others)
    ):
        return None
    normal = turning[0] * np.sign(turning[0][int(np.argmax(np.abs(turning[0])))])
    parallel = all(np.linalg.norm(np.cross(axis, normal)) < _SAME for axis in turning)
    across = all(abs(joint.axes[0] @ normal) < _SAME for joint in lines.joints if joint.type == "P")
    return normal if parallel and across else None
