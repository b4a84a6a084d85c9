"""A square or rectangular system of closure rows in unknown coordinates, with batched evaluation.

Steps are taken in the tangent space: d = (lengths; size * angles; size * rotation vector in the
base frame for each quaternion), all in the length unit, so that columns are comparable and unit
quaternions stay unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.numeric.linear_algebra import condition_of, extreme_singular_values
from symkin.numeric.mapped import Mapped
from symkin.numeric.newton import Polished, polish
from symkin.numeric.tolerances import ROUNDED_COMPONENT
from symkin.spatial.rotation import multiply, wrapped

_MANY_NUMBERS = 4096
"""Numbers of a Jacobian from which on common parts are not looked for: in rows of so many loops
these are a tenth of the operations, and finding them takes as long as 10^4 evaluations.
"""
_AT_ONCE = 256_000
"""Entries of Jacobians that are held at once: they stay in the processor's cache."""
_UNITS = np.array([[1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]])
_SIGNS = np.array([[-1.0, 1.0, -1.0, 1.0], [-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])
"""Places and signs of a quaternion's components in its products by i, j, k from the left."""
NOTHING = np.zeros(0)
"""Known values of a system that has none."""


@dataclass(frozen=True, eq=False)
class System:
    """Rows F(z; k) of the unknown coordinates z given known values k, geometry bound.

    `errors` are the full checks of the same constraints in the length unit; `farthest` is the
    largest coordinate of the points that rows are written with, where that is more than the size:
    what is far from the origin rounds more.
    """

    unknowns: tuple[Coordinate, ...]
    unknown: ca.SX
    known: ca.SX
    rows: ca.SX
    errors: ca.SX
    characteristic_length: float
    farthest: float = 0.0

    @cached_property
    def width(self) -> int:
        """Numbers that hold the unknowns."""
        return self.unknown.shape[0]

    @cached_property
    def count(self) -> int:
        """Rows."""
        return self.rows.shape[0]

    @cached_property
    def freedom(self) -> int:
        """Dimension of the tangent space of the unknowns."""
        return sum(c.freedom for c in self.unknowns)

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        ends = np.cumsum([c.width for c in self.unknowns]).tolist()
        return tuple(slice(end - c.width, end) for c, end in zip(self.unknowns, ends, strict=True))

    @cached_property
    def places(self) -> dict[str, slice]:
        """Places of the unknowns by their names."""
        return {c.name: place for c, place in zip(self.unknowns, self.slices, strict=True)}

    @cached_property
    def lengths(self) -> list[int]:
        """Places of the unknowns that are lengths."""
        return [self.places[c.name].start for c in self.unknowns if c.is_length]

    def exchanged(self, known: tuple[Coordinate, ...]) -> System:
        """The same rows with the values of coordinates that were `known` unknown, and back."""
        return replace(self, unknowns=known, unknown=self.known, known=self.unknown)

    def freed(self, known: tuple[Coordinate, ...]) -> System:
        """The same rows with the values of coordinates that were `known` unknown as well, behind
        the others.
        """
        both = ca.vertcat(self.unknown, self.known)
        return replace(self, unknowns=(*self.unknowns, *known), unknown=both, known=ca.SX(0, 1))

    def norms(self, z: ca.SX) -> ca.SX:
        """|q|^2 - 1 of each quaternion of a point z (width,)."""
        turns = [self.places[c.name] for c in self.unknowns if c.is_rotation]
        return ca.vertcat(*(ca.sumsqr(z[place]) - 1 for place in turns), ca.SX(0, 1))

    @cached_property
    def tangent(self) -> ca.SX:
        """dz/dd, width x freedom: columns 1, 1/size, and half the quaternion product with a unit
        vector / size.
        """
        basis = ca.SX(self.width, self.freedom)
        column = 0
        for coordinate, place in zip(self.unknowns, self.slices, strict=True):
            if coordinate.is_rotation:
                q = self.unknown[place]
                for k in range(3):
                    direction = [0.0, 0.0, 0.0, 0.0]
                    direction[k + 1] = 0.5 / self.characteristic_length
                    basis[place, column + k] = multiply(direction, q)
            else:
                basis[place.start, column] = 1 / coordinate.lever(self.characteristic_length)
            column += coordinate.freedom
        return basis

    @cached_property
    def jacobian(self) -> ca.SX:
        """dF/dd, rows x freedom; dimensionless."""
        return ca.mtimes(ca.jacobian(self.rows, self.unknown), self.tangent)

    @cached_property
    def _linearised(self) -> Mapped:
        few = self.rows.shape[0] * self.freedom < _MANY_NUMBERS
        return Mapped.of([self.unknown, self.known], [self.rows, self.jacobian], common=few)

    @cached_property
    def _judged(self) -> Mapped:
        few = self.rows.shape[0] * self.freedom < _MANY_NUMBERS
        told = [self.rows, self.jacobian, self.errors]
        return Mapped.of([self.unknown, self.known], told, common=few)

    @cached_property
    def _checked(self) -> Mapped:
        return Mapped.of([self.unknown, self.known], [self.errors])

    # --- evaluation: n points z (n, width), known values of each (n, known) or of all (known,) ----

    def linearise(
        self, z: np.ndarray, known: np.ndarray = NOTHING
    ) -> tuple[np.ndarray, np.ndarray]:
        """F (n, rows) and dF/dd (n, rows, freedom)."""
        values, jacobians = self._linearised(z, known)
        return values[:, :, 0], jacobians

    def checks(self, z: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Closure errors (n, checks) in the length unit, of all constraints and whole rotations."""
        return self._checked(z, known)[0][:, :, 0]

    def residuals(self, z: np.ndarray, known: np.ndarray = NOTHING) -> np.ndarray:
        """The largest of the `checks` (n,)."""
        return np.max(np.abs(self.checks(z, known)), axis=1, initial=0.0)

    def judge(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What `linearise` and `residuals` give, in one evaluation."""
        values, jacobians, errors = self._judged(z, known)
        return values[:, :, 0], jacobians, np.abs(errors).max(axis=(1, 2), initial=0.0)

    def extremes(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Largest and smallest (n, 2) of the min(rows, freedom) singular values of dF/dd, and the
        `residuals` (n,); few points at a time, since the Jacobians of a large system hold millions
        of numbers.
        """
        if min(self.count, self.freedom) == 0:
            return np.ones((len(z), 2)), self.residuals(z, known)
        each = max(1, _AT_ONCE // (self.count * self.freedom))
        every = np.broadcast_to(known, (len(z), known.shape[-1])) if len(z) > each else known
        found = []
        for i in range(0, max(len(z), 1), each):
            part = slice(i, i + each)
            at = every[part] if every.ndim == z.ndim else every
            _, jacobians, residuals = self.judge(z[part], at)
            found.append((extreme_singular_values(jacobians), residuals))
        if len(found) == 1:
            return found[0]
        return np.concatenate([e for e, _ in found]), np.concatenate([r for _, r in found])

    def conditions(self, z: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Largest over smallest (n,) of the min(rows, freedom) singular values of dF/dd; infinite
        at a singularity, 1 where there are no rows or no unknowns.
        """
        return condition_of(self.extremes(z, known)[0])

    def polish_many(self, z: np.ndarray, known: np.ndarray = NOTHING, steps: int = 8) -> Polished:
        """Gauss-Newton on all rows from each point, until its step no longer shrinks the rows."""
        return polish(self, z, known, steps)

    # --- the same at one point z (width,) with known values (known,) ------------------------------

    def linearise_one(
        self, z: np.ndarray, known: np.ndarray = NOTHING
    ) -> tuple[np.ndarray, np.ndarray]:
        """F (rows,) and dF/dd (rows, freedom)."""
        values, jacobians = self.linearise(z[None], known)
        return values[0], jacobians[0]

    def residual(self, z: np.ndarray, known: np.ndarray = NOTHING) -> float:
        """Largest closure error in the length unit, over all constraints and whole rotations."""
        return float(self.residuals(z[None], known)[0])

    def condition(self, z: np.ndarray, known: np.ndarray) -> float:
        """Condition of dF/dd; infinite at a singularity."""
        return float(self.conditions(z[None], known)[0])

    def polish(self, z: np.ndarray, known: np.ndarray, steps: int = 4) -> np.ndarray:
        """Gauss-Newton on all rows until the step no longer shrinks them."""
        return polish(self, z[None], known, steps).points[0]

    # --- points of the configuration space --------------------------------------------------------

    def move(self, z: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Retraction: add tangent steps (n, freedom) to points (n, width); quaternions are turned
        and normalised. In few array operations, since it is called for one point at a time too.
        """
        plain, columns, units, turns = self._retraction
        moved = z.copy()
        moved[:, plain] += step[:, columns] / units
        for place, column in turns:
            half = (0.5 / self.characteristic_length) * step[:, column : column + 3]
            q = z[:, place]
            q = q + np.einsum("nk,nki->ni", half, q[:, _UNITS] * _SIGNS)
            moved[:, place] = q / np.sqrt(np.add.reduce(q * q, axis=1))[:, None]
        return moved

    def difference(self, z: np.ndarray, there: np.ndarray) -> np.ndarray:
        """The tangent steps (n, freedom) that `move` takes from points (n, width) to others."""
        plain, columns, units, turns = self._retraction
        step = np.empty((len(z), self.freedom))
        step[:, columns] = (there[:, plain] - z[:, plain]) * units
        for place, column in turns:
            a, b = z[:, place], there[:, place]
            turn = a[:, :1] * b[:, 1:] - b[:, :1] * a[:, 1:] - np.cross(b[:, 1:], a[:, 1:])
            cosine = np.sum(a * b, axis=1, keepdims=True)
            # no step leads to half a turn: a very long one
            cosine = np.where(np.abs(cosine) > ROUNDED_COMPONENT, cosine, ROUNDED_COMPONENT)
            step[:, column : column + 3] = 2.0 * self.characteristic_length * turn / cosine
        return step

    @cached_property
    def _retraction(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[tuple[slice, int]]]:
        """Entries and tangent columns of single numbers, and tangent lengths that make one;
        (entries, first column) of quaternions.
        """
        plain, columns, units, turns, column = [], [], [], [], 0
        for c, place in zip(self.unknowns, self.slices, strict=True):
            if c.is_rotation:
                turns.append((place, column))
            else:
                plain.append(place.start)
                columns.append(column)
                units.append(c.lever(self.characteristic_length))
            column += c.freedom
        return np.array(plain, dtype=int), np.array(columns, dtype=int), np.array(units), turns

    def unit(self, z: np.ndarray) -> np.ndarray:
        """The same point with quaternions of unit length."""
        return self.move(z[None], np.zeros((1, self.freedom)))[0]

    def fold(self, points: np.ndarray) -> np.ndarray:
        """The same configurations with rod lengths that are not negative."""
        folded = points.copy()
        for coordinate, place in zip(self.unknowns, self.slices, strict=True):
            if coordinate.least is not None:
                folded[:, place] = coordinate.least + np.abs(points[:, place] - coordinate.least)
        return folded

    def wrap(self, points: np.ndarray) -> np.ndarray:
        """The same configurations with angles within half a turn of zero: after 1e7 turns a sine
        has nine digits left.
        """
        turned = points.copy()
        for coordinate, place in zip(self.unknowns, self.slices, strict=True):
            if coordinate.is_periodic:
                turned[..., place] = wrapped(turned[..., place])
        return turned


def split_blocks(system: System, *, by_errors: bool = False) -> tuple[System, ...]:
    """Independent parts: the connected components of the graph of unknown coordinates and rows,
    and closure errors where these tie as well. A limb whose platform pose is given is one part; its
    branches are found alone and combined afterwards.
    """
    errors_of = incidence_of(system.errors, system)
    rows_of = incidence_of(system.rows, system)
    groups = components([*rows_of, *(errors_of if by_errors else [])], len(system.unknowns))
    blocks = []
    for group in groups:
        unknowns = tuple(system.unknowns[k] for k in sorted(group))
        unknown = ca.vertcat(*(system.unknown[system.slices[k]] for k in sorted(group)))
        rows = [i for i, used in enumerate(rows_of) if used & group]
        errors = [i for i, used in enumerate(errors_of) if used & group]
        blocks.append(
            replace(
                system,
                unknowns=unknowns,
                unknown=unknown,
                rows=system.rows[rows, 0],
                errors=system.errors[errors, 0],
            )
        )
    return tuple(blocks)


def constant_rows(system: System) -> System:
    """The rows that no unknown enters: conditions on the given values alone."""
    rows = [i for i, used in enumerate(incidence_of(system.rows, system)) if not used]
    errors = [i for i, used in enumerate(incidence_of(system.errors, system)) if not used]
    return replace(
        system,
        unknowns=(),
        unknown=ca.SX(0, 1),
        rows=system.rows[rows, 0],
        errors=system.errors[errors, 0],
    )


def incidence_of(rows: ca.SX, system: System) -> list[set[int]]:
    """For each row, the unknown coordinates that it contains."""
    pattern = np.asarray(ca.DM(ca.jacobian_sparsity(rows, system.unknown), 1)) != 0
    return [
        {k for k, place in enumerate(system.slices) if pattern[i, place].any()}
        for i in range(rows.shape[0])
    ]


def components(incidence: Sequence[set[int]], count: int) -> list[set[int]]:
    groups: list[set[int]] = [{k} for k in range(count)]
    for used in incidence:
        joined = [g for g in groups if g & used]
        if len(joined) > 1:
            groups = [g for g in groups if not g & used] + [set().union(*joined)]
    return sorted(groups, key=min)
