"""What the studies of enumeration share: the words that say what a list of modes is worth."""

from __future__ import annotations

import numpy as np

from symkin import Modes


def statement(found: Modes) -> str:
    """Completeness as the result itself states it: `proved: 40 complex solutions, 40 real, 40 certified, 0 paths unresolved`."""
    complex_count = "unknown number of" if found.complex_count is None else str(found.complex_count)
    unresolved = "no paths" if found.unresolved_paths is None else f"{found.unresolved_paths} paths unresolved"
    return (
        f"{found.completeness}: {complex_count} complex solutions, {len(found)} real, {certified(found)} certified, {unresolved}"
    )


def certified(found: Modes) -> int:
    """How many modes carry a certificate."""
    return sum(mode.certified is True for mode in found)


def largest_radius(found: Modes) -> float | None:
    """The largest radius within which a certificate places its mode, length unit; None without certificates."""
    return max((mode.radius for mode in found if mode.radius is not None), default=None)


def largest_residual(found: Modes) -> float | None:
    return max((mode.residual for mode in found), default=None)


def distances(found: Modes, size: float) -> np.ndarray:
    """Largest difference (n, n) of two modes' positions and, times `size`, rotation matrices; infinite on the diagonal."""
    rows = np.array([[*mode.position, *(size * mode.rotation.ravel())] for mode in found]).reshape(len(found), 12)
    apart = np.max(np.abs(rows[:, None] - rows[None]), axis=2, initial=0.0)
    np.fill_diagonal(apart, np.inf)
    return apart
