"""The options of `plan_measurements`."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal, TypedDict

from symkin.calibration.options import SEED
from symkin.verb_options import POSTURES, READINGS, Option

if TYPE_CHECKING:
    import numpy as np


READ_BESIDE = Option(
    "What is read beside joints: inclination, position, orientation, pose; a passive joint, "
    "point.NAME, LINK.pose, distance.A.B.",
    "A,B,...",
    READINGS,
    default=(),
    read="names",
)


class PlanOptions(TypedDict, total=False):
    """Options of `plan_measurements`."""

    groups: Annotated[
        int, Option("Groups of equal inclination; 0: none.", "N", POSTURES, default=5)
    ]
    readings: Annotated[Sequence[str], READ_BESIDE]
    wedges: Annotated[
        "np.ndarray | None",
        Option(
            "Inclinations alpha:beta that groups may have. Default: level, and +-tilt.",
            "A:B,...",
            POSTURES,
            read="angle pairs",
        ),
    ]
    criterion: Annotated[
        Literal["D", "A", "I"],
        Option(
            "I: pose variance over the workspace; A: parameters; D: their determinant.", default="I"
        ),
    ]
    parameters: Annotated[Sequence[str] | None, Option()]
    aligned: Annotated[bool, Option(default=True)]
    seed: Annotated[int, SEED]
