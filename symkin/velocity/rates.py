"""Rates of any coordinates by those of any others that decide the motion: of' = J by'.

With the closure F(u, k) = 0, u its unknowns and k the coordinates of `by`: F_u u' + F_k k' = 0. Structure groups are solved one
after another, so that each expression holds no more than a group's own equations; of redundant rows an independent set is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.numeric.linear_algebra import null_space
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import closed_configurations
from symkin.position.determination import refuse_unless_determined
from symkin.position.given_by_name import given_coordinates, unknown_name
from symkin.position.groups import structure_groups
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import Solution
from symkin.position.solve_result import SolveError
from symkin.position.transfer import variables_elsewhere
from symkin.result import Result, Summary
from symkin.velocity.differential import tangent_jacobian
from symkin.velocity.jacobian_names import Variable, variables_read


@dataclass(frozen=True, eq=False, repr=False)
class RateJacobian(Result):
    """of' = J by': rates of the coordinates in `rows` by those in `columns`, at any regular closed configuration.

    Lengths are in the mechanism's length unit, angles in rad. `expression` reads the `symbols` of `inputs`, coordinates of the closure
    for these names. `at` evaluates the matrix at a solution, `function` is a CasADi function.

    >>> import symkin
    >>> linkage = symkin.load("four_bar")
    >>> ratio = symkin.jacobian(linkage, of=["follower"], by=["crank"])
    >>> ratio.at(symkin.solve(linkage, given={"crank": 60.0}).solution).shape
    (1, 1)
    """

    problem: Problem
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    expression: ca.SX
    inputs: tuple[Variable, ...]
    parameters: tuple[Variable, ...] = ()
    kind: str = "rates"

    @property
    def mechanism(self) -> Mechanism:
        return self.problem.mechanism

    @property
    def closure(self) -> Closure:
        return self.problem.closure

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.rows), len(self.columns)

    @property
    def symbols(self) -> ca.SX:
        """The inputs as one column."""
        return ca.vertcat(ca.SX(0, 1), *(self.closure.variables[v.index] for v in self.inputs))

    @cached_property
    def function(self) -> ca.Function:
        """A CasADi function of one scalar for each input, by name, with the output `jacobian`."""
        names = [v.name for v in self.inputs]
        name = ca.Function.fix_name(f"{self.mechanism.name}_rates_jacobian")
        inputs = ca.vertsplit(self.symbols) if names else []
        return ca.Function(name, inputs, [ca.densify(self.expression)], names, ["jacobian"], {"cse": True})

    def at(self, solution: Solution) -> np.ndarray:
        """The matrix at a closed configuration, by least squares of all rows. Raises SolveError at one where `by` does not decide the
        rates of `of`: a singular configuration."""
        values = variables_elsewhere(self.closure, solution)
        problem, size = self.problem, self.closure.characteristic_length
        unknown = np.asarray(self._slopes(values))
        rows, known = unknown[:, : problem.system.freedom], unknown[:, problem.system.freedom :]
        weights = np.array(
            [size if c.is_angular or c.kind == "quaternion" else 1.0 for c in problem.system.unknowns for _ in range(c.freedom)]
        )
        scaled = rows / weights
        rates = -np.linalg.lstsq(scaled, known, rcond=RANK_TOLERANCE)[0] / weights[:, None]
        free = null_space(scaled, RANK_TOLERANCE, relative=True)
        places = self._places
        wanted = [places[name] for name in self.rows if name in places]
        if len(free) and np.abs(free[:, wanted]).max(initial=0.0) > RANK_TOLERANCE:
            raise SolveError(
                f"{self.mechanism.name}: {', '.join(self.columns)} do not decide the rates of {', '.join(self.rows)} at this "
                "configuration: it is singular"
            )
        unit = np.eye(len(self.columns))
        return np.array([rates[places[name]] if name in places else unit[self.columns.index(name)] for name in self.rows])

    @cached_property
    def _places(self) -> dict[str, int]:
        """The place of each unknown among the unknown rates."""
        starts = np.cumsum([0, *(c.freedom for c in self.problem.system.unknowns)])
        return {c.name: int(k) for c, k in zip(self.problem.system.unknowns, starts, strict=False)}

    @cached_property
    def _slopes(self) -> ca.Function:
        problem, closure = self.problem, self.closure
        both = [tangent_jacobian(problem.system.rows, closure, c) for c in (problem.system.unknowns, problem.known_coordinates)]
        return ca.Function("slopes", [closure.variables], [ca.densify(ca.horzcat(*both))], {"cse": True})

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle as the mechanism and the names, from which the expression is built anew."""
        return _built, (self.mechanism, self.rows, self.columns)

    def to_dict(self) -> dict[str, Any]:
        """What the matrix relates: names of rows and columns, and what each entry reads."""
        return {
            "mechanism": self.mechanism.name,
            "kind": self.kind,
            "rows": list(self.rows),
            "columns": list(self.columns),
            "inputs": [{"name": v.name, "source": v.source, "unit": v.unit} for v in self.inputs],
            "parameters": [],
        }

    def summary(self, most_rows: int | None = None) -> Summary:  # noqa: ARG002 - there is no table
        """The matrix' shape, and the names of what it relates and reads."""
        inputs = ", ".join(v.name for v in self.inputs) or "nothing"
        rows, columns = self.shape
        return Summary(
            [
                f"{self.mechanism.name}: rates of {', '.join(self.rows)} by those of {', '.join(self.columns)}, {rows} x {columns}, of "
                f"{inputs}"
            ]
        )


def rate_jacobian(mechanism: Mechanism, of: Sequence[str], by: Sequence[str]) -> RateJacobian:
    """The rates of some coordinates by those of others, as many as the mobility. Raises InputError for names that nothing has, and for
    `by` that do not decide the motion, or say the same thing twice."""
    for what, names in (("of", of), ("by", by)):
        if isinstance(names, str) or not names:
            raise InputError(f"{what} = {names!r}; a list of names of coordinates is needed, as in {what}=['crank']")
        known = list(given_coordinates(mechanism))
        for name in names:
            if name not in known:
                raise InputError(unknown_name(mechanism, name, known, what))
        if len(set(names)) < len(list(names)):
            raise InputError(f"{what} = {', '.join(names)}: a name stands twice")
    return _built(mechanism, tuple(of), tuple(by))


@lru_cache(maxsize=128)
def _built(mechanism: Mechanism, of: tuple[str, ...], by: tuple[str, ...]) -> RateJacobian:
    problem = build_problem(mechanism, "given", by, tuple(name for name in of if name not in by))
    refuse_unless_determined(problem)
    rates = _rates_of_unknowns(problem)
    unit = ca.SX.eye(len(by))
    expression = ca.vertcat(*(rates[name] if name in rates else unit[by.index(name), :] for name in of))
    inputs, _ = variables_read(problem.closure, expression)
    return RateJacobian(problem, of, by, expression, inputs)


def _rates_of_unknowns(problem: Problem) -> dict[str, ca.SX]:
    """(freedom, k) for each coordinate: its rates by those of the known ones, group by group."""
    closure = problem.closure
    rates: dict[str, ca.SX] = {
        c.name: ca.SX.eye(len(problem.known_coordinates))[k, :] for k, c in enumerate(problem.known_coordinates)
    }
    values = np.array(closed_configurations(closure, 0))
    for group in structure_groups(problem):
        unknowns, knowns = group.system.unknowns, group.known_coordinates
        slopes = tangent_jacobian(group.system.rows, closure, unknowns)
        kept = _independent(ca.Function("slopes", [closure.variables], [ca.densify(slopes)]), values, group.system.freedom)
        driven = ca.SX(len(kept), len(problem.known_coordinates))
        for c in knowns:
            driven += ca.mtimes(tangent_jacobian(group.system.rows[kept, 0], closure, (c,)), rates[c.name])
        solved = -ca.solve(slopes[kept, :], driven)
        place = 0
        for c in unknowns:
            rates[c.name] = solved[place : place + c.freedom, :]
            place += c.freedom
    return rates


def _independent(slopes: ca.Function, values: np.ndarray, freedom: int) -> list[int]:
    """Rows that decide a group's rates at generic closed configurations, the largest rest first."""
    matrices = [np.asarray(slopes(v)) for v in values]
    left = max(matrices, key=lambda m: float(np.linalg.svd(m, compute_uv=False)[freedom - 1 : freedom].sum())).copy()
    kept: list[int] = []
    for _ in range(freedom):
        best = int(np.argmax(np.linalg.norm(left, axis=1)))
        unit = left[best] / np.linalg.norm(left[best])
        left -= np.outer(left @ unit, unit)
        kept.append(best)
    return sorted(kept)
