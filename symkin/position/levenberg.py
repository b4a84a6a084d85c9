"""One solution by Levenberg and Marquardt's damped steps on all rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.levenberg import patiently
from symkin.position.problem import Problem


@dataclass(frozen=True)
class Levenberg:
    """Damped steps, which need no regular start: where fewer coordinates are given than the
    mobility they are the shortest ones, so that the end is near the start; where redundant rows are
    written with few digits, the end is that of least squares.
    """

    @property
    def name(self) -> str:
        return "levenberg"

    def iterate(self, problem: Problem, start: np.ndarray, known: np.ndarray) -> list[np.ndarray]:
        """The iterates, the start first."""
        trace: list[np.ndarray] = []
        patiently(problem.system, start[None], known, trace)
        return [start, *(points[0] for points in trace)]
