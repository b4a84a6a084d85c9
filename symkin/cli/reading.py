"""The options that tell, beside a robot's file, how it is read: the same for every command that
takes MECH.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints, is_typeddict

import typer

from symkin.cli.help import ROBOT_FILES
from symkin.cli.options import record_options
from symkin.cli.streams import say
from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions
from symkin.text import first_of, shown

if TYPE_CHECKING:
    from symkin.model.mechanism import Mechanism

LoopOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME=KIND,...",
        help=(
            "The kind of a closure, R, S, C, P, U or weld, about the z axis of its frames; R:x "
            "names another axis."
        ),
        rich_help_panel=ROBOT_FILES,
    ),
]
ActuatedOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME,...",
        help="The joints that motors drive, in place of what the file tells.",
        rich_help_panel=ROBOT_FILES,
    ),
]
PlatformOption = Annotated[
    str | None,
    typer.Option(
        metavar="LINK",
        help="The link whose frame is the platform's, so that poses can be given and are told.",
        rich_help_panel=ROBOT_FILES,
    ),
]
ArgumentsOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME=VALUE,...", help="Arguments of a file in xacro.", rich_help_panel=ROBOT_FILES
    ),
]
PackagesOption = Annotated[
    list[Path] | None,
    typer.Option(
        metavar="FOLDER",
        help="A package, or a folder of packages; may be given several times.",
        rich_help_panel=ROBOT_FILES,
    ),
]
ModelOption = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Which model of an SDF file.", rich_help_panel=ROBOT_FILES),
]
_OPTIONS: dict[str, Any] = {
    "loop": LoopOption,
    "actuated": ActuatedOption,
    "platform": PlatformOption,
    "arguments": ArgumentsOption,
    "packages": PackagesOption,
    "model": ModelOption,
}


def reads_robots(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of how a robot's file is read; they reach it as `read`, a
    `ReadOptions`. Options of a record (a TypedDict) stand in the place of the parameter whose type
    it is, and reach it as one.
    """
    own, hints = inspect.signature(command).parameters, get_type_hints(command, include_extras=True)
    if "read" not in own:
        raise TypeError(f"{command.__name__} has no parameter `read`")
    records = {name: record_options(hints[name]) for name in own if is_typeddict(hints[name])}

    def with_options(*values: Any, **named: Any) -> Any:
        told = {key: named.pop(key) for key in _OPTIONS}
        for name, options in records.items():
            named[name] = {p.name: _word(named.pop(p.name)) for p in options}
        return command(*values, read=_read_options(**told), **named)

    kept: list[inspect.Parameter] = []
    for name, p in own.items():
        if name != "read":
            kept += records.get(name, [p.replace(annotation=hints[name], kind=p.KEYWORD_ONLY)])
    added = [
        inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kind)
        for key, kind in _OPTIONS.items()
    ]
    with_options.__name__, with_options.__doc__ = command.__name__, command.__doc__
    with_options.__annotations__ = {p.name: p.annotation for p in (*kept, *added)}
    with_options.__signature__ = inspect.Signature([*kept, *added])  # type: ignore[attr-defined]
    return with_options


def _word(value: Any) -> Any:
    """The word that a choice stands for."""
    return value.name if isinstance(value, StrEnum) else value


def loaded(mech: str, read: ReadOptions) -> Mechanism:
    """The mechanism of a command; what is odd about a mechanism file's numbers is said on stderr,
    of a robot's file its limits.
    """
    from symkin.formats.load import is_robot, load
    from symkin.model.oddities import degrees_question, oddities

    mechanism = load(mech, read)
    question = degrees_question(mechanism)
    of_robot = () if question is None else (question,)
    for text in of_robot if is_robot(Path(mech)) else oddities(mechanism):
        say(f"note: {text}")
    return mechanism


def say_left_out(mechanism: Mechanism) -> None:
    """Tell which joints of a graph are left out where the arm in it is taken alone."""
    from symkin.model.arm import joints_left_out

    names = joints_left_out(mechanism)
    if names:
        say(
            f"note: left out, as they do not move the platform link {mechanism.platform_link!r}: "
            f"{first_of(names)}"
        )


def _read_options(
    loop: list[str] | None,
    actuated: list[str] | None,
    platform: str | None,
    arguments: list[str] | None,
    packages: list[Path] | None,
    model: str | None,
) -> ReadOptions:
    if model is not None and not model.strip():
        raise InputError("--model is empty; the name of a model is needed")
    if platform is not None and not platform.strip():
        raise InputError("--platform is empty; the name of a link is needed")
    return ReadOptions(
        loop=_pairs(loop, "loop"),
        actuated=_words(actuated, "actuated"),
        platform=platform,
        arguments=_pairs(arguments, "arguments"),
        packages=packages or (),
        model=model,
    )


def _words(texts: list[str] | None, option: str) -> list[str]:
    """The names of a list, which may be given several times."""
    words = [word.strip() for text in texts or () for word in text.split(",")]
    if "" in words:
        raise InputError(
            f"--{option} {shown(','.join(texts or ()))}: a name is empty; names separated by "
            f"commas are needed"
        )
    return words


def _pairs(texts: list[str] | None, option: str) -> dict[str, str]:
    """Values by name."""
    found: dict[str, str] = {}
    for word in _words(texts, option):
        name, equals, value = (part.strip() for part in word.partition("="))
        if not name or not equals:
            raise InputError(f"--{option}: {shown(word)} is no NAME=VALUE")
        if name in found:
            raise InputError(f"--{option}: {shown(name)} is given twice")
        found[name] = value
    return found
