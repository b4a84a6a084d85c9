"""What the page solves: the closure as JavaScript functions, and the coordinates, limits and start
as numbers for JSON.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from symkin.assembly.group_solvers import most_roots
from symkin.assembly.modes import modes
from symkin.assembly.modes_result import Modes
from symkin.closure.closure import Closure, random_values
from symkin.closure.link_poses import joint_expressions, link_expressions
from symkin.codegen.text.javascript import javascript
from symkin.errors import NoConfigurationError
from symkin.model.joint import Coordinate, units_of
from symkin.model.mechanism import Mechanism
from symkin.numeric.system import components
from symkin.numeric.tolerances import (
    CLOSURE_TOLERANCE,
    DISTINCT_ROOTS,
    LIMIT_SLACK,
    SINGULAR_VALUE,
)
from symkin.page.steps import groups_of, steps_of
from symkin.position.closed_configurations import whole_system
from symkin.position.problem import Problem
from symkin.position.readings import left_out
from symkin.position.solution import Solution
from symkin.position.solve import solve
from symkin.position.solve_result import SolveResult
from symkin.spatial.backend import stacked
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, matrix_from_quaternion, multiply

_MOST_ROOTS = 200
"""Modes, and complex solutions of one step, that the page follows at most."""
_PLACES = 12
"""Other values at which modes are sought beforehand where they are found from random starts; these
are shared among the places, so that many cost no more than one.
"""


@dataclass(frozen=True, eq=False)
class PageModel:
    """`model` is JSON, `generated` the text of a JavaScript module."""

    model: dict[str, Any]
    generated: str


def page_model(
    mechanism: Mechanism,
    given: Mapping[str, float] | None = None,
    wanted: Mapping[str, Any] | None = None,
) -> PageModel:
    """The model of a mechanism whose coordinates `given` have sliders; without them its actuated
    joints, from the example or the reference. It begins in the mode that is nearest to the
    configuration `wanted`, as `Solution.to_dict` tells it. Raises InputError where there is no
    configuration to begin with.
    """
    found = _start(mechanism, given)
    problem, solution = found.problem, found.solution
    assert solution is not None  # noqa: S101 - _start has seen to it
    closure = problem.closure
    links = link_expressions(closure)
    known = tuple(c for c in problem.known_coordinates if c.role != "geometry")
    start = _with_turns(mechanism, closure, solution.variables, known, given or {})
    roots, here = _roots(problem, known, solution)
    if wanted is not None and here:
        known_values = [start[closure.slices[c.name]] for c in known]
        start = np.array(min(here, key=lambda mode: _apart(mode, wanted)).variables, dtype=float)
        for c, values in zip(known, known_values, strict=True):
            start[closure.slices[c.name]] = values
    model = {
        "names": [c.name for c in known],
        "units": {
            c.name: mechanism.unit_of(c)
            for c in (*known, *mechanism.coordinates)
            if not c.is_rotation
        },
        "values": {c.name: _out(mechanism, c, start[closure.slices[c.name].start]) for c in known},
        "limits": {
            c.name: _limits(mechanism, c)
            for c in (*known, *mechanism.coordinates)
            if not c.is_rotation
        },
        "angleUnit": mechanism.angle_unit,
        "size": closure.characteristic_length,
        "links": list(links),
        "coordinates": [
            _coordinate(mechanism, closure, c, known)
            for c in closure.coordinates
            if c.role != "geometry"
        ],
        "tolerances": {
            "closure": CLOSURE_TOLERANCE,
            "singular": SINGULAR_VALUE,
            "same": DISTINCT_ROOTS,
        },
        "width": closure.variables.shape[0],
        "start": start.tolist(),
        "hasPlatform": mechanism.platform_link is not None,
        "readings": _readings(closure),
    }
    model["limited"] = [
        *_limited(model["coordinates"], read=False),
        *_limited(model["readings"], read=True),
    ]
    generated, sizes = _functions(problem, links)
    groups = groups_of(problem)
    follows = roots.pop("listed") <= _MOST_ROOTS and all(
        (most_roots(group) or 0) <= _MOST_ROOTS for group in groups
    )
    columns = np.array(sizes["columns"])
    seeds = np.array(roots.pop("seeds")).reshape(-1, len(columns))
    steps, texts = steps_of(groups if follows else [], solution, seeds, columns)
    sentence = _sentence(roots["complexCount"], steps, follows=follows)
    model |= sizes | roots | {"steps": steps, "follows": follows, "sentence": sentence}
    return PageModel(model, "\n".join([generated, *texts]))


def _sentence(count: int | None, steps: Sequence[Mapping[str, Any]], *, follows: bool) -> str:
    """What the page says of its list of modes, beside paths that are unresolved."""
    if not follows:
        return (
            f"{f'More than {_MOST_ROOTS}' if count is None else count} complex solutions are too "
            f"many to follow here: away from the start the mode shown alone is followed; symkin "
            f"modes finds {'others' if count is None else 'all'}."
        )
    if not steps:
        return ""
    if not all(step["starts"] if step["signs"] is None else step["signs"] for step in steps):
        return (
            "No solution could be followed to other values, which must perhaps agree with each "
            "other: the mode shown alone is followed; symkin modes finds all."
        )
    if count is None:
        return "Solutions that symkin has met are followed; others may be missing."
    return f"{count} complex {'solution is' if count == 1 else 'solutions are'} followed."


# --- start ----------------------------------------------------------------------------------------


def _start(mechanism: Mechanism, given: Mapping[str, float] | None) -> SolveResult:
    """A solution at the values with sliders: those given, else those of the actuated joints; one
    within limits where there is one.
    """
    found = solve(mechanism, given=given or None, check=False)
    if found.solution is None or not found.problem.known_coordinates:
        found = _first_mode(mechanism, given, found)
    if found.solution is not None and found.solution.within_limits is False:
        every = modes(mechanism, given=given or None)
        within = next((mode for mode in every if mode.within_limits), None)
        found = found if within is None else _result(every, within, found)
    if found.problem.gives_pose and not given:
        solution = found.solution
        assert solution is not None  # noqa: S101 - asked for above
        start = None if mechanism.serial else [*solution.position, *solution.quaternion]
        found = solve(mechanism, joints=solution.actuated_values, start=start, check=False)
    return found


def _with_turns(
    mechanism: Mechanism,
    closure: Closure,
    variables: np.ndarray,
    known: Sequence[Coordinate],
    given: Mapping[str, float],
) -> np.ndarray:
    """The variables with given angles as they are given, whole turns too: from there a path or a
    map goes on.
    """
    start = np.array(variables, dtype=float)
    for c in known:
        if c.is_periodic and c.name in given:
            place = closure.slices[c.name].start
            start[place] += (
                2.0
                * np.pi
                * np.round((mechanism.angle_in(given[c.name]) - start[place]) / (2.0 * np.pi))
            )
    return start


def _first_mode(
    mechanism: Mechanism, given: Mapping[str, float] | None, failed: SolveResult
) -> SolveResult:
    every = modes(mechanism, given=given or None)
    if not len(every):
        raise NoConfigurationError(
            f"view: {mechanism.name} has no configuration at these values: {failed.message}"
        )
    return _result(every, every[0], failed)


def _result(every: Modes, mode: Solution, tried: SolveResult) -> SolveResult:
    return SolveResult(every.problem, tried.given, "ok", mode, 0, (), None, tried.method, 0.0)


def _apart(mode: Solution, wanted: Mapping[str, Any]) -> float:
    """How far a mode is from a configuration, in the joints and the position that both tell."""
    pairs = [(value, mode.joints.get(name)) for name, value in wanted["joints"].items()]
    if wanted["pose"] is not None and mode.has_platform:
        pairs += zip(wanted["pose"]["position"], mode.position, strict=True)
    return math.hypot(
        *(a - b for a, b in pairs if isinstance(a, (int, float)) and isinstance(b, (int, float)))
    )


def _roots(
    problem: Problem, known: Sequence[Coordinate], solution: Solution
) -> tuple[dict[str, Any], list[Solution]]:
    """The modes at the start, as variables and as they are, and how many complex solutions there
    are.
    """
    mechanism = problem.mechanism
    names = {c.name: _out(mechanism, c, solution.values[c.name]) for c in known}
    if not names:
        found = modes(mechanism)
    elif problem.of_joints:
        found = modes(mechanism, joints=list(names.values()))
    else:
        found = modes(mechanism, given=names)
    modes_here = [mode for mode in found if mode.partition == solution.partition]
    here = [mode.variables.tolist() for mode in modes_here]
    count = found.complex_count
    elsewhere: list[Modes] = []
    if known:
        # at special values, such as a symmetric reference, solutions meet or are at infinity that
        # others have
        places = 1 if found.starts is None else _PLACES
        elsewhere = _elsewhere(problem, known, names, places, found.starts)
        counts = [mode.complex_count for mode in elsewhere]
        count = None if count is None else max(count, *(each or 0 for each in counts))
    beside = [
        mode.variables.tolist()
        for place in elsewhere
        for mode in place
        if mode.partition == problem.closure.partition
    ]
    roots = {
        "modesHere": here[:_MOST_ROOTS],
        "listed": len(here),
        "seeds": [*here, *beside][:_MOST_ROOTS],
        "complexCount": count,
    }
    return roots, modes_here


def _elsewhere(
    problem: Problem,
    known: Sequence[Coordinate],
    names: Mapping[str, float],
    places: int,
    starts: int | None = None,
) -> list[Modes]:
    """Modes at other values. Where those of the start were found from random `starts`, these are
    shared among all places.
    """
    mechanism, rng = problem.mechanism, np.random.default_rng(5)
    rows = [[_near(mechanism, c, names[c.name], rng) for c in known] for _ in range(places)]
    columns = {c.name: [row[k] for row in rows] for k, c in enumerate(known)}
    given: dict[str, Any] = {"joints": rows} if problem.of_joints else {"given": columns}
    if starts:
        given["starts"] = starts // places
    found: Any = modes(mechanism, **given)
    return list(found)


def _near(mechanism: Mechanism, c: Coordinate, value: float, rng: np.random.Generator) -> float:
    """A random value of a coordinate within its limits, around one that it has."""
    half = c.unit(0.2 * mechanism.characteristic_length)
    low, high = c.limits or (c.least if c.least is not None else -np.inf, np.inf)
    middle = mechanism.value_in(c, value)
    return _out(mechanism, c, float(np.clip(middle + half * rng.uniform(-1.0, 1.0), low, high)))


# --- coordinates ----------------------------------------------------------------------------------


def _out(mechanism: Mechanism, c: Coordinate, value: Any) -> float:
    return float(mechanism.value_out(c, value))


def _limits(mechanism: Mechanism, c: Coordinate) -> list[float] | None:
    low, high = c.limits if c.limits is not None else (c.least, None)
    if low is None:
        return None
    return [_out(mechanism, c, low), None if high is None else _out(mechanism, c, high)]  # type: ignore[list-item]


def _coordinate(
    mechanism: Mechanism, closure: Closure, c: Coordinate, known: Sequence[Coordinate]
) -> dict[str, Any]:
    return {
        **_told(closure, c, closure.slices[c.name].start),
        "known": c in known,
        "actuated": c.role == "actuated",
        "joint": c.name in {other.name for other in mechanism.coordinates},
    }


def _told(closure: Closure, c: Coordinate, place: int) -> dict[str, Any]:
    """A coordinate with its place, and its limits with what rounding may add to them."""
    return {
        "name": c.name,
        "kind": c.kind,
        "place": place,
        "limits": None if c.limits is None else list(c.limits),
        "slack": LIMIT_SLACK * c.unit(closure.characteristic_length),
        "least": c.least,
    }


def _limited(coordinates: Sequence[Mapping[str, Any]], *, read: bool) -> Iterator[dict[str, Any]]:
    """Coordinates that limits hold: of the closure, where those that cannot be negative count too,
    or `read` of joints at which loops are cut.
    """
    for c in coordinates:
        limits = c["limits"] or ([c["least"], None] if c["least"] is not None and not read else [])
        if limits:
            yield {**c, "low": limits[0], "high": limits[1], "read": read}


def _readings(closure: Closure) -> list[dict[str, Any]]:
    """The coordinates that the closure leaves out, with their places among what joints read."""
    left = left_out(closure)
    ends = np.cumsum([c.width for c in left]).tolist()
    return [_told(closure, c, end - c.width) for c, end in zip(left, ends, strict=True)]


# --- functions ------------------------------------------------------------------------------------


def _functions(problem: Problem, links: Mapping[str, Pose]) -> tuple[str, dict[str, Any]]:
    """The rows with their Jacobian, closure errors, links, what joints read, and pose; and sizes
    of rows and columns.
    """
    closure, x = problem.closure, problem.closure.variables
    rows = ca.vertcat(problem.system.rows, whole_system(closure).norms(x))
    columns = _column_scales(closure)
    scales = _row_scales(x, rows, columns, closure)
    rows = rows / ca.DM(scales)
    jacobian = ca.jacobian(rows, x) @ ca.diag(ca.SX(ca.DM(columns)))
    places = [
        ca.reshape(ca.horzcat(matrix_from_quaternion(link.quaternion), link.position).T, 12, 1)
        for link in links.values()
    ]
    joints = joint_expressions(closure, links)
    read = stacked(joints[c.name] for c in left_out(closure))
    pose = closure.bound(ca.densify(ca.vertcat(closure.pose.position, closure.pose.quaternion)))
    texts = [
        javascript("system", x, [rows, jacobian]),
        javascript("errors", x, [problem.system.errors]),
        javascript("links", x, [ca.vertcat(*places)]),
        javascript("readings", x, [read]),
        javascript("pose", x, [pose]),
        javascript("twist", x, [_twist(pose, x) @ ca.diag(ca.SX(ca.DM(columns)))]),
    ]
    sizes = {
        "rows": rows.shape[0],
        "errors": problem.system.errors.shape[0],
        "columns": columns.tolist(),
        "unknown": problem.unknown_places.tolist(),
        "parts": _parts(jacobian[:, problem.unknown_places.tolist()]),
    }
    return "\n".join(texts), sizes


def _parts(jacobian: ca.SX) -> list[dict[str, list[int]]]:
    """The parts of a system that share neither rows nor unknowns, by its Jacobian."""
    entries = np.asarray(ca.DM(jacobian.sparsity(), 1.0)) > 0.0
    rows_of = [set(np.flatnonzero(row).tolist()) for row in entries]
    return [
        {"rows": [r for r, own in enumerate(rows_of) if own & part], "columns": sorted(part)}
        for part in components(rows_of, entries.shape[1])
    ]


def _twist(pose: ca.SX, x: ca.SX) -> ca.SX:
    """Velocity and angular velocity (6, variables) of a pose, position and quaternion, as the
    variables move.
    """
    position, quaternion = pose[:3], pose[3:]
    rates = ca.horzsplit(ca.jacobian(quaternion, x))
    turns = [2.0 * multiply(rate, conjugate(quaternion))[1:] for rate in rates]
    return ca.vertcat(ca.jacobian(position, x), ca.horzcat(*turns))


def _column_scales(closure: Closure) -> np.ndarray:
    """Units of the variables: the size for lengths, 1 for angles and quaternions."""
    return np.array(units_of(closure.coordinates, closure.characteristic_length))


def _row_scales(x: ca.SX, rows: ca.SX, columns: np.ndarray, closure: Closure) -> np.ndarray:
    """Norms of the rows' gradients at a random point, so that all rows count alike."""
    jacobian = ca.Function("gradients", [x], [ca.jacobian(rows, x)])
    point = random_values(
        closure.coordinates, closure.characteristic_length, np.random.default_rng(3)
    )
    norms = np.linalg.norm(np.asarray(jacobian(point)) * columns, axis=1)
    return np.where(norms > 0.0, norms, 1.0)
