"""Read the corrected mechanism file back as its users will, and solve its direct problems at the rows measured.

The figures of a report are those of this file. `read_back` gives the state at the values that the file holds, and a sentence
where the file is not what was fitted: it cannot be read, a row does not close, a rod is inside out, a limit is passed, or a
reading comes out otherwise than in the fit by more than rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import is_writable, nominal_parameters, with_parameters
from symkin.calibration.estimate.configurations import newton_configurations
from symkin.calibration.estimate.model import ConfigurationModel, build_model
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import wrapped
from symkin.calibration.estimate.state import State, closed_state, joint_covariance
from symkin.errors import SymkinError
from symkin.model.file import parse
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism

_READING_AGREEMENT = (1e-3, 1e-9)
"""Readings of file and fit agree within this share of their standard deviations, or of the size (angles: radians)."""
_UNIT_VECTORS = (".axis", ".axis2", ".quaternion")
"""Vectors that a mechanism file holds at unit length."""
_LIMIT_SLACK = 1e-9
"""Limits may be passed by this share of the size (angles: radians), which is rounding."""


@dataclass(frozen=True, eq=False)
class WrittenGeometry:
    """The state at the values of the file that would be written, and why it must not be, None where nothing speaks against it."""

    state: State
    reason: str | None


def read_back(problem: CalibrationProblem, state: State) -> WrittenGeometry:
    """Write the mechanism at a state, read it, and compare its direct problems at the measured rows with the state's."""
    values = dict(zip(problem.names, map(float, state.p), strict=True))
    try:
        found = parse(with_parameters(problem.mechanism, values).to_toml())
        table = nominal_parameters(found)
    except SymkinError as error:
        return WrittenGeometry(state, f"the file with the identified geometry cannot be read ({error})")
    nominal = {name: float(value) for name, (value, *_) in nominal_parameters(problem.mechanism).items()}
    read = {name: float(value) for name, (value, *_) in table.items()}
    factors = _vector_lengths(nominal | values, read)
    p = np.array(
        [read[n] * factors.get(_vector(n), 1.0) if is_writable(problem.mechanism, n) else values[n] for n in problem.names]
    )
    with np.errstate(all="ignore"):
        noise = joint_covariance(problem, state) if problem.form == "maximum likelihood" else None
        here = closed_state(problem, p, state.z, problem.form, noise)
        return WrittenGeometry(here, _difference(problem, state, found, values))


def _vector(name: str) -> str:
    """Name the vector of which a parameter is a component."""
    return name.rpartition(".")[0]


def _vector_lengths(fitted: dict[str, float], read: dict[str, float]) -> dict[str, float]:
    """Return by how much the fit's directions and quaternions are longer than those of the file, which are of unit length: a
    set of parameters may hold one of their components."""
    vectors = {_vector(name) for name in read if _vector(name).endswith(_UNIT_VECTORS)}
    factors = {}
    for vector in vectors:
        names = [name for name in read if _vector(name) == vector]
        ours, theirs = (np.array([numbers[name] for name in names]) for numbers in (fitted, read))
        factors[vector] = float(ours @ theirs) / float(theirs @ theirs)
    return factors


def _difference(problem: CalibrationProblem, state: State, found: Mechanism, values: dict[str, float]) -> str | None:
    """Say the first thing in which the file is not what was fitted, None where there is none."""
    m = problem.measurements
    beside = {n: v for n, v in values.items() if not is_writable(problem.mechanism, n)}
    model, p = build_model(found, m, tuple(beside)), np.array(list(beside.values()))
    inside_out = next(_negative_rods(found, m, _actuated_values(found, m, beside)), None)
    if inside_out is not None:
        return inside_out
    z, solved = newton_configurations(model, state.z, m.joints, p)
    if not solved.all():
        return f"{_row_names(m, ~solved)} {_has_or_have(~solved)} no solution at the geometry that would be written"
    outside = next(_outside_limits(model, m, z), None)
    return outside or _disagreement(problem, state, model.evaluate(z, m.joints, p, problem.quaternions).readings)


def _disagreement(problem: CalibrationProblem, state: State, of_file: np.ndarray) -> str | None:
    """Say which row comes out otherwise from the file than in the fit, None where none does."""
    readings, size = problem.readings, problem.model.closure.size
    ours = problem.model.evaluate(state.z, problem.measurements.joints, state.p, problem.quaternions).readings
    units = np.where(problem.model.angular, 1.0, size)
    gap = np.where(readings.taken, np.abs(of_file - ours), 0.0)
    gap = np.where(readings.turning, np.abs(wrapped(gap)), gap)
    known = _READING_AGREEMENT[0] * readings.sigma if readings.known else np.zeros_like(gap)
    off = np.any(~(gap <= np.maximum(known, _READING_AGREEMENT[1] * units)), axis=1)
    if not off.any():
        return None
    return (
        f"the file that would be written does not give the readings that the fit does at {_row_names(problem.measurements, off)}: "
        f"they differ by up to {np.nanmax(gap / units):.2g} of the size"
    )


# --- physical ------------------------------------------------------------------------------------------------------


def _actuated_values(found: Mechanism, m: Measurements, beside: dict[str, float]) -> np.ndarray:
    """Return the values (n, a) of the actuated joints: readings times their factors."""
    return np.asarray(m.joints * [beside.get(f"{c.name}.scale", 1.0) for c in found.actuated])


def _negative_rods(found: Mechanism, m: Measurements, joints: np.ndarray) -> Iterator[str]:
    """Yield a sentence for each rod of negative length."""
    for k, c in enumerate(found.actuated):
        short = joints[:, k] < _least(c)
        if short.any():
            least = float(np.min(joints[:, k] - _least(c)))
            yield f"the rod of {c.name} would have a negative length at {_row_names(m, short)}, down to {least:.4g} {found.length_unit}"


def _outside_limits(model: ConfigurationModel, m: Measurements, z: np.ndarray) -> Iterator[str]:
    """Yield a sentence for each passive joint outside its limits; limits of actuated joints speak of the rows, not of the
    geometry."""
    places = {c.name: place.start for c, place in zip(model.system.unknowns, model.system.slices, strict=True)}
    for c in model.closure.role("passive"):
        if c.width == 1:
            values = z[:, places[c.name]]
            off = _beyond_limits(c, values, model.closure.size) | (values < _least(c))
            if off.any():
                yield f"the passive joint {c.name} would be outside its limits at {_row_names(m, off)}"


def _least(c: Coordinate) -> float:
    return -math.inf if c.least is None else c.least


def _beyond_limits(c: Coordinate, values: np.ndarray, size: float) -> np.ndarray:
    """Tell which values, angles by whole turns as near as may be, are outside the limits by more than rounding."""
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
