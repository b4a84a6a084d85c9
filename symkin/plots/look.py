"""How configurations are drawn and told: limbs with base and platform in space, or links joined in
any way with a colour each.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.closure.closure import build_closure
from symkin.model.mechanism import Mechanism
from symkin.plots.graph_figures import GraphBlock, GraphPanel, panels_of_graph
from symkin.plots.graph_lines import reference_graph_lines, solution_lines
from symkin.plots.mechanism_lines import lines_at, reference_lines
from symkin.plots.panel_figure import Panel, PanelBlock, panel_figure
from symkin.position.given import leaves_motion
from symkin.position.solution import Solution
from symkin.spatial.rotation import euler_from_quaternion

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Look:
    """How configurations are drawn: a panel's type, lines of a solution and of the reference, text
    of a solution for given names, the figure of several panels, and the panels as a part of another
    figure.
    """

    panel: Callable[[str, str, Any], Any]
    lines: Callable[[Solution], Any]
    reference: Callable[[Mechanism], Any]
    text: Callable[[Solution, Sequence[str]], str]
    figure: Callable[..., Figure]
    block: Callable[..., PanelBlock | GraphBlock]


def look_of(mechanism: Mechanism) -> Look:
    """Limbs are drawn with base and platform in space; links joined in any way with a colour each,
    in a plane where they move in one.
    """
    if mechanism.is_graph:
        return Look(
            GraphPanel,
            solution_lines,
            reference_graph_lines,
            _joints_text,
            panels_of_graph,
            GraphBlock.of,
        )
    return Look(
        Panel,
        lambda s: lines_at(s.mechanism, s.values, s.pose),
        reference_lines,
        _mode_text,
        panel_figure,
        PanelBlock.of,
    )


def _joints_text(solution: Solution, given: Sequence[str]) -> str:
    """The first few single joint coordinates that were not given; below them where the platform's
    link is.
    """
    values = {
        name: v for name, v in solution.joints.items() if isinstance(v, float) and name not in given
    }
    size = solution.mechanism.characteristic_length
    scale = {c.name: 1.0 if c.is_angular else size for c in solution.mechanism.coordinates}
    first = list(values)[:_MOST_VALUES]
    clean = [_clean([values[name]], scale[name])[0] for name in first]
    shown = ", ".join(
        f"{name}\N{NO-BREAK SPACE}{v + 0.0:.5g}" for name, v in zip(first, clean, strict=True)
    )
    more = ",\N{NO-BREAK SPACE}..." if len(values) > _MOST_VALUES else ""
    pose = _pose_text(solution) if solution.has_platform else ""
    return "\n".join(line for line in (shown + more, pose) if line)


_MOST_VALUES = 4
"""Joint coordinates that are written above a panel."""


def _mode_text(solution: Solution, given: Sequence[str]) -> str:
    """Where the mode is: the platform's pose, or where that is given the actuated joints."""
    posed = any(c.name in given for c in build_closure(solution.mechanism).role("pose"))
    return f"joints {listed(solution.actuated_values)}" if posed else _pose_text(solution)


def limits_text(solution: Solution) -> str:
    return {
        None: "",
        True: "\n\N{CHECK MARK} within limits",
        False: "\n\N{BALLOT X} outside limits",
    }[solution.within_limits]


def _pose_text(solution: Solution) -> str:
    """Position and orientation: the angle of a motion with one, else roll, pitch and yaw, where the
    motion turns at all.
    """
    mechanism = solution.mechanism
    text = (
        f"position {listed(_clean(solution.position, mechanism.characteristic_length))} "
        f"{mechanism.length_unit}"
    )
    leaves = mechanism.is_graph and leaves_motion(mechanism, [solution.pose])
    if mechanism.motion in ("schoenflies", "planar") and not leaves:
        (angle,) = _clean([mechanism.angle_out(solution.gamma)], 1.0)
        return f"{text.removeprefix('position ')}, gamma {angle:.5g} {mechanism.angle_unit}"
    turn = euler_from_quaternion(np.asarray(solution.quaternion), "xyz")
    angles = (
        f"roll, pitch, yaw {listed(_clean([mechanism.angle_out(float(v)) for v in turn], 1.0))} "
        f"{mechanism.angle_unit}"
    )
    return {"spherical": angles, "translation": text}.get(
        "" if leaves else mechanism.motion, f"{text}\n{angles}"
    )


def _clean(values: Sequence[float] | np.ndarray, size: float) -> list[float]:
    return [0.0 if abs(v) < 1e-9 * size else float(v) for v in values]


def listed(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v + 0.0:.5g}" for v in values) + ")"
