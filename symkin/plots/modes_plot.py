"""Pictures of configurations: modes, single solutions and singularities, a panel for each with what
is found above it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.assembly.modes_result import Modes, nothing_found
from symkin.closure.closure import build_closure
from symkin.drawing.layout import layout_of
from symkin.errors import InputError
from symkin.model.keys import ABOUT_Z
from symkin.plots.figures import Panel, figure_of_panels
from symkin.plots.picture_options import chosen_numbers, looks_of, ranges_text
from symkin.position.pose_coordinates import leaves_motion
from symkin.position.solution import Solution
from symkin.position.solve_result import SolveResult
from symkin.position.table import without_rounding
from symkin.singularities.singularity_result import Singularity
from symkin.spatial.rotation import euler_from_quaternion
from symkin.text import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure


DEFAULT_MOST = 12
"""Panels of a picture of modes where nothing is chosen."""


def figure_of_modes(
    found: Modes,
    *,
    modes: str | Sequence[int] | None = None,
    most: int = DEFAULT_MOST,
    names: str = "none",
    views: str | Sequence[str] = "main",
) -> Figure:
    """One panel per mode, those of `shown_numbers`, all with the same limits and equal axes;
    without modes the mechanism's reference configuration. Raises InputError for `most` below 1, and
    for modes, names and views that are not there.
    """
    mechanism = found.problem.mechanism
    numbers = shown_numbers(found, modes, most)
    given = [c.name for c in found.problem.known_coordinates]
    panels = [panel_of(f"mode {k}", found[k - 1], given) for k in numbers] or [
        Panel(nothing_found(found), "drawn at the reference configuration", layout_of(mechanism))
    ]
    part = (
        f" \N{EM DASH} {len(numbers)} of {found.total} modes shown"
        if len(numbers) < found.total
        else ""
    )
    looks = looks_of(mechanism, names, views)
    return figure_of_panels(mechanism, panels, _facts(found), part, **looks)


def shown_numbers(
    modes: Modes, chosen: str | Sequence[int] | None = None, most: int = DEFAULT_MOST
) -> list[int]:
    """Numbers of the modes that a picture shows: the chosen ones, else `most` of them, poses and
    sets of actuated joints before branches. Raises InputError.
    """
    if most < 1:
        raise InputError(f"most = {most} must be at least 1")
    if chosen is not None and len(modes):
        return chosen_numbers(chosen, len(modes))
    first = set(modes.first_of_sets)
    numbers = range(1, len(modes) + 1)
    return sorted(sorted(numbers, key=lambda k: (k - 1 not in first, k))[:most])


def left_out(modes: Modes, shown: Sequence[int]) -> str:
    """What a picture of some modes leaves out, in a sentence; empty where it shows all."""
    others = [k for k in range(1, len(modes) + 1) if k not in set(shown)]
    hidden = modes.total - len(modes)
    if not others and not hidden > 0:
        return ""
    numbers = f": {ranges_text(others)}" if others else ""
    unlisted = f"; {hidden} more are not listed" if hidden > 0 else ""
    return (
        f"shows {len(shown)} of {modes.total} modes, leaves out "
        f"{modes.total - len(shown)}{numbers}{unlisted}; --modes chooses"
    )


def figure_of_solution(
    solution: Solution, *, names: str = "none", views: str | Sequence[str] = "main"
) -> Figure:
    """The mechanism in this configuration, a panel for each view."""
    mechanism = solution.mechanism
    unit, looks = mechanism.length_unit, looks_of(mechanism, names, views)
    facts = [f"closure error {solution.residual:.1e} {unit}, condition {solution.condition:.3g}"]
    return figure_of_panels(mechanism, [panel_of("", solution, ())], facts, **looks)


def figure_of_solve(
    result: SolveResult, *, names: str = "none", views: str | Sequence[str] = "main"
) -> Figure:
    """The configuration that a solve reached. Raises InputError where it reached none."""
    if result.solution is None:
        raise InputError(f"plot: {result.message}")
    return figure_of_solution(result.solution, names=names, views=views)


def _facts(modes: Modes) -> list[str]:
    """What is given, and the count of modes with its completeness."""
    mechanism = modes.problem.mechanism
    given = ", ".join(_given_text(key, values) for key, values in modes.given.items())
    units = f"{mechanism.length_unit}, {mechanism.angle_unit}"
    asked = f"problem at {given} [{units}]" if given else "problem, nothing given"
    statement = f"{modes.counted}; completeness: {modes.completeness}" + (
        f", {modes.starts} starts" if modes.starts else ""
    )
    return [f"{modes.problem.name} {asked}", statement]


def _given_text(key: str, values: Any) -> str:
    if np.ndim(values) == 0:
        return f"{key} = {values:.5g}"
    return f"{key} {listed(without_rounding(values))}"


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
    m = solution.mechanism
    place = f"{_listed(solution.position, m.characteristic_length)} {m.length_unit}"
    leaves = leaves_motion(m, solution.position[None], solution.quaternion[None])
    if m.motion in ABOUT_Z and not leaves:
        angle = m.angle_out(plain(solution.gamma, least=_NOISE))
        return f"{place}, gamma {angle:.5g} {m.angle_unit}"
    turn = euler_from_quaternion(np.asarray(solution.quaternion), "xyz")
    turned = _listed(map(m.angle_out, turn), m.angle_out(1.0))
    text, angles = f"position {place}", f"roll, pitch, yaw {turned} {m.angle_unit}"
    shown = {"spherical": angles, "translation": text}
    return shown.get("" if leaves else m.motion, f"{text}\n{angles}")


def _listed(values: Iterable[float], size: float) -> str:
    return listed([plain(value, size, _NOISE) for value in values])


def listed(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v + 0.0:.5g}" for v in values) + ")"


def figure_of_singularity(
    found: Singularity, *, names: str = "none", views: str | Sequence[str] = "main"
) -> Figure:
    """A panel for each view: the mechanism at the configuration; platform motions as dashed axes,
    translations as arrows. Where coordinates drive that are told by name, the rates of joints that
    move while these stand are written above it.
    """
    solution, mechanism = found.solution, found.solution.mechanism
    count = found.uncontrolled_freedoms
    usual = "singular everywhere" if count else "regular"
    kinds = ", ".join(found.kinds) + " singularity" if found.kinds else usual
    distances = ", ".join(f"{kind} {plain(value):.3g}" for kind, value in found.distances.items())
    facts = [f"distance from singularities (0 singular): {distances}"]
    if found.given:
        facts.insert(0, f"driven by {', '.join(found.given)}")
        rates = [
            ", ".join(f"{name} {rate:.4g}" for name, rate in motion.items())
            for motion in found.motions
            if found.rank_loss
        ]
        texts = [f"free to move: {motion}" for motion in rates]
        texts += [f"freedoms that are not driven, everywhere: {count}"] * (count > 0)
    else:
        texts = [str(twist) for twist in found.twists]
    twists = () if found.given else found.twists
    layout = layout_of(mechanism).at(solution.link_poses)
    panel = Panel(kinds, "\n".join(texts), layout, twists)
    return figure_of_panels(mechanism, [panel], facts, **looks_of(mechanism, names, views))
