"""`symkin show`."""

from __future__ import annotations

from typing import Annotated

from symkin.cli.options import JsonOption, MechArgument, print_either
from symkin.cli.pictures import NamedPicture
from symkin.cli.values import Asked
from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions
from symkin.verb_options import OUTPUT, Option


def show(
    mech: MechArgument,
    read: ReadOptions,
    picture: NamedPicture,
    latex: Annotated[
        bool,
        Option("Print the closure equations as LaTeX.", group=OUTPUT),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Show limbs, unknowns, rank, mobility, redundant constraints and reciprocal screws."""

    if latex and as_json:
        raise InputError(
            "both --latex and --json are given; the equations are LaTeX, the account is JSON: give "
            "one of them"
        )
    asked = Asked.of(mech, read, picture=picture)
    mechanism, drawing = asked.mechanism, asked.drawing
    if drawing.path is not None:
        from symkin.plots.figures import draw_sketch

        draw_sketch(mechanism, drawing.path, **drawing.options)
    if latex:
        from symkin.codegen.text.latex import equations

        print(equations(mechanism))
        return
    from symkin.position.describe import describe
    from symkin.position.mobility import mobility

    drawn = "" if drawing.path is None else f"\n\npicture: {drawing.path}"
    print_either(
        as_json, lambda: mobility(mechanism).to_dict(), lambda: describe(mechanism) + drawn
    )
