"""What a worker does: the arrays of one chunk, from a job that comes as bytes and is prepared once in each process."""

from __future__ import annotations

import pickle
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.assembly.finder import ModeFinder
from symkin.caching import lru_cache
from symkin.errors import InputError
from symkin.sweeps.plan import Plan, difference

_one_at_a_time = threading.Lock()
"""Threads of one process share what is prepared, and compute in turn."""


@dataclass(frozen=True, eq=False)
class Job:
    """A plan, and what its folder has pinned."""

    plan: Plan
    pinned: Mapping[str, Any]

    def packed(self) -> bytes:
        return pickle.dumps(self)


def compute_chunk(job: bytes, index: int) -> dict[str, np.ndarray]:
    """The arrays of chunk `index` of a packed `Job`. Raises InputError in a process whose results would differ."""
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
