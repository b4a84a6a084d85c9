"""Read mechanism files (TOML, `format = 1`).

Every mistake becomes one line: file, key path, value, what is allowed.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from io import TextIOWrapper
from pathlib import Path
from typing import Any

from symkin.computed_once import lru_cache
from symkin.errors import InputError, MechanismError, SymkinError
from symkin.model.dh import DHRow, DHTable
from symkin.model.foreign_keys import (
    JOINT_TYPES,
    LINKS_IN_A_LIMB,
    foreign_key,
    is_second_platform,
    second_platform,
)
from symkin.model.graph import Coupling, LinkJoint, LinkPoint, LinkRod, coupling_scale
from symkin.model.joint import BASE, PLATFORM, Joint, interval
from symkin.model.limb import LIMB_LINKS, Limb, Rod, RodLimb
from symkin.model.mechanism import ANGLE_UNITS, Example, Mechanism, serial_arm_from_dh
from symkin.model.motor import Motor
from symkin.model.names import name_fault
from symkin.model.shipped import SHIPPED
from symkin.regular_file import open_regular
from symkin.text import meant, shown


@lru_cache(maxsize=64)
def shipped(name: str) -> Mechanism:
    """The mechanism of this name that comes with symkin, which a process reads once."""
    return read(SHIPPED / f"{name}.toml")


def read(path: Path) -> Mechanism:
    """The mechanism that a file describes."""
    try:
        with open_regular(path) as file, TextIOWrapper(file, encoding="utf-8-sig") as lines:
            text = lines.read()
    except FileNotFoundError:
        raise InputError(no_such_file(path)) from None
    except UnicodeDecodeError:
        raise MechanismError(f"{path}: the file is not UTF-8 text") from None
    except (OSError, ValueError) as error:
        raise InputError(
            f"{path}: the file cannot be read ({getattr(error, 'strerror', None) or error})"
        ) from None
    return parse(text, str(path))


def no_such_file(path: Path) -> str:
    """What is said of a path that leads nowhere, with the file of its folder whose name is most
    like it.
    """
    beside = (
        [file.name for file in path.parent.iterdir() if file.suffix == path.suffix]
        if path.parent.is_dir()
        else []
    )
    return f"{path}: there is no such file{meant(path.name, beside)}"


def parse(text: str, file: str = "mechanism") -> Mechanism:
    """The mechanism that a TOML text describes; `file` names it in messages."""
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
        return _mechanism(data)
    except SymkinError as error:
        raise MechanismError(f"{file}: {error}") from None


def _mechanism(data: dict[str, Any]) -> Mechanism:
    from symkin.model.schema import JointLimbTable, MechanismTable, RodLimbTable

    _check_class(data)
    # sin, cos, tan in arithmetic need the unit before the file is validated; a wrong one is refused
    # there
    unit = data.get("angle_unit")
    context = {"angle_unit": unit if unit in ANGLE_UNITS else "deg"}
    table = _validated(MechanismTable, data, (), context)
    limbs = []
    for k, raw in enumerate(table.limb):
        model = JointLimbTable if "joint" in raw or "rod" in raw else RodLimbTable
        limbs.append(_validated(model, raw, ("limb", k), context))
    _check_frames(_form(table, limbs), table, limbs)
    _check_link_tables(table, limbs)
    options: dict[str, Any] = {
        "length_unit": table.length_unit,
        "angle_unit": table.angle_unit,
        "title": table.title,
        "source": table.source,
        "example": _example(table.example),
    }
    return _Builder(table.angle_unit).mechanism(table, limbs, options)


def _form(table: Any, limbs: Sequence[Any]) -> str:
    """What the file describes: "limb", "dh", "joint" (a serial arm) or "graph"."""
    linked = [joint for joint in table.joint if joint.links is not None]
    other_limbs = any(tuple(limb.links) != LIMB_LINKS for limb in limbs)
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


def _check_class(data: dict[str, Any]) -> None:
    """Refuse what other formats write by what it asks for, before single keys."""
    found = foreign_key(data)
    if found is not None:
        raise MechanismError(f"{_key_path(data, found[0], ())}: {found[1]}")


class _Builder:
    """From validated tables to the model; angles become radians here."""

    def __init__(self, angle_unit: str) -> None:
        self.scale = 1.0 if angle_unit == "rad" else None

    def angle(self, value: float) -> float:
        import math

        return value if self.scale else math.radians(value)

    def mechanism(self, table: Any, limbs: Sequence[Any], options: dict[str, Any]) -> Mechanism:
        if table.dh is not None:
            rows = [self.dh_row(row, k) for k, row in enumerate(table.dh.rows, start=1)]
            return serial_arm_from_dh(table.name, DHTable(table.dh.convention, rows), **options)
        serial = bool(table.joint) and table.joint[0].links is None
        frame = table.tool if serial else table.platform
        if frame is not None:
            options |= {
                "motion": getattr(frame, "motion", "spatial"),
                "platform_position": frame.position,
                "platform_quaternion": frame.quaternion,
            }
            if getattr(frame, "link", None) is not None:
                options["platform_link"] = frame.link
        if serial:
            chain = Limb(table.name, [self.joint(j, serial=True) for j in table.joint])
            return Mechanism(table.name, [chain], serial=True, **options)
        options |= {
            "link_joints": [LinkJoint(self.joint(j), j.links) for j in table.joint],
            "link_rods": [self.link_rod(rod) for rod in table.rod],
            "link_points": [
                LinkPoint(link.name, name, at)
                for link in table.link
                for name, at in link.points.items()
            ],
        }
        found = Mechanism(table.name, [self.limb(limb) for limb in limbs], **options)
        if not table.coupling:
            return found
        kinds = {c.name: c.is_angular for c in found.coordinates}
        return replace(
            found, couplings=tuple(self.coupling(entry, kinds) for entry in table.coupling)
        )

    def limb(self, table: Any) -> Limb | RodLimb:
        if hasattr(table, "base"):
            return RodLimb(
                table.name,
                table.base,
                table.platform,
                table.offset,
                table.limits,
                table.type,
                table.links,
            )
        rods = [self.rod(table.name, k, rod) for k, rod in enumerate(table.rod)]
        return Limb(table.name, [self.joint(joint) for joint in table.joint], rods, table.links)

    def link_rod(self, table: Any) -> LinkRod:
        return LinkRod(
            name=table.name,
            links=table.links,
            start=table.from_,
            end=table.to,
            length=table.length,
            actuated=table.actuated,
            offset=table.offset,
            limits=table.limits,
        )

    def coupling(self, table: Any, is_angular: Mapping[str, bool]) -> Coupling:
        """Numbers from the file's units: with u the unit of each coordinate, q / u = sum f q' /
        u' + offset.
        """
        unit = {name: self.angle(1.0) if angular else 1.0 for name, angular in is_angular.items()}
        own = unit.get(table.joint, 1.0)
        if isinstance(table.of, str):
            powers = None
            if table.polynomial is not None:
                other = unit.get(table.of, 1.0)
                powers = [coupling_scale(own, other, k) * c for k, c in enumerate(table.polynomial)]
            return Coupling(table.joint, table.of, own * table.offset, powers)
        terms = {
            name: coupling_scale(own, unit.get(name, 1.0), 1) * factor
            for name, factor in table.of.items()
        }
        return Coupling(table.joint, terms, own * table.offset, table.polynomial)

    def rod(self, limb: str, k: int, table: Any) -> Rod:
        try:
            return Rod(table.from_, table.platform, table.length)
        except MechanismError as error:
            raise MechanismError(f"limb {limb!r}, rod[{k}]: {error}") from None

    def joint(self, table: Any, *, serial: bool = False) -> Joint:
        if table.point is None and table.type not in ("P", "weld"):
            raise MechanismError(
                f"joint {table.name!r}: point is missing; a joint of type {table.type} needs it"
            )
        angular = table.type in ("R", "H")
        if serial and table.actuated is False:
            raise MechanismError(
                f"joint {table.name!r}: actuated = false; all joints of a serial arm are actuated"
            )
        return Joint(
            name=table.name,
            type=table.type,
            point=table.point or (0.0, 0.0, 0.0),
            axis=table.axis,
            axis2=table.axis2,
            pitch=table.pitch,
            actuated=serial or bool(table.actuated),
            zero=self.angle(table.zero) if angular else table.zero,
            limits=self.range(table.limits, f"joint {table.name!r}", angular=angular),
            motor=None if table.motor is None else Motor(**table.motor.model_dump()),
        )

    def dh_row(self, table: Any, k: int) -> DHRow:
        name = table.name or f"q{k}"
        limits = self.range(table.limits, f"dh row {name!r}", angular=table.type == "R")
        return DHRow(
            name=name,
            type=table.type,
            theta=self.angle(table.theta),
            d=table.d,
            a=table.a,
            alpha=self.angle(table.alpha),
            limits=limits,
        )

    def range(self, limits: list[float] | None, where: str, *, angular: bool) -> list[float] | None:
        interval(limits, f"{where}: limits")
        return [self.angle(v) for v in limits] if limits and angular else limits


def _example(table: Any) -> Example | None:
    if table is None:
        return None
    if [table.joints, table.pose, table.given].count(None) != 2:
        raise MechanismError("example: exactly one of joints, pose and given is needed")
    given = None if table.given is None else tuple(table.given.items())
    values = {k: tuple(v) for k, v in table.model_dump().items() if v is not None and k != "given"}
    return Example(**values, given=given)


def _check_frames(form: str, table: Any, limbs: Sequence[Any]) -> None:
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
        and PLATFORM not in _links_named(table, limbs)
    ):
        raise MechanismError(
            "platform.link is missing; in a graph of links it names the one that carries the "
            "platform frame, which a link named "
            f"{PLATFORM!r} does by itself"
        )
    if form == "limb" and table.platform is None and any(hasattr(limb, "joint") for limb in limbs):
        raise MechanismError(
            "platform is missing; limbs of joints need [platform] with its position at the "
            "reference"
        )
    if form == "graph":
        return
    placed = table.platform is None or "position" in table.platform.model_fields_set
    if not placed and any(hasattr(limb, "joint") for limb in limbs):
        raise MechanismError("platform.position is missing; limbs of joints need it")


def _links_named(table: Any, limbs: Sequence[Any]) -> list[str]:
    """The links that joints, rods and limbs name."""
    return [link for entry in (*table.joint, *table.rod, *limbs) for link in entry.links or ()]


def _check_link_tables(table: Any, limbs: Sequence[Any]) -> None:
    """Every [[link]] is one that a joint, a rod or a limb names."""
    held = _links_named(table, limbs)
    for k, link in enumerate(table.link):
        if link.name not in held and link.name != BASE:
            raise MechanismError(
                f"link[{k}] ({link.name}): nothing holds it{meant(link.name, held)}; name it in "
                f"the links of a joint or rod"
            )


def _validated(model: Any, data: Any, path: tuple[str | int, ...], context: dict[str, Any]) -> Any:
    from pydantic import ValidationError

    try:
        return model.model_validate(data, context=context)
    except ValidationError as error:
        first = _first(error.errors(include_url=False))
        keys = (*path, *first["loc"])
        raise MechanismError(_sentence(_key_path(data, keys, path), first, model)) from None


def _first(errors: Sequence[Any]) -> Any:
    """The first error; where it is a key that is missing, one that is unknown in the same table:
    the key misspelt.
    """
    table = errors[0]["loc"][:-1]
    unknown = (e for e in errors if e["type"] == "extra_forbidden" and e["loc"][:-1] == table)
    return next(unknown, errors[0]) if errors[0]["type"] == "missing" else errors[0]


def _key_path(data: Any, keys: tuple[str | int, ...], prefix: tuple[str | int, ...]) -> str:
    """`limb[1] (trt1).joint[0] (theta1).type`: positions from 0 and, where there is one, the
    name.
    """
    text, node = "", data
    for depth, key in enumerate(keys):
        if depth >= len(prefix):
            node = node[key] if _has(node, key) else None
        text += f"[{key}]" if isinstance(key, int) else f"{'.' if text else ''}{key}"
        if isinstance(key, int) and isinstance(node, dict) and name_fault(node.get("name")) is None:
            text += f" ({node['name']})"
    return text


def _has(node: Any, key: str | int) -> bool:
    if isinstance(node, dict):
        return key in node
    return isinstance(node, list) and isinstance(key, int) and key < len(node)


def _sentence(path: str, error: Any, model: Any) -> str:
    value, kind = error.get("input"), error["type"]
    match kind:
        case "missing":
            return f"{path} is missing"
        case "extra_forbidden":
            return _unknown_key(path, str(error["loc"][-1]), _allowed_keys(model, error["loc"]))
        case "literal_error":
            instead = (
                JOINT_TYPES.get(value)
                if path.endswith(".type") and isinstance(value, str)
                else None
            )
            allowed = error["ctx"]["expected"].replace(" or ", ", ")
            guess = meant(value, re.findall("'(.*?)'", allowed)) if isinstance(value, str) else ""
            refused = f"{path} = {shown(value)} is not allowed{guess}; allowed: {allowed}"
            return f"{refused}; {instead}" if instead else refused
        case "too_short" | "too_long":
            limit = error["ctx"].get("min_length", error["ctx"].get("max_length"))
            return (
                f"{path} = {shown(value)} has {error['ctx']['actual_length']} entries; {limit} "
                f"needed"
            )
        case _:
            return f"{path} = {shown(value)}: {error['msg']}"


def _unknown_key(path: str, key: str, allowed: list[str]) -> str:
    """What is said of a key that a table has not, with the nearest that it has."""
    if key == "links" and ".joint[" in path:
        return f"{path} is an unknown key; {LINKS_IN_A_LIMB}"
    return f"{path} is an unknown key{meant(key, allowed)}; allowed: {', '.join(allowed)}"


def _allowed_keys(model: Any, loc: tuple[str | int, ...]) -> list[str]:
    """Keys of the table in which an unknown key stands."""
    import typing

    for key in loc[:-1]:
        if isinstance(key, str):
            annotation = model.model_fields[key].annotation
            candidates = [annotation, *typing.get_args(annotation)]
            model = next((c for c in candidates if hasattr(c, "model_fields")), model)
    return [field.alias or name for name, field in model.model_fields.items()]
