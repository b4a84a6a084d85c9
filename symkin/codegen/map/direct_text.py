"""Write the C of both ends of a line that formulas follow: how a guess is read, by the limbs'
formulas, and how the answer is checked and written.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.codegen.closed_limb import BESIDE, READ_AGAIN, LimbFormulas, side_lines
from symkin.codegen.map.limb_platform import LimbBlock, LimbPlatform
from symkin.codegen.map.record import Source
from symkin.codegen.steps.composed import Composed, snapped
from symkin.codegen.steps.direct_formulas import DirectFormulas
from symkin.codegen.steps.formula_guards import RESOLVED
from symkin.codegen.steps.guard_text import GuardText
from symkin.codegen.steps.newton_kernel import rounded
from symkin.codegen.steps.newton_source import tolerance_of
from symkin.codegen.steps.pose_coordinates import POSE, off_motion, restricted
from symkin.codegen.text.angles import NotLiftedError, Numbers
from symkin.codegen.text.c import Emitter, refused
from symkin.codegen.text.gathered import gathered
from symkin.computed_once import cached_property
from symkin.elimination.closed_form import ClosedForm
from symkin.model.joint import Coordinate, places_of
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
class DirectText(Source):
    """The values of one platform's direct problem: `u` the given ones, `y` the unknowns, angles by
    cosine and sine, `half` those of half the pose's turn.
    """

    made: LimbPlatform
    found: DirectFormulas

    @cached_property
    def guards(self) -> GuardText:
        return GuardText(self.found.guards, self.real, measures=True)

    @cached_property
    def joint_places(self) -> dict[str, range]:
        """Places of each actuated joint's generators in the arrays `at` and `u`."""
        return _generators_of(self.made.actuated)

    @cached_property
    def unknown_places(self) -> dict[str, range]:
        """Places of each unknown's generators in `y`."""
        return _generators_of(self.unknowns)

    @property
    def unknowns(self) -> tuple[Coordinate, ...]:
        return self.made.direct.system.unknowns

    @property
    def u(self) -> ca.SX:
        return self.found.form.known

    @cached_property
    def y(self) -> ca.SX:
        return ca.SX.sym("y", sum(len(places) for places in self.unknown_places.values()))

    @cached_property
    def half(self) -> ca.SX:
        return ca.SX.sym("h", 2)

    def of_numbers(self, expression: ca.SX, known: ca.SX) -> ca.SX:
        """An expression of the formulas by the known numbers."""
        per = [
            c.unit(1.0 / self.found.unit)
            for c in self.made.actuated
            for _ in self.joint_places[c.name]
        ]
        return snapped(ca.substitute(expression, self.u, known * ca.DM(per)))

    def guards_of(self, squares: Sequence[ca.SX], at: Composed, divisors: ca.SX) -> ca.SX:
        """The guards by the squares of all roots, the numbers of coordinates and divisors."""
        form = self.found.form
        reaches = (at.written(reach.value) for reach in form.reaches)
        watched = stacked([*squares[: form.pose_choices], *reaches])
        return stacked(guard.of(watched, divisors) for guard in self.found.guards)

    def _over(
        self, expression: ca.SX, numbers: Mapping[str, Numbers], form: ClosedForm | None = None
    ) -> ca.SX:
        """An expression of the closure's variables, and of a form's roots, over the numbers of
        coordinates. Raises NotLiftedError.
        """
        whole = Composed(self.made.closure, {name: [own] for name, own in numbers.items()})
        return snapped(whole.written(expression, form))

    @cached_property
    def generators(self) -> dict[str, Numbers]:
        """Symbols of the joints and of the unknowns; of the pose's turn those of half of it."""
        found = {}
        for places, array in ((self.joint_places, self.u), (self.unknown_places, self.y)):
            for name, own in places.items():
                found[name] = Numbers.of(tuple(array[i] for i in own))
        return found

    def store_guards(self, emitter: Emitter, output: int, array: str, *, of_divisors: bool) -> None:
        """Add statements of guards: those of divisors, by which formulas divide, or those of
        discriminants.
        """
        for j, guard in enumerate(self.found.guards):
            if guard.is_divisor == of_divisors:
                emitter.lines.append(f"w->{array}[{j}] = {emitter.value(output, j)};")

    def above(self, array: str, *, of_divisors: bool) -> str:
        """C condition: these guards are more than rounding, where it is least: the line asks again
        by the part of the slides' ranges that holds it.
        """
        tests = [
            f"(w->{array}[{j}] > {self.guards.roundings(guard)[0]})"
            for j, guard in enumerate(self.found.guards)
            if guard.is_divisor == of_divisors
        ]
        return " && ".join(tests)

    # --- the guess --------------------------------------------------------------------------------

    @property
    def guess_lines(self) -> list[str]:
        """Statements that read a guess: joints by the limbs, signs and guards of the direct
        problem.
        """
        made, form = self.made, self.found.form
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
        at = ca.vertcat(*(part for c in made.actuated for part in generators[c.name].parts))
        numbers = {name: [self._over_unit(own)] for name, own in generators.items()}
        there = Composed(form.whole.closure, numbers)
        told = self._told(stacked(there.written(own.told, own) for own in form.whole.forms))
        guards = self.guards_of((told**2).elements(), there, form.divisors)
        told, guards = (self.of_numbers(e, at) for e in (told, guards))
        outputs = [stacked(discriminants), at, told, guards, stacked(taken.off)]
        return self._read(x, stacked(roots), outputs, limits)

    def _over_unit(self, numbers: Numbers) -> Numbers:
        """The numbers of a coordinate as the formulas read them."""
        if numbers.value is None:
            return numbers
        return Numbers.of((numbers.value * (1.0 / self.found.unit),))

    def _joints(
        self, block: LimbBlock, generators: dict[str, Numbers]
    ) -> tuple[ca.SX, ca.SX, list[float]] | None:
        """Add the generators of a limb's joints; its roots, what stands under them, and below which
        that is nothing; None of a rod.
        """
        unknowns = block.system.unknowns
        # symbols for unknowns that no formula reads
        unread = {
            c.name: Numbers.of(tuple(map(ca.SX.sym, "cs"[: 1 + c.is_angular]))) for c in unknowns
        }
        if block.rod is not None:
            generators[unknowns[0].name] = Numbers.of((self._over(block.rod, unread | generators),))
            return None
        assert block.formulas is not None  # noqa: S101 - the caller has looked
        limb, own = LimbFormulas(self.made, block, block.formulas), block.formulas
        discriminants, first, second = (
            self._over(limb.signed(e), unread | generators, own)
            for e in (own.discriminants, own.first, own.second)
        )
        for k, c in enumerate(unknowns):
            generators[c.name] = Numbers.of((first[k], second[k])[: 1 + c.is_angular])
        least = RESOLVED * self.real.epsilon * limb.usual_roots
        return own.roots, discriminants, (least**2).tolist()

    def _read(
        self, x: ca.SX, roots: ca.SX, parts: Sequence[ca.SX], limits: Sequence[float]
    ) -> list[str]:
        real = self.real
        outputs = gathered(parts, [x, roots], [])
        inputs = [(x, "x"), (roots, [f"r{k + 1}" for k in range(roots.numel())])]
        emitter = Emitter.of(real, inputs, *outputs)
        tests = [
            emitter.root(k + 1, emitter.value(0, k), str(rounded(limit)), "1.0")
            for k, limit in enumerate(limits)
        ]
        limit = off_motion(self.made.geometry, real)
        tests += [f"(fabs({text}) <= {limit})" for text in emitter.values(4)]
        begun, middle = emitter.take(), emitter.stored("w->at", 1)
        self.store_guards(emitter, 3, "left", of_divisors=True)
        middle += emitter.take()
        for k in range(parts[2].numel()):
            text = emitter.value(2, k)
            emitter.lines.append(f"w->sign[{k}] = ({text} < 0.0) ? -1.0 : 1.0;")
        self.store_guards(emitter, 3, "left", of_divisors=False)
        last, near = emitter.take(), self.above("left", of_divisors=False)
        last += refused(near, "SINGULAR")
        below = refused(self.above("left", of_divisors=True), "SINGULAR", last)
        return [*begun, *refused(" && ".join(tests), "OUT_OF_RANGE", [*middle, *below])]

    def _told(self, told: ca.SX) -> ca.SX:
        """What tells each sign, with those before put in: sign times root."""
        roots, parts = self.found.form.roots, list[ca.SX]()
        for part in told.elements():
            for j, before in enumerate(parts):
                part = ca.substitute(part, roots[j], before)
            parts.append(part)
        return stacked(parts)

    # --- the answer -------------------------------------------------------------------------------

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
        made, system = self.made, self.made.direct.system
        half = Numbers.of((self.half[0], self.half[1]), is_half=True)
        generators = self.generators | {c.name: half for c in self._turns}
        try:
            rows = self._over(system.rows, generators)
        except NotLiftedError:
            rows = self._over(system.errors, generators)  # these hold whole angles only
        sides = (self._over(limb.formulas.sides(limb.signs), generators) for limb in self._limbs)
        return self._distinct(rows), stacked(sides), self._over(made.geometry.pose, generators)

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
    def answer_lines(self) -> dict[str, list[str]]:
        """Statements of the residual, the sides, what is firm, and the pose."""
        real, symbols = self.real, [self.u, self.y, self.half]
        outputs = gathered(list(self._answer), symbols, self.found.form.turns)
        names = zip(symbols, ("w->u", "w->y", "h"), strict=True)
        emitter = Emitter.of(real, list(names), *outputs)
        squares = " + ".join(f"{t} * {t}" for t in emitter.values(0))
        emitter.lines.append(f"*residual = sqrt({squares});")
        residual, tests, k = emitter.take(), list[str](), 0
        for limb in self._limbs:
            size = limb.block.system.characteristic_length
            near = READ_AGAIN * BESIDE * np.sqrt(tolerance_of(real, size) / size)
            for root, what in zip(limb.usual_roots, limb.formulas.names, strict=True):
                bounds = (0.0, float(near * root))
                tests += side_lines(emitter.value(1, k), what, bounds)
                k += 1
        sides = [*emitter.take(), *tests]
        parts = {"residual": residual, "side": sides, "firm": self._firm_lines}
        return {f"{part}_lines": lines for part, lines in parts.items()} | {
            "pose_lines": emitter.stored(POSE, 2)
        }

    @property
    def _firm_lines(self) -> list[str]:
        """Statements on what is near a fold: there the pose's error is large beside the
        distance.
        """
        found, lines = self.found, list[str]()
        tests = [f"(w->share > {_SMALL_SHARE})"] * bool(found.usual_roots.size)
        for j, guard in enumerate(found.guards):
            firm = self.guards.by_reach(f"firm{j}", self.guards.roundings(guard, _FIRM), lines)
            tests.append(f"(w->guard[{j}] > {firm})")
        return [*lines, f"bool firm = {' && '.join(tests) or 'true'};"]


def _generators_of(coordinates: Sequence[Coordinate]) -> dict[str, range]:
    """Places of the generators of coordinates, one after the other."""
    return places_of(coordinates, [2 if c.is_angular else 1 for c in coordinates])
