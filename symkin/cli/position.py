"""`symkin modes` and `symkin solve`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from symkin.cli.options import (
    AllOption,
    GivenOption,
    JointsOption,
    JsonOption,
    MechArgument,
    PoseOption,
    SearchSeedOption,
    StartOption,
    joints_from,
    print_result,
    whole_numbers,
)
from symkin.cli.pictures import NamesOption, ViewsOption, picture_options
from symkin.cli.poses import EulerOption, PoseReader, RpyOption
from symkin.cli.progress import progress_bar
from symkin.cli.reading import RobotFile, loaded
from symkin.verb_options import HOW, OUTPUT, Option

if TYPE_CHECKING:
    from symkin.assembly.modes_result import Modes


def modes(
    mech: MechArgument,
    read: RobotFile,
    joints: JointsOption = None,
    pose: PoseOption = None,
    rpy: RpyOption = None,
    euler: EulerOption = None,
    given: GivenOption = None,
    method: Annotated[
        Literal["continuation", "multistart"] | None,
        Option(
            "Track all complex solutions, or keep what random starts reach. Default: formulas of "
            "arms that have some, else "
            "continuation.",
            group=HOW,
        ),
    ] = None,
    starts: Annotated[
        int | None,
        Option("Random starts of multistart, or of what is sampled. Default: 2000.", "N"),
    ] = None,
    seed: SearchSeedOption = None,
    choose: Annotated[
        str | None,
        Option(
            "Of given values: one solution of each of the first blocks, by number from 0.",
            "K1,K2,...",
        ),
    ] = None,
    everything: AllOption = False,
    as_json: JsonOption = False,
    plot: Annotated[
        Path | None,
        Option("Draw the modes into a file.", "FILE.png", OUTPUT),
    ] = None,
    shown: Annotated[
        str | None,
        Option(
            "Modes in the picture, such as 1-16 or 1,3, or all. Default: 12 of them.",
            "K1-K2,...",
            OUTPUT,
            flags=("--modes",),
        ),
    ] = None,
    names: NamesOption = None,
    views: ViewsOption = None,
) -> int:
    """Find every solution: assembly modes of given joints, working modes of a given pose."""
    from symkin.assembly.modes import modes as find_modes

    mechanism = loaded(mech, read)
    options = picture_options(plot, mechanism, names=names, views=views, modes=shown)
    reader = PoseReader(mechanism, rpy, euler)
    reader.check_used(pose, given)
    with progress_bar("solutions") as progress:
        found = find_modes(
            mechanism,
            joints=joints_from(joints, "joints", mechanism.angle_unit),
            pose=reader.pose(pose, "pose"),
            given=reader.given(given),
            choose=whole_numbers(choose, "choose"),
            method=method,
            starts=starts,
            seed=seed,
            progress=progress,
        )
    drawn = _drawn(found, plot, options)
    print_result(
        as_json, found.to_dict, lambda: found.summary(everything=everything).text() + drawn
    )
    return 0 if found.modes or found.positive_dimensional else 3


def _drawn(found: Modes, plot: Path | None, options: dict[str, Any]) -> str:
    """Draw the modes; the line that names the picture and what it leaves out."""
    if plot is None:
        return ""
    from symkin.plots.modes_plot import left_out, shown_numbers

    found.plot(plot, **options)
    missing = left_out(found, shown_numbers(found, options.get("modes")))
    return f"\npicture: {plot}" + (f" ({missing})" if missing else "")


def solve(
    mech: MechArgument,
    read: RobotFile,
    joints: JointsOption = None,
    pose: PoseOption = None,
    rpy: RpyOption = None,
    euler: EulerOption = None,
    given: GivenOption = None,
    start: StartOption = None,
    solver: Annotated[
        Literal["newton", "ipopt", "closed"],
        Option("CasADi's rootfinder, or IPOPT on the squared closure.", group=HOW),
    ] = "newton",
    everything: AllOption = False,
    as_json: JsonOption = False,
    plot: Annotated[
        Path | None,
        Option("Draw the solution into a file.", "FILE.png", OUTPUT),
    ] = None,
    names: NamesOption = None,
    views: ViewsOption = None,
) -> int:
    """Find one solution near a start."""
    from symkin.position.solve import solve as solve_one

    mechanism = loaded(mech, read)
    options = picture_options(plot, mechanism, names=names, views=views)
    reader = PoseReader(mechanism, rpy, euler)
    reader.check_used(pose, given, start)
    result = solve_one(
        mechanism,
        joints=joints_from(joints, "joints", mechanism.angle_unit),
        pose=reader.pose(pose, "pose"),
        given=reader.given(given),
        start=reader.start(start, is_pose=pose is None),
        solver=solver,
        check=False,
    )
    picture = ""
    if plot is not None and result.solution is not None:
        result.plot(plot, **options)
        picture = f"\npicture: {plot}"
    print_result(
        as_json, result.to_dict, lambda: result.summary(everything=everything).text() + picture
    )
    return 0 if result.solution is not None else 3
