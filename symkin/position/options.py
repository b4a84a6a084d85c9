"""The options of `solve` and `convert`, and what every verb is given that asks for a position."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal, TypedDict

from symkin.verb_options import GIVEN, OUTPUT, Option

if TYPE_CHECKING:
    from symkin.position.closed import ClosedForm
    from symkin.position.given import Joints, Values
    from symkin.position.least_squares import LeastSquares
    from symkin.position.newton import Newton
    from symkin.position.starts import Start
    from symkin.spatial.pose import Pose

JOINTS = Option(
    "All actuated joints, in file order or as NAME=VALUE,..., in the file's units: the direct "
    "problem.",
    "V1,V2,...",
    GIVEN,
    read="joints",
)
POSE = Option(
    "The platform's or tool's pose: the inverse problem.",
    "X,Y,Z,QW,QX,QY,QZ",
    GIVEN,
    read="pose",
)
VALUES = Option(
    "Any coordinates, as many as the mobility: joints, passive ones too, and x, y, z, azimuth, "
    "tilt, torsion of the platform, or pose=X,Y,Z,QW,QX,QY,QZ.",
    "NAME=VALUE,...",
    GIVEN,
    read="given",
)
START = Option(
    "A pose for the direct problem, all actuated joints for the inverse one; NAME=VALUE,... with "
    "--given and for graphs.",
    "V1,V2,...",
    read="start",
)
SEED = Option("Seed of the random starts. Default: 0.", "N")


class Given(TypedDict, total=False):
    """What is given of one configuration."""

    joints: Annotated["Joints | None", JOINTS]
    pose: Annotated["Sequence[float] | Pose | None", POSE]
    given: Annotated["Values | None", VALUES]


class Begun(Given, total=False):
    """What names one configuration, near a start."""

    start: Annotated["Start", START]


class SolveOptions(Begun, total=False):
    """Options of `solve`."""

    solver: Annotated[
        "str | Newton | LeastSquares | ClosedForm",
        Option(
            "CasADi's rootfinder, or IPOPT on the squared closure.",
            words=("newton", "ipopt", "closed"),
            default="newton",
        ),
    ]
    check: Annotated[bool, Option(default=True)]


class ConvertOptions(TypedDict, total=False):
    """Options of `convert`."""

    loops: Annotated[
        Literal["loop", "yaml"],
        Option(
            "URDF: loops in the file as those of URDF+, or in a YAML file beside it.",
            group=OUTPUT,
            default="loop",
        ),
    ]
