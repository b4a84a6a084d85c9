"""The options of `transmission`."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, TypedDict

from symkin.verb_options import Option

if TYPE_CHECKING:
    from symkin.position.given import Values
    from symkin.position.solution import Solution

_MOTORS = "Motors"


class MotorOptions(TypedDict, total=False):
    """What is told of motors: a number for each, or one for all; limits may be pairs."""

    inertia: Annotated[
        Any,
        Option("Inertia of each motor, at its coordinate.", "I1,I2,...", _MOTORS, read="numbers"),
    ]
    torque_limits: Annotated[
        Any, Option("Largest torques, or LOW:HIGH of each.", "T1,T2,...", _MOTORS, read="limits")
    ]
    speed_limits: Annotated[
        Any, Option("Largest rates, or LOW:HIGH of each.", "W1,W2,...", _MOTORS, read="limits")
    ]
    resolution: Annotated[
        Any,
        Option("Steps of each motor's sensor, for the play.", "R1,R2,...", _MOTORS, read="numbers"),
    ]


class TransmissionOptions(MotorOptions, total=False):
    """Options of `transmission`."""

    start: Annotated[
        "Solution | Values | None",
        Option(
            "A configuration whose mode is meant, by some values.", "NAME=VALUE,...", read="named"
        ),
    ]
    ranges: Annotated[
        Mapping[str, Sequence[float]] | None,
        Option(
            "Limits of coordinates in place of the file's.",
            "NAME=LOW:HIGH,...",
            flags=("--range",),
            read="ranges",
        ),
    ]
