"""Options that the commands of `symkin calibrate` share, and the choices they allow."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from symkin.cli.help import HOW, OUTPUT, POSTURES, READINGS
from symkin.cli.options import whole_number


class Method(StrEnum):
    nested = "nested"
    lifted = "lifted"
    ipopt = "ipopt"


class Residual(StrEnum):
    means = "means"
    differences = "differences"
    likelihood = "maximum-likelihood"


class Loss(StrEnum):
    squared = "squared"
    huber = "huber"
    cauchy = "cauchy"


class Outliers(StrEnum):
    remove = "remove"
    report = "report"
    ignore = "ignore"


class CriterionName(StrEnum):
    D = "D"
    A = "A"
    I = "I"  # noqa: E741 - the name of the criterion


class Shape(StrEnum):
    normal = "normal"
    uniform = "uniform"


DataArgument = Annotated[
    Path, typer.Argument(metavar="DATA.csv", help="Measurements, one row a posture.")
]
CsvOption = Annotated[
    Path,
    typer.Option(
        "-o", "--output", metavar="FILE.csv", help="File to write.", rich_help_panel=OUTPUT
    ),
]
PosturesOption = Annotated[
    int,
    typer.Option(
        metavar="N", parser=whole_number, help="Number of postures.", rich_help_panel=POSTURES
    ),
]
GroupsOption = Annotated[
    int,
    typer.Option(
        metavar="N",
        parser=whole_number,
        help="Groups of equal inclination; 0: none.",
        rich_help_panel=POSTURES,
    ),
]
RandomPosturesOption = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        parser=whole_number,
        help="Number of random postures. Default: 40.",
        rich_help_panel=POSTURES,
    ),
]
RandomGroupsOption = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        parser=whole_number,
        help="Their groups of equal inclination. Default: 0, none.",
        rich_help_panel=POSTURES,
    ),
]
ReadingsOption = Annotated[
    str,
    typer.Option(
        metavar="A,B,...",
        help=(
            "What is read beside joints: inclination, position, orientation, pose; a passive "
            "joint, point.NAME, LINK.pose, distance.A.B."
        ),
        rich_help_panel=READINGS,
    ),
]
BoxOption = Annotated[
    str | None,
    typer.Option(
        metavar="DX,DY,DZ",
        help="Half widths of the workspace about the reference. Default: 0.15 of the size.",
        rich_help_panel=POSTURES,
    ),
]
TiltOption = Annotated[
    str | None,
    typer.Option(
        metavar="ANGLE",
        help="Range of alpha and beta about the reference. Default: 20deg.",
        rich_help_panel=POSTURES,
    ),
]
SpinOption = Annotated[
    str | None,
    typer.Option(
        metavar="ANGLE", help="Range of the turn about z. Default: 20deg.", rich_help_panel=POSTURES
    ),
]
NoiseJoints = Annotated[
    str | None,
    typer.Option(
        metavar="SIGMA",
        help=(
            "Standard deviation of joint readings, as in 2um or 2um,0.001deg. Default: 1e-6 of "
            "the size, 0.001deg."
        ),
        rich_help_panel=READINGS,
    ),
]
NoiseGroup = Annotated[
    str | None,
    typer.Option(
        metavar="SIGMA",
        help=(
            "Standard deviation of equality in a group (inclinometer's repeatability). "
            "Default: 0.001deg."
        ),
        rich_help_panel=READINGS,
    ),
]
NoiseInclination = Annotated[
    str | None,
    typer.Option(
        metavar="SIGMA",
        help="Standard deviation of inclination readings. Default: 0.001deg.",
        rich_help_panel=READINGS,
    ),
]
NoisePosition = Annotated[
    str | None,
    typer.Option(
        metavar="SIGMA",
        help="Standard deviation of positions. Default: 1e-5 of the size.",
        rich_help_panel=READINGS,
    ),
]
NoiseOrientation = Annotated[
    str | None,
    typer.Option(
        metavar="SIGMA",
        help="Standard deviation of orientations. Default: 0.001deg.",
        rich_help_panel=READINGS,
    ),
]
SigmaOption = Annotated[
    str | None,
    typer.Option(
        metavar="SIGMA",
        help="Standard deviation where the file has no sigma_ columns.",
        rich_help_panel=READINGS,
    ),
]
HoldOption = Annotated[
    str | None,
    typer.Option(
        metavar="A,B,...",
        help="Parameters that keep their nominal values: names or patterns.",
        rich_help_panel=HOW,
    ),
]
PatternOption = Annotated[
    str | None,
    typer.Option(
        metavar="A,B,...",
        help=(
            "Names or patterns such as 'leg*.base.*'; all (default): every parameter that "
            "moves poses."
        ),
        rich_help_panel=HOW,
    ),
]
ToleranceOption = Annotated[
    str | None,
    typer.Option(
        metavar="LENGTH,ANGLE",
        help=(
            "Manufacturing tolerances, as in 1mm,0.1deg: standard deviations about the file's "
            "geometry, weighed against the noise."
        ),
        rich_help_panel=HOW,
    ),
]
AnyMachineOption = Annotated[
    bool,
    typer.Option(
        "--any-machine",
        help="Write the geometry even where it is another machine than the file describes.",
        rich_help_panel=HOW,
    ),
]
DistanceOption = Annotated[
    list[str] | None,
    typer.Option(
        "--distance",
        metavar="NAME=X,Y,Z:BX,BY,BZ",
        help=(
            "Points of the column distance_NAME: on the platform in its frame, on the base in "
            "its own. May be repeated."
        ),
        rich_help_panel=READINGS,
    ),
]
NoiseDistance = Annotated[
    str | None,
    typer.Option(
        metavar="SIGMA",
        help="Standard deviation of distances. Default: 1e-5 of the size.",
        rich_help_panel=READINGS,
    ),
]
ForceOption = Annotated[
    bool,
    typer.Option(
        "--force",
        help="Replace files in the way that symkin has not written, or that were edited since.",
        rich_help_panel=OUTPUT,
    ),
]
HoldOutOption = Annotated[
    str | None,
    typer.Option(
        metavar="N|PERCENT",
        help="Postures, as in 20 or 20%, drawn with --seed, that are not fitted but predicted.",
        rich_help_panel=HOW,
    ),
]
