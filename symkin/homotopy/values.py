"""Between the coordinates of a problem and the points (z, k) of its algebraic system."""

from __future__ import annotations

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import distance_data, is_universal
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem
from symkin.spatial.rotation import conjugate, multiply


def coordinate_scale(problem: Problem, coordinates: tuple[Coordinate, ...]) -> np.ndarray:
    """What a number of each coordinate is divided by: the size for lengths."""
    size = problem.closure.size
    parts = [np.full(c.width, 1.0 if c.is_angular or c.kind == "quaternion" else size) for c in coordinates]
    return np.concatenate([*parts, np.zeros(0)])


def known_angles(problem: Problem) -> np.ndarray:
    """Which numbers of the known coordinates are angles."""
    return np.array([c.kind == "angle" for c in problem.known_coordinates for _ in range(c.width)], dtype=bool)


def known_values(problem: Problem, known: np.ndarray) -> np.ndarray:
    """Known values of a problem, real or complex, as the algebraic system takes them."""
    data = distance_data(problem) if is_universal(problem) else None
    if data is not None:
        return data(known)
    return np.asarray(known / coordinate_scale(problem, problem.known_coordinates))


def real_values(problem: Problem, system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> dict[str, np.ndarray]:
    """Coordinates of the block (radians, length unit, unit quaternion) from a root at k that is real up to rounding."""
    size = problem.closure.size
    values = {c.name: np.array([z[i].real * (1.0 if c.is_angular else size)]) for i, c in enumerate(system.unknowns)}
    if system.eliminated:
        angles = system.angles_eliminated.call([z.real, k.real])
        values |= {c.name: np.asarray(angle).ravel() for (c, _), angle in zip(system.eliminated, angles, strict=True)}
    if system.projective:
        values |= _pose_values(z[list(system.projective)], size)
    return values


def _pose_values(ray: np.ndarray, size: float) -> dict[str, np.ndarray]:
    ray = (ray / ray[np.argmax(np.abs(ray))]).real
    ray = ray / np.linalg.norm(ray[:4])
    values = {"pose.quaternion": ray[:4]}
    if len(ray) == 8:
        position = 2 * size * multiply(ray[4:], conjugate(ray[:4]))[1:]
        values |= {f"pose.{axis}": position[i : i + 1] for i, axis in enumerate("xyz")}
    return values


def algebraic_point(problem: Problem, system: AlgebraicSystem, values: dict[str, np.ndarray]) -> np.ndarray:
    """z of a real root given as coordinates of the block: the inverse of `real_values`."""
    z = [values[c.name] / (1.0 if c.is_angular else problem.closure.size) for c in system.unknowns]
    if system.projective:
        z.append(pose_point(values, problem.closure.size))
    return np.concatenate(z).astype(complex)


def pose_point(values: dict[str, np.ndarray], size: float) -> np.ndarray:
    """Study coordinates (e, g / size) of a pose; of one without a position, whose motion is spherical, the quaternion."""
    e = values["pose.quaternion"]
    if "pose.x" not in values:
        return e
    t = np.concatenate([[0.0], *(values[f"pose.{axis}"] / size for axis in "xyz")])
    return np.concatenate([e, 0.5 * multiply(t, e)])
