"""Write the C that holds guards along a line of known values, and what a README says of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symkin.codegen.steps.guards import NOISE, SLIDE_PARTS, Guard
from symkin.codegen.steps.newton_kernel import rounded, rounded_up
from symkin.codegen.text.c import Real
from symkin.codegen.text.templates import fill, substitute
from symkin.text import c_comment, markdown

Watched = tuple[Sequence[str], Sequence[Guard]]
"""What changes along the lines of a function, and its guards."""
_NOISE = 64.0
"""Roundings of a guard's size below which its value is nothing."""
_BOTH_ENDS = 4.0 / 3.0
"""Multiples of this that the lesser end of a part is less, of which three times the value counts:
as much as both ends less their own.
"""
_ALIKE = 0.01
"""Relative difference of weights that are taken as equal: as the largest of them."""
_LEAST_PART = 2.0**-12
"""Shortest part of a line."""
_STRAIGHT = dict.fromkeys(("aimed", "walk_members", "and_follows", "take"), "") | {
    "longer": "part + part"
}
"""What the walk along straight lines of known values asks and does beside its guards: nothing."""
_WAYS = """\
    for (int i = 0; i < @{nto}; ++i) {
        way2[i] = (to[i] - at[i]) * (to[i] - at[i]);
    }"""

_HOLD_GUARDS = """\
        for (int j = 0; j < @{ng}; ++j) {
            above = above && (w->guard[j] > 0.0);
        }"""


@dataclass(frozen=True, eq=False)
class GuardText:
    """The guards of one direct problem or direction, whose work space is `w`: `w->left` and
    `w->guard` are their values where the line is done and at the point that is tried. `measures`:
    what is too long is cut by how far it is, and not halved.
    """

    guards: Sequence[Guard]
    real: Real
    measures: bool

    @property
    def members(self) -> list[str]:
        """Members of the work space."""
        count = max(1, len(self.guards))
        lines = [f"real left[{count}];", f"real guard[{count}];"]
        if self.measures:
            lines += ["real bent;", "real most;"]
        return [*lines, *(["unsigned int reach;"] if self._has_parts else [])]

    @property
    def _has_parts(self) -> bool:
        return any(len(guard.bounds) > 1 for guard in self.guards)

    def reach_lines(self, slides: Sequence[tuple[str, float, float]]) -> list[str]:
        """Statements of the first part of the slides' ranges that holds the line, which has these
        values: C text, the middle of the range and half of its width. `away0`, ... are how far they
        are from the middle.
        """
        lines = ["w->reach = 0U;"] if self._has_parts else []
        for i, (text, middle, half) in enumerate(slides):
            value = text if middle == 0.0 else f"{text} - {middle}"
            lines.append(f"const real away{i} = fabs({value});")
            for k, part in enumerate(SLIDE_PARTS[:-1] if self._has_parts else (), start=1):
                beyond = f"(w->reach < {k}U) && (away{i} > {part * half})"
                lines.append(f"w->reach = ({beyond}) ? {k}U : w->reach;")
        return lines

    def roundings(self, guard: Guard, times: float = 1.0) -> list[float]:
        """Multiples of the values of a guard that are nothing but rounding, one for each part of
        the slides' ranges.
        """
        return [rounded(times * _NOISE * self.real.epsilon * b.size) for b in guard.bounds]

    def by_reach(self, name: str, values: Sequence[float], lines: list[str]) -> str:
        """C text of one of the values, by the part of the slides' ranges that holds the line;
        `lines` get their table where they differ.
        """
        if all(value == values[0] for value in values):
            return str(values[0])
        texts = ", ".join(str(value) for value in values)
        lines.append(f"static const real {name}[{len(values)}] = {{ {texts} }};")
        return f"{name}[w->reach]"

    def text(self, values: Mapping[str, object], aim: Sequence[str], first_part: float) -> str:
        """The functions that hold a part of a line and walk all of it; `aim` are statements that
        put the guards of its point `end` into w->guard. Values beside those of `_STRAIGHT` say
        what else a walk asks and does.
        """
        wrong = "NAME_WRONG_BRANCH"
        plain = {"unreached": wrong, "refused": wrong, "nat": values["nto"], "nways": values["nto"]}
        own = {"ng": max(1, len(self.guards)), "walks": "NAME_COLD"}
        plain |= {
            "ways": substitute(_WAYS, values),
            "hold_guards": substitute(_HOLD_GUARDS, {**values, **own}),
            "shorter": self.shorter_lines,
        }
        return fill(
            "guarded_line.c",
            _STRAIGHT
            | own
            | plain
            | ({} if "keep_lines" in values else {"keep_lines": self._keep_lines})
            | dict(values)
            | {
                "aim": aim,
                "first_part": first_part,
                "least_part": _LEAST_PART,
                "not_measured": self._reset_lines,
            },
        )

    @property
    def shorter_lines(self) -> list[str]:
        """Statements of the next part where one was too long."""
        if not self.measures:
            return ["part = 0.5 * share;"]
        return [
            "/* what is too long by its square is cut to nine tenths of what would do */",
            "part = share * ((w->bent < 80.0 * w->most)",
            "    ? (0.9 * sqrt(w->most / w->bent)) : 0.1);",
        ]

    @property
    def _reset_lines(self) -> list[str]:
        """Statements for a part whose bend is not told: it is cut to less than a half."""
        return ["w->bent = 4.0;", "w->most = 1.0;"] if self.measures else []

    @property
    def _keep_lines(self) -> list[str]:
        """Statements that compare each guard with how far it may bend on the way."""
        later = {j for guard in self.guards for j in (guard.root, *guard.read) if j is not None}
        roots = {guard.root for guard in self.guards}
        shared = {j for guard in self.guards for j in guard.read}
        lines, sums = ["bool kept = true;"], dict[str, str]()
        for j, guard in enumerate(self.guards):
            lines.append(f"/* {c_comment(guard.name)}: {guard.ground} */")
            rounding = self.by_reach(f"noise{j}", self.roundings(guard, _BOTH_ENDS), lines)
            bend = self._bend_text(j, guard, lines, sums)
            a, b = f"w->left[{j}]", f"w->guard[{j}]"
            lines += [
                f"const real bend{j} = {bend};",
                f"const real lesser{j} = (({a} < {b}) ? {a} : {b}) - {rounding};",
                f"const real greater{j} = ({a} < {b}) ? {b} : {a};",
                f"const real most{j} = 3.0 * lesser{j} + greater{j};",
                f"if (!((lesser{j} > 0.0) && (bend{j} < most{j}))) {{",
                *(
                    [
                        f"    if (kept && (lesser{j} > 0.0)) {{",
                        f"        w->bent = bend{j};",
                        f"        w->most = most{j};",
                        "    }",
                    ]
                    if self.measures
                    else []
                ),
                "    kept = false;",
                "}",
            ]
            if j in later:
                lines += self._least_lines(j)
            if j in roots:
                lines += [f"const real per{j} = 1.0 / sqrt(under{j});"]
            if j in shared:
                lines += self._share_lines(j)
        # guards that do not bend, of linear formulas, read no changes
        read = {"w": "w->", "change": "change["}
        unread = [name for name, text in read.items() if not any(text in line for line in lines)]
        return [*(f"(void){name};" for name in unread), *lines, "return kept;"]

    def _bend_text(self, j: int, guard: Guard, lines: list[str], sums: dict[str, str]) -> str:
        """C text of K of a guard."""
        columns = {
            "plain": [bound.plain for bound in guard.bounds],
            "once": [bound.by_root for bound in guard.bounds],
            "thrice": [bound.by_cube for bound in guard.bounds],
        }
        parts = [self._weighted(f"{k}{j}", v, lines, sums) for k, v in columns.items()]
        bend = parts[0]
        if guard.root is not None:
            per = f"per{guard.root}"
            bend = f"{bend} + {per} * ({parts[1]} + {per} * {per} * ({parts[2]}))"
        if guard.read:
            # of what it reads these shares are left (README.md)
            bend = f"({bend}) / ({' * '.join(f'share{i}' for i in guard.read)})"
        return bend

    def _least_lines(self, j: int) -> list[str]:
        """Statements of what a guard keeps at least on the way."""
        return [
            f"const real least{j} = lesser{j} - 0.25 * bend{j};",
            f"kept = kept && (least{j} > 0.0);",
            f"const real under{j} = (least{j} > 0.0) ? least{j} : 1.0;",
        ]

    def _share_lines(self, j: int) -> list[str]:
        """Statements of the share that a guard leaves of the bends of those that read it."""
        power = (
            f"(rest{j} * rest{j}) * (rest{j} * rest{j})"
            if self.guards[j].is_divisor
            else f"rest{j} * sqrt(rest{j})"
        )
        return [
            f"const real rest{j} = (under{j} < 1.0) ? under{j} : 1.0;",
            f"const real share{j} = {power};",
        ]

    def _weighted(
        self, name: str, weights: Sequence[np.ndarray], lines: list[str], sums: dict[str, str]
    ) -> str:
        """C text of a sum of squared changes by weights of each reach; known values of about one
        weight are added first. `lines` get tables and sums.
        """
        parts = list[str]()
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
                    lines.append(f"const real {sums[added]} = {added};")
                added = sums[added]
            weight = self.by_reach(f"{name}_{alike[0]}", column.tolist(), lines)
            parts.append(f"{weight} * {added}")
        return " + ".join(parts) or "0.0"


_BENDS = r"""Discriminants $D$ and divisors $v$ of the formulas are the guards $g$: while none of
them reaches zero, each point of the line has one configuration with the guess's signs, which moves
continuously and is regular. On a part of the line, $t$ from 0 to 1, given values change by $d_i$,
and at all its points $|g''(t)| \le \sum_i W_i \, d_i^2 =: 2 K$. So
$g(t) \ge (1 - t) g_0 + t g_1 - K t (1 - t)$, which is above zero for all $t$ where
$K < (\sqrt{g_0} + \sqrt{g_1})^2$. The part is accepted where $K < g_0 + g_1 + 2 \min(g_0, g_1)$,
which is not more; what is refused is cut. A point at which some $g$ is not above its rounding is a
point without a configuration or a singular one, and parts shorter than 1/4096 pass too near to one:
the status is then `WRONG_BRANCH`. Lines within a sixteenth or a quarter of the slides' ranges may
have bounds of their own, which are smaller."""

_PROVED = r"""**Proved** says that $g$ is a polynomial in the given lengths and in cosines and sines
of the given angles: a finite sum of waves in the angles and of Chebyshev polynomials in the lengths
over their ranges, with amplitudes $a$, so that $|g''| \le \sum_a |a| (\sum_i k_i |d_i|)^2$, $k_i$
the order of the wave (of a Chebyshev polynomial its largest derivatives). The amplitudes are those
of exact trigonometric interpolation of $g$, compared with it at points of their own when the code
was generated."""

_ROOT = r"""A guard that holds the root $r$ of another one, $D$, is $P + Q r$ with polynomials $P$
and $Q$; where $D \ge m$ on a part of the line, $r' = D' / (2 r)$ and
$r'' = D'' / (2 r) - D'^2 / (4 r^3)$ give

$$|(P + Q r)''| \le |P''| + |Q''| \, r + |Q'| \, |D'| \, m^{-1/2} + |Q| \, (\tfrac12 |D''| \,
m^{-1/2} + \tfrac14 D'^2 \, m^{-3/2}),$$

each by its amplitudes; $m$ is the bound of $D$ from below by its own $K$,
$\min(g_0, g_1) - K / 4$."""

_SAMPLED = r"""**Sampled** says that $2 K$ is by the largest second derivative of $g$ at 400 samples
of the given values, the larger ones followed uphill, times 1.5, given values in units in which $g$
bends alike with each. A guard that reads the root or the quotient of others bends the more the
nearer these are to 0: its bound is of the second derivative times $h^{3/2}$ for each $h$ under such
a root and $h^4$ for each divisor, $h$ over its usual size and at most 1, and is divided by what
these keep at least in the part."""


def bend_words(guards: Sequence[Guard]) -> str:
    """What a README says of how lines are held by guards of these grounds."""
    grounds = {guard.ground for guard in guards}
    parts = [
        _BENDS,
        *([_PROVED] if "proved" in grounds else []),
        *([_ROOT] if any(guard.root is not None for guard in guards) else []),
        *([_SAMPLED] if "sampled" in grounds else []),
    ]
    return "\n\n".join(parts)


def guard_tables(name: str, watched: Mapping[str, Watched]) -> str:
    """A README's tables of what is watched along lines: the bound of each guard over the widest
    ranges, and the word for how it is known.
    """
    parts = ["## What is watched along a line"]
    if not all(guard.is_led for _, guards in watched.values() for guard in guards):
        parts.append(
            "On a part of a line on which given values change by $d_i$ a guard $g$ bends by at "
            r"most $|g''| \le \sum_i W_i \, d_i^2$. Values of $g$ below 64 roundings of its size "
            "count as zero."
        )
    for function, (ways, guards) in watched.items():
        if all(guard.is_led for guard in guards):
            rows = [
                f"| {markdown(guard.name)} | {guard.bounds[-1].size:.3g} | {guard.ground} |"
                for guard in guards
            ]
            lines = [f"`{name}_{function}`, by what the tool and the joints before do:", ""]
            head = ["| above 0 stays | size | bound |", "|---|---|---|"]
            parts.append("\n".join([*lines, *head, *rows]))
            continue
        lines = [f"`{name}_{function}`, by the squares of changes of {', '.join(ways)}:", ""]
        lines += ["| above 0 stays | $W / 2$ | size | bound |", "|---|---|---|---|"]
        parts.append("\n".join([*lines, *(_row(guard) for guard in guards)]))
    return "\n\n".join(parts)


def _row(guard: Guard) -> str:
    if not guard.bounds:
        return f"| {guard.name} | | | {guard.ground} |"
    last = guard.bounds[-1]
    parts = [(last.plain, "")]
    if guard.root is not None:
        parts += [(last.by_root, r" m^{-1/2}"), (last.by_cube, r" m^{-3/2}")]
    least = NOISE * max(float(np.max(v)) for v, _ in parts)
    sums = [
        " + ".join(f"{v[i]:.3g}{factor}" for v, factor in parts if v[i] > least) or "0"
        for i in range(len(last.plain))
    ]
    weights = ", ".join(f"${text}$" for text in sums)
    return f"| {markdown(guard.name)} | {weights} | {last.size:.3g} | {guard.ground} |"
