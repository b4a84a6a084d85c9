"""Compute the start roots of the shipped mechanisms into the package: `python
tests/campaigns/shipped_starts.py`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from helpers.inside import (
    SHIPPED,
    Problem,
    Search,
    any_paths,
    build_problem,
    problem_plan,
    solved_parts,
)
from symkin import load, shipped_names


def write_shipped() -> None:
    """Write the starts of the limbs' direct and inverse problems anew."""
    for old in SHIPPED.glob("*.npz"):
        old.unlink()
    with TemporaryDirectory() as folder:
        os.environ["SYMKIN_CACHE"] = folder
        for problem in prepared_groups():
            print(problem.mechanism.name, ", ".join(c.name for c in problem.system.unknowns))
        for kept in Path(folder).glob("*.npz"):
            (SHIPPED / f"{kept.name.split('-')[0]}.npz").write_bytes(kept.read_bytes())


def prepared_groups() -> Iterator[Problem]:
    """The groups of shipped mechanisms of limbs whose starts the package carries, and the parts
    into which implied rows take them apart, once their paths are at hand.
    """
    for mechanism in (load(name) for name in shipped_names()):
        for kind in () if mechanism.is_graph else ("direct", "inverse"):
            problem = build_problem(mechanism, kind)
            groups = () if problem.is_explicit else problem_plan(problem, Search.of(None)).groups
            for group in groups:
                for part in (group, *solved_parts(group)):
                    any_paths(part)
                    yield part


if __name__ == "__main__":
    write_shipped()
