"""Figures 1 to 7 of the telescopic Pieper robot as drawings: axes, lengths, key points, planes, the
return of the axes.

Units: mm (figure 1: m). Source: Yao Haifeng et al. 2020 (see `study`).
"""

from __future__ import annotations

import math

import numpy as np

from studies.shared.report import new_figure
from studies.yao2020.inverse import inverse, plane_vectors, sequence
from studies.yao2020.model import (
    A1,
    A2,
    A3,
    D1,
    FORWARD,
    TIP,
    axis_lines,
    drawn_axes,
    goal_rotation,
    placed,
    pose_of,
    posed_axes,
    spherical_wrists,
)
from studies.yao2020.pictures import (
    GREY,
    MEMBERS,
    arrow,
    box,
    dimension,
    frame,
    members,
    name_points,
    patch,
)

WRISTS = {
    "PUMA560": (
        (20.0, 30.0, -50.0, 30.0, 50.0, 0.0),
        ((-0.1, -0.4, -0.1), (0.9, 0.3, 0.9)),
        (20, -60),
    ),
    "Stanford": (
        (20.0, 0.0, 0.0, 30.0, 50.0, 0.0),
        ((-0.3, -0.2, 0.0), (0.5, 0.6, 1.2)),
        (20, -50),
    ),
}
"""Joint values at which figure 1 is drawn, its box in m, and from where it is seen."""


# --- figures 1 to 3 -------------------------------------------------------------------------------


def draw_frames():
    figure = new_figure(17, 12)
    figure.suptitle(
        "Figures 1 to 3: spherical wrists, the robot's axes and members, the global frame and its "
        "lengths",
        fontsize=15,
    )
    grid = figure.add_gridspec(2, 2)
    for column, (name, arm) in enumerate(spherical_wrists().items()):
        draw_wrist(figure.add_subplot(grid[0, column], projection="3d"), name, arm)
    draw_architecture(figure.add_subplot(grid[1, 0], projection="3d"))
    draw_lengths(figure.add_subplot(grid[1, 1], projection="3d"))
    return figure


def draw_wrist(axes, name: str, arm) -> None:
    joints, (low, high), view = WRISTS[name]
    lines = posed_axes(drawn_axes(arm), joints, [j.type for j in arm.limbs[0].joints])
    points = np.array([(0.0, 0.0, 0.0), *(p for p, _ in lines)])
    axes.plot(*points.T, color="0.6", lw=5, solid_capstyle="round")
    for k, line in enumerate(lines, start=1):
        arrow(axes, line, k, 0.22 if k < 4 else 0.26, back=0.2)
    axes.plot(*lines[4][0].reshape(3, 1), "o", mfc="none", mec="black", ms=16, mew=1.5)
    box(axes, low, high, "m", 0.4, 1.0)
    axes.set_title(f"figure 1: {name}\naxes 4, 5, 6 meet (circle)", fontsize=12)
    axes.view_init(*view)


BOX = ((-600, -130, -110), (110, 130, 210))


def draw_architecture(axes) -> None:
    at = placed([0] * 6)
    members(axes, at)
    for k, line in enumerate(axis_lines([0] * 6), start=1):
        line = (at["D"], line[1]) if k == 6 else line
        arrow(axes, line, k, {5: 150.0, 6: 90.0}.get(k, 75.0), back=0.5)
    axes.text(*(at["A"] + (-5, 0, 25)), "A", fontsize=13, fontstyle="italic")
    box(axes, *BOX, "mm", 200, 1.22)
    axes.set_title(
        "figure 2: axes 1 to 6 and the members they move\n(O F 3, F E 4, E D 5, D A 6)", fontsize=12
    )
    axes.view_init(24, -68)


def draw_lengths(axes) -> None:
    at = placed([0] * 6)
    members(axes, at)
    name_points(
        axes,
        at,
        "OFEDA",
        {"O": (-30, 0, 16), "F": (-6, 0, 16), "E": (8, 0, 14), "D": (-6, 0, 16), "A": (-12, 0, 16)},
    )
    frame(axes, 80.0)
    down = (0, 0, -60)
    dimension(axes, at["O"], at["F"], f"a1 = {A1:g}", down)
    dimension(axes, at["F"], at["E"], f"a2 = {A2:g}", down)
    dimension(axes, at["D"], at["A"], f"a3 = {A3:g}", (0, 0, 50))
    dimension(axes, at["E"], at["D"], f"d1 = {D1:g}", (40, 0, 0))
    box(axes, *BOX, "mm", 200, 1.22)
    axes.set_title(
        "figure 3: the global frame, the initial position and the lengths [mm]\n"
        "(computed from the worked example)",
        fontsize=12,
    )
    axes.view_init(14, -74)


# --- figures 4, 5 and 7 ---------------------------------------------------------------------------


def draw_planes():
    figure = new_figure(17, 12)
    figure.suptitle(
        "Figures 4, 5 and 7: the key points, planes I and II, the forward example", fontsize=15
    )
    draw_key_points(figure.add_subplot(221, projection="3d"))
    draw_two_planes(figure.add_subplot(222, projection="3d"))
    draw_forward_example(figure.add_subplot(223, projection="3d"))
    draw_along_axis5(figure.add_subplot(224))
    return figure


def draw_key_points(axes) -> None:
    at = placed([0] * 6)
    members(axes, at)
    name_points(
        axes,
        at,
        "OFEDABC",
        {
            "C": (14, 12, 8),
            "A": (-30, 0, -8),
            "O": (12, 0, 12),
            "F": (-6, 0, 16),
            "E": (-6, 0, -34),
        },
    )
    for name in "BC":
        axes.plot(*np.array([at["A"], at[name]]).T, "--", color="black", lw=1)
    for k, line in enumerate(axis_lines([0] * 6), start=1):
        if k in (3, 4, 5):
            arrow(axes, line, k, 150.0 if k == 5 else 70.0, back=0.8 if k < 5 else 0.4)
    box(axes, *BOX, "mm", 200, 1.22)
    axes.set_title(
        "figure 4: |OF| = a1, |FE| = a2, |ED| = d1,\n|DA| = a3; A, B, C state the pose", fontsize=12
    )
    axes.view_init(24, -68)


def draw_two_planes(axes) -> None:
    """The forward example: plane I through A, D, E, plane II through O and axis 5."""
    at, (A, R) = placed(FORWARD), pose_of(FORWARD)
    _, _, towards = plane_vectors(A, R, FORWARD[5])
    members(axes, at)
    up = (at["D"] - at["E"]) / D1
    low, high = at["E"] - 70 * up, at["D"] + 40 * up
    foot = at["E"] + (at["E"] - at["O"]) @ up * -up
    reach = float(np.linalg.norm(foot - at["O"]))
    patch(axes, [low, high, high + reach * towards, low + reach * towards], MEMBERS[1])
    outward = (at["A"] - at["D"]) / np.linalg.norm(at["A"] - at["D"])
    patch(axes, [low, high, high + 170 * outward, low + 170 * outward], MEMBERS[5])
    patch(axes, [low, high, high - 130 * outward, low - 130 * outward], MEMBERS[5])
    turns = np.linspace(0, math.radians(FORWARD[4]), 20)
    side = np.cross(up, towards)
    arc = np.array([high + 110 * (math.cos(t) * towards + math.sin(t) * side) for t in turns])
    axes.plot(*arc.T, color="black", lw=1.6)
    axes.text(*(arc[10] + 18 * up + 25 * towards), "θ5 = 25°", fontsize=13)
    axes.text(
        *(low + 0.75 * reach * towards + 55 * up),
        "II",
        fontsize=17,
        color=MEMBERS[1],
        fontweight="bold",
    )
    axes.text(
        *(low + 130 * outward + 18 * up), "I", fontsize=17, color=MEMBERS[5], fontweight="bold"
    )
    name_points(
        axes,
        at,
        "OFEDA",
        {
            "O": (14, 0, 10),
            "D": (-35, 0, 12),
            "E": (-40, 0, -6),
            "A": (-26, 0, -12),
            "F": (8, 0, -30),
        },
    )
    box(axes, (-600, -160, -200), (60, 110, 130), "mm", 200, 1.15)
    axes.set_title(
        "figure 5: plane I (A, D, E), plane II (O, axis 5);\nthey meet in axis 5 at the angle θ5",
        fontsize=12,
    )
    axes.view_init(50, -62)


def draw_along_axis5(axes) -> None:
    """The forward example seen along axis 5: both planes are lines, and the angle between them is
    theta5 itself.
    """
    at, (_, normal, towards) = placed(FORWARD), plane_vectors(*pose_of(FORWARD), FORWARD[5])
    flat = {
        name: np.array([(p - at["E"]) @ towards, (p - at["E"]) @ normal]) for name, p in at.items()
    }
    for (one, other), k in zip(("OF", "FE", "DA"), (3, 4, 6), strict=True):
        axes.plot(
            *np.array([flat[one], flat[other]]).T,
            color=MEMBERS[k - 1],
            lw=5,
            solid_capstyle="round",
        )
    along = -flat["A"] / np.linalg.norm(flat["A"])
    axes.plot([-130, 420], [0, 0], "--", color=MEMBERS[1], lw=1.4)
    axes.plot(*np.array([-200 * along, 260 * along]).T, "--", color=MEMBERS[5], lw=1.4)
    turns = np.linspace(0, math.radians(FORWARD[4]), 20)
    axes.plot(150 * np.cos(turns), 150 * np.sin(turns), color="black", lw=1.6)
    axes.text(158, 28, "θ5 = 25°", fontsize=13)
    axes.text(395, 10, "II", fontsize=17, color=MEMBERS[1], fontweight="bold")
    axes.text(*(268 * along), "I", fontsize=17, color=MEMBERS[5], fontweight="bold")
    for name, shift in {"O": (0, -16), "F": (-4, -16), "E": (-10, 9), "A": (-4, 9)}.items():
        axes.plot(*flat[name], "o", color="black", ms=4)
        text = "E, D" if name == "E" else name
        axes.annotate(
            text,
            flat[name],
            xytext=shift,
            textcoords="offset points",
            fontsize=13,
            fontstyle="italic",
        )
    axes.set(
        aspect="equal",
        xlabel="from axis 5 towards O [mm]",
        ylabel="along the normal of plane II [mm]",
        ylim=(-140, 160),
    )
    axes.set_title("figure 5 seen along axis 5", fontsize=12)


def draw_forward_example(axes) -> None:
    at = placed(FORWARD)
    members(axes, placed([0] * 6), ghost=True)
    members(axes, at)
    for name in "BC":
        axes.plot(*np.array([at["A"], at[name]]).T, "--", color="black", lw=1)
    name_points(
        axes,
        at,
        "OFEDABC",
        {
            "O": (14, 0, 10),
            "F": (0, 0, 18),
            "E": (-6, 0, -38),
            "D": (-6, 0, 16),
            "A": (8, 0, -32),
            "B": (-34, 0, 8),
            "C": (8, 10, 12),
        },
    )
    box(axes, (-600, -160, -200), (60, 130, 160), "mm", 200, 1.15)
    tip = ", ".join(f"{v:.4f}" for v in at["A"])
    axes.set_title(
        f"figure 7: θ = 5°, -10°, 15°, -20°, 25°, L6 = 30 mm\n"
        f"A = ({tip}) mm; grey: initial position",
        fontsize=12,
    )
    axes.view_init(22, -66)


# --- figure 6 -------------------------------------------------------------------------------------


VIEWS = {
    1: ("top view", 0, 1),
    2: ("front view", 0, 2),
    3: ("left view", 1, 2),
    4: ("front view", 0, 2),
}


def draw_return():
    """The worked example: joints 6 and 5 are at zero, then 1, 2, 3 and 4 are returned."""
    q = inverse(TIP, goal_rotation())[0]
    figure = new_figure(18, 9.5)
    figure.suptitle(
        "Figure 6: the return of the axes in the worked example, and the view in which each angle "
        "is read",
        fontsize=15,
    )
    figure.get_layout_engine().set(rect=(0.0, 0.0, 0.97, 1.0))
    grid = figure.add_gridspec(2, 4, height_ratios=(1.25, 1))
    before = placed(q)
    for joint, value, points in sequence(TIP, goal_rotation(), float(q[5])):
        at = {**points, "O": np.zeros(3)}
        draw_state(figure.add_subplot(grid[0, joint - 1], projection="3d"), joint, at, before)
        draw_view(figure.add_subplot(grid[1, joint - 1]), joint, value, at)
        before = at
    return figure


def draw_state(axes, joint: int, at: dict[str, np.ndarray], before: dict[str, np.ndarray]) -> None:
    members(axes, before, ghost=True)
    members(axes, at)
    name_points(
        axes,
        at,
        "OFEDA",
        {
            "O": (16, 0, 10),
            "F": (0, 0, 22),
            "E": (-10, 0, -50),
            "D": (-10, 0, 24),
            "A": (-24, 0, 20),
        },
    )
    done = ", ".join(["6", "5", *(str(k) for k in range(1, joint))])
    box(axes, (-600, -130, -120), (80, 280, 200), "mm", 200, 0.93)
    axes.set_title(
        f"({'abcd'[joint - 1]}) joints {done} at zero\n(grey: the state before)", fontsize=12
    )
    axes.view_init(28, -70)


def draw_view(axes, joint: int, value: float, at: dict[str, np.ndarray]) -> None:
    """The orthographic view of the members, and the angle of the joint that is returned next."""
    name, i, j = VIEWS[joint]
    for (one, other), k in zip(("OF", "FE", "ED", "DA"), (3, 4, 5, 6), strict=True):
        axes.plot(
            *np.array([at[one], at[other]])[:, [i, j]].T,
            color=MEMBERS[k - 1],
            lw=4,
            solid_capstyle="round",
        )
    centre = at["F"] if joint == 4 else at["O"]
    marked = {1: at["F"], 2: at["F"], 3: at["D"], 4: at["E"]}[joint] - centre
    flat, zero = (
        np.array([marked[i], marked[j]]),
        np.array([0.0, 1.0] if joint == 3 else [-1.0, 0.0]),
    )
    start, radius = math.atan2(zero[1], zero[0]), 0.8 * float(np.linalg.norm(flat))
    swing = math.remainder(math.atan2(flat[1], flat[0]) - start, 2 * math.pi)
    origin = np.array([centre[i], centre[j]])
    axes.plot(*np.array([origin, origin + 1.3 * radius * zero]).T, "--", color=GREY, lw=1.2)
    axes.plot(*np.array([origin, origin + flat]).T, "--", color=GREY, lw=1.2)
    turns = np.linspace(start, start + swing, 30)
    axes.plot(
        origin[0] + radius * np.cos(turns),
        origin[1] + radius * np.sin(turns),
        color="black",
        lw=1.6,
    )
    for point in ("O", "F", "E", "D", "A") if joint != 3 else ("O", "D"):
        axes.plot(at[point][i], at[point][j], "o", color="black", ms=4)
        shift, where = (6, -16 if point == "D" and joint == 1 else 7), (at[point][i], at[point][j])
        axes.annotate(
            point, where, xytext=shift, textcoords="offset points", fontsize=12, fontstyle="italic"
        )
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.2)
    axes.set(xlabel=f"{'xyz'[i]} [mm]", ylabel=f"{'xyz'[j]} [mm]")
    axes.set_title(f"{name}: θ{joint} = {value:.4f}°", fontsize=12)
