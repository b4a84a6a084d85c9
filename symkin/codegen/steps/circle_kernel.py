"""State Newton's iteration with angles as cosines and sines: no trigonometry is left in its loop.

Where rows are short as polynomials in these numbers, they are written so, with what depends on the
known values alone collected in a few `coefficients`, which are computed once for a point of the
line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import casadi as ca
import numpy as np

from symkin.closure.snapping import snap, snapped_expression
from symkin.codegen.steps.newton_kernel import Kernel, Meaning, bent_places, listed, moves
from symkin.codegen.text.angles import by_numbers, number_counts, numbers_of
from symkin.computed_once import lru_cache
from symkin.elimination.polynomial import Monomial, Polynomial, Ring
from symkin.elimination.rows import NotPolynomialError, polynomial_rows
from symkin.model.joint import Coordinate
from symkin.numeric.system import System
from symkin.spatial.backend import dot, stacked

_MOST_ANGLES = 6
"""Coordinates of rows that are written as polynomials: terms double with each angle."""
_MOST_TERMS = 60
"""Terms of a row beyond which products of nested sums are shorter."""
_NOTHING = 1e-12
"""Share of a row's largest coefficient that is rounding."""
_PARALLEL = 1e-10
"""Sine of the angle between vectors of coefficients below which they are parallel."""


@dataclass(frozen=True, eq=False)
class CircleKernel:
    """A kernel, and its known values as expressions `coefficients` of the known coordinates'
    `numbers`.
    """

    kernel: Kernel
    numbers: ca.SX
    coefficients: ca.SX

    @property
    def is_plain(self) -> bool:
        """Whether the kernel reads the numbers themselves."""
        return self.kernel.known is self.numbers

    def known_at(self, numbers: np.ndarray) -> np.ndarray:
        """The kernel's known values (n,) at numbers of the known coordinates."""
        return np.asarray(ca.Function("k", [self.numbers], [self.coefficients])(numbers)).ravel()

    @property
    def rows_by_numbers(self) -> ca.SX:
        """The kernel's rows over state and numbers."""
        return ca.substitute(self.kernel.rows, self.kernel.known, self.coefficients)


def circle_kernel(
    name: str, system: System, known: Sequence[Coordinate], *, collected: bool
) -> CircleKernel:
    """The iteration that solves a system; `collected`: known values may be coefficients of the rows
    in place of numbers.
    """
    size = system.characteristic_length
    state = ca.SX.sym("x", sum(number_counts(system.unknowns)))
    numbers = ca.SX.sym("k", sum(number_counts(known)))
    step = ca.SX.sym("s", system.freedom)
    tangent, moved = moves(system.unknowns, state, step, size)
    symbols = [
        (system.unknown, numbers_of(system.unknowns, state)),
        (system.known, numbers_of(known, numbers)),
    ]
    rows = snapped_expression(-by_numbers(system.rows, symbols), [state, numbers])
    jacobian = snapped_expression(-ca.mtimes(ca.jacobian(rows, state), tangent), [state, numbers])
    symbol, coefficients = numbers, numbers
    short = _polynomials(system, known, state, numbers, collected=collected)
    if short is not None and _length(short[:2], [state, short[2]]) < _length(
        (rows, jacobian), [state, numbers]
    ):
        rows, jacobian, symbol, coefficients = short
    kernel = Kernel(
        name=name,
        state=state,
        known=symbol,
        geometry=ca.SX(0, 1),
        step=step,
        shared_symbols=ca.SX(0, 1),
        rows=rows,
        shared=ca.SX(0, 1),
        jacobian=jacobian,
        moved=moved,
        norm=dot(step, step),
        row_length=1.0,
        characteristic_length=size,
        meaning=Meaning(
            state=f"{listed(system.unknowns)}: of angles cosine and sine",
            known=f"{listed(known)}: of angles cosine and sine"
            if symbol is numbers
            else f"what the rows read of {listed(known)}",
            rows="minus the closure's rows, lengths and angles times the size",
            step="changes of the state: lengths, angles and turns times the size",
        ),
        turns=bent_places(known, size),
    )
    return CircleKernel(kernel, numbers, coefficients)


def _length(expressions: Sequence[ca.SX], symbols: Sequence[ca.SX]) -> int:
    """Operations of expressions."""
    return ca.Function(
        "f", list(symbols), [ca.densify(e) for e in expressions], {"cse": True}
    ).n_instructions()


# --- rows as polynomials --------------------------------------------------------------------------


def polynomials_of(
    rows: ca.SX, system: System, coordinates: tuple[Coordinate, ...]
) -> tuple[Ring, list[Polynomial]] | None:
    """Rows of a system as polynomials in the numbers of all its coordinates, the unknown ones
    first; None where they are none.
    """
    if len(coordinates) > _MOST_ANGLES or any(
        c.kind not in ("angle", "length") for c in coordinates
    ):
        return None
    symbols, none = ca.vertcat(system.unknown, system.known), ca.SX(0, 1)
    whole = System(coordinates, symbols, none, rows, rows, system.characteristic_length)
    entries = (*symbols.elements(), *rows.elements())
    return _found(_Asked(coordinates, tuple(e.element_hash() for e in entries), whole))


@dataclass(frozen=True)
class _Asked:
    """Rows that are asked for as polynomials, by the marks of their symbols and expressions: groups
    and kernels ask for the same ones.
    """

    coordinates: tuple[Coordinate, ...]
    marks: tuple[int, ...]
    system: System = field(compare=False)


@lru_cache(maxsize=32)
def _found(asked: _Asked) -> tuple[Ring, list[Polynomial]] | None:
    ring, system = Ring(asked.coordinates), asked.system
    try:
        found = polynomial_rows(ring, system, system.rows, {})
    except NotPolynomialError:
        return None
    tidy = [_tidied(row) for row in found]
    return None if any(len(row.terms) > _MOST_TERMS for row in tidy) else (ring, tidy)


def shortened(system: System, known: Sequence[Coordinate]) -> System:
    """The system with rows as polynomials of cosines and sines, where they are short ones."""
    found = polynomials_of(system.rows, system, (*system.unknowns, *known))
    if found is None:
        return system
    generators: list[ca.SX] = []
    for coordinates, values in ((system.unknowns, system.unknown), (known, system.known)):
        for k, c in enumerate(coordinates):
            generators += [ca.cos(values[k]), ca.sin(values[k])] if c.is_angular else [values[k]]
    rows = stacked(_value(row, ca.vertcat(*generators)) for row in found[1])
    return replace(system, rows=rows)


def _tidied(row: Polynomial) -> Polynomial:
    """The row without coefficients that are rounding."""
    numbers = {m: float(c) for m, c in row.terms.items()}
    largest = max((abs(v) for v in numbers.values()), default=0.0)
    return Polynomial(
        {m: ca.SX(snap(v)) for m, v in numbers.items() if abs(v) > _NOTHING * largest}
    )


def _polynomials(
    system: System, known: Sequence[Coordinate], state: ca.SX, numbers: ca.SX, *, collected: bool
) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX] | None:
    """Rows, Jacobian, symbols of the known values and what they are; None where rows are no short
    polynomials.
    """
    found = polynomials_of(system.rows, system, (*system.unknowns, *known))
    if found is None:
        return None
    ring, rows = found[0], [row.times(-1.0) for row in found[1]]
    count, size = state.numel(), system.characteristic_length
    generators = ca.vertcat(state, numbers)
    coefficients: list[ca.SX] = []
    written, jacobian = [], ca.SX(len(rows), system.freedom)
    for i, row in enumerate(rows):
        parts, values = _collected(row, count) if collected else _plain(row, count)
        symbols = [ca.SX.sym(f"b{i}_{k}") for k in range(len(values))]
        factors = [ca.SX(1), *(symbols if collected else (_value(p, generators) for p in values))]
        coefficients += (
            [(s, _value(p, generators)) for s, p in zip(symbols, values, strict=True)]
            if collected
            else []
        )
        written.append(_sum(factors, [_value(part, generators) for part in parts]))
        for j, c in enumerate(system.unknowns):
            scale = -1.0 / size if c.is_angular else -1.0
            slopes = [_value(_derivative(ring, part.times(scale), j), generators) for part in parts]
            jacobian[i, j] = _sum(factors, slopes)
    whole = [ca.vertcat(*written), jacobian]
    if not collected:
        return whole[0], whole[1], numbers, numbers
    symbol = stacked(s for s, _ in coefficients)
    return whole[0], whole[1], symbol, stacked(v for _, v in coefficients)


def _sum(factors: Sequence[ca.SX], values: Sequence[ca.SX]) -> ca.SX:
    total = ca.SX(0)
    for factor, value in zip(factors, values, strict=True):
        total = total + (value if factor.is_constant() else factor * value)
    return total


def _value(polynomial: Polynomial, generators: ca.SX) -> ca.SX:
    """A polynomial as an expression; products of generators are formed in one order, so that they
    are shared.
    """
    total = ca.SX(0)
    for monomial, coefficient in sorted(polynomial.terms.items()):
        product = ca.SX(1)
        for place, exponent in enumerate(monomial):
            for _ in range(exponent):
                product = (
                    generators[place] if product.is_constant() else product * generators[place]
                )
        total = total + (coefficient if product.is_constant() else coefficient * product)
    return total


def _derivative(ring: Ring, polynomial: Polynomial, unknown: int) -> Polynomial:
    """The derivative by a length or an angle."""
    places, found = ring.places[unknown], Polynomial({})
    for monomial, coefficient in polynomial.terms.items():
        for place in places:
            exponent = monomial[place]
            if not exponent:
                continue
            lower = tuple(e - (k == place) for k, e in enumerate(monomial))
            inner = ring.constant(1.0)
            if len(places) == 2:
                inner = (
                    ring.generator(places[1]).times(-1.0)
                    if place == places[0]
                    else ring.generator(places[0])
                )
            found = found.plus(ring.product(Polynomial({lower: exponent * coefficient}), inner))
    return _tidied(found)


def _split(row: Polynomial, count: int) -> Mapping[Monomial, dict[Monomial, float]]:
    """Coefficients of a row by monomials of the first `count` generators, and of the others."""
    found: dict[Monomial, dict[Monomial, float]] = {}
    for monomial, coefficient in row.terms.items():
        inner = tuple(e if k < count else 0 for k, e in enumerate(monomial))
        outer = tuple(0 if k < count else e for k, e in enumerate(monomial))
        found.setdefault(inner, {})[outer] = float(coefficient)
    return found


def _plain(row: Polynomial, count: int) -> tuple[list[Polynomial], list[Polynomial]]:
    """The row as what is free of known numbers and, for each monomial of these, a polynomial of the
    state.
    """
    found: dict[Monomial, dict[Monomial, ca.SX]] = {}
    for inner, outers in _split(row, count).items():
        for outer, value in outers.items():
            found.setdefault(outer, {})[inner] = ca.SX(value)
    one = next((outer for outer in found if not any(outer)), None)
    others = [outer for outer in found if outer != one]
    free = Polynomial(found[one]) if one is not None else Polynomial({})
    return [free, *(Polynomial(found[outer]) for outer in others)], [
        Polynomial({outer: ca.SX(1)}) for outer in others
    ]


def _collected(row: Polynomial, count: int) -> tuple[list[Polynomial], list[Polynomial]]:
    """The row as what is free of known numbers and, for each of few combinations of these, a
    polynomial of the state: coefficients of the state's monomials that are multiples of each other
    are one combination.
    """
    split = _split(row, count)
    outers = sorted({outer for part in split.values() for outer in part})
    vectors = {
        inner: np.array([part.get(outer, 0.0) for outer in outers]) for inner, part in split.items()
    }
    constant = np.array([0.0 if any(outer) else 1.0 for outer in outers])
    basis = _basis([v for v in vectors.values() if np.any(v * (1.0 - constant))], constant)
    matrix = np.array([constant, *basis]).T
    parts: list[dict[Monomial, ca.SX]] = [{} for _ in range(1 + len(basis))]
    for inner, vector in vectors.items():
        shares = np.linalg.lstsq(matrix, vector, rcond=None)[0]
        largest = float(np.max(np.abs(shares)))
        for part, share in zip(parts, shares, strict=True):
            if abs(share) > _NOTHING * largest:
                part[inner] = ca.SX(snap(float(share)))
    values = [
        Polynomial(
            {outer: ca.SX(snap(float(v))) for outer, v in zip(outers, b, strict=True) if v != 0.0}
        )
        for b in basis
    ]
    return [Polynomial(part) for part in parts], values


def _basis(vectors: Sequence[np.ndarray], constant: np.ndarray) -> list[np.ndarray]:
    """Vectors that span all of them, together with the constant: those first to which most others
    are parallel, largest part 1.
    """
    classes: list[list[np.ndarray]] = []
    for v in vectors:
        same = next((c for c in classes if abs(_sine(c[0], v)) < _PARALLEL), None)
        if same is None:
            classes.append([v])
        else:
            same.append(v)
    found: list[np.ndarray] = []
    for group in sorted(classes, key=len, reverse=True):
        matrix = np.array([constant, *found, group[0] / np.max(np.abs(group[0]))])
        singular = np.linalg.svd(matrix, compute_uv=False)
        if singular[-1] > _PARALLEL * singular[0] and len(singular) == len(matrix):
            found.append(group[0] / group[0][int(np.argmax(np.abs(group[0])))])
    return found


def _sine(a: np.ndarray, b: np.ndarray) -> float:
    u, v = a / np.linalg.norm(a), b / np.linalg.norm(b)
    return float(np.linalg.norm(u - (u @ v) * v))
