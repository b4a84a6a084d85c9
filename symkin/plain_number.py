"""Numbers for people: rounding noise prints as 0."""

from __future__ import annotations

NOTHING = 1e-12
"""Values below this (lengths over the size) are rounding noise."""


def plain(value: float, size: float = 1.0, least: float = NOTHING) -> float:
    """The value, or 0 without a sign where it is below `least` times the size."""
    return value if abs(value) >= least * size else 0.0
