"""What a format can write of a mechanism: joints of its own types, a tree of them from the base,
and closures between its links.

Joints of other types, rods, and closing joints that the format has no closure for are written in
parts (`Parts`): a universal joint as two revolute ones, a rod as a link between spherical joints, a
closing joint as a joint to a leaf that is welded to the link.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from symkin.errors import MechanismError
from symkin.formats.graph_form import as_graph, is_closed_at_reference
from symkin.formats.naming import fresh_name
from symkin.formats.parts import Parts, Whole, in_two
from symkin.formats.robot import Z
from symkin.model.graph import Coupling, LinkJoint, LinkRod
from symkin.model.graph_checks import links_of
from symkin.model.joined import outward, spanning
from symkin.model.joint import BASE, Joint
from symkin.model.joint_forms import JointType
from symkin.model.mechanism import Mechanism
from symkin.model.motor import Motor

MASS, INERTIA = 0.1, 1e-3
"""Kilograms and kilogram square metres of every link: any that are not zero do."""
_CLOSED = 1e-5
"""Of the size: rods and couplings that miss their lengths and values by less are closed at the
reference, if only to the digits of a file; what they miss is told in the text.
"""

_TURNED = 3.0
"""Radians: closing joints have their values between half turns either way, and those nearer to one
are joints of the tree.
"""

_SQUARE = 1e-14
"""Cosine between the axes of a universal joint that is zero to rounding."""


@dataclass(frozen=True)
class Form:
    """What a format holds, which is called `name`: types of joints that carry a link (`carry`) and
    that close a loop (`close`).

    `free_only`: its closing joints hold neither range nor motor nor turns, so that those with any
    of them are joints of the tree, as joints that are coupled are in every format.
    """

    name: str
    carry: frozenset[JointType]
    close: frozenset[JointType]
    free_only: bool = True


@dataclass(frozen=True)
class Carried:
    """A link and the joints that carry it, in order from its carrier."""

    carrier: str
    link: str
    joints: tuple[Joint, ...]


@dataclass(frozen=True)
class WrittenTree:
    """A mechanism as a format writes it, in metres and radians: `graph` has its points and its
    platform frame; the links of the tree, each behind the one that carries it; closing joints;
    couplings of joints of one coordinate; and what makes parts whole again.
    """

    graph: Mechanism
    carried: tuple[Carried, ...]
    closures: tuple[LinkJoint, ...]
    couplings: tuple[Coupling, ...]
    parts: Parts

    @property
    def joints(self) -> tuple[Joint, ...]:
        """The joints of the tree."""
        return tuple(joint for entry in self.carried for joint in entry.joints)

    def one_by_one(self) -> tuple[LinkJoint, ...]:
        """The joints of the tree, each from its carrier, with a link between each two."""
        taken, found = {entry.link for entry in self.carried}, []
        for entry in self.carried:
            carrier = entry.carrier
            for joint in entry.joints[:-1]:
                link = fresh_name(f"{joint.name}.link", taken)
                found.append(LinkJoint(joint, (carrier, link)))
                carrier = link
            found.append(LinkJoint(entry.joints[-1], (carrier, entry.link)))
        return tuple(found)


def written_tree(mechanism: Mechanism, form: Form) -> WrittenTree:
    """The mechanism in what a format holds. Raises MechanismError for a reference that is not
    closed, and for welds in no loop.
    """
    graph = as_graph(mechanism)
    if not is_closed_at_reference(graph, _CLOSED):
        raise MechanismError(
            f"{mechanism.name}: rods or couplings are open at the reference, and {form.name} is "
            f"written of closed ones"
        )
    return _Writer(graph, form).tree()


class _Writer:
    """Takes a graph apart."""

    def __init__(self, graph: Mechanism, form: Form) -> None:
        self.graph, self.form = graph, form
        self.links = set(links_of(graph))
        self.names = {c.name for c in graph.coordinates} | {
            joint.name for joint in graph.all_joints
        }
        self.coupled = {name for c in graph.couplings for name in (c.joint, *c.names)}
        self.couplings = list(graph.couplings)
        self.wholes: list[Whole] = []
        self.turned: list[str] = []
        self.entries = list(graph.link_joints)
        for rod in graph.link_rods:
            self._add_rod(rod)

    def tree(self) -> WrittenTree:
        inside = spanning(self.entries, self._rank)
        self._refuse_welds(inside)
        closures = [self._closed(entry, inside) for entry in self.entries if entry not in inside]
        carried = self._carried(inside)
        graph = self.graph
        parts: list[Joint | LinkRod] = [
            *(entry.joint for entry in graph.link_joints),
            *graph.link_rods,
        ]
        actuated = tuple(part.name for part in parts if part.actuated)
        welds = tuple(entry.joint.name for entry in closures if entry.joint.type == "weld")
        told = Parts(
            tuple(self.wholes),
            actuated,
            welds=welds,
            turned=tuple(self.turned),
            order=tuple(part.name for part in parts),
            platform=None
            if graph.platform_link is None
            else (graph.platform_link, graph.reference_pose),
            points=tuple(graph.link_points),
        )
        return WrittenTree(graph, tuple(carried), tuple(closures), tuple(self.couplings), told)

    # --- rods -------------------------------------------------------------------------------------

    def _add_rod(self, rod: LinkRod) -> None:
        """A rod as links between spherical joints, a slide between them where it is actuated."""
        ends = [fresh_name(end.path, self.names) for end in (rod.bar.start, rod.bar.end)]
        joints, names, number = [Joint(ends[0], "S", rod.start)], [rod.name], rod.length or 0.0
        if rod.actuated:
            along = np.subtract(rod.end, rod.start) if rod.reference_length else Z
            look: dict[str, Any] = {"zero": rod.reference_length - rod.offset, "limits": rod.limits}
            joints.append(Joint(rod.name, "P", rod.end, tuple(along), actuated=True, **look))
            names = [f"{rod.name}.{word}" for word in ("cylinder", "piston")]
            number = rod.offset
        joints.append(Joint(ends[1], "S", rod.end))
        links = [rod.links[0], *(fresh_name(name, self.links) for name in names), rod.links[1]]
        pairs = zip(joints, pairwise(links), strict=True)
        self.entries += [LinkJoint(joint, between) for joint, between in pairs]
        self.wholes.append(Whole(rod.name, "rod", tuple(joint.name for joint in joints), number))

    # --- the tree ---------------------------------------------------------------------------------

    def _rank(self, entry: LinkJoint) -> int:
        """Joints of low rank carry links; those of high rank close loops where there is a
        choice.
        """
        joint = entry.joint
        if joint.type == "weld":
            return 5
        if {c.name for c in joint.coordinates} & self.coupled:
            return 0
        if self._closes(joint):
            return 4 if joint.type == "S" else 3
        return 1 if joint.actuated or joint.limits is not None else 2

    def _closes(self, joint: Joint) -> bool:
        """Whether the format has a closure for it."""
        if (
            joint.type not in self.form.close
            or not _is_plain(joint)
            or {c.name for c in joint.coordinates} & self.coupled
        ):
            return False
        free = joint.limits is None and (joint.type == "P" or abs(joint.zero) < _TURNED)
        return (free and not joint.actuated) or not self.form.free_only

    def _carries(self, joint: Joint) -> bool:
        """Whether a joint may be one of the tree as it is."""
        return joint.type in self.form.carry and _is_plain(joint)

    def _refuse_welds(self, inside: Sequence[LinkJoint]) -> None:
        for entry in inside:
            if entry.joint.type == "weld":
                first, second = entry.links
                raise MechanismError(
                    f"{self.graph.name}: the weld {entry.joint.name!r} alone joins the links "
                    f"{first!r} and {second!r}, which are one link in "
                    f"{self.form.name}; a .toml holds it, or make them one link"
                )

    def _closed(self, entry: LinkJoint, inside: list[LinkJoint]) -> LinkJoint:
        """The closure of a joint outside the tree: itself, the second of its parts, or a weld of
        the leaf that it carries.
        """
        joint, (first, second) = entry.joint, entry.links
        if self._closes(joint):
            return entry
        if joint.type in ("U", "C") and not self._carries(joint):
            one, other = in_two(joint)
            if self._closes(other) and not {one.name, other.name} & self.coupled:
                middle = fresh_name(f"{one.name}.link", self.links)
                inside.append(LinkJoint(one, (first, middle)))
                self.wholes.append(Whole(joint.name, joint.type, (one.name, other.name)))
                return LinkJoint(other, (middle, second))
        leaf = fresh_name(f"{joint.name}.leaf", self.links)
        weld = fresh_name(f"{joint.name}.weld", self.names)
        inside.append(LinkJoint(joint, (first, leaf)))
        self.wholes.append(Whole(joint.name, joint.type, (joint.name, weld), joint.pitch))
        return LinkJoint(Joint(weld, "weld", joint.point), (leaf, second))

    def _carried(self, inside: Sequence[LinkJoint]) -> list[Carried]:
        """The links from the base outward, each with the parts of the joint that carries it."""
        found: list[Carried] = []
        for entry, forward in outward(inside, [BASE], deep=True):
            carrier, link = entry.links if forward else entry.links[::-1]
            parts = self._in_parts(entry.joint)
            if not forward:
                parts = [part.turned() for part in reversed(parts)]
                # of joints in parts the order of these tells it
                if not Parts(tuple(self.wholes)).hold(entry.joint.name):
                    self.turned.append(entry.joint.name)
            found.append(Carried(carrier, link, tuple(parts)))
        return found

    # --- joints in parts --------------------------------------------------------------------------

    def _in_parts(self, joint: Joint) -> list[Joint]:
        """The joint by joints that the format has; the list of wholes is told."""
        if self._carries(joint):
            return [joint]
        made, number = self._parts_of(joint)
        names = tuple(part.name for part in made)
        at = next((k for k, whole in enumerate(self.wholes) if joint.name in whole.parts), None)
        if at is None:
            self.wholes.append(Whole(joint.name, joint.type, names, number))
        else:
            whole = self.wholes[at]
            place = whole.parts.index(joint.name)
            self.wholes[at] = replace(
                whole, parts=(*whole.parts[:place], *names, *whole.parts[place + 1 :])
            )
        return made

    def _parts_of(self, joint: Joint) -> tuple[list[Joint], float]:
        point, name = joint.point, joint.name
        match joint.type:
            case "U" | "C":
                return [*in_two(joint)], 0.0
            case "S":
                words = [fresh_name(f"{name}.{word}", self.names) for word in "xyz"]
                return [
                    Joint(word, "R", point, axis)
                    for word, axis in zip(words, np.eye(3).tolist(), strict=True)
                ], 0.0
            case "H":
                slide = fresh_name(f"{name}.slide", self.names)
                lead = joint.pitch / (2.0 * math.pi)
                self.couplings.append(Coupling(slide, {name: lead}, -lead * joint.zero))
                return [
                    replace(joint, type="R", pitch=0.0),
                    Joint(slide, "P", point, joint.axis),
                ], joint.pitch
            case _:
                raise MechanismError(
                    f"joint {name!r}: {self.form.name} has no joint of type {joint.type}"
                )


def least_effort(motor: Motor) -> float:
    """The effort that a motor gives either way, which formats of one number hold."""
    low, high = motor.effort or (0.0, 0.0)
    return min(-low, high)


def _is_plain(joint: Joint) -> bool:
    """Whether formats that have its type have it so: axes of universal joints are square to each
    other there.
    """
    if joint.axis is None or joint.axis2 is None:
        return True
    return abs(float(np.dot(joint.axis, joint.axis2))) <= _SQUARE
