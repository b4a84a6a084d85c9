"""`symkin jacobian`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from symkin.cli.help import ASKED, OUTPUT
from symkin.cli.options import MechArgument, check_output, choice
from symkin.cli.reading import loaded, reads_robots, say_left_out
from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions


class Format(StrEnum):
    casadi = "casadi"
    c = "c"
    numpy = "numpy"
    sympy = "sympy"
    latex = "latex"


class Kind(StrEnum):
    direct = "direct"
    inverse = "inverse"
    analytic = "analytic"
    passive = "passive"


@reads_robots
def jacobian(
    mech: MechArgument,
    read: ReadOptions,
    language: Annotated[Format, choice(Format, "--format", "The language to write.", ASKED)],
    kind: Annotated[
        Kind | None,
        choice(
            Kind,
            "--kind",
            "Twist by joint rates, joint rates by twist, pose rates, passive joint rates. "
            "Default: direct.",
            ASKED,
        ),
    ] = None,
    of: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,...",
            help="Coordinates whose rates are wanted, by those of --by.",
            rich_help_panel=ASKED,
        ),
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,...",
            help="Coordinates that decide the motion, as many as the mobility.",
            rich_help_panel=ASKED,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="File to write; default: stdout.",
            rich_help_panel=OUTPUT,
        ),
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
        made = symbolic(mechanism, of=_names(of), by=_names(by))
    else:
        made = symbolic(mechanism, (kind or Kind.direct).value)
        say_left_out(mechanism)
    text = jacobian_text(made, language.value)
    if output is None:
        print(text, end="")
    else:
        write_output(output, text)
        print(output)


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",")]
