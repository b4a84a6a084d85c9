"""`symkin convert`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from symkin.cli.options import MechArgument, output_option
from symkin.formats.read_options import ReadOptions
from symkin.position.options import ConvertOptions


def convert(
    mech: MechArgument,
    read: ReadOptions,
    output: Annotated[
        Path,
        output_option("The file to write: .toml, .xml (MJCF), .urdf or .sdf.", "FILE"),
    ],
    options: ConvertOptions,
) -> None:
    """Write a mechanism in another format: `symkin convert ankle -o ankle.xml`. Its kinematics are
    the same; masses are plain.
    """
    from symkin.position.convert import convert as convert_one

    written = convert_one(mech, output, read, **options)
    print(f"written: {written}")
    if options["loops"] == "yaml":
        print(f"written: {written.with_suffix('.yaml')}")
