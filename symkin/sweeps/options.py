"""The options of `sweep`."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Literal, TypedDict

from symkin.position.options import SEED
from symkin.verb_options import GIVEN, OUTPUT, Option

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from symkin.position.given import Joints
    from symkin.spatial.pose import Pose
    from symkin.sweeps.space import Values


class SweepOptions(TypedDict, total=False):
    """Options of `sweep`."""

    given: Annotated["Mapping[str, float | Values] | None", Option()]
    over: Annotated[Literal["inputs", "poses"], Option(default="inputs")]
    poses: Annotated[
        bool,
        Option(
            "Sweep x, y, z, gamma from the reference, or the rotation vector rx, ry, rz before the "
            "orientation of --at; those of the motion.",
            group=GIVEN,
            default=False,
        ),
    ]
    at: Annotated["Joints | Pose | None", Option()]
    random: Annotated[int | None, Option("Random points in place of a grid.", "N", GIVEN)]
    seed: Annotated[int | None, SEED]
    quantity: Annotated[
        Literal["modes", "conditioning", "reach"],
        Option("What is stored.", group=OUTPUT, default="modes"),
    ]
    certify: Annotated[bool, Option("Prove every mode; takes many times as long.", default=False)]
    starts: Annotated[
        int | None, Option("Random starts where paths do not decide. Default: 2000.", "N")
    ]
    chunk: Annotated[int | None, Option("Points that are computed and written at a time.", "N")]
    executor: Annotated["Executor | None", Option()]
    workers: Annotated[
        int | None, Option("Local processes; 0: this one. Default: one a processor.", "N")
    ]
    dask: Annotated[
        str | None,
        Option("Dask scheduler that computes in place of local processes.", "ADDRESS"),
    ]
    progress: Annotated[Callable[[int, int], None] | None, Option()]
