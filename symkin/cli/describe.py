"""`symkin show`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from symkin.cli.options import JsonOption, MechArgument, print_result
from symkin.cli.pictures import NamesOption, picture_options
from symkin.cli.reading import RobotFile, loaded
from symkin.errors import InputError
from symkin.verb_options import OUTPUT, Option


def show(
    mech: MechArgument,
    read: RobotFile,
    latex: Annotated[
        bool,
        Option("Print the closure equations as LaTeX.", group=OUTPUT),
    ] = False,
    plot: Annotated[
        Path | None,
        Option("Draw a kinematic sketch into a file.", "FILE.png", OUTPUT),
    ] = None,
    names: NamesOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show limbs, unknowns, rank, mobility, redundant constraints and reciprocal screws."""

    if latex and as_json:
        raise InputError(
            "both --latex and --json are given; the equations are LaTeX, the account is JSON: give "
            "one of them"
        )
    mechanism = loaded(mech, read)
    options = picture_options(plot, mechanism, names=names)
    if plot is not None:
        from symkin.plots.figures import draw_sketch

        draw_sketch(mechanism, plot, **options)
    if latex:
        from symkin.codegen.text.latex import equations

        print(equations(mechanism))
        return
    from symkin.position.describe import describe
    from symkin.position.mobility import mobility

    picture = "" if plot is None else f"\n\npicture: {plot}"
    print_result(
        as_json, lambda: mobility(mechanism).to_dict(), lambda: describe(mechanism) + picture
    )
