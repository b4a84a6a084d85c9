"""Newton's method by CasADi's rootfinder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import casadi as ca
import numpy as np

from symkin.computed_once import lru_cache
from symkin.locks import Pool
from symkin.numeric.system import System
from symkin.position.problem import Problem

Path = list[np.ndarray]


@dataclass(frozen=True)
class Newton:
    """z <- z - (dG/dz)^-1 G(z), one rootfinder call an iteration so that each iterate is seen and
    judged.

    The rootfinder wants as many equations as unknowns. G holds the closure rows and the
    quaternions' norms; where the rows are more than the unknowns (overconstrained mechanisms, arms
    of fewer than six joints) or depend on each other, G = S F + T (z - z0): S projects the rows
    onto the range of the Jacobian at the start, T holds what the rows leave free (arms of more than
    six joints) at the start. The driver checks the answer on all rows.
    """

    method: Literal["newton", "fast_newton"] = "newton"
    tolerance: float = 1e-12
    max_iterations: int = 60

    @property
    def name(self) -> str:
        return self.method

    def iterate(self, problem: Problem, start: np.ndarray, known: np.ndarray) -> Path:
        """Iterates from `start` until the largest row is below `tolerance` times the size or no
        longer shrinks.
        """
        system = problem.system
        steps, rows = _functions(problem, self.method)
        project, hold = _squaring(problem, start, known)
        data = np.concatenate([known, project.T.ravel(), hold.T.ravel(), start])
        path, largest = [start], _largest(rows, start, known)
        with steps.borrowed() as step:
            for _ in range(self.max_iterations):
                if largest <= self.tolerance * system.characteristic_length:
                    break
                z = np.asarray(step(path[-1], data)).ravel()
                path.append(z)
                previous, largest = largest, _largest(rows, z, known)
                if not np.isfinite(largest):
                    break
                if largest >= previous and largest <= 1e-9 * system.characteristic_length:
                    break
        return path


def _largest(rows: ca.Function, z: np.ndarray, known: np.ndarray) -> float:
    return float(np.max(np.abs(np.asarray(rows(z, known))), initial=0.0))


def flat_rows(system: System) -> ca.SX:
    """Closure rows and, for each quaternion, size (|q|^2 - 1) / 2."""
    return ca.vertcat(
        system.rows, 0.5 * system.characteristic_length * system.norms(system.unknown)
    )


@lru_cache(maxsize=64)
def _functions(problem: Problem, method: str) -> tuple[Pool[ca.Function], ca.Function]:
    """Rootfinders of one iteration each, and the rows."""
    system = problem.system
    rows = flat_rows(system)
    m, n = rows.shape[0], system.width
    evaluate = ca.Function("rows", [system.unknown, system.known], [rows], {"cse": True})
    project, hold, start = ca.SX.sym("S", n, m), ca.SX.sym("T", n, n), ca.SX.sym("z0", n)
    square = m == n and problem.generic_rank == system.freedom
    g = rows if square else ca.mtimes(project, rows) + ca.mtimes(hold, system.unknown - start)
    data = ca.vertcat(system.known, ca.vec(project), ca.vec(hold), start)
    options = {"error_on_fail": False, "max_iter": 1, "abstol": 0.0, "show_eval_warnings": False}
    equations = {"x": system.unknown, "p": data, "g": g}
    return Pool(lambda: ca.rootfinder("step", method, equations, options)), evaluate


def _squaring(
    problem: Problem, start: np.ndarray, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """S (n x m) and T (n x n) from the singular vectors of dG/dz at the start."""
    jacobian = np.asarray(_flat_jacobian(problem)(start, known))
    m, n = jacobian.shape
    project, hold = np.zeros((n, m)), np.zeros((n, n))
    if not np.all(np.isfinite(jacobian)):
        return project, hold
    left, _, right = np.linalg.svd(jacobian)
    rank = min(problem.generic_rank + n - problem.system.freedom, m, n)
    project[:rank] = left[:, :rank].T
    hold[rank:] = right[rank:]
    return project, hold


@lru_cache(maxsize=64)
def _flat_jacobian(problem: Problem) -> ca.Function:
    system = problem.system
    rows = flat_rows(system)
    return ca.Function(
        "jacobian", [system.unknown, system.known], [ca.densify(ca.jacobian(rows, system.unknown))]
    )
