"""`symkin view`."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from symkin.cli.options import MechArgument, slices_from
from symkin.cli.poses import PoseForm
from symkin.cli.progress import progress_bar
from symkin.cli.reading import RobotFile
from symkin.cli.values import Asked
from symkin.errors import InputError
from symkin.position.options import Given
from symkin.verb_options import GIVEN, OUTPUT, Option

if TYPE_CHECKING:
    from symkin.model.mechanism import Mechanism
    from symkin.page.view import View


def view(
    mech: MechArgument,
    read: RobotFile,
    inputs: Given,
    form: PoseForm,
    path: Annotated[
        Path | None,
        Option(
            "A trajectory to play: columns of the given coordinates, or poses.", "FILE.csv", GIVEN
        ),
    ] = None,
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
    slices: Annotated[
        str | None,
        Option(
            "Where --map cuts a grid of more than two dimensions.",
            "NAME=VALUE,...",
            GIVEN,
            flags=("--slice",),
        ),
    ] = None,
    loci: Annotated[
        bool,
        Option("Lay the curves of singular configurations over --map.", group=GIVEN),
    ] = False,
    html: Annotated[
        Path | None,
        Option("Write the page, and open no browser.", "FILE.html", OUTPUT),
    ] = None,
) -> None:
    """Show the mechanism in the browser, where it moves; `symkin view MECH --html FILE.html` writes
    the page into one file.

    Meshes in COLLADA (.dae) take pycollada: pip install 'symkin[meshes]'
    """
    from symkin.page.view import view_mechanism

    asked = Asked.of(mech, read, form)
    mechanism, told = asked.mechanism, {**inputs, **form, "path": path}
    if swept is not None:
        for name, value in told.items():
            if value is not None:
                raise InputError(
                    f"both --map and --{name} are given; a map brings its values: give one of them"
                )
        print(_shown(_of_map(mechanism, swept, slices, loci=loci), html))
        return
    if slices is not None or loci:
        raise InputError(
            f"{'--slice' if slices is not None else '--loci'} belongs to the map of a sweep; give "
            f"--map FOLDER, or leave it out"
        )
    if told["pose"] is not None:
        for name in ("joints", "given", "path"):
            if told[name] is not None:
                raise InputError(
                    f"both --pose and --{name} are given; each tells where the page begins: give "
                    f"one of them"
                )
    values = asked.values(Given, inputs, "pose")
    given = _plain(values.pop("given", None))
    print(_shown(view_mechanism(mechanism, given=given, path=path, **values), html))


def _of_map(mechanism: Mechanism, folder: Path, slices: str | None, *, loci: bool) -> View:
    """The page of a sweep's map. Raises InputError for a sweep of another mechanism."""
    from symkin.page.sweep_plane import view_of_sweep

    cuts = slices_from(slices, mechanism.angle_unit)
    with progress_bar("singularity loci") if loci else nullcontext():
        page = view_of_sweep(folder, cuts, loci=loci)
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


def _plain(values: dict[str, float | list[float]] | None) -> dict[str, float] | None:
    """Values of single coordinates: sliders have no whole poses."""
    if values is None:
        return None
    if any(isinstance(value, list) for value in values.values()):
        raise InputError(
            "--given: pose=... is a whole pose, and sliders have single coordinates: write --pose "
            "X,Y,Z,QW,QX,QY,QZ, or x, y, z, azimuth, tilt, "
            "torsion one by one"
        )
    return {name: value for name, value in values.items() if isinstance(value, (int, float))}
