"""Frames: what data leave free is chosen by parameters that are held, or by the least change from nominal."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from symkin.calibration.descent import REMAINING, untold
from symkin.calibration.estimator import Estimate, estimate
from symkin.calibration.parameters import FRAMES
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.state import State, ideal_design
from symkin.calibration.steps import null_directions
from symkin.errors import InputError
from symkin.model.limb import RodLimb
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import RANK_TOLERANCE

_ROUNDS = 40
"""Most corrections of the frames; each shrinks the departure by the curvature of the unobservable set."""
_SAME = 1e-9
"""Share of the cost by which a change of frames may raise it, for rounding."""


def joint_frames(mechanism: Mechanism, platform: Sequence[str], base: Sequence[str]) -> tuple[str, ...]:
    """Parameters to hold so that frames stand in the joints of a platform on rods: the platform frame's origin in the
    joint of the first limb named, x axis through the second, xy plane through the third; the base frame's origin in the
    joint of the first, z against gravity, x towards the projection of the second.

    Raises InputError where a limb is no rod, and where an entry to be held is not zero at the nominal geometry.
    """
    if len(platform) != 3 or len(base) != 2:
        raise InputError(
            f"joint frames need three limbs for the platform and two for the base, not {len(platform)} and {len(base)}"
        )
    rods = {limb.name: limb for limb in mechanism.limbs if isinstance(limb, RodLimb)}
    for name in (*platform, *base):
        if name not in rods:
            raise InputError(
                f"joint frames: {name!r} is no rod limb of {mechanism.name}; its rods are {', '.join(rods) or 'none'}"
            )
    held = [(name, "platform", k) for name, letters in zip(platform, ("xyz", "yz", "z"), strict=True) for k in letters]
    held += [(name, "base", k) for name, letters in zip(base, ("xyz", "y"), strict=True) for k in letters]
    for name, end, k in held:
        value = getattr(rods[name], end)["xyz".index(k)]
        if abs(value) > 1e-9 * mechanism.size:
            raise InputError(f"joint frames: {name}.{end}.{k} = {value:g} must be 0; give the joints in these frames first")
    return tuple(f"{name}.{end}.{k}" for name, end, k in held)


def least_change(problem: CalibrationProblem, result: Estimate, method: str) -> Estimate:
    """The same fit with parameters nearest to nominal: moved along the unobservable directions N until N^T (p - nominal)
    vanishes (scaled parameters), and refitted; as far as the cost stays. Rigid frames are then a best fit of the joints to nominal
    (Procrustes); measuring frames, which have no nominal place, take all of it."""
    result, moved = _towards_nominal(problem, result, method, lambda state: null_directions(ideal_design(problem, state)))
    return result if moved else _towards_nominal(problem, result, method, lambda state: untold(problem, state))[0]


def _towards_nominal(
    problem: CalibrationProblem, result: Estimate, method: str, free: Callable[[State], np.ndarray]
) -> tuple[Estimate, bool]:
    """The fit moved along the directions that are `free` of it until it is nearest to nominal, and whether it got there."""
    model, size = problem.model, problem.model.closure.size
    slack = REMAINING if problem.readings.known else 1e-12 * result.state.fit.vector.size
    for _ in range(_ROUNDS):
        directions = free(result.state)
        change = _removable(directions, (result.state.p - model.nominal) / model.scales, model.names)
        if directions.shape[1] == 0 or np.max(np.abs(change), initial=0.0) < 1e-12 * size:
            return result, True
        p = result.state.p - model.scales * (directions @ change)
        z = model.system.move(result.state.z, result.state.follow(-(directions @ change)))
        again = estimate(problem, z, p=p, method=method, max_iterations=8)
        if again.status != "ok" or again.state.cost > (1 + _SAME) * result.state.cost + slack:
            return result, False
        result = Estimate(again.state, result.status, result.iterations, directions)
    return result, False


def _removable(directions: np.ndarray, change: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """How much of each direction (P, k) a change of the parameters (P,) holds: what is taken away so that the mechanism's own
    parameters change least, and then, with the freedom that is left, the measuring frames."""
    measuring = np.array([name in FRAMES for name in names])
    if not np.any(measuring):
        return np.asarray(directions.T @ change)
    left, singular, right = np.linalg.svd(directions[~measuring], full_matrices=True)
    kept = int(np.sum(singular > RANK_TOLERANCE))
    held = right[:kept].T @ ((left[:, :kept].T @ change[~measuring]) / singular[:kept])
    free = right[kept:].T
    rest = np.linalg.pinv(directions[measuring] @ free, rcond=RANK_TOLERANCE) @ (change - directions @ held)[measuring]
    return np.asarray(held + free @ rest)
