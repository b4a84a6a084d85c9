"""Ask a mechanism's generated C many things at once."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from symkin.codegen.options import Options
from symkin.codegen.program import Program, build_program
from symkin.model.mechanism import Mechanism

STATUSES = ("OK", "MAX_ITERATIONS", "SINGULAR", "NONFINITE", "OUT_OF_RANGE", "WRONG_BRANCH")


@dataclass(frozen=True)
class Answers:
    """Status, what was found, and count of steps of each call."""

    status: np.ndarray
    found: np.ndarray
    steps: np.ndarray


@dataclass(frozen=True, eq=False)
class Asked:
    """The generated C of one mechanism: of a platform its direct problem, of an arm its inverse
    one.
    """

    mechanism: Mechanism
    options: Options

    @property
    def number(self) -> type[np.floating]:
        return np.float32 if self.options.real == "float" else np.float64

    def answers(self, goals: np.ndarray, guesses: np.ndarray) -> Answers:
        """Answers to each goal from each guess; what is not found is zero."""
        count, arm = len(goals), self.mechanism.serial
        given, near = (np.ascontiguousarray(values, self.number) for values in (goals, guesses))
        found = np.zeros((count, len(self.mechanism.actuated) if arm else 7), self.number)
        status, steps = np.zeros(count, np.int32), np.zeros(count, np.int32)
        self._library.ask_all(
            count, *(ctypes.c_void_p(v.ctypes.data) for v in (given, near, found, status, steps))
        )
        return Answers(status, found.astype(float), steps)

    def back(self, found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Statuses and goals that the other problem gives for what was found."""
        count, arm = len(found), self.mechanism.serial
        given, status = np.ascontiguousarray(found, self.number), np.zeros(count, np.int32)
        goals = np.zeros((count, 7 if arm else len(self.mechanism.actuated)), self.number)
        self._library.back_all(
            count, *(ctypes.c_void_p(v.ctypes.data) for v in (given, goals, status))
        )
        return status, goals.astype(float)

    @cached_property
    def program(self) -> Program:
        return build_program(self.mechanism, self.options)

    @cached_property
    def _library(self) -> ctypes.CDLL:
        folder, name = Path(tempfile.mkdtemp()), self.mechanism.name
        for suffix, text in ((".h", self.program.header), (".c", self.program.source)):
            (folder / f"{name}{suffix}").write_text(text)
        macros = [
            f'-DHEADER="{name}.h"',
            f"-DREAL={self.options.real}",
            f"-DOF(x)={name}_##x",
            f"-DJOINTS={len(self.mechanism.actuated)}",
        ]
        macros += ["-DARM"] if self.mechanism.serial else []
        flags = [
            "-O2",
            "-std=c99",
            "-fno-math-errno",
            "-ffp-contract=off",
            "-shared",
            "-fPIC",
            "-I.",
        ]
        source = str(Path(__file__).with_name("ask.c"))
        subprocess.run(
            ["gcc", *flags, *macros, source, f"{name}.c", "-o", "code.so", "-lm"],
            cwd=folder,
            check=True,
        )
        return ctypes.CDLL(str(folder / "code.so"))
