"""Ask a mechanism's generated C many things at once."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from symkin.codegen.folder.folder import write_folder
from symkin.codegen.map.options import Options
from symkin.codegen.map.program import Program, build_program
from symkin.machine.limbs import with_limbs
from symkin.model.mechanism import Mechanism

STATUSES = ("OK", "MAX_ITERATIONS", "SINGULAR", "NONFINITE", "OUT_OF_RANGE", "WRONG_BRANCH")

FLAGS = ["-O2", "-std=c99", "-fno-math-errno", "-ffp-contract=off", "-shared", "-fPIC", "-I."]


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


def built(machine: Machine, real: str, folder: Path) -> ctypes.CDLL:
    """The library of a machine's code; `write_folder` refuses it where its own test fails."""
    mechanism = (
        machine.mechanism if machine.given else with_limbs(machine.mechanism, "firmware", "")
    )
    write_folder(mechanism, folder, machine.options(real))
    joints = len(machine.given) or len(mechanism.actuated)
    return compiled(folder, mechanism.name, real, machine.kind, joints)


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
        function, width = getattr(self._library, way), guesses.shape[1]
        found, status, steps = asked(
            function, self.options.real, [goals, guesses], [width], "iiosn"
        )
        return Answers(status, found, steps)

    def back(self, found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Statuses and goals that the other problem gives for what was found."""
        width = 7 if self.mechanism.serial else len(self.mechanism.actuated)
        goals, status = asked(self._library.back_all, self.options.real, [found], [width], "ios")
        return status, goals

    @cached_property
    def program(self) -> Program:
        return build_program(self.mechanism, self.options)

    @cached_property
    def _library(self) -> ctypes.CDLL:
        if self.built is not None:
            return self.built
        folder, name = Path(tempfile.mkdtemp()), self.mechanism.name
        for suffix, text in ((".h", self.program.header), (".c", self.program.source)):
            (folder / f"{name}{suffix}").write_text(text)
        kind, joints = "arm" if self.mechanism.serial else "platform", len(self.mechanism.actuated)
        return compiled(folder, name, self.options.real, kind, joints)


def compiled(folder: Path, name: str, real: str, kind: str, joints: int) -> ctypes.CDLL:
    """ask.c with the code in a folder, as a library; `kind` is "platform", "arm" or "map"."""
    macros = [f'-DHEADER="{name}.h"', f"-DREAL={real}", f"-DOF(x)={name}_##x", f"-DJOINTS={joints}"]
    sources = [str(Path(__file__).with_name("ask.c")), f"{name}.c"]
    command = ["gcc", *FLAGS, *macros, f"-D{kind.upper()}", *sources, "-o", "code.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "code.so"))


def asked(
    function: ctypes._CFuncPtr,
    real: str,
    inputs: Sequence[np.ndarray],
    outputs: list[int],
    order: str,
) -> list[np.ndarray]:
    """Call a function of ask.c: its arrays `order` (i input, o output of so many numbers, s status,
    n numbers of steps).
    """
    number, count = np.float32 if real == "float" else np.float64, len(inputs[0])
    given, widths = iter(inputs), iter(outputs)
    arrays, results = list[np.ndarray](), list[np.ndarray]()
    for letter in order:
        if letter == "i":
            arrays.append(np.ascontiguousarray(next(given), number))
            continue
        arrays.append(
            np.zeros((count, next(widths)), number) if letter == "o" else np.zeros(count, np.int32)
        )
        results.append(arrays[-1])
    function(count, *(ctypes.c_void_p(a.ctypes.data) for a in arrays))
    return [r.astype(float) if r.dtype != np.int32 else r for r in results]
