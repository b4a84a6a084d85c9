"""Identified parameters written back into a mechanism (contract 1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from symkin.closure.closure import build_closure
from symkin.model.dh import DHTable
from symkin.model.joint import Joint
from symkin.model.limb import Limb, Rod, RodLimb
from symkin.model.mechanism import Mechanism, serial_arm_from_dh


def is_writable(mechanism: Mechanism, name: str) -> bool:
    """Whether a mechanism file has a place for the parameter: factors of readings and measuring frames have none."""
    return name in build_closure(mechanism).parameter_names


def with_parameters(mechanism: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """The same mechanism with other values of named parameters (key paths of the closure, angles in radians); names that
    a file has no place for are left out. Rods keep their lengths, which become explicit."""
    closure = build_closure(mechanism)
    table = dict(zip(closure.parameter_names, map(float, closure.parameter_values), strict=True))
    table |= {name: float(v) for name, v in values.items() if name in table}
    if mechanism.dh is not None:
        return _with_dh(mechanism, mechanism.dh, table)
    frame = "tool" if mechanism.serial else "platform"
    limbs = tuple(_limb(mechanism, limb, table) for limb in mechanism.limbs)
    return replace(
        mechanism,
        limbs=limbs,
        platform_position=_vector(table, f"{frame}.position", mechanism.platform_position),
        platform_quaternion=_unit(_vector(table, f"{frame}.quaternion", mechanism.platform_quaternion, "wxyz")),
    )


def _with_dh(mechanism: Mechanism, table: DHTable, values: Mapping[str, float]) -> Mechanism:
    rows = [
        replace(row, **{k: values.get(f"dh.{i}.{k}", getattr(row, k)) for k in ("theta", "d", "a", "alpha")})
        for i, row in enumerate(table.rows, start=1)
    ]
    options = {k: getattr(mechanism, k) for k in ("length_unit", "angle_unit", "title", "source", "example")}
    return serial_arm_from_dh(mechanism.name, DHTable(table.convention, rows), **options)


def _limb(mechanism: Mechanism, limb: Limb | RodLimb, values: Mapping[str, float]) -> Limb | RodLimb:
    if isinstance(limb, RodLimb):
        return replace(
            limb,
            base=_vector(values, f"{limb.name}.base", limb.base),
            platform=_vector(values, f"{limb.name}.platform", limb.platform),
            offset=values.get(f"{limb.name}.offset", limb.offset),
        )
    joints = [_joint(j, j.name if mechanism.serial else f"{limb.name}.{j.name}", values) for j in limb.joints]
    rods = [_rod(rod, f"{limb.name}.rod{k}", values) for k, rod in enumerate(limb.rods, start=1)]
    return replace(limb, joints=joints, rods=rods)


def _joint(joint: Joint, path: str, values: Mapping[str, float]) -> Joint:
    changes: dict[str, Any] = {"point": _vector(values, f"{path}.point", joint.point)}
    for key in ("axis", "axis2"):
        if getattr(joint, key) is not None:
            changes[key] = _vector(values, f"{path}.{key}", getattr(joint, key))
    for key in ("pitch", "zero"):
        changes[key] = values.get(f"{path}.{key}", getattr(joint, key))
    return replace(joint, **changes)


def _rod(rod: Rod, path: str, values: Mapping[str, float]) -> Rod:
    start, end = _vector(values, f"{path}.from", rod.start), _vector(values, f"{path}.platform", rod.platform)
    return Rod(start, end, values.get(f"{path}.length", rod.length))


def _vector(values: Mapping[str, float], path: str, nominal: Sequence[float], letters: str = "xyz") -> tuple[float, ...]:
    return tuple(values.get(f"{path}.{k}", v) for k, v in zip(letters, nominal, strict=True))


def _unit(q: tuple[float, ...]) -> tuple[float, ...]:
    length = sum(v * v for v in q) ** 0.5
    return q if abs(length - 1.0) <= 4e-16 else tuple(v / length for v in q)
