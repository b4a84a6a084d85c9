"""One solution of a position problem: its values, their checks, and how they print."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.closure.link_poses import link_poses
from symkin.closure.partition import ALL_JOINTS, Partition
from symkin.computed_once import cached_property
from symkin.model.mechanism import Mechanism
from symkin.position.pose_coordinates import pose_coordinates
from symkin.position.problem import Problem
from symkin.position.readings import left_out, points_at, poses_of, readings
from symkin.result import Result, Summary
from symkin.spatial.pose import Pose
from symkin.text import plain

SINGULAR_NOTE = "singular: the solution is multiple or nearly so, and known to fewer digits"
SIMPLE_NOTE = "nearly singular: one solution, known to fewer digits"
DOUBLE_NOTE = "double: to rounding, two solutions or more meet here, or a set of them passes"


@dataclass(frozen=True)
class PartialProof:
    """`independent` of `rows` rows vanish at one exact point within `radius` of the given one
    (length unit, angles times the size); no other row is more than `remaining` there (length unit).
    """

    independent: int
    rows: int
    radius: float
    remaining: float


@dataclass(frozen=True, eq=False)
class _Read:
    """`values` of joints that a closure leaves out, in radians and the length unit, and named
    `points`, at one configuration.
    """

    values: dict[str, Any]
    points: dict[str, list[float]]


@dataclass(frozen=True, eq=False, repr=False)
class Solution(Result):
    """One configuration that closes all loops: F(q, x, X, p) = 0 to within `residual`.

    `values` maps each closure coordinate to its value (a unit quaternion for S joints); `residual`
    is the largest closure error over all constraints in the length unit; `condition` that of the
    unknowns' Jacobian with angles times the size; `hits` counts the starts that reached it;
    `ground` is what is proved where rows are redundant, so that none of it is `certified`. `values`
    are in radians and the length unit, those of the closure for a `partition`; `joints`, in the
    mechanism's units, those of all joints. `pose` is the base's own where a graph names no platform
    link.

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
    partition: Partition = ALL_JOINTS

    @cached_property
    def joints(self) -> dict[str, Any]:
        """The coordinates of all joints in the mechanism's units: passive and cut ones too, in file
        order for a graph, else those of the closure first.
        """
        order = [*self._printed_names, *(c.name for c in self.mechanism.coordinates)]
        return self._in_units(order, self.all_values)

    @cached_property
    def all_values(self) -> dict[str, Any]:
        """`values` with those of joints that the closure leaves out beside them, in radians and the
        length unit.
        """
        return self.values | self._read.values

    @cached_property
    def points(self) -> dict[str, list[float]]:
        """Where the named points of links are, in the base frame."""
        return self._read.points

    @cached_property
    def link_poses(self) -> dict[str, Pose]:
        """The displacement of each link from the reference, in the base frame."""
        return link_poses(self._closure, self.variables[None]).at(0)

    @property
    def has_platform(self) -> bool:
        """Whether `pose` is that of a link."""
        return self.mechanism.platform_link is not None

    @property
    def variables(self) -> np.ndarray:
        """The full vector of the variables of the closure for its partition."""
        closure = self._closure
        values = closure.reference.copy()
        for name, value in self.values.items():
            values[closure.slices[name]] = value
        return values

    @property
    def _closure(self) -> Closure:
        return build_closure(self.mechanism, self.partition)

    @cached_property
    def _read(self) -> _Read:
        return next(_readings([self]))

    def _in_units(self, names: Iterable[str], values: Mapping[str, Any]) -> dict[str, Any]:
        return in_units(self.mechanism, names, values)

    @property
    def actuated_values(self) -> list[float]:
        """Actuated joint values in file order and the mechanism's units: what `modes(joints=...)`
        takes.
        """
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
    def gamma(self) -> float:
        """The angle about z of a platform of planar or Schoenflies motion, from the reference,
        whether the closure has it or not.
        """
        if "pose.gamma" in self.values:
            return float(self.values["pose.gamma"])
        values, _ = pose_coordinates(self.mechanism, self.pose)
        return float(values[-1])

    @property
    def quaternion(self) -> np.ndarray:
        return np.asarray(self.pose.quaternion, dtype=float)

    @property
    def rotation(self) -> np.ndarray:
        return np.asarray(self.pose.rotation, dtype=float)

    def to_dict(self) -> dict[str, Any]:
        """One entry of `modes` in the JSON of `symkin modes --json`."""
        return {
            "pose": pose_dict(self.pose) if self.has_platform else None,
            "joints": self.joints,
            "points": self.points,
            "residual": self.residual,
            "condition": finite(self.condition),
            "certified": self.certified,
            "radius": self.radius,
            "ground": None if self.ground is None else asdict(self.ground),
            "within_limits": self.within_limits,
            "notes": list(self.notes),
        }

    def summary(self, most_rows: int | None = None) -> Summary:
        """Pose, points, joints and checks, a row each."""
        unit = self.mechanism.length_unit
        pose = dict(
            zip(
                (*(f"{axis} [{unit}]" for axis in "xyz"), "qw", "qx", "qy", "qz"),
                (*self.position, *self.quaternion),
                strict=True,
            )
        )
        points = {
            f"{name}.{axis} [{unit}]": v
            for name, point in self.points.items()
            for axis, v in zip("xyz", point, strict=True)
        }
        units = {
            c.name: self.mechanism.angle_unit if c.is_angular else unit
            for c in self.mechanism.coordinates
        }
        joints = {
            f"{name} [{units[name]}]": v
            for name, v in self.printed_joints.items()
            if isinstance(v, float)
        }
        values = {**(pose if self.has_platform else {}), **points, **joints}
        values |= {f"residual [{unit}]": self.residual, "condition": self.condition}
        rows = [[name, f"{value:.7g}"] for name, value in values.items()]
        return Summary(
            [self.mechanism.name],
            ["", "value"],
            rows[:most_rows],
            [f"note: {note}" for note in self.notes],
        )

    @property
    def _printed_names(self) -> list[str]:
        """All joints of a graph, those of the closure of limbs."""
        graph = self.mechanism.is_graph
        held = self.mechanism.coordinates if graph else self._closure.role("actuated", "passive")
        return [c.name for c in held]

    @cached_property
    def printed_joints(self) -> dict[str, Any]:
        """The joint coordinates that tables show, in the mechanism's units."""
        values = self.values if set(self._printed_names) <= set(self.values) else self.all_values
        return self._in_units(self._printed_names, values)

    def __str__(self) -> str:
        size = self.mechanism.characteristic_length
        parts = [
            f"{name} = {plain(v, size):.6g}"
            for name, v in self.printed_joints.items()
            if isinstance(v, float)
        ]
        where = self.mechanism.name
        if self.has_platform:
            position = ", ".join(f"{plain(v, size):.6g}" for v in self.position.tolist())
            quaternion = ", ".join(f"{plain(v, least=5e-7):.6f}" for v in self.quaternion.tolist())
            where += f" at ({position}) {self.mechanism.length_unit}, quaternion ({quaternion})"
        points = [
            f"{name} ({', '.join(f'{v:.6g}' for v in point)})"
            for name, point in self.points.items()
        ]
        texts = [
            where,
            *points,
            ", ".join(parts),
            f"residual {self.residual:.1e}, condition {self.condition:.3g}",
        ]
        return "; ".join(text for text in texts if text)

    def __repr__(self) -> str:
        return str(self)


def in_units(
    mechanism: Mechanism, names: Iterable[str], values: Mapping[str, Any]
) -> dict[str, Any]:
    """Coordinates' values, from radians and the length unit, as users read them."""
    kinds = {c.name: c for c in mechanism.coordinates}
    return {
        name: [float(v) for v in values[name]]
        if kinds[name].is_rotation
        else mechanism.value_out(kinds[name], values[name])
        for name in names
    }


def pose_dict(pose: Pose) -> dict[str, Any]:
    """A pose in JSON."""
    return {
        "position": np.asarray(pose.position, dtype=float).tolist(),
        "quaternion": np.asarray(pose.quaternion, dtype=float).tolist(),
        "matrix": np.asarray(pose.rotation, dtype=float).tolist(),
    }


def named_values(closure: Closure, values: np.ndarray) -> dict[str, Any]:
    """A full vector of variables by the names of its coordinates; a quaternion is a tuple of
    four.
    """
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


def finite(value: float | None) -> float | None:
    """JSON has no infinity: null stands for it."""
    return value if value is not None and math.isfinite(value) else None


def heading(problem: Problem, given: Mapping[str, Any]) -> dict[str, Any]:
    mechanism = problem.mechanism
    return {
        "mechanism": mechanism.name,
        "problem": problem.name,
        "given": dict(given),
        "length_unit": mechanism.length_unit,
        "angle_unit": mechanism.angle_unit,
    }


def read_together(solutions: Sequence[Solution]) -> None:
    """Find what joints that the closure leaves out read and where named points are, for many
    solutions of one problem at once: each keeps its own.
    """
    unread = [one for one in solutions if "_read" not in vars(one)]
    for one, read in zip(unread, _readings(unread), strict=True):
        vars(one)["_read"] = read


def _readings(solutions: Sequence[Solution]) -> Iterator[_Read]:
    """What is read at each of some solutions of one closure."""
    if not solutions:
        return
    mechanism, closure = solutions[0].mechanism, solutions[0]._closure
    if not left_out(closure) and not mechanism.link_points:
        yield from (_Read({}, {}) for _ in solutions)
        return
    poses = link_poses(closure, np.array([one.variables for one in solutions]))
    read = {name: v.tolist() for name, v in readings(closure, poses).items()}
    points = {name: p.tolist() for name, p in points_at(mechanism, poses).items()}
    for i in range(len(solutions)):
        values = {name: tuple(v[i]) if len(v[i]) > 1 else v[i][0] for name, v in read.items()}
        yield _Read(values, {name: p[i] for name, p in points.items()})
