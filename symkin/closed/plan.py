"""Closed forms of serial arms: an ordered list of steps, found by structure and tried on random
configurations.

`plan_of` looks for one. A plan is data: `derivation` puts it into words, `expressions` writes it
for one branch, as CasADi expressions that are evaluated in batches or emitted as C.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import casadi as ca
import numpy as np

from symkin.closed.evaluation import Decision, Evaluation, Motion
from symkin.closed.geometry import EXACT, AxisGeometry
from symkin.closed.rules import Chain, Rules
from symkin.closed.screws import ArmScrews, arm_screws
from symkin.closed.steps import TOOL, Factor, Step
from symkin.computed_once import lru_cache
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import quaternion_from_axis_angle, rotate

_MOST_JOINTS = 6
_TRIALS = 3
"""Random configurations at which each step is tried."""
_FIRM = 1e-6
"""Least strength of a step at random configurations (squares over the size's): below it the step
decides nothing.
"""
_MISFIT = 1e3
"""A step is true of an arm whose axes are off by a tolerance where it misses a joint's value by
less than so many tolerances.
"""
_LEAST_MISFIT = 1e-7
_BRANCHES = {1: ("elbow",), 2: ("shoulder", "elbow"), 3: ("shoulder", "elbow", "forearm")}


@dataclass(frozen=True, eq=False)
class Branch:
    """Joint values (n,) of one branch, as expressions, and of each step the discriminant and the
    strength (see `Decision`).
    """

    joints: ca.SX
    discriminants: ca.SX
    strengths: ca.SX


@dataclass(frozen=True, eq=False)
class Plan:
    """Steps that decide all joints of an arm from its tool pose, one after the other; each named
    branch doubles the solutions.
    """

    arm: ArmScrews
    steps: tuple[Step, ...]

    @property
    def branches(self) -> tuple[str, ...]:
        """Names of the choices, in the order of the steps."""
        return tuple(step.branch for step in self.steps if step.branch is not None)

    @property
    def count(self) -> int:
        """Branches, complex solutions included."""
        return 1 << len(self.branches)

    @property
    def signs(self) -> np.ndarray:
        """Signs (count, choices) of all branches, all 1 first."""
        return np.array(list(product((1.0, -1.0), repeat=len(self.branches)))).reshape(
            self.count, len(self.branches)
        )

    def derivation(self) -> list[str]:
        """The steps in words."""
        ends = (f" ({s.branch}: two solutions)" if s.branch else "" for s in self.steps)
        return [step.reason + end for step, end in zip(self.steps, ends, strict=True)]

    def branch(self, pose: ca.SX, signs: Sequence[ca.SX | float]) -> Branch:
        """One branch at a tool pose (x, y, z, qw, qx, qy, qz; unit quaternion)."""
        at, choices, decisions = Evaluation(self.arm, pose[:3], pose[3:]), iter(signs), []
        for step in self.steps:
            decision = at.decide(step, 1.0 if step.branch is None else next(choices))
            decisions.append(decision)
            at = at.decided(step.joints, decision.motions)
        values = [at.motions[i].value + screw.zero for i, screw in enumerate(self.arm.screws)]
        return Branch(
            ca.vertcat(*values),
            ca.vertcat(*(decision.discriminant for decision in decisions)),
            ca.vertcat(*(decision.strength for decision in decisions)),
        )

    def slopes(self, pose: ca.SX, joints: ca.SX) -> ca.SX:
        """What has the signs of the branch in which joint values (n,) with a tool pose are."""
        at = self.at(pose, joints)
        return ca.vertcat(*(at.slope(step) for step in self.steps if step.branch is not None))

    def at(self, pose: ca.SX, joints: ca.SX) -> Evaluation:
        """The arm at joint values (n,) with their tool pose."""
        return replace(Evaluation(self.arm, pose[:3], pose[3:]), motions=_motions(self.arm, joints))


def _motions(arm: ArmScrews, joints: ca.SX) -> dict[int, Motion]:
    found = {}
    for i, screw in enumerate(arm.screws):
        value = joints[i] - screw.zero
        found[i] = Motion(value) if screw.slides else Motion(value, ca.cos(value), ca.sin(value))
    return found


@lru_cache(maxsize=128)
def plan_of(mechanism: Mechanism, tolerance: float = EXACT) -> Plan | None:
    """The plan of a mechanism's inverse problem, where it is an arm whose axes allow one to within
    `tolerance` (rad, or of the size); None elsewhere.
    """
    arm = arm_screws(mechanism)
    if arm is None or not 1 <= len(arm) <= _MOST_JOINTS:
        return None
    axes = AxisGeometry(arm, tolerance)
    trials = [_Trial.of(arm, seed) for seed in range(_TRIALS)]
    whole = Chain(tuple(Factor(i) for i in range(len(arm))), (Factor(TOOL),))
    misfit = max(_MISFIT * tolerance, _LEAST_MISFIT)
    for steps in _search(Rules(axes), whole, (), trials, misfit):
        return Plan(arm, _with_names(steps))
    return None


def _search(
    rules: Rules, chain: Chain, found: tuple[Step, ...], trials: list[_Trial], misfit: float
) -> Iterator[tuple[Step, ...]]:
    """Sequences of steps that hold at all trials, depth first."""
    if not chain.factors:
        yield found
        return
    for steps in rules.options(chain):
        if all(trial.holds(step, misfit) for step in steps for trial in trials):
            decided = {joint for step in steps for joint in step.joints}
            yield from _search(rules, chain.without(decided), found + steps, trials, misfit)


@dataclass(frozen=True, eq=False)
class _Trial:
    """An arm at a random configuration, all motions known."""

    at: Evaluation

    @staticmethod
    def of(arm: ArmScrews, seed: int) -> _Trial:
        rng = np.random.default_rng(seed)
        values = [
            arm.size * rng.uniform(-0.5, 0.5) if s.slides else rng.uniform(-3.0, 3.0)
            for s in arm.screws
        ]
        pose = forward(arm, np.array(values))
        evaluation = Evaluation(arm, _constants(pose.position), _constants(pose.quaternion))
        zeros = np.array([screw.zero for screw in arm.screws])
        return _Trial(
            replace(evaluation, motions=_motions(arm, _constants(np.array(values) + zeros)))
        )

    def holds(self, step: Step, misfit: float) -> bool:
        """Whether the step decides its joints, and as they are, to within `misfit` (rad, or of the
        size).
        """
        sign = 1.0 if step.branch is None else float(np.sign(float(self.at.slope(step))) or 1.0)
        decision = self.at.decide(step, sign)
        numbers = [decision.strength, decision.discriminant, *(m.value for m in decision.motions)]
        if not all(np.isfinite(float(n)) for n in numbers) or float(decision.strength) < _FIRM:
            return False
        return all(
            self._is_near(joint, m, misfit)
            for joint, m in zip(step.joints, decision.motions, strict=True)
        )

    def _is_near(self, joint: int, found: Motion, misfit: float) -> bool:
        gap = float(found.value - self.at.motions[joint].value)
        if self.at.arm.screws[joint].slides:
            return abs(gap) <= misfit * self.at.arm.size
        return bool(abs(np.angle(np.exp(1j * gap))) <= misfit)


def forward(arm: ArmScrews, values: np.ndarray) -> Pose:
    """The tool pose at joint values less their zeros, as it is described."""
    pose = arm.tool
    for screw, value in zip(reversed(arm.screws), reversed(values.tolist()), strict=True):
        k, point = np.array(screw.axis), np.array(screw.point)
        if screw.slides:
            pose = Pose(value * k, np.array([1.0, 0.0, 0.0, 0.0])) @ pose
        else:
            q = quaternion_from_axis_angle(k, value)
            pose = Pose(point - rotate(q, point), q) @ pose
    return arm.told(pose)


def _constants(numbers: np.ndarray) -> ca.SX:
    return ca.SX(ca.DM(np.asarray(numbers, dtype=float)))


def _with_names(steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """The steps with names of their own for their choices: the wrist's, and shoulder, elbow in the
    order of the joints.
    """
    arm = sorted((s for s in steps if s.branch == "arm"), key=lambda s: s.joints)
    wrists = [s for s in steps if s.branch == "wrist"]
    names = {id(s): name for s, name in zip(arm, _BRANCHES.get(len(arm), ()), strict=False)}
    names |= {id(s): "wrist" if len(wrists) == 1 else f"wrist{i + 1}" for i, s in enumerate(wrists)}
    return tuple(
        s if s.branch is None else replace(s, branch=names.get(id(s), f"joint{s.joints[0] + 1}"))
        for s in steps
    )


__all__ = ["Branch", "Decision", "Plan", "forward", "plan_of"]
