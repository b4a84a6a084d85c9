"""The modes of many inputs (points), one after the other, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.assembly.group_roots import STATEMENTS, places_of
from symkin.assembly.modes_result import Modes
from symkin.closure.link_poses import link_poses
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem
from symkin.position.readings import points_at, readings
from symkin.position.solution_list import SolutionList

COMPLETENESS = (
    "not computed",
    *STATEMENTS,
    "off the motion",
    "too many to list",
)
"""What the numbers of the array `completeness` mean: their place here."""


PER_POINT = ("count", "completeness", "unresolved", "continuum", "complex_count")
"""The arrays that tell of points."""


@dataclass(frozen=True, eq=False)
class ModeTable:
    """Of n points: `count` modes (-1: not counted), `completeness` codes, `unresolved` paths (-1:
    no paths), `continuum`: a set of solutions that are not isolated was met; `complex_count` (-1:
    not known). `listed` are all m modes, in the order of points.
    """

    problem: Problem
    listed: SolutionList
    count: np.ndarray
    completeness: np.ndarray
    unresolved: np.ndarray
    continuum: np.ndarray
    complex_count: np.ndarray

    @cached_property
    def owner(self) -> np.ndarray:
        """The point (m,) of each mode."""
        return np.repeat(np.arange(len(self.count)), np.maximum(self.count, 0))

    @cached_property
    def joints_and_points(self) -> tuple[np.ndarray, np.ndarray]:
        """Of all modes joint coordinates (m, numbers) in the mechanism's units and named points (m,
        points, 3).
        """
        return joints_and_points(self.problem, self.listed.values)

    def at(self, places: np.ndarray) -> ModeTable:
        """Some of the points, in the order of their places."""
        if np.array_equal(places, np.arange(len(self.count))):
            return self
        rank = np.full(len(self.count), -1)
        rank[places] = np.arange(len(places))
        listed = self.listed.chosen(places_of(self.owner, rank))
        return replace(self, listed=listed, **{k: getattr(self, k)[places] for k in PER_POINT})

    @staticmethod
    def joined(tables: Sequence[ModeTable]) -> ModeTable:
        """The points of several tables, one after the other."""
        if len(tables) == 1:
            return tables[0]
        listed = SolutionList.joined([table.listed for table in tables])
        told = {
            name: np.concatenate([getattr(table, name) for table in tables]) for name in PER_POINT
        }
        return ModeTable(tables[0].problem, listed, **told)

    @staticmethod
    def of(found: Modes, why: str = "", count: int | None = None) -> ModeTable:
        """One point, from its modes, or `why` in `COMPLETENESS` none are listed of its `count`."""
        unresolved, complex_count = found.unresolved_paths, found.complex_count
        return ModeTable(
            found.problem,
            found.modes,
            count=np.array([len(found) if count is None else count]),
            completeness=np.array([COMPLETENESS.index(why or found.completeness)]),
            unresolved=np.array([-1 if unresolved is None else unresolved]),
            continuum=np.array([found.positive_dimensional]),
            complex_count=np.array([-1 if complex_count is None else complex_count]),
        )


def stored_counts(counts: np.ndarray) -> np.ndarray:
    """Counts (n,) as tables hold them, whole numbers with -1 for what is not known."""
    return np.where(np.isnan(counts), -1, counts).astype(int)


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
