"""The options of `view`."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated

from symkin.position.options import Given
from symkin.verb_options import GIVEN, Option

if TYPE_CHECKING:
    from pathlib import Path

    from symkin.page.page import PlayedPath


class ViewOptions(Given, total=False):
    """Options of `view`: of a mechanism, then those of a sweep."""

    path: Annotated[
        "PlayedPath | Path | str | None",
        Option(
            "A trajectory to play: columns of the given coordinates, or poses.", "FILE.csv", GIVEN
        ),
    ]
    slices: Annotated[
        Mapping[str, float] | None,
        Option(
            "Where --map cuts a grid of more than two dimensions.",
            "NAME=VALUE,...",
            GIVEN,
            flags=("--slice",),
            read="slices",
        ),
    ]
    loci: Annotated[
        bool,
        Option("Lay the curves of singular configurations over --map.", group=GIVEN, default=False),
    ]
