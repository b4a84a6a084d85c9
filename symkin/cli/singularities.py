"""`symkin singularities`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

from symkin.cli.options import (
    GivenOption,
    JointsOption,
    JsonOption,
    MechArgument,
    PoseOption,
    SearchSeedOption,
    StartOption,
    joints_from,
    names_from,
    numbers_from,
    pairs_from,
    print_result,
)
from symkin.cli.pictures import NamesOption, ViewsOption, picture_options
from symkin.cli.poses import EulerOption, PoseReader, RpyOption
from symkin.cli.progress import progress_bar
from symkin.cli.reading import RobotFile, loaded
from symkin.cli.streams import say
from symkin.errors import InputError
from symkin.ignored_options import refuse_ignored
from symkin.position.solve_result import SolveError
from symkin.result import Result
from symkin.verb_options import ASKED, OUTPUT, Option


def singularities(
    mech: MechArgument,
    read: RobotFile,
    joints: JointsOption = None,
    pose: PoseOption = None,
    rpy: RpyOption = None,
    euler: EulerOption = None,
    given: GivenOption = None,
    start: StartOption = None,
    plane: Annotated[
        str | None,
        Option(
            "Loci over two pose coordinates (x, y, z, gamma from the reference, or the "
            "rotation vector rx, ry, rz before the "
            "configuration's orientation), two actuated joints, or two coordinates of --given "
            "(one: points), others held.",
            "U,V",
            ASKED,
        ),
    ] = None,
    window: Annotated[
        str | None,
        Option(
            "The window of --plane, in the file's units.", "U0:U1,V0:V1", ASKED, flags=("--range",)
        ),
    ] = None,
    plot: Annotated[
        Path | None,
        Option("Draw the configuration, or the loci of --plane, into a file.", "FILE.png", OUTPUT),
    ] = None,
    names: NamesOption = None,
    views: ViewsOption = None,
    starts: Annotated[
        int | None,
        Option("Random starts for --plane. Default: 200.", "N"),
    ] = None,
    seed: SearchSeedOption = None,
    output: Annotated[
        str | None,
        Option(
            "What type 1 and 2 are about, of x, y, z, rx, ry, rz (velocities, base frame) or "
            "joints, in place of position and "
            "orientation together.",
            "NAME,...",
            ASKED,
        ),
    ] = None,
    point: Annotated[
        str | None,
        Option(
            "The output's point in the platform's frame; without --output x,y,z of it.",
            "X,Y,Z",
            ASKED,
        ),
    ] = None,
    as_json: JsonOption = False,
) -> int:
    """Name the singularity of one configuration, driven by its actuated joints or what --given
    names, or draw the loci over a plane through it.
    """
    from symkin.singularities.configuration import configuration

    if plane is None:
        loci_only = {"--range": window, "--starts": starts, "--seed": seed}
        refuse_ignored(
            loci_only,
            "such options belong to --plane U,V, which names the two coordinates of loci",
            "give --plane",
        )
    if plane is not None and (output is not None or point is not None):
        raise InputError(
            "--output and --point belong to one configuration, not to --plane, whose loci are "
            "those of the platform"
        )
    mechanism = loaded(mech, read)
    if plane is not None and (names is not None or views is not None):
        raise InputError(
            "--names and --views belong to the picture of one configuration, not to that of "
            "--plane, which shows curves"
        )
    options = picture_options(plot, mechanism, names=names, views=views)
    unit = mechanism.angle_unit
    needed = "U0:U1,V0:V1, such as -100:100,-50:50,"
    sides = None if window is None else pairs_from(window, "range", unit, needed)
    reader = PoseReader(mechanism, rpy, euler)
    reader.check_used(pose, given, start)
    values = reader.given(given)
    outputs = None if output is None else names_from(output)
    try:
        solution = configuration(
            mechanism,
            joints=joints_from(joints, "joints", unit),
            pose=reader.pose(pose, "pose"),
            given=values,
            start=reader.start(start, is_pose=pose is None),
        )
    except SolveError as error:
        if as_json and error.result is not None:
            print(json.dumps(error.result.to_dict(), allow_nan=False))
        say(error)
        return 3
    found: Result
    if plane is None:
        from symkin.singularities.classification import singularity

        driven = None if values is None else list(values)
        found = singularity(
            solution, given=driven, output=outputs, point=numbers_from(point, "point", unit)
        )
    else:
        from symkin.singularities.singular_loci import DEFAULT_STARTS, singular_loci

        with progress_bar("singularity loci"):
            found = singular_loci(
                solution,
                names_from(plane),
                given=None if values is None else list(values),
                ranges=sides,
                starts=DEFAULT_STARTS if starts is None else starts,
                seed=0 if seed is None else seed,
            )
    picture = ""
    if plot is not None:
        found.plot(plot, **options)
        picture = f"\npicture: {plot}"
    print_result(as_json, found.to_dict, lambda: str(found) + picture)
    return 0
