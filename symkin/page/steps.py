"""The steps by which the page finds all solutions: those of `modes`, each by its formulas, or by
complex solutions at generic known values from which paths lead to any others.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from symkin.assembly.closed_roots import closed_block
from symkin.assembly.group_solvers import (
    accounts_for_all,
    any_paths,
    solved_at_once,
    solved_parts,
)
from symkin.closure.numpy_code import vectorise
from symkin.codegen.text.javascript import complex_parts, javascript
from symkin.elimination.closed_form import ClosedForm
from symkin.homotopy.many_instances import instance
from symkin.homotopy.systems import meets_all_rows
from symkin.homotopy.values import complex_values, known_values
from symkin.position.gear_train import gear_train
from symkin.position.groups import is_linear, is_tied, structure_groups
from symkin.position.problem import Problem
from symkin.position.solution import Solution

_SPREAD = 0.5
"""How far generic known values lie from those of the start: in sizes and radians."""
_CLOSED, _ROUNDS = 1e-6, 4
"""Largest last step of Newton's method at a start, in sizes and radians, and steps at most."""


def groups_of(problem: Problem) -> list[Problem]:
    """The groups that the steps solve: in place of those that implied rows take apart their
    parts.
    """
    if problem.is_explicit or not problem.known_coordinates:
        return []
    return _leaves(structure_groups(problem))


def steps_of(
    groups: Sequence[Problem], solution: Solution, seeds: np.ndarray, columns: np.ndarray
) -> tuple[list[dict[str, Any]], list[str]]:
    """The steps as JSON, and their functions as JavaScript. Paths go from a configuration of the
    page's start on; of a step for which `modes` knows no complex solutions, from the `seeds`
    (n, variables) that it has met. `columns` are units of the variables.
    """
    steps, texts = [], []
    for number, group in enumerate(groups):
        step, text = _step(group, number, solution.variables, seeds, columns)
        steps.append(step)
        texts += text
    return steps, texts


def _leaves(groups: Sequence[Problem]) -> list[Problem]:
    found: list[Problem] = []
    for group in groups:
        parts = solved_parts(group)
        found += _leaves(parts) if parts else [group]
    return found


def _step(
    group: Problem, number: int, start: np.ndarray, seeds: np.ndarray, columns: np.ndarray
) -> tuple[dict[str, Any], list[str]]:
    x = group.closure.variables
    system = group.system
    rows = ca.vertcat(
        system.rows / group.closure.characteristic_length, system.norms(system.unknown)
    )
    gradients = ca.jacobian(rows, x) @ ca.diag(ca.SX(ca.DM(columns)))
    starts = _starts(group, start, seeds, rows, gradients, columns)
    step = {
        "number": number,
        "known": group.known_places.tolist(),
        "unknown": group.unknown_places.tolist(),
        "rows": 2 * rows.shape[0],
        "starts": [np.column_stack([z.real, z.imag]).ravel().tolist() for z in starts],
        "signs": None,
        "margins": 0,
    }
    texts = [_over_complex(f"step{number}", x, rows, gradients)]
    form = _formulas(group)
    if form is not None:
        values, discriminants, margins = form.judged
        inputs = ca.vertcat(x, form.signs)
        outputs = [values, discriminants, margins]
        texts.append(javascript(f"branches{number}", inputs, [ca.densify(v) for v in outputs]))
        step |= {"signs": form.choices.tolist(), "margins": margins.shape[0]}
    return step, texts


def _over_complex(name: str, x: ca.SX, rows: ca.SX, gradients: ca.SX) -> str:
    """The function of a step's rows over pairs of numbers, as a real system of twice the size:
    gradients a + ib are [[a, -b], [b, a]].
    """
    parts, (values, slopes) = complex_parts(x, [rows, gradients])
    one, turn = ca.DM.eye(2), ca.sparsify(ca.DM([[0, -1], [1, 0]]))
    matrix = ca.kron(slopes[0], one) + ca.kron(slopes[1], turn)
    return javascript(name, parts, [ca.vec(ca.horzcat(*values).T), matrix])


def _formulas(group: Problem) -> ClosedForm | None:
    """The formulas of a group that account for all its solutions."""
    if solved_at_once(group):
        return None
    closed = closed_block(group)
    if closed is None or not isinstance(closed.formulas, ClosedForm):
        return None
    return closed.formulas if accounts_for_all(closed) else None


def _starts(
    group: Problem,
    start: np.ndarray,
    seeds: np.ndarray,
    rows: ca.SX,
    gradients: ca.SX,
    columns: np.ndarray,
) -> np.ndarray:
    """Solutions (n, known + unknown values), real where no path from them meets a singularity or no
    others are known.
    """
    places = np.concatenate([group.known_places, group.unknown_places])
    if is_linear(group):
        return start[None, places].astype(complex)
    train = gear_train(group)
    if train is not None:
        known = start[None, group.known_places]
        unknown = train.solutions(known)[0]
        return np.hstack([np.repeat(known, len(unknown), axis=0), unknown]).astype(complex)
    paths = any_paths(group)
    if paths is None:
        # values that must agree with each other lead from no solution to others
        return seeds[: 0 if is_tied(group) else None, places].astype(complex)
    known = _generic_known(group, start, columns)
    k = known_values(group, known[:, None])
    k = k if paths.shared is None else paths.shared.known(k)
    z = instance(paths.algebraic, paths.start, k[:, 0]).isolated
    k = np.repeat(k, z.shape[1], axis=1)
    if paths.combined:
        z = z[:, meets_all_rows(group, paths.algebraic, z, k)]
    found = np.zeros((z.shape[1], len(start)), dtype=complex)
    found[:, group.known_places] = known
    named = complex_values(group, paths.algebraic, z)
    values = (
        named.values()
        if paths.shared is not None and not paths.algebraic.projective
        else (named[c.name] for c in group.system.unknowns)
    )
    found[:, group.unknown_places] = np.hstack(list(values))
    return _polished(group, found, rows, gradients, columns)[:, places]


def _generic_known(group: Problem, start: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Complex known values about those of a configuration, quaternions of unit length."""
    rng, places = np.random.default_rng(5), group.known_places
    away = rng.uniform(-_SPREAD, _SPREAD, (2, len(places)))
    values = start.astype(complex)
    values[places] += columns[places] * (away[0] + 1j * away[1])
    for c in group.known_coordinates:
        if c.is_rotation:
            place = group.closure.slices[c.name]
            values[place] /= np.sqrt(np.sum(values[place] ** 2))
    return np.asarray(values[places])


def _polished(
    group: Problem, points: np.ndarray, rows: ca.SX, gradients: ca.SX, columns: np.ndarray
) -> np.ndarray:
    """The points (n, variables) that Newton's method on the step's rows leaves where they are, to
    rounding.
    """
    x, unknown = group.closure.variables, group.unknown_places
    evaluate = vectorise(ca.Function("step", [x], [rows, ca.densify(gradients)], {"cse": True}))
    values, count = points.copy(), rows.shape[0]
    length = np.zeros(len(values))
    for _ in range(_ROUNDS):
        f = np.zeros((len(values), count, 1), dtype=complex)
        jacobian = np.zeros((len(values), count, values.shape[1]), dtype=complex)
        evaluate(values.T, f, jacobian)
        step = -(np.linalg.pinv(jacobian[:, :, unknown]) @ f)[:, :, 0]
        values[:, unknown] += columns[unknown] * step
        length = np.max(np.abs(step), axis=1, initial=0.0)
    moved = np.max(np.abs(values - points) / columns, axis=1, initial=0.0)
    large = 1.0 + np.max(np.abs(values) / columns, axis=1, initial=0.0)
    return values[(length < _CLOSED * large) & (moved < 1e-3 * large)]
