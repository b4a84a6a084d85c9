"""`symkin convert`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from symkin.cli.help import OUTPUT
from symkin.cli.options import MechArgument, choice
from symkin.cli.reading import reads_robots
from symkin.formats.read_options import ReadOptions


class Loops(StrEnum):
    loop = "loop"
    yaml = "yaml"


@reads_robots
def convert(
    mech: MechArgument,
    read: ReadOptions,
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="The file to write: .toml, .xml (MJCF), .urdf or .sdf.",
            rich_help_panel=OUTPUT,
        ),
    ],
    loops: Annotated[
        Loops,
        choice(
            Loops,
            "--loops",
            "URDF: loops in the file as those of URDF+, or in a YAML file beside it.",
            OUTPUT,
        ),
    ] = Loops.loop,
) -> None:
    """Write a mechanism in another format: `symkin convert ankle -o ankle.xml`. Its kinematics are
    the same; masses are plain.
    """
    from symkin.position.convert import convert as convert_one

    written = convert_one(mech, output, read, loops=loops.value)
    print(f"written: {written}")
    if loops is Loops.yaml:
        print(f"written: {written.with_suffix('.yaml')}")
