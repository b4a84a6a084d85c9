"""All that a mechanism file says, and what follows from it at once: its joints, rods and
coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from symkin.computed_once import cached_property
from symkin.model.bar import Bar
from symkin.model.dh import DHTable
from symkin.model.graph import Coupling, LinkJoint, LinkPoint, LinkRod
from symkin.model.joint import BASE, PLATFORM, Coordinate, Joint, finite
from symkin.model.keys import Motion
from symkin.model.limb import Limb, RodLimb
from symkin.model.mesh import LinkMesh
from symkin.spatial.pose import Pose


@dataclass(frozen=True)
class Example:
    """A worked example of a mechanism, used where no input is given; in the mechanism's own units.

    `joints` (actuated values in file order), `pose` (x, y, z, qw, qx, qy, qz) or `given` (pairs of
    a coordinate's name and its value); `start` is where a solve begins: a pose with `joints`, else
    actuated values. Raises MechanismError for a number that is not finite; whether they fit is
    checked by the Mechanism that holds them.

    >>> import symkin
    >>> symkin.load("zhang2009").example.joints[:3]
    (144.6, 347.0, 110.3)
    """

    joints: tuple[float, ...] | None = None
    pose: tuple[float, ...] | None = None
    given: tuple[tuple[str, float], ...] | None = None
    start: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        for key in ("joints", "pose", "start"):
            for k, value in enumerate(getattr(self, key) or ()):
                finite(value, f"example.{key}[{k}]")
        for name, value in self.given or ():
            finite(value, f"example.given.{name}")


@dataclass(frozen=True)
class Description:
    """The parts of a mechanism, which `Mechanism` checks."""

    name: str
    limbs: Sequence[Limb | RodLimb] = ()
    platform_position: Sequence[float] = (0.0, 0.0, 0.0)
    platform_quaternion: Sequence[float] = (1.0, 0.0, 0.0, 0.0)
    motion: Motion = "spatial"
    length_unit: Literal["m", "mm"] = "mm"
    angle_unit: Literal["deg", "rad"] = "rad"
    title: str = ""
    source: str = ""
    serial: bool = False
    dh: DHTable | None = None
    example: Example | None = None
    link_joints: Sequence[LinkJoint] = ()
    link_rods: Sequence[LinkRod] = ()
    couplings: Sequence[Coupling] = ()
    link_points: Sequence[LinkPoint] = ()
    platform_link: str | None = PLATFORM
    link_meshes: Sequence[LinkMesh] = field(default=(), compare=False)

    @cached_property
    def is_graph(self) -> bool:
        """Whether links are joined in other ways than by limbs from the base to the platform."""
        other_limbs = any(limb.links != (BASE, PLATFORM) for limb in self.limbs)
        return bool(
            self.link_joints or self.link_rods or self.couplings or self.link_points or other_limbs
        )

    @property
    def frame_name(self) -> str:
        """What the frame is called whose pose is found: the tool's of an arm, else the
        platform's.
        """
        return "tool" if self.serial else "platform"

    def key_path(self, limb: Limb | RodLimb, joint: Joint) -> str:
        """The key path of a joint's numbers: the joints of an arm stand in no limb."""
        return joint.name if self.serial else f"{limb.name}.{joint.name}"

    @property
    def reference_pose(self) -> Pose:
        """Pose of the platform or tool at the reference configuration."""
        return Pose(np.array(self.platform_position), np.array(self.platform_quaternion))

    @property
    def joints(self) -> Iterator[tuple[Limb | RodLimb, Joint]]:
        """All joints of limbs, in file order."""
        return ((limb, joint) for limb in self.limbs for joint in limb.joints)

    @property
    def all_joints(self) -> Iterator[Joint]:
        """The joints of limbs, then those between links, in file order."""
        yield from (joint for _, joint in self.joints)
        yield from (entry.joint for entry in self.link_joints)

    @cached_property
    def bars(self) -> tuple[Bar, ...]:
        """The rods of limbs, then those between links, in file order."""
        pose = self.reference_pose
        return (
            *(bar for limb in self.limbs for bar in limb.bars(pose)),
            *(rod.bar for rod in self.link_rods),
        )

    @property
    def rod_ends(self) -> list[np.ndarray]:
        """Both ends of each rod in the base frame at the reference."""
        return [place for bar in self.bars for place in bar.places]

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Every coordinate of joints and actuated rods in file order: those of limbs, then of
        joints and of rods between links. Angles of `advancing` couplings are no angles modulo a
        turn: a whole turn of one gear is none of the other.
        """
        advancing = self.advancing
        return tuple(
            replace(c, kind="turns") if c.is_periodic and c.name in advancing else c
            for c in self._as_described
        )

    @cached_property
    def _as_described(self) -> tuple[Coordinate, ...]:
        """Every coordinate, couplings left aside."""
        parts: list[Joint | Bar] = []
        for limb in self.limbs:
            parts += limb.joints
            parts += limb.bars(self.reference_pose)
        parts += [entry.joint for entry in self.link_joints]
        parts += [rod.bar for rod in self.link_rods]
        return tuple(c for part in parts for c in part.coordinates)

    @cached_property
    def advancing(self) -> Mapping[str, str]:
        """Why angles that couplings name advance without end, by their names; an angle coupled to
        one that advances does too.
        """
        kinds: dict[str, str] = {c.name: c.kind for c in self._as_described}
        naming: dict[str, list[Coupling]] = {}
        todo: list[tuple[str, Coupling]] = []
        for coupling in self.couplings:
            for name in (coupling.joint, *coupling.names):
                naming.setdefault(name, []).append(coupling)
            reason = coupling.advance_reason(kinds)
            todo += [] if reason is None else [(reason, coupling)]
        found: dict[str, str] = {}
        while todo:
            reason, coupling = todo.pop()
            for name in (coupling.joint, *coupling.names):
                if kinds.get(name) == "angle" and name not in found:
                    found[name] = reason
                    todo += [(reason, other) for other in naming[name]]
        return found

    @cached_property
    def actuated(self) -> tuple[Coordinate, ...]:
        """Actuated coordinates in file order: the order of `--joints`."""
        return tuple(c for c in self.coordinates if c.role == "actuated")

    @cached_property
    def pitches(self) -> Mapping[str, float]:
        """Lengths per turn of the coordinates of helical joints, by their names."""
        return {
            c.name: joint.pitch
            for joint in self.all_joints
            if joint.type == "H"
            for c in joint.coordinates
        }

    def angle_out(self, radians: float) -> float:
        """From radians to the mechanism's angle unit."""
        return math.degrees(radians) if self.angle_unit == "deg" else radians

    def angle_in(self, value: float) -> float:
        """From the mechanism's angle unit to radians."""
        return math.radians(value) if self.angle_unit == "deg" else value

    def value_out(self, coordinate: Coordinate, value: float) -> float:
        """A coordinate's value in the mechanism's units, from radians and the length unit."""
        return self.angle_out(value) if coordinate.is_angular else value

    def value_in(self, coordinate: Coordinate, value: float) -> float:
        """A coordinate's value in radians and the length unit, from the mechanism's units."""
        return self.angle_in(value) if coordinate.is_angular else value

    def unit_of(self, coordinate: Coordinate) -> str:
        """The mechanism's unit of a coordinate that is one number."""
        return self.angle_unit if coordinate.is_angular else self.length_unit

    @property
    def units(self) -> dict[str, float]:
        """The unit of each coordinate in its file, by name: radians of a degree, or 1."""
        return {c.name: self.value_in(c, 1.0) for c in self.coordinates}
