"""Name the parameters of a mechanism that may be identified, with nominal values and kinds, and
write identified values back.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from symkin.calibration.data.observables import (
    ParameterKind,
    observables_named,
    observed,
    observing_closure,
    point_path,
)
from symkin.closure.closure import build_closure, random_points
from symkin.closure.link_frames import link_frames
from symkin.closure.rows import RowBuilder
from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.model.dh import DHRow, DHTable
from symkin.model.graph import LinkPoint, LinkRod
from symkin.model.joint import Joint
from symkin.model.limb import Limb, Rod, RodLimb
from symkin.model.mechanism import Mechanism, serial_arm_from_dh
from symkin.text import meant

MEASURING_FRAMES = tuple(
    f"{frame}.{what}.{k}"
    for frame in ("world", "target")
    for what in ("position", "rotation")
    for k in "xyz"
)
"""Components of the frames between mechanism and measurement: the base frame in the measuring
system (world), and what is observed in the platform frame (target); lengths, and rotation vectors
in radians.
"""

AXES = ("x", "y", "z")
Velocity = dict[str, float]
"""Rates of parameters by name; those that are not named stay."""


def parameter_names(mechanism: Mechanism, read: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Name all that may be identified: the closure's parameters, those of what is read besides (see
    `data.observables`), factors of readings, world and target frame.
    """
    return tuple(nominal_parameters(mechanism, read))


def nominal_parameters(
    mechanism: Mechanism, read: tuple[str, ...] = ()
) -> dict[str, tuple[float, ParameterKind]]:
    """List all that may be identified by name, with nominal value (lengths, radians, plain numbers)
    and kind.
    """
    every = described_parameters(mechanism)
    joints = [o.name for o in observables_named(mechanism, read) if o.kind == "joint"]
    scales = [f"{name}.scale" for name in (*(c.name for c in mechanism.actuated), *joints)]
    names = (*geometry_parameters(mechanism, read), *scales, *MEASURING_FRAMES)
    return {name: every[name] for name in names}


@lru_cache(maxsize=64)
def geometry_parameters(mechanism: Mechanism, read: tuple[str, ...] = ()) -> Mapping[str, float]:
    """The numbers of the description, by key path, on which the closure or what is read depends."""
    found = observed(mechanism, read)
    closure = found.closure
    values = dict(zip(closure.parameter_names, map(float, closure.parameter_values), strict=True))
    others = {name: pair for name, pair in found.geometry.items() if name not in values}
    if others:
        seen, symbols = ca.vertcat(*found.values.values()), [s for s, _ in others.values()]
        depends = ca.which_depends(seen, ca.vertcat(*symbols), 1, False) if found.values else []
        pairs = zip(others.items(), depends, strict=False)
        values |= {name: value for (name, (_, value)), flag in pairs if flag}
    # where no link carries it, the platform frame is a place at which loops are compared, and no
    # geometry
    out = "platform." if mechanism.platform_link is None else " "
    return {name: value for name, value in values.items() if not name.startswith(out)}


@lru_cache(maxsize=64)
def described_parameters(mechanism: Mechanism) -> Mapping[str, tuple[float, ParameterKind]]:
    """List all numbers of the description, those that nothing depends on too, the factors of all
    joints and the measuring frames.
    """
    geometry = link_frames(build_closure(mechanism)).geometry
    values = {name: value for name, (_, value) in geometry.items()}
    for p in mechanism.link_points:
        values |= vector_velocity(point_path(p), np.array(p.point))
    zeros = {f"{p}.zero" for p, joint in joint_paths(mechanism) if joint.type in ("R", "H")}
    points = tuple(f"{point_path(point)}." for point in mechanism.link_points)

    def kind_of(name: str) -> ParameterKind:
        _, *inner, last = name.split(".")
        if name in zeros or (name.startswith("dh.") and last in ("theta", "alpha")):
            return "angle"
        unit = inner[-1:] in (["axis"], ["axis2"], ["quaternion"])
        return "number" if unit and not name.startswith(points) else "length"

    found = {name: (float(value), kind_of(name)) for name, value in values.items()}
    found |= {f"{c.name}.scale": (1.0, "number") for c in mechanism.coordinates}
    return found | {
        name: (0.0, "angle" if ".rotation." in name else "length") for name in MEASURING_FRAMES
    }


def joint_paths(mechanism: Mechanism) -> Iterator[tuple[str, Joint]]:
    """All joints with the key paths of their parameters, in file order."""
    for limb, joint in mechanism.joints:
        yield mechanism.key_path(limb, joint), joint
    for entry in mechanism.link_joints:
        yield entry.joint.name, entry.joint


@lru_cache(maxsize=64)
def bound_by_motion(mechanism: Mechanism, read: tuple[str, ...] = ()) -> frozenset[str]:
    """Name the parameters that a declared motion binds, or loops that are planar or spherical:
    moved alone, they let rows that the motion leaves out appear, and the limb could no longer carry
    the platform through it.
    """
    closure = observing_closure(mechanism, read)
    builder = RowBuilder(mechanism, partition=closure.partition)
    builder.build_rows()
    if len(builder.rows) == closure.rows.shape[0]:
        return frozenset()
    variables = ca.vertcat(*(builder.coordinates[c.name][1] for c in closure.coordinates))
    rows, table = ca.vertcat(*builder.rows), ca.vertcat(*builder.table.symbols)
    both = ca.Function("left_out", [variables, table], [rows, ca.jacobian(rows, table)])
    size = closure.characteristic_length
    points = random_points(closure.coordinates, size, 3)
    drawn = [both(point, builder.table.values) for point in points]
    largest, slopes = (
        np.abs([np.asarray(values) for values in found]).max(axis=0)
        for found in zip(*drawn, strict=True)
    )
    reach = slopes[largest[:, 0] <= 1e-11 * size].max(axis=0, initial=0.0)
    return frozenset(n for n, r in zip(builder.table.names, reach, strict=True) if r > 1e-9)


def is_writable(name: str) -> bool:
    """Tell whether a mechanism file has a place for the parameter: factors of readings and
    measuring frames have none.
    """
    return not name.endswith(".scale") and name not in MEASURING_FRAMES


def with_parameters(mechanism: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """Replace values of named parameters in a mechanism (key paths of the closure, angles in
    radians); names that a file has no place for are left out. Rods keep their lengths, which become
    explicit.
    """
    table = {**geometry_parameters(mechanism)} | {
        name: float(v) for name, v in values.items() if is_writable(name)
    }
    if mechanism.dh is not None:
        rows = [_with(row, f"dh.{i}", table) for i, row in enumerate(mechanism.dh.rows, start=1)]
        kept = ("length_unit", "angle_unit", "title", "source", "example")
        options = {key: getattr(mechanism, key) for key in kept}
        return serial_arm_from_dh(mechanism.name, DHTable(mechanism.dh.convention, rows), **options)
    frame = mechanism.frame_name
    q = _vector_of(table, f"{frame}.quaternion", mechanism.platform_quaternion)
    length = sum(v * v for v in q) ** 0.5

    def limb_with(limb: Limb | RodLimb) -> Limb | RodLimb:
        if isinstance(limb, RodLimb):
            return _with(limb, limb.name, table)
        joints = [_with(joint, mechanism.key_path(limb, joint), table) for joint in limb.joints]
        rods = [_with(rod, f"{limb.name}.rod{k}", table) for k, rod in enumerate(limb.rods, 1)]
        return replace(limb, joints=joints, rods=rods)

    return replace(
        mechanism,
        limbs=[limb_with(limb) for limb in mechanism.limbs],
        link_joints=[
            replace(e, joint=_with(e.joint, e.joint.name, table)) for e in mechanism.link_joints
        ],
        link_rods=[_with(rod, rod.name, table) for rod in mechanism.link_rods],
        link_points=[_with(p, point_path(p), table) for p in mechanism.link_points],
        platform_position=_vector_of(table, f"{frame}.position", mechanism.platform_position),
        platform_quaternion=q if abs(length - 1.0) <= 4e-16 else tuple(v / length for v in q),
    )


_KEYS: dict[type, dict[str, str]] = {
    Joint: {k: k for k in ("point", "axis", "axis2", "pitch", "zero")},
    Rod: {"start": "from", "platform": "platform", "length": "length"},
    RodLimb: {k: k for k in ("base", "platform", "offset")},
    LinkRod: {"start": "from", "end": "to", "length": "length", "offset": "offset"},
    LinkPoint: {"point": ""},
    DHRow: {k: k for k in ("theta", "d", "a", "alpha")},
}
"""Key paths, after those of the part, of the numbers that a part holds."""
_Part = TypeVar("_Part", Joint, Rod, RodLimb, LinkRod, LinkPoint, DHRow)


def _with(part: _Part, path: str, values: Mapping[str, float]) -> _Part:
    changes: dict[str, Any] = {}
    for key, end in _KEYS[type(part)].items():
        value, name = getattr(part, key), f"{path}.{end}".rstrip(".")
        vector = isinstance(value, Sequence)
        changes[key] = _vector_of(values, name, value) if vector else values.get(name, value)
    return replace(part, **changes)


def _vector_of(
    values: Mapping[str, float], path: str, nominal: Sequence[float]
) -> tuple[float, ...]:
    letters = "xyz" if len(nominal) == 3 else "wxyz"
    return tuple(values.get(f"{path}.{k}", v) for k, v in zip(letters, nominal, strict=True))


# --- single joints --------------------------------------------------------------------------------


def written_freedoms(
    mechanism: Mechanism, values: Mapping[str, float], read: Sequence[str] = ()
) -> Iterator[tuple[str, Velocity]]:
    """Yield the freedoms in how joints are written down, each with the rates of parameters that it
    leaves open: where on its axis the point of a joint lies, the length of a direction, the zero of
    a passive joint that nothing reads and no coupling names.
    """
    meant = {*read, *(name for c in mechanism.couplings for name in (c.joint, *c.names))}
    for path, joint in joint_paths(mechanism):
        if joint.type == "P":
            for k, axis in enumerate(AXES):
                yield (
                    f"point {axis} of prismatic joint {path}",
                    vector_velocity(f"{path}.point", np.eye(3)[k]),
                )
        elif joint.type in ("R", "H", "C"):
            yield (
                f"point of {path} along its axis",
                vector_velocity(f"{path}.point", vector_values(values, f"{path}.axis")),
            )
        for key in ("axis", "axis2"):
            if getattr(joint, key) is not None:
                yield (
                    f"length of the vector {path}.{key}",
                    vector_velocity(f"{path}.{key}", vector_values(values, f"{path}.{key}")),
                )
        if joint.freedom == 1 and not joint.actuated and joint.name not in meant:
            yield f"zero of passive joint {path}", {f"{path}.zero": 1.0}
    frame = mechanism.frame_name
    if f"{frame}.quaternion.w" in values:
        q = vector_values(values, f"{frame}.quaternion", "wxyz")
        yield f"length of {frame}.quaternion", vector_velocity(f"{frame}.quaternion", q, "wxyz")


def vector_values(values: Mapping[str, float], path: str, letters: str = "xyz") -> np.ndarray:
    return np.array([values.get(f"{path}.{k}", 0.0) for k in letters])


def vector_velocity(path: str, value: np.ndarray, letters: str = "xyz") -> Velocity:
    return {f"{path}.{k}": float(v) for k, v in zip(letters, value, strict=True)}


def joint_frames(
    mechanism: Mechanism, platform: Sequence[str], base: Sequence[str]
) -> tuple[str, ...]:
    """Name the parameters to hold so that frames stand in the joints of a platform on rods: the
    platform frame's origin in the joint of the first limb named, x axis through the second, xy
    plane through the third; the base frame's origin in the joint of the first, z against gravity, x
    towards the projection of the second.

    Raises InputError where a limb is no rod, and where an entry to be held is not zero at the
    nominal geometry.
    """
    if len(platform) != 3 or len(base) != 2:
        raise InputError(
            f"joint frames need three limbs for the platform and two for the base, not "
            f"{len(platform)} and {len(base)}"
        )
    rods = {limb.name: limb for limb in mechanism.limbs if isinstance(limb, RodLimb)}
    for name in (*platform, *base):
        if name not in rods:
            raise InputError(
                f"joint frames: {name!r} is no rod limb of {mechanism.name}{meant(name, rods)}; "
                f"its rods are {', '.join(rods) or 'none'}"
            )
    ends = [*((name, "platform") for name in platform), *((name, "base") for name in base)]
    letters = ("xyz", "yz", "z", "xyz", "y")
    held = [(*end, k) for end, some in zip(ends, letters, strict=True) for k in some]
    for name, end, k in held:
        value = getattr(rods[name], end)["xyz".index(k)]
        if abs(value) > 1e-9 * mechanism.characteristic_length:
            raise InputError(
                f"joint frames: {name}.{end}.{k} = {value:g} must be 0; give the joints in these "
                f"frames first"
            )
    return tuple(f"{name}.{end}.{k}" for name, end, k in held)
