"""Draw closed configurations at random in a workspace, within joint limits and on home's side of
singularities.

A configuration is drawn as a pose: the middle of the platform's joint points within `half` of its
place at home, and the orientation R = Rz(gamma) Ry(beta) Rx(alpha) R_home with |alpha|, |beta| <=
`tilt` and |gamma| <= `spin`. Home is the reference pose, or that of the worked example where the
reference is much nearer to a singularity. Configurations that share (alpha, beta) have the same
inclination R^T e_z. Platforms that cannot take the pose take the nearest one with that inclination;
serial arms, and mechanisms whose joints carry the platform, are drawn by their joints.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import Any

import numpy as np

from symkin.calibration.data.observables import judged_link
from symkin.calibration.estimate.configuration_model import ConfigurationModel, level_turn
from symkin.calibration.estimate.configurations import (
    ROUGHLY_SOLVED_TOLERANCE,
    ClosedConfigurations,
    Closing,
    closed_at,
    closing_model,
    determinant_signs,
    follow_joints,
    is_carried,
    outside_limits,
    with_poses,
)
from symkin.closure.branches import edges_of
from symkin.closure.closure import Closure
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.bar import Bar
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.numeric.linear_algebra import conditions
from symkin.position.given import pose_from
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import (
    conjugate,
    euler_from_quaternion,
    multiply,
    quaternion_from_euler,
    rotate,
)

DEFAULT_REACH = 0.15
"""Half width of the default workspace, of the size."""
DEFAULT_TILT = math.radians(20)
"""Default range (radians) of each inclination and of the turn about z."""
_ARM_SWING = math.radians(60)
"""Half range (radians) of an arm's angle that has no limits."""
_SAME_PLACE = 1e-4
"""Unknown coordinates (length unit over the size, radians) that differ by less are the same."""
_MIN_DRAWN, _MAX_IDLE_DRAWS = 64, 1000
"""Least number of configurations drawn at once, and draws without a new configuration after which
the drawing is given up.
"""

_LEANING = ("spatial", "spherical")
"""Declared motions in which a platform may lean."""
_POORER_CONDITION = 3.0
"""The example's pose is home where the reference's condition is worse by this factor."""
_SINGULAR_CONDITION, _WORSE_CONDITION = 1e6, 30.0
"""Condition of the direct problem above which home counts as singular, and how many times home's
that of a configuration may be.
"""


@dataclass(frozen=True, eq=False)
class Workspace:
    """Half widths (3,) about home in the length unit; tilt and spin in radians; `margin` is the
    share of each joint's range that is kept free at both its limits. `start` is another home.
    """

    mechanism: Mechanism
    half: np.ndarray
    tilt: float = DEFAULT_TILT
    spin: float = DEFAULT_TILT
    margin: float = 0.0
    start: Pose | None = None

    def __post_init__(self) -> None:
        require_mechanism(self.mechanism)
        half = np.asarray(self.half, dtype=float)
        good = half.shape == (3,) and np.all((half >= 0) & (half < np.inf))
        if not good or min(self.tilt, self.spin) < 0:
            raise InputError(
                f"workspace: half widths {half.tolist()} and angles must be three numbers and not "
                f"negative"
            )
        if self.tilt >= 0.5 * math.pi:
            raise InputError(
                f"workspace: a tilt of {math.degrees(self.tilt):g} deg is too large; allowed: "
                f"below 90 deg"
            )
        object.__setattr__(self, "half", half)

    @staticmethod
    def about(
        mechanism: Mechanism, half: Sequence[float] | None = None, **options: Any
    ) -> Workspace:
        """Make the default workspace: 0.15 of the size and 20 deg about home."""
        reach = [DEFAULT_REACH * mechanism.characteristic_length] * 3
        return Workspace(mechanism, np.array(reach if half is None else half), **options)

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the description alone: what closes configurations holds functions, and is made
        again where it is needed.
        """
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @cached_property
    def centre(self) -> np.ndarray:
        """Middle (3,) of the platform's joint points, in the platform frame."""
        return np.mean(platform_points(self.mechanism), axis=0)

    @cached_property
    def home(self) -> Pose:
        return home_pose(self.mechanism) if self.start is None else self.start

    @cached_property
    def _model(self) -> ConfigurationModel:
        return closing_model(self.mechanism)

    @property
    def closure(self) -> Closure:
        return self._model.closure

    @cached_property
    def _joints(self) -> Closing:
        """The closing of joints for poses."""
        return Closing(self._model, held=("pose",))

    @property
    def lean(self) -> float:
        """The tilt, or 0 where the declared motion keeps the platform level."""
        return self.tilt if self.mechanism.motion in _LEANING else 0.0

    def inclinations(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Draw random (alpha, beta), (count, 2)."""
        return rng.uniform(-self.lean, self.lean, (count, 2))

    def draw(
        self,
        inclinations: np.ndarray,
        rng: np.random.Generator,
        *,
        held: bool = True,
        edge: float = 1.0,
    ) -> ClosedConfigurations:
        """Draw one configuration for each (alpha, beta); with `held` every configuration has
        exactly its inclination. With `edge` above 1 positions and turns are drawn from so many
        times the workspace and brought back to its border.

        Raises InputError where too few draws close within the limits.
        """
        found, count = dict[int, ClosedConfigurations](), len(inclinations)
        drawn, idle = 0, 0
        while (missing := [k for k in range(count) if k not in found]) and idle < _MAX_IDLE_DRAWS:
            chosen = np.resize(missing, max(_MIN_DRAWN, len(missing)))
            drawn, idle = drawn + len(chosen), idle + len(chosen)
            wanted = inclinations[chosen]
            starts = self._starts(wanted, rng, edge)
            made, good = self.close(starts, wanted if held else None)
            for row in np.flatnonzero(good):
                if chosen[row] not in found:
                    found[chosen[row]], idle = made.take(np.array([row])), 0
        if missing:
            raise InputError(
                f"{self.mechanism.name}: only {len(found)} of {count} postures were found in "
                f"{drawn} draws within joint limits and away from singularities "
                f"{self._why_none(inclinations[missing[0]], held)}"
            )
        made = ClosedConfigurations.joined([found[k] for k in range(count)])
        self._check_motion(made)
        return made

    def _check_motion(self, made: ClosedConfigurations) -> None:
        """Raise InputError where all configurations are one although they were drawn apart: loops
        that close at their reference alone.
        """
        size = self.mechanism.characteristic_length
        apart = max(np.ptp(v, axis=0).max(initial=0.0) for v in (made.joints, made.poses))
        if len(made) > 1 and np.any(self.half > 0.0) and apart <= _SAME_PLACE * min(size, 1.0):
            raise InputError(
                f"{self.mechanism.name}: it does not move; {len(made)} random postures are one: "
                f"its loops close there alone; check its geometry, or declare the motion that "
                f"it has"
            )

    def _why_none(self, inclination: np.ndarray, held: bool) -> str:
        """What to do where postures are not found."""
        if self.carried and not held:
            rows, freedom = self._model.system.rows.shape[0], self._model.system.freedom
            redundant = (
                f"; {rows} rows for {freedom} unknowns close at special geometry alone: check it, "
                f"or name fewer joints as actuated"
                if rows > freedom
                else ""
            )
            return f"about the reference; give joints limits within which it moves{redundant}"
        text = ", ".join(f"{angle:g}" for angle in np.degrees(inclination))
        return (
            f"(none for alpha, beta = {text} deg); use a smaller workspace, inclinations that "
            f"the platform can take, or no groups of equal inclination"
        )

    def near(
        self,
        around: ClosedConfigurations,
        inclinations: np.ndarray | None,
        scale: float,
        rng: np.random.Generator,
    ) -> tuple[ClosedConfigurations, np.ndarray]:
        """Draw closed configurations near given ones, moved by `scale` of the workspace, no further
        than its borders; and the numbers of those they are near to.
        """
        if self.carried:
            low, high = self._joint_ranges
            away = 0.5 * scale * (high - low) * rng.uniform(-1, 1, around.joints.shape)
            joints = np.clip(around.joints + away, low, high)
            starts = self.at_joints(joints, around.values)
        else:
            turns = multiply(around.poses[:, 3:].T, conjugate(self.home.quaternion))
            alpha, beta, gamma = euler_from_quaternion(turns, "xyz")
            drawn = scale * rng.uniform(-1, 1, (len(around), 4))
            gamma = np.clip(gamma + self.spin * drawn[:, 0], -self.spin, self.spin)
            away = np.clip(self._middles(around) + self.half * drawn[:, 1:], -self.half, self.half)
            starts = self._posed(around.values, away, np.array([alpha, beta, gamma]))
        made, good = self.close(starts, inclinations)
        if not self.drawn_by_joints:  # whose range is the workspace
            good &= np.all(np.abs(self._middles(made)) <= self.half * (1 + 1e-9), axis=1)
        kept = np.flatnonzero(good)
        return made.take(kept), kept

    def _posed(self, values: np.ndarray, away: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Variables with the middles of the platforms so far from home's (n, 3), and turned from
        home's orientation by angles (3, n).
        """
        q = multiply(quaternion_from_euler(angles, "xyz"), self.home.quaternion).T
        turned = moved_point(np.hstack([np.zeros((len(q), 3)), q]), self.centre)
        places = self.home.apply(self.centre) + away - turned
        return with_poses(self.closure, np.hstack([places, q]), values)

    def _middles(self, made: ClosedConfigurations) -> np.ndarray:
        """Middles of the platforms (n, 3), from home's."""
        return moved_point(made.poses, self.centre) - self.home.apply(self.centre)

    def _starts(
        self, inclinations: np.ndarray, rng: np.random.Generator, edge: float
    ) -> np.ndarray:
        count = len(inclinations)
        starts = np.tile(self.closure.reference, (count, 1))
        if not self.drawn_by_joints:
            share = np.clip(edge * rng.uniform(-1, 1, (count, 4)), -1, 1)
            angles = np.vstack([inclinations.T, self.spin * share[:, 3]])
            return self._posed(starts, self.half * share[:, :3], angles)
        low, high = self._joint_ranges
        joints = rng.uniform(low[:, None], high[:, None], (len(low), count)).T
        return self.at_joints(joints, starts)

    @property
    def carried(self) -> bool:
        """Whether the platform's pose follows from the joints, and no coordinates of its own."""
        return is_carried(self.closure)

    @property
    def drawn_by_joints(self) -> bool:
        """Whether configurations are drawn by their joints and not by the platform's pose."""
        return self.mechanism.serial or self.carried

    @property
    def _joint_ranges(self) -> tuple[np.ndarray, np.ndarray]:
        """Ranges (a,) from which actuated joints are drawn: their limits, else about the
        reference.
        """
        reach, sides = DEFAULT_REACH * self.mechanism.characteristic_length, np.array([-1.0, 1.0])
        low, high = np.reshape(
            [
                c.limits or c.reference[0] + sides * (_ARM_SWING if c.is_angular else reach)
                for c in self.mechanism.actuated
            ],
            (-1, 2),
        ).T
        return low, high

    # --- closing ----------------------------------------------------------------------------------

    def close(
        self, starts: np.ndarray, inclinations: np.ndarray | None, *, limits: bool = True
    ) -> tuple[ClosedConfigurations, np.ndarray]:
        """Close configurations near the starts, and tell which of them are good: closed, with the
        inclination where one is given, within limits, regular, and on home's side of singularities.
        """
        inclined = None
        if inclinations is not None:
            tilts = quaternion_from_euler(np.pad(inclinations, ((0, 0), (0, 1))).T, "xyz")
            level = multiply(self.home.quaternion, level_turn(self.mechanism))
            inclined = np.array(euler_from_quaternion(multiply(tilts, level), "xyz"))[:2].T
        every = Closing(self._model, held=(), inclined=inclined)
        with np.errstate(all="ignore"):
            values, closed = every.close(self._joints.close(starts)[0])
            z, joints = every.split(values)
            made = ClosedConfigurations(values, joints, self._model.poses(z, joints))
            good = closed & self._regular(self._model.values("rows", z, joints)[1])
            if limits:
                good &= np.isfinite(values).all(axis=1)
                for c in self.closure.coordinates:
                    low, high = c.limits or (0.0, 0.0)
                    column = values[:, self.closure.slices[c.name].start]
                    good &= ~outside_limits(c, column, self.margin * (high - low))
        return made, good

    def at_joints(self, joints: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Follow configurations (n, width) from their joints to others (n, a), and return the
        variables there; not numbers where one is lost on the way, or does not come back to where it
        began: it has passed into another assembly mode. Of an arm the tool at its joints.
        """
        follow, size = partial(follow_joints, self._model), self.closure.characteristic_length
        start, begin = self._joints.split(values)
        if not self.carried:
            points = np.hstack([joints, start])
            return Closing(self._model).newton(points, longest=np.inf)[0]
        start = follow(start, begin, begin)
        z = follow(start, begin, joints)
        rows, back = self._model.values("rows", z, joints)[0], follow(z, joints, begin)
        lost = ~(np.abs(rows).max(axis=1, initial=0.0) <= ROUGHLY_SOLVED_TOLERANCE * size)
        lost |= ~(np.abs(back - start).max(axis=1, initial=0.0) <= _SAME_PLACE * max(size, 1.0))
        return np.hstack([joints, np.where(lost[:, None], np.nan, z)])

    @cached_property
    def _at_home(self) -> np.ndarray:
        """F_z (1, m, f) at home."""
        return _rows_at(self._model, self.home)

    def _regular(self, rows_z: np.ndarray) -> np.ndarray:
        (side,), (condition,) = determinant_signs(self._at_home), conditions(self._at_home)
        regular = condition < _SINGULAR_CONDITION
        worst = _WORSE_CONDITION * condition if regular else _SINGULAR_CONDITION
        # a singular home has no side
        beside = determinant_signs(rows_z) * side * regular >= 0
        return (conditions(rows_z) < worst) & beside


def platform_points(mechanism: Mechanism) -> np.ndarray:
    """List the joint points of the platform, or of the link judged in its place, in its frame (n,
    3): ends of rods, joints and named points.
    """
    link, points = judged_link(mechanism), []
    frame = mechanism.reference_pose if mechanism.platform_link is not None else Pose.identity()
    inverse = frame.inverse()  # points of joints are given at the reference
    own = [(edge.ends, edge.elements[0]) for edge in edges_of(mechanism) if link in edge.ends]
    for ends, element in sorted(own, key=lambda each: not isinstance(each[1].part, Bar)):
        if isinstance(bar := element.part, Bar):
            end = (bar.start, bar.end)[ends.index(link)]
            point = np.array(end.point)
            points.append(point if end.in_platform_frame else inverse.apply(point))
        else:
            points.append(inverse.apply(mechanism.places[element.name]))
    points += [inverse.apply(np.array(p.point)) for p in mechanism.link_points if p.link == link]
    return np.array(points)


def moved_point(poses: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Where a point of a frame is at its poses (n, 7)."""
    return poses[:, :3] + rotate(poses[:, 3:].T, point[:, None]).T


def home_pose(mechanism: Mechanism) -> Pose:
    """Return the reference pose; the pose of the worked example where the file states no reference,
    or where the direct problem is conditioned much better there.
    """
    example, reference = mechanism.example, mechanism.reference_pose
    given = None
    if example is not None:
        given = example.pose or (example.start if example.joints is not None else None)
    if mechanism.serial or given is None or len(given) != 7:
        return reference
    shown = pose_from(given, "example")
    if not states_reference(mechanism):
        return shown
    here, there = conditions(_rows_at(closing_model(mechanism), reference, shown))
    return shown if here > _POORER_CONDITION * there else reference


def states_reference(mechanism: Mechanism) -> bool:
    """Tell whether a file says where the platform stands at the reference: rod limbs alone leave it
    open, and it is then the origin.
    """
    return any(mechanism.platform_position) or any(mechanism.all_joints)


def _rows_at(model: ConfigurationModel, *poses: Pose) -> np.ndarray:
    """F_z (n, m, f) at poses, with the joints that lead there."""
    table = np.array([[*pose.position, *pose.quaternion] for pose in poses])
    closing, values, _ = closed_at(model, table)
    return model.values("rows", *closing.split(values))[1]


def lever(mechanism: Mechanism) -> float:
    """Return the length by which angles are compared with positions: root mean square distance of
    the platform's joint points from their middle; where they coincide, a quarter of the size.
    """
    points = platform_points(mechanism)
    spread = float(np.sqrt(np.sum(points.var(axis=0))))
    size = mechanism.characteristic_length
    return spread if spread > 1e-9 * size else 0.25 * size
