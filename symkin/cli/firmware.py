"""`symkin firmware`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from symkin.cli.options import MechArgument, names_from
from symkin.cli.poses import EulerOption, PoseReader, RpyOption
from symkin.cli.reading import RobotFile, loaded, say_left_out
from symkin.cli.streams import say
from symkin.verb_options import OUTPUT, Option


def firmware(
    mech: MechArgument,
    read: RobotFile,
    output: Annotated[
        Path,
        Option("Folder to write.", "DIR", OUTPUT, flags=("-o", "--output")),
    ],
    real: Annotated[
        Literal["float", "double"], Option("The C type of numbers.", group="The code")
    ] = "double",
    home_relative: Annotated[
        bool,
        Option(
            "Joint values and positions as changes from home (platforms on six rods).",
            group="The code",
        ),
    ] = False,
    geometry: Annotated[
        Literal["fixed", "struct"],
        Option("Numbers in the code, or a struct given with each call.", group="The code"),
    ] = "fixed",
    home: Annotated[
        str | None,
        Option(
            "Pose about which pivots are chosen (platforms on six rods).",
            "X,Y,Z,QW,QX,QY,QZ",
            "The code",
        ),
    ] = None,
    rpy: RpyOption = None,
    euler: EulerOption = None,
    given: Annotated[
        str | None,
        Option(
            "Joint coordinates of which a map is written, as many as the mobility; needs --find.",
            "A,B,...",
            "A map between joints",
        ),
    ] = None,
    find: Annotated[
        str | None,
        Option(
            "Joint coordinates that the map finds, and from which it leads back.",
            "C,D,...",
            "A map between joints",
        ),
    ] = None,
    compact: Annotated[
        bool,
        Option("The least code, at some cost of instructions (not of maps).", group="The code"),
    ] = False,
    package: Annotated[
        bool,
        Option("Also files for PlatformIO, Arduino and Zephyr.", group=OUTPUT),
    ] = False,
    linuxcnc: Annotated[
        bool,
        Option("Also a LinuxCNC kinematics component.", group=OUTPUT),
    ] = False,
    cpp: Annotated[
        bool,
        Option("Also a header for C++17 and later.", group=OUTPUT),
    ] = False,
    ros2: Annotated[
        bool,
        Option("Also a ROS 2 package: the map as a transmission of ros2_control.", group=OUTPUT),
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
        real=real,
        home_relative=home_relative,
        geometry=geometry,
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
