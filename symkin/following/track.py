"""Staying on one mode along a path of inputs or poses (see `follow` for the steps and their proof)."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from symkin.errors import InputError
from symkin.following.follow import Branch, Place, follow
from symkin.following.formula import evaluate, is_formula
from symkin.following.joint_limits import Limit, LimitWatch
from symkin.following.meeting_modes import meeting_modes
from symkin.following.nearest import nearest_place
from symkin.following.track_result import Sample, Stop, Track, ground
from symkin.following.track_start import check_start
from symkin.following.trajectory import Trajectory, make_trajectory
from symkin.model.mechanism import Mechanism
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import SINGULAR, Solution, pose_of
from symkin.position.solve import solve
from symkin.position.start_notes import start_notes
from symkin.singularities.singularity import classify
from symkin.spatial.pose import Pose

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
    notes: Sequence[str] = (),
    progress: Callable[[int, int], None] | None = None,
) -> Track:
    """Follow one assembly mode along rows of actuated joint values, or one working mode along poses.

    `joints` (n, actuated joints) or `poses` (n, 7) in the mechanism's units; between two rows joint values and positions
    move straight, rotations by the shortest way. `start` is the mode: a solution of `modes` or `solve` at the first row, or
    what `solve` takes as its start. `samples` divides the path further; `limits` stops at joint limits; `times` and `notes` are kept; `name_modes`
    enumerates all modes before a singular stop, to say which of them meet there.
    The track ends at the path's end or the first stop: a singularity, a limit, loops that open. Raises InputError.
    """
    begin = time.perf_counter()
    trajectory = make_trajectory(mechanism, joints=joints, poses=poses, times=times, count=samples)
    trajectory = replace(trajectory, notes=(*notes, *trajectory.notes))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return _track(trajectory, start, limits, name_modes, progress, begin)


def _track(
    trajectory: Trajectory, start: Solution | Sequence[float] | Pose | None, limits: bool,
    name_modes: bool, progress: Callable[[int, int], None] | None, begin: float,
) -> Track:  # fmt: skip
    problem = build_problem(trajectory.mechanism, trajectory.kind)
    _check_isolated(problem)
    mode, failure = _start_mode(trajectory, start)
    if mode is None:
        stop = Stop("no start", 0, 0.0, None, failure)
        return Track(trajectory, problem, (), stop, False, None, 0, 0.0, 0.0, "nothing was followed", time.perf_counter() - begin)
    if start is not None and not isinstance(start, Solution):
        trajectory = replace(trajectory, notes=(*trajectory.notes, *start_notes(mode, trajectory.kind, start)))
    unknown = np.concatenate([np.atleast_1d(mode.values[c.name]) for c in problem.system.unknowns] or [np.zeros(0)])
    watch = LimitWatch(problem, trajectory, off=not limits)
    first = Place(0, 0.0, unknown, None)
    limit = watch.start(problem.join_values(unknown, trajectory.samples[0]))
    if mode.condition >= SINGULAR or limit is not None:
        branch = Branch([first], first, (), "singular" if limit is None else "limit", limit=limit)
    else:
        go = evaluate if is_formula(problem, trajectory) else follow
        branch = go(problem, trajectory, unknown, watch, progress)
    return _result(trajectory, problem, branch, name_modes, begin)


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
        check_start(trajectory, start)
        return start, ""
    given = {"joints" if trajectory.kind == "direct" else "pose": trajectory.given[0]}
    result = solve(trajectory.mechanism, start=start, check=False, **given)  # type: ignore[arg-type]
    return result.solution, result.message


def _result(trajectory: Trajectory, problem: Problem, branch: Branch, name_modes: bool, begin: float) -> Track:
    kept: list[Sample] = []
    for place in branch.places:
        kept.append(make_sample(trajectory, problem, place, kept[-1] if kept else None))
    stop = _stop(trajectory, problem, branch, kept, name_modes)
    if stop is not None and stop.place is not None and stop.place.parameter > kept[-1].parameter:
        kept.append(stop.place)
    near = nearest_place(branch, problem, trajectory)
    certified = branch.proved and (stop is None or stop.kind != "singular start")
    residual = max(s.residual for s in kept)
    return Track(
        trajectory, problem, tuple(kept), stop, certified, branch.followed, branch.steps, branch.tightest, residual,
        ground(branch, certified, residual, trajectory.mechanism.length_unit), time.perf_counter() - begin,
        None if near is None else make_sample(trajectory, problem, near, None),
    )  # fmt: skip


def make_sample(trajectory: Trajectory, problem: Problem, place: Place, before: Sample | None) -> Sample:
    """One configuration of the path with its checks; its quaternion continues the one before."""
    row, u, unknown = place.row, place.u, place.unknown
    known = trajectory.at(row, u)
    values = problem.join_values(unknown, known)
    pose = pose_of(problem.closure, values)
    if before is not None and np.dot(pose.quaternion, before.pose.quaternion) < 0.0:
        pose = Pose(pose.position, -np.asarray(pose.quaternion))
    jacobian = problem.system.linearise_one(unknown, known)[1]
    singular = np.linalg.svd(jacobian, compute_uv=False)[: problem.system.freedom] if jacobian.size else np.ones(1)
    smallest = float(singular[-1]) if len(singular) else 1.0
    condition = float(singular[0] / smallest) if smallest > 1e-15 * singular[0] else math.inf
    return Sample(
        problem, trajectory.parameter(row, u), trajectory.time(row, u), values, pose,
        problem.system.residual(unknown, known), condition, smallest, place.radius,
    )  # fmt: skip


def _stop(trajectory: Trajectory, problem: Problem, branch: Branch, kept: list[Sample], name_modes: bool) -> Stop | None:
    if branch.ending == "reached":
        return None
    last, singular = branch.last, branch.ending == "singular" and bool(branch.stopped)
    if singular and trajectory.parameter(last.row, last.u) > _AT_START:
        return _singular_stop(trajectory, problem, branch, kept, name_modes)
    last = branch.places[0] if singular else last
    place = make_sample(trajectory, problem, last, kept[-1])
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
            left = max(w.stop.residual for w in branch.stopped if w.stop is not None)
            return f"the loops open: a step further {left:.3g} {unit} are left; the mechanism cannot take what the path asks"
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
    how = "lies beyond its limit" if limit.is_passed else "meets its limit"
    text = (
        f"{limit.name} {how} {value:g} {mechanism.angle_unit if c.is_angular else mechanism.length_unit}"
        + " at the start" * limit.is_passed
    )
    turns = round(limit.turns / (2 * math.pi))
    return text + (f", {abs(turns)} whole turn{'s' * (abs(turns) > 1)} apart" if turns else "")


def _singular_stop(trajectory: Trajectory, problem: Problem, branch: Branch, kept: list[Sample], name_modes: bool) -> Stop:
    stops = [w.stop for w in branch.stopped if w.stop is not None]
    points = [s.singular for s in stops if s.singular is not None]
    kind = next((k for k in ("bifurcation", "degenerate") if any(p.kind == k for p in points)), "turning point")
    place = make_sample(trajectory, problem, branch.last, kept[-1])
    errors = [None if s.arrival is None else s.arrival.error for s in stops]
    error = None if None in errors else max(e for e in errors if e is not None)
    meeting = meeting_modes(problem, trajectory, branch) if name_modes else None
    return Stop(
        kind, branch.last.row, branch.last.u, place, "", _type(branch), classify(place.solution).kinds, meeting, error,
        blocks=len(points),
    )  # fmt: skip


def _type(branch: Branch) -> str:
    """Type 2 (direct problem) or type 1 (inverse problem), or passive where neither platform nor actuated joints move."""
    largest = 0.0
    for walk in branch.stopped:
        problem, system = walk.system.problem, walk.system.system
        moving = "pose" if problem.kind == "direct" else "actuated"
        for c, place in zip(system.unknowns, system.slices, strict=True):
            if c.role == moving and walk.stop is not None and walk.stop.singular is not None:
                largest = max(largest, float(np.max(np.abs(walk.stop.singular.null[place]))))
    if largest < 1e-6:
        return "passive"
    return "type 2" if problem.kind == "direct" else "type 1"
