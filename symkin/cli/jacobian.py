"""`symkin jacobian`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from symkin.cli.options import MechArgument, check_output, names_from
from symkin.cli.reading import RobotFile, loaded, say_left_out
from symkin.errors import InputError
from symkin.verb_options import ASKED, OUTPUT, Option


def jacobian(
    mech: MechArgument,
    read: RobotFile,
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
    of: Annotated[
        str | None,
        Option("Coordinates whose rates are wanted, by those of --by.", "NAME,...", ASKED),
    ] = None,
    by: Annotated[
        str | None,
        Option("Coordinates that decide the motion, as many as the mobility.", "NAME,...", ASKED),
    ] = None,
    output: Annotated[
        Path | None,
        Option("File to write; default: stdout.", "FILE", OUTPUT, flags=("-o", "--output")),
    ] = None,
) -> None:
    """Write a symbolic Jacobian in another language: CasADi, C99, NumPy, SymPy or LaTeX."""
    from symkin.codegen.text.jacobians import jacobian_text
    from symkin.files.outputs import write_output
    from symkin.velocity.jacobian import AnyJacobian
    from symkin.velocity.jacobian import jacobian as symbolic

    check_output(output, mech)
    mechanism = loaded(mech, read)
    made: AnyJacobian
    if of is not None or by is not None:
        if of is None or by is None or kind is not None:
            raise InputError(
                "--of and --by name the coordinates whose rates are related: give both, and no "
                "--kind"
            )
        made = symbolic(mechanism, of=names_from(of), by=names_from(by))
    else:
        made = symbolic(mechanism, kind or "direct")
        say_left_out(mechanism)
    text = jacobian_text(made, language)
    if output is None:
        print(text, end="")
    else:
        write_output(output, text)
        print(output)
