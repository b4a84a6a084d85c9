"""Whether given coordinates decide a configuration: as many as the mobility, and none that others
decide.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.numeric.rank import Rank, generic, independent_rows, null_space
from symkin.numeric.tolerances import CLOSURE_TOLERANCE, RANK_TOLERANCE, SINGULAR_CONDITION
from symkin.position.closed_configurations import (
    assembly_of,
    closed_configurations,
    least_squares_ends,
    own_component,
    whole_system,
)
from symkin.position.file_digits import rank_to_digits
from symkin.position.problem import Problem
from symkin.position.solution import Solution
from symkin.position.transfer import variables_elsewhere
from symkin.text import counted

DIGITS = 1e-4
"""Largest closure error, as a share of the size, that may be due to the digits of a file."""
_OPEN_RANK = 1e3
"""Singular values below this many times the share of the size by which loops stay open are those of
redundant rows.
"""
_STATIONARY = 0.9
"""A configuration whose rows one step would lessen to below this share is no minimum of them."""
_REGULAR = 1e-5
"""Singular value, over the largest, below which a configuration is at the end of its reach and not
one of redundant rows.
"""
_OWN_MOTION = 1e-7
"""Share of a coordinate's motions beyond those of others up to which it has none of its own."""
_OWN_WAY = 1e-2
"""The same of directions to configurations nearby, which rounding and curvature bend."""
_SUGGESTED = 4
"""Names that a message lists."""


@dataclass(frozen=True)
class Determination:
    """Given coordinates that others decide; freedoms that are left; coordinates that would bind
    them; the mobility. `misfit` (length unit) is not 0 where loops of redundant constraints close
    only to the digits of a file; `infinitesimal` counts freedoms of first order that the given
    coordinates leave and no motion follows.
    """

    decided: tuple[str, ...]
    free: int
    binding: tuple[str, ...]
    mobility: int
    misfit: float = 0.0
    infinitesimal: int = 0


def refuse_unless_determined(
    problem: Problem, solution: Solution | None = None, *, rates: bool = False
) -> None:
    """Raise InputError where the given coordinates leave some motion free, or say the same thing
    twice, about the reference and at a solution; with `rates` where they leave some of these free
    at every configuration.
    """
    if solution is not None:
        there = determination_at(problem, solution)
        if not (there.decided or there.free):
            return
    refuse_contradictions(problem, solution)
    found = determination(problem)
    if rates and found.infinitesimal and not found.free:
        raise InputError(
            f"given: {', '.join(c.name for c in _given(problem))}; their rates leave "
            f"{problem.mechanism.name} {counted(found.infinitesimal, 'freedom')} of first order, "
            "which no motion follows: every configuration of this assembly is singular"
        )
    if found.free:
        name, some = (
            problem.mechanism.name,
            ", ".join(found.binding[:_SUGGESTED] or _pose_names(problem)),
        )
        listed = ", ".join(c.name for c in _given(problem)) or "nothing"
        what = (
            f"give {found.free} more, for example {some}; or use"
            if some
            else "no joint is left to be given; use"
        )
        raise InputError(
            f"given: {listed}; that leaves {name} {counted(found.free, 'freedom')}, "
            f"and its configurations are not "
            f"isolated: {what} solve with a start for one of them"
        )


def what_is_free(problem: Problem) -> str | None:
    """What to say where an inverse or direct problem leaves unknowns free, so that no solution is
    isolated.
    """
    free = 0 if problem.by_name else _free_unknowns(problem)
    return (
        f"{problem.mechanism.name}: the {problem.name} problem leaves {free} of "
        f"{problem.system.freedom} unknowns free"
        if free
        else None
    )


def what_is_free_at(problem: Problem, condition: float) -> str | None:
    """The same of one solution: nothing where its `condition` is that of a regular one, whatever is
    free about the reference.
    """
    determined = problem.generic_rank == problem.system.freedom
    return None if determined and condition < SINGULAR_CONDITION else what_is_free(problem)


def set_notes(problem: Problem, condition: float) -> tuple[str, ...]:
    """What is said of one solution where none is isolated."""
    free = what_is_free_at(problem, condition)
    return () if free is None else (f"{free}: this is one of a set of solutions",)


@lru_cache(maxsize=128)
def _free_unknowns(problem: Problem) -> int:
    """How many unknowns the known coordinates leave free where loops close: rows have more rank at
    random points where no motion is declared. 0 where the reference closes and has full rank.
    """
    system, closure = problem.system, problem.closure
    free = system.freedom - problem.generic_rank
    if free or not system.freedom:
        return free
    z, known = (closure.reference[at] for at in (problem.unknown_places, problem.known_places))
    closes = system.residual(z, known) <= CLOSURE_TOLERANCE * closure.characteristic_length
    if closes and Rank.of(system.linearise_one(z, known)[1]).value == system.freedom:
        return 0
    return determination(problem).free


def _pose_names(problem: Problem) -> tuple[str, ...]:
    """What may bind where no joint does."""
    known = {c.name for c in problem.known_coordinates}
    return (
        tuple(name for name in POSE_CONDITIONS if name not in known)
        if problem.mechanism.platform_link is not None
        else ()
    )


def refuse_contradictions(problem: Problem, solution: Solution | None = None) -> None:
    """Raise InputError where given coordinates say what others decide, about the reference and at a
    solution. A pose as a whole may hold what the joints decide anyway.
    """
    found = determination(problem)
    decided = [name for name in found.decided if not name.startswith("pose.")]
    if not decided or (solution and not determination_at(problem, solution).decided):
        return
    names = [c.name for c in _given(problem)]
    one = len(names) == 1
    nothing = "no motion about the reference" if found.mobility else "nothing"
    raise InputError(
        f"given: {', '.join(names)} {'is' if one else 'are'} {len(names)} "
        f"coordinate{'' if one else 's'} of "
        f"{problem.mechanism.name}, whose mobility is {found.mobility}: "
        + (f"{nothing} moves {names[0]}" if one else f"the others decide {', '.join(decided)}")
        + f"; leave {'it' if len(decided) == 1 else 'them'} out"
    )


def _given(problem: Problem) -> list[Coordinate]:
    return [c for c in problem.known_coordinates if c.role != "geometry"]


@lru_cache(maxsize=128)
def determination(problem: Problem) -> Determination:
    """What the given coordinates of a problem decide, at generic closed configurations."""
    closure = _without_geometry(problem)
    system, own = whole_system(closure), own_component(assembly_of(closure), 0)
    jacobians = [system.linearise_one(z)[1] for z in closed_configurations(closure, 0)]
    best = jacobians[generic([Rank.of(j) for j in jacobians])]
    found = _determination(problem, closure, _motions(best, RANK_TOLERANCE))
    if own is not None and own.motions is not None:
        # what no motion follows is not free, and values of it may be given all the same
        led = _determination(problem, closure, own.motions, own_motion=_OWN_WAY)
        return replace(led, decided=found.decided, infinitesimal=found.free - led.free)
    if not found.decided:
        beside = _beside_singular(closure, system.freedom - found.mobility) if found.free else None
        return found if beside is None else _determination(problem, closure, *beside)
    # loops of redundant constraints that are written with few digits are rigid, strictly speaking
    nearly = _nearly_closed(closure)
    if nearly is None:
        return found
    z, misfit = nearly
    tolerance = min(_OPEN_RANK * misfit / closure.characteristic_length, 1e-2)
    motions = _motions(system.linearise_one(z)[1], tolerance)
    loose = _determination(problem, closure, motions, misfit)
    return loose if len(loose.decided) < len(found.decided) else found


def determination_at(problem: Problem, solution: Solution) -> Determination:
    """What they decide at a solution, which may lie in another motion than the reference."""
    closure = _without_geometry(problem)
    z = variables_elsewhere(closure, solution)
    motions = _motions(whole_system(closure).linearise_one(z)[1], RANK_TOLERANCE)
    return _determination(problem, closure, motions)


def _without_geometry(problem: Problem) -> Closure:
    return build_closure(problem.mechanism, replace(problem.closure.partition, geometry=False))


def _motions(jacobian: np.ndarray, tolerance: float) -> np.ndarray:
    return null_space(jacobian, tolerance, relative=True)


def _determination(
    problem: Problem,
    closure: Closure,
    motions: np.ndarray,
    misfit: float = 0.0,
    own_motion: float = _OWN_MOTION,
) -> Determination:
    """What given coordinates decide of motions (orthonormal rows) at a configuration."""
    left = motions.T
    columns: dict[str, list[int]] = {}
    for column, coordinate in enumerate(closure.owners):
        columns.setdefault(coordinate.name, []).append(column)
    given = _given(problem)
    others = [
        c
        for c in closure.coordinates
        if c not in problem.known_coordinates
        and not c.is_rotation
        and c.role not in ("body", "pose")
    ]
    # one after another: how many motions each decides that those before it leave free
    order = [k for c in (*given, *others) for k in columns[c.name]]
    taken = {*independent_rows(left, own_motion, groups=order)}
    grown = {c.name: sum(k in taken for k in columns[c.name]) for c in (*given, *others)}
    free = left.shape[1] - sum(grown[c.name] for c in given)
    decided = tuple(c.name for c in given if grown[c.name] < c.freedom)
    binding = tuple(c.name for c in others if grown[c.name])
    return Determination(decided, free, binding, left.shape[1], misfit)


def is_least(problem: Problem, known: np.ndarray, z: np.ndarray, residual: float) -> bool:
    """Whether rows that are redundant but for digits are all that is left at a minimum z of the
    closure error: the error is small, and no motion would lessen it.
    """
    system = problem.system
    if (
        not CLOSURE_TOLERANCE * system.characteristic_length
        < residual
        <= DIGITS * system.characteristic_length
    ):
        return False
    needed = system.freedom - determination(problem).free
    rows, jacobian = system.linearise_one(z, known)
    if jacobian.shape[0] <= needed or needed <= 0:
        return False
    step = np.linalg.lstsq(jacobian, -rows, rcond=RANK_TOLERANCE)[0]
    if np.linalg.norm(rows + jacobian @ step) < _STATIONARY * np.linalg.norm(rows):
        return False
    singular = np.linalg.svd(jacobian, compute_uv=False)
    return bool(singular[needed - 1] > _REGULAR * singular[0])


def misfit_note(problem: Problem, misfit: float) -> str:
    """What is said of configurations that close only to the digits of a file, by a largest error in
    the length unit.
    """
    return (
        f"the loops close only to {misfit:.2g} {problem.mechanism.length_unit}: constraints are "
        f"redundant, and the numbers of the "
        "description do not meet them to more digits; what is given here is of least squares"
    )


def _beside_singular(closure: Closure, rank: int) -> tuple[np.ndarray, float] | None:
    """Where nothing but a singular reference of this rank closes exactly: motions of first order at
    a configuration beside it that closes to the digits of a file, and the closure error. None
    elsewhere.
    """
    system, ends = whole_system(closure), least_squares_ends(assembly_of(closure), 0)
    digits = rank_to_digits(system, ends, rank)
    if digits is None or digits.at_reference is None:
        return None
    near = np.flatnonzero(ends.misfits <= digits.misfit)
    jacobians = system.linearise(ends.points[near])[1]
    values = np.linalg.svd(jacobians, compute_uv=False)
    values = np.hstack([values, np.zeros((len(near), 1))])
    drops = values[:, digits.rank] / values[:, digits.rank - 1]
    best = int(np.argmin(drops))
    share = (
        np.sqrt(
            values[best, digits.rank - 1] * max(values[best, digits.rank], np.finfo(float).tiny)
        )
        / values[best, 0]
    )
    return _motions(jacobians[best], float(share)), digits.misfit


def _nearly_closed(closure: Closure) -> tuple[np.ndarray, float] | None:
    """Of the configurations where least squares end off the reference that of largest closure
    error, and that error, among those where it is more than rounding and no more than that of
    digits.
    """
    ends, size = least_squares_ends(assembly_of(closure), 0), closure.characteristic_length
    left = ends.misfits
    near = np.flatnonzero((left > CLOSURE_TOLERANCE * size) & (left <= DIGITS * size))
    if not near.size:
        return None
    best = near[np.argmax(left[near])]
    return ends.points[best], float(left[best])
