"""The keys of a mechanism file (TOML, `format = 1`), each once: by these tables a file is read, its
mistakes are told and it is written.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any, Literal, get_args

from symkin.errors import MechanismError
from symkin.model.arithmetic import evaluate, parameter_fault
from symkin.model.foreign_keys import JOINT_TYPES as FOREIGN_TYPES
from symkin.model.foreign_keys import LINKS_IN_A_LIMB
from symkin.model.joint import interval
from symkin.model.joint_forms import JOINT_TYPES
from symkin.model.limb import LIMB_LINKS, ROD_TYPES
from symkin.model.motor import Motor
from symkin.model.names import name_fault, text_fault
from symkin.text import first_of, meant, shown

LENGTH_UNITS, ANGLE_UNITS = ("m", "mm"), ("deg", "rad")
Motion = Literal["spatial", "schoenflies", "planar", "translation", "spherical"]
MOTIONS: tuple[Motion, ...] = get_args(Motion)
ABOUT_Z: tuple[Motion, ...] = ("schoenflies", "planar")
"""Motions that turn about the base frame's z alone: one angle is their last coordinate."""
_NEEDED = object()
"""The default of a key that a table must have."""


@dataclass(frozen=True)
class Place:
    """Where a value stands in a file, the unit that sin, cos and tan take there, and the parameters
    that arithmetic may use.
    """

    angle_unit: str
    path: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)

    def key(self, name: str) -> Place:
        return replace(self, path=f"{self.path}{'.' if self.path else ''}{name}")

    def item(self, k: int, value: object = None) -> Place:
        """The place of an item of a list, with its name where it has one."""
        name = value.get("name") if isinstance(value, dict) else None
        named = f" ({name})" if name_fault(name) is None else ""
        return replace(self, path=f"{self.path}[{k}]{named}")

    def refusal(self, value: object, needed: str) -> MechanismError:
        return MechanismError(f"{self.path} = {shown(value)}: {needed}")


Read = Callable[[Any, Place], Any]
"""A value of a file as the model has it. Raises MechanismError."""


@dataclass(frozen=True)
class Key:
    """A key of a table: how its value is read, its default, the model's name for it where that is
    another, the types of joints of which it is an angle, and whether it is written where it has its
    default too.
    """

    name: str
    read: Read
    default: Any = _NEEDED
    field: str = ""
    angle_of: Sequence[str] = ()
    always: bool = False

    @property
    def attribute(self) -> str:
        return self.field or self.name


Table = Sequence[Key]


def read_table(table: Table, raw: Any, place: Place) -> SimpleNamespace:
    """The values of a table, by the model's names for them, angles in radians."""
    if not isinstance(raw, dict):
        raise place.refusal(raw, "a table is needed")
    found: dict[str, Any] = {}
    for key in table:
        if key.name in raw:
            found[key.attribute] = key.read(raw[key.name], place.key(key.name))
        elif key.default is _NEEDED:
            _refuse_unknown(table, raw, place)  # which may be this one, misspelt
            allowed = f"; {key.read.allowed}" if isinstance(key.read, _Word) else ""
            raise MechanismError(f"{place.key(key.name).path} is missing{allowed}")
        else:
            found[key.attribute] = key.default
    _refuse_unknown(table, raw, place)
    if place.angle_unit == "deg":
        for key in _angles(table, found.get("type")):
            value = found[key.attribute]
            if isinstance(value, tuple):
                found[key.attribute] = tuple(map(math.radians, value))
            elif value is not None:
                found[key.attribute] = math.radians(value)
    return SimpleNamespace(**found)


def write_table(table: Table, source: Any, angle_unit: str) -> dict[str, Any]:
    """The table of a part of a description, without what has its default."""
    found: dict[str, Any] = {}
    for key in table:
        value = getattr(source, key.attribute, None)
        if value is None or value is False or (value == key.default and not key.always):
            continue
        if angle_unit == "deg" and key in _angles(table, getattr(source, "type", None)):
            value = (
                [in_degrees(v) for v in value] if isinstance(value, tuple) else in_degrees(value)
            )
        if isinstance(value, Motor):
            value = write_table(MOTOR, value, angle_unit)
        found[key.name] = list(value) if isinstance(value, tuple) else value
    return found


def _angles(table: Table, type_: object) -> list[Key]:
    return [key for key in table if type_ in key.angle_of]


def _refuse_unknown(table: Table, raw: Mapping[str, Any], place: Place) -> None:
    allowed = [key.name for key in table]
    for name in raw:
        if name in allowed:
            continue
        path = place.key(name).path
        if table is JOINT and name == "links":
            raise MechanismError(f"{path} is an unknown key; {LINKS_IN_A_LIMB}")
        raise MechanismError(
            f"{path} is an unknown key{meant(name, allowed)}; allowed: {', '.join(allowed)}"
        )


def in_degrees(radians: float) -> float:
    """The shortest number of degrees that reads back as exactly these radians, if there is one."""
    return shortest(math.degrees(radians), radians, math.radians)


def shortest(number: float, value: float, read: Callable[[float], float]) -> float:
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


# --- kinds of values ------------------------------------------------------------------------------


def _number(value: Any, place: Place) -> float:
    """A finite number, or a string of arithmetic."""
    if isinstance(value, str):
        try:
            return evaluate(value, place.angle_unit, place.parameters)
        except MechanismError as error:
            raise place.refusal(value, str(error)) from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise place.refusal(value, "a number or a string of arithmetic is needed")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise place.refusal(value, "a finite number is needed")
    return number


def _items(read: Read, what: str, count: int | None = None, least: int = 0) -> Read:
    """A list of values, `count` of them or at least `least`."""

    def listed(value: Any, place: Place) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise place.refusal(value, f"{what} needed")
        needed = least if count is None and len(value) < least else count
        if needed is not None and len(value) != needed:
            entries = "entry" if len(value) == 1 else "entries"
            raise MechanismError(
                f"{place.path} = {shown(value)} has {len(value)} {entries}; {needed} needed"
            )
        return tuple(read(each, place.item(k, each)) for k, each in enumerate(value))

    return listed


def _numbers(count: int | None = None) -> Read:
    what = "a list of numbers is" if count is None else f"a list of {count} numbers is"
    return _items(_number, what, count)


def _range(value: Any, place: Place) -> Any:
    return interval(_numbers(2)(value, place), place.path)


def _text(fault: Callable[[object], str | None] = lambda _: None) -> Read:
    """A text in which nothing is wrong."""

    def read(value: Any, place: Place) -> str:
        if not isinstance(value, str):
            raise place.refusal(value, "a text is needed")
        reason = fault(value)
        if reason is not None:
            raise place.refusal(value, reason)
        return value

    return read


class _Word:
    """One of some words; `instead` says what to write in place of those of other formats: a word,
    or a sentence.
    """

    def __init__(self, *words: Any, instead: Mapping[str, str] | None = None) -> None:
        self.words, self.instead = words, instead or {}
        self.allowed = f"allowed: {', '.join(map(repr, words))}"

    def __call__(self, value: Any, place: Place) -> Any:
        if type(value) is type(self.words[0]) and value in self.words:
            return value
        guess = more = ""
        if isinstance(value, str):
            other = self.instead.get(value, "")
            is_word = other in self.words
            guess = f" (do you mean {other!r}?)" if is_word else meant(value, self.words)
            more = f"; {other}" if other and not is_word else ""
        raise MechanismError(
            f"{place.path} = {shown(value)} is not allowed{guess}; {self.allowed}{more}"
        )


def _flag(value: Any, place: Place) -> bool:
    if not isinstance(value, bool):
        raise place.refusal(value, "true or false is needed")
    return value


def _mapping(read: Read) -> Read:
    """Values by names that are the user's own."""

    def mapped(value: Any, place: Place) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise place.refusal(value, "a table is needed")
        return {name: read(each, place.key(name)) for name, each in value.items()}

    return mapped


def _followed(value: Any, place: Place) -> Any:
    """The joints that a coupling follows: one by name, or several with their factors."""
    if isinstance(value, dict):
        return _mapping(_number)(value, place)
    if not isinstance(value, str):
        raise place.refusal(
            value, "the name of a joint, or a table of joints with factors is needed"
        )
    return _NAME(value, place)


def _one(table: Table) -> Read:
    return lambda value, place: read_table(table, value, place)


def _tables(table: Table, least: int = 0) -> Read:
    return _items(_one(table), "a list of tables ([[...]]) is", least=least)


def _motor(value: Any, place: Place) -> Motor:
    try:
        return Motor(**vars(read_table(MOTOR, value, place)))
    except MechanismError as error:
        told = str(error)
        raise MechanismError(
            told if told.startswith(place.path) else f"{place.path}: {told}"
        ) from None


def _limb(value: Any, place: Place) -> SimpleNamespace:
    """A limb of joints, or one that is a rod."""
    of_joints = isinstance(value, dict) and ("joint" in value or "rod" in value)
    return read_table(JOINT_LIMB if of_joints else ROD_LIMB, value, place)


_NAME, _VECTOR, _QUATERNION = _text(name_fault), _numbers(3), _numbers(4)
_LINKS = _items(_text(), "a list of two links is", 2)


def with_parameters(place: Place, raw: Any, told: Mapping[str, Any]) -> Place:
    """The place of a file whose arithmetic may use its `[parameters]`, each of which may use those
    before it; `told` are numbers, or arithmetic, in place of the file's. Raises MechanismError.
    """
    if not isinstance(raw, dict):
        raise place.key("parameters").refusal(raw, "a table of names with numbers is needed")
    for name in told:
        if name not in raw:
            known = f"parameters: {first_of([*raw])}" if raw else "the file has no [parameters]"
            raise MechanismError(
                f"set: no parameter is named {shown(name)}{meant(name, raw)}; {known}"
            )
    for name, value in raw.items():
        own = (replace(place, path="set") if name in told else place.key("parameters")).key(name)
        reason = parameter_fault(name)
        if reason is not None:
            raise MechanismError(f"{own.path}: {reason}")
        number = _number(told.get(name, value), own)
        place = replace(place, parameters={**place.parameters, name: number})
    return place


# --- the tables -----------------------------------------------------------------------------------


def _of_joint(types: Sequence[str], *links: Key) -> Table:
    """Keys of a joint, those of a graph with the links that it joins."""
    return (
        Key("name", _NAME),
        Key("type", _Word(*types, instead=FOREIGN_TYPES)),
        *links,
        Key("point", _VECTOR, None),
        Key("axis", _VECTOR, None),
        Key("axis2", _VECTOR, None),
        Key("pitch", _number, 0.0),
        Key("actuated", _flag, None),
        Key("zero", _number, 0.0, angle_of=("R", "H")),
        Key("limits", _range, None, angle_of=("R", "H")),
        Key("motor", _motor, None),
    )


MOTOR = (
    Key("effort", _numbers(2), None),
    Key("speed", _number, None),
    Key("armature", _number, None),
)
_LIMITS = Key("limits", _range, None)
_LIMB_LINKS = Key("links", _LINKS, LIMB_LINKS)
JOINT = _of_joint(JOINT_TYPES)
LINK_JOINT = _of_joint((*JOINT_TYPES, "weld"), Key("links", _LINKS, None))
ROD = (
    Key("from", _VECTOR, field="start"),
    Key("platform", _VECTOR),
    Key("length", _number, None),
)
ROD_LIMB = (
    Key("name", _NAME),
    Key("type", _Word(*ROD_TYPES), always=True),
    Key("base", _VECTOR),
    Key("platform", _VECTOR),
    Key("offset", _number, 0.0),
    _LIMB_LINKS,
    _LIMITS,
)
JOINT_LIMB = (
    Key("name", _NAME),
    _LIMB_LINKS,
    Key("joint", _tables(JOINT, least=1)),
    Key("rod", _tables(ROD), ()),
)
LINK_ROD = (
    Key("name", _NAME),
    Key("links", _LINKS),
    Key("from", _VECTOR, field="start"),
    Key("to", _VECTOR, field="end"),
    Key("length", _number, None),
    Key("actuated", _flag, False),
    Key("offset", _number, 0.0),
    _LIMITS,
)
COUPLING = (
    Key("joint", _NAME),
    Key("of", _followed),
    Key("offset", _number, 0.0),
    Key("polynomial", _numbers(), None),
)
LINK = (Key("name", _NAME), Key("points", _mapping(_VECTOR), {}))
TOOL = (
    Key("position", _VECTOR),
    Key("quaternion", _QUATERNION, (1.0, 0.0, 0.0, 0.0), always=True),
)
PLATFORM = (
    Key("link", _NAME, None),
    Key("position", _VECTOR, None),
    TOOL[1],
    Key("motion", _Word(*MOTIONS), "spatial"),
)
DH_ROW = (
    Key("name", _NAME, None),
    Key("type", _Word("R", "P")),
    Key("theta", _number, 0.0, angle_of=("R", "P"), always=True),
    Key("d", _number, 0.0, always=True),
    Key("a", _number, 0.0, always=True),
    Key("alpha", _number, 0.0, angle_of=("R", "P"), always=True),
    Key("limits", _range, None, angle_of=("R",)),
)
DH = (
    Key("convention", _Word("standard", "modified")),
    Key("rows", _tables(DH_ROW, least=1)),
)
EXAMPLE = (
    Key("joints", _numbers(), None),
    Key("pose", _numbers(7), None),
    Key("start", _numbers(), None),
    Key("given", _mapping(_number), None),
)
HEAD = (
    Key("format", _Word(1)),
    Key("name", _text()),
    Key("title", _text(text_fault), ""),
    Key("source", _text(text_fault), ""),
    Key("length_unit", _Word(*LENGTH_UNITS)),
    Key("angle_unit", _Word(*ANGLE_UNITS)),
)
MECHANISM = (
    *HEAD,
    Key("parameters", lambda _, place: place.parameters, None),
    Key("limb", _items(_limb, "a list of tables ([[limb]]) is"), ()),
    Key("platform", _one(PLATFORM), None),
    Key("dh", _one(DH), None),
    Key("joint", _tables(LINK_JOINT), ()),
    Key("rod", _tables(LINK_ROD), ()),
    Key("coupling", _tables(COUPLING), ()),
    Key("link", _tables(LINK), ()),
    Key("tool", _one(TOOL), None),
    Key("example", _one(EXAMPLE), None),
)
