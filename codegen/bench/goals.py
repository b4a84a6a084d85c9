"""Where the goals of lines lie: at random about home, near to as far as the joints go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.codegen.map.program import Kind
from symkin.codegen.map.rod_platform import RodPlatform
from symkin.codegen.serial_arm import SerialArm
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply


@dataclass(frozen=True)
class Reach:
    """How far goals lie from home: positions of poses or sliding joints (a part of the size),
    rotations (rad).
    """

    part: float
    turn: float


SMALL, MIDDLE, WIDEST = Reach(0.05, 0.2), Reach(0.15, 0.6), Reach(0.5, np.pi)
"""The widest: whole turns, and half of the size or, where a joint has limits, all of them."""
POSES = {SMALL: Reach(0.1, 0.25), MIDDLE: Reach(180.0 / 531.2592, 1.0), WIDEST: WIDEST}
"""The same for platforms on six rods, whose goals are those of poses."""


def goals_about(kind: Kind, count: int, reach: Reach, rng: np.random.Generator) -> np.ndarray:
    """Joint values (count, joints): of poses about home, or about the reference's joint values;
    kept within limits. Of arms the tool's poses (count, 7) at such joint values.
    """
    size, joints = kind.mechanism.characteristic_length, kind.mechanism.actuated
    if isinstance(kind, RodPlatform):
        poses = POSES.get(reach, reach)
        goals = np.array(
            [kind.lengths(_pose_about(kind.home, poses, size, rng)) for _ in range(count)]
        )
    else:
        middle = np.array([c.reference[0] for c in joints])
        spread = np.array([reach.turn if c.is_angular else reach.part * size for c in joints])
        goals = middle + spread * rng.uniform(-1, 1, (count, len(joints)))
    for i, c in enumerate(joints):
        if c.limits is not None:
            low, high = c.limits
            goals[:, i] = (
                rng.uniform(low, high, count)
                if reach == WIDEST
                else np.clip(goals[:, i], low, high)
            )
    return np.array([kind.forward_at(q) for q in goals]) if isinstance(kind, SerialArm) else goals


def goals_anywhere(mechanism: Mechanism, count: int, rng: np.random.Generator) -> np.ndarray:
    """Joint values (count, joints) of an arm all over their ranges; whole turns and a third of the
    size where there is none.
    """
    third = mechanism.characteristic_length / 3
    spans = [
        c.limits or ((-np.pi, np.pi) if c.is_angular else (-third, third))
        for c in mechanism.actuated
    ]
    low, high = np.array(spans).T
    return np.asarray(rng.uniform(low, high, (count, len(spans))))


def _pose_about(home: Pose, reach: Reach, size: float, rng: np.random.Generator) -> Pose:
    shift = reach.part * size * rng.uniform(-1, 1, 3)
    turn = rng.uniform(-reach.turn, reach.turn, 3)
    angle = float(np.linalg.norm(turn))
    q = multiply(
        np.array([np.cos(angle / 2), *(np.sin(angle / 2) / angle * turn)]),
        np.asarray(home.quaternion),
    )
    return Pose(np.asarray(home.position) + shift, np.asarray(q))
