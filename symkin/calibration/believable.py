"""Is a fit believable? Each doubt is one sentence with its figure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from symkin.calibration.motions import all_values
from symkin.calibration.parallel_axes import nearly_parallel
from symkin.calibration.plausible import FAR, beyond_tolerance, moved_far
from symkin.calibration.residuals import only_rounding
from symkin.calibration.statistics import UNLIKELY

if TYPE_CHECKING:
    from symkin.calibration.result import Calibration

_ILL = 1e6
"""Condition of the identification Jacobian above which digits of the parameters are lost."""
_NAMED = 5


def believe(fit: Calibration, *, removed: bool) -> Iterator[str]:
    """Doubts and facts about a fit that its reader must know."""
    yield from _postures(fit)
    yield from _fit(fit)
    yield from _rank(fit)
    for o in fit.outliers:
        yield ("left out: " if removed else "outlier: ") + o.reason
    if fit.given_up:
        yield (
            f"so many readings do not belong, {len(fit.given_up)} and more, that none was left out: the readings or the model are "
            f"wrong as a whole; the first was {fit.given_up[0].reason}"
        )
    if fit.unchecked:
        yield f"nothing else checks {listed([f'{kind} of posture {fit.measurements.labels[k]}' for k, kind in fit.unchecked])}"


def _postures(fit: Calibration) -> Iterator[str]:
    labels = fit.measurements.labels
    if fit.unsolved:
        yield (
            f"not used: the direct problem of posture {listed([labels[k] for k in fit.unsolved])} was not solved, neither at "
            "the nominal nor at the identified geometry; check the joint readings or give starts"
        )
    judged = {o.posture for o in (*fit.outliers, *fit.given_up)}
    silent = [labels[k] for k in fit.silent if k not in judged]
    if silent:
        yield f"not used: posture {listed(silent)} holds no reading beside the joints (a group of two postures or more, or a sensor's)"
    if fit.changed_mode:
        yield f"posture {listed([labels[k] for k in fit.changed_mode])} crossed a singularity and changed its assembly mode"
    groups = fit.measurements.groups
    if groups is not None:
        numbers, counts = np.unique(groups[groups >= 0], return_counts=True)
        if np.any(counts == 1):
            yield f"group {listed([str(g) for g in numbers[counts == 1]])} has one posture and says nothing"


def _fit(fit: Calibration) -> Iterator[str]:
    if fit.status != "ok":
        yield f"the iteration ended with {fit.status} after {fit.iterations} steps; the values are not a minimum"
    if fit.degrees <= 0:
        yield "there are no degrees of freedom left: the residuals are zero for any noise and nothing is checked; add postures"
    elif fit.p_value is None:
        yield "standard deviations are missing: those of the parameters are scaled by the residuals, and chi-square tests nothing"
    elif fit.p_value < UNLIKELY:
        ratio = fit.chi_square / fit.degrees
        yield (
            f"not believable with the stated noise: chi-square per degree of freedom is {ratio:.3g}, probability {fit.p_value:.1g}; "
            "the noise is larger than stated or the model lacks something"
        )
    elif 1.0 - fit.p_value < UNLIKELY:
        yield (
            f"chi-square per degree of freedom is only {fit.chi_square / fit.degrees:.3g}: the stated noise is too large, and the "
            "standard deviations with it"
        )
    if is_exact(fit):
        yield "the residuals are rounding only: is this a plan, or a simulation without noise?"
    yield from (f"{name} moved by {times:.3g} times its tolerance" for name, times in beyond_tolerance(fit)[:_NAMED])
    far = [p.name for p in moved_far(fit)]
    if far:
        yield f"{listed(far)} moved by more than {100 * FAR:.0f} % of the size (angles: {FAR} rad); check units and nominal values"


def is_exact(fit: Calibration) -> bool:
    """Whether the fit has degrees of freedom and yet leaves no residual above rounding: no instrument reads so."""
    size = fit.mechanism.size
    return fit.status == "ok" and fit.degrees > 0 and all(only_rounding(r.kind, r.value, size) for r in fit.residuals)


def _rank(fit: Calibration) -> Iterator[str]:
    found = fit.identifiability
    if not found.is_clear:
        yield f"the rank {found.rank} is not clear: singular values fall by a factor of only {found.gap:.3g} there{_parallel(fit)}"
    if found.condition > _ILL:
        yield f"the identification Jacobian has condition {found.condition:.2g}; {_parallel(fit)[2:] or 'choose postures that differ more'}"
    if found.unobservable:
        yield f"not observable, held by the least change from nominal: {'; '.join(found.unobservable)}"
    yield from found.advice


def _parallel(fit: Calibration) -> str:
    """What nearly parallel axes have to do with a rank that is not clear."""
    pairs = nearly_parallel(fit.mechanism, all_values(fit.problem.model, fit.state.p))
    free = {n for n in fit.problem.names if n.endswith(".d")}
    if not pairs or len(free) < 2:
        return ""
    return f"; {', '.join(pairs)} are parallel axes or nearly so, and their offsets d are told by how little they are not: hold one of each pair"


def listed(items: list[str]) -> str:
    """The first few of some names, and how many more there are."""
    more = len(items) - _NAMED
    return ", ".join(items[:_NAMED]) + (f" and {more} more" if more > 0 else "")
