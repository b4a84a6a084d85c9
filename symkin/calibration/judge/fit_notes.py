"""Note doubts and facts about a fit that its reader must know."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.estimate.residuals import only_rounding
from symkin.calibration.judge.named_directions import all_values, nearly_parallel
from symkin.calibration.judge.result import EXPECTED_TOLERANCES, Calibration, Parameter
from symkin.calibration.judge.statistics import SIGNIFICANCE
from symkin.text import first_of

LARGE_CHANGE = 0.2
"""A change of a parameter by more than this share of the size (angles: radians) is no correction of
a nominal geometry.
"""
_NAMED_TOLERANCES = 5
"""Parameters beyond their tolerances that are named at most."""
_MAX_CONDITION = 1e6
"""Condition of the identification Jacobian above which digits of the parameters are lost."""
NOT_CHECKED = "no degree of freedom is left to check it; add postures"
EXACT = "the residuals are rounding only: is this a plan, or a simulation without noise?"


def is_exact(fit: Calibration) -> bool:
    """Tell whether the fit has degrees of freedom and yet leaves no residual above rounding: no
    instrument reads so.
    """
    size = fit.mechanism.characteristic_length
    rounding = all(only_rounding(r.value, 1.0 if r.angular else size) for r in fit.residuals)
    return fit.status == "ok" and fit.degrees > 0 and rounding


def not_converged(fit: Calibration) -> str:
    return f"the fit did not converge ({fit.status})"


def chi_square_doubt(fit: Calibration) -> Iterator[str]:
    """Say why chi-square is not as the stated noise lets expect."""
    ratio, p = fit.chi_square / max(fit.degrees, 1), fit.p_value
    if p is not None and p <= SIGNIFICANCE:
        yield (
            f"chi-square per degree of freedom is {ratio:.3g}, probability {p:.1g}; noise larger "
            f"than stated, outliers, or a model that lacks something"
        )
    elif p is not None and 1.0 - p <= SIGNIFICANCE:
        yield (
            f"chi-square per degree of freedom is only {ratio:.3g}; the stated noise is too large, "
            f"and the standard deviations with it"
        )


def large_changes(fit: Calibration) -> list[Parameter]:
    """List free parameters that moved by more than `LARGE_CHANGE`; measuring frames have no nominal
    place.
    """
    free = (p for p in fit.parameters if not p.held and p.name not in MEASURING_FRAMES)
    return [p for p in free if fit.relative_change(p) > LARGE_CHANGE]


def fit_notes(fit: Calibration, *, removed: bool) -> Iterator[str]:
    """Yield doubts and facts about a fit; `removed` says whether its outliers were left out."""
    yield from _notes_on_postures(fit)
    yield from _notes_on_residuals(fit)
    yield from _notes_on_parameters(fit)
    for o in fit.outliers:
        yield ("left out: " if removed else "outlier: ") + o.reason
    if fit.given_up:
        yield (
            f"so many readings do not belong, {len(fit.given_up)} and more, that none was left "
            f"out: the readings or the model are wrong as a whole; the first was "
            f"{fit.given_up[0].reason}"
        )
    if fit.unchecked:
        alone = [f"{kind} of posture {fit.measurements.labels[k]}" for k, kind in fit.unchecked]
        yield f"nothing else checks {first_of(alone)}"


def _notes_on_postures(fit: Calibration) -> Iterator[str]:
    judged = {o.configuration for o in (*fit.outliers, *fit.given_up)}
    silent = [k for k in fit.silent if k not in judged]

    def named(numbers: Iterable[int]) -> str:
        return f"posture {first_of([fit.measurements.labels[k] for k in numbers])}"

    if fit.unsolved:
        yield (
            f"not used: the direct problem of {named(fit.unsolved)} was not solved, neither at the "
            f"nominal nor at the identified geometry; check the joint readings or give starts"
        )
    if silent:
        yield (
            f"not used: {named(silent)} holds no reading beside the joints (a group of two "
            f"postures or more, or a sensor's)"
        )
    if fit.changed_mode:
        yield f"{named(fit.changed_mode)} crossed a singularity and changed its assembly mode"
    groups = fit.measurements.groups
    if groups is not None:
        numbers, counts = np.unique(groups[groups >= 0], return_counts=True)
        if single := [str(g) for g in numbers[counts == 1]]:
            yield f"group {first_of(single)} has one posture and says nothing"


def _notes_on_residuals(fit: Calibration) -> Iterator[str]:
    if fit.status != "ok":
        yield f"{not_converged(fit)}, after {fit.iterations} steps; the values are not a minimum"
    if fit.degrees <= 0:
        yield f"{NOT_CHECKED}: the residuals are zero for any noise"
    elif fit.p_value is None:
        yield (
            "standard deviations are missing: those of the parameters are scaled by the residuals, "
            "and chi-square tests nothing"
        )
    yield from (f"not believable with the stated noise: {text}" for text in chi_square_doubt(fit))
    if is_exact(fit):
        yield EXACT


def _notes_on_parameters(fit: Calibration) -> Iterator[str]:
    found, beyond = fit.identifiability, dict(fit.changes_over_tolerances)
    for name in sorted(beyond, key=lambda name: -abs(beyond[name]))[:_NAMED_TOLERANCES]:
        if abs(beyond[name]) > EXPECTED_TOLERANCES:
            yield f"{name} moved by {abs(beyond[name]):.3g} times its tolerance"
    if far := [p.name for p in large_changes(fit)]:
        yield (
            f"{first_of(far)} moved by more than {100 * LARGE_CHANGE:.0f} % of the size (angles: "
            f"{LARGE_CHANGE} rad); check units and nominal values"
        )
    pairs = nearly_parallel(fit.mechanism, all_values(fit.problem.model, fit.state.p))
    offsets = [n for n in fit.problem.names if n.endswith(".d")]
    parallel = (
        f"{', '.join(pairs)} are parallel axes or nearly so, and their offsets d are told by how "
        f"little they are not: hold one of each pair"
        if pairs and len(offsets) > 1
        else ""
    )
    if found.weak:
        text, share = found.weak[0]
        yield (
            f"hardly told by the readings, and held near nominal by the prior: {len(found.weak)} "
            f"combination{'s' * (len(found.weak) != 1)} of parameters, most of all {text}, whose "
            f"standard deviation by the readings is {share:.2g} of the prior's"
            f"{parallel and f'; {parallel}'}"
        )
    if found.condition > _MAX_CONDITION:
        remedy = parallel or "choose postures that differ more"
        yield f"the identification Jacobian has condition {found.condition:.2g}; {remedy}"
    if found.unobservable:
        held = "; ".join(found.unobservable)
        yield f"not observable, held by the least change from nominal: {held}"
    yield from found.advice
