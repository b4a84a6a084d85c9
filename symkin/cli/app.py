"""The command line (docs/contracts.md). Exit status: 0 done, or its reader had enough; 2 bad input, 3 no real solution or not
converged, 130 interrupted by Ctrl-C."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

from symkin.cli.calibrate import calibrate
from symkin.cli.close import close
from symkin.cli.convert import convert
from symkin.cli.describe import list_, show
from symkin.cli.firmware import firmware
from symkin.cli.jacobian import jacobian
from symkin.cli.options import Interrupted
from symkin.cli.position import modes, solve
from symkin.cli.singularities import singularities
from symkin.cli.streams import prepare_streams, say, silence
from symkin.cli.sweep import sweep
from symkin.cli.track import track
from symkin.cli.view import view
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
app.command()(close)
app.command()(convert)
app.command()(modes)
app.command()(solve)
app.command()(singularities)
app.command()(firmware)
app.command()(jacobian)
app.add_typer(calibrate, name="calibrate")
app.command()(sweep)
app.command()(track)
app.command()(view)


def main(arguments: list[str] | None = None) -> None:
    """Run a command; every mistake of the user's becomes one line on stderr and exit status 2."""
    prepare_streams()
    os.environ["MPLBACKEND"] = "agg"  # pictures go to files only, and a wrong name would stop the import of matplotlib
    sys.exit(_status(arguments))


def _status(arguments: list[str] | None) -> int:
    """Run a command, to its exit status."""
    try:
        status = app(args=arguments, prog_name="symkin", standalone_mode=False)
        sys.stdout.flush()
        if status == INTERRUPTED:
            say("interrupted")
        return status or 0
    except SymkinError as error:
        return _complain(error)
    except (KeyboardInterrupt, Interrupted) as error:
        say(f"interrupted; {error}" if str(error) else "interrupted")
        return INTERRUPTED
    except SystemExit as stop:
        if not isinstance(stop.__context__, BrokenPipeError):  # which Typer makes an exit status of 1 of
            raise
        return _reader_gone()
    except BrokenPipeError:
        return _reader_gone()
    except OSError as error:
        silence(sys.stdout)
        return _complain(f"the output cannot be written ({error.strerror})")
    except Exception as error:
        if not hasattr(error, "exit_code"):
            raise
        text = error.format_message() if hasattr(error, "format_message") else ""
        return _complain(text.replace("Value error, ", "")) if text else int(error.exit_code)


def _reader_gone() -> int:
    """Whoever reads the output has enough, as `head` has: no fault."""
    silence(sys.stdout)
    return 0


def _complain(message: object) -> int:
    say(message)
    return 2
