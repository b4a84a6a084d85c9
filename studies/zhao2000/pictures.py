"""Pictures of the 3-TRT + SPS platform: its modes, and the guesses that lead to them. Source: see
`study`.
"""

from __future__ import annotations

import math

import numpy as np

from studies.shared.guesses import Closure, draw_basins, least_squares, rootfinder
from studies.shared.report import equal_axes, new_figure
from studies.zhao2000.model import BASE, INPUT, PAPER_POSES, corners, inside, line_misses, normals
from studies.zhao2000.screws import elbow

BLUE, RED, GREY = "#0072b2", "#d55e00", "0.5"
MODES = ("#0072b2", "#56b4e9", "#d55e00", "#e69f00")
"""One colour a mode; the two of a mirror pair are alike."""


def triangle(axes, points: np.ndarray, colour: str) -> None:
    axes.plot(*np.vstack([points, points[:1]]).T, color=colour, lw=2)
    if points.shape[1] == 3:
        axes.plot_trisurf(*points.T, triangles=[(0, 1, 2)], color=colour, alpha=0.25, shade=False)
    else:
        axes.fill(*points.T, color=colour, alpha=0.2)


def draw_space(axes, pose, title: str, outward: bool | None = None) -> None:
    """Line model: each limb as the straight line a_i C_i over its trace on the ground; real limbs:
    the two links.
    """
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
    figure.suptitle(
        "3-TRT + SPS platform: direct problem of (81.6°, 202.8°, 330.6°; 105.2 mm)", fontsize=15
    )
    grid = figure.add_gridspec(2, 4)
    for k, pose in enumerate(poses):
        place = figure.add_subplot(grid[k % 2, k // 2], projection="3d")
        title = (
            f"line model, pose {k + 1}\n"
            f"({pose[0]:.2f}, {pose[1]:.2f}, {pose[2]:.2f}) mm, {pose[3]:.2f}°"
        )
        draw_space(place, pose, title)
    for k, side in enumerate(("outward", "inward")):
        place = figure.add_subplot(grid[k, 2], projection="3d")
        draw_space(
            place, poses[0], f"real limbs at pose 1,\nelbows {side}", outward=side == "outward"
        )
    draw_plan(
        figure.add_subplot(grid[0, 3]), poses[0], "from above, pose 1:\neach corner on its line"
    )
    draw_plan(
        figure.add_subplot(grid[1, 3]),
        PAPER_POSES[2],
        "from above, the paper's (-3.85, 23.60):\ncorner 2 off its line",
    )
    return figure


# --- guesses --------------------------------------------------------------------------------------


def draw_guesses(closure: Closure, poses: list[np.ndarray], points: int):
    """Over two planes of guesses, the mode that each solver reaches, and the four modes
    themselves.
    """
    modes = [np.array([*p[:3], math.radians(p[3])]) for p in poses]
    figure = new_figure(17, 9)
    figure.suptitle(
        "3-TRT + SPS platform: from which guesses each solver reaches which of the four modes",
        fontsize=15,
    )
    grid = figure.add_gridspec(2, 4)
    turn = (-math.pi, math.pi)
    planes = (
        ((2, 3), ((-150.0, 150.0), turn), "Zp [mm]", "gamma [deg]", (1.0, 180 / math.pi)),
        ((0, 3), ((-150.0, 150.0), turn), "Xp [mm]", "gamma [deg]", (1.0, 180 / math.pi)),
    )
    at = np.array([0.0, 0.0, 100.0, 0.0])
    for column, search in enumerate((rootfinder(closure), least_squares(closure))):
        for row, (plane, ranges, x, y, scales) in enumerate(planes):
            axes = figure.add_subplot(grid[row, column])
            draw_basins(
                axes,
                search,
                inside(INPUT),
                modes,
                plane,
                at,
                ranges,
                MODES,
                points=points,
                scales=scales,
            )
            axes.set(xlabel=f"guess: {x}", ylabel=f"guess: {y}", yticks=range(-180, 181, 90))
            others = "Xp = Yp = 0" if row == 0 else "Yp = 0, Zp = 100 mm"
            axes.set_title(f"{search.name}, {others}", fontsize=12)
    for k, pose in enumerate(poses):
        axes = figure.add_subplot(grid[k % 2, 2 + k // 2], projection="3d")
        draw_space(axes, pose, f"mode {k + 1}")
        axes.title.set_color(MODES[k])
    figure.supxlabel(
        "each guess has the colour of the mode that it leads to; white: no solution; circles: the "
        "modes",
        fontsize=11,
    )
    return figure
