"""Measurements of a platform on six rods with an inclinometer, made in plain NumPy: nothing here
uses symkin's formulas.

Postures as in Ren, Feng and Su (2008), workspace assumed: groups of equal inclination, angles
within 20 deg, the centre of the platform's joint circle within 0.25 m in x and y of the centre of
the base's and 1.15 to 1.45 m above, extensions 0 to 0.55 m. Units m, rad. The inclinometer's error
turns the platform, since its reading is what is held equal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import symkin
from symkin import Measurements

PLATFORM_CENTRE = np.array([0.38435, 0.28757, 0.0])
BASE_CENTRE = np.array([0.0752, 0.59525, 0.0])
PLATFORM_LIMBS, BASE_LIMBS = ("leg1", "leg2", "leg6"), ("leg1", "leg2")
ROD, INCLINOMETER = 2e-6, np.radians(0.001)
"""Widths of the uniform errors of rods and inclinometer."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """base (6, 3), platform (6, 3), offset (6,)."""

    base: np.ndarray
    platform: np.ndarray
    offset: np.ndarray

    def extensions(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        return (
            np.linalg.norm(position + self.platform @ rotation.T - self.base, axis=1) - self.offset
        )

    def value(self, name: str) -> float:
        limb, what, *letter = name.split(".")
        row = getattr(self, what)[int(limb[3:]) - 1]
        return float(row["xyz".index(letter[0])] if letter else row)

    def values(self, names: tuple[str, ...]) -> np.ndarray:
        return np.array([self.value(n) for n in names])


def geometry(mechanism: symkin.Mechanism) -> Geometry:
    return Geometry(
        *(
            np.array([getattr(limb, key) for limb in mechanism.limbs])
            for key in ("base", "platform", "offset")
        )
    )


def random_geometry(
    nominal: Geometry, held: tuple[str, ...], spread: float, rng: np.random.Generator
) -> Geometry:
    """Every entry within `spread` of nominal, those held by the frames at nominal."""
    tables = {
        k: getattr(nominal, k) + rng.uniform(-spread, spread, getattr(nominal, k).shape)
        for k in ("base", "platform", "offset")
    }
    for name in held:
        limb, what, letter = name.split(".")
        tables[what][int(limb[3:]) - 1, "xyz".index(letter)] = nominal.value(name)
    return Geometry(**tables)


def rotation(alpha: float, beta: float, gamma: float) -> np.ndarray:
    """Rz(gamma) Ry(beta) Rx(alpha)."""
    (ca, cb, cg), (sa, sb, sg) = np.cos([alpha, beta, gamma]), np.sin([alpha, beta, gamma])
    x = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
    y = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    z = np.array([[cg, -sg, 0], [sg, cg, 0], [0, 0, 1]])
    return z @ y @ x


def centred(centre: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Position of the platform frame whose circle centre is there."""
    return centre - r @ PLATFORM_CENTRE


def random_posture(
    truth: Geometry,
    tilt: np.ndarray,
    rng: np.random.Generator,
    yaw: float,
    errors: tuple[float, float],
) -> np.ndarray | None:
    """Extensions at a random place with the inclination `tilt`, or None out of stroke."""
    centre = BASE_CENTRE + [*rng.uniform(-0.25, 0.25, 2), rng.uniform(1.15, 1.45)]
    read = tilt + errors[1] * rng.uniform(-0.5, 0.5, 2)
    r = rotation(*read, np.radians(rng.uniform(-yaw, yaw)) if yaw else 0.0)
    length = truth.extensions(centred(centre, r), r)
    if length.min() < 0 or length.max() > 0.55:
        return None
    return length + errors[0] * rng.uniform(-0.5, 0.5, 6)


def groups_of_postures(
    truth: Geometry,
    rng: np.random.Generator,
    groups: int = 10,
    each: int = 4,
    *,
    tilt: float = 20.0,
    yaw: float = 20.0,
    errors: tuple[float, float] = (0.0, 0.0),
) -> tuple[np.ndarray, np.ndarray]:
    """Extensions (groups * each, 6) and group numbers; a group that is hardly reachable is drawn
    again.
    """
    joints: list[np.ndarray] = []
    while len(joints) < groups * each:
        angles = np.radians(rng.uniform(-tilt, tilt, 2)) if tilt else np.zeros(2)
        found = (random_posture(truth, angles, rng, yaw, errors) for _ in range(30 * each))
        some = [joint for joint in found if joint is not None][:each]
        if len(some) == each:
            joints += some
    return np.array(joints), np.repeat(np.arange(groups), each)


def measured(
    truth: Geometry,
    rng: np.random.Generator,
    groups: int = 10,
    *,
    noisy: bool = False,
    rods: bool = True,
    each: int = 4,
) -> Measurements:
    """Groups (10 of 4) with the standard deviations of uniform errors (of the nominal widths where
    there is no noise).
    """
    errors = (ROD, INCLINOMETER) if noisy else (0.0, 0.0)
    joints, numbers = groups_of_postures(truth, rng, groups, each, errors=errors)
    return Measurements(
        joints,
        groups=numbers,
        group_sigma=INCLINOMETER / np.sqrt(12),
        joint_sigma=ROD / np.sqrt(12) if rods else None,
    )


def tilted(
    truth: Geometry, joints: np.ndarray, poses: np.ndarray, posture: int, shift: np.ndarray
) -> np.ndarray:
    """The joint readings with one posture's inclination off by `shift` (alpha, beta), its yaw and
    circle centre kept.
    """
    w, x, y, z = poses[posture, 3:]
    r = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    angles = np.array(
        [np.arctan2(r[2, 1], r[2, 2]), np.arcsin(-r[2, 0]), np.arctan2(r[1, 0], r[0, 0])]
    )
    turned = rotation(angles[0] + shift[0], angles[1] + shift[1], angles[2])
    position = poses[posture, :3] + (r - turned) @ PLATFORM_CENTRE
    changed = joints.copy()
    changed[posture] += truth.extensions(position, turned) - truth.extensions(poses[posture, :3], r)
    return changed
