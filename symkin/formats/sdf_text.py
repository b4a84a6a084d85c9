"""Write a mechanism as SDF: links at the reference, and its joints as the graph that they are.

Joints of SDF are 0 where the file has the links: what is added to their values is told in the text
<symkin:joints>, with which joints are parts of one. The base is the world. Couplings are `mimic`.
Masses are plain: they have no meaning for the kinematics.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from symkin.errors import MechanismError
from symkin.formats.couplings import mimic_of
from symkin.formats.naming import fresh_name
from symkin.formats.parts import JOINTS_TAG, NAMESPACE, Whole, parts_text
from symkin.formats.sdf_frames import NEWEST, WORLD
from symkin.formats.written_tree import (
    INERTIA,
    MASS,
    Form,
    WrittenTree,
    least_effort,
    written_tree,
)
from symkin.formats.xml_written import Element, document, element, inside, numbers
from symkin.model.graph import Coupling, LinkJoint
from symkin.model.joint import BASE, Coordinate, Joint
from symkin.model.mechanism import Mechanism
from symkin.model.motor import Motor

_TYPES = {
    "R": "revolute",
    "P": "prismatic",
    "H": "screw",
    "U": "universal",
    "S": "ball",
    "weld": "fixed",
}
FORM = Form(
    "SDF",
    carry=frozenset({"R", "P", "H", "U", "S"}),
    close=frozenset({"R", "P", "H", "U", "S", "weld"}),
    free_only=False,
)
_MOTOR = ("gz-sim-joint-position-controller-system", "gz::sim::systems::JointPositionController")


def sdf_text(mechanism: Mechanism) -> str:
    """The SDF file of a mechanism. Raises MechanismError for what SDF cannot hold."""
    return _Text(written_tree(mechanism, FORM)).document()


class _Text:
    """The elements of the file."""

    def __init__(self, tree: WrittenTree) -> None:
        self.tree, self.name = tree, tree.graph.name
        self.places: dict[str, np.ndarray] = {BASE: np.zeros(3)}
        inside_tree = tree.one_by_one()
        self.places |= {entry.links[1]: np.array(entry.joint.point) for entry in inside_tree}
        # the base is no child
        backward = [e.joint.name for e in tree.closures if e.links[1] == BASE]
        closures = [e.turned() if e.joint.name in backward else e for e in tree.closures]
        self.joints = [*inside_tree, *closures]
        self.turned = {*tree.parts.turned, *(n for n in backward if not tree.parts.hold(n))}
        self._refuse_names()
        self.names = self._joint_names()
        self.zeros = {
            e.joint.name: e.joint.zero for e in self.joints if e.joint.freedom == 1 and e.joint.zero
        }
        self.couplings = {coupling.joint: coupling for coupling in tree.couplings}
        self.axes = {
            c.name: (e.joint, tag) for e in self.joints for c, tag in self._tagged(e.joint)
        }

    def document(self) -> str:
        root = element("sdf", version=".".join(str(part) for part in NEWEST))
        root.set("xmlns:symkin", NAMESPACE)
        model = inside(root, "model", name=self.name)
        for link, place in self.places.items():
            if link != BASE:
                self._link(model, link, place)
        # coupled joints stand in the tree of whoever reads
        coupled = {name for c in self.couplings.values() for name in (c.joint, *c.names)}
        for entry in sorted(
            self.joints, key=lambda e: not {c.name for c in e.joint.coordinates} & coupled
        ):
            self._joint(model, entry)
        for entry in self.joints:
            if entry.joint.actuated:
                plugin = inside(model, "plugin", filename=_MOTOR[0], name=_MOTOR[1])
                inside(plugin, "joint_name", self.names[entry.joint.name])
        inside(model, JOINTS_TAG, self._parts())
        return document(root, self.name)

    def _refuse_names(self) -> None:
        for what, names in (("link", self.places), ("joint", [e.joint.name for e in self.joints])):
            wrong = next(
                (n for n in names if n == WORLD or (n.startswith("__") and n.endswith("__"))), None
            )
            if wrong is not None:
                raise MechanismError(
                    f"{self.name}: a {what} is named {wrong!r}, which SDF keeps for itself; rename "
                    f"it"
                )

    def _joint_names(self) -> dict[str, str]:
        """Names of joints in the file, where links and joints have none in common."""
        names = [e.joint.name for e in self.joints]
        taken = {*self.places, *names}
        return {n: fresh_name(f"{n}.joint", taken) if n in self.places else n for n in names}

    def _parts(self) -> str:
        """The text, in the file's names of joints."""
        parts = self.tree.parts
        kinds = {e.joint.name: e.joint for e in self.joints}
        for old, new in self.names.items():
            if old != new and any(old in whole.parts for whole in parts.wholes):
                parts = parts.renamed(old, new)
            elif old != new:
                parts = parts.with_whole(Whole(old, kinds[old].type, (new,), kinds[old].pitch))
        welds = tuple(self.names[name] for name in parts.welds)
        other_way = tuple(new for old, new in self.names.items() if old in self.turned)
        zeros = {self.names[name]: zero for name, zero in self.zeros.items()}
        return parts_text(replace(parts, zeros=zeros, welds=welds, turned=other_way))

    def _tagged(self, joint: Joint) -> Iterator[tuple[Coordinate, str]]:
        """The coordinates with the elements of their axes in the file; of a universal joint that is
        turned the last comes first.
        """
        coordinates = joint.coordinates[::-1] if joint.name in self.turned else joint.coordinates
        return zip(coordinates, _TAGS, strict=False)

    # --- links and joints -------------------------------------------------------------------------

    def _link(self, model: Element, name: str, place: np.ndarray) -> None:
        link = inside(model, "link", name=name)
        inside(link, "pose", numbers([*place, 0, 0, 0]))
        inertial = inside(link, "inertial")
        inside(inertial, "mass", MASS)
        inertia = inside(inertial, "inertia")
        for word in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
            inside(inertia, word, INERTIA if word[1] == word[2] else 0)

    def _joint(self, model: Element, entry: LinkJoint) -> None:
        joint, (parent, child) = entry.joint, entry.links
        made = inside(model, "joint", name=self.names[joint.name], type_=_TYPES[joint.type])
        inside(made, "pose", numbers([*(np.array(joint.point) - self.places[child]), 0, 0, 0]))
        inside(made, "parent", WORLD if parent == BASE else parent)
        inside(made, "child", child)
        if joint.type == "H":
            inside(made, "screw_thread_pitch", joint.pitch)
        for (coordinate, tag), vector in zip(
            self._tagged(joint), (joint.axis, joint.axis2), strict=False
        ):
            if vector is not None:
                axis = inside(made, tag)
                inside(axis, "xyz", vector)
                self._limit(axis, joint)
                if coordinate.name in self.couplings:
                    self._mimic(axis, self.couplings[coordinate.name])

    def _limit(self, axis: Element, joint: Joint) -> None:
        motor, told = joint.motor or Motor(), dict[str, float]()
        if joint.limits is not None:
            told |= {"lower": joint.limits[0] - joint.zero, "upper": joint.limits[1] - joint.zero}
        if motor.effort is not None:
            told["effort"] = least_effort(motor)
        if motor.speed is not None:
            told["velocity"] = motor.speed
        limit = inside(axis, "limit") if told else axis
        for word, value in told.items():
            inside(limit, word, value)

    def _mimic(self, axis: Element, coupling: Coupling) -> None:
        other, factor, offset = mimic_of(coupling.counted_from(self.zeros), self.name, "SDF")
        leader, tag = self.axes[other]
        mimic = inside(axis, "mimic", joint=self.names[leader.name], axis=tag)
        inside(mimic, "multiplier", factor)
        inside(mimic, "offset", offset)
        inside(mimic, "reference", 0)


_TAGS = ("axis", "axis2")
