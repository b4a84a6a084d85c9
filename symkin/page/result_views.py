"""The page of each result: what `result.view()` shows, by the result's type."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Unpack

from symkin.assembly.modes_result import Modes
from symkin.errors import InputError
from symkin.following.track_result import Track
from symkin.model.mechanism import Mechanism
from symkin.page.options import ViewOptions
from symkin.page.page import PlayedPath
from symkin.page.sweep_plane import view_of_sweep
from symkin.page.view import View, actuated_values, view_mechanism, view_solution
from symkin.position.options import Given
from symkin.position.solution import Solution
from symkin.position.solve_result import SolveResult
from symkin.singularities.loci import Loci
from symkin.sweeps.run import Swept
from symkin.verb_options import takes


@takes(ViewOptions)
def view(result: object, **options: Unpack[ViewOptions]) -> View:
    """Make the page on which a mechanism or a result moves: one HTML text that needs no network.

    `result` is a mechanism, modes (the first one is shown), a solution, a track, which is played,
    loci, whose plane is shown, or a sweep, whose map is. `options` of a mechanism: `joints` (all
    actuated ones) or `given` (any coordinates by name), which get sliders, `path`, the CSV file
    that is played, or `pose`, where it begins; of a sweep: `slices`, where its map is cut, and
    `loci`, whether singular curves lie over it. `.save(file)` writes the page, `.open()` shows it
    in the browser, and a notebook shows it in place. Raises InputError for what has no page.

    >>> import symkin
    >>> page = symkin.view(symkin.load("four_bar"), given={"crank": 60.0})
    >>> page.html.startswith("<!doctype html>")
    True
    """
    taken: tuple[str, ...] = ("slices", "loci") if isinstance(result, Swept) else ()
    if isinstance(result, Mechanism):
        taken = (*Given.__annotations__, "path")
    told: dict[str, Any] = {n: v for n, v in options.items() if v is not None and v is not False}
    wrong = [name for name in told if name not in taken]
    if wrong:
        raise InputError(
            f"view: {', '.join(wrong)} is not what the page of a {type(result).__name__} takes"
        )
    if isinstance(result, Mechanism):
        return view_mechanism(result, **told)
    if isinstance(result, Swept):
        return view_of_sweep(result.folder, **told)
    if isinstance(result, SolveResult) and result.solution is not None:
        return _of_solution(result.solution, result.given)
    if isinstance(result, Modes) and len(result):
        return _of_solution(result[0], result.given)
    if isinstance(result, Solution):
        return _of_solution(result, {})
    if isinstance(result, Track) and result.samples:
        return _of_track(result)
    if isinstance(result, Loci):
        return _of_loci(result)
    if isinstance(result, (Modes, SolveResult, Track)):
        raise InputError(
            "view: there is no configuration to show; the mechanism's own page is "
            "symkin.view(mechanism)"
        )
    raise InputError(
        f"view: a {type(result).__name__} has no page; mechanisms, modes, solutions, tracks, loci "
        f"and sweeps have one"
    )


def _of_solution(solution: Solution, given: Mapping[str, Any]) -> View:
    """Sliders for what was given by name, else for the actuated joints."""
    mechanism = solution.mechanism
    if any(not isinstance(value, (int, float)) for value in given.values()) or not given:
        return view_solution(solution)
    return View(
        mechanism, {name: float(value) for name, value in given.items()}, start=solution.to_dict()
    )


def _of_loci(loci: Loci) -> View:
    """Curves over two given coordinates, or over two of the platform's position: the page goes
    where one points.
    """
    solution, names = loci.solution, list(loci.plane.names)
    actuated = actuated_values(loci.plane.mechanism, solution.joints) or {}
    known = all(name in actuated for name in names) or (
        loci.plane.of_pose and all(name in ("x", "y", "z") for name in names)
    )
    if len(names) != 2 or not known:
        raise InputError(
            f"view: loci over {', '.join(names)} have no page; those over two actuated joints, or "
            f"over two of x, y, z, have one"
        )
    curves = [{"kind": curve.kind, "points": curve.points.tolist()} for curve in loci.curves]
    plane = {
        "names": names,
        "units": list(loci.units),
        "ranges": [list(ends) for ends in loci.ranges],
        "held": loci.held,
        "lociAsked": True,
    }
    return View(
        loci.plane.mechanism, actuated, start=solution.to_dict(), plane=plane | {"curves": curves}
    )


def _of_track(track: Track) -> View:
    mechanism = track.trajectory.mechanism
    known = [c.name for c in track.problem.known_coordinates]
    joints = [sample.joints for sample in track.samples]
    names = (
        known if all(name in joints[0] for name in known) else [c.name for c in mechanism.actuated]
    )
    times = [sample.time for sample in track.samples]
    path = PlayedPath(
        "of the track",
        names,
        _rows(names, joints),
        None if None in times else [float(t or 0.0) for t in times],
    )
    first = track.samples[0]
    pose = {
        "position": list(map(float, first.pose.position)),
        "quaternion": list(map(float, first.pose.quaternion)),
    }
    return View(
        mechanism,
        {name: float(joints[0][name]) for name in names},
        path,
        {"pose": pose, "joints": joints[0]},
    )


def _rows(names: Sequence[str], joints: Sequence[Mapping[str, Any]]) -> list[list[float]]:
    return [[float(values[name]) for name in names] for values in joints]
