"""Random serial arms of each structure that has a closed form, all other numbers drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin import Joint, Limb, Mechanism

Axis = tuple[str, np.ndarray, np.ndarray]
"""Type, point and direction of a joint."""


def serial(name: str, axes: Sequence[Axis], rng: np.random.Generator) -> Mechanism:
    """The arm with a random tool frame."""
    joints = [
        Joint(f"q{i + 1}", kind, point, axis, actuated=True)
        for i, (kind, point, axis) in enumerate(axes)
    ]
    return Mechanism(
        name,
        [Limb("arm", joints)],
        platform_position=rng.normal(size=3),
        platform_quaternion=direction(rng, 4),
        serial=True,
    )


def direction(rng: np.random.Generator, count: int = 3) -> np.ndarray:
    v = rng.normal(size=count)
    return v / np.linalg.norm(v)


def free(rng: np.random.Generator, kind: str = "R") -> Axis:
    """A joint anywhere."""
    return kind, rng.normal(size=3), direction(rng)


def along(rng: np.random.Generator, k: np.ndarray, count: int) -> list[Axis]:
    """Revolute joints with parallel axes."""
    return [("R", rng.normal(size=3), k) for _ in range(count)]


def through(rng: np.random.Generator, point: np.ndarray, count: int) -> list[Axis]:
    """Revolute joints whose axes meet, each given by another point of its axis."""
    found = []
    for _ in range(count):
        k = direction(rng)
        found.append(("R", point + rng.normal() * k, k))
    return found


def structures(rng: np.random.Generator) -> dict[str, Mechanism]:
    """One arm of each structure."""
    k, c, w = direction(rng), rng.normal(size=3), rng.normal(size=3)
    wrist = through(rng, w, 3)
    normal = np.cross(k, direction(rng))
    arms = {
        "parallel_inner": [free(rng), *along(rng, k, 3), *through(rng, c, 2)],
        "parallel_inner_mirrored": [*through(rng, c, 2), *along(rng, k, 3), free(rng)],
        "parallel_first": [*along(rng, k, 3), free(rng), *through(rng, c, 2)],
        "parallel_first_other": [*along(rng, k, 3), *through(rng, c, 2), free(rng)],
        "parallel_last": [free(rng), *through(rng, c, 2), *along(rng, k, 3)],
        "parallel_inner_and_pair": [free(rng), *along(rng, k, 3), *along(rng, direction(rng), 2)],
        "parallel_slide": [free(rng), *along(rng, k, 3), free(rng), free(rng, "P")],
        "planar_with_slide": [
            free(rng),
            *along(rng, k, 2),
            ("P", c, normal / np.linalg.norm(normal)),
            *through(rng, c, 2),
        ],
        "wrist_parallel_two_three": [free(rng), *along(rng, k, 2), *wrist],
        "wrist_parallel_one_two": [*along(rng, k, 2), free(rng), *wrist],
        "wrist_meeting_one_two": [*through(rng, c, 2), free(rng), *wrist],
        "wrist_meeting_two_three": [free(rng), *through(rng, c, 2), *wrist],
        "wrist_first": [*wrist, free(rng), *along(rng, k, 2)],
        "wrist_first_meeting": [*wrist, *through(rng, c, 2), free(rng)],
        "stanford": [*through(rng, c, 2), free(rng, "P"), *wrist],
        "gantry": [free(rng, "P"), free(rng, "P"), free(rng, "P"), *wrist],
        "gantry_without_wrist": [
            free(rng, "P"),
            free(rng),
            free(rng, "P"),
            free(rng),
            free(rng, "P"),
            free(rng),
        ],
        "slide_first": [("P", c, normal / np.linalg.norm(normal)), ("R", c, k), free(rng), *wrist],
    }
    return {name: serial(name, axes, rng) for name, axes in arms.items()}


def short_structures(rng: np.random.Generator) -> dict[str, Mechanism]:
    """Arms of three to five joints, whose poses must meet conditions."""
    k, z, c = direction(rng), np.array([0.0, 0.0, 1.0]), rng.normal(size=3)
    arms = {
        "five_parallel": [free(rng), *along(rng, k, 3), free(rng)],
        "five_wrist": [free(rng), *along(rng, k, 2), *through(rng, c, 2)],
        "palletizer": [free(rng), *along(rng, k, 3)],
        "scara": [*along(rng, z, 3), ("P", c, z)],
        "scara_slide_inside": [*along(rng, z, 2), ("P", c, z), *along(rng, z, 1)],
        "planar": along(rng, z, 3),
        "gantry_with_turn": [*(("P", c, e) for e in np.eye(3)), free(rng)],
    }
    return {name: serial(name, axes, rng) for name, axes in arms.items()}


def random_values(arm: Mechanism, rng: np.random.Generator) -> list[float]:
    """Joint values, angles all round."""
    size = arm.characteristic_length
    return [
        rng.uniform(-np.pi, np.pi) if c.is_angular else size * float(rng.normal())
        for c in arm.actuated
    ]
