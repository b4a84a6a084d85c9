"""The options of `calibrate`, of `fit_file` and of the command `symkin calibrate fit`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, TypedDict, get_args

from symkin.verb_options import Option

METHODS = ("nested", "lifted", "ipopt")
"""Names of the method: all are the same now, the two last are accepted for one release."""
Form = Literal["means", "differences", "maximum likelihood"]
FORMS: tuple[Form, ...] = get_args(Form)
"""Forms of the residuals."""
LOSSES = ("squared", "huber", "cauchy")
OUTLIER_RULES = ("remove", "report", "ignore")
LEAST_CHANGE = "least"
"""Frames chosen by the least change from nominal."""


class FitOptions(TypedDict, total=False):
    """Options of every fit."""

    method: Annotated[str, Option("nested", "Names of before: all mean nested now.", words=METHODS)]
    residual: Annotated[str, Option("means", "How groups and joint noise enter.", words=FORMS)]
    outliers: Annotated[
        str,
        Option("remove", "What to do with readings that do not belong.", words=OUTLIER_RULES),
    ]
    loss: Annotated[
        str,
        Option(
            "squared",
            "How far readings count that are far off: in full, or less the farther (robust, with a "
            "note on figures).",
            words=LOSSES,
        ),
    ]
    tolerance: Annotated[
        tuple[float, float] | None,
        Option(
            None,
            "Manufacturing tolerances, as in 1mm,0.1deg: standard deviations about the file's "
            "geometry, weighed against the noise.",
            "LENGTH,ANGLE",
        ),
    ]
    any_machine: Annotated[
        bool,
        Option(
            False, "Write the geometry even where it is another machine than the file describes."
        ),
    ]
    seed: Annotated[int, Option(0, "Seed of random numbers.", "N")]
    level: Annotated[float | None, Option(None)]
    max_iterations: Annotated[int, Option(60)]


class CalibrateOptions(FitOptions, total=False):
    """Options of `calibrate`."""

    parameters: Annotated[Sequence[str] | None, Option(None)]
    fixed: Annotated[Sequence[str], Option(())]


class FileOptions(FitOptions, total=False):
    """Options of `fit_file`: patterns of parameters, and postures that are only predicted."""

    parameters: Annotated[
        str | None,
        Option(
            None,
            "Names or patterns such as 'leg*.base.*'; all (default): every parameter that moves "
            "poses.",
            "A,B,...",
        ),
    ]
    hold: Annotated[
        str | None,
        Option(None, "Parameters that keep their nominal values: names or patterns.", "A,B,..."),
    ]
    frames: Annotated[
        str,
        Option(
            LEAST_CHANGE,
            "Frames that no reading tells: least change, or joints:P1,P2,P3/B1,B2.",
            "least|joints:...",
        ),
    ]
    hold_out: Annotated[
        str | None,
        Option(
            None,
            "Postures, as in 20 or 20%, drawn with --seed, that are not fitted but predicted.",
            "N|PERCENT",
        ),
    ]
