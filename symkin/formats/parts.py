"""Joints that a format writes in parts, and how they are made whole again when the file is read.

A universal joint is two revolute ones with a link between them, a rod two spherical ones, a joint that closes a loop may be a joint to a
leaf that is welded to the link. Such parts are named in one text of the file, which others pass over:

    knee = U: knee.1, knee.2; rod1 = rod: rod1.from, rod1.to; actuated: hip

Statements stand between semicolons; commas, colons and equals signs are no characters of names.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from symkin.errors import MechanismError
from symkin.model.graph import LinkJoint, LinkRod
from symkin.model.joint import Joint
from symkin.model.mechanism import Mechanism
from symkin.text import shown

KEY = "symkin"
"""What the text is called: <text name="symkin"> of MJCF, <symkin:joints> of URDF and SDF."""
JOINTS_TAG = f"{KEY}:joints"
NAMESPACE = f"urn:{KEY}"
"""Element and namespace of the text in XML that has none of its own."""
_LISTS = ("actuated", "zeros", "reference", "welds", "order")
_KINDS = ("R", "P", "H", "C", "U", "S", "weld", "rod")


@dataclass(frozen=True)
class Whole:
    """A joint or rod that is written in `parts`, joints by name in order from its first link to its second; welds among them join
    leaves to their links. `number` is the pitch of an H (metres a turn), the offset of an actuated rod, the length of another one where
    it is told."""

    name: str
    kind: str
    parts: tuple[str, ...]
    number: float = 0.0


@dataclass(frozen=True)
class Parts:
    """What a file tells of joints beyond its format: those in parts; which joints are actuated (None: not told); values that are added
    to those of the file (`zeros`), or at which the file's loops are closed (`reference`); welds that are joints, not parts of a link
    (`welds`); the order of joints and rods."""

    wholes: tuple[Whole, ...] = ()
    actuated: tuple[str, ...] | None = None
    zeros: Mapping[str, float] = field(default_factory=dict)
    reference: Mapping[str, float] = field(default_factory=dict)
    welds: tuple[str, ...] = ()
    order: tuple[str, ...] = ()

    def drives(self, joint: str, kind: str) -> bool:
        """Whether a joint of the file is actuated, or what it is a part of: of a rod the slide, of a screw the turn."""
        driven = self.actuated or ()
        whole = next((w for w in self.wholes if joint in w.parts and w.name in driven), None)
        if whole is None:
            return joint in driven
        return kind == "P" if whole.kind == "rod" else joint == whole.parts[0] if whole.kind == "H" else kind != "weld"

    def at(self, reference: Mapping[str, float]) -> Parts:
        """The same with the values at which the loops are closed."""
        return replace(self, reference=reference)

    def in_file(self, zeros: Mapping[str, float], welds: tuple[str, ...]) -> Parts:
        """The same with what is added to the file's values, and welds by their names there."""
        return replace(self, zeros=zeros, welds=welds)

    def renamed(self, old: str, new: str) -> Parts:
        """The same where a part is called otherwise."""
        wholes = [replace(w, parts=tuple(new if part == old else part for part in w.parts)) for w in self.wholes]
        return replace(self, wholes=tuple(wholes))

    def with_whole(self, whole: Whole) -> Parts:
        """The same with one more joint in parts, which others may be parts of."""
        return replace(self, wholes=(whole, *self.wholes))


def parts_text(parts: Parts) -> str:
    """The statements of a file."""
    lines = [f"{w.name} = {w.kind}{f' {w.number!r}' if w.number else ''}: {', '.join(w.parts)}" for w in parts.wholes]
    if parts.actuated is not None:
        lines.append(f"actuated: {', '.join(parts.actuated)}")
    for key in ("zeros", "reference"):
        values: Mapping[str, float] = getattr(parts, key)
        if values:
            lines.append(f"{key}: " + ", ".join(f"{name} = {value!r}" for name, value in values.items()))
    for key in ("welds", "order"):
        names: tuple[str, ...] = getattr(parts, key)
        if names:
            lines.append(f"{key}: {', '.join(names)}")
    return "; ".join(lines)


def parts_from(text: str, where: str) -> Parts:
    """The statements of a text. Raises MechanismError, which begins with `where`, for one that is not right."""
    wholes: list[Whole] = []
    found: dict[str, tuple[str, ...]] = {}
    for statement in filter(None, (" ".join(piece.split()) for piece in text.split(";"))):
        head, colon, names = statement.partition(":")
        entries = tuple(filter(None, (name.strip() for name in names.split(","))))
        name, equals, kind = (piece.strip() for piece in head.partition("="))
        if colon and not equals and name in _LISTS and name not in found:
            found[name] = entries
        elif colon and equals and name and entries and kind.partition(" ")[0] in _KINDS:
            word, _, number = kind.partition(" ")
            wholes.append(Whole(name, word, entries, _number(number or "0", statement, where)))
        else:
            raise MechanismError(
                f"{where}: {shown(statement)} is no statement on joints in parts; remove it, or write it as symkin does"
            )
    return Parts(
        tuple(wholes),
        found.get("actuated"),
        _values(found.get("zeros", ()), where),
        _values(found.get("reference", ()), where),
        found.get("welds", ()),
        found.get("order", ()),
    )


def _values(entries: Sequence[str], where: str) -> dict[str, float]:
    pairs = [entry.partition("=") for entry in entries]
    return {name.strip(): _number(value, f"{name} = {value}", where) for name, _, value in pairs}


def _number(text: str, statement: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise MechanismError(f"{where}: {shown(statement)} holds no finite number where one is needed")
    return value


# --- whole again ---------------------------------------------------------------------------------------------------


def whole_again(mechanism: Mechanism, parts: Parts) -> Mechanism:
    """The mechanism with joints and rods in place of their parts. Raises MechanismError for parts that are not there, or not so."""
    if parts == Parts():
        return mechanism
    made = _Made(mechanism, parts)
    made.shift(parts.zeros)
    for whole in parts.wholes:
        made.join(whole)
    return made.mechanism()


class _Made:
    """The joints and rods of a mechanism while parts are joined."""

    def __init__(self, mechanism: Mechanism, parts: Parts) -> None:
        self.given, self.parts = mechanism, parts
        self.joints = {entry.joint.name: entry for entry in mechanism.link_joints}
        self.rods = {rod.name: rod for rod in mechanism.link_rods}
        self.couplings = {coupling.joint: coupling for coupling in mechanism.couplings}

    def shift(self, zeros: Mapping[str, float]) -> None:
        """Add to values what the file leaves out: y' = b + sum f x' becomes y = b + y0 + sum f (x - x0)."""
        for name, value in zeros.items():
            entry = self._known(name)
            limits = None if entry.joint.limits is None else [end + value for end in entry.joint.limits]
            self.joints[name] = replace(entry, joint=replace(entry.joint, zero=entry.joint.zero + value, limits=limits))
        for name, coupling in self.couplings.items():
            offset = coupling.offset + zeros.get(name, 0.0) - sum(f * zeros.get(other, 0.0) for other, f in coupling.terms)
            if coupling.polynomial is None:
                self.couplings[name] = replace(coupling, offset=offset)

    def join(self, whole: Whole) -> None:
        """Put a joint or a rod in the place of its parts."""
        path, links = self._path(whole)
        for name in whole.parts:
            del self.joints[name]
        moving = [joint for joint in path if joint.type != "weld"]
        if len(moving) == 1 and moving[0].name != whole.name:
            self._rename_coordinates(moving[0], whole.name)
        if whole.name in self.joints or whole.name in self.rods:
            raise self._error(f"two joints are named {whole.name!r}")
        if whole.kind == "rod":
            self.rods[whole.name] = self._rod_of(whole, moving, links)
        else:
            self.joints[whole.name] = LinkJoint(self._joint_of(whole, moving), links)

    def _rename_coordinates(self, joint: Joint, name: str) -> None:
        """In couplings, for a joint that is called otherwise."""
        new = {c.name: name + c.name.removeprefix(joint.name) for c in joint.coordinates}
        if not set(new) & {n for c in self.couplings.values() for n in (c.joint, *c.names)}:
            return
        found = {}
        for c in self.couplings.values():
            of = new.get(c.of, c.of) if isinstance(c.of, str) else tuple((new.get(n, n), f) for n, f in c.terms)
            found[new.get(c.joint, c.joint)] = replace(c, joint=new.get(c.joint, c.joint), of=of)
        self.couplings = found

    def mechanism(self) -> Mechanism:
        """All of it, in the order that is told."""
        driven = self.parts.actuated
        for name in driven or ():
            if name not in self.rods:
                self._known(name)
        places = {name: k for k, name in enumerate(self.parts.order)}
        joints = sorted(self.joints.values(), key=lambda entry: places.get(entry.joint.name, len(places)))
        rods = sorted(self.rods.values(), key=lambda rod: places.get(rod.name, len(places)))
        if driven is not None:
            joints = [replace(entry, joint=replace(entry.joint, actuated=entry.joint.name in driven)) for entry in joints]
        couplings = tuple(self.couplings.values())
        try:
            return replace(self.given, link_joints=joints, link_rods=rods, couplings=couplings)
        except MechanismError as error:
            raise self._error(str(error)) from None

    def _known(self, name: str) -> LinkJoint:
        if name not in self.joints:
            raise self._error(f"the text {KEY!r} names the joint {shown(name)}, which the file has not")
        return self.joints[name]

    def _error(self, message: str) -> MechanismError:
        return MechanismError(
            f"{self.given.source or self.given.name}: {message}; remove the text, or what was changed beside it"
        )

    def _path(self, whole: Whole) -> tuple[list[Joint], tuple[str, str]]:
        """The parts, each turned to lead from the first link to the second, and these links."""
        entries = [self._known(name) for name in whole.parts]
        first = entries[0].links[0]
        if len(entries) > 1 and first in entries[1].links:
            first = entries[0].links[1]
        at, path = first, []
        for entry in entries:
            if at not in entry.links:
                raise self._error(f"the parts of {whole.name!r} are no chain of joints")
            forward = entry.links[0] == at
            path.append(entry.joint if forward else turned(entry.joint))
            at = entry.links[1] if forward else entry.links[0]
        return path, (first, at)

    def _joint_of(self, whole: Whole, moving: Sequence[Joint]) -> Joint:
        first = moving[0] if moving else Joint(whole.name, "weld")
        match whole.kind, "".join(joint.type for joint in moving):
            case ("R" | "P" | "S", kind) if kind == whole.kind:
                return replace(first, name=whole.name)
            case "U", "RR":
                return Joint(whole.name, "U", first.point, first.axis, moving[1].axis, actuated=first.actuated)
            case "C", "RP":
                return Joint(whole.name, "C", first.point, first.axis, actuated=first.actuated)
            case "S", "RRR":
                return Joint(whole.name, "S", first.point)
            case "H", "RP" if whole.number:
                self.couplings.pop(moving[1].name, None)
                return replace(first, name=whole.name, type="H", pitch=whole.number)
            case ("H", "H") | ("U", "U") | ("weld", ""):
                return replace(first, name=whole.name)
            case _:
                raise self._unfit(whole)

    def _rod_of(self, whole: Whole, moving: Sequence[Joint], links: tuple[str, str]) -> LinkRod:
        """A rod between the centres of its first and last part; a prismatic joint between them drives it."""
        types = [joint.type for joint in moving]
        balls = len(types) > 1 and types[0] in ("S", "R") and types[-1] in ("S", "R")
        drives = [joint for joint in moving if joint.type == "P"]
        if not balls or len(drives) > 1 or set(types) > {"S", "R", "P"}:
            raise self._unfit(whole)
        start, end = moving[0].point, moving[-1].point
        if not drives:
            return LinkRod(whole.name, links, start, end, length=whole.number or None)
        return LinkRod(whole.name, links, start, end, actuated=True, offset=whole.number, limits=drives[0].limits)

    def _unfit(self, whole: Whole) -> MechanismError:
        return self._error(f"the parts of {whole.name!r}, {', '.join(whole.parts)}, make no {whole.kind}")


def turned(joint: Joint) -> Joint:
    """A joint as it is seen from its second link, which its coordinate moves the other way about."""
    axis, axis2 = (None if a is None else tuple(-c + 0.0 for c in a) for a in (joint.axis, joint.axis2))
    return replace(joint, axis=axis2, axis2=axis) if joint.type == "U" else replace(joint, axis=axis)
