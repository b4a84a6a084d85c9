"""Diagnose wrong labels of groups by the inclinations at the nominal geometry.

A configuration may stand in a wrong group, two groups under one label, or the labels have nothing to do with the inclinations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.estimate.configurations import newton_configurations, start_points
from symkin.calibration.estimate.problem import build_calibration
from symkin.calibration.estimate.residuals import wrapped
from symkin.calibration.estimate.starting import with_starts
from symkin.errors import SymkinError
from symkin.model.mechanism import Mechanism
from symkin.text import first_of

_OUTSTANDING_RATIO = 10.0
"""A configuration or a part of a group stands out when it is so many times further away than the others usually are."""
_USUAL_QUANTILE = 0.75
"""Share of the configurations that tells what is usual: errors of the nominal geometry spread them too."""
_MIN_GROUP_SIZE = 3
"""Configurations of a group from which one can be told from the others."""
_COMPARED_NEIGHBOURS, _SCATTER_RATIO = 3, 5.0
"""Labels mean nothing when a configuration is so many times further from its group than from this many others of any label."""


def diagnose_groups(mechanism: Mechanism, measurements: Measurements) -> tuple[str, ...]:
    """Write a sentence on groups that look wrongly labelled, or none."""
    if measurements.groups is None:
        return ()
    try:
        inclination, group = _nominal_inclinations(mechanism, measurements)
    except SymkinError:
        return ()
    numbers, counts = np.unique(group[group >= 0], return_counts=True)
    kept = numbers[counts >= _MIN_GROUP_SIZE]
    if not len(kept):
        return ()
    members = np.flatnonzero(np.isin(group, kept))
    places = np.searchsorted(kept, group[members])
    found = _GroupedInclinations(mechanism, measurements, members, places, inclination[members])
    return found.merged() or found.scattered() or found.misplaced()


class _GroupedInclinations:
    """Configurations `members` (numbers in the measurements) with the places (m,) of their groups and inclinations (m, 2), radians."""

    def __init__(
        self, mechanism: Mechanism, measurements: Measurements, members: np.ndarray, places: np.ndarray, inclination: np.ndarray
    ) -> None:
        self.mechanism, self.labels, self.members, self.places = mechanism, measurements.labels, members, places
        self.inclination = inclination
        self.away = _distances(inclination, np.array([self._middle(k) for k in range(int(places.max()) + 1)])[places])

    def _middle(self, place: int) -> np.ndarray:
        return np.asarray(np.median(self.inclination[self.places == place], axis=0))

    def misplaced(self) -> tuple[str, ...]:
        """Find configurations whose inclination is far from the median of their group."""
        usual = float(np.quantile(self.away, _USUAL_QUANTILE))
        out = np.flatnonzero(self.away > _OUTSTANDING_RATIO * usual)
        if not len(out):
            return ()
        largest = float(np.max(self.away[out]))
        look, group = ("look", "wrong groups") if len(out) > 1 else ("looks", "the wrong group")
        return (
            f"posture {self._named(out)} {look} to be in {group}: at the nominal geometry the inclination is "
            f"{'up to ' if len(out) > 1 else ''}{self._angle(largest)} from the others of the group, where three quarters of the postures "
            f"are within {self._angle(usual)}",
        )

    def merged(self) -> tuple[str, ...]:
        """Find a group that falls into two tight parts far from each other."""
        for place in range(int(self.places.max()) + 1):
            inside = np.flatnonzero(self.places == place)
            parts = _split_at_gap(self.inclination[inside])
            if parts is None:
                continue
            first, second = inside[parts], inside[~parts]
            middles = [np.median(self.inclination[part], axis=0) for part in (first, second)]
            tight = [_distances(self.inclination[part], middle) for part, middle in zip((first, second), middles, strict=True)]
            usual = max(float(np.quantile(np.concatenate([*tight, self.away[self.places != place]]), _USUAL_QUANTILE)), 1e-12)
            gap = float(_distances(middles[0][None], middles[1])[0])
            if gap > _OUTSTANDING_RATIO * usual and max(float(np.max(t)) for t in tight) < 0.5 * gap:
                return (
                    f"the group of posture {self._named(first)} looks to be two groups under one label: at the nominal geometry these are "
                    f"inclined by {self._angle(gap)} against {self._named(second)}, where three quarters of the postures are within "
                    f"{self._angle(usual)} of their group",
                )
        return ()

    def scattered(self) -> tuple[str, ...]:
        """Find labels that do not go with the inclinations, although the inclinations come in groups."""
        count = len(self.members)
        if count <= _COMPARED_NEIGHBOURS:
            return ()
        apart = np.array([np.sort(_distances(self.inclination, row))[_COMPARED_NEIGHBOURS] for row in self.inclination])
        within, near = float(np.median(self.away)), float(np.median(apart))
        if not within > _SCATTER_RATIO * near:
            return ()
        return (
            f"the groups look wrongly labelled: at the nominal geometry half of the postures are more than {self._angle(within)} from the "
            f"inclination of their group, and half have {_COMPARED_NEIGHBOURS} postures of any group within {self._angle(near)}",
        )

    def _named(self, chosen: Sequence[int] | np.ndarray) -> str:
        return first_of([self.labels[self.members[k]] for k in chosen])

    def _angle(self, angle: float) -> str:
        return f"{self.mechanism.angle_out(angle):.3g} {self.mechanism.angle_unit}"


def _split_at_gap(inclination: np.ndarray) -> np.ndarray | None:
    """Tell which configurations (m,) of a group lie on one side of the largest gap along the direction of largest spread, two
    or more on each side; None where there is none."""
    if len(inclination) < 4:
        return None
    around = wrapped(inclination - np.median(inclination, axis=0))
    along = around @ np.linalg.svd(around - around.mean(axis=0), full_matrices=False)[2][0]
    order = np.sort(along)
    cut = 1 + int(np.argmax(np.diff(order)[1:-1]))
    return np.asarray(along <= order[cut])


def _distances(inclination: np.ndarray, middle: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(wrapped(inclination - middle), axis=1))


def _nominal_inclinations(mechanism: Mechanism, measurements: Measurements) -> tuple[np.ndarray, np.ndarray]:
    """Return inclinations (n, 2) at the nominal geometry and groups (n,), -1 for configurations that do not close."""
    problem = build_calibration(mechanism, with_starts(mechanism, measurements))
    model, m = problem.model, problem.measurements
    with np.errstate(all="ignore"):
        z, solved = newton_configurations(model, start_points(model, m), m.joints, model.nominal)
        e = model.evaluate(np.nan_to_num(z), m.joints, model.nominal, problem.quaternions)
    return np.nan_to_num(e.readings)[:, problem.readings.columns], np.where(solved, problem.readings.group, -1)
