"""One configuration of a track."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symkin.closure.link_poses import link_poses
from symkin.computed_once import cached_property
from symkin.following.follow import PathPoint, Way
from symkin.following.machine_path import MachinePath
from symkin.model.joint import Coordinate
from symkin.numeric.linear_algebra import singular_values
from symkin.position.problem import Problem
from symkin.position.readings import points_at
from symkin.position.solution import Solution, in_units, named_values, pose_dict, pose_of
from symkin.position.solution_list import make_solution
from symkin.result import json_fields
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
            **json_fields(self, "parameter", "time"),
            "pose": pose_dict(self.pose) if self.has_platform else None,
            "joints": self.joints,
            **({"points": self.points} if self.points else {}),
            "residual": self.residual,
            "condition": self.condition if math.isfinite(self.condition) else None,
            **json_fields(self, "smallest_singular_value", "radius"),
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
    path: MachinePath,
    place: PathPoint,
    before: Sample | None,
    way: Way | None = None,
    values: np.ndarray | None = None,
) -> Sample:
    """One configuration of the path with its checks; what is told in its standard writing goes on
    from the one before, with what angles have turned along the `way` from there. `values` are the
    description's variables there, where they are known.
    """
    row, u, unknown = place.row, place.u, place.unknown
    written, followed = path.written.problem, path.trajectory.problem
    values = np.array(path.told([place])[0] if values is None else values)
    read = {name: part[0] for name, part in path.read(values[None]).items()}
    if before is not None:
        read = _continued(path, read, before, _turned(path, row, way))
    for name in [name for name in read if name in written.closure.slices]:
        values[written.closure.slices[name]] = read.pop(name)
    pose = pose_of(written.closure, values)
    if before is not None and np.dot(pose.quaternion, before.pose.quaternion) < 0.0:
        pose = Pose(pose.position, -np.asarray(pose.quaternion))
    known = path.trajectory.at(row, u)
    singular = singular_values(followed.system.linearise_one(unknown, known)[1])
    return Sample(
        problem=written,
        parameter=path.written.parameter(row, u),
        time=path.written.time(row, u),
        values=values,
        pose=pose,
        residual=written.system.residual(
            written.select_values(values, written.system.unknowns), path.written.at(row, u)
        ),
        condition=followed.system.condition(unknown, known),
        smallest_singular_value=float(singular[-1]) if singular.size else 1.0,
        radius=place.radius,
        readings=read,
    )


def _continued(
    path: MachinePath, read: dict[str, np.ndarray], before: Sample, turned: dict[str, float]
) -> dict[str, np.ndarray]:
    """Coordinates that what is followed leaves out, as near as possible to those before and what
    they have turned since.
    """
    slices, found = before.problem.closure.slices, dict(read)
    for c in path.rewritten:
        here = read[c.name]
        last = before.values[slices[c.name]] if c.name in slices else before.readings[c.name]
        if c.is_rotation:
            found[c.name] = here if here @ last >= 0.0 else -here
        elif c.is_periodic:
            near = last + turned.get(c.name, 0.0)
            found[c.name] = near + np.array([math.remainder(v, 2 * math.pi) for v in here - near])
    return found


def _turned(path: MachinePath, row: int, way: Way | None) -> dict[str, float]:
    """What angles that what is followed leaves out turn by along a way."""
    angles = [c.name for c in path.rewritten if c.is_periodic]
    if way is None or not angles:
        return {}
    found = dict.fromkeys(angles, 0.0)
    for ends, times in ((way.turn, way.times), (way.rest, 1)):
        if len(ends) > 1 and times:
            places = [PathPoint(row, u, unknown, None) for u, unknown in ends]
            read = path.read(path.told(places))
            for name in angles:
                steps = np.diff(read[name][:, 0])
                found[name] += times * float(
                    np.sum(steps - 2 * math.pi * np.round(steps / (2 * math.pi)))
                )
    return found
