"""Solutions of a plain closure by damped least squares from random starts, and whether they are
isolated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oracle.plain_closure import PlainMechanism, quaternion_matrix

CLOSED = 1e-9
"""Largest closure error of a solution, over the size."""
STEPS = 60
FREE = 1e-7
"""A singular value below this share of the largest is none."""
REGULAR = 1e-5
"""A solution whose least other singular value is above this share of the largest counts as
regular.
"""


@dataclass(frozen=True)
class Found:
    """A solution, whether the named coordinates and the pose are determined there, and whether
    clearly so.
    """

    x: np.ndarray
    isolated: bool
    regular: bool


def solve(m: PlainMechanism, x: np.ndarray, columns: np.ndarray, steps: int = STEPS) -> np.ndarray:
    """Levenberg-Marquardt of all rows in some tangent columns, from all configurations (n, numbers)
    at once.
    """
    damping = np.full(len(x), 1e-2)
    r, j = m.closure(x)
    for _ in range(steps):
        if not columns.size or np.max(np.abs(r), initial=0.0) < 1e-14 * m.size:
            break
        a = j[:, :, columns]
        normal = np.einsum("nri,nrj->nij", a, a)
        gradient = np.einsum("nri,nr->ni", a, r)
        normal[:, np.arange(columns.size), np.arange(columns.size)] += damping[:, None] + 1e-15
        step = np.zeros((len(x), m.freedom))
        step[:, columns] = -_solved(normal, gradient)
        far = np.linalg.norm(step, axis=1, keepdims=True)
        step *= np.minimum(1.0, m.size / np.maximum(far, 1e-300))
        trial = m.move(x, step)
        r_trial, j_trial = m.closure(trial)
        better = np.sum(r_trial**2, axis=1) < np.sum(r**2, axis=1)
        x = np.where(better[:, None], trial, x)
        r, j = np.where(better[:, None], r_trial, r), np.where(better[:, None, None], j_trial, j)
        damping = np.clip(np.where(better, damping / 5, damping * 4), 1e-13, 1e3)
    return x


def _solved(normal: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    """Solutions of symmetric systems, least ones where a matrix is singular to rounding."""
    try:
        return np.asarray(np.linalg.solve(normal, gradient[:, :, None])[:, :, 0])
    except np.linalg.LinAlgError:
        return np.asarray((np.linalg.pinv(normal, hermitian=True) @ gradient[:, :, None])[:, :, 0])


def random_configurations(
    m: PlainMechanism, x: np.ndarray, free: Sequence[int], rng: np.random.Generator
) -> np.ndarray:
    """Configurations with the coordinates at places `free` anywhere: lengths about the reference,
    by the mechanism's reach.
    """
    x = x.copy()
    reach = 1.5 * m.size + max(
        (abs(x[:, m.slices[i]]).max() for i, n in enumerate(m.numbers) if n.kind == "length"),
        default=0.0,
    )
    for i in free:
        number, place = m.numbers[i], m.slices[i]
        if number.kind == "quaternion":
            q = rng.normal(size=(len(x), 4))
            x[:, place] = q / np.linalg.norm(q, axis=1, keepdims=True)
        elif number.kind == "length":
            x[:, place] = m.reference[place] + reach * rng.uniform(-1, 1, (len(x), 1))
        else:
            x[:, place] = number.value[0] + rng.uniform(-np.pi, np.pi, (len(x), 1))
    return x


def solutions(
    m: PlainMechanism, known: np.ndarray, free: Sequence[int], starts: int, rng: np.random.Generator
) -> list[Found]:
    """Distinct solutions with the coordinates at places `free` unknown, the others as in `known`
    (numbers,).
    """
    begin = random_configurations(m, np.tile(known, (starts, 1)), free, rng)
    columns = m.tangent(free)
    ends = solve(m, begin, columns)
    ends = ends[m.residual(ends) < 1e-6]
    ends = solve(m, ends, columns, 8) if len(ends) else ends
    ends = ends[m.residual(ends) < CLOSED]
    f = features(m, ends, named_places(m))
    kept: list[int] = []
    for i in range(len(ends)):
        if all(np.max(np.abs(f[i] - f[k])) > 1e-5 for k in kept):
            kept.append(i)
        if len(kept) > 80:
            break
    return [found_at(m, ends[i], free) for i in kept]


def found_at(m: PlainMechanism, x: np.ndarray, free: Sequence[int]) -> Found:
    """Whether named coordinates and pose are determined at a solution: no null vector of the rows
    moves them.
    """
    columns = m.tangent(free)
    j = m.closure(x[None])[1][0][:, columns]
    _, s, right = np.linalg.svd(j, full_matrices=True)
    s = np.concatenate([s, np.zeros(len(right) - len(s))])
    named = np.isin(columns, m.tangent(named_places(m)))
    null = right[s <= FREE * max(s[0], 1e-300)] if len(s) else right
    isolated = not len(null) or float(np.max(np.abs(null[:, named]), initial=0.0)) < 1e-6
    others = s[s > FREE * max(s[0], 1e-300)] if len(s) else s
    return Found(
        x, isolated, isolated and (not len(others) or float(others.min() / s[0]) > REGULAR)
    )


def named_places(m: PlainMechanism) -> list[int]:
    """All coordinates but those that leave the others alone: spherical joints at both ends of a
    limb.
    """
    return [i for i, n in enumerate(m.numbers) if n.name not in m.idle]


def features(m: PlainMechanism, x: np.ndarray, places: Sequence[int]) -> np.ndarray:
    """Numbers (n, any) in which equal configurations are equal: pose, and the coordinates at some
    places.
    """
    position, rotation = m.pose(x)
    parts = [position / m.size, rotation.reshape(len(x), 9)]
    for i in places:
        number, values = m.numbers[i], x[:, m.slices[i]]
        if number.role == "pose":
            continue
        if number.kind == "quaternion":
            parts.append(quaternion_matrix(values).reshape(len(x), 9))
        elif number.kind == "angle":
            parts += [np.cos(values), np.sin(values)]
        else:
            parts.append(values / (m.size if number.kind == "length" else 1.0))
    return np.concatenate(parts, axis=1)


def closed_configurations(
    m: PlainMechanism, count: int, spread: float, rng: np.random.Generator
) -> np.ndarray:
    """Closed configurations (n, numbers), at most `count`, from random steps off the reference;
    none where none closes.
    """
    steps = spread * m.size * rng.normal(size=(count, m.freedom))
    everything = np.arange(m.freedom)
    x = solve(m, m.move(np.tile(m.reference, (count, 1)), steps), everything, 40)
    return np.asarray(x[m.residual(x) < 1e-12])


def freedom_at(m: PlainMechanism, x: np.ndarray) -> int | None:
    """Mobility at a configuration: motions of named coordinates and pose that the rows allow. None
    where a singular value between 1e-11 and 1e-5 of the largest leaves the rank open, as where
    every configuration is a multiple one.
    """
    j = m.closure(x[None])[1][0]
    _, s, right = np.linalg.svd(j, full_matrices=True)
    share = s / max(s[0], 1e-300) if len(s) else s
    if np.any((share > 1e-11) & (share < 1e-5)):
        return None
    moving = right[int(np.sum(share > 1e-8)) :][:, m.tangent(named_places(m))]
    return int(np.linalg.matrix_rank(moving, tol=1e-6)) if moving.size else 0
