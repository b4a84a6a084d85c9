"""Krawczyk's test in double precision for all points at once, with bounds for every rounding.

For F(z) = 0 with as many rows as unknowns (a ray's patch is one more row), points c and any matrix
Y, with e_i >= sum_j |1 - Y F'(X)|_ij on the numbers X within `wide` of the first points and s_i >=
|Y F(c)|_i,

    s_i + 1.5 e_i r < r for all i

shows one root, regular, within r of c, and no other in the box |Re|, |Im| <= r (see `krawczyk`, and
`numeric/data/krawczyk.h` for the bounds). Where the known values and c are real, so is the root.
What fails here, and all where no compiler is found, may be proved by balls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.certificate.discs import DiscFunction, Knowns
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.far_roots import rows_over_balls
from symkin.numeric.shared_library import SharedLibrary, shared_library
from symkin.numeric.tape import Tape

_WIDE = (2.0**-30, 2.0**-34, 2.0**-40)
"""Distances from a point within which the derivatives are bounded, one trial after another. The
first may serve to come near.
"""
_MOST_UNKNOWNS = 64
"""Up to which the rounding of sums is allowed for."""


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
    function, library = disc_function(system), shared_library()
    square = system.count + bool(system.projective) == system.width <= _MOST_UNKNOWNS
    if function is None or library is None or not square:
        return Enclosures(z.copy(), np.full(n, np.inf), is_real)
    centre, half = np.empty((n, len(z)), dtype=complex), np.empty(n)
    known = np.ascontiguousarray(knowns.discs.middle), np.ascontiguousarray(knowns.discs.radius)
    for among, points in ((is_real, z.real.T), (~is_real, z.T)):
        if among.any():
            centre[among], half[among] = _enclose(
                library, function.tape, system.projective, points[among], known, instance[among]
            )
    return Enclosures(centre.T, half, is_real)


@lru_cache(maxsize=128)
def disc_function(system: AlgebraicSystem) -> DiscFunction | None:
    """The rows of a system and their derivatives over discs; None where an operation has no form
    over them.
    """
    try:
        return DiscFunction(rows_over_balls(system).tape)
    except NotImplementedError:
        return None


def _enclose(
    library: SharedLibrary,
    tape: Tape,
    ray: tuple[int, ...],
    points: np.ndarray,
    known: tuple[np.ndarray, np.ndarray],
    instance: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, width) and half widths for points of one kind, by a Newton step each; trials
    about what the one before has come to.
    """
    points = np.ascontiguousarray(points)
    patch = np.zeros(points.shape, dtype=points.dtype)
    if ray:
        patch[:, ray[0] : ray[-1] + 1] = points[:, ray[0] : ray[-1] + 1].conj()
    chosen = np.ascontiguousarray(instance, dtype=np.intc)
    centre, half = library.enclose(tape, points, patch, known, chosen, _WIDE[0])
    for wide in _WIDE[1:]:
        todo = ~np.isfinite(half)
        if not todo.any():
            break
        centre[todo], half[todo] = library.enclose(
            tape, centre[todo], patch[todo], known, chosen[todo], wide
        )
    return centre, half
