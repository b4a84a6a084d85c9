"""What a command asks: the mechanism, and the values of a verb's options, read from their texts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from symkin.cli.options import (
    joints_from,
    limits_from,
    named_from,
    names_from,
    numbers_from,
    pairs_from,
    ranges_from,
    slices_from,
    whole_numbers,
)
from symkin.cli.pictures import Drawing
from symkin.cli.poses import UNTOLD, PoseForm, PoseReader
from symkin.cli.reading import loaded
from symkin.formats.read_options import ReadOptions
from symkin.verb_options import options_of

if TYPE_CHECKING:
    from symkin.model.mechanism import Mechanism


def _angle_pairs(reader: PoseReader, text: str, option: str) -> Any:
    from symkin.cli.quantities import angle_pairs

    return angle_pairs(text, reader.mechanism, option)


READ: dict[str, Callable[[PoseReader, Any, str], Any]] = {
    "joints": lambda reader, text, option: joints_from(text, option, reader.unit),
    "numbers": lambda reader, text, option: numbers_from(text, option, reader.unit),
    "pose": lambda reader, text, option: reader.pose(text, option),
    "given": lambda reader, text, _: reader.given(text),
    "named": lambda reader, text, option: named_from(text, option, reader.unit),
    "ranges": lambda reader, text, _: ranges_from(text, "range", reader.unit, "NAME=LOW:HIGH,..."),
    "window": lambda reader, text, _: pairs_from(
        text, "range", reader.unit, "U0:U1,V0:V1, such as -100:100,-50:50,"
    ),
    "limits": lambda reader, text, option: limits_from(text, option, reader.unit),
    "slices": lambda reader, text, _: slices_from(text, reader.unit),
    "angle pairs": _angle_pairs,
    "names": lambda _, text, __: names_from(text or None),
    "whole numbers": lambda _, text, option: whole_numbers(text, option),
}
"""How the text of an option becomes a value, by what `Option.read` says."""


@dataclass(frozen=True)
class Asked:
    """A mechanism with the way its poses are written, and where its picture goes."""

    mechanism: Mechanism
    reader: PoseReader
    drawing: Drawing

    @classmethod
    def of(
        cls,
        mech: str,
        read: ReadOptions,
        form: PoseForm = UNTOLD,
        picture: Mapping[str, Any] | None = None,
    ) -> Asked:
        """Load the mechanism, and check the picture before the work."""
        mechanism = loaded(mech, read)
        reader = PoseReader(mechanism, **form)
        return cls(mechanism, reader, Drawing.checked(picture or {"plot": None}, mechanism))

    @property
    def unit(self) -> str:
        """The unit of angles."""
        return self.mechanism.angle_unit

    def values(self, record: type, told: Mapping[str, Any], *poses: str) -> dict[str, Any]:
        """The values of a record's options that are given; `poses` are those in which a pose may
        stand, one of which --euler needs.
        """
        if poses:
            self.reader.check_used(*(told[name] for name in poses))
        found = {}
        for name, (_, option) in options_of(record).items():
            if option.read == "start":
                is_pose = told.get("pose") is None
                found[name] = self.reader.start(told[name], is_pose=is_pose)
            elif option.read and (told[name] is not None or option.read == "pose"):
                flag = name.replace("_", "-")
                found[name] = READ[option.read](self.reader, told[name], flag)
            elif option.help and not option.read:
                found[name] = told[name]
        return {name: value for name, value in found.items() if value is not None}
