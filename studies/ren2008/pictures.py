"""Pictures of XJ-HEXAS: figure 1, errors before calibration, guesses and modes, figures 2 and 3,
the procedure.

Source: see `study`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from studies.ren2008.errors import BEFORE, PoseErrors
from studies.ren2008.method import BEST, centres_of
from studies.ren2008.model import (
    BASE_CENTRE,
    PLATFORM_CENTRE,
    Case,
    closure,
    inverse,
    joints_of,
    turn,
)
from studies.ren2008.noise import CLAIM, COUNTS, ESTIMATORS, FIGURE_3, Noisy, Series
from studies.ren2008.procedure import Campaign
from studies.shared.guesses import draw_basins, least_squares, rootfinder
from studies.shared.report import new_figure

BLUE, RED, GREEN, PINK, GREY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#4d4d4d"
MODES = (
    "#1f77b4",
    "#aec7e8",
    "#ff7f0e",
    "#ffbb78",
    "#2ca02c",
    "#98df8a",
    "#d62728",
    "#ff9896",
    "#9467bd",
    "#c5b0d5",
    "#8c564b",
    "#c49c94",
    "#e377c2",
    "#f7b6d2",
    "#7f7f7f",
    "#bcbd22",
)
HALF = 180.0 / np.pi


def bare(axes: Any) -> None:
    axes.spines[["top", "right"]].set_visible(False)


# --- figure 1 -------------------------------------------------------------------------------------


def ends(case: Case, X: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """B_i and M_i (6, 3) in the base frame."""
    m, b, _ = joints_of(case.eta)
    return b, X[:3] + m @ turn(X[None, 3:])[0].T


def draw_body(
    axes: Any, base: np.ndarray, top: np.ndarray, colour: str = BLUE, width: float = 2.0
) -> None:
    """Base, platform and rods."""
    for points, own in ((base, GREY), (top, colour)):
        axes.plot_trisurf(
            *points.T, color=own, alpha=0.2, triangles=[(0, k, k + 1) for k in range(1, 5)]
        )
        axes.plot(*np.vstack([points, points[:1]]).T, "-o", color=own, lw=width, ms=2 + width)
    for pair in zip(base, top, strict=True):
        axes.plot(*np.array(pair).T, color=RED, lw=1.2 * width)


def draw_frame(
    axes: Any, origin: np.ndarray, R: np.ndarray, name: str, length: float = 0.3
) -> None:
    """Axes x, y, z of a frame, named at their ends."""
    for k, letter in enumerate("xyz"):
        axes.quiver(*origin, *(length * R[:, k]), color="black", lw=1.8, arrow_length_ratio=0.15)
        below = (0.0, 0.0, -0.07 if k == 0 else 0.0)
        axes.text(
            *(origin + 1.22 * length * R[:, k] + below),
            f"${letter}_{{{name}}}$",
            fontsize=12,
            ha="center",
            va="center",
        )


def draw_figure_1(case: Case):
    """The paper's figure 1: rods, joints, {M1} in M1 with x through M2, {B1} in B1 with z up and x
    towards B2; and its plan.
    """
    base, top = ends(case, case.home)
    figure = new_figure(15, 7.5)
    figure.suptitle(
        "XJ-HEXAS, figure 1 of the paper: home posture of table 1, frames {M1} and {B1}",
        fontsize=14,
    )
    space, plan = figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2)
    draw_body(space, base, top)
    draw_frame(space, base[0], np.eye(3), "B")
    draw_frame(space, top[0], turn(case.home[None, 3:])[0], "M")
    for i in range(6):
        space.text(
            *(base[i] + 0.17 * outward(base, i)),
            f"$B_{i + 1}$",
            fontsize=11,
            ha="center",
            va="center",
            color=GREY,
        )
        space.text(
            *(top[i] + 0.17 * outward(top, i)),
            f"$M_{i + 1}$",
            fontsize=11,
            ha="center",
            va="center",
            color=BLUE,
        )
    space.set(
        xlabel="x [m]",
        ylabel="y [m]",
        zlabel="z [m]",
        xlim=(-0.7, 0.85),
        ylim=(-0.2, 1.35),
        zlim=(0, 1.55),
    )
    space.set_box_aspect((1, 1, 1))
    space.locator_params(nbins=4)
    space.view_init(38, -62)
    for points, colour, letter, centre in (
        (base, GREY, "B", BASE_CENTRE),
        (top, BLUE, "M", case.home[:3] + PLATFORM_CENTRE),
    ):
        plan.plot(*np.vstack([points, points[:1]])[:, :2].T, "-o", color=colour, lw=2)
        radius = float(np.linalg.norm((points - centre)[0, :2]))
        around = centre[:2] + radius * np.column_stack(
            [f(np.linspace(0, 2 * np.pi, 181)) for f in (np.cos, np.sin)]
        )
        plan.plot(
            *around.T,
            ":",
            color=colour,
            lw=1,
            label=f"circle of the {letter}$_i$: radius {1e3 * radius:.0f} mm",
        )
        for i in range(6):
            plan.annotate(
                f"${letter}_{i + 1}$",
                points[i, :2] + 0.08 * outward(points, i)[:2],
                ha="center",
                va="center",
                fontsize=12,
                color=colour,
            )
    for pair in zip(base, top, strict=True):
        plan.plot(*np.array(pair)[:, :2].T, color=RED, lw=1.6)
    for origin in (base[0], top[0]):
        for k in range(2):
            plan.annotate(
                "",
                origin[:2] + 0.26 * np.eye(2)[k],
                origin[:2],
                arrowprops={"arrowstyle": "-|>", "lw": 1.8},
            )
    plan.set(
        xlabel="x [m]",
        ylabel="y [m]",
        aspect="equal",
        title="seen from above: arrows are the x and y axes of {B1} and {M1}",
    )
    plan.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=2)
    bare(plan)
    return figure


def outward(points: np.ndarray, i: int) -> np.ndarray:
    """Unit vector from the middle of the joints to joint i."""
    arm = points[i] - points.mean(axis=0)
    return arm / np.linalg.norm(arm)


# --- errors before calibration --------------------------------------------------------------------


def draw_before(errors: dict[str, PoseErrors], tests: np.ndarray):
    figure = new_figure(18, 5.4)
    figure.suptitle(
        "XJ-HEXAS before calibration: errors at 200 poses, and the frames in which they are told",
        fontsize=14,
    )
    place, *panels = figure.subplots(1, 3)
    centres = centres_of(tests)
    dots = place.scatter(*centres[:, :2].T, c=errors["aligned"].positions, s=26, cmap="viridis")
    figure.colorbar(dots, ax=place, label="position error, aligned frames [mm]")
    place.set(
        xlabel="x of the circle's centre [m]", ylabel="y of the circle's centre [m]", aspect="equal"
    )
    place.set_title("where in the workspace", loc="left")
    for axes, k, unit in zip(panels, (0, 1), ("mm", "deg"), strict=True):
        values = {f: (e.positions, e.angles)[k] for f, e in errors.items()}
        bins = np.linspace(0, 1.05 * max(v.max() for v in values.values()), 30)
        for (frame, own), colour in zip(values.items(), (RED, PINK, BLUE), strict=True):
            axes.hist(own, bins=bins, color=colour, alpha=0.55, label=f"{frame} frames")
        axes.axvline(
            BEFORE[k], color="black", lw=2, ls="--", label=f"the paper's {BEFORE[k]:g} {unit}"
        )
        axes.set(
            xlabel=f"{'position' if k == 0 else 'orientation'} error, infinity norm [{unit}]",
            ylabel="poses",
        )
        axes.legend(
            frameon=False,
            loc="upper center",
            bbox_to_anchor=(0.5, 1.16),
            ncols=4,
            fontsize=9,
            columnspacing=1.0,
        )
        bare(axes)
    return figure


# --- guesses --------------------------------------------------------------------------------------


def draw_guesses(case: Case, modes: list[np.ndarray], points: int):
    """Over two planes of guesses the mode that each solver reaches, and the modes themselves."""
    system, home = closure(case.eta), case.home
    given = inverse(home[None], case.eta)[0]
    figure = new_figure(19, 10)
    figure.suptitle(
        f"XJ-HEXAS at home: from which guesses each solver reaches which of the {len(modes)} "
        f"modes (white: no solution)",
        fontsize=15,
    )
    left, right = figure.subfigures(1, 2, width_ratios=(1.15, 1))
    panels = left.subplots(2, 2)
    x, y = ((home[k] - 1.2, home[k] + 1.2) for k in (0, 1))
    flat, tilted = home.copy(), home.copy()
    flat[3], tilted[2], tilted[4] = np.radians(60.0), 0.6, np.radians(70.0)
    planes = (
        (
            (2, 5),
            flat,
            ((-1.6, 1.6), (-np.pi, np.pi)),
            "z [m]",
            "gamma [deg]",
            (1.0, HALF),
            "alpha = 60 deg",
        ),
        ((0, 1), tilted, (x, y), "x [m]", "y [m]", (1.0, 1.0), "z = 0.6 m, beta = 70 deg"),
    )
    for column, search in enumerate((rootfinder(system), least_squares(system))):
        for row, (plane, at, ranges, across, up, scales, fixed) in enumerate(planes):
            axes = panels[row, column]
            draw_basins(
                axes, search, given, modes, plane, at, ranges, MODES, points=points, scales=scales
            )
            for mark in [*axes.texts, *axes.lines]:
                mark.remove()
            axes.set(xlabel=f"guess: {across}", ylabel=f"guess: {up}")
            axes.set_title(f"{search.name}: {fixed}, the others as at home", fontsize=10)
    left.supxlabel(
        "each guess has the colour of the mode that it leads to, as in the titles of the modes",
        fontsize=11,
    )
    for k, X in enumerate(modes):
        axes = right.add_subplot(4, 4, k + 1, projection="3d")
        draw_body(axes, *ends(case, X), colour=MODES[k], width=1.2)
        axes.set(
            xlim=(-0.8, 1.0), ylim=(-0.3, 1.5), zlim=(-1.5, 1.5), xticks=[], yticks=[], zticks=[]
        )
        axes.set_box_aspect((1.8, 1.8, 3.0), zoom=1.1)
        axes.view_init(14, -65)
        axes.set_title(f"mode {k + 1}", fontsize=10, color="black", backgroundcolor=MODES[k], pad=6)
    return figure


# --- figures 2 and 3 ------------------------------------------------------------------------------


def draw_calibration(noisy: Noisy, absolute: dict[str, Series]):
    """Figures 2 and 3: medians over the experiments of the worst error at 200 unused poses. Legends
    stand below the panels.
    """
    figure = new_figure(18, 9.5)
    figure.suptitle(
        "XJ-HEXAS: worst error at 200 unused poses against the number of postures (medians of "
        "experiments)",
        fontsize=14,
    )
    panels = figure.subplots(2, 4, sharex=True)
    for column, frame in enumerate(("joint", "aligned")):
        for row in (0, 1):
            draw_figure_2(panels[row, column], noisy, frame, row)
    for column, (premise, series) in enumerate(absolute.items(), start=2):
        for row in (0, 1):
            draw_figure_3(panels[row, column], noisy[FIGURE_3], series, premise, row)
    for axes in panels[1]:
        axes.set_xlabel("postures")
    for axes, place in (
        (panels[0, 0], "outside lower left"),
        (panels[0, 2], "outside lower right"),
    ):
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(
            handles, labels, loc=place, ncols=2, frameon=False, fontsize=10, handlelength=3.5
        )
    return figure


def draw_figure_2(axes: Any, noisy: Noisy, frame: str, row: int) -> None:
    for colour, (precision, by_form) in zip((BLUE, RED, GREEN, PINK), noisy.items(), strict=True):
        for (form, name), style in zip(ESTIMATORS.items(), ("-o", ":s"), strict=True):
            values = by_form[form].curve(frame)[row]
            axes.plot(COUNTS, values, style, color=colour, lw=2, ms=5, label=f"{precision}; {name}")
    axes.axhline(
        CLAIM[row], color=GREY, lw=1.2, ls="--", label="claimed at 80 postures: 0.1 mm, 0.01 deg"
    )
    axes.set_title(f"Figure 2, {frame} frames", loc="left")
    draw_axes(axes, row)


def draw_figure_3(
    axes: Any, ours: dict[str, Series], absolute: Series, premise: str, row: int
) -> None:
    lines = {
        **{ESTIMATORS[form]: series for form, series in ours.items()},
        "absolute inclinations": absolute,
    }
    for colour, (name, series) in zip((BLUE, GREEN, RED), lines.items(), strict=True):
        for frame, style in (("joint", ":s"), ("aligned", "-o")):
            axes.plot(
                COUNTS,
                series.curve(frame)[row],
                style,
                color=colour,
                lw=2,
                ms=5,
                label=f"figure 3: {name}, {frame} frames",
            )
    axes.set_title("Figure 3, rod 20 um,\n" + premise.replace(", ", ",\n"), loc="left", fontsize=10)
    draw_axes(axes, row)


def draw_axes(axes: Any, row: int) -> None:
    axes.set_yscale("log")
    axes.set_xticks(COUNTS)
    axes.set_ylabel("worst position error [mm]" if row == 0 else "worst orientation error [deg]")
    axes.grid(True, which="both", lw=0.4, color="#dddddd")
    bare(axes)


# --- the procedure --------------------------------------------------------------------------------


def draw_procedure(
    campaigns: dict[str, Campaign], conditions: dict[float, float], sizes: dict[str, float]
):
    """1.5 and (8): readings move by move, the wedges' effect, and the three causes of a neighbour
    difference.
    """
    figure = new_figure(18, 5.4)
    figure.suptitle(
        "XJ-HEXAS: levelling, wedges, and the causes of inclination differences", fontsize=14
    )
    loops, wedges, bars = figure.subplots(1, 3)
    for colour, name in ((RED, "nominal, plain"), (BLUE, "identified, carried")):
        for k, loop in enumerate(campaigns[name].loops):
            readings = np.degrees(np.abs(loop.readings).max(axis=1))
            label = f"{name.split(', ')[0]} geometry, {name.split(', ')[1]}" if k == 0 else None
            loops.semilogy(
                np.arange(1, len(readings) + 1),
                readings,
                "-",
                color=colour,
                lw=0.8,
                alpha=0.6,
                label=label,
            )
    loops.axhline(BEST.inclinometer, color=GREY, ls="--", lw=1.2, label="repeatability")
    loops.set(
        xlabel="move",
        ylabel="larger reading [deg]",
        xticks=range(1, 1 + max(int(c.moves.max()) for c in campaigns.values())),
    )
    loops.set_title("levelling of 80 postures", loc="left")
    loops.set_ylim(top=20 * loops.get_ylim()[1])
    loops.legend(frameon=False, loc="upper right", fontsize=9)
    wedges.loglog(list(conditions), list(conditions.values()), "-o", color=BLUE, lw=2)
    wedges.set(xlabel="inclinations within +- [deg]", ylabel="condition number of dC/deta, median")
    wedges.set_xticks(list(conditions), [f"{w:g}" for w in conditions])
    values = [2000, 5000, 10000, 20000, 50000]
    wedges.set_yticks(values, [f"{v:,}" for v in values])
    wedges.minorticks_off()
    wedges.set_title("40 postures; one inclination alone: rank 27 of 32", loc="left", fontsize=11)
    wedges.grid(True, which="both", lw=0.4, color="#dddddd")
    bars.barh(list(sizes), list(sizes.values()), color=[GREEN, GREEN, BLUE, BLUE, RED])
    bars.set(xscale="log", xlabel="neighbour difference in alpha, beta, rms [deg]")
    bars.set_title("equation (8): three causes", loc="left")
    bars.invert_yaxis()
    for axes in (loops, wedges, bars):
        bare(axes)
    return figure
