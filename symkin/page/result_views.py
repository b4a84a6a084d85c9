"""The page of each result: what `result.view()` shows, by the result's type."""

from __future__ import annotations

from typing import Any, Unpack

from symkin.assembly.modes_result import Modes
from symkin.errors import InputError
from symkin.following.track_result import Track
from symkin.model.mechanism import Mechanism
from symkin.page.options import ViewOptions
from symkin.page.played_path import path_of_track
from symkin.page.sweep_plane import view_of_sweep
from symkin.page.view import View, view_mechanism, view_solution
from symkin.position.options import Given
from symkin.position.solution import Solution
from symkin.position.solve_result import SolveResult
from symkin.singularities.loci import Loci
from symkin.sweeps.run import Swept
from symkin.verb import verb


@verb(ViewOptions)
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
        return view_solution(result.solution, result.given)
    if isinstance(result, Modes) and len(result):
        return view_solution(result[0], result.given)
    if isinstance(result, Solution):
        return view_solution(result)
    if isinstance(result, Track) and result.samples:
        path = path_of_track(result, "of the track")
        return view_mechanism(result.trajectory.mechanism, path=path)
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


def _of_loci(loci: Loci) -> View:
    """Curves over two given coordinates, or over two of the platform's position: the page goes
    where one points.
    """
    solution, names = loci.solution, list(loci.plane.names)
    actuated = {c.name for c in loci.plane.mechanism.actuated}
    known = actuated.issuperset(names) or (
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
    return view_solution(solution, plane=plane | {"curves": curves})
