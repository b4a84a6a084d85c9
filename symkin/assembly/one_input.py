"""All modes for one input: parts found by continuation or multistart, combined, with what can be
said of them.
"""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import product
from math import prod

import numpy as np

from symkin.assembly.continuation import by_continuation, lacks_starts
from symkin.assembly.group_solvers import parted_group
from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.mode_proofs import ground_notes, theorem_notes
from symkin.assembly.modes_by_name import modes_by_name
from symkin.assembly.modes_result import Completeness, Modes, sampling
from symkin.assembly.prover import prover_of
from symkin.assembly.search import Search
from symkin.errors import InputError, TooManyModesError
from symkin.homotopy.systems import system_of, unsuitable
from symkin.numeric.levenberg import Progress
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.given import Given
from symkin.position.groups import structure_groups
from symkin.position.multistart import batched, one_by_one
from symkin.position.platform_motion import motion_notes
from symkin.position.problem import Problem
from symkin.position.roots import MOST_MODES, NOT_KNOWN, Roots, product_of_counts
from symkin.position.solution import PartialProof, Solution
from symkin.position.solution_list import checked_solutions, make_solution
from symkin.position.starts import start_values


def modes_of_input(
    problem: Problem, given: Given, search: Search, progress: Progress | None = None
) -> tuple[Modes, bool | None]:
    """The modes, and whether random starts were of use; None where nothing was searched."""
    begin = time.perf_counter()
    found, random_starts = _known_without_search(problem, given, search), None
    if found is None:
        found, random_starts = _searched(problem, given, search, progress)
    return replace(found, elapsed_s=time.perf_counter() - begin), random_starts


def _searched(
    problem: Problem, given: Given, search: Search, progress: Progress | None
) -> tuple[Modes, bool]:
    """The modes by paths or from random starts, and whether these were of use."""
    if search.method == "continuation" and _only_by_groups(problem, progress):
        (found,) = modes_by_name(problem, [given], search, progress=progress)
        return found, found.starts is not None
    rng = np.random.default_rng(search.seed)
    notes: tuple[str, ...] = ()
    random_starts = True
    if search.method == "continuation":
        blocks, notes, random_starts = by_continuation(problem, given, search.starts, rng, progress)
    elif search.solver == "batched":
        blocks = [
            batched(problem, block, given, search.starts, rng, progress) for block in problem.blocks
        ]
    else:
        blocks = [one_by_one(problem, given, search.starts, rng, search.solver, progress)]
    found = _result(problem, given, blocks, search.name, search.seed, notes)
    if search.method == "continuation" and found.completeness == "sampled":
        found = replace(found, notes=(*found.notes, *motion_notes(problem)))
    return found, random_starts


def _only_by_groups(problem: Problem, progress: Progress | None) -> bool:
    """Whether implied rows take the problem apart; or a block has no start system, and its parts,
    which are solved one after another, may have one each.
    """
    if parted_group(problem) is not None:
        return True
    return lacks_starts(problem, progress) and len(structure_groups(problem)) > len(problem.blocks)


def free_unknowns(problem: Problem) -> str | None:
    """What to say where the rows leave unknowns free, so that no solution is isolated."""
    free = problem.system.freedom - problem.generic_rank
    if free <= 0:
        return None
    return (
        f"{problem.mechanism.name}: the {problem.kind} problem leaves {free} of "
        f"{problem.system.freedom} unknowns free, so that "
        "its solutions are no isolated modes; use solve with a start for one of them"
    )


def _proved(problem: Problem, solution: Solution) -> Solution:
    """The pose that a formula gives, certified in balls as any other solution."""
    if unsuitable(problem) is not None:
        return solution
    values, owner = solution.variables[None], np.zeros(1, dtype=int)
    radii = list[float]()
    for block in problem.blocks:
        prover = prover_of(problem, system_of(problem, block), block)
        knowns = prover.knowns(values[:, problem.known_places])
        found = prover.proofs(None, values[:, problem.places(block.unknowns)], owner, knowns)
        if not found.certified[0]:
            return replace(solution, certified=False, radius=None)
        radii.append(float(found.radius[0]))
    return replace(solution, certified=True, radius=max(radii, default=0.0))


def _known_without_search(problem: Problem, given: Given, search: Search) -> Modes | None:
    """What needs no search: unknowns that nothing determines, a pose off the motion, the direct
    problem of a serial arm, given values that contradict rows without unknowns.
    """
    method, seed = search.method, search.seed
    free = free_unknowns(problem)
    if free is not None and problem.mechanism.serial:
        raise InputError(free)
    if free is not None:
        search.refuse_unless_multistart(free)
        empty = _result(problem, given, [], method, seed, (f"positive-dimensional set: {free}",))
        return replace(empty, positive_dimensional=True)
    if given.off_motion > 0.0:
        return replace(
            _result(problem, given, [], method, seed, ()), smallest_residual=given.off_motion
        )
    if problem.is_explicit:
        search.refuse_unless_multistart(
            "the direct problem of a serial arm is a function of its joints, and nothing is "
            "searched"
        )
        values = problem.join_values(start_values(problem, given, None), given.values)
        note = "forward kinematics of a serial arm is a function of its joints: one pose"
        solution = make_solution(problem, values)
        if not solution.residual <= CLOSURE_TOLERANCE * problem.closure.characteristic_length:
            return replace(
                _result(problem, given, [], method, seed, ()), smallest_residual=solution.residual
            )
        return Modes(
            problem=problem,
            given=given.echo,
            modes=(_proved(problem, solution),),
            completeness="proved",
            method="forward",
            seed=None,
            elapsed_s=0.0,
            complex_count=1,
            unresolved_paths=0,
            notes=(*given.notes, note),
        )
    conditions = problem.conditions
    off = conditions.residual(np.zeros(0), given.values) if conditions.errors.shape[0] else 0.0
    if off > CLOSURE_TOLERANCE * problem.closure.characteristic_length:
        return replace(_result(problem, given, [], method, seed, ()), smallest_residual=off)
    if not problem.blocks:
        search.refuse_unless_multistart(
            f"the {problem.kind} problem of {problem.mechanism.name} has no unknowns, and nothing "
            f"is searched"
        )
        solution = make_solution(
            problem, problem.join_values(np.zeros(0), given.values), notes=given.notes
        )
        return Modes(
            problem=problem,
            given=given.echo,
            modes=(solution,),
            completeness="proved",
            method=method,
            seed=seed,
            elapsed_s=0.0,
            complex_count=1,
            unresolved_paths=0,
            notes=given.notes,
        )
    return None


def _result(
    problem: Problem,
    given: Given,
    blocks: list[Roots],
    method: str,
    seed: int,
    notes: tuple[str, ...],
) -> Modes:
    found = (
        _combine(problem, given, blocks) if blocks and all(len(b.points) for b in blocks) else []
    )
    continuum = [b for b in blocks if b.continuum is not None]
    texts = [
        *given.notes,
        *notes,
        *(_continuum_note(problem, block) for block in continuum),
        *_proof_notes(blocks),
    ]
    if not continuum and any(b.complex_sets for b in blocks):
        texts.append(
            "paths ended on a set of complex solutions that are not isolated; no real one of it "
            "was met"
        )
    smallest = None
    if not found and not continuum:
        smallest = max((b.smallest_residual for b in blocks if not len(b.points)), default=None)
    texts += ground_notes(problem, [s.ground for s in found if s.ground is not None], len(found))
    texts += [
        b.missing if len(blocks) == 1 else f"{_names(b)}: {b.missing}"
        for b in blocks
        if b.missing is not None
    ]
    sampled = sampling([b for b in blocks if b.hits is not None])
    if sampled:
        sampled["estimated_unseen"] = _unseen(blocks)
    return Modes(
        problem=problem,
        given=given.echo,
        modes=tuple(found),
        completeness=_completeness(blocks),
        method=method,
        seed=seed,
        elapsed_s=0.0,
        **sampled,
        complex_count=product_of_counts(
            NOT_KNOWN if b.complex_count is None else b.complex_count for b in blocks
        )
        if blocks
        else None,
        unresolved_paths=sum(b.unresolved for b in blocks)
        if blocks and not all(b.sampled for b in blocks)
        else None,
        smallest_residual=smallest,
        positive_dimensional=bool(continuum),
        notes=tuple(texts),
        engine=", ".join(dict.fromkeys(b.engine for b in blocks if b.engine is not None)) or None,
    )


def _completeness(blocks: list[Roots]) -> Completeness:
    """The weakest statement among the parts."""
    if not blocks or any(b.sampled for b in blocks):
        return "sampled"
    if all(b.proofs is not None and b.proofs.reached for b in blocks):
        return "proved"
    return (
        "incomplete"
        if any(b.unresolved or b.complex_sets or b.continuum is not None for b in blocks)
        else "probability one"
    )


def _proof_notes(blocks: list[Roots]) -> list[str]:
    """Theorems that the certified roots reach, and why modes have no certificate."""
    proofs = [b.proofs for b in blocks if b.proofs is not None]
    reasons = dict.fromkeys(p.reason for p in proofs if p.reason is not None)
    return [
        *theorem_notes(p.reached for p in proofs),
        *(f"not certified: {r}" for r in reasons),
    ]


def _names(block: Roots) -> str:
    return ", ".join(c.name for c in block.system.unknowns)


def _unseen(blocks: list[Roots]) -> float:
    return prod(len(b.points) + b.unseen for b in blocks) - prod(len(b.points) for b in blocks)


def _continuum_note(problem: Problem, block: Roots) -> str:
    names = ", ".join(c.name for c in block.system.unknowns)
    return (
        f"positive-dimensional set: the {problem.kind} problem has solutions that are not isolated "
        f"(in {names}); "
        "the modes listed are the isolated ones only"
    )


def _combine(problem: Problem, given: Given, blocks: list[Roots]) -> list[Solution]:
    """The product of the blocks' roots, sorted by pose and joint values; a mode's hits are its
    rarest part's.
    """
    count = prod(len(b.points) for b in blocks)
    if count > MOST_MODES:
        raise TooManyModesError(
            f"{problem.mechanism.name}: the limbs' branches combine to {count} modes, more than "
            f"the {MOST_MODES} that are "
            "listed; solve for one of them near a start"
        )
    parts = np.array(list(product(*(range(len(b.points)) for b in blocks))), dtype=int).reshape(
        count, len(blocks)
    )
    values = np.empty((count, int(problem.closure.variables.shape[0])))
    values[:, problem.known_places] = given.values
    for roots, chosen in zip(blocks, parts.T, strict=True):
        values[:, problem.places(roots.system.unknowns)] = roots.points[chosen]
    found = checked_solutions(problem, values, given.notes)
    order = order_of_modes(
        problem, found.values, found.position, found.quaternion, np.zeros(count, dtype=int)
    )
    return [_with_parts(found[i], blocks, tuple(parts[i].tolist())) for i in order.tolist()]


def _with_parts(solution: Solution, blocks: list[Roots], parts: tuple[int, ...]) -> Solution:
    """A mode with what is known of its parts: it is certified if each of them is, and its radius is
    the largest of theirs.
    """
    hits = min(
        (
            int(roots.hits[k])
            for roots, k in zip(blocks, parts, strict=True)
            if roots.hits is not None
        ),
        default=None,
    )
    proofs = [roots.proofs for roots in blocks]
    if not all(proofs):
        return replace(solution, hits=hits)
    certified = all(p.certified[k] for p, k in zip(proofs, parts, strict=True) if p is not None)
    radius = (
        max(float(p.radius[k]) for p, k in zip(proofs, parts, strict=True) if p is not None)
        if certified
        else None
    )
    ground = None if certified else _ground(blocks, parts)
    return replace(solution, hits=hits, certified=certified, radius=radius, ground=ground)


def _ground(blocks: list[Roots], parts: tuple[int, ...]) -> PartialProof | None:
    """What is proved of a mode that is not certified, if something is proved of each of its
    parts.
    """
    return PartialProof.joined(
        [
            None if r.proofs is None else r.proofs.of(k, r.system)
            for r, k in zip(blocks, parts, strict=True)
        ]
    )
