"""Frames: what data leave free is chosen by parameters that are held, or by the least change from nominal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.calibration.estimator import Estimate, estimate
from symkin.calibration.parameters import FRAMES
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.state import ideal_design
from symkin.calibration.steps import null_directions
from symkin.errors import InputError
from symkin.model.limb import RodLimb
from symkin.model.mechanism import Mechanism
from symkin.position.rank import RANK_TOLERANCE

_ROUNDS = 40
"""Most corrections of the frames; each shrinks the departure by the curvature of the unobservable set."""


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
    vanishes (scaled parameters), and refitted. Directions that were free at nominal and are told at the fit (parallel axes
    that turn out not to be) are freed. Rigid frames are then a best fit of the joints to nominal (Procrustes); measuring frames,
    which have no nominal place, take all of it."""
    model = problem.model
    size = model.closure.size
    if null_directions(ideal_design(problem, result.state)).shape[1] < result.null_space.shape[1]:
        again = estimate(problem, result.state.z, p=result.state.p, method=method)
        if again.status == "ok" and again.state.cost <= result.state.cost * (1 + 1e-9):
            result = Estimate(again.state, again.status, result.iterations + again.iterations, again.null_space)
    for _ in range(_ROUNDS):
        directions = null_directions(ideal_design(problem, result.state))
        change = _removable(directions, (result.state.p - model.nominal) / model.scales, model.names)
        if directions.shape[1] == 0 or np.max(np.abs(change), initial=0.0) < 1e-12 * size:
            break
        p = result.state.p - model.scales * (directions @ change)
        z = model.system.move(result.state.z, result.state.follow(-(directions @ change)))
        again = estimate(problem, z, p=p, method=method, max_iterations=8)
        if again.status != "ok" or again.state.cost > 1.1 * result.state.cost + 1e-12 * result.state.fit.vector.size:
            break
        result = Estimate(again.state, result.status, result.iterations, directions)
    return result


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
