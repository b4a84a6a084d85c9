"""Name the parameters of a mechanism that may be identified, with nominal values and kinds, and write identified values back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

import casadi as ca
import numpy as np

from symkin.closure.closure import build_closure, random_values
from symkin.closure.rows import RowBuilder
from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.model.dh import DHTable
from symkin.model.joint import Joint
from symkin.model.limb import Limb, Rod, RodLimb
from symkin.model.mechanism import Mechanism, serial_arm_from_dh

ParameterKind = Literal["length", "angle", "number"]
MEASURING_FRAMES = tuple(
    f"{frame}.{what}.{k}" for frame in ("world", "target") for what in ("position", "rotation") for k in "xyz"
)
"""Components of the frames between mechanism and measurement: the base frame in the measuring system (world), and what is
observed in the platform frame (target); lengths, and rotation vectors in radians."""

AXES = ("x", "y", "z")
Velocity = dict[str, float]
"""Rates of parameters by name; those that are not named stay."""


def parameter_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Name all that may be identified: the closure's parameters, factors of readings, world and target frame."""
    return tuple(nominal_parameters(mechanism))


def nominal_parameters(mechanism: Mechanism) -> dict[str, tuple[float, ParameterKind]]:
    """List all that may be identified by name, with nominal value (lengths, radians, plain numbers) and kind."""
    closure = build_closure(mechanism)
    turning = {f"{_joint_path(mechanism, limb.name, j.name)}.zero" for limb, j in mechanism.joints if j.type in ("R", "H")}
    table: dict[str, tuple[float, ParameterKind]] = {}
    for name, value in zip(closure.parameter_names, closure.parameter_values, strict=True):
        pieces = name.split(".")
        directed = pieces[-2] in ("axis", "axis2", "quaternion")
        angular = name in turning or (pieces[0] == "dh" and pieces[-1] in ("theta", "alpha"))
        table[name] = (float(value), "number" if directed else "angle" if angular else "length")
    for c in mechanism.actuated:
        table[f"{c.name}.scale"] = (1.0, "number")
    table |= {name: (0.0, "angle" if ".rotation." in name else "length") for name in MEASURING_FRAMES}
    return table


@lru_cache(maxsize=64)
def bound_by_motion(mechanism: Mechanism) -> frozenset[str]:
    """Name the parameters that a declared motion binds: moved alone, they let rows that the motion leaves out appear, and the
    limb could no longer carry the platform through it."""
    closure = build_closure(mechanism)
    builder = RowBuilder(mechanism)
    builder.build_rows()
    if len(builder.rows) == int(closure.rows.shape[0]):
        return frozenset()
    coordinates = [builder.coordinates[c.name][1] for c in closure.coordinates]
    variables, table = ca.vertcat(*coordinates), ca.vertcat(*builder.table.symbols)
    both = ca.Function("left_out", [variables, table], [ca.vertcat(*builder.rows), ca.jacobian(ca.vertcat(*builder.rows), table)])
    rng, size = np.random.default_rng(0), closure.characteristic_length
    largest, slopes = np.zeros(len(builder.rows)), np.zeros((len(builder.rows), len(builder.table.names)))
    for _ in range(3):
        rows, by_p = both(random_values(closure.coordinates, size, rng), builder.table.values)
        largest = np.maximum(largest, np.abs(np.asarray(rows)).ravel())
        slopes = np.maximum(slopes, np.abs(np.asarray(by_p)))
    left_out = largest <= 1e-11 * size
    reach = np.max(slopes[left_out], axis=0, initial=0.0)
    return frozenset(n for n, r in zip(builder.table.names, reach, strict=True) if r > 1e-9)


def _joint_path(mechanism: Mechanism, limb: str, joint: str) -> str:
    return joint if mechanism.serial else f"{limb}.{joint}"


def is_writable(mechanism: Mechanism, name: str) -> bool:
    """Tell whether a mechanism file has a place for the parameter: factors of readings and measuring frames have none."""
    return name in build_closure(mechanism).parameter_names


def with_parameters(mechanism: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """Replace values of named parameters in a mechanism (key paths of the closure, angles in radians); names that a file has
    no place for are left out. Rods keep their lengths, which become explicit."""
    closure = build_closure(mechanism)
    table = dict(zip(closure.parameter_names, map(float, closure.parameter_values), strict=True))
    table |= {name: float(v) for name, v in values.items() if name in table}
    if mechanism.dh is not None:
        return _with_dh(mechanism, mechanism.dh, table)
    frame = "tool" if mechanism.serial else "platform"
    limbs = tuple(_limb_with(mechanism, limb, table) for limb in mechanism.limbs)
    return replace(
        mechanism,
        limbs=limbs,
        platform_position=_vector_of(table, f"{frame}.position", mechanism.platform_position),
        platform_quaternion=_unit_quaternion(_vector_of(table, f"{frame}.quaternion", mechanism.platform_quaternion, "wxyz")),
    )


def _with_dh(mechanism: Mechanism, table: DHTable, values: Mapping[str, float]) -> Mechanism:
    rows = [
        replace(row, **{k: values.get(f"dh.{i}.{k}", getattr(row, k)) for k in ("theta", "d", "a", "alpha")})
        for i, row in enumerate(table.rows, start=1)
    ]
    options = {k: getattr(mechanism, k) for k in ("length_unit", "angle_unit", "title", "source", "example")}
    return serial_arm_from_dh(mechanism.name, DHTable(table.convention, rows), **options)


def _limb_with(mechanism: Mechanism, limb: Limb | RodLimb, values: Mapping[str, float]) -> Limb | RodLimb:
    if isinstance(limb, RodLimb):
        return replace(
            limb,
            base=_vector_of(values, f"{limb.name}.base", limb.base),
            platform=_vector_of(values, f"{limb.name}.platform", limb.platform),
            offset=values.get(f"{limb.name}.offset", limb.offset),
        )
    joints = [_joint_with(j, j.name if mechanism.serial else f"{limb.name}.{j.name}", values) for j in limb.joints]
    rods = [_rod_with(rod, f"{limb.name}.rod{k}", values) for k, rod in enumerate(limb.rods, start=1)]
    return replace(limb, joints=joints, rods=rods)


def _joint_with(joint: Joint, path: str, values: Mapping[str, float]) -> Joint:
    changes: dict[str, Any] = {"point": _vector_of(values, f"{path}.point", joint.point)}
    for key in ("axis", "axis2"):
        if getattr(joint, key) is not None:
            changes[key] = _vector_of(values, f"{path}.{key}", getattr(joint, key))
    for key in ("pitch", "zero"):
        changes[key] = values.get(f"{path}.{key}", getattr(joint, key))
    return replace(joint, **changes)


def _rod_with(rod: Rod, path: str, values: Mapping[str, float]) -> Rod:
    start, end = _vector_of(values, f"{path}.from", rod.start), _vector_of(values, f"{path}.platform", rod.platform)
    return Rod(start, end, values.get(f"{path}.length", rod.length))


def _vector_of(values: Mapping[str, float], path: str, nominal: Sequence[float], letters: str = "xyz") -> tuple[float, ...]:
    return tuple(values.get(f"{path}.{k}", v) for k, v in zip(letters, nominal, strict=True))


def _unit_quaternion(q: tuple[float, ...]) -> tuple[float, ...]:
    length = sum(v * v for v in q) ** 0.5
    return q if abs(length - 1.0) <= 4e-16 else tuple(v / length for v in q)


# --- single joints -------------------------------------------------------------------------------------------------


def written_freedoms(mechanism: Mechanism, values: Mapping[str, float]) -> Iterator[tuple[str, Velocity]]:
    """Yield the freedoms in how joints are written down, each with the rates of parameters that it leaves open: where on its
    axis the point of a joint lies, the length of a direction, the zero of a passive joint."""
    for limb, joint in mechanism.joints:
        path = joint.name if mechanism.serial else f"{limb.name}.{joint.name}"
        if joint.type == "P":
            for k, axis in enumerate(AXES):
                yield f"point {axis} of prismatic joint {path}", vector_velocity(f"{path}.point", np.eye(3)[k])
        elif joint.type in ("R", "H", "C"):
            yield f"point of {path} along its axis", vector_velocity(f"{path}.point", vector_values(values, f"{path}.axis"))
        for key in ("axis", "axis2"):
            if getattr(joint, key) is not None:
                yield (
                    f"length of the vector {path}.{key}",
                    vector_velocity(f"{path}.{key}", vector_values(values, f"{path}.{key}")),
                )
        if joint.freedom == 1 and not joint.actuated:
            yield f"zero of passive joint {path}", {f"{path}.zero": 1.0}
    frame = "tool" if mechanism.serial else "platform"
    if f"{frame}.quaternion.w" in values:
        q = vector_values(values, f"{frame}.quaternion", "wxyz")
        yield f"length of {frame}.quaternion", vector_velocity(f"{frame}.quaternion", q, "wxyz")


def vector_values(values: Mapping[str, float], path: str, letters: str = "xyz") -> np.ndarray:
    return np.array([values.get(f"{path}.{k}", 0.0) for k in letters])


def vector_velocity(path: str, value: np.ndarray, letters: str = "xyz") -> Velocity:
    return {f"{path}.{k}": float(v) for k, v in zip(letters, value, strict=True)}


def joint_frames(mechanism: Mechanism, platform: Sequence[str], base: Sequence[str]) -> tuple[str, ...]:
    """Name the parameters to hold so that frames stand in the joints of a platform on rods: the platform frame's origin in the
    joint of the first limb named, x axis through the second, xy plane through the third; the base frame's origin in the joint of
    the first, z against gravity, x towards the projection of the second.

    Raises InputError where a limb is no rod, and where an entry to be held is not zero at the nominal geometry.
    """
    if len(platform) != 3 or len(base) != 2:
        raise InputError(
            f"joint frames need three limbs for the platform and two for the base, not {len(platform)} and {len(base)}"
        )
    rods = {limb.name: limb for limb in mechanism.limbs if isinstance(limb, RodLimb)}
    for name in (*platform, *base):
        if name not in rods:
            raise InputError(
                f"joint frames: {name!r} is no rod limb of {mechanism.name}; its rods are {', '.join(rods) or 'none'}"
            )
    held = [(name, "platform", k) for name, letters in zip(platform, ("xyz", "yz", "z"), strict=True) for k in letters]
    held += [(name, "base", k) for name, letters in zip(base, ("xyz", "y"), strict=True) for k in letters]
    for name, end, k in held:
        value = getattr(rods[name], end)["xyz".index(k)]
        if abs(value) > 1e-9 * mechanism.characteristic_length:
            raise InputError(f"joint frames: {name}.{end}.{k} = {value:g} must be 0; give the joints in these frames first")
    return tuple(f"{name}.{end}.{k}" for name, end, k in held)
