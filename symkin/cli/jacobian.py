"""`symkin jacobian`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from symkin.cli.options import MechArgument, check_output, output_option
from symkin.cli.reading import say_left_out
from symkin.cli.values import Asked
from symkin.formats.read_options import ReadOptions
from symkin.velocity.options import JacobianOptions
from symkin.verb_options import ASKED, Option


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
