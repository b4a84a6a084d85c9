"""Reciprocal screws of limbs and platform at one configuration.

With the closure's rows F(q, x, X) = 0 differentiated, A twist + B rates = 0 for each limb. A wrench
of the limb's constraint system is A^T y for y^T B = 0: it does no work on any twist that the limb's
joints, cut ones included, allow. With the actuated joints locked, only the passive columns of B
count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.numeric.rank import null_space, row_space
from symkin.numeric.system import System
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import whole_system
from symkin.position.transfer import many_elsewhere
from symkin.spatial.rotation import conjugate, multiply
from symkin.spatial.screw import tidy_rows


@dataclass(frozen=True, eq=False)
class LimbScrews:
    """Wrenches (force; moment about the base origin), as rows: those that a limb always exerts on
    the platform, and those with its actuated joints locked.
    """

    limb: str
    constraints: np.ndarray
    locked: np.ndarray

    @property
    def counts(self) -> tuple[int, int]:
        return len(self.constraints), len(self.locked)


def limb_screws(closure: Closure, values: np.ndarray) -> tuple[LimbScrews, ...]:
    """Constraint wrenches of each limb against a free platform, whatever motion is declared; none
    where joints or rods other than limbs hold the platform.
    """
    if closure.mechanism.is_graph:
        return ()
    spatial, z, jacobian = in_space(closure, values)
    roles = [c.role for c in spatial.owners]
    joints = [k for k, role in enumerate(roles) if role != "pose"]
    passive = [k for k, role in enumerate(roles) if role == "passive"]
    position = z[spatial.slices["pose.x"].start :][:3]
    screws = []
    for limb in closure.mechanism.limbs:
        rows = [k for k, row in enumerate(spatial.row_sources) if row.limb == limb.name]
        twist_rows = jacobian[rows][:, [k for k, role in enumerate(roles) if role == "pose"]]
        systems = []
        for kept in (joints, passive):
            wrenches = (
                null_space(jacobian[np.ix_(rows, kept)].T, RANK_TOLERANCE, relative=True)
                @ twist_rows
            )
            systems.append(
                readable_span(
                    _at_base_origin(wrenches, position, closure.characteristic_length),
                    closure.characteristic_length,
                )
            )
        screws.append(LimbScrews(limb.name, systems[0], systems[1]))
    return tuple(screws)


def in_space(closure: Closure, values: np.ndarray) -> tuple[Closure, np.ndarray, np.ndarray]:
    """The closure without a declared motion, its variables at a configuration, and the derivatives
    of its rows there.
    """
    spatial = build_closure(replace(closure.mechanism, motion="spatial"))
    z = many_elsewhere(spatial, closure, values[None])[0]
    return spatial, z, whole_system(spatial).linearise_one(z)[1]


def _at_base_origin(wrenches: np.ndarray, position: np.ndarray, size: float) -> np.ndarray:
    """From (force, moment / size about the platform origin) to (force; moment about the base
    origin).
    """
    force, moment = wrenches[:, :3], size * wrenches[:, 3:]
    return np.hstack([force, moment + np.cross(position, force)])


def platform_screws(
    closure: Closure, system: System, values: np.ndarray, limbs: Sequence[LimbScrews]
) -> tuple[np.ndarray, np.ndarray]:
    """Wrenches that the platform takes and the twists that it has left, as rows: from those of its
    limbs, else from what the closed loops leave; none without a platform.
    """
    size = closure.characteristic_length
    if limbs:
        wrenches = readable_span(_even(np.vstack([limb.constraints for limb in limbs]), size), size)
        return wrenches, _reciprocal(wrenches, size)
    if closure.mechanism.platform_link is None:
        return np.zeros((0, 6)), np.zeros((0, 6))
    twists = _platform_twists(closure, system, values)
    return _reciprocal(twists, size), twists


def _reciprocal(screws: np.ndarray, size: float) -> np.ndarray:
    """A readable basis of the screws reciprocal to all of some."""
    return readable_span(reciprocal_system(screws, size), size) if len(screws) else np.eye(6)


def _platform_twists(closure: Closure, system: System, values: np.ndarray) -> np.ndarray:
    """Twists (angular velocity; velocity at the base origin) of the platform link that the closed
    loops leave, as rows.
    """
    free = null_space(system.linearise_one(values)[1], RANK_TOLERANCE, relative=True)
    pose = ca.vertcat(closure.pose.position, closure.pose.quaternion)
    rates = ca.mtimes(ca.jacobian(closure.bound(pose), closure.variables), system.tangent)
    evaluate = ca.Function("platform", [closure.variables], [closure.bound(pose), rates])
    at, moved = (np.asarray(part) for part in evaluate(values))
    moved = moved @ free.T
    position, quaternion = at[:3, 0], at[3:, 0]
    twists = []
    for rate in moved.T:
        angular = 2.0 * multiply(rate[3:], conjugate(quaternion))[1:]
        twists.append(np.concatenate([angular, rate[:3] - np.cross(angular, position)]))
    size = closure.characteristic_length
    return readable_span(np.array(twists), size) if twists else np.zeros((0, 6))


def reciprocal_system(screws: np.ndarray, size: float = 1.0) -> np.ndarray:
    """Basis (rows) of the screws reciprocal to every row of `screws`; moments are weighed by the
    length `size`.
    """
    weights = _weights(size)
    scaled = _even(np.atleast_2d(screws), size) * weights
    swapped = np.hstack([scaled[:, 3:], scaled[:, :3]])
    return tidy_rows(null_space(swapped, RANK_TOLERANCE, relative=True)) / weights


def _even(screws: np.ndarray, size: float) -> np.ndarray:
    """The same screws of one length: beside unit forces of a huge machine unit couples are nothing,
    and of a tiny one the forces are.
    """
    norms = np.linalg.norm(screws * _weights(size), axis=1, keepdims=True)
    return screws / np.where(norms > 0.0, norms, 1.0)


def _weights(size: float) -> np.ndarray:
    """Weights of the numbers of a screw, moments by the size."""
    return np.array([1.0, 1.0, 1.0, 1 / size, 1 / size, 1 / size])


def readable_span(wrenches: np.ndarray, size: float) -> np.ndarray:
    """A readable basis of the span of wrenches: unit forces, and unit couples where there is no
    force. Moments are weighed by the size in judging rank.
    """
    weights = _weights(size)
    scaled = wrenches * weights
    basis = row_space(scaled, RANK_TOLERANCE, relative=True)
    if not len(basis):
        return basis
    rows = tidy_rows(basis) / weights
    forces, moments = np.linalg.norm(rows[:, :3], axis=1), np.linalg.norm(rows[:, 3:], axis=1)
    return rows / np.where(forces > 1e-9, forces, moments)[:, None]
