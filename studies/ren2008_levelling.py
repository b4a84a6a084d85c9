"""The measuring procedure of 1.5 on a simulated machine: wedge, biaxial inclinometer, and a loop that brings its readings to
zero.

The machine has the true geometry, its controller the nominal one. A wedge W turns the inclinometer on the platform; with
n = W^T R^T e_z the vertical as the inclinometer sees it, its readings are (alpha, beta) of n = (-sin beta, cos beta sin alpha,
cos beta cos alpha), wrong by as much as it repeats. One move of a loop:

    command a pose -> the rods of the nominal inverse problem -> the true pose -> readings r
    (alpha, beta) of the command less J^-1 r, J = d readings / d (alpha, beta) by the controller's model

until both readings are within the tolerance; then the rods are read. How the loop begins is the remark on fast servo adjustment
of the paper's outlook:

    plain       at the wedge's nominal inclination
    carried     at that less the correction that the last posture of the group needed
    identified  plain, with the identified geometry in the controller

Units: m, rad. Source: Ren, Feng, Su 2008, 1.5 and 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ren2008_method import Precision, centres_of, posture_at, random_postures, readings
from ren2008_model import direct, inverse, turn
from symkin.calibration.data.measurements import Measurements

MOST = 20
STARTS = ("plain", "carried")
WEDGE_ERROR = np.radians(0.2)
"""How far a wedge is from its drawing, each way: nobody measures it."""


def level_turn(inclination: np.ndarray) -> np.ndarray:
    """The wedge under which a platform at (alpha, beta) holds the inclinometer level: W = (Ry(beta) Rx(alpha))^T."""
    return turn(np.array([[inclination[0], inclination[1], 0.0]]))[0].T


def read(angles: np.ndarray, wedge: np.ndarray) -> np.ndarray:
    """Readings (alpha, beta) of an inclinometer on a wedge, platform at angles (3,)."""
    n = wedge.T @ turn(angles[None])[0].T[:, 2]
    return np.array([np.arctan2(n[1], n[2]), np.arctan2(-n[0], np.hypot(n[1], n[2]))])


@dataclass(frozen=True, eq=False)
class Loop:
    """One posture: the readings of each move, the last commanded posture and the true one."""

    readings: np.ndarray
    command: np.ndarray
    truth: np.ndarray

    @property
    def moves(self) -> int:
        return len(self.readings)


@dataclass(frozen=True, eq=False)
class Machine:
    """True and controller's parameters, and how far readings repeat [rad]."""

    truth: np.ndarray
    model: np.ndarray
    repeatability: float

    def level(self, command: np.ndarray, wedge: np.ndarray, drawn: np.ndarray, rng: np.random.Generator) -> Loop:
        """Move until the inclinometer on `wedge` (its drawing: `drawn`) reads zero as far as it repeats."""
        command, centre, seen = command.copy(), centres_of(command[None]), []
        half = 0.5 * self.repeatability
        for _ in range(MOST):
            truth = direct(inverse(command[None], self.model), self.truth, command[None])[0]
            seen.append(read(truth[3:], wedge) + rng.uniform(-half, half, 2))
            if np.abs(seen[-1]).max() <= max(self.repeatability, 1e-12):
                return Loop(np.array(seen), command, truth)
            command[3:5] -= np.linalg.solve(by_inclination(command[3:], drawn), seen[-1])
            command = posture_at(centre, command[None, 3:])[0]
        raise SystemExit(f"ren2008: the inclinometer was not levelled in {MOST} moves")


def by_inclination(angles: np.ndarray, wedge: np.ndarray) -> np.ndarray:
    """d readings / d (alpha, beta) (2, 2), by central differences."""
    step = 1e-5
    ends = [read(angles + s * e, wedge) for e in np.eye(3)[:2] for s in (step, -step)]
    return np.column_stack([(ends[0] - ends[1]), (ends[2] - ends[3])]) / (2 * step)


@dataclass(frozen=True, eq=False)
class Campaign:
    """All loops of the procedure in order, the group of each, and the readings for calibration."""

    loops: list[Loop]
    groups: np.ndarray
    measured: Measurements

    def evidence(self) -> dict[str, object]:
        return {"by": "ren2008_levelling.campaign", "method": "levelling loop", "text": "levelling loop of 1.5"}

    @property
    def moves(self) -> np.ndarray:
        return np.array([loop.moves for loop in self.loops])

    @property
    def first(self) -> np.ndarray:
        """Largest first reading of each posture [rad]."""
        return np.array([np.abs(loop.readings[0]).max() for loop in self.loops])

    @property
    def spread(self) -> float:
        """Largest difference of true (alpha, beta) within a group [rad]."""
        angles = np.array([loop.truth[3:5] for loop in self.loops])
        return max(float(np.ptp(angles[self.groups == g], axis=0).max()) for g in np.unique(self.groups))


def campaign(
    machine: Machine, held: np.ndarray, each: int, precision: Precision, rng: np.random.Generator, start: str = "plain"
) -> Campaign:
    """The procedure of 1.5: for each wedge `each` postures are levelled, and their rods read; `held` (groups, 2) are the
    inclinations for which the wedges are drawn."""
    if start not in STARTS:
        raise ValueError(f"start = {start!r}; allowed: {', '.join(STARTS)}")
    loops = []
    for drawn in held:
        wedge = level_turn(drawn + rng.uniform(-WEDGE_ERROR, WEDGE_ERROR, 2))
        commands, _ = random_postures(machine.model, np.tile(drawn, (each, 1)), rng)
        shift = np.zeros(2)
        for command in commands:
            begin = posture_at(centres_of(command[None]), command[None, 3:] + np.array([*shift, 0.0]))[0]
            loops.append(machine.level(begin, wedge, level_turn(drawn), rng))
            if start == "carried":
                shift = loops[-1].command[3:5] - drawn
    groups = np.repeat(np.arange(len(held)), each)
    q = inverse(np.array([loop.truth for loop in loops]), machine.truth)
    return Campaign(loops, groups, readings(q, groups, precision, rng))
