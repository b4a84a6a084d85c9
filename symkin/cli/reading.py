"""The options that tell, beside a file, how it is read: the same for every command that takes
MECH.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypedDict

from symkin.cli.streams import say
from symkin.errors import InputError
from symkin.text import first_of, shown
from symkin.verb_options import FILES, ROBOT_FILES, Option

if TYPE_CHECKING:
    from symkin.formats.read_options import ReadOptions
    from symkin.model.mechanism import Mechanism


class RobotFile(TypedDict):
    """Options that tell how a file is read: a mechanism file, and a robot's."""

    set: Annotated[
        list[str] | None,
        Option(
            "Numbers of the file's [parameters], or arithmetic, in place of its own.",
            "NAME=VALUE,...",
            FILES,
        ),
    ]
    loop: Annotated[
        list[str] | None,
        Option(
            "The kind of a closure, R, S, C, P, U or weld, about the z axis of its frames; R:x "
            "names another axis.",
            "NAME=KIND,...",
            ROBOT_FILES,
        ),
    ]
    actuated: Annotated[
        list[str] | None,
        Option(
            "The joints that motors drive, in place of what the file tells.",
            "NAME,...",
            ROBOT_FILES,
        ),
    ]
    platform: Annotated[
        str | None,
        Option(
            "The link whose frame is the platform's, so that poses can be given and are told.",
            "LINK",
            ROBOT_FILES,
        ),
    ]
    arguments: Annotated[
        list[str] | None,
        Option("Arguments of a file in xacro.", "NAME=VALUE,...", ROBOT_FILES),
    ]
    packages: Annotated[
        list[Path] | None,
        Option(
            "A package, or a folder of packages; may be given several times.",
            "FOLDER",
            ROBOT_FILES,
        ),
    ]
    model: Annotated[str | None, Option("Which model of an SDF file.", "NAME", ROBOT_FILES)]


def loaded(mech: str, read: RobotFile | None) -> "Mechanism":
    """The mechanism of a command; what is odd about a mechanism file's numbers is said on stderr,
    of a robot's file its limits.
    """
    from symkin.formats.load import is_robot, load
    from symkin.model.oddities import degrees_question, oddities

    mechanism = load(mech) if read is None else load(mech, read_options(read))
    question = degrees_question(mechanism)
    of_robot = () if question is None else (question,)
    for text in of_robot if is_robot(Path(mech)) else oddities(mechanism):
        say(f"note: {text}")
    return mechanism


def say_left_out(mechanism: "Mechanism") -> None:
    """Tell which joints of a graph are left out where the arm in it is taken alone."""
    from symkin.model.arm import joints_left_out

    names = joints_left_out(mechanism)
    if names:
        say(
            f"note: left out, as they do not move the platform link {mechanism.platform_link!r}: "
            f"{first_of(names)}"
        )


def read_options(told: RobotFile) -> "ReadOptions":
    """What is told beside a robot's file."""
    from symkin.formats.read_options import ReadOptions

    for name, what in (("model", "a model"), ("platform", "a link")):
        value = told[name]  # type: ignore[literal-required]
        if value is not None and not value.strip():
            raise InputError(f"--{name} is empty; the name of {what} is needed")
    return ReadOptions(
        loop=_pairs(told["loop"], "loop"),
        actuated=_words(told["actuated"], "actuated"),
        platform=told["platform"],
        arguments=_pairs(told["arguments"], "arguments"),
        packages=told["packages"] or (),
        model=told["model"],
        set=_pairs(told["set"], "set"),
    )


def _words(texts: Sequence[str] | None, option: str) -> list[str]:
    """The names of a list, which may be given several times."""
    words = [word.strip() for text in texts or () for word in text.split(",")]
    if "" in words:
        raise InputError(
            f"--{option} {shown(','.join(texts or ()))}: a name is empty; names separated by "
            f"commas are needed"
        )
    return words


def _pairs(texts: Sequence[str] | None, option: str) -> dict[str, str]:
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
