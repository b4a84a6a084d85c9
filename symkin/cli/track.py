"""`symkin track`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from symkin.cli.options import (
    JsonOption,
    MechArgument,
    StartOption,
    check_output,
    joints_from,
    print_result,
    whole_number,
)
from symkin.cli.progress import progress_bar
from symkin.errors import InputError


def track(
    mech: MechArgument,
    begin: Annotated[
        str | None, typer.Option("--from", metavar="V1,V2,...", help="All actuated joints at the beginning.")
    ] = None,
    end: Annotated[str | None, typer.Option("--to", metavar="V1,V2,...", help="All actuated joints at the end.")] = None,
    poses: Annotated[bool, typer.Option("--poses", help="--from, --to or the CSV file are poses: the inverse problem.")] = False,
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE.csv", help="A trajectory, in place of --from and --to.")
    ] = None,
    start: StartOption = None,
    samples: Annotated[
        int | None, typer.Option(metavar="N", parser=whole_number, help="Samples on the path; default 101, or those of the file.")
    ] = None,
    ignore_limits: Annotated[bool, typer.Option("--ignore-limits", help="Go on beyond joint limits.")] = False,
    output: Annotated[Path | None, typer.Option("-o", metavar="FILE.csv", help="Write the configurations into a file.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw the track into a file.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Follow one mode along a path of joints or poses, with a proof, up to the first singularity or limit."""
    from symkin.following.track import track as follow_mode
    from symkin.following.track_csv import read_trajectory, write_track
    from symkin.model.file import load

    mechanism = load(mech)
    check_output(output, mech, csv)
    if plot is not None:
        from symkin.plots.picture_file import check_picture_path

        check_picture_path(plot)
    if csv is not None:
        if begin is not None or end is not None:
            raise InputError("both --csv and --from or --to are given; give one of them")
        path = read_trajectory(mechanism, csv, poses=poses)
    else:
        path = _straight(begin, end, poses, mechanism.angle_unit)
        samples = 101 if samples is None else samples
    begun = joints_from(start, "start", mechanism.angle_unit)
    with progress_bar("samples") as progress:
        found = follow_mode(mechanism, **path, start=begun, samples=samples, limits=not ignore_limits, progress=progress)
    if output is not None:
        write_track(found, output)
    drawn = plot if found.samples else None
    if drawn is not None:
        found.plot(drawn)
    files = "".join(f"\n{what}: {name}" for what, name in (("configurations", output), ("picture", drawn)) if name is not None)
    print_result(as_json, found.to_dict, lambda: str(found) + files)
    raise typer.Exit(0 if found.reached else 3)


def _straight(begin: str | None, end: str | None, poses: bool, unit: str) -> dict[str, Any]:
    if begin is None or end is None:
        missing = "--from" if begin is None else "--to"
        raise InputError(f"{missing} is missing; a path is --from and --to, or --csv FILE")
    return {"poses" if poses else "joints": [joints_from(begin, "from", unit), joints_from(end, "to", unit)]}
