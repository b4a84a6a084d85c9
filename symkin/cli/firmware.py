"""`symkin firmware`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from symkin.cli.help import OUTPUT
from symkin.cli.options import MechArgument, choice
from symkin.cli.poses import EulerOption, PoseReader, RpyOption
from symkin.cli.reading import loaded, reads_robots, say_left_out
from symkin.cli.streams import say
from symkin.formats.read_options import ReadOptions


class RealType(StrEnum):
    float = "float"
    double = "double"


class GeometryChoice(StrEnum):
    fixed = "fixed"
    struct = "struct"


@reads_robots
def firmware(
    mech: MechArgument,
    read: ReadOptions,
    output: Annotated[
        Path,
        typer.Option(
            "-o", "--output", metavar="DIR", help="Folder to write.", rich_help_panel=OUTPUT
        ),
    ],
    real: Annotated[
        RealType, choice(RealType, "--real", "The C type of numbers.", "The code")
    ] = RealType.double,
    home_relative: Annotated[
        bool,
        typer.Option(
            "--home-relative",
            help="Joint values and positions as changes from home (platforms on six rods).",
            rich_help_panel="The code",
        ),
    ] = False,
    geometry: Annotated[
        GeometryChoice,
        choice(
            GeometryChoice,
            "--geometry",
            "Numbers in the code, or a struct given with each call.",
            "The code",
        ),
    ] = GeometryChoice.fixed,
    home: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z,QW,QX,QY,QZ",
            help="Pose about which pivots are chosen (platforms on six rods).",
            rich_help_panel="The code",
        ),
    ] = None,
    rpy: RpyOption = None,
    euler: EulerOption = None,
    given: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,...",
            help=(
                "Joint coordinates of which a map is written, as many as the mobility; needs "
                "--find."
            ),
            rich_help_panel="A map between joints",
        ),
    ] = None,
    find: Annotated[
        str | None,
        typer.Option(
            metavar="C,D,...",
            help="Joint coordinates that the map finds, and from which it leads back.",
            rich_help_panel="A map between joints",
        ),
    ] = None,
    compact: Annotated[
        bool,
        typer.Option(
            "--compact",
            help="The least code, at some cost of instructions (not of maps).",
            rich_help_panel="The code",
        ),
    ] = False,
    package: Annotated[
        bool,
        typer.Option(
            "--package",
            help="Also files for PlatformIO, Arduino and Zephyr.",
            rich_help_panel=OUTPUT,
        ),
    ] = False,
    linuxcnc: Annotated[
        bool,
        typer.Option(
            "--linuxcnc", help="Also a LinuxCNC kinematics component.", rich_help_panel=OUTPUT
        ),
    ] = False,
    cpp: Annotated[
        bool,
        typer.Option("--cpp", help="Also a header for C++17 and later.", rich_help_panel=OUTPUT),
    ] = False,
    ros2: Annotated[
        bool,
        typer.Option(
            "--ros2",
            help="Also a ROS 2 package: the map as a transmission of ros2_control.",
            rich_help_panel=OUTPUT,
        ),
    ] = False,
) -> None:
    """Write C99 for controllers: direct and inverse kinematics, Jacobian, test and build files.

    With --given and --find: the map between joints of any mechanism, both ways, with Jacobian,
    rates and torques.
    """
    from symkin.codegen.folder import write_firmware
    from symkin.codegen.own_test import can_run

    mechanism = loaded(mech, read)
    reader = PoseReader(mechanism, rpy, euler)
    reader.check_used(home)
    pose = reader.pose(home, "home")
    also = [
        name
        for name, wanted in (
            ("package", package),
            ("linuxcnc", linuxcnc),
            ("cpp", cpp),
            ("ros2", ros2),
        )
        if wanted
    ]
    files = write_firmware(
        mechanism,
        output,
        real=real.value,
        home_relative=home_relative,
        geometry=geometry.value,
        home=pose,
        given=names_from(given),
        find=names_from(find),
        also=also,  # type: ignore[arg-type]
        compact=compact,
    )
    if given is None and find is None:
        say_left_out(mechanism)
    if not can_run():
        say(
            "note: there is no C compiler here: the code's own test has not run; `make test` in "
            "the folder runs it"
        )
    for path in files:
        print(path)


def names_from(text: str | None) -> tuple[str, ...]:
    """Names that commas part."""
    return tuple(name.strip() for name in text.split(",") if name.strip()) if text else ()
