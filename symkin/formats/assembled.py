"""Make a mechanism of a robot at a closed configuration: every joint of the tree and every closure
becomes a joint between two links, and joints and rods that the file holds in parts are made whole.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symkin.closure.link_poses import joint_coordinates
from symkin.errors import MechanismError
from symkin.formats.parts import KEY, Parts, Whole
from symkin.formats.robot import ClosingJoint, Robot
from symkin.formats.tree import Closed, nearest_closed
from symkin.model.graph import LinkJoint, LinkRod
from symkin.model.joint import Joint
from symkin.model.joint_forms import JointType
from symkin.model.mechanism import Mechanism
from symkin.model.mesh import LinkMesh
from symkin.model.names import identifier
from symkin.spatial.pose import Pose
from symkin.text import printable, shown


def mechanism_of(robot: Robot) -> Mechanism:
    """Close a robot's loops and make the mechanism. Raises MechanismError where no configuration
    closes them.
    """
    return assembled(robot, require_closed(robot))


def require_closed(robot: Robot) -> Closed:
    """The closed configuration nearest to the file's own. Raises MechanismError, with the loop that
    resists, where there is none.
    """
    closed = nearest_closed(robot)
    if not closed.to_digits:
        raise MechanismError(f"{robot.source or robot.name}: {open_sentence(closed)}")
    return closed


def open_sentence(closed: Closed) -> str:
    """What is said of loops that no configuration found closes."""
    places = {c.joint.name: f" ({c.where})" for c in closed.tree.robot.closures if c.where}
    return (
        f"no configuration was found that closes the loops: the best one leaves "
        f"{closed.residual:.3g} m, most of it in the loop of "
        f"{closed.resists}{places.get(closed.resists, '')}; check its frames and the types of the "
        f"joints along it"
    )


def assembled(robot: Robot, closed: Closed) -> Mechanism:
    """The graph of links at a closed configuration, which is its reference; joints of one
    coordinate keep their values, those of two count from there, also in couplings.
    """
    if not robot.joints:
        raise MechanismError(
            f"{robot.source or robot.name}: no joint moves; a mechanism needs one at least"
        )
    several = [entry.joint for entry in robot.tree if entry.joint.type in ("C", "U")]
    away = {c.name: closed.values[c.name][0] for joint in several for c in joint.coordinates}
    found = Mechanism(
        identifier(robot.name),
        link_joints=[_moved(entry, closed) for entry in robot.joints],
        couplings=[coupling.counted_from(away) for coupling in robot.couplings],
        length_unit="m",
        angle_unit="rad",
        source=printable(robot.source),
        link_meshes=list(_link_meshes(robot, closed)),
    )
    return whole_again(found, robot.parts.moved(closed.displacements))


def _link_meshes(robot: Robot, closed: Closed) -> Iterator[LinkMesh]:
    """The meshes of links, and of bodies that are part of them, where the links are."""
    for name, meshes in robot.meshes.items():
        link, frame = robot.frames[name]
        for mesh in meshes:
            pose = closed.displacements[link] @ frame @ mesh.pose
            yield LinkMesh(
                link, mesh.file, tuple(pose.position), tuple(pose.quaternion), mesh.scale
            )


def _moved(entry: LinkJoint, closed: Closed) -> LinkJoint:
    """A joint where its links are, a closure half of what is left open away from its first frame;
    `zero` is its value there, for joints of one coordinate.
    """
    joint = entry.joint
    first, second = (closed.displacements[link] for link in entry.links)
    point = first.apply(np.array(joint.point))
    if closes := isinstance(entry, ClosingJoint):
        second = second @ entry.gap
        point = 0.5 * (point + second.apply(np.array(joint.point)))
    changes: dict[str, Any] = {"point": tuple(point)}
    for key, pose in (("axis", first), ("axis2", second)):
        own = getattr(joint, key)
        changes[key] = None if own is None else tuple(pose.turn(np.array(own)))
    if joint.freedom == 1:
        changes["zero"] = (
            _reading(replace(joint, zero=0.0), first.inverse() @ second)
            if closes
            else closed.values[joint.name][0]
        )
    made = LinkJoint(replace(joint, **changes), entry.links)
    return made.turned() if closes and joint.name in closed.tree.robot.parts.turned else made


def _reading(joint: Joint, between: Pose) -> float:
    """The coordinate of a joint where its second link is displaced in its first."""
    columns = Pose(between.position[:, None], between.quaternion[:, None])
    (value,) = joint_coordinates(joint, columns)
    return float(value[0])


def whole_again(mechanism: Mechanism, parts: Parts) -> Mechanism:
    """The mechanism with joints and rods in place of their parts. Raises MechanismError for parts
    that are not there, or not so.
    """
    if parts == Parts() and parts.platform is None:
        return mechanism
    made = _Made(mechanism, parts)
    made.check_known(parts.turned)
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
        """Add to values what the file leaves out."""
        for name, value in zeros.items():
            entry = self._known(name)
            joint = entry.joint
            limits = joint.limits and [end + value for end in joint.limits]
            moved = replace(joint, zero=joint.zero + value, limits=limits)
            self.joints[name] = replace(entry, joint=moved)
        before = {name: -value for name, value in zeros.items()}
        for name, coupling in self.couplings.items():
            self.couplings[name] = coupling.counted_from(before)

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
        couplings = [coupling.renamed(new) for coupling in self.couplings.values()]
        self.couplings = {coupling.joint: coupling for coupling in couplings}

    def mechanism(self) -> Mechanism:
        """All of it, in the order that is told."""
        driven = self.parts.actuated
        self.check_known(name for name in driven or () if name not in self.rods)
        places = {name: k for k, name in enumerate(self.parts.order)}

        def place(name: str) -> int:
            return places.get(name, len(places))

        joints = [self.joints[name] for name in sorted(self.joints, key=place)]
        rods = [self.rods[name] for name in sorted(self.rods, key=place)]
        if driven is not None:
            joints = [
                replace(entry, joint=replace(entry.joint, actuated=entry.joint.name in driven))
                for entry in joints
            ]
        changes: dict[str, Any] = {}
        if self.parts.platform is not None:
            link, pose = self.parts.platform
            frame = {"platform_position": pose.position, "platform_quaternion": pose.quaternion}
            changes = {key: tuple(map(float, values)) for key, values in frame.items()}
            changes["platform_link"] = link
        try:
            return replace(
                self.given,
                link_joints=joints,
                link_rods=rods,
                couplings=tuple(self.couplings.values()),
                link_points=self.parts.points,
                **changes,
            )
        except MechanismError as error:
            raise self._error(str(error)) from None

    def check_known(self, names: Iterable[str]) -> None:
        """Raise MechanismError for a name that no joint has."""
        for name in names:
            self._known(name)

    def _known(self, name: str) -> LinkJoint:
        if name not in self.joints:
            raise self._error(
                f"the text {KEY!r} names the joint {shown(name)}, which the file has not"
            )
        return self.joints[name]

    def _error(self, message: str) -> MechanismError:
        return MechanismError(
            f"{self.given.source or self.given.name}: {message}; remove the text, or what was "
            f"changed beside it"
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
            path.append(entry.joint if forward else entry.joint.turned())
            at = entry.links[1] if forward else entry.links[0]
        return path, (first, at)

    def _joint_of(self, whole: Whole, moving: Sequence[Joint]) -> Joint:
        first = moving[0] if moving else Joint(whole.name, "weld")
        kinds = "".join(joint.type for joint in moving) or "weld"
        match whole.kind, kinds:
            case ("U", "RR") | ("C", "RP"):
                kind: JointType = "U" if kinds == "RR" else "C"
                axis2 = moving[1].axis if kind == "U" else None
                own = (first.point, first.axis, axis2)
                return Joint(whole.name, kind, *own, actuated=first.actuated)
            case "S", "RRR":
                return Joint(whole.name, "S", first.point)
            case "H", "RP" if whole.number:
                self.couplings.pop(moving[1].name, None)
                return replace(first, name=whole.name, type="H", pitch=whole.number)
            case told, found if told == found:
                return replace(first, name=whole.name)
            case _:
                raise self._unfit(whole)

    def _rod_of(self, whole: Whole, moving: Sequence[Joint], links: tuple[str, str]) -> LinkRod:
        """A rod between the centres of its first and last part; a prismatic joint between them
        drives it.
        """
        types = [joint.type for joint in moving]
        balls = len(types) > 1 and types[0] in ("S", "R") and types[-1] in ("S", "R")
        drives = [joint for joint in moving if joint.type == "P"]
        if not balls or len(drives) > 1 or set(types) > {"S", "R", "P"}:
            raise self._unfit(whole)
        told: dict[str, Any] = {"length": whole.number or None}
        if drives:
            told = {"actuated": True, "offset": whole.number, "limits": drives[0].limits}
        return LinkRod(whole.name, links, moving[0].point, moving[-1].point, **told)

    def _unfit(self, whole: Whole) -> MechanismError:
        return self._error(
            f"the parts of {whole.name!r}, {', '.join(whole.parts)}, make no {whole.kind}"
        )
