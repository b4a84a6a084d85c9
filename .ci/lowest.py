"""The lowest versions that pyproject.toml allows: `lowest.py bounds` lists them for pip, `lowest.py
try` runs the shipped mechanisms through the commands with what is installed.
"""

import contextlib
import io
import pathlib
import re
import sys
import tomllib

EXTRAS = ("mjcf", "urdf", "sweep", "meshes")


def bounds() -> list[str]:
    """`name==version` for each direct dependency, and those of the extras that users take."""
    project = tomllib.loads(pathlib.Path("pyproject.toml").read_text())["project"]
    extras = [text for name in EXTRAS for text in project["optional-dependencies"][name]]
    found = [re.match(r"([\w-]+)>=([\w.]+)", text) for text in project["dependencies"] + extras]
    assert all(found), "each dependency has a lower bound"
    return [f"{match[1]}=={match[2]}" for match in found]


def run(arguments: list[str], expected: int = 0) -> None:
    """One command in this process; its exit status must be the expected one, and an error one
    line.
    """
    from symkin.cli.app import main

    said, complained = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(complained):
        try:
            main(arguments)
        except SystemExit as stop:
            status = stop.code
    text = complained.getvalue()
    assert "Warning" not in text, f"{arguments}: {text}"
    assert (status or 0) == expected, f"{arguments}: status {status}: {text}"
    assert (
        said.getvalue() if not expected else text.startswith("symkin: ") and text.count("\n") == 1
    ), arguments


def try_commands() -> None:
    import symkin

    run(["list"])
    for name in symkin.shipped_names():
        run(["show", name])
        run(["solve", name, "--json"])
        if symkin.load(name).is_graph:
            continue
        run(["modes", name])
        for language in ("casadi", "c", "numpy", "latex"):
            run(["jacobian", name, "--format", language])
    run(["modes", "zhang2009", "--plot", "lowest.png"])
    run(["modes", "ankle", "--given", "upper_motor=8,lower_motor=12", "--plot", "ankle.png"])
    run(
        [
            "jacobian",
            "ankle",
            "--of",
            "ankle.1,ankle.2",
            "--by",
            "upper_motor,lower_motor",
            "--format",
            "numpy",
        ]
    )
    for suffix in ("xml", "urdf"):
        run(["convert", "ankle", "-o", f"ankle.{suffix}"])
        run(["show", f"ankle.{suffix}"])
    pathlib.Path("ankle.urdf").rename("ankle.xacro")
    run(["show", "ankle.xacro"])
    run(["sweep", "four_bar", "--grid", "crank=50:60:3", "--workers", "0", "-o", "map"])
    for words in ([], ["-h"], ["modes", "--help"], ["calibrate"], ["calibrate", "fit", "-h"]):
        run(words)
    for mistake in (
        ["modes"],
        ["modes", "zhang2009", "--method", "none"],
        ["modes", "zhang2009", "--joints", "1", "2"],
        ["none"],
    ):
        run(mistake, 2)


if __name__ == "__main__":
    if sys.argv[1] == "bounds":
        print("\n".join(bounds()))
    else:
        try_commands()
