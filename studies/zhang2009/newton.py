"""Newton's method as the paper writes it, X <- X - C F with C = D^-1 by Gauss and Jordan, for any
closure; its operations.

The residual max |f_i| of a path is in mm^2. Source: Zhang Zhaoyin 2009, section 3 (see `study`).
"""

from __future__ import annotations

from collections import Counter

import casadi as ca
import numpy as np

from studies.shared.guesses import Closure, Search
from studies.zhang2009.model import START, Equations, Numbers, inside, outside

CLOSED = 1e-9
"""Largest |f_i| at which the iteration ends, mm^2: the rounding of squares of 300 mm is 1e-11."""
CLOSED_SCALED = 1e-13
"""The same over the base's radius squared, within a factor of ten."""
MOST = 60
"""Iterations after which a guess is given up."""

Path = list[tuple[np.ndarray, float]]
"""(X, max |f|) at every step."""


def gauss_jordan(D: np.ndarray) -> np.ndarray:
    """C = D^-1 by elimination with row pivots; NaN where a pivot vanishes."""
    n = len(D)
    work = np.hstack([D, np.eye(n)])
    for k in range(n):
        best = k + int(np.argmax(np.abs(work[k:, k])))
        if not abs(work[best, k]) >= 1e-12 * np.abs(D).max():
            return np.full((n, n), np.nan)
        work[[k, best]] = work[[best, k]]
        work[k] /= work[k, k]
        work -= np.outer(np.where(np.arange(n) == k, 0.0, work[:, k]), work[k])
    return work[:, n:]


def newton(system: Equations, start: Numbers, *, as_printed: bool = False, most: int = 30) -> Path:
    """Steps until no |f| is above 1e-9 mm^2. `as_printed`: the update X - C D, row i of C by column
    i of D for unknown i.
    """
    X, path = inside(start), []
    for _ in range(most + 1):
        F, D = (np.asarray(v) for v in system.evaluate(X))
        path.append((X, float(np.abs(F).max())))
        if path[-1][1] < CLOSED:
            break
        C = gauss_jordan(D)
        X = X - (np.diag(C @ D) if as_printed else (C @ F).ravel())
    return path


class PaperNewton:
    """The paper's iteration on a closure, as a solver of `guesses`: `path` holds the largest |F| at
    each step of its last call.
    """

    def __init__(self, closure: Closure) -> None:
        self.evaluate = ca.Function(
            "F_D",
            [closure.X, closure.u],
            [closure.F, ca.densify(ca.jacobian(closure.F, closure.X))],
            {"cse": True},
        )
        self.path: list[float] = []

    def __call__(self, guess: np.ndarray, u: np.ndarray) -> np.ndarray:
        X, self.path = np.asarray(guess, dtype=float), []
        for _ in range(MOST + 1):
            F, D = (np.asarray(v) for v in self.evaluate(X, u))
            self.path.append(float(np.abs(F).max()))
            if not np.isfinite(self.path[-1]) or self.path[-1] < CLOSED_SCALED:
                break
            X = X - (gauss_jordan(D) @ F).ravel()
        return X


def paper_newton(closure: Closure, name: str) -> Search:
    """Newton's method with the Gauss-Jordan inverse and no safeguard."""
    solver = PaperNewton(closure)
    return Search(name, closure, solver, lambda: len(solver.path) - 1)


def rootfinder_pose(system: Equations, method: str) -> np.ndarray:
    """The pose by CasADi's rootfinder from the same start."""
    find = ca.rootfinder("find", method, {"x": system.X, "g": system.F}, {"abstol": CLOSED})
    return outside(np.asarray(find(x0=inside(START))["x"]).ravel())


# --- operations -----------------------------------------------------------------------------------


def evaluation_operations(closure: Closure) -> int:
    """Arithmetic operations, sines and cosines of F and D, common subexpressions shared."""
    evaluate = PaperNewton(closure).evaluate
    kinds = Counter(evaluate.instruction_id(k) for k in range(evaluate.n_instructions()))
    return sum(
        count
        for kind, count in kinds.items()
        if kind not in (ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_ASSIGN)
    )


def inverse_operations(n: int) -> int:
    """Divisions, multiplications and subtractions of `gauss_jordan` on n rows of 2 n columns, and
    of C F and X - C F.
    """
    elimination = n * (2 * n + (n - 1) * 2 * (2 * n))
    return elimination + n * (2 * n - 1) + n
