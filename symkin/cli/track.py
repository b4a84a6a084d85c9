"""`symkin track`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, cast

from symkin.cli.options import (
    JsonOption,
    MechArgument,
    check_output,
    joints_from,
    output_option,
    print_result,
    ranges_from,
)
from symkin.cli.pictures import Drawing, PictureOfSides
from symkin.cli.poses import EULER, PoseReader
from symkin.cli.progress import progress_bar
from symkin.cli.reading import loaded
from symkin.errors import InputError
from symkin.following.options import TrackOptions
from symkin.formats.read_options import ReadOptions
from symkin.text import shown
from symkin.verb_options import GIVEN, Option

_PATH = "NAME=FROM:TO,..., such as crank=0:360,"
"""How a path by names is written."""


def track(
    mech: MechArgument,
    read: ReadOptions,
    picture: PictureOfSides,
    *,
    begin: Annotated[
        str | None,
        Option(
            "All actuated joints at the beginning, or NAME=VALUE,... of any coordinates.",
            "V1,V2,...",
            GIVEN,
            flags=("--from",),
        ),
    ] = None,
    end: Annotated[
        str | None,
        Option("The same at the end.", "V1,V2,...", GIVEN, flags=("--to",)),
    ] = None,
    poses: Annotated[
        bool,
        Option("--from, --to or the CSV file are poses: the inverse problem.", group=GIVEN),
    ] = False,
    euler: Annotated[str | None, EULER] = None,
    csv: Annotated[
        Path | None,
        Option("A trajectory, in place of --from and --to.", "FILE.csv", GIVEN),
    ] = None,
    given: Annotated[
        str | None,
        Option(
            "A path of any coordinates, as many as the mobility, in place of --from and --to; "
            "NAME=VALUE stands, NAME alone is a "
            "column of --csv.",
            "NAME=FROM:TO,...",
            GIVEN,
        ),
    ] = None,
    options: TrackOptions,
    ignore_limits: Annotated[
        bool,
        Option("Go on beyond joint limits."),
    ] = False,
    output: Annotated[
        Path | None,
        output_option("Write the configurations into a file.", "FILE.csv"),
    ] = None,
    as_json: JsonOption = False,
) -> int:
    """Follow one mode along a path of joints, poses or any coordinates, with a proof, up to the
    first singularity or limit.
    """
    from symkin.following.track import track as follow_mode
    from symkin.following.track_csv import read_trajectory, write_track

    mechanism, start = loaded(mech, read), cast("str | None", options["start"])
    check_output(output, mech, csv)
    drawing = Drawing.checked(picture, mechanism)
    reader = PoseReader(mechanism, euler=euler, has_rpy=False)
    if euler is not None and csv is not None and start is None:
        raise InputError(
            "--euler is for --from and --to; a file's header names its angles, as in "
            "euler_ZYX_1[deg] or roll[deg]"
        )
    reader.check_used(start, *((begin, end) if poses else ()))
    if given is not None and poses:
        raise InputError(
            "both --given and --poses are given; --given names the coordinates of the path"
        )
    by_name = None
    if begin is not None or end is not None:
        for option, value in (("--csv", csv), ("--given", given)):
            if value is not None:
                raise InputError(f"both {option} and --from or --to are given; give one of them")
    if given is not None:
        by_name = _by_name(given, mechanism.angle_unit, of_file=csv is not None)
    if csv is not None:
        path = read_trajectory(mechanism, csv, poses=poses, given=by_name)
    else:
        path = _straight(begin, end, poses, reader) if by_name is None else {"given": by_name}
        options["samples"] = 101 if options["samples"] is None else options["samples"]
    options["limits"] = not ignore_limits
    options["start"] = reader.start(start, is_pose=not poses)
    with progress_bar("samples") as progress:
        options["progress"] = progress
        found = follow_mode(mechanism, **path, **options)
    if output is not None:
        write_track(found, output)
    files = "" if output is None else f"\nconfigurations: {output}"
    files += drawing.of(found if found.samples else None)
    print_result(as_json, found, files)
    return 0 if found.reached else 3


def _straight(
    begin: str | None, end: str | None, poses: bool, reader: PoseReader
) -> dict[str, Any]:
    """The path of --from and --to: joints, poses, or values by name that are not those of all
    actuated joints.
    """
    if begin is None or end is None:
        missing = "--from" if begin is None else "--to"
        raise InputError(
            f"{missing} is missing; a path is --from and --to, --given NAME=FROM:TO,..., or --csv "
            f"FILE"
        )
    if poses:
        return {"poses": [reader.pose(begin, "from"), reader.pose(end, "to")]}
    mechanism, unit = reader.mechanism, reader.mechanism.angle_unit
    ends = [joints_from(begin, "from", unit), joints_from(end, "to", unit)]
    named = [e for e in ends if isinstance(e, dict)]
    if len(named) == 2 and {*named[0], *named[1]} != {c.name for c in mechanism.actuated}:
        lone = sorted(set(named[0]) ^ set(named[1]))
        if lone:
            raise InputError(
                f"--from and --to: {lone[0]} stands in one of them only; both name the same "
                f"coordinates"
            )
        return {"given": {name: [named[0][name], named[1][name]] for name in named[0]}}
    return {"joints": ends}


def _by_name(given: str, unit: str, *, of_file: bool) -> dict[str, Any]:
    """The path of --given NAME=FROM:TO,..., or with a file the columns of --csv that it names and
    values that stand.
    """
    columns: dict[str, float | list[float] | None] = {}
    for name, values in ranges_from(given, "given", unit, _PATH, (0, 1, 2)).items():
        if of_file and len(values) > 1:
            raise InputError(
                f"--given: {name}={values[0]:g}:{values[1]:g} is a path of its own; with --csv a "
                f"name is a column, NAME=VALUE stands"
            )
        if not of_file and not values:
            raise InputError(
                f"--given: {name} has no values; NAME=FROM:TO,... is needed without --csv, "
                f"NAME=VALUE for one that stands"
            )
        columns[name] = values if len(values) == 2 else values[0] if values else None
    if not of_file and not any(isinstance(column, list) for column in columns.values()):
        raise InputError(
            f"--given {shown(given)}: nothing moves; a path has NAME=FROM:TO for at least one "
            f"coordinate"
        )
    return columns
