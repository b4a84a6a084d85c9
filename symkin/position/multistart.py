"""Assembly and working modes from varied initial guesses.

All starts of a block run at once through one mapped function; roots are merged modulo whole turns and quaternion sign
and counted. Nothing here knows when all modes are found: the result says "sampled", with an estimate from the counts
of how many modes are still unseen (Chao 1984) and how likely the next start finds one (Good 1953).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import prod

import numpy as np

from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.given import Given, given_from, pose_from
from symkin.position.least_squares import LeastSquares
from symkin.position.levenberg import Progress, levenberg_marquardt
from symkin.position.newton import Newton
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import Modes, Solution, make_solution
from symkin.position.solve import ACCEPTED, SOLVERS
from symkin.position.starts import random_starts, start_values
from symkin.position.system import System
from symkin.spatial.pose import Pose

DEFAULT_STARTS = 2000
_SINGULAR = 1e8
"""Condition above which a root is examined for being one of a continuum."""
_MOST_MODES = 20_000
_CONTINUUM_SAMPLE = 5


@dataclass(frozen=True, eq=False)
class Roots:
    """Distinct roots of one block: points (n, width), hits (n,), starts, and the least error reached by any start."""

    system: System
    points: np.ndarray
    hits: np.ndarray
    starts: int
    smallest_residual: float
    continuum: np.ndarray | None = None

    @property
    def unseen(self) -> float:
        """Chao's lower bound f1^2 / (2 f2) of the roots not yet hit, with f2 at least 1."""
        once, twice = int(np.sum(self.hits == 1)), int(np.sum(self.hits == 2))
        return once * once / (2 * max(twice, 1))

    @property
    def next_new(self) -> float:
        """Good-Turing: the share of hits that are single, the probability that the next hit is a new root."""
        total = int(np.sum(self.hits))
        return float(np.sum(self.hits == 1)) / total if total else 1.0


def modes(
    mechanism: Mechanism,
    *,
    joints: Sequence[float] | None = None,
    pose: Sequence[float] | Pose | None = None,
    starts: int = DEFAULT_STARTS,
    seed: int = 0,
    solver: str | Newton | LeastSquares = "batched",
    progress: Progress | None = None,
) -> Modes:
    """Every solution that `starts` random starts find, of the direct (`joints`) or inverse (`pose`) problem.

    Values are in the mechanism's units, as for `solve`. `solver` is "batched" (Levenberg-Marquardt on all rows, all
    starts at once) or a solver of `solve`, called once a start. Raises InputError for values that do not fit.
    """
    if starts < 1:
        raise InputError(f"starts = {starts} must be at least 1")
    if seed < 0:
        raise InputError(f"seed = {seed} must not be negative")
    begin = time.perf_counter()
    given = given_from(mechanism, joints, pose)
    problem = build_problem(mechanism, given.kind)
    _refuse_redundant(problem)
    if given.off_motion > 0.0:
        return _result(problem, given, [], begin, seed, smallest=given.off_motion)
    if problem.is_explicit:
        values = problem.assemble(start_values(problem, given, None), given.values)
        found = Modes(problem, given.echo, (make_solution(problem, values),), "proved", "forward", None, 0.0)
        note = "forward kinematics of a serial arm is a function of its joints: one pose"
        return replace(found, elapsed_s=time.perf_counter() - begin, notes=(*given.notes, note))
    conditions = problem.conditions
    off = conditions.residual(np.zeros(0), given.values) if conditions.errors.shape[0] else 0.0
    if off > ACCEPTED * mechanism.size:
        return _result(problem, given, [], begin, seed, smallest=off)
    rng = np.random.default_rng(seed)
    if solver == "batched":
        blocks = [_batched(problem, block, given, starts, rng, progress) for block in problem.blocks]
    else:
        blocks = [_one_by_one(problem, given, starts, rng, solver, progress)]
    return _result(problem, given, blocks, begin, seed, method="multistart" if solver == "batched" else f"multistart {solver}")


def _refuse_redundant(problem: Problem) -> None:
    free = problem.system.freedom - problem.generic_rank
    if free > 0:
        raise InputError(
            f"{problem.mechanism.name}: the {problem.kind} problem leaves {free} of {problem.system.freedom} unknowns free, "
            "so that its solutions are no isolated modes; use solve with a start for one of them"
        )


def _batched(
    problem: Problem, block: System, given: Given, starts: int, rng: np.random.Generator, progress: Progress | None
) -> Roots:
    points = random_starts(problem, block, given, starts, rng)
    batch = levenberg_marquardt(block, points, given.values, progress=progress)
    ends = batch.points[batch.converged]
    if not len(ends):
        return _no_roots(block, batch.points, batch.largest_row, given, starts)
    return distinct(block, ends, given.values, starts)


def _no_roots(block: System, points: np.ndarray, largest: np.ndarray, given: Given, starts: int) -> Roots:
    """Refine the best ends, so that the smallest residual is that of a minimum."""
    order = np.argsort(np.where(np.isfinite(largest), largest, np.inf))[:16]
    batch = levenberg_marquardt(block, points[order], given.values, max_iterations=300, patience=60)
    residuals = [block.residual(z, given.values) for z in batch.points]
    return Roots(block, np.zeros((0, block.width)), np.zeros(0, dtype=int), starts, float(np.nanmin(residuals)))


def _one_by_one(
    problem: Problem, given: Given, starts: int, rng: np.random.Generator,
    solver: str | Newton | LeastSquares, progress: Progress | None,
) -> Roots:  # fmt: skip
    chosen = SOLVERS.get(solver) if isinstance(solver, str) else solver
    if chosen is None:
        raise InputError(f"solver = {solver!r} is unknown; allowed: batched, {', '.join(SOLVERS)}")
    system = problem.system
    ends, smallest = [], np.inf
    for k, start in enumerate(random_starts(problem, system, given, starts, rng), start=1):
        path = chosen.iterate(problem, start, given.values)
        z = system.unit(path[-1]) if np.all(np.isfinite(path[-1])) else path[-1]
        left = system.residual(z, given.values) if np.all(np.isfinite(z)) else np.inf
        smallest = min(smallest, left)
        if left <= 1e-6 * system.size:
            ends.append(z)
        if progress is not None:
            progress(k, starts)
    if not ends:
        return Roots(system, np.zeros((0, system.width)), np.zeros(0, dtype=int), starts, smallest)
    return distinct(system, np.array(ends), given.values, starts)


# --- merging -----------------------------------------------------------------------------------------------------


def features(system: System, points: np.ndarray) -> np.ndarray:
    """Coordinates in which equal configurations are equal: lengths, size (cos, sin) of angles, size times the
    products q_i q_j of quaternions."""
    columns = []
    for c, place in zip(system.unknowns, system.slices, strict=True):
        part = points[:, place]
        if c.kind == "quaternion":
            outer = part[:, :, None] * part[:, None, :]
            columns.append(system.size * outer.reshape(len(part), 16))
        elif c.kind == "angle":
            columns += [system.size * np.cos(part), system.size * np.sin(part)]
        else:
            columns.append(system.size * part if c.kind == "turns" else part)
    return np.hstack(columns)


def merge(points: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Representatives and the label of each row of `points` (features); rows within `tolerance` are one. At most
    `_MOST_MODES` are told apart; rows beyond have the label -1."""
    labels = np.full(len(points), -1)
    chosen: list[int] = []
    left = np.arange(len(points))
    while left.size and len(chosen) < _MOST_MODES:
        same = np.max(np.abs(points[left] - points[left[0]]), axis=1) <= tolerance
        labels[left[same]] = len(chosen)
        chosen.append(int(left[0]))
        left = left[~same]
    return np.array(chosen, dtype=int), labels


def distinct(system: System, ends: np.ndarray, known: np.ndarray, starts: int) -> Roots:
    """Merge ends, polish the representatives to full precision, drop what fails the check, merge again. Roots of a
    continuum are set apart; once they outnumber the isolated ones, a few of them stand for the rest."""
    ends = system.fold(ends)
    first, labels = merge(features(system, ends), 1e-5 * system.size)
    hits = np.bincount(labels[labels >= 0], minlength=len(first))
    order = np.argsort(-hits, kind="stable")
    roots: list[np.ndarray] = []
    counts, continuum, smallest = [], [], np.inf
    for index, count in zip(first[order], hits[order], strict=True):
        z = system.polish(ends[index], known, steps=8)
        left = system.residual(z, known)
        smallest = min(smallest, left)
        if left > ACCEPTED * system.size:
            continue
        if system.condition(z, known) > _SINGULAR and moves_freely(system, z, known):
            continuum.append(z)
            if len(continuum) >= _CONTINUUM_SAMPLE and len(continuum) > len(roots):
                break
        else:
            roots.append(z)
            counts.append(count)
    points = np.array(roots).reshape(len(roots), system.width)
    first, labels = merge(features(system, points), 1e-6 * system.size) if roots else (np.zeros(0, int), np.zeros(0, int))
    totals = np.bincount(labels, weights=counts, minlength=len(first)).astype(int)
    return Roots(system, points[first], totals, starts, smallest, np.array(continuum) if continuum else None)


def moves_freely(system: System, z: np.ndarray, known: np.ndarray) -> bool:
    """Whether the root z lies on a continuum: a step of 1e-3 of the size along the free direction of the Jacobian
    closes again nearby without coming back (from an isolated double root it comes back)."""
    _, jacobian = system.linearise_one(z, known)
    free = np.linalg.svd(jacobian)[2][-1]
    length = 1e-3 * system.size
    begin = system.move(z[None], length * free[None])[0]
    end = system.polish(begin, known, steps=30)
    if system.residual(end, known) > 1e-10 * system.size:
        return False
    moved = np.max(np.abs(features(system, end[None]) - features(system, z[None])))
    return bool(moved > 0.1 * np.max(np.abs(features(system, begin[None]) - features(system, z[None]))))


# --- the whole result --------------------------------------------------------------------------------------------


def _result(
    problem: Problem, given: Given, blocks: list[Roots], begin: float, seed: int,
    *, smallest: float | None = None, method: str = "multistart",
) -> Modes:  # fmt: skip
    found = _combine(problem, given, blocks) if blocks and all(len(b.points) for b in blocks) else []
    notes = list(given.notes)
    continuum = [b for b in blocks if b.continuum is not None]
    notes += [_continuum_note(problem, block) for block in continuum]
    if smallest is None and not found and not continuum:
        smallest = max((b.smallest_residual for b in blocks if not len(b.points)), default=None)
    seen = prod(len(b.points) for b in blocks)
    return Modes(
        problem, given.echo, tuple(found), "sampled", method, seed, time.perf_counter() - begin,
        starts=max((b.starts for b in blocks), default=0),
        estimated_unseen=prod(len(b.points) + b.unseen for b in blocks) - seen if blocks else None,
        next_new=max((b.next_new for b in blocks), default=None),
        smallest_residual=smallest, positive_dimensional=bool(continuum), notes=tuple(notes),
    )  # fmt: skip


def _continuum_note(problem: Problem, block: Roots) -> str:
    names = ", ".join(c.name for c in block.system.unknowns)
    return (
        f"positive-dimensional set: the {problem.kind} problem has solutions that are not isolated (in {names}); "
        "the modes listed are the isolated ones only"
    )


def _combine(problem: Problem, given: Given, blocks: list[Roots]) -> list[Solution]:
    """The product of the blocks' roots, sorted by pose and joint values; a mode's hits are its rarest part's."""
    count = prod(len(b.points) for b in blocks)
    if count > _MOST_MODES:
        raise InputError(
            f"{problem.mechanism.name}: the limbs' branches combine to {count} modes, more than the {_MOST_MODES} that are "
            "listed; solve for one of them near a start"
        )
    found = []
    for parts in product(*(range(len(b.points)) for b in blocks)):
        values = np.empty(int(problem.closure.variables.shape[0]))
        for roots, k in zip(blocks, parts, strict=True):
            for c, place in zip(roots.system.unknowns, roots.system.slices, strict=True):
                values[problem.closure.slices[c.name]] = roots.points[k][place]
        start = 0
        for c in problem.known_coordinates:
            values[problem.closure.slices[c.name]] = given.values[start : start + c.width]
            start += c.width
        hits = min(int(roots.hits[k]) for roots, k in zip(blocks, parts, strict=True))
        found.append(make_solution(problem, values, hits=hits, notes=given.notes))
    return sorted(found, key=lambda s: _sort_key(problem, s))


def _sort_key(problem: Problem, solution: Solution) -> tuple[float, ...]:
    """Nearest to the example's start or the reference pose first; ties by joint values, all rounded."""
    mechanism, size = problem.mechanism, problem.closure.size
    reference = mechanism.reference_pose
    if problem.kind == "direct" and mechanism.example is not None and mechanism.example.start is not None:
        reference = pose_from(mechanism.example.start) if mechanism.example.joints is not None else reference
    turn = float(np.sum((solution.rotation - reference.rotation) ** 2))
    away = float(np.linalg.norm(solution.position - np.asarray(reference.position))) / size
    flat = np.concatenate([np.atleast_1d(np.asarray(v, dtype=float)) for v in solution.values.values()])
    return (round(turn + away**2, 6), *np.round(flat, 6))
