"""`symkin modes` and `symkin solve`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from symkin.assembly.options import ModesOptions
from symkin.cli.options import AllOption, JsonOption, MechArgument, print_result
from symkin.cli.pictures import Drawing, PictureOfSides
from symkin.cli.poses import PoseForm
from symkin.cli.progress import progress_bar
from symkin.cli.values import Asked
from symkin.formats.read_options import ReadOptions
from symkin.position.options import Given, SolveOptions
from symkin.verb_options import OUTPUT, Option

if TYPE_CHECKING:
    from symkin.assembly.modes_result import Modes


def modes(
    mech: MechArgument,
    read: ReadOptions,
    inputs: Given,
    form: PoseForm,
    options: ModesOptions,
    picture: PictureOfSides,
    shown: Annotated[
        str | None,
        Option(
            "Modes in the picture, such as 1-16 or 1,3, or all. Default: 12 of them.",
            "K1-K2,...",
            OUTPUT,
            flags=("--modes",),
        ),
    ] = None,
    everything: AllOption = False,
    as_json: JsonOption = False,
) -> int:
    """Find every solution: assembly modes of given joints, working modes of a given pose."""
    from symkin.assembly.modes import modes as find_modes

    asked = Asked.of(mech, read, form, {**picture, "modes": shown})
    with progress_bar("solutions") as progress:
        found = find_modes(
            asked.mechanism,
            **asked.values(Given, inputs, "pose", "given"),
            **asked.values(ModesOptions, options),
            progress=progress,
        )
    print_result(as_json, found, _drawn(found, asked.drawing), everything=everything)
    return 0 if found.modes or found.positive_dimensional else 3


def _drawn(found: Modes, drawing: Drawing) -> str:
    """Draw the modes; the line that names the picture and what it leaves out."""
    line = drawing.of(found)
    if not line:
        return ""
    from symkin.plots.modes_plot import left_out, shown_numbers

    missing = left_out(found, shown_numbers(found, drawing.options.get("modes")))
    return line + (f" ({missing})" if missing else "")


def solve(
    mech: MechArgument,
    read: ReadOptions,
    options: SolveOptions,
    form: PoseForm,
    picture: PictureOfSides,
    everything: AllOption = False,
    as_json: JsonOption = False,
) -> int:
    """Find one solution near a start."""
    from symkin.position.solve import solve as solve_one

    asked = Asked.of(mech, read, form, picture)
    values = asked.values(SolveOptions, options, "pose", "given", "start")
    result = solve_one(asked.mechanism, **values, check=False)
    drawn = asked.drawing.of(None if result.solution is None else result)
    print_result(as_json, result, drawn, everything=everything)
    return 0 if result.solution is not None else 3
