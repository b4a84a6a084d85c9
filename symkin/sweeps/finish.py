"""From values of all variables to modes: canonical, verified on all rows, in the order of `symkin.modes`."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.caching import cached_property
from symkin.model.joint import Coordinate
from symkin.numeric.mapped import Mapped
from symkin.position.given import pose_from
from symkin.position.problem import Problem
from symkin.position.solution import canonical
from symkin.sweeps.found import COMPLETENESS, Found

_SLACK = 1e-9
"""What a joint may lie beyond its limits (rad, or of the size) by rounding."""
_NO_SIGN = 1e-12
"""Components of a quaternion below this do not decide its sign."""


@dataclass(frozen=True, eq=False)
class Finisher:
    """What is prepared once for all modes of a problem."""

    problem: Problem

    @cached_property
    def _pose(self) -> Mapped:
        closure = self.problem.closure
        return Mapped.of([closure.variables], [closure.bound(ca.vertcat(closure.pose.position, closure.pose.quaternion))])

    def finish(self, values: np.ndarray, owner: np.ndarray, points: int) -> Found:
        """Modes with values (m, variables) that belong to `points` points; `owner` (m,) rises."""
        closure = self.problem.closure
        values = np.array([canonical(closure, v) for v in values]).reshape(values.shape)
        position, quaternion = self._poses(values)
        order = np.lexsort((*self._sort_keys(values, position, quaternion), owner))
        values, position, quaternion = values[order], position[order], quaternion[order]
        unknown, known = self._take(values, self.problem.system.unknowns), self._take(values, self.problem.known_coordinates)
        none = np.full(len(values), -1)
        return Found(
            np.bincount(owner, minlength=points),
            np.full(points, COMPLETENESS.index("probability one")),
            np.zeros(points, dtype=int),
            np.zeros(points, dtype=bool),
            position,
            quaternion,
            self._joints(values),
            self.problem.system.residuals(unknown, known),
            self.problem.system.conditions(unknown, known),
            self._within_limits(values),
            none,
            np.full(len(values), np.nan),
            values,
        )

    def _poses(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (m, 3) and unit quaternions (m, 4) with w >= 0."""
        packed = self._pose(values)[0][:, :, 0]
        q = packed[:, 3:] / np.linalg.norm(packed[:, 3:], axis=1, keepdims=True)
        leading = np.argmax(np.abs(q) > _NO_SIGN, axis=1)
        sign = np.where(q[np.arange(len(q)), leading] < 0, -1.0, 1.0)
        return packed[:, :3], q * sign[:, None] + 0.0

    def _sort_keys(self, values: np.ndarray, position: np.ndarray, quaternion: np.ndarray) -> list[np.ndarray]:
        """Last key first, as `numpy.lexsort` takes them: nearness to the example's start or the reference, |R - R0|^2 =
        8 (1 - (q.q0)^2) beside the position's, then values."""
        mechanism = self.problem.mechanism
        reference, example = mechanism.reference_pose, mechanism.example
        if self.problem.kind == "direct" and example is not None and example.start is not None and example.joints is not None:
            reference = pose_from(example.start)
        turn = 8.0 * (1.0 - np.sum(quaternion * np.asarray(reference.quaternion), axis=1) ** 2)
        away = np.linalg.norm(position - np.asarray(reference.position), axis=1) / self.problem.closure.size
        columns = [self.problem.closure.slices[c.name] for c in self.problem.closure.coordinates]
        flat = [np.round(values[:, i], 6) for place in columns for i in range(place.start, place.stop)]
        return [*reversed(flat), np.round(turn + away**2, 6)]

    def _take(self, values: np.ndarray, coordinates: tuple[Coordinate, ...]) -> np.ndarray:
        parts = [values[:, self.problem.closure.slices[c.name]] for c in coordinates]
        return np.concatenate([values[:, :0], *parts], axis=1)

    def _joints(self, values: np.ndarray) -> np.ndarray:
        """Joint coordinates (m, numbers) in the mechanism's units."""
        closure = self.problem.closure
        columns = [values[:, :0]]
        for c in closure.coordinates:
            if c.role != "pose":
                part = values[:, closure.slices[c.name]]
                columns.append(part * closure.mechanism.angle_out(1.0) if c.is_angular else part)
        return np.concatenate(columns, axis=1)

    def _within_limits(self, values: np.ndarray) -> np.ndarray:
        closure = self.problem.closure
        limited = [(c, c.limits) for c in closure.coordinates if c.limits is not None]
        if not limited:
            return np.full(len(values), -1)
        inside = np.ones(len(values), dtype=bool)
        for c, (low, high) in limited:
            slack, value = _SLACK * (1.0 if c.is_angular else closure.size), values[:, closure.slices[c.name]][:, 0]
            inside &= (low - slack <= value) & (value <= high + slack)
        return inside.astype(int)
