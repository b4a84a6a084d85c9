"""Geometry of the wrist-offset telescopic Pieper robot as its paper writes it: axes by two points,
equations (1) to (3).

Notation (global frame, initial position): axes 1, 2, 3 through O along z, y, x; F = (-a1, 0, 0) on
axis 4 (along y); E = (-a1-a2, 0, 0) on axis 5 (along z); D = E + (0, 0, d1); tool tip A = D - (a3,
0, 0); B = A + (0, 0, t), C = A + (0, t, 0); joint 6 slides along +x by L6. A point passes joint 6
first and joint 1 last, so that

    A = R123 (F + Ry(theta4) (E - F + Rz(theta5) (A - E + (L6, 0, 0)))),
    R123 = Rz(theta1) Ry(theta2) Rx(theta3).

Units: mm; degrees where printed. Source: Yao Haifeng et al. 2020 (see `study`). The paper prints
none of its lengths; they follow from the points D0, E0, F0 and the answer of its worked example.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise, permutations

import casadi as ca
import numpy as np

import symkin

Line = tuple[np.ndarray, np.ndarray]
"""A point and a unit direction."""
A1, A2, A3, D1 = 300.0, 85.0, 160.0, 105.0
T = 50.0
"""Distance of B and C from A, mm; any value will do, and the paper prints none."""
SIZE = A1 + A2 + A3
SEED = 5
"""Of every random number of the study."""
FORWARD = (5.0, -10.0, 15.0, -20.0, 25.0, 30.0)
"""Joint values of the paper's forward example: theta1 to theta5 in degrees, L6 in mm."""
TIP = np.array([-507.4063, 89.8079, 69.4402])
ANGLES = (20.0, -15.0, 25.0)
"""theta_x, theta_y, theta_z of the pose of the inverse example."""
PRINTED_POINTS = {
    "D": (-367.3381, 155.1228, 110.8512),
    "E": (-359.3707, 198.4627, 15.5455),
    "F": (-284.9595, 233.1612, 37.5452),
}
PRINTED = (-35.5954, 2.7289, 22.5392, 7.7657, 62.2462, -51.556)
STROKE = (-500.0, 0.0)
"""Interval of L6 that the paper searches; it prints no other range of any joint."""

AXES = (
    ((0, 0, 0), (0, 0, 1)),
    ((0, 0, 0), (0, 1, 0)),
    ((0, 0, 0), (1, 0, 0)),
    ((-A1, 0, 0), (-A1, 1, 0)),
    ((-A1 - A2, 0, 0), (-A1 - A2, 0, 1)),
    ((-A1 - A2 - A3, 0, D1), (-A1 - A2, 0, D1)),
)
"""Each axis from one point to another at the initial position (section 1.1)."""
ZERO = {
    "O": np.zeros(3),
    "F": np.array([-A1, 0, 0]),
    "E": np.array([-A1 - A2, 0, 0]),
    "D": np.array([-A1 - A2, 0, D1]),
    "A": np.array([-A1 - A2 - A3, 0, D1]),
    "B": np.array([-A1 - A2 - A3, 0, D1 + T]),
    "C": np.array([-A1 - A2 - A3, T, D1]),
}
CARRIED = {"O": 0, "F": 3, "E": 4, "D": 4, "A": 6, "B": 6, "C": 6}
"""The last joint that moves each point; joint 5 turns about E and D."""


def random_joints(count: int) -> np.ndarray:
    """Joint values anywhere, rows of theta1 to theta5 in degrees and L6 between -400 and 0."""
    rng = np.random.default_rng(SEED)
    return np.column_stack([rng.uniform(-180, 180, (count, 5)), rng.uniform(-400, 0, count)])


def apart(one: float, other: float) -> float:
    """Difference of two angles in degrees, modulo turns."""
    return abs((one - other + 180) % 360 - 180)


def same(a: Sequence[float], b: Sequence[float]) -> bool:
    """Equal joint values to 1e-6, angles modulo turns."""
    return max(*(apart(x, y) for x, y in zip(a[:5], b[:5], strict=True)), abs(a[5] - b[5])) < 1e-6


# --- equations (1) to (3) -------------------------------------------------------------------------


def along(point: np.ndarray, start, end, length: float) -> np.ndarray:
    """(1): a point moved along the direction from `start` to `end`."""
    r = np.subtract(end, start)
    return point + length * r / np.linalg.norm(r)


def about(point: np.ndarray, start, end, degrees: float) -> np.ndarray:
    """(2): a point turned about the axis from `start` to `end`."""
    r, p = np.subtract(end, start) / math.dist(start, end), np.subtract(point, start)
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return start + c * p + s * np.cross(r, p) + (1 - c) * (r @ p) * r


def forward(point: np.ndarray, joints: Sequence[float], last: int = 6) -> np.ndarray:
    """(3): a point of the member that joint `last` moves, through joints `last` to 1."""
    for k in reversed(range(last)):
        point = (along if k == 5 else about)(point, *AXES[k], joints[k])
    return point


def placed(joints: Sequence[float]) -> dict[str, np.ndarray]:
    """O, F, E, D, A, B, C at joint values."""
    return {name: forward(point, joints, CARRIED[name]) for name, point in ZERO.items()}


def rotation_of(A: np.ndarray, B: np.ndarray, C: np.ndarray) -> np.ndarray:
    """The rotation that three points state: z from A to B, y from A to C."""
    z, y = (B - A) / np.linalg.norm(B - A), (C - A) / np.linalg.norm(C - A)
    return np.column_stack([np.cross(y, z), y, z])


def pose_of(joints: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """A and the rotation."""
    at = placed(joints)
    return at["A"], rotation_of(at["A"], at["B"], at["C"])


def axis_lines(joints: Sequence[float]) -> list[Line]:
    """The six axes at joint values: a point and a unit direction each."""
    ends = [[forward(np.array(p, float), joints, k) for p in axis] for k, axis in enumerate(AXES)]
    return [(start, (end - start) / np.linalg.norm(end - start)) for start, end in ends]


def line_distance(one: Line, other: Line) -> float:
    """Distance of two lines, each a point and a unit direction."""
    (p, u), (q, v) = one, other
    n = np.cross(u, v)
    if np.linalg.norm(n) < 1e-12:
        return float(np.linalg.norm(np.cross(q - p, u)))
    return float(abs((q - p) @ n) / np.linalg.norm(n))


def forward_steps() -> list[tuple[str, ca.SX]]:
    """Equation (3) for A as symbols, one joint a step: what was moved, and its x, y, z in terms of
    the step before.
    """
    theta1, theta2, theta3, theta4, theta5, L6 = (
        ca.SX.sym(n) for n in (*(f"theta{k}" for k in range(1, 6)), "L6")
    )
    a1, a2, a3, d1 = (ca.SX.sym(n) for n in ("a1", "a2", "a3", "d1"))

    def before(joint: int) -> list[ca.SX]:
        return [ca.SX.sym(f"{c}{joint}") for c in "xyz"]

    slid = ca.vertcat(L6 - a1 - a2 - a3, 0, d1)
    x, y, z = before(6)
    fifth = ca.vertcat(
        ca.cos(theta5) * (x + a1 + a2) - ca.sin(theta5) * y - a1 - a2,
        ca.sin(theta5) * (x + a1 + a2) + ca.cos(theta5) * y,
        z,
    )
    x, y, z = before(5)
    fourth = ca.vertcat(
        ca.cos(theta4) * (x + a1) + ca.sin(theta4) * z - a1,
        y,
        ca.cos(theta4) * z - ca.sin(theta4) * (x + a1),
    )
    x, y, z = before(4)
    third = ca.vertcat(
        x, ca.cos(theta3) * y - ca.sin(theta3) * z, ca.sin(theta3) * y + ca.cos(theta3) * z
    )
    x, y, z = before(3)
    second = ca.vertcat(
        ca.cos(theta2) * x + ca.sin(theta2) * z, y, ca.cos(theta2) * z - ca.sin(theta2) * x
    )
    x, y, z = before(2)
    first = ca.vertcat(
        ca.cos(theta1) * x - ca.sin(theta1) * y, ca.sin(theta1) * x + ca.cos(theta1) * y, z
    )
    return list(
        zip(
            ("x6, y6, z6", "x5, y5, z5", "x4, y4, z4", "x3, y3, z3", "x2, y2, z2", "A"),
            (slid, fifth, fourth, third, second, first),
            strict=True,
        )
    )


# --- rotations and poses --------------------------------------------------------------------------


def turn(axis: str, degrees: float) -> np.ndarray:
    """Rx, Ry or Rz."""
    end = np.eye(3)["xyz".index(axis)]
    return np.column_stack([about(column, np.zeros(3), end, degrees) for column in np.eye(3)])


def euler_product(order: str) -> np.ndarray:
    """The worked example's three turns, the first letter leftmost: "zyx" is Rz(25) Ry(-15)
    Rx(20).
    """
    R = np.eye(3)
    for axis in order:
        R = R @ turn(axis, ANGLES["xyz".index(axis)])
    return R


def goal_rotation() -> np.ndarray:
    return euler_product("zyx")


def orders_off() -> dict[str, float]:
    """For each order of the three turns, how far the directions A0 D0, D0 E0, E0 F0 of the printed
    points are from the rotation's x, -z, x.
    """
    points = [TIP, *(np.array(PRINTED_POINTS[name]) for name in "DEF")]
    steps = [(b - a) / np.linalg.norm(b - a) for a, b in pairwise(points)]
    wanted = np.column_stack([steps[0], -steps[1], steps[2]])
    return {
        "".join(order): float(np.abs(euler_product("".join(order))[:, [0, 2, 0]] - wanted).max())
        for order in permutations("xyz")
    }


def symkin_pose(A: np.ndarray, R: np.ndarray) -> symkin.Pose:
    return symkin.Pose.from_matrix(np.block([[R, A[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]]))


def tool_points(A: np.ndarray, R: np.ndarray) -> dict[str, np.ndarray]:
    """A0, D0, E0, F0: points fixed to member 6, where they stand at the goal with L6 = theta5 =
    0.
    """
    return {name: A + R @ (ZERO[name] - ZERO["A"]) for name in "ADEF"}


# --- figure 1: arms with spherical wrists ---------------------------------------------------------


def spherical_wrists() -> dict[str, symkin.Mechanism]:
    """PUMA 560 (Corke and Armstrong-Helouvry 1994) and the Stanford arm (Paul 1981) with its slide
    at 0.4, lengths in m; the paper prints none.
    """
    quarter = math.pi / 2
    puma = (
        ("R", 0, 0, 0, quarter),
        ("R", 0, 0, 0.4318, 0),
        ("R", 0, 0.15005, 0.0203, -quarter),
        ("R", 0, 0.4318, 0, quarter),
        ("R", 0, 0, 0, -quarter),
        ("R", 0, 0, 0, 0),
    )
    stanford = (
        ("R", 0, 0.412, 0, -quarter),
        ("R", 0, 0.154, 0, quarter),
        ("P", -quarter, 0.4, 0, 0),
        ("R", 0, 0, 0, -quarter),
        ("R", 0, 0, 0, quarter),
        ("R", 0, 0.263, 0, 0),
    )
    tables = {"PUMA560": puma, "Stanford": stanford}
    return {name: arm_of(name, rows) for name, rows in tables.items()}


def arm_of(name: str, rows) -> symkin.Mechanism:
    table = [symkin.DHRow(f"q{k}", *row) for k, row in enumerate(rows, start=1)]
    return symkin.serial_arm_from_dh(
        name, symkin.DHTable("standard", table), length_unit="m", angle_unit="deg"
    )


def drawn_axes(arm: symkin.Mechanism) -> list[Line]:
    """The axes of an arm's joints where its file places them."""
    return [(np.array(j.point, float), np.array(j.axis, float)) for j in arm.limbs[0].joints]


def posed_axes(lines: list[Line], joints: Sequence[float], types: Sequence[str]) -> list[Line]:
    """Axes of an arm, given where its joints are zero, at joint values: each is moved by the joints
    before it.
    """
    moved = []
    for k, (point, direction) in enumerate(lines):
        ends = [point, point + direction]
        for j in reversed(range(k)):
            (start, along_axis), value = lines[j], joints[j]
            ends = [
                p + value * along_axis
                if types[j] == "P"
                else about(p, start, start + along_axis, value)
                for p in ends
            ]
        moved.append((ends[0], ends[1] - ends[0]))
    return moved


def concurrency(lines: list[Line]) -> float:
    """Largest distance between two of the lines: 0 where they meet pairwise."""
    return max(line_distance(a, b) for i, a in enumerate(lines) for b in lines[:i])
