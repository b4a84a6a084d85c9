"""Decide whether a converged fit is a calibration, or a geometry bent until wrong readings fit as
well as they can.

Noise that is stated too small or a model that lacks something leaves residuals some times as large
as expected; such a fit is not believable, and yet nearer to the truth than nominal. Readings that
mean something else (columns exchanged, a sign, another sequence) leave residuals far beyond any
noise, and move the geometry by a large share of its size to reach even these.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.judge.result import (
    EXPECTED_TOLERANCES,
    Calibration,
    Parameter,
    Residual,
)
from symkin.calibration.judge.statistics import rms_of_better_part

LARGE_CHANGE = 0.2
"""A change of a parameter by more than this share of the size (angles: radians) is no correction of
a nominal geometry.
"""
MAX_NOISE_RATIO = 30.0
"""Residuals larger than so many times the noise stated do not come from noise: an instrument's is
known better than to a factor of ten.
"""
_MAX_RESIDUAL_SHARE = 1e-3
"""Where no noise is stated, residuals above this share of the size are coarser than any instrument
that calibrates.
"""
_UNEXPLAINED_SHARE = 0.5
"""Residuals above this share of the nominal geometry's say that the parameters do not explain the
readings.
"""
_NAMED_CHANGES = 3
"""Largest changes that a sentence names."""


def rejection_reason(
    fit: Calibration,
    at_nominal: float,
    suspicions: Sequence[str],
) -> str | None:
    """Say why a converged fit is not to be used, None where nothing speaks against it; `at_nominal`
    is the misfit of the nominal geometry (see `residual_misfit`).
    """
    found = fit.identifiability
    if suspicions and found.drowned.shape[1]:
        told = f"{found.rank} of {len(found.names)} parameters"
        return f"the readings tell {told} beside their noise; {suspicions[0]}"
    beyond = _noise_excess(fit)
    misplaced = fit.is_other_machine or (bool(suspicions) and fit.is_noticeable)
    if beyond is not None:
        why = _misfit_reason(fit, beyond, at_nominal, suspicions)
        if why is not None:
            return why
    return describe_other_machine(fit, suspicions) if misplaced and not fit.any_machine else None


def _misfit_reason(
    fit: Calibration, beyond: str, at_nominal: float, suspicions: Sequence[str]
) -> str | None:
    """Say why residuals beyond any noise fit no geometry, None where they may fit one that the
    model does not know.
    """
    moved = large_changes(fit)
    if moved:
        largest = max(moved, key=lambda p: fit.relative_change(p))
        how = (
            "of the size"
            if largest.kind == "length"
            else "of a radian"
            if largest.kind == "angle"
            else "of one"
        )
        return (
            f"{beyond}, although {largest.name} moved by "
            f"{100 * fit.relative_change(largest):.0f} % {how}: no geometry near the nominal one "
            f"fits "
            "these readings"
        )
    misfit = residual_misfit(fit.residuals, fit.mechanism.characteristic_length)
    if misfit > _UNEXPLAINED_SHARE * at_nominal:
        unit = fit.mechanism.length_unit
        return (
            f"{beyond}, hardly less than those of the nominal geometry ({misfit:.3g} {unit} after "
            f"{at_nominal:.3g} {unit}, angles times "
            "the size): the parameters do not explain the readings"
        )
    return beyond if suspicions else None


def beyond_tolerances(fit: Calibration) -> list[tuple[str, float]]:
    """List parameters that moved by more tolerances than expected, largest first, with how many."""
    found = [
        (name, abs(z)) for name, z in fit.changes_over_tolerances if abs(z) > EXPECTED_TOLERANCES
    ]
    return sorted(found, key=lambda pair: -pair[1])


def describe_other_machine(fit: Calibration, suspicions: Sequence[str] = ()) -> str:
    """Describe a geometry far from the file's, first what would explain it."""
    m, departure = fit.mechanism, fit.departure
    free = [p for p in fit.parameters if not p.held]
    largest = sorted(free, key=lambda p: -fit.relative_change(p))[:_NAMED_CHANGES]
    changes = ", ".join(
        f"{p.name} {m.angle_out(p.change):+.3g} {m.angle_unit}"
        if p.kind == "angle"
        else f"{p.name} {p.change:+.3g}{f' {m.length_unit}' if p.kind == 'length' else ''}"
        for p in largest
    )
    unclosed = (
        f"; {departure.unclosed} of {departure.configurations} postures the file's geometry cannot "
        f"take there"
        if departure.unclosed
        else ""
    )
    cause = f"{suspicions[0]}; its" if suspicions else "its"
    return (
        f"another machine than {m.name} describes: {cause} poses are {100 * departure.share:.2g} % "
        f"of their spread away from the file's at the same "
        f"joint readings ({departure.position:.3g} {m.length_unit} and "
        f"{m.angle_out(departure.angle):.3g} {m.angle_unit} rms, frames aligned{unclosed}); "
        f"largest changes: {changes}; for a machine that is so, state --tolerance or --any-machine"
    )


def is_beyond_noise(fit: Calibration) -> bool:
    """Tell whether residuals are larger than any noise would make them."""
    return _noise_excess(fit) is not None


def large_changes(fit: Calibration) -> list[Parameter]:
    """List free parameters that moved by more than `LARGE_CHANGE`; measuring frames have no nominal
    place.
    """
    return [
        p
        for p in fit.parameters
        if not p.held and p.name not in MEASURING_FRAMES and fit.relative_change(p) > LARGE_CHANGE
    ]


def residual_misfit(residuals: Iterable[Residual], size: float) -> float:
    """Return the root mean square of a configuration's residuals, angles times the size (length
    unit), over the better four fifths.
    """
    squares: dict[int, float] = {}
    for r in residuals:
        squares[r.configuration] = (
            squares.get(r.configuration, 0.0) + (r.value * (size if r.angular else 1.0)) ** 2
        )
    return rms_of_better_part(np.array(list(squares.values())))


def _noise_excess(fit: Calibration) -> str | None:
    """Say how far residuals are beyond noise, None where they are not."""
    if fit.p_value is not None and fit.degrees > 0:
        times = math.sqrt(fit.chi_square / fit.degrees)
        return (
            f"the residuals are {times:.3g} times as large as the noise stated"
            if times > MAX_NOISE_RATIO
            else None
        )
    share = (
        residual_misfit(fit.residuals, fit.mechanism.characteristic_length)
        / fit.mechanism.characteristic_length
    )
    return (
        f"the residuals are {100 * share:.2g} % of the size"
        if share > _MAX_RESIDUAL_SHARE
        else None
    )
