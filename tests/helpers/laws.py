"""Shared checkers of laws, in plain NumPy matrices: nothing here uses symkin's formulas.

A displacement is a 4 x 4 matrix; angles are radians; coordinates are named as in a closure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce
from typing import Any

import casadi as ca
import numpy as np
import pytest

from helpers.inside import Closure
from symkin import Joint, Limb, Mechanism, MechanismError, RodLimb

CLOSED = 1e-9
"""A closed configuration's largest error, over the mechanism's size."""


# --- matrices -------------------------------------------------------------------------------------


def axis_turn(axis: Sequence[float], angle: float) -> np.ndarray:
    """Rodrigues: R = I + sin(t) K + (1 - cos(t)) K^2, K v = axis x v."""
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=float)
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * (k @ k)


def ball_turn(q: Sequence[float]) -> np.ndarray:
    """R v = (w^2 - u.u) v + 2 (u.v) u + 2 w u x v for the unit quaternion (w, u)."""
    w, u = q[0], np.asarray(q[1:], dtype=float)
    k = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    return (w * w - u @ u) * np.eye(3) + 2 * np.outer(u, u) + 2 * w * k


def displacement(
    rotation: np.ndarray, point: Sequence[float], shift: np.ndarray | float = 0.0
) -> np.ndarray:
    """x -> point + R (x - point) + shift."""
    g = np.eye(4)
    g[:3, :3] = rotation
    g[:3, 3] = np.asarray(point, dtype=float) - rotation @ np.asarray(point, dtype=float) + shift
    return g


def frame(position: Sequence[float], quaternion: Sequence[float]) -> np.ndarray:
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = ball_turn(quaternion), position
    return g


def act(g: np.ndarray, point: Sequence[float]) -> np.ndarray:
    return g[:3, :3] @ np.asarray(point, dtype=float) + g[:3, 3]


def joint_displacement(joint: Joint, values: Sequence[Any]) -> np.ndarray:
    """exp of a joint's screws, one value per coordinate (a quaternion for S)."""
    if joint.type == "S":
        return displacement(ball_turn(values[0]), joint.point)
    axis = np.array(joint.axis)
    match joint.type:
        case "R":
            return displacement(axis_turn(axis, values[0] - joint.zero), joint.point)
        case "P":
            return displacement(np.eye(3), joint.point, (values[0] - joint.zero) * axis)
        case "H":
            angle = values[0] - joint.zero
            return displacement(
                axis_turn(axis, angle), joint.point, joint.pitch * angle / (2 * math.pi) * axis
            )
        case "C":
            return displacement(axis_turn(axis, values[0]), joint.point, values[1] * axis)
        case _:
            first = displacement(axis_turn(axis, values[0]), joint.point)
            return first @ displacement(axis_turn(np.array(joint.axis2), values[1]), joint.point)


def chain(joints: Iterable[Joint], values: Mapping[str, Any]) -> np.ndarray:
    """Product of exponentials, base to platform."""
    steps = [joint_displacement(j, [values[c.name] for c in j.coordinates]) for j in joints]
    return reduce(np.matmul, steps, np.eye(4))


# --- does a configuration close? ------------------------------------------------------------------


def _point_gap(joint: Joint, g: np.ndarray) -> float:
    return float(np.linalg.norm(act(g, joint.point) - np.array(joint.point)))


def joint_gap(joint: Joint, g: np.ndarray) -> float:
    """How far (largest component; angular parts are pure numbers) the displacement g is from those
    of the joint.
    """
    if joint.type == "S":
        return _point_gap(joint, g)
    axis, turned = np.array(joint.axis), g[:3, :3] @ np.array(joint.axis)
    across = np.eye(3) - np.outer(axis, axis)
    match joint.type:
        case "R":
            return max(_point_gap(joint, g), float(np.linalg.norm(turned - axis)))
        case "P":
            return max(
                float(np.linalg.norm(across @ g[:3, 3])),
                float(np.linalg.norm(g[:3, :3] - np.eye(3))),
            )
        case "C":
            slide = across @ (act(g, joint.point) - np.array(joint.point))
            return max(float(np.linalg.norm(slide)), float(np.linalg.norm(turned - axis)))
        case "U":
            axis2 = np.array(joint.axis2)
            return max(_point_gap(joint, g), abs(float(axis @ g[:3, :3] @ axis2 - axis @ axis2)))
    raise AssertionError(f"joint {joint.name}: a joint of type {joint.type} is never cut")


def limb_gap(
    mechanism: Mechanism, limb: Limb | RodLimb, platform: np.ndarray, values: Mapping[str, Any]
) -> float:
    """Closure error of one limb, the platform frame at `platform`: the joint that `values` does not
    name is cut.
    """
    if isinstance(limb, RodLimb):
        length = float(np.linalg.norm(act(platform, limb.platform) - np.array(limb.base)))
        return abs(length - limb.offset - values[limb.name])
    moved = platform @ np.linalg.inv(
        frame(mechanism.platform_position, mechanism.platform_quaternion)
    )
    if limb.rods:
        last = chain(limb.joints, values)
        return max(
            abs(_rod_length(platform, last, rod) - _nominal_length(mechanism, rod))
            for rod in limb.rods
        )
    cut = [i for i, j in enumerate(limb.joints) if j.coordinates[0].name not in values]
    if not cut:
        return float(np.max(np.abs(chain(limb.joints, values) - moved)))
    first, last_cut = cut[0], cut[-1]
    before = chain(limb.joints[:first], values)
    after = chain(limb.joints[last_cut + 1 :], values)
    between = np.linalg.inv(before) @ moved @ np.linalg.inv(after)
    if len(cut) == 1:
        return joint_gap(limb.joints[first], between)
    a, b = limb.joints[first], limb.joints[last_cut]
    inner = act(chain(limb.joints[first + 1 : last_cut], values), b.point) - np.array(a.point)
    outer = act(between, b.point) - np.array(a.point)
    return abs(float(np.linalg.norm(inner) - np.linalg.norm(outer)))


def _rod_length(platform: np.ndarray, last: np.ndarray, rod: Any) -> float:
    return float(np.linalg.norm(act(platform, rod.platform) - act(last, rod.start)))


def _nominal_length(mechanism: Mechanism, rod: Any) -> float:
    if rod.length is not None:
        return float(rod.length)
    return _rod_length(
        frame(mechanism.platform_position, mechanism.platform_quaternion), np.eye(4), rod
    )


def closes(mechanism: Mechanism, solution: Any) -> bool:
    """Every limb reaches the solution's pose with the solution's joint values."""
    platform = frame(solution.position, solution.quaternion)
    gap = max(limb_gap(mechanism, limb, platform, solution.values) for limb in mechanism.limbs)
    return gap <= 1e-8 * max(1.0, mechanism.characteristic_length)


# --- equality of poses and of sets of modes -------------------------------------------------------


def same_pose(a: Any, b: Any, size: float = 1.0, tolerance: float = 1e-8) -> bool:
    """Equal positions (over the size) and rotations; the sign of a quaternion does not matter."""
    apart = (
        np.max(
            np.abs(np.asarray(a.position, float).ravel() - np.asarray(b.position, float).ravel())
        )
        / size
    )
    turn = np.max(np.abs(ball_turn(np.ravel(a.quaternion)) - ball_turn(np.ravel(b.quaternion))))
    return bool(max(apart, turn) <= tolerance)


def same_angle(a: float, b: float, tolerance: float = 1e-8) -> bool:
    """Equal modulo whole turns (radians)."""
    return abs(math.remainder(a - b, 2 * math.pi)) <= tolerance


def matched(
    found: Sequence[Any], expected: Sequence[Any], same: Callable[[Any, Any], bool]
) -> bool:
    """One to one: each expected thing is the same as exactly one found thing, and none is left."""
    counts = [[bool(same(f, e)) for f in found] for e in expected]
    rows = all(sum(row) == 1 for row in counts)
    return (
        rows
        and len(found) == len(expected)
        and all(sum(column) == 1 for column in zip(*counts, strict=True))
    )


def same_modes(a: Iterable[Any], b: Iterable[Any], size: float, tolerance: float = 1e-6) -> bool:
    """The same set of poses, one to one."""
    return matched(list(a), list(b), lambda x, y: same_pose(x, y, size, tolerance))


def configuration(solution: Any, size: float) -> np.ndarray:
    """Numbers that are equal for equal configurations: lengths over the size, cosine and sine of
    angles, rotation matrices.
    """
    parts = [solution.position / size, ball_turn(solution.quaternion).ravel()]
    kinds = {c.name: c for c in solution_coordinates(solution)}
    for name, value in solution.values.items():
        if kinds[name].kind == "quaternion":
            parts.append(ball_turn(value).ravel())
        elif kinds[name].kind == "angle":
            parts.append(np.array([math.cos(value), math.sin(value)]))
        else:
            parts.append(np.array([value / size if kinds[name].kind == "length" else value]))
    return np.concatenate(parts)


def all_distinct(solutions: Iterable[Any], size: float) -> bool:
    """No two solutions are the same pose with the same joint values (angles modulo turns,
    quaternions modulo sign).
    """
    rows = [configuration(s, size) for s in solutions]
    return all(np.max(np.abs(rows[i] - rows[j])) > 1e-6 for i in range(len(rows)) for j in range(i))


def solution_coordinates(solution: Any) -> Sequence[Any]:
    from helpers.inside import build_closure

    return build_closure(solution.mechanism).coordinates


# --- groups and derivatives -----------------------------------------------------------------------


def is_group(
    product: Callable[[Any, Any], Any],
    inverse: Callable[[Any], Any],
    one: Any,
    elements: Sequence[Any],
    same: Any,
) -> None:
    """Associativity, identity and inverses on three elements."""
    a, b, c = elements
    assert same(product(product(a, b), c), product(a, product(b, c)))
    assert same(product(one, a), a)
    assert same(product(a, one), a)
    assert same(product(a, inverse(a)), one)
    assert same(product(inverse(a), a), one)


def is_rotation(r: np.ndarray, tolerance: float = 1e-12) -> bool:
    """R^T R = 1 and det R = 1."""
    return bool(
        np.max(np.abs(r.T @ r - np.eye(3))) < tolerance and abs(np.linalg.det(r) - 1) < tolerance
    )


def evaluated(closure: Closure, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows and errors of a closure at a vector of its variables, over the size."""
    rows, errors = closure.bound(closure.rows), closure.bound(closure.errors)
    function = ca.Function("closure", [closure.variables], [rows, errors])
    return tuple(
        np.asarray(part).ravel() / closure.characteristic_length for part in function(values)
    )  # type: ignore[return-value]


def differences(f: Callable[[np.ndarray], np.ndarray], width: int, step: float) -> np.ndarray:
    """Central differences of f(d) at d = 0, one column per direction."""
    columns = []
    for k in range(width):
        d = np.zeros(width)
        d[k] = step
        columns.append((f(d) - f(-d)) / (2 * step))
    return np.array(columns).T


def refused_in_one_line(make, fragments):
    """Making raises MechanismError: one line that holds every fragment (offender, value, what is
    allowed).
    """
    with pytest.raises(MechanismError) as error:
        make()
    for fragment in fragments:
        assert fragment in str(error.value)
    assert "\n" not in str(error.value)


def assert_wrenches_do_no_work(found: Any) -> None:
    """Every wrench of a singularity is reciprocal to every feasible twist: s_t . s0_w + s0_t .
    s_w = 0.
    """
    for t in (twist.vector for twist in found.feasible_twists):
        for w in (wrench.vector for wrench in found.wrenches):
            assert abs(t[:3] @ w[3:] + t[3:] @ w[:3]) < 1e-9 * np.linalg.norm(t) * np.linalg.norm(w)
