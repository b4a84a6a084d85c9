"""Determine what the readings can tell: rank and null space of the identification Jacobian, named
in parameter terms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.observables import observables
from symkin.calibration.estimate.configurations import solve_configurations
from symkin.calibration.estimate.estimator import estimate
from symkin.calibration.estimate.linear import UNTOLD, WELL_TOLD, Linear
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.state import State, design, error_free_state, spectrum
from symkin.calibration.judge.named_directions import all_values, named_motions, parallel_offsets
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism

_NULL_SPACE_TOLERANCE = 1e-5
"""A unit direction belongs to the null space when its part outside is shorter than this."""
_SAME_ANGLE = np.radians(2.0)
"""Inclinations or yaws (radians) that spread by less count as one."""
_SPARSE_DRAWS = 60
"""Draws of parameters in the search for sparse combinations."""
_FREE_FRAMES = ("base frame translation", "base frame yaw", "platform frame", "tool frame")
"""Combinations that inclinations never determine."""
_OFF_PLANE = ("translation z", "about x", "about x)", "about y", "about y)")
"""Ends of the names of frames in which a planar mechanism cannot be used."""
_MAX_LISTED_PARAMETERS = 4
"""Most parameters that a combination without a name of its own lists."""


@dataclass(frozen=True, eq=False)
class Identifiability:
    """Rank of the identification Jacobian (residuals over their standard deviations, columns per
    length unit, angles and directions times the size), its singular values and null space (P, k)
    over `names`; `unobservable` names k independent combinations that no reading determines,
    `advice` says what to measure besides. `blind` (P, j) is that part of the null space which no
    reading tells at all, whatever its noise. `weak` names combinations that the readings tell
    hardly better than the prior, each with its standard deviation by the readings over the prior's.
    `gap` is the ratio of the singular values on both sides of the rank (infinite where nothing is
    dropped to rounding).
    """

    names: tuple[str, ...]
    jacobian: np.ndarray
    singular_values: np.ndarray
    rank: int
    gap: float
    null_space: np.ndarray
    unobservable: tuple[str, ...]
    advice: tuple[str, ...]
    blind: np.ndarray
    weak: tuple[tuple[str, float], ...] = ()

    @cached_property
    def base_set(self) -> tuple[str, ...]:
        """As many parameters as the rank, that the readings determine when the others are held: of
        the null space, by elimination with pivots, the parameters that span it best are left out.
        """
        rest, dropped = self.null_space.copy(), set[int]()
        for _ in range(self.null_space.shape[1]):
            sizes = np.linalg.norm(rest, axis=1)
            pivot = int(np.flatnonzero(sizes >= (1 - 1e-9) * sizes.max())[-1])
            dropped.add(pivot)
            unit = rest[pivot] / sizes[pivot]
            rest -= np.outer(rest @ unit, unit)
        return tuple(n for k, n in enumerate(self.names) if k not in dropped)

    @property
    def drowned(self) -> np.ndarray:
        """The rest of the null space (P, k - j): told by readings without noise alone."""
        rest = self.null_space - self.blind @ (self.blind.T @ self.null_space)
        left, lengths, _ = np.linalg.svd(rest, full_matrices=False)
        return np.asarray(left[:, lengths > 0.5])

    @property
    def condition(self) -> float:
        """Largest over smallest kept singular value."""
        return (
            float(self.singular_values[0] / self.singular_values[self.rank - 1])
            if self.rank
            else float("inf")
        )

    def __str__(self) -> str:
        lines = [
            f"rank {self.rank} of {len(self.names)} parameters, condition {self.condition:.3g}, "
            f"gap {self.gap:.3g}"
        ]
        lines += [f"  not observable: {text}" for text in self.unobservable]
        lines += [
            f"  hardly told: {text} (standard deviation {share:.2g} of the prior's)"
            for text, share in self.weak
        ]
        return "\n".join([*lines, *(f"  advice: {text}" for text in self.advice)])


def identifiability(
    mechanism: Mechanism,
    measurements: Measurements,
    *,
    parameters: Sequence[str] | None = None,
    fixed: Sequence[str] = (),
    residual: str = "means",
) -> Identifiability:
    """Determine the identifiability at the nominal geometry, over the configurations whose direct
    problem is solved there. Where standard deviations are known, what the readings tell ten times
    worse than the prior (see `estimate.linear`) counts as not told.
    """
    problem = build_calibration(
        mechanism, measurements, parameters=parameters, fixed=fixed, residual=residual
    )
    configurations = solve_configurations(problem.model, measurements, problem.model.nominal)
    if not configurations.solved.any():
        raise InputError(
            f"{mechanism.name}: the direct problem of no posture has a solution at the nominal "
            f"geometry"
        )
    if not configurations.solved.all():
        some = measurements.subset(configurations.solved)
        problem = build_calibration(
            mechanism, some, parameters=parameters, fixed=fixed, residual=residual
        )
    state = estimate(problem, configurations.z[configurations.solved], max_iterations=0).state
    return identifiability_at(problem, state, 1.0 if problem.readings.known else 0.0)


def identifiability_at(problem: CalibrationProblem, state: State, weight: float) -> Identifiability:
    """Determine the identifiability at a state with closed configurations: what the readings
    determine beside a prior of some weight, 0 for none.
    """
    state = error_free_state(problem, state)
    matrix = design(state)
    found = spectrum(matrix)
    null_space = found.null_space
    weak: tuple[tuple[str, float], ...] = ()
    if weight > 0.0:
        null_space, weak = _beside_prior(problem, state, null_space, weight)
    named = name_null_space(problem, state.p, null_space)
    return Identifiability(
        names=problem.names,
        jacobian=state.linearised.matrix,
        singular_values=found.values,
        rank=len(problem.names) - null_space.shape[1],
        gap=found.gap,
        null_space=null_space,
        blind=found.null_space,
        weak=weak,
        unobservable=named,
        advice=_advice(problem, state, named),
    )


def _beside_prior(
    problem: CalibrationProblem, state: State, null_space: np.ndarray, weight: float
) -> tuple[np.ndarray, tuple[tuple[str, float], ...]]:
    """Return the directions (P, k) of which the readings tell nothing beside the prior, and those
    of which they tell little, named.
    """
    linear = Linear.of(problem, state, problem.widened)
    ratios, directions = linear.told
    ratios, directions = ratios / weight, linear.basis @ directions
    untold = ratios < UNTOLD
    if np.sum(untold) > null_space.shape[1]:
        null_space = np.linalg.qr(directions[:, untold])[0]
    little = np.flatnonzero(~untold & (ratios < WELL_TOLD))
    weak = [(_combination(problem.names, directions[:, k]), 1.0 / ratios[k]) for k in little]
    return null_space, tuple((text, float(share)) for text, share in weak[::-1])


def name_null_space(
    problem: CalibrationProblem, p: np.ndarray, null_space: np.ndarray
) -> tuple[str, ...]:
    """Name independent directions that span the null space: single parameters without effect,
    frames and other known motions, then sparse combinations of parameters.
    """
    names: list[str] = []
    taken = np.zeros((len(p), 0))

    def take(name: str, direction: np.ndarray) -> None:
        nonlocal taken
        outside = direction - null_space @ (null_space.T @ direction)
        if taken.shape[1] == null_space.shape[1] or np.linalg.norm(outside) > _NULL_SPACE_TOLERANCE:
            return
        fresh = direction - taken @ (taken.T @ direction)
        if np.linalg.norm(fresh) > 1e-3:
            names.append(name)
            taken = np.column_stack([taken, fresh / np.linalg.norm(fresh)])

    for name, direction in named_motions(problem.model, p):
        take(name, direction)
    for name, velocity in parallel_offsets(problem.mechanism, all_values(problem.model, p)):
        if all(n in problem.names for n in velocity):
            direction = np.array([velocity.get(n, 0.0) for n in problem.names])
            take(name, direction / np.linalg.norm(direction))
    for k, name in enumerate(problem.names):
        take(f"{name} (no effect)", np.eye(len(p))[k])
    for direction in _sparse_directions(null_space):
        take(_combination(problem.names, direction), direction)
    return tuple(names)


def _sparse_directions(null_space: np.ndarray) -> list[np.ndarray]:
    """Find unit directions of a space (P, k) with few parameters in each, fewest first: bases in
    which k parameters, drawn again and again, are 1 in one direction and 0 in the others.
    """
    width, count = null_space.shape
    rng = np.random.default_rng(0)
    found: list[np.ndarray] = []
    for _ in range(_SPARSE_DRAWS if count else 0):
        chosen = rng.permutation(width)
        pivots: list[int] = []
        reduced = null_space.copy()
        for row in chosen:
            norm = np.linalg.norm(reduced[row])
            if norm > 0.03:
                pivots.append(int(row))
                unit = reduced[row] / norm
                reduced = reduced - np.outer(reduced @ unit, unit)
            if len(pivots) == count:
                break
        if len(pivots) == count:
            found.extend((null_space @ np.linalg.inv(null_space[pivots])).T)
    found = [v / np.linalg.norm(v) for v in found]
    return sorted(found, key=lambda v: int(np.sum(np.abs(v) > 1e-6)))


def _combination(names: Sequence[str], direction: np.ndarray) -> str:
    """Write 'dh.2.d - dh.3.d': the largest components, with their weights where they are not
    one.
    """
    order = np.argsort(-np.abs(direction), kind="stable")
    kept = [int(k) for k in order if abs(direction[k]) > 1e-6 * abs(direction[order[0]])]
    lead = direction[kept[0]]
    terms = []
    for k in kept[:_MAX_LISTED_PARAMETERS]:
        weight = direction[k] / lead
        size = "" if abs(abs(weight) - 1) < 1e-4 else f"{abs(weight):.3g} "
        terms.append(f"{'-' if weight < 0 else '+'} {size}{names[k]}")
    more = (
        f" and {len(kept) - _MAX_LISTED_PARAMETERS} more"
        if len(kept) > _MAX_LISTED_PARAMETERS
        else ""
    )
    return " ".join(terms).removeprefix("+ ") + more


# --- advice ---------------------------------------------------------------------------------------


def _advice(
    problem: CalibrationProblem, state: State, unobservable: Sequence[str]
) -> tuple[str, ...]:
    """Say what to measure besides, from what the configurations have in common."""
    advice = []
    kinds = {kind for kind, _ in problem.model.columns}
    unusual = [
        text for text in unobservable if not text.startswith(_FREE_FRAMES) and "size of" not in text
    ]
    poses = problem.model.poses(state.z, problem.measurements.joints, state.p)
    if problem.readings.groups and unusual:
        heads = inclinations(poses[problem.readings.first])
        if _largest_range(heads) < _SAME_ANGLE:
            advice.append(
                "all groups have the same inclination; add groups at other inclinations (a wedge "
                "under the inclinometer)"
            )
    if (
        kinds <= {"group", "inclination"}
        and unusual
        and _largest_range(_yaws(poses)[:, None]) < _SAME_ANGLE
    ):
        advice.append(
            "the yaw (rotation about the vertical) is the same in all postures; vary the yaw "
            "within each group"
        )
    if any(text.startswith("size of") for text in unobservable):
        advice.append(
            "no reading fixes the size: hold one length or factor, or measure a distance, a "
            "position or a known length"
        )
    flat = problem.mechanism.motion == "planar"
    if any("frame" in text and not (flat and text.endswith(_OFF_PLANE)) for text in unobservable):
        besides = any(
            o.kind in ("point", "position") for o in observables(problem.mechanism).values()
        )
        others = " or of links, or by positions of points" if besides else ""
        advice.append(
            "frames are free: they are chosen by the least change, by `fixed` parameters, or "
            "measured by positions and "
            f"orientations of the platform{others}"
        )
    if len(problem.readings.values) and problem.readings.count < len(problem.names) - len(
        unobservable
    ):
        advice.append(
            f"{problem.readings.count} independent readings for {len(problem.names)} parameters; "
            f"add postures"
        )
    return tuple(advice)


def inclinations(poses: np.ndarray) -> np.ndarray:
    """Return alpha, beta (n, 2) of poses (n, 7)."""
    w, x, y, z = poses[:, 3:].T
    first, second, third = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return np.column_stack([np.arctan2(second, third), np.arctan2(-first, np.hypot(second, third))])


def _yaws(poses: np.ndarray) -> np.ndarray:
    w, x, y, z = poses[:, 3:].T
    return np.asarray(np.unwrap(np.arctan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z))))


def _largest_range(values: np.ndarray) -> float:
    return float(np.max(np.ptp(values, axis=0), initial=0.0))
