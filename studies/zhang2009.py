"""Six-SPS Gough-Stewart platform: direct kinematics by Newton's method on six equations in three lengths and three angles.

Notation: A_i platform joint centres on a circle of 250 mm at 240, 330, 0, 90, 120, 210 degrees, B_i base joint centres on
275 mm at 270, 300, 30, 60, 150, 180 degrees (both z = 0), L_i the length of limb i, X = (x, y, z, alpha, beta, gamma):

    f_i(X) = |B_i - (p + R A_i)|^2 - L_i^2 = 0,   p = (x, y, z),   R = Rx(alpha) Ry(beta) Rz(gamma)   ('XYZ', moving axes)

    X <- X - C F,   C = D^-1 by Gauss and Jordan,   D = dF/dX.

Units: mm; angles in degrees where printed, in radians inside; the residual max |f_i| is in mm^2.
Source: Zhang Zhaoyin, Practical solution of 6-DOF parallel robot position forward solution, Computer Engineering and
Applications 45(9), 2009, 47-48. Tables 2 (start) and 3 (iterations) are missing from the copy at hand: the start here is
our choice. The paper claims real time without a figure.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

import symkin
from enumerated import statement
from report import Report, equal_axes, folder_from_arguments, new_figure
from symkin.spatial.rotation import euler_from_quaternion

PLATFORM_DEG, BASE_DEG = (240, 330, 0, 90, 120, 210), (270, 300, 30, 60, 150, 180)
A = 250.0 * np.array([[math.cos(t), math.sin(t), 0.0] for t in np.radians(PLATFORM_DEG)])
B = 275.0 * np.array([[math.cos(t), math.sin(t), 0.0] for t in np.radians(BASE_DEG)])
B_PRINTED = np.vstack([[0.0, -125.0, 0.0], B[1:]])
TABLE_1 = np.array([144.6, 347.0, 110.3, 178.6, 277.6, 269.4])
START = (0.0, 0.0, 100.0, 0.0, 0.0, 0.0)
START_NEARBY = (0.0, 0.0, 100.0, 5.0, 5.0, 5.0)
EVIDENT_POSE = (119.0, 88.0, 72.0, 10.0, 21.0, 15.0)
SEED = 0
COLOURS = ("#0072b2", "#d55e00", "#7f7f7f")

Numbers = Sequence[float] | np.ndarray
Path = list[tuple[np.ndarray, float]]
"""(X, max |f|) at every step."""


# --- the paper's equations ---------------------------------------------------------------------------------------


def rotation(angles: ca.SX, *, misprint: bool) -> ca.SX:
    """R of the paper's T; row 3, column 1 is printed with s_gamma where c_gamma must stand."""
    (sa, sb, sg), (ca_, cb, cg) = ca.vertsplit(ca.sin(angles)), ca.vertsplit(ca.cos(angles))
    return ca.vertcat(
        ca.horzcat(cb * cg, -cb * sg, sb),
        ca.horzcat(sa * sb * cg + ca_ * sg, ca_ * cg - sa * sb * sg, -sa * cb),
        ca.horzcat(sa * sg - ca_ * sb * (sg if misprint else cg), ca_ * sb * sg + sa * cg, ca_ * cb),
    )


@dataclass(frozen=True)
class Equations:
    """F and D = dF/dX for one reading of the paper: its T as printed or right, its B as printed or as in equation (2)."""

    X: ca.SX
    F: ca.SX
    evaluate: ca.Function
    lengths: ca.Function
    R: ca.Function


def equations(*, misprint: bool = False, base: np.ndarray = B) -> Equations:
    X = ca.SX.sym("X", 6)
    R = rotation(X[3:], misprint=misprint)
    squares = ca.vertcat(*(ca.sumsqr(ca.DM(b) - X[:3] - R @ ca.DM(a)) for a, b in zip(A, base, strict=True)))
    F = squares - TABLE_1**2
    evaluate = ca.Function("F_D", [X], [F, ca.jacobian(F, X)])
    return Equations(X, F, evaluate, ca.Function("L", [X], [ca.sqrt(squares)]), ca.Function("R", [X], [R]))


def inside(pose: Numbers) -> np.ndarray:
    """Degrees to radians in the last three."""
    return np.concatenate([pose[:3], np.radians(pose[3:])])


def outside(X: np.ndarray) -> np.ndarray:
    """Radians to degrees in (-180, 180] in the last three."""
    return np.concatenate([X[:3], np.degrees(np.arctan2(np.sin(X[3:]), np.cos(X[3:])))])


def leg_lengths(system: Equations, pose: Numbers) -> np.ndarray:
    return np.asarray(system.lengths(inside(pose))).ravel()


# --- Newton's method as the paper writes it ----------------------------------------------------------------------


def gauss_jordan(D: np.ndarray) -> np.ndarray:
    """C = D^-1 by elimination with row pivots; NaN where a pivot vanishes."""
    n = len(D)
    work = np.hstack([D, np.eye(n)])
    for k in range(n):
        best = k + int(np.argmax(np.abs(work[k:, k])))
        if abs(work[best, k]) < 1e-12 * np.abs(D).max():
            return np.full((n, n), np.nan)
        work[[k, best]] = work[[best, k]]
        work[k] /= work[k, k]
        work -= np.outer(np.where(np.arange(n) == k, 0.0, work[:, k]), work[k])
    return work[:, n:]


def newton(system: Equations, start: Numbers, *, as_printed: bool = False, most: int = 30) -> Path:
    """Steps until no |f| is above 1e-9 mm^2. `as_printed`: the update X - C D, row i of C by column i of D for unknown i."""
    X, path = inside(start), []
    for _ in range(most + 1):
        F, D = (np.asarray(v) for v in system.evaluate(X))
        path.append((X, float(np.abs(F).max())))
        if path[-1][1] < 1e-9:
            break
        C = gauss_jordan(D)
        X = X - (np.diag(C @ D) if as_printed else (C @ F).ravel())
    return path


def rootfinder(system: Equations, method: str) -> np.ndarray:
    """The same by CasADi's rootfinder from the same start."""
    find = ca.rootfinder("find", method, {"x": system.X, "g": system.F}, {"abstol": 1e-9})
    return outside(np.asarray(find(x0=inside(START))["x"]).ravel())


# --- report ------------------------------------------------------------------------------------------------------


def euler_pose(pose: symkin.Pose) -> np.ndarray:
    """x, y, z in mm, alpha, beta, gamma in degrees."""
    return np.concatenate([pose.position, np.degrees(euler_from_quaternion(pose.quaternion, "XYZ"))])


def quaternion_pose(pose: Numbers) -> symkin.Pose:
    return symkin.Pose.from_euler(np.array(pose[:3]), np.radians(pose[3:]), "XYZ")


def report_inverse(report: Report, platform: symkin.Mechanism, system: Equations) -> None:
    report.row("limb lengths, frames coincident", None, leg_lengths(system, (0.0,) * 6), "mm")
    own = symkin.solve(platform, pose=quaternion_pose(EVIDENT_POSE)).solution.actuated
    report.row("limb lengths at (119, 88, 72; 10, 21, 15)", TABLE_1, leg_lengths(system, EVIDENT_POSE), "mm")
    report.row("the same by symkin's inverse", TABLE_1, own, "mm")
    tenths = 10 * np.array(own)
    fits = (np.floor(tenths) == np.round(10 * TABLE_1)) | (np.round(tenths) == np.round(10 * TABLE_1))
    report.row("of these truncate or round to table 1", 6, int(fits.sum()))


def report_newton(report: Report, system: Equations) -> Path:
    path = newton(system, START)
    for k, (X, residual) in enumerate(path):
        report.row(f"Newton, step {k}: x, y, z, alpha, beta, gamma; max |f|", None, [*outside(X), residual], "mm, deg; mm^2")
    report.row("Newton steps from (0, 0, 100; 0, 0, 0)", "tables 2, 3 missing: not comparable", len(path) - 1)
    for method in ("newton", "fast_newton"):
        report.row(f"CasADi rootfinder {method}", EVIDENT_POSE, rootfinder(system, method), "mm, deg")
    begin = time.perf_counter()
    for _ in range(20):
        newton(system, START)
    report.row("time of one direct solution", "real time, no figure", round(50 * (time.perf_counter() - begin), 2), "ms")
    return path


def report_modes(report: Report, platform: symkin.Mechanism) -> list[symkin.Pose]:
    found = symkin.modes(platform, joints=TABLE_1, seed=SEED)
    poses = [euler_pose(mode.pose) for mode in found]
    report.row(f"real modes by symkin.modes, {found.method}", None, len(found))
    report.row("complex solutions of the six equations", None, found.complex_count)
    report.row("completeness", None, statement(found))
    for k, pose in enumerate(poses, start=1):
        report.row(f"mode {k}", EVIDENT_POSE if k == 1 else None, pose, "mm, deg")
    mirrored = [pose * (1, 1, -1, -1, -1, 1) for pose in poses]
    pairs = sum(any(np.abs(m - p).max() < 1e-8 for p in poses) for m in mirrored) // 2
    report.row("mirror pairs (z, alpha, beta change sign)", None, pairs)
    for solver in ("newton", "fast_newton", "ipopt"):
        report.row(f"modes reached by symkin.solve, {solver}", None, reached(platform, poses, solver))
    return [mode.pose for mode in found]


def reached(platform: symkin.Mechanism, poses: list[np.ndarray], solver: str) -> int:
    """How many modes a solver finds from their poses rounded to 10 mm and 10 degrees."""
    count = 0
    for pose in poses:
        end = symkin.solve(platform, joints=TABLE_1, start=quaternion_pose(np.round(pose, -1)), solver=solver).solution
        count += bool(np.abs(euler_pose(end.pose) - pose).max() < 1e-8)
    return count


def report_base_misprint(report: Report, system: Equations) -> None:
    printed = equations(base=B_PRINTED)
    first = leg_lengths(printed, EVIDENT_POSE)[0], leg_lengths(system, EVIDENT_POSE)[0]
    report.row("limb 1 at the pose with B_1 = (0, -125, 0), (0, -275, 0)", [144.6, 144.6], first, "mm")
    end = outside(newton(printed, START)[-1][0])
    report.row("Newton with B_1 = (0, -125, 0)", EVIDENT_POSE, end, "mm, deg")
    shown = abs(first[0] - 144.6) > 1.0 and abs(first[1] - 144.6) < 0.1 and abs(np.linalg.norm(B_PRINTED[0]) - 275) > 1
    report.erratum("B_1 = (0, -125, 0) in the matrix B is off its circle; (0, -275, 0) in equation (2) is right.", shown=shown)


def report_rotation_misprint(report: Report, system: Equations) -> Path:
    printed = equations(misprint=True)
    R = np.asarray(printed.R(inside(EVIDENT_POSE)))
    rank = [int(np.linalg.matrix_rank(np.asarray(e.evaluate(inside(START))[1]), tol=1e-6)) for e in (printed, system)]
    path = newton(printed, START_NEARBY)
    false_pose = outside(path[-1][0])
    miss = leg_lengths(system, false_pose) - TABLE_1
    report.row("rank of D at a start without rotation: T as printed, right", None, rank)
    report.row("largest entry of R^T R - I, T as printed", None, float(np.abs(R.T @ R - np.eye(3)).max()))
    report.row(f"Newton, T as printed, {len(path) - 1} steps from {START_NEARBY}", EVIDENT_POSE, false_pose, "mm, deg")
    report.row("limb lengths there under the right rotation, less table 1", None, miss, "mm")
    text = (
        "row 3, column 1 of T, and with it every z_i, is printed s_alpha s_gamma - c_alpha s_beta s_gamma; it must be "
        f"s_alpha s_gamma - c_alpha s_beta c_gamma. As printed, R is no rotation, D has rank {rank[0]} without rotation, and "
        f"Newton goes to a false pose that misses the limbs by up to {np.abs(miss).max():.1f} mm."
    )
    report.erratum(text, shown=rank == [5, 6] and path[-1][1] < 1e-6 and np.abs(miss).max() > 1.0)
    return path


def report_printed_update(report: Report, system: Equations) -> Path:
    _, D = (np.asarray(v) for v in system.evaluate(inside(START)))
    identity = float(np.abs(gauss_jordan(D) @ D - np.eye(6)).max())
    path = newton(system, START, as_printed=True, most=8)
    steps = np.diff([X for X, _ in path], axis=0)
    report.row("largest entry of C D - I", None, identity)
    report.row("printed update X - C D: every step in each unknown", None, [float(steps.min()), float(steps.max())], "mm, rad")
    report.row("residual before, after 8 printed updates", None, [path[0][1], path[-1][1]], "mm^2")
    text = (
        "the update is printed X - C D, but D is the Jacobian and C its inverse, so that C D is the identity and every "
        "unknown falls by 1 at each step whatever the limbs measure; it must be X - C F."
    )
    report.erratum(text, shown=identity < 1e-9 and bool(np.abs(steps + 1).max() < 1e-9) and path[-1][1] > 1e3)
    return path


# --- picture -----------------------------------------------------------------------------------------------------


def draw_convergence(axes, right, misprint, printed) -> None:
    labels = "Newton", "Newton with T as misprinted, from 5° each: a false pose", "update as printed: X less C D"
    for path, style, label, colour in zip((right, misprint, printed), ("o-", "s-", "^-"), labels, COLOURS, strict=True):
        axes.semilogy([r for _, r in path], style, color=colour, lw=1.8, ms=6, label=label)
    axes.set(xlabel="iteration", ylabel="largest residual $|f_i|$ [mm$^2$]", ylim=(1e-13, 1e8))
    axes.set_title("Convergence from (0, 0, 100) mm without rotation", fontsize=12)
    axes.grid(alpha=0.3)
    axes.legend(loc="lower left", frameon=False, fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)


def draw_platform(axes, pose: symkin.Pose, title: str) -> None:
    ends = np.array([pose.apply(a) for a in A])
    for polygon, colour in ((B, "0.45"), (ends, COLOURS[0])):
        closed = np.vstack([polygon, polygon[:1]])
        axes.plot_trisurf(*polygon.T, triangles=[(0, i, i + 1) for i in range(1, 5)], color=colour, alpha=0.22, shade=False)
        axes.plot(*closed.T, color=colour, lw=1.8)
    for b, a in zip(B, ends, strict=True):
        axes.plot(*np.array([b, a]).T, "-o", color=COLOURS[1], lw=2, ms=3.5)
    equal_axes(axes, (-290, -290, -230), (390, 390, 230), "mm", 200)
    axes.set_title(title, fontsize=12, y=0.97)
    axes.view_init(20, -116)


def draw(poses: list[symkin.Pose], *paths: Path):
    figure = new_figure(16, 9)
    figure.suptitle("Gough-Stewart platform, direct problem of table 1: Newton's method and all four assembly modes", fontsize=15)
    grid = figure.add_gridspec(2, 3, width_ratios=(1.15, 1, 1))
    draw_convergence(figure.add_subplot(grid[:, 0]), *paths)
    for k, pose in enumerate(poses):
        x, y, z, *angles = euler_pose(pose)
        turns = r"$\alpha, \beta, \gamma$ = " + ", ".join(f"{a:.2f}°" for a in angles)
        place = figure.add_subplot(grid[k % 2, 1 + k // 2], projection="3d")
        draw_platform(place, pose, f"mode {k + 1}: ({x:.2f}, {y:.2f}, {z:.2f}) mm\n{turns}")
    return figure


def main() -> None:
    folder = folder_from_arguments(__doc__.splitlines()[0])
    platform, system = symkin.load("zhang2009"), equations()
    report = Report("zhang2009", "Gough-Stewart platform (Zhang 2009): direct kinematics by Newton's method", SEED)
    report_inverse(report, platform, system)
    right = report_newton(report, system)
    poses = report_modes(report, platform)
    report_base_misprint(report, system)
    misprint = report_rotation_misprint(report, system)
    printed = report_printed_update(report, system)
    report.finish(draw(poses, right, misprint, printed), folder)


if __name__ == "__main__":
    main()
