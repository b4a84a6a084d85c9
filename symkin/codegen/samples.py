"""Sample closed configurations near home, over which pivots are chosen and of which test vectors
are made.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.model.joint import Coordinate, units_of
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.problem import Problem, build_problem

_STEPS = 12
MORE = 4
"""Lines that are followed at once beside those that are lacking: some are left out."""
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
    signs, found = _limb_signs(direct, home[None])[0], list[Configuration]()
    left = 4 * count
    while len(found) < count and left > 0:
        tried = min(left, count - len(found) + MORE)
        left -= tried
        moves = reach * np.round(rng.uniform(-1, 1, (tried, len(joints))), 6)
        goals = np.array([_within(joints, begin_known, way) for way in moves])
        ends, whole = all_followed(direct, begin, begin_known, goals)
        values = direct.join_values(ends, goals)
        whole[whole] = np.all(_limb_signs(direct, values[whole]) == signs, axis=1)
        for k in range(tried):
            # joints between narrow limits give the same goal again and again
            if whole[k] and not any(
                np.all(np.abs(goals[k] - other.known) <= _DISTINCT * reach) for other in found
            ):
                found.append(Configuration(values[k], ends[k], goals[k]))
    return found[:count]


def _limb_signs(direct: Problem, values: np.ndarray) -> np.ndarray:
    """Signs (n, limbs) of the determinants of the limbs for a given pose: one changes where a limb
    has passed a dead centre.
    """
    inverse = build_problem(direct.mechanism, "inverse")
    known, signs = values[:, inverse.known_places], [np.zeros((len(values), 0))]
    for b in inverse.blocks:
        matrices = b.linearise(inverse.select_values(values, b.unknowns), known)[1]
        if matrices.shape[1] == matrices.shape[2]:
            signs.append(np.sign(np.linalg.det(matrices))[:, None])
    return np.hstack(signs)


def all_followed(
    direct: Problem, z: np.ndarray, start: np.ndarray, goals: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The unknowns (n, width) after the joints' straight lines from a start, or one of each (n,
    known), to each of the goals (n, known), in small steps, and which lines (n,) are followed: none
    of whose steps fails, or turns the matrix over, det(A^T B) < 0, where a fold was leapt.
    """
    system, starts = direct.system, np.broadcast_to(start, goals.shape)
    closed = CLOSURE_TOLERANCE * system.characteristic_length
    ends = np.broadcast_to(z, (len(goals), z.shape[-1])).copy()
    going, matrices = np.arange(len(goals)), system.linearise(ends, starts)[1]
    for k in range(1, _STEPS + 1):
        known = starts[going] + k / _STEPS * (goals[going] - starts[going])
        found = system.polish_many(ends[going], known, 6)
        turned = np.linalg.slogdet(matrices[going].transpose(0, 2, 1) @ found.jacobians)[0]
        fine = (
            (system.residuals(found.points, known) <= closed)
            & ~_jumped(direct, ends[going], found.points)
            & ~(turned < 0.0)
        )
        going = going[fine]
        ends[going], matrices[going] = found.points[fine], found.jacobians[fine]
        if not going.size:
            break
    whole = np.zeros(len(goals), dtype=bool)
    whole[going] = True
    return ends, whole


def _jumped(direct: Problem, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Which points (n, width) have moved too far in a step."""
    units = units_of(direct.system.unknowns, direct.closure.characteristic_length)
    return np.asarray(np.max(np.abs(after - before) / units, axis=1, initial=0.0) > 0.25)


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
