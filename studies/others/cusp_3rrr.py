"""Planar 3-RRR: a path of inputs around a cusp that changes the assembly mode and meets no
singularity.

Notation: base joints b_i on a circle of 100 at 90, 210, 330 degrees, platform joints c_i on one of
30, links 60 and 65; inputs q_i, the directions of the first links; pose X = (x, y, phi); elbows
e_i = b_i + 60 (cos q_i, sin q_i):

    f_i(X, q) = |(x, y) + R(phi) c_i - e_i|^2 - 65^2 = 0,   i = 1, 2, 3.

In a slice q_3 = constant the type 2 singularities, det A = 0 with A = dF/dX, are a curve of (q_1,
q_2) with cusps, where three assembly modes meet. With A v = 0, n A = 0, |v| = 1 a cusp satisfies n
d2F(v, v) = 0 (a triple root): F = 0, A v = 0, v.v = 1 and this are eight equations in (X, v, q_1,
q_2), solved here by Newton's method beside the cusp that symkin finds on its traced locus. As
adj(A) is v n times a number, sum over k of v_k det(A with column k replaced by d2F(v, v)) is n
d2F(v, v) times it. A path around the cusp leaves the wedge through one of its sides, on which two
other modes merge, and comes back through the other one: it begins and ends at the same inputs, on
two assembly modes, without det A = 0 on the way (Innocenti and Parenti-Castelli 1998, McAree and
Daniel 1999 for the 3-RPR).

Angles in radians inside, degrees where printed; lengths have no unit. The column `paper` holds what
the law demands.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import casadi as ca
import numpy as np

import symkin
from symkin.following.track import track
from symkin.plots.loci_plot import draw_curves
from symkin.position.solution import Solution
from symkin.singularities.loci import Loci
from symkin.singularities.singular_loci import singular_loci

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, new_figure, of_all_modes, options_parser

BASE_RADIUS, PLATFORM_RADIUS, LINKS = 100.0, 30.0, (60.0, 65.0)
TOWARDS = np.radians([90.0, 210.0, 330.0])
BASE, PLATFORM = (
    r * np.column_stack([np.cos(TOWARDS), np.sin(TOWARDS)]) for r in (BASE_RADIUS, PLATFORM_RADIUS)
)
SEED, RADIUS, SAMPLES = 8, math.radians(2.0), 720
"""RADIUS is that of the circle of inputs about the cusp, SAMPLES how many steps it is cut into."""
BLUE, RED = "#0072b2", "#d55e00"


# --- the mechanism and its equations --------------------------------------------------------------


def elbow_angle(k: int) -> float:
    """Direction of first link k with the platform in the middle, the elbow on the left of base
    joint -> platform joint.
    """
    along = PLATFORM[k] - BASE[k]
    length = float(np.linalg.norm(along))
    lean = math.acos((length**2 + LINKS[0] ** 2 - LINKS[1] ** 2) / (2 * length * LINKS[0]))
    return math.atan2(along[1], along[0]) + lean


def mechanism() -> symkin.Mechanism:
    limbs = []
    for k in range(3):
        zero = elbow_angle(k)
        elbow = BASE[k] + LINKS[0] * np.array([math.cos(zero), math.sin(zero)])
        places = [(f"q{k + 1}", BASE[k]), (f"elbow{k + 1}", elbow), (f"c{k + 1}", PLATFORM[k])]
        joints = [
            symkin.Joint(
                name, "R", (*p, 0.0), (0, 0, 1), actuated=i == 0, zero=zero if i == 0 else 0.0
            )
            for i, (name, p) in enumerate(places)
        ]
        limbs.append(symkin.Limb(f"limb{k + 1}", joints))
    return symkin.Mechanism(
        "three_rrr", limbs, motion="planar", angle_unit="deg", title="planar 3-RRR"
    )


X, Q, V = ca.SX.sym("X", 3), ca.SX.sym("q", 3), ca.SX.sym("v", 3)


def closure() -> ca.SX:
    """F over 2 * 65 (a length), written independently of symkin's closure."""
    c, s = ca.cos(X[2]), ca.sin(X[2])
    rows = []
    for k in range(3):
        (cx, cy), (bx, by) = PLATFORM[k], BASE[k]
        dx = X[0] + c * cx - s * cy - bx - LINKS[0] * ca.cos(Q[k])
        dy = X[1] + s * cx + c * cy - by - LINKS[0] * ca.sin(Q[k])
        rows.append((dx * dx + dy * dy - LINKS[1] ** 2) / (2 * LINKS[1]))
    return ca.vertcat(*rows)


UNITS = np.array([1.0, 1.0, 1.0 / PLATFORM_RADIUS])
SCALE = ca.DM(UNITS)
"""Turns are measured at the platform's circle, so that v has one unit."""
F = closure()
A = ca.jacobian(F, X) @ ca.diag(SCALE)
CONVERGED = 1e-10 * PLATFORM_RADIUS
"""Newton's steps converge quadratically: after one below this the next would be rounding."""
SECOND = ca.jacobian(A @ V, X) @ ca.diag(SCALE) @ V
"""d2F(v, v)."""
EVALUATE = ca.Function("F_A", [X, Q], [F, A])


def newton_pose(pose: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The pose near another one that closes the loops at q."""
    for _ in range(8):
        f, a = (v.full() for v in EVALUATE(pose, q))
        step = np.linalg.solve(a, f[:, 0])
        pose = pose - UNITS * step
        if np.max(np.abs(step)) < CONVERGED:
            break
    return pose


def sign(pose: np.ndarray, q: np.ndarray) -> float:
    return float(np.linalg.det(np.asarray(EVALUATE(pose, q)[1])))


# --- cusps ----------------------------------------------------------------------------------------


def cusp_system() -> tuple[ca.Function, ca.Function]:
    """Eight equations in z = (X, v, q_1, q_2) with q_3 given, and their Jacobian."""
    columns = [ca.horzcat(*(SECOND if j == k else A[:, j] for j in range(3))) for k in range(3)]
    last = sum(V[k] * ca.det(columns[k]) for k in range(3))
    rows = ca.vertcat(F / PLATFORM_RADIUS, A @ V, (ca.dot(V, V) - 1) / 2, last)
    unknown = ca.vertcat(X, V, Q[:2])
    rates = ca.jacobian(rows, unknown)
    return ca.Function("rows", [unknown, Q[2]], [rows]), ca.Function(
        "rates", [unknown, Q[2]], [rates]
    )


def newton_cusp(start: np.ndarray, q3: float) -> tuple[np.ndarray, float, int]:
    """(z, largest row, steps) from a start, by Newton's method."""
    rows, rates = cusp_system()
    z, steps = start, 0
    while steps < 30:
        step = np.linalg.solve(np.asarray(rates(z, q3)), np.asarray(rows(z, q3)).ravel())
        z, steps = z - step, steps + 1
        if np.abs(step / np.array([100, 100, 1, 1, 1, 1, 1, 1])).max() < 1e-14:
            break
    return z, float(np.abs(np.asarray(rows(z, q3))).max()), steps


@dataclass(frozen=True, eq=False)
class Cusp:
    """Pose, null vector v and inputs (radians) of a cusp; `traced` are the inputs as found on the
    locus.
    """

    pose: np.ndarray
    v: np.ndarray
    q: np.ndarray
    largest_row: float
    steps: int
    traced: np.ndarray


def refine(loci: Loci, q3: float) -> list[Cusp]:
    """Every cusp of the traced locus by Newton's method on the eight equations, from the traced
    point rounded to 1e-3.
    """
    found = []
    for curve in loci.of("type 2"):
        for traced in np.radians(curve.cusps):
            near = int(np.argmin(np.linalg.norm(np.radians(curve.points) - traced, axis=1)))
            place = {name: k for k, name in enumerate(curve.names)}
            pose = np.array(
                [curve.configurations[near, place[f"pose.{name}"]] for name in ("x", "y", "gamma")]
            )
            v = np.linalg.svd(np.asarray(EVALUATE(pose, [*traced, q3])[1]))[2][-1]
            z, row, steps = newton_cusp(np.round(np.concatenate([pose, v, traced]), 3), q3)
            found.append(Cusp(z[:3], z[3:6], np.array([*z[6:], q3]), row, steps, traced))
    return found


# --- a path around it -----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Loop:
    """A circle of inputs (n, 3), the poses (n, 3) along it and det A (n,); it begins and ends at
    the same inputs.
    """

    cusp: Cusp
    q: np.ndarray
    poses: np.ndarray
    determinants: np.ndarray
    longest_step: float

    @property
    def changes_mode(self) -> bool:
        return bool(
            np.linalg.norm(self.poses[-1, :2] - self.poses[0, :2]) > 1e-3
            and np.ptp(np.sign(self.determinants)) == 0
        )


def circle(cusp: Cusp, begin: float, number: int = SAMPLES) -> np.ndarray:
    turn = begin + np.linspace(0.0, 2 * math.pi, number + 1)
    around = RADIUS * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(number + 1)])
    return np.asarray(cusp.q + around)


def modes_at(platform: symkin.Mechanism, q: np.ndarray) -> tuple[list[np.ndarray], str]:
    """All poses (x, y, phi) of inputs by complete enumeration, and its statement."""
    found = symkin.modes(platform, joints=np.degrees(q))
    return [pose_numbers(mode) for mode in found], found.completeness


def into_wedge(platform: symkin.Mechanism, cusp: Cusp) -> float | None:
    """The angle on the circle in the middle of the arc on which the three modes that meet in the
    cusp are real.
    """
    turns = np.linspace(0, 2 * math.pi, 90, endpoint=False)
    near = []
    for turn in turns:
        poses, _ = modes_at(platform, circle(cusp, turn, 1)[0])
        near.append(sum(gap(pose, cusp.pose) < 0.6 * PLATFORM_RADIUS for pose in poses) >= 3)
    inside = np.flatnonzero(near)
    if not len(inside) or len(inside) > 45:
        return None
    middle = np.angle(np.mean(np.exp(1j * turns[inside])))
    return float(middle)


def gap(one: np.ndarray, other: np.ndarray) -> float:
    """How far poses are apart, turns at the platform's circle."""
    turn = math.remainder(one[2] - other[2], 2 * math.pi)
    return math.hypot(one[0] - other[0], one[1] - other[1], PLATFORM_RADIUS * turn)


def follow(cusp: Cusp, q: np.ndarray, start: np.ndarray) -> Loop:
    """The branch through a start along inputs: Newton from each pose to the next, the predictor
    along dX/dq.
    """
    poses, determinants, longest = [start], [sign(start, q[0])], 0.0
    for before, now in pairwise(q):
        middle = newton_pose(poses[-1], 0.5 * (before + now))
        pose = newton_pose(middle, now)
        longest = max(longest, gap(pose, middle), gap(middle, poses[-1]))
        poses.append(pose)
        determinants.append(sign(pose, now))
    return Loop(cusp, q, np.array(poses), np.array(determinants), longest)


def loops(platform: symkin.Mechanism, cusp: Cusp) -> list[Loop]:
    """Both senses, from each of the modes that meet in the cusp."""
    begin = into_wedge(platform, cusp)
    if begin is None:
        return []
    q = circle(cusp, begin)
    starts = [
        pose for pose in modes_at(platform, q[0])[0] if gap(pose, cusp.pose) < 0.6 * PLATFORM_RADIUS
    ]
    found = [follow(cusp, path, start) for start in starts for path in (q, q[::-1])]
    return [
        loop
        for loop in found
        if np.all(np.isfinite(loop.poses)) and loop.changes_mode and loop.longest_step < 1.0
    ]


# --- report ---------------------------------------------------------------------------------------


def report_cusps(report: Report, cusps: list[Cusp]) -> None:
    for k, cusp in enumerate(cusps, start=1):
        report.row(
            f"cusp {k}: q1, q2 by Newton on the eight equations, {cusp.steps} steps",
            None,
            np.degrees(cusp.q[:2]).tolist(),
            "deg",
        )
        report.row(
            f"cusp {k}: pose x, y, phi",
            None,
            [*cusp.pose[:2].tolist(), math.degrees(cusp.pose[2])],
            "-, -, deg",
        )
        report.row(f"cusp {k}: largest of the eight equations", 0.0, cusp.largest_row)
        report.row(
            f"cusp {k}: on the traced locus less by Newton, largest",
            0.0,
            float(np.abs(cusp.traced - cusp.q[:2]).max()),
            "rad",
        )
        a = np.asarray(EVALUATE(cusp.pose, cusp.q)[1])
        singular = np.linalg.svd(a, compute_uv=False)
        report.row(
            f"cusp {k}: singular values of A, largest, second, last", None, singular.tolist()
        )


def report_loop(report: Report, platform: symkin.Mechanism, loop: Loop) -> None:
    start, statement = modes_at(platform, loop.q[0])
    end, _ = modes_at(platform, loop.q[-1])
    report.row(
        "inputs at the start and at the end of the path, difference",
        0.0,
        float(np.abs(loop.q[0] - loop.q[-1]).max()),
        "rad",
    )
    report.row(
        "assembly modes there, by complete enumeration", None, [len(start), len(end), statement]
    )
    signs = np.sign(loop.determinants)
    report.row(
        "sign of det A along the path: least, largest",
        [float(signs[0])] * 2,
        [float(signs.min()), float(signs.max())],
    )
    report.row(
        "|det A| along the path: least, largest",
        None,
        [float(np.abs(loop.determinants).min()), float(np.abs(loop.determinants).max())],
    )
    report.row(
        f"longest step of the pose between {2 * SAMPLES} samples, turns at the platform's circle",
        None,
        loop.longest_step,
    )
    report.row(
        "pose at the start", None, [*loop.poses[0, :2], math.degrees(loop.poses[0, 2])], "-, -, deg"
    )
    report.row(
        "pose at the end", None, [*loop.poses[-1, :2], math.degrees(loop.poses[-1, 2])], "-, -, deg"
    )
    first, last = (
        min(range(len(start)), key=lambda k: gap(start[k], pose)) + 1
        for pose in (loop.poses[0], loop.poses[-1])
    )
    report.row("number of the mode at the start, at the end", None, [first, last])
    report.row("these are different modes", True, first != last)
    misses = [
        min(gap(pose, mode) for mode in modes)
        for pose, modes in ((loop.poses[0], start), (loop.poses[-1], end))
    ]
    report.row("both are among the enumerated modes: largest miss", 0.0, max(misses))


def report_tracked(report: Report, platform: symkin.Mechanism, loop: Loop) -> None:
    """Back along the same path the branch returns to where it began; symkin's tracker proves that
    it is one branch.
    """
    back = follow(loop.cusp, loop.q[::-1], loop.poses[-1])
    report.row("followed back, miss of the start", 0.0, gap(back.poses[-1], loop.poses[0]))
    thirds = [np.linspace(a, b, 4)[1:] for a, b in pairwise(loop.q)]
    finer = follow(loop.cusp, np.vstack([loop.q[0], *thirds]), loop.poses[0])
    report.row(
        "followed with steps of a third, miss of the end", 0.0, gap(finer.poses[-1], loop.poses[-1])
    )
    rows = np.degrees(loop.q[:: SAMPLES // 72])
    start = min(
        symkin.modes(platform, joints=rows[0]),
        key=lambda mode: gap(pose_numbers(mode), loop.poses[0]),
    )
    tracked = track(platform, joints=rows, start=start)
    report.row(
        "symkin's tracker on the polygon of 72 sides: reached the end, certified",
        [True, True],
        [tracked.stop is None, tracked.certified],
    )
    report.row(
        "its end, miss of the end",
        0.0,
        gap(pose_numbers(tracked.samples[-1].solution), loop.poses[-1]),
    )


def pose_numbers(mode: Solution) -> np.ndarray:
    return np.array([mode.values[f"pose.{name}"] for name in ("x", "y", "gamma")])


def draw(loci: Loci, loop: Loop):
    figure = new_figure(15.5, 5.6)
    figure.suptitle(
        "Planar 3-RRR: a path around a cusp changes the assembly mode without a singularity",
        fontsize=14,
        weight="bold",
    )
    whole, zoom, sheet = figure.subplots(1, 3)
    q = np.degrees(loop.q)
    centre = np.degrees(loop.cusp.q[:2])
    for axes in (whole, zoom):
        draw_curves(axes, of_all_modes(loci))
        axes.plot(q[:, 0], q[:, 1], color=RED, lw=1.6, label="path")
    whole.set_title(f"type 2 locus, q3 = {np.degrees(loop.cusp.q[2]):.4g}°")
    half = 1.6 * math.degrees(RADIUS)
    zoom.set(
        xlim=(centre[0] - half, centre[0] + half),
        ylim=(centre[1] - half, centre[1] + half),
        title="around the cusp",
    )
    zoom.plot(*q[0, :2], "o", color=RED, ms=7)
    for k in (len(q) // 8, len(q) // 2):
        zoom.annotate(
            "", q[k + 8, :2], q[k, :2], arrowprops={"arrowstyle": "->", "color": RED, "lw": 1.8}
        )
    turn = np.linspace(0, 360, len(q))
    sheet.plot(turn, np.degrees(loop.poses[:, 2]), color=BLUE, lw=1.8, label="phi")
    sheet.set(
        xlabel="angle on the path [deg]",
        ylabel="phi [deg]",
        xlim=(0, 360),
        xticks=range(0, 361, 90),
        title="the platform's turn, and det A",
    )
    sheet.plot([0, 360], np.degrees(loop.poses[[0, -1], 2]), "o", color=BLUE)
    other = sheet.twinx()
    other.plot(turn, loop.determinants, color="0.45", lw=1.2)
    other.axhline(0.0, color="0.7", lw=0.8)
    other.set_ylabel("det A", color="0.35")
    return figure


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    options = parser.parse_args()
    platform = mechanism()
    report = Report(
        "cusp_3rrr", "Planar 3-RRR: cusps of the type 2 locus and a mode-changing path", SEED
    )
    solution = symkin.solve(
        platform, joints=[platform.angle_out(c.reference[0]) for c in platform.actuated]
    ).solution
    loci = singular_loci(solution, ("q1", "q2"), kinds=("type 2",), starts=60, seed=SEED)
    cusps = refine(loci, float(solution.values["q3"]))
    report.row("cusps in the slice of q1, q2", None, len(cusps))
    report_cusps(report, cusps)
    loop = next((found for cusp in cusps for found in loops(platform, cusp)), None)
    if loop is None:
        raise SystemExit("cusp_3rrr: no path around a cusp changes the mode")
    report_loop(report, platform, loop)
    report_tracked(report, platform, loop)
    report.finish(draw(loci, loop), options.output)


if __name__ == "__main__":
    main()
