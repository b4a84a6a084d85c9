"""A laser tracker's readings of an arm and of a hexapod, made in plain NumPy: nothing here uses
symkin's formulas.

The tracker stands anywhere (world frame W) and sees a reflector anywhere on the platform (point t
of its frame): it reads W (R t + p) and no orientation. Units mm, rad.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import symkin
from symkin import DHRow, DHTable, serial_arm_from_dh

WORLD_POSITION, WORLD_ROTATION = np.array([2400.0, -1300.0, 650.0]), np.array([0.3, -0.5, 2.1])
REFLECTOR = np.array([35.0, -60.0, 80.0])
NOISE = 0.02
"""Standard deviation of a coordinate that the tracker reads."""
ARM = np.array(
    [
        (0.0, 300.0, 60.0, 90.0),
        (90.0, 20.0, 400.0, 5.0),
        (0.0, -15.0, 70.0, 85.0),
        (0.0, 420.0, 10.0, -88.0),
        (0.0, 8.0, 5.0, 91.0),
        (0.0, 90.0, 0.0, 0.0),
    ]
)
"""theta, d, a, alpha of a 6R arm without parallel axes, standard convention, degrees."""


def turned(r: np.ndarray) -> np.ndarray:
    """Rotation matrix of a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(r))
    k = np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]]) / max(angle, 1e-300)
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


@dataclass(frozen=True, eq=False)
class Posed:
    """Postures of a machine: joints (n, a), rotations (n, 3, 3) and positions (n, 3) of its
    platform.
    """

    joints: np.ndarray
    rotations: np.ndarray
    positions: np.ndarray

    def seen(
        self,
        world: np.ndarray = WORLD_POSITION,
        turn: np.ndarray = WORLD_ROTATION,
        reflector: np.ndarray = REFLECTOR,
    ) -> np.ndarray:
        """What the tracker would read without noise (n, 3)."""
        return world + (self.positions + self.rotations @ reflector) @ turned(turn).T

    def csv(self, names: list[str], rng: np.random.Generator) -> str:
        """A file of the readings, joints by their names with units (`q1[rad]`)."""
        read = np.column_stack(
            [self.joints, self.seen() + NOISE * rng.normal(size=(len(self.joints), 3))]
        )
        header = ",".join([*names, "x[mm]", "y[mm]", "z[mm]"])
        return "\n".join([header, *(",".join(repr(float(v)) for v in row) for row in read)]) + "\n"


def arm(table: np.ndarray = ARM) -> symkin.Mechanism:
    """The arm of a DH table in degrees."""
    rows = [
        DHRow(f"q{k}", theta=np.radians(t), d=d, a=a, alpha=np.radians(al))
        for k, (t, d, a, al) in enumerate(table, start=1)
    ]
    return serial_arm_from_dh("arm", DHTable("standard", rows), length_unit="mm", angle_unit="deg")


def arm_posed(table: np.ndarray, joints: np.ndarray) -> Posed:
    """The arm at joint values (n, 6): A = Rz(theta + q) Tz(d) Tx(a) Rx(alpha), link after link."""
    count = len(joints)
    rotations, positions = np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3))
    for k, (theta, d, a, alpha) in enumerate(table):
        for n in range(count):
            about_z = turned(np.array([0.0, 0.0, np.radians(theta) + joints[n, k]]))
            positions[n] += rotations[n] @ (about_z @ np.array([a, 0.0, d]))
            rotations[n] = rotations[n] @ about_z @ turned(np.array([np.radians(alpha), 0.0, 0.0]))
    return Posed(joints, rotations, positions)


@dataclass(frozen=True, eq=False)
class Hexapod:
    """base (6, 3), platform (6, 3), offset (6,)."""

    base: np.ndarray
    platform: np.ndarray
    offset: np.ndarray

    @staticmethod
    def nominal() -> Hexapod:
        angles = np.radians([0.0, 50.0, 120.0, 170.0, 240.0, 290.0])
        base = np.column_stack(
            [300.0 * np.cos(angles), 300.0 * np.sin(angles), [0.0, 5.0, -5.0, 8.0, -3.0, 0.0]]
        )
        others = np.radians([25.0, 35.0, 140.0, 160.0, 255.0, 280.0])
        platform = np.column_stack(
            [160.0 * np.cos(others), 160.0 * np.sin(others), [0.0, -4.0, 6.0, 3.0, 0.0, -6.0]]
        )
        return Hexapod(base, platform, np.full(6, 250.0))

    def spoilt(self, rng: np.random.Generator, spread: float = 0.5) -> Hexapod:
        """A machine as built: every number off by up to `spread`."""
        return Hexapod(
            *(
                part + rng.uniform(-spread, spread, part.shape)
                for part in (self.base, self.platform, self.offset)
            )
        )

    def mechanism(self) -> symkin.Mechanism:
        limbs = [
            symkin.RodLimb(f"leg{k}", b, p, o)
            for k, (b, p, o) in enumerate(
                zip(self.base, self.platform, self.offset, strict=True), start=1
            )
        ]
        return symkin.Mechanism(
            "hexapod",
            limbs,
            length_unit="mm",
            angle_unit="deg",
            platform_position=(0.0, 0.0, 420.0),
        )

    def postures(self, count: int, rng: np.random.Generator) -> Posed:
        """Random poses about (0, 0, 420), and the legs that take them there."""
        positions = np.array([0.0, 0.0, 420.0]) + rng.uniform(-80.0, 80.0, (count, 3))
        rotations = np.array([turned(rng.uniform(-0.35, 0.35, 3)) for _ in range(count)])
        return Posed(
            np.linalg.norm(self.rods(rotations, positions), axis=2) - self.offset,
            rotations,
            positions,
        )

    def rods(self, rotations: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Vectors (n, 6, 3) from base to platform joints."""
        return positions[:, None] + self.platform @ rotations.transpose(0, 2, 1) - self.base

    def posed(self, joints: np.ndarray) -> Posed:
        """The direct problem from the middle of the workspace, by Newton: rows [u, (R m) x u] of
        the rods' directions u.
        """
        count = len(joints)
        rotations, positions = (
            np.tile(np.eye(3), (count, 1, 1)),
            np.tile([0.0, 0.0, 420.0], (count, 1)),
        )
        for _ in range(20):
            rods = self.rods(rotations, positions)
            length = np.linalg.norm(rods, axis=2)
            u = rods / length[:, :, None]
            jacobian = np.concatenate(
                [u, np.cross(self.platform @ rotations.transpose(0, 2, 1), u)], axis=2
            )
            step = np.linalg.solve(jacobian, (joints + self.offset - length)[:, :, None])[:, :, 0]
            positions += step[:, :3]
            rotations = np.array(
                [turned(w) @ r for w, r in zip(step[:, 3:], rotations, strict=True)]
            )
        return Posed(joints, rotations, positions)
