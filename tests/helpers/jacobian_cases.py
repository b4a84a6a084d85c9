"""Mechanisms of every joint type and motion at closed configurations, and finite differences of
solved configurations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

import symkin
from helpers import joint_types, samples
from helpers.inside import (
    Closure,
    build_closure,
    build_problem,
    closed_configurations,
    conjugate,
    joint_readings,
    link_poses,
    multiply,
    pose_of,
    rate_names,
    velocity_equations,
    whole_system,
)
from helpers.shipped import LIMBS
from symkin import Mechanism

FAMILIES: dict[str, tuple[list[str], dict[str, Any]]] = {
    "6 SPS": (["SPS"] * 6, {}),
    "6 RUS": (["rUS"] * 6, {}),
    "6 PUS": (["pUS"] * 6, {}),
    "6 HUS": (["hUS"] * 6, {}),
    "6 UPS": (["UpS"] * 6, {}),
    "3 RCU": (["rCU"] * 3, {}),
    "3 RPS": (["RpS"] * 3, {}),
    "3 RRS": (["rRS"] * 3, {}),
    "3 HRS": (["hRS"] * 3, {}),
    "3 RUU": (["rUU"] * 3, {}),
    "2 RRRRRR": (["rrrRRR"] * 2, {}),
    "loop RHCS": (["rH", "CS"], {}),
    "loop PRUS": (["pR", "US"], {}),
    "loop HPUS": (["hP", "US"], {}),
    "loop RCCC": (["rC", "CC"], {}),
    "idle limb": ([*["SPS"] * 6, "SRSS"], {}),
    "redundant actuation": (["SPS"] * 7, {}),
    "redundant limb": (["rprrS", "rpRS", "SPS"], {}),
    "planar rods": (["SPS"] * 3, {"motion": "planar"}),
    "planar RUS": (["rUS"] * 3, {"motion": "planar"}),
    "schoenflies RUS": (["rUS"] * 4, {"motion": "schoenflies"}),
    "schoenflies PRS": (["pRRS"] * 4, {"motion": "schoenflies"}),
    "translation PUS": (["pUS"] * 3, {"motion": "translation"}),
    "spherical HUS": (["hUS"] * 3, {"motion": "spherical"}),
    "arm RRPRRR": (["rrprrr"], {"serial": True}),
    "arm RPRHRR": (["rprhrr"], {"serial": True}),
    "arm RRRRRRR": (["rrrrrrr"], {"serial": True}),
    "arm RRP": (["rrp"], {"serial": True}),
}
"""Random mechanisms by their limbs' letters (see samples.random_mechanism)."""
REDUNDANT = {"redundant actuation", "redundant limb", "arm RRRRRRR", "seven_joints", "eight_joints"}
"""Twist and rates do not decide one another."""
UNCONSTRAINED = [
    "zhang2009",
    "zhao2000",
    "gluon_6l3",
    "delta",
    "planar three_rrr",
    "rods_at_the_end",
    "6 SPS",
    "6 RUS",
    "6 PUS",
    "6 HUS",
    "6 UPS",
    "2 RRRRRR",
    "planar RUS",
    "schoenflies PRS",
    "translation PUS",
    "spherical HUS",
    "arm RRPRRR",
    "arm RPRHRR",
]
"""Limbs that forbid no twist of the motion."""
CLASSICAL = {
    "delta": samples.delta,
    "three_rps": samples.three_rps,
    "three_rrr": samples.three_rrr,
    "five_bar": samples.five_bar,
    "planar three_rrr": lambda: samples.three_rrr("planar"),
    "four_bar": lambda: samples.four_bar()[0],
    **{made.__name__: made for made in joint_types.MADE},
}
NAMES = [*LIMBS, *CLASSICAL, *FAMILIES]
FEW = [*LIMBS[::3], *list(CLASSICAL)[::3], *list(FAMILIES)[::2]]
"""Those on which the gate tries laws that take long."""


@dataclass(frozen=True, eq=False)
class Case:
    """A mechanism at a closed configuration; `condition` is that of its position problems there."""

    mechanism: Mechanism
    closure: Closure
    values: np.ndarray
    condition: float


@cache
def case(name: str) -> Case:
    """The best conditioned configuration of the first seed that has one below 1e6, of the mechanism
    of that name: those of a singular reference's own assembly begin beside it.
    """
    for seed in range(6):
        mechanism = _mechanism(name, seed)
        closure = build_closure(mechanism)
        found = [
            (_condition(mechanism, values), values)
            for values in closed_configurations(closure, seed + 1)
        ]
        condition, values = min(found, key=lambda pair: pair[0])
        if condition < 1e6:
            return Case(mechanism, closure, values, condition)
    raise AssertionError(f"{name}: no closed configuration of condition below 1e6")


def _mechanism(name: str, seed: int) -> Mechanism:
    if name in FAMILIES:
        limbs, options = FAMILIES[name]
        return samples.random_mechanism(np.random.default_rng(100 + seed), limbs, **options)
    return CLASSICAL[name]() if name in CLASSICAL else symkin.load(name)


def _condition(mechanism: Mechanism, values: np.ndarray) -> float:
    """Of the direct problem; of the inverse one for a serial arm."""
    problem = build_problem(mechanism, "inverse" if mechanism.serial else "direct")
    return problem.system.condition(
        problem.select_values(values, problem.system.unknowns),
        problem.select_values(values, problem.known_coordinates),
    )


_STENCIL = ((1, 45 / 60), (2, -9 / 60), (3, 1 / 60))
"""Central differences of sixth order: f' h = sum of weight (f(k h) - f(-k h))."""


def differences(f: Any, step: float) -> np.ndarray:
    """df/ds at s = 0."""
    return sum(weight * (f(k * step) - f(-k * step)) for k, weight in _STENCIL) / step


def along_joint(c: Case, k: int, s: float) -> np.ndarray:
    """The closed configuration after actuated joint k has moved by s."""
    problem = build_problem(c.mechanism, "direct")
    known = problem.select_values(c.values, problem.known_coordinates).copy()
    known[k] += s
    if problem.is_explicit:
        return problem.join_values(problem.forward(known), known)
    start = problem.select_values(c.values, problem.system.unknowns)
    return problem.join_values(problem.system.polish(start, known, 10), known)


def along_pose(c: Case, k: int, s: float) -> np.ndarray:
    """The closed configuration after the platform has moved by s in component k of the motion's
    twist coordinates.
    """
    problem = build_problem(c.mechanism, "inverse")
    pose = [x for x in c.closure.coordinates if x.role == "pose"]
    system = whole_system(c.closure)
    first = sum(x.freedom for x in c.closure.coordinates if x.role != "pose")
    step = np.zeros((1, system.freedom))
    scale = [
        c.closure.characteristic_length if x.is_angular or x.kind == "quaternion" else 1.0
        for x in pose
        for _ in range(x.freedom)
    ]
    step[0, first + k] = s * scale[k]
    moved = system.move(c.values[None], step)[0]
    known = problem.select_values(moved, problem.known_coordinates)
    return problem.join_values(
        problem.system.polish(problem.select_values(c.values, problem.system.unknowns), known, 10),
        known,
    )


def twist(c: Case, path: Any, step: float) -> np.ndarray:
    """(velocity; angular velocity) of the platform along a path of configurations, by
    differences.
    """
    base = pose_of(c.closure, path(0.0))

    def pose(s: float) -> np.ndarray:
        there = pose_of(c.closure, path(s))
        sign = 1.0 if there.quaternion @ base.quaternion > 0 else -1.0
        return np.concatenate([there.position, sign * there.quaternion])

    rate = differences(pose, step)
    return np.concatenate([rate[:3], 2 * multiply(rate[3:], conjugate(base.quaternion))[1:]])


def joint_rates(c: Case, path: Any, step: float, role: str) -> np.ndarray:
    """Rates of the actuated or passive joints along a path; spherical joints by their angular
    velocity.
    """
    rate = differences(path, step)
    found = [np.zeros(0)]
    for x in c.closure.role(role):
        place = c.closure.slices[x.name]
        found.append(
            2 * multiply(rate[place], conjugate(c.values[place]))[1:]
            if x.kind == "quaternion"
            else rate[place]
        )
    return np.concatenate(found)


def closure_passive(c: Case) -> np.ndarray:
    """The passive Jacobian of the joints that the closure holds."""
    made = symkin.jacobian(c.mechanism, "passive")
    held = rate_names(c.closure.role("passive"))
    return made.at(c.values)[[made.rows.index(name) for name in held]]


def readings(c: Case, values: np.ndarray) -> dict[str, np.ndarray]:
    """What all joints read, those at which loops are cut too, as columns."""
    found = joint_readings(c.closure, link_poses(c.closure, values[None]))
    return {name: np.asarray(value).reshape(-1) for name, value in found.items()}


def agrees(expected: np.ndarray, measured: Any, unit: float) -> bool:
    """Some step from 1e-3 to 1e-8 units (rad, or the size) gives differences within 1e-7 of the
    largest expected entry.
    """
    largest = float(np.max(np.abs(expected), initial=1e-300))
    return any(
        np.max(np.abs(measured(h * unit) - expected)) < 1e-7 * largest
        for h in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
    )


def step_of(c: Case, k: int) -> float:
    """The unit of steps of actuated joint k: 1 rad, or the size."""
    return 1.0 if c.mechanism.actuated[k].is_angular else c.closure.characteristic_length


class Matrices(NamedTuple):
    """A (m, 6), P (m, p) and B (m, n) at a configuration, rows in lengths, and what makes lengths
    of the rates of their columns; those of P are of passive joints and then of floating links.
    """

    twist: np.ndarray
    passive: np.ndarray
    actuated: np.ndarray
    scales: tuple[np.ndarray, np.ndarray, np.ndarray]


def matrices(case: Case, geometry: np.ndarray | None = None) -> Matrices:
    """A, P and B of a case, with the nominal geometry or another one."""
    equations = velocity_equations(
        case.mechanism, case.mechanism.characteristic_length, bound=False
    )
    # the equations' own symbols: after many other machines the case's are those of an older closure
    closure = equations.closure
    d, size = equations.differential, closure.characteristic_length
    outputs = [ca.densify(part) for part in (d.twist, d.passive, d.actuated)]
    function = ca.Function("velocity", [closure.variables, closure.parameters], outputs)
    found = [
        np.asarray(m.full())
        for m in function(case.values, closure.parameter_values if geometry is None else geometry)
    ]
    joints = (
        [c.lever(size) for c in closure.role(*roles) for _ in range(c.freedom)]
        for roles in (("passive", "body"), ("actuated",))
    )
    scales = (np.repeat([1.0, size], 3), *(np.array(s) for s in joints))
    moves = np.isin(np.arange(6), equations.columns)
    return Matrices(
        d.weights[:, None] * found[0] * moves,
        *(d.weights[:, None] * m for m in found[1:]),
        scales=scales,
    )
