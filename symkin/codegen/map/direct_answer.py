"""Write the C of the answer of a direct problem in closed form: residual, sides of the limbs,
pose.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from symkin.codegen.closed_limb import BESIDE, READ_AGAIN, LimbFormulas, side_lines
from symkin.codegen.map.direct_values import DirectValues
from symkin.codegen.steps.newton_source import tolerance_of
from symkin.codegen.steps.pose_coordinates import POSE
from symkin.codegen.text.angles import NotLiftedError, Numbers, lifted
from symkin.codegen.text.c import Emitter, indent
from symkin.codegen.text.gathered import gathered
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.spatial.backend import stacked

_SMALL_SHARE = 1.0 / 64
"""Share of its usual size below which a root multiplies rounding so much that an answer is read
again before it is OK.
"""
_FIRM = 64.0
"""How many times what rounding leaves of a guard it is at least where an answer need not be read
again.
"""


class AnswerText(DirectValues):
    """How the answer of one platform is checked and written."""

    @property
    def _turns(self) -> list[Coordinate]:
        """The turn of the pose, if it has one."""
        return [c for c in self.made.closure.role("pose") if c.is_angular]

    @cached_property
    def _limbs(self) -> list[LimbFormulas]:
        """The limbs that have choices."""
        blocks = [(b, b.formulas) for b in self.made.blocks]
        return [LimbFormulas(self.made, b, found) for b, found in blocks if found is not None]

    @cached_property
    def _answer(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Rows, sides of the limbs' choices and numbers of the pose, over u, y and the half
        turn.
        """
        made, system, none = self.made, self.found.formulas.system, ca.SX(0, 1)
        half = Numbers.of((self.half[0], self.half[1]), is_half=True)
        generators = self.generators | {c.name: half for c in self._turns}
        try:
            rows = lifted(system.rows, self.places(system), generators, none)
        except NotLiftedError:
            # these hold whole angles only
            rows = lifted(system.errors, self.places(system), generators, none)
        sides = [
            lifted(
                limb.formulas.sides(limb.signs), self.places(limb.block.system), generators, none
            )
            for limb in self._limbs
        ]
        pose = made.closure.role("pose")
        symbols = [(made.closure.symbols([c]), c.name) for c in pose]
        return (
            self._distinct(rows),
            stacked(sides),
            lifted(made.geometry.pose, symbols, generators, none),
        )

    def _distinct(self, rows: ca.SX) -> ca.SX:
        """Rows without those that equal another one, at values about 1 and about the size: beside
        the first the squares of a tiny machine's lengths are nothing, beside the second its cosines
        are.
        """
        symbols = ca.vertcat(self.u, self.y, self.half)
        function = ca.Function("rows", [symbols], [rows])
        rng = np.random.default_rng(2)
        sizes = [1.0, 1.0, 1.0, *[self.made.size] * 3]
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
        reads = ca.which_depends(stacked(self._answer), self.y, 1, False)
        turns = {i for c in self._turns for i in self.unknown_places[c.name]}
        return turns | {i for i, is_read in enumerate(reads) if is_read}

    @property
    def lines(self) -> dict[str, str]:
        """Statements of the residual, the sides, what is firm, and the pose."""
        real, symbols = self.real, [self.u, self.y, self.half]
        outputs = gathered(list(self._answer), symbols, self.turns)
        names = zip(symbols, ("w->u", "w->y", "h"), strict=True)
        emitter = Emitter.of(real, list(names), *outputs)
        squares = " + ".join(f"{t} * {t}" for t in emitter.values(0))
        emitter.lines.append(f"*residual = {real.call('sqrt')}({squares});")
        residual, tests, k = emitter.take(), list[str](), 0
        for limb in self._limbs:
            size = limb.block.system.characteristic_length
            near = READ_AGAIN * BESIDE * np.sqrt(tolerance_of(real, size) / size)
            for root, what in zip(limb.usual_roots, limb.formulas.names, strict=True):
                bounds = (0.0, float(near * root))
                tests += side_lines(emitter.value(1, k), what, bounds, real, self.capital)
                k += 1
        sides = [*emitter.take(), *tests]
        parts = {"residual": residual, "side": sides, "firm": self._firm_lines}
        return {f"{part}_lines": indent(lines) for part, lines in parts.items()} | {
            "pose_lines": indent(emitter.stored(POSE, 2), 2)
        }

    @property
    def _firm_lines(self) -> list[str]:
        """Statements on what is near a fold: there the pose's error is large beside the
        distance.
        """
        found, lines = self.found, list[str]()
        tests = [f"(w->share > {self.literal(_SMALL_SHARE)})"] * bool(found.usual_roots.size)
        for j, guard in enumerate(found.guards):
            firm = self.guards.by_reach(f"firm{j}", self.guards.roundings(guard, _FIRM), lines)
            tests.append(f"(w->guard[{j}] > {firm})")
        return [*lines, f"bool firm = {' && '.join(tests) or 'true'};"]

    @property
    def half_lines(self) -> list[str]:
        """Statements of cosine and sine of half the pose's turn, by the larger one."""
        kind, half, zero = self.real.type, self.literal(0.5), self.real.zero
        sqrt, fabs = self.real.call("sqrt"), self.real.call("fabs")
        lines = list[str]()
        for c in self._turns:
            cosine, sine = (f"w->y[{i}]" for i in self.unknown_places[c.name])
            lines += [
                f"{kind} h[2];",
                "/* half the turn, by the larger of its cosine and sine */",
                f"const {kind} larger = {sqrt}({half} + {half} * {fabs}({cosine}));",
                f"const {kind} lesser = {half} * {sine} / larger;",
                f"if ({cosine} >= {zero}) {{",
                "    h[0] = larger;",
                "    h[1] = lesser;",
                "} else {",
                f"    h[0] = {fabs}(lesser);",
                f"    h[1] = (lesser < {zero}) ? -larger : larger;",
                "}",
            ]
        return lines
