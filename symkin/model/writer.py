"""Write mechanism files (TOML, `format = 1`)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import tomlkit

from symkin.model.dh import DHTable
from symkin.model.joint import Joint
from symkin.model.limb import Limb, RodLimb


class Description(Protocol):
    """What the file says of a mechanism, as `Mechanism` has it: that class writes itself, so that this module cannot import
    it."""

    @property
    def motion(self) -> str: ...
    @property
    def angle_unit(self) -> str: ...
    @property
    def serial(self) -> bool: ...
    @property
    def limbs(self) -> Sequence[Limb | RodLimb]: ...
    @property
    def joints(self) -> Iterator[tuple[Limb, Joint]]: ...
    @property
    def dh(self) -> DHTable | None: ...
    @property
    def platform_position(self) -> Sequence[float]: ...
    @property
    def platform_quaternion(self) -> Sequence[float]: ...
    @property
    def example(self) -> object | None: ...


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
        document["joint"] = _tables([_joint(mechanism, joint) for _, joint in mechanism.joints])
    else:
        _frame(document, "platform", mechanism)
        document["limb"] = _tables([_limb(mechanism, limb) for limb in mechanism.limbs])
    if mechanism.example is not None:
        given = {k: getattr(mechanism.example, k) for k in ("joints", "pose", "start")}
        document["example"] = {k: list(v) for k, v in given.items() if v is not None}
    return tomlkit.dumps(document)


def _frame(document: tomlkit.TOMLDocument, key: str, mechanism: Description) -> None:
    table: dict[str, Any] = {"position": list(mechanism.platform_position), "quaternion": list(mechanism.platform_quaternion)}
    if mechanism.motion != "spatial":
        table["motion"] = mechanism.motion
    document[key] = table


def _limb(mechanism: Description, limb: Limb | RodLimb) -> dict[str, Any]:
    if isinstance(limb, RodLimb):
        table: dict[str, Any] = {"name": limb.name, "type": limb.type, "base": list(limb.base), "platform": list(limb.platform)}
        if limb.offset:
            table["offset"] = limb.offset
        return table | _range(limb.limits)
    table = {"name": limb.name, "joint": _tables([_joint(mechanism, joint) for joint in limb.joints])}
    rods = []
    for rod in limb.rods:
        entry: dict[str, Any] = {"from": list(rod.start), "platform": list(rod.platform)}
        rods.append(entry | ({} if rod.length is None else {"length": rod.length}))
    return table | ({"rod": _tables(rods)} if rods else {})


def _joint(mechanism: Description, joint: Joint) -> dict[str, Any]:
    angular = joint.type in ("R", "H")
    table: dict[str, Any] = {"name": joint.name, "type": joint.type, "point": list(joint.point)}
    for key in ("axis", "axis2"):
        if getattr(joint, key) is not None:
            table[key] = list(getattr(joint, key))
    if joint.pitch:
        table["pitch"] = joint.pitch
    if joint.actuated and not mechanism.serial:
        table["actuated"] = True
    if joint.zero:
        table["zero"] = _angle(mechanism, joint.zero) if angular else joint.zero
    limits = joint.limits
    return table | _range([_angle(mechanism, v) for v in limits] if limits and angular else limits)


def _dh(mechanism: Description, table: DHTable) -> dict[str, Any]:
    rows = tomlkit.array()
    for row in table.rows:
        entry = tomlkit.inline_table()
        entry.update({"name": row.name, "type": row.type, "theta": _angle(mechanism, row.theta), "d": row.d, "a": row.a})
        entry.update({"alpha": _angle(mechanism, row.alpha)})
        limits = row.limits
        entry.update(_range([_angle(mechanism, v) for v in limits] if limits and row.type == "R" else limits))
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
    """The shortest number in the mechanism's angle unit that reads back as exactly these radians, if there is one."""
    if mechanism.angle_unit == "rad":
        return radians
    degrees = math.degrees(radians)
    # degrees(radians(x)) is not always x: try the shorter spellings that read back as these very radians
    for digits in (12, 14, 15, 16, 17):
        candidate = float(f"{degrees:.{digits}g}")
        if math.radians(candidate) == radians:
            return candidate
    neighbours = (math.nextafter(degrees, math.inf), math.nextafter(degrees, -math.inf))
    return next((n for n in neighbours if math.radians(n) == radians), degrees)
