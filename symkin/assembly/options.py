"""The options of `modes`."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, TypedDict

from symkin.position.options import SEED
from symkin.verb_options import Option

if TYPE_CHECKING:
    from symkin.numeric.levenberg import Progress
    from symkin.position.least_squares import LeastSquares
    from symkin.position.newton import Newton


class ModesOptions(TypedDict, total=False):
    """Options of `modes` beside its inputs."""

    method: Annotated[
        str | None,
        Option(
            "Track all complex solutions, or keep what random starts reach. Default: formulas of "
            "arms that have some, else continuation.",
            words=("continuation", "multistart"),
        ),
    ]
    starts: Annotated[
        int | None,
        Option("Random starts of multistart, or of what is sampled. Default: 2000.", "N"),
    ]
    seed: Annotated[int | None, SEED]
    choose: Annotated[
        Sequence[int],
        Option(
            "Of given values: one solution of each of the first blocks, by number from 0.",
            "K1,K2,...",
            default=(),
            read="whole numbers",
        ),
    ]
    solver: Annotated["str | Newton | LeastSquares | None", Option()]
    progress: Annotated["Progress | None", Option()]
