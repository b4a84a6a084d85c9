"""The configuration that a machine reaches when its known values move in straight lines: a
reference in C of its own (walk.c).
"""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import casadi as ca
import numpy as np

from processors import BENCH, HOST, compiled_for
from symkin.model.joint import Coordinate
from symkin.numeric.system import System
from symkin.position.problem import Problem

LONGEST = 1.0 / 200
"""Longest step as a part of a line."""
_RESIDUAL = 1e-8
"""Largest closure error, over all constraints, of a configuration that is reached, as a part of the
size.
"""
ROUNDINGS = 16.0
"""How many roundings of goals and answers are no error; those of goals take poses off what an arm
of few joints can reach.
"""


def library(folder: Path, words: str) -> ctypes.CDLL:
    """C as a library: sources and macros as the compiler's words."""
    compiled_for(HOST, f"-shared -fPIC -I. {words} -o code.so -lm", folder)
    return ctypes.CDLL(str(folder / "code.so"))


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
    Known positions, joints and quaternions move in straight lines, quaternions normalised. Goals
    are given to a relative error `epsilon`.
    """

    problem: Problem
    longest: float = LONGEST
    epsilon: float = 0.0

    @property
    def system(self) -> System:
        return self.problem.system

    def reached(self, start: np.ndarray, begin: np.ndarray, goals: np.ndarray) -> Ends:
        """Lines from known values `begin` (n, known), where the unknowns are `start` (n, width), to
        `goals`.
        """
        long = [np.array(v, np.longdouble, order="C") for v in (start, begin, goals)]
        shortest, done = np.zeros(len(start)), np.zeros(len(start))
        arrays = [ctypes.c_void_p(v.ctypes.data) for v in (*long, shortest, done)]
        self._library.follow_all(len(start), ctypes.c_double(self.longest), *arrays)
        z, whole = long[0].astype(float), np.flatnonzero(shortest > 0.0)
        if len(whole):
            error = self.system.residuals(z[whole], goals[whole])
            most = (_RESIDUAL + ROUNDINGS * self.epsilon) * self.system.characteristic_length
            shortest[whole[~(error < most)]] = 0.0
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
            return library(Path(folder), f"{macros} {BENCH / 'walk.c'}")

    @property
    def _functions(self) -> tuple[ca.Function, ca.Function]:
        """Rows, their matrix and their rate along a line; the unknowns after a tangent step."""
        system, part = self.system, ca.SX.sym("t")
        begin, goal = (ca.SX.sym(name, *system.known.shape) for name in "bg")
        line = _normalised(begin + part * (goal - begin), self.problem.known_coordinates)
        told = (ca.densify(out) for out in (system.rows, system.jacobian))
        rows, matrix = (ca.substitute(out, system.known, line) for out in told)
        outputs = [rows, ca.densify(matrix), ca.densify(ca.jacobian(rows, part))]
        step = ca.SX.sym("step", system.freedom)
        to = _normalised(system.unknown + ca.mtimes(system.tangent, step), system.unknowns)
        return (
            ca.Function("linearised", [system.unknown, begin, goal, part], outputs, {"cse": True}),
            ca.Function("retracted", [system.unknown, step], [to], {"cse": True}),
        )


def _normalised(values: ca.SX, coordinates: Sequence[Coordinate]) -> ca.SX:
    """Values of coordinates, quaternions of unit length."""
    place = 0
    for c in coordinates:
        if c.kind == "quaternion":
            values[place : place + 4] /= ca.norm_2(values[place : place + 4])
        place += c.width
    return values
