"""Ask a machine's generated C many things at once."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from continuation import library
from processors import BENCH
from symkin.codegen.map.options import Options
from symkin.codegen.map.program import Program, build_program
from symkin.model.mechanism import Mechanism

STATUSES = ("OK", "MAX_ITERATIONS", "SINGULAR", "NONFINITE", "OUT_OF_RANGE", "WRONG_BRANCH")


class Answers(NamedTuple):
    """Status, what was found, and count of steps of each call."""

    status: np.ndarray
    found: np.ndarray
    steps: np.ndarray


@dataclass(frozen=True, eq=False)
class Asked:
    """A mechanism, the options of its code, and this code, compiled: of a platform its direct
    problem, of an arm its inverse one, of a map both.
    """

    mechanism: Mechanism
    options: Options = Options()  # noqa: RUF009 - frozen

    def of(self, real: str) -> Asked:
        """The same in a type of numbers."""
        return replace(self, options=replace(self.options, real=real))  # type: ignore[arg-type]

    @property
    def kind(self) -> str:
        if self.options.is_map:
            return "map"
        return "arm" if self.mechanism.serial else "platform"

    @property
    def number(self) -> type[np.floating]:
        return np.float32 if self.options.real == "float" else np.float64

    def rounded(self, values: np.ndarray) -> np.ndarray:
        """Values as the code's numbers are."""
        return values.astype(self.number).astype(float)

    def answers(self, goals: np.ndarray, guesses: np.ndarray, way: str = "ask_all") -> Answers:
        """Answers to each goal from each guess, of a map's inverse problem by `way` "ask_inverse";
        what is not found is zero.
        """
        status, steps = np.zeros((2, len(goals)), np.int32)
        found = np.zeros(guesses.shape, self.number)
        self._call(way, [goals, guesses], [found, status, steps])
        return Answers(status, found.astype(float), steps)

    def back(self, found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Statuses and goals that the other problem gives for what was found."""
        width = 7 if self.mechanism.serial else len(self.mechanism.actuated)
        goals, status = np.zeros((len(found), width), self.number), np.zeros(len(found), np.int32)
        self._call("back_all", [found], [goals, status])
        return status, goals.astype(float)

    def _call(self, name: str, given: Sequence[np.ndarray], results: Sequence[np.ndarray]) -> None:
        arrays = [*(np.ascontiguousarray(values, self.number) for values in given), *results]
        places = (ctypes.c_void_p(array.ctypes.data) for array in arrays)
        getattr(self._library, name)(len(given[0]), *places)

    @cached_property
    def program(self) -> Program:
        return build_program(self.mechanism, self.options)

    @cached_property
    def _library(self) -> ctypes.CDLL:
        """ask.c with the code."""
        name = self.mechanism.name
        joints = len(self.options.given) or len(self.mechanism.actuated)
        macros = f"""-D'HEADER="{name}.h"' -DREAL={self.options.real} -D'OF(x)={name}_##x'"""
        macros += f" -DJOINTS={joints} -D{self.kind.upper()}"
        with tempfile.TemporaryDirectory() as place:
            for suffix, text in (("h", self.program.header), ("c", self.program.source)):
                Path(place, f"{name}.{suffix}").write_text(text)
            return library(Path(place), f"{macros} {BENCH / 'ask.c'} {name}.c")
