"""Evaluate the closure and the readings with their derivatives, for all configurations at once.

F(z; q, p) = 0 in the unknown coordinates z (passive joints and pose) given joint readings q and
parameters p; readings h(z, p). Derivatives are taken in the tangent space of z (see
`numeric.system`) and along scaled parameters: one unit of a scaled parameter is one length unit,
for angles and directions 1/size.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.observables import (
    Observable,
    Observed,
    is_angular,
    observables_named,
    observed,
)
from symkin.calibration.data.parameters import (
    MEASURING_FRAMES,
    ParameterKind,
    described_parameters,
    nominal_parameters,
)
from symkin.calibration.estimate.mapped_functions import MappedFunction, map_functions
from symkin.closure.closure import Closure
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.numeric.system import System
from symkin.spatial.backend import dot
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, quaternion_from_rotation_vector
from symkin.text import meant, shown

READING_KINDS = ("group", "inclination", "position", "orientation")
"""Kinds of readings of the platform in the order of their columns; distances follow, then the
observables that are read.
"""
COMPONENTS = {
    "group": ("alpha", "beta"),
    "inclination": ("alpha", "beta"),
    "position": ("x", "y", "z"),
    "orientation": ("x", "y", "z"),
}


_VECTOR_OUTPUTS = {"whole": (0, 3), "rows": (0,), "joints": (), "tangent": (0, 3), "pose": (0,)}
"""Outputs that are columns, for each function of a configuration."""


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Values at n configurations: rows F (n, m), F_z (n, m, f), F_p (n, m, P); readings h (n, K),
    h_z (n, K, f), h_p (n, K, P).
    """

    rows: np.ndarray
    rows_z: np.ndarray
    rows_p: np.ndarray
    readings: np.ndarray
    readings_z: np.ndarray
    readings_p: np.ndarray

    def condensed(
        self, pending: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray] | None]:
        """Eliminate the unknown coordinates: readings corrected for closures that are off by
        `pending` steps (n, f), their derivative dh/dp (n, K, P) with the configurations following,
        and what an overconstrained closure leaves of F and dF/dp.
        """
        if self.rows_z.shape[1] == self.rows_z.shape[2]:
            # A = h_z F_z^-1 from the transposed system: K right sides in place of P
            weights = solve_systems(
                self.rows_z.transpose(0, 2, 1), self.readings_z.transpose(0, 2, 1)
            ).transpose(0, 2, 1)
            return (
                self.readings - (weights @ self.rows[:, :, None])[:, :, 0],
                self.readings_p - weights @ self.rows_p,
                None,
            )
        follow = self.following
        left = (
            self.rows - (self.rows_z @ pending[:, :, None])[:, :, 0],
            self.rows_p + self.rows_z @ follow,
        )
        return (
            self.readings - (self.readings_z @ pending[:, :, None])[:, :, 0],
            self.readings_p + self.readings_z @ follow,
            left,
        )

    @property
    def following(self) -> np.ndarray:
        """dz/dp (n, f, P), by which the unknown coordinates follow the parameters: -F_z^+ F_p."""
        return -solve_systems(self.rows_z, self.rows_p)

    @property
    def left_over(self) -> np.ndarray:
        """What an overconstrained closure leaves of dF/dp (n, m, P); no rows where none is left."""
        left = self.condensed(np.zeros((len(self.rows), self.rows_z.shape[2])))[2]
        return self.rows_p[:, :0] if left is None else left[1]

    @property
    def slopes(self) -> np.ndarray:
        """dh/dp (n, K, P) with the configurations following: h_p - h_z F_z^+ F_p."""
        return self.condensed(np.zeros((len(self.rows), self.rows_z.shape[2])))[1]


def solve_systems(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve n systems by least squares, matrix (n, m, f), right (n, m, k); not finite where a
    system is singular.
    """
    if matrix.shape[1] == matrix.shape[2]:
        try:
            return np.asarray(np.linalg.solve(matrix, right))
        except np.linalg.LinAlgError:
            pass
    if not np.all(np.isfinite(matrix)):
        matrix = np.nan_to_num(matrix)
    return np.asarray(np.linalg.pinv(matrix, rcond=1e-12) @ right)


@dataclass(frozen=True, eq=False)
class ConfigurationModel:
    """One configuration as expressions: `system` holds closure and tangent space, `joints`,
    `parameters` and `quaternion` (measured ones, of the platform and of other links) are what is
    known; `columns` names each reading (kind, component), `read` what is read beside the platform;
    `pose` is that of the link by which geometry is judged, as it is observed.
    """

    mechanism: Mechanism
    closure: Closure
    system: System
    names: tuple[str, ...]
    kinds: tuple[ParameterKind, ...]
    nominal: np.ndarray
    scales: np.ndarray
    joints: ca.SX
    parameters: ca.SX
    quaternion: ca.SX
    readings: ca.SX
    columns: tuple[tuple[str, str], ...]
    pose: Pose
    read: tuple[Observable, ...] = ()

    def evaluate(
        self, z: np.ndarray, joints: np.ndarray, p: np.ndarray, quaternions: np.ndarray
    ) -> Evaluation:
        """Evaluate closure and readings with derivatives; z (n, width), joints (n, a), p (P,),
        quaternions (n, 4).
        """
        return Evaluation(*self._call("whole", z, joints, p, quaternions))

    def rows(
        self, z: np.ndarray, joints: np.ndarray, p: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Evaluate F (n, m) and F_z (n, m, f)."""
        rows, rows_z = self._call("rows", z, joints, p, self._no_quaternions(len(z)))
        return rows, rows_z

    def joint_slopes(
        self,
        e: Evaluation,
        z: np.ndarray,
        joints: np.ndarray,
        p: np.ndarray,
        quaternions: np.ndarray,
    ) -> np.ndarray:
        """Minus dh/dq (n, K, a) with the configurations following, h_z F_z^+ F_q - h_q, at an
        evaluation e: the pose of a link that open chains carry is a function of the joints, without
        unknowns.
        """
        rows_q, readings_q = self._call("joints", z, joints, p, quaternions)
        return np.asarray(e.readings_z @ solve_systems(e.rows_z, rows_q) - readings_q)

    def tangent(self, z: np.ndarray, joints: np.ndarray, p: np.ndarray) -> list[np.ndarray]:
        """Evaluate F, F_z, F_q, h, h_z; orientations are measured against none."""
        return self._call("tangent", z, joints, p, self._no_quaternions(len(z)))

    def poses(self, z: np.ndarray, joints: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Evaluate the observed poses (n, 7), quaternions with w >= 0."""
        packed = self._call("pose", z, joints, p, self._no_quaternions(len(z)))[0]
        return np.asarray(
            np.where(packed[:, 3:4] < 0, np.hstack([packed[:, :3], -packed[:, 3:]]), packed)
        )

    def _no_quaternions(self, count: int) -> np.ndarray:
        return np.zeros((count, int(self.quaternion.shape[0])))

    @cached_property
    def angular(self) -> np.ndarray:
        """Which readings (K,) are angles."""
        return np.array([is_angular(self.mechanism, kind) for kind, _ in self.columns], dtype=bool)

    @cached_property
    def turning(self) -> np.ndarray:
        """Which readings (K,) are angles modulo a turn."""
        whole = {"group", "inclination", *(o.name for o in self.read if o.turning)}
        return np.array([kind in whole for kind, _ in self.columns], dtype=bool)

    @property
    def lengths(self) -> np.ndarray:
        """Lengths (K,) by which readings are multiplied to be lengths: the size for angles, 1 for
        lengths.
        """
        return np.where(self.angular, self.closure.characteristic_length, 1.0)

    @property
    def observes_through_frames(self) -> bool:
        """Whether frames between the mechanism and what is measured are unknown."""
        return any(n in MEASURING_FRAMES for n in self.names)

    def compile(self) -> None:
        """Compile the functions now, where there is a compiler; else they are compiled when that
        pays.
        """
        self._mapped["whole"].engine.compile()

    @cached_property
    def _outputs(self) -> dict[str, list[ca.SX]]:
        system, scales = self.system, ca.diag(ca.DM(self.scales))
        rows_z = system.jacobian
        readings_z = ca.mtimes(ca.jacobian(self.readings, system.unknown), system.tangent)
        by_p = [
            ca.mtimes(ca.jacobian(f, self.parameters), scales) for f in (system.rows, self.readings)
        ]
        return {
            "whole": [system.rows, rows_z, by_p[0], self.readings, readings_z, by_p[1]],
            "rows": [system.rows, rows_z],
            "joints": [ca.jacobian(f, self.joints) for f in (system.rows, self.readings)],
            "tangent": [
                system.rows,
                rows_z,
                ca.jacobian(system.rows, self.joints),
                self.readings,
                readings_z,
            ],
            "pose": [ca.vertcat(self.pose.position, self.pose.quaternion)],
        }

    @cached_property
    def _mapped(self) -> dict[str, MappedFunction]:
        inputs = [self.system.unknown, self.joints, self.parameters, self.quaternion]
        made = [
            ca.Function(f"symkin_{what}", inputs, [ca.densify(f) for f in outputs], {"cse": True})
            for what, outputs in self._outputs.items()
        ]
        return dict(zip(self._outputs, map_functions(made), strict=True))

    def _call(
        self, what: str, z: np.ndarray, joints: np.ndarray, p: np.ndarray, quaternions: np.ndarray
    ) -> list[np.ndarray]:
        results = self._mapped[what](len(z), (z, joints, p, quaternions))
        vectors = _VECTOR_OUTPUTS[what]
        return [a[:, 0, :] if k in vectors else a.transpose(0, 2, 1) for k, a in enumerate(results)]


# --- building -------------------------------------------------------------------------------------


def build_model(
    mechanism: Mechanism, measurements: Measurements, names: Sequence[str]
) -> ConfigurationModel:
    """Build the model of a configuration with the readings that `measurements` has, over the named
    parameters; all others keep their nominal values.
    """
    kinds = tuple(k for k in READING_KINDS if _is_taken(measurements, k))
    distances = tuple((d.name, tuple(d.platform), tuple(d.base)) for d in measurements.distances)
    return _build_model(mechanism, kinds, distances, measurements.observed, tuple(names))


def _is_taken(measurements: Measurements, kind: str) -> bool:
    if kind == "group":
        return measurements.groups is not None
    return getattr(measurements, kind) is not None


@lru_cache(maxsize=64)
def _build_model(
    mechanism: Mechanism,
    kinds: tuple[str, ...],
    distances: tuple[tuple[str, tuple[float, ...], tuple[float, ...]], ...],
    read: tuple[str, ...],
    names: tuple[str, ...],
) -> ConfigurationModel:
    seen = observed(mechanism, read)
    closure = seen.closure  # another one, of equal rows, would have other symbols
    table = _values_of(mechanism, read, names)
    symbols = {
        name: ca.SX.sym(name) if name in names else ca.SX(value)
        for name, (value, _) in table.items()
    }
    parameters = ca.vertcat(*(symbols[n] for n in names)) if names else ca.SX(0, 1)
    known = _Known(symbols, seen)
    system = known.system(parameters)
    world, target = (_frame(symbols, name) for name in ("world", "target"))
    pose = _framed(world, known.pose(seen.pose), target)
    read_of = observables_named(mechanism, read)
    quaternion = ca.SX.sym("measured", 4 + 4 * sum(o.kind == "orientation" for o in read_of))
    here = {name: ca.SX(value) for name, (value, _) in table.items()}
    upright = _framed(_frame(here, "world"), mechanism.reference_pose, _frame(here, "target"))
    readings, columns = _readings(
        pose, quaternion[:4], _level(upright.quaternion), kinds, distances
    )
    others, other_columns = _other_readings(known, read_of, world, quaternion[4:])
    types = tuple(table[n][1] for n in names)
    scales = np.array(
        [1.0 if kind == "length" else 1.0 / closure.characteristic_length for kind in types]
    )
    return ConfigurationModel(
        mechanism=mechanism,
        closure=closure,
        system=system,
        names=names,
        kinds=types,
        nominal=np.array([table[n][0] for n in names]),
        scales=scales,
        joints=known.readings,
        parameters=parameters,
        quaternion=quaternion,
        readings=ca.vertcat(readings, others),
        columns=columns + other_columns,
        pose=pose,
        read=read_of,
    )


def _values_of(
    mechanism: Mechanism, read: tuple[str, ...], names: tuple[str, ...]
) -> dict[str, tuple[float, ParameterKind]]:
    """Nominal values and kinds of all parameters; those of the names that only what is not read
    depends on are among them.
    """
    table = nominal_parameters(mechanism, read)
    missing = [name for name in names if name not in table]
    every = described_parameters(mechanism) if missing else {}
    for name in missing:
        if name not in every:
            raise InputError(
                f"parameter {shown(name)} is unknown{meant(name, table)}; {mechanism.name} has "
                f"{', '.join(table)}"
            )
    return table | {name: every[name] for name in missing}


class _Known:
    """Expressions with what is known put in: readings of actuated joints in place of their
    coordinates, the parameters' symbols or numbers in place of the closure's geometry.
    """

    def __init__(self, symbols: Mapping[str, ca.SX], seen: Observed) -> None:
        closure = seen.closure
        actuated = closure.role("actuated")
        self.closure, self.symbols, self.seen = closure, symbols, seen
        self.readings = ca.vertcat(ca.SX(0, 1), *(ca.SX.sym(f"{c.name}.reading") for c in actuated))
        pairs = [
            (
                closure.variables[closure.slices[c.name]],
                symbols[f"{c.name}.scale"] * self.readings[k],
            )
            for k, c in enumerate(actuated)
        ]
        if closure.parameter_names:
            pairs.append((closure.parameters, _parameter_values(closure, symbols)))
        own = set(closure.parameter_names)
        pairs += [
            (symbol, symbols.get(n, ca.SX(value)))
            for n, (symbol, value) in seen.geometry.items()
            if n not in own
        ]
        self._before = ca.vertcat(ca.SX(0, 1), *(before for before, _ in pairs))
        self._after = ca.vertcat(ca.SX(0, 1), *(after for _, after in pairs))

    def __call__(self, *expressions: ca.SX) -> list[ca.SX]:
        return list(ca.substitute(list(expressions), [self._before], [self._after]))

    def pose(self, pose: Pose) -> Pose:
        packed = self(ca.vertcat(pose.position, pose.quaternion))[0]
        return Pose(packed[:3], packed[3:])

    def system(self, parameters: ca.SX) -> System:
        """The closure in its unknown coordinates."""
        closure, unknowns = self.closure, self.closure.role("passive", "body", "pose")
        unknown = ca.vertcat(
            ca.SX(0, 1), *(closure.variables[closure.slices[c.name]] for c in unknowns)
        )
        rows, errors = self(closure.rows, closure.errors)
        return System(
            unknowns,
            unknown,
            ca.vertcat(self.readings, parameters),
            rows,
            errors,
            closure.characteristic_length,
        )


def _parameter_values(closure: Closure, symbols: Mapping[str, ca.SX]) -> ca.SX:
    pairs = zip(closure.parameter_names, closure.parameter_values, strict=True)
    return ca.vertcat(
        ca.SX(0, 1), *(symbols.get(name, ca.SX(float(value))) for name, value in pairs)
    )


def _frame(symbols: Mapping[str, ca.SX], name: str) -> Pose | None:
    """The world or target frame, None where it is the identity."""
    parts = [symbols[f"{name}.{what}.{k}"] for what in ("position", "rotation") for k in "xyz"]
    if all(part.is_constant() and float(part) == 0.0 for part in parts):
        return None
    return Pose(ca.vertcat(*parts[:3]), quaternion_from_rotation_vector(ca.vertcat(*parts[3:])))


def _framed(world: Pose | None, pose: Pose, target: Pose | None = None) -> Pose:
    """Compose world @ pose @ target."""
    pose = pose if world is None else world @ pose
    return pose if target is None else pose @ target


def _readings(
    pose: Pose,
    quaternion: ca.SX,
    level: ca.SX,
    kinds: Sequence[str],
    distances: Sequence[tuple[str, Sequence[float], Sequence[float]]],
) -> tuple[ca.SX, tuple[tuple[str, str], ...]]:
    made: list[ca.SX] = []
    columns: list[tuple[str, str]] = []
    for kind in kinds:
        match kind:
            case "group":
                made.extend(inclination(multiply(pose.quaternion, level)))
            case "inclination":
                made.extend(inclination(pose.quaternion))
            case "position":
                made.extend(ca.vertsplit(pose.position))
            case _:
                made.extend(_turn_from(quaternion, pose.quaternion))
        columns.extend((kind, c) for c in COMPONENTS[kind])
    for name, end, base in distances:
        gap = pose.apply(ca.SX(ca.DM(list(end)))) - ca.SX(ca.DM(list(base)))
        made.append(ca.sqrt(dot(gap, gap)))
        columns.append(("distance", name))
    return ca.vertcat(*made) if made else ca.SX(0, 1), tuple(columns)


def _other_readings(
    known: _Known, read: Sequence[Observable], world: Pose | None, quaternions: ca.SX
) -> tuple[ca.SX, tuple[tuple[str, str], ...]]:
    """The readings of passive joints, points and other links; `quaternions` are the orientations
    measured.
    """
    made: list[ca.SX] = []
    measured = ca.vertsplit(quaternions, 4) if quaternions.numel() else []
    for o in read:
        value = known.seen.values[o.name]
        if isinstance(value, Pose):
            pose = _framed(world, known.pose(value))
            if o.kind == "position":
                made.extend(ca.vertsplit(pose.position))
            elif o.kind == "inclination":
                made.extend(inclination(pose.quaternion))
            else:
                made.extend(_turn_from(measured.pop(0), pose.quaternion))
            continue
        (value,) = known(value)
        if o.kind == "joint":
            made.append(value / known.symbols[f"{o.name}.scale"])
        elif o.kind == "point":
            made.extend(ca.vertsplit(value if world is None else world.apply(value)))
        else:
            made.append(value)
    return ca.vertcat(ca.SX(0, 1), *made), tuple(
        (o.name, component) for o in read for component in o.components
    )


def _turn_from(measured: ca.SX, quaternion: ca.SX) -> list[ca.SX]:
    """Components of the turn from a measured orientation, twice the vector part of its
    quaternion.
    """
    e = multiply(conjugate(measured), quaternion)
    sign = ca.if_else(e[0] < 0, -1, 1)
    return [2 * sign * e[k] for k in (1, 2, 3)]


def inclination(q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return alpha and beta of R = Rz(gamma) Ry(beta) Rx(alpha), from the last row of R: (-sin b,
    cos b sin a, cos b cos a).
    """
    first, second, third = _upward(q)
    return ca.atan2(second, third), ca.atan2(-first, ca.sqrt(second * second + third * third))


def _upward(q: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """The last row of a rotation: the base's z axis in the turned frame."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


def _level(quaternion: ca.SX | np.ndarray) -> ca.SX:
    """The turn of the platform frame after which its z axis points up where its orientation is
    `quaternion`. Groups are compared by alpha and beta of the frame so turned: these weigh errors
    of tilt alike about every axis there, where alpha of a frame whose x axis points up is any.
    """
    up = [float(component) for component in _upward(ca.SX(quaternion))]
    turn = np.array([1.0 + up[2], -up[1], up[0], 0.0])
    if turn[0] < 1e-12:  # z points down: a half turn about x
        turn = np.array([0.0, 1.0, 0.0, 0.0])
    return ca.SX(ca.DM(turn / np.linalg.norm(turn)))
