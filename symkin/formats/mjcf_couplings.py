"""Joints of MJCF that follow or drive each other: joint equalities, fixed tendons, actuators, and
what is told of these.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from symkin.errors import MechanismError
from symkin.formats.couplings import CouplingSet, LinearEquation
from symkin.formats.mjcf_equalities import Equality
from symkin.formats.mjcf_model import CompiledModel
from symkin.model.graph import Coupling
from symkin.model.motor import Motor, motor_of
from symkin.text import first_of

Terms = list[tuple[int, float]]
"""Joints by number, and the factor of each."""


def couplings_of(
    compiled: CompiledModel,
    equalities: list[Equality],
    held: Mapping[int, float],
    names: Mapping[int, str],
) -> CouplingSet:
    """The couplings of joint and tendon equalities; `held` joints stand at a value, and are no part
    of them.
    """
    found = CouplingSet()
    for equality in equalities:
        if equality.kind == "joint" and equality.objects[1] >= 0:
            first, second = ([(joint, 1.0)] for joint in equality.objects)
        elif equality.kind == "tendon":
            first, second = (_tendon_of(compiled, equality, end) for end in (0, 1))
        else:
            continue
        _Pair(compiled, equality, first, second).couple(found, held, names)
    return found


class _Pair:
    """first - first0 = c0 + c1 d + c2 d^2 + ..., d = second - second0, both from qpos0; sums of
    joints.
    """

    def __init__(
        self, compiled: CompiledModel, equality: Equality, first: Terms, second: Terms
    ) -> None:
        self.equality, self.first, self.second = equality, first, second
        self.coefficients = [float(c) for c in compiled.model.eq_data[equality.number][:5]]
        while len(self.coefficients) > 2 and self.coefficients[-1] == 0.0:
            self.coefficients.pop()
        self.start, self.other = (
            sum(f * compiled.at_qpos0(j) for j, f in terms) for terms in (first, second)
        )

    def couple(
        self, found: CouplingSet, held: Mapping[int, float], names: Mapping[int, str]
    ) -> None:
        moving = [j for j, _ in (*self.first, *self.second) if j not in held]
        if len(self.coefficients) <= 2:
            self._linear(found, held, names)
        elif len(self.first) == len(self.second) == 1 and len(moving) == 2:
            (joint, own), (of, factor) = self.first[0], self.second[0]
            inner = np.polynomial.Polynomial([-self.other, factor])
            polynomial = (np.polynomial.Polynomial(self.coefficients)(inner) + self.start) / own
            powers = [float(c) for c in polynomial.coef]
            coupling = Coupling(names[joint], names[of], polynomial=powers)
            found.add(coupling, self.equality.where)
        else:
            raise MechanismError(
                f"{self.equality.where}: a polynomial of more than one joint, or of a held one, is "
                f"not read; write it linearly"
            )

    def _linear(
        self, found: CouplingSet, held: Mapping[int, float], names: Mapping[int, str]
    ) -> None:
        slope = self.coefficients[1] if self.second else 0.0
        constant = self.coefficients[0] + self.start - slope * self.other
        terms: dict[str, float] = {}
        for j, factor in [*self.first, *((j, -slope * f) for j, f in self.second)]:
            if j in held:
                constant -= factor * held[j]
            else:
                terms[names[j]] = terms.get(names[j], 0.0) + factor
        if any(terms.values()):
            found.add_linear(LinearEquation(terms, constant, self.equality.where))


def _tendon_of(compiled: CompiledModel, equality: Equality, end: int) -> Terms:
    """Joints and factors of one of the two tendons; none where there is no second."""
    number = equality.objects[end]
    if number < 0:
        return []
    found = compiled.tendon(number)
    if found is None:
        raise MechanismError(
            f"{equality.where}: its tendon {compiled.names['tendon'][number]!r} is a spatial one; "
            f"only fixed tendons are read"
        )
    return found


def driven_by(compiled: CompiledModel, actuator: int) -> list[int]:
    """Hinges and slides that an actuator drives, directly or through a fixed tendon."""
    kind, target = (
        compiled.kinds["actuator"][actuator],
        int(compiled.model.actuator_trnid[actuator][0]),
    )
    joints: list[int] = []
    if kind in ("joint", "jointinparent"):
        joints = [target]
    elif kind == "tendon":
        joints = [joint for joint, _ in compiled.tendon(target) or ()]
    return [joint for joint in joints if compiled.joint_type(joint) in ("hinge", "slide")]


def driven(compiled: CompiledModel) -> set[int]:
    """All joints that actuators drive."""
    return {joint for k in range(compiled.model.nu) for joint in driven_by(compiled, k)}


def motor_at(compiled: CompiledModel, joint: int) -> Motor | None:
    """What the file tells of the motors at a hinge or slide: the armature of the joint and of its
    actuators; the forces of these, as far as each has a range, and as far as the joint takes them.
    """
    model = compiled.model
    own = [
        k
        for k in range(model.nu)
        if compiled.kinds["actuator"][k] in ("joint", "jointinparent")
        and int(model.actuator_trnid[k][0]) == joint
    ]
    gears = [float(model.actuator_gear[k][0]) for k in own]
    armature = float(model.dof_armature[model.jnt_dofadr[joint]])
    armature += sum(
        float(model.actuator_armature[k]) * g * g for k, g in zip(own, gears, strict=True)
    )
    low, high = (
        map(float, model.jnt_actfrcrange[joint])
        if model.jnt_actfrclimited[joint]
        else (-np.inf, np.inf)
    )
    ranges = [sorted(g * f for f in _forces(compiled, k)) for k, g in zip(own, gears, strict=True)]
    if ranges:
        low = max(low, sum(first for first, _ in ranges))
        high = min(high, sum(last for _, last in ranges))
    return motor_of((low, high), None, armature)


def _forces(compiled: CompiledModel, actuator: int) -> tuple[float, float]:
    """The range of an actuator's force: its own, and that of its control where the force is a
    multiple of it.
    """
    model, low, high = compiled.model, -np.inf, np.inf
    if model.actuator_forcelimited[actuator]:
        low, high = map(float, model.actuator_forcerange[actuator])
    is_motor = (compiled.kinds["gain"][actuator], compiled.kinds["bias"][actuator]) == (
        "fixed",
        "none",
    )
    if is_motor and model.actuator_ctrllimited[actuator]:
        gain = float(model.actuator_gainprm[actuator][0])
        first, last = sorted(gain * float(c) for c in model.actuator_ctrlrange[actuator])
        low, high = max(low, first), min(high, last)
    return low, high


def without_kinematics(compiled: CompiledModel) -> Iterator[str]:
    """Notes on what of the file moves no link by itself."""
    model = compiled.model
    spatial = sum(compiled.tendon(k) is None for k in range(model.ntendon))
    counts = {
        "spatial tendon": spatial,
        "contact pair": model.npair,
        "flex": model.nflex,
        "sensor": model.nsensor,
    }
    named = [
        f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items() if count
    ]
    if named:
        yield f"left out, since it moves no link by itself: {', '.join(named)}"


def idle_actuators(compiled: CompiledModel) -> Iterator[str]:
    """Notes on actuators that drive no joint, and on a file without any."""
    model = compiled.model
    idle = [
        compiled.names["actuator"][k] or f"number {k + 1}"
        for k in range(model.nu)
        if not driven_by(compiled, k)
    ]
    if idle:
        yield (
            f"actuators that drive no hinge or slide, directly or by a fixed tendon, are left out: "
            f"{first_of(idle)}"
        )
    if not model.nu:
        yield "the file has no actuator: no joint is actuated, and values are given by name"
