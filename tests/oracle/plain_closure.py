"""The loop closure of a mechanism file in plain NumPy, and its solutions from random starts:
nothing here is symkin's.

Every joint keeps all its coordinates and no joint is cut: each limb carries the platform's frame by
a product of exponentials, and its residual is the difference from the platform's own frame. All
functions take many configurations at once, as rows of an array. Steps are tangent: lengths, angles
times the size, and rotation vectors (before the joint; in the base frame for the platform) times
the size for quaternions.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

POSE = {
    "spatial": ("x", "y", "z", "quaternion"),
    "schoenflies": ("x", "y", "z", "gamma"),
    "planar": ("x", "y", "gamma"),
    "translation": ("x", "y", "z"),
    "spherical": ("quaternion",),
}
"""Coordinates of the platform's pose for each motion."""


@dataclass(frozen=True)
class Number:
    """One coordinate: `kind` is length, angle, turns or quaternion; `value` that at the reference,
    radians.
    """

    name: str
    kind: str
    role: str
    value: tuple[float, ...]

    @property
    def freedom(self) -> int:
        return 3 if self.kind == "quaternion" else 1


@dataclass(frozen=True)
class Step:
    """A displacement of a limb: fixed (`matrix`), or a screw or ball at `place` among the
    coordinates.
    """

    matrix: np.ndarray | None = None
    place: int = -1
    point: np.ndarray = field(default_factory=lambda: np.zeros(3))
    axis: np.ndarray = field(default_factory=lambda: np.zeros(3))
    turn: float = 0.0
    slide: float = 0.0


@dataclass(frozen=True)
class Chain:
    """A limb: its steps, its rods (start, platform point, length), or one actuated rod (base,
    platform point, offset).
    """

    name: str
    steps: tuple[Step, ...] = ()
    rods: tuple[tuple[np.ndarray, np.ndarray, float], ...] = ()
    leg: tuple[np.ndarray, np.ndarray, float, int] | None = None


class PlainMechanism:
    """Coordinates and limbs of a parsed mechanism file whose numbers are plain."""

    def __init__(self, data: dict[str, Any]) -> None:
        self.data = data
        self.unit = math.pi / 180 if data["angle_unit"] == "deg" else 1.0
        self.numbers: list[Number] = []
        self.chains: list[Chain] = []
        self.idle: set[str] = set()
        self.serial = "limb" not in data
        frame = data.get("tool" if self.serial else "platform", {})
        self.position = np.array(frame.get("position", (0.0, 0.0, 0.0)), dtype=float)
        self.quaternion = _unit(
            np.array(frame.get("quaternion", (1.0, 0.0, 0.0, 0.0)), dtype=float)
        )
        self.motion = frame.get("motion", "spatial")
        if "dh" in data:
            self.chains.append(self._dh(data["dh"]))
        for limb in data.get(
            "limb", [{"name": "arm", "joint": data["joint"]}] if "joint" in data else []
        ):
            self.chains.append(self._limb(limb))
        self._declare_pose()
        self.names = [n.name for n in self.numbers]
        widths = [len(n.value) for n in self.numbers]
        self.slices = [
            slice(e - w, e) for e, w in zip(np.cumsum(widths).tolist(), widths, strict=True)
        ]
        freedoms = [n.freedom for n in self.numbers]
        self.columns = [
            slice(e - f, e) for e, f in zip(np.cumsum(freedoms).tolist(), freedoms, strict=True)
        ]
        self.freedom = sum(freedoms)
        self.size = self._size()
        self.reference = self._reference()

    # --- from the file ----------------------------------------------------------------------------

    def _declare(self, name: str, kind: str, role: str, value: Sequence[float]) -> int:
        self.numbers.append(Number(name, kind, role, tuple(value)))
        return len(self.numbers) - 1

    def _limb(self, limb: dict[str, Any]) -> Chain:
        if "base" in limb:
            base, end, offset = (
                np.array(limb["base"]),
                np.array(limb["platform"]),
                limb.get("offset", 0.0),
            )
            place = self._declare(
                limb["name"],
                "length",
                "actuated",
                [np.linalg.norm(self._carried(end) - base) - offset],
            )
            return Chain(limb["name"], leg=(base, end, offset, place))
        steps = [step for joint in limb["joint"] for step in self._joint(joint)]
        rods = []
        for rod in limb.get("rod", []):
            start, end = np.array(rod["from"]), np.array(rod["platform"])
            rods.append(
                (start, end, rod.get("length", float(np.linalg.norm(self._carried(end) - start))))
            )
        balls = [joint["name"] for joint in limb["joint"] if joint["type"] == "S"]
        if len(balls) > 1:
            self.idle |= {balls[0], balls[-1]}
        return Chain(limb["name"], tuple(steps), tuple(rods))

    def _carried(self, point: np.ndarray) -> np.ndarray:
        return self.position + quaternion_matrix(self.quaternion[None])[0] @ point

    def _joint(self, joint: dict[str, Any]) -> Iterator[Step]:
        kind, name = joint["type"], joint["name"]
        point = np.array(joint.get("point", (0.0, 0.0, 0.0)), dtype=float)
        role = "actuated" if joint.get("actuated", self.serial) else "passive"
        axis = _unit(np.array(joint["axis"], dtype=float)) if kind != "S" else np.zeros(3)
        if kind == "S":
            yield Step(None, self._declare(name, "quaternion", role, (1.0, 0.0, 0.0, 0.0)), point)
            return
        if kind == "C":
            yield Step(None, self._declare(f"{name}.angle", "angle", role, [0.0]), point, axis, 1.0)
            yield Step(
                None, self._declare(f"{name}.slide", "length", role, [0.0]), point, axis, 0.0, 1.0
            )
            return
        if kind == "U":
            second = _unit(np.array(joint["axis2"], dtype=float))
            yield Step(None, self._declare(f"{name}.1", "angle", role, [0.0]), point, axis, 1.0)
            yield Step(None, self._declare(f"{name}.2", "angle", role, [0.0]), point, second, 1.0)
            return
        zero = joint.get("zero", 0.0) * (1.0 if kind == "P" else self.unit)
        name_of = {"R": "angle", "P": "length", "H": "turns"}
        place = self._declare(name, name_of[kind], role, [zero])
        slide = {"R": 0.0, "P": 1.0, "H": joint.get("pitch", 0.0) / (2 * math.pi)}[kind]
        yield Step(None, place, point, axis, 0.0 if kind == "P" else 1.0, slide)

    def _dh(self, table: dict[str, Any]) -> Chain:
        z, steps = np.array([0.0, 0.0, 1.0]), []
        for k, row in enumerate(table["rows"], start=1):
            turning = row["type"] == "R"
            place = self._declare(
                row.get("name", f"q{k}"), "angle" if turning else "length", "actuated", [0.0]
            )
            joint = Step(None, place, np.zeros(3), z, float(turning), float(not turning))
            about_z = _screw(z, row.get("theta", 0.0) * self.unit, row.get("d", 0.0))
            about_x = _screw(
                np.array([1.0, 0.0, 0.0]), row.get("alpha", 0.0) * self.unit, row.get("a", 0.0)
            )
            parts = (
                (joint, Step(about_z @ about_x))
                if table["convention"] == "standard"
                else (Step(about_x), joint, Step(about_z))
            )
            steps += list(parts)
        return Chain("arm", tuple(steps))

    def _declare_pose(self) -> None:
        for name in POSE[self.motion]:
            if name == "quaternion":
                self._declare("pose.quaternion", "quaternion", "pose", self.quaternion)
            elif name == "gamma":
                self._declare("pose.gamma", "angle", "pose", [0.0])
            else:
                self._declare(f"pose.{name}", "length", "pose", [self.position["xyz".index(name)]])

    def _reference(self) -> np.ndarray:
        """The reference configuration; a DH arm's tool is where its joints at zero carry it."""
        x = np.concatenate([n.value for n in self.numbers])
        if "dh" in self.data:
            frame = self._carry(self.chains[0], x[None])[0][0]
            x = self.with_pose(x[None], frame[:3, 3], matrix_quaternion(frame[:3, :3]))[0]
        return x

    def _size(self) -> float:
        """The largest distance between joint points, rods' ends and, where these coincide, the
        platform origin; or 1.
        """
        points = [
            step.point for chain in self.chains for step in chain.steps if step.matrix is None
        ]
        for chain in self.chains:
            points += [p for start, end, _ in chain.rods for p in (start, self._carried(end))]
            points += [chain.leg[0], self._carried(chain.leg[1])] if chain.leg else []
        if "dh" in self.data:
            points, frame = [], np.eye(4)
            for step in self.chains[0].steps:
                points += [frame[:3, 3]] if step.matrix is None else []
                frame = frame if step.matrix is None else frame @ step.matrix
        for cloud in (points, [*points, self.position]):
            spread = max((float(np.linalg.norm(a - b)) for a in cloud for b in cloud), default=0.0)
            if spread > 0.0:
                return spread
        return 1.0

    # --- values -----------------------------------------------------------------------------------

    def places(self, *roles: str) -> list[int]:
        return [i for i, n in enumerate(self.numbers) if n.role in roles]

    def tangent(self, places: Sequence[int]) -> np.ndarray:
        """Columns of the coordinates at some places."""
        found = [np.arange(self.columns[i].start, self.columns[i].stop) for i in places]
        return np.concatenate(found) if found else np.zeros(0, dtype=int)

    def pose(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, 3) and rotations (n, 3, 3) of the platform."""
        n = len(x)
        position, rotation = (
            np.tile(self.position, (n, 1)),
            quaternion_matrix(np.tile(self.quaternion, (n, 1))),
        )
        for i in self.places("pose"):
            name, values = self.names[i].removeprefix("pose."), x[:, self.slices[i]]
            if name == "quaternion":
                rotation = quaternion_matrix(values)
            elif name == "gamma":
                rotation = turn_matrix(np.array([0.0, 0.0, 1.0]), values[:, 0]) @ rotation
            else:
                position[:, "xyz".index(name)] = values[:, 0]
        return position, rotation

    def with_pose(self, x: np.ndarray, position: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
        """Configurations with the pose coordinates of one pose, as far as the motion has them."""
        x = x.copy()
        for i in self.places("pose"):
            name = self.names[i].removeprefix("pose.")
            if name == "quaternion":
                x[:, self.slices[i]] = quaternion
            elif name == "gamma":
                turn = (
                    quaternion_matrix(quaternion[None])[0]
                    @ quaternion_matrix(self.quaternion[None])[0].T
                )
                x[:, self.slices[i]] = math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1])
            else:
                x[:, self.slices[i]] = position["xyz".index(name)]
        return x

    def move(self, x: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Configurations (n, numbers) after tangent steps (n, freedom)."""
        moved = x.copy()
        for number, place, column in zip(self.numbers, self.slices, self.columns, strict=True):
            if number.kind == "quaternion":
                vector = step[:, column] / self.size
                angle = np.linalg.norm(vector, axis=1, keepdims=True)
                half = np.concatenate(
                    [np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * vector], axis=1
                )
                moved[:, place] = _unit(_product(half, x[:, place]))
            else:
                moved[:, place] += step[:, column] / (1.0 if number.kind == "length" else self.size)
        return moved

    # --- closure ----------------------------------------------------------------------------------

    def closure(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals (n, rows) in lengths, rotations times the size, and their derivatives (n, rows,
        freedom).
        """
        position, rotation = self.pose(x)
        moved, turned = self._pose_derivatives(rotation)
        rows, derivatives = [], []
        for chain in self.chains:
            if chain.leg is not None:
                base, end, offset, place = chain.leg
                r, j = self._distance(
                    position + rotation @ end,
                    self._point_derivative(moved, turned, rotation @ end),
                    base,
                    0.0,
                )
                j[:, self.columns[place].start] -= 1.0
                rows.append((r - offset - x[:, self.slices[place]][:, 0])[:, None])
                derivatives.append(j[:, None])
                continue
            frame, twists = self._carry(chain, x)
            for start, end, length in chain.rods:
                here = frame[:, :3, :3] @ start + frame[:, :3, 3]
                there = position + rotation @ end
                d_here = twists[:, 3:] - cross_matrix(here) @ twists[:, :3]
                r, j = self._distance(
                    there,
                    self._point_derivative(moved, turned, rotation @ end) - d_here,
                    here,
                    length,
                )
                rows.append(r[:, None])
                derivatives.append(j[:, None])
            if not chain.rods:
                r, j = self._frame_rows(frame, twists, position, rotation, moved, turned)
                rows.append(r)
                derivatives.append(j)
        return np.concatenate(rows, axis=1), np.concatenate(derivatives, axis=1)

    def _pose_derivatives(self, rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Velocity of the origin and angular velocity (n, 3, freedom) by the tangent."""
        n = len(rotation)
        moved, turned = np.zeros((n, 3, self.freedom)), np.zeros((n, 3, self.freedom))
        for i in self.places("pose"):
            name, column = self.names[i].removeprefix("pose."), self.columns[i]
            if name == "quaternion":
                turned[:, :, column] = np.eye(3) / self.size
            elif name == "gamma":
                turned[:, 2, column.start] = 1 / self.size
            else:
                moved[:, "xyz".index(name), column.start] = 1.0
        return moved, turned

    @staticmethod
    def _point_derivative(moved: np.ndarray, turned: np.ndarray, arm: np.ndarray) -> np.ndarray:
        return np.asarray(moved - cross_matrix(arm) @ turned)

    @staticmethod
    def _distance(
        a: np.ndarray, da: np.ndarray, b: np.ndarray, length: float
    ) -> tuple[np.ndarray, np.ndarray]:
        gap = a - b
        far = np.linalg.norm(gap, axis=1)
        return far - length, np.einsum("ni,nif->nf", gap / np.maximum(far, 1e-300)[:, None], da)

    def _frame_rows(
        self,
        frame: np.ndarray,
        twists: np.ndarray,
        position: np.ndarray,
        rotation: np.ndarray,
        moved: np.ndarray,
        turned: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        turn = frame[:, :3, :3]
        home = quaternion_matrix(self.quaternion[None])[0]
        carried, there = turn @ home, turn @ self.position + frame[:, :3, 3]
        if "dh" in self.data:
            carried, there = turn, frame[:, :3, 3]
        d_there = twists[:, 3:] - cross_matrix(there) @ twists[:, :3]
        rows, derivatives = [there - position], [d_there - moved]
        for k in range(3):
            rows.append(self.size * (carried[:, :, k] - rotation[:, :, k]))
            ours = cross_matrix(carried[:, :, k]) @ twists[:, :3]
            theirs = cross_matrix(rotation[:, :, k]) @ turned
            derivatives.append(self.size * (theirs - ours))
        return np.concatenate(rows, axis=1), np.concatenate(derivatives, axis=1)

    def _carry(self, chain: Chain, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacements (n, 4, 4) of a limb's last link, and its twists (angular velocity; velocity
        at the base origin) (n, 6, freedom) by the tangent.
        """
        frame = np.tile(np.eye(4), (len(x), 1, 1))
        twists = np.zeros((len(x), 6, self.freedom))
        for step in chain.steps:
            if step.matrix is not None:
                frame = frame @ step.matrix
                continue
            number, values, column = (
                self.numbers[step.place],
                x[:, self.slices[step.place]],
                self.columns[step.place],
            )
            if number.kind == "quaternion":
                for k in range(3):
                    twists[:, :, column.start + k] = (
                        _carried_screw(frame, step.point, np.eye(3)[k], 1.0, 0.0) / self.size
                    )
                frame = frame @ _about(quaternion_matrix(values), step.point)
                continue
            unit = 1.0 if number.kind == "length" else self.size
            twists[:, :, column.start] = (
                _carried_screw(frame, step.point, step.axis, step.turn, step.slide) / unit
            )
            amount = values[:, 0] - number.value[0]
            g = _about(turn_matrix(step.axis, step.turn * amount), step.point)
            g[:, :3, 3] += step.slide * amount[:, None] * step.axis
            frame = frame @ g
        return frame, twists

    def residual(self, x: np.ndarray) -> np.ndarray:
        """Largest closure error (n,) of each configuration, over the size."""
        return np.asarray(np.max(np.abs(self.closure(x)[0]), axis=1, initial=0.0) / self.size)


# --- rotations ------------------------------------------------------------------------------------


def _unit(v: np.ndarray) -> np.ndarray:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def cross_matrix(v: np.ndarray) -> np.ndarray:
    """Matrices (n, 3, 3) by which vectors (n, 3) are multiplied for v x w: NumPy's `cross` takes
    many times as long for few vectors.
    """
    k = np.zeros((len(v), 3, 3))
    k[:, 2, 1], k[:, 0, 2], k[:, 1, 0] = v[:, 0], v[:, 1], v[:, 2]
    return k - np.swapaxes(k, 1, 2)


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    w = a[:, 0] * b[:, 0] - np.sum(a[:, 1:] * b[:, 1:], axis=1)
    across = (cross_matrix(a[:, 1:]) @ b[:, 1:, None])[:, :, 0]
    return np.column_stack([w, a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + across])


def quaternion_matrix(q: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) of unit quaternions (n, 4): columns are the images of the unit
    vectors.
    """
    k = cross_matrix(q[:, 1:])
    return np.asarray(np.eye(3) + 2 * q[:, :1, None] * k + 2 * k @ k)


def matrix_quaternion(r: np.ndarray) -> np.ndarray:
    """The unit quaternion of a rotation, by the eigenvector of its largest component."""
    k = np.array(
        [
            [r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [0, r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [0, 0, r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1]],
            [0, 0, 0, r[2, 2] - r[0, 0] - r[1, 1]],
        ]
    )
    q = np.linalg.eigh(np.triu(k) + np.triu(k, 1).T)[1][:, -1]
    return q if q[0] >= 0 else -q


def turn_matrix(axis: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) about a unit axis by angles (n,)."""
    (k,) = cross_matrix(np.asarray(axis)[None])
    s, c = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.asarray(np.eye(3) + s * k + (1 - c) * (k @ k))


def _about(rotation: np.ndarray, point: np.ndarray) -> np.ndarray:
    g = np.tile(np.eye(4), (len(rotation), 1, 1))
    g[:, :3, :3], g[:, :3, 3] = rotation, point - rotation @ point
    return g


def _screw(axis: np.ndarray, angle: float, slide: float) -> np.ndarray:
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = turn_matrix(axis, np.array([angle]))[0], slide * axis
    return g


def _carried_screw(
    frame: np.ndarray, point: np.ndarray, axis: np.ndarray, turn: float, slide: float
) -> np.ndarray:
    """The twist (n, 6) of a joint at the reference, carried by the displacements before it."""
    w, direction = turn * (frame[:, :3, :3] @ axis), frame[:, :3, :3] @ axis
    there = frame[:, :3, :3] @ point + frame[:, :3, 3]
    moment = (cross_matrix(there) @ w[:, :, None])[:, :, 0]
    return np.concatenate([w, moment + slide * direction], axis=1)
