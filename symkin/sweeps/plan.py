"""All that decides the arrays of a sweep, the comparison of two sweeps, and what a worker does with
a plan.
"""

from __future__ import annotations

import hashlib
import json
import pickle
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin._version import __version__
from symkin.assembly.modes_at_points import ModeFinder, make_finder
from symkin.assembly.search import MOST_STARTS
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import InputError
from symkin.locks import Lock
from symkin.model.mechanism import Mechanism
from symkin.position.problem import Problem
from symkin.sweeps.quantities import Variable, arrays_of, variables
from symkin.sweeps.space import Blocks, Space

FORMAT = 3
"""Number of this layout of a sweep's folder; folders of all are read."""
_LARGEST_CHUNK, _FEWEST_CHUNKS = 10_000, 16
"""A chunk has as many points as it may, unless a sweep would have less chunks than this."""
_MODES_IN_CHUNK = 40_000
"""Complex solutions of a chunk's points: a few seconds of work."""
_FORMULA_MODES = 200_000
"""Those of a chunk that formulas solve, in half a second, distances from singularities left aside:
writing its files takes a tenth of that, however few points they hold, so that small sweeps are one
chunk.
"""
_SLOW_CHUNK = 500
"""Points of a chunk where each is searched alone, or its modes are proved."""
_MOST_CHUNK = 100_000


@dataclass(frozen=True, eq=False)
class Plan:
    """What is swept, what is stored, and how: `starts` and `seed` are those of `symkin.modes`,
    `chunk` the points that one worker computes at a time.
    """

    space: Space
    quantity: str
    certify: bool
    starts: int
    chunk: int

    @property
    def mechanism(self) -> Mechanism:
        return self.space.mechanism

    @property
    def problem(self) -> Problem:
        return self.space.problem

    @cached_property
    def blocks(self) -> Blocks:
        return Blocks(self.space.shape, self.chunk)

    @property
    def variables(self) -> tuple[Variable, ...]:
        return variables(self.quantity, self.certify, self.problem)

    def finder(self) -> ModeFinder:
        return make_finder(
            self.problem, starts=self.starts, seed=self.space.seed, certify=self.certify
        )

    def compute(self, finder: ModeFinder, index: int) -> dict[str, np.ndarray]:
        """The arrays of one chunk."""
        return self._arrays(finder, self.space.points(self.blocks[index]))

    def _arrays(self, finder: ModeFinder, points: np.ndarray) -> dict[str, np.ndarray]:
        found = finder.find_values(*self.space.known_values(points))
        return arrays_of(found, self.quantity, self.certify, self.problem)

    def pinned(self, finder: ModeFinder) -> dict[str, Any]:
        """What another sweep must share for its arrays to be equal."""
        return {
            "symkin_sweep": FORMAT,
            "symkin_version": __version__,
            "mechanism": self.mechanism.name,
            "mechanism_sha256": self.mechanism.digest,
            "mechanism_file": self.mechanism.to_toml(),
            "problem": self.problem.name,
            **self.space.pinned(),
            "quantity": self.quantity,
            "certify": self.certify,
            "starts": self.starts,
            "seed": self.space.seed,
            "chunk": self.chunk,
            "engine": finder.engine,
            "starts_sha256": finder.starts_digest,
            "first_point_sha256": self._probe(finder),
        }

    def _probe(self, finder: ModeFinder) -> str:
        """Hash of the results at the first point: shows a machine that computes other last
        digits.
        """
        arrays = self._arrays(finder, self.space.points(self.blocks[0])[:1])
        return hashlib.sha256(
            b"".join(arrays[name].tobytes() for name in sorted(arrays))
        ).hexdigest()


def make_plan(
    space: Space,
    *,
    quantity: str = "modes",
    certify: bool = False,
    starts: int = 2000,
    chunk: int | None = None,
) -> Plan:
    """A checked plan. Raises InputError for options that do not fit."""
    if chunk is not None and not 1 <= chunk <= _MOST_CHUNK:
        raise InputError(f"chunk = {chunk}; allowed: 1 to {_MOST_CHUNK} points")
    if not 1 <= starts <= MOST_STARTS:
        raise InputError(f"starts = {starts}; allowed: 1 to {MOST_STARTS}")
    variables(quantity, certify, space.problem)
    if chunk is None:
        chunk = _usual_chunk(Plan(space, quantity, certify, starts, 1))
    return Plan(space, quantity, certify, starts, chunk)


def _usual_chunk(plan: Plan) -> int:
    """Points that are computed and written at a time where nobody says how many."""
    finder = plan.finder()
    bound = finder.bound if finder.own.is_tracked and not plan.certify else None
    if bound is not None and finder.engine == "closed form" and plan.quantity != "conditioning":
        return max(1, min(_FORMULA_MODES // max(bound, 1), plan.space.size))
    largest = (
        _SLOW_CHUNK
        if bound is None
        else min(_LARGEST_CHUNK, max(_SLOW_CHUNK, _MODES_IN_CHUNK // max(bound, 1)))
    )
    return max(1, min(largest, -(-plan.space.size // _FEWEST_CHUNKS)))


def difference(there: Mapping[str, Any], here: Mapping[str, Any]) -> str | None:
    """What differs between what two sweeps pinned, as a clause; None where nothing does."""
    if there.get("symkin_sweep") != here["symkin_sweep"]:
        return (
            f"another version of symkin, which lays folders out in another way "
            f"({there.get('symkin_sweep')}, here {here['symkin_sweep']}), began it; what it holds "
            f"can be read and drawn"
        )
    if (
        there.get("mechanism_sha256") != here["mechanism_sha256"]
        and there.get("mechanism") == here["mechanism"]
    ):
        return f"the file of {here['mechanism']} has changed"
    for key in here:
        if key.endswith("_sha256") or key == "mechanism_file":
            continue
        if json.dumps(there.get(key)) != json.dumps(here[key]):
            verb = "are" if key == "axes" else "is"
            return (
                f"{key.replace('_', ' ')} {verb} {_short(there.get(key))} there and "
                f"{_short(here[key])} here"
            )
    if there.get("starts_sha256") != here["starts_sha256"]:
        return (
            "the generic solutions from which paths begin are others (the cache folder has changed)"
        )
    if there.get("first_point_sha256") != here["first_point_sha256"]:
        return "this machine or its libraries compute other last digits than those that began it"
    return None


def _short(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{k} ({v})" for k, v in value.items())
    return str(value)


# --- workers --------------------------------------------------------------------------------------

_one_at_a_time = Lock()
"""Threads of one process share what is prepared, and compute in turn."""


@dataclass(frozen=True, eq=False)
class Job:
    """A plan, and what its folder has pinned."""

    plan: Plan
    pinned: Mapping[str, Any]

    def packed(self) -> bytes:
        return pickle.dumps(self)


def compute_chunk(job: bytes, index: int) -> dict[str, np.ndarray]:
    """The arrays of chunk `index` of a packed `Job`. Raises InputError in a process whose results
    would differ.
    """
    with _one_at_a_time:
        plan, finder = _prepared(job)
        return plan.compute(finder, index)


@lru_cache(maxsize=4)
def _prepared(job: bytes) -> tuple[Plan, ModeFinder]:
    loaded: Job = pickle.loads(job)
    finder = loaded.plan.finder()
    reason = difference(loaded.pinned, loaded.plan.pinned(finder))
    if reason is not None:
        raise InputError(f"a worker cannot go on with this sweep: {reason}")
    return loaded.plan, finder
