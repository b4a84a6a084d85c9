"""Angles of the universal joints that distances have replaced (see
`closure.rows.ReplacedUniversalJoint`), at a real pose.

Turn(a, alpha) Turn(b, beta) v = w is the second subproblem of Paden and Kahan (Murray, Li, Sastry,
A Mathematical Introduction to Robotic Manipulation, 1994, section 3.2): c = Turn(b, beta) v has
a.c = a.w, b.c = b.v, |c| = |v|, which leaves two points, mirrored in the plane of a and b.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import casadi as ca
import numpy as np

from symkin.closure.closure import build_algebraic_closure
from symkin.computed_once import lru_cache
from symkin.homotopy.values import pose_point
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem

Values = dict[str, np.ndarray]
_DOUBLE = 1e-9
"""Share of |v|^2 below which the two points are one."""


@dataclass(frozen=True, eq=False)
class _Angles:
    """One replaced joint with its vectors as a function of (joints of the rows, pose); `joints` are
    the coordinates of the first.
    """

    coordinates: tuple[Coordinate, Coordinate]
    axis: np.ndarray
    axis2: np.ndarray
    vectors: ca.Function
    joints: tuple[Coordinate, ...]


@lru_cache(maxsize=128)
def replaced_universal_joints(problem: Problem) -> tuple[_Angles, ...]:
    """The universal joints that distances replace in a direct problem; none in others."""
    if problem.kind != "direct":
        return ()
    algebraic = build_algebraic_closure(problem.mechanism, "study")
    arguments = [algebraic.joints, algebraic.pose]
    return tuple(
        _Angles(
            d.coordinates,
            np.asarray(ca.DM(d.axis)).ravel(),
            np.asarray(ca.DM(d.axis2)).ravel(),
            ca.Function("vectors", arguments, [d.arm, d.target]),
            algebraic.coordinates,
        )
        for d in algebraic.replaced_universal_joints
    )


def with_universal_angles(problem: Problem, known: np.ndarray, values: Values) -> list[Values]:
    """The coordinates of a real root at given joints with every combination of the replaced joints'
    angles at its pose.
    """
    replaced = replaced_universal_joints(problem)
    if not replaced:
        return [values]
    given = dict(zip((c.name for c in problem.known_coordinates), known, strict=True))
    joints = np.array(
        [given[c.name] if c.name in given else values[c.name][0] for c in replaced[0].joints]
    )
    pose = pose_point(values, 1.0)
    choices: list[list[Values]] = []
    for joint in replaced:
        arm, target = (np.asarray(v).ravel() for v in joint.vectors(joints, pose))
        first, second = (c.name for c in joint.coordinates)
        found = two_angles(joint.axis, joint.axis2, arm, target)
        choices.append(
            [{first: np.array([alpha]), second: np.array([beta])} for alpha, beta in found]
        )
    return [
        {**values, **{k: v for part in choice for k, v in part.items()}}
        for choice in product(*choices)
    ]


def two_angles(
    a: np.ndarray, b: np.ndarray, v: np.ndarray, w: np.ndarray
) -> list[tuple[float, float]]:
    """Pairs (alpha, beta) with Turn(a, alpha) Turn(b, beta) v = w for unit axes that are not
    parallel, |v| = |w|.
    """
    normal = np.cross(a, b)
    square, cosine = float(normal @ normal), float(a @ b)
    along_a = (float(a @ w) - cosine * float(b @ v)) / square
    along_b = (float(b @ v) - cosine * float(a @ w)) / square
    foot = along_a * a + along_b * b
    left = float(v @ v) - float(foot @ foot)
    if left < -_DOUBLE * float(v @ v):
        return []
    height = np.sqrt(max(left, 0.0) / square)
    points = (
        [foot + height * normal, foot - height * normal]
        if height**2 * square > _DOUBLE * float(v @ v)
        else [foot]
    )
    return [(_angle(a, c, w), _angle(b, v, c)) for c in points]


def _angle(axis: np.ndarray, begin: np.ndarray, end: np.ndarray) -> float:
    """The turn about a unit axis that takes one vector to another."""
    return float(
        np.arctan2(axis @ np.cross(begin, end), begin @ end - (axis @ begin) * (axis @ end))
    )
