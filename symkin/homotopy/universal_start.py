"""Starts that serve every mechanism of a kind: read as data, or computed until a bound is reached.
That of every platform held by six distances.

With lengths and all points complex and random there are 40 roots, the most that any such platform
has (Ronga and Vust 1992). They are tracked to any machine; those of special machines that run to
e.e = 0 are at infinity.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem, complex_normal
from symkin.homotopy.endgame import finish
from symkin.homotopy.ends import Ends
from symkin.homotopy.engine import track
from symkin.homotopy.monodromy import Fibre, Looping, fibre
from symkin.homotopy.six_distances import universal_system
from symkin.homotopy.tracker import TrackSettings
from symkin.spatial.rotation import multiply

BOUND = 40
DATA = Path(__file__).resolve().parent / "data" / "six_distances.npz"
_FADING = 1e-4
"""|e.e| / |e|^2 below which a singular end of a generic instance is one at infinity."""


@lru_cache(maxsize=1)
def universal_start() -> Fibre:
    """40 roots of a random complex instance; carried as data, `compute_universal_start` makes
    them.
    """
    return read_start(DATA)


def compute_universal_start(seed: int = 0) -> Fibre:
    """Monodromy in lengths and geometry until the bound of 40 is reached."""

    def point(rng: np.random.Generator) -> np.ndarray:
        e = complex_normal(4, rng)
        t = np.concatenate([[0.0], complex_normal(3, rng)])
        return np.concatenate([e, 0.5 * multiply(t, e)])

    return compute_start(universal_system(), point, BOUND, seed)


def read_start(path: Path) -> Fibre:
    """A start that is carried as data: z (width, n), k of the system."""
    data = np.load(path)
    return Fibre(data["z"], data["k"], np.zeros(data["z"].shape[1], dtype=int), float("inf"), 0, 0)


def compute_start(
    system: AlgebraicSystem,
    point: Callable[[np.random.Generator], np.ndarray],
    bound: int,
    seed: int,
) -> Fibre:
    """All roots of a random complex instance, `bound` by theorem: monodromy from a random `point`
    on the system's unknowns. Raises RuntimeError where fewer are found.
    """

    def points(rng: np.random.Generator, near: bool) -> tuple[np.ndarray, np.ndarray]:  # noqa: ARG001 - no reference here
        return point(rng), complex_normal(system.k.shape[0], rng)

    found = fibre(
        system,
        points,
        np.random.default_rng(seed),
        seed,
        system.count,
        Looping(bound=bound, needed=1e9),
    )
    if found is None or found.z.shape[1] != bound:
        raise RuntimeError(
            f"{0 if found is None else found.z.shape[1]} of {bound} roots were found; try another "
            f"seed"
        )
    return found


def machine_start(data: np.ndarray) -> tuple[np.ndarray, int]:
    """Roots z (8, n) of a machine's complex instance `data` (42,), which holds L, b, m of each
    distance, and how many of the 40 paths are unresolved: others ran to e.e = 0.
    """
    ends = followed(universal_system(), universal_start(), data, smallest_step=1e-8)
    e = ends.singular.z[:4]
    fading = np.abs(np.sum(e**2, axis=0)) < _FADING * np.sum(np.abs(e) ** 2, axis=0)
    return ends.z, len(ends.unresolved) + int(ends.singular.multiplicity[~fading].sum())


def followed(
    system: AlgebraicSystem, start: Fibre, target: np.ndarray, *, smallest_step: float
) -> Ends:
    """What paths from a start that serves all machines come to at one of them."""
    settings = TrackSettings(tolerance=1e-5, smallest_step=smallest_step, most_steps=4000)
    tracked = track(system, start.z, start.k, target, settings)
    return finish(system, start, target, tracked)
