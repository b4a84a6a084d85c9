"""Read mechanism files (TOML, `format = 1`).

Every mistake becomes one line: file, key path, value, what is allowed.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from symkin.computed_once import lru_cache
from symkin.errors import MechanismError, SymkinError
from symkin.model.description import Example
from symkin.model.dh import DHRow, DHTable
from symkin.model.foreign_keys import foreign_key, is_second_platform, second_platform
from symkin.model.graph import Coupling, LinkJoint, LinkPoint, LinkRod
from symkin.model.joint import BASE, PLATFORM, Joint
from symkin.model.joint_forms import JOINT_FORMS
from symkin.model.keys import MECHANISM, Place, read_table, with_parameters
from symkin.model.limb import LIMB_LINKS, Limb, Rod, RodLimb
from symkin.model.mechanism import Mechanism, serial_arm_from_dh
from symkin.model.shipped import SHIPPED
from symkin.regular_file import content_of
from symkin.text import meant


@lru_cache(maxsize=64)
def shipped(name: str) -> Mechanism:
    """The mechanism of this name that comes with symkin, which a process reads once."""
    return read(SHIPPED / f"{name}.toml")


def read(path: Path, told: Mapping[str, Any] | None = None) -> Mechanism:
    """The mechanism that a file describes; `told` are numbers of its parameters in place of the
    file's own.
    """
    try:
        text = content_of(path).decode("utf-8-sig")
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError:
        raise MechanismError(f"{path}: the file is not UTF-8 text") from None
    return parse(text, str(path), told)


def parse(text: str, file: str = "mechanism", told: Mapping[str, Any] | None = None) -> Mechanism:
    """The mechanism that a TOML text describes; `file` names it in messages, `told` are numbers of
    its parameters in place of its own.
    """
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        if is_second_platform(str(error)):
            raise MechanismError(f"{file}: {second_platform()}") from None
        raise MechanismError(f"{file}: not TOML: {' '.join(str(error).split())}") from None
    if not data:
        raise MechanismError(
            f"{file}: the file is empty; format = 1, name, units and at least one limb are needed"
        )
    try:
        return _mechanism(data, told or {})
    except SymkinError as error:
        raise MechanismError(f"{file}: {error}") from None


def _mechanism(data: dict[str, Any], told: Mapping[str, Any]) -> Mechanism:
    found = foreign_key(data)
    if found is not None:
        raise MechanismError(f"{_key_path(data, found[0])}: {found[1]}")
    # sin, cos, tan in arithmetic need the unit before it is read; a wrong one is refused there
    unit = data.get("angle_unit")
    place = Place("rad" if unit == "rad" else "deg")
    place = with_parameters(place, data.get("parameters", {}), told)
    table = read_table(MECHANISM, data, place)
    form = _form(table)
    _check_frames(form, table)
    _check_link_tables(table)
    options: dict[str, Any] = {
        "length_unit": table.length_unit,
        "angle_unit": table.angle_unit,
        "title": table.title,
        "source": table.source,
        "example": _example(table.example),
    }
    if form == "dh":
        rows = [
            DHRow(**vars(row) | {"name": row.name or f"q{k}"})
            for k, row in enumerate(table.dh.rows, start=1)
        ]
        return serial_arm_from_dh(table.name, DHTable(table.dh.convention, rows), **options)
    frame = table.tool if form == "joint" else table.platform
    if frame is not None:
        options |= {
            "motion": getattr(frame, "motion", "spatial"),
            "platform_position": frame.position or (0.0, 0.0, 0.0),
            "platform_quaternion": frame.quaternion,
        }
        if getattr(frame, "link", None) is not None:
            options["platform_link"] = frame.link
    if form == "joint":
        chain = Limb(table.name, [_joint(joint, serial=True) for joint in table.joint])
        return Mechanism(table.name, [chain], serial=True, **options)
    described = Mechanism(
        table.name,
        [_limb(limb) for limb in table.limb],
        link_joints=[LinkJoint(_joint(joint), joint.links) for joint in table.joint],
        link_rods=[LinkRod(**vars(rod)) for rod in table.rod],
        link_points=[
            LinkPoint(link.name, name, at)
            for link in table.link
            for name, at in link.points.items()
        ],
        **options,
    )
    if not table.coupling:
        return described
    units = described.units
    couplings = [Coupling(**vars(each)).in_units(units) for each in table.coupling]
    return replace(described, couplings=couplings)


def _form(table: Any) -> str:
    """What the file describes: "limb", "dh", "joint" (a serial arm) or "graph"."""
    linked = [joint for joint in table.joint if joint.links is not None]
    other_limbs = any(limb.links != LIMB_LINKS for limb in table.limb)
    if linked or table.rod or table.coupling or table.link or other_limbs:
        if table.dh is not None:
            raise MechanismError(
                "dh: a serial arm by DH stands alone; describe its joints with links in a graph"
            )
        alone = next((joint for joint in table.joint if joint.links is None), None)
        if alone is not None:
            raise MechanismError(
                f"joint {alone.name!r}: links is missing; every [[joint]] of a graph names the two "
                f"links that it joins"
            )
        return "graph"
    forms = [key for key in ("limb", "dh", "joint") if getattr(table, key)]
    if len(forms) != 1:
        what = "the mechanism has no limb" if not forms else f"the file has {' and '.join(forms)}"
        raise MechanismError(
            f"{what}; exactly one of [[limb]], [dh] and [[joint]] is needed, or [[joint]] with "
            f"links"
        )
    return forms[0]


def _limb(table: Any) -> Limb | RodLimb:
    if hasattr(table, "base"):
        return RodLimb(**vars(table))
    rods = [_rod(table.name, k, rod) for k, rod in enumerate(table.rod)]
    return Limb(table.name, [_joint(joint) for joint in table.joint], rods, table.links)


def _rod(limb: str, k: int, table: Any) -> Rod:
    try:
        return Rod(**vars(table))
    except MechanismError as error:
        raise MechanismError(f"limb {limb!r}, rod[{k}]: {error}") from None


def _joint(table: Any, *, serial: bool = False) -> Joint:
    if table.point is None and JOINT_FORMS[table.type].has_point:
        raise MechanismError(
            f"joint {table.name!r}: point is missing; a joint of type {table.type} needs it"
        )
    if serial and table.actuated is False:
        raise MechanismError(
            f"joint {table.name!r}: actuated = false; all joints of a serial arm are actuated"
        )
    values = {key: value for key, value in vars(table).items() if key != "links"}
    values["point"] = table.point or (0.0, 0.0, 0.0)
    values["actuated"] = serial or bool(table.actuated)
    return Joint(**values)


def _example(table: Any) -> Example | None:
    if table is None:
        return None
    if [table.joints, table.pose, table.given].count(None) != 2:
        raise MechanismError("example: exactly one of joints, pose and given is needed")
    given = None if table.given is None else tuple(table.given.items())
    return Example(table.joints, table.pose, given, table.start)


def _check_frames(form: str, table: Any) -> None:
    if table.platform is not None and form not in ("limb", "graph"):
        raise MechanismError("platform: a serial arm has none; [tool] is allowed with [[joint]]")
    if table.tool is not None and form != "joint":
        raise MechanismError(
            f"tool: allowed with [[joint]] only; with [{form}] the last frame is the platform or "
            f"tool"
        )
    linked = table.platform is not None and table.platform.link is not None
    if linked and form != "graph":
        raise MechanismError(
            "platform.link: allowed with [[joint]] that have links; limbs end on the platform"
        )
    if (
        form == "graph"
        and table.platform is not None
        and not linked
        and PLATFORM not in _links_named(table)
    ):
        raise MechanismError(
            "platform.link is missing; in a graph of links it names the one that carries the "
            "platform frame, which a link named "
            f"{PLATFORM!r} does by itself"
        )
    if (
        form == "limb"
        and table.platform is None
        and any(hasattr(limb, "joint") for limb in table.limb)
    ):
        raise MechanismError(
            "platform is missing; limbs of joints need [platform] with its position at the "
            "reference"
        )
    if form == "graph":
        return
    placed = table.platform is None or table.platform.position is not None
    if not placed and any(hasattr(limb, "joint") for limb in table.limb):
        raise MechanismError("platform.position is missing; limbs of joints need it")


def _links_named(table: Any) -> list[str]:
    """The links that joints, rods and limbs name."""
    return [link for entry in (*table.joint, *table.rod, *table.limb) for link in entry.links or ()]


def _check_link_tables(table: Any) -> None:
    """Every [[link]] is one that a joint, a rod or a limb names."""
    held = _links_named(table)
    for k, link in enumerate(table.link):
        if link.name not in held and link.name != BASE:
            raise MechanismError(
                f"link[{k}] ({link.name}): nothing holds it{meant(link.name, held)}; name it in "
                f"the links of a joint or rod"
            )


def _key_path(data: Any, keys: Sequence[str | int]) -> str:
    """`limb[1] (trt1).joint[0] (theta1).type`: positions from 0 and, where there is one, the
    name.
    """
    place, node = Place(""), data
    for key in keys:
        node = node[key]
        place = place.item(key, node) if isinstance(key, int) else place.key(key)
    return place.path
