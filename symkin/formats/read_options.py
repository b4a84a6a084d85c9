"""What is told beside a file: parameters of a mechanism file; of a robot kinds of closures,
actuated joints, the platform's link, arguments of xacro, packages, the model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symkin.errors import InputError
from symkin.text import shown
from symkin.verb_options import FILES, ROBOT_FILES, Option

if TYPE_CHECKING:
    from symkin.model.joint_forms import JointType

_CLOSURES: tuple[JointType, ...] = ("S", "U", "R", "C", "P", "weld")
"""Kinds that may be told; a screw takes its pitch as well, which the file must tell."""


def _told(kind: Any, read: str, *said: str, **default: Any) -> Any:
    """A field that is an option of every command that takes MECH, by what `Option` says of it: a
    text of a `kind` or several, which `cli/reading.py` reads as pairs or as words.
    """
    return field(**default, metadata={"option": (kind, Option(*said, read=read))})


@dataclass(frozen=True)
class ReadOptions:
    """What is told beside a file to `load`, `close` and `convert`: parameters of a mechanism file,
    and what the file of a robot in a format of others leaves out.

    `set`: numbers of `[parameters]`, or arithmetic, in place of the file's. `loop`: the kind of
    closures by name, R, S, C, P, U or weld, about or along the z axis of their frames; "R:x" names
    another of its axes (x, y, z). `actuated`: names of the joints that motors drive, in place of
    what the file tells. `platform`: the link (or a body that a fixed joint makes part of one) whose
    own frame is the platform frame, so that poses can be given and told; its `[platform]`.
    `arguments`: those of a file in xacro. `packages`: folders that are packages or hold them, for
    `package://NAME`, `model://NAME` and `$(find NAME)`. `model`: which model of an SDF file. Raises
    InputError, when the file is read, for what does not fit it.

    >>> import symkin
    >>> symkin.ReadOptions(loop={"closing_knee": "R:x"}, actuated=["hip"]).actuated
    ('hip',)
    """

    loop: Mapping[str, str] = _told(
        list[str],
        "pairs",
        "The kind of a closure, R, S, C, P, U or weld, about the z axis of its frames; R:x names "
        "another axis.",
        "NAME=KIND,...",
        ROBOT_FILES,
        default_factory=dict,
    )
    actuated: Sequence[str] = _told(
        list[str],
        "words",
        "The joints that motors drive, in place of what the file tells.",
        "NAME,...",
        ROBOT_FILES,
        default=(),
    )
    platform: str | None = _told(
        str,
        "",
        "The link whose frame is the platform's, so that poses can be given and are told.",
        "LINK",
        ROBOT_FILES,
        default=None,
    )
    arguments: Mapping[str, str] = _told(
        list[str],
        "pairs",
        "Arguments of a file in xacro.",
        "NAME=VALUE,...",
        ROBOT_FILES,
        default_factory=dict,
    )
    packages: Sequence[Path | str] = _told(
        list[Path],
        "",
        "A package, or a folder of packages; may be given several times.",
        "FOLDER",
        ROBOT_FILES,
        default=(),
    )
    model: str | None = _told(
        str, "", "Which model of an SDF file.", "NAME", ROBOT_FILES, default=None
    )
    set: Mapping[str, float | str] = _told(
        list[str],
        "pairs",
        "Numbers of the file's [parameters], or arithmetic, in place of its own.",
        "NAME=VALUE,...",
        FILES,
        default_factory=dict,
    )

    def __post_init__(self) -> None:
        for key in ("loop", "arguments", "set"):
            value = getattr(self, key)
            if not isinstance(value, Mapping):
                raise InputError(f"{key} = {shown(value)}; a mapping of names to values is needed")
            object.__setattr__(self, key, dict(value))
        for key in ("actuated", "packages"):
            value = getattr(self, key)
            if isinstance(value, str):
                raise InputError(f"{key} = {shown(value)} is one text; a list is needed")
            object.__setattr__(self, key, tuple(value))
        for name, kind in self.loop.items():
            closure_kind(name, kind)
        for name, what in (("model", "a model"), ("platform", "a link")):
            value = getattr(self, name)
            if isinstance(value, str) and not value.strip():
                raise InputError(f"--{name} is empty; the name of {what} is needed")

    @property
    def folders(self) -> tuple[Path, ...]:
        """The folders of packages. Raises InputError for one that is none."""
        found = tuple(Path(folder) for folder in self.packages)
        missing = next((folder for folder in found if not folder.is_dir()), None)
        if missing is not None:
            raise InputError(
                f"packages: {shown(str(missing))} is no folder; name a package, or a folder that "
                f"holds packages"
            )
        return found

    def refuse_but(self, allowed: Sequence[str], what: str, because: str) -> None:
        """Raise InputError for options that are given and mean nothing for a file; `because` says
        why.
        """
        given = [option.name for option in fields(self) if getattr(self, option.name)]
        wrong = next((key for key in given if key not in allowed), None)
        if wrong == "set":
            because = "parameters are those of a mechanism file (.toml), in its [parameters]"
        if wrong is not None:
            raise InputError(f"{wrong} (--{wrong}) has no meaning for {what}: {because}")


def closure_kind(name: str, told: str) -> tuple[JointType, str]:
    """Kind and axis of a text such as R or R:x."""
    kinds = {kind.lower(): kind for kind in _CLOSURES}
    word, colon, axis = told.strip().partition(":")
    kind = kinds.get(word.strip().lower())
    if kind is None or (colon and axis.strip().lower() not in ("x", "y", "z")):
        raise InputError(
            f"loop: {name} = {shown(told)} is no kind of closure; allowed: "
            f"{', '.join(kinds.values())}, and behind them :x, :y or :z "
            "for the axis in its frames"
        )
    if colon and kind in ("S", "weld"):
        raise InputError(
            f"loop: {name} = {shown(told)} names an axis, and {kind} has none; write {kind}"
        )
    return kind, axis.strip().lower() or "z"


AS_IT_IS = ReadOptions()
"""Nothing is told beside the file."""
