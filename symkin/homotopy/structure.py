"""One algebraic system for all blocks of one structure, so that its generic roots are sought once.

Rows of joints are trigonometric polynomials of degree 1 in each angle, of degree 2 in each length:
row i = sum over m of C_im(k) phi_m(z), phi_m products of 1, cos z_j, sin z_j (1, z_j, z_j^2). Which
coefficients vanish, and which are equal but for sign whatever the known values are, is the block's
structure: a dyad of revolute joints is two circles, wherever it stands and however long its links
are. The different coefficients are the known values of the structure's own system; its generic
roots serve every block whose paths from them all arrive.

Source: A. P. Morgan, A. J. Sommese, Coefficient-parameter polynomial continuation, Applied
Mathematics and Computation 29 (1989) 123-160.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial, reduce
from itertools import product

import casadi as ca
import numpy as np

from symkin.closure.numpy_code import vectorise
from symkin.computed_once import cached_property, lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem, complex_normal, first_of_each, known_root
from symkin.homotopy.body_on_rods import distances_of, universal_system_of
from symkin.homotopy.engine import newton, track
from symkin.homotopy.many_instances import plain_instances
from symkin.homotopy.monodromy import (
    Fibre,
    Known,
    Looping,
    TooManyRootsError,
    agreeing_searches,
    fibre,
    progress_of_searches,
    roots_beside,
)
from symkin.homotopy.seeds import random_known, regular
from symkin.homotopy.start_files import closure_key, kept_or_computed
from symkin.homotopy.tracker import TrackSettings
from symkin.homotopy.universal_start import universal_start
from symkin.homotopy.values import known_values
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem

MOST_UNKNOWNS = 4
"""Unknowns of a block at most: its rows have three to this power coefficients each."""
MOST_COEFFICIENTS = 30
"""Different coefficients of a block at most. Many of them are bound by rules beyond equality, which
rotations in space follow, so that random ones have many more roots.
"""
_NODES = {"angle": (0.0, np.pi, np.pi / 2), "length": (0.0, 1.0, -1.0)}
"""Values of an unknown from which a row's coefficients follow."""
_COEFFICIENTS = {
    "angle": np.array([[0.5, 0.5, 0.0], [0.5, -0.5, 0.0], [-0.5, -0.5, 1.0]]),
    "length": np.array([[1.0, 0.0, 0.0], [0.0, 0.5, -0.5], [-1.0, 0.5, 0.5]]),
}
"""Coefficients of 1, cos, sin (of 1, t, t^2) from the values at these nodes."""
_DRAWS = 3
"""Random known values at which coefficients are compared."""
_EQUAL = 1e-10
"""Difference of equal coefficients, over the largest of their row."""
_SEARCHES = 3
"""Second searches at most; the first that finds what is known settles the count."""
_POINTS, _NEWTON_STEPS = 256, 40
"""Random points, and Newton steps from each, that look for roots which loops do not reach."""
_SEARCH = "loops and random points, each to its end"
"""What finds a structure's roots: kept ones that loops alone found are not taken."""
_CLOSED = 1e-9
"""Largest last step of Newton's method at a root."""

Terms = tuple[tuple[tuple[int, int, int], ...], ...]
"""Of each row its terms: number of the product phi_m, number of the coefficient, sign."""


@dataclass(frozen=True, eq=False)
class Structure:
    """A structure's `system` and, for one block, its coefficients as a function of the block's
    known values (`data`).
    """

    system: AlgebraicSystem
    data: ca.Function

    @cached_property
    def _code(self) -> Callable[..., None]:
        return vectorise(self.data)

    def known(self, k: np.ndarray) -> np.ndarray:
        """Known values of the structure's system (coefficients, n) from those of the block's,
        (known, n).
        """
        numbers = np.zeros((k.shape[1], self.system.k.shape[0], 1), dtype=complex)
        self._code(np.asarray(k, dtype=complex), numbers)
        return numbers[:, :, 0].T


def structure_of(problem: Problem, system: AlgebraicSystem) -> Structure | None:
    """The structure of a block of a few joints, or of a body that six distances hold; None where
    its rows are no such polynomials, or more than its unknowns.
    """
    distances = distances_of(system)
    if distances is not None:
        held = Structure(
            universal_system_of(system.body),
            ca.Function("distances", [system.k], [ca.densify(distances)], {"cse": True}),
        )
        return held if _has_rows(problem, system, held) else None
    kinds = tuple(c.kind for c in system.unknowns)
    fits = (
        not system.projective
        and not system.eliminated
        and system.count == system.width <= MOST_UNKNOWNS
    )
    if (
        not fits
        or any(kind not in _NODES for kind in kinds)
        or any(c.least is not None for c in system.unknowns)
    ):
        return None
    coefficients = _coefficients(system, kinds)
    if not _is_whole(problem, system, kinds, coefficients):
        return None
    terms, places = _terms(problem, system, coefficients)
    if len(places) > MOST_COEFFICIENTS:
        return None
    data = ca.Function(
        "coefficients",
        [system.k],
        [ca.densify(ca.vertcat(*(coefficients[i, m] for i, m in places)))],
        {"cse": True},
    )
    return Structure(_system(kinds, terms), data)


def start_of_structure(problem: Problem, structure: Structure) -> Fibre | None:
    """The generic roots of a structure, found once and then kept; None where not all of them lead
    to roots of this block at random known values: its coefficients are special, and it has fewer.
    """
    if structure.system.projective:
        start: Fibre | None = universal_start()
    else:
        start, _ = kept_or_computed(
            closure_key(structure.system, _SEARCH),
            structure.system,
            lambda: _searched(structure.system),
        )
    if start is None:
        return None
    k = known_values(problem, random_known(problem, np.random.default_rng(3), near=True))
    _, plain = plain_instances(structure.system, start, structure.known(k[:, None]))
    return start if plain.all() else None


def _has_rows(problem: Problem, system: AlgebraicSystem, structure: Structure) -> bool:
    """Whether the block's rows are those of its structure, times factors that the unknowns do not
    enter: at random complex points of one instance their ratio is one number.
    """
    rng = np.random.default_rng(1)
    z = complex_normal(system.width * _DRAWS, rng).reshape(system.width, _DRAWS)
    one = known_values(problem, random_known(problem, rng, near=False)).astype(complex)
    k = np.repeat(one[:, None], _DRAWS, axis=1)
    own, shared = system.linearise(z, k)[0], structure.system.linearise(z, structure.known(k))[0]
    # the universal system begins with e.g = 0, a block ends with it
    ratio = own / np.roll(shared, -1, axis=1)
    return bool(
        np.isfinite(ratio).all()
        and (np.max(np.abs(ratio - ratio[0]), axis=0) <= 1e-6 * np.abs(ratio[0])).all()
    )


# --- coefficients ---------------------------------------------------------------------------------


def _coefficients(system: AlgebraicSystem, kinds: tuple[str, ...]) -> ca.SX:
    """Coefficients (rows, products) as expressions of the known values."""
    values = [
        ca.substitute(system.rows, system.z, ca.SX(ca.DM(nodes)))
        for nodes in product(*(_NODES[kind] for kind in kinds))
    ]
    inverse = reduce(np.kron, (_COEFFICIENTS[kind] for kind in kinds))
    return ca.mtimes(ca.horzcat(*values), ca.sparsify(ca.DM(inverse.T)))


def _drawn_known(problem: Problem, rng: np.random.Generator) -> np.ndarray:
    """Known values (known, draws) at which coefficients are compared."""
    return np.array(
        [known_values(problem, random_known(problem, rng, near=False)) for _ in range(_DRAWS)],
        dtype=complex,
    ).T


def _products(z: ca.SX, kinds: tuple[str, ...]) -> list[ca.SX]:
    """The products phi_m of an unknown vector, in the order of the coefficients."""
    factors = []
    for j, kind in enumerate(kinds):
        powers = (
            (ca.SX(1), z[j], z[j] ** 2)
            if kind == "length"
            else (ca.SX(1), ca.cos(z[j]), ca.sin(z[j]))
        )
        factors.append(powers)
    return [reduce(lambda a, b: a * b, chosen) for chosen in product(*factors)]


def _is_whole(
    problem: Problem, system: AlgebraicSystem, kinds: tuple[str, ...], coefficients: ca.SX
) -> bool:
    """Whether the rows are the sums of these products: they are equal at random complex points."""
    sums = ca.mtimes(coefficients, ca.vertcat(*_products(system.z, kinds)))
    code = vectorise(
        ca.Function("difference", [system.z, system.k], [ca.densify(ca.horzcat(system.rows, sums))])
    )
    rng = np.random.default_rng(1)
    z = complex_normal(system.width * _DRAWS, rng).reshape(system.width, _DRAWS)
    k = _drawn_known(problem, rng)
    both = np.zeros((_DRAWS, system.count, 2), dtype=complex)
    code(z, k, both)
    scale = np.max(np.abs(both), axis=(0, 2))
    return bool((np.max(np.abs(both[..., 0] - both[..., 1]), axis=0) <= 1e-9 * scale).all())


def _terms(
    problem: Problem, system: AlgebraicSystem, coefficients: ca.SX
) -> tuple[Terms, list[tuple[int, int]]]:
    """The terms of each row, and the place (row, product) of each different coefficient."""
    rng = np.random.default_rng(2)
    evaluate = vectorise(ca.Function("c", [system.k], [ca.densify(coefficients)]))
    k = _drawn_known(problem, rng)
    values = np.zeros((_DRAWS, *coefficients.shape), dtype=complex)
    evaluate(k, values)
    largest = np.max(np.abs(values))
    places: list[tuple[int, int]] = []
    rows = []
    for i in range(coefficients.shape[0]):
        terms = []
        for m in range(coefficients.shape[1]):
            mine = values[:, i, m]
            if np.max(np.abs(mine)) <= _EQUAL * largest:
                continue
            same = [
                (number, sign)
                for number, place in enumerate(places)
                for sign in (1, -1)
                if np.max(np.abs(values[:, *place] - sign * mine)) <= _EQUAL * largest
            ]
            number, sign = same[0] if same else (len(places), 1)
            if not same:
                places.append((i, m))
            terms.append((m, number, sign))
        rows.append(tuple(terms))
    return tuple(rows), places


@lru_cache(maxsize=256)
def _system(kinds: tuple[str, ...], terms: Terms) -> AlgebraicSystem:
    """The system of a structure: its unknowns have no names but numbers, and its lengths are in
    units of the size.
    """
    z = ca.SX.sym("z", len(kinds))
    count = 1 + max(number for row in terms for _, number, _ in row)
    k, phi = ca.SX.sym("k", count), _products(z, kinds)
    rows = [sum((sign * k[number] * phi[m] for m, number, sign in row), ca.SX(0)) for row in terms]
    numbered = enumerate(kinds, start=1)
    unknowns = tuple(Coordinate(f"z{j}", kind, "passive", (0.0,)) for j, kind in numbered)  # type: ignore[arg-type]
    return AlgebraicSystem(1.0, unknowns, z, k, ca.vertcat(*rows), ())


# --- generic roots --------------------------------------------------------------------------------


def _searched(system: AlgebraicSystem) -> tuple[Fibre | None, str]:
    """All roots for random complex coefficients: loops of the coefficients until a second search
    from other numbers finds no others, and until those of real coefficients come in conjugate
    pairs.
    """

    def points(rng: np.random.Generator, near: bool) -> tuple[np.ndarray, np.ndarray]:  # noqa: ARG001 - no reference here
        return complex_normal(system.width, rng), complex_normal(system.k.shape[0], rng)

    def search(seed: int, known: Known | None, bound: int | None) -> Fibre | None:  # noqa: ARG001 - each to its end
        rng = np.random.default_rng(seed)
        begin = partial(fibre, system, points, rng, seed, system.count, Looping())
        found = begin(known, progress_of_searches() if seed == 0 else None)
        fresh = None if found is None else _not_connected(system, found, seed)
        if found is None or fresh is None or not fresh.shape[1]:
            return found
        return begin((np.hstack([found.z, fresh]), found.k))

    try:
        return agreeing_searches(system, search, partial(_unpaired, system), _SEARCHES)
    except TooManyRootsError as error:
        return None, f"the search was given up after {error.args[0]} roots"


def _not_connected(system: AlgebraicSystem, start: Fibre, seed: int) -> np.ndarray:
    """Roots at the start's base that Newton's method finds there from random points, and loops did
    not: a root that is the same whatever the coefficients are is connected to no other.
    """
    rng = np.random.default_rng([seed, 2])
    z = complex_normal(system.width * _POINTS, rng).reshape(system.width, _POINTS)
    turns = [i for i, c in enumerate(system.unknowns) if c.is_periodic]
    z[turns] += rng.uniform(-np.pi, np.pi, (len(turns), _POINTS))
    ends, last = newton(system, z, start.k, _NEWTON_STEPS)
    ends = ends[:, last <= _CLOSED]
    ends = ends[:, regular(system, ends, np.repeat(start.k[:, None], ends.shape[1], axis=1))]
    ends = ends[:, first_of_each(system, ends)]
    return ends[:, known_root(system, start.z, ends) < 0]


def _unpaired(system: AlgebraicSystem, start: Fibre, seed: int) -> np.ndarray:
    """Roots at the start's base that are missing there: conjugates of roots for random real
    coefficients.
    """
    k = np.random.default_rng([seed, 1]).normal(size=system.k.shape[0]).astype(complex)
    tracked = track(system, start.z, start.k, k, TrackSettings(tolerance=1e-5))
    ends, last = newton(system, tracked.z[:, tracked.arrived], k)
    ends = ends[:, last <= _CLOSED]
    wanted = np.conj(ends)
    return roots_beside(system, start, wanted[:, known_root(system, ends, wanted) < 0], k)
