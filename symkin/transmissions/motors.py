"""What is told of motors: inertias, limits of torque and speed, resolutions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.formats.graph_form import METRES
from symkin.model.mechanism import Mechanism
from symkin.model.motor import Motor
from symkin.text import shown

_NOTHING: Mapping[str, Any] = {}
_NOTES = {
    "torque_limits": "no torque limits of motors are told: 1 is taken for each, so that torques of "
    "joints are those per unit of a motor's",
    "speed_limits": "no speed limits of motors are told: 1 is taken for each",
    "inertia": "no inertias of motors are told: 1 is taken for each",
}
_IN_FILE = {"torque_limits": "effort", "speed_limits": "speed", "inertia": "armature"}
"""What a file's `Motor` calls them."""


@dataclass(frozen=True, eq=False)
class Motors:
    """Inertias (m,), limits (m, 2) and resolutions (m,) of motors, the last in radians or the
    length unit; `untold` is 1 where it has a unit, `of_file` is the file's, and `notes` say so.
    """

    inertias: np.ndarray
    torque_limits: np.ndarray
    speed_limits: np.ndarray
    resolutions: np.ndarray | None
    untold: tuple[str, ...]
    of_file: tuple[str, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        words = ", ".join(key.replace("_", " ") for key in self.of_file)
        told = (f"taken from the file, in SI units: {words} of the motors",) if words else ()
        return (*told, *(_NOTES[key] for key in self.untold))


def motors_of_file(mechanism: Mechanism, names: tuple[str, ...]) -> dict[str, Any]:
    """What a file tells of all these motors, as options in the mechanism's length unit."""
    joints = {joint.name: joint for joint in mechanism.all_joints}
    own = [joints[name].motor or Motor() if name in joints else Motor() for name in names]
    slides = [name in joints and joints[name].type == "P" for name in names]
    metres, found = METRES[mechanism.length_unit], dict[str, Any]()
    # a torque in N m is 1 / metres of N times the unit, a mass in kg as many N s^2 over the unit
    scales = {
        "torque_limits": (1.0 / metres, 1.0),
        "speed_limits": (1.0, 1.0 / metres),
        "inertia": (1.0 / metres, metres),
    }
    for key, word in _IN_FILE.items():
        values = [getattr(motor, word) for motor in own]
        if None not in values:
            found[key] = [
                np.multiply(value, scales[key][slide]).tolist()
                for value, slide in zip(values, slides, strict=True)
            ]
    return found


def read_motors(
    names: tuple[str, ...], told: Mapping[str, Any], of_file: Mapping[str, Any] = _NOTHING
) -> Motors:
    """Read the options of motors: one number for all, one for each, by name, or pairs of limits;
    `of_file` in the place of what is not told. Raises InputError.
    """
    read = tuple(key for key in of_file if told.get(key) is None)
    told = {**told, **{key: of_file[key] for key in read}}
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
        read,
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
    return pairs
