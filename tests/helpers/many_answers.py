"""The generated direct problem of any platform, compiled: answers for many goals."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np

from helpers import firmware_tools as tools
from helpers.inside import Options
from symkin import Mechanism

_MANY = """
#include "NAME.h"
void many(int count, const NAME_real *goals, const NAME_pose *guesses, NAME_pose *poses,
  int *statuses)
{
    for (int k = 0; k < count; ++k) {
        statuses[k] = (int)NAME_direct(0, goals + NAME_JOINTS * k, &guesses[k], &poses[k], 0);
    }
}
"""
Answers = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Statuses and poses (n, 7) of goals (n, joints) from guesses (n, 7)."""


def answers_of(mechanism: Mechanism, options: Options, folder: Path) -> Answers:
    """Compile the generated C in a folder."""
    name = mechanism.name
    tools.write_code(mechanism, folder, options)
    prefixed = _MANY.replace("NAME_JOINTS", f"{name.upper()}_JOINTS").replace("NAME", name)
    (folder / "many.c").write_text(prefixed)
    command = [
        tools.compiler("gcc"),
        "-O2",
        "-shared",
        "-fPIC",
        f"{name}.c",
        "many.c",
        "-o",
        "code.so",
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    library, kind = (
        ctypes.CDLL(str(folder / "code.so")),
        np.float32 if options.real == "float" else np.float64,
    )

    def answers(goals: np.ndarray, guesses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        given, starts = (np.ascontiguousarray(array, kind) for array in (goals, guesses))
        poses, statuses = np.zeros((len(given), 7), kind), np.zeros(len(given), np.int32)
        library.many(
            len(given),
            *(array.ctypes.data_as(ctypes.c_void_p) for array in (given, starts, poses, statuses)),
        )
        return statuses, poses.astype(float)

    return answers
