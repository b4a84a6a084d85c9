"""Real roots of one block of a problem at many instances, with what is in doubt left to others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from symkin.caching import cached_property
from symkin.errors import TooManyModesError
from symkin.homotopy.algebraic import AlgebraicSystem, imaginary_part
from symkin.homotopy.branches import real_candidates
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.six_distances import distance_data, is_universal
from symkin.homotopy.universal_joints import with_universal_angles
from symkin.homotopy.values import coordinate_scale, real_values
from symkin.numeric.system import System
from symkin.position.problem import Problem
from symkin.position.roots import SINGULAR_ROOT, features, merge
from symkin.position.solution import ACCEPTED
from symkin.sweeps.batch import BatchedSystem
from symkin.sweeps.many_paths import plain_roots

_REAL, _NOT_REAL = 1e-10, 1e-4
"""Imaginary parts of roots below the first and above the second leave no doubt; `symkin.modes` decides between."""
_ONE = 1e-6
"""Distance (of the size) within which polished roots are one."""


@dataclass(frozen=True, eq=False)
class BlockRoots:
    """A block with its algebraic system and the start of its paths."""

    problem: Problem
    block: System
    algebraic: AlgebraicSystem
    start: Fibre

    @cached_property
    def _batched(self) -> BatchedSystem:
        return BatchedSystem(self.block)

    @cached_property
    def _known_values(self) -> Callable[[np.ndarray], np.ndarray]:
        """`values.known_values`, prepared."""
        data = distance_data(self.problem) if is_universal(self.problem) else None
        scale = coordinate_scale(self.problem, self.problem.known_coordinates)
        return data if data is not None else lambda known: known / scale

    def roots(self, known: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
        """Distinct real roots (roots, width) of each instance known (n, values), and whether they are settled."""
        k = np.array([self._known_values(values) for values in known]).T
        ends, settled = plain_roots(self.algebraic, self.start, k)
        settled[settled] &= self._all_clear(ends[settled])
        points, owner = [np.zeros((0, self.block.width))], []
        for i in np.flatnonzero(settled):
            try:
                candidates = real_candidates(self.algebraic, ends[i])
            except TooManyModesError:
                settled[i] = False
                continue
            for z in candidates.T:
                root = real_values(self.problem, self.algebraic, z, k[:, i])
                named = with_universal_angles(self.problem, known[i], root)
                points += [np.concatenate([values[c.name] for c in self.block.unknowns])[None] for values in named]
                owner += [i] * len(named)
        return self._checked(np.concatenate(points), np.array(owner, dtype=int), known, settled)

    def _all_clear(self, ends: np.ndarray) -> np.ndarray:
        """Instances (n,) whose ends (n, width, roots) are real or not, beyond doubt, in the pose and in each limb."""
        n, width, roots = ends.shape
        z = ends.transpose(1, 0, 2).reshape(width, n * roots)
        clear = np.ones(n * roots, dtype=bool)
        for places in (self.algebraic.pose_places, *self.algebraic.limbs):
            part = imaginary_part(self.algebraic, z, places)
            clear &= (part < _REAL) | (part > _NOT_REAL)
        return np.asarray(clear.reshape(n, roots).all(axis=1))

    def _checked(
        self, z: np.ndarray, owner: np.ndarray, known: np.ndarray, settled: np.ndarray
    ) -> tuple[list[np.ndarray], np.ndarray]:
        """Candidates polished; those that close, each once. An instance with a root that is nearly singular is not
        settled."""
        size = self.block.size
        if len(z):
            z = self.block.fold(self._batched.polish(z, known[owner]))
            closed = self._batched.residual(z, known[owner]) <= ACCEPTED * size
            z, owner = z[closed], owner[closed]
        if len(z):
            condition = self._batched.condition(z, known[owner])
            settled[owner[~(condition < SINGULAR_ROOT)]] = False
        places = np.searchsorted(owner, np.arange(len(known) + 1))
        f = features(self.block, z) if len(z) else np.zeros((0, 1))
        found = []
        for begin, end in pairwise(places):
            first = merge(f[begin:end], _ONE * size)[0] if end - begin > 1 else slice(None)
            found.append(z[begin:end][first])
        return found, settled
