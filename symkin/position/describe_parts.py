"""Joints, vectors and screws as `symkin show` writes them."""

from __future__ import annotations

import numpy as np

from symkin.closure.closure import Closure
from symkin.model.joint import Joint
from symkin.model.mechanism import Mechanism
from symkin.position.mobility_result import Mobility


def joint_text(mechanism: Mechanism, joint: Joint) -> str:
    """A joint in a line: type, name, place, axes, drive."""
    place = f"at {vector_text(joint.point)}" if joint.form.has_point else ""
    axis = f"along {vector_text(joint.axis)}" if joint.axis else ""
    second = f"then {vector_text(joint.axis2)}" if joint.axis2 else ""
    pitch = f"pitch {joint.pitch:g} {mechanism.length_unit} a turn" if joint.type == "H" else ""
    drive = "actuated" if joint.actuated else ""
    return " ".join(
        part for part in (joint.type, joint.name, place, axis, second, pitch, drive) if part
    )


def heading(mechanism: Mechanism, kind: str) -> str:
    """Name and title, what kind of mechanism it is, source, units and size."""
    lines = [mechanism.name + (f": {mechanism.title}" if mechanism.title else ""), kind]
    if mechanism.source:
        lines.append(f"source: {mechanism.source}")
    size = f"{mechanism.characteristic_length:.6g}"
    return "\n".join(
        [
            *lines,
            f"units: {mechanism.length_unit}, {mechanism.angle_unit}; size (largest distance of "
            f"joint points): {size}",
        ]
    )


def coordinates_text(closure: Closure) -> list[str]:
    """The closure's coordinates by their roles; poses only where there are any."""
    roles = (
        ("actuated", "q, actuated"),
        ("passive", "x, passive"),
        ("body", "x, poses of floating links"),
        ("pose", "X, pose"),
    )
    lines = ["Closure F(q, x, X, p) = 0"]
    for role, text in roles:
        coordinates = closure.role(role)
        if coordinates or role in ("actuated", "passive"):
            names = ", ".join(c.name for c in coordinates) or "none"
            lines.append(f"  {text} ({sum(c.freedom for c in coordinates)}): {names}")
    return lines


def ranks_text(found: Mobility, rows: str) -> list[str]:
    """Rank, mobility and redundant constraints at generic closed configurations; `rows` is what the
    closure's rows are called.
    """
    alone = found.generic_rank != found.rank.value or (found.infinitesimal and not found.mobility)
    where = "the reference" if alone else "generic closed configurations"
    less = f" - {found.infinitesimal} of first order alone" if found.infinitesimal else ""
    return [
        f"  {rows} {found.rows}, rank at {where} {found.rank.value}, freedoms of the coordinates "
        f"{found.freedoms}",
        f"  mobility = {found.freedoms} - {found.rank.value}{less} = {found.mobility}   "
        f"(Gruebler-Kutzbach, geometry and idle freedoms unseen: "
        f"{found.gruebler})",
        f"  redundant constraints: {found.redundant}{_whose(found)}",
    ]


def _whose(found: Mobility) -> str:
    """Why the count is not what rows and rank leave."""
    if found.redundant == found.implied_rows:
        return ""
    return ", of the loops in space; the rows are those of the declared motion"


def where_text(found: Mobility) -> str:
    """Where screws are those of."""
    return (
        "the reference configuration"
        if found.at_reference
        else "a configuration near the reference"
    )


def rows_text(title: str, rows: np.ndarray) -> list[str]:
    """Screws, a line each, under a title."""
    if len(rows) == 0:
        return [f"{title}: none"]
    if len(rows) == 6:
        return [f"{title}: all"]
    return [f"{title}:"] + [f"    ({_plain(row[:3])}; {_plain(row[3:])})" for row in rows]


def _plain(values: np.ndarray) -> str:
    return ", ".join(f"{0.0 if abs(v) < 5e-6 else v:.5g}" for v in values)


def vector_text(values: object) -> str:
    """A vector to six digits, rounding noise as 0."""
    return (
        "("
        + ", ".join(f"{0.0 if abs(v) < 1e-12 else v:.6g}" for v in np.asarray(values, dtype=float))
        + ")"
    )
