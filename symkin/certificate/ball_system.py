"""A system's rows and their derivatives over balls, by its graph or, where the rows are quadratic,
by matrix products.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
from flint import ctx

from symkin.computed_once import cached_property, lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.balls import BallFunction, Number, Part, Ring, raise_constants


@dataclass(frozen=True, eq=False)
class BallSystem:
    """F(z, k) and dF/dz over balls, at known values k that are doubles, taken as exact, or balls.

    Rows with a second derivative that does not depend on z, F_i = z.A_i z / 2 + b_i.z + c_i, are
    evaluated from A, b and c, which are enclosed once: dF/dz = A z + b and F = (dF/dz + b) z / 2 +
    c.
    """

    system: AlgebraicSystem
    known: tuple[Number, ...]
    _prepared: dict[tuple[bool, int], list[Any]] = field(default_factory=dict)

    @cached_property
    def width(self) -> int:
        """Unknowns."""
        return self.system.width

    @cached_property
    def count(self) -> int:
        """Rows that a root must satisfy."""
        return self.system.count

    @cached_property
    def all_rows(self) -> tuple[int, ...]:
        return tuple(range(self.count))

    @cached_property
    def all_columns(self) -> tuple[int, ...]:
        return tuple(range(self.width))

    @cached_property
    def freedom(self) -> int:
        """Unknowns, a ray's scale apart."""
        return self.width - bool(self.system.projective)

    def rows(self, ring: Ring, z: Sequence[Number]) -> list[Number]:
        """F at balls z."""
        if not _is_quadratic(self.system):
            return _graph(self.system).evaluate(0, z, self._at(ring))
        second, first, constant = self._at(ring)
        column = ring.column(z)
        slope = ring.matrix(self.count, self.width, (second * column + first + first).entries())
        return (slope * column * ring.number(0.5) + constant).entries()

    def jacobian(self, ring: Ring, z: Sequence[Number]) -> list[Number]:
        """dF/dz at balls z, row by row."""
        if not _is_quadratic(self.system):
            return _graph(self.system).evaluate(1, z, self._at(ring))
        second, first, _ = self._at(ring)
        return (second * ring.column(z) + first).entries()

    def _at(self, ring: Ring) -> list[Any]:
        """What the known values determine, at the present precision."""
        key = (ring.is_real, ctx.prec)
        if key not in self._prepared:
            graph = _graph(self.system)
            prepared = graph.prepare(ring, self.known)
            if _is_quadratic(self.system):
                sizes = (
                    (self.count * self.width, self.width),
                    (self.count * self.width, 1),
                    (self.count, 1),
                )
                prepared = [
                    ring.matrix(*s, graph.evaluate(i, (), prepared)) for i, s in enumerate(sizes)
                ]
            self._prepared[key] = prepared
        return self._prepared[key]


@lru_cache(maxsize=64)
def _is_quadratic(system: AlgebraicSystem) -> bool:
    rows, _, _ = raise_constants(system.rows, system.z, system.k)
    return not any(ca.which_depends(ca.vec(ca.jacobian(rows, system.z)), system.z, 2, True))


@lru_cache(maxsize=64)
def _graph(system: AlgebraicSystem) -> BallFunction:
    """Rows and first derivatives; of quadratic rows the coefficients A, b, c."""
    parts: tuple[Part, ...] = (
        ("second", "first", "constant") if _is_quadratic(system) else ("value", "slope")
    )
    return BallFunction(system.z, system.k, system.rows, parts)
