"""Between the coordinates of a problem and the points (z, k) of its algebraic system."""

from __future__ import annotations

import casadi as ca
import numpy as np

from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import distance_function, is_universal
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.system import System
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
    line = _line_of_distances(problem)
    if line is None:
        return (known.T / _known_scale(problem)).T
    begin, slope = line
    return slope @ known.astype(complex) + (begin if known.ndim == 1 else begin[:, None])


@lru_cache(maxsize=128)
def _known_scale(problem: Problem) -> np.ndarray:
    return coordinate_scale(problem, problem.known_coordinates)


@lru_cache(maxsize=128)
def _line_of_distances(problem: Problem) -> tuple[np.ndarray, np.ndarray] | None:
    """Six distances and their points (42,), over the size, at joints that are zero, and their
    derivatives: they are linear in the joints. None for another problem.
    """
    function = distance_function(problem) if is_universal(problem) else None
    if function is None:
        return None
    size, zero = problem.closure.characteristic_length, np.zeros(function.numel_in(0))
    at_zero = function(zero)
    slope = function.jacobian()(zero, at_zero)
    return np.asarray(at_zero)[:, 0] / size, np.asarray(ca.densify(slope)) / size


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
            position = 2 * size * _products(rays[4:], conjugate(rays[:4]))[1:]
            values |= {
                f"{system.body}.{axis}": position[i][:, None] for i, axis in enumerate("xyz")
            }
    return values


def algebraic_points(
    problem: Problem, system: AlgebraicSystem, block: System, points: np.ndarray
) -> np.ndarray:
    """z (width, n) of real roots given as points (n, numbers) of the block: the inverse of
    `real_values`.
    """
    size = problem.closure.characteristic_length
    columns, scale, pose = _columns(system, block, size)
    z = (points[:, columns] / scale).T.astype(complex)
    if not system.projective:
        return z
    own = {name: points[:, place].T for name, place in pose.items()}
    return np.concatenate([z, pose_point(own, size)])


@lru_cache(maxsize=128)
def _columns(
    system: AlgebraicSystem, block: System, size: float
) -> tuple[list[int], np.ndarray, dict[str, slice]]:
    """Where a block's points have the affine unknowns of an algebraic system, what these are
    divided by, and where they have the coordinates of its body's pose.
    """
    columns = [block.places[c.name].start for c in system.unknowns]
    start = f"{system.body}."
    pose = {
        f"pose.{name.removeprefix(start)}": place
        for name, place in block.places.items()
        if name.startswith(start)
    }
    return columns, np.array(units_of(system.unknowns, size)), pose


def pose_point(values: dict[str, np.ndarray], size: float) -> np.ndarray:
    """Study coordinates (e, g / size) of a pose, components first; of one without a position, whose
    motion is spherical, the quaternion.
    """
    e = values["pose.quaternion"]
    if "pose.x" not in values:
        return e
    x, y, z = (values[f"pose.{axis}"][0] / size for axis in "xyz")
    return np.concatenate([e, 0.5 * _products(np.array([0.0 * x, x, y, z]), e)])


_PRODUCT = np.array([[multiply(p, q) for q in np.eye(4)] for p in np.eye(4)])
"""The product of the unit quaternions j and k, components along the last axis."""


def _products(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Products (4, n) of quaternions (4, n), real or complex, in one step."""
    return np.asarray(np.einsum("jki,jn,kn->in", _PRODUCT, p, q))
