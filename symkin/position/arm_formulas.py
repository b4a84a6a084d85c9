"""The plan of a serial arm as formulas of its inverse problem's block."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closed.plan import Plan, forward, plan_of
from symkin.computed_once import cached_property, lru_cache
from symkin.elimination.closed_form import Solutions
from symkin.numeric.mapped import Mapped
from symkin.position.problem import Problem

DOUBLE_ROOT = 1e-8
"""Discriminants and strengths (squares over the size's) within this of zero leave a doubt: two
solutions are then nearer than 1e-4, or nothing decides a joint.
"""


@dataclass(frozen=True, eq=False)
class ArmFormulas:
    """An arm's inverse problem, with its plan: joint by joint."""

    problem: Problem
    plan: Plan

    @property
    def count(self) -> int:
        """Branches, complex solutions included."""
        return self.plan.count

    @property
    def steps(self) -> tuple[str, ...]:
        return tuple(self.plan.derivation())

    def random_known(self) -> np.ndarray:
        """A tool pose that some joints have."""
        pose = forward(
            self.plan.arm, np.random.default_rng(0).uniform(-1.0, 1.0, len(self.plan.arm))
        )
        return np.concatenate([pose.position, pose.quaternion])

    def solutions(self, known: np.ndarray) -> Solutions:
        """Of all branches the points (n, count, joints), and which are real; which instances leave
        no doubt.
        """
        values, marks = self._formulas(known)
        shape = (len(known), self.plan.count)
        marks = marks.reshape(*shape, 2, -1)
        real, doubtful = judged(marks[:, :, 0], marks[:, :, 1])
        return Solutions(values.reshape(*shape, -1), real, ~np.any(doubtful, axis=1))

    @cached_property
    def _formulas(self) -> Mapped:
        """All branches' joints, then their discriminants and strengths, from the known values."""
        closure = self.problem.closure
        pose = closure.bound(ca.vertcat(closure.pose.position, closure.pose.quaternion))
        known = self.problem.system.known
        found = [self.plan.branch(pose, signs) for signs in self.plan.signs.tolist()]
        places = {screw.name: i for i, screw in enumerate(self.plan.arm.screws)}
        order = [places[c.name] for c in self.problem.system.unknowns]
        joints = ca.vertcat(*(branch.joints[order] for branch in found))
        return Mapped.of(
            [known],
            [joints, ca.vertcat(*(ca.vertcat(b.discriminants, b.strengths) for b in found))],
        )


@lru_cache(maxsize=128)
def arm_formulas(problem: Problem) -> ArmFormulas | None:
    """The formulas of an arm's inverse problem; None of any other problem, and where the axes do
    not allow any.
    """
    if not problem.of_pose:
        return None
    plan = plan_of(problem.mechanism)
    if plan is None or {c.name for c in problem.system.unknowns} != {
        screw.name for screw in plan.arm.screws
    }:
        return None
    return ArmFormulas(problem, plan)


def judged(discriminants: np.ndarray, strengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which branches (n, count) are real, and which are in doubt, from the marks (n, count, steps)
    of their steps: behind a step without real solution others mean nothing.
    """
    with np.errstate(invalid="ignore"):
        regular = (discriminants > DOUBLE_ROOT) & (strengths > DOUBLE_ROOT)
        none = (discriminants < -DOUBLE_ROOT) & (strengths > DOUBLE_ROOT)
    before = np.cumprod(
        np.concatenate([np.ones_like(regular[:, :, :1]), regular[:, :, :-1]], axis=2), axis=2
    ).astype(bool)
    return np.all(regular, axis=2), np.any(before & ~regular & ~none, axis=2)
