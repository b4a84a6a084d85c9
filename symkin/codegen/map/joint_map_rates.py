"""Write the C of a map's derivatives, first and second, and of what follows from them: rates,
torques, reflected inertia, limits of torque and rate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from symkin.codegen.map.map_direction import DirectionSource
from symkin.codegen.map.rates import row_bends, row_derivatives, step_columns, step_text
from symkin.codegen.steps.linear_solver import singular_condition
from symkin.codegen.text.c import Emitter
from symkin.codegen.text.templates import fill, substitute
from symkin.model.joint import Coordinate

_BELONG = 1e-2
"""Residual, in sizes, up to which joints and found values belong together."""
LARGEST = 1e20
"""Rates, torques and inertias beyond it are refused: their products stay below the largest
float.
"""


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
        ("result[i] = name_alone(&jacobian[@{nq} * i], 1, joint_limits);",),
    ),
    _Applied(
        "rate_limits",
        f"Largest rate {_LIMIT}",
        "inverse_jacobian",
        "joint_limits",
        "@{zero}",
        "found_limits",
        1,
        ("result[i] = name_alone(&inverse_jacobian[i], @{nq}, joint_limits);",),
    ),
)


def rates_text(direct: DirectionSource, inverse: DirectionSource) -> str:
    """All functions of derivatives of a map of two directions, and what follows from them."""
    n, common = direct.n, direct.common

    def filled(text: str) -> str:
        return substitute(text, common)

    applied = (
        fill(
            "map_applied.c",
            common
            | vars(one)
            | {
                "count": n**one.power,
                "least": filled(one.least),
                "body": [filled(line) for line in one.body],
            },
        )
        for one in _APPLIED
    )
    return "".join(
        [
            _columns(direct),
            _jacobian(
                direct,
                "jacobian",
                "Rates of the found coordinates by those of the joints: the matrix solved for each "
                "joint's column.",
            ),
            _columns(inverse),
            _jacobian(
                inverse,
                "inverse_jacobian",
                "Rates of the joints by those of the found coordinates.",
            ),
            _second(direct),
            fill("map_rates.c", common),
            *applied,
        ]
    )


def _emitted(way: DirectionSource, function: ca.Function, *more: list[str]) -> list[str]:
    """Statements that set `sides` to what a function gives, row by row."""
    emitter = Emitter(function, ["w->x", way.numbers_of_known, *more], way.real)
    rows, columns = function.size_out(0)
    stores = [
        f"sides[{columns * i + j}] = {emitter.entry(i, j)};"
        for i in range(rows)
        for j in range(columns)
    ]
    return [*emitter.lines, *stores]


def _names(way: DirectionSource) -> dict[str, object]:
    """Names that the templates of a direction's derivatives share."""
    of = "joint" if way.direction.name == "direct" else "found"
    return way.names | {
        "of": "joints" if of == "joint" else "found values",
        "columns": f"{of}_columns",
        "m": way.kernel.m,
        "nsides": way.kernel.m * way.n,
    }


def _columns(way: DirectionSource) -> str:
    lines = _emitted(way, row_derivatives(way.direction))
    return fill("map_columns.c", _names(way) | {"sides": lines})


def _jacobian(
    way: DirectionSource, function: str, about: str, steps: Sequence[str] = (), **more: object
) -> str:
    """A function of first derivatives; `steps`: statements for each step of the state, `more`:
    names of the template that stand for something else.
    """
    made, n, literal = way.made, way.n, way.real.literal
    y, state = way.state_of("found")
    set_ = [way.placed]
    if made.passive and way.direction.name == "inverse":
        # the state has the joints that are given, not those that the found values lead to
        places = way.places(made.given)
        set_ = [*way.circles("joints", made.given, "y", places), *set_]
    rates = _stores(way, way.wanted, "rates", n)
    nj, values = n * n, _names(way)
    shown = {
        "function": function,
        "about": about,
        "written": f"{way.real.type} {function}[{nj}]",
        "most_sides": values["nsides"],
        "nrates": nj,
        "kept": "",
        "y": y,
        "state": state,
        "set": set_,
        "near": literal(_BELONG * made.size),
        "singular": singular_condition(way.kernel, way.k, "&w"),
        "more": "",
        "store": [f"for (int i = 0; i < {nj}; ++i) {{", f"    {function}[i] = rates[i];", "}"],
        "rates": [*rates, *steps],
    }
    return fill("map_jacobian.c", values | shown | more)


def _stores(
    way: DirectionSource, wanted: Sequence[Coordinate], target: str, width: int, first: int = 0
) -> list[str]:
    """Statements that write column j of the wanted coordinates' rates from a step."""
    places = step_columns(way.unknown, wanted, way.made.size)
    return [
        f"{target}[{first + width * i} + j] = {step_text(way.real, *place)};"
        for i, place in enumerate(places)
    ]


def _second(way: DirectionSource) -> str:
    """The function of second derivatives."""
    n, freedom, m = way.n, way.direction.problem.system.freedom, way.kernel.m
    real, pairs = way.real.type, n * (n + 1) // 2
    moved = [f"steps[{freedom * j + i}]" for j in range(n) for i in range(freedom)]
    places = step_columns(way.unknown, way.unknown, way.made.size)
    values = _names(way) | {
        "pairs": pairs,
        "nsteps": n * freedom,
        "nbends": m * pairs,
        "bends": _emitted(way, row_bends(way.direction), moved),
        "seconds": _stores(way, way.wanted, "rates", pairs, n * n),
    }
    return fill("map_bends.c", values) + _jacobian(
        way,
        "second",
        "Jacobian, if it is asked for, and second derivatives: the same matrix solved for the "
        "rows' second derivatives.",
        [
            f"steps[{freedom} * j + {i}] = {step_text(way.real, *place)};"
            for i, place in enumerate(places)
        ],
        written=f"{real} jacobian[{n * n}], {real} second[{n**3}]",
        most_sides=m * max(n, pairs),
        nrates=n * n + n * pairs,
        kept=[f"{real} steps[{n * freedom}];"],
        more=fill("map_second.c", values).splitlines(),
        store=fill("map_give_second.c", values).splitlines(),
    )
