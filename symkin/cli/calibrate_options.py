"""Options that the commands of `symkin calibrate` share, and the choices they allow."""

from pathlib import Path
from typing import Annotated, Any, TypedDict

from symkin.calibration.options import READ_BESIDE
from symkin.cli.options import output_option
from symkin.verb_options import OUTPUT, POSTURES, READINGS, Argument, Option

DataArgument = Annotated[Path, Argument("Measurements, one row a posture.", "DATA.csv")]
CsvOption = Annotated[
    Path,
    output_option("File to write.", "FILE.csv"),
]
PosturesOption = Annotated[
    int,
    Option("Number of postures.", "N", POSTURES),
]
RandomPosturesOption = Annotated[
    int | None,
    Option("Number of random postures. Default: 40.", "N", POSTURES),
]
RandomGroupsOption = Annotated[
    int | None,
    Option("Their groups of equal inclination. Default: 0, none.", "N", POSTURES),
]
ReadingsOption = Annotated[str | None, READ_BESIDE]
PatternOption = Annotated[
    str | None,
    Option(
        "Names or patterns such as 'leg*.base.*'; all (default): every parameter that moves poses.",
        "A,B,...",
    ),
]
DistanceOption = Annotated[
    list[str] | None,
    Option(
        "Points of the column distance_NAME: on the platform in its frame, on the base in "
        "its own. May be repeated.",
        "NAME=X,Y,Z:BX,BY,BZ",
        READINGS,
    ),
]
PicturesOption = Annotated[
    bool,
    Option(
        "Draw residuals, changes of parameters and the pose's accuracy (PNG) beside the report.",
        group=OUTPUT,
    ),
]
ForceOption = Annotated[
    bool,
    Option(
        "Replace files in the way that symkin has not written, or that were edited since.",
        group=OUTPUT,
    ),
]


def _sigma(text: str) -> Any:
    return Option(text, "SIGMA", READINGS)


_ANGULAR, _LENGTH = " Default: 0.001deg.", " Default: 1e-5 of the size."
_Sigma = Annotated[str | None, _sigma("Standard deviation where the file has no sigma_ columns.")]


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

    sigma_joints: _Sigma
    sigma_group: _Sigma
    sigma_inclination: _Sigma
    sigma_position: _Sigma
    sigma_orientation: _Sigma
    distance: DistanceOption
    sigma_distance: _Sigma


def _range(metavar: str, text: str) -> Any:
    return Option(text, metavar, POSTURES)


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
