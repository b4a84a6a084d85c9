"""Machines with closed loops described once, in no format: their parts stand where they are when
all joints are 0, which is closed.

`tests/helpers/robot_texts.py` writes them in MJCF, URDF and SDF; `tests/oracle/robot_accounts.py`
builds them in MuJoCo and Pinocchio.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

GROUND = "ground"
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
FREEDOMS = {"R": 1, "P": 1, "H": 1, "U": 2, "S": 3, "weld": 0}
Vector = Sequence[float]


@dataclass(frozen=True)
class Part:
    """A link with the joint that carries it, whose frame is the link's: `at` and `axis` (of U and
    then `axis2`) are in the world.
    """

    name: str
    parent: str
    joint: Literal["R", "P", "H", "U", "S", "weld"]
    at: Vector
    axis: Vector = Z
    axis2: Vector = X
    pitch: float = 0.0
    limits: tuple[float, float] | None = None

    @property
    def joint_name(self) -> str:
        return f"q_{self.name}"

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the joint's numbers; that of a ball is none."""
        name = self.joint_name
        return {"U": (f"{name}.1", f"{name}.2"), "S": (), "weld": ()}.get(self.joint, (name,))


@dataclass(frozen=True)
class Pin:
    """A closure of two parts at a point of the world: S, R about an axis, or weld."""

    name: str
    kind: Literal["S", "R", "weld"]
    parts: tuple[str, str]
    at: Vector
    axis: Vector = Z


@dataclass(frozen=True)
class Follower:
    """joint of `part` = factor x joint of `leader`."""

    part: str
    leader: str
    factor: float


@dataclass(frozen=True)
class Machine:
    """Parts in an order from the ground, closures, couplings, the parts whose joints motors drive,
    the coordinates that `given` tells in tests (as many as the mobility), and how far they may go.
    """

    name: str
    parts: tuple[Part, ...]
    pins: tuple[Pin, ...]
    mobility: int
    given: tuple[str, ...]
    reach: float = 0.15
    followers: tuple[Follower, ...] = ()
    seed: int = field(default=1)
    turned: Mapping[str, float] = field(default_factory=dict)
    """Angles by which revolute parts are turned where their joints are 0: then the file is open
    there.
    """

    @cached_property
    def frames(self) -> dict[str, np.ndarray]:
        """The pose of every part in the world where all joints are 0: frames of U joints lie along
        their axes, others are turned at random.
        """
        rng = np.random.default_rng(self.seed)
        found = {GROUND: np.eye(4)}
        for part in self.parts:
            pose = np.eye(4)
            pose[:3, :3] = Rotation.from_euler("xyz", rng.uniform(-1.5, 1.5, 3)).as_matrix()
            if part.joint == "U":
                first, second = np.array(part.axis), np.array(part.axis2)
                pose[:3, :3] = np.column_stack([first, second, np.cross(first, second)])
            pose[:3, 3] = part.at
            found[part.name] = pose
        return found

    @property
    def motors(self) -> tuple[str, ...]:
        """The joints of one coordinate among those that are given."""
        return tuple(part.joint_name for part in self.parts if part.joint_name in self.given)

    def part(self, name: str) -> Part:
        return next(part for part in self.parts if part.name == name)

    def in_parent(self, part: Part) -> np.ndarray:
        """A part's frame in that of its parent where its joint is 0."""
        turn = np.eye(4)
        if part.name in self.turned:
            angle = self.turned[part.name] * self.direction(part.name, part.axis)
            turn[:3, :3] = Rotation.from_rotvec(angle).as_matrix()
        return np.asarray(np.linalg.inv(self.frames[part.parent]) @ self.frames[part.name] @ turn)

    def direction(self, name: str, axis: Vector) -> np.ndarray:
        """A direction of the world in a part's frame."""
        return np.asarray(self.frames[name][:3, :3].T @ np.array(axis))

    def frame(self, name: str, at: Vector) -> np.ndarray:
        """The frame at a point, parallel to the world's, in that of a part."""
        pose = np.eye(4)
        pose[:3, 3] = at
        return np.asarray(np.linalg.inv(self.frames[name]) @ pose)


def _planar(name: str, parent: str, x: float, y: float, **more: object) -> Part:
    return Part(name, parent, "R", (x, y, 0.0), **more)  # type: ignore[arg-type]


def four_bar() -> Machine:
    parts = (
        _planar("crank", GROUND, 0, 0, limits=(-2.0, 2.0)),
        _planar("coupler", "crank", 0.1, 0.3),
        _planar("rocker", GROUND, 0.6, 0),
    )
    return Machine(
        "four_bar", parts, (Pin("end", "R", ("coupler", "rocker"), (0.7, 0.5, 0)),), 1, ("q_crank",)
    )


def five_bar() -> Machine:
    parts = (
        _planar("left", GROUND, 0, 0),
        _planar("left_rod", "left", -0.1, 0.3),
        _planar("right", GROUND, 0.4, 0),
        _planar("right_rod", "right", 0.55, 0.3),
    )
    return Machine(
        "five_bar",
        parts,
        (Pin("tip", "S", ("left_rod", "right_rod"), (0.2, 0.6, 0)),),
        2,
        ("q_left", "q_right"),
    )


def six_bar() -> Machine:
    """Watt's chain: a four-bar whose rocker is the crank of another."""
    parts = (
        _planar("crank", GROUND, 0, 0),
        _planar("coupler", "crank", 0.05, 0.25),
        _planar("rocker", GROUND, 0.5, 0),
        _planar("rod", "rocker", 0.65, 0.2),
        _planar("output", GROUND, 1.0, 0.05),
    )
    pins = (
        Pin("first", "R", ("coupler", "rocker"), (0.55, 0.4, 0)),
        Pin("second", "R", ("rod", "output"), (1.05, 0.45, 0)),
    )
    return Machine("six_bar", parts, pins, 1, ("q_crank",))


def _about(angle: float, radius: float, height: float) -> np.ndarray:
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])


def delta() -> Machine:
    """Three arms, each with two rods of equal length on universal joints, ball joints at the
    platform.
    """
    parts: list[Part] = []
    pins: list[Pin] = []
    for k in range(3):
        angle = 2.0 * np.pi * k / 3
        tangent = (-np.sin(angle), np.cos(angle), 0.0)
        parts.append(Part(f"arm{k}", GROUND, "R", _about(angle, 0.2, 0), tangent))
        for side, word in ((-1, "a"), (1, "b")):
            offset = 0.04 * side * np.array(tangent)
            at = _about(angle, 0.4, -0.05) + offset
            end = _about(angle, 0.06, -0.4) + offset
            along = end - at
            radial = np.cross(tangent, along) / np.linalg.norm(along)
            rod = f"rod{k}{word}"
            parts.append(Part(rod, f"arm{k}", "U", at, tangent, tuple(radial)))
            if not pins and word == "a" and k == 0:
                parts.append(Part("platform", rod, "S", end))
            if (k, word) != (0, "a"):
                pins.append(Pin(f"ball{k}{word}", "S", (rod, "platform"), end))
    return Machine("delta", tuple(parts), tuple(pins), 3, ("q_arm0", "q_arm1", "q_arm2"), 0.1)


def stewart() -> Machine:
    """Six legs: a universal joint, a slide, a ball."""
    parts: list[Part] = []
    pins: list[Pin] = []
    for k in range(6):
        foot = _about(np.pi / 3 * (k - k % 2) + (0.2 if k % 2 else -0.2) + 0.5, 0.5, 0)
        head = _about(np.pi / 3 * (k + k % 2) + (-0.2 if k % 2 else 0.2) - 0.1, 0.3, 0.55)
        along = (head - foot) / np.linalg.norm(head - foot)
        second = np.cross(along, X) / np.linalg.norm(np.cross(along, X))
        first = np.cross(second, along)
        parts.append(Part(f"low{k}", GROUND, "U", foot, tuple(first), tuple(second)))
        parts.append(
            Part(f"high{k}", f"low{k}", "P", 0.5 * (foot + head), tuple(along), limits=(-0.2, 0.2))
        )
        if k == 0:
            parts.append(Part("platform", "high0", "S", head))
        else:
            pins.append(Pin(f"ball{k}", "S", (f"high{k}", "platform"), head))
    return Machine(
        "stewart", tuple(parts), tuple(pins), 6, tuple(f"q_high{k}" for k in range(6)), 0.03
    )


def parallel_ankle() -> Machine:
    """A foot on a universal joint, turned by two cranks with rods."""
    parts = [Part("foot", GROUND, "U", (0, 0, 0), Y, X)]
    pins = []
    for side, word in ((1, "left"), (-1, "right")):
        axle, knee, toe = (
            np.array([-0.02, 0.06 * side, 0.25]),
            np.array([-0.07, 0.06 * side, 0.26]),
            np.array([-0.06, 0.05 * side, 0.0]),
        )
        along = (toe - knee) / np.linalg.norm(toe - knee)
        first = np.cross(Y, along) / np.linalg.norm(np.cross(Y, along))
        parts.append(Part(f"crank_{word}", GROUND, "R", axle, Y))
        parts.append(
            Part(
                f"rod_{word}",
                f"crank_{word}",
                "U",
                knee,
                tuple(np.cross(along, first)),
                tuple(first),
            )
        )
        pins.append(Pin(f"end_{word}", "S", (f"rod_{word}", "foot"), toe))
    return Machine(
        "parallel_ankle", tuple(parts), tuple(pins), 2, ("q_crank_left", "q_crank_right"), 0.2
    )


def gripper() -> Machine:
    """Two fingers on four-bars, the right one's crank geared to the left one's."""
    parts: list[Part] = []
    pins = []
    for side, word in ((-1, "left"), (1, "right")):
        parts += [
            _planar(f"{word}_crank", GROUND, 0.02 * side, 0),
            _planar(f"{word}_finger", f"{word}_crank", 0.06 * side, 0.05),
            _planar(f"{word}_follower", GROUND, 0.01 * side, 0.03),
        ]
        pins.append(
            Pin(
                f"{word}_pin", "R", (f"{word}_finger", f"{word}_follower"), (0.055 * side, 0.085, 0)
            )
        )
    followers = (Follower("right_crank", "left_crank", -1.0),)
    return Machine("gripper", tuple(parts), tuple(pins), 1, ("q_left_crank",), 0.2, followers)


def leg() -> Machine:
    """A thigh on a ball joint at the hip, held by two rods with slides, and a shank."""
    parts = [Part("thigh", GROUND, "S", (0, 0, 0)), Part("shank", "thigh", "R", (0.02, 0, -0.4), Y)]
    pins = []
    for side, word in ((1, "left"), (-1, "right")):
        foot, head = np.array([-0.2, 0.15 * side, -0.1]), np.array([-0.08, 0.06 * side, -0.3])
        along = (head - foot) / np.linalg.norm(head - foot)
        first = np.cross(Y, along) / np.linalg.norm(np.cross(Y, along))
        parts.append(
            Part(f"cylinder_{word}", GROUND, "U", foot, tuple(np.cross(along, first)), tuple(first))
        )
        parts.append(
            Part(f"piston_{word}", f"cylinder_{word}", "P", 0.5 * (foot + head), tuple(along))
        )
        pins.append(Pin(f"end_{word}", "S", (f"piston_{word}", "thigh"), head))
    given = ("q_shank", "q_piston_left", "q_piston_right", "q_cylinder_left.1")
    return Machine("leg", tuple(parts), tuple(pins), 4, given, 0.03)


def universal_loop() -> Machine:
    """Four universal joints in one loop, whose axes have no common direction; in a format of graphs
    the fourth closes it.
    """
    rng = np.random.default_rng(5)
    parts = []
    corners = [(0, 0, 0), (0.4, 0.1, 0.3), (0.7, 0.5, 0.2), (0.3, 0.6, -0.1)]
    parent = GROUND
    for name, at in zip(("first", "second", "third", "end"), corners, strict=True):
        first, second, _ = Rotation.random(random_state=rng).as_matrix()
        parts.append(Part(name, parent, "U", at, tuple(first), tuple(second)))
        parent = name
    pins = (Pin("closing", "weld", ("end", GROUND), (0.3, 0.6, -0.1)),)
    return Machine("universal_loop", tuple(parts), pins, 2, ("q_first.1", "q_first.2"), 0.1)


def screw_drive() -> Machine:
    """A spindle turns in its bearing, and drives a nut that a guide keeps from turning; a rod
    swings a lever from the nut.
    """
    parts = (
        Part("spindle", GROUND, "R", (0, 0, 0), X),
        Part("nut", "spindle", "H", (0.2, 0, 0), X, pitch=0.1),
        Part("guide", GROUND, "P", (0.2, -0.1, 0), X),
        Part("rod", "guide", "R", (0.2, 0, 0.05), Y),
        Part("lever", GROUND, "R", (0.5, 0, 0), Y),
    )
    pins = (
        Pin("slot", "weld", ("nut", "guide"), (0.2, 0, 0)),
        Pin("end", "R", ("rod", "lever"), (0.45, 0, 0.3), Y),
    )
    return Machine("screw_drive", parts, pins, 1, ("q_spindle",), 0.8)


def humanoid(limbs: int = 6) -> Machine:
    """Limbs of ten joints on the ground: five in series about changing axes, a planar four-bar, and
    two more behind its coupler.
    """
    parts: list[Part] = []
    pins = []
    for k in range(limbs):
        turn = Rotation.from_euler("z", 2.0 * np.pi * k / limbs).as_matrix()
        axes = (X, Y, X, Z, Y)
        parent = GROUND

        def add(
            name: str, parent: str, at: Vector, axis: Vector, k: int = k, turn: np.ndarray = turn
        ) -> str:
            parts.append(
                Part(
                    f"{name}{k}",
                    parent,
                    "R",
                    tuple(turn @ np.array(at)),
                    tuple(turn @ np.array(axis)),
                )
            )
            return f"{name}{k}"

        for j, axis in enumerate(axes):
            parent = add(f"hip{j}_", parent, (0.3 + 0.02 * j, 0.0, -0.1 * j), axis)
        crank = add("crank", parent, (0.4, 0, -0.5), Y)
        coupler = add("coupler", crank, (0.5, 0, -0.48), Y)
        rocker = add("rocker", parent, (0.42, 0, -0.8), Y)
        wrist = add("wrist", coupler, (0.55, 0, -0.9), X)
        add("tool", wrist, (0.6, 0, -0.9), Z)
        pins.append(
            Pin(
                f"pin{k}",
                "R",
                (coupler, rocker),
                tuple(turn @ np.array((0.53, 0, -0.79))),
                tuple(turn @ np.array(Y)),
            )
        )
    given = tuple(
        part.joint_name for part in parts if not part.name.startswith(("coupler", "rocker"))
    )
    return Machine("humanoid", tuple(parts), tuple(pins), 8 * limbs, given)


def opened(machine: Machine, by: float, seed: int = 0) -> Machine:
    """The machine with revolute joints told from other zeros, at which its loops are open."""
    rng = np.random.default_rng(seed)
    return replace(
        machine,
        turned={part.name: by * rng.uniform(-1, 1) for part in machine.parts if part.joint == "R"},
    )


MACHINES = {
    make.__name__: make
    for make in (
        four_bar,
        five_bar,
        six_bar,
        delta,
        stewart,
        parallel_ankle,
        gripper,
        leg,
        universal_loop,
        screw_drive,
    )
}
