"""Bring a description to the machine that it means: what geometry says is not left to how it is
written.

A platform that its joints leave a plane has that motion, z normal to it, wherever the plane stands;
one that they leave to turn about a point has that motion; two revolute joints whose axes meet are a
universal joint. The machine has the links, the actuated joints and the values of the description.
"""

from __future__ import annotations

from dataclasses import dataclass

from symkin.computed_once import lru_cache
from symkin.machine.motion import with_own_motion
from symkin.machine.universal import Reading, with_universal_joints
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose


@dataclass(frozen=True, eq=False)
class Lowered:
    """The machine of a description: its base frame turned by `turn` (None: as it is), and what
    coordinates of the description read that it has not.
    """

    written: Mechanism
    machine: Mechanism
    turn: Pose | None
    readings: tuple[Reading, ...]


@lru_cache(maxsize=128)
def lowered(
    mechanism: Mechanism, kept: frozenset[str] = frozenset(), *, pose: bool = True
) -> Lowered | None:
    """The machine of a description whose coordinates `kept` stay, since they are given, and whose
    platform's `pose` is a coordinate or not; None where it is the description itself.
    """
    placed, turn = with_own_motion(mechanism, declare=pose)
    machine, readings = with_universal_joints(placed, kept)
    return None if machine is mechanism else Lowered(mechanism, machine, turn, readings)
