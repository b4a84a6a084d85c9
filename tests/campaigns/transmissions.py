"""Many configurations of many transmissions: is power the same on both sides, does every goal keep
its branch, do motors come back from joints, and is the array file the verb's twin?

    python tests/campaigns/transmissions.py [NAMES] [--count 2000] [--seed 0] [--models]
                                            [--tracks 20] [--legs 0]

For each of the shared machines, and with `--models` for every transmission that is found in the
models of others: `--count` random goals of the motors; those that are reached go back through the
joints; `--tracks` of them are held against a track with proof. `--legs`: at so many motors of a
closed ankle its dynamics are held against MuJoCo's and Pinocchio's. Exit status 1 where anything is
wrong.
"""

from __future__ import annotations

import argparse
import sys
import types
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from helpers.closed_leg import g1_maps, of_mujoco, of_pinocchio
from helpers.closed_leg import worst as worst_of_leg
from helpers.inside import array_source
from helpers.transmissions import MODELS, robot, transmission

MACHINES = (
    "geared",
    "four_bar",
    "ankle",
    "g1",
    "five_bar",
    "six_bar",
    "digit_knee",
    "digit_ankle",
)
POWER, THERE_AND_BACK, SAME, DYNAMICS = 1e-12, 1e-12, 1e-7, 1e-8
"""Relative power that is lost; error of motors that come back; what tells branches apart;
relative error of motions, accelerations, inertias and torques of a closed leg.
"""
REGULAR = 1e3
"""Condition of a Jacobian up to which a configuration is regular: rounding of the inverse is as
many times larger.
"""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAMES", help="of the shared machines")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--tracks", type=int, default=20)
    parser.add_argument("--models", action="store_true")
    parser.add_argument("--legs", type=int, default=0)
    told = parser.parse_args()
    worst = 0
    for engine in (of_mujoco, of_pinocchio) if told.legs else ():
        off = worst_of_leg(engine, g1_maps(), told.legs, told.seed)
        worst += int((off > DYNAMICS).any())
        print(f"{engine.__name__}: {told.legs} configurations of a closed leg: {off}", flush=True)
    for name, found in machines(told.names or MACHINES, told.models):
        faults, text = judge(found, told.count, told.seed, told.tracks)
        worst += faults
        print(f"{name}: {text}{'' if not faults else f'; {faults} WRONG'}", flush=True)
    return int(worst > 0)


def machines(names: Sequence[str], models: bool) -> Iterator[tuple[str, symkin.Transmission]]:
    for name in names:
        yield name, transmission(name)
    files = sorted(MODELS.glob("*/*.*")) if models else []
    for path in files:
        if path.suffix in (".xml", ".urdf", ".sdf"):
            try:
                for key, found in robot(str(path.relative_to(MODELS))).items():
                    yield f"{path.stem}, {key}", found
            except symkin.InputError as error:
                print(f"{path.stem}: {error}", flush=True)


def judge(found: symkin.Transmission, count: int, seed: int, tracks: int) -> tuple[int, str]:
    """Faults of one transmission, and what was looked at."""
    rng, survey = np.random.default_rng(seed), found.survey
    low, high = survey.states.motors.min(axis=0), survey.states.motors.max(axis=0)
    turn = found.linkage.mechanism.angle_out(1.0)
    units = [
        np.array([turn if c.is_angular else 1.0 for c in found.linkage.coordinates_of(names)])
        for names in (found.motors, found.joints)
    ]
    goals = low + (high - low) * rng.uniform(-0.2, 1.2, (count, len(low)))
    there = found.states(goals * units[0], check=False)
    reached = np.isfinite(there.w).all(axis=1)
    back = found.states(joints=there.joints[reached] * units[1], check=False).motors
    off = np.abs(back - goals[reached]).max(axis=1, initial=0.0)
    # beyond a motor's dead centre the joints are those of another motor angle
    returned = off < SAME
    with np.errstate(all="ignore"):
        steep = np.abs(there.inverse_jacobian[reached]).max(axis=(1, 2))
    # near a dead centre of a motor rounding of the joints is as many times larger there
    share = off[returned] / np.maximum(1.0, np.nan_to_num(steep[returned], nan=np.inf))
    faults = int((share > THERE_AND_BACK * max(1.0, np.abs(goals).max())).sum())
    lost = _power_lost(there, reached, rng)
    faults += int(lost > POWER)
    wrong, proved = _against_tracks(found, goals[reached][:tracks], there, reached, units)
    text = (
        f"{count} goals, {reached.sum()} reached, {returned.sum()} come back to "
        f"{off[returned].max(initial=0.0):.1e} ({share.max(initial=0.0):.1e} over the slope); "
        f"power {lost:.1e}; {proved} tracks, {wrong} wrong"
    )
    try:
        twin = types.ModuleType("twin")
        exec(compile(array_source(found), "twin", "exec"), twin.__dict__)
    except symkin.InputError:
        return faults + wrong, f"{text}; no array file"
    with np.errstate(all="ignore"):
        mine = twin.joints(goals)
        still = twin.joints(goals, guess=mine)
    told = np.isfinite(mine).all(axis=1)
    apart = np.abs(mine - there.joints).max(axis=1)
    left = int((told & reached & (apart > SAME)).sum())
    more = int((told & ~reached).sum())
    # an answer as its own guess stays where it is
    stays = np.abs(still - mine)[told].max(axis=1, initial=0.0) <= SAME
    moved = int((~stays).sum())
    return (
        faults + wrong + left + moved,
        f"{text}; file: {told.sum()} told, {left} on another branch, {moved} that do not stand "
        f"still, {more} that no line reaches",
    )


def _power_lost(states: object, reached: np.ndarray, rng: np.random.Generator) -> float:
    """The largest difference of power on both sides over the sum of its terms, at regular
    configurations.
    """
    g, j = states.inverse_jacobian[reached], states.jacobian[reached]  # type: ignore[attr-defined]
    regular = np.isfinite(g).all(axis=(1, 2)) & np.isfinite(j).all(axis=(1, 2))
    g, j = g[regular], j[regular]
    regular = np.linalg.cond(g) < REGULAR
    g, j = g[regular], j[regular]
    joint_rates = rng.normal(size=(len(g), g.shape[2]))
    held = rng.normal(size=(len(g), g.shape[1]))
    motor_rates = np.einsum("nai,ni->na", g, joint_rates)
    of_joints = np.einsum("nai,na->ni", g, held)
    joint_rates = np.einsum("nia,na->ni", j, motor_rates)
    left, right = held * motor_rates, of_joints * joint_rates
    size = np.abs(left).sum(axis=1) + np.abs(right).sum(axis=1)
    return float(np.max(np.abs(left.sum(axis=1) - right.sum(axis=1)) / size, initial=0.0))


def _against_tracks(
    found: symkin.Transmission,
    goals: np.ndarray,
    there: object,
    reached: np.ndarray,
    units: list[np.ndarray],
) -> tuple[int, int]:
    """How many of some goals a proved track leads elsewhere, of how many."""
    joints = there.joints[reached][: len(goals)]  # type: ignore[attr-defined]
    here = found.linkage.reference[found.linkage.motor_places]
    wrong = proved = 0
    for goal, mine in zip(goals, joints, strict=True):
        path = {
            name: [float(a), float(b)]
            for name, a, b in zip(found.motors, here * units[0], goal * units[0], strict=True)
        }
        way = symkin.track(found.linkage.mechanism, given=path, limits=False, name_modes=False)
        if way.reached and way.certified:
            proved += 1
            told = np.array([way.end.solution.joints[name] for name in found.joints]) / units[1]
            wrong += int(np.abs(told - mine).max() > SAME)
    return wrong, proved


if __name__ == "__main__":
    sys.exit(main())
