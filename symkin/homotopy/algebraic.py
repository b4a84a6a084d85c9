"""Closure rows over the complex numbers: a system F(z, k) = 0 whose roots are tracked while k
moves.

z holds angles, lengths / size and, where the pose is unknown, a projective point: Study coordinates
(e, g / size), or a quaternion. Rows are divided by the size. Evaluation is vectorised over paths:
the SX graph is walked once into straight-line NumPy code, in which every value is an array over the
paths.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.numpy_code import vectorise
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.numeric.mapped import Mapped
from symkin.position.roots import merge

SAME_ROOT = 1e-6
"""Largest difference of features (relative to 1) of two equal roots."""


@dataclass(frozen=True, eq=False)
class AlgebraicSystem:
    """Rows of one block of a problem, lengths in units of `size`.

    `projective` are the places of a homogeneous group in z (a ray), empty if none; `unknowns` are
    the affine coordinates, in order, before it. `eliminated` are angles that the rows do not hold,
    with their values at real roots. `known_ray` are places in k of a quaternion of any length;
    `body` begins the names of the coordinates for which the projective point stands.
    """

    characteristic_length: float
    unknowns: tuple[Coordinate, ...]
    z: ca.SX
    k: ca.SX
    rows: ca.SX
    projective: tuple[int, ...]
    eliminated: tuple[tuple[Coordinate, ca.SX], ...] = ()
    known_ray: tuple[int, ...] = ()
    body: str = "pose"

    @cached_property
    def width(self) -> int:
        """Numbers that hold the unknowns."""
        return self.z.shape[0]

    @cached_property
    def count(self) -> int:
        """Rows."""
        return self.rows.shape[0]

    @cached_property
    def cost(self) -> int:
        """Instructions of one evaluation of the rows and their derivatives."""
        return self._function.n_instructions()

    @cached_property
    def _code(self) -> Callable[..., None]:
        return vectorise(self._function)

    @cached_property
    def _function(self) -> ca.Function:
        direction = ca.SX.sym("dk", self.k.shape[0])
        along = ca.jtimes(self.rows, self.k, direction)
        outputs = [self.rows, ca.jacobian(self.rows, self.z), along]
        return ca.Function("f", [self.z, self.k, direction], outputs, {"cse": True})

    @cached_property
    def _residual(self) -> Callable[..., None]:
        return vectorise(
            ca.Function(
                "r", [self.z, self.k], [self.rows, ca.jacobian(self.rows, self.z)], {"cse": True}
            )
        )

    @cached_property
    def angles_eliminated(self) -> Mapped:
        """Values of the eliminated angles at real (z, k)."""
        return Mapped.of([self.z, self.k], [value for _, value in self.eliminated])

    def evaluate(
        self, z: np.ndarray, k: np.ndarray, dk: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """F (n, rows), dF/dz (n, rows, width) and dF/dk dk (n, rows) at z (width, n), k (known, n),
        dk (known, 1 or n).
        """
        n = z.shape[1]
        f, j, t = (np.zeros((n, self.count, c), dtype=complex) for c in (1, self.width, 1))
        self._code(z, k, dk, f, j, t)
        return f[:, :, 0], j, t[:, :, 0]

    def linearise(self, z: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F and dF/dz at z (width, n), k (known, n)."""
        n = z.shape[1]
        f, j = (np.zeros((n, self.count, c), dtype=complex) for c in (1, self.width))
        self._residual(z, k, f, j)
        return f[:, :, 0], j

    def features(self, z: np.ndarray) -> np.ndarray:
        """Coordinates (n, any) in which equal roots are equal: cos and sin of angles, squares of
        rod lengths, the projector of the ray; large ones relative to their size.
        """
        parts: list[np.ndarray] = []
        for i, c in enumerate(self.unknowns):
            if c.is_periodic:
                parts += _within_reach(np.cos(z[i]), np.sin(z[i]))
            elif c.least is None:
                parts += _within_reach(z[i])
            else:
                parts += _within_reach((z[i] - c.least / self.characteristic_length) ** 2)
        if self.projective:
            ray = z[list(self.projective)]
            ray = ray / np.linalg.norm(ray, axis=0)
            parts += list(
                (ray[:, None] * np.conj(ray[None])).reshape(ray.shape[0] ** 2, ray.shape[1])
            )
        return np.array(parts).T

    def patched(self, z: np.ndarray, j: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """dF/dz (n, rows, width or more columns) and F (n, rows) at points z (width, n), with a row
        that keeps a step orthogonal to the ray, whose length means nothing.
        """
        if not self.projective:
            return j, f
        row = np.zeros((len(j), 1, j.shape[2]), dtype=complex)
        row[:, 0, self.projective] = np.conj(z[list(self.projective)]).T
        return np.concatenate([j, row], axis=1), np.concatenate([f, np.zeros((len(f), 1))], axis=1)

    def unit_rays(self, z: np.ndarray) -> np.ndarray:
        """The same points with rays of unit length."""
        z, ray = z.copy(), list(self.projective)
        if ray:
            z[ray] = z[ray] / np.linalg.norm(z[ray], axis=0)
        return z

    def normalise(self, z: np.ndarray) -> np.ndarray:
        """Rays to unit length, angles into (-pi, pi]."""
        z = self.unit_rays(z)
        z[self.angles] -= 2 * np.pi * np.round(z[self.angles].real / (2 * np.pi))
        return z

    @cached_property
    def angles(self) -> list[int]:
        """Places of the unknowns that are angles."""
        return [i for i, c in enumerate(self.unknowns) if c.is_periodic]

    @cached_property
    def others(self) -> list[int]:
        """Places of the unknowns that are none."""
        return [i for i, c in enumerate(self.unknowns) if not c.is_periodic]


def _within_reach(*values: np.ndarray) -> list[np.ndarray]:
    """Numbers over the largest of them, if that is above 1, and how large it is: differences of far
    roots count as far as their digits do.
    """
    size = np.maximum(1.0, np.max(np.abs(values), axis=0))
    return [*(value / size for value in values), np.log(size)]


def complex_normal(count: int, rng: np.random.Generator) -> np.ndarray:
    """Complex numbers of a normal distribution, mean square 1."""
    return (rng.normal(size=count) + 1j * rng.normal(size=count)) / np.sqrt(2)


def known_root(system: AlgebraicSystem, known: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Index of the known root (width, m) that each column of z repeats; -1 where it is new."""
    apart = np.abs(system.features(z)[:, None] - system.features(known)[None])
    same = np.max(apart, axis=2, initial=0.0) < SAME_ROOT
    # a last column that none is, of which there may be no other
    first = np.argmax(np.pad(same, ((0, 0), (0, 1)), constant_values=True), axis=1)
    return np.where(first < same.shape[1], first, -1)


def first_of_each(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """Places of the roots z (width, n) that repeat no earlier one."""
    features = system.features(z)
    return merge(np.hstack([features.real, features.imag]), SAME_ROOT)[0]


def imaginary_part(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """How far each root (width, n) is from being real: largest imaginary part, rays turned to
    their best phase.
    """
    found = np.abs(z[: len(system.unknowns)].imag).max(axis=0, initial=0.0)
    if system.projective:
        ray = z[list(system.projective)]
        turned = ray / ray[np.abs(ray).argmax(axis=0), np.arange(ray.shape[1])]
        found = np.maximum(found, np.abs(turned.imag).max(axis=0))
    return found
