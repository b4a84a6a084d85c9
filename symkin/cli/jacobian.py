"""`symkin jacobian`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from symkin.cli.options import MechArgument, check_output


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


def jacobian(
    mech: MechArgument,
    language: Annotated[Format, typer.Option("--format", help="The language to write.")],
    kind: Annotated[
        Kind, typer.Option(help="Twist by joint rates, joint rates by twist, pose rates, passive joint rates.")
    ] = Kind.direct,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE", help="File to write; default: stdout.")] = None,
) -> None:
    """Write a symbolic Jacobian in another language: CasADi, C99, NumPy, SymPy or LaTeX."""
    from symkin.codegen.jacobian_formats import jacobian_text
    from symkin.files.outputs import write_output
    from symkin.model.file import load
    from symkin.velocity.jacobian import jacobian as symbolic

    check_output(output, mech)
    text = jacobian_text(symbolic(load(mech), kind.value), language.value)
    if output is None:
        print(text, end="")
    else:
        write_output(output, text)
        print(output)
