"""Write a mechanism as MJCF, the XML of MuJoCo: bodies whose frames are parallel to the base's at
the reference, equality constraints, and a keyframe there.

Joint values are the mechanism's own in metres and radians (`ref`). Loops are closed by `connect`
and `weld`, couplings are `joint` equalities, or fixed tendons where a joint follows several. Masses
are plain: they have no meaning for the kinematics.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np

from symkin.errors import MechanismError
from symkin.formats.naming import fresh_name
from symkin.formats.parts import KEY, parts_text
from symkin.formats.written_tree import INERTIA, MASS, Carried, Form, WrittenTree, written_tree
from symkin.formats.xml_written import Element, document, element, inside, number
from symkin.model.graph import Coupling, LinkJoint
from symkin.model.graph_checks import links_of
from symkin.model.joint import BASE, Joint
from symkin.model.mechanism import Mechanism
from symkin.model.motor import Motor

FORM = Form("MJCF", carry=frozenset({"R", "P", "S"}), close=frozenset({"S", "weld"}))
_TYPES = {"R": "hinge", "P": "slide", "S": "ball"}
_WORLD = "world"

_BAR = {"type": "capsule", "contype": "0", "conaffinity": "0", "mass": "0"}
"""Bars are seen and touch nothing."""
_THICKNESS, _SHORTEST = 0.01, 1e-3
"""Of the size: radius of bars, and length of those that are left out."""


def mjcf_text(mechanism: Mechanism, told: str = "") -> str:
    """The MJCF file of a mechanism; `told`: more for the comment at the head. Raises MechanismError
    for what MJCF cannot hold.
    """
    return _Text(written_tree(mechanism, FORM)).document(told)


class _Text:
    """The elements of the file."""

    def __init__(self, tree: WrittenTree) -> None:
        self.tree = tree
        if _WORLD in (*links_of(tree.graph), *(entry.link for entry in tree.carried)):
            raise MechanismError(
                f"{tree.graph.name}: a link is named {_WORLD!r}, which is the base of MJCF; rename "
                f"it"
            )
        self.places: dict[str, np.ndarray] = {BASE: np.zeros(3)}
        self.bodies: dict[str, Element] = {}
        self.values = {joint.name: joint.zero for joint in tree.joints}

    def document(self, told: str) -> str:
        graph = self.tree.graph
        root = element("mujoco", model=graph.name)
        inside(root, "compiler", angle="radian", autolimits=True)
        bars = inside(inside(root, "default"), "geom")
        for key, value in _BAR.items():
            bars.set(key, value)
        bars.set("size", number(_THICKNESS * graph.characteristic_length))
        inside(inside(root, "custom"), "text", name=KEY, data=parts_text(self.tree.parts))
        self.bodies[BASE] = inside(root, "worldbody")
        for entry in self.tree.carried:
            self._body(entry)
        self._bars()
        self._sites()
        self._equality(root)
        self._actuator(root)
        balls = [1.0, 0.0, 0.0, 0.0]
        values = (balls if j.type == "S" else [j.zero] for j in self._joints_in_order())
        inside(
            inside(root, "keyframe"), "key", name="reference", qpos=[*chain.from_iterable(values)]
        )
        return document(root, graph.name, told)

    # --- bodies -----------------------------------------------------------------------------------

    def _body(self, entry: Carried) -> None:
        """A body with its joints, at the first of them."""
        place = self.places[entry.link] = np.array(entry.joints[0].point)
        body = self.bodies[entry.link] = inside(
            self.bodies[entry.carrier],
            "body",
            name=entry.link,
            pos=place - self.places[entry.carrier],
        )
        inside(body, "inertial", pos=[0, 0, 0], mass=MASS, diaginertia=[INERTIA] * 3)
        for joint in entry.joints:
            away, motor = np.array(joint.point) - place, joint.motor or Motor()
            inside(
                body,
                "joint",
                name=joint.name,
                type_=_TYPES[joint.type],
                pos=away if away.any() else None,
                axis=joint.axis,
                ref=joint.zero or None,
                range_=joint.limits,
                armature=motor.armature,
                actuatorfrcrange=motor.effort,
            )

    def _bars(self) -> None:
        """What viewers show of a body: bars from its origin to the joints that it carries."""
        ends = {
            link: [self.places[e.link] for e in self.tree.carried if e.carrier == link]
            for link in self.bodies
            if link != BASE
        }
        for entry in self.tree.closures:
            for link in {*entry.links} - {BASE}:
                ends[link].append(np.array(entry.joint.point))
        size = self.tree.graph.characteristic_length
        for link, points in ends.items():
            for away in (point - self.places[link] for point in points):
                if float(np.linalg.norm(away)) > _SHORTEST * size:
                    inside(self.bodies[link], "geom", fromto=[0.0, 0.0, 0.0, *away])

    def _sites(self) -> None:
        """The platform frame and points of links, which others may measure at."""
        graph, taken = self.tree.graph, set[str]()
        for point in graph.link_points:
            taken.add(point.name)
            away = np.array(point.point) - self.places[point.link]
            inside(self.bodies[point.link], "site", name=point.name, pos=away)
        link = graph.platform_link
        if link is not None:
            name = fresh_name("platform", taken)
            away = np.array(graph.platform_position) - self.places[link]
            inside(self.bodies[link], "site", name=name, pos=away, quat=graph.platform_quaternion)

    def _joints_in_order(self) -> Sequence[Joint]:
        """The joints as the compiler counts them: those of a body, then those of the bodies within
        it.
        """
        joints = {joint.name: joint for joint in self.tree.joints}
        return [joints[e.attrib["name"]] for e in self.bodies[BASE].iter("joint")]

    # --- the rest ---------------------------------------------------------------------------------

    def _equality(self, root: Element) -> None:
        closures, couplings = self.tree.closures, self.tree.couplings
        if not closures and not couplings:
            return
        tendon = element("tendon")
        section = element("equality")
        for entry in closures:
            self._closure(section, entry)
        taken = {entry.joint.name for entry in closures}
        for coupling in couplings:
            name = fresh_name(f"coupling of {coupling.joint}", taken)
            self._coupling(section, tendon, coupling, name)
        if len(tendon):
            root.append(tendon)
        root.append(section)

    def _closure(self, section: Element, entry: LinkJoint) -> None:
        """A point or a frame that two bodies have in common."""
        joint = entry.joint
        first, second = (_WORLD if link == BASE else link for link in entry.links)
        # of a weld the anchor is on the second body
        tag, on = ("connect", 0) if joint.type == "S" else ("weld", 1)
        anchor = np.array(joint.point) - self.places[entry.links[on]]
        inside(section, tag, name=joint.name, body1=first, body2=second, anchor=anchor)

    def _coupling(self, section: Element, tendon: Element, coupling: Coupling, name: str) -> None:
        """y - y0 = c0 + c1 (x - x0) + ...; of several joints the length of a tendon, y - sum f x,
        is held.
        """
        coupling = coupling.counted_from(self.values)
        if coupling.polynomial is not None or len(coupling.terms) == 1:
            (other,) = coupling.names
            powers = coupling.polynomial or (coupling.offset, coupling.terms[0][1])
            inside(
                section,
                "joint",
                name=name,
                joint1=coupling.joint,
                joint2=other,
                polycoef=[*powers, *[0.0] * (5 - len(powers))],
            )
            return
        fixed = inside(tendon, "fixed", name=name)
        for joint, factor in ((coupling.joint, 1.0), *((n, -f) for n, f in coupling.terms)):
            inside(fixed, "joint", joint=joint, coef=factor)
        powers = [coupling.offset, 0, 0, 0, 0]
        inside(section, "tendon", name=name, tendon1=name, polycoef=powers)

    def _actuator(self, root: Element) -> None:
        driven = [joint for joint in self._joints_in_order() if joint.actuated]
        if driven:
            section = inside(root, "actuator")
            for joint in driven:
                efforts = joint.motor and joint.motor.effort
                inside(section, "motor", name=joint.name, joint=joint.name, ctrlrange=efforts)
