"""A square or rectangular system of closure rows in unknown coordinates, with batched evaluation.

Steps are taken in the tangent space: d = (lengths; size * angles; size * rotation vector in the base frame for each
quaternion), all in the length unit, so that columns are comparable and unit quaternions stay unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.caching import cached_property
from symkin.model.joint import Coordinate
from symkin.spatial.rotation import multiply

_LANES = 128
"""Starts that one mapped call evaluates; larger batches are cut into calls of this width."""
NO_MOTION = 1e-13
"""Singular value (rows per motion, both lengths) below which unknowns do not move the rows; joints that matter give 1e-6 and
more, rounding of a pose's numbers 1e-16."""


@dataclass(frozen=True, eq=False)
class System:
    """Rows F(z; k) of the unknown coordinates z given known values k, geometry bound.

    `errors` are the full checks of the same constraints in the length unit.
    """

    unknowns: tuple[Coordinate, ...]
    unknown: ca.SX
    known: ca.SX
    rows: ca.SX
    errors: ca.SX
    size: float

    @property
    def width(self) -> int:
        """Numbers that hold the unknowns."""
        return int(self.unknown.shape[0])

    @property
    def freedom(self) -> int:
        """Dimension of the tangent space of the unknowns."""
        return sum(c.freedom for c in self.unknowns)

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        ends = np.cumsum([c.width for c in self.unknowns]).tolist()
        return tuple(slice(end - c.width, end) for c, end in zip(self.unknowns, ends, strict=True))

    @cached_property
    def tangent(self) -> ca.SX:
        """dz/dd, width x freedom: columns 1, 1/size, and half the quaternion product with a unit vector / size."""
        basis = ca.SX(self.width, self.freedom)
        column = 0
        for coordinate, place in zip(self.unknowns, self.slices, strict=True):
            if coordinate.kind == "quaternion":
                q = self.unknown[place]
                for k in range(3):
                    direction = [0.0, 0.0, 0.0, 0.0]
                    direction[k + 1] = 0.5 / self.size
                    basis[place, column + k] = multiply(direction, q)
            else:
                basis[place.start, column] = 1 / self.size if coordinate.is_angular else 1.0
            column += coordinate.freedom
        return basis

    @cached_property
    def jacobian(self) -> ca.SX:
        """dF/dd, rows x freedom; dimensionless."""
        return ca.mtimes(ca.jacobian(self.rows, self.unknown), self.tangent)

    @cached_property
    def _linearised(self) -> ca.Function:
        outputs = [ca.densify(self.rows), ca.densify(self.jacobian)]
        return ca.Function("linearised", [self.unknown, self.known], outputs, {"cse": True})

    @cached_property
    def _checked(self) -> ca.Function:
        return ca.Function("checked", [self.unknown, self.known], [ca.densify(self.errors)], {"cse": True})

    @cached_property
    def _mapped(self) -> ca.Function:
        return self._linearised.map(_LANES)

    def linearise(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F (n, rows) and dF/dd (n, rows, freedom) at the n points z (n, width), by one mapped CasADi function."""
        count, m = z.shape[0], int(self.rows.shape[0])
        values, jacobians = np.empty((count, m)), np.empty((count, m, self.freedom))
        tiled = np.tile(known, _LANES)
        buffer, evaluate = self._mapped.buffer()
        points, out_f = np.zeros((_LANES, self.width)), np.zeros((_LANES, m))
        out_j = np.zeros((_LANES, self.freedom, m))
        buffer.set_arg(0, points.reshape(-1).data)
        buffer.set_arg(1, tiled.data)
        buffer.set_res(0, out_f.reshape(-1).data)
        buffer.set_res(1, out_j.reshape(-1).data)
        for begin in range(0, count, _LANES):
            part = z[begin : begin + _LANES]
            points[: len(part)] = part
            evaluate()
            values[begin : begin + _LANES] = out_f[: len(part)]
            jacobians[begin : begin + _LANES] = out_j[: len(part)].transpose(0, 2, 1)
        return values, jacobians

    def residual(self, z: np.ndarray, known: np.ndarray) -> float:
        """Largest closure error at one point, in the length unit, over all constraints and whole rotations."""
        return float(np.max(np.abs(np.asarray(self._checked(z, known))), initial=0.0))

    def linearise_one(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F (rows,) and dF/dd (rows, freedom) at one point."""
        values, jacobian = self._linearised(z, known)
        return np.asarray(values).ravel(), np.asarray(jacobian)

    def move(self, z: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Retraction: add tangent steps (n, freedom) to points (n, width); quaternions are turned and normalised. In few
        array operations, since it is called for one point at a time too."""
        plain, columns, units, turns = self._retraction
        moved = z.copy()
        moved[:, plain] += step[:, columns] / units
        for place, column in turns:
            w, x, y, t = z[:, place].T
            a, b, c = (0.5 / self.size) * step[:, column : column + 3].T
            q = np.array(
                [w - a * x - b * y - c * t, x + a * w + b * t - c * y, y - a * t + b * w + c * x, t + a * y - b * x + c * w]
            )
            moved[:, place] = (q / np.sqrt(np.sum(q * q, axis=0))).T
        return moved

    @cached_property
    def _retraction(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[tuple[slice, int]]]:
        """Entries and tangent columns of single numbers, and tangent lengths that make one; (entries, first column) of
        quaternions."""
        plain, columns, units, turns, column = [], [], [], [], 0
        for c, place in zip(self.unknowns, self.slices, strict=True):
            if c.kind == "quaternion":
                turns.append((place, column))
            else:
                plain.append(place.start)
                columns.append(column)
                units.append(self.size if c.is_angular else 1.0)
            column += c.freedom
        return np.array(plain, dtype=int), np.array(columns, dtype=int), np.array(units), turns

    def unit(self, z: np.ndarray) -> np.ndarray:
        """The same point with quaternions of unit length."""
        return np.asarray(self.move(z[None], np.zeros((1, self.freedom)))[0])

    def fold(self, points: np.ndarray) -> np.ndarray:
        """The same configurations with rod lengths that are not negative."""
        folded = points.copy()
        for coordinate, place in zip(self.unknowns, self.slices, strict=True):
            if coordinate.least is not None:
                folded[:, place] = coordinate.least + np.abs(points[:, place] - coordinate.least)
        return folded

    def wrap(self, points: np.ndarray) -> np.ndarray:
        """The same configurations with angles within half a turn of zero: after 1e7 turns a sine has nine digits left."""
        wrapped = points.copy()
        for coordinate, place in zip(self.unknowns, self.slices, strict=True):
            if coordinate.kind == "angle":
                wrapped[..., place] -= 2.0 * np.pi * np.round(wrapped[..., place] / (2.0 * np.pi))
        return wrapped

    def condition(self, z: np.ndarray, known: np.ndarray) -> float:
        """Largest over smallest of the min(rows, freedom) singular values of dF/dd; infinite at a singularity."""
        _, jacobian = self.linearise_one(z, known)
        if not np.all(np.isfinite(jacobian)) or min(jacobian.shape) == 0:
            return float("inf") if jacobian.size else 1.0
        singular = np.linalg.svd(jacobian, compute_uv=False)
        smallest = singular[-1]
        return float(singular[0] / smallest) if smallest > max(1e-15 * singular[0], NO_MOTION) else float("inf")

    def polish(self, z: np.ndarray, known: np.ndarray, steps: int = 4) -> np.ndarray:
        """Gauss-Newton by least squares on all rows until the step no longer shrinks the rows."""
        values, jacobian = self.linearise_one(z, known)
        for _ in range(steps):
            if not np.all(np.isfinite(jacobian)):
                return z
            step = np.linalg.lstsq(jacobian, -values, rcond=1e-13)[0]
            trial = self.move(z[None], step[None])[0]
            trial_values, trial_jacobian = self.linearise_one(trial, known)
            if not np.linalg.norm(trial_values) < np.linalg.norm(values):
                return z
            z, values, jacobian = trial, trial_values, trial_jacobian
        return z


def split_blocks(system: System, together: Sequence[set[int]] = ()) -> tuple[System, ...]:
    """Independent parts: the connected components of the graph of rows and unknown coordinates, with places of unknowns
    that stay `together`. A limb whose platform pose is given is one part; its branches are found alone and combined
    afterwards."""
    errors_of = _incidence(system.errors, system)
    rows_of = _incidence(system.rows, system)
    groups = components([*rows_of, *together], len(system.unknowns))
    blocks = []
    for group in groups:
        unknowns = tuple(system.unknowns[k] for k in sorted(group))
        unknown = ca.vertcat(*(system.unknown[system.slices[k]] for k in sorted(group)))
        rows = [i for i, used in enumerate(rows_of) if used & group]
        errors = [i for i, used in enumerate(errors_of) if used & group]
        blocks.append(System(unknowns, unknown, system.known, system.rows[rows, 0], system.errors[errors, 0], system.size))
    return tuple(blocks)


def constant_rows(system: System) -> System:
    """The rows that no unknown enters: conditions on the given values alone."""
    rows = [i for i, used in enumerate(_incidence(system.rows, system)) if not used]
    errors = [i for i, used in enumerate(_incidence(system.errors, system)) if not used]
    return System((), ca.SX(0, 1), system.known, system.rows[rows, 0], system.errors[errors, 0], system.size)


def _incidence(rows: ca.SX, system: System) -> list[set[int]]:
    """For each row, the unknown coordinates that it contains."""
    pattern = np.asarray(ca.DM(ca.jacobian_sparsity(rows, system.unknown), 1)) != 0
    return [{k for k, place in enumerate(system.slices) if pattern[i, place].any()} for i in range(int(rows.shape[0]))]


def components(incidence: Sequence[set[int]], count: int) -> list[set[int]]:
    groups: list[set[int]] = [{k} for k in range(count)]
    for used in incidence:
        joined = [g for g in groups if g & used]
        if len(joined) > 1:
            groups = [g for g in groups if not g & used] + [set().union(*joined)]
    return sorted(groups, key=min)
