"""A 6R arm with three parallel axes by a DH table, its machines off parallel, and least squares
over its tool positions, all in NumPy and SciPy and without symkin's equations.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

import symkin
from symkin import DHRow, DHTable, Measurements, serial_arm_from_dh

KEYS = ("theta", "d", "a", "alpha")
QUARTER = np.pi / 2
TABLE = np.array(
    [
        [0.0, 89.16, 0.0, QUARTER],
        [0.0, 0.0, -425.0, 0.0],
        [0.0, 0.0, -392.25, 0.0],
        [0.0, 109.15, 0.0, QUARTER],
        [0.0, 94.65, 0.0, -QUARTER],
        [0.0, 82.3, 0.0, 0.0],
    ]
)
"""theta, d, a, alpha of each row (rad, mm), standard convention: axes 2, 3 and 4 are parallel."""
SIGMA = 0.02
"""Standard deviation of each coordinate of a tool position, mm."""


def arm(table: np.ndarray = TABLE) -> symkin.Mechanism:
    rows = [DHRow(f"j{k}", "R", *row) for k, row in enumerate(table, start=1)]
    return serial_arm_from_dh("arm", DHTable("standard", rows), length_unit="mm", angle_unit="deg")


def links(table: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Rz(theta + q) Tz(d) Tx(a) Rx(alpha) of each row: (n, 6, 4, 4)."""
    theta, (d, a, alpha) = table[:, 0] + joints, table[:, 1:].T
    c, s, ca, sa, zero = (
        np.cos(theta),
        np.sin(theta),
        np.cos(alpha),
        np.sin(alpha),
        np.zeros_like(theta),
    )
    rows = [
        [c, -s * ca, s * sa, a * c],
        [s, c * ca, -c * sa, a * s],
        [zero, zero + sa, zero + ca, zero + d],
        [zero, zero, zero, zero + 1.0],
    ]
    return np.array(rows).transpose(2, 3, 0, 1)


def positions(
    table: np.ndarray, joints: np.ndarray, offset: tuple[float, ...] = (0.0, 0.0, 0.0)
) -> np.ndarray:
    """Places (n, 3) of a point of the tool frame."""
    made, point = links(table, joints), np.tile(offset, (len(joints), 1))
    for k in range(5, -1, -1):
        point = (made[:, k, :3, :3] @ point[:, :, None])[:, :, 0] + made[:, k, :3, 3]
    return point


def slopes(table: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """d position / d table (n, 3, 24) from the lines about and along which each number moves the
    tool.
    """
    made = links(table, joints)
    tool, frame, found = positions(table, joints), np.tile(np.eye(4), (len(joints), 1, 1)), []
    for k in range(6):
        after = frame @ made[:, k]
        z, x = frame[:, :3, 2], after[:, :3, 0]
        turn_z, turn_x = np.cross(z, tool - frame[:, :3, 3]), np.cross(x, tool - after[:, :3, 3])
        found += [turn_z, z, x, turn_x]
        frame = after
    return np.stack(found, axis=2)


def random_table(rng: np.random.Generator) -> np.ndarray:
    """The table of a machine whose DH numbers are each off by normal errors."""
    return TABLE + rng.normal(size=TABLE.shape) * [2e-3, 1.0, 1.0, 1e-3]


def moved_lines(tilt: float, shift: float, rng: np.random.Generator) -> np.ndarray:
    """The table of a machine whose axes are off by normal angles and distances: common normals of
    the lines that its axes are, hundreds of metres along the axes that are nearly parallel.
    """
    frame, lines = np.eye(4), []
    for link in links(TABLE, np.zeros((1, 6)))[0]:
        lines.append((frame[:3, 3], frame[:3, 2]))
        frame = frame @ link
    off = [(p + shift * rng.normal(size=3), z + tilt * rng.normal(size=3)) for p, z in lines]
    lines = [lines[0], *((p, z / np.linalg.norm(z)) for p, z in off[1:])]
    return _table_of(lines, frame)


def _table_of(lines: list[tuple[np.ndarray, np.ndarray]], tool: np.ndarray) -> np.ndarray:
    """DH rows from the joints' lines (point, axis) and the tool frame: feet of common normals; the
    last frame stands at the tool's origin with its z along the last axis.
    """
    x, origin, table = np.array([1.0, 0.0, 0.0]), np.zeros(3), []
    for (p, z), (q, w) in pairwise([*lines, (tool[:3, 3], lines[-1][1])]):
        normal = np.cross(z, w)
        if np.linalg.norm(normal) > 1e-12:
            s, _, _ = np.linalg.solve(np.column_stack([z, normal, -w]), q - p)
        else:
            s = (q - p) @ z
            normal = q - p - s * z if np.linalg.norm(q - p - s * z) > 1e-9 else x
        normal = np.copysign(1.0, normal @ x) * normal / np.linalg.norm(normal)
        foot = p + s * z
        a = (q - foot) @ normal
        theta, alpha = (
            np.arctan2(np.cross(x, normal) @ z, x @ normal),
            np.arctan2(np.cross(z, w) @ normal, z @ w),
        )
        table.append([theta, (foot - origin) @ z, a, alpha])
        x, origin = normal, foot + a * normal
    return np.array(table)


def measured(
    table: np.ndarray,
    rng: np.random.Generator,
    count: int = 60,
    offset: tuple[float, ...] = (0.0, 0.0, 0.0),
) -> Measurements:
    """Tool positions with noise at random joint values; `offset` is a target in the tool frame that
    no model knows of.
    """
    joints = rng.uniform(-2.0, 2.0, (count, 6))
    read = positions(table, joints, offset)
    return Measurements(
        joints, position=read + SIGMA * rng.normal(size=read.shape), position_sigma=SIGMA
    )


def chi_square(mechanism: symkin.Mechanism, data: Measurements) -> float:
    """Of a mechanism's DH table on the readings."""
    table = np.array([[getattr(row, key) for key in KEYS] for row in mechanism.dh.rows])
    return float(np.sum(((positions(table, data.joints) - data.position) / SIGMA) ** 2))


def least_chi_square(data: Measurements, table: np.ndarray = TABLE) -> float:
    """SciPy's minimum from the nominal table."""
    from scipy.optimize import least_squares

    def residuals(p: np.ndarray) -> np.ndarray:
        return ((positions(p.reshape(6, 4), data.joints) - data.position) / SIGMA).ravel()

    def jacobian(p: np.ndarray) -> np.ndarray:
        return slopes(p.reshape(6, 4), data.joints).reshape(-1, 24) / SIGMA

    best = np.inf
    for scale in ("jac", np.tile([1e-3, 1.0, 1.0, 1e-3], 6)):
        for method in ("trf", "lm"):
            found = least_squares(
                residuals,
                table.ravel(),
                jacobian,
                x_scale=scale,
                method=method,
                xtol=1e-15,
                ftol=1e-15,
                gtol=1e-15,
                max_nfev=3000,
            )
            best = min(best, 2 * float(found.cost))
    return best
