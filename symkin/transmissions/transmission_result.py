"""A transmission of motors and joints: positions, differentials, torques, its whole range."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.following.track import track
from symkin.model.mechanism import Mechanism
from symkin.position.solve_result import SolveError
from symkin.result import Result, Summary, json_value
from symkin.text import counted, shown
from symkin.transmissions.linkage import Linkage
from symkin.transmissions.motors import Motors, read_motors
from symkin.transmissions.polytope import between_planes, torque_vertices
from symkin.transmissions.states import States
from symkin.transmissions.survey import Survey, survey


@dataclass(frozen=True, eq=False, repr=False)
class Transmission(Result):
    """The map between motors m and joints j of a closed linkage; made by `symkin.transmission`.

    Arrays have the coordinates along their last axis and any leading ones; values are in the
    mechanism's units, derivatives per radian and length unit. A configuration is told by `motors`,
    or by `joints`; the mode is the reference's, followed along the straight line from there, and
    without either it is the reference. What is not reached is NaN with `check=False`, else raises
    SolveError. With J = d joints / d motors and G = J^-1:

    rates         j' = J m'                     torques     tau_m = J^T tau_j, tau_j = G^T tau_m
    inertia       G^T I G                       bias        G^T I d2m/dj2

    so that tau_j = inertia j'' + bias j' j' for the motors' inertias I. Of more motors than
    freedoms, J is the pseudo-inverse of G: rates that agree, and the least torques.

    >>> import symkin
    >>> linkage = symkin.load("four_bar")
    >>> knee = symkin.transmission(linkage, motors=["crank"], joints=["follower"])
    >>> follower = knee.joints_of([[50.0], [60.0]])
    >>> bool(abs(knee.motors_of(follower) - [[50.0], [60.0]]).max() < 1e-9)
    True
    """

    name: str
    linkage: Linkage
    data: Motors
    notes: tuple[str, ...] = ()

    @property
    def motors(self) -> tuple[str, ...]:
        """Names of the motors' coordinates."""
        return self.linkage.motors

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints' coordinates."""
        return self.linkage.joints

    # --- positions --------------------------------------------------------------------------------

    def joints_of(self, motors: Any, *, check: bool = True) -> np.ndarray:
        """The joints (..., n) at motors (..., m)."""
        states, lead = self._at(motors, None, check=check)
        return self._out(states.joints, self.joints, lead)

    def motors_of(self, joints: Any, *, check: bool = True) -> np.ndarray:
        """The motors (..., m) at joints (..., n)."""
        states, lead = self._at(None, joints, check=check)
        return self._out(states.motors, self.motors, lead)

    def states(self, motors: Any = None, joints: Any = None, *, check: bool = True) -> States:
        """All that is known at configurations, in radians, leading axes as one."""
        return self._at(motors, joints, check=check)[0]

    # --- differentials ----------------------------------------------------------------------------

    def jacobian(self, motors: Any = None, *, joints: Any = None, check: bool = True) -> np.ndarray:
        """J = d joints / d motors (..., n, m)."""
        return self._of(lambda s: s.jacobian, motors, joints, check)

    def inverse_jacobian(
        self, motors: Any = None, *, joints: Any = None, check: bool = True
    ) -> np.ndarray:
        """G = d motors / d joints (..., m, n)."""
        return self._of(lambda s: s.inverse_jacobian, motors, joints, check)

    def second(self, motors: Any = None, *, joints: Any = None, check: bool = True) -> np.ndarray:
        """d2 joints / d motors2 (..., n, m, m)."""
        return self._of(lambda s: s.second, motors, joints, check)

    def torques(
        self, of_joints: Any, motors: Any = None, *, joints: Any = None, check: bool = True
    ) -> np.ndarray:
        """The motors' torques J^T tau_j (..., m) that hold torques of joints (..., n)."""
        jacobian = self.jacobian(motors, joints=joints, check=check)
        return np.einsum("...ji,...j->...i", jacobian, self._numbers(of_joints, self.joints))

    def joint_torques(
        self, of_motors: Any, motors: Any = None, *, joints: Any = None, check: bool = True
    ) -> np.ndarray:
        """The joints' torques G^T tau_m (..., n) of torques of motors (..., m)."""
        inverse = self.inverse_jacobian(motors, joints=joints, check=check)
        return np.einsum("...ij,...i->...j", inverse, self._numbers(of_motors, self.motors))

    def inertia(
        self, motors: Any = None, *, joints: Any = None, of_motors: Any = None, check: bool = True
    ) -> np.ndarray:
        """The motors' inertias at the joints, G^T I G (..., n, n); `of_motors` are those told."""
        own = self._told(inertia=of_motors).inertias
        return self._of(lambda s: s.inertia(own), motors, joints, check)

    def bias(
        self, motors: Any = None, *, joints: Any = None, of_motors: Any = None, check: bool = True
    ) -> np.ndarray:
        """b (..., n, n, n) of the torques b_ijk j'_j j'_k that the motors' inertias take."""
        own = self._told(inertia=of_motors).inertias
        return self._of(lambda s: s.bias(own), motors, joints, check)

    def polytope(
        self, motors: Any = None, *, joints: Any = None, kind: str = "torque", limits: Any = None
    ) -> np.ndarray:
        """The vertices (k, n) of all joint torques ("torque") or rates ("speed") that the motors'
        limits allow at one configuration: a number for each motor, or (low, high).
        """
        if kind not in ("torque", "speed"):
            raise InputError(f"kind = {shown(kind)}; torque or speed is needed")
        own = getattr(self._told(**{f"{kind}_limits": limits}), f"{kind}_limits")
        states, lead = self._at(motors, joints, check=True)
        if lead:
            raise InputError("polytope: one configuration is needed, not an array of them")
        g = states.inverse_jacobian[0]
        if not np.isfinite(g).all():
            raise SolveError(f"{self.name}: singular there; {states.lost(0)}")
        if kind == "speed":
            return between_planes(g, *own.T)
        return torque_vertices(g, own)

    # --- the whole range --------------------------------------------------------------------------

    @cached_property
    def survey(self) -> Survey:
        """What the transmission does over its whole range."""
        return survey(self.linkage, self.data)

    def summary(self, most_rows: int | None = None) -> Summary:  # noqa: ARG002 - few rows
        """The range, the torques and rates of each joint, and what limits them."""
        return self.survey.summary(self.name, self.notes)

    def to_dict(self, motors: Any = None, joints: Any = None) -> dict[str, Any]:
        """The JSON of `symkin transmission` at a configuration, the reference's without one."""
        states, _ = self._at(motors, joints, check=True)
        own = self.data
        told = self._out(states.motors, self.motors, ()), self._out(states.joints, self.joints, ())
        certified, why = self.certified(told[0])
        arrays = {
            **{key: getattr(states, key)[0] for key in ("jacobian", "second", "inverse_jacobian")},
            "reflected_inertia": states.inertia(own.inertias)[0],
            "bias": states.bias(own.inertias)[0],
            "torque_polytope": self.polytope(motors, joints=joints),
            "speed_polytope": self.polytope(motors, joints=joints, kind="speed"),
        }
        within = bool(np.all(self.linkage.beyond_limits(states.w) <= 0.0))
        return {
            "transmission": self.name,
            "motors": dict(zip(self.motors, told[0].tolist(), strict=True)),
            "joints": dict(zip(self.joints, told[1].tolist(), strict=True)),
            **{key: _listed(array) for key, array in arrays.items()},
            "certified": certified,
            "within_limits": within if self.linkage.limited else None,
            "range": self.survey.to_dict(),
            "notes": [*self.notes, *own.notes, *why],
        }

    def certified(self, motors: Any) -> tuple[bool, tuple[str, ...]]:
        """Whether ball arithmetic proves that this is the reference's mode, followed along the
        straight line of the motors; else why not.
        """
        here = self._out(self.linkage.reference[None, self.linkage.motor_places], self.motors, ())
        goal = np.asarray(motors, dtype=float).reshape(-1)
        path = {n: [float(a), float(b)] for n, a, b in zip(self.motors, here, goal, strict=True)}
        if len(self.motors) != self.linkage.mobility:
            return False, ("redundant motors: the mode is followed and measured, not proved",)
        if np.allclose(here, goal, rtol=0.0, atol=1e-12):
            return True, ()
        found = track(self.linkage.mechanism, given=path, limits=False, name_modes=False)
        return (True, ()) if found.certified and found.reached else (False, (found.statement,))

    # --- values -----------------------------------------------------------------------------------

    def _at(self, motors: Any, joints: Any, *, check: bool) -> tuple[States, tuple[int, ...]]:
        linkage, start = self.linkage, self.linkage.reference
        if motors is not None and joints is not None:
            raise InputError("both motors and joints are given; one of them tells a configuration")
        if motors is None and joints is None:
            return States(linkage, start[None]), ()
        names = self.motors if joints is None else self.joints
        values = self._numbers(motors if joints is None else joints, names)
        goals = values.reshape(-1, len(names)) * linkage.radians(names)
        found = linkage.moved(names, start, goals)
        w = found.points
        if check and not found.reached.all():
            raise SolveError(self._why(names, w, goals, found.shares))
        w[~found.reached] = np.nan
        return States(linkage, w), values.shape[:-1]

    def _why(
        self, names: tuple[str, ...], w: np.ndarray, goals: np.ndarray, shares: np.ndarray
    ) -> str:
        """Why the first goal that is not reached is not."""
        row = int(np.flatnonzero(shares < 1.0)[0])
        values = goals[row] / self.linkage.radians(names)
        told = ", ".join(f"{n} = {v:.6g}" for n, v in zip(names, values, strict=True))
        if not np.isfinite(values).all():
            return f"{self.name}: {told}: a value is not finite"
        where = f" (row {row + 1} of {len(shares)})" if len(shares) > 1 else ""
        if len(self.motors) > self.linkage.mobility and names == self.motors and not shares[row]:
            return (
                f"{self.name}: {told}{where}: {len(self.motors)} motors move "
                f"{counted(self.linkage.mobility, 'freedom')}, and these values do not agree with "
                f"each other"
            )
        lost = States(self.linkage, w[row : row + 1]).lost(0)
        return (
            f"{self.name}: {told}{where} is not reached from the reference: {shares[row]:.3g} of "
            f"the straight line leads to a singularity or the end of the reach"
            + (f"; {lost}" if lost else "")
        )

    def _of(
        self, read: Callable[[States], np.ndarray], motors: Any, joints: Any, check: bool
    ) -> np.ndarray:
        states, lead = self._at(motors, joints, check=check)
        found = read(states)
        if check and not np.isfinite(found).all():
            row = int(np.flatnonzero(~np.isfinite(found).reshape(len(found), -1).all(axis=1))[0])
            raise SolveError(f"{self.name}: singular at this configuration; {states.lost(row)}")
        return found.reshape(*lead, *found.shape[1:])

    def _numbers(self, values: Any, names: tuple[str, ...]) -> np.ndarray:
        """An array (..., names) of numbers, or values by name. Raises InputError."""
        if isinstance(values, Mapping):
            missing = [name for name in names if name not in values]
            if missing or len(values) != len(names):
                raise InputError(f"{self.name}: values for {', '.join(names)} are needed")
            values = np.stack([np.asarray(values[name]) for name in names], axis=-1)
        try:
            found = np.asarray(values, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"{self.name}: {shown(values)} are no numbers") from None
        if found.ndim == 0 or found.shape[-1] != len(names):
            needed = f"needed: {', '.join(names)}"
            if found.ndim < 2:
                raise InputError(
                    f"{self.name}: {counted(found.size)} given, {len(names)} are {needed}"
                )
            raise InputError(
                f"{self.name}: an array of shape {found.shape}; {len(names)} numbers along its "
                f"last axis are {needed}"
            )
        return found

    def _told(self, **option: Any) -> Motors:
        """The motors' data, or those with an option if it is told."""
        (value,) = option.values()
        return self.data if value is None else read_motors(self.motors, option)

    def _out(self, values: np.ndarray, names: tuple[str, ...], lead: tuple[int, ...]) -> np.ndarray:
        return (values / self.linkage.radians(names)).reshape(*lead, len(names))


@dataclass(frozen=True, eq=False, repr=False)
class Transmissions(Result, Mapping[str, Transmission]):
    """The transmissions of a robot by name, and what was left aside and why; made by
    `symkin.transmission`.

    >>> import symkin
    >>> list(symkin.transmission(symkin.load("ankle")))
    ['ankle.1, ankle.2']
    """

    mechanism: Mechanism
    found: tuple[Transmission, ...]
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Transmission:
        return {t.name: t for t in self.found}[name]

    def __iter__(self) -> Iterator[str]:
        return (t.name for t in self.found)

    def __len__(self) -> int:
        return len(self.found)

    def to_dict(self) -> dict[str, Any]:
        """The JSON objects of all transmissions."""
        return {
            "mechanism": self.mechanism.name,
            "transmissions": json_value(self.found),
            "notes": list(self.notes),
        }

    def summary(self, most_rows: int | None = None) -> Summary:
        """The tables of all transmissions, one below the other."""
        texts = [t.summary(most_rows).text() for t in self.found]
        return Summary(["\n\n".join(texts)] if texts else [], below=list(self.notes))


def _listed(values: np.ndarray) -> Any:
    """Nested lists, None for what a singularity leaves undefined."""
    return np.where(np.isfinite(values), values.astype(object), np.full(1, None)).tolist()
