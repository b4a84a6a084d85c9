"""Parts of the drawings of the telescopic Pieper robot: members, axes, points, lengths, frames, planes.

Each member has one colour, as in the paper's figure 2: red, orange, yellow, green, teal, blue for members 1 to 6; each axis is an
arrow of its member's colour with its number. Units: mm (figure 1: m). Source: Yao Haifeng et al. 2020 (see `yao2020`).
"""

from __future__ import annotations

import numpy as np

from report import equal_axes
from yao2020_model import Line

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
        axes.plot(*np.array([at[one], at[other]]).T, color=colour, lw=3 if ghost else 5, solid_capstyle="round", zorder=1)


def name_points(axes, at: dict[str, np.ndarray], names: str, shifts: dict[str, tuple[float, float, float]] | None = None) -> None:
    for name in names:
        axes.plot(*at[name].reshape(3, 1), "o", color="black", ms=4)
        axes.text(*(at[name] + np.array((shifts or {}).get(name, (10, 0, 14)))), name, fontsize=13, fontstyle="italic")


def dimension(axes, one, other, name: str, shift) -> None:
    """A length between two points, drawn beside them."""
    a, b = np.add(one, shift), np.add(other, shift)
    for end, foot in ((a, one), (b, other)):
        axes.plot(*np.array([end, foot], float).T, color=GREY, lw=0.8)
    axes.plot(*np.array([a, b]).T, color="black", lw=1.2, marker="|", ms=7)
    axes.text(*((a + b) / 2 + 0.28 * np.array(shift)), name, fontsize=13, ha="left" if shift[0] else "center", va="center")


def frame(axes, length: float, at=(0.0, 0.0, 0.0)) -> None:
    for k, name in enumerate("xyz"):
        end = np.array(at) + length * np.eye(3)[k]
        axes.plot(*np.array([at, end]).T, color="black", lw=1)
        axes.text(*(end + 0.14 * length * np.eye(3)[k]), name, fontsize=11, ha="center", va="center")


def patch(axes, corners, colour: str) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.add_collection3d(Poly3DCollection([np.array(corners)], facecolor=colour, edgecolor=colour, alpha=0.22))


def box(axes, low, high, unit: str, step: float, zoom: float) -> None:
    """`equal_axes` drawn larger: long, flat boxes leave most of their place empty."""
    equal_axes(axes, low, high, unit, step)
    axes.set_box_aspect(np.subtract(high, low), zoom=zoom)
