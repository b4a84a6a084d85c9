"""Bring a description to the machine that it means: what geometry says is not left to how it is
written.

A platform that its joints leave a plane has that motion, z normal to it, wherever the plane stands;
one that they leave to turn about a point has that motion; two revolute joints whose axes meet are a
universal joint, three at right angles a ball; a chain of driven joints is an arm; a graph that is
limbs, and limbs with named points, are limbs. The machine has the links, the actuated joints and
the values of the description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from symkin.computed_once import lru_cache
from symkin.machine.frame import Frames, with_own_frame
from symkin.machine.limbs import limbs_of
from symkin.machine.motion import Guide, with_own_motion, without_guides
from symkin.machine.universal import BallReading, Reading, with_universal_joints
from symkin.model.arm import arm_of
from symkin.model.joint import BASE
from symkin.model.machine import Machine
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose


@dataclass(frozen=True, eq=False)
class Lowered:
    """The machine of a description, which may be itself, its frames (None: those of the
    description), what coordinates of the description read that it has not, what it calls links
    whose names differ, and the guides that it does without.
    """

    written: Mechanism
    machine: Mechanism
    frames: Frames | None = None
    readings: tuple[Reading | BallReading, ...] = ()
    links: Mapping[str, str] = field(default_factory=dict)
    guides: tuple[Guide, ...] = ()

    @property
    def is_written(self) -> bool:
        """Whether the machine is the description itself."""
        return self.machine is self.written

    def taken(self, pose: Pose) -> Pose:
        """A pose of the description as the machine has it."""
        return pose if self.frames is None else self.frames.taken(pose)

    def told(self, pose: Pose) -> Pose:
        """A pose of the machine as the description has it."""
        return pose if self.frames is None else self.frames.told(pose)


@lru_cache(maxsize=128)
def lowered(
    mechanism: Mechanism,
    given: frozenset[str] = frozenset(),
    *,
    pose: bool = True,
    kept: frozenset[str] = frozenset(),
) -> Lowered | None:
    """The machine of a description whose coordinates `given` stay, as those `kept`, and whose
    platform's `pose` is a coordinate or not; None where it is the description itself. A graph is
    the limbs that it is where all of its driven joints, or the whole pose, are given.
    """
    bare = _without_points(mechanism)
    whole = pose if not given else given == {c.name for c in mechanism.actuated}
    arm = arm_of(bare) if whole else None
    if arm is not None and {c.name for c in arm.coordinates} >= {c.name for c in bare.coordinates}:
        return Lowered(mechanism, arm)
    limbs, links = limbs_of(bare) if whole else (bare, {})
    plain = mechanism if limbs.is_graph else limbs
    placed, frames = with_own_motion(plain, declare=pose or not plain.is_graph)
    alone, guides = without_guides(placed) if whole else (placed, ())
    machine, readings = with_universal_joints(alone, given | kept)
    if machine is mechanism:
        return None
    return Lowered(mechanism, machine, frames, readings, links, guides)


def posed(mechanism: Mechanism) -> Lowered:
    """The machine of a description whose pose is known, which may be the description itself."""
    return lowered(mechanism) or Lowered(mechanism, mechanism)


@lru_cache(maxsize=128)
def arm_or_limbs(mechanism: Mechanism) -> Lowered | None:
    """A description as the arm or the limbs that it is, in its own frame and motion; None of other
    graphs.
    """
    arm = arm_of(mechanism)
    machine, links = limbs_of(mechanism) if arm is None else (arm, {})
    return None if machine.is_graph else Lowered(mechanism, machine, links=links)


@lru_cache(maxsize=128)
def lowered_limbs(mechanism: Mechanism) -> Lowered:
    """The machine of a description as limbs, whose passive joints are told where they have limits
    only: a graph that is limbs is these, a limb that does nothing but guide the platform in its
    motion is gone, it stands in the frame in which its numbers are simplest, and its limbs are laid
    along axes.
    """
    placed, frames = with_own_motion(limbs_of(mechanism)[0], declare=True)
    kept = frozenset(c.name for c in mechanism.coordinates if c.limits is not None)
    machine, readings = with_universal_joints(without_guides(placed)[0], kept)
    if frames is None:
        machine, frames = with_own_frame(machine)
    if any(limb.joints for limb in machine.limbs):
        machine = Machine.of(machine, laid=True)
    return Lowered(mechanism, machine, frames, readings)


def _without_points(mechanism: Mechanism) -> Mechanism:
    """The mechanism without named points, where these are of the base and the platform, which are
    placed anyway.
    """
    placed = {BASE, mechanism.platform_link}
    if not mechanism.link_points or not {p.link for p in mechanism.link_points} <= placed:
        return mechanism
    return replace(mechanism, link_points=())
