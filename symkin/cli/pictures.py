"""Options of pictures that commands share, and their check before a long computation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from symkin.errors import InputError
from symkin.verb_options import OUTPUT, Option

if TYPE_CHECKING:
    from symkin.model.mechanism import Mechanism

NamesOption = Annotated[
    str | None,
    Option(
        "Names in the picture of --plot: of joints and links, of one of them, of the "
        "joints that close loops of a graph, of none.",
        "all|joints|links|loops|none",
        OUTPUT,
    ),
]
ViewsOption = Annotated[
    str | None,
    Option(
        "Sides in the picture of --plot, of main, top, front, side: a panel each. Default: main.",
        "VIEW,...",
        OUTPUT,
    ),
]


def picture_options(
    plot: Path | None,
    mechanism: Mechanism | None = None,
    *,
    names: str | None = None,
    views: str | None = None,
    modes: str | None = None,
) -> dict[str, Any]:
    """What `result.plot` takes of a command's options, checked with the picture's path. Raises
    InputError, too where there is no picture that they are about.
    """
    chosen = {
        name: value
        for name, value in (("names", names), ("views", views), ("modes", modes))
        if value is not None
    }
    if plot is None:
        for name in chosen:
            raise InputError(
                f"--{name} is given without --plot; it says what the picture shows: give --plot "
                f"FILE.png too"
            )
        return {}
    from symkin.plots.picture_file import check_picture_path
    from symkin.plots.picture_options import check_numbers, names_from, views_from

    check_picture_path(plot)
    if names is not None:
        graph, name = (True, "") if mechanism is None else (mechanism.is_graph, mechanism.name)
        names_from(names, graph=graph, mechanism=name)
    if views is not None:
        views_from(views)
    if modes is not None and modes.strip() != "all":
        check_numbers(modes)
    return chosen
