"""What an option says of itself, once: the signature of a verb, the options of its command, their
help and their messages are made from it. Options that belong together are a record, a TypedDict,
in a module that commands import for their help: what is heavy stands in quotes there, as types.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, fields, is_dataclass
from types import NoneType
from typing import Any, Literal, get_args, get_origin

from symkin.errors import InputError

GIVEN, HOW, OUTPUT = "What is given", "How it is found", "Output"
FILES, ROBOT_FILES = "Mechanism files", "Robot files"
ASKED, READINGS, POSTURES = "What is asked", "Readings and their noise", "Postures"
"""Headings of options that several commands have."""


@dataclass(frozen=True)
class Option:
    """An option: what its help says, how its value is written, the heading it stands under, its
    names on the command line where they are not its own, how a shell completes it, and in a record
    its default. Without help it is no option of a command. One that may be some words only says so
    by its type, a `Literal`, or by the `words` of the command line. What is a value of another kind
    in Python is `read` from its text, by what `cli.values` has of this name.
    """

    help: str = ""
    metavar: str | None = None
    group: str = HOW
    _: KW_ONLY
    flags: Sequence[str] = ()
    complete: Callable[[str], list[str]] | None = None
    default: Any = None
    words: Sequence[str] = ()
    read: str = ""


@dataclass(frozen=True)
class Argument(Option):
    """An argument of a command, which has a place and no name."""


def options_of(record: type) -> dict[str, tuple[Any, Option]]:
    """List the options of a record by name, with their types."""
    if is_dataclass(record):
        return {field.name: field.metadata["option"] for field in fields(record)}
    hints = record.__annotations__
    return {name: (hint.__origin__, hint.__metadata__[0]) for name, hint in hints.items()}


def words_of(kind: Any) -> tuple[str, ...]:
    """The words that a `Literal`, or one beside None, allows; none for another type."""
    kinds = get_args(kind) if NoneType in get_args(kind) else (kind,)
    return next((get_args(k) for k in kinds if get_origin(k) is Literal), ())


def check_seed(seed: int | None) -> None:
    """Refuse what NumPy's generators do not take."""
    if seed is not None and seed < 0:
        raise InputError(f"seed = {seed} is negative; whole numbers from 0 are allowed")


def refuse_ignored(options: Mapping[str, object], reason: str, instead: str = "") -> None:
    """Raise InputError for the options, by name, that are given (neither None nor False) although
    `reason` is that nothing reads them; `instead` is what to do in place of leaving them out.
    """
    names = [name for name, value in options.items() if value is not None and value is not False]
    if not names:
        return
    several = len(names) > 1
    listed = f"{', '.join(names[:-1])} and {names[-1]}" if several else names[0]
    remedy = f"leave {'them' if several else 'it'} out" + (f", or {instead}" if instead else "")
    raise InputError(
        f"{listed} {'are' if several else 'is'} given and would be ignored: {reason}; {remedy}"
    )
