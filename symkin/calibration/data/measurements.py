"""Hold what was measured: joint readings of n configurations and, for each, constraints or sensor
readings.

All values are in radians and the mechanism's length unit. A reading that was not taken is NaN. The
inclination of a platform with rotation R is (alpha, beta) of R = Rz(gamma) Ry(beta) Rx(alpha),
turns about the base frame's axes with z against gravity; it says R^T e_z and no more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from symkin.calibration.data.observables import (
    PLATFORM,
    Observable,
    distance_to_base,
    observables_named,
)
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.joint import units_of, vector3
from symkin.model.mechanism import Mechanism

_MOST_READING = 1e6
"""Joint readings beyond so many radians or sizes are slips."""
NO_GROUP = -1
"""Group number of a configuration that belongs to no group."""
_TABLES = ("inclination", "position", "orientation")
"""Kinds of readings of the platform that are tables of numbers."""
_TABLE_OF = {"joint": "joints", "group": "groups"}
"""Tables that are not called as what they hold."""


@dataclass(frozen=True, eq=False)
class Reading:
    """What was read beside the platform's own pose, by its name.

    A passive joint, a named point, a distance of two, another link than the platform's; or, with
    `ends`, the distance between a point of the platform frame and one of the base frame, whatever
    it is called.

    Names are "follower" (a joint), "point.toe" (in the base frame), "distance.toe.hip",
    "coupler.position", "coupler.orientation" (unit quaternions) and "coupler.inclination" of a
    link's displacement from the reference. `values` are (n,) or (n, w), NaN where none was taken,
    in the length unit and radians; `sigma` is a number or an array that broadcasts to them
    (orientation: (n, 3)). Raises InputError for values that are no table, and quaternions that are
    not of unit length.

    >>> import numpy as np, symkin
    >>> symkin.Reading("follower", np.radians([30.0, 42.0]), sigma=1e-4).values.shape
    (2, 1)
    """

    name: str
    values: np.ndarray
    sigma: float | np.ndarray | None = None
    ends: Sequence[Sequence[float]] = ()

    def __post_init__(self) -> None:
        keep, values = partial(object.__setattr__, self), np.array(self.values, dtype=float)
        values = values[:, None] if values.ndim == 1 else _matrix(values, self.name)
        width = values.shape[1]
        if self.is_orientation:
            values, width = _unit_quaternions(values, self.name), 3
        keep("values", values)
        keep("sigma", _sigma(self.sigma, f"{self.name}: sigma", (len(values), width)))
        if len(self.ends) not in (0, 2):
            raise InputError(
                f"{self.name}: {len(self.ends)} ends; a point of the platform and one of the base "
                f"are needed"
            )
        sides = zip(self.ends, ("platform", "base"), strict=False)
        keep("ends", tuple(vector3(end, f"{self.name}: {side}") for end, side in sides))

    @property
    def is_orientation(self) -> bool:
        """Whether the values are unit quaternions, and the standard deviations those of a rotation
        vector (n, 3).
        """
        return self.name.rpartition(".")[2] == "orientation"


@dataclass(frozen=True, eq=False)
class Measurements:
    """Readings of n configurations.

    joints (n, actuated)     joint readings in file order
    groups (n,)              integers; configurations of one group have equal inclination,
                             unknown; -1: no group
    inclination (n, 2)       alpha, beta
    position (n, 3)          platform origin in the base frame, any of its components
    orientation (n, 4)       unit quaternion w, x, y, z (all four or NaN)
    readings                 of passive joints, named points, other links, distances: see
                             `Reading`
    *_sigma                  standard deviations: a number or an array that broadcasts to the
                             readings (orientation: of the rotation vector's components,
                             (n, 3)); None: unknown, and then estimated from the fit
    starts (n, 7)            poses from which the direct problems begin; NaN rows: the measured
                             pose, else the reference
    labels                   names of the configurations for messages (default: 1, 2, ...)

    Lengths are in the mechanism's unit, angles in radians; NaN stands for what was not read. Raises
    InputError for shapes, values or standard deviations that cannot be.

    >>> import numpy as np, symkin
    >>> tips = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, np.nan]])
    >>> readings = symkin.Measurements(np.zeros((2, 6)), position=tips)
    >>> len(readings), readings.labels
    (2, ('1', '2'))
    """

    joints: np.ndarray
    groups: np.ndarray | None = None
    inclination: np.ndarray | None = None
    position: np.ndarray | None = None
    orientation: np.ndarray | None = None
    readings: Sequence[Reading] = ()
    joint_sigma: float | np.ndarray | None = None
    group_sigma: float | np.ndarray | None = None
    inclination_sigma: float | np.ndarray | None = None
    position_sigma: float | np.ndarray | None = None
    orientation_sigma: float | np.ndarray | None = None
    starts: np.ndarray | None = None
    labels: Sequence[str] = ()

    def __post_init__(self) -> None:
        joints = _matrix(self.joints, "joints")
        if not np.isfinite(joints).all():
            row, column = np.argwhere(~np.isfinite(joints))[0]
            raise InputError(
                f"joints: posture {row + 1}, joint {column + 1} is {joints[row, column]}; a number "
                f"is needed"
            )
        keep, count = partial(object.__setattr__, self), len(joints)
        keep("joints", joints)
        keep("labels", tuple(self.labels) or tuple(map(str, range(1, count + 1))))
        if len(self.labels) != count:
            raise InputError(
                f"labels: {len(self.labels)} names for {count} postures; one for each is needed"
            )
        if self.groups is not None:
            groups = np.asarray(self.groups)
            if groups.shape != (count,) or not np.issubdtype(groups.dtype, np.integer):
                raise InputError(
                    f"groups: {groups.shape} values of type {groups.dtype}; one integer for each "
                    f"posture is needed"
                )
            keep("groups", groups.astype(int))
        for kind, width in (
            *((kind, len(PLATFORM[kind].columns)) for kind in _TABLES),
            ("starts", 7),
        ):
            if getattr(self, kind) is not None:
                table = _shaped(_matrix(getattr(self, kind), kind), (count, width), kind)
                if width > 3:
                    table[:, -4:] = _unit_quaternions(table[:, -4:], kind, self.labels)
                keep(kind, table)
        widths = {kind: len(o.components) for kind, o in PLATFORM.items()}
        for kind, width in (("joint", joints.shape[1]), *widths.items()):
            key = f"{kind}_sigma"
            keep(key, _sigma(getattr(self, key), key, (count, width)))
        keep("readings", tuple(self.readings))
        for r in self.readings:
            _shaped(r.values, (count, *r.values.shape[1:]), r.name)

    def __len__(self) -> int:
        return len(self.joints)

    def sigma(self, key: str) -> np.ndarray | None:
        """Return the standard deviations (n, width) of one kind of reading (`joint`, `group`,
        `inclination`, ...), None if unknown.
        """
        return getattr(self, f"{key}_sigma")

    @property
    def observed(self) -> tuple[str, ...]:
        """Names of what is read beside actuated joints and the platform."""
        return tuple(r.name for r in self.readings if not r.ends)

    @property
    def poses(self) -> np.ndarray:
        """Poses (n, 7) that were measured whole, NaN where none was."""
        if self.position is None or self.orientation is None:
            return np.full((len(self), 7), np.nan)
        poses = np.hstack([self.position, self.orientation])
        return np.where(np.isfinite(poses).all(axis=1, keepdims=True), poses, np.nan)

    @property
    def quaternions(self) -> np.ndarray:
        """Measured orientations (n, 4 k), zero where there are none: of the platform, then of other
        links.
        """
        platform = np.zeros((len(self), 4)) if self.orientation is None else self.orientation
        others = (r.values for r in self.readings if r.is_orientation)
        return np.nan_to_num(np.hstack([platform, *others]))

    @property
    def group_of(self) -> np.ndarray:
        """The group of each configuration (n,), as it is numbered here."""
        return np.full(len(self), NO_GROUP) if self.groups is None else self.groups

    @cached_property
    def grouping(self) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the groups (n,) from 0, -1 for none, and the first configuration of each; a
        group of one configuration is none.
        """
        groups = self.group_of
        _, first, number, counts = np.unique(
            groups, return_index=True, return_inverse=True, return_counts=True
        )
        kept = (counts > 1) & (groups[first] >= 0)
        places = np.where(kept, kept.cumsum() - 1, -1)
        return places[number], first[kept]

    @property
    def _of_platform(self) -> list[Reading]:
        """What was read of the platform; of groups zeros."""
        held = np.where(self.grouping[0] >= 0, 0.0, np.nan)
        groups = None if self.groups is None else np.column_stack([held, held])
        tables = {"group": groups, **{kind: getattr(self, kind) for kind in _TABLES}}
        return [Reading(k, t, self.sigma(k)) for k, t in tables.items() if t is not None]

    def channels(self, mechanism: Mechanism) -> tuple[tuple[Observable, Reading], ...]:
        """All that was read beside the joints: what it is, and the readings."""
        others = iter(observables_named(mechanism, self.observed))
        own = [(PLATFORM[r.name], r) for r in self._of_platform]
        beside = [
            (distance_to_base(r.name, r.ends) if r.ends else next(others), r) for r in self.readings
        ]
        return (*own, *beside)

    @property
    def is_read(self) -> np.ndarray:
        """Tell which configurations (n,) hold any reading beside the joints; a group of one
        configuration is none.
        """
        tables = [r.values for r in (*self._of_platform, *self.readings)]
        whole = np.hstack([np.zeros((len(self), 0)), *tables])
        return np.isfinite(whole).any(axis=1)

    def named(self, configurations: Sequence[int] | np.ndarray) -> tuple[str, ...]:
        """The labels of some configurations, by number from 0 or by mask."""
        return tuple(self.labels[k] for k in np.arange(len(self))[np.asarray(configurations)])

    def subset(self, configurations: Sequence[int] | np.ndarray) -> Measurements:
        """Keep the readings of some configurations, by number from 0 or by mask."""
        index = np.arange(len(self))[np.asarray(configurations)]

        def rows(of: Reading | Measurements) -> dict[str, Any]:
            return {k: v[index] for k, v in vars(of).items() if isinstance(v, np.ndarray)}

        labels = self.named(index)
        readings = [replace(r, **rows(r)) for r in self.readings]
        return replace(self, labels=labels, readings=readings, **rows(self))

    def replaced(self, name: str, *, by_name: bool = False, **changes: Any) -> Measurements:
        """Replace the `values` or the `sigma` of a table (`joint`, `group`, `inclination`, ...), or
        of readings that are held `by_name`.
        """
        if by_name:
            readings = [replace(r, **changes) if r.name == name else r for r in self.readings]
            return replace(self, readings=readings)
        keys = {"values": _TABLE_OF.get(name, name), "sigma": f"{name}_sigma"}
        return replace(self, **{keys[key]: value for key, value in changes.items()})

    def without(self, configuration: int, kind: str) -> Measurements:
        """Leave out one reading: the kind is group, inclination, position, orientation or the name
        of another reading.
        """
        table = getattr(self, _TABLE_OF.get(kind, kind)) if kind in PLATFORM else None
        named = {r.name: r.values for r in self.readings} if table is None else {kind: table}
        values = np.array(named[kind])
        values[configuration] = NO_GROUP if kind == "group" and table is not None else np.nan
        return self.replaced(kind, by_name=table is None, values=values)

    def check(self, mechanism: Mechanism) -> None:
        """Refuse readings of another number of joints than the mechanism has, and of what it does
        not have.
        """
        names = [c.name for c in mechanism.actuated]
        if self.joints.shape[1] != len(names):
            raise InputError(
                f"joints: {self.joints.shape[1]} readings a posture, {mechanism.name} has "
                f"{len(names)} actuated joints ({', '.join(names) or 'none'})"
            )
        most = _MOST_READING * np.array(
            units_of(mechanism.actuated, mechanism.characteristic_length)
        )
        beyond = np.argwhere(np.abs(self.joints) > most)
        if len(beyond):
            row, column = beyond[0]
            raise InputError(
                f"joints: posture {self.labels[row]} reads {self.joints[row, column]:g} of "
                f"{names[column]}, beyond {most[column]:g} (a million "
                f"radians, or times the size); check the units"
            )
        called = [r.name for r in self.readings]
        twice = next((name for name in called if called.count(name) > 1), None)
        if twice is not None:
            raise InputError(f"readings: {twice!r} stands twice")
        for o, reading in self.channels(mechanism):
            if not o.of and mechanism.platform_link is None:
                raise InputError(
                    f"{o.name}: {mechanism.name} has no platform link that it could be of; name it "
                    f"by [platform] link, or read named points (point.NAME) and other links "
                    f"(LINK.position, LINK.orientation, LINK.inclination)"
                )
            if o.kind != "group":
                _shaped(reading.values, (len(self), len(o.columns)), reading.name)


def _unit_quaternions(values: np.ndarray, what: str, labels: Sequence[str] = ()) -> np.ndarray:
    """Quaternions (n, 4) at unit length. Raises InputError where one is far from that."""
    norms = np.linalg.norm(values, axis=1)
    bad = np.flatnonzero(np.isfinite(norms) & (np.abs(norms - 1) > 1e-2))
    if bad.size:
        label = labels[bad[0]] if labels else str(bad[0] + 1)
        raise InputError(
            f"{what}: the quaternion of posture {label} has norm {norms[bad[0]]:.6g}; allowed: 1 "
            f"to within 0.01"
        )
    return values / norms[:, None]


def spread_rows(count: int, most: int) -> np.ndarray:
    """Choose at most so many of `count` rows, spread evenly, by number."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def _matrix(values: Any, what: str) -> np.ndarray:
    try:
        matrix = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(
            f"{what}: no table of numbers; one row for each posture is needed"
        ) from None
    if matrix.ndim != 2 or len(matrix) == 0:
        raise InputError(
            f"{what}: an array of shape {matrix.shape}; one row for each posture is needed"
        )
    return matrix


def _shaped(values: np.ndarray, shape: tuple[int, ...], what: str) -> np.ndarray:
    if values.shape != shape:
        raise InputError(f"{what}: an array of shape {values.shape}; {shape} is needed")
    return values


def _sigma(value: Any, what: str, shape: tuple[int, ...]) -> np.ndarray | None:
    """Standard deviations as an array of this shape, decided here once, so that a part of the
    configurations is read as all of them are.
    """
    if value is None:
        return None
    array = np.asarray(value, dtype=float)
    if array.ndim == 1 and len(shape) == 2 and array.shape[0] == shape[0] != shape[1]:
        array = array[:, None]
    try:
        array = np.array(np.broadcast_to(array, shape))
    except ValueError:
        raise InputError(
            f"{what}: an array of shape {np.shape(value)} does not fit {shape}"
        ) from None
    least = 0.0 if what == "joint_sigma" else np.finfo(float).tiny
    given = array[~np.isnan(array)]
    if np.any(given < least) or not np.isfinite(given).all():
        raise InputError(
            f"{what} = {float(given.min()):g}: a standard deviation must be finite and positive"
        )
    return array
