"""What is proved at the ends of steps where rows are redundant: a root of independent rows, and a bound of the others there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.caching import lru_cache
from symkin.certificate.balls import UP, precision, upper
from symkin.certificate.independent_rows import most_independent
from symkin.following.ball_matrices import balls
from symkin.following.path_system import PathSystem
from symkin.following.step_certificate import BITS, Interval


def left_on_others(interval: Interval, y: np.ndarray) -> float:
    """An upper bound (length unit) of every row at the one exact root near y, at its u, of as many independent rows as
    unknowns; infinite where no such root is proved."""
    system = interval.system
    jacobian = interval.evaluate(y)[1]
    chosen = most_independent(jacobian[:, :-1], system.width)
    if len(chosen) < system.width:
        return float("inf")
    along = np.append(np.zeros(system.width), 1.0)
    half = Interval(_part(system, chosen), interval.c).point(y, along, jacobian[list(chosen)])
    if half is None:
        return float("inf")
    with precision(BITS):
        values = interval.series(0, balls(y, half))
        others = [upper(v) for i, v in enumerate(values) if i not in chosen]
    return max(others, default=0.0) * system.problem.closure.size * UP


@lru_cache(maxsize=128)
def _part(system: PathSystem, chosen: tuple[int, ...]) -> PathSystem:
    return replace(system, rows=system.rows[list(chosen), 0])
