"""`symkin view`."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from symkin.cli.options import MechArgument
from symkin.cli.poses import PoseForm
from symkin.cli.progress import progress_bar
from symkin.cli.values import Asked
from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions
from symkin.page.options import ViewOptions
from symkin.verb_options import GIVEN, OUTPUT, Option

if TYPE_CHECKING:
    from symkin.model.mechanism import Mechanism
    from symkin.page.view import View


def view(
    mech: MechArgument,
    read: ReadOptions,
    options: ViewOptions,
    form: PoseForm,
    swept: Annotated[
        Path | None,
        Option(
            "A folder of `symkin sweep`: its map is shown, and the mechanism goes where "
            "one points.",
            "FOLDER",
            GIVEN,
            flags=("--map",),
        ),
    ] = None,
    html: Annotated[
        Path | None,
        Option("Write the page, and open no browser.", "FILE.html", OUTPUT),
    ] = None,
) -> None:
    """Show the mechanism in the browser, where it moves; `symkin view MECH --html FILE.html` writes
    the page into one file.

    Meshes in COLLADA (.dae) take pycollada: pip install 'symkin[meshes]'
    """
    from symkin.page.result_views import view as view_of

    asked, told = Asked.of(mech, read, form), {**options, **form}
    of_map = {name: told.pop(name) for name in ("slices", "loci")}
    if swept is not None:
        for name, value in told.items():
            if value is not None:
                raise InputError(
                    f"both --map and --{name} are given; a map brings its values: give one of them"
                )
    elif of_map["slices"] is not None or of_map["loci"]:
        raise InputError(
            f"{'--loci' if of_map['slices'] is None else '--slice'} belongs to the map of a "
            f"sweep; give --map FOLDER, or leave it out"
        )
    values = asked.values(ViewOptions, options, "pose")
    if swept is None:
        print(_shown(view_of(asked.mechanism, **values), html))
    else:
        print(_shown(_of_map(asked.mechanism, swept, **values), html))


def _of_map(
    mechanism: Mechanism,
    folder: Path,
    slices: Mapping[str, float] | None = None,
    *,
    loci: bool,
) -> View:
    """The page of a sweep's map. Raises InputError for a sweep of another mechanism."""
    from symkin.page.sweep_plane import view_of_sweep

    with progress_bar("singularity loci") if loci else nullcontext():
        page = view_of_sweep(folder, slices, loci=loci)
    if page.mechanism.to_toml() != mechanism.to_toml():
        raise InputError(
            f"--map {folder}: the sweep is of {page.mechanism.name}, or its geometry is another "
            f"than that of {mechanism.name}"
        )
    return page


def _shown(page: View, html: Path | None) -> str:
    """Write the page or open it; what became of it, in a line."""
    if html is not None:
        return f"page: {page.save(html)}"
    place = page.open()
    return (
        f"page: {place}\n"
        f"opened in the browser; if none appears, open this file in one, or write your own with "
        f"--html FILE.html"
    )
