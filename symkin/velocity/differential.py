"""Differentiate the closure's rows by twist and joint rates, in the form in which one writes them
by hand.

A platform direction s = R v turns with the platform, s' = w x s, so that a row F(s) has the moment
s x dF/ds; the distance d = |t + s - b| gives (u; s x u), u = (t + s - b) / d. Automatic
differentiation by the quaternion would give the same numbers in many more terms.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symkin.closure.chain import Chain, Turn
from symkin.closure.closure import Closure, nonzero_rows
from symkin.closure.link_poses import cut_expressions
from symkin.closure.pose_forms import PlatformPose, UnitPose
from symkin.closure.rows import RowBuilder
from symkin.model.joint import Coordinate
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import matrix_from_quaternion, multiply

TWIST_COLUMNS = {
    "pose.x": (0,),
    "pose.y": (1,),
    "pose.z": (2,),
    "pose.gamma": (5,),
    "pose.quaternion": (3, 4, 5),
}
"""Components of (velocity, angular velocity) that each pose coordinate moves."""


@dataclass(frozen=True, eq=False)
class Differential:
    """A t + P x' + B q' = 0 over a closure's `variables` and `parameters`; t = (velocity of the
    platform's or tool's origin; angular velocity), base frame, all six columns.

    `twist` (m, 6), `passive` (m, p), `actuated` (m, n); a passive unit quaternion has three
    columns, its angular velocity in the frame before the joint. `weights` (m) makes lengths of the
    rows, which are (d.d - l^2) / 2 for distances. `pose` is the platform's or tool's pose. With
    `explicit`, the rows are those of a serial arm, t = J(q) q', and neither they nor the pose
    contain pose coordinates.
    """

    twist: ca.SX
    passive: ca.SX
    actuated: ca.SX
    weights: np.ndarray
    pose: Pose
    explicit: bool


def differentiate(closure: Closure, *, bound: bool = False) -> Differential:
    """The differential of a mechanism's closure; geometry symbolic, or numbers free of rounding
    noise with `bound`.
    """
    builder = _Builder(closure.mechanism, bound=bound)
    builder.build_rows()
    ours = [symbol for _, symbol in builder.coordinates.values()]
    theirs = [closure.variables[closure.slices[name]] for name in builder.coordinates]
    if not bound:
        numbers = dict(zip(closure.parameter_names, ca.vertsplit(closure.parameters), strict=True))
        ours += builder.table.symbols
        theirs += [
            numbers.get(name, ca.SX(value))
            for name, value in zip(builder.table.names, builder.table.values, strict=True)
        ]
    if _is_explicit(closure):
        twist, actuated, pose = _of_arm(builder)
        twist, actuated, position, quaternion = ca.substitute(
            [twist, actuated, pose.position, pose.quaternion], ours, theirs
        )
        return Differential(
            twist=twist,
            passive=ca.SX(6, 0),
            actuated=actuated,
            weights=np.repeat([1.0, closure.characteristic_length], 3),
            pose=Pose(position, quaternion),
            explicit=True,
        )
    rows, twist = builder.pose.settled([ca.vertcat(*builder.rows), builder.twist_columns()])
    rows, twist = ca.substitute([rows, twist], ours, theirs)
    kept = _kept_rows(closure, rows)
    joints = (
        tangent_jacobian(rows, closure, closure.role("actuated")),
        tangent_jacobian(rows, closure, closure.role("passive", "body")),
    )
    return Differential(
        twist=twist[kept, :],
        passive=joints[1][kept, :],
        actuated=joints[0][kept, :],
        weights=np.array(
            [
                1 / closure.characteristic_length
                if builder.sources[k].relation == "distance"
                else 1.0
                for k in kept
            ]
        ),
        pose=closure.pose,
        explicit=False,
    )


def tangent_jacobian(
    expression: ca.SX, closure: Closure, coordinates: tuple[Coordinate, ...]
) -> ca.SX:
    """Derivatives by rates: of numbers, and of unit quaternions by their angular velocity."""
    columns = [ca.SX(expression.shape[0], 0)]
    for c in coordinates:
        symbol = closure.symbols([c])
        jacobian = ca.jacobian(expression, symbol)
        columns.append(ca.mtimes(jacobian, quaternion_rates(symbol)) if c.is_rotation else jacobian)
    return ca.horzcat(*columns)


def quaternion_rates(q: ca.SX) -> ca.SX:
    """(4, 3): q' = (0, w) q / 2 as a matrix times w."""
    half = [[0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0], [0.0, 0.0, 0.0, 0.5]]
    return ca.horzcat(*(multiply(unit, q) for unit in half))


def variable_rates(closure: Closure, rates: Mapping[str, ca.SX]) -> ca.SX:
    """Rates of a closure's variables by those of its coordinates, told by name (freedom, k); of
    unit quaternions the derivatives.
    """
    parts = [
        ca.mtimes(quaternion_rates(closure.symbols([c])), rates[c.name])
        if c.is_rotation
        else rates[c.name]
        for c in closure.coordinates
    ]
    return ca.vertcat(*parts)


def passive_rates(
    closure: Closure, rates: Mapping[str, ca.SX], free: Collection[str] = ()
) -> dict[str, ca.SX]:
    """Rates of the passive joints by those of a closure's coordinates, in the order of the file.
    Those of joints at which loops are cut are derivatives of what these read; of the geometry
    numbers that are `free` stay symbols.
    """
    read, moving = cut_expressions(closure, free), variable_rates(closure, rates)
    found = {}
    for c in closure.mechanism.coordinates:
        if c.role == "actuated":
            continue
        if c.name in read:
            rate = ca.mtimes(ca.jacobian(read[c.name], closure.variables), moving)
            # of a quaternion q' = (0, w) q / 2
            found[c.name] = (
                4 * ca.mtimes(quaternion_rates(read[c.name]).T, rate) if c.is_rotation else rate
            )
        elif c.name in rates:
            found[c.name] = rates[c.name]
    return found


def by_name(coordinates: Sequence[Coordinate], rates: ca.SX) -> dict[str, ca.SX]:
    """The rates of each coordinate, of all of them one below the other."""
    found, place = dict[str, ca.SX](), 0
    for c in coordinates:
        found[c.name] = rates[place : place + c.freedom, :]
        place += c.freedom
    return found


def pose_rates(coordinate: Coordinate, quaternion: ca.SX, twists: ca.SX) -> ca.SX:
    """Rates of one pose coordinate by twists (6, k): components of them, or (0, w) q / 2."""
    if coordinate.is_rotation:
        return ca.mtimes(quaternion_rates(quaternion), twists[3:, :])
    return twists[TWIST_COLUMNS[coordinate.name][0], :]


@dataclass(frozen=True)
class _TurningPose(UnitPose):
    """A platform pose whose position, quaternion and turned directions are symbols in place of the
    `true` ones.
    """

    true: Pose
    turned: list[tuple[ca.SX, ca.SX]] = field(default_factory=list)

    def direction(self, v: ca.SX) -> ca.SX:
        symbol = ca.SX.sym("s", 3)
        self.turned.append((symbol, v))
        return symbol

    def settled(self, expressions: list[ca.SX]) -> list[ca.SX]:
        """The expressions with the pose in place of the symbols."""
        rotation = matrix_from_quaternion(self.true.quaternion)
        symbols = [self.position, self.quaternion, *(s for s, _ in self.turned)]
        values = [
            self.true.position,
            self.true.quaternion,
            *(ca.mtimes(rotation, v) for _, v in self.turned),
        ]
        return list(ca.substitute(expressions, symbols, values))


class _Builder(RowBuilder):
    """The closure's rows over a turning pose; distance rows without the size."""

    pose: _TurningPose  # type: ignore[assignment]

    def _declare_pose(self, reference: Pose) -> None:
        super()._declare_pose(reference)
        self.pose = _TurningPose(ca.SX.sym("p", 3), ca.SX.sym("e", 4), self.pose)  # type: ignore[arg-type]
        self.platform_pose = self.pose

    def _distance(
        self,
        name: str,
        pose: PlatformPose,
        ends: tuple[ca.SX, ca.SX],
        length: ca.SX,
        length_squared: ca.SX | None = None,
    ) -> None:
        target = length * length if length_squared is None else length_squared
        self._add(name, "distance", [(pose.squared_distance(*ends) - target) / 2], [])

    def twist_columns(self) -> ca.SX:
        """(m, 6): dF/dp, and the moments s x dF/ds with dF/de of the quaternion itself."""
        rows = ca.vertcat(*self.rows)
        angular = ca.mtimes(
            ca.jacobian(rows, self.pose.quaternion), quaternion_rates(self.pose.quaternion)
        )
        for symbol, _ in self.pose.turned:
            gradient = ca.jacobian(rows, symbol)
            angular += ca.horzcat(*(_column(symbol, gradient, k) for k in range(3)))
        return ca.horzcat(ca.jacobian(rows, self.pose.position), angular)


def _column(s: ca.SX, gradient: ca.SX, k: int) -> ca.SX:
    """Component k of s x gradient, for each row of the gradient (m, 3)."""
    i, j = (k + 1) % 3, (k + 2) % 3
    return s[i] * gradient[:, j] - s[j] * gradient[:, i]


def _is_explicit(closure: Closure) -> bool:
    alone = len(closure.mechanism.limbs) == 1 and closure.mechanism.motion == "spatial"
    return alone and closure.forward is not None and not closure.role("passive")


def _of_arm(builder: _Builder) -> tuple[ca.SX, ca.SX, Pose]:
    """1 t - J q' = 0: each joint's axis a, moved by the joints before it, turns the tool by a and
    slides it.
    """
    forward = builder.forward
    assert forward is not None  # noqa: S101 - _is_explicit has asked
    symbols = [symbol for c, symbol in builder.coordinates.values() if c.role == "actuated"]
    position = ca.jacobian(forward.position, ca.vertcat(*symbols))
    columns = []
    for k, step in enumerate(builder.arm.steps):
        assert isinstance(step, Turn)  # noqa: S101 - actuated joints are R, P and H
        spin = (
            ca.SX(3, 1) if step.angle is None else Chain(builder.arm.steps[:k]).direction(step.axis)
        )
        columns.append(ca.vertcat(position[:, k], spin))
    return ca.SX.eye(6), -ca.horzcat(*columns), forward


def _kept_rows(closure: Closure, rows: ca.SX) -> list[int]:
    """Numbers of the rows that do not vanish for every configuration of the restricted motion."""
    if closure.mechanism.motion == "spatial":
        return list(range(rows.shape[0]))
    evaluate = ca.Function("rows", [closure.variables], [closure.bound(rows)])
    return list(nonzero_rows(evaluate, closure.coordinates, closure.characteristic_length))


def rate_names(coordinates: Sequence[Coordinate]) -> tuple[str, ...]:
    """One name a rate: that of the coordinate, or `name.x`, `name.y`, `name.z` of a rotation."""
    return tuple(
        f"{c.name}.{letter}" if c.is_rotation else c.name
        for c in coordinates
        for letter in "xyz"[: c.freedom]
    )


def motion_columns(closure: Closure) -> list[int]:
    """The twist's components that the platform's motion has, in the order of its pose
    coordinates.
    """
    return [k for c in closure.role("pose") for k in TWIST_COLUMNS[c.name]]
