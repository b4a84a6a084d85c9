"""Diagnose data-file mistakes: wrong units, swapped columns, flipped signs, wrong labels (another
Euler sequence: see `euler_sequence`).

`RULES` is the table of the mistakes that are looked for. The readings alone show some; for the
others the readings are put right and the direct problems solved again at the nominal geometry, and
a mistake is named when the readings then agree with it many times better.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto
from itertools import combinations, permutations

import numpy as np

from symkin.calibration.data.measurements import Measurements, Reading, spread_rows
from symkin.calibration.data.observables import is_angular, observables
from symkin.calibration.estimate.configurations import first_points, newton_configurations
from symkin.calibration.estimate.first_guess import fit_measuring_frames
from symkin.calibration.estimate.problem import build_calibration
from symkin.calibration.estimate.residuals import linearise
from symkin.calibration.estimate.starting import has_home, with_starts
from symkin.calibration.judge.assignments import (
    best_column_order,
    diagnose_groups,
    is_possible,
    like_pairs,
    sign_change,
    swapped,
)
from symkin.calibration.judge.statistics import rms_of_better_part
from symkin.errors import SymkinError
from symkin.model.mechanism import Mechanism

_EXAMINED_CONFIGURATIONS = 40
"""Configurations that are looked at, spread evenly over the file: enough to see a mistake of all
rows.
"""
_MAX_SENTENCES = 3
"""Mistakes that are named at most: further ones are likely to follow from these."""
_MIN_IMPROVEMENT = 3.0
"""A mistake is named when putting it right makes the misfit smaller by this factor."""
_REST_SPREAD = 1e-4
"""Joints that spread by less than this share of the size (angles: radians), and of ten times their
value, are at rest.
"""
_MIN_LIKE_JOINTS, _MIN_DECADES = 3, 2.0
"""Joints of a kind from which one can be told from the others, and decades by which another unit
must bring it nearer to them.
"""
_LENGTH_UNITS = {
    1000.0: "a factor of 1000 too small (m taken for mm?)",
    0.001: "a factor of 1000 too large (mm taken for m?)",
}
_ANGLE_UNITS = {
    180 / math.pi: "radians taken for degrees",
    math.pi / 180: "degrees taken for radians",
}
"""Factors that put lengths and angles in another unit right, with what is said of them."""
_USUAL_SPREAD = (3e-3, 1.0)
"""Usual standard deviation of a joint's readings over the size (angles: radians), and the most that
its mean may be: 5 times the upper one.
"""


# --- the table ------------------------------------------------------------------------------------


class Stage(Enum):
    """What shows a mistake. Rules of a stage are looked at where those before it found nothing;
    positions besides the corrections.
    """

    READINGS = auto()
    CORRECTION = auto()
    ORDER = auto()
    POSITION = auto()
    LABELS = auto()


@dataclass(frozen=True, eq=False)
class Case:
    """What the rules look at: some readings of a mechanism without standard deviations, and
    parameters that are unknown frames.
    """

    mechanism: Mechanism
    measurements: Measurements
    frames: tuple[str, ...] = ()

    def misfit(self, measurements: Measurements) -> float:
        """The misfit of other readings in place of these."""
        return nominal_misfit(self.mechanism, measurements, self.frames)


Finding = tuple[str, Measurements | None]
"""A sentence on a mistake, and the readings put right by which it is judged; None where the
readings alone show it.
"""


@dataclass(frozen=True)
class Rule:
    """A mistake that is looked for: `find` yields its possible forms in a case."""

    mistake: str
    stage: Stage
    find: Callable[[Case], Iterable[Finding]]


def diagnose(
    mechanism: Mechanism, measurements: Measurements, frames: Sequence[str] = ()
) -> tuple[str, ...]:
    """Sentences on mistakes in the columns, at most three; none where nothing explains the readings
    better than they are. `frames` are unknown ones, which are sought anew for each mistake.
    """
    examined = _without_sigmas(measurements.subset(_examined_rows(measurements)))
    case = Case(mechanism, examined, tuple(frames))
    found = _sentences(case, Stage.READINGS)
    if not found:
        found = _sentences(case, Stage.CORRECTION) or _sentences(case, Stage.ORDER)
        found += _sentences(
            replace(case, measurements=replace(examined, orientation=None)), Stage.POSITION
        )
    return tuple(found[:_MAX_SENTENCES])


def diagnose_labels(mechanism: Mechanism, measurements: Measurements) -> tuple[str, ...]:
    """Sentences on labels of groups that look wrong."""
    return tuple(_sentences(Case(mechanism, measurements), Stage.LABELS))


def _examined_rows(m: Measurements) -> np.ndarray:
    """Numbers of some rows, spread over the file, whole groups where there are any."""
    rows = spread_rows(len(m), _EXAMINED_CONFIGURATIONS)
    if m.groups is None or len(m) <= _EXAMINED_CONFIGURATIONS:
        return rows
    return np.flatnonzero(np.isin(m.groups, np.unique(m.groups[rows])))[
        : 4 * _EXAMINED_CONFIGURATIONS
    ]


def _sentences(case: Case, stage: Stage) -> list[str]:
    """What a stage finds: the sentences of the first rule that the readings alone show, else of all
    mistakes that would make the misfit much smaller if they were put right, best first.
    """
    judged: list[tuple[str, Measurements]] = []
    for rule in (rule for rule in RULES if rule.stage is stage):
        findings = [*rule.find(case)]
        shown = [text for text, changed in findings if changed is None]
        if shown:
            return shown
        judged += [(text, changed) for text, changed in findings if changed is not None]
    return _improvements(case, judged) if judged else []


def _improvements(case: Case, judged: Iterable[tuple[str, Measurements]]) -> list[str]:
    as_read, unit = case.misfit(case.measurements), case.mechanism.length_unit
    return [
        f"{text}: the misfit at the nominal geometry would fall from {as_read:.3g} to {value:.3g} "
        f"{unit} (angles times the size)"
        for value, text in sorted((case.misfit(changed), text) for text, changed in judged)
        if value * _MIN_IMPROVEMENT < as_read
    ]


# --- misfit ---------------------------------------------------------------------------------------


def nominal_misfit(
    mechanism: Mechanism, measurements: Measurements, frames: Sequence[str] = ()
) -> float:
    """Root mean square of readings less those of the nominal geometry, angles times the size
    (length unit), over the better four fifths of the configurations, so that single bad rows do not
    count; a configuration that does not close counts as one size. `frames` that are unknown are
    where they fit best.
    """
    try:
        ready = with_starts(
            mechanism,
            _without_sigmas(measurements),
            posed=not frames,
            completed=not has_home(mechanism),
        )
        problem = build_calibration(mechanism, ready, parameters=frames or None)
    except SymkinError:
        return math.inf
    model, m = problem.model, problem.measurements
    with np.errstate(all="ignore"):
        z, solved = newton_configurations(
            model, first_points(model, m, model.nominal), m.joints, model.nominal
        )
        p = fit_measuring_frames(problem, np.nan_to_num(z), model.nominal, solved)
        squares = np.zeros(len(m))
        for rows, part in problem.parts:
            e = model.evaluate(
                np.nan_to_num(z[rows]), part.measurements.joints, p, part.quaternions
            )
            fit = linearise(
                "means", part.readings, np.nan_to_num(e.readings), np.zeros((*e.readings.shape, 1))
            )
            squares[rows] = np.nan_to_num(np.sum(fit.residuals**2, axis=1), nan=1e300)
    size = model.closure.characteristic_length
    squares = np.where(solved, squares, problem.readings.values.shape[1] * size**2)
    return rms_of_better_part(squares)


def _without_sigmas(m: Measurements) -> Measurements:
    """Without standard deviations: residuals are then in the length unit."""
    return replace(
        m,
        distances=[replace(d, sigma=None) for d in m.distances],
        readings=[replace(r, sigma=None) for r in m.readings],
        group_sigma=None,
        inclination_sigma=None,
        position_sigma=None,
        orientation_sigma=None,
    )


# --- what the readings alone show -----------------------------------------------------------------


def _joints_at_rest(case: Case) -> Iterator[Finding]:
    """Every joint stays where it is but for noise: its spread is nothing beside the size and, of a
    length, which may be in another unit, beside its value.
    """
    m, joints = case.mechanism, case.measurements.joints
    mean, spread = np.abs(np.mean(joints, axis=0)), np.std(joints, axis=0)
    most = np.array(
        [
            1.0 if c.is_angular else min(m.characteristic_length, 10.0 * mean[k])
            for k, c in enumerate(m.actuated)
        ]
    )
    if len(joints) < 2 or not np.all(spread <= _REST_SPREAD * most):
        return
    said = []
    for angular, unit, out in ((False, m.length_unit, float), (True, m.angle_unit, m.angle_out)):
        if columns := _columns_of_kind(m, angular=angular):
            said.append(f"{out(float(np.max(spread[columns]))):.2g} {unit}")
    yield (
        f"the posture never changes: the joint readings spread by {' and '.join(said)} only; one "
        f"posture determines no geometry, "
        "measure many that differ",
        None,
    )


def _units_of_all_joints(case: Case) -> Iterator[Finding]:
    """Joint readings whose spread or mean is out of all proportion, by a decade or more, and would
    not be in other units.
    """
    m, joints = case.mechanism, case.measurements.joints
    for angular, factors in ((False, _LENGTH_UNITS), (True, _ANGLE_UNITS)):
        columns = _columns_of_kind(m, angular=angular)
        if not columns or np.any(np.ptp(joints[:, columns], axis=0) == 0.0):
            continue
        values = joints[:, columns] / (1.0 if angular else m.characteristic_length)
        names, of = (
            ", ".join(m.actuated[k].name for k in columns),
            "rad" if angular else "of the mechanism's size",
        )
        for factor, text in factors.items():
            if (
                _decades_out_of_proportion(values) - _decades_out_of_proportion(values * factor)
                >= 1.0
            ):
                spread = float(np.median(np.std(values, axis=0)))
                yield f"the readings of {names} look {text}: they spread by {spread:.2g} {of}", None


def _unit_of_one_joint(case: Case) -> Iterator[Finding]:
    """Single joints whose readings spread, and are, about 1000 times more or less than those of the
    other joints of their kind.
    """
    m, joints = case.mechanism, case.measurements.joints
    columns = _columns_of_kind(m, angular=False)
    spread, large = (
        np.std(joints[:, columns], axis=0),
        np.sqrt(np.mean(joints[:, columns] ** 2, axis=0)),
    )
    if len(columns) < _MIN_LIKE_JOINTS or not np.all(spread > 0.0):
        return
    for k, column in enumerate(columns):
        ratios = [float(sizes[k] / np.median(np.delete(sizes, k))) for sizes in (spread, large)]
        for factor, text in _LENGTH_UNITS.items():
            if all(
                abs(math.log10(r)) - abs(math.log10(r * factor)) >= _MIN_DECADES for r in ratios
            ):
                yield (
                    f"the readings of {m.actuated[column].name} look {text}: they spread "
                    f"{ratios[0]:.2g} times as much as those "
                    "of the other joints",
                    None,
                )


def _columns_of_kind(mechanism: Mechanism, *, angular: bool) -> list[int]:
    """Columns of the joints that are angles, or of those that are lengths."""
    return [k for k, c in enumerate(mechanism.actuated) if c.is_angular == angular]


def _decades_out_of_proportion(values: np.ndarray) -> float:
    """Decades by which the spread lies outside its usual range, or the mean above it."""
    spread, mean = (
        float(np.median(np.std(values, axis=0))),
        float(np.median(np.abs(np.mean(values, axis=0)))),
    )
    low, high = _USUAL_SPREAD
    return max(
        0.0,
        math.log10(low / spread),
        math.log10(spread / high),
        math.log10(max(mean, 1e-300) / (5 * high)),
    )


# --- what a correction shows ----------------------------------------------------------------------


def _exchanged_joints(case: Case) -> Iterator[Finding]:
    for a, b in like_pairs(case.mechanism):
        order = swapped(len(case.mechanism.actuated), a, b)
        joints = case.measurements.joints[:, order]
        if is_possible(case.mechanism.actuated, joints):
            names = (case.mechanism.actuated[k].name for k in (a, b))
            yield (
                f"the columns {' and '.join(names)} look exchanged",
                replace(case.measurements, joints=joints),
            )


def _reversed_joints(case: Case) -> Iterator[Finding]:
    for k, c in enumerate(case.mechanism.actuated):
        joints = case.measurements.joints * sign_change(len(case.mechanism.actuated), k)
        if is_possible(case.mechanism.actuated, joints):
            yield f"the sign of {c.name} looks reversed", replace(case.measurements, joints=joints)


def _reversed_all_joints(case: Case) -> Iterator[Finding]:
    joints, names = -case.measurements.joints, [c.name for c in case.mechanism.actuated]
    if len(names) > 1 and is_possible(case.mechanism.actuated, joints):
        yield (
            f"the signs of {', '.join(names)} look reversed",
            replace(case.measurements, joints=joints),
        )


def _joints_in_radians(case: Case) -> Iterator[Finding]:
    """All angles in radians, which spread as degrees may. Of other units the spread tells; and
    factors below one make any misfit smaller.
    """
    columns = _columns_of_kind(case.mechanism, angular=True)
    factor, joints = 180 / math.pi, np.array(case.measurements.joints)
    joints[:, columns] *= factor
    if columns and is_possible(case.mechanism.actuated, joints):
        names = ", ".join(case.mechanism.actuated[k].name for k in columns)
        yield (
            f"the readings of {names} look {_ANGLE_UNITS[factor]}",
            replace(case.measurements, joints=joints),
        )


def _reordered_joints(case: Case) -> Iterator[Finding]:
    found = best_column_order(case.mechanism, case.measurements, case.misfit)
    if found is not None:
        yield found


def _unit_of_positions(case: Case) -> Iterator[Finding]:
    m = case.measurements
    for factor, text in _LENGTH_UNITS.items() if m.position is not None else ():
        yield f"the positions look {text}", replace(m, position=np.asarray(m.position) * factor)


def _inverted_orientations(case: Case) -> Iterator[Finding]:
    if (q := case.measurements.orientation) is not None:
        inverse = replace(case.measurements, orientation=q * (1.0, -1.0, -1.0, -1.0))
        yield "the orientations look inverted (base seen from the platform)", inverse


def _scalar_last(case: Case) -> Iterator[Finding]:
    if (q := case.measurements.orientation) is not None:
        yield (
            "qw looks to stand last, not first",
            replace(case.measurements, orientation=np.roll(q, 1, axis=1)),
        )


def _unit_of_distances(case: Case) -> Iterator[Finding]:
    m = case.measurements
    for factor, text in _LENGTH_UNITS.items() if m.distances else ():
        yield (
            f"the distances look {text}",
            replace(m, distances=[replace(d, values=factor * d.values) for d in m.distances]),
        )


def _with_readings(case: Case, changed: dict[str, np.ndarray]) -> Measurements:
    """The measurements with other values of some readings."""
    m = case.measurements
    return replace(
        m, readings=[replace(r, values=changed.get(r.name, r.values)) for r in m.readings]
    )


def _encoders(case: Case) -> list[Reading]:
    """Readings of passive joints."""
    known = observables(case.mechanism)
    return [r for r in case.measurements.readings if known[r.name].kind == "joint"]


def _reversed_encoders(case: Case) -> Iterator[Finding]:
    for r in _encoders(case):
        yield f"the sign of {r.name} looks reversed", _with_readings(case, {r.name: -r.values})


def _exchanged_encoders(case: Case) -> Iterator[Finding]:
    for one, other in combinations(_encoders(case), 2):
        if is_angular(case.mechanism, one.name) == is_angular(case.mechanism, other.name):
            changed = _with_readings(case, {one.name: other.values, other.name: one.values})
            yield f"the columns {one.name} and {other.name} look exchanged", changed


def _units_of_readings(case: Case) -> Iterator[Finding]:
    """One reading of a joint, a point, a distance or a link's place in another unit."""
    known = observables(case.mechanism)
    for r in case.measurements.readings:
        o = known[r.name]
        factors = {} if r.is_orientation else _ANGLE_UNITS if o.angular else _LENGTH_UNITS
        for factor, text in factors.items():
            yield (
                f"the readings of {r.name} look {text}",
                _with_readings(case, {r.name: factor * r.values}),
            )


def _exchanged_inclinations(case: Case) -> Iterator[Finding]:
    if (inclination := case.measurements.inclination) is not None:
        yield (
            "the columns alpha and beta look exchanged",
            replace(case.measurements, inclination=inclination[:, ::-1]),
        )


def _exchanged_positions(case: Case) -> Iterator[Finding]:
    """Columns x, y, z in another order. Orientations are left out, as they may be read in the wrong
    sequence besides.
    """
    position, read = case.measurements.position, _position_columns(case)
    for order in permutations(read) if read else ():
        moved = [k for k, other in zip(read, order, strict=True) if k != other]
        changed = np.array(position)
        changed[:, read] = changed[:, order]
        names, others = (", ".join("xyz"[k] for k in columns) for columns in (read, order))
        text = f"the columns {names} look exchanged: {names} seem to stand in {others}"
        if len(moved) == 2:
            text = f"the columns {'xyz'[moved[0]]} and {'xyz'[moved[1]]} look exchanged"
        if moved:
            yield text, replace(case.measurements, position=changed)


def _reversed_positions(case: Case) -> Iterator[Finding]:
    for k in _position_columns(case):
        changed = np.asarray(case.measurements.position) * sign_change(3, k)
        yield f"the sign of {'xyz'[k]} looks reversed", replace(case.measurements, position=changed)


def _position_columns(case: Case) -> list[int]:
    """Components of the position that were read."""
    position = case.measurements.position
    return [] if position is None else [k for k in range(3) if np.any(np.isfinite(position[:, k]))]


RULES = (
    Rule("the joints never move", Stage.READINGS, _joints_at_rest),
    Rule("all joints of a kind in another unit", Stage.READINGS, _units_of_all_joints),
    Rule("one joint in another unit than the others", Stage.READINGS, _unit_of_one_joint),
    Rule("two joint columns exchanged", Stage.CORRECTION, _exchanged_joints),
    Rule("the sign of a joint reversed", Stage.CORRECTION, _reversed_joints),
    Rule("the signs of all joints reversed", Stage.CORRECTION, _reversed_all_joints),
    Rule("angles of joints in radians", Stage.CORRECTION, _joints_in_radians),
    Rule("positions in another unit", Stage.CORRECTION, _unit_of_positions),
    Rule("orientations of the base in the platform", Stage.CORRECTION, _inverted_orientations),
    Rule("quaternions with their scalar last", Stage.CORRECTION, _scalar_last),
    Rule("distances in another unit", Stage.CORRECTION, _unit_of_distances),
    Rule("the sign of a passive joint's encoder reversed", Stage.CORRECTION, _reversed_encoders),
    Rule("two encoders exchanged", Stage.CORRECTION, _exchanged_encoders),
    Rule(
        "readings of joints, points and links in another unit", Stage.CORRECTION, _units_of_readings
    ),
    Rule("alpha and beta exchanged", Stage.CORRECTION, _exchanged_inclinations),
    Rule("joint columns in another order, with other signs", Stage.ORDER, _reordered_joints),
    Rule("position columns in another order", Stage.POSITION, _exchanged_positions),
    Rule("the sign of a position column reversed", Stage.POSITION, _reversed_positions),
    Rule(
        "groups wrongly labelled",
        Stage.LABELS,
        lambda case: ((s, None) for s in diagnose_groups(case.mechanism, case.measurements)),
    ),
)
"""The mistakes that are looked for, in the order in which those that the readings alone show
are.
"""
