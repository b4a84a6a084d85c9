"""Modes at many points of one mechanism: paths of all points together where nothing is in doubt, `symkin.modes` elsewhere.

A point goes to `symkin.modes` where a path does not arrive at a regular root of its own, where a root is nearly real or
nearly singular, and wherever the problem has no start for paths or certificates are asked for. What is plain gets the same
checks: every root polished and verified on all rows, distinct, in the same order.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Any

import numpy as np

from symkin.assembly.continuation import unsuitable
from symkin.assembly.modes import modes_at_need
from symkin.caching import cached_property
from symkin.errors import InputError, TooManyModesError
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.branches import complex_count
from symkin.homotopy.engine import engine_of
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.start_store import start_of
from symkin.homotopy.systems import system_of
from symkin.homotopy.universal_joints import replaced_universal_joints
from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import Progress
from symkin.numeric.system import System
from symkin.position.given import Given, given_from
from symkin.position.problem import Kind, Problem, build_problem
from symkin.position.roots import MOST_MODES
from symkin.position.solution import ACCEPTED
from symkin.sweeps.block_roots import BlockRoots
from symkin.sweeps.finish import Finisher
from symkin.sweeps.found import Found, from_modes, joined, nothing


@dataclass(frozen=True, eq=False)
class Enumerator:
    """What is prepared once for all points of one problem of a mechanism; `starts` and `seed` are those of
    `symkin.modes`."""

    problem: Problem
    starts: int
    seed: int
    certify: bool
    parts: tuple[tuple[System, AlgebraicSystem, Fibre], ...]

    @property
    def engine(self) -> str:
        """What tracks the paths."""
        return ", ".join(dict.fromkeys(engine_of(system)[1] for _, system, _ in self.parts)) or "none"

    @property
    def starts_digest(self) -> str:
        """Hash of the roots from which paths begin."""
        digest = hashlib.sha256()
        for _, _, start in self.parts:
            digest.update(start.z.tobytes() + start.k.tobytes())
        return digest.hexdigest()

    @property
    def bound(self) -> int | None:
        """Most isolated modes that a point can have, where paths tell."""
        if self.problem.is_explicit:
            return 1
        if not self.parts:
            return None
        angles = 1 << len(replaced_universal_joints(self.problem))
        return prod([angles * complex_count(system, start.z) for _, system, start in self.parts], start=1)

    @cached_property
    def _blocks(self) -> tuple[BlockRoots, ...]:
        return tuple(BlockRoots(self.problem, *part) for part in self.parts)

    @cached_property
    def _finisher(self) -> Finisher:
        return Finisher(self.problem)

    def enumerate(self, inputs: Sequence[Mapping[str, Any]]) -> Found:
        """All modes at points given as arguments of `symkin.modes`."""
        with np.errstate(all="ignore"):
            return self._enumerate(inputs)

    def _enumerate(self, inputs: Sequence[Mapping[str, Any]]) -> Found:
        givens = [given_from(self.problem.mechanism, g.get("joints"), g.get("pose")) for g in inputs]
        plain = np.array([self._may_be_plain(given) for given in givens], dtype=bool)
        places = np.flatnonzero(plain)
        known = np.array([givens[i].values for i in places]).reshape(len(places), len(givens[0].values))
        roots: list[list[np.ndarray]] = []
        good = np.ones(len(places), dtype=bool)
        for block in self._blocks if places.size else ():
            found, settled = block.roots(known)
            good &= settled
            roots.append(found)
        good &= np.array([prod(len(r[i]) for r in roots) <= MOST_MODES for i in range(len(places))], dtype=bool)
        kept = np.flatnonzero(good)
        values, owner = self._combined(known, roots, kept)
        settled_points = self._finisher.finish(values, owner, len(kept))
        others = sorted(set(range(len(inputs))) - set(places[kept].tolist()))
        return joined(settled_points, places[kept], {i: self._by_modes(inputs[i], givens[i]) for i in others})

    def _may_be_plain(self, given: Given) -> bool:
        """Whether a point's paths are to be tracked; given values that contradict rows without unknowns have no modes."""
        if self.certify or not self.parts or given.off_motion > 0.0:
            return False
        conditions = self.problem.conditions
        left = conditions.residual(np.zeros(0), given.values) if conditions.errors.shape[0] else 0.0
        return left <= ACCEPTED * self.problem.closure.size

    def _combined(self, known: np.ndarray, roots: list[list[np.ndarray]], kept: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Full vectors of variables (m, variables) of all modes, the product of the blocks' roots, and their points."""
        width = int(self.problem.closure.variables.shape[0])
        slices, coordinates = self.problem.closure.slices, self.problem.known_coordinates
        rows, owner = [np.zeros((0, width))], [np.zeros(0, dtype=int)]
        for number, i in enumerate(kept):
            choices = list(product(*(range(len(found[i])) for found in roots)))
            values = np.empty((len(choices), width))
            for block, found, chosen in zip(
                self.parts, roots, np.array(choices, dtype=int).reshape(-1, len(roots)).T, strict=True
            ):
                for c, place in zip(block[0].unknowns, block[0].slices, strict=True):
                    values[:, slices[c.name]] = found[i][chosen][:, place]
            begin = 0
            for c in coordinates:
                values[:, slices[c.name]] = known[i, begin : begin + c.width]
                begin += c.width
            rows.append(values)
            owner.append(np.full(len(choices), number))
        return np.concatenate(rows), np.concatenate(owner)

    def _by_modes(self, arguments: Mapping[str, Any], given: Given) -> Found:
        if given.off_motion > 0.0:
            return nothing(self.problem.closure, "off the motion", 0)
        try:
            found = modes_at_need(self.problem.mechanism, **arguments, starts=self.starts, seed=self.seed)
        except TooManyModesError:
            return nothing(self.problem.closure, "too many to list", -1)
        return from_modes(found)


def make_enumerator(
    mechanism: Mechanism, kind: Kind, *, starts: int, seed: int, certify: bool, progress: Progress | None = None
) -> Enumerator:
    """The enumerator of one problem; a start that is not kept yet is computed. Raises InputError where the problem has no
    isolated solutions."""
    problem = build_problem(mechanism, kind)
    if mechanism.serial and problem.system.freedom > problem.generic_rank:
        raise InputError(
            f"{mechanism.name}: its {len(mechanism.actuated)} joints leave solutions of a pose free, so that none is isolated; "
            "sweep over its inputs"
        )
    return Enumerator(problem, starts, seed, certify, _parts(problem, progress))


def _parts(problem: Problem, progress: Progress | None) -> tuple[tuple[System, AlgebraicSystem, Fibre], ...]:
    """Blocks with their systems and starts; none where some block has no start, or nothing is to be tracked."""
    if problem.is_explicit or problem.system.freedom > problem.generic_rank or unsuitable(problem):
        return ()
    parts = []
    for block in problem.blocks:
        system = system_of(problem, block)
        start = None if system is None else start_of(problem, system, block, progress)[0]
        if system is None or start is None:
            return ()
        parts.append((block, system, start))
    return tuple(parts)
