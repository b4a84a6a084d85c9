"""The options of `calibrate`, of `fit_file`, of `plan_measurements` and of the commands `symkin
calibrate fit` and `plan`.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal, TypedDict, get_args

from symkin.verb_options import POSTURES, READINGS, Option

if TYPE_CHECKING:
    import numpy as np


Method = Literal["nested", "lifted", "ipopt"]
METHODS: tuple[Method, ...] = get_args(Method)
"""Names of the method: all are the same now, the two last are accepted for one release."""
Form = Literal["means", "differences", "maximum likelihood"]
FORMS: tuple[Form, ...] = get_args(Form)
"""Forms of the residuals."""
Loss = Literal["squared", "huber", "cauchy"]
OutlierRule = Literal["remove", "report", "ignore"]
SEED = Option("Seed of random numbers.", "N", default=0)
LEAST_CHANGE = "least"
"""Frames chosen by the least change from nominal."""


class FitOptions(TypedDict, total=False):
    """Options of every fit."""

    method: Annotated[Method, Option("Names of before: all mean nested now.", default="nested")]
    residual: Annotated[Form, Option("How groups and joint noise enter.", default="means")]
    outliers: Annotated[
        OutlierRule, Option("What to do with readings that do not belong.", default="remove")
    ]
    loss: Annotated[
        Loss,
        Option(
            "How far readings count that are far off: in full, or less the farther (robust, with a "
            "note on figures).",
            default="squared",
        ),
    ]
    tolerance: Annotated[
        tuple[float, float] | None,
        Option(
            "Manufacturing tolerances, as in 1mm,0.1deg: standard deviations about the file's "
            "geometry, weighed against the noise.",
            "LENGTH,ANGLE",
        ),
    ]
    any_machine: Annotated[
        bool,
        Option(
            "Write the geometry even where it is another machine than the file describes.",
            default=False,
        ),
    ]
    seed: Annotated[int, SEED]
    level: Annotated[float | None, Option()]
    max_iterations: Annotated[int, Option(default=60)]


class CalibrateOptions(FitOptions, total=False):
    """Options of `calibrate`."""

    parameters: Annotated[Sequence[str] | None, Option()]
    fixed: Annotated[Sequence[str], Option(default=())]


class FileOptions(FitOptions, total=False):
    """Options of `fit_file`: patterns of parameters, and postures that are only predicted."""

    parameters: Annotated[
        str | None,
        Option(
            "Names or patterns such as 'leg*.base.*'; all (default): every parameter that moves "
            "poses.",
            "A,B,...",
        ),
    ]
    hold: Annotated[
        str | None,
        Option("Parameters that keep their nominal values: names or patterns.", "A,B,..."),
    ]
    frames: Annotated[
        str,
        Option(
            "Frames that no reading tells: least change, or joints:P1,P2,P3/B1,B2.",
            "least|joints:...",
            default=LEAST_CHANGE,
        ),
    ]
    hold_out: Annotated[
        str | None,
        Option(
            "Postures, as in 20 or 20%, drawn with --seed, that are not fitted but predicted.",
            "N|PERCENT",
        ),
    ]


# --- plans ----------------------------------------------------------------------------------------


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
