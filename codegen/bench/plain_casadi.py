"""The C that CasADi's own code generator makes of symkin's equations: what a user of plain CasADi
has.

    python codegen/bench/plain_casadi.py [-o DIR] [--real double] [NAME ...]

Writes NAME_casadi.c and NAME_casadi.h for each of the five systems, about 1,000 lines each; they
are not committed. Functions:

    NAME_newton    unknowns z from a start z0 and the known values: the rootfinder `fast_newton` on
                   F(z, known) = 0
    NAME_rows      F(z, known), with which a caller can judge an answer
    NAME_matrix    joint rates = matrix * twist of a platform, twist = matrix * joint rates of an
                   arm, as symkin's NAME_jacobian

F is the closure that symkin solves (rows in the length unit, quaternions' norms included), z the
passive joints and the pose of a platform, the joints of an arm. `fast_newton` needs as many rows as
unknowns: not so for `zhao2000_links`.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import casadi as ca
import numpy as np

import symkin
from bench_cases import HOMES
from symkin.codegen.options import Options
from symkin.codegen.program import Program, build_program
from symkin.formats.load import load
from symkin.model.mechanism import Mechanism
from symkin.position.newton import flat_rows
from symkin.position.problem import Problem, build_problem

RealName = Literal["float", "double"]
SYSTEMS = ("zhang2009", "ren2008", "zhao2000", "gluon_6l3", "yao2020")
MAX_STEPS = 100
"""As many as symkin's C takes at most; CasADi's default is 1000."""


@dataclass(frozen=True, eq=False)
class PlainCasadi:
    """One mechanism for CasADi's generator, with the tolerance (length unit) and the type of
    symkin's C.
    """

    name: str
    real: RealName = "double"

    @cached_property
    def mechanism(self) -> Mechanism:
        return load(self.name)

    @cached_property
    def program(self) -> Program:
        """symkin's C of the same mechanism."""
        return build_program(self.mechanism, Options(self.real, home=HOMES.get(self.name)))

    @cached_property
    def problem(self) -> Problem:
        return build_problem(self.mechanism, "inverse" if self.mechanism.serial else "direct")

    @property
    def tolerance(self) -> float:
        return self.program.main.tuning.tolerance

    @cached_property
    def rows(self) -> ca.Function:
        system = self.problem.system
        return ca.Function(
            f"{self.name}_rows", [system.unknown, system.known], [flat_rows(system)], {"cse": True}
        )

    @cached_property
    def newton(self) -> ca.Function:
        """The rootfinder; ValueError where rows and unknowns differ in number, which CasADi
        refuses.
        """
        system, rows = self.problem.system, flat_rows(self.problem.system)
        if rows.shape != system.unknown.shape:
            counts = f"{rows.shape[0]} rows, {system.unknown.shape[0]} unknowns"
            raise ValueError(
                f"{self.name}: fast_newton needs as many rows as unknowns; there are {counts}"
            )
        equations = {"x": system.unknown, "p": system.known, "g": rows}
        options = {"abstol": self.tolerance, "abstolStep": self.tolerance, "max_iter": MAX_STEPS}
        return ca.rootfinder(f"{self.name}_newton", "fast_newton", equations, options)

    @cached_property
    def matrix(self) -> ca.Function:
        """Of all variables that it reads, in their order, as one vector; by rows, as symkin's C."""
        jacobian = symkin.jacobian(self.mechanism, "direct" if self.mechanism.serial else "inverse")
        return ca.Function(
            f"{self.name}_matrix",
            [jacobian.symbols],
            [ca.densify(jacobian.expression).T],
            {"cse": True},
        )

    @property
    def functions(self) -> tuple[ca.Function, ...]:
        return self.newton, self.rows, self.matrix

    @property
    def source(self) -> str:
        return f"{self.name}_casadi"

    def generate(self, folder: Path) -> None:
        """NAME_casadi.c and NAME_casadi.h."""
        folder.mkdir(parents=True, exist_ok=True)
        generator = ca.CodeGenerator(
            f"{self.source}.c", {"with_header": True, "casadi_real": self.real}
        )
        for function in self.functions:
            generator.add(function)
        generator.generate(f"{folder}/")

    # --- values -----------------------------------------------------------------------------------

    def values_at(self, pose: np.ndarray) -> dict[str, np.ndarray]:
        """All variables of a platform at a pose (x, y, z, quaternion): passive joints of the
        reference's branch.
        """
        there = symkin.solve(self.mechanism, pose=symkin.Pose(pose[:3], pose[3:]))
        return {name: np.atleast_1d(value) for name, value in there.solution.values.items()}

    def unknowns_at(self, pose: np.ndarray) -> np.ndarray:
        """z of a platform at a pose."""
        if all(c.role == "pose" for c in self.problem.system.unknowns):
            return pose
        values = self.values_at(pose)
        z = np.concatenate([values[c.name] for c in self.problem.system.unknowns])
        place = self.places(("pose.quaternion",))
        z[place] = pose[3:] if place else z[place]
        return z

    def places(self, names: tuple[str, ...]) -> list[int]:
        """Where coordinates stand in z."""
        slices = zip(self.problem.system.unknowns, self.problem.system.slices, strict=True)
        return [k for c, place in slices if c.name in names for k in range(place.start, place.stop)]

    def matrix_input(self, pose_or_joints: np.ndarray) -> np.ndarray:
        """What NAME_matrix reads: an arm's joints, or a platform's variables at a pose."""
        if self.mechanism.serial:
            return pose_or_joints
        jacobian, values = (
            symkin.jacobian(self.mechanism, "inverse"),
            self.values_at(pose_or_joints),
        )
        whole = np.concatenate([values[c.name] for c in jacobian.closure.coordinates])
        return np.array([whole[v.index] for v in jacobian.inputs])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else "")
    parser.add_argument("names", nargs="*", default=list(SYSTEMS))
    parser.add_argument("--real", choices=("float", "double"), default="double")
    parser.add_argument(
        "-o", default="casadi_c", metavar="DIR", help="where to write (default: casadi_c)"
    )
    chosen = parser.parse_args()
    for given in chosen.names:
        PlainCasadi(given, chosen.real).generate(Path(chosen.o))
        print(f"{chosen.o}/{given}_casadi.c")
