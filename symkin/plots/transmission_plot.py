"""The picture of a transmission: the torque of each joint over the range, and the torques that are
possible together, or ratios of a single joint.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.palette import COLOURS, SERIES
from symkin.plots.sheet import new_figure
from symkin.plots.style import drawing
from symkin.text import matplotlib_text
from symkin.transmissions.transmission_result import Transmission, Transmissions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PANEL = (4.0, 3.7)
"""Inches of a panel."""
_SPREAD = 95.0
"""Percentile of torques at which colours and axes end: near a dead centre they grow without
bound.
"""


def figure_of_transmission(found: Transmission) -> Figure:
    """The largest torque of each joint alone, over the joints' range, each with its least place;
    beside it all torques of two joints at the reference and where each is least. Of a single joint
    torque and ratio are curves.
    """
    return _figure([found])


def figure_of_transmissions(found: Transmissions) -> Figure:
    """A row of panels for each transmission."""
    return _figure(list(found.found))


def _figure(several: list[Transmission]) -> Figure:
    columns = max(_panels(one) for one in several)
    with drawing():
        size = (_PANEL[0] * columns, _PANEL[1] * len(several))
        figure = new_figure(*size)
        axes: Any = figure.subplots(len(several), columns, squeeze=False)
        for row, one in zip(axes, several, strict=True):
            _draw(one, row)
            for ax in row[_panels(one) :]:
                ax.set_axis_off()
    return figure


def _panels(one: Transmission) -> int:
    return len(one.joints) + (len(one.joints) <= 2)


def _draw(one: Transmission, axes: Any) -> None:
    survey, n = one.survey, len(one.joints)
    joints = np.array(
        [[survey.out(i, v) for i, v in enumerate(row)] for row in survey.states.joints]
    )
    unit = one.linkage.mechanism.angle_unit
    labels = [
        matplotlib_text(f"{c.name}, {unit if c.is_angular else one.linkage.mechanism.length_unit}")
        for c in one.linkage.coordinates_of(one.joints)
    ]
    for i, ax in enumerate(axes[:n]):
        ax.set_title(matplotlib_text(f"torque of {one.joints[i]} alone"), fontsize=9)
        torque = survey.alone[:, i]
        high = np.percentile(torque, _SPREAD)
        if n == 2:
            _map(ax, joints, torque, high)
            least = int(np.argmin(torque))
            ax.plot(
                *joints[least], "v", color=COLOURS["accent"], label=f"least {torque[least]:.3g}"
            )
            ax.plot(*joints[0], "o", color=COLOURS["text"], label=f"reference {torque[0]:.3g}")
            ax.set_xlabel(labels[0])
            ax.set_ylabel(labels[1])
            ax.legend(fontsize=7, framealpha=0.9)
            continue
        order = np.argsort(joints[:, i])
        look = "-" if n == 1 else "."
        ax.plot(joints[order, i], torque[order], look, color=SERIES[0], markersize=3)
        ax.set_ylim(0.0, 1.1 * high)
        ax.set_xlabel(labels[i])
        ax.grid(True)
    if n == 1:
        _ratios(one, axes[1], joints, labels[0])
    elif n == 2:
        _polytopes(one, axes[2], joints)


def _map(ax: Any, joints: np.ndarray, torque: np.ndarray, high: float) -> None:
    """Torques over two joints."""
    image = ax.scatter(
        *joints.T, c=torque, s=22, marker="s", linewidths=0, cmap="viridis", vmin=0.0, vmax=high
    )
    ax.figure.colorbar(image, ax=ax, extend="max", fraction=0.05)


def _ratios(one: Transmission, ax: Any, joints: np.ndarray, label: str) -> None:
    order = np.argsort(joints[:, 0])
    ratios = one.survey.states.inverse_jacobian[order, :, 0]
    for a, name in enumerate(one.motors):
        ax.plot(
            joints[order, 0],
            ratios[:, a],
            color=SERIES[a % len(SERIES)],
            label=matplotlib_text(name),
        )
    low, high = np.percentile(ratios, [100.0 - _SPREAD, _SPREAD])
    ax.set_ylim(low - 0.2 * (high - low) - 0.05, high + 0.2 * (high - low) + 0.05)
    ax.set_title("ratio: motor's rate by the joint's", fontsize=9)
    ax.set_xlabel(label)
    ax.grid(True)
    ax.legend(fontsize=7)


def _polytopes(one: Transmission, ax: Any, joints: np.ndarray) -> None:
    """All torques of two joints at some places."""
    survey = one.survey
    rows = dict.fromkeys([0, *(int(np.argmin(survey.alone[:, i])) for i in range(2))])
    for colour, row in zip(SERIES, rows, strict=False):
        corners = survey.torques_at(row)
        name = ", ".join(f"{v:.2g}" for v in joints[row]) if row else "reference"
        ax.fill(*corners.T, facecolor="none", edgecolor=colour, linewidth=1.6, label=name)
    reach = 1.6 * np.abs(survey.torques_at(0)).max(axis=0)
    ax.set_xlim(-reach[0], reach[0])
    ax.set_ylim(-reach[1], reach[1])
    ax.axhline(0.0, color=COLOURS["axis"], linewidth=0.6)
    ax.axvline(0.0, color=COLOURS["axis"], linewidth=0.6)
    ax.set_title("torques of both together", fontsize=9)
    ax.set_xlabel(matplotlib_text(one.joints[0]))
    ax.set_ylabel(matplotlib_text(one.joints[1]))
    ax.grid(True)
    ax.legend(fontsize=7)
