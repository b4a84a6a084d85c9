"""What the page solves: the closure as JavaScript functions, and the coordinates, limits and start
as numbers for JSON.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from symkin.assembly.modes import modes
from symkin.assembly.modes_result import Modes
from symkin.closure.closure import Closure, random_values
from symkin.closure.link_frames import LinkFrames, link_frames
from symkin.codegen.text.javascript import javascript
from symkin.errors import NoConfigurationError
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.page.complex_solutions import complex_solutions
from symkin.position.problem import Problem
from symkin.position.solution import Solution
from symkin.position.solve import solve
from symkin.position.solve_result import SolveResult

_MOST_ROOTS = 200
"""Complex solutions that the page follows at most."""
_PLACES = 12
"""Other values at which modes are found beforehand."""
_SAMPLED_PLACES = 2
"""The same where modes are found from random starts, which cost a hundred times as much."""


@dataclass(frozen=True, eq=False)
class PageModel:
    """`model` is JSON, `generated` the text of a JavaScript module."""

    model: dict[str, Any]
    generated: str


def page_model(mechanism: Mechanism, given: Mapping[str, float] | None = None) -> PageModel:
    """The model of a mechanism whose coordinates `given` have sliders; without them its actuated
    joints, from the example or the reference. Raises InputError where there is no configuration to
    begin with.
    """
    found = _start(mechanism, given)
    problem, solution = found.problem, found.solution
    assert solution is not None  # noqa: S101 - _start has seen to it
    closure = problem.closure
    frames = link_frames(closure)
    known = tuple(c for c in problem.known_coordinates if c.role != "geometry")
    start = _with_turns(mechanism, closure, solution.variables, known, given or {})
    model = {
        "names": [c.name for c in known],
        "units": {
            c.name: _unit(mechanism, c)
            for c in (*known, *mechanism.coordinates)
            if c.kind != "quaternion"
        },
        "values": {c.name: _out(mechanism, c, start[closure.slices[c.name].start]) for c in known},
        "limits": {
            c.name: _limits(mechanism, c)
            for c in (*known, *mechanism.coordinates)
            if c.kind != "quaternion"
        },
        "lengthUnit": mechanism.length_unit,
        "angleUnit": mechanism.angle_unit,
        "size": closure.characteristic_length,
        "links": list(frames.frames),
        "coordinates": [
            _coordinate(mechanism, closure, c, known)
            for c in closure.coordinates
            if c.role != "geometry"
        ],
        "width": int(closure.variables.shape[0]),
        "start": start.tolist(),
        "hasPlatform": mechanism.platform_link is not None,
        "bridges": _bridges(frames),
        "readings": _readings(closure, frames),
        **_roots(problem, known, solution),
    }
    generated, sizes = _functions(problem, frames, follows=model["follows"])
    return PageModel(model | sizes, generated)


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
    if found.problem.name == "inverse" and not given:
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
        if c.kind == "angle" and c.name in given:
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


def _roots(problem: Problem, known: Sequence[Coordinate], solution: Solution) -> dict[str, Any]:
    """The modes at the start, as seeds of all complex solutions, and how many of these there
    are.
    """
    mechanism = problem.mechanism
    names = {c.name: _out(mechanism, c, solution.values[c.name]) for c in known}
    if not names:
        found = modes(mechanism)
    elif problem.kind == "direct":
        found = modes(mechanism, joints=list(names.values()))
    else:
        found = modes(mechanism, given=names)
    here = [mode.variables.tolist() for mode in found if mode.partition == solution.partition]
    count = found.complex_count
    if known and count is not None and count <= _MOST_ROOTS:
        # at special values, such as a symmetric reference, solutions meet or are at infinity that
        # others have
        (beside,) = _elsewhere(problem, known, names, 1)
        count = max(count, beside.complex_count or 0)
    follows = (len(here) if count is None else count) <= _MOST_ROOTS
    over_complex = complex_solutions(problem, solution) if follows else ()
    is_whole = not known or not follows or count in (len(here), len(over_complex))
    count_elsewhere = _PLACES if found.starts is None else _SAMPLED_PLACES
    places = [] if is_whole else _elsewhere(problem, known, names, count_elsewhere, found.starts)
    elsewhere = [
        mode.variables.tolist()
        for place in places
        for mode in place
        if mode.partition == problem.closure.partition
    ]
    pairs = [np.column_stack([z.real, z.imag]).ravel().tolist() for z in over_complex]
    return {
        "modesHere": here[:_MOST_ROOTS],
        "complexHere": pairs,
        "seeds": elsewhere[:_MOST_ROOTS],
        "complexCount": count,
        "follows": follows,
        "mostFollowed": _MOST_ROOTS,
    }


def _elsewhere(
    problem: Problem,
    known: Sequence[Coordinate],
    names: Mapping[str, float],
    places: int,
    starts: int | None = None,
) -> list[Modes]:
    """Modes at other values: complex solutions that no loop leads to from those of the start may be
    real there. Where those of the start were found from random `starts`, these are shared among
    all places.
    """
    mechanism, rng = problem.mechanism, np.random.default_rng(5)
    rows = [[_near(mechanism, c, names[c.name], rng) for c in known] for _ in range(places)]
    columns = {c.name: [row[k] for row in rows] for k, c in enumerate(known)}
    given: dict[str, Any] = {"joints": rows} if problem.kind == "direct" else {"given": columns}
    if starts:
        given["starts"] = starts // places
    found: Any = modes(mechanism, **given)
    return list(found)


def _near(mechanism: Mechanism, c: Coordinate, value: float, rng: np.random.Generator) -> float:
    """A random value of a coordinate within its limits, around one that it has."""
    half = 1.0 if c.is_angular else 0.2 * mechanism.characteristic_length
    low, high = c.limits or (c.least if c.least is not None else -np.inf, np.inf)
    middle = mechanism.angle_in(value) if c.is_angular else value
    return _out(mechanism, c, float(np.clip(middle + half * rng.uniform(-1.0, 1.0), low, high)))


# --- coordinates ----------------------------------------------------------------------------------


def _unit(mechanism: Mechanism, c: Coordinate) -> str:
    return mechanism.angle_unit if c.is_angular else mechanism.length_unit


def _out(mechanism: Mechanism, c: Coordinate, value: Any) -> float:
    return float(mechanism.angle_out(value) if c.is_angular else value)


def _limits(mechanism: Mechanism, c: Coordinate) -> list[float] | None:
    low, high = c.limits if c.limits is not None else (c.least, None)
    if low is None:
        return None
    return [_out(mechanism, c, low), None if high is None else _out(mechanism, c, high)]  # type: ignore[list-item]


def _coordinate(
    mechanism: Mechanism, closure: Closure, c: Coordinate, known: Sequence[Coordinate]
) -> dict[str, Any]:
    return {
        "name": c.name,
        "kind": c.kind,
        "place": closure.slices[c.name].start,
        "known": c in known,
        "actuated": c.role == "actuated",
        "joint": c.name in {other.name for other in mechanism.coordinates},
        "limits": None if c.limits is None else list(c.limits),
        "least": c.least,
    }


def _bridges(frames: LinkFrames) -> list[dict[str, Any]]:
    number = {name: k for k, name in enumerate(frames.frames)}
    return [
        {
            "links": [number[link] for link in bridge.links],
            "ends": [number[link] for link in bridge.ends],
            "centres": [centre.tolist() for centre in bridge.centres],
        }
        for bridge in frames.bridges
    ]


def _readings(closure: Closure, frames: LinkFrames) -> list[dict[str, Any]]:
    """The joints whose coordinates the closure leaves out, and the links on both sides."""
    held, number = (
        {c.name for c in closure.coordinates},
        {name: k for k, name in enumerate(frames.frames)},
    )
    found = []
    for joint, links in frames.joints.items():
        if all(c.name in held for c in joint.coordinates):
            continue
        found.append(
            {
                "type": joint.type,
                "links": [number[link] for link in links],
                "point": list(joint.point),
                "axis": list(joint.axis or ()),
                "axis2": list(joint.axis2 or ()),
                "zero": joint.zero,
                "pitch": joint.pitch,
                "coordinates": [
                    {
                        "name": c.name,
                        "kind": c.kind,
                        "limits": None if c.limits is None else list(c.limits),
                    }
                    for c in joint.coordinates
                ],
            }
        )
    return found


# --- functions ------------------------------------------------------------------------------------


def _functions(
    problem: Problem, frames: LinkFrames, *, follows: bool
) -> tuple[str, dict[str, Any]]:
    """The rows with their Jacobian (complex ones too where solutions are followed), closure errors,
    links and pose; and sizes of rows and columns.
    """
    closure, x = problem.closure, problem.closure.variables
    norms = [
        ca.sumsqr(x[closure.slices[c.name]]) - 1.0
        for c in closure.coordinates
        if c.kind == "quaternion"
    ]
    rows = ca.vertcat(problem.system.rows, *norms)
    columns = _column_scales(closure)
    scales = _row_scales(x, rows, columns, closure)
    rows = rows / ca.DM(scales)
    jacobian = ca.jacobian(rows, x) @ ca.diag(ca.SX(ca.DM(columns)))
    geometry = ca.vertcat(ca.SX(0, 1), *(symbol for symbol, _ in frames.geometry.values()))
    numbers = ca.SX(ca.DM([value for _, value in frames.geometry.values()]))
    links = ca.densify(ca.substitute(ca.vertcat(*frames.frames.values()), geometry, numbers))
    pose = closure.bound(ca.densify(ca.vertcat(closure.pose.position, closure.pose.quaternion)))
    texts = [
        javascript("system", x, [rows, jacobian]),
        javascript("errors", x, [problem.system.errors]),
        javascript("links", x, [links]),
        javascript("pose", x, [pose, ca.jacobian(pose, x) @ ca.diag(ca.SX(ca.DM(columns)))]),
    ]
    sizes = {
        "rows": int(rows.shape[0]),
        "errors": int(problem.system.errors.shape[0]),
        "columns": columns.tolist(),
        "complex": follows,
    }
    try:
        texts += (
            [javascript("complexSystem", x, [rows, jacobian], over_complex=True)] if follows else []
        )
    except NotImplementedError:
        sizes["complex"] = False
    return "\n".join(texts), sizes


def _column_scales(closure: Closure) -> np.ndarray:
    """Units of the variables: the size for lengths, 1 for angles and quaternions."""
    scales = np.ones(int(closure.variables.shape[0]))
    for c in closure.coordinates:
        if c.kind == "length":
            scales[closure.slices[c.name]] = closure.characteristic_length
    return scales


def _row_scales(x: ca.SX, rows: ca.SX, columns: np.ndarray, closure: Closure) -> np.ndarray:
    """Norms of the rows' gradients at a random point, so that all rows count alike."""
    jacobian = ca.Function("gradients", [x], [ca.jacobian(rows, x)])
    point = random_values(
        closure.coordinates, closure.characteristic_length, np.random.default_rng(3)
    )
    norms = np.linalg.norm(np.asarray(jacobian(point)) * columns, axis=1)
    return np.where(norms > 0.0, norms, 1.0)
