"""Write the C of a direct problem that formulas solve: guess, formulas, the check of the line,
answer.

No angle is formed where cosine and sine are known: the guess's joints, its turn and the answer's.
Angles of the line between two configurations are needed where it has to be cut alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.codegen.direct_answer import AnswerText
from symkin.codegen.direct_formulas import DirectFormulas
from symkin.codegen.direct_guess import GuessText
from symkin.codegen.direct_line import LineText
from symkin.codegen.direct_values import DirectValues
from symkin.codegen.limb_platform import LimbPlatform
from symkin.codegen.newton_kernel import rounded
from symkin.codegen.text.angles import lifted
from symkin.codegen.text.c import Emitter, Real, indent
from symkin.codegen.text.gathered import gathered
from symkin.codegen.text.templates import fill
from symkin.codegen.text.turns import angle_of_direction, cosine_and_sine
from symkin.computed_once import cached_property
from symkin.spatial.backend import stacked
from symkin.text import c_comment

_WIDE = 1.5 * np.pi
"""Range of a limited angle (rad) from which the way between two of its values may be longer than
half a turn and ends within a right angle all the same.
"""


@dataclass(frozen=True, eq=False)
class ClosedDirectSource:
    """The direct problem of one platform; `common` are the values of the names that templates of
    limbs need.
    """

    made: LimbPlatform
    found: DirectFormulas
    common: Mapping[str, object]

    @cached_property
    def values(self) -> DirectValues:
        return DirectValues(self.made, self.found)

    @property
    def real(self) -> Real:
        return self.made.real

    @cached_property
    def _answer(self) -> AnswerText:
        return AnswerText(self.values)

    @property
    def text(self) -> str:
        """All functions of the direct problem."""
        line = LineText(self.values)
        real, made, literal = self.real, self.made, self.real.literal
        angular = any(c.is_angular for c in made.actuated)
        polynomial = real.name == "float" and angular
        angle = angle_of_direction(real, self.common) if polynomial else ""
        turn = cosine_and_sine(self.real, self.common) if polynomial else ""
        wide = [
            c.limits is not None and c.is_angular and c.limits[1] - c.limits[0] > _WIDE
            for c in made.actuated
        ]
        values = dict(self.common) | {
            "nu": self.values.count,
            "nk": max(1, len(self.found.formulas.names)),
            "nto": len(made.actuated),
            "k": f"{made.name}_direct",
            "ny": self.values.y.numel(),
            "guess_lines": indent(GuessText(self.values).lines, 2),
            "formula_lines": indent(self._formula_lines),
            "set_lines": indent(self._set_lines),
            "guard_members": indent(self.values.guards.members),
            "aimed": f"const {real.type} joints[{len(made.actuated)}], ",
            "walk_members": f"    {real.type} at_end[{len(made.actuated)}];",
            "at_lines": indent(line.at_lines, 3),
            "span_lines": indent(line.span_lines),
            "change_lines": indent(line.change_lines, 3),
            "same_signs": indent(self._same_signs),
            "near": "false" if any(wide) else "true",
            # limits of more than half a turn: the line within them need not be the nearer way
            # round, and is walked
            "evaluations": "two evaluations, since limits say which way round the line goes"
            if any(wide)
            else "one evaluation",
            "evaluation_count": 2 if any(wide) else 1,
            "half_lines": indent(self._answer.half_lines),
            "rounding": literal(rounded(64 * real.epsilon * made.closure.characteristic_length)),
            **self._answer.lines,
        }
        aim = [
            f"for (int i = 0; i < {len(made.actuated)}; ++i) {{",
            f"    const {real.type} there = at[i] + end * (to[i] - at[i]);",
            f"    at_end[i] = (end < {literal(1.0)}) ? there : joints[i];",
            "}",
            f"{made.name}_direct_set(w, at_end);",
            f"{made.name}_direct_formulas(w);",
        ]
        walk = self.values.guards.text(values, aim, 1.0 if any(wide) else 0.5)
        whole = fill("closed_direct.c", values | {"walk": angle + walk})
        answer = fill("closed_direct_answer.c", values)
        begin = whole.index("/* The answer at joint values")
        return turn + whole[:begin] + answer + whole[begin:]

    @property
    def _same_signs(self) -> list[str]:
        """Statements that compare the signs of a guess read again."""
        count, p = self.found.formulas.roots.numel(), self.made.name.upper()
        return (
            [
                f"for (int k = 0; (k < {count}) && (status == {p}_OK); ++k) {{",
                f"    status = (again.sign[k] * w->sign[k] > {self.real.literal(0.0)}) ? {p}_OK : "
                f"{p}_WRONG_BRANCH;",
                "}",
            ]
            if count
            else ["(void)w;"]
        )

    @property
    def _formula_lines(self) -> list[str]:
        """Statements of roots, unknowns and guards."""
        formulas, real = self.found.formulas, self.real
        places = self.values.places(formulas.system)
        parts = [
            self.values.signed(e)
            for e in (formulas.discriminants, formulas.first, formulas.second, formulas.divisors)
        ]
        discriminants, first, second, divisors = (
            lifted(e, places, self.values.generators, formulas.roots) for e in parts
        )
        unknowns = [
            part
            for k, c in enumerate(self.values.unknowns)
            for part in ((first[k], second[k]) if c.is_angular else (first[k],))
        ]
        reaches = stacked(self.values.signed(reach.of_known) for reach in self.found.whole.reaches)
        reaches = lifted(reaches, places, self.values.generators, formulas.roots)
        guards = [guard.of(discriminants, reaches, divisors) for guard in self.found.guards]
        outputs = [discriminants, ca.vertcat(*unknowns), ca.vertcat(*guards)]
        outputs = gathered(outputs, [self.values.u, formulas.roots], self.values.turns)
        count = formulas.roots.numel()
        inputs = [
            (self.values.u, "w->u"),
            (formulas.roots, [f"r{k + 1}" for k in range(count)]),
        ]
        emitter = Emitter.of(real, inputs, *outputs)
        self.values.store_guards(emitter, 2, "guard", of_divisors=True)
        lines, zero, begun = emitter.lines, real.literal(0.0), len(emitter.lines)
        for k in range(count):
            text = emitter.value(0, k)
            lines.append(
                f"const {real.type} d{k + 1} = {text}; /* above 0 where "
                f"{c_comment(formulas.names[k])} has two values */"
            )
            lines.append(
                f"const {real.type} r{k + 1} = w->sign[{k}] * {real.call('sqrt')}((d{k + 1} > "
                f"{zero}) ? d{k + 1} : {zero});"
            )
        self.values.store_guards(emitter, 2, "guard", of_divisors=False)
        for i in range(len(unknowns)):
            if i in self._answer.needed:
                lines.append(f"w->y[{i}] = {emitter.value(1, i)};")
        one = real.literal(1.0)
        shares = [
            f"{real.call('fabs')}(r{k + 1}) * {real.literal(1.0 / float(root))}"
            for k, root in enumerate(self.found.usual_roots)
        ]
        lines.append(f"w->share = {shares[0] if shares else one};")
        for k, share in enumerate(shares[1:], start=2):
            lines.append(f"const {real.type} share{k} = {share};")
            lines.append(f"w->share = (share{k} < w->share) ? share{k} : w->share;")
        none = [
            f"w->guard[{j}] = {zero};"
            for j, guard in enumerate(self.found.guards)
            if not guard.is_divisor
        ]
        condition = self.values.above("guard", of_divisors=True)
        if not self.found.guards:
            lines.append(f"w->guard[0] = {one}; /* nothing can vanish */")
        if not condition:
            return lines
        return [
            *lines[:begun],
            f"if ({condition}) {{",
            *("    " + line for line in lines[begun:]),
            "} else {",
            "    /* what formulas divide by vanishes: no guard is above zero */",
            *("    " + line for line in none),
            f"    w->share = {zero};",
            "}",
        ]

    @property
    def _set_lines(self) -> list[str]:
        lines, call = [], f"{self.made.name}_cosine_and_sine"
        for i, c in enumerate(self.made.actuated):
            place = self.values.joint_places[c.name][0]
            if not c.is_angular:
                lines.append(f"w->u[{place}] = joints[{i}];")
            elif self.real.name == "float":
                lines.append(f"{call}(joints[{i}], &w->u[{place}]);")
            else:
                lines += [
                    f"w->u[{place}] = cos(joints[{i}]);",
                    f"w->u[{place + 1}] = sin(joints[{i}]);",
                ]
        return lines
