"""Write the C of one direction of a map between joints: its solver, configurations of known values,
the function of the direction and its one step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.codegen.closed_direction import ClosedDirection
from symkin.codegen.line_parts import FIRST_TURN
from symkin.codegen.map.home_sheet import HomeSheet, home_sheet
from symkin.codegen.map.joint_map import Direction
from symkin.codegen.map.joint_map_values import MapValues, places_among
from symkin.codegen.map.rates import step_columns, step_text
from symkin.codegen.steps.geometry import Geometry
from symkin.codegen.steps.guard_text import Watched
from symkin.codegen.steps.guards import DETERMINANT
from symkin.codegen.steps.linear_solver import singular_condition
from symkin.codegen.steps.newton_kernel import Kernel, sampled
from symkin.codegen.steps.newton_source import NewtonCode, tolerance_of
from symkin.codegen.steps.passive_limits import limit_lines
from symkin.codegen.text.angles import number_counts, numbers_at
from symkin.codegen.text.c import Emitter, block, if_ok, indexed
from symkin.codegen.text.templates import copy, copy_loop, fill
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.text import c_comment

_TRACKED = 24.0
"""A step of one call is at most the size over this."""
_NOISE = 4.0
"""Roundings of the size that rows of formulas may leave: a step of Newton's method would not mend
them.
"""
_ROUGH = 4.0
"""How many times the polynomials' largest error a step from them may be long."""
_GUESSED = 1e-5
"""Error of a guess's own configuration, in sizes: the line begins there."""
_GUESS_ROUNDINGS = 2048.0
"""Roundings that such a configuration is off at most where it is regular."""
_SAME = 16.0
"""Tolerances by which an answer whose guess is read elsewhere may differ from where that leads, or
the rounding to which rows close, where that is more: in float.
"""
_NOT_DECIDED = 1e-4
"""Share of a condition's usual size below which one step decides nothing."""


@dataclass(frozen=True, eq=False)
class DirectionSource(MapValues):
    """The C of one direction; `common` are values of the names in all templates of the map."""

    direction: Direction
    common: dict[str, object]

    @property
    def k(self) -> str:
        """What the names of its functions begin with."""
        return f"{self.name}_{self.direction.name}"

    @property
    def known(self) -> tuple[Coordinate, ...]:
        return self.direction.known

    @property
    def unknown(self) -> tuple[Coordinate, ...]:
        return self.direction.unknown

    @property
    def is_direct(self) -> bool:
        return self.direction.name == "direct"

    @property
    def wanted(self) -> tuple[Coordinate, ...]:
        """What the direction is for."""
        return self.made.found if self.is_direct else self.made.given

    @property
    def words(self) -> tuple[str, str]:
        """What the known and the wanted values are called."""
        return ("joints", "found") if self.is_direct else ("found", "joints")

    @property
    def n(self) -> int:
        return len(self.known)

    @property
    def kernel(self) -> Kernel:
        return self.direction.kernel

    @property
    def numbers_of_known(self) -> str:
        """The array of the numbers of what is aimed at: the matrix reads them, or coefficients."""
        return "w->k" if self.direction.circles.is_plain else "w->numbers"

    @cached_property
    def names(self) -> dict[str, object]:
        """Values of the names in all templates of the direction; without passive joints the wanted
        values are all of a configuration.
        """
        values, out = self.words
        whole = bool(self.made.passive)
        return self.common | {
            "k": self.k,
            "values": values,
            "out": out,
            "nto": self.n,
            "nout": self.n,
            "from": "y" if whole else out,
            "nfrom": self.common["ny"] if whole else self.n,
        }

    @cached_property
    def closed(self) -> ClosedDirection | None:
        """The formulas, where some solve it."""
        if not self.direction.is_closed:
            return None
        return ClosedDirection(self.made, self.direction, self.common)

    @cached_property
    def sheet(self) -> HomeSheet | None:
        """What polynomials come near about the reference, where Newton's method solves it."""
        if self.closed is not None:
            return None
        return home_sheet(self.made, self.direction, self.wanted)

    @property
    def watched(self) -> Watched:
        """What is watched along lines."""
        guards = [DETERMINANT] if self.closed is None else self.closed.guards
        return [c.name for c in self.known], guards

    # --- the solver -------------------------------------------------------------------------------

    @cached_property
    def code(self) -> NewtonCode:
        """Newton's method."""
        states, known = zip(
            *(self.made.numbers(self.direction, s) for s in self.made.samples), strict=True
        )
        matrices, kappa = sampled(self.kernel, states, known, np.zeros(0))
        members, numbers = [] if self.closed is None else self.closed.members, 0
        if self.closed is None and not self.direction.circles.is_plain:
            numbers = self.direction.circles.numbers.numel()
            members = [
                f"real numbers[{numbers}]; /* numbers of what is aimed at: of angles cosine and "
                "sine */"
            ]
        return NewtonCode(
            kernel=self.kernel,
            name=self.name,
            real=self.real,
            geometry=[],
            matrices=matrices,
            kappa=kappa,
            target_lines=self._target_lines,
            known_count=self.n,
            first_turn=FIRST_TURN,
            measured=True,
            keeps_known=self.closed is None,
            numbers=numbers,
            members=members,
        )

    @property
    def _target_lines(self) -> list[str]:
        """Statements that set w->k, the known values, on the line from w->at to `to`."""
        return self._known_lines(
            [
                f"(part < 1.0) ? (w->at[{i}] + part * (to[{i}] - w->at[{i}])) : to[{i}]"
                for i in range(self.n)
            ]
        )

    def _known_lines(self, values: Sequence[str]) -> list[str]:
        """Statements that set w->k by C text of the known values."""
        target, places = self.numbers_of_known, range(sum(number_counts(self.known)))
        lines = self.circles_of(values, self.known, target, places)
        return [*lines, *self._coefficients(target, "w->k")]

    def _coefficients(self, source: str, target: str) -> list[str]:
        """The statement that sets the kernel's known values by numbers of the known coordinates,
        where these are others.
        """
        return (
            []
            if self.direction.circles.is_plain
            else [f"{self.k}_coefficients({source}, {target});"]
        )

    @property
    def _coefficients_text(self) -> str:
        """The function of the rows' coefficients, where known values are these."""
        circles = self.direction.circles
        if circles.is_plain:
            return ""
        inputs = [(circles.numbers, "numbers")]
        lines = Emitter.of(self.real, inputs, circles.coefficients).stored("k")
        own = {"numbers": circles.numbers.numel(), "nk": circles.coefficients.numel()}
        return fill("map_coefficients.c", self.names | own | {"lines": lines})

    @property
    def solver_text(self) -> str:
        """Newton's method, or formulas with the parts of Newton's method that finish and give
        rates; the function that sets the state, and polynomials near the reference.
        """
        code, closed = self.code, self.closed
        if closed is None:
            return self._coefficients_text + code.text + self._place_text + self._sheet_text
        own = {
            "singular": singular_condition(code.kernel, code.k, "w"),
            "rounding": code.tuning.rounding,
            "noise": _NOISE * self.real.epsilon * self.made.size,
        }
        finish = fill("map_finish.c", code.factoring | closed.values | own)
        text = closed.text
        if self.real.name == "float":
            text = text.replace("atan2f(", "atan2(")
        work = "\n".join(line for line in code.work.split("\n") if " x0[" not in line)
        solver = work + code.functions + code.target + code.solver + finish + text
        return solver + self._place_text

    @property
    def _place_text(self) -> str:
        """The function that sets known values, the matrix's too, and the state: by the wanted
        values where these are all of it.
        """
        values, out = self.words
        lines = self._known_lines(indexed(values, self.n))
        source = "the rest as in the configuration y"
        if self.closed is None:
            lines += copy("w->k0", "w->k", self.kernel.known.numel())
        if self.made.passive:
            lines += self.copies("w->x", self.unknown)
        else:
            places = places_among(self.unknown, self.wanted)
            lines += self.circles(out, self.wanted, "w->x", places)
            source = f"the {out} as they were last"
        return fill("map_place.c", self.names | {"lines": lines, "source": source})

    # --- configurations ---------------------------------------------------------------------------

    @property
    def state_text(self) -> str:
        """The configuration of known values, with the reference's choices."""
        if self.closed is not None:
            names = self.closed.values
            circles = self.circles("values", self.known, "k", range(int(str(names["nk"]))))
            solve = fill("map_closed_state.c", names | {"circles": circles}).splitlines()
            known, state, other = "k", "x", self._other_lines("x")
        else:
            solve = [f"{self.k}_work w;", *self._followed_lines]
            known, state, other = self.numbers_of_known.replace("->", "."), "w.x", list[str]()
        copies = [*self.into_y(known, self.known), *self.into_y(state, self.unknown)]
        return fill("map_state.c", self.names | {"lines": [*solve, *copies, *other]})

    @property
    def _followed_lines(self) -> list[str]:
        """Statements that bring the work space from the reference configuration to known values:
        near it by one step from polynomials, else along the line.
        """
        made, at = self.made, self.made.reference_of(self.known)
        starts = {
            "at": at,
            "x": numbers_at(self.unknown, made.reference_of(self.unknown)),
            "k0": self.direction.circles.known_at(numbers_at(self.known, at)),
        }
        # passive joints go on from a guess's own configuration, which is then as an answer's
        near = _GUESSED * made.size
        own = {
            "near": "NAME_TOLERANCE" if made.passive else near,
            "starts": [
                f"w.{array}[{i}] = {v};"
                for array, values in starts.items()
                for i, v in enumerate(values)
            ],
            "to": self.unwrapped("to", "values", "w.at", self.known),
            "other": self._other_lines("w.x"),
        }
        line = fill("map_followed.c", self.names | own)
        if self.sheet is None:
            return line.splitlines()
        columns = step_columns(self.unknown, self.wanted, made.size)
        near_home = {
            "nf": self.kernel.n,
            "singular": singular_condition(self.kernel, self.k, "&w"),
            "others": [
                f"other[{i}] = {self.words[1]}[{i}] + {step_text(*place)};"
                for i, place in enumerate(columns)
            ],
            "longest": (_ROUGH * self.sheet.error * made.size) ** 2,
            "line": line,
        }
        moved = self.code.moving("w.")[1]
        return fill("map_near_home.c", self.names | near_home | moved).splitlines()

    @property
    def _sheet_text(self) -> str:
        """The function of the polynomials, where there are some."""
        sheet = self.sheet
        if sheet is None:
            return ""
        inputs = [(sheet.known, [f"u{i}" for i in range(self.n)])]
        begin = [
            f"const real u{i} = values[{i}] - {v};"
            for i, v in enumerate(self.made.reference_of(self.known))
        ]
        lines = [*begin, *Emitter.of(self.real, inputs, sheet.values).stored("wanted")]
        within = [f"(fabs(u{i}) <= {v})" for i, v in enumerate(sheet.reach)]
        own = {"count": self.n, "lines": lines, "within": " && ".join(within)}
        return fill("map_sheet.c", self.names | own)

    def _other_lines(self, state: str) -> list[str]:
        """Statements that set `other` by the numbers of a state."""
        numbers = [f"{state}[{i}]" for i in places_among(self.unknown, self.wanted)]
        texts = self.plain_values(self.wanted, numbers)
        return [f"other[{i}] = {text};" for i, text in enumerate(texts)]

    # --- the function of the direction ------------------------------------------------------------

    @property
    def text(self) -> str:
        """The function of the direction, and its one step."""
        (values, out), known, wanted = self.words, self.known, self.wanted
        n, size = self.n, self.made.size
        begin = [
            f"w->at[{i}] = {self.nearest(c, f'at[{i}]', f'{values}[{i}]')};"
            for i, c in enumerate(known)
        ]
        solve, begun, of_known = "newton", values, self.copies("w->k0", known)
        stand_at = list[str]()
        if self.closed is not None:
            # formulas tell an answer anywhere, so that the line to it begins at the reference
            solve, begun, of_known = "follow", "home", self.copies("w->k", known)
            home = ", ".join(str(v) for v in self.made.reference_of(known))
            stand_at = [
                f"static const real home[{n}] = {{ {home} }};",
                f"real there[{n}];",
                f"(void)name_state_of_{values}(home, y, there);",
            ]
        elif not self.direction.circles.is_plain:
            of_known = self._coefficients(f"&y[{self.places(known)[0]}]", "w->k0")
        stand_at[1:1] = copy_loop("at", begun, n)
        follow = [
            *self.copies("w->x", self.unknown),
            *of_known,
            f"status = {self.k}_{solve}(w, {values}, config, info);",
        ]
        weights = [(size if c.is_angular else 1.0) ** 2 for c in wanted]
        change = [
            f"change2 += {w} * (result[{i}] - {out}[{i}]) * (result[{i}] - {out}[{i}]);"
            for i, w in enumerate(weights)
        ]
        unused = [] if any(c.is_periodic for c in wanted) else ["(void)guess;"]
        outside = "NAME_OUT_OF_RANGE"
        blame = [
            f"if ((info != NULL) && (status == {outside})) {{",
            "    info->joint = name_first_beyond(result);",
            "}",
        ]
        no_step = "name_write_info(info, 0U, HUGE_VAL, 0.0, 0.0);"
        stands = max(_GUESSED, _GUESS_ROUNDINGS * self.real.epsilon) * size
        own = {
            "passive": self._passive_call,
            "drifted": self._drifted,
            "about": (
                f"The {self.direction.name} problem: {c_comment(', '.join(c.name for c in wanted))}"
                f" from {c_comment(', '.join(c.name for c in known))}."
            ),
            "about_track": f"One step of the {self.direction.name} problem from the last values.",
            "f": self.k,
            "track": "name_track" if self.is_direct else "name_track_inverse",
            "begin": begin,
            "follow": follow,
            "line_results": [*unused, *self._results("w->x", "guess")],
            "track_results": [f"real result[{n}];", *self._results("w.x", out)],
            "store": [f"{out}[{i}] = result[{i}];" for i in range(n)],
            "no_step": "name_write_no_step(info, joints);" if self.is_direct else no_step,
            "blame_result": "" if self.is_direct else blame,
            "change": change,
            "stand_at": stand_at,
            # of the checks that a guess, or an answer, stands where the known values are
            "stands2": stands**2,
            "rounding": self.code.tuning.rounding,
            "same2": max(_SAME * tolerance_of(self.real, size), self.code.tuning.rounding) ** 2,
            "guess_from": "y" if self.made.passive else "guess",
            "answer_from": "y" if self.made.passive else "answer",
            "track2": (size / _TRACKED) ** 2,
            **self._step,
        }
        return self._passive_text + fill("map_direction.c", self.names | own)

    def _results(self, state: str, near: str) -> list[str]:
        """Statements of the wanted values by the numbers of a state."""
        numbers = [f"{state}[{i}]" for i in places_among(self.unknown, self.wanted)]
        texts = self.values_of(self.wanted, numbers, near)
        return [f"result[{i}] = {text};" for i, text in enumerate(texts)]

    @property
    def away_text(self) -> str:
        """The function of how far wanted values are from others."""
        lines = list[str]()
        for i, c in enumerate(self.wanted):
            weight = self.made.size if c.is_angular else 1.0
            other = self.nearest(c, f"other[{i}]", f"guess[{i}]")
            lines += [
                f"const real way{i} = {weight} * ({other} - guess[{i}]);",
                f"away2 += way{i} * way{i};",
            ]
        return fill("map_away.c", self.names | {"away": lines})

    @property
    def _passive_call(self) -> list[str]:
        """Statements that hold passive joints of an answer against their limits."""
        if not self.made.passive_limits:
            return []
        return if_ok([f"status = {self.k}_check_passive(&w, {self.words[0]});"])

    @property
    def _drifted(self) -> list[str]:
        """Statements that give up an answer that rounding has taken beyond a limit, in favour of a
        guess that has the given values.
        """
        values, out = self.words
        kept = []
        if any(c.limits is not None for c in self.wanted):
            kept.append(f"(name_limit_{out}(NAME_OK, result) == NAME_OK)")
        if self.made.passive_limits:
            kept.append(f"({self.k}_check_passive(&w, {values}) == NAME_OK)")
        if not kept:
            return []
        beyond = f"still && (status == NAME_OK) && !({' && '.join(kept)})"
        return block(f"if ({beyond})", ["status = NAME_WRONG_BRANCH;"])

    @property
    def _passive_text(self) -> str:
        """The function that holds passive joints against their limits, where they have some."""
        limits, closure = self.made.passive_limits, self.made.direct.problem.closure
        if not limits:
            return ""
        numbers = indexed("w->x", sum(number_counts(self.unknown)))
        found = self.plain_values(self.unknown, numbers)
        texts = {c.name: text for c, text in zip(self.unknown, found, strict=True)}
        texts |= {c.name: f"{self.words[0]}[{i}]" for i, c in enumerate(self.known)}
        variables = [texts.get(c.name, "0.0") for c in closure.coordinates for _ in range(c.width)]
        beyond = "NAME_OUT_OF_RANGE"
        fixed = Geometry(closure, at_run_time=False)
        lines = limit_lines(limits, variables, fixed, self.real, beyond, stands=False)
        return fill("map_passive.c", self.names | {"lines": lines})

    def state_of(self, side: str) -> tuple[list[str], list[str]]:
        """Members and statements that set y to the configuration of the joints or of the found
        values, where they are not all of it.
        """
        if not self.made.passive:
            return [], []
        return [f"real y[{self.common['ny']}];", f"real at[{self.n}];"], [
            *if_ok([f"status = name_state_of_{side}({side}, y, at);"])
        ]

    @property
    def _step(self) -> dict[str, list[str]]:
        """Statements of one step: from the last values' configuration, by Newton's method or by
        formulas.
        """
        y, last = self.state_of(self.words[1])
        if self.closed is None:
            singular = singular_condition(self.kernel, self.k, "&w")
            kappa = np.sqrt(self.code.tuning.kappa2)
            step = fill("map_step.c", self.names | {"singular": singular, "kappa": kappa})
        else:
            own = {"not_decided": _NOT_DECIDED}
            step = fill("map_closed_step.c", self.closed.values | self.names | own)
        return {"y": y, "last": last, "step": step.splitlines()}
