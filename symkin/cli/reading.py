"""How the file of a mechanism is read: the same for every command that takes MECH."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symkin.cli.streams import say
from symkin.errors import InputError
from symkin.text import first_of, shown
from symkin.verb_options import options_of

if TYPE_CHECKING:
    from symkin.formats.read_options import ReadOptions
    from symkin.model.mechanism import Mechanism


def loaded(mech: str, read: "ReadOptions | None") -> "Mechanism":
    """The mechanism of a command; what is odd about a mechanism file's numbers is said on stderr,
    of a robot's file its limits.
    """
    from symkin.formats.load import is_robot, load
    from symkin.formats.read_options import AS_IT_IS
    from symkin.model.oddities import degrees_question, oddities

    mechanism = load(mech, read or AS_IT_IS)
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


def record_of(record: Any, told: Mapping[str, Any]) -> Any:
    """The record of options that are values themselves, of their texts."""
    return record(
        **{
            name: _READ[option.read](told[name], name) if option.read else told[name]
            for name, (_, option) in options_of(record).items()
            if told[name] not in (None, ())
        }
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


_READ = {"pairs": _pairs, "words": _words}
"""How texts are read, by what `Option.read` says."""
