"""Write a transmission as one Python file of array operations: NumPy, JAX, any array API.

What formulas give is written as it is; the other way takes a fixed number of Newton steps of the
same rows from a polynomial that is fitted over the range, or from a told guess. Its last two steps
begin at the solution to half of its digits and further, so that derivatives through them are exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import casadi as ca
import numpy as np

from symkin._version import __version__
from symkin.codegen.map.transmission_rows import Formula, TransmissionRows
from symkin.codegen.text.languages import ARRAY_NAMES, python_language
from symkin.codegen.text.printer import Printer
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.text import docstring_line
from symkin.transmissions.transmission_result import Transmission

_XP = python_language("xp", ARRAY_NAMES, "t")
_DEGREES = {1: 12, 2: 6, 3: 4}
"""Degree of the fitted start by so many motors; of more it is 2."""
_MOST_STEPS = 10
_SETTLED = 1e-7
"""Change of a Newton step after which two more leave rounding, in values and second derivatives."""
_WIDER = 0.05
"""Share of the sampled box by which values may leave it without a guess."""


@dataclass(frozen=True, eq=False)
class _Way:
    """One way of the map: by a formula, or by Newton steps from a start over the sampled range."""

    name: str
    known: ca.SX
    unknown: ca.SX
    formula: Formula | None
    known_samples: np.ndarray
    samples: np.ndarray
    rows: ca.SX

    @cached_property
    def step(self) -> ca.SX:
        return self.unknown - ca.solve(ca.jacobian(self.rows, self.unknown), self.rows)

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """The known values that were sampled, a little wider."""
        low, high = self.known_samples.min(axis=0), self.known_samples.max(axis=0)
        return low - _WIDER * (high - low), high + _WIDER * (high - low)

    @cached_property
    def start(self) -> ca.SX:
        """A polynomial of the known values by least squares."""
        low, high = self.box
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        monomials = _monomials(len(middle))
        inside = (self.known - middle) / half
        terms = [math.prod((inside[k] for k in m), start=ca.SX(1)) for m in monomials]
        scaled = (self.known_samples - middle) / half
        matrix = np.stack([np.prod(scaled[:, list(m)], axis=1) for m in monomials], axis=1)
        factors = np.linalg.lstsq(matrix, self.samples, rcond=None)[0]
        return ca.mtimes(ca.SX(ca.DM(factors.T)), ca.vertcat(*terms))

    @cached_property
    def steps(self) -> int:
        """Newton steps after which all samples that settle have settled, and two more."""
        begin = ca.Function("start", [self.known], [self.start])
        step = ca.Function("step", [self.known, self.unknown], [self.step])
        known = self.known_samples.T
        found = np.asarray(begin.map(known.shape[1])(known))
        mapped, needed = step.map(known.shape[1]), 1
        for count in range(1, _MOST_STEPS + 1):
            after = np.asarray(mapped(known, found))
            change = np.abs(after - found).max(axis=0)
            close = np.abs(after - self.samples.T).max(axis=0) < _SETTLED
            if (close & (change > _SETTLED)).any():
                needed = count
            found = after
        return needed + 2


def array_source(transmission: Transmission) -> str:
    """The file of a transmission with as many motors as joints. Raises InputError."""
    linkage = transmission.linkage
    if len(linkage.motors) != len(linkage.joints):
        raise InputError(
            f"{transmission.name}: array files have as many motors as joints; these are "
            f"{len(linkage.motors)} and {len(linkage.joints)}"
        )
    rows, states = TransmissionRows(linkage), transmission.survey.states
    equations = rows.rows
    direct = _Way("joints", rows.m, rows.j, rows.joints_of, states.motors, states.joints, equations)
    inverse = _Way(
        "motors", rows.j, rows.m, rows.motors_of, states.joints, states.motors, equations
    )
    both = [(rows.m, "m"), (rows.j, "j")]
    parts = [
        _head(transmission),
        *_way_lines(direct, "m"),
        *_way_lines(inverse, "j"),
        *_function("_rows", both, equations),
        *_function("_by_joints", both, _by_row(equations, rows.j)),
        *_function("_by_motors", both, _by_row(equations, rows.m)),
        *_bends(rows, both),
        _body(direct, "motors", "joints", _turning(transmission, linkage.joints)),
        _body(inverse, "joints", "motors", _turning(transmission, linkage.motors)),
        _DERIVATIVES.format(n=len(linkage.joints)),
    ]
    return "\n".join(parts)


def _by_row(rows: ca.SX, symbols: ca.SX) -> ca.SX:
    """Rows and their derivatives, row by row: r1, dr1/ds1, dr1/ds2, ..., r2, ..."""
    return ca.vec(ca.horzcat(rows, ca.jacobian(rows, symbols)).T)


def _bends(rows: TransmissionRows, both: list[tuple[ca.SX, str]]) -> list[str]:
    """The function of the rows' second derivatives along two motors each, row by row, where the
    joints' rates by the motors, row by row, are given as well.
    """
    n, symbols = rows.m.shape[0], ca.vertcat(rows.m, rows.j)
    slopes = ca.SX.sym("s", n * n)
    motions = ca.vertcat(ca.SX.eye(n), ca.reshape(slopes, n, n).T)
    along = [ca.jtimes(rows.rows, symbols, motions[:, a]) for a in range(n)]
    bent = [
        ca.jtimes(along[min(a, b)], symbols, motions[:, max(a, b)])
        for a in range(n)
        for b in range(n)
    ]
    return _function("_bends", [*both, (slopes, "s")], ca.vec(ca.horzcat(*bent).T))


def _monomials(n: int) -> list[tuple[int, ...]]:
    """Numbers of the factors of all monomials of n variables up to the degree for so many."""
    degrees = range(_DEGREES.get(n, 2) + 1)
    return [m for degree in degrees for m in combinations_with_replacement(range(n), degree)]


def _turning(transmission: Transmission, names: Sequence[str]) -> tuple[float, ...]:
    """A turn for each angle, of which whole ones are the same place, and 0 for others."""
    return tuple(
        2.0 * math.pi if c.is_periodic else 0.0 for c in transmission.linkage.coordinates_of(names)
    )


# --- text -----------------------------------------------------------------------------------------


def _function(name: str, arguments: list[tuple[ca.SX, str]], values: ca.SX) -> list[str]:
    """A function of numbers or arrays that returns a tuple."""
    names = [[f"{prefix}{k}" for k in range(symbol.shape[0])] for symbol, prefix in arguments]
    function = ca.Function("f", [s for s, _ in arguments], [ca.densify(values)], {"cse": True})
    printer = Printer(function, names, _XP)
    entries = [printer.value(0, k) for k in range(function.numel_out(0))]
    symbols = ca.vertcat(*(symbol for symbol, _ in arguments))
    depends = ca.which_depends(ca.densify(ca.vec(values)), symbols, 1, True)
    like = names[-1][-1]
    shaped = [e if d else f"{e} + 0.0 * {like}" for e, d in zip(entries, depends, strict=True)]
    return [
        "",
        "",
        f"def {name}({', '.join(['xp', *(n for part in names for n in part)])}):",
        *(f"    {line}" for line in printer.lines),
        "    return (",
        *(f"        {entry}," for entry in shaped),
        "    )",
    ]


def _way_lines(way: _Way, known: str) -> list[str]:
    """The function of one way: its formula, or where its Newton steps start."""
    if way.formula is not None:
        arguments = [(way.formula.signs, "s"), (way.known, known)]
        return _function(f"_{way.name}", arguments, way.formula.values)
    return _function(f"_{way.name}_start", [(way.known, known)], way.start)


def _body(way: _Way, given: str, found: str, turning: tuple[float, ...]) -> str:
    if way.formula is not None:
        signs = tuple(float(s) for s in way.formula.at_reference)
        return _BY_FORMULA.format(given=given, found=found, signs=signs, turning=turning)
    low, high = way.box
    order = ("known", "{}") if given == "motors" else ("{}", "known")
    return _BY_NEWTON.format(
        given=given,
        found=found,
        steps=way.steps,
        low=tuple(low.tolist()),
        high=tuple(high.tolist()),
        values_found=", ".join(order).format("found"),
        values_start=", ".join(order).format("start"),
    )


def _head(transmission: Transmission) -> str:
    linkage, mechanism = transmission.linkage, transmission.linkage.mechanism
    names = [docstring_line(", ".join(n)) for n in (linkage.motors, linkage.joints)]
    return _HEAD.format(
        name=docstring_line(mechanism.name),
        motors=names[0],
        joints=names[1],
        unit=mechanism.length_unit,
        version=__version__,
        motor_names=tuple(linkage.motors),
        joint_names=tuple(linkage.joints),
    )


_HEAD = '''"""{name}: the transmission between motors ({motors})
and joints ({joints}).

Angles are in radians, lengths in {unit}. Arrays have the coordinates along their last axis and any
leading axes; `xp` is their library: numpy, jax.numpy, or another with the functions of the array
API. Loops have fixed lengths: the functions may be compiled, mapped and differentiated, and their
derivatives are those of the transmission.

The mode is that of the description's reference. NaN is told where a value cannot be reached in it,
where a guess is nearer to another, and where motors and joints do not belong together.

    joints(motors, guess=None)     motors(joints, guess=None)
    jacobian(motors, joints)       d joints / d motors (..., joints, motors)
    second(motors, joints)         d2 joints / d motors2 (..., joints, motors, motors)
    residual(motors, joints)       what is zero where they belong together

Generated by symkin {version}.
"""

import itertools

import numpy

MOTORS = {motor_names!r}
JOINTS = {joint_names!r}
CLOSED = 256.0
"""Roundings of 1 that an answer may leave as its residual."""
BELONG = 1e-5
"""Residual up to which motors and joints belong together."""
NEAR = 0.5
"""Relative change of the slopes between start and end of Newton's iteration: beyond it another
mode may be nearer to the start.
"""


def _columns(values, xp):
    values = xp.asarray(values)
    return [values[..., k] for k in range(values.shape[-1])]


def _matrices(function, values, shape, xp):
    """What a function of numbers returns, as arrays of this shape in the last axes."""
    columns = [column for part in values for column in _columns(part, xp)]
    found = xp.stack(function(xp, *columns), axis=-1)
    return xp.reshape(found, (*found.shape[:-1], *shape))


def _kept(values, xp):
    """The same values: a product with 1 that compilers do not melt into what reads it, so that they
    compute it once.
    """
    return xp.matmul(values, xp.eye(values.shape[-1]))


def _system(function, m, j, xp):
    """The rows and their derivatives."""
    n = len(MOTORS)
    found = _kept(_matrices(function, (m, j), (n * (n + 1),), xp), xp)
    found = xp.reshape(found, (*found.shape[:-1], n, n + 1))
    return found[..., :1], found[..., 1:]


def _inverse(a, xp):
    if a.shape[-1] == 1:
        return 1.0 / a
    if a.shape[-1] > 2:
        return xp.linalg.inv(a)
    p, q, r, s = a[..., 0, 0], a[..., 0, 1], a[..., 1, 0], a[..., 1, 1]
    rows = [xp.stack([s, -q], axis=-1), xp.stack([-r, p], axis=-1)]
    return xp.stack(rows, axis=-2) / (p * s - q * r)[..., None, None]


def _turned(values, guess, turns, xp):
    """Values moved by whole turns next to a guess."""
    parts = [
        values[..., k] + turn * xp.round((guess[..., k] - values[..., k]) / turn)
        if turn
        else values[..., k]
        for k, turn in enumerate(turns)
    ]
    return xp.stack(parts, axis=-1)'''

_BY_FORMULA = '''

def {found}({given}, guess=None, xp=numpy):
    """The {found} (..., n) at {given} (..., n), angles within half a turn of the reference's or of
    the guess.
    """
    known, signs = _columns({given}, xp), {signs}
    found = xp.stack(_{found}(xp, *signs, *known), axis=-1)
    if guess is None:
        return found
    guess, turns = xp.asarray(guess), {turning}
    found = _turned(found, guess, turns, xp)
    own = xp.sum((found - guess) ** 2, axis=-1)
    for other in itertools.product((1.0, -1.0), repeat=len(signs)):
        if other != signs:
            values = xp.stack(_{found}(xp, *other, *known), axis=-1)
            values = _turned(values, guess, turns, xp)
            nearer = xp.sum((values - guess) ** 2, axis=-1) < own
            found = xp.where(nearer[..., None], xp.nan, found)
    return found'''

_BY_NEWTON = '''

def {found}({given}, guess=None, xp=numpy):
    """The {found} (..., n) at {given} (..., n), by Newton steps from the guess, or from a
    polynomial that was fitted over the range.
    """
    known, fitted = xp.asarray({given}), guess is None
    columns = _columns(known, xp)
    start = xp.asarray(guess) if not fitted else xp.stack(_{found}_start(xp, *columns), axis=-1)
    start = _kept(start, xp)
    found = start
    for _ in range({steps} if fitted else {steps} + 4):
        rows, slopes = _system(_by_{found}, {values_found}, xp)
        found = found - xp.matmul(_inverse(slopes, xp), rows)[..., 0]
    rows, end = _system(_by_{found}, {values_found}, xp)
    begin = _system(_by_{found}, {values_start}, xp)[1]
    good = xp.max(xp.abs(rows[..., 0]), axis=-1) <= CLOSED * xp.finfo(found.dtype).eps
    change = xp.matmul(_inverse(end, xp), begin) - xp.eye(len(MOTORS))
    good = good & (xp.max(xp.sum(xp.abs(change), axis=-1), axis=-1) <= NEAR)
    if fitted:
        for value, low, high in zip(columns, {low}, {high}):
            good = good & (value >= low) & (value <= high)
    return xp.where(good[..., None], found, xp.nan)'''

_DERIVATIVES = '''

def residual(motors, joints, xp=numpy):
    """What is zero (..., n) where motors and joints belong together."""
    return _matrices(_rows, (motors, joints), ({n},), xp)


def _belonging(found, motors, joints, xp):
    belong = xp.max(xp.abs(residual(motors, joints, xp)), axis=-1) <= BELONG
    axes = (1,) * (found.ndim - belong.ndim)
    return xp.where(xp.reshape(belong, (*belong.shape, *axes)), found, xp.nan)


def jacobian(motors, joints, xp=numpy):
    """d joints / d motors (..., {n}, {n})."""
    m, j = xp.broadcast_arrays(xp.asarray(motors), xp.asarray(joints))
    by_joints, by_motors = (_system(f, m, j, xp)[1] for f in (_by_joints, _by_motors))
    return _belonging(-xp.matmul(_inverse(by_joints, xp), by_motors), m, j, xp)


def second(motors, joints, xp=numpy):
    """d2 joints / d motors2 (..., {n}, {n}, {n})."""
    m, j = xp.broadcast_arrays(xp.asarray(motors), xp.asarray(joints))
    by_joints, by_motors = (_system(f, m, j, xp)[1] for f in (_by_joints, _by_motors))
    inverse = _inverse(by_joints, xp)
    along = -xp.matmul(inverse, by_motors)
    along = xp.reshape(along, (*along.shape[:-2], {n} * {n}))
    flat = xp.matmul(inverse, _matrices(_bends, (m, j, along), ({n}, {n} * {n}), xp))
    return _belonging(-xp.reshape(flat, (*flat.shape[:-2], {n}, {n}, {n})), m, j, xp)
'''
