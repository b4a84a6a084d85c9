"""Read the YAML file that the Gepetto team writes beside a URDF: pairs of frames that close loops,
motors, joints of another type.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from symkin.errors import InputError, MechanismError
from symkin.formats.robot import AXES, Direction
from symkin.model.joint_forms import JointType
from symkin.regular_file import content_of
from symkin.text import first_of, not_among, shown

_CLOSURES: dict[str, JointType] = {"3d": "S", "6d": "weld"}
YAML_ENDINGS = (".yaml", ".yml")
_UNIVERSAL = re.compile(r"ujoint_([xyz])([xyz])")
_KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
_LARGEST = 200_000
"""Bytes of a YAML file: loops and motors take a few thousand, and PyYAML reads a tenth of a
megabyte in a second.
"""
_MOST_VALUES = 100_000
"""Values that a YAML file may hold, its aliases written out."""

Retyped = tuple[JointType, tuple[Direction, Direction] | None]
"""A joint's type in place of that in the URDF, and the axes of a universal one in the joint's
frame.
"""


@dataclass(frozen=True)
class LoopsBeside:
    """What the YAML file says: `closures` (type and two links each), `motors` by name, joints that
    are of another type.
    """

    file: Path | None = None
    closures: tuple[tuple[JointType, str, str], ...] = ()
    motors: tuple[str, ...] = ()
    retyped: Mapping[str, Retyped] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def frames(self) -> frozenset[str]:
        """The links whose frames the closures name."""
        return frozenset(link for _, first, second in self.closures for link in (first, second))


def loops_beside(path: Path) -> LoopsBeside:
    """What stands in the YAML file of a URDF's name (leg.yaml of leg.urdf, and of leg.urdf.xacro);
    nothing where there is none, or it closes no loop.
    """
    names = [path, path.with_suffix("")] if path.with_suffix("").suffix == ".urdf" else [path]
    file = next(
        (
            f
            for name in names
            for ending in YAML_ENDINGS
            if (f := name.with_suffix(ending)).is_file()
        ),
        None,
    )
    if file is None:
        return LoopsBeside()
    text = _text(file)
    if re.search(r"^\s*[\"']?closed_loop[\"']?\s*:", text, re.M) is None:
        return LoopsBeside(
            notes=(f"{file.name} beside the file tells no closed_loop, and is left out",)
        )
    try:
        return _loops(file, _mapping(text))
    except MechanismError as error:
        raise MechanismError(f"{file}: {error}") from None


def _loops(file: Path, data: Mapping[str, Any]) -> LoopsBeside:
    pairs = data.get("closed_loop") or []
    if not isinstance(pairs, list) or not all(_is_names(pair) and len(pair) == 2 for pair in pairs):
        raise MechanismError(f"closed_loop = {shown(pairs)} is no list of pairs of links")
    kinds = _names(data, "type")
    if len(kinds) != len(pairs):
        raise MechanismError(
            f"type has {len(kinds)} entries and closed_loop {len(pairs)}; one for each loop is "
            f"needed"
        )
    unknown = next((kind for kind in kinds if kind.lower() not in _CLOSURES), None)
    if unknown is not None:
        raise MechanismError(f"type: {not_among(unknown, _CLOSURES)}")
    closures = tuple(
        (_CLOSURES[kind.lower()], first, second)
        for kind, (first, second) in zip(kinds, pairs, strict=True)
    )
    other = [key if isinstance(key, str) else shown(key) for key in data if key not in _KEYS]
    notes = (f"{file.name}: left out, of no meaning here: {first_of(other)}",) if other else ()
    return LoopsBeside(file, closures, tuple(_names(data, "name_mot")), _retyped(data), notes)


def _retyped(data: Mapping[str, Any]) -> dict[str, Retyped]:
    names, types = _names(data, "joint_name"), _names(data, "joint_type")
    if len(names) != len(types):
        raise MechanismError(
            f"joint_type has {len(types)} entries and joint_name {len(names)}; one for each joint "
            f"is needed"
        )
    return {name: _type(kind) for name, kind in zip(names, types, strict=True)}


def _type(kind: str) -> Retyped:
    universal = _UNIVERSAL.fullmatch(kind.lower())
    if universal is not None and universal[1] != universal[2]:
        return "U", (AXES[universal[1]], AXES[universal[2]])
    if kind.upper() == "SPHERICAL":
        return "S", None
    if kind.upper() == "FIXED":
        return "weld", None
    raise MechanismError(
        f"joint_type: {shown(kind)} is unknown; allowed: SPHERICAL, FIXED, UJOINT_XY and other "
        f"pairs of axes"
    )


def _names(data: Mapping[str, Any], key: str) -> Sequence[str]:
    """A list of names; empty where the key is missing."""
    value = data.get(key) or []
    if not _is_names(value):
        raise MechanismError(f"{key} = {shown(value)} is no list of names")
    return list(value)


def _is_names(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(entry, str) for entry in value)


def _mapping(text: str) -> Mapping[str, Any]:
    """A YAML text of plain values."""
    try:
        yaml = import_module("yaml")
    except ImportError:
        raise InputError(
            "loops written in YAML beside a URDF need the package PyYAML: pip install "
            "'symkin[urdf]' installs it"
        ) from None
    try:
        data = _loaded(yaml, text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        line = "" if mark is None else f"line {mark.line + 1}: "
        raise MechanismError(
            f"{line}not YAML: {getattr(error, 'problem', None) or ' '.join(str(error).split())}"
        ) from None
    if not isinstance(data, dict):
        raise MechanismError("not a YAML mapping of closed_loop, type, name_mot")
    return data


def _loaded(yaml: Any, text: str) -> Any:
    """The value of a YAML text. Raises MechanismError for one whose aliases repeat too much."""
    loader = yaml.SafeLoader(text)
    try:
        node = loader.get_single_node()
        if node is not None and _size(node, {}) > _MOST_VALUES:
            raise MechanismError(
                f"its aliases (*name) make more than {_MOST_VALUES} values of it; write out the "
                f"few that are needed"
            )
        return None if node is None else loader.construct_document(node)
    finally:
        loader.dispose()


def _size(node: Any, known: dict[int, float]) -> float:
    """How many values a node of YAML holds with its aliases written out; infinitely many where it
    holds itself.
    """
    if id(node) not in known:
        known[id(node)] = math.inf
        parts = node.value if isinstance(node.value, list) else []
        flat = [
            part for entry in parts for part in (entry if isinstance(entry, tuple) else (entry,))
        ]
        known[id(node)] = 1.0 + sum(_size(part, known) for part in flat)
    return known[id(node)]


def _text(file: Path) -> str:
    content = content_of(file, _LARGEST + 1)
    if len(content) > _LARGEST:
        raise MechanismError(
            f"{file}: the file has more than {_LARGEST / 1e6:g} MB, which are allowed for loops "
            f"beside a URDF"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise MechanismError(f"{file}: the file is not UTF-8 text") from None
