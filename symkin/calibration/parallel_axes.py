"""Parallel axes of arms by DH rows: offsets along them that only their sum tells."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from symkin.model.mechanism import Mechanism

NEARLY = 0.01
"""Axes whose twist from parallel is less than this (radians) are nearly parallel: their offsets are told by little."""


def parallel_offsets(
    mechanism: Mechanism, values: Mapping[str, float], within: float = 0.0
) -> Iterator[tuple[str, dict[str, float]]]:
    """(name, velocity of parameters) for neighbouring rows whose axes are parallel to rounding, or `within` an angle: the offset d of
    one and that of the next move the tool alike."""
    if mechanism.dh is None:
        return
    rows, standard = mechanism.dh.rows, mechanism.dh.convention == "standard"
    for k in range(1, len(rows)):
        twist = values[f"dh.{k if standard else k + 1}.alpha"]
        if abs(np.sin(twist)) <= max(within, 1e-12):
            names = " and ".join(mechanism.actuated[i].name for i in (k - 1, k))
            other = -1.0 if np.cos(twist) > 0 else 1.0
            yield (
                f"parallel axes {names}: only the sum of their offsets dh.{k}.d and dh.{k + 1}.d is told",
                {f"dh.{k}.d": 1.0, f"dh.{k + 1}.d": other},
            )


def nearly_parallel(mechanism: Mechanism, values: Mapping[str, float]) -> tuple[str, ...]:
    """Pairs of neighbouring axes that are parallel or nearly so, by name."""
    if mechanism.dh is None:
        return ()
    return tuple(text.split(":")[0].removeprefix("parallel axes ") for text, _ in parallel_offsets(mechanism, values, NEARLY))
