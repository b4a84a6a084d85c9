"""Arguments and options that commands share, and how they read numbers, print results and show progress."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from symkin.errors import InputError
from symkin.model.written_number import whole, written_number
from symkin.text import shown


def whole_number(text: str) -> int:
    """An integer option, refused with its value."""
    number = whole(str(text))  # Typer passes defaults through here too
    if number is None:
        raise InputError(f"{shown(text)} is not a whole number; --starts, --seed and other counts take whole numbers from 0")
    return number


MechArgument = Annotated[str, typer.Argument(metavar="MECH", help="A name from `symkin list`, or a path to a .toml file.")]
JointsOption = Annotated[
    str | None,
    typer.Option(metavar="V1,V2,...", help="All actuated joints, in file order and the file's units: the direct problem."),
]
PoseOption = Annotated[
    str | None, typer.Option(metavar="X,Y,Z,QW,QX,QY,QZ", help="The platform's or tool's pose: the inverse problem.")
]
StartOption = Annotated[
    str | None,
    typer.Option(metavar="V1,V2,...", help="A pose for the direct problem, all actuated joints for the inverse one."),
]
SeedOption = Annotated[int, typer.Option(metavar="N", parser=whole_number, help="Seed of random numbers.")]
SearchSeedOption = Annotated[
    int | None, typer.Option(metavar="N", parser=whole_number, help="Seed of the random starts. Default: 0.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Write one JSON object to stdout and nothing else.")]


class Interrupted(Exception):  # noqa: N818 - no error: the user's wish
    """Ctrl-C in a command whose work is not lost; the text says what is kept."""


def numbers_from(text: str | None, what: str, angle_unit: str) -> list[float] | None:
    """Numbers, or arithmetic, from a comma-separated list; None stays None. sin, cos and tan take `angle_unit`."""
    if text is None:
        return None
    if not text.strip():
        raise InputError(f"--{what} is empty; numbers separated by commas are needed")
    numbers = []
    for k, part in enumerate(text.split(","), start=1):
        try:
            numbers.append(written_number(part, angle_unit))
        except InputError as error:
            raise InputError(f"--{what}: value {k} = {error}; values are separated by commas") from None
    return numbers


def check_output(output: Path | None, *inputs: Path | str | None) -> None:
    """Refuse, before a long computation, an output that cannot be written or would replace what is read."""
    if output is None:
        return
    if output.is_dir() or not output.resolve().parent.is_dir():
        raise InputError(f"-o: {str(output)!r} is a folder, or its folder does not exist; the name of a file is needed")
    if any(given is not None and Path(given).exists() and Path(given).resolve() == output.resolve() for given in inputs):
        raise InputError(f"-o: {str(output)!r} is read by this command; give another name")
    if ".toml" in (output.suffix, output.resolve().suffix):
        raise InputError(f"-o: {str(output)!r} is the name of a mechanism file; give another suffix")


def print_result(as_json: bool, to_dict: Callable[[], dict[str, Any]], to_text: Callable[[], str]) -> None:
    """One JSON object, or the text for people."""
    print(json.dumps(to_dict(), allow_nan=False) if as_json else to_text())
