"""Pictures of the 6-SPS platform: figure 1 as a plan, convergence and modes, guesses and modes, six
unknowns beside 24.

Source: see `study`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

import symkin
from studies.shared.guesses import Closure, Trial, draw_basins, least_squares, rootfinder
from studies.shared.report import equal_axes, new_figure
from studies.zhang2009.model import (
    BASE_DEG,
    BASE_RADIUS,
    PLATFORM_DEG,
    PLATFORM_RADIUS,
    START,
    TABLE_1,
    A,
    B,
    as_six,
    euler_pose,
    quadratic_unknowns,
    scaled,
    to_same_pose,
)
from studies.zhang2009.newton import Path, paper_newton

BLUE, RED, GREY, GREEN = "#0072b2", "#d55e00", "#7f7f7f", "#009e73"
MODES = ("#0072b2", "#56b4e9", "#d55e00", "#e69f00")
"""One colour a mode; the two of a mirror pair are alike."""


# --- figure 1 -------------------------------------------------------------------------------------


def at(radius: float, degrees: float) -> np.ndarray:
    return radius * np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])


def draw_arc(axes, radius: float, begin: float, end: float, colour: str) -> None:
    """The central angle from one joint to the next, with its size."""
    turn = np.radians(np.linspace(begin, end, 40))
    axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=colour, lw=1.4)
    for angle in (begin, end):
        axes.plot(*np.array([(0.0, 0.0), at(radius + 18, angle)]).T, ":", color=colour, lw=1)
    text = f"{end - begin:.0f}°"
    axes.text(
        *at(radius + 20, (begin + end) / 2),
        text,
        color=colour,
        ha="center",
        va="center",
        fontsize=11,
    )


def draw_plan(axes) -> None:
    """The two circles with their joints in the reference position, where the frames coincide."""
    turn = np.linspace(0, 2 * math.pi, 200)
    sides = (
        (PLATFORM_RADIUS, PLATFORM_DEG, BLUE, "A", -24, 6),
        (BASE_RADIUS, BASE_DEG, GREY, "B", 24, 0),
    )
    for radius, places, colour, letter, gap, aside in sides:
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=colour, lw=1.2)
        for i, angle in enumerate(places, start=1):
            axes.plot(*at(radius, angle), "o", color=colour, ms=7, zorder=4)
            axes.text(
                *at(radius + gap, angle + aside),
                f"${letter}_{i}$",
                color=colour,
                ha="center",
                va="center",
                fontsize=13,
            )
    for a, b in zip(A, B, strict=True):
        axes.plot([a[0], b[0]], [a[1], b[1]], color=RED, lw=2)
    for begin, end in ((90, 120), (120, 210)):
        draw_arc(axes, 95, begin, end, BLUE)
    for begin, end in ((270, 300), (300, 390)):
        draw_arc(axes, 95, begin, end, "0.35")
    for tip, name, side in (
        ((345.0, 0.0), "$X, X^1$", (0, -20)),
        ((0.0, 345.0), "$Y, Y^1$", (30, 0)),
    ):
        axes.annotate(
            "", xy=tip, xytext=(0, 0), arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 1.3}
        )
        axes.text(tip[0] + side[0], tip[1] + side[1], name, ha="center", va="center", fontsize=12)
    axes.plot(0, 0, "o", mfc="white", mec="black", ms=11)
    axes.plot(0, 0, "k.", ms=4)
    axes.text(-14, 16, "$O = O^1$", ha="right", va="center", fontsize=12)
    axes.set(xlim=(-350, 375), ylim=(-330, 375), aspect="equal", xlabel="X [mm]", ylabel="Y [mm]")
    axes.set_title(
        "plan with the frames coincident: circles of 250 and 275 mm, Z towards the reader",
        fontsize=12,
    )


def draw_frame(axes, origin: np.ndarray, R: np.ndarray, names: Sequence[str], colour: str) -> None:
    for axis, name in zip(R.T, names, strict=True):
        tip = origin + 130 * axis
        axes.plot(*np.array([origin, tip]).T, color=colour, lw=1.8)
        axes.text(*(origin + 155 * axis), name, color=colour, fontsize=11, ha="center", va="center")


def draw_platform(axes, pose: symkin.Pose, title: str) -> None:
    ends = np.array([pose.apply(a) for a in A])
    for polygon, colour in ((B, "0.45"), (ends, BLUE)):
        closed = np.vstack([polygon, polygon[:1]])
        axes.plot_trisurf(
            *polygon.T,
            triangles=[(0, i, i + 1) for i in range(1, 5)],
            color=colour,
            alpha=0.22,
            shade=False,
        )
        axes.plot(*closed.T, color=colour, lw=1.8)
    for b, a in zip(B, ends, strict=True):
        axes.plot(*np.array([b, a]).T, "-o", color=RED, lw=2, ms=3.5)
    equal_axes(axes, (-290, -290, -230), (390, 390, 230), "mm", 200)
    axes.set_title(title, fontsize=12, y=0.97)
    axes.view_init(20, -116)


def draw_figure_1(pose: symkin.Pose):
    figure = new_figure(17, 8.5)
    figure.set_layout_engine("none")
    figure.suptitle(
        "Gough-Stewart platform, figure 1: joint centres $A_i$ (platform), $B_i$ (base), and the "
        "two frames",
        fontsize=15,
    )
    draw_plan(figure.add_axes((0.05, 0.08, 0.45, 0.8)))
    axes = figure.add_axes((0.55, 0.05, 0.42, 0.85), projection="3d")
    draw_platform(axes, pose, "the frames at the pose of table 1")
    draw_frame(axes, np.zeros(3), np.eye(3), ("$X$", "$Y$", "$Z$"), "black")
    draw_frame(axes, np.array(pose.position), pose.rotation, ("$X^1$", "$Y^1$", "$Z^1$"), BLUE)
    return figure


# --- convergence and modes ------------------------------------------------------------------------


def draw_convergence(axes, right: Path, misprint: Path, printed: Path) -> None:
    labels = (
        "Newton",
        "Newton with T as misprinted, from 5° each: a false pose",
        "update as printed: X less C D",
    )
    for path, style, label, colour in zip(
        (right, misprint, printed), ("o-", "s-", "^-"), labels, (BLUE, RED, GREY), strict=True
    ):
        axes.semilogy([r for _, r in path], style, color=colour, lw=1.8, ms=6, label=label)
    axes.set(xlabel="iteration", ylabel="largest residual $|f_i|$ [mm$^2$]", ylim=(1e-13, 1e8))
    axes.set_title("Convergence from (0, 0, 100) mm without rotation", fontsize=12)
    axes.grid(alpha=0.3)
    axes.legend(loc="lower left", frameon=False, fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)


def mode_title(k: int, pose: symkin.Pose) -> str:
    x, y, z, *angles = euler_pose(pose)
    turns = r"$\alpha, \beta, \gamma$ = " + ", ".join(f"{a:.2f}°" for a in angles)
    return f"mode {k + 1}: ({x:.2f}, {y:.2f}, {z:.2f}) mm\n{turns}"


def draw(poses: list[symkin.Pose], *paths: Path):
    figure = new_figure(16, 9)
    figure.suptitle(
        "Gough-Stewart platform, direct problem of table 1: Newton's method and all four assembly "
        "modes",
        fontsize=15,
    )
    grid = figure.add_gridspec(2, 3, width_ratios=(1.15, 1, 1))
    draw_convergence(figure.add_subplot(grid[:, 0]), *paths)
    for k, pose in enumerate(poses):
        draw_platform(
            figure.add_subplot(grid[k % 2, 1 + k // 2], projection="3d"), pose, mode_title(k, pose)
        )
    return figure


# --- guesses --------------------------------------------------------------------------------------


def draw_guesses(six: Closure, poses: list[symkin.Pose], points: int):
    """Over two planes of guesses, the mode that each search reaches, and the four modes
    themselves.
    """
    modes = [scaled(euler_pose(pose)) for pose in poses]
    turn = (-math.pi / 2, math.pi / 2)
    searches = {
        "the paper's Newton, 6 unknowns": to_same_pose(paper_newton(six, "Newton, 6 unknowns")),
        "rootfinder, 24 unknowns": as_six(rootfinder(quadratic_unknowns()), six),
        "IPOPT, 6 unknowns": to_same_pose(least_squares(six)),
    }
    length = (-200 / BASE_RADIUS, 200 / BASE_RADIUS)
    planes = (
        ((2, 4), (length, turn), "z [mm]", r"$\beta$ [deg]", "x = y = 0, no other rotation"),
        (
            (3, 4),
            (turn, turn),
            r"$\alpha$ [deg]",
            r"$\beta$ [deg]",
            r"(0, 0, 100) mm, $\gamma$ = 0",
        ),
    )
    ticks = {2: range(-200, 201, 100), 3: range(-90, 91, 45)}
    figure = new_figure(20, 9.5)
    figure.suptitle(
        "Gough-Stewart platform: from which guesses each method reaches which of the four modes",
        fontsize=16,
    )
    grid = figure.add_gridspec(2, 6, width_ratios=(1, 1, 1, 0.15, 1, 1))
    for column, (title, search) in enumerate(searches.items()):
        for row, (plane, ranges, x, y, others) in enumerate(planes):
            axes = figure.add_subplot(grid[row, column])
            scales = tuple(BASE_RADIUS if k < 3 else math.degrees(1) for k in plane)
            draw_basins(
                axes,
                search,
                TABLE_1 / BASE_RADIUS,
                modes,
                plane,
                scaled(START),
                ranges,
                MODES,
                points=points,
                scales=scales,
            )
            axes.set(
                xlabel=f"guess: {x}", ylabel=f"guess: {y}", xticks=ticks[plane[0]], yticks=ticks[3]
            )
            axes.set_title(f"{title}\n{others}", fontsize=12)
    for k, pose in enumerate(poses):
        axes = figure.add_subplot(grid[k % 2, 4 + k // 2], projection="3d")
        draw_platform(axes, pose, f"mode {k + 1}")
        axes.title.set_color(MODES[k])
    figure.supxlabel(
        "each guess has the colour of the mode that it leads to; white: no solution; circles: the "
        "modes, projected",
        fontsize=12,
    )
    return figure


# --- six unknowns beside 24 -----------------------------------------------------------------------


def draw_unknowns(
    paths: dict[str, list[float]], trials: dict[str, Trial], instructions: dict[str, int]
):
    """Convergence from one start; what becomes of the same guesses; instructions of the example in
    C.
    """
    figure = new_figure(18, 6.5)
    figure.suptitle("Direct problem of table 1 in three, six and 24 unknowns", fontsize=15)
    left, middle, right = figure.subplots(1, 3)
    for (name, path), style, colour in zip(
        paths.items(), ("o-", "s--", "^:"), (BLUE, RED, GREEN), strict=True
    ):
        left.semilogy(path, style, color=colour, lw=1.8, ms=6, label=name)
    left.set(xlabel="iteration", ylabel="largest residual over the base's radius squared")
    left.set_title("the paper's Newton", fontsize=12)
    left.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=1, frameon=False, fontsize=10
    )
    left.grid(alpha=0.3)
    names, begin = list(trials), np.zeros(len(trials))
    for k in range(4):
        share = np.array([100 * t.hits[k] / len(t.ends) for t in trials.values()])
        middle.barh(names, share, left=begin, color=MODES[k], label=f"mode {k + 1}")
        begin += share
    middle.barh(names, 100 - begin, left=begin, color="0.9", label="none")
    middle.set(xlabel="share of the same random guesses [%]", xlim=(0, 100))
    middle.invert_yaxis()
    middle.set_title("modes met", fontsize=12)
    middle.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=5, frameon=False, fontsize=10
    )
    right.barh(list(instructions), list(instructions.values()), color=(BLUE, RED, GREY, GREEN))
    right.set_xscale("log")
    right.set(xlabel="instructions on a Cortex-M7", xlim=(1e4, 1e7))
    for k, value in enumerate(instructions.values()):
        right.text(value * 1.1, k, f"{value:,}", va="center", fontsize=11)
    right.invert_yaxis()
    right.set_title("the example in C, double precision", fontsize=12)
    return figure
