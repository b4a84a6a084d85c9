"""3-TRT + SPS platform of four freedoms: mobility by reciprocal screws, inverse and direct problem in closed form.

Notation: a_i, c_i corners of the base (side 240 mm) and platform (120 mm) triangles at -90, 30, 150 degrees; the platform
stays level, X = (Xp, Yp, Zp, gamma); theta_i direction of limb i seen from above, l_op = |OP|; limb = links 70 + 70 mm.

    inverse:  C_i = P + Rz(gamma) c_i,   theta_i = atan2(Y_Ci - Y_ai, X_Ci - X_ai),   l_op = |P|
    direct:   n_i . (P + Rz(gamma) c_i - a_i) = 0,   n_i = (-sin theta_i, cos theta_i),   i = 1, 2, 3

With w_1 = n_2 x n_3 and so on in turn, sum w_i n_i = 0, so that P drops out of sum w_i (equation i):

    A sin(gamma) + B cos(gamma) + C = 0,   A = sum w_i n_i . J c_i,   B = sum w_i n_i . c_i,   C = -sum w_i n_i . a_i,

J the quarter turn. The paper writes tan(theta_i) in place of n_i. Units: mm; degrees where printed, radians inside.
Source: Zhao Tieshi et al., A novel four-DOF mixed platform mechanism and its position analysis, Optics and Precision
Engineering 8(1), 2000, 42-45. Table 1 has lost its decimal points in the copy at hand (1000 reads 100.0).
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

import symkin
from enumerated import statement
from report import Report, equal_axes, folder_from_arguments, new_figure
from symkin.position.mobility import analyse_mobility
from symkin.spatial.rotation import euler_from_quaternion
from symkin.spatial.screw import reciprocal_product, reciprocal_system, revolute_screw

CORNERS = np.array([[math.cos(t), math.sin(t)] for t in np.radians([-90.0, 30.0, 150.0])])
BASE, PLATFORM, LINK = 240.0 / math.sqrt(3) * CORNERS, 120.0 / math.sqrt(3) * CORNERS, 70.0
QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])
TABLE_1 = (((0.0, 0.0, 100.0, 0.0), (90.0, 210.0, 330.0, 100.0)), ((5.0, 5.0, 105.0, 5.0), (81.6, 202.8, 330.6, 105.2)))
INPUT = TABLE_1[1][1]
PAPER_POSES = tuple(
    (x, y, s * z, g) for x, y, z, g in ((4.95, 5.01, 104.96, 5.02), (-3.85, 23.60, 102.45, 14.99)) for s in (1, -1)
)
SEED, GUESSES = 4, 60
BLUE, RED, GREY = "#0072b2", "#d55e00", "0.5"


# --- geometry, inverse problem -----------------------------------------------------------------------------------


def turned(points: np.ndarray, gamma: float) -> np.ndarray:
    """Rz(gamma) on rows (x, y)."""
    return math.cos(gamma) * points + math.sin(gamma) * points @ QUARTER.T


def corners(pose) -> np.ndarray:
    """C_i, rows (x, y, z), of a pose with gamma in degrees."""
    flat = np.array(pose[:2]) + turned(PLATFORM, math.radians(pose[3]))
    return np.column_stack([flat, np.full(3, pose[2])])


def inverse(pose, base: np.ndarray = BASE, flip: float = 1.0) -> np.ndarray:
    """theta_1, theta_2, theta_3 in [0, 360), l_op; `flip` scales the platform."""
    flat = np.array(pose[:2]) + turned(flip * PLATFORM, math.radians(pose[3])) - base
    return np.array([*np.degrees(np.arctan2(flat[:, 1], flat[:, 0])) % 360.0, math.hypot(*pose[:3])])


def limb_lengths(pose) -> np.ndarray:
    """|a_i C_i|: at most 140 mm for links of 70 + 70."""
    return np.linalg.norm(corners(pose) - np.column_stack([BASE, np.zeros(3)]), axis=1)


def normals(theta) -> np.ndarray:
    return np.column_stack([-np.sin(np.radians(theta)), np.cos(np.radians(theta))])


def line_misses(pose, theta=INPUT[:3]) -> np.ndarray:
    """Signed distances of C_i from the vertical planes of the limbs."""
    return np.sum(normals(theta) * (corners(pose)[:, :2] - BASE), axis=1)


def elbow(pose, i: int, *, outward: bool) -> np.ndarray:
    """b_i at 70 mm from a_i and C_i in the limb's plane."""
    a, c = np.array([*BASE[i], 0.0]), corners(pose)[i]
    across = np.cross(c - a, [*(c - a)[1::-1] * (1, -1), 0.0])
    offset = math.sqrt(LINK**2 - np.dot(c - a, c - a) / 4) * across / np.linalg.norm(across)
    return (a + c) / 2 + (offset if (across[:2] @ BASE[i] > 0) == outward else -offset)


# --- direct problem, three ways ----------------------------------------------------------------------------------


def coefficients(theta, platform: np.ndarray = PLATFORM) -> np.ndarray:
    """A, B, C of the equation in gamma."""
    n = normals(theta)
    w = np.array([np.linalg.det(n[[1, 2]]), np.linalg.det(n[[2, 0]]), np.linalg.det(n[[0, 1]])])
    return np.array([w @ np.sum(n * v, axis=1) for v in (platform @ QUARTER.T, platform, -BASE)])


def position(theta, gamma: float, lines=(0, 1, 2), platform: np.ndarray = PLATFORM) -> np.ndarray:
    """Xp, Yp from two of the lines, or all three, which agree at a root gamma (radians)."""
    n, rows = normals(theta), list(lines)
    right = np.sum(n * (BASE - turned(platform, gamma)), axis=1)
    return np.linalg.lstsq(n[rows], right[rows], rcond=None)[0]


def closed_form(given) -> list[np.ndarray]:
    """All poses (gamma in degrees), up to four."""
    theta, length = given[:3], given[3]
    A, B, C = coefficients(theta)
    poses = []
    for turn in math.acos(-C / math.hypot(A, B)) * np.array([-1.0, 1.0]):
        gamma = math.remainder(math.atan2(A, B) + turn, 2 * math.pi)
        x, y = position(theta, gamma)
        z = math.sqrt(length**2 - x * x - y * y)
        poses += [np.array([x, y, s * z, math.degrees(gamma)]) for s in (1, -1)]
    return sorted(poses, key=lambda p: (abs(p[3]), -p[2]))


def closure() -> tuple[ca.SX, ca.SX, ca.SX]:
    """X = (Xp, Yp, Zp, gamma), inputs u = (theta, l_op), and the paper's equations (6), each in mm: lines written without
    tan, and (|P|^2 - l_op^2) / l_op."""
    X, u = ca.SX.sym("X", 4), ca.SX.sym("u", 4)
    s, c = ca.sin(X[3]), ca.cos(X[3])
    rows = []
    for i in range(3):
        (cx, cy), (ax, ay) = PLATFORM[i], BASE[i]
        across, along = X[0] + c * cx - s * cy - ax, X[1] + s * cx + c * cy - ay
        rows.append(ca.cos(u[i]) * along - ca.sin(u[i]) * across)
    return X, u, ca.vertcat(*rows, (ca.sumsqr(X[:3]) - u[3] ** 2) / u[3])


def searches() -> dict[str, ca.Function]:
    """Solvers (guess, u) -> X of the closure: Newton's rootfinder, and least squares by IPOPT."""
    X, u, F = closure()
    newton = ca.rootfinder("newton", "newton", {"x": X, "p": u, "g": F}, {"abstol": 1e-11, "error_on_fail": False})
    quiet = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-12}}
    ipopt = ca.nlpsol("ipopt", "ipopt", {"x": X, "p": u, "f": 0.5 * ca.sumsqr(F)}, quiet)
    guess = ca.MX.sym("guess", 4), ca.MX.sym("u", 4)
    ends = newton(x0=guess[0], p=guess[1])["x"], ipopt(x0=guess[0], p=guess[1])["x"]
    return {name: ca.Function(name, list(guess), [end]) for name, end in zip(("rootfinder", "IPOPT"), ends, strict=True)}


def from_guesses(search: ca.Function) -> tuple[list[np.ndarray], int]:
    """(distinct poses, guesses that reached one) for random guesses within 150 mm and any gamma."""
    X, u, F = closure()
    residual = ca.Function("F", [X, u], [ca.norm_inf(F)])
    given = np.array([*np.radians(INPUT[:3]), INPUT[3]])
    rng, found, hits = np.random.default_rng(SEED), [], 0
    for guess in rng.uniform(-1, 1, (GUESSES, 4)) * (150.0, 150.0, 150.0, math.pi):
        end = np.asarray(search(guess, given)).ravel()
        if not np.all(np.isfinite(end)) or float(residual(end, given)) > 1e-8:
            continue
        pose, hits = np.array([*end[:3], math.degrees(math.remainder(end[3], 2 * math.pi))]), hits + 1
        if not any(np.abs(pose - other).max() < 1e-4 for other in found):
            found.append(pose)
    return found, hits


def pose_numbers(pose: symkin.Pose) -> np.ndarray:
    return np.array([*pose.position, math.degrees(euler_from_quaternion(pose.quaternion, "xyz")[2])])


def furthest(one: list[np.ndarray], other: list[np.ndarray]) -> float:
    """Largest difference of two lists of poses; infinite when their counts differ."""
    if len(one) != len(other):
        return math.inf
    return max(min(float(np.abs(a - b).max()) for b in other) for a in one)


# --- report ------------------------------------------------------------------------------------------------------


def report_inverse(report: Report, platform: symkin.Mechanism) -> None:
    for pose, given in TABLE_1:
        report.row(f"inverse at {pose}", given, inverse(pose), "deg, mm")
        full = symkin.Pose.from_euler(np.array(pose[:3]), np.radians([0.0, 0.0, pose[3]]), "xyz")
        branches = symkin.modes(platform, pose=full)
        ahead = [m for m in branches if all(m.joints[f"radial{i}"] > 0 for i in (1, 2, 3))]
        own = np.array(ahead[0].actuated) % 360.0
        report.row(f"the same by symkin: 1 of {len(branches)} branches has all radii > 0", given, own, "deg, mm")
    swapped = inverse(TABLE_1[1][0], BASE / 2, 2.0)
    report.row("inverse with a of side 120, c of 240, as the letters read", INPUT, swapped, "deg, mm")
    text = (
        "the example gives 120 and 240 mm as the sides of the 'upper, lower' triangles 'a, c', but a is the lower one: only a = "
        "240, c = 120 mm reproduces table 1."
    )
    report.erratum(text, shown=np.abs(inverse(TABLE_1[1][0]) - INPUT).max() < 0.06 and np.abs(swapped - INPUT).max() > 10)


def limb_twists(pose, i: int) -> np.ndarray:
    """The five revolutes of limb i, elbow outward, as rows of twists about O."""
    a, c = np.array([*BASE[i], 0.0]), corners(pose)[i]
    theta, up = math.radians(inverse(pose)[i]), np.array([0.0, 0.0, 1.0])
    level = np.array([math.sin(theta), -math.cos(theta), 0.0])
    places = [(a, up), (a, level), (elbow(pose, i, outward=True), level), (c, level), (c, up)]
    return np.array([revolute_screw(point, axis) for point, axis in places])


def report_mobility(report: Report) -> None:
    links, joints, freedoms = 2 + 3 * 4 + 2, 3 * 5 + 3, 3 * 5 + 7
    report.row("6 (n - g - 1) + sum f + 1 redundant couple - 1 idle spin", 4, 6 * (links - joints - 1) + freedoms + 1 - 1)
    for pose, _ in TABLE_1:
        twists = [limb_twists(pose, i) for i in range(3)]
        wrenches = [reciprocal_system(t, 240.0) for t in twists]
        couples = np.vstack([w / np.linalg.norm(w[:, 3:]) for w in wrenches])
        report.row(f"at {pose}: screws reciprocal to each limb", [1, 1, 1], [len(w) for w in wrenches])
        for i, (t, couple) in enumerate(zip(twists, couples, strict=True), start=1):
            report.row(f"limb {i}: reciprocal couple (force; moment)", None, couple + 0.0)
            report.row(f"limb {i}: l l^r + m m^r; most work on its five twists", [0, 0], [t[1, :3] @ couple[3:], work(t, couple)])
        free = reciprocal_system(couples, 240.0)
        report.row("rank of the three couples; of their forces", [2, 0], [rank(couples), rank(couples[:, :3])])
        report.row("screws reciprocal to all twists (common constraints)", 0, len(reciprocal_system(np.vstack(twists), 240.0)))
        report.row("platform freedoms; those that tilt it", [4, 0], [len(free), rank(free[:, :2])])
    for name in ("zhao2000", "zhao2000_links"):
        found = analyse_mobility(symkin.load(name))
        numbers = [found.freedoms, found.rows, found.rank.value, found.redundant, found.mobility]
        paper = [None, None, None, 1, 4] if name == "zhao2000_links" else None
        report.row(f"{name}, closure Jacobian: freedoms, rows, rank, redundant rows, mobility", paper, numbers)


def work(twists: np.ndarray, wrench: np.ndarray) -> float:
    return max(abs(float(reciprocal_product(t, wrench))) for t in twists)


def rank(rows: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(rows, tol=1e-9))


def report_direct(report: Report, platform: symkin.Mechanism) -> list[np.ndarray]:
    poses = closed_form(INPUT)
    report.row("A, B, C of the equation in gamma", None, coefficients(INPUT[:3]))
    for k, (pose, paper) in enumerate(zip(poses, PAPER_POSES, strict=True), start=1):
        report.row(f"direct, closed form, pose {k}", paper, pose, "mm, deg")
    for name, search in searches().items():
        found, hits = from_guesses(search)
        report.row(f"{name}, {GUESSES} guesses: poses, guesses that led to one", None, [len(found), hits])
        report.row(f"{name}: largest difference from the closed form", None, furthest(poses, found), "mm, deg")
    found = symkin.modes(platform, joints=INPUT)
    modes = [pose_numbers(m.pose) for m in found]
    report.row("symkin.modes on the line model: poses", 4, len(modes))
    report.row("completeness, line model", None, statement(found))
    report.row("symkin.modes: largest difference from the closed form", None, furthest(poses, modes), "mm, deg")
    return poses


def report_links(report: Report, poses: list[np.ndarray]) -> None:
    """The real limbs: two links of 70 mm reach 140 mm."""
    for pose in poses[::2]:
        report.row(f"limb lengths at gamma = {pose[3]:.3f}, reach 140", None, limb_lengths(pose), "mm")
    found = symkin.modes(symkin.load("zhao2000_links"), joints=INPUT)
    report.row("real limbs: configurations, poses", None, [len(found), found.poses])
    report.row("completeness, real limbs", None, statement(found))
    for pose in poses:
        here = [m for m in found if np.abs(pose_numbers(m.pose) - pose).max() < 1e-6]
        elbows = {tuple(round(m.joints[f"elbow{i}"], 3) for i in (1, 2, 3)) for m in here}
        sides = [len({e[i] for e in elbows}) for i in range(3)]
        label = f"configurations at ({', '.join(f'{v:.2f}' for v in pose)}), elbow positions of each limb"
        report.row(label, None, [len(elbows), *sides])


def report_verdict(report: Report, poses: list[np.ndarray]) -> None:
    """Each pose of the paper against its own equations, and where the wrong pair came from."""
    for pose in PAPER_POSES:
        right = np.abs(line_misses(pose)).max() < 0.02 and abs(inverse(pose)[3] - INPUT[3]) < 0.02
        report.row(f"{pose}: {'right' if right else 'wrong'}; distances from the three lines", [0, 0, 0], line_misses(pose), "mm")
    wrong, A, B, C = PAPER_POSES[2], *coefficients(INPUT[:3])
    report.row(f"inverse of the paper's {wrong}", INPUT, inverse(wrong), "deg, mm")
    sines = np.sort(np.roots([A * A + B * B, 2 * A * C, C * C - B * B]))
    arcsines = np.degrees(np.arcsin(sines))
    report.row("arcsin of the two roots sin(gamma)", [5.02, 14.99], arcsines, "deg")
    report.row("A sin + B cos + C there", [0, 0], A * sines + B * np.sqrt(1 - sines**2) + C)
    pairs = {lines: position(INPUT[:3], math.radians(arcsines[1]), lines) for lines in ((0, 1), (0, 2), (1, 2))}
    for lines, xy in pairs.items():
        report.row(f"Xp, Yp there from lines {lines[0] + 1} and {lines[1] + 1} alone", wrong[:2], xy, "mm")
    miss, second = abs(line_misses(wrong)[1]), poses[2]
    text = (
        f"the poses (-3.85, 23.60, +-102.45, 14.99) are wrong; they are {tuple(np.round(second[:2], 3).tolist())}, "
        f"+-{second[2]:.3f}, {second[3]:.3f}. arcsin gave {arcsines[1]:.2f} for {second[3]:.2f}, and two of the three lines the "
        f"position: it misses the line of limb 2 by {miss:.0f} mm, its own inverse has theta_2 = {inverse(wrong)[1]:.1f}."
    )
    from_arcsine = abs(arcsines[1] - 14.99) < 0.01 and np.abs(pairs[0, 2] - wrong[:2]).max() < 0.01
    shown = (
        miss > 1.0 and from_arcsine and abs(second[3] + arcsines[1] - 180.0) < 1e-6 and np.abs(line_misses(second)).max() < 1e-9
    )
    report.erratum(text, shown=shown)
    lengths = limb_lengths(second)
    text = (
        "the input has two platform poses with the real limbs, not four assembly modes: the true second pair needs limbs of "
        f"{', '.join(f'{v:.1f}' for v in lengths)} mm, and two links of 70 mm reach 140."
    )
    report.erratum(text, shown=lengths.min() > 140.0 and limb_lengths(poses[0]).max() < 140.0)
    text = "equations (6) to (9) divide by cos(theta_1), which is zero at the first row of table 1 (theta_1 = 90)."
    report.erratum(text, shown=abs(math.cos(math.radians(TABLE_1[0][1][0]))) < 1e-12)


def report_upside_down(report: Report) -> None:
    """The platform turned over, c_i -> (x, -y): what a declared level motion leaves out."""
    over = PLATFORM * (1.0, -1.0)
    A, B, C = coefficients(INPUT[:3], over)
    report.row("upside down, table 1 row 2: |C| / sqrt(A^2 + B^2), above 1 no real pose", None, abs(C) / math.hypot(A, B))
    theta, length = TABLE_1[0][1][:3], TABLE_1[0][1][3]
    report.row("upside down, row 1: A, B, C (all zero: a self-motion)", None, coefficients(theta, over))
    least = math.inf
    for gamma in np.radians(np.arange(0.0, 360.0, 0.5)):
        xy = position(theta, gamma, platform=over)
        reach = np.linalg.norm(xy + turned(over, gamma) - BASE, axis=1)
        height = length**2 - xy @ xy
        least = min(least, math.sqrt(reach.max() ** 2 + height)) if height >= 0 else least
    report.row("longest limb on that self-motion, least value (reach 140)", None, least, "mm")


# --- picture -----------------------------------------------------------------------------------------------------


def triangle(axes, points: np.ndarray, colour: str) -> None:
    axes.plot(*np.vstack([points, points[:1]]).T, color=colour, lw=2)
    if points.shape[1] == 3:
        axes.plot_trisurf(*points.T, triangles=[(0, 1, 2)], color=colour, alpha=0.25, shade=False)
    else:
        axes.fill(*points.T, color=colour, alpha=0.2)


def draw_space(axes, pose, title: str, outward: bool | None = None) -> None:
    """Line model: each limb as the straight line a_i C_i over its trace on the ground; real limbs: the two links."""
    feet, tops = np.column_stack([BASE, np.zeros(3)]), corners(pose)
    triangle(axes, feet, GREY)
    triangle(axes, tops, BLUE)
    for i, (a, c) in enumerate(zip(feet, tops, strict=True)):
        path = [a, c] if outward is None else [a, elbow(pose, i, outward=outward), c]
        axes.plot(*np.array(path).T, "-o", color=RED, lw=2.4, ms=4)
        axes.plot(*np.array([a, c * (1, 1, 0), c]).T, ":", color=GREY, lw=1)
    axes.plot(*np.array([(0, 0, 0), pose[:3]]).T, color="#009e73", lw=4, solid_capstyle="round")
    equal_axes(axes, (-150, -150, -120 if outward is None else -10), (150, 150, 120), "mm", 100)
    axes.set_title(title, fontsize=12)
    axes.view_init(22, -72)


def draw_plan(axes, pose, title: str) -> None:
    """Seen from above: the three lines and the platform."""
    triangle(axes, BASE, GREY)
    triangle(axes, corners(pose)[:, :2], BLUE)
    for i, (a, t) in enumerate(zip(BASE, np.radians(INPUT[:3]), strict=True)):
        ends = np.array([a, a + 330 * np.array([math.cos(t), math.sin(t)])])
        axes.plot(*ends.T, color=RED, lw=1.4)
        axes.plot(*corners(pose)[i, :2], "o", color=BLUE, ms=6)
        axes.annotate(f"$a_{i + 1}$", a, xytext=1.13 * a, ha="center", va="center", fontsize=12)
    corner, gap = corners(pose)[1, :2], line_misses(pose)[1]
    if abs(gap) > 1.0:
        foot = corner - gap * normals(INPUT[:3])[1]
        axes.plot(*np.array([corner, foot]).T, "k--", lw=1.6)
        axes.text(*(corner + (6, 6)), f"{abs(gap):.0f} mm", fontsize=11)
    axes.set(xlim=(-170, 170), ylim=(-170, 170), aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    axes.set_title(title, fontsize=12)


def draw(poses: list[np.ndarray]):
    figure = new_figure(18, 9.5)
    figure.suptitle("3-TRT + SPS platform: direct problem of (81.6°, 202.8°, 330.6°; 105.2 mm)", fontsize=15)
    grid = figure.add_gridspec(2, 4)
    for k, pose in enumerate(poses):
        place = figure.add_subplot(grid[k % 2, k // 2], projection="3d")
        title = f"line model, pose {k + 1}\n({pose[0]:.2f}, {pose[1]:.2f}, {pose[2]:.2f}) mm, {pose[3]:.2f}°"
        draw_space(place, pose, title)
    for k, side in enumerate(("outward", "inward")):
        place = figure.add_subplot(grid[k, 2], projection="3d")
        draw_space(place, poses[0], f"real limbs at pose 1,\nelbows {side}", outward=side == "outward")
    draw_plan(figure.add_subplot(grid[0, 3]), poses[0], "from above, pose 1:\neach corner on its line")
    draw_plan(figure.add_subplot(grid[1, 3]), PAPER_POSES[2], "from above, the paper's (-3.85, 23.60):\ncorner 2 off its line")
    return figure


def main() -> None:
    folder = folder_from_arguments(__doc__.splitlines()[0])
    platform = symkin.load("zhao2000")
    report = Report("zhao2000", "3-TRT + SPS platform (Zhao 2000): mobility, inverse and direct problem", SEED)
    report_inverse(report, platform)
    report_mobility(report)
    poses = report_direct(report, platform)
    report_links(report, poses)
    report_verdict(report, poses)
    report_upside_down(report)
    report.finish(draw(poses), folder)


if __name__ == "__main__":
    main()
