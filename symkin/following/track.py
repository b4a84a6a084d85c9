"""Follow one mode along a path of inputs or poses (see `follow` for the steps and their proof), and
find its place that is nearest to a singularity.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import Unpack

import numpy as np

from symkin.errors import InputError
from symkin.following.block_follower import BlockFollower
from symkin.following.follow import (
    Branch,
    PathPoint,
    evaluate_formula,
    follow,
    ground,
    is_formula,
    joined,
)
from symkin.following.joint_limits import LimitWatch
from symkin.following.machine_path import MachinePath, machine_path
from symkin.following.options import PathOptions, TrackOptions
from symkin.following.sample import Sample, make_sample
from symkin.following.station import Station, interval_of, singular_values_near, station_near
from symkin.following.steps import Step
from symkin.following.stop import Stop, stop_of
from symkin.following.track_result import Track
from symkin.following.trajectory import Trajectory, make_trajectory
from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import SINGULAR_CONDITION
from symkin.position.determination import refuse_unless_determined, what_is_free_at
from symkin.position.given import Joints, Values
from symkin.position.problem import Problem
from symkin.position.solution import Solution
from symkin.position.solve import solve
from symkin.position.starts import start_notes
from symkin.position.transfer import own_closure, variables_elsewhere
from symkin.spatial.pose import Pose
from symkin.verb import verb
from symkin.verb_options import options_of

_OFF_START = 1e-6
"""A start mode's given values may differ from the path's first sample by this (of the size, or
rad).
"""

Start = Solution | Joints | Values | Pose | None


@verb(TrackOptions)
def track(mechanism: Mechanism, **options: Unpack[TrackOptions]) -> Track:
    """Follow one assembly mode along rows of actuated joint values, one working mode along poses,
    or one mode along values by name.

    The mode is a branch of F(z, k(u)) = 0 over the path k(u), z the unknowns. Each step is proved
    by Krawczyk's operator in ball arithmetic: exactly one solution for every input of the step, and
    no singularity (Krawczyk 1969; see `tube`).

    `joints` (n, actuated joints; or by name, rows or columns) or `poses` (n, 7: x, y, z, qw, qx,
    qy, qz) are in the mechanism's units; `given` maps names of coordinates, as many as the
    mobility, to a column of n values, or to one value that stands: joints, passive ones too, x, y,
    z, azimuth, tilt and torsion of the platform, or its whole "pose". Between two rows joint values
    and positions move straight, rotations by the shortest way. `start` is the mode: a solution of
    `modes` or `solve` at the first row, or what `solve` takes as its start.

    `times` (s), one a row, are kept with the samples and must not go back; the path is divided into
    about `samples` samples, at least its rows. `limits` False goes beyond joint limits;
    `name_modes` False leaves out the enumeration of all modes before a singular stop, which says
    which of them meet there. `notes` are sentences that are kept with the result; `progress` is
    called with the intervals that are done and their number.

    The track ends at the path's end or the first stop: a singularity, a limit, loops that open
    (`Track.stop`). Raises InputError for a path, a start or options that do not fit.

        >>> import symkin
        >>> arm = symkin.load("gluon_6l3")
        >>> found = symkin.track(arm, joints=[[0, 0, 0, 0, 0, 0], [10, 20, 30, 0, 0, 0]], samples=3)
        >>> found.reached, len(found.samples), [round(v, 9) for v in found.end.actuated_values]
        (True, 3, [10.0, 20.0, 30.0, 0.0, 0.0, 0.0])
        >>> linkage = symkin.load("four_bar")
        >>> symkin.track(linkage, given={"follower": [0.0, -60.0]}).stop.kind   # a dead point
        'turning point'
    """
    begin = time.perf_counter()
    path = {name: options[name] for name in options_of(PathOptions)}  # type: ignore[literal-required]
    trajectory = make_trajectory(mechanism, **path)
    trajectory = replace(trajectory, notes=(*options["notes"], *trajectory.notes))
    found = _track(trajectory, options)
    return replace(found, elapsed_s=time.perf_counter() - begin)


def _track(trajectory: Trajectory, options: TrackOptions) -> Track:
    mode, notes = _start_mode(trajectory, options["start"])
    if trajectory.problem.by_name:
        refuse_unless_determined(trajectory.problem, mode)
    if mode is None:
        _refuse_free(trajectory.problem, math.inf)
        return _not_begun(trajectory, "; ".join(notes))
    path = machine_path(replace(trajectory, notes=(*trajectory.notes, *notes)))
    problem = path.trajectory.problem
    if problem.by_name and problem is not trajectory.problem:
        refuse_unless_determined(problem)
    begin = path.unknowns(own_closure(mode), mode.variables[None])[0]
    _refuse_free(problem, problem.system.condition(begin, path.trajectory.samples[0]))
    limits, progress = options["limits"], options["progress"]
    branch = branch_from(begin, path.trajectory, limits=limits, progress=progress)
    return _result(path, branch, options["name_modes"])


def branch_from(
    unknown: np.ndarray,
    trajectory: Trajectory,
    *,
    limits: bool,
    progress: Callable[[int, int], None] | None = None,
    known: Sequence[list[Step]] = (),
) -> Branch:
    """Follow the branch through the unknowns at the path's first sample; `known` are proved steps
    of each block on the first interval.
    """
    problem = trajectory.problem
    watch = LimitWatch(problem, trajectory, off=not limits)
    limit = watch.start(problem.join_values(unknown, trajectory.samples[0]))
    if (
        problem.system.condition(unknown, trajectory.samples[0]) >= SINGULAR_CONDITION
        or limit is not None
    ):
        first = PathPoint(0, 0.0, unknown, radius=None)
        return Branch(
            [first], first, (), ending="singular" if limit is None else "limit", limit=limit
        )
    if is_formula(problem):
        return evaluate_formula(problem, trajectory, unknown, watch, progress)
    return follow(problem, trajectory, unknown, watch, progress, known)


# --- the start ------------------------------------------------------------------------------------


def _refuse_free(problem: Problem, condition: float) -> None:
    """Raise InputError where a start of a `condition` is no isolated mode."""
    if (free := what_is_free_at(problem, condition)) is not None:
        raise InputError(f"{free}, so that there is no isolated mode to stay on")


def _start_mode(trajectory: Trajectory, start: Start) -> tuple[Solution | None, tuple[str, ...]]:
    """Find the mode at the first sample and what is to be noted of it; or None and why there is
    none.
    """
    if isinstance(start, Solution):
        _check_start(trajectory, start)
        return start, ()
    result = solve(trajectory.mechanism, start=start, check=False, **trajectory.given[0])
    found, by_name = result.solution, trajectory.problem.by_name
    if found is None:
        return None, (result.message, *(result.notes if by_name else ()))
    if by_name:
        return found, tuple(n for n in result.notes if n not in found.notes)
    return found, () if start is None else start_notes(found, trajectory.problem, start)


def _check_start(trajectory: Trajectory, mode: Solution) -> None:
    """Raise InputError where a start mode is not one of the path's first sample."""
    mechanism, problem = trajectory.mechanism, trajectory.problem
    if mode.mechanism != mechanism:
        raise InputError(
            f"start: the solution is one of {mode.mechanism.name}, the path one of {mechanism.name}"
        )
    values = problem.select_values(
        variables_elsewhere(problem.closure, mode), problem.known_coordinates
    )
    place = 0
    for c in trajectory.coordinates:
        here = slice(place, place + c.width)
        wanted, own, place = trajectory.samples[0][here], values[here], place + c.width
        if c.is_rotation:
            off = min(float(np.max(np.abs(own - wanted))), float(np.max(np.abs(own + wanted))))
        elif c.is_periodic:
            off = abs(math.remainder(own[0] - wanted[0], 2 * math.pi))
        else:
            off = abs(float(own[0] - wanted[0])) / c.unit(mechanism.characteristic_length)
        if not off <= _OFF_START:
            shown = [mechanism.value_out(c, float(v)) for v in (own[0], wanted[0])]
            raise InputError(
                f"start: the solution has {c.name} = {shown[0]:.9g}, the path begins at "
                f"{shown[1]:.9g}; the start must be a "
                "mode of the path's first sample"
            )


# --- the result -----------------------------------------------------------------------------------


def _not_begun(trajectory: Trajectory, failure: str) -> Track:
    return Track(
        trajectory=trajectory,
        problem=trajectory.problem,
        samples=(),
        stop=Stop("no start", row=0, u=0.0, place=None, text=failure),
        certified=False,
        followed_to=None,
        steps=0,
        tightest=0.0,
        residual=0.0,
        ground="nothing was followed",
        elapsed_s=0.0,
    )


def _result(path: MachinePath, branch: Branch, name_modes: bool) -> Track:
    kept: list[Sample] = []
    for place, values in zip(branch.places, path.told(branch.places), strict=True):
        way, before = branch.way(place.row, place.u), kept[-1] if kept else None
        kept.append(make_sample(path, place, before, way, values))
    stop = stop_of(path, branch, kept, name_modes)
    if stop is not None and stop.place is not None and stop.place.parameter > kept[-1].parameter:
        kept.append(stop.place)
    near = nearest_to_singularity(branch, path.trajectory)
    certified = branch.proved and (stop is None or stop.kind != "singular start")
    residual = max(s.residual for s in kept)
    return Track(
        trajectory=path.written,
        problem=path.written.problem,
        samples=tuple(kept),
        stop=stop,
        certified=certified,
        followed_to=branch.followed,
        steps=branch.steps,
        tightest=branch.tightest,
        residual=residual,
        ground=ground(branch, certified, residual, path.written.mechanism.length_unit),
        elapsed_s=0.0,
        nearest=None if near is None else make_sample(path, near, None),
    )


_PLACES, _ROUNDS = 17, 9
"""Places at which an interval that holds the least value is looked at, and how often that is
repeated between the neighbours of the best one: it shrinks to 1e-8 of itself.
"""
_SAME = 1e-9
"""Singular values that differ by less than this share are the same."""


def nearest_to_singularity(branch: Branch, trajectory: Trajectory) -> PathPoint | None:
    """Where the smallest singular value of the blocks' unknowns is least among the ends of steps
    and, at places that grow denser, between the neighbours of the least one; the singular stop
    where there is one, None where no step was needed.
    """
    blocks = [block for block in branch.blocks if block.passed]
    if not blocks:
        return None
    if branch.ending == "singular" and branch.stopped:
        return branch.last
    block = min(blocks, key=lambda b: min(p.sigma for p in b.passed))
    least = min(p.sigma for p in block.passed)
    # where a branch comes back to itself its first place is its last one too, with other neighbours
    equal = [k for k, p in enumerate(block.passed) if p.sigma <= least * (1.0 + _SAME)][:2]
    _, there, u = min((_least_near(block, trajectory, k) for k in equal), key=itemgetter(0))
    parts = (_between(each, trajectory, there.row, u) for each in branch.blocks)
    unknown = joined(trajectory.problem, branch.blocks, parts)
    return PathPoint(there.row, u, unknown, None)


def _least_near(
    block: BlockFollower, trajectory: Trajectory, k: int
) -> tuple[float, Station, float]:
    """The least singular value between the neighbours of the end of a step, this end, and where
    (u) it is."""
    there = block.passed[k]
    last = len(block.passed) - 1
    around = block.passed[max(k - 1, 0)], block.passed[min(k + 1, last)]
    before, after = (p if p.row == there.row else there for p in around)
    interval = interval_of(block.system, trajectory, there.row)
    low, high, best = before.u, after.u, (there.sigma, there.u)
    for _ in range(_ROUNDS if high > low else 0):
        u = np.linspace(low, high, _PLACES)
        y = [
            [*_interpolated(*((before, there) if v <= there.u else (there, after)), v), v]
            for v in u.tolist()
        ]
        sigma = singular_values_near(interval, np.array(y))
        k = int(np.argmin(sigma))
        best = min(best, (float(sigma[k]), float(u[k])))
        low, high = float(u[max(k - 1, 0)]), float(u[min(k + 1, _PLACES - 1)])
    return best[0], there, best[1]


def _between(block: BlockFollower, trajectory: Trajectory, row: int, u: float) -> np.ndarray:
    """z of a block at a place that another one has reached."""
    closed = block.closed_branches.get(row)
    if closed is not None and u > closed.period:
        place, times = closed.folded(u)
        return closed.moved(_between(block, trajectory, row, place), times)
    own = [p for p in block.passed if p.row == row] or block.passed[-1:]
    before = max((p for p in own if p.u <= u), key=lambda p: p.u, default=own[0])
    after = min((p for p in own if p.u >= u), key=lambda p: p.u, default=own[-1])
    guess = _interpolated(before, after, u)
    station = station_near(interval_of(block.system, trajectory, row), row, guess, u)
    return station.z if station.is_regular else guess


def _interpolated(one: Station, two: Station, u: float) -> np.ndarray:
    share = (u - one.u) / (two.u - one.u) if two.u > one.u else 0.0
    return one.z + share * (two.z - one.z)
