"""Where the links of a robot's tree are for given joint values: products of exponentials, in
numbers and in CasADi's expressions.

A joint is one or two steps (a turn, a slide, a screw) or a ball; a link that hangs on no joint
moves freely, as a ball and three slides. The state of a ball is its unit quaternion, of every other
step a number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import casadi as ca
import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import MechanismError
from symkin.formats.robot import Robot
from symkin.model.joint import BASE, Joint
from symkin.spatial.backend import Array, is_casadi
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import (
    matrix_from_quaternion,
    multiply,
    normalized,
    quaternion_from_axis_angle,
    quaternion_from_rotation_vector,
    rotation_vector_from_quaternion,
)

_AXES = np.eye(3)
_ONE_POINT = 1e-12
"""Of the largest coordinate: points that are this near are one to the rounding of their poses."""


@dataclass(frozen=True, eq=False)
class Step:
    """One elementary motion, in the base frame at the file's configuration: a turn about an axis
    with a slide of `lead` a radian, a slide along it, or a ball about its point. `name` is its
    coordinate's, `zero` its value at the file's configuration.
    """

    name: str
    kind: Literal["turn", "slide", "ball"]
    point: np.ndarray
    axis: np.ndarray
    lead: float = 0.0
    zero: float = 0.0

    @property
    def freedom(self) -> int:
        return 3 if self.kind == "ball" else 1

    def displacement(self, value: Array) -> tuple[Array, Array]:
        """Rotation and translation of its value: a number, or the quaternion of a ball."""
        if self.kind == "ball":
            turn = matrix_from_quaternion(value)
            return turn, self.point - turn @ self.point
        amount = value[0] - self.zero
        if self.kind == "slide":
            return ca.SX.eye(3) if is_casadi(value) else _AXES, amount * self.axis
        turn = matrix_from_quaternion(quaternion_from_axis_angle(self.axis, amount))
        return turn, self.point - turn @ self.point + self.lead * amount * self.axis


def steps_of(joint: Joint) -> list[Step]:
    """The elementary motions of a joint in their order, the first nearest to the joint's first
    link.
    """
    point = np.array(joint.point)
    axis, axis2 = (np.zeros(3) if a is None else np.array(a) for a in (joint.axis, joint.axis2))
    names = [c.name for c in joint.coordinates]
    match joint.type:
        case "S":
            return [Step(names[0], "ball", point, axis)]
        case "P":
            return [Step(names[0], "slide", point, axis, zero=joint.zero)]
        case "C":
            return [Step(names[0], "turn", point, axis), Step(names[1], "slide", point, axis)]
        case "U":
            return [Step(names[0], "turn", point, axis), Step(names[1], "turn", point, axis2)]
        case "R" | "H":
            return [Step(names[0], "turn", point, axis, joint.pitch / (2.0 * np.pi), joint.zero)]
        case _:
            return []


def _seen_backward(joint: Joint) -> list[Step]:
    """The motions of a joint with the names that they have as seen from its second link: the last
    turn of a universal joint comes first there, turn and slide of a C joint are in any order."""
    steps = steps_of(joint)
    names = [step.name for step in steps]
    if joint.type == "U":
        names.reverse()
    return [replace(step, name=name) for step, name in zip(steps, names, strict=True)]


State = tuple[np.ndarray, ...]
"""The value of each step: one number, or four of a ball."""


@dataclass(frozen=True, eq=False)
class Placed:
    """Where all links are displaced to from the file's configuration, numbers or expressions."""

    rotations: Mapping[str, Array]
    translations: Mapping[str, Array]

    def displacement(self, link: str) -> Pose:
        return Pose.from_matrix(self.rotations[link], self.translations[link])

    def point(self, link: str, point: np.ndarray) -> Array:
        """Where a point of a link is."""
        return self.rotations[link] @ point + self.translations[link]

    def direction(self, link: str, direction: np.ndarray) -> Array:
        """A direction of a link."""
        return self.rotations[link] @ direction


@dataclass(frozen=True, eq=False)
class Tree:
    """The tree of a robot: its links behind the base in an order in which each stands after the one
    that carries it.
    """

    robot: Robot

    @cached_property
    def chains(self) -> tuple[tuple[str, str, tuple[int, ...]], ...]:
        """The link that carries, the link that is carried, and the numbers of the steps between
        them.
        """
        found: list[tuple[str, str, tuple[int, ...]]] = []
        numbers = iter(range(len(self.steps)))
        for carrier, link, steps in self._hung:
            found.append((carrier, link, tuple(next(numbers) for _ in steps)))
        return tuple(found)

    @cached_property
    def steps(self) -> tuple[Step, ...]:
        return tuple(step for _, _, steps in self._hung for step in steps)

    @cached_property
    def _hung(self) -> tuple[tuple[str, str, list[Step]], ...]:
        robot = self.robot
        found = [(BASE, link, _free_steps(link, robot.links[link])) for link in robot.floating]
        placed, waiting = {BASE, *robot.floating}, list(robot.joints)
        while waiting:
            ready = [entry for entry in waiting if entry.links[0] in placed]
            if not ready:
                raise MechanismError(
                    f"joint {waiting[0].joint.name!r}: its link {waiting[0].links[0]!r} hangs on "
                    f"nothing; the tree begins at {BASE!r}"
                )
            for entry in ready:
                backward = entry.joint.name in robot.turned
                steps = _seen_backward(entry.joint) if backward else steps_of(entry.joint)
                found.append((entry.links[0], entry.links[1], steps))
                if entry.links[1] in placed:
                    raise MechanismError(
                        f"joint {entry.joint.name!r}: the link {entry.links[1]!r} hangs on two "
                        f"joints of the tree; a loop is a closure"
                    )
                placed.add(entry.links[1])
            waiting = [entry for entry in waiting if entry not in ready]
        return tuple(found)

    @cached_property
    def places(self) -> tuple[slice, ...]:
        """The freedoms of each step."""
        ends = np.cumsum([step.freedom for step in self.steps])
        return tuple(
            slice(int(end) - step.freedom, int(end))
            for end, step in zip(ends, self.steps, strict=True)
        )

    @cached_property
    def freedom(self) -> int:
        return sum(step.freedom for step in self.steps)

    @cached_property
    def own(self) -> State:
        """The file's own configuration."""
        return tuple(
            np.array([1.0, 0.0, 0.0, 0.0]) if s.kind == "ball" else np.array([s.zero])
            for s in self.steps
        )

    @cached_property
    def angular(self) -> np.ndarray:
        """Which freedoms are angles."""
        return np.array(
            [step.kind != "slide" for step in self.steps for _ in range(step.freedom)], dtype=bool
        )

    @cached_property
    def size(self) -> float:
        """The diagonal of the box around joints, closures and frames at the file's configuration
        (metres), by which angles become lengths; 1 where all of them are one point.
        """
        points = np.array([*self._points]).reshape(-1, 3)
        if not len(points):
            return 1.0
        spread = float(np.linalg.norm(np.ptp(points, axis=0)))
        return spread if spread > _ONE_POINT * float(np.abs(points).max()) else 1.0

    @property
    def _points(self) -> list[np.ndarray]:
        robot = self.robot
        points = [
            np.array(e.joint.point) for e in robot.joints if e.joint.type not in ("P", "weld")
        ]
        return points + [
            np.asarray(frame.position) for c in robot.closures for frame in (c.first, c.second)
        ]

    def moved(self, state: State, step: np.ndarray) -> State:
        """A state after a step of all freedoms; a ball turns in the frame that carries it."""
        found = []
        for value, place, motion in zip(state, self.places, self.steps, strict=True):
            if motion.kind == "ball":
                found.append(
                    normalized(multiply(quaternion_from_rotation_vector(step[place]), value))
                )
            else:
                found.append(value + step[place])
        return tuple(found)

    def between(self, start: State, end: State) -> np.ndarray:
        """The step of all freedoms from one state to another."""
        found = np.zeros(self.freedom)
        for a, b, place, motion in zip(start, end, self.places, self.steps, strict=True):
            if motion.kind == "ball":
                found[place] = rotation_vector_from_quaternion(
                    multiply(b, a * np.array([1.0, -1.0, -1.0, -1.0]))
                )
            else:
                found[place] = b - a
        return found

    def placed(self, state: Sequence[Array]) -> Placed:
        """All links at a state."""
        symbolic = is_casadi(*state)
        rotations: dict[str, Array] = {BASE: ca.SX.eye(3) if symbolic else _AXES}
        translations: dict[str, Array] = {BASE: ca.SX.zeros(3) if symbolic else np.zeros(3)}
        for carrier, link, numbers in self.chains:
            turn, shift = rotations[carrier], translations[carrier]
            for k in numbers:
                own_turn, own_shift = self.steps[k].displacement(state[k])
                turn, shift = turn @ own_turn, turn @ own_shift + shift
            rotations[link], translations[link] = turn, shift
        return Placed(rotations, translations)


def _free_steps(link: str, frame: Pose) -> list[Step]:
    """Three slides and a ball about the link's origin."""
    point = np.asarray(frame.position)
    slides = [
        Step(f"{link}.{name}", "slide", point, axis)
        for name, axis in zip("xyz", _AXES, strict=True)
    ]
    return [*slides, Step(f"{link}.turn", "ball", point, np.zeros(3))]
