"""Pictures of the Gluon-6L3: axes and dimensions at zero joints, solutions of the inverse problem,
guesses that lead to them.

Source: see `study`.
"""

from __future__ import annotations

import numpy as np

from studies.gluon_6l3.model import EXAMPLE, A, D, closed_form, forward, frames
from studies.gluon_6l3.numeric import Equations, given_numbers, rootfinder_of_six
from studies.shared.guesses import draw_basins, least_squares
from studies.shared.report import equal_axes, new_figure

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#9e9ac8")
AXES = ("#d62728", "#2ca02c", "#1f77b4")
"""Colours of x, y, z of a frame."""
LINK, AXIS = "0.35", "#d55e00"
DEGREES = 180 / np.pi


# --- axes and zero pose ---------------------------------------------------------------------------


def draw_frame(axes, F: np.ndarray, length: float, name: str = "", height: float = 0.0) -> None:
    for direction, colour in zip(F[:3, :3].T, AXES, strict=True):
        axes.quiver(*F[:3, 3], *(length * direction), color=colour, lw=1.5)
    if name:
        axes.text(*(F[:3, 3] + (0, 0, height)), name, fontsize=11, ha="center", va="center")


def draw_joints(axes, q: np.ndarray, title: str) -> None:
    """Links, the six axes with their numbers, joints as short thick pieces of their axes, base and
    tool frames.
    """
    chain = frames(q)
    points = np.array([F[:3, 3] for F in chain])
    axes.plot(
        *points.T, color=LINK, lw=5, solid_capstyle="round", solid_joinstyle="round", zorder=1
    )
    for k, F in enumerate(chain[:6], start=1):
        o, z = F[:3, 3], F[:3, 2]
        axes.plot(*np.array([o - 60 * z, o + 60 * z]).T, "--", color=AXIS, lw=1.2)
        axes.plot(
            *np.array([o - 16 * z, o + 16 * z]).T, color=AXIS, lw=9, solid_capstyle="butt", zorder=3
        )
        axes.text(
            *(o - 80 * z),
            str(k),
            color=AXIS,
            fontsize=12,
            fontweight="bold",
            ha="center",
            va="center",
        )
    draw_frame(axes, chain[0] @ shifted(0, -130, 0), 70, "base", -80)
    draw_frame(axes, chain[6], 70, "tool", 55)
    low, high = np.minimum(points.min(0) - 95, -150), points.max(0) + 95
    equal_axes(axes, low, high, "mm", 200)
    axes.set_box_aspect(high - low, zoom=0.92)
    axes.set_title(title, fontsize=12)
    axes.view_init(18, -35)


def shifted(x: float, y: float, z: float) -> np.ndarray:
    F = np.eye(4)
    F[:3, 3] = x, y, z
    return F


def draw_dimensions(axes) -> None:
    """The zero pose seen along x: all links and axes lie in the plane y, z."""
    chain = frames(np.zeros(6))
    points = np.array([F[1:3, 3] for F in chain])
    axes.plot(*points.T, color=LINK, lw=4, solid_capstyle="round", solid_joinstyle="round")
    for k, F in enumerate(chain[:6], start=1):
        o, z = F[1:3, 3], F[1:3, 2]
        along = z / np.linalg.norm(z)
        axes.plot(*np.array([o - 45 * along, o + 45 * along]).T, "--", color=AXIS, lw=1.2)
        axes.plot(
            *np.array([o - 14 * along, o + 14 * along]).T,
            color=AXIS,
            lw=13,
            solid_capstyle="butt",
            zorder=3,
        )
        axes.annotate(
            str(k),
            o - 58 * along,
            color=AXIS,
            fontsize=13,
            fontweight="bold",
            ha="center",
            va="center",
        )
    names = (
        ("d1", D[0], 0),
        ("a2", -A[1], 1),
        ("a3", -A[2], 2),
        ("d4", D[3], 3),
        ("d5", D[4], 4),
        ("d6", D[5], 5),
    )
    for name, value, k in names:
        a, b = points[k], points[k + 1]
        upright = abs(b[1] - a[1]) > abs(b[0] - a[0])
        side = np.array([92.0 if k < 3 else -62.0, 0.0]) if upright else np.array([0.0, 26.0])
        axes.annotate(
            "",
            a + side,
            b + side,
            arrowprops={"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0, "lw": 1.0},
        )
        place = (a + b) / 2 + side
        text = f"|{name}| = {value:.2f}" if name.startswith("a") else f"{name} = {value:.2f}"
        if upright:
            axes.text(
                *(place + (5 if k < 3 else -5, 0)),
                text,
                fontsize=11,
                va="center",
                ha="left" if k < 3 else "right",
            )
        else:
            where, align = (
                ((place + (0, 8)), "center") if k == 5 else (np.array([8.0, place[1]]), "left")
            )
            axes.text(*where, text, fontsize=11, ha=align, va="bottom" if k == 5 else "center")
    axes.set(xlim=(-300, 265), ylim=(-90, 640), aspect="equal", xlabel="y [mm]", ylabel="z [mm]")
    axes.set_title("zero joints seen along x, dimensions in mm", fontsize=12)


def draw_arm():
    figure = new_figure(17, 7)
    figure.suptitle(
        "Gluon-6L3: joint axes 1 to 6 (2, 3, 4 parallel), base and tool frame (x red, y green, z "
        "blue)",
        fontsize=14,
    )
    grid = figure.add_gridspec(1, 3)
    draw_joints(
        figure.add_subplot(grid[0], projection="3d"), np.zeros(6), "zero joints: the arm is upright"
    )
    draw_dimensions(figure.add_subplot(grid[1]))
    draw_joints(
        figure.add_subplot(grid[2], projection="3d"),
        EXAMPLE,
        "15° at every joint, the page's example",
    )
    return figure


# --- solutions ------------------------------------------------------------------------------------


def draw_solutions(axes, T: np.ndarray, title: str, numbers: bool = False) -> None:
    paths = [np.array([F[:3, 3] for F in frames(q)]) for q in closed_form(T)]
    for k, (path, colour) in enumerate(zip(paths, COLOURS, strict=False), start=1):
        label = f"solution {k}" if numbers else None
        axes.plot(*path.T, "-o", color=colour, lw=2.4, ms=3.5, solid_capstyle="round", label=label)
    tool, points = T[:3, 3], np.vstack(paths)
    draw_frame(axes, T, 60)
    axes.plot(*tool, "k*", ms=10)
    axes.plot([0, 0], [0, 0], [-25, 5], color="0.4", lw=10, solid_capstyle="butt")
    middle, half = (points.max(0) + points.min(0)) / 2, 0.55 * np.ptp(points, axis=0).max()
    low, high = middle - half, middle + half
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set(xlabel="x [mm]", ylabel="y [mm]", title=title)
    axes.zaxis.set_rotate_label(False)
    axes.set_zlabel("z [mm]", labelpad=8, rotation=90)
    axes.set_box_aspect((1, 1, 1), zoom=0.9)
    axes.locator_params(nbins=5)
    axes.view_init(18, -115)
    if numbers:
        axes.legend(fontsize=9, loc="upper left", ncols=2)


def draw(counts: np.ndarray, eight: np.ndarray):
    """The example's two solutions, a pose with eight, and how many random poses have."""
    figure = new_figure(16, 5.6)
    figure.suptitle("Gluon-6L3: the inverse problem in closed form", fontsize=14)
    grid = figure.add_gridspec(1, 3, width_ratios=(1.15, 1.15, 1))
    draw_solutions(
        figure.add_subplot(grid[0], projection="3d"),
        forward(EXAMPLE),
        "15° at every joint: 2 solutions",
    )
    draw_solutions(
        figure.add_subplot(grid[1], projection="3d"), eight, "a random pose: 8 solutions"
    )
    axes = figure.add_subplot(grid[2])
    share = [100 * np.mean(counts == n) for n in (2, 4, 6, 8)]
    bars = axes.bar(["2", "4", "6", "8"], share, color=COLOURS[0], width=0.6)
    axes.bar_label(bars, fmt="%.1f %%", padding=3)
    axes.set(
        xlabel="number of real solutions", ylabel="share of poses [%]", ylim=(0, 1.12 * max(share))
    )
    axes.set_title(f"{len(counts)} poses of random joint angles")
    axes.spines[["top", "right"]].set_visible(False)
    return figure


# --- guesses --------------------------------------------------------------------------------------


def draw_guesses(system: Equations, eight: np.ndarray, points: int):
    """Over two planes of guesses, the solution that each solver reaches, and the solutions
    themselves.
    """
    figure = new_figure(17, 10)
    figure.suptitle(
        "Gluon-6L3, inverse problem: from which guesses each solver reaches which solution",
        fontsize=15,
    )
    grid = figure.add_gridspec(2, 3, width_ratios=(1, 1, 1.05))
    searches = (rootfinder_of_six(system.twelve, system.tangents), least_squares(system.twelve))
    cases = ((forward(EXAMPLE), "15° at every joint", (2, 4)), (eight, "a random pose", (2, 4)))
    for row, (T, name, plane) in enumerate(cases):
        modes = closed_form(T)
        for column, search in enumerate(searches):
            axes = figure.add_subplot(grid[row, column])
            draw_basins(
                axes,
                search,
                given_numbers(T),
                modes,
                plane,
                modes[0],
                ((-np.pi, np.pi),) * 2,
                COLOURS,
                points=points,
                scales=(DEGREES, DEGREES),
            )
            axes.set(xticks=range(-180, 181, 90), yticks=range(-180, 181, 90))
            axes.set(xlabel=f"guess: q{plane[0] + 1} [deg]", ylabel=f"guess: q{plane[1] + 1} [deg]")
            axes.set_title(f"{search.name}, {name}", fontsize=12)
        title = f"{name}: {len(modes)} solutions"
        draw_solutions(figure.add_subplot(grid[row, 2], projection="3d"), T, title, numbers=True)
    figure.supxlabel(
        "each guess has the colour of the solution that it leads to, its other joints those of "
        "solution 1; white: no solution, as "
        "on the singular lines q3 = 0, q5 = 0; circles: q3, q5 of the solutions",
        fontsize=11,
    )
    return figure
