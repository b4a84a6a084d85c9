"""Real solutions of one structure group that are found without formulas and paths of many values.

A group whose rows are linear, or couplings of whole numbers, is solved at once; others are searched
one by one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.assembly.continuation import by_continuation, sampled_rows
from symkin.assembly.group_roots import NO_ENDS, GroupRoots
from symkin.assembly.group_solvers import group_paths
from symkin.assembly.search import Search
from symkin.numeric.newton import Polished
from symkin.numeric.root_checks import are_roots
from symkin.position.gear_train import GearTrain
from symkin.position.multistart import batched_rows, one_by_one
from symkin.position.problem import Problem
from symkin.position.readings import canonical


def searched_alone(group: Problem, known: np.ndarray, search: Search) -> GroupRoots:
    """The solutions of a group at known values (n, known), each searched alone, with random numbers
    that do not depend on the others.
    """
    found = _searched(group, known, search)
    paths = group_paths(group) if search.method == "continuation" else None
    if paths is not None and (paths.shared is None or not paths.algebraic.projective):
        return found
    # no complex roots of the system in which the group is proved: rods are those of all rods
    return replace(found, ends=NO_ENDS, ends_of=found.ends_of[:0])


def _searched(group: Problem, known: np.ndarray, search: Search) -> GroupRoots:
    rngs = [np.random.default_rng(search.seed) for _ in known]
    starts, progress = search.starts, search.progress
    if search.method == "continuation":
        return by_continuation(group, known, starts, rngs)
    if search.solver == "batched":
        return sampled_rows(group, batched_rows(group, known, starts, rngs, progress))
    each = zip(known, rngs, strict=True)
    return sampled_rows(
        group, [one_by_one(group, row, starts, rng, search.solver, progress) for row, rng in each]
    )


# --- groups that are linear, or linear but for whole turns ----------------------------------------


def linear_roots(group: Problem, known: np.ndarray) -> GroupRoots:
    points = group.system.polish_many(np.zeros((len(known), group.system.width)), known).points
    return _closed(group, known, points[:, None, :])


def geared_roots(group: Problem, train: GearTrain, known: np.ndarray) -> GroupRoots:
    points, system = train.solutions(known), group.system
    flat = canonical(system, points.reshape(-1, system.width))
    found = _closed(group, known, flat.reshape(points.shape))
    return (
        found
        if len(train.places) == 1
        else replace(found, orbits=(_places_note(group, len(train.places)),))
    )


def _places_note(group: Problem, count: int) -> str:
    """What is said of wheels that have several places beside one place of those that drive them."""
    own, read = (
        ", ".join(c.name for c in part) for part in (group.system.unknowns, group.known_coordinates)
    )
    return (
        f"{own}: {count} places for one of {read}, whose whole turns are not told apart (ratio of "
        f"the coupling)"
    )


def _closed(group: Problem, known: np.ndarray, points: np.ndarray) -> GroupRoots:
    """The solutions that close, of all complex ones (n, count, width) at known values (n,
    known).
    """
    system, (n, count, width) = group.system, points.shape
    flat, given = points.reshape(-1, width), np.repeat(known, count, axis=0)
    residual = system.residuals(flat, given)
    closed = are_roots(system, Polished(flat, *system.linearise(flat, given)), residual).reshape(
        n, count
    )
    residual = residual.reshape(n, count)
    return GroupRoots.of_all(
        points[closed],
        np.nonzero(closed)[0],
        np.full(n, count),
        statement=np.zeros(n, dtype=int),
        smallest=residual.min(axis=1),
    )
