"""Which slices a sweep's map may be cut at."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from symkin.errors import InputError
from symkin.text import meant

_ROUNDING = 1e-9
"""Share of a bound by which a slice may pass it: the last digits of arithmetic."""


def check_slices(
    slices: Mapping[str, float], swept: Mapping[str, np.ndarray], *, sampled: bool
) -> None:
    """Raises InputError for slices that a sweep over these values does not have."""
    if slices and sampled:
        raise InputError(
            "slice: a random sample has no slices; it is drawn over the first two swept values"
        )
    for name, value in slices.items():
        if name not in swept:
            raise InputError(
                f"slice: {name!r} is not swept{meant(name, swept)}; allowed: {', '.join(swept)}"
            )
        low, high = float(np.min(swept[name])), float(np.max(swept[name]))
        slack = _ROUNDING * max(abs(low), abs(high))
        if not low - slack <= value <= high + slack:
            allowed = f"{low:.10g} to {high:.10g}" if high > low else f"{low:.10g}"
            raise InputError(
                f"slice: {name} = {value:.10g} lies outside what is swept; allowed: {allowed}"
            )


def check_map_is_left(slices: Mapping[str, float], swept: Iterable[str]) -> None:
    """Raises InputError for slices that leave nothing over which a map could be drawn."""
    if slices and set(swept) <= set(slices):
        all_of_it = f"{', '.join(slices)} {'is' if len(slices) == 1 else 'are'} all that is swept"
        raise InputError(f"slice: {all_of_it}; leave at least one out, over which the map is drawn")
