"""Compute the start roots of the shipped mechanisms into the package: `python
tests/campaigns/shipped_starts.py`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from helpers.inside import (
    SHIPPED,
    AlgebraicSystem,
    BlockPaths,
    Problem,
    build_problem,
    compute_start,
    content_of,
    solved_parts,
    solvers_of,
    start_key,
    structure_groups,
    system_of,
)
from symkin import load, shipped_names


def write_shipped() -> None:
    """Write the starts of the limbs' direct and inverse problems anew."""
    for old in SHIPPED.glob("*.npz"):
        old.unlink()
    for problem, system in shipped_systems():
        start, reason = compute_start(problem, system)
        (SHIPPED / f"{start_key(problem, system)}.npz").write_bytes(content_of(start, reason))
        names = ", ".join(c.name for c in problem.system.unknowns)
        told = reason if start is None else f"{start.z.shape[1]} roots"
        print(problem.mechanism.name, problem.name, names, told)


def shipped_systems() -> Iterator[tuple[Problem, AlgebraicSystem]]:
    """The systems whose starts the package carries: of the blocks of shipped mechanisms of limbs,
    and of the parts that implied rows take them apart into.
    """
    for mechanism in (load(name) for name in shipped_names()):
        for kind in () if mechanism.is_graph else ("direct", "inverse"):
            problem = build_problem(mechanism, kind)
            if problem.is_explicit:
                continue
            blocks = structure_groups(problem)
            yield from ((block, system_of(block)) for block in blocks)
            for part in solved_parts(blocks[0]) if len(blocks) == 1 else ():
                for solver in solvers_of(part):
                    if isinstance(solver, BlockPaths) and solver.shared is None:
                        yield part, solver.algebraic


if __name__ == "__main__":
    write_shipped()
