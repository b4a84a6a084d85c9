"""The same measurements without error, nearest to those taken.

What a group's readings cannot tell shows in the null space of their Jacobian only where the group's inclinations agree: a
turn of the platform frame by w moves each deviation r from the group's mean by w x r, which no rank should count.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.calibration.direct import CLOSED
from symkin.calibration.problem import CalibrationProblem

_STEPS = 6
"""Gauss-Newton steps; deviations are small, so that three or four meet the tolerance."""


def ideal(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> tuple[CalibrationProblem, np.ndarray]:
    """The problem with joint readings moved least (with the unknown coordinates, angles times the size) so that at p the
    postures close and every group has one inclination; and the unknown coordinates there."""
    readings, model = problem.readings, problem.model
    if not readings.groups:
        return problem, z
    joints, size = problem.measurements.joints, model.closure.size
    columns, inside = readings.columns, readings.inside
    first, apart = readings.first[readings.group[inside]], readings.group < 0
    units = np.array([1.0 / size if c.is_angular else 1.0 for c in model.closure.role("actuated")])
    for _ in range(_STEPS):
        rows, rows_z, rows_q, h, h_z = model.tangent(z, joints, p)
        gap, grouped = np.zeros((len(z), 2)), size * h_z[:, columns]
        gap[inside] = h[inside][:, columns] - h[first][:, columns]
        gap, grouped[apart] = size * (np.remainder(gap + np.pi, 2 * np.pi) - np.pi), 0.0
        if max(np.max(np.abs(gap)), np.max(np.abs(rows), initial=0.0)) < CLOSED * size:
            break
        free = rows_z.shape[2]
        matrix = np.zeros((len(z), rows.shape[1] + 2, free + len(units)))
        matrix[:, :-2, :free], matrix[:, :-2, free:], matrix[:, -2:, :free] = rows_z, rows_q * units, grouped
        step = _least_steps(matrix, -np.concatenate([rows, gap], axis=1))
        z, joints = model.system.move(z, step[:, :free]), joints + units * step[:, free:]
    return replace(problem, measurements=replace(problem.measurements, joints=joints)), z


def _least_steps(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Shortest solutions of n underdetermined systems: A^T (A A^T)^-1 b."""
    transposed = matrix.transpose(0, 2, 1)
    try:
        return np.asarray(transposed @ np.linalg.solve(matrix @ transposed, right[:, :, None]))[:, :, 0]
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.pinv(matrix, rcond=1e-10) @ right[:, :, None])[:, :, 0]
