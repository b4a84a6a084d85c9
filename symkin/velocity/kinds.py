"""Jacobians of every kind, read from the rates of all coordinates by those that drive."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection

import casadi as ca

from symkin.closure.closure import Closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.velocity.differential import passive_rates, pose_rates, rate_names
from symkin.velocity.jacobian_names import TWIST, JacobianKind, Matrix, names_of


class Rates(ABC):
    """Rates of all coordinates of a closure by known ones, as expressions of its variables and of
    the geometry that is `free`.
    """

    free: Collection[str] = ()

    @property
    @abstractmethod
    def closure(self) -> Closure: ...

    @property
    @abstractmethod
    def following(self) -> ca.SX:
        """All rates by those of the known coordinates."""

    @abstractmethod
    def split(self, rates: ca.SX) -> dict[str, ca.SX]:
        """Rates of each coordinate among all rates, those of `following`."""

    @property
    @abstractmethod
    def direct(self) -> ca.SX:
        """(6, n): the twist by the known rates."""

    @property
    @abstractmethod
    def inverse(self) -> ca.SX:
        """(n, 6): the known rates by a twist."""

    def matrix(self, kind: JacobianKind, mechanism: Mechanism) -> Matrix:
        """A Jacobian of one of the kinds, its passive joints in the order of a description. Raises
        InputError where no joint is passive.
        """
        closure = self.closure
        joints = tuple(c.name for c in mechanism.actuated)
        if kind == "direct":
            return Matrix(TWIST, joints, self.direct)
        if kind == "inverse":
            return Matrix(joints, TWIST, self.inverse)
        if kind == "analytic":
            pose = closure.role("pose")
            rows = tuple(name for c in pose for name in names_of(c.name, c.width))
            rates = (pose_rates(c, self._quaternion, self.direct) for c in pose)
            return Matrix(rows, joints, ca.sparsify(ca.vertcat(*rates)))
        return self._passive_matrix(joints, mechanism)

    def _passive_matrix(self, joints: tuple[str, ...], mechanism: Mechanism) -> Matrix:
        told = passive_rates(self.closure, self.split(self.following), self.free)
        if not told:
            raise InputError(
                f"{mechanism.name} has no passive joint whose rate the actuated joints decide; "
                f"allowed kinds: direct, inverse, analytic; or name coordinates: --of NAMES "
                f"--by NAMES"
            )
        listed = [c for c in mechanism.coordinates if c.name in told]
        rates = ca.vertcat(*(told[c.name] for c in listed))
        return Matrix(rate_names(listed), joints, ca.sparsify(rates))

    @property
    def _quaternion(self) -> ca.SX:
        closure = self.closure
        return closure.symbols([c for c in closure.role("pose") if c.is_rotation])
