"""Jacobians of every kind, read from the rates of all coordinates by those that drive."""

from __future__ import annotations

import casadi as ca

from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.velocity.differential import passive_rates, pose_rates, rate_names
from symkin.velocity.jacobian_names import TWIST, JacobianKind, Matrix, names_of
from symkin.velocity.rates import Rates


def driven_places(rates: Rates, mechanism: Mechanism) -> dict[str, int]:
    """The place among the rates of each actuated joint in the order of a description: of one that
    is an arm these stand along the arm, without those beside it.
    """
    own = [c.name for c in rates.closure.mechanism.actuated]
    return {c.name: own.index(c.name) for c in mechanism.actuated if c.name in own}


def matrix_of(rates: Rates, kind: JacobianKind, mechanism: Mechanism) -> Matrix:
    """A Jacobian of one of the kinds, its passive joints in the order of a description. Raises
    InputError where no joint is passive.
    """
    own = driven_places(rates, mechanism)
    joints, places = tuple(own), list(own.values())
    if kind == "direct":
        return Matrix(TWIST, joints, rates.direct[:, places])
    if kind == "inverse":
        return Matrix(joints, TWIST, rates.inverse[places, :])
    if kind == "analytic":
        pose = rates.closure.role("pose")
        rows = tuple(name for c in pose for name in names_of(c.name, c.width))
        told = (pose_rates(c, rates.quaternion, rates.direct[:, places]) for c in pose)
        return Matrix(rows, joints, ca.sparsify(ca.vertcat(*told)))
    passive = passive_rates(rates.closure, rates.split(rates.following), rates.free)
    if not passive:
        raise InputError(
            f"{mechanism.name} has no passive joint whose rate the actuated joints decide; "
            f"allowed kinds: direct, inverse, analytic; or name coordinates: --of NAMES "
            f"--by NAMES"
        )
    listed = [c for c in mechanism.coordinates if c.name in passive]
    rows = rate_names(listed)
    return Matrix(
        rows, joints, ca.sparsify(ca.vertcat(*(passive[c.name] for c in listed)))[:, places]
    )
