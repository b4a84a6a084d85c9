"""What every symbolic Jacobian is: a matrix of expressions, and names of what it relates."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import casadi as ca

from symkin.closure.closure import Closure
from symkin.computed_once import cached_property
from symkin.model.mechanism import Mechanism
from symkin.result import Summary
from symkin.velocity.jacobian_names import Variable


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
