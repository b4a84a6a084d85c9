"""Machines with motors and joints, and their transmissions, that the tests share."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import symkin

MODELS = Path(__file__).resolve().parents[1] / "data" / "models"
G1 = MODELS / "mjcf" / "g1_parallel_ankle.xml"
G1_RANGES = {"roll_joint": (-0.26, 0.26)}
"""The file's own limits of roll are in degrees, and as radians none."""
DIGIT = MODELS / "urdf_gepetto_yaml" / "digit_like_2legs.urdf"
KANGAROO = MODELS / "mjcf" / "kangaroo_lower_body.xml"


def linear(motors: dict[str, dict[str, float]]) -> symkin.Transmission:
    """Geared joints: motors as sums of joints, by name."""
    joints = sorted({name for of in motors.values() for name in of})
    names = [*motors, *joints]
    axes = [
        symkin.LinkJoint(
            symkin.Joint(name, "R", [0, 0, 0], [0, 0, 1], actuated=name in motors),
            ["base", f"link_{name}"],
        )
        for name in names
    ]
    gears = [symkin.Coupling(name, of) for name, of in motors.items()]
    machine = symkin.Mechanism("geared", link_joints=axes, couplings=gears)
    return symkin.transmission(machine, list(motors), joints)


def kangaroo_knee() -> symkin.Transmission:
    """A slide that pushes a knee; the ankle on the same axis turns freely."""
    robot = symkin.load(KANGAROO)
    start = {"leg_left_length_joint": 0.45, "leg_left_femur_joint": 0.5, "leg_left_4_joint": 0.1}
    return symkin.transmission(
        robot,
        ["leg_left_length_joint", "leg_left_4_joint"],
        ["leg_left_knee_joint", "leg_left_4_joint"],
        start=start,
    )


@cache
def transmission(name: str) -> symkin.Transmission:
    """One of the `MACHINES`, made once."""
    if name == "geared":
        return linear({"a1": {"j1": 1.0}, "a2": {"j1": 1.0, "j2": 1.0}})
    if name == "redundant":
        return linear(
            {"a1": {"j1": 1.0}, "a2": {"j1": 1.0, "j2": 1.0}, "a3": {"j1": 1.0, "j2": -2.0}}
        )
    if name == "four_bar":
        return symkin.transmission(symkin.load("four_bar"), ["crank"], ["follower"])
    if name == "ankle":
        return symkin.transmission(symkin.load("ankle"), ["upper_motor", "lower_motor"])
    if name == "kangaroo":
        return kangaroo_knee()
    if name == "g1":
        options: dict[str, Any] = {"ranges": G1_RANGES}
        return symkin.transmission(symkin.load(G1), **options).found[0]
    file, key = {
        "five_bar": ("urdf_gepetto_yaml/5bar_linkage_iso3d.urdf", 0),
        "six_bar": ("urdf_plus/six_bar.urdf", 0),
        "digit_knee": ("urdf_gepetto_yaml/digit_like_2legs.urdf", 0),
        "digit_ankle": ("urdf_gepetto_yaml/digit_like_2legs.urdf", 2),
    }[name]
    return robot(file).found[key]


@cache
def robot(file: str) -> symkin.Transmissions:
    """All transmissions that are found in a model."""
    return symkin.transmission(symkin.load(MODELS / file))


def regular_motors(
    found: symkin.Transmission, count: int, seed: int = 0, reach: float = 0.3
) -> np.ndarray:
    """Random values of motors about the reference (count, m) at which the joints are reached."""
    rng = np.random.default_rng(seed)
    here = found.motors_of(found.states().joints[0] / _units(found, found.joints))
    size = [
        1.0 if c.is_angular else found.linkage.size
        for c in found.linkage.coordinates_of(found.motors)
    ]
    if len(found.motors) == found.linkage.mobility:
        goals = here + reach * np.array(size) * rng.uniform(-1, 1, (count, len(here)))
    else:
        joints = found.states().joints[0] + reach * rng.uniform(-1, 1, (count, len(found.joints)))
        goals = found.motors_of(joints, check=False)
    reached = np.isfinite(found.joints_of(goals, check=False)).all(axis=1)
    return np.asarray(goals[reached])


def _units(found: symkin.Transmission, names: tuple[str, ...]) -> np.ndarray:
    """What divides radians into the machine's angles."""
    turn = found.linkage.mechanism.angle_in(1.0)
    return np.array([turn if c.is_angular else 1.0 for c in found.linkage.coordinates_of(names)])
