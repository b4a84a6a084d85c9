"""Write the C that begins the line of a direct problem in closed form: changes of the given values,
and the part of the slides' ranges that holds it.
"""

from __future__ import annotations

from dataclasses import dataclass

from symkin.codegen.direct_values import DirectValues

_ARC = 0.117
"""An angle up to a right one squared is its chord squared, c, and less than this times c^2: (pi^2 /
8 - 1) / 2.
"""
_ROUNDED = 256.0
"""Roundings by which a guess's slide, read from its pose, may be beyond its range: the given value
is held against its limits apart.
"""


@dataclass(frozen=True, eq=False)
class LineText:
    """How a line between two given values of one platform is looked at."""

    values: DirectValues

    @property
    def change_lines(self) -> list[str]:
        lines, real = [], self.values.real
        for i, c in enumerate(self.values.made.actuated):
            places = self.values.joint_places[c.name]
            for n in places:
                lines.append(f"const {real.type} move{n} = w->u[{n}] - w->at[{n}];")
            square = " + ".join(f"move{n} * move{n}" for n in places)
            if c.is_angular:
                lines += [
                    f"const {real.type} chord{i} = {square};",
                    f"kept = kept && (chord{i} <= {real.literal(2.0)});",
                    f"change[{i}] = chord{i} + {real.literal(_ARC)} * chord{i} * chord{i};",
                ]
            else:
                lines += [f"change[{i}] = {square};"]
        return lines

    @property
    def span_lines(self) -> list[str]:
        """Statements that choose the part of the slides' ranges that holds the line, and refuse
        what is outside.
        """
        real, slides, tests = self.values.real, list[tuple[str, float, float]](), list[str]()
        joints = zip(self.values.made.actuated, self.values.found.spans, strict=True)
        for i, (c, span) in enumerate(joints):
            if not span.angular:
                guess = f"w->at[{self.values.joint_places[c.name][0]}]"
                for text, room in ((guess, 1.0 + _ROUNDED * real.epsilon), (f"joints[{i}]", 1.0)):
                    tests.append(f"(away{len(slides)} <= {real.literal(room * span.half)})")
                    slides.append((text, span.middle, span.half))
        if not slides:
            return []
        return [
            "/* which part of the slides' ranges holds both ends of the line */",
            *self.values.guards.reach_lines(slides),
            f"if (!({' && '.join(tests)})) {{",
            f"    status = {self.values.made.name.upper()}_WRONG_BRANCH;",
            "}",
        ]

    @property
    def at_lines(self) -> list[str]:
        """Statements of the joints' values at the guess and the given ones that are meant."""
        made, p, lines = (
            self.values.made,
            self.values.made.name,
            list[str](),
        )
        angle = f"{p}_angle" if self.values.real.name == "float" else "atan2"
        for i, c in enumerate(made.actuated):
            places = self.values.joint_places[c.name]
            if c.is_angular:
                lines.append(f"at[{i}] = {angle}(w->at[{places[1]}], w->at[{places[0]}]);")
            else:
                lines.append(f"at[{i}] = w->at[{places[0]}];")
        if any(made.limited_angles):
            lines.append(f"{p}_turn_into_limits(at, joints);")
        return [*lines, f"{p}_unwrap_joints(at, joints, given);"]
