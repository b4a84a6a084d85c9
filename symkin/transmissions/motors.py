"""What is told of motors: inertias, limits of torque and speed, resolutions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.text import shown

_NOTES = {
    "torque_limits": "no torque limits of motors are told: 1 is taken for each, so that torques of "
    "joints are those per unit of a motor's",
    "speed_limits": "no speed limits of motors are told: 1 is taken for each",
    "inertia": "no inertias of motors are told: 1 is taken for each",
}


@dataclass(frozen=True, eq=False)
class Motors:
    """Inertias (m,), limits (m, 2) and resolutions (m,) of motors, the last in radians or the
    length unit; `untold` is 1 where it has a unit, and `notes` say so.
    """

    inertias: np.ndarray
    torque_limits: np.ndarray
    speed_limits: np.ndarray
    resolutions: np.ndarray | None
    untold: tuple[str, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        return tuple(_NOTES[key] for key in self.untold)


def read_motors(names: tuple[str, ...], told: Mapping[str, Any]) -> Motors:
    """Read the options of motors: one number for all, one for each, by name, or pairs of limits.
    Raises InputError.
    """
    values = {key: None if told.get(key) is None else _read(key, names, told[key]) for key in _KEYS}
    ones = np.ones((len(names), 2)) * [-1.0, 1.0]
    for key in ("inertia", "resolution"):
        pairs = values[key]
        if pairs is not None and not (pairs[:, 1] >= 0.0).all():
            raise InputError(f"{key} = {shown(told[key])}; numbers from 0 are needed")
    known = {key: ones if pairs is None else pairs for key, pairs in values.items()}
    return Motors(
        known["inertia"][:, 1],
        known["torque_limits"],
        known["speed_limits"],
        None if values["resolution"] is None else known["resolution"][:, 1],
        tuple(key for key in _NOTES if told.get(key) is None),
    )


_KEYS = ("inertia", "torque_limits", "speed_limits", "resolution")


def _read(key: str, names: tuple[str, ...], told: Any) -> np.ndarray:
    """Pairs (m, 2) of a number for each motor, -x and x of a single number x."""
    if isinstance(told, Mapping):
        if set(told) != set(names):
            raise InputError(
                f"{key}: {shown(list(told))}; values for {', '.join(names)} are needed"
            )
        told = [told[name] for name in names]
    try:
        numbers = np.asarray(told, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{key} = {shown(told)}; numbers are needed") from None
    if numbers.size == 1:
        numbers = np.full(len(names), float(numbers.item()))
    pairs = numbers if numbers.ndim == 2 else np.stack([-numbers, numbers], axis=-1)
    if pairs.shape != (len(names), 2) or not np.isfinite(pairs).all():
        raise InputError(
            f"{key} = {shown(told)}; a number is needed for each of {', '.join(names)}"
        )
    for name, (low, high) in zip(names, pairs, strict=True):
        if key.endswith("limits") and not low < high:
            raise InputError(
                f"{key}: {name} = {low:g} to {high:g}; the lower limit comes first, and a single "
                f"number is positive"
            )
    return np.asarray(pairs)
