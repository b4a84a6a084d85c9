"""Real roots of one group at many instances, by formulas, with what is in doubt left to paths.

Formulas are used where they account for all solutions: generically every branch, complex ones
included, closes on all rows, and they are as many as paths find or, where there are none, all that
random complex starts end at. Where each equation of the formulas is far from a double root and from
leaving its unknown undecided, and each real branch closes on all rows to rounding, their branches
are then all solutions that there are; every other input is left to paths.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from symkin.assembly.complex_branches import complex_errors
from symkin.assembly.group_roots import GroupRoots, checked_roots
from symkin.assembly.rod_lengths import rod_lengths
from symkin.computed_once import cached_property, lru_cache
from symkin.elimination.closed_form import ClosedForm, Solutions, closed_form, samples_about
from symkin.homotopy.values import coordinate_scale
from symkin.position.arm_formulas import arm_formulas
from symkin.position.closed_configurations import closed_configurations
from symkin.position.groups import is_linear, is_tied
from symkin.position.problem import Problem
from symkin.position.roots import NOT_KNOWN

_SOLVES, _FAILS = 1e-7, 1e-4
"""Closure errors, of the size, of branches that are solutions to rounding, with some digits lost,
and of branches that are none.
"""
_SPREAD = 0.3
"""How far generic known values lie from the regular ones at which formulas are compared with paths:
in radians, and in sizes.
"""
_MOST_IMPLIED = 3
"""Unknowns of a block with implied rows, at most: the squares of its joints' chains have as many
terms as three to a power.
"""
_INSTANCES = 2
"""Generic known values at which all branches must close."""


class Formulas(Protocol):
    """Formulas of all unknowns of a block; `count` solutions over the complex numbers, `steps` the
    derivation.
    """

    @property
    def count(self) -> int: ...
    @property
    def steps(self) -> tuple[str, ...]: ...
    def solutions(self, known: np.ndarray) -> Solutions:
        """All values for known values (n, known)."""


@dataclass(frozen=True, eq=False)
class ClosedBlock:
    """A group with its formulas; `regular` are known values (known,) of a regular configuration."""

    problem: Problem
    formulas: Formulas
    regular: np.ndarray

    @property
    def engine(self) -> str:
        """What finds the roots."""
        return "closed form"

    @property
    def most_roots(self) -> int:
        """Complex roots of a generic instance."""
        return self.formulas.count

    @property
    def digest(self) -> bytes:
        """What the roots begin from."""
        return "\n".join(self.formulas.steps).encode()

    @cached_property
    def is_determined(self) -> bool:
        """Whether each real branch is a solution. Arms of fewer than six joints have branches that
        some of their poses' conditions refuse, and that are none then; formulas that elimination
        has found have none of these (`group_solvers.accounts_for_all`).
        """
        rows = self.problem.system.rows.shape[0]
        if rows <= self.problem.system.freedom or isinstance(self.formulas, ClosedForm):
            return True
        found = self.formulas.solutions(self.regular[None])
        errors = self.problem.system.residuals(found.values[0][found.real[0]], self.regular)
        return bool(
            found.clear[0] and np.all(errors <= _SOLVES * self.problem.system.characteristic_length)
        )

    @property
    def generic_known(self) -> np.ndarray:
        """Random known values (instances, known), quaternions of unit length."""
        scale = coordinate_scale(self.problem, self.problem.known_coordinates)
        away = np.random.default_rng(5).uniform(-_SPREAD, _SPREAD, (_INSTANCES, len(scale)))
        given = self.problem.system.exchanged(self.problem.known_coordinates)
        return given.move(self.regular + scale * away, np.zeros((_INSTANCES, given.freedom)))

    def roots(self, known: np.ndarray, *, judges: bool = False) -> tuple[GroupRoots, np.ndarray]:
        """As `BlockPaths.roots`."""
        points, real, plain = self.formulas.solutions(known)
        owner, branch = np.nonzero(real & plain[:, None])
        chosen, plain = points[owner, branch], plain.copy()
        judged: tuple[np.ndarray, ...] = self.problem.system.judge(chosen, known[owner])
        errors = judged[-1] / self.problem.system.characteristic_length
        fails = np.zeros(len(errors), dtype=bool) if self.is_determined else errors >= _FAILS
        plain[owner[~fails & ~(errors <= _SOLVES)]] = False
        kept = plain[owner] & ~fails
        if not kept.all():
            chosen, owner = chosen[kept], owner[kept]
            judged = tuple(part[kept] for part in judged)
        count = self._complex_counts(known, real)
        chosen, closed, found = checked_roots(
            self.problem.system, chosen, owner, known, plain, judged, judges=judges
        )
        # a branch that solves all steps and fails the check leaves a doubt
        n, left = len(known), owner[closed]
        plain[np.bincount(owner, minlength=n) != np.bincount(left, minlength=n)] = False
        roots = GroupRoots.of_all(chosen, left, count, engine=self.engine, judged=found)
        return roots, (~plain).nonzero()[0]

    def _complex_counts(self, known: np.ndarray, real: np.ndarray) -> np.ndarray:
        """Complex solutions (n,) of known values (n, known), of which branches are `real` (n,
        count). Those of an arm that its pose's conditions may refuse are not known.
        """
        if not self.is_determined:
            return np.full(len(known), NOT_KNOWN)
        counts = np.full(len(known), float(self.formulas.count))
        if isinstance(self.formulas, ClosedForm) and is_tied(self.problem):
            rows = np.flatnonzero(~real.all(axis=1))
            if rows.size:
                counts[rows] = closing(self.problem, self.formulas, known[rows]).sum(axis=1)
        return counts


def closing(problem: Problem, formulas: ClosedForm, known: np.ndarray) -> np.ndarray:
    """Which branches (n, count) close for known values (n, known), over the complex numbers."""
    try:
        return complex_errors(problem, formulas, known) <= _SOLVES
    except NotImplementedError:
        return np.zeros((len(known), formulas.count), dtype=bool)


@lru_cache(maxsize=256)
def closed_block(problem: Problem) -> ClosedBlock | None:
    """A group with the formulas that solve it; None where there are none."""
    system, arm = problem.system, arm_formulas(problem)
    if arm is not None:
        return ClosedBlock(problem, arm, arm.random_known())
    if problem.is_explicit or is_linear(problem):
        return None
    if problem.implied and len(problem.system.unknowns) > _MOST_IMPLIED:
        return None
    near = problem.reference_known
    rods = rod_lengths(system)
    if rods is not None:
        return ClosedBlock(problem, rods, near)
    samples = samples_about(system, near, problem.known_coordinates)
    found = closed_form(system, samples, all_rows=True)
    if found is None:
        return None
    if found.has_conditions:
        # rows that divisors of the formulas take out may be nothing at the reference
        generic = closed_configurations(problem.closure, 0)[0]
        near = problem.select_values(generic, problem.known_coordinates)
    return ClosedBlock(problem, found, near)
