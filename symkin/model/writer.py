"""Write mechanism files (TOML, `format = 1`)."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from types import SimpleNamespace
from typing import Any

import tomlkit

from symkin.model.description import Description
from symkin.model.dh import DHTable
from symkin.model.graph import Coupling
from symkin.model.keys import (
    COUPLING,
    DH_ROW,
    EXAMPLE,
    HEAD,
    JOINT,
    JOINT_LIMB,
    LINK_JOINT,
    LINK_ROD,
    PLATFORM,
    ROD,
    ROD_LIMB,
    shortest,
    write_table,
)
from symkin.model.limb import Limb, RodLimb


def mechanism_to_toml(mechanism: Description) -> str:
    """Write the file that describes the mechanism; reading it back gives an equal one."""
    unit = mechanism.angle_unit
    document = tomlkit.document()
    document["format"] = 1
    document.update(write_table(HEAD, mechanism, unit))
    if mechanism.dh is not None:
        document["dh"] = _dh(mechanism.dh, unit)
    elif mechanism.serial:
        document["tool"] = _frame(mechanism)
        joints = [write_table(JOINT, joint, unit) for _, joint in mechanism.joints]
        for joint in joints:
            joint.pop("actuated", None)  # which goes without saying
        document["joint"] = _tables(joints)
    else:
        _links(document, mechanism)
    if mechanism.example is not None:
        example = vars(mechanism.example)
        given = example["given"] and dict(example["given"])
        document["example"] = write_table(
            EXAMPLE, SimpleNamespace(**example | {"given": given}), unit
        )
    return tomlkit.dumps(document)


def _links(document: tomlkit.TOMLDocument, mechanism: Description) -> None:
    """Limbs, and joints and rods between links."""
    unit = mechanism.angle_unit
    if mechanism.platform_link is not None:
        document["platform"] = _frame(mechanism)
    joints = [
        SimpleNamespace(**vars(entry.joint), links=tuple(entry.links))
        for entry in mechanism.link_joints
    ]
    units = mechanism.units
    tables = {
        "joint": [write_table(LINK_JOINT, joint, unit) for joint in joints],
        "rod": [write_table(LINK_ROD, rod, unit) for rod in mechanism.link_rods],
        "limb": [_limb(limb, unit) for limb in mechanism.limbs],
        "coupling": [_coupling(coupling, units) for coupling in mechanism.couplings],
        "link": [
            {"name": link, "points": {point.name: list(point.point) for point in points}}
            for link, points in groupby(mechanism.link_points, key=lambda point: point.link)
        ],
    }
    for key, entries in tables.items():
        if entries:
            document[key] = _tables(entries)


def _frame(mechanism: Description) -> dict[str, Any]:
    frame = SimpleNamespace(
        link=mechanism.platform_link if mechanism.is_graph else None,
        position=tuple(mechanism.platform_position),
        quaternion=tuple(mechanism.platform_quaternion),
        motion=mechanism.motion,
    )
    return write_table(PLATFORM, frame, mechanism.angle_unit)


def _limb(limb: Limb | RodLimb, unit: str) -> dict[str, Any]:
    if isinstance(limb, RodLimb):
        return write_table(ROD_LIMB, limb, unit)
    parts = SimpleNamespace(
        name=limb.name,
        links=tuple(limb.links),
        joint=_tables([write_table(JOINT, joint, unit) for joint in limb.joints]),
        rod=_tables([write_table(ROD, rod, unit) for rod in limb.rods]) if limb.rods else None,
    )
    return write_table(JOINT_LIMB, parts, unit)


def _coupling(coupling: Coupling, units: Mapping[str, float]) -> dict[str, Any]:
    """Numbers in the file's units, as `Coupling.in_units` reads them."""
    told = coupling.in_units(units, _over)
    if told.polynomial is not None:
        return write_table(COUPLING, told, "")
    factors = tomlkit.inline_table()
    factors.update(told.terms)
    return write_table(COUPLING, SimpleNamespace(**vars(told) | {"of": factors}), "")


def _dh(table: DHTable, unit: str) -> dict[str, Any]:
    rows = tomlkit.array()
    for row in table.rows:
        entry = tomlkit.inline_table()
        entry.update(write_table(DH_ROW, row, unit))
        rows.append(entry)
    return {"convention": table.convention, "rows": rows.multiline(True)}


def _tables(tables: list[dict[str, Any]]) -> Any:
    array = tomlkit.aot()
    for table in tables:
        item = tomlkit.table()
        item.update(table)
        array.append(item)
    return array


def _over(value: float, scale: float) -> float:
    """The shortest number that, times `scale`, is exactly this value, if there is one."""
    return value if scale == 1.0 else shortest(value / scale, value, lambda number: scale * number)
