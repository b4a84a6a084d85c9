"""Modes of many inputs where paths leave nothing in doubt: all of them together, with all checks.

What is in doubt at any input is left to the search for that input alone (see `modes`).
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from math import prod

import numpy as np

from symkin.assembly.block_paths import BlockPaths
from symkin.assembly.checked_roots import BlockRoots
from symkin.assembly.closed_roots import ClosedBlock, accounts_for_all, closed_block
from symkin.assembly.group_solvers import parted_group
from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.mode_proofs import theorem_notes
from symkin.assembly.mode_table import (
    COMPLETENESS,
    ModeTable,
    concatenated,
    stored_counts,
    table_of,
)
from symkin.assembly.parted_block import PartedBlock
from symkin.computed_once import cached_property, lru_cache
from symkin.homotopy.six_distances import redundant_distances
from symkin.homotopy.start_store import start_of
from symkin.homotopy.systems import system_of, unsuitable
from symkin.numeric.cache_folder import cache_folder
from symkin.numeric.levenberg import Progress
from symkin.numeric.linear_algebra import condition_of
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.canonical import canonical, poses_of
from symkin.position.groups import implied_parts
from symkin.position.problem import Problem
from symkin.position.readings import within_limits
from symkin.position.roots import MOST_MODES
from symkin.position.solution_list import SolutionList

_Solver = BlockPaths | ClosedBlock | PartedBlock
ROOTS_AT_ONCE = 40_000
"""Complex roots that are held at once."""


@dataclass(frozen=True, eq=False)
class Plain:
    """Modes of the inputs at the `places` (n,); `complete` (n, blocks): whether a theorem bounds a
    block's roots and as many are certified.
    """

    table: ModeTable
    places: np.ndarray
    complete: np.ndarray


@dataclass(frozen=True, eq=False)
class PlainModes:
    """What is prepared once for all inputs of one problem: its blocks with their formulas or paths,
    none where some block has neither.
    """

    problem: Problem
    parts: tuple[_Solver, ...]

    @property
    def method(self) -> str:
        """How the modes are found: by formulas where all blocks have some."""
        methods = {part.method for part in self.parts}
        return methods.pop() if len(methods) == 1 else "continuation"

    @property
    def engine(self) -> str | None:
        """What tracks the paths or has the formulas."""
        return ", ".join(dict.fromkeys(part.engine for part in self.parts)) or None

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What is said of every input."""
        return tuple(note for part in self.parts for note in part.notes)

    def theorems(self, complete: np.ndarray) -> tuple[str, ...]:
        """What is said of the bounds that an input's blocks (blocks,) reach."""
        reached = zip(self.parts, complete, strict=True)
        return theorem_notes(part.prover.theorem for part, whole in reached if whole)

    @property
    def is_tracked(self) -> bool:
        """Whether all blocks have paths."""
        return bool(self.parts)

    @property
    def starts_digest(self) -> str:
        """Hash of the roots from which paths begin."""
        digest = hashlib.sha256()
        for part in self.parts:
            digest.update(part.digest)
        return digest.hexdigest()

    @cached_property
    def most_modes(self) -> int:
        """Most isolated modes that an input can have."""
        return prod(part.most_roots for part in self.parts)

    def find(self, known: np.ndarray, *, certify: bool) -> Plain:
        """Modes at those of the inputs known (n, values) that are plain."""
        each = max(1, ROOTS_AT_ONCE // max(self.most_modes, 1))
        found = [
            self._found(known[i : i + each], certify) for i in range(0, max(len(known), 1), each)
        ]
        return Plain(
            concatenated([part.table for part in found]),
            np.concatenate([number * each + part.places for number, part in enumerate(found)]),
            np.concatenate([part.complete for part in found]),
        )

    def _found(self, known: np.ndarray, certify: bool) -> Plain:
        constant = self._errors_without_unknowns(known)
        places = np.flatnonzero(
            (constant <= CLOSURE_TOLERANCE * self.problem.closure.characteristic_length)
            & bool(self.parts)
        )
        known = known[places]
        blocks = [part.roots(known, certify=certify) for part in self.parts] if places.size else []
        good = np.ones(len(places), dtype=bool)
        for block in blocks:
            good &= block.plain
        counts = np.array([block.counts for block in blocks], dtype=float).reshape(
            len(blocks), len(places)
        )
        kept = np.flatnonzero(good & (np.prod(counts, axis=0) <= MOST_MODES))
        complete = [
            b.proofs.complete[kept] if b.proofs is not None else np.zeros(len(kept), dtype=bool)
            for b in blocks
        ]
        proved = np.array(complete, dtype=bool).reshape(len(blocks), len(kept)).T
        if not blocks:
            proved = np.zeros((len(kept), len(self.parts)), dtype=bool)
        return Plain(
            self._combined(known, constant[places], blocks, kept, proved), places[kept], proved
        )

    def _errors_without_unknowns(self, known: np.ndarray) -> np.ndarray:
        """By how much inputs contradict rows without unknowns (n,), length unit."""
        conditions = self.problem.conditions
        if not conditions.errors.shape[0]:
            return np.zeros(len(known))
        return conditions.residuals(np.zeros((len(known), 0)), known)

    def _combined(
        self,
        known: np.ndarray,
        constant: np.ndarray,
        blocks: list[BlockRoots],
        kept: np.ndarray,
        proved: np.ndarray,
    ) -> ModeTable:
        """All modes of the instances `kept`: the product of their blocks' roots. `constant` (n,)
        are the errors of rows without unknowns.
        """
        problem, width = self.problem, int(self.problem.closure.variables.shape[0])
        counts = [block.counts[kept] for block in blocks]
        total = (
            np.prod(np.array(counts, dtype=int).reshape(len(blocks), len(kept)), axis=0)
            if blocks
            else np.zeros(len(kept), dtype=int)
        )
        owner = np.repeat(np.arange(len(kept)), total)
        chosen = _choices(blocks, kept, total, owner)
        values = np.empty((len(owner), width))
        values[:, problem.known_places] = known[kept][owner]
        for part, block, which in zip(self.parts, blocks, chosen, strict=bool(blocks)):
            values[:, problem.places(part.block.unknowns)] = block.points[which]
        values = canonical(problem.closure.coordinates, problem.closure.slices, values)
        position, quaternion = poses_of(problem.closure, values)
        order = order_of_modes(problem, values, position, quaternion, owner)
        values, position, quaternion = values[order], position[order], quaternion[order]
        residual, condition = self._verified(
            values, blocks, [which[order] for which in chosen], constant[kept][owner]
        )
        inside = within_limits(problem.closure, values)
        certified, radius = _certified(blocks, chosen, order)
        listed = SolutionList(
            closure=problem.closure,
            values=values,
            position=position,
            quaternion=quaternion,
            residual=residual,
            condition=condition,
            within_limits=np.full(len(values), -1) if inside is None else inside.astype(int),
            certified=certified,
            radius=radius,
            notes=(),
        )
        return table_of(
            problem,
            listed,
            count=total,
            completeness=np.where(
                proved.all(axis=1),
                COMPLETENESS.index("proved"),
                COMPLETENESS.index("probability one"),
            ),
            unresolved=np.zeros(len(kept), dtype=int),
            continuum=np.zeros(len(kept), dtype=bool),
            complex_count=stored_counts(
                np.prod(
                    np.array([b.complex_count[kept] for b in blocks]).reshape(
                        len(blocks), len(kept)
                    ),
                    axis=0,
                )
            ),
        )

    def _verified(
        self,
        values: np.ndarray,
        blocks: list[BlockRoots],
        chosen: list[np.ndarray],
        constant: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Residuals and conditions (m,) of the whole system: the largest of the blocks' and of rows
        without unknowns; the blocks' Jacobians are the diagonal of the whole one.
        """
        problem, residual = self.problem, constant
        for block, which in zip(blocks, chosen, strict=True):
            residual = np.maximum(residual, block.residual[which])
        if blocks and all(part.block.rows.shape[0] >= part.block.freedom for part in self.parts):
            extremes = np.stack(
                [block.extremes[which] for block, which in zip(blocks, chosen, strict=True)]
            )
            return residual, condition_of(
                np.stack([extremes[:, :, 0].max(axis=0), extremes[:, :, 1].min(axis=0)], axis=1)
            )
        return residual, problem.system.conditions(
            values[:, problem.unknown_places], values[:, problem.known_places]
        )


def _choices(
    blocks: list[BlockRoots], kept: np.ndarray, total: np.ndarray, owner: np.ndarray
) -> list[np.ndarray]:
    """Of each block, the root (m,) of every mode: those of an instance run through all
    combinations, the last block fastest.
    """
    number = np.arange(len(owner)) - (np.cumsum(total) - total)[owner]
    chosen = []
    for block in reversed(blocks):
        counts, first = block.counts, np.cumsum(block.counts) - block.counts
        radix = np.maximum(counts[kept][owner], 1)
        chosen.append(first[kept][owner] + number % radix)
        number = number // radix
    return chosen[::-1]


def _certified(
    blocks: list[BlockRoots], chosen: list[np.ndarray], order: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Whether each mode is certified (1, 0; -1 where it was not tried) and its radius, the largest
    of its parts'.
    """
    proofs = [block.proofs for block in blocks if block.proofs is not None]
    if not proofs or len(proofs) < len(blocks):
        return np.full(len(order), -1), np.full(len(order), np.nan)
    certified, radius = np.ones(len(order), dtype=bool), np.zeros(len(order))
    for proof, which in zip(proofs, chosen, strict=True):
        certified &= proof.certified[which]
        radius = np.maximum(radius, proof.radius[which])
    return certified[order].astype(int), np.where(certified, radius, np.nan)[order]


def plain_modes(
    problem: Problem, progress: Progress | None = None, *, formulas: bool = True
) -> PlainModes:
    """The blocks of a problem with their formulas, if they are wanted and there are some, or with
    their paths; a start that is not kept yet is computed.
    """
    if problem.is_explicit or problem.system.freedom > problem.generic_rank:
        return PlainModes(problem, ())
    parts: list[_Solver] = []
    for number in range(len(problem.blocks)):
        solver = _solver(problem, number, progress, formulas=formulas)
        if solver is None:
            return PlainModes(problem, ())
        parts.append(solver)
    return _prepared(problem, tuple(parts))


def _solver(
    problem: Problem, number: int, progress: Progress | None, *, formulas: bool
) -> _Solver | None:
    """The formulas of one of a problem's blocks, if they are wanted and account for all solutions,
    else its parts, or its paths.
    """
    closed = closed_block(problem, number) if formulas else None
    if closed is not None and closed.is_of_arm:
        return closed
    group = parted_group(problem)
    if group is not None:
        return PartedBlock(group, group.blocks[0], implied_parts(group))
    paths = _paths(problem, number, progress, str(cache_folder()))
    return closed if closed is not None and accounts_for_all(closed, paths) else paths


@lru_cache(maxsize=256)
def _paths(
    problem: Problem, number: int, progress: Progress | None, _folder: str
) -> BlockPaths | None:
    """One of a problem's blocks with its paths, whose start is read from the cache folder once in a
    process; None where it has none.
    """
    if unsuitable(problem) or redundant_distances(problem):
        return None
    block = problem.blocks[number]
    system = system_of(problem, block)
    start, _ = start_of(problem, system, block, progress)
    return None if start is None else BlockPaths(problem, block, system, start)


@lru_cache(maxsize=128)
def _prepared(problem: Problem, parts: tuple[_Solver, ...]) -> PlainModes:
    return PlainModes(problem, parts)
