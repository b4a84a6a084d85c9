"""Write the C of a direction of a joint map that formulas solve: formulas, signs of a
configuration, and the check of a line.

Everything is composed of the structure groups' closed forms, in the order of their solution: a
group's formulas read the numbers of those before it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.snapping import snapped_expression
from symkin.codegen.composed import Composed, Condition, Part
from symkin.codegen.condition_bends import (
    ConditionBend,
    condition_bend,
    even_units,
    share_of,
)
from symkin.codegen.joint_map import Direction, JointMap
from symkin.codegen.line_bounds import Span
from symkin.codegen.newton_kernel import rounded
from symkin.codegen.text.angles import Numbers, number_counts, numbers_by_name
from symkin.codegen.text.c import Emitter, Real, indent, indexed
from symkin.codegen.text.templates import fill
from symkin.computed_once import cached_property
from symkin.model.joint import units_of
from symkin.text import c_comment

_RESOLVED = 64.0
"""Roundings of a condition's usual size below which it is nothing."""
_ROOT = 1e-12
"""Share of a discriminant's usual size below which its root is not formed."""
_POINTS = 400
_FAR = 1.0
"""How far from the reference bends are sampled: in half turns, and in sizes."""
SLIDE_PARTS = (1.0 / 16, 1.0 / 4, 1.0)
"""Parts of a slide's range for which bends are bounded."""
_SMALLER = 0.25
"""Share of a bend in the whole range below which that in the least part is worth a table."""


@dataclass(frozen=True, eq=False)
class ClosedDirection:
    """The formulas of one direction, over its known numbers k, signs and roots."""

    made: JointMap
    direction: Direction
    names: Mapping[str, object]

    @property
    def real(self) -> Real:
        return self.made.real

    @cached_property
    def known(self) -> ca.SX:
        return ca.SX.sym("k", sum(number_counts(self.direction.known)))

    @cached_property
    def state(self) -> ca.SX:
        return ca.SX.sym("x", sum(number_counts(self.direction.unknown)))

    @cached_property
    def _composed(self) -> Composed:
        return Composed.of(self.direction.known, self.known, self.direction.parts)

    @cached_property
    def signs(self) -> ca.SX:
        """Symbols of all choices."""
        return self._composed.signs

    @cached_property
    def roots(self) -> ca.SX:
        return self._composed.roots

    @cached_property
    def _outputs(self) -> ca.SX:
        """The state's numbers."""
        found: list[ca.SX] = []
        for c in self.direction.unknown:
            for n in self.numbers[c.name]:
                found += (
                    _unit(n.cosine, n.sine)
                    if c.kind == "angle" and n.cosine is not None
                    else [n.value]
                )
        return snapped_expression(ca.vertcat(*found), [self.known, self.signs, self.roots])

    @property
    def conditions(self) -> list[Condition]:
        """Discriminants, and the divisors that none of them implies."""
        return self._composed.conditions

    @cached_property
    def divisors(self) -> list[int]:
        """Numbers of the conditions that are divided by: they may be of either sign, which they
        keep.
        """
        return [j for j, one in enumerate(self.conditions) if one.root is None]

    def sizes_of_divisors(self, array: str) -> list[str]:
        """Statements that leave the sizes of the divisors in an array of conditions."""
        return [f"{array}[{j}] = {self.real.call('fabs')}({array}[{j}]);" for j in self.divisors]

    @property
    def _begin_sides(self) -> list[str]:
        """Statements of the divisors' signs where a line begins, on which side they have to
        stay.
        """
        zero, one = self.real.literal(0.0), self.real.literal(1.0)
        return [
            line
            for j in self.divisors
            for line in (
                f"const {self.real.type} side{j} = (begin[{j}] < {zero}) ? -{one} : {one};",
                f"begin[{j}] *= side{j};",
            )
        ]

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

    def _bound(self, expression: ca.SX) -> ca.Function:
        """A function of the known values, at the reference's signs, roots put in."""
        values = ca.SX.sym("v", len(self.direction.known))
        return ca.Function("f", [values], [self._put_in(expression, values)])

    def _put_in(self, expression: ca.SX, values: ca.SX) -> ca.SX:
        signs = self.reference_signs
        expression = self.with_roots(expression, values, lambda d: ca.sqrt(ca.fmax(d, 0)))
        return (
            ca.substitute(expression, self.signs, ca.SX(ca.DM(signs))) if len(signs) else expression
        )

    def with_roots(
        self, expression: ca.SX, values: ca.SX, root: Callable[[ca.SX], ca.SX] = ca.sqrt
    ) -> ca.SX:
        """An expression of the known numbers, signs and roots over the known `values` and signs."""
        for one in reversed([c for c in self.conditions if c.root is not None]):
            expression = ca.substitute(expression, one.root, root(one.value))
        numbers = []
        for k, c in enumerate(self.direction.known):
            numbers += [ca.cos(values[k]), ca.sin(values[k])] if c.kind == "angle" else [values[k]]
        return ca.substitute(expression, self.known, ca.vertcat(*numbers))

    @property
    def numbers(self) -> dict[str, list[Numbers]]:
        """The numbers of every coordinate over the known numbers, signs and roots."""
        return self._composed.numbers

    @cached_property
    def reference_signs(self) -> np.ndarray:
        """The reference's sign of each choice."""
        found = []
        for part in self.direction.parts:
            if part.form is not None:
                values = [
                    part.problem.select_values(self.made.reference, c)
                    for c in (part.form.system.unknowns, part.problem.known_coordinates)
                ]
                found.append(part.form.signs_at(*values))
        return np.concatenate(found) if found else np.zeros(0)

    @cached_property
    def usual(self) -> np.ndarray:
        """The usual size of each condition, with the sign that it has at the reference."""
        function = self._bound(ca.vertcat(ca.SX(0, 1), *(c.value for c in self.conditions)))
        places = self.direction.problem.known_places
        values = np.array(
            [np.asarray(function(s.values[places])).ravel() for s in self.made.samples]
        )
        return np.array([rounded(float(v)) for v in np.median(values, axis=0)])

    @property
    def bends(self) -> np.ndarray:
        """An eighth of the largest second derivative of each condition over its usual size, known
        values in their `units`.
        """
        return np.array([bend.eighth for bend in self.part_bends[-1]])

    @cached_property
    def _known_values(self) -> ca.SX:
        """Symbols of the known values, angles as they are."""
        return ca.SX.sym("v", len(self.direction.known))

    @cached_property
    def _over_usual(self) -> list[ca.SX]:
        """The conditions over their usual sizes, of the known values."""
        return [
            self._put_in(one.value, self._known_values) / usual
            for one, usual in zip(self.conditions, self.usual, strict=True)
        ]

    @cached_property
    def units(self) -> np.ndarray:
        """What changes of the known values along a line are told in."""
        places = self.direction.problem.known_places
        scales = np.array(units_of(self.direction.known, self.made.size))
        near = np.array([s.values[places] for s in self.made.samples])
        return even_units(self._over_usual, self._known_values, scales, near)

    @cached_property
    def part_bends(self) -> list[list[ConditionBend]]:
        """The bend of each condition, and how it is known, in each of the parts; in the whole alone
        where bends in the least part are not far smaller.
        """
        whole = self._bends_in(SLIDE_PARTS[-1])
        if all(c.is_angular for c in self.direction.known):
            return [whole]
        least = self._bends_in(SLIDE_PARTS[0])
        smaller = any(a.eighth < _SMALLER * b.eighth for a, b in zip(least, whole, strict=True))
        between = [self._bends_in(part) for part in SLIDE_PARTS[1:-1]] if smaller else []
        return [least, *between, whole] if smaller else [whole]

    @cached_property
    def _shares(self) -> list[ca.SX]:
        """What each condition leaves of the bends of those that read it."""
        return [
            share_of(v, divides=one.root is None)
            for v, one in zip(self._over_usual, self.conditions, strict=True)
        ]

    def _bends_in(self, part: float) -> list[ConditionBend]:
        values, plain, shares = self._known_values, self._over_usual, self._shares
        scales = np.array(units_of(self.direction.known, self.made.size))
        spans, rng = self._spans(part), np.random.default_rng(7)
        low, high = np.array([(s.middle - s.half, s.middle + s.half) for s in spans]).T
        points = rng.uniform(low, high, (_POINTS, len(spans)))
        # lines may leave the whole of a range that no limits bound
        held = spans if part < SLIDE_PARTS[-1] or self._is_bounded else None
        found = []
        for j, one in enumerate(plain):
            read = self._read_by(j)
            share = ca.SX(1)
            for i in read:
                share = share * shares[i]
            found.append(condition_bend(one, share, values, scales, self.units, held, points, read))
        return found

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
        literal, count = self.real.literal, max(1, len(self.conditions))
        return dict(self.names) | {
            "which": self.direction.name,
            "k": f"{self.made.name}_{self.direction.name}",
            "nk": int(self.known.shape[0]),
            "ns": int(self.state.shape[0]),
            "nto": len(self.direction.known),
            "signs": max(1, int(self.signs.shape[0])),
            "conditions": count,
            "hold": indent(self._hold_lines, 2),
            "resolved": literal(_RESOLVED * self.real.epsilon),
            "near_one": literal(0.999),
            "least_part": literal(1.0 / 1024.0),
            "sides": indent(self._begin_sides),
            "sides_of_end": indent([f"end[{j}] *= side{j};" for j in self.divisors], 2),
            "home_signs": ", ".join(literal(float(s)) for s in self.reference_signs)
            or literal(1.0),
        }

    @property
    def _bend_lines(self) -> list[str]:
        """Statements of the bends: where they are of parts of the slides' ranges, of the first that
        holds the line.
        """
        real, literal, count = self.real, self.real.literal, max(1, len(self.conditions))
        rows = [
            ", ".join(literal(b.eighth) for b in row) or literal(0.0) for row in self.part_bends
        ]
        grounds = ", ".join(bend.ground for bend in self.part_bends[-1]) or "no condition"
        if len(rows) == 1:
            return [
                f"static const {real.type} bend[{count}] = {{ {rows[0]} }}; /* M / 8: {grounds} */"
            ]
        reference = self.made.reference_of(self.direction.known)
        away = [
            value if v == 0.0 else f"{value} - {literal(float(v))}"
            for i, (c, v) in enumerate(zip(self.direction.known, reference, strict=True))
            if not c.is_angular
            for value in (f"w->at[{i}]", f"to[{i}]")
        ]
        table = ", ".join(f"{{ {row} }}" for row in rows)
        fabs, ends = (
            self.real.call("fabs"),
            [part * _FAR * self.made.size for part in SLIDE_PARTS[:-1]],
        )
        return [
            f"static const {real.type} bends[{len(rows)}][{count}] = {{ {table} }}; /* M / 8: "
            f"{grounds} */",
            f"const {real.type} away[{len(away)}] = {{ {', '.join(away)} }};",
            "unsigned int reach = 0U; /* the part of the slides' ranges that holds the line */",
            f"for (int i = 0; i < {len(away)}; ++i) {{",
            *(
                f"    reach = ((reach < {k}U) && ({fabs}(away[i]) > {literal(end)})) ? {k}U : "
                f"reach;"
                for k, end in enumerate(ends, start=1)
            ),
            "}",
            f"const {real.type} *const bend = bends[reach];",
        ]

    @property
    def _hold_lines(self) -> list[str]:
        """Statements that hold a part of a line against the conditions' bends."""
        literal, count = self.real.literal, max(1, len(self.conditions))
        bent = "bend[{}] * way2 * (aim - done) * (aim - done)"
        read = {i for bend in self.part_bends[-1] for i in bend.read}
        if not read:
            return [
                f"for (int i = 0; i < {count}; ++i) {{",
                f"    const {self.real.type} smaller = (begin[i] < end[i]) ? begin[i] : end[i];",
                f"    held = held && (smaller > {bent.format('i')} + "
                f"{literal(_RESOLVED * self.real.epsilon)});",
                "    least = (smaller < least) ? smaller : least;",
                "}",
            ]
        lines = [
            "/* bends of conditions that read others are over the shares that these keep in the "
            "part (README.md) */"
        ]
        for j, bend in enumerate(self.part_bends[-1]):
            share = " * ".join(f"share{i}" for i in bend.read)
            lines += [
                f"const {self.real.type} smaller{j} = (begin[{j}] < end[{j}]) ? begin[{j}] : "
                f"end[{j}];",
                f"const {self.real.type} bent{j} = "
                f"{bent.format(j)}{f' / ({share})' if share else ''};",
                f"held = held && (smaller{j} > bent{j} + "
                f"{literal(_RESOLVED * self.real.epsilon)});",
                f"least = (smaller{j} < least) ? smaller{j} : least;",
                *(self._share_lines(j) if j in read else []),
            ]
        return lines

    def _share_lines(self, j: int) -> list[str]:
        """Statements of the share that a condition keeps at least in a part of a line: one that
        does not hold keeps any.
        """
        one = self.real.literal(1.0)
        power = (
            f"(kept{j} * kept{j}) * (kept{j} * kept{j})"
            if j in self.divisors
            else f"kept{j} * {self.real.call('sqrt')}(kept{j})"
        )
        return [
            f"const {self.real.type} kept{j} = (held && (smaller{j} - bent{j} < {one})) ? "
            f"(smaller{j} - bent{j}) : {one};",
            f"const {self.real.type} share{j} = {power};",
        ]

    @property
    def text(self) -> str:
        told = fill("map_told.c", self.values | {"lines": indent(self._told_lines)})
        way = [
            f"for (int i = 0; i < {len(self.direction.known)}; ++i) {{",
            f"    static const {self.real.type} weight[{len(self.direction.known)}] = {{ "
            f"{self._weights} }};",
            f"    const {self.real.type} way = weight[i] * (to[i] - w->at[i]);",
            "    way2 += way * way;",
            "}",
        ]
        return fill(
            "map_closed.c",
            self.values
            | {
                "bends": indent(self._bend_lines),
                "formulas": indent(self._formula_lines),
                "told": told,
                "way": indent(way),
            },
        )

    @property
    def _weights(self) -> str:
        return ", ".join(self.real.literal(1.0 / float(unit)) for unit in self.units)

    @property
    def _formula_lines(self) -> list[str]:
        """Statements of the conditions, the roots and the state."""
        literal, kind = self.real.literal, self.real.type
        symbols = [self.known, self.signs, self.roots]
        conditions = snapped_expression(
            ca.vertcat(ca.SX(0, 1), *(c.value for c in self.conditions)), symbols
        )
        roots = [f"r{k + 1}" for k in range(int(self.roots.shape[0]))]
        names = [
            indexed("k", int(self.known.shape[0])),
            indexed("sign", int(self.signs.shape[0])),
            roots,
        ]
        inputs = list(zip(symbols, names, strict=True))
        emitter = Emitter.of(self.real, inputs, conditions, self._outputs)
        number = 0
        for j, one in enumerate(self.conditions):
            text = emitter.value(0, j)
            if one.root is None:
                emitter.lines.append(
                    f"d[{j}] = {text} * {self._per_usual(j)}; /* {c_comment(one.name)}: what is "
                    f"divided by */"
                )
                continue
            number += 1
            emitter.lines.append(
                f"const {kind} d{number} = {text}; /* above 0 where {c_comment(one.name)} has two "
                f"values */"
            )
            emitter.lines.append(f"d[{j}] = d{number} * {self._per_usual(j)};")
            least = literal(rounded(_ROOT * float(self.usual[j])))
            emitter.lines.append(
                f"const {kind} r{number} = (d{number} > {least}) ? "
                f"{self.real.call('sqrt')}(d{number}) : {literal(0.0)};"
            )
        count = int(self._outputs.shape[0])
        lines = emitter.stored(indexed("x", count), 1)
        ones = [] if self.conditions else [f"d[0] = {literal(1.0)};"]
        return [*lines[: len(lines) - count], *ones, *lines[len(lines) - count :]]

    @property
    def _told_lines(self) -> list[str]:
        """Statements of the signs of a configuration, and of its conditions."""
        there = Composed(
            numbers_by_name(self.direction.known, self.known)
            | numbers_by_name(self.direction.unknown, self.state)
        )
        told: list[ca.SX] = []
        for part in self.direction.parts:
            if part.form is not None:
                system, own = part.form.system, part.problem
                inputs = [(system.known, own.known_coordinates), (system.unknown, system.unknowns)]
                told += there.written(part.form.told, inputs, part.form).elements()
        inputs = [self.known, self.state, self.signs, self.roots]
        divisors = [one.value for one in self.conditions if one.root is None]
        expressions = [
            snapped_expression(ca.vertcat(ca.SX(0, 1), *part), inputs) for part in (told, divisors)
        ]
        literal, count = self.real.literal, len(told)
        names = [
            indexed("k", int(self.known.shape[0])),
            indexed("x", int(self.state.shape[0])),
            indexed("sign", count),
        ]
        names.append([f"r{k + 1}" for k in range(count)])
        emitter = Emitter.of(self.real, list(zip(inputs, names, strict=True)), *expressions)
        place = 0
        for k in range(count):
            text = emitter.value(0, k)
            emitter.lines.append(
                f"sign[{k}] = ({text} < {literal(0.0)}) ? -{literal(1.0)} : {literal(1.0)};"
            )
            if self._read_later(k, [*told[k + 1 :], *divisors]):
                emitter.lines.append(
                    f"const {self.real.type} r{k + 1} = {self.real.call('fabs')}({text});"
                )
            j = next(
                (
                    i
                    for i, one in enumerate(self.conditions)
                    if one.root is not None and ca.is_equal(one.root, self.roots[k])
                ),
                None,
            )
            if j is not None:
                emitter.lines.append(f"d[{j}] = {text} * {text} * {self._per_usual(j)};")
        for j, one in enumerate(self.conditions):
            if one.root is None:
                text = emitter.value(1, place)
                emitter.lines.append(f"d[{j}] = {text} * {self._per_usual(j)};")
                place += 1
        return [
            *emitter.lines,
            *([] if told else [f"sign[0] = {literal(1.0)};"]),
            *([] if self.conditions else [f"d[0] = {literal(1.0)};"]),
        ]

    def _read_later(self, k: int, expressions: list[ca.SX]) -> bool:
        """Whether expressions hold the root of a choice."""
        return bool(expressions) and bool(
            ca.which_depends(ca.vertcat(*expressions), self.roots[k], 1, True).count(True)
        )

    def _per_usual(self, j: int) -> str:
        return self.real.literal(rounded(1.0 / float(self.usual[j])))


def _unit(cosine: ca.SX, sine: ca.SX | None) -> list[ca.SX]:
    """Cosine and sine of length 1: rounding takes formulas off the circle, where Newton's method
    could not bring them back.
    """
    assert sine is not None  # noqa: S101 - an angle has both
    inverse = 1 / ca.sqrt(cosine * cosine + sine * sine)
    return [cosine * inverse, sine * inverse]
