"""Read the loops that are written into a URDF: closing frames, <loop_joint>, <loop>, <coupling>,
<constraint>, <gazebo><joint>, <drake:ball_constraint>.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from symkin.formats.couplings import LinearEquation
from symkin.formats.robot import Direction, RobotJoint, Z, frame_along
from symkin.formats.sdf_frames import NEWEST, sdf_pose
from symkin.formats.sdf_joint import sdf_axis, sdf_type
from symkin.formats.urdf_parts import (
    direction,
    known_link,
    origin,
    plain_tag,
    pose_of,
    refuse_itself,
)
from symkin.formats.xml_text import Element
from symkin.model.joined import along, way
from symkin.model.joint_forms import JOINT_FORMS, JointType
from symkin.spatial.pose import Pose
from symkin.text import not_among

LOOP_TAGS = ("loop_joint", "loop", "coupling", "constraint", "ball_constraint")
"""Elements of a robot that close loops or couple joints, without their maker's prefix."""
_TYPES: dict[str, JointType] = {
    "revolute": "R",
    "continuous": "R",
    "hinge": "R",
    "prismatic": "P",
    "cylindrical": "C",
    "fixed": "weld",
    "weld": "weld",
    "ball": "S",
    "spherical": "S",
    "point": "S",
}
_CLOSING = re.compile(r"closing_(.+)_([12])")
"""Links of onshape-to-robot: the two frames of one mate."""
_OPPOSITE = 1e-9
"""Below this 1 + cos is rounding of axes that are 180 deg apart, to 5e-5 rad."""


def loops_within(
    root: Element, zero: Mapping[str, Pose], taken: Collection[str], told: Collection[str] = ()
) -> tuple[list[RobotJoint], list[str]]:
    """The closing joints of a robot, and notes; `zero` are the poses of its links where all joints
    are 0 (of those that joints place), `taken` links whose frames are told beside the file, `told`
    names of closures whose kind is.
    """
    reader = _Reader(root, zero)
    pairs = reader.closing_pairs(taken)
    joints = [*pairs, *(reader.joint(element) for element in reader.elements)]
    points = [joint.name for joint in pairs if joint.name not in told]
    notes = [
        f"the kind of the mates is not written in the file: {', '.join(points)} hold a point, as "
        f"ball joints; `loop` (--loop {first}=R) tells another"
        for first in points[:1]
    ]
    return joints, notes


class _Reader:
    """The elements of a robot that close loops."""

    def __init__(self, root: Element, zero: Mapping[str, Pose]) -> None:
        self.root, self.zero = root, zero
        self.links = [link.attribute("name") for link in root.all("link")]
        own = [e for e in root.children if plain_tag(e.tag) in LOOP_TAGS and e.tag != "coupling"]
        self.elements = own + [
            joint for gazebo in root.all("gazebo") for joint in gazebo.all("joint")
        ]

    def joint(self, element: Element) -> RobotJoint:
        """The closing joint that an element tells."""
        tag = plain_tag(element.tag)
        if tag not in _FORMS:
            return self._gazebo_joint(element)
        kind = "S" if tag == "ball_constraint" else _type(element)
        ends = [
            (
                _link_of(end, self.links),
                frame,
                direction(at, *tags) if JOINT_FORMS[kind].axes else None,
            )
            for end, frame, at, tags in _FORMS[tag](element)
        ]
        return self._made(element, kind, ends)

    def closing_pairs(self, taken: Collection[str]) -> list[RobotJoint]:
        """Points that the links closing_X_1 and closing_X_2 have in common."""
        found: dict[str, dict[str, str]] = {}
        for link in self.root.all("link"):
            name = link.attribute("name")
            match = _CLOSING.fullmatch(name)
            if match is not None and name not in taken:
                found.setdefault(match[1], {})[match[2]] = name
        for mate, links in found.items():
            if len(links) != 2:
                ((end, name),) = links.items()
                link = next(e for e in self.root.all("link") if e.attribute("name") == name)
                other = f"closing_{mate}_{3 - int(end)}"
                raise link.error(f"the loop's other frame, the link {other!r}, is missing")
        return [
            RobotJoint(
                f"closing_{mate}",
                "S",
                (links["1"], links["2"]),
                closing=True,
                where=f"{self.root.file}: closing_{mate}",
            )
            for mate, links in found.items()
        ]

    def _gazebo_joint(self, element: Element) -> RobotJoint:
        """A joint of SDF between links of the URDF: its pose is in the child's frame."""
        names = [element.needed(tag).text.strip() for tag in ("parent", "child")]
        parent, child = (known_link(name, element, self.links) for name in names)
        frame, _ = sdf_pose(element, NEWEST)
        lost = next((link for link in (parent, child) if link not in self.zero), None)
        if lost is not None:
            raise element.error(
                f"no joint places the link {lost!r}, and so neither this one, whose frame is told "
                f"in one link only"
            )
        at = self.zero[child] @ frame
        kind = sdf_type(element, ("revolute", "prismatic", "ball", "fixed"))
        has_axis = JOINT_FORMS[kind].axes > 0
        turn = frame_along(sdf_axis(element, "axis", at)) if has_axis else Pose.identity()
        frames = (self.zero[parent].inverse() @ at @ turn, frame @ turn)
        return RobotJoint(
            element.attribute("name"),
            kind,
            (parent, child),
            frames,
            Z if has_axis else None,
            closing=True,
            where=element.where,
        )

    # --- parts ------------------------------------------------------------------------------------

    def _made(
        self, element: Element, kind: JointType, ends: Sequence[tuple[str, Pose, Direction | None]]
    ) -> RobotJoint:
        """A closing joint whose axis is the z axis of both frames."""
        links = (ends[0][0], ends[1][0])
        refuse_itself(*links, element)
        first, second = (
            frame if axis is None else frame @ frame_along(axis) for _, frame, axis in ends
        )
        (_, _, told), (_, frame, other) = ends
        if kind == "P" and other is not None and told != other and set(links) <= self.zero.keys():
            # two axes tell no angle about them, which a slide holds: it is that of the file
            there, back = self.zero[links[0]] @ first, (self.zero[links[1]] @ frame).inverse()
            x, z = (back.turn(there.turn(unit)) for unit in np.eye(3)[[0, 2]])
            second = frame @ frame_along(other, _least_turned(x, z, np.asarray(other)))
        axis = Z if JOINT_FORMS[kind].axes else None
        return RobotJoint(
            element.attribute("name") if "name" in element.attributes else f"loop{element.line}",
            kind,
            links,
            (first, second),
            axis,
            closing=True,
            where=element.where,
        )


def _least_turned(x: np.ndarray, z: np.ndarray, end: np.ndarray) -> list[float]:
    """Where the least turn that takes z along another axis takes an x across z; x itself for
    opposite axes, which every half turn across them joins.
    """
    end = end / np.linalg.norm(end)
    share = 1.0 + z @ end
    return (x if share < _OPPOSITE else x - (x @ end) / share * (z + end)).tolist()


# --- one form each --------------------------------------------------------------------------------

_End = tuple[Element, Pose, Element, tuple[str, ...]]
"""What names a link, the frame on it, and where an axis in this frame is told, under which tags."""


def _loop_joint(element: Element) -> Iterator[_End]:
    """Two frames by their links, and an axis in the first of them."""
    ends = element.all("link1", "link2")
    if len(ends) != 2:
        raise element.error(f"has {len(ends)} of <link1> and <link2>; two links are needed")
    yield from ((end, pose_of(end), element, ()) for end in ends)


def _loop(element: Element) -> Iterator[_End]:
    """Predecessor and successor with an origin each; the axis is in their frames."""
    for end in map(element.needed, ("predecessor", "successor")):
        yield end, origin(end), end if end.all("axis") else element, ()


def _constraint(element: Element) -> Iterator[_End]:
    """Parent and child with an origin each, and an axis in one frame or in both."""
    for tag, other in (("parent", "child"), ("child", "parent")):
        axes = (f"{tag}_axis", f"{other}_axis", "axis")
        yield element.needed(tag), origin(element, f"{tag}_origin"), element, axes


def _ball_constraint(element: Element) -> Iterator[_End]:
    """A point on each of two bodies."""
    for body, point in (("body_A", "p_AP"), ("body_B", "p_BQ")):
        at = element.needed(f"drake:ball_constraint_{point}").numbers("value", 3)
        frame = Pose(np.array(at), Pose.identity().quaternion)
        yield element.needed(f"drake:ball_constraint_{body}"), frame, element, ()


_FORMS = {
    "loop_joint": _loop_joint,
    "loop": _loop,
    "constraint": _constraint,
    "ball_constraint": _ball_constraint,
}
"""The frames of each element that closes a loop."""


def _type(element: Element) -> JointType:
    word = element.attribute("type").lower().removesuffix("_joint")
    if word not in _TYPES:
        raise element.error(f"type of closure = {not_among(element.attribute('type'), _TYPES)}")
    return _TYPES[word]


def _link_of(element: Element, links: Collection[str]) -> str:
    """The link that an element names."""
    return known_link(element.attribute("link", "name"), element, links)


def gears_within(
    root: Element, links: Collection[str], joints: Sequence[RobotJoint]
) -> Iterator[LinearEquation]:
    """The couplings of URDF+: ratio x (sum of the joints from the common ancestor to the
    predecessor) = the same sum to the successor.
    """
    tree = [joint for joint in joints if not joint.closing]
    for element in root.all("coupling"):
        at, end = (_link_of(element.needed(tag), links) for tag in ("predecessor", "successor"))
        ratio, factors = element.needed("ratio").number("value"), dict[str, float]()
        for joint, down in along(way(tree, at, end) or (), at):
            if joint.type not in ("R", "P", "H", "weld"):
                raise element.error(f"the joint {joint.name!r} has no one coordinate to couple")
            if joint.type != "weld":
                # towards the ancestor, then away from it
                factors[joint.name] = -1.0 if down else ratio
        if sum(factor != 0.0 for factor in factors.values()) < 2:
            raise element.error("it couples no two joints")
        # what follows is the joint before the successor
        yield LinearEquation(dict(reversed(factors.items())), 0.0, element.where)
