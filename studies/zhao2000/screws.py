"""Screws of the 3-TRT + SPS platform: the five of each limb, their reciprocal couple, mobility, and the choice of inputs.

Twists are rows (s; s0), direction and moment about O, in (1; mm). Limb i has the revolutes a_i z, a_i h, b_i h, c_i h, c_i z,
h horizontal across the limb; the SPS limb exerts one force along OP and lets its slide follow. Source: see `study`.
"""

from __future__ import annotations

import math
from collections import Counter
from itertools import combinations

import numpy as np

from studies.zhao2000.model import BASE, LINK, SIZE, corners, inverse
from symkin.position.limb_screws import reciprocal_system
from symkin.spatial.screw import reciprocal_product, revolute_screw

INDEPENDENT = 1e-9
"""Singular values below this, rows normalised, count as zero."""
JOINTS = ("base R", "lower R", "elbow R", "upper R", "platform R")
"""The five revolutes of a TRT limb, from the base."""


def elbow(pose, i: int, *, outward: bool) -> np.ndarray:
    """b_i at 70 mm from a_i and C_i in the limb's plane."""
    a, c = np.array([*BASE[i], 0.0]), corners(pose)[i]
    across = np.cross(c - a, [*(c - a)[1::-1] * (1, -1), 0.0])
    offset = math.sqrt(LINK**2 - np.dot(c - a, c - a) / 4) * across / np.linalg.norm(across)
    return (a + c) / 2 + (offset if (across[:2] @ BASE[i] > 0) == outward else -offset)


def limb_twists(pose, i: int) -> np.ndarray:
    """The five revolutes of limb i, elbow outward, as rows of twists about O."""
    a, c = np.array([*BASE[i], 0.0]), corners(pose)[i]
    theta, up = math.radians(inverse(pose)[i]), np.array([0.0, 0.0, 1.0])
    level = np.array([math.sin(theta), -math.cos(theta), 0.0])
    places = [(a, up), (a, level), (elbow(pose, i, outward=True), level), (c, level), (c, up)]
    return np.array([revolute_screw(point, axis) for point, axis in places])


def couple(pose, i: int) -> np.ndarray:
    """The wrench (force; moment) reciprocal to limb i's twists, of unit moment: a couple."""
    (wrench,) = reciprocal_system(limb_twists(pose, i), SIZE)
    return np.asarray(wrench / np.linalg.norm(wrench[3:]))


def work(twists: np.ndarray, wrench: np.ndarray) -> float:
    """Largest work of a wrench on the twists."""
    return max(abs(float(reciprocal_product(t, wrench))) for t in twists)


def rank(rows: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(rows, tol=INDEPENDENT))


def freedoms_left(pose, locked: tuple[int, ...]) -> int:
    """Freedoms of the platform with these joints locked: 5 i + k is revolute k of limb i, 15 the slide of the SPS limb."""
    wrenches = []
    for i in range(3):
        kept = [k for k in range(5) if 5 * i + k not in locked]
        wrenches.append(reciprocal_system(limb_twists(pose, i)[kept], SIZE) if kept else np.eye(6))
    if 15 in locked:
        wrenches.append(np.array([[*pose[:3], 0.0, 0.0, 0.0]]))
    stacked = np.vstack(wrenches)
    stacked[:, 3:] /= SIZE
    return 6 - rank(stacked / np.linalg.norm(stacked, axis=1, keepdims=True))


def input_choices(pose) -> list[tuple[int, ...]]:
    """All sets of four joints that hold the platform when they are locked."""
    return [choice for choice in combinations(range(16), 4) if freedoms_left(pose, choice) == 0]


def limbs_of(choice: tuple[int, ...]) -> tuple[int, ...]:
    """How many of a choice's joints each TRT limb has, most first, then whether the slide is among them."""
    counts = Counter(k // 5 for k in choice if k < 15)
    return (*sorted((counts[i] for i in range(3)), reverse=True), int(15 in choice))


def on_base(choice: tuple[int, ...]) -> bool:
    """Whether every motor of a choice stands on the base, or pushes the central leg, whose foot does."""
    return all(k == 15 or k % 5 == 0 for k in choice)
