"""Poses of a sweep: which of their coordinates can be swept, and the values of many at once (see
`position.varied_pose`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symkin.assembly.by_groups import modes_by_groups
from symkin.assembly.search import Search
from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.keys import ABOUT_Z
from symkin.model.mechanism import Mechanism
from symkin.position.determination import determination
from symkin.position.given import given_poses, read_given
from symkin.position.pose_conditions import condition_sentence, poses_vary
from symkin.position.problem import Problem
from symkin.position.varied_pose import POSE_AXES, pose_at
from symkin.singularities.motion_ranks import generic_ranks
from symkin.velocity.roles import Roles

_NEAR, _SAMPLES = 1e-3, 4
"""Poses within this share of the size (rad) of one that is taken, and how many of them, tell
whether the joints tie the coordinates.
"""


def pose_units(mechanism: Mechanism) -> dict[str, str]:
    """Names that can be swept, with their units."""
    return {
        n: mechanism.length_unit if n in "xyz" else mechanism.angle_unit
        for n in POSE_AXES[mechanism.motion]
    }


def pose_values(
    mechanism: Mechanism, base: Sequence[float], varied: Mapping[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Pose coordinates (n, numbers) of the poses `base` (x, y, z, qw, qx, qy, qz) with varied
    coordinates (n,) in the mechanism's units, and how far each lies off those that the mechanism
    can take (length unit), 0 where it is one.
    """
    poses = pose_at(mechanism, base, varied)
    read = given_poses(mechanism, np.vstack([poses.position, poses.quaternion]).T)
    return np.array([one.values for one in read]), np.array([one.off_motion for one in read])


def check_poses(problem: Problem, base: Sequence[float], values: Mapping[str, np.ndarray]) -> None:
    """Raises InputError where no point, or hardly any, is a pose that the mechanism can take: the
    angle is given twice, `base` lies off the platform's motion, or its joints put a condition on
    what is swept.
    """
    if "gamma" in values and "rz" in values:
        raise InputError(
            "grid: gamma and rz are given together; they are the same angle, from the reference's "
            "orientation or at's"
        )
    mechanism = problem.mechanism
    off = read_given(mechanism, None, base).off_motion
    if off > 0.0:
        raise InputError(
            f"at: the pose lies off the {mechanism.motion} motion of {mechanism.name}'s platform "
            f"by {off:.3g} {mechanism.length_unit}, "
            "so that no point has a solution; allowed: poses of that motion"
        )
    if problem.by_name:
        _check_some_near(problem, base, values)
    else:
        _check_conditions(mechanism, base, values)


def _check_some_near(
    problem: Problem, base: Sequence[float], values: Mapping[str, np.ndarray]
) -> None:
    """Raises InputError where the joints tie the pose's coordinates: `base` has solutions, and none
    of some poses near it has one.
    """
    mechanism, swept = problem.mechanism, [name for name, v in values.items() if v[-1] > v[0]]
    if not swept or not determination(problem).decided:
        return
    shares = np.vstack(
        [
            np.zeros(len(swept)),
            np.random.default_rng(0).uniform(-_NEAR, _NEAR, (_SAMPLES, len(swept))),
        ]
    )
    size, angle = mechanism.characteristic_length, mechanism.angle_out(1.0)
    near = {
        n: base["xyz".index(n)] + size * share if n in "xyz" else angle * share
        for n, share in zip(swept, shares.T, strict=True)
    }
    counts = modes_by_groups(problem, pose_values(mechanism, base, near)[0], Search.of(None)).total
    if counts[0] and not any(counts[1:]):
        raise InputError(
            f"grid: the joints of {mechanism.name} tie the coordinates of its platform's pose, so "
            f"that {_listed(swept)} cannot vary while "
            "the others are held; sweep as many coordinates as it has freedoms by name, with "
            "--given (given={...})"
        )


def _check_conditions(
    mechanism: Mechanism, base: Sequence[float], values: Mapping[str, np.ndarray]
) -> None:
    swept = [name for name, v in values.items() if v[-1] > v[0]]
    freedoms = generic_ranks(Roles.of_limbs(mechanism)).outputs
    coordinates = sum(c.freedom for c in build_closure(mechanism).role("pose"))
    if not swept or freedoms >= coordinates:
        return
    held = pose_at(
        mechanism, base, {name: float(v[0]) for name, v in values.items() if name not in swept}
    )
    box = tuple(_side(mechanism, name, values[name]) for name in swept)
    if poses_vary(mechanism, (*held.position.tolist(), *held.quaternion.tolist()), box) is False:
        instead = "actuated joints (without --poses)"
        raise InputError(
            f"grid: {condition_sentence(mechanism, _listed(swept), instead, freedoms, coordinates)}"
        )


def _side(mechanism: Mechanism, name: str, values: np.ndarray) -> tuple[str, float, float]:
    """A swept coordinate by the closure's name, its bounds in length units and rad."""
    low, high = float(values[0]), float(values[-1])
    if name in "xyz":
        return name, low, high
    own = "gamma" if mechanism.motion in ABOUT_Z else name
    return own, mechanism.angle_in(low), mechanism.angle_in(high)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
