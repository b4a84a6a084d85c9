"""The inverse problem of an arm by its closed form: the branch nearest to a start."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closed.evaluation import Evaluation
from symkin.closed.plan import Plan, plan_of
from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.position.problem import Problem
from symkin.spatial.rotation import wrapped


@dataclass(frozen=True)
class ClosedForm:
    """The steps of an arm's plan, at each choice the solution nearest to the start's joint; its
    angles are near the start's.
    """

    @property
    def name(self) -> str:
        return "closed"

    def iterate(self, problem: Problem, start: np.ndarray, known: np.ndarray) -> list[np.ndarray]:
        """The start and the answer. Raises InputError where the problem has no closed form."""
        formula = _nearest_branch(problem)
        if formula is None:
            raise InputError(
                f"solver = 'closed': the {problem.kind} problem of {problem.mechanism.name} has no "
                f"closed form; allowed: newton, "
                "fast_newton, ipopt"
            )
        end = np.asarray(formula(known, start)).ravel()
        angular = np.array([c.is_angular for c in problem.system.unknowns])
        return [start, np.where(angular, start + wrapped(end - start), end)]


@lru_cache(maxsize=128)
def _nearest_branch(problem: Problem) -> ca.Function | None:
    """Joint values from known values and a start, in the order of the unknowns; None without a
    closed form.
    """
    plan = plan_of(problem.mechanism) if problem.of_pose else None
    if plan is None:
        return None
    places = {c.name: i for i, c in enumerate(problem.system.unknowns)}
    order = [places[screw.name] for screw in plan.arm.screws]
    closure, start = problem.closure, ca.SX.sym("start", len(order))
    pose = closure.bound(ca.vertcat(closure.pose.position, closure.pose.quaternion))
    joints = _nearest(plan, pose, start[order])
    return ca.Function(
        "nearest",
        [problem.system.known, start],
        [joints[np.argsort(order).tolist()]],
        {"cse": True},
    )


def _nearest(plan: Plan, pose: ca.SX, start: ca.SX) -> ca.SX:
    """Joint values (n,) at a tool pose, in the order of the plan's screws."""
    at, zeros = Evaluation(plan.arm, pose[:3], pose[3:]), [screw.zero for screw in plan.arm.screws]
    for step in plan.steps:
        sign: ca.SX | float = 1.0
        if step.branch is not None:
            value = start[step.joints[0]] - zeros[step.joints[0]]
            slides = plan.arm.screws[step.joints[0]].slides
            lean = at.lean(step, value if slides else ca.cos(value), ca.sin(value))
            sign = ca.if_else(lean < 0, -1.0, 1.0)
        at = at.decided(step.joints, at.decide(step, sign).motions)
    return ca.vertcat(*(at.motions[i].value + zero for i, zero in enumerate(zeros)))
