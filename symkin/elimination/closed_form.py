"""Find the closed form of a block of rows: formulas of its unknowns, with a sign for each choice
between two values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import NamedTuple

import casadi as ca
import numpy as np

from symkin.computed_once import cached_property
from symkin.elimination.angle_sums import Sums, angle_sums
from symkin.elimination.eliminating import (
    combine_lengths,
    cut_by_line,
    defer_defined,
    leave_alone,
    subtract_quadratics,
    turn_angle,
)
from symkin.elimination.polynomial import Ring
from symkin.elimination.rows import NotPolynomialError, polynomial_rows
from symkin.elimination.solving import solve_deferred, solve_single
from symkin.elimination.term_sizes import term_sizes
from symkin.elimination.workspace import Workspace
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.mapped import Mapped
from symkin.numeric.system import System
from symkin.spatial.backend import stacked

_SAMPLES = 3
_NEAR = 0.05
"""How far samples lie from the given values: in radians, and in sizes."""
_DOUBLE = 1e-9
"""Share of the terms of a discriminant below which two solutions may be one."""
_VANISHING = 1e-7
"""Share of the terms of a divisor below which a formula may lose a solution, or has lost its
digits.
"""
_CLOSED = 1e-9
"""Closure error, in sizes, of a solution by formulas: rounding, with some digits lost."""
_MOST_STEPS = 100


class Solutions(NamedTuple):
    """Values (n, count, width) of the unknowns, which of them are `real` (n, count), and for which
    known values (n,) that is `clear`: no discriminant is nearly zero beside its terms, and no
    divisor.
    """

    values: np.ndarray
    real: np.ndarray
    clear: np.ndarray


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """Formulas of all unknowns of a system, with choices between two values.

    unknowns = `values`(known; signs, roots): of each choice a sign, +1 or -1, and a root, the
    square root of one of the `discriminants`(known; signs and roots of those before), which are at
    least 0 where a solution is real; `told` are expressions of (known, unknowns; signs and roots of
    those before) that equal sign times root, by which a configuration says which of the values it
    is. Formulas divide by `divisors`, of which those of the numbers `implied`, A^2 + B^2, are above
    zero where a discriminant is, A^2 + B^2 - C^2, and those of the numbers `squares` sums of
    squares, or less one. `first` are lengths and cosines of angles,
    `second` the sines. `steps` are the derivation, a sentence each, `names` what the choices
    decide. `samples` are the known values at which coefficients were compared.
    """

    system: System
    signs: ca.SX
    roots: ca.SX
    first: ca.SX
    second: ca.SX
    discriminants: ca.SX
    divisors: ca.SX
    implied: frozenset[int]
    squares: frozenset[int]
    told: ca.SX
    steps: tuple[str, ...]
    names: tuple[str, ...]
    samples: np.ndarray

    @cached_property
    def count(self) -> int:
        """How many solutions the formulas have, over the complex numbers."""
        return 2 ** self.signs.shape[0]

    @property
    def values(self) -> ca.SX:
        """The unknowns, angles within half a turn of 0."""
        return self.values_about(np.zeros(self.system.width))

    def values_about(self, near: np.ndarray) -> ca.SX:
        """The unknowns, each angle within half a turn of the multiple of a quarter turn that is
        next to its value in `near` (width,).
        """
        found = []
        for k, coordinate in enumerate(self.system.unknowns):
            if not coordinate.is_angular:
                found.append(self.first[k])
                continue
            quarters = round(float(near[k]) / (0.5 * np.pi))
            cosine, sine = self.first[k], self.second[k]
            for _ in range(quarters % 4):
                cosine, sine = sine, -cosine
            angle = ca.atan2(sine, cosine)
            found.append(angle + 0.5 * np.pi * quarters if quarters else angle)
        return ca.vertcat(*found)

    @cached_property
    def choices(self) -> np.ndarray:
        """All signs (count, choices)."""
        return np.array(list(product((1.0, -1.0), repeat=self.signs.shape[0]))).reshape(
            self.count, -1
        )

    @cached_property
    def judged(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Expressions of (signs, known): the unknowns; the discriminants, which are at least 0
        where these are real; and what is above 0 where no discriminant is nearly zero beside its
        terms, and no divisor.
        """
        values, discriminants, divisors, sizes = self._parts
        judged = ca.vertcat(ca.SX(0, 1), *discriminants.elements(), *divisors.elements())
        least = np.full(judged.shape[0], _VANISHING)
        least[: self.signs.shape[0]] = _DOUBLE
        return values, discriminants, ca.fabs(judged) - ca.DM(least) * sizes

    @cached_property
    def _parts(self) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """Values, discriminants, divisors and the sizes of the terms of these two, for signs and
        known values.
        """
        width, choices = self.system.width, self.signs.shape[0]
        whole = ca.densify(
            self.at_roots(
                ca.vertcat(self.values, self.discriminants, self.divisors),
                lambda d: ca.sqrt(ca.fmax(d, 0.0)),
            )
        )
        inputs = ca.vertcat(self.signs, self.system.known)
        sizes = term_sizes(whole[width:], inputs, ca.fabs(inputs))
        return whole[:width], whole[width : width + choices], whole[width + choices :], sizes

    @cached_property
    def _mapped(self) -> Mapped:
        return Mapped.of([self.signs, self.system.known], list(self._parts))

    def at_roots(self, whole: ca.SX, root: Callable[[ca.SX], ca.SX]) -> ca.SX:
        """Expressions with the `root` of each discriminant put in."""
        for k in reversed(range(self.roots.shape[0])):
            whole = ca.substitute(whole, self.roots[k], root(self.discriminants[k]))
        return whole

    @cached_property
    def _signs(self) -> ca.Function:
        told = self.told
        for k in range(self.signs.shape[0]):
            told = ca.substitute(told, self.signs[k], ca.if_else(told[k] < 0, -1, 1))
            told = ca.substitute(told, self.roots[k], ca.fabs(told[k]))
        return ca.Function("signs", [self.system.unknown, self.system.known], [told])

    def sides(self, signs: np.ndarray) -> ca.SX:
        """Expressions (choices,) of (known, unknowns) that are at least 0 where a configuration has
        these signs.
        """
        told = ca.substitute(self.told, self.signs, ca.SX(ca.DM(signs)))
        found: list[ca.SX] = []
        for k, sign in enumerate(signs):
            part = told[k]
            for before, root in enumerate(found):
                part = ca.substitute(part, self.roots[before], root)
            found.append(sign * part)
        return stacked(found)

    def signs_at(self, unknown: np.ndarray, known: np.ndarray) -> np.ndarray:
        """The signs (choices,) of a configuration."""
        return np.where(np.asarray(self._signs(unknown, known)).ravel() < 0.0, -1.0, 1.0)

    def discriminants_at(self, known: np.ndarray, signs: np.ndarray) -> np.ndarray:
        """The discriminants (n, choices) for known values (n, known) and signs (choices,)."""
        return self._mapped(np.tile(signs, (len(known), 1)), known)[1].reshape(len(known), -1)

    def divisors_at(self, known: np.ndarray, signs: np.ndarray) -> np.ndarray:
        """The divisors (n, divisors) for known values (n, known) and signs (choices,)."""
        return self._mapped(np.tile(signs, (len(known), 1)), known)[2].reshape(len(known), -1)

    def solutions(self, known: np.ndarray) -> Solutions:
        """All solutions for known values (n, known)."""
        with np.errstate(all="ignore"):
            values, discriminants, divisors, sizes = self._evaluated(known)
            choices = discriminants.shape[2]
            clear = (
                np.isfinite(values).all(axis=(1, 2))
                & (np.abs(discriminants) > _DOUBLE * sizes[:, :, :choices]).all(axis=(1, 2))
                & (np.abs(divisors) > _VANISHING * sizes[:, :, choices:]).all(axis=(1, 2))
            )
        return Solutions(values, np.asarray((discriminants >= 0.0).all(axis=2)), clear)

    def _evaluated(self, known: np.ndarray) -> list[np.ndarray]:
        """Values (n, count, width), discriminants, divisors, and the sizes of the terms of these
        two.
        """
        signs = self.choices[np.arange(len(known) * self.count) % self.count]
        parts = self._mapped(signs, known.repeat(self.count, axis=0))
        return [part.reshape(len(known), self.count, -1) for part in parts]

    def closes(self, known: np.ndarray) -> bool:
        """Whether all real solutions for known values (n, known), of which there are some, satisfy
        the system.
        """
        found = self.solutions(known)
        owner, which = np.nonzero(found.real)
        residuals = self.system.residuals(found.values[owner, which], known[owner])
        return bool(owner.size and np.all(residuals <= _CLOSED * self.system.characteristic_length))

    @property
    def has_conditions(self) -> bool:
        """Whether there are more rows than unknowns, so that known values need not have a
        solution.
        """
        return self.system.rows.shape[0] > self.system.freedom


def closed_form(
    system: System, samples: np.ndarray, *, all_rows: bool = False
) -> ClosedForm | None:
    """The closed form of a system, None where the steps known here find none; with `all_rows` by as
    many rows as there are (see `Workspace`).

    Coefficients are compared at the known values `samples` (n, known): the formulas hold where
    relations among known values that hold at all samples do (`samples_about`: none).
    """
    if not system.unknowns:
        return None
    for rows in (system.rows, system.errors):
        try:
            work, sums = _begun(system, rows, samples)
        except NotPolynomialError:
            continue
        work.all_rows = all_rows
        found = _made(system, work, sums, samples) if _run(work) else None
        return (
            found if found is not None and (found.has_conditions or found.closes(samples)) else None
        )
    return None


def samples_about(
    system: System, near: np.ndarray, coordinates: Sequence[Coordinate], seed: int = 0
) -> np.ndarray:
    """Random values (samples, known) of the known coordinates about those of a configuration, for
    formulas that hold whatever is given.
    """
    scale = np.array(units_of(coordinates, system.characteristic_length))
    return (
        near
        + _NEAR * np.random.default_rng(seed).uniform(-1.0, 1.0, size=(_SAMPLES, len(near))) * scale
    )


def _begun(system: System, rows: ca.SX, samples: np.ndarray) -> tuple[Workspace, Sums]:
    """All rows, by those sums of angles that leave the fewest terms."""
    ring, chosen = Ring(system.unknowns), None
    for sums in angle_sums(system, rows, samples[0]):
        polynomials = polynomial_rows(ring, system, rows, sums)
        work = Workspace(
            ring,
            polynomials,
            set(range(len(system.unknowns))),
            [system.known],
            samples,
            system.characteristic_length,
        )
        size = max(system.characteristic_length, system.farthest)
        work.rows = work.all_tidied(polynomials, size)
        terms = sum(len(row.terms) for row in work.rows)
        if chosen is None or terms < chosen[0]:
            chosen = terms, work, sums
    assert chosen is not None  # noqa: S101 - the first choice has no sums
    return chosen[1], chosen[2]


def _run(work: Workspace) -> bool:
    """Take steps, the plainest first, until all is solved; False where no step is left."""
    steps = (
        solve_deferred,
        solve_single,
        defer_defined,
        combine_lengths,
        turn_angle,
        subtract_quadratics,
        cut_by_line,
        leave_alone,
    )
    for _ in range(_MOST_STEPS):
        work.without_repeats()
        if not work.active and not work.deferred:
            return True
        if not any(step(work) for step in steps):
            return False
    return False


def _made(system: System, work: Workspace, sums: Sums, samples: np.ndarray) -> ClosedForm:
    ring = work.ring
    found, own, whole = [], [], [ca.SX(0)] * system.width
    for k, coordinate in enumerate(ring.unknowns):
        parts = [work.values[place] for place in ring.places[k]]
        z = system.unknown[k]
        if not coordinate.is_angular:
            found.append((parts[0], ca.SX(0)))
            own.append((ring.places[k][0], z))
            continue
        if k in sums:
            # the sum of angles up to this one, less that up to the one before
            before, sign = sums[k]
            c, s = (work.values[place] for place in ring.places[before])
            cosine, sine = parts
            parts = [cosine * c + sine * s, sign * (sine * c - cosine * s)]
            whole[k] = whole[before] + sign * z
        else:
            whole[k] = z
        found.append((parts[0], parts[1]))
        own += [(ring.places[k][0], ca.cos(whole[k])), (ring.places[k][1], ca.sin(whole[k]))]
    signs = stacked(c.sign for c in work.choices)
    outputs = [
        *(ca.vertcat(*column) for column in zip(*found, strict=True)),
        stacked(c.discriminant for c in work.choices),
        stacked(work.divisors),
    ]
    symbols = [symbol for symbol, _ in work.definitions]
    first, second, discriminants, divisors = _inlined(
        symbols, [expression for _, expression in work.definitions], outputs
    )
    roots = stacked(c.root for c in work.choices)
    return ClosedForm(
        system=system,
        signs=signs,
        roots=roots,
        first=first,
        second=second,
        discriminants=discriminants,
        divisors=divisors,
        implied=_places(work.divisors, work.implied),
        squares=_places(work.divisors, work.squares),
        told=_told(work, dict(own)),
        steps=tuple(work.steps),
        names=tuple(c.name for c in work.choices),
        samples=samples,
    )


def _places(symbols: Sequence[ca.SX], among: Sequence[ca.SX]) -> frozenset[int]:
    """Places of the symbols that are among others."""
    return frozenset(
        j for j, d in enumerate(symbols) if any(ca.is_equal(d, other) for other in among)
    )


def _told(work: Workspace, own: dict[int, ca.SX]) -> ca.SX:
    """What has the signs of a configuration, whose generators are `own`: the formulas, with what is
    solved read from it.
    """
    places, parts = [ca.vertcat(*(part[k] for k in own)) for part in (work.own, own)]
    solved = {_key(work.values[place]): expression for place, expression in own.items()}
    symbols = [symbol for symbol, _ in work.definitions]
    read = [solved.get(_key(symbol), expression) for symbol, expression in work.definitions]
    told = ca.substitute(stacked(c.tells for c in work.choices), places, parts)
    (told,) = _inlined(symbols, read, [told])
    return told


def _key(symbol: ca.SX) -> int:
    """What tells a symbol from others."""
    return int(symbol.element_hash()) if symbol.is_symbolic() else -1


def _inlined(symbols: list[ca.SX], definitions: list[ca.SX], outputs: list[ca.SX]) -> list[ca.SX]:
    """Outputs with definitions put in, which may read earlier ones."""
    sizes = np.cumsum([0, *(o.shape[0] for o in outputs)]).tolist()
    whole = ca.vertcat(*outputs)
    for symbol, definition in zip(reversed(symbols), reversed(definitions), strict=True):
        whole = ca.substitute(whole, symbol, definition)
    return [whole[a:b] for a, b in pairwise(sizes)]
