"""Check names of mechanisms, limbs and joints: their grammar, what other systems reserve; and make
identifiers of them.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

from symkin.errors import InputError, MechanismError
from symkin.text import code_point, one_line, refused_character, shown

LONGEST_NAME = 100
"""Characters of a name: with the endings of generated files it stays below the 255 bytes of a file
name.
"""
_INSIDE = " -+.'\"#()/\\*"
_GRAMMAR = (
    f"letters, digits and _, after the first character also spaces and {' '.join(_INSIDE[1:])}, no "
    f"space at the end"
)
_WINDOWS = re.compile(r"con|prn|aux|nul|(com|lpt)[0-9]", re.IGNORECASE)
"""Devices of Windows, which are no names of files there, whatever the suffix."""
_HEADERS = frozenset(
    [
        "assert",
        "complex",
        "ctype",
        "errno",
        "fenv",
        "float",
        "inttypes",
        "iso646",
        "limits",
        "locale",
        "math",
        "setjmp",
        "signal",
        "stdalign",
        "stdarg",
        "stdatomic",
        "stdbit",
        "stdbool",
        "stdckdint",
        "stddef",
        "stdint",
        "stdio",
        "stdlib",
        "stdnoreturn",
        "string",
        "tgmath",
        "threads",
        "time",
        "uchar",
        "wchar",
        "wctype",
    ]
)
"""Headers of standard C: a file of such a name takes the place of the compiler's."""
_CMAKE = frozenset(
    [
        "all",
        "all_build",
        "clean",
        "edit_cache",
        "example",
        "help",
        "install",
        "m",
        "package",
        "package_source",
        "preinstall",
        "rebuild_cache",
        "run_tests",
        "test",
        "zero_check",
    ]
)
"""Targets that CMake keeps for itself, those of a generated folder, and the library of
mathematics.
"""


# --- what is refused ------------------------------------------------------------------------------


def text_fault(text: object) -> str | None:
    """What is wrong with a title or a source: no text, or control and bidirectional characters
    other than line breaks and tabs.
    """
    if not isinstance(text, str):
        return "is no text"
    refused = refused_character(one_line(text))
    return (
        None
        if refused is None
        else f"holds {code_point(refused)}; control and bidirectional characters are not allowed"
    )


def name_fault(name: object) -> str | None:
    """What is wrong with the name of a limb or joint, and the grammar of names."""
    fault = _fault(name)
    return None if fault is None else f"{fault}; allowed: {_GRAMMAR}; to {LONGEST_NAME} characters"


def check_text(text: object, where: str) -> str:
    """A title or a source in one line. Raises MechanismError."""
    fault = text_fault(text)
    if fault is not None:
        raise MechanismError(f"{where} = {shown(text)} {fault}")
    return one_line(str(text))


def check_name(name: object, where: str) -> None:
    """Raises MechanismError for the name of a limb or joint outside the grammar."""
    fault = name_fault(name)
    if fault is not None:
        raise MechanismError(f"{where} = {shown(name)} {fault}")


def check_mechanism_name(name: object) -> None:
    """The name of a mechanism, which files and functions are called after: an identifier of C.
    Raises MechanismError.
    """
    if not isinstance(name, str) or not (name.isascii() and name.isidentifier()):
        raise MechanismError(
            f"name = {shown(name)} is no C identifier; allowed: letters, digits and _, no digit "
            f"first"
        )
    if len(name) > LONGEST_NAME:
        raise MechanismError(
            f"name = {shown(name)} is too long; allowed: to {LONGEST_NAME} characters"
        )
    if is_device(name):
        raise MechanismError(
            f"name = {name!r} is a device of Windows, where no file can have this name; allowed: "
            f"other names"
        )


def check_c_name(name: str) -> None:
    """Raises InputError for a mechanism's name that C code cannot begin its names with, or its
    files be called.
    """
    reason = None
    if name.startswith("_") or name.endswith("_") or "__" in name:
        reason = "makes identifiers that C and C++ reserve (a _ first, or two in a row)"
    elif name.lower() in _HEADERS:
        reason = f"would make the header {name}.h, which C has already"
    elif name.lower() == "example_main":
        reason = "is that of another file of the folder"
    if reason is not None:
        raise InputError(
            f"{name}: the mechanism's name begins all names of generated C, and this one {reason}; "
            f"rename the mechanism"
        )


def is_device(name: str) -> bool:
    """Whether Windows takes a file of this name for a device."""
    return _WINDOWS.fullmatch(name.partition(".")[0].rstrip(" ")) is not None


def _fault(name: object) -> str | None:
    """What is wrong with a name."""
    if not isinstance(name, str):
        return "is no text"
    if not name:
        return "is an empty name"
    if len(name) > LONGEST_NAME:
        return "is too long"
    wrong = next((c for c in name if not (_in_word(c) or c in _INSIDE)), None)
    if wrong is not None:
        return (
            f"holds "
            f"{code_point(wrong) if refused_character(wrong) or wrong.isspace() else repr(wrong)}"
        )
    if not _begins(name[0]):
        return f"begins with {name[0]!r}"
    if name.endswith(" "):
        return "ends with a space"
    return None


def _begins(c: str) -> bool:
    """Letters and digits of any script, and _."""
    return c == "_" or unicodedata.category(c)[0] in "LN"


def _in_word(c: str) -> bool:
    """What words of any script are made of: letters, digits, their marks, and _."""
    return _begins(c) or unicodedata.category(c) in ("Mn", "Mc")


# --- identifiers ----------------------------------------------------------------------------------


def identifier(name: str) -> str:
    """ASCII letters, digits and single _, a letter first: what C, C++, NumPy and SymPy take after
    any beginning.
    """
    stem = re.sub(r"[^0-9A-Za-z]+", "_", name).strip("_")
    return stem if stem[:1].isalpha() else f"q_{stem}".rstrip("_")


def identifiers(names: Sequence[str]) -> list[str]:
    """An identifier for each name, all different; `leg1.base.x` becomes leg1_base_x."""
    found: dict[str, None] = {}
    for name in names:
        stem = text = identifier(name)
        number = 2
        while text in found:
            text, number = f"{stem}_{number}", number + 1
        found[text] = None
    return list(found)


def cmake_target(name: str) -> str:
    """The library's target: the mechanism's name, or where CMake keeps that for itself one made
    from it.
    """
    return f"{name}_kinematics" if name.lower() in _CMAKE else name
