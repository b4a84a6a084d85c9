"""Where the joints of a limb stand at the reference, and where its slides begin and end: NumPy
only, base frame, length unit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby

import numpy as np

from symkin.model.joint import Joint
from symkin.model.limb import AnyLimb
from symkin.model.mechanism import Mechanism

_SAME = 1e-9
"""Extent over the size below which joints meet in one point."""


def joint_places(mechanism: Mechanism, *, loops: bool) -> dict[str, np.ndarray]:
    """A point on each joint; where the joints of `loops` meet in one point (a spherical mechanism),
    points of their axes at the distance `size` from it stand for them.
    """
    places, size = dict(mechanism.places), mechanism.characteristic_length
    joints = list(mechanism.all_joints)
    held = [places[joint.name] for joint in joints if joint.type != "P"]
    apart = not held or np.ptp(held, axis=0).max() > _SAME * size
    if not loops or mechanism.bars or apart:
        return places
    return {
        joint.name: places[joint.name] + size * np.array(joint.axis or (0.0, 0.0, 0.0))
        for joint in joints
    }


def slide_routes(
    mechanism: Mechanism, limb: AnyLimb, places: Mapping[str, np.ndarray]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Begin and end of each P joint of a limb: along their axes, one after the other, from the
    joint before to the joint behind, after what the axes cannot cover.
    """
    found: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    runs = [list(run) for _, run in groupby(limb.joints, key=lambda joint: joint.type == "P")]
    for number, run in enumerate(runs):
        if run[0].type != "P":
            continue
        before = places[runs[number - 1][-1].name] if number else None
        behind = places[runs[number + 1][0].name] if number + 1 < len(runs) else None
        start, end = _ends(mechanism, limb, run, before, behind)
        axes = np.array([joint.axis for joint in run])
        shares = np.linalg.lstsq(axes.T, end - start, rcond=None)[0]
        begin = end - shares @ axes
        for joint, share, axis in zip(run, shares, axes, strict=True):
            found[joint.name] = (begin, begin + share * axis)
            begin = begin + share * axis
    return found


def _ends(
    mechanism: Mechanism,
    limb: AnyLimb,
    run: Sequence[Joint],
    before: np.ndarray | None,
    behind: np.ndarray | None,
) -> tuple[np.ndarray, np.ndarray]:
    """From where and to where P joints lead. At the base it is the point of their rails nearest
    their own point, at the platform the one nearest its origin, or where its rods begin.
    """
    origin = np.array(mechanism.platform_position)
    starts = [bar.start.point for bar in limb.bars(mechanism.reference_pose)]
    end = np.asarray(np.mean(starts, axis=0)) if starts else origin
    if before is None:
        end = end if behind is None else behind
        own = mechanism.places[run[0].name]
        return _beside(own, end, run), end
    if behind is None:
        alone = len(mechanism.limbs) == 1  # holds the frame, to which it leads
        return before, end if starts or alone else _beside(origin, before, run)
    return before, behind


def _beside(anchor: np.ndarray, target: np.ndarray, rails: Sequence[Joint]) -> np.ndarray:
    """The point nearest `anchor` from which the rails' axes lead to `target`."""
    u, s, _ = np.linalg.svd(np.array([rail.axis for rail in rails]).T, full_matrices=False)
    basis = u[:, s > 1e-9]
    away = target - anchor
    return anchor + away - basis @ (basis.T @ away)
