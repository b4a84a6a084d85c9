"""State what one Newton iteration of generated code computes, as CasADi expressions.

A kernel solves rows(state; known) = 0. Its linear system is J step = rows with J = -d rows/d step,
and `moved` puts the step on: positions and joint values are added to, quaternions are turned by the
world-frame twist, so that no trigonometry is left in the loop of platforms on rods.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.snapping import snapped_expression
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.numeric.system import System, incidence_of
from symkin.spatial.backend import dot
from symkin.spatial.rotation import multiply

_SEED = 5
"""Of the directions in which curvatures are asked."""
_OWN_ROUNDING = 1e-12
"""Relative rounding of a bound's own computation, which differs from processor to processor."""


@dataclass(frozen=True)
class Meaning:
    """What the arrays of a kernel hold, for comments of the C; `each_row` says of each row what it
    is about.
    """

    state: str
    known: str
    rows: str
    step: str
    shared: str = ""
    each_row: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Kernel:
    """One system for Newton's method: rows(state; known) = 0.

    `rows` are functions of (state, known, geometry), with `shared` beside them: values that the
    Jacobian reads again. `jacobian` is one of (state, known, geometry, shared_symbols); `moved` and
    `norm` (squared length of the step, angles times the size) of (state, step). `row_length` times
    a row is a length. `is_pose`: the state is a position and a quaternion, whose length is one but
    for the rounding of steps. `quaternion` is where a unit quaternion begins in `known`, if it has
    one;
    `turns` are the places of known values in which the rows are bent, with how much of a radian a
    unit of each is. `meaning` says in comments of the C what state, known values, rows and shared
    values are.
    """

    name: str
    state: ca.SX
    known: ca.SX
    geometry: ca.SX
    step: ca.SX
    shared_symbols: ca.SX
    rows: ca.SX
    shared: ca.SX
    jacobian: ca.SX
    moved: ca.SX
    norm: ca.SX
    row_length: float
    characteristic_length: float
    meaning: Meaning
    is_pose: bool = False
    quaternion: int | None = None
    turns: tuple[tuple[int, float], ...] = ()

    @property
    def m(self) -> int:
        """Count of rows."""
        return self.rows.numel()

    @property
    def n(self) -> int:
        """Count of unknowns: entries of a step."""
        return self.step.numel()

    @property
    def is_square(self) -> bool:
        return self.m == self.n

    @property
    def is_wide(self) -> bool:
        """More unknowns than rows: steps are the shortest that solve the rows."""
        return self.n > self.m

    @property
    def reads_known(self) -> bool:
        """Whether J depends on the known values, not on the state alone."""
        whole = ca.substitute(self.jacobian, self.shared_symbols, self.shared)
        return bool(any(ca.which_depends(whole, self.known, 1, False)))

    def row_function(self) -> ca.Function:
        """Rows and shared values by (state, known, geometry)."""
        return ca.Function(
            "rows", [self.state, self.known, self.geometry], [self.rows, self.shared], {"cse": True}
        )

    def jacobian_function(self) -> ca.Function:
        """J = -d rows / d step by (state, known, geometry, shared)."""
        inputs = [self.state, self.known, self.geometry, self.shared_symbols]
        return ca.Function("jacobian", inputs, [self.jacobian], {"cse": True})

    def move_function(self) -> ca.Function:
        """The state after a step, and the step's squared length, by (state, step, geometry)."""
        return ca.Function(
            "move", [self.state, self.step, self.geometry], [self.moved, self.norm], {"cse": True}
        )

    def matrix(self, state: np.ndarray, known: np.ndarray, geometry: np.ndarray) -> np.ndarray:
        """J at a point, by CasADi."""
        rows, jacobian = self._sampled
        _, shared = rows(state, known, geometry)
        return ca.DM(jacobian(state, known, geometry, shared)).full()

    @cached_property
    def _sampled(self) -> tuple[ca.Function, ca.Function]:
        """The functions of rows and of J that `matrix` asks at every sample."""
        return self.row_function(), self.jacobian_function()


def system_kernel(
    name: str, system: System, known: Sequence[Coordinate], geometry: ca.SX
) -> Kernel:
    """Make the kernel of a position system: rows -F, J = dF/dd over the system's tangent space.

    `known` are the coordinates of the system's known values.
    """
    step = ca.SX.sym("s", system.freedom)
    size = system.characteristic_length
    _, moved = moves(system.unknowns, system.unknown, step, size, circles=False)
    symbols = [system.unknown, system.known, geometry]
    return Kernel(
        name=name,
        state=system.unknown,
        known=system.known,
        geometry=geometry,
        step=step,
        shared_symbols=ca.SX(0, 1),
        rows=snapped_expression(-system.rows, symbols),
        shared=ca.SX(0, 1),
        jacobian=snapped_expression(system.jacobian, symbols),
        moved=moved,
        norm=dot(step, step),
        row_length=1.0,
        characteristic_length=system.characteristic_length,
        meaning=Meaning(
            state=listed(system.unknowns),
            known=listed(known),
            rows="minus the closure's rows, lengths and angles times the size",
            step="changes of the state: lengths, angles and turns times the size",
            each_row=tuple(_about_row(system, used) for used in incidence_of(system.rows, system)),
        ),
        quaternion=quaternion_place(known),
        turns=bent_places(known, system.characteristic_length),
    )


def moves(
    coordinates: Sequence[Coordinate],
    state: ca.SX,
    step: ca.SX,
    size: float,
    *,
    circles: bool = True,
) -> tuple[ca.SX, ca.SX]:
    """dstate/dstep (numbers, freedom), and the state after a step, angles and turns of which are
    times the size. Quaternions, and angles where they are `circles`, cosine and sine, are moved by
    the arc whose tangent is the step.
    """
    tangent, moved, place, column = ca.SX(state.numel(), step.numel()), [], 0, 0
    for c in coordinates:
        if c.is_periodic and circles:
            cosine, sine, turn = state[place], state[place + 1], (1 / size) * step[column]
            tangent[place, column], tangent[place + 1, column] = -sine / size, cosine / size
            after = [cosine - sine * turn, sine + cosine * turn]
            inverse = 1 / ca.sqrt(after[0] * after[0] + after[1] * after[1])
            moved += [part * inverse for part in after]
            place += 1
        elif c.is_rotation:
            q, part = state[place : place + 4], step[column : column + 3]
            for k in range(3):
                axis = [0.0, 0.0, 0.0, 0.0]
                axis[k + 1] = 0.5 / size
                tangent[place : place + 4, column + k] = multiply(axis, q)
            turned = multiply(ca.vertcat(1, (0.5 / size) * part), q)
            inverse = 1 / ca.sqrt(dot(turned, turned))
            moved += [turned[k] * inverse for k in range(4)]
        else:
            scale = 1 / size if c.is_angular else 1.0
            tangent[place, column] = scale
            moved.append(state[place] + scale * step[column])
        place, column = place + c.width, column + c.freedom
    return tangent, ca.vertcat(*moved)


def _about_row(system: System, used: set[int]) -> str:
    """Names of the unknowns in a row."""
    return ", ".join(listed([system.unknowns[k]]) for k in sorted(used))


def curvature(
    kernel: Kernel,
    states: Sequence[np.ndarray],
    known: Sequence[np.ndarray],
    geometry: np.ndarray,
) -> float:
    """Estimate kappa of a typical pose: a Newton step s leaves an error of kappa |s|^2.

    kappa = |J^-1 (J(x + s) - J(x)) s| / (2 |s|^2), the ninth decile over states and random
    directions s.
    """
    rng = np.random.default_rng(_SEED)
    move = kernel.move_function()
    found = []
    for state, k in zip(states, known, strict=True):
        here = kernel.matrix(state, k, geometry)
        scale = np.max(np.abs(here), axis=0)
        step = rng.normal(size=kernel.n) / np.where(scale > 0, scale, 1.0)
        unit = float(move(state, step, geometry)[1])
        step *= (
            0.02 * kernel.characteristic_length / np.sqrt(unit)
        )  # a fiftieth of the size: far enough to see J change, near enough to stay local
        there, squared = move(state, step, geometry)
        change = (kernel.matrix(np.asarray(there).ravel(), k, geometry) - here) @ step
        second = np.linalg.lstsq(here, change, rcond=None)[0]
        found.append(0.5 * np.sqrt(float(move(state, second, geometry)[1])) / float(squared))
    return rounded(np.quantile(found, 0.9))


def sampled(
    kernel: Kernel,
    states: Sequence[np.ndarray],
    known: Sequence[np.ndarray],
    geometry: np.ndarray,
) -> tuple[np.ndarray, float]:
    """Matrices (count, m, n) at states with known values, and the curvature there."""
    matrices = [kernel.matrix(z, k, geometry) for z, k in zip(states, known, strict=True)]
    return np.array(matrices), curvature(kernel, states, known, geometry)


def rounded(value: float) -> float:
    """Round to three digits: generated constants must not depend on the last bits of a linear
    algebra library.
    """
    return float(f"{value:.3g}")


def rounded_up(value: float) -> float:
    """Round a bound to three digits, away from zero; one that three digits state but for its own
    rounding stays, on any processor.
    """
    near = rounded(value)
    if abs(near) >= abs(value) * (1.0 - _OWN_ROUNDING):
        return near
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 2)
    return rounded(near + math.copysign(step, value))


def quaternion_place(coordinates: Sequence[Coordinate]) -> int | None:
    """Where a quaternion begins among the numbers of coordinates; None where there is none."""
    start = 0
    for c in coordinates:
        if c.is_rotation:
            return start
        start += c.width
    return None


def bent_places(coordinates: Sequence[Coordinate], size: float) -> tuple[tuple[int, float], ...]:
    """Places of angles, and of rods' lengths, whose squares stand in rows; and what turns their
    unit into radians.
    """
    found, start = [], 0
    for c in coordinates:
        if c.is_periodic or c.least is not None:
            found.append((start, 1.0 if c.is_angular else 1.0 / size))
        start += c.width
    return tuple(found)


def listed(coordinates: Sequence[Coordinate]) -> str:
    """Names of coordinates in order, those of the platform as x, y, z, gamma or quaternion."""
    names = [c.name.removeprefix("pose.") for c in coordinates]
    return ", ".join(
        f"{name} (w, x, y, z)" if c.is_rotation else name
        for name, c in zip(names, coordinates, strict=True)
    )
