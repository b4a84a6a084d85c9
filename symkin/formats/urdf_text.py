"""Write a mechanism as URDF: a tree at the configuration where all joints are 0, and its loops as
<loop> of URDF+ or in YAML beside it.

Frames of links are parallel to the base's where all joints are 0. Couplings are `mimic`. The text
<symkin:joints> tells at which values the loops are closed, and which joints are parts of one.
Masses are plain: they have no meaning for the kinematics.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.formats.couplings import mimic_of
from symkin.formats.naming import fresh_name
from symkin.formats.parts import JOINTS_TAG, NAMESPACE, Parts, Whole, parts_text
from symkin.formats.robot import frame_along, moved_along
from symkin.formats.written_tree import (
    INERTIA,
    MASS,
    Form,
    WrittenTree,
    least_effort,
    written_tree,
)
from symkin.formats.xml_written import Element, document, element, inside
from symkin.model.graph import Coupling, LinkJoint
from symkin.model.joint import BASE, Joint
from symkin.model.joint_forms import JointType
from symkin.model.mechanism import Mechanism
from symkin.model.motor import Motor
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import euler_from_quaternion

_CARRY: frozenset[JointType] = frozenset({"R", "P"})
_FORMS = {
    "loop": Form("URDF", carry=_CARRY, close=frozenset({"S", "R", "P", "C", "weld"})),
    "yaml": Form("URDF", carry=_CARRY, close=frozenset({"S", "weld"})),
}
_CLOSURES = {"S": "ball", "R": "revolute", "P": "prismatic", "C": "cylindrical", "weld": "fixed"}
_YAML_CLOSURES = {"S": "3d", "weld": "6d"}
_UNBOUNDED = 1e16
"""What a joint has without a range, efforts or speeds, for the format wants them."""


def urdf_text(mechanism: Mechanism, told: str = "") -> str:
    """The URDF file of a mechanism, with its loops; `told`: more for the comment at the head.
    Raises MechanismError for what URDF cannot hold.
    """
    return _Text(written_tree(mechanism, _FORMS["loop"])).document(told)


def urdf_and_yaml(mechanism: Mechanism) -> tuple[str, str]:
    """The URDF file of a mechanism, and the YAML file with its loops. Raises MechanismError for
    what they cannot hold.
    """
    text = _Text(written_tree(mechanism, _FORMS["yaml"]), beside=True)
    return text.document(), text.yaml()


class _Text:
    """The elements of the file."""

    def __init__(self, tree: WrittenTree, *, beside: bool = False) -> None:
        self.tree, self.beside = tree, beside
        self.joints = tree.one_by_one()
        self.moved = zero_displacements(self.joints)
        self.zero = {BASE: Pose.identity()}
        for entry in self.joints:
            carrier, link = entry.links
            place = self.moved[carrier].apply(np.array(entry.joint.point))
            self.zero[link] = Pose(place, Pose.identity().quaternion)
        self.reference = {
            link: self.moved[link].inverse() @ frame for link, frame in self.zero.items()
        }
        self.closing: list[tuple[str, str, str]] = []

    def document(self, told: str = "") -> str:
        graph, parts = self.tree.graph, self.tree.parts
        root = element("robot", name=graph.name)
        root.set("xmlns:symkin", NAMESPACE)
        for link in self.zero:
            self._link(root, link)
        couplings = {c.joint: c for c in self.tree.couplings}
        for entry in self.joints:
            self._joint(root, entry, couplings.get(entry.joint.name))
        for closure in self.tree.closures:
            if self.beside:
                parts = self._frames(root, closure, parts)
            else:
                self._loop(root, closure)
        for joint in self.tree.joints:
            if joint.actuated:
                self._transmission(root, joint)
        reference = {joint.name: joint.zero for joint in self.tree.joints if joint.zero}
        inside(root, JOINTS_TAG, parts_text(replace(parts, reference=reference)))
        return document(root, graph.name, told)

    def yaml(self) -> str:
        """The loops, once the document is made."""
        lines = {
            "closed_loop": [ends for _, *ends in self.closing],
            "type": [kind for kind, *_ in self.closing],
            "name_mot": [joint.name for joint in self.tree.joints if joint.actuated],
        }
        return "".join(
            f"{key}: {json.dumps(value, ensure_ascii=False)}\n" for key, value in lines.items()
        )

    # --- the tree ---------------------------------------------------------------------------------

    def _link(self, root: Element, name: str) -> None:
        link = inside(root, "link", name=name)
        if name != BASE:
            inertial = inside(link, "inertial")
            inside(inertial, "mass", value=MASS)
            inside(inertial, "inertia", ixx=INERTIA, ixy=0, ixz=0, iyy=INERTIA, iyz=0, izz=INERTIA)

    def _joint(self, root: Element, entry: LinkJoint, coupling: Coupling | None) -> None:
        joint, (carrier, link) = entry.joint, entry.links
        turns = "continuous" if joint.limits is None else "revolute"
        kind = "prismatic" if joint.type == "P" else turns
        made = inside(root, "joint", name=joint.name, type_=kind)
        inside(made, "parent", link=carrier)
        inside(made, "child", link=link)
        at = self.zero[carrier].inverse() @ self.zero[link]
        inside(made, "origin", xyz=at.position, rpy=[0, 0, 0])
        inside(made, "axis", xyz=self.moved[carrier].turn(np.array(joint.axis)))
        motor = joint.motor or Motor()
        ends = dict(zip(("lower", "upper"), joint.limits or (-_UNBOUNDED, _UNBOUNDED), strict=True))
        if kind == "continuous":
            ends = {}
        if ends or motor.effort or motor.speed:
            inside(
                made,
                "limit",
                **ends,
                effort=least_effort(motor) if motor.effort else _UNBOUNDED,
                velocity=motor.speed or _UNBOUNDED,
            )
        if coupling is not None:
            self._mimic(made, coupling)

    def _mimic(self, made: Element, coupling: Coupling) -> None:
        other, factor, offset = mimic_of(coupling, self.tree.graph.name, "URDF")
        inside(made, "mimic", joint=other, multiplier=factor, offset=offset)

    def _transmission(self, root: Element, joint: Joint) -> None:
        made = inside(root, "transmission", name=f"{joint.name}.transmission")
        inside(made, "type", "transmission_interface/SimpleTransmission")
        inside(
            inside(made, "joint", name=joint.name),
            "hardwareInterface",
            "hardware_interface/PositionJointInterface",
        )
        inside(made, "actuator", name=f"{joint.name}.motor")

    # --- loops ------------------------------------------------------------------------------------

    def _frames_on_links(self, closure: LinkJoint) -> list[Pose]:
        ends = zip(closure.links, closing_frames(closure.joint), strict=True)
        found = [self.reference[link].inverse() @ frame for link, frame in ends]
        if closure.joint.type == "S":  # it has no direction
            return [Pose(f.position, Pose.identity().quaternion) for f in found]
        return found

    def _loop(self, root: Element, closure: LinkJoint) -> None:
        """A closing joint of URDF+, about or along the z axis of both frames."""
        joint = closure.joint
        made = inside(root, "loop", name=joint.name, type_=_CLOSURES[joint.type])
        for tag, link, frame in zip(
            ("predecessor", "successor"), closure.links, self._frames_on_links(closure), strict=True
        ):
            inside(inside(made, tag, link=link), "origin", **xyz_rpy(frame))
        if joint.axis is not None:
            inside(made, "axis", xyz=[0, 0, 1])

    def _frames(self, root: Element, closure: LinkJoint, parts: Parts) -> Parts:
        """Links on fixed joints, which the YAML file names; the reader numbers the closures."""
        joint, names = closure.joint, []
        for k, (link, frame) in enumerate(
            zip(closure.links, self._frames_on_links(closure), strict=True), start=1
        ):
            name = f"{joint.name}.{k}.frame"
            self._link(root, name)
            made = inside(root, "joint", name=f"{name}.fixed", type_="fixed")
            inside(made, "parent", link=link)
            inside(made, "child", link=name)
            inside(made, "origin", **xyz_rpy(frame))
            names.append(name)
        self.closing.append((_YAML_CLOSURES[joint.type], names[0], names[1]))
        own = fresh_name(f"loop{len(self.closing)}", {j.name for j in self.tree.joints})
        if any(joint.name in whole.parts for whole in parts.wholes):
            return parts.renamed(joint.name, own)
        return parts.with_whole(Whole(joint.name, joint.type, (own,)))


# --- frames ---------------------------------------------------------------------------------------


def displacement(joint: Joint, value: float) -> Pose:
    """How far a joint of one coordinate moves its second link from the reference to a value."""
    frame = Pose(np.array(joint.point), Pose.identity().quaternion)
    return frame @ moved_along(joint, value - joint.zero) @ frame.inverse()


def zero_displacements(joints: Sequence[LinkJoint]) -> dict[str, Pose]:
    """The displacements of all links of a tree from the reference to the configuration where its
    joints are 0.
    """
    found = {BASE: Pose.identity()}
    for entry in joints:
        carrier, link = entry.links
        moved = found[carrier]
        found[link] = moved @ displacement(entry.joint, 0.0) if entry.joint.zero else moved
    return found


def closing_frames(joint: Joint) -> tuple[Pose, Pose]:
    """The frames of a closing joint on its two links, in the base frame at the reference: z along
    its axis, which coincide at 0.
    """
    turn = Pose.identity() if joint.axis is None else frame_along(joint.axis)
    frame = Pose(np.array(joint.point), turn.quaternion)
    return frame, displacement(joint, 2.0 * joint.zero) @ frame if joint.zero else frame


def xyz_rpy(pose: Pose) -> dict[str, list[float] | None]:
    """The attributes of an origin; angles about the fixed axes x, y, z, and none where it is not
    turned.
    """
    angles = [float(v) + 0.0 for v in euler_from_quaternion(pose.quaternion, "xyz")]
    return {"xyz": [float(v) + 0.0 for v in pose.position], "rpy": angles if any(angles) else None}
