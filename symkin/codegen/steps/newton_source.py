"""Write the C functions of one Newton kernel: work space, rows, linear solver, step, target and
driver.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.codegen.line_parts import LONGEST_TURN, LineParts
from symkin.codegen.steps.linear_solver import (
    GUARD,
    SINGULAR,
    LinearSolver,
    factor_calls,
    linear_solver,
)
from symkin.codegen.steps.newton_kernel import Kernel, rounded
from symkin.codegen.text.c import Emitter, Real, block, indexed
from symkin.codegen.text.templates import common_values, copy, copy_loop, fill
from symkin.computed_once import cached_property
from symkin.text import c_comment

_SURE = 25.0
"""Square of how much shorter than the second step a third one is that needs no fourth, though
|J_0^-1| |s_0| is above the size: there curvatures of 1 / size leave the theorem silent, and three
steps can contract towards a point where the rows have no root.
"""
_ROWS = 64.0
"""Roundings of the size by which rows are off."""
_LINE = 256.0
"""Roundings of the size in the rows below which a line is none: then the state stays where it was,
its rows held against the goal.
"""
_STANDS = 4.0
"""How many times the rounding of an answer's rows those of a guess may be off that is the answer:
it is rounded itself, and its rows are not solved once more.
"""
_COMMENT_WIDTH = 118
"""Characters of a comment line."""


@dataclass(frozen=True)
class Tuning:
    """Constants of the driver: tolerances as lengths, kappa^2 of a typical pose. Rows may leave
    `noise`, after a step more `rounding`.
    """

    tolerance: float
    floor: float
    rounding: float
    noise: float
    kappa2: float


def tolerance_of(real: Real, size: float) -> float:
    """Error of an answer (length unit) that is near what the type resolves of lengths of the
    size.
    """
    return real.epsilon * size * (1.0 if real.name == "float" else 1e4)


def tracked_error(tuning: Tuning, size: float) -> float:
    """The error of one step, up to the size, from which another one comes below the tolerance: an
    error e leaves kappa e^2 after one more, nothing where the rows are linear.
    """
    kappa = math.sqrt(tuning.kappa2)
    return min(math.sqrt(tuning.tolerance) / math.sqrt(kappa), size) if kappa else size


def tuning_of(kernel: Kernel, real: Real, kappa: float) -> Tuning:
    """Choose tolerances near what the type resolves. Of rows that are linear a step of the size is
    taken to leave the tolerance.
    """
    size = kernel.characteristic_length
    resolution, tolerance = real.epsilon * size, tolerance_of(real, size)
    kappa = max(kappa, tolerance / size**2)
    return Tuning(tolerance, 64.0 * resolution, 64.0 * resolution, 8.0 * resolution, kappa**2)


@dataclass(frozen=True, eq=False)
class NewtonCode:
    """The C functions NAME_KERNEL_... of one kernel.

    `geometry` is the C text of each geometry parameter, empty where they are numbers in the code;
    `matrices` are samples of the kernel's matrix, over which pivots are chosen; `kappa` is its
    curvature; `target_lines` are statements that set w->k from w->at, `to` and `part`. What differs
    from one kind of mechanism to another has defaults: `known_count` numbers in `to`; `on_the_way`,
    whether the rows can vanish at all points of the line; `first_turn`, the largest turn of a known
    value (rad) that is tried first; `measured`, whether the ratio of steps says how far the next
    part reaches; `members`, more members of the work space; `matrix`, statements that fill w->a,
    where something shorter than the emitted ones is known; `retarget`, the call that aims anew and
    puts the state back, where known values at the guess are not kept; `keeps_known`: the matrix
    reads w->k0, the known values at the part of the line that is done, which are kept where they
    take long to compute: who begins a line sets them, or, where it `makes_known`, the line itself;
    `compact`: one factorisation, in loops.
    """

    kernel: Kernel
    name: str
    real: Real
    geometry: Sequence[str]
    matrices: np.ndarray
    kappa: float
    target_lines: Sequence[str]
    known_count: int | None = None
    first_turn: float = LONGEST_TURN
    measured: bool = False
    on_the_way: bool = True
    members: Sequence[str] = ()
    matrix: Sequence[str] = ()
    retarget: str = ""
    keeps_known: bool = False
    makes_known: bool = False
    numbers: int = 0
    compact: bool = False

    @property
    def k(self) -> str:
        """What the names of the functions begin with."""
        return f"{self.name}_{self.kernel.name}"

    @cached_property
    def tuning(self) -> Tuning:
        return tuning_of(self.kernel, self.real, self.kappa)

    @property
    def work(self) -> str:
        """The type of the work space."""
        return fill("work.c", self._values)

    @property
    def functions(self) -> str:
        """Rows and residual."""
        return fill(
            "functions.c",
            self._values
            | {
                "residual": self._residual_lines,
                "rows": self._rows.lines,
            },
        )

    @property
    def target(self) -> str:
        """The function that sets the known values aimed at."""
        return fill("target.c", self._values | {"target": self.target_lines})

    @cached_property
    def linear(self) -> LinearSolver:
        """The linear solver."""
        known = "w->k0" if self.keeps_known else "w->k"
        inputs = ["w->x", known, self.geometry, "w->d"]
        return linear_solver(
            self.kernel,
            self.real,
            inputs,
            self.matrices,
            self._values,
            self.matrix,
            compact=self.compact,
        )

    @property
    def bends(self) -> bool:
        """Whether known values turn, on a line at whose points there is something to look at."""
        return self.on_the_way and (bool(self.kernel.turns) or self.kernel.quaternion is not None)

    @property
    def middle(self) -> str:
        """The function that looks at the middle of a part, where known values turn."""
        count = self.kernel.state.numel()
        copies = {
            "to_begin": copy_loop("end", "w->x", count) + self._copies_of_state[1],
            "to_end": copy_loop("w->x", "end", count),
            "aimed_at": list[str](),
        }
        known = self.kernel.known.numel() * self.keeps_known
        for kept, array, size in (("aimed", "k", known), ("values", "numbers", self.numbers)):
            if size:
                copies["aimed_at"] += [f"real {kept}[{size}];"]
                copies["to_begin"] += copy_loop(kept, f"w->{array}", size)
                copies["to_end"] += copy_loop(f"w->{array}", kept, size)
        return fill("middle.c", self._values | copies) if self.bends else ""

    @property
    def driver(self) -> str:
        """Newton's method along the line of known values."""
        side = fill("side.c", self._values) if self._has_side else ""
        return side + fill("newton.c", self._values)

    def stand(
        self, read: Sequence[str], to: str, asked: Sequence[str] | str, **more: Sequence[str]
    ) -> str:
        """Statements that take a guess whose own rows vanish for the answer, where a step of
        rounding has led to what is refused: it is `read` once more, and `asked` what answers are.
        `more`: statements that keep the `answer`, and say how far the guess has `moved` to it.
        """
        own = {"read": read, "goal": to, "stands": _STANDS * self.tuning.noise, "asked": asked}
        return fill("stand.c", self._values | {"answer": "", "moved": ""} | own | more)

    @property
    def solver(self) -> str:
        """The linear solver, and the function that takes a step by it."""
        return self.linear.text + fill("step.c", self._values | self.moving("w->")[1])

    @property
    def text(self) -> str:
        """All functions in an order in which each is known before it is called."""
        return self.work + self.functions + self.target + self.solver + self.middle + self.driver

    @property
    def factoring(self) -> dict[str, object]:
        """Values for other drivers of the same steps: names, roundings, and the statements that set
        `turn` and factor the matrix.
        """
        first, *second = factor_calls(self.kernel, self.k, compact=self.compact)
        return self._values | {"factor": [f"turn = {first};", *second]}

    @cached_property
    def operations(self) -> dict[str, int]:
        """Operations of one step: rows, matrix, factors and step."""
        parts = (self._rows.operations, self.moving("w->")[0].operations, self.linear.operations)
        return {key: sum(part.get(key, 0) for part in parts) for key in sorted(set().union(*parts))}

    # --- statements -------------------------------------------------------------------------------

    @cached_property
    def _rows(self) -> Emitter:
        """Each row made and stored in turn, and what the matrix shares with it as soon as the row
        has been made.
        """
        kernel = self.kernel
        inputs = ["w->x", "w->k", self.geometry]
        emitter = Emitter(kernel.row_function(), inputs, self.real)
        count = kernel.shared_symbols.numel()
        for row in range(kernel.m):
            if kernel.m > 1:
                about = kernel.meaning.each_row[row] if kernel.meaning.each_row else ""
                emitter.comment(f"row {row + 1}: {about}" if about else f"row {row + 1}")
            text = emitter.value(0, row)
            emitter.lines.append(f"w->f[{row}] = {text};")
            for shared in range(count * row // kernel.m, count * (row + 1) // kernel.m):
                text = emitter.value(1, shared)
                emitter.lines.append(f"w->d[{shared}] = {text};")
        return emitter

    def moving(self, w: str) -> tuple[Emitter, dict[str, object]]:
        """Statements that add the step s to the state of the work space w, "w." or "w->", and text
        of its squared length, as templates read them.
        """
        emitter = Emitter(self.kernel.move_function(), [f"{w}x", "s", self.geometry], self.real)
        moved, squared = emitter.values(0), emitter.value(1, 0)
        stores = [f"{w}x[{i}] = {text};" for i, text in enumerate(moved)]
        return emitter, {"move": [*emitter.lines, *stores], "squared": squared}

    @property
    def _residual_lines(self) -> list[str]:
        """A loop in float, where room counts, statements in double, where each is an instruction or
        two.
        """
        real, count, length = self.real, self.kernel.m, self.kernel.row_length
        adds = [f"sum += w->f[{i}] * w->f[{i}];" for i in range(1, count)]
        if real.name == "float":
            adds = [f"for (int i = 1; i < {count}; ++i) {{", "    sum += w->f[i] * w->f[i];", "}"]
        root = "sqrt(sum)"
        result = f"return {root};" if length == 1.0 else f"return {root} * {length};"
        return ["real sum = w->f[0] * w->f[0];", *adds, result]

    # --- values of the templates ------------------------------------------------------------------

    @cached_property
    def _values(self) -> dict[str, object]:
        first, *second = factor_calls(self.kernel, self.k, compact=self.compact)
        return (
            common_values(self.name, self.real, struct=bool(self.geometry))
            | {"k": self.k, "first_factor": first, "second_factor": second}
            | self._sizes
            | self._members
            | self._constants
            | self._aiming
            | self._parts.values
            | self._still
        )

    @property
    def _sizes(self) -> dict[str, object]:
        kernel = self.kernel
        n, m, nk = kernel.n, kernel.m, kernel.known.numel()
        return {
            "n": n,
            "last": n - 1,
            "n1": n + 1,
            "m": m,
            "ns": kernel.state.numel(),
            "nk": nk,
            "nto": self.known_count or nk,
            "na": m * n,
        }

    @property
    def _has_side(self) -> bool:
        """Whether there are more rows than unknowns, so that factors have no determinant of their
        own.
        """
        return self.kernel.m > self.kernel.n

    @property
    def _members(self) -> dict[str, object]:
        """Members of the work space that not every kernel has, and what its arrays hold."""
        kernel = self.kernel
        nd, square = kernel.shared_symbols.numel(), min(kernel.m, kernel.n) ** 2
        meaning = kernel.meaning
        told = [
            f"x: {meaning.state}",
            f"k: {meaning.known}",
            f"f: {meaning.rows}",
            f"s: the step, {meaning.step}",
        ]
        told += [f"d: {meaning.shared}"] if nd else []
        wrapped = [
            line
            for text in told
            for line in textwrap.wrap(c_comment(text), _COMMENT_WIDTH - 3, subsequent_indent="   ")
        ]
        factors = (
            "its LU factors"
            if kernel.is_square
            else "Q of QR of its transpose"
            if kernel.is_wide
            else "Q of QR"
        )
        return {
            "meaning": "\n".join(f" * {line}" for line in wrapped),
            "x0": "name_pose x0" if kernel.is_pose else f"real x0[{kernel.state.numel()}]",
            "at": ""
            if self.retarget
            else (
                f"    real at[{self._sizes['nto']}]; /* known values at the guess, where the "
                f"line begins */"
            ),
            "shared": "\n".join(
                ([f"    real d[{nd}]; /* values that rows and matrix share */"] if nd else [])
                + (
                    [
                        f"    real k0[{self._sizes['nk']}]; /* known values at the part that is "
                        f"done: the matrix's */"
                    ]
                    if self.keeps_known
                    else []
                )
            ),
            "r": ""
            if kernel.is_square
            else f"    real r[{square}]; /* R of QR, reciprocals on its diagonal */",
            "sides": f"    real q[{kernel.m * kernel.n}]; /* Q at the part of the line that is "
            f"done */\n"
            "    int8_t side; /* sign of the determinant there, 0 before the line has begun */"
            if self._has_side
            else "",
            "no_side": "    w->side = 0;" if self._has_side else "",
            "side": ["if (turn != 0) {", f"    turn = {self.k}_side(w, taken == 0U);", "}"]
            if self._has_side
            else "",
            "factors": factors,
            "members": "\n".join(f"    {line}" for line in self.members),
        }

    @property
    def _constants(self) -> dict[str, object]:
        """Constants of the driver: squares of lengths, of ratios of steps, and parts of the
        line.
        """
        tuning = self.tuning
        return {
            "rounding": tuning.rounding,
            "noise_of_rows": tuning.noise,
            "kappa2": tuning.kappa2,
            "contraction2": 1.0 / 16.0,
            "far2": 1.0 / 36.0,
            "very_far2": 1.0 / 64.0,
            "later_fresh2": 0.0064 if self.on_the_way else 1.0,
            "very_far_later2": 0.09 if self.on_the_way else 1.0,
            "very_far_fresh2": 9e-4 if self.on_the_way else 1.0,
            "later2": 9.0 / 64.0 if self.on_the_way else 1.0,
            "least_part": 1.0 / 1024.0,
            "singular": SINGULAR * self.real.epsilon,
            "least_sides": (SINGULAR * self.real.epsilon,) * self.kernel.n,
            "sure": _SURE,
            "size2": self.kernel.characteristic_length**2,
            "guard": GUARD**-2,
        }

    @property
    def _aiming(self) -> dict[str, object]:
        """Calls that aim at parts of the line: by known values kept at the guess, or by `retarget`;
        where those at the part that is done are kept, new factors on the way to the aim are those
        of the aim.
        """
        k = self.k
        aim, done = (f"{k}_set_target(GEOMETRY w, to, {part});" for part in ("aim", "done"))
        is_pose, by_call = self.kernel.is_pose, bool(self.retarget)
        forth, back_again = self._copies_of_state
        save0 = forth if is_pose else copy("w->x0", "w->x", self.kernel.state.numel())
        kept = self.keeps_known
        keep = copy("w->k0", "w->k", self.kernel.known.numel()) if kept else []
        back, begin_target = [done, *keep] if kept else [], [aim]
        if by_call:
            begin_target, save0 = [f"{k}_set_target(GEOMETRY w, to);"], []
        elif kept:
            back = block("if (!kept)", back)
        if self.makes_known:
            begin_target = []
            save0 = [*save0, f"{k}_set_target(GEOMETRY w, to, 0.0);", *keep, aim]
        # the matrix reads known values: it is made at the part of the line that is done. Of wide
        # systems it is made at the part aimed at, because shortest steps follow the path more
        # closely by that one
        reads_known = self.kernel.reads_known and not self.kernel.is_wide and not kept

        def first(call: str) -> list[str]:
            return block("if (taken == 0U)", [call]) if reads_known else []

        keeping = block("if (taken > 0U)", keep)
        # a pose is read back where the line goes on: its quaternion's rounding is not added up
        settled = back_again if is_pose and not by_call else []
        return {
            "begin_target": begin_target,
            "part": "" if by_call else ", real part",
            "aimed": "" if by_call else ": a part of the line from the guess's to `to`",
            "at_done": keeping if kept else first(done),
            "at_aim": first(aim),
            "save0": save0,
            "advance": [*forth, *settled, *keep, self.retarget or aim],
            "retreat": [self.retarget] if by_call else [*back_again, *back, aim],
        }

    @property
    def _copies_of_state(self) -> tuple[list[str], list[str]]:
        """Statements that keep the state where the part that is done ends, and that put it back: a
        pose by the function that reads poses, which makes its quaternion's length one.
        """
        if not self.kernel.is_pose:
            count = self.kernel.state.numel()
            return copy_loop("w->x0", "w->x", count), copy_loop("w->x", "w->x0", count)
        numbers = indexed("w->x0.position", 3) + indexed("w->x0.quaternion", 4)
        forth = [f"{number} = w->x[{i}];" for i, number in enumerate(numbers)]
        return forth, ["(void)name_normalise_pose(GEOMETRY &w->x0, w->x);"]

    @property
    def _still(self) -> dict[str, object]:
        """Below which squared length a step is rounding: what the rows' rounding makes of it where
        pivots are small, and where they are so small that this could reach a singularity, an eighth
        of the way to that, which the least pivot tells. Of rods, whose matrix is well scaled, a
        constant.
        """
        floor = self.tuning.floor**2
        epsilon = self.real.epsilon
        rounding = (_ROWS * epsilon * self.kernel.characteristic_length) ** 2
        far = rounded(1.0 / (8.0 * _ROWS * epsilon))
        eighth = (_ROWS * epsilon * self.kernel.characteristic_length * far) ** 2
        test = f"w->spread > {(64.0 / _ROWS) ** 2}"
        noise = f"(w->spread < {far}) ? ({rounding} * w->spread) : ({eighth} / w->spread)"
        # what follows a step that is rounding or nothing tells no ratio of steps
        line = (_LINE * epsilon * self.kernel.characteristic_length) ** 2
        common: dict[str, object] = {
            "row_noise2": line,
            "moved": " && (before > still2)",
        }
        if not self.retarget:
            return common | {
                "still2": "still2",
                "still_variable": [
                    f"real still2 = {floor}; /* square of a step that is rounding */"
                ],
                "noise": [f"still2 = ({test}) ? ({noise}) : {floor};"],
                "stay": self._copies_of_state[1],
            }
        put_back = [f"{self.k}_retarget(GEOMETRY w, to, 1.0, 0.0);"]
        return common | {
            "still2": floor,
            "still_variable": "",
            "noise": "",
            "moved": "",
            "stay": put_back,
        }

    @property
    def _parts(self) -> LineParts:
        """How far parts of the line reach."""
        return LineParts(
            self.kernel,
            self.real,
            self.k,
            str(self._still["still2"]),
            self.bends,
            self.first_turn,
            self.measured,
            self.keeps_known,
        )
