"""State the Newton iteration of a platform over its pose alone: points on spheres and in planes,
which the actuated joints move.

A platform point B = p + R a is tied to a centre or plane through A, d = B - A, by level - d . d = 0
or by n . d = level. With v0 the velocity of the platform at the base's origin and w its angular
velocity B moves by v0 + w x B, and because A x d = A x B

    d (d . d) / 2 = d . v0 + (A x B) . w,        d (n . B) = n . v0 + (B x n) . w,

so that the matrix by (2 v0, 2 w) has the rows [B - A, A x B] and [n, B x n]. A, level and sines of
joints are known values: they are made once for each point of the line that is aimed at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.snapping import snap
from symkin.codegen.steps.newton_kernel import Kernel, Meaning, listed
from symkin.codegen.steps.pose_coordinates import COLUMNS
from symkin.elimination.implied_rows import PointRow, plain
from symkin.model.joint import Coordinate
from symkin.spatial.backend import cross, dot, stacked
from symkin.spatial.rotation import multiply, rotate

_SAME = 1e-10
"""Share of the size within which points are the same."""
_SAMPLES = 5
"""Random values at which expressions are compared."""
_HALF_TURNS = (
    (1.0, 0.0, 0.0, 0.0),
    (0.0, 1.0, 0.0, 0.0),
    (0.0, 0.0, 1.0, 0.0),
    (0.0, 0.0, 0.0, 1.0),
)
"""Quaternions of which each vector's turned ones add to nothing."""


@dataclass(frozen=True, eq=False)
class TiedPoint:
    """The point p + R arm on a sphere, or in a plane, of the actuated joints; arms are those of the
    motion's turns.
    """

    arm: tuple[float, ...]
    of: ca.SX
    level: ca.SX
    is_sphere: bool


@dataclass(frozen=True, eq=False)
class PlatformPose:
    """How a platform moves: coordinates of its pose, and what turns its points."""

    closure: Closure

    @property
    def motion(self) -> str:
        return self.closure.mechanism.motion

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        return self.closure.role("pose")

    @property
    def symbols(self) -> ca.SX:
        return self.closure.symbols(self.coordinates)

    @property
    def lengths(self) -> int:
        """Count of coordinates of the position."""
        return 2 if self.motion == "planar" else 3

    @property
    def is_supported(self) -> bool:
        return self.motion in ("spatial", "schoenflies", "planar", "translation")

    @property
    def _turns(self) -> list[tuple[float, ...]]:
        """Turns, the first one none, of which each arm's turned ones add to nothing."""
        if self.motion == "translation":
            return [()]
        return list(_HALF_TURNS) if self.motion == "spatial" else [(0.0,), (np.pi,)]

    def turned(self, turn: ca.SX, arm: Sequence[float] | ca.SX) -> ca.SX:
        """R arm."""
        vector = arm if isinstance(arm, ca.SX) else numbers_of(arm)
        if self.motion == "translation":
            return vector
        if self.motion == "spatial":
            return rotate(turn, vector)
        c, s = ca.cos(turn[0]), ca.sin(turn[0])
        x, y, *z = (vector[i] for i in range(self.lengths))
        return ca.vertcat(c * x - s * y, s * x + c * y, *z)

    def plane(self, row: PointRow) -> TiedPoint | None:
        """A plane in which a point of the platform lies; None where the row's point is not one."""
        found = self._attached(row.point)
        if found is None:
            return None
        axes, arm, fixed = found
        normal = ca.mtimes(numbers_of(axes.T), row.of)
        level = row.level - dot(row.of, numbers_of(fixed))
        if level.is_constant():
            level = ca.SX(snap(float(level), self.closure.characteristic_length))
        return TiedPoint(arm, normal, level, is_sphere=False)

    def sphere(self, row: PointRow, planes: Sequence[TiedPoint]) -> TiedPoint | None:
        """A sphere on which a point of the platform lies. A component that is not in the row is
        that of one of the `planes`.
        """
        found = self._attached(row.point)
        if found is None:
            return None
        axes, arm, fixed = found
        center = [ca.SX(0)] * self.lengths
        unit, given = np.eye(self.lengths), list(axes)
        for j, axis in enumerate(unit):
            rows = [i for i, other in enumerate(given) if np.array_equal(other, axis)]
            if rows:
                center[j] = row.of[rows[0]] - float(fixed[rows[0]])
                continue
            plane = next(
                (
                    p
                    for p in planes
                    if p.arm == arm and p.of.is_constant() and np.array_equal(_values(p.of), axis)
                ),
                None,
            )
            if plane is None:
                return None
            center[j] = plane.level
        return TiedPoint(arm, ca.vertcat(*center), row.level, is_sphere=True)

    def _attached(self, point: ca.SX) -> tuple[np.ndarray, tuple[float, ...], np.ndarray] | None:
        """Axes N, arm a and what does not turn b of expressions N (p + R a) + b; None where they
        are others.
        """
        n, size = self.lengths, self.closure.characteristic_length
        position, turn = self.symbols[:n], self.symbols[n:]
        axes = self._sampled([ca.jacobian(point, position)], [self.symbols])
        if any(np.max(np.abs(other - axes[0])) > _SAME for other in axes):
            return None
        rows = np.vectorize(snap)(axes[0])
        arms, none = ca.SX.sym("a", n), ca.SX(0, 1)
        arm_part = (
            ca.jacobian(ca.mtimes(numbers_of(rows), self.turned(turn, arms)), arms)
            if self.motion != "translation"
            else ca.SX(len(rows), n)
        )
        values = self._sampled([arm_part], [self.symbols])
        offsets = self._sampled([point - ca.mtimes(numbers_of(rows), position)], [self.symbols])
        matrix = np.vstack([np.hstack([v, np.eye(len(rows))]) for v in values])
        solved = np.linalg.lstsq(matrix, np.vstack(offsets).ravel(), rcond=None)[0]
        arm, fixed = (
            tuple(snap(float(v), size) for v in part) for part in (solved[:n], solved[n:])
        )
        arm = tuple(0.0 if abs(v) <= _SAME * size else v for v in arm)
        expected = ca.mtimes(numbers_of(rows), position + self.turned(turn, arm)) + numbers_of(
            fixed
        )
        if not self._vanishes(ca.vertcat(none, point - expected) / size, [self.symbols]):
            return None
        return rows, arm, np.array(fixed)

    def rod(self, row: ca.SX, joints: ca.SX, actuated: Sequence[Coordinate]) -> TiedPoint | None:
        """A row without passive joints that is a distance: its second derivative by the position is
        a number times one.
        """
        p, turn = self.symbols[: self.lengths], self.symbols[self.lengths :]
        slope = ca.jacobian(row, p).T
        bend = ca.simplify(ca.jacobian(slope, p))
        values = self._sampled([bend], [self.symbols, joints], actuated)
        half = 0.5 * float(values[0][0, 0])
        if half == 0.0 or any(
            np.max(np.abs(v - 2 * half * np.eye(self.lengths))) > _SAME * abs(half) for v in values
        ):
            return None
        zero = ca.SX(ca.DM([0.0] * self.lengths))

        def at(expression: ca.SX, place: tuple[float, ...]) -> ca.SX:
            put_in = ca.substitute(expression, p, zero)
            return ca.substitute(put_in, turn, ca.SX(ca.DM(list(place)))) if place else put_in

        vectors = [at(slope, place) / (2 * half) for place in self._turns]
        of = -sum(vectors[1:], vectors[0]) / len(vectors)
        arm = vectors[0] + of
        size = self.closure.characteristic_length
        numbers = tuple(
            snap(float(v), size)
            for v in self._sampled([arm], [self.symbols, joints], actuated)[0].ravel()
        )
        level = (
            dot(numbers_of(numbers) - of, numbers_of(numbers) - of) - at(row, self._turns[0]) / half
        )
        d = p + self.turned(turn, numbers) - of
        if not self._vanishes(
            (row / half - (dot(d, d) - level)) / size**2, [self.symbols, joints], actuated
        ):
            return None
        found = plain(ca.vertcat(of, level), joints, actuated, size)
        return TiedPoint(numbers, found[:-1], found[-1], is_sphere=True)

    def _sampled(
        self,
        expressions: Sequence[ca.SX],
        inputs: Sequence[ca.SX],
        joints: Sequence[Coordinate] = (),
    ) -> list[np.ndarray]:
        """An expression at some random values of the pose, and of `joints`: lengths about the size,
        angles about 1, quaternions of unit length.
        """
        kinds = [c.is_angular for c in joints]
        units = [
            np.where(
                [k >= self.lengths for k in range(inputs[0].numel())],
                1.0,
                self.closure.characteristic_length,
            )
        ]
        units += [np.where(kinds, 1.0, self.closure.characteristic_length)] if kinds else []
        rng, function = (
            np.random.default_rng(4),
            ca.Function("sampled", list(inputs), list(expressions)),
        )
        found = []
        for _ in range(_SAMPLES):
            values = [unit * rng.uniform(-1.0, 1.0, len(unit)) for unit in units]
            if self.motion == "spatial":
                values[0][3:] /= np.linalg.norm(values[0][3:])
            found.append(ca.DM(function(*values)).full())
        return found

    def _vanishes(
        self, expression: ca.SX, inputs: Sequence[ca.SX], joints: Sequence[Coordinate] = ()
    ) -> bool:
        return all(np.max(np.abs(v)) <= _SAME for v in self._sampled([expression], inputs, joints))

    def row(self, point: TiedPoint) -> ca.SX:
        """The row of a tied point over pose and joints, as a length."""
        n = self.lengths
        b = self.symbols[:n] + self.turned(self.symbols[n:], point.arm)
        if not point.is_sphere:
            return dot(point.of, b) - point.level
        d = b - point.of
        return (dot(d, d) - point.level) / (2 * self.closure.characteristic_length)

    # --- steps ------------------------------------------------------------------------------------

    def columns(self, force: ca.SX, at: ca.SX, other: ca.SX, turning: ca.SX | None = None) -> ca.SX:
        """A row of the matrix by a force and the moment at x other, and more `turning` beside it:
        as many columns as the motion has.
        """
        moment = cross(_whole(at), _whole(other))
        both = ca.vertcat(_whole(force), moment if turning is None else moment + turning)
        return both[list(COLUMNS[self.motion])].T

    def twist(self, state: ca.SX, step: ca.SX) -> ca.SX:
        """Velocity of the platform's origin and angular velocity by a step (2 v0, 2 w)."""
        whole = ca.SX.zeros(6)
        whole[list(COLUMNS[self.motion])] = 0.5 * step
        velocity = whole[:3] + cross(whole[3:], _whole(state[: self.lengths]))
        return ca.vertcat(velocity, whole[3:])

    def moved(self, state: ca.SX, step: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The state after a step, and the step's squared length, turns by the size, velocities at
        the platform's origin.
        """
        n, size, twist = self.lengths, self.closure.characteristic_length, self.twist(state, step)
        velocity, w = twist[:n], twist[3:]
        new = state[n:]
        if self.motion == "spatial":
            half = 0.5 * w
            turned = multiply(ca.vertcat(1, half), state[n:])
            # |(1, h) q| = sqrt(1 + h.h) for a unit quaternion q
            inverse = 1 / ca.sqrt(1 + dot(half, half))
            new = ca.vertcat(*(turned[k] * inverse for k in range(4)))
        elif self.motion != "translation":
            new = state[n:] + w[2]
        return ca.vertcat(state[:n] + velocity, new), dot(velocity, velocity) + size**2 * dot(w, w)

    def slope(self, row: ca.SX) -> ca.SX:
        """Derivatives of an expression of the pose by (v0, w)."""
        n, turning = self.lengths, None
        position, turn = self.symbols[:n], self.symbols[n:]
        force = ca.jacobian(row, position).T
        if self.motion == "spatial":
            basis = ca.horzcat(
                *(
                    0.5 * multiply(ca.SX([0.0, *(float(k == j) for j in range(3))]), turn)
                    for k in range(3)
                )
            )
            turning = ca.mtimes(ca.jacobian(row, turn), basis).T
        elif self.motion != "translation":
            turning = ca.vertcat(0, 0, ca.jacobian(row, turn))
        return self.columns(force, position, force, turning)


def _whole(vector: ca.SX) -> ca.SX:
    """A vector of two entries or three as one of space."""
    return ca.vertcat(vector, *[0.0] * (3 - vector.numel()))


def numbers_of(values: Sequence[float] | np.ndarray) -> ca.SX:
    """Constants."""
    return ca.SX(ca.sparsify(ca.DM(np.asarray(values))))


def _values(constants: ca.SX) -> np.ndarray:
    return ca.DM(constants).full().ravel()


@dataclass
class _Known:
    """Numbers that rows read of the actuated joints: each is one known value, constants stay
    numbers.
    """

    joints: ca.SX
    symbols: list[ca.SX] = field(default_factory=list)
    values: list[ca.SX] = field(default_factory=list)

    def of(self, expression: ca.SX) -> ca.SX:
        """Entries of an expression as numbers or symbols of known values."""
        return ca.vertcat(*(self._entry(expression[i]) for i in range(expression.numel())))

    def _entry(self, value: ca.SX) -> ca.SX:
        if not any(ca.which_depends(value, self.joints, 1, False)):
            return value
        for symbol, other in zip(self.symbols, self.values, strict=True):
            if ca.is_equal(value, other, 20):
                return symbol
        symbol = ca.SX.sym(f"k{len(self.symbols)}")
        self.symbols.append(symbol)
        self.values.append(value)
        return symbol


@dataclass(frozen=True, eq=False)
class PoseKernel:
    """The kernel, its known values by the actuated joints, and the platform's twist by state and
    step.
    """

    kernel: Kernel
    joints: ca.SX
    target: ca.SX
    twist: ca.SX

    def known(self, joints: np.ndarray) -> np.ndarray:
        """Known values of joint values."""
        return np.asarray(ca.Function("known", [self.joints], [self.target])(joints)).ravel()


@dataclass
class _Points:
    """Points B = p + R arm, each made once: rows and matrix share them."""

    pose: PlatformPose
    arms: list[tuple[float, ...]] = field(default_factory=list)
    symbols: list[ca.SX] = field(default_factory=list)
    values: list[ca.SX] = field(default_factory=list)

    def of(self, arm: tuple[float, ...]) -> tuple[ca.SX, ca.SX]:
        """Symbol and expression of a point."""
        if arm not in self.arms:
            n, state = self.pose.lengths, self.pose.symbols
            self.arms.append(arm)
            self.symbols.append(ca.SX.sym(f"b{len(self.symbols)}", n))
            self.values.append(state[:n] + self.pose.turned(state[n:], arm))
        k = self.arms.index(arm)
        return self.symbols[k], self.values[k]


def pose_kernel(
    pose: PlatformPose,
    points: Sequence[TiedPoint],
    others: Sequence[ca.SX],
    actuated: Sequence[Coordinate],
    reference: np.ndarray,
) -> PoseKernel:
    """Rows over the pose: those of points, then others, which vanish. `reference` are the actuated
    joints' values there.
    """
    closure, state = pose.closure, pose.symbols
    size, joints = (
        closure.characteristic_length,
        closure.symbols(actuated),
    )
    known, shared, none = _Known(joints), _Points(pose), ca.SX(0, 1)
    step = ca.SX.sym("s", sum(c.freedom for c in pose.coordinates))
    length = _usual_length(
        [point.level for point in points if point.is_sphere], joints, reference, size
    )
    rows, matrix = [], []
    for point in points:
        symbol, b = shared.of(point.arm)
        of, level = known.of(point.of), known.of(point.level)
        if point.is_sphere:
            rows.append(level - dot(b - of, b - of))
            matrix.append(pose.columns(symbol - of, of, symbol))
        else:
            rows.append(2 * length * (level - dot(of, b)))
            matrix.append(length * pose.columns(of, symbol, of))
    for other in others:
        rows.append(-2 * length * other)
        matrix.append(length * pose.slope(other))
    moved, norm = pose.moved(state, step)
    kernel = Kernel(
        name="direct",
        state=state,
        known=stacked(known.symbols),
        geometry=none,
        step=step,
        shared_symbols=stacked(shared.symbols),
        rows=ca.vertcat(*rows),
        shared=stacked(shared.values),
        jacobian=ca.vertcat(*matrix),
        moved=moved,
        norm=norm,
        row_length=0.5 / length,
        characteristic_length=size,
        meaning=_meaning(pose),
        is_pose=pose.motion == "spatial",
        turns=tuple((i, 1.0 if c.is_angular else 1.0 / size) for i, c in enumerate(actuated)),
    )
    return PoseKernel(kernel, joints, stacked(known.values), pose.twist(state, step))


def _usual_length(
    levels: Sequence[ca.SX], joints: ca.SX, reference: np.ndarray, size: float
) -> float:
    """The mean distance of spheres: half of what makes lengths of their rows."""
    if not levels:
        return size
    found = ca.Function("levels", [joints], [ca.vertcat(*levels)])(reference)
    return float(f"{np.mean(np.sqrt(np.abs(np.asarray(found)))):.3g}")


def _meaning(pose: PlatformPose) -> Meaning:
    turning = {"translation": "2 v0", "spatial": "(2 v0, 2 w)"}.get(
        pose.motion, "(2 v0, 2 w), w about z"
    )
    return Meaning(
        state=listed(pose.coordinates),
        known=(
            "centers and squared radii of spheres, normals and levels of planes, as far as "
            "actuated joints move them"
        ),
        rows=(
            "squared radius - d . d of spheres, level - n . d of planes (times twice the mean "
            "radius)"
        ),
        step=f"{turning}: velocity v0 of the platform where the base's origin is, and its turn w",
        shared="points B of the platform",
    )
