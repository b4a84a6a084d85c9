"""Joints that a format writes in parts, and how they are made whole again when the file is read.

A universal joint is two revolute ones with a link between them, a rod two spherical ones, a joint
that closes a loop may be a joint to a leaf that is welded to the link. Such parts are named in one
text of the file, which others pass over:

    knee = U: knee.1, knee.2; rod1 = rod: rod1.from, rod1.to; actuated: hip; turned: wrist

Statements stand between semicolons; commas, colons and equals signs are no characters of names.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from symkin.errors import MechanismError
from symkin.model.graph import LinkPoint
from symkin.model.joint import Joint
from symkin.model.joint_forms import JointType
from symkin.model.mechanism import unit_quaternion
from symkin.spatial.pose import Pose
from symkin.text import shown

KEY = "symkin"
"""What the text is called: <text name="symkin"> of MJCF, <symkin:joints> of URDF and SDF."""
JOINTS_TAG = f"{KEY}:joints"
NAMESPACE = f"urn:{KEY}"
"""Element and namespace of the text in XML that has none of its own."""
_KINDS = ("R", "P", "H", "C", "U", "S", "weld", "rod")


@dataclass(frozen=True)
class Whole:
    """A joint or rod that is written in `parts`, joints by name in order from its first link to its
    second; welds among them join leaves to their links. `number` is the pitch of an H (metres a
    turn), the offset of an actuated rod, the length of another one where it is told.
    """

    name: str
    kind: str
    parts: tuple[str, ...]
    number: float = 0.0


@dataclass(frozen=True)
class Parts:
    """What a file tells of joints beyond its format: those in parts; which joints are actuated
    (None: not told); values that are added to those of the file (`zeros`), or at which the file's
    loops are closed (`reference`); welds that are joints, not parts of a link (`welds`); joints
    that lead from the file's second link to its first (`turned`); the order of joints and rods; the
    link that carries the platform frame, with the frame's pose, and named points of links, in the
    base frame at the file's configuration.
    """

    wholes: tuple[Whole, ...] = ()
    actuated: tuple[str, ...] | None = None
    zeros: Mapping[str, float] = field(default_factory=dict)
    reference: Mapping[str, float] = field(default_factory=dict)
    welds: tuple[str, ...] = ()
    turned: tuple[str, ...] = ()
    order: tuple[str, ...] = ()
    platform: tuple[str, Pose] | None = field(default=None, compare=False)
    points: tuple[LinkPoint, ...] = ()

    def drives(self, joint: str, kind: str) -> bool:
        """Whether a joint of the file is actuated, or what it is a part of: of a rod the slide, of
        a screw the turn.
        """
        driven = self.actuated or ()
        for whole in self.wholes:
            if joint in whole.parts and whole.name in driven:
                is_slide, is_turn = kind == "P", joint == whole.parts[0]
                return {"rod": is_slide, "H": is_turn}.get(whole.kind, kind != "weld")
        return joint in driven

    def hold(self, joint: str) -> bool:
        """Whether a joint is written in parts, or is one."""
        return any(joint in (whole.name, *whole.parts) for whole in self.wholes)

    def moved(self, displacements: Mapping[str, Pose]) -> Parts:
        """The same where links are displaced."""
        points = [
            replace(p, point=displacements[p.link].apply(np.array(p.point)))
            for p in self.points
            if p.link in displacements
        ]
        platform = self.platform
        if platform is not None and platform[0] in displacements:
            platform = (platform[0], displacements[platform[0]] @ platform[1])
        return replace(self, points=tuple(points), platform=platform)

    def renamed(self, old: str, new: str) -> Parts:
        """The same where a part is called otherwise."""
        wholes = [
            replace(w, parts=tuple(new if part == old else part for part in w.parts))
            for w in self.wholes
        ]
        return replace(self, wholes=tuple(wholes))

    def with_whole(self, whole: Whole) -> Parts:
        """The same with one more joint in parts, which others may be parts of."""
        return replace(self, wholes=(whole, *self.wholes))


def parts_text(parts: Parts) -> str:
    """The statements of a file."""
    lines = [
        f"{w.name} = {w.kind}{f' {w.number!r}' if w.number else ''}: {', '.join(w.parts)}"
        for w in parts.wholes
    ]
    for key, (write, _) in _LISTS.items():
        told = getattr(parts, key)
        if told or (key == "actuated" and told is not None):
            lines.append(f"{key}: {', '.join(write(told))}")
    return "; ".join(lines)


def parts_from(text: str, where: str) -> Parts:
    """The statements of a text. Raises MechanismError, which begins with `where`, for one that is
    not right.
    """
    wholes: list[Whole] = []
    found: dict[str, Any] = {}
    for statement in filter(None, (" ".join(piece.split()) for piece in text.split(";"))):
        head, colon, names = statement.partition(":")
        entries = tuple(filter(None, (name.strip() for name in names.split(","))))
        name, equals, kind = (piece.strip() for piece in head.partition("="))
        if colon and not equals and name in _LISTS and name not in found:
            found[name] = _LISTS[name][1](entries, where)
        elif colon and equals and name and entries and kind.partition(" ")[0] in _KINDS:
            word, _, number = kind.partition(" ")
            wholes.append(Whole(name, word, entries, _number(number or "0", statement, where)))
        else:
            raise MechanismError(
                f"{where}: {shown(statement)} is no statement on joints in parts; remove it, or "
                f"write it as symkin does"
            )
    return Parts(tuple(wholes), **found)


def _entry(*values: object) -> str:
    """Names and numbers with strokes between them."""
    texts = [v if isinstance(v, str) else repr(float(v) + 0.0) for v in values]  # type: ignore[arg-type]
    return " | ".join(texts)


def _split(entry: str, form: str, names: int, where: str) -> tuple[list[str], list[float]]:
    """The names and the numbers of an entry that is written as `form`."""
    words = [word.strip() for word in entry.split("|")]
    if len(words) != form.count("|") + 1:
        raise MechanismError(f"{where}: {shown(entry)} is no {form}")
    return words[:names], [_number(word, entry, where) for word in words[names:]]


def _points(entries: Sequence[str], where: str) -> tuple[LinkPoint, ...]:
    found = []
    for entry in entries:
        (name, link), point = _split(entry, "NAME | LINK | X | Y | Z", 2, f"{where}: points")
        found.append(LinkPoint(link, name, point))
    return tuple(found)


def _platform(entries: Sequence[str], where: str) -> tuple[str, Pose] | None:
    if not entries:
        return None
    form, place = "LINK | X | Y | Z | QW | QX | QY | QZ", f"{where}: platform"
    (link,), numbers = _split(", ".join(entries), form, 1, place)
    return link, Pose(np.array(numbers[:3]), np.array(unit_quaternion(numbers[3:], place)))


def _values(entries: Sequence[str], where: str) -> dict[str, float]:
    pairs = [entry.partition("=") for entry in entries]
    return {name.strip(): _number(value, f"{name} = {value}", where) for name, _, value in pairs}


_Written = tuple[Callable[[Any], Iterable[str]], Callable[[Sequence[str], str], Any]]
_NAMES: _Written = tuple, lambda entries, _: entries
_NUMBERS: _Written = lambda told: [f"{name} = {value!r}" for name, value in told.items()], _values
_LISTS: dict[str, _Written] = {
    "actuated": _NAMES,
    "zeros": _NUMBERS,
    "reference": _NUMBERS,
    "welds": _NAMES,
    "turned": _NAMES,
    "order": _NAMES,
    "platform": (
        lambda told: [_entry(told[0], *told[1].position, *told[1].quaternion)],
        _platform,
    ),
    "points": (lambda told: [_entry(p.name, p.link, *p.point) for p in told], _points),
}
"""What a file tells beside joints in parts, by its word: how it is written and read."""


def _number(text: str, statement: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise MechanismError(
            f"{where}: {shown(statement)} holds no finite number where one is needed"
        )
    return value


def in_two(joint: Joint) -> tuple[Joint, Joint]:
    """A joint of two coordinates as two joints, which have the names of these."""
    first, second = (c.name for c in joint.coordinates)
    other = joint.axis2 if joint.type == "U" else joint.axis
    kind: JointType = "R" if joint.type == "U" else "P"
    return (
        Joint(first, "R", joint.point, joint.axis, actuated=joint.actuated),
        Joint(second, kind, joint.point, other, actuated=joint.actuated),
    )
