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
from symkin.model.joint import Coordinate

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
_SHARE = 0.9
"""Share of the configurations at which rows must be so near to zero: beside a dead centre no
formula is firm.
"""


def feasible_error(epsilon: float, size: float) -> float:
    """Largest error of a closure row, as a length, of values that the mechanism is said to take."""
    return max(FEASIBLE, _ROUNDINGS * epsilon) * size


def _sizes(form: ClosedForm, known: Sequence[Coordinate]) -> np.ndarray:
    """The size of each known value: of lengths the machine's, of all others 1."""
    return np.array(
        [
            form.system.characteristic_length if c.kind == "length" else 1.0
            for c in known
            for _ in range(c.width)
        ]
    )


def free_divisors(form: ClosedForm) -> list[int]:
    """Numbers of the divisors that may vanish while all discriminants are above zero."""
    return [j for j in range(int(form.divisors.shape[0])) if j not in form.implied]


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
    formulas' answers well within their bound.
    """
    size, rng = form.system.characteristic_length, np.random.default_rng(12)
    scale = np.maximum(np.abs(near), _sizes(form, known))
    moved = near + _PER_NUMBER * epsilon * scale * rng.choice([-1.0, 1.0], near.shape)
    which = int(np.flatnonzero(np.all(form.choices == signs, axis=1))[0]) if len(signs) else 0
    values = form.solutions(moved).values[:, which]
    with np.errstate(all="ignore"):
        residuals = form.system.residuals(values, moved)
    largest = np.sort(np.where(np.isfinite(residuals), residuals, np.inf))[
        int(_SHARE * (len(residuals) - 1))
    ]
    return bool(_STEEP * largest <= feasible_error(epsilon, size))
