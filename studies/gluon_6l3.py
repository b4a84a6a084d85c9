"""Gluon-6L3, a 6R arm with joints 2, 3, 4 parallel: forward, closed-form inverse, numeric inverse, Jacobian.

Notation: standard DH, A_i = Rz(t_i) Tz(d_i) Tx(a_i) Rx(alpha_i), t_i = q_i + offset_i, T = A_1 ... A_6;
c234 = cos(t2 + t3 + t4). With B = A_1^-1 T and elements [row, column] counted from 1 as on the page:

    B[3,3] = c5,  B[3,4] = d4 + d6 c5    ->  q1 (two), q5 (two each)
    B[3,1] = s5 c6,  B[3,2] = -s5 s6     ->  q6
    B[1,3] = -c234 s5,  B[2,3] = -s234 s5 ->  q2 + q3 + q4
    B (A_5 A_6)^-1 = A_2 A_3 A_4          ->  a planar two-link: q3 (two), q2, q4

Units: mm; joint values in degrees where printed, in radians inside. Random joints are uniform in a turn.
Source: "Gluon-6L3 forward and inverse kinematics", tutorial page; its formulas were pictures and are derived anew here.
"""

from __future__ import annotations

import time

import casadi as ca
import numpy as np

import symkin
from report import Report, new_figure, options_parser
from symkin.spatial.screw import exponential, move_screw, revolute_screw

D = (105.03, 0.0, 0.0, 75.66, 80.09, 44.36)
A = (0.0, -174.42, -174.42, 0.0, 0.0, 0.0)
ALPHA = np.radians([90.0, 0.0, 0.0, 90.0, -90.0, 0.0])
OFFSET = np.radians([0.0, -90.0, 0.0, -90.0, 0.0, 0.0])
EXAMPLE = np.radians(np.full(6, 15.0))
SIZE = 400.0
SEED = 6
FIRST_STARTS, MORE_STARTS = 200, (2000, 10000)
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#222222")


# --- forward -----------------------------------------------------------------------------------------------------


def link(i: int, t: float) -> np.ndarray:
    """A_i at the DH angle t."""
    c, s, ca_, sa = np.cos(t), np.sin(t), np.cos(ALPHA[i]), np.sin(ALPHA[i])
    return np.array([[c, -s * ca_, s * sa, A[i] * c], [s, c * ca_, -c * sa, A[i] * s], [0, sa, ca_, D[i]], [0, 0, 0, 1]])


def frames(q: np.ndarray) -> list[np.ndarray]:
    """I, A_1, A_1 A_2, ..., T."""
    chain = [np.eye(4)]
    for i in range(6):
        chain.append(chain[-1] @ link(i, q[i] + OFFSET[i]))
    return chain


def forward(q: np.ndarray) -> np.ndarray:
    return frames(q)[-1]


def pose_error(q: np.ndarray, T: np.ndarray) -> float:
    """Largest difference of a pose's entries, in mm; those of the rotation count times the arm's size."""
    difference = forward(q) - T
    return float(max(SIZE * np.abs(difference[:3, :3]).max(), np.abs(difference[:3, 3]).max()))


# --- closed form -------------------------------------------------------------------------------------------------


def wrap(angles: np.ndarray) -> np.ndarray:
    return (np.asarray(angles) + np.pi) % (2 * np.pi) - np.pi


def shoulders(T: np.ndarray) -> list[float]:
    """q1 from s1 wx - c1 wy = d4, w = p - d6 a the wrist's centre: two values, none where w is within d4 of the axis."""
    wx, wy = T[:2, 3] - D[5] * T[:2, 2]
    ratio = D[3] / np.hypot(wx, wy)
    if ratio > 1.0:
        return []
    return [np.arctan2(wy, wx) + np.arcsin(ratio), np.arctan2(wy, wx) + np.pi - np.arcsin(ratio)]


def wrists(T: np.ndarray) -> list[tuple[float, float, float]]:
    """(q1, q5, q6), up to four."""
    found = []
    for q1 in shoulders(T):
        B = np.linalg.inv(link(0, q1)) @ T
        for q5 in np.arccos(np.clip(B[2, 2], -1, 1)) * np.array([1, -1]):
            sign = np.sign(q5) or 1.0
            found.append((q1, float(q5), float(np.arctan2(-sign * B[2, 1], sign * B[2, 0]))))
    return found


def two_link(M: np.ndarray, t234: float) -> list[tuple[float, float, float]]:
    """(q2, q3, q4) with A_2 A_3 A_4 = M: elbow up and down, none out of reach."""
    x, y = M[0, 3], M[1, 3]
    c3 = (x * x + y * y - A[1] ** 2 - A[2] ** 2) / (2 * A[1] * A[2])
    if abs(c3) > 1.0:
        return []
    found = []
    for t3 in (np.arccos(c3), -np.arccos(c3)):
        t2 = np.arctan2(y, x) - np.arctan2(A[2] * np.sin(t3), A[1] + A[2] * c3)
        found.append((t2 - OFFSET[1], t3 - OFFSET[2], t234 - t2 - t3 - OFFSET[3]))
    return found


def closed_form(T: np.ndarray) -> list[np.ndarray]:
    """All real q with forward(q) = T, up to eight; each is put back and verified against the whole pose."""
    found = []
    for q1, q5, q6 in wrists(T):
        B = np.linalg.inv(link(0, q1)) @ T
        sign = np.sign(q5) or 1.0
        M = B @ np.linalg.inv(link(4, q5) @ link(5, q6))
        for q2, q3, q4 in two_link(M, np.arctan2(-sign * B[1, 2], -sign * B[0, 2])):
            q = wrap(np.array([q1, q2, q3, q4, q5, q6]))
            if pose_error(q, T) < 1e-7:
                found.append(q)
    return found


# --- Jacobian ----------------------------------------------------------------------------------------------------


def symbolic_jacobian(arm: symkin.Mechanism) -> tuple[ca.Function, ca.SX]:
    """J(q), 6 x 6, (angular velocity; velocity of the tool point): column i is joint i's screw carried by the joints
    before it in the product of exponentials, and moved to the tool point."""
    q, moved = ca.SX.sym("q", 6), symkin.Pose(ca.SX([0, 0, 0]), ca.SX([1, 0, 0, 0]))
    columns = []
    for k, (_, joint) in enumerate(arm.joints):
        screw = revolute_screw(ca.SX(ca.DM(joint.point)), ca.SX(ca.DM(joint.axis)))
        columns.append(move_screw(moved, screw))
        moved = moved @ exponential(screw, q[k])
    tool = moved.apply(ca.SX(ca.DM(arm.platform_position)))
    J = ca.horzcat(*(ca.vertcat(s[:3], s[3:] + ca.cross(s[:3], tool)) for s in columns))
    return ca.Function("jacobian", [q], [J], ["q"], ["J"]), J


def difference_jacobian(q: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """The same by central differences of the DH product."""
    columns, R = [], forward(q)[:3, :3]
    for k in range(6):
        e = step * np.eye(6)[k]
        dT = (forward(q + e) - forward(q - e)) / (2 * step)
        W = dT[:3, :3] @ R.T
        columns.append([W[2, 1], W[0, 2], W[1, 0], *dT[:3, 3]])
    return np.array(columns).T


def determinant(q: np.ndarray) -> float:
    """det J = -a2 a3 s3 s5 (a2 c2 + a3 c23 + d5 s234): zero for the elbow stretched, the wrist aligned (axis 6 parallel to axes
    2 to 4), and the meeting point of axes 5 and 6 in the plane of axis 1 that is parallel to axis 2."""
    t = q + OFFSET
    reach = A[1] * np.cos(t[1]) + A[2] * np.cos(t[1] + t[2]) + D[4] * np.sin(t[1] + t[2] + t[3])
    return float(-A[1] * A[2] * np.sin(t[2]) * np.sin(t[4]) * reach)


# --- closed form against multistart ------------------------------------------------------------------------------


def numeric(arm: symkin.Mechanism, T: np.ndarray, starts: int) -> list[tuple[np.ndarray, float]]:
    """(q, condition) of every solution that multistart finds."""
    found = symkin.modes(arm, pose=symkin.Pose.from_matrix(T), starts=starts, seed=SEED)
    return [(np.radians(s.actuated), s.condition) for s in found]


def covered(one: list[np.ndarray], other: list[np.ndarray], tolerances: list[float]) -> bool:
    return all(any(np.abs(wrap(a - b)).max() <= tol for b in other) for a, tol in zip(one, tolerances, strict=True))


def has_twin(q: np.ndarray, solutions: list[np.ndarray]) -> bool:
    """Whether another of the solutions lies within 1e-3 rad of the one nearest to q: a double root is near."""
    gaps = [np.abs(wrap(q - other)).max() for other in solutions]
    nearest = solutions[int(np.argmin(gaps))] if solutions else q
    return any(other is not nearest and np.abs(wrap(nearest - other)).max() < 1e-3 for other in solutions)


def agree(exact: list[np.ndarray], sampled: list[tuple[np.ndarray, float]], T: np.ndarray) -> bool:
    """Both lists are the same set modulo turns, within 1e-10 rad times the condition. Where two closed-form solutions
    lie within 1e-3 rad, the numeric ones there need only be within 1e-2 rad; all are judged by their residual."""
    found = [q for q, _ in sampled]
    condition = [max((c for q, c in sampled if np.abs(wrap(a - q)).max() < 1e-2), default=1.0) for a in exact]
    forth = [1e-2 if has_twin(a, exact) else 1e-10 * c for a, c in zip(exact, condition, strict=True)]
    back = [1e-2 if has_twin(q, exact) else 1e-10 * c for q, c in sampled]
    counted = len(found) == len(exact) or any(has_twin(a, exact) for a in exact)
    closed = all(pose_error(q, T) < 1e-6 for q in found)
    return counted and closed and covered(exact, found, forth) and covered(found, exact, back)


def compare(arm: symkin.Mechanism, poses: list[np.ndarray]) -> tuple[int, int]:
    """(poses where the two agree, poses that needed more than the first number of starts)."""
    equal = again = 0
    for T in poses:
        exact = closed_form(T)
        same = agree(exact, numeric(arm, T, FIRST_STARTS), T)
        again += not same
        equal += same or any(agree(exact, numeric(arm, T, n), T) for n in MORE_STARTS)
    return equal, again


def random_poses(count: int) -> list[np.ndarray]:
    rng = np.random.default_rng(SEED)
    return [forward(q) for q in rng.uniform(-np.pi, np.pi, (count, 6))]


# --- picture -----------------------------------------------------------------------------------------------------


def draw_arms(axes, T: np.ndarray, title: str) -> None:
    paths = [np.array([F[:3, 3] for F in frames(q)]) for q in closed_form(T)]
    for path, colour in zip(paths, COLOURS, strict=False):
        axes.plot(*path.T, "-o", color=colour, lw=2.4, ms=3.5, solid_capstyle="round")
    tool, points = T[:3, 3], np.vstack(paths)
    for direction, colour in zip(T[:3, :3].T, ("#d62728", "#2ca02c", "#1f77b4"), strict=True):
        axes.quiver(*tool, *(60 * direction), color=colour, lw=1.4)
    axes.plot(*tool, "k*", ms=10)
    axes.plot([0, 0], [0, 0], [-25, 5], color="0.4", lw=10, solid_capstyle="butt")
    middle, half = (points.max(0) + points.min(0)) / 2, 0.55 * np.ptp(points, axis=0).max()
    low, high = middle - half, middle + half
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]), box_aspect=(1, 1, 1))
    axes.set(xlabel="x [mm]", ylabel="y [mm]", title=title)
    axes.zaxis.set_rotate_label(False)
    axes.set_zlabel("z [mm]", labelpad=8, rotation=90)
    axes.locator_params(nbins=5)
    axes.view_init(18, -115)


def draw(counts: np.ndarray):
    figure = new_figure(16, 5.6)
    figure.suptitle("Gluon-6L3: the inverse problem in closed form", fontsize=14)
    grid = figure.add_gridspec(1, 3, width_ratios=(1.15, 1.15, 1))
    eight = next(T for T in random_poses(50) if len(closed_form(T)) == 8)
    draw_arms(figure.add_subplot(grid[0], projection="3d"), forward(EXAMPLE), "15° at every joint: 2 solutions")
    draw_arms(figure.add_subplot(grid[1], projection="3d"), eight, "a random pose: 8 solutions")
    axes = figure.add_subplot(grid[2])
    share = [100 * np.mean(counts == n) for n in (2, 4, 6, 8)]
    bars = axes.bar(["2", "4", "6", "8"], share, color=COLOURS[0], width=0.6)
    axes.bar_label(bars, fmt="%.1f %%", padding=3)
    axes.set(xlabel="number of real solutions", ylabel="share of poses [%]", ylim=(0, 1.12 * max(share)))
    axes.set_title(f"{len(counts)} poses of random joint angles")
    axes.spines[["top", "right"]].set_visible(False)
    return figure


# --- study -------------------------------------------------------------------------------------------------------


def report_example(report: Report, arm: symkin.Mechanism) -> None:
    T = forward(EXAMPLE)
    own = symkin.solve(arm, joints=[15.0] * 6).solution
    report.row("tool position at 15 degrees each", None, T[:3, 3], "mm")
    report.row("symkin's forward less the DH product", None, float(np.abs(own.pose.matrix - T).max()), "mm")
    for k, q in enumerate(closed_form(T), start=1):
        report.row(f"inverse, closed form, solution {k}", [15.0] * 6 if k == 1 else None, np.degrees(q), "deg")
    for solver, start in (("newton", [10.0, 10.0, 20.0, 10.0, 20.0, 10.0]), ("ipopt", [0.0, 20.0, 0.0, 20.0, 0.0, 0.0])):
        result = symkin.solve(arm, pose=own.pose, solver=solver, start=start)
        report.row(f"inverse, {solver}, {result.iterations} steps from {start}", None, result.solution.actuated, "deg")
    report.row("inverse by multistart, 2000 starts: solutions", None, len(numeric(arm, T, 2000)))


def third_row_errors(T: np.ndarray, *, principal: bool) -> list[float]:
    """How far each (q1, q5, q6) misses [3,1] and [3,2] of A_1^-1 T; `principal`: q6 by arctan of the quotient."""
    errors = []
    for q1, q5, q6 in wrists(T):
        B = np.linalg.inv(link(0, q1)) @ T
        angle = np.arctan(np.tan(q6)) if principal else q6
        errors.append(float(np.hypot(B[2, 0] - np.sin(q5) * np.cos(angle), B[2, 1] + np.sin(q5) * np.sin(angle))))
    return errors


def report_wrist_check(report: Report) -> None:
    """The page: 'check with [3,1] and [3,2]; here three of the four q1, q5, q6 are excluded'."""
    T = forward(EXAMPLE)
    full, principal = third_row_errors(T, principal=False), third_row_errors(T, principal=True)
    left = sum(e < 1e-9 for e in full), sum(e < 1e-9 for e in principal)
    reach = len({round(q[0], 6) + 1j * round(q[4], 6) for q in closed_form(T)})
    report.row("(q1, q5, q6) left by the check of [3,1], [3,2]", 1, left[0])
    report.row("(q1, q5, q6) left by the reach of the two-link", None, reach)
    text = (
        f"the check of elements [3,1] and [3,2] does not exclude three of the four (q1, q5, q6): {left[0]} pass it with q6 by atan2 "
        f"({left[1]} with q6 by arctan); that {reach} remains follows from the reach of links 2 and 3 alone."
    )
    report.erratum(text, shown=left == (4, 2) and reach == 1)


def report_jacobian(report: Report, arm: symkin.Mechanism) -> None:
    jacobian, J = symbolic_jacobian(arm)
    rng = np.random.default_rng(SEED)
    samples = rng.uniform(-np.pi, np.pi, (200, 6))
    away = max(np.abs(np.asarray(jacobian(q)) - difference_jacobian(q)).max() for q in samples)
    ratios = [np.linalg.det(np.asarray(jacobian(q))) / determinant(q) for q in samples]
    report.row("symbolic Jacobian: shape, operations", None, [*J.shape, jacobian.n_instructions()])
    report.row("symbolic Jacobian less central differences, 200 poses", None, float(away), "mm")
    report.row("det J / (-a2 a3 s3 s5 (a2 c2 + a3 c23 + d5 s234)): least, most", None, [min(ratios), max(ratios)])
    stretched = np.asarray(jacobian(np.array([0.3, 0.4, 0.0, 0.5, 0.6, 0.7])))
    report.row("rank of J with q3 = 0 (elbow stretched)", None, int(np.linalg.matrix_rank(stretched, tol=1e-9)))


def report_random(report: Report, arm: symkin.Mechanism, count: int) -> np.ndarray:
    begin = time.perf_counter()
    equal, again = compare(arm, random_poses(count))
    report.row(f"random poses where closed form = multistart, of {count}", None, equal)
    report.row(f"poses that needed more than {FIRST_STARTS} starts ({', '.join(map(str, MORE_STARTS))})", None, again)
    twins = sum(any(has_twin(q, solutions) for q in solutions) for solutions in map(closed_form, random_poses(count)))
    report.row("poses with two solutions within 1e-3 rad, where residuals decide", None, twins)
    report.row("time of the comparison", None, round(time.perf_counter() - begin, 1), "s")
    counts = np.array([len(closed_form(T)) for T in random_poses(2 * count)])
    report.row(
        f"2, 4, 6, 8 real solutions, {2 * count} poses", None, [100 * float(np.mean(counts == n)) for n in (2, 4, 6, 8)], "%"
    )
    return counts


def main() -> None:
    parser = options_parser(__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=1000, help="random poses compared (default: 1000)")
    options = parser.parse_args()
    arm = symkin.load("gluon_6l3")
    report = Report("gluon_6l3", "Gluon-6L3: forward and inverse kinematics, Jacobian", SEED)
    report_example(report, arm)
    report_wrist_check(report)
    report_jacobian(report, arm)
    counts = report_random(report, arm, options.poses)
    report.finish(draw(counts), options.output)


if __name__ == "__main__":
    main()
