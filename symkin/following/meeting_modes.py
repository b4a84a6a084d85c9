"""Name the modes that meet at a singular point of a branch, by the complete enumeration a little
before it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from symkin.assembly.modes import modes
from symkin.assembly.modes_result import Completeness, Modes
from symkin.errors import SymkinError
from symkin.following.block_follower import BlockFollower
from symkin.following.follow import Branch, joined
from symkin.following.machine_path import MachinePath
from symkin.following.singular_point import SingularPoint
from symkin.following.trajectory import Trajectory
from symkin.numeric.tolerances import DISTINCT_ROOTS
from symkin.position.problem import Problem
from symkin.position.roots import features
from symkin.position.solution import pose_of
from symkin.result import json_fields

_LOOK_BACK = 1e-4
"""Modes are enumerated this far before the singular point (share of an interval), or half way to
its beginning.
"""
_NEAR_RATIO = 20.0
"""At a bifurcation the modes nearer to the singular point than this times the followed one's
distance are said to meet.
"""
_MOST_COMBINED = 8
"""Blocks that turn together of which all combinations are looked for."""


@dataclass(frozen=True)
class Meeting:
    """Numbers (from 1) of modes in the list that `modes` gives at `given` (joints, pose or values
    by name in the mechanism's units, at `parameter` of the path): the followed one, None where the
    list lacks it, and those that meet it. `count` is the length of the list and `completeness` what
    it is worth. `opposite_signs`: whether the determinants of the followed rows (of each block that
    turns) have opposite signs on the two sides of the turning point; None where rows are redundant,
    or elsewhere.
    """

    parameter: float
    given: dict[str, Any]
    own: int | None
    others: tuple[int, ...]
    count: int
    completeness: Completeness
    opposite_signs: bool | None = None

    def to_dict(self) -> dict[str, Any]:
        """The meeting in the JSON of `symkin track`."""
        return {
            **json_fields(self, "parameter", "given", "own", "others"),
            "modes": self.count,
            **json_fields(self, "completeness", "opposite_signs"),
        }

    def __str__(self) -> str:
        """Which modes meet, in words."""
        place = f"at {self.parameter:.9g} of the path ({self.completeness})"
        if not self.count:
            return (
                f"`modes` lists no mode {place}, so that none is named that meets the mode followed"
            )
        listed = f"of the {self.count} that `modes` lists {place}"
        *most, last = [str(k) for k in self.others] or [""]
        several = f"modes {', '.join(most)} and {last}" if most else f"mode {last}"
        if self.own is None:
            return f"the mode followed is none {listed}" + (
                f"; {several} {'are' if most else 'is'} near it" if last else ""
            )
        own = f"mode {self.own}"
        if not last:
            return f"{own} {listed} was followed, and no other one is listed near it"
        if most:
            return f"{own} {listed} meets {several}"
        signs = {
            True: ", with determinants of opposite sign",
            False: ", with determinants of one sign",
            None: "",
        }
        return f"{own} {listed} meets mode {last}{signs[self.opposite_signs]}"


def meeting_modes(path: MachinePath, branch: Branch) -> Meeting | None:
    """The modes that meet where a branch ends at a singular point. None where nothing lies before
    it or the enumeration refuses.
    """
    row, u = branch.last.row, branch.last.u
    back = min(_LOOK_BACK, 0.5 * u)
    if back <= 0.0:
        return None
    written, problem = path.written, path.trajectory.problem
    given = user_values(written, written.at(row, u - back))
    try:
        found = modes(written.mechanism, **given)
    except SymkinError:
        return None
    turning = [block for block in branch.stopped if _is_turning(block)]
    folds_only = len(turning) == len(branch.stopped) and len(turning) <= _MOST_COMBINED
    listed = listed_unknowns(path, found)
    own, near, signs = (_across_folds if folds_only else _near_by)(
        problem, branch, listed, u - back
    )
    return Meeting(
        parameter=written.parameter(row, u - back),
        given=given,
        own=None if own is None else own + 1,
        others=tuple(sorted({k + 1 for k in near if k != own})),
        count=len(found),
        completeness=found.completeness,
        opposite_signs=signs,
    )


def _across_folds(
    problem: Problem, branch: Branch, listed: np.ndarray, u: float
) -> tuple[int | None, list[int], bool | None]:
    """Numbers (from 0) of the followed mode and of those on the other sides of the turning blocks'
    folds, in all combinations, and whether the determinants' signs are opposite.
    """
    turning = {block: _sides(block, u) for block in branch.stopped if _is_turning(block)}
    sides = [turning.get(block) or (block.at(u),) for block in branch.blocks]
    numbers = [
        nearest_mode(problem, listed, joined(problem, branch.blocks, parts))
        for parts in product(*sides)
    ]
    opposite = None
    if all(block.suffices for block in turning):
        signs = ({_sign(block, z, u) for z in own} for block, own in turning.items())
        opposite = all(own == {-1.0, 1.0} for own in signs)
    return numbers[0], [number for number in numbers if number is not None], opposite


def _near_by(
    problem: Problem, branch: Branch, listed: np.ndarray, u: float
) -> tuple[int | None, list[int], None]:
    """Numbers (from 0) of the followed mode and of those near the singular point, where branches
    cross.
    """
    own = joined(problem, branch.blocks, (block.at(u) for block in branch.blocks))
    reach = (
        _NEAR_RATIO * float(_distances(problem, own[None], branch.last.unknown)[0]) + DISTINCT_ROOTS
    )
    near = np.flatnonzero(_distances(problem, listed, branch.last.unknown) < reach)
    return nearest_mode(problem, listed, own), near.tolist(), None


def user_values(trajectory: Trajectory, known: np.ndarray) -> dict[str, Any]:
    """Known values as `modes` takes them, in the mechanism's units: joints, a pose, or values by
    name.
    """
    mechanism, problem = trajectory.mechanism, trajectory.problem
    values, place = dict[str, Any](), 0
    for c in trajectory.coordinates:
        if c.role != "pose":
            number = float(known[place])
            values[c.name] = mechanism.value_out(c, number)
        place += c.width
    if problem.gives_joints:
        return {"joints": [values[c.name] for c in mechanism.actuated]}
    if any(c.role == "pose" for c in trajectory.coordinates):
        reference = problem.select_values(problem.closure.reference, problem.system.unknowns)
        pose = pose_of(problem.closure, problem.join_values(reference, known))
        values["pose"] = [*map(float, pose.position), *map(float, pose.quaternion)]
    return {"pose": values["pose"]} if problem.gives_pose else {"given": values}


def listed_unknowns(path: MachinePath, modes: Modes) -> np.ndarray:
    """The followed unknowns (n, w) of a path at the modes of a list."""
    return path.unknowns(modes.modes.closure, modes.modes.values)


def nearest_mode(problem: Problem, listed: np.ndarray, unknown: np.ndarray) -> int | None:
    """The number (from 0) of the mode of a list, by its unknowns, that a configuration is, None
    where the list lacks it.
    """
    distances = _distances(problem, listed, unknown)
    return (
        int(np.argmin(distances)) if len(distances) and np.min(distances) < DISTINCT_ROOTS else None
    )


def _distances(problem: Problem, points: np.ndarray, unknown: np.ndarray) -> np.ndarray:
    away = features(problem.system, points) - features(problem.system, unknown[None])
    return np.max(np.abs(away), axis=1, initial=0.0) / problem.closure.characteristic_length


def _is_turning(block: BlockFollower) -> bool:
    return (
        block.stop is not None
        and block.stop.singular is not None
        and block.stop.singular.kind == "turning point"
    )


def _sides(block: BlockFollower, u: float) -> tuple[np.ndarray, np.ndarray]:
    """z of a turning block at a u before its turning point: on the followed side, and on the other
    one.
    """
    point: SingularPoint = block.stop.singular  # type: ignore[assignment, union-attr]
    # u = u* + u'' t^2 / 2 about the turning point (see `singular_point`): t = +-sqrt(2 (u* - u) /
    # |u''|) on its two sides
    reach = math.sqrt(2.0 * (point.u - u) / abs(point.curvature))
    null, z = point.null[:, 0], point.y[:-1]
    v = reach * (null if null @ (block.station.z - z) > 0 else -null)
    sides = (np.append(z + away, u)[None] for away in (v, -v))
    own, mate = (block.system.correct(y, block.interval.c)[0][0, :-1] for y in sides)
    return own, mate


def _sign(block: BlockFollower, z: np.ndarray, u: float) -> float:
    """The sign of det dG/dz, of redundant rows in the combinations that the turning point has."""
    point: SingularPoint = block.stop.singular  # type: ignore[assignment, union-attr]
    y = np.array([point.y, np.append(z, u)])
    there, here = block.system.evaluate(y, np.repeat(block.interval.c, 2, axis=0))[1]
    combined = np.linalg.svd(there)[0][:, : block.system.width].T
    return float(np.linalg.slogdet(combined @ here[:, :-1])[0])
