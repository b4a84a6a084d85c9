"""Write the C that checks the line of a direct problem in closed form: changes of the given values
against guards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.codegen.direct_values import DirectValues
from symkin.codegen.newton_kernel import rounded_up
from symkin.text import c_comment

_ARC = 0.117
"""An angle up to a right one squared is its chord squared, c, and less than this times c^2: (pi^2 /
8 - 1) / 2.
"""
_ALIKE = 0.01
"""Relative difference of weights that are taken as equal: as the largest of them."""


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
        real, largest = self.values.real, []
        for i, (c, span) in enumerate(
            zip(self.values.made.actuated, self.values.found.spans, strict=True)
        ):
            if not span.angular:
                place, beyond = self.values.joint_places[c.name][0], 1.0 + _ROUNDED * real.epsilon
                for value, half in (
                    (f"w->at[{place}]", span.half * beyond),
                    (f"joints[{i}]", span.half),
                ):
                    largest.append(
                        f"{real.literal(1.0 / half)} * {real.call('fabs')}({value} - "
                        f"{real.literal(span.middle)})"
                    )
        if not largest:
            return []
        p = self.values.made.name.upper()
        lines = [
            f"if (status == {p}_OK) {{",
            "    /* which part of the slides' ranges holds both ends of the line */",
            f"    {real.type} excursion = {largest[0]};",
        ]
        for text in largest[1:]:
            lines += [
                "    {",
                f"        const {real.type} other = {text};",
                "        excursion = (other > excursion) ? other : excursion;",
                "    }",
            ]
        for reach in self.values.found.parts[:-1]:
            lines += [f"    w->reach += (excursion > {real.literal(reach)}) ? 1U : 0U;"]
        return [
            *lines,
            f"    if (!(excursion <= {real.literal(1.0)})) {{",
            f"        status = {p}_WRONG_BRANCH;",
            "    }",
            "}",
        ]

    @property
    def at_lines(self) -> list[str]:
        """Statements of the joints' values at the guess and the given ones that are meant."""
        made, p, lines = (
            self.values.made,
            self.values.made.name,
            [f"{self.values.real.type} at_end[{len(self.values.made.actuated)}];"],
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

    @property
    def reach_member(self) -> str:
        return "    unsigned int reach;" if len(self.values.found.parts) > 1 else ""

    @property
    def keep_lines(self) -> list[str]:
        """Statements that compare each guard with how far it may bend on the way."""
        real, zero = self.values.real, self.values.real.literal(0.0)
        roots = {guard.root for guard in self.values.found.guards}
        lines, sums = ["bool kept = true;"], dict[str, str]()
        for j, guard in enumerate(self.values.found.guards):
            lines.append(f"/* {c_comment(guard.name)} */")
            rounding = self.values.by_reach(f"noise{j}", self.values.roundings(guard), lines)
            lines += [
                f"const {real.type} a{j} = w->left[{j}] - {rounding};",
                f"const {real.type} b{j} = w->guard[{j}] - {rounding};",
                f"const {real.type} lesser{j} = (a{j} < b{j}) ? a{j} : b{j};",
            ]
            bend = self._weighted(
                f"plain{j}", [weights.plain for weights in guard.weights], lines, sums
            )
            if guard.root is not None:
                # the root that it holds is at least this on the way
                lines.append(
                    f"const {real.type} per{j} = {real.literal(1.0)} / "
                    f"{real.call('sqrt')}(under{guard.root});"
                )
                once = self._weighted(
                    f"once{j}", [weights.by_root for weights in guard.weights], lines, sums
                )
                cube = self._weighted(
                    f"thrice{j}", [weights.by_cube for weights in guard.weights], lines, sums
                )
                bend = f"{bend} + per{j} * ({once} + per{j} * per{j} * ({cube}))"
            lines.append(f"const {real.type} bend{j} = {bend};")
            lines += [
                f"const {real.type} most{j} = a{j} + b{j} + lesser{j} + lesser{j};",
                f"if (!((lesser{j} > {zero}) && (bend{j} < most{j}))) {{",
                f"    w->over = (kept && (lesser{j} > {zero})) ? (bend{j} / most{j}) : w->over;",
                "    kept = false;",
                "}",
            ]
            if j in roots:
                lines.append(
                    f"const {real.type} least{j} = lesser{j} - {real.literal(0.25)} * bend{j};"
                )
                lines.append(f"kept = kept && (least{j} > {zero});")
                lines.append(
                    f"const {real.type} under{j} = (least{j} > {zero}) ? least{j} : "
                    f"{real.literal(1.0)};"
                )
        # guards that do not bend, of linear formulas, read no changes
        read = {"w": "w->", "change": "change["}
        unread = [name for name, text in read.items() if not any(text in line for line in lines)]
        return [*(f"(void){name};" for name in unread), *lines]

    def _weighted(
        self, name: str, weights: Sequence[np.ndarray], lines: list[str], sums: dict[str, str]
    ) -> str:
        """C text of a sum of squared changes by weights of each reach; joints of about one weight
        are added first. `lines` get tables and sums.
        """
        real, parts = self.values.real, list[str]()
        table = np.array([[rounded_up(float(v)) for v in part] for part in weights])
        left = [i for i in range(table.shape[1]) if np.any(table[:, i] > 0.0)]
        while left:
            alike = [
                i
                for i in left
                if np.all(np.abs(table[:, i] - table[:, left[0]]) <= _ALIKE * table[:, left[0]])
            ]
            left = [i for i in left if i not in alike]
            column, added = (
                np.max(table[:, alike], axis=1),
                " + ".join(f"change[{i}]" for i in alike),
            )
            if len(alike) > 1:
                if added not in sums:
                    sums[added] = f"sum{len(sums)}"
                    lines.append(f"const {real.type} {sums[added]} = {added};")
                added = sums[added]
            weight = self.values.by_reach(f"{name}_{alike[0]}", column.tolist(), lines)
            parts.append(f"{weight} * {added}")
        return " + ".join(parts) or real.literal(0.0)
