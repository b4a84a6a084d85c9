"""How configurations are told: panels with what is found above them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import zip_longest

import numpy as np

from symkin.closure.closure import build_closure
from symkin.drawing.layout import layout_of
from symkin.model.keys import ABOUT_Z
from symkin.plots.figures import Panel
from symkin.position.pose_coordinates import leaves_motion
from symkin.position.solution import Solution
from symkin.spatial.rotation import euler_from_quaternion
from symkin.text import plain


def panel_of(title: str, solution: Solution, given: Sequence[str], text: str = "") -> Panel:
    """The panel of a solution for given names: below `text` where it is, and whether within
    limits.
    """
    words = f"{text}\n{_told(solution, given)}{_limits_text(solution)}"
    layout = layout_of(solution.mechanism).at(solution.link_poses)
    return Panel(title, words.strip(), layout)


_MOST_VALUES = 6
"""Joint coordinates that are written above a panel; beyond, driven ones, or the first."""


def _told(solution: Solution, given: Sequence[str]) -> str:
    """What was not given: single joint coordinates, and where the platform is."""
    mechanism = solution.mechanism
    own = [c for c in mechanism.coordinates if c.width == 1 and c.name not in given]
    driven = [c for c in own if c.role == "actuated"]
    posed = any(c.name in given for c in build_closure(mechanism).role("pose"))
    if len(own) > _MOST_VALUES and (driven or solution.has_platform):
        own = driven
    shown = own[: max(_MOST_VALUES, len(driven))]
    texts = []
    for c, after in zip_longest(shown, shown[1:]):
        value = mechanism.value_in(c, solution.joints[c.name])
        value = plain(value, c.unit(mechanism.characteristic_length), _NOISE)
        unit = mechanism.unit_of(c)
        told = "" if after is not None and mechanism.unit_of(after) == unit else f" {unit}"
        texts.append(f"{c.name} {mechanism.value_out(c, value):.5g}{told}")
    more = ["..."] * (len(shown) < len(own))
    # a line breaks between joints alone
    joints = ", ".join(text.replace(" ", "\N{NO-BREAK SPACE}") for text in [*texts, *more])
    pose = _pose_text(solution) if solution.has_platform and not posed else ""
    return "\n".join(line for line in (joints, pose) if line)


_NOISE = 1e-9
"""Values below this (lengths over the size) are written as 0."""


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
        f"position {_listed(solution.position, mechanism.characteristic_length)} "
        f"{mechanism.length_unit}"
    )
    leaves = leaves_motion(mechanism, solution.position[None], solution.quaternion[None])
    if mechanism.motion in ABOUT_Z and not leaves:
        angle = mechanism.angle_out(plain(solution.gamma, least=_NOISE))
        return f"{text.removeprefix('position ')}, gamma {angle:.5g} {mechanism.angle_unit}"
    turn = euler_from_quaternion(np.asarray(solution.quaternion), "xyz")
    turned = _listed([mechanism.angle_out(angle) for angle in turn], mechanism.angle_out(1.0))
    angles = f"roll, pitch, yaw {turned} {mechanism.angle_unit}"
    return {"spherical": angles, "translation": text}.get(
        "" if leaves else mechanism.motion, f"{text}\n{angles}"
    )


def _listed(values: Iterable[float], size: float) -> str:
    return listed([plain(value, size, _NOISE) for value in values])


def listed(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v + 0.0:.5g}" for v in values) + ")"
