"""Which modes meet at a singular point of a branch, by the complete enumeration a little before it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from symkin.assembly.mode_list import Completeness, Modes
from symkin.assembly.modes import modes_at_need
from symkin.errors import SymkinError
from symkin.following.block_follower import BlockFollower
from symkin.following.follow import Branch
from symkin.following.path_system import PathSystem
from symkin.following.singular_point import SingularPoint
from symkin.following.trajectory import Trajectory
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import pose_of
from symkin.spatial.pose import Pose

_BEFORE = 1e-4
"""Modes are enumerated this far before the singular point (share of an interval), or half way to its beginning."""
_SAME = 1e-5
"""Two writings of one configuration differ by less than this (lengths over the size, rotations by their matrices)."""
_FEW_TIMES = 20.0
"""At a bifurcation the modes nearer to the singular point than this times the followed one's distance are said to meet."""
_MOST_TURNING = 8
"""Blocks that turn together of which all combinations are looked for."""


@dataclass(frozen=True)
class Meeting:
    """Numbers (from 1) of modes in the list that `modes` gives at `given` (joints or pose in the mechanism's units, at
    `parameter` of the path): the followed one, None where the list lacks it, and those that meet it. `count` is the length
    of the list and `completeness` what it is worth. `opposite_signs`: whether the determinants of the followed rows (of each
    block that turns) have opposite signs on the two sides of the turning point; None where rows are redundant, or elsewhere."""

    parameter: float
    given: dict[str, list[float]]
    own: int | None
    others: tuple[int, ...]
    count: int
    completeness: Completeness
    opposite_signs: bool | None = None

    def to_dict(self) -> dict[str, Any]:
        """The meeting in the JSON of `symkin track`."""
        return {
            "parameter": self.parameter,
            "given": self.given,
            "own": self.own,
            "others": list(self.others),
            "modes": self.count,
            "completeness": self.completeness,
            "opposite_signs": self.opposite_signs,
        }

    def __str__(self) -> str:
        """Which modes meet, in words."""
        own = "the mode followed" if self.own is None else f"mode {self.own}"
        listed = f"of the {self.count} that `modes` lists at {self.parameter:.9g} of the path ({self.completeness})"
        if not self.others:
            return f"{own} {listed} was followed, and no other one is listed near it"
        *most, last = (str(k) for k in self.others)
        if most:
            return f"{own} {listed} meets modes {', '.join(most)} and {last}"
        signs = {True: ", with determinants of opposite sign", False: ", with determinants of one sign", None: ""}
        return f"{own} {listed} meets mode {last}{signs[self.opposite_signs]}"


def meeting_modes(problem: Problem, trajectory: Trajectory, branch: Branch, seed: int = 0) -> Meeting | None:
    """The modes that meet where a branch ends at a singular point. None where nothing lies before it or the enumeration
    refuses."""
    row, u = branch.last.row, branch.last.u
    back = min(_BEFORE, 0.5 * u)
    if back <= 0.0:
        return None
    given = user_values(trajectory, trajectory.at(row, u - back))
    try:
        found = modes_at_need(trajectory.mechanism, seed=seed, **given)  # type: ignore[arg-type]
    except SymkinError:
        return None
    turning = [w for w in branch.stopped if _turns(w)]
    sides = {id(w): _sides(w, u - back) for w in turning}
    signs = None
    if len(turning) < len(branch.stopped) or len(turning) > _MOST_TURNING:
        own_unknown = _together(problem, branch.blocks, {id(w): w.at(u - back) for w in branch.blocks})
        reach = _FEW_TIMES * _apart(problem, own_unknown, branch.last.unknown) + _SAME
        own = _number(problem, found, own_unknown)
        near = [k for k, d in enumerate(_distances(problem, found, branch.last.unknown), start=1) if d < reach]
    else:
        rest = {id(w): w.at(u - back) for w in branch.blocks if w not in turning}
        near, own = [], None
        for sign in product((0, 1), repeat=len(turning)):
            chosen = {id(w): sides[id(w)][k] for w, k in zip(turning, sign, strict=True)}
            number = _number(problem, found, _together(problem, branch.blocks, rest | chosen))
            near += [] if number is None else [number]
            own = own if any(sign) else number
        signs = _opposite(turning, sides, u - back)
    others = tuple(sorted({k for k in near if k != own}))
    return Meeting(trajectory.parameter(row, u - back), given, own, others, len(found), found.completeness, signs)


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
    return pose_of(
        problem.closure, problem.join_values(problem.select_values(problem.closure.reference, problem.system.unknowns), known)
    )


def _turns(block: BlockFollower) -> bool:
    return block.stop is not None and block.stop.singular is not None and block.stop.singular.kind == "turning point"


def _sides(block: BlockFollower, u: float) -> tuple[np.ndarray, np.ndarray]:
    """z of a turning block at a u before its turning point: on the followed side, and on the other one."""
    point: SingularPoint = block.stop.singular  # type: ignore[assignment, union-attr]
    reach = math.sqrt(2.0 * (point.u - u) / abs(point.curvature))
    v = point.null[:, 0] * (1.0 if point.null[:, 0] @ (block.station.z - point.y[:-1]) > 0 else -1.0)
    own, mate = (block.system.correct(point.y[:-1] + s * reach * v, u, block.interval.c)[0] for s in (1.0, -1.0))
    return own, mate


def _opposite(turning: list[BlockFollower], sides: dict[int, tuple[np.ndarray, np.ndarray]], u: float) -> bool | None:
    """Whether det dG/dz has opposite signs on the two sides, in each block that turns; None where rows are redundant."""
    if not all(block.system.is_square for block in turning):
        return None
    return all(_sign(w.system, sides[id(w)][0], u, w) * _sign(w.system, sides[id(w)][1], u, w) < 0 for w in turning)


def _sign(system: PathSystem, z: np.ndarray, u: float, block: BlockFollower) -> float:
    return float(np.linalg.slogdet(system.evaluate(np.append(z, u), block.interval.c)[1][:, :-1])[0])


def _together(problem: Problem, blocks: tuple[BlockFollower, ...], z: dict[int, np.ndarray]) -> np.ndarray:
    """The unknowns (in radians and the length unit) that the blocks' z make."""
    unknown = np.empty(problem.system.width)
    for block in blocks:
        unknown[block.system.places] = block.system.unknown(z[id(block)])
    return unknown


def _number(problem: Problem, found: Modes, unknown: np.ndarray) -> int | None:
    distances = _distances(problem, found, unknown)
    if not len(distances) or not np.min(distances) < _SAME:
        return None
    return int(np.argmin(distances)) + 1


def _distances(problem: Problem, found: Modes, unknown: np.ndarray) -> np.ndarray:
    """Largest difference of each mode from a configuration in the features of its unknowns."""
    unknowns = problem.system.unknowns
    listed = [np.concatenate([np.atleast_1d(mode.values[c.name]) for c in unknowns]) for mode in found]
    return np.array([_apart(problem, other, unknown) for other in listed])


def _apart(problem: Problem, a: np.ndarray, b: np.ndarray) -> float:
    pairs = list(zip(problem.system.unknowns, problem.system.slices, strict=True))
    one, two = (np.concatenate([_feature(c, x[place], problem.closure.size) for c, place in pairs]) for x in (a, b))
    return float(np.max(np.abs(one - two)))


def _feature(c: Coordinate, value: np.ndarray, size: float) -> np.ndarray:
    """Numbers that two writings of one value share: of an angle its cosine and sine, of a unit quaternion its products."""
    if c.kind == "quaternion":
        return np.outer(value, value)[np.triu_indices(4)]
    if c.kind == "angle":
        return np.array([math.cos(value[0]), math.sin(value[0])])
    return value / (1.0 if c.is_angular else size)
