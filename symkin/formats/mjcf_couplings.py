"""Joints of MJCF that follow or drive each other: joint equalities, fixed tendons, actuators, and
what is told of these.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from symkin.errors import MechanismError
from symkin.formats.couplings import CouplingSet, LinearEquation
from symkin.formats.mjcf_model import CompiledModel, Record
from symkin.model.graph import Coupling
from symkin.model.motor import Motor, motor_of
from symkin.text import first_of

Terms = list[tuple[int, float]]
"""Joints by number, and the factor of each."""


def couplings_of(
    compiled: CompiledModel,
    equalities: list[Record],
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
        self, compiled: CompiledModel, equality: Record, first: Terms, second: Terms
    ) -> None:
        self.equality, self.first, self.second = equality, first, second
        self.coefficients = list(equality.coefficients)
        while len(self.coefficients) > 2 and self.coefficients[-1] == 0.0:
            self.coefficients.pop()
        self.start, self.other = (
            sum(f * compiled.joints[j].zero for j, f in terms) for terms in (first, second)
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


def _tendon_of(compiled: CompiledModel, equality: Record, end: int) -> Terms:
    """Joints and factors of one of the two tendons; none where there is no second."""
    number = equality.objects[end]
    if number < 0:
        return []
    tendon = compiled.tendons[number]
    if tendon.joints is None:
        raise MechanismError(
            f"{equality.where}: its tendon {tendon.name!r} is a spatial one; only fixed tendons "
            f"are read"
        )
    return [(joint, factor) for joint, factor in tendon.joints]


def motor_at(compiled: CompiledModel, joint: int) -> Motor | None:
    """What the file tells of the motors at a hinge or slide: the armature of the joint and of its
    actuators; the forces of these, as far as each has a range, and as far as the joint takes them.
    """
    own = [a for a in compiled.actuators if a.direct and joint in a.joints]
    armature = compiled.joints[joint].armature + sum(a.armature * a.gear * a.gear for a in own)
    low, high = compiled.joints[joint].force
    ranges = [sorted(a.gear * force for force in a.force) for a in own]
    if ranges:
        low = max(low, sum(first for first, _ in ranges))
        high = min(high, sum(last for _, last in ranges))
    return motor_of((low, high), None, armature)


def without_kinematics(compiled: CompiledModel) -> Iterator[str]:
    """Notes on what of the file moves no link by itself."""
    spatial = sum(tendon.joints is None for tendon in compiled.tendons)
    counts = {"spatial tendon": spatial, **compiled.idle}
    named = [
        f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items() if count
    ]
    if named:
        yield f"left out, since it moves no link by itself: {', '.join(named)}"


def idle_actuators(compiled: CompiledModel) -> Iterator[str]:
    """Notes on actuators that drive no joint, and on a file without any."""
    idle = [
        actuator.name or f"number {k}"
        for k, actuator in enumerate(compiled.actuators, start=1)
        if not actuator.joints
    ]
    if idle:
        yield (
            f"actuators that drive no hinge or slide, directly or by a fixed tendon, are left out: "
            f"{first_of(idle)}"
        )
    if not compiled.actuators:
        yield "the file has no actuator: no joint is actuated, and values are given by name"
