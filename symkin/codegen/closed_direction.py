"""Write the C of a direction of a joint map that formulas solve: formulas, signs of a
configuration, and the check of a line.

Everything is composed of the structure groups' closed forms, in the order of their solution: a
group's formulas read the numbers of those before it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.codegen.line_bounds import Span
from symkin.codegen.map.joint_map import Direction, JointMap
from symkin.codegen.map.record import Source
from symkin.codegen.steps.composed import Composed, Condition, Formulas, Part
from symkin.codegen.steps.guard_text import GuardText
from symkin.codegen.steps.guards import (
    SLIDE_PARTS,
    Bound,
    Guard,
    Line,
    even_units,
    sampled_bound,
    share_of,
)
from symkin.codegen.steps.newton_kernel import rounded
from symkin.codegen.text.angles import number_counts, numbers_by_name
from symkin.codegen.text.c import Emitter
from symkin.codegen.text.gathered import gathered
from symkin.codegen.text.templates import fill
from symkin.computed_once import cached_property
from symkin.model.joint import units_of
from symkin.spatial.backend import stacked
from symkin.text import c_comment

_RESOLVED = 64.0
"""Roundings of a condition's usual size below which it is nothing."""
_ROOT = 1e-12
"""Share of a discriminant's usual size below which its root is not formed."""
_FAR = 1.0
"""How far from the reference bends are sampled: in half turns, and in sizes."""
_MOST_GIVEN = 3
"""Known values of which waves are summed: their samples grow by a power with each."""
_SMALLER = 0.25
"""Share of a bend in the whole range below which that in the least part is worth a table."""


@dataclass(frozen=True, eq=False)
class ClosedDirection(Source):
    """The formulas of one direction, over its known numbers k, signs and roots."""

    made: JointMap
    direction: Direction
    names: Mapping[str, object]

    @cached_property
    def formulas(self) -> Formulas:
        return Formulas.of(self.direction.problem, self.direction.parts)

    @cached_property
    def state(self) -> ca.SX:
        return ca.SX.sym("x", sum(number_counts(self.direction.unknown)))

    @cached_property
    def _outputs(self) -> ca.SX:
        """The state's numbers."""
        return stacked(
            _unit(n.cosine, n.sine) if c.is_periodic and n.cosine is not None else n.value
            for c in self.direction.unknown
            for n in self.formulas.whole.numbers[c.name]
        )

    @property
    def conditions(self) -> list[Condition]:
        """Discriminants, and the divisors that none of them implies."""
        return self.formulas.whole.conditions

    @cached_property
    def divisors(self) -> list[int]:
        """Numbers of the conditions that are divided by: they may be of either sign, which they
        keep.
        """
        return [j for j, one in enumerate(self.conditions) if one.root is None]

    def _spans(self, part: float) -> list[Span]:
        """What the known values run over about the reference: within limits, slides in a part of
        their range.
        """
        found, reference = list[Span](), self.made.reference_of(self.direction.known)
        for c, v, unit in zip(self.direction.known, reference, self.units.tolist(), strict=True):
            reach = _FAR * np.pi if c.is_angular else part * _FAR * self.made.size
            low, high = (v - reach, v + reach)
            if c.limits is not None:
                low, high = max(low, c.limits[0]), min(high, c.limits[1])
            found.append(Span(c.is_angular, 0.5 * (low + high), 0.5 * (high - low), unit))
        return found

    @property
    def _is_bounded(self) -> bool:
        """Whether all slides have limits near the reference."""
        far, reference = _FAR * self.made.size, self.made.reference_of(self.direction.known)
        return all(
            c.is_angular or (c.limits is not None and np.max(np.abs(c.limits - v)) <= far)
            for c, v in zip(self.direction.known, reference, strict=True)
        )

    def _put_in(self, expression: ca.SX) -> ca.SX:
        """An expression by the known values at the reference's signs, roots put in."""
        return self.formulas.put_in(expression, self.reference_signs)

    @cached_property
    def reference_signs(self) -> np.ndarray:
        """The reference's sign of each choice."""
        return self.formulas.signs_at(self.made.reference)

    @cached_property
    def usual(self) -> np.ndarray:
        """The usual size of each condition, with the sign that it has at the reference."""
        whole = stacked(c.value for c in self.conditions)
        values = self.formulas.at(whole, self.reference_signs, self._near)
        return np.array([rounded(v) for v in np.median(values, axis=0)])

    @cached_property
    def _near(self) -> np.ndarray:
        """Known values (n, known) of sampled configurations."""
        return np.array([s.values[self.direction.problem.known_places] for s in self.made.samples])

    @cached_property
    def _over_usual(self) -> list[ca.SX]:
        """The conditions over their usual sizes, of the known values."""
        return [
            self._put_in(one.value) * factor
            for one, factor in zip(self.conditions, self._factors, strict=True)
        ]

    @property
    def _scales(self) -> np.ndarray:
        """The size of a length among the known values, 1 of an angle."""
        return np.array(units_of(self.direction.known, self.made.size))

    @cached_property
    def units(self) -> np.ndarray:
        """What changes of the known values along a line are told in."""
        return even_units(self._over_usual, self.formulas.values, self._scales, self._near)

    @cached_property
    def _parts(self) -> tuple[float, ...]:
        """Parts of the slides' ranges that may have bounds of their own."""
        angular = all(c.is_angular for c in self.direction.known)
        return SLIDE_PARTS[-1:] if angular else SLIDE_PARTS

    @cached_property
    def guards(self) -> list[Guard]:
        """The guard of each condition over its usual size, with bounds for each of the parts; for
        the whole alone where bounds of the least part are not far smaller.
        """
        found = list[Guard]()
        for j, one in enumerate(self.conditions):
            place = None if one.root is None else j
            made = Guard(one.name, place, (), self._factors[j], "proved", ())
            found.append(self._bounded(made, j, found))
        smaller = any(
            np.max(g.bounds[0].plain) < _SMALLER * np.max(g.bounds[-1].plain) for g in found
        )
        return found if smaller else [replace(g, bounds=g.bounds[-1:]) for g in found]

    @cached_property
    def _shares(self) -> list[ca.SX]:
        """What each condition leaves of the bends of those that read it."""
        return [
            share_of(v, divides=one.root is None)
            for v, one in zip(self._over_usual, self.conditions, strict=True)
        ]

    @cached_property
    def _line(self) -> Line:
        return Line(self.formulas.values, [self._spans(part) for part in self._parts])

    def _bounded(self, guard: Guard, j: int, before: list[Guard]) -> Guard:
        """The guard of condition j with its bounds: proved where it is a polynomial, or one with a
        root, and lines stay within its ranges; else sampled.
        """
        one, line = self.conditions[j], self._line
        roots = {
            i: (other.root, self.formulas.of_values(other.value))
            for i, other in enumerate(self.conditions[:j])
            if other.root is not None
        }
        value = self.formulas.of_values(one.value * guard.factor)
        few = len(self.direction.known) <= _MOST_GIVEN
        proved = line.proved(guard, value, roots, before, ca.SX(0, 1)) if few else None
        kept: tuple[Bound, ...] = ()
        if proved is not None:
            # values are over their usual size, and so are their roundings
            kept = tuple(replace(b, size=1.0) for b in proved.bounds)
            if self._is_bounded:
                return replace(proved, bounds=kept)
            # lines may leave the whole of a range that no limits bound
            kept = kept[:-1] if proved.root is None else ()
        read, share = self._read_by(j), ca.SX(1)
        for i in read:
            share = share * self._shares[i]
        sampled = (
            sampled_bound(self._over_usual[j], share, line, part, self._scales, self.units)
            for part in range(len(kept), len(line.spans))
        )
        return replace(guard, ground="sampled", bounds=(*kept, *sampled), read=read)

    def _read_by(self, j: int) -> tuple[int, ...]:
        """Numbers of the conditions whose roots or quotients a condition is made of, those of these
        included.
        """
        one, parts = self.conditions[j], self._parts_before(self.conditions[j].part)
        found = set[int]()
        for i, other in enumerate(self.conditions[:j]):
            if (
                (other.part in parts)
                if other.root is None
                else bool(ca.depends_on(one.value, other.root))
            ):
                found |= {i, *self._read_by(i)}
        return tuple(sorted(found))

    def _parts_before(self, part: Part) -> list[Part]:
        """The parts whose unknowns a part reads, and those that these read."""
        names, found = {c.name for c in part.problem.known_coordinates}, list[Part]()
        for other in reversed(self.direction.parts[: self.direction.parts.index(part)]):
            if names & {c.name for c in other.problem.system.unknowns}:
                found.append(other)
                names |= {c.name for c in other.problem.known_coordinates}
        return found

    # --- text -------------------------------------------------------------------------------------

    @cached_property
    def values(self) -> dict[str, object]:
        """Names of the templates."""
        count = max(1, len(self.conditions))
        return dict(self.names) | {
            "which": self.direction.name,
            "k": f"{self.name}_{self.direction.name}",
            "nk": self.formulas.known.numel(),
            "ns": self.state.numel(),
            "nto": len(self.direction.known),
            "signs": max(1, self.formulas.roots.numel() + len(self.divisors)),
            "conditions": count,
            "resolved": _RESOLVED * self.real.epsilon,
            "home_signs": (*self.reference_signs, *(self._factors[j] for j in self.divisors))
            or (1.0,),
        }

    @property
    def guard_text(self) -> GuardText:
        return GuardText(self.guards, self.real, measures=False)

    @property
    def members(self) -> list[str]:
        """Members of the work space beside those of Newton's method."""
        return [f"real sign[{self.values['signs']}];", *self.guard_text.members]

    @property
    def _reach_lines(self) -> list[str]:
        """Statements of the first part of the slides' ranges that holds the line."""
        if not self.guards or len(self.guards[0].bounds) == 1:
            return []
        reference = self.made.reference_of(self.direction.known)
        slides = [
            (text, float(v), _FAR * self.made.size)
            for i, (c, v) in enumerate(zip(self.direction.known, reference, strict=True))
            if not c.is_angular
            for text in (f"w->at[{i}]", f"to[{i}]")
        ]
        return self.guard_text.reach_lines(slides)

    @property
    def text(self) -> str:
        k = self.values["k"]
        aim = [
            f"{k}_set_target(w, to, end);",
            f"{k}_formulas(w->k, w->sign, w->x, w->guard);",
        ]
        own = {
            "reach": self._reach_lines,
            "formulas": self._formula_lines,
            "told": self._told_lines,
            "walk": self.guard_text.text(self.values, aim, 1.0),
        }
        return fill("map_closed.c", self.values | own)

    @property
    def _formula_lines(self) -> list[str]:
        """Statements of the conditions, the roots and the state."""
        made, conditions = self.formulas, stacked(c.value for c in self.conditions)
        roots = [f"r{k + 1}" for k in range(made.roots.numel())]
        inputs = [(made.known, "k"), (made.roots, roots)]
        symbols = [made.known, made.roots]
        outputs = gathered([conditions, self._outputs], symbols, made.turns)
        emitter = Emitter.of(self.real, inputs, *outputs)
        number, side = 0, made.roots.numel()
        for j, one in enumerate(self.conditions):
            text = emitter.value(0, j)
            if one.root is None:
                about = f"/* {c_comment(one.name)}: what is divided by */"
                emitter.lines.append(f"d[{j}] = sign[{side}] * {text}; {about}")
                side += 1
                continue
            number += 1
            least, sign = rounded(_ROOT * float(self.usual[j])), f"sign[{number - 1}]"
            emitter.root(number, text, str(least), "0.0", about=one.name, sign=sign)
            emitter.lines.insert(-1, f"d[{j}] = d{number} * {self._factors[j]};")
        if not self.conditions:
            emitter.lines.append("d[0] = 1.0;")
        return emitter.stored("x", 1)

    @property
    def _told_lines(self) -> list[str]:
        """Statements of the signs of a configuration, and of its conditions."""
        made, known, unknown = self.formulas, self.direction.known, self.direction.unknown
        numbers = numbers_by_name(known, made.known) | numbers_by_name(unknown, self.state)
        there = Composed(self.direction.problem.closure, numbers)
        told = [e for form in made.whole.forms for e in there.written(form.told, form).elements()]
        inputs = [made.known, self.state, made.roots]
        divisors = [one.value for one in self.conditions if one.root is None]
        names = ("k", "x", [f"r{k + 1}" for k in range(len(told))])
        outputs = gathered([stacked(told), stacked(divisors)], inputs, made.turns)
        emitter = Emitter.of(self.real, list(zip(inputs, names, strict=True)), *outputs)
        lines = emitter.lines
        for k, j in enumerate(j for j, c in enumerate(self.conditions) if c.root is not None):
            text = emitter.value(0, k)
            lines.append(f"sign[{k}] = ({text} < 0.0) ? -1.0 : 1.0;")
            if ca.depends_on(stacked([*told[k + 1 :], *divisors]), made.roots[k]):
                lines.append(f"const real r{k + 1} = {text};")
            lines.append(f"d[{j}] = {text} * {text} * {self._factors[j]};")
        for place, j in enumerate(self.divisors):
            # on which side of zero it has to stay, over its usual size
            text, side = emitter.value(1, place), f"sign[{len(told) + place}]"
            per = abs(self._factors[j])
            lines += [
                f"{side} = ({text} < 0.0) ? -{per} : {per};",
                f"d[{j}] = {side} * {text};",
            ]
        lines += [] if told or divisors else ["sign[0] = 1.0;"]
        return [*lines, *([] if self.conditions else ["d[0] = 1.0;"])]

    @cached_property
    def _factors(self) -> list[float]:
        """What makes conditions 1 at a usual place, with the sign that they have at the
        reference.
        """
        return [rounded(1.0 / float(usual)) for usual in self.usual]


def _unit(cosine: ca.SX, sine: ca.SX | None) -> ca.SX:
    """Cosine and sine of length 1: rounding takes formulas off the circle, where Newton's method
    could not bring them back.
    """
    assert sine is not None  # noqa: S101 - an angle has both
    inverse = 1 / ca.sqrt(cosine * cosine + sine * sine)
    return ca.vertcat(cosine * inverse, sine * inverse)
