"""Write mechanism files (TOML, `format = 1`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

import tomlkit

from symkin.model.description import Description
from symkin.model.dh import DHTable
from symkin.model.graph import Coupling, LinkJoint, LinkRod, coupling_scale
from symkin.model.joint import Joint
from symkin.model.limb import LIMB_LINKS, Limb, RodLimb


def mechanism_to_toml(mechanism: Description) -> str:
    """Write the file that describes the mechanism; reading it back gives an equal one."""
    document = tomlkit.document()
    document["format"] = 1
    for key in ("name", "title", "source", "length_unit", "angle_unit"):
        if getattr(mechanism, key):
            document[key] = getattr(mechanism, key)
    if mechanism.dh is not None:
        document["dh"] = _dh(mechanism, mechanism.dh)
    elif mechanism.serial:
        _frame(document, "tool", mechanism)
        # that they are actuated goes without saying
        joints = [_joint(mechanism, joint) for _, joint in mechanism.joints]
        document["joint"] = _tables(
            [{key: value for key, value in table.items() if key != "actuated"} for table in joints]
        )
    else:
        _links(document, mechanism)
    if mechanism.example is not None:
        values = {k: getattr(mechanism.example, k) for k in ("joints", "pose", "start")}
        document["example"] = {k: list(v) for k, v in values.items() if v is not None}
        given = getattr(mechanism.example, "given", None)
        if given is not None:
            document["example"]["given"] = dict(given)
    return tomlkit.dumps(document)


def _links(document: tomlkit.TOMLDocument, mechanism: Description) -> None:
    """Limbs, and joints and rods between links."""
    if mechanism.platform_link is not None:
        _frame(document, "platform", mechanism)
    tables = {
        "joint": [_link_joint(mechanism, entry) for entry in mechanism.link_joints],
        "rod": [_link_rod(rod) for rod in mechanism.link_rods],
        "limb": [_limb(mechanism, limb) for limb in mechanism.limbs],
        "coupling": [_coupling(mechanism, coupling) for coupling in mechanism.couplings],
        "link": [
            {"name": link, "points": {point.name: list(point.point) for point in points}}
            for link, points in groupby(mechanism.link_points, key=lambda point: point.link)
        ],
    }
    for key, entries in tables.items():
        if entries:
            document[key] = _tables(entries)


def _frame(document: tomlkit.TOMLDocument, key: str, mechanism: Description) -> None:
    table: dict[str, Any] = {} if not mechanism.is_graph else {"link": mechanism.platform_link}
    table |= {
        "position": list(mechanism.platform_position),
        "quaternion": list(mechanism.platform_quaternion),
    }
    if mechanism.motion != "spatial":
        table["motion"] = mechanism.motion
    document[key] = table


def _limb(mechanism: Description, limb: Limb | RodLimb) -> dict[str, Any]:
    if isinstance(limb, RodLimb):
        table: dict[str, Any] = {
            "name": limb.name,
            "type": limb.type,
            "base": list(limb.base),
            "platform": list(limb.platform),
        }
        if limb.offset:
            table["offset"] = limb.offset
        return table | _links_of_limb(limb) | _range(limb.limits)
    table = {"name": limb.name} | _links_of_limb(limb)
    table["joint"] = _tables([_joint(mechanism, joint) for joint in limb.joints])
    rods = []
    for rod in limb.rods:
        entry: dict[str, Any] = {"from": list(rod.start), "platform": list(rod.platform)}
        rods.append(entry | ({} if rod.length is None else {"length": rod.length}))
    return table | ({"rod": _tables(rods)} if rods else {})


def _links_of_limb(limb: Limb | RodLimb) -> dict[str, Any]:
    return {} if tuple(limb.links) == LIMB_LINKS else {"links": list(limb.links)}


def _link_joint(mechanism: Description, entry: LinkJoint) -> dict[str, Any]:
    table = _joint(mechanism, entry.joint)
    return {
        "name": table.pop("name"),
        "type": table.pop("type"),
        "links": list(entry.links),
    } | table


def _link_rod(rod: LinkRod) -> dict[str, Any]:
    table: dict[str, Any] = {
        "name": rod.name,
        "links": list(rod.links),
        "from": list(rod.start),
        "to": list(rod.end),
    }
    if rod.length is not None:
        table["length"] = rod.length
    if rod.actuated:
        table["actuated"] = True
    if rod.offset:
        table["offset"] = rod.offset
    return table | _range(rod.limits)


def _coupling(mechanism: Description, coupling: Coupling) -> dict[str, Any]:
    """Numbers in the file's units, as `coupling_scale` reads them."""
    coordinates = mechanism.coordinates
    unit = {
        c.name: math.radians(1.0) if c.is_angular and mechanism.angle_unit == "deg" else 1.0
        for c in coordinates
    }
    own = unit[coupling.joint]
    table: dict[str, Any] = {"joint": coupling.joint}
    if coupling.polynomial is not None:
        (name,) = coupling.names
        powers = [
            _scaled(c, coupling_scale(own, unit[name], k))
            for k, c in enumerate(coupling.polynomial)
        ]
        return table | {"of": name, "polynomial": powers}
    factors = tomlkit.inline_table()
    factors.update(
        {
            name: _scaled(factor, coupling_scale(own, unit[name], 1))
            for name, factor in coupling.terms
        }
    )
    table["of"] = factors
    return table | ({"offset": _scaled(coupling.offset, own)} if coupling.offset else {})


def _joint(mechanism: Description, joint: Joint) -> dict[str, Any]:
    angular = joint.type in ("R", "H")
    table: dict[str, Any] = {"name": joint.name, "type": joint.type, "point": list(joint.point)}
    for key in ("axis", "axis2"):
        if getattr(joint, key) is not None:
            table[key] = list(getattr(joint, key))
    if joint.pitch:
        table["pitch"] = joint.pitch
    if joint.actuated:
        table["actuated"] = True
    if joint.zero:
        table["zero"] = _angle(mechanism, joint.zero) if angular else joint.zero
    limits = joint.limits
    table |= _range([_angle(mechanism, v) for v in limits] if limits and angular else limits)
    if joint.motor is not None:
        table["motor"] = tomlkit.inline_table()
        table["motor"].update(joint.motor.to_dict())
    return table


def _dh(mechanism: Description, table: DHTable) -> dict[str, Any]:
    rows = tomlkit.array()
    for row in table.rows:
        entry = tomlkit.inline_table()
        entry.update(
            {
                "name": row.name,
                "type": row.type,
                "theta": _angle(mechanism, row.theta),
                "d": row.d,
                "a": row.a,
            }
        )
        entry.update({"alpha": _angle(mechanism, row.alpha)})
        limits = row.limits
        entry.update(
            _range([_angle(mechanism, v) for v in limits] if limits and row.type == "R" else limits)
        )
        rows.append(entry)
    return {"convention": table.convention, "rows": rows.multiline(True)}


def _range(limits: Sequence[float] | None) -> dict[str, Any]:
    return {} if limits is None else {"limits": list(limits)}


def _tables(tables: list[dict[str, Any]]) -> Any:
    array = tomlkit.aot()
    for table in tables:
        item = tomlkit.table()
        item.update(table)
        array.append(item)
    return array


def _angle(mechanism: Description, radians: float) -> float:
    """The shortest number in the mechanism's angle unit that reads back as exactly these radians,
    if there is one.
    """
    return (
        radians
        if mechanism.angle_unit == "rad"
        else _shortest(math.degrees(radians), radians, math.radians)
    )


def _scaled(value: float, scale: float) -> float:
    """The shortest number that, times `scale`, is exactly this value, if there is one."""
    return value if scale == 1.0 else _shortest(value / scale, value, lambda number: scale * number)


def _shortest(number: float, value: float, read: Callable[[float], float]) -> float:
    """The shortest number beside `number` that is read as exactly `value`; `number` itself where
    there is none.
    """
    # degrees(radians(x)) is not always x: try the shorter spellings that read back as these very
    # radians
    for digits in (12, 14, 15, 16, 17):
        candidate = float(f"{number:.{digits}g}")
        if read(candidate) == value:
            return candidate
    neighbours = (math.nextafter(number, math.inf), math.nextafter(number, -math.inf))
    return next((n for n in neighbours if read(n) == value), number)
