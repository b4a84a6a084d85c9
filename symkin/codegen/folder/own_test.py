"""Compile generated code and run its own test, where there is a C compiler: a folder whose test
fails is not written.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from symkin.errors import InputError
from symkin.numeric.c_library import CompilerError, compiler_command

_LONGEST = 60.0
"""Seconds after which a compiler or a test is given up."""
_FLAGS = ("-std=c99", "-O0", "-ffp-contract=off", "-w")
"""As a compiler rounds that neither joins nor reorders operations; compiling takes a tenth of a
second.
"""
_TRIVIAL = (
    "#include <math.h>\n#include <stdio.h>\nint main(void) { return (sqrt(4.0) == 2.0) ? 0 : 1; }\n"
)


def can_run() -> bool:
    """Whether a C compiler is there that makes programs which run."""
    try:
        with tempfile.TemporaryDirectory() as work:
            (Path(work) / "trivial.c").write_text(_TRIVIAL)
            return (
                _compiled(Path(work), ["trivial.c"]) is None
                and _run([str(Path(work) / "test")], work).returncode == 0
            )
    except (CompilerError, OSError, subprocess.SubprocessError):
        return False


def run_own_test(name: str, files: Mapping[str, str]) -> None:
    """Raises InputError where NAME.c with NAME_test.c, of the texts `files`, does not compile, or
    its test fails. Without a compiler nothing is tested.
    """
    wrong = None
    try:
        with tempfile.TemporaryDirectory() as work:
            for file in (f"{name}.h", f"{name}.c", f"{name}_test.c", f"{name}_vectors.h"):
                (Path(work) / file).write_text(files[file])
            said = _compiled(Path(work), [f"{name}.c", f"{name}_test.c"])
            if said is not None:
                wrong = f"the compiler says: {said}" if can_run() else None
            else:
                done = _run([str(Path(work) / "test")], work)
                lines = done.stdout.strip().splitlines() or [
                    f"it ends with status {done.returncode}"
                ]
                # the first thing that fails, and how many
                wrong = "; ".join(dict.fromkeys((lines[0], lines[-1]))) if done.returncode else None
    except subprocess.TimeoutExpired:
        wrong = f"it does not end within {_LONGEST:g} s"
    except (CompilerError, OSError):
        return
    if wrong is not None:
        raise InputError(
            f"{name}: the code's own test fails here ({wrong}), so that nothing is written; --real "
            f"double has more digits, and another "
            "reference configuration, farther from singular ones and from limits, may help"
        )


def _compiled(work: Path, sources: Sequence[str]) -> str | None:
    """Compile sources of a folder to the program `test`; the first error, None where there is
    none.
    """
    command = compiler_command(os.environ.get("CC", ""), os.environ.get("PATH", ""))
    done = _run([*command, *_FLAGS, *sources, "-o", "test", "-lm"], str(work))
    if done.returncode == 0:
        return None
    lines = [
        line for line in done.stderr.splitlines() if "error" in line
    ] or done.stderr.splitlines()
    return lines[0] if lines else f"status {done.returncode}"


def _run(command: Sequence[str], folder: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=_LONGEST,
        check=False,
        stdin=subprocess.DEVNULL,
        errors="replace",
    )
