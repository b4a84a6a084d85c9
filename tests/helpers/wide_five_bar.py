"""A five-bar whose couplers its cranks can pull straight, and the exact fate of a line of its
joints.
"""

from __future__ import annotations

import math

import numpy as np

from helpers.samples import circles, turning
from symkin import Joint, Limb, Mechanism

HALF_BASE, CRANK, COUPLER = 90.0, 110.0, 190.0
HOME = (math.radians(120.0), math.radians(60.0))


def wide_five_bar(motion: str = "spatial") -> Mechanism:
    """Base joints at x = -90 and 90, cranks 110, couplers 190; home: the cranks lean outwards by 30
    degrees. The platform is the left coupler, its frame in the tip with the base's directions. The
    cranks' coordinates are their angles from +x.
    """
    pins = crank_pins(np.array(HOME))
    tip = circles(pins[0], COUPLER, pins[1], COUPLER)[0]
    drives = [
        Joint(name, "R", (side * HALF_BASE, 0.0, 0.0), (0.0, 0.0, 1.0), actuated=True, zero=angle)
        for name, side, angle in zip(("left", "right"), (-1, 1), HOME, strict=True)
    ]
    limbs = [
        Limb("left", [drives[0], turning("b1", *pins[0])]),
        Limb("right", [drives[1], turning("b2", *pins[1]), turning("p", *tip)]),
    ]
    return Mechanism("wide_five_bar", limbs, platform_position=(*tip, 0.0), motion=motion)  # type: ignore[arg-type]


def crank_pins(angles: np.ndarray) -> np.ndarray:
    """Ends of the two cranks (2, ..., 2) at their angles (..., 2)."""
    ends = CRANK * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    ends[..., 0] += np.array([-HALF_BASE, HALF_BASE])
    return np.moveaxis(ends, -2, 0)


def tip_of(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The cranks' pins (2, ..., 2) and the tip (..., 2) to the left of left pin -> right pin, where
    the couplers meet; on the line of the pins where they do not.
    """
    pins = crank_pins(angles)
    apart = pins[1] - pins[0]
    length = np.linalg.norm(apart, axis=-1, keepdims=True)
    height = np.sqrt(np.maximum(COUPLER**2 - length**2 / 4, 0.0))
    across = np.stack([-apart[..., 1], apart[..., 0]], axis=-1) / length
    return pins, 0.5 * (pins[0] + pins[1]) + height * across


def _line(starts: np.ndarray, goals: np.ndarray, points: int) -> np.ndarray:
    """Angles (points, n, 2) on the lines from starts to goals (n, 2)."""
    return starts + np.linspace(0.0, 1.0, points)[:, None, None] * (goals - starts)


def slack_of(starts: np.ndarray, goals: np.ndarray, points: int = 400) -> np.ndarray:
    """For each line of crank angles the least 1 - |E1 E2|^2 / (2 COUPLER)^2, E the pins: below zero
    the couplers do not meet on a part of it.
    """
    pins = crank_pins(_line(starts, goals, points))
    return np.asarray(
        np.min(1.0 - np.sum((pins[1] - pins[0]) ** 2, axis=-1) / (2 * COUPLER) ** 2, axis=0)
    )


def passes_dead_centre(starts: np.ndarray, goals: np.ndarray, points: int = 300) -> np.ndarray:
    """For each line whether a crank and its coupler come into one line on the way."""
    pins, tips = tip_of(_line(starts, goals, points))
    passed = np.zeros(len(goals), dtype=bool)
    for side in (0, 1):
        crank = pins[side] - np.array([(2 * side - 1) * HALF_BASE, 0.0])
        coupler = tips - pins[side]
        turn = crank[..., 0] * coupler[..., 1] - crank[..., 1] * coupler[..., 0]
        passed |= (np.min(turn, axis=0) < 0.0) & (np.max(turn, axis=0) > 0.0)
    return passed
