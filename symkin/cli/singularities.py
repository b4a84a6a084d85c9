"""`symkin singularities`, `symkin mode-graph` and `symkin jacobian`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Literal

from symkin.cli.options import (
    JsonOption,
    MechArgument,
    check_output,
    names_from,
    output_option,
    print_result,
    ranges_from,
)
from symkin.cli.pictures import Picture, PictureOfSides
from symkin.cli.poses import PoseForm
from symkin.cli.progress import progress_bar
from symkin.cli.reading import say_left_out
from symkin.cli.streams import say
from symkin.cli.values import Asked
from symkin.errors import InputError
from symkin.following.options import GraphOptions
from symkin.formats.read_options import ReadOptions
from symkin.position.solve_result import SolveError
from symkin.result import Result
from symkin.singularities.options import LociOptions, SingularityOptions
from symkin.velocity.options import JacobianOptions
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


def mode_graph(
    mech: MechArgument,
    read: ReadOptions,
    options: GraphOptions,
    picture: Picture,
    over: Annotated[
        str,
        Option(
            "One or two of the known coordinates, each with a range.", "NAME=LOW:HIGH,...", ASKED
        ),
    ],
    points: Annotated[
        int,
        Option("Points along each range, 2 to 100. Default: 11.", "N", ASKED),
    ] = 11,
    as_json: JsonOption = False,
) -> None:
    """Find which modes connect without a singularity, over a grid of one or two of the known
    coordinates about what is given.
    """
    from symkin.following.mode_graph import mode_graph as graph_of_modes

    asked = Asked.of(mech, read, picture=picture)
    needed = "NAME=LOW:HIGH,..., such as crank=0:360,"
    ranges = ranges_from(over, "over", asked.unit, needed)
    axes = [(name, low, high) for name, (low, high) in ranges.items()]
    with progress_bar("points and lines") as progress:
        found = graph_of_modes(
            asked.mechanism,
            axes,
            points,
            **asked.values(GraphOptions, options),
            progress=progress,
        )
    print_result(as_json, found, asked.drawing.of(found))


def jacobian(
    mech: MechArgument,
    read: ReadOptions,
    *,
    language: Annotated[
        Literal["casadi", "c", "numpy", "sympy", "latex"],
        Option("The language to write.", group=ASKED, flags=("--format",)),
    ],
    kind: Annotated[
        Literal["direct", "inverse", "analytic", "passive"] | None,
        Option(
            "Twist by joint rates, joint rates by twist, pose rates, passive joint rates. "
            "Default: direct.",
            group=ASKED,
        ),
    ] = None,
    options: JacobianOptions,
    output: Annotated[
        Path | None,
        output_option("File to write; default: stdout.", "FILE"),
    ] = None,
) -> None:
    """Write a symbolic Jacobian in another language: CasADi, C99, NumPy, SymPy or LaTeX."""
    from symkin.codegen.text.jacobians import jacobian_text
    from symkin.files.outputs import write_output
    from symkin.velocity.jacobian import jacobian as symbolic

    check_output(output, mech)
    asked = Asked.of(mech, read)
    made = symbolic(asked.mechanism, kind, **asked.values(JacobianOptions, options))
    if made.kind != "rates":
        say_left_out(asked.mechanism)
    text = jacobian_text(made, language)
    if output is None:
        print(text, end="")
    else:
        write_output(output, text)
        print(output)
