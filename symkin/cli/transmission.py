"""`symkin transmission`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from symkin.cli.options import (
    JsonOption,
    MechArgument,
    names_from,
    numbers_from,
    output_option,
    print_either,
)
from symkin.cli.pictures import Picture
from symkin.cli.streams import say
from symkin.cli.values import Asked
from symkin.errors import InputError, NoConfigurationError
from symkin.formats.read_options import ReadOptions
from symkin.transmissions.options import TransmissionOptions
from symkin.verb_options import ASKED, GIVEN, OUTPUT, Option

if TYPE_CHECKING:
    from symkin.transmissions.transmission_result import Transmission


def transmission(
    mech: MechArgument,
    read: ReadOptions,
    *,
    options: TransmissionOptions,
    motors: Annotated[
        str | None,
        Option("Coordinates that motors drive. Default: those of the file.", "A,B,...", ASKED),
    ] = None,
    joints: Annotated[
        str | None,
        Option("Joints of the limb. Default: a serial way is found.", "C,D,...", ASKED),
    ] = None,
    at: Annotated[
        str | None,
        Option(
            "The motors' values at the configuration that is told. Default: the reference.",
            "V1,V2,...",
            GIVEN,
        ),
    ] = None,
    at_joints: Annotated[
        str | None, Option("The joints' values, in place of --at.", "V1,V2,...", GIVEN)
    ] = None,
    language: Annotated[
        Literal["array", "c", "ros2"],
        Option(
            "What -o writes: array operations, C with a header for C++, also a ROS 2 package.",
            group=OUTPUT,
            flags=("--format",),
        ),
    ] = "array",
    output: Annotated[Path | None, output_option("Folder to write into.", "DIR")] = None,
    serial: Annotated[
        Path | None,
        Option(
            "Write the robot with driven joints in its linkages' place.", "FILE.urdf|.xml", OUTPUT
        ),
    ] = None,
    picture: Picture,
    as_json: JsonOption = False,
) -> None:
    """The exact map between motors and the joints that they drive by closed linkages: range,
    torques, ratios; at a configuration Jacobians, second derivatives, inertia, polytopes.
    """
    from symkin.position.solve_result import SolveError
    from symkin.transmissions.transmission import transmission as find

    asked = Asked.of(mech, read, picture=picture)
    mechanism, unit = asked.mechanism, asked.unit
    if motors is None and joints is not None:
        raise InputError("--joints needs --motors beside it: the coordinates that motors drive")
    if output is None and language != "array":
        raise InputError(f"--format {language} needs -o DIR: the folder to write into")
    names = (names_from(motors), names_from(joints) or None) if motors is not None else ()
    found = find(mechanism, *names, **asked.values(TransmissionOptions, options))
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
    drawn = asked.drawing.of(found)
    lines = "".join(f"\n{file}" for file in files) + drawn
    print_either(as_json, to_dict, lambda: text() + lines)


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


def _written(several: list[Transmission], folder: Path, language: str) -> list[Path]:
    """Write the files of all transmissions, C of several into a folder each."""
    from symkin.codegen.folder.folder import write_firmware
    from symkin.codegen.map.transmission_array import array_source
    from symkin.files.outputs import write_output
    from symkin.model.names import identifiers
    from symkin.transmissions.found import with_twins

    if folder.exists() and not folder.is_dir():
        raise InputError(f"-o: {str(folder)!r} is a file; the name of a folder is needed")
    stems = [one.linkage.mechanism.name for one in several]
    if len(several) > 1:
        stems = [f"{stem}_{one.joints[0]}" for stem, one in zip(stems, several, strict=True)]
    named = list(zip(identifiers(stems), several, strict=True))
    folder.mkdir(parents=True, exist_ok=True)
    if language == "array":
        texts = {folder / f"{stem}_transmission.py": array_source(one) for stem, one in named}
        for path, text in texts.items():
            write_output(path, text)
        return list(texts)
    also: list[Any] = ["cpp", *(["ros2"] if language == "ros2" else [])]
    files = []
    for stem, one in named:
        mechanism, twins = with_twins(
            one.linkage.mechanism, [n for n in one.joints if n in one.motors]
        )
        for name, twin in twins.items():
            say(f"{name} is motor and joint at once: as a joint its name is {twin}")
        files += write_firmware(
            replace(mechanism, name=stem),
            folder / stem if len(several) > 1 else folder,
            given=one.motors,
            find=[twins.get(name, name) for name in one.joints],
            also=also,
        )
    return files
