"""`symkin singularities`."""

from __future__ import annotations

import json
from typing import Annotated

from symkin.cli.options import (
    JsonOption,
    MechArgument,
    names_from,
    numbers_from,
    pairs_from,
    print_result,
)
from symkin.cli.pictures import PictureOfSides
from symkin.cli.poses import PoseForm
from symkin.cli.progress import progress_bar
from symkin.cli.reading import RobotFile
from symkin.cli.streams import say
from symkin.cli.values import Asked
from symkin.errors import InputError
from symkin.ignored_options import refuse_ignored
from symkin.position.options import SEED, Begun
from symkin.position.solve_result import SolveError
from symkin.result import Result
from symkin.verb_options import ASKED, Option


def singularities(
    mech: MechArgument,
    read: RobotFile,
    inputs: Begun,
    form: PoseForm,
    picture: PictureOfSides,
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
    starts: Annotated[
        int | None,
        Option("Random starts for --plane. Default: 200.", "N"),
    ] = None,
    seed: Annotated[int | None, SEED] = None,
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
    if plane is not None and (picture["names"] is not None or picture["views"] is not None):
        raise InputError(
            "--names and --views belong to the picture of one configuration, not to that of "
            "--plane, which shows curves"
        )
    asked = Asked.of(mech, read, form, picture)
    unit = asked.unit
    needed = "U0:U1,V0:V1, such as -100:100,-50:50,"
    sides = None if window is None else pairs_from(window, "range", unit, needed)
    values = asked.values(Begun, inputs, "pose", "given", "start")
    driven = list(values["given"]) if "given" in values else None
    outputs = None if output is None else names_from(output)
    try:
        solution = configuration(asked.mechanism, **values)
    except SolveError as error:
        if as_json and error.result is not None:
            print(json.dumps(error.result.to_dict(), allow_nan=False))
        say(error)
        return 3
    found: Result
    if plane is None:
        from symkin.singularities.classification import singularity

        found = singularity(
            solution, given=driven, output=outputs, point=numbers_from(point, "point", unit)
        )
    else:
        from symkin.singularities.singular_loci import DEFAULT_STARTS, singular_loci

        with progress_bar("singularity loci"):
            found = singular_loci(
                solution,
                names_from(plane),
                given=driven,
                ranges=sides,
                starts=DEFAULT_STARTS if starts is None else starts,
                seed=0 if seed is None else seed,
            )
    drawn = asked.drawing.of(found)
    print_result(as_json, found.to_dict, lambda: str(found) + drawn)
    return 0
