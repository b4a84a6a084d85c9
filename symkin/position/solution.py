"""One solution of a position problem: its values, their checks, and how they print."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from symkin.closure.closure import Closure
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.position.canonical import poses_of
from symkin.position.problem import Problem
from symkin.result import Result, Summary
from symkin.spatial.pose import Pose

SINGULAR_NOTE = "singular: the solution is multiple or nearly so, and known to fewer digits"


@dataclass(frozen=True)
class PartialProof:
    """`independent` of `rows` rows vanish at one exact point within `radius` of the given one (length unit, angles times the
    size); no other row is more than `remaining` there (length unit)."""

    independent: int
    rows: int
    radius: float
    remaining: float

    @staticmethod
    def joined(parts: Sequence[PartialProof]) -> PartialProof:
        """Of parts that are solved one by one."""
        return PartialProof(
            sum(p.independent for p in parts), sum(p.rows for p in parts),
            max(p.radius for p in parts), max(p.remaining for p in parts),
        )  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Solution(Result):
    """One configuration that closes all loops: F(q, x, X, p) = 0 to within `residual`.

    `values` maps each closure coordinate to its value (a unit quaternion for S joints); `residual` is the largest
    closure error over all constraints in the length unit; `condition` that of the unknowns' Jacobian with angles times
    the size; `hits` counts the starts that reached it; `ground` is what is proved where rows are redundant, so that none of it is
    `certified`. `values` are in radians and the length unit, `joints` in the mechanism's units.

    >>> import symkin
    >>> found = symkin.solve(symkin.load("zhao2000"), joints=[81.6, 202.8, 330.6, 105.2]).solution
    >>> found.position.round(3).tolist(), round(found.joints["radial1"], 3)
    ([4.946, 5.009, 104.964], 75.365)
    """

    mechanism: Mechanism
    values: dict[str, Any]
    pose: Pose
    residual: float
    condition: float
    within_limits: bool | None
    hits: int | None = None
    certified: bool | None = None
    radius: float | None = None
    notes: tuple[str, ...] = ()
    ground: PartialProof | None = None

    @property
    def joints(self) -> dict[str, Any]:
        """Joint coordinates in the mechanism's units, passive ones included."""
        return {name: value for name, value in self._user_values().items() if not name.startswith("pose.")}

    @property
    def actuated_values(self) -> list[float]:
        """Actuated joint values in file order and the mechanism's units: what `modes(joints=...)` takes."""
        values = self.joints
        return [values[c.name] for c in self.mechanism.actuated]

    @property
    def actuated(self) -> list[float]:
        """Deprecated name of `actuated_values`."""
        return self.actuated_values

    @property
    def position(self) -> np.ndarray:
        return np.asarray(self.pose.position, dtype=float)

    @property
    def quaternion(self) -> np.ndarray:
        return np.asarray(self.pose.quaternion, dtype=float)

    @property
    def rotation(self) -> np.ndarray:
        return np.asarray(self.pose.rotation, dtype=float)

    def _user_values(self) -> dict[str, Any]:
        kinds = {c.name: c for c in _coordinates(self.mechanism)}
        out: dict[str, Any] = {}
        for name, value in self.values.items():
            c = kinds.get(name)
            if c is None:
                continue
            if c.kind == "quaternion":
                out[name] = [float(v) for v in value]
            else:
                out[name] = self.mechanism.angle_out(value) if c.is_angular else value
        return out

    def to_dict(self) -> dict[str, Any]:
        """One entry of `modes` in the JSON of `symkin modes --json`."""
        return {
            "pose": {
                "position": self.position.tolist(),
                "quaternion": self.quaternion.tolist(),
                "matrix": self.rotation.tolist(),
            },
            "joints": self.joints,
            "residual": self.residual,
            "condition": finite(self.condition),
            "certified": self.certified,
            "radius": self.radius,
            "ground": None if self.ground is None else asdict(self.ground),
            "within_limits": self.within_limits,
            "notes": list(self.notes),
        }

    def summary(self, most_rows: int | None = None) -> Summary:
        """Pose, joints and checks, a row each."""
        unit = self.mechanism.length_unit
        pose = dict(zip(("x", "y", "z", "qw", "qx", "qy", "qz"), (*self.position, *self.quaternion), strict=True))
        values = {**pose, **self.joints, f"residual, {unit}": self.residual, "condition": self.condition}
        rows = [[name, f"{value:.7g}"] for name, value in values.items() if isinstance(value, float)]
        return Summary([self.mechanism.name], ["", "value"], rows[:most_rows], [f"note: {note}" for note in self.notes])

    def __str__(self) -> str:
        position = ", ".join(f"{v:.6g}" for v in self.position)
        quaternion = ", ".join(f"{v:.6f}" for v in self.quaternion)
        joints = ", ".join(f"{k} = {v:.6g}" for k, v in self.joints.items() if isinstance(v, float))
        return (
            f"{self.mechanism.name} at ({position}) {self.mechanism.length_unit}, quaternion ({quaternion}); "
            f"{joints}; residual {self.residual:.1e}, condition {self.condition:.3g}"
        )

    def __repr__(self) -> str:
        return str(self)


def named_values(closure: Closure, values: np.ndarray) -> dict[str, Any]:
    """A full vector of variables by the names of its coordinates; a quaternion is a tuple of four."""
    numbers = values.tolist()
    named: dict[str, Any] = {}
    for c in (c for c in closure.coordinates if c.role != "geometry"):
        place = closure.slices[c.name]
        named[c.name] = numbers[place.start] if c.width == 1 else tuple(numbers[place])
    return named


def pose_of(closure: Closure, values: np.ndarray) -> Pose:
    """The platform's pose, quaternion with w >= 0, from a full vector of variables."""
    position, quaternion = poses_of(closure, values[None])
    return Pose(position[0], quaternion[0])


def _coordinates(mechanism: Mechanism) -> tuple[Coordinate, ...]:
    """Coordinates of all joints and actuated rods."""
    return (*(c for joint in mechanism.all_joints for c in joint.coordinates), *mechanism.actuated)


def finite(value: float | None) -> float | None:
    """JSON has no infinity: null stands for it."""
    return value if value is not None and math.isfinite(value) else None


def heading(problem: Problem, given: dict[str, list[float]]) -> dict[str, Any]:
    mechanism = problem.mechanism
    return {
        "mechanism": mechanism.name,
        "problem": problem.kind,
        "given": given,
        "length_unit": mechanism.length_unit,
        "angle_unit": mechanism.angle_unit,
    }
