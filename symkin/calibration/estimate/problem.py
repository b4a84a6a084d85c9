"""State a calibration problem: mechanism, readings, the parameters to identify and those that are held.

By default all parameters that matter are identified. A file writes down more than the geometry has: a direction has a length, the
point of a joint may lie anywhere on its axis, a slide may pass anywhere, a passive joint's zero shifts only its own coordinate,
and any closed configuration may be the reference, so that points and axes there determine the zeros of actuated joints. Of each
such freedom one parameter is left out: the largest component. What is free at the nominal values only, parallel axes for
instance, stays: the machine as built may determine it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import bound_by_motion, written_freedoms
from symkin.calibration.estimate.configuration_model import ConfigurationModel, build_model
from symkin.calibration.estimate.residuals import FORMS, Form, Readings, build_readings
from symkin.calibration.estimate.workspace import Workspace
from symkin.closure.closure import build_closure
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import InputError, SymkinError
from symkin.model.mechanism import Mechanism

MAX_WHOLE_ROWS, PART_ROWS = 10_000, 4_000
"""Configurations beyond which derivatives are not kept but evaluated part by part, and how many a part has: derivatives of
10,000 configurations of a hexapod take some 100 MB."""

_COMPARED_CONFIGURATIONS = 24
"""Random closed configurations at which zeros are compared with the other parameters."""
_REDUNDANT_SHARE = 1e-7
"""A zero whose effect differs from one of the other parameters by less than this share is redundant."""


class NothingReadError(InputError):
    """Measurements without any reading beside the joints."""


@dataclass(frozen=True, eq=False)
class CalibrationProblem:
    """What is fitted to what: `model.names` are the free parameters, `fixed` those that the user asked for and holds at their
    nominal values. `prior` (P,) holds standard deviations of the scaled parameters about nominal, infinite where there is
    none: the manufacturing tolerances, by which the estimate is the maximum a posteriori; None: least squares of the readings
    alone."""

    mechanism: Mechanism
    measurements: Measurements
    model: ConfigurationModel
    readings: Readings
    fixed: tuple[str, ...]
    form: Form
    prior: np.ndarray | None = None

    @property
    def names(self) -> tuple[str, ...]:
        return self.model.names

    def __getstate__(self) -> dict[str, Any]:
        """Pickle without the model, whose symbols are built anew from the mechanism, the measurements and the names."""
        return {**{k: v for k, v in self.__dict__.items() if k not in ("model", "parts")}, "_free": self.names}

    def __setstate__(self, state: dict[str, Any]) -> None:
        own = dict(state)
        model = build_model(own["mechanism"], own["measurements"], own.pop("_free"))
        self.__dict__.update(own, model=model)

    def prior_rows(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the residuals (k,) of parameters p from nominal over their tolerances, and their derivative (k, P) by scaled
        parameters; None without tolerances."""
        if self.prior is None:
            return None
        known = np.isfinite(self.prior)
        change = (p - self.model.nominal) / self.model.scales
        return (change / self.prior)[known], np.diag(1.0 / self.prior)[known]

    @property
    def is_large(self) -> bool:
        """Whether derivatives are made part by part; not where the closure leaves rows to the parameters, which bind all
        configurations."""
        system = self.model.system
        return len(self.measurements) > MAX_WHOLE_ROWS and int(system.rows.shape[0]) == system.freedom

    @cached_property
    def parts(self) -> tuple[tuple[np.ndarray, CalibrationProblem], ...]:
        """Numbers of configurations and the problem of these alone, members of a group together and without the prior; one
        part where the problem is not large."""
        if not self.is_large:
            return ((np.arange(len(self.measurements)), self),)
        return tuple((rows, self._of(rows)) for rows in _split_rows(self.readings))

    def _of(self, rows: np.ndarray) -> CalibrationProblem:
        some = self.measurements.subset(rows)
        return replace(self, measurements=some, readings=build_readings(self.model, some), prior=None)

    @property
    def quaternions(self) -> np.ndarray:
        """Measured orientations (n, 4), zero where there are none."""
        q = self.measurements.orientation
        return np.zeros((len(self.measurements), 4)) if q is None else np.nan_to_num(q)


def build_calibration(
    mechanism: Mechanism,
    measurements: Measurements,
    *,
    parameters: Sequence[str] | None = None,
    fixed: Sequence[str] = (),
    residual: str = "means",
    tolerance: tuple[float, float] | None = None,
) -> CalibrationProblem:
    """State the problem of identifying `parameters` (default: `default_parameters`), of which `fixed` are held; `tolerance` is
    that of lengths (length unit) and of angles and directions (radians).

    Raises InputError for unknown names, for readings that do not fit the mechanism and for measurements without any.
    """
    measurements.check(mechanism)
    if residual not in FORMS:
        raise InputError(f"residual = {residual!r} is unknown; allowed: {', '.join(FORMS)}")
    names = default_parameters(mechanism) if parameters is None else tuple(parameters)
    _check_names(mechanism, names, fixed)
    free = [n for n in names if n not in fixed]
    if not free:
        raise InputError("no parameter is left to identify; name some, or fix fewer")
    model = build_model(mechanism, measurements, free)
    readings = build_readings(model, measurements)
    if readings.count <= 0:
        raise NothingReadError(
            "the measurements hold no reading beside the joints: give groups of two postures or more, inclinations, "
            "positions, orientations or distances"
        )
    if tolerance is not None and not readings.known:
        raise InputError("a tolerance is weighed against the noise, and standard deviations of readings are missing: give them")
    prior = None if tolerance is None else _prior(model, *tolerance)
    return CalibrationProblem(
        mechanism=mechanism, measurements=measurements, model=model, readings=readings, fixed=tuple(fixed), form=residual,
        prior=prior,
    )  # fmt: skip


def _check_names(mechanism: Mechanism, names: Sequence[str], fixed: Sequence[str]) -> None:
    """Refuse parameters that are named twice or bound by the declared motion, and held ones that are not to be identified."""
    bound = bound_by_motion(mechanism)
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"parameters: {name!r} is named twice")
        if name in bound and name not in fixed:
            raise InputError(
                f"parameter {name!r} is bound by the platform's {mechanism.motion} motion: moved alone, its limb could not carry "
                "the platform through that motion; leave it out of the parameters to identify, hold it, or declare the motion spatial"
            )
    for name in fixed:
        if name not in names:
            raise InputError(f"fixed: {name!r} is not among the parameters to identify ({', '.join(names)})")


def _prior(model: ConfigurationModel, length: float, angle: float) -> np.ndarray:
    """Return the standard deviations (P,) of scaled parameters; frames between the mechanism and what is measured are not
    made to a tolerance, and factors of readings are no geometry."""
    if not (0.0 < length < np.inf and 0.0 < angle < np.inf):
        raise InputError(f"tolerance = ({length:g}, {angle:g}): both a length and an angle, finite and positive, are needed")
    free = [name.startswith(("world.", "target.")) or name.endswith(".scale") for name in model.names]
    spread = [length if kind == "length" else angle for kind in model.kinds]
    return np.where(free, np.inf, np.array(spread) / model.scales)


def _split_rows(readings: Readings) -> list[np.ndarray]:
    """Split configurations, by number, into parts of `PART_ROWS`, or of a group where one has more."""
    order = np.concatenate([readings.order, np.flatnonzero(readings.group < 0)]).astype(int)
    heads = np.concatenate([readings.begins, np.arange(len(readings.order), len(order))]).astype(int)
    cuts = heads[np.flatnonzero(np.diff(heads // PART_ROWS, prepend=0))]
    return [rows for rows in np.split(order, cuts) if len(rows)]


@lru_cache(maxsize=64)
def default_parameters(mechanism: Mechanism) -> tuple[str, ...]:
    """Name the closure's parameters that matter, in its order: without those that a declared motion binds, and without one
    for each freedom in how the file is written."""
    bound, closure = bound_by_motion(mechanism), build_closure(mechanism)
    values = dict(zip(closure.parameter_names, map(float, closure.parameter_values), strict=True))
    dropped: set[str] = set()
    for _, velocity in written_freedoms(mechanism, values):
        open_ = {n: abs(v) for n, v in velocity.items() if n in values and n not in bound and n not in dropped and abs(v) > 1e-12}
        if open_:
            dropped.add(max(open_, key=lambda n: open_[n]))
    kept = [n for n in closure.parameter_names if n not in bound and n not in dropped]
    return tuple(n for n in kept if n not in _redundant_zeros(mechanism, kept))


def _redundant_zeros(mechanism: Mechanism, names: list[str]) -> set[str]:
    """Find the zeros of actuated joints among the names whose effect on closure and pose is that of the other parameters."""
    zeros = [n for n in names if n.endswith(".zero")]
    if not zeros:
        return set()
    try:
        workspace, rng = Workspace.about(mechanism), np.random.default_rng(0)
        made = workspace.draw(workspace.inclinations(_COMPARED_CONFIGURATIONS, rng), rng, held=False)
    except SymkinError:
        return set()
    poses = Measurements(made.joints, position=made.poses[:, :3], orientation=made.poses[:, 3:])
    model = build_model(mechanism, poses, names)
    z = np.ascontiguousarray(made.values[:, len(mechanism.actuated) :])
    e = model.evaluate(z, made.joints, model.nominal, made.poses[:, 3:])
    follow = e.following
    effect = np.concatenate([e.readings_p + e.readings_z @ follow, e.rows_p + e.rows_z @ follow], axis=1).reshape(-1, len(names))
    redundant, others = set[str](), [k for k, n in enumerate(names) if n not in zeros]
    for zero in zeros:
        column, basis = effect[:, names.index(zero)], effect[:, others]
        left = column - basis @ np.linalg.lstsq(basis, column, rcond=1e-10)[0]
        if np.linalg.norm(left) <= _REDUNDANT_SHARE * np.linalg.norm(column):
            redundant.add(zero)
        else:
            others.append(names.index(zero))
    return redundant
