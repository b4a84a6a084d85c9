"""Evaluate the closure and the readings with their derivatives, for all configurations at once.

F(z; q, p) = 0 in the unknown coordinates z (passive joints and pose) given joint readings q and parameters p; readings
h(z, p). Derivatives are taken in the tangent space of z (see `numeric.system`) and along scaled parameters: one unit of
a scaled parameter is one length unit, for angles and directions 1/size. CasADi's map evaluates at first, compiled C once that
pays: libraries are kept in the cache folder (see `numeric.c_library`) and used from there at once; a new one is compiled when as
much time has gone into the map as the compiler is likely to take. SYMKIN_ENGINE = numpy forbids compiled code, as it does for path
tracking.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import casadi as ca
import numpy as np

from symkin.caching import cached_property, computing, lru_cache
from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import MEASURING_FRAMES, ParameterKind, nominal_parameters
from symkin.closure.closure import Closure, build_closure
from symkin.errors import InputError
from symkin.homotopy.compiled import OFF
from symkin.model.mechanism import Mechanism
from symkin.numeric.c_library import CompilerError, find_compilers, load_library
from symkin.numeric.cache import cache_folder
from symkin.numeric.system import System
from symkin.spatial.backend import dot
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, quaternion_from_rotation_vector

READING_KINDS = ("group", "inclination", "position", "orientation")
"""Kinds of readings in the order of their columns; distances follow."""
COMPONENTS = {
    "group": ("alpha", "beta"), "inclination": ("alpha", "beta"),
    "position": ("x", "y", "z"), "orientation": ("x", "y", "z"),
}  # fmt: skip


_VECTOR_OUTPUTS = {"whole": (0, 3), "rows": (0,), "joints": (), "tangent": (0, 3), "pose": (0,)}
"""Outputs that are columns, for each function of a posture."""

_INTERPRETED_BEFORE_COMPILING = 30000
"""A library is compiled when each of its instructions has been interpreted this often: about as long as compiling it."""
_MAX_INSTRUCTIONS = 30000
"""Functions of more instructions than this are not compiled: the compiler would take longer than the fit."""
_C_LOOP = """
int {name}_map(int n, const int* stride, const double** in, double** out) {{
  const double* arg[{args}]; double* res[{outs}]; casadi_int iw[{iw}]; double w[{w}]; int i, k;
  static const int sizes[{outs}] = {{{sizes}}};
  for (i = 0; i < n; ++i) {{
    for (k = 0; k < {n_in}; ++k) arg[k] = in[k] + (size_t)i * stride[k];
    for (k = 0; k < {n_out}; ++k) res[k] = out[k] + (size_t)i * sizes[k];
    {name}(arg, res, iw, w, 0);
  }}
  return 0;
}}
"""


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Values at n postures: rows F (n, m), F_z (n, m, f), F_p (n, m, P); readings h (n, K), h_z (n, K, f), h_p (n, K, P)."""

    rows: np.ndarray
    rows_z: np.ndarray
    rows_p: np.ndarray
    readings: np.ndarray
    readings_z: np.ndarray
    readings_p: np.ndarray


@dataclass(frozen=True, eq=False)
class ConfigurationModel:
    """One posture as expressions: `system` holds closure and tangent space, `known` stacks joints, parameters and the
    measured quaternion; `columns` names each reading (kind, component)."""

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

    def evaluate(self, z: np.ndarray, joints: np.ndarray, p: np.ndarray, quaternions: np.ndarray) -> Evaluation:
        """Closure and readings with derivatives; z (n, width), joints (n, a), p (P,), quaternions (n, 4)."""
        return Evaluation(*self._call("whole", z, joints, p, quaternions))

    def rows(self, z: np.ndarray, joints: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F (n, m) and F_z (n, m, f)."""
        rows, rows_z = self._call("rows", z, joints, p, np.zeros((len(z), 4)))
        return rows, rows_z

    def rows_by_joint(self, z: np.ndarray, joints: np.ndarray, p: np.ndarray) -> np.ndarray:
        """dF/dq (n, m, a)."""
        return self._call("joints", z, joints, p, np.zeros((len(z), 4)))[0]

    def tangent(self, z: np.ndarray, joints: np.ndarray, p: np.ndarray) -> list[np.ndarray]:
        """F, F_z, F_q, h, h_z, orientations measured against none."""
        return self._call("tangent", z, joints, p, np.zeros((len(z), 4)))

    def poses(self, z: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Observed poses (n, 7), quaternions with w >= 0."""
        packed = self._call("pose", z, np.zeros((len(z), int(self.joints.shape[0]))), p, np.zeros((len(z), 4)))[0]
        return np.asarray(np.where(packed[:, 3:4] < 0, np.hstack([packed[:, :3], -packed[:, 3:]]), packed))

    @property
    def observes_through_frames(self) -> bool:
        """Whether frames between the mechanism and what is measured are unknown."""
        return any(n in MEASURING_FRAMES for n in self.names)

    def compile(self) -> None:
        """Compile the functions now, where there is a compiler; else they are when that pays (see `mapped`)."""
        self._mapped["whole"].engine.compile()

    @cached_property
    def _outputs(self) -> dict[str, list[ca.SX]]:
        system, scales = self.system, ca.diag(ca.DM(self.scales))
        rows_z = system.jacobian
        readings_z = ca.mtimes(ca.jacobian(self.readings, system.unknown), system.tangent)
        by_p = [ca.mtimes(ca.jacobian(f, self.parameters), scales) for f in (system.rows, self.readings)]
        return {
            "whole": [system.rows, rows_z, by_p[0], self.readings, readings_z, by_p[1]],
            "rows": [system.rows, rows_z],
            "joints": [ca.jacobian(system.rows, self.joints)],
            "tangent": [system.rows, rows_z, ca.jacobian(system.rows, self.joints), self.readings, readings_z],
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

    def _call(self, what: str, z: np.ndarray, joints: np.ndarray, p: np.ndarray, quaternions: np.ndarray) -> list[np.ndarray]:
        results = self._mapped[what](len(z), (z, joints, p, quaternions))
        vectors = _VECTOR_OUTPUTS[what]
        return [a[:, 0, :] if k in vectors else a.transpose(0, 2, 1) for k, a in enumerate(results)]


# --- building ------------------------------------------------------------------------------------------------------


def build_model(mechanism: Mechanism, measurements: Measurements, names: Sequence[str]) -> ConfigurationModel:
    """The model of a posture with the readings that `measurements` has, over the named parameters; all others keep
    their nominal values."""
    kinds = tuple(k for k in READING_KINDS if _is_taken(measurements, k))
    distances = tuple((d.name, tuple(d.platform), tuple(d.base)) for d in measurements.distances)
    return _build_model(mechanism, kinds, distances, tuple(names))


def _is_taken(measurements: Measurements, kind: str) -> bool:
    if kind == "group":
        return measurements.groups is not None
    return getattr(measurements, kind) is not None


@lru_cache(maxsize=64)
def _build_model(
    mechanism: Mechanism, kinds: tuple[str, ...], distances: tuple[tuple[str, tuple[float, ...], tuple[float, ...]], ...],
    names: tuple[str, ...],
) -> ConfigurationModel:  # fmt: skip
    closure = build_closure(mechanism)
    table = nominal_parameters(mechanism)
    for name in names:
        if name not in table:
            raise InputError(f"parameter {name!r} is unknown; {mechanism.name} has {', '.join(table)}")
    symbols = {name: ca.SX.sym(name) if name in names else ca.SX(value) for name, (value, _) in table.items()}
    parameters = ca.vertcat(*(symbols[n] for n in names)) if names else ca.SX(0, 1)
    system, readings_of_joints = _closure_system(closure, symbols, parameters)
    pose = _observed_pose(closure, symbols)
    quaternion = ca.SX.sym("measured", 4)
    readings, columns = _readings(pose, quaternion, kinds, distances)
    system = System(
        system.unknowns, system.unknown, ca.vertcat(readings_of_joints, parameters), system.rows, system.errors, closure.size
    )
    types = tuple(table[n][1] for n in names)
    scales = np.array([1.0 if kind == "length" else 1.0 / closure.size for kind in types])
    return ConfigurationModel(
        mechanism, closure, system, names, types, np.array([table[n][0] for n in names]), scales, readings_of_joints,
        parameters, quaternion, readings, columns, pose,
    )  # fmt: skip


def _closure_system(closure: Closure, symbols: dict[str, ca.SX], parameters: ca.SX) -> tuple[System, ca.SX]:
    """The closure over readings in place of actuated coordinates, and the readings."""
    unknowns = closure.role("passive", "pose")
    actuated = closure.role("actuated")
    readings = ca.vertcat(*(ca.SX.sym(f"{c.name}.reading") for c in actuated)) if actuated else ca.SX(0, 1)
    unknown = ca.vertcat(*(closure.variables[closure.slices[c.name]] for c in unknowns))
    before = [*(closure.variables[closure.slices[c.name]] for c in actuated), closure.parameters]
    after = [*(symbols[f"{c.name}.scale"] * readings[k] for k, c in enumerate(actuated)), _parameter_values(closure, symbols)]
    rows, errors = ca.substitute([closure.rows, closure.errors], [ca.vertcat(*before)], [ca.vertcat(*after)])
    return System(unknowns, unknown, ca.vertcat(readings, parameters), rows, errors, closure.size), readings


def _parameter_values(closure: Closure, symbols: dict[str, ca.SX]) -> ca.SX:
    return ca.vertcat(*(symbols[n] for n in closure.parameter_names)) if closure.parameter_names else ca.SX(0, 1)


def _observed_pose(closure: Closure, symbols: dict[str, ca.SX]) -> Pose:
    """world @ platform pose @ target."""

    def frame(name: str) -> Pose | None:
        parts = [symbols[f"{name}.{what}.{k}"] for what in ("position", "rotation") for k in "xyz"]
        if all(part.is_constant() and float(part) == 0.0 for part in parts):
            return None
        return Pose(ca.vertcat(*parts[:3]), quaternion_from_rotation_vector(ca.vertcat(*parts[3:])))

    packed = ca.vertcat(closure.pose.position, closure.pose.quaternion)
    packed = ca.substitute(packed, closure.parameters, _parameter_values(closure, symbols))
    pose = Pose(packed[:3], packed[3:])
    world, target = frame("world"), frame("target")
    pose = pose if world is None else world @ pose
    return pose if target is None else pose @ target


def _readings(
    pose: Pose, quaternion: ca.SX, kinds: Sequence[str], distances: Sequence[tuple[str, Sequence[float], Sequence[float]]]
) -> tuple[ca.SX, tuple[tuple[str, str], ...]]:
    made: list[ca.SX] = []
    columns: list[tuple[str, str]] = []
    for kind in kinds:
        match kind:
            case "group" | "inclination":
                made.extend(inclination(pose.quaternion))
            case "position":
                made.extend(ca.vertsplit(pose.position))
            case _:
                e = multiply(conjugate(quaternion), pose.quaternion)
                sign = ca.if_else(e[0] < 0, -1, 1)
                made.extend(2 * sign * e[k] for k in (1, 2, 3))
        columns.extend((kind, c) for c in COMPONENTS[kind])
    for name, end, base in distances:
        gap = pose.apply(ca.SX(ca.DM(list(end)))) - ca.SX(ca.DM(list(base)))
        made.append(ca.sqrt(dot(gap, gap)))
        columns.append(("distance", name))
    return ca.vertcat(*made) if made else ca.SX(0, 1), tuple(columns)


def inclination(q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """alpha and beta of R = Rz(gamma) Ry(beta) Rx(alpha), from the last row of R: (-sin b, cos b sin a, cos b cos a)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    first, second, third = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return ca.atan2(second, third), ca.atan2(-first, ca.sqrt(second * second + third * third))


class CompiledLibrary:
    """The library of some functions: None until it is found or compiled."""

    def __init__(self, functions: Sequence[ca.Function]) -> None:
        self.functions = functions
        self.size = sum(f.n_instructions() for f in functions)
        self.library: ctypes.CDLL | None = None
        self.left = float(_INTERPRETED_BEFORE_COMPILING) * self.size
        if os.environ.get("SYMKIN_ENGINE", "") == OFF or self.size > _MAX_INSTRUCTIONS:
            self.left = float("inf")
        else:
            self._load(build=False)

    def spend(self, instructions: int) -> ctypes.CDLL | None:
        """The library, compiled when enough instructions have been interpreted."""
        if self.library is None and self.left < float("inf"):
            self.left -= instructions
            if self.left <= 0.0:
                self.compile()
        return self.library

    def compile(self) -> None:
        """Compile now; without a compiler nothing changes."""
        with computing((id(self), "library")):
            if self.library is None and self.left < float("inf"):
                self._load(build=True)
                self.left = float("inf")

    def _load(self, *, build: bool) -> None:
        try:
            found = find_compilers(os.environ.get("CC", ""), os.environ.get("PATH", ""))
            quick = (replace(c, flags=tuple("-O1" if flag == "-O2" else flag for flag in c.flags)) for c in found)
            self.library = load_library(
                quick, {"postures.c": _c_source(self.functions)}, "postures.c", cache_folder(), build=build
            )
        except CompilerError:
            self.library = None


@dataclass(frozen=True, eq=False)
class MappedFunction:
    """A function with dense outputs, at n postures at once: inputs (n, width) or (width,) for all; outputs (n, columns,
    rows), the columns of each output one after another."""

    function: ca.Function
    engine: CompiledLibrary
    _maps: dict[int, ca.Function] = field(default_factory=dict)

    def __call__(self, count: int, inputs: Sequence[np.ndarray]) -> list[np.ndarray]:
        results = [np.empty((count, *shape)) for shape in self._shapes]
        inputs = [np.ascontiguousarray(a, dtype=float) for a in inputs]
        if self.engine.spend(count * self._cost) is None:
            self._interpreted(count, inputs, results)
        else:
            strides = (ctypes.c_int * len(inputs))(*(0 if a.ndim == 1 else a.shape[1] for a in inputs))
            pointers = (ctypes.c_void_p * len(inputs))(*(a.ctypes.data for a in inputs))
            ends = (ctypes.c_void_p * len(results))(*(a.ctypes.data for a in results))
            self._run(count, strides, pointers, ends)
        return results

    @cached_property
    def _cost(self) -> int:
        return int(self.function.n_instructions())

    @cached_property
    def _shapes(self) -> list[tuple[int, int]]:
        f = self.function
        return [(f.size2_out(k), f.size1_out(k)) for k in range(f.n_out())]

    @cached_property
    def _run(self) -> Any:
        return getattr(self.engine.library, f"{self.function.name()}_map")

    def _interpreted(self, count: int, inputs: list[np.ndarray], results: list[np.ndarray]) -> None:
        if count not in self._maps:
            self._maps[count] = self.function.map(count)
        buffer, run = self._maps[count].buffer()
        full = [np.ascontiguousarray(np.broadcast_to(a, (count, a.shape[-1]))) for a in inputs]
        for k, array in enumerate(full):
            buffer.set_arg(k, array.reshape(-1).data)
        for k, array in enumerate(results):
            buffer.set_res(k, array.reshape(-1).data)
        run()


def map_functions(functions: Sequence[ca.Function]) -> list[MappedFunction]:
    """The functions as maps over postures, of one library."""
    engine = CompiledLibrary(functions)
    return [MappedFunction(f, engine) for f in functions]


def _c_source(functions: Sequence[ca.Function]) -> str:
    generator = ca.CodeGenerator("postures.c", {"casadi_int": "int"})
    for f in functions:
        generator.add(f)
    loops = [
        _C_LOOP.format(
            name=f.name(), args=max(f.sz_arg(), 1), outs=max(f.sz_res(), 1), iw=max(f.sz_iw(), 1), w=max(f.sz_w(), 1),
            n_in=f.n_in(), n_out=f.n_out(), sizes=", ".join(str(f.numel_out(k)) for k in range(f.n_out())),
        )
        for f in functions
    ]  # fmt: skip
    return "\n".join(["#include <stddef.h>", str(generator.dump()), *loops])
