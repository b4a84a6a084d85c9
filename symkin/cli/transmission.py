"""`symkin transmission`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from symkin.cli.firmware import names_from
from symkin.cli.help import ASKED, GIVEN, HOW, OUTPUT
from symkin.cli.options import (
    JsonOption,
    MechArgument,
    choice,
    named_from,
    numbers_from,
    print_result,
)
from symkin.cli.pictures import picture_options
from symkin.cli.reading import loaded, reads_robots
from symkin.cli.streams import say
from symkin.errors import InputError, NoConfigurationError
from symkin.formats.read_options import ReadOptions
from symkin.text import shown

if TYPE_CHECKING:
    from symkin.transmissions.transmission_result import Transmission

_MOTORS = "Motors"


class Format(StrEnum):
    array = "array"
    c = "c"
    ros2 = "ros2"


def _option(metavar: str, text: str, group: str) -> Any:
    return typer.Option(metavar=metavar, help=text, rich_help_panel=group)


@reads_robots
def transmission(
    mech: MechArgument,
    read: ReadOptions,
    motors: Annotated[
        str | None,
        _option("A,B,...", "Coordinates that motors drive. Default: those of the file.", ASKED),
    ] = None,
    joints: Annotated[
        str | None,
        _option("C,D,...", "Joints of the limb. Default: a serial way is found.", ASKED),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option(
            "--at",
            metavar="V1,V2,...",
            help="The motors' values at the configuration that is told. Default: the reference.",
            rich_help_panel=GIVEN,
        ),
    ] = None,
    at_joints: Annotated[
        str | None, _option("V1,V2,...", "The joints' values, in place of --at.", GIVEN)
    ] = None,
    start: Annotated[
        str | None,
        _option("NAME=VALUE,...", "A configuration whose mode is meant, by some values.", HOW),
    ] = None,
    ranges: Annotated[
        str | None,
        typer.Option(
            "--range",
            metavar="NAME=LOW:HIGH,...",
            help="Limits of coordinates in place of the file's.",
            rich_help_panel=HOW,
        ),
    ] = None,
    inertia: Annotated[
        str | None, _option("I1,I2,...", "Inertia of each motor, at its coordinate.", _MOTORS)
    ] = None,
    torque_limits: Annotated[
        str | None, _option("T1,T2,...", "Largest torques, or LOW:HIGH of each.", _MOTORS)
    ] = None,
    speed_limits: Annotated[
        str | None, _option("W1,W2,...", "Largest rates, or LOW:HIGH of each.", _MOTORS)
    ] = None,
    resolution: Annotated[
        str | None, _option("R1,R2,...", "Steps of each motor's sensor, for the play.", _MOTORS)
    ] = None,
    language: Annotated[
        Format,
        choice(
            Format,
            "--format",
            "What -o writes: array operations, C with a header for C++, also a ROS 2 package.",
            OUTPUT,
        ),
    ] = Format.array,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="DIR", help="Folder to write into.", rich_help_panel=OUTPUT
        ),
    ] = None,
    serial: Annotated[
        Path | None,
        _option(
            "FILE.urdf|.xml", "Write the robot with driven joints in its linkages' place.", OUTPUT
        ),
    ] = None,
    plot: Annotated[
        Path | None, _option("FILE.png", "Draw torques and ratios over the range.", OUTPUT)
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """The exact map between motors and the joints that they drive by closed linkages: range,
    torques, ratios; at a configuration Jacobians, second derivatives, inertia, polytopes.
    """
    from symkin.position.solve_result import SolveError
    from symkin.transmissions.transmission import transmission as find

    mechanism = loaded(mech, read)
    picture_options(plot, mechanism)
    unit = mechanism.angle_unit
    if motors is None and joints is not None:
        raise InputError("--joints needs --motors beside it: the coordinates that motors drive")
    if output is None and language != Format.array:
        raise InputError(f"--format {language.value} needs -o DIR: the folder to write into")
    names = (names_from(motors), names_from(joints) or None) if motors is not None else ()
    found = find(
        mechanism,
        *names,
        inertia=numbers_from(inertia, "inertia", unit),
        torque_limits=_limits(torque_limits, "torque-limits", unit),
        speed_limits=_limits(speed_limits, "speed-limits", unit),
        resolution=numbers_from(resolution, "resolution", unit),
        ranges=_ranges(ranges, unit),
        start=named_from(start, "start", unit),
    )
    several: list[Transmission] = list(found.values() if isinstance(found, Mapping) else [found])
    to_dict: Callable[[], dict[str, Any]] = found.to_dict
    text = found.__str__
    if at is not None or at_joints is not None:
        if len(several) > 1:
            raise InputError(
                f"--at: {len(several)} transmissions are found; name one by --motors and --joints"
            )
        values = numbers_from(at, "at", unit), numbers_from(at_joints, "at-joints", unit)
        try:
            told = several[0].to_dict(*values)
        except SolveError as error:
            raise NoConfigurationError(str(error)) from None
        to_dict, text = lambda: told, lambda: _text_at(told)
    files = [] if output is None else _written(several, output, language)
    if serial is not None:
        from symkin.transmissions.serial import write_serial

        for note in write_serial(mechanism, several, serial):
            say(note)
        files.append(serial)
    if plot is not None:
        found.plot(plot)
        files.append(plot)
    lines = "".join(f"\n{file}" for file in files)
    print_result(as_json, to_dict, lambda: text() + lines)


_TOLD = (
    "motors",
    "joints",
    "jacobian",
    "inverse_jacobian",
    "second",
    "reflected_inertia",
    "bias",
    "torque_polytope",
    "speed_polytope",
    "certified",
    "within_limits",
)


def _text_at(told: dict[str, Any]) -> str:
    """What is told of one configuration."""
    return "\n".join(f"{key}: {_short(told[key])}" for key in _TOLD)


def _short(value: Any) -> str:
    """A value of JSON with six digits a number."""
    if isinstance(value, dict):
        return ", ".join(f"{name} = {_short(v)}" for name, v in value.items())
    if isinstance(value, list):
        return f"[{', '.join(map(_short, value))}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _written(several: list[Transmission], folder: Path, language: Format) -> list[Path]:
    """Write the files of all transmissions, C of several into a folder each."""
    from symkin.codegen.folder import write_firmware
    from symkin.codegen.transmission_array import array_source
    from symkin.files.outputs import write_output
    from symkin.model.names import identifiers

    if folder.exists() and not folder.is_dir():
        raise InputError(f"-o: {str(folder)!r} is a file; the name of a folder is needed")
    both = [name for one in several for name in one.joints if name in one.motors]
    if both and language is not Format.array:
        raise InputError(
            f"--format {language.value}: {', '.join(both)}: motor and joint at once, which C has "
            f"no map for; name other joints (--motors, --joints), or take --format array"
        )
    stems = [one.linkage.mechanism.name for one in several]
    if len(several) > 1:
        stems = [f"{stem}_{one.joints[0]}" for stem, one in zip(stems, several, strict=True)]
    named = list(zip(identifiers(stems), several, strict=True))
    folder.mkdir(parents=True, exist_ok=True)
    if language is Format.array:
        texts = {folder / f"{stem}_transmission.py": array_source(one) for stem, one in named}
        for path, text in texts.items():
            write_output(path, text)
        return list(texts)
    also: list[Any] = ["cpp", *(["ros2"] if language is Format.ros2 else [])]
    return [
        path
        for stem, one in named
        for path in write_firmware(
            replace(one.linkage.mechanism, name=stem),
            folder / stem if len(several) > 1 else folder,
            given=one.motors,
            find=one.joints,
            also=also,
        )
    ]


def _limits(text: str | None, what: str, unit: str) -> list[Any] | None:
    """A number for each motor, or a pair LOW:HIGH."""
    if text is None:
        return None
    parts = [_pair(part, what, unit) for part in text.split(",")]
    pairs = [[-part[0], part[0]] if len(part) == 1 else part for part in parts]
    return pairs if len(pairs) > 1 or len(parts[0]) > 1 else [parts[0][0]]


def _pair(text: str, what: str, unit: str) -> list[float]:
    values = [v for part in text.split(":") for v in numbers_from(part, what, unit) or []]
    if len(values) > 2:
        raise InputError(f"--{what}: {shown(text)} is neither a number nor LOW:HIGH")
    return values


def _ranges(text: str | None, unit: str) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for part in text.split(",") if text else []:
        name, equals, bounds = (piece.strip() for piece in part.partition("="))
        values = _pair(bounds, "range", unit) if equals and bounds else []
        if not name or len(values) != 2 or name in found:
            raise InputError(f"--range: {shown(part.strip())}; NAME=LOW:HIGH,... is needed")
        found[name] = values
    return found
