"""How configurations are told: panels with what is found above them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest

import numpy as np

from symkin.closure.closure import build_closure
from symkin.drawing.layout import layout_of
from symkin.model.keys import ABOUT_Z
from symkin.plots.figures import Panel
from symkin.position.pose_coordinates import leaves_motion
from symkin.position.solution import Solution
from symkin.spatial.rotation import euler_from_quaternion


def panel_of(title: str, solution: Solution, given: Sequence[str], text: str = "") -> Panel:
    """The panel of a solution for given names: below `text` where it is, and whether within
    limits.
    """
    mechanism = solution.mechanism
    told = _joints_text if mechanism.is_graph else _mode_text
    words = f"{text}\n{told(solution, given)}{_limits_text(solution)}"
    return Panel(title, words.strip(), layout_of(mechanism).at(solution.link_poses))


def _joints_text(solution: Solution, given: Sequence[str]) -> str:
    """The first few single joint coordinates that were not given; below them where the platform's
    link is.
    """
    mechanism, size = solution.mechanism, solution.mechanism.characteristic_length
    own = [c for c in mechanism.coordinates if c.width == 1 and c.name not in given]
    texts = []
    for c, after in zip_longest(own[:_MOST_VALUES], own[1:_MOST_VALUES]):
        (value,) = _clean([mechanism.value_in(c, solution.joints[c.name])], c.unit(size))
        unit = mechanism.unit_of(c)
        told = "" if after is not None and mechanism.unit_of(after) == unit else f" {unit}"
        texts.append(f"{c.name} {mechanism.value_out(c, value):.5g}{told}")
    more = ["..."] if len(own) > _MOST_VALUES else []
    # a line breaks between joints alone
    shown = ", ".join(text.replace(" ", "\N{NO-BREAK SPACE}") for text in [*texts, *more])
    pose = _pose_text(solution) if solution.has_platform else ""
    return "\n".join(line for line in (shown, pose) if line)


_MOST_VALUES = 4
"""Joint coordinates that are written above a panel."""


def _mode_text(solution: Solution, given: Sequence[str]) -> str:
    """Where the mode is: the platform's pose, or where that is given the actuated joints."""
    posed = any(c.name in given for c in build_closure(solution.mechanism).role("pose"))
    return f"joints {listed(solution.actuated_values)}" if posed else _pose_text(solution)


def _limits_text(solution: Solution) -> str:
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
    leaves = leaves_motion(mechanism, solution.position[None], solution.quaternion[None])
    if mechanism.motion in ABOUT_Z and not leaves:
        angle = mechanism.angle_out(*_clean([solution.gamma], 1.0))
        return f"{text.removeprefix('position ')}, gamma {angle:.5g} {mechanism.angle_unit}"
    turn = _clean(euler_from_quaternion(np.asarray(solution.quaternion), "xyz"), 1.0)
    turned = listed([mechanism.angle_out(angle) for angle in turn])
    angles = f"roll, pitch, yaw {turned} {mechanism.angle_unit}"
    return {"spherical": angles, "translation": text}.get(
        "" if leaves else mechanism.motion, f"{text}\n{angles}"
    )


def _clean(values: Sequence[float] | np.ndarray, size: float) -> list[float]:
    return [0.0 if abs(v) < 1e-9 * size else float(v) for v in values]


def listed(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v + 0.0:.5g}" for v in values) + ")"
