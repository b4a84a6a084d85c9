"""Note doubts and facts about a fit that its reader must know: `RULES` is the table of what is
looked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from symkin.calibration.estimate.residuals import only_rounding
from symkin.calibration.judge.named_directions import all_values, nearly_parallel
from symkin.calibration.judge.plausibility import LARGE_CHANGE, beyond_tolerances, large_changes
from symkin.calibration.judge.result import Calibration
from symkin.calibration.judge.statistics import SIGNIFICANCE
from symkin.text import first_of

_MAX_NAMED_TOLERANCES = 5
"""Parameters beyond their tolerances that are named at most."""
_MAX_CONDITION = 1e6
"""Condition of the identification Jacobian above which digits of the parameters are lost."""


@dataclass(frozen=True)
class Rule:
    """A doubt or a fact that is looked for: `sentences` yields what is said of a fit, each sentence
    with its figure.
    """

    about: str
    sentences: Callable[[Calibration], Iterable[str]]


def fit_notes(fit: Calibration, *, removed: bool) -> Iterator[str]:
    """Yield all notes on a fit; `removed` says whether its outliers were left out."""
    for rule in RULES:
        yield from rule.sentences(fit)
    for o in fit.outliers:
        yield ("left out: " if removed else "outlier: ") + o.reason
    if fit.given_up:
        yield (
            f"so many readings do not belong, {len(fit.given_up)} and more, that none was left "
            f"out: the readings or the model are "
            f"wrong as a whole; the first was {fit.given_up[0].reason}"
        )
    if fit.unchecked:
        alone = [f"{kind} of posture {fit.measurements.labels[k]}" for k, kind in fit.unchecked]
        yield f"nothing else checks {first_of(alone)}"


def is_exact(fit: Calibration) -> bool:
    """Tell whether the fit has degrees of freedom and yet leaves no residual above rounding: no
    instrument reads so.
    """
    size = fit.mechanism.characteristic_length
    return (
        fit.status == "ok"
        and fit.degrees > 0
        and all(only_rounding(r.value, 1.0 if r.angular else size) for r in fit.residuals)
    )


# --- configurations -------------------------------------------------------------------------------


def _unsolved(fit: Calibration) -> Iterator[str]:
    if fit.unsolved:
        yield (
            f"not used: the direct problem of posture {_labelled(fit, fit.unsolved)} was not "
            f"solved, neither at "
            "the nominal nor at the identified geometry; check the joint readings or give starts"
        )


def _silent(fit: Calibration) -> Iterator[str]:
    judged = {o.configuration for o in (*fit.outliers, *fit.given_up)}
    silent = [k for k in fit.silent if k not in judged]
    if silent:
        yield (
            f"not used: posture {_labelled(fit, silent)} holds no reading beside the joints (a "
            f"group of two postures or more, or a sensor's)"
        )


def _changed_mode(fit: Calibration) -> Iterator[str]:
    if fit.changed_mode:
        yield (
            f"posture {_labelled(fit, fit.changed_mode)} crossed a singularity and changed its "
            f"assembly mode"
        )


def _single_groups(fit: Calibration) -> Iterator[str]:
    groups = np.zeros(0, dtype=int) if fit.measurements.groups is None else fit.measurements.groups
    numbers, counts = np.unique(groups[groups >= 0], return_counts=True)
    if np.any(counts == 1):
        yield (
            f"group {first_of([str(g) for g in numbers[counts == 1]])} has one posture and says "
            f"nothing"
        )


def _labelled(fit: Calibration, numbers: Iterable[int]) -> str:
    return first_of([fit.measurements.labels[k] for k in numbers])


# --- residuals ------------------------------------------------------------------------------------


def _not_converged(fit: Calibration) -> Iterator[str]:
    if fit.status != "ok":
        yield (
            f"the iteration ended with {fit.status} after {fit.iterations} steps; the values are "
            f"not a minimum"
        )


def _chi_square(fit: Calibration) -> Iterator[str]:
    ratio = fit.chi_square / max(fit.degrees, 1)
    if fit.degrees <= 0:
        yield (
            "there are no degrees of freedom left: the residuals are zero for any noise and "
            "nothing is checked; add postures"
        )
    elif fit.p_value is None:
        yield (
            "standard deviations are missing: those of the parameters are scaled by the residuals, "
            "and chi-square tests nothing"
        )
    elif fit.p_value < SIGNIFICANCE:
        yield (
            f"not believable with the stated noise: chi-square per degree of freedom is "
            f"{ratio:.3g}, probability {fit.p_value:.1g}; "
            "the noise is larger than stated or the model lacks something"
        )
    elif 1.0 - fit.p_value < SIGNIFICANCE:
        yield (
            f"chi-square per degree of freedom is only {ratio:.3g}: the stated noise is too large, "
            f"and the "
            "standard deviations with it"
        )


def _rounding_only(fit: Calibration) -> Iterator[str]:
    if is_exact(fit):
        yield "the residuals are rounding only: is this a plan, or a simulation without noise?"


# --- parameters -----------------------------------------------------------------------------------


def _beyond_tolerances(fit: Calibration) -> Iterator[str]:
    for name, times in beyond_tolerances(fit)[:_MAX_NAMED_TOLERANCES]:
        yield f"{name} moved by {times:.3g} times its tolerance"


def _large_changes(fit: Calibration) -> Iterator[str]:
    if far := [p.name for p in large_changes(fit)]:
        yield (
            f"{first_of(far)} moved by more than {100 * LARGE_CHANGE:.0f} % of the size (angles: "
            f"{LARGE_CHANGE} rad); check units and "
            "nominal values"
        )


def _left_to_the_prior(fit: Calibration) -> Iterator[str]:
    if weak := fit.identifiability.weak:
        text, share = weak[0]
        yield (
            f"hardly told by the readings, and held near nominal by the prior: {len(weak)} "
            f"combination{'s' * (len(weak) != 1)} of parameters, most of all {text}, whose "
            f"standard deviation by the readings is {share:.2g} of the prior's{_parallel_axes(fit)}"
        )


def _poor_condition(fit: Calibration) -> Iterator[str]:
    found = fit.identifiability
    if found.condition > _MAX_CONDITION:
        remedy = _parallel_axes(fit)[2:] or "choose postures that differ more"
        yield f"the identification Jacobian has condition {found.condition:.2g}; {remedy}"


def _unobservable(fit: Calibration) -> Iterator[str]:
    if fit.identifiability.unobservable:
        yield (
            f"not observable, held by the least change from nominal: "
            f"{'; '.join(fit.identifiability.unobservable)}"
        )
    yield from fit.identifiability.advice


def _parallel_axes(fit: Calibration) -> str:
    """Say what nearly parallel axes have to do with a rank that is not clear."""
    pairs = nearly_parallel(fit.mechanism, all_values(fit.problem.model, fit.state.p))
    free = {n for n in fit.problem.names if n.endswith(".d")}
    if not pairs or len(free) < 2:
        return ""
    return (
        f"; {', '.join(pairs)} are parallel axes or nearly so, and their offsets d are told by how "
        f"little they are not: hold one of each pair"
    )


RULES = (
    Rule("configurations that are not solved", _unsolved),
    Rule("configurations without a reading beside the joints", _silent),
    Rule("configurations that crossed a singularity", _changed_mode),
    Rule("groups of one configuration", _single_groups),
    Rule("an iteration that did not converge", _not_converged),
    Rule("residuals and the noise stated", _chi_square),
    Rule("residuals that are rounding only", _rounding_only),
    Rule("parameters beyond their tolerances", _beyond_tolerances),
    Rule("parameters far from nominal", _large_changes),
    Rule("combinations that the prior decides", _left_to_the_prior),
    Rule("an ill-conditioned identification Jacobian", _poor_condition),
    Rule("combinations that no reading determines", _unobservable),
)
"""What is looked for, in the order of the notes."""
