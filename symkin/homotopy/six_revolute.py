"""Arms of six revolute joints: one algebraic system for all of them, and the start of each.

Frames stand on the axes, z along them. Joint i turns by q_i about z, and the link behind it moves
the frame by Trans(t) Rx(a) Ry(b), which has no large numbers where axes are parallel or nearly so.
The loop is cut at the third joint, as `closure.rows` cuts it. With links and tool pose complex and
random there are 16 roots, the most that any such arm has (Lee and Liang 1988); they are tracked to
any arm. Of special arms some run to infinity: 8 where three axes are parallel.
"""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np

from symkin.closure.pose_forms import HomogeneousPose
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem, complex_normal
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.universal_start import compute_start, followed, read_start
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, quaternion_from_axis_angle, rotate

JOINTS = 6
CUT = 2
"""Place of the joint at which the loop is cut."""
BOUND = 16
DATA = Path(__file__).resolve().parent / "data" / "six_revolute.npz"
_LINK = 5
"""Numbers of a link: t, a, b."""
_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def is_six_revolute(problem: Problem) -> bool:
    """Whether a problem is the inverse one of an arm of six revolute joints."""
    joints = [joint for _, joint in problem.mechanism.joints]
    is_arm = problem.of_pose and problem.mechanism.serial
    return is_arm and len(joints) == JOINTS and all(joint.type == "R" for joint in joints)


@lru_cache(maxsize=1)
def universal_arm() -> AlgebraicSystem:
    """Rows over z = (q1, q2, q4, q5, q6) and k = (the five links; position and quaternion of the
    frame behind the last joint in that of the first), all lengths in one unit.
    """
    names = [i for i in range(JOINTS) if i != CUT]
    z, k = ca.SX.sym("q", len(names)), ca.SX.sym("k", _LINK * (JOINTS - 1) + 7)
    turn = {
        i: Pose(ca.SX.zeros(3), quaternion_from_axis_angle(_Z, z[place]))
        for place, i in enumerate(names)
    }
    link = [_link(k[_LINK * i : _LINK * (i + 1)]) for i in range(JOINTS - 1)]
    before, behind = turn[0] @ link[0], link[CUT]
    for i in range(1, CUT):
        before = before @ turn[i] @ link[i]
    for i in range(CUT + 1, JOINTS):
        behind = behind @ turn[i] @ (link[i] if i < JOINTS - 1 else Pose.identity())
    hand, back = HomogeneousPose(k[-7:-4], k[-4:]), behind.inverse()
    gap = hand.point(ca.SX(back.position)) - hand.weight * before.position
    e = multiply(conjugate(before.quaternion), multiply(k[-4:], back.quaternion))
    rows = ca.vertcat(gap, 2 * e[1], 2 * e[2])
    unknowns = tuple(Coordinate(f"q{i + 1}", "angle", "passive") for i in names)
    last = k.shape[0]
    return AlgebraicSystem(1.0, unknowns, z, k, rows, (), known_ray=tuple(range(last - 4, last)))


def _link(numbers: ca.SX) -> Pose:
    about_x, about_y = (
        quaternion_from_axis_angle(_X, numbers[3]),
        quaternion_from_axis_angle(_Y, numbers[4]),
    )
    return Pose(numbers[:3], multiply(about_x, about_y))


@lru_cache(maxsize=1)
def universal_start() -> Fibre:
    """16 roots of a random complex arm and pose; carried as data, `compute_universal_start` makes
    them.
    """
    return read_start(DATA)


def compute_universal_start(seed: int = 0) -> Fibre:
    """Monodromy in links and pose until the bound of 16 is reached."""
    system = universal_arm()
    return compute_start(system, lambda rng: complex_normal(system.width, rng), BOUND, seed)


def arm_start(problem: Problem, pose: np.ndarray) -> tuple[np.ndarray, int]:
    """Roots (5, n) of an arm at a complex tool pose (x, y, z, qw, qx, qy, qz; length unit), as its
    own angles, and how many of the 16 paths are unresolved.
    """
    target = arm_data(problem, pose)
    ends = followed(universal_arm(), universal_start(), target, smallest_step=1e-12)
    zeros = np.array([joint.zero for _, joint in problem.mechanism.joints])
    angles = ends.z + np.delete(zeros, CUT)[:, None]
    return angles, len(ends.unresolved) + int(ends.singular.multiplicity.sum())


def arm_data(problem: Problem, pose: np.ndarray) -> np.ndarray:
    """k of the universal system for an arm and a tool pose."""
    mechanism, size = problem.mechanism, problem.closure.characteristic_length
    axes = [np.array(joint.axis) for _, joint in mechanism.joints]
    points = [mechanism.places[joint.name] / size for _, joint in mechanism.joints]
    frames, links = [Pose(points[0], _quaternion_to(axes[0]))], []
    for point, axis in zip(points[1:], axes[1:], strict=True):
        link = _link_between(frames[-1], point, axis)
        links.append(link)
        frames.append(frames[-1] @ Pose(link[:3], _turn(*link[3:])))
    reference = Pose(
        np.array(mechanism.platform_position) / size, np.array(mechanism.platform_quaternion)
    )
    first, last = frames[0].inverse(), reference.inverse() @ frames[-1]
    position, q = pose[:3] / size, pose[3:]
    at = position + _rotated(q, np.asarray(last.position))
    hand = np.concatenate(
        [
            rotate(first.quaternion, at) + first.position,
            multiply(multiply(first.quaternion, q), last.quaternion),
        ]
    )
    return np.concatenate([*links, hand])


def _rotated(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """R v for a quaternion of any length."""
    turned = multiply(multiply(q, np.array([0.0, *v])), conjugate(q))
    return turned[1:] / np.sum(q * q)


def _turn(a: float, b: float) -> np.ndarray:
    return multiply(quaternion_from_axis_angle(_X, a), quaternion_from_axis_angle(_Y, b))


def _link_between(frame: Pose, point: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """t, a, b from a frame to the axis (unit) through a point: Rx(a) Ry(b) z = (sin b, -sin a cos
    b, cos a cos b).
    """
    local = frame.inverse()
    x, y, z = rotate(local.quaternion, axis)
    return np.array([*local.apply(point), np.arctan2(-y, z), np.arcsin(np.clip(x, -1.0, 1.0))])


def _quaternion_to(axis: np.ndarray) -> np.ndarray:
    x, y, z = axis
    return _turn(float(np.arctan2(-y, z)), float(np.arcsin(np.clip(x, -1.0, 1.0))))


def write_universal_start() -> None:
    """Compute the universal start into the package: `python -m symkin.homotopy.six_revolute`."""
    found = compute_universal_start()
    np.savez(DATA, z=found.z, k=found.k)


if __name__ == "__main__":
    write_universal_start()
