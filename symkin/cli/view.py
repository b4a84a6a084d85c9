"""`symkin view`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from symkin.cli.help import GIVEN, OUTPUT
from symkin.cli.options import GivenOption, JointsOption, MechArgument, joints_from, named_from
from symkin.cli.reading import loaded, reads_robots
from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions

if TYPE_CHECKING:
    from symkin.page.view import View


@reads_robots
def view(
    mech: MechArgument,
    read: ReadOptions,
    joints: JointsOption = None,
    given: GivenOption = None,
    path: Annotated[
        Path | None,
        typer.Option(
            "--path",
            metavar="FILE.csv",
            help="A trajectory to play: columns of the given coordinates, or poses.",
            rich_help_panel=GIVEN,
        ),
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option("--html", metavar="FILE.html", help="Write the page, and open no browser.", rich_help_panel=OUTPUT),
    ] = None,
) -> None:
    """Show the mechanism in the browser, where it moves; `symkin view MECH --html FILE.html` writes the page into one file."""
    from symkin.page.played_path import played_path
    from symkin.page.view import view_mechanism

    mechanism = loaded(mech, read)
    values = _plain(named_from(given, "given", mechanism.angle_unit))
    played = None if path is None else played_path(mechanism, path, values)
    if played is not None and values is None and joints is None:
        values = dict(zip(played.names, played.rows[0], strict=True))
    page = view_mechanism(mechanism, joints_from(joints, "joints", mechanism.angle_unit), values, played)
    print(_shown(page, html))


def _shown(page: View, html: Path | None) -> str:
    """Write the page or open it; what became of it, in a line."""
    if html is not None:
        return f"page: {page.save(html)}"
    place = page.open()
    return (
        f"page: {place}\nopened in the browser; if none appears, open this file in one, or write your own with --html FILE.html"
    )


def _plain(values: dict[str, float | list[float]] | None) -> dict[str, float] | None:
    """Values of single coordinates: sliders have no whole poses."""
    if values is None:
        return None
    if any(isinstance(value, list) for value in values.values()):
        raise InputError(
            "--given: pose=... is a whole pose; a page takes its coordinates one by one: x, y, z, azimuth, tilt, torsion"
        )
    return {name: value for name, value in values.items() if isinstance(value, (int, float))}
