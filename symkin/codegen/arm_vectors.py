"""Find lines of an arm's tool poses that generated code must follow: guesses beside joint values at
which the arm is regular and its closed form, where it has one, decides firmly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import casadi as ca
import numpy as np

from symkin.codegen.serial_arm import NEARLY, SerialArm, closed_misfit, poses_between
from symkin.codegen.steps.samples import MORE, followed, pose_scales, rounded_to, tidied_pose
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.mapped import Mapped
from symkin.numeric.newton import Polished

_FIRM = 0.3
"""Least strength of the steps of a closed form at a vector's pose, over the usual one."""
_REACHED = 0.5
"""Share of the misfit of a closed form that rounding of a vector's pose may take: near a fold half
of the digits are lost.
"""
_ROUNDINGS, _BESIDE = 2.0, 6
"""Roundings of a pose beside a vector's, and how many such poses are tried."""
_CLEAR = 4096.0
"""Least square by which steps of a closed form decide on the line to a vector, in roundings: code
refuses lines that may come below
256. Of an arm whose axes are off by NEARLY it is as much as these.
"""
_ASIDE = 1e-3
"""Distance of vectors from limits, as a share of the range: code refuses what is too near to one to
be decided.
"""
_AWAY, _AWAY_SHARE = 0.1, 0.5
"""Distance of guesses from answers (rad; slides over a tenth of the size): at most this, and this
share of the root of the least square by which the answer's steps decide, which is about how far the
nearest singularity is. Longer lines may take code more parts than it has.
"""
_STEPS = 40
_SAME = 1e-6
"""How far, in steps of `_scales`, the end of a followed line may be from the joints of its pose."""


class Line(NamedTuple):
    """Joints of an arm, a guess beside them, their pose as generated code reads it, with a unit
    quaternion, and the condition there.
    """

    joints: np.ndarray
    guess: np.ndarray
    target: np.ndarray
    condition: float


def followed_lines(arm: SerialArm, count: int) -> Iterator[tuple[Line, np.ndarray]]:
    """Lines that are followed to the joints of their pose, of a redundant arm to any, and where
    they end; searched for until there are `count`.
    """
    branches, kept = _branches(arm), 0
    lines = _lines(arm, branches)
    while lines and kept < count:
        # some lines more than are lacking, since not all are followed
        number = count - kept + MORE
        tried, lines = lines[:number], lines[number:]
        ends, whole = _all_followed(arm, tried, branches)
        for line, end, is_whole in zip(tried, ends, whole, strict=True):
            away = np.max(np.abs(end - line.joints) / _scales(arm))
            if is_whole and (arm.is_redundant or away <= _SAME):
                kept += 1
                yield line, end


def singular_joints(arm: SerialArm) -> np.ndarray:
    """Joint values (n, joints) at which the arm is singular: the reference or nothing."""
    zero = np.array([c.reference[0] for c in arm.actuated])
    matrix = arm.kernel.matrix(zero, arm.forward_at(zero), arm.geometry.values)
    singular = np.linalg.svd(matrix, compute_uv=False)
    ranges = [c.limits or (-np.inf, np.inf) for c in arm.actuated]
    within = all(low <= v <= high for (low, high), v in zip(ranges, zero.tolist(), strict=True))
    # beyond a limit, or with more joints than the pose needs, it is refused for other reasons
    is_told = singular[-1] < 1e-14 * singular[0] and within and not arm.is_redundant
    return zero[None][: int(is_told)]


def _lines(arm: SerialArm, branches: Mapped | None) -> list[Line]:
    """Lines to the samples at which an arm is regular and its closed form decides firmly."""
    real, size, rng = arm.real, arm.mechanism.characteristic_length, np.random.default_rng(21)
    units = np.array(units_of(arm.actuated, size))
    joints = [rounded_to(real, q) for q, _ in arm.samples]
    poses = [tidied_pose(canonical(arm.forward_at(q)), size) for q in joints]
    targets = [rounded_to(real, pose) for pose in poses]
    away = np.full(len(joints), _AWAY)
    if branches is not None:
        squares = _least_squares(branches, np.array(joints), np.array(targets))
        away = np.minimum(_AWAY, _AWAY_SHARE * np.sqrt(squares))
    found, firm = [], _decided(arm, branches)
    for k, (given, target) in enumerate(zip(joints, targets, strict=True)):
        moves = away[k] * rng.uniform(-1, 1, len(given)) * _scales(arm)
        guess = rounded_to(
            real, _within(units * np.round((given + moves) / units, 6), arm.actuated)
        )
        condition = arm.inverse.system.condition(given, target)
        if condition <= (60.0 if arm.is_redundant else 300.0) and firm[k]:
            unit = target / np.array([1, 1, 1, *[np.linalg.norm(target[3:])] * 4])
            found.append(Line(given, guess, unit, condition))
    return found


def _decided(arm: SerialArm, branches: Mapped | None) -> list[bool]:
    """For each sample of an arm whether the steps of its closed form decide their joints firmly
    there, as at most samples, and reach the pose as vectors have it. The pose of an arm of fewer
    than six joints is beside those that it can take by rounding, and a joint that is decided weakly
    passes that on.
    """
    if branches is None or len(arm.actuated) >= 6:
        return [True] * len(arm.samples)
    size = arm.mechanism.characteristic_length
    found = branches(np.array([canonical(pose) for _, pose in arm.samples]))[2][:, :, 0]
    firm = np.all(~(found < _FIRM * np.nanmedian(found, axis=0)), axis=1)
    gaps, rng = [], np.random.default_rng(22)
    for _, pose in arm.samples:
        target = rounded_to(arm.real, tidied_pose(canonical(pose), size))
        # the code's own roundings are as large as those of such poses beside it
        beside = target + arm.real.epsilon * _ROUNDINGS * np.array(pose_scales(size)) * rng.uniform(
            -1, 1, (_BESIDE, 7)
        )
        gaps.append(max(_reached(arm, branches, near) for near in (target, *beside)))
    return (firm & (np.array(gaps) < _REACHED * closed_misfit(arm.real, size))).tolist()


def _reached(arm: SerialArm, branches: Mapped, target: np.ndarray) -> float:
    """How far the nearest branch of a closed form is from a pose."""
    ends = branches(target[None])[0][0].T
    size = arm.mechanism.characteristic_length
    return min(
        (_pose_gap(arm.forward_at(q), target, size) for q in ends if np.all(np.isfinite(q))),
        default=np.inf,
    )


def _pose_gap(pose: np.ndarray, target: np.ndarray, size: float) -> float:
    """Distance of two poses: of their origins, and of two directions times the size, each of which
    may be off by the whole angle.
    """
    turned = min(np.linalg.norm(pose[3:] - sign * target[3:]) for sign in (1.0, -1.0))
    return float(
        np.hypot(np.linalg.norm(pose[:3] - target[:3]), np.sqrt(2.0) * size * 2.0 * turned)
    )


def _within(joints: np.ndarray, coordinates: Sequence[Coordinate]) -> np.ndarray:
    """The nearest joint values (joints,) or (n, joints) that are clearly within the limits."""
    ranges = np.array([c.limits or (-np.inf, np.inf) for c in coordinates])
    finite = np.isfinite(ranges[:, 1])
    aside = np.where(finite, _ASIDE * (ranges[:, 1] - np.where(finite, ranges[:, 0], 0.0)), 0.0)
    return np.clip(joints, ranges[:, 0] + aside, ranges[:, 1] - aside)


def _scales(arm: SerialArm) -> np.ndarray:
    return np.array(units_of(arm.actuated, 0.1 * arm.mechanism.characteristic_length))


def _branches(arm: SerialArm) -> Mapped | None:
    """At a pose the joint values of all branches of the closed form, a column each; the least
    square by which a step of each decides; the strengths of the first one's steps. None without a
    closed form.
    """
    if arm.plan is None:
        return None
    plan, _ = arm.plan
    symbol = ca.SX.sym("pose", 7)
    made = [plan.branch(symbol, signs) for signs in plan.signs.tolist()]
    least = [ca.mmin(ca.vertcat(branch.strengths, branch.discriminants)) for branch in made]
    outputs = [
        ca.horzcat(*(branch.joints for branch in made)),
        ca.horzcat(*least),
        made[0].strengths,
    ]
    return Mapped.of([symbol], outputs)


def _least_squares(branches: Mapped, joints: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """The least square (n,) by which a step of the branch decides that joints (n, joints) are of; 0
    where there is none.
    """
    found, squares, _ = branches(poses)
    gaps = np.abs(np.angle(np.exp(1j * (found - joints[:, :, None])))).max(axis=1)
    gaps = np.where(np.isfinite(gaps), gaps, np.inf)
    every, nearest = np.arange(len(joints)), np.argmin(gaps, axis=1)
    told = np.maximum(squares[every, 0, nearest], 0.0)
    return np.where(np.isfinite(gaps[every, nearest]), told, 0.0)


def _all_followed(
    arm: SerialArm, lines: Sequence[Line], branches: Mapped | None
) -> tuple[np.ndarray, np.ndarray]:
    """The joints (n, joints) after the lines of poses from the guesses' to the targets, in small
    steps, and which lines (n,) are followed: no step is long, leaves limits, or is too near to
    another branch for a closed form's check of lines.
    """
    least = NEARLY if arm.plan is not None and arm.plan[1] else _CLEAR * arm.real.epsilon
    guesses, targets = (
        np.array(part) for part in zip(*((v.guess, v.target) for v in lines), strict=True)
    )
    starts = np.array([arm.forward_at(guess) for guess in guesses])

    def kept(_: np.ndarray, before: np.ndarray, found: Polished, poses: np.ndarray) -> np.ndarray:
        moved = found.points
        fine = np.max(np.abs(moved - before) / _scales(arm), axis=1) <= 0.1
        fine &= np.all(moved == _within(moved, arm.actuated), axis=1)
        if branches is not None:
            fine &= _least_squares(branches, moved, poses) > least
        return fine

    return followed(
        arm.inverse.system, guesses, partial(poses_between, starts, targets), _STEPS, kept
    )


def canonical(pose: np.ndarray) -> np.ndarray:
    q = pose[3:] / np.linalg.norm(pose[3:])
    return np.concatenate([pose[:3], q if q[0] >= 0 else -q])
