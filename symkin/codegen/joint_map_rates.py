"""Write the C of a map's derivatives, first and second, and of what follows from them: rates,
torques, reflected inertia, limits of torque and rate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from symkin.codegen.joint_map import Direction, JointMap
from symkin.codegen.joint_map_derivatives import row_bends, row_derivatives, step_columns
from symkin.codegen.joint_map_values import MapValues
from symkin.codegen.linear_solver import singular_condition
from symkin.codegen.text.c import Emitter, Real, indent, indexed
from symkin.codegen.text.templates import fill, substitute

_BELONG = 1e-2
"""Residual, in sizes, up to which joints and found values belong together."""
LARGEST = 1e20
"""Rates, torques and inertias beyond it are refused: their products stay below the largest
float.
"""


def step_text(real: Real, column: int, scale: float) -> str:
    """Write an entry of the step in its coordinate's unit."""
    return f"w.f[{column}]" + (f" * {real.literal(scale)}" if scale != 1.0 else "")


@dataclass(frozen=True)
class _Applied:
    """A function of a matrix: what of size N is given and of which least value, what is asked, of
    which size in powers of N, and the statements of each entry i.
    """

    function: str
    about: str
    matrix: str
    given: str
    least: str
    asked: str
    power: int
    body: tuple[str, ...]


_SUM = ("result[i] = @{zero};", "for (int j = 0; j < @{nq}; ++j) {", "    result[i] += %s;", "}")
_LIMIT = "of each found coordinate alone, the others without any, within limits of the joints."
_APPLIED = (
    _Applied(
        "rates",
        "found_rates = J joint_rates.",
        "jacobian",
        "joint_rates",
        "-@{largest}",
        "found_rates",
        1,
        (*_SUM[:2], _SUM[2] % "jacobian[@{nq} * i + j] * joint_rates[j]", _SUM[3]),
    ),
    _Applied(
        "torques",
        "joint_torques = J^T found_torques: the power of the joints is that of the found "
        "coordinates.",
        "jacobian",
        "found_torques",
        "-@{largest}",
        "joint_torques",
        1,
        (*_SUM[:2], _SUM[2] % "jacobian[@{nq} * j + i] * found_torques[j]", _SUM[3]),
    ),
    _Applied(
        "inertia",
        "inertia = G^T joint_inertias G with the inverse Jacobian G: the kinetic energy of both "
        "sides is the same.",
        "inverse_jacobian",
        "joint_inertias",
        "@{zero}",
        "inertia",
        2,
        (
            *_SUM[:2],
            _SUM[2] % "inverse_jacobian[@{nq} * j + i / @{nq}] * joint_inertias[j] "
            "* inverse_jacobian[@{nq} * j + i % @{nq}]",
            _SUM[3],
        ),
    ),
    _Applied(
        "torque_limits",
        f"Largest torque {_LIMIT}",
        "jacobian",
        "joint_limits",
        "@{zero}",
        "found_limits",
        1,
        ("result[i] = @{p}_alone(&jacobian[@{nq} * i], 1, joint_limits);",),
    ),
    _Applied(
        "rate_limits",
        f"Largest rate {_LIMIT}",
        "inverse_jacobian",
        "joint_limits",
        "@{zero}",
        "found_limits",
        1,
        ("result[i] = @{p}_alone(&inverse_jacobian[i], @{nq}, joint_limits);",),
    ),
)


@dataclass(frozen=True, eq=False)
class MapRates:
    """The functions of derivatives; `common`: values of the names in all templates of the map."""

    numbers: MapValues
    common: dict[str, object]

    @property
    def made(self) -> JointMap:
        return self.numbers.made

    @property
    def text(self) -> str:
        """All of them."""
        made, n = self.made, len(self.made.given)
        return "".join(
            [
                self._columns(made.direct),
                self._jacobian(
                    made.direct,
                    "jacobian",
                    "Rates of the found coordinates by those of the joints: the matrix solved for "
                    "each joint's column.",
                ),
                self._columns(made.inverse),
                self._jacobian(
                    made.inverse,
                    "inverse_jacobian",
                    "Rates of the joints by those of the found coordinates.",
                ),
                self._second,
                fill("map_rates.c", self.common),
                *(
                    fill(
                        "map_applied.c",
                        self.common
                        | vars(applied)
                        | {
                            "count": n**applied.power,
                            "least": self._filled(applied.least),
                            "body": indent([self._filled(line) for line in applied.body], 3),
                        },
                    )
                    for applied in _APPLIED
                ),
            ]
        )

    def _filled(self, text: str) -> str:
        return substitute(text, self.common)

    def _emitted(self, direction: Direction, function: ca.Function, *more: list[str]) -> list[str]:
        """Statements that set `sides` to what a function gives, row by row."""
        circles = direction.circles
        emitter = Emitter(
            function,
            [
                indexed("w->x", int(circles.kernel.state.shape[0])),
                indexed(
                    "w->k" if circles.is_plain else "w->numbers", int(circles.numbers.shape[0])
                ),
                *more,
            ],
            self.made.real,
        )
        rows, columns = function.size_out(0)
        stores = [
            f"sides[{columns * i + j}] = {emitter.entry(i, j)};"
            for i in range(rows)
            for j in range(columns)
        ]
        return [*emitter.lines, *stores]

    def _of(self, direction: Direction) -> dict[str, object]:
        """Names that the templates of a direction's derivatives share."""
        k = f"{self.made.name}_{direction.name}"
        of = "joint" if direction.name == "direct" else "found"
        return self.common | {
            "k": k,
            "of": "joints" if of == "joint" else "found values",
            "columns": f"{of}_columns",
            "m": direction.kernel.m,
            "nsides": direction.kernel.m * len(self.made.given),
        }

    def _columns(self, direction: Direction) -> str:
        lines = self._emitted(direction, row_derivatives(direction))
        return fill("map_columns.c", self._of(direction) | {"sides": indent(lines)})

    def _jacobian(
        self,
        direction: Direction,
        function: str,
        about: str,
        steps: Sequence[str] = (),
        **more: object,
    ) -> str:
        """A function of first derivatives; `steps`: statements for each step of the state, `more`:
        names of the template that stand for something else.
        """
        made, values = self.made, self._of(direction)
        n, prefix, k = len(made.given), made.name.upper(), values["k"]
        wanted, known, others = made.found, "joints", "found"
        if direction.name == "inverse":
            wanted, known, others = made.given, "found", "joints"
        y, state = [], []
        if made.passive:
            y = [f"{made.real.type} y[{self.common['ny']}];", f"{made.real.type} at[{n}];"]
            state = [
                f"if (status == {prefix}_OK) {{",
                f"    status = {made.name}_state_of_found(found, y, at);",
                "}",
            ]
        set_ = [f"{k}_place(&w, {known}, {'y' if made.passive else others});"]
        if made.passive and direction.name == "inverse":
            # the state has the joints that are given, not those that the found values lead to
            places = self.numbers.places(made.given)
            set_ = [*self.numbers.circles("joints", made.given, "y", places), *set_]
        rates = [
            f"rates[{n * i} + j] = {step_text(made.real, *place)};"
            for i, place in enumerate(step_columns(direction.unknown, wanted, made.size))
        ]
        nj, nsides = n * n, values["nsides"]
        shown = {
            "function": function,
            "about": about,
            "written": f"{made.real.type} {function}[{nj}]",
            "most_sides": nsides,
            "nrates": nj,
            "kept": "",
            "y": indent(y),
            "state": indent(state),
            "set": indent(set_, 2),
            "near": made.real.literal(_BELONG * made.size),
            "singular": singular_condition(direction.kernel, f"{k}", "&w"),
            "more": "",
            "store": indent(
                [f"for (int i = 0; i < {nj}; ++i) {{", f"    {function}[i] = rates[i];", "}"], 2
            ),
            "rates": indent([*rates, *steps], 4),
        }
        return fill("map_jacobian.c", values | shown | more)

    @property
    def _second(self) -> str:
        """The function of second derivatives."""
        made, direct, real = self.made, self.made.direct, self.made.real.type
        n, freedom, m = len(made.given), direct.problem.system.freedom, direct.kernel.m
        pairs = n * (n + 1) // 2
        steps = [f"steps[{freedom * j + i}]" for j in range(n) for i in range(freedom)]
        values = self._of(direct) | {
            "pairs": pairs,
            "nsteps": n * freedom,
            "nbends": m * pairs,
            "bends": indent(self._emitted(direct, row_bends(direct), steps)),
            "seconds": indent(
                [
                    f"rates[{n * n + pairs * i} + j] = {step_text(made.real, *place)};"
                    for i, place in enumerate(step_columns(direct.unknown, made.found, made.size))
                ]
            ),
        }
        return fill("map_bends.c", values) + self._jacobian(
            direct,
            "second",
            "Jacobian, if it is asked for, and second derivatives: the same matrix solved for the "
            "rows' second derivatives.",
            [
                f"steps[{freedom} * j + {i}] = {step_text(made.real, *place)};"
                for i, place in enumerate(step_columns(direct.unknown, direct.unknown, made.size))
            ],
            written=f"{real} jacobian[{n * n}], {real} second[{n**3}]",
            most_sides=m * max(n, pairs),
            nrates=n * n + n * pairs,
            kept=indent([f"{real} steps[{n * freedom}];"]),
            more=indent(fill("map_second.c", values).splitlines(), 3),
            store=indent(fill("map_give_second.c", values).splitlines(), 2),
        )
