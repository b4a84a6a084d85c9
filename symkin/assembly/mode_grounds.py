"""What is proved of modes that have no certificate because their rows are redundant, block by
block.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.assembly.block_proofs import block_prover
from symkin.homotopy.systems import system_of
from symkin.numeric.system import System
from symkin.position.problem import Problem
from symkin.position.solution import PartialProof
from symkin.position.solution_list import SolutionList


def with_grounds(
    problem: Problem, found: SolutionList, known: np.ndarray, owner: np.ndarray
) -> SolutionList:
    """The modes of inputs known (n, values), each of its input `owner` (m,), rising, with what is
    proved of those that are not certified: of each of a mode's blocks.
    """
    left = np.flatnonzero(found.certified == 0)
    if not left.size:
        return found
    parts = [
        _of_block(problem, block, known, found.values[left], owner[left])
        for block in problem.blocks
    ]
    ground = np.full(len(found), None, dtype=object)
    for place, number in enumerate(left.tolist()):
        ground[number] = PartialProof.joined([part[place] for part in parts])
    return replace(found, ground=ground, _made={})


def _of_block(
    problem: Problem, block: System, known: np.ndarray, values: np.ndarray, owner: np.ndarray
) -> Sequence[PartialProof | None]:
    """What is proved of a block's part of modes `values` (m, variables); modes that share it share
    that.
    """
    rows = np.column_stack([owner, values[:, problem.places(block.unknowns)]])
    own, which = np.unique(rows, axis=0, return_inverse=True)
    found = block_prover(problem, system_of(problem, block), block).grounds(
        own[:, 1:], own[:, 0].astype(int), known
    )
    return [found[k] for k in which.ravel().tolist()]
