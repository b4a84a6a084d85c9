"""The equations of a robot's closures and couplings at a configuration of its tree, with their
derivatives, in numbers.

Rows are lengths: directions and angles are multiplied by the robot's size. Directions are compared
as vectors, so that some rows are redundant; the rank and the least squares of a closure are those
of its constraint.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symkin.formats.robot import Closure, ClosureType
from symkin.formats.tree_motion import Placed, State, Tree
from symkin.model.graph import Coupling

ROWS: dict[ClosureType, int] = {"S": 3, "U": 4, "R": 5, "H": 5, "C": 4, "P": 5, "weld": 6}
"""Constraints that a closure of each type is counted with."""

Rows = tuple[np.ndarray, np.ndarray]
"""Values (n,) and derivatives (n, freedoms)."""


def closure_rows(closure: Closure, placed: Placed, size: float) -> Rows:
    """What is zero where a closure is closed."""
    builder = _Pair(closure, placed, size)
    parts = [part(builder) for part in _PARTS[closure.type]]
    return np.concatenate([values for values, _ in parts]), np.concatenate(
        [rates for _, rates in parts]
    )


def coupling_rows(coupling: Coupling, tree: Tree, state: State) -> Rows:
    """joint - sum of factor x other - offset, or joint - polynomial of the other."""
    numbers = {step.name: k for k, step in enumerate(tree.steps)}
    own, rates = numbers[coupling.joint], np.zeros((1, tree.freedom))
    rates[0, tree.places[own]] = 1.0
    value = float(state[own][0])
    if coupling.polynomial is not None:
        other = numbers[coupling.names[0]]
        polynomial = np.polynomial.Polynomial(coupling.polynomial)
        value -= float(polynomial(state[other][0]))
        rates[0, tree.places[other]] -= polynomial.deriv()(state[other][0])
    else:
        value -= coupling.offset
        for name, factor in coupling.terms:
            value -= factor * float(state[numbers[name]][0])
            rates[0, tree.places[numbers[name]]] -= factor
    scale = tree.size if tree.steps[own].kind == "turn" else 1.0
    return np.array([scale * value]), scale * rates


class _Pair:
    """The two frames of a closure where they are displaced to."""

    def __init__(self, closure: Closure, placed: Placed, size: float) -> None:
        self.closure, self.placed, self.size = closure, placed, size
        first, second = closure.links
        self.ends = ((first, closure.first), (second, closure.second))

    def gap(self) -> Rows:
        """From the first frame's origin to the second's."""
        (a, da), (b, db) = (
            self.placed.point(link, np.asarray(frame.position)) for link, frame in self.ends
        )
        return b - a, db - da

    def axis(self, end: int, number: int) -> Rows:
        """An axis of one of the frames."""
        link, frame = self.ends[end]
        return self.placed.direction(link, np.asarray(frame.rotation)[:, number])

    def parallel(self, number: int) -> Rows:
        """How an axis of the second frame differs from that of the first."""
        (a, da), (b, db) = self.axis(0, number), self.axis(1, number)
        return self.size * (b - a), self.size * (db - da)

    def across(self) -> Rows:
        """The gap square to the first frame's z axis."""
        (gap, rates), (z, dz) = self.gap(), self.axis(0, 2)
        return np.cross(gap, z), np.cross(rates, z, axisa=0, axisc=0) + np.cross(
            gap, dz, axisb=0, axisc=0
        )

    def square(self) -> Rows:
        """Cosine of the angle between the first frame's z axis and the second's x axis."""
        (z, dz), (x, dx) = self.axis(0, 2), self.axis(1, 0)
        return self.size * np.array([z @ x]), self.size * (z @ dx + x @ dz)[None]

    def screwed(self) -> Rows:
        """The gap along the z axis less what the turn about it advances."""
        (gap, rates), (z, dz) = self.gap(), self.axis(0, 2)
        (ax, _), (ay, _), (bx, _) = self.axis(0, 0), self.axis(0, 1), self.axis(1, 0)
        lead = self.closure.pitch / (2.0 * np.pi)
        spin = self.placed.spin(self.closure.links[1]) - self.placed.spin(self.closure.links[0])
        value = gap @ z - lead * np.arctan2(ay @ bx, ax @ bx)
        return np.array([value]), (z @ rates + gap @ dz - lead * (z @ spin))[None]


_PARTS: dict[ClosureType, tuple[Callable[[_Pair], Rows], ...]] = {
    "S": (_Pair.gap,),
    "U": (_Pair.gap, _Pair.square),
    "R": (_Pair.gap, lambda pair: pair.parallel(2)),
    "C": (_Pair.across, lambda pair: pair.parallel(2)),
    "P": (_Pair.across, lambda pair: pair.parallel(2), lambda pair: pair.parallel(0)),
    "H": (_Pair.across, lambda pair: pair.parallel(2), _Pair.screwed),
    "weld": (_Pair.gap, lambda pair: pair.parallel(2), lambda pair: pair.parallel(0)),
}
