"""All paths from a mechanism's generic roots to one set of given values."""

from __future__ import annotations

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.endgame import finish
from symkin.homotopy.ends import Ends
from symkin.homotopy.engine import aligned, track
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.tracker import Tracked


def instance(system: AlgebraicSystem, start: Fibre, target: np.ndarray) -> Ends:
    """Track all generic roots to known values `target`; what does not arrive at a regular root of
    its own is decided by the endgame.
    """
    target = aligned(system, start.k, target)
    return finish(system, start, target, _tracked(system, start, target))


def _tracked(system: AlgebraicSystem, start: Fibre, target: np.ndarray) -> Tracked:
    """All paths; of those that symmetries carry to each other, one is followed."""
    mirrors = start.mirrors
    if mirrors is None:
        return track(system, start.z, start.k, target)
    return mirrors.unfold_tracked(track(system, start.z[:, mirrors.first], start.k, target))
