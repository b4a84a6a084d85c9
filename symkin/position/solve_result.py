"""What one solve returns: the solution or the reason why there is none, with the steps on the
way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from symkin.errors import SymkinError
from symkin.position.problem import Problem
from symkin.position.solution import Solution, finite, heading, pose_of
from symkin.position.table import given_text, solution_table
from symkin.result import Result, Summary
from symkin.spatial.pose import Pose

Status = Literal["ok", "max_iterations", "singular", "infeasible", "nonfinite"]

REMEDIES: dict[str, str] = {
    "ok": "the solution satisfies every closure row",
    "max_iterations": (
        "the iteration did not settle: start nearer, use the other solver (newton, ipopt), or "
        "list all with modes"
    ),
    "singular": (
        "the Jacobian lost rank on the way: start elsewhere, or look at the mechanism's "
        "singularities"
    ),
    "infeasible": (
        "no configuration near the start closes all loops: check the given values against the "
        "mechanism's reach"
    ),
    "nonfinite": "the iteration met NaN or infinity: check the given values and start nearer",
}


@dataclass(frozen=True, eq=False)
class Iterate:
    """One step of an iteration: pose (or None for unknown joints only) and the largest closure row
    (length unit).
    """

    values: np.ndarray
    pose: Pose
    residual: float


def iterates_of(
    problem: Problem, path: Sequence[np.ndarray], known: np.ndarray
) -> tuple[Iterate, ...]:
    """The finite points of a path of unknowns as iterates."""
    system, steps = problem.system, []
    for z in path:
        values = problem.join_values(z, known)
        if np.all(np.isfinite(values)):
            residual = system.residual(system.unit(z), known)
            steps.append(Iterate(values, pose_of(problem.closure, values), residual))
    return tuple(steps)


@dataclass(frozen=True, eq=False, repr=False)
class SolveResult(Result):
    """Outcome of one solve: a status with a remedy, the verified solution or None, and the
    iteration history.

    `status` is "ok", "max_iterations", "singular", "infeasible" or "nonfinite"; `smallest_residual`
    (length unit) is the closure error that was left where there is no solution; `history` holds
    pose and residual of each iterate.

    >>> import symkin
    >>> found = symkin.solve(symkin.load("zhang2009"), joints=[1, 900, 1, 900, 1, 900], check=False)
    >>> found.status, found.solution is None
    ('infeasible', True)
    """

    problem: Problem
    given: dict[str, Any]
    status: Status
    solution: Solution | None
    iterations: int
    history: tuple[Iterate, ...]
    smallest_residual: float | None
    method: str
    elapsed_s: float
    notes: tuple[str, ...] = ()

    @property
    def message(self) -> str:
        """The status with its remedy, in one sentence."""
        mechanism = self.problem.mechanism
        left = (
            ""
            if self.smallest_residual is None
            else f" (closure error {self.smallest_residual:.3g} {mechanism.length_unit})"
        )
        return (
            f"{mechanism.name}: {self.status} after {self.iterations} iterations{left}; "
            f"{REMEDIES[self.status]}"
        )

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of `symkin solve --json`."""
        return {
            **heading(self.problem, self.given),
            "solution": None if self.solution is None else self.solution.to_dict(),
            "status": self.status,
            "iterations": self.iterations,
            "smallest_residual": finite(self.smallest_residual),
            "method": self.method,
            "elapsed_s": self.elapsed_s,
            "notes": list(self.notes),
        }

    def summary(self, most_rows: int | None = None, *, everything: bool = False) -> Summary:
        """The solution with its checks, or the status with its remedy; with `everything` all joints
        and named points too.
        """
        mechanism, s = self.problem.mechanism, self.solution
        above = [f"{mechanism.name}: {self.problem.name} problem, {given_text(self.given)}"]
        below = [f"note: {note}" for note in self.notes]
        if s is None:
            return Summary([*above, self.message], below=below)
        checks = (
            f"ok after {self.iterations} iterations ({self.method}); closure error "
            f"{s.residual:.1e} "
            f"{mechanism.length_unit}, condition {s.condition:.3g}"
        )
        if most_rows == 0:
            return Summary([*above, checks], below=below)
        table = solution_table(self.problem, [s], everything)
        return Summary(
            above,
            table.header,
            table.rows,
            [*([table.left_out] if table.left_out else []), checks, *below],
        )


class SolveError(SymkinError):
    """A configuration that was not reached, or a Jacobian that is not defined there.

    `result` is the outcome of the solve (status, iterations, closure error left); None where no
    solve was made, as for a Jacobian at a singular configuration.

    >>> import symkin
    >>> try:
    ...     symkin.solve(symkin.load("zhang2009"), joints=[1, 900, 1, 900, 1, 900])
    ... except symkin.SolveError as error:
    ...     print(error.result.status)
    infeasible
    """

    def __init__(self, message: str, result: SolveResult | None = None) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle with both arguments, so that a process pool hands the error on."""
        return type(self), (str(self), self.result)
