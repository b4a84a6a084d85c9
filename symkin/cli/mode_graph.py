"""`symkin mode-graph`."""

from typing import Annotated

from symkin.cli.options import JsonOption, MechArgument, print_result, ranges_from
from symkin.cli.pictures import Picture
from symkin.cli.progress import progress_bar
from symkin.cli.values import Asked
from symkin.following.options import GraphOptions
from symkin.formats.read_options import ReadOptions
from symkin.verb_options import ASKED, Option


def mode_graph(
    mech: MechArgument,
    read: ReadOptions,
    options: GraphOptions,
    picture: Picture,
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
    as_json: JsonOption = False,
) -> None:
    """Find which modes connect without a singularity, over a grid of one or two of the known
    coordinates about what is given.
    """
    from symkin.following.mode_graph import mode_graph as graph_of_modes

    asked = Asked.of(mech, read, picture=picture)
    needed = "NAME=LOW:HIGH,..., such as crank=0:360,"
    ranges = ranges_from(over, "over", asked.unit, needed)
    axes = [(name, low, high) for name, (low, high) in ranges.items()]
    with progress_bar("points and lines") as progress:
        found = graph_of_modes(
            asked.mechanism,
            axes,
            points,
            **asked.values(GraphOptions, options),
            progress=progress,
        )
    print_result(as_json, found, asked.drawing.of(found))
