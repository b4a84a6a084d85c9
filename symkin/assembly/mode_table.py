"""The modes of many inputs (points), one after the other, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.assembly.modes_result import Modes
from symkin.closure.closure import Closure
from symkin.position.solution import Solution
from symkin.velocity.equations import variables_of

COMPLETENESS = ("not computed", "proved", "probability one", "incomplete", "sampled", "off the motion", "too many to list")
"""What the numbers of the array `completeness` mean: their place here."""


@dataclass(frozen=True, eq=False)
class ModeTable:
    """Of n points: `count` modes (-1: not counted), `completeness` codes, `unresolved` paths (-1: no paths), `continuum`: a set
    of solutions that are not isolated was met; `complex_count` (-1: not known). Of all m modes, in the order of points: positions
    (m, 3), quaternions (m, 4), joints (m, numbers) in the mechanism's units; residual, condition; limits: 1 within, 0 not, -1
    none; `certified` 1, 0, or -1 where it was not tried; radius; `values` (m, variables) of the closure."""

    count: np.ndarray
    completeness: np.ndarray
    unresolved: np.ndarray
    continuum: np.ndarray
    complex_count: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    joints: np.ndarray
    residual: np.ndarray
    condition: np.ndarray
    within_limits: np.ndarray
    certified: np.ndarray
    radius: np.ndarray
    values: np.ndarray


PER_POINT = ("count", "completeness", "unresolved", "continuum", "complex_count")


def joint_labels(closure: Closure) -> list[tuple[str, str]]:
    """Names and units of the numbers in `joints`: closure coordinates in order; a ball joint's are name.w, .x, .y, .z."""
    mechanism = closure.mechanism
    labels: list[tuple[str, str]] = []
    for c in closure.coordinates:
        if c.role == "pose":
            continue
        unit = mechanism.angle_unit if c.is_angular else mechanism.length_unit
        labels += [(f"{c.name}.{k}", "1") for k in "wxyz"] if c.kind == "quaternion" else [(c.name, unit)]
    return labels


def joint_values_out(closure: Closure, values: np.ndarray) -> np.ndarray:
    """Joint coordinates (m, numbers) in the mechanism's units, of full vectors of variables (m, variables)."""
    columns = [values[:, :0]]
    for c in closure.coordinates:
        if c.role != "pose":
            part = values[:, closure.slices[c.name]]
            columns.append(part * closure.mechanism.angle_out(1.0) if c.is_angular else part)
    return np.concatenate(columns, axis=1)


def from_modes(found: Modes, code: str | None = None) -> ModeTable:
    """One point, from its modes; `code` in place of their completeness."""
    closure = found.problem.closure
    width = len(joint_labels(closure))
    unresolved = -1 if found.unresolved_paths is None else found.unresolved_paths
    return ModeTable(
        count=np.array([len(found)]),
        completeness=np.array([COMPLETENESS.index(code or found.completeness)]),
        unresolved=np.array([unresolved]),
        continuum=np.array([found.positive_dimensional]),
        complex_count=np.array([-1 if found.complex_count is None else found.complex_count]),
        position=np.array([s.position for s in found]).reshape(-1, 3),
        quaternion=np.array([s.quaternion for s in found]).reshape(-1, 4),
        joints=np.array([_joints(s) for s in found]).reshape(-1, width),
        residual=np.array([s.residual for s in found]),
        condition=np.array([s.condition for s in found]),
        within_limits=np.array([_flag(s.within_limits) for s in found], dtype=int),
        certified=np.array([_flag(s.certified) for s in found], dtype=int),
        radius=np.array([np.nan if s.radius is None else s.radius for s in found]),
        values=np.array([variables_of(closure, s) for s in found]).reshape(-1, closure.reference.size),
    )


def nothing(closure: Closure, code: str, count: int) -> ModeTable:
    """One point without modes."""
    empty, width = np.zeros(0), len(joint_labels(closure))
    flags = np.zeros(0, dtype=int)
    return ModeTable(
        count=np.array([count]),
        completeness=np.array([COMPLETENESS.index(code)]),
        unresolved=np.array([-1]),
        continuum=np.array([False]),
        complex_count=np.array([-1]),
        position=np.zeros((0, 3)),
        quaternion=np.zeros((0, 4)),
        joints=np.zeros((0, width)),
        residual=empty,
        condition=empty,
        within_limits=flags,
        certified=flags,
        radius=empty,
        values=np.zeros((0, closure.reference.size)),
    )


def concatenated(tables: Sequence[ModeTable]) -> ModeTable:
    """The points of several tables, one after the other."""
    if len(tables) == 1:
        return tables[0]
    arrays = {name: np.concatenate([getattr(t, name) for t in tables]) for name in ModeTable.__dataclass_fields__}
    return ModeTable(**arrays)


def joined(plain: ModeTable, places: np.ndarray, others: dict[int, ModeTable]) -> ModeTable:
    """All points in order: `plain` holds those of `places`, `others` single ones."""
    if not others:
        return plain
    total = len(places) + len(others)
    owner = np.repeat(places, np.maximum(plain.count, 0))
    single = [(i, others[i]) for i in sorted(others)]
    owners = np.concatenate([owner, *(np.full(max(int(f.count[0]), 0), i) for i, f in single)])
    order = np.argsort(owners, kind="stable")
    arrays = {}
    for name in ModeTable.__dataclass_fields__:
        pieces = [getattr(plain, name), *(getattr(f, name) for _, f in single)]
        if name in PER_POINT:
            arrays[name] = np.zeros(total, dtype=pieces[0].dtype)
            arrays[name][places] = pieces[0]
            arrays[name][[i for i, _ in single]] = np.concatenate(pieces[1:])
        else:
            arrays[name] = np.concatenate(pieces)[order]
    return ModeTable(**arrays)


def _joints(solution: Solution) -> np.ndarray:
    values = solution.held_joints.values()
    return np.concatenate([np.zeros(0), *(np.atleast_1d(np.asarray(v, dtype=float)) for v in values)])


def _flag(value: bool | None) -> int:
    return -1 if value is None else int(value)
