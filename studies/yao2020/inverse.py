"""Inverse problem of the telescopic Pieper robot: the paper's search (4) to (8), the return of the
axes (9) to (12), all roots.

As written: joint 6 undone by l moves A0, D0, E0, F0 to A1, D1, E1, F1 against the direction A0 D0.
Plane I holds A1, D1, E1, plane II holds O, D1, E1, with normal n = OE1 x OD1. The angle of AD with
n gives sin(theta5); F1 turned back about E1 D1 is F2,

    f(l) = |OF2| - a1,   a root l is L6.

The shorter way: with u, v, w the columns of R, e = R^T E0, and h the distance of O from axis 5,

    theta5 = atan2(s e_y, -s (e_x - L6)),
    |OF2|^2 = (h - s a2)^2 + e_z^2,   h^2 = (e_x - L6)^2 + e_y^2,

s = 1 where F lies between axis 5 and O, -1 where it lies beyond. So f falls until L6 = e_x and
rises after it where h > s a2; its roots are L6 = e_x +- sqrt(h^2 - e_y^2), h = s a2 +- sqrt(a1^2 -
e_z^2) > |e_y|: closed form. Units: mm; degrees where printed. Source: Yao Haifeng et al. 2020 (see
`study`); (4) to (10), (12) are missing in the copy at hand and written from the text around them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import casadi as ca
import numpy as np

from studies.shared.guesses import Closure
from studies.yao2020.model import (
    A1,
    A2,
    AXES,
    SIZE,
    STROKE,
    ZERO,
    T,
    about,
    along,
    pose_of,
    tool_points,
)

TOLERANCE = 1e-8
"""|f| at which the paper stops, mm."""
Function = Callable[[float], float]


# --- the search as written, (4) to (8) ------------------------------------------------------------


def retreated(A: np.ndarray, R: np.ndarray, length: float) -> dict[str, np.ndarray]:
    """(4): A1, D1, E1, F1."""
    points = tool_points(A, R)
    return {name: along(p, points["A"], points["D"], -length) for name, p in points.items()}


def plane_vectors(
    A: np.ndarray, R: np.ndarray, length: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(5): AD, the normal n of plane II, and n x ED, which points in plane II from axis 5 to O;
    unit vectors.
    """
    p = retreated(A, R, length)
    ad, normal, ed = p["D"] - p["A"], np.cross(p["E"], p["D"]), p["D"] - p["E"]
    ad, normal, ed = (v / np.linalg.norm(v) for v in (ad, normal, ed))
    return ad, normal, np.cross(normal, ed)


def angle_of_planes(A: np.ndarray, R: np.ndarray, length: float) -> float:
    """(6) as the text says it: 90 degrees less the angle of AD with the normal of plane II, between
    -90 and 90.
    """
    ad, normal, _ = plane_vectors(A, R, length)
    return 90.0 - math.degrees(math.acos(np.clip(ad @ normal, -1.0, 1.0)))


def full_angle_of_planes(A: np.ndarray, R: np.ndarray, length: float) -> float:
    """The same with its cosine, between -180 and 180."""
    ad, normal, towards = plane_vectors(A, R, length)
    return degrees2(ad @ normal, ad @ towards)


def f_iteration(A: np.ndarray, R: np.ndarray, angle=angle_of_planes) -> Function:
    """(7), (8): f(l) = |OF2| - a1 through the points."""

    def f(length: float) -> float:
        p = retreated(A, R, length)
        return float(np.linalg.norm(about(p["F"], p["E"], p["D"], -angle(A, R, length)))) - A1

    return f


def paper_search(f: Function, order: str) -> tuple[float, int]:
    """The printed loop on [-500, 0] to 1e-8. `order`: which test comes first, 'left' (f_min
    f_mid < 0) or 'right'; 'both': one after the other with the same values, as printed. Returns L6
    and the number of steps.
    """
    (low, high), steps = STROKE, 0
    at_low, at_high = f(low), f(high)
    for steps in range(1, 201):  # noqa: B007 - the last value is returned
        middle = 0.5 * (low + high)
        at_middle = f(middle)
        left, right = at_low * at_middle < 0, at_middle * at_high < 0
        if abs(at_middle) < TOLERANCE or not (left or right):
            break
        take_left = left and (order != "right" or not right)
        take_right = right and (order != "left" or not left)
        low, at_low = (middle, at_middle) if take_right else (low, at_low)
        high, at_high = (middle, at_middle) if take_left else (high, at_high)
    return middle, steps


def secant_search(
    f: Function, low: float, high: float, tolerance: float = TOLERANCE
) -> tuple[float, int]:
    """The same loop with the chord's zero (Illinois: the end that stays counts half) in place of
    the midpoint.
    """
    f_low, f_high, x, steps = f(low), f(high), low, 0
    if f_low * f_high > 0:
        raise SystemExit(f"yao2020: no change of sign in [{low}, {high}]: {f_low}, {f_high}")
    for steps in range(1, 101):  # noqa: B007 - the last value is returned
        x = high - f_high * (high - low) / (f_high - f_low)
        value = f(x)
        if abs(value) <= tolerance:
            break
        low, f_low = (high, f_high) if value * f_high < 0 else (low, 0.5 * f_low)
        high, f_high = x, value
    return x, steps


# --- the shorter way ------------------------------------------------------------------------------


def axis5_origin(A: np.ndarray, R: np.ndarray) -> np.ndarray:
    """e = R^T E0: the goal's point E in the tool's axes."""
    return R.T @ A + ZERO["E"] - ZERO["A"]


def fifth(A: np.ndarray, R: np.ndarray, s: int, slide: float) -> float:
    e = axis5_origin(A, R)
    return degrees2(s * e[1], -s * (e[0] - slide))


def distance_function(A: np.ndarray, R: np.ndarray, s: int = 1, a1: float = A1) -> Function:
    """f by h, the distance of O from axis 5."""
    e = axis5_origin(A, R)
    return lambda slide: math.hypot(math.hypot(e[0] - slide, e[1]) - s * A2, e[2]) - a1


def slides(A: np.ndarray, R: np.ndarray, s: int = 1, a1: float = A1) -> list[float]:
    """All roots of f in closed form, up to four."""
    e, found = axis5_origin(A, R), []
    if abs(e[2]) >= a1:
        return []
    for sign in (1, -1):
        h = s * A2 + sign * math.sqrt(a1**2 - e[2] ** 2)
        if h > abs(e[1]):
            away = math.sqrt(h * h - e[1] ** 2)
            found += [e[0] - away, e[0] + away]
    return found


# --- return of the axes, (9) to (12) --------------------------------------------------------------


def wrist_returned(
    A: np.ndarray, R: np.ndarray, slide: float, theta5: float
) -> dict[str, np.ndarray]:
    """Joints 6 and 5 at zero: the tool's points A, C, D, E, F, with F on axes 3 and 4."""
    points = {
        name: along(A + R @ (ZERO[name] - ZERO["A"]), R[:, 0], np.zeros(3), slide)
        for name in "ACDEF"
    }
    E, D = points["E"], points["D"]
    return {name: about(p, E, D, -theta5) for name, p in points.items()}


def undone(points: dict[str, np.ndarray], joint: int, degrees: float) -> dict[str, np.ndarray]:
    """The points with one of the joints 1 to 3 turned back."""
    return {name: about(p, *AXES[joint - 1], -degrees) for name, p in points.items()}


def sequence(
    A: np.ndarray, R: np.ndarray, slide: float, s: int = 1, side: int = 1
) -> Iterator[tuple[int, float, dict[str, np.ndarray]]]:
    """Joint, its value, and the points before it is returned, for joints 1, 2, 3, 4 in turn; `side`
    chooses of theta1's two.
    """
    points = wrist_returned(A, R, slide, fifth(A, R, s, slide))
    theta1 = degrees2(-side * points["F"][1], -side * points["F"][0])
    yield 1, theta1, points
    points = undone(points, 1, theta1)
    theta2 = degrees2(points["F"][2], -points["F"][0])
    yield 2, theta2, points
    points = undone(points, 2, theta2)
    across = points["C"] - points["A"]
    theta3 = degrees2(across[2], across[1])
    yield 3, theta3, points
    points = undone(points, 3, theta3)
    link = points["E"] - points["F"]
    yield 4, degrees2(link[2], -link[0]), points


def returned(A: np.ndarray, R: np.ndarray, slide: float, s: int, side: int = 1) -> np.ndarray:
    """theta1 to theta5 and L6."""
    return np.array(
        [*(value for _, value, _ in sequence(A, R, slide, s, side)), fifth(A, R, s, slide), slide]
    )


def third_angles(joints: np.ndarray) -> dict[str, float]:
    """(11) from the points of the state before joint 3 is returned: as printed, its arguments
    exchanged, signs mended, by C - A.
    """
    A, R = pose_of(joints)
    points = undone(undone(wrist_returned(A, R, joints[5], joints[4]), 1, joints[0]), 2, joints[1])
    (_, y, z), (_, cy, cz) = points["D"], points["C"] - points["A"]
    return {
        "(z, y)": degrees2(z, y),
        "(y, z)": degrees2(y, z),
        "(-y, z)": degrees2(-y, z),
        "C - A": degrees2(cz, cy),
    }


def degrees2(y: float, x: float) -> float:
    return math.degrees(math.atan2(y, x))


def inverse(A: np.ndarray, R: np.ndarray) -> list[np.ndarray]:
    """All real solutions, up to eight, each verified against the pose; the branch of the paper's
    answer first.
    """
    found = [
        returned(A, R, x, s, side) for s in (1, -1) for x in slides(A, R, s) for side in (1, -1)
    ]
    return sorted(
        (q for q in found if misses(q, A, R) < 1e-7), key=lambda q: (-round(q[5], 6), abs(q[0]))
    )


def misses(joints: np.ndarray, A: np.ndarray, R: np.ndarray) -> float:
    """How far joint values are from a pose: the larger of position (mm) and rotation times the
    robot's length.
    """
    at, turned = pose_of(joints)
    return max(float(np.linalg.norm(at - A)), SIZE * float(np.abs(turned - R).max()))


# --- closures for CasADi's solvers ----------------------------------------------------------------


def plane_closure() -> Closure:
    """(5) to (8) in X = (L6, theta5), given e: O in the plane of F and axis 5, and |OF| = a1."""
    L6, theta5 = ca.SX.sym("L6"), ca.SX.sym("theta5")
    e = ca.vertcat(*(ca.SX.sym(f"e{c}") for c in "xyz"))
    across = (e[0] - L6) * ca.sin(theta5) + e[1] * ca.cos(theta5)
    distance = (
        ca.sqrt(
            (e[0] - L6 + A2 * ca.cos(theta5)) ** 2 + (e[1] - A2 * ca.sin(theta5)) ** 2 + e[2] ** 2
        )
        - A1
    )
    return Closure(ca.vertcat(L6, theta5), e, ca.vertcat(across, distance), (False, True), SIZE)


def _moved(point, q: ca.SX) -> ca.SX:
    """(3) with symbols, angles in rad."""
    x = ca.DM(point) + ca.vertcat(q[5], 0, 0)
    for k in reversed(range(5)):
        (start, end), c, s = AXES[k], ca.cos(q[k]), ca.sin(q[k])
        i = int(np.argmax(np.abs(np.subtract(end, start))))
        p, j, m = x - ca.DM(start), (i + 1) % 3, (i + 2) % 3
        rows = [None] * 3
        rows[i], rows[j], rows[m] = p[i], c * p[j] - s * p[m], s * p[j] + c * p[m]
        x = ca.DM(start) + ca.vertcat(*rows)
    return x


def _joints() -> ca.SX:
    return ca.vertcat(*(ca.SX.sym(name) for name in (*(f"theta{k}" for k in range(1, 6)), "L6")))


def point_closure() -> Closure:
    """(3) for A, B and C less their goals: nine rows in the six joints."""
    q, goal = _joints(), ca.SX.sym("goal", 9)
    rows = ca.vertcat(*(_moved(ZERO[name], q) for name in "ABC")) - goal
    return Closure(q, goal, rows, (True,) * 5 + (False,), SIZE)


def square_closure() -> Closure:
    """(3) as six rows: A less its goal, and t times the Cayley vector of the turn from the goal's
    B - A, C - A to ours, which vanishes only where the two agree.
    """
    q, goal = _joints(), ca.SX.sym("goal", 9)
    A, B, C = (_moved(ZERO[name], q) for name in "ABC")
    frame, wanted = _frame(A, B, C), _frame(*ca.vertsplit(goal, 3))
    M = frame @ wanted.T
    cayley = ca.vertcat(M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]) / (1 + ca.trace(M))
    return Closure(q, goal, ca.vertcat(A - goal[:3], T * cayley), (True,) * 5 + (False,), SIZE)


def _frame(A: ca.SX, B: ca.SX, C: ca.SX) -> ca.SX:
    z, y = (B - A) / T, (C - A) / T
    return ca.horzcat(ca.cross(y, z), y, z)


def inside(joints: np.ndarray) -> np.ndarray:
    """Joint values with their angles in radians."""
    return np.array([*np.radians(joints[:5]), joints[5]])


def three_points(A: np.ndarray, R: np.ndarray) -> np.ndarray:
    """A, B, C of a pose in one vector."""
    return np.concatenate([A + R @ (ZERO[name] - ZERO["A"]) for name in "ABC"])
