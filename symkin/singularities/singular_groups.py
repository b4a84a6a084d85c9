"""Name the structure groups of a problem that are singular at a configuration, and the loops that
they close.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.closure.branches import layout_of
from symkin.numeric.tolerances import SINGULAR_VALUE
from symkin.position.groups import structure_groups
from symkin.position.loops import loops_at
from symkin.position.problem import Problem
from symkin.result import json_fields
from symkin.velocity.limb_equations import row_basis


@dataclass(frozen=True)
class SingularGroup:
    """A structure group whose unknowns its rows do not decide at a configuration: its number from 0
    and its unknowns, as `modes` lists them in `blocks`, the loops that it closes, by their joints,
    and its smallest singular value (rows of unit length, angles times the size).
    """

    number: int
    unknowns: tuple[str, ...]
    loops: tuple[str, ...]
    singular_value: float

    def to_dict(self) -> dict[str, Any]:
        """The group in JSON."""
        return json_fields(self, "number", "unknowns", "loops", "singular_value")

    def __str__(self) -> str:
        of = f" of loop{'s' * (len(self.loops) > 1)} {'; '.join(self.loops)}" if self.loops else ""
        return f"block {self.number} ({', '.join(self.unknowns)}){of}"


def singular_groups(
    problem: Problem, values: np.ndarray, tolerance: float = SINGULAR_VALUE
) -> tuple[SingularGroup, ...]:
    """The groups that lose rank at a singular configuration, a full vector of variables: those of
    singular values below `tolerance`, at least the one of the smallest.
    """
    groups = structure_groups(problem)
    least = [_least_singular_value(group, values, tolerance) for group in groups]
    bound = max(tolerance, min(least, default=0.0))
    return tuple(
        SingularGroup(
            k, tuple(c.name for c in groups[k].system.unknowns), _loops_of(groups, k, values), value
        )
        for k, value in enumerate(least)
        if value <= bound
    )


def _least_singular_value(group: Problem, values: np.ndarray, tolerance: float) -> float:
    """The smallest singular value of a group's rows by its unknowns, the rows orthonormal over
    unknowns and knowns.
    """
    system, knowns = group.system, group.known_coordinates
    both = system.freed(knowns)
    point = np.concatenate([group.select_values(values, c) for c in (system.unknowns, knowns)])
    rows = row_basis(both.linearise_one(point, np.zeros(0))[1], tolerance)
    singular = np.linalg.svd(rows[:, : system.freedom], compute_uv=False)
    return float(singular[-1]) if len(rows) >= system.freedom else 0.0


def _loops_of(groups: tuple[Problem, ...], number: int, values: np.ndarray) -> tuple[str, ...]:
    """The loops that run through a branch that the group closes, and through none that groups close
    which read its values.
    """
    closure = groups[number].closure
    own = _edges(groups[number])
    later = {name for group in _readers(groups, number) for name in _edges(group)} - own
    loops = [loop for loop in loops_at(closure, values) if own & set(loop.joints)]
    return tuple(
        loop.name for loop in ([loop for loop in loops if not later & set(loop.joints)] or loops)
    )


def _readers(groups: tuple[Problem, ...], number: int) -> list[Problem]:
    """The groups that read a group's values, directly or not."""
    told = {c.name for c in groups[number].system.unknowns}
    found = []
    for group in groups[number + 1 :]:
        if told & {c.name for c in group.known_coordinates}:
            found.append(group)
            told |= {c.name for c in group.system.unknowns}
    return found


def _edges(group: Problem) -> set[str]:
    """Names of the joints and rods in the branches that a group closes."""
    closure = group.closure
    coupled = {name for c in closure.mechanism.couplings for name in (c.joint, *c.names)}
    layout = layout_of(
        closure.mechanism, closure.partition.kept | coupled, pose=closure.partition.pose
    )
    sources = {closure.row_sources[k].limb for k in group.row_places}
    return {
        element.name
        for branch in layout.branches
        if branch.name in sources
        for element in branch.elements
    }
