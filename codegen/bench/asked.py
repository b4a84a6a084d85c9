"""Ask a machine's generated C many things at once."""

from __future__ import annotations

import ctypes
import tempfile
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from continuation import library
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

    def answers(self, goals: np.ndarray, guesses: np.ndarray, way: str = "") -> Answers:
        """Answers to each goal from each guess, by `way` "inverse" of a map its inverse problem;
        what is not found is zero.
        """
        way = way or ("inverse" if self.mechanism.serial else "direct")
        found, info = np.zeros(guesses.shape, self.number), np.zeros((len(goals), 64), np.uint8)
        status = self._called(way, (goals, guesses), (found, info), None)
        return Answers(status, found.astype(float), info[:, 0].astype(int))

    def back(self, found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Statuses and goals that the other problem gives for what was found."""
        width, way = len(self.mechanism.actuated), "inverse"
        if self.mechanism.serial:
            width, way = 7, "direct"
        goals = np.zeros((len(found), width), self.number)
        return self._called(way, (found,), (goals,)), goals.astype(float)

    def _called(
        self,
        function: str,
        given: tuple[np.ndarray, ...],
        results: tuple[np.ndarray, ...],
        *first: None,
    ) -> np.ndarray:
        """Statuses of calls of a function with each row of arrays; results are written into theirs.
        The number of steps stands first in an info.
        """
        arrays = [*(np.ascontiguousarray(values, self.number) for values in given), *results]
        call = getattr(self._library, f"{self.mechanism.name}_{function}")
        call.argtypes = [ctypes.c_void_p] * (len(first) + len(arrays))
        widths = (a.shape[1] * a.itemsize for a in arrays)
        begins = (a.ctypes.data for a in arrays)
        at = (range(b, b + len(given[0]) * w, w) for b, w in zip(begins, widths, strict=True))
        return np.array([call(*first, *row) for row in zip(*at, strict=True)], int)

    @cached_property
    def program(self) -> Program:
        return build_program(self.mechanism, self.options)

    @cached_property
    def _library(self) -> ctypes.CDLL:
        name = self.mechanism.name
        with tempfile.TemporaryDirectory() as place:
            for suffix, text in (("h", self.program.header), ("c", self.program.source)):
                Path(place, f"{name}.{suffix}").write_text(text)
            return library(Path(place), f"{name}.c")
