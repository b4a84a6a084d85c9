"""The options of `singularity` and `singular_loci`."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, TypedDict

from symkin.numeric.tolerances import SINGULAR_VALUE
from symkin.position.options import JOINTS, POSE, SEED, START, VALUES
from symkin.verb_options import ASKED, Option

if TYPE_CHECKING:
    from symkin.position.given import Joints, Values
    from symkin.position.starts import Start
    from symkin.singularities.locus_system import LocusKind
    from symkin.spatial.pose import Pose


class SingularityOptions(TypedDict, total=False):
    """Options of `singularity`."""

    joints: Annotated["Joints | None", JOINTS]
    pose: Annotated["Sequence[float] | Pose | None", POSE]
    given: Annotated["Values | Sequence[str] | None", VALUES]
    start: Annotated["Start", START]
    tolerance: Annotated[float, Option(default=SINGULAR_VALUE)]
    output: Annotated[
        Sequence[str] | None,
        Option(
            "What type 1 and 2 are about, of x, y, z, rx, ry, rz (velocities, base frame) or "
            "joints, in place of position and "
            "orientation together.",
            "NAME,...",
            ASKED,
            read="names",
        ),
    ]
    point: Annotated[
        Sequence[float] | None,
        Option(
            "The output's point in the platform's frame; without --output x,y,z of it.",
            "X,Y,Z",
            ASKED,
            read="numbers",
        ),
    ]


class LociOptions(TypedDict, total=False):
    """Options of `singular_loci`."""

    given: Annotated[Sequence[str] | None, Option()]
    ranges: Annotated[
        Sequence[Sequence[float]] | None,
        Option(
            "The window of --plane, in the file's units.",
            "U0:U1,V0:V1",
            ASKED,
            flags=("--range",),
            read="window",
        ),
    ]
    kinds: Annotated["Sequence[LocusKind]", Option(default=("type 1", "type 2"))]
    starts: Annotated[int | None, Option("Random starts for --plane. Default: 200.", "N")]
    seed: Annotated[int | None, SEED]
