"""Write the C of a direct problem that formulas solve: guess, formulas, the check of the line, answer.

No angle is formed where cosine and sine are known: the guess's joints, its turn and the answer's. Angles of the line between two
configurations are needed where it has to be cut alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.codegen.c_emitter import Emitter, Real, indent, indexed
from symkin.codegen.c_templates import fill
from symkin.codegen.closed_limb import RESOLVED, LimbFormulas
from symkin.codegen.closed_source import arctangent
from symkin.codegen.direct_formulas import DirectFormulas
from symkin.codegen.gathered import gathered
from symkin.codegen.lifted import Generators, NotLiftedError, lifted
from symkin.codegen.limb_platform import LimbPlatform
from symkin.codegen.newton_kernel import rounded
from symkin.codegen.newton_source import tuning_of
from symkin.codegen.pose_coordinates import off_motion, restricted
from symkin.codegen.turns import cosine_and_sine
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.numeric.system import System
from symkin.text import c_comment

_NOISE = 64.0
"""Roundings of the sum of a guard's amplitudes by which its value may be off."""
_LEAST_PART = 2.0**-12
"""Shortest part of a line."""
_WIDE = 1.5 * np.pi
"""Range of a limited angle (rad) from which the way between two of its values may be longer than half a turn and ends within a right
angle all the same."""
_ARC = 0.117
"""An angle up to a right one squared is its chord squared, c, and less than this times c^2: (pi^2 / 8 - 1) / 2."""
_ALIKE = 0.01
"""Relative difference of weights that are taken as equal: as the largest of them."""


@dataclass(frozen=True, eq=False)
class ClosedDirectSource:
    """The direct problem of one platform; `common` are the values of the names that templates of limbs need."""

    made: LimbPlatform
    found: DirectFormulas
    common: Mapping[str, object]

    @property
    def real(self) -> Real:
        return self.made.real

    # --- names of values -------------------------------------------------------------------------------------------------

    @cached_property
    def _joint_places(self) -> dict[str, list[int]]:
        """Places of each actuated joint's generators in the arrays `at` and `u`."""
        found, place = {}, 0
        for c in self.made.actuated:
            count = 2 if c.is_angular else 1
            found[c.name] = list(range(place, place + count))
            place += count
        return found

    @cached_property
    def _unknown_places(self) -> dict[str, list[int]]:
        """Places of each unknown's generators in `y`."""
        found, place = {}, 0
        for c in self._unknowns:
            count = 2 if c.is_angular else 1
            found[c.name] = list(range(place, place + count))
            place += count
        return found

    @property
    def _unknowns(self) -> tuple[Coordinate, ...]:
        return self.found.formulas.system.unknowns

    @cached_property
    def _count(self) -> int:
        return sum(len(places) for places in self._joint_places.values())

    @cached_property
    def _u(self) -> ca.SX:
        return ca.SX.sym("u", self._count)

    @cached_property
    def _y(self) -> ca.SX:
        return ca.SX.sym("y", sum(len(places) for places in self._unknown_places.values()))

    @cached_property
    def _half(self) -> ca.SX:
        return ca.SX.sym("h", 2)

    def _places(self, system: System) -> list[tuple[ca.SX, str]]:
        """Symbols of a system's coordinates with their names."""
        whole = system is self.found.formulas.system
        known = self.made.direct.known_coordinates if whole else self.made.inverse.known_coordinates
        parts = ((system.unknowns, system.unknown), (known, system.known))
        return [(symbols[k], c.name) for coordinates, symbols in parts for k, c in enumerate(coordinates)]

    # --- the guess -------------------------------------------------------------------------------------------------------

    @cached_property
    def _guess_lines(self) -> list[str]:
        """Statements that read a guess: joints by the limbs, signs and guards of the direct problem."""
        made, formulas, real = self.made, self.found.formulas, self.real
        x = ca.SX.sym("x", 7)
        taken = restricted(made.geometry, x)
        generators = self._pose_generators(taken.lengths, taken.half_turn)
        roots: list[ca.SX] = []
        discriminants: list[ca.SX] = []
        limits: list[float] = []
        for block in made.blocks:
            places = self._places(block.system)
            if block.rod is not None:
                rod = lifted(block.rod, places, self._all(generators, block.system.unknowns), ca.SX(0, 1))
                generators[block.system.unknowns[0].name] = Generators((rod[0],))
                continue
            assert block.formulas is not None  # noqa: S101 - the caller has looked
            limb, own = LimbFormulas(made, block, block.formulas), block.formulas
            symbols = ca.SX.sym(f"{block.name}_r", int(own.roots.shape[0]))
            with_roots = [ca.substitute(limb.signed(e), own.roots, symbols) for e in (own.discriminants, own.first, own.second)]
            found = [lifted(e, places, self._all(generators, block.system.unknowns), symbols) for e in with_roots]
            for k in range(int(symbols.shape[0])):
                roots.append(symbols[k])
                discriminants.append(found[0][k])
                limits.append(float((RESOLVED * real.epsilon * limb.usual_roots[k]) ** 2))
            for k, c in enumerate(block.system.unknowns):
                generators[c.name] = Generators((found[1][k], found[2][k]) if c.is_angular else (found[1][k],))
        places = self._places(formulas.system)
        told = self._told(lifted(self._signed(formulas.told), places, generators, formulas.roots))
        divisors = lifted(formulas.divisors, places, generators, formulas.roots)
        reaches = ca.vertcat(ca.SX(0, 1), *(reach.of_configuration for reach in self.found.whole.reaches))
        reaches = lifted(reaches, places, generators, formulas.roots)
        guards = ca.vertcat(*(guard.of(told**2, reaches, divisors) for guard in self.found.guards))
        at = ca.vertcat(*(part for c in made.actuated for part in generators[c.name].parts))
        off = ca.vertcat(ca.SX(0, 1), *taken.off)
        return self._read(
            x, ca.vertcat(ca.SX(0, 1), *roots), [ca.vertcat(ca.SX(0, 1), *discriminants), at, told, guards, off], limits
        )

    def _read(self, x: ca.SX, roots: ca.SX, parts: Sequence[ca.SX], limits: Sequence[float]) -> list[str]:
        real, name = self.real, self.made.name.upper()
        outputs = gathered(parts, [x, roots], [])
        function = ca.Function("guess", [x, roots], outputs, {"cse": True})
        count = int(roots.shape[0])
        emitter = Emitter(function, [indexed("x", 7), [f"r{k + 1}" for k in range(count)]], real)
        tests = []
        for k in range(count):
            text, limit = emitter.value(0, k), real.literal(rounded(limits[k]))
            emitter.lines.append(f"const {real.type} d{k + 1} = {text};")
            emitter.lines.append(
                f"const {real.type} r{k + 1} = (d{k + 1} > {limit}) ? {real.call('sqrt')}(d{k + 1}) : {real.literal(1.0)};"
            )
            tests.append(f"(d{k + 1} > {limit})")
        limit = real.literal(off_motion(self.made.geometry, real))
        tests += [f"({real.call('fabs')}({emitter.value(4, i)}) <= {limit})" for i in range(int(parts[4].shape[0]))]
        begun, lines = len(emitter.lines), emitter.lines
        lines += [f"w->at[{i}] = {emitter.value(1, i)};" for i in range(int(parts[1].shape[0]))]
        self._store_guards(emitter, 3, "left", of_divisors=True)
        middle, zero, one = len(lines), real.literal(0.0), real.literal(1.0)
        for k in range(int(parts[2].shape[0])):
            lines.append(f"w->sign[{k}] = ({emitter.value(2, k)} < {zero}) ? -{one} : {one};")
        self._store_guards(emitter, 3, "left", of_divisors=False)
        near = self._above("left", of_divisors=False)
        last = [*lines[middle:], *([f"if (!({near})) {{", f"    status = {name}_SINGULAR;", "}"] if near else [])]
        rest = [*lines[begun:middle], *_refused(self._above("left", of_divisors=True), last, f"{name}_SINGULAR")]
        return [*lines[:begun], *_refused(" && ".join(tests), rest, f"{name}_OUT_OF_RANGE")]

    def _store_guards(self, emitter: Emitter, output: int, array: str, *, of_divisors: bool) -> None:
        """Add statements of guards: those of divisors, by which formulas divide, or those of discriminants."""
        for j, guard in enumerate(self.found.guards):
            if guard.is_divisor == of_divisors:
                emitter.lines.append(f"w->{array}[{j}] = {emitter.value(output, j)};")

    def _above(self, array: str, *, of_divisors: bool) -> str:
        """C condition: these guards are more than rounding."""
        tests = [f"(w->{array}[{j}] > {self._least[j]})" for j, g in enumerate(self.found.guards) if g.is_divisor == of_divisors]
        return " && ".join(tests)

    def _pose_generators(self, lengths: Sequence[ca.SX], half: tuple[ca.SX, ca.SX] | None) -> dict[str, Generators]:
        pose, found, left = self.made.closure.role("pose"), {}, list(lengths)
        for c in pose:
            if c.is_angular:
                assert half is not None  # noqa: S101 - a pose with a turn has half of it
                found[c.name] = Generators(half, is_half=True)
            else:
                found[c.name] = Generators((left.pop(0),))
        return found

    @staticmethod
    def _all(generators: Mapping[str, Generators], unknowns: Sequence[Coordinate]) -> dict[str, Generators]:
        """Generators, with symbols for unknowns that no formula reads."""
        own = {c.name: Generators((ca.SX.sym("c"), ca.SX.sym("s")) if c.is_angular else (ca.SX.sym("v"),)) for c in unknowns}
        return own | dict(generators)

    def _signed(self, expression: ca.SX) -> ca.SX:
        """An expression in which roots have their signs."""
        return ca.substitute(expression, self.found.formulas.signs, ca.SX.ones(*self.found.formulas.signs.shape))

    def _told(self, told: ca.SX) -> ca.SX:
        """What tells each sign, with those before put in: sign times root."""
        roots, parts = self.found.formulas.roots, list[ca.SX]()
        for k in range(int(told.shape[0])):
            part = told[k]
            for j, before in enumerate(parts):
                part = ca.substitute(part, roots[j], before)
            parts.append(part)
        return ca.vertcat(ca.SX(0, 1), *parts)

    # --- formulas --------------------------------------------------------------------------------------------------------

    @cached_property
    def _generators(self) -> dict[str, Generators]:
        """Symbols of the joints and of the unknowns; of the pose's turn those of half of it."""
        found = {}
        for places, array in ((self._joint_places, self._u), (self._unknown_places, self._y)):
            for name, own in places.items():
                found[name] = Generators(tuple(array[i] for i in own))
        return found

    @property
    def _turns(self) -> list[tuple[ca.SX, ca.SX]]:
        """The joints' symbols that are cosine and sine of one angle."""
        return [(self._u[p[0]], self._u[p[1]]) for p in self._joint_places.values() if len(p) == 2]

    @property
    def _formula_lines(self) -> list[str]:
        """Statements of roots, unknowns and guards."""
        formulas, real = self.found.formulas, self.real
        places = self._places(formulas.system)
        parts = [self._signed(e) for e in (formulas.discriminants, formulas.first, formulas.second, formulas.divisors)]
        discriminants, first, second, divisors = (lifted(e, places, self._generators, formulas.roots) for e in parts)
        unknowns = [
            part for k, c in enumerate(self._unknowns) for part in ((first[k], second[k]) if c.is_angular else (first[k],))
        ]
        reaches = ca.vertcat(ca.SX(0, 1), *(self._signed(reach.of_known) for reach in self.found.whole.reaches))
        reaches = lifted(reaches, places, self._generators, formulas.roots)
        guards = [guard.of(discriminants, reaches, divisors) for guard in self.found.guards]
        outputs = [discriminants, ca.vertcat(*unknowns), ca.vertcat(*guards)]
        outputs = gathered(outputs, [self._u, formulas.roots], self._turns)
        function = ca.Function("formulas", [self._u, formulas.roots], outputs, {"cse": True})
        count = int(formulas.roots.shape[0])
        emitter = Emitter(function, [indexed("w->u", self._count), [f"r{k + 1}" for k in range(count)]], real)
        self._store_guards(emitter, 2, "guard", of_divisors=True)
        lines, zero, begun = emitter.lines, real.literal(0.0), len(emitter.lines)
        for k in range(count):
            text = emitter.value(0, k)
            lines.append(
                f"const {real.type} d{k + 1} = {text}; /* above 0 where {c_comment(formulas.names[k])} has two values */"
            )
            lines.append(
                f"const {real.type} r{k + 1} = w->sign[{k}] * {real.call('sqrt')}((d{k + 1} > {zero}) ? d{k + 1} : {zero});"
            )
        self._store_guards(emitter, 2, "guard", of_divisors=False)
        for i in range(len(unknowns)):
            if i in self._needed:
                lines.append(f"w->y[{i}] = {emitter.value(1, i)};")
        one = real.literal(1.0)
        shares = [
            f"{real.call('fabs')}(r{k + 1}) * {real.literal(1.0 / float(root))}" for k, root in enumerate(self.found.usual_roots)
        ]
        lines.append(f"w->share = {shares[0] if shares else one};")
        for k, share in enumerate(shares[1:], start=2):
            lines.append(f"const {real.type} share{k} = {share};")
            lines.append(f"w->share = (share{k} < w->share) ? share{k} : w->share;")
        none = [f"w->guard[{j}] = {zero};" for j, guard in enumerate(self.found.guards) if not guard.is_divisor]
        condition = self._above("guard", of_divisors=True)
        if not condition:
            return lines
        return [*lines[:begun], f"if ({condition}) {{", *("    " + line for line in lines[begun:]), "} else {",
                "    /* what formulas divide by vanishes: no guard is above zero */", *("    " + line for line in none),
                f"    w->share = {zero};", "}"]  # fmt: skip

    @property
    def _set_lines(self) -> list[str]:
        lines, call = [], f"{self.made.name}_cosine_and_sine"
        for i, c in enumerate(self.made.actuated):
            place = self._joint_places[c.name][0]
            if not c.is_angular:
                lines.append(f"w->u[{place}] = joints[{i}];")
            elif self.real.name == "float":
                lines.append(f"{call}(joints[{i}], &w->u[{place}]);")
            else:
                lines += [f"w->u[{place}] = cos(joints[{i}]);", f"w->u[{place + 1}] = sin(joints[{i}]);"]
        return lines

    @property
    def _change_lines(self) -> list[str]:
        lines, real = [], self.real
        for i, c in enumerate(self.made.actuated):
            places = self._joint_places[c.name]
            for n in places:
                lines.append(f"const {real.type} move{n} = w.u[{n}] - w.at[{n}];")
            square = " + ".join(f"move{n} * move{n}" for n in places)
            if c.is_angular:
                lines += [f"const {real.type} chord{i} = {square};", f"kept = kept && (chord{i} <= {real.literal(2.0)});",
                          f"change[{i}] = chord{i} + {real.literal(_ARC)} * chord{i} * chord{i};"]  # fmt: skip
            else:
                lines += [f"change[{i}] = {square};"]
        return lines

    @property
    def _span_lines(self) -> list[str]:
        """Statements that choose the part of the slides' ranges that holds the line, and refuse what is outside."""
        real, largest = self.real, []
        for i, (c, span) in enumerate(zip(self.made.actuated, self.found.spans, strict=True)):
            if not span.angular:
                place, per = self._joint_places[c.name][0], real.literal(1.0 / span.half)
                for value in (f"w.at[{place}]", f"joints[{i}]"):
                    largest.append(f"{per} * {real.call('fabs')}({value} - {real.literal(span.middle)})")
        if not largest:
            return []
        p = self.made.name.upper()
        lines = [f"if (status == {p}_OK) {{", "    /* which part of the slides' ranges holds both ends of the line */",
                 f"    {real.type} excursion = {largest[0]};"]  # fmt: skip
        for text in largest[1:]:
            lines += [
                "    {",
                f"        const {real.type} other = {text};",
                "        excursion = (other > excursion) ? other : excursion;",
                "    }",
            ]
        for reach in self.found.parts[:-1]:
            lines += [f"    w.reach += (excursion > {real.literal(reach)}) ? 1U : 0U;"]
        return [*lines, f"    if (!(excursion <= {real.literal(1.0)})) {{", f"        status = {p}_WRONG_BRANCH;", "    }", "}"]

    @property
    def _at_lines(self) -> list[str]:
        """Statements of the joints' values at the guess and the given ones that are meant."""
        made, p, lines = self.made, self.made.name, [f"{self.real.type} at_end[{len(self.made.actuated)}];"]
        angle = f"{p}_angle" if self.real.name == "float" else "atan2"
        for i, c in enumerate(made.actuated):
            places = self._joint_places[c.name]
            if c.is_angular:
                lines.append(f"at[{i}] = {angle}(w->at[{places[1]}], w->at[{places[0]}]);")
            else:
                lines.append(f"at[{i}] = w->at[{places[0]}];")
        if any(made.limited_angles):
            lines.append(f"{p}_turn_into_limits(at, joints);")
        return [*lines, f"{p}_unwrap_joints(at, joints, given);"]

    # --- the answer ------------------------------------------------------------------------------------------------------

    @cached_property
    def _answer(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Rows, sides of the limbs' choices and numbers of the pose, over u, y and the half turn."""
        made, formulas = self.made, self.found.formulas
        generators = dict(self._generators)
        for c in made.closure.role("pose"):
            if c.is_angular:
                generators[c.name] = Generators((self._half[0], self._half[1]), is_half=True)
        none = ca.SX(0, 1)
        places = self._places(formulas.system)
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
            sides.append(lifted(block.formulas.sides(limb.signs), self._places(block.system), generators, none))
        pose_symbols = [(made.closure.variables[made.closure.slices[c.name]], c.name) for c in made.closure.role("pose")]
        pose = made.geometry.of(ca.vertcat(made.closure.pose.position, made.closure.pose.quaternion))
        return self._distinct(rows), ca.vertcat(*sides), lifted(pose, pose_symbols, generators, none)

    def _distinct(self, rows: ca.SX) -> ca.SX:
        """Rows without those that equal another one."""
        symbols = ca.vertcat(self._u, self._y, self._half)
        function = ca.Function("rows", [symbols], [rows])
        rng = np.random.default_rng(2)
        values = np.array([np.asarray(function(rng.normal(size=int(symbols.shape[0])))).ravel() for _ in range(3)])
        kept: list[int] = []
        for k in range(values.shape[1]):
            if not any(np.allclose(values[:, k], s * values[:, j], rtol=1e-9, atol=1e-9) for j in kept for s in (1, -1)):
                kept.append(k)
        return ca.vertcat(ca.SX(0, 1), *(rows[k] for k in kept))

    @cached_property
    def _needed(self) -> set[int]:
        """Places of `y` that the answer reads."""
        function = ca.Function("answer", [self._y, self._u, self._half], [ca.vertcat(*self._answer)])
        turns = {i for c in self.made.closure.role("pose") if c.is_angular for i in self._unknown_places[c.name]}
        return turns | {
            i for i, reads in enumerate(ca.which_depends(function(self._y, self._u, self._half), self._y, 1, False)) if reads
        }

    @property
    def _answer_lines(self) -> dict[str, str]:
        real, name = self.real, self.made.name.upper()
        rows, sides, pose = self._answer
        symbols = [self._u, self._y, self._half]
        outputs = gathered([rows, sides, pose], symbols, self._turns)
        function = ca.Function("answer", symbols, outputs, {"cse": True})
        names = [indexed("w->u", self._count), indexed("w->y", int(self._y.shape[0])), indexed("h", 2)]
        emitter = Emitter(function, names, real)
        texts = [emitter.value(0, k) for k in range(int(rows.shape[0]))]
        squares = " + ".join(f"{t} * {t}" for t in texts)
        emitter.lines.append(f"*residual = {real.call('sqrt')}({squares});")
        residual = list(emitter.lines)
        tests, k = [], 0
        for block in self.made.blocks:
            if block.formulas is None:
                continue
            limb = LimbFormulas(self.made, block, block.formulas)
            for root, what in zip(limb.usual_roots, block.formulas.names, strict=True):
                near = -rounded(float(4.0 * np.sqrt(self._tolerance / block.system.characteristic_length) * root))
                tests += [f"if (!({emitter.value(1, k)} >= {real.literal(near)})) {{ /* {c_comment(what)} */",
                          f"    status = {name}_WRONG_BRANCH;", "}"]  # fmt: skip
                k += 1
        side = [*emitter.lines[len(residual) :], *tests]
        begin = len(emitter.lines)
        targets = indexed("pose->position", 3) + indexed("pose->quaternion", 4)
        values = [emitter.value(2, i) for i in range(7)]
        stores = [*emitter.lines[begin:], *(f"{target} = {text};" for target, text in zip(targets, values, strict=True))]
        return {"residual_lines": indent(residual), "side_lines": indent(side), "pose_lines": indent(stores, 2)}

    @property
    def _half_lines(self) -> list[str]:
        """Statements of cosine and sine of half the pose's turn, by the larger one."""
        real = self.real
        for c in self.made.closure.role("pose"):
            if c.is_angular:
                cosine, sine = (f"w->y[{i}]" for i in self._unknown_places[c.name])
                half, zero, sqrt = real.literal(0.5), real.literal(0.0), real.call("sqrt")
                return [
                    f"{real.type} h[2];", "/* half the turn, by the larger of its cosine and sine */",
                    f"const {real.type} larger = {sqrt}({half} + {half} * {real.call('fabs')}({cosine}));",
                    f"const {real.type} lesser = {half} * {sine} / larger;",
                    f"if ({cosine} >= {zero}) {{", "    h[0] = larger;", "    h[1] = lesser;", "} else {",
                    f"    h[0] = {real.call('fabs')}(lesser);", f"    h[1] = (lesser < {zero}) ? -larger : larger;", "}",
                ]  # fmt: skip
        return []

    # --- text ------------------------------------------------------------------------------------------------------------

    @property
    def _tolerance(self) -> float:
        return tuning_of(self.made.direct_kernel, self.real, 1.0).tolerance

    @cached_property
    def _least(self) -> list[str]:
        """Values of the guards that are nothing but rounding."""
        return [self.real.literal(rounded(_NOISE * self.real.epsilon * guard.size)) for guard in self.found.guards]

    @property
    def text(self) -> str:
        """All functions of the direct problem."""
        real, made, literal = self.real, self.made, self.real.literal
        angular = any(c.is_angular for c in made.actuated)
        polynomial = real.name == "float" and angular
        angle = fill("closed_angle.c", dict(self.common) | arctangent(real)) if polynomial else ""
        turn = cosine_and_sine(self.real, self.common) if polynomial else ""
        wide = [c.limits is not None and c.is_angular and c.limits[1] - c.limits[0] > _WIDE for c in made.actuated]
        values = dict(self.common) | {
            "nu": self._count, "nk": max(1, len(self.found.formulas.names)), "ng": len(self.found.guards), "ny": int(self._y.shape[0]),
            "guess_lines": indent(self._guess_lines, 2), "formula_lines": indent(self._formula_lines), "set_lines": indent(self._set_lines),
            "keep_lines": indent(self._keep_lines), "reach_member": self._reach_member, "no_reach": "    w.reach = 0U;" if self._reach_member else "",
            "p_angle": angle, "near_one": literal(0.9999), "hundred": literal(80.0), "nine_tenths": literal(0.9), "tenth": literal(0.1), "least_part": literal(_LEAST_PART), "first_part": literal(0.5 if not any(wide) else 1.0), "at_lines": indent(self._at_lines),
            "span_lines": indent(self._span_lines), "change_lines": indent(self._change_lines, 3), "near": "false" if any(wide) else "true",
            "half_lines": indent(self._half_lines), "rounding": literal(rounded(64 * real.epsilon * made.closure.characteristic_length)),
            **self._answer_lines,
        }  # fmt: skip
        whole = fill("closed_direct.c", values)
        answer = fill("closed_direct_answer.c", values)
        begin = whole.index("/* The answer at joint values")
        return turn + whole[:begin] + answer + whole[begin:]

    @property
    def _reach_member(self) -> str:
        return "    unsigned int reach;" if len(self.found.parts) > 1 else ""

    @property
    def _keep_lines(self) -> list[str]:
        """Statements that compare each guard with how far it may bend on the way."""
        real, zero = self.real, self.real.literal(0.0)
        roots = {guard.root for guard in self.found.guards}
        lines, sums = ["bool kept = true;"], dict[str, str]()
        for j, guard in enumerate(self.found.guards):
            lines += [f"/* {c_comment(guard.name)} */", f"const {real.type} a{j} = w->left[{j}] - {self._least[j]};",
                      f"const {real.type} b{j} = w->guard[{j}] - {self._least[j]};",
                      f"const {real.type} lesser{j} = (a{j} < b{j}) ? a{j} : b{j};"]  # fmt: skip
            bend = self._weighted(f"plain{j}", [weights.plain for weights in guard.weights], lines, sums)
            if guard.root is not None:
                # the root that it holds is at least this on the way
                lines.append(f"const {real.type} per{j} = {real.literal(1.0)} / {real.call('sqrt')}(under{guard.root});")
                once = self._weighted(f"once{j}", [weights.by_root for weights in guard.weights], lines, sums)
                cube = self._weighted(f"thrice{j}", [weights.by_cube for weights in guard.weights], lines, sums)
                bend = f"{bend} + per{j} * ({once} + per{j} * per{j} * ({cube}))"
            lines.append(f"const {real.type} bend{j} = {bend};")
            lines += [f"const {real.type} most{j} = a{j} + b{j} + lesser{j} + lesser{j};", f"if (!((lesser{j} > {zero}) && (bend{j} < most{j}))) {{",
                      f"    w->over = (kept && (lesser{j} > {zero})) ? (bend{j} / most{j}) : w->over;", "    kept = false;", "}"]  # fmt: skip
            if j in roots:
                lines.append(f"const {real.type} least{j} = lesser{j} - {real.literal(0.25)} * bend{j};")
                lines.append(f"kept = kept && (least{j} > {zero});")
                lines.append(f"const {real.type} under{j} = (least{j} > {zero}) ? least{j} : {real.literal(1.0)};")
        return lines

    def _weighted(self, name: str, weights: Sequence[np.ndarray], lines: list[str], sums: dict[str, str]) -> str:
        """C text of a sum of squared changes by weights of each reach; joints of about one weight are added first. `lines` get tables and
        sums."""
        real, parts = self.real, list[str]()
        table = np.array([[rounded(float(1.0001 * v)) for v in part] for part in weights])
        left = [i for i in range(table.shape[1]) if np.any(table[:, i] > 0.0)]
        while left:
            alike = [i for i in left if np.all(np.abs(table[:, i] - table[:, left[0]]) <= _ALIKE * table[:, left[0]])]
            left = [i for i in left if i not in alike]
            column, added = np.max(table[:, alike], axis=1), " + ".join(f"change[{i}]" for i in alike)
            if len(alike) > 1:
                if added not in sums:
                    sums[added] = f"sum{len(sums)}"
                    lines.append(f"const {real.type} {sums[added]} = {added};")
                added = sums[added]
            if np.all(column == column[0]):
                parts.append(f"{real.literal(float(column[0]))} * {added}")
                continue
            texts, table_name = ", ".join(real.literal(float(v)) for v in column), f"{name}_{alike[0]}"
            lines.append(f"static const {real.type} {table_name}[{len(column)}] = {{ {texts} }};")
            parts.append(f"{table_name}[w->reach] * {added}")
        return " + ".join(parts) or real.literal(0.0)


def _refused(condition: str, lines: Sequence[str], status: str) -> list[str]:
    """Statements under a condition, without which a status is set."""
    if not condition:
        return list(lines)
    return [f"if (!({condition})) {{", f"    status = {status};", "} else {", *("    " + line for line in lines), "}"]
