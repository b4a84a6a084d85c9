"""One configuration of a track."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symkin.closure.link_poses import link_poses
from symkin.computed_once import cached_property
from symkin.following.follow import PathPoint, Way
from symkin.following.trajectory import Trajectory
from symkin.model.joint import Coordinate
from symkin.numeric.linear_algebra import singular_values
from symkin.position.problem import Problem
from symkin.position.readings import left_out, points_at, readings_at
from symkin.position.solution import Solution, in_units, named_values, pose_dict, pose_of
from symkin.position.solution_list import make_solution
from symkin.spatial.pose import Pose


@dataclass(frozen=True, eq=False)
class Sample:
    """One configuration of the path. `values` are all variables of the closure, angles and
    quaternions continuing those before, `readings` the coordinates of joints that a closure of
    coordinates by name leaves out; `parameter` runs from 0 to 1; `smallest_singular_value` is that
    of the unknowns' Jacobian (angles times the size), zero at a singularity; `radius` (length unit)
    is proved to hold the one exact solution, None where it is not.
    """

    problem: Problem
    parameter: float
    time: float | None
    values: np.ndarray
    pose: Pose
    residual: float
    condition: float
    smallest_singular_value: float
    radius: float | None
    readings: dict[str, np.ndarray] = field(default_factory=dict)

    @cached_property
    def joints(self) -> dict[str, Any]:
        """Joint coordinates in the mechanism's units, passive ones included; where values are told
        by name, those of all joints.
        """
        values = named_values(self.problem.closure, self.values)
        values |= {name: v if len(v) > 1 else float(v[0]) for name, v in self.readings.items()}
        names = [c.name for c in listed_joints(self.problem)]
        return in_units(self.problem.mechanism, names, values)

    @cached_property
    def points(self) -> dict[str, list[float]]:
        """Where the named points of links are, in the base frame."""
        mechanism, closure = self.problem.mechanism, self.problem.closure
        if not mechanism.link_points:
            return {}
        there = points_at(mechanism, link_poses(closure, self.values[None]))
        return {name: point[0].tolist() for name, point in there.items()}

    @property
    def has_platform(self) -> bool:
        """Whether `pose` is that of a link."""
        return self.problem.mechanism.platform_link is not None

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
            "pose": pose_dict(self.pose) if self.has_platform else None,
            "joints": self.joints,
            **({"points": self.points} if self.points else {}),
            "residual": self.residual,
            "condition": self.condition if math.isfinite(self.condition) else None,
            "smallest_singular_value": self.smallest_singular_value,
            "radius": self.radius,
        }


def listed_joints(problem: Problem) -> tuple[Coordinate, ...]:
    """The joint coordinates of samples: of all joints in file order where values are told by name,
    else those of the closure.
    """
    return (
        problem.mechanism.coordinates
        if problem.by_name
        else problem.closure.role("actuated", "passive")
    )


def make_sample(
    trajectory: Trajectory,
    problem: Problem,
    place: PathPoint,
    before: Sample | None,
    way: Way | None = None,
    read: dict[str, np.ndarray] | None = None,
) -> Sample:
    """One configuration of the path with its checks; its quaternion continues the one before,
    and what angles of joints that the closure leaves out have turned is counted along the
    `way` from there. `read` are the coordinates of joints there, where they are known."""
    row, u, unknown = place.row, place.u, place.unknown
    if read is None:
        (read,) = places_read(trajectory, problem, [place])
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
        readings=_continued(problem, read, before, _turned(trajectory, problem, row, way))
        if problem.by_name
        else {},
    )


def places_read(
    trajectory: Trajectory, problem: Problem, places: Sequence[PathPoint]
) -> list[dict[str, np.ndarray]]:
    """The coordinates of joints at several places, read together; nothing where the closure has
    all that are told."""
    if not problem.by_name:
        return [{} for _ in places]
    values = [problem.join_values(p.unknown, trajectory.at(p.row, p.u)) for p in places]
    read = readings_at(problem.closure, np.array(values))
    return [{name: part[k] for name, part in read.items()} for k in range(len(places))]


def _continued(
    problem: Problem,
    read: dict[str, np.ndarray],
    before: Sample | None,
    turned: dict[str, float],
) -> dict[str, np.ndarray]:
    """Coordinates of joints that the closure leaves out, as near as possible to those before and
    what they have turned since."""
    read = dict(read)
    for c in left_out(problem.closure) if before is not None else ():
        last = before.readings[c.name]  # type: ignore[union-attr]
        if c.is_rotation:
            read[c.name] = read[c.name] if read[c.name] @ last >= 0.0 else -read[c.name]
        elif c.is_periodic:
            near = last + turned.get(c.name, 0.0)
            read[c.name] = near + np.array(
                [math.remainder(v, 2 * math.pi) for v in read[c.name] - near]
            )
    return read


def _turned(
    trajectory: Trajectory, problem: Problem, row: int, way: Way | None
) -> dict[str, float]:
    """What angles of joints that the closure leaves out turn by along a way."""
    angles = [c.name for c in left_out(problem.closure) if c.is_periodic]
    if way is None or not angles:
        return {}
    found = dict.fromkeys(angles, 0.0)
    for ends, times in ((way.turn, way.times), (way.rest, 1)):
        if len(ends) > 1 and times:
            values = np.array(
                [problem.join_values(unknown, trajectory.at(row, u)) for u, unknown in ends]
            )
            read = readings_at(problem.closure, values)
            for name in angles:
                steps = np.diff(read[name][:, 0])
                found[name] += times * float(
                    np.sum(steps - 2 * math.pi * np.round(steps / (2 * math.pi)))
                )
    return found
