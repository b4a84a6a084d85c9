"""Machines of `made_robots` in MJCF, URDF and SDF; loops in URDF in the form of its writing that is
asked for.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from helpers.made_robots import GROUND, Machine, Part, Pin

POINT_FORMS = ("closing", "constraint", "drake", "yaml", "loop_joint")
HINGE_FORMS = ("loop_joint", "loop", "constraint")
WELD_FORMS = ("loop_joint", "yaml", "loop")


def write(machine: Machine, suffix: str, folder: Path, form: int = 0) -> Path:
    """The machine's file in a format; `form` counts through the ways of writing loops in URDF, and
    odd ones tell every second joint of SDF from its other link.
    """
    path = folder / f"{machine.name}.{suffix}"
    if suffix == "urdf":
        text, beside = urdf(machine, form)
        if beside:
            path.with_suffix(".yaml").write_text(beside, encoding="utf-8")
    else:
        text = mjcf(machine) if suffix == "xml" else sdf(machine, backward=form % 2 == 1)
    path.write_text(text, encoding="utf-8")
    return path


def words(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(number) + 0.0) for number in numbers)


def _rpy(pose: np.ndarray) -> str:
    return words(Rotation.from_matrix(pose[:3, :3]).as_euler("xyz"))


def _wxyz(pose: np.ndarray) -> str:
    x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat()
    return words((w, x, y, z))


# --- MJCF -----------------------------------------------------------------------------------------


def mjcf(machine: Machine) -> str:
    """Hinges two by two for universal joints, a hinge and a slide for screws; two connects for a
    hinge that closes a loop.
    """
    bodies = "".join(_body(machine, part) for part in machine.parts if part.parent == GROUND)
    sites = "".join(_site(machine, pin, GROUND) for pin in machine.pins)
    equalities = "".join(_equality(pin) for pin in machine.pins)
    equalities += "".join(
        f'<joint joint1="q_{f.part}" joint2="q_{f.leader}" polycoef="0 {f.factor!r} 0 0 0"/>'
        for f in machine.followers
    )
    equalities += "".join(
        f'<joint joint1="{p.joint_name}_advance" joint2="{p.joint_name}" polycoef="0 '
        f'{p.pitch / (2 * np.pi)!r} 0 0 0"/>'
        for p in machine.parts
        if p.joint == "H"
    )
    motors = "".join(f'<motor joint="{name}"/>' for name in machine.motors)
    return (
        f'<mujoco model="{machine.name}"><compiler '
        f'angle="radian"/><worldbody>{sites}{bodies}</worldbody><equality>{equalities}'
        f"</equality><actuator>{motors}</actuator></mujoco>\n"
    )


def _body(machine: Machine, part: Part) -> str:
    pose = machine.in_parent(part)
    inside = "".join(_body(machine, other) for other in machine.parts if other.parent == part.name)
    sites = "".join(_site(machine, pin, part.name) for pin in machine.pins)
    return (
        f'<body name="{part.name}" pos="{words(pose[:3, 3])}" '
        f'quat="{_wxyz(pose)}">{_mjcf_joint(machine, part)}'
        f'<geom size="0.01"/>{sites}{inside}</body>\n'
    )


def _mjcf_joint(machine: Machine, part: Part) -> str:
    name, axis = part.joint_name, words(machine.direction(part.name, part.axis))
    limits = "" if part.limits is None else f' range="{words(part.limits)}"'
    hinge = f'<joint name="{{}}" type="hinge" axis="{{}}"{limits}/>'
    match part.joint:
        case "R":
            return hinge.format(name, axis)
        case "U":
            return hinge.format(f"{name}.1", "1 0 0") + hinge.format(f"{name}.2", "0 1 0")
        case "S":
            return f'<joint name="{name}" type="ball"/>'
        case "P":
            return f'<joint name="{name}" type="slide" axis="{axis}"{limits}/>'
        case "H":
            return (
                hinge.format(name, axis)
                + f'<joint name="{name}_advance" type="slide" axis="{axis}"/>'
            )
        case _:
            return ""


def _site(machine: Machine, pin: Pin, part: str) -> str:
    """The frames of a closure on one of its parts: of a hinge one more along its axis."""
    if part not in pin.parts:
        return ""
    places = [("", np.array(pin.at))]
    if pin.kind == "R":
        places.append(("_along", np.array(pin.at) + 0.1 * np.array(pin.axis)))
    found = ""
    for ending, at in places:
        pose = machine.frame(part, at)
        found += (
            f'<site name="{pin.name}_{part}{ending}" pos="{words(pose[:3, 3])}" '
            f'quat="{_wxyz(pose)}"/>'
        )
    return found


def _equality(pin: Pin) -> str:
    first, second = (f"{pin.name}_{part}" for part in pin.parts)
    if pin.kind == "weld":
        return f'<weld name="{pin.name}" site1="{first}" site2="{second}"/>'
    found = f'<connect name="{pin.name}" site1="{first}" site2="{second}"/>'
    if pin.kind == "R":
        found += f'<connect name="{pin.name}_along" site1="{first}_along" site2="{second}_along"/>'
    return found


# --- URDF -----------------------------------------------------------------------------------------

_URDF_TYPES = {
    "R": "continuous",
    "P": "prismatic",
    "H": "screw",
    "U": "universal",
    "S": "ball",
    "weld": "fixed",
}


def urdf(machine: Machine, form: int = 0) -> tuple[str, str]:
    """The URDF, and the YAML beside it where the form writes one."""
    links = "".join(f'<link name="{name}"/>\n' for name in machine.frames)
    joints = "".join(_urdf_joint(machine, part) for part in machine.parts)
    pairs: list[tuple[str, str, str]] = []
    loops = "".join(_urdf_pin(machine, pin, form + k, pairs) for k, pin in enumerate(machine.pins))
    motors = "".join(
        f'<transmission name="t_{name}"><joint name="{name}"/></transmission>'
        for name in machine.motors
    )
    beside = ""
    if pairs:
        beside = (
            f"closed_loop: {[list(pair[:2]) for pair in pairs]}\n"
            f"type: {[pair[2] for pair in pairs]}\n"
        )
    return f'<robot name="{machine.name}">\n{links}{joints}{loops}{motors}</robot>\n', beside


def _urdf_joint(machine: Machine, part: Part) -> str:
    kind = "revolute" if part.joint == "R" and part.limits else _URDF_TYPES[part.joint]
    more = ""
    if part.joint in ("R", "P", "H"):
        more += f'<axis xyz="{words(machine.direction(part.name, part.axis))}"/>'
    if part.joint == "H":
        more += f'<drake:screw_thread_pitch value="{part.pitch!r}"/>'
    if part.joint in ("R", "P") and part.limits:
        more += (
            f'<limit lower="{part.limits[0]!r}" upper="{part.limits[1]!r}" effort="1" '
            f'velocity="1"/>'
        )
    follower = next((f for f in machine.followers if f.part == part.name), None)
    if follower is not None:
        more += f'<mimic joint="q_{follower.leader}" multiplier="{follower.factor!r}"/>'
    return (
        f'<joint name="{part.joint_name}" type="{kind}"><parent link="{part.parent}"/><child '
        f'link="{part.name}"/>'
        f"<origin {_urdf_pose(machine.in_parent(part))}/>{more}</joint>\n"
    )


def _urdf_pose(pose: np.ndarray) -> str:
    return f'xyz="{words(pose[:3, 3])}" rpy="{_rpy(pose)}"'


def _urdf_pin(machine: Machine, pin: Pin, form: int, pairs: list[tuple[str, str, str]]) -> str:
    a, b = pin.parts
    at, bt = (_urdf_pose(machine.frame(part, pin.at)) for part in pin.parts)
    forms = {"S": POINT_FORMS, "R": HINGE_FORMS, "weld": WELD_FORMS}[pin.kind]
    kind = {"S": "spherical", "R": "revolute", "weld": "fixed"}[pin.kind]
    axis = f'<axis xyz="{words(pin.axis)}"/>' if pin.kind == "R" else ""
    match forms[form % len(forms)]:
        case "loop_joint":
            return (
                f'<loop_joint name="{pin.name}" type="{kind}">{axis}<link1 link="{a}" {at}/><link2 '
                f'link="{b}" {bt}/></loop_joint>\n'
            )
        case "loop":
            return (
                f'<loop name="{pin.name}" type="{kind}"><predecessor link="{a}"><origin '
                f'{at}/></predecessor><successor link="{b}">'
                f"<origin {bt}/></successor>{axis}</loop>\n"
            )
        case "constraint":
            axes = axis.replace("axis", "parent_axis") + axis.replace("axis", "child_axis")
            return (
                f'<constraint name="{pin.name}" type="{kind}"><parent link="{a}"/><parent_origin '
                f'{at}/><child link="{b}"/>'
                f"<child_origin {bt}/>{axes}</constraint>\n"
            )
        case "drake":
            points = [words(machine.frame(part, pin.at)[:3, 3]) for part in pin.parts]
            return (
                f"<drake:ball_constraint><drake:ball_constraint_body_A "
                f'name="{a}"/><drake:ball_constraint_p_AP value="{points[0]}"/>'
                f'<drake:ball_constraint_body_B name="{b}"/><drake:ball_constraint_p_BQ '
                f'value="{points[1]}"/></drake:ball_constraint>\n'
            )
        case word:
            stem = f"closing_{pin.name}" if word == "closing" else pin.name
            if word == "yaml":
                pairs.append((f"{stem}_1", f"{stem}_2", "3d" if pin.kind == "S" else "6d"))
            return "".join(
                f'<link name="{stem}_{k}"/><joint name="{stem}_{k}_frame" type="fixed"><parent '
                f'link="{part}"/><child link="{stem}_{k}"/>'
                f"<origin {pose}/></joint>\n"
                for k, (part, pose) in enumerate(((a, at), (b, bt)), start=1)
            )


# --- SDF ------------------------------------------------------------------------------------------

_SDF_TYPES = {
    "R": "revolute",
    "P": "prismatic",
    "H": "screw",
    "U": "universal",
    "S": "ball",
    "weld": "fixed",
}


def sdf(machine: Machine, *, backward: bool = False) -> str:
    """A graph of joints: nothing tells those that close loops from others; `backward` tells every
    second from the link that it carries.
    """
    links = "".join(
        f'<link name="{name}"><pose>{words(pose[:3, 3])} {_rpy(pose)}</pose></link>\n'
        for name, pose in machine.frames.items()
    )
    joints = "".join(
        _sdf_joint(machine, part, backward=backward and k % 2 == 0)
        for k, part in enumerate(machine.parts)
    )
    pins = "".join(
        f'<joint name="{pin.name}" '
        f'type="{_SDF_TYPES[pin.kind]}"><parent>{pin.parts[0]}</parent><child>{pin.parts[1]}</child>'
        f'<pose relative_to="__model__">{words(pin.at)} 0 0 0</pose>'
        + (f"<axis><xyz>{words(pin.axis)}</xyz></axis>" if pin.kind == "R" else "")
        + "</joint>\n"
        for pin in machine.pins
    )
    motors = "".join(
        f'<plugin name="m" filename="f"><joint_name>{name}</joint_name></plugin>'
        for name in machine.motors
    )
    return (
        f'<sdf version="1.11"><model name="{machine.name}">\n'
        f"{links}{joints}{pins}{motors}</model></sdf>\n"
    )


def _sdf_joint(machine: Machine, part: Part, *, backward: bool) -> str:
    follower = next((f for f in machine.followers if f.part == part.name), None)
    inner = (
        ""
        if part.limits is None
        else f"<limit><lower>{part.limits[0]!r}</lower><upper>{part.limits[1]!r}</upper></limit>"
    )
    if follower is not None:
        inner += (
            f"<mimic "
            f'joint="q_{follower.leader}"><multiplier>{follower.factor!r}</multiplier></mimic>'
        )
    more = f"<screw_thread_pitch>{part.pitch!r}</screw_thread_pitch>" if part.joint == "H" else ""
    axes = [
        machine.direction(part.name, axis)
        for axis in ((part.axis, part.axis2) if part.joint == "U" else (part.axis,))
    ]
    links = (part.parent, part.name)
    if backward:
        # the inverse of turns about a and then b is one about -b and then -a
        links, axes = links[::-1], [-axis for axis in axes[::-1]]
        more += f'<pose relative_to="{part.name}">0 0 0 0 0 0</pose>'
    if part.joint not in ("S", "weld"):
        more += f"<axis><xyz>{words(axes[0])}</xyz>{inner}</axis>"
    if part.joint == "U":
        more += f"<axis2><xyz>{words(axes[1])}</xyz></axis2>"
    return (
        f'<joint name="{part.joint_name}" '
        f'type="{_SDF_TYPES[part.joint]}"><parent>{links[0]}</parent><child>{links[1]}</child>'
        f"{more}</joint>\n"
    )
