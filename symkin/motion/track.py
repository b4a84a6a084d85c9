"""Staying on one mode along a path of inputs or poses (see `follow` for the steps and their proof)."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

import numpy as np

from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.motion.follow import Branch, Limit, Station, follow, interval_of
from symkin.motion.joint_limits import LimitWatch
from symkin.motion.meeting_modes import meeting_modes
from symkin.motion.path_system import PathSystem, path_system
from symkin.motion.step_certificate import Interval
from symkin.motion.track_result import Sample, Stop, Track
from symkin.motion.trajectory import Trajectory, make_trajectory
from symkin.motion.turning_point import SingularPoint, turning_system
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import SINGULAR, Solution, pose_of
from symkin.position.solve import solve
from symkin.spatial.pose import Pose

_OFF_START = 1e-6
"""A start mode's given values may differ from the path's first sample by this (of the size, or rad)."""

_SINGULAR_START = 1e6
"""Condition of a start from which no step is proved above which it is called singular: double roots are known to 1e-8."""
_AT_START = 1e-6
"""A singular point found at a smaller parameter than this is that of the start."""
_SINGULAR_TEXT = "the start is singular: modes meet there, and which one to follow is not defined"


def track(
    mechanism: Mechanism,
    *,
    joints: Sequence[Sequence[float]] | np.ndarray | None = None,
    poses: Sequence[Sequence[float] | Pose] | np.ndarray | None = None,
    start: Solution | Sequence[float] | Pose | None = None,
    times: Sequence[float] | None = None,
    samples: int | None = None,
    limits: bool = True,
    name_modes: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> Track:
    """Follow one assembly mode along rows of actuated joint values, or one working mode along poses.

    `joints` (n, actuated joints) or `poses` (n, 7) in the mechanism's units; between two rows joint values and positions
    move straight, rotations by the shortest way. `start` is the mode: a solution of `modes` or `solve` at the first row, or
    what `solve` takes as its start. `samples` divides the path further; `limits` stops at joint limits; `times` are kept; `name_modes`
    enumerates all modes before a singular stop, to say which of them meet there.
    The track ends at the path's end or the first stop: a singularity, a limit, loops that open. Raises InputError.
    """
    begin = time.perf_counter()
    trajectory = make_trajectory(mechanism, joints=joints, poses=poses, times=times, count=samples)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return _track(trajectory, start, limits, name_modes, progress, begin)


def _track(
    trajectory: Trajectory, start: Solution | Sequence[float] | Pose | None, limits: bool,
    name_modes: bool, progress: Callable[[int, int], None] | None, begin: float,
) -> Track:  # fmt: skip
    problem = build_problem(trajectory.mechanism, trajectory.kind)
    _check_isolated(problem)
    system = path_system(problem)
    mode, failure = _start_mode(trajectory, start)
    if mode is None:
        stop = Stop("no start", 0, 0.0, None, failure)
        return Track(trajectory, system, (), stop, False, None, 0, 0.0, 0.0, time.perf_counter() - begin)
    unknown = np.concatenate([np.atleast_1d(mode.values[c.name]) for c in problem.system.unknowns] or [np.zeros(0)])
    z = unknown / system.scale
    watch = LimitWatch(system, trajectory)
    first = Station(0, np.append(z, 0.0), np.zeros(len(z)), None)
    limit = watch.violated(first) if limits else None
    if mode.condition >= SINGULAR or limit is not None:
        branch = Branch([first], "singular" if limit is None else "limit", first, limit=limit)
    else:
        branch = follow(system, trajectory, z, watch if limits else _no_watch, progress)
    return _result(trajectory, system, branch, name_modes, begin)


def _no_watch(*_: object) -> None:
    return None


def _check_isolated(problem: Problem) -> None:
    free = problem.system.freedom - problem.generic_rank
    if free > 0:
        raise InputError(
            f"{problem.mechanism.name}: the {problem.kind} problem leaves {free} of {problem.system.freedom} unknowns free, so "
            "that there is no isolated mode to stay on"
        )


def _start_mode(trajectory: Trajectory, start: Solution | Sequence[float] | Pose | None) -> tuple[Solution | None, str]:
    """The mode at the first sample, or None and why there is none."""
    if isinstance(start, Solution):
        _check_start(trajectory, start)
        return start, ""
    given = {"joints" if trajectory.kind == "direct" else "pose": trajectory.given[0]}
    result = solve(trajectory.mechanism, start=start, check=False, **given)  # type: ignore[arg-type]
    return result.solution, result.message


def _check_start(trajectory: Trajectory, mode: Solution) -> None:
    mechanism = trajectory.mechanism
    if mode.mechanism != mechanism:
        raise InputError(f"start: the solution is one of {mode.mechanism.name}, the path one of {mechanism.name}")
    place = 0
    for c in trajectory.coordinates:
        wanted, own = trajectory.samples[0][place : place + c.width], np.atleast_1d(np.asarray(mode.values[c.name], dtype=float))
        place += c.width
        if c.kind == "quaternion":
            off = min(float(np.max(np.abs(own - wanted))), float(np.max(np.abs(own + wanted))))
        elif c.kind == "angle":
            off = abs(math.remainder(own[0] - wanted[0], 2 * math.pi))
        else:
            off = abs(float(own[0] - wanted[0])) / (1.0 if c.is_angular else mechanism.size)
        if not off <= _OFF_START:
            shown = [mechanism.angle_out(float(v)) if c.is_angular else float(v) for v in (own[0], wanted[0])]
            raise InputError(
                f"start: the solution has {c.name} = {shown[0]:.9g}, the path begins at {shown[1]:.9g}; the start must be a "
                "mode of the path's first sample"
            )


def _result(trajectory: Trajectory, system: PathSystem, branch: Branch, name_modes: bool, begin: float) -> Track:
    last = branch.last or branch.stations[0]
    kept = _samples(trajectory, system, branch)
    stop = _stop(trajectory, system, branch, last, name_modes)
    if stop is not None and stop.place is not None and stop.place.parameter > kept[-1].parameter:
        kept.append(stop.place)
    certified = system.is_square and branch.stations[0].half is not None
    certified = certified and (branch.ending in ("reached", "limit") or branch.joined)
    certified = certified and (stop is None or stop.kind != "singular start")
    return Track(
        trajectory, system, tuple(kept), stop, certified, trajectory.parameter(last.row, last.u), branch.steps,
        branch.tightest, max(s.residual for s in kept), time.perf_counter() - begin,
    )  # fmt: skip


def _samples(trajectory: Trajectory, system: PathSystem, branch: Branch) -> list[Sample]:
    kept: list[Sample] = []
    for index, station in enumerate(branch.stations):
        row, u = (index, 0.0) if index < len(trajectory) - 1 or index == 0 else (index - 1, 1.0)
        kept.append(make_sample(trajectory, system, row, u, station.z, station.half, kept[-1] if kept else None))
    return kept


def make_sample(
    trajectory: Trajectory, system: PathSystem, row: int, u: float, z: np.ndarray, half: np.ndarray | None, before: Sample | None
) -> Sample:
    """One configuration of the path with its checks; its quaternion continues the one before."""
    problem = system.problem
    known, unknown = trajectory.at(row, u), system.unknown(z)
    values = problem.assemble(unknown, known)
    pose = pose_of(problem.closure, values)
    if before is not None and np.dot(pose.quaternion, before.pose.quaternion) < 0.0:
        pose = Pose(pose.position, -np.asarray(pose.quaternion))
    jacobian = problem.system.linearise_one(unknown, known)[1]
    singular = np.linalg.svd(jacobian, compute_uv=False)[: problem.system.freedom] if jacobian.size else np.ones(1)
    smallest = float(singular[-1]) if len(singular) else 1.0
    condition = float(singular[0] / smallest) if smallest > 1e-15 * singular[0] else math.inf
    radius = None if half is None else float(np.max(half[:-1], initial=0.0)) * problem.closure.size
    return Sample(
        problem, trajectory.parameter(row, u), trajectory.time(row, u), values, pose,
        problem.system.residual(unknown, known), condition, smallest, radius,
    )  # fmt: skip


def _stop(trajectory: Trajectory, system: PathSystem, branch: Branch, last: Station, name_modes: bool) -> Stop | None:
    if branch.ending == "reached":
        return None
    if branch.singular is not None and trajectory.parameter(last.row, branch.singular.u) > _AT_START:
        return _singular_stop(trajectory, system, last, branch.singular, name_modes)
    if branch.singular is not None:
        last = branch.stations[0]
    place = make_sample(trajectory, system, last.row, last.u, last.z, last.half, None)
    reasons = {"singular": "singular start", "limit": "limit", "open": "open loops", "unproved": "unproved"}
    kind, text = reasons[branch.ending], _why(branch, trajectory)
    if branch.ending == "unproved" and branch.steps == 0 and place.condition > _SINGULAR_START:
        kind, text = "singular start", _SINGULAR_TEXT
    return Stop(kind, last.row, last.u, place, text, limit=branch.limit)


def _why(branch: Branch, trajectory: Trajectory) -> str:
    unit = trajectory.mechanism.length_unit
    match branch.ending:
        case "singular":
            return _SINGULAR_TEXT
        case "open":
            return f"the loops open: a step further {branch.residual:.3g} {unit} are left; the mechanism cannot take what the path asks"
        case "unproved":
            return "no further step could be proved, and no singular point was located: a singularity is very near"
        case _:
            return _limit_text(branch.limit, trajectory)


def _limit_text(limit: Limit | None, trajectory: Trajectory) -> str:
    if limit is None:
        return ""
    mechanism = trajectory.mechanism
    c = next(c for c in build_problem(mechanism, trajectory.kind).closure.coordinates if c.name == limit.name)
    value = mechanism.angle_out(limit.value) if c.is_angular else limit.value
    return f"{limit.name} meets its limit {value:g} {mechanism.angle_unit if c.is_angular else mechanism.length_unit}"


def _singular_stop(trajectory: Trajectory, system: PathSystem, last: Station, point: SingularPoint, name_modes: bool) -> Stop:
    row, u = last.row, min(point.u, 1.0)
    interval = interval_of(system, trajectory, row)
    place = make_sample(trajectory, system, row, u, point.y[:-1], None, None)
    # backwards along the branch: at a turning point towards the last station, elsewhere by its slope
    along = last.z - point.y[:-1] if point.kind == "turning point" else (last.z - point.y[:-1]) / max(point.u - last.u, 1e-300)
    error = _proved_error(system, interval, point) if point.kind == "turning point" else None
    meeting = meeting_modes(system, trajectory, row, point, along) if name_modes else None
    return Stop(point.kind, row, u, place, "", _type(system.problem, point), meeting, error)


def _type(problem: Problem, point: SingularPoint) -> str:
    """Type 2 (direct problem) or type 1 (inverse problem), or passive where neither platform nor actuated joints move."""
    moving = "pose" if problem.kind == "direct" else "actuated"
    pairs = zip(problem.system.unknowns, problem.system.slices, strict=True)
    parts = [point.null[place] for c, place in pairs if c.role == moving]
    largest = max((float(np.max(np.abs(part))) for part in parts), default=0.0)
    if largest < 1e-6:
        return "passive"
    return "type 2" if problem.kind == "direct" else "type 1"


def _proved_error(system: PathSystem, interval: Interval, point: SingularPoint) -> float | None:
    """Half width in u of a box that is proved to hold exactly one turning point; None where that is not proved."""
    if not system.is_square:
        return None
    v = point.null[:, 0]
    y = np.concatenate([point.y[:-1], v, point.y[-1:]])
    direction = np.concatenate([np.zeros(len(v)), v, [0.0]])
    augmented = Interval(turning_system(system), interval.c)
    half = augmented.point(y, direction, augmented.evaluate(y)[1])
    return None if half is None else float(half[-1])
