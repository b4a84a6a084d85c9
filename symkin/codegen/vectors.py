"""Make test vectors: inputs that generated code reads exactly, and the answers of the Python
solvers to those inputs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.codegen.limb_platform import LimbPlatform
from symkin.codegen.passive_limits import keeps_limits
from symkin.codegen.pose_coordinates import COLUMNS
from symkin.codegen.refused_vectors import infeasible_poses, joints_past
from symkin.codegen.rod_platform import RodPlatform
from symkin.codegen.samples import MORE, Configuration, configurations
from symkin.codegen.serial_arm import NEARLY, SerialArm, closed_misfit
from symkin.codegen.text.c import Real
from symkin.errors import InputError
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.mapped import Mapped
from symkin.numeric.system import System
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import pose_of

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
_PARTS = (1.0, 0.25, 0.0625)
"""Shares of the usual way from home that are tried where limits of passive joints leave few
configurations.
"""
COUNT = 24
JACOBIANS = 4


@dataclass(frozen=True)
class Vectors:
    """Arrays by name: one row a case. `joints` and `guesses` make the direct problem's (or
    inverse's) cases, `poses` its answers (or targets), `bounds` the error allowed of each case
    (length unit, angles times the size). `singular` holds a start at which the matrix is singular,
    if one is known. `infeasible` are poses that the mechanism cannot take, `past` joint values of
    which the joint that is `blamed` is beyond a limit.
    """

    joints: np.ndarray
    guesses: np.ndarray
    poses: np.ndarray
    inverse: np.ndarray
    jacobians: np.ndarray
    bounds: np.ndarray
    home: np.ndarray
    singular: np.ndarray
    infeasible: np.ndarray
    past: np.ndarray
    blamed: tuple[int, ...]

    @property
    def answers(self) -> dict[str, np.ndarray]:
        """Cases and their answers, by the name of their table."""
        names = ("guesses", "joints", "poses", "inverse", "jacobians")
        return {name: getattr(self, name) for name in names}

    @property
    def refused(self) -> dict[str, np.ndarray]:
        """What code refuses, by the name of its table; `doubled`: quaternions of length 2."""
        doubled = self.poses[:1] * [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]
        return {
            "singular": self.singular,
            "infeasible": self.infeasible,
            "past": self.past,
            "doubled": doubled,
        }

    @property
    def places(self) -> dict[str, np.ndarray]:
        """Home, and the pose farthest from the first case's; of arms nothing."""
        if not len(self.home):
            return {}
        away = np.linalg.norm(self.poses[:, :3] - self.poses[0][:3], axis=1)
        return {"home": self.home, "far": self.poses[int(np.argmax(away))]}


_Row = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]
"""Joints, guess, pose, inverse and bound of one case."""
_Found = tuple[list[_Row], list[np.ndarray], np.ndarray, np.ndarray]
"""Cases, Jacobians of the first ones, home, singular start."""


def build_vectors(kind: RodPlatform | LimbPlatform | SerialArm) -> Vectors:
    """The vectors of a mechanism; the same bytes on every machine, because answers are rounded.
    Raises InputError where there is not one case.
    """
    rows, jacobians, home, singular = (
        _serial(kind) if isinstance(kind, SerialArm) else _parallel(kind)
    )
    if not rows:
        where = "home" if isinstance(kind, RodPlatform) else "the reference"
        raise InputError(
            f"{kind.mechanism.name}: no regular configuration was found near {where} to test "
            f"generated code with; check the "
            "geometry by `symkin show`, the joints' limits and the pose of [platform]"
            + ("; --real double has more digits" if kind.real.name == "float" else "")
        )
    joints, guesses, poses, inverse, bounds = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    infeasible = (
        infeasible_poses(kind, _cases(kind, kind.direct))
        if isinstance(kind, LimbPlatform)
        else np.zeros((0, 7))
    )
    zero = 0.0 if isinstance(kind, SerialArm) else kind.zero
    past, blamed = joints_past(kind.mechanism.actuated, joints[0], zero)
    return Vectors(
        infeasible=np.array(
            [tidied(row, _pose_scales(kind.mechanism.characteristic_length)) for row in infeasible]
        ).reshape(-1, 7),
        past=past,
        blamed=tuple(blamed),
        joints=joints,
        guesses=guesses,
        poses=poses,
        inverse=inverse,
        jacobians=np.array(jacobians),
        bounds=bounds,
        home=home,
        singular=singular,
    )


def rounded_to(real: Real, values: Sequence[float] | np.ndarray) -> np.ndarray:
    """Numbers as the generated code reads them."""
    exact = np.asarray(values, dtype=float)
    return exact.astype(np.float32).astype(float) if real.name == "float" else exact


def tidied(values: Sequence[float] | np.ndarray, scales: Sequence[float] | float) -> np.ndarray:
    """Each number rounded to 13 digits of its scale (the size for lengths, 1 for angles and
    quaternions): below every tolerance, above what linear algebra libraries differ by.
    """
    numbers = np.asarray(values, dtype=float)
    digits = [
        13 - int(np.ceil(np.log10(scale)))
        for scale in np.broadcast_to(scales, numbers.shape).ravel()
    ]
    rounded = [round(float(v), d) + 0.0 for v, d in zip(numbers.ravel(), digits, strict=True)]
    return np.array(rounded).reshape(numbers.shape)


def _pose_scales(size: float) -> list[float]:
    return [size] * 3 + [1.0] * 4


def _bound(real: Real, size: float, condition: float, tolerance: float) -> float:
    """Error allowed: what rounding makes of the rows, times the condition, and the tolerance."""
    return float(f"{4 * tolerance + real.epsilon * size * (16 + 4 * min(condition, 1e4)):.2g}")


def _parallel(kind: RodPlatform | LimbPlatform) -> _Found:
    mechanism, real = kind.mechanism, kind.real
    direct, back = (build_problem(mechanism, which) for which in ("direct", "inverse"))
    closure, size = direct.closure, direct.closure.characteristic_length
    home = kind.home_values
    lengths, seven = units_of(mechanism.actuated, size), _pose_scales(size)
    tolerance = real.epsilon * size * (1.0 if real.name == "float" else 1e4)
    cases = _cases(kind, direct)
    rows: list[_Row] = []
    jacobians: list[np.ndarray] = []
    for number, case in enumerate(cases):
        given = rounded_to(real, tidied(case.known - kind.zero, lengths))
        z = direct.system.polish(case.unknown, given + kind.zero, 6)
        pose = pose_of(closure, direct.join_values(z, given + kind.zero))
        # every other case starts next to the answer, as a servo loop does; the others from home
        warm = _shifted(direct, case, 2e-4) if number % 2 else home
        guess = rounded_to(real, tidied(kind.stated(pose_of(closure, warm)), seven))
        target = tidied(kind.stated(pose), seven)
        values = direct.join_values(z, given + kind.zero)
        inverse = tidied(kind.inverse_at(rounded_to(real, target), values), lengths)
        # of joints found for a pose, too
        condition = max(
            problem.system.condition(values[problem.unknown_places], values[problem.known_places])
            for problem in (direct, back)
        )
        bound = _bound(real, size, condition, tolerance)
        rows.append((given, guess, target, inverse, bound))
        if number < JACOBIANS:
            own = rates(closure, values)
            told = kind.told_rates(own) if isinstance(kind, LimbPlatform) else own
            jacobians.append(tidied(told, size).ravel())
    here = rounded_to(real, tidied(kind.stated(pose_of(closure, home)), seven))
    return rows, jacobians, here, kind.singular_starts


def _cases(kind: RodPlatform | LimbPlatform, direct: Problem) -> list[Configuration]:
    """Configurations about home; where joints that are not actuated have limits, within these, and
    nearer ones if they are few.
    """
    limits = [] if isinstance(kind, RodPlatform) else kind.passive_limits
    found: list[Configuration] = []
    for part in _PARTS:
        cases = configurations(
            direct, kind.home_values, COUNT, 20, spread=0.06 * part, turn=0.15 * part
        )
        found += [case for case in cases if keeps_limits(limits, direct.closure, case.values)]
        if not limits or len(found) >= COUNT:
            break
    return found[:COUNT]


def _shifted(direct: Problem, case: Configuration, part: float) -> np.ndarray:
    """A configuration near a case: joints moved by a part of the size."""
    size = direct.closure.characteristic_length
    known = case.known + part * np.array(units_of(direct.known_coordinates, size))
    return direct.join_values(direct.system.polish(case.unknown, known, 6), known)


def rates(closure: Closure, values: np.ndarray) -> np.ndarray:
    """Actuated joint rates by the twist (velocity; angular velocity), N x 6, from the closure's
    differential.
    """
    inverse = build_problem(closure.mechanism, "inverse")
    unknown, known = (
        inverse.select_values(values, inverse.system.unknowns),
        inverse.select_values(values, inverse.known_coordinates),
    )
    _, by_joints = inverse.system.linearise_one(unknown, known)
    pose = inverse.system.exchanged(inverse.known_coordinates)
    _, by_pose = pose.linearise_one(known, unknown)
    solved = np.linalg.lstsq(by_joints, -by_pose, rcond=1e-12)[0]
    columns = COLUMNS[closure.mechanism.motion]
    full = np.zeros((len(closure.mechanism.actuated), 6))
    kept = [k for k, c in enumerate(_each(inverse.system)) if c[0] == "actuated"]
    names = [c[1] for c in _each(inverse.system) if c[0] == "actuated"]
    for row, name in zip(kept, names, strict=True):
        number = [c.name for c in closure.mechanism.actuated].index(name)
        angular = closure.mechanism.actuated[number].is_angular
        for j, column in enumerate(columns):
            full[number, column] = (
                solved[row, j]
                * (closure.characteristic_length if column >= 3 else 1.0)
                / (closure.characteristic_length if angular else 1.0)
            )
    return full


def _each(system: System) -> list[tuple[str, str]]:
    return [(c.role, c.name) for c in system.unknowns for _ in range(c.freedom)]


def _decided(arm: SerialArm, branches: Mapped | None) -> list[bool]:
    """For each sample of an arm whether the steps of its closed form decide their joints firmly
    there, as at most samples, and reach the pose as vectors have it. The pose of an arm of fewer
    than six joints is beside those that it can take by rounding, and a joint that is decided weakly
    passes that on.
    """
    if branches is None or len(arm.actuated) >= 6:
        return [True] * len(arm.samples)
    size = arm.mechanism.characteristic_length
    found = branches(np.array([_canonical(pose) for _, pose in arm.samples]))[2][:, :, 0]
    firm = np.all(~(found < _FIRM * np.nanmedian(found, axis=0)), axis=1)
    gaps, rng = [], np.random.default_rng(22)
    for _, pose in arm.samples:
        target = rounded_to(arm.real, tidied(_canonical(pose), _pose_scales(size)))
        # the code's own roundings are as large as those of such poses beside it
        beside = target + arm.real.epsilon * _ROUNDINGS * np.array(
            _pose_scales(size)
        ) * rng.uniform(-1, 1, (_BESIDE, 7))
        gaps.append(max(_reached(arm, branches, near) for near in (target, *beside)))
    return (firm & (np.array(gaps) < _REACHED * closed_misfit(arm.real, size))).tolist()  # type: ignore[no-any-return]


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


def _serial(arm: SerialArm) -> _Found:
    real, size = arm.real, arm.mechanism.characteristic_length
    system = arm.inverse.system
    tolerance = real.epsilon * size * (1.0 if real.name == "float" else 1e4)
    scales = units_of(arm.actuated, size)
    rows: list[_Row] = []
    jacobians: list[np.ndarray] = []
    branches = _branches(arm)
    lines = _lines(arm, branches)
    while lines and len(rows) < COUNT:
        # some lines more than are lacking, since not all are followed
        tried, lines = lines[: COUNT - len(rows) + MORE], lines[COUNT - len(rows) + MORE :]
        ends, whole = _all_followed(arm, tried, branches)
        for line, end, is_whole in zip(tried, ends, whole, strict=True):
            given = line.joints
            if len(rows) == COUNT or not is_whole:
                continue
            if not arm.is_redundant and np.max(np.abs(end - given) / _scales(arm)) > 1e-6:
                continue
            inverse = end if arm.is_redundant else system.polish(given, line.target, 6)
            bound = _bound(real, size, line.condition, tolerance)
            pose = tidied(_canonical(arm.forward_at(given)), _pose_scales(size))
            rows.append((given, line.guess, pose, tidied(inverse, scales), bound))
            if len(jacobians) < JACOBIANS:
                jacobians.append(tidied(arm.jacobian_at(given), size).ravel())
    zero = np.array([c.reference[0] for c in arm.actuated])
    singular = np.linalg.svd(
        arm.kernel.matrix(zero, arm.forward_at(zero), arm.geometry.values), compute_uv=False
    )
    within = all(
        c.limits is None or c.limits[0] <= v <= c.limits[1]
        for c, v in zip(arm.actuated, zero.tolist(), strict=True)
    )
    # beyond a limit, or with more joints than the pose needs, such a start is refused for other
    # reasons
    is_told = singular[-1] < 1e-14 * singular[0] and within and not arm.is_redundant
    starts = zero[None] if is_told else np.zeros((0, len(zero)))
    return rows, jacobians, np.zeros(0), starts


class _Line(NamedTuple):
    """Joints of an arm, a guess beside them, their pose as generated code reads it, with a unit
    quaternion, and the condition there.
    """

    joints: np.ndarray
    guess: np.ndarray
    target: np.ndarray
    condition: float


def _lines(arm: SerialArm, branches: Mapped | None) -> list[_Line]:
    """Lines to the samples at which an arm is regular and its closed form decides firmly."""
    real, size, rng = arm.real, arm.mechanism.characteristic_length, np.random.default_rng(21)
    units = np.array(units_of(arm.actuated, size))
    joints = [rounded_to(real, q) for q, _ in arm.samples]
    poses = [tidied(_canonical(arm.forward_at(q)), _pose_scales(size)) for q in joints]
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
            found.append(_Line(given, guess, unit, condition))
    return found


def _within(joints: np.ndarray, coordinates: Sequence[Coordinate]) -> np.ndarray:
    """The nearest joint values (joints,) or (n, joints) that are clearly within the limits."""
    ranges = np.array([c.limits or (-np.inf, np.inf) for c in coordinates])
    finite = np.isfinite(ranges[:, 1])
    aside = np.where(finite, _ASIDE * (ranges[:, 1] - np.where(finite, ranges[:, 0], 0.0)), 0.0)
    return np.asarray(np.clip(joints, ranges[:, 0] + aside, ranges[:, 1] - aside))


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
    return np.asarray(np.where(np.isfinite(gaps[every, nearest]), told, 0.0))


def _all_followed(
    arm: SerialArm, lines: Sequence[_Line], branches: Mapped | None
) -> tuple[np.ndarray, np.ndarray]:
    """The joints (n, joints) after the lines of poses from the guesses' to the targets, in small
    steps, and which lines (n,) are followed: no step is long, leaves limits, or is too near to
    another branch for a closed form's check of lines.
    """
    least = NEARLY if arm.plan is not None and arm.plan[1] else _CLEAR * arm.real.epsilon
    ends, targets = np.array([line.guess for line in lines]), np.array([v.target for v in lines])
    starts = np.array([arm.forward_at(guess) for guess in ends])
    starts[:, 3:] *= np.where(np.sum(starts[:, 3:] * targets[:, 3:], axis=1) > 0, 1.0, -1.0)[
        :, None
    ]
    going = np.arange(len(lines))
    for k in range(1, 41):
        poses = starts[going] + k / 40 * (targets[going] - starts[going])
        poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
        moved = arm.inverse.system.polish_many(ends[going], poses, 6).points
        fine = np.max(np.abs(moved - ends[going]) / _scales(arm), axis=1) <= 0.1
        fine &= np.all(moved == _within(moved, arm.actuated), axis=1)
        if branches is not None:
            fine &= _least_squares(branches, moved, poses) > least
        going = going[fine]
        ends[going] = moved[fine]
        if not going.size:
            break
    whole = np.zeros(len(lines), dtype=bool)
    whole[going] = True
    return ends, whole


def _canonical(pose: np.ndarray) -> np.ndarray:
    q = pose[3:] / np.linalg.norm(pose[3:])
    return np.concatenate([pose[:3], q if q[0] >= 0 else -q])
