"""Platforms on six rods and their readings in plain NumPy, for calibration: nothing here uses
symkin's formulas.
"""

from __future__ import annotations

import numpy as np

ROD, PLACE, TURN = 5e-4, 2e-3, np.radians(1e-3)
"""Noise of rods and positions (mm) and of the components of orientations."""
SIDE = np.tile([-0.5, 0.5], 3)
HEIGHT = 450.0


def rings(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Joint centres (6, 3) of a base of radius 400 mm and a platform of 250 mm, off their rings by
    up to 10 mm.
    """
    thirds = np.repeat(np.radians([0, 120, 240]), 2)
    angles = thirds + SIDE * np.radians(30), thirds + SIDE * np.radians(95)
    return tuple(
        r * np.column_stack([np.cos(a), np.sin(a), np.zeros(6)]) + rng.uniform(-10, 10, (6, 3))
        for r, a in zip((400.0, 250.0), angles, strict=True)
    )


def matrices(q: np.ndarray) -> np.ndarray:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4)."""
    w, x, y, z = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def poses(count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 3) about 450 mm above the base and quaternions (n, 4) within 15 deg."""
    v = np.radians(15) * rng.uniform(-1, 1, (count, 3))
    angle = np.linalg.norm(v, axis=1, keepdims=True)
    q = np.hstack([np.cos(angle / 2), np.sin(angle / 2) * v / angle])
    return np.array([0, 0, HEIGHT]) + rng.uniform(-80, 80, (count, 3)), q


def legs(base: np.ndarray, platform: np.ndarray, position: np.ndarray, q: np.ndarray) -> np.ndarray:
    return np.linalg.norm(
        position[:, None] + np.einsum("nij,kj->nki", matrices(q), platform) - base, axis=2
    )


def toml(base: np.ndarray, platform: np.ndarray, *, home: bool) -> str:
    """A mechanism file, with or without the reference pose of the platform."""
    lines = ["format = 1", 'name = "hexapod"', 'length_unit = "mm"', 'angle_unit = "deg"']
    for k in range(6):
        ends = (f"[{', '.join(repr(float(v)) for v in t[k])}]" for t in (base, platform))
        lines += [
            "[[limb]]",
            f'name = "leg{k + 1}"',
            'type = "SPS"',
            *(f"{n} = {e}" for n, e in zip(("base", "platform"), ends, strict=True)),
        ]
    return (
        "\n".join(lines + (["[platform]", f"position = [0.0, 0.0, {HEIGHT}]"] if home else []))
        + "\n"
    )


def csv(rods: np.ndarray, position: np.ndarray, q: np.ndarray | None) -> str:
    """A measurement file with standard deviations; NaN is an empty cell."""
    names = (
        [f"leg{k}[mm]" for k in range(1, 7)]
        + [f"sigma_leg{k}[mm]" for k in range(1, 7)]
        + [f"{k}[mm]" for k in "xyz"]
    )
    names += [f"sigma_{k}[mm]" for k in "xyz"]
    columns = [rods, np.full((len(rods), 6), ROD), position, np.full((len(rods), 3), PLACE)]
    if q is not None:
        names += ["qw", "qx", "qy", "qz", "sigma_orientation[deg]"]
        columns += [q, np.full((len(rods), 1), np.degrees(TURN))]
    rows = [
        ",".join("" if np.isnan(v) else repr(float(v)) for v in row) for row in np.hstack(columns)
    ]
    return "\n".join([",".join(names), *rows]) + "\n"


def noisy(
    rods: np.ndarray, position: np.ndarray, q: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, ...]:
    """Readings with their noise; orientations turn by small rotation vectors in the platform's
    frame.
    """
    v = np.hstack([np.ones((len(q), 1)), 0.5 * TURN * rng.normal(size=(len(q), 3))])
    w, u = q[:, :1], q[:, 1:]
    turned = np.hstack(
        [w - np.sum(u * v[:, 1:], axis=1, keepdims=True), u + w * v[:, 1:] + np.cross(u, v[:, 1:])]
    )
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    return (
        rods + ROD * rng.normal(size=rods.shape),
        position + PLACE * rng.normal(size=position.shape),
        turned,
    )
