"""`symkin convert`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from symkin.cli.options import MechArgument
from symkin.cli.reading import reads_robots
from symkin.formats.read_options import ReadOptions


@reads_robots
def convert(
    mech: MechArgument,
    read: ReadOptions,
    output: Annotated[Path, typer.Option("-o", metavar="FILE", help="The file to write: .toml, .xml (MJCF), .urdf or .sdf.")],
    loops: Annotated[
        str, typer.Option(metavar="loop|yaml", help="URDF: loops in the file as those of URDF+, or in a YAML file beside it.")
    ] = "loop",
) -> None:
    """Write a mechanism in another format: `symkin convert ankle -o ankle.xml`. Its kinematics are the same; masses are plain."""
    from symkin.position.convert import convert as convert_one

    written = convert_one(mech, output, read, loops=loops)  # type: ignore[arg-type]
    print(f"written: {written}")
    if loops == "yaml":
        print(f"written: {written.with_suffix('.yaml')}")
