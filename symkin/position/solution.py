"""One solution of a position problem: its values, their checks, and how they print."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.position.problem import Problem
from symkin.result import Result, Summary
from symkin.spatial.pose import Pose

if TYPE_CHECKING:
    from symkin.certificate.independent_rows import PartialProof

ACCEPTED = 1e-9
"""A configuration is a solution when no closure error exceeds this times the size."""
SINGULAR = 1e8
"""Condition above which a solution is called singular."""
_SINGULAR_NOTE = "singular: the solution is multiple or nearly so, and known to fewer digits"


@dataclass(frozen=True, eq=False, repr=False)
class Solution(Result):
    """One configuration that closes all loops, in radians and the mechanism's length unit.

    `values` maps each closure coordinate to its value (a unit quaternion for S joints); `residual` is the largest
    closure error over all constraints in the length unit; `condition` that of the unknowns' Jacobian with angles times
    the size; `hits` counts the starts that reached it; `ground` is what is proved where rows are redundant, so that none of it is
    `certified`.
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
            c = kinds[name]
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


def make_solution(problem: Problem, values: np.ndarray, *, hits: int | None = None, notes: tuple[str, ...] = ()) -> Solution:
    """A canonical, checked solution from a full vector of variables."""
    values = canonical(problem.closure, values)
    closure, system = problem.closure, problem.system
    unknown = problem.select_values(values, system.unknowns)
    known = problem.select_values(values, problem.known_coordinates)
    condition = system.condition(unknown, known)
    named: dict[str, Any] = {}
    for c in closure.coordinates:
        part = values[closure.slices[c.name]]
        named[c.name] = float(part[0]) if c.width == 1 else tuple(float(v) for v in part)
    return Solution(
        closure.mechanism,
        named,
        pose_of(closure, values),
        system.residual(unknown, known),
        condition,
        _within_limits(closure, values),
        hits,
        notes=notes if condition < SINGULAR else (*notes, _SINGULAR_NOTE),
    )


def pose_of(closure: Closure, values: np.ndarray) -> Pose:
    """The platform's pose, quaternion with w >= 0, from a full vector of variables."""
    packed = np.asarray(_pose_function(closure)(values)).ravel()
    q = packed[3:] / np.linalg.norm(packed[3:])
    return Pose(packed[:3], _positive(q))


def _pose_function(closure: Closure) -> ca.Function:
    cached: ca.Function | None = closure.__dict__.get("_pose_function")
    if cached is None:
        expression = closure.bound(ca.vertcat(closure.pose.position, closure.pose.quaternion))
        cached = ca.Function("pose", [closure.variables], [expression])
        closure.__dict__["_pose_function"] = cached
    return cached


def canonical(closure: Closure, values: np.ndarray) -> np.ndarray:
    """The same configuration in its standard writing: rod lengths not negative, angles in (-pi, pi] and moved by
    whole turns into their limits where possible, quaternions of unit length with w >= 0."""
    values = values.copy()
    for c in closure.coordinates:
        place = closure.slices[c.name]
        if c.kind == "quaternion":
            values[place] = _positive(values[place] / np.linalg.norm(values[place]))
        elif c.kind == "angle":
            values[place] = _wrap(float(values[place][0]), c.limits)
        elif c.least is not None and values[place][0] < c.least:
            values[place] = 2.0 * c.least - values[place]
        values[place] += 0.0
    return values


def _wrap(angle: float, limits: tuple[float, float] | None) -> float:
    wrapped = math.remainder(angle, 2 * math.pi)
    if wrapped <= -math.pi + 1e-15:
        wrapped += 2 * math.pi
    if limits is not None and not limits[0] <= wrapped <= limits[1]:
        turns = math.ceil((limits[0] - wrapped) / (2 * math.pi) - 1e-12)
        if wrapped + 2 * math.pi * turns <= limits[1] + 1e-12:
            wrapped += 2 * math.pi * turns
    return wrapped


def _positive(q: np.ndarray) -> np.ndarray:
    leading = next((v for v in q if abs(v) > 1e-12), 1.0)
    return np.asarray((q if leading > 0 else -q) + 0.0)


def _within_limits(closure: Closure, values: np.ndarray) -> bool | None:
    limited = [c for c in closure.coordinates if c.limits is not None]
    if not limited:
        return None
    return all(_inside(c, float(values[closure.slices[c.name]][0]), closure.size) for c in limited)


def _inside(c: Coordinate, value: float, size: float) -> bool:
    if c.limits is None:
        return True
    slack = 1e-9 * (1.0 if c.is_angular else size)
    return c.limits[0] - slack <= value <= c.limits[1] + slack


def _coordinates(mechanism: Mechanism) -> tuple[Coordinate, ...]:
    from symkin.closure.closure import build_closure

    return build_closure(mechanism).coordinates


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
