"""Make joints and rods whole again that a file holds in parts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from symkin.errors import MechanismError
from symkin.formats.parts import KEY, Parts, Whole
from symkin.model.graph import LinkJoint, LinkRod
from symkin.model.joint import Joint
from symkin.model.joint_forms import JointType
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.text import shown


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
            limits = (
                None if entry.joint.limits is None else [end + value for end in entry.joint.limits]
            )
            self.joints[name] = replace(
                entry, joint=replace(entry.joint, zero=entry.joint.zero + value, limits=limits)
            )
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
        joints = sorted(
            self.joints.values(), key=lambda entry: places.get(entry.joint.name, len(places))
        )
        rods = sorted(self.rods.values(), key=lambda rod: places.get(rod.name, len(places)))
        if driven is not None:
            joints = [
                replace(entry, joint=replace(entry.joint, actuated=entry.joint.name in driven))
                for entry in joints
            ]
        couplings = tuple(self.couplings.values())
        try:
            made = replace(
                self.given,
                link_joints=joints,
                link_rods=rods,
                couplings=couplings,
                link_points=self.parts.points,
            )
            return made if self.parts.platform is None else _with_frame(made, *self.parts.platform)
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
        start, end = moving[0].point, moving[-1].point
        if not drives:
            return LinkRod(whole.name, links, start, end, length=whole.number or None)
        return LinkRod(
            whole.name,
            links,
            start,
            end,
            actuated=True,
            offset=whole.number,
            limits=drives[0].limits,
        )

    def _unfit(self, whole: Whole) -> MechanismError:
        return self._error(
            f"the parts of {whole.name!r}, {', '.join(whole.parts)}, make no {whole.kind}"
        )


def _with_frame(mechanism: Mechanism, link: str, pose: Pose) -> Mechanism:
    position, quaternion = (
        tuple(float(v) for v in values) for values in (pose.position, pose.quaternion)
    )
    return replace(
        mechanism, platform_link=link, platform_position=position, platform_quaternion=quaternion
    )
