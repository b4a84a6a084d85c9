"""Write the C of a map between joints: both directions, one step of each, its derivatives, first
and second, and of what follows from them: rates, torques, reflected inertia, limits of torque and
rate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symkin.codegen.map.joint_map_values import MapValues
from symkin.codegen.map.map_direction import DirectionSource
from symkin.codegen.map.rates import (
    SolvedColumns,
    row_bends,
    row_derivatives,
    step_columns,
    step_text,
    summed,
)
from symkin.codegen.steps.guard_text import Watched
from symkin.codegen.steps.joint_ranges import Range, check_text, range_functions, ranges_of
from symkin.codegen.steps.linear_solver import singular_condition
from symkin.codegen.steps.newton_source import NewtonCode
from symkin.codegen.text.angles import number_counts
from symkin.codegen.text.c import Emitter, if_ok
from symkin.codegen.text.templates import (
    FARTHEST,
    common_values,
    copy_loop,
    farthest,
    fill,
    substitute,
)
from symkin.codegen.text.turns import angle_of_direction, cosine_and_sine
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate, units_of


@dataclass(frozen=True, eq=False)
class JointMapSource(MapValues):
    """The C of one map, function by function."""

    @cached_property
    def ways(self) -> tuple[DirectionSource, DirectionSource]:
        """The direct problem and the inverse one."""
        direct, inverse = (
            DirectionSource(self.made, d, self._common)
            for d in (self.made.direct, self.made.inverse)
        )
        return direct, inverse

    @property
    def code(self) -> NewtonCode:
        """Newton's method of the direct problem."""
        return self.ways[0].code

    @property
    def watched(self) -> dict[str, Watched]:
        """What each direction watches along lines."""
        return {way.direction.name: way.watched for way in self.ways}

    @cached_property
    def _common(self) -> dict[str, object]:
        made = self.made
        n = len(made.given)
        return common_values(self.name, self.real, struct=False) | {
            "nq": n,
            "nj": n * n,
            "ny": sum(number_counts(made.coordinates)),
            "farthest": farthest(made.size, (0.0, 0.0, 0.0)),
            "largest": self.real.literal(LARGEST),
        }

    @cached_property
    def values(self) -> dict[str, object]:
        """Values of the names in the templates of this kind, the tests and the header."""
        note = "What the values leave to other joints is as at the reference configuration."
        return self._common | {"passive_note": note if self.made.passive else ""}

    @property
    def text(self) -> str:
        """Everything of NAME.c between its beginning and end."""
        direct, inverse = self.ways
        body = "".join(
            [
                *(way.solver_text for way in self.ways),
                inverse.state_text,
                direct.state_text,
                *(way.away_text for way in self.ways),
                *(way.text for way in self.ways),
                fill("map_give.c", self._common),
                rates_text(direct, inverse),
            ]
        )
        return fill("info.c", self._common) + self._tools(body) + body

    # --- parts ------------------------------------------------------------------------------------

    def _tools(self, text: str) -> str:
        """The functions of angles that a text calls, and the checks of values."""
        common = self._common
        turn = cosine_and_sine(self.real, common) if "_cosine_and_sine(" in text else ""
        turning = self.turning(text, common)
        angle = angle_of_direction(self.real, common, text)
        return "".join([angle, turn, turning, self._checks, fill("no_step.c", common)])

    @property
    def _checks(self) -> str:
        """Checks of joints and of found values: against limits, and of guesses, which need not keep
        to them.
        """
        real, size, common, found = self.real, self.made.size, self._common, list[str]()
        for what, coordinates in self.made.told.items():
            ranges = ranges_of(coordinates, real, size)
            far = [str(FARTHEST * unit) for unit in units_of(coordinates, size)]
            bounds = [Range(f"-{most}", most) for most in far]
            found += [
                range_functions(ranges, real, common)
                if what == "joints"
                else check_text("found values", "ranges", "limit_found", ranges, common),
                check_text(f"{what} of a guess", "bounds", f"bound_{what}", bounds, common),
            ]
        return "".join(found)


# --- rates ----------------------------------------------------------------------------------------


_BELONG = 1e-2
"""Residual, in sizes, up to which joints and found values belong together."""
LARGEST = 1e20
"""Rates, torques and inertias beyond it are refused: their products stay below the largest
float.
"""


_ALONE = "of each found coordinate alone, the others without any, within limits of the joints."
_APPLIED = (
    (
        "rates",
        "found_rates = J joint_rates.",
        ("joint_rates", "found_rates"),
        "jacobian[@{nq} * i + j] * joint_rates[j]",
    ),
    (
        "torques",
        "joint_torques = J^T found_torques: the power of the joints is that of the found "
        "coordinates.",
        ("found_torques", "joint_torques"),
        "jacobian[@{nq} * j + i] * found_torques[j]",
    ),
    (
        "inertia",
        "inertia = G^T joint_inertias G with the inverse Jacobian G: the kinetic energy of both "
        "sides is the same.",
        ("joint_inertias", "inertia"),
        "inverse_jacobian[@{nq} * j + i / @{nq}] * joint_inertias[j] "
        "* inverse_jacobian[@{nq} * j + i % @{nq}]",
    ),
    (
        "torque_limits",
        f"Largest torque {_ALONE}",
        ("joint_limits", "found_limits"),
        "name_alone(&jacobian[@{nq} * i], 1, joint_limits)",
    ),
    (
        "rate_limits",
        f"Largest rate {_ALONE}",
        ("joint_limits", "found_limits"),
        "name_alone(&inverse_jacobian[i], @{nq}, joint_limits)",
    ),
)
"""Functions of a Jacobian: what they do, what is given and asked, and the terms over joints j of
each entry i, or the entry of a limit.
"""


def _applied(row: tuple[str, str, tuple[str, str], str], common: Mapping[str, object]) -> str:
    """A function of a Jacobian that is applied to values."""
    function, about, (given, asked), term = row
    n = int(str(common["nq"]))
    body = [f"result[i] = {term};"] if given == "joint_limits" else summed(term, n)
    matrix = "inverse_jacobian" if "inverse" in term else "jacobian"
    count = n * n if function == "inertia" else n
    shown = {
        "function": function,
        "about": about,
        "at": substitute("const name_real joints[@nq], const name_real found[@nq]", common),
        "matrix": matrix,
        "before": "NAME_OK",
        "then": if_ok([f"status = name_{matrix}(joints, found, {matrix});"]),
        "given": given,
        "taken": n,
        # rates and torques have either sign
        "least": f"-{common['largest']}" if function in ("rates", "torques") else "0.0",
        "asked": asked,
        "count": count,
        "body": [substitute(line, common) for line in body],
        "give": f"status = name_give(result, {asked}, {count});",
    }
    return fill("applied.c", {**common, **shown})


def rates_text(direct: DirectionSource, inverse: DirectionSource) -> str:
    """All functions of derivatives of a map of two directions, and what follows from them."""
    common = direct.common

    return "".join(
        [
            _columns(direct)[1],
            _jacobian(
                direct,
                "jacobian",
                "Rates of the found coordinates by those of the joints: the matrix solved for each "
                "joint's column.",
            ),
            _columns(inverse)[1],
            _jacobian(
                inverse,
                "inverse_jacobian",
                "Rates of the joints by those of the found coordinates.",
            ),
            _second(direct),
            fill("check_sizes.c", common),
            fill("map_rates.c", common),
            *(_applied(row, common) for row in _APPLIED),
        ]
    )


def _columns(way: DirectionSource) -> tuple[SolvedColumns, str]:
    """The rates by each known value, and the function of their right-hand sides."""
    of, what = ("joint", "joints") if way.is_direct else ("found", "found values")
    solved = SolvedColumns(way.kernel, way.k, f"{way.name}_{of}_columns", way.n, way.names)
    emitter = Emitter(row_derivatives(way.direction), ["w->x", way.numbers_of_known], way.real)
    return solved, solved.text(f"Derivatives of the rows by the {what}, row by row.", emitter)


def _jacobian(
    way: DirectionSource, function: str, about: str, steps: Sequence[str] = (), **more: object
) -> str:
    """A function of first derivatives; `steps`: statements for each step of the state, `more`:
    names of the template that stand for something else.
    """
    made, n = way.made, way.n
    y, state = way.state_of("found")
    set_ = [f"{way.k}_place(&w, {way.words[0]}, {way.names['from']});"]
    if made.passive and not way.is_direct:
        # the state has the joints that are given, not those that the found values lead to
        places = way.places(made.given)
        set_ = [*way.circles("joints", made.given, "y", places), *set_]
    rates = _stores(way, way.wanted, "rates", n)
    nj, solved = n * n, _columns(way)[0]
    shown = {
        "function": function,
        "about": about,
        "written": f"real {function}[{nj}]",
        "most_sides": solved.size,
        "nrates": nj,
        "kept": "",
        "y": y,
        "state": state,
        "set": set_,
        "near": _BELONG * made.size,
        "singular": singular_condition(way.kernel, way.k, "&w"),
        "more": "",
        "store": copy_loop(function, "rates", nj),
        "rates": solved.solved([*rates, *steps]),
    }
    return fill("map_jacobian.c", way.names | shown | more)


def _stores(
    way: DirectionSource, wanted: Sequence[Coordinate], target: str, width: int, first: int = 0
) -> list[str]:
    """Statements that write column j of the wanted coordinates' rates from a step."""
    places = step_columns(way.unknown, wanted, way.made.size)
    return [
        f"{target}[{first + width * i} + j] = {step_text(*place)};"
        for i, place in enumerate(places)
    ]


def _second(way: DirectionSource) -> str:
    """The function of second derivatives."""
    n, freedom = way.n, way.direction.problem.system.freedom
    real, pairs = way.real.type, n * (n + 1) // 2
    moved = [f"steps[{freedom * j + i}]" for j in range(n) for i in range(freedom)]
    places = step_columns(way.unknown, way.unknown, way.made.size)
    bends = SolvedColumns(
        way.kernel, way.k, f"{way.name}_joint_bends", pairs, way.names, f"steps[{n * freedom}]"
    )
    about = (
        "Second derivatives of the rows along the motions of two joints each: pair k (k + 1) / 2 + "
        "j is of the joints j <= k, of which each moves the state by its steps."
    )
    inputs = ["w->x", way.numbers_of_known, moved]
    text = bends.text(about, Emitter(row_bends(way.direction), inputs, way.real))
    return text + _jacobian(
        way,
        "second",
        "Jacobian, if it is asked for, and second derivatives: the same matrix solved for the "
        "rows' second derivatives.",
        [f"steps[{freedom} * j + {i}] = {step_text(*place)};" for i, place in enumerate(places)],
        written=f"{real} jacobian[{n * n}], {real} second[{n**3}]",
        most_sides=way.kernel.m * max(n, pairs),
        nrates=n * n + n * pairs,
        kept=[f"{real} steps[{n * freedom}];"],
        more=bends.solved(_stores(way, way.wanted, "rates", pairs, n * n)),
        store=fill("map_give_second.c", way.names | {"pairs": pairs}).splitlines(),
    )
