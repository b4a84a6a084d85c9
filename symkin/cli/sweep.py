"""`symkin sweep`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from symkin.cli.options import (
    Interrupted,
    JsonOption,
    MechArgument,
    check_output,
    joints_from,
    names_from,
    output_option,
    print_result,
    slices_from,
)
from symkin.cli.pictures import Picture
from symkin.cli.poses import PoseForm
from symkin.cli.progress import progress_bar
from symkin.cli.values import Asked
from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions
from symkin.model.mechanism import Mechanism
from symkin.sweeps.options import SweepOptions
from symkin.verb_options import GIVEN, OUTPUT, Option


def sweep(
    mech: MechArgument,
    read: ReadOptions,
    *,
    output: Annotated[
        Path,
        output_option("Folder of the arrays (Zarr); a begun sweep goes on.", "DIR"),
    ],
    options: SweepOptions,
    form: PoseForm,
    grid: Annotated[
        str | None,
        Option(
            "What is swept of the actuated joints, or of poses; NAME=LOW:HIGH with --random, "
            "NAME=VALUE for one value.",
            "NAME=LOW:HIGH:COUNT,...",
            GIVEN,
        ),
    ] = None,
    given: Annotated[
        str | None,
        Option(
            "In place of --grid: any coordinates, as many as the mobility, swept or held; as "
            "--given of modes.",
            "NAME=LOW:HIGH:COUNT,NAME=VALUE,...",
            GIVEN,
        ),
    ] = None,
    at: Annotated[
        str | None,
        Option(
            "What is not swept: all actuated joints, or a pose with --poses.", "V1,V2,...", GIVEN
        ),
    ] = None,
    as_json: JsonOption = False,
    picture: Picture,
    of: Annotated[
        str | None,
        Option(
            "What is drawn in place of the map: the paths of named points, or joints.",
            "NAME,...",
            OUTPUT,
        ),
    ] = None,
    loci: Annotated[
        bool,
        Option("Lay the curves of singular configurations over the map of --plot.", group=OUTPUT),
    ] = False,
    table: Annotated[
        Path | None,
        Option(
            "Write the result as a table too, a row a mode.", "FILE.csv", OUTPUT, flags=("--csv",)
        ),
    ] = None,
    slices: Annotated[
        str | None,
        Option(
            "Where the map cuts a grid of more than two dimensions.",
            "NAME=VALUE,...",
            OUTPUT,
            flags=("--slice",),
        ),
    ] = None,
) -> None:
    """Find every solution over a grid or a random sample of inputs or poses, into labelled arrays
    that xarray reads.

    Needs xarray, zarr and dask: pip install 'symkin[sweep]'
    """
    import numpy as np

    from symkin.cli.ranges import read_values
    from symkin.sweeps.map_slice import check_drawable, check_map_is_left, check_slices
    from symkin.sweeps.run import sweep as run
    from symkin.sweeps.store import require_zarr

    require_zarr()
    asked = Asked.of(mech, read, form, {**picture, "of": of, "slice": slices, "loci": loci})
    mechanism, unit = asked.mechanism, asked.unit
    poses, sampled = options["poses"], options["random"] is not None
    ranges: Any
    told: Any
    ranges, told = (
        None if text is None else read_values(text, option, sampled=sampled, angle_unit=unit)
        for text, option in ((grid, "grid"), (given, "given"))
    )
    either = (told if ranges is None else ranges) or {}
    values = {n: v for n, v in either.items() if isinstance(v, np.ndarray)}
    cuts = {} if slices is None else slices_from(slices, unit)
    check_slices(cuts, values, sampled=sampled)
    check_map_is_left(cuts, values)
    drawn = names_from(of)
    if not all(drawn):
        raise InputError(f"--of {of!r}: names separated by commas are needed")
    if loci and drawn:
        raise InputError(
            "both --loci and --of are given; --loci belongs to the map, in whose place --of draws "
            "points or joints"
        )
    if loci and poses:
        _check_pose_loci(mechanism, list(values))
    if drawn:
        check_drawable(mechanism, options["quantity"], list(values), drawn)
    check_output(table)
    asked.reader.check_used(at if poses else None)
    held = asked.reader.pose(at, "at") if poses else joints_from(at, "at", unit)
    with _kept_when_interrupted(output), progress_bar("points") as progress:
        swept = run(
            mechanism,
            ranges,
            output,
            given=told,
            at=held,
            progress=progress,
            **asked.values(SweepOptions, options),
        )
    more = ""
    if table is not None:
        more += f"\nwritten: {table}, {swept.write_csv(table)} rows"
    shown = replace(asked.drawing, options={"slices": cuts, "of": drawn, "loci": loci})
    with progress_bar("singularity loci") if loci else nullcontext():
        more += shown.of(swept)
    print_result(as_json, swept, more)


def _check_pose_loci(mechanism: Mechanism, names: Sequence[str]) -> None:
    """Raise InputError where no loci are traced over poses; known before the sweep, which may take
    long.
    """
    from symkin.singularities.locus_system import pose_planes
    from symkin.singularities.singular_loci import check_poses_vary

    found = pose_planes(mechanism)
    if found is None:
        raise InputError(
            f"--loci with --poses: {mechanism.name} is no platform on limbs, and its loci are "
            f"traced over joints; sweep joints with --grid or --given, or leave --loci out"
        )
    check_poses_vary(found.machine, names)


@contextmanager
def _kept_when_interrupted(folder: Path) -> Iterator[None]:
    """Ctrl-C says what is not lost."""
    try:
        yield
    except KeyboardInterrupt:
        kept = f"finished chunks are kept in {folder}, and the same command goes on from there"
        raise Interrupted(
            kept if (folder / "zarr.json").exists() else "nothing was begun"
        ) from None
