"""Differentiate the rows of a map along its own motion: once, for rates, and twice, for the second
derivatives.

With state X, known values q and rows F(q, X) = 0, a motion of q has a step S of the state with
F_X S_j = -F_j. Differentiated once more along the motion of another known value,
F_X S_jk = -D_k D_j F, where D_j differentiates along q_j and S_j together; S_jk are the second
derivatives of the state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.snapping import snapped_expression
from symkin.codegen.map.joint_map import Direction, JointMap
from symkin.codegen.steps.newton_kernel import Kernel, moves
from symkin.codegen.text.angles import numbers_at
from symkin.codegen.text.c import Emitter, block
from symkin.codegen.text.templates import fill
from symkin.computed_once import lru_cache
from symkin.model.joint import Coordinate, places_of


@lru_cache(maxsize=32)
def row_derivatives(direction: Direction) -> ca.Function:
    """Give the derivatives (m, n) of the kernel's rows by the known values, of (state, numbers)."""
    circles = direction.circles
    kernel, numbers = circles.kernel, circles.numbers
    tangent = _tangent(direction.known, numbers)
    return _function(
        ca.mtimes(ca.jacobian(circles.rows_by_numbers, numbers), tangent),
        [kernel.state, numbers],
    )


@lru_cache(maxsize=32)
def row_bends(direction: Direction) -> ca.Function:
    """Give the second derivatives (m, pairs) of the kernel's rows along two known values each, of
    (state, numbers, rates), where column j of `rates` moves the state with known value j. The pairs
    j <= k stand in the order k (k + 1) / 2 + j. Two turns of one quaternion are taken in one order:
    in the other they differ by a turn of the same quaternion, which moves no other coordinate.
    """
    circles = direction.circles
    state, numbers, n = circles.kernel.state, circles.numbers, len(direction.known)
    rates = ca.SX.sym("s", circles.kernel.step.numel(), n)
    everything, motions = ca.vertcat(state, numbers), ca.vertcat(rates, ca.SX.eye(n))
    tangent = ca.diagcat(_tangent(direction.unknown, state), _tangent(direction.known, numbers))
    # the entries of a row's Hessian serve all pairs
    count = tangent.shape[1]
    along = [ca.jtimes(circles.rows_by_numbers, everything, tangent[:, a]) for a in range(count)]
    bent = {
        (a, b): ca.jtimes(along[b], everything, tangent[:, a])
        for a in range(count)
        for b in range(a + 1)
    }
    rows = []
    for i in range(circles.kernel.m):
        hessian = ca.sparsify(
            ca.blockcat(
                [[bent[max(a, b), min(a, b)][i] for b in range(count)] for a in range(count)]
            )
        )
        turned = [ca.mtimes(hessian, motions[:, k]) for k in range(n)]
        rows.append([ca.dot(motions[:, j], turned[k]) for k in range(n) for j in range(k + 1)])
    return _function(ca.blockcat(rows), [state, numbers, rates])


def derivatives(made: JointMap, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give the Jacobian (found, given) and the second derivatives (found, given, given) at a
    configuration of the closure.
    """
    direct = made.direct
    circles, kernel, n = direct.circles, direct.kernel, len(made.given)
    numbers, state = (
        numbers_at(part, direct.problem.select_values(values, part))
        for part in (direct.known, direct.unknown)
    )
    matrix = kernel.matrix(state, circles.known_at(numbers), np.zeros(0))

    def solved(function: ca.Function, *read: np.ndarray) -> np.ndarray:
        sides = ca.DM(function(*read)).full()
        return np.linalg.lstsq(matrix, sides, rcond=1e-12)[0]

    steps = solved(row_derivatives(direct), state, numbers)
    scales = [scale for _, scale in step_columns(direct.unknown, direct.unknown, made.size)]
    bends = solved(row_bends(direct), state, numbers, steps * np.array(scales)[:, None])
    lower = np.tril_indices(n)
    first, second = np.zeros((n, n)), np.zeros((n, n, n))
    for i, (column, scale) in enumerate(step_columns(direct.unknown, made.found, made.size)):
        first[i] = steps[column] * scale
        second[i][lower] = bends[column] * scale
        second[i].T[lower] = second[i][lower]
    return first, second


def summed(term: str, count: int) -> list[str]:
    """Statements that set result[i] to the sum of a term over j."""
    return [
        "result[i] = 0.0;",
        *block(f"for (int j = 0; j < {count}; ++j)", [f"result[i] += {term};"]),
    ]


@dataclass(frozen=True, eq=False)
class SolvedColumns:
    """Rates by the matrix of a kernel whose functions begin with `k`: a function `columns` gives
    right-hand sides, row by row, of motions that are solved one after the other. `values` are those
    of all templates; `given`, steps that it reads beside the state.
    """

    kernel: Kernel
    k: str
    columns: str
    count: int
    values: Mapping[str, object]
    given: str = ""

    @property
    def _given(self) -> str:
        return self.given.split("[")[0]

    @property
    def size(self) -> int:
        """Numbers of all right-hand sides."""
        return self.kernel.m * self.count

    def text(self, about: str, emitter: Emitter) -> str:
        """The function, of what an emitter has (rows, motions)."""
        stores = [
            f"sides[{self.count * i + j}] = {emitter.entry(i, j)};"
            for i in range(self.kernel.m)
            for j in range(self.count)
        ]
        given = f"const {self.values['real']} {self.given}, " if self.given else ""
        unused = f"(void){self._given};" if given else ""
        own = {"about": about, "columns": self.columns, "k": self.k, "nsides": self.size}
        own |= {"given": given, "unused": unused}
        shown = {**self.values, **own, "sides": [*emitter.lines, *stores]}
        return fill("columns.c", shown)

    def solved(self, stores: Sequence[str]) -> list[str]:
        """Statements that solve for motion j after motion j, and then store its rates."""
        read = f"&w, {self._given}, " if self.given else "&w, "
        return [
            f"{self.columns}(GEOMETRY {read}sides);",
            f"for (int j = 0; j < {self.count}; ++j) {{",
            f"    for (int i = 0; i < {self.kernel.m}; ++i) {{",
            f"        w.f[i] = sides[{self.count} * i + j];",
            "    }",
            f"    real s[{self.kernel.n}];",
            f"    {self.k}_solve(&w, s);",
            *("    " + line for line in stores),
            "}",
        ]


def step_columns(
    unknown: Sequence[Coordinate], wanted: Sequence[Coordinate], size: float
) -> list[tuple[int, float]]:
    """List the places of each wanted coordinate in a step of the unknown ones, and what turns the
    step's length into its unit.
    """
    places = places_of(unknown, [c.freedom for c in unknown])
    return [(k, 1.0 / size if c.is_angular else 1.0) for c in wanted for k in places[c.name]]


def step_text(column: int, scale: float) -> str:
    """Write an entry of the step in its coordinate's unit."""
    return f"s[{column}]" + (f" * {scale}" if scale != 1.0 else "")


def _tangent(coordinates: tuple[Coordinate, ...], numbers: ca.SX) -> ca.SX:
    """Differentiate the numbers of coordinates by their values."""
    return moves(coordinates, numbers, ca.SX(sum(c.freedom for c in coordinates), 1), 1.0)[0]


def _function(expression: ca.SX, symbols: list[ca.SX]) -> ca.Function:
    expression = ca.densify(snapped_expression(expression, symbols))
    return ca.Function("f", symbols, [expression], {"cse": True})
