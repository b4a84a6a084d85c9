"""Write the C of the answer of a direct problem in closed form: residual, sides of the limbs,
pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.codegen.closed_limb import BESIDE, READ_AGAIN, LimbFormulas, side_lines
from symkin.codegen.direct_values import DirectValues
from symkin.codegen.newton_source import tuning_of
from symkin.codegen.text.angles import NotLiftedError, Numbers, lifted
from symkin.codegen.text.c import Emitter, indent, indexed
from symkin.codegen.text.gathered import gathered
from symkin.computed_once import cached_property
from symkin.spatial.backend import stacked

_SMALL_SHARE = 1.0 / 64
"""Share of its usual size below which a root multiplies rounding so much that an answer is read
again before it is OK.
"""
_FIRM = 64.0
"""How many times what rounding leaves of a guard it is at least where an answer need not be read
again.
"""


@dataclass(frozen=True, eq=False)
class AnswerText:
    """How the answer of one platform is checked and written."""

    values: DirectValues

    @cached_property
    def _answer(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Rows, sides of the limbs' choices and numbers of the pose, over u, y and the half
        turn.
        """
        made, formulas = self.values.made, self.values.found.formulas
        generators = dict(self.values.generators)
        for c in made.closure.role("pose"):
            if c.is_angular:
                generators[c.name] = Numbers.of(
                    (self.values.half[0], self.values.half[1]), is_half=True
                )
        none = ca.SX(0, 1)
        places = self.values.places(formulas.system)
        try:
            rows = lifted(formulas.system.rows, places, generators, none)
        except NotLiftedError:
            # these hold whole angles only
            rows = lifted(formulas.system.errors, places, generators, none)
        sides = [none]
        for block in made.blocks:
            if block.formulas is None:
                continue
            limb = LimbFormulas(made, block, block.formulas)
            sides.append(
                lifted(
                    block.formulas.sides(limb.signs),
                    self.values.places(block.system),
                    generators,
                    none,
                )
            )
        pose_symbols = [
            (made.closure.variables[made.closure.slices[c.name]], c.name)
            for c in made.closure.role("pose")
        ]
        pose = made.geometry.pose
        return (
            self._distinct(rows),
            ca.vertcat(*sides),
            lifted(pose, pose_symbols, generators, none),
        )

    def _distinct(self, rows: ca.SX) -> ca.SX:
        """Rows without those that equal another one, at values about 1 and about the size: beside
        the first the squares of a tiny machine's lengths are nothing, beside the second its cosines
        are.
        """
        symbols = ca.vertcat(self.values.u, self.values.y, self.values.half)
        function = ca.Function("rows", [symbols], [rows])
        rng = np.random.default_rng(2)
        sizes = [1.0, 1.0, 1.0, *[self.values.made.closure.characteristic_length] * 3]
        drawn = [s * rng.normal(size=symbols.numel()) for s in sizes]
        values = np.array([np.asarray(function(one)).ravel() for one in drawn])
        values /= np.maximum(np.max(np.abs(values), axis=1, keepdims=True), np.finfo(float).tiny)
        kept: list[int] = []
        for k in range(values.shape[1]):
            if not any(
                np.allclose(values[:, k], s * values[:, j], rtol=1e-9, atol=1e-15)
                for j in kept
                for s in (1, -1)
            ):
                kept.append(k)
        return stacked(rows[k] for k in kept)

    @cached_property
    def needed(self) -> set[int]:
        """Places of `y` that the answer reads."""
        function = ca.Function(
            "answer", [self.values.y, self.values.u, self.values.half], [ca.vertcat(*self._answer)]
        )
        turns = {
            i
            for c in self.values.made.closure.role("pose")
            if c.is_angular
            for i in self.values.unknown_places[c.name]
        }
        return turns | {
            i
            for i, reads in enumerate(
                ca.which_depends(
                    function(self.values.y, self.values.u, self.values.half),
                    self.values.y,
                    1,
                    False,
                )
            )
            if reads
        }

    @property
    def lines(self) -> dict[str, str]:
        real, name = self.values.real, self.values.made.name.upper()
        rows, sides, pose = self._answer
        symbols = [self.values.u, self.values.y, self.values.half]
        outputs = gathered([rows, sides, pose], symbols, self.values.turns)
        function = ca.Function("answer", symbols, outputs, {"cse": True})
        names = [
            indexed("w->u", self.values.count),
            indexed("w->y", self.values.y.numel()),
            indexed("h", 2),
        ]
        emitter = Emitter(function, names, real)
        texts = [emitter.value(0, k) for k in range(rows.numel())]
        squares = " + ".join(f"{t} * {t}" for t in texts)
        emitter.lines.append(f"*residual = {real.call('sqrt')}({squares});")
        residual = list(emitter.lines)
        tests, k = [], 0
        for block in self.values.made.blocks:
            if block.formulas is None:
                continue
            limb = LimbFormulas(self.values.made, block, block.formulas)
            for root, what in zip(limb.usual_roots, block.formulas.names, strict=True):
                near = (
                    READ_AGAIN
                    * BESIDE
                    * np.sqrt(self._tolerance / block.system.characteristic_length)
                )
                tests += side_lines(
                    emitter.value(1, k), what, (0.0, float(near * root)), real, name
                )
                k += 1
        side = [*emitter.lines[len(residual) :], *tests]
        begin = len(emitter.lines)
        targets = indexed("pose->position", 3) + indexed("pose->quaternion", 4)
        values = [emitter.value(2, i) for i in range(7)]
        stores = [
            *emitter.lines[begin:],
            *(f"{target} = {text};" for target, text in zip(targets, values, strict=True)),
        ]
        parts = {"residual": residual, "side": side, "firm": self._firm_lines}
        return {f"{part}_lines": indent(lines) for part, lines in parts.items()} | {
            "pose_lines": indent(stores, 2)
        }

    @property
    def _firm_lines(self) -> list[str]:
        """Statements on what is near a fold: there the pose's error is large beside the
        distance.
        """
        real, values = self.values.real, self.values
        tests = (
            [f"(w->share > {real.literal(_SMALL_SHARE)})"] if values.found.usual_roots.size else []
        )
        lines = list[str]()
        for j, guard in enumerate(values.found.guards):
            firm = values.guards.by_reach(f"firm{j}", values.guards.roundings(guard, _FIRM), lines)
            tests.append(f"(w->guard[{j}] > {firm})")
        return [*lines, f"bool firm = {' && '.join(tests) or 'true'};"]

    @property
    def half_lines(self) -> list[str]:
        """Statements of cosine and sine of half the pose's turn, by the larger one."""
        real = self.values.real
        for c in self.values.made.closure.role("pose"):
            if c.is_angular:
                cosine, sine = (f"w->y[{i}]" for i in self.values.unknown_places[c.name])
                half, zero, sqrt = real.literal(0.5), real.literal(0.0), real.call("sqrt")
                return [
                    f"{real.type} h[2];",
                    "/* half the turn, by the larger of its cosine and sine */",
                    f"const {real.type} larger = {sqrt}({half} + {half} * "
                    f"{real.call('fabs')}({cosine}));",
                    f"const {real.type} lesser = {half} * {sine} / larger;",
                    f"if ({cosine} >= {zero}) {{",
                    "    h[0] = larger;",
                    "    h[1] = lesser;",
                    "} else {",
                    f"    h[0] = {real.call('fabs')}(lesser);",
                    f"    h[1] = (lesser < {zero}) ? -larger : larger;",
                    "}",
                ]
        return []

    @property
    def _tolerance(self) -> float:
        return tuning_of(self.values.made.direct_kernel, self.values.real, 1.0).tolerance
