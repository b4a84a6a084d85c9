"""What finds the roots of one group at many instances: formulas, paths or parts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from symkin.position.problem import Problem


@dataclass(frozen=True, eq=False)
class BlockSolver:
    """A group; `method` is how users read what finds its roots."""

    problem: Problem
    method: ClassVar[str] = "continuation"

    @property
    def notes(self) -> tuple[str, ...]:
        """What is said of every input."""
        return ()
