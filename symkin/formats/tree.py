"""The closure of a robot over all coordinates of its tree: where its links are, the rows of its
closures and couplings, by the rules of any machine's (`closure.rows`), and the closed configuration
that is nearest to the file's own.

Joints of the tree carry links, whatever their types; loops are cut where the file closes them, open
by the constant displacement from a closure's first frame to its second. A link that hangs on no
joint moves freely, by three slides and a ball.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import casadi as ca
import numpy as np

from symkin.closure.closure import nonzero_rows
from symkin.closure.link_frames import side_frames
from symkin.closure.rows import RowBuilder
from symkin.computed_once import cached_property
from symkin.formats.robot import Robot
from symkin.model.graph import LinkJoint
from symkin.model.joint import BASE, Coordinate, Joint
from symkin.model.machine import Machine
from symkin.numeric.mapped import Mapped
from symkin.numeric.nearest_root import NearestRoot
from symkin.numeric.system import NOTHING, System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION, FILE_DIGITS
from symkin.spatial.backend import stacked
from symkin.spatial.pose import Pose

_ONE_POINT = 1e-12
"""Of the largest coordinate: points that are this near are one to the rounding of their poses."""


@dataclass(frozen=True, eq=False)
class Tree:
    """The tree of a robot, with its closures; a configuration holds the values of `coordinates`,
    balls by the quaternion from the file's configuration.
    """

    robot: Robot

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        return self.system.unknowns

    @property
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
        points = [joint.point for joint in joints if joint.type not in ("P", "weld")]
        points += [frame.position for entry in self.robot.closures for frame in entry.frames]
        box = np.array(points).reshape(-1, 3)
        if not len(box):
            return 1.0
        spread = float(np.linalg.norm(np.ptp(box, axis=0)))
        return spread if spread > _ONE_POINT * float(np.abs(box).max()) else 1.0

    @cached_property
    def system(self) -> System:
        """The rows of all closures and couplings with every coordinate unknown."""
        own, nothing = self._rows, ca.SX(0, 1)
        return System(
            tuple(c for c, _ in own.coordinates.values()),
            stacked(symbol for _, symbol in own.coordinates.values()),
            nothing,
            stacked(own.rows),
            stacked(own.errors),
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
        sources = np.array([source.limb for source in self._rows.error_sources])
        names = dict.fromkeys(sources.tolist())
        return {name: float(np.linalg.norm(errors[sources == name])) for name in names}

    def displacements(self, values: np.ndarray) -> dict[str, Pose]:
        """How all links are displaced from the file's configuration."""
        (numbers,) = self._poses(values[None], NOTHING)
        return {
            link: Pose(own[:3], own[3:])
            for link, own in zip(self._rows.bodies, numbers[0].reshape(-1, 7), strict=True)
        }

    def by_name(self, values: np.ndarray) -> dict[str, tuple[float, ...]]:
        """The values of each coordinate."""
        return {
            c.name: tuple(map(float, values[place]))
            for c, place in zip(self.coordinates, self.system.slices, strict=True)
        }

    @cached_property
    def _poses(self) -> Mapped:
        frames = side_frames([*self._rows.bodies.values()])
        return Mapped.of([self.system.unknown, self.system.known], [ca.vertcat(*frames)])

    @cached_property
    def _rows(self) -> RowBuilder:
        """The rows of the robot as a machine that its file leaves open; whole turns of a joint are
        none of what is coupled to it.
        """
        robot = self.robot
        gaps = tuple(
            (entry.joint.name, (*map(float, [*entry.gap.position, *entry.gap.quaternion]),))
            for entry in robot.closures
        )
        free = (joint for link in robot.floating for joint in _free(link, robot.links[link]))
        machine = Machine(
            robot.name,
            link_joints=(*free, *robot.joints),
            couplings=tuple(replace(c, advances=True) for c in robot.couplings),
            platform_link=None,
            gaps=gaps,
            size=self.size,
        )
        rows = RowBuilder(machine, bound=True)
        rows.build_rows()
        return rows


def _free(link: str, frame: Pose) -> Iterator[LinkJoint]:
    """Three slides and a ball about the link's origin, from the base."""
    point = tuple(frame.position)
    joints = [
        *(Joint(f"{link}.{'xyz'[k]}", "P", point, tuple(np.eye(3)[k])) for k in range(3)),
        Joint(f"{link}.turn", "S", point),
    ]
    links = (BASE, *(f"{joint.name}.link" for joint in joints[:-1]), link)
    return (LinkJoint(joint, pair) for joint, pair in zip(joints, pairwise(links), strict=True))


@dataclass(frozen=True, eq=False)
class Closed:
    """The closed configuration of a robot that is nearest to the file's own, or what comes nearest
    to one: `state` holds the values of the tree's coordinates.

    `displacements` move links from their places in the file. `gaps` tell what each closure and
    coupling leaves open in the file, `residuals` what it leaves here (metres).
    """

    tree: Tree
    state: np.ndarray

    @cached_property
    def gaps(self) -> Mapping[str, float]:
        return self.tree.misfits(self.tree.own)

    @cached_property
    def residuals(self) -> Mapping[str, float]:
        return self.tree.misfits(self.state)

    @property
    def open_by(self) -> float:
        """How far the file's own configuration leaves the loops open."""
        return max(self.gaps.values(), default=0.0)

    @property
    def residual(self) -> float:
        """The largest closure error left."""
        return max(self.residuals.values(), default=0.0)

    @property
    def resists(self) -> str:
        """The closure or coupling that has it."""
        return max(self.residuals, key=lambda name: self.residuals[name], default="")

    @property
    def closed(self) -> bool:
        return self.residual <= CLOSED_CONFIGURATION * self.tree.size

    @property
    def to_digits(self) -> bool:
        """Whether the loops close, if only to the digits of a file."""
        return self.residual <= FILE_DIGITS * self.tree.size

    @cached_property
    def values(self) -> dict[str, tuple[float, ...]]:
        """Of every coordinate, in radians and metres; the quaternion of a ball from the file's
        configuration.
        """
        return self.tree.by_name(self.state)

    @cached_property
    def displacements(self) -> dict[str, Pose]:
        return self.tree.displacements(self.state)


def nearest_closed(robot: Robot) -> Closed:
    """Close the loops from the file's own configuration."""
    tree = Tree(robot)
    return Closed(tree, NearestRoot(tree.system, tree.own).found())
