"""Wrist-offset telescopic Pieper robot, 5R1P: the paper's search for L6 with successive return of the axes, and all roots.

Notation (global frame, initial position): axes 1, 2, 3 through O along z, y, x; F = (-a1, 0, 0) on axis 4 (along y);
E = (-a1-a2, 0, 0) on axis 5 (along z); D = E + (0, 0, d1); tool tip A = D - (a3, 0, 0); joint 6 slides along +x by L6. A
point passes joint 6 first and joint 1 last, so that

    A = F + R123 (...),   R = R123 Ry(theta4) Rz(theta5),   R123 = Rz(theta1) Ry(theta2) Rx(theta3).

Return of the axes: with u, v, w the columns x, z, y of R and e = R^T E0, undoing joint 6 gives E1 = E0 - L6 u; O, F and
axis 5 lie in one plane, which gives theta5 = atan2(s e_y, -s (e_x - L6)), s = 1 (F between the axis and O) or -1, and

    f(L6) = |OF2| - a1,   |OF2|^2 = (h - s a2)^2 + e_z^2,   h^2 = (e_x - L6)^2 + e_y^2 (distance of O from axis 5).

So f falls until L6 = e_x and rises after it where h > s a2: its roots are isolated by h = s a2 +- sqrt(a1^2 - e_z^2).
Units: mm, deg. Source: Yao Haifeng et al., Journal of Mining Science and Technology 5(6), 2020.
The lengths a1, a2, a3, d1 are not printed; they follow from the worked example's points D0, E0, F0 and its answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

import symkin
from report import Report, folder_from_arguments, new_figure
from symkin.spatial.rotation import quaternion_from_euler

A1, A2, A3, D1 = 300.0, 85.0, 160.0, 105.0
TIP = np.array([-507.4063, 89.8079, 69.4402])
ANGLES = (20.0, -15.0, 25.0)
D0, E0, F0 = (-367.3381, 155.1228, 110.8512), (-359.3707, 198.4627, 15.5455), (-284.9595, 233.1612, 37.5452)
PRINTED = (-35.5954, 2.7289, 22.5392, 7.7657, 62.2462, -51.556)
INTERVAL, TOLERANCE = (-500.0, 0.0), 1e-8
SEED = 5
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
Function = Callable[[float], float]


# --- forward -----------------------------------------------------------------------------------------------------


def turn(axis: str, degrees: float) -> np.ndarray:
    """Rx, Ry or Rz."""
    c, s, i = math.cos(math.radians(degrees)), math.sin(math.radians(degrees)), "xyz".index(axis)
    R, j, k = np.eye(3), (i + 1) % 3, (i + 2) % 3
    R[j, j] = R[k, k] = c
    R[j, k], R[k, j] = -s, s
    return R


def skeleton(joints: np.ndarray, a1: float = A1) -> tuple[np.ndarray, np.ndarray]:
    """Points O, F, E, D, A (rows) and the tool's rotation for (theta1..5 in degrees, L6): one turn after another, the
    joint nearest the tool first."""
    initial = [np.array([-A3, 0, 0.0]), np.zeros(3), np.array([0, 0, -D1])]
    A, D, E = (p + [joints[5] * (k == 0), 0, 0] for k, p in enumerate(initial))
    A, D, E = (turn("z", joints[4]) @ (p + [0, 0, D1]) - [A2, 0, 0] for p in (A, D, E))
    A, D, E = (turn("y", joints[3]) @ p - [a1, 0, 0] for p in (A, D, E))
    arm = turn("z", joints[0]) @ turn("y", joints[1]) @ turn("x", joints[2])
    points = np.array([np.zeros(3), [-a1, 0, 0], E, D, A]) @ arm.T
    return points, arm @ turn("y", joints[3]) @ turn("z", joints[4])


def tip(joints: np.ndarray, a1: float = A1) -> np.ndarray:
    return skeleton(joints, a1)[0][4]


def goal_rotation() -> np.ndarray:
    """Rz(25) Ry(-15) Rx(20)."""
    return turn("z", ANGLES[2]) @ turn("y", ANGLES[1]) @ turn("x", ANGLES[0])


# --- the search for L6 -------------------------------------------------------------------------------------------


def axis5_origin(A: np.ndarray, R: np.ndarray) -> np.ndarray:
    """e = R^T E0: the goal's point E in the tool's axes."""
    return R.T @ A + [A3, 0, -D1]


def distance_function(A: np.ndarray, R: np.ndarray, s: int = 1, a1: float = A1) -> Function:
    """f(L6) = |OF2| - a1 of the paper: joint 6 undone by L6, joint 5 undone by the angle between the planes A D E and
    O axis 5. |OF2| is computed from the points, as the paper does."""

    def f(slide: float) -> float:
        theta5 = fifth(A, R, s, slide)
        E1 = R @ (axis5_origin(A, R) - [slide, 0, 0])
        F2 = E1 + R @ turn("z", -theta5) @ [A2, 0, 0]
        return float(np.linalg.norm(F2)) - a1

    return f


def fifth(A: np.ndarray, R: np.ndarray, s: int, slide: float) -> float:
    e = axis5_origin(A, R)
    return math.degrees(math.atan2(s * e[1], -s * (e[0] - slide)))


def isolated_roots(A: np.ndarray, R: np.ndarray, s: int = 1, a1: float = A1) -> list[float]:
    """All roots of f: h takes at most two values, each at two L6 mirrored at e_x. They only place the brackets; each
    root is then the paper's search to 1e-12, by bisection and secant."""
    e, f, roots = axis5_origin(A, R), distance_function(A, R, s, a1), []
    if abs(e[2]) >= a1:
        return []
    heights = [s * A2 + sign * math.sqrt(a1**2 - e[2] ** 2) for sign in (1, -1)]
    for h in (h for h in heights if h > abs(e[1])):
        away, gap = math.sqrt(h * h - e[1] ** 2), 1e-3
        roots += [bracketed(f, e[0] + side * away - gap, e[0] + side * away + gap) for side in (-1, 1)]
    return roots


def bracketed(f: Function, low: float, high: float, tolerance: float = 1e-12) -> float:
    """Root of f in [low, high] by the Illinois secant: the end that stays counts half."""
    f_low, f_high = f(low), f(high)
    if f_low * f_high > 0:
        raise SystemExit(f"yao2020: no change of sign in [{low}, {high}]: {f_low}, {f_high}")
    x = low
    for _ in range(100):
        x = high - f_high * (high - low) / (f_high - f_low)
        value = f(x)
        if abs(value) <= tolerance:
            break
        low, f_low = (high, f_high) if value * f_high < 0 else (low, 0.5 * f_low)
        high, f_high = x, value
    return x


def paper_search(f: Function, order: str) -> tuple[float, int]:
    """The printed loop on [-500, 0] to 1e-8. `order`: which test is made first, 'left' (f_min f_mid < 0) or 'right';
    'both': one after the other with the same values, as printed. Returns L6 and the steps made."""
    (low, high), steps = INTERVAL, 0
    for steps in range(1, 201):  # noqa: B007 - the last value is returned
        middle = 0.5 * (low + high)
        at_low, at_middle, at_high = f(low), f(middle), f(high)
        left, right = at_low * at_middle < 0, at_middle * at_high < 0
        if abs(at_middle) < TOLERANCE or not (left or right):
            break
        take_left = left and (order != "right" or not right)
        take_right = right and (order != "left" or not left)
        low, high = (middle if take_right else low), (middle if take_left else high)
    return middle, steps


# --- return of the axes ------------------------------------------------------------------------------------------


def returned(A: np.ndarray, R: np.ndarray, slide: float, s: int) -> list[np.ndarray]:
    """theta1 to theta4 for a root: joints 6, 5, 1, 2, 3, 4 are undone in turn; theta1 has two values."""
    theta5 = fifth(A, R, s, slide)
    R4 = R @ turn("z", -theta5)
    F = R @ (axis5_origin(A, R) - [slide, 0, 0]) + R4 @ [A2, 0, 0]
    found = []
    for side in (1, -1):
        theta1 = degrees2(-side * F[1], -side * F[0])
        G, back = turn("z", -theta1) @ F, turn("z", -theta1) @ R4
        theta2 = degrees2(G[2], -G[0])
        back = turn("y", -theta2) @ back
        theta3 = degrees2(back[2, 1], back[1, 1])
        back = turn("x", -theta3) @ back
        found.append(np.array([theta1, theta2, theta3, degrees2(back[0, 2], back[0, 0]), theta5, slide]))
    return found


def degrees2(y: float, x: float) -> float:
    return math.degrees(math.atan2(y, x))


def inverse(A: np.ndarray, R: np.ndarray) -> list[np.ndarray]:
    """All real solutions, up to eight, each verified against the pose; the branch of the paper's answer first."""
    found = [q for s in (1, -1) for slide in isolated_roots(A, R, s) for q in returned(A, R, slide, s)]
    verified = [q for q in found if np.abs(tip(q) - A).max() < 1e-7 and np.abs(skeleton(q)[1] - R).max() < 1e-9]
    return sorted(verified, key=lambda q: (-round(q[5], 6), abs(q[0])))


# --- study -------------------------------------------------------------------------------------------------------


def report_lengths(report: Report) -> float:
    """a2, a3, d1 from the printed points; a1 by the printed answer, least squares over the tip."""
    a, d, e, f = TIP, *map(np.array, (D0, E0, F0))
    report.row("a3, d1, a2 from the printed D0, E0, F0", None, [math.dist(a, d), math.dist(d, e), math.dist(e, f)], "mm")
    direction = tip(np.array(PRINTED), 1.0) - tip(np.array(PRINTED), 0.0)
    a1 = A1 + float(direction @ (TIP - tip(np.array(PRINTED))))
    report.row("a1 from the printed answer and A", None, a1, "mm")
    return a1


def same(a: np.ndarray, b: np.ndarray) -> bool:
    """Equal joint values to 1e-6, angles modulo turns."""
    gap = a - b
    gap[:5] = (gap[:5] + 180) % 360 - 180
    return bool(np.abs(gap).max() < 1e-6)


def matches(one: list[np.ndarray], other: list[np.ndarray]) -> bool:
    return len(one) == len(other) and all(any(same(a, b) for b in other) for a in one)


def numeric(robot: symkin.Mechanism, A: np.ndarray, R: np.ndarray) -> list[np.ndarray]:
    T = np.block([[R, A[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])
    return [np.array(s.actuated) for s in symkin.modes(robot, pose=symkin.Pose.from_matrix(T), seed=SEED)]


def report_solutions(report: Report, robot: symkin.Mechanism) -> list[np.ndarray]:
    solutions = inverse(TIP, goal_rotation())
    for k, q in enumerate(solutions, start=1):
        report.row(f"inverse, solution {k}: theta1..5, L6", list(PRINTED) if k == 1 else None, q, "deg, mm")
    general = numeric(robot, TIP, goal_rotation())
    report.row("solutions by return of the axes, by multistart", None, [len(solutions), len(general)])
    report.row("both sets equal to 1e-6", None, str(matches(solutions, general)))
    pose = symkin.Pose(TIP, quaternion_from_euler(np.radians(ANGLES), "xyz"))
    near = symkin.solve(robot, pose=pose, start=list(PRINTED))
    report.row(
        f"symkin.solve from the printed answer, {near.iterations} Newton steps", list(PRINTED), near.solution.actuated, "deg, mm"
    )
    return solutions


def report_random(report: Report, robot: symkin.Mechanism, count: int = 40) -> None:
    rng, equal, sizes = np.random.default_rng(SEED), 0, []
    for _ in range(count):
        points, R = skeleton(np.append(rng.uniform(-180, 180, 5), rng.uniform(-400, 0)))
        exact = inverse(points[4], R)
        equal += matches(exact, numeric(robot, points[4], R))
        sizes.append(len(exact))
    report.row(f"random poses with equal sets, of {count}", None, equal)
    report.row("of these with 4, 8 solutions", None, [sizes.count(4), sizes.count(8)])


def rounding_of_slide() -> float:
    """Most that A's four decimals can move the first root L6."""
    R, h = goal_rotation(), 1e-3
    slides = [max(isolated_roots(TIP + h * k, R)) - max(isolated_roots(TIP - h * k, R)) for k in np.eye(3)]
    return 5e-5 * float(np.abs(np.array(slides) / (2 * h)).sum())


def report_printed(report: Report, f: Function, root: float, a1: float) -> None:
    miss, left = float(np.linalg.norm(tip(np.array(PRINTED)) - TIP)), f(PRINTED[5])
    other = max(isolated_roots(TIP, goal_rotation(), a1=a1)) - root
    rounding = rounding_of_slide()
    report.row("|OF| - a1 at the paper's L6", TOLERANCE, left, "mm")
    report.row("distance from A of the printed answer's tip", None, miss, "mm")
    report.row("L6 moved by A's rounding, by a1 of the printed answer", None, [rounding, other], "mm")
    text = (
        f"the claimed 1e-8 was not met: the printed answer leaves |OF| - a1 = {left:.1e} mm and misses A by {miss:.3f} mm; its L6 is "
        f"off by {PRINTED[5] - root:.4f} mm, while A's rounding moves L6 by at most {rounding:.0e} mm and a1 = {a1:.3f} by {other:.4f} mm."
    )
    shown = left > 1e5 * TOLERANCE and miss > 0.01 and abs(PRINTED[5] - root) > 2 * (rounding + abs(other))
    report.erratum(text, shown=shown)


def report_search(report: Report, f: Function, roots: list[float]) -> None:
    ends = [f(-500.0), f(-250.0), f(0.0)]
    report.row("f at -500, -250, 0", None, ends, "mm")
    found = {order: paper_search(f, order) for order in ("left", "right", "both")}
    for order, (slide, steps) in found.items():
        report.row(
            f"printed loop, {order} test first: L6, steps" if order != "both" else "printed loop, both tests: L6, steps",
            None,
            [slide, steps],
        )
    report.row("bisection steps to |f| < 1e-8, for the paper's root", 7, found["right"][1])
    inside = all(INTERVAL[0] < r < INTERVAL[1] for r in roots)
    text = (
        f"[-500, 0] is no bracket: f is {ends[0]:+.1f}, {ends[1]:+.1f}, {ends[2]:+.1f} at -500, -250, 0 and both roots lie inside. The order "
        f"of the two sign tests decides: f_min f_mid first gives L6 = {found['left'][0]:.3f}, f_mid f_max first {found['right'][0]:.3f}; "
        f"both in turn on the same values, as printed, stop at {found['both'][0]:.0f}, no root."
    )
    apart = abs(found["left"][0] - min(roots)) < 1e-6 and abs(found["right"][0] - max(roots)) < 1e-6
    report.erratum(text, shown=inside and ends[0] > 0 > ends[1] and ends[2] > 0 and apart and abs(f(found["both"][0])) > 1)
    steps = found["right"][1]
    report.erratum(
        f"bisection needs {steps} steps to 1e-8, not 7: seven leave an interval of {500 / 2**7:.1f} mm.", shown=steps > 25
    )


def report_closed_form(report: Report, f: Function, roots: list[float]) -> None:
    """The conclusion that L6 needs an iterative search, against h = a2 + sqrt(a1^2 - e_z^2)."""
    e = axis5_origin(TIP, goal_rotation())
    away = math.sqrt((A2 + math.sqrt(A1**2 - e[2] ** 2)) ** 2 - e[1] ** 2)
    direct = [e[0] - away, e[0] + away]
    report.row("L6 in closed form, e_x -+ sqrt((a2 + sqrt(a1^2 - e_z^2))^2 - e_y^2)", None, direct, "mm")
    text = "L6 needs no iterative search: e_x -+ sqrt((a2 + sqrt(a1^2 - e_z^2))^2 - e_y^2) gives both roots."
    report.erratum(text, shown=bool(np.allclose(direct, sorted(roots), atol=1e-9)) and max(abs(f(x)) for x in direct) < 1e-9)


def report_third_angle(report: Report, solution: np.ndarray) -> None:
    """Equation (11): theta3 = arctan2(D4z, D4y), D4 the point D once joints 6, 5, 1 and 2 are returned."""
    D4 = turn("x", solution[2]) @ (turn("y", solution[3]) @ [-A2, 0, D1] + [-A1, 0, 0])
    printed, right = [degrees2(D4[2], D4[1]), degrees2(D4[1], D4[2])], degrees2(-D4[1], D4[2])
    report.row("equation (11), arctan2(D4z, D4y), read as (y, x) and as (x, y)", PRINTED[2], printed, "deg")
    report.row("arctan2(-D4y, D4z), read as (y, x)", PRINTED[2], right, "deg")
    text = f"equation (11) as it stands in our copy gives {printed[0]:.3f} or {printed[1]:.3f}, not theta3; arctan2(-D4y, D4z) gives {right:.3f}."
    report.erratum(text, shown=min(abs(p - solution[2]) for p in printed) > 1 and abs(right - solution[2]) < 1e-6)


# --- picture -----------------------------------------------------------------------------------------------------


def draw_function(axes, f: Function, roots: list[float]) -> None:
    x = np.linspace(-560, 60, 600)
    axes.axvspan(*INTERVAL, color="0.91", label="the paper's interval")
    axes.plot(x, [f(v) for v in x], color="0.15", lw=1.8)
    axes.axhline(0, color="0.5", lw=0.8)
    for root, colour in zip(sorted(roots, reverse=True), COLOURS[::2], strict=True):
        axes.plot(root, 0, "o", color=colour, ms=8, label=f"root, L6 = {root:.4f} mm")
    axes.plot([-500, -250, 0], [f(-500), f(-250), f(0)], "kx", ms=8, label="the paper's first three points")
    axes.set(xlabel="L6 [mm]", ylabel="f(L6) = |OF| - a1 [mm]", title="The paper's function and its roots")
    axes.legend(loc="upper center")
    axes.spines[["top", "right"]].set_visible(False)


def draw_arms(axes, solutions: list[np.ndarray]) -> None:
    """Two solutions with the same L6 place all links alike and differ in axis 2, drawn as an arrow at O."""
    for k, (q, colour) in enumerate(zip(solutions, COLOURS, strict=True), start=1):
        points, axis2 = skeleton(q)[0], 110 * turn("z", q[0])[:, 1]
        label = f"{k}: θ1 = {q[0]:.1f}°, L6 = {q[5]:.1f} mm"
        axes.plot(*points.T, "-o" if k % 2 else "--o", color=colour, lw=2.6, ms=4, label=label)
        axes.quiver(0, 0, 0, *axis2, color=colour, lw=2, arrow_length_ratio=0.2)
    for name, point in zip("OA", (np.zeros(3), TIP), strict=True):
        axes.plot(*point, "k*" if name == "A" else "ks", ms=9)
        axes.text(*(point + [20, -25, -30] if name == "O" else point + [-8, -18, 22]), name, fontsize=13)
    axes.set_xlabel("x [mm]", labelpad=12)
    axes.set(ylabel="y [mm]", title="The four configurations at the paper's pose; arrows: axis 2")
    axes.zaxis.set_rotate_label(False)
    axes.set_zlabel("z [mm]", rotation=90)
    axes.set(xticks=range(-500, 1, 100), yticks=(0, 200, 400), zticks=(0, 100, 200), ylim=(-120, 400))
    axes.set_aspect("equal")
    axes.legend(loc="upper left", frameon=False, fontsize=9, handlelength=3)
    axes.view_init(32, -75)


def draw(f: Function, roots: list[float], solutions: list[np.ndarray]):
    figure = new_figure(13.5, 5.8)
    figure.suptitle("Telescopic Pieper robot: the inverse problem")
    draw_function(figure.add_subplot(121), f, roots)
    draw_arms(figure.add_subplot(122, projection="3d"), solutions)
    return figure


def main() -> None:
    folder = folder_from_arguments(__doc__.splitlines()[0])
    robot = symkin.load("yao2020")
    report = Report("yao2020", "Telescopic Pieper robot: forward, inverse, and the paper's search", SEED)
    report.row("forward, A at (5, -10, 15, -20, 25 deg, 30 mm)", None, tip(np.array([5, -10, 15, -20, 25, 30.0])), "mm")
    report.row("the same by symkin", None, symkin.solve(robot, joints=[5, -10, 15, -20, 25, 30]).solution.position, "mm")
    a1 = report_lengths(report)
    solutions = report_solutions(report, robot)
    f, roots = distance_function(TIP, goal_rotation()), isolated_roots(TIP, goal_rotation())
    report_printed(report, f, max(roots), a1)
    report_search(report, f, roots)
    report_closed_form(report, f, roots)
    report_third_angle(report, solutions[0])
    report_random(report, robot)
    report.finish(draw(f, roots, solutions), folder)


if __name__ == "__main__":
    main()
