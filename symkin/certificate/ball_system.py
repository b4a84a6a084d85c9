"""A system's rows and their derivatives over balls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from flint import ctx

from symkin.computed_once import cached_property
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.far_roots import rows_over_balls
from symkin.numeric.balls import Number, Prepared, Ring


@dataclass(frozen=True, eq=False)
class BallSystem:
    """F(z, k) and dF/dz over balls, at known values k: doubles, taken as exact, or balls."""

    system: AlgebraicSystem
    known: tuple[Number, ...]
    _prepared: dict[tuple[bool, int], Prepared] = field(default_factory=dict)

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
        return rows_over_balls(self.system).evaluate(0, z, self._at(ring))

    def jacobian(self, ring: Ring, z: Sequence[Number]) -> list[Number]:
        """dF/dz at balls z, row by row."""
        return rows_over_balls(self.system).evaluate(1, z, self._at(ring))

    def _at(self, ring: Ring) -> Prepared:
        """What the known values determine, at the present precision."""
        key = (ring.is_real, ctx.prec)
        if key not in self._prepared:
            self._prepared[key] = rows_over_balls(self.system).prepare(ring, self.known)
        return self._prepared[key]
