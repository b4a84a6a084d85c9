"""Write the C of a map between joints: both directions, one step of each, Jacobian, rates and
torques.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.codegen.closed_direction import ClosedDirection
from symkin.codegen.geometry import Geometry
from symkin.codegen.guard_text import Watched
from symkin.codegen.guards import DETERMINANT
from symkin.codegen.home_sheet import HomeSheet, home_sheet
from symkin.codegen.joint_map import Direction, JointMap
from symkin.codegen.joint_map_derivatives import step_columns
from symkin.codegen.joint_map_rates import LARGEST, MapRates, step_text
from symkin.codegen.joint_map_values import MapValues, places_among
from symkin.codegen.linear_solver import singular_condition
from symkin.codegen.newton_kernel import sampled
from symkin.codegen.newton_source import NewtonCode, tolerance_of
from symkin.codegen.passive_limits import limit_lines
from symkin.codegen.text.angles import number_counts, numbers_at
from symkin.codegen.text.c import Emitter, Real, indent, indexed
from symkin.codegen.text.templates import common_values, copy, farthest, fill
from symkin.codegen.text.turns import angle_of_direction, cosine_and_sine
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.text import c_comment

_FIRST_TURN = 0.5
"""Turn of the known values that is tried first (rad): most longer ones are refused."""
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
_READING = 256.0
"""Tolerances that rows leave at most where a guess is read with other known values than it was
found by, which differ by the tolerance times the condition.
"""
_SAME = 16.0
"""Tolerances by which an answer whose guess is read elsewhere may differ from where that leads."""
_NOT_DECIDED = 1e-4
"""Share of a condition's usual size below which one step decides nothing."""


@dataclass(frozen=True, eq=False)
class JointMapSource:
    """The C of one map, function by function."""

    made: JointMap

    @property
    def real(self) -> Real:
        return self.made.real

    @property
    def name(self) -> str:
        return self.made.name

    @cached_property
    def numbers(self) -> MapValues:
        """Statements of values and their numbers."""
        return MapValues(self.made)

    @cached_property
    def code(self) -> NewtonCode:
        """Newton's method of the direct problem."""
        return self._newton(self.made.direct)

    @cached_property
    def _inverse_code(self) -> NewtonCode:
        return self._newton(self.made.inverse)

    def _code_of(self, direction: Direction) -> NewtonCode:
        return self.code if direction.name == "direct" else self._inverse_code

    def _newton(self, direction: Direction) -> NewtonCode:
        made, kernel = self.made, direction.kernel
        states, known = zip(*(made.numbers(direction, s) for s in made.samples), strict=True)
        matrices, kappa = sampled(kernel, states, known, np.zeros(0))
        return NewtonCode(
            kernel=kernel,
            name=self.name,
            real=self.real,
            geometry=[],
            matrices=matrices,
            kappa=kappa,
            target_lines=self._target_lines(direction),
            known_count=len(direction.known),
            first_turn=_FIRST_TURN,
            keeps_known=not direction.is_closed,
            members=self._members(direction),
        )

    def _target_lines(self, direction: Direction) -> list[str]:
        """Statements that set w->k, the known values, on the line from w->at to `to`."""
        one, plain = self.real.literal(1.0), direction.circles.is_plain
        lines, place, target = [], 0, "w->k" if plain else "w->numbers"
        for i, c in enumerate(direction.known):
            value = f"(part < {one}) ? (w->at[{i}] + part * (to[{i}] - w->at[{i}])) : to[{i}]"
            if c.kind == "angle":
                lines.append(f"{self.name}_cosine_and_sine({value}, &{target}[{place}]);")
                place += 2
            else:
                lines.append(f"{target}[{place}] = {value};")
                place += 1
        if plain:
            return lines
        return [*lines, f"{self.name}_{direction.name}_coefficients(w->numbers, w->k);"]

    def _members(self, direction: Direction) -> list[str]:
        """Members of the work space beside those of every method."""
        if direction.name in self._closed:
            return self._closed[direction.name].members
        if direction.circles.is_plain:
            return []
        return [
            f"{self.real.type} numbers[{int(direction.circles.numbers.shape[0])}]; /* numbers of "
            f"what is aimed at: of angles cosine and sine */"
        ]

    def _coefficients_text(self, direction: Direction) -> str:
        """The function of the rows' coefficients, where known values are these."""
        circles = direction.circles
        if circles.is_plain:
            return ""
        count, place = int(circles.numbers.shape[0]), int(circles.coefficients.shape[0])
        function = ca.Function(
            "f", [circles.numbers], [ca.densify(circles.coefficients)], {"cse": True}
        )
        emitter = Emitter(function, [indexed("numbers", count)], self.real)
        stores = [f"k[{i}] = {emitter.value(0, i)};" for i in range(place)]
        return fill(
            "map_coefficients.c",
            self._common
            | {
                "k": f"{self.name}_{direction.name}",
                "numbers": count,
                "nk": place,
                "lines": indent([*emitter.lines, *stores]),
            },
        )

    def _known_of_y(self, direction: Direction, target: str) -> list[str]:
        """Statements that set the kernel's known values of a configuration."""
        if direction.circles.is_plain:
            return self.numbers.copies(target, direction.known)
        return self._known_lines(
            direction, f"&y[{self.numbers.places(direction.known)[0]}]", target
        )

    def _known_lines(self, direction: Direction, source: str, target: str) -> list[str]:
        """Statements that set the kernel's known values by numbers of the known coordinates, which
        are beside each other at `source`.
        """
        if direction.circles.is_plain:
            return copy(target, source, int(direction.kernel.known.shape[0]))
        return [f"{self.name}_{direction.name}_coefficients({source}, {target});"]

    @cached_property
    def _closed(self) -> dict[str, ClosedDirection]:
        """The directions that formulas solve, by name."""
        found: dict[str, ClosedDirection] = {}
        for direction in (self.made.direct, self.made.inverse):
            if direction.is_closed:
                found[direction.name] = ClosedDirection(self.made, direction, self._common)
        return found

    @property
    def watched(self) -> dict[str, Watched]:
        """What each direction watches along lines."""
        found = dict[str, Watched]()
        for d in (self.made.direct, self.made.inverse):
            closed = self._closed.get(d.name)
            guards = [DETERMINANT] if closed is None else closed.guards
            found[d.name] = ([c.name for c in d.known], guards)
        return found

    @cached_property
    def _common(self) -> dict[str, object]:
        made, literal = self.made, self.real.literal
        n = len(made.given)
        return common_values(self.name, self.real, struct=False) | {
            "nq": n,
            "nj": n * n,
            "ny": sum(number_counts(made.coordinates)),
            "turn": literal(2 * np.pi),
            "per_turn": literal(0.5 / np.pi),
            "minus_half": literal(-0.5),
            "half_turn": literal(np.pi),
            "farthest": literal(farthest(made.size, (0.0, 0.0, 0.0))),
            "largest": literal(LARGEST),
        }

    @cached_property
    def values(self) -> dict[str, object]:
        """Values of the names in the templates of this kind, the tests and the header."""
        passive = ", ".join(c_comment(c.name) for c in self.made.passive)
        note = (
            ""
            if not passive
            else "What the values leave to other joints is as at the reference configuration."
        )
        return self._common | {"passive_note": note}

    @property
    def text(self) -> str:
        """Everything of NAME.c between its beginning and end."""
        made = self.made
        parts = [
            self._solver_text(d) + self._place_text(d) + self._sheet_text(d)
            for d in (made.direct, made.inverse)
        ]
        parts += [self._state_text(made.inverse), self._state_text(made.direct)]
        parts += [self._away_text(d) for d in (made.direct, made.inverse)]
        parts += [self._direction_text(made.direct), self._direction_text(made.inverse)]
        parts += [fill("map_give.c", self._common), MapRates(self.numbers, self._common).text]
        body = "".join(parts)
        return fill("info.c", self._common) + self._tools(body) + body

    # --- parts ------------------------------------------------------------------------------------

    def _tools(self, text: str) -> str:
        """The functions of angles that a text calls, and the checks of values."""
        literal, written = self.real.literal, list[str]()
        if f"{self.name}_angle(" in text:
            written.append(angle_of_direction(self.real, self._common))
        if f"{self.name}_cosine_and_sine(" in text:
            written.append(cosine_and_sine(self.real, self._common))
        if f"{self.name}_turned(" in text:
            written.append(fill("map_turned.c", self._common))
        low, high = (
            ", ".join(literal(v) for v in part)
            for part in zip(*self.numbers.limits(self.made.given), strict=True)
        )
        return "".join(
            [*written, self._checks, fill("map_blame.c", self._common | {"low": low, "high": high})]
        )

    @property
    def _checks(self) -> str:
        """Checks of joints and of found values: against limits, and of guesses, which need not keep
        to them.
        """
        found = []
        for what, coordinates in (("joints", self.made.given), ("found", self.made.found)):
            for bounded, function in ((True, f"limit_{what}"), (False, f"bound_{what}")):
                literal = self.real.literal
                within = [
                    f"(values[{i}] >= {literal(low)}) && (values[{i}] <= {literal(high)})"
                    for i, (low, high) in enumerate(
                        self.numbers.limits(coordinates, bounded=bounded)
                    )
                ]
                found.append(
                    fill(
                        "map_check.c",
                        self._common
                        | {
                            "what": what if bounded else f"{what} of a guess",
                            "ranges_word": "limits" if bounded else "bounds",
                            "function": function,
                            "within": "\n        && ".join(within),
                        },
                    )
                )
        return "".join(found)

    def _solver_text(self, direction: Direction) -> str:
        """Newton's method of a direction, or its formulas with the parts of Newton's method that
        finish and give rates.
        """
        code = self._code_of(direction)
        if direction.name not in self._closed:
            return self._coefficients_text(direction) + code.text
        closed = self._closed[direction.name]
        finish = fill(
            "map_finish.c",
            code.factoring
            | closed.values
            | {
                "singular": singular_condition(code.kernel, code.k, "w"),
                "rounding": self.real.literal(code.tuning.rounding),
                "noise": self.real.literal(_NOISE * self.real.epsilon * self.made.size),
            },
        )
        text = closed.text
        if self.real.name == "float":
            text = text.replace("atan2f(", f"{self.name}_angle(")
        work = "\n".join(line for line in code.work.split("\n") if " x0[" not in line)
        return work + code.functions + code.target + code.linear.text + finish + text

    # --- configurations ---------------------------------------------------------------------------

    def _words(self, direction: Direction) -> tuple[str, str]:
        """What the known and the wanted values of a direction are called."""
        return ("joints", "found") if direction.name == "direct" else ("found", "joints")

    def _state_text(self, direction: Direction) -> str:
        """The configuration of known values, with the reference's choices."""
        values, _ = self._words(direction)
        k, kind = f"{self.name}_{direction.name}", self.real.type
        if direction.name in self._closed:
            closed = self._closed[direction.name]
            names = closed.values
            lines = [
                f"static const {kind} sign[{names['signs']}] = {{ {names['home_signs']} }};",
                f"{kind} k[{names['nk']}];",
                f"{kind} x[{names['ns']}];",
                f"{kind} d[{names['conditions']}];",
                *self.numbers.circles("values", direction.known, "k", range(int(str(names["nk"])))),
                f"{k}_formulas(k, sign, x, d);",
                f"for (int i = 0; i < {names['conditions']}; ++i) {{",
                f"    if (!(d[i] > {names['resolved']})) {{",
                f"        status = {self.name.upper()}_OUT_OF_RANGE;",
                "    }",
                "}",
                *self.numbers.into_y("k", direction.known),
                *self.numbers.into_y("x", direction.unknown),
                *self._other_lines(direction, "x"),
            ]
        else:
            lines = [
                f"{k}_work w;",
                *self._followed_lines(direction),
                *self.numbers.into_y(
                    "w.k" if direction.circles.is_plain else "w.numbers", direction.known
                ),
                *self.numbers.into_y("w.x", direction.unknown),
            ]
        return fill(
            "map_state.c",
            self._common | {"values": values, "nto": len(direction.known), "lines": indent(lines)},
        )

    def _followed_lines(self, direction: Direction) -> list[str]:
        """Statements that bring the work space from the reference configuration to known values:
        near it by one step from polynomials, else along the line.
        """
        _, out = self._words(direction)
        k, kind, made, prefix = (
            f"{self.name}_{direction.name}",
            self.real.type,
            self.made,
            self.name.upper(),
        )
        literal, n = self.real.literal, len(direction.known)
        at, begin = (
            made.reference_of(direction.known),
            numbers_at(direction.unknown, made.reference_of(direction.unknown)),
        )
        aims = [
            f"to[{i}] = {self.numbers.turned(c, f'values[{i}]', f'w.at[{i}]')};"
            if c.kind == "angle" and c.limits is None
            else f"to[{i}] = values[{i}];"
            for i, c in enumerate(direction.known)
        ]
        line = [
            f"static const {self.name}_config near = {{ {self._near_enough}, {prefix}_MAX_STEPS, "
            f"{prefix}_MAX_STEP }};",
            f"{kind} to[{n}];",
            "/* along the line from the reference configuration; an error of a guess moves the "
            "beginning of the line by as much */",
            *(f"w.at[{i}] = {literal(float(v))};" for i, v in enumerate(at)),
            *(f"w.x[{i}] = {literal(float(v))};" for i, v in enumerate(begin)),
            *(
                f"w.k0[{i}] = {literal(float(v))};"
                for i, v in enumerate(direction.circles.known_at(numbers_at(direction.known, at)))
            ),
            *aims,
            f"status = {k}_newton(&w, to, &near, NULL);",
        ]
        sheet = self.home_sheets.get(direction.name)
        if sheet is None:
            return [*line, *self._other_lines(direction, "w.x")]
        columns = step_columns(direction.unknown, self._wanted(direction), self.made.size)
        return [
            "/* near the reference configuration by one step of Newton's method from polynomials "
            "*/",
            f"{kind} {out}[{len(columns)}];",
            f"bool near_home = {k}_near_home(values, {out});",
            "if (near_home) {",
            f"    {k}_place(&w, values, {out});",
            f"    {k}_rows(&w);",
            f"    near_home = !({singular_condition(direction.kernel, k, '&w')});",
            "    if (near_home) {",
            f"        {k}_solve(&w);",
            *(
                f"        other[{i}] = {out}[{i}] + {step_text(self.real, *place)};"
                for i, place in enumerate(columns)
            ),
            f"        near_home = ({k}_apply_step(&w) <= "
            f"{literal((_ROUGH * sheet.error * made.size) ** 2)});",
            "    }",
            "}",
            "if (!near_home) {",
            *("    " + text for text in [*line, *self._other_lines(direction, "w.x")]),
            "}",
        ]

    def _sheet_text(self, direction: Direction) -> str:
        """The function of the polynomials, where there are some."""
        sheet = self.home_sheets.get(direction.name)
        if sheet is None:
            return ""
        n, literal = len(direction.known), self.real.literal
        function = ca.Function("f", [sheet.known], [ca.densify(sheet.values)], {"cse": True})
        emitter = Emitter(function, [[f"u{i}" for i in range(n)]], self.real)
        texts = [emitter.value(0, i) for i in range(int(sheet.values.shape[0]))]
        at = self.made.reference_of(direction.known)
        lines = [
            f"const {self.real.type} u{i} = values[{i}] - {literal(float(v))};"
            for i, v in enumerate(at)
        ]
        lines += [*emitter.lines, *(f"wanted[{i}] = {text};" for i, text in enumerate(texts))]
        within = [
            f"({self.real.call('fabs')}(u{i}) <= {literal(float(v))})"
            for i, v in enumerate(sheet.reach)
        ]
        return fill(
            "map_sheet.c",
            self._common
            | {
                "k": f"{self.name}_{direction.name}",
                "nto": n,
                "count": len(texts),
                "lines": indent(lines),
                "within": " && ".join(within),
            },
        )

    def _other_lines(self, direction: Direction, state: str) -> list[str]:
        """Statements that set `other` by the numbers of a state."""
        wanted = self._wanted(direction)
        numbers = [f"{state}[{i}]" for i in places_among(direction.unknown, wanted)]
        return [
            f"other[{i}] = {text};"
            for i, text in enumerate(self.numbers.plain_values(wanted, numbers))
        ]

    def _wanted(self, direction: Direction) -> tuple[Coordinate, ...]:
        """What a direction is for."""
        return self.made.found if direction.name == "direct" else self.made.given

    @cached_property
    def home_sheets(self) -> dict[str, HomeSheet]:
        """What polynomials come near about the reference, of directions that Newton's method
        solves.
        """
        made = self.made
        sheets = {
            d.name: home_sheet(made, d, self._wanted(d))
            for d in (made.direct, made.inverse)
            if not d.is_closed
        }
        return {name: sheet for name, sheet in sheets.items() if sheet is not None}

    @property
    def _near_enough(self) -> str:
        """Tolerance of a guess's own configuration: that of an answer where passive joints go on
        from there.
        """
        return (
            f"{self.name.upper()}_TOLERANCE"
            if self.made.passive
            else self.real.literal(_GUESSED * self.made.size)
        )

    def _direction_text(self, direction: Direction) -> str:
        """The function of a direction, and its one step."""
        values, out = self._words(direction)
        k, kind, name = f"{self.name}_{direction.name}", self.real.type, self.name
        wanted = self._wanted(direction)
        known, n, literal = direction.known, len(direction.known), self.real.literal
        begin = [
            f"w->at[{i}] = {self._nearest(c, f'at[{i}]', f'{values}[{i}]')};"
            for i, c in enumerate(known)
        ]
        copies = self.numbers.copies("w->x", direction.unknown)
        closed = self._closed.get(direction.name)
        if closed is None:
            follow = [
                *copies,
                *self._known_of_y(direction, "w->k0"),
                f"status = {k}_newton(w, {values}, config, info);",
            ]
        else:
            follow = [
                *copies,
                *self.numbers.copies("w->k", known),
                f"status = {k}_follow(w, {values}, config, info);",
            ]
        places = places_among(direction.unknown, wanted)

        def results(state: str, near: str) -> list[str]:
            texts = self.numbers.values_of(wanted, [f"{state}[{i}]" for i in places], near)
            return [f"result[{i}] = {t};" for i, t in enumerate(texts)]

        weights = [1.0 * self.made.size if c.is_angular else 1.0 for c in wanted]
        change = [
            f"change2 += {literal(w * w)} * (result[{i}] - {out}[{i}]) * (result[{i}] - "
            f"{out}[{i}]);"
            for i, w in enumerate(weights)
        ]
        stand_at = [
            f"for (int i = 0; i < {n}; ++i) {{",
            f"    at[i] = {values if closed is None else 'home'}[i];",
            "}",
        ]
        if closed is not None:
            # formulas tell an answer anywhere, so that the line to it begins at the reference
            home = ", ".join(literal(float(v)) for v in self.made.reference_of(known))
            stand_at = [
                f"static const {kind} home[{n}] = {{ {home} }};",
                *stand_at,
                f"{kind} there[{n}];",
                f"(void){name}_state_of_{values}(home, y, there);",
            ]
        unused = [] if any(c.kind == "angle" for c in wanted) else ["(void)guess;"]
        which = "direct" if direction.name == "direct" else "inverse"
        return self._passive_text(direction) + fill(
            "map_direction.c",
            self._common
            | {
                "passive": self._passive_call(direction),
                "about": (
                    f"The {which} problem: {c_comment(', '.join(c.name for c in wanted))} from "
                    f"{c_comment(', '.join(c.name for c in known))}."
                ),
                "about_track": f"One step of the {which} problem from the last values.",
                "f": f"{name}_{direction.name}",
                "track": f"{name}_track" if direction.name == "direct" else f"{name}_track_inverse",
                "k": k,
                "values": values,
                "out": out,
                "nto": n,
                "nout": n,
                "begin": indent(begin),
                "follow": indent(follow),
                "line_results": indent([*unused, *results("w->x", "guess")], 2),
                "track_results": indent([f"{kind} result[{n}];", *results("w.x", out)], 2),
                "store": indent([f"{out}[{i}] = result[{i}];" for i in range(n)], 3),
                "blame_values": f"        {name}_blame(info, joints);"
                if values == "joints"
                else "",
                "blame_result": indent(
                    [
                        f"if (status == {name.upper()}_OUT_OF_RANGE) {{",
                        f"    {name}_blame(info, result);",
                        "}",
                    ],
                    2,
                )
                if out == "joints"
                else "",
                "change": indent(change, 2),
                "stand_at": indent(stand_at),
                **self._held(out),
                "track2": literal((self.made.size / _TRACKED) ** 2),
                **self._step(direction),
            },
        )

    def _held(self, out: str) -> dict[str, object]:
        """Values of the checks that a guess, or an answer, stands where the known values are; `out`
        is what the wanted ones are called.
        """
        size, literal, passive = self.made.size, self.real.literal, bool(self.made.passive)
        stands = max(_GUESSED, _GUESS_ROUNDINGS * self.real.epsilon) * size
        reading = _READING * tolerance_of(self.real, size)
        return {
            "stands2": literal(stands**2),
            "held2": literal(self.real.epsilon * size**2),
            "reading": literal(reading),
            "same2": literal((_SAME * tolerance_of(self.real, size)) ** 2),
            # without passive joints the two sides' values are the whole configuration
            "from": "y" if passive else out,
            "nfrom": self._common["ny"] if passive else len(self.made.given),
            "guess_from": "y" if passive else "guess",
            "answer_from": "y" if passive else "answer",
        }

    def _away_text(self, direction: Direction) -> str:
        """The function of how far wanted values are from others."""
        wanted, kind = self._wanted(direction), self.real.type
        lines = []
        for i, c in enumerate(wanted):
            weight = self.real.literal(self.made.size if c.is_angular else 1.0)
            lines += [
                f"const {kind} way{i} = {weight} * "
                f"({self._nearest(c, f'other[{i}]', f'guess[{i}]')} - guess[{i}]);",
                f"away2 += way{i} * way{i};",
            ]
        return fill(
            "map_away.c",
            self._common
            | {"out": self._words(direction)[1], "nout": len(wanted), "away": indent(lines)},
        )

    def _nearest(self, c: Coordinate, value: str, near: str) -> str:
        """C of a value; of an angle's, the one of its whole turns that is nearest to another
        value.
        """
        return self.numbers.turned(c, value, near) if c.kind == "angle" else value

    def _passive_call(self, direction: Direction) -> str:
        """Statements that hold passive joints of an answer against their limits."""
        if not self.made.passive_limits:
            return ""
        values, _ = self._words(direction)
        call = f"status = {self.name}_{direction.name}_check_passive(&w, {values});"
        return indent([f"if (status == {self.name.upper()}_OK) {{", f"    {call}", "}"], 2)

    def _passive_text(self, direction: Direction) -> str:
        """The function that holds passive joints against their limits, where they have some."""
        made, limits = self.made, self.made.passive_limits
        if not limits:
            return ""
        values, _ = self._words(direction)
        closure, geometry = (
            made.direct.problem.closure,
            Geometry(made.direct.problem.closure, at_run_time=False),
        )
        numbers = indexed("w->x", sum(number_counts(direction.unknown)))
        texts = dict(
            zip(
                (c.name for c in direction.unknown),
                self.numbers.plain_values(direction.unknown, numbers),
                strict=True,
            )
        )
        texts |= {c.name: f"{values}[{i}]" for i, c in enumerate(direction.known)}
        variables = [
            texts.get(c.name, self.real.literal(0.0))
            for c in closure.coordinates
            for _ in range(c.width)
        ]
        lines = limit_lines(
            limits, variables, geometry, self.real, f"{self.name.upper()}_OUT_OF_RANGE"
        )
        return fill(
            "map_passive.c",
            self._common
            | {
                "k": f"{self.name}_{direction.name}",
                "values": values,
                "nto": len(direction.known),
                "lines": indent(lines),
            },
        )

    def _step(self, direction: Direction) -> dict[str, str]:
        """Statements of one step: from the last values' configuration, by Newton's method or by
        formulas.
        """
        values, out = self._words(direction)
        k, kind, prefix, literal = (
            f"{self.name}_{direction.name}",
            self.real.type,
            self.name.upper(),
            self.real.literal,
        )
        code, closed = self._code_of(direction), self._closed.get(direction.name)
        y, last = [], []
        if self.made.passive:
            y = [f"{kind} y[{self._common['ny']}];", f"{kind} at[{len(self.made.given)}];"]
            last = [
                f"if (status == {prefix}_OK) {{",
                f"    status = {self.name}_state_of_{out}({out}, y, at);",
                "}",
            ]
        place = f"{k}_place(&w, {values}, {'y' if self.made.passive else out});"
        if closed is None:
            step = [
                place,
                f"{k}_rows(&w);",
                f"if ({singular_condition(code.kernel, k, '&w')}) {{",
                f"    status = {prefix}_SINGULAR;",
                "} else {",
                f"    {k}_solve(&w);",
                f"    const {kind} size = {k}_apply_step(&w);",
                f"    {self.name}_write_info(info, 1U, "
                f"{literal(float(np.sqrt(code.tuning.kappa2)))} * size, size, w.spread);",
                "}",
            ]
        else:
            names = closed.values
            step = [
                f"static const {self.name}_config usual = {{ {prefix}_TOLERANCE, "
                f"{prefix}_MAX_STEPS, {prefix}_MAX_STEP }};",
                f"{kind} sign[{names['signs']}];",
                f"{kind} d[{names['conditions']}];",
                f"{kind} least = {literal(1.0)};",
                place,
                f"{k}_signs(w.k, w.x, sign, d);",
                f"{k}_formulas(w.k, sign, w.x, d);",
                f"for (int i = 0; i < {names['conditions']}; ++i) {{",
                "    least = (d[i] < least) ? d[i] : least;",
                "}",
                f"status = (least > {literal(_NOT_DECIDED)}) ? {k}_finish(&w, 1U, least, &usual, "
                f"info) : {prefix}_SINGULAR;",
            ]
        return {"y": indent(y), "last": indent(last), "step": indent(step, 2)}

    def _place_text(self, direction: Direction) -> str:
        """The function that sets known values, the matrix's too, and the state: by the wanted
        values where these are all of it.
        """
        values, out = self._words(direction)
        wanted = self._wanted(direction)
        count, k = sum(number_counts(direction.known)), f"{self.name}_{direction.name}"
        target = "w->k" if direction.circles.is_plain else "w->numbers"
        lines = self.numbers.circles(values, direction.known, target, range(count))
        if not direction.circles.is_plain:
            lines.append(f"{k}_coefficients(w->numbers, w->k);")
        if not direction.is_closed:
            lines += copy("w->k0", "w->k", int(direction.kernel.known.shape[0]))
        if self.made.passive:
            lines += self.numbers.copies("w->x", direction.unknown)
        else:
            lines += self.numbers.circles(
                out, wanted, "w->x", places_among(direction.unknown, wanted)
            )
        return fill(
            "map_place.c",
            self._common
            | {
                "k": k,
                "values": values,
                "nto": len(direction.known),
                "from": "y" if self.made.passive else out,
                "nfrom": self._common["ny"] if self.made.passive else len(wanted),
                "lines": indent(lines),
                "known": values,
                "source": "the rest as in the configuration y"
                if self.made.passive
                else f"the {out} as they were last",
            },
        )
