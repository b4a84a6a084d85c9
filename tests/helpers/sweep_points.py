"""Points of a sweep that are told as arguments of `symkin.modes`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from helpers.inside import read_given


def tables_of(finder: Any, inputs: Sequence[Mapping[str, Any]]) -> Any:
    """All modes that a finder finds at these points."""
    givens = [read_given(finder.problem.mechanism, **one) for one in inputs]
    values = np.array([given.values for given in givens])
    return finder.find_values(values, np.array([given.off_motion for given in givens]))
