"""The points of a sweep: a grid, or a random sample of boxes, of actuated joints or of poses.

Values are in the mechanism's units; poses are made as `pose_points` says.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.given import Joints, in_file_order, joint_values, pose_from
from symkin.position.varied_pose import ALL_POSE_AXES, pose_at
from symkin.spatial.pose import Pose
from symkin.sweeps.pose_points import check_poses, pose_units, pose_values

Values = Sequence[float] | np.ndarray
MOST_POINTS = 10**9


@dataclass(frozen=True, eq=False)
class Axis:
    """What is swept: all `values` of a grid, or of a sample the least and the largest."""

    name: str
    unit: str
    values: np.ndarray

    def __str__(self) -> str:
        """Every digit that decides the points."""
        steps = np.diff(self.values)
        if len(steps) < 2 or np.array_equal(self.values, np.linspace(self.values[0], self.values[-1], len(self.values))):
            return f"{len(self.values)} values from {float(self.values[0])!r} to {float(self.values[-1])!r}"
        return f"values {[float(v) for v in self.values]}"


@dataclass(frozen=True, eq=False)
class Space:
    """Points of a mechanism's inputs (`poses` false) or poses; `base` holds joint values, or x, y, z, qw, qx, qy, qz, for
    what is not swept. `sample` is the count of random points, None for a grid, whose last axis runs fastest."""

    mechanism: Mechanism
    poses: bool
    axes: tuple[Axis, ...]
    base: tuple[float, ...]
    sample: int | None = None
    seed: int = 0

    @property
    def shape(self) -> tuple[int, ...]:
        return (self.sample,) if self.sample is not None else tuple(len(axis.values) for axis in self.axes)

    @property
    def size(self) -> int:
        return math.prod(self.shape)

    def points(self, block: tuple[slice, ...]) -> np.ndarray:
        """Coordinates (n, axes) of the points in a block, one slice for each dimension of `shape`. A random point depends on
        the seed and its place only."""
        if self.sample is None:
            parts = [axis.values[place] for axis, place in zip(self.axes, block, strict=True)]
            return np.stack([part.ravel() for part in np.meshgrid(*parts, indexing="ij")], axis=1)
        low, high = (np.array([axis.values[end] for axis in self.axes]) for end in (0, -1))
        bits = np.random.PCG64(self.seed).advance(block[0].start * len(self.axes))
        shares = np.random.Generator(bits).random((block[0].stop - block[0].start, len(self.axes)))
        return np.asarray(low + shares * (high - low))

    def given(self, point: Sequence[float]) -> dict[str, Any]:
        """The arguments of `symkin.modes` at one point."""
        swept = {axis.name: float(value) for axis, value in zip(self.axes, point, strict=True)}
        if not self.poses:
            names = [c.name for c in self.mechanism.actuated]
            return {"joints": [swept.get(name, value) for name, value in zip(names, self.base, strict=True)]}
        return {"pose": pose_at(self.mechanism, self.base, swept)}

    def known_values(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What `symkin.modes` is given at points (n, axes): known values (n, numbers) in the length unit and radians, and how far
        a pose lies off those that the mechanism can take (n,)."""
        swept = {axis.name: points[:, k] for k, axis in enumerate(self.axes)}
        if self.poses:
            return pose_values(self.mechanism, self.base, swept)
        columns = []
        for c, held in zip(self.mechanism.actuated, self.base, strict=True):
            values = np.broadcast_to(swept.get(c.name, held), len(points))
            columns.append(_angles_in(self.mechanism, values, whole_turns=c.kind == "angle") if c.is_angular else values)
        return np.stack(columns, axis=1), np.zeros(len(points))

    def pinned(self) -> dict[str, Any]:
        """All that decides the points, for people and for comparison."""
        ways = {axis.name: str(axis) for axis in self.axes}
        if self.sample is not None:
            ways = {axis.name: f"{float(axis.values[0])!r} to {float(axis.values[-1])!r}" for axis in self.axes}
        return {"sweeps over": "poses" if self.poses else "inputs", "axes": ways, "base": list(self.base), "sample": self.sample}


def make_space(
    mechanism: Mechanism, ranges: Mapping[str, Values], *, poses: bool = False, at: Joints | Pose | None = None,
    sample: int | None = None, seed: int = 0,
) -> Space:  # fmt: skip
    """A checked space. `ranges` maps joints, or coordinates of the platform's motion, to their values, in a sample to (least,
    largest); `at` gives what is not swept: all actuated joints, or a pose (default: the example's, else the reference's).
    Raises InputError for names, values and counts that do not fit, and for poses of which the joints allow hardly any."""
    if not ranges:
        raise InputError("grid: nothing is swept; give at least one name with its values")
    if sample is not None and not 1 <= sample <= MOST_POINTS:
        raise InputError(f"random = {sample}; allowed: 1 to {MOST_POINTS} points")
    if seed < 0:
        raise InputError(f"seed = {seed} must not be negative")
    units = _units(mechanism, poses)
    axes = tuple(
        _axis(mechanism, name, values, units, poses=poses, sampled=sample is not None) for name, values in ranges.items()
    )
    space = Space(mechanism, poses, axes, _base(mechanism, poses, at), sample, seed)
    if space.size > MOST_POINTS:
        raise InputError(f"grid: {space.size} points; allowed: at most {MOST_POINTS}")
    if poses:
        check_poses(mechanism, space.base, {axis.name: axis.values for axis in axes})
    else:
        for end in (0, -1):
            joint_values(mechanism, space.given([float(axis.values[end]) for axis in axes])["joints"], "grid")
    return space


def _angles_in(mechanism: Mechanism, values: np.ndarray, *, whole_turns: bool) -> np.ndarray:
    """Angles (n,) in radians, those of more than a turn without `whole_turns` where these mean nothing."""
    turn = mechanism.angle_out(2 * math.pi)
    many = np.flatnonzero(np.abs(values) > turn)
    if whole_turns and many.size:
        values = values.copy()
        values[many] = [math.remainder(value, turn) for value in values[many]]
    return np.radians(values) if mechanism.angle_unit == "deg" else values


def _units(mechanism: Mechanism, poses: bool) -> dict[str, str]:
    """Names that can be swept, with their units."""
    if poses:
        return pose_units(mechanism)
    return {c.name: mechanism.angle_unit if c.is_angular else mechanism.length_unit for c in mechanism.actuated}


def _unknown(mechanism: Mechanism, name: str, units: Mapping[str, str], poses: bool) -> str:
    """What can be swept in place of a name, and why a pose coordinate cannot."""
    allowed = ", ".join(units) or "nothing"
    if poses and name in ALL_POSE_AXES:
        return f"grid: poses of {mechanism.name}, of {mechanism.motion} motion, have no {name!r} to sweep; allowed: {allowed}"
    hint = "; poses are swept with --poses (over='poses')" if not poses and name in ALL_POSE_AXES else ""
    return f"grid: {mechanism.name} has no {name!r} to sweep; allowed: {allowed}{hint}"


def _axis(mechanism: Mechanism, name: str, values: Values, units: Mapping[str, str], *, poses: bool, sampled: bool) -> Axis:
    if name not in units:
        raise InputError(_unknown(mechanism, name, units, poses))
    try:
        numbers = np.array([float(v) for v in np.asarray(values).ravel()])
    except (TypeError, ValueError):
        raise InputError(f"grid: {name} = {values!r} is no list of numbers") from None
    if not len(numbers):
        raise InputError(f"grid: {name} has no values; at least one is needed")
    if not np.isfinite(numbers).all():
        raise InputError(f"grid: {name} has a value that is not finite ({numbers[~np.isfinite(numbers)][0]})")
    if sampled and len(numbers) != 2:
        raise InputError(f"grid: {name} has {len(numbers)} values; a random sample takes the least and the largest")
    if sampled and numbers[1] < numbers[0]:
        raise InputError(f"grid: {name} = {numbers[0]:g}:{numbers[1]:g} is reversed; the lower bound comes first")
    if not sampled and not (np.diff(numbers) > 0).all():
        raise InputError(f"grid: the values of {name} do not rise; they must, and none may come twice")
    return Axis(name, units[name], numbers)


def _base(mechanism: Mechanism, poses: bool, at: Joints | Pose | None) -> tuple[float, ...]:
    example = mechanism.example
    if poses:
        if at is None:
            at = mechanism.reference_pose if example is None or example.pose is None else example.pose
        pose = pose_from(at, "at")
        return tuple(float(v) for v in (*pose.position, *pose.quaternion))
    if at is None and example is not None and example.joints is not None:
        at = example.joints
    if at is None:
        references = [(c, c.reference[0]) for c in mechanism.actuated]
        return tuple(mechanism.angle_out(v) if c.is_angular else v for c, v in references)
    if isinstance(at, Pose):
        raise InputError("at: a pose is given; a sweep over inputs takes all actuated joints (over='poses' sweeps over poses)")
    joint_values(mechanism, at, "at")
    return tuple(float(v) for v in in_file_order(mechanism, at, "at"))


@dataclass(frozen=True)
class Blocks:
    """The chunks of an array: boxes of at most `chunk` points, whole along the last axes, cut along one, single before."""

    shape: tuple[int, ...]
    chunk: int

    @property
    def box(self) -> tuple[int, ...]:
        """Points of a chunk along each axis."""
        left, box = self.chunk, []
        for length in reversed(self.shape):
            box.append(max(1, min(length, left)))
            left //= box[-1]
        return tuple(reversed(box))

    @property
    def grid(self) -> tuple[int, ...]:
        return tuple(-(-length // side) for length, side in zip(self.shape, self.box, strict=True))

    def __len__(self) -> int:
        return math.prod(self.grid)

    def __getitem__(self, index: int) -> tuple[slice, ...]:
        if not 0 <= index < len(self):
            raise IndexError(index)
        places = np.unravel_index(index, self.grid)
        return tuple(
            slice(int(i) * side, min((int(i) + 1) * side, length))
            for i, side, length in zip(places, self.box, self.shape, strict=True)
        )
