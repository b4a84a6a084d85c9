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
from dataclasses import replace

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import is_writable, nominal_parameters, with_parameters
from symkin.calibration.estimate.configuration_model import build_model
from symkin.calibration.estimate.configurations import newton_configurations, outside_limits
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.robust import EFFICIENCY
from symkin.calibration.estimate.state import (
    State,
    closed_state,
    evaluate,
    joint_covariance,
    readings_at,
    told_directions,
)
from symkin.calibration.judge.departure import measure_departure
from symkin.calibration.judge.identifiability import identifiability_at
from symkin.calibration.judge.outliers import MIN_REDUNDANCY, Fit, Screening
from symkin.calibration.judge.result import Calibration, Parameter, Residual
from symkin.calibration.judge.statistics import (
    DOUBTFUL_CURVATURE,
    LinearModel,
    chi_square_tail,
    covariance,
    curvature,
    linear_model,
)
from symkin.calibration.judge.verdict import fit_notes, is_exact
from symkin.errors import SymkinError
from symkin.model.file import parse
from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import LIMIT_SLACK
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


def build_result(
    measurements: Measurements, found: Fit, screening: Screening, *, removed: bool
) -> Calibration:
    """Build the result of a fit at the geometry that the corrected file holds; `removed` says
    whether the outliers were left out.
    """
    problem = found.problem
    state, reason = read_back(problem, found.state)
    told = told_directions(problem, state)
    model, known = linear_model(problem, state, told), problem.readings.known
    # of the parameters as they are, without the step that the projection stands for
    chi_square = model.chi_square + model.within_reach
    spread = 1.0 if known else chi_square / max(model.degrees, 1)
    used = 1.0 if found.loss == "squared" else EFFICIENCY
    free = spread / used * covariance(problem, state, told)
    crossed = found.used[state.determinant_signs * found.start_signs < 0]
    # where the form that was minimised leaves joint noise or correlation out of account, what the
    # parameters could still take away of chi-square is no misfit
    plain = problem.form == "means" and problem.measurements.joint_sigma is None
    efficient = problem.form == "maximum likelihood" or plain
    tested = chi_square if efficient else model.chi_square
    calibration = Calibration(
        mechanism=problem.mechanism,
        measurements=measurements,
        problem=problem,
        state=state,
        parameters=_parameters(problem, state, free, known or model.degrees > 0),
        covariance=np.pad(free, (0, len(problem.fixed))),
        residuals=_residuals(problem, state, model, spread, found.used),
        chi_square=chi_square,
        degrees=model.degrees,
        departure=measure_departure(problem, state),
        any_machine=found.any_machine,
        p_value=chi_square_tail(tested, model.degrees) if known and model.degrees > 0 else None,
        identifiability=identifiability_at(problem, state, told.weight),
        used=tuple(found.used.tolist()),
        unsolved=tuple(found.unsolved.tolist()),
        changed_mode=tuple(crossed.tolist()),
        poses=problem.model.poses(state.z, problem.joints, state.p),
        status=found.status,
        iterations=found.iterations,
        silent=tuple(found.silent),
        **vars(replace(screening, refused=reason or screening.refused)),
    )
    notes = [*found.notes, *fit_notes(calibration, removed=removed)]
    bent = ~(curvature(problem, state, told, spread) < DOUBTFUL_CURVATURE)
    if bent.any() and not is_exact(calibration):
        curved = [problem.names[k] for k in np.flatnonzero(bent)]
        notes.append(
            f"standard deviations of {first_of(curved)} are doubtful: the readings are not linear "
            f"in the parameters within them; "
            "choose postures that tell these parameters better, or hold some"
        )
    if left_out := [n for n in problem.names if not is_writable(n)]:
        notes.append(
            f"a mechanism file has no place for {', '.join(left_out)}: apply them to the readings"
        )
    return replace(calibration, notes=tuple(notes))


def _parameters(
    problem: CalibrationProblem, state: State, free: np.ndarray, has_sigma: bool
) -> tuple[Parameter, ...]:
    model = problem.model
    sigmas = np.sqrt(np.maximum(np.diag(free), 0.0))
    # what no reading sees has no variance, which is not to know it exactly
    scaled = sigmas / model.scales
    known = has_sigma & (scaled >= _UNSEEN * scaled.max(initial=0.0))
    found = [
        Parameter(name, kind, float(nominal), float(value), float(sigma) if told else None)
        for name, kind, nominal, value, sigma, told in zip(
            model.names, model.kinds, model.nominal, state.p, sigmas, known, strict=True
        )
    ]
    table = nominal_parameters(problem.mechanism, problem.measurements.observed)
    held = [(n, *table[n]) for n in problem.fixed]
    return (*found, *(Parameter(n, kind, v, v, 0.0, held=True) for n, v, kind in held))


def _residuals(
    problem: CalibrationProblem, state: State, model: LinearModel, spread: float, used: np.ndarray
) -> tuple[Residual, ...]:
    """List the readings of the model less those taken, radians and length unit; a group's from its
    weighted mean.
    """
    readings, columns = problem.readings, problem.model.columns
    taken, shape = readings.taken, readings.values.shape
    means = evaluate(problem.by_means, state.p, state.z).linearised.residuals
    raw = means * np.where(taken, readings.sigma, 0.0)
    left, whitened = (v[: raw.size].reshape(shape) for v in (1.0 - model.absorbed, model.residuals))
    judged = taken & (left > MIN_REDUNDANCY) & (spread > 0.0)
    normal = whitened / np.sqrt(np.where(judged, spread * left, 1.0))
    return tuple(
        Residual(
            int(used[i]),
            columns[k][0],
            columns[k][1],
            float(raw[i, k]),
            float(readings.sigma[i, k]),
            float(normal[i, k]) if judged[i, k] else None,
            bool(problem.model.angular[k]),
        )
        for i, k in np.argwhere(taken)
    )


# --- the file read back ---------------------------------------------------------------------------


def read_back(problem: CalibrationProblem, state: State) -> tuple[State, str | None]:
    """Write the mechanism at a state, read it, and compare its direct problems at the measured rows
    with the state's: the state at the values of the file, and why it must not be written, None
    where nothing speaks against it.
    """
    values = dict(zip(problem.names, map(float, state.p), strict=True))

    def numbers(mechanism: Mechanism) -> dict[str, float]:
        table = nominal_parameters(mechanism, problem.measurements.observed)
        return {name: float(value) for name, (value, _) in table.items()}

    try:
        found = parse(with_parameters(problem.mechanism, values).to_toml())
        read = numbers(found)
    except SymkinError as error:
        return state, f"the file with the identified geometry cannot be read ({error})"
    fitted = numbers(problem.mechanism) | values
    p = np.array(
        [
            read[n] * _stretch(n, fitted, read) if is_writable(n) else values[n]
            for n in problem.names
        ]
    )
    with np.errstate(all="ignore"):
        weighs = problem.form == "maximum likelihood"
        noise = joint_covariance(problem, state.p, state.z) if weighs else None
        here = closed_state(replace(problem, noise=noise), p, state.z)
        return here, next(_faults(problem, state, found, values), None)


def _stretch(name: str, fitted: dict[str, float], read: dict[str, float]) -> float:
    """Return by how much the fit's direction or quaternion, of which a parameter is a component, is
    longer than that of the file, which is of unit length; 1 for other parameters.
    """
    vector = name.rpartition(".")[0]
    if not vector.endswith(_UNIT_VECTORS):
        return 1.0
    names = [n for n in read if n.rpartition(".")[0] == vector]
    ours, theirs = (np.array([numbers[n] for n in names]) for numbers in (fitted, read))
    return float(ours @ theirs) / float(theirs @ theirs)


def _faults(
    problem: CalibrationProblem, state: State, found: Mechanism, values: dict[str, float]
) -> Iterator[str]:
    """Yield what in the file is not what was fitted."""
    m = problem.measurements
    beside = {n: v for n, v in values.items() if not is_writable(n)}
    for k, c in enumerate(found.actuated):
        least = -math.inf if c.least is None else c.least
        beyond = m.joints[:, k] * beside.get(f"{c.name}.scale", 1.0) - least
        if np.any(beyond < 0.0):
            yield (
                f"the rod of {c.name} would have a negative length at {_row_names(m, beyond < 0)}, "
                f"down to {beyond.min():.4g} {found.length_unit}"
            )
    model, p = build_model(found, m, tuple(beside)), np.array(list(beside.values()))
    z, solved = newton_configurations(model, state.z, m.joints, p)
    if not solved.all():
        has = "has" if np.sum(~solved) == 1 else "have"
        yield f"{_row_names(m, ~solved)} {has} no solution at the geometry that would be written"
    for c, place in zip(model.system.unknowns, model.system.slices, strict=True):
        if c.width == 1 and c in model.closure.role("passive"):
            column = z[:, place.start]
            off = outside_limits(c, column, -LIMIT_SLACK * c.unit(model.size))
            if off.any():  # limits of actuated joints speak of the rows, not of the geometry
                yield (
                    f"the passive joint {c.name} would be outside its limits at "
                    f"{_row_names(m, off)}"
                )
    yield from _disagreements(
        problem, state, model.evaluate(z, m.joints, p, problem.quaternions).readings
    )


def _disagreements(problem: CalibrationProblem, state: State, of_file: np.ndarray) -> Iterator[str]:
    """Yield which rows come out otherwise from the file than in the fit."""
    readings, lengths = problem.readings, problem.model.lengths
    units = problem.size / lengths
    gap = np.where(readings.taken, of_file - readings_at(problem, state.p, state.z), 0.0)
    gap = np.abs(np.where(readings.turning, wrapped(gap), gap))
    known = _READING_AGREEMENT[0] * readings.sigma if readings.known else 0.0
    off = np.any(~(gap <= np.maximum(known, _READING_AGREEMENT[1] * units)), axis=1)
    if off.any():
        yield (
            f"the file that would be written does not give the readings that the fit does at "
            f"{_row_names(problem.measurements, off)}: "
            f"they differ by up to {np.nanmax(gap / units):.2g} of the size"
        )


def _row_names(m: Measurements, which: np.ndarray) -> str:
    """Name rows: 'posture line 3, line 9 and 12 more'."""
    return f"posture {first_of(m.named(which), 3)}"
