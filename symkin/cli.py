"""The command line (contract 2). Exit status: 0 done, 2 bad input, 3 no real solution or not converged."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from symkin.errors import InputError, SymkinError

app = typer.Typer(
    help="Kinematics of robots with closed loops: closure equations, every solution, Jacobians, from one description.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def whole_number(text: str) -> int:
    """An integer option, refused with its value."""
    try:
        return int(text)
    except ValueError:
        raise InputError(f"{text!r} is not a whole number; --starts and --seed take whole numbers from 0") from None


class Method(StrEnum):
    continuation = "continuation"
    multistart = "multistart"


class SolverName(StrEnum):
    newton = "newton"
    ipopt = "ipopt"


class RealType(StrEnum):
    float = "float"
    double = "double"


class GeometryChoice(StrEnum):
    fixed = "fixed"
    struct = "struct"


MechArgument = Annotated[str, typer.Argument(metavar="MECH", help="A name from `symkin list`, or a path to a .toml file.")]
JointsOption = Annotated[
    str | None,
    typer.Option(metavar="V1,V2,...", help="All actuated joints, in file order and the file's units: the direct problem."),
]
PoseOption = Annotated[
    str | None, typer.Option(metavar="X,Y,Z,QW,QX,QY,QZ", help="The platform's or tool's pose: the inverse problem.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Write one JSON object to stdout and nothing else.")]


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


@app.command(name="list")
def list_() -> None:
    """List the shipped mechanisms."""
    from symkin.model.file import load, shipped_names

    names = shipped_names()
    for name in names:
        print(f"{name:{max(map(len, names))}}  {load(name).title}")


@app.command()
def show(
    mech: MechArgument, latex: Annotated[bool, typer.Option("--latex", help="Print the closure equations as LaTeX.")] = False
) -> None:
    """Show limbs, unknowns, rank, mobility, redundant constraints and reciprocal screws."""
    from symkin.model.file import load

    mechanism = load(mech)
    if latex:
        from symkin.export.latex import equations

        print(equations(mechanism))
        return
    from symkin.view.describe import describe

    print(describe(mechanism))


@app.command()
def modes(
    mech: MechArgument,
    joints: JointsOption = None,
    pose: PoseOption = None,
    method: Annotated[
        Method, typer.Option(help="Track all complex solutions, or keep what random starts reach.")
    ] = Method.continuation,
    starts: Annotated[int, typer.Option(metavar="N", parser=whole_number, help="Number of starts.")] = 2000,
    seed: Annotated[int, typer.Option(metavar="N", parser=whole_number, help="Seed of the starts.")] = 0,
    as_json: JsonOption = False,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw the modes into a file.")] = None,
) -> None:
    """Find every solution: assembly modes of given joints, working modes of a given pose."""
    from symkin.enumeration.modes import modes as find_modes
    from symkin.model.file import load

    mechanism = load(mech)
    if plot is not None:
        from symkin.view.plot import check_picture_path

        check_picture_path(plot)
    with _progress("solutions") as progress:
        found = find_modes(
            mechanism,
            joints=_values(joints, "joints"),
            pose=_values(pose, "pose"),
            method=method.value,
            starts=starts,
            seed=seed,
            progress=progress,
        )
    if plot is not None:
        from symkin.view.plot import draw_modes

        draw_modes(found, plot)
    _print(as_json, found.to_json, lambda: str(found) + (f"\npicture: {plot}" if plot is not None else ""))
    raise typer.Exit(0 if found.modes or found.positive_dimensional else 3)


@app.command()
def solve(
    mech: MechArgument,
    joints: JointsOption = None,
    pose: PoseOption = None,
    start: Annotated[
        str | None,
        typer.Option(metavar="V1,V2,...", help="A pose for the direct problem, all actuated joints for the inverse one."),
    ] = None,
    solver: Annotated[SolverName, typer.Option(help="CasADi's rootfinder, or IPOPT on the squared closure.")] = SolverName.newton,
    as_json: JsonOption = False,
) -> None:
    """Find one solution near a start."""
    from symkin.model.file import load
    from symkin.position.solve import solve as solve_one
    from symkin.view.table import solve_text

    result = solve_one(
        load(mech), joints=_values(joints, "joints"), pose=_values(pose, "pose"), start=_values(start, "start"),
        solver=solver.value, check=False,
    )  # fmt: skip
    _print(as_json, result.to_json, lambda: solve_text(result))
    raise typer.Exit(0 if result.solution is not None else 3)


@app.command()
def firmware(
    mech: MechArgument,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Folder to write.")],
    real: Annotated[RealType, typer.Option(help="The C type of numbers.")] = RealType.double,
    home_relative: Annotated[
        bool, typer.Option("--home-relative", help="Joint values and positions as changes from home (platforms on six rods).")
    ] = False,
    geometry: Annotated[
        GeometryChoice, typer.Option(help="Numbers in the code, or a struct given with each call (platforms on six rods).")
    ] = GeometryChoice.fixed,
    home: Annotated[
        str | None,
        typer.Option(metavar="X,Y,Z,QW,QX,QY,QZ", help="Pose about which pivots are chosen (platforms on six rods)."),
    ] = None,
) -> None:
    """Write C99 for controllers: direct and inverse kinematics, Jacobian, test and build files."""
    from symkin.firmware.folder import write_folder
    from symkin.firmware.options import Options
    from symkin.model.file import load

    pose = _values(home, "home")
    options = Options(real.value, home_relative, geometry.value, None if pose is None else tuple(pose))
    for path in write_folder(load(mech), output, options):
        print(path)


def main(arguments: list[str] | None = None) -> None:
    """Run a command; every mistake of the user's becomes one line on stderr and exit status 2."""
    try:
        status = app(args=arguments, prog_name="symkin", standalone_mode=False)
        sys.stdout.flush()
    except SymkinError as error:
        sys.exit(_complain(error))
    except KeyboardInterrupt:
        sys.exit(130)
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
    print("symkin: " + " ".join(str(message).split()), file=sys.stderr)
    return 2


def _values(text: str | None, what: str) -> list[float] | None:
    """Numbers from a comma-separated list; None stays None."""
    if text is None:
        return None
    if not text.strip():
        raise InputError(f"--{what} is empty; numbers separated by commas are needed")
    numbers = []
    for k, part in enumerate(text.split(","), start=1):
        try:
            numbers.append(float(part))
        except ValueError:
            raise InputError(
                f"--{what}: value {k} = {part.strip()!r} is not a number; numbers separated by commas are needed"
            ) from None
    return numbers


def _print(as_json: bool, to_json: Callable[[], dict[str, Any]], to_text: Callable[[], str]) -> None:
    print(json.dumps(to_json(), allow_nan=False) if as_json else to_text())


@contextmanager
def _progress(what: str) -> Iterator[Callable[[int, int], None] | None]:
    """A progress bar on stderr when it is a terminal, else nothing."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what)
        yield lambda done, total: bar.update(task, completed=done, total=total)
