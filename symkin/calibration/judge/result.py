"""Hold the result of a calibration: parameters with standard deviations, residuals, statistics and notes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from symkin.caching import cached_property
from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import ParameterKind, with_parameters
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.state import State
from symkin.calibration.judge.identifiability import Identifiability
from symkin.calibration.judge.outliers import Outlier
from symkin.calibration.judge.statistics import SIGNIFICANCE
from symkin.model.mechanism import Mechanism


@dataclass(frozen=True)
class Parameter:
    """One identified parameter: nominal and identified value, standard deviation (0 where held; None where unknown:
    no degrees of freedom). Lengths in the mechanism's unit, angles in radians, numbers (directions, factors) plain."""

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
    """One reading less its model: configuration number, kind and component; `value` in radians or the length unit (a group's
    from its mean), `normalised` over the deviation that the reading's own noise and the fit leave it."""

    configuration: int
    kind: str
    component: str
    value: float
    sigma: float
    normalised: float | None


@dataclass(frozen=True, eq=False)
class Calibration:
    """The result of a calibration. `problem` holds what was fitted: the configurations `used` (numbers in `measurements`) without
    outliers.

    `covariance` is that of `parameters`, held ones 0; `chi_square` has `degrees` of freedom and the tail probability
    `p_value` (None where standard deviations are unknown; they are then scaled by the fit). `unsolved` are configurations
    whose direct problem was not solved and `changed_mode` those that crossed a singularity on the way; none is dropped
    without being named. `given_up` are the first outliers of a fit where so many readings do not belong that none was left
    out, `silent` configurations without any reading beside the joints, which are not used. All figures are those of the file
    with the `corrected` geometry, written and read back (see `assessment`); `refused` says why it must not be written, None
    where nothing speaks against it.
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

    @cached_property
    def values(self) -> dict[str, float]:
        """Identified values by name."""
        return {p.name: p.value for p in self.parameters}

    @cached_property
    def corrected(self) -> Mechanism:
        """The mechanism with the identified geometry; factors of readings and measuring frames have no place in it."""
        return with_parameters(self.mechanism, self.values)

    @property
    def rank(self) -> int:
        return self.identifiability.rank

    @property
    def believable(self) -> bool:
        """Whether the fit converged, its rank is clear, every configuration is solved, and the stated noise explains the
        residuals (neither larger nor smaller than expected), but for some outliers."""
        fits = self.p_value is None or SIGNIFICANCE < self.p_value < 1.0 - SIGNIFICANCE
        whole = not self.unsolved and not self.given_up and self.refused is None
        return self.status == "ok" and self.identifiability.is_clear and whole and fits and self.degrees > 0

    def __str__(self) -> str:
        p = "" if self.p_value is None else f", probability {self.p_value:.3g}"
        lines = [
            f"{self.mechanism.name}: {self.status} after {self.iterations} iterations ({self.method}), "
            f"{len(self.used)} of {len(self.measurements)} postures; rank {self.rank} of {len(self.problem.names)}; "
            f"chi-square {self.chi_square:.4g} with {self.degrees} degrees of freedom{p}"
        ]
        lines += [self._line(q) for q in self.parameters]
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def _line(self, q: Parameter) -> str:
        """One parameter in the mechanism's units."""
        m = self.mechanism
        one = m.angle_out(1.0) if q.kind == "angle" else 1.0
        unit = {"length": m.length_unit, "angle": m.angle_unit, "number": ""}[q.kind]
        sigma = "held" if q.held else "sigma unknown" if q.sigma is None else f"+- {one * q.sigma:.2g}"
        return f"  {q.name:28s} {one * q.value:14.9g} {sigma:12s} {unit} (change {one * q.change:+.3g})"
