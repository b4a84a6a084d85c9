"""Find how far about the reference configuration a map is regular, and polynomials that come near
its values there.

About the reference the given coordinates lie in a box. Rays through it are followed in small steps:
where no determinant comes near zero, the wanted coordinates are one function of the given ones,
which polynomials approach. One step of Newton's method from these then gives the configuration that
straight lines from the reference lead to. Sampled, not proved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, product

import casadi as ca
import numpy as np

from symkin.codegen.map.joint_map import Direction, JointMap
from symkin.codegen.steps.samples import all_followed
from symkin.model.joint import Coordinate, units_of

_REACHES = (1.0, 0.8, 0.6, 0.45, 0.3, 0.2)
"""Half widths of the box that are tried: in radians, and in sizes over three."""
_KEPT = 0.9
"""Share of the half width that is used."""
_RAYS, _PARTS = 9, 4
"""Rays to points of each edge of the box, and points of a ray."""
_REGULAR = 0.1
"""Least determinant in the box, over that of the reference."""
_DEGREE = 3
_MOST_KNOWN = 2
_STEP_ERROR = 1e-4
"""Largest error after the one step (rad, or sizes): the line of a guess begins there."""


@dataclass(frozen=True, eq=False)
class HomeSheet:
    """Known values within `reach` of the reference's, in the unit of each; `values` are the wanted
    coordinates as an expression of the `known` ones less the reference's, off by at most `error`
    (rad, or sizes).
    """

    reach: np.ndarray
    known: ca.SX
    values: ca.SX
    error: float


def home_sheet(
    made: JointMap, direction: Direction, wanted: Sequence[Coordinate]
) -> HomeSheet | None:
    """The sheet about the reference; None where passive joints or more known values than two would
    make it long, or none is found.
    """
    if made.passive or len(direction.known) > _MOST_KNOWN or any(c.is_advancing for c in wanted):
        return None
    for reach in _REACHES:
        points = _followed_rays(made, direction, reach)
        found = None if points is None else _fitted(made, direction, wanted, reach, points)
        if found is not None:
            return found
    return None


def _units(made: JointMap, coordinates: Sequence[Coordinate], length: float) -> np.ndarray:
    return np.array(units_of(coordinates, length * made.size))


def _followed_rays(
    made: JointMap, direction: Direction, reach: float
) -> list[tuple[np.ndarray, np.ndarray]] | None:
    """Known values less the reference's, in shares of the reach, with the unknowns there; None
    where a ray meets a singularity.
    """
    problem, system = direction.problem, direction.problem.system
    begin, home = made.reference_of(direction.known), made.reference_of(direction.unknown)
    scale = reach * _units(made, direction.known, 1.0 / 3.0)
    least = _REGULAR * _determinants(system.linearise(home[None], begin[None])[1])[0]
    shares = np.array(
        [
            v
            for v in product(np.linspace(-1.0, 1.0, _RAYS), repeat=len(begin))
            if max(map(abs, v)) >= 1.0
        ]
    )
    parts, unknown = [], np.tile(home, (len(shares), 1))
    for part in range(1, _PARTS + 1):
        before, now = (begin + shares * p / _PARTS * scale for p in (part - 1, part))
        unknown, whole = all_followed(problem, unknown, before, now)
        if not whole.all() or _determinants(system.linearise(unknown, now)[1]).min() < least:
            return None
        parts.append([(share * part / _PARTS, z) for share, z in zip(shares, unknown, strict=True)])
    rays = (point for ray in zip(*parts, strict=True) for point in ray)
    return [(np.zeros(len(begin)), home), *rays]


def _determinants(matrices: np.ndarray) -> np.ndarray:
    """|det| (n,); 0 of matrices that are not square, of which no box is told."""
    square = matrices.shape[1] == matrices.shape[2]
    return np.abs(np.linalg.det(matrices)) if square else np.zeros(len(matrices))


def _fitted(
    made: JointMap,
    direction: Direction,
    wanted: Sequence[Coordinate],
    reach: float,
    points: list[tuple[np.ndarray, np.ndarray]],
) -> HomeSheet | None:
    """Polynomials by least squares; None where one step from them is still off."""
    n, scale = len(direction.known), reach * _units(made, direction.known, 1.0 / 3.0)
    exponents = [
        m for degree in range(_DEGREE + 1) for m in combinations_with_replacement(range(n), degree)
    ]
    shares = np.array([share for share, _ in points])
    order = [next(k for k, c in enumerate(direction.unknown) if c.name == w.name) for w in wanted]
    values = np.array([z for _, z in points])[:, order]
    basis = np.array([[np.prod([u[i] for i in m]) for m in exponents] for u in shares])
    coefficients = np.linalg.lstsq(basis, values, rcond=None)[0]
    units = _units(made, wanted, 1.0)
    error = float(np.max(np.abs(basis @ coefficients - values) / units))
    system, begin, worst = direction.problem.system, made.reference_of(direction.known), 0.0
    for (share, z), guess in zip(points, basis @ coefficients, strict=True):
        start = z.copy()
        start[order] = guess
        rows, jacobian = system.linearise_one(start, begin + share * scale)
        after = system.move(start[None], -np.linalg.lstsq(jacobian, rows, rcond=None)[0][None])[0]
        worst = max(worst, float(np.max(np.abs(after - z)[order] / units)))
    if worst > _STEP_ERROR:
        return None
    known = ca.SX.sym("u", n)
    expression = _nested(known, scale, exponents, coefficients)
    return HomeSheet(_KEPT * scale, known, expression, max(float(f"{error:.8g}"), 1e-6))


def _nested(
    known: ca.SX, scale: np.ndarray, exponents: list[tuple[int, ...]], coefficients: np.ndarray
) -> ca.SX:
    """The polynomials; monomials are shared, and numbers rounded as all that samples decide."""
    monomials = []
    for m in exponents:
        term = ca.SX(1)
        for i in m:
            term = known[i] if term.is_constant() else term * known[i]
        monomials.append(term)
    rows = []
    for column in coefficients.T:
        total = ca.SX(0)
        for m, term, value in zip(exponents, monomials, column, strict=True):
            factor = float(f"{float(value) / float(np.prod([scale[i] for i in m])):.6g}")
            total = total + factor * term
        rows.append(total)
    return ca.vertcat(*rows)
