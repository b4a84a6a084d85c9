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
from typing import Annotated, Any

import typer

from symkin.cli.help import HELP_NAMES, Entry, Group, LazyCommands
from symkin.cli.options import Interrupted
from symkin.cli.streams import prepare_streams, say, silence
from symkin.errors import NoConfigurationError, SymkinError

INTERRUPTED = 130
"""Exit status after Ctrl-C, which Typer gives too: 128 and the number of the signal."""

_FILES, _POSITIONS, _VELOCITIES = (
    "Mechanisms and files",
    "Positions and paths",
    "Velocities and singularities",
)
_MACHINE = "Your machine"

ENTRIES = (
    Entry(
        "list",
        "symkin.cli.list_names:list_",
        _FILES,
        "List the shipped mechanisms.",
        ("symkin list",),
    ),
    Entry(
        "show",
        "symkin.cli.describe:show",
        _FILES,
        "Limbs, unknowns, rank, mobility, redundant constraints.",
        (
            "symkin show zhao2000",
            "symkin show zhao2000 --plot sketch.png",
            "symkin show zhao2000 --latex",
        ),
    ),
    Entry(
        "close",
        "symkin.cli.close:close",
        _FILES,
        "The closed configuration nearest to a file's own.",
        (
            "symkin close ankle",
            "symkin close ankle -o closed.toml --plot closed.png",
            "symkin close robot.urdf",
        ),
    ),
    Entry(
        "convert",
        "symkin.cli.convert:convert",
        _FILES,
        "Write a mechanism as TOML, MJCF, URDF or SDF.",
        (
            "symkin convert ankle -o ankle.xml",
            "symkin convert robot.urdf -o robot.toml",
        ),
    ),
    Entry(
        "modes",
        "symkin.cli.position:modes",
        _POSITIONS,
        "Every solution: assembly modes, working modes.",
        (
            "symkin modes zhao2000",
            "symkin modes zhao2000 --joints 80,200,330,105 --plot modes.png",
            "symkin modes zhang2009 --pose 10,0,90 --rpy 0,5,10",
            "symkin modes ankle --given upper_motor=8,lower_motor=12 --json",
        ),
    ),
    Entry(
        "solve",
        "symkin.cli.position:solve",
        _POSITIONS,
        "One solution near a start.",
        (
            "symkin solve zhang2009",
            "symkin solve zhao2000 --joints theta1=80,theta2=200,theta3=330,op=105",
            "symkin solve zhao2000 --pose 0,0,100,1,0,0,0 --plot solution.png",
        ),
    ),
    Entry(
        "track",
        "symkin.cli.track:track",
        _POSITIONS,
        "Follow one mode along a path, up to the first stop.",
        (
            "symkin track zhao2000 --from 81,202,330,105 --to 85,200,330,110 -o path.csv",
            "symkin track ankle --given upper_motor=8:20,lower_motor=12",
            "symkin track zhao2000 --csv path.csv",
        ),
    ),
    Entry(
        "view",
        "symkin.cli.view:view",
        _POSITIONS,
        "The mechanism in a browser, where it moves.",
        (
            "symkin view zhao2000 --html zhao2000.html",
            "symkin view ankle --given upper_motor=8,lower_motor=12 --html ankle.html",
        ),
    ),
    Entry(
        "sweep",
        "symkin.cli.sweep:sweep",
        _POSITIONS,
        "Every solution over a grid or a sample; needs an extra.",
        (
            "symkin sweep zhao2000 --grid theta1=70:90:5 --at 81,202,330,105 -o map",
            "symkin sweep zhao2000 --poses --grid x=-20:20:5,y=-20:20:5 -o poses",
        ),
    ),
    Entry(
        "singularities",
        "symkin.cli.singularities:singularities",
        _VELOCITIES,
        "Kind of one configuration's singularity; loci.",
        (
            "symkin singularities zhao2000",
            "symkin singularities zhao2000 --plane x,y --starts 50 --plot loci.png",
        ),
    ),
    Entry(
        "mode-graph",
        "symkin.cli.mode_graph:mode_graph",
        _VELOCITIES,
        "Which modes connect without a singularity.",
        (
            "symkin mode-graph zhao2000 --over theta1=70:90,op=100:110 --points 3",
            "symkin mode-graph four_bar --over crank=0:350 --plot sheets.png",
        ),
    ),
    Entry(
        "jacobian",
        "symkin.cli.jacobian:jacobian",
        _VELOCITIES,
        "A symbolic Jacobian for CasADi, C, NumPy, SymPy, LaTeX.",
        (
            "symkin jacobian zhao2000 --format numpy -o jacobian.py",
            "symkin jacobian ankle --of ankle.1 --by upper_motor,lower_motor --format c",
        ),
    ),
    Entry(
        "transmission",
        "symkin.cli.transmission:transmission",
        _MACHINE,
        "Motors to joints: torques, ratios, range; array code.",
        (
            "symkin transmission robot.urdf --torque-limits 90",
            "symkin transmission ankle --motors upper_motor,lower_motor --at 8,12 --json",
            "symkin transmission ankle -o generated --plot torques.png",
        ),
    ),
    Entry(
        "firmware",
        "symkin.cli.firmware:firmware",
        _MACHINE,
        "C99 for your controller, with tests and build files.",
        (
            "symkin firmware zhang2009 -o firmware --real float",
            "symkin firmware zhao2000 -o zhao2000_c --package --linuxcnc --cpp",
        ),
    ),
    Entry(
        "calibrate",
        "symkin.cli.calibrate:calibrate",
        _MACHINE,
        "Geometry from measurements: plan, simulate, fit.",
    ),
)
"""The commands in the order of their list."""


class _Commands(Group):
    """The commands of `symkin`, whose modules are imported when they are called."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands = LazyCommands(ENTRIES)


app = typer.Typer(
    cls=_Commands,
    help=(
        "Kinematics of robots with closed loops: closure equations, every solution, Jacobians, "
        "from one description."
    ),
    epilog="\n".join(
        (
            "symkin show zhao2000                    what a shipped mechanism is",
            "symkin modes zhao2000 --plot modes.png  all its poses for its file's joints",
            "symkin modes my_robot.toml              the same of your own file",
            "symkin modes -h                         options and examples of one command",
        )
    ),
    context_settings=HELP_NAMES,
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
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Kinematics of robots with closed loops: closure equations, every solution, Jacobians, from
    one description.
    """


def main(arguments: list[str] | None = None) -> None:
    """Run a command; every mistake of the user's becomes one line on stderr and exit status 2."""
    prepare_streams()
    os.environ["MPLBACKEND"] = (
        "agg"  # pictures go to files only, and a wrong name would stop the import of matplotlib
    )
    with _interrupts() as pressed:
        status = _status(arguments, pressed)
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
        status = app(args=arguments, prog_name="symkin", standalone_mode=False)
        sys.stdout.flush()
        if status == INTERRUPTED:
            say("interrupted")
        return status or 0
    except NoConfigurationError as error:
        say(error)
        return 3
    except SymkinError as error:
        return _complain(error)
    except (KeyboardInterrupt, Interrupted) as error:
        say(f"interrupted; {error}" if str(error) else "interrupted")
        return INTERRUPTED
    except SystemExit as stop:
        if not isinstance(
            stop.__context__, BrokenPipeError
        ):  # which Typer makes an exit status of 1 of
            raise
        return _reader_gone()
    except BrokenPipeError:
        return _reader_gone()
    except OSError as error:
        if error.filename is not None:
            return _complain(f"{error.filename}: {error.strerror}")
        silence(sys.stdout)
        return _complain(f"the output cannot be written ({error.strerror})")
    except Exception as error:
        if pressed:
            say("interrupted")
            return INTERRUPTED
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
