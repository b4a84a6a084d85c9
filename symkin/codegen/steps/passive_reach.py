"""Find where a limb's passive joints exist that have been taken out of its rows: rows without them
hold, too, where a limb whose joints do not turn its point to all of the sphere cannot stand.

By pose and actuated joints the passive ones have formulas, and exist where no discriminant is below
zero. One of the form A^2 + B^2 - C^2 never is where C is zero, as of a leg across the second axis
of a U joint whose axes are perpendicular; nothing is asked of such a joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from symkin.codegen.steps.formula_guards import RESOLVED
from symkin.codegen.steps.limbwise import given_coordinates, passive_system
from symkin.codegen.steps.newton_kernel import rounded
from symkin.codegen.steps.passive_limits import PassiveCheck
from symkin.codegen.steps.samples import Configuration
from symkin.codegen.text.c import Real
from symkin.elimination.closed_form import ClosedForm, closed_form
from symkin.numeric.system import System
from symkin.position.problem import Problem

_COMPARED = 4
"""Configurations at which coefficients of rows, or formulas for single values of the actuated
joints, are compared.
"""
_SAME = 1e-13
"""Relative spread, over configurations that close to rounding, of a value that is constant: C is
then below 1e-6 of A and B.
"""


def passive_reaches(
    problem: Problem,
    limb: System,
    samples: Sequence[Configuration],
    home: np.ndarray,
    real: Real,
) -> list[PassiveCheck] | None:
    """Where a limb's passive joints exist, on the reference's branch of them, by the pose of a
    direct problem and its known values: nothing where they exist everywhere, None where no formulas
    tell.
    """
    system = passive_system(problem, limb)
    if not system.unknowns:
        return []
    given = given_coordinates(problem)
    at = np.array([problem.select_values(s.values, system.unknowns) for s in samples])
    known = np.array([problem.select_values(s.values, given) for s in samples])
    form = closed_form(system, known[:_COMPARED])
    if form is None:
        return [] if _exist_at_each(system, at, known, len(samples[0].known)) else None
    signs = form.signs_at(
        problem.select_values(home, system.unknowns), problem.select_values(home, given)
    )
    values, squares = _values_of(form, known, signs)
    if not np.all(np.isfinite(values)):
        return None
    usual = np.sqrt(np.median(np.abs(values), axis=0))
    least = [rounded(v) for v in (RESOLVED * real.epsilon * usual) ** 2]
    texts = form.at_roots(form.discriminants, ca.sqrt)
    texts = ca.substitute(texts, form.signs, ca.SX(ca.DM(signs)))
    return [
        PassiveCheck(name, (texts[k],), *[f"{{0}} > {least[k]}"] * 2)
        for k, name in enumerate(form.names)
        if not _is_never_below_zero(values[:, k], squares)
    ]


def _exist_at_each(system: System, at: np.ndarray, known: np.ndarray, joints: int) -> bool:
    """Whether passive joints, of values (n, width), have formulas for single values of the actuated
    joints, the first `joints` of the known ones (n, known), and then exist everywhere.
    """
    values, squares, symbols = list[np.ndarray](), list[np.ndarray](), system.known[:joints]
    for unknown, row in zip(at[:_COMPARED], known[:_COMPARED], strict=True):
        rows, errors = (
            ca.substitute(part, symbols, ca.SX(ca.DM(row[:joints])))
            for part in (system.rows, system.errors)
        )
        form = closed_form(replace(system, rows=rows, errors=errors), known[:_COMPARED])
        if form is None:
            return False
        found = _values_of(form, row[None], form.signs_at(unknown, row))
        values.append(found[0])
        squares.append(found[1])
    if len({v.shape for v in values}) > 1 or len({s.shape for s in squares}) > 1:
        return False
    whole, sums = np.vstack(values), np.vstack(squares)
    return all(_is_never_below_zero(whole[:, k], sums) for k in range(whole.shape[1]))


def _values_of(
    form: ClosedForm, known: np.ndarray, signs: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Discriminants (n, choices), and divisors that are sums of squares, or less one (n, sums)."""
    divisors = form.divisors_at(known, signs)[:, sorted(form.squares)]
    return form.discriminants_at(known, signs), divisors


def _is_never_below_zero(values: np.ndarray, squares: np.ndarray) -> bool:
    """Whether a discriminant (n,) is constant, or a share of one of some sums of squares, or less
    one (n, sums), and not below zero.
    """
    sums = np.hstack([squares, np.ones((len(values), 1))])
    shares = values[:, None] / sums[:, np.all(sums != 0.0, axis=0)]
    largest = np.max(np.abs(shares), axis=0)
    return bool(np.all(values >= 0.0) and np.any(np.ptp(shares, axis=0) <= _SAME * largest))
