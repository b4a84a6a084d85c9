"""The options of `jacobian`."""

from collections.abc import Sequence
from typing import Annotated, TypedDict

from symkin.verb_options import ASKED, Option


class JacobianOptions(TypedDict, total=False):
    """Options of `jacobian`."""

    parameters: Annotated[bool, Option(default=False)]
    of: Annotated[
        Sequence[str] | None,
        Option(
            "Coordinates whose rates are wanted, by those of --by.",
            "NAME,...",
            ASKED,
            read="names",
        ),
    ]
    by: Annotated[
        Sequence[str] | None,
        Option(
            "Coordinates that decide the motion, as many as the mobility.",
            "NAME,...",
            ASKED,
            read="names",
        ),
    ]
