"""Write the C of a limb that has a closed form: its joints and their rates by the pose, and which branch a configuration is on.

Of each choice between two values the reference's is taken. A discriminant below zero means that no configuration has the pose.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.snapping import snapped_expression
from symkin.codegen.c_emitter import Emitter, Real, indent, indexed
from symkin.codegen.c_templates import fill
from symkin.codegen.limb_platform import LimbBlock, LimbPlatform
from symkin.codegen.newton_kernel import rounded
from symkin.computed_once import cached_property
from symkin.elimination.closed_form import ClosedForm
from symkin.text import c_comment

RESOLVED = 32.0
"""Roundings of a root's usual size below which it is nothing: no configuration has the pose, or the joint is not decided there."""
_SINGULAR = 1e-3
"""Share of a root's usual size below which the limb is near a dead centre, where rates are without bound."""


def closed_limb_text(made: LimbPlatform, block: LimbBlock, common: Mapping[str, object]) -> str:
    """The functions that give a limb's joints, and their rates where no matrix does."""
    assert block.formulas is not None  # noqa: S101 - the caller has looked
    written, count = LimbFormulas(made, block, block.formulas), len(actuated_places(block)) * int(block.sides.shape[1])
    values = {**common, "k": f"{made.name}_{block.name}", "count": block.system.width, "rates": count}
    text = fill("closed_limb.c", values | {"joints_lines": indent(written.joints)})
    if not count or block.kernel is not None:
        return text
    return text + fill("closed_rates.c", values | {"rates_lines": indent(written.rates)})


def actuated_places(block: LimbBlock) -> list[int]:
    """Places of the actuated joints among a limb's unknowns."""
    return [place.start for c, place in zip(block.system.unknowns, block.system.slices, strict=True) if c.role == "actuated"]


@dataclass(frozen=True, eq=False)
class LimbFormulas:
    """A limb's formulas with the reference's signs."""

    made: LimbPlatform
    block: LimbBlock
    formulas: ClosedForm

    @property
    def real(self) -> Real:
        return self.made.real

    @cached_property
    def signs(self) -> np.ndarray:
        return self.made.home_signs(self.formulas)

    @cached_property
    def usual_roots(self) -> np.ndarray:
        """How large roots are at sampled configurations."""
        known = self.made.inverse.known_coordinates
        poses = np.array([self.made.inverse.select_values(s.values, known) for s in self.made.samples])
        return np.asarray(np.sqrt(np.median(np.abs(self.formulas.discriminants_at(poses, self.signs)), axis=0)))

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
        return self._lines(self._values, RESOLVED * self.real.epsilon, "x", "OUT_OF_RANGE")

    @property
    def rates(self) -> list[str]:
        """Statements of the actuated joints' derivatives by the platform's twist, joint by joint. Of a root r of D: dr = dD / (2 r)."""
        values, roots = self._values[actuated_places(self.block), 0], self.formulas.roots
        found, of_roots = self._by_twist(values), ca.SX(0, int(self.block.sides.shape[1]))
        for k in range(int(roots.shape[0])):
            change = self._by_twist(self._discriminants[k])
            if k:
                change = change + ca.mtimes(ca.jacobian(self._discriminants[k], roots[:k]), of_roots)
            of_roots = ca.vertcat(of_roots, change / (2 * roots[k]))
        if int(roots.shape[0]):
            found = found + ca.mtimes(ca.jacobian(values, roots), of_roots)
        return self._lines(ca.vec(found.T), _SINGULAR, "rates", "SINGULAR")

    def _by_twist(self, expression: ca.SX) -> ca.SX:
        return self.made.by_twist(self.block.system, expression)

    def _lines(self, results: ca.SX, least: float, array: str, refused: str) -> list[str]:
        """Statements of discriminants, their roots, the results and the status: refused where a root is below the `least` share of its
        usual size."""
        limits = [self.real.literal(rounded((least * root) ** 2)) for root in self.usual_roots]
        known, roots = self.formulas.system.known, self.formulas.roots
        outputs = [snapped_expression(ca.densify(part), [known, roots]) for part in (self._discriminants, results)]
        function = ca.Function("limb", [known, roots], outputs, {"cse": True})
        count = int(roots.shape[0])
        emitter = Emitter(function, [indexed("c", int(known.shape[0])), [f"r{k + 1}" for k in range(count)]], self.real)
        lines, tests, one = emitter.lines, [], self.real.literal(1.0)
        for k in range(count):
            text = emitter.value(0, k)
            real, sqrt = self.real.type, self.real.call("sqrt")
            lines.append(
                f"const {real} d{k + 1} = {text}; /* above 0 where {c_comment(self.formulas.names[k])} has two values */"
            )
            lines.append(f"const {real} r{k + 1} = (d{k + 1} > {limits[k]}) ? {sqrt}(d{k + 1}) : {one};")
            tests.append(f"(d{k + 1} > {limits[k]})")
        made = len(lines)
        stores = [f"{array}[{i}] = {emitter.value(1, i)};" for i in range(int(results.shape[0]))]
        name, given = self.made.name.upper(), [*lines[made:], *stores]
        if not tests:
            return [*lines[:made], *given, f"return {name}_OK;"]
        # only where the roots are there: then nothing that is divided by vanishes with them
        condition = tests[0] if len(tests) == 1 else "(" + " && ".join(tests) + ")"
        return [
            *lines[:made], f"{self.made.name}_status status = {name}_{refused};", f"if {condition} {{", *("    " + line for line in given),
            f"    status = {name}_OK;", "} else {",
            *(f"    {array}[{i}] = {self.real.literal(0.0)};" for i in range(int(results.shape[0]))), "}", "return status;",
        ]  # fmt: skip


def branch_text(made: LimbPlatform, common: Mapping[str, object], tolerance: float) -> str:
    """NAME_check_branch: whether each limb of an answer is on the reference's branch, by what tells its signs. An error t of the pose
    is sqrt(t) near a dead centre, where two branches meet: what differs by less is one."""
    lines, known = [], made.inverse.known_coordinates
    state = [*(c for c in made.passive), *known]
    names: dict[str, list[str]] = {}
    place = 0
    for c in state:
        names[c.name] = indexed("x", c.width, place)
        place += c.width
    names |= {c.name: [f"given[{i}]"] for i, c in enumerate(made.actuated)}
    for block in made.blocks:
        if block.formulas is None:
            continue
        system, formulas = block.system, block.formulas
        written = LimbFormulas(made, block, formulas)
        sides = snapped_expression(ca.densify(formulas.sides(written.signs)), [system.unknown, system.known])
        function = ca.Function("sides", [system.unknown, system.known], [sides], {"cse": True})
        inputs = [[text for c in part for text in names[c.name]] for part in (system.unknowns, known)]
        emitter = Emitter(function, inputs, made.real, prefix=f"{block.name}_t")
        tests = []
        for k, name in enumerate(formulas.names):
            text = emitter.value(0, k)
            near = made.real.literal(
                -rounded(float(4.0 * np.sqrt(tolerance / system.characteristic_length) * written.usual_roots[k]))
            )
            tests += [
                f"if (!({text} >= {near})) {{ /* {c_comment(name)} */",
                f"    status = {made.name.upper()}_WRONG_BRANCH;",
                "}",
            ]
        lines += [*emitter.lines, *tests]
    return fill("told_branch.c", {**common, "count": place, "told": indent(lines)})
