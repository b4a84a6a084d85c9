"""Checked solutions from values of all variables, held as arrays; each is made an object when it is
asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, overload

import numpy as np

from symkin.closure.closure import Closure
from symkin.numeric.linear_algebra import condition_of
from symkin.numeric.root_checks import NEARLY_SINGULAR, are_double
from symkin.numeric.tolerances import CLOSURE_TOLERANCE, SINGULAR_CONDITION
from symkin.position.determination import what_is_free
from symkin.position.groups import structure_groups
from symkin.position.problem import Problem
from symkin.position.readings import poses_of, within_limits, writing_of
from symkin.position.solution import (
    DOUBLE_NOTE,
    SIMPLE_NOTE,
    SINGULAR_NOTE,
    Solution,
    named_values,
)
from symkin.spatial.pose import Pose


@dataclass(frozen=True, eq=False, repr=False)
class SolutionList(Sequence[Solution]):
    """Solutions (m,) of one closure in their standard writing: `values` (m, variables), `position`
    (m, 3), `quaternion` (m, 4), `residual`, `condition`, `within_limits` and `certified` (1, 0, or
    -1 where there are no limits or nothing was tried), `radius` (m,), `ground` (m,) the partial
    proofs of those that are not certified, `double` (m,) which of them two or more meet in (1, 0,
    or -1 of points of a set), `hits` (m,) of random starts (-1: none were counted); `notes` are
    those of all.
    """

    closure: Closure
    values: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    residual: np.ndarray
    condition: np.ndarray
    within_limits: np.ndarray
    certified: np.ndarray
    radius: np.ndarray
    notes: tuple[str, ...]
    ground: np.ndarray | None
    double: np.ndarray | None
    hits: np.ndarray | None
    _made: dict[int, Solution] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.values)

    @overload
    def __getitem__(self, index: int) -> Solution: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Solution]: ...
    def __getitem__(self, index: int | slice) -> Solution | Sequence[Solution]:
        if isinstance(index, slice):
            return tuple(self[i] for i in range(*index.indices(len(self))))
        place = range(len(self))[index]
        if place not in self._made:
            self._made.setdefault(place, self._make(place))
        return self._made[place]

    @property
    def closed(self) -> np.ndarray:
        """Which of them (m,) close to rounding."""
        return self.residual <= CLOSURE_TOLERANCE * self.closure.characteristic_length

    def chosen(self, places: np.ndarray | Sequence[int] | slice, **told: Any) -> SolutionList:
        """Some of the solutions, in the order of their places (any,), a part of them, or where a
        mask (m,) holds; with what else is `told` of them. Arrays are cut when they are asked for.
        """
        found = object.__new__(SolutionList)
        vars(found).update(closure=self.closure, notes=self.notes, _made={}, _of=(self, places))
        vars(found).update(told)
        return found

    def __getattr__(self, name: str) -> Any:
        """An array of some solutions, cut at its first use."""
        if name.startswith("__") or "_of" not in vars(self):
            raise AttributeError(name)
        whole, places = vars(self)["_of"]
        array = getattr(whole, name)
        return vars(self).setdefault(name, None if array is None else array[places])

    @property
    def columns(self) -> dict[str, Any]:
        """All fields by their names."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    def __getstate__(self) -> dict[str, Any]:
        """What a copy holds: of a part nothing of other inputs."""
        return self.columns

    @staticmethod
    def joined(lists: Sequence[SolutionList]) -> SolutionList:
        """The solutions of several lists of one closure, one after the other, with what is said in
        all of these.
        """
        first = lists[0]
        if len(lists) == 1:
            return first
        arrays = {
            f.name: [getattr(one, f.name) for one in lists]
            for f in fields(first)
            if isinstance(getattr(first, f.name), np.ndarray | None)
        }
        told = {
            name: None if any(part is None for part in parts) else np.concatenate(parts)
            for name, parts in arrays.items()
        }
        return replace(first, **told, _made={})  # type: ignore[arg-type]

    def __repr__(self) -> str:
        return f"<{len(self)} solutions of {self.closure.mechanism.name}>"

    def _make(self, i: int) -> Solution:
        condition, certified = float(self.condition[i]), _flag(self.certified[i])
        return Solution(
            mechanism=self.closure.mechanism,
            values=named_values(self.closure, self.values[i]),
            pose=Pose(self.position[i], self.quaternion[i]),
            partition=self.closure.partition,
            residual=float(self.residual[i]),
            condition=condition,
            within_limits=_flag(self.within_limits[i]),
            certified=certified,
            radius=float(self.radius[i]) if certified else None,
            ground=None if self.ground is None else self.ground[i],
            hits=None if self.hits is None or self.hits[i] < 0 else int(self.hits[i]),
            notes=(*self.notes, *self._own_notes(i)),
        )

    def _own_notes(self, i: int) -> tuple[str, ...]:
        """What is said of one solution alone."""
        meet = 0 if self.double is None else self.double[i]
        if meet < 0:
            return ()
        # one exact solution alone is proved near a certified one, however weak its rows are
        is_simple = self.certified[i] == 1
        double = (DOUBLE_NOTE,) if meet and not is_simple else ()
        if self.condition[i] < SINGULAR_CONDITION:
            return double
        return (*double, SIMPLE_NOTE if is_simple else SINGULAR_NOTE)


def checked_solutions(
    problem: Problem,
    values: np.ndarray,
    notes: tuple[str, ...] = (),
    judged: np.ndarray | None = None,
) -> SolutionList:
    """Solutions from full vectors of variables (m, variables): in their standard writing, with
    closure errors and conditions, from the extreme singular values and errors (m, 3) of those that
    were `judged`, NaN of others.
    """
    closure, system = problem.closure, problem.system
    values = writing_of(closure).standard(values)
    inside, untried = within_limits(closure, values), np.full(len(values), -1)
    position, quaternion = poses_of(closure, values)
    judged = np.full((len(values), 3), np.nan) if judged is None else judged
    left = np.isnan(judged[:, 2])
    if left.any():
        own, judged = values[left], judged.copy()
        unknown, known = own[:, problem.unknown_places], own[:, problem.known_places]
        judged[left, :2], judged[left, 2] = system.extremes(unknown, known)
    extremes = judged[:, :2]
    return SolutionList(
        closure=closure,
        values=values,
        position=position,
        quaternion=quaternion,
        residual=judged[:, 2],
        condition=condition_of(extremes),
        within_limits=untried if inside is None else inside.astype(int),
        certified=untried,
        radius=np.full(len(values), np.nan),
        ground=None,
        double=_double(problem, values, extremes),
        hits=None,
        notes=notes,
    )


def _double(problem: Problem, values: np.ndarray, extremes: np.ndarray) -> np.ndarray:
    """Which solutions (m,) stand for two or more in some group: 1, or 0; -1 where unknowns are
    free, so that all are points of a set.
    """
    found = np.zeros(len(values), dtype=int)
    suspect = (extremes[:, 1] < NEARLY_SINGULAR).nonzero()[0]
    if suspect.size and what_is_free(problem) is not None:
        return found - 1
    near = values[suspect]
    for part in structure_groups(problem) if suspect.size else ():
        unknown, known = near[:, part.unknown_places], near[:, part.known_places]
        found[suspect] |= are_double(part.system, unknown, known)
    return found


def make_solution(problem: Problem, values: np.ndarray, *, notes: tuple[str, ...] = ()) -> Solution:
    """The solution from one full vector of variables."""
    return checked_solutions(problem, values[None], notes)[0]


def _flag(value: int) -> bool | None:
    return None if value < 0 else bool(value)
