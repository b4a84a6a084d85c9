"""The loop closure F(q, x, X, p) = 0 of a mechanism, built once and symbolically.

Each loop is cut at its passive joint of most freedom, and only what that joint constrains is written: two spherical
ends give one distance equation, a spherical end three, a universal or cylindrical end four, a revolute or prismatic
end five, none six. Every row has the dimension of a length: angular rows are multiplied by the mechanism's size.

Orientation rows are components of the vector part of a relative unit quaternion e = q_B* q_P. Its vector part vanishes
only where the two rotations are equal (that of R^T R' also vanishes for half turns), and its part normal to an axis a
only where e is a turn about a, so that these rows have no spurious roots and stay linear in the platform's quaternion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from symkin.model.chain import Chain, JointSymbols, PlatformMotion, Step
from symkin.model.dh import reference_frames
from symkin.model.joint import Coordinate
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism
from symkin.model.parameters import ParameterTable
from symkin.spatial.backend import cross, dot
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply

_ZERO_ROW = 1e-11
_POSE_COORDINATES: dict[str, tuple[tuple[str, str], ...]] = {
    "spatial": (("x", "length"), ("y", "length"), ("z", "length"), ("quaternion", "quaternion")),
    "schoenflies": (("x", "length"), ("y", "length"), ("z", "length"), ("gamma", "angle")),
    "planar": (("x", "length"), ("y", "length"), ("gamma", "angle")),
    "translation": (("x", "length"), ("y", "length"), ("z", "length")),
    "spherical": (("quaternion", "quaternion"),),
}


@dataclass(frozen=True)
class Row:
    """Where a row of the closure comes from: the limb and the relation that its cut joint keeps."""

    limb: str
    relation: str


@dataclass(frozen=True, eq=False)
class Closure:
    """Rows F and their full check over the variables (q, x, X) and the geometry p.

    `variables` stacks the coordinates in the order actuated, passive, pose; a quaternion takes four numbers, and its
    norm is not among the rows. `errors` restates every constraint without squares and with whole rotation matrices:
    distances for the distance rows, axis and frame vectors times the size for the others (length unit). `pose` is the
    platform's pose as an expression of the pose coordinates; `forward` that of the joints, where a limb has no passive
    joint (a serial arm); `idle` names the freedoms that the closure does not hold.
    """

    mechanism: Mechanism
    coordinates: tuple[Coordinate, ...]
    variables: ca.SX
    parameters: ca.SX
    parameter_names: tuple[str, ...]
    parameter_values: np.ndarray
    rows: ca.SX
    row_sources: tuple[Row, ...]
    errors: ca.SX
    pose: Pose
    forward: Pose | None
    idle: tuple[str, ...]

    @property
    def size(self) -> float:
        return self.mechanism.size

    @cached_property
    def slices(self) -> dict[str, slice]:
        """Where each coordinate stands in `variables`."""
        places, start = {}, 0
        for coordinate in self.coordinates:
            places[coordinate.name] = slice(start, start + coordinate.width)
            start += coordinate.width
        return places

    @cached_property
    def reference(self) -> np.ndarray:
        """Values of `variables` at the reference configuration."""
        return np.concatenate([np.array(c.reference) for c in self.coordinates])

    def bound(self, expression: ca.SX) -> ca.SX:
        """The expression with the nominal geometry in place of p; constants fold."""
        return ca.substitute(expression, self.parameters, ca.SX(ca.DM(self.parameter_values)))

    def role(self, *roles: str) -> tuple[Coordinate, ...]:
        return tuple(c for c in self.coordinates if c.role in roles)


@lru_cache(maxsize=128)
def build_closure(mechanism: Mechanism) -> Closure:
    """The closure of a mechanism; mechanisms are frozen, so that it is built once for each."""
    return _Builder(mechanism).build()


class _Builder:
    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.table = ParameterTable()
        self.coordinates: dict[str, tuple[Coordinate, ca.SX]] = {}
        self.rows: list[ca.SX] = []
        self.sources: list[Row] = []
        self.errors: list[ca.SX] = []
        self.idle: list[str] = []
        self.forward: Pose | None = None

    def build(self) -> Closure:
        m = self.mechanism
        joints, tool = self._geometry()
        self.limb_joints = joints
        self._declare_pose(tool)
        for limb in m.limbs:
            if isinstance(limb, RodLimb):
                self._rod_limb(limb)
            else:
                self._limb(limb, joints[limb.name])
        return self._assemble()

    # --- geometry and pose ---------------------------------------------------------------------------------------

    def _geometry(self) -> tuple[dict[str, list[JointSymbols]], Pose]:
        """Joints of each limb and the platform's reference pose as expressions of the parameters."""
        m, table = self.mechanism, self.table
        if m.dh is not None:
            rows = []
            for k, row in enumerate(m.dh.rows, start=1):
                rows.append([table.scalar(f"dh.{k}.{key}", getattr(row, key)) for key in ("theta", "d", "a", "alpha")])
            frames, tool = reference_frames(m.dh.convention, rows)
            symbols = [
                JointSymbols(joint, ca.SX(point), ca.SX(axis), None, None, ca.SX(0))
                for (_, joint), (point, axis) in zip(m.joints, frames, strict=True)
            ]
            return {m.limbs[0].name: symbols}, Pose(ca.SX(tool.position), ca.SX(tool.quaternion))
        joints: dict[str, list[JointSymbols]] = {}
        for limb, joint in m.joints:
            path = joint.name if m.serial else f"{limb.name}.{joint.name}"
            joints.setdefault(limb.name, []).append(JointSymbols.declare(joint, path, table))
        frame = "tool" if m.serial else "platform"
        position = table.vector(f"{frame}.position", m.platform_position)
        quaternion = table.vector(f"{frame}.quaternion", m.platform_quaternion, "wxyz")
        return joints, Pose(position, quaternion / ca.sqrt(ca.dot(quaternion, quaternion)))

    def _declare_pose(self, reference: Pose) -> None:
        m = self.mechanism
        values: dict[str, ca.SX] = {}
        nominal = {"x": 0, "y": 1, "z": 2}
        for name, kind in _POSE_COORDINATES[m.motion]:
            if name == "quaternion":
                start = m.platform_quaternion
            else:
                start = (m.platform_position[nominal[name]],) if name in nominal else (0.0,)
            coordinate = Coordinate(f"pose.{name}", kind, "pose", tuple(start))  # type: ignore[arg-type]
            values[name] = self._symbol(coordinate)
        position = ca.vertcat(*(values.get(name, reference.position[i]) for name, i in nominal.items()))
        if "quaternion" in values:
            quaternion = values["quaternion"]
            displacement = multiply(quaternion, conjugate(reference.quaternion))
        else:
            half = 0.5 * values.get("gamma", ca.SX(0))
            displacement = ca.vertcat(ca.cos(half), 0, 0, ca.sin(half))
            quaternion = multiply(displacement, reference.quaternion)
        self.pose = Pose(position, quaternion)
        self.platform = PlatformMotion(position, displacement, reference.position)
        self.reference = reference

    def _symbol(self, coordinate: Coordinate) -> ca.SX:
        symbol = ca.SX.sym(coordinate.name, coordinate.width)
        self.coordinates[coordinate.name] = (coordinate, symbol)
        return symbol

    def _steps(self, joints: Sequence[JointSymbols]) -> tuple[Step, ...]:
        steps: list[Step] = []
        for symbols in joints:
            values = []
            for coordinate in symbols.joint.coordinates:
                known = self.coordinates.get(coordinate.name)
                values.append(known[1] if known else self._symbol(coordinate))
            steps.extend(symbols.steps(values))
        return tuple(steps)

    # --- limbs ---------------------------------------------------------------------------------------------------

    def _add(self, limb: str, relation: str, rows: Sequence[ca.SX], errors: Sequence[ca.SX]) -> None:
        self.rows.extend(rows)
        self.sources.extend(Row(limb, relation) for _ in rows)
        self.errors.extend(errors)

    def _distance(self, limb: str, difference: ca.SX, length: ca.SX, squared: ca.SX | None = None) -> None:
        """(d.d - length^2) / (2 size) = 0, checked as |d| - length."""
        d2 = dot(difference, difference)
        l2 = length * length if squared is None else squared
        self._add(limb, "distance", [(d2 - l2) / (2 * self.mechanism.size)], [ca.sqrt(d2) - length])

    def _rod_limb(self, limb: RodLimb) -> None:
        table = self.table
        base = table.vector(f"{limb.name}.base", limb.base)
        end = table.vector(f"{limb.name}.platform", limb.platform)
        offset = table.scalar(f"{limb.name}.offset", limb.offset)
        value = self._symbol(limb.coordinate(self.mechanism.reference_rod_value(limb)))
        self._distance(limb.name, self.pose.apply(end) - base, offset + value)
        self.idle.append(f"{limb.name}: spin of the rod" if limb.type == "SPS" else "")

    def _limb(self, limb: Limb, joints: list[JointSymbols]) -> None:
        if limb.rods:
            self._rods(limb, joints)
            return
        balls = [i for i, symbols in enumerate(joints) if symbols.joint.type == "S"]
        if len(balls) >= 2:
            self._two_balls(limb, joints, balls[0], balls[-1])
            return
        cut = _cut_index(joints)
        base = Chain(self._steps(joints if cut is None else joints[:cut]))
        after = () if cut is None else self._steps(joints[cut + 1 :])
        platform = Chain((self.platform, *(step.inverse() for step in reversed(after))))  # type: ignore[union-attr]
        if cut is None:
            self._none_cut(limb.name, base, platform)
        else:
            self._cut(limb.name, joints[cut], base, platform)
            self.idle.extend(f"{limb.name}: {c.name} (cut)" for c in joints[cut].joint.coordinates)

    def _rods(self, limb: Limb, joints: list[JointSymbols]) -> None:
        chain = Chain(self._steps(joints))
        for k, rod in enumerate(limb.rods, start=1):
            path = f"{limb.name}.rod{k}"
            start = self.table.vector(f"{path}.from", rod.start)
            end = self.table.vector(f"{path}.platform", rod.platform)
            at_reference = np.array(rod.start) - self.mechanism.reference_pose.apply(np.array(rod.platform))
            length = rod.length if rod.length is not None else float(np.linalg.norm(at_reference))
            self._distance(limb.name, self.pose.apply(end) - chain.move(start), self.table.scalar(f"{path}.length", length))
            self.idle.append(f"{limb.name}: spin of rod {k}")

    def _two_balls(self, limb: Limb, joints: list[JointSymbols], first: int, last: int) -> None:
        base = Chain(self._steps(joints[:first])).move(joints[first].point)
        between = Chain(self._steps(joints[first + 1 : last])).move(joints[last].point) - joints[first].point
        after = self._steps(joints[last + 1 :])
        platform = Chain((self.platform, *(step.inverse() for step in reversed(after))))  # type: ignore[union-attr]
        squared = dot(between, between)
        self._distance(limb.name, platform.move(joints[last].point) - base, ca.sqrt(squared), squared)
        self.idle.append(f"{limb.name}: {joints[first].joint.name}, {joints[last].joint.name} (cut)")

    def _none_cut(self, name: str, base: Chain, platform: Chain) -> None:
        size, origin = self.mechanism.size, self.reference.position
        gap = platform.move(origin) - base.move(origin)
        e = multiply(conjugate(base.quaternion), platform.quaternion)
        full = ca.vertcat(*(platform.direction(u) - base.direction(u) for u in _unit_vectors()))
        if all(c.role == "actuated" for step in self.limb_joints[name] for c in step.joint.coordinates):
            self.forward = Pose(base.move(origin), multiply(base.quaternion, self.reference.quaternion))
        self._add(
            name, "frame", [*ca.vertsplit(gap), *(2 * size * e[i] for i in (1, 2, 3))],
            [*ca.vertsplit(gap), *ca.vertsplit(size * full)],
        )  # fmt: skip

    def _cut(self, name: str, symbols: JointSymbols, base: Chain, platform: Chain) -> None:
        size, point, axis = self.mechanism.size, symbols.point, symbols.axis
        gap = platform.move(point) - base.move(point)
        kind = symbols.joint.type
        if kind in "SRU":
            self._add(name, "point", ca.vertsplit(gap), ca.vertsplit(gap))
        if kind == "S":
            return
        assert axis is not None  # noqa: S101 - every cut joint but S has an axis
        if kind == "U":
            angle = dot(base.direction(axis), platform.direction(symbols.axis2)) - dot(axis, symbols.axis2)
            self._add(name, "axes' angle", [size * angle], [size * angle])
            return
        u, v = _normals(axis, symbols.joint.axis)
        if kind in "CP":
            offsets = [dot(base.direction(n), gap) for n in (u, v)]
            self._add(name, "line", offsets, offsets)
        e = multiply(conjugate(base.quaternion), platform.quaternion)
        if kind == "P":
            full = ca.vertcat(*(platform.direction(n) - base.direction(n) for n in _unit_vectors()))
            rows = [2 * size * e[i] for i in (1, 2, 3)]
            self._add(name, "orientation", rows, ca.vertsplit(size * full))
        else:
            parallel = platform.direction(axis) - base.direction(axis)
            rows = [2 * size * dot(e[1:], n) for n in (u, v)]
            self._add(name, "axis", rows, ca.vertsplit(size * parallel))

    # --- assembly ------------------------------------------------------------------------------------------------

    def _assemble(self) -> Closure:
        order = {"actuated": 0, "passive": 1, "pose": 2}
        pairs = sorted(self.coordinates.values(), key=lambda pair: order[pair[0].role])
        actuated = {c.name: k for k, c in enumerate(self.mechanism.actuated)}
        in_file_order = sorted((p for p in pairs if p[0].role == "actuated"), key=lambda p: actuated[p[0].name])
        pairs = in_file_order + [p for p in pairs if p[0].role != "actuated"]
        coordinates = tuple(pair[0] for pair in pairs)
        variables = ca.vertcat(*(pair[1] for pair in pairs))
        symbols, names, values = self._used_parameters()
        rows, sources = self._nonzero_rows(coordinates, variables, symbols, values)
        return Closure(
            self.mechanism, coordinates, variables, symbols, names, values, rows, sources,
            ca.vertcat(*self.errors), self.pose, self.forward, tuple(text for text in self.idle if text),
        )  # fmt: skip

    def _used_parameters(self) -> tuple[ca.SX, tuple[str, ...], np.ndarray]:
        """Only parameters on which the closure or the tool pose depends."""
        table = self.table
        everything = ca.vertcat(*table.symbols)
        depends = ca.which_depends(ca.vertcat(*self.rows, self.pose.position, self.pose.quaternion), everything, 1, False)
        used = [k for k, flag in enumerate(depends) if flag]
        symbols = ca.vertcat(*(table.symbols[k] for k in used)) if used else ca.SX(0, 1)
        return symbols, tuple(table.names[k] for k in used), np.array([table.values[k] for k in used])

    def _nonzero_rows(
        self, coordinates: Sequence[Coordinate], variables: ca.SX, symbols: ca.SX, values: np.ndarray
    ) -> tuple[ca.SX, tuple[Row, ...]]:
        """Rows that a restricted motion leaves: those that vanish identically at the nominal geometry are dropped."""
        rows = ca.vertcat(*self.rows)
        if self.mechanism.motion == "spatial":
            return rows, tuple(self.sources)
        evaluate = ca.Function("rows", [variables, symbols], [rows])
        rng = np.random.default_rng(0)
        largest = np.zeros(rows.shape[0])
        for _ in range(3):
            sample = random_values(coordinates, self.mechanism.size, rng)
            largest = np.maximum(largest, np.abs(np.asarray(evaluate(sample, values))).ravel())
        keep = [int(k) for k in np.flatnonzero(largest > _ZERO_ROW * self.mechanism.size)]
        return rows[keep, 0], tuple(self.sources[k] for k in keep)


def random_values(coordinates: Sequence[Coordinate], size: float, rng: np.random.Generator) -> np.ndarray:
    """Random coordinate values about the reference: lengths by the size, angles and rotations anywhere."""
    parts = []
    for c in coordinates:
        match c.kind:
            case "length":
                parts.append(np.array(c.reference) + size * rng.uniform(-1, 1, 1))
            case "quaternion":
                q = rng.normal(size=4)
                parts.append(q / np.linalg.norm(q))
            case _:
                parts.append(np.array(c.reference) + rng.uniform(-np.pi, np.pi, 1))
    return np.concatenate(parts)


def _unit_vectors() -> list[ca.SX]:
    return [ca.SX([1, 0, 0]), ca.SX([0, 1, 0]), ca.SX([0, 0, 1])]


def _normals(axis: ca.SX, nominal: Sequence[float] | None) -> tuple[ca.SX, ca.SX]:
    """Two unit vectors that make a right-handed frame with the axis, chosen at its nominal direction."""
    helper = [ca.SX(0)] * 3
    helper[int(np.argmin(np.abs(np.array(nominal))))] = ca.SX(1)
    u = cross(ca.vertcat(*helper), axis)
    u = u / ca.sqrt(dot(u, u))
    return u, cross(axis, u)


def _cut_index(joints: Sequence[JointSymbols]) -> int | None:
    """The passive joint of most freedom, the last of equals; helical joints are never cut (their angle stays)."""
    best: int | None = None
    for i, symbols in enumerate(joints):
        joint = symbols.joint
        if joint.actuated or joint.type == "H":
            continue
        if best is None or joint.freedom >= joints[best].joint.freedom:
            best = i
    return best
