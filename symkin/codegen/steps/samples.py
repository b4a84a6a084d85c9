"""Sample closed configurations near home, over which pivots are chosen and of which test vectors
are made.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.codegen.text.c import Real
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.newton import Polished
from symkin.numeric.system import System, split_blocks
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.problem import Problem, build_problem, pose_names

_STEPS = 12
_LONGEST = 0.25
"""Longest step, in sizes and radians."""
_MOST_TRIES = 8
"""Tries a configuration."""
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
    kept: Callable[[np.ndarray], np.ndarray] | None = None,
) -> list[Configuration]:
    """Distinct configurations, at most `count`, that the machine reaches from `home` (all
    variables) when its joints move in straight lines by up to `spread` times the size and `turn`
    radians, within their limits; lines that meet a singularity are left out, and those whose ends
    (n, variables) are not `kept`: by default those that bring a limb past a dead centre.
    """
    rng, size = np.random.default_rng(seed), direct.system.characteristic_length
    joints, begin = direct.known_coordinates, home[direct.unknown_places]
    begin_known = home[direct.known_places]
    reach = np.array([_reach(c, turn if c.is_angular else spread * size) for c in joints])
    kept = _on_sides_of(direct, home) if kept is None else kept
    found, left = list[Configuration](), _MOST_TRIES * count
    while len(found) < count and left > 0:
        tried = min(left, count - len(found) + MORE)
        left -= tried
        moves = reach * np.round(rng.uniform(-1, 1, (tried, len(joints))), 6)
        goals = np.array([_within(joints, begin_known, way) for way in moves])
        ends, whole = all_followed(direct, begin, begin_known, goals)
        values = np.tile(home, (tried, 1))
        values[:, direct.unknown_places], values[:, direct.known_places] = ends, goals
        whole[whole] = kept(values[whole])
        for k in np.flatnonzero(whole):
            # joints between narrow limits give the same goal again and again
            if not any(np.all(np.abs(goals[k] - f.known) <= _DISTINCT * reach) for f in found):
                found.append(Configuration(values[k], ends[k], goals[k]))
    return found[:count]


def _on_sides_of(direct: Problem, home: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Tells which configurations have their limbs on the sides of dead centres of those at home."""
    signs = _limb_signs(direct, home[None])[0]
    return lambda values: np.all(_limb_signs(direct, values) == signs, axis=1)


def _limb_signs(direct: Problem, values: np.ndarray) -> np.ndarray:
    """Signs (n, limbs) of the determinants of the limbs for a given pose: one changes where a limb
    has passed a dead centre.
    """
    inverse = build_problem(direct.mechanism, pose_names(direct.mechanism))
    known, signs = values[:, inverse.known_places], [np.zeros((len(values), 0))]
    for b in split_blocks(inverse.system, by_errors=True):
        matrices = b.linearise(inverse.select_values(values, b.unknowns), known)[1]
        if matrices.shape[1] == matrices.shape[2]:
            signs.append(np.sign(np.linalg.det(matrices))[:, None])
    return np.hstack(signs)


def all_followed(
    problem: Problem, z: np.ndarray, start: np.ndarray, goals: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The unknowns (n, width) after the known values' straight lines from a start, or one of each
    (n, known), to each of the goals (n, known), in small steps, and which lines (n,) are followed:
    none of whose steps fails, or turns the matrix over, det(A^T B) < 0, where a fold was leapt.
    """
    system, starts = problem.system, np.broadcast_to(start, goals.shape)
    size, begin = system.characteristic_length, np.broadcast_to(z, (len(goals), z.shape[-1]))
    units, matrices = np.array(units_of(system.unknowns, size)), system.linearise(begin, starts)[1]

    def kept(going: np.ndarray, before: np.ndarray, found: Polished, known: np.ndarray) -> Any:
        turned = np.linalg.slogdet(matrices[going].transpose(0, 2, 1) @ found.jacobians)[0]
        way = np.max(np.abs(found.points - before) / units, axis=1, initial=0.0)
        matrices[going] = found.jacobians
        closed = system.residuals(found.points, known) <= CLOSURE_TOLERANCE * size
        return closed & ~(way > _LONGEST) & ~(turned < 0.0)

    return followed(system, begin, lambda part: starts + part * (goals - starts), _STEPS, kept)


def followed(
    system: System,
    z: np.ndarray,
    line: Callable[[float], np.ndarray],
    steps: int,
    kept: Callable[[np.ndarray, np.ndarray, Polished, np.ndarray], np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """The unknowns (n, width) after lines from z, whose known values at a part of them are `line`
    (n, known), and which lines (n,) are followed: all of whose steps are `kept`, by the lines'
    numbers, the unknowns before and after, and the known values.
    """
    ends, going = z.copy(), np.arange(len(z))
    for k in range(1, steps + 1):
        known = line(k / steps)[going]
        found = system.polish_many(ends[going], known, 6)
        fine = kept(going, ends[going], found, known)
        going = going[fine]
        ends[going] = found.points[fine]
        if not going.size:
            break
    whole = np.zeros(len(z), dtype=bool)
    whole[going] = True
    return ends, whole


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


# --- numbers --------------------------------------------------------------------------------------


def rounded_to(real: Real, values: Sequence[float] | np.ndarray) -> np.ndarray:
    """Numbers as the generated code reads them."""
    exact = np.asarray(values, dtype=float)
    return exact.astype(np.float32).astype(float) if real.name == "float" else exact


def tidied(
    values: Sequence[float] | np.ndarray, scales: Sequence[float] | np.ndarray | float
) -> np.ndarray:
    """Each number rounded to 13 digits of its scale (the size for lengths, 1 for angles and
    quaternions): below every tolerance, above what linear algebra libraries differ by.
    """
    numbers = np.asarray(values, dtype=float)
    digits = [
        13 - int(np.ceil(np.log10(scale)))
        for scale in np.broadcast_to(scales, numbers.shape).ravel()
    ]
    rounded = [round(float(v), d) + 0.0 for v, d in zip(numbers.ravel(), digits, strict=True)]
    return np.array(rounded).reshape(numbers.shape)


def tidied_pose(pose: np.ndarray, size: float) -> np.ndarray:
    """The seven numbers of a pose, rounded."""
    return tidied(pose, pose_scales(size))


def pose_scales(size: float) -> list[float]:
    """Scales of the seven numbers of a pose."""
    return [size] * 3 + [1.0] * 4
