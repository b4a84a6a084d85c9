"""The engine that tracks paths of a system: compiled C where a compiler is found and it pays, else NumPy.

All have the same meaning (see `tracker`) and agree on the roots. SYMKIN_ENGINE = numpy keeps to NumPy.
"""

from __future__ import annotations

import numpy as np

from symkin.enumeration import tracker
from symkin.enumeration.algebraic import AlgebraicSystem
from symkin.enumeration.compiled import CompiledTracker, load
from symkin.enumeration.tracker import Tracked, TrackSettings

_WORTH_COMPILING = 400
"""Instructions of one evaluation below which NumPy answers sooner than a compiler builds."""


def track(
    system: AlgebraicSystem, z: np.ndarray, begin: np.ndarray, end: np.ndarray, settings: TrackSettings | None = None
) -> Tracked:
    """Roots z (width, n) of F(., begin) to roots of F(., end); known values (known,) or (known, n)."""
    compiled, _ = engine_of(system)
    return compiled.track(z, begin, end, settings) if compiled else tracker.track(system, z, begin, end, settings)


def newton(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, iterations: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Newton at fixed k, (known,) or (known, n); points and the size of the last step."""
    compiled, _ = engine_of(system)
    return compiled.newton(z, k, iterations) if compiled else tracker.newton(system, z, k, iterations)


def engine_of(system: AlgebraicSystem) -> tuple[CompiledTracker | None, str]:
    """The compiled engine of a system, or None; and what is used, in a few words."""
    if system.cost < _WORTH_COMPILING:
        return None, "NumPy"
    compiled, text = load(system)
    return compiled, text if compiled else f"NumPy ({text})"
