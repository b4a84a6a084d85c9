"""Build the result of a calibration from its fit: standard deviations, residuals, chi-square and
notes.

The figures are those of the corrected mechanism file as its users will read it: it is written, read
back, and its direct problems are solved at the rows measured. `read_back` gives the state at the
values that the file holds, and a sentence where the file is not what was fitted: it cannot be read,
a row does not close, a rod is inside out, a limit is passed, or a reading comes out otherwise than
in the fit by more than rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import is_writable, nominal_parameters, with_parameters
from symkin.calibration.estimate.configuration_model import ConfigurationModel, build_model
from symkin.calibration.estimate.configurations import newton_configurations
from symkin.calibration.estimate.estimator import Estimate
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.robust import EFFICIENCY
from symkin.calibration.estimate.state import State, closed_state, evaluate, joint_covariance
from symkin.calibration.judge.departure import measure_departure
from symkin.calibration.judge.fit_notes import fit_notes, is_exact
from symkin.calibration.judge.identifiability import identifiability_at
from symkin.calibration.judge.outliers import Screening
from symkin.calibration.judge.result import Calibration, Parameter, Residual
from symkin.calibration.judge.statistics import (
    DOUBTFUL_CURVATURE,
    LinearModel,
    chi_square_tail,
    covariance,
    curvature,
    linear_model,
    told_directions,
)
from symkin.errors import SymkinError
from symkin.model.file import parse
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.spatial.rotation import wrapped
from symkin.text import first_of

_READING_AGREEMENT = (1e-3, 1e-9)
"""Readings of file and fit agree within this share of their standard deviations, or of the size
(angles: radians).
"""
_UNIT_VECTORS = (".axis", ".axis2", ".quaternion")
"""Vectors that a mechanism file holds at unit length."""
_UNSEEN = 1e-12
"""Standard deviations (of scaled parameters, over the largest) below this are those of parameters
that no reading depends on.
"""
_LIMIT_SLACK = 1e-9
"""Limits may be passed by this share of the size (angles: radians), which is rounding."""


@dataclass(frozen=True, eq=False)
class Fit:
    """An estimate over the configurations `used`, those `unsolved`, the sign of det F_z of each
    used one where the estimation began, and configurations without a reading, `silent`.
    """

    problem: CalibrationProblem
    result: Estimate
    used: np.ndarray
    unsolved: np.ndarray
    start_signs: np.ndarray
    notes: tuple[str, ...] = ()
    silent: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))
    loss: str = "squared"
    any_machine: bool = False


def build_result(
    measurements: Measurements, found: Fit, screening: Screening, *, removed: bool
) -> Calibration:
    """Build the result of a fit at the geometry that the corrected file holds; `removed` says
    whether the outliers were left out.
    """
    mechanism = found.problem.mechanism
    problem, written = found.problem, read_back(found.problem, found.result.state)
    state = written.state
    model = linear_model(problem, state)
    known = problem.readings.known
    chi_square = model.chi_square_as_is
    spread = 1.0 if known else chi_square / max(model.degrees, 1)
    free = spread * covariance(problem, state) / (1.0 if found.loss == "squared" else EFFICIENCY)
    identified = identifiability_at(problem, state, told_directions(problem, state).weight)
    crossed = found.used[state.determinant_signs * found.start_signs < 0]
    calibration = Calibration(
        mechanism=mechanism,
        measurements=measurements,
        problem=problem,
        state=state,
        parameters=_parameters(problem, state, free, known or model.degrees > 0),
        covariance=_full_covariance(problem, free),
        residuals=_residuals(problem, state, model, spread, found.used),
        chi_square=chi_square,
        degrees=model.degrees,
        departure=measure_departure(problem, state),
        any_machine=found.any_machine,
        p_value=chi_square_tail(_tested_chi_square(problem, model), model.degrees)
        if known and model.degrees > 0
        else None,
        identifiability=identified,
        outliers=screening.outliers,
        unchecked=screening.unchecked,
        used=tuple(found.used.tolist()),
        unsolved=tuple(found.unsolved.tolist()),
        changed_mode=tuple(crossed.tolist()),
        poses=problem.model.poses(state.z, problem.measurements.joints, state.p),
        status=found.result.status,
        iterations=found.result.iterations,
        given_up=screening.given_up,
        silent=tuple(found.silent.tolist()),
        refused=written.reason,
    )
    left_out = [n for n in problem.names if not is_writable(n)]
    notes = [*found.notes, *fit_notes(calibration, removed=removed)]
    curved = [
        n
        for n, share in zip(problem.names, curvature(problem, state, spread), strict=True)
        if not share < DOUBTFUL_CURVATURE
    ]
    if curved and not is_exact(calibration):
        notes.append(
            f"standard deviations of {first_of(curved)} are doubtful: the readings are not linear "
            f"in the parameters within them; "
            "choose postures that tell these parameters better, or hold some"
        )
    if left_out:
        notes.append(
            f"a mechanism file has no place for {', '.join(left_out)}: apply them to the readings"
        )
    return replace(calibration, notes=tuple(notes))


def _tested_chi_square(problem: CalibrationProblem, model: LinearModel) -> float:
    """Return the statistic that has the chi-square distribution: where the form that was minimised
    leaves joint noise or correlation out of account, what the parameters could still take away of
    it is no misfit.
    """
    efficient = problem.form == "maximum likelihood" or (
        problem.form == "means" and problem.measurements.joint_sigma is None
    )
    return model.chi_square_as_is if efficient else model.chi_square


def _parameters(
    problem: CalibrationProblem, state: State, free: np.ndarray, has_sigma: bool
) -> tuple[Parameter, ...]:
    model = problem.model
    sigmas = np.sqrt(np.maximum(np.diag(free), 0.0))
    # what no reading sees has no variance, which is not to know it exactly
    scaled = sigmas / model.scales
    seen = scaled >= _UNSEEN * np.max(scaled, initial=0.0)
    found = [
        Parameter(
            name=name,
            kind=kind,
            nominal=float(nominal),
            value=float(value),
            sigma=float(sigma) if has_sigma and told else None,
        )
        for name, kind, nominal, value, sigma, told in zip(
            model.names, model.kinds, model.nominal, state.p, sigmas, seen, strict=True
        )
    ]
    table = nominal_parameters(problem.mechanism, problem.measurements.observed)
    return (
        *found,
        *(
            Parameter(
                name=n,
                kind=table[n][1],
                nominal=table[n][0],
                value=table[n][0],
                sigma=0.0,
                held=True,
            )
            for n in problem.fixed
        ),
    )


def _full_covariance(problem: CalibrationProblem, free: np.ndarray) -> np.ndarray:
    """Of the free parameters and then the held ones."""
    width = len(problem.names) + len(problem.fixed)
    whole = np.zeros((width, width))
    whole[: len(free), : len(free)] = free
    return whole


def _residuals(
    problem: CalibrationProblem, state: State, model: LinearModel, spread: float, used: np.ndarray
) -> tuple[Residual, ...]:
    readings = problem.readings
    raw = state_residuals(problem, state)
    left = np.sqrt(np.maximum(1.0 - model.absorbed[: raw.size], 0.0)).reshape(raw.shape)
    whitened = model.residuals[: raw.size].reshape(raw.shape)
    rows = []
    for i, k in np.argwhere(readings.taken):
        kind, component = problem.model.columns[k]
        normal = (
            float(whitened[i, k] / left[i, k] / np.sqrt(spread))
            if left[i, k] > 1e-6 and spread > 0
            else None
        )
        rows.append(
            Residual(
                configuration=int(used[i]),
                kind=kind,
                component=component,
                value=float(raw[i, k]),
                sigma=float(readings.sigma[i, k]),
                normalised=normal,
                angular=bool(problem.model.angular[k]),
            )
        )
    return tuple(rows)


def state_residuals(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Return the readings of the model less those taken (n, K), radians and length unit; a group's
    from its weighted mean.
    """
    means = evaluate(problem, state.p, state.z, "means").linearised.residuals
    return np.asarray(means * np.where(problem.readings.taken, problem.readings.sigma, 0.0))


# --- the file read back ---------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class WrittenGeometry:
    """The state at the values of the file that would be written, and why it must not be, None where
    nothing speaks against it.
    """

    state: State
    reason: str | None


def read_back(problem: CalibrationProblem, state: State) -> WrittenGeometry:
    """Write the mechanism at a state, read it, and compare its direct problems at the measured rows
    with the state's.
    """
    values = dict(zip(problem.names, map(float, state.p), strict=True))
    read_besides = problem.measurements.observed
    try:
        found = parse(with_parameters(problem.mechanism, values).to_toml())
        table = nominal_parameters(found, read_besides)
    except SymkinError as error:
        return WrittenGeometry(
            state, f"the file with the identified geometry cannot be read ({error})"
        )
    nominal = {
        name: float(value)
        for name, (value, *_) in nominal_parameters(problem.mechanism, read_besides).items()
    }
    read = {name: float(value) for name, (value, *_) in table.items()}
    factors = _vector_lengths(nominal | values, read)
    p = np.array(
        [
            read[n] * factors.get(_vector(n), 1.0) if is_writable(n) else values[n]
            for n in problem.names
        ]
    )
    with np.errstate(all="ignore"):
        noise = joint_covariance(problem, state) if problem.form == "maximum likelihood" else None
        here = closed_state(problem, p, state.z, problem.form, noise)
        return WrittenGeometry(here, _difference(problem, state, found, values))


def _vector(name: str) -> str:
    """Name the vector of which a parameter is a component."""
    return name.rpartition(".")[0]


def _vector_lengths(fitted: dict[str, float], read: dict[str, float]) -> dict[str, float]:
    """Return by how much the fit's directions and quaternions are longer than those of the file,
    which are of unit length: a set of parameters may hold one of their components.
    """
    vectors = {_vector(name) for name in read if _vector(name).endswith(_UNIT_VECTORS)}
    factors = {}
    for vector in vectors:
        names = [name for name in read if _vector(name) == vector]
        ours, theirs = (np.array([numbers[name] for name in names]) for numbers in (fitted, read))
        factors[vector] = float(ours @ theirs) / float(theirs @ theirs)
    return factors


def _difference(
    problem: CalibrationProblem, state: State, found: Mechanism, values: dict[str, float]
) -> str | None:
    """Say the first thing in which the file is not what was fitted, None where there is none."""
    m = problem.measurements
    beside = {n: v for n, v in values.items() if not is_writable(n)}
    model, p = build_model(found, m, tuple(beside)), np.array(list(beside.values()))
    inside_out = next(_negative_rods(found, m, _actuated_values(found, m, beside)), None)
    if inside_out is not None:
        return inside_out
    z, solved = newton_configurations(model, state.z, m.joints, p)
    if not solved.all():
        return (
            f"{_row_names(m, ~solved)} {_has_or_have(~solved)} no solution at the geometry that "
            f"would be written"
        )
    outside = next(_outside_limits(model, m, z), None)
    return outside or _disagreement(
        problem, state, model.evaluate(z, m.joints, p, problem.quaternions).readings
    )


def _disagreement(problem: CalibrationProblem, state: State, of_file: np.ndarray) -> str | None:
    """Say which row comes out otherwise from the file than in the fit, None where none does."""
    readings, size = problem.readings, problem.model.closure.characteristic_length
    ours = problem.model.evaluate(
        state.z, problem.measurements.joints, state.p, problem.quaternions
    ).readings
    units = np.where(problem.model.angular, 1.0, size)
    gap = np.where(readings.taken, np.abs(of_file - ours), 0.0)
    gap = np.where(readings.turning, np.abs(wrapped(gap)), gap)
    known = _READING_AGREEMENT[0] * readings.sigma if readings.known else np.zeros_like(gap)
    off = np.any(~(gap <= np.maximum(known, _READING_AGREEMENT[1] * units)), axis=1)
    if not off.any():
        return None
    return (
        f"the file that would be written does not give the readings that the fit does at "
        f"{_row_names(problem.measurements, off)}: "
        f"they differ by up to {np.nanmax(gap / units):.2g} of the size"
    )


# --- physical -------------------------------------------------------------------------------------


def _actuated_values(found: Mechanism, m: Measurements, beside: dict[str, float]) -> np.ndarray:
    """Return the values (n, a) of the actuated joints: readings times their factors."""
    return np.asarray(m.joints * [beside.get(f"{c.name}.scale", 1.0) for c in found.actuated])


def _negative_rods(found: Mechanism, m: Measurements, joints: np.ndarray) -> Iterator[str]:
    """Yield a sentence for each rod of negative length."""
    for k, c in enumerate(found.actuated):
        short = joints[:, k] < _least(c)
        if short.any():
            least = float(np.min(joints[:, k] - _least(c)))
            yield (
                f"the rod of {c.name} would have a negative length at {_row_names(m, short)}, down "
                f"to {least:.4g} {found.length_unit}"
            )


def _outside_limits(model: ConfigurationModel, m: Measurements, z: np.ndarray) -> Iterator[str]:
    """Yield a sentence for each passive joint outside its limits; limits of actuated joints speak
    of the rows, not of the geometry.
    """
    places = {
        c.name: place.start
        for c, place in zip(model.system.unknowns, model.system.slices, strict=True)
    }
    for c in model.closure.role("passive"):
        if c.width == 1:
            values = z[:, places[c.name]]
            off = _beyond_limits(c, values, model.closure.characteristic_length) | (
                values < _least(c)
            )
            if off.any():
                yield (
                    f"the passive joint {c.name} would be outside its limits at "
                    f"{_row_names(m, off)}"
                )


def _least(c: Coordinate) -> float:
    return -math.inf if c.least is None else c.least


def _beyond_limits(c: Coordinate, values: np.ndarray, size: float) -> np.ndarray:
    """Tell which values, angles by whole turns as near as may be, are outside the limits by more
    than rounding.
    """
    if c.limits is None:
        return np.zeros(len(values), dtype=bool)
    low, high = c.limits
    slack = _LIMIT_SLACK * (1.0 if c.is_angular else size)
    if c.kind == "angle":
        values = values + 2 * np.pi * np.ceil((low - slack - values) / (2 * np.pi))
    return np.asarray((values < low - slack) | (values > high + slack))


def _row_names(m: Measurements, which: np.ndarray) -> str:
    """Name rows: 'posture line 3, line 9 and 12 more'."""
    labels = [label for label, is_one in zip(m.labels, which, strict=True) if is_one]
    more = f" and {len(labels) - 3} more" if len(labels) > 3 else ""
    return f"posture {', '.join(labels[:3])}{more}"


def _has_or_have(which: np.ndarray) -> str:
    return "has" if int(np.sum(which)) == 1 else "have"
