"""Write the C that reads the guess of a direct problem in closed form: joints by the limbs, signs
and guards.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from symkin.codegen.closed_limb import LimbFormulas
from symkin.codegen.map.direct_values import DirectValues
from symkin.codegen.map.limb_platform import LimbBlock
from symkin.codegen.steps.formula_guards import RESOLVED
from symkin.codegen.steps.newton_kernel import rounded
from symkin.codegen.steps.pose_coordinates import off_motion, restricted
from symkin.codegen.text.angles import Numbers, lifted
from symkin.codegen.text.c import Emitter
from symkin.codegen.text.gathered import gathered
from symkin.spatial.backend import stacked


class GuessText(DirectValues):
    """How a guess of one platform is read."""

    @property
    def lines(self) -> list[str]:
        """Statements that read a guess: joints by the limbs, signs and guards of the direct
        problem.
        """
        made, found, formulas = self.made, self.found, self.found.formulas
        x, roots, limits = ca.SX.sym("x", 7), list[ca.SX](), list[float]()
        taken, discriminants = restricted(made.geometry, x), list[ca.SX]()
        generators, lengths = dict[str, Numbers](), iter(taken.lengths)
        for c in made.closure.role("pose"):
            turn = taken.half_turn if c.is_angular else None
            generators[c.name] = Numbers.of(
                (next(lengths),) if turn is None else turn, is_half=turn is not None
            )
        for block in made.blocks:
            own = self._joints(block, generators)
            if own is not None:
                roots.append(own[0])
                discriminants.append(own[1])
                limits += own[2]
        places = self.places(formulas.system)
        told = self._told(lifted(self.signed(formulas.told), places, generators, formulas.roots))
        divisors, reaches = (
            lifted(part, places, generators, formulas.roots)
            for part in (
                formulas.divisors,
                stacked(reach.of_configuration for reach in found.whole.reaches),
            )
        )
        guards = ca.vertcat(*(guard.of(told**2, reaches, divisors) for guard in found.guards))
        at = ca.vertcat(*(part for c in made.actuated for part in generators[c.name].parts))
        outputs = [stacked(discriminants), at, told, guards, stacked(taken.off)]
        return self._read(x, stacked(roots), outputs, limits)

    def _joints(
        self, block: LimbBlock, generators: dict[str, Numbers]
    ) -> tuple[ca.SX, ca.SX, list[float]] | None:
        """Add the generators of a limb's joints; its roots, what stands under them, and below which
        that is nothing; None of a rod.
        """
        unknowns, places = block.system.unknowns, self.places(block.system)
        # symbols for unknowns that no formula reads
        unread = {
            c.name: Numbers.of(tuple(map(ca.SX.sym, "cs"[: 1 + c.is_angular]))) for c in unknowns
        }
        if block.rod is not None:
            rod = lifted(block.rod, places, unread | generators, ca.SX(0, 1))
            generators[unknowns[0].name] = Numbers.of((rod[0],))
            return None
        assert block.formulas is not None  # noqa: S101 - the caller has looked
        limb, own = LimbFormulas(self.made, block, block.formulas), block.formulas
        symbols = ca.SX.sym(f"{block.name}_r", own.roots.numel())
        discriminants, first, second = (
            lifted(
                ca.substitute(limb.signed(e), own.roots, symbols),
                places,
                unread | generators,
                symbols,
            )
            for e in (own.discriminants, own.first, own.second)
        )
        for k, c in enumerate(unknowns):
            generators[c.name] = Numbers.of((first[k], second[k])[: 1 + c.is_angular])
        least = RESOLVED * self.real.epsilon * limb.usual_roots
        return symbols, discriminants, (least**2).tolist()

    def _read(
        self, x: ca.SX, roots: ca.SX, parts: Sequence[ca.SX], limits: Sequence[float]
    ) -> list[str]:
        real, name = self.real, self.capital
        outputs = gathered(parts, [x, roots], [])
        inputs = [(x, "x"), (roots, [f"r{k + 1}" for k in range(roots.numel())])]
        emitter, one = Emitter.of(real, inputs, *outputs), real.one
        tests = [
            emitter.root(k + 1, emitter.value(0, k), real.literal(rounded(limit)), one)
            for k, limit in enumerate(limits)
        ]
        limit = real.literal(off_motion(self.made.geometry, real))
        tests += [f"({real.call('fabs')}({text}) <= {limit})" for text in emitter.values(4)]
        begun, middle = emitter.take(), emitter.stored("w->at", 1)
        self.store_guards(emitter, 3, "left", of_divisors=True)
        middle += emitter.take()
        for k in range(parts[2].numel()):
            text = emitter.value(2, k)
            emitter.lines.append(f"w->sign[{k}] = ({text} < {real.zero}) ? -{one} : {one};")
        self.store_guards(emitter, 3, "left", of_divisors=False)
        last, near = emitter.take(), self.above("left", of_divisors=False)
        if near:
            last += [f"if (!({near})) {{", f"    status = {name}_SINGULAR;", "}"]
        below = _refused(self.above("left", of_divisors=True), last, f"{name}_SINGULAR")
        return [*begun, *_refused(" && ".join(tests), [*middle, *below], f"{name}_OUT_OF_RANGE")]

    def _told(self, told: ca.SX) -> ca.SX:
        """What tells each sign, with those before put in: sign times root."""
        roots, parts = self.found.formulas.roots, list[ca.SX]()
        for part in told.elements():
            for j, before in enumerate(parts):
                part = ca.substitute(part, roots[j], before)
            parts.append(part)
        return stacked(parts)


def _refused(condition: str, lines: Sequence[str], status: str) -> list[str]:
    """Statements under a condition, without which a status is set."""
    if not condition:
        return list(lines)
    return [
        f"if (!({condition})) {{",
        f"    status = {status};",
        "} else {",
        *("    " + line for line in lines),
        "}",
    ]
