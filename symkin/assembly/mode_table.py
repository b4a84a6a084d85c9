"""The modes of many inputs (points), one after the other, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from symkin.assembly.modes_result import Modes
from symkin.closure.closure import Closure
from symkin.closure.link_poses import link_poses
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem
from symkin.position.readings import points_at, readings
from symkin.position.solution_list import SolutionList

COMPLETENESS = (
    "not computed",
    "proved",
    "probability one",
    "incomplete",
    "sampled",
    "off the motion",
    "too many to list",
)
"""What the numbers of the array `completeness` mean: their place here."""


@dataclass(frozen=True, eq=False)
class ModeTable:
    """Of n points: `count` modes (-1: not counted), `completeness` codes, `unresolved` paths (-1:
    no paths), `continuum`: a set of solutions that are not isolated was met; `complex_count` (-1:
    not known). Of all m modes, in the order of points: positions (m, 3), quaternions (m, 4), joints
    (m, numbers) in the mechanism's units, named points (m, points, 3); residual, condition; limits:
    1 within, 0 not, -1 none; `certified` 1, 0, or -1 where it was not tried; radius; `values` (m,
    variables) of the closure.
    """

    count: np.ndarray
    completeness: np.ndarray
    unresolved: np.ndarray
    continuum: np.ndarray
    complex_count: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    joints: np.ndarray
    points: np.ndarray
    residual: np.ndarray
    condition: np.ndarray
    within_limits: np.ndarray
    certified: np.ndarray
    radius: np.ndarray
    values: np.ndarray

    def listed(self, closure: Closure) -> SolutionList:
        """All modes of all points, as solutions of their closure."""
        return SolutionList(
            closure,
            **{
                f.name: getattr(self, f.name) for f in fields(SolutionList) if hasattr(self, f.name)
            },
            notes=(),
        )


def stored_counts(counts: np.ndarray) -> np.ndarray:
    """Counts (n,) as tables hold them, whole numbers with -1 for what is not known."""
    return np.where(np.isnan(counts), -1, counts).astype(int)


PER_POINT = ("count", "completeness", "unresolved", "continuum", "complex_count")


def listed_joints(problem: Problem) -> tuple[Coordinate, ...]:
    """The joint coordinates that a table lists: all of the mechanism where the known ones are told
    by name, else those that the closure has.
    """
    if problem.by_name:
        return problem.mechanism.coordinates
    return tuple(c for c in problem.closure.coordinates if c.role != "pose")


def joint_labels(problem: Problem) -> list[tuple[str, str]]:
    """Names and units of the numbers in `joints`; a ball joint's are name.w, .x, .y, .z."""
    mechanism = problem.mechanism
    labels: list[tuple[str, str]] = []
    for c in listed_joints(problem):
        unit = mechanism.unit_of(c)
        labels += [(f"{c.name}.{k}", "1") for k in "wxyz"] if c.is_rotation else [(c.name, unit)]
    return labels


def joints_and_points(problem: Problem, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Joint coordinates (m, numbers) in the mechanism's units and named points (m, points, 3), of
    full vectors of variables (m, variables).
    """
    closure, mechanism = problem.closure, problem.mechanism
    joints = listed_joints(problem)
    cut = any(c.name not in closure.slices for c in joints)
    poses = link_poses(closure, values) if cut or mechanism.link_points else None
    read = readings(closure, poses) if cut and poses is not None else {}
    columns = [values[:, :0]]
    for c in joints:
        part = read[c.name] if c.name in read else values[:, closure.slices[c.name]]
        columns.append(part * mechanism.angle_out(1.0) if c.is_angular else part)
    points = list(points_at(mechanism, poses).values()) if poses is not None else []
    return np.concatenate(columns, axis=1), np.stack([np.zeros((len(values), 3)), *points], axis=1)[
        :, 1:
    ]


def table_of(problem: Problem, listed: SolutionList, **told: np.ndarray) -> ModeTable:
    """The table of solutions; `told` are the arrays of what is said of each point."""
    joints, points = joints_and_points(problem, listed.values)
    return ModeTable(
        **told,
        position=listed.position,
        quaternion=listed.quaternion,
        joints=joints,
        points=points,
        residual=listed.residual,
        condition=listed.condition,
        within_limits=listed.within_limits,
        certified=listed.certified,
        radius=listed.radius,
        values=listed.values,
    )


def from_modes(found: Modes, code: str | None = None) -> ModeTable:
    """One point, from its modes; `code` in place of their completeness."""
    problem = found.problem
    unresolved = -1 if found.unresolved_paths is None else found.unresolved_paths
    values = np.array([s.variables for s in found]).reshape(-1, problem.closure.reference.size)
    joints, points = joints_and_points(problem, values)
    return ModeTable(
        count=np.array([len(found)]),
        completeness=np.array([COMPLETENESS.index(code or found.completeness)]),
        unresolved=np.array([unresolved]),
        continuum=np.array([found.positive_dimensional]),
        complex_count=np.array([-1 if found.complex_count is None else found.complex_count]),
        position=np.array([s.position for s in found]).reshape(-1, 3),
        quaternion=np.array([s.quaternion for s in found]).reshape(-1, 4),
        joints=joints,
        points=points,
        residual=np.array([s.residual for s in found]),
        condition=np.array([s.condition for s in found]),
        within_limits=np.array([_flag(s.within_limits) for s in found], dtype=int),
        certified=np.array([_flag(s.certified) for s in found], dtype=int),
        radius=np.array([np.nan if s.radius is None else s.radius for s in found]),
        values=values,
    )


def nothing(problem: Problem, code: str, count: int) -> ModeTable:
    """One point without modes."""
    empty = np.zeros(0)
    flags = np.zeros(0, dtype=int)
    return ModeTable(
        count=np.array([count]),
        completeness=np.array([COMPLETENESS.index(code)]),
        unresolved=np.array([-1]),
        continuum=np.array([False]),
        complex_count=np.array([-1]),
        position=np.zeros((0, 3)),
        quaternion=np.zeros((0, 4)),
        joints=np.zeros((0, len(joint_labels(problem)))),
        points=np.zeros((0, len(problem.mechanism.link_points), 3)),
        residual=empty,
        condition=empty,
        within_limits=flags,
        certified=flags,
        radius=empty,
        values=np.zeros((0, problem.closure.reference.size)),
    )


def concatenated(tables: Sequence[ModeTable]) -> ModeTable:
    """The points of several tables, one after the other."""
    if len(tables) == 1:
        return tables[0]
    arrays = {
        name: np.concatenate([getattr(t, name) for t in tables])
        for name in ModeTable.__dataclass_fields__
    }
    return ModeTable(**arrays)


def at_places(table: ModeTable, places: np.ndarray) -> ModeTable:
    """Some of the points of a table, rising."""
    owner = np.repeat(np.arange(len(table.count)), np.maximum(table.count, 0))
    modes = np.isin(owner, places)
    return ModeTable(
        **{
            name: getattr(table, name)[places if name in PER_POINT else modes]
            for name in ModeTable.__dataclass_fields__
        }
    )


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


def _flag(value: bool | None) -> int:
    return -1 if value is None else int(value)
