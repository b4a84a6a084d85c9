"""The configuration that a machine reaches when its known values move in straight lines: a
reference in C of its own (walk.c).
"""

from __future__ import annotations

import ctypes
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import casadi as ca
import numpy as np

from asked import BENCH, library
from symkin.numeric.system import System
from symkin.position.problem import Problem
from symkin.spatial.rotation import multiply

LONGEST = 1.0 / 200
"""Longest step as a part of a line."""
_RESIDUAL = 1e-8
"""Largest closure error, over all constraints, of a configuration that is reached, as a part of the
size.
"""


@dataclass(frozen=True)
class Ends:
    """Where lines lead: unknowns where each ended, how far it came, and the shortest step that it
    needed: 0 where it met a singularity.
    """

    unknowns: np.ndarray
    done: np.ndarray
    shortest: np.ndarray


@dataclass(frozen=True, eq=False)
class Walker:
    """Fine continuation of a position problem, geometry nominal, by Newton's method on all rows.
    Known positions, joints and quaternions move in straight lines, quaternions normalised.
    """

    problem: Problem
    longest: float = LONGEST

    @property
    def system(self) -> System:
        return self.problem.system

    def reached(self, start: np.ndarray, begin: np.ndarray, goals: np.ndarray) -> Ends:
        """Lines from known values `begin` (n, known), where the unknowns are `start` (n, width), to
        `goals`.
        """
        z, begin, goals = (
            np.array(values, dtype=float, order="C") for values in (start, begin, goals)
        )
        shortest, done = np.zeros(len(z)), np.zeros(len(z))
        arrays = [ctypes.c_void_p(v.ctypes.data) for v in (z, begin, goals, shortest, done)]
        self._library.follow_all(len(z), ctypes.c_double(self.longest), *arrays)
        whole = np.flatnonzero(shortest > 0.0)
        if len(whole):
            error = self.system.residuals(z[whole], goals[whole])
            shortest[whole[~(error < _RESIDUAL * self.system.characteristic_length)]] = 0.0
        return Ends(z, done, shortest)

    @cached_property
    def _library(self) -> ctypes.CDLL:
        system, functions = self.system, self._functions
        generator = ca.CodeGenerator("rows.c", {"with_header": False})
        for function in functions:
            generator.add(function)
        counts: dict[str, object] = {
            f"SZ_{part.upper()}": max(getattr(f, f"sz_{part}")() for f in functions)
            for part in ("arg", "res", "iw", "w")
        }
        counts |= {"N": system.freedom, "M": system.rows.shape[0], "WIDTH": system.width}
        counts |= {"KNOWN": system.known.shape[0], "SIZE": repr(system.characteristic_length)}
        macros = " ".join(f"-D{name}={count}" for name, count in counts.items())
        with tempfile.TemporaryDirectory() as folder:
            generator.generate(f"{folder}/")
            return library(Path(folder), str(BENCH / "walk.c"), macros)

    @property
    def _functions(self) -> tuple[ca.Function, ca.Function]:
        """Rows, their matrix and their rate along a line; the retraction."""
        system = self.system
        begin, goal = (ca.SX.sym(name, *system.known.shape) for name in "bg")
        part, step = ca.SX.sym("t"), ca.SX.sym("step", system.freedom)
        line = self._line(begin, goal, part)
        rows, matrix = (
            ca.substitute(ca.densify(out), system.known, line)
            for out in (system.rows, system.jacobian)
        )
        outputs = [rows, ca.densify(matrix), ca.densify(ca.jacobian(rows, part))]
        options = {"cse": True}
        return (
            ca.Function("linearised", [system.unknown, begin, goal, part], outputs, options),
            ca.Function("retracted", [system.unknown, step], [self._moved(step)], options),
        )

    def _line(self, begin: ca.SX, goal: ca.SX, part: ca.SX) -> ca.SX:
        """Known values at a part of the line; quaternions have unit length."""
        line, place = begin + part * (goal - begin), 0
        for c in self.problem.known_coordinates:
            if c.kind == "quaternion":
                line[place : place + 4] /= ca.norm_2(line[place : place + 4])
            place += c.width
        return line

    def _moved(self, step: ca.SX) -> ca.SX:
        """The unknowns after a tangent step."""
        system, column, parts = self.system, 0, []
        size = system.characteristic_length
        for c, place in zip(system.unknowns, system.slices, strict=True):
            entry = system.unknown[place]
            if c.kind == "quaternion":
                turned = multiply([1.0, *(0.5 / size * step[column + k] for k in range(3))], entry)
                parts.append(turned / ca.norm_2(turned))
            else:
                parts.append(entry + step[column] * (1.0 / size if c.is_angular else 1.0))
            column += c.freedom
        return ca.vertcat(*parts)
