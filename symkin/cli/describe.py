"""`symkin list` and `symkin show`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from symkin.cli.options import MechArgument


def list_() -> None:
    """List the shipped mechanisms."""
    from symkin.model.file import load, shipped_names

    names = shipped_names()
    for name in names:
        print(f"{name:{max(map(len, names))}}  {load(name).title}")


def show(
    mech: MechArgument,
    latex: Annotated[bool, typer.Option("--latex", help="Print the closure equations as LaTeX.")] = False,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw a kinematic sketch into a file.")] = None,
) -> None:
    """Show limbs, unknowns, rank, mobility, redundant constraints and reciprocal screws."""
    from symkin.model.file import load

    mechanism = load(mech)
    if plot is not None:
        from symkin.plots.sketch import draw_sketch

        draw_sketch(mechanism, plot)
    if latex:
        from symkin.codegen.latex import equations

        print(equations(mechanism))
        return
    from symkin.position.describe import describe

    print(describe(mechanism))
    if plot is not None:
        print(f"\npicture: {plot}")
