"""All complex solutions at the page's first values, where the problem is that of one body on rods,
as symkin's own paths find them.
"""

from __future__ import annotations

import numpy as np

from symkin.homotopy.instance import instance
from symkin.homotopy.start_store import start_of
from symkin.homotopy.systems import system_of, unsuitable
from symkin.homotopy.values import known_values
from symkin.position.problem import Problem
from symkin.position.solution import Solution
from symkin.spatial.rotation import conjugate, multiply

_POSE = 7
"""Numbers of a pose: position and quaternion."""


def complex_solutions(problem: Problem, solution: Solution) -> np.ndarray:
    """Variables (n, width) of the closure at all complex solutions whose known values are those of
    `solution`; none where the unknowns are not one pose alone.

    From Study coordinates (e, g) the quaternion is e / sqrt(e . e), with the complex root, and the
    position 2 g e* / (e . e).
    """
    rays = _rays(problem, solution)
    names = {c.name for block in problem.blocks for c in block.unknowns}
    body = f"{next(iter(names)).rpartition('.')[0]}." if names else ""
    if rays is None or names != {f"{body}{part}" for part in ("x", "y", "z", "quaternion")}:
        return np.zeros((0, len(solution.variables)), dtype=complex)
    e, g = rays[:4], rays[4:]
    found = np.repeat(np.asarray(solution.variables, dtype=complex)[None], rays.shape[1], axis=0)
    squares = np.einsum("in,in->n", e, e)
    position = 2.0 * problem.closure.characteristic_length * multiply(g, conjugate(e))[1:] / squares
    slices = problem.closure.slices
    for part, axis in zip(position, "xyz", strict=True):
        found[:, slices[f"{body}{axis}"].start] = part
    found[:, slices[f"{body}quaternion"]] = (e / np.sqrt(squares)).T
    return found


def _rays(problem: Problem, solution: Solution) -> np.ndarray | None:
    """Study coordinates (8, n) of all complex poses, None where the problem is another."""
    if unsuitable(problem) or len(problem.blocks) != 1:
        return None
    (block,) = problem.blocks
    system = system_of(problem, block)
    if (
        system is None
        or len(system.projective) != _POSE + 1
        or system.unknowns
        or system.eliminated
    ):
        return None
    start, _ = start_of(problem, system, block)
    if start is None:
        return None
    known = [
        np.ravel(solution.variables[problem.closure.slices[c.name]])
        for c in problem.known_coordinates
    ]
    ends = instance(system, start, known_values(problem, np.concatenate(known)))
    return np.asarray(ends.isolated[list(system.projective)])
