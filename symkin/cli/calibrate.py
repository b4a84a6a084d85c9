"""`symkin calibrate`: identify a mechanism's geometry from measurements, and plan and simulate these."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from symkin.cli.calibrate_design import plan, simulate
from symkin.cli.calibrate_folder import check_folder, write_fit, write_unfitted
from symkin.cli.calibrate_options import (
    AnyMachineOption,
    DataArgument,
    DistanceOption,
    ForceOption,
    HoldOption,
    HoldOutOption,
    Loss,
    Method,
    Outliers,
    PatternOption,
    Residual,
    SigmaOption,
    ToleranceOption,
)
from symkin.cli.options import MechArgument, SeedOption
from symkin.cli.quantities import distance_points, joint_quantities, quantity, tolerances
from symkin.cli.reading import reads_robots
from symkin.formats.read_options import ReadOptions

if TYPE_CHECKING:
    from symkin.model.mechanism import Mechanism

calibrate = typer.Typer(help="Identify a mechanism's geometry from measurements.", no_args_is_help=True, rich_markup_mode=None)


@calibrate.command()
@reads_robots
def fit(
    mech: MechArgument,
    read: ReadOptions,
    data: DataArgument,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Folder for the mechanism file and the report.")],
    parameters: PatternOption = None,
    hold: HoldOption = None,
    frames: Annotated[
        str,
        typer.Option(metavar="least|joints:...", help="Frames that no reading tells: least change, or joints:P1,P2,P3/B1,B2."),
    ] = "least",
    method: Annotated[Method, typer.Option(help="Poses solved inside, or as unknowns, or by IPOPT.")] = Method.nested,
    residual: Annotated[Residual, typer.Option(help="How groups and joint noise enter.")] = Residual.means,
    outliers: Annotated[Outliers, typer.Option(help="What to do with readings that do not belong.")] = Outliers.remove,
    loss: Annotated[
        Loss,
        typer.Option(
            help="How far readings count that are far off: in full, or less the farther (robust, with a note on figures)."
        ),
    ] = Loss.squared,
    sigma_joints: SigmaOption = None,
    sigma_group: SigmaOption = None,
    sigma_inclination: SigmaOption = None,
    sigma_position: SigmaOption = None,
    sigma_orientation: SigmaOption = None,
    distance: DistanceOption = None,
    sigma_distance: SigmaOption = None,
    hold_out: HoldOutOption = None,
    tolerance: ToleranceOption = None,
    any_machine: AnyMachineOption = False,
    seed: SeedOption = 0,
    force: ForceOption = False,
) -> None:
    """Identify the geometry: DIR/NAME.toml, report.json, report.md and pictures. Exit status 3: not usable."""
    from symkin.calibration.data.files import read_measurements
    from symkin.calibration.fit_file import NotFittedError, fit_file
    from symkin.formats.load import load

    mechanism = load(mech, read)
    check_folder(output, mech, mechanism, force=force)
    given = {"group": sigma_group, "inclination": sigma_inclination, "orientation": sigma_orientation}
    sigmas = {k: quantity(v, "angle", mechanism, f"sigma-{k}") for k, v in given.items() if v is not None}
    lengths = {"position": sigma_position, "distance": sigma_distance}
    sigmas |= {k: quantity(v, "length", mechanism, f"sigma-{k}") for k, v in lengths.items() if v is not None}
    if sigma_joints is not None:
        sigmas["joint"] = joint_quantities(sigma_joints, mechanism, "sigma-joints")  # type: ignore[assignment]
    try:
        report = fit_file(
            mechanism, read_measurements(data, mechanism, distance_points(distance, mechanism)), parameters=parameters, hold=hold,
            frames=frames, sigmas=sigmas, command=shlex.join(["symkin", *sys.argv[1:]]), seed=seed, method=method.value, residual=residual.value.replace("-", " "),
            outliers=outliers.value, loss=loss.value, tolerance=None if tolerance is None else tolerances(tolerance, mechanism),
            any_machine=any_machine, hold_out=hold_out
        )  # fmt: skip
    except NotFittedError as error:
        write_unfitted(mechanism, data, error, output)
        print(f"{mechanism.name}: {error}")
        _note_earlier(output, mechanism)
        raise typer.Exit(3) from None
    written = write_fit(report, output)
    print(report.summary())
    print("written: " + ", ".join(str(path) for path in written))
    if not report.usable:
        print(f"no mechanism file was written: {report.verdict}")
        _note_earlier(output, mechanism)
    raise typer.Exit(0 if report.usable else 3)


def _note_earlier(output: Path, mechanism: Mechanism) -> None:
    """Say which files of the folder an earlier, usable fit has left: they are kept and are not of this fit."""
    for left in (output / f"{mechanism.name}.toml", output / "pose_sigma.png"):
        if left.exists():
            print(f"note: {left} is of an earlier fit, not of this one")


calibrate.command()(simulate)
calibrate.command()(plan)
