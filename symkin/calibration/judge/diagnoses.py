"""Diagnose data-file mistakes: wrong units, swapped columns, flipped signs.

For each mistake the readings are put right and the direct problems solved again at the nominal geometry. A mistake is named when the
readings then agree with it many times better.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.estimate.configurations import joints_at_poses, known_poses, newton_configurations, start_points
from symkin.calibration.estimate.first_guess import fit_measuring_frames
from symkin.calibration.estimate.problem import build_calibration
from symkin.calibration.estimate.residuals import linearise
from symkin.calibration.estimate.starting import has_home, with_starts
from symkin.calibration.judge.statistics import rms_of_better_part
from symkin.errors import SymkinError
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism

_EXAMINED_CONFIGURATIONS = 40
"""Postures that are looked at, spread evenly over the file."""
_MIN_IMPROVEMENT = 3.0
"""A slip is worth a sentence when it makes the misfit smaller by this factor."""
_REST_SPREAD = 1e-4
"""Joints that spread by less than this share of the size (angles: radians), and of ten times their value, are at rest."""
_MIN_LIKE_JOINTS, _MIN_DECADES = 3, 2.0
"""Joints of a kind from which one can be told from the others, and decades by which another unit must bring it nearer to them."""
_LENGTH_UNITS = {1000.0: "a factor of 1000 too small (m taken for mm?)", 0.001: "a factor of 1000 too large (mm taken for m?)"}
_ANGLE_UNITS = {180 / math.pi: "radians taken for degrees", math.pi / 180: "degrees taken for radians"}
_USUAL_SPREAD = (3e-3, 1.0)
"""Usual standard deviation of a joint's readings over the size (angles: radians), and the most that its mean may be: 5 times
the upper one."""

_MAX_ASSIGNED_JOINTS = 7
"""Joints whose orders are all tried (5040); with more only single exchanges are."""
_MIN_WHOLE_POSES = 4
"""Whole poses from which columns are assigned."""
_EXCHANGE_CONFIGURATIONS = 16
"""Postures by which exchanges one after the other are judged."""
_EXCHANGE_GAIN = 0.9
"""An exchange is taken where the misfit falls below this share."""

Misfit = Callable[[Mechanism, Measurements], float]


def diagnose(mechanism: Mechanism, measurements: Measurements, frames: Sequence[str] = ()) -> tuple[str, ...]:
    """Sentences, at most three; none where nothing explains the readings better than they are. `frames` are unknown ones, which are
    sought anew for each slip."""
    rows = np.unique(np.linspace(0, len(measurements) - 1, _EXAMINED_CONFIGURATIONS).astype(int))
    groups = measurements.groups
    if groups is not None and len(measurements) > _EXAMINED_CONFIGURATIONS:
        rows = np.flatnonzero(np.isin(groups, np.unique(groups[rows])))[: 4 * _EXAMINED_CONFIGURATIONS]
    bare = _without_sigmas(measurements.subset(rows))
    if len(rows) > 1 and _never_moves(mechanism, bare):
        return (_never_moved(mechanism, bare),)
    found = [*_units(mechanism, bare)] or [*_one_unit(mechanism, bare)]
    if not found:
        found = [*_better(mechanism, bare, _slips(mechanism, bare), frames)]
        if not found:
            found = [*_better(mechanism, bare, column_orders(mechanism, bare, partial(nominal_misfit, frames=frames)), frames)]
        if bare.position is not None:
            alone = replace(bare, orientation=None)
            found += _better(mechanism, alone, _position_slips(alone, bare.position), frames)
    return tuple(found[:3])


def _never_moves(mechanism: Mechanism, m: Measurements) -> bool:
    """Whether every joint stays where it is but for noise: its spread is nothing beside the size and, of a length, which may be
    in another unit, beside its value."""
    mean = np.abs(np.mean(m.joints, axis=0))
    most = [1.0 if c.is_angular else min(mechanism.size, 10.0 * mean[k]) for k, c in enumerate(mechanism.actuated)]
    return bool(np.all(np.std(m.joints, axis=0) <= _REST_SPREAD * np.array(most)))


def _never_moved(mechanism: Mechanism, m: Measurements) -> str:
    spread = []
    for angular, unit, out in ((False, mechanism.length_unit, float), (True, mechanism.angle_unit, mechanism.angle_out)):
        columns = [k for k, c in enumerate(mechanism.actuated) if c.is_angular == angular]
        if columns:
            spread.append(f"{out(float(np.max(np.std(m.joints[:, columns], axis=0)))):.2g} {unit}")
    return (
        f"the posture never changes: the joint readings spread by {' and '.join(spread)} only; one posture determines no geometry, "
        "measure many that differ"
    )


def _better(mechanism: Mechanism, m: Measurements, slips: Iterable[tuple[str, Measurements]], frames: Sequence[str]) -> list[str]:
    """Sentences for the slips that would make the misfit much smaller, best first."""
    as_read, unit = nominal_misfit(mechanism, m, frames), mechanism.length_unit
    return [
        f"{text}: the misfit at the nominal geometry would fall from {as_read:.3g} to {value:.3g} {unit} (angles times the size)"
        for value, text in sorted((nominal_misfit(mechanism, changed, frames), text) for text, changed in slips)
        if value * _MIN_IMPROVEMENT < as_read
    ]


def _units(mechanism: Mechanism, m: Measurements) -> Iterator[str]:
    """Joint readings whose spread or mean is out of all proportion, by a decade or more, and would not be in other units."""
    for angular, factors in ((False, _LENGTH_UNITS), (True, _ANGLE_UNITS)):
        columns = [k for k, c in enumerate(mechanism.actuated) if c.is_angular == angular]
        if not columns or np.any(np.ptp(m.joints[:, columns], axis=0) == 0.0):
            continue
        values = m.joints[:, columns] / (1.0 if angular else mechanism.size)
        for factor, text in factors.items():
            if _out_of_proportion(values) - _out_of_proportion(values * factor) >= 1.0:
                spread = float(np.median(np.std(values, axis=0)))
                of = "rad" if angular else "of the mechanism's size"
                yield f"the readings of {', '.join(mechanism.actuated[k].name for k in columns)} look {text}: they spread by {spread:.2g} {of}"


def _one_unit(mechanism: Mechanism, m: Measurements) -> Iterator[str]:
    """Single joints whose readings spread, and are, about 1000 times more or less than those of the other joints of their kind."""
    columns = [k for k, c in enumerate(mechanism.actuated) if not c.is_angular]
    if len(columns) < _MIN_LIKE_JOINTS:
        return
    spread, large = np.std(m.joints[:, columns], axis=0), np.sqrt(np.mean(m.joints[:, columns] ** 2, axis=0))
    if not np.all(spread > 0.0):
        return
    for k, column in enumerate(columns):
        ratios = [float(sizes[k] / np.median(np.delete(sizes, k))) for sizes in (spread, large)]
        for factor, text in _LENGTH_UNITS.items():
            if all(abs(math.log10(r)) - abs(math.log10(r * factor)) >= _MIN_DECADES for r in ratios):
                yield (
                    f"the readings of {mechanism.actuated[column].name} look {text}: they spread {ratios[0]:.2g} times as much as those "
                    "of the other joints"
                )


def _out_of_proportion(values: np.ndarray) -> float:
    """Decades by which the spread lies outside its usual range, or the mean above it."""
    spread, mean = float(np.median(np.std(values, axis=0))), float(np.median(np.abs(np.mean(values, axis=0))))
    low, high = _USUAL_SPREAD
    return max(0.0, math.log10(low / spread), math.log10(spread / high), math.log10(max(mean, 1e-300) / (5 * high)))


def nominal_misfit(mechanism: Mechanism, measurements: Measurements, frames: Sequence[str] = ()) -> float:
    """Root mean square of readings less those of the nominal geometry, angles times the size (length unit), over the better
    four fifths of the postures, so that single bad rows do not count; a posture that does not close counts as one size. `frames`
    that are unknown are where they fit best."""
    try:
        ready = with_starts(mechanism, _without_sigmas(measurements), posed=not frames, completed=not has_home(mechanism))
        problem = build_calibration(mechanism, ready, parameters=frames or None)
    except SymkinError:
        return math.inf
    model, m = problem.model, problem.measurements
    with np.errstate(all="ignore"):
        z, solved = newton_configurations(model, start_points(model, m), m.joints, model.nominal)
        p = fit_measuring_frames(problem, np.nan_to_num(z), model.nominal, solved)
        squares = np.zeros(len(m))
        for rows, part in problem.parts:
            e = model.evaluate(np.nan_to_num(z[rows]), part.measurements.joints, p, part.quaternions)
            fit = linearise("means", part.readings, np.nan_to_num(e.readings), np.zeros((*e.readings.shape, 1)))
            squares[rows] = np.nan_to_num(np.sum(fit.residuals**2, axis=1), nan=1e300)
    size = model.closure.size
    squares = np.where(solved, squares, problem.readings.values.shape[1] * size**2)
    return rms_of_better_part(squares)


def _without_sigmas(m: Measurements) -> Measurements:
    """Without standard deviations: residuals are then in the length unit."""
    distances = tuple(replace(d, sigma=None) for d in m.distances)
    return replace(m, distances=distances, group_sigma=None, inclination_sigma=None, position_sigma=None, orientation_sigma=None)


def _slips(mechanism: Mechanism, m: Measurements) -> Iterator[tuple[str, Measurements]]:
    actuated = mechanism.actuated
    for a, b in combinations(range(len(actuated)), 2):
        if actuated[a].is_angular == actuated[b].is_angular:
            joints = np.array(m.joints)
            joints[:, [a, b]] = joints[:, [b, a]]
            if is_possible(actuated, joints):
                yield f"the columns {actuated[a].name} and {actuated[b].name} look exchanged", replace(m, joints=joints)
    for k, c in enumerate(actuated):
        joints = np.array(m.joints)
        joints[:, k] *= -1
        if is_possible(actuated, joints):
            yield f"the sign of {c.name} looks reversed", replace(m, joints=joints)
    if m.position is not None:
        for factor, text in _LENGTH_UNITS.items():
            yield f"the positions look {text}", replace(m, position=m.position * factor)
    if m.orientation is not None:
        inverse = m.orientation * (1.0, -1.0, -1.0, -1.0)
        yield "the orientations look inverted (base seen from the platform)", replace(m, orientation=inverse)
        yield "qw looks to stand last, not first", replace(m, orientation=np.roll(m.orientation, 1, axis=1))
    if m.distances:
        for factor, text in _LENGTH_UNITS.items():
            yield f"the distances look {text}", replace(m, distances=[replace(d, values=factor * d.values) for d in m.distances])
    if m.inclination is not None:
        yield "the columns alpha and beta look exchanged", replace(m, inclination=m.inclination[:, ::-1])


def _position_slips(m: Measurements, position: np.ndarray) -> Iterator[tuple[str, Measurements]]:
    """Columns x, y, z in another order, or one of them with its sign turned; judged without orientations, which may be read in the
    wrong sequence besides."""
    read = [k for k in range(3) if np.any(np.isfinite(position[:, k]))]
    for order in permutations(read):
        moved = [k for k, other in zip(read, order, strict=True) if k != other]
        changed = np.array(position)
        changed[:, read] = position[:, order]
        names, others = (", ".join("xyz"[k] for k in columns) for columns in (read, order))
        if len(moved) == 2:
            yield f"the columns {'xyz'[moved[0]]} and {'xyz'[moved[1]]} look exchanged", replace(m, position=changed)
        elif moved:
            yield f"the columns {names} look exchanged: {names} seem to stand in {others}", replace(m, position=changed)
    for k in read:
        yield f"the sign of {'xyz'[k]} looks reversed", replace(m, position=position * np.where(np.arange(3) == k, -1.0, 1.0))


def column_orders(mechanism: Mechanism, m: Measurements, misfit: Misfit) -> Iterator[tuple[str, Measurements]]:
    """Orders and signs of the joint columns that may explain the readings, with the readings put right."""
    whole = np.array([pose is not None for pose in known_poses(m, measured=True)])
    if not mechanism.serial and np.sum(whole) >= _MIN_WHOLE_POSES and len(mechanism.actuated) <= _MAX_ASSIGNED_JOINTS:
        found = _assign_columns(mechanism, m.subset(whole))
    else:
        found = _exchange_one_by_one(mechanism, m, misfit)
    if found is not None:
        order, signs = found
        yield _describe_order(mechanism.actuated, order, signs), replace(m, joints=signs * m.joints[:, order])


def is_possible(actuated: Sequence[Coordinate], joints: np.ndarray) -> bool:
    """Whether no reading is below the least value of its joint (rods of negative length)."""
    return all(c.least is None or bool(np.all(joints[:, k] > c.least)) for k, c in enumerate(actuated))


def _assign_columns(mechanism: Mechanism, m: Measurements) -> tuple[np.ndarray, np.ndarray] | None:
    """For each joint the column that fits its values at the measured poses best, each column once, and its sign."""
    actuated = mechanism.actuated
    poses = np.array([pose for pose in known_poses(m, measured=True) if pose is not None])
    values = joints_at_poses(mechanism, poses)
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
    return None if unchanged or not is_possible(actuated, signs * m.joints[:, best]) else (best, signs)


def _joint_gap(values: np.ndarray, c: Coordinate) -> np.ndarray:
    return np.asarray(np.remainder(values + np.pi, 2 * np.pi) - np.pi if c.is_angular else values)


def _exchange_one_by_one(mechanism: Mechanism, m: Measurements, misfit: Misfit) -> tuple[np.ndarray, np.ndarray] | None:
    """Exchanges of two columns and changes of one sign, the best first, while the misfit falls."""
    actuated, count = mechanism.actuated, len(mechanism.actuated)
    m = m.subset(np.unique(np.linspace(0, len(m) - 1, _EXCHANGE_CONFIGURATIONS).astype(int)))
    order, signs, least = np.arange(count), np.ones(count), misfit(mechanism, m)
    for step in range(count):
        trials = []
        for a, b in combinations(range(count), 2):
            if actuated[a].is_angular == actuated[b].is_angular:
                swap = np.arange(count)
                swap[[a, b]] = b, a
                trials.append((order[swap], signs[swap]))
        trials += [(order, signs * np.where(np.arange(count) == k, -1.0, 1.0)) for k in range(count)]
        judged = [
            (misfit(mechanism, replace(m, joints=s * m.joints[:, o])), o, s)
            for o, s in trials
            if is_possible(actuated, s * m.joints[:, o])
        ]
        value, o, s = min(judged, key=lambda trial: trial[0], default=(np.inf, order, signs))
        if not value < _EXCHANGE_GAIN * least:
            return None if step < 1 else (order, signs)
        order, signs, least = o, s, value
    return order, signs


def _describe_order(actuated: Sequence[Coordinate], order: np.ndarray, signs: np.ndarray) -> str:
    """'the columns a, b, c look exchanged: they seem to hold b, c, a; the sign of d looks reversed'."""
    names = [c.name for c in actuated]
    holds = np.argsort(order)  # column order[j] holds joint j
    moved = [k for k in range(len(names)) if holds[k] != k]
    parts = []
    if moved:
        parts.append(
            f"the columns {', '.join(names[k] for k in moved)} look exchanged: they seem to hold {', '.join(names[holds[k]] for k in moved)}"
        )
    turned = [names[order[j]] for j in range(len(names)) if signs[j] < 0]
    if turned:
        parts.append(f"the sign{'s' * (len(turned) > 1)} of {', '.join(turned)} look{'s' * (len(turned) == 1)} reversed")
    return "; ".join(parts)
