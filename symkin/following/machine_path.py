"""A path as it is followed: that of the machine which its description means, whose configurations
are told in the description's coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.assembly.as_written import machine_of
from symkin.closure.closure import Closure
from symkin.computed_once import cached_property
from symkin.following.follow import PathPoint
from symkin.following.trajectory import Trajectory, continued, path_problem
from symkin.machine.lower import Lowered
from symkin.model.joint import Coordinate
from symkin.position.given import Given, in_order
from symkin.position.pose_coordinates import ON_MOTION, pose_coordinates
from symkin.position.problem import Problem, pose_names
from symkin.position.readings import left_out, readings_at
from symkin.position.transfer import (
    in_standard_writing,
    many_as_written,
    many_of_machine,
)
from symkin.spatial.pose import Pose


@dataclass(frozen=True, eq=False)
class MachinePath:
    """A path as it is `written`, and as its machine (None: the description itself) takes it,
    `trajectory`.
    """

    written: Trajectory
    trajectory: Trajectory
    low: Lowered | None = None

    def unknowns(self, own: Closure, values: np.ndarray) -> np.ndarray:
        """The followed unknowns (n, w) at configurations (n, own variables) of a closure of the
        description.
        """
        problem = self.trajectory.problem
        told = many_of_machine(problem.closure, own, values, self.low)
        return problem.select_values(told, problem.system.unknowns)

    def told(self, places: Sequence[PathPoint]) -> np.ndarray:
        """The variables (n, variables) of the description's closure at places of the path."""
        problem, at = self.trajectory.problem, self.trajectory.at
        known = np.array([at(place.row, place.u) for place in places])
        values = problem.join_values(np.array([place.unknown for place in places]), known)
        if self.low is None:
            return values
        written = self.written.problem
        found = many_as_written(written.closure, problem.closure, values, self.low)
        found = in_standard_writing(written.closure, problem.closure, found)
        found[:, written.known_places] = [self.written.at(place.row, place.u) for place in places]
        return found

    def read(self, values: np.ndarray) -> dict[str, np.ndarray]:
        """Of what the description tells at its variables (n, variables) that whose angles are in
        their standard writing, since what is followed does not hold it.
        """
        closure = self.written.problem.closure
        found = {c.name: values[:, closure.slices[c.name]] for c in self._changed}
        return found | (readings_at(closure, values) if self.written.problem.by_name else {})

    @cached_property
    def rewritten(self) -> tuple[Coordinate, ...]:
        """The coordinates that `read` reads."""
        problem = self.written.problem
        return (*self._changed, *(left_out(problem.closure) if problem.by_name else ()))

    @cached_property
    def _changed(self) -> tuple[Coordinate, ...]:
        """Unknowns of the description that the machine's closure does not hold as they are."""
        if self.low is None:
            return ()
        held = {c.name for c in self.trajectory.problem.closure.coordinates if c.role != "pose"}
        return tuple(c for c in self.written.problem.system.unknowns if c.name not in held)


def machine_path(trajectory: Trajectory) -> MachinePath:
    """The path of a description's machine, where that is another one and takes all of its poses."""
    mechanism, names = trajectory.mechanism, tuple(c.name for c in trajectory.coordinates)
    first, of_pose = Given(names, trajectory.samples[0], {}), names == pose_names(mechanism)
    is_mixed = not of_pose and any(c.role == "pose" for c in trajectory.coordinates)
    low = None if is_mixed else machine_of(mechanism, first.names, frozenset(trajectory.limited))
    if low is None:
        return MachinePath(trajectory, trajectory)
    known = pose_names(low.machine) if of_pose else in_order(low.machine, first).names
    problem = path_problem(low.machine, known, trajectory.limited)
    if of_pose:
        samples = _poses(low, problem, trajectory.samples)
    else:
        samples = trajectory.samples[:, [names.index(name) for name in known]]
    if samples is None:
        return MachinePath(trajectory, trajectory)
    return MachinePath(trajectory, replace(trajectory, problem=problem, samples=samples), low)


def _poses(low: Lowered, problem: Problem, samples: np.ndarray) -> np.ndarray | None:
    """Poses of the description as the machine has them; None where some are off its motion."""
    if low.frames is None and low.machine.motion == low.written.motion:
        return samples
    found = list[np.ndarray]()
    for v in samples:
        values, off = pose_coordinates(low.machine, low.taken(Pose(v[:3], v[3:])))
        if off > ON_MOTION * low.machine.characteristic_length:
            return None
        found.append(continued(problem.known_coordinates, found[-1], values) if found else values)
    return np.array(found)
