"""`symkin firmware`."""

from __future__ import annotations

from typing import Annotated

from symkin.cli.options import FolderOption, MechArgument
from symkin.cli.poses import PoseForm
from symkin.cli.reading import say_left_out
from symkin.cli.streams import say
from symkin.cli.values import Asked
from symkin.codegen.map.firmware_options import FirmwareOptions
from symkin.formats.read_options import ReadOptions
from symkin.verb_options import OUTPUT, Option


def firmware(
    mech: MechArgument,
    read: ReadOptions,
    output: FolderOption,
    options: FirmwareOptions,
    form: PoseForm,
    package: Annotated[
        bool, Option("Also files for PlatformIO, Arduino and Zephyr.", group=OUTPUT)
    ] = False,
    linuxcnc: Annotated[
        bool, Option("Also a LinuxCNC kinematics component.", group=OUTPUT)
    ] = False,
    cpp: Annotated[bool, Option("Also a header for C++17 and later.", group=OUTPUT)] = False,
    ros2: Annotated[
        bool,
        Option("Also a ROS 2 package: the map as a transmission of ros2_control.", group=OUTPUT),
    ] = False,
) -> None:
    """Write C99 for controllers: direct and inverse kinematics, Jacobian, test and build files.

    With --given and --find: the map between joints of any mechanism, both ways, with Jacobian,
    rates and torques.
    """
    from symkin.codegen.folder.folder import write_firmware
    from symkin.codegen.folder.own_test import can_run

    asked = Asked.of(mech, read, form)
    values = asked.values(FirmwareOptions, options, "home")
    more = {"package": package, "linuxcnc": linuxcnc, "cpp": cpp, "ros2": ros2}
    also = [name for name, wanted in more.items() if wanted]
    files = write_firmware(asked.mechanism, output, **values, also=also)  # type: ignore[arg-type]
    if not values.keys() & {"given", "find"}:
        say_left_out(asked.mechanism)
    if not can_run():
        say(
            "note: there is no C compiler here: the code's own test has not run; `make test` in "
            "the folder runs it"
        )
    for path in files:
        print(path)
