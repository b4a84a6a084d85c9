"""Write the serial equivalent of a robot: its transmissions' joints driven, its linkages left out,
with the efforts, speeds and inertias that the motors have at the joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np

from symkin.errors import InputError
from symkin.files.outputs import check_output, write_output
from symkin.formats.graph_form import METRES
from symkin.formats.mjcf_text import mjcf_text
from symkin.formats.serial_form import Drive, serial_form
from symkin.formats.urdf_text import urdf_text
from symkin.model.mechanism import Mechanism
from symkin.model.motor import motor_of
from symkin.transmissions.found import Group, group_with
from symkin.transmissions.transmission_result import Transmission

_LONGER = 3
"""Coordinates beyond the freedoms that a way is looked for with."""
_WRITERS = {".urdf": urdf_text, ".xml": mjcf_text}


def write_serial(
    mechanism: Mechanism, transmissions: Sequence[Transmission], path: Path | str
) -> tuple[str, ...]:
    """Write the serial equivalent of a robot as URDF or MJCF, by the path's suffix; what its
    numbers mean is told in the file, and returned.

    The joints' ranges are where each of them ends; `effort` and `velocity` are half the sides of
    the largest box (by volume) that lies within the polytopes of all sampled configurations, so
    that all joints may have theirs at once; the armature is the reflected inertia at the reference.
    What is not told of the motors is left out. Raises InputError for another suffix, for limits
    without 0 within and for joints that cannot move, MechanismError for a robot whose other parts
    hang on what is left out.
    """
    output = Path(path)
    check_output(output, tuple(_WRITERS), "serial", "")
    drives, notes, inside = dict[str, Drive](), list[str](), set[str]()
    for transmission in transmissions:
        found, of_it = drives_of(transmission)
        drives |= found
        notes += of_it
        group = group_with(mechanism, [*transmission.motors, *transmission.joints])
        _refuse_too_long(transmission, group)
        for element in (element for edge in group.own for element in edge.elements):
            inside |= {element.path, element.name}
    serial, told = serial_form(mechanism, inside, drives), "".join(f"; {note}" for note in notes)
    write_output(output, _WRITERS[output.suffix.lower()](serial, told))
    return tuple(notes)


def _refuse_too_long(transmission: Transmission, group: Group) -> None:
    """Raise InputError where the way to a link that carries more of the robot has more joints than
    the linkage has freedoms: some follow from others, and no tree of driven joints does that.
    """
    free = transmission.linkage.mobility
    for link in group.carriers:
        way = group.way_to(link, free + _LONGER)
        if way is not None and len(way) > free:
            raise InputError(
                f"{transmission.name}: no serial robot stands for this linkage: the way to "
                f"{link!r}, which carries more of the robot, is by {', '.join(way)}, of which the "
                f"linkage leaves {free} free of each other; its map is written by --format"
            )


def drives_of(transmission: Transmission) -> tuple[dict[str, Drive], list[str]]:
    """Find what drives each joint of a transmission, in SI units, and what is to be told of it."""
    linkage, data, survey = transmission.linkage, transmission.data, transmission.survey
    metres = METRES[linkage.mechanism.length_unit]
    motors, joints = (
        np.array([c.unit(metres) for c in linkage.coordinates_of(names)])
        for names in (linkage.motors, linkage.joints)
    )
    inverse = survey.states.inverse_jacobian * motors[:, None] / joints
    jacobian = survey.states.jacobian * joints[:, None] / motors
    inertia = np.einsum("kmi,m,kmj->kij", inverse, data.inertias, inverse)
    efforts = largest_box(jacobian.transpose(0, 2, 1), data.torque_limits, "torque_limits")
    speeds = largest_box(inverse, data.speed_limits, "speed_limits")
    drives, notes = {}, list[str]()
    for i, name in enumerate(linkage.joints):
        low, high = (float(end.value) * joints[i] for end in survey.ends[i])
        own = inertia[:, i, i]
        if not low < high:
            raise InputError(
                f"{name}: within the limits of its linkage it has one value alone, {low:.6g}, so "
                f"that nothing drives it; give other ranges or another start"
            )
        notes.append(f"range of {name}: from {survey.ends[i][0].by} to {survey.ends[i][1].by}")
        effort = None if "torque_limits" in data.untold else [-efforts[i], efforts[i]]
        speed = None if "speed_limits" in data.untold else float(speeds[i])
        armature = None if "inertia" in data.untold else float(own[0])
        drives[name] = Drive((low, high), motor_of(effort, speed, armature))
        if armature is not None:
            others = np.abs(np.delete(inertia[:, i], i, axis=1)).max(initial=0.0)
            notes.append(
                f"armature of {name}: {own[0]:.4g} at the reference, {own.min():.4g} to "
                f"{own.max():.4g} over the range; products with other joints, up to {others:.4g}, "
                f"are left out"
            )
    notes.append(
        f"effort and velocity of {', '.join(linkage.joints)}: what all of them may have at once at "
        f"each of {len(inertia)} configurations; each has its own range, of which not every set is "
        f"reached"
    )
    if data.untold:
        words = ", ".join(word.replace("_", " ") for word in data.untold)
        notes.append(f"not told of the motors, and left out or 1 here: {words}")
    return drives, notes


def largest_box(effects: np.ndarray, limits: np.ndarray, what: str) -> np.ndarray:
    """Half the sides b (n,) of the box |x_i| <= b_i of the largest volume with low <= A x <= high
    for all A (k, m, n) of `effects`, pairs of `limits` (m, 2). Raises InputError where 0 is not
    within the limits.
    """
    bounds = np.minimum(-limits[:, 0], limits[:, 1])
    if not (bounds > 0.0).all():
        raise InputError(f"{what}: 0 must be within the limits of each motor")
    rows = (np.abs(effects) / bounds[:, None]).reshape(-1, effects.shape[-1])
    box = ca.SX.sym("b", rows.shape[1])
    problem = {"x": box, "f": -ca.sum1(ca.log(box)), "g": ca.mtimes(ca.DM(rows), box)}
    quiet = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-12}}
    begin = 0.5 / (rows.max(axis=0) * rows.shape[1])
    found = ca.nlpsol("box", "ipopt", problem, quiet)(x0=begin, lbx=0.0, ubg=1.0)
    sides = np.asarray(found["x"]).ravel()
    # rounding of the search leaves no row beyond its bound
    return sides / (rows @ sides).max()
