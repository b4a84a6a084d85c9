"""Where iterations begin: the user's start, the default one, and random ones; passive joints near
roughly told values; and how far a start lies from what it led to.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import System, split_blocks
from symkin.position.closed_configurations import whole_system
from symkin.position.given import Given, given_by_name, given_joints, pose_from
from symkin.position.pose_coordinates import pose_coordinates
from symkin.position.problem import Problem, actuated_names, build_problem, pose_names
from symkin.position.solution import Solution
from symkin.spatial.pose import Pose

Start = Mapping[str, Any] | Sequence[float] | Pose | None
_FAR = 0.2
"""A start further from the configuration that it led to than this (of the size, or rad) is
noted.
"""


def begun(mechanism: Mechanism, given: Given, start: Start) -> tuple[Problem, np.ndarray]:
    """The problem of what is given, which holds the coordinates that tell the start, and its
    unknowns there.

    The others are fitted to both, so that the pose or the joints of a mode lead to it; where limbs
    or loops have several branches there, to those nearest to the reference.
    """
    problem = build_problem(mechanism, given.names)
    begin = _start_by_name(problem, start)
    if problem.by_name:
        held = tuple(name for name in begin.names if name not in given.names)
        problem = build_problem(mechanism, given.names, held)
    values = problem.closure.reference.copy()
    forward = problem.forward(given.values)
    if forward is not None:
        pose, _ = pose_coordinates(mechanism, Pose(forward[:3], forward[3:]))
        values[problem.places(problem.closure.role("pose"))] = pose
    elif begin.names:
        named = {c.name: c for c in problem.closure.coordinates}
        values[problem.known_places] = given.values
        values[problem.places(tuple(named[name] for name in begin.names))] = begin.values
        values = fit_passive(problem.closure, values, frozenset((*given.names, *begin.names)))
    return problem, values[problem.unknown_places]


def _start_by_name(problem: Problem, start: Start) -> Given:
    """The start as values of coordinates by name: those of the user, else the example's where they
    are of the kind that the problem takes, else none. Of limbs it is a pose beside joints, and
    joints beside a pose.
    """
    mechanism, example = problem.mechanism, problem.mechanism.example
    if start is None and example is not None and _takes_example(problem):
        start = example.start
    if start is None:
        return Given((), np.zeros(0), {})
    if problem.of_pose:
        return given_joints(mechanism, start, "start")  # type: ignore[arg-type]
    if problem.of_joints:
        return _pose_on_motion(mechanism, start)
    if isinstance(start, Mapping):
        return _read_start(mechanism, start)
    actuated = actuated_names(mechanism)
    direct = {c.name for c in problem.known_coordinates} == set(actuated)
    if isinstance(start, Pose) or (len(start) == 7 and (direct or len(actuated) != 7)):
        return _read_start(mechanism, {"pose": start})
    if len(start) != len(actuated):
        raise InputError(
            f"start: {len(start)} values given; values by name are needed (NAME=VALUE,...), a pose "
            f"of 7 numbers, or the "
            f"{len(actuated)} actuated joints of {mechanism.name}"
        )
    return _read_start(mechanism, dict(zip(actuated, start, strict=True)))


def _pose_on_motion(mechanism: Mechanism, start: Any) -> Given:
    """The pose of a start, which must be one of the platform's motion."""
    told = start["pose"] if isinstance(start, Mapping) and list(start) == ["pose"] else start
    coordinates, off = pose_coordinates(mechanism, pose_from(told, "start"))
    if off > 1e-6 * mechanism.characteristic_length:
        raise InputError(
            f"start: the pose lies off the platform's {mechanism.motion} motion by {off:.3g} "
            f"{mechanism.length_unit}"
        )
    return Given(pose_names(mechanism), coordinates, {})


def _takes_example(problem: Problem) -> bool:
    """Whether the example's start is of the kind that the problem takes."""
    example = problem.mechanism.example
    of_pose = example is not None and example.pose is not None
    return problem.by_name or problem.of_pose == of_pose


def _read_start(mechanism: Mechanism, start: Mapping[str, Any]) -> Given:
    try:
        return given_by_name(mechanism, start)
    except InputError as error:
        raise InputError(f"start: {str(error).removeprefix('given: ')}") from None


def random_starts(
    problem: Problem, system: System, known: np.ndarray, count: int, rng: np.random.Generator
) -> np.ndarray:
    """Starts (count, width): lengths about the reference within 1.5 times the mechanism's reach,
    angles and rotations uniform, screws by two turns and, every second time, across the reach;
    the first start at the reference; within `limits` where there are some.
    """
    closure, reach = problem.closure, reach_at(problem, known)
    points = np.empty((count, system.width))
    for c, place in zip(system.unknowns, system.slices, strict=True):
        reference = closure.reference[closure.slices[c.name]]
        if c.is_rotation:
            q = rng.normal(size=(count, 4))
            points[:, place] = q / np.linalg.norm(q, axis=1, keepdims=True)
        elif c.limits is not None:
            points[:, place] = rng.uniform(*c.limits, (count, 1))
        elif c.is_periodic:
            points[:, place] = rng.uniform(-np.pi, np.pi, (count, 1))
        elif c.is_advancing:
            spans = np.where(
                np.arange(count) % 2, 2 * np.pi, turns_within(problem.mechanism, c, reach)
            )
            points[:, place] = reference + (spans * rng.uniform(-1, 1, count))[:, None]
        else:
            points[:, place] = reference + reach * rng.uniform(-1, 1, (count, 1))
        points[0, place] = reference
    return system.fold(points)


def reach_at(problem: Problem, known: np.ndarray) -> float:
    """How far from the reference lengths are looked for."""
    lengths = [c.is_length for c in problem.known_coordinates for _ in range(c.width)]
    size = problem.closure.characteristic_length
    return 1.5 * float(np.max(np.abs(known[lengths]), initial=size))


def turns_within(mechanism: Mechanism, c: Coordinate, reach: float) -> float:
    """The angle by which a screw advances from one end of the reach to the other; one turn to both
    sides where that is less, and for what is no screw.
    """
    pitch = mechanism.pitches.get(c.name, 0.0)
    return max(2 * np.pi, 4 * np.pi * reach / abs(pitch)) if pitch else 2 * np.pi


# --- what a start has led to ----------------------------------------------------------------------


def start_notes(found: Solution, problem: Problem, start: Any) -> tuple[str, ...]:
    """A note where the start that the user gives is far from what it led to: values by name, else a
    pose of the direct problem, joints in file order of the inverse one.
    """
    mechanism = found.mechanism
    if not isinstance(start, Mapping):
        if problem.by_name:
            return ()
        names = [c.name for c in mechanism.actuated]
        start = {"pose": start} if problem.of_joints else dict(zip(names, start, strict=True))
    far = [
        f"{name} by {mechanism.angle_out(gap):.3g} {mechanism.angle_unit}"
        if angular
        else f"{name} by {gap:.3g} {mechanism.length_unit}"
        for name, gap, angular in _gaps(found, start)
        if gap > _FAR * (1.0 if angular else mechanism.characteristic_length)
    ]
    return (
        (f"the start lies far from the configuration that it led to: {', '.join(far)}",)
        if far
        else ()
    )


def _gaps(found: Solution, start: Mapping[str, Any]) -> Iterator[tuple[str, float, bool]]:
    """How far each value lies from the start's (rad, or length unit), and whether it is an
    angle.
    """
    kinds = {c.name: c for c in found.mechanism.coordinates}
    for name, value in start.items():
        there = found.joints.get(name)
        if isinstance(there, float):
            gap = found.mechanism.value_in(kinds[name], there - float(value))
            angular = kinds[name].is_angular
            yield name, abs(math.remainder(gap, 2 * math.pi) if angular else gap), angular
        elif name == "pose":
            pose = pose_from(value, "start")
            away = np.asarray(pose.position) - found.position
            turn = 2 * math.acos(min(1.0, abs(float(np.dot(pose.quaternion, found.quaternion)))))
            yield "position", float(np.linalg.norm(away)), False
            yield "orientation", turn, True


# --- passive joints near a start ------------------------------------------------------------------


_STARTS = 23
"""Further starts, with random angles, of a limb that the values given do not lead to a closed
loop.
"""
_AS_GOOD = 2.0
"""Branches that leave at most this many times the least closure error are equals; the nearest to
the values given is taken.
"""


def fit_passive(closure: Closure, values: np.ndarray, told: frozenset[str]) -> np.ndarray:
    """Values of all variables, those that are not `told` such that each limb or loop closes as well
    as it can with the others held; of branches that close equally well, the one nearest to
    `values`.
    """
    found = values.copy()
    held = [values[closure.slices[c.name]] for c in closure.coordinates if c.name in told]
    known = np.concatenate(held)
    for part in _parts(closure, told):
        here = np.concatenate([values[closure.slices[c.name]] for c in part.unknowns])
        fitted = _best(part, here, known)
        for name, place in part.places.items():
            found[closure.slices[name]] = fitted[place]
    return found


@lru_cache(maxsize=128)
def _parts(closure: Closure, told: frozenset[str]) -> tuple[System, ...]:
    """The rows of each limb or loop that holds coordinates which are not told: these unknown."""
    held = tuple(c for c in closure.coordinates if c.name in told)
    left = tuple(c for c in closure.coordinates if c.name not in told)
    whole, unknown = whole_system(closure), closure.symbols(left)
    known = closure.symbols(held)
    return split_blocks(replace(whole, unknowns=left, unknown=unknown, known=known)) if left else ()


def _best(part: System, here: np.ndarray, known: np.ndarray) -> np.ndarray:
    near = levenberg_marquardt(part, here[None], known)
    if near.largest_row[0] <= 1e-6 * part.characteristic_length:
        return near.points[0]
    points = np.vstack([near.points, levenberg_marquardt(part, _starts(part, here), known).points])
    errors = np.linalg.norm(part.linearise(points, known)[0], axis=1)
    errors = np.where(np.isfinite(errors), errors, np.inf)
    least = float(errors.min())
    if not np.isfinite(least):
        return here
    good = np.flatnonzero(errors <= _AS_GOOD * least + 1e-6 * part.characteristic_length)
    return points[min(good, key=lambda k: _distance(part, here, points[k]))]


def _starts(part: System, here: np.ndarray) -> np.ndarray:
    """Angles uniform, lengths as they are."""
    rng = np.random.default_rng(0)
    starts = np.tile(here, (_STARTS, 1))
    for c, place in zip(part.unknowns, part.slices, strict=True):
        if c.is_rotation:
            q = rng.normal(size=(_STARTS, 4))
            starts[:, place] = q / np.linalg.norm(q, axis=1, keepdims=True)
        elif c.is_periodic:
            starts[:, place] = rng.uniform(-np.pi, np.pi, (_STARTS, 1))
    return starts


def _distance(part: System, a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference of a coordinate: angles without whole turns (rad), lengths by the size."""
    return max(
        _apart(c, a[place], b[place], part.characteristic_length)
        for c, place in zip(part.unknowns, part.slices, strict=True)
    )


def _apart(c: Coordinate, a: np.ndarray, b: np.ndarray, size: float) -> float:
    if c.is_rotation:
        return 2 * math.acos(min(1.0, abs(float(a @ b))))
    if c.is_periodic:
        return abs(math.remainder(float(a[0] - b[0]), 2 * math.pi))
    return abs(float(a[0] - b[0])) / c.unit(size)
