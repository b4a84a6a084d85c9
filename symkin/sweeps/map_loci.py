"""Singular curves of the plane that a sweep's map shows: those that are given, or sought over
it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.given import read_given
from symkin.position.problem import build_problem
from symkin.singularities.configuration import configuration
from symkin.singularities.curve import distance
from symkin.singularities.loci import Loci
from symkin.singularities.singular_loci import singular_loci
from symkin.sweeps.map_slice import SweepFolder

_SAME = 1e-6
"""Difference over the size (angles: radians) below which held values are one."""


def loci_over(
    loci: Loci | bool,
    folder: SweepFolder,
    ranges: Mapping[str, tuple[float, float]],
    cuts: Mapping[str, float],
    some: Sequence[float],
) -> Loci | None:
    """The curves for a map over the names of `ranges` of a sweep that is cut at `cuts`: `loci`
    where they have this plane, or with True a search from the point `some`, which has a mode
    (empty: none has). Raises InputError for curves of another mechanism or plane.
    """
    if loci is False:
        return None
    names, space = list(ranges), folder.space
    if set(names) | set(cuts) < set(folder.names):
        raise InputError(
            "plot: loci are drawn over the map of a grid; a random sample of more than two "
            "coordinates has no plane"
        )

    def given(point: Sequence[float]) -> dict[str, Any]:
        values = dict(cuts) | dict(zip(names, point, strict=True))
        return space.given([values[axis.name] for axis in space.axes])

    if loci is not True:
        here = list(some) or [low for low, _ in ranges.values()]
        _check_plane(loci, folder, names, given(here), here)
        return loci
    if not len(some):
        raise InputError(
            "plot: no point of this map has a mode, so that there is nothing to seek singular loci "
            "from"
        )
    told = given(some)
    known = told.get("given") and list(told["given"])
    sides = [(low, high) for low, high in ranges.values()]
    return singular_loci(configuration(folder.mechanism, **told), names, given=known, ranges=sides)


def _check_plane(
    loci: Loci,
    folder: SweepFolder,
    names: Sequence[str],
    here: Mapping[str, Any],
    some: Sequence[float],
) -> None:
    """Raise InputError unless curves are of the map's mechanism, over its coordinates, with the
    same values held.
    """
    mechanism = loci.plane.mechanism
    if mechanism.to_toml() != folder.attributes["mechanism_file"]:
        raise InputError(
            f"plot: the loci are of {mechanism.name} and the map of {folder.mechanism.name}, or "
            f"its geometry is another"
        )
    if set(loci.plane.names) != set(names):
        raise InputError(
            f"plot: the loci are over {', '.join(loci.plane.names)} and the map over "
            f"{', '.join(names)}; one plane is needed"
        )
    place = dict(zip(names, some, strict=True))
    there = loci.given([place[name] for name in loci.plane.names])
    if not _alike(mechanism, here, there):
        raise InputError(
            f"plot: the loci have other values than the map ({loci.held}); one plane is needed"
        )


def _alike(mechanism: Mechanism, here: Mapping[str, Any], there: Mapping[str, Any]) -> bool:
    """Whether what is given of two configurations is the same, angles but for whole turns."""
    own, other = here.get("given"), there.get("given", {})
    if own and own.keys() == other.keys():
        there = {"given": {name: other[name] for name in own}}
    one, two = (read_given(mechanism, **told) for told in (here, there))
    if one.names != two.names:
        return False
    problem = build_problem(mechanism, one.names)
    known = problem.system.exchanged(problem.known_coordinates)
    return distance(known, one.values, two.values) < _SAME * mechanism.characteristic_length
