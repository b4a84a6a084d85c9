"""Recognise keys of other formats in a mechanism file, and say how the format writes what they ask
for.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

_LINKS = (
    'a joint says which links it joins by links = ["first", "second"] ("base" is fixed), and any '
    "number of loops may follow from that; "
    "loops have no table of their own"
)
_COUPLING = (
    "gears, belts and other ties between joints are written as [[coupling]] with joint, of and "
    "offset: "
    'joint = "finger2", of = { finger1 = -1.0 }'
)
_PLATFORMS = (
    "one link of a file has a pose that is given and told, the one that [platform] names; other "
    "links are told of by "
    "points ([[link]] with points)"
)
_KEYS = {
    **dict.fromkeys(("loop", "loops", "child", "parent"), _LINKS),
    **dict.fromkeys(("couplings", "gear", "gears", "belt", "mimic", "ratio"), _COUPLING),
    **dict.fromkeys(("platforms", "platform2", "stage"), _PLATFORMS),
}
"""Keys that no table of the format has, with what they ask for and what to write in its place."""
JOINT_TYPES = {
    **dict.fromkeys(
        ("fixed", "rigid", "weld"),
        "a joint that does not move is a weld between links ([[joint]] with links); in a limb it "
        "is left out",
    ),
    **dict.fromkeys(
        ("Pa", "parallelogram"),
        "a parallelogram is two rods ([[rod]], or [[limb.rod]] at the end of a limb)",
    ),
    **dict.fromkeys(("G", "gear", "belt"), _COUPLING),
    "E": "a planar joint is written as two P joints and an R joint",
    **dict.fromkeys(("revolute", "continuous", "hinge", "rotary"), "R"),
    **dict.fromkeys(("prismatic", "slide", "slider", "linear"), "P"),
    **dict.fromkeys(("helical", "screw"), "H"),
    "cylindrical": "C",
    **dict.fromkeys(("universal", "cardan"), "U"),
    **dict.fromkeys(("spherical", "ball"), "S"),
}
"""Names of joints that the format has not, with the word or what else to write in their place."""
LINKS_IN_A_LIMB = (
    "joints of a limb follow each other, from link to link; a joint between two named links stands "
    "at the top of the file, as [[joint]]"
)
_DEEPEST = 6
"""Keys and numbers on the way to the deepest table of the format are fewer."""


def foreign_key(data: dict[str, Any]) -> tuple[tuple[str | int, ...], str] | None:
    """The first key path of a file that belongs to another format, and a sentence that says what to
    use; None where there is none.
    """
    for keys, value in _entries(data, ()):
        last = keys[-1]
        if last == "platform" and len(keys) == 1 and isinstance(value, list):
            return keys, _PLATFORMS
        # names of points, of coupled joints and of parameters are the user's own
        if str(last) in _KEYS and not {"points", "of", "parameters"} & set(keys):
            return keys, _KEYS[str(last)]
    return None


def is_second_platform(reason: str) -> bool:
    """Whether a TOML reader's complaint is about a second [platform]."""
    return "'platform'" in reason and "twice" in reason


def second_platform() -> str:
    return f"[platform] stands twice: {_PLATFORMS}"


def _entries(node: Any, path: tuple[str | int, ...]) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Keys of tables with their values, each table's own before those below it, as deep as the
    format's tables are.
    """
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
