"""A controller's log of a platform on six rods: joints as distances of points, in NumPy and without
symkin's equations.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import symkin
from symkin import Measurements

TRUTH = symkin.load("ren2008_true")
SCATTER = 0.44e-6
"""Standard deviation of each coordinate of a position (m), and of an orientation (rad)."""


def off_nominal(rng: np.random.Generator, spread: float = 3e-3) -> symkin.Mechanism:
    """The machine as a drawing has it: every joint centre and zero off by some millimetres."""
    limbs = [
        replace(
            limb,
            base=tuple(np.array(limb.base) + rng.uniform(-spread, spread, 3)),
            platform=tuple(np.array(limb.platform) + rng.uniform(-spread, spread, 3)),
            offset=limb.offset + rng.uniform(-spread, spread),
        )
        for limb in TRUTH.limbs
    ]
    return replace(TRUTH, name="drawn", limbs=limbs)


def log(rng: np.random.Generator, count: int = 600) -> Measurements:
    """Rows within the workspace with whole poses, all with noise of SCATTER."""
    base, platform = (
        np.array([getattr(limb, end) for limb in TRUTH.limbs]) for end in ("base", "platform")
    )
    offset = np.array([limb.offset for limb in TRUTH.limbs])
    position = np.array(TRUTH.platform_position) + rng.uniform(-0.12, 0.12, (count, 3))
    q = _quaternions(0.12 * rng.normal(size=(count, 3)))
    w, v = q[:, :1, None], q[:, None, 1:]
    ends = platform + 2 * np.cross(v, np.cross(v, platform) + w * platform)
    joints = np.linalg.norm(position[:, None] + ends - base, axis=2) - offset
    read = position + SCATTER * rng.normal(size=position.shape)
    turn = _quaternions(0.5 * SCATTER * rng.normal(size=(count, 3)))
    return Measurements(
        joints,
        position=read,
        orientation=_product(q, turn),
        position_sigma=SCATTER,
        orientation_sigma=SCATTER,
    )


def unstated(data: Measurements) -> Measurements:
    """The same without standard deviations."""
    return replace(data, position_sigma=None, orientation_sigma=None)


def spoilt(
    data: Measurements, share: float, size: float, rng: np.random.Generator
) -> tuple[Measurements, np.ndarray]:
    """Positions of some rows off by normal errors of a size, and which."""
    bad = np.sort(rng.choice(len(data), round(share * len(data)), replace=False))
    position = data.position.copy()
    position[bad] += size * rng.normal(size=(len(bad), 3))
    return replace(data, position=position), bad


def _quaternions(turns: np.ndarray) -> np.ndarray:
    """Unit quaternions (n, 4) with vector parts in these ratios."""
    q = np.column_stack([np.ones(len(turns)), turns])
    return np.asarray(q / np.linalg.norm(q, axis=1)[:, None])


def _product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    vector = p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])
    return np.column_stack([p[:, 0] * q[:, 0] - np.sum(p[:, 1:] * q[:, 1:], axis=1), vector])
