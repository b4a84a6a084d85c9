"""Options that the commands of `symkin calibrate` share, and the choices they allow."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, TypedDict

import typer

from symkin.cli.help import HOW, OUTPUT, POSTURES, READINGS
from symkin.cli.options import whole_number


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
PicturesOption = Annotated[
    bool,
    typer.Option(
        "--pictures",
        help="Draw residuals, changes of parameters and the pose's accuracy (PNG) beside the "
        "report.",
        rich_help_panel=OUTPUT,
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


def _sigma(text: str) -> Any:
    return typer.Option(metavar="SIGMA", help=text, rich_help_panel=READINGS)


_ANGULAR, _LENGTH = " Default: 0.001deg.", " Default: 1e-5 of the size."
_MISSING = _sigma("Standard deviation where the file has no sigma_ columns.")


class Noise(TypedDict):
    """Options of the noise of readings."""

    noise_joints: Annotated[
        str | None,
        _sigma(
            "Standard deviation of joint readings, as in 2um or 2um,0.001deg. Default: 1e-6 of the "
            "size, 0.001deg."
        ),
    ]
    noise_group: Annotated[
        str | None,
        _sigma(
            "Standard deviation of equality in a group (inclinometer's repeatability)." + _ANGULAR
        ),
    ]
    noise_inclination: Annotated[
        str | None, _sigma("Standard deviation of inclination readings." + _ANGULAR)
    ]
    noise_position: Annotated[str | None, _sigma("Standard deviation of positions." + _LENGTH)]
    noise_orientation: Annotated[
        str | None, _sigma("Standard deviation of orientations." + _ANGULAR)
    ]


class AllNoise(Noise):
    """The same, and of distances."""

    distance: DistanceOption
    noise_distance: Annotated[str | None, _sigma("Standard deviation of distances." + _LENGTH)]


class Sigmas(TypedDict):
    """Options for standard deviations that the file leaves out."""

    sigma_joints: Annotated[str | None, _MISSING]
    sigma_group: Annotated[str | None, _MISSING]
    sigma_inclination: Annotated[str | None, _MISSING]
    sigma_position: Annotated[str | None, _MISSING]
    sigma_orientation: Annotated[str | None, _MISSING]
    distance: DistanceOption
    sigma_distance: Annotated[str | None, _MISSING]


def _range(metavar: str, text: str) -> Any:
    return typer.Option(metavar=metavar, help=text, rich_help_panel=POSTURES)


class Space(TypedDict):
    """Options of the workspace that postures are drawn from."""

    box: Annotated[
        str | None,
        _range(
            "DX,DY,DZ",
            "Half widths of the workspace about the reference. Default: 0.15 of the size.",
        ),
    ]
    tilt: Annotated[
        str | None,
        _range("ANGLE", "Range of alpha and beta about the reference. Default: 20deg."),
    ]
    spin: Annotated[str | None, _range("ANGLE", "Range of the turn about z. Default: 20deg.")]


MEASURES = {
    "group": "angle",
    "inclination": "angle",
    "orientation": "angle",
    "position": "length",
    "distance": "length",
}
"""What readings are, by the ends of their options' names."""
