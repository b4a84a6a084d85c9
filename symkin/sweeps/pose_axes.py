"""Coordinates of poses that can be swept: those of the platform's motion, with the meaning of `position.varied_pose`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.given import given_from
from symkin.position.pose_conditions import condition_sentence, poses_vary
from symkin.position.varied_pose import POSE_AXES, pose_at
from symkin.singularities.motion_ranks import generic_ranks


def pose_units(mechanism: Mechanism) -> dict[str, str]:
    """Names that can be swept, with their units."""
    return {n: mechanism.length_unit if n in "xyz" else mechanism.angle_unit for n in POSE_AXES[mechanism.motion]}


def check_poses(mechanism: Mechanism, base: Sequence[float], values: Mapping[str, np.ndarray]) -> None:
    """Raises InputError where no point, or hardly any, is a pose that the mechanism can take: the angle is given twice, `base`
    lies off the platform's motion, or its joints put a condition on what is swept."""
    if "gamma" in values and "rz" in values:
        raise InputError(
            "grid: gamma and rz are given together; they are the same angle, from the reference's orientation or at's"
        )
    off = given_from(mechanism, None, base).off_motion
    if off > 0.0:
        raise InputError(
            f"at: the pose lies off the {mechanism.motion} motion of {mechanism.name}'s platform by {off:.3g} {mechanism.length_unit}, "
            "so that no point has a solution; allowed: poses of that motion"
        )
    _check_conditions(mechanism, base, values)


def _check_conditions(mechanism: Mechanism, base: Sequence[float], values: Mapping[str, np.ndarray]) -> None:
    swept = [name for name, v in values.items() if v[-1] > v[0]]
    freedoms = generic_ranks(mechanism).outputs
    coordinates = sum(c.freedom for c in build_closure(mechanism).role("pose"))
    if not swept or freedoms >= coordinates:
        return
    held = pose_at(mechanism, base, {name: float(v[0]) for name, v in values.items() if name not in swept})
    box = tuple(_side(mechanism, name, values[name]) for name in swept)
    if poses_vary(mechanism, (*held.position.tolist(), *held.quaternion.tolist()), box) is False:
        instead = "actuated joints (without --poses)"
        raise InputError(f"grid: {condition_sentence(mechanism, _listed(swept), instead, freedoms, coordinates)}")


def _side(mechanism: Mechanism, name: str, values: np.ndarray) -> tuple[str, float, float]:
    """A swept coordinate by the closure's name, its bounds in length units and rad."""
    low, high = float(values[0]), float(values[-1])
    if name in "xyz":
        return name, low, high
    own = "gamma" if mechanism.motion in ("schoenflies", "planar") else name
    return own, mechanism.angle_in(low), mechanism.angle_in(high)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
