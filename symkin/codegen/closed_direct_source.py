"""Write the C of a direct problem that formulas solve: guess, formulas, the check of the line,
answer.

No angle is formed where cosine and sine are known: the guess's joints, its turn and the answer's.
Angles of the line between two configurations are needed where it has to be cut alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symkin.codegen.map.direct_text import DirectText
from symkin.codegen.steps.newton_kernel import rounded
from symkin.codegen.text.c import Emitter, block, refused
from symkin.codegen.text.gathered import gathered
from symkin.codegen.text.templates import fill
from symkin.codegen.text.turns import angle_of_direction, cosine_and_sine
from symkin.spatial.backend import stacked

_WIDE = 1.5 * np.pi
"""Range of a limited angle (rad) from which the way between two of its values may be longer than
half a turn and ends within a right angle all the same.
"""
_ARC = 0.117
"""An angle up to a right one squared is its chord squared, c, and less than this times c^2: (pi^2 /
8 - 1) / 2.
"""
_ROUNDED = 256.0
"""Roundings by which a guess's slide, read from its pose, may be beyond its range: the given value
is held against its limits apart.
"""


@dataclass(frozen=True, eq=False)
class ClosedDirectSource(DirectText):
    """The direct problem of one platform; `common` are the values of the names that templates of
    limbs need.
    """

    common: Mapping[str, object]

    @property
    def text(self) -> str:
        """All functions of the direct problem."""
        real, made = self.real, self.made
        angular = any(c.is_angular for c in made.actuated)
        polynomial = real.name == "float" and angular
        angle = angle_of_direction(real, self.common) if polynomial else ""
        turn = cosine_and_sine(self.real, self.common) if polynomial else ""
        wide = [
            c.limits is not None and c.is_angular and c.limits[1] - c.limits[0] > _WIDE
            for c in made.actuated
        ]
        values = dict(self.common) | {
            "nu": self.u.numel(),
            "nk": max(1, self.found.form.roots.numel()),
            "nto": len(made.actuated),
            "k": "name_direct",
            "ny": self.y.numel(),
            "guess_lines": self.guess_lines,
            "formula_lines": self._formula_lines,
            "set_lines": self._set_lines,
            "guard_members": self.guards.members,
            "aimed": f"const real joints[{len(made.actuated)}], ",
            "walk_members": f"    real at_end[{len(made.actuated)}];",
            "at_lines": self._at_lines,
            "span_lines": self._span_lines,
            "change_lines": self._change_lines,
            "same_signs": self._same_signs,
            "near": "false" if any(wide) else "true",
            # limits of more than half a turn: the line within them need not be the nearer way
            # round, and is walked
            "evaluations": "two evaluations, since limits say which way round the line goes"
            if any(wide)
            else "one evaluation",
            "evaluation_count": 2 if any(wide) else 1,
            "half_lines": self._half_lines,
            "rounding": rounded(64 * real.epsilon * made.size),
            **self.answer_lines,
        }
        aim = [
            f"for (int i = 0; i < {len(made.actuated)}; ++i) {{",
            "    const real there = at[i] + end * (to[i] - at[i]);",
            "    at_end[i] = (end < 1.0) ? there : joints[i];",
            "}",
            "name_direct_set(w, at_end);",
            "name_direct_formulas(w);",
        ]
        walk = self.guards.text(values, aim, 1.0 if any(wide) else 0.5)
        return turn + fill("closed_direct.c", values | {"walk": angle + walk})

    @property
    def _half_lines(self) -> str:
        """Statements of cosine and sine of half the pose's turn."""
        if not self._turns:
            return ""
        places = self.unknown_places[self._turns[0].name]
        cosine, sine = (f"w->y[{i}]" for i in places)
        return fill("half_turn.c", {**self.common, "cosine": cosine, "sine": sine})

    @property
    def _same_signs(self) -> list[str]:
        """Statements that compare the signs of a guess read again."""
        count = self.found.form.roots.numel()
        return (
            [
                f"for (int k = 0; (k < {count}) && (status == NAME_OK); ++k) {{",
                "    status = (again.sign[k] * w->sign[k] > 0.0) ? NAME_OK : NAME_WRONG_BRANCH;",
                "}",
            ]
            if count
            else ["(void)w;"]
        )

    @property
    def _formula_lines(self) -> list[str]:
        """Statements of roots, unknowns and guards."""
        form, real = self.found.form, self.real
        numbers = (form.whole.numbers[c.name][0] for c in self.unknowns)
        unknowns = (
            part * (1.0 if len(n.parts) == 2 else self.found.unit)
            for n in numbers
            for part in n.parts
        )
        discriminants = [c.value for c in form.discriminants]
        outputs = [
            stacked(discriminants),
            stacked(unknowns),
            self.guards_of(discriminants, form.whole, form.divisors),
        ]
        outputs = [self.of_numbers(e, self.u) for e in outputs]
        outputs = gathered(outputs, [self.u, form.roots], form.turns)
        inputs = [(self.u, "w->u"), (form.roots, [f"r{k + 1}" for k in range(form.roots.numel())])]
        emitter = Emitter.of(real, inputs, *outputs)
        self.store_guards(emitter, 2, "guard", of_divisors=True)
        begun, lines = emitter.take(), emitter.lines
        for k, one in enumerate(form.discriminants):
            square, sign = emitter.value(0, k), f"w->sign[{k}]"
            emitter.root(k + 1, square, "0.0", "0.0", about=one.name, sign=sign)
        self.store_guards(emitter, 2, "guard", of_divisors=False)
        for i in sorted(self.needed):
            text = emitter.value(1, i)
            lines.append(f"w->y[{i}] = {text};")
        shares = [
            f"fabs(r{k + 1}) * {rounded(1.0 / float(root))}"
            for k, root in enumerate(self.found.usual_roots)
        ]
        lines.append(f"w->share = {shares[0] if shares else 1.0};")
        for k, share in enumerate(shares[1:], start=2):
            lines.append(f"const real share{k} = {share};")
            lines.append(f"w->share = (share{k} < w->share) ? share{k} : w->share;")
        if not self.found.guards:
            lines.append("w->guard[0] = 1.0; /* nothing can vanish */")
        condition = self.above("guard", of_divisors=True)
        if not condition:
            return [*begun, *emitter.take()]
        none = [
            f"w->guard[{j}] = 0.0;"
            for j, guard in enumerate(self.found.guards)
            if not guard.is_divisor
        ]
        return [
            *begun,
            *block(
                f"if ({condition})",
                emitter.take(),
                [
                    "/* what formulas divide by vanishes: no guard is above zero */",
                    *none,
                    "w->share = 0.0;",
                ],
            ),
        ]

    @property
    def _set_lines(self) -> list[str]:
        lines, call = [], "name_cosine_and_sine"
        for i, c in enumerate(self.made.actuated):
            place = self.joint_places[c.name][0]
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

    # --- the line ---------------------------------------------------------------------------------

    @property
    def _change_lines(self) -> list[str]:
        """Statements of the squares of changes, of an angle by its chord's."""
        lines = list[str]()
        for i, c in enumerate(self.made.actuated):
            places = self.joint_places[c.name]
            lines += [f"const real move{n} = w->u[{n}] - w->at[{n}];" for n in places]
            square = " + ".join(f"move{n} * move{n}" for n in places)
            if not c.is_angular:
                lines += [f"change[{i}] = {square};"]
                continue
            lines += [
                f"const real chord{i} = {square};",
                f"kept = kept && (chord{i} <= 2.0);",
                f"change[{i}] = chord{i} + {_ARC} * chord{i} * chord{i};",
            ]
        return lines

    @property
    def _span_lines(self) -> list[str]:
        """Statements that choose the part of the slides' ranges that holds the line, and refuse
        what is outside.
        """
        real, slides, tests = self.real, list[tuple[str, float, float]](), list[str]()
        joints = zip(self.made.actuated, self.found.spans, strict=True)
        for i, (c, span) in enumerate(joints):
            if not span.angular:
                guess = f"w->at[{self.joint_places[c.name][0]}]"
                for text, room in ((guess, 1.0 + _ROUNDED * real.epsilon), (f"joints[{i}]", 1.0)):
                    tests.append(f"(away{len(slides)} <= {room * span.half})")
                    slides.append((text, span.middle, span.half))
        if not slides:
            return []
        return [
            "/* which part of the slides' ranges holds both ends of the line */",
            *self.guards.reach_lines(slides),
            *refused(" && ".join(tests), "WRONG_BRANCH"),
        ]

    @property
    def _at_lines(self) -> list[str]:
        """Statements of the joints' values at the guess and the given ones that are meant."""
        made, lines = self.made, list[str]()
        for i, c in enumerate(made.actuated):
            places = self.joint_places[c.name]
            if c.is_angular:
                lines.append(f"at[{i}] = atan2(w->at[{places[1]}], w->at[{places[0]}]);")
            else:
                lines.append(f"at[{i}] = w->at[{places[0]}];")
        lines += self.into_limits("at", "joints")
        return [*lines, *self.unwrapped("given", "joints", "at")]
