"""State a calibration problem: mechanism, readings, the parameters to identify and those that are
held.

By default all parameters that matter are identified. A file writes down more than the geometry has:
a direction has a length, the point of a joint may lie anywhere on its axis, a slide may pass
anywhere, a passive joint's zero shifts only its own coordinate, and any closed configuration may be
the reference, so that points and axes there determine the zeros of actuated joints. Of each such
freedom one parameter is left out: the largest component. What is free at the nominal values only,
parallel axes for instance, stays: the machine as built may determine it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import (
    Velocity,
    bound_by_motion,
    geometry_parameters,
    is_writable,
    joint_paths,
    nominal_parameters,
    written_freedoms,
)
from symkin.calibration.data.reference_motions import reference_motions
from symkin.calibration.estimate.configuration_model import ConfigurationModel, build_model
from symkin.calibration.estimate.residuals import Readings, build_readings
from symkin.calibration.options import FORMS, Form
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.numeric.linear_algebra import largest_of
from symkin.text import not_among

MAX_WHOLE_ROWS, PART_ROWS = 10_000, 4_000
"""Configurations beyond which derivatives are not kept but evaluated part by part, and how many a
part has: derivatives of 10,000 configurations of a hexapod take some 100 MB.
"""

PRIOR_SHARE = 0.01
"""Standard deviation of a geometry about nominal, of the size (angles: radians), where no tolerance
is stated: machines are built to some per mille.
"""
_NO_RATE = 1e-9
"""Rates of parameters in a freedom of how the file is written (of the largest) that are
rounding.
"""


@dataclass(frozen=True, eq=False)
class CalibrationProblem:
    """What is fitted to what: `model.names` are the free parameters, `fixed` those that the user
    asked for and holds at their nominal values. `prior` (P,) holds standard deviations of the
    scaled parameters about nominal, infinite for what has no nominal place: `PRIOR_SHARE` of the
    size, or the manufacturing tolerances where they are stated (`is_stated`), by which the estimate
    is the maximum a posteriori. A fit that goes further than the prior lets expect begins or ends
    with it `widened` by this factor. `noise` (n, K, K) is the covariance that joint noise gives the
    readings, by which maximum likelihood weighs them; without it they count as means. `estimated`
    are the standard deviations of kinds of readings that state none.
    """

    mechanism: Mechanism
    measurements: Measurements
    model: ConfigurationModel
    readings: Readings
    fixed: tuple[str, ...]
    form: Form
    prior: np.ndarray
    is_stated: bool = False
    widened: float = 1.0
    noise: np.ndarray | None = None
    estimated: Mapping[str, float] = field(default_factory=dict)

    @property
    def by_means(self) -> CalibrationProblem:
        """The same with residuals from the means of groups, each reading by itself."""
        return self if self.form == "means" else replace(self, form="means")

    @property
    def names(self) -> tuple[str, ...]:
        return self.model.names

    @property
    def size(self) -> float:
        return self.model.size

    @property
    def joints(self) -> np.ndarray:
        return self.measurements.joints

    @property
    def spread(self) -> np.ndarray:
        """The prior's standard deviations (P,), as wide as they are."""
        return self.widened * self.prior

    def over_prior(self, p: np.ndarray) -> np.ndarray:
        """Changes of the parameters (P,) from nominal over the prior's standard deviations."""
        return (p - self.model.nominal) / self.model.scales / self.prior / self.widened

    @property
    def is_large(self) -> bool:
        """Whether derivatives are made part by part; not where the closure leaves rows to the
        parameters, which bind all configurations.
        """
        system = self.model.system
        return len(self.measurements) > MAX_WHOLE_ROWS and system.rows.shape[0] == system.freedom

    @cached_property
    def parts(self) -> tuple[tuple[np.ndarray, CalibrationProblem], ...]:
        """Numbers of configurations and the problem of these alone, members of a group together,
        `PART_ROWS` or those of a group that has more; one part where the problem is not large.
        """
        if not self.is_large:
            return ((np.arange(len(self.measurements)), self),)
        readings = self.readings
        order = np.append(readings.order, np.flatnonzero(readings.group < 0)).astype(int)
        heads = np.append(readings.begins, np.arange(len(readings.order), len(order))).astype(int)
        cuts = heads[np.flatnonzero(np.diff(heads // PART_ROWS, prepend=0))]
        return tuple((rows, self.of(rows)) for rows in np.split(order, cuts) if len(rows))

    def of(self, rows: np.ndarray) -> CalibrationProblem:
        """The problem of some configurations, by number or by mask."""
        some, noise = self.measurements.subset(rows), self.noise
        noise = None if noise is None else noise[rows]
        readings = build_readings(self.model, some, self.estimated)
        return replace(self, measurements=some, readings=readings, noise=noise)

    @property
    def quaternions(self) -> np.ndarray:
        """Measured orientations (n, 4 k), zero where there are none."""
        return self.measurements.quaternions


def build_calibration(
    mechanism: Mechanism,
    measurements: Measurements,
    *,
    parameters: Sequence[str] | None = None,
    fixed: Sequence[str] = (),
    residual: str = "means",
    tolerance: tuple[float, float] | None = None,
    estimated: Mapping[str, float] | None = None,
) -> CalibrationProblem:
    """State the problem of identifying `parameters` (default: `default_parameters`), of which
    `fixed` are held; `tolerance` is that of lengths (length unit) and of angles and directions
    (radians).

    Raises InputError for unknown names, for readings that do not fit the mechanism and for
    measurements without any.
    """
    measurements.check(mechanism)
    if residual not in FORMS:
        raise InputError(f"residual = {not_among(residual, FORMS)}")
    names = (
        default_parameters(mechanism, measurements.observed)
        if parameters is None
        else tuple(parameters)
    )
    _check_names(mechanism, measurements.observed, names, fixed)
    free = [n for n in names if n not in fixed]
    if not free:
        raise InputError("no parameter is left to identify; name some, or fix fewer")
    model = build_model(mechanism, measurements, free)
    readings = build_readings(model, measurements, estimated or {})
    if readings.count <= 0:
        raise InputError(
            "the measurements hold no reading beside the joints: give groups of two postures or "
            "more, inclinations, "
            "positions, orientations or distances"
        )
    if tolerance is not None and not readings.known:
        raise InputError(
            "a tolerance is weighed against the noise, and standard deviations of readings are "
            "missing: give them"
        )
    return CalibrationProblem(
        mechanism=mechanism,
        measurements=measurements,
        model=model,
        readings=readings,
        fixed=tuple(fixed),
        form=residual,
        prior=prior_of(model, tolerance),
        is_stated=tolerance is not None,
        estimated=estimated or {},
    )


def _check_names(
    mechanism: Mechanism, read: tuple[str, ...], names: Sequence[str], fixed: Sequence[str]
) -> None:
    """Refuse parameters that are named twice or bound by the declared motion, and held ones that
    are not to be identified.
    """
    bound = bound_by_motion(mechanism, read)
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"parameters: {name!r} is named twice")
        if name in bound and name not in fixed:
            raise InputError(f"parameter {name!r} is bound by {_binding(mechanism)}")
    for name in fixed:
        if name not in names:
            raise InputError(
                f"fixed: {name!r} is not among the parameters to identify ({', '.join(names)})"
            )


def _binding(mechanism: Mechanism) -> str:
    """What binds parameters, why, and what to do."""
    leave = "leave it out of the parameters to identify, hold it"
    if mechanism.motion == "spatial":
        return (
            f"a loop that is planar or spherical, which could no longer move with it alone "
            f"changed; {leave}"
        )
    return (
        f"the platform's {mechanism.motion} motion: moved alone, its limb could not carry the "
        f"platform through that motion; "
        f"{leave}, or declare the motion spatial"
    )


def prior_of(model: ConfigurationModel, tolerance: tuple[float, float] | None = None) -> np.ndarray:
    """Return the standard deviations (P,) of scaled parameters, `tolerance` that of lengths and of
    angles; frames between the mechanism and what is measured are not made to a tolerance, and
    factors of readings are no geometry.
    """
    size = model.size
    length, angle = (PRIOR_SHARE * size, PRIOR_SHARE) if tolerance is None else tolerance
    if not (0.0 < length < np.inf and 0.0 < angle < np.inf):
        raise InputError(
            f"tolerance = ({length:g}, {angle:g}): both a length and an angle, finite and "
            f"positive, are needed"
        )
    free = [not is_writable(name) for name in model.names]
    spread = [length if kind == "length" else angle for kind in model.kinds]
    return np.where(free, np.inf, np.array(spread) / model.scales)


@lru_cache(maxsize=64)
def default_parameters(mechanism: Mechanism, read: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Name the parameters that matter, in the closure's order: without those that a declared motion
    binds, and without one for each freedom in how the file is written. `read` names what is read
    beside actuated joints and the platform.
    """
    bound, values = bound_by_motion(mechanism, read), geometry_parameters(mechanism, read)
    free = {name: k for k, name in enumerate(name for name in values if name not in bound)}
    table, size = nominal_parameters(mechanism, read), mechanism.characteristic_length
    units = np.array([1.0 if table[name][1] == "length" else size for name in free])
    zeros = [f"{path}.zero" for path, joint in joint_paths(mechanism) if joint.actuated]
    freedoms: list[tuple[Velocity, list[str]]]
    freedoms = [(v, []) for _, v in written_freedoms(mechanism, values, read)]
    for _, velocity in reference_motions(mechanism, values, read):
        if not any(abs(v) > _NO_RATE for name, v in velocity.items() if name in bound):
            freedoms.append((velocity, zeros))
    rows, dropped = np.zeros((0, len(free))), list[int]()
    for velocity, first in freedoms:
        row = units * [velocity.get(name, 0.0) for name in free]
        bound_below = _NO_RATE * largest_of(row)
        # by elimination, so that what is left out tells the freedoms apart
        for k, earlier in zip(dropped, rows, strict=True):
            row = row - row[k] / earlier[k] * earlier
        left = np.abs(row) > bound_below
        if left.any():
            chosen = [free[name] for name in first if name in free and left[free[name]]]
            dropped.append(chosen[0] if chosen else int(np.abs(row).argmax()))
            rows = np.vstack([rows, row])
    return tuple(name for name, k in free.items() if k not in dropped)
