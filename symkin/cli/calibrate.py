"""`symkin calibrate fit`: identify a mechanism's geometry from measurements. The folder that it
writes holds mechanism, report and, where they are asked for, pictures; every file whole or not at
all.
"""

from __future__ import annotations

import json
import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from symkin._version import __version__
from symkin.calibration.options import FileOptions
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
from symkin.errors import InputError
from symkin.files.outputs import write_output
from symkin.files.written_files import (
    MANIFEST,
    digest,
    foreign_files,
    read_manifest,
    refuse_foreign,
)
from symkin.formats.read_options import ReadOptions
from symkin.text import markdown

if TYPE_CHECKING:
    from symkin.calibration.fit_file import NotFittedError
    from symkin.calibration.report import FitReport
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


PICTURES = ("residuals.png", "parameters.png", "pose_sigma.png")
_REPORTS = ("report.json", "report.md")
_KEY, _REPLACED = "calibration", "replaced"
"""What the manifest of a calibration has, and others have not; and digests of files that a run
under way replaces.
"""


def check_folder(folder: Path, mech: str, mechanism: Mechanism, *, force: bool = False) -> None:
    """Refuse, before anything is computed, a folder that cannot be written, one where the file
    given would be lost and, unless `force`, one where a file stands that no fit of this mechanism
    has written or that was edited since.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; the name of a folder is needed")
    target = folder / f"{mechanism.name}.toml"
    if Path(mech).is_file() and target.exists() and target.samefile(mech):
        raise InputError(
            f"{target} is the mechanism that was given and would be lost; name another folder"
        )
    there = next(p for p in (folder, *folder.absolute().parents) if p.exists())
    if not os.access(there, os.W_OK):
        raise InputError(f"{folder}: the folder cannot be written (permission denied)")
    if not force:
        _check_own(folder, mechanism)


def _check_own(folder: Path, mechanism: Mechanism) -> None:
    written = read_manifest(folder, _KEY)
    remedy = "give another folder with -o, or say --force"
    if written.get(_KEY, mechanism.name) != mechanism.name:
        raise InputError(f"{folder}: holds the calibration of {written[_KEY]!r}; {remedy}")
    digests = {
        name: (d, written.get(_REPLACED, {}).get(name))
        for name, d in written.get("files", {}).items()
    }
    names = [*PICTURES, *_REPORTS, f"{mechanism.name}.toml", *([] if written else [MANIFEST])]
    refuse_foreign(
        folder, foreign_files(folder, names, digests), digests, f"move them away, {remedy}"
    )


def write_fit(report: FitReport, folder: Path, *, pictures: bool = False) -> list[Path]:
    """Write every file whole or not at all; the mechanism and what it says of poses only if it can
    be used.
    """
    from symkin.calibration.fit_file import calibrated_mechanism

    drawn = _drawn(report) if pictures else {}
    contents = {
        **drawn,
        "report.json": report.json_text(),
        "report.md": report.to_markdown([Path(name) for name in drawn]).encode(),
    }
    if report.usable:
        made = calibrated_mechanism(report)
        contents[f"{made.name}.toml"] = made.to_toml().encode()
    return _write_contents(folder, report.fit.mechanism, contents)


def _drawn(report: FitReport) -> dict[str, bytes]:
    """Draw the pictures of a report, by file name."""
    from symkin.plots.calibration_plot import (
        parameter_figure,
        pose_sigma_figure,
        residual_figure,
    )
    from symkin.plots.pictures import picture

    figures = [residual_figure(report.fit), parameter_figure(report.fit)]
    if report.usable:
        figures.append(pose_sigma_figure(report.fit, report.sigma))
    return {name: picture(figure) for name, figure in zip(PICTURES, figures, strict=False)}


def write_unfitted(
    mechanism: Mechanism, data: Path, error: NotFittedError, folder: Path
) -> list[Path]:
    """The report of a file that nothing can be fitted to."""
    content = {
        "mechanism": mechanism.name,
        "data": str(data),
        "verdict": str(error),
        "believable": False,
        "usable": False,
        "suspicions": list(error.suspicions),
    }
    lines = "".join(f"- {markdown(line)}\n" for line in error.suspicions)
    text = f"# Calibration of {mechanism.name}\n\n{markdown(str(error))}\n\n{lines}"
    return _write_contents(
        folder,
        mechanism,
        {
            "report.json": (json.dumps(content, indent=1) + "\n").encode(),
            "report.md": text.encode(),
        },
    )


def _write_contents(folder: Path, mechanism: Mechanism, contents: dict[str, bytes]) -> list[Path]:
    """Write every file whole or not at all. The manifest comes first, with the digests of what is
    replaced beside the new ones, so that a run which is cut short leaves no file that counts as
    foreign.
    """
    before = read_manifest(folder, _KEY)
    kept = {name: d for name, d in before.get("files", {}).items() if (folder / name).is_file()}
    digests = kept | {name: digest(content) for name, content in contents.items()}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_output(folder / MANIFEST, _manifest(mechanism, digests, kept))
        for name, content in contents.items():
            write_output(folder / name, content)
        write_output(folder / MANIFEST, _manifest(mechanism, digests, {}))
    except OSError as error:
        raise InputError(f"{folder}: the report cannot be written ({error.strerror})") from None
    return [folder / name for name in (*contents, MANIFEST)]


def _manifest(mechanism: Mechanism, digests: dict[str, str], replaced: dict[str, str]) -> bytes:
    content: dict[str, object] = {
        _KEY: mechanism.name,
        "symkin": __version__,
        "files": dict(sorted(digests.items())),
    }
    if replaced:
        content[_REPLACED] = replaced
    return (json.dumps(content, indent=2) + "\n").encode()
