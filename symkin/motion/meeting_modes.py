"""Which modes meet at a singular point of a branch, by the complete enumeration a little before it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.enumeration.modes import modes
from symkin.errors import SymkinError
from symkin.model.joint import Coordinate
from symkin.motion.path_system import PathSystem, coefficients
from symkin.motion.trajectory import Trajectory
from symkin.motion.turning_point import SingularPoint
from symkin.position.problem import build_problem
from symkin.position.solution import Completeness, Modes, pose_of
from symkin.spatial.pose import Pose

_BEFORE = 1e-4
"""Modes are enumerated this far before the singular point (share of an interval), or half way to its beginning."""
_SAME = 1e-5
"""Two writings of one configuration differ by less than this (lengths over the size, rotations by their matrices)."""
_FEW_TIMES = 20.0
"""At a bifurcation the modes nearer to the singular point than this times the followed one's distance are said to meet."""


@dataclass(frozen=True)
class Meeting:
    """Numbers (from 1) of modes in the list that `modes` gives at `given` (joints or pose in the mechanism's units, at
    `parameter` of the path): the followed one, None where the list lacks it, and those that meet it. `count` is the length
    of the list and `completeness` what it is worth."""

    parameter: float
    given: dict[str, list[float]]
    own: int | None
    others: tuple[int, ...]
    count: int
    completeness: Completeness

    def to_json(self) -> dict[str, Any]:
        return {
            "parameter": self.parameter, "given": self.given, "own": self.own, "others": list(self.others),
            "modes": self.count, "completeness": self.completeness,
        }  # fmt: skip


def meeting_modes(
    system: PathSystem, trajectory: Trajectory, row: int, point: SingularPoint, along: np.ndarray, seed: int = 0
) -> Meeting | None:
    """The modes that meet at a singular point on interval `row`; `along` leads from it back to a point of the branch (w,).
    None where nothing lies before it or the enumeration refuses."""
    if point.u <= 0.0:
        return None
    back = min(_BEFORE, 0.5 * point.u)
    u = point.u - back
    c = coefficients(system.problem, trajectory.samples[row], trajectory.samples[row + 1])
    given = user_values(trajectory, trajectory.at(row, u))
    try:
        found = modes(trajectory.mechanism, seed=seed, **given)  # type: ignore[arg-type]
    except SymkinError:
        return None
    if point.kind == "turning point":
        reach = math.sqrt(2.0 * back / abs(point.curvature))
        v = point.null[:, 0] * (1.0 if point.null[:, 0] @ along > 0 else -1.0)
        own, mate = (_number(system, found, system.correct(point.y[:-1] + s * reach * v, u, c)[0]) for s in (1.0, -1.0))
        others = tuple(k for k in (mate,) if k is not None and k != own)
    else:
        length = back * float(np.linalg.norm(along))
        own = _number(system, found, system.correct(point.y[:-1] + back * along, u, c)[0])
        near = [k for k, d in enumerate(_distances(system, found, point.y[:-1]), start=1) if d < _FEW_TIMES * length + _SAME]
        others = tuple(k for k in near if k != own)
    return Meeting(trajectory.parameter(row, u), given, own, others, len(found), found.completeness)


def user_values(trajectory: Trajectory, known: np.ndarray) -> dict[str, list[float]]:
    """Known values as `modes` takes them: joints in the mechanism's units, or a pose."""
    mechanism = trajectory.mechanism
    if trajectory.kind == "direct":
        pairs = zip(trajectory.coordinates, known.tolist(), strict=True)
        return {"joints": [mechanism.angle_out(v) if c.is_angular else v for c, v in pairs]}
    pose = known_pose(trajectory, known)
    return {"pose": [*np.asarray(pose.position).tolist(), *np.asarray(pose.quaternion).tolist()]}


def known_pose(trajectory: Trajectory, known: np.ndarray) -> Pose:
    """The pose that the known coordinates of an inverse problem make."""
    problem = build_problem(trajectory.mechanism, "inverse")
    return pose_of(problem.closure, problem.assemble(problem.take(problem.closure.reference, problem.system.unknowns), known))


def _number(system: PathSystem, found: Modes, z: np.ndarray) -> int | None:
    distances = _distances(system, found, z)
    if not len(distances) or not np.min(distances) < _SAME:
        return None
    return int(np.argmin(distances)) + 1


def _distances(system: PathSystem, found: Modes, z: np.ndarray) -> np.ndarray:
    """Largest difference of each mode from z in the features of its unknowns."""
    unknowns, size = system.problem.system.unknowns, system.problem.closure.size
    own = np.concatenate(
        [_feature(c, (z * system.scale)[p], size) for c, p in zip(unknowns, system.problem.system.slices, strict=True)]
    )
    listed = [np.concatenate([_feature(c, np.atleast_1d(mode.values[c.name]), size) for c in unknowns]) for mode in found]
    return np.array([float(np.max(np.abs(other - own))) for other in listed])


def _feature(c: Coordinate, value: np.ndarray, size: float) -> np.ndarray:
    """Numbers that two writings of one value share: of an angle its cosine and sine, of a unit quaternion its products."""
    if c.kind == "quaternion":
        return np.outer(value, value)[np.triu_indices(4)]
    if c.kind == "angle":
        return np.array([math.cos(value[0]), math.sin(value[0])])
    return value / (1.0 if c.is_angular else size)
