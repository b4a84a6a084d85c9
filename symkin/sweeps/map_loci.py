"""Singular curves of the plane that a sweep's map shows: those that are given, or sought over
it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.model.file import parse
from symkin.model.mechanism import Mechanism
from symkin.position.given_by_name import given_coordinates
from symkin.singularities.configuration import configuration
from symkin.singularities.loci import Loci
from symkin.singularities.singular_loci import singular_loci
from symkin.spatial.pose import Pose
from symkin.sweeps.map_slice import space_of

_SAME = 1e-6
"""Difference over the size, or a whole turn, below which two held values are one."""


def loci_over(
    loci: Loci | bool,
    attributes: Mapping[str, Any],
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
    mechanism, names = parse(attributes["mechanism_file"]), list(ranges)
    if set(names) | set(cuts) < set(attributes["axes"]):
        raise InputError(
            "plot: loci are drawn over the map of a grid; a random sample of more than two "
            "coordinates has no plane"
        )
    space = space_of(attributes)

    def given(point: Sequence[float]) -> dict[str, Any]:
        values = dict(cuts) | dict(zip(names, point, strict=True))
        return space.given([values[axis.name] for axis in space.axes])

    if loci is not True:
        here = list(some) or [low for low, _ in ranges.values()]
        _check_plane(loci, attributes, names, given(here), here)
        return loci
    if not len(some):
        raise InputError(
            "plot: no point of this map has a mode, so that there is nothing to seek singular loci "
            "from"
        )
    told = given(some)
    known = list(told["given"]) if "given" in told else None
    sides = [(low, high) for low, high in ranges.values()]
    return singular_loci(configuration(mechanism, **told), names, given=known, ranges=sides)


def _check_plane(
    loci: Loci,
    attributes: Mapping[str, Any],
    names: Sequence[str],
    here: Mapping[str, Any],
    some: Sequence[float],
) -> None:
    """Raise InputError unless curves are of the map's mechanism, over its coordinates, with the
    same values held.
    """
    mechanism = loci.plane.mechanism
    if mechanism.to_toml() != attributes["mechanism_file"]:
        raise InputError(
            f"plot: the loci are of {mechanism.name} and the map of {attributes['mechanism']}, or "
            f"its geometry is another"
        )
    if set(loci.plane.names) != set(names):
        raise InputError(
            f"plot: the loci are over {', '.join(loci.plane.names)} and the map over "
            f"{', '.join(names)}; one plane is needed"
        )
    place = dict(zip(names, some, strict=True))
    there = loci.given([place[name] for name in loci.plane.names])
    if not _alike(_values(mechanism, here), _values(mechanism, there), mechanism):
        raise InputError(
            f"plot: the loci have other values than the map ({loci.held}); one plane is needed"
        )


def _values(mechanism: Mechanism, given: Mapping[str, Any]) -> dict[str, Any]:
    """What is given, by name."""
    if "joints" in given:
        return dict(zip((c.name for c in mechanism.actuated), given["joints"], strict=True))
    return dict(given["given"]) if "given" in given else {"pose": given["pose"]}


def _alike(a: Mapping[str, Any], b: Mapping[str, Any], mechanism: Mechanism) -> bool:
    """Whether two configurations' given values are the same, angles but for whole turns."""
    if a.keys() != b.keys():
        return False
    turn, size = mechanism.angle_out(2.0 * math.pi), mechanism.characteristic_length
    angles = {name for name, c in given_coordinates(mechanism).items() if c.is_angular}
    for name, value in a.items():
        if isinstance(value, Pose):
            same = _near(value.position, b[name].position, size) and _near(
                value.rotation, b[name].rotation, 1.0
            )
        elif name in angles:
            same = abs(math.remainder(value - b[name], turn)) < _SAME * turn
        else:
            same = _near(value, b[name], size)
        if not same:
            return False
    return True


def _near(a: Any, b: Any, size: float) -> bool:
    return bool(np.abs(np.subtract(a, b)).max() < _SAME * size)
