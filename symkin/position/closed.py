"""The inverse problem of an arm by its closed form: the branch nearest to a start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.errors import InputError
from symkin.model.joint import units_of
from symkin.position.arm_formulas import arm_formulas
from symkin.position.problem import Problem
from symkin.spatial.rotation import wrapped


@dataclass(frozen=True)
class ClosedForm:
    """Of all branches of an arm's formulas the one nearest to the start: least sum of squares of
    angles, without whole turns, and of lengths over the size.
    """

    @property
    def name(self) -> str:
        return "closed"

    def iterate(self, problem: Problem, start: np.ndarray, known: np.ndarray) -> list[np.ndarray]:
        """The start and the answer, its angles near the start's. Raises InputError where the
        problem has no closed form.
        """
        arm = arm_formulas(problem)
        if arm is None:
            raise InputError(
                f"solver = 'closed': the {problem.name} problem of {problem.mechanism.name} has no "
                f"closed form; allowed: newton, "
                "fast_newton, ipopt"
            )
        unknowns, size = problem.system.unknowns, problem.closure.characteristic_length
        away = arm.solutions(known[None]).values[0] - start
        away = np.where([c.is_angular for c in unknowns], wrapped(away), away)
        far = np.linalg.norm(away / np.array(units_of(unknowns, size)), axis=1)
        return [start, start + away[int(np.argmin(np.where(np.isfinite(far), far, np.inf)))]]
