"""Names of what may be identified, with nominal values and kinds."""

from __future__ import annotations

from typing import Literal

import casadi as ca
import numpy as np

from symkin.caching import lru_cache
from symkin.closure.closure import build_closure, random_values
from symkin.closure.rows import RowBuilder
from symkin.model.mechanism import Mechanism

ParameterKind = Literal["length", "angle", "number"]
FRAMES = tuple(f"{frame}.{what}.{k}" for frame in ("world", "target") for what in ("position", "rotation") for k in "xyz")
"""Frames between the mechanism and what is measured: the base frame in the measuring system, and what is observed on the platform."""


def parameter_names(mechanism: Mechanism) -> tuple[str, ...]:
    """All that may be identified: the closure's parameters, factors of readings, world and target frame."""
    return tuple(nominal_parameters(mechanism))


def nominal_parameters(mechanism: Mechanism) -> dict[str, tuple[float, ParameterKind]]:
    """Nominal value and kind of each name that may be identified."""
    closure = build_closure(mechanism)
    turning = {f"{_path(mechanism, limb.name, j.name)}.zero" for limb, j in mechanism.joints if j.type in ("R", "H")}
    table: dict[str, tuple[float, ParameterKind]] = {}
    for name, value in zip(closure.parameter_names, closure.parameter_values, strict=True):
        pieces = name.split(".")
        directed = pieces[-2] in ("axis", "axis2", "quaternion")
        angular = name in turning or (pieces[0] == "dh" and pieces[-1] in ("theta", "alpha"))
        table[name] = (float(value), "number" if directed else "angle" if angular else "length")
    for c in mechanism.actuated:
        table[f"{c.name}.scale"] = (1.0, "number")
    table |= {name: (0.0, "angle" if ".rotation." in name else "length") for name in FRAMES}
    return table


@lru_cache(maxsize=64)
def bound_by_motion(mechanism: Mechanism) -> frozenset[str]:
    """Parameters that a declared motion binds: moved alone, they let rows that the motion leaves out appear, and the limb
    could no longer carry the platform through it."""
    closure = build_closure(mechanism)
    builder = RowBuilder(mechanism)
    builder.build_rows()
    if len(builder.rows) == int(closure.rows.shape[0]):
        return frozenset()
    coordinates = [builder.coordinates[c.name][1] for c in closure.coordinates]
    variables, table = ca.vertcat(*coordinates), ca.vertcat(*builder.table.symbols)
    both = ca.Function("left_out", [variables, table], [ca.vertcat(*builder.rows), ca.jacobian(ca.vertcat(*builder.rows), table)])
    rng, size = np.random.default_rng(0), closure.size
    largest, slopes = np.zeros(len(builder.rows)), np.zeros((len(builder.rows), len(builder.table.names)))
    for _ in range(3):
        rows, by_p = both(random_values(closure.coordinates, size, rng), builder.table.values)
        largest = np.maximum(largest, np.abs(np.asarray(rows)).ravel())
        slopes = np.maximum(slopes, np.abs(np.asarray(by_p)))
    left_out = largest <= 1e-11 * size
    reach = np.max(slopes[left_out], axis=0, initial=0.0)
    return frozenset(n for n, r in zip(builder.table.names, reach, strict=True) if r > 1e-9)


def _path(mechanism: Mechanism, limb: str, joint: str) -> str:
    return joint if mechanism.serial else f"{limb}.{joint}"
