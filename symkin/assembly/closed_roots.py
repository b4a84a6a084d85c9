"""Real roots of an arm's inverse problem at many instances, by the formulas of its plan, with what is in doubt left to paths.

A plan decides joint by joint; where each of its equations is far from a double root and from leaving its joint undecided, its
branches are all solutions that there are. Every one is polished and checked on all rows as the ends of paths are.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.assembly.block_proofs import BlockProver, block_prover
from symkin.assembly.checked_roots import BlockRoots, Candidates, checked_roots, with_proofs
from symkin.closed.plan import Plan, forward, plan_of
from symkin.computed_once import cached_property, lru_cache
from symkin.homotopy.systems import system_of
from symkin.numeric.mapped import Mapped
from symkin.numeric.system import System
from symkin.position.problem import Problem

DOUBLE_ROOT = 1e-8
"""Discriminants and strengths (squares over the size's) within this of zero leave a doubt: two solutions are then nearer than 1e-4,
or nothing decides a joint."""


@dataclass(frozen=True, eq=False)
class ClosedBlock:
    """The only block of an arm's inverse problem, with its plan."""

    problem: Problem
    block: System
    plan: Plan
    method: str = "closed"

    @property
    def engine(self) -> str:
        """What finds the roots."""
        return "closed form"

    @property
    def most_roots(self) -> int:
        """Complex roots of a generic instance."""
        return self.plan.count

    @property
    def notes(self) -> tuple[str, ...]:
        return ()

    @cached_property
    def prover(self) -> BlockProver:
        return block_prover(self.problem, system_of(self.problem, self.block), self.block)

    @property
    def digest(self) -> bytes:
        """What the roots begin from."""
        return "\n".join(self.plan.derivation()).encode()

    @property
    def is_determined(self) -> bool:
        """Whether each real branch is a solution: a pose leaves arms of fewer joints conditions that only some branches meet."""
        return int(self.block.rows.shape[0]) <= self.block.freedom

    def roots(self, known: np.ndarray, *, certify: bool) -> BlockRoots:
        """Roots at instances known (n, values)."""
        points, discriminants, strengths = self._branches(known)
        real, doubtful = judged(discriminants, strengths)
        plain = np.asarray(~doubtful.any(axis=1))
        owner, branch = np.nonzero(real & plain[:, None])
        chosen = points[owner, branch]
        complex_count = self.plan.count
        if not self.is_determined:
            complex_count = NOT_KNOWN
            left = self.block.residuals(chosen, known[owner]) / self.block.characteristic_length
            plain[owner[(left > _SOLVES) & (left < _FAILS)]] = False
            chosen, owner = chosen[left <= _SOLVES], owner[left <= _SOLVES]
        candidates = Candidates(chosen, owner, np.full(len(owner), -1))
        found, kept = checked_roots(self.block, candidates, known, plain, np.full(len(known), complex_count))
        # a branch that solves all steps and fails the check leaves a doubt
        plain[np.bincount(owner, minlength=len(known)) != found.counts] = False
        return with_proofs(found, self.prover, None, known, kept) if certify and self._certifies else found

    @cached_property
    def _certifies(self) -> bool:
        """Whether roots can be certified: with more rows than joints, where those of a random configuration can."""
        if self.is_determined:
            return True
        pose = forward(self.plan.arm, np.random.default_rng(0).uniform(-1.0, 1.0, len(self.plan.arm)))
        known = np.concatenate([pose.position, pose.quaternion])[None]
        found = self.roots(known, certify=False)
        return bool(with_proofs(found, self.prover, None, known, np.full(len(found.owner), -1)).plain.all())

    def _branches(self, known: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of all branches the points (n, count, joints), the discriminants and the strengths (n, count, steps)."""
        values, marks = self._formulas(known)
        shape = (len(known), self.plan.count)
        marks = marks.reshape(*shape, 2, -1)
        return values.reshape(*shape, -1), marks[:, :, 0], marks[:, :, 1]

    @cached_property
    def _formulas(self) -> Mapped:
        """All branches' joints, then their discriminants and strengths, from the known values."""
        closure = self.problem.closure
        pose = closure.bound(ca.vertcat(closure.pose.position, closure.pose.quaternion))
        known = self.problem.system.known
        found = [self.plan.branch(pose, signs) for signs in self.plan.signs.tolist()]
        places = {screw.name: i for i, screw in enumerate(self.plan.arm.screws)}
        order = [places[c.name] for c in self.block.unknowns]
        joints = ca.vertcat(*(branch.joints[order] for branch in found))
        return Mapped.of([known], [joints, ca.vertcat(*(ca.vertcat(b.discriminants, b.strengths) for b in found))])


NOT_KNOWN = -1
"""Complex solutions of an arm of fewer than six joints: only real branches are held against the pose."""
_SOLVES, _FAILS = 1e-7, 1e-4
"""Closure errors, of the size, of branches that are solutions to rounding, and of branches that are none; between them is doubt."""


def judged(discriminants: np.ndarray, strengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which branches (n, count) are real, and which are in doubt, from the marks (n, count, steps) of their steps: behind a step
    without real solution others mean nothing."""
    with np.errstate(invalid="ignore"):
        regular = (discriminants > DOUBLE_ROOT) & (strengths > DOUBLE_ROOT)
        none = (discriminants < -DOUBLE_ROOT) & (strengths > DOUBLE_ROOT)
    before = np.cumprod(np.concatenate([np.ones_like(regular[:, :, :1]), regular[:, :, :-1]], axis=2), axis=2).astype(bool)
    return np.asarray(regular.all(axis=2)), np.asarray((before & ~regular & ~none).any(axis=2))


def closed_block(problem: Problem) -> ClosedBlock | None:
    """The block of a problem that a plan solves; None where there is no plan."""
    plan = plan_of(problem.mechanism) if problem.kind == "inverse" else None
    if plan is None or len(problem.blocks) != 1:
        return None
    (block,) = problem.blocks
    if {c.name for c in block.unknowns} != {screw.name for screw in plan.arm.screws}:
        return None
    return _closed_block(problem)


@lru_cache(maxsize=128)
def _closed_block(problem: Problem) -> ClosedBlock:
    plan = plan_of(problem.mechanism)
    assert plan is not None  # noqa: S101 - asked for where there is one
    return ClosedBlock(problem, problem.blocks[0], plan)
