"""Real solutions of one structure group that are found without formulas and paths of many values.

A group whose rows are linear, or couplings of whole numbers, is solved at once; others are searched
one by one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.assembly.continuation import by_continuation
from symkin.assembly.group_roots import NO_ENDS, STATEMENTS, GroupRoots, engines_together
from symkin.assembly.group_solvers import group_paths
from symkin.assembly.modes_result import Completeness
from symkin.assembly.search import Search
from symkin.numeric.newton import Polished
from symkin.numeric.root_checks import are_roots
from symkin.position.canonical import canonical
from symkin.position.gear_train import GearTrain
from symkin.position.multistart import batched, one_by_one
from symkin.position.problem import Problem
from symkin.position.roots import NOT_KNOWN, Roots


def searched_alone(group: Problem, known: np.ndarray, search: Search) -> GroupRoots:
    """The solutions of a group at known values (n, known), each searched alone, with random numbers
    that do not depend on the others.
    """
    searched = [_searched(group, numbers, search) for numbers in known]
    roots = [found for found, _ in searched]
    paths = group_paths(group) if search.method == "continuation" else None
    own = paths is not None and paths.shared is None
    ends = [r.ends if own and r.ends is not None else NO_ENDS for r in roots]
    some = [part for part in ends if part.size]
    counts = [NOT_KNOWN if r.complex_count is None else r.complex_count for r in roots]
    return GroupRoots(
        points=np.concatenate([np.zeros((0, group.system.width)), *(r.points for r in roots)]),
        owner=np.repeat(np.arange(len(roots)), [len(r.points) for r in roots]),
        hits=np.concatenate(
            [
                np.zeros(0),
                *(np.full(len(r.points), np.inf) if r.hits is None else r.hits for r in roots),
            ]
        ),
        statement=np.array([STATEMENTS.index(_statement(r)) for r in roots], dtype=int),
        complex_count=np.array(counts, dtype=float),
        unresolved=np.array([NOT_KNOWN if r.sampled else r.unresolved for r in roots], dtype=float),
        smallest=np.array([r.smallest_residual for r in roots]),
        continuum=np.array([r.continuum is not None for r in roots], dtype=bool),
        notes={i: notes for i, (_, notes) in enumerate(searched) if notes},
        engine=engines_together([r.engine for r in roots]),
        ends=np.hstack(some) if some else NO_ENDS,
        ends_of=np.repeat(np.arange(len(roots)), [part.shape[1] for part in ends]),
        samples={i: r for i, r in enumerate(roots) if r.hits is not None},
    )


def _searched(group: Problem, known: np.ndarray, search: Search) -> tuple[Roots, tuple[str, ...]]:
    """The roots of a group, and what is said of them."""
    rng, notes = np.random.default_rng(search.seed), tuple[str, ...]()
    if search.method == "continuation":
        roots, notes = by_continuation(group, known, search.starts, rng)
    elif search.solver == "batched":
        roots = batched(group, known, search.starts, rng, search.progress)
    else:
        roots = one_by_one(group, known, search.starts, rng, search.solver, search.progress)
    return roots, (*notes, *_notes_of(group, roots))


def _notes_of(group: Problem, roots: Roots) -> list[str]:
    """What is said of sets that are not isolated and of generic solutions that are missing."""
    names, notes = ", ".join(c.name for c in group.system.unknowns), []
    if roots.continuum is not None:
        notes.append(
            f"positive-dimensional set: the {group.kind} problem has solutions that are not "
            f"isolated (in {names}); the modes listed are the isolated ones only"
        )
    elif roots.complex_sets:
        notes.append(
            "paths ended on a set of complex solutions that are not isolated; no real one of it "
            "was met"
        )
    if roots.missing is not None:
        notes.append(f"{names}: {roots.missing}")
    return notes


def _statement(roots: Roots) -> Completeness:
    if roots.sampled:
        return "sampled"
    return (
        "incomplete"
        if roots.unresolved or roots.complex_sets or roots.continuum is not None
        else "probability one"
    )


# --- groups that are linear, or linear but for whole turns ----------------------------------------


def linear_roots(group: Problem, known: np.ndarray) -> GroupRoots:
    points = group.system.polish_many(np.zeros((len(known), group.system.width)), known).points
    return _closed(group, known, points[:, None, :])


def geared_roots(group: Problem, train: GearTrain, known: np.ndarray) -> GroupRoots:
    points = train.solutions(known)
    unknowns, slices = group.system.unknowns, group.system.slices
    places = {c.name: place for c, place in zip(unknowns, slices, strict=True)}
    flat = canonical(unknowns, places, points.reshape(-1, group.system.width))
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
