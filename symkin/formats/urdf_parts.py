"""What elements of URDF share: origins, directions, tags with a maker's prefix."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from symkin.errors import InputError
from symkin.formats.parts import JOINTS_TAG, Parts, parts_from
from symkin.formats.robot import Direction
from symkin.formats.xml_text import Element
from symkin.spatial.pose import Pose
from symkin.text import meant


def origin(element: Element, tag: str = "origin") -> Pose:
    """The pose in the child <origin xyz rpy>; the identity where there is none."""
    found = element.one(tag)
    return Pose.identity() if found is None else pose_of(found)


def pose_of(element: Element) -> Pose:
    """The pose in the attributes xyz and rpy (or quat_xyzw) of an element; 0 where they are
    missing.
    """
    position = element.numbers("xyz", 3, (0.0, 0.0, 0.0))
    if "quat_xyzw" in element.attributes:
        if "rpy" in element.attributes:
            raise element.error("has rpy and quat_xyzw; one rotation is needed")
        return turned_pose(element, position, element.numbers("quat_xyzw", 4))
    return Pose.from_euler(position, element.numbers("rpy", 3, (0.0, 0.0, 0.0)), "xyz")


def turned_pose(element: Element, position: Sequence[float], xyzw: Sequence[float]) -> Pose:
    """The pose of a position and a quaternion that an element holds."""
    try:
        return Pose.from_quaternion(np.asarray(position), np.asarray(xyzw), order="xyzw")
    except InputError as error:
        raise element.error(str(error)) from None


def direction(element: Element, *tags: str) -> Direction:
    """The unit vector in the child <axis xyz>, or the first of other tags that is there. Raises
    MechanismError where it is missing or zero.
    """
    found = next(
        (axis for tag in (tags or ("axis",)) if (axis := element.one(tag)) is not None), None
    )
    if found is None:
        raise element.error(
            '<axis> is missing; write it, as in <axis xyz="1 0 0"/>, which is the default of URDF'
        )
    return unit(found, found.numbers("xyz", 3))


def unit(element: Element, vector: tuple[float, ...]) -> Direction:
    """A vector of length 1. Raises MechanismError for the zero vector."""
    x, y, z = vector
    length = math.hypot(x, y, z)
    if length < 1e-9:
        raise element.error(f"{[x, y, z]} is the zero vector; a direction is needed")
    return (x, y, z) if abs(length - 1.0) < 4e-16 else (x / length, y / length, z / length)


def known_link(name: str, element: Element, links: Collection[str]) -> str:
    """The name of a link. Raises MechanismError for one that no link has."""
    if name not in links:
        raise element.error(f"the link {name!r} is unknown{meant(name, links)}")
    return name


def refuse_itself(first: str, second: str, element: Element) -> None:
    """Raise MechanismError for a joint between a link and itself."""
    if first == second:
        raise element.error(f"joins the link {first!r} to itself; two links are needed")


def plain_tag(tag: str) -> str:
    """A tag without its prefix: drake:ball_constraint is ball_constraint."""
    return tag.rpartition(":")[2]


def parts_within(element: Element) -> Parts:
    """What an element tells of joints in parts."""
    text = element.one(JOINTS_TAG)
    return Parts() if text is None else parts_from(text.text, text.where)


def names_any(element: Element, names: set[str]) -> bool:
    """Whether an attribute or text within the element is one of the names."""
    return any(
        e.text.strip() in names or names & {v.strip() for v in e.attributes.values()}
        for e in element.walk()
    )
