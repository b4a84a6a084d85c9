"""Every mode by parameter continuation from the mechanism's own start system.

The roots of one generic complex instance are found once for a mechanism and kept (see
`start_store`); each real instance is then a straight path in the known values from there, with
exactly the mechanism's own number of paths. All paths accounted for, the list is complete with
probability one: the random numbers avoid a set of measure zero, and the generic count rests on a
theorem's bound or on the evidence of monodromy, never on a proof.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.assembly.block_paths import BlockPaths, own_paths
from symkin.assembly.group_roots import STATEMENTS, GroupRoots
from symkin.homotopy.algebraic import imaginary_part
from symkin.homotopy.ends import Ends
from symkin.homotopy.many_instances import instance
from symkin.homotopy.six_distances import meet_all_distances, redundant_distances
from symkin.homotopy.systems import meets_all_rows
from symkin.homotopy.values import known_values
from symkin.model.joint import Coordinate
from symkin.position.multistart import batched, batched_rows, screws_of, turning
from symkin.position.problem import Problem
from symkin.position.roots import Sample, polished_roots, unite

_REAL = 1e-5
"""Largest imaginary part of a root that is tried as a real one; the closure decides."""
_LEAST_ERROR_STARTS = 200
"""Random starts for the least closure error where no root is real."""


def by_continuation(
    problem: Problem, known: np.ndarray, starts: int, rngs: Sequence[np.random.Generator]
) -> GroupRoots:
    """Roots of a group at rows of known values (n, known) by paths; where it has no start system by
    `starts` random starts, with a note why. These are of use too where paths left something in
    doubt.
    """
    from symkin.numeric.shared_library import begin_loading

    begin_loading()
    paths, why = own_paths(problem)
    if paths is not None:
        return GroupRoots.joined(
            [_block_roots(paths, row, starts, rng) for row, rng in zip(known, rngs, strict=True)]
        )
    names = ", ".join(sorted(c.name for c in problem.system.unknowns))
    note = f"{names}: sampled by multistart, {why}"
    return sampled_rows(problem, batched_rows(problem, known, starts, rngs), note)


def sampled_rows(problem: Problem, samples: Sequence[Sample], *notes: str) -> GroupRoots:
    """What random starts have reached at rows of known values."""
    return GroupRoots.joined([sampled_roots(problem, sample, *notes) for sample in samples])


def sampled_roots(problem: Problem, sample: Sample, *notes: str) -> GroupRoots:
    """What random starts have reached at one row of known values."""
    more = [_continuum_note(problem)] if sample.continuum else []
    if names := ", ".join(turning(problem)):
        more.append(
            f"{names}: whole turns count; what they repeat beyond the limits is listed once"
        )
    more += [_screw_note(problem, sample, c) for c in screws_of(problem) if len(sample.points)]
    return GroupRoots.sampled(sample, (*notes, *more))


def _screw_note(problem: Problem, sample: Sample, screw: Coordinate) -> str:
    """Which turns of a screw the solutions of random starts have, and how these were looked for."""
    turns = sample.points[:, problem.system.places[screw.name]] / (2.0 * np.pi)
    beside = "each" if sample.turned else "some alone, for want of starts"
    return (
        f"{screw.name}: solutions from {turns.min():.3g} to {turns.max():.3g} turns; the next turn "
        f"on and back was looked for beside {beside}"
    )


def _continuum_note(problem: Problem) -> str:
    names = ", ".join(c.name for c in problem.system.unknowns)
    return (
        f"positive-dimensional set, as far as rounding tells: the {problem.name} problem has "
        f"solutions that are not isolated (in {names}), or so near to such a set that they may be "
        f"of it; the modes listed are the isolated ones only"
    )


def _block_roots(
    paths: BlockPaths, known: np.ndarray, starts: int, rng: np.random.Generator
) -> GroupRoots:
    """Roots that are real: polished on the group's own rows and checked on all of them. Where paths
    are unresolved, or end on a set that is not isolated, `starts` random starts look for what they
    missed; where no root is real, a fixed number of fixed ones looks for the least error.
    """
    problem, system, algebraic = paths.problem, paths.problem.system, paths.algebraic
    k = known_values(problem, known)
    ends, prover = instance(algebraic, paths.start, k), paths.prover
    knowns = prover.knowns(known[None])
    possible, singular = (
        z[:, imaginary_part(algebraic, z) < _REAL] for z in (ends.z, ends.singular.z)
    )
    if prover.proves_ends:
        # however near to being real
        tried = prover.ends(possible, knowns, np.zeros(possible.shape[1], dtype=int))
        possible = possible[:, ~tried.proved_unreal]
    possible = np.concatenate([possible, singular], axis=1)
    near = paths.points(possible, np.zeros(possible.shape[1], dtype=int), k[:, None])
    found = polished_roots(system, near, known)
    points, smallest = found.points, found.smallest_residual
    continuum = found.continuum is not None
    doubtful = bool(ends.unresolved) or not ends.singular.isolated.all()
    if doubtful or not len(points):
        sampled = (
            batched(problem, known, starts, rng) if doubtful else _least_errors(problem, known)
        )
        continuum = continuum or sampled.continuum
        points = np.concatenate([points, sampled.points])
        smallest = min(smallest, sampled.smallest_residual)
    first, _ = unite(system, points, known, continuum_met=continuum)
    points = points[first]
    isolated = _isolated(problem, ends, known)
    columns = np.repeat(k[:, None], isolated.shape[1], axis=1)
    whole = meets_all_rows(problem, algebraic, isolated, columns)
    said = "incomplete" if doubtful or continuum else "probability one"
    notes = (*paths.notes, *_notes(problem, ends, continuum=continuum))
    return GroupRoots.of_all(
        points,
        np.zeros(len(points), dtype=int),
        # roots that nearly meet may be one for paths and two for the rows
        np.array([max(int(whole.sum()), len(points))]),
        statement=np.array([STATEMENTS.index(said)]),
        unresolved=np.array([len(ends.unresolved)], dtype=float),
        smallest=np.array([smallest]),
        continuum=np.array([continuum]),
        notes={0: notes} if notes else {},
        engine=paths.engine,
        ends=ends.z,
        ends_of=np.zeros(ends.z.shape[1], dtype=int),
    )


def _least_errors(problem: Problem, known: np.ndarray) -> Sample:
    return batched(problem, known, _LEAST_ERROR_STARTS, np.random.default_rng(0))


def least_error(problem: Problem, known: np.ndarray) -> float:
    """The least closure error that a fixed number of fixed starts reach."""
    return _least_errors(problem, known).smallest_residual


def _isolated(problem: Problem, ends: Ends, known: np.ndarray) -> np.ndarray:
    """Isolated complex roots, of all distances where there are more than six."""
    z = ends.isolated
    return z if not redundant_distances(problem) else z[:, meet_all_distances(problem, z, known)]


def _notes(problem: Problem, ends: Ends, *, continuum: bool) -> list[str]:
    """What is said of sets that are not isolated and of generic solutions that are missing."""
    notes, missing = list[str](), _missing(ends)
    if continuum:
        notes.append(_continuum_note(problem))
    elif not ends.singular.isolated.all():
        notes.append(
            "paths ended on a set of complex solutions that are not isolated to rounding; no real "
            "one of it was met"
        )
    if missing is not None:
        notes.append(f"{', '.join(c.name for c in problem.system.unknowns)}: {missing}")
    return notes


def _missing(ends: Ends) -> str | None:
    """Where generic solutions are that are no isolated ones of their own at these values."""
    several = ends.singular.isolated & (ends.singular.multiplicity > 1)
    met, sets = (
        int(ends.singular.multiplicity[several].sum()),
        int(ends.singular.multiplicity[~ends.singular.isolated].sum()),
    )
    parts = (
        [f"{met} meet in {several.sum()} multiple one{'' if several.sum() == 1 else 's'}"]
        if met
        else []
    )
    # rounding does not tell roots at infinity from those some 1e7 sizes away
    away = f"{ends.at_infinity} are at infinity, or too far off to be told from it"
    parts += [away] if ends.at_infinity else []
    parts += [f"{sets} end on sets that are not isolated to rounding"] if sets else []
    return (
        f"of {ends.paths} generic complex solutions {', '.join(parts)} at these values"
        if parts
        else None
    )
