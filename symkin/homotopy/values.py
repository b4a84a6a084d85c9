"""Between the coordinates of a problem and the points (z, k) of its algebraic system."""

from __future__ import annotations

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import distance_data, is_universal
from symkin.model.joint import Coordinate, units_of
from symkin.position.problem import Problem
from symkin.spatial.rotation import conjugate, multiply


def coordinate_scale(problem: Problem, coordinates: tuple[Coordinate, ...]) -> np.ndarray:
    """What a number of each coordinate is divided by: the size for lengths."""
    return np.array(units_of(coordinates, problem.closure.characteristic_length))


def known_angles(problem: Problem) -> np.ndarray:
    """Which numbers of the known coordinates are angles."""
    return np.array(
        [c.is_periodic for c in problem.known_coordinates for _ in range(c.width)], dtype=bool
    )


def known_values(problem: Problem, known: np.ndarray) -> np.ndarray:
    """Known values of a problem (known,) or (known, n), real or complex, as the algebraic system
    takes them.
    """
    data = distance_data(problem) if is_universal(problem) else None
    if data is not None:
        return data(known)
    scale = coordinate_scale(problem, problem.known_coordinates)
    return (known.T / scale).T


def real_values(
    problem: Problem, system: AlgebraicSystem, z: np.ndarray, k: np.ndarray
) -> dict[str, np.ndarray]:
    """Coordinates (n, numbers) of the block (radians, length unit, unit quaternion) from roots z
    (width, n) at k (known, n) that are real up to rounding.
    """
    real = z.real.copy()
    if system.projective:
        rays = z[list(system.projective)]
        largest = rays[np.argmax(np.abs(rays), axis=0), np.arange(rays.shape[1])]
        real[list(system.projective)] = (rays / largest).real
    values = complex_values(problem, system, real)
    if system.eliminated:
        angles = system.angles_eliminated(real.T, k.real.T)
        values |= {
            c.name: angle[:, :, 0] for (c, _), angle in zip(system.eliminated, angles, strict=True)
        }
    return values


def complex_values(
    problem: Problem, system: AlgebraicSystem, z: np.ndarray
) -> dict[str, np.ndarray]:
    """Coordinates (n, numbers) of the block from roots z (width, n), complex ones too; of a block
    without eliminated angles.

    From Study coordinates (e, g) the quaternion is e / sqrt(e . e), with the complex root, and the
    position 2 g e* / (e . e).
    """
    size = problem.closure.characteristic_length
    values = {c.name: z[i][:, None] * c.unit(size) for i, c in enumerate(system.unknowns)}
    if system.projective:
        rays = z[list(system.projective)]
        rays = rays / np.sqrt(np.einsum("in,in->n", rays[:4], rays[:4]))
        values[f"{system.body}.quaternion"] = rays[:4].T
        if len(rays) == 8:
            position = 2 * size * multiply(rays[4:], conjugate(rays[:4]))[1:]
            values |= {
                f"{system.body}.{axis}": position[i][:, None] for i, axis in enumerate("xyz")
            }
    return values


def algebraic_points(
    problem: Problem, system: AlgebraicSystem, values: dict[str, np.ndarray]
) -> np.ndarray:
    """z (width, n) of real roots given as coordinates (n, numbers) of the block: the inverse of
    `real_values`.
    """
    size = problem.closure.characteristic_length
    z = [values[c.name].T / c.unit(size) for c in system.unknowns]
    if system.projective:
        start = f"{system.body}."
        own = {
            f"pose.{name.removeprefix(start)}": value.T
            for name, value in values.items()
            if name.startswith(start)
        }
        z.append(pose_point(own, size))
    return np.concatenate(z).astype(complex)


def pose_point(values: dict[str, np.ndarray], size: float) -> np.ndarray:
    """Study coordinates (e, g / size) of a pose, components first; of one without a position, whose
    motion is spherical, the quaternion.
    """
    e = values["pose.quaternion"]
    if "pose.x" not in values:
        return e
    x, y, z = (values[f"pose.{axis}"][0] / size for axis in "xyz")
    return np.concatenate([e, 0.5 * multiply(np.array([0.0 * x, x, y, z]), e)])
