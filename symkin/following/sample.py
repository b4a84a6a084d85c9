"""One configuration of a track."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.following.follow import PathPoint
from symkin.following.trajectory import Trajectory
from symkin.numeric.linear_algebra import singular_values
from symkin.position.problem import Problem
from symkin.position.solution import Solution, pose_of
from symkin.position.solution_list import make_solution
from symkin.spatial.pose import Pose


@dataclass(frozen=True, eq=False)
class Sample:
    """One configuration of the path. `values` are all variables of the closure, angles and quaternions continuing those
    before; `parameter` runs from 0 to 1; `smallest_singular_value` is that of the unknowns' Jacobian (angles times the
    size), zero at a singularity; `radius` (length unit) is proved to hold the one exact solution, None where it is not."""

    problem: Problem
    parameter: float
    time: float | None
    values: np.ndarray
    pose: Pose
    residual: float
    condition: float
    smallest_singular_value: float
    radius: float | None

    @cached_property
    def joints(self) -> dict[str, Any]:
        """Joint coordinates in the mechanism's units, passive ones included."""
        mechanism, closure = self.problem.mechanism, self.problem.closure
        out: dict[str, Any] = {}
        for c in closure.role("actuated", "passive"):
            part = self.values[closure.slices[c.name]]
            scalar = mechanism.angle_out(float(part[0])) if c.is_angular else float(part[0])
            out[c.name] = scalar if c.width == 1 else [float(v) for v in part]
        return out

    @property
    def solution(self) -> Solution:
        """The same configuration as `solve` gives it: angles within half a turn, no certificate."""
        return make_solution(self.problem, self.values)

    @property
    def actuated_values(self) -> list[float]:
        """Actuated joint values in file order and the mechanism's units."""
        return [self.joints[c.name] for c in self.problem.mechanism.actuated]

    @property
    def actuated(self) -> list[float]:
        """Deprecated name of `actuated_values`."""
        return self.actuated_values

    def to_dict(self) -> dict[str, Any]:
        """The sample in the JSON of `symkin track`; an infinite condition is None."""
        return {
            "parameter": self.parameter,
            "time": self.time,
            "pose": {
                "position": np.asarray(self.pose.position).tolist(),
                "quaternion": np.asarray(self.pose.quaternion).tolist(),
                "matrix": np.asarray(self.pose.rotation).tolist(),
            },
            "joints": self.joints,
            "residual": self.residual,
            "condition": self.condition if math.isfinite(self.condition) else None,
            "smallest_singular_value": self.smallest_singular_value,
            "radius": self.radius,
        }


def make_sample(trajectory: Trajectory, problem: Problem, place: PathPoint, before: Sample | None) -> Sample:
    """One configuration of the path with its checks; its quaternion continues the one before."""
    row, u, unknown = place.row, place.u, place.unknown
    known = trajectory.at(row, u)
    values = problem.join_values(unknown, known)
    pose = pose_of(problem.closure, values)
    if before is not None and np.dot(pose.quaternion, before.pose.quaternion) < 0.0:
        pose = Pose(pose.position, -np.asarray(pose.quaternion))
    singular = singular_values(problem.system.linearise_one(unknown, known)[1])
    return Sample(
        problem=problem,
        parameter=trajectory.parameter(row, u),
        time=trajectory.time(row, u),
        values=values,
        pose=pose,
        residual=problem.system.residual(unknown, known),
        condition=problem.system.condition(unknown, known),
        smallest_singular_value=float(singular[-1]) if singular.size else 1.0,
        radius=place.radius,
    )
