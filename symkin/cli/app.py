"""The command line (docs/reference/commands.md). Exit status: 0 done, or its reader had enough; 2
bad input, 3 no real solution or not converged, 130 interrupted by Ctrl-C.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import click

from symkin.cli.commands import Entry, Group
from symkin.cli.completion import OPTIONS, answer_shell
from symkin.cli.options import Interrupted
from symkin.cli.streams import prepare_streams, say, silence
from symkin.errors import NoConfigurationError, SymkinError
from symkin.model.shipped import shipped_examples

INTERRUPTED = 130
"""Exit status after Ctrl-C: 128 and the number of the signal."""

_FILES, _POSITIONS, _VELOCITIES = (
    "Mechanisms and files",
    "Positions and paths",
    "Velocities and singularities",
)
_MACHINE = "Your machine"
_MEASURED = "Commands"
_IN_CALIBRATE = "symkin calibrate"

ENTRIES = (
    Entry("list", "symkin.cli.list_names:list_", _FILES, "List the shipped mechanisms."),
    Entry(
        "show",
        "symkin.cli.describe:show",
        _FILES,
        "Limbs, unknowns, rank, mobility, redundant constraints.",
    ),
    Entry(
        "close",
        "symkin.cli.describe:close",
        _FILES,
        "The closed configuration nearest to a file's own.",
    ),
    Entry(
        "convert",
        "symkin.cli.describe:convert",
        _FILES,
        "Write a mechanism as TOML, MJCF, URDF or SDF.",
    ),
    Entry(
        "modes",
        "symkin.cli.position:modes",
        _POSITIONS,
        "Every solution: assembly modes, working modes.",
    ),
    Entry("solve", "symkin.cli.position:solve", _POSITIONS, "One solution near a start."),
    Entry(
        "track",
        "symkin.cli.track:track",
        _POSITIONS,
        "Follow one mode along a path, up to the first stop.",
    ),
    Entry(
        "view",
        "symkin.cli.view:view",
        _POSITIONS,
        "The mechanism in a browser, where it moves.",
    ),
    Entry(
        "sweep",
        "symkin.cli.sweep:sweep",
        _POSITIONS,
        "Every solution over a grid or a sample; needs an extra.",
    ),
    Entry(
        "singularities",
        "symkin.cli.singularities:singularities",
        _VELOCITIES,
        "Kind of one configuration's singularity; loci.",
    ),
    Entry(
        "mode-graph",
        "symkin.cli.singularities:mode_graph",
        _VELOCITIES,
        "Which modes connect without a singularity.",
    ),
    Entry(
        "jacobian",
        "symkin.cli.singularities:jacobian",
        _VELOCITIES,
        "A symbolic Jacobian for CasADi, C, NumPy, SymPy, LaTeX.",
    ),
    Entry(
        "transmission",
        "symkin.cli.transmission:transmission",
        _MACHINE,
        "Motors to joints: torques, ratios, range; array code.",
    ),
    Entry(
        "firmware",
        "symkin.cli.firmware:firmware",
        _MACHINE,
        "C99 for your controller, with tests and build files.",
    ),
    Entry(
        "calibrate",
        "",
        _MACHINE,
        "Geometry from measurements: plan, simulate, fit.",
        help="Identify a mechanism's geometry from measurements: plan them, take or simulate them, "
        "fit.",
        below=(
            Entry(
                "plan",
                "symkin.cli.calibrate_design:plan",
                _MEASURED,
                "Choose the postures that are worth measuring.",
                path=_IN_CALIBRATE,
            ),
            Entry(
                "simulate",
                "symkin.cli.calibrate_design:simulate",
                _MEASURED,
                "Measurements as a measuring system would take them.",
                path=_IN_CALIBRATE,
            ),
            Entry(
                "fit",
                "symkin.cli.calibrate:fit",
                _MEASURED,
                "Identify the geometry, and say how well.",
                path=_IN_CALIBRATE,
            ),
        ),
    ),
)
"""The commands in the order of their list."""


def _print_version(ctx: click.Context, _option: click.Parameter, wanted: bool) -> None:
    if wanted:
        from symkin._version import __version__

        print(__version__)
        ctx.exit()


app = Group(
    "symkin",
    ENTRIES,
    help=(
        "Kinematics of robots with closed loops: closure equations, every solution, Jacobians, "
        "from one description."
    ),
    epilog="\n".join(shipped_examples("symkin", remarks=True)),
    params=[
        click.Option(
            ["--version"],
            is_flag=True,
            is_eager=True,
            expose_value=False,
            callback=_print_version,
            help="Print the version.",
        ),
        *OPTIONS,
    ],
)


def main(arguments: list[str] | None = None) -> None:
    """Run a command; every mistake of the user's becomes one line on stderr and exit status 2."""
    prepare_streams()
    os.environ["MPLBACKEND"] = (
        "agg"  # pictures go to files only, and a wrong name would stop the import of matplotlib
    )
    with _interrupts() as pressed:
        status = _status(arguments, pressed)
    if pressed:
        eval("None")  # `python -m` ends by the signal, not by a status, where its last eval did
    sys.exit(status)


@contextmanager
def _interrupts() -> Iterator[list[int]]:
    """Raise KeyboardInterrupt at Ctrl-C, where it is not ignored, and list that it came: code of
    other packages makes errors of its own of it.
    """
    pressed: list[int] = []
    former = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(former):
        yield pressed
        return

    def note(number: int, _: object) -> None:
        pressed.append(number)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, note)
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, former)


def _status(arguments: list[str] | None, pressed: Sequence[int] = ()) -> int:
    """Run a command, to its exit status."""
    try:
        status = _run(sys.argv[1:] if arguments is None else arguments)
        sys.stdout.flush()
        return status
    except click.exceptions.Exit as stop:
        sys.stdout.flush()
        return stop.exit_code
    except NoConfigurationError as error:
        say(error)
        return 3
    except SymkinError as error:
        return _complain(error)
    except (KeyboardInterrupt, Interrupted) as error:
        say(f"interrupted; {error}" if str(error) else "interrupted")
        return INTERRUPTED
    except BrokenPipeError:
        silence(sys.stdout)  # whoever reads the output has enough, as `head` has: no fault
        return 0
    except OSError as error:
        if error.filename is not None:
            return _complain(f"{error.filename}: {error.strerror}")
        silence(sys.stdout)
        return _complain(f"the output cannot be written ({error.strerror})")
    except Exception:
        if pressed:
            say("interrupted")
            return INTERRUPTED
        raise


def _run(arguments: list[str]) -> int:
    """Answer the shell that completes a line, or call the command that the words name."""
    if answer_shell(app):
        return 0
    with app.make_context("symkin", list(arguments)) as context:
        return int(app.invoke(context) or 0)


def _complain(message: object) -> int:
    say(message)
    return 2
