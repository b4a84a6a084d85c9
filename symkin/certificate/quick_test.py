"""Krawczyk's test in double precision for all points at once, with bounds for every rounding.

For F(z) = 0 with as many rows as unknowns (a ray's patch is one more row), points c and any matrix
Y, with e_i >= sum_j |1 - Y F'(X)|_ij on the numbers X within `wide` of the first points and s_i >=
|Y F(c)|_i,

    s_i + 1.5 e_i r < r for all i

shows one root, regular, within r of c, and no other in the box |Re|, |Im| <= r (see `krawczyk`, and
`data/krawczyk.h` for the bounds). Where the known values and c are real, so is the root. What fails
here may be proved by balls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.certificate.disc_arithmetic import LARGEST, UNIT, UP, modulus
from symkin.certificate.disc_library import disc_library
from symkin.certificate.discs import DiscFunction, Discs, Knowns
from symkin.certificate.tape import build_tape
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem

_WIDE = (2.0**-30, 2.0**-34, 2.0**-40)
"""Distances from a point within which the derivatives are bounded, one trial after another. The
first may serve to come near.
"""
_MOST_UNKNOWNS = 64
"""Up to which the rounding of sums is allowed for."""
_WORTH_NUMPY = 250
"""Points from which on the test in NumPy takes less time than balls."""
_FLOOR = 2.0**-600
"""Allowance for underflow in sums, with entries of the inverse below 2^400."""
_MANY = 1.0 + 2.0**-44
"""Outweighs the roundings of sums of numbers that are not negative, for that many unknowns."""


@dataclass(frozen=True, eq=False)
class Enclosures:
    """Of n points: the half width (n,) of the box about `centre` (width, n) that holds one root,
    infinite where the test is open, and whether its numbers are real.
    """

    centre: np.ndarray
    half_width: np.ndarray
    is_real: np.ndarray

    @property
    def found(self) -> np.ndarray:
        return np.asarray(np.isfinite(self.half_width))


def enclose_all(
    system: AlgebraicSystem, z: np.ndarray, real: np.ndarray, knowns: Knowns, instance: np.ndarray
) -> Enclosures:
    """The test at points z (width, n) of instances (n,), of their real parts in real numbers where
    `real` (n,).
    """
    n, is_real = z.shape[1], real & knowns.discs.is_real
    function = disc_function(system)
    square = system.count + bool(system.projective) == system.width <= _MOST_UNKNOWNS
    if function is None or not square or (n < _WORTH_NUMPY and disc_library() is None):
        return Enclosures(z.copy(), np.full(n, np.inf), is_real)
    points, prepared = z.T, function.prepare(knowns.discs)
    centre, half = np.empty((n, len(z)), dtype=complex), np.empty(n)
    for among, of_real in ((is_real, True), (~is_real, False)):
        if among.any():
            chosen = points[among].real if of_real else points[among]
            ready = prepared if of_real else prepared.as_complex()
            centre[among], half[among] = _enclose(
                function, system.projective, chosen, ready, instance[among]
            )
    return Enclosures(centre.T, half, is_real)


@lru_cache(maxsize=128)
def disc_function(system: AlgebraicSystem) -> DiscFunction | None:
    """The rows of a system and their derivatives over discs; None where an operation has no form
    over them.
    """
    try:
        return DiscFunction(build_tape(system.z, system.k, system.rows, ("value", "slope")))
    except NotImplementedError:
        return None


def _enclose(
    function: DiscFunction,
    ray: tuple[int, ...],
    points: np.ndarray,
    prepared: Discs,
    instance: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, width) and half widths for points of one kind; trials about what the one before
    has come to.
    """
    points = np.ascontiguousarray(points)
    patch = np.zeros(points.shape, dtype=points.dtype)
    if ray:
        patch[:, ray[0] : ray[-1] + 1] = points[:, ray[0] : ray[-1] + 1].conj()
    centre, half = _test(function, points, patch, prepared, instance, _WIDE[0])
    for wide in _WIDE[1:]:
        todo = ~np.isfinite(half)
        if not todo.any():
            break
        centre[todo], half[todo] = _test(
            function, centre[todo], patch[todo], prepared, instance[todo], wide
        )
    return centre, half


def _test(
    function: DiscFunction,
    points: np.ndarray,
    patch: np.ndarray,
    prepared: Discs,
    instance: np.ndarray,
    wide: float,
) -> tuple[np.ndarray, np.ndarray]:
    """One trial: a Newton step from points (n, width), and half widths (n,), infinite where it
    fails.
    """
    library = disc_library()
    if library is not None:
        chosen = np.ascontiguousarray(instance, dtype=np.intc)
        return library.enclose(
            function.tape, points, patch, (prepared.middle, prepared.radius), chosen, wide
        )
    with np.errstate(all="ignore"):
        return _test_in_numpy(function, points, patch, prepared, instance, wide)


def _test_in_numpy(
    function: DiscFunction,
    points: np.ndarray,
    patch: np.ndarray,
    prepared: Discs,
    instance: np.ndarray,
    wide: float,
) -> tuple[np.ndarray, np.ndarray]:
    n, width = points.shape
    rows = function.tape.parts[0].outputs
    slope = function.evaluate(1, Discs(points, np.full(points.shape, wide)), prepared, instance)
    middle, error = np.zeros((2, n, width, width), dtype=points.dtype)
    middle[:, *function.tape.patterns[1]], middle[:, rows:] = (
        slope.middle,
        patch[:, None][:, : width - rows],
    )
    error = np.zeros((n, width, width))
    error[:, *function.tape.patterns[1]] = slope.radius
    gamma = (2 * width + 8) * UNIT
    inverse = _inverses(middle)
    weights = modulus(inverse)
    value = function.evaluate(0, Discs.exact(points), prepared, instance).middle
    centre = points - np.einsum("nij,nj->ni", inverse[:, :, :rows], value)
    f = function.evaluate(0, Discs.exact(centre), prepared, instance)
    step = modulus(np.einsum("nij,nj->ni", inverse[:, :, :rows], f.middle))
    s = (
        step
        + np.einsum("nij,nj->ni", weights[:, :, :rows], f.radius + gamma * modulus(f.middle))
        + _FLOOR
    ) * _MANY
    off = np.sum(modulus(np.einsum("nij,njk->nik", inverse, middle) - np.eye(width)), axis=2)
    e = (
        off
        + np.einsum("nij,nj->ni", weights, np.sum(error + gamma * modulus(middle), axis=2))
        + _FLOOR
    ) * _MANY
    half = np.max(s / (0.98 - 1.5 * e), axis=1) * (1.0 + 2.0**-40)
    away = modulus(centre - points) + 1.5 * half[:, None]
    inside = (
        (e < 0.6)
        & (weights.max(axis=2) < LARGEST)
        & ((s + e * (1.5 * half[:, None])) * UP < half[:, None])
        & (away * UP <= wide)
    )
    return centre, np.where(inside.all(axis=1), half, np.inf)


def _inverses(matrices: np.ndarray) -> np.ndarray:
    """About the inverses (n, m, m); no numbers where there is none."""
    try:
        return np.linalg.inv(matrices)
    except np.linalg.LinAlgError:
        singular = np.linalg.matrix_rank(np.nan_to_num(matrices)) < matrices.shape[1]
        regular = np.where(singular[:, None, None], np.eye(matrices.shape[1]), matrices)
        return np.where(singular[:, None, None], np.nan, np.linalg.inv(regular))
