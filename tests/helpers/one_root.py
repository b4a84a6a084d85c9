"""Coordinates of one root, and the root that they tell."""

from __future__ import annotations

import numpy as np

from helpers.inside import AlgebraicSystem, Problem, algebraic_points, many_real_values


def algebraic_point(
    problem: Problem, system: AlgebraicSystem, values: dict[str, np.ndarray]
) -> np.ndarray:
    """The root z (width,) that coordinates tell."""
    point = np.concatenate([values[c.name] for c in problem.system.unknowns])[None]
    return np.asarray(algebraic_points(problem, system, problem.system, point)[:, 0])


def real_values(
    problem: Problem, system: AlgebraicSystem, z: np.ndarray, k: np.ndarray
) -> dict[str, np.ndarray]:
    """The coordinates of a root z (width,) at k that is real up to rounding."""
    found = many_real_values(problem, system, z[:, None], k[:, None])
    return {name: value[0] for name, value in found.items()}
