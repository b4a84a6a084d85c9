"""The equations of a robot's closures and couplings at a configuration of its tree.

Rows are lengths: directions and angles are multiplied by the robot's size. Directions are compared
as vectors, so that some rows are redundant; the rank and the least squares of a closure are those
of its constraint.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.computed_once import cached_property, lru_cache
from symkin.formats.robot import Closure, ClosureType
from symkin.formats.tree_motion import Placed, State, Tree
from symkin.model.graph import Coupling
from symkin.spatial.backend import Array, atan2, cross, dot
from symkin.spatial.rotation import multiply

ROWS: dict[ClosureType, int] = {"S": 3, "U": 4, "R": 5, "H": 5, "C": 4, "P": 5, "weld": 6}
"""Constraints that a closure of each type is counted with."""


@dataclass(frozen=True, eq=False)
class ConstraintRows:
    """All rows of a tree's closures and couplings: `places` are those of each, by its name;
    `expression` reads the symbols of the `state`, and of a `step` of all freedoms from there.
    """

    places: tuple[tuple[str, slice], ...]
    expression: ca.SX
    state: ca.SX
    step: ca.SX

    def values(self, state: State) -> np.ndarray:
        """The rows (n,) at a state."""
        return np.asarray(self._values(_numbers(state)).full()[:, 0])

    def rates(self, state: State) -> np.ndarray:
        """Their derivatives (n, freedoms) by a step, as `Tree.moved` takes it."""
        return np.asarray(self._rates(_numbers(state)).full())

    @cached_property
    def _values(self) -> ca.Function:
        return self._at_no_step("values", self.expression)

    @cached_property
    def _rates(self) -> ca.Function:
        return self._at_no_step("rates", ca.jacobian(self.expression, self.step))

    def _at_no_step(self, name: str, expression: ca.SX) -> ca.Function:
        here = ca.substitute(expression, self.step, ca.SX.zeros(*self.step.shape))
        return ca.Function(name, [self.state], [ca.densify(here)], {"cse": True})


@lru_cache(maxsize=4)
def constraint_rows(tree: Tree) -> ConstraintRows:
    """The rows of a tree's closures and couplings, as functions of its state.

    A ball at the quaternion q is at (1, r/2) q after a small step r; the norm is 1 to first order.
    """
    state, moved, step = [ca.SX(0, 1)], [], ca.SX.sym("step", tree.freedom)
    for motion, place in zip(tree.steps, tree.places, strict=True):
        own = ca.SX.sym("value", 4 if motion.kind == "ball" else 1)
        state.append(own)
        moved.append(
            multiply(ca.vertcat(1.0, 0.5 * step[place]), own)
            if motion.kind == "ball"
            else own + step[place]
        )
    placed = tree.placed(moved)
    parts = [(c.name, _closure_rows(c, placed, tree.size)) for c in tree.robot.closures]
    parts += [
        (f"coupling of {c.joint}", _coupling_row(c, tree, moved)) for c in tree.robot.couplings
    ]
    ends = np.cumsum([0, *(rows.shape[0] for _, rows in parts)]).tolist()
    places = [(n, slice(*ends[k : k + 2])) for k, (n, _) in enumerate(parts)]
    rows = ca.vertcat(ca.SX(0, 1), *(rows for _, rows in parts))
    return ConstraintRows(tuple(places), rows, ca.vertcat(*state), step)


def _numbers(state: State) -> np.ndarray:
    return np.concatenate([np.zeros(0), *state])


def _closure_rows(closure: Closure, placed: Placed, size: float) -> Array:
    """What is zero where a closure is closed (n,)."""
    pair = _Pair(closure, placed, size)
    return ca.vertcat(*(part(pair) for part in _PARTS[closure.type]))


def _coupling_row(coupling: Coupling, tree: Tree, state: Sequence[Array]) -> Array:
    """joint - sum of factor x other - offset, or joint - polynomial of the other."""
    numbers = {step.name: k for k, step in enumerate(tree.steps)}
    own = numbers[coupling.joint]
    others = [state[numbers[name]] for name in coupling.names]
    told = (
        ca.polyval(ca.SX(coupling.polynomial[::-1]), others[0])
        if coupling.polynomial is not None
        else coupling.offset
        + sum(factor * x for (_, factor), x in zip(coupling.terms, others, strict=True))
    )
    return (tree.size if tree.steps[own].kind == "turn" else 1.0) * (state[own] - told)


class _Pair:
    """The two frames of a closure where they are displaced to."""

    def __init__(self, closure: Closure, placed: Placed, size: float) -> None:
        self.closure, self.placed, self.size = closure, placed, size
        first, second = closure.links
        self.ends = ((first, closure.first), (second, closure.second))

    def gap(self) -> Array:
        """From the first frame's origin to the second's."""
        a, b = (self.placed.point(link, np.asarray(frame.position)) for link, frame in self.ends)
        return b - a

    def axis(self, end: int, number: int) -> Array:
        """An axis of one of the frames."""
        link, frame = self.ends[end]
        return self.placed.direction(link, np.asarray(frame.rotation)[:, number])

    def parallel(self, number: int) -> Array:
        """How an axis of the second frame differs from that of the first."""
        return self.size * (self.axis(1, number) - self.axis(0, number))

    def across(self) -> Array:
        """The gap square to the first frame's z axis."""
        return cross(self.gap(), self.axis(0, 2))

    def square(self) -> Array:
        """Cosine of the angle between the first frame's z axis and the second's x axis."""
        return self.size * dot(self.axis(0, 2), self.axis(1, 0))

    def screwed(self) -> Array:
        """The gap along the z axis less what the turn about it advances."""
        x, y, z, turned = (self.axis(0, 0), self.axis(0, 1), self.axis(0, 2), self.axis(1, 0))
        turn = atan2(dot(y, turned), dot(x, turned))
        return dot(self.gap(), z) - self.closure.pitch / (2.0 * np.pi) * turn


_PARTS: dict[ClosureType, tuple[Callable[[_Pair], Array], ...]] = {
    "S": (_Pair.gap,),
    "U": (_Pair.gap, _Pair.square),
    "R": (_Pair.gap, lambda pair: pair.parallel(2)),
    "C": (_Pair.across, lambda pair: pair.parallel(2)),
    "P": (_Pair.across, lambda pair: pair.parallel(2), lambda pair: pair.parallel(0)),
    "H": (_Pair.across, lambda pair: pair.parallel(2), _Pair.screwed),
    "weld": (_Pair.gap, lambda pair: pair.parallel(2), lambda pair: pair.parallel(0)),
}
