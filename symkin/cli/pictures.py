"""The picture of a command: its options, which are checked before a long computation, and what is
told of it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypedDict

from symkin.errors import InputError
from symkin.verb_options import OUTPUT, Option

if TYPE_CHECKING:
    from symkin.model.mechanism import Mechanism
    from symkin.result import Result


class Picture(TypedDict):
    """Options of a picture."""

    plot: Annotated[Path | None, Option("Draw the result into a file.", "FILE.png", OUTPUT)]


class NamedPicture(Picture):
    """Options of a picture of a mechanism."""

    names: Annotated[
        str | None,
        Option(
            "Names in the picture of --plot: of joints and links, of one of them, of the joints "
            "that close loops of a graph, of none.",
            "all|joints|links|loops|none",
            OUTPUT,
        ),
    ]


class PictureOfSides(NamedPicture):
    """Options of a picture that may show several sides."""

    views: Annotated[
        str | None,
        Option(
            "Sides in the picture of --plot, of main, top, front, side: a panel each. Default: "
            "main.",
            "VIEW,...",
            OUTPUT,
        ),
    ]


@dataclass(frozen=True)
class Drawing:
    """Where a command draws, and what `result.plot` takes of its options."""

    path: Path | None
    options: dict[str, Any]

    @classmethod
    def checked(cls, told: Mapping[str, Any], mechanism: "Mechanism | None" = None) -> "Drawing":
        """The option `plot` and those beside it that a command has. Raises InputError, too where
        there is no picture that they are about.
        """
        path, untold = told["plot"], (None, False)
        chosen = {n: value for n, value in told.items() if n != "plot" and value not in untold}
        if path is None:
            for name in chosen:
                raise InputError(
                    f"--{name} is given without --plot; it says what the picture shows: give "
                    f"--plot FILE.png too"
                )
            return cls(None, {})
        from symkin.plots.picture_options import check_numbers, names_from, views_from
        from symkin.plots.pictures import check_picture_path

        check_picture_path(path)
        if "names" in chosen:
            names_from(chosen["names"], mechanism)
        if "views" in chosen:
            views_from(chosen["views"])
        if chosen.get("modes", "all").strip() != "all":
            check_numbers(chosen["modes"])
        return cls(path, chosen)

    def of(self, found: "Result | None") -> str:
        """Draw a result, where there is one; the line that names the picture."""
        if self.path is None or found is None:
            return ""
        found.plot(self.path, **self.options)
        return f"\npicture: {self.path}"
