"""Hold the result of a calibration: parameters with standard deviations, residuals, statistics and
notes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.observables import ParameterKind, unit_of, value_out, written
from symkin.calibration.data.parameters import MEASURING_FRAMES, with_parameters
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.state import State
from symkin.calibration.judge.departure import Departure
from symkin.calibration.judge.identifiability import Identifiability
from symkin.calibration.judge.outliers import Outlier
from symkin.calibration.judge.statistics import SIGNIFICANCE, chi_square_tail, misfits
from symkin.computed_once import cached_property
from symkin.model.mechanism import Mechanism
from symkin.position.solution import finite
from symkin.result import Result, Summary

OTHER_MACHINE_DEPARTURE, NOTICEABLE_DEPARTURE = 0.08, 0.02
"""A departure (see `departure`) by more than the first share is no correction of the machine that
the file describes, but another machine; one by more than the second is, where a mistake in the
columns would explain it. Tolerances of some per mille of the size leave some per mille, a nominal
geometry measured with a ruler two or three per cent.
"""
_NEGLIGIBLE_CHANGE = 0.03
"""Changes of all parameters below this share of the size (angles: radians) are the same machine,
although near singularities its poses may differ by much.
"""
EXPECTED_TOLERANCES = 6.0
"""Changes within so many of the tolerances stated are what the user expects, however far they
go.
"""
_FRAME_WORD = "frame"
"""Unobservable combinations with this word are frames: they move no pose against another."""


@dataclass(frozen=True)
class Parameter:
    """One identified parameter: nominal and identified value, standard deviation (0 where held;
    None where unknown: no degrees of freedom). Lengths in the mechanism's unit, angles in radians,
    numbers (directions, factors) plain.
    """

    name: str
    kind: ParameterKind
    nominal: float
    value: float
    sigma: float | None
    held: bool = False

    @property
    def change(self) -> float:
        return self.value - self.nominal


@dataclass(frozen=True, slots=True)
class Residual:
    """One reading less its model: configuration number, kind and component; `value` in radians or
    the length unit (a group's from its mean), `normalised` over the deviation that the reading's
    own noise and the fit leave it, None where that is next to nothing.
    """

    configuration: int
    kind: str
    component: str
    value: float
    sigma: float
    normalised: float | None
    angular: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Result):
    """The result of a calibration: parameters, their standard deviations, residuals, and what they
    rest on.

    `problem` holds what was fitted: the configurations `used` (numbers in `measurements`) without
    outliers.

    `covariance` is that of `parameters`, held ones 0, by slopes at the estimate: where directions
    are hardly told it holds for parameters, readings and poses, not for every combination of
    parameters (see docs/explanations/identifiability.md). `chi_square` has `degrees` of freedom and
    the tail probability `p_value` (None where standard deviations are unknown; they are then scaled
    by the fit). `unsolved` are configurations whose direct problem was not solved and
    `changed_mode` those that crossed a singularity on the way; none is dropped without being named.
    `given_up` are the first outliers of a fit where so many readings do not belong that none was
    left out, `silent` configurations without any reading beside the joints, which are not used. All
    figures are those of the file with the `corrected` geometry, written and read back (see
    `assessment`); `departure` says how far its poses went from the file's; `refused` says why it
    must not be written, None where nothing speaks against it. `plot()` draws the changes of the
    parameters, `plot(what="residuals")` the residuals.

    >>> import numpy as np, symkin
    >>> arm = symkin.load("gluon_6l3")
    >>> joints = np.radians(np.random.default_rng(1).uniform(-90.0, 90.0, (12, 6)))
    >>> tips = [symkin.solve(arm, joints=np.degrees(q)).solution.position for q in joints]
    >>> higher = np.array(tips) + [0.0, 0.0, 0.5]
    >>> readings = symkin.Measurements(joints, position=higher, position_sigma=0.01)
    >>> found = symkin.calibrate(arm, readings, parameters=["dh.1.d"])
    >>> round(found.values["dh.1.d"] - 105.03, 3)
    0.5
    """

    mechanism: Mechanism
    measurements: Measurements
    problem: CalibrationProblem
    state: State
    parameters: tuple[Parameter, ...]
    covariance: np.ndarray
    residuals: tuple[Residual, ...]
    chi_square: float
    degrees: int
    p_value: float | None
    departure: Departure
    identifiability: Identifiability
    outliers: tuple[Outlier, ...]
    unchecked: tuple[tuple[int, str], ...]
    used: tuple[int, ...]
    unsolved: tuple[int, ...]
    changed_mode: tuple[int, ...]
    poses: np.ndarray
    status: str
    iterations: int
    method: str = "nested"
    elapsed_s: float = 0.0
    notes: tuple[str, ...] = field(default=())
    given_up: tuple[Outlier, ...] = ()
    silent: tuple[int, ...] = ()
    refused: str | None = None
    any_machine: bool = False

    @cached_property
    def values(self) -> dict[str, float]:
        """Identified values by name."""
        return {p.name: p.value for p in self.parameters}

    @cached_property
    def corrected(self) -> Mechanism:
        """The mechanism with the identified geometry; factors of readings and measuring frames have
        no place in it.
        """
        return with_parameters(self.mechanism, self.values)

    @property
    def rank(self) -> int:
        return self.identifiability.rank

    @property
    def sound(self) -> bool:
        """Whether the fit converged, every configuration is solved, and nothing speaks against it:
        the stated noise, where it is, explains the residuals (neither larger nor smaller than
        expected), and none by itself is further off than chance allows; and it is the machine that
        the file describes, unless `any_machine` was asked for.
        """
        fits = self.p_value is None or SIGNIFICANCE < self.p_value < 1.0 - SIGNIFICANCE
        doubts = (
            self.unsolved,
            self.given_up,
            self.refused,
            self.stray,
            self.identifiability.opens,
            self.is_other_machine and not self.any_machine,
        )
        told = self.status == "ok" and self.rank > 0 and self.degrees > 0
        return told and fits and not any(doubts)

    @cached_property
    def stray(self) -> Residual | None:
        """The largest residual, where the noise stated does not explain it: among many others it
        hides from chi-square, and it bends the geometry.
        """
        judged = [(abs(r.normalised), r) for r in self.residuals if r.normalised is not None]
        if not self.tested or not judged:
            return None
        largest, worst = max(judged, key=lambda one: one[0])
        chance = len(judged) * chi_square_tail(largest**2, 1)
        return worst if chance < SIGNIFICANCE else None

    @cached_property
    def misfits(self) -> dict[str, float]:
        """Root mean square of the residuals by kind (radians, length unit), see `misfits`."""
        return misfits(self.table("value"), self.problem.model.keys)

    def table(self, what: Literal["value", "normalised"]) -> np.ndarray:
        """Return residuals by configuration and column (n, K), NaN where there is none."""
        columns = self.problem.model.columns
        found = np.full((len(self.measurements), len(columns)), np.nan)
        for r in self.residuals:
            found[r.configuration, columns.index((r.kind, r.component))] = getattr(r, what)
        return found

    @property
    def tested(self) -> bool:
        """Whether the residuals were tested, against the noise stated."""
        return self.p_value is not None

    @property
    def believable(self) -> bool:
        """Whether the fit is sound and tested: without a test nothing says whether it is right."""
        return self.sound and self.tested

    def relative_change(self, p: Parameter) -> float:
        """Return the change of a parameter over the size (lengths), in radians or plain."""
        return abs(p.change) / (self.mechanism.characteristic_length if p.kind == "length" else 1.0)

    @cached_property
    def free(self) -> list[Parameter]:
        """The free parameters of the geometry, those that changed most first; measuring frames have
        no nominal place.
        """
        free = (p for p in self.parameters if not p.held and p.name not in MEASURING_FRAMES)
        return sorted(free, key=self.relative_change, reverse=True)

    def largest_changes(self, most: int) -> str:
        """Write the largest changes, with their units."""
        m = self.mechanism
        return ", ".join(f"{p.name} {written(m, p.kind, p.change)}" for p in self.free[:most])

    @property
    def is_noticeable(self) -> bool:
        """Whether the geometry went so far that mistakes in the file are worth a search although it
        fits.
        """
        return self.departure.share > NOTICEABLE_DEPARTURE and any(
            self.relative_change(p) > _NEGLIGIBLE_CHANGE for p in self.parameters if not p.held
        )

    @property
    def is_other_machine(self) -> bool:
        """Whether the fit is of another machine than the file describes, and further away than the
        tolerances stated let expect.
        """
        changes = [abs(z) for _, z in self.changes_over_tolerances]
        within = self.problem.is_stated and max(changes, default=0.0) <= EXPECTED_TOLERANCES
        return self.departure.share > OTHER_MACHINE_DEPARTURE and not within and self.is_noticeable

    @property
    def changes_over_tolerances(self) -> list[tuple[str, float]]:
        """The changes of free parameters over the tolerances stated."""
        problem = self.problem
        changes = zip(problem.names, problem.over_prior(self.state.p), problem.prior, strict=True)
        return [(name, float(z)) for name, z, s in changes if problem.is_stated and np.isfinite(s)]

    @property
    def frames(self) -> tuple[str, ...]:
        """Unobservable combinations that are frames: they move no pose against another."""
        return tuple(text for text in self.identifiability.unobservable if _FRAME_WORD in text)

    @property
    def unobservable(self) -> tuple[str, ...]:
        """The other unobservable combinations of parameters."""
        return tuple(text for text in self.identifiability.unobservable if _FRAME_WORD not in text)

    def summary(self, most_rows: int | None = None) -> Summary:
        """The fit in one line, the parameters in the mechanism's units, and the notes."""
        p = "" if self.p_value is None else f", probability {self.p_value:.3g}"
        head = (
            f"{self.mechanism.name}: {self.status} after {self.iterations} iterations "
            f"({self.method}), "
            f"{len(self.used)} of {len(self.measurements)} postures; rank {self.rank} of "
            f"{len(self.problem.names)}; "
            f"chi-square {self.chi_square:.4g} with {self.degrees} degrees of freedom{p}"
        )
        rows = [self.row(q) for q in self.parameters]
        shown, notes = rows[:most_rows], [f"note: {note}" for note in self.notes]
        if len(shown) < len(rows):
            notes = [f"{len(rows) - len(shown)} more parameters", *notes]
        return Summary([head], ["parameter", "value", "sigma", "unit", "change"], shown, notes)

    def row(self, q: Parameter) -> list[str]:
        """Name, value, standard deviation, unit and change of a parameter, as texts."""
        one, unit = value_out(self.mechanism, q.kind, 1.0), unit_of(self.mechanism, q.kind)
        sigma = "held" if q.held else "unknown" if q.sigma is None else f"{one * q.sigma:.2g}"
        return [q.name, f"{one * q.value:.9g}", sigma, unit, f"{one * q.change:+.3g}"]

    def to_dict(self, *, residuals: bool = True) -> dict[str, Any]:
        """What `report.json` of `symkin calibrate fit` holds of the fit itself, with or without
        `residuals`; lengths in the mechanism's unit, angles in its angle unit.
        """
        m, labels, found = self.mechanism, self.measurements.labels, self.identifiability
        own = ("believable", "tested", "status", "iterations", "method")
        rows = ("unsolved", "silent", "changed_mode")
        return {
            "mechanism": m.name,
            "length_unit": m.length_unit,
            "angle_unit": m.angle_unit,
            **{key: getattr(self, key) for key in own},
            "postures": len(self.measurements),
            "used": len(self.used),
            **{key: [labels[k] for k in getattr(self, key)] for key in rows},
            "chi_square": finite(self.chi_square),
            "degrees": self.degrees,
            "p_value": finite(self.p_value),
            "rank": found.rank,
            "parameters_in_all": len(found.names),
            "condition": finite(found.condition),
            "base_set": list(found.base_set),
            "singular_values": found.singular_values.tolist(),
            "frames": list(self.frames),
            "unobservable": list(self.unobservable),
            "advice": list(found.advice),
            "parameters": [
                {
                    "name": q.name,
                    "unit": unit_of(m, q.kind) or "1",
                    "nominal": value_out(m, q.kind, q.nominal),
                    "value": value_out(m, q.kind, q.value),
                    "sigma": None if q.sigma is None else value_out(m, q.kind, q.sigma),
                    "held": q.held,
                }
                for q in self.parameters
            ],
            "outliers": [
                {"posture": o.label, "kind": o.kind, "reason": o.reason} for o in self.outliers
            ],
            "notes": list(self.notes),
            "elapsed_s": self.elapsed_s,
            "residuals": list(self.residual_rows()) if residuals else [],
        }

    def residual_rows(self) -> Iterator[dict[str, Any]]:
        """The residuals in JSON, one by one."""
        for r in self.residuals:
            yield {
                "posture": self.measurements.labels[r.configuration],
                "kind": r.kind,
                "component": r.component,
                "value": value_out(self.mechanism, "angle" if r.angular else "length", r.value),
                "normalised": finite(r.normalised),
            }


def length_and_angle(mechanism: Mechanism, length: float, angle: float) -> str:
    """Write '0.1 mm and 0.02 deg'."""
    turn = written(mechanism, "angle", float(angle), ".3g")
    return f"{written(mechanism, 'length', length, '.3g')} and {turn}"
