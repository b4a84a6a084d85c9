"""The points of a sweep: a grid, or a random sample of boxes, of actuated joints, of poses, or of
coordinates told by name.

Values are in the mechanism's units; poses are made as `pose_points` says.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NoReturn

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.given import (
    Given,
    Joints,
    given_coordinates,
    given_joints,
    pose_from,
    read_given,
)
from symkin.position.problem import Problem, build_problem
from symkin.position.varied_pose import ALL_POSE_AXES, given_at
from symkin.spatial.pose import Pose
from symkin.sweeps.pose_points import check_poses, pose_units, pose_values
from symkin.text import meant
from symkin.verb_options import check_seed

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
        if len(steps) < 2 or np.array_equal(
            self.values, np.linspace(self.values[0], self.values[-1], len(self.values))
        ):
            return (
                f"{len(self.values)} values from {float(self.values[0])!r} to "
                f"{float(self.values[-1])!r}"
            )
        return f"values {[float(v) for v in self.values]}"


Over = Literal["inputs", "poses", "coordinates"]


@dataclass(frozen=True, eq=False)
class Space:
    """Points of a mechanism's inputs, poses or coordinates told by name; `base` holds what is not
    swept: joint values, or x, y, z, qw, qx, qy, qz, or values by name. `sample` is the count of
    random points, None for a grid, whose last axis runs fastest.
    """

    mechanism: Mechanism
    over: Over
    axes: tuple[Axis, ...]
    base: tuple[float, ...] | Mapping[str, Any]
    sample: int | None = None
    seed: int = 0

    @property
    def shape(self) -> tuple[int, ...]:
        return (
            (self.sample,)
            if self.sample is not None
            else tuple(len(axis.values) for axis in self.axes)
        )

    @property
    def size(self) -> int:
        return math.prod(self.shape)

    def points(self, block: tuple[slice, ...]) -> np.ndarray:
        """Coordinates (n, axes) of the points in a block, one slice for each dimension of `shape`.
        A random point depends on the seed and its place only.
        """
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
        return given_at(self.mechanism, self.base, swept, of_pose=self.over == "poses")

    def given_at_end(self, end: int) -> Given:
        """What is given at the first (0) or the last point (-1) of the box. Raises InputError for
        values that do not fit.
        """
        return read_given(
            self.mechanism, **self.given([float(axis.values[end]) for axis in self.axes])
        )

    @cached_property
    def problem(self) -> Problem:
        """The problem of all points."""
        return build_problem(self.mechanism, self.given_at_end(0).names)

    def known_values(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What `symkin.modes` is given at points (n, axes): known values (n, numbers) in the length
        unit and radians, and how far a pose lies off those that the mechanism can take (n,).
        """
        swept = {axis.name: points[:, k] for k, axis in enumerate(self.axes)}
        if self.over == "poses" and not isinstance(self.base, Mapping):
            return pose_values(self.mechanism, self.base, swept)
        held, place = self.given_at_end(0), 0
        values = np.tile(held.values, (len(points), 1))
        for c in self.problem.known_coordinates:
            if c.name in swept:
                column = swept[c.name]
                values[:, place] = (
                    _angles_in(self.mechanism, column, whole_turns=c.is_periodic)
                    if c.is_angular
                    else column
                )
            place += c.width
        return values, np.full(len(points), held.off_motion)

    def pinned(self) -> dict[str, Any]:
        """All that decides the points, for people and for comparison."""
        ways = {axis.name: str(axis) for axis in self.axes}
        if self.sample is not None:
            ways = {
                axis.name: f"{float(axis.values[0])!r} to {float(axis.values[-1])!r}"
                for axis in self.axes
            }
        base = dict(self.base) if isinstance(self.base, Mapping) else list(self.base)
        return {"sweeps over": self.over, "axes": ways, "base": base, "sample": self.sample}


def make_space(
    mechanism: Mechanism,
    ranges: Mapping[str, float | Values],
    *,
    over: Over = "inputs",
    at: Joints | Pose | None = None,
    sample: int | None = None,
    seed: int = 0,
) -> Space:
    """A checked space. `ranges` maps actuated joints, coordinates of the platform's motion, or any
    coordinates, to their values, in a sample to (least, largest). What is not swept is held: by
    `at`, all actuated joints or a pose (default: the example's, else the reference's), or, of any
    coordinates, where one number or a whole "pose" is told. Raises InputError for names, values and
    counts that do not fit, and for poses of which the joints allow hardly any.
    """
    by_name, what = over == "coordinates", "given" if over == "coordinates" else "grid"
    if not ranges and not by_name:
        raise InputError("grid: nothing is swept; give at least one name with its values")
    if sample is not None and not 1 <= sample <= MOST_POINTS:
        raise InputError(f"random = {sample}; allowed: 1 to {MOST_POINTS} points")
    check_seed(seed)
    units = _units(mechanism, over)
    held = {n: v for n, v in ranges.items() if by_name and (np.ndim(v) == 0 or n not in units)}
    axes = tuple(
        _axis(n, values, units.get(n) or _refused(mechanism, n, units, over), what, sample)
        for n, values in ranges.items()
        if n not in held
    )
    base = held if by_name else _base(mechanism, over == "poses", at)
    space = Space(mechanism, over, axes, base, sample, seed)
    _check_ends(space)
    if not axes:
        example = next(iter(units), "NAME")
        raise InputError(
            f"given: nothing is swept; give at least one name several values, as in "
            f"{example}=0:90:91 ({{{example!r}: [0, 1, 2]}})"
        )
    if space.size > MOST_POINTS:
        raise InputError(f"{what}: {space.size} points; allowed: at most {MOST_POINTS}")
    if not isinstance(base, Mapping) and over == "poses":
        check_poses(space.problem, base, {axis.name: axis.values for axis in axes})
    return space


def _check_ends(space: Space) -> None:
    """Raise InputError where the first or the last point is none of a sweep's by joints."""
    for end in (0, -1):
        match space.over:
            case "coordinates":
                space.given_at_end(end)
            case "inputs":
                point = [float(axis.values[end]) for axis in space.axes]
                given_joints(space.mechanism, space.given(point)["joints"], "grid")


def _angles_in(mechanism: Mechanism, values: np.ndarray, *, whole_turns: bool) -> np.ndarray:
    """Angles (n,) in radians, those of more than a turn without `whole_turns` where these mean
    nothing.
    """
    turn = mechanism.angle_out(2 * math.pi)
    many = np.flatnonzero(np.abs(values) > turn)
    if whole_turns and many.size:
        values = values.copy()
        values[many] = [math.remainder(value, turn) for value in values[many]]
    return np.radians(values) if mechanism.angle_unit == "deg" else values


def _units(mechanism: Mechanism, over: Over) -> dict[str, str]:
    """Units of what can be swept, by name."""
    if over == "poses":
        if mechanism.platform_link is None:
            raise InputError(
                f"poses: {mechanism.name} has no platform link; sweep over its inputs, or over "
                f"coordinates by name (given)"
            )
        return pose_units(mechanism)
    told = mechanism.actuated if over == "inputs" else given_coordinates(mechanism).values()
    return {c.name: mechanism.unit_of(c) for c in told}


def _refused(mechanism: Mechanism, name: str, units: Mapping[str, str], over: Over) -> NoReturn:
    """Raise InputError: what can be swept in place of a name, and how this one can."""
    allowed, poses = ", ".join(units) or "nothing", over == "poses"
    if poses and name in ALL_POSE_AXES:
        raise InputError(
            f"grid: poses of {mechanism.name}, of {mechanism.motion} motion, have no {name!r} to "
            f"sweep; allowed: {allowed}"
        )
    hint = ""
    if not poses and name in ALL_POSE_AXES and mechanism.platform_link is not None:
        hint = "; poses are swept with --poses (over='poses')"
    elif not poses and name in given_coordinates(mechanism):
        hint = (
            f"; any coordinates, as many as the mobility, are swept with --given "
            f"{name}=LOW:HIGH:COUNT (given={{...}})"
        )
    raise InputError(
        f"grid: {mechanism.name} has no {name!r} to sweep{'' if hint else meant(name, units)}; "
        f"allowed: {allowed}{hint}"
    )


def _axis(name: str, values: float | Values, unit: str, what: str, sample: int | None) -> Axis:
    try:
        numbers = np.array([float(v) for v in np.asarray(values).ravel()])
    except (TypeError, ValueError):
        raise InputError(f"{what}: {name} = {values!r} is no list of numbers") from None
    if not len(numbers):
        raise InputError(f"{what}: {name} has no values; at least one is needed")
    if not np.isfinite(numbers).all():
        raise InputError(
            f"{what}: {name} has a value that is not finite ({numbers[~np.isfinite(numbers)][0]})"
        )
    if sample is not None and len(numbers) != 2:
        raise InputError(
            f"{what}: {name} has {len(numbers)} values; a random sample takes the least and the "
            f"largest"
        )
    if sample is not None and numbers[1] < numbers[0]:
        raise InputError(
            f"{what}: {name} = {numbers[0]:g}:{numbers[1]:g} is reversed; the lower bound comes "
            f"first"
        )
    if sample is None and not (np.diff(numbers) > 0).all():
        raise InputError(
            f"{what}: the values of {name} do not rise; they must, and none may come twice"
        )
    return Axis(name, unit, numbers)


def _base(mechanism: Mechanism, poses: bool, at: Joints | Pose | None) -> tuple[float, ...]:
    example = mechanism.example
    if poses:
        if at is None:
            at = (
                mechanism.reference_pose
                if example is None or example.pose is None
                else example.pose
            )
        pose = pose_from(at, "at")
        return tuple(float(v) for v in (*pose.position, *pose.quaternion))
    if at is None and example is not None and example.joints is not None:
        at = example.joints
    if at is None:
        references = [(c, c.reference[0]) for c in mechanism.actuated]
        return tuple(mechanism.value_out(c, v) for c, v in references)
    if isinstance(at, Pose):
        raise InputError(
            "at: a pose is given; a sweep over inputs takes all actuated joints (over='poses' "
            "sweeps over poses)"
        )
    return tuple(given_joints(mechanism, at, "at").echo["joints"])


@dataclass(frozen=True)
class Blocks:
    """The chunks of an array: boxes of at most `chunk` points, whole along the last axes, cut along
    one, single before.
    """

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
