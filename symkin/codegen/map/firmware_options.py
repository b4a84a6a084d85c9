"""The options of `write_firmware`."""

from collections.abc import Collection, Sequence
from typing import Annotated, Literal, TypedDict

from symkin.verb_options import Option

_CODE, _MAP = "The code", "A map between joints"


class FirmwareOptions(TypedDict, total=False):
    """Options of `write_firmware`."""

    real: Annotated[
        Literal["float", "double"], Option("The C type of numbers.", group=_CODE, default="double")
    ]
    home_relative: Annotated[
        bool,
        Option(
            "Joint values and positions as changes from home (platforms on six rods).",
            group=_CODE,
            default=False,
        ),
    ]
    geometry: Annotated[
        Literal["fixed", "struct"],
        Option(
            "Numbers in the code, or a struct given with each call.", group=_CODE, default="fixed"
        ),
    ]
    home: Annotated[
        Sequence[float] | None,
        Option(
            "Pose about which pivots are chosen (platforms on six rods).",
            "X,Y,Z,QW,QX,QY,QZ",
            _CODE,
            read="pose",
        ),
    ]
    given: Annotated[
        Sequence[str],
        Option(
            "Joint coordinates of which a map is written, as many as the mobility; needs --find.",
            "A,B,...",
            _MAP,
            default=(),
            read="names",
        ),
    ]
    find: Annotated[
        Sequence[str],
        Option(
            "Joint coordinates that the map finds, and from which it leads back.",
            "C,D,...",
            _MAP,
            default=(),
            read="names",
        ),
    ]
    also: Annotated[Collection[Literal["package", "linuxcnc", "cpp", "ros2"]], Option(default=())]
    compact: Annotated[
        bool,
        Option(
            "The least code, at some cost of instructions (not of maps).",
            group=_CODE,
            default=False,
        ),
    ]
