"""Write the C that reads the guess of a direct problem in closed form: joints by the limbs, signs
and guards.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from symkin.codegen.closed_limb import LimbFormulas
from symkin.codegen.direct_values import DirectValues
from symkin.codegen.formula_guards import RESOLVED
from symkin.codegen.newton_kernel import rounded
from symkin.codegen.pose_coordinates import off_motion, restricted
from symkin.codegen.text.angles import Numbers, lifted
from symkin.codegen.text.c import Emitter
from symkin.codegen.text.gathered import gathered
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.spatial.backend import stacked


@dataclass(frozen=True, eq=False)
class GuessText:
    """How a guess of one platform is read."""

    values: DirectValues

    @cached_property
    def lines(self) -> list[str]:
        """Statements that read a guess: joints by the limbs, signs and guards of the direct
        problem.
        """
        made, formulas, real = self.values.made, self.values.found.formulas, self.values.real
        x = ca.SX.sym("x", 7)
        taken = restricted(made.geometry, x)
        generators = self._pose_generators(taken.lengths, taken.half_turn)
        roots: list[ca.SX] = []
        discriminants: list[ca.SX] = []
        limits: list[float] = []
        for block in made.blocks:
            places = self.values.places(block.system)
            if block.rod is not None:
                rod = lifted(
                    block.rod, places, self._all(generators, block.system.unknowns), ca.SX(0, 1)
                )
                generators[block.system.unknowns[0].name] = Numbers.of((rod[0],))
                continue
            assert block.formulas is not None  # noqa: S101 - the caller has looked
            limb, own = LimbFormulas(made, block, block.formulas), block.formulas
            symbols = ca.SX.sym(f"{block.name}_r", own.roots.numel())
            with_roots = [
                ca.substitute(limb.signed(e), own.roots, symbols)
                for e in (own.discriminants, own.first, own.second)
            ]
            found = [
                lifted(e, places, self._all(generators, block.system.unknowns), symbols)
                for e in with_roots
            ]
            for k in range(symbols.numel()):
                roots.append(symbols[k])
                discriminants.append(found[0][k])
                limits.append(float((RESOLVED * real.epsilon * limb.usual_roots[k]) ** 2))
            for k, c in enumerate(block.system.unknowns):
                generators[c.name] = Numbers.of(
                    (found[1][k], found[2][k]) if c.is_angular else (found[1][k],)
                )
        places = self.values.places(formulas.system)
        told = self._told(
            lifted(self.values.signed(formulas.told), places, generators, formulas.roots)
        )
        divisors = lifted(formulas.divisors, places, generators, formulas.roots)
        reaches = stacked(reach.of_configuration for reach in self.values.found.whole.reaches)
        reaches = lifted(reaches, places, generators, formulas.roots)
        guards = ca.vertcat(
            *(guard.of(told**2, reaches, divisors) for guard in self.values.found.guards)
        )
        at = ca.vertcat(*(part for c in made.actuated for part in generators[c.name].parts))
        off = stacked(taken.off)
        return self._read(
            x,
            stacked(roots),
            [stacked(discriminants), at, told, guards, off],
            limits,
        )

    def _read(
        self, x: ca.SX, roots: ca.SX, parts: Sequence[ca.SX], limits: Sequence[float]
    ) -> list[str]:
        real, name = self.values.real, self.values.made.name.upper()
        outputs = gathered(parts, [x, roots], [])
        count = roots.numel()
        inputs = [(x, "x"), (roots, [f"r{k + 1}" for k in range(count)])]
        emitter = Emitter.of(real, inputs, *outputs)
        tests = []
        for k in range(count):
            text, limit = emitter.value(0, k), real.literal(rounded(limits[k]))
            emitter.lines.append(f"const {real.type} d{k + 1} = {text};")
            emitter.lines.append(
                f"const {real.type} r{k + 1} = (d{k + 1} > {limit}) ? "
                f"{real.call('sqrt')}(d{k + 1}) : {real.literal(1.0)};"
            )
            tests.append(f"(d{k + 1} > {limit})")
        limit = real.literal(off_motion(self.values.made.geometry, real))
        tests += [
            f"({real.call('fabs')}({emitter.value(4, i)}) <= {limit})"
            for i in range(parts[4].numel())
        ]
        begun, lines = len(emitter.lines), emitter.lines
        lines += [f"w->at[{i}] = {emitter.value(1, i)};" for i in range(parts[1].numel())]
        self.values.store_guards(emitter, 3, "left", of_divisors=True)
        middle, zero, one = len(lines), real.literal(0.0), real.literal(1.0)
        for k in range(parts[2].numel()):
            lines.append(f"w->sign[{k}] = ({emitter.value(2, k)} < {zero}) ? -{one} : {one};")
        self.values.store_guards(emitter, 3, "left", of_divisors=False)
        near = self.values.above("left", of_divisors=False)
        last = [
            *lines[middle:],
            *([f"if (!({near})) {{", f"    status = {name}_SINGULAR;", "}"] if near else []),
        ]
        rest = [
            *lines[begun:middle],
            *_refused(self.values.above("left", of_divisors=True), last, f"{name}_SINGULAR"),
        ]
        return [*lines[:begun], *_refused(" && ".join(tests), rest, f"{name}_OUT_OF_RANGE")]

    def _pose_generators(
        self, lengths: Sequence[ca.SX], half: tuple[ca.SX, ca.SX] | None
    ) -> dict[str, Numbers]:
        pose, found, left = self.values.made.closure.role("pose"), {}, list(lengths)
        for c in pose:
            if c.is_angular:
                assert half is not None  # noqa: S101 - a pose with a turn has half of it
                found[c.name] = Numbers.of(half, is_half=True)
            else:
                found[c.name] = Numbers.of((left.pop(0),))
        return found

    @staticmethod
    def _all(
        generators: Mapping[str, Numbers], unknowns: Sequence[Coordinate]
    ) -> dict[str, Numbers]:
        """Generators, with symbols for unknowns that no formula reads."""
        own = {
            c.name: Numbers.of(
                (ca.SX.sym("c"), ca.SX.sym("s")) if c.is_angular else (ca.SX.sym("v"),)
            )
            for c in unknowns
        }
        return own | dict(generators)

    def _told(self, told: ca.SX) -> ca.SX:
        """What tells each sign, with those before put in: sign times root."""
        roots, parts = self.values.found.formulas.roots, list[ca.SX]()
        for k in range(told.numel()):
            part = told[k]
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
