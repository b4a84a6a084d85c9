"""`symkin mode-graph`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from symkin.cli.options import (
    GivenOption,
    JointsOption,
    JsonOption,
    MechArgument,
    joints_from,
    named_from,
    print_result,
    ranges_from,
)
from symkin.cli.progress import progress_bar
from symkin.cli.reading import RobotFile, loaded
from symkin.verb_options import ASKED, OUTPUT, Option


def mode_graph(
    mech: MechArgument,
    read: RobotFile,
    over: Annotated[
        str,
        Option(
            "One or two of the known coordinates, each with a range.", "NAME=LOW:HIGH,...", ASKED
        ),
    ],
    points: Annotated[
        int,
        Option("Points along each range, 2 to 100. Default: 11.", "N", ASKED),
    ] = 11,
    joints: JointsOption = None,
    given: GivenOption = None,
    plot: Annotated[
        Path | None,
        Option("Draw the sheets into a file.", "FILE.png", OUTPUT),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Find which modes connect without a singularity, over a grid of one or two of the known
    coordinates about what is given.
    """
    from symkin.following.mode_graph import mode_graph as graph_of_modes
    from symkin.plots.picture_file import check_picture_path

    mechanism = loaded(mech, read)
    if plot is not None:
        check_picture_path(plot)
    unit = mechanism.angle_unit
    needed = "NAME=LOW:HIGH,..., such as crank=0:360,"
    ranges = ranges_from(over, "over", unit, needed)
    axes = [(name, low, high) for name, (low, high) in ranges.items()]
    with progress_bar("points and lines") as progress:
        found = graph_of_modes(
            mechanism,
            axes,
            points,
            joints=joints_from(joints, "joints", unit),
            given=None if given is None else named_from(given, "given", unit),
            progress=progress,
        )
    if plot is not None:
        found.plot(plot)
    picture = "" if plot is None else f"\npicture: {plot}"
    print_result(as_json, found.to_dict, lambda: str(found) + picture)
