"""What a picture of a sweep says beside its curves: title, what is held, names of axes."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from symkin.closure.closure import build_closure
from symkin.drawing.palette import COLOURS
from symkin.model.file import parse
from symkin.model.mechanism import Mechanism
from symkin.plots.sheet import head, subtitle
from symkin.position.given import given_coordinates
from symkin.position.varied_pose import axis_title, turn_text
from symkin.spatial.rotation import conjugate, multiply
from symkin.text import plain


def write_title(ax: Any, what: str, attributes: Mapping[str, Any], fixed: Sequence[str]) -> None:
    """The title, and below it what is fixed besides what the sweep holds."""
    head(ax.figure, f"{what}: {attributes['mechanism']}, {_problem(attributes)}")
    lines = ", ".join([*fixed, *held_texts(attributes)])
    subtitle(ax, f"at {lines}" if lines else "", 9.5, wrap=True)
    ax.tick_params(colors=COLOURS["quiet"])


def _problem(attributes: Mapping[str, Any]) -> str:
    """The problem by its name, or by what is given."""
    if attributes["problem"] != "given":
        return f"{attributes['problem']} problem"
    base = attributes["base"] if isinstance(attributes["base"], Mapping) else {}
    return f"given {', '.join([*attributes['axes'], *base])}"


def axis_text(attributes: Mapping[str, Any], name: str, unit: str) -> str:
    """What stands at the axis of a swept coordinate."""
    titled = axis_title(name) if attributes["sweeps over"] == "poses" else name
    return f"{titled} [{unit}]"


def held_texts(attributes: Mapping[str, Any]) -> list[str]:
    """Joints, or coordinates of the pose, that are not swept, with their values; rounding noise as
    0.
    """
    mechanism, base = parse(attributes["mechanism_file"]), attributes["base"]
    if attributes["sweeps over"] == "poses":
        return _held_pose(mechanism, base, attributes["axes"])
    by_name = isinstance(base, Mapping)
    values = (
        base if by_name else dict(zip((c.name for c in mechanism.actuated), base, strict=False))
    )
    coordinates = given_coordinates(mechanism)
    found = []
    for name, value in values.items():
        if name in coordinates and name not in attributes["axes"]:
            unit = mechanism.unit_of(coordinates[name])
            found.append(f"{name} = {plain(value, mechanism.characteristic_length):.5g} {unit}")
        elif name not in coordinates:
            found.append(f"{name} ({', '.join(f'{plain(float(v)):.4g}' for v in value)})")
    return found


def _held_pose(mechanism: Mechanism, base: Sequence[float], swept: Collection[str]) -> list[str]:
    """Coordinates of the mechanism's motion: a planar one has no z and an angle gamma, one with a
    free rotation an orientation.
    """
    found, closure = [], build_closure(mechanism)
    for c in closure.role("pose"):
        name = c.name.removeprefix("pose.")
        if c.is_rotation:
            numbers = ", ".join(f"{plain(float(v)):.4g}" for v in base[3:])
            found.append(f"orientation ({numbers}){turn_text(swept)}")
        elif name in ("x", "y", "z") and name not in swept:
            found.append(
                f"{name} = {plain(base['xyz'.index(name)], mechanism.characteristic_length):.5g} "
                f"{mechanism.length_unit}"
            )
        elif name == "gamma" and "gamma" not in swept:
            turn = multiply(np.array(base[3:]), conjugate(mechanism.reference_pose.quaternion))
            angle = plain(mechanism.angle_out(2.0 * math.atan2(turn[3], turn[0])))
            if "rz" not in swept or angle:
                found.append(
                    f"gamma = {'rz + ' * ('rz' in swept)}{angle:.5g} {mechanism.angle_unit}"
                )
    return found
