"""Arguments and options that commands share, and how they read numbers, print results and show
progress.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

from symkin.cli.completion import mechanism_names
from symkin.cli.streams import print_text
from symkin.errors import InputError
from symkin.model.written_number import whole, written_number
from symkin.result import Result
from symkin.text import shown
from symkin.verb_options import OUTPUT, Argument, Option


def whole_numbers(text: str, option: str) -> list[int]:
    """The numbers of an option that is a list of whole ones."""
    numbers = [whole(part.strip()) for part in text.split(",")]
    if None in numbers:
        raise InputError(
            f"--{option} {shown(text)}: whole numbers from 0, separated by commas, are needed"
        )
    return [number for number in numbers if number is not None]


def output_option(text: str, metavar: str) -> Option:
    """The option of what a command writes."""
    return Option(text, metavar, OUTPUT, flags=("-o", "--output"))


MechArgument = Annotated[
    str,
    Argument(
        "A name from `symkin list`, or a path to a .toml, .xml (MJCF, needs pip install "
        "'symkin[mjcf]'), .urdf, .xacro (needs "
        "'symkin[urdf]', as do loops in YAML beside a .urdf) or .sdf file.",
        "MECH",
        complete=mechanism_names,
    ),
]
FolderOption = Annotated[Path, output_option("Folder to write.", "DIR")]
JsonOption = Annotated[
    bool,
    Option("Write one JSON object to stdout and nothing else.", group=OUTPUT, flags=("--json",)),
]


AllOption = Annotated[
    bool,
    Option("Passive joints and named points in the table too.", group=OUTPUT, flags=("--all",)),
]


_WITH_UNIT = re.compile(r"[-+\d.eE]+\s*(mm|cm|m|um|in|deg|rad|mrad|°)")


class Interrupted(Exception):  # noqa: N818 - no error: the user's wish
    """Ctrl-C in a command whose work is not lost; the text says what is kept."""


def numbers_from(text: str | None, what: str, angle_unit: str) -> list[float] | None:
    """Numbers, or arithmetic, from a comma-separated list; None stays None. sin, cos and tan take
    `angle_unit`.
    """
    if text is None:
        return None
    if not text.strip():
        raise InputError(f"--{what} is empty; numbers separated by commas are needed")
    return [
        number(part, f"value {k}", what, angle_unit)
        for k, part in enumerate(text.split(","), start=1)
    ]


def joints_from(
    text: str | None, what: str, angle_unit: str, *, whole_pose: bool = False
) -> list[float] | dict[str, Any] | None:
    """Numbers as `numbers_from`, or numbers by name from `leg1=400,leg2=420`, with `whole_pose` of
    a pose seven.
    """
    if text is None or "=" not in text:
        return numbers_from(text, what, angle_unit)
    wrong = "has no name; either every value has one (NAME=VALUE,...) or none"
    return named_from(text, what, angle_unit, wrong, whole_pose=whole_pose)


def pieces_from(
    text: str, what: str, wrong: str, *, whole_pose: bool = True
) -> dict[str, list[str]]:
    """What stands after each name, up to the next one: one piece, of a whole pose seven. `wrong` is
    what is said of a piece without a name.
    """
    found: dict[str, list[str]] = {}
    name = ""
    for part in text.split(","):
        before, equals, after = (piece.strip() for piece in part.partition("="))
        if not equals and whole_pose and name == "pose":
            found[name].append(before)
            continue
        name = before
        if not equals or not name:
            raise InputError(f"--{what}: {shown(part.strip())} {wrong}")
        if name in found:
            raise InputError(f"--{what}: {shown(name)} is given twice")
        found[name] = [after]
    return found


def named_from(
    text: str,
    what: str,
    angle_unit: str,
    wrong: str = "has no name; values are written NAME=VALUE,...",
    *,
    whole_pose: bool = True,
) -> dict[str, Any]:
    """Values by name from `crank=60,pose=0,0,100,1,0,0,0`: what follows a name up to the next one
    is its value.
    """
    pieces = pieces_from(text, what, wrong, whole_pose=whole_pose) if text.strip() else {}
    found = {name: [number(p, name, what, angle_unit) for p in own] for name, own in pieces.items()}
    return {name: values if len(values) > 1 else values[0] for name, values in found.items()}


def slices_from(text: str, angle_unit: str) -> dict[str, float]:
    """Where --slice cuts: names with one value each."""
    wrong = "is not of the form NAME=VALUE"
    return named_from(text, "slice", angle_unit, wrong, whole_pose=False)


def names_from(text: str | None) -> list[str]:
    """Names that commas part."""
    return [] if text is None else [name.strip() for name in text.split(",")]


def ranges_from(
    text: str, what: str, angle_unit: str, needed: str, counts: Sequence[int] = (2,)
) -> dict[str, list[float]]:
    """Values by name from `crank=0:360,lift=5`, of each as many as `counts` allows; `needed` is how
    they are written.
    """
    found: dict[str, list[float]] = {}
    for part in text.split(","):
        name, equals, ends = (piece.strip() for piece in part.partition("="))
        values = _ends(ends, equals and name, part, f"--{what}", needed, counts)
        if name in found:
            raise InputError(f"--{what}: {shown(name)} is given twice")
        found[name] = [number(value, name, what, angle_unit) for value in values]
    return found


def pairs_from(
    text: str, what: str, angle_unit: str, needed: str, counts: Sequence[int] = (2,)
) -> list[list[float]]:
    """Values in places, from `-5:5,0:10`, as `ranges_from` reads them by name."""
    return [
        [
            number(value, f"value {k}", what, angle_unit)
            for value in _ends(part, "=", part, f"--{what}", needed, counts)
        ]
        for k, part in enumerate(text.split(","), start=1)
    ]


def _ends(
    text: str, given: str, part: str, option: str, needed: str, counts: Sequence[int]
) -> list[str]:
    """The values that colons part, none where nothing is `given`, as many as are allowed."""
    values = [value.strip() for value in text.split(":")] if given else []
    if len(values) not in counts or not all(values) or not part.partition("=")[0].strip():
        raise InputError(f"{option}: {shown(part.strip())} is no range; {needed} is needed")
    return values


def limits_from(text: str, what: str, angle_unit: str) -> list[Any]:
    """A number, or a pair LOW:HIGH, for each motor, or one number for all."""
    parts = pairs_from(text, what, angle_unit, "a number, or LOW:HIGH,", (1, 2))
    pairs = [[-part[0], part[0]] if len(part) == 1 else part for part in parts]
    return pairs if len(pairs) > 1 or len(parts[0]) > 1 else [parts[0][0]]


def number(text: str, which: str, what: str, angle_unit: str) -> float:
    try:
        return written_number(text, angle_unit)
    except InputError as error:
        raise InputError(f"--{what}: {which} = {error}; {_hint(text.strip())}") from None


def _hint(text: str) -> str:
    """What may be meant by a text that is no number."""
    if _WITH_UNIT.fullmatch(text):
        return "write it without a unit: values are in the file's units"
    if "=" in text:
        return "these values have no names"
    if ":" in text:
        return "a name and its value are written NAME=VALUE, values are separated by commas"
    return "values are separated by commas"


def check_output(output: Path | None, *inputs: Path | str | None) -> None:
    """Refuse, before a long computation, an output that cannot be written or would replace what is
    read.
    """
    if output is None:
        return
    from symkin.files.outputs import check_place

    check_place(output, *inputs)
    if ".toml" in (output.suffix.lower(), output.resolve().suffix.lower()):
        raise InputError(
            f"output {str(output)!r} is the name of a mechanism file; give another suffix"
        )


def print_result(as_json: bool, found: Result, more: str = "", **shown: Any) -> None:
    """A result as JSON, or its summary of what is to be shown, with lines below it."""
    print_either(as_json, found.to_dict, lambda: found.summary(**shown).text() + more)


def print_either(
    as_json: bool, to_dict: Callable[[], dict[str, Any]], to_text: Callable[[], str]
) -> None:
    """One JSON object, or the text for people."""
    print(json.dumps(to_dict(), allow_nan=False)) if as_json else print_text(to_text())
