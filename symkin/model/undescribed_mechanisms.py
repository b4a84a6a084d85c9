"""Recognise mechanisms that the file format does not describe yet by the keys with which a file asks for them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

_GRAPH = (
    "links that are joined in other ways than limbs (loops within a limb, stages, linkages without a platform) are not described "
    "by this version; it describes limbs of joints from the base to one platform, which may end in rods ([[limb.rod]]: two of them "
    "make a parallelogram), rod limbs, and serial arms"
)
_COUPLING = (
    "joints that gears, belts or other couplings tie are not described by this version; mark each of them `actuated = true` and "
    "give the coupled values together"
)
_ROD = (
    "rods between any two links are not described by this version; from the base to the platform use a rod limb (type, base, "
    "platform), at the end of a limb [[limb.rod]]"
)
_PLATFORMS = (
    "several platforms are not described by this version; it describes one platform a file: leave the others out, or write a file "
    "for each platform with the limbs that hold it"
)
_KEYS = {
    **dict.fromkeys(("link", "links", "loop", "loops", "child", "parent"), _GRAPH),
    **dict.fromkeys(("coupling", "couplings", "gear", "gears", "belt", "mimic", "ratio"), _COUPLING),
    **dict.fromkeys(("platforms", "platform2", "stage"), _PLATFORMS),
}
"""Keys that no table of the format has, with what they ask for and what to write in its place."""
_TOP_KEYS = {"rod": _ROD, "rods": _ROD}
"""The same for keys at the top of a file, which tables below may have."""
JOINT_TYPES = {
    **dict.fromkeys(("weld", "fixed", "rigid"), "a joint that does not move is left out: its two links are one"),
    **dict.fromkeys(("Pa", "parallelogram"), "a parallelogram is a limb that ends in two rods ([[limb.rod]])"),
    **dict.fromkeys(("G", "gear", "belt"), _COUPLING),
    "E": "a planar joint is written as two P joints and an R joint",
}
"""Names of joints that the format has not, with what to write in their place."""
ACTUATED = {
    "U": "write it as two R joints at one point",
    "C": "write it as an R and a P joint along one axis",
    "S": "write it as three R joints whose axes meet in a point",
}
"""How joints of several freedoms are written where some of these are actuated."""

_DEEPEST = 6
"""Keys and numbers on the way to the deepest table of the format are fewer."""


def class_not_described(data: dict[str, Any]) -> tuple[tuple[str | int, ...], str] | None:
    """The first key path of a file that asks for a class of mechanism which the format does not describe, and a sentence that
    says so and what to use; None where there is none."""
    for keys, value in _entries(data, ()):
        last = keys[-1]
        if last == "platform" and len(keys) == 1 and isinstance(value, list):
            return keys, _PLATFORMS
        found = _KEYS.get(str(last)) or (_TOP_KEYS.get(str(last)) if len(keys) == 1 else None)
        if found is not None:
            return keys, found
        if keys[:1] == ("limb",) and last == "limb" and len(keys) > 1:
            return keys, _GRAPH
    return None


def is_second_platform(reason: str) -> bool:
    """Whether a TOML reader's complaint is about a second [platform]."""
    return "'platform'" in reason and "twice" in reason


def second_platform() -> str:
    return f"[platform] stands twice: {_PLATFORMS}"


def _entries(node: Any, path: tuple[str | int, ...]) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Keys of tables with their values, each table's own before those below it, as deep as the format's tables are."""
    if len(path) > _DEEPEST:
        return
    if isinstance(node, dict):
        for key, value in node.items():
            yield (*path, key), value
        for key, value in node.items():
            yield from _entries(value, (*path, key))
    elif isinstance(node, list):
        for k, value in enumerate(node):
            yield from _entries(value, (*path, k))
