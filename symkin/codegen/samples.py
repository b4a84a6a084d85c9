"""Sample closed configurations near home, over which pivots are chosen and of which test vectors
are made.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.model.joint import Coordinate
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.problem import Problem, build_problem

_STEPS = 12
_DISTINCT = 1e-4
"""Goals that differ by less than this part of the reach in every joint are one case."""


@dataclass(frozen=True, eq=False)
class Configuration:
    """A closed configuration: all variables of the closure, and their unknown and known parts for
    the direct problem.
    """

    values: np.ndarray
    unknown: np.ndarray
    known: np.ndarray


def configurations(
    direct: Problem,
    home: np.ndarray,
    count: int,
    seed: int,
    spread: float = 0.1,
    turn: float = 0.25,
) -> list[Configuration]:
    """Distinct configurations, at most `count`, that the machine reaches from `home` (all
    variables) when its joints move in straight lines by up to `spread` times the size and `turn`
    radians, within their limits; lines that meet a singularity, or bring a limb past a dead centre,
    are left out.
    """
    rng = np.random.default_rng(seed)
    joints = direct.known_coordinates
    begin_known, begin = (
        direct.select_values(home, joints),
        direct.select_values(home, direct.system.unknowns),
    )
    reach = np.array(
        [
            _reach(c, turn if c.is_angular else spread * direct.closure.characteristic_length)
            for c in joints
        ]
    )
    signs, found = _limb_signs(direct, home), list[Configuration]()
    for _ in range(4 * count):
        if len(found) == count:
            break
        goal = _within(joints, begin_known, reach * np.round(rng.uniform(-1, 1, len(joints)), 6))
        # joints between narrow limits give the same goal again and again
        if any(np.all(np.abs(goal - other.known) <= _DISTINCT * reach) for other in found):
            continue
        z = followed(direct, begin, begin_known, goal)
        if z is None:
            continue
        values = direct.join_values(z, goal)
        if np.array_equal(_limb_signs(direct, values), signs):
            found.append(Configuration(values, z, goal))
    return found


def _limb_signs(direct: Problem, values: np.ndarray) -> np.ndarray:
    """Signs of the determinants of the limbs for a given pose: one changes where a limb has passed
    a dead centre.
    """
    inverse = build_problem(direct.mechanism, "inverse")
    known = inverse.select_values(values, inverse.known_coordinates)
    matrices = [
        b.linearise_one(inverse.select_values(values, b.unknowns), known)[1] for b in inverse.blocks
    ]
    return np.array([np.sign(np.linalg.det(m)) for m in matrices if m.shape[0] == m.shape[1]])


def followed(
    direct: Problem, z: np.ndarray, start: np.ndarray, goal: np.ndarray
) -> np.ndarray | None:
    """The unknowns after the joints' straight line from start to goal, in small steps; None where a
    step fails, or where the matrix has turned over, det(A^T B) < 0: a fold was leapt.
    """
    system = direct.system
    _, matrix = system.linearise_one(z, start)
    for k in range(1, _STEPS + 1):
        known = start + k / _STEPS * (goal - start)
        moved = system.polish(z, known, 6)
        if system.residual(
            moved, known
        ) > CLOSURE_TOLERANCE * system.characteristic_length or _jumped(direct, z, moved):
            return None
        before, (_, matrix) = matrix, system.linearise_one(moved, known)
        if np.linalg.slogdet(before.T @ matrix)[0] < 0.0:
            return None
        z = moved
    return system.polish(z, goal, 6)


def _jumped(direct: Problem, before: np.ndarray, after: np.ndarray) -> bool:
    parts = [
        float(np.max(np.abs(after[place] - before[place])))
        / (1.0 if c.kind != "length" else direct.closure.characteristic_length)
        for c, place in zip(direct.system.unknowns, direct.system.slices, strict=True)
    ]
    return max(parts) > 0.25


def _limited(joint: Coordinate) -> tuple[float, float]:
    """Its limits less a hundredth of their range at each end; infinite where it has none."""
    low, high = joint.limits or (-np.inf, np.inf)
    margin = 0.01 * (high - low) if joint.limits else 0.0
    return low + margin, high - margin


def _reach(joint: Coordinate, reach: float) -> float:
    """At most half of the range between the limits: then a move or its opposite stays inside."""
    low, high = _limited(joint)
    return float(min(reach, 0.5 * (high - low)))


def _within(joints: tuple[Coordinate, ...], begin: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Goals begin + moves; a move that leaves its joint's limits is made in the opposite
    direction.
    """
    inside: np.ndarray = begin + moves
    for i, c in enumerate(joints):
        low, high = _limited(c)
        if not low <= inside[i] <= high:
            inside[i] = np.clip(np.clip(begin[i], low, high) - moves[i], low, high)
        if c.least is not None:
            inside[i] = max(inside[i], c.least + 1e-2 * abs(c.reference[0] - c.least))
    return inside
