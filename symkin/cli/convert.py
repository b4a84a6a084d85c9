"""`symkin convert`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from symkin.cli.options import MechArgument
from symkin.cli.reading import RobotFile, read_options
from symkin.verb_options import OUTPUT, Option


def convert(
    mech: MechArgument,
    read: RobotFile,
    output: Annotated[
        Path,
        Option(
            "The file to write: .toml, .xml (MJCF), .urdf or .sdf.",
            "FILE",
            OUTPUT,
            flags=("-o", "--output"),
        ),
    ],
    loops: Annotated[
        Literal["loop", "yaml"],
        Option(
            "URDF: loops in the file as those of URDF+, or in a YAML file beside it.", group=OUTPUT
        ),
    ] = "loop",
) -> None:
    """Write a mechanism in another format: `symkin convert ankle -o ankle.xml`. Its kinematics are
    the same; masses are plain.
    """
    from symkin.position.convert import convert as convert_one

    written = convert_one(mech, output, read_options(read), loops=loops)
    print(f"written: {written}")
    if loops == "yaml":
        print(f"written: {written.with_suffix('.yaml')}")
