"""Name a Jacobian's rows, columns and inputs."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, Literal, get_args

import casadi as ca

from symkin.closure.closure import Closure
from symkin.computed_once import cached_property
from symkin.model.mechanism import Mechanism
from symkin.model.names import identifier
from symkin.result import Summary
from symkin.velocity.equations import VelocityEquations

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


def labels(
    equations: VelocityEquations, kind: JacobianKind
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    joints = tuple(c.name for c in equations.closure.role("actuated"))
    match kind:
        case "direct":
            return TWIST, joints
        case "inverse":
            return joints, TWIST
        case "passive":
            return equations.passive_names, joints
        case _:
            pose = [v for c in equations.closure.role("pose") for v in components(c.name, c.width)]
            return tuple(pose), joints


def variables_read(
    closure: Closure, expression: ca.SX, *, explicit: bool = False
) -> tuple[tuple[Variable, ...], tuple[Variable, ...]]:
    """The coordinates and the parameters that an expression reads; of a serial arm (`explicit`) all
    joints.
    """
    taken = set(_TAKEN)
    size = int(closure.variables.shape[0])
    used = ca.which_depends(
        ca.vec(ca.densify(expression)), ca.vertcat(closure.variables, closure.parameters), 1, False
    )
    inputs, numbers = [], []
    for c in closure.coordinates:
        unit = "1" if c.is_rotation else "rad" if c.is_angular else closure.mechanism.length_unit
        for k, source in enumerate(components(c.name, c.width)):
            name = _identifier(source, taken)
            if used[closure.slices[c.name].start + k] or (explicit and c.role == "actuated"):
                inputs.append(
                    Variable(name, source, unit, closure.slices[c.name].start + k, c.name)
                )
    for k, source in enumerate(closure.parameter_names):
        if used[size + k]:
            numbers.append(Variable(_identifier(source, taken), source, "", k, source))
    return tuple(inputs), tuple(numbers)


def components(name: str, width: int) -> list[str]:
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


# --- what every symbolic Jacobian is --------------------------------------------------------------


class SymbolicMatrix:
    """A matrix of rates by rates: `expression` reads the `symbols` of `inputs` (coordinates of a
    closure) and of `parameters`.
    """

    kind: str
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    expression: ca.SX
    inputs: tuple[Variable, ...]
    parameters: tuple[Variable, ...]

    @property
    @abstractmethod
    def closure(self) -> Closure: ...

    @property
    def mechanism(self) -> Mechanism:
        return self.closure.mechanism

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.rows), len(self.columns)

    @property
    def symbols(self) -> ca.SX:
        """Inputs, then parameters, as one column."""
        parts = [self.closure.variables[v.index] for v in self.inputs] + [
            self.closure.parameters[v.index] for v in self.parameters
        ]
        return ca.vertcat(ca.SX(0, 1), *parts)

    @cached_property
    def function(self) -> ca.Function:
        """A CasADi function of one scalar for each input and parameter, by name, with the output
        `jacobian`.
        """
        names = [v.name for v in (*self.inputs, *self.parameters)]
        outputs = [ca.densify(self.expression)]
        name = ca.Function.fix_name(f"{self.mechanism.name}_{self.kind}_jacobian")
        inputs = ca.vertsplit(self.symbols) if names else []
        return ca.Function(name, inputs, outputs, names, ["jacobian"], {"cse": True})

    def to_dict(self) -> dict[str, Any]:
        """What the matrix relates: kind, names of rows and columns, and what each entry reads."""
        return {
            "mechanism": self.mechanism.name,
            "kind": self.kind,
            "rows": list(self.rows),
            "columns": list(self.columns),
            "inputs": [{"name": v.name, "source": v.source, "unit": v.unit} for v in self.inputs],
            "parameters": [v.source for v in self.parameters],
        }

    def summary(self, most_rows: int | None = None) -> Summary:  # noqa: ARG002 - there is no table
        """The matrix' kind and shape, and the names of what it reads."""
        inputs = ", ".join(v.name for v in self.inputs) or "nothing"
        rows, columns = self.shape
        return Summary([f"{self.mechanism.name}: {self._what}, {rows} x {columns}, of {inputs}"])

    @property
    def _what(self) -> str:
        return f"{self.kind} Jacobian"
