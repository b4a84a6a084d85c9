"""Arguments and options that commands share, and how they read numbers, print results and show
progress.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from enum import StrEnum
from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from symkin.cli.completion import mechanism_names
from symkin.cli.help import GIVEN, HOW, OUTPUT
from symkin.cli.streams import print_text
from symkin.errors import InputError
from symkin.model.written_number import whole, written_number
from symkin.text import not_among, shown
from symkin.verb_options import Option


def whole_number(text: str) -> int:
    """An integer option, refused with its value."""
    number = whole(str(text))  # Typer passes defaults through here too
    if number is None:
        raise InputError(
            f"{shown(text)} is not a whole number; --starts, --seed and other counts take whole "
            f"numbers from 0"
        )
    return number


def whole_numbers(text: str | None, option: str) -> list[int]:
    """The numbers of an option that is a list of whole ones; none where it is not given."""
    if text is None:
        return []
    numbers = [whole(part.strip()) for part in text.split(",")]
    if None in numbers:
        raise InputError(
            f"--{option} {shown(text)}: whole numbers from 0, separated by commas, are needed"
        )
    return [number for number in numbers if number is not None]


def choice(kind: type[StrEnum], option: str, text: str, group: str) -> Any:
    """An option whose values are those of `kind`; others are refused with the nearest one."""
    values = [str(value) for value in kind]

    def chosen(word: str) -> StrEnum:
        if word not in values:
            raise InputError(f"{option} {not_among(str(word), values)}")
        return kind(word)

    def complete(incomplete: str) -> list[str]:
        return [value for value in values if value.startswith(incomplete)]

    return typer.Option(
        option,
        metavar="|".join(values),
        parser=chosen,
        autocompletion=complete,
        help=text,
        rich_help_panel=group,
    )


def record_options(record: type) -> list[Parameter]:
    """The options of a verb's record that have help, and those of a command's own record, which are
    none by default.
    """
    found = []
    for name, hint in get_type_hints(record, include_extras=True).items():
        told = hint.__metadata__[0]
        if not isinstance(told, Option):
            found.append(Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=hint))
        elif told.help:
            kind = _annotated(name, hint.__origin__, told)
            found.append(
                Parameter(name, Parameter.KEYWORD_ONLY, default=told.default, annotation=kind)
            )
    return found


def _annotated(name: str, kind: Any, option: Option) -> Any:
    flag, text = f"--{name.replace('_', '-')}", option.help
    if option.words:
        make: Callable[..., Any] = StrEnum
        words = make("words", {word: word.replace(" ", "-") for word in option.words})
        return Annotated[words, choice(words, flag, text, HOW)]
    read = whole_number if kind is int else None
    told = typer.Option(flag, metavar=option.metavar, parser=read, help=text, rich_help_panel=HOW)
    return Annotated[kind if kind in (bool, int) else str | None, told]


MechArgument = Annotated[
    str,
    typer.Argument(
        metavar="MECH",
        autocompletion=mechanism_names,
        help="A name from `symkin list`, or a path to a .toml, .xml (MJCF, needs pip install "
        "'symkin[mjcf]'), .urdf, .xacro (needs "
        "'symkin[urdf]', as do loops in YAML beside a .urdf) or .sdf file.",
    ),
]
JointsOption = Annotated[
    str | None,
    typer.Option(
        metavar="V1,V2,...",
        help=(
            "All actuated joints, in file order or as NAME=VALUE,..., in the file's units: the "
            "direct problem."
        ),
        rich_help_panel=GIVEN,
    ),
]
PoseOption = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y,Z,QW,QX,QY,QZ",
        help="The platform's or tool's pose: the inverse problem.",
        rich_help_panel=GIVEN,
    ),
]
GivenOption = Annotated[
    str | None,
    typer.Option(
        metavar="NAME=VALUE,...",
        help="Any coordinates, as many as the mobility: joints, passive ones too, and x, y, z, "
        "azimuth, tilt, torsion of the "
        "platform, or pose=X,Y,Z,QW,QX,QY,QZ.",
        rich_help_panel=GIVEN,
    ),
]
StartOption = Annotated[
    str | None,
    typer.Option(
        metavar="V1,V2,...",
        help=(
            "A pose for the direct problem, all actuated joints for the inverse one; "
            "NAME=VALUE,... with --given and for graphs."
        ),
        rich_help_panel=HOW,
    ),
]
SeedOption = Annotated[
    int,
    typer.Option(
        metavar="N", parser=whole_number, help="Seed of random numbers.", rich_help_panel=HOW
    ),
]
SearchSeedOption = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        parser=whole_number,
        help="Seed of the random starts. Default: 0.",
        rich_help_panel=HOW,
    ),
]
JsonOption = Annotated[
    bool,
    typer.Option(
        "--json", help="Write one JSON object to stdout and nothing else.", rich_help_panel=OUTPUT
    ),
]


AllOption = Annotated[
    bool,
    typer.Option(
        "--all", help="Passive joints and named points in the table too.", rich_help_panel=OUTPUT
    ),
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
        _number(part, f"value {k}", what, angle_unit)
        for k, part in enumerate(text.split(","), start=1)
    ]


def joints_from(
    text: str | None, what: str, angle_unit: str
) -> list[float] | dict[str, float] | None:
    """Numbers as `numbers_from`, or numbers by name from `leg1=400,leg2=420`."""
    if text is None or "=" not in text:
        return numbers_from(text, what, angle_unit)
    found: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not name or not equals:
            raise InputError(
                f"--{what}: {shown(part.strip())} has no name; either every value has one "
                f"(NAME=VALUE,...) or none"
            )
        if name in found:
            raise InputError(f"--{what}: {shown(name)} is given twice")
        found[name] = _number(value, name, what, angle_unit)
    return found


def named_from(
    text: str | None, what: str, angle_unit: str
) -> dict[str, float | list[float]] | None:
    """Values by name from `crank=60,pose=0,0,100,1,0,0,0`: what follows a name up to the next one
    is its value.
    """
    if text is None:
        return None
    found: dict[str, list[float]] = {}
    name = ""
    for part in text.split(",") if text.strip() else []:
        before, equals, after = (piece.strip() for piece in part.partition("="))
        if equals:
            name = before
            if not name:
                raise InputError(
                    f"--{what}: {shown(part.strip())} has no name; values are written "
                    f"NAME=VALUE,..."
                )
            if name in found:
                raise InputError(f"--{what}: {shown(name)} is given twice")
            found[name] = []
        elif not name or name != "pose":
            raise InputError(
                f"--{what}: {shown(part.strip())} has no name; values are written NAME=VALUE,..."
            )
        found[name].append(_number(after if equals else before, name, what, angle_unit))
    return {
        name: values if name == "pose" and len(values) > 1 else values[0]
        for name, values in found.items()
    }


def start_from(
    text: str | None, angle_unit: str
) -> list[float] | dict[str, float | list[float]] | None:
    """A start: numbers, or values by name."""
    return (
        named_from(text, "start", angle_unit)
        if text is not None and "=" in text
        else numbers_from(text, "start", angle_unit)
    )


def _number(text: str, which: str, what: str, angle_unit: str) -> float:
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
    if output.is_dir() or not output.resolve().parent.is_dir():
        raise InputError(
            f"-o: {str(output)!r} is a folder, or its folder does not exist; the name of a file is "
            f"needed"
        )
    if any(
        given is not None and Path(given).exists() and Path(given).resolve() == output.resolve()
        for given in inputs
    ):
        raise InputError(f"-o: {str(output)!r} is read by this command; give another name")
    if ".toml" in (output.suffix.lower(), output.resolve().suffix.lower()):
        raise InputError(
            f"-o: {str(output)!r} is the name of a mechanism file; give another suffix"
        )


def print_result(
    as_json: bool, to_dict: Callable[[], dict[str, Any]], to_text: Callable[[], str]
) -> None:
    """One JSON object, or the text for people."""
    print(json.dumps(to_dict(), allow_nan=False)) if as_json else print_text(to_text())
