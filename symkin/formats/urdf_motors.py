"""Which joints of a URDF are driven, what is told of their motors, and which follow others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symkin.formats.gepetto_yaml import LoopsBeside
from symkin.formats.graph_reader import ONE_COORDINATE
from symkin.formats.robot import RobotJoint
from symkin.formats.xml_text import Element
from symkin.model.graph import Coupling
from symkin.model.motor import Motor, motor_of
from symkin.text import meant


def told_motors(root: Element) -> dict[str, Motor | None]:
    """What <limit> tells of the motor at each joint, and transmissions of its rotor and gears
    (Drake's elements, else mechanicalReduction).
    """
    inertias = {}
    for made in root.all("transmission"):
        for motor, joint in zip(made.all("actuator"), made.all("joint"), strict=False):
            rotor = motor.one("drake:rotor_inertia")
            gear = motor.one("drake:gear_ratio")
            ratio = (
                motor.child_number("mechanicalReduction", 1.0)
                if gear is None
                else gear.number("value")
            )
            if rotor is not None:
                inertias[joint.attributes.get("name", "")] = rotor.number("value") * ratio**2
    found = {}
    for element in root.all("joint", "drake:joint"):
        name, limit = element.attribute("name"), element.one("limit")
        effort, speed = (
            0.0 if limit is None else limit.number(key, 0.0, infinite=True)
            for key in ("effort", "velocity")
        )
        found[name] = motor_of((-effort, effort), speed, inertias.get(name))
    return found


def mimics(
    elements: Sequence[Element], joints: Sequence[RobotJoint]
) -> Iterator[tuple[Coupling, str]]:
    """joint = multiplier x other + offset, for every <mimic> of a joint that moves, and its
    place.
    """
    made = {joint.name: joint for joint in joints}
    for element in elements:
        mimic = element.one("mimic")
        if mimic is None:
            continue
        name, other = element.attribute("name"), mimic.attribute("joint")
        if other == name:
            raise mimic.error(f"the joint {name!r} mimics itself; name another joint")
        if other not in made:
            raise mimic.error(
                f"the joint {other!r} that {name!r} mimics is unknown{meant(other, made)}"
            )
        if name in made and made[name].type == "weld":
            continue
        wrong = next(
            (n for n in (name, other) if n not in made or made[n].type not in ONE_COORDINATE), None
        )
        if wrong is not None:
            raise mimic.error(
                f"{wrong!r} has no one coordinate; joints that mimic are revolute, continuous or "
                f"prismatic"
            )
        factor, offset = mimic.number("multiplier", 1.0), mimic.number("offset", 0.0)
        yield Coupling(name, {other: factor}, offset), mimic.where


def _is_passive(joint: Element) -> bool:
    """Whether a transmission's joint has an interface that only reads it."""
    interfaces = [e.text for e in joint.all("hardwareInterface")]
    return bool(interfaces) and all(
        "PassiveJoint" in text or "JointStateInterface" in text for text in interfaces
    )


def driven_names(root: Element, beside: LoopsBeside) -> tuple[frozenset[str], str]:
    """The driven joints that are told, and where."""
    if beside.motors:
        return frozenset(beside.motors), str(beside.file)
    driven = [
        joint
        for t in root.all("transmission")
        for joint in t.all("joint")
        if not _is_passive(joint)
    ]
    controlled = [
        j for c in root.all("ros2_control") for j in c.all("joint") if j.all("command_interface")
    ]
    named = frozenset(e.attributes.get("name", e.text).strip() for e in (driven or controlled)) - {
        ""
    }
    if named:
        return named, "transmissions" if driven else "controllers"
    elements = root.all("joint", "drake:joint")
    return frozenset(
        e.attribute("name")
        for e in elements
        if e.attributes.get("independent", "").lower() == "true"
    ), "joints"
