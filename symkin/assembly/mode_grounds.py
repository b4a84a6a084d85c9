"""What is proved of modes that have no certificate because their rows are redundant, block by block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.assembly.proofs import Prover
from symkin.homotopy.systems import whole_system
from symkin.numeric.system import System
from symkin.position.given import Given
from symkin.position.problem import Problem
from symkin.position.solution import PartialProof
from symkin.position.solution_list import SolutionList


def with_grounds(problem: Problem, blocks: Sequence[System], given: Given, found: SolutionList) -> SolutionList:
    """The modes of one input with what is proved of those that are not certified: of each of a mode's blocks."""
    left = np.flatnonzero(found.certified == 0)
    if not left.size:
        return found
    parts = [_of_block(problem, block, given, found.values[left]) for block in blocks]
    ground = np.full(len(found), None, dtype=object)
    for place, number in enumerate(left.tolist()):
        ground[number] = PartialProof.joined([part[place] for part in parts])
    return replace(found, ground=ground, _made={})


def _of_block(problem: Problem, block: System, given: Given, values: np.ndarray) -> list[PartialProof | None]:
    """What is proved of a block's part of modes `values` (m, variables); a certificate is a proof of all its rows."""
    points, which = np.unique(values[:, problem.places(block.unknowns)], axis=0, return_inverse=True)
    found = Prover(problem, block, given, whole_system(problem, block), None, None).proofs(points)
    return [found.of(k, block) for k in which.ravel().tolist()]
