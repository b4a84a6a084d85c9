"""Pictures of the telescopic Pieper robot's inverse problem: its function and roots, guesses, holes
and reach; their parts.

Each member has one colour, as in the paper's figure 2: red, orange, yellow, green, teal, blue for
members 1 to 6; each axis is an arrow of its member's colour with its number. Units: mm (figure 1:
m); degrees. Source: Yao Haifeng et al. 2020 (see `study`).
"""

from __future__ import annotations

import math

import numpy as np

import symkin
from studies.shared.guesses import draw_basins, least_squares, rootfinder
from studies.shared.report import equal_axes, new_figure
from studies.yao2020.holes import FACE, FEED, SPACING, holes, worst_of_equal_errors
from studies.yao2020.inverse import (
    axis5_origin,
    distance_function,
    f_iteration,
    inside,
    inverse,
    plane_closure,
    point_closure,
    slides,
    square_closure,
    three_points,
)
from studies.yao2020.model import A1, A2, D1, STROKE, TIP, Line, goal_rotation, placed, turn
from symkin.following.track_result import Track

MEMBERS = ("#d62728", "#ff7f0e", "#d4b100", "#2ca02c", "#17a2b8", "#1f4ed8")
GREY = "0.55"


def arrow(axes, line: Line, number: int, length: float, back: float = 0.35) -> None:
    """An axis with its number, running from `back` of its length behind its point."""
    point, direction = line
    start, end = point - back * length * direction, point + length * direction
    axes.quiver(*start, *(end - start), color=MEMBERS[number - 1], lw=1.8, arrow_length_ratio=0.12)
    axes.text(
        *(end + 0.18 * length * direction),
        str(number),
        color=MEMBERS[number - 1],
        fontsize=13,
        fontweight="bold",
        ha="center",
        va="center",
    )


def members(axes, at: dict[str, np.ndarray], *, ghost: bool = False) -> None:
    """O F (members 1 to 3), F E (4), E D (5), D A (6)."""
    for (one, other), k in zip(("OF", "FE", "ED", "DA"), (3, 4, 5, 6), strict=True):
        colour = "0.8" if ghost else MEMBERS[k - 1]
        axes.plot(
            *np.array([at[one], at[other]]).T,
            color=colour,
            lw=3 if ghost else 5,
            solid_capstyle="round",
            zorder=1,
        )


def name_points(
    axes,
    at: dict[str, np.ndarray],
    names: str,
    shifts: dict[str, tuple[float, float, float]] | None = None,
) -> None:
    for name in names:
        axes.plot(*at[name].reshape(3, 1), "o", color="black", ms=4)
        axes.text(
            *(at[name] + np.array((shifts or {}).get(name, (10, 0, 14)))),
            name,
            fontsize=13,
            fontstyle="italic",
        )


def dimension(axes, one, other, name: str, shift) -> None:
    """A length between two points, drawn beside them."""
    a, b = np.add(one, shift), np.add(other, shift)
    for end, foot in ((a, one), (b, other)):
        axes.plot(*np.array([end, foot], float).T, color=GREY, lw=0.8)
    axes.plot(*np.array([a, b]).T, color="black", lw=1.2, marker="|", ms=7)
    axes.text(
        *((a + b) / 2 + 0.28 * np.array(shift)),
        name,
        fontsize=13,
        ha="left" if shift[0] else "center",
        va="center",
    )


def frame(axes, length: float, at=(0.0, 0.0, 0.0)) -> None:
    for k, name in enumerate("xyz"):
        end = np.array(at) + length * np.eye(3)[k]
        axes.plot(*np.array([at, end]).T, color="black", lw=1)
        axes.text(
            *(end + 0.14 * length * np.eye(3)[k]), name, fontsize=11, ha="center", va="center"
        )


def patch(axes, corners, colour: str) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.add_collection3d(
        Poly3DCollection([np.array(corners)], facecolor=colour, edgecolor=colour, alpha=0.22)
    )


def box(axes, low, high, unit: str, step: float, zoom: float) -> None:
    """`equal_axes` drawn larger: long, flat boxes leave most of their place empty."""
    equal_axes(axes, low, high, unit, step)
    axes.set_box_aspect(np.subtract(high, low), zoom=zoom)


# --- colours of solutions -------------------------------------------------------------------------

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")


# --- the function and the four configurations -----------------------------------------------------


def draw(solutions: list[np.ndarray]):
    figure = new_figure(15, 6.4)
    figure.suptitle(
        "Telescopic Pieper robot: the inverse problem of the worked example", fontsize=14
    )
    grid = figure.add_gridspec(1, 2, width_ratios=(1, 1.15))
    draw_function(figure.add_subplot(grid[0]))
    draw_arms(figure.add_subplot(grid[1], projection="3d"), solutions)
    return figure


def draw_function(axes) -> None:
    A, R = TIP, goal_rotation()
    f, literal, x = distance_function(A, R), f_iteration(A, R), np.linspace(-560, 60, 400)
    axes.axvspan(*STROKE, color="0.93", label="the paper's interval")
    axes.plot(
        x,
        [literal(v) for v in x],
        "--",
        color=COLOURS[3],
        lw=1.8,
        label="θ5 by its sine alone, as (6) is told",
    )
    axes.plot(x, [f(v) for v in x], color="0.15", lw=1.8, label="f(L6) = |OF| - a1")
    axes.axhline(0, color="0.5", lw=0.8)
    for root, colour in zip(sorted(slides(A, R), reverse=True), COLOURS, strict=False):
        axes.plot(root, 0, "o", color=colour, ms=8, label=f"root, L6 = {root:.4f} mm")
    axes.plot(
        [-500, -250, 0], [f(-500), f(-250), f(0)], "kx", ms=8, label="the loop's first three points"
    )
    axes.set(
        xlabel="L6 [mm]",
        ylabel="f [mm]",
        title="The paper's function and its roots",
        ylim=(-60, 190),
    )
    axes.legend(loc="upper right", fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)


def draw_arms(axes, solutions: list[np.ndarray]) -> None:
    """Two solutions with the same L6 place all links alike and differ in axis 2, drawn as an arrow
    at O.
    """
    for k, (q, colour) in enumerate(zip(solutions, COLOURS, strict=True), start=1):
        draw_configuration(
            axes, q, colour, "-o" if k % 2 else "--o", f"{k}: θ1 = {q[0]:.1f}°, L6 = {q[5]:.1f} mm"
        )
    for name, point in zip("OA", (np.zeros(3), TIP), strict=True):
        axes.plot(*point.reshape(3, 1), "k*" if name == "A" else "ks", ms=9)
        axes.text(
            *(point + [20, -25, -30] if name == "O" else point + [-8, -18, 22]), name, fontsize=13
        )
    equal_axes(axes, (-560, -130, -60), (40, 420, 220), "mm", 200)
    axes.set_title("The four configurations at the paper's pose; arrows: axis 2")
    axes.legend(loc="upper center", ncols=2, frameon=False, fontsize=9, handlelength=3)
    axes.view_init(32, -75)


def draw_configuration(
    axes, q: np.ndarray, colour: str, style: str = "-o", label: str | None = None
) -> None:
    """O, F, E, D, A and axis 2."""
    at, axis2 = placed(q), 110 * turn("z", q[0])[:, 1]
    axes.plot(
        *np.array([at[name] for name in "OFEDA"]).T, style, color=colour, lw=2.6, ms=4, label=label
    )
    axes.quiver(0, 0, 0, *axis2, color=colour, lw=2, arrow_length_ratio=0.2)


# --- guesses --------------------------------------------------------------------------------------


def draw_guesses(solutions: list[np.ndarray], points: int):
    """The solution that each guess leads to: of L6 and theta5 by (5) to (8), and of theta1 and L6,
    the others zero, by (3).
    """
    A, R = TIP, goal_rotation()
    e, goal = axis5_origin(A, R), three_points(A, R)
    pairs, modes = (
        [np.array([q[5], math.radians(q[4])]) for q in solutions[::2]],
        [inside(q) for q in solutions],
    )
    turns, reach = (-math.pi, math.pi), (-600.0, 100.0)
    figure = new_figure(18, 9.5)
    figure.suptitle(
        "Telescopic Pieper robot: from which guesses each solver reaches which solution",
        fontsize=15,
    )
    grid = figure.add_gridspec(2, 4)
    two = {"rootfinder": rootfinder(plane_closure()), "IPOPT": least_squares(plane_closure())}
    six = {"rootfinder": rootfinder(square_closure()), "IPOPT": least_squares(point_closure())}
    degree = 180 / math.pi
    for column, name in enumerate(two):
        axes = figure.add_subplot(grid[0, column])
        draw_basins(
            axes,
            two[name],
            e,
            pairs,
            (0, 1),
            np.zeros(2),
            (reach, turns),
            COLOURS[::2],
            points=points,
            scales=(1.0, degree),
        )
        axes.set(xlabel="guess: L6 [mm]", ylabel="guess: θ5 [deg]", yticks=range(-180, 181, 90))
        axes.set_title(
            f"{name}, (5)-(8): L6 and θ5\n1: solutions 1, 2; 2: solutions 3, 4", fontsize=12
        )
        axes = figure.add_subplot(grid[1, column])
        draw_basins(
            axes,
            six[name],
            goal,
            modes,
            (0, 5),
            np.zeros(6),
            (turns, reach),
            COLOURS,
            points=points,
            scales=(degree, 1.0),
        )
        axes.set(xlabel="guess: θ1 [deg]", ylabel="guess: L6 [mm]", xticks=range(-180, 181, 90))
        axes.set_title(f"{name}, (3): six joints,\nguess θ2 to θ5 = 0", fontsize=12)
    for k, q in enumerate(solutions):
        axes = figure.add_subplot(grid[k % 2, 2 + k // 2], projection="3d")
        draw_configuration(axes, q, COLOURS[k])
        equal_axes(axes, (-560, -130, -60), (80, 420, 220), "mm", 200)
        axes.set_title(
            f"solution {k + 1}: θ1 = {q[0]:.1f}°,\nθ5 = {q[4]:.1f}°, L6 = {q[5]:.1f} mm",
            fontsize=12,
            color=COLOURS[k],
        )
        axes.view_init(32, -75)
    figure.supxlabel(
        "each guess has the colour of the solution that it leads to; white: none; circles: the "
        "solutions; arrows: axis 2",
        fontsize=11,
    )
    return figure


# --- section 3.3 ----------------------------------------------------------------------------------


def draw_holes(arm: symkin.Mechanism, track: Track):
    """Figures 8 to 11 as far as the printed data go."""
    figure = new_figure(19, 10)
    figure.suptitle(
        "Section 3.3: 86 holes (the pattern is ours) on one working mode, and what is printed of "
        "figures 8 to 11",
        fontsize=15,
    )
    grid = figure.add_gridspec(2, 3, width_ratios=(1.1, 1, 1))
    draw_seat(figure.add_subplot(grid[0, 0], projection="3d"))
    draw_robot(figure.add_subplot(grid[1, 0], projection="3d"), track)
    draw_face(figure.add_subplot(grid[0, 1]))
    draw_errors(figure, figure.add_subplot(grid[0, 2]), arm, track)
    joints, place = (
        np.array([s.actuated for s in track.samples]),
        np.arange(len(track.samples)) / 3 + 1,
    )
    draw_angles(figure.add_subplot(grid[1, 1]), joints, place)
    draw_slide(figure.add_subplot(grid[1, 2]), joints, place)
    return figure


def draw_seat(axes) -> None:
    """Figure 8: the printed pose and the last 40 mm before it."""
    q = inverse(TIP, goal_rotation())[0]
    members(axes, placed([*q[:5], q[5] + 40]), ghost=True)
    members(axes, placed(q))
    axes.plot(*np.array([TIP + 40 * goal_rotation()[:, 0], TIP]).T, color="black", lw=2.5)
    axes.text(*(TIP + (-20, 0, -45)), "A", fontsize=13, fontstyle="italic")
    equal_axes(axes, (-560, -130, -60), (80, 420, 220), "mm", 200)
    axes.set_title(
        "figure 8: the seat goes to the cutting head\nalong axis 6 (black: the last 40 mm)",
        fontsize=12,
    )
    axes.view_init(32, -75)


def draw_robot(axes, track: Track) -> None:
    """Figure 10: the robot at three holes."""
    for index in (0, 42, 85):
        members(axes, placed(track.samples[3 * index + 1].actuated))
    y, z = holes().T
    axes.plot(np.full(len(y), FACE), y, z, ".", color="0.3", ms=4)
    equal_axes(axes, (-680, -420, -220), (60, 420, 420), "mm", 200)
    axes.set_box_aspect((740, 840, 640), zoom=0.95)
    axes.set_title("figure 10: drilling the first, the 43rd\nand the last hole", fontsize=12)
    axes.view_init(18, -38)


def draw_face(axes) -> None:
    turns, y = np.linspace(-math.pi / 2, math.pi / 2, 60), holes()
    edge = np.array([A2 + A1 * np.cos(turns), D1 + A1 * np.sin(turns)]).T
    rim = np.vstack([edge, edge[::-1] * (-1, 1)])
    axes.fill(*rim.T, color="0.93")
    axes.plot(*np.vstack([rim, rim[:1]]).T, color="black", lw=1.2)
    axes.plot(*y.T, "-o", color=COLOURS[0], lw=1, ms=5)
    for k in (0, len(y) - 1):
        axes.annotate(
            str(k + 1),
            y[k],
            xytext=(0, 6 if k == 0 else -15),
            textcoords="offset points",
            ha="center",
            fontsize=11,
        )
    axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]", xlim=(-420, 420), ylim=(-260, 470))
    axes.set_title(
        f"holes {SPACING:g} mm apart, in their order,\nin the wrist's reach 2 (a1 + a2) by 2 a1",
        fontsize=12,
    )


def draw_errors(figure, axes, arm: symkin.Mechanism, track: Track) -> None:
    jacobian, (y, z) = symkin.jacobian(arm, kind="direct"), holes().T
    values = [worst_of_equal_errors(jacobian, s.solution) for s in track.samples[1::3]]
    shown = axes.scatter(y, z, c=values, cmap="viridis", s=70)
    figure.colorbar(shown, ax=axes, label="most that A moves [mm]")
    axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]", xlim=(-330, 330))
    axes.set_title(
        "figure 11 has measured offsets, at most 27.6 mm;\n"
        "here: A for errors of 1° in joints 1 to 5",
        fontsize=12,
    )


def draw_angles(axes, joints: np.ndarray, place: np.ndarray) -> None:
    for k in range(5):
        axes.plot(place, joints[:, k], color=MEMBERS[k], lw=1.6, label=f"θ{k + 1}")
    axes.set(
        xlabel="hole", ylabel="joint angle [deg]", title="joints along the path", ylim=(-75, 95)
    )
    axes.legend(ncols=5, loc="upper center", fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)


def draw_slide(axes, joints: np.ndarray, place: np.ndarray) -> None:
    axes.axhspan(*STROKE, color="0.93", label="the paper's interval of L6")
    axes.plot(
        place, joints[:, 5], color=MEMBERS[5], lw=1.2, label=f"L6; each hole is {FEED:g} mm deep"
    )
    axes.set(xlabel="hole", ylabel="L6 [mm]", title="the slide along the path", ylim=(-540, 110))
    axes.legend(loc="upper right", fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)
