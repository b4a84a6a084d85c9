"""The paper's experiment in numbers: groups of postures, readings with noise, and fits by symkin.

Units: m, rad; Precision as the paper states it. Arrays as in `model`. Source: Ren, Feng, Su 2008,
2.1 and 2.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

import symkin
from studies.ren2008.model import (
    ASIDE,
    BASE_CENTRE,
    EXTENSIONS,
    HEIGHTS,
    NAMES,
    PLATFORM_CENTRE,
    TILT,
    angles_of,
    eta_from,
    eta_of,
    held_names,
    inverse,
    turn,
)
from symkin.calibration.calibrate import calibrate
from symkin.calibration.data.measurements import Measurements
from symkin.calibration.judge.result import Calibration
from symkin.spatial.rotation import quaternion_from_matrix

TESTS = 200
TILTS = ("target.rotation.x", "target.rotation.y")
"""How the inclinometer sits on the platform: unknown when its absolute readings are used."""


@dataclass(frozen=True)
class Precision:
    """Rod noise [m] and repeatability of the inclinometer [deg]; both uniform within +- half of
    them.
    """

    rod: float
    inclinometer: float

    @property
    def sigmas(self) -> tuple[float, float]:
        """Standard deviations: m, rad."""
        return self.rod / np.sqrt(12), np.radians(self.inclinometer) / np.sqrt(12)

    def __str__(self) -> str:
        return f"rod {1e6 * self.rod:g} um, inclinometer {self.inclinometer:g} deg"


EXACT = Precision(0.0, 0.0)
BEST = Precision(2e-6, 0.001)


# --- postures -------------------------------------------------------------------------------------


def posture_at(centres: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """X (n, 6) whose platform circles are centred at `centres` (n, 3), turned by angles (n, 3) in
    rad.
    """
    return np.hstack([centres - turn(angles) @ PLATFORM_CENTRE, angles])


def centres_of(X: np.ndarray) -> np.ndarray:
    """Centres (n, 3) of the platform's joint circle."""
    return X[:, :3] + turn(X[:, 3:]) @ PLATFORM_CENTRE


def random_postures(
    eta: np.ndarray, inclinations: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, int]:
    """X (n, 6) of the assumed workspace with (alpha, beta) as given [rad] or random where NaN, and
    how many were drawn.
    """
    left, drawn, found = np.arange(len(inclinations)), 0, np.zeros((len(inclinations), 6))
    while len(left):
        drawn += len(left)
        aside, heights = (
            rng.uniform(-ASIDE, ASIDE, (len(left), 2)),
            rng.uniform(*HEIGHTS, len(left)),
        )
        angles = np.radians(rng.uniform(-TILT, TILT, (len(left), 3)))
        angles[:, :2] = np.where(np.isnan(inclinations[left]), angles[:, :2], inclinations[left])
        X = posture_at(BASE_CENTRE + np.column_stack([aside, heights]), angles)
        q = inverse(X, eta)
        inside = (q.min(axis=1) >= EXTENSIONS[0]) & (q.max(axis=1) <= EXTENSIONS[1])
        found[left[inside]] = X[inside]
        left = left[~inside]
    return found, drawn


def postures_in_groups(
    eta: np.ndarray, inclined: np.ndarray, rng: np.random.Generator, each: int = 4
) -> np.ndarray:
    """X of random postures, `each` for each inclination of `inclined` (groups, 2) [rad]."""
    return random_postures(eta, np.repeat(inclined, each, axis=0), rng)[0]


def unused_poses(eta: np.ndarray, seed: int, count: int = TESTS) -> np.ndarray:
    """X (n, 6) at which calibrations are judged; no fit sees them."""
    return random_postures(eta, np.full((count, 2), np.nan), np.random.default_rng([seed, 1]))[0]


def inclinations(groups: int, rng: np.random.Generator) -> np.ndarray:
    """(alpha, beta) of the groups [rad]: equally spaced over +-20 deg, beta in random order."""
    steps = np.radians(np.linspace(-TILT, TILT, groups))
    return np.column_stack([steps, rng.permutation(steps)])


def random_truth(nominal: symkin.Mechanism, spread: float, rng: np.random.Generator) -> np.ndarray:
    """eta with errors uniform within +-spread [m], zero where the frames say so."""
    free = ~np.isin(NAMES, held_names(nominal))
    return eta_of(nominal) + np.where(free, rng.uniform(-spread, spread, len(NAMES)), 0.0)


# --- readings and fits ----------------------------------------------------------------------------


def measure(
    eta: np.ndarray, groups: int, each: int, precision: Precision, rng: np.random.Generator
) -> Measurements:
    """Groups of random postures, each group brought to one inclination as far as the inclinometer
    repeats.
    """
    return measure_groups(eta, inclinations(groups, rng), each, precision, rng)


def measure_groups(
    eta: np.ndarray, inclined: np.ndarray, each: int, precision: Precision, rng: np.random.Generator
) -> Measurements:
    """The same at given inclinations (groups, 2) [rad]."""
    tilts = np.repeat(inclined, each, axis=0)
    half = np.radians(0.5 * precision.inclinometer)
    X, _ = random_postures(eta, tilts + rng.uniform(-half, half, tilts.shape), rng)
    return readings(inverse(X, eta), np.repeat(np.arange(len(inclined)), each), precision, rng)


def measure_at(
    eta: np.ndarray,
    X: np.ndarray,
    groups: np.ndarray,
    precision: Precision,
    rng: np.random.Generator,
) -> Measurements:
    """Planned postures X (n, 6), their centres kept, their inclinations as far as the inclinometer
    repeats.
    """
    half = np.radians(0.5 * precision.inclinometer)
    angles = X[:, 3:] + np.column_stack([rng.uniform(-half, half, (len(X), 2)), np.zeros(len(X))])
    return readings(inverse(posture_at(centres_of(X), angles), eta), groups, precision, rng)


def readings(
    q: np.ndarray, groups: np.ndarray, precision: Precision, rng: np.random.Generator
) -> Measurements:
    """Extensions with rod noise; standard deviations where there is noise."""
    rod, tilt = precision.sigmas
    noise = rng.uniform(-0.5 * precision.rod, 0.5 * precision.rod, q.shape)
    return Measurements(q + noise, groups=groups, joint_sigma=rod or None, group_sigma=tilt or None)


def fit(
    nominal: symkin.Mechanism,
    measured: Measurements,
    residual: str = "means",
) -> Calibration:
    """symkin's fit in the paper's frames; `residual`: "differences" of neighbours, the paper's (4),
    or "means" of groups.
    """
    return calibrate(
        nominal,
        measured,
        fixed=held_names(nominal),
        residual=residual,
        outliers="ignore",
    )


def absolute_readings(
    eta: np.ndarray, postures: int, precision: Precision, accuracy: float, rng: np.random.Generator
) -> Measurements:
    """Random postures with both inclinations read absolutely, each wrong by up to half the accuracy
    [deg].
    """
    X, _ = random_postures(eta, np.full((postures, 2), np.nan), rng)
    half = np.radians(0.5 * accuracy)
    read = readings(inverse(X, eta), np.full(postures, -1), precision, rng)
    tilts = X[:, 3:5] + rng.uniform(-half, half, (postures, 2))
    return replace(
        read,
        groups=None,
        group_sigma=None,
        inclination=tilts,
        inclination_sigma=2 * half / np.sqrt(12),
    )


def absolute_fit(nominal: symkin.Mechanism, measured: Measurements) -> Calibration:
    """A fit of absolute inclinations as Besnard and Khalil (1999) read them, the inclinometer's
    mounting among the unknowns.
    """
    return calibrate(
        nominal, measured, parameters=[*NAMES, *TILTS], fixed=held_names(nominal), outliers="ignore"
    )


@dataclass(frozen=True, eq=False)
class Fits:
    """Calibrations of one kind, as a row quotes them: what was read and how it was fitted are read
    off the first.
    """

    found: Sequence[Calibration]

    def evidence(self) -> dict[str, object]:
        problem, method = self.found[0].problem, self.found[0].method
        what = problem.form if problem.measurements.groups is not None else "absolute inclinations"
        return {
            "by": "symkin.calibrate",
            "method": f"{what}, {method}",
            "calls": len(self.found),
            "text": f"calibrate: {what}, {method}",
        }


def deviation(values: dict[str, float], eta: np.ndarray) -> float:
    """Largest error of the identified parameters [m]."""
    return float(np.abs(eta_from(values, eta) - eta).max())


def poses_of(X: np.ndarray) -> list[symkin.Pose]:
    """The postures as symkin's poses."""
    return [
        symkin.Pose(row[:3], quaternion_from_matrix(R))
        for row, R in zip(X, turn(X[:, 3:]), strict=True)
    ]


def posture_of(poses: Sequence[symkin.Pose]) -> np.ndarray:
    """X (n, 6) of symkin's poses."""
    return np.hstack(
        [np.array([p.position for p in poses]), angles_of(np.array([p.rotation for p in poses]))]
    )
