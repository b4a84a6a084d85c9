"""Judge a fit: whether it is a calibration, what speaks against it, and what its reader must know.

Noise that is stated too small or a model that lacks something leaves residuals some times as large
as expected; such a fit is not believable, and yet nearer to the truth than nominal. Readings that
mean something else (columns exchanged, a sign, another sequence) leave residuals far beyond any
noise, and move the geometry by a large share of its size to reach even these: not usable.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symkin.calibration.data.observables import measure_of, written
from symkin.calibration.estimate.residuals import only_rounding
from symkin.calibration.judge.identifiability import OPEN_LOOPS, all_values, nearly_parallel
from symkin.calibration.judge.result import (
    EXPECTED_TOLERANCES,
    Calibration,
    Parameter,
    length_and_angle,
)
from symkin.calibration.judge.statistics import SIGNIFICANCE
from symkin.computed_once import cached_property
from symkin.text import first_of

if TYPE_CHECKING:
    from symkin.calibration.judge.accuracy import HeldOut, PoseSigma
    from symkin.calibration.judge.trials import SequenceChoice

_MAX_NOISE_RATIO = 30.0
"""Residuals larger than so many times the noise stated do not come from noise: an instrument's is
known better than to a factor of ten.
"""
_COARSE_LENGTH, _COARSE_ANGLE = 1e-3, 0.02
"""Where no noise is stated, lengths that are off by more than the first, of the size, and angles by
more than the second (radians) are coarser than any instrument that calibrates: tapes and cameras.
"""
_UNEXPLAINED_SHARE = 0.5
"""Residuals of a kind above this share of the nominal geometry's say that the parameters do not
explain its readings.
"""
_NAMED_CHANGES = 3
"""Largest changes that a sentence names."""
_MAX_OUTSIDE_SHARE = 0.2
"""Share of the workspace's poses beyond the measured joint values that is worth a note."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """A fit with what bears on it: the Euler sequence that was found, mistakes that may explain
    readings which do not fit, the pose's standard deviation, predictions of postures held out, the
    misfits of the nominal geometry by kind, and notes on the data. `objections` is all that speaks
    against the fit, the gravest first; what follows is read from it.
    """

    fit: Calibration
    sequence: SequenceChoice | None
    suspicions: tuple[str, ...]
    sigma: PoseSigma
    held_out: HeldOut | None
    at_nominal: Mapping[str, float]
    notes: tuple[str, ...]

    @cached_property
    def objections(self) -> tuple[tuple[bool, str], ...]:
        """Whether a fit may be used in spite of each objection, and the sentence."""
        grave = ((False, text) for text in self._grave())
        return (*grave, *((True, text) for text in self._doubts()))

    def _grave(self) -> Iterator[str]:
        fit = self.fit
        if fit.status != "ok":
            yield not_converged(fit)
        if fit.identifiability.opens:
            yield OPEN_LOOPS
        # of one posture the poses are those measured, whatever the parameters are
        alone = len(fit.used) == 1 and fit.rank < len(fit.identifiability.names)
        if self.sigma.blind or fit.rank == 0 or alone:
            yield "the readings do not determine the geometry; see what is not observable"
        yield from filter(None, (self.refusal, fit.refused))

    def _doubts(self) -> Iterator[str]:
        fit, held = self.fit, self.held_out
        yield from self.suspicions[:1]
        if fit.degrees <= 0:
            yield NOT_CHECKED
        elif fit.p_value is not None and is_exact(fit):
            yield EXACT
        else:
            yield from chi_square_doubt(fit)
        if (r := fit.stray) is not None:
            yield (
                f"{r.kind} {r.component} of posture {fit.measurements.labels[r.configuration]} is "
                f"off by {abs(r.normalised or 0.0):.3g} standard deviations, and was kept"
            )
        if fit.given_up:
            yield "too many readings do not belong; see the notes"
        if fit.unsolved:
            yield f"{len(fit.unsolved)} of {len(fit.measurements)} postures do not close"
        if held is not None and not held.believable:
            yield held.doubt
        if self.sequence is not None and not self.sequence.clear:
            yield "these data cannot tell the Euler sequence: several fit almost equally"

    @cached_property
    def refusal(self) -> str | None:
        """Why the readings fit no geometry near the file's, None where they do."""
        fit, found, suspected = self.fit, self.fit.identifiability, self.suspicions[:1]
        if suspected and found.drowned.shape[1]:
            told = f"{found.rank} of {len(found.names)} parameters"
            return f"the readings tell {told} beside their noise; {suspected[0]}"
        why = next(filter(None, map(self._misfit_reason, noise_excess(fit).items())), None)
        misplaced = fit.is_other_machine or (suspected and fit.is_noticeable)
        misplaced = misplaced and not fit.any_machine
        return why or (_other_machine(fit, suspected) if misplaced else None)

    def _misfit_reason(self, excess: tuple[str, str]) -> str | None:
        """Say why residuals of a kind, beyond any noise, fit no geometry, None where they may fit
        one that the model does not know.
        """
        fit, (kind, beyond) = self.fit, excess
        if (moved := large_changes(fit)) and fit.is_noticeable:
            largest = moved[0]
            how = {"length": "of the size", "angle": "of a radian"}.get(largest.kind, "of one")
            return (
                f"{beyond}, although {largest.name} moved by "
                f"{100 * fit.relative_change(largest):.0f} % {how}: no geometry near the nominal "
                f"one fits these readings"
            )
        misfit, before = fit.misfits[kind], self.at_nominal.get(kind, math.inf)
        if misfit > _UNEXPLAINED_SHARE * before:
            measure = measure_of(fit.mechanism, kind)
            here, there = (written(fit.mechanism, measure, v, ".3g") for v in (misfit, before))
            return (
                f"{beyond}, hardly less than those of the nominal geometry ({here} after {there}): "
                f"the parameters do not explain the readings"
            )
        return beyond if self.suspicions else None

    @property
    def usable(self) -> bool:
        """Whether the fit converged, every combination that moves poses was observable, and the
        readings fit the geometry.
        """
        return all(usable for usable, _ in self.objections)

    @property
    def sound(self) -> bool:
        """Whether nothing speaks against the fit."""
        return not self.objections

    @property
    def tested(self) -> bool:
        """Whether the fit was tested: by the noise stated, or by postures held out."""
        return self.fit.tested or self._predicted > 0

    @property
    def believable(self) -> bool:
        return self.sound and self.tested

    @property
    def _predicted(self) -> int:
        """How many postures were held out and predicted with a probability."""
        held = self.held_out
        return 0 if held is None or held.p_value is None else len(held.labels)

    @property
    def verdict(self) -> str:
        """One sentence: believable, not tested, or why not."""
        if self.objections:
            usable, why = self.objections[0]
            cause = self.suspicions[0] if self.suspicions else ""
            besides = "" if usable or cause in why else f"; {cause}"
            return f"NOT {'BELIEVABLE' if usable else 'USABLE'}: {why}{besides}"
        other = f"; {_other_machine(self.fit)}" if self.fit.is_other_machine else ""
        if not self.tested:
            return (
                f"NOT TESTED: converged; the noise is not known and no posture was held out, so "
                f"that nothing says whether it is right: state standard deviations or take "
                f"--hold-out 20%{other}"
            )
        sure, link = "the residuals are as the stated noise lets expect", "and"
        if self.fit.p_value is None:
            sure, link = "the noise is not known", "but"
        if self._predicted:
            sure += (
                f", {link} {self._predicted} held-out postures are predicted as well as it lets "
                f"expect"
            )
        return f"believable: {sure}{other}"

    # --- notes ------------------------------------------------------------------------------------

    @property
    def all_notes(self) -> tuple[str, ...]:
        """All notes, those on the data first."""
        told = [] if self.sequence is None else [self.sequence.text(fits=self.fits)]
        return (*told, *self.suspicions, *self._beyond(), *self.notes, *self.fit.notes)

    @property
    def fits(self) -> bool:
        """Whether the readings fit some geometry, all of it observable or not."""
        return self.fit.status == "ok" and self.refusal is None

    def _beyond(self) -> Iterator[str]:
        """Say what is known of poses outside the measured configurations, where they are many."""
        sigma, unit = self.sigma.about_home, self.fit.mechanism.length_unit
        if sigma is None or not self.usable or sigma.outside.mean() <= _MAX_OUTSIDE_SHARE:
            return
        there, inside = (
            sigma.position[part].max(initial=0.0) for part in (sigma.outside, ~sigma.outside)
        )
        elsewhere = "" if sigma.outside.all() else f" and {inside:.3g} {unit} elsewhere"
        yield (
            f"{sigma.outside.sum()} of {len(sigma.outside)} poses of the workspace about "
            f"home need joint values beyond those measured: the largest standard deviation of the "
            f"position is {there:.3g} {unit} there{elsewhere}; no reading has tested the model "
            f"there; measure as far as the mechanism is used"
        )


# --- residuals ------------------------------------------------------------------------------------


def noise_excess(fit: Calibration) -> dict[str, str]:
    """Say of each kind of reading by how much its residuals are beyond noise, nothing where they
    are not.
    """
    m, found, keys = fit.mechanism, dict[str, str](), np.array(fit.problem.model.keys)
    stated = {o.key for o, r in fit.measurements.channels(m) if r.sigma is not None}
    spread = 1.0 if fit.tested else fit.chi_square / max(fit.degrees, 1)
    squares = spread * fit.table("normalised") ** 2
    for kind, misfit in fit.misfits.items():
        measure, said = measure_of(m, kind), f"the residuals of {kind} are"
        unit, coarse = m.characteristic_length, _COARSE_LENGTH
        if measure == "angle":
            unit, coarse = 1.0, _COARSE_ANGLE
        own = squares[:, keys == kind]
        times = math.sqrt(np.mean(own[np.isfinite(own)])) if np.isfinite(own).any() else 0.0
        if kind in stated and times > _MAX_NOISE_RATIO:
            found[kind] = f"{said} {times:.3g} times as large as the noise stated"
        elif kind not in stated and misfit > coarse * unit:
            share = f" ({100 * misfit / unit:.2g} % of the size)" if measure == "length" else ""
            found[kind] = f"{said} {written(m, measure, misfit, '.3g')}{share}"
    return found


# --- changes --------------------------------------------------------------------------------------


def _other_machine(fit: Calibration, suspicions: Sequence[str] = ()) -> str:
    """Describe a geometry far from the file's, first what would explain it."""
    m, departure = fit.mechanism, fit.departure
    unclosed, cause = "", f"{suspicions[0]}; its" if suspicions else "its"
    if departure.unclosed:
        unclosed = (
            f"; {departure.unclosed} of {departure.configurations} postures the file's geometry "
            f"cannot take there"
        )
    away = length_and_angle(m, departure.position, departure.angle)
    return (
        f"another machine than {m.name} describes: {cause} poses are {100 * departure.share:.2g} % "
        f"of their spread away from the file's at the same joint readings "
        f"({away} rms, frames aligned{unclosed}); largest changes: "
        f"{fit.largest_changes(_NAMED_CHANGES)}; for a machine that is so, state --tolerance or "
        f"--any-machine"
    )


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
    """List free parameters that moved by more than `LARGE_CHANGE`, furthest first."""
    return [p for p in fit.free if fit.relative_change(p) > LARGE_CHANGE]


def fit_notes(fit: Calibration, *, removed: bool) -> Iterator[str]:
    """Yield doubts and facts about a fit; `removed` says whether its outliers were left out."""
    yield from _notes_on_postures(fit)
    if fit.status != "ok":
        yield f"{not_converged(fit)}, after {fit.iterations} steps; the values are not a minimum"
    if fit.degrees <= 0:
        yield f"{NOT_CHECKED}: the residuals are zero for any noise"
    elif fit.p_value is None:
        read = fit.measurements.channels(fit.mechanism)
        unstated = [o.name or o.kind for o, reading in read if reading.sigma is None]
        yield (
            f"standard deviations of {first_of(unstated)} are missing: those of the parameters are "
            f"scaled by the residuals, and chi-square tests nothing"
        )
        if estimated := fit.problem.estimated:
            values = [
                f"{o.name or o.kind} {written(fit.mechanism, o.measure, estimated[o.key], '.3g')}"
                for o, _ in read
                if o.key in estimated
            ]
            yield (
                f"readings are weighed by standard deviations estimated from the residuals: "
                f"{', '.join(values)}"
            )
    yield from (f"not believable with the stated noise: {text}" for text in chi_square_doubt(fit))
    if is_exact(fit):
        yield EXACT
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

    def named(numbers: Sequence[int]) -> str:
        return f"posture {first_of(fit.measurements.named(numbers))}"

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
