"""The closure of a robot: where the links of its tree are, and the rows of its closures and
couplings, over all coordinates of the tree.

Displacements are products of exponentials, rows those of joints that loops are cut at
(`closure.rows`). A closure may be open in the file: the constant displacement from its first frame
to its second moves what the second link carries. A link that hangs on no joint moves freely, by
three slides and a ball.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closure.chain import Ball, Chain, JointSymbols, Side, Turn, relative_sides
from symkin.closure.closure import nonzero_rows
from symkin.closure.parameters import ParameterTable
from symkin.closure.rows import Cut, rows_of_joint
from symkin.closure.written_once import written_once
from symkin.computed_once import cached_property
from symkin.formats.robot import Robot, RobotJoint
from symkin.model.graph import Coupling
from symkin.model.joint import BASE, Coordinate, Joint
from symkin.numeric.mapped import Mapped
from symkin.numeric.system import NOTHING, System
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply, rotate

STILL = Chain(())
"""Where the base is."""
_ONE_POINT = 1e-12
"""Of the largest coordinate: points that are this near are one to the rounding of their poses."""


@dataclass(frozen=True)
class _Hung:
    """A link, the one that carries it, and the joints between them with their coordinates."""

    carrier: str
    link: str
    joints: tuple[tuple[JointSymbols, tuple[Coordinate, ...]], ...]

    @staticmethod
    def of(links: Sequence[str], joints: Iterable[Joint], *, backward: bool = False) -> _Hung:
        """The second link by joints, which lead the other way in the mechanism where they are
        `backward`.
        """
        own = ((_symbols_of(j), tuple(_seen_from(j, backward=backward))) for j in joints)
        return _Hung(links[0], links[1], tuple(own))


@dataclass(frozen=True, eq=False)
class Tree:
    """The tree of a robot, with its closures; a configuration holds the values of `coordinates`,
    balls by the quaternion from the file's configuration.
    """

    robot: Robot

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        return tuple(c for hung in self._hung for _, own in hung.joints for c in own)

    @cached_property
    def own(self) -> np.ndarray:
        """The file's own configuration."""
        return np.array([value for c in self.coordinates for value in c.reference])

    @property
    def freedom(self) -> int:
        """Independent ways in which the coordinates change."""
        return self.system.freedom

    @cached_property
    def size(self) -> float:
        """The diagonal of the box around joints, closures and frames at the file's configuration
        (metres), by which angles become lengths; 1 where all of them are one point.
        """
        joints = (entry.joint for entry in self.robot.tree)
        frames = [frame for entry in self.robot.joints for frame in entry.frames or ()]
        points = [joint.point for joint in joints if joint.type not in ("P", "weld")]
        box = np.array([*points, *(frame.position for frame in frames)]).reshape(-1, 3)
        if not len(box):
            return 1.0
        spread = float(np.linalg.norm(np.ptp(box, axis=0)))
        return spread if spread > _ONE_POINT * float(np.abs(box).max()) else 1.0

    @cached_property
    def system(self) -> System:
        """The rows of all closures and couplings with every coordinate unknown."""
        rows = [row for _, found, _ in self._parts for row in found]
        errors = [error for _, _, found in self._parts for error in found]
        return System(
            self.coordinates,
            ca.vertcat(ca.SX(0, 1), *self._symbols.values()),
            ca.SX(0, 1),
            ca.vertcat(ca.SX(0, 1), *rows),
            ca.vertcat(ca.SX(0, 1), *errors),
            self.size,
        )

    @cached_property
    def constraints(self) -> System:
        """The same without the rows of rounding that two hinges with one axis leave."""
        rows = self.system.rows
        kept = nonzero_rows(lambda z: self.system.linearise_one(z)[0], self.coordinates, self.size)
        return replace(self.system, rows=rows[list(kept), 0])

    def misfits(self, values: np.ndarray) -> dict[str, float]:
        """What each closure and coupling leaves open (metres), by its name."""
        (errors,) = self.system.checks(values[None], NOTHING)
        ends = np.cumsum([0, *(len(found) for _, _, found in self._parts)])
        return {
            name: float(np.linalg.norm(errors[begin:end]))
            for (name, _, _), begin, end in zip(self._parts, ends[:-1], ends[1:], strict=True)
        }

    def displacements(self, values: np.ndarray) -> dict[str, Pose]:
        """How all links are displaced from the file's configuration."""
        (numbers,) = self._poses(values[None], NOTHING)
        return {
            link: Pose(own[:3], own[3:])
            for link, own in zip(self._sides, numbers[0].reshape(-1, 7), strict=True)
        }

    def by_name(self, values: np.ndarray) -> dict[str, tuple[float, ...]]:
        """The values of each coordinate."""
        return {
            c.name: tuple(map(float, values[place]))
            for c, place in zip(self.coordinates, self.system.slices, strict=True)
        }

    @cached_property
    def _poses(self) -> Mapped:
        found = {BASE: Pose(ca.SX(3, 1), ca.SX([1, 0, 0, 0]))}
        for hung in self._hung:
            at = found[hung.carrier]
            before = len(self._sides[hung.carrier].steps)
            for step in self._sides[hung.link].steps[before:]:
                moved = rotate(at.quaternion, step.move(ca.SX(3, 1))) + at.position
                at = Pose(moved, multiply(at.quaternion, step.quaternion))
            found[hung.link] = at
        numbers = [part for pose in found.values() for part in (pose.position, pose.quaternion)]
        return Mapped.of([self.system.unknown, self.system.known], [ca.vertcat(*numbers)])

    @cached_property
    def _symbols(self) -> dict[str, ca.SX]:
        return {c.name: ca.SX.sym(c.name, c.width) for c in self.coordinates}

    @cached_property
    def _sides(self) -> dict[str, Chain]:
        """Links by the joints that lead to them from the base."""
        found = {BASE: STILL}
        for hung in self._hung:
            found[hung.link] = found[hung.carrier].extended(
                [
                    step
                    for symbols, own in hung.joints
                    for step in symbols.steps([self._symbols[c.name] for c in own])
                ]
            )
        return found

    @cached_property
    def _parts(self) -> list[tuple[str, list[ca.SX], list[ca.SX]]]:
        """Rows and checks of each closure and coupling, by its name."""
        closures = [(c.joint.name, *self._closure_rows(c)) for c in self.robot.closures]
        couplings = [(f"coupling of {c.joint}", c) for c in self.robot.couplings]
        gaps = [(name, [self._coupling_row(coupling)]) for name, coupling in couplings]
        return [*closures, *((name, gap, gap) for name, gap in gaps)]

    def _closure_rows(self, closure: RobotJoint) -> tuple[list[ca.SX], list[ca.SX]]:
        first, last = (self._sides[link] for link in closure.links)
        near, far = closure.frames or (Pose.identity(),) * 2
        gap = far @ near.inverse()
        return rows_and_checks(closure.joint, gap, self.size, *relative_sides(first, last))

    def _coupling_row(self, coupling: Coupling) -> ca.SX:
        """joint - sum of factor x other - offset, or joint - polynomial of the other; angles times
        the size.
        """
        (own,) = (c for c in self.coordinates if c.name == coupling.joint)
        return own.lever(self.size) * (self._symbols[own.name] - coupling.value(self._symbols))

    @cached_property
    def _hung(self) -> tuple[_Hung, ...]:
        """The links in an order in which each stands after the one that carries it."""
        robot = self.robot
        return (
            *(_free(link, robot.links[link]) for link in robot.floating),
            *(_Hung.of(e.links, [e.joint], backward=e.backward) for e in robot.tree),
        )


def rows_and_checks(
    joint: Joint, gap: Pose, size: float, base: Side = STILL, other: Side = STILL
) -> tuple[list[ca.SX], list[ca.SX]]:
    """What vanishes where a joint between two sides is closed, the second of which is displaced by
    a `gap` while all its own joints stand still.
    """
    away = ca.SX(ca.DM(gap.position))
    steps = (Turn(away, away, None, ca.SX(1)), Ball(ca.SX(3, 1), ca.SX(ca.DM(gap.quaternion))))
    found = written_once(
        rows_of_joint, Cut.of(_symbols_of(joint)), base, other.extended(steps), ca.SX(size)
    )
    return (
        [row for _, rows, _ in found for row in rows],
        [error for _, _, errors in found for error in errors],
    )


def _symbols_of(joint: Joint) -> JointSymbols:
    """The joint's geometry as numbers."""
    return JointSymbols.declare(joint, joint.name, ParameterTable(bound=True))


def _seen_from(joint: Joint, *, backward: bool) -> Iterator[Coordinate]:
    """The coordinates of a joint in the order in which it moves, with the names that they have as
    seen from its second link where it is `backward`: the last turn of a universal joint comes first
    there.
    """
    names = [c.name for c in joint.coordinates]
    if backward and joint.type == "U":
        names.reverse()
    for coordinate, name in zip(joint.coordinates, names, strict=True):
        yield replace(coordinate, name=name)


def _free(link: str, frame: Pose) -> _Hung:
    """Three slides and a ball about the link's origin."""
    point = tuple(frame.position)
    slides = [
        Joint(f"{link}.{key}", "P", point, axis)
        for key, axis in zip("xyz", np.eye(3).tolist(), strict=True)
    ]
    return _Hung.of((BASE, link), [*slides, Joint(f"{link}.turn", "S", point)])
