"""Find what was assigned wrongly: columns to joints, and configurations to groups of equal
inclination.

Where whole poses were measured, each limb of a parallel mechanism has a joint value of its own at
each pose (the inverse problem at the nominal geometry), and the columns are assigned to the limbs
that they fit best, whatever the order. Elsewhere single exchanges and signs are taken one after the
other, each the best, while the readings fit better.

Inclinations at the nominal geometry show configurations in a wrong group, two groups under one
label, and labels that have nothing to do with the inclinations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np

from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.estimate.configurations import (
    first_points,
    joints_at_poses,
    newton_configurations,
    whole_poses,
)
from symkin.calibration.estimate.problem import build_calibration
from symkin.calibration.estimate.starting import with_starts
from symkin.calibration.judge.statistics import rms_of_better_part
from symkin.errors import SymkinError
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.spatial.rotation import wrapped
from symkin.text import first_of

_MAX_ASSIGNED_JOINTS = 7
"""Joints whose orders are all tried (5040); with more only single exchanges are."""
_MIN_WHOLE_POSES = 4
"""Whole poses from which columns are assigned to joints."""
_EXCHANGE_CONFIGURATIONS = 16
"""Configurations by which exchanges one after the other are judged."""
_EXCHANGE_GAIN = 0.9
"""An exchange is taken where the misfit falls below this share."""
_OUTSTANDING_RATIO = 10.0
"""A configuration or a part of a group stands out when it is so many times further away than the
others usually are.
"""
_USUAL_QUANTILE = 0.75
"""Share of the configurations that tells what is usual: errors of the nominal geometry spread them
too.
"""
_MIN_GROUP_SIZE = 3
"""Configurations of a group from which one can be told from the others."""
_COMPARED_NEIGHBOURS, _SCATTER_RATIO = 3, 5.0
"""Labels mean nothing when a configuration is so many times further from its group than from this
many others of any label.
"""


# --- joint columns --------------------------------------------------------------------------------


def best_column_order(
    mechanism: Mechanism, m: Measurements, misfit: Callable[[Measurements], float]
) -> tuple[str, Measurements] | None:
    """A sentence on the order and signs of the joint columns that explain the readings, and the
    readings put right; None where the columns stand as they should, or where too few poses are
    known.
    """
    whole = np.isfinite(whole_poses(m, measured=True)[:, 0])
    if (
        not mechanism.serial
        and np.sum(whole) >= _MIN_WHOLE_POSES
        and len(mechanism.actuated) <= _MAX_ASSIGNED_JOINTS
    ):
        found = _assign_columns(mechanism, m.subset(whole))
    else:
        found = _exchange_one_by_one(mechanism, m, misfit)
    if found is None:
        return None
    order, signs = found
    return _describe_order(mechanism.actuated, order, signs), replace(
        m, joints=signs * m.joints[:, order]
    )


def is_possible(actuated: Sequence[Coordinate], joints: np.ndarray) -> bool:
    """Whether no reading is below the least value of its joint (rods of negative length)."""
    return all(
        c.least is None or bool(np.all(joints[:, k] > c.least)) for k, c in enumerate(actuated)
    )


def like_pairs(mechanism: Mechanism) -> Iterator[tuple[int, int]]:
    """Pairs of joints of one kind."""
    actuated = mechanism.actuated
    return (
        (a, b)
        for a, b in combinations(range(len(actuated)), 2)
        if actuated[a].is_angular == actuated[b].is_angular
    )


def swapped(count: int, a: int, b: int) -> np.ndarray:
    order = np.arange(count)
    order[[a, b]] = b, a
    return order


def sign_change(count: int, k: int) -> np.ndarray:
    return np.where(np.arange(count) == k, -1.0, 1.0)


def _assign_columns(mechanism: Mechanism, m: Measurements) -> tuple[np.ndarray, np.ndarray] | None:
    """For each joint the column that fits its values at the measured poses best, each column once,
    and its sign.
    """
    actuated = mechanism.actuated
    poses = whole_poses(m, measured=True)
    values = joints_at_poses(mechanism, poses[np.isfinite(poses[:, 0])])
    reached = np.all(np.isfinite(values), axis=1)
    if np.sum(reached) < _MIN_WHOLE_POSES:
        return None
    values, read, count = values[reached], m.joints[reached], len(actuated)
    cost, sign = np.full((count, count), np.inf), np.ones((count, count))
    for j, c in enumerate(actuated):
        for k, other in enumerate(actuated):
            if c.is_angular != other.is_angular:
                continue
            for s in (1.0, -1.0):
                found = rms_of_better_part(_joint_gap(s * read[:, k] - values[:, j], c) ** 2) ** 2
                if found < cost[j, k]:
                    cost[j, k], sign[j, k] = found, s
    orders = np.array(list(permutations(range(count))))
    best = orders[int(np.argmin(np.sum(cost[np.arange(count), orders], axis=1)))]
    signs = sign[np.arange(count), best]
    unchanged = np.array_equal(best, np.arange(count)) and np.all(signs > 0)
    return (
        None if unchanged or not is_possible(actuated, signs * m.joints[:, best]) else (best, signs)
    )


def _joint_gap(values: np.ndarray, c: Coordinate) -> np.ndarray:
    return wrapped(values) if c.is_angular else values


def _exchange_one_by_one(
    mechanism: Mechanism, m: Measurements, misfit: Callable[[Measurements], float]
) -> tuple[np.ndarray, np.ndarray] | None:
    """Exchanges of two columns and changes of one sign, the best first, while the misfit falls."""
    count, m = len(mechanism.actuated), m.subset(spread_rows(len(m), _EXCHANGE_CONFIGURATIONS))
    order, signs, least = np.arange(count), np.ones(count), misfit(m)
    for step in range(count):
        swaps = [swapped(count, a, b) for a, b in like_pairs(mechanism)]
        trials = [(order[swap], signs[swap]) for swap in swaps]
        trials += [(order, signs * sign_change(count, k)) for k in range(count)]
        judged = [
            (misfit(replace(m, joints=s * m.joints[:, o])), o, s)
            for o, s in trials
            if is_possible(mechanism.actuated, s * m.joints[:, o])
        ]
        value, o, s = min(judged, key=lambda trial: trial[0], default=(np.inf, order, signs))
        if not value < _EXCHANGE_GAIN * least:
            return None if step < 1 else (order, signs)
        order, signs, least = o, s, value
    return order, signs


def _describe_order(actuated: Sequence[Coordinate], order: np.ndarray, signs: np.ndarray) -> str:
    """'the columns a, b, c look exchanged: they seem to hold b, c, a; the sign of d looks
    reversed'.
    """
    names = [c.name for c in actuated]
    holds = np.argsort(order)  # column order[j] holds joint j
    moved = [k for k in range(len(names)) if holds[k] != k]
    parts = []
    if moved:
        parts.append(
            f"the columns {', '.join(names[k] for k in moved)} look exchanged: they seem to hold "
            f"{', '.join(names[holds[k]] for k in moved)}"
        )
    turned = [names[order[j]] for j in range(len(names)) if signs[j] < 0]
    if turned:
        parts.append(
            f"the sign{'s' * (len(turned) > 1)} of {', '.join(turned)} "
            f"look{'s' * (len(turned) == 1)} reversed"
        )
    return "; ".join(parts)


# --- groups ---------------------------------------------------------------------------------------


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
    """Configurations `members` (numbers in the measurements) with the places (m,) of their groups
    and inclinations (m, 2), radians.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        measurements: Measurements,
        members: np.ndarray,
        places: np.ndarray,
        inclination: np.ndarray,
    ) -> None:
        self.mechanism, self.labels, self.members, self.places = (
            mechanism,
            measurements.labels,
            members,
            places,
        )
        self.inclination = inclination
        self.away = _distances(
            inclination, np.array([self._middle(k) for k in range(int(places.max()) + 1)])[places]
        )

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
            f"posture {self._named(out)} {look} to be in {group}: at the nominal geometry the "
            f"inclination is "
            f"{'up to ' if len(out) > 1 else ''}{self._angle(largest)} from the others of the "
            f"group, where three quarters of the postures "
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
            tight = [
                _distances(self.inclination[part], middle)
                for part, middle in zip((first, second), middles, strict=True)
            ]
            usual = max(
                float(
                    np.quantile(
                        np.concatenate([*tight, self.away[self.places != place]]), _USUAL_QUANTILE
                    )
                ),
                1e-12,
            )
            gap = float(_distances(middles[0][None], middles[1])[0])
            if (
                gap > _OUTSTANDING_RATIO * usual
                and max(float(np.max(t)) for t in tight) < 0.5 * gap
            ):
                return (
                    f"the group of posture {self._named(first)} looks to be two groups under one "
                    f"label: at the nominal geometry these are "
                    f"inclined by {self._angle(gap)} against {self._named(second)}, where three "
                    f"quarters of the postures are within "
                    f"{self._angle(usual)} of their group",
                )
        return ()

    def scattered(self) -> tuple[str, ...]:
        """Find labels that do not go with the inclinations, although the inclinations come in
        groups.
        """
        count = len(self.members)
        if count <= _COMPARED_NEIGHBOURS:
            return ()
        apart = np.array(
            [
                np.sort(_distances(self.inclination, row))[_COMPARED_NEIGHBOURS]
                for row in self.inclination
            ]
        )
        within, near = float(np.median(self.away)), float(np.median(apart))
        if not within > _SCATTER_RATIO * near:
            return ()
        return (
            f"the groups look wrongly labelled: at the nominal geometry half of the postures are "
            f"more than {self._angle(within)} from the "
            f"inclination of their group, and half have {_COMPARED_NEIGHBOURS} postures of any "
            f"group within {self._angle(near)}",
        )

    def _named(self, chosen: Sequence[int] | np.ndarray) -> str:
        return first_of([self.labels[self.members[k]] for k in chosen])

    def _angle(self, angle: float) -> str:
        return f"{self.mechanism.angle_out(angle):.3g} {self.mechanism.angle_unit}"


def _split_at_gap(inclination: np.ndarray) -> np.ndarray | None:
    """Tell which configurations (m,) of a group lie on one side of the largest gap along the
    direction of largest spread, two or more on each side; None where there is none.
    """
    if len(inclination) < 4:
        return None
    around = wrapped(inclination - np.median(inclination, axis=0))
    along = around @ np.linalg.svd(around - around.mean(axis=0), full_matrices=False)[2][0]
    order = np.sort(along)
    cut = 1 + int(np.argmax(np.diff(order)[1:-1]))
    return np.asarray(along <= order[cut])


def _distances(inclination: np.ndarray, middle: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(wrapped(inclination - middle), axis=1))


def _nominal_inclinations(
    mechanism: Mechanism, measurements: Measurements
) -> tuple[np.ndarray, np.ndarray]:
    """Return inclinations (n, 2) at the nominal geometry and groups (n,), -1 for configurations
    that do not close.
    """
    problem = build_calibration(mechanism, with_starts(mechanism, measurements))
    model, m = problem.model, problem.measurements
    with np.errstate(all="ignore"):
        z, solved = newton_configurations(
            model, first_points(model, m, model.nominal), m.joints, model.nominal
        )
        e = model.evaluate(np.nan_to_num(z), m.joints, model.nominal, problem.quaternions)
    return np.nan_to_num(e.readings)[:, problem.readings.columns], np.where(
        solved, problem.readings.group, -1
    )
