"""How modes are searched: the method with its random starts and solver, and which of these the
caller has named.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field

from symkin.errors import InputError
from symkin.numeric.levenberg import Progress
from symkin.position.least_squares import LeastSquares
from symkin.position.multistart import DEFAULT_STARTS
from symkin.position.newton import Newton
from symkin.position.problem import Problem
from symkin.text import not_among
from symkin.verb import read_as
from symkin.verb_options import check_seed, refuse_ignored

MOST_STARTS = 1_000_000
DEFAULT_SEED = 0
METHODS = ("continuation", "multistart")
_MULTISTART = "give method = 'multistart' (--method multistart), which searches from random starts"


@dataclass(frozen=True)
class Search:
    """`starts` and `seed` of random starts and the `solver` of multistart; `named` are those that
    the caller gave, None for the others, so that what a problem has no use for can be refused.
    `formulas`: whether continuation may leave inputs to closed forms where there are some.
    `progress` is told how far a search has come. It has `begun` (seconds of the counter) for as
    many inputs.
    """

    method: str
    starts: int
    seed: int
    solver: str | Newton | LeastSquares
    named: Mapping[str, object] = field(default_factory=dict)
    formulas: bool = True
    progress: Progress | None = None
    begun: float = field(default_factory=time.perf_counter)
    inputs: int = 1

    @property
    def elapsed_s(self) -> float:
        """Seconds since it has begun, of each input."""
        return (time.perf_counter() - self.begun) / self.inputs

    @property
    def name(self) -> str:
        """The method and, where it calls one, the solver."""
        return self.method if self.solver == "batched" else f"{self.method} {self.solver}"

    @staticmethod
    def of(
        method: str | None,
        starts: int | None = None,
        seed: int | None = None,
        solver: str | Newton | LeastSquares | None = None,
        progress: Progress | None = None,
    ) -> Search:
        """A checked search; a solver without a method means multistart. Raises InputError."""
        starts, seed = read_as("int | None", "starts", starts), read_as("int | None", "seed", seed)
        chosen = method or ("continuation" if solver is None else "multistart")
        if chosen not in METHODS:
            raise InputError(f"method = {not_among(chosen, METHODS)}")
        if starts is not None and not 1 <= starts <= MOST_STARTS:
            raise InputError(f"starts = {starts}; allowed: 1 to {MOST_STARTS}")
        check_seed(seed)
        if chosen == "continuation":
            refuse_ignored(
                {"solver": solver},
                "continuation tracks paths and calls no solver of single solutions",
                _MULTISTART,
            )
        return Search(
            chosen,
            DEFAULT_STARTS if starts is None else starts,
            DEFAULT_SEED if seed is None else seed,
            "batched" if solver is None else solver,
            {"starts": starts, "seed": seed, "solver": solver},
            formulas=method is None,
            progress=progress,
        )

    def refuse_starts(self, problem: Problem) -> None:
        """Refuse `starts` and `seed` after a continuation that had no use for random starts."""
        reason = (
            f"every part of the {problem.name} problem of {problem.mechanism.name} was solved by "
            f"formulas or by continuation, and nothing was sampled"
        )
        refuse_ignored(self.named, reason, _MULTISTART)

    def refuse_unless_multistart(self, reason: str) -> None:
        """Refuse `starts` and `seed` where nothing is searched, unless they belong to a multistart
        that the caller asked for, which is then answered without any start.
        """
        if self.method == "continuation":
            refuse_ignored(self.named, reason)
