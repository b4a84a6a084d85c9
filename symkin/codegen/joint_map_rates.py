"""Write the C of a map's rates and torques: its Jacobian from the rows' derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from symkin.closure.snapping import snapped_expression
from symkin.codegen.joint_map import Direction, JointMap
from symkin.codegen.linear_solver import singular_condition
from symkin.codegen.text.c import Emitter, Real, indent, indexed
from symkin.codegen.text.templates import fill
from symkin.model.joint import Coordinate

_BELONG = 1e-2
"""Residual, in sizes, up to which joints and found values belong together."""
_LARGEST = 1e20
"""Rates and torques beyond it are refused: their products stay below the largest float."""


def step_columns(
    direction: Direction, wanted: Sequence[Coordinate], real: Real, size: float
) -> list[tuple[int, str]]:
    """Place of each wanted coordinate in a step, and what turns the step's length into its unit."""
    places, column = {}, 0
    for c in direction.unknown:
        places[c.name] = (column, f" * {real.literal(1.0 / size)}" if c.is_angular else "")
        column += c.freedom
    return [places[c.name] for c in wanted]


@dataclass(frozen=True, eq=False)
class MapRates:
    """The functions of rates; `common`: values of the names in all templates of the map."""

    made: JointMap
    common: dict[str, object]

    @property
    def text(self) -> str:
        """NAME_rates and NAME_torques."""
        made, direct, literal = self.made, self.made.direct, self.made.real.literal
        kernel, n, prefix = direct.kernel, len(made.given), self.made.name.upper()
        y, state = [], []
        if made.passive:
            y = [
                f"{self.made.real.type} y[{self.common['ny']}];",
                f"{self.made.real.type} at[{n}];",
            ]
            state = [
                f"if (status == {prefix}_OK) {{",
                f"    status = {self.made.name}_state_of_found(found, y, at);",
                "}",
            ]
        set_ = [f"{self.made.name}_direct_place(&w, joints, {'y' if made.passive else 'found'});"]
        rows = [
            f"rates[{n * i} + j] = w.f[{column}]{scale};"
            for i, (column, scale) in enumerate(
                step_columns(direct, made.found, self.made.real, made.size)
            )
        ]
        return fill(
            "map_rates.c",
            self.common
            | {
                "largest": self.made.real.literal(_LARGEST),
                "nsides": kernel.m * n,
                "m": kernel.m,
                "sides": indent(self._sides),
                "y": indent(y),
                "state": indent(state),
                "set": indent(set_, 2),
                "near": literal(_BELONG * made.size),
                "singular": singular_condition(kernel, f"{self.made.name}_direct", "&w"),
                "rates": indent(rows, 4),
            },
        )

    @property
    def _sides(self) -> list[str]:
        """Statements of the rows' derivatives by the given coordinates."""
        circles, given = self.made.direct.circles, self.made.given
        kernel, numbers = circles.kernel, circles.numbers
        tangent, place = ca.SX(int(numbers.shape[0]), len(given)), 0
        for i, c in enumerate(given):
            if c.kind == "angle":
                tangent[place, i], tangent[place + 1, i] = -numbers[place + 1], numbers[place]
                place += 2
            else:
                tangent[place, i] = 1.0
                place += 1
        sides = snapped_expression(
            ca.mtimes(ca.jacobian(circles.rows_by_numbers, numbers), tangent),
            [kernel.state, numbers],
        )
        function = ca.Function("sides", [kernel.state, numbers], [ca.densify(sides)], {"cse": True})
        emitter = Emitter(
            function,
            [
                indexed("w->x", int(kernel.state.shape[0])),
                indexed("w->k" if circles.is_plain else "w->numbers", int(numbers.shape[0])),
            ],
            self.made.real,
        )
        stores = [
            f"sides[{len(given) * i + j}] = {emitter.entry(i, j)};"
            for i in range(kernel.m)
            for j in range(len(given))
        ]
        return [*emitter.lines, *stores]
