"""Nonlinear least squares by IPOPT: the closure where it may not close, with joint limits as
bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.computed_once import lru_cache
from symkin.locks import Lock
from symkin.position.problem import Problem

Path = list[np.ndarray]
IPOPT = Lock()
"""Held by the thread that runs IPOPT: its linear solver MUMPS has variables that all runs of a
process share.
"""


@dataclass(frozen=True)
class LeastSquares:
    """min |F(z) / size|^2 / 2 with |q| = 1 for each quaternion and `limits` as bounds, by IPOPT
    with the Gauss-Newton Hessian.

    A minimum is a solution only where F vanishes there; the driver checks that on all rows.
    """

    tolerance: float = 1e-12
    max_iterations: int = 300

    @property
    def name(self) -> str:
        return "ipopt"

    def iterate(self, problem: Problem, start: np.ndarray, known: np.ndarray) -> Path:
        """Iterates of IPOPT from `start`, the start first."""
        solver, recorder = _solver(problem, self)
        low, high = _bounds(problem)
        with IPOPT:
            recorder.path.clear()
            result = solver(
                x0=np.clip(start, low, high), p=known, lbx=low, ubx=high, lbg=0.0, ubg=0.0
            )
            path = [start, *recorder.path[1:]]
        final = np.asarray(result["x"]).ravel()
        return path if len(path) > 1 and np.array_equal(path[-1], final) else [*path, final]


class _Recorder(ca.Callback):  # type: ignore[misc]  # CasADi is untyped here
    """Keeps IPOPT's iterates."""

    def __init__(self, width: int, equations: int, parameters: int) -> None:
        super().__init__()
        self.path: Path = []
        self._sizes = {
            "x": width,
            "f": 1,
            "g": equations,
            "lam_x": width,
            "lam_g": equations,
            "lam_p": parameters,
        }
        self.construct("recorder", {})

    def get_n_in(self) -> int:
        return ca.nlpsol_n_out()

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return str(ca.nlpsol_out(i))

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self._sizes[ca.nlpsol_out(i)], 1)

    def eval(self, arguments: list[ca.DM]) -> list[int]:
        self.path.append(np.asarray(arguments[0]).ravel())
        return [0]


@lru_cache(maxsize=32)
def _solver(problem: Problem, settings: LeastSquares) -> tuple[ca.Function, _Recorder]:
    system = problem.system
    scaled = system.rows / system.characteristic_length
    norms = system.norms(system.unknown)
    recorder = _Recorder(system.width, norms.shape[0], system.known.shape[0])
    options = {
        "print_time": False,
        "show_eval_warnings": False,
        "calc_lam_p": False,
        "iteration_callback": recorder,
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            "tol": settings.tolerance,
            "max_iter": settings.max_iterations,
        },
    }
    options["hess_lag"] = _gauss_newton_hessian(system.unknown, system.known, scaled, norms)
    nlp = {
        "x": system.unknown,
        "p": system.known,
        "f": 0.5 * ca.sumsqr(scaled),
        "g": norms,
    }
    return ca.nlpsol("least_squares", "ipopt", nlp, options), recorder


def _gauss_newton_hessian(z: ca.SX, known: ca.SX, rows: ca.SX, norms: ca.SX) -> ca.Function:
    """J^T J of the rows and the curvature of the norms: positive where the exact Hessian leads to
    saddles.
    """
    jacobian = ca.jacobian(rows, z)
    weight, multipliers = ca.SX.sym("lam_f"), ca.SX.sym("lam_g", norms.shape[0])
    curvature = weight * ca.mtimes(jacobian.T, jacobian)
    curvature += ca.hessian(multipliers.T @ norms, z)[0]
    names = ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]
    return ca.Function("nlp_hess_l", [z, known, weight, multipliers], [ca.triu(curvature)], *names)


def _bounds(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    low = np.full(problem.system.width, -np.inf)
    high = np.full(problem.system.width, np.inf)
    for c, place in zip(problem.system.unknowns, problem.system.slices, strict=True):
        if c.limits is not None:
            low[place], high[place] = c.limits
    return low, high
