"""Fit an arm by the lines of its joints and its tool, where its DH table cannot.

Common normals of nearly parallel axes lie anywhere: a table may hold hundreds of metres that
cancel, and axes that are parallel in the file cannot tilt out of a plane to first order. The lines
of the joints at zero joint values have neither fault. They are fitted first, and written as a table
afterwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from symkin.calibration.data.parameters import geometry_parameters, with_parameters
from symkin.calibration.estimate.problem import (
    CalibrationProblem,
    build_calibration,
    default_parameters,
)
from symkin.model.dh import reference_frames
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import wrapped

KEYS = ("theta", "d", "a", "alpha")
NEARLY_PARALLEL = 0.01
"""Axes whose twist from parallel is less than this (radians) are nearly parallel: readings hardly
determine their offsets.
"""
_PARALLEL = 1e-12
"""Sines below this are rounding: such axes have no common normal of their own."""


def dh_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Name the numbers of an arm's DH table, row after row; none for other mechanisms."""
    rows = () if mechanism.dh is None else mechanism.dh.rows
    return tuple(f"dh.{i}.{key}" for i in range(1, len(rows) + 1) for key in KEYS)


def parallel_axes(
    mechanism: Mechanism, values: Mapping[str, float], within: float
) -> Iterator[tuple[int, float]]:
    """Yield the numbers k of a DH table's axes that are parallel to the next within an angle, with
    the twist between; none of other mechanisms.
    """
    if mechanism.dh is None:
        return
    standard = mechanism.dh.convention == "standard"
    for k in range(1, len(mechanism.dh.rows)):
        twist = values[f"dh.{k if standard else k + 1}.alpha"]
        if abs(np.sin(twist)) <= within:
            yield k, twist


def has_nearly_parallel_axes(mechanism: Mechanism) -> bool:
    """Tell whether neighbouring axes of a DH table are parallel or nearly so."""
    nominal = geometry_parameters(mechanism)
    return any(parallel_axes(mechanism, nominal, NEARLY_PARALLEL))


def lines_problem(problem: CalibrationProblem) -> CalibrationProblem:
    """State the problem of an arm's lines and tool from one of its whole table, all else as there.
    The first line is the base frame's, and stays.
    """
    arm = replace(problem.mechanism, dh=None)
    names = default_parameters(arm, problem.measurements.observed)
    base = arm.key_path(*next(iter(arm.joints)))
    first = (f"{base}.point.", f"{base}.axis.")
    table = set(dh_names(problem.mechanism))
    chosen = [name for name in names if not name.startswith(first)]
    chosen += [name for name in problem.names if name not in table]
    return build_calibration(arm, problem.measurements, parameters=chosen, residual=problem.form)


def table_of_lines(
    problem: CalibrationProblem, lines: CalibrationProblem, p: np.ndarray
) -> np.ndarray:
    """Write the lines at parameters p as the parameters (P,) of the problem of the table, angles
    within half a turn of nominal.
    """
    values = dict(zip(lines.names, map(float, p), strict=True))
    values |= dh_of_lines(problem.mechanism, with_parameters(lines.mechanism, values))
    found, nominal = np.array([values[name] for name in problem.names]), problem.model.nominal
    angular = np.array([kind == "angle" for kind in problem.model.kinds])
    return np.where(angular, nominal + wrapped(found - nominal), found)


def dh_of_lines(mechanism: Mechanism, found: Mechanism) -> dict[str, float]:
    """Write the lines and the tool of an arm `found` as numbers of the table of `mechanism`, common
    normals on the side of the file's. What a table cannot write (parts of the first axis and of the
    tool frame) is left out.
    """
    assert mechanism.dh is not None  # noqa: S101 (arms alone are asked for)
    table, base = mechanism.dh, (np.zeros(3), np.array([0.0, 0.0, 1.0]))
    lines = [(np.array(j.point), np.array(j.axis)) for j in found.limbs[0].joints]
    modified = table.convention == "modified"
    usual = [*[0.0] * modified, *(row.theta for row in table.rows)]
    steps = _steps([base, *(lines if modified else lines[1:])], usual)
    if modified:
        # theta and d of a row follow the normal before it; the base frame has none of its own
        links = [(0.0, 0.0, *steps[0][2:]), *steps[1:]]
        rows = [
            (*after[:2], *before[2:]) for before, after in pairwise([*links, (0.0, 0.0, 0.0, 0.0)])
        ]
    else:
        rows = [*steps, (0.0, 0.0, 0.0, 0.0)]
    _, frame = reference_frames(table.convention, rows)
    rows[-1] = _last_row(frame.inverse() @ found.reference_pose, rows[-1], modified=modified)
    return dict(zip(dh_names(mechanism), np.ravel(rows).tolist(), strict=True))


_Line = tuple[np.ndarray, np.ndarray]
"""A point of a line and its direction."""
_Row = tuple[float, float, float, float]
"""theta, d, a, alpha."""


def _steps(lines: Sequence[_Line], usual: Sequence[float]) -> list[_Row]:
    """Steps from each line to the next: theta and d about and along it to their common normal, a
    and alpha along and about that. Normals are on the side of those at the `usual` thetas.
    """
    x, origin, made = np.array([1.0, 0.0, 0.0]), np.zeros(3), list[_Row]()
    for (p, z), (q, w), theta in zip(lines, lines[1:], usual, strict=False):
        side = np.cos(theta) * x + np.sin(theta) * np.cross(z, x)
        normal, reach = np.cross(z, w), (q - p) @ z
        if np.linalg.norm(normal) > _PARALLEL:
            reach = np.linalg.solve(np.column_stack([z, normal, -w]), q - p)[0]
        else:
            normal = q - p - reach * z
            normal = normal if np.linalg.norm(normal) > 0.0 else side
        normal = normal * np.copysign(1.0 / np.linalg.norm(normal), normal @ side)
        foot = p + reach * z
        turn = np.arctan2(np.cross(x, normal) @ z, x @ normal)
        alpha = np.arctan2(np.cross(z, w) @ normal, z @ w)
        d, a = (foot - origin) @ z, (q - foot) @ normal
        made.append((turn, d, a, alpha))
        x, origin = normal, foot + a * normal
    return made


def _last_row(tool: Pose, row: _Row, *, modified: bool) -> _Row:
    """The row that leads nearest to a tool frame, seen from the frame before it."""
    turn, (x, y, d) = tool.turn(np.eye(3)), tool.position
    theta = np.arctan2(turn[1, 0], turn[0, 0])
    if modified:
        return (theta, d, *row[2:])
    a = x * np.cos(theta) + y * np.sin(theta)
    return (theta, d, a, np.arctan2(turn[2, 1], turn[2, 2]))
