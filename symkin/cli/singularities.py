"""`symkin singularities`."""

from __future__ import annotations

import json
from typing import Annotated

from symkin.cli.options import (
    JsonOption,
    MechArgument,
    names_from,
    print_result,
)
from symkin.cli.pictures import PictureOfSides
from symkin.cli.poses import PoseForm
from symkin.cli.progress import progress_bar
from symkin.cli.streams import say
from symkin.cli.values import Asked
from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions
from symkin.position.solve_result import SolveError
from symkin.result import Result
from symkin.singularities.options import LociOptions, SingularityOptions
from symkin.verb_options import ASKED, Option, refuse_ignored


def singularities(
    mech: MechArgument,
    read: ReadOptions,
    *,
    options: SingularityOptions,
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
    of_plane: LociOptions,
    as_json: JsonOption = False,
) -> int:
    """Name the singularity of one configuration, driven by its actuated joints or what --given
    names, or draw the loci over a plane through it.
    """
    from symkin.singularities.configuration import configuration

    if plane is None:
        ranges, starts, seed = of_plane["ranges"], of_plane["starts"], of_plane["seed"]
        refuse_ignored(
            {"--range": ranges, "--starts": starts, "--seed": seed},
            "such options belong to --plane U,V, which names the two coordinates of loci",
            "give --plane",
        )
    elif options["output"] is not None or options["point"] is not None:
        raise InputError(
            "--output and --point belong to one configuration, not to --plane, whose loci are "
            "those of the platform"
        )
    elif picture["names"] is not None or picture["views"] is not None:
        raise InputError(
            "--names and --views belong to the picture of one configuration, not to that of "
            "--plane, which shows curves"
        )
    asked = Asked.of(mech, read, form, picture)
    curves = asked.values(LociOptions, of_plane)
    values = asked.values(SingularityOptions, options, "pose", "given", "start")
    wanted = {name: values.pop(name) for name in ("output", "point") if name in values}
    driven = list(values["given"]) if "given" in values else None
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

        found = singularity(solution, given=driven, **wanted)
    else:
        from symkin.singularities.singular_loci import singular_loci

        with progress_bar("singularity loci"):
            found = singular_loci(solution, names_from(plane), given=driven, **curves)
    print_result(as_json, found, asked.drawing.of(found))
    return 0
