"""Ask a mechanism's generated C many things at once."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from shlex import split
from typing import NamedTuple

import numpy as np

from symkin.codegen.folder.folder import write_folder
from symkin.codegen.map.options import Options
from symkin.codegen.map.program import Program, build_program
from symkin.machine.limbs import with_limbs
from symkin.model.mechanism import Mechanism

BENCH = Path(__file__).parent
STATUSES = ("OK", "MAX_ITERATIONS", "SINGULAR", "NONFINITE", "OUT_OF_RANGE", "WRONG_BRANCH")


class Answers(NamedTuple):
    """Status, what was found, and count of steps of each call."""

    status: np.ndarray
    found: np.ndarray
    steps: np.ndarray


@dataclass(frozen=True, eq=False)
class Machine:
    """A mechanism and the options of its folder."""

    mechanism: Mechanism
    given: tuple[str, ...] = ()
    find: tuple[str, ...] = ()
    home: tuple[float, ...] | None = None

    @property
    def kind(self) -> str:
        return "map" if self.given else "arm" if self.mechanism.serial else "platform"

    def options(self, real: str) -> Options:
        return Options(real, home=self.home, given=self.given, find=self.find)  # type: ignore[arg-type]


def library(folder: Path, sources: str, macros: str) -> ctypes.CDLL:
    """Compiled C as a library; `sources` stand in the folder or are named whole."""
    flags = "-O2 -std=c99 -fno-math-errno -ffp-contract=off -shared -fPIC -I."
    command = split(f"gcc {flags} {macros} {sources} -o code.so -lm")
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "code.so"))


@lru_cache(maxsize=2)
def built(machine: Machine, real: str) -> ctypes.CDLL:
    """The library of a machine's code; `write_folder` refuses it where its own test fails."""
    mechanism = machine.mechanism
    if not machine.given:
        mechanism = with_limbs(mechanism, "firmware", "")
    joints = len(machine.given) or len(mechanism.actuated)
    with tempfile.TemporaryDirectory() as folder:
        write_folder(mechanism, Path(folder), machine.options(real))
        return _compiled(Path(folder), mechanism.name, real, machine.kind, joints)


@dataclass(frozen=True, eq=False)
class Asked:
    """The generated C of one mechanism: of a platform its direct problem, of an arm its inverse
    one, of a map both. Without a library that was `built` its text alone is compiled.
    """

    mechanism: Mechanism
    options: Options
    built: ctypes.CDLL | None = None

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
        if self.built is not None:
            return self.built
        name, kind = self.mechanism.name, "arm" if self.mechanism.serial else "platform"
        with tempfile.TemporaryDirectory() as folder:
            for suffix, text in (("h", self.program.header), ("c", self.program.source)):
                Path(folder, f"{name}.{suffix}").write_text(text)
            joints = len(self.mechanism.actuated)
            return _compiled(Path(folder), name, self.options.real, kind, joints)


def _compiled(folder: Path, name: str, real: str, kind: str, joints: int) -> ctypes.CDLL:
    """ask.c with the code in a folder, as a library; `kind` is "platform", "arm" or "map"."""
    macros = f"""-D'HEADER="{name}.h"' -DREAL={real} -D'OF(x)={name}_##x' -DJOINTS={joints}"""
    return library(folder, f"{BENCH / 'ask.c'} {name}.c", f"{macros} -D{kind.upper()}")
