"""The command line (contract 2). Exit status: 0 done, 2 bad input, 3 no real solution or not converged, 130 interrupted
by Ctrl-C."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

from symkin.commands.calibrate import calibrate
from symkin.commands.describe import list_, show
from symkin.commands.firmware import firmware
from symkin.commands.jacobian import jacobian
from symkin.commands.options import Interrupted
from symkin.commands.position import modes, solve
from symkin.commands.singularities import singularities
from symkin.commands.sweep import sweep
from symkin.commands.track import track
from symkin.errors import SymkinError

INTERRUPTED = 130
"""Exit status after Ctrl-C, which Typer gives too: 128 and the number of the signal."""

app = typer.Typer(
    help="Kinematics of robots with closed loops: closure equations, every solution, Jacobians, from one description.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from symkin._version import __version__

        print(__version__)
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Kinematics of robots with closed loops: closure equations, every solution, Jacobians, from one description."""


app.command(name="list")(list_)
app.command()(show)
app.command()(modes)
app.command()(solve)
app.command()(singularities)
app.command()(firmware)
app.command()(jacobian)
app.add_typer(calibrate, name="calibrate")
app.command()(sweep)
app.command()(track)


def main(arguments: list[str] | None = None) -> None:
    """Run a command; every mistake of the user's becomes one line on stderr and exit status 2."""
    try:
        status = app(args=arguments, prog_name="symkin", standalone_mode=False)
        sys.stdout.flush()
        if status == INTERRUPTED:
            _say("interrupted")
    except SymkinError as error:
        sys.exit(_complain(error))
    except (KeyboardInterrupt, Interrupted) as error:
        _say(f"interrupted; {error}" if str(error) else "interrupted")
        sys.exit(INTERRUPTED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(_complain(f"the output cannot be written ({error.strerror})"))
    except Exception as error:
        if not hasattr(error, "exit_code"):
            raise
        text = error.format_message() if hasattr(error, "format_message") else ""
        sys.exit(_complain(text.replace("Value error, ", "")) if text else error.exit_code)
    sys.exit(status or 0)


def _complain(message: object) -> int:
    _say(message)
    return 2


def _say(message: object) -> None:
    print("symkin: " + " ".join(str(message).split()), file=sys.stderr)
