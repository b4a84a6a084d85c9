"""Evaluate the closure and the readings with their derivatives, for all configurations at once.

F(z; q, p) = 0 in the unknown coordinates z (passive joints and pose) given joint readings q and
parameters p; readings h(z, p). Derivatives are taken in the tangent space of z (see
`numeric.system`) and along scaled parameters: one unit of a scaled parameter is one length unit,
for angles and directions 1/size.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.observables import Observable, Observed, ParameterKind, observed
from symkin.calibration.data.parameters import (
    MEASURING_FRAMES,
    described_parameters,
    nominal_parameters,
)
from symkin.closure.closure import Closure
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.numeric.mapped import Mapped
from symkin.numeric.system import NOTHING, System
from symkin.spatial.backend import dot, stacked
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, quaternion_from_rotation_vector, rotate
from symkin.text import meant, shown


class Evaluation(NamedTuple):
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
        self,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray] | None]:
        """Eliminate the unknown coordinates: the steps (n, f) by which closures are off, readings
        corrected for them, their derivative dh/dp (n, K, P) with the configurations following, and
        what an overconstrained closure leaves of F and dF/dp.
        """
        inverse = solve_systems(self.rows_z, np.eye(self.rows.shape[1]))
        weights, rows = self.readings_z @ inverse, self.rows[:, :, None]
        readings = self.readings - (weights @ rows)[:, :, 0]
        slopes, left = self.readings_p - weights @ self.rows_p, None
        if self.rows_z.shape[1] != self.rows_z.shape[2]:
            both = np.concatenate([rows, self.rows_p], axis=2)
            both = both - self.rows_z @ (inverse @ both)
            left = both[:, :, 0], both[:, :, 1:]
        return (inverse @ rows)[:, :, 0], readings, slopes, left

    @property
    def left_over(self) -> np.ndarray:
        """What an overconstrained closure leaves of dF/dp (n, m, P); no rows where none is left."""
        left = self.condensed()[3]
        return self.rows_p[:, :0] if left is None else left[1]

    @property
    def slopes(self) -> np.ndarray:
        """dh/dp (n, K, P) with the configurations following: h_p - h_z F_z^+ F_p."""
        return self.condensed()[2]


def solve_systems(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve n systems by least squares, matrix (n, m, f), right (n, m, k); not finite where a
    system is singular.
    """
    if matrix.shape[1] == matrix.shape[2]:
        try:
            return np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            pass
    if not np.isfinite(matrix).all():
        matrix = np.nan_to_num(matrix)
    return np.linalg.pinv(matrix, rcond=1e-12) @ right


@dataclass(frozen=True, eq=False)
class ConfigurationModel:
    """One configuration as expressions: `system` holds closure and tangent space, `joints`,
    `parameters` and `quaternion` (measured ones, of the platform and of other links) are what is
    known; `channels` are what is read, `exact` the numbers that stand in a file (quaternions
    whole); `pose` is that of the link by which geometry is judged, as it is observed.
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
    exact: ca.SX
    channels: tuple[Observable, ...]
    pose: Pose

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle as what it is built from: symbols and functions stay in their process."""
        return model_of, (self.mechanism, self.channels, self.names)

    def evaluate(
        self,
        z: np.ndarray,
        joints: np.ndarray,
        p: np.ndarray,
        quaternions: np.ndarray | None = None,
    ) -> Evaluation:
        """Evaluate closure and readings with derivatives; z (n, width), joints (n, a), p (P,),
        quaternions (n, 4), zero where none are measured.
        """
        return Evaluation(*self.values("whole", z, joints, p, quaternions))

    def poses(self, z: np.ndarray, joints: np.ndarray, p: np.ndarray = NOTHING) -> np.ndarray:
        """Evaluate the observed poses (n, 7), quaternions with w >= 0."""
        packed = self.values("pose", z, joints, p)[0]
        packed[:, 3:] *= np.where(packed[:, 3:4] < 0, -1.0, 1.0)
        return packed

    @cached_property
    def columns(self) -> tuple[tuple[str, str], ...]:
        """Kind and component of each reading (K)."""
        return tuple((o.name, component) for o in self.channels for component in o.components)

    @property
    def keys(self) -> list[str]:
        """What each reading (K) is of, distances by their own names."""
        return [o.key for o in self.channels for _ in o.components]

    @property
    def read(self) -> tuple[str, ...]:
        """Names of what is read beside the platform."""
        return tuple(o.name for o in self.channels if o.of)

    @cached_property
    def angular(self) -> np.ndarray:
        """Which readings (K,) are angles."""
        return np.array([o.angular for o in self.channels for _ in o.components], dtype=bool)

    @cached_property
    def grouped(self) -> np.ndarray:
        """Which readings (K,) are of the groups' inclination."""
        return np.array([kind == "group" for kind in self.keys], dtype=bool)

    @property
    def size(self) -> float:
        return self.closure.characteristic_length

    @property
    def lengths(self) -> np.ndarray:
        """Lengths (K,) by which readings are multiplied to be lengths: the size for angles, 1 for
        lengths.
        """
        return np.where(self.angular, self.size, 1.0)

    @property
    def observes_through_frames(self) -> bool:
        """Whether frames between the mechanism and what is measured are unknown."""
        return any(n in MEASURING_FRAMES for n in self.names)

    @cached_property
    def _mapped(self) -> dict[str, Mapped]:
        system, scales = self.system, ca.diag(ca.DM(self.scales))
        both = (system.rows, self.readings)
        by_z = [
            system.jacobian,
            ca.mtimes(ca.jacobian(self.readings, system.unknown), system.tangent),
        ]
        by_p = [ca.mtimes(ca.jacobian(f, self.parameters), scales) for f in both]
        by_q = [ca.jacobian(f, self.joints) for f in both]
        outputs = {
            "whole": [both[0], by_z[0], by_p[0], both[1], by_z[1], by_p[1]],
            "rows": [both[0], by_z[0]],
            "tangent": [both[0], by_z[0], by_q[0], both[1], by_z[1], by_q[1]],
            "pose": [ca.vertcat(self.pose.position, self.pose.quaternion)],
            "exact": [self.exact],
        }
        inputs = [system.unknown, self.joints, self.parameters, self.quaternion]
        return {what: Mapped.of(inputs, made) for what, made in outputs.items()}

    def values(
        self,
        what: str,
        z: np.ndarray,
        joints: np.ndarray,
        p: np.ndarray = NOTHING,
        quaternions: np.ndarray | None = None,
    ) -> list[np.ndarray]:
        """Evaluate "rows", F (n, m) and F_z (n, m, f); "tangent", F, F_z, F_q (n, m, a), h, h_z,
        h_q (n, K, a); "exact", what each channel would read (n, w), quaternions whole.
        """
        if quaternions is None:
            quaternions = np.zeros((len(z), self.quaternion.shape[0]))
        results = self._mapped[what](z, joints, p, quaternions)
        # rows and readings, each with two derivatives, are columns
        return [a if k % 3 else a[:, :, 0] for k, a in enumerate(results)]


# --- building -------------------------------------------------------------------------------------


def build_model(
    mechanism: Mechanism, measurements: Measurements, names: Sequence[str]
) -> ConfigurationModel:
    """Build the model of a configuration with the readings that `measurements` has, over the named
    parameters; all others keep their nominal values.
    """
    channels = tuple(o for o, _ in measurements.channels(mechanism))
    return model_of(mechanism, channels, tuple(names))


@lru_cache(maxsize=64)
def model_of(
    mechanism: Mechanism, channels: tuple[Observable, ...], names: tuple[str, ...] = ()
) -> ConfigurationModel:
    """The same of what is read."""
    read = tuple(o.name for o in channels if o.of)
    table, every = nominal_parameters(mechanism, read), described_parameters(mechanism)
    for name in names:
        if name not in every:
            raise InputError(
                f"parameter {shown(name)} is unknown{meant(name, table)}; {mechanism.name} has "
                f"{', '.join(table)}"
            )
    # those that only what is not read depends on, too
    table |= {name: every[name] for name in names}
    symbols = {
        name: ca.SX.sym(name) if name in names else ca.SX(value)
        for name, (value, _) in table.items()
    }
    known = _Known(mechanism, symbols, observed(mechanism, read))
    closure, size = known.seen.closure, known.seen.closure.characteristic_length
    # the platform's, read or not
    turning = ["orientation", *(name for name in read if name.endswith(".orientation"))]
    quaternion = ca.SX.sym("measured", 4 * len(turning))
    measured = dict(zip(turning, ca.vertsplit(quaternion, 4), strict=True))
    parameters = stacked(symbols[n] for n in names)
    unknowns = closure.role("passive", "body", "pose")
    types = tuple(table[n][1] for n in names)
    return ConfigurationModel(
        mechanism=mechanism,
        closure=closure,
        system=System(
            unknowns,
            closure.symbols(unknowns),
            ca.vertcat(known.joints, parameters),
            known(closure.rows),
            known(closure.errors),
            size,
        ),
        names=names,
        kinds=types,
        nominal=np.array([table[n][0] for n in names]),
        scales=np.array([1.0 if kind == "length" else 1.0 / size for kind in types]),
        joints=known.joints,
        parameters=parameters,
        quaternion=quaternion,
        readings=stacked(known.reading(o, measured.get(o.name)) for o in channels),
        exact=stacked(known.reading(o) for o in channels),
        channels=channels,
        pose=known.pose,
    )


class _Known:
    """Expressions with what is known put in: readings of actuated joints in place of their
    coordinates, the parameters' symbols or numbers in place of the geometry; `pose` is that of the
    judged link as it is observed, from the world frame to the target.
    """

    def __init__(self, mechanism: Mechanism, symbols: Mapping[str, ca.SX], seen: Observed) -> None:
        self.mechanism, self.symbols, self.seen = mechanism, symbols, seen
        closure, actuated = seen.closure, seen.closure.role("actuated")
        self.joints = stacked(ca.SX.sym(f"{c.name}.reading") for c in actuated)
        own = dict(zip(closure.parameter_names, closure.parameter_values, strict=True))
        values = own | {name: value for name, (_, value) in seen.geometry.items()}
        self._before = ca.vertcat(
            closure.symbols(actuated),
            closure.parameters,
            *(symbol for name, (symbol, _) in seen.geometry.items() if name not in own),
        )
        self._after = ca.vertcat(
            ca.SX(0, 1),
            *(symbols[f"{c.name}.scale"] * self.joints[k] for k, c in enumerate(actuated)),
            *(symbols.get(name, ca.SX(float(value))) for name, value in values.items()),
        )
        self.world, target = (_frame(symbols, name) for name in ("world", "target"))
        self.pose = self._observed(seen.pose) @ target

    def __call__(self, expression: ca.SX) -> ca.SX:
        return ca.substitute(expression, self._before, self._after)

    def _observed(self, pose: ca.SX) -> Pose:
        known = self(pose)
        return self.world @ Pose(known[:3], known[3:])

    def reading(self, o: Observable, measured: ca.SX | None = None) -> ca.SX:
        """What is read, a column; of an orientation the turn from the one `measured`, if any."""
        value = self.seen.values.get(o.name, self.seen.pose)
        if o.kind == "joint":
            return self(value) / self.symbols[f"{o.name}.scale"]
        if o.kind == "point":
            return self.world.apply(self(value))
        if o.kind == "distance" and not o.ends:
            return self(value)
        pose = self._observed(value) if o.of else self.pose
        match o.kind:
            case "distance":
                end, base = (ca.SX(ca.DM(list(point))) for point in o.ends)
                gap = pose.apply(end) - base
                return ca.sqrt(dot(gap, gap))
            case "group":
                level = ca.SX(ca.DM(level_turn(self.mechanism)))
                return inclination(multiply(pose.quaternion, level))
            case "inclination":
                return inclination(pose.quaternion)
            case "position":
                return pose.position
        if measured is None:
            return pose.quaternion
        # twice the vector part of the quaternion
        e = multiply(conjugate(measured), pose.quaternion)
        return 2 * ca.if_else(e[0] < 0, -1, 1) * e[1:]


def _frame(symbols: Mapping[str, ca.SX], name: str) -> Pose:
    """The world or target frame."""
    place, turn = (
        ca.vertcat(*(symbols[f"{name}.{what}.{k}"] for k in "xyz"))
        for what in ("position", "rotation")
    )
    still = turn.is_zero()  # no operations are left of it so
    return Pose(place, ca.SX([1, 0, 0, 0]) if still else quaternion_from_rotation_vector(turn))


def inclination(q: ca.SX) -> ca.SX:
    """Return alpha and beta of R = Rz(gamma) Ry(beta) Rx(alpha), from the last row of R: (-sin b,
    cos b sin a, cos b cos a).
    """
    up = rotate(conjugate(q), ca.SX([0, 0, 1]))
    across = ca.sqrt(up[1] * up[1] + up[2] * up[2])
    return ca.vertcat(ca.atan2(up[1], up[2]), ca.atan2(-up[0], across))


def level_turn(mechanism: Mechanism) -> np.ndarray:
    """The turn (4,) of the platform frame after which its z axis points up at the reference. Groups
    are compared by alpha and beta of the frame so turned: these weigh errors of tilt alike about
    every axis there, where alpha of a frame whose x axis points up is any.
    """
    first, second, third = mechanism.reference_pose.inverse().turn(np.array([0.0, 0.0, 1.0]))
    turn = np.array([1.0 + third, -second, first, 0.0])
    if turn[0] < 1e-12:  # z points down: a half turn about x
        turn = np.array([0.0, 1.0, 0.0, 0.0])
    return turn / np.linalg.norm(turn)
