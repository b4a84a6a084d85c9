"""Name a Jacobian's rows, columns and inputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import casadi as ca

from symkin.closure.closure import Closure
from symkin.model.names import identifier

JacobianKind = Literal["direct", "inverse", "analytic", "passive"]
KINDS: tuple[JacobianKind, ...] = get_args(JacobianKind)
TWIST = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Components of a twist: velocity of the platform's or tool's origin, angular velocity, base
frame.
"""
_TAKEN = ("jacobian", "jac", "hess", "null")
"""Names that CasADi's functions keep for themselves, and that of the output."""


@dataclass(frozen=True)
class Variable:
    """One number that an expression reads: `name` is an identifier, `source` the coordinate's (with
    the component of a quaternion) or the parameter's own name, `unit` that of the number; `index`
    its place in the closure's vector and `coordinate` the coordinate or parameter that it belongs
    to.
    """

    name: str
    source: str
    unit: str
    index: int
    coordinate: str


@dataclass(frozen=True, eq=False)
class Matrix:
    """A matrix of rates by rates as an expression, and the names of its rows and columns."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    expression: ca.SX


def variables_read(
    closure: Closure, expression: ca.SX, *, explicit: bool = False
) -> tuple[tuple[Variable, ...], tuple[Variable, ...]]:
    """The coordinates and the parameters that an expression reads; of a serial arm (`explicit`) all
    joints.
    """
    taken = set(_TAKEN)
    size = closure.variables.shape[0]
    used = ca.which_depends(
        ca.vec(ca.densify(expression)), ca.vertcat(closure.variables, closure.parameters), 1, False
    )
    inputs, numbers = [], []
    for c in closure.coordinates:
        unit = "1" if c.is_rotation else "rad" if c.is_angular else closure.mechanism.length_unit
        for k, source in enumerate(names_of(c.name, c.width)):
            name = _identifier(source, taken)
            if used[closure.slices[c.name].start + k] or (explicit and c.role == "actuated"):
                inputs.append(
                    Variable(name, source, unit, closure.slices[c.name].start + k, c.name)
                )
    for k, source in enumerate(closure.parameter_names):
        if used[size + k]:
            numbers.append(Variable(_identifier(source, taken), source, "", k, source))
    return tuple(inputs), tuple(numbers)


def names_of(name: str, width: int) -> list[str]:
    """The names of a coordinate's numbers, without the pose's prefix."""
    if width == 1:
        return [name.removeprefix("pose.")]
    return (
        ["qw", "qx", "qy", "qz"]
        if name == "pose.quaternion"
        else [f"{name}.{letter}" for letter in "wxyz"]
    )


def _identifier(name: str, taken: set[str]) -> str:
    """An identifier that no other has, in capitals or not."""
    stem = text = identifier(name)
    number = 2
    while text.lower() in taken:
        text, number = f"{stem}_{number}", number + 1
    taken.add(text.lower())
    return text
