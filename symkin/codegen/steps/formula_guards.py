"""Decide which guards a closed form needs in C: divisors that no discriminant implies, and rows
that the formulas leave over.

A divisor A^2 + B^2 is no less than the discriminant A^2 + B^2 - C^2 beside it: where that one is
above zero, so is the divisor. All others are compared with a share of their usual size. Rows that
the derivation did not use (more rows than unknowns) hold only where the mechanism can take the
known values, so that the answer is put into all rows before it is called OK.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.elimination.closed_form import ClosedForm
from symkin.model.joint import Coordinate, units_of

RESOLVED = 32.0
"""Roundings of a root's usual size below which it is nothing: no configuration has the pose, or the
joint is not decided there.
"""
FEASIBLE = 1e-6
"""Share of the size by which given values may be off what the mechanism can take: they are
projected, as on the command line.
"""
_ROUNDINGS = 64.0
"""Roundings of the size that given values, rounded to the real type, and formulas leave in the
rows.
"""
_SMALL = 1e-3
"""Share of its usual size below which a divisor costs three digits: another way is taken where it
is so small at home.
"""
_STEEP = 4.0
"""How many times smaller than its bound the error is that roundings of known values make in rows of
formulas that are used.
"""
_PER_NUMBER = 4.0
"""Roundings of each known value that stand for those inside the formulas."""
_LOST = 30.0
"""Multiple of the roundings of known values by which answers may be off: a digit and a half. A limb
whose hinge is all but perpendicular to its slide, as a calibrated one is, loses more: given a pose
that the mechanism takes but for rounding, its formulas would pass on that rounding so enlarged.
"""
_SHARE = 0.9
"""Share of the configurations at which that must hold: beside a dead centre no formula is firm."""


def feasible_error(epsilon: float, size: float) -> float:
    """Largest error of a closure row, as a length, of values that the mechanism is said to take."""
    return max(FEASIBLE, _ROUNDINGS * epsilon) * size


def free_divisors(form: ClosedForm) -> list[int]:
    """Numbers of the divisors that may vanish while all discriminants are above zero."""
    return [j for j in range(form.divisors.numel()) if j not in form.implied]


def is_firm(form: ClosedForm, home: np.ndarray, near: np.ndarray, signs: np.ndarray) -> bool:
    """Whether no divisor is small at home beside what it is at other known values (n, known)."""
    free = free_divisors(form)
    usual = np.median(np.abs(form.divisors_at(near, signs)), axis=0)
    here = np.abs(form.divisors_at(home[None], signs))[0]
    return bool(np.all(here[free] > _SMALL * usual[free]))


def keeps_digits(
    form: ClosedForm,
    near: np.ndarray,
    signs: np.ndarray,
    known: Sequence[Coordinate],
    epsilon: float,
) -> bool:
    """Whether roundings of values (n, width) of the known coordinates leave the rows of the
    formulas' answers well within their bound, and the answers where they are to a digit and a half.
    """
    size, rng = form.system.characteristic_length, np.random.default_rng(12)
    rounding = _PER_NUMBER * epsilon
    scale = np.maximum(np.abs(near), units_of(known, size))
    moved = near + rounding * scale * rng.choice([-1.0, 1.0], near.shape)
    which = int(np.flatnonzero(np.all(form.choices == signs, axis=1))[0]) if len(signs) else 0
    before, after = (form.solutions(at).values[:, which] for at in (near, moved))
    with np.errstate(all="ignore"):
        residuals = form.system.residuals(after, moved)
        changes = np.max(np.abs(after - before) / units_of(form.system.unknowns, size), axis=1)
    return bool(
        _STEEP * _usual_largest(residuals) <= feasible_error(epsilon, size)
        and _usual_largest(changes) <= _LOST * rounding
    )


def _usual_largest(values: np.ndarray) -> float:
    """The largest of the values (n,) but for the share that may be beside a dead centre."""
    ordered = np.sort(np.where(np.isfinite(values), values, np.inf))
    return float(ordered[int(_SHARE * (len(values) - 1))])
