"""`symkin calibrate fit`: identify a mechanism's geometry from measurements."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from symkin.calibration.options import FileOptions
from symkin.cli.calibrate_folder import PICTURES, check_folder, write_fit, write_unfitted
from symkin.cli.calibrate_options import (
    MEASURES,
    DataArgument,
    ForceOption,
    PicturesOption,
    Sigmas,
)
from symkin.cli.options import MechArgument, output_option
from symkin.cli.quantities import distance_points, joint_quantities, quantity, tolerances
from symkin.cli.reading import loaded
from symkin.cli.streams import print_text
from symkin.formats.read_options import ReadOptions

if TYPE_CHECKING:
    from symkin.model.mechanism import Mechanism


def fit(
    mech: MechArgument,
    read: ReadOptions,
    data: DataArgument,
    output: Annotated[
        Path,
        output_option("Folder for the mechanism file and the report.", "DIR"),
    ],
    options: FileOptions,
    sigmas: Sigmas,
    pictures: PicturesOption = False,
    force: ForceOption = False,
) -> int:
    """Identify the geometry: DIR/NAME.toml, report.json, report.md. Exit status 3: not usable."""
    from symkin.calibration.data.files import read_measurements
    from symkin.calibration.fit_file import NotFittedError, fit_file

    mechanism = loaded(mech, read)
    check_folder(output, mech, mechanism, force=force)
    ends = distance_points(sigmas["distance"], mechanism)
    given: dict[str, Any] = {
        kind: quantity(text, measure, mechanism, f"sigma-{kind}")
        for kind, measure in MEASURES.items()
        if (text := sigmas[f"sigma_{kind}"]) is not None  # type: ignore[literal-required]
    }
    if sigmas["sigma_joints"] is not None:
        given["joint"] = joint_quantities(sigmas["sigma_joints"], mechanism, "sigma-joints")
    told: Any = options["tolerance"]
    options["tolerance"] = None if told is None else tolerances(told, mechanism)
    try:
        report = fit_file(
            mechanism,
            read_measurements(data, mechanism, ends),
            sigmas=given,
            command=shlex.join(["symkin", *sys.argv[1:]]),
            **options,
        )
    except NotFittedError as error:
        written = write_unfitted(mechanism, data, error, output)
        print(f"{mechanism.name}: {error}")
        _note_earlier(output, mechanism, written)
        return 3
    written = write_fit(report, output, pictures=pictures)
    print_text(report.summary())
    print("written: " + ", ".join(str(path) for path in written))
    if not report.usable:
        print(f"no mechanism file was written: {report.verdict}")
    _note_earlier(output, mechanism, written)
    return 0 if report.usable else 3


def _note_earlier(output: Path, mechanism: Mechanism, written: list[Path]) -> None:
    """Say which files of the folder an earlier fit has left: they are kept and are not of this
    fit.
    """
    for left in (output / name for name in (f"{mechanism.name}.toml", *PICTURES)):
        if left not in written and left.exists():
            print(f"note: {left} is of an earlier fit, not of this one")
