"""Generic roots of a mechanism's problems: computed once, then read from the shipped data or the
user's cache.

A start belongs to a closure: its key is a hash of the closure's instructions and constants. The
shipped mechanisms' starts lie in `symkin/homotopy/data/starts`, others in the cache folder
(SYMKIN_CACHE, else the platform's).
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem, complex_normal, first_of_each, known_root
from symkin.homotopy.best_start import bases_beside, best_start
from symkin.homotopy.components import real_roots, real_seeds, roots_elsewhere
from symkin.homotopy.coplanar import distance_frames, reflection
from symkin.homotopy.engine import aligned, newton, track_lines
from symkin.homotopy.monodromy import (
    Fibre,
    Known,
    Looping,
    TooManyRootsError,
    agreeing_searches,
    fibre,
    loop_radius,
    orbits,
    progress_of_searches,
    within_reach,
)
from symkin.homotopy.seeds import Points, full_linearisation, random_known, random_point
from symkin.homotopy.six_distances import DISTANCES, distance_data, distance_function, is_universal
from symkin.homotopy.six_revolute import arm_start, is_six_revolute
from symkin.homotopy.start_files import closure_key, hash_of, kept_or_computed
from symkin.homotopy.symmetry import find_symmetries, orbits_under
from symkin.homotopy.systems import system_of
from symkin.homotopy.tracker import TrackSettings
from symkin.homotopy.universal_start import machine_start, universal_start
from symkin.homotopy.values import algebraic_points, coordinate_scale, known_angles, known_values
from symkin.numeric.rank import Rank
from symkin.position.closed_configurations import closed_configurations
from symkin.position.mobility import must_agree
from symkin.position.multistart import batched
from symkin.position.problem import Problem

LOG = logging.getLogger(__name__)
RIGID = "no coordinate is known that would move the solutions"
"""Why a part that nothing moves has no generic instances."""
TIED = "the given values must satisfy conditions of their own"
"""Why rows that are more than the unknowns have no generic roots; as many combinations of them have
some.
"""
TIED_ELSEWHERE = f"the rows are singular at the reference, and elsewhere {TIED}"
"""The same of rows that the reference alone meets with room to move."""
SINGULAR = "some solutions are singular whatever the given values are"
"""Why no loop of known values leads to all of them."""
_INSTANCES = 5
_SINGULAR = 1e7
"""Condition from which a root is singular, to what its position is known to."""
_CHECK_STARTS = 600
_TARGETS, _BASES = 4, 19
"""Real instances on which bases of a start are compared, and how many bases."""
_RUNS = 4
"""Second searches at most; the first that agrees settles the generic count."""
_LOOPS, _FEW_LOOPS, _FEW_RUNS = 200, 40, 1
"""Loops of one search; of one for combinations of a limb's rows, whose few roots are found at once
or not at all, and then how many second searches.
"""


def start_of(problem: Problem, system: AlgebraicSystem) -> tuple[Fibre | None, str]:
    """The generic roots of a problem, or None and the reason."""
    return kept_or_computed(
        start_key(problem, system), system, lambda: compute_start(problem, system)
    )


def compute_start(problem: Problem, system: AlgebraicSystem) -> tuple[Fibre | None, str]:
    """Generic roots from the universal start of six distances where the closure is that, else by
    monodromy; at a base from which real instances take few steps.
    """
    if not system.k.shape[0]:
        return None, RIGID
    LOG.info("the generic solutions of the %s problem are found, once", problem.name)
    data = distance_data(problem)
    try:
        if is_six_revolute(problem):
            found, reason = _of_family(
                problem, system, partial(arm_start, problem), "revolute joints"
            )
        elif data is not None:
            found, reason = _of_family(
                problem, system, lambda q: machine_start(data(q)), "distances"
            )
        else:
            found, reason = _by_monodromy(problem, system)
    except TooManyRootsError as error:
        reason = f"the search for the generic solutions was given up after {error.args[0]} of them"
        return None, reason
    if found is None or found is universal_start():
        return found, reason
    return _with_mirrors(problem, system, _at_best_base(problem, system, found)), reason


def _at_best_base(problem: Problem, system: AlgebraicSystem, start: Fibre) -> Fibre:
    if start.z.shape[1] == 1:
        return start
    closed = closed_configurations(problem.closure, start.seed)[:_TARGETS]
    targets = [
        known_values(problem, problem.select_values(values, problem.known_coordinates))
        for values in closed
    ]
    if len(targets) < 2:
        return start
    targets = [aligned(system, targets[0], target).real for target in targets]
    return best_start(system, start, bases_beside(targets, _BASES, start.seed), targets).start


def _with_mirrors(problem: Problem, system: AlgebraicSystem, start: Fibre) -> Fibre:
    """Symmetries that hold for this mechanism's known values, where they carry all roots to
    roots.
    """
    if start.z.shape[1] == 1:
        return start

    def draw(rng: np.random.Generator) -> np.ndarray:
        return known_values(problem, random_known(problem, rng, near=True))

    others = []
    if is_universal(problem):
        frames = distance_frames(draw(np.random.default_rng(0)).reshape(DISTANCES, 7).real)
        others = [] if frames is None else [reflection(frames)]
    mirrors = orbits_under(system, find_symmetries(system, draw, others), start.z)
    return (
        replace(start, mirrors=mirrors)
        if mirrors.whole and len(mirrors.first) < start.z.shape[1]
        else start
    )


def _of_family(
    problem: Problem,
    system: AlgebraicSystem,
    roots_at: Callable[[np.ndarray], tuple[np.ndarray, int]],
    of: str,
) -> tuple[Fibre | None, str]:
    """Track the roots that all machines of a family share to this one at random complex known
    values, where `roots_at` tells roots and how many paths are unresolved; loops there show its
    orbits. A platform that cannot be assembled for generic lengths is reached from the universal
    start each time.
    """
    for seed in range(3):
        rng = np.random.default_rng(seed)
        known = random_known(problem, rng, near=True)
        k = known_values(problem, known)
        z, unresolved = roots_at(known)
        if not unresolved and not z.shape[1] and is_universal(problem):
            return universal_start(), ""
        ends = None if unresolved or not z.shape[1] else _settled(system, z, k)
        if ends is not None:
            apart = orbits(system, ends, k, _corners(problem, known, rng))
            return Fibre(ends, k, apart, float("inf"), 0, seed), ""
    return None, f"paths from the universal start of six {of} are unresolved"


def _corners(
    problem: Problem, base: np.ndarray, rng: np.random.Generator
) -> Callable[[], np.ndarray]:
    """Draws known values of the algebraic system about those of a base, in the length unit and
    radians.
    """
    scale, angles = coordinate_scale(problem, problem.known_coordinates), known_angles(problem)

    def corner() -> np.ndarray:
        way = 2.0 * loop_radius(rng) * complex_normal(len(base), rng)
        return known_values(problem, base + scale * within_reach(way, angles))

    return corner


def _settled(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> np.ndarray | None:
    """Roots polished on a machine's own rows, those far from real ones by more bits; None where one
    is not found.
    """
    from symkin.homotopy.far_roots import are_far, settled

    ends, last = newton(system, z, k)
    left = np.flatnonzero(~(last <= 1e-9))
    if not are_far(system, z[:, left]).all():
        return None
    found, ends[:, left] = settled(system, z[:, left], k)
    return ends if found.all() else None


def _by_monodromy(problem: Problem, system: AlgebraicSystem) -> tuple[Fibre | None, str]:
    if problem.of_joints and (why := must_agree(problem.mechanism)) is not None:
        return None, why
    # fewer combinations of the rows than these are no more redundant than they
    redundant = 0 if problem.of_pose else redundant_rows(problem)
    rank = min(system.count, problem.system.rows.shape[0] - redundant)

    def points(rng: np.random.Generator, near: bool) -> tuple[np.ndarray, np.ndarray]:
        return random_point(problem, system, rng, near=near)

    if (why := _why_not_determined(problem, system)) is not None:
        return None, why
    combined = system.count < system_of(problem).count
    loops, runs = (_FEW_LOOPS, _FEW_RUNS) if combined else (_LOOPS, _RUNS)
    bound = 1 if len(system.unknowns) == 1 and system.unknowns[0].least is not None else None

    def search(seed: int, known: Known | None, enough: int | None) -> Fibre | None:
        looping = Looping(known_angles(problem), enough or bound, most_loops=loops)
        rng, progress = np.random.default_rng(seed), progress_of_searches() if seed == 0 else None
        begin = partial(fibre, system, points, rng, seed, rank, looping)
        found = begin(known, progress)
        if found is None and known is None:
            # no random point leads to a root: from closed configurations
            known = real_seeds(problem, system, points, np.random.default_rng([seed, 2]))
            found = None if known is None else begin(known, progress)
        return found

    def missing(start: Fibre, seed: int) -> np.ndarray:
        elsewhere = roots_elsewhere(problem, system, points, rank, start, seed)
        return np.hstack([missing_roots(problem, system, start, seed), elsewhere])

    if bound is not None and (only := search(0, None, None)) is not None:
        return only, ""
    found, why = agreeing_searches(system, search, missing, runs)
    return (None, SINGULAR) if found is not None and _has_singular_roots(problem) else (found, why)


def _has_singular_roots(problem: Problem) -> bool:
    """Whether two real instances have isolated roots that are singular: such roots, which may be
    complex at other values, are singular whatever the known values are. No loop leads to them, and
    a list of the others would lack them. One instance alone may be near values at which roots meet.
    """
    closed = closed_configurations(problem.closure, 0)[:_INSTANCES]
    instances = (problem.select_values(values, problem.known_coordinates) for values in closed)
    singular = (known for known in instances if _sampled(problem, known, 0)[1].any())
    return len([*islice(singular, 2)]) == min(2, len(closed))


def redundant_rows(problem: Problem) -> int:
    """Rows of a problem less their rank at generic closed configurations, all coordinates free."""
    system = problem.system.freed(problem.known_coordinates)
    ranks = []
    for values in closed_configurations(problem.closure, 0):
        _, jacobian = system.linearise_one(
            problem.select_values(values, system.unknowns), np.zeros(0)
        )
        ranks.append(Rank.of(jacobian).value)
    return system.rows.shape[0] - max(ranks)


def missing_roots(problem: Problem, system: AlgebraicSystem, start: Fibre, seed: int) -> np.ndarray:
    """Roots (width, n) at the start's base that real instances show to be missing there.

    At random closed configurations the roots must come in conjugate pairs, and must hold every real
    root that random starts find; what is missing is tracked back to the base.
    """
    settings = TrackSettings(tolerance=1e-5)
    closed = closed_configurations(problem.closure, seed)[:_INSTANCES]
    instances = [problem.select_values(values, problem.known_coordinates) for values in closed]
    ks = [known_values(problem, known).astype(complex) for known in instances]
    there = track_lines(system, [start.z] * len(ks), [(start.k, k) for k in ks], settings)
    lost = []
    for known, k, tracked in zip(instances, ks, there, strict=True):
        ends, _ = newton(system, tracked.z[:, tracked.arrived], k)
        wanted = np.concatenate([np.conj(ends), _real_points(problem, system, known, seed)], axis=1)
        lost.append(
            wanted[:, known_root(system, ends, wanted) < 0]
            if tracked.arrived.any()
            else wanted[:, :0]
        )
    back = track_lines(system, lost, [(k, start.k) for k in ks], settings)
    missing = [tracked.z[:, tracked.arrived] for tracked in back]
    if not any(z.shape[1] for z in missing):
        return np.zeros((system.width, 0), dtype=complex)
    everything = np.hstack([start.z, *missing])
    first = first_of_each(system, everything)
    return everything[:, first[first >= start.z.shape[1]]]


def _real_points(
    problem: Problem, system: AlgebraicSystem, known: np.ndarray, seed: int
) -> np.ndarray:
    """Regular real roots of an instance that random starts reach, as points of the algebraic
    system.
    """
    points, singular = _sampled(problem, known, seed)
    return algebraic_points(problem, system, problem.system, points[~singular])


def _sampled(problem: Problem, known: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Isolated real roots of an instance that random starts reach, and which are singular."""
    found = batched(problem, known, _CHECK_STARTS, np.random.default_rng(seed)).points
    return found, problem.system.conditions(found, known) >= _SINGULAR


def _closed_points(problem: Problem, system: AlgebraicSystem) -> Points:
    """Draws generic closed configurations: rows that close for any known values may still depend on
    them elsewhere.
    """
    closed = closed_configurations(problem.closure, 0)

    def draw(rng: np.random.Generator, near: bool) -> tuple[np.ndarray, np.ndarray]:  # noqa: ARG001 - all are near the reference
        values = closed[int(rng.integers(len(closed)))]
        point = values[None, problem.unknown_places]
        z = algebraic_points(problem, system, problem.system, point)[:, 0]
        return z, known_values(
            problem, problem.select_values(values, problem.known_coordinates)
        ).astype(complex)

    return draw


def _why_not_determined(problem: Problem, system: AlgebraicSystem) -> str | None:
    """Why the rows cannot be met for known values near given ones: they are more than the unknowns,
    and do not depend on each other where they are met. Of loops that are singular there, as at the
    straight leg of a file of few digits, closed configurations elsewhere tell.
    """
    if system.projective or system.count <= system.width:
        return None
    z, k = _closed_points(problem, system)(np.random.default_rng(11), True)
    (own,), (whole,) = _ranks(system, z[:, None], k[:, None])
    if own < whole:
        return TIED
    if own == system.width:
        return None
    z, k = real_roots(problem, system, np.random.default_rng(11))
    if not z.shape[1]:
        return None
    owns, wholes = _ranks(system, z, k)
    return TIED_ELSEWHERE if (owns < wholes).all() else None


def _ranks(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ranks (n,) of dF/dz, and of dF/d(z, k), at points z (width, n) and k (known, n)."""
    _, jz, jk = full_linearisation(system, z, k)
    both = np.concatenate([jz, jk], axis=2)
    own, whole = (np.array([Rank.of(j).value for j in part]) for part in (jz, both))
    return own, whole


def start_key(problem: Problem, system: AlgebraicSystem) -> str:
    """Hash of what generic roots depend on: a problem's rows, or the points of its distances."""
    distances = distance_function(problem) if is_universal(problem) else None
    return closure_key(system) if distances is None else hash_of(distances, "six distances")
