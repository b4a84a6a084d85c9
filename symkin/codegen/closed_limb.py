"""Write the C of a limb that has a closed form: its joints and their rates by the pose, and which
branch a configuration is on.

Of each choice between two values the reference's is taken. A discriminant below zero means that no
configuration has the pose, as do rows that the formulas leave over and that do not close; where a
divisor vanishes the limb is singular.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.codegen.map.limb_platform import LimbBlock, LimbPlatform
from symkin.codegen.map.record import Source
from symkin.codegen.steps.formula_guards import RESOLVED
from symkin.codegen.steps.newton_kernel import rounded
from symkin.codegen.steps.passive_limits import texts_of
from symkin.codegen.text.angles import Numbers, by_numbers
from symkin.codegen.text.c import Emitter, indented_by_braces
from symkin.codegen.text.gathered import gathered
from symkin.codegen.text.templates import fill
from symkin.computed_once import cached_property
from symkin.elimination.closed_form import ClosedForm
from symkin.spatial.backend import stacked
from symkin.text import c_comment

BESIDE = 4.0
"""Square roots of an answer's error, as shares of a root's usual size, within which the pose does
not tell a limb's side.
"""
READ_AGAIN = 8.0
"""Multiple of BESIDE within which an answer is read again, for poses whose error is larger than
usual.
"""
_SINGULAR = 1e-3
"""Share of a root's usual size below which the limb is near a dead centre, where rates are without
bound.
"""


def actuated_places(block: LimbBlock) -> list[int]:
    """Places of the actuated joints among a limb's unknowns."""
    return [
        place.start
        for c, place in zip(block.system.unknowns, block.system.slices, strict=True)
        if c.role == "actuated"
    ]


@dataclass(frozen=True, eq=False)
class LimbFormulas(Source):
    """A limb's formulas with the reference's signs."""

    made: LimbPlatform
    block: LimbBlock
    formulas: ClosedForm

    @cached_property
    def signs(self) -> np.ndarray:
        return self.made.home_signs(self.formulas)

    @cached_property
    def usual_roots(self) -> np.ndarray:
        """How large roots are at sampled configurations."""
        discriminants = self.formulas.discriminants_at(self.made.sampled_poses, self.signs)
        return np.sqrt(np.median(np.abs(discriminants), axis=0))

    @cached_property
    def _usual_divisors(self) -> np.ndarray:
        """How large the divisors with guards of their own are at sampled configurations."""
        divisors = self.formulas.divisors_at(self.made.sampled_poses, self.signs)
        return np.median(np.abs(divisors[:, list(self.block.free_divisors)]), axis=0)

    @cached_property
    def _discriminants(self) -> ca.SX:
        return self.signed(self.formulas.discriminants)

    @cached_property
    def _values(self) -> ca.SX:
        home = self.made.inverse.select_values(self.made.home_values, self.block.system.unknowns)
        return self.signed(self.formulas.values_about(home))

    def signed(self, expression: ca.SX) -> ca.SX:
        return ca.substitute(expression, self.formulas.signs, ca.SX(ca.DM(self.signs)))

    @property
    def joints(self) -> list[str]:
        """Statements of the joints."""
        rows = self._rows if self.block.is_checked else ca.SX(0, 1)
        return self._lines(self._values, RESOLVED * self.real.epsilon, "x", "OUT_OF_RANGE", rows)

    @property
    def rates(self) -> list[str]:
        """Statements of the actuated joints' derivatives by the platform's twist, joint by joint.
        Of a root r of D: dr = dD / (2 r).
        """
        values, roots = self._values[actuated_places(self.block), 0], self.formulas.roots
        found, of_roots = self._by_twist(values), ca.SX(0, self.block.sides.shape[1])
        for k in range(roots.numel()):
            change = self._by_twist(self._discriminants[k])
            if k:
                change = change + ca.mtimes(
                    ca.jacobian(self._discriminants[k], roots[:k]), of_roots
                )
            of_roots = ca.vertcat(of_roots, change / (2 * roots[k]))
        if roots.numel():
            found = found + ca.mtimes(ca.jacobian(values, roots), of_roots)
        return self._lines(ca.vec(found.T), _SINGULAR, "rates", "SINGULAR", ca.SX(0, 1))

    def _by_twist(self, expression: ca.SX) -> ca.SX:
        return self.made.by_twist(self.block.system, expression)

    def _lines(
        self, results: ca.SX, least: float, array: str, refused: str, rows: ca.SX
    ) -> list[str]:
        """Statements of discriminants, their roots, the results and the status: refused where a
        root is below the `least` share of its usual size, SINGULAR where a divisor is,
        OUT_OF_RANGE where `rows` do not close.
        """
        real = self.real
        known, roots = self.formulas.system.known, self.formulas.roots
        free, count = self.block.free_divisors, roots.numel()
        divisors = self.signed(stacked(self.formulas.divisors[j] for j in free))
        inputs = [(known, "c"), (roots, [f"r{k + 1}" for k in range(count)])]
        outputs = gathered([self._discriminants, results, divisors, rows], [known, roots], [])
        emitter = Emitter.of(real, inputs, *outputs)
        zeros = [f"{array}[{i}] = 0.0;" for i in range(results.numel())]
        status = [f"name_status status = NAME_{refused};"]
        written, closings, tests = list(status if free else []), list[list[str]](), list[str]()
        for k in range(count + 1):
            # a divisor is asked before anything is divided by it
            conditions = [
                self._above(emitter.value(2, j), least * float(self._usual_divisors[j]))
                for j in range(len(free))
                if self._last_root(divisors[j]) == k
            ]
            if conditions:
                written += [*emitter.take(), f"if ({' && '.join(conditions)}) {{"]
                vanishes = ["/* what is divided by vanishes */", "status = NAME_SINGULAR;"]
                closings.append(["} else {", *vanishes, *zeros, "}"])
            if k < count:
                limit = rounded((least * self.usual_roots[k]) ** 2)
                about, square = self.formulas.names[k], emitter.value(0, k)
                tests.append(emitter.root(k + 1, square, str(limit), "1.0", about=about))
        written += emitter.take()
        if tests:
            # only where the roots are there: then nothing that is divided by vanishes with them
            whole = tests[0] if len(tests) == 1 else f"({' && '.join(tests)})"
            written += [*([] if free else status), f"if {whole} {{"]
            closings.append(["} else {", *zeros, "}"])
        written += emitter.stored(array, 1)
        checks, result = self._row_checks(emitter) if rows.numel() else ([], "NAME_OK")
        ending = [f"return {result};"]
        if closings:
            closed = (line for lines in reversed(closings) for line in lines)
            ending = [f"status = {result};", *closed, "return status;"]
        return indented_by_braces([*written, *checks, *ending])

    def _last_root(self, expression: ca.SX) -> int:
        """Number, from 1, of the last root that an expression reads; 0 for none."""
        roots = self.formulas.roots
        reads = (k + 1 for k in range(roots.numel()) if ca.depends_on(expression, roots[k]))
        return max(reads, default=0)

    def _above(self, text: str, least: float) -> str:
        return f"(fabs({text}) > {rounded(least)})"

    @property
    def _rows(self) -> ca.SX:
        """The limb's closing errors at the joints by their formulas: of an angle the cosine and
        sine that its formulas give, made a unit vector: a root takes the place of trigonometry.
        """
        system, numbers = self.block.system, []
        first, second = self.signed(self.formulas.first), self.signed(self.formulas.second)
        for k, coordinate in enumerate(system.unknowns):
            cosine, sine = first[k], second[k]
            per = 1 / ca.sqrt(cosine**2 + sine**2)
            numbers.append(
                Numbers(self._values[k], cosine * per, sine * per)
                if coordinate.is_angular
                else Numbers(self._values[k])
            )
        known = [Numbers(system.known[k]) for k in range(system.known.numel())]
        return by_numbers(system.errors, [(system.unknown, numbers), (system.known, known)])

    def _row_checks(self, emitter: Emitter) -> tuple[list[str], str]:
        """Statements of the limb's rows, and the status that they leave: a pose off what the
        mechanism can take has no answer.
        """
        texts = emitter.values(3)
        closes = " && ".join(f"(fabs({text}) <= within)" for text in texts)
        return [
            "/* the rows that the formulas leave over */",
            *emitter.take(),
        ], f"({closes}) ? NAME_OK : NAME_OUT_OF_RANGE"


def side_lines(side: str, what: str, bounds: tuple[float, float]) -> list[str]:
    """Statements on a limb's side of a dead centre, sign times root: below the first bound it is
    the other one, below the second it is not firm.
    """
    wrong, beside = (float(np.copysign(rounded(abs(bound)), bound)) for bound in bounds)
    return [
        f"if (!({side} >= {wrong})) {{ /* {c_comment(what)} */",
        "    status = NAME_WRONG_BRANCH;",
        "}",
        f"firm = firm && ({side} > {beside});",
    ]


def branch_text(made: LimbPlatform, common: Mapping[str, object], tolerance: float) -> str:
    """NAME_check_branch: whether each limb of an answer is on the reference's branch, by what tells
    its signs. An error t of the pose is sqrt(t) near a dead centre, where two branches meet.
    `common` has NAME_check_given's bounds `near`.
    """
    lines, known = [], made.inverse.known_coordinates
    state = (*made.passive, *known)
    names = texts_of("x", state) | texts_of("given", made.actuated)
    for block in made.blocks:
        if block.formulas is None:
            continue
        system, formulas = block.system, block.formulas
        written = LimbFormulas(made, block, formulas)
        sides = formulas.sides(written.signs)
        inputs = [
            (symbols, [text for c in part for text in names[c.name]])
            for symbols, part in ((system.unknown, system.unknowns), (system.known, known))
        ]
        emitter = Emitter.of(made.real, inputs, sides, prefix=f"{block.name}_t")
        tests = []
        for k, name in enumerate(formulas.names):
            text = emitter.value(0, k)
            near = float(
                BESIDE * np.sqrt(tolerance / system.characteristic_length) * written.usual_roots[k]
            )
            tests += side_lines(text, name, (-near, READ_AGAIN * near))
            tests += [f"told = told && ({text} > {rounded(near)});"]
        lines += [*emitter.lines, *tests]
    count, passive = (sum(c.width for c in part) for part in (state, made.passive))
    shown = {"count": count, "told": lines, "answer": f"&x[{passive}]"}
    return fill("told_branch.c", {**common, **shown})
